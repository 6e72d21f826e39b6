"""The co-simulation unit: valid, reproducible, and with the motion of the rigs."""

from __future__ import annotations

import stat
from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from fmpy.fmi2 import FMU2Slave
from fmpy.validation import validate_fmu

from exported import VARIANTS, model_of
from fmu_unit import (
    Unit,
    compiled_without_a_warning,
    difference,
    fmpy,
    moved,
    needs_compiler,
    ramp,
    rig_of,
    run_by_master,
    unpacked,
)
from joint_models import model_of as model_with
from patience import PATIENCE
from stribeck import LAWS, RIGS, read
from stribeck.errors import InputError
from stribeck.export.fmu.axis import axis
from stribeck.export.fmu.build import fmu
from stribeck.export.fmu.description import exponents
from stribeck.export.model import Model
from stribeck.friction import law_named
from stribeck.friction.law import NORMAL
from stribeck.rig.motion.axis_row import rows
from stribeck.rig.motion.drives import AXIS, IDLE, SLIDE, AxisInputs
from stribeck.rig.motion.implicit import motions
from stribeck.rig.motion.track import Track
from stribeck.rig.parts import part_named
from stribeck.rig.parts.axis_of_parts import assembled
from stribeck.rig.slide_bed import SLIDE_BED, SlideBed, published_both, with_inputs
from stribeck.space import Array

pytestmark = needs_compiler
DATA = Path(__file__).parents[2] / "shared" / "data"
real = pytest.mark.recordings


@pytest.fixture(autouse=True)
def patient(monkeypatch: pytest.MonkeyPatch) -> None:
    """A compiler may take long on a loaded machine."""
    monkeypatch.setattr("stribeck.export.fmu.build._PATIENCE", PATIENCE)


#: Units that have been built, by the card's hash.
BUILT: dict[str, bytes] = {}


@pytest.fixture
def opened(tmp_path: Path) -> Callable[[Model], Unit]:
    def unit_of(model: Model) -> Unit:
        path = tmp_path / f"{len(list(tmp_path.iterdir()))}.fmu"
        if model.sha256 not in BUILT:
            BUILT[model.sha256] = fmu(model)
        path.write_bytes(BUILT[model.sha256])
        folder = fmpy.extract(str(path), str(path.with_suffix("")))
        return Unit(folder, fmpy.read_model_description(str(path)))

    return unit_of


# The archive.

MODELS = [
    *((law, None) for law in (*LAWS, *VARIANTS)),
    *(("stribeck", rig) for rig in RIGS),
    ("lugre", "joint"), ("dahl", "presliding"), ("gms", "servo-pendulum"),
    ("stribeck-directional", "emps"), ("coulomb-viscous+temperature", "forced-pendulum"),
]  # fmt: skip


def model_on(law: str, rig: str | None) -> Model:
    """A model of a law on a rig, its parameters from the middle of their ranges."""
    if rig is None:
        return model_of(law)
    kind = RIGS[rig]
    rng = np.random.default_rng(3)
    values = {}
    for q in kind.parameters(law_named(law)):
        share = float(rng.uniform(0.3, 0.6))
        values[q.name] = q.lower + share * (q.upper - q.lower) if q.fixed is None else q.fixed
    for name in values:
        if name.startswith("F_S"):
            values[name] += values[name.replace("F_S", "F_C")]
    return model_with(rig, law, values, (-1.0, 1.0))


@pytest.mark.parametrize(("law", "rig"), MODELS)
def test_every_law_and_rig_makes_a_valid_unit(law: str, rig: str | None, tmp_path: Path) -> None:
    # Whether it compiles is seen below for each drive, and in test_export_c for each law.
    path = tmp_path / "axis.fmu"
    path.write_bytes(fmu(model_on(law, rig), "axis", binary=False))
    assert validate_fmu(str(path)) == []


def test_the_same_model_is_the_same_bytes_and_another_has_another_guid() -> None:
    model = model_of("lugre")
    assert fmu(model) == fmu(model)
    guids = {
        ET.fromstring(unpacked(fmu(m, n, binary=False))["modelDescription.xml"]).get("guid")  # noqa: S314
        for m, n in ((model, "friction"), (model, "axis"), (model_of("lugre", 2), "friction"))
    }
    assert len(guids) == 3


