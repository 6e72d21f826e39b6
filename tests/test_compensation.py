"""The scale of a compensation: signs of overcompensation, its limit, and the recommendation."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import astuple, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

from command import Completed, caller
from stribeck import RIGS, Card, InputError, identify
from stribeck.compensate.closed_loop import Reference, Sensor
from stribeck.compensate.compensation import Compensation, compensate
from stribeck.compensate.corners import IDENTIFIED, plants
from stribeck.compensate.limit_cycle import Stretch, floors, observed, stretches
from stribeck.compensate.reference_motions import CYCLES, FAST, followed, references
from stribeck.compensate.scale_curve import MARGIN, Onset, ScaleCurve
from stribeck.data.recording import Recording
from stribeck.identify.pace import paced
from stribeck.report.compensation_report import (
    compensation_text,
    figure,
    sentences,
    tables,
    times,
)
from stribeck.rig.slide_bed import PUBLISHED, published_both
from stribeck.rig.twin import TestBed

Given = dict[str, tuple[float, float | None, float | None, str]]


def card_of(law: str, rig: str, parameters: Given, **constants: tuple[float, str]) -> Card:
    """A card of parameters: value, low and high end, unit."""
    fields = {
        "schema": "stribeck-card/1", "law": law, "rig": rig, "kind": rig,
        "constants": {n: {"value": v, "unit": u} for n, (v, u) in constants.items()},
        "parameters": {
            n: {"value": v, "unit": u, "low": low, "high": high, "at_bound": None,
                "verdict": "identified"}
            for n, (v, low, high, u) in parameters.items()
        },
        "objective": {"name": "position_rmse", "value": 0.1, "unit": "mm", "samples": 10},
        "search": {"method": "mbts", "seed": 0, "evaluations": 1, "seconds": 0.1, "ended": "done"},
        "data": [], "software": {},
    }  # fmt: skip
    return Card.model_validate(fields)


KD = 2.0


def robot(F_V: tuple[float, float | None, float | None], F_C: float = 0.0, **ends: Any) -> Card:
    """A joint without gravity, without Coulomb friction unless given."""
    return card_of(
        "coulomb-viscous", "joint",
        {
            "F_C": (F_C, ends.get("F_C_low"), ends.get("F_C_high"), "N m"),
            "F_V": (*F_V, "N m s/rad"),
            "J": (0.5, None, None, "kg m**2"),
            **dict.fromkeys(("g_sin", "g_cos", "g_0"), (0.0, None, None, "N m")),
        },
        kp=(40.0, "N m/rad"), kd=(KD, "N m s/rad"),
    )  # fmt: skip


def bed(**ends: tuple[float | None, float | None]) -> Card:
    """The rightward set of the paper's slide, with intervals where given."""
    values = dict(zip(("F_S", "F_C", "F_V", "v_SS"), PUBLISHED["right"][:4], strict=True))
    units = {"F_S": "N", "F_C": "N", "F_V": "N s/m", "v_SS": "m/s", "k_spring": "N/m"}
    values["k_spring"] = PUBLISHED["right"][5]
    return card_of(
        "stribeck", "slide-bed",
        {n: (v, *ends.get(n, (None, None)), units[n]) for n, v in values.items()},
    )  # fmt: skip


def servo(*, together: bool = True) -> Card:
    """A pendulum's servo of which k_t / R = 0.1 and F_V + k_t²/R = 0.03 are known.

    Args:
        together: Whether the card has the others at the end of each.
    """
    values: Given = {
        "F_S": (0.07, None, None, "N m"), "F_C": (0.04, None, None, "N m"),
        "F_V": (0.02, 0.005, 0.029, "N m s/rad"), "v_SS": (0.1, None, None, "rad/s"),
        "k_t": (0.1, 0.01, 0.25, "N m/A"), "R": (1.0, 0.1, 2.5, "ohm"),
        "armature": (1e-3, None, None, "kg m**2"), "q_offset": (0.0, None, None, "mrad"),
    }  # fmt: skip
    names = {q.name for q in RIGS["servo-pendulum"].parameters(_law("stribeck"))}
    written = card_of("stribeck", "servo-pendulum", {n: v for n, v in values.items() if n in names})
    low = {"k_t": 0.01, "R": 0.1, "F_V": 0.029}
    high = {"k_t": 0.25, "R": 2.5, "F_V": 0.005}
    others = {
        n: {"others_at_low": {m: v for m, v in a.items() if m != n},
            "others_at_high": {m: v for m, v in b.items() if m != n}}
        for n, a, b in (("k_t", low, high), ("R", low, high), ("F_V", high, low))
        if together
    }  # fmt: skip
    parts = {n: q.model_copy(update=others.get(n, {})) for n, q in written.parameters.items()}
    return written.model_copy(update={"parameters": parts})


