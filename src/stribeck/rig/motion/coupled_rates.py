"""The rates of an axis of two masses in an instant, and how far it is from its next event.

    M_m v_m' = F_m(u, q, v_m) − T − F_f,m(v_m)        the motor, with what drives it
    M v' = η T + F_e(u, q) − F_f(v)                   the load, with what acts on it

Everything is at the load: the motor's position, inertia and friction times or over the ratio of
the gear. `drive_force` has F_m and F_e, `coupling` has T. Each side slides forward or backward, or
sticks; the coupling is at a flank of its play, or between them. As long as none of these changes
the rates are smooth. What would change them first stands in five numbers that are below zero until
then: for each side how fast it slides yet, or, where it sticks, the force on it beyond its
breakaway level; for the coupling the force that presses it against its flank, or the way to the
next one.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ...compile_cache import compiled
from ...friction.law import DRIVE, EXTERNAL, terms_factor
from ...space import Array
from .coupling import (
    FREE,
    JOINED,
    LOAD_ROW,
    MOTOR_ROW,
    CouplingConstants,
    coupling_constants,
    coupling_force,
    relaxed_twist,
)
from .drive_force import driven
from .drives import AXIS, EXTERNAL_FORCE
from .velocity import rubs

#: The state: position and velocity of the motor and of the load.
Q_M, V_M, Q, V = range(4)
STATE = 4
#: The modes of the two sides (−1, 0, +1), where the coupling is, and what rubs on each side.
MOTOR, LOAD, FLANK, MOTOR_RUBS, LOAD_RUBS = range(5)
MODES = 5
#: What rubs on a side: nothing, a law of its velocity alone, a law that reads loads.
SMOOTH, PLAIN, GENERAL = range(3)
#: Numbers that are below zero until an event of the motor, of the load, of the coupling.
EVENTS = 3


@compiled(forceinline=True)
def read_position(coupling: CouplingConstants, q_m: float, q: float) -> float:
    """The position that a controller reads."""
    return q if coupling.by_load > 0.5 else q_m + coupling.zero  # noqa: PLR2004 - a flag


@compiled(forceinline=True)
def _resisted(
    slip: Any, rub: Any, p: Array, term: Array, load: Array, none: Array, side: int, rubbing: int,
    v: float, force: float,
) -> tuple[float, float]:  # fmt: skip
    """The force on a side with its friction, and how far it is from its event.

    Args:
        slip: Its law, as all further ones to `none`.
        rub: The law as one that reads loads.
        p: The law's parameters.
        term: Places of the law's terms.
        load: What the law may depend on.
        none: No states.
        side: Its mode.
        rubbing: What rubs on it.
        v: Its velocity.
        force: On it, friction apart.
    """
    if rubbing == SMOOTH:
        return force, -1.0
    general = rubbing == GENERAL
    scale = terms_factor(term, p, load)
    if side == 0:
        way = 1.0 if force > 0.0 else -1.0
        level = rubs(slip, rub, general, scale, way * 0.0, 0.0, none, load, p, none)
        return 0.0, way * (force - level)
    slides = v if side * v > 0.0 else np.copysign(0.0, side)
    return force - rubs(slip, rub, general, scale, slides, 0.0, none, load, p, none), -side * v


@compiled(forceinline=True)
def coupled_rates(
    slip_m: Any, rub_m: Any, p_m: Array, term_m: Array, slip: Any, rub: Any, p: Array,
    term: Array, c: Array, u: Array, y: Array, twist: float, mode: Array,
    load_m: Array, load: Array, none: Array, rate: Array, g: Array,
) -> float:  # fmt: skip
    """The rates of the state into `rate`, distances from events into `g`; T.

    Args:
        slip_m: The law of the motor's side, as all further ones to `term_m`.
        rub_m: The same as a law that reads loads.
        p_m: Its parameters.
        term_m: Places of its terms.
        slip: The law of the load's side, as all further ones to `term`.
        rub: The same as a law that reads loads.
        p: Its parameters.
        term: Places of its terms.
        c: Constants, a row as `coupled_row` makes it.
        u: Inputs.
        y: The state.
        twist: Of the spring, where the coupling is between its flanks.
        mode: The modes.
        load_m: What the motor's law depends on, and its demand where that is held.
        load: What the load's law depends on.
        none: No states.
        rate: Of the state, (4,).
        g: Distances from events, (3,).
    """
    coupling = coupling_constants(c)
    ahead, closing = y[Q_M] - y[Q], y[V_M] - y[V]
    T = coupling_force(coupling, mode[FLANK], ahead, closing)
    if mode[FLANK] == FREE:
        g[2] = abs(ahead - twist) - 0.5 * coupling.play
    else:
        g[2] = -1.0 if mode[FLANK] == JOINED else -mode[FLANK] * T
    external = u[EXTERNAL_FORCE]
    u[EXTERNAL_FORCE] = 0.0
    read = read_position(coupling, y[Q_M], y[Q])
    mass, F, d, _ = driven(AXIS, c[MOTOR_ROW:], u, read, y[V_M], load_m)
    u[EXTERNAL_FORCE] = external
    load_m[EXTERNAL] = -T
    F, g[0] = _resisted(
        slip_m, rub_m, p_m, term_m, load_m, none, mode[MOTOR], mode[MOTOR_RUBS],
        y[V_M], F - d * y[V_M] - T,
    )  # fmt: skip
    rate[Q_M], rate[V_M] = y[V_M], F / mass
    mass, F, _, _ = driven(AXIS, c[int(c[LOAD_ROW]) :], u, y[Q], y[V], load)
    way = float(mode[LOAD])  # that in which the load moves, or would
    if mode[LOAD_RUBS] == SMOOTH or mode[LOAD] == 0:
        way = y[V] if y[V] != 0.0 else F + T
    passed = T * (coupling.forward if T * way >= 0.0 else coupling.backward)
    load[DRIVE] = passed
    F, g[1] = _resisted(
        slip, rub, p, term, load, none, mode[LOAD], mode[LOAD_RUBS], y[V], F + passed
    )
    rate[Q], rate[V] = y[V], F / mass
    return T  # type: ignore[no-any-return]


@compiled(forceinline=True)
def twist_left(c: Array, flank: int, twist: float, span: float) -> float:
    """The twist of the spring after a span: it relaxes between the flanks."""
    if flank != FREE:
        return 0.0
    return relaxed_twist(coupling_constants(c), twist, span)  # type: ignore[no-any-return]
