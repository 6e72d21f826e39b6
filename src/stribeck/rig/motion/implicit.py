"""Motion under friction of any law: implicit steps for rigs whose drive is known.

The equation of motion is m dv/dt = F(t, q) − d v + F_e(q) − F_f(v, z). A step is implicit in the
velocity, with the friction and the damping and stiffness of the drive: one scalar equation for a
velocity (`velocity.py`). Where a law has states, F_f is its force after a span at constant
velocity, which the law integrates itself, exactly or by a rule that is stable for any span. Steps
divide the interval between two samples evenly, and are halved where their error asks for it
(`passage.py`).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numba import boolean, float64, int64, types, void
from numpy.typing import NDArray

from ...compile_cache import compiled
from ...errors import InputError
from ...friction import RUB_TYPE, SLIP_TYPE
from ...friction.law import DRIVE, POSITION, term_places, terms_factor
from ...space import Array, contiguous
from . import row_pool
from .axis_row import DEMAND, LOAD_ROOM
from .drive_force import LOOP_MEMORY, demanded, driven, held_demand, loop_reset, mixed
from .drives import ENABLED, INPUTS
from .passage import MEMORY, passed
from .row_pool import borrowed
from .track import joined_tracks
from .velocity import calls_of

if TYPE_CHECKING:
    from ...friction import Law
    from .track import Track

#: Rows for each further thread: one takes milliseconds.
FEWEST = 2
#: Steps before any is halved, over a whole log: 55 hours in steps of 20 ms.
MOST_STEPS = 10_000_000
#: A motion may take so many halved steps, and so many more for each whole one: seconds at
#: most. It ends there, as if it had run away.
ROOM, EACH = 1 << 20, 64
#: The shortest way on which bristles may be stretched at the start, how often it is doubled, a way
#: on which they slide, m or rad, and a time so long, s, that no viscous force counts.
_SHORT, _DOUBLINGS, _LONG, _SLOW = 1e-12, 45, 10.0, 1e6

_F1 = types.Array(float64, 1, "C", readonly=True)
_F2 = types.Array(float64, 2, "C", readonly=True)
_W2 = float64[:, ::1]
_I1 = int64[::1]


@compiled()
def begun(
    rub: Any, scale: float, F: float, v: float, load: Array, p: Array, relaxed: Array, z: Array
) -> None:
    """The states of a law where a motion starts, into `z`.

    In motion, those of steady sliding. At rest, those on the way from relaxed bristles on which
    the friction balances the force F, or those of a long way if it never does.
    """
    relaxed[:] = 0.0
    if v != 0.0:
        rub(v, _LONG / abs(v), relaxed, load, p, z)
        return
    s, low, high = np.copysign(1.0, F), 0.0, _SHORT
    for _ in range(_DOUBLINGS):
        if s * scale * rub(s * high / _SLOW, _SLOW, relaxed, load, p, z) >= s * F:
            break
        low, high = high, 2.0 * high
    for _ in range(_DOUBLINGS):
        way = 0.5 * (low + high)
        if s * scale * rub(s * way / _SLOW, _SLOW, relaxed, load, p, z) < s * F:
            low = way
        else:
            high = way
    rub(s * low / _SLOW, _SLOW, relaxed, load, p, z)


@compiled(inline="always")
def started(
    rub: Any, states: int, kind: int, p: Array, term: Array, c: Array, inputs: Array, held: Array,
    k: int, q: float, v: float, u: Array, load: Array, last: Array, relaxed: Array, z: Array,
) -> None:  # fmt: skip
    """An axis at its first sample, k: what its controller remembers, and its law's states."""
    mixed(inputs, held, k, 0.0, u)
    load[POSITION] = np.nan  # of another axis
    if held_demand(kind, c):
        loop_reset(c, u, q, v, last)
        load[DEMAND] = last[0]
    _, F, d, _ = driven(kind, c, u, q, v, load)
    if states > 0:
        begun(rub, terms_factor(term, p, load), F - d * v, v, load, p, relaxed, z)