def only(compensated: Compensation, mode: str) -> ScaleCurve:
    return next(c for c in compensated.curves if c.mode == mode)


# --- signs, on motions made by hand -------------------------------------------------------------

T = np.arange(0.0, 10.0, 0.01)
RAMP = Reference("ramp", T, np.interp(T, [1.0, 9.0], [0.0, 0.8]))
STRETCHES = stretches(RAMP, 1e-3)


def looked(error: Any, floor: float = 1e-3, baseline: Any = 0.0, reference: Any = RAMP) -> set[str]:
    """The signs of an error over time beyond those of a baseline's."""
    parts = stretches(reference, 1e-3)

    def seen(e: Any) -> Any:
        x = np.broadcast_to(reference.x - e, reference.x.shape)[None]
        v = np.gradient(x[0], T)[None].copy()
        v[np.abs(v) < 1e-9] = 0.0
        return observed(reference, parts, x, v, 1e-3, np.array([floor]))

    shown = seen(error).beyond(seen(baseline))
    return {name for name, present in shown.items() if present[0]}


SLIDES = (T > 1.0) & (T < 9.0)
SWING = 0.01 * np.sin(5.0 * T) * SLIDES
BEHIND = 0.1 * ((T - 1.0) % 1.0) * SLIDES  # rests, then jumps after the reference


def test_stretches_are_where_the_reference_moves_one_way_or_rests() -> None:
    assert [(s.direction, s.even) for s in STRETCHES] == [(0, False), (1, True), (0, False)]
    assert STRETCHES[1] == Stretch(100, 900, 1, True)  # its velocity is that of the sample to come
    bent = Reference("sine", T, np.sin(T))
    assert [s.even for s in stretches(bent, 1e-3)] == [False] * 4


def test_a_lasting_swing_is_told_from_a_decaying_one() -> None:
    assert looked(SWING) == {"swings on"}
    assert looked(SWING * np.exp(-0.5 * T)) == set()
    assert looked(SWING, floor=0.05) == set()


def test_an_axis_that_rests_behind_its_reference_sticks_and_slips() -> None:
    assert looked(BEHIND) == {"sticks and slips"}
    assert looked(BEHIND - 0.2) == {"sticks and slips"}  # the same ahead of the reference


def test_what_does_not_settle_without_compensation_is_not_the_compensations() -> None:
    assert looked(0.5 * BEHIND, baseline=BEHIND) == set()
    assert looked(SWING, baseline=BEHIND) == set()
    assert looked(BEHIND, baseline=SWING) == set()
    assert looked(SWING, baseline=SWING * np.exp(-0.5 * T)) == {"swings on"}
    elsewhere = np.where(T > 9.0, 0.01 * np.sin(20.0 * T), 0.0)
    assert looked(SWING, baseline=elsewhere) == {"swings on"}  # stretch by stretch


def test_where_the_speed_changes_swings_are_counted() -> None:
    turns = Reference("sine", T, 0.4 * (1.0 - np.cos(np.pi * T / 5.0)))  # 0.25 m/s at most
    lag = 0.05 * np.sin(np.pi * T / 5.0)
    assert looked(lag, reference=turns) == set()
    assert looked(lag + 0.01 * np.sin(9.0 * T), reference=turns) >= {"swings on"}
    decaying = 0.01 * np.sin(9.0 * T) * np.exp(-1.5 * (T % 5.0))
    assert "swings on" not in looked(lag + decaying, reference=turns)
    stuck = np.where((T > 3.0) & (T < 3.5), turns.x - turns.x[300], lag)
    assert looked(stuck, reference=turns) >= {"sticks and slips"}


