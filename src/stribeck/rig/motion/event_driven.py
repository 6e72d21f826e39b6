"""The fast integrator of the slide bed: what is stuck costs nothing, what slips is exact.

While the slide is stuck only the command moves, so breakaway is found by solving for its time, and
the misfit of the stuck stretch comes from prefix sums of the measured position.

While it slips it obeys m a = offset + slope e - F_f(v) - damping v with the stretch e,
de/dt = rate - v. The embedded Runge-Kutta pair 5(4) of Tsitouras (2011, doi
10.1016/j.camwa.2011.06.002) integrates that. Position inside a step is the quintic that has
position, velocity and acceleration at both its ends; velocity is its derivative. Where the
equation has a corner (the end of the motor's dead zone, its clamp) and at rest the step is cut. A
step without a corner is told by the control points of its quintic, which enclose it.

What is integrated is kept as a path, and samples are read from it. The equation does not name the
time: under a ramp each slip begins as the one before did, and so is the same path, read again.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

import numpy as np
from numba import boolean, float64, int64, types, void

from ...compile_cache import compiled
from ...friction import SLIP_TYPE, addressed
from ...space import Array, contiguous
from . import row_pool
from .drives import (
    BAND,
    CLAMP,
    DAMPING,
    F_FM,
    IMPULSE,
    INERTIA,
    K_HAT_M,
    K_HAT_P,
    K_SPRING_M,
    K_SPRING_P,
    MASS,
)
from .row_pool import borrowed
from .track import RUN, Track

if TYPE_CHECKING:
    from collections.abc import Callable

    from ...friction import Law

#: Steps after which a candidate is given up (its cost is then not finite), and what each knot of
#: the command adds to them: a log's noisy command may have millions.
MOST_STEPS, MOST_STEPS_A_KNOT = 1_000_000, 20
#: Stretches at breakaway this close, m, are the same slip: far below the tolerance of a step.
SAME = 1e-12
#: Error allowed in one step: position, m; velocity, m/s, and as a share of the velocity.
TOLERANCE_X, TOLERANCE_V, TOLERANCE_V_SHARE = 1e-9, 1e-8, 1e-5
#: Steps of one leg of a slip at most: so many rows has a path.
LEG = 128
#: Columns of a path, a row a step: when it begins and ends (s since the leg began), its length
#: before it was cut, and the travel in it, m, by powers of the share of the step.
BEGIN, END, LENGTH, TRAVEL = 0, 1, 2, 3
WIDTH = TRAVEL + 6

#: How a leg ends: at its time limit, at rest, or (a failure) with numbers that are none.
LIMIT, REST, FAILED = 0, 1, 2

_F1 = types.Array(float64, 1, "C", readonly=True)
_F2 = types.Array(float64, 2, "C", readonly=True)
_W1 = float64[::1]
_W2 = float64[:, ::1]
_I1 = int64[::1]


def from_zero(track: Track) -> Track:
    """The same track on a clock that starts with it: seconds since 1970 leave no digits."""
    if track.t[0] == 0.0:
        return track
    return track._replace(t=track.t - track.t[0], knots_t=track.knots_t - track.t[0])


@compiled()
def drive_force(e: float, c: Array) -> float:
    """Spring force plus what the motor's own friction leaves of its force (section 4.3, 1-4)."""
    if e > 0.0:
        return c[K_SPRING_P] * e + max(c[K_HAT_P] * e - c[F_FM], 0.0)  # type: ignore[no-any-return]
    return c[K_SPRING_M] * e + min(c[K_HAT_M] * e + c[F_FM], 0.0)  # type: ignore[no-any-return]


@compiled()
def stretch_at(level: float, k_hat: float, k_spring: float, F_fm: float) -> float:
    """The stretch at which the drive force reaches a level (both as magnitudes); inf if never."""
    if k_spring > 0.0 and level * k_hat <= F_fm * k_spring:
        return level / k_spring
    if k_hat + k_spring > 0.0:
        return (level + F_fm) / (k_hat + k_spring)
    return np.inf


