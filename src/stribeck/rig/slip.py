"""One slip of the slide bed: from breakaway to rest, in as few steps as its tolerance allows.

While it slips the slide obeys m a = offset + slope e - F_f(v) - damping v with the stretch e,
de/dt = rate - v: an equation that does not name the time. It is integrated by the embedded
Runge-Kutta pair 5(4) of Tsitouras (2011, doi 10.1016/j.camwa.2011.06.002). Position inside a step
is the quintic that has position, velocity and acceleration at both its ends; velocity is its
derivative. Where the equation has a corner (the end of the motor's dead zone, its clamp) and at
rest the step is cut. A step without a corner is told by the control points of the quintic, which
enclose it.
"""
# ruff: noqa: PLR2004 - coefficients of the method

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import float64, njit, types

from ..space import Array

#: Error allowed in one step: position, m; velocity, m/s, and as a share of the velocity.
TOLERANCE_X, TOLERANCE_V, TOLERANCE_V_SHARE = 1e-9, 1e-8, 1e-5
#: Steps of one leg of a slip at most: so many rows has a path.
LEG = 128
#: Columns of a path, a row a step: when it begins and ends (s since the leg began), its length
#: before it was cut, and the travel in it, m, by powers of the share of the step.
BEGIN, END, LENGTH, TRAVEL = 0, 1, 2, 3
WIDTH = TRAVEL + 6

#: Columns of the constants that one candidate is simulated with, all SI. K_HAT and K_SPRING
#: stand twice: for a stretch e > 0 (the drive pulls rightward) and for e < 0.
MASS, K_HAT_P, K_HAT_M, K_SPRING_P, K_SPRING_M, F_FM, INERTIA, DAMPING, CLAMP, BAND = range(10)

#: How a leg ends: at its time limit, at rest, or (a failure) with numbers that are none.
LIMIT, REST, FAILED = 0, 1, 2

_F1 = types.Array(float64, 1, "C", readonly=True)


@njit(float64(float64, _F1), cache=True, error_model="numpy")
def drive_force(e: float, c: Array) -> float:
    """Spring force plus what the motor's own friction leaves of its force (section 4.3, 1-4)."""
    if e > 0.0:
        return c[K_SPRING_P] * e + max(c[K_HAT_P] * e - c[F_FM], 0.0)  # type: ignore[no-any-return]
    return c[K_SPRING_M] * e + min(c[K_HAT_M] * e + c[F_FM], 0.0)  # type: ignore[no-any-return]


class Piece(NamedTuple):
    """Where the slipping slide obeys one smooth law: a = offset + slope e - inverse F_f - damping v.

    Args:
        offset: m/s^2; holds the motor's own friction, and the clamped force where it is clamped.
        slope: 1/s^2.
        damping: 1/s; nothing while the motor's inertia force is clamped.
        inverse: One over the mass, 1/kg, with the motor's reflected inertia unless it is clamped.
        e_low: Least stretch at which this piece holds, m.
        e_high: Greatest.
        clamped: +1.0 or -1.0 while the motor's inertia force is at its clamp, else 0.0.
        of_a: The motor's unclamped force by the acceleration, kg.
        of_v: The same by the velocity, N s/m.
        of_1: And what is left, N.
    """

    offset: float
    slope: float
    damping: float
    inverse: float
    e_low: float
    e_high: float
    clamped: float
    of_a: float
    of_v: float
    of_1: float


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
        # The unclamped force would be K_J a' + K_D v of a' = (m a + clamp - K_D v) / (m + K_J).
        share = c[INERTIA] / (c[MASS] + c[INERTIA])
        held, w = clamped * c[CLAMP], 1.0 / c[MASS]
        return Piece(
            w * (offset - held), w * slope, 0.0, w, e_low, e_high, clamped,
            share * c[MASS], (1.0 - share) * c[DAMPING], share * held,
        )  # fmt: skip
    w = 1.0 / (c[MASS] + c[INERTIA])
    return Piece(
        w * offset, w * slope, w * c[DAMPING], w, e_low, e_high, 0.0, c[INERTIA], c[DAMPING], 0.0
    )


@njit(cache=True, error_model="numpy")
def _side_of_clamp(slip: Any, p: Array, c: Array, e: float, v: float, s: float) -> float:
    """+1.0, 0.0 or -1.0: where the motor's inertia and damping force is against its clamp."""
    net = drive_force(e, c) - slip(v if v * s > 0.0 else s * 0.0, p)
    a = (net - c[DAMPING] * v) / (c[MASS] + c[INERTIA])
    motor = c[INERTIA] * a + c[DAMPING] * v
    if abs(motor) <= c[CLAMP]:
        return 0.0
    return 1.0 if motor > 0.0 else -1.0


