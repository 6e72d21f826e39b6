"""Axes of two masses that a spring with play joins: against plain steps, limits, and as files."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from foreign import two_masses as plain_steps
from joint_models import model_of
from stribeck import LAWS, Fit, InputError, Recording, compensate, export, identify
from stribeck.compensate.compensation import around
from stribeck.identify.data_check import data_violations
from stribeck.rig.axis_table import composed_axis
from stribeck.rig.motion.track import Track
from stribeck.rig.simulated import as_simulated
from stribeck.rig.two_masses import TwoMassRig
from stribeck.space import Array
from two_mass_axes import FORCE, GAINS, GOAL, SERVO, moved, rig_of, started, t
from written_equation import acceleration

LAW = LAWS["coulomb-viscous"]
AXES: dict[str, tuple[dict[str, float], str, dict[str, Array]]] = {
    "play, under force": (SERVO, "coulomb-viscous", {"force": FORCE}),
    "no play, no damper": (SERVO | {"play": 0.0, "damping": 0.0}, "coulomb-viscous",
                           {"force": FORCE}),
    "play in a loop": (SERVO | GAINS, "coulomb-viscous", {"goal": GOAL}),
    "play and a lossy gear": (SERVO | {"eta": 0.8, "eta_back": 0.6}, "coulomb-viscous",
                              {"force": FORCE}),
    "behind a gear": (SERVO | {"gear": 5.0, "armature": 0.1}, "coulomb-viscous",
                      {"force": 0.2 * FORCE}),
    "a loop behind a gear": (
        SERVO | {"gear": 5.0, "armature": 0.1, "kp": 4e3, "kd": 60.0}, "coulomb-viscous",
        {"goal": GOAL},
    ),
    "a load that sticks and jumps": (
        SERVO | GAINS | {"stiffness": 4e4, "F_S": 60.0, "v_SS": 5e-3, "F_S_motor": 10.0,
                         "v_SS_motor": 5e-3, "exponent": 2.0, "exponent_motor": 2.0},
        "stribeck", {"goal": 0.02 * t},
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", AXES)
def test_two_masses_are_their_equations(name: str) -> None:
    """Plain steps come nearer and nearer, in proportion to their length."""
    values, law, inputs = AXES[name]
    motor, load = moved(rig_of(values, law), values, **inputs)
    n = values.get("gear", 1.0)
    drive = {"drive" if name == "force" else name: x for name, x in inputs.items()}
    drive |= {"drive": n * drive["drive"]} if "drive" in drive else {}
    stated = {"M_m": n * n * values["armature"], **values}
    stated |= {name: n * values[name] for name in GAINS if name in values}
    errors = []
    for sub in (50, 400, 3200):
        known_motor, known_load = plain_steps.simulate(stated, t, sub, **drive)
        off = np.abs(known_motor - motor).max(), np.abs(known_load - load).max()
        errors.append(float(max(off)))
    way = np.ptp(motor - load)
    assert way > 5e-5
    assert errors[2] < 5e-3 * way
    assert errors[2] < 0.25 * errors[1] < 0.06 * errors[0]


def test_a_motion_does_not_depend_on_the_tolerance_of_its_steps() -> None:
    values = SERVO | GAINS
    fine, rough = (
        moved(rig_of(values, tolerance=tolerance), values, goal=GOAL) for tolerance in (1e-4, 0.1)
    )
    for a, b in zip(fine, rough, strict=True):
        assert np.abs(a - b).max() < 1e-7


def test_an_axis_left_alone_loses_energy() -> None:
    """From where the force ends on; its spring has no damper, so that positions tell its energy."""
    values = SERVO | {"damping": 0.0, "F_C": 2.0, "F_C_motor": 1.0}
    rig = rig_of(values)
    force = np.where(t < 0.1, FORCE, 0.0)
    p = np.array([[values[q.name] for q in rig.parameters(LAW)]])
    motor, load = rig.sides(LAW, p, started(rig, force))
    ahead = motor.position[0] - load.position[0]
    twist = np.sign(ahead) * np.maximum(np.abs(ahead) - 0.5 * values["play"], 0.0)
    energy = 0.5 * (
        2.0 * motor.velocity[0] ** 2 + 5.0 * load.velocity[0] ** 2 + values["stiffness"] * twist**2
    )
    alone = energy[t > 0.102]
    assert alone[0] > 0.1
    assert np.diff(alone).max() < 1e-9 * alone[0]
    assert alone[-1] < 1e-3 * alone[0]


@pytest.mark.parametrize("values", [SERVO, SERVO | {"play": 0.0}])
def test_a_mirrored_force_mirrors_the_motion(values: dict[str, float]) -> None:
    rig = rig_of(values)
    forth, back = (moved(rig, values, force=sign * FORCE) for sign in (1.0, -1.0))
    for a, b in zip(forth, back, strict=True):
        np.testing.assert_array_equal(a, -b)


def test_the_force_of_the_drive_is_that_of_each_motion_from_its_start_on() -> None:
    """One after the other, no motion begins with the force at which the last one ended."""
    rig, force = rig_of(SERVO), 70.0 * np.cos(8.0 * t)
    values = [{**SERVO, "F_C": level} for level in (20.0, 15.0, 10.0, 5.0, 25.0)]
    p = np.array([[row[q.name] for q in rig.parameters(LAW)] for row in values])
    motor, load = rig.sides(LAW, p, started(rig, force))
    for side in (motor, load):
        np.testing.assert_allclose(side.force, np.tile(force, (len(p), 1)), atol=1e-9)


def test_a_stiff_coupling_is_none() -> None:
    """The nearer to the rigid axis the stiffer, in proportion."""
    table = {
        "controller": {"none": {}}, "motor": {"force": {"armature": 2.0}},
        "load": {"mass": {"M": 5.0}}, "law": "coulomb-viscous", "tolerance": 1e-3,
    }  # fmt: skip
    rigid = as_simulated(composed_axis(table, "rigid"))
    known = rigid.move(LAW, np.array([[30.0, 50.0]]), started(rigid, FORCE)).position[0]
    errors = []
    for k in (1e5, 1e6, 1e7):
        values = SERVO | {"stiffness": k, "damping": 2.0 * np.sqrt(k), "play": 0.0}
        motor, load = moved(rig_of(values), values, force=FORCE)
        errors.append(max(np.abs(motor - known).max(), np.abs(load - known).max()))
    assert errors[2] < 2e-4 * np.ptp(known)
    assert errors[2] < 0.2 * errors[1] < 0.04 * errors[0]


def test_the_controller_reads_the_side_that_it_is_said_to() -> None:
    """With the load's encoder in the loop the load comes to where it is asked to be."""
    values = SERVO | GAINS | {"F_C": 0.0, "F_C_motor": 0.0, "offset": 20.0}  # 1 mm of the loop
    goal = 1e-3 * np.minimum(t / 0.2, 1.0)
    by_motor = moved(rig_of(values), values, goal=goal)
    sensors = {"motor": {}, "load": {"by_load": 1}}
    by_load = moved(rig_of(values, sensor=sensors), values, goal=goal)
    assert abs(by_motor[0][-1]) < 1e-6
    assert abs(by_motor[1][-1] + 0.5 * values["play"] + 20.0 / values["stiffness"]) < 1e-6
    assert abs(by_load[1][-1]) < 1e-6


