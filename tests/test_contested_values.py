"""Values that a caller sets, against logs that hold other ones."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from stribeck import Fit, identify
from stribeck.data.recording import Recording
from test_nested_laws import PLAIN, RIG, log_of

TRUTH = {"F_C": 20.0, "F_V": 30.0, "M": 18.0, "offset": 1.0}


def force_log(seed: int, noise: float) -> Recording:
    """Three sines, and the force that they take: no integrator, no filter."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, 10.0, 1e-3)
    sines = [(w, a, rng.uniform(0, 6)) for w, a in ((1.9, 0.15), (4.8, 0.05), (12.0, 0.01))]
    x = sum(a * np.sin(w * t + shift) for w, a, shift in sines)
    v = sum(a * w * np.cos(w * t + shift) for w, a, shift in sines)
    a = -sum(a * w**2 * np.sin(w * t + shift) for w, a, shift in sines)
    force = TRUTH["M"] * a + TRUTH["F_C"] * np.sign(v) + TRUTH["F_V"] * v + TRUTH["offset"]
    force += noise * rng.standard_normal(len(t))
    return Recording(t=t, position=np.round(x / 1e-5) * 1e-5, force=force)


def contests(fit: Fit) -> list[str]:
    return [w for w in fit.warnings if " is set to " in w]


def verdicts(fit: Fit) -> dict[str, str]:
    return {e.name: e.verdict for e in fit.estimates}


@pytest.mark.parametrize("noise", [0.3, 3.0])
@pytest.mark.parametrize(("name", "value"), [("M", 12.0), ("F_V", 50.0), ("F_C", 14.0)])
def test_a_force_contests_a_wrong_value_and_says_what_it_gives(
    name: str, value: float, noise: float
) -> None:
    fit = identify(force_log(1, noise), rig="forced", law="coulomb-viscous", fixed={name: value})
    (told,) = contests(fit)
    words = told.split()
    assert words[:5] == [name, "is", "set", "to", f"{value:.4g}"]
    instead = float(told.split("the data give ")[1].split()[0])
    assert instead == pytest.approx(TRUTH[name], rel=0.02)
    # What it leaves over is the value's doing: no other law or sensor is advised.
    assert not [w for w in fit.warnings if "the model leaves over" in w]


def test_what_bends_around_a_wrong_value_is_not_identified() -> None:
    fit = identify(force_log(2, 3.0), rig="forced", law="coulomb-viscous", fixed={"F_V": 36.0})
    (told,) = contests(fit)
    assert "F_C may be 20" in told
    assert verdicts(fit)["F_C"] == "weak"


@pytest.mark.parametrize("name", TRUTH)
def test_a_force_does_not_contest_a_true_value(name: str) -> None:
    for seed, noise in ((0, 0.3), (1, 3.0), (2, 10.0)):
        fit = identify(
            force_log(seed, noise), rig="forced", law="coulomb-viscous", fixed={name: TRUTH[name]}
        )
        assert contests(fit) == []


def test_a_force_without_noise_contests_no_true_value() -> None:
    """Its error is rounding, and so is what a value that is free differs by."""
    log = force_log(4, 0.0)
    x = np.sin(1.9 * log.t)
    log = Recording(
        t=log.t, position=x, force=-18.0 * 1.9**2 * x + 30.0 * 1.9 * np.cos(1.9 * log.t)
    )
    for fixed in ({"M": 18.0, "F_C": 0.0}, {"F_V": 30.0, "offset": 0.0}):
        assert contests(identify(log, rig="forced", law="coulomb-viscous", fixed=fixed)) == []


@pytest.mark.recordings("emps")
@pytest.mark.parametrize(
    ("name", "published", "wrong"), [("M", 95.1089, 90.0), ("F_C", 20.3935, 25.0)]
)
def test_a_real_axis_contests_what_is_not_published_of_it(
    name: str, published: float, wrong: float
) -> None:
    log = Path(__file__).parents[2] / "shared" / "data" / "emps" / "DATA_EMPS.mat"
    fits = [
        identify(log, rig="emps", law="coulomb-viscous", fixed={name: value})
        for value in (published, wrong)
    ]
    assert contests(fits[0]) == []
    (told,) = contests(fits[1])
    instead = float(told.split("the data give ")[1].split()[0])
    assert instead == pytest.approx(published, rel=1e-3)