@compiled()
def command_at(knots_t: Array, knots_x: Array, j: int, time: float) -> tuple[float, float, float]:
    """The command at a time, its rate, and until when that holds; j counts the knots passed."""
    if j == 0:
        return knots_x[0], 0.0, knots_t[0]
    if j == len(knots_t):
        return knots_x[j - 1], 0.0, np.inf
    rate = (knots_x[j] - knots_x[j - 1]) / (knots_t[j] - knots_t[j - 1])
    return knots_x[j - 1] + rate * (time - knots_t[j - 1]), rate, knots_t[j]


@compiled()
def later(time: float, span: float) -> float:
    """The time after a span: later even where the span is lost in the last digit."""
    return max(time + span, np.nextafter(time, np.inf))  # type: ignore[no-any-return]


@compiled()
def _breakaway(
    c: Array,
    knots_t: Array,
    knots_x: Array,
    extremes: Array,
    j: int,
    time: float,
    x: float,
    level_m: float,
    level_p: float,
    reach_m: float,
    reach_p: float,
) -> tuple[float, float, int]:
    """When and in which direction the stuck slide starts to move, and the knots passed by then.

    The force must exceed its level until the momentum of section 4.3, step 5, has grown out of
    its dead band: |P| = dp. While the slide is stuck force and impulse are known in closed form.
    """
    P, side = 0.0, 0.0
    while True:
        while j < len(knots_t) and knots_t[j] <= time:
            j += 1
        xi, rate, end = command_at(knots_t, knots_x, j, time)
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
                if time + wait >= end:
                    side = 0.0
                    if end == np.inf:
                        return np.inf, 0.0, j
                    time = end
                    # Runs of the command that stay inside the band are passed in one go.
                    k = j // RUN
                    while (
                        j == k * RUN
                        and k < len(extremes[0])
                        and x + reach_m < extremes[0, k]
                        and extremes[1, k] < x + reach_p
                    ):
                        k += 1
                        j = min(k * RUN, len(knots_t) - 1)
                        time = knots_t[j]
                else:
                    time += wait
                continue
        if c[IMPULSE] <= 0.0:
            return time, side, j
        # Beyond the edge: the excess force is linear in time until the drive force bends or the
        # command has a corner.
        level = level_p if side > 0.0 else level_m
        excess = max(side * (drive_force(e, c) - level), 0.0)
        k_hat = c[K_HAT_P] if side > 0.0 else c[K_HAT_M]
        slope = c[K_SPRING_P] if side > 0.0 else c[K_SPRING_M]
        bend = c[F_FM] / k_hat if k_hat > 0.0 else np.inf
        pull = side * rate  # how fast the stretch grows
        span = end - time
        if abs(e) > bend or (abs(e) == bend and pull > 0.0):
            slope += k_hat
            if pull < 0.0:
                span = min(span, (bend - abs(e)) / pull + 1e-12)
        elif pull > 0.0:
            span = min(span, (bend - abs(e)) / pull + 1e-12)
        growth = pull * slope
        if growth < 0.0:
            span = min(span, -excess / growth)
        need = c[IMPULSE] - P
        root = excess * excess + 2.0 * growth * need
        wait = np.inf
        if root >= 0.0 and excess + np.sqrt(root) > 0.0:
            wait = 2.0 * need / (excess + np.sqrt(root))
        if wait <= span:
            return time + wait, side, j
        if span == np.inf:
            return np.inf, 0.0, j
        P += (excess + 0.5 * growth * span) * span
        time = later(time, span)
        if growth < 0.0 and excess + growth * span <= 1e-12 * abs(level_p - level_m):
            P, side = 0.0, 0.0  # the force fell back into the stick band
            time = later(time, 1e-9)


