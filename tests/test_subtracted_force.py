"""A rigid-body torque in a log, taken off the force before friction is looked for."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from command import Completed, caller
from foreign import driven, sensors
from foreign.friction import coulomb_viscous
from foreign.strokes import strokes
from stribeck import Fit, InputError, Recording, check, identify, read, read_card, validate
from stribeck.space import Array

#: kg m², N m, N m s/rad, N m.
INERTIA, F_C, F_V, GRAVITY = 0.8, 6.0, 4.0, 25.0


@cache
def motion() -> dict[str, Array]:
    """A joint that gravity pulls at: its motion, its torque, and what a model knows of that."""
    t, x, _ = strokes(np.array([0.3, 0.8, 1.6, 2.4, 1.2, 0.5]), 1.2, ramp=0.2)
    curve = coulomb_viscous(F_C, F_V)
    loop = driven.Loop(kp=3e4, kd=8e2, ki=4e4, mass_ff=INERTIA)
    extras = driven.Extras(g_sin=GRAVITY)
    table = driven.simulate(INERTIA, curve, curve, loop, t, x, extras)._asdict()
    table = sensors.quantised(table, "position", 1e-6)
    a = np.gradient(np.asarray(table["velocity"]), np.asarray(table["t"]))
    gravity = GRAVITY * np.sin(np.asarray(table["position"]))
    return {
        "t [s]": np.asarray(table["t"]),
        "q [rad]": np.asarray(table["position"]),
        "tau_meas [N m]": np.asarray(table["force"])
        + 0.05 * np.random.default_rng(1).standard_normal(len(a)),
        "tau_gravity [N m]": gravity,
        "tau_rigid [mN m]": 1e3 * (gravity + INERTIA * a),
    }


def fitted(column: str, **options: Any) -> Fit:
    """A fit of the joint, a column subtracted."""
    return identify(motion(), rig="forced-rotary", subtract=column, **options)


def verdicts(fit: Fit) -> dict[str, str]:
    """The verdict on each parameter."""
    names = (q.name for q in fit.parameters.every)
    return {n: e.verdict for n, e in zip(names, fit.estimates, strict=True)}


@pytest.fixture
def stribeck(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str],
             tmp_path: Path) -> Callable[..., Completed]:  # fmt: skip
    """The command line in a folder with the log."""
    columns = motion()
    rows = zip(*columns.values(), strict=True)
    text = "\n".join([",".join(columns), *(",".join(map(repr, map(float, r))) for r in rows)])
    (tmp_path / "joint.csv").write_text(text + "\n")
    monkeypatch.chdir(tmp_path)
    return caller(monkeypatch, capsys)


def test_gravity_that_the_log_knows_leaves_friction_and_inertia() -> None:
    fit = fitted("tau_gravity [N m]")
    for name, value in (("F_C", F_C), ("F_V", F_V), ("M", INERTIA)):
        low, high = fit.intervals[name]
        assert low <= value <= high
        assert fit.values[name] == pytest.approx(value, rel=0.01)
        assert verdicts(fit)[name] == "identified"
    assert "the torque goes with the sine" not in " ".join(fit.warnings)
    assert "tau_gravity [N m] is subtracted from the force" in " ".join(fit.notes)
    without = identify(motion(), rig="forced-rotary")
    assert "the torque goes with the sine" in " ".join(without.warnings)


def test_units_are_converted_and_an_inertia_in_the_column_is_told() -> None:
    fit = fitted("tau_rigid [mN m]")
    assert fit.values["F_C"] == pytest.approx(F_C, rel=0.01)
    assert abs(fit.values["M"]) < 0.02
    assert "goes with the acceleration by 0.8" in " ".join(fit.warnings)
    assert verdicts(fit)["M"] != "identified"
    held = fitted("tau_rigid [mN m]", fixed={"J": 0.0})
    assert not any(v.caps for v in held.violations)
    assert verdicts(held)["F_C"] == "identified"
    twice = fitted("tau_rigid [mN m]", fixed={"J": INERTIA})
    assert "the mass counts twice: J is set to 0.8 kg m**2" in " ".join(twice.warnings)
    assert verdicts(twice)["F_C"] == "weak"


def test_the_torque_belongs_to_the_motion_where_the_force_is_late() -> None:
    late = dict(motion())
    late["tau_meas [N m]"] = np.interp(late["t [s]"] - 0.012, late["t [s]"], late["tau_meas [N m]"])
    fit = identify(late, rig="forced-rotary", subtract="tau_gravity [N m]")
    # The loop holds its force from sample to sample, which is half a sample ahead.
    assert 1e3 * fit.delay == pytest.approx(11.5, abs=0.2)
    assert fit.values["F_C"] == pytest.approx(F_C, rel=0.01)
    assert fit.values["M"] == pytest.approx(INERTIA, rel=0.02)


def test_a_drive_chain_scales_the_measured_force_alone() -> None:
    log = {n: a for n, a in motion().items() if n != "tau_meas [N m]"}
    log["i [A]"] = motion()["tau_meas [N m]"] / (0.1 * 50)
    drive = {"signal": "A rms", "kt": "0.1 ± 5 % N m/A rms", "gear": 50}
    recording = Recording.of(log, columns={"columns": {"force": "i [A]"}, "drive": drive},
                             subtract="tau_gravity [N m]")  # fmt: skip
    fit = identify(recording, rig="forced-rotary")
    assert fit.values["F_C"] == pytest.approx(F_C, rel=0.01)
    # A torque constant that is off leaves a share of gravity: friction does not go with it alone.
    low, high = fit.intervals["F_C"]
    assert high - low > 0.05 * F_C


def test_a_card_remembers(stribeck: Callable[..., Completed], tmp_path: Path) -> None:
    done = stribeck("identify", "joint.csv", "--rig", "forced-rotary", "--subtract", "tau_gravity",
                    "--out", "result", "--no-figures")  # fmt: skip
    assert done.status == 0, done.err
    assert "tau_gravity [N m] is subtracted from the force" in done.out
    assert "tau_gravity [N m] is subtracted" in (tmp_path / "result/report.html").read_text()
    card = read_card("result/card.json")
    assert card.columns["subtract"].startswith("tau_gravity")
    (row,) = validate(card, "joint.csv")
    assert row[2].value == pytest.approx(card.objective.value, rel=1e-6)
    again = stribeck("validate", "result/card.json", "joint.csv", "--json")
    assert f"{card.objective.value:.4f}"[:5] in again.out
    # Of a log in memory the card knows it, too.
    memory = identify(motion(), rig="forced-rotary", subtract="tau_gravity [N m]").card()
    (row,) = validate(memory, motion())
    assert row[2].value == pytest.approx(memory.objective.value, rel=1e-6)
    (row,) = validate(memory, read("joint.csv"))
    assert row[2].value == pytest.approx(memory.objective.value, rel=1e-3)


def test_a_map_and_check_take_it(stribeck: Callable[..., Completed], tmp_path: Path) -> None:
    (tmp_path / "map.toml").write_text('subtract = "tau_gravity"\n')
    by_map = read("joint.csv", columns="map.toml")
    assert by_map.known_force is not None
    assert by_map.known_force.values == pytest.approx(motion()["tau_gravity [N m]"])
    checked = stribeck("check", "joint.csv", "--subtract", "tau_gravity")
    assert "tau_gravity [N m] is subtracted" in checked.out.replace("\n", " ")
    assert any("is subtracted" in n for n in check(by_map).notes)
    part = read("joint.csv@1s:3s", subtract="tau_gravity")
    assert part.known_force is not None
    assert len(part.known_force.values) == len(part)


def test_what_cannot_be_subtracted_is_refused(stribeck: Callable[..., Completed]) -> None:
    unknown = stribeck("identify", "joint.csv", "--rig", "forced-rotary", "--subtract", "tau_x")
    assert unknown.status == 2
    assert "subtract: there is no column 'tau_x': there are t [s], q [rad]" in unknown.err
    with pytest.raises(InputError, match=r"column q \[rad\] is in rad, and the force in N m"):
        fitted("q [rad]")
    with pytest.raises(InputError, match="is the force itself"):
        fitted("tau_meas [N m]")
    with pytest.raises(InputError, match=r'has no unit: write it as "tau_r \[N m\]"'):
        identify({**motion(), "tau_r": motion()["tau_gravity [N m]"]}, rig="forced-rotary",
                 subtract="tau_r")  # fmt: skip
    channels = {"time": "t [s]", "position": "q [rad]", "command": "q [rad]"}
    with pytest.raises(InputError, match="which rig joint does not go"):
        identify(motion(), rig="joint", subtract="tau_gravity [N m]", columns=channels)
    with pytest.raises(InputError, match="stands beside other words"):
        Recording.of(motion(), columns={"subtract": "tau_gravity [N m]", "position": "q [rad]"})
