"""What drives an axis in an instant: the force of its drive, and what it depends on.

Arrays are handed over by seven words each, which takes longer than most of what is computed here,
so what is called in every step is written out in its caller.
"""

from __future__ import annotations

import numpy as np

from ...compile_cache import compiled
from ...friction.law import DRIVE, EXTERNAL, NORMAL, POSITION, TEMPERATURE
from ...space import Array
from .drives import (
    CASCADE,
    FORCE,
    JOINT,
    SERVO,
    CascadeConstants,
    CascadeInputs,
    ForceConstants,
    ForceInputs,
    JointConstants,
    JointInputs,
    ServoConstants,
    ServoInputs,
    SlideConstants,
    SlideInputs,
)


@compiled(forceinline=True)
def servo_constants(c: Array) -> ServoConstants:
    """A row of constants by their names."""
    return ServoConstants(c[0], c[1], c[2], c[3], c[4], c[5], c[6])


@compiled(forceinline=True)
def servo_inputs(u: Array) -> ServoInputs:
    """A row of inputs by their names."""
    return ServoInputs(u[0], u[1], u[2], u[3], u[4])


@compiled(forceinline=True)
def joint_constants(c: Array) -> JointConstants:
    """A row of constants by their names."""
    return JointConstants(c[0], c[1], c[2], c[3], c[4], c[5], c[6], c[7])


@compiled(forceinline=True)
def joint_inputs(u: Array) -> JointInputs:
    """A row of inputs by their names."""
    return JointInputs(u[0], u[1], u[2], u[3], u[4])


@compiled(forceinline=True)
def slide_constants(c: Array) -> SlideConstants:
    """A row of constants by their names."""
    return SlideConstants(c[0], c[1], c[2], c[3], c[4], c[5], c[6], c[7], c[8], c[9], c[10])


@compiled(forceinline=True)
def cascade_constants(c: Array) -> CascadeConstants:
    """A row of constants by their names."""
    return CascadeConstants(c[0], c[1], c[2], c[3], c[4], c[5], c[6], c[7])


@compiled(forceinline=True)
def driven(
    kind: int, c: Array, u: Array, q: float, v: float, load: Array
) -> tuple[float, float, float, float]:
    """Mass, force of drive and surroundings without damping, the drive's damping and stiffness.

    Writes what a law may depend on into `load`: drive and external force, normal load, position
    and temperature. A drive that holds its force finds it there. The stiffness is how fast the
    force falls with the position, N/m.
    """
    load[NORMAL], load[POSITION], load[TEMPERATURE] = u[0], q, u[1]
    if kind == SERVO:
        servo, control = servo_constants(c), servo_inputs(u)
        asked = servo.stiffness * (control.goal - q) + control.volts
        volts = min(max(asked, -servo.volts_max), servo.volts_max)
        per_volt = servo.per_volt if control.enabled > 0.5 else 0.0  # noqa: PLR2004 - a flag
        damping = servo.damping if control.enabled > 0.5 else 0.0  # noqa: PLR2004 - a flag
        k = servo.weight * np.cos(q + servo.q_offset)
        if volts == asked:
            k += per_volt * servo.stiffness
        load[EXTERNAL] = -servo.weight * np.sin(q + servo.q_offset)
        load[DRIVE] = per_volt * volts - damping * v
        return servo.J, per_volt * volts + load[EXTERNAL], damping, k
    if kind == JOINT:
        joint, wish = joint_constants(c), joint_inputs(u)
        s, o = np.sin(q), np.cos(q)
        k = joint.g_sin * o - joint.g_cos * s
        load[EXTERNAL] = -(joint.g_sin * s + joint.g_cos * o + joint.g_0)
        if joint.hold > 0.0:  # the drive's torque stands there already
            return joint.J, load[DRIVE] + load[EXTERNAL], 0.0, k
        torque = wish.torque + joint.k_p * (wish.goal - q) + joint.k_d * wish.velocity
        load[DRIVE] = min(max(torque - joint.k_d * v, -joint.limit), joint.limit)
        if abs(torque - joint.k_d * v) >= joint.limit:
            return joint.J, load[DRIVE] + load[EXTERNAL], 0.0, k
        return joint.J, torque + load[EXTERNAL], joint.k_d, k + joint.k_p
    if kind in (FORCE, CASCADE):
        mass = ForceConstants(c[0], c[1])  # with which a cascade's constants begin, too
        if kind == FORCE:  # the force of a cascade stands there already
            load[DRIVE] = ForceInputs(u[0], u[1], u[2]).force
        load[EXTERNAL] = -mass.offset
        return mass.M, load[DRIVE] - mass.offset, 0.0, 0.0
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
def commanded(c: Array, u: Array, q: float, v: float) -> float:
    """The torque that the controller of a joint computes at a sample."""
    joint, wish = joint_constants(c), joint_inputs(u)
    torque = wish.torque + joint.k_p * (wish.goal - q) + joint.k_d * (wish.velocity - v)
    return min(max(torque, -joint.limit), joint.limit)  # type: ignore[no-any-return]


@compiled(forceinline=True)
def cascade_reset(c: Array, q: float, v: float, last: Array) -> None:
    """What a cascade remembers at its start: an axis that came at a constant velocity."""
    loop = cascade_constants(c)
    last[0] = last[1] = loop.volts_start
    last[2], last[3] = q - loop.T * v, q - 2 * loop.T * v


@compiled(forceinline=True)
def cascade_force(c: Array, u: Array, q: float, last: Array) -> float:
    """The force of a cascade's drive from this instant on.

    At a sample k the controller computes

        u_k = clip(k_v (k_p (q_ref,k − q_k) − (q_k − q_k−2) / 2T), ±volts_max),

    whose velocity is a backward difference of the mean of two positions. `last` keeps the voltages
    of the last sample and of the one before, and the positions at these, (4,).
    """
    loop = cascade_constants(c)
    wish = CascadeInputs(u[0], u[1], u[2], u[3], u[4], u[5])
    if wish.sampled > 0.5:  # noqa: PLR2004 - a flag
        volts = loop.k_v * (loop.k_p * (wish.goal - q) - (q - last[3]) / (2 * loop.T))
        last[0], last[1] = min(max(volts, -loop.volts_max), loop.volts_max), last[0]
        last[2], last[3] = q, last[2]
    volts = last[1] if wish.late > 0.5 else last[0]  # noqa: PLR2004 - a flag
    return loop.per_volt * (volts + wish.volts)  # type: ignore[no-any-return]


@compiled(forceinline=True)
def mixed(inputs: Array, held: Array, k: int, share: float, u: Array) -> None:
    """The inputs at a share of the interval after sample k: between its ends, or held."""
    for i in range(len(u)):
        u[i] = inputs[i, k]
        if share > 0.0 and held[i] == 0:
            u[i] += share * (inputs[i, k + 1] - u[i])
