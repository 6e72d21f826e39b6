"""The drives that the implicit stepper knows: their constants and inputs, by name.

A candidate's constants are a row of WIDTH numbers, an instant's inputs a short row, so that one
compiled stepper serves every drive. Here the columns have their names: a rig fills them by name,
compiled code reads them by name.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ...space import Array

#: The kinds of drive.
SLIDE, SERVO, JOINT, FORCE, CASCADE = range(5)
#: Constants that a candidate may have.
WIDTH = 11


class ServoConstants(NamedTuple):
    """A pendulum on a position-controlled servo motor.

    Args:
        J: Moment of inertia, kg m^2.
        per_volt: Torque per volt k_t / R, N m/V.
        damping: Of the back-EMF, k_t^2 / R, N m s/rad.
        weight: Greatest torque of the weight m g l, N m.
        q_offset: Angle at which the weight hangs straight down, rad.
        stiffness: Voltage per angle of control error, V/rad.
        volts_max: Supply voltage, V.
    """

    J: Any
    per_volt: Any
    damping: Any
    weight: Any
    q_offset: Any
    stiffness: Any
    volts_max: Any


class ServoInputs(NamedTuple):
    """Inputs of a servo: normal load, temperature, angle asked for, 1 while on, added volts."""

    normal: Any
    temperature: Any
    goal: Any
    enabled: Any
    volts: Any


class JointConstants(NamedTuple):
    """A joint under PD control with feed-forward, and gravity.

    Args:
        J: Moment of inertia, kg m^2.
        k_p: Gain of the position, N m/rad.
        k_d: Gain of the velocity, N m s/rad.
        g_sin: Torque of gravity that goes with sin q, N m.
        g_cos: Torque of gravity that goes with cos q, N m.
        g_0: Constant torque, N m.
        limit: Largest torque of the drive, N m.
        hold: 0 if the torque follows the axis at all times, 1 if it is held from sample to sample,
            2 if it acts a sample late.
    """

    J: Any
    k_p: Any
    k_d: Any
    g_sin: Any
    g_cos: Any
    g_0: Any
    limit: Any
    hold: Any


class JointInputs(NamedTuple):
    """Inputs of a joint: normal load, temperature, angle and velocity asked for, feed-forward."""

    normal: Any
    temperature: Any
    goal: Any
    velocity: Any
    torque: Any


class ForceConstants(NamedTuple):
    """A mass under a force: mass, kg or kg m^2, and a constant force against it, N or N m."""

    M: Any
    offset: Any


class ForceInputs(NamedTuple):
    """Inputs of a mass under a force: normal load, temperature, the force, N or N m."""

    normal: Any
    temperature: Any
    force: Any


class CascadeConstants(NamedTuple):
    """A mass under a sampled cascade: a loop of the position around one of the velocity.

    Args:
        M: Mass, kg.
        offset: Constant force against it, N.
        k_p: Gain of the position, 1/s.
        k_v: Gain of the velocity, V s/m.
        per_volt: Force of the drive per volt, N/V.
        volts_max: Largest voltage, V.
        T: Time between two samples, s.
        volts_start: Voltage in force before the first one computed, V.
    """

    M: Any
    offset: Any
    k_p: Any
    k_v: Any
    per_volt: Any
    volts_max: Any
    T: Any
    volts_start: Any


class CascadeInputs(NamedTuple):
    """Inputs of a cascade, all held from one instant to the next.

    Args:
        normal: Normal load, N.
        temperature: Temperature, K.
        goal: Position asked for, m.
        volts: Voltage added to the controller's, V.
        sampled: 1 at an instant at which the controller computes a voltage.
        late: 1 while the voltage of the sample before is still in force.
    """

    normal: Any
    temperature: Any
    goal: Any
    volts: Any
    sampled: Any
    late: Any


class SlideConstants(NamedTuple):
    """The slide bed's mass, springs and motor; `+` and `-` are the directions of the stretch.

    Args:
        m: Mass of the slide, kg.
        k_hat_plus: Gain of the motor, N/m, rightward.
        k_hat_minus: The same leftward.
        k_spring_plus: Stiffness of the spring, N/m, rightward.
        k_spring_minus: The same leftward.
        F_fm: Friction of the motor, N.
        inertia: Of the motor at the slide, K_kt J_m, kg.
        damping: Of the motor at the slide, K_kt D_m, N s/m.
        clamp: Largest force of the motor's inertia and damping, N.
        band: Speed below which the slide rests, m/s.
        impulse: That it takes to leave rest, N s.
    """

    m: Any
    k_hat_plus: Any
    k_hat_minus: Any
    k_spring_plus: Any
    k_spring_minus: Any
    F_fm: Any
    inertia: Any
    damping: Any
    clamp: Any
    band: Any
    impulse: Any


#: The columns of the slide bed's constants.
(
    MASS, K_HAT_P, K_HAT_M, K_SPRING_P, K_SPRING_M, F_FM, INERTIA, DAMPING, CLAMP, BAND, IMPULSE,
) = range(len(SlideConstants._fields))  # fmt: skip


class SlideInputs(NamedTuple):
    """Inputs of a slide: normal load, temperature, position commanded, force added to the motor."""

    normal: Any
    temperature: Any
    command: Any
    added: Any


def rows(constants: Sequence[Any], n: int) -> Array:
    """Constants of n candidates, each a number or (n,), as (n, WIDTH) rows in their order."""
    table = np.zeros((n, WIDTH))
    for column, values in zip(table.T, constants, strict=False):
        column[:] = values
    return table
