"""Friction of a law with states along a motion that was measured.

The states are stepped through the measured path from sample to sample, each at the constant
velocity that makes its way, or in parts along a monotone cubic where the speed changes within it;
the friction at a sample is the law's at the velocity there, with its states as they are.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numba import float64, int64, types
from numpy.typing import NDArray

from ..compile_cache import compiled
from ..compile_cache.copies import copy_into
from ..friction import LOADS, RUB_SIGNATURE, RUB_TYPE, addressed
from ..space import Array, contiguous

if TYPE_CHECKING:
    from ..friction import Law

_F1 = types.Array(float64, 1, "C", readonly=True)
_I1 = types.Array(int64, 1, "C", readonly=True)
#: A slide long enough for any state to be that of sliding: its speed, m/s (rad/s), and time, s.
_CREEP, _LONG = 1e-6, 1e9
#: A span at whose ends the speed differs by more than this share from its mean is passed in so many
#: parts.
_EVEN, _PARTS = 0.05, 4


@dataclass(frozen=True, eq=False)
class MeasuredPath:
    """A measured motion on an even grid, as it drives the states of a law.

    Args:
        way: From the sample before, m (rad), (N,).
        v: Velocity at the samples, m/s (rad/s), (N,).
        dt: Interval, s.
        starts: Samples at which nothing is known of what was before, the first one included.
        error: By which positions may be off, m (rad): reversals within twice that are none.
    """

    way: Array
    v: Array
    dt: float
    starts: NDArray[np.int64]
    error: float

    @property
    def heading(self) -> Array:
        """Which way the axis went last, -1 or 1 at each sample, (N,)."""
        moves = np.flatnonzero(self.way)
        if not len(moves):
            return np.ones(len(self.way))
        last = np.searchsorted(moves, np.arange(len(self.way)), side="right") - 1
        return np.asarray(np.sign(self.way[moves[np.maximum(last, 0)]]))

    @property
    def reverses(self) -> bool:
        """Whether the axis goes both ways."""
        return bool((self.way > 0).any() and (self.way < 0).any())

    def friction(self, law: Law, p: Array, first: Array | None = None) -> Array:
        """Friction along it, N (N m), (N,), without a law's terms.

        Args:
            law: With states.
            p: Its parameters, (k,).
            first: States at the starts, (states,); relaxed by default.
        """
        z = np.zeros(law.states) if first is None else first
        p = contiguous(p[: len(law.params)])
        rub, load = addressed(law.rub, RUB_SIGNATURE), np.zeros(len(LOADS))
        return np.asarray(along(rub, self.way, self.v, self.dt, self.starts, z, load, p))

    def thinned(self) -> MeasuredPath:
        """The same path by every other sample, from the first on."""
        total = np.concatenate([[0.0], np.cumsum(self.way[1:])])[::2]
        return MeasuredPath(
            np.diff(total, prepend=total[:1]),
            np.ascontiguousarray(self.v[::2]),
            2.0 * self.dt,
            np.unique(self.starts // 2),
            self.error,
        )

    def memory(self, law: Law, p: Array) -> Array:
        """By how much friction depends on what was before the starts, N (N m), (N,).

        The difference between an axis that came from the one side and one that came from the other.
        """
        ends = [self.friction(law, p, slid(law, p, way)) for way in (1.0, -1.0)]
        return np.asarray(np.abs(ends[0] - ends[1]))


def slid(law: Law, p: Array, way: float) -> Array:
    """The states of a law after a long slow slide one way (the sign of `way`), (states,)."""
    out = np.zeros(law.states)
    p = contiguous(p[: len(law.params)])
    law.rub(way * _CREEP, _LONG, np.zeros(law.states), np.zeros(len(LOADS)), p, out)
    return out


@compiled(forceinline=True)
def _speed_between(before: float, after: float) -> float:
    """Way in a span at its border with the next, of the ways in both: 0 where they differ in sign.

    The slope of a piecewise cubic that rises where its points rise (Fritsch and Butland 1984, doi
    10.1137/0905021).
    """
    return 2.0 * before * after / (before + after) if before * after > 0.0 else 0.0


@compiled(float64[::1](RUB_TYPE, _F1, _F1, float64, _I1, _F1, _F1, _F1))
def along(
    rub: Any, way: Array, v: Array, dt: float, starts: Array, first: Array, load: Array, p: Array
) -> Array:
    """Friction at the samples of a path; see `MeasuredPath`."""
    n = len(way)
    friction = np.empty(n)
    z = first.copy()
    out = first.copy()
    k = 0
    for i in range(n):
        if k < len(starts) and i == starts[k]:
            copy_into(z, first)
            k += 1
        else:
            begin = _speed_between(way[i - 1], way[i]) if i > 1 else way[i]
            end = _speed_between(way[i], way[i + 1]) if i + 1 < n else way[i]
            if abs(begin - way[i]) + abs(end - way[i]) <= _EVEN * abs(way[i]):
                rub(way[i] / dt, dt, z, load, p, out)
                copy_into(z, out)
            else:
                passed = 0.0
                for part in range(1, _PARTS + 1):
                    s = part / _PARTS
                    to = s * (1.0 - s) * ((1.0 - s) * begin - s * end)
                    to += s * s * (3.0 - 2.0 * s) * way[i]
                    rub((to - passed) * _PARTS / dt, dt / _PARTS, z, load, p, out)
                    copy_into(z, out)
                    passed = to
        friction[i] = rub(v[i], 0.0, z, load, p, out)
    return friction


@compiled(float64[:, ::1](_F1, _I1, _F1))
def elements_along(way: Array, starts: Array, yields: Array) -> Array:
    """Maxwell elements at unit level along a path, (N, m): see `friction.maxwell`.

    Args:
        way: From the sample before, (N,).
        starts: Samples at which they are relaxed.
        yields: Displacements at which they slip, (m,).
    """
    n, m = len(way), len(yields)
    shares = np.zeros((n, m))
    k = 0
    for i in range(n):
        if k < len(starts) and i == starts[k]:
            k += 1
            continue
        for j in range(m):
            shares[i, j] = min(max(shares[i - 1, j] + way[i] / yields[j], -1.0), 1.0)
    return shares
