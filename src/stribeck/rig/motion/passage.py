"""The way of an axis from one sample to the next: steps, their errors, stops and breakaways.

The velocity at the share θ of a step of h seconds solves

    (m + θh d + (θh)² k) w + θh F_f(w, z after θh) = m v + θh F(t + θh, q),

d and k the damping and the stiffness of the drive, F its force without them; then

    v' = v + (w − v) / θ,    q' = q + h w,    z' = z after h at the velocity w.

θ = 1/2 is the implicit midpoint rule, symmetric in time, so that its error is a series in h²: one
step and two of half the length are extrapolated to order 4, (4 fine − coarse) / 3. That would let
the swing of a mass on bristles grow by 0.0009 y⁶ in a step of y rad, so θ = 1/2 + 0.003 y⁴, which
leaves the order. θ = 1 is backward Euler, extrapolated to order 2, 2 fine − coarse: it damps what
is too quick to be followed, and takes over where the axis forgets its velocity within a step.

The error of a step is the change of velocity and position less the integral of the acceleration by
Simpson's rule, which is of order 4, too, and shares nothing with the extrapolation. A step whose
error exceeds the tolerance is halved; corners of the drive and of a law's states are enclosed so.

Under a law without states, whose velocity decays by little in a step, most steps need no equation
to be solved: they are explicit, by Nyström's method of order 4 (1925; Abramowitz and Stegun,
25.5.20). Where the error of such a step is too great, it is halved; where it comes to rest, or the
velocity decays by more than that, it is taken implicitly.

A law without states sticks. It stops at the instant at which its velocity is zero, which is
located: within a step friction keeps its sign. Then it rests until the force passes a breakaway
level, which is located as well, or goes on at once, forward or backward. With a band of speeds in
which it rests, a slide stops where its speed falls to the band, and leaves rest with that speed
when what pulls at it beyond its level amounts to an impulse: as in `event_driven`, for who steps a
slide that sticks and has no events, a unit of `export.fmu`.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ...compile_cache import compiled
from ...friction.law import terms_factor
from ...space import Array
from .drive_force import driven, mixed
from .drives import BAND, CLAMP, DAMPING, IMPULSE, INERTIA, SLIDE
from .explicit_step import MILD, acceleration, explicit_step
from .velocity import rubs, solved

#: A step is halved so often at most.
FINEST = 16
#: Backward Euler where a velocity decays at more than STIFF per step, or the square of the angle by
#: which bristles swing in an unhalved one is above FAST.
STIFF, FAST = 6.0, 3600.0
#: How θ grows with the angle y by which bristles swing in a step, 1/2 + SWING y⁴: just enough that
#: no swing grows, however long the step is.
SWING = 0.003
#: A step is doubled where its error is so far below the tolerance: of order 4 and of order 2.
GROW, GROW_DAMPED = 64.0, 12.0
#: Velocity, as a share of that before the step, from which it is a straight line to the instant of
#: the stop, and looks for that instant.
CLOSE, LOOKS = 1e-4, 8
#: Stops in one step after which an axis creeps along a jump of its friction: backward Euler does.
STOPS = 6
#: Breakaway is located to this share of an interval, in so many looks at most.
INSTANT, MOST = 1e-13, 60
#: Where `memory` keeps how steeply friction rose in half a step and in a whole one, the rate at
#: which it lets a velocity decay, 1/s, the square of that at which bristles swing, rad²/s², and the
#: impulse beyond its level at a slide at rest, N s.
SLOPE, SLOPE_COARSE, DECAY, SPRING, PUSH = range(5)
MEMORY = 5
#: What is left of an interval that is none, as a share.
_NONE = 1e-12


@compiled(forceinline=True)
def _step(
    slip: Any, rub: Any, general: bool, states: int, kind: int, p: Array, term: Array, c: Array,
    u: Array, span: float, h: float, q: float, v: float, guess: float, z: Array, load: Array,
    out: Array, memory: Array, at: int,
) -> float:  # fmt: skip
    """The velocity after a span, the share θ of h, under the inputs u there; states after h."""
    w = guess
    loaded = (general and states == 0) or term[0] >= 0 or term[1] >= 0
    for _ in range(2 if loaded else 1):  # loads are those at the velocity that is looked for
        q_near = q + span * w
        mass, F, d, k = driven(kind, c, u, q_near, w, load)
        scale = terms_factor(term, p, load)
        k = max(k, -0.5 * mass / (span * span))
        F += k * (q_near - q)
        M = mass + span * d + span * span * k
        inertia, damping, clamp, push = 0.0, 0.0, np.inf, 0.0
        if kind == SLIDE:  # the motor's, clamped: implicit, and outside a constant
            inertia, damping, clamp = c[INERTIA], c[DAMPING], c[CLAMP]
        for _clamped in range(2):  # in one place, as `solved` becomes part of each that calls it
            P = (mass + inertia) * v + span * (F - push)
            w = solved(
                slip, rub, general, states, scale, M + inertia + span * damping, P, span, w, z,
                load, p, out, memory, at,
            )  # fmt: skip
            motor = inertia * (w - v) / span + damping * w
            if not abs(motor) > clamp:
                break
            inertia, damping, push = 0.0, 0.0, np.copysign(clamp, motor)
    if states > 0:
        rub(w, h, z, load, p, out)
    return w


@compiled(forceinline=True)
def _beyond(
    slip: Any, rub: Any, general: bool, kind: int, p: Array, term: Array, c: Array, inputs: Array,
    held: Array, k: int, share: float, q: float, z: Array, load: Array, out: Array, u: Array,
    way: float, level: float,
) -> tuple[float, float, float]:  # fmt: skip
    """How far the force on an axis at rest is beyond its breakaway level, its way, and the level.

    The level that holds one way, 0 for none, is not asked for again where a law reads no loads.
    """
    mixed(inputs, held, k, share, u)
    _, F, _, _ = driven(kind, c, u, q, 0.0, load)
    heading = 1.0 if F > 0.0 else -1.0
    if heading != way or general or term[0] >= 0 or term[1] >= 0:
        scale = terms_factor(term, p, load)
        level = rubs(slip, rub, general, scale, heading * 0.0, 0.0, z, load, p, out)
    return heading * (F - level), heading, level


@compiled()
def _breakaway(
    slip: Any, rub: Any, general: bool, kind: int, p: Array, term: Array, c: Array, inputs: Array,
    held: Array, k: int, low: float, high: float, q: float, z: Array, load: Array, out: Array,
    u: Array,
) -> tuple[float, float]:  # fmt: skip
    """Share of an interval up to which an axis rests from another share on, and which way it goes.

    It is `high` where the axis rests all the time. By false position, Illinois.
    """
    g_low, way, level = _beyond(
        slip, rub, general, kind, p, term, c, inputs, held, k, low, q, z, load, out, u, 0.0, 0.0
    )
    if g_low > 0.0:
        return low, way
    middle = 0.5 * (low + high)
    g_high, way, level = _beyond(
        slip, rub, general, kind, p, term, c, inputs, held, k, middle, q, z, load, out, u, way,
        level,
    )  # fmt: skip
    if g_high > 0.0:
        high = middle
    else:
        low, g_low, end = middle, g_high, high
        g_high, way, level = _beyond(
            slip, rub, general, kind, p, term, c, inputs, held, k, end, q, z, load, out, u, way,
            level,
        )  # fmt: skip
        if not g_high > 0.0:
            return high, 0.0
    side, heading = 0, way
    for i in range(MOST):
        if high - low <= INSTANT:
            break
        share = high - g_high * (high - low) / (g_high - g_low)
        if not low < share < high or i % 3 == 2:  # noqa: PLR2004 - halved at least that often
            share = 0.5 * (low + high)
        g, heading, level = _beyond(
            slip, rub, general, kind, p, term, c, inputs, held, k, share, q, z, load, out, u,
            heading, level,
        )  # fmt: skip
        if g > 0.0:
            high, g_high, way = share, g, heading
            g_low *= 0.5 if side > 0 else 1.0
            side = 1
        else:
            low, g_low = share, g
            g_high *= 0.5 if side < 0 else 1.0
            side = -1
    return high, way


@compiled()
def _pushed(
    slip: Any, rub: Any, general: bool, kind: int, p: Array, term: Array, c: Array, inputs: Array,
    held: Array, k: int, low: float, high: float, span: float, q: float, z: Array, load: Array,
    out: Array, u: Array, memory: Array,
) -> float:  # fmt: skip
    """The way in which a slide leaves rest within a span, between two shares of an interval.

    It is 0 where it rests, and the impulse beyond its level is kept.
    """
    g_low, way, _ = _beyond(
        slip, rub, general, kind, p, term, c, inputs, held, k, low, q, z, load, out, u, 0.0, 0.0
    )
    impulse = memory[PUSH] + 0.5 * span * way * max(g_low, 0.0)
    g_high, way, _ = _beyond(
        slip, rub, general, kind, p, term, c, inputs, held, k, high, q, z, load, out, u, 0.0, 0.0
    )
    if g_high <= 0.0:  # at the end it is held
        memory[PUSH] = 0.0
        return 0.0
    impulse += 0.5 * span * way * g_high
    if abs(impulse) >= c[IMPULSE]:
        return np.copysign(1.0, impulse)  # type: ignore[no-any-return]
    memory[PUSH] = impulse
    return 0.0


@compiled(inline="always")
def _keep_rates(memory: Array, states: int, mass: float, theta: float, h: float) -> None:
    """Keep how friction resists and springs back, as the slopes of a step that was tried show.

    Over a span a slope is that of viscous friction and the span times the stiffness of bristles.
    """
    slope, coarse = memory[SLOPE], memory[SLOPE_COARSE]
    if slope == 0.0 or coarse == 0.0:  # unknown
        return
    if states > 0:
        memory[SPRING] = max((coarse - slope) / (0.5 * theta * h * mass), 0.0)
        slope -= coarse - slope
    memory[DECAY] = slope / mass


@compiled(inline="always")
def _share(memory: Array, h: float) -> float:
    """The θ of a step under bristles that swing: it damps what extrapolation would let grow."""
    square = memory[SPRING] * h * h
    return min(0.5 + SWING * square * square, 1.0)  # type: ignore[no-any-return]


@compiled(forceinline=True)
def _halved(level: int, piece: float) -> int:
    """The level of steps of half a piece, or shorter."""
    level += 1
    while level < FINEST and 0.5**level > 0.51 * piece:
        level += 1
    return level


@compiled(inline="always")
def _pair(
    slip: Any, rub: Any, general: bool, states: int, kind: int, p: Array, term: Array, c: Array,
    inputs: Array, held: Array, k: int, begin: float, share: float, h: float, theta: float,
    q: float, v: float, a_0: float, z: Array, coarse: Array, half: Array, fine: Array, u: Array,
    load: Array, memory: Array,
) -> tuple[float, float, float]:  # fmt: skip
    """The velocities w of a step of h and of two of half its length, a share of an interval."""
    shift = theta * h
    mixed(inputs, held, k, begin + theta * share, u)
    w_c = _step(
        slip, rub, general, states, kind, p, term, c, u, shift, h, q, v, v + shift * a_0, z, load,
        coarse, memory, SLOPE_COARSE,
    )  # fmt: skip
    mixed(inputs, held, k, begin + 0.5 * theta * share, u)
    w_1 = _step(
        slip, rub, general, states, kind, p, term, c, u, 0.5 * shift, 0.5 * h, q, v,
        0.5 * (v + w_c), z, load, half, memory, SLOPE,
    )  # fmt: skip
    mixed(inputs, held, k, begin + 0.5 * (1.0 + theta) * share, u)
    w_2 = _step(
        slip, rub, general, states, kind, p, term, c, u, 0.5 * shift, 0.5 * h, q + 0.5 * h * w_1,
        v + (w_1 - v) / theta, 2.0 * w_c - w_1 if theta < 1.0 else w_c, half, load, fine, memory,
        SLOPE,
    )  # fmt: skip
    return w_c, w_1, w_2


@compiled(inline="always")
def _defect(
    slip: Any, rub: Any, general: bool, kind: int, p: Array, term: Array, c: Array, inputs: Array,
    held: Array, k: int, begin: float, share: float, h: float, base: float, way: float, q: float,
    v: float, a_0: float, q_1: float, v_1: float, middle: Array, end: Array, load: Array,
    out: Array, u: Array,
) -> tuple[float, float]:  # fmt: skip
    """By what Simpson's rule is off a step, m or rad, and the acceleration at its end."""
    mixed(inputs, held, k, begin + share, u)
    v_end = v_1 if way * v_1 > 0.0 or way == 0.0 else np.copysign(0.0, way)
    a_1 = acceleration(slip, rub, general, kind, p, term, c, u, q_1, v_end, end, load, out)
    v_m = 0.5 * (v + v_1) + 0.125 * h * (a_0 - a_1)
    q_m = 0.5 * (q + q_1) + 0.125 * h * (v - v_1)
    mixed(inputs, held, k, begin + 0.5 * share, u)
    a_m = acceleration(slip, rub, general, kind, p, term, c, u, q_m, v_m, middle, load, out)
    off = base * abs(v + h * (a_0 + 4.0 * a_m + a_1) / 6.0 - v_1)
    return off + abs(q + h * (v + h * (a_0 + 2.0 * a_m) / 6.0) - q_1), a_1


