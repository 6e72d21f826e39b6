"""The identified law in numbers: its curve and band, what the data imply, its loop, its loads."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING

import numpy as np

from ...friction import LOADS
from ...identify.score import simulated
from ...rig.simulated import as_simulated

if TYPE_CHECKING:
    from ...friction import Law
    from ...identify.balance.balance import Balance
    from ...identify.result import Fit
    from ...identify.segment import Segment
    from ...space import Array

#: A loop is walked in so many steps a stroke, as far as bristles slip, and this much further.
_STEPS, _BEYOND = 200, 1.5
#: Bristles slip where the force has come so near that of steady sliding; ways tried, m or rad.
_SLIPPING, _WAYS = 0.97, np.geomspace(1e-9, 10.0, 60)
#: Speeds of a curve each way, from a ten-thousandth of the greatest.
_SPEEDS = 400
#: How motor and surroundings share the work, in words.
_WORK = {"motor against load": "both", "motor alone": "drive", "load alone": "external"}


def sides(low: float, high: float, n: int = _SPEEDS) -> list[Array]:
    """Speeds at which a law is drawn, each way from rest (its level first), SI."""
    return [
        np.concatenate([[sign * 0.0], end * np.geomspace(1e-4, 1.0, n)])
        for sign, end in ((1.0, high), (-1.0, low))
        if sign * end > 0
    ]


def law_parameters(fit: Fit) -> Array:
    """The law's parameters."""
    return np.ascontiguousarray(fit.p[: len(fit.law.params)])


def velocity_range(fit: Fit) -> tuple[float, float]:
    """Least and greatest velocity of the training data, m/s (rad/s)."""
    if fit.balance is not None:
        velocities = [b.velocity for b in fit.balance.signals]
    else:
        velocities = [m.velocity for m in simulated(fit.parameters, fit.p, fit.train)]
    return min(float(v.min()) for v in velocities), max(float(v.max()) for v in velocities)


def reach(fit: Fit) -> float:
    """The greatest speed of the training data, m/s (rad/s)."""
    return float(np.abs(velocity_range(fit)).max())


def implied(fit: Fit) -> tuple[Array, Array] | None:
    """Velocity and friction in slip as the measured motions imply them, SI, (N,) each.

    None where the rig cannot say, or nothing slips long enough.
    """
    if fit.balance is not None:
        return balance_points(fit.balance)
    points = [both for s in fit.train if (both := _implied(fit, s)) is not None]
    if not points:
        return None
    return np.concatenate([v for v, _ in points]), np.concatenate([F for _, F in points])


def balance_points(balance: Balance) -> tuple[Array, Array]:
    """Velocity and what inertia and offset leave of the measured force, SI."""
    return (
        np.concatenate([b.velocity for b in balance.signals]),
        np.concatenate([b.friction for b in balance.signals]),
    )


