"""The motion of a unit: what its C is translated from, and the translation.

Three functions start an axis, pass a communication step and tell its friction. All that they call,
the stepper of `rig.motion`, the parts of the axis and its friction law, is translated with them,
for this law and this axis: what is known of both is no argument in C, and what that rules out is
not there.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...friction import Law
from ...friction.law import POSITION, term_places, terms_factor
from ...rig.motion.axis_row import DEMAND, LOAD_ROOM, Chain
from ...rig.motion.drive_force import LOOP_MEMORY, demanded, driven, held_demand, mixed
from ...rig.motion.drives import INPUTS, SLIDE
from ...rig.motion.implicit import EACH, ROOM, started
from ...rig.motion.passage import MEMORY, passed
from ...rig.motion.velocity import rubs
from ...space import Array
from ..code.c import c_functions
from ..code.function_source import FunctionSource
from ..code.law_program import law_entries
from .symbol import Symbol

#: Where position and velocity stand in `at`, and beyond which they have run away.
Q, V = range(2)
FAR = 1e12


def _start(
    rub: Any, states: int, kind: int, p: Array, term: Array, c: Array, inputs: Array, held: Array,
    at: Array, z: Array, relaxed: Array, u: Array, load: Array, memory: Array, last: Array,
) -> None:  # fmt: skip
    """At rest as far as the force there lets bristles hold, or in steady motion."""
    memory[:] = 0.0
    started(rub, states, kind, p, term, c, inputs, held, 0, at[Q], at[V], u, load, last, relaxed, z)


def _advance(
    slip: Any, rub: Any, general: bool, states: int, kind: int, p: Array, term: Array, c: Array,
    inputs: Array, held: Array, n: int, span: float, tolerance: float, at: Array, z: Array,
    coarse: Array, half: Array, fine: Array, u: Array, load: Array, memory: Array, last: Array,
) -> bool:  # fmt: skip
    """Pass a span, s, in n steps and their halves; False where the motion runs away."""
    if span > 0.0:
        load[POSITION] = np.nan  # constants may be others than before
        mixed(inputs, held, 0, 0.0, u)
        if held_demand(kind, c):
            load[DEMAND] = demanded(c, u, at[Q], at[V], last)
        at[Q], at[V], _ = passed(
            slip, rub, general, states, kind, p, term, c, inputs, held, 0, n, span, tolerance,
            kind == SLIDE and states == 0, at[Q], at[V], z, coarse, half, fine, u, load, memory,
            ROOM + EACH * n,
        )  # fmt: skip
    return abs(at[Q]) < FAR and abs(at[V]) < FAR  # type: ignore[no-any-return]


def _friction(
    slip: Any, rub: Any, general: bool, states: int, kind: int, p: Array, term: Array, c: Array,
    inputs: Array, held: Array, at: Array, z: Array, out: Array, u: Array, load: Array,
) -> float:  # fmt: skip
    """The friction, and in `load` the force of the drive; at rest, what holds it."""
    load[POSITION] = np.nan  # constants may be others than before
    mixed(inputs, held, 0, 0.0, u)
    _, F, _, _ = driven(kind, c, u, at[Q], at[V], load)
    scale = terms_factor(term, p, load)
    force = rubs(slip, rub, general, scale, at[V], 0.0, z, load, p, out)
    if states == 0 and at[V] == 0.0:  # as large as what pulls at it
        lower = rubs(slip, rub, general, scale, -0.0, 0.0, z, load, p, out)
        upper = rubs(slip, rub, general, scale, 0.0, 0.0, z, load, p, out)
        force = min(max(F, lower), upper)
    return force  # type: ignore[no-any-return]


def motion_source(law: Law, kind: int, row: Sequence[Any]) -> str:
    """The three functions and all that they call, in C.

    Args:
        law: The friction.
        kind: The kind of drive.
        row: Its constants, numbers and symbols.

    Raises:
        InputError: a law or a part whose source says something that has no place in C.
    """
    bristles = max(law.states, 1)
    arrays: dict[str, int | tuple[int, int]] = {
        "p": len(law.params), "c": len(row), "inputs": (INPUTS, 2), "held": INPUTS, "at": 2,
        "u": INPUTS, "load": LOAD_ROOM, "memory": MEMORY, "last": LOOP_MEMORY,
        **dict.fromkeys(("z", "relaxed", "coarse", "half", "fine", "out"), bristles),
    }  # fmt: skip
    values = (x.function if isinstance(x, Chain) else x for x in row)
    known = {i: x for i, x in enumerate(values) if not isinstance(x, Symbol)}
    constants: dict[str, float | tuple[int, ...]] = {
        "general": law.rub is not None, "states": law.states, "kind": kind,
        "term": tuple(term_places(law).tolist()),
    }  # fmt: skip
    (friction, unread) = ("rub", "slip") if law.rub else ("slip", "rub")
    law_source = law_entries(law)[-1]
    entries = [
        FunctionSource(
            name, function, arrays, None, (unread,), constants, {friction: law_source.name},
            {"c": known},
        )
        for name, function in (("start", _start), ("advance", _advance), ("friction", _friction))
    ]  # fmt: skip
    text = c_functions([law_source, *entries], f"law {law.name} on its axis", "motion_")
    return f"/* The motion of this axis, translated from the library that made the unit. */\n{text}"
