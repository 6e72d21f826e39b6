"""Rows of a manifest from the names of files: `logs/{machine}/{axis}/{when}.csv`."""

from __future__ import annotations

import datetime as dt
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from ..errors import InputError

#: What a pattern may take from a path.
FIELDS = ("axis", "machine", "when", "joint", "temperature", "load")
_FIELD = re.compile(r"\{(\w+)\}")


def matched_rows(pattern: str, folder: Path, when_format: str | None) -> Iterator[dict[str, Any]]:
    """A row for every file that a pattern fits, in the order of their paths.

    Args:
        pattern: A path in which `{axis}` and the like stand for a name without slashes, and `*`
            for any; the same field twice has to be the same.
        folder: Where it starts.
        when_format: How `{when}` is written, as `strptime` takes it; by default as ISO 8601.

    Raises:
        InputError: a field that no row has, no file, or a time that is not so written.
    """
    if strange := [name for name in _FIELD.findall(pattern) if name not in FIELDS]:
        raise InputError(f"log: no field {{{strange[0]}}}: there are {', '.join(FIELDS)}")
    root, relative = _root(pattern, folder)
    expression, found = re.compile(_expression(relative)), False
    paths = (p.relative_to(root).as_posix() for p in found_paths(root, _glob(relative)))
    for path in sorted(paths):
        if match := expression.fullmatch(path):
            found = True
            row: dict[str, Any] = {"log": str(root / path), **match.groupdict()}
            if "when" in row and when_format is not None:
                row["when"] = _time(row["when"], when_format, path)
            yield row
    if not found:
        raise InputError(f"log: no file is called {pattern}: it is sought from {folder}")


def found_paths(folder: Path, pattern: str) -> list[Path]:
    """What is called as a pattern says, in a folder.

    Raises:
        InputError: no path can be called so.
    """
    try:
        return list(folder.glob(pattern))
    except (ValueError, NotImplementedError, IndexError) as error:
        raise InputError(f"log: {pattern!r} is no pattern of paths: {error}") from error


def _glob(pattern: str) -> str:
    """A pattern as the file system takes it: fields beside each other are one `*`."""
    return re.sub(r"\**\0[\0*]*", "*", _FIELD.sub("\0", pattern))


def _root(pattern: str, folder: Path) -> tuple[Path, str]:
    """The folder of a pattern that is the same for all its files, and the rest of it."""
    parts = Path(pattern).parts
    fixed = next((k for k, part in enumerate(parts) if re.search(r"[{*?\[]", part)), len(parts) - 1)
    return folder.joinpath(*parts[:fixed]), "/".join(parts[fixed:])


def _expression(pattern: str) -> str:
    """The regular expression of a pattern."""
    text, seen = "", set[str]()
    for piece in re.split(r"(\{\w+\}|\*\*/|\*|\?)", pattern):
        if match := _FIELD.fullmatch(piece):
            name = match[1]
            text += f"(?P={name})" if name in seen else f"(?P<{name}>[^/]+)"
            seen.add(name)
        else:
            wild = {"**/": "(?:.*/)?", "*": "[^/]*", "?": "[^/]"}
            text += wild.get(piece, re.escape(piece))
    return text


def _time(text: str, form: str, path: str) -> dt.datetime:
    try:
        return dt.datetime.strptime(text, form)  # noqa: DTZ007 - a zone stands in the format
    except (ValueError, re.error) as error:  # the latter of a format that has a field twice
        raise InputError(f"log: {path}: {text!r} is not a time written {form!r}") from error
