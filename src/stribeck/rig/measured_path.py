"""Friction of a law with states along a motion that was measured.

The states are stepped through the measured path from sample to sample, each at the constant
velocity that makes its way; the friction at a sample is the law's at the velocity there, with its
states as they are.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numba import float64, int64, types
from numpy.typing import NDArray

from ..compile_cache import compiled
from ..friction import LOADS, RUB_TYPE
from ..space import Array

if TYPE_CHECKING:
    from ..friction import Law

_F1 = types.Array(float64, 1, "C", readonly=True)
_F2 = types.Array(float64, 2, "C", readonly=True)
_I1 = types.Array(int64, 1, "C", readonly=True)
#: A slide long enough for any state to be that of sliding: its speed, m/s (rad/s), and time, s.
_CREEP, _LONG = 1e-6, 1e9


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
        p = np.ascontiguousarray(p[: len(law.params)], dtype=float)
        return np.asarray(
            along(law.rub, self.way, self.v, self.dt, self.starts, z, np.zeros(len(LOADS)), p)
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
    p = np.ascontiguousarray(p[: len(law.params)], dtype=float)
    law.rub(way * _CREEP, _LONG, np.zeros(law.states), np.zeros(len(LOADS)), p, out)
    return out


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
            z[:] = first
            k += 1
        else:
            rub(way[i] / dt, dt, z, load, p, out)
            z[:] = out
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
