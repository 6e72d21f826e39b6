"""Channels at other instants: what is exact, what a tone keeps, and where lines are straight."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from stribeck import identify, read
from stribeck.data.resampling import averaged, interpolated
from stribeck.space import Array


def kept_of_a_tone(of: Array, t: Array, w: float) -> float:
    """The amplitude of sin(w t) in a channel."""
    return float(np.linalg.lstsq(np.column_stack([np.sin(w * t), np.cos(w * t)]), of)[0][0])


def test_polynomials_of_degree_5_are_exact_on_an_uneven_clock() -> None:
    rng = np.random.default_rng(1)
    t = np.cumsum(rng.uniform(0.7, 1.3, 40))
    curve = np.polynomial.Polynomial.fromroots([3.0, 8.0, 15.0, 22.0, 31.0]) * 1e-4
    at = np.linspace(t[0], t[-1], 501)
    np.testing.assert_allclose(interpolated(at, t, curve(t)), curve(at), rtol=1e-9, atol=1e-8)
    np.testing.assert_array_equal(interpolated(t, t, curve(t)), curve(t))


def test_lines_are_straight_where_six_samples_are_missing() -> None:
    """Beyond the ends, beside a gap, samples that all but coincide, and one that is no number."""
    t = np.arange(60.0)
    t[20:] += 5.0
    t[40] = t[39] + 1e-3
    y = np.sin(t)
    y[52] = np.nan
    at = np.linspace(-2.0, t[-1] + 2.0, 3001)
    ours, lines = interpolated(at, t, y), np.interp(at, t, y)
    same = (ours == lines) | (np.isnan(ours) & np.isnan(lines))
    between = np.searchsorted(t, at, side="right") - 1
    straight = {-1, 17, 18, 19, 20, 21, 37, 38, 39, 40, 41, 42, *range(49, 55), 59}
    for k in range(-1, 60):
        inside = (between == k) & ~np.isin(at, t)
        assert same[inside].all() == (k in straight), k


@pytest.mark.parametrize(("share", "lost"), [(1 / 16, 2e-5), (1 / 8, 1e-3)])
def test_a_tone_keeps_what_straight_lines_lose(share: float, lost: float) -> None:
    t, w = np.arange(3000.0), 2 * np.pi * share
    at = np.arange(1600, 16 * 2990, dtype=float) / 16
    ours = kept_of_a_tone(interpolated(at, t, np.sin(w * t)), at, w)
    lines = kept_of_a_tone(np.interp(at, t, np.sin(w * t)), at, w)
    assert ours == pytest.approx(1.0, abs=lost)
    assert 1.0 - lines > 50 * lost


@pytest.mark.parametrize("faster", [1.6, 2.5, 8.0])
def test_a_slower_clock_keeps_what_is_slow_and_loses_what_is_fast(faster: float) -> None:
    t, grid = np.arange(0.0, 2000.0, 1 / faster), np.arange(8.0, 1990.0)
    slow = 2 * np.pi / 16
    assert kept_of_a_tone(averaged(grid, t, np.sin(slow * t))[4:-4], grid[4:-4], slow) == (
        pytest.approx(1.0, abs=2e-4)
    )
    if faster > 2.0:  # above half of its own rate it would be another tone already
        fast = averaged(grid, t, np.sin(2 * np.pi * 0.9 * t))
        assert np.std(fast) < 0.2 * np.std(np.sin(2 * np.pi * 0.9 * grid))


def test_means_stay_means_where_a_grid_is_uneven() -> None:
    grid = np.cumsum(np.tile([1.0, 1.5], 50))
    t = np.arange(0.0, 130.0, 0.01)
    means = averaged(grid, t, t**2)
    # (b^3 - a^3) / 3 over (b - a), of edges in the middle between instants
    edges = 0.5 * (grid[1:] + grid[:-1])
    np.testing.assert_allclose(means[1:-1], np.diff(edges**3) / 3 / np.diff(edges), rtol=1e-7)


@pytest.mark.parametrize("every", [2, 8, 16])
def test_a_slower_force_keeps_the_mass_and_the_friction(every: int, tmp_path: Path) -> None:
    """Straight lines make of 85 kg 85.0, 84.7 and 83.6, surely."""
    t = np.arange(20_000) / 1000.0
    x, v, a = np.zeros((3, len(t)))
    for f in (0.31, 0.83, 1.7, 3.1, 4.7, 7.3):
        w, size = 2 * np.pi * f, 0.08 * np.exp(-0.25 * f) / f
        x += size * np.sin(w * t + 1.3 * f)
        v += size * w * np.cos(w * t + 1.3 * f)
        a -= size * w**2 * np.sin(w * t + 1.3 * f)
    rng = np.random.default_rng(20261126)
    force = 85.0 * a + 20.0 * np.sign(v) + 214.0 * v + 2.0 * rng.standard_normal(len(t))
    cells = [f"{f:.5f}" if k % every == 0 else "" for k, f in enumerate(force)]
    rows = (f"{t[k]:.3f},{x[k]:.9f},{cells[k]}\n" for k in range(len(t)))
    file = tmp_path / "two-rates.csv"
    file.write_text("t_s,x_m,F_N\n" + "".join(rows), encoding="utf-8")
    fit = identify(read(file), rig="forced", law="coulomb-viscous")
    estimates = {e.name: e for e in fit.estimates}
    mass, coulomb = estimates["M"], estimates["F_C"]
    assert mass.verdict == "identified"
    assert mass.low - 0.01 < 85.0 < mass.high + 0.01
    assert mass.high - mass.low < 0.2
    assert coulomb.low - 0.1 < 20.0 < coulomb.high + 0.1
