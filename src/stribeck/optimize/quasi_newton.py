"""Quasi-Newton descent by costs alone, with few evaluations.

BFGS in its direct form (the curvature itself is kept, so that a parameter on its bound can be left
out of it), damped as Powell does (1978, doi 10.1007/BFb0067703), gradients by forward differences
in one batch. Their steps follow the curvature: as short as rounding allows, so that a narrow valley
is seen as it is; half the curvature is taken off each, which makes them good to second order.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..space import Array
from .differences import differences
from .moves import Moves, Note

#: Differences: the first, the shortest and the longest.
STEP, SHORTEST, LONGEST = 1e-7, 1e-9, 1e-6
#: A step must keep this share of the gain that the slope promises (Armijo's rule).
ARMIJO = 1e-4
#: Backtracking steps before a direction is given up.
TRIES = 6
#: A descent is abandoned when this many times the gain promised, or the last one if that was
#: more, would not make it the best (after as many steps as there are parameters).
HOPE = 1.5
#: The first curvature is this share of what the first step has shown: where it is too low a step
#: goes too far, and teaches; where it is too high, all steps are too short for long.
FIRST = 0.01
#: A gain above this share of the one before is no longer that of a Newton method.
SLOW = 0.3
ROUNDING = float(np.finfo(float).eps)
#: Gains promised below this share of the cost, some roundings of it, are not seen in it.
NOTHING = 100 * ROUNDING
#: And so are steps shorter than this.
SHORT = 2e-9


class BfgsState(NamedTuple):
    """Where a descent stands, and all it takes to go on from there.

    Args:
        point: In the unit cube, (dim,).
        cost: There.
        gradient: There, (dim,); None before any is taken.
        curvature: (dim, dim); None before any is known.
        radius: Length of the first step; the longest is twice that.
        worth: Gains below this were small to the descent that left here.
        ended: "" if it has not; "flat" where no gain is left, "slow" where it comes slowly and
            another start may bring more, "poor" where it would not become the best, "rough"
            where the slopes promise a gain and no step keeps it.
    """

    point: Array
    cost: float
    gradient: Array | None = None
    curvature: Array | None = None
    radius: float = 0.1
    worth: float = 0.0
    ended: str = ""


def quasi_newton(state: BfgsState, note: Note, *, best: float = np.inf) -> Moves[BfgsState]:
    """Descend from a point of the unit cube.

    Args:
        state: Where from; what an earlier descent returned goes on where it ended. Where gains
            are below its `worth` and come slowly, too, the descent is left.
        note: Takes what every batch asks for.
        best: The least cost known elsewhere: a descent that would not get below it is abandoned.
    """
    u, f, g, B, radius, worth, _ = state
    if g is None:
        note(asks="slopes")
        g = yield from _gradient(u, f, None)
        if g is None:
            return state._replace(ended="rough")
    rough, turns = False, 0
    before = 0.0  # the last gain
    while True:
        turns += 1
        inside = ~(((u <= 0.0) & (g > 0.0)) | ((u >= 1.0) & (g < 0.0)))
        p, promised = _direction(g, B, inside, radius)
        hopeless = B is not None and turns > len(u) and f - HOPE * max(promised, before) > best
        if hopeless or promised <= NOTHING * abs(f) or np.abs(p).max() < SHORT:
            return BfgsState(u, f, g, B, radius, worth, "poor" if hopeless else "flat")

        v, cost = yield from _step(u, f, g, p, note)
        if not cost < f:
            if B is None or rough:
                return BfgsState(u, f, g, B, radius, worth, "rough")
            rough, B, radius = True, None, min(radius, max(1e-6, 4.0 * float(np.abs(v - u).max())))
            continue

        note(asks="slopes")
        slopes = yield from _gradient(v, cost, B)
        if slopes is None:
            return BfgsState(v, cost, g, B, radius, worth, "rough")
        gain, s, y = f - cost, v - u, slopes - g
        u, f, g, rough = v, cost, slopes, False
        B = _curvature(B, s, y)
        if B is None:
            radius = min(2.0 * radius, 0.5)
        if gain < worth and gain > SLOW * before > 0.0:
            return BfgsState(u, f, g, B, radius, worth, "slow")
        before = gain


def _step(u: Array, f: float, g: Array, p: Array, note: Note) -> Moves[tuple[Array, float]]:
    """Step along p, less far until enough of the gain promised is kept; inf if it never is."""
    t = 1.0
    for _ in range(TRIES):
        v = np.minimum(np.maximum(u + t * p, 0.0), 1.0)
        note(asks="step")
        cost = float((yield v[None])[0])
        slope = float(g @ (v - u))
        if cost < f and cost <= f + ARMIJO * slope:
            return v, cost
        bend = 2.0 * (cost - f - slope)
        t *= min(max(-slope / bend, 0.1), 0.5) if 0.0 < bend < np.inf else 0.25
    return v, np.inf


def _gradient(u: Array, f: float, B: Array | None) -> Moves[Array | None]:
    """Forward differences; None where a neighbour cannot be run."""
    bend = None if B is None else np.maximum(np.diag(B), 0.0)
    h = np.full(len(u), STEP)
    if bend is not None:
        with np.errstate(divide="ignore"):
            h = np.minimum(np.maximum(2.0 * np.sqrt(ROUNDING * abs(f) / bend), SHORTEST), LONGEST)
    changes, h = yield from differences(u, np.array([f]), h, detailed=False, complete=True)
    g: Array = changes[:, 0] / h
    if not np.isfinite(g).all():
        return None
    if bend is not None:
        half = 0.5 * h * bend
        g = np.where(np.abs(half) < 0.5 * np.abs(g), g - half, g)
    return g


def _direction(g: Array, B: Array | None, inside: np.ndarray, radius: float) -> tuple[Array, float]:
    """A step within the bounds that are not met, and the gain it promises."""
    p = np.zeros(len(g))
    free = np.flatnonzero(inside)
    if not len(free):
        return p, 0.0
    slope = g[free]
    if B is not None:
        try:
            p[free] = -np.linalg.solve(B[np.ix_(free, free)], slope)
        except np.linalg.LinAlgError:
            B = None
    length = float(np.sqrt(slope @ slope))
    if B is None or not p @ g < 0.0:
        p[:] = 0.0
        if length > 0.0:
            p[free] = -slope * (radius / length)
        return p, radius * length
    promised = -0.5 * float(p @ g)
    long = float(np.sqrt(p @ p))
    if long > 2.0 * radius:
        p *= 2.0 * radius / long
    return p, promised


def _curvature(B: Array | None, s: Array, y: Array) -> Array | None:
    """The BFGS update, damped so that it stays positive definite; None while there is none."""
    sy = float(s @ y)
    if B is None:
        return np.eye(len(s)) * (FIRST * sy / float(s @ s)) if sy > 0.0 else None
    Bs = B @ s
    sBs = float(s @ Bs)
    if not sBs > 0.0:
        return None
    share = 1.0 if sy >= 0.2 * sBs else 0.8 * sBs / (sBs - sy)
    r = share * y + (1.0 - share) * Bs
    updated: Array = B - np.outer(Bs, Bs / sBs) + np.outer(r, r / float(s @ r))
    return updated
