"""The bytes of a log, unpacked if packed, within the memory that a read may take."""

from __future__ import annotations

import gzip
import hashlib
import zlib
from pathlib import Path

from ...errors import InputError
from .budget import LARGEST, ReadBudget

#: Bytes that tell a format, of a file or of what is packed in it.
HEAD = 4096
GZIP = b"\x1f\x8b"
BROKEN_GZIP = "is a broken gzip archive: copy or export it again"
_CHUNK = 1 << 20


def checked(file: Path) -> Path:
    """A file that is there and can be read, or a folder.

    Raises:
        InputError: it is not there, no regular file, or empty.
    """
    try:
        if file.is_dir():
            return file
        if file.exists() and not file.is_file():
            raise InputError("is not a regular file")
        if file.stat().st_size == 0:
            raise InputError("is empty")
        with file.open("rb"):
            return file
    except FileNotFoundError as error:
        raise InputError(f"no such file in {file.parent}") from error
    except (OSError, ValueError) as error:  # a zero byte in a path is a ValueError
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(f"cannot be read: {reason}") from error


def head(file: Path) -> bytes:
    """The first bytes of a file, or of what is packed in it with gzip; none of a folder."""
    if file.is_dir():
        return b""
    with file.open("rb") as opened:
        start = opened.read(HEAD)
    if not start.startswith(GZIP):
        return start
    try:
        return zlib.decompressobj(wbits=31).decompress(start, HEAD)
    except zlib.error:
        return start


def whole(file: Path) -> bytes:
    """All bytes of a file, or of what is packed in it with gzip.

    Raises:
        InputError: it is too large, or cannot be unpacked.
    """
    size = file.stat().st_size
    if size > LARGEST:
        raise InputError(
            "is larger than 2 GiB: cut it into parts, or save it as Parquet or HDF5, of which the "
            "channels that are used are read alone"
        )
    data = file.read_bytes()
    if not data.startswith(GZIP):
        return data
    most = ReadBudget(len(data)).total
    try:
        with gzip.open(file) as packed:
            data = packed.read(most + 1)
    except (OSError, EOFError, zlib.error) as error:
        raise InputError(BROKEN_GZIP) from error
    if len(data) > most:
        raise InputError(f"unpacks to more than {ReadBudget(size).most}: unpack it first")
    if not data:
        raise InputError("is empty")
    return data


def sha256(*files: Path) -> str:
    """The hash of files one after another, of a folder all in it by name, read in pieces."""
    digest = hashlib.sha256()
    for file in files:
        for each in sorted(p for p in file.rglob("*") if p.is_file()) if file.is_dir() else [file]:
            with each.open("rb") as opened:
                while piece := opened.read(_CHUNK):
                    digest.update(piece)
    return digest.hexdigest()
