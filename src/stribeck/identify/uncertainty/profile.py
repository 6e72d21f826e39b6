"""Profile likelihood: how far each parameter can go, the others refitted, before the fit suffers.

From the best fit a parameter is moved outward in its search scale, and all others are refitted at
each place, until the sum of squares has risen by what noise explains: s^2 F(1, N - k), times the
parameter's own ratio for residuals that correlate (see `covariance`). Venzon and Moolgavkar 1988,
doi 10.2307/2347496; for practical identifiability, Raue et al. 2009, doi
10.1093/bioinformatics/btp358.

A misfit of stick-slip has walls and several basins. So strides are as long as the refit can
follow; where a walk finds a better fit than the best, all start again from there; and an interval
holds whatever point any walk has met that fits as well.
"""

from __future__ import annotations

from collections.abc import Generator, Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from scipy.special import fdtri

from ...errors import InputError
from ...space import Array
from .covariance import QuickLook, quick_look
from .descent import (
    Asking,
    Meter,
    Place,
    Terrain,
    ahead,
    masked,
    settle,
    slopes,
    squares_of,
    together,
)
from .residuals import Residuals, logs_of, physical

Ended = Literal["threshold", "bound", "order", "flat", "unrunnable", "budget"]

LEVEL = 0.95
#: Rows that profiles may evaluate unless told otherwise.
BUDGET = 20_000
#: An end is known to this share of the half-width.
SHARP = 0.02
#: A refit is over where no step promises more than this share of the threshold; the last one of
#: a side, this; that of the best fit, from which all is counted, this.
ROUGH, FINE, FINEST = 0.05, 0.004, 1e-6
#: A side that rises by less than this share of the threshold up to the end of its range is flat,
#: if it is longer than this share of the range.
FLAT, LONG = 0.05, 0.25
#: Below this height the end is still far, and the refit need not be fine.
ROUGHLY = 0.85
#: A stride that ends higher than this (root of the rise over the threshold) is tried shorter.
STEEP = 1.6
#: A guess that is higher than this is tried with a shorter stride, unless it is a stride shorter
#: than this share of the way.
FAR, NEAR = 5.0, 0.1
#: A fit better by this share of the least threshold is a new best; how often that may happen.
BETTER, RESTARTS = 0.02, 8
#: Places that a side looks at before it is given up as if the budget were spent.
MOST = 60
#: How often intervals are carried on from places that other walks have met.
ROUNDS = 2
#: Memory for slopes, bytes: so many sides walk at once.
MEMORY = 4e8


@dataclass(frozen=True, eq=False)
class Side:
    """One end of an interval.

    Args:
        end: Where it is, SI.
        ended: Why there: `threshold` (the fit suffers), `bound` (end of the search range),
            `order` (the law allows no further), `flat` (end of the range, and the fit has hardly
            changed), `unrunnable` (no simulation beyond), `budget` (no evaluations left: the
            end is extrapolated).
        rise: Of the sum of squares there, in thresholds.
    """

    end: float
    ended: Ended
    rise: float

    @property
    def closed(self) -> bool:
        """Whether the data, or the law, end the interval there rather than the range."""
        return self.ended in ("threshold", "order", "unrunnable")


@dataclass(frozen=True, eq=False)
class Profile:
    """What the data say of one parameter.

    Args:
        name: The parameter.
        value: The best fit's, SI.
        low: The lower end.
        high: The upper end.
        values: Places visited, rising, SI, (m,).
        rises: The sum of squares there, others refitted, less the least one, over the threshold.
        places: All parameters there, SI, (m, dim).
        threshold: Rise of the sum of squares that ends the interval.
    """

    name: str
    value: float
    low: Side
    high: Side
    values: Array = field(repr=False)
    rises: Array = field(repr=False)
    places: Array = field(repr=False)
    threshold: float


@dataclass(frozen=True, eq=False)
class Profiles:
    """The profiles of all free parameters, and the fit that they rest on.

    Args:
        x: The best fit, SI, (dim,): the one given, or a better one that was met on the way.
        squares: Its sum of squares.
        before: That of the fit given.
        improved: How often a walk met a better fit.
        profiles: In the order of the space.
        look: The quick look at x.
        J: Slopes of the residuals at x over the unit cube, (dim, N).
        residuals: At x, (N,).
        logs: Rows of each log.
        rows: Rows evaluated.
        complete: Whether the budget sufficed.
    """

    x: Array
    squares: float
    before: float
    improved: int
    profiles: tuple[Profile, ...]
    look: QuickLook
    J: Array = field(repr=False)
    residuals: Array = field(repr=False)
    logs: tuple[int, ...] = field(repr=False)
    rows: int
    complete: bool


