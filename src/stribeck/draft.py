"""Files written aside and moved into their folder together, however the process ends.

A draft is a hidden folder in the folder that its files are for: a lock that dies with its process,
the files, and, once all of them are written, a mark with the names of those that they outdate.
From then on they are as good as in their place: a process that comes upon the draft of a dead one
moves what is left of it. A draft without a mark whose process is dead is removed.
"""

from __future__ import annotations

import os
import shutil
import uuid
from collections.abc import Iterable, Iterator
from errno import EISDIR, ENOTDIR
from pathlib import Path
from typing import TYPE_CHECKING

from .lock_file import NO_LOCKS, taken

if TYPE_CHECKING:
    from filelock import FileLock

#: How the names of drafts begin.
PREFIX = ".stribeck-"
_LOCK, _FILES, _MARK = "lock", "files", "complete"


class Draft:
    """A draft of this process.

    Args:
        folder: The folder that its files are for.

    Attributes:
        files: The folder to write them to.

    Raises:
        OSError: the disk refuses.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._lock: FileLock | None = None
        while True:
            self._path = folder / f"{PREFIX}{uuid.uuid4().hex[:12]}"
            self.files = self._path / _FILES
            self._path.mkdir(mode=0o700)
            try:
                self._acquire()
                self.files.mkdir()
            except FileNotFoundError:  # before it had its lock it was taken for a dead one's
                self.discard()
                continue
            return

    def publish(self, outdated: Iterable[str] = ()) -> None:
        """Move the files into the folder, in place of those of their names and the outdated.

        Args:
            outdated: Files in the folder that are removed, by their paths from it.

        Raises:
            OSError: the disk refuses.
        """
        list(_moves(self._path, self._folder))  # while there is still a way back
        names = "".join(f"{name}\n" for name in outdated)
        new, mark = self._path / f"{_MARK}.new", self._path / _MARK
        new.write_bytes(os.fsencode(names))
        try:
            new.rename(mark)
            _move(self._path, self._folder)
        except KeyboardInterrupt:
            if mark.exists():  # half of them would be neither the old nor the new
                _move(self._path, self._folder)
            raise
        finally:
            self.discard()

    def discard(self) -> None:
        """Leave nothing of it, unless its files could not all be moved."""
        if self._lock is not None:
            self._lock.release()
        if not (self._path / _MARK).exists():
            shutil.rmtree(self._path, ignore_errors=True)

    def _acquire(self) -> None:
        try:
            self._lock = taken(self._path / _LOCK, wait=True)
        except OSError as error:
            if error.errno not in NO_LOCKS:  # where there are none nobody clears drafts either
                raise


def settle(folder: Path) -> None:
    """Move what dead processes had ready for a folder, and remove what they had not.

    Raises:
        OSError: the disk refuses to move it.
    """
    for path in sorted(folder.glob(f"{PREFIX}*/")):
        try:
            lock = taken(path / _LOCK) if _ours(path) else None
        except OSError:  # gone meanwhile, or without locks
            continue
        if lock is None:
            continue
        try:
            if (path / _MARK).exists():
                _move(path, folder)
        finally:
            lock.release()
        shutil.rmtree(path, ignore_errors=True)


def _ours(path: Path) -> bool:
    """Whether this user made a draft: in a folder that is shared, others' are left to them."""
    return not path.is_symlink() and (os.name != "posix" or path.stat().st_uid == os.geteuid())


def _move(path: Path, folder: Path) -> None:
    """Move a draft's files into their folder; what was moved before is left as it is."""
    for name in os.fsdecode((path / _MARK).read_bytes()).splitlines():
        place = folder / name
        parents = place.parents[: len(Path(name).parts) - 1]
        if ".." in Path(name).parts or Path(name).is_absolute():
            continue
        if not any(p.is_symlink() for p in parents):  # the folder may be a stranger's
            place.unlink(missing_ok=True)
    for file, place in list(_moves(path, folder)):
        place.parent.mkdir(parents=True, exist_ok=True)
        os.replace(file, place)  # noqa: PTH105 - atomic, and says so
    (path / _MARK).unlink()


def _moves(path: Path, folder: Path) -> Iterator[tuple[Path, Path]]:
    """The files of a draft, and their places.

    Raises:
        OSError: a place is a folder, or lies behind a link.
    """
    files = path / _FILES
    for file in sorted(files.rglob("*")):
        place = folder / file.relative_to(files)
        if file.is_dir():
            if place.is_symlink():
                raise OSError(ENOTDIR, "it is a link", str(place))
        elif place.is_dir():
            raise OSError(EISDIR, "it is a folder", str(place))
        else:
            yield file, place
