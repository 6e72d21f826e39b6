"""What is told of held-out data, and of joints that move beside the axis."""

from __future__ import annotations

import numpy as np
import pytest

from stribeck import RIGS, Recording
from stribeck.friction import LAWS
from stribeck.identify.adequacy.generalisation import (
    held_out_violations,
    moving_joints,
    neighbour_violations,
)
from stribeck.identify.held_out_scope import held_out_scope
from stribeck.identify.parameters import Parameters
from stribeck.identify.score import HeldOut, Score

T = np.linspace(0.0, 5.0, 501)


def log(**extra: object) -> Recording:
    columns = {name: np.asarray(values, float) for name, values in extra.items()}
    return Recording(T, np.sin(T), force=np.cos(T), extra=columns, rotary=True)


def test_joints_that_move_are_seen_and_columns_of_the_axis_are_not() -> None:
    moving = log(q_2=np.sin(3 * T), qd_2=np.cos(3 * T), q_3=0.001 * np.sin(T * 5), q_1=np.sin(T))
    assert moving_joints(moving) == ["q_2", "qd_2"]
    assert moving_joints(log(temperature_2=np.cos(3 * T), q_cmd_rad=np.cos(3 * T))) == []


def test_an_inertia_is_not_identified_where_other_joints_move() -> None:
    parameters = Parameters.declared(RIGS["forced-rotary"], LAWS["coulomb-viscous"])
    (violation,) = neighbour_violations(parameters, [log(q_2=np.sin(3 * T))])
    assert (violation.parameters, violation.caps) == (frozenset({"M"}), True)
    assert "q_2" in violation.sentence
    assert "J is no constant" in violation.sentence
    assert not neighbour_violations(parameters, [log()])


@pytest.mark.parametrize(("error", "told"), [(1.2, False), (2.0, True)])
def test_a_held_out_error_far_above_training_is_told(error: float, told: object) -> None:
    def score(value: float) -> Score:
        return Score("relative_error", value, "%", float("nan"), float("nan"), 200)

    violations = held_out_violations(score(1.0), [HeldOut(None, score(error), (), ())])
    assert bool(violations) is told
    assert not any(v.caps for v in violations)


def test_a_range_in_which_nothing_moves_tests_nothing() -> None:
    """Ten seconds of rest under a sensor's noise, beside the motion after it."""
    t = np.arange(0.0, 20.0, 0.01)
    position = np.where(t < 10.0, 0.0, 0.05 * (t - 10.0))
    position = position + 1e-4 * np.random.default_rng(1).standard_normal(len(t))
    moving = Recording(t, position)
    rest, motion = slice(0, 1000), t >= 10.0
    rig = RIGS["forced"]
    assert held_out_scope([(moving, rest)], rig) == ("nothing: the axis does not move in it", False)
    text, moves = held_out_scope([(moving, motion)], rig)
    assert (text.split(", ")[0], moves) == ("9.99 s", True)
    assert held_out_scope([(moving, rest), (moving, motion)], rig).moves
    score = Score("relative_error", 1.0, "%", float("nan"), float("nan"), 200)
    scope = held_out_scope([(moving, rest)], rig)
    (violation,) = held_out_violations(score, [HeldOut(None, score, (), (), scope)])
    assert violation.sentence.startswith(
        "hold-out all tests nothing: the axis does not move in it;"
    )
