"""Where a search of a smooth motion begins: descents over longer and longer horizons.

Where a simulated axis sticks a moment too long, all that follows is another motion, so that the
misfit over whole motions has a hollow for each such moment. A motion that begins anew from its
measured state again and again cannot go far astray, and the misfit over these short horizons is
smoother (as in multiple shooting; A. H. Ribeiro et al., On the smoothness of nonlinear system
identification, Automatica 121 (2020), doi:10.1016/j.automatica.2020.109158). Its minimum is not
the answer, as errors of the states at the beginnings count and what grows slowly does not show: the
horizon is doubled until motions are whole, and descents go on from where they have ended.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.random import SeedSequence

from ..rig.simulated import SimulatedRig, as_simulated
from ..rig.two_masses import TwoMassRig
from ..space import Array
from .parameters import Parameters
from .problem import MotionProblem
from .search_repeats import Progress, run_searches
from .search_settings import SearchSettings
from .segment import Segment

#: Horizons as shares of the longest motion, each with how many descents go through it; and the
#: fewest samples of one.
HORIZONS, FEWEST = ((1 / 16, 8), (1 / 8, 8), (1 / 4, 8), (1 / 2, 6)), 8
#: Places that are drawn for each descent, and evaluations a parameter of one over one horizon.
DRAWN, DESCENT = 8, 10


@dataclass(frozen=True, eq=False)
class NearPlaces:
    """Places near the answer of a problem.

    Args:
        parameters: Those of the problem, in ranges that hold the places.
        places: The best first, free parameters, SI, (dim,) each.
        evaluations: Of the residuals, each row counted, that led there.
        interrupted: Whether Ctrl-C ended the way there.
    """

    parameters: Parameters
    places: list[Array]
    evaluations: int
    interrupted: bool = False


def has_horizons(problem: MotionProblem) -> bool:
    """Whether motions of a problem can begin anew from measured states, and are long enough."""
    rig, parts = as_simulated(problem.parameters.rig), problem.train
    if isinstance(rig, TwoMassRig) or rig.floating or problem.parameters.law.states:
        return False  # how a spring or bristles are stretched was not measured
    if problem.weights is not None or any(s.start_directions is not None for s in parts):
        return False
    if any(rig.velocity_at(s.recording, s.begin) is None for s in parts):
        return False
    return len(on_horizon(problem, HORIZONS[-1][0]).train) > len(problem.train)


def evaluations_of(problem: MotionProblem) -> int:
    """How many evaluations `horizon_ends` may take, about."""
    descents = sum(most for _, most in HORIZONS)
    return DRAWN * HORIZONS[0][1] + descents * DESCENT * problem.space.dim


def horizon_ends(
    problem: MotionProblem, settings: SearchSettings, progress: Progress | None
) -> NearPlaces:
    """Descend over longer and longer horizons, from places anywhere in the search ranges.

    Args:
        problem: With motions that `has_horizons`; those of fewer samples are quicker.
        settings: How it is searched.
        progress: Called with the descents after every step.

    Raises:
        InputError: no place could be simulated.
        KeyboardInterrupt: before anything was evaluated.
    """
    space = problem.space
    rng = np.random.default_rng(SeedSequence(settings.seed, spawn_key=(space.dim, 2)))
    places, rows = space.decode(space.sample(rng, DRAWN * HORIZONS[0][1])), 0
    for share, most in HORIZONS:
        part = on_horizon(problem, share)
        if not rows:
            costs, rows = part(places), len(places)
            places = places[np.argsort(costs, kind="stable")]
        starts = places[:most, None]
        descents = [settings.descents(part, start, ((1, DESCENT),)) for start in starts]
        runs, interrupted = run_searches(part, descents, progress)
        rows += sum(run.evaluations for run in runs)
        places = np.array([run.x for run in sorted(runs, key=lambda run: run.cost)])
        if interrupted:
            return NearPlaces(problem.parameters, list(places), rows, interrupted=True)
        problem = problem.widened(places[0]) or problem
    return NearPlaces(problem.parameters, list(places), rows)


def on_horizon(problem: MotionProblem, share: float) -> MotionProblem:
    """The problem with its motions begun anew after each share of the longest."""
    horizon = share * max(float(np.ptp(s.track.t)) for s in problem.train)
    rig = as_simulated(problem.parameters.rig)
    return problem.of_segments([p for s in problem.train for p in _pieces(rig, s, horizon)])


def _pieces(rig: SimulatedRig, segment: Segment, horizon: float) -> list[Segment]:
    """A segment in pieces of a horizon, s, each from the state that was measured at its start."""
    track, log = segment.track, segment.recording
    N, span = len(track.t), float(np.ptp(track.t))
    n = max(min(round(span / horizon), N // FEWEST), 1)
    starts = np.unique(np.searchsorted(track.t, track.t[0] + span * np.arange(n) / n))
    pieces = []
    for first, stop in pairwise([*starts.tolist(), N]):
        piece, begin = track.of_samples(slice(first, stop)), segment.begin
        if first:
            begin = int(np.searchsorted(log.t, track.t[first]))
            v0 = rig.velocity_at(log, begin) or 0.0
            piece = piece.begun_at(float(track.measured[first]), v0)
        pieces.append(replace(segment, begin=begin, track=piece))
    return pieces
