"""A mass that swings on its bristles: its inertia has many minima, and the deepest one counts."""

from __future__ import annotations

import numpy as np
import pytest

import interval_axes
from foreign_axes import noisy, recordings
from stribeck import RIGS, problem
from stribeck.identify.displaced_inertia import displaced_inertia
from stribeck.identify.refinement import Refined
from stribeck.identify.uncertainty.profile import profiles
from stribeck.space import Array, box

#: A minimum in which searches of this log end: 21.7 kg where 29.1 kg made it.
ELSEWHERE = {"sigma_0": 498111.0, "F_C": 13.6385, "F_V": 312.93, "M": 21.676, "offset": 0.5323}


def test_a_mass_that_swings_on_its_bristles_is_looked_for_elsewhere() -> None:
    axis = interval_axes.dahl(4)
    logs = recordings(axis, noisy(axis, np.random.default_rng(4), 0.0))
    swinging = problem(logs, rig=RIGS[axis.rig].set(**axis.given), law="dahl")
    names = swinging.space.names
    at, truth = (np.array([[values[n] for n in names]]) for values in (ELSEWHERE, axis.truth))
    start, least = swinging(np.concatenate([at, truth]))
    assert start > 1.05 * least
    allowance = 3000
    best = displaced_inertia(swinging, Refined(at[0], float(start), 7, None), allowance)
    assert best.cost <= least
    assert abs(best.x[names.index("M")] / axis.truth["M"] - 1.0) < 0.02
    assert best.evaluations <= 7 + allowance


def test_a_law_without_states_has_nothing_to_swing_on() -> None:
    axis = interval_axes.dahl(4)
    logs = recordings(axis, noisy(axis, np.random.default_rng(4), 0.0))
    sliding = problem(logs, rig=RIGS[axis.rig].set(**axis.given), law="coulomb-viscous")
    best = Refined(sliding.space.decode(np.full((1, sliding.space.dim), 0.5))[0], 1.0, 7, None)
    assert displaced_inertia(sliding, best, 3000) is best


def test_minima_that_explain_the_data_as_well_are_kept() -> None:
    """Log 15 of the coverage study: its least misfit is at 24.3 kg where 21.7 kg made it."""
    axis = interval_axes.dahl(15)
    logs = recordings(axis, noisy(axis, np.random.default_rng(15), 0.0))
    swinging = problem(logs, rig=RIGS[axis.rig].set(**axis.given), law="dahl")
    at = np.array([[2.649e6, 15.3298, 133.7, 24.278, 0.50194]])
    start = float(swinging(at)[0])
    best = displaced_inertia(swinging, Refined(at[0], start, 7, None), 6000)
    masses = [mode[swinging.space.names.index("M")] for mode in best.modes]
    assert min(abs(m / axis.truth["M"] - 1.0) for m in masses) < 0.03
    assert all(float(swinging(mode[None])[0]) < 1.006 * best.cost for mode in best.modes)


class Valleys:
    """Two unknowns; the misfit is as small about every whole number of the first one."""

    def __init__(self) -> None:
        self.space = box([(-3.4, 3.4), (-1.0, 1.0)])
        self._noise = np.random.default_rng(0).standard_normal(200)

    def residuals(self, x: Array, /) -> Array:
        x = np.atleast_2d(x)
        wave = 5.0 * np.sin(np.pi * x[:, :1])
        return self._noise + wave * np.linspace(-1.0, 1.0, 200) + 5.0 * x[:, 1:]


def test_an_interval_reaches_to_minima_that_fit_as_well() -> None:
    valleys = Valleys()
    at = np.zeros(2)
    alone, all_known = (
        profiles(valleys, at, ratio=np.ones(2), modes=modes).profiles[0]
        for modes in ([], [np.array([0.9, 0.1]), np.array([-2.1, -0.1])])
    )
    assert alone.low.end > -0.1
    assert alone.high.end < 0.1
    assert all_known.low.end == pytest.approx(-2.0, abs=0.05)
    assert all_known.high.end == pytest.approx(1.0, abs=0.05)
