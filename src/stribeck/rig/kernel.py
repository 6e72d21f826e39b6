"""The fast integrator of the slide bed: what is stuck costs nothing, what slips is exact.

While the slide is stuck only the command moves, so breakaway is found by solving for its time.
A slip is integrated by the embedded Runge-Kutta pair 5(4) of Dormand and Prince (1980, doi
10.1016/0771-050X(80)90013-3) with its continuous extension (Hairer, Norsett, Wanner, Solving
Ordinary Differential Equations I, section II.6), which gives the samples inside a step and the
instant at which the slide comes to rest. The misfit of a stuck stretch comes from prefix sums
of the measured position.
"""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numba import boolean, float64, int64, njit, types, void

from ..friction import SLIP_TYPE
from ..space import Array
from .track import Track

if TYPE_CHECKING:
    from ..friction import Law

#: Error allowed in one step: position, m; velocity, m/s, and as a share of the velocity.
TOLERANCE_X, TOLERANCE_V, TOLERANCE_V_SHARE = 1e-9, 1e-8, 1e-5
#: Steps after which a candidate is given up (its cost is then not finite), and what each knot of
#: the command adds to them: a log's noisy command may have millions.
MOST_STEPS, MOST_STEPS_A_KNOT = 1_000_000, 20
#: The first step of a slip, s.
FIRST_STEP = 1e-4

#: Columns of the constants that one candidate is simulated with, all SI. K_HAT and K_SPRING
#: stand twice: for a stretch e > 0 (the drive pulls rightward) and for e < 0.
MASS, K_HAT_P, K_HAT_M, K_SPRING_P, K_SPRING_M, F_FM, INERTIA, DAMPING, CLAMP, BAND = range(10)

_F1 = types.Array(float64, 1, "C", readonly=True)
_F2 = types.Array(float64, 2, "C", readonly=True)
_W1 = float64[::1]
_W2 = float64[:, ::1]


def from_zero(on: Track) -> Track:
    """The same track on a clock that starts with it: seconds since 1970 leave no digits."""
    return on._replace(t=on.t - on.t[0], knots_t=on.knots_t - on.t[0])


@njit(float64(float64, _F1), cache=True, error_model="numpy")
def drive_force(e: float, c: Array) -> float:
    """Spring force plus what the motor's own friction leaves of its force (section 4.3, 1-4)."""
    if e > 0.0:
        return c[K_SPRING_P] * e + max(c[K_HAT_P] * e - c[F_FM], 0.0)  # type: ignore[no-any-return]
    return c[K_SPRING_M] * e + min(c[K_HAT_M] * e + c[F_FM], 0.0)  # type: ignore[no-any-return]


@njit(float64(float64, float64, float64, float64), cache=True, error_model="numpy")
def stretch_at(level: float, k_hat: float, k_spring: float, F_fm: float) -> float:
    """The stretch at which the drive force reaches a level (both as magnitudes); inf if never."""
    if k_spring > 0.0 and level * k_hat <= F_fm * k_spring:
        return level / k_spring
    if k_hat + k_spring > 0.0:
        return (level + F_fm) / (k_hat + k_spring)
    return np.inf


class Piece(NamedTuple):
    """Where the slipping slide obeys one smooth law: a = (offset + slope e - F_f - damping v) / m.

    Args:
        offset: N; holds the motor's own friction, and the clamped force where it is clamped.
        slope: N/m.
        damping: N s/m; nothing while the motor's inertia force is clamped.
        mass: kg, with the motor's reflected inertia unless its force is clamped.
        e_low: Least stretch at which this piece holds, m.
        e_high: Greatest.
        clamped: +1.0 or -1.0 while the motor's inertia force is at its clamp, else 0.0.
    """

    offset: float
    slope: float
    damping: float
    mass: float
    e_low: float
    e_high: float
    clamped: float


class Step(NamedTuple):
    """A Runge-Kutta step of length h from stretch e and velocity v, with its polynomials.

    Position and velocity inside it are y(theta) = y + theta (dy + (1 - theta) (b + theta (q +
    (1 - theta) r))), theta from 0 to 1 (the continuous extension).
    """

    h: float
    rate: float
    e: float
    v: float
    dx: float
    bx: float
    qx: float
    rx: float
    dv: float
    bv: float
    qv: float
    rv: float
    last: float
    error_x: float
    error_v: float


