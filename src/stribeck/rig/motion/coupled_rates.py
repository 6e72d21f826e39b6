"""The rates of an axis of two masses in an instant, and how far it is from its next event.

    M_m v_m' = F_m(u, q, v_m) − T − F_f,m(v_m)        the motor, with what drives it
    M v' = η T + F_e(u, q) − F_f(v)                   the load, with what acts on it

Everything is at the load: the motor's position, inertia and friction times or over the ratio of
the gear. `drive_force` has F_m and F_e, `coupling` has T. Each side slides forward or backward, or
sticks; the coupling is at a flank of its play, or between them. As long as none of these changes
the rates are smooth. What would change them first stands in three numbers that are below zero until
then: for each side how fast it slides yet, or, where it sticks, the force on it beyond its
breakaway level; for the coupling the force that presses it against its flank, or the way to the
next one.

A law with states neither slides nor sticks, its bristles hold a side: there is no event. But where
the coupling loses power it holds the load, too: of T that has η T or T / η_back, by the way that it
goes, and rests as long as the force of neither way is enough. A load without friction is held
likewise, under a law that never rubs.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ...compile_cache import compiled
from ...friction.law import DRIVE, EXTERNAL, terms_factor
from ...space import Array
from .axis_row import LOAD_ROOM
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
from .drive_force import parts_driven
from .drives import EXTERNAL_FORCE
from .velocity import rubs

#: The state: position and velocity of the motor and of the load.
Q_M, V_M, Q, V = range(4)
STATE = 4
#: The modes of the two sides (−1, 0, +1), where the coupling is, what rubs on each side, and how
#: many states that has.
MOTOR, LOAD, FLANK, MOTOR_RUBS, LOAD_RUBS, MOTOR_STATES, LOAD_STATES = range(7)
MODES = 7
#: What rubs on a side: nothing; a law of its velocity alone; one that reads loads; one with states;
#: one with states on a load that a coupling which loses power may hold.
SMOOTH, PLAIN, GENERAL, BRISTLES, HELD_BRISTLES = range(5)
#: Where friction stands behind what `driven` writes into a load, and how long that is then.
FRICTION = LOAD_ROOM
SIDE_ROOM = LOAD_ROOM + 1
#: Numbers that are below zero until an event of the motor, of the load, of the coupling.
EVENTS = 3


@compiled(forceinline=True)
def read_position(coupling: CouplingConstants, q_m: float, q: float) -> float:
    """The position that a controller reads."""
    return q if coupling.by_load > 0.5 else q_m + coupling.zero  # noqa: PLR2004 - a flag


@compiled(forceinline=True)
def _resisted(
    slip: Any, rub: Any, p: Array, term: Array, load: Array, z: Array, span: float, out: Array,
    side: int, rubbing: int, v: float, force: float,
) -> tuple[float, float]:  # fmt: skip
    """The force on a side with its friction, and how far it is from its event.

    Args:
        slip: Its law, as all further ones to `out`.
        rub: The law as one that reads loads, or has states.
        p: The law's parameters.
        term: Places of the law's terms.
        load: What the law may depend on; its friction goes there.
        z: Its states.
        span: For how long it has moved at this velocity since it had these states, s.
        out: The states after that.
        side: Its mode.
        rubbing: What rubs on it.
        v: Its velocity.
        force: On it, friction apart.
    """
    load[FRICTION] = 0.0
    if rubbing == SMOOTH:
        return force, -1.0
    general = rubbing != PLAIN
    scale = terms_factor(term, p, load)
    if rubbing == BRISTLES or (rubbing == HELD_BRISTLES and side != 0):
        load[FRICTION] = rubs(slip, rub, general, scale, v, span, z, load, p, out)
        return force - load[FRICTION], -1.0 if rubbing == BRISTLES else -side * v
    if side == 0:
        way = 1.0 if force > 0.0 else -1.0
        level = rubs(slip, rub, general, scale, way * 0.0, 0.0, z, load, p, out)
        return 0.0, way * (force - level)
    slides = v if side * v > 0.0 else np.copysign(0.0, side)
    load[FRICTION] = rubs(slip, rub, general, scale, slides, 0.0, z, load, p, out)
    return force - load[FRICTION], -side * v


@compiled(forceinline=True)
def _held(
    slip: Any, rub: Any, p: Array, term: Array, load: Array, z: Array, span: float, out: Array,
    rubbing: int, force: float, up: float, down: float,
) -> float:  # fmt: skip
    """How far a load that a lossy coupling may hold at rest is from moving.

    Args:
        slip: As all further ones to `out` for `_resisted`; what drives the load by the way on which
            it would move first goes into `load`, too.
        rub: See there.
        p: See there.
        term: See there.
        load: See there.
        z: See there.
        span: See there.
        out: See there.
        rubbing: See there.
        force: On the load, friction and coupling apart.
        up: What the coupling adds if it moves forward.
        down: The same backward.
    """
    load[DRIVE], load[FRICTION] = up, 0.0
    scale = terms_factor(term, p, load)
    if rubbing == HELD_BRISTLES:
        load[FRICTION] = rubs(slip, rub, True, scale, 0.0, span, z, load, p, out)
        forward, backward = force + up - load[FRICTION], load[FRICTION] - force - down
    else:
        general = rubbing == GENERAL
        forward = force + up - rubs(slip, rub, general, scale, 0.0, 0.0, z, load, p, out)
        load[DRIVE] = down
        backward = rubs(slip, rub, general, scale, -0.0, 0.0, z, load, p, out) - force - down
    load[DRIVE] = up if forward >= backward else down
    return max(forward, backward)  # type: ignore[no-any-return]


@compiled(forceinline=True)
def coupled_rates(
    slip_m: Any, rub_m: Any, p_m: Array, term_m: Array, slip: Any, rub: Any, p: Array,
    term: Array, c: Array, u: Array, y: Array, twist: float, mode: Array,
    load_m: Array, load: Array, z_m: Array, z: Array, span: float, out_m: Array, out: Array,
    rate: Array, g: Array,
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
        y: Positions and velocities.
        twist: Of the spring, where the coupling is between its flanks.
        mode: The modes.
        load_m: What the motor's law depends on, its demand where that is held, its friction.
        load: What the load's law depends on, and its friction.
        z_m: The states of the motor's law.
        z: The states of the load's law.
        span: For how long both have moved at these velocities since they had these states, s.
        out_m: The states of the motor's law after that.
        out: The states of the load's law after that.
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
    mass, F, d, _ = parts_driven(c[MOTOR_ROW:], u, read, y[V_M], load_m)
    u[EXTERNAL_FORCE] = external
    load_m[EXTERNAL] -= T
    F, g[0] = _resisted(
        slip_m, rub_m, p_m, term_m, load_m, z_m, span, out_m, mode[MOTOR], mode[MOTOR_RUBS],
        y[V_M], F - d * y[V_M] - T,
    )  # fmt: skip
    rate[Q_M], rate[V_M] = y[V_M], F / mass
    mass, F, d, _ = parts_driven(c[int(c[LOAD_ROW]) :], u, y[Q], y[V], load)
    F -= d * y[V]
    lossy = mode[LOAD_RUBS] == HELD_BRISTLES or not coupling.forward == coupling.backward == 1.0
    if mode[LOAD] == 0 and lossy:
        up, down = T * coupling.forward, T * coupling.backward
        if T < 0.0:
            up, down = down, up
        g[1] = _held(slip, rub, p, term, load, z, span, out, mode[LOAD_RUBS], F, up, down)
        rate[Q], rate[V] = y[V], 0.0
        return T  # type: ignore[no-any-return]
    way = float(mode[LOAD])  # in which the load moves, or would
    if mode[LOAD_RUBS] in (SMOOTH, BRISTLES) or mode[LOAD] == 0:
        way = y[V] if y[V] != 0.0 else F + T
    load[DRIVE] = T * (coupling.forward if T * way >= 0.0 else coupling.backward)
    F, g[1] = _resisted(
        slip, rub, p, term, load, z, span, out, mode[LOAD], mode[LOAD_RUBS], y[V], F + load[DRIVE]
    )
    rate[Q], rate[V] = y[V], F / mass
    return T  # type: ignore[no-any-return]


@compiled(forceinline=True)
def twist_left(c: Array, flank: int, twist: float, span: float) -> float:
    """The twist of the spring after a span: it relaxes between the flanks."""
    if flank != FREE:
        return 0.0
    coupling = coupling_constants(c)
    return relaxed_twist(coupling, twist, span)  # type: ignore[no-any-return]