class Piece(NamedTuple):
    """Where one smooth law holds in slip: a = offset + slope e - damping v - inverse F_f.

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


@compiled()
def piece_at(c: Array, e: float, clamped: float, held: float) -> Piece:
    """The piece in force at a stretch, with the motor clamped (+1.0, -1.0) or not (0.0)."""
    offset = held
    if e > 0.0:
        slope, e_low = c[K_SPRING_P], 0.0
        e_high = c[F_FM] / c[K_HAT_P] if c[K_HAT_P] > 0.0 else np.inf
        if e > e_high:
            slope, offset, e_low, e_high = slope + c[K_HAT_P], held - c[F_FM], e_high, np.inf
    else:
        slope, e_high = c[K_SPRING_M], 0.0
        e_low = -c[F_FM] / c[K_HAT_M] if c[K_HAT_M] > 0.0 else -np.inf
        if e < e_low:
            slope, offset, e_low, e_high = slope + c[K_HAT_M], held + c[F_FM], -np.inf, e_low
    if clamped != 0.0:
        # The unclamped force would be K_J a' + K_D v of a' = (m a + clamp - K_D v) / (m + K_J).
        share = c[INERTIA] / (c[MASS] + c[INERTIA])
        clamp_force, w = clamped * c[CLAMP], 1.0 / c[MASS]
        return Piece(
            w * (offset - clamp_force), w * slope, 0.0, w, e_low, e_high, clamped,
            share * c[MASS], (1.0 - share) * c[DAMPING], share * clamp_force,
        )  # fmt: skip
    w = 1.0 / (c[MASS] + c[INERTIA])
    return Piece(
        w * offset, w * slope, w * c[DAMPING], w, e_low, e_high, 0.0, c[INERTIA], c[DAMPING], 0.0
    )


@compiled()
def _side_of_clamp(
    slip: Any, p: Array, c: Array, e: float, v: float, s: float, held: float
) -> float:
    """+1.0, 0.0 or -1.0: where the motor's inertia and damping force is against its clamp."""
    net = drive_force(e, c) + held - slip(s * abs(v), p)
    a = (net - c[DAMPING] * v) / (c[MASS] + c[INERTIA])
    motor = c[INERTIA] * a + c[DAMPING] * v
    if abs(motor) <= c[CLAMP]:
        return 0.0
    return 1.0 if motor > 0.0 else -1.0


@compiled(forceinline=True, fastmath={"contract"})
def _acceleration(
    piece: Piece, e: float, v: float, s: float, friction: float, level: float
) -> float:
    """Acceleration in slip in direction s.

    The stages of a step near rest look beyond it. There friction is mirrored about its level at
    rest, so that the right-hand side is smooth and the instant of rest can be found on the
    polynomial of the step. The law is called by who calls this: its array is then not counted.

    Args:
        piece: The piece.
        e: Stretch, m.
        v: Velocity, m/s.
        s: +1.0 or -1.0.
        friction: The law at this speed in direction s, whichever direction v has.
        level: The law at rest in direction s.
    """
    if v * s < 0.0:
        friction = 2.0 * level - friction
    return piece.offset + piece.slope * e - piece.damping * v - piece.inverse * friction


#: What can end a piece of a slip: rest, a bend of the drive force on either side of it, the clamp
#: of the motor on either side.
_AT_REST, _LOW, _HIGH, _CLAMP_P, _CLAMP_M = 0, 1, 2, 3, 4


@compiled(fastmath={"contract"})
def _margin(
    kind: int, c: Array, s: float, piece: Piece, e: float, ahead: float, path: Array, m: int
) -> tuple[float, float, float, float, float, float]:
    """How far a step is from leaving its piece, by powers of the share of it that has passed.

    Negative beyond the edge. `e` is the stretch at its begin, `ahead` how far the command moves.
    """
    x1, x2, x3 = path[m, TRAVEL + 1], path[m, TRAVEL + 2], path[m, TRAVEL + 3]
    x4, x5 = path[m, TRAVEL + 4], path[m, TRAVEL + 5]
    if kind == _LOW:
        return e - piece.e_low, ahead - x1, -x2, -x3, -x4, -x5
    if kind == _HIGH:
        return piece.e_high - e, x1 - ahead, x2, x3, x4, x5
    per = 1.0 / path[m, LENGTH]
    v0, v1, v2, v3, v4 = per * x1, per * 2 * x2, per * 3 * x3, per * 4 * x4, per * 5 * x5
    if kind == _AT_REST:
        return s * v0 - c[BAND], s * v1, s * v2, s * v3, s * v4, 0.0
    side = -1.0 if kind == _CLAMP_P else 1.0
    if piece.clamped != 0.0:
        side = piece.clamped
    ma, mv, room = side * piece.of_a * per, side * piece.of_v, side * piece.of_1
    room += c[CLAMP] if piece.clamped == 0.0 else -c[CLAMP]
    return (
        room + mv * v0 + ma * v1,
        mv * v1 + ma * 2 * v2,
        mv * v2 + ma * 3 * v3,
        mv * v3 + ma * 4 * v4,
        mv * v4,
        0.0,
    )


