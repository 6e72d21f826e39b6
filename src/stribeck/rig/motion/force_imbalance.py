"""The forces that a measured motion leaves out of balance, under a drive that the stepper knows."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numba import boolean, float64, int64, types, void

from ...compile_cache import compiled
from ...friction import RUB_SIGNATURE, RUB_TYPE, SLIP_TYPE, addressed
from ...friction.law import DRIVE, term_places, terms_factor
from ...space import Array
from .drive_force import commanded, driven, joint_constants, mixed
from .drives import JOINT
from .velocity import NO_RUB

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
        kind: The kind of drive, no cascade.
        p: (n, k) parameters of the law.
        c: (n, WIDTH) constants of the drive.
        track: Times and inputs of the samples.
        motion: Position, velocity and acceleration there, (N,) each.
    """
    general = law.rub is not None
    out = np.empty((len(p), len(track.t)))
    for row in range(len(p)):
        _imbalances(
            addressed(law.slip), addressed(law.rub if general else NO_RUB, RUB_SIGNATURE),
            general, kind, _ready(p[row]), term_places(law), _ready(c[row]),
            _ready(track.inputs), track.held.astype(np.int64),
            *(_ready(x) for x in motion), out[row],
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
    u, load = np.empty(len(inputs)), np.zeros(5)
    none = np.empty(0)
    hold = joint_constants(c).hold if kind == JOINT else 0.0
    mixed(inputs, held, 0, 0.0, u)
    last = commanded(c, u, q[0], v[0]) if hold > 0.0 else 0.0
    for k in range(len(q)):
        mixed(inputs, held, k, 0.0, u)
        if hold > 0.0:
            torque = commanded(c, u, q[k], v[k])
            load[DRIVE] = torque if hold == 1.0 else last
            last = torque
        mass, force, damping, _ = driven(kind, c, u, q[k], v[k], load)
        scale = terms_factor(term, p, load)
        level = rub(v[k], 0.0, none, load, p, none) if general else slip(v[k], p)
        out[k] = force - damping * v[k] - mass * a[k] - scale * level


def _ready(x: Any) -> Array:
    return np.ascontiguousarray(x, dtype=float)