def test_share_at_rest_and_peak_speed() -> None:
    x = RAMP.x - BEHIND
    v = np.gradient(x, T)[None].copy()
    v[np.abs(v) < 1e-9] = 0.0
    shown = observed(RAMP, STRETCHES, x[None], v, 1e-3, np.array([1e-3]))
    assert shown.at_rest[0] == pytest.approx(0.98, abs=0.02)
    assert shown.peak[0] == pytest.approx(np.abs(v).max())
    assert shown.swing[0].max() == pytest.approx(0.099, rel=0.02)


def test_moving_back_creeping_and_running_away_are_told() -> None:
    assert "runs back" in looked(0.05 * np.sin(5.0 * T))  # 0.25 m/s against 0.1 m/s
    assert "runs back" not in looked(0.01 * np.sin(5.0 * T))
    assert looked(np.where(T > 9.0, 0.01 * np.sin(20.0 * T), 0.0)) == {"creeps on"}
    assert looked(np.where(T > 5.0, np.nan, 0.0)) == {"runs away"}


def test_a_lag_after_a_reversal_is_no_running_back() -> None:
    turn = Reference("turn", T, np.interp(T, [0.0, 5.0, 10.0], [0.0, 0.5, 0.0]))
    late = np.interp(T - 0.3, T, turn.x)  # goes on for 0.3 s after the reference has turned
    assert looked(turn.x - late, reference=turn) == set()


def test_the_floor_is_a_share_of_the_error_or_two_counts() -> None:
    without = (RAMP.x - 0.5 * (T > 3))[None]
    assert floors(RAMP, without, 0.0) == pytest.approx(0.005)
    assert floors(RAMP, without, 0.01) == pytest.approx(0.02)


# --- too much, where it is certain --------------------------------------------------------------


@pytest.mark.parametrize("F_V", [3.0, 8.0])
def test_viscous_friction_beyond_the_damping_of_all_else_is_unstable(F_V: float) -> None:
    """J s² + (k_d + F_V − s F_V) s + k_p has roots to the right from s = 1 + k_d / F_V on."""
    edge = 1.0 + KD / F_V
    stable, unstable = (
        compensate(robot((F_V, None, None)), speed=0.5, mode="feedback", scale=s)
        for s in (edge - 0.1, edge + 0.1)
    )
    at = only(unstable, "feedback")
    assert at.onset is not None
    assert at.onset.sign in ("runs away", "runs back", "swings on")
    assert at.onset.scale == pytest.approx(edge + 0.1, abs=1e-3)
    assert unstable.mode is None
    # Below, the scale itself is clean; what is a margin above it may not be.
    onset = only(stable, "feedback").onset
    assert onset is None or onset.scale > edge - 0.1


def test_the_edge_of_stability_is_found() -> None:
    F_V = 8.0
    curve = only(compensate(robot((F_V, None, None)), speed=0.5, mode="feedback"), "feedback")
    assert curve.onset is not None
    # A sample's delay costs some damping: k_p h / 2 of 2 N m s/rad, and it takes growth to be seen.
    assert curve.onset.scale == pytest.approx(1.0 + KD / F_V, abs=0.06)
    assert curve.scale is not None
    assert curve.scale <= curve.onset.scale - MARGIN + 1e-9


def test_without_feedback_nothing_can_become_unstable() -> None:
    curve = only(compensate(robot((8.0, None, None)), speed=0.5, mode="reference"), "reference")
    assert curve.onset is None or curve.onset.sign == "is worse"
    assert np.isfinite(curve.rms).all()


def test_the_ends_of_intervals_are_tried_and_hold_the_scale_back() -> None:
    """An axis with 5 where 8 N m s/rad are believed is unstable from (5 + k_d) / 8 = 0.875 on."""
    for low, clean in ((7.9, True), (5.0, False)):
        result = compensate(robot((8.0, low, 8.1)), speed=0.5, mode="feedback", scale=0.9)
        onset = only(result, "feedback").onset
        assert (result.mode is not None) is clean
        if clean:
            assert onset is None
        else:
            assert onset is not None
            assert (onset.plant, onset.scale) in {("F_V low", 0.9), ("all friction low", 0.9)}