@njit(cache=True, inline="always", error_model="numpy")
def _acceleration(slip: Any, p: Array, e: float, v: float, s: float, on: Piece) -> float:
    """Acceleration in slip in direction s.

    Friction keeps its side of zero speed, so that the right-hand side is smooth through the
    end of a slip and the instant of rest can be found on the polynomial of the step.
    """
    friction = slip(v if v * s > 0.0 else s * 0.0, p)
    return on.offset + on.slope * e - on.damping * v - on.inverse * friction


#: What can end a piece of a slip: rest, a bend of the drive force on either side of it, the clamp
#: of the motor.
_AT_REST, _LOW, _HIGH, _CLAMP = 0, 1, 2, 3


@njit(cache=True, error_model="numpy")
def _margin(
    kind: int, u: float, c: Array, s: float, on: Piece, e: float, ahead: float, row: Array
) -> float:
    """How far a step is, at a share u of it, from leaving its piece: negative beyond the edge."""
    c1, c2, c3 = row[TRAVEL + 1], row[TRAVEL + 2], row[TRAVEL + 3]
    c4, c5 = row[TRAVEL + 4], row[TRAVEL + 5]
    if kind in (_LOW, _HIGH):
        now = e + ahead * u - u * (c1 + u * (c2 + u * (c3 + u * (c4 + u * c5))))
        return now - on.e_low if kind == _LOW else on.e_high - now
    h = row[LENGTH]
    v = (c1 + u * (2 * c2 + u * (3 * c3 + u * (4 * c4 + u * 5 * c5)))) / h
    if kind == _AT_REST:
        return s * v - c[BAND]  # type: ignore[no-any-return]
    a = (2 * c2 + u * (6 * c3 + u * (12 * c4 + u * 20 * c5))) / (h * h)
    motor = on.of_a * a + on.of_v * v + on.of_1
    return c[CLAMP] - abs(motor) if on.clamped == 0.0 else on.clamped * motor - c[CLAMP]  # type: ignore[no-any-return]


@njit(cache=True, error_model="numpy")
def _crossing(
    kind: int, low: float, high: float, f_high: float,
    c: Array, s: float, on: Piece, e: float, ahead: float, row: Array,
) -> float:  # fmt: skip
    """Where in [low, high] the margin falls to zero: regula falsi with the Illinois rule."""
    f_low = _margin(kind, low, c, s, on, e, ahead, row)
    if f_low <= 0.0:
        return low
    side = 0
    while high - low > 1e-12:
        u = (low * f_high - high * f_low) / (f_high - f_low)
        u = min(max(u, low + 5e-13), high - 5e-13)
        f = _margin(kind, u, c, s, on, e, ahead, row)
        if f > 0.0:
            low, f_low = u, f
            if side == 1:
                f_high *= 0.5
            side = 1
        else:
            high, f_high = u, f
            if side == -1:
                f_low *= 0.5
            side = -1
    return high


@njit(cache=True, error_model="numpy")
def _cut(
    c: Array, s: float, on: Piece, e: float, ahead: float, row: Array
) -> tuple[float, int]:  # fmt: skip
    """The share of a step at which it leaves its piece, and how; (1.0, -1) if it stays inside."""
    theta, how = 1.0, -1
    for kind in range(4):
        # Each edge of the stretch by itself: a step that starts on one may leave by the other.
        if (kind == _LOW and on.e_low == -np.inf) or (kind == _HIGH and on.e_high == np.inf):
            continue
        before = 0.0
        for probe in (0.25, 0.5, 0.75, 1.0):
            if before >= theta:
                break
            f = _margin(kind, probe, c, s, on, e, ahead, row)
            if f < 0.0:
                found = _crossing(kind, before, probe, f, c, s, on, e, ahead, row)
                if found < theta or how < 0:
                    theta, how = found, kind
                break
            before = probe
    return theta, how


