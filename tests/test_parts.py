"""Axes of parts: against plain small steps, as files and as cards."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from command import Completed, caller
from foreign import parts as plain_steps
from stribeck import LAWS, InputError, Recording, identify
from stribeck.friction import law_named
from stribeck.identify.card import Card
from stribeck.identify.data_check import data_violations
from stribeck.rig.axis_draft import axis_draft
from stribeck.rig.axis_table import composed_axis
from stribeck.rig.composed import ComposedRig, settings
from stribeck.rig.log_reading import read_for
from stribeck.rig.lookup import rig_named
from stribeck.rig.parts import PARTS, Part, part_named
from stribeck.rig.simulated import as_simulated
from stribeck.rig.two_masses import SIDES, TwoMassRig
from stribeck.space import Array
from written_equation import acceleration

LAW = LAWS["coulomb-viscous"]


def rig_of(
    choice: dict[str, str], loads: list[str], values: dict[str, float], rotary: bool
) -> ComposedRig:
    """A rig of parts whose coefficients are all stated."""
    names = [*choice.items(), *(("load", n) for n in loads)]
    stated_parts = []
    for role, name in names:
        part = part_named(role, name)
        stated = [
            part[c.name].known(values[c.name], "the test") for c in part.coefficients
            if c.name in values
        ]  # fmt: skip
        stated_parts.append(part.with_coefficients(*stated))
    fine = {"step": 1.0, "tolerance": 1e-6}
    stepped = tuple(s.with_value(fine[s.name]) for s in settings("mrad" if rotary else "um"))
    return ComposedRig.compose(
        "test",
        stated_parts,
        rotary=rotary,
        doc="an axis",
        cite="this test",
        constants=stepped,
        laws=("coulomb-viscous",),
    )


t = np.arange(0.0, 1.5, 2e-3)
GOAL = 0.5 * np.sin(4.0 * t) + 0.1 * np.sin(19.0 * t)
AXES: dict[str, tuple[dict[str, str], list[str], dict[str, float], bool, dict[str, Any]]] = {
    "torque limit, pendulum, switched off": (
        {"controller": "damped", "motor": "force", "transmission": "rigid"}, ["pendulum"],
        {"kp": 10.0, "kd": 0.3, "gain_p": 0.9, "F_max": 2.0, "armature": 0.008, "m": 0.5, "l": 0.15,
         "m_arm": 0.078, "q_offset": 0.02, "F_C": 0.1, "F_V": 0.04}, True,
        {"goal": GOAL, "enabled": 1.0 * (t < 1.0)},
    ),
    "voltage, current limit, lossy gear": (
        {"controller": "pwm", "motor": "voltage", "transmission": "gear"}, ["inertia"],
        {"kp": 20.0, "vin": 24.0, "duty": 0.2, "k_t": 0.05, "R": 1.5, "I_max": 6.0,
         "armature": 2e-5, "gear_ratio": 20.0, "eta": 0.8, "eta_back": 0.7, "J": 0.05, "g_sin": 1.5,
         "g_cos": 0.4, "g_0": 0.1, "F_C": 0.3, "F_V": 0.2}, True,
        {"goal": GOAL, "feed_forward": 2.0 * np.cos(5.0 * t)},
    ),
    "current loop, screw, motor friction, spring": (
        {"controller": "pd", "motor": "current", "transmission": "screw"}, ["mass", "spring"],
        {"kp": 400.0, "kd": 8.0, "limit": 12.0, "k_t": 0.2, "armature": 3e-5, "lead": 0.01,
         "F_fm": 30.0, "M": 20.0, "offset": 15.0, "k_spring": 800.0, "q_spring": 0.05, "F_C": 40.0,
         "F_V": 200.0}, False,
        {"goal": 0.1 * GOAL, "goal_velocity": 0.1 * np.gradient(GOAL, t),
         "external": 25.0 * np.sin(11.0 * t)},
    ),
    "sampled cascade that integrates, a sample late": (
        {"controller": "cascade", "motor": "force", "transmission": "rigid"}, ["mass"],
        {"kp": 20.0, "kv": 300.0, "ki": 8.0, "T": 2e-3, "hold": 2.0, "limit": 150.0, "M": 5.0,
         "offset": 4.0, "F_C": 12.0, "F_V": 30.0}, False, {"goal": 0.1 * GOAL},
    ),
    "ripple of load and motor behind a gear": (
        {"controller": "pd", "motor": "force", "transmission": "gear"},
        ["inertia", "ripple", "motor-ripple"],
        {"kp": 2.0, "kd": 0.05, "gear_ratio": 30.0, "eta": 0.9, "eta_back": 0.8, "armature": 4e-5,
         "J": 0.05, "rip_period": 0.3, "rip_cos": 0.8, "rip_sin": -0.5, "rip_cos2": 0.3,
         "rip_sin2": 0.2, "cog_order": 2.0, "cog_cos": 0.02, "cog_sin": 0.03, "F_C": 0.4,
         "F_V": 0.2}, True,
        {"goal": GOAL, "goal_velocity": np.gradient(GOAL, t)},
    ),
    "uneven lead before a sampled loop at the motor": (
        {"controller": "damped", "motor": "force", "transmission": "screw", "sensor": "lead-error"},
        ["mass"],
        {"kp": 90.0, "kd": 1.5, "hold": 1.0, "lead": 0.02, "M": 6.0, "err_period": 0.02,
         "err_cos": 3e-4, "err_sin": 5e-4, "F_C": 12.0, "F_V": 30.0}, False, {"goal": 0.1 * GOAL},
    ),
    "recorded voltage": (
        {"controller": "none", "motor": "voltage", "transmission": "rigid"}, ["inertia"],
        {"k_t": 0.3, "R": 4.0, "armature": 1e-4, "J": 0.01, "F_C": 0.1, "F_V": 0.02}, True,
        {"added": 6.0 * np.sin(7.0 * t)},
    ),
}  # fmt: skip


def simulated(name: str) -> tuple[ComposedRig, Array]:
    """An axis of the table and its motion."""
    choice, loads, values, rotary, inputs = AXES[name]
    rig = rig_of(choice, loads, values, rotary)
    added = {"added": "voltage"}
    log = Recording(
        t=t, position=np.zeros(len(t)), command=inputs.get("goal"), rotary=rotary,
        voltage=inputs.get("added"),
        extra={
            {"goal_velocity": "command_velocity", "enabled": "torque_enable"}.get(n, n): x
            for n, x in inputs.items() if n not in ("goal", *added)
        },
    )  # fmt: skip
    p = np.array([[values[q.name] for q in rig.parameters(LAW)]])
    track = rig.track(log, slice(0, len(t)), 0.0, np.ones(len(t)))._replace(v0=0.0)
    return rig, rig.move(LAW, p, track).position[0]


@pytest.mark.parametrize("name", AXES)
def test_an_axis_of_parts_is_its_equations(name: str) -> None:
    """Plain steps come nearer and nearer to it, in proportion to their length."""
    choice, _, values, _, inputs = AXES[name]
    _, position = simulated(name)
    errors = []
    for sub in (25, 100, 400):
        known = plain_steps.simulate(values, t, inputs, choice["controller"], choice["motor"], sub)
        errors.append(float(np.abs(known - position).max()))
    assert np.ptp(position) > 0.02
    assert errors[2] <= 4e-4 * np.ptp(position)
    assert errors[2] < 0.5 * errors[1] < 0.25 * errors[0]


AXIS = """
law = "coulomb-viscous"
rotary = true
ranges = { F_C = [0, 1], F_V = [0, 1] }
[controller.damped]
kp = { column = "gain", value = 10.0 }
kd = 0.3
[motor.current]
k_t = "0.5±0.01"
I_max = 8.0
[load.pendulum]
m = 0.4
l = 0.2
[columns]
time = "t [s]"
position = "q [rad]"
command = "goal [rad]"
"""
#: F_C, F_V.
TRUTH = np.array([[0.12, 0.05]])


@pytest.fixture
def axis_file(tmp_path: Path) -> Path:
    path = tmp_path / "arm.toml"
    path.write_text(AXIS, encoding="utf-8")
    return path


@pytest.fixture
def axis_log(tmp_path: Path) -> Path:
    """A log of the axis by plain steps, whose own gain is another than the file's."""
    values = {"kp": 14.0, "kd": 0.3, "k_t": 0.5, "I_max": 8.0, "m": 0.4, "l": 0.2, "F_C": 0.12,
              "F_V": 0.05}  # fmt: skip
    goal = 0.8 * np.sin(3.0 * t)
    q = plain_steps.simulate(values, t, {"goal": goal}, "damped", "current", 100)
    q += 2e-5 * np.random.default_rng(0).standard_normal(len(t))
    path = tmp_path / "log.csv"
    head = "t [s],q [rad],goal [rad],gain"
    table = np.column_stack([t, q, goal, np.full(len(t), 14.0)])
    np.savetxt(path, table, delimiter=",", header=head, comments="")
    return path


