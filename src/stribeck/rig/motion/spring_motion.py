"""The exact motion of a mass on Maxwell elements under a force that is straight between samples.

    M dv/dt = F(t) − Σ W_i c_i − D v,    c_i' = v/d_i while |c_i| < 1

Between two events, a turn of the motion or the yield of an element, that is a linear oscillator,
whose motion is known in closed form (Iwan 1966, doi 10.1115/1.3625199, equation 4). With y from
where a step begins, u and r the acceleration that its force gives at rest and the rate of that,

    y(τ) = v h + u H_1 + r H_2,    h'' + 2γ h' + ω² h = 0,    h(0) = 0, h'(0) = 1,

2γ = D/M, ω² the stiffness of the elements that hold over M, and H_1, H_2 the first and second
integral of h. Events are located to rounding, so a motion has no step and no tolerance. Only where
the mass swings by many radians between samples is that dear, and the stepper the better choice.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numba import float64, int64, types, void

from ...compile_cache import compiled
from ...friction.law import DRIVE, POSITION
from ...space import Array, contiguous
from . import row_pool
from .axis_row import LOAD_ROOM
from .drive_force import driven
from .drives import (
    ADDED,
    AXIS,
    ENABLED,
    EXTERNAL_FORCE,
    FORCE_LIMIT,
    IDLE,
    INPUTS,
    MOTOR_FRICTION,
)
from .implicit import EACH, ROOM
from .row_pool import borrowed
from .track import joined_tracks

if TYPE_CHECKING:
    from ...friction import Law
    from .track import Track

#: A step is cut so that the mass swings by no more, rad; and the most that it may swing between
#: samples, by which a step of the stepper costs less.
SWING, MOST_SWING = 0.5, 10.0
#: Terms of the series of h, exact to rounding for arguments up to SWING; and the share of a step
#: by which another may differ that takes its response.
TERMS, ALIKE = 18, 1e-9
#: Looks for an instant at most; it is known to this share of a step.
LOOKS, INSTANT = 60, 1e-15

_F1 = types.Array(float64, 1, "C", readonly=True)
_F2 = types.Array(float64, 2, "C", readonly=True)


@compiled(forceinline=True)
def response(damping: float, stiffness: float, tau: float) -> tuple[float, float, float, float]:
    """h', h, H_1 and H_2 after τ of an oscillator with 2γ and ω², as the head of the file has them.

    By the series of h over a part of τ, which is doubled until it is all of it.
    """
    size, doublings = max(damping, np.sqrt(stiffness)) * tau, 0
    while size > SWING:
        size, tau, doublings = 0.5 * size, 0.5 * tau, doublings + 1
    before, now, power = 0.0, 1.0, 1.0  # coefficients of h, and a power of τ
    slope, h, first, second = 0.0, 0.0, 0.0, 0.0
    for k in range(1, TERMS):
        slope += k * now * power
        power *= tau
        term = now * power
        h += term
        term *= tau / (k + 1.0)
        first += term
        second += term * tau / (k + 2.0)
        before, now = now, -(damping * k * now + stiffness * before) / ((k + 1.0) * k)
    for _ in range(doublings):
        own = slope + damping * h  # y after τ of y = 1, at rest
        second += own * second + h * first + tau * first
        first += own * first + h * h
        h, slope = h * (own + slope), slope * slope - stiffness * h * h
        tau *= 2.0
    return slope, h, first, second


@compiled(forceinline=True)
def _turn(
    damping: float, stiffness: float, v: float, u: float, r: float, way: float, high: float
) -> float:
    """The instant up to which a velocity keeps its sign, `way`, that has lost it at `high`."""
    low, tau, whole = 0.0, high, high
    for _ in range(LOOKS):
        slope, h, first, _ = response(damping, stiffness, tau)
        speed = v * slope + u * h + r * first
        if way * speed > 0.0:
            low = tau
        else:
            high = tau
        own = u - damping * v  # the acceleration where the step begins
        rate = own * slope + (r - stiffness * v) * h
        tau -= speed / rate if rate != 0.0 else 0.0
        if high - low <= INSTANT * whole:
            break
        if not low < tau < high:
            tau = 0.5 * (low + high)
        elif abs(speed) <= INSTANT * whole * abs(rate):
            break
    return tau


@compiled(forceinline=True)
def _passage(
    damping: float, stiffness: float, v: float, u: float, r: float, way: float, room: float,
    high: float,
) -> float:  # fmt: skip
    """The instant at which a motion that keeps its sign has come so far, room, as at `high`."""
    low, tau, whole = 0.0, high, high
    for _ in range(LOOKS):
        slope, h, first, second = response(damping, stiffness, tau)
        left = room - way * (v * h + u * first + r * second)
        speed = way * (v * slope + u * h + r * first)
        if left > 0.0:
            low = tau
        else:
            high = tau
        if high - low <= INSTANT * whole:
            break
        tau += left / speed if speed > 0.0 else 0.0
        if not low < tau < high:
            tau = 0.5 * (low + high)
        elif abs(left) <= INSTANT * whole * speed:
            break
    return tau


@compiled(forceinline=True)
def _least(damping: float, stiffness: float, v: float, u: float, r: float, high: float) -> float:
    """The instant before `high` at which an acceleration changes its sign, at the chord."""
    own = u - damping * v
    slope, h, _, _ = response(damping, stiffness, high)
    end = own * slope + (r - stiffness * v) * h
    return high * own / (own - end)  # type: ignore[no-any-return]


@compiled(forceinline=True)
def _begun(W: Array, d: Array, force: float, v: float, z: Array) -> None:
    """Shares of the elements where a motion starts, as `implicit.begun` has them, into z.

    Of steady sliding; at rest those on the way from relaxed elements on which they balance a
    force.
    """
    low, high = 0.0, 0.0
    for i in range(len(z)):
        high = max(high, d[i])
    held = abs(force)
    for _ in range(LOOKS):
        way, total = 0.5 * (low + high), 0.0
        for i in range(len(z)):
            total += W[i] * min(way / d[i], 1.0)
        if total < held:
            low = way
        else:
            high = way
    for i in range(len(z)):
        z[i] = np.copysign(min(high / d[i], 1.0), force) if v == 0.0 else np.copysign(1.0, v)


@compiled(forceinline=True)
def _held(W: Array, d: Array, z: Array, way: float, moved: float) -> tuple[float, float, float]:
    """The force of the elements, the stiffness of those that hold, and how far they go on holding.

    z are their shares before the axis moved so far, and after it then. Those that stand at their
    level in the direction of the motion, `way`, slip.
    """
    force, stiffness, room = 0.0, 0.0, np.inf
    for i in range(len(z)):
        z[i] = min(max(z[i] + moved / d[i], -1.0), 1.0)
        force += W[i] * z[i]
        left = d[i] * (1.0 - way * z[i])
        if left > INSTANT * d[i]:
            stiffness += W[i] / d[i]
            room = min(room, left)
        else:
            z[i] = way
    return force, stiffness, room


@compiled(
    void(
        _F2, _F2, _F1, _F2, _F1, int64[::1], _F2, _F2, float64[:, ::1], float64[:, ::1],
        float64[:, ::1], int64[::1],
    ),
    nogil=True,
)  # fmt: skip
def _rows(  # noqa: C901, PLR0912, PLR0915 - one loop of many cases
    levels: Array, yields: Array, viscous: Array, c: Array, t: Array, first: Array, inputs: Array,
    start: Array, out_q: Array, out_v: Array, out_F: Array, counter: Array,
) -> None:  # fmt: skip
    """Simulate the motions that no thread has taken yet, as `implicit` does.

    Velocities and forces are written where their arrays have rows.
    """
    t, inputs = borrowed(t), borrowed(inputs)
    n, external, whole_state = len(levels), len(inputs) > EXTERNAL_FORCE, len(out_v) > 0
    z_owner, u_owner = np.empty(levels.shape[1]), np.zeros(INPUTS)
    load_owner = np.empty(LOAD_ROOM)
    z, idle, load = borrowed(z_owner), borrowed(u_owner), borrowed(load_owner)
    idle[ENABLED] = 1.0
    while True:
        job = row_pool.next_row(counter)
        if job >= len(start):
            z_owner[0] = u_owner[0] = load_owner[0] = 0.0  # kept alive
            return
        i, row = job // n, job % n
        begin, end = first[i], first[i + 1]
        W, d, constants = borrowed(levels[row]), borrowed(yields[row]), borrowed(c[job])
        q, v = start[job, 0], start[job, 1]
        # The force is linear in what drives the axis: what it is without, and for a unit of that.
        load[POSITION], idle[ADDED] = np.nan, 0.0
        M, base, D, _ = driven(AXIS, constants, idle, q, 0.0, load)
        at_rest = load[DRIVE]
        idle[ADDED], load[POSITION] = 1.0, np.nan
        _, gain, _, _ = driven(AXIS, constants, idle, q, 0.0, load)
        gain -= base
        drive = load[DRIVE] - at_rest
        damping = (D + viscous[row]) / M
        F_1 = base + gain * inputs[ADDED, begin]
        if external:
            F_1 += inputs[EXTERNAL_FORCE, begin]
        _begun(W, d, F_1 - (D + viscous[row]) * v, v, z)
        way = np.copysign(1.0, v if v != 0.0 else F_1)
        S, stiffness, room = _held(W, d, z, way, 0.0)
        total = 0.0
        for j in range(len(z)):
            total += W[j] / d[j]
        swing, moved = np.sqrt(total / M), 0.0  # moved: since the last event
        per_mass, square = 1.0 / M, stiffness / M
        whole, w_slope, w_h, w_first, w_second = -1.0, 0.0, 0.0, 0.0, 0.0
        steps_left = ROOM + EACH * (end - begin)
        for k in range(begin, end):
            out_q[row, k] = q
            if whole_state:
                out_v[row, k], out_F[row, k] = v, at_rest + drive * inputs[ADDED, k]
            if k == end - 1 or not (abs(q) < 1e12 and abs(v) < 1e12) or steps_left <= 0:  # noqa: PLR2004
                break
            F, span = F_1, t[k + 1] - t[k]
            F_1 = base + gain * inputs[ADDED, k + 1]
            if external:
                F_1 += inputs[EXTERNAL_FORCE, k + 1]
            rate = (F_1 - F) / span
            parts, step, done = 1.0, span, 0.0
            if swing * span > SWING:
                parts = np.ceil(swing * span / SWING)
                step = span / parts
            left, r = step, rate * per_mass
            while done < parts and steps_left > 0:
                steps_left -= 1
                u = (F + rate * (done * step + (step - left)) - S) * per_mass
                if left != step:
                    slope, h, one, two = response(damping, square, left)
                else:
                    if abs(step - whole) > ALIKE * step:
                        w_slope, w_h, w_first, w_second = response(damping, square, step)
                        whole = step
                    slope, h, one, two = w_slope, w_h, w_first, w_second
                v_1, y = v * slope + u * h + r * one, v * h + u * one + r * two
                tau, event = left, 0
                a = u - damping * v
                if way * v_1 < 0.0:
                    tau, event = _turn(damping, square, v, u, r, way, left), 1
                elif way * a < 0.0:
                    a_1 = a * slope + (r - square * v) * h
                    if way * a_1 > 0.0:  # it may turn and turn back
                        least = _least(damping, square, v, u, r, left)
                        slope, h, one, _ = response(damping, square, least)
                        if way * (v * slope + u * h + r * one) < 0.0:
                            tau, event = _turn(damping, square, v, u, r, way, least), 1
                if event == 1:
                    slope, h, one, two = response(damping, square, tau)
                    v_1, y = 0.0, v * h + u * one + r * two
                if way * (moved + y) >= room:
                    ahead = room - way * moved
                    tau = _passage(damping, square, v, u, r, way, ahead, tau)
                    slope, h, one, two = response(damping, square, tau)
                    v_1, y, event = v * slope + u * h + r * one, way * ahead, 2
                q, v, S, moved = q + y, v_1, S + stiffness * y, moved + y
                left -= tau
                if event > 0:
                    if event == 1:
                        way = -way
                    S, stiffness, room = _held(W, d, z, way, moved)
                    moved, whole, square = 0.0, -1.0, stiffness * per_mass
                if event == 0 or left <= INSTANT * step:
                    done, left = done + 1.0, step
            if steps_left <= 0:
                q = np.nan


def swings(law: Law, p: Array, c: Array, tracks: Sequence[Track]) -> Array:
    """The most by which candidates swing between samples, rad, (n,); nan where this cannot tell.

    It is nan, too, where a law is more than Maxwell elements, or a motor has limits of its own.

    Args:
        law: The law.
        p: (n, k) parameters of it.
        c: (tracks, n, constants) constants of an axis on which nothing but a force acts.
        tracks: Sample times and inputs.
    """
    n = len(p)
    if law.elements is None or law.terms:
        return np.full(n, np.nan)
    if any(len(x.inputs) > ENABLED and (x.inputs[ENABLED] != IDLE[ENABLED]).any() for x in tracks):
        return np.full(n, np.nan)
    W, d, _ = law.elements(p)
    spans = max(float(np.median(np.diff(track.t))) if len(track.t) > 1 else 0.0 for track in tracks)
    with np.errstate(divide="ignore", invalid="ignore"):
        swing: Array = np.sqrt((W / d).sum(axis=1) / c[:, :, 0].min(axis=0)) * spans
    plain = np.isinf(c[:, :, FORCE_LIMIT]) & (c[:, :, MOTOR_FRICTION] == 0.0)
    return np.where(plain.all(axis=0), swing, np.nan)


def spring_motions(
    law: Law, p: Array, c: Array, tracks: Sequence[Track]
) -> tuple[Array, Array, Array]:
    """Position, velocity and drive force, (n, N) each, as `implicit.motions_over` has them."""
    q, v, F = np.full((3, len(p), sum(len(track.t) for track in tracks)), np.nan)
    _move(law, p, c, tracks, q, v, F)
    return q, v, F


def spring_positions(law: Law, p: Array, c: Array, tracks: Sequence[Track]) -> Array:
    """The positions alone, (n, N)."""
    q = np.full((len(p), sum(len(track.t) for track in tracks)), np.nan)
    _move(law, p, c, tracks, q, np.empty((0, 0)), np.empty((0, 0)))
    return q


def _move(
    law: Law, p: Array, c: Array, tracks: Sequence[Track], q: Array, v: Array, F: Array
) -> None:
    """Write the motions into q, and into v and F where these have rows."""
    n = len(p)
    if not n:
        return
    assert law.elements is not None  # noqa: S101 - `swings` tells
    W, d, viscous = law.elements(p)
    t, first, inputs, _, start = joined_tracks(tracks, n)
    row_pool.pool().share(
        _rows, len(start),
        (
            contiguous(W), contiguous(d), contiguous(viscous), contiguous(np.concatenate(c)),
            t, first, inputs, start, q, v, F,
        ),
        max(2, 10 * row_pool.FEWEST_SAMPLES * len(tracks) // max(len(t), 1)),
    )  # fmt: skip
