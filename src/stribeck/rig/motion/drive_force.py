"""What drives an axis in an instant: the force of its drive, and what it depends on.

The drive of an axis of parts is a compiled function (`axis_row`), that of a slide stands here.

Arrays are handed over by seven words each, which takes longer than most of what is computed here,
so what is called in every step is written out in its caller.
"""

from __future__ import annotations

import numpy as np

from ...compile_cache import compiled
from ...friction.law import DRIVE, EXTERNAL, NORMAL, POSITION, TEMPERATURE
from ...space import Array
from .axis_row import DAMP, DEMANDED, MOTOR, SET, STIFF, WAY, WHOLE
from .drives import (
    AXIS,
    CLOCKED,
    DIFFERENCE,
    F_FM,
    FEED_FORWARD,
    FOLLOWS,
    HOLD,
    INPUTS,
    INTEGRATES,
    K_HAT_M,
    K_HAT_P,
    K_SPRING_M,
    K_SPRING_P,
    LATE,
    LATE_NOW,
    LIMIT,
    NORMAL_LOAD,
    RESOLUTION,
    SAMPLE_TIME,
    SAMPLED_NOW,
    SLIDE_ADDED,
    SLIDE_COMMAND,
    START,
)
from .drives import TEMPERATURE as TEMPERATURE_NOW
from .part_call import DAMPING, STIFFNESS, beginning, called, further

#: What a sampled controller remembers: the demands of the last sample and of the one before, the
#: positions at these, and what it has integrated.
#: Behind it is room for the slopes of a demand.
LAST, BEFORE, LAST_POSITION, POSITION_BEFORE, INTEGRAL, SLOPES = range(6)
LOOP_MEMORY = SLOPES + 2


@compiled(forceinline=True)
def parts_driven(
    c: Array, u: Array, q: float, v: float, load: Array
) -> tuple[float, float, float, float]:
    """What `driven` tells of an axis of parts."""
    total = called(beginning(c), WHOLE, 0.0, q, v, beginning(u), beginning(load))
    return c[0], total, load[DAMP], load[STIFF]


@compiled(forceinline=True)
def driven(
    kind: int, c: Array, u: Array, q: float, v: float, load: Array
) -> tuple[float, float, float, float]:
    """Mass, force of drive and surroundings without damping, the drive's damping and stiffness.

    Writes what a law may depend on into `load`: drive and external force, normal load, position
    and temperature. A demand that is held stands there, behind these. The stiffness is how fast
    the force falls with the position, N/m.

    So does what acts on the load by its position alone: it is asked for several times in a row at
    one position, and computed once. Where constants are others than before, the position in `load`
    is to be nan.
    """
    if kind == AXIS:
        return parts_driven(c, u, q, v, load)  # type: ignore[no-any-return]
    load[NORMAL], load[POSITION], load[TEMPERATURE] = u[NORMAL_LOAD], q, u[TEMPERATURE_NOW]
    e = u[SLIDE_COMMAND] - q
    k, k_hat = c[K_SPRING_M], c[K_HAT_M]
    if e > 0.0:
        k, k_hat = c[K_SPRING_P], c[K_HAT_P]
    motor = k_hat * e + u[SLIDE_ADDED]
    load[DRIVE] = k * e + max(motor - c[F_FM], 0.0) + min(motor + c[F_FM], 0.0)
    load[EXTERNAL] = 0.0
    return c[0], load[DRIVE], 0.0, k + k_hat if abs(motor) > c[F_FM] else k


@compiled(forceinline=True)
def held_demand(kind: int, c: Array) -> bool:
    """Whether the demand of a drive is held from sample to sample."""
    return kind == AXIS and c[HOLD] > FOLLOWS


@compiled(forceinline=True)
def _read(c: Array, q: float) -> float:
    """The position that a sampled controller reads."""
    if c[RESOLUTION] > 0.0:
        return c[RESOLUTION] * np.round(q / c[RESOLUTION])  # type: ignore[no-any-return]
    return q


