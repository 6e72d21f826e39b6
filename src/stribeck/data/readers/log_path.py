"""Where a log is, as people write it: `pos.csv+force.csv@10s:40s`, a part of two files' run."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from ...errors import InputError
from .raw_table import printable

#: What stands between the files of one run.
BETWEEN = "+"
_WINDOW = re.compile(r"(?P<file>.+)(?P<window>@(?P<since>[\d.]+)s:(?P<until>[\d.]+)s)")


@dataclass(frozen=True)
class LogPath:
    """The files of a log, and the part of it that is meant.

    Args:
        files: One, or those of one run; a folder is one.
        window: s from the start.
        written: The window as it was written.
    """

    files: tuple[Path, ...]
    window: tuple[float, float] | None = None
    written: str = ""

    @classmethod
    def of(cls, path: str | Path | Sequence[str | Path]) -> LogPath:
        """A path, or the paths of the files of one run.

        A file that is called so is neither a part of another nor several. A name without a folder
        stands in the folder of the first file.

        Raises:
            InputError: the window is empty, or stands in the middle.
        """
        if not isinstance(path, str | Path):
            files = tuple(Path(each) for each in path)
            if not files:
                raise InputError("no file was given")
            return cls(files)
        text = str(path)
        if _is_there(Path(text)):
            return cls((Path(text),))
        match = _WINDOW.fullmatch(text)
        window = None
        if match is not None:
            window = float(match["since"]), float(match["until"])
            if not window[0] < window[1]:
                raise InputError(
                    f"{Path(text).name}: from {window[0]:g} s to {window[1]:g} s is no time"
                )
        files = _files(match["file"] if match else text)
        for file in files[:-1]:
            if _WINDOW.fullmatch(file.name) and not _is_there(file):
                raise InputError(f"{file.name}: write the part of a run behind its last file")
        return cls(files, window, match["window"] if match else "")

    @property
    def name(self) -> str:
        """The names of its files without their folders, and the window."""
        return printable(BETWEEN.join(file.name for file in self.files) + self.written)


def _files(text: str) -> tuple[Path, ...]:
    if BETWEEN not in text or _is_there(Path(text)):
        return (Path(text),)
    pieces = text.split(BETWEEN)
    files: list[Path] = []
    while pieces:
        file, pieces = _first(pieces, files[0].parent if files else Path())
        files.append(file)
    return tuple(files)


def _is_there(path: Path) -> bool:
    try:
        return path.exists()
    except (OSError, ValueError):  # no name that the system takes
        return False


def _first(pieces: list[str], folder: Path) -> tuple[Path, list[str]]:
    """The first file, whose name may have a `+` if there is one that is called so, and the rest."""
    for count in range(len(pieces), 0, -1):
        name = Path(BETWEEN.join(pieces[:count]).strip())
        file = name if len(name.parts) > 1 else folder / name
        if count == 1 or _is_there(file):
            return file, pieces[count:]
    raise AssertionError
