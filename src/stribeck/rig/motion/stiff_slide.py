"""The slide bed under laws that never stick: from event to event in steps that samples do not cut.

A slide under a law that is smooth through rest, or whose bristles hold it, never rests: it creeps,
and what holds it there makes its equation stiff. Its steps (`stiff_step.py`) are as long as their
errors allow, from below a microsecond in a slip's first instant to seconds in creep. Samples are
read from the polynomial through position and velocity at both ends of a step.

Steps end where the drive force bends, where the motor's clamp opens or closes, and where the slide
overtakes its command. There, under a ramp, one slip is like the one before: where stretch and
states are those of one slip ago, what follows is the same path, read again.
"""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numba import boolean, float64, int64, types, void

from ...compile_cache import compiled
from ...friction import RUB_TYPE, SLIP_TYPE
from ...friction.law import LOADS
from ...space import Array
from . import event_driven, row_pool
from .drives import CLAMP, INERTIA, MASS
from .event_driven import (
    BEGIN,
    END,
    LENGTH,
    TOLERANCE_V_SHARE,
    TRAVEL,
    WIDTH,
    Piece,
    command_at,
    drive_force,
    from_zero,
    later,
    piece_at,
    possible,
    read_samples,
)
from .implicit import begun
from .row_pool import borrowed
from .stiff_step import (
    EULER,
    MIDPOINT,
    UNKNOWN,
    acceleration_at,
    smooth_step,
    stiff_step,
)
from .velocity import calls_of, rubs

if TYPE_CHECKING:
    from ...friction import Law
    from .track import Track

#: What a step ends at: nothing, a bend of the drive force on either side, the motor's clamp, a
#: slide as fast as its command.
NOTHING, BELOW, ABOVE, AT_CLAMP, OVERTAKES = range(5)
#: Steps after which a candidate is given up, and what each knot of the command adds to them.
MOST_STEPS, MOST_STEPS_A_KNOT = 200_000, 20
#: Rows of a path that are kept until its samples are read.
ROWS = 512
#: Two slips are the same whose stretch differs by no more, m, and whose velocity and states do as a
#: share of these.
SAME, SAME_SHARE = 3e-7, 1e-5
#: So often may a slide overtake its command between two that are the same: it swings back.
SEEN = 4
#: Below this share of its command's rate a slide creeps: what comes then is another slip.
SLOW = 0.5
#: A stiff step is worth its while where it is so much longer than one that is not.
WORTH = 4.0
#: A step is stiff in which a velocity would fade by more than this many e-fold times; under a law
#: with states, whose bristles may swing, by more than the other.
STIFF, SWINGS = 6.0, 1.5
#: Error allowed in one step, m; that of the velocity as it moves the slide until it has faded or
#: swung back, in so long at most, s.
TOLERANCE, LASTS = 3e-9, 1.0
#: The first step behind a corner of the command, s: one that is long jumps what follows quickly.
FIRST = 1e-5
#: A step is never shorter, s.
SHORTEST = 1e-9
#: How the next step may differ: at least, at most, and the share of what the error allows.
_LEAST, _MOST, _SAFE = 0.1, 6.0, 0.85
#: The clamp's side may change late by such a share of the error allowed.
NEAR = 0.3
#: Velocities are solved to this share of the error allowed; the clamp is located to such a share of
#: its force, and the command's rate to one of itself, in so many tries.
_FINE, _CLOSE, _OVERTAKEN, _TRIES = 0.1, 0.01, 1e-5, 12

_F1 = types.Array(float64, 1, "C", readonly=True)
_F2 = types.Array(float64, 2, "C", readonly=True)
_W2 = float64[:, ::1]
_I1 = int64[::1]


@compiled(forceinline=True)
def _room(piece: Piece, c: Array, v: float, a: float) -> float:
    """How far the motor's inertia and damping force is from leaving its side of the clamp, N."""
    force = piece.of_a * a + piece.of_v * v
    if piece.clamped == 0.0:
        return c[CLAMP] - abs(force)  # type: ignore[no-any-return]
    return piece.clamped * (force + piece.of_1) - c[CLAMP]  # type: ignore[no-any-return]


@compiled(forceinline=True)
def _part(low_room: float, room: float, c: Array) -> float:
    """Where between two instants to look for the clamp: halfway if it is at both of them."""
    return low_room / (low_room - room) if low_room > _CLOSE * c[CLAMP] else 0.5


@compiled()
def _clamped_at_first(friction: float, c: Array, e: float) -> tuple[float, float]:
    """On which side of its clamp the motor of a slide at rest is, and the slide's acceleration."""
    net = drive_force(e, c) - friction
    a = net / (c[MASS] + c[INERTIA])
    if abs(c[INERTIA] * a) <= c[CLAMP]:
        return 0.0, a
    side = 1.0 if a > 0.0 else -1.0
    return side, (net - side * c[CLAMP]) / c[MASS]