@compiled(forceinline=True)
def _seen(c: Array, u: Array, q: float, v: float, last: Array) -> tuple[float, float]:
    """Position and velocity of the motor, which a sampled controller reads, of the load's."""
    if c[WAY] > 0.0:
        slope = further(beginning(last), SLOPES)
        q = called(beginning(c), WAY, q, q, v, beginning(u), slope)
        v *= last[SLOPES]
    return q, v


@compiled(forceinline=True)
def _computed(c: Array, u: Array, q: float, v: float, last: Array) -> float:
    """The demand that a sampled controller computes, which is what it asks for from now on."""
    demand = 0.0
    q, v = _seen(c, u, q, v, last)
    q = _read(c, q)
    if c[DIFFERENCE] > SET:
        v = (q - last[POSITION_BEFORE]) / (2.0 * c[SAMPLE_TIME])
    if c[DEMANDED] > 0.0:
        slope = further(beginning(last), SLOPES)
        demand = called(beginning(c), DEMANDED, 0.0, q, v, beginning(u), slope)
    if c[INTEGRATES] > 0.0:  # what it integrates alone never asks for more than the limit
        total = last[INTEGRAL] + c[INTEGRATES] * c[SAMPLE_TIME] * demand
        last[INTEGRAL] = min(max(total, -c[LIMIT]), c[LIMIT])
    demand += u[FEED_FORWARD] + last[INTEGRAL]
    last[LAST_POSITION], last[POSITION_BEFORE] = q, last[LAST_POSITION]
    return min(max(demand, -c[LIMIT]), c[LIMIT])  # type: ignore[no-any-return]


@compiled(forceinline=True)
def loop_reset(c: Array, u: Array, q: float, v: float, last: Array) -> None:
    """What a sampled controller remembers at its start: an axis at a constant velocity."""
    last[:] = 0.0
    q_m, v_m = _seen(c, u, q, v, last)
    before, second = _read(c, q_m - c[SAMPLE_TIME] * v_m), _read(c, q_m - 2 * c[SAMPLE_TIME] * v_m)
    last[LAST_POSITION], last[POSITION_BEFORE] = before, second
    demand = c[START]
    if np.isnan(demand):
        demand = _computed(c, u, q, v, last)
    last[LAST], last[BEFORE], last[INTEGRAL] = demand, demand, 0.0
    last[LAST_POSITION], last[POSITION_BEFORE] = before, second


@compiled(forceinline=True)
def demanded(c: Array, u: Array, q: float, v: float, last: Array) -> float:
    """The demand in force from a sample on; the controller computes the next one there."""
    clocked = c[HOLD] == CLOCKED
    if not clocked or u[SAMPLED_NOW] > SET:
        demand = _computed(c, u, q, v, last)
        last[LAST], last[BEFORE] = demand, last[LAST]
    late = u[LATE_NOW] > SET if clocked else c[HOLD] == LATE
    return last[BEFORE] if late else last[LAST]  # type: ignore[no-any-return]


@compiled()
def loop_gains(c: Array) -> tuple[float, float, float]:
    """Force of the motor per demand; stiffness and damping of the loop, limits and friction apart.

    Of an axis of parts at rest at its goal.
    """
    inputs, slopes, demand = np.zeros(INPUTS), np.zeros(2), 0.0
    row, u, slope = beginning(c), beginning(inputs), beginning(slopes)
    if c[DEMANDED] > 0.0:
        demand = called(row, DEMANDED, 0.0, 0.0, 0.0, u, slope)
    force = called(row, MOTOR, demand, 0.0, 0.0, u, slope)
    stiffness, damping = slopes[STIFFNESS], slopes[DAMPING]
    return called(row, MOTOR, demand + 1.0, 0.0, 0.0, u, slope) - force, stiffness, damping


@compiled(forceinline=True)
def mixed(inputs: Array, held: Array, k: int, share: float, u: Array) -> None:
    """The inputs at a share of the interval after sample k: between its ends, or held."""
    for i in range(len(inputs)):
        u[i] = inputs[i, k]
        if share > 0.0 and held[i] == 0:
            u[i] += share * (inputs[i, k + 1] - u[i])