def logged(path: Path, values: dict[str, float], seed: int) -> Path:
    """A log of both encoders, by plain steps, the motor's in mrad of a screw of 10 mm lead."""
    stated = {"M_m": values["armature"], **values}
    motor, load = plain_steps.simulate(stated, t, 1000, goal=GOAL)
    rng = np.random.default_rng(seed)
    per_load = 2e3 * np.pi / 0.01
    shown = per_load * (motor + 0.3 + 1e-6 * rng.standard_normal(len(t)))
    load = load + 2e-6 * rng.standard_normal(len(t))
    head = "t [s],q [m],goal [m],shaft"
    table = np.column_stack([t, load, GOAL + 0.3, shown])
    np.savetxt(path, table, delimiter=",", header=head, comments="", fmt="%.12g")
    return path


AXIS = """
law = "coulomb-viscous"
ranges = { F_C = [5, 50], F_V = [0, 100], F_C_motor = [5, 50], F_V_motor = [0, 100] }
[controller.damped]
kp = 20000.0
kd = 300.0
[motor.force]
armature = 2.0
[transmission.compliant]
stiffness = { free = [2e5, 1e6] }
damping = 100.0
play = { free = [1e-4, 5e-4] }
[load.mass]
M = 5.0
[sensor.motor]
per_load = 628318.5307
[sensor.load]
[friction]
side = "both"
[inputs]
motor_position = "shaft"
[columns]
time = "t [s]"
position = "q [m]"
command = "goal [m]"
"""


