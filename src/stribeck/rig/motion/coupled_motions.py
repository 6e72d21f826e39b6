"""Motion of two masses that a spring with play joins, under friction of any law on each side.

The rows of `coupled_passage` over candidates and logs: of each a start at the load's position and
velocity, the motor where its coupling has it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numba import float64, int64, types, void

from ...compile_cache import compiled
from ...friction import RUB_TYPE, SLIP_TYPE
from ...friction.law import DRIVE, term_places
from ...space import Array, contiguous
from . import row_pool
from .axis_row import DEMAND
from .coupled_implicit import REMEMBERED
from .coupled_passage import ROWS, STAGES, coupled_passage
from .coupled_rates import (
    BRISTLES,
    EVENTS,
    GENERAL,
    LOAD_RUBS,
    LOAD_STATES,
    MODES,
    MOTOR_RUBS,
    MOTOR_STATES,
    PLAIN,
    Q_M,
    SIDE_ROOM,
    SMOOTH,
    STATE,
    V_M,
    Q,
    V,
    read_position,
)
from .coupled_start import coupled_start, held_rubbing
from .coupling import MOTOR_ROW, coupling_constants
from .drive_force import LOOP_MEMORY, demanded, mixed
from .drives import ENABLED, FOLLOWS, HOLD, INPUTS
from .implicit import EACH, FEWEST, ROOM, steps_between
from .row_pool import borrowed
from .track import joined_tracks
from .velocity import calls_of

if TYPE_CHECKING:
    from ...friction import Law
    from .track import Track

#: Of the steps that a motion may take, so many between two samples, beside those for each whole
#: step: where events follow each other without end, more would not lead further.
ROOM_BETWEEN = 1 << 16

_F1 = types.Array(float64, 1, "C", readonly=True)
_F2 = types.Array(float64, 2, "C", readonly=True)
_W2 = float64[:, ::1]
_I1 = int64[::1]


@compiled(
    void(
        SLIP_TYPE, RUB_TYPE, int64, int64, _F2, _I1, SLIP_TYPE, RUB_TYPE, int64, int64, _F2, _I1,
        _F2, _F1, _I1, _F2, _I1, _I1, _F2, float64, _W2, _W2, _W2, _W2, _W2, _I1,
    ),
    nogil=True,
)  # fmt: skip
def _rows(
    slip_m: Any, rub_m: Any, rubbing_m: int, states_m: int, p_m: Array, term_m: Array, slip: Any,
    rub: Any, rubbing: int, states: int, p: Array, term: Array, c: Array, t: Array, first: Array,
    inputs: Array, held: Array, parts: Array, start: Array, tolerance: float,
    out_q_m: Array, out_v_m: Array, out_q: Array, out_v: Array, out_F: Array, counter: Array,
) -> None:  # fmt: skip
    """Simulate the motions that no thread has taken yet, one after the other, until none is left.

    A motion is a candidate's over a track, in the order of `implicit.motions_over`.
    """
    term_m, term, t, parts = borrowed(term_m), borrowed(term), borrowed(t), borrowed(parts)
    inputs, held, start = borrowed(inputs), borrowed(held), borrowed(start)
    size = STATE + states_m + states
    owner, stages, modes = (
        np.zeros((5, SIDE_ROOM + INPUTS)),
        np.empty((STAGES, STATE)),
        np.zeros(MODES, np.int64),
    )
    states_owner, memory_owner = np.zeros((1 + ROWS, size)), np.empty((2, REMEMBERED))
    u, load_m, load = (
        borrowed(owner[0, :INPUTS]),
        borrowed(owner[1, :SIDE_ROOM]),
        borrowed(owner[2, :SIDE_ROOM]),
    )
    last, mode = borrowed(owner[3, :LOOP_MEMORY]), borrowed(modes)
    y, room, rates = borrowed(states_owner[0]), borrowed(states_owner[1:]), borrowed(stages)
    memory, g = borrowed(memory_owner), borrowed(owner[4, :EVENTS])
    while True:
        job = row_pool.next_row(counter)
        if job >= len(start):
            owner[0, 0] = stages[0, 0] = modes[0] = 0  # kept alive
            states_owner[0, 0] = memory_owner[0, 0] = 0.0
            return
        i, row = job // len(p), job % len(p)
        begin, end = first[i], first[i + 1]
        a_m, a, b = borrowed(p_m[row]), borrowed(p[row]), borrowed(c[job])
        axis, coupling = b[MOTOR_ROW:], coupling_constants(b)
        u[:] = 0.0
        u[ENABLED] = 1.0
        y[Q], y[V] = start[job, 0], start[job, 1]
        lossy = coupling.forward != 1.0 or coupling.backward != 1.0
        mode[MOTOR_RUBS], mode[LOAD_RUBS] = rubbing_m, held_rubbing(rubbing, lossy)
        mode[MOTOR_STATES], mode[LOAD_STATES] = states_m, states
        twist, piece, steps_left = 0.0, 1.0, ROOM + EACH * parts[begin : end - 1].sum()
        holds = axis[HOLD] > FOLLOWS
        mixed(inputs, held, begin, 0.0, u)
        coupled_start(
            slip_m, rub_m, a_m, term_m, slip, rub, a, term, b, u, start[job, 2], start[job, 3], y,
            mode, load_m, load, last, rates, room, g, memory,
        )  # fmt: skip
        for k in range(begin, end):
            mixed(inputs, held, k, 0.0, u)
            if holds:
                read = read_position(coupling, y[Q_M], y[Q])
                load_m[DEMAND] = demanded(axis, u, read, y[V_M], last)
            out_q_m[row, k], out_v_m[row, k] = y[Q_M], y[V_M]
            out_q[row, k], out_v[row, k], out_F[row, k] = y[Q], y[V], load_m[DRIVE]
            if k == end - 1 or not np.isfinite(y[Q]):
                break
            most = min(steps_left, ROOM_BETWEEN + EACH * parts[k])
            twist, piece, left = coupled_passage(
                slip_m, rub_m, a_m, term_m, slip, rub, a, term, b, inputs, held, k, parts[k],
                t[k + 1] - t[k], tolerance, y, twist, mode, u, load_m, load, rates, room, memory,
                piece, most,
            )  # fmt: skip
            steps_left -= most - left


def motions_of_two(
    laws: tuple[Law | None, Law | None],
    p: tuple[Array, Array],
    c: Array,
    tracks: Sequence[Track],
    step: float,
    tolerance: float,
) -> tuple[Array, Array, Array, Array, Array]:
    """Position and velocity of motor and load, and the motor's force, (n, N) each.

    Nan from where a motion runs away or takes too many steps. N are the samples of all tracks, one
    track after the other.

    Args:
        laws: Friction of the motor and of the load; None for none.
        p: Their parameters, (n, k) each.
        c: (tracks, n, constants): rows as `coupled_row` makes them.
        tracks: Sample times, inputs (m, N), which of them are held, and the start: the load's
            position, or the motor's where that is what is read. Where it is not known by how much
            the motor is ahead, it is at the flank that drives a load that moves, and at a rest
            where the coupling has it.
        step: No step is longer, s.
        tolerance: Error of a whole step at most, m or rad.

    Raises:
        InputError: so many steps that nobody would wait for them.
    """
    n = len(p[0])
    out = np.full((5, n, sum(len(track.t) for track in tracks)), np.nan)
    if not n:
        return out[0], out[1], out[2], out[3], out[4]
    t, first, inputs, held, start = joined_tracks(tracks, n)
    parts = steps_between(t, first, step)
    ahead = [[s.reading.ahead, s.reading.by_motor and np.isnan(s.reading.ahead)] for s in tracks]
    start = np.column_stack([start, np.repeat(ahead, n, axis=0)])
    sides: list[Any] = []
    for law, own in zip(laws, p, strict=True):
        slip, rub, _ = calls_of(law)
        sides += [
            slip, rub, rubbing_of(law), 0 if law is None else law.states, contiguous(own),
            np.array([-1, -1, 0]) if law is None else term_places(law),
        ]  # fmt: skip
    row_pool.pool().share(
        _rows, len(start),
        (
            *sides, contiguous(np.concatenate(c)), t, first, inputs, held, parts, start,
            tolerance, *out,
        ),
        max(FEWEST, row_pool.FEWEST_SAMPLES * len(tracks) // max(len(t), 1)),
    )  # fmt: skip
    return out[0], out[1], out[2], out[3], out[4]


def rubbing_of(law: Law | None) -> int:
    """What rubs on a side under a law."""
    if law is None:
        return SMOOTH
    if law.states:
        return BRISTLES
    return PLAIN if law.rub is None else GENERAL
