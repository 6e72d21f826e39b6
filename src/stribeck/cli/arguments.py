"""The argument list as it is typed, before it is parsed."""

from __future__ import annotations

from ..errors import InputError

#: Options that may be given more than once.
REPEATABLE = frozenset(
    {
        "--load",
        "--sensor",
        "--train",
        "--holdout",
        "--set",
        "--bounds",
        "--tie",
        "--setting",
        "--range",
        "--test",
        "--column",
    }
)
#: Options that take all that follows up to the next one.
GREEDY = frozenset({"--test"})


def checked(arguments: list[str]) -> list[str]:
    """The arguments, unless one is empty or an option that holds one value has two.

    An empty argument is a shell variable without a value; the last of two options would win
    silently.
    """
    options = [text.partition("=")[0] for text in arguments if text.startswith("--")]
    for text in arguments:
        if not text.strip() or (text.startswith("--") and text.endswith("=")):
            raise InputError(f"an argument is empty: {text or repr(text)} needs a value")
    for name in options:
        if name not in REPEATABLE and options.count(name) > 1:
            raise InputError(f"{name} is given twice: give it once")
    return arguments


def spread(arguments: list[str]) -> list[str]:
    """The arguments with `--test A B` written as `--test A --test B`, as shells expand names."""
    result: list[str] = []
    taking, fresh = "", False
    for text in arguments:
        if text.startswith("-"):
            taking, fresh = (text, True) if text in GREEDY else ("", False)
        elif taking and not fresh:
            result.append(taking)
        else:
            fresh = False
        result.append(text)
    return result