# --- what is tried ------------------------------------------------------------------------------


def test_axes_are_the_card_and_its_ends_in_si() -> None:
    written = bed(F_S=(140.0, 150.0), F_V=(900.0, None), k_spring=(950.0, 967.98))
    parts = written.parameters
    shown = {**parts, "F_V": parts["F_V"].model_copy(
        update={"value": 0.9583, "low": 0.9, "unit": "N s/mm"})}  # fmt: skip
    model, p = written.model_copy(update={"parameters": shown}).model()
    axes, messages = plants(written.model_copy(update={"parameters": shown}), model, p)
    assert list(axes) == [
        IDENTIFIED, "F_S low", "F_S high", "F_V low", "k_spring low", "all friction low",
        "all friction high",
    ]  # fmt: skip
    assert axes["F_V low"][2] == pytest.approx(900.0)
    np.testing.assert_allclose(axes["all friction low"][:3], [140.0, p[1], 900.0])
    assert axes["all friction low"][-1] == p[-1]  # the spring does not rub
    (message,) = messages
    assert "F_V high" in message
    assert "F_V low" not in message


def test_an_end_that_is_no_friction_is_left_out_and_told() -> None:
    written = bed(F_S=(20.0, 150.0))
    axes, messages = plants(written, *written.model())
    assert "F_S low" not in axes
    assert any(s.startswith("F_S low: no friction") for s in messages)


def test_axes_at_an_end_have_the_others_as_refitted_there() -> None:
    """k_t and R of a servo whose position alone was logged: their ratio, and F_V + k_t²/R."""
    written = servo()
    parameters, p = written.model()
    names = [q.name for q in parameters.every]
    axes, _ = plants(written, parameters, p)
    k_t, R, F_V = (names.index(n) for n in ("k_t", "R", "F_V"))
    for axis in axes.values():
        assert axis[k_t] / axis[R] == pytest.approx(p[k_t] / p[R], rel=1e-3)
    for name in ("F_V low", "F_V high", "k_t low", "k_t high", "all friction low"):
        axis = axes[name]
        assert axis[F_V] + axis[k_t] ** 2 / axis[R] == pytest.approx(0.03, abs=1e-4)
    alone = servo(together=False)
    apart = plants(alone, *alone.model())[0]
    assert apart["k_t low"][R] == p[R]


def test_a_card_that_knows_a_ratio_alone_is_compensated() -> None:
    """One axis with half of k_t, the others as they are, is none that the log allows."""
    ramp = references(0.1, 0.5, 0.0, 1e-3)[1]
    known, apart = (
        compensate(servo(together=t), reference=ramp, mode="reference", scale=0.9)
        for t in (True, False)
    )
    assert (known.mode, apart.mode) == ("reference", None)
    harm = only(apart, "reference").harm
    assert harm is not None
    assert harm.plant in {"k_t low", "k_t high", "R low", "R high"}


def test_a_card_that_names_no_parameter_of_its_own_is_refused() -> None:
    written = bed(F_S=(140.0, 150.0))
    strange = {"F_S": written.parameters["F_S"].model_copy(update={"others_at_low": {"k_t": 1.0}})}
    written = written.model_copy(update={"parameters": {**written.parameters, **strange}})
    with pytest.raises(InputError, match="F_S: beside its low end stands 'k_t', no parameter"):
        plants(written, *written.model())


def test_a_swing_that_gravity_makes_is_not_hunting() -> None:
    """A soft loop that lifts a weight through whole turns lags by what the weight pulls."""
    heavy = robot((3.0, None, None), F_C=1.0)
    pulls = {"g_sin": heavy.parameters["g_sin"].model_copy(update={"value": 5.0})}
    heavy = heavy.model_copy(update={"parameters": {**heavy.parameters, **pulls}})
    turns = references(1.0, 20.0, 0.0, 1e-3)[0]
    curve = only(compensate(heavy, reference=turns, mode="feedback", scale=0.8), "feedback")
    assert curve.onset is None
    assert curve.rms[1, 0, 0] > 0.02  # it swings, by g_sin / (k_p + ...) and more