@njit(cache=True, error_model="numpy")
def _piece(c: Array, e: float, clamped: float) -> Piece:
    """The piece in force at a stretch, with the motor clamped (+1.0, -1.0) or not (0.0)."""
    if e > 0.0:
        slope, offset, e_low = c[K_SPRING_P], 0.0, 0.0
        e_high = c[F_FM] / c[K_HAT_P] if c[K_HAT_P] > 0.0 else np.inf
        if e > e_high:
            slope, offset, e_low, e_high = slope + c[K_HAT_P], -c[F_FM], e_high, np.inf
    else:
        slope, offset, e_high = c[K_SPRING_M], 0.0, 0.0
        e_low = -c[F_FM] / c[K_HAT_M] if c[K_HAT_M] > 0.0 else -np.inf
        if e < e_low:
            slope, offset, e_low, e_high = slope + c[K_HAT_M], c[F_FM], -np.inf, e_low
    if clamped != 0.0:
        return Piece(offset - clamped * c[CLAMP], slope, 0.0, c[MASS], e_low, e_high, clamped)
    return Piece(offset, slope, c[DAMPING], c[MASS] + c[INERTIA], e_low, e_high, 0.0)


@njit(cache=True, error_model="numpy")
def _motor_force(slip: Any, p: Array, c: Array, e: float, v: float, s: float) -> float:
    """The unclamped inertia and damping force of the motor in slip."""
    return _motor(drive_force(e, c) - slip(v if v * s > 0.0 else s * 0.0, p), v, c)  # type: ignore[no-any-return]


@njit(cache=True, error_model="numpy")
def _motor(force: float, v: float, c: Array) -> float:
    """What it takes to move the motor, unclamped: F_m = K_J a + K_D v with a solved for.

    Of m a = force - K_J a - K_D v the acceleration is a = (force - K_D v) / (m + K_J).
    """
    a = (force - c[DAMPING] * v) / (c[MASS] + c[INERTIA])
    return c[INERTIA] * a + c[DAMPING] * v  # type: ignore[no-any-return]


@njit(cache=True, inline="always", error_model="numpy")
def _acceleration(slip: Any, p: Array, e: float, v: float, s: float, on: Piece) -> float:
    """Acceleration in slip in direction s.

    Friction keeps its side of zero speed, so that the right-hand side is smooth through the
    end of a slip and the instant of rest can be found on the polynomial of the step.
    """
    friction = slip(v if v * s > 0.0 else s * 0.0, p)
    return (on.offset + on.slope * e - friction - on.damping * v) / on.mass  # type: ignore[no-any-return]


@njit(types.UniTuple(float64, 3)(_F1, _F1, int64, float64), cache=True, error_model="numpy")
def _command(knots_t: Array, knots_x: Array, j: int, now: float) -> tuple[float, float, float]:
    """The command now, its rate, and until when that rate holds; j counts the knots passed."""
    if j == 0:
        return knots_x[0], 0.0, knots_t[0]
    if j == len(knots_t):
        return knots_x[j - 1], 0.0, np.inf
    rate = (knots_x[j] - knots_x[j - 1]) / (knots_t[j] - knots_t[j - 1])
    return knots_x[j - 1] + rate * (now - knots_t[j - 1]), rate, knots_t[j]


@njit(float64(float64, float64), cache=True, error_model="numpy")
def _after(now: float, span: float) -> float:
    """A span from now, and later than now even where the span is lost in its last digit."""
    return max(now + span, np.nextafter(now, np.inf))  # type: ignore[no-any-return]