@compiled(forceinline=True, fastmath={"contract"})
def _at(q: tuple[float, float, float, float, float, float], u: float) -> float:
    return q[0] + u * (q[1] + u * (q[2] + u * (q[3] + u * (q[4] + u * q[5]))))


@compiled(fastmath={"contract"})
def _crossing(q: tuple[float, float, float, float, float, float], low: float, high: float) -> float:
    """Where in [low, high] a polynomial falls to zero: Newton's rule, kept inside by halving."""
    if _at(q, low) <= 0.0:
        return low
    u = 0.5 * (low + high)
    for _ in range(100):
        f = _at(q, u)
        if f > 0.0:
            low = u
        else:
            high = u
        slope = q[1] + u * (2 * q[2] + u * (3 * q[3] + u * (4 * q[4] + u * 5 * q[5])))
        guess = u - f / slope if slope < 0.0 else low
        if not low < guess < high:
            guess = 0.5 * (low + high)
        if abs(guess - u) <= 1e-13 or high - low <= 1e-13:
            return guess
        u = guess
    return u


@compiled()
def _cut(
    c: Array, s: float, piece: Piece, e: float, ahead: float, path: Array, m: int
) -> tuple[float, int]:  # fmt: skip
    """The share of a step at which it leaves its piece, and how; (1.0, -1) if it stays inside."""
    theta, how = 1.0, -1
    for kind in range(5):
        # Each edge of the stretch by itself: a step that starts on one may leave by the other.
        if (kind == _LOW and piece.e_low == -np.inf) or (kind == _HIGH and piece.e_high == np.inf):
            continue
        if kind >= _CLAMP_P and (c[CLAMP] == np.inf or (piece.clamped != 0.0 and kind != _CLAMP_P)):
            continue
        q = _margin(kind, c, s, piece, e, ahead, path, m)
        if q[0] > abs(q[1]) + abs(q[2]) + abs(q[3]) + abs(q[4]) + abs(q[5]):
            continue
        before = 0.0
        for probe in (0.25, 0.5, 0.75, 1.0):
            if before >= theta:
                break
            if _at(q, probe) < 0.0:
                share = _crossing(q, before, probe)
                if share < theta or how < 0:
                    theta, how = share, kind
                break
            before = probe
    return theta, how


@compiled()
def _inside(
    c: Array, s: float, piece: Piece, e: float, ahead: float, dx: float,
    v: float, k1: float, w: float, k7: float, h: float,
) -> bool:  # fmt: skip
    """Whether a step certainly stays in its piece: the control points of its quintic do.

    A polynomial lies between the least and the greatest of its Bernstein coefficients.
    """
    v1, v3 = v + 0.25 * h * k1, w - 0.25 * h * k7
    v2 = 5.0 / h * dx - v - v1 - v3 - w
    slowest = min(s * v1, s * v2, s * v3, s * w)
    if slowest <= c[BAND]:
        return False
    # The slide moves one way only: the stretch lies between what the two could do alone.
    if s > 0.0:
        most, least = max(ahead, 0.0), min(ahead, 0.0) - dx
    else:
        most, least = max(ahead, 0.0) - dx, min(ahead, 0.0)
    if e + least <= piece.e_low or e + most >= piece.e_high:
        return False
    fast = max(abs(v), abs(v1), abs(v2), abs(v3), abs(w))
    a1, a2 = 4.0 / h * (v2 - v1), 4.0 / h * (v3 - v2)
    if piece.clamped == 0.0:
        strong = max(abs(k1), abs(a1), abs(a2), abs(k7))
        return piece.of_a * strong + piece.of_v * fast < c[CLAMP]  # type: ignore[no-any-return]
    t = piece.clamped
    weak = min(t * k1, t * a1, t * a2, t * k7)
    return piece.of_a * weak - piece.of_v * fast + t * piece.of_1 > c[CLAMP]  # type: ignore[no-any-return]


@compiled()
def _first(slip: Any, p: Array, e: float, v: float, s: float, piece: Piece, k1: float) -> float:
    """A first step, s: half the time in which friction's fall lets a slip grow e-fold."""
    more = max(abs(v), 1e-5)
    w = v + s * more
    growth = abs(_acceleration(piece, e, w, s, slip(s * abs(w), p), 0.0) - k1) / more
    rate = growth + np.sqrt(piece.slope) + piece.damping
    return min(0.5 / rate, 1.0) if rate > 0.0 else 1e-3


