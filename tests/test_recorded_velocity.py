"""Which velocity a force balance reads: of coarse positions, or as it was recorded."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.random import default_rng

from foreign import driven, sensors
from foreign.friction import coulomb_viscous
from foreign.strokes import sines
from stribeck import InputError, Recording, identify, read_card, select, validate
from stribeck.identify.balance.velocity_source import velocity_scale

CNC = Path(__file__).parents[2] / "shared" / "data" / "cnc" / "experiment_11.csv"


def log(step: float, noise: float) -> Recording:
    """10 kg with 20 N and 60 N s/m; positions in steps, a recorded velocity with noise, 100 Hz."""
    t, command = sines(20.0, np.array([0.08, 0.05, 0.03]), np.array([0.25, 0.6, 0.85]))
    curve = coulomb_viscous(20.0, 60.0)
    loop = driven.Loop(kp=4e4, kd=2e3, mass_ff=9.0, tick=1e-5)
    m = driven.simulate(10.0, curve, curve, loop, t, command, dt=1e-2)._asdict()
    rng = default_rng(1)
    m = sensors.noisy(sensors.noisy(m, "force", 0.5, rng), "velocity", noise, rng)
    m = sensors.quantised(m, "position", step)
    return Recording(m["t"], m["position"], velocity=m["velocity"], force=m["force"])


def sentence(fit: Any) -> str:
    (text,) = (w for w in fit.warnings if w.startswith("the recorded velocity"))
    return str(text)


def test_a_coarse_position_gives_way_to_the_velocity(tmp_path: Path) -> None:
    coarse = log(2e-3, 1e-4)
    fit = identify(coarse, rig="forced")
    assert sentence(fit).startswith("the recorded velocity is used")
    assert fit.values["F_C"] == pytest.approx(20.0, rel=0.03)
    assert fit.values["F_V"] == pytest.approx(60.0, rel=0.05)
    assert fit.values["M"] == pytest.approx(10.0, rel=0.03)
    (tmp_path / "card.json").write_text(fit.card().text())
    written = read_card(tmp_path / "card.json")
    assert written.velocity == "recorded"
    assert validate(written, coarse)[0][2].value == pytest.approx(fit.score.value)
    by_position = identify(coarse, rig="forced", velocity="position")
    assert fit.score.value < 0.8 * by_position.score.value


def test_a_fine_position_is_kept() -> None:
    fine = log(1e-7, 5e-3)
    fit = identify(fine, rig="forced")
    assert sentence(fit).startswith("the recorded velocity is not used")
    assert fit.card().velocity is None
    assert '"velocity":' not in fit.card().text()


def test_a_velocity_that_leaves_little_less_is_not_used_and_that_is_said() -> None:
    text = sentence(identify(log(1.5e-3, 1e-4), rig="forced"))
    assert text.startswith("the recorded velocity is not used")
    by_channel, by_position = (float(part.split()[-1]) for part in text.split(" %")[:2])
    assert 0.8 * by_position < by_channel < by_position
    assert "it is used below 80 % of that" in text


def test_refusals() -> None:
    fine = log(1e-7, 1e-4)
    with pytest.raises(InputError, match="give auto, recorded, position"):
        identify(fine, rig="forced", velocity="both")  # type: ignore[arg-type]
    without = Recording(fine.t, fine.position, force=fine.force)
    with pytest.raises(InputError, match="no velocity was recorded"):
        identify(without, rig="forced", velocity="recorded")
    with pytest.raises(InputError, match="is simulated"):
        identify(fine, rig="slide-bed", velocity="recorded")


@pytest.mark.recordings("cnc")
def test_a_mill_with_coarse_positions() -> None:
    """Least squares on sign and size of the recorded velocity, above 0.5 mm/s, give 4.3 A."""
    heads = CNC.read_text(encoding="utf-8").split("\n", 1)[0].split(",")
    names = ("ActualPosition", "ActualVelocity", "CurrentFeedback")
    columns = [heads.index(f"X1_{name}") for name in names]
    x, v, i = np.loadtxt(CNC, delimiter=",", skiprows=1, usecols=columns).T
    mill = Recording(np.arange(len(x)) / 10.0, 1e-3 * x, velocity=1e-3 * v, force=i)
    fit = identify(mill, rig="forced")
    assert sentence(fit).startswith("the recorded velocity is used")
    level = next(e for e in fit.estimates if e.name == "F_C")
    assert 4.1 < level.value < 4.5
    assert level.low < 4.29 < level.high


def test_laws_are_compared_with_the_velocity_that_identify_reads() -> None:
    coarse = log(2e-3, 1e-4)
    laws = ["coulomb-viscous", "stribeck"]
    kept: dict[str, Any] = {"train": "0s:12s", "holdout": "12s:20s"}
    selection = select(coarse, rig="forced", laws=laws, **kept)
    assert any(s.startswith("The recorded velocity is used") for s in selection.sentences)
    assert selection["coulomb-viscous"].fit.values["F_C"] == pytest.approx(20.0, rel=0.03)
    by_position = select(coarse, rig="forced", laws=laws, velocity="position", **kept)
    held = [s["coulomb-viscous"].held for s in (selection, by_position)]
    assert held[0] < 0.8 * held[1]
    with pytest.raises(InputError, match="is simulated: it reads no velocity"):
        select(coarse, rig="slide-bed", velocity="recorded")


@pytest.mark.parametrize("factor", [0.85, 0.95, 1.05, 1.1])
def test_a_velocity_of_another_scale_is_told_and_takes_identified_away(factor: float) -> None:
    """It explains the force better than coarse positions do, with an inertia that is off by it."""
    coarse = log(2e-3, 1e-4)
    assert coarse.velocity is not None
    other = replace(coarse, velocity=factor * coarse.velocity)
    fit = identify(other, rig="forced")
    assert f"it is {factor:.3g} times that of the position" in sentence(fit)
    mass = next(e for e in fit.estimates if e.name == "M")
    assert mass.value * factor == pytest.approx(10.0, rel=0.02)
    assert (mass.verdict, mass.reason) == ("weak", "data")


def test_a_velocity_of_the_positions_scale_is_not_told() -> None:
    for noise in (1e-4, 5e-3):
        assert "times that of the position" not in sentence(
            identify(log(2e-3, noise), rig="forced")
        )


def test_one_speed_tells_no_scale() -> None:
    """Position and way are straight lines over time then, and their ratio is that of noise."""
    t = np.arange(0.0, 10.0, 1e-2)
    rng = default_rng(3)
    v = 0.02 + 1e-4 * rng.standard_normal(len(t))
    steady = Recording(t, 0.02 * t + 1e-6 * rng.standard_normal(len(t)), velocity=v)
    assert velocity_scale(steady) == 1.0
    assert velocity_scale(log(2e-3, 1e-4)) == 1.0
    faster = log(2e-3, 1e-4)
    assert faster.velocity is not None
    assert velocity_scale(replace(faster, velocity=1.1 * faster.velocity)) == pytest.approx(
        1.1, rel=2e-3
    )