def test_what_goes_with_it() -> None:
    model = model_of("stribeck")
    files = unpacked(fmu(model, "axis", binary=False))
    assert model.head()[0] in files["documentation/index.html"].decode()
    assert b"BSD" in files["documentation/licenses/license.txt"]
    assert files["resources/card.json"].decode() == model.card.text()
    assert not [name for name in files if name.startswith("binaries/")]


def test_parameters_carry_unit_range_interval_and_verdict() -> None:
    model = model_of("stribeck")
    bounded = model.card.parameters["F_C"].model_copy(update={"low": 60.0, "high": 65.5})
    parameters = {**model.card.parameters, "F_C": bounded}
    model = Model(model.card.model_copy(update={"parameters": parameters}), model.parameters,
                  model.values, "", "card.json")  # fmt: skip
    root = ET.fromstring(unpacked(fmu(model, binary=False))["modelDescription.xml"])  # noqa: S314
    variables = {v.get("name"): v for v in root.iter("ScalarVariable")}
    level = variables["F_C"]
    assert level.get("variability") == "tunable"
    assert level.get("description") == (
        "Coulomb friction; 95 % interval 60 to 65.5; identified"
    )  # fmt: skip
    number = level[0].attrib
    assert (number["unit"], float(number["min"]), float(number["max"])) == ("N", 40.0, 80.0)
    assert float(number["start"]) == model.p[1]
    assert variables["k_hat_pos"][0].attrib == {"unit": "N/m", "start": "3500.0"}


@pytest.mark.parametrize(
    ("written", "powers"),
    [
        ("N m s/rad", {"kg": 1, "m": 2, "s": -1, "rad": -1}),
        ("V", {"kg": 1, "m": 2, "s": -3, "A": -1}),
        ("ohm", {"kg": 1, "m": 2, "s": -3, "A": -2}),
        ("N m/A", {"kg": 1, "m": 2, "s": -2, "A": -1}),
        ("1/m**2", {"m": -2}),
        ("1/K", {"K": -1}),
        ("Pa", {"kg": 1, "m": -1, "s": -2}),
    ],
)
def test_units_are_powers_of_what_fmi_knows(written: str, powers: dict[str, int]) -> None:
    assert exponents(written) == powers


@pytest.mark.parametrize(
    ("law", "rig"),
    [("lugre", "slide-bed"), ("stribeck", "slide-bed"), ("bam-m4", "servo-pendulum"),
     ("stribeck", "joint"), ("gms", "presliding"), ("coulomb-load", "cylinder"),
     ("stribeck-directional", "forced-pendulum")],
)  # fmt: skip
def test_its_sources_compile_without_a_warning(law: str, rig: str, tmp_path: Path) -> None:
    compiled_without_a_warning(model_on(law, rig), tmp_path)


# The motion.


@pytest.mark.parametrize(
    ("law", "most"),
    [
        # A unit steps as the stepper of all rigs does. What sticks and slips goes from event to
        # event in the rig: how far the two are apart is decided by when a slip begins.
        ("stribeck-directional", 1e-4),
        ("coulomb-viscous", 1e-6),
        ("stribeck-smooth", 1e-9),
        ("lugre", 1e-9),
        ("gms", 1e-9),
        ("stribeck+temperature", 1e-9),
        ("lugre+position", 1e-7),
    ],
)
def test_a_slide_follows_the_ramp_of_the_test_bed(
    opened: Callable[[Model], Unit], law: str, most: float
) -> None:
    p = published_both()
    names = [q.name for q in SLIDE_BED.parameters(LAWS["stribeck-directional"])]
    model = (
        model_with("slide-bed", law, dict(zip(names, p, strict=True)), (-1.0, 1.0))
        if law == "stribeck-directional"
        else model_of(law)
    )
    segment, rig = ramp(300.0), rig_of(model)
    if model.law.static and model.law.sticks:
        expected = rig.states(model.law, model.values[None], segment)[0]
    else:
        assert isinstance(rig, SlideBed)
        laws, c = rig.split(model.law, model.values[None])
        inputs = with_inputs(segment)
        expected = motions(model.law, SLIDE, laws, c, inputs, rig["step"], rig["tolerance"])[0]
    motion = moved(opened(model), model, segment)
    assert difference(motion[0], expected[0]) <= most