@njit(
    types.Tuple((float64, float64, int64))(
        _F1, _F1, _F1, int64, float64, float64, float64, float64, float64, float64
    ),
    cache=True,
    error_model="numpy",
)
def _breakaway(
    c: Array,
    knots_t: Array,
    knots_x: Array,
    j: int,
    now: float,
    x: float,
    level_m: float,
    level_p: float,
    reach_m: float,
    reach_p: float,
) -> tuple[float, float, int]:
    """When and in which direction the stuck slide starts to move, and the knots passed by then.

    The force must exceed its level until the momentum of section 4.3, step 5, has grown out of
    its dead band: |P| = m dv. The motor's inertia takes part, so that the impulse it takes is
    (m + K_kt J_m) dv; P is kept as a velocity here, the impulse over the mass that takes it.
    While the slide is stuck force and impulse are known in closed form.
    """
    P, side = 0.0, 0.0
    while True:
        while j < len(knots_t) and knots_t[j] <= now:
            j += 1
        xi, rate, end = _command(knots_t, knots_x, j, now)
        e = xi - x
        if side == 0.0:  # inside the stick band: wait until the stretch reaches an edge of it
            if e >= reach_p or e <= reach_m:
                side = 1.0 if e >= reach_p else -1.0
            else:
                wait = np.inf
                if rate > 0.0:
                    wait, side = (reach_p - e) / rate, 1.0
                elif rate < 0.0:
                    wait, side = (reach_m - e) / rate, -1.0
                if now + wait >= end:
                    side = 0.0
                    if end == np.inf:
                        return np.inf, 0.0, j
                    now = end
                else:
                    now += wait
                continue
        if c[BAND] <= 0.0:
            return now, side, j
        # Beyond the edge: the excess force is linear in time until the drive force bends, the
        # motor's inertia force meets its clamp, or the command has a corner.
        level = level_p if side > 0.0 else level_m
        excess = max(side * (drive_force(e, c) - level), 0.0)
        k_hat = c[K_HAT_P] if side > 0.0 else c[K_HAT_M]
        slope = c[K_SPRING_P] if side > 0.0 else c[K_SPRING_M]
        bend = c[F_FM] / k_hat if k_hat > 0.0 else np.inf
        pull = side * rate  # how fast the stretch grows
        span = end - now
        if abs(e) > bend or (abs(e) == bend and pull > 0.0):
            slope += k_hat
            if pull < 0.0:
                span = min(span, (bend - abs(e)) / pull + 1e-12)
        elif pull > 0.0:
            span = min(span, (bend - abs(e)) / pull + 1e-12)
        growth = pull * slope
        push, heavy = excess, c[MASS] + c[INERTIA]
        if c[INERTIA] > 0.0:
            most = c[CLAMP] * heavy / c[INERTIA]  # beyond it the motor's inertia force is clamped
            clamped = excess > most or (excess == most and growth > 0.0)
            if (most - excess) * growth > 0.0:
                span = min(span, (most - excess) / growth + 1e-12)
            if clamped:
                push, heavy = excess - c[CLAMP], c[MASS]
        if growth < 0.0:
            span = min(span, -excess / growth)
        need = heavy * (c[BAND] - P)
        root = push * push + 2.0 * growth * need
        wait = np.inf
        if root >= 0.0 and push + np.sqrt(root) > 0.0:
            wait = 2.0 * need / (push + np.sqrt(root))
        if wait <= span:
            return now + wait, side, j
        if span == np.inf:
            return np.inf, 0.0, j
        P += (push + 0.5 * growth * span) * span / heavy
        now = _after(now, span)
        if growth < 0.0 and excess + growth * span <= 1e-12 * abs(level_p - level_m):
            P, side = 0.0, 0.0  # the force fell back into the stick band
            now = _after(now, 1e-9)


@njit(cache=True, error_model="numpy")
def _step(
    slip: Any, p: Array, on: Piece, e: float, v: float, rate: float, s: float, h: float, k1: float
) -> Step:
    """One Dormand-Prince step under a command that moves at `rate`; k1 is the acceleration."""
    v2 = v + h * (0.2 * k1)
    k2 = _acceleration(slip, p, e + h * (0.2 * rate - 0.2 * v), v2, s, on)
    v3 = v + h * (3 / 40 * k1 + 9 / 40 * k2)
    e3 = e + h * (0.3 * rate - (3 / 40 * v + 9 / 40 * v2))
    k3 = _acceleration(slip, p, e3, v3, s, on)
    v4 = v + h * (44 / 45 * k1 - 56 / 15 * k2 + 32 / 9 * k3)
    e4 = e + h * (0.8 * rate - (44 / 45 * v - 56 / 15 * v2 + 32 / 9 * v3))
    k4 = _acceleration(slip, p, e4, v4, s, on)
    a1, a2, a3, a4 = 19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729
    v5 = v + h * (a1 * k1 + a2 * k2 + a3 * k3 + a4 * k4)
    e5 = e + h * (8 / 9 * rate - (a1 * v + a2 * v2 + a3 * v3 + a4 * v4))
    k5 = _acceleration(slip, p, e5, v5, s, on)
    b1, b2, b3, b4, b5 = 9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656
    v6 = v + h * (b1 * k1 + b2 * k2 + b3 * k3 + b4 * k4 + b5 * k5)
    e6 = e + h * (rate - (b1 * v + b2 * v2 + b3 * v3 + b4 * v4 + b5 * v5))
    k6 = _acceleration(slip, p, e6, v6, s, on)
    w1, w3, w4, w5, w6 = 35 / 384, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84
    dv = h * (w1 * k1 + w3 * k3 + w4 * k4 + w5 * k5 + w6 * k6)
    dx = h * (w1 * v + w3 * v3 + w4 * v4 + w5 * v5 + w6 * v6)
    v7 = v + dv
    k7 = _acceleration(slip, p, e + h * rate - dx, v7, s, on)
    d1, d3, d4, d5 = 71 / 57600, -71 / 16695, 71 / 1920, -17253 / 339200
    d6, d7 = 22 / 525, -1 / 40
    error_x = h * (d1 * v + d3 * v3 + d4 * v4 + d5 * v5 + d6 * v6 + d7 * v7)
    error_v = h * (d1 * k1 + d3 * k3 + d4 * k4 + d5 * k5 + d6 * k6 + d7 * k7)
    r1, r3, r4 = -12715105075 / 11282082432, 87487479700 / 32700410799, -10690763975 / 1880347072
    r5, r6, r7 = 701980252875 / 199316789632, -1453857185 / 822651844, 69997945 / 29380423
    rx = h * (r1 * v + r3 * v3 + r4 * v4 + r5 * v5 + r6 * v6 + r7 * v7)
    rv = h * (r1 * k1 + r3 * k3 + r4 * k4 + r5 * k5 + r6 * k6 + r7 * k7)
    bx, bv = h * v - dx, h * k1 - dv
    qx, qv = dx - h * v7 - bx, dv - h * k7 - bv
    return Step(h, rate, e, v, dx, bx, qx, rx, dv, bv, qv, rv, k7, error_x, error_v)


