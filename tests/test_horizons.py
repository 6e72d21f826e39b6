"""Motions that begin anew from measured states, and where descents over them lead."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from foreign import servo
from stribeck import RIGS
from stribeck.data.recording import Recording
from stribeck.friction import law_named
from stribeck.identify.horizons import HORIZONS, has_horizons, horizon_ends, on_horizon
from stribeck.identify.loss import Objective
from stribeck.identify.multistart import multistart
from stribeck.identify.parameters import partition
from stribeck.identify.polish import polish
from stribeck.identify.problem import MotionProblem
from stribeck.identify.search_settings import SearchSettings
from stribeck.identify.segment import segments
from stribeck.optimize import Search
from stribeck.rig.rig import Rig
from stribeck.rig.simulated import as_simulated

RIG = RIGS["servo-pendulum"]
AXIS = servo.Servo(kp=300.0, q_offset=0.02)
LOADED = servo.Bam(0.01, 0.008, 0.02, 0.8, 1.3, 0.15, 0.15, 0.1, 0.1)
TRUTH = np.array(
    [*LOADED[:5], LOADED.K_m, LOADED.K_ms, AXIS.k_t, AXIS.R, AXIS.armature, AXIS.q_offset]
)


def log_of(seed: int = 0, noise: float = 5e-4, *, speed: bool = False) -> Recording:
    """Two sines of the goal, then a free swing, by a foreign simulator."""
    t = np.arange(0.0, 4.0, 0.01)
    goal = 1.1 * np.sin(2.5 * t) + 0.3 * np.sin(9.0 * t)
    enabled = (t < 3.0).astype(float)
    motion = servo.simulate(AXIS, LOADED, t, goal, enabled)
    q = motion.position + noise * np.random.default_rng(seed).standard_normal(len(t))
    return Recording(
        t=t, position=q, velocity=motion.velocity if speed else None, command=goal, rotary=True,
        extra={"torque_enable": enabled, "kp": np.full_like(t, AXIS.kp)},
    )  # fmt: skip


def problem_of(log: Recording, law: str = "bam-m4", rig: Rig = RIG) -> MotionProblem:
    parameters = partition(rig, law_named(law), objective=Objective("squares"))
    return MotionProblem(parameters, segments([log], as_simulated(rig), None))


def test_a_piece_is_the_motion_of_a_log_that_begins_there() -> None:
    log = log_of(speed=True)
    problem = problem_of(log)
    assert log.velocity is not None
    assert log.command is not None
    ends = [0, 100, 200, 300, 400]
    cut = [
        replace(
            log, t=log.t[a:b], position=log.position[a:b], velocity=log.velocity[a:b],
            command=log.command[a:b], extra={k: v[a:b] for k, v in log.extra.items()},
        )
        for a, b in pairwise(ends)
    ]  # fmt: skip
    x = np.array([1.1 * TRUTH, 0.8 * TRUTH])
    apart = np.concatenate([problem_of(piece).residuals(x) for piece in cut], axis=1)
    assert np.array_equal(on_horizon(problem, 0.25).residuals(x), apart)


def test_a_gap_of_a_log_is_one_piece() -> None:
    """Six beginnings of sixteen lie in it."""
    log = log_of()
    kept = (log.t < 1.1) | (log.t > 2.6)
    assert log.command is not None
    gapped = replace(
        log, t=log.t[kept], position=log.position[kept], command=log.command[kept],
        extra={k: v[kept] for k, v in log.extra.items()},
    )  # fmt: skip
    short = on_horizon(problem_of(gapped), 1 / 16)
    lengths = [len(s.track.t) for s in short.train]
    assert len(lengths) == 11
    assert sum(lengths) == len(gapped)
    assert np.isfinite(short(TRUTH[None])).all()


def test_over_a_short_horizon_a_wrong_friction_errs_less_and_the_right_one_hardly() -> None:
    problem = problem_of(log_of(noise=0.0, speed=True))
    wrong = TRUTH.copy()
    wrong[0] += 0.03  # N m
    whole, short = problem, on_horizon(problem, 1 / 16)
    assert len(short.train) == 16
    (right, _), (right_short, wrong_short) = (p(np.array([TRUTH, wrong])) for p in (whole, short))
    assert right < 0.05  # mrad; short motions begin with a speed of 0 where the axis seems to rest
    assert right_short < 0.02 * wrong_short
    assert wrong_short < 0.5 * float(whole(wrong[None])[0])


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_descents_over_horizons_pass_the_hollows_of_whole_motions(seed: int) -> None:
    """From the same places, with no more evaluations each, descents over whole motions stay in
    them: the noise is 0.5 mrad."""
    problem = problem_of(log_of(seed)).thinned()
    near = horizon_ends(problem, SearchSettings(seed=seed), None)
    assert problem.over(near.parameters)(np.array(near.places)).max() < 0.6  # mrad
    space = problem.space
    rng = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(space.dim, 2)))
    drawn = space.decode(space.sample(rng, 64))
    share, most = HORIZONS[0]
    best = drawn[np.argsort(on_horizon(problem, share)(drawn))][:most]
    ends = [polish(problem, x, None, near.evaluations // len(best)).cost for x in best]
    assert max(ends) > 10.0  # mrad


def test_ranges_grow_where_an_answer_lies_beyond_them() -> None:
    """The armature is above the default range."""
    own = replace(RIG, ranges={**RIG.ranges, "armature": (1e-5, 4e-4)})
    problem = problem_of(log_of(), rig=own).thinned()
    near = horizon_ends(problem, SearchSettings(), None)
    k = problem.space.names.index("armature")
    assert near.places[0][k] == pytest.approx(AXIS.armature, rel=0.1)
    assert near.parameters.free[k].upper > 4e-4


@pytest.mark.parametrize("law", ["dahl", "lugre"])
def test_bristles_of_unknown_stretch_have_no_horizons(law: str) -> None:
    assert has_horizons(problem_of(log_of()))
    assert not has_horizons(problem_of(log_of(), law))


def test_few_evaluations_are_not_spent_on_horizons() -> None:
    """Eight descents would take thousands."""

    def most_abreast(budget: int) -> int:
        abreast: list[int] = []

        def note(searches: Sequence[Search]) -> None:
            abreast.append(len(searches))
            if len(abreast) == 3:
                raise KeyboardInterrupt

        with suppress(KeyboardInterrupt):
            settings = SearchSettings(budget=budget, repeats=1)
            multistart(problem_of(log_of(), "bam-m5"), settings, note)
        return max(abreast)

    assert most_abreast(300) == 1
    assert most_abreast(8_000) == 8


def test_descents_that_are_stopped_keep_the_best_place() -> None:
    """Over an eighth of a motion they may still be far from where they would have ended."""
    problem, met = problem_of(log_of(), "bam-m5"), []

    def stop(searches: Sequence[Search]) -> None:
        met.append(len(searches))
        if len(met) == 60:
            raise KeyboardInterrupt

    end = multistart(problem, SearchSettings(), stop)
    assert end.interrupted
    assert len(met) == 60
    assert end.search.evaluations > 60
    own = end.problem.thinned() if isinstance(end.problem, MotionProblem) else end.problem
    assert float(own(end.x[None])[0]) == pytest.approx(end.search.runs[0].cost, rel=1e-9)
    assert end.search.runs[0].cost < float(
        np.median(problem(problem.space.decode(problem.space.sample(np.random.default_rng(0), 64))))
    )
