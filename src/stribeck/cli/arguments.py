"""What people type: the arguments before they are parsed, and the values that they write in them."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from ..errors import InputError

if TYPE_CHECKING:
    from collections.abc import Sequence

#: Options that may be given more than once.
REPEATABLE = frozenset(
    {"--train", "--holdout", "--set", "--bounds", "--tie", "--setting", "--range", "--test"}
)
#: Options that take all that follows up to the next one.
GREEDY = frozenset({"--test"})
#: How the values of options are written that name what they are about.
FORMS = {
    "--set": "NAME=VALUE",
    "--setting": "NAME=VALUE",
    "--bounds": "NAME=LO:HI",
    "--tie": "NAME=OTHER",
}


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


def pairs(option: str, values: Sequence[str] | None) -> list[tuple[str, str]]:
    """The names and values of `NAME=VALUE`, each name once."""
    result = []
    for text in values or []:
        name, equals, value = text.partition("=")
        if not (name.strip() and equals and value.strip()):
            raise InputError(f"{option} {text!r}: write {FORMS[option]}")
        result.append((name.strip(), value.strip()))
    names = [n for n, _ in result]
    if twice := {n for n in names if names.count(n) > 1}:
        raise InputError(f"{option}: {', '.join(sorted(twice))} is given twice: give it once")
    return result


def numbers(option: str, values: Sequence[str] | None) -> dict[str, float]:
    """The same where all values are numbers."""
    return {name: number(text, f"{option} {name}") for name, text in pairs(option, values)}


def intervals(option: str, values: Sequence[str] | None) -> dict[str, tuple[float, float]]:
    """The same where they are `LO:HI`."""
    return {name: _interval(text, f"{option} {name}") for name, text in pairs(option, values)}


def each_once(option: str, values: Sequence[str] | None) -> None:
    """Refuse a value that is given twice."""
    bare = ["".join(text.split()) for text in values or []]
    if twice := {text for text in bare if bare.count(text) > 1}:
        raise InputError(f"{option} {min(twice)} is given twice: give it once")


def above_zero(option: str, value: float) -> None:
    """Refuse a number that is not above 0."""
    if not 0 < value < math.inf:
        raise InputError(f"{option}: give a number above 0, got {value:g}")


def _interval(text: str, place: str) -> tuple[float, float]:
    low, colon, high = text.partition(":")
    if not colon:
        raise InputError(f"{place}={text}: write NAME=LO:HI")
    return number(low, place), number(high, place)


def number(text: str, place: str) -> float:
    """A finite number; `place` it stands is for the message."""
    try:
        value = float(text)
    except ValueError:
        raise InputError(f"{place}: {text!r} is not a number") from None
    if not math.isfinite(value):
        raise InputError(f"{place}: {text!r} is not a finite number")
    return value


def setting_value(text: str) -> Any:
    """A setting as its method takes it: a number, None, pairs such as [[8, 0.01]], or a word."""
    from json import loads

    for kind in (int, float, loads):
        try:
            return kind(text)
        except (ValueError, RecursionError):
            continue
    return None if text == "None" else text
