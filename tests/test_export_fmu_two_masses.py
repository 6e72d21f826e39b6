"""The co-simulation unit of an axis of two masses: the motion of its rig, and of plain steps."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import pytest
from fmpy.validation import validate_fmu

from counted_units import GCOV, Built
from fmu_unit import (
    Unit,
    compiled_without_a_warning,
    difference,
    fmpy,
    needs_compiler,
    run_by_master,
    unpacked,
)
from foreign import two_masses as plain_steps
from foreign import two_masses_mixed as plain_mixed
from foreign.presliding import LuGre
from foreign.two_masses_bristles import Axis
from joint_models import model_of
from patience import PATIENCE
from stribeck import export
from stribeck.data.recording import Recording
from stribeck.export.fmu import build
from stribeck.export.fmu.build import fmu
from stribeck.export.model import Model
from stribeck.rig.custom import rig_file
from stribeck.rig.two_masses import TwoMassRig
from stribeck.space import Array
from two_mass_axes import GAINS, SERVO, rig_of

pytestmark = needs_compiler
FILE = Path(__file__).parents[1] / "docs" / "rigs" / "two_masses.toml"
OUTPUTS = ("position", "velocity", "motor_position", "motor_velocity")


def rounded(series: Array) -> Array:
    """To binary places that leave room for slopes: a unit's inputs are then those of the rig."""
    return np.round(series * 2.0**32) / 2.0**32


#: Knots of all inputs, s: between them they are straight.
KNOTS = np.arange(0.0, 1.5, 2.0**-6)
GOAL = rounded(np.minimum(KNOTS, 1.0) * (0.01 * np.sin(9 * KNOTS) + 0.004 * np.sin(20 * KNOTS)))
FORCE = rounded(90.0 * np.sin(8.0 * KNOTS) + 30.0 * np.sin(20.0 * KNOTS))
#: Communication steps, s.
SHORT, LONG = 2.0**-9, 2.0**-6
AXIS = {name: x for name, x in SERVO.items() if not name.startswith("F_")}
LUGRE = {"sigma_0": 1e6, "sigma_1": 300.0, "F_S": 30.0, "F_C": 20.0, "v_s": 5e-3, "F_V": 30.0}
STATIC = {"F_C_motor": 10.0, "F_V_motor": 20.0}
STRIBECK = {"F_S": 60.0, "F_C": 20.0, "F_V": 30.0, "v_SS": 5e-3, "exponent": 2.0}
MAXWELL = {"W_1": 6.0, "W_2": 4.0, "d_1": 3e-6, "r_2": 5.0, "F_V": 20.0}


def of_motor(values: Mapping[str, float]) -> dict[str, float]:
    """A law's parameters as those of the motor's."""
    return {f"{name}_motor": x for name, x in values.items()}


def by_motor() -> tuple[TwoMassRig, str, dict[str, float], dict[str, Array]]:
    """A position controller that follows a velocity, too, with an encoder on the motor."""
    rig = rig_of(AXIS, "stribeck", sensor={"motor": {}}, friction={"side": "load"},
                 controller={"pd": {"kp": 2e4, "kd": 300.0}})  # fmt: skip
    rate = rounded(np.gradient(GOAL, KNOTS))
    return rig, "stribeck", STRIBECK, {"goal": GOAL, "command_velocity": rate}


