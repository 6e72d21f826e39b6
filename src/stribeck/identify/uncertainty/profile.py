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

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.special import fdtri

from ...errors import InputError
from ...optimize.box import Box
from ...optimize.lockstep import AskTell, Counted, lockstep
from ...optimize.trust_region import Iterate, minimise
from ...space import Array
from ..polish import polish
from .covariance import QuickLook, quick_look
from .linearisation import box_of, linearised
from .profile_walk import Ended, Ray, Walked, beyond, nearest, rechecked, walk
from .residuals import Residuals, dofs_of, logs_of, rounding_of
from .roughness import outweighing, roughness

LEVEL = 0.95
#: Rows that profiles may evaluate unless a caller says otherwise.
BUDGET = 20_000
#: The refit of the best fit, from which all is counted, is over where no step promises more than
#: this share of the least threshold; and it may ask for so many rows, for each parameter and one.
FINEST, ROWS = 1e-6, 40
#: A fit better by this share of the least threshold is a new best; how often that may happen.
BETTER, RESTARTS = 0.02, 8
#: How often intervals are carried on from places that other walks have met.
ROUNDS = 3
#: A side is walked from the end of a parameter that the data do not hold, too, if to first order it
#: is longer from there by this factor.
LONGER = 1.5
#: A side shorter than this share of the other is refitted at its end, and carried on if that
#: lowers it below this share of its height.
SHORT, LOWER = 0.7, 0.9
#: A misfit is too rough to be walked along where hardly moving changes it by more than this share
#: of the least threshold: five times the share that decides whether a refit has ended.
ROUGHEST = 0.02
#: Evaluations of the descent to another minimum, for each parameter and one.
MODE = 15
#: Memory for slopes, bytes: so many sides walk at once.
MEMORY = 1e8