@compiled(inline="always")
def passed(  # noqa: C901, PLR0912, PLR0915 - one loop of many cases
    slip: Any, rub: Any, general: bool, states: int, kind: int, p: Array, term: Array, c: Array,
    inputs: Array, held: Array, k: int, n: int, span: float, tolerance: float, banded: bool,
    q: float, v: float, z: Array, coarse: Array, half: Array, fine: Array, u: Array, load: Array,
    memory: Array, steps_left: int,
) -> tuple[float, float, int]:  # fmt: skip
    """Position and velocity after the interval that begins with sample k, and steps still left.

    It is passed in n steps and their halves; the states go on in `z`. A slide under a law without
    states may be `banded`, and then has a band of speeds in which it rests. Where no steps are left
    for all of it, position and velocity are nan.
    """
    base = span / n
    band = c[BAND] if banded else 0.0
    for j in range(n):
        at, level, stop, looks, stops, fresh, way, a_0 = 0.0, 0, 0.0, 0, 0, True, 0.0, 0.0
        mixed(inputs, held, k, j / n, u)
        mass, _, d, _ = driven(kind, c, u, q, v, load)
        damped = (memory[DECAY] + d / mass) * base > STIFF or memory[SPRING] * base * base > FAST
        quick = states == 0 and not damped
        while at < 1.0:
            if steps_left <= 0:
                return np.nan, np.nan, 0
            steps_left -= 1
            if banded and band > 0.0 and v == 0.0:
                piece = min(0.5**level, 1.0 - at)
                way = _pushed(
                    slip, rub, general, kind, p, term, c, inputs, held, k, (j + at) / n,
                    (j + at + piece) / n, base * piece, q, z, load, half, u, memory,
                )  # fmt: skip
                if way != 0.0 and level < FINEST:
                    level += 1
                    continue
                if way != 0.0:
                    v, memory[PUSH], fresh = way * band, 0.0, True
                elif level > 0:
                    level -= 1
                at += piece
                if at > 1.0 - _NONE:
                    at = 1.0
                continue
            if states == 0 and v == 0.0:
                begin, way = _breakaway(
                    slip, rub, general, kind, p, term, c, inputs, held, k, (j + at) / n,
                    (j + 1.0) / n, q, z, load, half, u,
                )  # fmt: skip
                at = begin * n - j
                if at >= 1.0 - _NONE:
                    break
                v = np.copysign(0.0, way)
            elif states == 0:
                way = np.copysign(1.0, v)
            piece = min(0.5**level, 1.0 - at)
            if 0.0 < stop < piece:
                piece = stop
            h, begin, shortest = base * piece, (j + at) / n, piece <= 0.5**FINEST
            theta = 1.0 if damped else _share(memory, h)
            if fresh:
                mixed(inputs, held, k, begin, u)
                a_0 = acceleration(slip, rub, general, kind, p, term, c, u, q, v, z, load, half)
                fresh = False
            if quick and stop == 0.0 and max(abs(memory[DECAY]), d / mass) * h <= MILD:
                q_1, v_1, a_1, error, rate = explicit_step(
                    slip, rub, general, kind, p, term, c, inputs, held, k, begin, piece / n, h,
                    base, way, band, q, v, a_0, tolerance, half, load, coarse, u,
                )  # fmt: skip
                rate -= d / mass
                if way * v_1 > band and error <= tolerance and abs(rate) * h <= MILD:
                    q, v, a_0, at, memory[DECAY] = q_1, v_1, a_1, at + piece, rate
                    if at > 1.0 - _NONE:
                        at = 1.0
                    if not (abs(q) < 1e12 and abs(v) < 1e12):  # noqa: PLR2004
                        return q, v, steps_left
                    if level > 0 and error * GROW <= tolerance:
                        level -= 1
                    continue
                if tolerance < error < np.inf and abs(rate) * h <= MILD and not shortest:
                    level = _halved(level, piece)
                    continue
                quick = False
            w_c, w_1, w_2 = _pair(
                slip, rub, general, states, kind, p, term, c, inputs, held, k, begin, piece / n, h,
                theta, q, v, a_0, z, coarse, half, fine, u, load, memory,
            )  # fmt: skip
            _keep_rates(memory, states, mass, theta, h)
            v_c, v_h, weight = v + (w_c - v) / theta, v + (w_1 - v) / theta, (4.0 * theta - 1.0) / 3
            v_f, q_f = v_h + (w_2 - v_h) / theta, q + 0.5 * h * (w_1 + w_2)
            v_1, q_1, left = v_f + weight * (v_f - v_c), q_f + weight * (q_f - q - h * w_c), h
            over = v_1 - way * band  # what is left to the speed at which it stops
            if states == 0 and theta < 1.0:
                if way * w_c <= 0.0 or way * w_1 <= 0.0 or way * w_2 <= 0.0:
                    # It stops far within; or is held where a law jumps, which no halving ends.
                    level, stop, damped = _halved(level, piece), 0.0, shortest
                    if damped:
                        level = 0
                    continue
                if way * over <= 0.0 or stop > 0.0:  # how long it moves yet, on a parabola
                    left = h * over / (4.0 * v_h - v - 3.0 * v_1)
                if way * over <= 0.0 and abs(over) > CLOSE * abs(v):
                    stop, looks = piece + left / base, looks + 1
                    if not 0.0 < stop < piece:
                        stop = piece * (v - way * band) / (v - v_1)
                    if looks > LOOKS or not 0.0 < stop < piece:
                        level, stop, looks = _halved(level, piece), 0.0, 0
                    if banded and 0.0 < abs(v) <= band:  # it has hardly begun
                        v, stop = 0.0, 0.0
                    continue
            elif states == 0 and v_1 * v_f <= 0.0:  # extrapolated past the stop
                v_1 = v_f
            for i in range(states):
                difference = fine[i] - coarse[i]
                fine[i] += weight * difference
                half[i] += 0.5 * weight * difference
            if theta < 1.0:
                error, a_1 = _defect(
                    slip, rub, general, kind, p, term, c, inputs, held, k, begin, piece / n, h,
                    base, way, q, v, a_0, q_1, v_1, half, fine, load, coarse, u,
                )  # fmt: skip
            else:
                v_h += 0.5 * (v_f - v_c)
                error = h * abs(v_f - v_c) + abs(q + h * (v + 4.0 * v_h + v_1) / 6.0 - q_1)
                a_1, fresh = 0.0, True
            if not error <= tolerance and not (shortest and damped):
                level, stop, looks, fresh = _halved(level, piece), 0.0, 0, damped
                if not damped and (shortest or (memory[DECAY] + d / mass) * h > STIFF):
                    damped, level = True, 0
                continue
            if abs(left) < h and abs(over) <= CLOSE * abs(v):  # to the instant at which it stops
                q_1, piece = q_1 + 0.5 * left * over, min(piece + left / base, 1.0 - at)
                v_1, stops = 0.0, stops + 1
                if stops > STOPS:
                    damped = True
            elif banded and abs(v_1) <= band:
                v_1 = 0.0
            q, v, a_0, at, stop, looks = q_1, v_1, a_1, at + piece, 0.0, 0
            fresh = fresh or v == 0.0
            for i in range(states):
                z[i] = fine[i]
            if not (abs(q) < 1e12 and abs(v) < 1e12):  # noqa: PLR2004
                return q, v, steps_left
            if at > 1.0 - _NONE:
                at = 1.0
            if level > 0 and error * (GROW if theta < 1.0 else GROW_DAMPED) <= tolerance:
                level -= 1
    return q, v, steps_left