#: A rig, its law, parameters, SI, and what drives it, by the columns of a log.
CASES: dict[
    str, Callable[[], tuple[TwoMassRig, str, dict[str, float], dict[str, Array]]]
] = {
    "file": lambda: (as_two_masses(rig_file(FILE)), "coulomb-viscous", SERVO | GAINS,
                     {"goal": GOAL}),
    "motor encoder": by_motor,
    "lugre and static": lambda: (
        rig_of(AXIS | GAINS, "lugre", friction={"side": "both", "motor": "coulomb-viscous"}),
        "lugre", LUGRE | STATIC, {"goal": GOAL},
    ),
    "static and maxwell-slip": lambda: (
        rig_of(AXIS | GAINS, friction={"side": "both", "motor": "maxwell-slip:2"}),
        "coulomb-viscous", {"F_C": 20.0, "F_V": 30.0, **of_motor(MAXWELL)}, {"goal": GOAL},
    ),
    "motor's friction, lossy, no play": lambda: (
        rig_of(AXIS | GAINS | {"eta": 0.8, "eta_back": 0.6, "play": 0.0, "offset": 15.0},
               friction={"side": "motor"}),
        "coulomb-viscous", {"F_C": 10.0, "F_V": 20.0}, {"goal": GOAL},
    ),
    "held by a lossy coupling": lambda: (
        rig_of(AXIS | {"eta": 0.6, "eta_back": 0.4}, "lugre",
               friction={"side": "both", "motor": "coulomb-viscous"}),
        "lugre", LUGRE | STATIC, {"force": FORCE},
    ),
    "sampled, by the load's encoder": lambda: (
        rig_of(AXIS, sensor={"motor": {}, "load": {"by_load": 1}},
               controller={"cascade": {"kp": 20.0, "kv": 300.0, "ki": 8.0, "hold": 2.0,
                                       "difference": 1.0, "limit": 150.0}}),
        "coulomb-viscous", {"F_C": 20.0, "F_V": 30.0, **STATIC}, {"goal": GOAL},
    ),
    "started in the play, pressed": lambda: (
        rig_of(AXIS | GAINS | {"start": -0.5}, "bam-m4",
               friction={"side": "both", "motor": "stribeck"}),
        "bam-m4",
        {"F_S": 12.0, "F_C": 8.0, "F_V": 10.0, "v_SS": 5e-3, "exponent": 1.0, "K_c": 0.1,
         "K_v": 0.1, "K_cs": 0.2, "w_s": 0.4, "alpha": 1.2, "K_l": 0.1, "K_ls": 0.1,
         **of_motor(STRIBECK)},
        {"goal": GOAL},
    ),
}  # fmt: skip


def as_two_masses(rig: object) -> TwoMassRig:
    assert isinstance(rig, TwoMassRig)
    return rig


@pytest.fixture(autouse=True)
def patient(monkeypatch: pytest.MonkeyPatch) -> None:
    """A compiler may take long on a loaded machine."""
    monkeypatch.setattr("stribeck.export.fmu.build._PATIENCE", PATIENCE)


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


def case(name: str) -> tuple[TwoMassRig, Model, dict[str, Array]]:
    """A rig, its model, and what drives it at the knots."""
    rig, law, values, inputs = CASES[name]()
    return rig, model_of(rig, law, values), inputs


def sampled(inputs: Mapping[str, Array], h: float) -> tuple[Array, dict[str, Array]]:
    """Instants h seconds apart, and the inputs there."""
    t = np.arange(0.0, KNOTS[-1] + 0.5 * h, h)
    return t, {name: np.interp(t, KNOTS, x) for name, x in inputs.items()}


def simulated(
    rig: TwoMassRig, model: Model, t: Array, inputs: Mapping[str, Array], v0: float = 0.0
) -> Array:
    """Position and velocity of the load, then of the motor, as the rig has them, (4, N)."""
    log = Recording(t=t, position=np.zeros(len(t)), command=inputs.get("goal"),
                    force=inputs.get("force"),
                    extra={n: x for n, x in inputs.items() if n == "command_velocity"})  # fmt: skip
    track = rig.track(log, slice(0, len(t)), 0.0, np.ones(len(t)))._replace(v0=v0)
    motor, load = rig.sides(model.law, model.values[None], track)
    sides = (load.position, load.velocity, motor.position, motor.velocity)
    return np.array([x[0] for x in sides])


def walked(unit: Unit, t: Array, inputs: Mapping[str, Array], **values: float) -> Array:
    """The same of a unit."""
    series = {"command" if n == "goal" else n: x for n, x in inputs.items()}
    unit.begin(**{n: x[0] for n, x in series.items()}, **values)
    return unit.walk(t, series, OUTPUTS)


# The motion.


