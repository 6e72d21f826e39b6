"""A mass that swings on its bristles: its inertia has many minima, and the deepest one counts."""

from __future__ import annotations

import numpy as np

import interval_axes
from foreign_axes import noisy, recordings
from stribeck import RIGS, problem
from stribeck.identify.displaced_inertia import displaced_inertia
from stribeck.identify.refinement import Refined

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
