"""How a message names an option: as the command line spells it, or as a keyword of Python.

What refuses or advises stands on lower floors than what reads arguments, and the same sentence
reaches both who typed a command and who called a function. `option("repeats", 3)` is `repeats=3`
to the second; within `on_command_line`, which the command line enters, it is `--repeats 3`.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import TypeAlias

Value: TypeAlias = str | float | Mapping[str, str | float]

#: Keywords whose option is called otherwise.
_OPTIONS = {
    "columns": "--column",
    "constants": "--set",
    "fixed": "--set",
    "settings": "--setting",
    "within": "--range",
}
#: Keys of `columns` that are no channels, but options of their own.
_READING = frozenset({"joint", "rate", "time_unit", "stamp", "episode", "subtract"})
#: Options in other units than their keywords, and how many of them one is: ms of seconds.
_SCALES = {"delay": 1e3, "period": 1e3}
#: Words that stand for a value, and are no text.
_PLACEHOLDERS = frozenset({"VALUE", "HZ"})
#: What a shell takes as it is.
_PLAIN = re.compile(r"[\w.,:=±+-]+")

_COMMAND_LINE = [False]


@contextmanager
def on_command_line(*, entered: bool = True) -> Iterator[None]:
    """Messages name options as they are typed, in the block and what it calls."""
    before = _COMMAND_LINE[0]
    _COMMAND_LINE[0] = entered
    try:
        yield
    finally:
        _COMMAND_LINE[0] = before


def is_command_line() -> bool:
    """Whether messages go to who typed a command."""
    return _COMMAND_LINE[0]


def either(command: str, python: str) -> str:
    """One of two spellings, where an option and its keyword differ by more than their form."""
    return command if _COMMAND_LINE[0] else python


def option(keyword: str, value: Value | None = None) -> str:
    """An option, with a value to give it.

    Args:
        keyword: Of the Python function.
        value: As of the keyword: text, a number, or one of either by name.
    """
    if not _COMMAND_LINE[0]:
        return keyword if value is None else f"{keyword}={_literal(value)}"
    typed = _OPTIONS.get(keyword) or f"--{keyword.replace('_', '-')}"
    if value is None:
        return typed
    if not isinstance(value, Mapping):
        scaled = value if isinstance(value, str) else value * _SCALES.get(keyword, 1.0)
        return f"{typed} {_word(scaled)}"
    return " ".join(_pair(typed, name, v) for name, v in value.items())


def _pair(typed: str, name: str, value: str | float) -> str:
    if typed == _OPTIONS["columns"]:
        if name in _READING:
            return f"{option(name)} {_word(value)}"
        return f'{typed} {name}="{value}"'
    return f"{typed} {name}={_word(value)}"


def _word(value: str | float) -> str:
    """A value as it is typed."""
    text = value if isinstance(value, str) else _number(value)
    return text if _PLAIN.fullmatch(text) else f'"{text}"'


def _literal(value: Value) -> str:
    """A value as Python writes it, text in double quotes."""
    if isinstance(value, Mapping):
        return f"{{{', '.join(f'{_quoted(k)}: {_literal(v)}' for k, v in value.items())}}}"
    if isinstance(value, str):
        return value if value in _PLACEHOLDERS else _quoted(value)
    return _number(value)


def _quoted(text: str) -> str:
    return json.dumps(text, ensure_ascii=False)


def _number(value: float) -> str:
    return str(value) if isinstance(value, int) else f"{value:.4g}"