@real
@pytest.mark.parametrize("law", ["coulomb-viscous", "stribeck", "bam-m4", "bam-m6+temperature"])
def test_a_servo_follows_a_recorded_goal(opened: Callable[[Model], Unit], law: str) -> None:
    model = model_with("servo-pendulum", law, SERVO, (-5.0, 5.0))
    log = read(min((DATA / "bam_xl330" / "logs").glob("*.json")), columns=dict(model.rig.columns))
    n = len(log)
    segment = rig_of(model).track(log, slice(0, n), float(log.position[0]), np.ones(n))
    segment.inputs[1] = 300.0
    expected = rig_of(model).move(model.law, model.values[None], segment)
    of_the_run = dict(zip(("m", "l", "kp", "vin"), segment.given, strict=True))
    motion = moved(opened(model), model, segment, **of_the_run)
    assert np.ptp(expected.position) > 0.3
    assert difference(motion[0], expected.position[0]) <= 1e-9
    assert difference(motion[2], expected.force[0]) <= 1e-9


#: A small servo with a pendulum, SI.
SERVO = {
    "k_t": 0.41, "R": 8.6, "armature": 2e-3, "q_offset": 0.01, "F_S": 0.05, "F_C": 0.02,
    "F_V": 0.01, "v_SS": 1.0, "exponent": 1.0, "K_c": 0.012, "K_v": 0.01, "K_cs": 0.02, "w_s": 1.5,
    "alpha": 1.2, "K_l": 0.1, "K_ls": 0.15, "K_m": 0.1, "K_e": 0.15, "K_ms": 0.05, "K_es": 0.1,
    "K_mq": 0.05, "K_eq": 0.1, "temp_slope": -0.01, "temp_ref": 293.15,
}  # fmt: skip


def forced(
    model: Model, t: Array, load: str, constants: dict[str, float], hold: bool = False,
    **inputs: Array,
) -> Array:  # fmt: skip
    """Positions of an axis under inputs, as `implicit` has them, with the unit's own steps."""
    settings = {v.name: v.start for v in axis(model).of("setting")}
    row = assembled((part_named("motor", "force"), part_named("load", load)), constants)
    table = np.array(AxisInputs(**{n: x + 0 * t for n, x in {**IDLE._asdict(), **inputs}.items()}))
    segment = Track(t, t, t, 0.1, t, t, np.empty((3, 0)), inputs=table,
                    held=np.full(len(table), float(hold)))  # fmt: skip
    q, _, _ = motions(
        model.law, AXIS, model.p[None], rows(row, 1), segment, settings["step"] or 0.0,
        settings["tolerance"] or 0.0,
    )  # fmt: skip
    position: Array = q[0]
    return position


@real
@pytest.mark.parametrize("law", ["coulomb-viscous", "stribeck", "coulomb-viscous-directional"])
def test_emps_follows_its_recorded_force(opened: Callable[[Model], Unit], law: str) -> None:
    model, t, force = emps(law)
    offset = 0.0 if model.law.directional else -3.1648
    expected = forced(model, t, "mass", {"M": 95.1089, "offset": offset}, added=force)
    unit = opened(model)
    unit.begin(position_start=0.1, force=force[0])
    motion = unit.walk(t, {"force": force})
    assert difference(motion[0], expected) <= 1e-9
    np.testing.assert_allclose(motion[2], force, rtol=1e-12)


def emps(law: str) -> tuple[Model, Array, Array]:
    import scipy.io  # noqa: PLC0415 - only where there are logs

    raw = scipy.io.loadmat(DATA / "emps" / "DATA_EMPS.mat")
    t, voltage = (np.ascontiguousarray(raw[n].ravel(), dtype=float) for n in ("t", "vir"))
    values = {
        "F_C": 20.3935, "F_V": 203.5034, "F_S": 25.0, "v_SS": 0.005, "exponent": 1.0,
        "F_C+": 18.0, "F_C-": 22.0, "F_V+": 200.0, "F_V-": 205.0, "M": 95.1089, "offset": -3.1648,
    }  # fmt: skip
    return model_with("emps", law, values, (-0.15, 0.15)), t, float(raw["gtau"][0, 0]) * voltage


