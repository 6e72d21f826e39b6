"""Loops below breakaway: what a contact's law finds in them, and what no law can."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from stribeck import Fit, Recording, identify, read, select, validate
from stribeck.data.hold import fresh

ROOT = Path(__file__).parents[1]
DATA = ROOT.parent / "shared" / "data" / "direct_drive"
RIG = str(ROOT / "benchmarks" / "direct_drive.toml")
#: From where on a loop has settled, and the inertia that the authors give.
SETTLED, KNOWN = "2s:11s", {"J": 2.519}
real = pytest.mark.skipif(
    not DATA.exists(), reason="the direct-drive logs are not beside the repository"
)


@cache
def loops(k: int) -> Recording:
    return read(DATA / f"sig0_j1_6_exp{k}.csv")


@cache
def fitted(law: str) -> Fit:
    """On the second log, with the others held out."""
    return identify(loops(2), rig=RIG, law=law, train=SETTLED, fixed=KNOWN)


def relative(fit: Fit, k: int) -> float:
    """Error of the angle on a log, as a share of its standard deviation."""
    ((_, _, score),) = validate(fit, loops(k), SETTLED)
    log = loops(k)
    counts = (log.t >= 2.0) & fresh(log)
    return score.value * 1e-3 / float(np.std(log.position[counts]))  # shown in mrad


@real
def test_blocks_on_springs_follow_loops_of_other_logs_and_one_bristle_does_not() -> None:
    # What others found with the same laws and a search of their own: 0.12 for Dahl and LuGre,
    # 0.043 and then 0.061 and 0.046 for two blocks with a viscous term.
    dahl = [relative(fitted("dahl"), k) for k in (1, 2, 3)]
    blocks = [relative(fitted("maxwell-slip:2"), k) for k in (1, 2, 3)]
    assert np.allclose(dahl, 0.12, atol=0.01)
    assert blocks[1] < 0.043
    assert max(blocks) < 0.061
    assert max(blocks) < min(dahl) / 2


@real
def test_the_same_law_is_selected() -> None:
    found = select(
        loops(2), rig=RIG, laws=["dahl", "maxwell-slip:2"], train=SETTLED,
        test=[loops(1), loops(3)], fixed=KNOWN, budget=1500,
    )  # fmt: skip
    assert found.law == "maxwell-slip:2"


@real
def test_what_loops_show_and_what_they_do_not() -> None:
    said = {e.name: e for e in fitted("maxwell-slip:2").estimates}
    assert said["W_1"].verdict == said["W_2"].verdict == "identified"
    # The first block slips within four steps of the encoder.
    assert said["d_1"].verdict == "weak"
    said = {e.name: e for e in fitted("lugre").estimates}
    assert said["F_C"].verdict == said["v_s"].verdict == "not identifiable"
    stiffness = said["sigma_0"]
    assert stiffness.low < 0.9 * stiffness.value < 1.02 * stiffness.value < stiffness.high


@real
def test_that_it_never_slid_is_told() -> None:
    told = {law: [w for w in fitted(law).warnings if "never slid" in w] for law in
            ("dahl", "lugre", "maxwell-slip:2")}  # fmt: skip
    head = "the axis never slid: "
    assert told["dahl"] == [head + "F_C cannot be known from this log"]
    assert told["lugre"] == [head + "F_S, F_C and v_s cannot be known from this log"]
    assert told["maxwell-slip:2"] == [head + "the levels W_i do not add up to its breakaway"]
