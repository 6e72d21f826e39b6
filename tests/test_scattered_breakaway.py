"""Breakaway that differs from slip to slip, on foreign axes whose slips have one of their own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy import stats

import interval_axes
from foreign import joint, sensors, slide_bed
from foreign.clock import Array
from foreign.friction import Curve
from foreign_axes import noisy, recordings
from stribeck import RIGS, Fit, InputError, Recording, identify, select
from stribeck.friction import law_named
from stribeck.identify import arithmetic
from stribeck.identify.breakaway_scatter import scatter
from stribeck.identify.fit_warnings import misfit_violations
from stribeck.identify.loss import Objective
from stribeck.identify.onset_levels import onset_levels
from stribeck.identify.own_breakaway import (
    moved_onsets,
    onset_of,
    pulls,
    simulated_slip,
    unexplained,
)
from stribeck.identify.parameters import Parameters, partition
from stribeck.identify.problem import MotionProblem
from stribeck.identify.random_effects import spread_of
from stribeck.identify.segment import Segment, segments
from stribeck.identify.slip_starts import drawn_starts
from stribeck.identify.validate import validate
from stribeck.report.fit_report import show_fit
from stribeck.rig.simulated import SimulatedRig, as_simulated
from stribeck.space import Space

CURVE = Curve(144.5, 47.9, 958.3, 1.1e-3)
K_SPRING = 967.98
ARM = {"J": 0.06, "g_sin": 0.05, "g_0": -0.03}
ARM_CURVE = Curve(0.6, 0.25, 0.7, 0.05, 2.0)
BY_SLIP = Objective(breakaway="scattered")


def factors(seed: int, share: float) -> Array:
    drawn = 1.0 + share * np.random.default_rng(seed).standard_normal(100)
    return np.maximum(drawn, 0.5)


@cache
def bed_log(share: float, seed: int = 1, sd: float = 5e-5) -> Recording:
    """A stroke up and one down, 14 or 15 slips."""
    times, command = np.array([0.0, 50.0, 52.0, 102.0]), np.array([0.05, 0.3, 0.3, 0.05])
    bed = slide_bed.Bed(k_spring_down=K_SPRING)
    m = slide_bed.simulate(
        bed, CURVE, CURVE, times, command, 0.045, scatter=factors(seed, share), h=2e-5
    )
    table = sensors.noisy(m._asdict(), "position", sd, np.random.default_rng(seed))
    return Recording(t=table["t"], position=table["position"], command=table["command"])


@cache
def joint_log(share: float, hold: float, seed: int = 1) -> Recording:
    """Slow sines under coarse steps of the encoder, some 20 slips."""
    t: Array = 0.02 * np.arange(3001.0)
    command = 0.4 * np.sin(2.0 * np.pi * t / 60.0)
    speed = np.gradient(command, t)
    arm = joint.Joint(**ARM, kp=35.0, kd=2.2, gain=0.2, hold=hold)
    m = joint.simulate(
        arm, ARM_CURVE, ARM_CURVE, t, command, speed, scatter=factors(seed, share), h=1e-4
    )
    position = sensors.quantised(m._asdict(), "position", 3.8e-4)["position"]
    extra = {"qd_cmd_rad_s": speed}
    return Recording(t=t, position=position, command=command, extra=extra, rotary=True)


def arm_rig(hold: float) -> SimulatedRig:
    return as_simulated(RIGS["joint"].exact().set(kp=35.0, kd=2.2, gain=0.2, hold=hold))


def slips(log: Recording, rig: SimulatedRig, law: str) -> tuple[Parameters, list[Segment]]:
    parameters = partition(rig, law_named(law), objective=BY_SLIP)
    return parameters, segments([log], rig, None, BY_SLIP)


# --- whether it scatters --------------------------------------------------------------------------


@pytest.mark.parametrize("share", [0.0, 0.05, 0.1, 0.25])
def test_scatter_of_a_slide_bed(share: float) -> None:
    for seed in (1, 2):
        seen = scatter(*slips(bed_log(share, seed), as_simulated(RIGS["slide-bed"]), "stribeck"))
        drawn = factors(seed, share)[: seen.slips]
        assert seen.evident == (share > 0.0)
        assert seen.share == pytest.approx(np.std(drawn, ddof=1) / np.mean(drawn), abs=0.03)


@pytest.mark.parametrize("hold", [0.0, 1.0, 2.0])
@pytest.mark.parametrize("share", [0.0, 0.1])
def test_scatter_of_a_joint_apart_from_gravity(share: float, hold: float) -> None:
    seen = scatter(*slips(joint_log(share, hold), arm_rig(hold), "stribeck-gauss"))
    assert seen.evident == (share > 0.0)


def test_a_motion_that_begins_while_the_pull_falls_tells_no_scatter() -> None:
    """A joint with one breakaway level; it reverses twice so slowly that it seems to rest."""
    axis = interval_axes.robot(32)
    log = recordings(axis, noisy(axis, np.random.default_rng(32), 0.0))[0]
    rig = as_simulated(RIGS[axis.rig].set(**axis.given))
    parameters, begun = slips(log, rig, axis.law)
    middle = [0.5 * (q.lower + q.upper) for q in parameters.free]
    _, rise = pulls(rig, parameters.law, parameters.full(np.array([middle])), begun)
    assert (rise < 0.0).sum() >= 2
    refusal = f"3 of the {len(begun)} slips in what is trained on begin while the pull rises"
    with pytest.raises(InputError, match=refusal):
        scatter(parameters, begun)
    with pytest.raises(InputError, match=refusal):
        identify(log, rig=rig, law=axis.law, breakaway="scattered")


def test_a_scatter_counts_the_slips_that_tell_it() -> None:
    """Two of all slips begin as if the pull fell."""
    parameters, begun = slips(bed_log(0.1), as_simulated(RIGS["slide-bed"]), "stribeck")
    for k in (1, 4):
        onset = onset_of(begun[k])
        begun[k] = replace(begun[k], onset=replace(onset, direction=-onset.direction))
    assert scatter(parameters, begun).slips == len(begun) - 2


def test_a_scatter_takes_a_rig_that_says_what_pulls() -> None:
    parameters, begun = slips(bed_log(0.1), as_simulated(RIGS["slide-bed"]), "stribeck")
    silent = as_simulated(RIGS["presliding"])
    with pytest.raises(InputError, match="presliding does not say what pulls at an axis"):
        scatter(replace(parameters, rig=silent), begun)


# --- the breakaway of each slip -------------------------------------------------------------------


def test_each_slip_tells_its_own_breakaway() -> None:
    """To a thousandth, once the onsets are where the true motion has them."""
    rig = as_simulated(RIGS["slide-bed"])
    parameters, found = slips(bed_log(0.1), rig, "stribeck")
    p = np.array([CURVE.F_S, CURVE.F_C, CURVE.F_V, CURVE.v_SS, 1.0, K_SPRING])
    moved = moved_onsets(rig, parameters.law, p, found)
    F, _ = pulls(rig, parameters.law, p[None], moved)
    assert len(moved) > 12
    np.testing.assert_allclose(F[0], CURVE.F_S * factors(1, 0.1)[: len(moved)], rtol=1e-3)


@pytest.mark.parametrize("hold", [0.0, 1.0, 2.0])
def test_a_joint_tells_the_breakaway_of_each_slip(hold: float) -> None:
    rig = arm_rig(hold)
    parameters, found = slips(joint_log(0.1, hold), rig, "stribeck-gauss")
    values = {**ARM, **ARM_CURVE._asdict(), "g_cos": 0.0}
    p = np.array([values[q.name] for q in parameters.every])
    moved = moved_onsets(rig, parameters.law, p, found)
    F, _ = pulls(rig, parameters.law, p[None], moved)
    drawn = ARM_CURVE.F_S * factors(1, 0.1)
    nearest = np.abs(F[0][:, None] - drawn[None, :30]).min(axis=1)
    assert len(moved) > 10
    assert np.median(nearest) < 5e-3


def test_the_interval_of_a_spread_holds_it() -> None:
    """Seven slips with an error of half the spread, 400 times: 95 %, give or take 2.2."""
    rng = np.random.default_rng(5)
    held = 0
    for _ in range(400):
        error = np.full(7, 0.5)
        off = rng.standard_normal(7) + error * rng.standard_normal(7)
        _, low, high = spread_of(off, error, 6.0)
        held += low <= 1.0 <= high
    assert stats.binomtest(held, 400, 0.95).pvalue > 0.01


# --- the fit --------------------------------------------------------------------------------------


@cache
def fitted(**options: Any) -> Fit:
    rig = RIGS["slide-bed"].exact()
    return identify(bed_log(0.1), rig=rig, law="stribeck", repeats=1, **options)


def test_scattered_breakaway_is_a_mean_and_a_spread(capsys: pytest.CaptureFixture[str]) -> None:
    fit = fitted()
    by_name = {e.name: e for e in fit.estimates}
    assert by_name["F_S"].low < CURVE.F_S < by_name["F_S"].high
    truth = {"F_C": CURVE.F_C, "F_V": CURVE.F_V, "k_spring": K_SPRING}
    for name, value in truth.items():
        assert by_name[name].value == pytest.approx(value, rel=0.02)
        assert by_name[name].verdict == "identified"
    (spread,) = fit.breakaway
    drawn = CURVE.F_S * factors(1, 0.1)[: spread.slips]
    assert by_name["F_S"].value == pytest.approx(drawn.mean(), rel=5e-3)
    assert spread.sd == pytest.approx(drawn.std(ddof=1), rel=0.05)
    assert spread.low < 0.1 * CURVE.F_S < spread.high
    half = stats.t.ppf(0.975, spread.slips - 1) * drawn.std(ddof=1) / np.sqrt(spread.slips)
    assert by_name["F_S"].high - by_name["F_S"].low == pytest.approx(2 * half, rel=0.1)
    assert fit.score.value == pytest.approx(0.05, rel=0.1)  # mm, the noise
    assert "breakaway scatters by 7 %" in fit.warnings[0].replace("7%", "7 %")
    assert not any("raise" in w for w in fit.warnings)
    show_fit(fit)
    assert f", from slip to slip sd {spread.sd:.2g}" in capsys.readouterr().out


def test_finer_steps_of_the_simulation_reach_the_residuals_of_slips() -> None:
    """What a finer simulation moves is seen, and hardly matters."""
    fit = fitted()
    problem, answer = fit.residuals, fit.uncertainty.profiles
    assert isinstance(problem, MotionProblem)
    rig = as_simulated(problem.parameters.rig)
    finer = problem.on(rig.finer(*arithmetic.FINER)).residuals(answer.x[None])[0]
    assert 0.0 < np.abs(finer - answer.residuals).max() < 0.01 * fit.score.value
    shifts = arithmetic.shifts(problem, fit.uncertainty)
    assert 0.0 < max(shifts.values()) < arithmetic.SHARE


def test_its_card_validates_slip_by_slip() -> None:
    text = fitted().card()
    assert text.breakaway["F_S"].slips == fitted().breakaway[0].slips
    (row,) = validate(text, bed_log(0.1, seed=2))
    assert row[2].value < 0.1  # mm, though each slip breaks away where it likes


def test_a_hold_out_is_scored_slip_by_slip() -> None:
    fit = fitted(holdout="52s:102s", train="0s:52s")
    assert fit.holdout[0].score.value < 2.0 * fit.score.value


def test_ctrl_c_while_its_slips_are_settled_keeps_the_answer(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("stribeck.identify.output_error.settled_slips", interrupted)
    fit = identify(bed_log(0.1), rig=RIGS["slide-bed"].exact(), law="stribeck", repeats=1)
    assert fit.search.ended == "interrupted"
    assert any(w.startswith("interrupted") for w in fit.warnings)
    assert fit.score.value < 1.0


def test_slips_that_a_fit_does_not_follow_identify_nothing() -> None:
    fit = fitted()
    for times, caps in ((1.0, []), (3.0, [True])):
        score = replace(fit.score, value=times * fit.score.value)
        violations = misfit_violations(
            fit.parameters, score, fit.recordings, fit.estimates, rivals=2, repeats=2
        )
        assert [v.caps for v in violations] == caps


# --- refusals -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"law": "coulomb-viscous"}, "no breakaway level F_S of its own"),
        ({"law": "stribeck", "train": "0s:12s"}, "slips in what is trained on, 6 are needed"),
    ],
)
def test_what_cannot_be_asked_slip_by_slip(options: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        identify(bed_log(0.1), rig="slide-bed", breakaway="scattered", **options)


def test_a_law_without_a_breakaway_of_its_own_is_told_of_the_scatter() -> None:
    rig = RIGS["slide-bed"].exact()
    fit = identify(bed_log(0.1), rig=rig, law="coulomb-viscous", repeats=1, budget=200)
    assert "law coulomb-viscous has no level that could" in fit.warnings[0]
    assert not fit.breakaway


def test_an_objective_is_refused_that_there_is_not() -> None:
    with pytest.raises(InputError, match="breakaway 'some' is not one of auto, common, scattered"):
        Objective(breakaway="some")  # type: ignore[arg-type]


def test_a_slide_after_a_low_breakaway_counts_at_its_beginning_alone() -> None:
    """72 N after 130 N: the axis slides for 49 s, and hardly tells when it began to."""
    rig = as_simulated(RIGS["slide-bed"])
    parameters, found = slips(bed_log(0.25, 2), rig, "stribeck")
    p = np.array([CURVE.F_S, CURVE.F_C, CURVE.F_V, CURVE.v_SS, 1.0, K_SPRING])
    F, _ = pulls(rig, parameters.law, p[None], moved_onsets(rig, parameters.law, p, found))
    assert F[0].min() == pytest.approx(CURVE.F_S * factors(2, 0.25)[3], rel=5e-3)
    lasting = [float(s.track.t[-1] - s.track.t[0]) for s in found]
    assert max(lasting) < 4.0 * np.median(lasting)


# --- the search, and how wide intervals are -------------------------------------------------------


@pytest.mark.parametrize(("share", "seed"), [(0.15, 3), (0.25, 1), (0.25, 2)])
def test_a_mean_is_known_as_well_as_a_mean_is(share: float, seed: int) -> None:
    """Half-widths are sd/sqrt(n) times Student's t; repeats confirm each other at wide scatter."""
    fit = identify(bed_log(share, seed), rig=RIGS["slide-bed"].exact(), law="stribeck")
    assert fit.search.method == "descents"
    assert fit.search.evaluations < 2000
    (spread,) = fit.breakaway
    level = next(e for e in fit.estimates if e.name == "F_S")
    drawn = CURVE.F_S * factors(seed, share)[: spread.slips]
    half = stats.t.ppf(0.975, spread.slips - 1) * drawn.std(ddof=1) / np.sqrt(spread.slips)
    assert level.high - level.low == pytest.approx(2 * half, rel=0.1)
    assert level.low < CURVE.F_S < level.high
    assert not any("extrapolated" in w or "repeats came" in w for w in fit.warnings)


