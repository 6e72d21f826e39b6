"""Files that are dropped on the page: bounded, and named by the studio and never by the sender."""

from __future__ import annotations

import contextlib
import re
import shutil
from collections.abc import AsyncIterable
from pathlib import Path, PurePosixPath

import anyio

from ..data.readers.budget import LARGEST
from ..errors import InputError
from .home import Home, StoredLog

#: Letters of a name that are kept.
LONGEST = 120
_UNUSUAL = re.compile(r"[^\w .()\[\]@=,-]")


def file_name(text: str) -> str:
    """A name for a file, whatever was sent as its name: without folders, and of usual letters.

    Raises:
        InputError: nothing is left of it.
    """
    name = PurePosixPath(text.replace("\\", "/")).name
    name = _UNUSUAL.sub("_", name).strip(" .")
    # `a+b` would be two files of one run, and `a@1s:2s` a part of one.
    name = name.replace("@", "_")
    if len(name) > LONGEST:
        stem, dot, end = name.rpartition(".")
        name = f"{stem[: LONGEST - len(end) - 1]}{dot}{end}"[:LONGEST]
    if not name.strip("._ "):
        raise InputError(f"{text[:40]!r} is no name for a file")
    return name


async def store(home: Home, name: str, body: AsyncIterable[bytes]) -> StoredLog:
    """Keep a file that is being sent.

    Raises:
        InputError: its name is none, it is empty or larger than what is read, or the disk refuses.
    """
    safe = file_name(name)
    folder = home.log_folder()
    try:
        path = folder / safe
        await _written(path, body)
        return home.keep_log(safe, path)
    except BaseException:
        with contextlib.suppress(OSError):
            shutil.rmtree(folder)
        raise


async def _written(path: Path, body: AsyncIterable[bytes]) -> None:
    size = 0
    try:
        async with await anyio.open_file(path, "wb") as file:
            async for piece in body:
                size += len(piece)
                if size > LARGEST:
                    raise InputError(
                        f"{path.name}: is larger than {LARGEST >> 30} GiB: start the studio with "
                        "the path of the file, which it then reads where it is"
                    )
                await file.write(piece)
    except OSError as error:
        raise InputError(f"{path.name}: cannot be kept: {error.strerror or error}") from error
    if not size:
        raise InputError(f"{path.name}: is empty")
