"""Results on disk: each file appears whole or not at all."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable

    from ..identify.fit import Fit


def check_folder(folder: Path) -> None:
    """Say before the work starts that its results could not be written.

    Raises:
        InputError: the folder is a file, cannot be written to, or lies in one that is not there.
    """
    place = folder if folder.exists() else folder.parent
    if not place.exists():
        raise InputError(f"{folder}: the folder {folder.parent} is not there: make it first")
    if not place.is_dir():
        raise InputError(f"{place}: is a file, not a folder")
    if not os.access(place, os.W_OK | os.X_OK):
        raise InputError(f"{place}: no permission to write there")


def check_file(file: Path) -> None:
    """The same for a single file."""
    if file.is_dir():
        raise InputError(f"{file}: is a folder: name a file in it")
    check_folder(file.parent)


def write_text(file: Path, text: str) -> None:
    """Write a text file, whole or not at all."""
    write_files(file.parent, lambda place: (place / file.name).write_text(text, encoding="utf-8"))


def write_files(folder: Path, write: Callable[[Path], object]) -> None:
    """Let `write` fill an empty folder, then move its files into `folder`.

    Raises:
        InputError: the disk refuses.
    """
    try:
        folder.mkdir(exist_ok=True)
        with tempfile.TemporaryDirectory(prefix=".stribeck-", dir=folder) as name:
            write(Path(name))
            for file in sorted(Path(name).iterdir()):
                os.replace(file, folder / file.name)  # noqa: PTH105 - atomic, and says so
    except OSError as error:
        raise InputError(f"{folder}: cannot be written: {error.strerror or error}") from error


def write_fit(fit: Fit, folder: Path) -> None:
    """Write a fit's card and figures into a folder."""
    from ..identify.card import card  # noqa: PLC0415 - pydantic and matplotlib come late on purpose
    from .figures import draw  # noqa: PLC0415

    # The card first: whatever happens to a figure, the numbers are safe.
    write_text(folder / "card.json", card(fit).text())
    write_files(folder, lambda place: draw(fit, place))