@pytest.mark.parametrize(("h", "v0"), [(SHORT, 0.0), (LONG, 0.0), (SHORT, 0.02)])
@pytest.mark.parametrize("name", CASES)
def test_a_unit_moves_as_its_rig(
    opened: Callable[[Model], Unit], name: str, h: float, v0: float
) -> None:
    """Both masses, in communication steps of the samples of a log: the same bits, as a rule."""
    rig, model, inputs = case(name)
    t, series = sampled(inputs, h)
    expected = simulated(rig, model, t, series, v0)
    motion = walked(opened(model), t, series, position_start=expected[0, 0], velocity_start=v0)
    assert np.ptp(expected[0]) > 5e-4
    for ours, known in zip(motion, expected, strict=True):
        assert difference(ours, known) <= 1e-12


@pytest.mark.parametrize("name", [n for n in CASES if not n.startswith("sampled")])
def test_the_communication_step_does_not_decide_the_motion(
    opened: Callable[[Model], Unit], name: str
) -> None:
    """Whole motions in steps of two lengths, beside the way by which one step may be off, 1 nm."""
    _, model, inputs = case(name)
    ends = []
    for h in (SHORT, LONG):
        t, series = sampled(inputs, h)
        ends.append(walked(opened(model), t, series)[:, :: round(LONG / h)])
    short, long = ends
    assert np.abs(long - short)[[0, 2]].max() <= 2e-7


@pytest.mark.parametrize("stated", [False, True])
def test_a_unit_reads_the_zero_of_the_motor_s_encoder(
    opened: Callable[[Model], Unit], stated: bool
) -> None:
    """Of a log whose encoders have different zeros: the unit follows it as its rig does."""
    zero, ahead = 2.0**-8, 2e-5  # the zero of the rig is a fifth of half the play less
    motor = {"per_load": 5.0} | ({"zero": zero} if stated else {})
    rig = rig_of(AXIS | GAINS, sensor={"motor": motor, "load": {}})
    values = {"F_C": 20.0, "F_V": 30.0, **STATIC}
    model = model_of(rig, "coulomb-viscous", values)
    t, series = sampled({"goal": GOAL + zero}, SHORT)
    shown = np.full(len(t), 5.0 * (zero + ahead))
    log = Recording(t=t, position=np.zeros(len(t)), command=series["goal"],
                    extra={"motor_position": shown})  # fmt: skip
    track = rig.track(log, slice(0, len(t)), 0.0, np.ones(len(t)))._replace(v0=0.0)
    _, load = rig.sides(model.law, model.values[None], track)
    told = {"start": 0.2} if stated else {"zero": zero + ahead}
    motion = walked(opened(model), t, series, **told)
    assert difference(motion[0], load.position[0]) <= 1e-9
    if stated:  # the log may lack the motor's position
        motion = walked(opened(model), t, series)
        assert difference(motion[0], simulated(rig, model, t, series)[0]) <= 1e-9


def test_what_acts_at_the_start_alone_is_fixed_then(tmp_path: Path) -> None:
    _, model, _ = case("started in the play, pressed")
    path = tmp_path / "axis.fmu"
    path.write_bytes(fmu(model, binary=False))
    variables = {v.name: v for v in fmpy.read_model_description(str(path)).modelVariables}
    assert variables["start"].variability == "fixed"
    assert variables["play"].variability == "tunable"


def test_a_unit_says_whose_position_it_shows() -> None:
    text = described(case("motor encoder")[1])
    assert 'name="position" valueReference="0" description="position of the load"' in text
    assert "what the encoder shows, and the rig calls its position" in text
    both = rig_of(AXIS | GAINS, sensor={"motor": {"per_load": 5.0}, "load": {}})
    text = described(model_of(both, "coulomb-viscous", {"F_C": 20.0, "F_V": 30.0, **STATIC}))
    assert "its encoder shows 5 (motor_position + zero)" in text


PLAIN = {"armature": "M_m"}


