"""A direct-drive joint: breakaway of eleven torque ramps, stiffness of three loops."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from stribeck.data import check, read
from stribeck.data.breakaway import levels, presliding, ramps

DATA = Path(__file__).parents[2] / "shared" / "data" / "direct_drive"
pytestmark = pytest.mark.recordings("direct_drive")


@pytest.mark.parametrize(
    ("file", "level"),
    [
        ("05", 10.31), ("05_exp1", 10.41), ("05_exp2", 11.48), ("05_exp3", 10.26),
        ("05_exp4", 9.53), ("n05", -11.84), ("n05_exp1", -11.71), ("n05_exp2", -11.87),
        ("n05_exp3", -11.98), ("n05_exp4", -11.57),
    ],
)  # fmt: skip
def test_the_breakaway_of_each_ramp(file: str, level: float) -> None:
    (ramp,) = ramps(read(DATA / f"est_j1_{file}.csv"))
    assert ramp.by_speed == pytest.approx(level, abs=0.01)
    assert abs(ramp.rate) == pytest.approx(0.5, rel=1e-3)
    # The authors' files lie between 9.5 and 12 N m whatever is called breakaway.
    assert all(9.4 <= abs(x) <= 12.1 for x in ramp.levels)
    assert len(ramp.levels) == 2


def test_one_ramp_ends_before_breakaway() -> None:
    (ramp,) = ramps(read(DATA / "est_j1_05_exp.csv"))
    assert ramp.by_speed is None
    assert ramp.reached == pytest.approx(10.07, abs=0.01)
    quality = dict(check(read(DATA / "est_j1_05_exp.csv")).lines())
    assert quality["breakaway"].startswith("none below 10.07 N m")


def test_all_ramps_together_are_the_authors_mean_and_spread() -> None:
    up, down = levels([read(f) for f in sorted(DATA.glob("est_*.csv"))])
    assert (len(up.values), len(down.values)) == (5, 5)
    assert up.censored == pytest.approx((10.07,), abs=0.01)
    assert up.mean == pytest.approx(10.75, rel=0.05)  # theirs, over four of them
    assert down.mean == pytest.approx(12.0, rel=0.05)
    assert up.low == pytest.approx(9.53, abs=0.01)
    assert down.high == pytest.approx(11.98, abs=0.01)


def test_the_stiffness_by_the_authors_definition() -> None:
    stiffnesses = [presliding(read(DATA / f"sig0_j1_6_exp{k}.csv")) for k in (1, 2, 3)]
    halves = [cycle.half for cycle in stiffnesses if cycle is not None]
    assert len(halves) == 3
    assert np.mean(halves) == pytest.approx(20809.4, rel=1e-3)
    assert np.mean(halves) == pytest.approx(21419.0, rel=0.05)  # as they print it
    assert [cycle.cycles for cycle in stiffnesses if cycle is not None] == [4, 4, 4]


@pytest.mark.parametrize("file", sorted(f.name for f in DATA.glob("*.csv")))
def test_no_log_is_called_stick_slip_or_good_for_a_force_balance(file: str) -> None:
    quality = check(read(DATA / file))
    assert not any("stick-slip present" in line for line in quality.verdict)
    assert not any("hardly any stick-slip" in line for line in quality.verdict)
    assert any("no force balance is possible" in line for line in quality.verdict)
    assert not any("road is open" in line for line in quality.verdict)
    assert bool(quality.breakaways) == file.startswith("est")
    assert (quality.presliding is not None) == file.startswith("sig0")