@compiled(fastmath={"contract"})
def leg(
    slip: Any,
    p: Array,
    c: Array,
    e: float,
    v: float,
    rate: float,
    s: float,
    level: float,
    span: float,
    wish: float,
    tolerance: float,
    path: Array,
    held: float,
) -> tuple[int, float, float, float, int, float, int]:
    """Integrate a slip in direction s while the command moves at one rate; fill its path.

    Args:
        slip: The law, its parameters and the constants follow.
        p: (k,).
        c: (11,).
        e: Stretch at the start, m.
        v: Velocity at the start, m/s.
        rate: Speed of the command, m/s.
        s: Direction of the slip, +1.0 or -1.0.
        level: Friction at rest in that direction, N.
        span: How long that rate holds, s.
        wish: Length of the first step, s; 0.0 where it is to be found.
        tolerance: Scales the error allowed in a step.
        path: (LEG, WIDTH), is written.
        held: Force of a drive that does not go with the stretch, N.

    Returns:
        Rows written, how long the leg took, the travel, the velocity at its end, how it ended,
        the next wish, and the steps tried.
    """
    piece = piece_at(c, e, _side_of_clamp(slip, p, c, e, v, s, held), held)
    k1 = _acceleration(piece, e, v, s, slip(s * abs(v), p), level)
    time, moved, tries, m = 0.0, 0.0, 0, 0
    if wish <= 0.0:
        wish = _first(slip, p, e, v, s, piece, k1) * min(tolerance, 1.0) ** 0.2
    before_h, before_r = 0.0, 1.0
    while m < LEG:
        h = min(wish, span - time)
        last = h == span - time
        tries += 1
        v2 = v + h * (0.161 * k1)
        k2 = _acceleration(piece, e + h * (0.161 * (rate - v)), v2, s, slip(s * abs(v2), p), level)
        a31, a32 = -0.008480655492356989, 0.335480655492357
        v3 = v + h * (a31 * k1 + a32 * k2)
        e3 = e + h * (0.327 * rate - (a31 * v + a32 * v2))
        k3 = _acceleration(piece, e3, v3, s, slip(s * abs(v3), p), level)
        a41, a42, a43 = 2.8971530571054935, -6.359448489975075, 4.3622954328695815
        v4 = v + h * (a41 * k1 + a42 * k2 + a43 * k3)
        e4 = e + h * (0.9 * rate - (a41 * v + a42 * v2 + a43 * v3))
        k4 = _acceleration(piece, e4, v4, s, slip(s * abs(v4), p), level)
        a51, a52, a53 = 5.325864828439257, -11.748883564062828, 7.4955393428898365
        a54 = -0.09249506636175525
        v5 = v + h * (a51 * k1 + a52 * k2 + a53 * k3 + a54 * k4)
        e5 = e + h * (0.9800255409045097 * rate - (a51 * v + a52 * v2 + a53 * v3 + a54 * v4))
        k5 = _acceleration(piece, e5, v5, s, slip(s * abs(v5), p), level)
        a61, a62, a63 = 5.86145544294642, -12.92096931784711, 8.159367898576159
        a64, a65 = -0.071584973281401, -0.028269050394068383
        v6 = v + h * (a61 * k1 + a62 * k2 + a63 * k3 + a64 * k4 + a65 * k5)
        e6 = e + h * (rate - (a61 * v + a62 * v2 + a63 * v3 + a64 * v4 + a65 * v5))
        k6 = _acceleration(piece, e6, v6, s, slip(s * abs(v6), p), level)
        b1, b2, b3 = 0.09646076681806523, 0.01, 0.4798896504144996
        b4, b5, b6 = 1.379008574103742, -3.290069515436081, 2.324710524099774
        dv = h * (b1 * k1 + b2 * k2 + b3 * k3 + b4 * k4 + b5 * k5 + b6 * k6)
        dx = h * (b1 * v + b2 * v2 + b3 * v3 + b4 * v4 + b5 * v5 + b6 * v6)
        w = v + dv
        k7 = _acceleration(piece, e + h * rate - dx, w, s, slip(s * abs(w), p), level)
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
            return m, time, moved, v, FAILED, wish, tries
        r = max(error, 1e-4) ** -0.2  # by how much the step could have been longer
        if error > 1.0:
            wish = h * max(0.2, 0.9 * r)
            continue
        factor = 0.9 * r
        if before_h > 0.0:  # steps that shrink or grow go on doing so
            factor = min(factor, factor * h / before_h * r / before_r)
        factor = min(5.0, max(0.2, factor))
        before_h, before_r = h, r
        # --- the quintic of this step, and where it is cut ---
        c1, c2 = h * v, 0.5 * h * h * k1
        far, turn, bend = dx - c1 - c2, h * dv - 2.0 * c2, 0.5 * h * h * (k7 - k1)
        c3 = 10.0 * far - 4.0 * turn + bend
        c4 = -15.0 * far + 7.0 * turn - 2.0 * bend
        c5 = 6.0 * far - 3.0 * turn + bend
        path[m, BEGIN], path[m, LENGTH], path[m, TRAVEL] = time, h, moved
        path[m, TRAVEL + 1], path[m, TRAVEL + 2], path[m, TRAVEL + 3] = c1, c2, c3
        path[m, TRAVEL + 4], path[m, TRAVEL + 5] = c4, c5
        m += 1
        theta, how = 1.0, -1
        if not _inside(c, s, piece, e, rate * h, dx, v, k1, w, k7, h):
            theta, how = _cut(c, s, piece, e, rate * h, path, m - 1)
        if how < 0:
            time = span if last else time + h
            path[m - 1, END] = time
            moved += dx
            e += h * rate - dx
            v, k1 = w, k7
            wish = h * factor if h == wish else max(wish, h * factor)
            if last:
                return m, time, moved, v, LIMIT, wish, tries
            continue
        u = theta
        dx = u * (c1 + u * (c2 + u * (c3 + u * (c4 + u * c5))))
        v = (c1 + u * (2 * c2 + u * (3 * c3 + u * (4 * c4 + u * 5 * c5)))) / h
        moved += dx
        e += u * h * rate - dx
        time = max(time + u * h, time + 1e-10)  # time goes on whatever happens
        path[m - 1, END] = time
        if how == _AT_REST:
            return m, time, moved, v, REST, wish, tries
        if time >= span:
            return m, time, moved, v, LIMIT, wish, tries
        clamped = piece.clamped
        if how >= _CLAMP_P:
            clamped = 0.0
            if piece.clamped == 0.0:
                clamped = 1.0 if how == _CLAMP_P else -1.0
        nudge = (rate - v) * 1e-9  # onto the far side of a bend
        heavy = piece.inverse
        piece = piece_at(c, e + nudge, clamped, held)
        k1 = _acceleration(piece, e, v, s, slip(s * abs(v), p), level)
        wish = h * factor
        if piece.inverse != heavy:  # all goes faster with less mass, and slower with more
            wish *= (heavy / piece.inverse) ** 0.75
        before_h = 0.0
    return m, time, moved, v, LIMIT, wish, tries