class _Walk:
    """One side of one profile: walks outward from a place, and keeps its record.

    Distances t are from the best fit, outward, in the unit cube; heights z are roots of the rise
    over the threshold, which grow evenly where the problem is near to linear.
    """

    def __init__(
        self, terrain: Terrain, problem: Residuals, best: Place, k: int, sign: int,
        threshold: float, reach: float,
    ) -> None:  # fmt: skip
        self.terrain, self.problem, self.k, self.sign = terrain, problem, k, sign
        self.base, self.threshold, self.reach = best.squares, threshold, reach
        self.origin = float(best.u[k])
        limit, ordered = terrain.limit(k, sign)
        self.room = max(sign * (limit - self.origin), 0.0)
        self.limited: Ended = "order" if ordered else "bound"
        self.known: list[tuple[float, float, Array]] = [(0.0, 0.0, best.u.copy())]
        self.end, self.z = 0.0, 0.0
        self.ended: Ended = "budget"
        self._stand(best)

    def _stand(self, place: Place) -> None:
        """Start out from a place."""
        self._place = place
        self._t = max(self.sign * (float(place.u[self.k]) - self.origin), 0.0)
        self._z = self._height(place.squares)
        self._outer: tuple[float, float] | None = None
        self._stride = np.inf
        self._blocked: Ended = "threshold"

    def _height(self, squares: float) -> float:
        with np.errstate(over="ignore"):  # beside a model that leaves nothing, all is infinite
            return float(np.sqrt(max(squares - self.base, 0.0) / self.threshold))

    def walk(self, start: Place) -> Asking:
        """Go outward from a place until the side is known."""
        self._stand(start.copy())
        if self._t > 0:
            self.known.append((self._t, self._z, start.u.copy()))
        for _ in range(MOST):
            if self._over():
                break
            goal = self._goal()
            trial = yield from self._tried(goal)
            if trial is not None:
                self._take(goal, trial)

    def _over(self) -> bool:
        """Whether the side is known; whatever is known of it is put down."""
        t, z, outer = self._t, self._z, self._outer
        if abs(z - 1) <= SHARP:
            return self._put("threshold", self._crossing(), 1.0)
        if outer is not None and min(outer[0] - t, self._stride) <= SHARP * outer[0]:
            share = (1 - z) / (outer[1] - z) if outer[1] > z else 0.0
            return self._put("threshold", t + min(max(share, 0.0), 1.0) * (outer[0] - t), 1.0)
        if outer is None and t >= self.room * (1 - 1e-12):
            flat = z * z < FLAT and t > LONG
            return self._put("flat" if flat else self.limited, self.room, z)
        if outer is None and self._stride < SHARP * max(t, SHARP * self.reach, 1e-9):
            return self._put(self._blocked, t, z)  # a wall
        guess = max(t / z if z > 0.2 else t, self.reach)  # noqa: PLR2004 - too low to tell
        self._put("budget", guess, z)  # unless there is a next step
        return False

    def _put(self, ended: Ended, t: float, z: float) -> bool:
        self.ended, self.end, self.z = ended, min(max(t, 0.0), self.room), z
        return True

    def _tried(self, goal: float) -> Generator[Array, Array, Place | None]:
        """The refit at a distance; None if it has to be tried nearer."""
        k, step = self.k, goal - self._t
        there, _ = ahead(self._place, self.terrain, k, self.sign * step)
        R = (yield there[None])[0]
        if not np.isfinite(R).all():
            good = physical(self.problem, self.terrain.x(there)[None])[0]
            self._blocked, self._stride = ("unrunnable" if good else "order"), step / 3
            return None
        trial = self._place.copy()
        trial.move(there, R)
        height, free = self._height(trial.squares), masked(self.terrain.dim, k)
        if height > FAR and step > NEAR * max(goal, self.reach):
            # the straight guess errs by the square of the step, and so does its height
            self._blocked, self._stride = "threshold", step * max(np.sqrt(2 / height), 0.1)
            return None
        most = 4 * self.terrain.dim + 12
        yield from settle(trial, self.terrain, free, ROUGH * self.threshold, most, sure=False)
        if self._height(trial.squares) > ROUGHLY:
            yield from settle(trial, self.terrain, free, FINE * self.threshold, most)
        height = self._height(trial.squares)
        if height > STEEP and step > SHARP * goal:
            self._blocked, self._stride = "threshold", step / 3
            return None
        return trial

    def _take(self, goal: float, trial: Place) -> None:
        """Keep a refit: as the next place to go on from, or as one that is too far."""
        height = self._height(trial.squares)
        self.known.append((goal, height, trial.u.copy()))
        if height > 1 + SHARP:
            self._outer = goal, height
            return
        if self._stride < np.inf:
            self._stride = max(self._stride, 3 * (goal - self._t))
        self._place, self._t, self._z = trial, goal, height

    def _goal(self) -> float:
        """The distance to look at next."""
        t, z = self._t, self._z
        if self._outer is not None:
            far, high = self._outer
            share = (1 - z) / (high - z) if high > z else 0.5
            return t + min(max(share, 0.1), 0.9) * min(far - t, self._stride)
        slope = 1.0 / self.reach
        if t > 0:
            before, low = self._before(t)
            slope = (z - low) / (t - before)
        ask = t + (1.0 - z) / slope if slope > 0 else self.room
        ask = min(ask, t + self._stride, max(2.5 * t, t + self.reach), self.room)
        if self.room - ask < 0.05 * (ask - t) and self.room - t <= self._stride:
            return self.room
        return ask

    def _crossing(self) -> float:
        """Where z passes 1, by the slope to the place before."""
        before, low = self._before(self._t)
        if not self._z > low:
            return self._t
        return self._t + (1 - self._z) * (self._t - before) / (self._z - low)

    def _before(self, t: float) -> tuple[float, float]:
        """The place before one on the way out, and its height."""
        return max(((at, z) for at, z, _ in self.known if at < t), default=(0.0, 0.0))

    def beyond(self, seen: Sequence[tuple[Array, float]]) -> Array | None:
        """The outermost point met by others that fits as well and lies beyond the end."""
        if self.ended in ("bound", "order", "flat", "budget"):
            return None
        fitting = [u for u, s in seen if s - self.base < (1 - SHARP) * self.threshold]
        out = [self.sign * (float(u[self.k]) - self.origin) for u in fitting]
        if not out or max(out) <= self.end * (1 + 2 * SHARP) + 1e-9:
            return None
        return fitting[int(np.argmax(out))]


