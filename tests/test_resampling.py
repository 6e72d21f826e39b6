"""Channels at other instants: what is exact, what a tone keeps, and where lines are straight."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from foreign.tones import axis
from stribeck import Recording, identify, read
from stribeck.data.resampling import averaged, interpolated
from stribeck.errors import InputError
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
    straight = {-1, 17, 18, 19, 20, 21, 37, 38, 39, 40, 41, *range(49, 55), 59}
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


def written(path: Path, t: Array, x: Array, force: Array) -> Path:
    """A table; what is nan is an empty cell."""
    cells = ["" if np.isnan(f) else f"{f:.6g}" for f in force]
    rows = (f"{t[k]:.3f},{x[k]:.9f},{cells[k]}\n" for k in range(len(t)))
    path.write_text("t_s,x_m,F_N\n" + "".join(rows), encoding="utf-8")
    return path


def slow(force: Array, every: int) -> Array:
    return np.where(np.arange(len(force)) % every == 0, force, np.nan)


@pytest.mark.parametrize("every", [2, 8, 16])
def test_a_slower_force_keeps_the_mass_and_the_friction(every: int, tmp_path: Path) -> None:
    """Straight lines make of 85 kg 85.0, 84.7 and 83.6, surely."""
    t, x, force = axis()
    file = written(tmp_path / "two-rates.csv", t, x, slow(force, every))
    fit = identify(read(file), rig="forced", law="coulomb-viscous")
    estimates = {e.name: e for e in fit.estimates}
    mass, coulomb = estimates["M"], estimates["F_C"]
    assert mass.verdict == "identified"
    assert mass.low < 85.0 < mass.high
    assert mass.high - mass.low < 0.2
    assert coulomb.low < 20.0 < coulomb.high


def test_a_slower_force_that_is_cut_off_is_told(tmp_path: Path) -> None:
    t, x, force = axis()
    file = written(tmp_path / "cut.csv", t, x, slow(np.clip(force, -1000.0, 1000.0), 8))
    fit = identify(read(file), rig="forced", law="coulomb-viscous")
    assert any("force is cut off at -1000 N and 1000 N" in w for w in fit.warnings)
    assert all(e.verdict != "identified" for e in fit.estimates)


def test_a_wild_sample_and_missing_ones_of_a_slower_force(tmp_path: Path) -> None:
    """They are left out where they are, and not spread over those around."""
    t, x, force = axis()
    force = slow(force, 8)
    force[8000] += 3000.0
    lost = np.random.default_rng(5).random(len(force)) < 0.05
    lost[[0, 8000, len(lost) - 8]] = False
    force[lost] = np.nan
    recording = read(written(tmp_path / "wild.csv", t, x, force))
    assert any("1 wild sample of F_N left out, first in line 8002" in n for n in recording.notes)
    fit = identify(recording, rig="forced", law="coulomb-viscous")
    mass = next(e for e in fit.estimates if e.name == "M")
    assert mass.verdict == "identified"
    assert mass.low < 85.0 < mass.high


def test_a_slower_force_that_is_away_for_long_is_refused(tmp_path: Path) -> None:
    t, x, force = axis()
    (tmp_path / "pos.csv").write_text(
        "t_s,x_m\n" + "".join(f"{a:.3f},{b:.9f}\n" for a, b in zip(t, x, strict=True)),
        encoding="utf-8",
    )
    own = [k for k in range(0, len(t), 8) if not 10_000 <= k < 10_400]
    (tmp_path / "force.csv").write_text(
        "t_s,F_N\n" + "".join(f"{t[k]:.3f},{force[k]:.4f}\n" for k in own), encoding="utf-8"
    )
    with pytest.raises(InputError, match=r"force is empty in pos.csv, line .*: cut the log there"):
        read(f"{tmp_path / 'pos.csv'}+{tmp_path / 'force.csv'}")


def test_an_angle_that_turns_over_is_not_thinned(tmp_path: Path) -> None:
    t, x, force = axis()
    file = written(tmp_path / "turns.csv", t, np.mod(100.0 * x, 2 * np.pi), slow(0.01 * force, 8))
    file.write_text(file.read_text(encoding="utf-8").replace("t_s,x_m,F_N", "t_s,q_rad,torque_Nm"))
    fit = identify(read(file), rig="forced-rotary", law="coulomb-viscous")
    inertia = next(e for e in fit.estimates if e.name == "J")
    assert inertia.value == pytest.approx(85e-4, rel=2e-3)


def test_a_position_from_a_velocity_keeps_the_mass(tmp_path: Path) -> None:
    """By trapezia it is too small by (w h)^2 / 12, which made 85.2 kg at 125 Hz."""
    t, x, force = axis()
    v = np.gradient(x, t, edge_order=2)
    v[2:-2] = (x[:-4] - 8 * x[1:-3] + 8 * x[3:-1] - x[4:]) / (12 * (t[1] - t[0]))
    rows = (f"{t[k]:.3f},{v[k]:.9f},{force[k]:.5f}\n" for k in range(0, len(t), 8))
    file = tmp_path / "velocity.csv"
    file.write_text("t_s,v_m_s,F_N\n" + "".join(rows), encoding="utf-8")
    fit = identify(read(file), rig="forced", law="coulomb-viscous", velocity="position")
    mass = next(e for e in fit.estimates if e.name == "M")
    assert mass.low < 85.0 < mass.high
    assert mass.value == pytest.approx(85.0, rel=1e-3)


def test_values_near_the_end_of_all_numbers_stay_between_those_around() -> None:
    t, y = np.arange(30.0), np.sin(np.arange(30.0))
    y[15] = 1.7e308
    with np.errstate(over="ignore", invalid="ignore"):
        ours = interpolated(np.linspace(0.0, 29.0, 301), t, y)
    assert np.isfinite(ours).all()
    assert ours.max() > 1.6e308
    assert y.min() <= ours.min() < -0.9


def test_a_log_that_is_nearly_all_gap_is_refused() -> None:
    t, x, force = axis()
    t = t + 1e9 * (t >= 10.0)
    with pytest.raises(InputError, match=r"leave most of 1e\+09 s out, most between 9.999 and"):
        identify(Recording(t=t, position=x, force=force), rig="forced", law="coulomb-viscous")