@compiled()
def samples_passed(t: Array, i: int, time: float, pace: float) -> int:
    """How many samples are at or before a time, i of which are known to be.

    A guess from the mean rate is right at once where samples are even; else halving finds it.
    """
    n = len(t)
    if i == n or t[i] > time:
        return i
    if t[n - 1] <= time:
        return n
    low, high = i, n - 1  # t[low] <= now < t[high]
    k = min(max(i + int((time - t[i]) * pace), low), high - 1)
    reach = 1
    while high - low > 1:
        if t[k] <= time:
            low = k
            k = min(low + reach, high - 1)
        else:
            high = k
            k = max(high - reach, low + 1)
        reach *= 2
        if reach > 16:
            k = (low + high) // 2
    return low + 1


@compiled()
def possible(c: Array) -> bool:
    """Whether constants can be simulated: a mass, and nothing below zero or undefined."""
    for k in range(len(c)):
        unlimited = k in (F_FM, CLAMP)
        if not (c[k] >= 0.0 and (c[k] < np.inf or unlimited)):
            return False
    return c[MASS] > 0.0  # type: ignore[no-any-return]


@compiled(fastmath={"contract"})
def read_samples(
    path: Array,
    rows: int,
    time: float,
    x: float,
    t: Array,
    i: int,
    measured: Array,
    score: Array,
    out_x: Array,
    out_v: Array,
    store: bool,
) -> tuple[int, float]:
    """Read the samples from i on that lie on a path; those done then, and their misfit, m^2."""
    n, sse = len(t), 0.0
    for k in range(rows):
        until = time + path[k, END]
        if i == n:
            break
        if t[i] > until:
            continue
        c0, c1, c2 = path[k, TRAVEL], path[k, TRAVEL + 1], path[k, TRAVEL + 2]
        c3, c4, c5 = path[k, TRAVEL + 3], path[k, TRAVEL + 4], path[k, TRAVEL + 5]
        begin, per = time + path[k, BEGIN], 1.0 / path[k, LENGTH]
        while i < n and t[i] <= until:
            u = (t[i] - begin) * per
            at = x + (c0 + u * (c1 + u * (c2 + u * (c3 + u * (c4 + u * c5)))))
            if store:
                out_x[i] = at
                out_v[i] = per * (c1 + u * (2 * c2 + u * (3 * c3 + u * (4 * c4 + u * 5 * c5))))
            else:
                miss = measured[i] - at
                sse += score[i] * miss * miss
            i += 1
    return i, sse


