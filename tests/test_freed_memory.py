"""Freed memory goes back to the system after long logs."""

from __future__ import annotations

import platform
from pathlib import Path

import numpy as np
import pytest

from stribeck.data.freed_memory import release


def resident() -> int:
    """Pages that this process has in memory."""
    return int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="the C library here is not glibc")
def test_what_was_freed_is_handed_back_after_long_logs_alone() -> None:
    chunks = [np.ones(2_000) for _ in range(20_000)]  # 320 MB of the heap
    last = np.ones(2_000)  # at its end, so that nothing goes back by itself
    del chunks
    before = resident()
    release(1000)
    assert resident() > 0.9 * before
    release(10_000_000)
    assert resident() < before - 40_000
    assert last.sum() == 2_000