def profiles(
    problem: Residuals,
    x: Array,
    *,
    level: float = LEVEL,
    ratio: Array | None = None,
    budget: int = BUDGET,
    which: Sequence[str] | None = None,
    keep: bool = False,
) -> Profiles:
    """The profile likelihood of each parameter at a fit.

    Args:
        problem: Its residuals; see `Residuals`.
        x: The fit, SI, (dim,).
        level: Of the intervals.
        ratio: Variance of each estimate over that with white residuals, (dim,); by default
            from the residuals themselves. Ones for residuals known to be white.
        budget: Rows that may be evaluated.
        which: Names of the parameters to profile; all by default.
        keep: Whether the fit stays as it is, whatever better one is met.

    Raises:
        InputError: the fit cannot be run, has no more rows than parameters, or a name is unknown.
    """
    meter, terrain = Meter(problem, budget), Terrain(problem)
    chosen = _chosen(terrain, which)
    best = start(meter, terrain, x)
    logs, before, improved = logs_of(problem, len(best.r)), best.squares, 0
    while True:
        rough = _thresholds(best, quick_look(best.J, best.r, logs), level, ratio)
        if not keep:
            together([_refined(best, terrain, FINEST * float(rough.min()))], meter)
        look = quick_look(best.J, best.r, logs)
        thresholds = _thresholds(best, look, level, ratio)
        walks = [
            _Walk(terrain, problem, best, k, sign, thresholds[k], _reach(look, thresholds[k], k))
            for k in chosen
            for sign in (-1, 1)
        ]
        better = -np.inf if keep else best.squares - BETTER * float(thresholds.min())
        met = _walked(walks, best, meter, terrain, better, float(thresholds.max()))
        if met is None or improved >= RESTARTS or meter.left < 4 * terrain.dim:
            break
        improved += 1
        best = start(meter, terrain, terrain.x(met))
    found = tuple(
        _profile(terrain, best, low, high)
        for low, high in zip(walks[::2], walks[1::2], strict=True)
    )
    return Profiles(
        terrain.x(best.u),
        best.squares,
        before,
        improved,
        found,
        look,
        best.J,
        best.r,
        logs,
        meter.rows,
        all(s.ended != "budget" for p in found for s in (p.low, p.high)),
    )


