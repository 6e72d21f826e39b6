"""The co-simulation unit of axes of parts moves as they do, on every line of its motion in C."""

from __future__ import annotations

import shutil
import tomllib
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

from counted_units import GCOV, Built
from exported import model_of as slide
from fmu_unit import difference, moved, ramp, rig_of
from joint_models import model_of
from stribeck.data.recording import Recording
from stribeck.export.fmu import build
from stribeck.export.model import Model
from stribeck.rig.axis_table import composed_axis
from stribeck.rig.motion.drives import SLIDE
from stribeck.rig.motion.implicit import motions
from stribeck.rig.motion.track import Track
from stribeck.rig.parts import PARTS
from stribeck.rig.slide_bed import SlideBed, with_inputs
from stribeck.space import Array

CC = next(filter(None, map(shutil.which, ("gcc", "cc"))), None)
pytestmark = pytest.mark.skipif(CC is None, reason="there is no C compiler here")

t = np.arange(0.0, 1.5, 2e-3)
GOAL: Array = 0.5 * np.sin(4.0 * t) + 0.1 * np.sin(19.0 * t)
RATE: Array = np.gradient(GOAL, t)

#: An axis of parts, its law with parameters, SI, and what drives it by input.
AXES: dict[str, tuple[str, str, dict[str, float], Mapping[str, Array]]] = {
    "damped, force, pendulum: torque limit, switched off": (
        """
        rotary = true
        controller.damped = { kp = 10.0, kd = 0.3, gain_p = 0.9 }
        motor.force = { F_max = 2.0, armature = 0.008 }
        load.pendulum = { m = 0.5, l = 0.15, m_arm = 0.078, q_offset = 0.02 }
        """,
        "stribeck", {"F_S": 0.2, "F_C": 0.1, "F_V": 0.04, "v_SS": 0.3},
        {"goal": GOAL, "enabled": np.where(t < 1.0, 1.0, 0.0)},
    ),
    "pwm, voltage, gear, inertia: current limit, losses": (
        """
        rotary = true
        controller.pwm = { kp = 20.0, vin = 24.0, duty = 0.2 }
        motor.voltage = { k_t = 0.05, R = 1.5, I_max = 6.0, armature = 2e-5 }
        transmission.gear = { gear_ratio = 20.0, eta = 0.8, eta_back = 0.7 }
        load.inertia = { J = 0.05, g_sin = 1.5, g_cos = 0.4, g_0 = 0.1 }
        load.ripple = { rip_period = 0.3, rip_cos = 0.1, rip_sin2 = 0.05 }
        load.motor-ripple = { cog_order = 2.0, cog_cos = 0.01, cog_sin = 0.02 }
        """,
        "bam-m4", {"K_c": 0.3, "K_v": 0.2, "K_cs": 0.2, "w_s": 0.4, "alpha": 1.2, "K_l": 0.1,
                   "K_ls": 0.1},
        {"goal": GOAL, "feed_forward": 2.0 * np.cos(5.0 * t)},
    ),
    "pd, current, screw, mass, spring: motor friction": (
        """
        controller.pd = { kp = 400.0, kd = 8.0, limit = 0.5 }
        motor.current = { k_t = 0.2, armature = 3e-5, F_fm = 30.0 }
        transmission.screw = { lead = 0.01 }
        load.mass = { M = 20.0, offset = 15.0 }
        load.spring = { k_spring = 800.0, q_spring = 0.05 }
        sensor.lead-error = { err_period = 0.01, err_cos = 1e-4, err_sin = 5e-5 }
        """,
        "lugre", {"sigma_0": 1e5, "sigma_1": 500.0, "F_S": 60.0, "F_C": 40.0, "v_s": 0.02,
                  "F_V": 200.0},
        {"goal": 0.1 * GOAL, "goal_velocity": 0.1 * RATE,
         "external": 25.0 * np.sin(11.0 * t)},
    ),
    "cascade, force, rigid, mass, encoder: integrates, a sample late": (
        """
        controller.cascade.limit = 99.0
        controller.cascade.difference = 1.0
        controller.cascade.hold = 2.0
        controller.cascade.kp = 20.0
        controller.cascade.kv = 300.0
        controller.cascade.ki = 8.0
        motor.force = {}
        transmission.rigid = {}
        load.mass = { M = 5.0, offset = 4.0 }
        sensor.encoder = { resolution = 1e-5 }
        """,
        "coulomb-viscous", {"F_C": 12.0, "F_V": 30.0},
        {"goal": 0.1 * GOAL, "goal_velocity": 0.1 * RATE},
    ),
    "none, voltage, rigid, inertia: recorded voltage": (
        """
        rotary = true
        controller.none = {}
        motor.voltage = { k_t = 0.3, R = 4.0, armature = 1e-4 }
        load.inertia = { J = 0.01 }
        """,
        "gms", {"W_1": 0.03, "W_2": 0.03, "W_3": 0.02, "W_4": 0.02, "d_1": 1e-3, "r_2": 2.0,
                "r_3": 2.0, "r_4": 2.0, "F_V": 0.02, "ratio": 1.4, "v_s": 0.3, "tau": 0.01},
        {"voltage": 6.0 * np.sin(7.0 * t)},
    ),
    "none, force, rigid, mass: bristles too quick to be followed": (
        "controller.none = {}\nload.mass = { M = 1e-4 }\nstep = 20.0",
        "lugre", {"sigma_0": 1e6, "sigma_1": 10.0, "F_S": 20.0, "F_C": 12.0, "v_s": 0.01,
                  "F_V": 40.0},
        {"force": 25.0 * np.sin(9.0 * t)},
    ),
    "none, force, rigid, mass: sticks and slips at every reversal": (
        "controller.none = {}\nload.mass = { M = 2.0 }\nstep = 20.0",
        "stribeck", {"F_S": 20.0, "F_C": 5.0, "F_V": 30.0, "v_SS": 0.01},
        {"force": 30.0 * np.sin(9.0 * t) * np.cos(40.0 * t)},
    ),
    "none, force, rigid, mass: creeps, stops and breaks away": (
        "controller.none = {}\nload.mass = { M = 1e-3 }\nstep = 0.02",
        "stribeck", {"F_S": 20.0, "F_C": 5.0, "F_V": 3000.0, "v_SS": 1e-4},
        {"force": 30.0 * np.sin(9.0 * t) ** 3},
    ),
}  # fmt: skip


