"""The play and the spring between a motor and its load: one force of two positions.

A spring with a damper, in series with play (Nordin, Galic and Gutman 1997, doi
10.1002/(SICI)1099-1115(199702)11:1<49::AID-ACS394>3.0.CO;2-X). Of the way δ = q_m − q by which the
motor is ahead, b lies in the play, |b| <= α, half of it, and s = δ − b in the spring:

    T = k s + d s',    s' = δ' at a flank, b = ±α, where T presses against it
                       s' = −(k/d) s between the flanks, where T = 0

A flank is left at the instant at which T has fallen to zero, and the spring relaxes from there; the
other one, or the same again, is met as soon as b has come to it. The force does no work but what
the damper takes, and what teeth or threads take by their efficiency: of T, a load that it drives
has η T, one that it brakes T / η_back. Without play spring and damper act both ways.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ...compile_cache import compiled
from ...space import Array

#: Where the coupling is: between the flanks, at the one ahead (+1) or behind (−1), or without play.
FREE, JOINED = 0, 2


class CouplingConstants(NamedTuple):
    """What joins motor and load; SI at the load.

    Args:
        stiffness: k, N/m or N m/rad.
        damping: d, N s/m or N m s/rad.
        play: The whole way of the load between the flanks, 2 α, m or rad.
        start: Where in the play a motion starts from rest, −1 to 1 of α.
        by_load: 1 where the controller reads the load's position, 0 where the motor's.
        zero: By how much the controller reads the motor's position higher.
        forward: Share of T that comes to a load which it drives.
        backward: By how much of T a load is braked.
    """

    stiffness: Any
    damping: Any = 0.0
    play: Any = 0.0
    start: Any = 0.0
    by_load: Any = 0.0
    zero: Any = 0.0
    forward: Any = 1.0
    backward: Any = 1.0


#: Places of the play and of the zero; and of two rows behind the coupling's own constants: where
#: that of the load begins, and where that of the motor does.
PLAY, ZERO = CouplingConstants._fields.index("play"), CouplingConstants._fields.index("zero")
LOAD_ROW = len(CouplingConstants._fields)
MOTOR_ROW = LOAD_ROW + 1


def coupled_row(
    coupling: CouplingConstants, motor: Sequence[Any], load: Sequence[Any]
) -> tuple[Any, ...]:
    """The row of an axis of two masses: the coupling's constants, the rows of motor and load."""
    return (*coupling, MOTOR_ROW + len(motor), *motor, *load)


@compiled(forceinline=True)
def coupling_constants(c: Array) -> CouplingConstants:
    """A row of constants by their names."""
    return CouplingConstants(c[0], c[1], c[2], c[3], c[4], c[5], c[6], c[7])


@compiled(forceinline=True)
def coupled_at(coupling: CouplingConstants, ahead: float) -> int:
    """Where a coupling is whose spring is relaxed between the flanks."""
    half = 0.5 * coupling.play
    if half <= 0.0:
        return JOINED
    if abs(ahead) >= half:
        return 1 if ahead > 0.0 else -1
    return FREE


@compiled(forceinline=True)
def coupling_force(coupling: CouplingConstants, flank: int, ahead: float, rate: float) -> float:
    """T, from the motor on the load.

    Args:
        coupling: Its constants.
        flank: Where it is.
        ahead: δ.
        rate: δ'.
    """
    if flank == FREE:
        return 0.0
    twist = ahead if flank == JOINED else ahead - 0.5 * flank * coupling.play
    return coupling.stiffness * twist + coupling.damping * rate  # type: ignore[no-any-return]


@compiled(forceinline=True)
def relaxed_twist(coupling: CouplingConstants, twist: float, span: float) -> float:
    """What is left of the twist of a spring between the flanks after a span, s."""
    if twist == 0.0 or coupling.damping <= 0.0:
        return 0.0
    return twist * np.exp(-span * coupling.stiffness / coupling.damping)  # type: ignore[no-any-return]