@compiled(
    void(
        SLIP_TYPE, RUB_TYPE, boolean, int64, int64, _F2, _I1, _F2, _F1, _I1, _F2, _I1, _I1, _F2,
        float64, _W2, _W2, _W2, _I1,
    ),
    nogil=True,
)  # fmt: skip
def _rows(  # a loop over candidates and samples
    slip: Any, rub: Any, general: bool, states: int, kind: int, p: Array, term: Array, c: Array,
    t: Array, first: Array, inputs: Array, held: Array, parts: Array, start: Array,
    tolerance: float, out_q: Array, out_v: Array, out_F: Array, counter: Array,
) -> None:  # fmt: skip
    """Simulate the motions that no thread has taken yet, one after the other, until none is left.

    A motion is a candidate's over a track: all candidates over the first track, then over the
    next; track i has the samples from `first[i]` to the next one's first.
    """
    term, t, parts = borrowed(term), borrowed(t), borrowed(parts)
    inputs, held, start = borrowed(inputs), borrowed(held), borrowed(start)
    states_owner = np.empty((6, max(states, 1)))
    u_owner, load_owner = np.zeros(INPUTS), np.empty(LOAD_ROOM)
    memory_owner, last_owner = np.empty(MEMORY), np.empty(LOOP_MEMORY)
    u_owner[ENABLED] = 1.0
    u, load, memory = borrowed(u_owner), borrowed(load_owner), borrowed(memory_owner)
    last = borrowed(last_owner)
    z, coarse, half, fine = (
        borrowed(states_owner[0]), borrowed(states_owner[1]), borrowed(states_owner[2]),
        borrowed(states_owner[3]),
    )  # fmt: skip
    while True:
        job = row_pool.next_row(counter)
        if job >= len(start):
            states_owner[0, 0] = u_owner[0] = load_owner[0] = memory_owner[0] = 0.0  # kept alive
            last_owner[0] = 0.0
            return
        i, row = job // len(p), job % len(p)
        begin, end = first[i], first[i + 1]
        a, b = borrowed(p[row]), borrowed(c[job])
        q, v = start[job, 0], start[job, 1]
        memory[:] = 0.0
        steps_left = ROOM + EACH * parts[begin : end - 1].sum()
        holds = held_demand(kind, b)
        started(rub, states, kind, a, term, b, inputs, held, begin, q, v, u, load, last, coarse, z)
        for k in range(begin, end):
            mixed(inputs, held, k, 0.0, u)
            if holds:
                load[DEMAND] = demanded(b, u, q, v, last)
            driven(kind, b, u, q, v, load)
            out_q[row, k], out_v[row, k], out_F[row, k] = q, v, load[DRIVE]
            if k == end - 1 or not (abs(q) < 1e12 and abs(v) < 1e12):  # noqa: PLR2004
                break
            q, v, steps_left = passed(
                slip, rub, general, states, kind, a, term, b, inputs, held, k, parts[k],
                t[k + 1] - t[k], tolerance, False, q, v, z, coarse, half, fine, u, load, memory,
                steps_left,
            )  # fmt: skip


def motions(
    law: Law, kind: int, p: Array, c: Array, track: Track, step: float, tolerance: float
) -> tuple[Array, Array, Array]:
    """The motions over one track; see `motions_over`. Its constants c are (n, constants)."""
    return motions_over(law, kind, p, c[None], (track,), step, tolerance)


def motions_over(
    law: Law,
    kind: int,
    p: Array,
    c: Array,
    tracks: Sequence[Track],
    step: float,
    tolerance: float,
) -> tuple[Array, Array, Array]:
    """Position, velocity and drive force, (n, N) each; nan from where a motion runs away.

    Nan stands, too, from where a motion takes too many steps. N are the samples of all tracks, one
    track after the other.

    Args:
        law: Any friction law.
        kind: The kind of drive.
        p: (n, k) parameters of the law.
        c: (tracks, n, constants) constants of the drive.
        tracks: Sample times, inputs (m, N), which of them are held, and the start.
        step: No step is longer, s.
        tolerance: Steps are halved until their error is less, m or rad, that of the velocity over
            an unhalved one.

    Raises:
        InputError: so many steps that nobody would wait for them.
    """
    n = len(p)
    q, v, F = np.full((3, n, sum(len(track.t) for track in tracks)), np.nan)
    if not n:
        return q, v, F
    t, first, inputs, held, start = joined_tracks(tracks, n)
    parts = steps_between(t, first, step)
    row_pool.pool().share(
        _rows, len(start),
        (
            *calls_of(law), law.states, kind, contiguous(p), term_places(law),
            contiguous(np.concatenate(c)), t, first, inputs, held, parts, start, tolerance, q, v, F,
        ),
        max(FEWEST, row_pool.FEWEST_SAMPLES * len(tracks) // max(len(t), 1)),
    )  # fmt: skip
    return q, v, F


def steps_between(t: Array, first: NDArray[np.int64], step: float) -> NDArray[np.int64]:
    """How many steps there are from each sample to the next, (N,); one from the last of a track.

    Raises:
        InputError: so many steps that nobody would wait for them.
    """
    with np.errstate(over="ignore"):
        many = np.maximum(np.ceil(np.diff(t, append=t[-1]) / step - 1e-9), 1)
    total = np.add.reduceat(many, first[:-1])
    if not total.max() <= MOST_STEPS:
        worst = int(np.argmax(total))
        raise InputError(
            f"{t[first[worst + 1] - 1]:.6g} s in steps of {step:.3g} s are {total[worst]:.3g} "
            f"steps, and {MOST_STEPS:,} is the most: set a longer step, or split the log at its "
            "gaps"
        )
    return many.astype(np.int64)
