"""Text of any usual encoding as UTF-8 with plain line ends."""

from __future__ import annotations

import re
from collections.abc import Iterable
from contextlib import suppress

import numpy as np

from ...errors import InputError

#: Bytes of a text from which its encoding and layout are told.
SNIFFED = 1 << 16
NO_TEXT = "is not text: export the log as CSV, Parquet or MATLAB 5"
_CONTROL = re.compile(rb"[\x00-\x08\x0e-\x1a\x1c-\x1f]")
#: What a text without a mark may be, in the order in which it is tried: cp1252 has `‰` and `µ`
#: where drives write them, but leaves five bytes out; latin-1 has a character for each.
UNMARKED = ("utf-8", "cp1252", "latin-1")
_MARKS = {b"\xff\xfe": "utf-16-le", b"\xfe\xff": "utf-16-be", b"\xef\xbb\xbf": "utf-8"}


def utf8(data: bytes) -> bytes:
    """The text in UTF-8 with plain line ends.

    Raises:
        InputError: it is no text.
    """
    encoding = encoding_mark(data)
    marked = ((encoding[0], encoding[1]),) if encoding is not None else ()
    if marked or not data.isascii():
        data = _decoded(data, (*marked, *((name, 0) for name in UNMARKED)))
    if _CONTROL.search(data, 0, SNIFFED) or b"\0" in data:
        raise InputError(NO_TEXT)
    line_end = b"\r\n" if b"\n" in data else b"\r"
    return data.replace(line_end, b"\n") if b"\r" in data else data


def _decoded(data: bytes, encodings: Iterable[tuple[str, int]]) -> bytes:
    """A text in UTF-8, by the first of some encodings that reads it; each with bytes to skip."""
    for name, mark in encodings:
        with suppress(UnicodeDecodeError):
            return data[mark:].decode(name).encode()
    raise InputError(NO_TEXT)


def encoding_mark(head: bytes) -> tuple[str, int] | None:
    """The encoding that the first bytes of a text show, and the bytes of its mark."""
    marked = next(((name, len(m)) for m, name in _MARKS.items() if head.startswith(m)), None)
    wide = _wide(head)
    return marked or (None if wide is None else (wide, 0))


def has_control(head: bytes) -> bool:
    """Whether the first bytes of something have characters that no text has."""
    return _CONTROL.search(head, 0, SNIFFED) is not None


def _wide(data: bytes) -> str | None:
    """UTF-16 without a mark, known by its zero bytes."""
    head = np.frombuffer(data[: SNIFFED & -2][: len(data) & -2], dtype=np.uint8)
    zero = (head.reshape(-1, 2) == 0).mean(axis=0) if len(head) else np.zeros(2)
    if zero[1] > 0.9 and zero[0] == 0:  # noqa: PLR2004 - Latin text has a zero in each pair
        return "utf-16-le"
    return "utf-16-be" if zero[0] > 0.9 and zero[1] == 0 else None  # noqa: PLR2004


def is_text(head: bytes) -> bool:
    """Whether the first bytes of a file are those of a text."""
    marked = encoding_mark(head) is not None
    return marked or not (_CONTROL.search(head) or b"\0" in head)