@real
def test_fmpy_simulates_a_recorded_force(tmp_path: Path) -> None:
    # FMPy sets inputs at communication points, between which the unit holds them.
    model, logged, recorded = emps("stribeck")
    t = np.arange(5000) / 1000.0
    force = np.interp(t, logged - logged[0], recorded)
    (tmp_path / "axis.fmu").write_bytes(fmu(model))
    inputs = np.array(list(zip(t, force, strict=True)), dtype=[("time", float), ("force", float)])
    motion = fmpy.simulate_fmu(
        str(tmp_path / "axis.fmu"), stop_time=t[-1], output_interval=1e-3, input=inputs,
        start_values={"position_start": 0.1}, output=["position"],
    )  # fmt: skip
    expected = forced(model, t, "mass", {"M": 95.1089, "offset": -3.1648}, hold=True, added=force)
    assert difference(np.interp(t, motion["time"], motion["position"]), expected) <= 1e-6


def test_bristles_under_a_force_are_the_rigs(opened: Callable[[Model], Unit]) -> None:
    values = {"sigma_0": 1e5, "sigma_1": 300.0, "F_S": 20.0, "F_C": 12.0, "v_s": 0.01,
              "F_V": 40.0, "M": 5.0, "offset": 0.5}  # fmt: skip
    model = model_with("presliding", "lugre", values, (-0.1, 0.1))
    t = np.arange(0.0, 4.0, 2e-3)
    force = 14.0 * np.sin(2.0 * t) + 10.0 * np.sin(7.3 * t)
    segment = Track(t, t, t, 0.0, t, t, np.empty((3, 0)), held=np.zeros(3),
                    inputs=np.array([0.0 * t, 0.0 * t, force]))  # fmt: skip
    expected = rig_of(model).move(model.law, model.values[None], segment)
    motion = moved(opened(model), model, segment)
    assert difference(motion[0], expected.position[0]) <= 1e-9
    assert difference(motion[1], expected.velocity[0]) <= 1e-9


@pytest.mark.parametrize("hold", [0.0, 1.0, 2.0])
@pytest.mark.parametrize("law", ["stribeck", "lugre"])
def test_a_joint_is_the_rigs_with_a_torque_that_follows_or_is_held(
    opened: Callable[[Model], Unit], law: str, hold: float
) -> None:
    values = {"J": 0.3, "g_sin": 2.0, "g_cos": 0.7, "g_0": 0.1, "F_S": 0.9, "F_C": 0.6,
              "F_V": 0.2, "v_SS": 0.05, "v_s": 0.05, "exponent": 1.0, "sigma_0": 2e3,
              "sigma_1": 5.0}  # fmt: skip
    model = model_with("joint", law, values, (-1.0, 1.0))
    rig = rig_of(model).set(hold=hold, limit=20.0, kp=60.0)
    t = np.arange(0.0, 3.0, 4e-3)
    command = 0.5 * np.sin(2.0 * t)
    nothing = np.zeros(len(t))
    steps = 0.3 * np.sign(np.sin(t))
    inputs = np.array([nothing, nothing, nothing, command, np.gradient(command, t), steps])
    segment = Track(t, t, t, 0.05, t, t, np.empty((3, 0)), v0=0.2, inputs=inputs, held=np.zeros(6))
    expected = rig.move(model.law, model.values[None], segment)
    motion = moved(opened(model), model, segment, hold=hold, limit=20.0, kp=60.0)
    assert difference(motion[0], expected.position[0]) <= 1e-9
    if hold == 0.0:
        assert difference(motion[2], expected.force[0]) <= 1e-9


def test_a_pendulum_under_a_torque_is_a_joint_without_a_controller(
    opened: Callable[[Model], Unit],
) -> None:
    values = {"F_C": 0.05, "F_V": 0.02, "M": 0.06, "offset": 0.03, "g_sin": 1.2, "g_cos": 0.2}
    model = model_with("forced-pendulum", "coulomb-viscous", values, (-5.0, 5.0))
    t = np.arange(0.0, 5.0, 5e-3)
    torque = 0.8 * np.sin(3.0 * t)
    joint = {"J": 0.06, "g_sin": 1.2, "g_cos": 0.2, "g_0": 0.03}
    expected = forced(model, t, "inertia", joint, feed_forward=torque)
    unit = opened(model)
    unit.begin(position_start=0.1)
    motion = unit.walk(t, {"force": torque})
    assert difference(motion[0], expected) <= 1e-9