def test_plain_steps_come_to_the_unit_of_the_file(opened: Callable[[Model], Unit]) -> None:
    """In proportion to their length; they share nothing with the package."""
    _, model, inputs = case("file")
    t, series = sampled(inputs, SHORT)
    motion = walked(opened(model), t, series)[[2, 0]]
    values = {PLAIN.get(n, n): x for n, x in (SERVO | GAINS).items()}
    errors = [
        np.abs(np.array(plain_steps.simulate(values, t, sub, goal=series["goal"])) - motion).max()
        for sub in (100, 800, 3200)
    ]
    way = np.ptp(motion[0] - motion[1])
    assert way > 1e-4
    assert errors[2] < 5e-3 * way
    assert errors[2] < 0.4 * errors[1] < 0.1 * errors[0]


def test_plain_steps_come_to_the_unit_of_a_bristle_and_a_level(
    opened: Callable[[Model], Unit],
) -> None:
    """LuGre on the load, Coulomb friction on the motor."""
    _, model, inputs = case("lugre and static")
    t, series = sampled(inputs, SHORT)
    motion = walked(opened(model), t, series, tolerance=1e-11)[[2, 0]]
    axis = Axis(**{PLAIN.get(n, n): x for n, x in (AXIS | GAINS).items()})
    errors = [
        np.abs(
            plain_mixed.simulate(axis, 10.0, 20.0, LuGre(**LUGRE), t, sub, series["goal"]) - motion
        ).max()
        for sub in (400, 1600, 6400)
    ]
    way = np.ptp(motion[0] - motion[1])
    assert way > 1e-4
    assert errors[2] < 5e-3 * way
    assert errors[2] < 0.4 * errors[1] < 0.2 * errors[0]


def test_the_outputs_are_the_forces_of_the_equations(opened: Callable[[Model], Unit]) -> None:
    """M_m a_m = drive - coupling - friction_motor, M a = coupling - friction: in short steps."""
    _, model, inputs = case("file")
    unit, h = opened(model), 1e-7
    unit.begin()
    names = ("motor_velocity", "velocity", "drive", "coupling", "friction_motor", "friction")
    checked = 0
    for k in range(200):
        unit.set(command=float(np.interp(k * 5e-3, KNOTS, inputs["goal"])))
        unit.slave.doStep(k * 5e-3, 5e-3 - h)
        before = unit.get(*names)
        unit.slave.doStep(k * 5e-3 + 5e-3 - h, h)
        a_m, a = (unit.get(*names) - before)[:2] / h
        v_m, v, drive, coupling, motor, load = before
        largest = max(abs(drive), abs(coupling), 10.0)
        if v_m * v != 0.0:
            checked += 1
            assert abs(2.0 * a_m - (drive - coupling - motor)) < 1e-3 * largest
            assert abs(5.0 * a - (coupling - load)) < 1e-3 * largest
    assert checked > 60


def test_friction_holds_each_side_with_what_pulls_at_it(opened: Callable[[Model], Unit]) -> None:
    rig = rig_of(SERVO)
    unit = opened(model_of(rig, "coulomb-viscous", SERVO))
    unit.begin()
    for force in (4.0, -7.0):
        unit.set(force=force)
        unit.slave.doStep(0.0, 1e-3)
        values = unit.get("friction_motor", "friction", "coupling", "drive", *OUTPUTS)
        np.testing.assert_allclose(values, [force, 0.0, 0.0, force, 0.0, 0.0, 0.0, 0.0])
    unit.set(force=22.0)  # beyond the motor's level, and short of that of both
    for k in range(400):
        unit.slave.doStep(k * 2e-3, 2e-3)
    values = unit.get("friction_motor", "friction", "coupling", "motor_velocity", "velocity")
    assert values[3] == values[4] == 0.0
    assert 0.0 < values[1] <= 20.0
    np.testing.assert_allclose(values[:2], [22.0 - values[2], values[2]], rtol=1e-9)


RUBS = ("friction", "friction_motor")


def test_frictions_are_told_of_the_sides_that_have_one() -> None:
    rubbed = {
        name: [
            v for v in ("friction", "friction_motor") if f'name="{v}"' in described(case(name)[1])
        ]
        for name in ("file", "motor encoder", "motor's friction, lossy, no play")
    }
    assert rubbed == {
        "file": ["friction", "friction_motor"],
        "motor encoder": ["friction"],
        "motor's friction, lossy, no play": ["friction_motor"],
    }