def test_a_file_of_parts_is_identified_and_its_card_needs_no_file(
    axis_file: Path, axis_log: Path, tmp_path: Path
) -> None:
    fit = identify(axis_log, rig=str(axis_file), repeats=1, budget=600)
    values = {e.name: (e.low, e.value, e.high) for e in fit.estimates}
    for name, truth in zip(("F_C", "F_V"), TRUTH[0], strict=True):
        low, _, high = values[name]
        assert low <= truth <= high
        assert high - low < 0.3 * truth
    assert fit.card().model()[0].rig["kp"] == 14.0  # as the log states it, not the file
    path = fit.report(tmp_path / "report.html")
    page = Path(path).read_text(encoding="utf-8")
    assert "m l² a = F − m g l sin(q + q_offset) − F_f" in page
    axis_file.unlink()
    card = Card.model_validate(json.loads(fit.card().text()))
    assert card.kind == "composed"
    assert card.constants["k_t"].tolerance == pytest.approx(0.01)
    assert card.stated["kp"] == [14.0, 14.0]
    parameters, p = card.model()
    log = fit.recordings[0]
    again = as_simulated(parameters.rig).simulate(parameters.law, p[None], log)
    assert np.abs(again.position[0] - log.position).max() < 1e-4


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("[controller.damped]", "[controller.pid]", "no controller 'pid': there are pd, damped"),
        ("kd = 0.3", "ki = 0.3", r"controller.damped has no 'ki': it has kp, kd"),
        ("I_max = 8.0", "I_max = -8.0", "I_max = -8 must be above zero"),
        ("I_max = 8.0", "I_max = 8.0\narmature = -0.1", "armature = -0.1 must not be below 0"),
        ("m = 0.4", "m = -0.4", "m = -0.4 must not be below 0"),
        ("m = 0.4", 'm = "0.4 foo"', r"load\.pendulum\.m: '0.4 foo': unknown unit 'foo'"),
        (
            "[load.pendulum]",
            "[transmission.gear]\ngear_ratio = 5.0\neta = 1.2\n[load.pendulum]",
            "eta = 1.2 must not be above 1",
        ),
        (
            "[load.pendulum]",
            "[transmission.gear]\ngear_ratio = 5.0\neta = { free = [0.5, 2] }\n[load.pendulum]",
            r"gear.eta: free = \[0.5, 2\]: it must not be above 1",
        ),
        ("I_max = 8.0", "I_max = { free = [3, 2] }", r"motor.current.I_max: free = \[3, 2\]"),
        ("rotary = true", "rotary = false", "load.pendulum is of rotary axes, and this one is"),
        ("[load.pendulum]\nm = 0.4\nl = 0.2", "", "load: is missing"),
        ("kd = 0.3", "kd = [0.3]", r"controller.damped.kd: must be a finite number, text as"),
        ("kd = 0.3", "kd = nan", r"controller.damped.kd: must be a finite number"),
        ("kd = 0.3", "hold = { free = [0, 2] }", "controller.damped.hold is a choice: no log"),
        (
            "m = 0.4",
            "m = 0.4\nq_offset = { column = 'gain', value = 0.0 }",
            "column 'gain' is that of kp already",
        ),
        ("l = 0.2", "l = { free = [-1, 1] }", r"l: free = \[-1, 1\]: it must be above zero"),
        (
            "[columns]",
            "[shows]\nposition = 'kg'\n[columns]",
            "'kg' is not a unit of rad",
        ),
        ("[columns]", "[shows]\nspeed = 'rpm'\n[columns]", "shows.speed: there is position, .*F_C"),
        ("[columns]", "[shows]\nF_C = 'm'\n[columns]", "shows.F_C: 'm' is not a unit of N m"),
        ('law = "coulomb-viscous"', 'law = "glue"', "no law 'glue'"),
        ("l = 0.2", "l = -1", "load.pendulum.l = -1 must be above zero"),
        ("l = 0.2", 'l = "-0.2±0.1"', "load.pendulum.l = -0.2 must be above zero"),
        ("l = 0.2", 'l = { column = "l", value = -1.0 }', "l = -1 must be above zero"),
        ("l = 0.2", 'l = "0.2 kg"', "load.pendulum.l: '0.2 kg': it is in m"),
        (
            "l = 0.2",
            "l = { free = [1e-320, 1e-310] }",
            "load.pendulum.l: free = .* it must be above zero",
        ),
        ("kd = 0.3", "kd = 0.3\nhold = 7", r"damped.hold = 7 must be 0, 1 or 2 \(1: demand held"),
        ("kd = 0.3", 'kd = "0.3 N"', "damped.kd: '0.3 N': it is a number alone: demand per veloc"),
        (
            "[load.pendulum]",
            "[sensor.encoder]\nresolution = 1e-3\n[load.pendulum]",
            "resolution = 0.001: one that reads the steps of an encoder is sampled: .* hold = 1",
        ),
        ("[controller.damped]", "[controller.pwm]\nvin = 5\nduty = 1", "pwm.* no 'kd'"),
        ("[load.pendulum]\nm = 0.4\nl = 0.2", "[load.spring]", "nothing of it has an inertia"),
        (
            "[columns]",
            "[inputs]\nenabled = 'on'\nexternal = 'on'\n[columns]",
            "inputs.external: column 'on' is that of inputs.enabled already",
        ),
        (
            "[columns]",
            "[inputs]\nexternal = 'goal [rad]'\n[columns]",
            "inputs.external: column 'goal .rad.' is that of command already",
        ),
        (
            "l = 0.2",
            "l = { column = 'torque_enable', value = 1.0 }",
            "l: column 'torque_enable' is that of inputs.enabled already",
        ),
        ("l = 0.2", "l = { column = ' ', value = 1.0 }", "l: ' ' is no head of a column"),
        ("l = 0.2", 'l = "1e308 km"', "l: '1e308 km' is no finite number"),
        ("F_C = [0, 1]", "F_C = [0, 5e-324]", "F_C: range 0:4.94066e-324 cannot be searched"),
        ("l = 0.2", "l = { free = [1e-290, 1e290] }", "l: range 1e-290:1e.290 cannot be searched"),
        (
            "[columns]",
            "[inputs]\ngoal_velocity = 'v'\n[columns]",
            "inputs.goal_velocity: nothing of this axis reads it",
        ),
        (
            "[columns]",
            "[inputs]\nlamp = 'x'\n[columns]",
            "no input 'lamp': there are feed_forward",
        ),
        ("F_C = [0, 1]", "F_X = [0, 1]", "ranges: no law has a parameter 'F_X'"),
        ("law =", "kind_ =", "kind_: a rig file has no such word"),
    ],
)
def test_files_that_make_no_axis_are_refused(
    old: str, new: str, message: str, axis_file: Path, axis_log: Path
) -> None:
    axis_file.write_text(AXIS.replace(old, new), encoding="utf-8")
    with pytest.raises(InputError, match=message) as refusal:
        identify(axis_log, rig=str(axis_file), repeats=1, budget=50)
    assert "\n" not in str(refusal.value)


