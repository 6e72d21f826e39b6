"""A search on fewer samples sees the same misfit, and its answer is refitted on all of them."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import least_squares

from foreign import servo
from stribeck import RIGS, identify
from stribeck.data.recording import Recording
from stribeck.friction import law_named
from stribeck.identify.free_constants import FreeConstantsProblem
from stribeck.identify.problem import MotionProblem, problem
from stribeck.rig.simulated import as_simulated
from stribeck.space import Array

RIG = RIGS["servo-pendulum"]
AXIS = servo.Servo(kp=300.0, q_offset=0.02)
TRUE = np.array([0.03, 0.008, AXIS.k_t, AXIS.R, AXIS.armature, AXIS.q_offset])


def log_of(rate: float = 500.0, step: float = 0.3, buzz: float = 0.0) -> Recording:
    """A sine with a step of the goal, then a free swing."""
    t = np.arange(0.0, 6.0, 1.0 / rate)
    goal = 0.8 * np.sin(2.5 * t) + step * (t > 1.2345) + buzz * np.sin(2 * np.pi * 60.0 * t)
    enabled = (t < 4.567).astype(float)
    q = servo.simulate(AXIS, servo.Bam(0.03, 0.008), t, goal, enabled).position
    q = q + 5e-4 * np.random.default_rng(0).standard_normal(len(t))
    return Recording(
        t=t, position=q, command=goal, rotary=True,
        extra={"torque_enable": enabled, "kp": np.full_like(t, AXIS.kp)},
    )  # fmt: skip


def problem_of(log: Recording, law: str = "coulomb-viscous") -> MotionProblem:
    return problem(log, rig=RIG, law=law)


def test_a_tenth_of_the_samples_tells_the_misfit() -> None:
    whole = problem_of(log_of())
    fewer = whole.thinned()
    assert sum(fewer.logs) == sum(whole.logs) // 10
    # 500 Hz is a tenth of the longest step of 20 ms; some more samples, where the goal steps and
    # the torque ends, are simulated and do not count.
    assert sum(fewer.logs) < len(fewer.train[0].track.t) < 1.2 * sum(fewer.logs)
    x = TRUE * (1.0 + 0.2 * np.random.default_rng(1).standard_normal((40, 6)))
    assert fewer(x) == pytest.approx(whole(x), rel=0.02)


def test_a_step_of_the_goal_and_the_end_of_the_torque_stay_where_they_are() -> None:
    whole = problem_of(log_of())
    fewer = whole.thinned()
    full, thin = whole.train[0].track, fewer.train[0].track
    law, rig = law_named("coulomb-viscous"), as_simulated(RIG)
    p = whole.parameters.full(TRUE[None])
    every, some = (rig.states(law, p, track)[0][0] for track in (full, thin))
    assert np.abs(every[np.searchsorted(full.t, thin.t)] - some).max() < 5e-4  # as the noise


@pytest.mark.parametrize("law", ["dahl", "lugre"])
def test_a_law_with_states_keeps_all_samples(law: str) -> None:
    whole = problem_of(log_of(), law)
    assert whole.thinned() is whole


def test_inputs_that_change_from_sample_to_sample_keep_all() -> None:
    whole = problem_of(log_of(buzz=0.5))
    assert whole.thinned() is whole


def test_a_log_of_few_samples_keeps_all() -> None:
    whole = problem_of(log_of(rate=30.0))
    assert whole.thinned() is whole


def test_priors_of_constants_weigh_as_much_beside_fewer_residuals() -> None:
    log = log_of()
    constants = [c for c in RIG.constants if c.standard_deviation > 0]
    problem = FreeConstantsProblem(problem_of(log), constants, 0.5)
    fewer = problem.thinned()
    shares = [
        float(np.sum(r[-len(constants) :] ** 2) / np.sum(r**2))
        for p in (problem, fewer)
        for r in p.residuals(np.concatenate([TRUE, 1.001 * problem.nominal])[None])
    ]
    assert shares[0] == pytest.approx(shares[1], rel=0.15)  # 300 samples of noise


def test_the_answer_is_that_of_all_samples() -> None:
    log = log_of()
    fit = identify(log, rig=RIG, law="coulomb-viscous")
    assert fit.score.samples == len(log)
    assert fit.residuals is not None
    whole = problem_of(log)

    def residuals(x: Array) -> Array:
        row: Array = whole.residuals(x[None])[0]
        return row

    best = least_squares(residuals, fit.p, x_scale=np.abs(fit.p), xtol=1e-10)
    errors = np.array([e.standard_error for e in fit.estimates])
    assert (np.abs(best.x - fit.p) < 0.05 * errors).all()