def test_a_cylinder_is_pressed_and_rubs_by_its_pressure(opened: Callable[[Model], Unit]) -> None:
    values = {"F_C": 20.0, "F_V": 300.0, "mu": 2e-4, "M": 8.0, "offset": 3.0, "b": 1e-5}
    model = model_with("cylinder", "coulomb-load", values, (-1.0, 1.0))
    t = np.arange(0.0, 5.0, 5e-3)
    pressure = 2e5 * (1.0 + 0.5 * np.sin(t))
    area = np.pi / 4 * 0.025**2 + 1e-5
    force = pressure * area + 150.0 * np.sin(4.0 * t)
    expected = forced(
        model, t, "mass", {"M": 8.0, "offset": 3.0}, normal=pressure, added=force - pressure * area
    )
    unit = opened(model)
    unit.begin(position_start=0.1, force=force[0], pressure=pressure[0])
    motion = unit.walk(t, {"force": force, "pressure": pressure})
    assert NORMAL == 2
    assert difference(motion[0], expected) <= 1e-9


# What a master may do with it.


def pushed(unit: Unit, forces: Array, h: float = 1e-3) -> Array:
    """Position, velocity and friction after steps of h under forces."""
    motion = np.empty((len(forces), 3))
    for k, force in enumerate(forces):
        unit.set(force=force)
        unit.slave.doStep(k * h, h)
        motion[k] = unit.get("position", "velocity", "friction")
    return motion


def bristled() -> Model:
    values = {"sigma_0": 1e5, "sigma_1": 300.0, "F_S": 20.0, "F_C": 12.0, "v_s": 0.01,
              "F_V": 40.0, "M": 5.0, "offset": 0.0}  # fmt: skip
    return model_with("presliding", "lugre", values, (-0.1, 0.1))


FORCES = 25.0 * np.sin(0.02 * np.arange(400))


@pytest.mark.parametrize("by", ["handle", "bytes"])
def test_a_state_brings_back_the_motion(opened: Callable[[Model], Unit], by: str) -> None:
    unit = opened(bristled())
    unit.begin()
    pushed(unit, FORCES)
    state = unit.slave.getFMUstate()
    data = unit.slave.serializeFMUState(state) if by == "bytes" else b""
    first = pushed(unit, FORCES)
    if by == "bytes":
        unit.slave.freeFMUState(state)
        state = unit.slave.deSerializeFMUstate(data)
    unit.slave.setFMUState(state)
    assert np.array_equal(pushed(unit, FORCES), first)
    unit.slave.freeFMUState(state)
    assert not np.array_equal(pushed(unit, FORCES), first)


def test_two_axes_of_one_unit_are_two(opened: Callable[[Model], Unit]) -> None:
    model = bristled()
    alone, first, second = opened(model), opened(model), opened(model)
    for unit in (alone, first, second):
        unit.begin()
    pushed(second, -FORCES)
    assert np.array_equal(pushed(first, FORCES), pushed(alone, FORCES))


def test_a_reset_axis_starts_anew(opened: Callable[[Model], Unit]) -> None:
    unit = opened(bristled())
    unit.begin()
    first = pushed(unit, FORCES)
    unit.slave.reset()
    unit.begin()
    assert np.array_equal(pushed(unit, FORCES), first)