@njit(cache=True, error_model="numpy")
def _travel(step: Step, theta: float) -> float:
    """Distance moved since the start of a step."""
    w = 1.0 - theta
    return theta * (step.dx + w * (step.bx + theta * (step.qx + w * step.rx)))


@njit(cache=True, error_model="numpy")
def _speed(step: Step, theta: float) -> float:
    """Velocity inside a step."""
    w = 1.0 - theta
    return step.v + theta * (step.dv + w * (step.bv + theta * (step.qv + w * step.rv)))


@njit(cache=True, error_model="numpy")
def _pace(step: Step, theta: float) -> float:
    """Acceleration inside a step: the derivative of its velocity polynomial."""
    w = 1.0 - theta
    inner = step.qv + w * step.rv
    outer = step.bv + theta * inner
    slope = step.dv + (w - theta) * outer + theta * w * (inner - theta * step.rv)
    return slope / step.h


#: What can end a piece of a slip: rest, a bend of the drive force on either side of it, the clamp
#: of the motor.
_REST, _LOW, _HIGH, _CLAMP = 0, 1, 2, 3


@njit(cache=True, error_model="numpy")
def _margin(kind: int, theta: float, c: Array, s: float, on: Piece, step: Step) -> float:
    """How far a step is, at theta, from leaving its piece: negative beyond the edge."""
    v = _speed(step, theta)
    if kind == _REST:
        return s * v - c[BAND]  # type: ignore[no-any-return]
    if kind in (_LOW, _HIGH):
        e = step.e + theta * step.h * step.rate - _travel(step, theta)
        return e - on.e_low if kind == _LOW else on.e_high - e  # type: ignore[no-any-return]
    net = on.mass * _pace(step, theta) + on.damping * v + on.clamped * c[CLAMP]
    motor = _motor(net, v, c)
    return c[CLAMP] - abs(motor) if on.clamped == 0.0 else on.clamped * motor - c[CLAMP]  # type: ignore[no-any-return]


@njit(cache=True, error_model="numpy")
def _crossing(
    kind: int, low: float, high: float, f_high: float, c: Array, s: float, on: Piece, step: Step
) -> float:
    """Where in [low, high] the margin falls to zero: regula falsi with the Illinois rule."""
    f_low = _margin(kind, low, c, s, on, step)
    if f_low <= 0.0:
        return low
    side = 0
    while high - low > 1e-12:
        theta = (low * f_high - high * f_low) / (f_high - f_low)
        theta = min(max(theta, low + 5e-13), high - 5e-13)
        f = _margin(kind, theta, c, s, on, step)
        if f > 0.0:
            low, f_low = theta, f
            if side == 1:
                f_high *= 0.5
            side = 1
        else:
            high, f_high = theta, f
            if side == -1:
                f_low *= 0.5
            side = -1
    return high