def test_a_rest_between_two_steps_of_the_sensor_shifts_its_slip() -> None:
    """The level of a rest under a coarse encoder is off by up to half a step, for all of a slip."""
    rig = arm_rig(1.0)
    parameters, found = slips(joint_log(0.1, 1.0), rig, "stribeck-gauss")
    values = {**ARM, **ARM_CURVE._asdict(), "g_cos": 0.0}
    p = np.array([[values[q.name] for q in parameters.every]])
    moved = moved_onsets(rig, parameters.law, p[0], found)
    F, rise = pulls(rig, parameters.law, p, moved)

    def error(*, levelled: bool) -> float:
        squares = []
        for k, s in enumerate(moved):
            slip = simulated_slip(rig, parameters.law, p, s, F[:, k], rise[:, k], levelled=levelled)
            squares.append(np.mean(np.square(s.track.measured - slip.position[0])))
        return float(np.sqrt(np.mean(squares)))

    assert all(s.onset is not None and s.onset.uncertain <= 2.0e-4 for s in moved)
    assert error(levelled=True) < 0.9 * error(levelled=False)


def test_an_onset_moves_only_to_where_less_of_its_slip_is_left() -> None:
    """Under a set that follows the slips badly, moves by slopes may turn to and fro for ever."""
    rig = arm_rig(1.0)
    parameters, found = slips(joint_log(0.1, 1.0), rig, "stribeck-gauss")
    values = {**ARM, **ARM_CURVE._asdict(), "g_cos": 0.0}
    values |= {"F_C": 1.15 * values["F_C"], "J": 0.7 * values["J"]}
    p = np.array([values[q.name] for q in parameters.every])

    def left(some: Sequence[Segment], *, rough: bool) -> Array:
        F, rise = pulls(rig, parameters.law, p[None], some)
        return np.array([
            unexplained(s, simulated_slip(
                rig, parameters.law, p[None], s, F[:, k], rise[:, k], rough=rough
            ))[0]
            for k, s in enumerate(some)
        ])  # fmt: skip

    moved = moved_onsets(rig, parameters.law, p, found)
    plain = left(moved, rough=False)
    assert (plain <= left(found, rough=False)).all()
    assert (plain < left(found, rough=False)).any()
    # What a fit reports of a slip, whose onset it tries to move on, is not above what it minimised.
    assert (left(moved, rough=True) <= plain).all()


