"""What drives an axis in an instant: the force of its drive, and what it depends on.

An axis of parts: a controller asks for a demand, the motor makes a force of it, the gear passes it
on to the load, on which gravity, a spring and forces from outside act, too:

    demand = clip(k_p (goal − q) + k_d (goal_velocity − v) + feed_forward, ±limit)
    F_m    = clip(gain (demand + added) − emf v, ±force_limit), less the motor's own friction
    F      = F_m times forward where it drives the load, times backward where the load drives it
    M a    = F − g_sin sin(q + q_offset) − g_cos cos(q + q_offset) − g_0 − spring (q − q_spring)
             − per_normal N + external − F_f

Arrays are handed over by seven words each, which takes longer than most of what is computed here,
so what is called in every step is written out in its caller.
"""

from __future__ import annotations

import numpy as np

from ...compile_cache import compiled
from ...friction.law import DRIVE, EXTERNAL, LOADS, NORMAL, POSITION, TEMPERATURE
from ...space import Array
from .drives import (
    AXIS,
    CLOCKED,
    FOLLOWS,
    LATE,
    AxisConstants,
    AxisInputs,
    SlideConstants,
    SlideInputs,
)

#: What stands behind the loads of a law: a demand that is held, gravity at the position, and how
#: fast that grows with it; and how long the row then is.
DEMAND = len(LOADS)
GRAVITY, GRADIENT = DEMAND + 1, DEMAND + 2
LOAD_ROOM = DEMAND + 3
#: What a sampled controller remembers: the demands of the last sample and of the one before, the
#: positions at these, and what it has integrated.
LAST, BEFORE, LAST_POSITION, POSITION_BEFORE, INTEGRAL = range(5)
LOOP_MEMORY = 5
#: A flag above this is set.
_SET = 0.5


@compiled(forceinline=True)
def axis_constants(c: Array) -> AxisConstants:
    """A row of constants by their names."""
    return AxisConstants(
        c[0], c[1], c[2], c[3], c[4], c[5], c[6], c[7], c[8], c[9], c[10], c[11], c[12], c[13],
        c[14], c[15], c[16], c[17], c[18], c[19], c[20], c[21], c[22],
    )  # fmt: skip


@compiled(forceinline=True)
def axis_inputs(u: Array) -> AxisInputs:
    """A row of inputs by their names."""
    return AxisInputs(u[0], u[1], u[2], u[3], u[4], u[5], u[6], u[7], u[8], u[9])


@compiled(forceinline=True)
def slide_constants(c: Array) -> SlideConstants:
    """A row of constants by their names."""
    return SlideConstants(c[0], c[1], c[2], c[3], c[4], c[5], c[6], c[7], c[8], c[9], c[10])


@compiled(forceinline=True)
def _gravity(axis: AxisConstants, q: float) -> tuple[float, float]:
    """The force of gravity against an axis at a position, and how fast it grows with that."""
    if axis.g_sin == 0.0 and axis.g_cos == 0.0:
        return 0.0, 0.0
    s, o = np.sin(q + axis.q_offset), np.cos(q + axis.q_offset)
    return axis.g_sin * s + axis.g_cos * o, axis.g_sin * o - axis.g_cos * s


@compiled(forceinline=True)
def _motor(
    axis: AxisConstants, wish: AxisInputs, demand: float, v: float, stiff: float, damp: float
) -> tuple[float, float, float]:
    """Force of the motor at the load, its stiffness and its damping.

    Args:
        axis: The axis.
        wish: Its inputs.
        demand: What its controller asks for.
        v: Its velocity; at rest the sign of the zero says which way it is about to go.
        stiff: How fast the demand falls with the position.
        damp: And with the velocity.
    """
    if not wish.enabled > _SET:
        return 0.0, 0.0, 0.0
    force = axis.gain * (demand + wish.added) - axis.emf * v
    stiff, damp = axis.gain * stiff, axis.gain * damp + axis.emf
    if abs(force) >= axis.force_limit:
        force, stiff, damp = np.copysign(axis.force_limit, force), 0.0, 0.0
    if axis.motor_friction > 0.0:
        if abs(force) <= axis.motor_friction:
            return 0.0, 0.0, 0.0
        force -= np.copysign(axis.motor_friction, force)
    share = axis.forward if force * np.copysign(1.0, v) >= 0.0 else axis.backward
    return share * force, share * stiff, share * damp