@compiled(forceinline=True)
def _reached(dx: float, d0: float, d1: float, goal: float, ahead: float) -> float:
    """Where in a step the stretch has fallen by a goal, m, on the cubic of its position.

    Args:
        dx: Travel of the step.
        d0: Its length times the velocity at its begin.
        d1: The same at its end.
        goal: By how much the command would have to move less than the slide.
        ahead: How far the command moves.
    """
    low, high = 0.0, 1.0
    side = 1.0 if dx - ahead > goal else -1.0
    c2, c3 = 3.0 * dx - 2.0 * d0 - d1, d0 + d1 - 2.0 * dx
    for _ in range(50):
        u = 0.5 * (low + high)
        if side * (u * (d0 - ahead + u * (c2 + u * c3)) - goal) > 0.0:
            high = u
        else:
            low = u
    return high


@compiled()
def _alike(
    e: float, v: float, z: Array, states: Array, other_e: float, other_v: float, same: float
) -> bool:
    """Whether a slip begins as the one before it did, whose states are the last row."""
    other = states[3]
    if abs(e - other_e) > same or abs(v - other_v) > SAME_SHARE * abs(v):
        return False
    for i in range(len(z)):
        if abs(z[i] - other[i]) > SAME_SHARE * abs(other[i]) + 0.01 * same:
            return False
    return True