@njit(cache=True, inline="always", error_model="numpy")
def _inside(
    c: Array, s: float, on: Piece, e: float, ahead: float, dx: float,
    v: float, k1: float, w: float, k7: float, h: float,
) -> bool:  # fmt: skip
    """Whether a step certainly stays in its piece: the control points of its quintic do.

    A polynomial lies between the least and the greatest of its Bernstein coefficients.
    """
    v1, v3 = v + 0.25 * h * k1, w - 0.25 * h * k7
    v2 = 5.0 / h * dx - v - v1 - v3 - w
    slowest = min(min(s * v1, s * v2), min(s * v3, s * w))
    if slowest <= c[BAND]:
        return False
    # The slide moves one way only: the stretch lies between what the two could do alone.
    gone, back = (max(ahead, 0.0), min(ahead, 0.0)) if s < 0.0 else (ahead, ahead)
    if s > 0.0:
        gone, back = max(ahead, 0.0), min(ahead, 0.0) - dx
    else:
        gone, back = max(ahead, 0.0) - dx, min(ahead, 0.0)
    if e + back <= on.e_low or e + gone >= on.e_high:
        return False
    fast = max(max(abs(v), abs(v1)), max(max(abs(v2), abs(v3)), abs(w)))
    a1, a2 = 4.0 / h * (v2 - v1), 4.0 / h * (v3 - v2)
    if on.clamped == 0.0:
        strong = max(max(abs(k1), abs(a1)), max(abs(a2), abs(k7)))
        return on.of_a * strong + on.of_v * fast < c[CLAMP]  # type: ignore[no-any-return]
    t = on.clamped
    weak = min(min(t * k1, t * a1), min(t * a2, t * k7))
    return on.of_a * weak - on.of_v * fast + t * on.of_1 > c[CLAMP]  # type: ignore[no-any-return]


