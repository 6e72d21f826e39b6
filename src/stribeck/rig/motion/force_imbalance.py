"""The forces that a measured motion leaves out of balance, under a drive that the stepper knows."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numba import boolean, float64, int64, types, void

from ...compile_cache import compiled
from ...friction import RUB_TYPE, SLIP_TYPE
from ...friction.law import POSITION, term_places, terms_factor
from ...space import Array, contiguous
from .axis_row import DEMAND, LOAD_ROOM
from .drive_force import LOOP_MEMORY, demanded, driven, held_demand, loop_reset, mixed
from .drives import AXIS, ENABLED, INPUTS
from .velocity import calls_of

if TYPE_CHECKING:
    from ...friction import Law
    from .track import Track

_F1 = types.Array(float64, 1, "C", readonly=True)
_F2 = types.Array(float64, 2, "C", readonly=True)
_I1 = int64[::1]


def imbalances(
    law: Law, kind: int, p: Array, c: Array, track: Track, motion: tuple[Array, Array, Array]
) -> Array:
    """Drive and surroundings less inertia and friction, N (N m), (n, N).

    Args:
        law: A friction law without states.
        kind: The kind of drive.
        p: (n, k) parameters of the law.
        c: (n, constants) constants of the drive.
        track: Times and inputs of the samples.
        motion: Position, velocity and acceleration there, (N,) each.
    """
    out = np.empty((len(p), len(track.t)))
    for row in range(len(p)):
        _imbalances(
            *calls_of(law), kind, contiguous(p[row]), term_places(law), contiguous(c[row]),
            contiguous(track.inputs), track.held.astype(np.int64),
            *(contiguous(x) for x in motion), out[row],
        )  # fmt: skip
    return out


@compiled(
    void(
        SLIP_TYPE, RUB_TYPE, boolean, int64, _F1, _I1, _F1, _F2, _I1, _F1, _F1, _F1,
        float64[::1],
    )
)  # fmt: skip
def _imbalances(
    slip: Any, rub: Any, general: bool, kind: int, p: Array, term: Array, c: Array,
    inputs: Array, held: Array, q: Array, v: Array, a: Array, out: Array,
) -> None:  # fmt: skip
    u, load, last = np.zeros(INPUTS), np.zeros(LOAD_ROOM), np.zeros(LOOP_MEMORY)
    u[ENABLED], load[POSITION] = 1.0, np.nan
    none = np.empty(0)
    holds = held_demand(kind, c)
    mixed(inputs, held, 0, 0.0, u)
    if holds:
        loop_reset(c, u, q[0], v[0], last)
    for k in range(len(q)):
        mixed(inputs, held, k, 0.0, u)
        if holds:
            load[DEMAND] = demanded(c, u, q[k], v[k], last)
        mass, force, damping, _ = driven(kind, c, u, q[k], v[k], load)
        scale = terms_factor(term, p, load)
        level = rub(v[k], 0.0, none, load, p, none) if general else slip(v[k], p)
        out[k] = force - damping * v[k] - mass * a[k] - scale * level


def resting_forces(c: Array, resting: Array) -> Array:
    """What pulls at axes at rest, friction apart, N (N m), (n, instants).

    A sampled controller has computed its demand there; what it may have integrated is not known.

    Args:
        c: (n, constants) constants of composed axes.
        resting: (instants, 1 + INPUTS) the position, then the inputs.
    """
    out = np.empty((len(c), len(resting)))
    _resting_forces(contiguous(c), contiguous(resting), out)
    return out


@compiled(void(_F2, _F2, float64[:, ::1]))
def _resting_forces(c: Array, resting: Array, out: Array) -> None:
    load, last = np.zeros(LOAD_ROOM), np.zeros(LOOP_MEMORY)
    for row in range(len(c)):
        load[POSITION] = np.nan  # of another axis
        for k in range(len(resting)):
            q, u = resting[k, 0], resting[k, 1:]
            if held_demand(AXIS, c[row]):
                loop_reset(c[row], u, q, 0.0, last)
                load[DEMAND] = last[0]
            _, out[row, k], _, _ = driven(AXIS, c[row], u, q, 0.0, load)