@compiled()
def _walk(
    slip: Any,
    p: Array,
    c: Array,
    knots_t: Array,
    knots_x: Array,
    extremes: Array,
    t: Array,
    x0: float,
    measured: Array,
    score: Array,
    sums: Array,
    out_x: Array,
    out_v: Array,
    store: bool,
    tolerance: float,
    path: Array,
) -> float:
    """Simulate one candidate over one track; return its sum of squared misfits, m^2."""
    level_p, level_m = slip(0.0, p), slip(-0.0, p)
    if not (0.0 <= level_p < np.inf and -np.inf < level_m <= 0.0 and possible(c)):
        return np.nan
    reach_p = stretch_at(level_p, c[K_HAT_P], c[K_SPRING_P], c[F_FM])
    reach_m = -stretch_at(-level_m, c[K_HAT_M], c[K_SPRING_M], c[F_FM])
    n = len(t)
    pace = (n - 1) / (t[n - 1] - t[0]) if n > 1 else 0.0
    time, x = t[0], x0
    i, j = 0, 0  # samples done, command knots passed
    sse, steps, most = 0.0, 0, MOST_STEPS + MOST_STEPS_A_KNOT * len(knots_t)
    # The path of the last whole slip, and how that one began.
    known, known_e, known_rate, known_s, known_span, known_travel = 0, 0.0, 0.0, 0.0, 0.0, 0.0
    while True:
        # --- stuck, until the command has pulled the slide loose ---
        time, s, j = _breakaway(
            c, knots_t, knots_x, extremes, j, time, x, level_m, level_p, reach_m, reach_p
        )  # fmt: skip
        first = i
        i = samples_passed(t, i, time, pace)
        if store:
            out_x[first:i] = x
            out_v[first:i] = 0.0
        d = x - x0
        sse += (sums[2, i] - sums[2, first]) - 2.0 * d * (sums[1, i] - sums[1, first])
        sse += d * d * (sums[0, i] - sums[0, first])
        if i == n:
            return sse  # type: ignore[no-any-return]
        # --- slip, until the slide comes to rest ---
        while j < len(knots_t) and knots_t[j] <= time:
            j += 1
        xi, rate, end = command_at(knots_t, knots_x, j, time)
        again = (
            known > 0
            and s == known_s
            and rate == known_rate
            and abs(xi - x - known_e) <= SAME
            and time + known_span <= end
        )
        if again:
            i, miss = read_samples(path, known, time, x, t, i, measured, score, out_x, out_v, store)
            sse += miss
            x += known_travel
            time = later(time, known_span)
            if i == n:
                return sse  # type: ignore[no-any-return]
            continue
        known, known_e, known_rate, known_s = 0, xi - x, rate, s
        v, wish, whole = s * c[BAND], 0.0, True
        while True:
            level = level_p if s > 0.0 else level_m
            rows, span, travel, v, how, wish, tries = leg(
                slip, p, c, xi - x, v, rate, s, level, end - time, wish, tolerance, path, 0.0
            )
            steps += tries
            if how == FAILED or steps > most:
                return np.nan
            i, miss = read_samples(path, rows, time, x, t, i, measured, score, out_x, out_v, store)
            sse += miss
            x += travel
            if i == n:
                return sse  # type: ignore[no-any-return]
            time = later(time, span)
            if how == REST:
                if whole:
                    known, known_span, known_travel = rows, span, travel
                break
            time = min(time, end)
            while j < len(knots_t) and knots_t[j] <= time:
                j += 1
            xi, rate, end = command_at(knots_t, knots_x, j, time)
            whole = False


