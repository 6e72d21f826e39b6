"""One side of a profile: outward from the best fit, the other parameters refitted at each place.

Distances t are from the best fit, outward, in the unit cube; heights z are roots of the rise of
the sum of squares over the threshold, which grow evenly where the problem is near to linear.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, NamedTuple

import numpy as np

from ...optimize.box import Box
from ...optimize.moves import Answer, Detailed, Moves, SpentError, counted
from ...optimize.trust_region import Iterate, minimise, with_slopes
from ...space import Array
from .linearisation import compensated, others, predicted
from .residuals import Residuals, physical

Ended = Literal["threshold", "bound", "order", "flat", "unrunnable", "budget"]

#: An end is known to this share of the half-width.
SHARP = 0.02
#: The shortest way in the unit cube that is looked along.
TINIEST = 1e-20
#: A refit is over where no step promises more than this share of the threshold; the last one of
#: a side, this.
ROUGH, FINE = 0.05, 0.004
#: A side that rises by less than this share of the threshold up to the end of its range is flat,
#: if it is longer than this share of the range.
FLAT, LONG = 0.05, 0.25
#: Below this height the end is still far, and the refit need not be fine; below this one it is
#: too low to tell the slope.
ROUGHLY, LOW = 0.85, 0.2
#: A stride that ends higher than this (root of the rise over the threshold) is tried shorter.
STEEP = 1.6
#: A guess that is higher than this is tried with a shorter stride, unless it is a stride shorter
#: than this share of the way.
FAR, NEAR = 5.0, 0.1
#: Places that a side looks at before it is given up as if the budget were spent.
MOST = 60


class Visited(NamedTuple):
    """A place that a walk has refitted at: its distance, its height, its point, (dim,)."""

    t: float
    z: float
    u: Array


class Standing(NamedTuple):
    """Where a walk stands.

    Args:
        place: The refit that it goes on from.
        t: Its distance.
        z: Its height.
        outer: Distance and height of the nearest place known to be too far, if any.
        stride: The longest that may be tried next.
        blocked: Why the last stride was too long.
    """

    place: Iterate
    t: float
    z: float
    outer: tuple[float, float] | None = None
    stride: float = np.inf
    blocked: Ended = "threshold"


class Walked(NamedTuple):
    """What is known of a ray.

    Args:
        t: Distance of its end.
        z: Height there.
        ended: Why it ends there, see `profile.IntervalEnd`; `budget` while it is only a guess.
        visited: The places refitted at, the best fit first, in order.
        standing: Where the last walk stood; without slopes once the end is known.
    """

    t: float
    z: float
    ended: Ended
    visited: tuple[Visited, ...]
    standing: Standing | None = None


def nearest(best: Iterate, k: int) -> float:
    """How near two values of a parameter may be in the unit cube and still differ.

    Ranges are wide enough for a press: the friction of a small motor lies at a billionth of its.
    """
    return max(float(np.finfo(float).eps * best.u[k]), TINIEST)


@dataclass(frozen=True, eq=False)
class Ray:
    """A parameter, the way it goes, and what its heights are counted from.

    Args:
        problem: Whose residuals.
        box: Of its parameters.
        best: The best fit.
        k: The parameter.
        sign: -1 for downwards, 1 for upwards.
        threshold: Rise of the sum of squares that ends the interval.
        reach: Half-width of the interval to first order.
    """

    problem: Residuals
    box: Box
    best: Iterate
    k: int
    sign: int
    threshold: float
    reach: float

    @cached_property
    def limit(self) -> tuple[float, Ended]:
        """How far the range or an order lets it go, and which of them."""
        end, ordered = self.box.limit(self.k, self.sign)
        return max(self.distance(end), 0.0), "order" if ordered else "bound"

    def distance(self, u: float) -> float:
        """Of a value of the parameter, in the unit cube, from the best fit's, outward."""
        return self.sign * (u - float(self.best.u[self.k]))

    def height(self, squares: float) -> float:
        """Of a sum of squares."""
        with np.errstate(over="ignore"):  # beside a model that leaves nothing, all is infinite
            return float(np.sqrt(max(squares - self.best.squares, 0.0) / self.threshold))

    def guess(self) -> Walked:
        """What the slopes at the best fit say, where it cannot be walked."""
        end = _end(self, Standing(self.best, 0.0, 0.0), ())
        return end._replace(visited=self.unwalked().visited)

    def unwalked(self) -> Walked:
        """What is known before any walk."""
        return Walked(0.0, 0.0, "budget", (Visited(0.0, 0.0, self.best.u.copy()),))


