"""Locks on files that die with their process, however that ends.

The operating system drops such a lock, so there is no clock to trust and no process number to
compare: it holds across containers that share the folder.
"""

from __future__ import annotations

import contextlib
from errno import ENOLCK, ENOSYS, EOPNOTSUPP
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from filelock import FileLock

#: Errors of file systems that have no locks.
NO_LOCKS = frozenset({ENOSYS, EOPNOTSUPP, ENOLCK})


def lock_on(path: Path) -> FileLock:
    """A lock on a file, not yet taken; a file system without locks is an error.

    A child that is forked does not keep its parent's lock.
    """
    from filelock import FileLock  # noqa: PLC0415 - most commands write nothing

    return FileLock(path, thread_local=False, fallback_to_soft=False)


def taken(path: Path, *, wait: bool = False) -> FileLock | None:
    """The lock on a file, which is made where it is not there; None while a process holds it.

    Args:
        path: The file.
        wait: Whether to wait until no process holds it.

    Raises:
        OSError: the file cannot be made, or its file system has no locks.
    """
    from filelock import Timeout  # noqa: PLC0415

    lock = lock_on(path)
    try:
        lock.acquire(blocking=wait)
    except Timeout:
        return None
    return lock


def remove(path: Path, lock: FileLock) -> None:
    """Remove a lock file that this process holds, and let go of it."""
    with contextlib.suppress(OSError):  # while locked, so that nobody takes it for alive
        path.unlink()
    lock.release()
    with contextlib.suppress(OSError):  # Windows removes no file that is open
        path.unlink()