@njit(cache=True, error_model="numpy")
def _piece_end(c: Array, s: float, on: Piece, step: Step) -> tuple[float, int]:
    """The theta at which a step leaves its piece, and how; (1.0, -1) if it stays inside."""
    theta, how = 1.0, -1
    for kind in range(4):
        # Each edge of the stretch by itself: a step that starts on one may leave by the other.
        if (kind == _LOW and on.e_low == -np.inf) or (kind == _HIGH and on.e_high == np.inf):
            continue
        before = 0.0
        for probe in (0.25, 0.5, 0.75, 1.0):
            if before >= theta:
                break
            f = _margin(kind, probe, c, s, on, step)
            if f < 0.0:
                found = _crossing(kind, before, probe, f, c, s, on, step)
                if found < theta or how < 0:
                    theta, how = found, kind
                break
            before = probe
    return theta, how


@njit(boolean(_F1), cache=True, error_model="numpy")
def _possible(c: Array) -> bool:
    """Whether constants can be simulated: a mass, and nothing below zero or undefined."""
    for k in range(len(c)):
        unlimited = k in (F_FM, CLAMP)
        if not (c[k] >= 0.0 and (c[k] < np.inf or unlimited)):
            return False
    return c[MASS] > 0.0  # type: ignore[no-any-return]


@njit(
    float64(SLIP_TYPE, _F1, _F1, _F1, _F1, _F1, float64, _F1, _F1, _F2, _W1, _W1, boolean, float64),
    cache=True,
    nogil=True,
    error_model="numpy",
)
def _walk(
    slip: Any,
    p: Array,
    c: Array,
    knots_t: Array,
    knots_x: Array,
    t: Array,
    x0: float,
    measured: Array,
    score: Array,
    sums: Array,
    out_x: Array,
    out_v: Array,
    store: bool,
    tolerance: float,
) -> float:
    """Simulate one candidate over one track; return its sum of squared misfits, m^2."""
    level_p, level_m = slip(0.0, p), slip(-0.0, p)
    if not (0.0 <= level_p < np.inf and -np.inf < level_m <= 0.0 and _possible(c)):
        return np.nan
    reach_p = stretch_at(level_p, c[K_HAT_P], c[K_SPRING_P], c[F_FM])
    reach_m = -stretch_at(-level_m, c[K_HAT_M], c[K_SPRING_M], c[F_FM])
    n, band = len(t), c[BAND]
    now, x = t[0], x0
    i, j = 0, 0  # samples done, command knots passed
    sse, steps, most = 0.0, 0, MOST_STEPS + MOST_STEPS_A_KNOT * len(knots_t)
    while True:
        # --- stuck, until the command has pulled the slide loose ---
        now, s, j = _breakaway(
            c, knots_t, knots_x, j, now, x, level_m, level_p, reach_m, reach_p
        )  # fmt: skip
        first = i
        while i < n and t[i] <= now:
            if store:
                out_x[i], out_v[i] = x, 0.0
            i += 1
        d = x - x0
        sse += (sums[2, i] - sums[2, first]) - 2.0 * d * (sums[1, i] - sums[1, first])
        sse += d * d * (sums[0, i] - sums[0, first])
        if i == n:
            return sse  # type: ignore[no-any-return]
        # --- slip, until the slide comes to rest ---
        v, wish = s * band, FIRST_STEP
        xi, rate, end = _command(knots_t, knots_x, j, now)
        motor = _motor_force(slip, p, c, xi - x, v, s)
        clamped = 0.0 if abs(motor) <= c[CLAMP] else (1.0 if motor > 0.0 else -1.0)
        on = _piece(c, xi - x, clamped)
        k1 = _acceleration(slip, p, xi - x, v, s, on)
        while s != 0.0 and i < n:
            while j < len(knots_t) and knots_t[j] <= now:
                j += 1
            xi, rate, end = _command(knots_t, knots_x, j, now)
            e = xi - x
            while True:
                steps += 1
                h = min(wish, end - now)  # the command has a corner there
                step = _step(slip, p, on, e, v, rate, s, h, k1)
                error = max(
                    abs(step.error_x) / TOLERANCE_X,
                    abs(step.error_v) / (TOLERANCE_V + TOLERANCE_V_SHARE * abs(v)),
                )
                error /= tolerance
                if not np.isfinite(error) or steps > most:
                    return np.nan
                factor = 5.0 if error < 1e-4 else min(5.0, max(0.2, 0.9 * error**-0.2))
                if error <= 1.0:
                    break
                wish = h * factor
            theta, how = _piece_end(c, s, on, step)
            until = now + theta * h
            while i < n and t[i] <= until:
                u = (t[i] - now) / h
                xs = x + _travel(step, u)
                if store:
                    out_x[i], out_v[i] = xs, _speed(step, u)
                miss = measured[i] - xs
                sse += score[i] * miss * miss
                i += 1
            x += _travel(step, theta)
            v, k1 = _speed(step, theta), step.last
            if how == _REST:
                s = 0.0
            if how >= 0:
                until = max(until, _after(now, 1e-10))  # time goes on whatever happens
                xi, rate, end = _command(knots_t, knots_x, j, until)
                if how == _CLAMP:
                    motor = _motor_force(slip, p, c, xi - x, v, s)
                    clamped = 0.0 if clamped != 0.0 else (1.0 if motor > 0.0 else -1.0)
                nudge = (rate - v) * 1e-9  # onto the far side of a bend
                on = _piece(c, xi - x + nudge, clamped)
                k1 = _acceleration(slip, p, xi - x, v, s, on)
            now = until
            wish = max(wish, h * factor)


