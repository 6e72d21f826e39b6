"""The delay of the force of a log against its motion, and how well the log shows it.

A coarse search over the length of a stroke (`lag_search`) leads to within a row; from there the
delay is a parameter like any other, whose slope is that of the force over time. The slope that is
measured has noise of its own, so that it is no regressor: what stands in for it in the equations is
the slope of the modelled force, whose noise, the position's, is another one (an instrument). The
delay is where that instrument leaves no step, and not where the sum of squares is least: the noise
of a force that is moved is another one at each lag, and on slow motion that decides which is least.

Rows in which the velocity does not tell the direction are not among those of a balance: at a
reversal friction rises before the axis moves, which reads as a force that is some milliseconds
ahead. What the low pass of the position leaves beside them of the kink in between reads as a force
that is ahead, too, the more so the lower the cut-off: here half a period of it is left out as well.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...data.filtering import kept
from ...data.runs import within
from ...space import Array
from ..uncertainty.covariance import HALF_WIDTH, correlation_time, quick_look
from . import variable_projection
from .lag_evidence import ratios, searched_errors
from .lag_search import LagSums, best_lags, columns, lag_sums
from .modelled_force import force_signal, slope_over_time
from .regression import System, stacked

if TYPE_CHECKING:
    from ...data.derived_channel import SampledChannel
    from .balance import Balance
    from .rows import Log

#: A log is searched to at most this share of its length, whatever its strokes.
_SHARE = 0.25
#: A stroke ends where the axis comes back by this share of the travel, which neither noise nor the
#: steps of a sensor do; samples of a log of which strokes are taken at most.
_BACK, _STROKE_SAMPLES = 0.05, 4000
#: Parts of a log whose delays are compared, and logs from which on each is one part.
_THIRDS, _LOGS = 3, 4
_WHICH = ("first", "second", "last")
#: Minima of the sum of squares that are held against the ranges of the parameters.
_MINIMA = 3
#: The slope of the force is a difference over this share of a row to each side.
_SPAN = 0.25
#: Steps of the refinement end at this share of a row, or after so many.
_FINE, _STEPS = 0.005, 6
#: What a delay moves is a difference over no more than so many rows to each side.
_FAR = 2.0
#: Periods of the cut-off that are left out beside rows of no known direction, unless fewer rows
#: than this share of them are left.
_BESIDE, _REMAINING = 0.5, 0.5


class DelayPart(NamedTuple):
    """A part of the logs whose delay is compared with that of the others.

    label: What it is called.
    log: Which log it is of.
    begin: Its first instant, s.
    end: Its last one.
    """

    label: str
    log: int
    begin: float
    end: float


@dataclass(frozen=True, eq=False)
class ChannelDelay:
    """By how much later than the motion the force of logs was measured.

    Args:
        seconds: The delay of all of it, negative where the force is ahead.
        error: Its standard error.
        parts: That of each part of the logs, (parts,).
        part_errors: Theirs.
        log_parts: The parts.
        reach: How far was searched to each side, s.
        sample: The longest interval between two samples, s.
        slopes: By how much the free parameters move for a second of delay, over the delays that
            its error allows, (free,).
        share: What is left of the residual's sum of squares without the delay.
        unexplained: What is left of the force's, square roots of both.
    """

    seconds: float
    error: float
    parts: Array
    part_errors: Array
    log_parts: tuple[DelayPart, ...]
    reach: float
    sample: float
    slopes: Array
    share: float
    unexplained: float

    @property
    def at_edge(self) -> bool:
        """Whether the search ended at its edge: the delay is this long at least."""
        return abs(self.seconds) > 0.98 * self.reach


def channel_delay(solution: Balance, *, near: bool = False) -> ChannelDelay:
    """The delay that explains solved logs best, with those of their parts.

    Args:
        solution: The balance of the logs.
        near: Only about where they are, not over the length of a stroke.
    """
    balanced, solution = solution, _apart_from_reversals(solution)
    system = solution.system
    row = 1.0 / min(log.row_rate for log in system.logs)
    parts, log_parts = _parts(system)
    reach = _reach(system)
    count = 1 if near else max(int(reach / row), 1)
    lags: Array = row * np.arange(-count, count + 1, dtype=float)
    sums = lag_sums(solution, lags, parts)
    total = sums[0]
    for other in sums[1:]:
        total = total + other
    variance = total.variance()
    least = _feasible(solution, lags, total)
    places = best_lags(sums, least)
    W, rest = columns(solution)
    one = np.zeros_like(parts)
    first = np.array([_vertex(lags, variance, least)])
    whole = _Linearised(solution, W, rest, one, row).refined(first)
    lag = float(whole.lags[0])
    start = np.where(np.abs(lags[places] - lags[least]) <= row, lag, lags[places])
    alike = whole.moved if np.ptp(start) == 0.0 else None
    whole = replace(whole, moved=None)
    apart = _Linearised(solution, W, rest, parts, row).refined(start, alike)
    apart = replace(apart, moved=None)
    del alike
    tiny = float(np.finfo(float).tiny)
    force = system.y - rest
    unmoved = force - W @ variable_projection.least_squares(W, force)
    del force
    share = whole.variance / max(float(unmoved @ unmoved) / len(unmoved), tiny)
    effective = len(unmoved) / correlation_time(unmoved, [len(log.t) for log in system.logs])
    searched = partial(searched_errors, effective=effective, row=row, reach=float(lags[-1]))
    spans = [float(log.clock[-1] - log.clock[0]) for log in system.logs]
    ratio = np.array([1.0 / max(share, tiny)])
    error = float(searched(whole.lags, whole.errors, ratio, span=float(np.mean(spans)))[0])
    error = min(error, max(spans))  # a log shows no more of it than that it lies in the log
    return ChannelDelay(
        seconds=lag,
        error=error,
        parts=apart.lags,
        part_errors=searched(
            apart.lags - lag, apart.errors, ratios(sums, places, least), span=sum(spans)
        ),
        log_parts=log_parts,
        reach=row * max(int(reach / row), 1),
        sample=1.0 / min(log.rate for log in system.logs),
        slopes=_slopes(balanced, lag, float(np.clip(HALF_WIDTH * error, _SPAN * row, _FAR * row))),
        share=share,
        unexplained=float(np.sqrt(whole.variance / max(float(np.mean(system.y**2)), tiny))),
    )


def _apart_from_reversals(solution: Balance) -> Balance:
    """A balance without the rows beside those whose direction is not known.

    As it is where most rows are.
    """
    system = solution.system
    logs = [_wider(log, round(_BESIDE * log.rate / system.filtering.cutoff(log.rate)))
            for log in system.logs]  # fmt: skip
    rows = sum(len(log.t) for log in logs)
    if rows == len(system.y) or rows < _REMAINING * len(system.y):
        return solution
    fewer = System(system.parameters, logs, system.prior)
    return replace(solution, system=fewer, jacobian=fewer.jacobian(solution.values))


def _wider(log: Log, samples: int) -> Log:
    """A log with gaps about its reversals that are longer by so many samples to each side."""
    if not log.unsure.any() or log.unsure.all():
        return log
    unsure = within(log.unsure, samples)
    counts = log.counts & ~unsure[kept(len(log), log.factor)]
    return replace(log, unsure=unsure, counts=counts, t=log.row_clock[counts])


def _parts(system: System) -> tuple[NDArray[np.intp], tuple[DelayPart, ...]]:
    """The part of each row, and the parts: thirds of a log, or logs where there are many."""
    logs = system.logs
    thirds = 1 if len(logs) >= _LOGS else _THIRDS
    numbers, parts = [], []
    for k, log in enumerate(logs):
        begin, span = float(log.clock[0]), float(log.clock[-1] - log.clock[0])
        third = np.minimum(thirds * (log.t - begin) / span, thirds - 1).astype(int)
        numbers.append(thirds * k + third)
        name = "the log" if len(logs) == 1 else log.label
        for i in range(thirds):
            label = log.label if thirds == 1 else f"the {_WHICH[i]} third of {name}"
            ends = (begin + span * share / thirds for share in (i, i + 1))
            parts.append(DelayPart(label, k, *ends))
    present, own = np.unique(np.concatenate(numbers), return_inverse=True)
    return own, tuple(parts[k] for k in present)


def _reach(system: System) -> float:
    """How long a stroke takes, s, the median of all; no longer than a quarter of the logs."""
    strokes, longest = [], 0.0
    for log in system.logs:
        strokes.append(np.diff(_turns(log.clock, log.position)))
        longest = max(longest, float(log.clock[-1] - log.clock[0]))
    lengths = np.concatenate(strokes)
    stroke = float(np.median(lengths)) if len(lengths) else longest
    return min(stroke, _SHARE * longest)


def _turns(t: Array, position: SampledChannel) -> Array:
    """When a motion turns round and comes back by a share of its travel, s."""
    every = -(-len(t) // _STROKE_SAMPLES)
    t, x = t[::every], position[::every]
    back = _BACK * float(np.ptp(x))
    turns, at, way = list[int](), 0, 0
    for i in range(len(x)):
        ahead = x[i] - x[at]
        if way * ahead > 0 or (way == 0 and abs(ahead) > back):
            at, way = i, way or int(np.sign(ahead))
        elif abs(ahead) > back:
            turns.append(at)
            at, way = i, -way
    return t[turns]


def _feasible(solution: Balance, lags: Array, sums: LagSums) -> int:
    """The lag, by its place, that leaves least of all of the force with parameters in their ranges.

    What a lag moves out of the log counts as far as it varies: beyond the only start of a motion
    there is nothing left to explain, which is not to say that a lag so long explains it.
    """
    system, variance, left = solution.system, sums.variance(), sums.left()
    zero = len(lags) // 2
    padded = np.concatenate([[np.inf], variance, [np.inf]])
    is_minimum = (variance <= padded[:-2]) & (variance <= padded[2:]) & np.isfinite(variance)
    minima = np.flatnonzero(is_minimum)
    minima = minima[np.argsort(left[minima], kind="stable")][:_MINIMA]
    if not len(minima) or minima[0] == zero:
        return zero
    within = [
        system.least_squares(force, solution.values) for force in system.at_lags(lags[minima]).T
    ]
    return int(minima[int(np.argmin(within + sums.moved_out[minima]))])


def _vertex(lags: Array, variance: Array, k: int) -> float:
    """Where the parabola through a minimum and its neighbours has its vertex.

    At the minimum itself where it has a neighbour at which too few rows are left.
    """
    if not 0 < k < len(lags) - 1 or not np.isfinite(variance[k - 1 : k + 2]).all():
        return float(lags[k])
    a, b, c = variance[k - 1 : k + 2]
    bend = a - 2 * b + c
    share = float(np.clip(0.5 * (a - c) / bend, -0.5, 0.5)) if bend > 0 else 0.0
    return float(lags[k] + share * (lags[1] - lags[0]))


@dataclass(frozen=True, eq=False)
class _MovedForce:
    """The force at some lags, its slope over time, and that of the modelled one, (rows,) each."""

    force: Array
    slope: Array
    modelled_slope: Array


@dataclass(frozen=True, eq=False)
class _Step:
    """Lags (parts,), what they are too large by, their errors, and what was moved by them.

    `moved` is None where another step has been looked at since: of a long log it is much to keep.
    """

    lags: Array
    change: Array
    errors: Array
    variance: float
    moved: _MovedForce | None


@dataclass(frozen=True, eq=False)
class _Linearised:
    """A balance about lags of the parts of its logs.

    Args:
        solution: The balance.
        W: Its columns, (rows, k).
        rest: The force that these do not explain, (rows,).
        parts: The part of each row.
        row: Time between two rows, s.
    """

    solution: Balance
    W: Array
    rest: Array
    parts: NDArray[np.intp]
    row: float

    def refined(self, lags: Array, alike: _MovedForce | None = None) -> _Step:
        """The lags at which the instrument leaves no step, from lags within some rows of them.

        Args:
            lags: Where it begins, of the parts, (parts,).
            alike: What these lags move, where that is known.
        """
        best = self.stepped(lags, alike)
        for _ in range(_STEPS):
            if np.abs(best.change).max() < _FINE * self.row:
                break
            best = replace(best, moved=None)
            step = self.stepped(best.lags - np.clip(best.change, -self.row, self.row))
            if not np.abs(step.change).max() < np.abs(best.change).max():
                break
            best = step
        return best

    def stepped(self, lags: Array, alike: _MovedForce | None = None) -> _Step:
        """The step from lags of the parts, (parts,); what they move, where that is known."""
        from scipy.linalg import qr  # noqa: PLC0415 - slow to import

        system, W, parts = self.solution.system, self.W, self.parts
        inside = _inside(system, parts, lags)
        if alike is None:
            force, slope = _moved(system, parts, lags, _SPAN * self.row)
            instrument: Array = _modelled_slope(self.solution, np.where(inside, force, system.y))
        else:
            force, slope, instrument = alike.force, alike.slope, alike.modelled_slope
        (rows, k), count = W.shape, len(lags)
        J, gain = np.empty((k + count, rows)), np.empty((count, count))
        Z = J[k:]
        basis: Array = J[:k].T  # the columns themselves take its place at the end
        np.multiply(W, inside[:, None], out=basis)
        in_place = qr(basis, overwrite_a=True, mode="economic", check_finite=False)[0]
        basis = np.asarray(in_place, dtype=np.float64)
        r = _beside(basis, np.where(inside, force - self.rest, 0.0))
        for z, part in zip(Z, range(count), strict=True):
            z[:] = _beside(basis, np.where((parts == part) & inside, instrument, 0.0))
        for part in range(count):
            gain[:, part] = Z @ _beside(basis, np.where((parts == part) & inside, slope, 0.0))
        del basis
        np.multiply(W.T, inside, out=J[:k])
        change = np.linalg.lstsq(gain, Z @ r, rcond=None)[0]
        look = quick_look(J, r, [len(log.t) for log in system.logs])
        tiny, eps = np.finfo(float).tiny, np.finfo(float).eps
        strength = np.abs(np.diag(gain)) / np.maximum(np.einsum("jm,jm->j", Z, Z), tiny)
        errors = look.errors[-count:] / np.clip(strength, eps, 1.0)
        variance = float(r @ r) / max(int(inside.sum()), 1)
        return _Step(
            lags, np.asarray(change), errors, variance, _MovedForce(force, slope, instrument)
        )


def _moved(
    system: System, parts: NDArray[np.intp], lags: Array, span: float
) -> tuple[Array, Array]:
    """The force of each part, measured later by its lag, and its slope over a span, (rows,)."""
    distinct, which = np.unique(lags, return_inverse=True)
    rows, column = np.arange(len(parts)), which[parts]

    def force(at: Array) -> Array:
        return np.asarray(system.at_lags(at)[rows, column])

    slope = force(distinct + span)
    slope -= force(distinct - span)
    slope /= 2 * span
    return force(distinct), slope


def _inside(system: System, parts: NDArray[np.intp], lags: Array) -> NDArray[np.bool_]:
    """Rows whose force lies within their log once it is moved."""
    t = np.concatenate([log.t for log in system.logs]) + lags[parts]
    first, last = (
        np.concatenate([np.full(len(log.t), log.clock[end]) for log in system.logs])
        for end in (0, -1)
    )
    return np.asarray((t >= first) & (t <= last))


def _beside(basis: Array, y: Array) -> Array:
    """What orthonormal columns leave of a vector."""
    return np.asarray(y - basis @ (basis.T @ y))


def _modelled_slope(solution: Balance, force: Array) -> Array:
    """The slope over time of the force that the model explains, (rows,)."""
    system, p = solution.system, solution.values.copy()
    linear = [k for k, i in enumerate(system.free) if i in system.linear]
    J = solution.jacobian
    W = J if len(linear) == J.shape[1] else J[:, linear]
    p[system.linear] = 0.0
    without = system.predicted(p[None])[:, 0]
    force = force - without
    if len(system.prior):
        W, force = np.vstack([W, system.prior]), np.append(force, np.zeros(len(system.prior)))
    p[[system.free[k] for k in linear]] = variable_projection.least_squares(W, force)
    del J, W, force
    models = [force_signal(system.rig, system.law, log, p) for log in system.logs]
    return stacked([
        log.thin(partial(slope_over_time, log, model))
        for log, model in zip(system.logs, models, strict=True)
    ])  # fmt: skip


def _slopes(solution: Balance, lag: float, reach: float) -> Array:
    """By how much the free parameters move for a second of delay, about a lag, (free,).

    A difference and no derivative: a force that is late by more than a reversal is blurred brings
    what acted during it into the rows after it, which no slope at one lag tells.
    """
    before, after = solution.system.at_lags(np.array([lag - reach, lag + reach])).T
    force_slope: Array = (after - before) / (2.0 * reach)
    seen = np.isfinite(np.diag(solution.covariance))
    slopes = np.zeros(len(solution.system.free))
    W, prior = solution.jacobian, solution.system.free_prior
    W = W if seen.all() else W[:, seen]
    if len(prior):
        W = np.vstack([W, prior[:, seen]])
        force_slope = np.append(force_slope, np.zeros(len(prior)))
    slopes[seen] = variable_projection.least_squares(W, force_slope)
    return slopes