@pytest.mark.parametrize(("value", "times"), [(30.0, 0), (45.0, 1)])
def test_a_table_of_steady_speeds_contests_a_wrong_value_alone(value: float, times: int) -> None:
    speeds = np.repeat(np.linspace(0.01, 0.4, 15), 2) * np.tile([1.0, -1.0], 15)
    force = 20.0 * np.sign(speeds) + 30.0 * speeds + np.random.default_rng(0).normal(0.0, 0.1, 30)
    table = {"velocity_m_s": speeds, "force_N": force}
    fit = identify(table, rig="forced", law="coulomb-viscous", fixed={"F_V": value, "M": 12.0})
    told = contests(fit)
    assert len(told) == times
    assert all("F_V is set to 45 N s/m, and the data give 29.9" in w for w in told)


def test_a_force_says_nothing_of_a_value_that_it_cannot_tell() -> None:
    """One slow sine accelerates so little that any mass explains it."""
    t = np.arange(0.0, 60.0, 1e-2)
    v = 0.02 * np.sin(0.2 * t)
    force = 20.0 * np.sign(v) + 30.0 * v + np.random.default_rng(0).standard_normal(len(t))
    log = Recording(t=t, position=0.1 * (1 - np.cos(0.2 * t)), force=force)
    assert contests(identify(log, rig="forced", law="coulomb-viscous", fixed={"M": 12.0})) == []


@pytest.mark.parametrize(
    ("name", "wrong", "truth"), [("armature", 1.5e-3, 1e-3), ("k_t", 0.5, 0.4), ("F_C", 0.02, 0.03)]
)
def test_a_motion_contests_a_wrong_value(name: str, wrong: float, truth: float) -> None:
    """Masses that are known to a few percent would bend beyond all tolerance to make up for it."""
    log = log_of(PLAIN)
    (told,) = contests(identify(log, rig=RIG, law="coulomb-viscous", fixed={name: wrong}))
    instead = float(told.split("the data give ")[1].split()[0])
    assert instead == pytest.approx(truth, rel=0.01)
    assert contests(identify(log, rig=RIG, law="coulomb-viscous", fixed={name: truth})) == []


def test_what_rests_on_a_value_that_is_set_is_named_with_its_share() -> None:
    """The share is that between fits to one log at two values."""
    log = force_log(3, 3.0)
    told, levels = [], []
    for value in (29.7, 30.3):
        fit = identify(log, rig="forced", law="coulomb-viscous", fixed={"F_V": value})
        told += [w for w in fit.warnings if w.startswith("taken as exact")]
        levels.append(fit.estimates[0].value)
    assert len(told) == 2
    share = float(told[0].split("10 % of F_V moves F_C by ")[1].split()[0])
    moved = (levels[1] - levels[0]) / TRUTH["F_C"] / (0.6 / TRUTH["F_V"])
    assert share == pytest.approx(10 * moved, rel=0.05)


def test_what_rests_on_a_value_of_a_motion_is_named() -> None:
    log = log_of(PLAIN)
    truth, levels = 0.4, []
    for value in (0.99 * truth, 1.01 * truth):
        fit = identify(log, rig=RIG.exact(), law="coulomb-viscous", fixed={"k_t": value})
        levels.append(next(e.value for e in fit.estimates if e.name == "R"))
    (told,) = (w for w in fit.warnings if w.startswith("taken as exact"))
    share = float(told.split("10 % of k_t moves ")[1].split("R by ")[1].split()[0])
    assert share == pytest.approx(10 * (levels[1] / levels[0] - 1) / 0.02, rel=0.1)