def walk(ray: Ray, start: Iterate | None, walked: Walked, rows: float = np.inf) -> Moves[Walked]:
    """Go outward from a place until the side is known.

    Args:
        ray: Which side.
        start: A refit on it; None to go on from where the last walk stood.
        walked: What earlier walks have visited.
        rows: Evaluations after which it stops, with the end as a guess.
    """
    at, visited = walked.standing, list(walked.visited)
    if start is not None or at is None:
        start = start or ray.best
        t = max(ray.distance(float(start.u[ray.k])), 0.0)
        at = Standing(start, t, ray.height(start.squares))
        if t > 0:
            visited.append(Visited(t, at.z, start.u.copy()))
    try:
        for _ in range(MOST):
            walked = _end(ray, at, visited)
            if walked.ended != "budget" or rows <= 0:
                break
            goal = _goal(ray, at, visited)
            (trial, stride, blocked), asked = yield from counted(_refitted(ray, at, goal))
            rows -= asked
            if trial is None:
                at = at._replace(stride=stride, blocked=blocked)
                continue
            height = ray.height(trial.squares)
            visited.append(Visited(goal, height, trial.u.copy()))
            at = _advanced(at, goal, height, trial)
    except SpentError:  # then the end is a guess
        pass
    if walked.ended != "budget":  # nobody goes on from there
        at = at._replace(place=at.place.without_slopes())
    return walked._replace(visited=tuple(visited), standing=at)


def _advanced(at: Standing, goal: float, height: float, trial: Iterate) -> Standing:
    """Stand at a refit, or know it as one that is too far."""
    if height > 1 + SHARP:
        return at._replace(outer=(goal, height))
    stride = max(at.stride, 3 * (goal - at.t)) if at.stride < np.inf else at.stride
    return at._replace(place=trial, t=goal, z=height, stride=stride)


def _end(ray: Ray, at: Standing, visited: Sequence[Visited]) -> Walked:
    """The end as far as it is known from here."""
    t, z, outer, (room, limited) = at.t, at.z, at.outer, ray.limit

    def end(ended: Ended, t: float, z: float) -> Walked:
        return Walked(min(max(t, 0.0), room), z, ended, ())

    if abs(z - 1) <= SHARP:
        return end("threshold", _crossing(at, visited), 1.0)
    if outer is not None and min(outer[0] - t, at.stride) <= SHARP * outer[0]:
        share = (1 - z) / (outer[1] - z) if outer[1] > z else 0.0
        return end("threshold", t + min(max(share, 0.0), 1.0) * (outer[0] - t), 1.0)
    if outer is None and t >= room * (1 - 1e-12):
        return end("flat" if z * z < FLAT and t > LONG else limited, room, z)
    if outer is None and at.stride < SHARP * max(t, SHARP * ray.reach, nearest(ray.best, ray.k)):
        return end(at.blocked, t, z)  # a wall
    return end("budget", max(t / z if z > LOW else t, ray.reach), z)


def _goal(ray: Ray, at: Standing, visited: Sequence[Visited]) -> float:
    """The distance to look at next."""
    t, z, room = at.t, at.z, ray.limit[0]
    if at.outer is not None:
        far, high = at.outer
        share = (1 - z) / (high - z) if high > z else 0.5
        return t + min(max(share, 0.1), 0.9) * min(far - t, at.stride)
    slope = 1.0 / ray.reach
    if t > 0:
        before, low = _before(t, visited)
        slope = (z - low) / (t - before)
    goal = t + (1.0 - z) / slope if slope > 0 else room
    goal = min(goal, t + at.stride, max(2.5 * t, t + ray.reach), room)
    if room - goal < 0.05 * (goal - t) and room - t <= at.stride:
        return room
    return goal