@pytest.fixture
def axis_file(tmp_path: Path) -> Path:
    path = tmp_path / "axis.toml"
    path.write_text(AXIS, encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def two_encoders(tmp_path_factory: pytest.TempPathFactory) -> Fit:
    """A fit of a log of both encoders."""
    folder = tmp_path_factory.mktemp("axis")
    path = folder / "axis.toml"
    path.write_text(AXIS, encoding="utf-8")
    log = logged(folder / "log.csv", SERVO | GAINS, 0)
    return identify(log, rig=str(path), repeats=1, budget=400)


def test_two_encoders_tell_compliance_play_and_both_frictions(two_encoders: Fit) -> None:
    fit = two_encoders
    assert fit.score.value < 1.1 * np.sqrt(0.5 * (1e-3**2 + 2e-3**2))  # mm, of both encoders
    for e in fit.estimates:
        truth = SERVO[e.name]
        assert e.low <= truth <= e.high, e.name
        assert e.high - e.low < 0.5 * truth
    play = next(e for e in fit.estimates if e.name == "play")
    assert play.verdict == "identified"
    assert play.high - play.low < 0.02 * SERVO["play"]


def test_a_motion_that_no_loop_holds_is_fitted_by_its_beginning_first(tmp_path: Path) -> None:
    """Under a recorded force; over the whole log J has minima at several times the noise."""
    stated = {"M_m": SERVO["armature"], **SERVO}
    motor, load = plain_steps.simulate(stated, t, 1000, drive=FORCE)
    rng = np.random.default_rng(0)
    motor = 2e2 * np.pi / 1e-3 * (motor + 1e-6 * rng.standard_normal(len(t)))
    load = load + 2e-6 * rng.standard_normal(len(t))
    np.savetxt(tmp_path / "log.csv", np.column_stack([t, load, FORCE, motor]), delimiter=",",
               header="t [s],q [m],F [N],shaft", comments="", fmt="%.12g")  # fmt: skip
    text = AXIS.replace("[controller.damped]\nkp = 20000.0\nkd = 300.0\n", "")
    text = text.replace('command = "goal [m]"', 'force = "F [N]"')
    (tmp_path / "axis.toml").write_text(text, encoding="utf-8")
    fit = identify(tmp_path / "log.csv", rig=str(tmp_path / "axis.toml"), repeats=1, budget=400,
                   delay=0.0)  # fmt: skip
    for e in fit.estimates:
        assert abs(e.value / SERVO[e.name] - 1.0) < 0.04, e.name
        assert e.verdict != "identified"
    assert any("no controller holds the two masses" in w for w in fit.warnings)


def test_what_moves_one_mass_refuses_two(two_encoders: Fit) -> None:
    words = "a joint there has one mass and no play, and rig axis has two"
    for target in ("mjcf", "urdf"):
        with pytest.raises(InputError, match=f"{target}: {words}"):
            export(two_encoders, target, into="model.xml", joint="hinge")
    exported = export(two_encoders, "c")
    assert "this is the load's friction" in exported.notes[0]
    with pytest.raises(InputError, match="two masses, and a compensation is tried on"):
        compensate(two_encoders)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("armature = 2.0", "", "motor.force: .* inertia of its own: state armature"),
        ("armature = 2.0", "armature = 2.0\nF_fm = 3.0", r"F_fm: friction of a motor with inertia"),
        ("play = { free = [1e-4, 5e-4] }", "play = -1e-4", "play = -0.0001 must not be below 0"),
        ("armature = 2.0", "armature = 0.0", "armature = 0: the motor of an axis of two masses"),
        ("[sensor.load]", "[sensor.lead-error]\nerr_period = 0.1", "sensor.lead-error is of one"),
        ('side = "both"', 'side = "left"', "friction.side"),
        ('side = "both"', 'side = "load"\nmotor = "dahl"', "friction.motor: the motor's own law"),
        ("[transmission.compliant]", "[transmission.rigid]\n[transmission.compliant]",
         "an axis has one transmission, this one 2"),
        ('motor_position = "shaft"', 'motor_position = "rotor"',
         "reads both sides, and there is no column 'rotor'"),
        ("per_load = 628318.5307", 'per_load = "628318±10"', "per_load has no tolerance: give a"),
        ("per_load = 628318.5307", 'zero = { column = "shaft", value = 0.0 }',
         "zero: no column of a log: give a number"),
        ("[sensor.load]", "", "per_load: it scales a second position, and without .sensor.load."),
        ("per_load = 628318.5307\n[sensor.load]", "zero = 0.3", "zero: it is between two encoders"),
        ("[inputs]", '[inputs]\nlamp = "x"', "no input 'lamp': there are .*motor_position"),
    ],
)  # fmt: skip
def test_what_makes_no_axis_of_two_masses_is_refused(
    old: str, new: str, message: str, axis_file: Path, tmp_path: Path
) -> None:
    axis_file.write_text(AXIS.replace(old, new), encoding="utf-8")
    log = logged(tmp_path / "log.csv", SERVO | GAINS, 0)
    with pytest.raises(InputError, match=message) as refusal:
        identify(log, rig=str(axis_file), repeats=1, budget=50)
    assert "\n" not in str(refusal.value)