@compiled()
def _walk(  # noqa: C901, PLR0912, PLR0915 - one loop of many cases
    slip: Any, rub: Any, general: bool, p: Array, c: Array, knots_t: Array, knots_x: Array,
    t: Array, x0: float, measured: Array, score: Array, out_x: Array, out_v: Array, store: bool,
    tolerance: float, states: Array, scratch: Array, path: Array,
) -> float:  # fmt: skip
    """Simulate one candidate over one track; return its sum of squared misfits, m^2."""
    if not possible(c):
        return np.nan
    n, n_z, z, load, slopes = len(t), len(states[4]), states[4], scratch[0], scratch[1]
    stiff = SWINGS if n_z > 0 else STIFF
    scratch[:] = UNKNOWN
    load[:] = 0.0
    time, x, v, i, j = t[0], x0, 0.0, 0, 0
    sse, steps, most = 0.0, 0, MOST_STEPS + MOST_STEPS_A_KNOT * len(knots_t)
    while j < len(knots_t) and knots_t[j] <= time:
        j += 1
    xi, rate, end = command_at(knots_t, knots_x, j, time)
    end = min(end, later(t[n - 1], 0.0))
    e, friction = xi - x, 0.0
    if len(z) > 0:
        begun(rub, 1.0, drive_force(e, c), 0.0, load, p, states[1], z)
        friction = rub(0.0, 0.0, z, load, p, states[1])
    else:
        friction = rubs(slip, rub, general, 1.0, 0.0, 0.0, z, load, p, states[1])
    side, a = _clamped_at_first(friction, c, e)
    piece = piece_at(c, e, side, 0.0)
    rows, begin, begin_x = 0, time, x
    # The last slip: its stretch and velocity at the begin, its first step; whether all of it is on
    # the path. Its states are the last row of `states`.
    slip_e, slip_v, slip_wish, whole, armed, seen = 0.0, 0.0, 0.0, False, False, 0
    wish, tries, steep, steep_h = FIRST, 0, np.inf, FIRST
    low, low_room, high, high_room = 0.0, 0.0, 0.0, 0.0
    event, target, most_now, before, known, forced = NOTHING, 0.0, _MOST, 0.0, False, False
    while True:
        h = wish if event == NOTHING else target
        last = event == NOTHING and h >= end - time
        if last:
            h = end - time
        fine = _FINE * tolerance * (TOLERANCE / LASTS + TOLERANCE_V_SHARE * abs(v))
        steps += 1
        if steps > most:
            return np.nan
        longer = max(h / steep_h, 1.0) if n_z > 0 else 1.0
        smooth = not forced and h * (piece.damping + steep * longer) <= stiff
        for k in range(len(slopes)):
            if slopes[k] == 0.0:
                slopes[k] = UNKNOWN
        if smooth:
            if not known:
                a = acceleration_at(slip, rub, general, p, load, piece, e, v, z, states[1])
                known = True
            dx, v_1, a_1, off_x, off_v = smooth_step(
                slip, rub, general, p, load, piece, e, v, a, rate, h, fine, z, states, slopes
            )  # fmt: skip
            span, between, last_slope = 0.5 * h, h / 3.0, slopes[len(MIDPOINT) - 1]
        else:
            dx, v_1, a_1, off_x, off_v = stiff_step(
                slip, rub, general, p, load, piece, e, v, a, rate, h, fine, z, states, slopes
            )  # fmt: skip
            span, between, last_slope = h, 0.75 * h, slopes[len(EULER) - 1]
        steep = slopes[0] if slopes[0] * last_slope != 0.0 else np.inf
        steep_h, back = span, 1.0 / LASTS
        if n_z > 0:
            back = max(np.sqrt(max(slopes[0] - last_slope, 0.0) / between + piece.slope), back)
        allowed = TOLERANCE * back + TOLERANCE_V_SHARE * max(abs(v), abs(v_1))
        error = max(off_x / TOLERANCE, off_v / allowed) / tolerance
        by = max(error, 1e-6) ** (-0.2 if smooth else -0.25) if error < np.inf else 0.0
        if smooth and h * steep > 2.0 * stiff and h > SHORTEST:
            event, tries, most_now, wish, forced = NOTHING, 0, 1.0, h, True
            continue
        if not error <= 1.0 and h > SHORTEST:
            wish, most_now = max(h * max(_SAFE * by, _LEAST), SHORTEST), 1.0
            event, tries = NOTHING, 0
            continue
        if not error < np.inf:
            return np.nan
        # --- what it comes to within the step ---
        e_1 = e + h * rate - dx
        room = _room(piece, c, v_1, a_1)
        if event == NOTHING and h > SHORTEST:
            if e_1 < piece.e_low:
                event, target = BELOW, h * _reached(dx, h * v, h * v_1, e - piece.e_low, h * rate)
            elif e_1 > piece.e_high:
                event, target = ABOVE, h * _reached(dx, h * v, h * v_1, e - piece.e_high, h * rate)
            elif room < 0.0 and (
                0.5 * h * h * -room > NEAR * TOLERANCE * tolerance * c[MASS]
                or h * -room > NEAR * allowed * tolerance * c[MASS]
            ):
                low, low_room, high, high_room = 0.0, max(_room(piece, c, v, a), 0.0), h, room
                event, target = AT_CLAMP, h * _part(low_room, high_room, c)
            elif armed and v / rate < 1.0 and v_1 / rate > 1.0:
                event, target = OVERTAKES, h * (rate - v) / (v_1 - v)
            if event != NOTHING:
                tries, wish = 0, h
                target = max(target, SHORTEST)
                if target < h * (1.0 - 1e-9):
                    continue
        elif event >= AT_CLAMP:  # by false position
            off = room / c[CLAMP] if event == AT_CLAMP else 1.0 - v_1 / rate
            tries += 1
            near = (_CLOSE if event == AT_CLAMP else _OVERTAKEN) * min(tolerance, 1.0)
            if abs(off) > near and tries < _TRIES:
                if event == AT_CLAMP:
                    if room > 0.0:
                        low, low_room = h, room
                    else:
                        high, high_room = h, room
                    part = _part(low_room, high_room, c) if tries % 3 > 0 else 0.5
                    target = low + (high - low) * part
                else:
                    target = h + (rate - v_1) / a_1 if a_1 * rate > 0.0 else h
                if SHORTEST < target < wish:
                    continue
        # --- accept ---
        if rows == ROWS:
            i, miss = read_samples(
                path, rows, begin, begin_x, t, i, measured, score, out_x, out_v, store
            )
            sse += miss
            rows, begin, begin_x, whole = 0, time, x, False
        row = path[rows]
        row[BEGIN], row[LENGTH], row[TRAVEL] = time - begin, h, x - begin_x
        c1, c2 = h * v, 3.0 * dx - h * (2.0 * v + v_1)
        c3, c4, c5 = h * (v + v_1) - 2.0 * dx, 0.0, 0.0
        if smooth:  # with the accelerations
            c2 = 0.5 * h * h * a
            far, turn, bend = dx - c1 - c2, h * (v_1 - v) - 2.0 * c2, 0.5 * h * h * (a_1 - a)
            c3 = 10.0 * far - 4.0 * turn + bend
            c4 = -15.0 * far + 7.0 * turn - 2.0 * bend
            c5 = 6.0 * far - 3.0 * turn + bend
        row[TRAVEL + 1], row[TRAVEL + 2], row[TRAVEL + 3] = c1, c2, c3
        row[TRAVEL + 4], row[TRAVEL + 5] = c4, c5
        time = end if last else time + h
        row[END] = time - begin
        rows += 1
        x, v, a, e, known, forced = x + dx, v_1, a_1, e_1, smooth, False
        for k in range(len(z)):
            z[k] = states[0, k]
        if event == NOTHING:  # steps that shrink or grow go on doing so
            factor = _SAFE * by * (min(1.0, h * by / before) if before > 0.0 else 1.0)
            factor, before = min(max(factor, _LEAST), most_now), h * by
            wish, most_now = h * factor if not last else max(wish, h * factor), _MOST
            if smooth and stiff < wish * (piece.damping + steep) < WORTH * stiff:
                wish = stiff / (piece.damping + steep)
        armed = armed or (rate != 0.0 and v / rate < SLOW)
        happened, event, tries = AT_CLAMP if event == NOTHING and room < 0.0 else event, NOTHING, 0
        if happened != NOTHING:
            before = 0.0
        if happened == BELOW:
            piece = piece_at(c, np.nextafter(piece.e_low, -np.inf), piece.clamped, 0.0)
        elif happened == ABOVE:
            piece = piece_at(c, np.nextafter(piece.e_high, np.inf), piece.clamped, 0.0)
        elif happened == AT_CLAMP:
            side = 0.0
            if piece.clamped == 0.0:
                side = 1.0 if piece.of_a * a + piece.of_v * v > 0.0 else -1.0
            middle = 0.5 * (max(piece.e_low, e - 1.0) + min(piece.e_high, e + 1.0))
            piece = piece_at(c, middle, side, 0.0)
        if not (happened == OVERTAKES or time >= end):
            continue
        i, miss = read_samples(
            path, rows, begin, begin_x, t, i, measured, score, out_x, out_v, store
        )
        sse += miss
        if i == n:
            return sse  # type: ignore[no-any-return]
        if happened == OVERTAKES:
            again = whole and _alike(e, v, z, states, slip_e, slip_v, SAME * tolerance)
            if again:
                span = time - begin
                travel = rate * span
                while time + span <= end and i < n:
                    i, miss = read_samples(
                        path, rows, time, x, t, i, measured, score, out_x, out_v, store
                    )
                    sse += miss
                    time, x = time + span, x + travel
                if i == n:
                    return sse  # type: ignore[no-any-return]
            armed, seen = False, seen + 1
            if not again and whole and seen < SEEN:
                continue
            if not again:
                slip_wish = slip_wish if whole else wish
                slip_e, slip_v = e, v
                for k in range(len(z)):
                    states[3, k] = z[k]
            wish, whole, seen = slip_wish, True, 0
        else:
            whole = False
        rows, begin, begin_x = 0, time, x
        if time >= end:
            while j < len(knots_t) and knots_t[j] <= time:
                j += 1
            xi, rate, end = command_at(knots_t, knots_x, j, time)
            e, end, wish = xi - x, min(end, later(t[n - 1], 0.0)), FIRST


