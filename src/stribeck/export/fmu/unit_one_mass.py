"""The motion of a unit of one mass: what its C is translated from, and the translation.

Three functions start an axis, pass a communication step and tell its outputs. All that they call,
the stepper of `rig.motion`, the parts of the axis and its friction law, is translated with them,
for this law and this axis: what is known of both is no argument in C, and what that rules out is
not there.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...friction import Law
from ...friction.law import DRIVE, POSITION, term_places, terms_factor
from ...rig.motion.axis_row import DEMAND, LOAD_ROOM
from ...rig.motion.drive_force import LOOP_MEMORY, demanded, driven, held_demand, mixed
from ...rig.motion.drives import INPUTS, SLIDE
from ...rig.motion.implicit import EACH, ROOM, started
from ...rig.motion.passage import MEMORY, passed
from ...rig.motion.velocity import rubs
from ...space import Array
from ..code.law_program import law_entries
from .unit_motion import UnitMotion, known_constants, motion_source

#: What is kept: position and velocity; what the law may depend on, and what the drive keeps; what
#: the stepper remembers, and a sampled controller; the law's states.
Q, V, LOAD = range(3)
STEPPER = LOAD + LOAD_ROOM
LAST = STEPPER + MEMORY
STATES = LAST + LOOP_MEMORY
#: Beyond which an axis has run away, m or rad, and per second.
FAR = 1e12
#: Where the outputs stand.
OUT_POSITION, OUT_VELOCITY, OUT_DRIVE, OUT_FRICTION = range(4)


def _start(
    rub: Any, states: int, kind: int, p: Array, term: Array, c: Array, inputs: Array, held: Array,
    position: float, velocity: float, memory: Array, mode: Array, room: Array,  # noqa: ARG001 - of two masses
) -> None:  # fmt: skip
    """At rest as far as the force there lets bristles hold, or in steady motion."""
    memory[:] = 0.0
    memory[Q], memory[V] = position, velocity
    load, last, z = memory[LOAD:STEPPER], memory[LAST:STATES], memory[STATES:]
    u, relaxed = room[:INPUTS], room[INPUTS : INPUTS + len(z)]
    started(
        rub, states, kind, p, term, c, inputs, held, 0, position, velocity, u, load, last, relaxed,
        z,
    )  # fmt: skip


def _advance(
    slip: Any, rub: Any, general: bool, states: int, kind: int, p: Array, term: Array, c: Array,
    inputs: Array, held: Array, n: int, span: float, tolerance: float, memory: Array,
    mode: Array, room: Array,  # noqa: ARG001 - of two masses
) -> bool:  # fmt: skip
    """Pass a span, s, in n steps and their halves; False where the motion runs away."""
    load, last, z = memory[LOAD:STEPPER], memory[LAST:STATES], memory[STATES:]
    u, coarse = room[:INPUTS], room[INPUTS : INPUTS + len(z)]
    half = room[INPUTS + len(z) : INPUTS + 2 * len(z)]
    fine = room[INPUTS + 2 * len(z) : INPUTS + 3 * len(z)]
    if span > 0.0:
        load[POSITION] = np.nan  # constants may be others than before
        mixed(inputs, held, 0, 0.0, u)
        if held_demand(kind, c):
            load[DEMAND] = demanded(c, u, memory[Q], memory[V], last)
        memory[Q], memory[V], _ = passed(
            slip, rub, general, states, kind, p, term, c, inputs, held, 0, n, span, tolerance,
            kind == SLIDE and states == 0, memory[Q], memory[V], z, coarse, half, fine, u, load,
            memory[STEPPER:LAST], ROOM + EACH * n,
        )  # fmt: skip
    return abs(memory[Q]) < FAR and abs(memory[V]) < FAR  # type: ignore[no-any-return]


def _tell(
    slip: Any, rub: Any, general: bool, states: int, kind: int, p: Array, term: Array, c: Array,
    inputs: Array, held: Array, memory: Array, mode: Array, room: Array, outputs: Array,  # noqa: ARG001 - of two masses
) -> None:  # fmt: skip
    """Position and velocity, the force of the drive, and the friction; at rest, what holds it."""
    load, z, v = memory[LOAD:STEPPER], memory[STATES:], memory[V]
    u, out = room[:INPUTS], room[INPUTS : INPUTS + len(z)]
    load[POSITION] = np.nan  # constants may be others than before
    mixed(inputs, held, 0, 0.0, u)
    _, F, _, _ = driven(kind, c, u, memory[Q], v, load)
    scale = terms_factor(term, p, load)
    force = rubs(slip, rub, general, scale, v, 0.0, z, load, p, out)
    if states == 0 and v == 0.0:  # as large as what pulls at it
        lower = rubs(slip, rub, general, scale, -0.0, 0.0, z, load, p, out)
        upper = rubs(slip, rub, general, scale, 0.0, 0.0, z, load, p, out)
        force = min(max(F, lower), upper)
    outputs[OUT_POSITION], outputs[OUT_VELOCITY] = memory[Q], v
    outputs[OUT_DRIVE], outputs[OUT_FRICTION] = load[DRIVE], force


def one_mass_motion(law: Law, kind: int, row: Sequence[Any]) -> UnitMotion:
    """The motion of an axis of one mass.

    Args:
        law: The friction.
        kind: The kind of drive.
        row: Its constants, numbers and symbols.

    Raises:
        InputError: a law or a part whose source says something that has no place in C.
    """
    bristles = max(law.states, 1)
    memory, room = STATES + bristles, INPUTS + 3 * bristles
    (friction, unread) = ("rub", "slip") if law.rub else ("slip", "rub")
    law_source = law_entries(law)[-1]
    source = motion_source(
        [law_source],
        (_start, _advance, _tell),
        f"law {law.name} on its axis",
        arrays={
            "p": len(law.params), "c": len(row), "inputs": (INPUTS, 2), "held": INPUTS,
            "memory": memory, "mode": 1, "room": room, "outputs": OUT_FRICTION + 1,
        },
        drop=(unread,),
        constants={
            "general": law.rub is not None, "states": law.states, "kind": kind,
            "term": tuple(term_places(law).tolist()),
        },
        functions={friction: law_source.name},
        known={"c": known_constants(row)},
        whole=("mode",),
    )  # fmt: skip
    return UnitMotion(source, memory, 1, room)
