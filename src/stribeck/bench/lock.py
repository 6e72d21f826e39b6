"""Is the process that claimed a job still alive? Its lock on a small file of its own says so.

The operating system drops the lock when the process ends, however it ends, so there is no clock
to trust and no process number to compare: it holds across containers that share the folder.
"""

from __future__ import annotations

import contextlib
import errno
import os
import sys
import tempfile
import weakref
from pathlib import Path
from typing import Self

if sys.platform == "win32":
    import msvcrt

    def _lock(fd: int) -> None:
        msvcrt.locking(fd, msvcrt.LK_NBLCK, 1)
else:
    import fcntl

    def _lock(fd: int) -> None:
        fcntl.flock(fd, fcntl.LOCK_EX | fcntl.LOCK_NB)


#: What the system says of a lock that another process holds.
_TAKEN = {errno.EACCES, errno.EAGAIN, errno.EDEADLK, errno.EWOULDBLOCK}


class Owner:
    """A process at work on a store, alive for the others until it is closed or ends.

    Args:
        store: The store's file; the lock file lies beside it.

    Attributes:
        name: The name of the lock file, different for every owner there ever was.

    Raises:
        OSError: the lock file cannot be made.
    """

    def __init__(self, store: Path) -> None:
        for path in store.parent.iterdir():
            if path.name.startswith(_prefix(store)):
                _bury(path)  # of processes that were killed
        while True:
            self._fd, made = tempfile.mkstemp(prefix=_prefix(store), dir=store.parent)
            self._path, self.name = Path(made), Path(made).name
            _OWNERS.add(self)
            if _held(self._fd) and os.fstat(self._fd).st_nlink:
                return
            self._disown()  # another process took it for a dead one's before it was locked

    def close(self) -> None:
        """End: what it has claimed is free."""
        if self._fd >= 0:
            with contextlib.suppress(OSError):
                self._path.unlink()
            self._disown()
            with contextlib.suppress(OSError):  # Windows removes no file that is open
                self._path.unlink()

    def _disown(self) -> None:
        if self._fd >= 0:
            os.close(self._fd)
            self._fd = -1

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *raised: object) -> None:
        self.close()


def alive(store: Path, name: str) -> bool:
    """Whether the owner of that name lives; the lock file of one that does not is removed."""
    ours = name.startswith(_prefix(store)) and name == Path(name).name
    return ours and not _bury(store.parent / name)


def _bury(path: Path) -> bool:
    """Remove the lock file of a process that is gone; False if the process lives."""
    try:
        fd = os.open(path, os.O_RDWR)
    except FileNotFoundError:
        return True
    except PermissionError:  # of another user: nothing can be said, so nothing is taken
        return False
    try:
        if not _held(fd):
            return False
        with contextlib.suppress(OSError):  # while locked, so that nobody takes it for alive
            path.unlink()
    finally:
        os.close(fd)
    with contextlib.suppress(OSError):  # Windows removes no file that is open
        path.unlink()
    return True


def _held(fd: int) -> bool:
    """Take the lock of an open file, if it is free."""
    try:
        _lock(fd)
    except OSError as error:
        if error.errno in _TAKEN:
            return False
        raise
    return True


def _prefix(store: Path) -> str:
    return f"{store.name}-owner-"


_OWNERS: weakref.WeakSet[Owner] = weakref.WeakSet()


def _disown_all() -> None:
    for owner in _OWNERS:
        owner._disown()  # noqa: SLF001 - of this file


if hasattr(os, "register_at_fork"):  # a forked child would keep its parent's lock alive
    os.register_at_fork(after_in_child=_disown_all)