def test_starts_lie_about_what_the_onsets_tell() -> None:
    rig, law = arm_rig(1.0), law_named("stribeck-gauss")
    parameters = partition(rig, law, fixed={"g_cos": 0.0}, objective=BY_SLIP)
    found = segments([joint_log(0.1, 1.0)], rig, None, BY_SLIP)
    known = onset_levels(parameters, found)
    assert known.values["F_S"][0] == pytest.approx(ARM_CURVE.F_S, rel=0.1)
    assert known.values["g_0"][0] == pytest.approx(ARM["g_0"], abs=0.05)
    u = drawn_starts(parameters, found, np.random.default_rng(0))
    x = Space(parameters.free).decode(u)
    for i, q in enumerate(parameters.free):
        if q.name in {"F_C", "F_V", "v_SS", "J"}:  # on both sides of the truth, within decades
            truth = {**ARM, **ARM_CURVE._asdict()}[q.name]
            assert x[:, i].min() < truth < x[:, i].max()
            assert x[:, i].max() < 50.0 * truth


def test_a_comparison_of_laws_says_that_it_has_one_breakaway_for_all() -> None:
    selection = select(
        bed_log(0.15, 3),
        rig=RIGS["slide-bed"].exact(),
        laws=["coulomb-viscous", "stribeck"],
        train="0s:52s",
        holdout="52s:102s",
        budget=300,
    )
    (sentence,) = (s for s in selection.sentences if s.startswith("Breakaway scatters by"))
    assert "here all laws have one breakaway for all" in sentence