def test_references_go_both_ways_and_rest_where_they_turn() -> None:
    slow, fast, sine = references(0.005, 0.1, 0.2, 1e-3)
    assert np.abs(slow.v).max() == pytest.approx(0.005)
    assert np.abs(fast.v).max() == pytest.approx(FAST * 0.005)
    for reference in (slow, fast, sine):
        assert reference.x[0] == 0.2
        assert reference.x[-1] == pytest.approx(0.2)
        assert reference.v.min() == pytest.approx(-reference.v.max(), rel=1e-6)
    assert [s.direction for s in stretches(slow, 1e-6)] == [0, 1, 0, -1, 0]


def test_a_ramp_lasts_long_enough_to_tell_a_swing_from_a_transient() -> None:
    for ramp in references(0.005, 0.1, 0.0, 1e-3, period=1.46)[:2]:
        moving = np.count_nonzero(ramp.v > 0.0) * ramp.h
        assert moving >= CYCLES * 1.46 - 2e-3


def test_the_pace_of_a_log_is_its_commands() -> None:
    log = TestBed(speed=0.007).run("up", seed=1).recording
    pace = paced([log])
    assert pace is not None
    np.testing.assert_allclose(astuple(pace), (0.007, 0.3, 0.05), rtol=1e-3)
    measured = paced([replace(log, command=None)])  # a slide that jumps
    assert measured is not None
    assert measured.speed > 0.007
    assert paced([replace(log, command=np.zeros(len(log)))]) is None
    followed_log = followed(log, 2e-3)
    assert followed_log.h == pytest.approx(2e-3)
    assert log.command is not None
    at = np.arange(0, len(log), 50)
    np.testing.assert_allclose(
        np.interp(log.t[at], followed_log.t, followed_log.x), log.command[at], atol=1e-9
    )


# --- what is recommended ------------------------------------------------------------------------


def test_a_slide_that_sticks_needs_feedback_and_gains_fivefold_both_ways() -> None:
    """Identified on a noisy recording of the twin; tried on the axis that made it."""
    fit = identify(
        TestBed().run("both", seed=3).recording,
        rig="slide-bed",
        law="stribeck-directional",
        budget=1500,
    )
    ramp = references(0.005, 0.1, 0.0, 1e-3)[0]
    result = compensate(fit, reference=ramp, scale=0.9, beside={"truth": published_both()})
    curve, forward = only(result, "feedback"), only(result, "reference")
    assert result.mode == "feedback"
    assert curve.best is not None
    truth = result.plants.index("truth")
    assert curve.ratio[curve.best, truth, 0] < 1 / 5
    assert curve.worst[curve.best] < 1 / 3
    # Where steady sliding is not stable, feed-forward cannot make it so.
    assert forward.ratio[1, truth, 0] > 1 / 3


def test_the_simpler_mode_is_taken_where_it_is_as_good() -> None:
    exact = robot((3.0, 2.9, 3.1), F_C=1.0, F_C_low=0.95, F_C_high=1.05)
    result = compensate(exact, reference=references(0.2, 1.0, 0.0, 1e-3)[0])
    assert result.mode == "reference"
    assert result.compensator is not None
    assert result.compensator.feedback is False
    assert result.curve is not None
    assert result.curve.scale is not None
    assert 0.8 <= result.curve.scale <= 1.0
    # What is left is about what the loop leaves without friction.
    assert result.curve.best is not None
    errors = result.curve.outcomes[result.curve.best].rms[0]
    np.testing.assert_allclose(errors, result.frictionless, rtol=0.3, atol=2e-5)


def test_a_card_that_knows_nothing_is_not_compensated() -> None:
    ignorant = robot((1.0, 0.0, 2.0), F_C=1.0, F_C_low=0.0, F_C_high=2.0)
    result = compensate(ignorant, reference=references(0.2, 1.0, 0.0, 1e-3)[0])
    assert result.mode is None
    assert result.compensator is None
    assert all(c.best is None for c in result.curves)
    assert all(c.harm is not None for c in result.curves)