@compiled(
    void(
        SLIP_TYPE, RUB_TYPE, boolean, int64, _F2, _F2, _F1, _F1, _F1, _F1, _F1, _F1, _W2, _W2,
        float64[::1], boolean, float64, _I1,
    ),
    nogil=True,
)  # fmt: skip
def _rows(
    slip: Any, rub: Any, general: bool, states: int, p: Array, c: Array, knots_t: Array,
    knots_x: Array, t: Array, start: Array, measured: Array, score: Array, out_x: Array,
    out_v: Array, sse: Array, store: bool, tolerance: float, counter: Array,
) -> None:  # fmt: skip
    """Simulate the rows that no thread has taken yet, one after the other, until none is left."""
    path_owner, states_owner = np.empty((ROWS, WIDTH)), np.empty((5, states))
    scratch_owner = np.empty((2, max(len(LOADS), len(EULER))))
    path, room, scratch = borrowed(path_owner), borrowed(states_owner), borrowed(scratch_owner)
    knots_t, knots_x = borrowed(knots_t), borrowed(knots_x)
    t, measured, score = borrowed(t), borrowed(measured), borrowed(score)
    while True:
        row = row_pool.next_row(counter)
        if row >= len(p):
            path_owner[0, 0] = scratch_owner[0, 0] = 0.0  # they live until here
            states_owner[:] = 0.0
            return
        k = row if store else 0
        sse[row] = _walk(
            slip, rub, general, borrowed(p[row]), borrowed(c[row]), knots_t, knots_x, t, start[row],
            measured, score, borrowed(out_x[k]), borrowed(out_v[k]), store, tolerance, room,
            scratch, path,
        )  # fmt: skip


def _spread(
    law: Law, p: Array, c: Array, track: Track, start: Array, arguments: tuple[Any, ...]
) -> None:
    """Run all rows, dealt out over the cores; no result depends on how they are dealt."""
    track = from_zero(track)
    row_pool.pool().share(
        _rows, len(p),
        (*calls_of(law), law.states, p, c, track.knots_t, track.knots_x, track.t, start,
         track.measured, track.score, *arguments),
        max(row_pool.FEWEST, row_pool.FEWEST_SAMPLES // len(track.t)),
    )  # fmt: skip


misfits = partial(event_driven.misfits, spread=_spread)
trajectories = partial(event_driven.trajectories, spread=_spread)
