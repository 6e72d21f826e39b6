"""Loops below breakaway: parameters that a contact law identifies from them, and others."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest

import interval_axes
from foreign_axes import noisy, recordings
from stribeck import Fit, Recording, identify, read, select, validate
from stribeck.data.repeated_samples import is_new
from stribeck.friction import law_named
from stribeck.friction.orders import orders
from stribeck.identify.parameters import partition
from stribeck.identify.sliding_check import never_slid
from stribeck.rig.presliding import PRESLIDING
from stribeck.space import Array

ROOT = Path(__file__).parents[1]
DATA = ROOT.parent / "shared" / "data" / "direct_drive"
RIG = str(ROOT / "benchmarks" / "direct_drive.toml")
#: The range in which a loop has settled, and the inertia as published.
SETTLED, FIXED = "2s:11s", {"J": 2.519}
real = pytest.mark.recordings("direct_drive")


@cache
def loops(k: int) -> Recording:
    return read(DATA / f"sig0_j1_6_exp{k}.csv")


@cache
def fit_of(law: str) -> Fit:
    """The fit to the second log, with the others held out."""
    return identify(loops(2), rig=RIG, law=law, train=SETTLED, fixed=FIXED)


def relative(fit: Fit, k: int) -> float:
    """Error of the angle on a log, as a share of its standard deviation."""
    ((_, _, score),) = validate(fit, loops(k), SETTLED)
    log = loops(k)
    counts = (log.t >= 2.0) & is_new(log)
    return score.value * 1e-3 / float(np.std(log.position[counts]))  # shown in mrad


@real
def test_blocks_on_springs_follow_loops_of_other_logs_and_one_bristle_does_not() -> None:
    # What others found with the same laws and a search of their own: 0.12 for Dahl and LuGre,
    # 0.043 and then 0.061 and 0.046 for two blocks with a viscous term.
    dahl = [relative(fit_of("dahl"), k) for k in (1, 2, 3)]
    blocks = [relative(fit_of("maxwell-slip:2"), k) for k in (1, 2, 3)]
    assert np.allclose(dahl, 0.12, atol=0.01)
    assert blocks[1] < 0.043
    assert max(blocks) < 0.061
    assert max(blocks) < min(dahl) / 2


@real
def test_the_same_law_is_selected() -> None:
    selection = select(
        loops(2), rig=RIG, laws=["dahl", "maxwell-slip:2"], train=SETTLED,
        test=[loops(1), loops(3)], fixed=FIXED, budget=1500,
    )  # fmt: skip
    assert selection.law == "maxwell-slip:2"


@real
def test_what_loops_show_and_what_they_do_not() -> None:
    estimates = {e.name: e for e in fit_of("maxwell-slip:2").estimates}
    assert estimates["W_1"].verdict == estimates["W_2"].verdict == "identified"
    # The first block slips within four steps of the encoder.
    assert estimates["d_1"].verdict == "weak"
    estimates = {e.name: e for e in fit_of("lugre").estimates}
    assert estimates["v_s"].verdict == "not identifiable"
    assert estimates["F_C"].verdict != "identified"
    assert estimates["F_C"].low == 0.0  # whatever is below F_S will do
    stiffness = estimates["sigma_0"]
    assert stiffness.low < 0.9 * stiffness.value < 1.02 * stiffness.value < stiffness.high


@real
def test_that_it_never_slid_is_told() -> None:
    warnings = {law: [w for w in fit_of(law).warnings if "never slid" in w] for law in
            ("dahl", "lugre", "maxwell-slip:2")}  # fmt: skip
    head = "the axis never slid: "
    assert warnings["dahl"] == [head + "F_C cannot be known from this log"]
    assert warnings["lugre"] == [head + "F_S, F_C and v_s cannot be known from this log"]
    assert warnings["maxwell-slip:2"] == [head + "the levels W_i do not add up to its breakaway"]


# --- simulated logs -----------------------------------------------------------------------------


def simulated_log(F: Array, seconds: float = 8.0) -> Recording:
    """2 kg on a LuGre contact, 12 N Coulomb, 18 N static, under a force; rounded to 10 nm."""
    t = np.linspace(0.0, seconds, len(F))
    log = Recording(t, np.zeros(len(t)), velocity=np.zeros(len(t)), force=F)
    p = np.array([1.2e6, 600.0, 18.0, 12.0, 2e-2, 50.0, 2.0, 0.0])
    x = PRESLIDING.simulate(law_named("lugre"), p, log).position[0]
    return Recording(t, np.round(x, 8), velocity=np.zeros(len(t)), force=F)


CYCLES = np.sin(2 * np.pi * np.linspace(0.0, 5.0, 800))
RAMP = np.clip(np.linspace(-0.1, 1.0, 800), 0.0, 1.0)


def test_an_axis_that_slides_shows_its_levels_and_one_that_is_held_does_not() -> None:
    parameters = partition(PRESLIDING, law_named("lugre"))
    for shape in (CYCLES, RAMP):
        stuck, slid = simulated_log(9.0 * shape), simulated_log(24.0 * shape)
        assert never_slid(parameters, [stuck]) == [
            "the axis never slid: F_S, F_C and v_s cannot be known from this log"
        ]
        assert "these logs" in never_slid(parameters, [stuck, stuck])[0]
        assert never_slid(parameters, [slid]) == never_slid(parameters, [stuck, slid]) == []


def test_only_what_is_searched_is_told() -> None:
    stuck = simulated_log(9.0 * CYCLES)
    lugre = partition(PRESLIDING, law_named("lugre"), fixed={"F_C": 12.0, "v_s": 0.02})
    assert never_slid(lugre, [stuck])[0].endswith("never slid: F_S cannot be known from this log")
    gms = partition(PRESLIDING, law_named("gms:2"))
    (message,) = never_slid(gms, [stuck])
    assert message.endswith(
        "tau cannot be known from this log; the levels W_i do not add up to its breakaway"
    )
    free = {"M": 2.0, "F_C": 12.0}
    assert never_slid(partition(PRESLIDING, law_named("dahl"), fixed=free), [stuck]) == []


@pytest.mark.parametrize(
    ("law", "pairs"),
    [
        ("lugre", {("F_S", "F_C")}),
        ("elasto-plastic", {("F_S", "F_C")}),
        ("makkar", {("g2", "g3")}),
        ("maxwell-slip", set()),
    ],
)
def test_what_must_be_above_what_is_asked_of_every_parameter(
    law: str, pairs: set[tuple[str, str]]
) -> None:
    # A refit that breaks such an order cannot be run, and its interval would have no width.
    names = law_named(law).names
    assert {(names[i], names[j]) for i, j in orders(law_named(law), nonlinear=True)} == pairs


def test_a_level_that_may_be_the_other_one_is_not_identified() -> None:
    """A foreign log without a drop: that level is called F_C beside a drop below all speeds."""
    axis = interval_axes.lugre(32)
    logs = recordings(axis, noisy(axis, np.random.default_rng(32)))
    fit = identify(logs, rig=PRESLIDING.set(**axis.given), law="lugre")
    by_name = {e.name: e for e in fit.estimates}
    F_S, F_C, v_s = (by_name[name] for name in ("F_S", "F_C", "v_s"))
    assert v_s.low_ended == "bound"
    assert F_C.verdict == "weak"
    assert "v_s may be at an end of its range" in F_C.meaning
    assert F_S.verdict == "identified"
    assert F_S.low < axis.truth["F_S"] < F_S.high
