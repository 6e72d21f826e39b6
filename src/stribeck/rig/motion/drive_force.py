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
    FOLLOWS,
    INPUTS,
    LATE,
    AxisConstants,
    AxisInputs,
    SlideConstants,
    SlideInputs,
)
from .part_call import DAMPING, STIFFNESS, beginning, called, further

#: What a sampled controller remembers: the demands of the last sample and of the one before, the
#: positions at these, and what it has integrated.
#: Behind it is room for the slopes of a demand.
LAST, BEFORE, LAST_POSITION, POSITION_BEFORE, INTEGRAL, SLOPES = range(6)
LOOP_MEMORY = SLOPES + 2


@compiled(forceinline=True)
def axis_constants(c: Array) -> AxisConstants:
    """What the row of an axis of parts begins with, by name."""
    return AxisConstants(c[0], c[1], c[2], c[3], c[4], c[5], c[6], c[7], c[8], c[9])


@compiled(forceinline=True)
def axis_inputs(u: Array) -> AxisInputs:
    """A row of inputs by their names."""
    return AxisInputs(u[0], u[1], u[2], u[3], u[4], u[5], u[6], u[7], u[8], u[9])


@compiled(forceinline=True)
def slide_constants(c: Array) -> SlideConstants:
    """A row of constants by their names."""
    return SlideConstants(c[0], c[1], c[2], c[3], c[4], c[5], c[6], c[7], c[8], c[9], c[10])


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
        total = called(beginning(c), WHOLE, 0.0, q, v, beginning(u), beginning(load))
        return c[0], total, load[DAMP], load[STIFF]
    load[NORMAL], load[POSITION], load[TEMPERATURE] = u[0], q, u[1]
    bed, slide = slide_constants(c), SlideInputs(u[0], u[1], u[2], u[3])
    e = slide.command - q
    k, k_hat = bed.k_spring_minus, bed.k_hat_minus
    if e > 0.0:
        k, k_hat = bed.k_spring_plus, bed.k_hat_plus
    motor = k_hat * e + slide.added
    load[DRIVE] = k * e + max(motor - bed.F_fm, 0.0) + min(motor + bed.F_fm, 0.0)
    load[EXTERNAL] = 0.0
    return bed.m, load[DRIVE], 0.0, k + k_hat if abs(motor) > bed.F_fm else k


@compiled(forceinline=True)
def held_demand(kind: int, c: Array) -> bool:
    """Whether the demand of a drive is held from sample to sample."""
    return kind == AXIS and axis_constants(c).hold > FOLLOWS


@compiled(forceinline=True)
def _read(axis: AxisConstants, q: float) -> float:
    """The position that a sampled controller reads."""
    if axis.resolution > 0.0:
        return axis.resolution * np.round(q / axis.resolution)  # type: ignore[no-any-return]
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
    axis, wish, demand = axis_constants(c), axis_inputs(u), 0.0
    q, v = _seen(c, u, q, v, last)
    q = _read(axis, q)
    if axis.difference > SET:
        v = (q - last[POSITION_BEFORE]) / (2.0 * axis.T)
    if c[DEMANDED] > 0.0:
        slope = further(beginning(last), SLOPES)
        demand = called(beginning(c), DEMANDED, 0.0, q, v, beginning(u), slope)
    if axis.k_i > 0.0:  # what it integrates alone never asks for more than the limit
        total = last[INTEGRAL] + axis.k_i * axis.T * demand
        last[INTEGRAL] = min(max(total, -axis.limit), axis.limit)
    demand += wish.feed_forward + last[INTEGRAL]
    last[LAST_POSITION], last[POSITION_BEFORE] = q, last[LAST_POSITION]
    return min(max(demand, -axis.limit), axis.limit)  # type: ignore[no-any-return]


@compiled(forceinline=True)
def loop_reset(c: Array, u: Array, q: float, v: float, last: Array) -> None:
    """What a sampled controller remembers at its start: an axis at a constant velocity."""
    axis = axis_constants(c)
    last[:] = 0.0
    q_m, v_m = _seen(c, u, q, v, last)
    last[LAST_POSITION] = _read(axis, q_m - axis.T * v_m)
    last[POSITION_BEFORE] = _read(axis, q_m - 2.0 * axis.T * v_m)
    demand = axis.start
    if np.isnan(demand):
        demand = _computed(c, u, q, v, last)
    last[LAST] = last[BEFORE] = demand
    last[INTEGRAL] = 0.0
    last[LAST_POSITION] = _read(axis, q_m - axis.T * v_m)
    last[POSITION_BEFORE] = _read(axis, q_m - 2.0 * axis.T * v_m)


@compiled(forceinline=True)
def demanded(c: Array, u: Array, q: float, v: float, last: Array) -> float:
    """The demand in force from a sample on; the controller computes the next one there."""
    axis, wish = axis_constants(c), axis_inputs(u)
    clocked = axis.hold == CLOCKED
    if not clocked or wish.sampled > SET:
        demand = _computed(c, u, q, v, last)
        last[LAST], last[BEFORE] = demand, last[LAST]
    late = wish.late > SET if clocked else axis.hold == LATE
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