@compiled(
    void(
        SLIP_TYPE, _F2, _F2, _F1, _F1, _F2, _F1, _F1, _F1, _F1, _F2, _W2, _W2, _W1, boolean,
        float64, _I1,
    ),
    nogil=True,
)  # fmt: skip
def _rows(
    slip: Any,
    p: Array,
    c: Array,
    knots_t: Array,
    knots_x: Array,
    extremes: Array,
    t: Array,
    start: Array,
    measured: Array,
    score: Array,
    sums: Array,
    out_x: Array,
    out_v: Array,
    sse: Array,
    store: bool,
    tolerance: float,
    counter: Array,
) -> None:
    """Simulate the rows that no thread has taken yet, one after the other, until none is left."""
    path_owner = np.empty((LEG, WIDTH))
    path = borrowed(path_owner)
    knots_t, knots_x = borrowed(knots_t), borrowed(knots_x)
    extremes, sums = borrowed(extremes), borrowed(sums)
    t, measured, score = borrowed(t), borrowed(measured), borrowed(score)
    while True:
        row = row_pool.next_row(counter)
        if row >= len(p):
            path_owner[0, 0] = 0.0  # it lives until here
            return
        k = row if store else 0
        sse[row] = _walk(
            slip, borrowed(p[row]), borrowed(c[row]), knots_t, knots_x, extremes, t, start[row],
            measured, score, sums, borrowed(out_x[k]), borrowed(out_v[k]), store,
            tolerance, path,
        )  # fmt: skip


#: Runs all rows of a kernel: law, parameters, constants, track, starts, and where results go.
Spread: TypeAlias = "Callable[[Law, Array, Array, Track, Array, tuple[Any, ...]], None]"


def _spread(
    law: Law, p: Array, c: Array, track: Track, start: Array, arguments: tuple[Any, ...]
) -> None:
    """Run all rows, dealt out over the cores; no result depends on how they are dealt."""
    track = from_zero(track)
    row_pool.pool().share(
        _rows, len(p),
        (addressed(law.slip), p, c, track.knots_t, track.knots_x, track.extremes, track.t, start,
         track.measured, track.score, track.sums, *arguments),
        max(row_pool.FEWEST, row_pool.FEWEST_SAMPLES // len(track.t)),
    )  # fmt: skip


def misfits(
    law: Law, p: Array, c: Array, track: Track, tolerance: float = 1.0, spread: Spread = _spread
) -> Array:
    """Sums of squared position misfits, m^2, of (n, k) law parameters with (n, 11) constants.

    A candidate whose simulation fails has nan. `tolerance` scales the error allowed in a step,
    `spread` runs the rows of a kernel.
    """
    sse, nothing = np.empty(len(p)), np.empty((1, 0))
    if len(p):
        start, results = np.full(len(p), track.x0), (nothing, nothing, sse, False, tolerance)
        spread(law, contiguous(p), contiguous(c), track, start, results)
    return sse


def trajectories(
    law: Law,
    p: Array,
    c: Array,
    track: Track,
    tolerance: float = 1.0,
    start: Array | None = None,
    spread: Spread = _spread,
) -> tuple[Array, Array]:
    """Positions and velocities, (n, N) each, of (n, k) law parameters with (n, 11) constants.

    Each starts at its own `start`, m, (n,); by default all where the track does.
    """
    x, v = np.full((2, len(p), len(track.t)), np.nan)
    if len(p):
        start = np.full(len(p), track.x0) if start is None else contiguous(start)
        results = (x, v, np.empty(len(p)), True, tolerance)
        spread(law, contiguous(p), contiguous(c), track, start, results)
    return x, v