def described(model: Model) -> str:
    return unpacked(fmu(model, binary=False))["modelDescription.xml"].decode()


# What a master may do with it.


def pushed(unit: Unit, name: str, inputs: Array) -> Array:
    """Outputs after steps of 2 ms under values of an input."""
    motion = np.empty((len(inputs), 6))
    for k, value in enumerate(inputs):
        unit.set(**{name: float(value)})
        unit.slave.doStep(k * 2e-3, 2e-3)
        motion[k] = unit.get(*OUTPUTS, "coupling", "drive")
    return motion


def driver(inputs: Mapping[str, Array]) -> tuple[str, Array]:
    """The name and 200 values of what drives a unit."""
    t = 2e-3 * np.arange(200)
    ((name, series),) = inputs.items()
    return ("command" if name == "goal" else name), np.interp(t, KNOTS, series)


@pytest.mark.parametrize("by", ["handle", "bytes"])
@pytest.mark.parametrize("name", ["file", "lugre and static", "held by a lossy coupling",
                                  "sampled, by the load's encoder"])  # fmt: skip
def test_a_state_brings_back_the_motion(
    opened: Callable[[Model], Unit], name: str, by: str
) -> None:
    _, model, inputs = case(name)
    unit, (drives, series) = opened(model), driver(inputs)
    unit.begin()
    pushed(unit, drives, series)
    state = unit.slave.getFMUstate()
    data = unit.slave.serializeFMUState(state) if by == "bytes" else b""
    first = pushed(unit, drives, -series)
    if by == "bytes":
        unit.slave.freeFMUState(state)
        state = unit.slave.deSerializeFMUstate(data)
    unit.slave.setFMUState(state)
    assert np.array_equal(pushed(unit, drives, -series), first)
    unit.slave.freeFMUState(state)
    assert not np.array_equal(pushed(unit, drives, -series), first)


def test_a_reset_axis_starts_anew(opened: Callable[[Model], Unit]) -> None:
    _, model, inputs = case("lugre and static")
    unit, (drives, series) = opened(model), driver(inputs)
    unit.begin()
    first = pushed(unit, drives, series)
    unit.slave.reset()
    unit.begin()
    assert np.array_equal(pushed(unit, drives, series), first)


def test_a_tuned_parameter_is_that_of_another_model(opened: Callable[[Model], Unit]) -> None:
    """Of the motor's law, of the load's, of the coupling and of the masses, while it runs."""
    changed = {"F_C_motor": 6.0, "F_V": 45.0, "stiffness": 3e5, "play": 3e-4, "armature": 1.5}
    tuned, built = (
        opened(model_of(rig_of(v), "coulomb-viscous", v)) for v in (SERVO, SERVO | changed)
    )
    tuned.begin()
    built.begin()
    tuned.set(**changed)
    series = np.interp(2e-3 * np.arange(200), KNOTS, FORCE)
    assert np.array_equal(pushed(tuned, "force", series), pushed(built, "force", series))


def test_play_may_be_taken_away_and_given(opened: Callable[[Model], Unit]) -> None:
    unit = opened(model_of(rig_of(SERVO), "coulomb-viscous", SERVO))
    unit.begin(force=60.0)

    def ahead() -> float:
        for k in range(100):
            unit.slave.doStep(k * 2e-3, 2e-3)
        position, motor, coupling = unit.get("position", "motor_position", "coupling")
        return float(motor - position - coupling / SERVO["stiffness"])

    for play in (2e-4, 0.0, 4e-4):  # at the flank ahead, in a steady motion
        unit.set(play=play)
        assert ahead() == pytest.approx(0.5 * play, abs=2e-6)


def test_an_efficiency_may_be_set_to_one(opened: Callable[[Model], Unit]) -> None:
    """A load that a lossy coupling could hold is one that it does not."""
    friction = {"side": "both", "motor": "coulomb-viscous"}
    values = LUGRE | STATIC
    lossy, ideal = (
        opened(model_of(rig_of(AXIS | more, "lugre", friction=friction), "lugre", values))
        for more in ({"eta": 0.6, "eta_back": 0.4}, {})
    )
    t, series = sampled({"force": FORCE}, SHORT)
    lossy.begin(eta=1.0, eta_back=1.0)
    ideal.begin()
    motions = [unit.walk(t, series, OUTPUTS) for unit in (lossy, ideal)]
    assert np.abs(motions[0] - motions[1])[[0, 2]].max() <= 2e-7


