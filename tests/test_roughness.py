"""Intervals of a misfit that changes where its parameters hardly do, beside the smooth one's."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.random import default_rng

from stribeck.identify.uncertainty.linearisation import box_of, linearised
from stribeck.identify.uncertainty.profile import ROUGHEST, Profiles, profiles
from stribeck.identify.uncertainty.roughness import Roughness, outweighing, roughness
from stribeck.identify.uncertainty.verdict import verdict
from stribeck.optimize.lockstep import Counted
from stribeck.optimize.trust_region import Iterate
from stribeck.space import Array, box

ROWS = 2000


class Line:
    """A straight line and a wave under noise, whose residuals are off anew at every point.

    Args:
        rough: By how much each is off, in standard deviations of the noise.
        steep: By how much steeper the wave is than the line.
    """

    def __init__(self, rough: float, steep: float = 1e3) -> None:
        t = np.linspace(0.0, 1.0, ROWS)
        self.W = np.column_stack([np.ones(ROWS), t, steep * np.sin(40.0 * t)])
        self.space, self.rough = box([(-50.0, 50.0)] * 3), rough
        truth = np.array([1.0, 2.0, 0.5])
        self.y = self.W @ truth + 0.1 * default_rng(1).standard_normal(ROWS)
        self.best = np.linalg.lstsq(self.W, self.y, rcond=None)[0]

    def residuals(self, x: Array, /) -> Array:
        off = [default_rng(np.frombuffer(row.tobytes(), np.uint32)) for row in x]
        rows = np.array([rng.standard_normal(ROWS) for rng in off])
        return np.asarray(self.y - x @ self.W.T + 0.1 * self.rough * rows)


def half_widths(profiled: Profiles) -> Array:
    return np.array([0.5 * (p.high.end - p.low.end) for p in profiled.profiles])


def test_intervals_of_a_rough_misfit_are_guesses_and_as_wide_as_the_smooth_ones() -> None:
    smooth, rough = (Line(size) for size in (0.0, 0.03))
    walked = profiles(smooth, smooth.best)
    guessed = profiles(rough, rough.best)
    assert walked.complete
    assert not walked.rough
    assert guessed.rough
    assert not guessed.complete
    assert {e.ended for p in guessed.profiles for e in (p.low, p.high)} == {"budget"}
    np.testing.assert_allclose(half_widths(guessed), half_widths(walked), rtol=0.15)


def test_a_rough_misfit_leaves_nothing_identified() -> None:
    model = Line(0.03)
    profiled = profiles(model, model.best)
    verdicts = [verdict(p, q) for p, q in zip(profiled.profiles, model.space.params, strict=True)]
    assert set(verdicts) == {("weak", "guessed")}


def test_a_smooth_misfit_costs_one_point_more() -> None:
    model = Line(0.0)
    counted, box_ = Counted(model, 100), box_of(model)
    best = linearised(counted, box_, model.best)
    before = counted.rows
    assert roughness(best, box_, counted, ROUGHEST * best.squares / ROWS) is None
    assert counted.rows == before + 1


def test_a_narrow_valley_is_not_rough() -> None:
    """One in which a billionth of the range changes the fit by many thresholds."""
    model = Line(0.0, steep=1e9)
    assert not profiles(model, model.best).rough


@pytest.mark.parametrize("size", [0.01, 0.03, 0.1])
def test_long_differences_outweigh_what_is_rough(size: float) -> None:
    model = Line(size)
    counted, box_ = Counted(model, 1000), box_of(model)
    best = linearised(counted, box_, model.best)
    rough = roughness(best, box_, counted, 0.0)
    assert rough is not None
    assert rough.residuals == pytest.approx(0.1 * size * np.sqrt(2 * ROWS), rel=0.1)
    J = outweighing(best, box_, counted, rough).J
    exact = -100.0 * model.W.T
    errors = np.linalg.norm(J - exact, axis=1) / np.linalg.norm(exact, axis=1)
    assert errors.max() < 0.12


def test_a_side_that_cannot_be_run_leaves_the_slope_to_the_other() -> None:
    model = Line(0.03)

    class Walled(Line):
        def residuals(self, x: Array, /) -> Array:
            R = super().residuals(x)
            R[x[:, 0] > model.best[0] + 1e-4] = np.nan
            R[x[:, 1] != model.best[1]] = np.nan
            return R

    walled = Walled(0.03)
    counted, box_ = Counted(walled, 1000), box_of(walled)
    u = box_.u(model.best)
    walled_at = box_.x(u)
    model.best[:] = walled_at  # as it is once decoded
    best = Iterate.at(u, walled.residuals(walled_at[None])[0])
    J = outweighing(best, box_, counted, Roughness(1.0, 0.1 * 0.03 * np.sqrt(2 * ROWS))).J
    exact = -100.0 * model.W.T
    assert np.linalg.norm(J[0] - exact[0]) < 0.2 * np.linalg.norm(exact[0])
    assert not J[1].any()
