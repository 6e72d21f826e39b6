"""Recursive filters run forwards and backwards over long columns, a block at a time.

The forward pass hands its state from block to block. The backward pass of a block begins so far
beyond its end that nothing is left of how it began (overlap and discard), so that the result is
that of one pass over everything (SciPy's `sosfiltfilt`) to the last digits, and what it takes is a
few blocks. Columns go through together: their recursions do not wait for each other.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import numpy as np
from numba import boolean, float64, void
from numpy.typing import NDArray

from ..compile_cache import compiled
from ..compile_cache.copies import copy_into
from ..space import Array
from .low_pass import settled

#: Samples of a column: a slice with both ends and no step, or their numbers.
Samples = slice | NDArray[np.intp]
#: Columns as a function of samples: (len(samples), k), or (len(samples),) of one.
Signal = Callable[[Samples], Array]

#: Samples of a block; at the length of a response a block is that many times as long.
BLOCK, _LONGER = 1 << 16, 8
#: What is left of how the backward pass of a block began.
_LEFT = 1e-20


def zero_phase(sections: Array, signal: Signal, n: int, padding: int, every: slice) -> Array:
    """Columns through a filter both ways, and the samples of them that are kept, (kept, k).

    Args:
        sections: Second-order sections, (n, 6).
        signal: The columns.
        n: Their length.
        padding: Samples by which they are mirrored about their ends.
        every: Which samples are kept, with all three numbers.
    """
    rest, reach = _settling(np.ascontiguousarray(sections).tobytes())
    block = max(BLOCK, _LONGER * reach)
    total, count, done = n + 2 * padding, 0, 0
    state: Array | None = None
    kept: Array | None = None
    waiting: Array | None = None
    for begin in range(0, total, block):
        end = min(begin + block, total)
        y = _mirrored(signal, n, padding, begin, end)
        if state is None or kept is None:
            state = rest[:, :, None] * y[0]
            kept = np.empty((len(range(*every.indices(n))), y.shape[1]))
        _cascade(sections, y, state, False)
        y = y if waiting is None else np.concatenate([waiting, y])
        stop = total if end == total else max(end - reach, done)
        waiting = y[stop - done :].copy()
        _cascade(sections, y, rest[:, :, None] * y[-1], True)
        first = max(done - padding, 0)
        first += (every.start - first) % every.step
        last = min(stop - padding, every.stop)
        some = y[first + padding - done : max(last + padding - done, 0) : every.step]
        kept[count : count + len(some)] = some
        count, done = count + len(some), stop
    assert kept is not None  # noqa: S101 - a column has samples
    return kept


@lru_cache(maxsize=64)  # a search filters thousands of times by the same sections
def _settling(sections: bytes) -> tuple[Array, int]:
    """The state (n, 2) of sections (n, 6) under a constant 1, and samples until it is forgotten."""
    table = np.frombuffer(sections).reshape(-1, 6)
    return settled(table), _reach(table)


def _reach(sections: Array) -> int:
    """Samples after which a filter has forgotten."""
    slowest = max(float(np.abs(np.roots(s[3:])).max(initial=0.0)) for s in sections)
    return int(np.ceil(np.log(_LEFT) / np.log(min(max(slowest, 0.1), 1 - 1e-9))))


def _mirrored(signal: Signal, n: int, padding: int, begin: int, end: int) -> Array:
    """Some samples of columns that go on beyond their ends as their mirror images, negated."""
    parts = []
    begin, end = begin - padding, end - padding
    if begin < 0:
        edge = _table(signal(slice(0, padding + 1)))
        parts.append((2 * edge[0] - edge[:0:-1])[begin + padding : min(end, 0) + padding])
    if begin < n and end > 0:
        parts.append(_table(signal(slice(max(begin, 0), min(end, n)))))
    if end > n:
        edge = _table(signal(slice(n - padding - 1, n)))
        parts.append((2 * edge[-1] - edge[-2::-1])[max(begin - n, 0) : end - n])
    return np.ascontiguousarray(np.concatenate(parts))


def _table(x: Array) -> Array:
    return x[:, None] if x.ndim == 1 else x


@compiled()
def _filter(sections: Array, s: int) -> tuple[float, float, float, float, float]:
    """The b0, b1, b2, a1 and a2 of a section; those of none pass everything on."""
    if s >= len(sections):
        return 1.0, 0.0, 0.0, 0.0, 0.0
    return sections[s, 0], sections[s, 1], sections[s, 2], sections[s, 4], sections[s, 5]


@compiled()
def _filtered(
    u: float, p: float, q: float, f: tuple[float, float, float, float, float]
) -> tuple[float, float, float]:
    """A sample through a section, and the states that it leaves."""
    y = f[0] * u + p
    return y, f[1] * u - f[3] * y + q, f[2] * u - f[4] * y


@compiled(void(float64[:, ::1], float64[:, ::1], float64[:, :, ::1], boolean))
def _cascade(sections: Array, x: Array, state: Array, backwards: bool) -> None:
    """Columns (n, k) through second-order sections in place (direct form II, transposed).

    Four sections in a row are one loop over the samples of a column; what is missing of four passes
    everything on.

    Args:
        sections: (s, 6).
        x: The columns.
        state: Of the sections, (s, 2, k).
        backwards: Whether the last sample goes first.
    """
    n, k = x.shape
    own = np.zeros((4, 2))
    for first in range(0, len(sections), 4):
        some = state[first : first + 4]
        f0, f1 = _filter(sections, first), _filter(sections, first + 1)
        f2, f3 = _filter(sections, first + 2), _filter(sections, first + 3)
        for j in range(k):
            for s in range(len(some)):
                copy_into(own[s], some[s, :, j])
            (p0, q0), (p1, q1), (p2, q2), (p3, q3) = own[0], own[1], own[2], own[3]
            for m in range(n):
                i = n - 1 - m if backwards else m
                y, p0, q0 = _filtered(x[i, j], p0, q0, f0)
                y, p1, q1 = _filtered(y, p1, q1, f1)
                y, p2, q2 = _filtered(y, p2, q2, f2)
                x[i, j], p3, q3 = _filtered(y, p3, q3, f3)
            own[0, 0], own[1, 0], own[2, 0], own[3, 0] = p0, p1, p2, p3
            own[0, 1], own[1, 1], own[2, 1], own[3, 1] = q0, q1, q2, q3
            for s in range(len(some)):
                copy_into(some[s, :, j], own[s])
