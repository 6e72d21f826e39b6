"""The motion of a unit of two masses: what its C is translated from, and the translation.

As `unit_one_mass` has it of one: the stepper is that of `rig.motion.coupled_passage`, with a law on
each side or on one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...friction import Law
from ...friction.law import DRIVE, EXTERNAL, POSITION, term_places, terms_factor
from ...rig.motion.axis_row import DEMAND
from ...rig.motion.coupled_implicit import REMEMBERED
from ...rig.motion.coupled_motions import ROOM_BETWEEN, rubbing_of
from ...rig.motion.coupled_passage import ROWS, STAGES, coupled_passage, near
from ...rig.motion.coupled_rates import (
    EVENTS,
    FLANK,
    FRICTION,
    HELD_BRISTLES,
    LOAD,
    LOAD_RUBS,
    LOAD_STATES,
    MODES,
    MOTOR,
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
    coupled_rates,
    read_position,
)
from ...rig.motion.coupled_start import coupled_start, held_rubbing
from ...rig.motion.coupling import (
    JOINED,
    MOTOR_ROW,
    CouplingConstants,
    coupled_at,
    coupling_constants,
)
from ...rig.motion.drive_force import LOOP_MEMORY, demanded, mixed
from ...rig.motion.drives import FOLLOWS, HOLD, INPUTS
from ...rig.motion.implicit import EACH
from ...rig.motion.velocity import no_slip, rubs
from ...space import Array
from ..code.function_source import FunctionSource
from ..code.law_program import law_entries
from .symbol import Symbol
from .unit_motion import UnitMotion, known_constants, motion_source

#: What is kept: the twist of the spring and the last whole step, as a share of an interval; what
#: the motor's and the load's law may depend on; what a sampled controller and the stepper remember;
#: positions, velocities and the states of both laws.
TWIST, PIECE, MOTOR_SIDE = range(3)
LOAD_SIDE = MOTOR_SIDE + SIDE_ROOM
LAST = LOAD_SIDE + SIDE_ROOM
STEPPER = LAST + LOOP_MEMORY
STATES = STEPPER + 2 * REMEMBERED
#: Room within a step: inputs, distances from events, rates, and what a passage needs.
DISTANCES = INPUTS
RATES = DISTANCES + EVENTS
PASSAGE = RATES + STAGES * STATE
#: Where the outputs stand; the frictions come after these.
(
    OUT_POSITION, OUT_VELOCITY, OUT_DRIVE, OUT_MOTOR_POSITION, OUT_MOTOR_VELOCITY, OUT_COUPLING,
    OUT_FRICTION,
) = range(7)  # fmt: skip


@dataclass(frozen=True)
class RubbedSide:
    """The friction of a side of the axis.

    Args:
        law: It; None for none.
        begin: Where its parameters begin, counted from those of the axis's law.
        output: Where it stands among the outputs.
    """

    law: Law | None
    begin: int = 0
    output: int = 0


def _start(
    slip_m: Any, rub_m: Any, begin_m: int, term_m: Array, slip: Any, rub: Any, begin: int,
    term: Array, p: Array, c: Array, inputs: Array, held: Array, position: float, velocity: float,
    memory: Array, mode: Array, room: Array,
) -> None:  # fmt: skip
    """At rest as far as the forces there let bristles hold, or in steady motion."""
    memory[:] = 0.0
    memory[PIECE] = 1.0
    y, u = memory[STATES:], room[:INPUTS]
    y[Q], y[V] = position, velocity
    mixed(inputs, held, 0, 0.0, u)
    coupled_start(
        slip_m, rub_m, p[begin_m:], term_m, slip, rub, p[begin:], term, c, u, np.nan, 0.0, y,
        mode, memory[MOTOR_SIDE:LOAD_SIDE], memory[LOAD_SIDE:LAST], memory[LAST:STEPPER],
        room[RATES:PASSAGE].reshape(STAGES, STATE), room[PASSAGE:].reshape(ROWS, len(y)),
        room[DISTANCES:RATES], memory[STEPPER:STATES].reshape(2, REMEMBERED),
    )  # fmt: skip


def _advance(
    slip_m: Any, rub_m: Any, begin_m: int, term_m: Array, slip: Any, rub: Any, begin: int,
    term: Array, p: Array, c: Array, inputs: Array, held: Array, n: int, span: float,
    tolerance: float, memory: Array, mode: Array, room: Array,
) -> bool:  # fmt: skip
    """Pass a span, s, in n steps or more; False where the motion runs away."""
    y, u = memory[STATES:], room[:INPUTS]
    if span > 0.0:
        load_m, load = memory[MOTOR_SIDE:LOAD_SIDE], memory[LOAD_SIDE:LAST]
        coupling, axis = coupling_constants(c), c[MOTOR_ROW:]
        load_m[POSITION] = load[POSITION] = np.nan  # constants may be others than before
        if (coupling.play > 0.0) != (mode[FLANK] != JOINED):
            mode[FLANK] = coupled_at(coupling, y[Q_M] - y[Q])
        mixed(inputs, held, 0, 0.0, u)
        if axis[HOLD] > FOLLOWS:
            read = read_position(coupling, y[Q_M], y[Q])
            load_m[DEMAND] = demanded(axis, u, read, y[V_M], memory[LAST:STEPPER])
        memory[TWIST], memory[PIECE], _ = coupled_passage(
            slip_m, rub_m, p[begin_m:], term_m, slip, rub, p[begin:], term, c, inputs, held, 0, n,
            span, tolerance, y, memory[TWIST], mode, u, load_m, load,
            room[RATES:PASSAGE].reshape(STAGES, STATE), room[PASSAGE:].reshape(ROWS, len(y)),
            memory[STEPPER:STATES].reshape(2, REMEMBERED), memory[PIECE], ROOM_BETWEEN + EACH * n,
        )  # fmt: skip
    return near(y)  # type: ignore[no-any-return]


def _held_back(
    slip: Any, rub: Any, rubbing: int, term: Array, p: Array, side: int, load: Array, z: Array,
    out: Array,
) -> float:  # fmt: skip
    """The friction of a side after `coupled_rates`; at rest, as large as what pulls at it."""
    if side != 0 or rubbing == HELD_BRISTLES:
        return load[FRICTION]  # type: ignore[no-any-return]
    general, scale = rubbing != PLAIN, terms_factor(term, p, load)
    lower = rubs(slip, rub, general, scale, -0.0, 0.0, z, load, p, out)
    upper = rubs(slip, rub, general, scale, 0.0, 0.0, z, load, p, out)
    return min(max(load[DRIVE] + load[EXTERNAL], lower), upper)  # type: ignore[no-any-return]


def _tell(
    slip_m: Any, rub_m: Any, begin_m: int, output_m: int, term_m: Array, slip: Any, rub: Any,
    begin: int, output: int, term: Array, p: Array, c: Array, inputs: Array, held: Array,
    memory: Array, mode: Array, room: Array, outputs: Array,
) -> None:  # fmt: skip
    """Positions and velocities, forces of the drive and the coupling, and the frictions."""
    y, u, load_m, load = (
        memory[STATES:], room[:INPUTS], memory[MOTOR_SIDE:LOAD_SIDE], memory[LOAD_SIDE:LAST],
    )  # fmt: skip
    own, out = STATE + mode[MOTOR_STATES], room[PASSAGE : PASSAGE + len(y)]
    z_m, z, out_m, out_l = y[STATE:own], y[own:], out[STATE:own], out[own:]
    load_m[POSITION] = load[POSITION] = np.nan  # constants may be others than before
    mixed(inputs, held, 0, 0.0, u)
    outputs[OUT_COUPLING] = coupled_rates(
        slip_m, rub_m, p[begin_m:], term_m, slip, rub, p[begin:], term, c, u, y, memory[TWIST],
        mode, load_m, load, z_m, z, 0.0, out_m, out_l, room[RATES : RATES + STATE],
        room[DISTANCES:RATES],
    )  # fmt: skip
    outputs[OUT_POSITION], outputs[OUT_VELOCITY] = y[Q], y[V]
    outputs[OUT_MOTOR_POSITION], outputs[OUT_MOTOR_VELOCITY] = y[Q_M], y[V_M]
    outputs[OUT_DRIVE] = load_m[DRIVE]
    if output >= 0:
        outputs[output] = _held_back(
            slip, rub, mode[LOAD_RUBS], term, p[begin:], mode[LOAD], load, z, out_l
        )
    if output_m >= 0:
        outputs[output_m] = _held_back(
            slip_m, rub_m, mode[MOTOR_RUBS], term_m, p[begin_m:], mode[MOTOR], load_m, z_m, out_m
        )


def two_mass_motion(
    motor: RubbedSide, load: RubbedSide, parameters: int, row: Sequence[Any]
) -> UnitMotion:
    """The motion of an axis of two masses.

    Args:
        motor: Its friction.
        load: Likewise.
        parameters: How many values of the unit there are from the first of its law's.
        row: The constants of coupling, motor and load, numbers and symbols.

    Raises:
        InputError: a law or a part whose source says something that has no place in C.
    """
    coupling = CouplingConstants(*row[: len(CouplingConstants._fields)])
    ideal = not any(isinstance(x, Symbol) for x in (coupling.forward, coupling.backward))
    lossy = not (ideal and coupling.forward == coupling.backward == 1.0)
    rubbing = {
        MOTOR_RUBS: rubbing_of(motor.law),
        LOAD_RUBS: held_rubbing(rubbing_of(load.law), lossy),
    }
    states = {
        MOTOR_STATES: motor.law.states if motor.law else 0,
        LOAD_STATES: load.law.states if load.law else 0,
    }
    size = STATE + sum(states.values())
    memory, room = STATES + size, PASSAGE + ROWS * size
    constants: dict[str, float | tuple[int, ...]] = {}
    functions: dict[str, str] = {}
    sources: dict[str, FunctionSource] = {}
    for end, side, rubs_there in (("_m", motor, MOTOR_RUBS), ("", load, LOAD_RUBS)):
        law, general = side.law, side.law is not None and side.law.rub is not None
        constants |= {
            f"begin{end}": side.begin,
            f"output{end}": -1 if law is None else side.output,
            f"term{end}": (-1, -1, 0) if law is None else tuple(term_places(law).tolist()),
        }
        if rubbing[rubs_there] == SMOOTH:
            continue
        source = FunctionSource("frictionless", no_slip, {"p": 0})
        if law is not None:
            source = law_entries(law)[-1]
            name = source.name if load.law is law or load.law is None else f"{source.name}{end}"
            source = replace(source, name=name)
        sources[source.name] = source
        functions[f"{'rub' if general else 'slip'}{end}"] = source.name
    names = {"slip_m", "rub_m", "slip", "rub"}
    text = motion_source(
        list(sources.values()),
        (_start, _advance, _tell),
        " and ".join(
            f"law {side.law.name} of the {word}"
            for side, word in ((motor, "motor"), (load, "load"))
            if side.law
        ),
        arrays={
            "p": parameters, "c": len(row), "inputs": (INPUTS, 2), "held": INPUTS,
            "memory": memory, "mode": MODES, "room": room, "outputs": OUT_FRICTION + 2,
        },
        drop=tuple(sorted(names - functions.keys())),
        constants=constants,
        functions=functions,
        known={"c": known_constants(row), "mode": rubbing | states},
        whole=("mode",),
    )  # fmt: skip
    return UnitMotion(text, memory, MODES, room)