def test_a_head_with_a_unit_of_which_nobody_speaks_is_refused() -> None:
    """The motor's position is read as it is written, in proportion to `per_load`."""
    still = np.zeros(len(t))
    shown = {"q_m [mm]": 1e3 * FORCE}
    log = Recording(t=t, position=still, command=still, extra=shown)
    inputs = {"motor_position": "q_m [mm]"}
    silent, stated = (
        rig_of(SERVO | GAINS, sensor={"motor": motor, "load": {}}, inputs=inputs)
        for motor in ({}, {"per_load": 1000.0})
    )
    with pytest.raises(InputError, match=r"read as it is written: .* per_load = 1000, times"):
        rig_track(silent, log)
    _, motor = stated.readings(rig_track(stated, log), log, slice(0, len(t)))
    np.testing.assert_allclose(motor.measured, FORCE)


def rig_track(rig: TwoMassRig, log: Recording) -> Track:
    return rig.track(log, slice(0, len(t)), 0.0, np.ones(len(t)))


def test_a_position_of_the_motor_is_scaled_and_then_shifted() -> None:
    """What `rigs --parts` says of it is what a log is read by."""
    still = np.zeros(len(t))
    motor = {"per_load": 5.0, "zero": 0.01}
    rig = rig_of(SERVO | GAINS, sensor={"motor": motor, "load": {}})
    shown = 5.0 * (still + 0.01)
    log = Recording(t=t, position=still, command=still, extra={"motor_position": shown})
    reading = rig_track(rig, log).reading
    assert reading.ahead == pytest.approx(0.0, abs=1e-12)
    assert reading.zero == pytest.approx(0.01)
    (equation,) = (p.equation for p in rig.parts if (p.role, p.name) == ("sensor", "motor"))
    shows = equation.partition("=")[2].replace(" (", " * (").strip()
    assert eval(shows, {}, motor | {"q_m": 0.0}) == pytest.approx(shown[0])  # noqa: S307 - of a part