def refused(call: Callable[..., object], *arguments: object, **named: float) -> None:
    with pytest.raises(fmpy.fmi1.FMICallException, match="error"):
        call(*arguments, **named)


@pytest.mark.parametrize("name", ["file", "lugre and static"])
def test_a_motion_that_runs_away_is_an_error(opened: Callable[[Model], Unit], name: str) -> None:
    _, model, _ = case(name)
    unit = opened(model)
    unit.begin()
    unit.set(external=1e30)
    refused(unit.slave.doStep, 0.0, 0.1)
    again = opened(model)
    again.begin()
    again.set(M=float("nan"))
    refused(again.slave.doStep, 0.0, 1e-3)


STRICT = [*CASES, "no friction of a load that is held"]


def strict(name: str) -> Model:
    if name in CASES:
        return case(name)[1]
    return model_of(
        rig_of(AXIS | GAINS | {"eta": 0.5}, friction={"side": "motor"}),
        "coulomb-viscous", {"F_C": 10.0, "F_V": 20.0},
    )  # fmt: skip


@pytest.mark.parametrize("name", STRICT)
def test_its_sources_compile_without_a_warning(name: str, tmp_path: Path) -> None:
    compiled_without_a_warning(strict(name), tmp_path)


@pytest.mark.parametrize("name", ["file", "lugre and static", "sampled, by the load's encoder"])
def test_no_byte_is_lost_or_touched_that_is_another_s(name: str, tmp_path: Path) -> None:
    run_by_master(case(name)[1], tmp_path)


@pytest.mark.parametrize("name", CASES)
def test_it_is_a_valid_unit(name: str, tmp_path: Path) -> None:
    exported = export(case(name)[1], "fmu", name="axis")
    assert exported.notes == ()
    (path,) = exported.write(tmp_path / "axis.fmu")
    assert validate_fmu(str(path)) == []


#: Functions that other tests walk: of a law, and of a drive that may follow its axis or not.
ELSEWHERE = {"motion_rubbed", "motion_steady", "motion_drive"}
#: Lines that no motion here reaches: where slopes of two velocities have no common root, where
#: steps run out, a level is passed and passed back within a step, or a limit is infinite.
IDLE = {
    "break;", "*result_3 = 0;", "piece = early * share;", "demand = copysign(INFINITY, demand);",
}  # fmt: skip


@pytest.mark.skipif(GCOV is None, reason="there is no gcov here")
def test_every_line_of_the_stepper_is_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    units = Built(tmp_path)
    monkeypatch.setattr(build, "_compiled", units.compiled)
    ran, idle = set[str](), set[str]()
    for name in CASES:
        _, model, inputs = case(name)
        t, series = sampled(inputs, SHORT)
        unit = units.opened(model)
        walked(unit, t, series)
        unit.slave.reset()
        walked(unit, t, {n: x + 15.0 if n == "force" else x + 1e-3 for n, x in series.items()})
        unit.slave.reset()
        half = len(t) // 2
        walked(unit, t[:half], {n: x[:half] for n, x in series.items()}, velocity_start=0.02)
        for k, play in enumerate((3e-4, 0.0, 2e-4)):
            unit.set(play=play, **({"enabled": 0.0} if "goal" in inputs else {}))
            unit.slave.doStep(t[half] + k * LONG, LONG)
        unit.set(**{"external" if "goal" in inputs else "force": 1e30})
        refused(unit.slave.doStep, t[-1], 0.1)
        unit.slave.freeInstance()  # and unloads it, which writes the counts
        now, never = units.lines()
        ran, idle = ran | now, idle | never
    assert len(ran) > 600
    never = {line for line in idle - ran if line.partition(": ")[0] not in ELSEWHERE}
    assert {line.partition(": ")[2] for line in never} <= IDLE
