"""A first-order filter on one channel of a balance, which is no pure delay.

Slow motion is late by the filter's time constant, and fast motion by less, and smaller. A filter on
the force is one on the model's side; one on the position is undone there: the axis itself was at
x + T dx/dt, so that noise of the position, which that makes larger, speaks against it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from ...data.derived_channel import Slope
from ...data.filtering import bridged, decimate, kept
from ...data.resampling import interpolated
from ...data.runs import slices, within
from ...data.zero_phase import BLOCK
from ...space import Array
from . import variable_projection

if TYPE_CHECKING:
    from .balance import Balance
    from .regression import System
    from .rows import Log

#: Time constants that are tried, as shares of the delay; then about the best, by these factors.
_SHARES, _FINER = (0.5, 0.7, 1.0, 1.4, 2.0, 2.8, 4.0), (0.84, 0.92, 1.09, 1.19)
#: A filter is told in place of a delay if it leaves this share of what the delay leaves, or less;
#: a delay is one for sure if the filter leaves this many times as much.
CLEARLY, SURELY = 0.8, 1.15


@dataclass(frozen=True, eq=False)
class ChannelFilter:
    """A first-order low pass on one channel.

    Args:
        channel: Which.
        seconds: Its time constant.
        ratio: What it leaves of the force as a share of what a delay does, mean squares.
        moves: By how much its estimates of the linear parameters lie above those of the delay.
    """

    channel: Literal["force", "position"]
    seconds: float
    ratio: float
    moves: Array


def channel_filter(solution: Balance, delay: float) -> ChannelFilter:
    """The filter that explains solved logs best, beside a delay.

    Args:
        solution: The logs as they were recorded.
        delay: The delay of the force that explains them best, s.
    """
    channel: Literal["force", "position"] = "force" if delay > 0 else "position"
    logs = solution.system.logs
    moved = [interpolated(log.clock + delay, log.clock, log.raw) for log in logs]
    beside = partial(_beside, solution, channel, delay=delay, moved=moved)
    best = min((beside(share * abs(delay)) for share in _SHARES), key=_ratio)
    return min([best, *(beside(share * best.seconds) for share in _FINER)], key=_ratio)


def _ratio(f: ChannelFilter) -> float:
    return f.ratio


def _beside(
    solution: Balance,
    channel: Literal["force", "position"],
    seconds: float,
    *,
    delay: float,
    moved: Sequence[Array],
) -> ChannelFilter:
    """A filter beside a delay, both seen through a low pass of the same time constant.

    Args:
        solution: The logs as they were recorded.
        channel: The one that is filtered.
        seconds: The time constant.
        delay: Of the force.
        moved: The forces of the logs without it.
    """
    system = solution.system
    sets = np.tile(solution.values, (len(system.linear) + 1, 1))
    sets[:, system.linear] = 0.0
    sets[1 + np.arange(len(system.linear)), system.linear] = 1.0

    filtered: list[Array] = []
    delayed: list[Array] = []
    for log, advanced in zip(system.logs, moved, strict=True):
        v, a = log.v[:], log.a[:]
        if channel == "position":
            v = v + seconds * a
            a = a + seconds * Slope(a, log.rate)[:]
        turns = np.flatnonzero(np.diff(np.sign(v)) != 0)
        apart = np.zeros(len(v), dtype=bool)
        apart[turns] = apart[turns + 1] = True
        gaps = log.unsure | within(apart, log.blur)
        rows = log.counts & ~gaps[kept(len(v), log.factor)]
        rows &= (log.row_clock + delay >= log.clock[0]) & (log.row_clock + delay <= log.clock[-1])
        smooth = _Runs(gaps, seconds * log.rate)
        force = smooth.fallen(log.raw) if channel == "force" else smooth.low(log.raw)

        def thin(x: Array, log: Log = log, gaps: NDArray[np.bool_] = gaps) -> Array:
            return decimate(bridged(x, gaps), log.factor)

        def modelled(v: Array, a: Array, log: Log = log, smooth: _Runs = smooth) -> list[Array]:
            return [thin(smooth.low(_model(system, log, row, v, a))) for row in sets]

        own = modelled(v, a)
        alike = own if channel == "force" else modelled(log.v[:], log.a[:])
        filtered.append(np.column_stack([*own, thin(force)])[rows])
        delayed.append(np.column_stack([*alike, thin(smooth.low(advanced))])[rows])
    (left, x), (left_of_delay, x_of_delay) = map(_solved, (filtered, delayed))
    ratio = left / max(left_of_delay, np.finfo(float).tiny)
    return ChannelFilter(channel, seconds, ratio, x - x_of_delay)


def _model(system: System, log: Log, p: Array, v: Array, a: Array) -> Array:
    """The force of a model over a motion at full rate, (N,)."""
    force = np.empty(len(log))
    for k in range(0, len(log), BLOCK):
        at = slice(k, min(k + BLOCK, len(log)))
        force[at] = system.rig.force(system.law, p, v[at], a[at], log.motion(at).loads)
        force[at] += log.known_at(at)
    return force


class _Runs:
    """A first-order low pass that starts at zero after every gap.

    Args:
        gaps: Samples that it does not see, (N,).
        samples: Its time constant.
    """

    def __init__(self, gaps: NDArray[np.bool_], samples: float) -> None:
        self._runs = slices(~gaps)
        self._keep = float(np.exp(-1.0 / samples))

    def low(self, x: Array) -> Array:
        """Columns (N, ...) through it; 0 in gaps."""
        from scipy.signal import lfilter  # noqa: PLC0415 - slow to import

        result = np.zeros_like(x)
        for run in self._runs:
            result[run] = lfilter([1.0 - self._keep], [1.0, -self._keep], x[run], axis=0)
        return result

    def fallen(self, x: Array) -> Array:
        """What came out of it, (N,), less what it remembers of before each run; 0 in gaps."""
        result = np.zeros_like(x)
        for run in self._runs:
            fading = self._keep ** np.arange(run.stop - run.start)
            result[run] = x[run] - x[run.start] * fading
        return result


def _solved(tables: list[Array]) -> tuple[float, Array]:
    """Sum of squares that columns leave of the last, and what they are multiplied by.

    The first is no column: it is taken off the others and the last.
    """
    table = np.concatenate(tables)
    W, y = table[:, 1:-1] - table[:, :1], table[:, -1] - table[:, 0]
    lengths = np.linalg.norm(W, axis=0)
    lengths[lengths == 0] = 1.0
    R = variable_projection.triangle(np.column_stack([W / lengths, y]))
    x = np.linalg.lstsq(R[:-1, :-1], R[:-1, -1], rcond=None)[0] / lengths
    return float(R[-1, -1] ** 2), x
