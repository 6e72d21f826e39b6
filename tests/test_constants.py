"""Constants of a rig: what is known of them beforehand, and what a fit may say where they are not.

The logs are made by a foreign simulator, on a slide bed whose constants are its own.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from command import Completed, caller
from foreign import slide_bed
from foreign.friction import Curve
from stribeck import RIGS, Fit, InputError, Recording, identify
from stribeck.constant import COVERAGE, toleranced
from stribeck.friction import LAWS
from stribeck.identify.card import read_card
from stribeck.identify.free_constants import FreeConstantsProblem
from stribeck.rig.custom import rig_file
from stribeck.rig.simulated import as_simulated
from stribeck.rig.slide_bed import SLIDE_BED

#: Of the foreign slide: F_S, F_C in N, F_V in N s/m, v_SS in m/s.
TRUTH = Curve(130.0, 60.0, 958.3, 2e-3)
#: Constants that are of the rig's source, and rule a stick-slip log.
K_HAT, K_SPRING = 3500.0, 967.98


def log(F_fm: float, seed: int = 1, noise: float = 0.3e-3) -> Recording:
    """A ramp up on a foreign slide bed whose motor has a friction of its own."""
    bed = slide_bed.Bed(F_fm=F_fm)
    times, command = np.array([0.0, 60.0]), np.array([0.05, 0.35])
    motion = slide_bed.simulate(bed, TRUTH, TRUTH, times, command, 0.044, dt=0.02)
    rng = np.random.default_rng(seed)
    position = motion.position + noise * rng.standard_normal(len(motion.t))
    return Recording(t=motion.t, position=position, command=motion.command)


@pytest.fixture(scope="module")
def other_motor() -> Fit:
    """The default rig on a log of a machine whose motor has 15 N of friction, not 23.5 N."""
    return identify(log(15.0), rig="slide-bed", law="stribeck", repeats=1)


# --- what is known beforehand ---------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "value", "tolerance", "origin"),
    [
        ("20", 20.0, 0.0, "yours"),
        ("20±5", 20.0, 5.0, "yours"),
        ("20 +- 5", 20.0, 5.0, "yours"),
        ("2e1+/-5e-1", 20.0, 0.5, "yours"),
        ("-20±10%", -20.0, 2.0, "yours"),
        ("1e-6±2e-7", 1e-6, 2e-7, "yours"),
        ("-0.3 nameplate", -0.3, 0.03, "nameplate"),
        ("0.3 ± 5 % nameplate", 0.3, 0.015, "nameplate"),
        ("1,3 ± 0,05", 1.3, 0.05, "yours"),
        ("0,052", 0.052, 0.0, "yours"),
        ("12,5e-1", 1.25, 0.0, "yours"),
    ],
)
def test_a_value_with_a_tolerance(text: str, value: float, tolerance: float, origin: str) -> None:
    stated = toleranced(text, "--set F")
    assert stated[:2] == pytest.approx((value, tolerance))
    assert stated[2] == origin


@pytest.mark.parametrize(
    "text",
    [
        "",
        "x",
        "20±",
        "±5",
        "20±x",
        "20±-5",
        "nan",
        "20±inf",
        "20%",
        "1±2±3",
        "nameplate",
        "20 plate",
        "1,250",
        "1,2,3",
        "20,",
    ],
)
def test_what_is_no_value_with_a_tolerance(text: str) -> None:
    with pytest.raises(InputError, match="--set F: "):
        toleranced(text, "--set F")


def test_what_the_user_gives_is_exact_and_the_rest_has_a_tolerance() -> None:
    rig = SLIDE_BED.set(m=12.0, F_fm=(20.0, 5.0))
    known = {c.name: c for c in rig.constants}
    assert (known["m"].origin, known["m"].tolerance) == ("yours", 0.0)
    assert (known["F_fm"].origin, known["F_fm"].tolerance) == ("yours", 5.0)
    assert known["F_fm"].standard_deviation == 5.0 / COVERAGE
    assert known["k_hat+"].origin == "the paper"
    assert known["k_hat+"].tolerance == pytest.approx(350.0)
    assert {c.origin for c in SLIDE_BED.constants if c.tolerance} == {"the paper", "inferred"}
    assert not rig.exact().uncertain


def test_a_nameplate_has_the_tolerance_of_nameplates() -> None:
    rig = SLIDE_BED.exact().set(J_m=toleranced("4e-6 nameplate", "--set J_m"))
    (J_m,) = rig.uncertain
    assert (J_m.name, J_m.origin) == ("J_m", "nameplate")
    assert J_m.tolerance == pytest.approx(4e-7)


def test_a_setting_of_the_simulation_has_no_tolerance() -> None:
    with pytest.raises(InputError, match="step is a setting of the simulation"):
        SLIDE_BED.set(step=(1.0, 0.1))


def test_what_follows_from_a_constant_follows_its_estimate() -> None:
    rig = SLIDE_BED.estimated({"a": 11.8})
    assert rig["K_kt"] == pytest.approx(4 * SLIDE_BED["K_kt"])
    assert {c.name: c.origin for c in rig.constants}["a"] == "the paper"


def test_a_rig_file_has_tolerances(tmp_path: Path) -> None:
    file = tmp_path / "bed.toml"
    file.write_text('kind = "slide-bed"\nconstants = { F_fm = "20±5", m = 12 }\n', encoding="utf-8")
    known = {c.name: c for c in rig_file(file).constants}
    assert (known["F_fm"].shown, known["F_fm"].shown_tolerance) == (20.0, 5.0)
    assert known["m"].tolerance == 0.0
    file.write_text('kind = "slide-bed"\nconstants = { F_fm = "20+5" }\n', encoding="utf-8")
    with pytest.raises(InputError, match=r"bed\.toml: constants\.F_fm: '20\+5' is not a number"):
        rig_file(file)


# --- what a fit says ------------------------------------------------------------------------------


def test_intervals_carry_the_constants_of_another_machine(other_motor: Fit) -> None:
    truth = {"F_S": 130.0, "F_C": 60.0, "F_V": 958.3, "v_SS": 2e-3, "k_spring": K_SPRING}
    for e in other_motor.estimates:
        if e.name in truth:
            assert e.low <= truth[e.name] <= e.high, e.name
            off = abs(e.value / truth[e.name] - 1)
            assert e.verdict != "identified" or off < 0.03, e.name


def test_the_same_constants_taken_as_exact_miss_the_truth() -> None:
    """What the tolerances are for: the misfit does not tell that a constant is wrong."""
    fit = identify(log(15.0), rig=SLIDE_BED.exact(), law="stribeck", repeats=1)
    F_C = next(e for e in fit.estimates if e.name == "F_C")
    assert F_C.verdict == "identified"
    assert F_C.high < 60.0
    assert fit.score.value < 0.31


def test_what_is_taken_as_exact_is_named_with_what_it_moves() -> None:
    """The shift that the sentence tells is that between refits with gear ratios 2 % off."""
    low, middle, high = (
        identify(log(23.5), rig=SLIDE_BED.exact().set(a=a), law="stribeck", repeats=1)
        for a in (5.782, 5.9, 6.018)
    )
    (sentence,) = [w for w in middle.warnings if w.startswith("taken as exact")]
    (share,) = re.findall(r"10 % of a moves [^;]*F_C by (\d+) %", sentence)
    change = (high.values["F_C"] - low.values["F_C"]) / middle.values["F_C"] / 0.04
    assert float(share) == pytest.approx(10 * change, rel=0.2)


def test_sums_that_the_data_know_are_identified(other_motor: Fit) -> None:
    sums = {(c.parameter, c.constant): c for c in other_motor.combinations}
    motor = sums["F_C", "F_fm"]
    assert motor.low <= 60.0 + 15.0 <= motor.high
    assert motor.verdict == "identified"
    spring = sums["k_spring", "k_hat+"]
    assert spring.low <= K_SPRING + K_HAT <= spring.high
    assert spring.verdict == "identified"


def test_a_parameter_says_what_rules_it(other_motor: Fit) -> None:
    meanings = {e.name: e.meaning for e in other_motor.estimates}
    assert "it falls 1 N/mm for each N/mm of k_hat+" in meanings["k_spring"]
    assert "for each N of F_fm" in meanings["F_C"]


def test_a_constant_of_another_unit_rules_by_a_share(other_motor: Fit) -> None:
    """A slope per kg m**2 of a rotor of 4e-6 kg m**2 is a figure that nobody reads."""
    clauses = [c for e in other_motor.estimates for c in (e.meaning or "").split("; it ")[1:]]
    assert any(re.search(r"(rises|falls) [\d.]+ \S.* for 10 % of \w+ \(", c) for c in clauses)
    assert not any("e+0" in c or "kg m**2 of" in c for c in clauses)


def test_constants_that_the_data_tell_only_together_are_told_by_refits() -> None:
    """An arm whose gains are in proportion to all of its torques: their ratios alone are known."""
    rig = as_simulated(RIGS["joint"])
    law = LAWS["stribeck"]
    t = np.arange(0.0, 8.0, 8e-3)
    command = 0.6 * np.sin(0.7 * t) + 0.3 * np.sin(2.9 * t)
    truth = {"F_S": 2.0, "F_C": 1.5, "F_V": 0.5, "v_SS": 0.05, "J": 0.5, "g_sin": 4.0}
    p = np.array([truth.get(q.name, q.fixed or 0.0) for q in rig.parameters(law)])
    still = Recording(t=t, position=np.zeros(len(t)), command=command, rotary=True)
    track = rig.track(still, slice(0, len(t)), 0.0, np.ones(len(t)))
    noise = 1e-5 * np.random.default_rng(2).standard_normal(len(t))
    position = rig.positions(law, p[None], track)[0] + noise
    arm = Recording(t=t, position=position, command=command, rotary=True)

    def fitted(rig: Any) -> Fit:
        return identify(arm, rig=rig, law="stribeck", budget=400, repeats=1)

    fit = fitted(rig)
    (F_S,) = [e for e in fit.estimates if e.name == "F_S"]
    assert "which the data do not tell apart" in F_S.meaning
    assert "of its variance" not in F_S.meaning
    (sentence,) = [w for w in fit.warnings if w.startswith("what each constant does")]
    base = fitted(rig.exact()).values["F_S"]
    for name, value in (("kp", 101.0), ("kd", 5.05)):
        (told,) = re.findall(rf"10 % of {name} moves [^;]*F_S by (-?[\d.]+) N m", sentence)
        refit = fitted(rig.exact().set(**{name: value})).values["F_S"]
        assert float(told) == pytest.approx(10 * (refit - base), rel=0.3)


def test_one_warning_names_the_constants_of_the_source(other_motor: Fit) -> None:
    (warning,) = [w for w in other_motor.warnings if "not of this axis" in w]
    for name in ("F_fm = 23.5 ± 12 N", "k_hat+ = 3.5 ± 0.35 N/mm", "m = 10.9 ± 1.1 kg"):
        assert name in warning
    assert "k_hat-" not in warning  # the ramp never pulls that way


def test_the_right_constants_narrow_the_intervals() -> None:
    fit = identify(log(15.0), rig=SLIDE_BED.set(F_fm=15.0).exact(), law="stribeck", repeats=1)
    F_C = next(e for e in fit.estimates if e.name == "F_C")
    assert F_C.verdict == "identified"
    assert F_C.low <= 60.0 <= F_C.high
    assert not fit.combinations
    assert not any("not of this axis" in w for w in fit.warnings)


def test_a_constant_that_the_data_know_better_is_estimated() -> None:
    """A given gain that is 8 % off with a tolerance of 20 %: the sum with the spring stays."""
    rig = SLIDE_BED.exact().set(**{"k_hat+": (3.8, 0.76)})
    fit = identify(log(23.5), rig=rig, law="stribeck", repeats=1)
    assert isinstance(fit.residuals, FreeConstantsProblem)
    (spring,) = [c for c in fit.combinations if c.parameter == "k_spring"]
    assert spring.low <= K_SPRING + K_HAT <= spring.high


def test_the_card_lists_all_constants_and_gives_the_same_rig_back(
    other_motor: Fit, tmp_path: Path
) -> None:
    file = tmp_path / "card.json"
    file.write_text(other_motor.card().text(), encoding="utf-8")
    entries = json.loads(file.read_text(encoding="utf-8"))["constants"]
    assert entries["F_fm"]["origin"] == "inferred"
    assert entries["F_fm"]["tolerance"] == pytest.approx(11.75)
    assert entries["k_hat+"] | {"value": 0} == {
        "value": 0, "unit": "N/mm", "origin": "the paper", "tolerance": pytest.approx(0.35),
    }  # fmt: skip
    parameters, p = read_card(file).model()
    assert p == pytest.approx(other_motor.p, rel=1e-12)
    for ours, theirs in zip(parameters.rig.constants, other_motor.rig.constants, strict=True):
        assert ours.value == pytest.approx(theirs.value, rel=1e-14), ours.name
        assert ours.tolerance == pytest.approx(theirs.tolerance), ours.name


# --- the command line -----------------------------------------------------------------------------


@pytest.fixture
def run(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Callable[..., Completed]:
    return caller(monkeypatch, capsys)


def test_a_tolerance_for_a_parameter_is_refused(
    run: Callable[..., Completed], tmp_path: Path
) -> None:
    recording = log(15.0)
    assert recording.command is not None
    rows = np.column_stack([recording.t, recording.position, recording.command])
    heads = "time [s],position [m],command [m]"
    np.savetxt(tmp_path / "log.csv", rows, delimiter=",", header=heads, comments="")
    identify_it = ("identify", str(tmp_path / "log.csv"), "--rig", "slide-bed")
    completed = run(*identify_it, "--set", "F_C=60±5")
    assert completed.status == 2
    assert "--set F_C: '60±5' is not a number" in completed.err
    completed = run(*identify_it, "--set", "F_fm=20±x")
    assert completed.status == 2
    assert "--set F_fm: '20±x' is not a number, nor VALUE±TOLERANCE" in completed.err


@pytest.mark.parametrize("name", list(RIGS))
def test_every_constant_says_who_vouches_for_it(name: str) -> None:
    for c in RIGS[name].constants:
        assert c.source, c.name
        assert (c.tolerance > 0) <= (c.origin in ("the paper", "inferred", "example")), c.name
