"""Friction tables for drives: their error and the places of their points."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize

from exported import model_of
from stribeck.errors import InputError
from stribeck.export.drive_table import DirectionTable, table, text


def off(side: DirectionTable, v: np.ndarray, expected: np.ndarray) -> float:
    """The greatest error of linear interpolation, as in a drive."""
    return float(np.abs(np.interp(v, side.speeds, side.levels) - expected).max())


@pytest.mark.parametrize("law", ["stribeck", "stribeck-rational", "makkar", "lugre", "gms"])
@pytest.mark.parametrize("points", [5, 16, 20])
def test_the_stated_error_is_that_of_a_fine_look_at_the_curve(law: str, points: int) -> None:
    model = model_of(law)
    lookup = table(model, points, 0.1)
    v = np.concatenate([0.1 * np.geomspace(1e-4, 1.0, 20_001), np.linspace(0.0, 0.1, 20_001)])
    expected = model.law.friction(v, model.p)
    assert len(lookup.plus.speeds) <= points
    assert lookup.plus.speeds[0] == 0.0
    assert lookup.plus.speeds[-1] == pytest.approx(0.1)
    assert off(lookup.plus, v, expected) == pytest.approx(lookup.plus.worst, rel=0.03)


@pytest.mark.parametrize("law", ["stribeck", "stribeck-rational", "lugre"])
def test_no_drive_finds_more_than_the_stated_error(law: str) -> None:
    model = model_of(law)
    lookup = table(model, 20, 0.1)
    v = np.concatenate([0.1 * np.geomspace(1e-4, 1.0, 300_001), np.linspace(0.0, 0.1, 300_001)])
    worst = off(lookup.plus, v, model.law.friction(v, model.p))
    assert worst == pytest.approx(lookup.plus.worst, rel=2e-4)


@pytest.mark.parametrize("points", [5, 16, 20])
def test_points_stand_where_evenly_spaced_ones_would_be_many_times_worse(points: int) -> None:
    model = model_of("stribeck")
    lookup = table(model, points, 0.1)
    v = np.linspace(0.0, 0.1, 40_001)
    expected = model.law.friction(v, model.p)
    evenly = np.linspace(0.0, 0.1, points)
    plain = np.abs(np.interp(v, evenly, model.law.friction(evenly, model.p)) - expected).max()
    assert off(lookup.plus, v, expected) < 0.25 * plain


def test_a_search_from_the_table_finds_hardly_a_better_one() -> None:
    model = model_of("stribeck")
    lookup = table(model, 4, 0.1)
    v = np.concatenate([0.1 * np.geomspace(1e-4, 1.0, 2_001), np.linspace(0.0, 0.1, 2_001)])
    v.sort()
    expected = model.law.friction(v, model.p)
    scale = lookup.plus.speeds[1:3], lookup.plus.levels

    def worst(x: np.ndarray) -> float:
        inner = scale[0] * np.exp(x[:2])
        if not 0.0 < inner[0] < inner[1] < 0.1:
            return 1e9
        levels = scale[1] * np.exp(x[2:])
        return float(np.abs(np.interp(v, [0.0, *inner, 0.1], levels) - expected).max())

    best = minimize(
        worst,
        np.zeros(6),
        method="Nelder-Mead",
        options={"maxiter": 4000, "maxfev": 4000, "xatol": 1e-9, "fatol": 1e-9},
    )
    assert best.fun > 0.9 * lookup.plus.worst


def test_a_straight_law_has_no_error_and_directions_have_tables_of_their_own() -> None:
    straight = table(model_of("coulomb-viscous"), 2, 0.1)
    assert straight.symmetric
    assert straight.plus.worst == pytest.approx(0.0, abs=1e-9)
    model = model_of("coulomb-viscous-directional")
    lookup = table(model, 3, 0.1)
    assert not lookup.symmetric
    for side, sign in ((lookup.plus, 1.0), (lookup.minus, -1.0)):
        expected = sign * model.law.friction(sign * side.speeds[1:], model.p)
        assert side.levels[1:] == pytest.approx(expected, rel=1e-9)
    assert not np.allclose(lookup.plus.levels, lookup.minus.levels, rtol=1e-3)


def test_the_file_reads_back_as_the_table_and_states_its_error() -> None:
    model = model_of("stribeck")
    lookup = table(model, 16, 0.1)
    file = text(model, lookup)
    lines = [line for line in file.splitlines() if not line.startswith("#")]
    read = np.array([[float(x) for x in line.split(",")] for line in lines[1:]])
    assert lines[0] == "speed / (mm/s),friction / (N)"
    assert read[:, 0] == pytest.approx(1e3 * lookup.plus.speeds, rel=1e-8)
    assert read[:, 1] == pytest.approx(lookup.plus.levels, rel=1e-8)
    assert f"greatest error {lookup.plus.worst:.3g} N" in file
    assert "SI throughout, but for the speeds of the table: mm/s." in file


@pytest.mark.parametrize(
    ("law", "lost"),
    [
        ("lugre", "presliding and its memory"),
        ("bam-m4", "drive, external"),
        ("stribeck+temperature", "temperature"),
    ],
)
def test_what_a_table_cannot_hold_is_said(law: str, lost: str) -> None:
    model = model_of(law)
    assert lost in text(model, table(model, 5, 0.1))


@pytest.mark.parametrize("points", [-1, 0, 1, 1001])
def test_numbers_of_points_that_make_no_table(points: int) -> None:
    with pytest.raises(InputError, match="2 to 1000 points"):
        table(model_of("stribeck"), points, 0.1)


@pytest.mark.parametrize("fastest", [0.0, -1.0, float("nan"), float("inf")])
def test_speeds_that_make_no_table(fastest: float) -> None:
    with pytest.raises(InputError, match="above 0"):
        table(model_of("stribeck"), 5, fastest)
