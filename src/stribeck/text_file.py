"""A small text file that a person wrote, a card or a mapping: read whole, or one line why not."""

from __future__ import annotations

from pathlib import Path

from .errors import InputError

#: Such a file is a page, not a data set: bytes.
LARGEST = 4 << 20


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
