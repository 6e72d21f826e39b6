"""What is told of held-out data, and of joints that move beside the axis."""

from __future__ import annotations

import numpy as np
import pytest

from stribeck import RIGS, Recording
from stribeck.friction import LAWS
from stribeck.identify.adequacy.generalisation import held_out_violations
from stribeck.identify.adequacy.neighbours import neighbour_violations, neighbours
from stribeck.identify.held_out_scope import held_out_scope
from stribeck.identify.parameters import Parameters
from stribeck.identify.score import HeldOut, Score

T = np.linspace(0.0, 5.0, 501)


def log(**extra: object) -> Recording:
    columns = {name: np.asarray(values, float) for name, values in extra.items()}
    return Recording(T, np.sin(T), force=np.cos(T), extra=columns, rotary=True)


def test_joints_that_move_are_seen_and_columns_of_the_axis_are_not() -> None:
    moving = log(q_2=np.sin(3 * T), qd_2=np.cos(3 * T), q_3=0.001 * np.sin(T * 5), q_1=np.sin(T))
    (joint,) = neighbours(moving)
    assert joint.column == "q_2"
    assert joint.travel == pytest.approx(2.0, rel=1e-3)
    assert neighbours(log(temperature_2=np.cos(3 * T), q_cmd_rad=np.cos(3 * T))) == []
    (joint,) = neighbours(log(qd_3=np.cos(3 * T)))
    assert joint.speed


@pytest.mark.parametrize(
    ("head", "travel"),
    [
        ("joint_2_pos", 1.0),
        ("/joint_states/elbow/position", 1.0),
        ("observation.state/elbow.pos", 1.0),
        ("q2_deg", np.radians(1.0)),
        ("Y1_ActualPosition [mrad]", 1e-3),
    ],
)
def test_names_of_joints_and_their_units_are_understood(head: str, travel: float) -> None:
    big = Recording(T, 1e-3 * np.sin(T), extra={head: np.sin(3 * T)}, rotary=True)
    (joint,) = neighbours(big)
    assert joint.travel == pytest.approx(2 * travel, rel=1e-3)


def test_columns_without_names_are_joints_where_one_is_the_slope_of_another() -> None:
    columns = {"column 3": np.sin(3 * T), "column 4": 0.01 * np.sin(5 * T), "column 9": np.sin(T),
               "column 10": 3 * np.cos(3 * T), "column 11": 0.05 * np.cos(5 * T),
               "column 12": np.cos(T), "column 20": np.abs(np.sin(2 * T))}  # fmt: skip
    moving = Recording(T, np.sin(T), velocity=np.cos(T), extra=columns, rotary=True)
    assert [n.column for n in neighbours(moving)] == ["column 3"]


def test_a_small_motion_or_a_linear_axis_is_told_and_keeps_its_inertia() -> None:
    parameters = Parameters.declared(RIGS["forced-rotary"], LAWS["coulomb-viscous"])
    little = Recording(T, 0.1 * np.sin(T), extra={"q_2": 0.02 * np.sin(3 * T)}, rotary=True)
    (violation,) = neighbour_violations(parameters, [little])
    assert not violation.caps
    linear = Parameters.declared(RIGS["forced"], LAWS["coulomb-viscous"])
    gantry = Recording(T, np.sin(T), extra={"Y1_ActualPosition [mm]": 1e3 * np.sin(3 * T)})
    (violation,) = neighbour_violations(linear, [gantry])
    assert not violation.caps
    assert "Y1_ActualPosition [mm] by 2 m)" in violation.sentence


def test_an_inertia_is_not_identified_where_other_joints_move() -> None:
    parameters = Parameters.declared(RIGS["forced-rotary"], LAWS["coulomb-viscous"])
    (violation,) = neighbour_violations(parameters, [log(q_2=np.sin(3 * T))])
    assert (violation.parameters, violation.caps) == (frozenset({"M"}), True)
    assert "(q_2 by 2)" in violation.sentence
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