def test_a_coarse_sensor_is_told_and_sets_the_dead_band_of_the_measured_speed() -> None:
    written = robot((3.0, None, None), F_C=1.0)
    fine = compensate(written, speed=0.5, scale=0.9, sensor=Sensor(1e-5))
    assert fine.compensator is not None
    coarse = compensate(written, speed=0.5, scale=0.9, sensor=Sensor(1e-3))
    assert any("the sensor's steps hide speeds" in note for note in coarse.notes)
    shape = only(coarse, "feedback")
    assert shape.outcomes  # tried all the same


@pytest.mark.parametrize("sensor", [Sensor(noise=0.3e-3), Sensor(resolution=0.0977e-3)])
def test_a_sensor_does_not_switch_feed_forward_off(sensor: Sensor) -> None:
    """Its dead band is far above the reference's speed, which is known without a sensor."""
    ideal, seen = (
        only(
            compensate(
                bed(), reference=references(0.005, 0.05, 0.0, 1e-3)[1], mode="reference",
                scale=0.8, sensor=s,
            ),
            "reference",
        )
        for s in (Sensor(), sensor)
    )  # fmt: skip
    np.testing.assert_allclose(seen.rms, ideal.rms, rtol=1e-6)
    assert seen.ratio[1].max() < 0.9


def test_a_law_that_is_smooth_through_rest_is_asked_where_it_has_risen() -> None:
    values: Given = {
        "F_S": (150.0, None, None, "N"), "F_C": (50.0, None, None, "N"),
        "F_V": (900.0, None, None, "N s/m"), "v_SS": (2e-3, None, None, "m/s"),
        "v_brk": (1e-4, None, None, "m/s"), "k_spring": (900.0, None, None, "N/m"),
    }  # fmt: skip
    law = RIGS["slide-bed"].parameters(_law("stribeck-smooth"))
    names = {q.name for q in law}
    written = card_of(
        "stribeck-smooth", "slide-bed", {n: v for n, v in values.items() if n in names}
    )
    result = compensate(written, speed=0.005, mode="feedback", scale=0.9)
    assert result.compensator is not None
    assert result.compensator.rest > 1e-5


def _law(name: str) -> Any:
    from stribeck.friction import law_named  # noqa: PLC0415

    return law_named(name)


# --- the command --------------------------------------------------------------------------------


@pytest.fixture
def stribeck(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Callable[..., Completed]:
    return caller(monkeypatch, capsys)


def written_to(folder: Path, written: Card) -> str:
    file = folder / "card.json"
    file.write_text(written.text(), encoding="utf-8")
    return str(file)


def test_the_command_says_yes_with_its_files(stribeck: Any, tmp_path: Path) -> None:
    file = written_to(tmp_path, robot((3.0, 2.9, 3.1), F_C=1.0, F_C_low=0.95, F_C_high=1.05))
    options = ("--speed", "0.2", "--scale", "0.9", "--mode", "reference")
    completed = stribeck("compensate", file, *options, "--out", str(tmp_path / "out"), "--json")
    assert completed.status == 0
    document = json.loads(completed.out)
    assert document["recommended"]["scale"] == 0.9
    assert document["recommended"]["settings"]["feedback"]["value"] == 0.0
    assert sorted(f.name for f in (tmp_path / "out").iterdir()) == [
        "compensation.json", "compensation.png", "compensation.svg",
    ]  # fmt: skip
    assert (tmp_path / "out" / "compensation.json").read_text(encoding="utf-8") == completed.out


def test_the_command_says_no_with_status_1(stribeck: Any, tmp_path: Path) -> None:
    file = written_to(tmp_path, robot((1.0, 0.0, 2.0), F_C=1.0, F_C_low=0.0, F_C_high=2.0))
    completed = stribeck("compensate", file, "--speed", "0.2", "--scale", "0.9")
    assert completed.status == 1
    assert "do not compensate" in " ".join(completed.out.split())


def test_a_reference_may_be_a_log(stribeck: Any, tmp_path: Path) -> None:
    t = np.arange(0.0, 4.0, 0.02)
    q = 0.2 * (1 - np.cos(np.pi * t / 2))
    log = tmp_path / "log.csv"
    rows = "\n".join(f"{a:.6f},{b:.9f},{b:.9f}" for a, b in zip(t, q, strict=True))
    log.write_text(f"t_s,q_rad,q_cmd_rad\n{rows}\n", encoding="utf-8")
    file = written_to(tmp_path, robot((3.0, 2.9, 3.1), F_C=1.0))
    completed = stribeck("compensate", file, "--reference", str(log), "--scale", "0.9", "--json")
    assert completed.status == 0
    assert json.loads(completed.out)["motions"] == ["log.csv"]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ([], "its logs are not beside it: give --speed or --reference"),
        (["--speed", "0"], "speed"),
        (["--speed", "0.2", "--period", "0"], "--period"),
        (["--speed", "0.2", "--period", "10000"], "samples at a period"),
        (["--speed", "0.2", "--mode", "both"], "--mode 'both'"),
        (["--speed", "0.2", "--scale", "-1"], "scale"),
        (["--speed", "0.2", "--reference", "x.csv"], "give one"),
        (["--speed", "0.2", "--rig", "forced-rotary"], "has no controller"),
        (["--speed", "0.2", "--rig", "slide-bed"], "parameter k_spring is missing"),
        (["--speed", "0.2", "--mode", "crossover"], "does not fall up to a speed"),
        (["--speed", "0.2", "--resolution", "-1"], "resolution"),
    ],
)
def test_misuse_is_one_line_and_status_2(
    stribeck: Any, tmp_path: Path, options: list[str], message: str
) -> None:
    file = written_to(tmp_path, robot((3.0, 2.9, 3.1), F_C=1.0).model_copy(update={"data": [_LOG]}))
    completed = stribeck("compensate", file, *options)
    assert completed.status == 2
    assert message in completed.err
    assert completed.err.count("\n") == 1


