"""Whether the process that claimed a job is still alive: a lock on a file of its own."""

from __future__ import annotations

import uuid
from pathlib import Path
from typing import Self

from ..lock_file import lock_on, remove, taken


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
                _remove_dead(path)  # of processes that were killed
        self._path = store.parent / f"{_prefix(store)}{uuid.uuid4().hex}"
        self.name = self._path.name
        self._lock = lock_on(self._path)
        self._lock.acquire()  # it waits only while another process looks at the new file

    def close(self) -> None:
        """End: what it has claimed is free."""
        if self._lock.is_locked:
            remove(self._path, self._lock)

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
    try:
        lock = taken(path)
    except PermissionError:  # of another user nothing can be said, so nothing is taken
        return False
    if lock is None:
        return False
    remove(path, lock)
    return True


def _prefix(store: Path) -> str:
    return f"{store.name}-owner-"
