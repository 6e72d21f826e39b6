"""Memory that arrays no longer need, back to the operating system."""

from __future__ import annotations

import ctypes
from functools import cache
from typing import Any


def release() -> None:
    """Hand back what the C library keeps of freed memory, where it can (glibc).

    Arrays of some megabytes come from its heap, of which it hands back the end alone: after work
    on a long log half of what a process holds may be free.
    """
    trim = _trim()
    if trim is not None:
        trim(0)


@cache
def _trim() -> Any:
    """The `malloc_trim` of glibc, or None of another C library."""
    try:
        return ctypes.CDLL(None).malloc_trim
    except (AttributeError, OSError, TypeError):  # another C library, or Windows
        return None