_LOG = identify(
        Recording(t=np.arange(400) / 100, position=np.sin(np.arange(400) / 50) / 9,
                  force=np.cos(np.arange(400) / 50)),
        rig="forced", law="coulomb-viscous",
    ).card().data[0].model_copy(update={"file": "gone.csv"})  # fmt: skip


def test_json_has_every_axis_and_null_where_one_ran_away() -> None:
    result = compensate(robot((8.0, None, None)), speed=0.5, mode="feedback", scale=3.0)
    document = json.loads(compensation_text(result))
    assert document["recommended"] is None
    feedback = document["modes"]["feedback"]
    for name in ("rms", "swing", "at_rest", "peak"):
        assert len(feedback[name]) == len(feedback["scales"])
        assert len(feedback[name][0]) == len(document["axes"])
    assert times(0.25) == "4×"
    assert times(float("inf")) == "–"


def test_a_card_of_another_axis_is_refused() -> None:
    with pytest.raises(InputError, match="has no controller"):
        compensate(robot((3.0, None, None)), RIGS["forced-rotary"], speed=0.2)
    with pytest.raises(InputError, match="is missing"):
        compensate(robot((3.0, None, None)), RIGS["emps"], speed=0.2)


def test_the_legends_of_the_figure_stay_in_it() -> None:
    """Also where both modes stick and slip from some scale on, and have the longest labels."""
    result = compensate(robot((1.0, 0.5, 1.5), F_C=1.0), speed=0.2)
    onset = Onset(0.03125, "sticks and slips", "F_C at its lower end", "ramp")
    curves = tuple(replace(curve, onset=onset) for curve in result.curves)
    drawn = figure(replace(result, curves=curves))
    FigureCanvasAgg(drawn)
    drawn.draw_without_rendering()
    width, height = drawn.bbox.size
    assert len(drawn.legends) == 2
    for legend in drawn.legends:
        box = legend.get_window_extent()
        assert 0 <= box.x0 < box.x1 <= width
        assert 0 <= box.y0 < box.y1 <= height


def test_a_scale_that_is_worse_than_none_is_told_where_no_sign_of_too_much_is() -> None:
    """A quarter of the friction that the card believes rubs on the worst axis."""
    result = compensate(robot((0.2, None, None), F_C=4.0, F_C_low=1.0), mode="reference", speed=0.5)
    assert only(result, "reference").onset is None
    (told,) = [s for s in sentences(result) if s.startswith("reference:")]
    assert told.startswith("reference: no sign of too much up to scale 1.3, but worse than without")
    named = told.partition(" at ")[2].split(", ")
    marked = [row[0].text for row in tables(result)[0].rows if "!" in row[2].text]
    assert marked == named