@pytest.mark.parametrize(
    ("extra", "message"),
    [
        ({"friction": {"side": "both"}}, "friction: an axis of one mass has one side"),
        ({"sensor": {"motor": {}}}, "sensor.motor: an axis of one mass has one side"),
    ],
)
def test_an_axis_of_one_mass_has_no_sides(extra: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        composed_axis({"load": {"mass": {"M": 1.0}}} | extra, "axis")


@pytest.mark.parametrize(("ratio", "rotary"), [(1.0, False), (50.0, False), (50.0, True)])
def test_what_is_said_to_make_one_mass_of_two_does(ratio: float, rotary: bool) -> None:
    table: dict[str, Any] = {
        "rotary": rotary,
        "law": "coulomb-viscous",
        "ranges": {"F_C": [0, 9], "F_C_motor": [0, 9]},
        "controller": {"damped": GAINS},
        "motor": {"force": {"armature": 2.0}},
        "transmission": {"compliant": {"stiffness": {"free": [1e4, 1e7]}, "gear_ratio": ratio}},
        "load": {"mass": {"M": 5.0}},
        "sensor": {"motor": {}, "load": {}},
        "friction": {"side": "both"},
        "inputs": {"motor_position": "shaft", "external": "push"},
    }
    rig = composed_axis(table, "axis")
    with pytest.raises(InputError, match="two masses, and a compensation is tried on") as refusal:
        around(rig, None)
    said = str(refusal.value)
    stated = re.search(r"\[transmission\.(\w+)\](?: with (\w+) = ([\d.]+))? for", said)
    assert stated is not None
    coefficients = {stated[2]: float(stated[3])} if stated[2] else {}
    table["transmission"] = {stated[1]: coefficients}
    _, _, leave = said.partition("leave out ")
    for side in re.findall(r"\[sensor\.(\w+)\]", leave):
        del table["sensor"][side]
    for word in re.findall(r"\[inputs\] (\w+)", leave):
        del table["inputs"][word]
    for name in re.findall(r"(\w+_motor)\b", leave.partition("ranges of ")[2]):
        del table["ranges"][name]
    if "[friction]" in leave:
        del table["friction"]
    one = composed_axis(table, "axis")
    assert not isinstance(one, TwoMassRig)
    values = {c.name: c.value for c in one.constants}
    assert one.coefficients(values)[0] == pytest.approx(5.0 + 2.0 * ratio**2)


@pytest.mark.parametrize("side", ["both", "load", "motor"])
@pytest.mark.parametrize("target", ["c", "st", "plcopen", "matlab", "modelica", "table"])
def test_files_of_a_law_say_whose_friction_it_is(target: str, side: str) -> None:
    rig = rig_of(SERVO, friction={"side": side})
    names = ("F_C", "F_V", "F_C_motor", "F_V_motor")[: 4 if side == "both" else 2]
    model = model_of(rig, "coulomb-viscous", {n: SERVO[n] for n in names}, (-0.1, 0.1))
    words = {"both": "the load's friction alone", "load": "the friction of the load",
             "motor": "the friction of the motor, as a force at the load"}  # fmt: skip
    exported = export(model, target)
    assert words[side] in exported.notes[0]
    files = [" ".join(content.decode().split()) for content in exported.files.values()]
    assert any(words[side].replace("'", mark) in text for text in files for mark in ("'", "&#x27;"))


def test_a_unit_does_not_call_itself_one_friction_alone() -> None:
    model = model_of(rig_of(SERVO), "coulomb-viscous", SERVO, (-0.1, 0.1))
    assert model.side
    assert model.side not in " ".join(model.head(whole=True))
    assert export(model, "json").notes == ()


@pytest.mark.parametrize("by_load", [0.0, 1.0])
def test_the_equations_that_are_shown_are_those_that_are_simulated(by_load: float) -> None:
    """Those of both masses, evaluated as they are written along their motion."""
    values = {
        "kp": 900.0, "kd": 40.0, "armature": 0.3, "M": 5.0, "offset": 3.0, "k_spring": 400.0,
        "q_spring": 0.01, "gear_ratio": 3.0, "stiffness": 6e3, "damping": 30.0, "cog_order": 8.0,
        "cog_cos": 1.0, "cog_sin": -2.0, "by_load": by_load,
    }  # fmt: skip
    tables: dict[str, dict[str, tuple[str, ...]]] = {
        "controller": {"damped": ("kp", "kd")},
        "motor": {"force": ("armature",)},
        "transmission": {"compliant": ("gear_ratio", "stiffness", "damping")},
        "load": {"mass": ("M", "offset"), "spring": ("k_spring", "q_spring"),
                 "motor-ripple": ("cog_order", "cog_cos", "cog_sin")},
        "sensor": {"motor": (), "load": ("by_load",)},
    }  # fmt: skip
    table: dict[str, Any] = {
        role: {name: {n: values[n] for n in names} for name, names in parts.items()}
        for role, parts in tables.items()
    }
    rig = composed_axis(table | {"tolerance": 1e-3}, "test")
    assert isinstance(rig, TwoMassRig)
    none = np.zeros((1, len(rig.parameters(LAW))))
    motor, load = rig.sides(LAW, none, started(rig, goal=GOAL))
    (q_m, v_m), (q, v) = ((side.position[0], side.velocity[0]) for side in (motor, load))
    T = values["stiffness"] * (q_m - q) + values["damping"] * (v_m - v)
    letters = values | {
        "q": q, "v": v, "q_m": q_m, "v_m": v_m, "T": T, "command": GOAL, "feed_forward": 0.0,
        "zero": 0.0, "F_f": 0.0, "F_f,m": 0.0,
    }  # fmt: skip
    lines = rig.equation(LAW).text.split(";  ")
    for inertial, speed in (("a", v), ("a_m", v_m)):
        differences = np.gradient(speed, t)
        expected = acceleration(lines, letters, inertial)
        off = np.abs(differences - expected)[5:-5]
        assert off.max() < 0.02 * np.ptp(differences)


def test_a_zero_that_gravity_moves_is_told() -> None:
    """Not where it is stated, nor where nothing pulls to one side."""
    log = Recording(t=t, position=np.zeros(len(t)), command=GOAL, rotary=True)
    for load, motor, told in (
        ({"pendulum": {"m": 1.0, "l": 0.2}}, {}, True),
        ({"pendulum": {"m": 1.0, "l": 0.2}}, {"zero": 0.0}, False),
        ({"mass": {"M": 1.0}}, {}, False),
    ):
        table = {
            "rotary": True, "controller": {"damped": {"kp": 1.0}}, "load": load,
            "motor": {"force": {"armature": 0.1}}, "transmission": {"compliant": {}},
            "sensor": {"motor": motor, "load": {}},
        }  # fmt: skip
        violations = data_violations(composed_axis(table, "axis"), [log], [None])
        assert any(v.caps and "state zero" in v.sentence for v in violations) == told