@pytest.fixture
def stribeck(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Callable[..., Completed]:
    return caller(monkeypatch, capsys)


def test_a_new_file_holds_what_it_says(stribeck: Callable[..., Completed], tmp_path: Path) -> None:
    path = tmp_path / "axis.toml"
    options = ("--new", str(path), "--rotary", "--controller", "pd", "--motor", "voltage",
               "--transmission", "gear", "--load", "pendulum", "--load", "spring")  # fmt: skip
    assert stribeck("rigs", *options).status == 0
    shown = stribeck("rigs", str(path))
    assert shown.status == 0
    for words in (
        "F_m = n k_t clip",
        "m l² a = F − m g l sin(q + q_offset) − k_spring (q − q_spring) − F_f",
        "k_spring (q",
        "parameters with",
    ):
        assert words in shown.out
    free = {q.name for q in rig_named(str(path)).params}
    assert free == {"kp", "k_t", "R", "m", "l", "k_spring"}
    again = stribeck("rigs", *options)
    assert again.status == 2
    assert "is there already" in again.err
    lacking = stribeck("rigs", "--new", str(tmp_path / "other.toml"), "--linear")
    assert lacking.status == 2
    assert "needs --controller: there are pd, damped, cascade" in lacking.err
    assert not (tmp_path / "other.toml").exists()


@pytest.mark.parametrize("rotary", [False, True])
def test_every_part_stands_in_a_draft_that_is_read(rotary: bool) -> None:
    chosen = {role: [p for p in PARTS.values() if p.role == role and p.rotary in (None, rotary)]
              for role in ("controller", "motor", "transmission", "load")}  # fmt: skip
    for role, parts in chosen.items():
        for part in parts:
            axis = [part if role == other else named[0] for other, named in chosen.items()]
            if part.drive == "voltage":
                axis[1] = part_named("motor", "voltage")
            if role == "load" and not part.inertia:
                axis.append(part_named("load", "mass"))
            table = tomllib.loads(axis_draft(axis, rotary=rotary))
            rig = composed_axis(table, "axis")
            assert {c.name for c in part.coefficients if c.idle is None} <= {
                q.name for q in rig.params
            }


def test_a_range_in_an_axis_file_is_kept_to() -> None:
    t = np.arange(0.0, 3.0, 4e-3)
    goal = 0.8 * np.sin(1.5 * t) + 0.3 * np.sin(4.1 * t)
    values = {"kp": 4.0, "kd": 0.1, "armature": 0.05, "F_C": 0.4, "F_V": 0.2}
    q = plain_steps.simulate(values, t, {"goal": goal}, "damped", "force", 100)
    q += 2e-5 * np.random.default_rng(0).standard_normal(len(t))
    table = """
        law = "coulomb-viscous"
        rotary = true
        ranges = { F_C = [0, 2], F_V = [0, 1] }
        controller.damped = { kp = 4.0, kd = 0.1 }
        motor.force.armature = 0.0
        load.inertia.J = { free = [0.08, 0.2] }
    """
    rig = composed_axis(tomllib.loads(table), "axis")
    fit = identify(Recording(t=t, position=q, command=goal, rotary=True), rig=rig, delay=0.0)
    J = next(e for e in fit.estimates if e.name == "J")
    assert J.value == pytest.approx(0.08, rel=1e-6)
    assert J.verdict != "identified"
    assert not any("widened" in note for note in fit.notes)


#: Dimensions of what the parts of an axis say: of its motor where that turns, and of all of it.
_UNITS: list[tuple[str, dict[str, str]]] = [
    (
        """
        rotary = true
        controller.damped.kp = 40.0
        motor.force = { armature = 0.02, F_max = 30.0 }
        transmission.compliant = { stiffness = "1e4±5%", damping = 2.0, play = 1e-3 }
        load.pendulum = { m = { free = [0.1, 5] }, l = { free = [0.1, 1] } }
        load.spring = { k_spring = { free = [1, 9] }, q_spring = 0.1 }
        """,
        {"armature": "kg m**2", "F_max": "N m", "stiffness": "N m/rad", "damping": "N m s/rad",
         "play": "rad", "m": "kg", "l": "m", "k_spring": "N m/rad", "q_spring": "rad",
         "F_C": "N m", "F_C_motor": "N m", "F_V_motor": "N m s/rad"},
    ),
    (
        """
        controller.damped.kp = 40.0
        motor.current = { armature = 2e-4, k_t = { free = [0.1, 1] }, F_fm = 3.0 }
        transmission.screw.lead = 0.01
        load.mass = { M = { column = "mass", value = 5.0 }, offset = 1.0 }
        load.motor-ripple = { cog_order = 7.0, cog_sin = 0.1, cog_cos = { free = [-1, 1] } }
        """,
        {"armature": "kg m**2", "k_t": "N m/A", "F_fm": "N", "lead": "m", "M": "kg", "offset": "N",
         "cog_sin": "N m", "cog_cos": "N m", "F_C": "N"},
    ),
    (
        """
        controller.damped.kp = 40.0
        motor.force = { armature = 2.0, F_max = 30.0 }
        load.mass = { M = { free = [1, 9] }, offset = 1.0 }
        """,
        {"armature": "kg", "F_max": "N", "M": "kg", "offset": "N", "F_V": "N s/m"},
    ),
]  # fmt: skip


@pytest.mark.parametrize(("text", "units"), _UNITS)
def test_a_quantity_has_the_unit_of_its_axis(text: str, units: dict[str, str]) -> None:
    table = tomllib.loads(text) | {"law": "coulomb-viscous"}
    if "compliant" in text:
        table["friction"] = {"side": "both"}
    rig = composed_axis(table, "axis")
    shown = {c.name: c.unit for c in rig.constants}
    shown |= {q.name: rig.unit_of(q) for q in rig.parameters(LAWS["coulomb-viscous"])}
    assert {name: shown[name] for name in units} == units
    values = {c.name: c.value for c in rig.constants}
    assert values["armature"] == table["motor"].popitem()[1]["armature"]


def test_a_controller_without_it_does_not_take_the_velocity_of_the_command() -> None:
    """A damped one brakes by the velocity of the axis alone, whatever columns its log has."""
    goal = 0.1 * GOAL
    table = {"controller": {"damped": {"kp": 2e3, "kd": 300.0}}, "load": {"mass": {"M": 5.0}}}
    rig = as_simulated(composed_axis(table | {"law": "coulomb-viscous"}, "axis"))
    still, p = np.zeros(len(t)), np.array([[20.0, 30.0]])
    plain, said = (
        rig.simulate(LAW, p, Recording(t=t, position=still, command=goal, extra=extra)).position
        for extra in ({}, {"command_velocity": np.gradient(goal, t)})
    )
    assert np.ptp(plain) > 0.01
    np.testing.assert_array_equal(plain, said)


@pytest.mark.parametrize("sensors", [(), ("motor",), ("motor", "load")])
def test_a_draft_of_two_masses_says_what_they_need(sensors: tuple[str, ...]) -> None:
    """The rotor's inertia; and nothing of a second encoder where there is one, or of a zero."""
    names = [("controller", "damped"), ("motor", "force"), ("transmission", "compliant"),
             ("load", "mass"), *(("sensor", name) for name in sensors)]  # fmt: skip
    text = axis_draft([part_named(*name) for name in names], rotary=False)
    rig = composed_axis(tomllib.loads(text), "axis")
    armature = next(q for q in rig.params if q.name == "armature")
    assert armature.lower > 0.0
    assert ("# per_load" in text) == (len(sensors) == 2)
    assert "# zero = 0" not in text
    named = [f"[sensor.{side}]" for side in ("motor", "load")]
    assert all(text.count(head) == 1 for head in named[: max(len(sensors), 1)])


def test_a_setting_that_nobody_states_is_not_called_given() -> None:
    table = {"motor": {"force": {"armature": 1.0}}, "load": {"mass": {"M": 1.0}}, "law": "dahl"}
    for law, more in (("dahl", {}), ("coulomb-viscous", {"tolerance": 0.5}), ("stribeck", {})):
        rig = composed_axis(
            table | {"transmission": {"compliant": {"stiffness": 1e4}}, "law": law} | more, "axis"
        )
        (tolerance,) = (c for c in rig.constants if c.name == "tolerance")
        assert (tolerance.source == "given") == bool(more)


@pytest.mark.parametrize("name", [n for n, a in AXES.items() if a[0]["controller"] != "cascade"])
def test_the_equation_that_a_rig_shows_is_the_one_that_is_simulated(name: str) -> None:
    """Evaluated as it is written, along a motion that has nothing to do with it."""
    choice, loads, stated, rotary, inputs = AXES[name]
    values = {n: x for n, x in stated.items() if n != "hold"}
    rig = rig_of(choice, loads, values, rotary)
    q, v, a = 0.02 * np.sin(9.0 * t), 3.0 * np.cos(5.0 * t), 60.0 + 40.0 * np.sin(7.0 * t)
    log = Recording(
        t=t, position=q, command=inputs.get("goal"), rotary=rotary, voltage=inputs.get("added"),
        extra={"command_velocity": inputs["goal_velocity"]} if "goal_velocity" in inputs else {},
    )  # fmt: skip
    track = rig.track(log, slice(0, len(t)), 0.0, np.ones(len(t)))
    p = np.array([[0.0 if q.name in ("F_C", "F_V") else values[q.name]
                   for q in rig.parameters(LAW)]])  # fmt: skip
    free = rig.imbalance(LAW, p, track, (q, v, np.zeros(len(t))))
    held = rig.imbalance(LAW, p, track, (q, v, a))
    assert free is not None
    assert held is not None
    letters = values | {
        "command": inputs.get("goal", 0.0), "feed_forward": 0.0, "demand": inputs.get("added"),
        "command_velocity": inputs.get("goal_velocity", 0.0), "q": q, "v": v, "F_f": 0.0,
    }  # fmt: skip
    text = rig.equation(LAW).text.split(";  ")
    if choice["controller"] != "none":
        del letters["demand"]
    np.testing.assert_allclose(
        acceleration(text, letters), (free * a / (free - held))[0], rtol=1e-6, atol=1e-9
    )


def test_a_servo_that_sets_a_voltage_drives_a_motor_that_takes_one() -> None:
    table: dict[str, Any] = {
        "controller": {"pwm": {}},
        "motor": {"current": {}},
        "load": {"mass": {}},
    }
    with pytest.raises(InputError, match=r"pwm sets a voltage, and motor\.current takes"):
        composed_axis(table, "axis")


def test_a_value_of_an_axis_file_may_have_its_unit() -> None:
    table: dict[str, Any] = {
        "load": {"mass": {"M": "2500 g ± 10 %"}},
        "motor": {"force": {"F_max": "0.2 kN"}},
    }
    rig = composed_axis(table, "axis")
    stated = {c.name: c for c in rig.constants}
    assert stated["M"].value == pytest.approx(2.5)
    assert stated["M"].tolerance == pytest.approx(0.25)
    assert stated["F_max"].value == pytest.approx(200.0)


def _stated(part: Part, changed: str = "") -> dict[str, float]:
    """A value of each coefficient of a part that is not its idle one; another of one of them."""
    values = {}
    for c in part.coefficients:
        value = 1.0 if c.choices else 0.8 * (c.idle if c.idle and 0 < c.idle < np.inf else 1.0)
        other = next((choice for choice in reversed(c.choices) if choice != value), 0.9 * value)
        values[c.name] = other if c.name == changed else value
    return values


@pytest.mark.parametrize("masses", [1, 2])
@pytest.mark.parametrize("key", PARTS, ids=".".join)
def test_no_coefficient_of_a_part_is_idle(key: tuple[str, str], masses: int) -> None:
    """Another value makes another axis, whatever else it is made of."""
    role, name = key
    part, two = PARTS[key], masses > 1
    of_two = name in ("compliant", *(SIDES if role == "sensor" else ()))
    if (two and (role == "transmission" or name == "lead-error") and not of_two) or (
        of_two and (not two or key == ("sensor", "motor"))  # how that reads is tested apart
    ):
        return
    rotary = bool(part.rotary)
    axis: dict[str, dict[str, dict[str, float]]] = {
        "controller": {"pd": {"hold": 1.0}}, "motor": {"current": {}},
        "transmission": {"compliant" if two else "gear" if rotary else "screw": {}},
        "load": {"mass": {}}, "sensor": {"motor": {}, "load": {}} if two else {},
    }  # fmt: skip
    if role in ("controller", "motor", "transmission") or part.inertia:
        axis[role] = {}
    if part.drive == "voltage":
        axis["motor"] = {"voltage": {}}

    def row(changed: str = "") -> list[Any]:
        values = _stated(part, changed)
        if two:
            values.pop("F_fm", None)
            axis["motor"] = {n: v | {"armature": 0.8} for n, v in axis["motor"].items()}
        axis[role] = axis[role] | {name: values}
        rig = composed_axis(axis | {"rotary": rotary}, "axis")
        numbers = dict.fromkeys((q.name for q in rig.parameters(LAW)), 0.5)
        numbers |= {c.name: c.value for c in rig.constants}
        read = rig.coupled_coefficients if isinstance(rig, TwoMassRig) else rig.coefficients
        return [x for x in read(numbers) if isinstance(x, float)]

    for c in part.coefficients:
        if not (two and c.name == "F_fm"):
            assert row(c.name) != row(), c.name


def _log_with(axis_log: Path, head: str, values: Array) -> Path:
    """The log of the axis with another column in place of its gain's."""
    table = np.loadtxt(axis_log, delimiter=",", skiprows=1)
    table[:, 3] = values
    heads = f"t [s],q [rad],goal [rad],{head}"
    np.savetxt(axis_log, table, delimiter=",", header=heads, comments="")
    return axis_log


def test_a_column_that_states_a_constant_is_read_in_its_unit(
    axis_file: Path, axis_log: Path
) -> None:
    text = axis_file.read_text(encoding="utf-8").replace('column = "gain", value = 10.0', "")
    text = text.replace("kp = {  }", "kp = 14.0")
    text = text.replace("m = 0.4", 'm = { column = "weight [g]", value = 1.0 }')
    axis_file.write_text(text, encoding="utf-8")
    rig = as_simulated(rig_named(str(axis_file)))
    log = Recording(t=t, position=np.zeros(len(t)), extra={"weight [g]": np.full(len(t), 400.0)})
    assert rig.stated(log) == {"m": pytest.approx(0.4)}
    axis_file.write_text(text.replace("weight [g]", "weight [mm]"), encoding="utf-8")
    with pytest.raises(InputError, match=r"weight \[mm\] is in mm, and what is read from it in kg"):
        identify(_log_with(axis_log, "weight [mm]", np.full(len(t), 400.0)), rig=str(axis_file))


def test_an_input_is_read_in_its_unit() -> None:
    table: dict[str, Any] = {"controller": {"pd": {"kp": 1.0}}, "load": {"inertia": {"J": 1.0}}}
    table |= {"rotary": True, "inputs": {"goal_velocity": "qd [deg/s]", "external": "push_mNm"}}
    rig = composed_axis(table, "axis")
    still, ones = np.zeros(len(t)), np.ones(len(t))
    extra = {"qd [deg/s]": 180.0 * ones, "push_mNm": 500.0 * ones}
    log = Recording(t=t, position=still, command=still, rotary=True, extra=extra)
    np.testing.assert_allclose(rig.inputs(log)["goal_velocity"], np.pi)
    np.testing.assert_allclose(rig.inputs(log)["external"], 0.5)


def test_a_constant_that_changes_and_a_column_that_is_absent_are_told(
    axis_file: Path, axis_log: Path, tmp_path: Path, stribeck: Callable[..., Completed]
) -> None:
    """A gain that rises by a fifth takes "identified" away; one that is the file's does not."""
    text = axis_file.read_text(encoding="utf-8")
    axis_file.write_text(text.replace("value = 10.0", "value = 14.0"), encoding="utf-8")
    absent = identify(_log_with(axis_log, "other", np.full(len(t), 1.0)), rig=str(axis_file))
    told = [w for w in absent.warnings if "lacks columns that the axis file names" in w]
    assert "kp ('gain') is 14" in told[0]
    assert {e.verdict for e in absent.estimates} == {"identified"}
    card = absent.card().write(tmp_path / "card.json")
    for arguments in (
        ("check", f"{axis_log}", "--rig", f"{axis_file}"),
        ("validate", f"{card}", f"{axis_log}"),
        ("simulate", f"{card}", f"{axis_log}", "--out", f"{tmp_path / 'motion.csv'}"),
    ):
        done = stribeck(*arguments)
        assert done.status == 0, done.err
        assert f"warning: {told[0]}" in done.err, arguments
    rising = identify(_log_with(axis_log, "gain", np.linspace(12.6, 15.4, len(t))),
                      rig=str(axis_file))  # fmt: skip
    told = [w for w in rising.warnings if "states kp goes from 12.6 to 15.4" in w]
    assert "its median, 14, counts" in told[0]
    assert not {e.verdict for e in rising.estimates} & {"identified"}


def test_values_have_the_units_of_their_axis() -> None:
    """Of a rotary one, and of a motor that turns before a screw."""
    turns: dict[str, Any] = {
        "rotary": True, "load": {"mass": {"M": "200 g cm**2"}},
        "transmission": {"gear": {"gear_ratio": 3.0}}, "motor": {"force": {"F_max": "3 N m"}},
    }  # fmt: skip
    rig = composed_axis(turns, "axis")
    assert rig["M"] == pytest.approx(2e-5)
    with pytest.raises(InputError, match=r"load\.mass\.M: '0.6 kg': it is in kg m"):
        composed_axis(turns | {"load": {"mass": {"M": "0.6 kg"}}}, "axis")
    screw: dict[str, Any] = {
        "load": {"mass": {"M": "2 kg"}}, "transmission": {"screw": {"lead": "5 mm"}},
        "motor": {"force": {"armature": "200 g cm**2"}},
    }  # fmt: skip
    assert composed_axis(screw, "axis")["armature"] == pytest.approx(2e-5)


def test_a_column_that_an_axis_names_is_no_channel(tmp_path: Path) -> None:
    """Though its head is that of one: it would be the velocity, and no goal of it."""
    (tmp_path / "axis.toml").write_text(
        'inputs = { goal_velocity = "qd [mm/s]" }\n[controller.pd]\nkp = 900\nkd = 60\n'
        "[load.mass]\nM = 5\n[columns]\ntime = 't [s]'\nposition = 'q [m]'\ncommand = 'goal [m]'\n",
        encoding="utf-8",
    )
    table = np.column_stack([t, 0.1 * np.sin(t), 0.1 * np.sin(t), np.full(len(t), 7.0)])
    np.savetxt(tmp_path / "log.csv", table, delimiter=",", header="t [s],q [m],goal [m],qd [mm/s]",
               comments="")  # fmt: skip
    rig = as_simulated(rig_named(str(tmp_path / "axis.toml")))
    log = read_for(rig, tmp_path / "log.csv", None)
    assert log.velocity is None
    assert isinstance(rig, ComposedRig)
    np.testing.assert_allclose(rig.inputs(log)["goal_velocity"], 7e-3)


def test_what_is_recorded_takes_no_feed_forward() -> None:
    table: dict[str, Any] = {"motor": {"current": {"k_t": 1.0}}, "load": {"mass": {"M": 1.0}}}
    with pytest.raises(InputError, match=r"inputs.feed_forward: .* it takes a controller"):
        composed_axis(table | {"inputs": {"feed_forward": "ff"}}, "axis")
    still, ones = np.zeros(len(t)), np.ones(len(t))
    log = Recording(t=t, position=still, current=ones, extra={"feed_forward": ones})
    assert "feed_forward" not in composed_axis(table, "axis").inputs(log)


def test_a_controller_with_another_clock_than_its_log_is_told() -> None:
    table: dict[str, Any] = {"load": {"mass": {"M": 1.0}}}
    loop = {"kp": 20.0, "kv": 300.0, "ki": 8.0}
    log = Recording(t=t, position=np.zeros(len(t)), command=np.sin(t))
    cases: tuple[tuple[dict[str, float], bool], ...]
    cases = (({}, True), ({"T": 4e-3}, True), ({"T": 2e-3}, False), ({"ki": 0.0}, False))
    for stated, told in cases:
        rig = composed_axis(table | {"controller": {"cascade": loop | stated}}, "axis")
        sentences = [v.sentence for v in data_violations(rig, [log], [None]) if v.caps]
        assert any("the controller computes every" in s for s in sentences) == told


def test_a_value_that_a_log_overrules_is_told(axis_file: Path) -> None:
    rig = rig_named(str(axis_file)).set(kp=20.0)
    log = Recording(t=t, position=np.zeros(len(t)), extra={"gain": np.full(len(t), 14.0)})
    (sentence,) = [
        v.sentence for v in data_violations(rig, [log], [None]) if "kp is set" in v.sentence
    ]
    assert "kp is set to 20, and logs state it in a column of theirs (14), which counts" in sentence


def test_no_coefficient_is_called_as_a_parameter_of_a_law() -> None:
    """A geared axis under a law that has a ratio of its own has two quantities, and two names."""
    names = [*LAWS, "maxwell-slip:2", "gms:2", "gms-damped:2", "curve:4"]
    params = {q.name for name in names for q in law_named(name).params}
    assert not params & {c.name for part in PARTS.values() for c in part.coefficients}


@pytest.mark.parametrize("law", ["coulomb-viscous", "coulomb-viscous-directional"])
@pytest.mark.parametrize("seed", range(2))
def test_a_small_axis_needs_no_ranges(axis_file: Path, axis_log: Path, law: str, seed: int) -> None:
    """A range of 0 to 1000 N m is friction, nearly all of it, under which it never moves."""
    text = axis_file.read_text(encoding="utf-8")
    axis_file.write_text(text.replace("ranges = { F_C = [0, 1], F_V = [0, 1] }", ""), "utf-8")
    fit = identify(axis_log, rig=str(axis_file), law=law, seed=seed)
    assert fit.score.value < 1e-3 * fit.score.still
    for e in fit.estimates:
        truth = TRUTH[0][0 if e.name.startswith("F_C") else 1]
        assert e.value == pytest.approx(truth, rel=0.01)
    assert not [w for w in fit.warnings if "than the search" in w]


def test_a_cascade_is_sampled_where_nobody_says_so() -> None:
    """Its demand is held in a search, too, which may leave samples out where none is."""
    loop = {"kp": 20.0, "kv": 300.0, "ki": 8.0}
    table: dict[str, Any] = {"controller": {"cascade": loop}, "load": {"mass": {"M": 5.0}}}
    log = Recording(t=t, position=np.zeros(len(t)), command=0.1 * np.sin(4.0 * t))
    held, silent = (
        as_simulated(composed_axis(table | {"controller": {"cascade": loop | more}}, "axis"))
        for more in ({"hold": 1.0}, {})
    )
    track = silent.track(log, slice(0, len(t)), 0.0, np.ones(len(t)))
    assert held.thinned([track]) is None
    assert silent.thinned([track]) is None
    p = np.array([[12.0, 30.0]])
    resting = [rig.resting(track, float(track.t[100]), 0.01) for rig in (held, silent)]
    pulls = [
        rig.pull(LAW, p, np.array([instant]))
        for rig, instant in zip((held, silent), resting, strict=True)
    ]
    assert resting[0] is not None
    np.testing.assert_array_equal(resting[0], resting[1])
    np.testing.assert_array_equal(pulls[0], pulls[1])
