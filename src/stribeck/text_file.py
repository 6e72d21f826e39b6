"""A small text file that a person wrote, a card or a mapping: read whole, or one line why not.

What is written for people to change is TOML.
"""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from .errors import InputError

#: Such a file is a page, not a data set: bytes.
LARGEST = 4 << 20

#: A key of TOML that needs no quotes; and what its strings must not hold as it is, JSON's may.
_BARE, _DELETE = re.compile(r"[A-Za-z0-9_-]+"), "\x7f"
#: How deep tables have heads of their own: `[load.mass]`.
_HEADED = 2


def page(file: Path) -> str:
    """The text of a small UTF-8 file.

    The caller names the file: the line starts with what is wrong.

    Raises:
        InputError: no such file, not a regular one, too large, or not text.
    """
    try:
        return page_bytes(file).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError("is not UTF-8 text: is it the right file?") from error


def page_bytes(file: Path) -> bytes:
    """The same without a look at what it says.

    Raises:
        InputError: no such file, not a regular one, or too large.
    """
    try:
        if file.is_dir():
            raise InputError("is a folder: name a file in it")
        if file.exists() and not file.is_file():
            raise InputError("is not a regular file")
        with file.open("rb") as f:
            data = f.read(LARGEST + 1)
        if len(data) > LARGEST:
            raise InputError(f"is larger than {LARGEST >> 20} MiB: is it the right file?")
    except FileNotFoundError as error:
        raise InputError("no such file") from error
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror or error}") from error
    return data


def unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """A JSON object of its (name, value) pairs, for a decoder's `object_pairs_hook`.

    Raises:
        InputError: a name stands twice in it; JSON leaves open which of the two would count.
    """
    members = dict(pairs)
    if len(members) < len(pairs):
        counts = Counter(name for name, _ in pairs)
        doubled = next(name for name, count in counts.items() if count > 1)
        raise InputError(f"the name {doubled[:40]!r} stands twice in one object: keep one")
    return members


def json_document(text: str) -> Any:
    """A JSON text in which no object has a name twice.

    The caller names the file, as with `page`.

    Raises:
        InputError: a name stands twice in one object.
        ValueError: it is no JSON.
        RecursionError: it is nested too deeply.
    """
    return json.loads(text, object_pairs_hook=unique)


def toml_text(table: Mapping[str, Any]) -> str:
    """A table as TOML: tables, and tables in these, under heads; what is deeper stands inline."""
    return "\n".join(_toml_lines(table, ())).strip() + "\n"


def toml_value(value: Any) -> str:
    """A value as TOML: text, a number, true or false, a list or an inline table."""
    if isinstance(value, Mapping):
        return f"{{ {', '.join(f'{_key(k)} = {toml_value(v)}' for k, v in value.items())} }}"
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(toml_value, value))}]"
    return json.dumps(value, ensure_ascii=False).replace(_DELETE, "\\u007f")


def _toml_lines(table: Mapping[str, Any], place: tuple[str, ...]) -> list[str]:
    inner = {k: v for k, v in table.items() if isinstance(v, Mapping) and len(place) < _HEADED}
    plain = [f"{_key(k)} = {toml_value(v)}" for k, v in table.items() if k not in inner]
    head = [f"[{'.'.join(map(_key, place))}]"] if place and (plain or not inner) else []
    rest = [line for k, v in inner.items() for line in _toml_lines(v, (*place, k))]
    return [*head, *plain, "", *rest] if head or plain else rest


def _key(name: str) -> str:
    return name if _BARE.fullmatch(name) else toml_value(name)
