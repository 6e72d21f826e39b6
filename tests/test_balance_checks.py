"""Warnings of a force balance: simulated logs with one fault each, and EMPS with none."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from foreign import driven
from foreign.friction import coulomb_viscous
from foreign.strokes import levels
from stribeck import Recording, identify, read
from stribeck.data.force_channel import both_ways, spikes
from stribeck.rig import RIGS
from stribeck.space import Array

EMPS = Path(__file__).parents[2] / "shared" / "data" / "emps"
T: Array = np.arange(0.0, 20.0, 1e-3)
#: Starts of the warnings, by fault.
FAULTS = {
    "delay": "the motion (",
    "spikes": "the force has spikes",
    "gravity": "the torque goes with the sine",
    "command": "it is a command that was computed",
    "narrow": "the speeds are too narrow",
    "few": "too few speeds for a Stribeck curve",
    "cut-off": "the estimates depend on the cut-off",
    "offset": "most of the force is the constant offset",
    "unexplained": "the log supports nothing better",
    "pressure": "the force holds that of the recorded pressure",
    "logs": "logs differ beyond their noise",
}


def motion(reach: float = 0.2) -> tuple[Array, Array, Array]:
    """Position, speed and acceleration of two tones: many speeds, both ways."""
    x, v, a = np.zeros((3, len(T)))
    for size, w in ((reach, 1.57), (0.3 * reach, 4.1)):
        x += size * np.sin(w * T)
        v += size * w * np.cos(w * T)
        a -= size * w * w * np.sin(w * T)
    return x, v, a


def sound(seed: int = 0) -> tuple[Array, Array]:
    """Position and force of a 3 kg axis with 20 N and 50 N s/m of friction, a little noise."""
    x, v, a = motion()
    noise = 0.5 * np.random.default_rng(seed).standard_normal(len(T))
    return x, 3 * a + 20 * np.sign(v) + 50 * v + noise


def faults(fit: Any) -> set[str]:
    return {name for name, words in FAULTS.items() if any(words in w for w in fit.warnings)}


def fitted(x: Array, force: Array, rig: str = "forced", **options: Any) -> Any:
    return identify(Recording(T, x, force=force, rotary=RIGS[rig].rotary), rig=rig, **options)


def test_a_sound_log_raises_no_doubt_and_all_of_it_is_identified() -> None:
    fit = fitted(*sound())
    assert faults(fit) == set()
    assert {e.name: e.verdict for e in fit.estimates if e.name != "offset"} == dict.fromkeys(
        ("F_C", "F_V", "M"), "identified"
    )


@pytest.mark.recordings("emps")
@pytest.mark.parametrize("name", ["DATA_EMPS", "DATA_EMPS_PULSES"])
def test_emps_raises_none(name: str) -> None:
    log = read(EMPS / f"{name}.mat", columns=dict(RIGS["emps"].columns))
    assert faults(identify(log, rig="emps")) == set()


@pytest.mark.recordings("emps")
def test_emps_has_too_few_speeds_for_a_stribeck_curve() -> None:
    log = read(EMPS / "DATA_EMPS.mat", columns=dict(RIGS["emps"].columns))
    assert faults(identify(log, rig="emps", law="stribeck")) == {"few"}


@pytest.mark.parametrize(("count", "replaced"), [(300, True), (600, False)])
def test_spikes(count: int, *, replaced: bool) -> None:
    """Few of them are replaced when the log is looked at, many are left and told by the balance."""
    x, force = sound()
    rng = np.random.default_rng(1)
    at = rng.choice(len(T), count, replace=False)
    force[at] += rng.choice([-1, 1], count) * 400.0
    fit = fitted(x, force)
    assert ("spikes" in faults(fit)) != replaced
    assert any("off their neighbours" in w for w in fit.notes) == replaced


def test_white_noise_and_steps_are_no_spikes() -> None:
    rng = np.random.default_rng(2)
    assert spikes([rng.standard_normal(5000)]) == 0
    assert spikes([np.sign(np.sin(T))]) == 0
    assert spikes([np.where(np.arange(5000) % 100 == 0, 50.0, 0.0)]) > 0.5


def test_gravity_on_a_rig_without_it() -> None:
    x, v, a = motion(reach=1.0)
    force = 0.02 * a + 0.2 * np.sign(v) + 0.05 * v + 3.0 * np.sin(x)
    assert "gravity" in faults(fitted(x, force, "forced-rotary"))
    fit = fitted(x, force, "forced-pendulum")
    assert faults(fit) == set()
    assert fit.values["g_sin"] == pytest.approx(3.0, rel=0.01)
    assert fit.values["g_cos"] == pytest.approx(0.0, abs=0.01)
    assert fit.values["M"] == pytest.approx(0.02, rel=0.02)
    assert fit.values["F_C"] == pytest.approx(0.2, rel=0.02)


def test_a_torque_that_was_computed_from_the_angle() -> None:
    x, v, _ = motion(reach=1.0)
    command = 3.3 * np.sin(np.round(x, 3))
    fit = fitted(x, command, "forced-pendulum")
    assert "command" in faults(fit)
    assert all(e.verdict != "identified" for e in fit.estimates)
    assert "command" not in faults(fitted(x, command + 0.3 * np.sign(v), "forced-pendulum"))


def test_a_function_of_position_is_told_from_a_loop() -> None:
    x, v, _ = motion()
    assert both_ways(T, x, np.cos(4 * x)) == pytest.approx(0.0, abs=0.02)
    share = both_ways(T, x, np.cos(4 * x) + 0.2 * np.sign(v))
    assert share is not None
    assert share > 0.3
    assert both_ways(T, T, np.cos(T)) is None  # one way: neighbours in place are so in time


def test_one_speed_cannot_tell_viscous_from_coulomb() -> None:
    x = 0.05 * np.abs((T / 2) % 2 - 1)
    v = np.gradient(x, T)
    force = 20 * np.sign(v) + 50 * v + 0.1 * np.random.default_rng(3).standard_normal(len(T))
    fit = fitted(x, force)
    assert "narrow" in faults(fit)
    assert "narrow" not in faults(fitted(x, force, fixed={"F_V": 50.0}))


def test_speeds_whose_ramps_tell_viscous_friction_are_not_too_narrow() -> None:
    """Strokes of one speed that start and stop in 0.15 and 0.3 s show both to some per mille."""
    t, command = levels([(0.1, 1.0, 0.15), (-0.1, 1.0, 0.3)] * 4)
    curve, loop = coulomb_viscous(30.0, 100.0), driven.Loop(kp=4e4, kd=2e3, mass_ff=20.0, tick=1e-5)
    run = driven.simulate(20.0, curve, curve, loop, t, command)._asdict()
    noise = np.random.default_rng(1).standard_normal((2, len(t)))
    told, hidden = (
        identify(Recording(t, run["position"], force=run["force"] + sd * own), rig="forced")
        for sd, own in zip((0.2, 40.0), noise, strict=True)
    )
    for e, truth in zip(told.estimates, (30.0, 100.0), strict=False):
        assert e.verdict == "identified"
        assert e.value == pytest.approx(truth, rel=0.02)
    assert "narrow" not in faults(told)
    assert "narrow" in faults(hidden)
    advice = next(w for w in hidden.warnings if FAULTS["narrow"] in w)
    assert "log other speeds, too, or hold the one that is known" in advice


def test_few_speeds_for_a_curve_and_many() -> None:
    rng = np.random.default_rng(4)
    speed = np.select([T % 20 < 5, T % 20 < 10], [0.05, 0.1], 0.02)
    v = speed * np.sign(np.sin(2 * np.pi * T / 2.5))
    x = np.cumsum(v) * 1e-3
    force = v * 50 + 20 * np.sign(v) + 0.1 * rng.standard_normal(len(T))
    assert "few" in faults(fitted(x, force, law="stribeck"))
    assert "few" not in faults(fitted(*sound(), law="stribeck"))


def test_estimates_that_depend_on_the_cut_off_are_widened() -> None:
    # A sensor that trembles at 38 Hz shows an acceleration that is none, which makes a mass too
    # small; at a third of the cut-off it is filtered away.
    x, v, a = motion()
    trembling = x + 1e-5 * np.sin(2 * np.pi * 38 * T)
    force = 3 * a + 20 * np.sign(v) + 50 * v
    force += 0.5 * np.random.default_rng(5).standard_normal(len(T))
    fit = fitted(trembling, force)
    assert "cut-off" in faults(fit)
    mass = next(e for e in fit.estimates if e.name == "M")
    assert mass.value < 2.8
    assert mass.high > 2.95  # what a third of the cut-off gives
    assert mass.verdict != "identified"


@pytest.mark.parametrize(
    "measured",
    [
        pytest.param(lambda x, rng: x + 3e-5 * rng.standard_normal(len(x)), id="noise"),
        pytest.param(lambda x, _: 1e-4 * np.round(x / 1e-4), id="steps of 0.1 mm"),
    ],
)
def test_the_error_of_a_position_is_taken_off_the_mass(measured: Any) -> None:
    """It is an error of the acceleration, which least squares makes a mass too small by."""
    x, v, a = motion()
    for seed in range(4):
        rng = np.random.default_rng(seed)
        force = 3 * a + 20 * np.sign(v) + 50 * v + 0.5 * rng.standard_normal(len(T))
        fit = fitted(measured(x, rng), force)
        mass = next(e for e in fit.estimates if e.name == "M")
        assert mass.low < 3.0 < mass.high
        assert mass.high - mass.low < 0.45
        (told,) = [w for w in fit.warnings if w.startswith("the error of the position is taken")]
        assert re.search(r"M from 2\.[5-9]\d* to ", told)


def test_a_fine_position_moves_nothing() -> None:
    fit = fitted(*sound())
    assert not any("error of the position" in w for w in fit.warnings)
    assert fit.p[fit.parameters.names.index("M")] == fit.balance.values[2]


def test_a_constant_must_not_flatter_the_error() -> None:
    x, force = sound()
    noisy = force + 40 * np.random.default_rng(6).standard_normal(len(T)) + 2000.0
    fit = fitted(x, np.repeat(noisy[::20], 20) + 0 * x)
    assert fit.score.value < 5.0
    assert "offset" in faults(fit)


def test_what_explains_little_identifies_nothing() -> None:
    x, force = sound()
    slow = np.cumsum(np.random.default_rng(7).standard_normal(len(T)))
    fit = fitted(x, force + 300 * (slow - slow.mean()) / slow.std())
    assert "unexplained" in faults(fit)
    assert all(e.verdict in ("weak", "not identifiable") for e in fit.estimates)


def test_a_pressure_that_the_rig_does_not_know() -> None:
    x, force = sound()
    pressure = 1e5 + 0 * x
    log = Recording(T, x, force=force + 50.0, pressure=pressure)
    assert "pressure" in faults(identify(log, rig="forced"))
    assert "pressure" not in faults(identify(log, rig="cylinder"))


def test_several_logs_of_one_axis_agree_and_of_two_do_not() -> None:
    x, force = sound()
    v = np.gradient(x, T)
    logs = [Recording(T, x, force=sound(k)[1]) for k in range(3)]
    one_axis = identify(logs, rig="forced")
    assert "logs" not in faults(one_axis)
    mixed = [*logs[:2], replace(logs[2], force=force + 4 * np.sign(v))]
    two_axes = identify(mixed, rig="forced")
    assert "logs" in faults(two_axes)
    level, wide = (
        next(e for e in fit.estimates if e.name == "F_C") for fit in (one_axis, two_axes)
    )
    assert level.verdict == "identified"
    assert level.low < 20 < level.high
    assert wide.low < 20
    assert wide.high > 24


def test_a_force_that_is_a_current_times_a_number_says_so(tmp_path: Path) -> None:
    x, force = sound()
    rows = "\n".join(f"{t:.3f},{p:.9f},{i:.6f}" for t, p, i in zip(T, x, force / 80, strict=True))
    file = tmp_path / "log.csv"
    file.write_text("t_s,x_m,i_A\n" + rows)
    columns = {"force": {"column": "i_A", "factor": 80.0, "unit": "N"}}
    fit = identify(read(file, columns=columns), rig="forced")
    assert any("force is i_A times 80" in w for w in fit.notes)
    turned = {"force": {"column": "i_A", "factor": -1.0, "unit": "N"}}
    assert not any("times" in note for note in read(file, columns=turned).notes)
