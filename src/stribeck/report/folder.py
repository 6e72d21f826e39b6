"""Results on disk: each file appears whole or not at all."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping


def check_folder(folder: Path) -> None:
    """Say before the work starts that its results could not be written.

    Raises:
        InputError: the folder is a file, cannot be written to, or lies in one that is not there.
    """
    try:
        place = folder if folder.exists() else folder.parent
        present, usable = place.exists(), os.access(place, os.W_OK | os.X_OK)
    except OSError as error:  # a name too long, say
        raise InputError(f"{folder}: {error.strerror or error}: take another folder") from error
    if not present:
        raise InputError(f"{folder}: the folder {folder.parent} is not there: make it first")
    if not place.is_dir():
        raise InputError(f"{place}: is a file, not a folder: take another name")
    if not usable:
        raise InputError(f"{place}: no permission to write there: take another folder")


def check_file(file: Path, suffix: str = "") -> None:
    """The same for a single file, which has to end in a suffix.

    Raises:
        InputError: also if the folder is not there, or something else than a file has its name.
    """
    if suffix and file.suffix.lower() != suffix:
        raise InputError(f"{file}: is written as {suffix[1:].upper()}: name it {file}{suffix}")
    try:
        taken = file.exists() and not file.is_file()
    except OSError as error:
        raise InputError(f"{file}: {error.strerror or error}: take another name") from error
    if taken:
        what = "folder: name a file in it" if file.is_dir() else "device: name a file"
        raise InputError(f"{file}: is a {what}")
    if not file.parent.exists():
        raise InputError(f"{file}: the folder {file.parent} is not there: make it first")
    check_folder(file.parent)


def write_text(file: Path, text: str) -> None:
    """Write a text file, whole or not at all."""
    write_files(file.parent, lambda place: (place / file.name).write_text(text, encoding="utf-8"))


def write_data(file: Path, data: bytes) -> None:
    """The same for bytes."""
    write_files(file.parent, lambda place: (place / file.name).write_bytes(data))


def write_all(folder: Path, files: Mapping[str, bytes]) -> None:
    """The same for several, by name."""

    def write(place: Path) -> None:
        for name, data in files.items():
            (place / name).write_bytes(data)

    write_files(folder, write)


def write_files(folder: Path, write: Callable[[Path], object]) -> None:
    """Let `write` fill an empty folder, then move its files into `folder`.

    Raises:
        InputError: the disk refuses.
    """
    new = not folder.exists()
    try:
        folder.mkdir(exist_ok=True)
        with tempfile.TemporaryDirectory(prefix=".stribeck-", dir=folder) as name:
            write(Path(name))
            for file in sorted(Path(name).iterdir()):
                os.replace(file, folder / file.name)  # noqa: PTH105 - atomic, and says so
    except OSError as error:
        if new and folder.is_dir() and not any(folder.iterdir()):
            folder.rmdir()
        raise InputError(f"{folder}: cannot be written: {error.strerror or error}") from error