@dataclass(frozen=True, eq=False)
class IntervalEnd:
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
    low: IntervalEnd
    high: IntervalEnd
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
        quick: The quick look at x.
        J: Slopes of the residuals at x over the unit cube, (dim, N); N is 0 where they have served.
        residuals: At x, (N,); the same.
        logs: Rows of each log.
        rows: Rows evaluated.
        complete: Whether the budget sufficed.
        rough: Whether the misfit is too rough to be walked along: then all ends are guesses.
    """

    x: Array
    squares: float
    before: float
    improved: int
    profiles: tuple[Profile, ...]
    quick: QuickLook
    J: Array = field(repr=False)
    residuals: Array = field(repr=False)
    logs: tuple[int, ...] = field(repr=False)
    rows: int
    complete: bool
    rough: bool = False


def profiles(
    problem: Residuals,
    x: Array,
    *,
    level: float = LEVEL,
    ratio: Array | None = None,
    budget: int = BUDGET,
    chosen_names: Sequence[str] | None = None,
    keep: bool = False,
    modes: Sequence[Array] = (),
) -> Profiles:
    """The profile likelihood of each parameter at a fit.

    Args:
        problem: Its residuals; see `Residuals`.
        x: The fit, SI, (dim,).
        level: Of the intervals.
        ratio: Variance of each estimate over that with white residuals, (dim,); by default
            from the residuals themselves. Ones for residuals known to be white.
        budget: Rows that may be evaluated.
        chosen_names: Names of the parameters to profile; all by default.
        keep: Whether the fit stays as it is, whatever better one is met.
        modes: Near other minima, SI, (dim,) each: what fits as well there is in the intervals, too.

    Raises:
        InputError: the fit cannot be run, has no more rows than parameters, or a name is unknown.
    """
    counted, box = Counted(problem, budget), box_of(problem)
    chosen = _chosen(box, chosen_names)
    best = linearised(counted, box, x)
    logs, before, improved, rough = logs_of(problem, len(best.r)), best.squares, 0, None
    for mode in modes:  # what is met there is kept
        if counted.left > 2 * MODE * (box.dim + 1):
            polish(counted, mode, None, MODE * (box.dim + 1))
    while True:
        few = dofs_of(problem)
        rounding = rounding_of(problem, best.J)
        first = _thresholds(quick_look(best.J, best.r, logs), level, ratio, few, rounding)
        if not keep:
            best = _refined(best, counted, box, FINEST * float(first.min()))
            if np.isfinite(few).any() and counted.left > 2 * box.dim:
                # Corrected slopes give rows to a parameter that only its few observations move.
                best = linearised(counted, box, box.x(best.u))
        quick = quick_look(best.J, best.r, logs)
        thresholds = _thresholds(quick, level, ratio, few, rounding)
        if not hasattr(problem, "rounding"):  # one that states it is smooth beside that
            rough = roughness(best, box, counted, ROUGHEST * float(thresholds.min()))
        if rough is not None:
            best = outweighing(best, box, counted, rough)
            quick = quick_look(best.J, best.r, logs)
            thresholds = _thresholds(quick, level, ratio, few, rounding)
        rays = [
            Ray(problem, box, best, k, sign, thresholds[k], _reach(best, quick, thresholds[k], k))
            for k in chosen
            for sign in (-1, 1)
        ]
        if rough is not None:
            walked = [ray.guess() for ray in rays]
            break
        better = -np.inf if keep else best.squares - BETTER * float(thresholds.min())
        walked, met = _walked(rays, best, counted, better)
        if met is None or improved >= RESTARTS or counted.left < 4 * box.dim:
            break
        improved += 1
        best = linearised(counted, box, met)
    sides = list(zip(rays, walked, strict=True))
    result = tuple(
        _profile(box, low, high) for low, high in zip(sides[::2], sides[1::2], strict=True)
    )
    return Profiles(
        box.x(best.u),
        best.squares,
        before,
        improved,
        result,
        quick,
        best.J,
        best.r,
        logs,
        counted.rows,
        all(s.ended != "budget" for p in result for s in (p.low, p.high)),
        rough is not None,
    )


def _chosen(box: Box, chosen_names: Sequence[str] | None) -> list[int]:
    names = box.space.names
    if strange := [n for n in chosen_names or () if n not in names]:
        raise InputError(f"no free parameter {strange[0]!r}: there are {', '.join(names)}")
    return [i for i, n in enumerate(names) if chosen_names is None or n in chosen_names]


def _refined(best: Iterate, counted: Counted, box: Box, gain: float) -> Iterate:
    """The best fit refitted, as far as the budget goes."""
    rows = min(ROWS * (box.dim + 1), counted.left)
    moves = minimise(best, box, gain=gain, rows=rows)
    (iterate,) = lockstep(counted, [AskTell("refit", box.space, moves)])
    return best if iterate is None else iterate[0]


def _thresholds(
    quick: QuickLook, level: float, ratio: Array | None, few: Array, rounding: float
) -> Array:
    """By how much the sum of squares may rise, (dim,)."""
    quantile = fdtri(1, np.minimum(few, quick.dof), level)
    ratios = quick.ratio if ratio is None else np.asarray(ratio, dtype=float)
    # A fit without misfit is known as well as finite differences are.
    least = rounding**2 + float(np.finfo(float).tiny)
    thresholds: Array = max(quick.variance, least) * quantile * ratios
    return thresholds


def _reach(best: Iterate, quick: QuickLook, threshold: float, k: int) -> float:
    """Half-width of the interval to first order, at most the range."""
    if quick.blind[k]:
        return 1.0
    return float(np.clip(np.sqrt(threshold * quick.curvature[k, k]), nearest(best, k), 1.0))


def _walked(
    rays: Sequence[Ray], best: Iterate, counted: Counted, better: float
) -> tuple[list[Walked], Array | None]:
    """What is known of all sides once they are walked; and a better fit, SI, if one was met."""
    limit = best.squares + max((ray.threshold for ray in rays), default=0.0)

    def met() -> bool:
        counted.forget(limit)
        return any(s < better for _, s in counted.visited)

    walked = [ray.unwalked() for ray in rays]
    todo: list[tuple[int, Iterate | None]] = [(i, best) for i in range(len(rays))]
    at_once = max(int(MEMORY / (8 * best.J.size)), 1)
    open_ends: dict[Iterate, Iterate] = {}
    for _ in range(1 + ROUNDS):
        for first in range(0, len(todo), at_once):
            part = todo[first : first + at_once]
            share = max(counted.left // (len(todo) - first), 1)
            moves = [walk(rays[i], place, walked[i], share) for i, place in part]
            tasks = [AskTell("walk", counted.space, m) for m in moves]
            for (i, _), side in zip(part, lockstep(counted, tasks, met), strict=True):
                walked[i] = walked[i] if side is None else side
            if met():
                return walked, min(counted.visited, key=lambda visited: visited[1])[0]
        todo = (
            _unfinished(rays, walked, counted)
            or _doubtful(rays, walked, counted, at_once)
            or _from_open_ends(rays, walked, counted, open_ends)
        )
        if met():
            return walked, min(counted.visited, key=lambda visited: visited[1])[0]
        if not todo:
            break
    return walked, None


def _doubtful(
    rays: Sequence[Ray], walked: Sequence[Walked], counted: Counted, at_once: int
) -> list[tuple[int, Iterate | None]]:
    """Short sides that end at a place which fits better once refitted with slopes of its own.

    On the way out slopes are corrected, not taken anew: where a misfit is rough they may be those
    of another branch, in which the fit seems to suffer long before it does. Then one side of a
    parameter is much shorter than the other, as a rule.
    """
    reaches = {(ray.k, ray.sign): side.t for ray, side in zip(rays, walked, strict=True)}
    ends = [
        (i, side.standing.place)
        for i, (ray, side) in enumerate(zip(rays, walked, strict=True))
        if side.ended == "threshold"
        and side.standing is not None
        and 0 < side.t < SHORT * reaches[ray.k, -ray.sign]
    ]
    todo: list[tuple[int, Iterate | None]] = []
    for first in range(0, len(ends), at_once):
        part = ends[first : first + at_once]
        if counted.left <= 2 * len(part) * rays[0].box.dim:
            break
        tasks = [AskTell("check", counted.space, rechecked(rays[i], at)) for i, at in part]
        for (i, at), iterate in zip(part, lockstep(counted, tasks), strict=True):
            before = rays[i].height(at.squares)
            if iterate is not None and rays[i].height(iterate.squares) < LOWER * before:
                todo.append((i, iterate))
    return todo


def _from_open_ends(
    rays: Sequence[Ray],
    walked: Sequence[Walked],
    counted: Counted,
    known: dict[Iterate, Iterate],
) -> list[tuple[int, Iterate | None]]:
    """Sides that are longer, to first order, from where another parameter meets its range.

    What the data do not hold may be anywhere in its range, and what is known of the others is what
    is known wherever it is: a drop of friction below all speeds of a log shows the level after it,
    one above them all the level before.

    Args:
        rays: The sides.
        walked: What is known of each.
        counted: The problem.
        known: Where sides stand, with slopes taken there; this adds to it.
    """
    todo: dict[int, tuple[float, Iterate]] = {}
    for open_ray, side in zip(rays, walked, strict=True):
        if side.ended not in ("bound", "flat") or side.standing is None or not side.t > 0:
            continue
        if counted.left <= 4 * open_ray.box.dim:
            break
        at = side.standing.place
        if at not in known:
            known[at] = linearised(counted, open_ray.box, open_ray.box.x(at.u))
        place = known[at]
        quick = quick_look(place.J, place.r, logs_of(open_ray.problem, len(place.r)))
        for i, ray in enumerate(rays):
            height = ray.height(place.squares)
            if ray.k == open_ray.k or walked[i].ended != "threshold" or height >= 1.0:
                continue
            way = _reach(ray.best, quick, ray.threshold, ray.k) * float(np.sqrt(1.0 - height**2))
            way = min(ray.distance(float(place.u[ray.k])) + way, ray.limit[0])
            if way > max(LONGER * walked[i].t, todo[i][0] if i in todo else 0.0):
                todo[i] = way, place
    return [(i, place) for i, (_, place) in todo.items()]


def _unfinished(
    rays: Sequence[Ray], walked: Sequence[Walked], counted: Counted
) -> list[tuple[int, Iterate | None]]:
    """Sides to be walked on: from a fitting point beyond the end, or from where they stand."""
    todo: list[tuple[int, Iterate | None]] = []
    for i, ray in enumerate(rays):
        if counted.left <= 2 * ray.box.dim:
            break
        x = beyond(ray, walked[i], counted.visited)
        if x is not None:
            todo.append((i, linearised(counted, ray.box, x)))
        elif walked[i].ended == "budget":  # with what the others have left
            todo.append((i, None))
    return todo


def _profile(box: Box, low: tuple[Ray, Walked], high: tuple[Ray, Walked]) -> Profile:
    (ray, down), (_, up) = low, high
    best, k = ray.best, ray.k

    def x(t: float) -> float:
        u = best.u.copy()
        u[k] = min(max(u[k] + t, 0.0), 1.0)
        return float(box.x(u)[k])

    places = [(-t, z, u) for t, z, u in down.visited[1:]] + [*up.visited]
    places.sort(key=lambda place: place[:2])
    return Profile(
        box.space.names[k],
        x(0.0),
        IntervalEnd(x(-down.t), down.ended, down.z**2),
        IntervalEnd(x(up.t), up.ended, up.z**2),
        np.array([x(t) for t, _, _ in places]),
        np.array([z * z for _, z, _ in places]),
        box.space.decode(np.array([u for _, _, u in places])),
        ray.threshold,
    )
