"""Whether the process that claimed a job is still alive: a lock on a file of its own.

The operating system drops the lock when the process ends, however it ends, so there is no clock
to trust and no process number to compare: it holds across containers that share the folder.
"""

from __future__ import annotations

import contextlib
import uuid
from pathlib import Path
from typing import Self

from filelock import FileLock, Timeout


class Owner:
    """A process at work on a store, alive for the others until it is closed or ends.

    A child that is forked does not keep its parent's lock.

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
                _remove_dead(path)  # of processes that were killed
        self._path = store.parent / f"{_prefix(store)}{uuid.uuid4().hex}"
        self.name = self._path.name
        self._lock = _lock(self._path)
        self._lock.acquire()  # it waits only while another process looks at the new file

    def close(self) -> None:
        """End: what it has claimed is free."""
        if self._lock.is_locked:
            _remove(self._path, self._lock)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *raised: object) -> None:
        self.close()


def alive(store: Path, name: str) -> bool:
    """Whether the owner of that name lives; the lock file of one that does not is removed."""
    ours = name.startswith(_prefix(store)) and name == Path(name).name
    return ours and not _remove_dead(store.parent / name)


def _remove_dead(path: Path) -> bool:
    """Remove the lock file of a process that is gone; False if the process lives."""
    if not path.exists():
        return True
    lock = _lock(path)
    try:
        lock.acquire(blocking=False)
    except (Timeout, PermissionError):  # of another user nothing can be said, so nothing is taken
        return False
    _remove(path, lock)
    return True


def _lock(path: Path) -> FileLock:
    """A lock of this process's on a file; a file system without locks is an error."""
    return FileLock(path, thread_local=False, fallback_to_soft=False)


def _remove(path: Path, lock: FileLock) -> None:
    """Remove a lock file that this process holds, and let go of it."""
    with contextlib.suppress(OSError):  # while locked, so that nobody takes it for alive
        path.unlink()
    lock.release()
    with contextlib.suppress(OSError):  # Windows removes no file that is open
        path.unlink()


def _prefix(store: Path) -> str:
    return f"{store.name}-owner-"
