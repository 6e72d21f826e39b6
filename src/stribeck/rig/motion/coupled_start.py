"""The start of an axis of two masses: where its coupling is, and what both laws and a loop have."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...compile_cache import compiled
from ...friction.law import DRIVE, EXTERNAL, POSITION, terms_factor
from ...space import Array
from .axis_row import DEMAND
from .coupled_rates import (
    BRISTLES,
    FLANK,
    HELD_BRISTLES,
    LOAD,
    LOAD_RUBS,
    MOTOR,
    MOTOR_RUBS,
    MOTOR_STATES,
    PLAIN,
    Q_M,
    SMOOTH,
    STATE,
    V_M,
    Q,
    V,
    coupled_rates,
    read_position,
)
from .coupling import MOTOR_ROW, coupled_at, coupling_constants
from .drive_force import loop_reset
from .drives import FOLLOWS, HOLD
from .implicit import begun


@compiled(forceinline=True)
def held_rubbing(rubbing: int, lossy: bool) -> int:
    """What rubs on a load that a lossy coupling may hold, too."""
    if not lossy:
        return rubbing
    return PLAIN if rubbing == SMOOTH else HELD_BRISTLES if rubbing == BRISTLES else rubbing


@compiled(inline="always")
def _begun(
    slip_m: Any, rub_m: Any, p_m: Array, term_m: Array, slip: Any, rub: Any, p: Array,
    term: Array, c: Array, u: Array, y: Array, mode: Array, load_m: Array, load: Array,
    room: Array, rates: Array, g: Array,
) -> None:  # fmt: skip
    """The loads and the states of both laws where a motion starts; see `implicit.begun`."""
    own, relaxed = STATE + mode[MOTOR_STATES], room[0]
    relaxed[:] = 0.0
    coupled_rates(
        slip_m, rub_m, p_m, term_m, slip, rub, p, term, c, u, y, 0.0, mode, load_m, load,
        relaxed[STATE:own], relaxed[own:], 0.0, room[1, STATE:own], room[1, own:], rates[0], g,
    )  # fmt: skip
    if own > STATE:
        F = load_m[DRIVE] + load_m[EXTERNAL]
        factor = terms_factor(term_m, p_m, load_m)
        begun(rub_m, factor, F, y[V_M], load_m, p_m, relaxed[STATE:own], y[STATE:own])
    if len(y) > own:
        F = load[DRIVE] + load[EXTERNAL]
        factor = terms_factor(term, p, load)
        begun(rub, factor, F, y[V], load, p, relaxed[own:], y[own:])


@compiled(forceinline=True)
def _side_begun(rubbing: int, v: float) -> int:
    """The mode of a side at a velocity."""
    if rubbing in (SMOOTH, BRISTLES) or v > 0.0:
        return 1
    return -1 if v < 0.0 else 0


@compiled(inline="always")
def coupled_start(
    slip_m: Any, rub_m: Any, p_m: Array, term_m: Array, slip: Any, rub: Any, p: Array,
    term: Array, c: Array, u: Array, ahead: float, by_motor: float, y: Array, mode: Array,
    load_m: Array, load: Array, last: Array, rates: Array, room: Array, g: Array, memory: Array,
) -> None:  # fmt: skip
    """The state `y`, the modes and what is remembered, where a motion starts.

    Args:
        slip_m: As all further ones to `u` for `coupled_rates`.
        rub_m: See there.
        p_m: See there.
        term_m: See there.
        slip: See there.
        rub: See there.
        p: See there.
        term: See there.
        c: See there.
        u: See there.
        ahead: By how much the motor is ahead of the load; nan where nobody knows. It is then at the
            flank that drives a load that moves, and at a rest where the coupling has it.
        by_motor: 1 where the position in `y` is the motor's, 0 where it is the load's.
        y: Position and velocity of the load; of all others there is nothing yet.
        mode: What rubs on each side, and how many states that has; the modes are set.
        load_m: Room for what the motor's law depends on, and the demand that is held.
        load: Room for what the load's law depends on.
        last: What a sampled controller remembers.
        rates: Room for rates.
        room: As of `coupled_passage`.
        g: Room for distances from events, (3,).
        memory: Of the stepper.
    """
    coupling, axis = coupling_constants(c), c[MOTOR_ROW:]
    half = 0.5 * coupling.play
    if np.isnan(ahead):
        ahead = np.copysign(half, y[V]) if y[V] != 0.0 else half * coupling.start
    ahead = min(max(ahead, -half), half)
    y[Q] -= ahead * by_motor
    y[Q_M], y[V_M] = y[Q] + ahead, y[V]
    mode[MOTOR] = _side_begun(mode[MOTOR_RUBS], y[V])
    mode[LOAD] = _side_begun(mode[LOAD_RUBS], y[V])
    mode[FLANK] = coupled_at(coupling, ahead)
    load_m[POSITION] = load[POSITION] = np.nan  # of another axis
    memory[:] = 0.0
    if axis[HOLD] > FOLLOWS:
        loop_reset(axis, u, read_position(coupling, y[Q_M], y[Q]), y[V_M], last)
        load_m[DEMAND] = last[0]
    _begun(
        slip_m, rub_m, p_m, term_m, slip, rub, p, term, c, u, y, mode, load_m, load, room, rates, g
    )