def _crossing(at: Standing, visited: Sequence[Visited]) -> float:
    """Where z passes 1, by the slope to the place before."""
    before, low = _before(at.t, visited)
    return at.t + (1 - at.z) * (at.t - before) / (at.z - low) if at.z > low else at.t


def _before(t: float, visited: Sequence[Visited]) -> tuple[float, float]:
    """Distance and height of the place before one on the way out."""
    return max(((v.t, v.z) for v in visited if v.t < t), default=(0.0, 0.0))


def _refitted(ray: Ray, at: Standing, goal: float) -> Moves[tuple[Iterate | None, float, Ended]]:
    """The refit at a distance; where it has to be tried nearer, None, the next stride and why."""
    box, k, threshold, step = ray.box, ray.k, ray.threshold, goal - at.t
    u, _ = predicted(at.place, box, k, ray.sign * step)
    trial = yield from _tried(at.place, u)
    if trial is None:
        allowed = physical(ray.problem, box.x(u)[None])[0]
        return None, step / 3, "unrunnable" if allowed else "order"
    height, free = ray.height(trial.squares), others(box.dim, k)
    if height > FAR and step > NEAR * max(goal, ray.reach):
        # the straight guess errs by the square of the step, and so does its height
        shorter = step * max(np.sqrt(2 / height), 0.1)
        trial = yield from _tried(at.place, compensated(at.place, box, k, ray.sign * step))
        if trial is None or ray.height(trial.squares) > FAR:
            return None, shorter, "threshold"
    rows = 4 * box.dim + 12
    trial, _ = yield from minimise(
        trial, box, free, gain=ROUGH * threshold, rows=rows, rest="corrected"
    )
    if ray.height(trial.squares) > ROUGHLY:
        trial, _ = yield from minimise(
            trial, box, free, gain=FINE * threshold, rows=rows, rest="corrected"
        )
    if ray.height(trial.squares) > STEEP and step > SHARP * goal:
        return None, step / 3, "threshold"
    return trial, at.stride, at.blocked


def rechecked(ray: Ray, place: Iterate) -> Moves[Iterate]:
    """The refit at a place, from slopes that are taken there."""
    fresh = yield from with_slopes(place)
    free, rows = others(ray.box.dim, ray.k), 4 * ray.box.dim + 12
    gain = FINE * ray.threshold
    refit, _ = yield from minimise(fresh, ray.box, free, gain=gain, rows=rows, rest="corrected")
    return refit


def _tried(place: Iterate, u: Array) -> Moves[Iterate | None]:
    """The point u beside a place, with its slopes as far as they are known; None if it cannot."""
    answer: Answer = yield Detailed(u[None])
    R = _shown(answer)[0]
    return place.corrected(u - place.u, R).moved(u, R) if np.isfinite(R).all() else None


def _shown(answer: Answer) -> Array:
    assert answer.residuals is not None  # noqa: S101 - the problem shows them
    return answer.residuals


def beyond(ray: Ray, walked: Walked, met: Sequence[tuple[Array, float]]) -> Array | None:
    """The outermost point that fits as well and lies beyond the end, SI; None if there is none.

    Args:
        ray: Which side.
        walked: What is known of it.
        met: Points, SI, with their sums of squares, whoever has met them.
    """
    if walked.ended in ("bound", "order", "flat", "budget"):
        return None
    fitting = [x for x, s in met if s - ray.best.squares < (1 - SHARP) * ray.threshold]
    if not fitting:
        return None
    far = ray.sign * (ray.box.space.encode(np.array(fitting))[:, ray.k] - ray.best.u[ray.k])
    k = int(far.argmax())
    return fitting[k] if far[k] > walked.t * (1 + 2 * SHARP) + nearest(ray.best, ray.k) else None