@njit(cache=True, error_model="numpy")
def leg(
    slip: Any,
    p: Array,
    c: Array,
    e: float,
    v: float,
    rate: float,
    s: float,
    span: float,
    wish: float,
    tolerance: float,
    path: Array,
) -> tuple[int, float, float, float, int, float, int]:
    """Integrate a slip in direction s while the command moves at one rate; fill its path.

    Args:
        slip: The law, its parameters and the constants follow.
        p: (k,).
        c: (10,).
        e: Stretch at the start, m.
        v: Velocity at the start, m/s.
        rate: Speed of the command, m/s.
        s: Direction of the slip, +1.0 or -1.0.
        span: How long that rate holds, s.
        wish: Length of the first step, s.
        tolerance: Scales the error allowed in a step.
        path: (LEG, WIDTH), is written.

    Returns:
        Rows written, how long the leg took, the travel, the velocity at its end, how it ended,
        the next wish, and the steps tried.
    """
    on = _piece(c, e, _side_of_clamp(slip, p, c, e, v, s))
    k1 = _acceleration(slip, p, e, v, s, on)
    now, moved, tries, m = 0.0, 0.0, 0, 0
    while m < LEG:
        h = min(wish, span - now)
        last = h == span - now
        tries += 1
        v2 = v + h * (0.161 * k1)
        k2 = _acceleration(slip, p, e + h * (0.161 * (rate - v)), v2, s, on)
        a31, a32 = -0.008480655492356989, 0.335480655492357
        v3 = v + h * (a31 * k1 + a32 * k2)
        e3 = e + h * (0.327 * rate - (a31 * v + a32 * v2))
        k3 = _acceleration(slip, p, e3, v3, s, on)
        a41, a42, a43 = 2.8971530571054935, -6.359448489975075, 4.3622954328695815
        v4 = v + h * (a41 * k1 + a42 * k2 + a43 * k3)
        e4 = e + h * (0.9 * rate - (a41 * v + a42 * v2 + a43 * v3))
        k4 = _acceleration(slip, p, e4, v4, s, on)
        a51, a52, a53 = 5.325864828439257, -11.748883564062828, 7.4955393428898365
        a54 = -0.09249506636175525
        v5 = v + h * (a51 * k1 + a52 * k2 + a53 * k3 + a54 * k4)
        e5 = e + h * (0.9800255409045097 * rate - (a51 * v + a52 * v2 + a53 * v3 + a54 * v4))
        k5 = _acceleration(slip, p, e5, v5, s, on)
        a61, a62, a63 = 5.86145544294642, -12.92096931784711, 8.159367898576159
        a64, a65 = -0.071584973281401, -0.028269050394068383
        v6 = v + h * (a61 * k1 + a62 * k2 + a63 * k3 + a64 * k4 + a65 * k5)
        e6 = e + h * (rate - (a61 * v + a62 * v2 + a63 * v3 + a64 * v4 + a65 * v5))
        k6 = _acceleration(slip, p, e6, v6, s, on)
        b1, b2, b3 = 0.09646076681806523, 0.01, 0.4798896504144996
        b4, b5, b6 = 1.379008574103742, -3.290069515436081, 2.324710524099774
        dv = h * (b1 * k1 + b2 * k2 + b3 * k3 + b4 * k4 + b5 * k5 + b6 * k6)
        dx = h * (b1 * v + b2 * v2 + b3 * v3 + b4 * v4 + b5 * v5 + b6 * v6)
        w = v + dv
        k7 = _acceleration(slip, p, e + h * rate - dx, w, s, on)
        d1, d2, d3 = -0.00178001105222577714, -0.0008164344596567469, 0.007880878010261995
        d4, d5, d6 = -0.1447110071732629, 0.5823571654525552, -0.45808210592918697
        d7 = 0.015151515151515152
        error_v = h * (d1 * k1 + d2 * k2 + d3 * k3 + d4 * k4 + d5 * k5 + d6 * k6 + d7 * k7)
        error_x = h * (d1 * v + d2 * v2 + d3 * v3 + d4 * v4 + d5 * v5 + d6 * v6 + d7 * w)
        error = max(
            abs(error_x) / TOLERANCE_X,
            abs(error_v) / (TOLERANCE_V + TOLERANCE_V_SHARE * abs(v)),
        )
        error /= tolerance
        if not error < np.inf:
            return m, now, moved, v, FAILED, wish, tries
        factor = 5.0 if error < 1e-4 else min(5.0, max(0.2, 0.9 * error**-0.2))
        if error > 1.0:
            wish = h * factor
            continue
        # --- the quintic of this step, and where it is cut ---
        c1, c2 = h * v, 0.5 * h * h * k1
        far, turn, bend = dx - c1 - c2, h * dv - 2.0 * c2, 0.5 * h * h * (k7 - k1)
        row = path[m]
        row[BEGIN], row[LENGTH] = now, h
        row[TRAVEL], row[TRAVEL + 1], row[TRAVEL + 2] = moved, c1, c2
        row[TRAVEL + 3] = 10.0 * far - 4.0 * turn + bend
        row[TRAVEL + 4] = -15.0 * far + 7.0 * turn - 2.0 * bend
        row[TRAVEL + 5] = 6.0 * far - 3.0 * turn + bend
        m += 1
        theta, how = 1.0, -1
        if not _inside(c, s, on, e, rate * h, dx, v, k1, w, k7, h):
            theta, how = _cut(c, s, on, e, rate * h, row)
        if how < 0:
            now = span if last else now + h
            row[END] = now
            moved += dx
            e += h * rate - dx
            v, k1 = w, k7
            wish = max(wish, h * factor)
            if last:
                return m, now, moved, v, LIMIT, wish, tries
            continue
        u = theta
        dx = u * (c1 + u * (c2 + u * (row[6] + u * (row[7] + u * row[8]))))
        v = (c1 + u * (2 * c2 + u * (3 * row[6] + u * (4 * row[7] + u * 5 * row[8])))) / h
        moved += dx
        e += u * h * rate - dx
        now = max(now + u * h, now + 1e-10)  # time goes on whatever happens
        row[END] = now
        if how == _AT_REST:
            return m, now, moved, v, REST, wish, tries
        if now >= span:
            return m, now, moved, v, LIMIT, wish, tries
        clamped = on.clamped
        if how == _CLAMP:
            clamped = 0.0
            if on.clamped == 0.0:
                clamped = 1.0 if _motor_pulls(slip, p, c, e, v, s) else -1.0
        nudge = (rate - v) * 1e-9  # onto the far side of a bend
        on = _piece(c, e + nudge, clamped)
        k1 = _acceleration(slip, p, e, v, s, on)
        wish = max(wish, h * factor)
    return m, now, moved, v, LIMIT, wish, tries


@njit(cache=True, error_model="numpy")
def _motor_pulls(slip: Any, p: Array, c: Array, e: float, v: float, s: float) -> bool:
    """Whether the motor's unclamped force points rightward."""
    net = drive_force(e, c) - slip(v if v * s > 0.0 else s * 0.0, p)
    return c[INERTIA] * (net - c[DAMPING] * v) / (c[MASS] + c[INERTIA]) + c[DAMPING] * v > 0.0  # type: ignore[no-any-return]