def _implied(fit: Fit, segment: Segment) -> tuple[Array, Array] | None:
    """Velocity and friction in slip as the measurement implies them.

    Velocity and acceleration by local quadratics over a tenth of a second or nine new samples,
    whichever is longer. None if the rig cannot say or the segment is too short.
    """
    rig, track = as_simulated(fit.rig), segment.track
    counts = track.score > 0
    t, x = track.t[counts], track.measured[counts]
    dt = float(np.median(np.diff(t)))
    grid = np.arange(t[0], t[-1], dt)
    x = np.interp(grid, t, x)
    width = max(9, 2 * int(0.05 / dt) + 1)
    if len(grid) <= width:
        return None
    smooth, v, a = local_quadratics(x, width, dt)
    inner = slice(width // 2, len(grid) - width // 2)
    e = np.interp(grid[inner], track.knots_t, track.knots_x) - smooth
    F = rig.friction(fit.law, fit.p, e, v, a)
    if F is None:
        return None
    # A window that reaches into a rest mixes both; only those wholly inside a slip are drawn.
    fast = np.pad(np.abs(v) > 0.05 * np.abs(v).max(), width // 2, mode="symmetric")
    moving = np.lib.stride_tricks.sliding_window_view(fast, width).all(axis=1)
    return v[moving], F[moving]


def local_quadratics(x: Array, width: int, dt: float) -> tuple[Array, Array, Array]:
    """Value, slope and curvature at the middle of every window of `width` samples (odd).

    The least-squares parabola of each window (Savitzky and Golay 1964, doi 10.1021/ac60214a047).
    scipy.signal has one for each of the three, for half a second of start-up.
    """
    t = (np.arange(width) - width // 2) * dt
    rows = np.linalg.pinv(np.vander(t, 3, increasing=True))
    value, slope, half = (np.convolve(x, row[::-1], mode="valid") for row in rows)
    return value, slope, 2.0 * half


def loop(law: Law, p: Array, way: float, pace: float) -> tuple[Array, Array]:
    """Displacement and force from relaxed bristles to `way`, back to −way, and to `way` again."""
    turns = way * np.array([0.0, 1.0, -1.0, 1.0])
    x = np.concatenate(
        [np.linspace(a, b, _STEPS, endpoint=False) for a, b in itertools.pairwise(turns)]
        + [turns[-1:]]
    )
    return x, force_along(law, p, x, pace)


def force_along(law: Law, p: Array, x: Array, pace: float) -> Array:
    """Force of a law at positions that are passed one after the other at a pace, without load."""
    z, out, load = np.zeros(law.states), np.zeros(law.states), np.zeros(len(LOADS))
    F = np.zeros(len(x))
    for k, step in enumerate(np.diff(x), 1):
        F[k] = law.rub(np.copysign(pace, step), abs(step) / pace, z, load, p, out)
        z, out = out, z
    return F


def stroke(fit: Fit) -> tuple[float, float]:
    """How far and how fast slow strokes go that show the loop of a law with states, SI."""
    pace = 0.01 * reach(fit) if not fit.rig.applied_force else _pace(fit)
    return _way(fit, pace), pace


def _way(fit: Fit, pace: float) -> float:
    """How far strokes go that show the loop: as far as was measured, or until bristles slip."""
    p = law_parameters(fit)
    if fit.rig.applied_force:
        spans = [np.ptp(s.track.measured[s.track.score > 0]) for s in fit.train]
        return 0.5 * float(max(spans))
    steady = float(fit.law.slip(pace, p))
    for way in _WAYS:
        if force_along(fit.law, p, np.linspace(0.0, way, _STEPS), pace)[-1] >= _SLIPPING * steady:
            return float(_BEYOND * way)
    return float(_WAYS[-1])


def _pace(fit: Fit) -> float:
    """The mean speed of the motions, m/s (rad/s)."""
    ways = [(np.abs(np.diff(s.track.measured)).sum(), np.ptp(s.track.t)) for s in fit.train]
    return float(sum(a for a, _ in ways) / sum(b for _, b in ways))


def loads(law: Law) -> dict[str, str]:
    """The loads under which a law is shown: what `friction_under` calls them, by their names."""
    return {"normal load": "normal"} if "normal" in law.loads else dict(_WORK)


def friction_under(law: Law, p: Array, v: float, way: str, size: float) -> float:
    """The friction of a law at a speed (its level at +0) under a load of some size.

    Args:
        law: A law that reads loads.
        p: Its parameters.
        v: The speed, m/s or rad/s.
        way: Which load; `both` if the drive holds what the surroundings apply.
        size: How large it is.
    """
    load, nothing = np.zeros(len(LOADS)), np.zeros(law.states)
    for name in ("drive", "external") if way == "both" else (way,):
        load[LOADS.index(name)] = -size if (way, name) == ("both", "external") else size
    return float(law.rub(v, 0.0, nothing, load, p, nothing.copy()))


def greatest_load(fit: Fit) -> float:
    """The greatest load of the training data, in the law's unit."""
    if "normal" in fit.law.loads:
        pressures = [a for log in fit.recordings if (a := log.pressure) is not None]
        return max((float(np.abs(a).max()) for a in pressures), default=1.0)
    if fit.balance is not None:
        return max(float(np.abs(b.measured).max()) for b in fit.balance.signals)
    motions = simulated(fit.parameters, fit.p, fit.train)
    return max(float(np.abs(m.force).max()) for m in motions)
