"""The drives that the implicit stepper knows: their constants and inputs, by name.

A candidate's constants are a row of numbers, an instant's inputs a row of INPUTS, so that one
compiled stepper serves every axis. Here the columns have their names: a rig fills them by name,
compiled code reads them by name. The row of an axis of parts has its functions, too.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

#: The kinds of drive: an axis composed of parts, the paper's slide bed, and two masses of parts.
AXIS, SLIDE, TWO_MASSES = range(3)
#: How a demand is kept: it follows the axis at all times; held from a sample of the log to the
#: next; in force a sample late; computed and in force when the inputs say so.
FOLLOWS, HELD, LATE, CLOCKED = range(4)


class AxisConstants(NamedTuple):
    """What the row of an axis of parts begins with: what is of the axis as a whole.

    The neutral values are those of parts that are not there. Units are SI at the axis; a demand is
    in what the motor takes: N or N m, A, or V.

    Args:
        M: Mass or moment of inertia that moves, kg or kg m^2.
        limit: Largest demand.
        hold: How a demand is kept, FOLLOWS to CLOCKED.
        k_i: Rate at which a sampled controller integrates its demand, 1/s.
        T: Sample time of a controller that integrates or takes differences, s.
        difference: 1 where its velocity is the mean of the last two differences of positions.
        resolution: Step of the position that a sampled controller reads; 0 for none.
        start: Demand in force before the first one computed; nan for that one.
        force_limit: Largest force of the motor, N or N m.
        motor_friction: Coulomb friction of the motor, which takes its share of its force.
    """

    M: Any
    limit: Any = np.inf
    hold: Any = FOLLOWS
    k_i: Any = 0.0
    T: Any = 0.0
    difference: Any = 0.0
    resolution: Any = 0.0
    start: Any = np.nan
    force_limit: Any = np.inf
    motor_friction: Any = 0.0


#: The columns of what the row of an axis of parts begins with.
(
    MOVING, LIMIT, HOLD, INTEGRATES, SAMPLE_TIME, DIFFERENCE, RESOLUTION, START, FORCE_LIMIT,
    MOTOR_FRICTION,
) = range(len(AxisConstants._fields))  # fmt: skip


class AxisInputs(NamedTuple):
    """Inputs of an axis; a rig states the first of them, the others stay as here.

    Args:
        normal: Normal load, as the law counts it.
        temperature: K.
        added: Demand beside the controller's, beyond its limit: a measured force, pulses.
        goal: Position asked for, m or rad.
        goal_velocity: Velocity asked for.
        feed_forward: Demand that is added to the controller's, within its limit.
        enabled: 1 while the motor drives and brakes.
        sampled: 1 at an instant at which a CLOCKED controller computes a demand.
        late: 1 while the demand of the sample before is still in force.
        external: Force on the load from outside, N or N m.
    """

    normal: Any = 0.0
    temperature: Any = 0.0
    added: Any = 0.0
    goal: Any = 0.0
    goal_velocity: Any = 0.0
    feed_forward: Any = 0.0
    enabled: Any = 1.0
    sampled: Any = 0.0
    late: Any = 0.0
    external: Any = 0.0


#: Inputs that an instant may have, and what they are where a rig does not state them.
INPUTS = len(AxisInputs._fields)
IDLE = AxisInputs()
#: Where each stands.
(
    NORMAL_LOAD, TEMPERATURE, ADDED, GOAL, GOAL_VELOCITY, FEED_FORWARD, ENABLED, SAMPLED_NOW,
    LATE_NOW, EXTERNAL_FORCE,
) = range(INPUTS)  # fmt: skip


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


#: Where the inputs of a slide stand that are its own: its position commanded, and what is added to
#: the motor's force. Its normal load and temperature stand where those of an axis of parts do.
SLIDE_COMMAND, SLIDE_ADDED = 2, 3
