"""Closed loops with a compensator: a scale of 0 changes nothing, closed forms, refusals."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from stribeck.compensate.closed_loop import (
    CompensatedMotion,
    Reference,
    Sensor,
    compensated,
)
from stribeck.compensate.compensator import Compensator
from stribeck.data.recording import Recording
from stribeck.errors import InputError
from stribeck.friction import LAWS, Law, law_named
from stribeck.rig import RIGS, Rig
from stribeck.rig.motion.drives import SLIDE
from stribeck.rig.motion.implicit import motions
from stribeck.rig.simulated import SimulatedRig
from stribeck.rig.slide_bed import SLIDE_BED, SlideBed, published_both, with_inputs
from stribeck.rig.stepped import SteppedRig
from stribeck.space import Array

COULOMB, STRIBECK, LUGRE = LAWS["coulomb-viscous"], LAWS["stribeck"], LAWS["lugre"]
OFF = Compensator(scale=0.0)


def ramps(travel: float, speed: float, h: float = 1e-3, pause: float = 0.2) -> Reference:
    knots = np.cumsum([0.0, pause, travel / speed, pause, travel / speed, pause])
    t = np.arange(0.0, knots[-1], h)
    return Reference("ramps", t, np.interp(t, knots, travel * np.array([0, 0, 1, 1, 0, 0])))


def run(
    rig: Rig, law: Law, p: Array, reference: Reference, *compensators: Compensator, **options: Any
) -> CompensatedMotion:
    model = options.pop("model", (law, p))
    plants = np.repeat(np.atleast_2d(p), len(compensators), axis=0)
    return compensated(rig, law, plants, reference, compensators, model, **options)


def set_of(rig: Rig, law: Law, **values: float) -> Array:
    """A parameter set in the middle of its ranges, but for the values."""
    parameters = rig.parameters(law)
    return np.array(
        [
            values.get(q.name, q.fixed if q.fixed is not None else 0.5 * (q.lower + q.upper))
            for q in parameters
        ]
    )


def rms(x: Array) -> float:
    return float(np.sqrt(np.mean(x * x)))


JOINT = RIGS["joint"]
#: A joint under friction, without gravity: its loop follows a ramp without lag.
ROBOT: dict[str, float] = {"F_C": 1.5, "F_S": 2.5, "F_V": 2.0, "v_SS": 0.05, "J": 0.3,
                           "g_sin": 0.0, "g_cos": 0.0, "g_0": 0.0}  # fmt: skip
SERVO = RIGS["servo-pendulum"]
M4 = {"K_c": 0.02, "K_v": 0.01, "K_cs": 0.02, "w_s": 1.0, "alpha": 1.0, "K_l": 0.1, "K_ls": 0.1,
      "k_t": 0.4, "R": 4.0, "armature": 2e-3, "q_offset": 0.0}  # fmt: skip
BRISTLES = {"sigma_0": 1e5, "sigma_1": 100.0, "F_S": 140.0, "F_C": 50.0, "v_s": 2e-3,
            "F_V": 900.0, "k_spring": 900.0}  # fmt: skip


# --- nothing added ------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("rig", "law", "values"),
    [
        (JOINT, "stribeck", ROBOT),
        (JOINT.set(hold=1), "coulomb-viscous", ROBOT),
        (JOINT.set(hold=2), "stribeck", ROBOT),
        (SERVO, "bam-m4", M4),
        (RIGS["slide-bed"], "lugre", BRISTLES),
    ],
    ids=["joint", "held", "late", "servo", "slide-bed"],
)
def test_a_scale_of_nothing_is_the_rigs_own_motion_bit_for_bit(
    rig: SimulatedRig, law: str, values: dict[str, float]
) -> None:
    reference = ramps(0.6, 0.6) if rig.rotary else ramps(0.08, 0.04)
    friction = law_named(law)
    p = set_of(rig, friction, **values)
    x = reference.x
    log = Recording(t=reference.t, position=x, command=x, rotary=rig.rotary)
    segment = rig.track(log, slice(0, len(x)), float(x[0]), np.ones(len(x)))._replace(v0=0.0)
    if isinstance(rig, SlideBed):  # it is quicker between the samples, where no controller is
        laws, c = rig.split(friction, p[None])
        stepped = with_inputs(segment)
        q, v, _ = motions(friction, SLIDE, laws, c, stepped, rig["step"], rig["tolerance"])
    else:
        q, v = rig.states(friction, p[None], segment)
    moved = run(rig, friction, p, reference, OFF, replace(OFF, feedback=False))
    for row in range(2):
        assert np.array_equal(moved.position[row], q[0])
        assert np.array_equal(moved.velocity[row], v[0])
    assert not moved.output.any()
    assert np.ptp(q) > 0.3 * np.ptp(x)  # and it is a motion


def test_a_slide_bed_that_sticks_moves_as_its_two_integrators_say() -> None:
    reference = ramps(0.06, 0.005)
    law, p = LAWS["stribeck-directional"], published_both()
    moved = run(SLIDE_BED, law, p, reference, OFF).position[0]
    x = reference.x
    log = Recording(t=reference.t, position=x, command=x)
    segment = SLIDE_BED.track(log, slice(0, len(x)), 0.0, np.ones(len(x)))
    laws, c = SLIDE_BED.split(law, p[None])
    step, tolerance = SLIDE_BED["step"], SLIDE_BED["tolerance"]
    stepped = motions(law, SLIDE, laws, c, with_inputs(segment), step, tolerance)
    assert np.array_equal(moved, stepped[0][0])
    events = SLIDE_BED.move(law, p[None], segment).position[0]
    assert rms(moved - events) < 0.02 * rms(x - events)


def test_the_cascade_of_emps_follows_as_its_own_simulation_does() -> None:
    emps = RIGS["emps"]
    law = COULOMB
    p = set_of(emps, law, F_C=20.0, F_V=200.0, M=95.0, offset=-3.0)
    reference = ramps(0.02, 0.02)
    log = Recording(t=reference.t, position=reference.x, command=reference.x,
                    voltage=np.zeros(len(reference.t)))  # fmt: skip
    simulated = emps.simulate(law, p[None], log).position[0]
    moved = run(emps, law, p, reference, OFF).position[0]
    # They differ by how the velocity is measured: half a sample to a sample and a half late.
    assert rms(moved - simulated) < 0.03 * rms(reference.x - simulated)


# --- closed forms -------------------------------------------------------------------------------


def test_a_perfect_model_leaves_the_axis_without_friction() -> None:
    """The friction that remains is its change within a sample: proportional to the period."""
    bare = set_of(JOINT, COULOMB, **ROBOT | {"F_C": 0.0, "F_V": 0.0})
    p = set_of(JOINT, STRIBECK, **ROBOT)
    remainders, errors = [], []
    for h in (2e-3, 5e-4):
        reference = ramps(0.2, 0.1, h)
        moving = reference.t < 2.19  # then the reference stops, and friction is let hold
        free = run(JOINT, COULOMB, bare, reference, OFF).position[0]
        moved = run(JOINT, STRIBECK, p, reference, OFF, Compensator()).position
        remainders.append(rms((moved[1] - free)[moving]))
        errors.append(rms((moved[0] - free)[moving]))
    assert remainders[0] < 0.05 * errors[0]
    assert remainders[1] < 0.5 * remainders[0]


@pytest.mark.parametrize("scale", [0.0, 0.3, 0.6])
def test_a_stuck_slide_breaks_away_where_the_forces_say(scale: float) -> None:
    """k_spring e + k_hat e + s (F_C + F_fm) − F_fm = F_C, the motor past its own friction."""
    F_C, k = 60.0, 900.0
    p = set_of(SLIDE_BED, COULOMB, F_C=F_C, F_V=500.0, k_spring=k)
    F_fm, k_hat = SLIDE_BED["F_fm"], SLIDE_BED["k_hat+"]
    reference = ramps(0.06, 0.01)
    compensator = Compensator(scale=scale, feedback=False, drive=SLIDE_BED.drive_friction())
    # A model of the level alone: the viscous part of the axis is not at work while it rests.
    model = set_of(SLIDE_BED, COULOMB, F_C=F_C, F_V=0.0, k_spring=k)
    moved = run(SLIDE_BED, COULOMB, p, reference, compensator, model=(COULOMB, model))
    stretch = (reference.x - moved.position[0])[np.flatnonzero(moved.velocity[0])[0]]
    assert stretch == pytest.approx((1 - scale) * (F_C + F_fm) / (k + k_hat), abs=3e-5)


def test_a_servo_is_given_the_volts_that_make_the_torque() -> None:
    """At stall the added torque is the output, if k_t and R are known."""
    law = law_named("coulomb-viscous")
    p = set_of(SERVO, law, F_C=0.05, F_V=0.0, k_t=0.3, R=7.0, armature=2e-3, q_offset=0.0)
    reference = ramps(0.02, 0.02)
    level = set_of(SERVO, law, F_C=0.02, F_V=0.0, k_t=0.3, R=7.0, armature=2e-3, q_offset=0.0)
    moved = run(SERVO, law, p, reference, OFF, Compensator(feedback=False), model=(law, level))
    k = int(0.21 / reference.h)  # it has hardly left, and the reference moves
    assert moved.output[1, k] == 0.02
    assert moved.force[1, k] - moved.force[0, k] == pytest.approx(0.02, rel=0.02)


def test_the_output_is_held_and_the_velocity_is_a_difference_of_counts() -> None:
    reference = ramps(0.2, 0.1)
    sensor = Sensor(resolution=1e-4)
    p = set_of(JOINT, STRIBECK, **ROBOT)
    moved = run(JOINT, STRIBECK, p, reference, Compensator(dead_band=0.05), sensor=sensor)
    counts = moved.seen[0] / (sensor.resolution / reference.h)
    np.testing.assert_allclose(counts, np.round(counts), atol=1e-6)
    shown = np.floor(moved.position[0] / 1e-4 + 0.5) * 1e-4
    np.testing.assert_allclose(moved.seen[0, 1:], np.diff(shown) / reference.h, atol=1e-6)


def test_noise_is_the_same_for_its_seed_and_disturbs() -> None:
    reference = ramps(0.2, 0.1)
    p = set_of(JOINT, STRIBECK, **ROBOT)
    compensator = Compensator(dead_band=0.02)
    motion = [
        run(
            JOINT, STRIBECK, p, reference, compensator, sensor=Sensor(noise=1e-5, seed=seed)
        ).position
        for seed in (1, 1, 2)
    ]
    assert np.array_equal(motion[0], motion[1])
    assert not np.array_equal(motion[0], motion[2])


# --- laws with states and loads -----------------------------------------------------------------


@pytest.mark.parametrize(
    ("rig", "name", "values", "reference"),
    [
        (SLIDE_BED, "lugre", BRISTLES, ramps(0.06, 0.005)),
        (SERVO, "bam-m4", M4, ramps(0.5, 0.25)),
        (JOINT, "stribeck+temperature", ROBOT | {"temp_slope": 0.0}, ramps(0.2, 0.1)),
    ],
    ids=["bristles", "load", "term"],
)
def test_a_model_with_states_loads_or_terms_compensates_its_own_axis(
    rig: Rig, name: str, values: dict[str, float], reference: Reference
) -> None:
    law = law_named(name)
    p = set_of(rig, law, **values)
    rig_values = p[len(law.params) :]
    bare = np.concatenate([np.zeros(2), rig_values])
    free = run(rig, COULOMB, bare, reference, OFF).position[0]
    compensator = Compensator(drive=rig.drive_friction())
    without, compensated_motion = run(rig, law, p, reference, OFF, compensator).position
    moving = np.abs(reference.v) > 0.0
    assert rms((compensated_motion - free)[moving]) < 0.2 * rms((without - free)[moving])


def test_bristles_of_a_compensator_advance_only_as_it_may_know() -> None:
    """Without feedback its states follow the reference: the output builds up over the bristle."""
    p = set_of(SLIDE_BED, LUGRE, **BRISTLES | {"sigma_0": 1e3, "sigma_1": 0.0, "F_V": 0.0})
    reference = ramps(0.02, 0.005)
    moved = run(
        SLIDE_BED, LUGRE, p, reference, Compensator(feedback=False), Compensator(dead_band=1e-3)
    )
    travel = reference.x - reference.x[0]
    k = int((0.2 + 2.0) / reference.h)  # 10 mm on; the relaxed bristle bends towards F/sigma_0
    level = BRISTLES["F_C"] + (BRISTLES["F_S"] - BRISTLES["F_C"]) * np.exp(-(2.5**2))
    bent = level * (1 - np.exp(-1e3 * travel[k] / level))
    assert moved.output[0, k] == pytest.approx(bent, rel=0.02)
    # With feedback the output is the breakaway level of the resting axis instead.
    first = moved.output[1, np.flatnonzero(moved.output[1])[0]]
    assert first == pytest.approx(BRISTLES["F_S"], rel=1e-6)


# --- ends of the world --------------------------------------------------------------------------


def test_an_axis_that_runs_away_ends_there_and_leaves_the_others_alone() -> None:
    p = set_of(JOINT, COULOMB, **ROBOT | {"F_C": 0.0, "F_V": 20.0})
    reference = ramps(0.2, 0.1)
    wild = Compensator(scale=3.0, feedback=True)
    strong = JOINT.set(limit=1e30)  # else the drive's limit keeps it in a cycle
    moved = run(strong, COULOMB, p, reference, wild, OFF)
    assert np.isnan(moved.position[0, -1])
    alone = run(strong, COULOMB, p, reference, OFF)
    assert np.array_equal(moved.position[1], alone.position[0])


def test_a_parameter_that_is_no_number_spoils_its_own_row_only() -> None:
    p = set_of(JOINT, STRIBECK, **ROBOT)
    broken = p.copy()
    broken[0] = np.nan
    reference = ramps(0.2, 0.1)
    moved = compensated(
        JOINT, STRIBECK, np.array([broken, p]), reference, [Compensator()], (STRIBECK, p)
    )
    assert np.isfinite(moved.position[1]).all()
    assert np.array_equal(
        moved.position[1], run(JOINT, STRIBECK, p, reference, Compensator()).position[0]
    )


def test_a_controller_as_slow_as_the_motion_is_simulated_all_the_same() -> None:
    reference = ramps(0.2, 0.1, h=0.1)
    p = set_of(JOINT, STRIBECK, **ROBOT)
    moved = run(JOINT, STRIBECK, p, reference, OFF, Compensator())
    assert np.isfinite(moved.position).all()


@pytest.mark.parametrize(
    "name",
    ["forced", "forced-rotary", "forced-pendulum", "cylinder", "presliding", "presliding-rotary"],
)
def test_rigs_without_a_controller_are_refused(name: str) -> None:
    rig = RIGS[name]
    p = set_of(rig, COULOMB)
    with pytest.raises(InputError, match=f"rig {name} has no controller"):
        run(rig, COULOMB, p, ramps(0.1, 0.1), OFF)


def test_what_does_not_fit_is_refused() -> None:
    p, reference = set_of(JOINT, STRIBECK, **ROBOT), ramps(0.2, 0.1)
    with pytest.raises(InputError, match="got 3 columns"):
        run(JOINT, STRIBECK, p[:3], reference, OFF, model=(STRIBECK, p))
    with pytest.raises(InputError, match="has 9 parameters"):
        run(JOINT, STRIBECK, p, reference, OFF, model=(STRIBECK, p[:3]))
    with pytest.raises(InputError, match="one each"):
        compensated(JOINT, STRIBECK, np.array([p] * 3), reference, [OFF] * 2, (STRIBECK, p))
    with pytest.raises(InputError, match="not evenly spaced"):
        Reference("odd", np.array([0.0, 1.0, 3.0]), np.zeros(3))
    with pytest.raises(InputError, match="finite"):
        Reference("odd", np.arange(3.0), np.array([0.0, np.nan, 0.0]))
    with pytest.raises(InputError, match="resolution"):
        Sensor(resolution=-1.0)
    long_reference = Reference("long", np.array([0.0, 1e9, 2e9]), np.array([0.0, 1.0, 2.0]))
    with pytest.raises(InputError, match="take a shorter one"):
        run(JOINT, STRIBECK, p, long_reference, OFF)
    assert isinstance(JOINT, SteppedRig)
