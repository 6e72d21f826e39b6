"""The fast integrator of the slide bed: what is stuck costs nothing, what slips is exact.

While the slide is stuck only the command moves, so breakaway is found by solving for its time, and
the misfit of the stuck stretch comes from prefix sums of the measured position. A slip is
integrated (`slip.py`) as a path that its samples are read from. Its equation does not name the
time: under a ramp each slip begins as the one before did and so is the same path, read again.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numba import boolean, float64, int64, njit, types, void

from ..friction import SLIP_TYPE
from ..space import Array
from . import crew
from .slip import (
    BAND, BEGIN, CLAMP, DAMPING, END, F_FM, FAILED, INERTIA, K_HAT_M, K_HAT_P, K_SPRING_M,
    K_SPRING_P, LEG, LENGTH, MASS, REST, TRAVEL, WIDTH, drive_force, leg,
)  # fmt: skip
from .track import RUN, Track

if TYPE_CHECKING:
    from ..friction import Law

#: Steps after which a candidate is given up (its cost is then not finite), and what each knot of
#: the command adds to them: a log's noisy command may have millions.
MOST_STEPS, MOST_STEPS_A_KNOT = 1_000_000, 20
#: The first step of a slip, s.
FIRST_STEP = 1e-4
#: Stretches at breakaway this close, m, are the same slip: far below the tolerance of a step.
SAME = 1e-12

_F1 = types.Array(float64, 1, "C", readonly=True)
_F2 = types.Array(float64, 2, "C", readonly=True)
_W1 = float64[::1]
_W2 = float64[:, ::1]
_I1 = int64[::1]


def from_zero(on: Track) -> Track:
    """The same track on a clock that starts with it: seconds since 1970 leave no digits."""
    if on.t[0] == 0.0:
        return on
    return on._replace(t=on.t - on.t[0], knots_t=on.knots_t - on.t[0])


@njit(float64(float64, float64, float64, float64), cache=True, error_model="numpy")
def stretch_at(level: float, k_hat: float, k_spring: float, F_fm: float) -> float:
    """The stretch at which the drive force reaches a level (both as magnitudes); inf if never."""
    if k_spring > 0.0 and level * k_hat <= F_fm * k_spring:
        return level / k_spring
    if k_hat + k_spring > 0.0:
        return (level + F_fm) / (k_hat + k_spring)
    return np.inf


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
        _F1, _F1, _F1, _F2, int64, float64, float64, float64, float64, float64, float64
    ),
    cache=True,
    error_model="numpy",
)
def _breakaway(
    c: Array,
    knots_t: Array,
    knots_x: Array,
    extremes: Array,
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
                        now = knots_t[j]
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



@njit(int64(_F1, int64, float64, float64), cache=True, error_model="numpy")
def _passed(t: Array, i: int, now: float, pace: float) -> int:
    """How many samples are at or before now, i of which are known to be.

    A guess from the mean rate is right at once where samples are even; else halving finds it.
    """
    n = len(t)
    if i == n or t[i] > now:
        return i
    if t[n - 1] <= now:
        return n
    low, high = i, n - 1  # t[low] <= now < t[high]
    k = min(max(i + int((now - t[i]) * pace), low), high - 1)
    reach = 1
    while high - low > 1:
        if t[k] <= now:
            low = k
            k = min(low + reach, high - 1)
        else:
            high = k
            k = max(high - reach, low + 1)
        reach *= 2
        if reach > 16:
            k = (low + high) // 2
    return low + 1


@njit(boolean(_F1), cache=True, error_model="numpy")
def _possible(c: Array) -> bool:
    """Whether constants can be simulated: a mass, and nothing below zero or undefined."""
    for k in range(len(c)):
        unlimited = k in (F_FM, CLAMP)
        if not (c[k] >= 0.0 and (c[k] < np.inf or unlimited)):
            return False
    return c[MASS] > 0.0  # type: ignore[no-any-return]


@njit(
    types.Tuple((int64, float64))(
        _W2, int64, float64, float64, _F1, int64, _F1, _F1, _W1, _W1, boolean
    ),
    cache=True,
    nogil=True,
    error_model="numpy",
)
def _read(
    path: Array,
    rows: int,
    now: float,
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
        row = path[k]
        until = now + row[END]
        if i == n:
            break
        if t[i] > until:
            continue
        c0, c1, c2, c3, c4, c5 = row[3], row[4], row[5], row[6], row[7], row[8]
        begin, per = now + row[BEGIN], 1.0 / row[LENGTH]
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


@njit(
    float64(
        SLIP_TYPE, _F1, _F1, _F1, _F1, _F2, _F1, float64, _F1, _F1, _F2, _W1, _W1, boolean,
        float64, _W2, _I1,
    ),
    cache=True,
    nogil=True,
    error_model="numpy",
)  # fmt: skip
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
    count: Array,
) -> float:
    """Simulate one candidate over one track; return its sum of squared misfits, m^2."""
    level_p, level_m = slip(0.0, p), slip(-0.0, p)
    if not (0.0 <= level_p < np.inf and -np.inf < level_m <= 0.0 and _possible(c)):
        return np.nan
    reach_p = stretch_at(level_p, c[K_HAT_P], c[K_SPRING_P], c[F_FM])
    reach_m = -stretch_at(-level_m, c[K_HAT_M], c[K_SPRING_M], c[F_FM])
    n = len(t)
    pace = (n - 1) / (t[n - 1] - t[0]) if n > 1 else 0.0
    now, x = t[0], x0
    i, j = 0, 0  # samples done, command knots passed
    sse, steps, most = 0.0, 0, MOST_STEPS + MOST_STEPS_A_KNOT * len(knots_t)
    # The path of the last whole slip, and how that one began.
    known, known_e, known_rate, known_s, known_span, known_travel = 0, 0.0, 0.0, 0.0, 0.0, 0.0
    while True:
        # --- stuck, until the command has pulled the slide loose ---
        now, s, j = _breakaway(
            c, knots_t, knots_x, extremes, j, now, x, level_m, level_p, reach_m, reach_p
        )  # fmt: skip
        first = i
        i = _passed(t, i, now, pace)
        if store:
            out_x[first:i] = x
            out_v[first:i] = 0.0
        d = x - x0
        sse += (sums[2, i] - sums[2, first]) - 2.0 * d * (sums[1, i] - sums[1, first])
        sse += d * d * (sums[0, i] - sums[0, first])
        if i == n:
            return sse  # type: ignore[no-any-return]
        # --- slip, until the slide comes to rest ---
        while j < len(knots_t) and knots_t[j] <= now:
            j += 1
        xi, rate, end = _command(knots_t, knots_x, j, now)
        again = (
            known > 0
            and s == known_s
            and rate == known_rate
            and abs(xi - x - known_e) <= SAME
            and now + known_span <= end
        )
        if again:
            i, miss = _read(path, known, now, x, t, i, measured, score, out_x, out_v, store)
            sse += miss
            x += known_travel
            now = _after(now, known_span)
            if i == n:
                return sse  # type: ignore[no-any-return]
            continue
        known, known_e, known_rate, known_s = 0, xi - x, rate, s
        v, wish, whole = s * c[BAND], FIRST_STEP, True
        while True:
            rows, span, travel, v, how, wish, tries = leg(
                slip, p, c, xi - x, v, rate, s, end - now, wish, tolerance, path
            )
            steps += tries
            count[0] += tries
            count[1] += rows
            if how == FAILED or steps > most:
                return np.nan
            i, miss = _read(path, rows, now, x, t, i, measured, score, out_x, out_v, store)
            sse += miss
            x += travel
            if i == n:
                return sse  # type: ignore[no-any-return]
            now = _after(now, span)
            if how == REST:
                if whole:
                    known, known_span, known_travel = rows, span, travel
                break
            if now >= end:
                now = end
            while j < len(knots_t) and knots_t[j] <= now:
                j += 1
            xi, rate, end = _command(knots_t, knots_x, j, now)
            whole = False


@njit(
    void(
        SLIP_TYPE, _F2, _F2, _F1, _F1, _F2, _F1, float64, _F1, _F1, _F2, _W2, _W2, _W1, boolean,
        float64, _I1,
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
    extremes: Array,
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
    taken: Array,
) -> None:
    """Simulate the rows that nobody has taken yet, one after the other, until none is left."""
    own = np.empty((LEG, WIDTH))
    path = crew.lent(own)
    count = np.zeros(2, np.int64)
    while True:
        row = crew.take(taken)
        if row >= len(p):
            return
        k = row if store else 0
        sse[row] = _walk(
            slip, crew.lent(p[row]), crew.lent(c[row]), knots_t, knots_x, extremes, t, x0, measured, score, sums,
            out_x[k], out_v[k], store, tolerance, path, count,
        )  # fmt: skip


def _spread(law: Law, p: Array, c: Array, on: Track, arguments: tuple[Any, ...]) -> None:
    """Run all rows, dealt out over the cores; no result depends on how they are dealt."""
    on = from_zero(on)
    crew.share(
        _rows, len(p),
        (law.slip, p, c, on.knots_t, on.knots_x, on.extremes, on.t, on.x0, on.measured, on.score,
         on.sums, *arguments),
    )  # fmt: skip


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