def composed(name: str) -> Model:
    """The model of an axis of the table."""
    table, law, values, _ = AXES[name]
    return model_of(composed_axis(tomllib.loads(table), "axis"), law, values)


def driven(model: Model, inputs: Mapping[str, Array]) -> Track:
    """The track of an axis under inputs, from a slow motion."""
    columns = {"goal_velocity": "command_velocity", "enabled": "torque_enable"}
    log = Recording(
        t=t, position=np.zeros(len(t)), rotary=model.rig.rotary, command=inputs.get("goal"),
        force=inputs.get("force"), voltage=inputs.get("voltage"),
        extra={columns.get(n, n): x for n, x in inputs.items()},
    )  # fmt: skip
    track = rig_of(model).track(log, slice(0, len(t)), 0.0, np.ones(len(t)))
    return track._replace(v0=0.02)


def test_the_axes_have_every_part_of_one_mass() -> None:
    tables = [tomllib.loads(table) for table, *_ in AXES.values()]
    used = {(p.role, p.name) for table in tables for p in composed_axis(table, "axis").parts}
    both = {("transmission", "compliant"), ("sensor", "motor"), ("sensor", "load")}
    assert used == PARTS.keys() - both


@pytest.fixture
def built(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Built:
    units = Built(tmp_path)
    monkeypatch.setattr(build, "_compiled", units.compiled)
    return units


#: Lines that no motion here reaches: where one ends that runs away or takes too many steps; where a
#: root or a stop is met exactly; and limits that are infinite.
IDLE = {
    "return NAN;", "*result_2 = NAN;", "*result_3 = 0;", "return 0.0;", "return low;",
    "return high;", "return w;", "return s * w;", "return q;", "v = 0.0;", "damped = 1;",
    "stop = piece * (v - way * band) / (v - v_1);", "demand = copysign(INFINITY, demand);",
    "force = copysign(INFINITY, force);",
}  # fmt: skip
#: Functions that other tests walk: of a law, and of a drive that may follow its axis or not.
ELSEWHERE = {"motion_rubbed", "motion_steady", "motion_drive"}


def stepped(model: Model, track: Track) -> tuple[Array, Array]:
    """Position and velocity as the stepper of all rigs has them, which a unit steps as.

    A slide that sticks, or creeps, has a kernel of its own in its rig.
    """
    rig = rig_of(model)
    if not isinstance(rig, SlideBed) or model.law.sticks:
        motion = rig.move(model.law, model.values[None], track)
        return motion.position[0], motion.velocity[0]
    laws, c = rig.split(model.law, model.values[None])
    inputs = with_inputs(track)
    x, v, *_ = motions(model.law, SLIDE, laws, c, inputs, rig["step"], rig["tolerance"])
    return x[0], v[0]


@pytest.mark.skipif(GCOV is None, reason="there is no gcov here")
def test_units_of_all_parts_move_as_their_axes_on_every_line(built: Built) -> None:
    ran, idle = set[str](), set[str]()
    axes = {name: (composed(name), inputs) for name, (_, _, _, inputs) in AXES.items()}
    cases = {name: (model, driven(model, inputs), 1e-12) for name, (model, inputs) in axes.items()}
    # A slide that sticks goes from event to event there, and in short steps here.
    for law, most in (("stribeck", 1e-4), ("lugre", 1e-12)):
        cases[law] = slide(law), ramp(), most
    for name, (model, track, most) in cases.items():
        position, velocity = stepped(model, track)
        unit = built.opened(model)
        motion = moved(unit, model, track)
        unit.slave.freeInstance()  # and unloads it, which writes the counts
        assert difference(motion[0], position) <= most, name
        assert difference(motion[1], velocity) <= 1e3 * most, name
        now, never = built.lines()
        ran, idle = ran | now, idle | never
    assert len(ran) > 600
    never = {line for line in idle - ran if line.partition(": ")[0] not in ELSEWHERE}
    assert {line.partition(": ")[2] for line in never} <= IDLE