@compiled(forceinline=True)
def driven(
    kind: int, c: Array, u: Array, q: float, v: float, load: Array
) -> tuple[float, float, float, float]:
    """Mass, force of drive and surroundings without damping, the drive's damping and stiffness.

    Writes what a law may depend on into `load`: drive and external force, normal load, position
    and temperature. A demand that is held stands there, behind these. The stiffness is how fast
    the force falls with the position, N/m.

    Gravity, too: it is asked for several times in a row at one position, and computed once. Where
    constants are others than before, the position in `load` is to be nan.
    """
    elsewhere = q != load[POSITION]
    load[NORMAL], load[POSITION], load[TEMPERATURE] = u[0], q, u[1]
    if kind == AXIS:
        axis, wish = axis_constants(c), axis_inputs(u)
        demand, stiff, damp = load[DEMAND], 0.0, 0.0
        if axis.hold == FOLLOWS:
            demand = wish.feed_forward + axis.k_p * (wish.goal - q)
            demand += axis.k_d * (wish.goal_velocity - v)
            if abs(demand) < axis.limit:
                stiff, damp = axis.k_p, axis.k_d
            else:
                demand = np.copysign(axis.limit, demand)
        force, k, d = _motor(axis, wish, demand, v, stiff, damp)
        if elsewhere:
            load[GRAVITY], load[GRADIENT] = _gravity(axis, q)
        slope = load[GRADIENT]
        load[DRIVE] = force
        load[EXTERNAL] = wish.external - load[GRAVITY] - axis.g_0 - axis.per_normal * wish.normal
        load[EXTERNAL] -= axis.spring * (q - axis.q_spring)
        return axis.M, force + d * v + load[EXTERNAL], d, k + slope + axis.spring
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
    return kind == AXIS and c[4] > FOLLOWS


@compiled(forceinline=True)
def _read(axis: AxisConstants, q: float) -> float:
    """The position that a sampled controller reads."""
    if axis.resolution > 0.0:
        return axis.resolution * np.round(q / axis.resolution)  # type: ignore[no-any-return]
    return q


@compiled(forceinline=True)
def _computed(axis: AxisConstants, wish: AxisInputs, q: float, v: float, last: Array) -> float:
    """The demand that a sampled controller computes, which is what it asks for from now on."""
    q = _read(axis, q)
    if axis.difference > _SET:
        v = (q - last[POSITION_BEFORE]) / (2.0 * axis.T)
    demand = axis.k_p * (wish.goal - q) + axis.k_d * (wish.goal_velocity - v)
    if axis.k_i > 0.0:  # what it integrates alone never asks for more than the limit
        total = last[INTEGRAL] + axis.k_i * axis.T * demand
        last[INTEGRAL] = min(max(total, -axis.limit), axis.limit)
    demand += wish.feed_forward + last[INTEGRAL]
    last[LAST_POSITION], last[POSITION_BEFORE] = q, last[LAST_POSITION]
    return min(max(demand, -axis.limit), axis.limit)  # type: ignore[no-any-return]


@compiled(forceinline=True)
def loop_reset(c: Array, u: Array, q: float, v: float, last: Array) -> None:
    """What a sampled controller remembers at its start: an axis at a constant velocity."""
    axis, wish = axis_constants(c), axis_inputs(u)
    last[:] = 0.0
    last[LAST_POSITION] = _read(axis, q - axis.T * v)
    last[POSITION_BEFORE] = _read(axis, q - 2.0 * axis.T * v)
    demand = axis.start
    if np.isnan(demand):
        demand = _computed(axis, wish, q, v, last)
    last[LAST] = last[BEFORE] = demand
    last[INTEGRAL] = 0.0
    last[LAST_POSITION] = _read(axis, q - axis.T * v)
    last[POSITION_BEFORE] = _read(axis, q - 2.0 * axis.T * v)


@compiled(forceinline=True)
def demanded(c: Array, u: Array, q: float, v: float, last: Array) -> float:
    """The demand in force from a sample on; the controller computes the next one there."""
    axis, wish = axis_constants(c), axis_inputs(u)
    clocked = axis.hold == CLOCKED
    if not clocked or wish.sampled > _SET:
        demand = _computed(axis, wish, q, v, last)
        last[LAST], last[BEFORE] = demand, last[LAST]
    late = wish.late > _SET if clocked else axis.hold == LATE
    return last[BEFORE] if late else last[LAST]  # type: ignore[no-any-return]


@compiled(forceinline=True)
def mixed(inputs: Array, held: Array, k: int, share: float, u: Array) -> None:
    """The inputs at a share of the interval after sample k: between its ends, or held."""
    for i in range(len(inputs)):
        u[i] = inputs[i, k]
        if share > 0.0 and held[i] == 0:
            u[i] += share * (inputs[i, k + 1] - u[i])
