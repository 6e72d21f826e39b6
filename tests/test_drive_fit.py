"""Fits of forces that came through a drive chain, on logs of a foreign simulator."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from math import pi
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from foreign import driven, presliding, sensors
from foreign.friction import coulomb_viscous
from foreign.strokes import sines, strokes
from stribeck import RIGS, Fit, InputError, Recording, export, identify, read_card, validate
from stribeck.drive import DriveChain
from stribeck.report.fit_report import show_fit
from stribeck.rig.custom import rig_file

#: kg, N, N s/m; the motor behind a screw of 10 mm, and a reduction of 3.
MASS, F_C, F_V, LEAD, GEAR = 10.0, 20.0, 50.0, 0.01, 3.0
#: N m at 100 % of the signal.
RATED = 0.64
TABLE: Mapping[str, Any] = {
    "signal": "% of rated torque",
    "rated_torque": "0.64 N m",
    "gear": GEAR,
    "lead": "10 mm",
}


@cache
def motion(losses: tuple[float, float] = (1.0, 1.0)) -> tuple[Recording, np.ndarray]:
    """A log without force, and what its drive recorded: percent of the rated torque."""
    rng = np.random.default_rng(4)
    speeds = 0.4 * rng.permutation([0.1, 0.2, 0.35, 0.5, 0.75, 1.0])
    t, x, _ = strokes(speeds, 0.2)
    curve = coulomb_viscous(F_C, F_V)
    loop = driven.Loop(kp=4e4, kd=2e3, ki=1e5, mass_ff=9.0)
    table = driven.simulate(MASS, curve, curve, loop, t, x)._asdict()
    driving = table["force"] * table["velocity"] >= 0
    behind = np.where(driving, losses[0], 1 / losses[1])
    torque = table["force"] / behind * LEAD / (2 * pi) / GEAR
    table = sensors.quantised(table, "position", 1e-6)
    noise = 0.003 * rng.standard_normal(len(t))
    return Recording(table["t"], table["position"]), 100 * torque / RATED + noise


def log(
    signal: float = 1.0, losses: tuple[float, float] = (1.0, 1.0), **table: object
) -> Recording:
    """The log with its force by a chain; `signal` multiplies what was recorded."""
    chain = DriveChain.of_table({**TABLE, **table})
    written = chain.resolved("force", chain.signal.unit)
    assert written is not None
    bare, percent = motion(losses)
    return replace(bare, force=written.to_si(signal * percent)).through(chain, "Torque")


@cache
def fitted(rated: str = "0.64 N m", **table: Any) -> Fit:
    return identify(log(rated_torque=rated, **table), rig="forced", law="coulomb-viscous")


def by_name(fit: Fit) -> dict[str, Any]:
    return {e.name: e for e in fit.estimates}


def test_the_force_is_that_of_the_axis() -> None:
    estimates = by_name(fitted())
    for name, truth in {"F_C": F_C, "F_V": F_V, "M": MASS}.items():
        assert estimates[name].value == pytest.approx(truth, rel=0.01)
        assert estimates[name].verdict == "identified"
        assert "in proportion to rated_torque" in estimates[name].meaning
    notes = [n for n in fitted().notes if "where friction is" in n]
    assert len(notes) == 1
    assert "1 % is 12.06 N at the axis" in notes[0]  # 0.0064 N m x 3 x 2 pi/0.01 m
    assert not [w for w in fitted().warnings if "in proportion to the measured force" in w]


def test_an_uncertain_scale_widens_levels_and_leaves_ratios() -> None:
    """5 % is two standard deviations: an interval of 95 % is 4.9 % to each side."""
    exact, rough = fitted(), fitted("0.64 N m ± 5 %")
    for name in ("F_C", "F_V", "M"):
        a, b = by_name(exact)[name], by_name(rough)[name]
        own = (a.high - a.low) / 2 / a.value
        assert b.value == a.value
        assert (b.high - b.low) / 2 / b.value == pytest.approx(np.hypot(own, 0.049), rel=0.01)
    assert not exact.ratios
    ratios = {r.name: r for r in rough.ratios}
    assert set(ratios) == {"F_V / F_C", "M / F_C"}
    mass = ratios["M / F_C"]
    assert mass.low < MASS / F_C < mass.high
    assert (mass.high - mass.low) / 2 / mass.value < 0.01
    assert any("10 % of rated_torque" in w for w in exact.warnings)
    assert not any("10 % of rated_torque" in w for w in rough.warnings)


def test_a_card_has_the_chain_and_reads_the_next_log_with_it(tmp_path: Path) -> None:
    fit = fitted("0.64 N m ± 5 % (data sheet)")
    file = tmp_path / "card.json"
    file.write_text(fit.card().text(), encoding="utf-8")
    written = read_card(file)
    assert written.constants["rated_torque"].tolerance == pytest.approx(0.032)
    assert written.combinations["M / F_C"].verdict == "identified"
    assert written.model()[0].rig.chain == fit.rig.chain
    ((_, _, score),) = validate(written, log())
    assert score.value == pytest.approx(fit.score.value, rel=0.01)


def test_a_rig_file_has_a_drive(tmp_path: Path) -> None:
    file = tmp_path / "axis.toml"
    file.write_text(
        'kind = "forced"\n[drive]\nsignal = "A rms"\nkt = "0.5 Nm/A rms ± 5 %"\nlead = "10 mm"\n',
        encoding="utf-8",
    )
    rig = rig_file(file)
    assert rig.chain is not None
    assert rig.chain.gain == pytest.approx(0.5 * 2 * pi / 0.01)
    assert {c.name: c.shown_tolerance for c in rig.uncertain} == {"kt": pytest.approx(0.025)}
    twice = rig.set(kt=1.0).chain
    assert twice is not None
    assert twice.gain == pytest.approx(1.0 * 2 * pi / 0.01)
    file.write_text('kind = "forced"\n[drive]\nsignal = "%"\n', encoding="utf-8")
    with pytest.raises(InputError, match=r"axis\.toml: drive\.signal: '%' does not say"):
        rig_file(file)


@pytest.mark.parametrize(
    ("table", "signal", "says"),
    [
        ({}, GEAR, "the gear ratio"),  # recorded behind the gear
        ({"gear": 1.0}, 1.0, "no single factor"),
        ({}, 10.0, "10 between % and ‰"),
        ({}, 2**-0.5, "the root of 2 between rms and peak"),
        ({}, 1.5, "no single factor"),  # which is within 6 % of the root of 2
    ],
)
def test_a_factor_too_many_or_too_few_shows_in_a_known_mass(
    table: dict[str, Any], signal: float, says: str
) -> None:
    fit = identify(log(signal, mass="10 kg ± 2 %", **table), rig="forced", law="coulomb-viscous")
    (sentence,) = [v.sentence for v in fit.violations if v.condition == "constants"]
    assert "M = " in sentence
    assert says in sentence
    assert by_name(fit)["F_C"].verdict == "weak"
    assert by_name(fit)["F_C"].reason == "constants"


def test_a_known_mass_that_agrees_gives_the_scale() -> None:
    fit = fitted("0.67 N m ± 10 %", mass="10 kg ± 1 %")  # 4.7 % too high
    assert not fit.violations
    assert by_name(fit)["M"].value == pytest.approx(10.47, rel=0.01)
    (sentence,) = [w for w in fit.warnings if "the known mass asks for" in w]
    value = float(sentence.split('rated_torque = "')[1].split(" ")[0])
    assert value == pytest.approx(RATED, rel=0.01)


def test_amperes_stay_amperes_and_say_so() -> None:
    """A motor with 0.2 N m/A: its current in place of its torque."""
    chain = DriveChain.of_table({"signal": "A rms", "lead": "10 mm", "mass": "10 kg"})
    bare, percent = motion()
    current = percent / 100 * RATED * GEAR / 0.2
    fit = identify(replace(bare, force=current).through(chain), rig="forced", law="coulomb-viscous")
    per_newton = LEAD / (2 * pi) / 0.2
    estimates = by_name(fit)
    assert estimates["F_C"].value == pytest.approx(F_C * per_newton, rel=0.01)
    assert {n: estimates[n].unit for n in ("F_C", "F_V", "M")} == {
        "F_C": "A", "F_V": "A s/m", "M": "A s**2/m",
    }  # fmt: skip
    assert any("friction is in A" in n for n in fit.notes)
    (sentence,) = [w for w in fit.warnings if "the known mass asks for" in w]
    assert float(sentence.split('kt = "')[1].split(" ")[0]) == pytest.approx(0.2, rel=0.01)
    written = fit.card()
    assert written.parameters["F_C"].unit == "A"
    assert written.model()[0].rig.in_amperes
    (header,) = [f for f in export(written, "c").files.values() if b"friction in A" in f]
    assert b"N s/m" not in header
    with pytest.raises(InputError, match="friction is in A"):
        export(written, "fmu")


def test_losses_of_the_gear_are_taken_off_by_the_way_of_the_power() -> None:
    losses = (0.8, 0.7)
    stated = log(1.0, losses, efficiency="0.8", efficiency_backward="0.7")
    fit = identify(stated, rig="forced", law="coulomb-viscous")
    blind = identify(log(losses=losses), rig="forced", law="coulomb-viscous")
    assert by_name(fit)["F_C"].value == pytest.approx(F_C, rel=0.02)
    assert by_name(fit)["M"].value == pytest.approx(MASS, rel=0.02)
    assert by_name(blind)["F_C"].value > 1.2 * F_C


def test_a_chain_is_applied_once_and_is_one_for_all_logs() -> None:
    once = log()
    assert once.drive is not None
    with pytest.raises(InputError, match="apply it once"):
        once.through(once.drive)
    other = log(efficiency="0.9")
    with pytest.raises(InputError, match="another drive chain"):
        identify([once, other], rig="forced", law="coulomb-viscous")


def test_a_simulated_axis_feels_the_force_of_its_own_chain() -> None:
    t = np.linspace(0.0, 1.0, 200)
    chain = DriveChain.of_table({"signal": "A", "kt": "0.5 N m/A ± 5 %", "lead": "10 mm"})
    push = Recording(t, 1e-6 * t, force=30.0 * np.sin(6 * t))
    rig = RIGS["presliding"].behind([push.through(chain)])
    (kt,) = rig.uncertain
    moved = rig.estimated({"kt": 1.1 * kt.value})
    driven_log = push.through(chain)
    track = rig.track(driven_log, slice(20, 180), 0.0, np.ones(160))  # type: ignore[attr-defined]
    again = moved.with_constants(track, driven_log)  # type: ignore[attr-defined]
    np.testing.assert_allclose(again.inputs[2], 1.1 * track.inputs[2], rtol=1e-12)
    np.testing.assert_allclose(again.inputs[2], 33.0 * np.sin(6 * t[20:180]), rtol=1e-9, atol=1e-9)


@cache
def pendulum(weight: float, seed: int) -> Recording:
    """A log of an arm of 0.3 N m with a weight at 0.15 m, its motor's current beside it.

    0.05 N m/A behind a gear of 6; the log states weight and arm.
    """
    rng = np.random.default_rng(seed)
    t, q = sines(6.0, np.array([0.6, 0.4]), np.array([0.3, 0.7]), dt=4e-3)
    curve = coulomb_viscous(0.2, 0.05)
    extras = driven.Extras(g_sin=0.3 + weight * 9.80665 * 0.15)
    loop = driven.Loop(kp=60.0, kd=3.0, tick=4e-3)
    inertia = 0.02 + weight * 0.15**2
    motion = driven.simulate(inertia, curve, curve, loop, t, q, extras, dt=4e-3)
    table = sensors.noisy(motion._asdict(), "force", 0.02, rng)
    stated = {"mass": np.full(len(t), weight), "length": np.full(len(t), 0.15)}
    return Recording(
        table["t"], table["position"], force=table["force"] / 0.3, extra=stated, rotary=True
    )


def loaded(gear: str, **table: str) -> Fit:
    chain = DriveChain.of_table({"signal": "A", "gear": gear, **table})
    logs = [pendulum(weight, k) for k, weight in enumerate([0.0, 0.5, 1.0, 1.5, 2.0])]
    logs = [replace(log, force=chain.gain * np.asarray(log.force)) for log in logs]
    return identify(
        [log.through(chain) for log in logs], rig="forced-pendulum", law="coulomb-viscous"
    )


def test_known_loads_give_the_torque_constant() -> None:
    (sentence,) = [w for w in loaded("6").warnings if "the loads that the logs state" in w]
    value, tolerance = sentence.split('kt = "')[1].split(" N m/A")[0].split(" ± ")
    assert abs(float(value) - 0.05) < float(tolerance) < 0.003


def test_known_loads_show_a_gear_that_was_left_out() -> None:
    fit = loaded("1", kt="0.05 N m/A")
    (sentence,) = [v.sentence for v in fit.violations if "loads that 5 logs state" in v.sentence]
    assert "pull with 6." in sentence or "pull with 5.9" in sentence
    assert not any(e.verdict == "identified" for e in fit.estimates)
    right = loaded("6", kt="0.05 N m/A")
    assert not [v for v in right.violations if "loads" in v.sentence]


def test_a_simulated_axis_has_wide_levels_and_narrow_ratios(
    capsys: pytest.CaptureFixture[str],
) -> None:
    """A Dahl slide below breakaway, 1e6 N/m and 12 N, by its motor's current."""
    rng = np.random.default_rng(0)
    t = np.arange(0.0, 4.0, 0.004)
    force = (7.0 + 3.0 * np.sin(2 * t)) * np.sin(pi * t)
    motion = presliding.simulate(5.0, presliding.dahl(1e6, 12.0, 200.0), t, force, dt=0.004)
    position = motion.position + 2e-8 * rng.standard_normal(len(motion.t))
    chain = DriveChain.of_table({"signal": "A", "kt": "0.5 N m/A ± 5 %", "lead": "10 mm"})
    log = Recording(motion.t, position, force=motion.force).through(chain)
    fit = identify(log, rig="presliding", law="dahl", repeats=1, budget=1000)
    level = by_name(fit)["F_C"]
    assert (level.high - level.low) / 2 / level.value == pytest.approx(0.049, rel=0.03)
    ratio = next(r for r in fit.ratios if r.name == "sigma_0 / F_C")
    assert ratio.low < 1e6 / 12.0 < ratio.high
    assert (ratio.high - ratio.low) / 2 / ratio.value < 0.002
    show_fit(fit)
    line = next(x for x in capsys.readouterr().out.splitlines() if x.startswith("sigma_0 / F_C"))
    assert line.split()[-1] == "identified"
