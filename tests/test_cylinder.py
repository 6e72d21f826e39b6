"""A cylinder whose seal friction grows with the pressure: recovery, refusals, the card."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from foreign import cylinder, sensors
from foreign.strokes import strokes
from stribeck import InputError, Recording, cli, identify, read, read_card, validate
from stribeck.friction import LAWS, law_named
from stribeck.identify.balance.balance import balance
from stribeck.identify.parameters import Parameters
from stribeck.rig import RIGS
from stribeck.rig.balanced import rubs
from stribeck.rig.custom import rig_file
from stribeck.rig.cylinder import CYLINDER, Cylinder
from stribeck.rig.forced import FORCED
from stribeck.space import Array

T: Array = np.arange(0.0, 40.0, 0.01)
AREA = np.pi / 4 * 0.025**2
#: F_C, F_V, mu [m^2], M, offset, b [m^2].
TRUTH = np.array([4.0, 60.0, 0.5e-5, 8.0, 1.5, 0.2e-5])


def log(bar: float, seed: int = 0, extra: float = 0.0, file: str = "") -> Recording:
    """Strokes at many speeds under a pressure, force with a little noise."""
    w = 2 * np.pi / 8.0
    x = 0.04 * np.sin(w * T) + 0.01 * np.sin(2.7 * w * T)
    v = 0.04 * w * np.cos(w * T) + 0.027 * w * np.cos(2.7 * w * T)
    a = -0.04 * w**2 * np.sin(w * T) - 0.0729 * w**2 * np.sin(2.7 * w * T)
    p = 1e5 * bar * (1 + 0.02 * np.sin(0.3 * T))
    F_C, F_V, mu, M, offset, b = TRUTH
    force = M * a + (F_C + mu * p + extra) * np.sign(v) + F_V * v + (AREA + b) * p + offset
    force += 0.05 * np.random.default_rng(seed).standard_normal(len(T))
    recording = Recording(T, x, force=force, pressure=p)
    return replace(recording, source=replace(recording.source, file=file))


def logs(*extras: float) -> list[Recording]:
    return [log(bar, k, m) for k, (bar, m) in enumerate(zip((1, 3, 5, 7), extras, strict=True))]


def test_everything_comes_back_and_pressure_is_told_per_bar() -> None:
    fit = identify(logs(0, 0, 0, 0), rig="cylinder")
    assert fit.law.name == "coulomb-load"
    # Reversals inside the filter cost the last percent.
    np.testing.assert_allclose(fit.p[[0, 2, 3]], TRUTH[[0, 2, 3]], rtol=0.03)
    np.testing.assert_allclose(fit.p[[4, 5]], TRUTH[[4, 5]], rtol=0.06)
    estimates = {e.name: e for e in fit.estimates}
    assert list(estimates) == ["F_C", "F_V", "mu_p", "M", "offset", "b"]
    assert (estimates["mu_p"].unit, estimates["b"].unit) == ("N/bar", "N/bar")
    assert estimates["mu_p"].verdict == "identified"
    assert estimates["mu_p"].low < TRUTH[2] < estimates["mu_p"].high
    assert not any("does not follow one law" in w for w in fit.warnings)


@pytest.mark.parametrize("ripple", [0.0, 0.5])
def test_a_pressure_that_is_the_noise_of_its_sensor_tells_nothing(ripple: float) -> None:
    """At 4 bar its force is 196 N of an offset, and friction has a share that is any."""
    axis = cylinder.Cylinder(M=5.0, F_C=20.0, F_V=200.0, mu_p=4e-5)
    t, _, speed = strokes(np.array([0.05, 0.1, 0.2]), 0.1, ramp=0.2)
    rng = np.random.default_rng(2)
    run = cylinder.simulate(axis, t, speed, 1e5 * (4.0 + ripple * np.sin(0.9 * t)))._asdict()
    run = sensors.noisy(sensors.noisy(run, "force", 0.3, rng), "pressure", 500.0, rng)
    measured = Recording(run["t"], run["position"], force=run["force"], pressure=run["pressure"])
    fit = identify(measured, rig=CYLINDER.set(bore=25.0))
    told = [w for w in fit.warnings if "the pressure does not change" in w]
    verdicts = {e.name: e.verdict for e in fit.estimates}
    if ripple:
        assert told == []
        assert {verdicts["F_C"], verdicts["mu_p"]} == {"identified"}
        return
    assert "nothing tells F_C, mu_p, offset and b apart" in told[0]
    assert "identified" not in {verdicts[n] for n in ("F_C", "mu_p", "offset", "b")}
    assert {verdicts["F_V"], verdicts["M"]} == {"identified"}
    held = identify(measured, rig=CYLINDER.set(bore=25.0), fixed={"mu": 4e-5, "b": 0.0})
    assert not any("the pressure does not change" in w for w in held.warnings)


def test_the_bore_moves_what_the_pressure_drives_and_its_tolerance_widens_that() -> None:
    """The default bore is an example: b = (area error) knows nothing, what the seals do stays."""
    every = logs(0, 0, 0, 0)
    default = {e.name: e for e in identify(every, rig="cylinder").estimates}
    assert default["b"].verdict == "weak"
    assert default["b"].reason in ("constants", "wide")
    assert default["mu_p"].verdict == "identified"
    exact = identify(every, rig=CYLINDER.set(bore=25.0))
    b = next(e for e in exact.estimates if e.name == "b")
    (sentence,) = [w for w in exact.warnings if w.startswith("taken as exact")]
    # d(area)/area = 2 d(bore)/bore, and b takes what the area lacks.
    share = 2 * AREA / TRUTH[5]
    shown = float(sentence.split("moves b by ")[1].split(" %")[0])
    assert shown == pytest.approx(-10 * share, rel=0.01)
    assert b.high - b.low < 0.1 * (default["b"].high - default["b"].low)


def test_the_error_is_of_the_force_without_the_pressure() -> None:
    recording = log(5)
    assert recording.force is not None
    assert recording.pressure is not None
    fit = identify(recording, rig="cylinder")
    friction_force = FORCED.measured(recording) - AREA * recording.pressure
    assert fit.balance is not None
    size = np.sqrt(np.mean(friction_force**2))
    assert size < 0.06 * np.sqrt(np.mean(recording.force**2))
    assert fit.score.value == pytest.approx(100 * fit.balance.residual_sd / size, rel=0.1)
    np.testing.assert_allclose(CYLINDER.measured(recording), friction_force)
    np.testing.assert_allclose(
        CYLINDER.set(bore=50.0).measured(recording) - friction_force, -3 * AREA * recording.pressure
    )


def test_a_seal_without_one_slope_is_told_and_its_interval_takes_logs_as_units() -> None:
    even, odd = (identify(logs(*m), rig="cylinder") for m in ((0, 0, 0, 0), (0, 0, 1.5, -1.5)))
    assert any("the 4 logs differ beyond their noise" in w for w in odd.warnings)
    assert not any("logs differ" in w for w in even.warnings)
    wide, narrow = (
        next(e.high - e.low for e in fit.estimates if e.name == "mu_p") for fit in (odd, even)
    )
    assert wide > 10 * narrow
    assert next(e.verdict for e in odd.estimates if e.name == "mu_p") == "weak"


def test_the_friction_range_is_twice_the_friction_whatever_the_offset() -> None:
    direction = np.sign(np.sin(2 * np.pi * T / 8.0))
    x = np.cumsum(0.01 * direction) * 0.01
    pressure = 3e5 + 0 * T
    recording = Recording(T, x, force=6.0 * direction + 2.5 + AREA * pressure, pressure=pressure)
    assert CYLINDER.friction_range(recording) == pytest.approx(12.0, rel=0.01)
    fit = identify(
        replace(recording, source=replace(recording.source, file="a.csv")), rig="cylinder"
    )
    assert fit.balance is not None
    assert fit.balance.figures()["friction_range_N a.csv"] == pytest.approx(12.0, rel=0.01)
    with pytest.raises(InputError, match="strokes both ways"):
        CYLINDER.friction_range(replace(recording, position=0.01 * T))


def test_static_laws_run_on_it_too() -> None:
    fit = identify(log(3), rig="cylinder", law="coulomb-viscous-directional")
    assert "offset" not in fit.values
    assert fit.values["F_C+"] - TRUTH[4] == pytest.approx(4.0 + 1.5, abs=0.4)


def test_a_law_with_a_load_is_its_own_formula() -> None:
    law = LAWS["coulomb-load"]
    loads = np.zeros((4, 5))
    loads[:, 2] = [0.0, 2.0, -2.0, 5.0]
    friction = rubs(law.rub, np.array([1.0, -1.0, 0.0, 2.0]), loads, np.array([3.0, 10.0, 0.5]))
    np.testing.assert_allclose(friction, [13.0, -14.0, 0.0, 25.5])


def test_a_rig_file_maps_a_pressure_of_any_name_and_unit(tmp_path: Path) -> None:
    original = log(4)
    assert original.force is not None
    assert original.pressure is not None
    table = np.column_stack(
        [original.t, 1e3 * original.position, 1e-3 * original.pressure, original.force]
    )
    file = tmp_path / "log.csv"
    np.savetxt(file, table, "%.6f", ",", header="t_s,x_mm,Kammer A,F_N", comments="")
    rig = tmp_path / "press.toml"
    rig.write_text(
        'kind = "cylinder"\nconstants = { bore = 40.0 }\n'
        'columns = { pressure = "Kammer A [kPa]" }\n'
    )
    cylinder = rig_file(rig)
    recording = read(file, columns=dict(cylinder.columns))
    assert recording.pressure is not None
    np.testing.assert_allclose(recording.pressure, original.pressure, rtol=1e-6)
    assert isinstance(cylinder, Cylinder)
    assert cylinder.area == pytest.approx(np.pi * 0.02**2)
    assert read(file).pressure is None  # unmapped, it is a further column
    assert list(read(file).extra) == ["Kammer A"]


@pytest.mark.parametrize(
    ("law", "rig", "words"),
    [
        ("bam-m3", "forced-rotary", "law bam-m3 depends on the force of the drive"),
        ("coulomb-load", "forced", "law coulomb-load depends on the normal load, which rig forced"),
    ],
)
def test_laws_that_a_force_balance_cannot_follow(law: str, rig: str, words: str) -> None:
    recording = replace(log(1), rotary=RIGS[rig].rotary)
    axis: Any = RIGS[rig]
    with pytest.raises(InputError, match=words) as refusal:
        balance(recording, Parameters.declared(axis, LAWS[law]))
    assert "\n" not in str(refusal.value)


def test_a_cylinder_needs_a_pressure_and_a_temperature_term_a_temperature() -> None:
    with pytest.raises(InputError, match="needs the pressure in the cylinder"):
        identify(replace(log(1), pressure=None), rig="cylinder")
    with pytest.raises(InputError, match="needs a temperature"):
        balance(log(1), Parameters.declared(FORCED, law_named("coulomb-viscous+temperature")))


def test_a_temperature_term_multiplies_all_friction() -> None:
    law = law_named("coulomb-viscous+temperature")
    w = 2 * np.pi / 8.0
    x, v, a = 0.04 * np.sin(w * T), 0.04 * w * np.cos(w * T), -0.04 * w * w * np.sin(w * T)
    warm = 293.15 + T
    force = 5 * a + (8 * np.sign(v) + 200 * v) * (1 - 0.01 * (warm - 293.15))
    estimates = balance(
        Recording(T, x, force=force, temperature=warm), Parameters.declared(FORCED, law)
    )
    assert estimates["temp_slope"] == pytest.approx(-0.01, rel=0.02)
    assert estimates["F_C"] == pytest.approx(8.0, rel=0.02)


def test_a_term_never_makes_friction_drive() -> None:
    law, loads = law_named("coulomb-viscous+temperature"), np.zeros((3, 5))
    loads[:, 4] = 303.15, 313.15, 333.15  # 5 % less a kelvin: half, none, and no less than none
    friction = FORCED.friction(law, np.array([20.0, 5.0, -0.05, 293.15]), np.ones(3), loads)
    assert friction == pytest.approx([12.5, 0.0, 0.0], abs=1e-9)


def test_the_card_of_a_csv_is_held_against_another_log(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for name, bar in (("one", 2.0), ("two", 6.0), ("three", 4.0)):
        r = log(bar)
        assert r.force is not None
        assert r.pressure is not None
        table = np.column_stack([1e3 * r.t, 1e3 * r.position, 1e-5 * r.pressure, r.force])
        np.savetxt(tmp_path / f"{name}.csv", table, "%.6f", ",", header="t_ms,x_mm,p_bar,F_N",
                   comments="")  # fmt: skip
    monkeypatch.chdir(tmp_path)

    def run(*arguments: str) -> int:
        monkeypatch.setattr(sys, "argv", ["stribeck", *arguments])
        try:
            cli.main()
        except SystemExit as end:
            return int(end.code or 0)
        return 0

    options = ("--rig", "cylinder", "--set", "bore=25", "--set", "F_V=60", "--out", "fit")
    assert run("identify", "one.csv", "two.csv", *options) == 0
    assert "friction range / N, one.csv" in capsys.readouterr().out
    assert run("validate", "fit/card.json", "three.csv", "--max-error", "15") == 0
    assert run("validate", "fit/card.json", "three.csv", "--max-error", "0.1") == 1
    card = read_card(tmp_path / "fit" / "card.json")
    ((_, _, score),) = validate(card, read(tmp_path / "three.csv"))
    assert score.value < 15.0
    made_of, p = card.model()
    assert dict(made_of.values(p))["mu"] == pytest.approx(0.5e-5, rel=0.05)
