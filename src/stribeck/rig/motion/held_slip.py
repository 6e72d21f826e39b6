"""A slip of the slide bed under a controller that holds its force until it reads again.

What the controller read is known, so the force of the motor is; the spring pulls at the simulated
position. Between two instants at which either changes its course the slide obeys the equation of
`event_driven` with the force held. The instant at which it breaks away is given: a force that
flickers breaks it away at one reading and not at the one before, and a motion that depended on a
breakaway level by that would jump with it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numba import float64, int64, types, void

from ...compile_cache import compiled
from ...friction import SLIP_TYPE, addressed
from ...space import Array, contiguous
from . import row_pool
from .drives import BAND, F_FM, K_HAT_M, K_HAT_P, K_SPRING_M, K_SPRING_P
from .event_driven import (
    FAILED,
    LEG,
    MOST_STEPS,
    REST,
    WIDTH,
    later,
    leg,
    possible,
    read_samples,
    samples_passed,
)
from .row_pool import borrowed

if TYPE_CHECKING:
    from ...friction import Law

_F1 = types.Array(float64, 1, "C", readonly=True)
_F2 = types.Array(float64, 2, "C", readonly=True)
_W2 = float64[:, ::1]
_I1 = int64[::1]


class HeldCourse(NamedTuple):
    """What pulls at the slide.

    Args:
        t: Instants at which the force of the motor or the rate of the command may change, s, (E,).
        command: There, m; a straight line between them.
        stretch: As the controller reads it, until the next instant, m.
    """

    t: Array
    command: Array
    stretch: Array


@compiled()
def held_force(stretch: float, c: Array) -> float:
    """What the motor's own friction leaves of its force at a stretch as it was read, N."""
    force = (c[K_HAT_P] if stretch > 0.0 else c[K_HAT_M]) * stretch
    return force - min(max(force, -c[F_FM]), c[F_FM])  # type: ignore[no-any-return]


@compiled()
def _line(course: HeldCourse, k: int, time: float) -> tuple[float, float, float]:
    """The command at a time after instant k, its rate, and until when that holds."""
    if k + 1 == len(course.t):
        return course.command[k], 0.0, np.inf
    until = course.t[k + 1]
    rate = (course.command[k + 1] - course.command[k]) / (until - course.t[k])
    return course.command[k] + rate * (time - course.t[k]), rate, until


@compiled()
def _direction(c: Array, e: float, held: float, level_m: float, level_p: float) -> float:
    """The direction in which a slide at rest breaks away; 0.0 where it stays."""
    pull = held + (c[K_SPRING_P] if e > 0.0 else c[K_SPRING_M]) * e
    if pull > level_p:
        return 1.0
    return -1.0 if pull < level_m else 0.0


@compiled()
def _walk(
    slip: Any,
    p: Array,
    c: Array,
    slipping: Array,
    course: HeldCourse,
    instant: float,
    s: float,
    t: Array,
    x0: float,
    out_x: Array,
    out_v: Array,
    tolerance: float,
    path: Array,
) -> None:
    """Fill the positions and velocities of one candidate; nan where it cannot be simulated."""
    level_p, level_m = slip(0.0, p), slip(-0.0, p)
    out_x[:], out_v[:] = np.nan, np.nan
    if not (0.0 <= level_p < np.inf and -np.inf < level_m <= 0.0 and possible(c)):
        return
    n = len(t)
    pace = (n - 1) / (t[n - 1] - t[0])
    time, x, i, steps = max(instant, course.t[0]), x0, 0, 0
    k = max(np.searchsorted(course.t, time, side="right") - 1, 0)
    v, wish = s * slipping[BAND], 0.0
    first, i = 0, samples_passed(t, 0, time, pace)
    out_x[:i], out_v[:i] = x, 0.0
    while i < n:
        goal, rate, until = _line(course, k, time)
        held = held_force(course.stretch[k], c)
        if s == 0.0:
            s = _direction(slipping, goal - x, held, level_m, level_p)
            v, wish = s * slipping[BAND], 0.0
        if s == 0.0:
            first, i = i, samples_passed(t, i, until, pace)
            out_x[first:i], out_v[first:i] = x, 0.0
            time, k = until, k + 1
            continue
        level = level_p if s > 0.0 else level_m
        rows, span, travel, v, how, wish, tries = leg(
            slip, p, slipping, goal - x, v, rate, s, level, until - time, wish, tolerance, path,
            held,
        )  # fmt: skip
        steps += tries
        if how == FAILED or steps > MOST_STEPS:
            out_x[:], out_v[:] = np.nan, np.nan
            return
        i, _ = read_samples(path, rows, time, x, t, i, t, t, out_x, out_v, True)
        x += travel
        time = later(time, span)
        if how == REST:
            s = 0.0
        if time >= until:
            time, k = until, k + 1


@compiled(
    void(
        SLIP_TYPE, _F2, _F2, _F2, _F1, _F1, _F1, _F1, float64, _F1, float64, _W2, _W2, float64,
        _I1,
    ),
    nogil=True,
)  # fmt: skip
def _rows(
    slip: Any,
    p: Array,
    c: Array,
    slipping: Array,
    edges: Array,
    command: Array,
    stretch: Array,
    instants: Array,
    s: float,
    t: Array,
    x0: float,
    out_x: Array,
    out_v: Array,
    tolerance: float,
    counter: Array,
) -> None:
    """Simulate the rows that no thread has taken yet, one after the other, until none is left."""
    path_owner = np.empty((LEG, WIDTH))
    path = borrowed(path_owner)
    course = HeldCourse(borrowed(edges), borrowed(command), borrowed(stretch))
    t = borrowed(t)
    while True:
        row = row_pool.next_row(counter)
        if row >= len(p):
            path_owner[0, 0] = 0.0  # it lives until here
            return
        _walk(
            slip, borrowed(p[row]), borrowed(c[row]), borrowed(slipping[row]), course,
            instants[row], s, t, x0, borrowed(out_x[row]), borrowed(out_v[row]), tolerance, path,
        )  # fmt: skip


def held_slips(
    law: Law, p: Array, c: Array, course: HeldCourse, instants: Array, direction: int,
    t: Array, x0: float, tolerance: float = 1.0,
) -> tuple[Array, Array]:  # fmt: skip
    """Positions and velocities, (n, N) each, of slides that rest until they break away.

    Args:
        law: The law.
        p: (n, k) parameters of it.
        c: (n, 11) constants of the slide.
        course: What pulls at it.
        instants: At which it breaks away, s, (n,).
        direction: Of the slips, +1 or -1.
        t: Samples, s, (N,), two and more.
        x0: Where it rests, m.
        tolerance: Scales the error allowed in a step.
    """
    x, v = np.empty((2, len(p), len(t)))
    start = float(course.t[0])  # seconds since 1970 leave no digits
    p, c = contiguous(p), contiguous(c)
    slipping = c.copy()
    slipping[:, [K_HAT_P, K_HAT_M]] = 0.0  # what the motor does is held
    row_pool.pool().share(
        _rows, len(p),
        (addressed(law.slip), p, c, slipping, course.t - start, course.command, course.stretch,
         np.asarray(instants, dtype=float) - start, float(direction), t - start, x0, x, v,
         tolerance),
        max(row_pool.FEWEST, row_pool.FEWEST_SAMPLES // len(t)),
    )  # fmt: skip
    return x, v