def test_the_communication_step_does_not_decide_the_motion(
    opened: Callable[[Model], Unit],
) -> None:
    t = np.arange(0.0, 2.0, 1e-3)
    force = 25.0 * np.sin(4.0 * t)
    positions = []
    for stride in (1, 10, 40):
        unit = opened(bristled())
        unit.begin(step=1e-4)
        coarse_force = np.interp(t, t[::40], force[::40])  # linear in the longest step
        positions.append(
            unit.walk(t[::stride], {"force": coarse_force[::stride]})[0, :: 40 // stride]
        )
    assert difference(positions[1], positions[0]) <= 1e-5
    assert difference(positions[2], positions[0]) <= 1e-5


def test_friction_holds_an_axis_with_what_pulls_at_it(opened: Callable[[Model], Unit]) -> None:
    values = {"F_C": 12.5, "F_V": 40.0, "M": 10.0, "offset": 1.5}
    unit = opened(model_with("forced", "coulomb-viscous", values, (-0.5, 0.5)))
    unit.begin()
    motion = pushed(unit, np.array([5.0, -4.0, 13.9]))
    np.testing.assert_allclose(motion[:, 2], [3.5, -5.5, 12.4], rtol=1e-12)
    assert not motion[:, :2].any()
    moving = pushed(unit, np.full(3, 30.0))[-1]
    assert moving[1] > 0.0
    assert moving[2] == pytest.approx(12.5 + 40.0 * moving[1], rel=1e-12)


def test_a_tuned_parameter_is_that_of_another_model(opened: Callable[[Model], Unit]) -> None:
    values = {"F_C": 12.5, "F_V": 40.0, "M": 10.0, "offset": 0.0}
    tuned, built = (
        opened(model_with("forced", "coulomb-viscous", v, (-0.5, 0.5)))
        for v in (values, {**values, "F_C": 9.0, "M": 7.0})
    )
    tuned.begin()
    built.begin()
    tuned.set(F_C=9.0, M=7.0)  # while it runs
    assert np.array_equal(pushed(tuned, FORCES), pushed(built, FORCES))


def refused(call: Callable[..., object], *arguments: object, **named: float) -> None:
    with pytest.raises(fmpy.fmi1.FMICallException, match="error"):
        call(*arguments, **named)


def test_what_cannot_be_is_an_error_and_no_crash(opened: Callable[[Model], Unit]) -> None:
    unit = opened(bristled())
    refused(unit.slave.doStep, 0.0, 1e-3)  # before the start
    refused(unit.slave.setReal, [0], [1.0])  # an output
    refused(unit.slave.getReal, [999])
    refused(unit.slave.getInteger, [0])
    unit.begin()
    refused(unit.set, step=1e-4)  # fixed
    refused(unit.slave.doStep, 0.0, -1e-3)
    refused(unit.slave.setRealInputDerivatives, [unit.references["M"]], [1], [0.0])
    refused(unit.slave.setRealInputDerivatives, [unit.references["force"]], [2], [0.0])
    unit.set(M=float("nan"))
    refused(unit.slave.doStep, 0.0, 1e-3)


def test_what_is_held_has_no_slope(opened: Callable[[Model], Unit]) -> None:
    unit = opened(model_of("lugre"))
    unit.begin(added_force=3.0)
    unit.slope(added_force=1e6)
    unit.slave.doStep(0.0, 0.1)
    assert unit.get("added_force")[0] == 3.0


@pytest.mark.parametrize("case", ["slide, lugre", "slide, stribeck", "servo", "joint", "force"])
def test_no_byte_is_lost_or_touched_that_is_another_s(case: str, tmp_path: Path) -> None:
    model = {
        "slide, lugre": lambda: model_on("lugre", "slide-bed"),
        "slide, stribeck": lambda: model_on("stribeck", "slide-bed"),
        "servo": lambda: model_on("bam-m4", "servo-pendulum"),
        "joint": lambda: model_on("gms", "joint"),
        "force": bristled,
    }[case]()
    run_by_master(model, tmp_path)


def test_a_unit_of_another_guid_is_not_instantiated(opened: Callable[[Model], Unit]) -> None:
    unit = opened(bristled())
    renamed = FMU2Slave(
        guid="{0}", unzipDirectory=unit.slave.unzipDirectory, instanceName="axis",
        modelIdentifier="friction",
    )  # fmt: skip
    with pytest.raises(Exception, match="Failed to instantiate"):
        renamed.instantiate()


# Where it cannot be made.


@pytest.mark.parametrize("name", ["", "1st", "a b", "x" * 42, "a/b", "f\n"])
def test_a_name_that_c_does_not_take_is_refused(name: str) -> None:
    with pytest.raises(InputError, match="letters, digits and _") as error:
        fmu(model_of("stribeck"), name)
    assert "\n" not in str(error.value)


def test_without_a_compiler_there_is_one_line(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(InputError, match="there is no C compiler") as error:
        fmu(model_of("stribeck"))
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("says", ["cc: out of memory\nmore", ""])
def test_a_compiler_that_fails_is_told_in_one_line_and_leaves_nothing(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, says: str
) -> None:
    broken = tmp_path / "bin" / "cc"
    broken.parent.mkdir()
    broken.write_text(f"#!/bin/sh\necho '{says}' >&2\nexit 1\n")
    broken.chmod(broken.stat().st_mode | stat.S_IXUSR)
    folder = tmp_path / "left"
    folder.mkdir()
    monkeypatch.setenv("PATH", str(broken.parent))
    monkeypatch.setattr("tempfile.tempdir", str(folder))
    with pytest.raises(InputError, match=says.partition("\n")[0] or "it said nothing") as error:
        fmu(model_of("stribeck"))
    assert "\n" not in str(error.value)
    assert not list(folder.iterdir())
