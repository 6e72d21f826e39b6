"""The row of constants of an axis of parts, and the one function that its parts are compiled into.

    demand = clip(Σ controllers + feed_forward, ±limit)
    F_m    = clip(motor(demand + added), ±force_limit), less the motor's own friction
    F      = transmission(F_m)
    M a    = F + Σ loads + external − F_f

Each of them is a function of its own (`part_call`), from the file that declares the part. The motor
may be at another position than the load, q_m = way(q): it and the controller see q_m and q_m' v,
and by the power that passes the load has q_m' F.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, Literal, NamedTuple, get_args

import numpy as np

from ...friction.law import DRIVE, EXTERNAL, LOADS, NORMAL, POSITION, TEMPERATURE
from ...space import Array
from .drives import (
    ADDED,
    ENABLED,
    EXTERNAL_FORCE,
    FEED_FORWARD,
    FOLLOWS,
    FORCE_LIMIT,
    HOLD,
    LIMIT,
    MOTOR_FRICTION,
    NORMAL_LOAD,
    AxisConstants,
)
from .drives import TEMPERATURE as TEMPERATURE_NOW
from .part_call import DAMPING, STIFFNESS, PartFunction, Row, address_of, further, inlined

#: Where a part acts, in the order in which power flows: on the position that the motor has, on the
#: demand of the controller, on the force of the motor, on what of it comes to the load; and on the
#: load, by its position alone or by anything.
Slot = Literal["way", "demand", "motor", "transmission", "position", "load"]
SLOTS: tuple[Slot, ...] = get_args(Slot)
#: Where a row has its functions, each before the place where its constants begin: that of the whole
#: drive; those of some slots by themselves, 0 for none; and where the parts' constants begin.
WHOLE = len(AxisConstants._fields)
WAY, DEMANDED, MOTOR, CONSTANTS = range(WHOLE + 2, WHOLE + 10, 2)
_APART: Sequence[Slot] = ("way", "demand", "motor")
#: What stands behind the loads of a law: a demand that is held, what acts on the load at the
#: position, and how fast that falls with it; the slopes of a force on its way through the parts;
#: and how long the row then is.
DEMAND = len(LOADS)
GRAVITY, GRADIENT, STIFF, DAMP = range(DEMAND + 1, DEMAND + 5)
LOAD_ROOM = DEMAND + 5
#: A flag above this is set.
SET = 0.5


class Stage(NamedTuple):
    """A part as it acts.

    Args:
        slot: Where.
        function: Its function, see `part_call`.
        constants: What that reads, in order.
    """

    slot: Slot
    function: PartFunction
    constants: Sequence[Any]


@dataclass(frozen=True)
class Chain:
    """Parts one after the other, as a row has them by their address.

    Args:
        parts: Where each acts, its function, and of how many constants.
        whole: Whether they are a whole drive, not the parts of one slot.
    """

    parts: tuple[tuple[Slot, PartFunction, int], ...]
    whole: bool = False

    @property
    def function(self) -> PartFunction:
        """The one that they are together."""
        return _whole_drive(self.parts) if self.whole else _chained(self.parts)

    def address(self) -> float:
        """Of its machine code."""
        return address_of(self.function)


def axis_row(constants: AxisConstants, stages: Sequence[Stage]) -> tuple[Any, ...]:
    """The row of an axis: its own constants, its functions, the constants of its parts."""
    ordered = [stage for slot in SLOTS for stage in stages if stage.slot == slot]
    parts = tuple((stage.slot, stage.function, len(stage.constants)) for stage in ordered)
    entries: list[Any] = [Chain(parts, whole=True), 0]
    for slot in _APART:
        chain = Chain(tuple(part for part in parts if part[0] == slot))
        begin = CONSTANTS + sum(n for at, _, n in parts if SLOTS.index(at) < SLOTS.index(slot))
        entries += [chain if chain.parts else 0.0, begin]
    return (*constants, *entries, *(x for stage in ordered for x in stage.constants))


def rows(constants: Sequence[Any], n: int) -> Array:
    """The row of n candidates, each constant a number or (n,), as a table, (n, constants)."""
    table = np.empty((n, len(constants)))
    for column, values in zip(table.T, constants, strict=True):
        column[:] = values.address() if isinstance(values, Chain) else values
    return table


def _unchanged(force: float, q: float, v: float, u: Row, c: Row, slope: Row) -> float:  # noqa: ARG001 - a slot without parts
    return force


@cache
def _chained(parts: tuple[tuple[Slot, PartFunction, int], ...]) -> PartFunction:
    """The function of parts one after the other, with their constants one after the other."""
    if len(parts) < 2:  # noqa: PLR2004 - a chain
        return parts[0][1] if parts else _unchanged
    first, after, n = inlined(parts[0][1]), inlined(_chained(parts[1:])), parts[0][2]

    def both(force: float, q: float, v: float, u: Row, c: Row, slope: Row) -> float:
        force = first(force, q, v, u, c, slope)
        return after(force, q, v, u, further(c, n), slope)

    return both


@cache
def _whole_drive(parts: tuple[tuple[Slot, PartFunction, int], ...]) -> PartFunction:
    """The function of a drive: the force on its load, friction and inertia apart.

    It takes the whole row, and in the place of slopes what a law depends on, with what stands
    behind that; it writes forces and slopes there.
    """
    chains = [tuple(part for part in parts if part[0] == slot) for slot in SLOTS]
    way, asked, motor, transmitted, held, loaded = (inlined(_chained(chain)) for chain in chains)
    counts = [sum(n for _, _, n in chain) for chain in chains]
    asked_at, motor_at, transmitted_at, held_at, loaded_at = (
        CONSTANTS + sum(counts[: k + 1]) for k in range(len(SLOTS) - 1)
    )
    turns = bool(chains[0])

    def drive(force: float, q: float, v: float, u: Row, c: Row, load: Row) -> float:
        slope, q_m, share = further(load, STIFF), q, 1.0
        if turns:
            q_m = way(q, q, v, u, further(c, CONSTANTS), slope)
            share = slope[STIFFNESS]
        v_m, demand = share * v, load[DEMAND]
        slope[STIFFNESS], slope[DAMPING] = 0.0, 0.0
        if c[HOLD] == FOLLOWS:
            demand = u[FEED_FORWARD] + asked(0.0, q_m, v_m, u, further(c, asked_at), slope)
            if not abs(demand) < c[LIMIT]:
                demand, slope[STIFFNESS], slope[DAMPING] = np.copysign(c[LIMIT], demand), 0.0, 0.0
        if u[ENABLED] > SET:
            force = motor(demand + u[ADDED], q_m, v_m, u, further(c, motor_at), slope)
            if abs(force) >= c[FORCE_LIMIT]:
                force = np.copysign(c[FORCE_LIMIT], force)
                slope[STIFFNESS], slope[DAMPING] = 0.0, 0.0
            if c[MOTOR_FRICTION] > 0.0:
                if abs(force) <= c[MOTOR_FRICTION]:
                    force, slope[STIFFNESS], slope[DAMPING] = 0.0, 0.0, 0.0
                else:
                    force -= np.copysign(c[MOTOR_FRICTION], force)
        else:
            force, slope[STIFFNESS], slope[DAMPING] = 0.0, 0.0, 0.0
        force = share * transmitted(force, q_m, v_m, u, further(c, transmitted_at), slope)
        k, d = share * share * slope[STIFFNESS], share * share * slope[DAMPING]
        if q != load[POSITION]:
            slope[STIFFNESS] = 0.0
            load[GRAVITY] = held(0.0, q, v, u, further(c, held_at), slope)
            load[GRADIENT] = slope[STIFFNESS]
        load[NORMAL], load[POSITION], load[TEMPERATURE] = u[NORMAL_LOAD], q, u[TEMPERATURE_NOW]
        slope[STIFFNESS], slope[DAMPING] = k + load[GRADIENT], d
        pull = u[EXTERNAL_FORCE] + load[GRAVITY]
        pull = loaded(pull, q, v, u, further(c, loaded_at), slope)
        load[DRIVE], load[EXTERNAL] = force, pull
        return force + slope[DAMPING] * v + pull  # type: ignore[no-any-return]

    return drive