@njit(
    void(
        SLIP_TYPE, _F2, _F2, _F1, _F1, _F1, float64, _F1, _F1, _F2, _W2, _W2, _W1, boolean,
        float64, int64, int64,
    ),
    cache=True,
    nogil=True,
    error_model="numpy",
)  # fmt: skip
def _rows(
    slip: Any,
    p: Array,
    c: Array,
    knots_t: Array,
    knots_x: Array,
    t: Array,
    x0: float,
    measured: Array,
    score: Array,
    sums: Array,
    out_x: Array,
    out_v: Array,
    sse: Array,
    store: bool,
    tolerance: float,
    begin: int,
    end: int,
) -> None:
    for row in range(begin, end):
        k = row if store else 0
        sse[row] = _walk(
            slip, p[row], c[row], knots_t, knots_x, t, x0, measured, score, sums,
            out_x[k], out_v[k], store, tolerance,
        )  # fmt: skip


def threads() -> int:
    """How many threads share the candidates: the cores there are, or OMP_NUM_THREADS if fewer."""
    n = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    told = os.environ.get("OMP_NUM_THREADS", "")  # how one tells a program that it is not alone
    return min(n, int(told)) if told.isdecimal() and int(told) > 0 else n


@cache
def _workers() -> tuple[ThreadPoolExecutor, int]:
    n = threads()
    return ThreadPoolExecutor(n, thread_name_prefix="stribeck"), n


if hasattr(os, "register_at_fork"):  # a child has none of its parent's threads
    os.register_at_fork(after_in_child=_workers.cache_clear)


def _spread(law: Law, p: Array, c: Array, on: Track, arguments: tuple[Any, ...]) -> None:
    """Run all rows, dealt out over the cores; no result depends on how they are dealt."""
    on = from_zero(on)
    pool, n = _workers()
    chunk = max(4, -(-len(p) // (4 * n)))
    cuts = range(0, len(p), chunk)
    if n == 1 or len(cuts) == 1:
        _rows(law.slip, p, c, *on, *arguments, 0, len(p))
        return
    before = (law.slip, p, c, *on, *arguments)
    for job in [pool.submit(_some, before, a, min(a + chunk, len(p))) for a in cuts]:
        job.result()


def _some(before: tuple[Any, ...], begin: int, end: int) -> None:
    _rows(*before, begin, end)


def misfits(law: Law, p: Array, c: Array, on: Track, tolerance: float = 1.0) -> Array:
    """Sums of squared position misfits, m^2, of (n, k) law parameters with (n, 10) constants.

    A candidate whose simulation fails has nan. `tolerance` scales the error allowed in a step.
    """
    sse, nothing = np.empty(len(p)), np.empty((1, 0))
    if len(p):
        _spread(law, _rows_of(p), _rows_of(c), on, (nothing, nothing, sse, False, tolerance))
    return sse


def trajectories(
    law: Law, p: Array, c: Array, on: Track, tolerance: float = 1.0
) -> tuple[Array, Array]:
    """Positions and velocities, (n, N) each, of (n, k) law parameters with (n, 10) constants."""
    x, v = np.full((2, len(p), len(on.t)), np.nan)
    if len(p):
        _spread(law, _rows_of(p), _rows_of(c), on, (x, v, np.empty(len(p)), True, tolerance))
    return x, v


def _rows_of(a: Any) -> Array:
    return np.ascontiguousarray(a, dtype=float)
