"""Memory that arrays no longer need, back to the operating system."""

from __future__ import annotations

import ctypes
from functools import cache
from typing import Any

#: Samples of logs from which on it is worth its while: what short ones took is soon wanted again.
_LONG = 1 << 20


def release(samples: int) -> None:
    """Hand back what the C library keeps of freed memory, where it can (glibc).

    Arrays of some megabytes come from its heap, of which it hands back the end alone: after work
    on a long log half of what a process holds may be free.

    Args:
        samples: Of the logs that were worked on; of fewer than a million nothing is handed back.
    """
    trim = _trim() if samples >= _LONG else None
    if trim is not None:
        trim(0)


@cache
def _trim() -> Any:
    """The `malloc_trim` of glibc, or None of another C library."""
    try:
        return ctypes.CDLL(None).malloc_trim
    except (AttributeError, OSError, TypeError):  # another C library, or Windows
        return None
