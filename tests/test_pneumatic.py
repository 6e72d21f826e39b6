"""Measured cylinder seals: friction ranges, and where one slope per bar holds and where not."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from stribeck import identify, read
from stribeck.rig.cylinder import CYLINDER

DATA = Path(__file__).parents[2] / "shared" / "data" / "pneumatic"
pytestmark = pytest.mark.recordings("pneumatic")
BARS = {"O-ring257": (1, 3, 5, 7), "X-ring257": (1, 3, 5, 7), "Kidney": (1, 2, 3)}
#: Mean friction extending less retracting, N, as published with the logs.
RANGES = {
    "O-ring257": (9.17, 11.39, 13.63, 15.26),
    "X-ring257": (8.96, 12.87, 17.04, 29.73),
    "Kidney": (13.65, 21.30, 19.59),
}


def bore(seal: str) -> float:
    return 25.7 if seal.endswith("257") else 25.0


@pytest.fixture(scope="module")
def fits() -> dict[str, Any]:
    return {
        seal: identify(
            [read(DATA / f"{seal}_{bar}bar.csv") for bar in bars],
            rig=CYLINDER.set(bore=bore(seal)),
            fixed={"F_V": 0.0},
        )
        for seal, bars in BARS.items()
    }


@pytest.mark.parametrize("seal", list(BARS))
def test_the_friction_range_of_each_log_is_the_published_one(seal: str) -> None:
    rig = CYLINDER.set(bore=bore(seal))
    for bar, published in zip(BARS[seal], RANGES[seal], strict=True):
        friction_range = rig.friction_range(read(DATA / f"{seal}_{bar}bar.csv"))
        assert friction_range == pytest.approx(published, rel=0.03)


@pytest.mark.parametrize("seal", list(BARS))
def test_the_fit_prints_them(fits: dict[str, Any], seal: str) -> None:
    figures = fits[seal].balance.figures()
    for bar, published in zip(BARS[seal], RANGES[seal], strict=True):
        assert figures[f"friction_range_N {seal}_{bar}bar.csv"] == pytest.approx(
            published, rel=0.03
        )


def slope(fit: Any) -> tuple[float, float, float, str]:
    """mu_p in N/bar with its interval, and its verdict."""
    e = next(e for e in fit.estimates if e.name == "mu_p")
    return e.value * 1e5, e.low * 1e5, e.high * 1e5, e.verdict


def test_the_o_ring_rubs_in_proportion_to_pressure(fits: dict[str, Any]) -> None:
    value, low, high, _ = slope(fits["O-ring257"])
    assert low < 0.5128 < high  # least squares through the four published ranges
    assert 0.4 < low < value < high < 0.64  # no wider than with the log as the unit
    assert not any("the friction of the logs" in w for w in fits["O-ring257"].warnings)


@pytest.mark.parametrize(("seal", "published"), [("X-ring257", 1.66), ("Kidney", 1.49)])
def test_for_the_other_seals_one_slope_is_no_fact(
    fits: dict[str, Any], seal: str, published: float
) -> None:
    value, low, high, verdict = slope(fits[seal])
    assert low < published < high  # least squares through their published ranges
    assert high - value > 0.9 * value  # nothing is said beyond its order
    assert verdict != "identified"
    (warning,) = (w for w in fits[seal].warnings if "the friction of the logs" in w)
    assert "mu_p" in warning
    assert "take each log as one observation" in warning


def test_pressure_does_not_hide_in_the_offset_unsaid() -> None:
    fit = identify(read(DATA / "Kidney_2bar.csv"), rig="forced")
    assert fit.score.value < 5.0  # of a force that is nearly all pressure
    assert any("use rig cylinder" in w for w in fit.warnings)
    assert any("most of the force is the constant offset" in w for w in fit.warnings)
    assert any("too narrow to tell F_V from F_C" in w for w in fit.warnings)


def test_viscous_friction_cannot_be_told_at_one_speed() -> None:
    fit = identify(read(DATA / "O-ring257_3bar.csv"), rig=CYLINDER.set(bore=25.7))
    assert any("too narrow to tell F_V from F_C" in w for w in fit.warnings)
    assert all(e.verdict != "identified" for e in fit.estimates if e.name in ("F_C", "F_V"))
