"""A log that tips beside an answer: a foreign pendulum that just does not stay where it starts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import foreign_axes
from foreign import servo
from stribeck import RIGS
from stribeck.identify.problem import MotionProblem, problem
from stribeck.identify.tipping import FAR, tipping_violations
from stribeck.space import Array

USUAL = foreign_axes.pendulum(bam=servo.Bam(1e-3, 0.004))
#: Gravity at the start over the friction that holds the pendulum, less one.
EXCESS = 4e-3


@pytest.fixture(scope="module")
def fallen() -> MotionProblem:
    """Two usual logs, and one of a pendulum without torque that falls after it has hung for long.

    A ten-thousandth of the range of F_C is half a percent of it: with so much more it stays.
    """
    truth = servo.Servo(**{n: USUAL.truth[n] for n in ("k_t", "R", "armature", "q_offset")})
    t, m, l = 0.01 * np.arange(301), 0.5, 0.15  # noqa: E741 - the equation's letter
    held = USUAL.truth["F_C"] / (m * truth.g * l)
    start = np.pi - np.arcsin((1.0 + EXCESS) * held) - truth.q_offset
    motion = servo.simulate(
        truth._replace(m=m, l=l), servo.Bam(1e-3, 0.004), t, np.full_like(t, start),
        np.zeros_like(t), (start, 0.0),
    )  # fmt: skip
    table = motion._asdict() | {"mass": np.full_like(t, m), "length": np.full_like(t, l)}
    axis = replace(USUAL, tables=(*USUAL.tables[:2], table))
    logs = foreign_axes.recordings(axis, list(axis.tables))
    return problem(logs, rig=RIGS[axis.rig].set(**axis.given), law=axis.law)


def truth_of(fallen: MotionProblem, **changes: float) -> Array:
    truth = {**USUAL.truth, **changes}
    return np.array([truth[name] for name in fallen.space.names])


def test_a_log_that_tips_is_named_with_what_it_leaves_on_either_side(fallen: MotionProblem) -> None:
    x = truth_of(fallen)
    (violation,), rows = tipping_violations(fallen, x)
    assert violation.sentence.startswith("log3.csv tips: its error is ")
    assert violation.caps
    assert rows == 1 + 2 * 2 * len(x)


def test_no_log_tips_a_hundred_times_further_from_the_edge(fallen: MotionProblem) -> None:
    """There the pendulum falls at once, or stays for good."""
    param = next(q for q in fallen.space.params if q.name == "F_C")
    for side in (-1.0, 1.0):
        x = truth_of(fallen, F_C=USUAL.truth["F_C"] + side * 10 * FAR * (param.upper - param.lower))
        assert tipping_violations(fallen, x)[0] == []


def test_usual_logs_do_not_tip(fallen: MotionProblem) -> None:
    usual = fallen.of_segments(fallen.train[:2])
    assert tipping_violations(usual, truth_of(usual))[0] == []