def start(meter: Meter, terrain: Terrain, x: Array) -> Place:
    """A fit with its slopes.

    Raises:
        InputError: it cannot be run there, or there are too few rows or evaluations.
    """
    u = terrain.orderly(terrain.u(np.asarray(x, dtype=float)))
    r = meter(u[None])[0]
    if not np.isfinite(r).all():
        raise InputError("the fit cannot be run at its own parameters: fit again before this")
    if len(r) <= terrain.dim:
        raise InputError(f"{len(r)} rows cannot tell {terrain.dim} parameters: give more data")
    place = Place(u, r, np.zeros((terrain.dim, len(r))), float(squares_of(r[None])[0]), 1)
    if meter.left < 2 * terrain.dim:
        raise InputError(f"a budget of {meter.budget} rows is too small to take slopes: raise it")
    together([slopes(place, terrain)], meter)
    return place


def _chosen(terrain: Terrain, which: Sequence[str] | None) -> list[int]:
    names = terrain.space.names
    if strange := [n for n in which or () if n not in names]:
        raise InputError(f"no free parameter {strange[0]!r}: there are {', '.join(names)}")
    return [i for i, n in enumerate(names) if which is None or n in which]


def _refined(place: Place, terrain: Terrain, gain: float) -> Asking:
    yield from settle(place, terrain, range(terrain.dim), gain, 40 * (terrain.dim + 1))


def _thresholds(best: Place, look: QuickLook, level: float, ratio: Array | None) -> Array:
    """By how much the sum of squares may rise, (dim,)."""
    quantile = float(fdtri(1, look.dof, level))
    ratios = look.ratio if ratio is None else np.asarray(ratio, dtype=float)
    # A fit without misfit is known as well as finite differences are.
    least = (1e-8 * np.abs(best.J).max(initial=0.0)) ** 2 + np.finfo(float).tiny
    found: Array = max(look.variance, float(least)) * quantile * ratios
    return found


def _reach(look: QuickLook, threshold: float, k: int) -> float:
    """Half-width of the interval to first order, at most the range."""
    if look.blind[k]:
        return 1.0
    return float(np.clip(np.sqrt(threshold * look.curvature[k, k]), 1e-12, 1.0))


def _walked(
    walks: Sequence[_Walk],
    best: Place,
    meter: Meter,
    terrain: Terrain,
    better: float,
    widest: float,
) -> Array | None:
    """Let all sides walk; the point of a better fit, if one was met."""
    keep = best.squares + widest

    def met() -> bool:
        meter.forget(keep)
        return any(s < better for _, s in meter.seen)

    todo = [(walk, best) for walk in walks]
    most = max(int(MEMORY / (8 * best.J.size)), 1)
    for _ in range(1 + ROUNDS):
        for first in range(0, len(todo), most):
            together([w.walk(p) for w, p in todo[first : first + most]], meter, met)
            if met():
                return min(meter.seen, key=lambda seen: seen[1])[0]
        todo = []
        for walk in walks:
            if (beyond := walk.beyond(meter.seen)) is not None and meter.left > 2 * terrain.dim:
                todo.append((walk, start(meter, terrain, terrain.x(beyond))))
        if not todo:
            break
    return None


def _profile(terrain: Terrain, best: Place, low: _Walk, high: _Walk) -> Profile:
    k = low.k
    name = terrain.space.names[k]

    def x(t: float) -> float:
        u = best.u.copy()
        u[k] = min(max(u[k] + t, 0.0), 1.0)
        return float(terrain.x(u)[k])

    known = [(-t, z, u) for t, z, u in low.known[1:]] + high.known
    known.sort(key=lambda place: place[:2])
    return Profile(
        name,
        x(0.0),
        Side(x(-low.end), low.ended, low.z**2),
        Side(x(high.end), high.ended, high.z**2),
        np.array([x(t) for t, _, _ in known]),
        np.array([z * z for _, z, _ in known]),
        terrain.space.decode(np.array([u for _, _, u in known])),
        low.threshold,
    )
