"""What the controller read, where a log tells it: against a foreign loop through a converter."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from foreign import slide_bed, slide_bed_loop
from foreign.clock import Array
from foreign.friction import Curve
from stribeck import Recording, identify
from stribeck.friction import LAWS
from stribeck.identify.held_onset import held_onsets
from stribeck.identify.loss import Objective
from stribeck.identify.own_breakaway import moved_onsets, onset_of, pulls
from stribeck.identify.segment import Segment, segments
from stribeck.identify.validate import validate
from stribeck.rig.loop_reading import read_stretch
from stribeck.rig.slide_bed import SLIDE_BED
from stribeck.rig.twin import TestBed

CURVE = Curve(144.5463, 47.8514, 958.3, 1.0964e-3)
TRUTH = np.array([*CURVE[:4], 1.0, 967.98])
BED = slide_bed.Bed(k_spring_down=967.98)
GAINS = (3500.0, 2800.0)
LAW, RIG = LAWS["stribeck"], SLIDE_BED.exact()
BY_SLIP = Objective(breakaway="scattered")


@cache
def loop(seed: int, seconds: float = 62.0, *, voltage: bool = False, gain: float = 1.0) -> Array:
    """Position, velocity, reading, current and command of a foreign loop."""
    rng = np.random.default_rng(seed)
    times, command = np.array([0.0, 1.0, seconds]), 0.05 + np.array([0, 0, 5e-3 * (seconds - 1.0)])
    noise = 3e-4 * rng.standard_normal(int(seconds * 50) + 2)
    of_loop = slide_bed_loop.Loop(voltage=voltage)
    bed = BED._replace(k_hat_up=gain * BED.k_hat_up)
    return slide_bed_loop.simulate(bed, of_loop, CURVE, CURVE, times, command, 0.044, noise)


def logged(rows: Array, seed: int = 0, force: Array | None = None) -> Recording:
    noise = 0.5 * np.random.default_rng(seed + 1000).standard_normal(rows.shape[1])
    measured = 101.1021 * rows[3] if force is None else force
    t: Array = 0.01 * np.arange(rows.shape[1])
    return Recording(t=t, position=rows[2], command=rows[4], force=measured + noise)


def slips(log: Recording) -> list[Segment]:
    """But for the first one, whose rest before it is short."""
    return segments([log], RIG, None, BY_SLIP)[1:]


def first_moves(rows: Array, log: Recording, passed: list[Segment]) -> Array:
    """The sample before each slip is seen to have begun, s."""
    moving = log.t[(np.abs(rows[1]) > 0.0)]
    return np.array([moving[moving > s.track.t[0]][0] - 0.01 for s in passed])


# --- whether a log tells --------------------------------------------------------------------------


@pytest.mark.parametrize("period", [1, 2])
def test_a_log_tells_what_its_controller_read(period: int) -> None:
    rows = loop(1)[
        :, :: 2 // period
    ]  # the controller read every other sample, or all that are left
    t: Array = 0.02 / period * np.arange(rows.shape[1])
    log = replace(logged(rows), t=t)
    stretch = read_stretch(log, GAINS)
    assert stretch is not None
    k = np.arange(len(stretch)) // period * period
    np.testing.assert_allclose(stretch, (rows[4] - rows[2])[k], atol=1e-12)


def test_logs_that_do_not_tell() -> None:
    rows = loop(1)
    ideal = logged(rows, force=3500.0 * (rows[4] - rows[0]))  # by the position, not the reading
    assert read_stretch(ideal, GAINS) is None
    assert read_stretch(logged(loop(1, voltage=True)), GAINS) is None  # the force is not held
    assert read_stretch(logged(loop(1, gain=0.3)), GAINS) is None  # another controller
    assert read_stretch(replace(logged(rows), force=None), GAINS) is None
    assert read_stretch(replace(logged(rows), command=None), GAINS) is None
    lacking: Array = 0.01 * np.arange(rows.shape[1]) + 0.01 * (np.arange(rows.shape[1]) > 500)
    assert read_stretch(replace(logged(rows), t=lacking), GAINS) is None
    assert read_stretch(TestBed(loop="ideal").run("up").recording, GAINS) is None


def test_slips_of_an_ideal_loop_are_simulated_as_before() -> None:
    for s in slips(TestBed(loop="ideal").run("up").recording):
        assert not s.track.stretch.size
        assert onset_of(s).instant is None


# --- a slip under a force that is held ------------------------------------------------------------


def test_a_slip_under_what_was_read_is_that_of_the_foreign_loop() -> None:
    rows = loop(2)
    log = logged(rows)
    passed = slips(log)
    begins = first_moves(rows, log, passed)
    assert len(passed) > 8
    for s, begin in zip(passed, begins, strict=True):
        theirs = np.interp(s.track.t, log.t, rows[0])
        track = s.track._replace(x0=float(theirs[0]))
        instants = begin + np.linspace(0.0, 0.01, 201)
        motion = RIG.held_slips(LAW, np.tile(TRUTH, (201, 1)), track, instants, 1)
        off = np.abs(motion.position - theirs).max(axis=1).min()
        assert off < 2e-5  # and their Euler's steps are as far from the equation
        held = rows[3][(log.t >= track.t[0] - 1e-9) & (log.t <= track.t[-1] + 1e-9)]
        np.testing.assert_allclose(motion.force[0], 101.1021 * held, atol=1e-3)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_readings_tell_under_which_each_slip_breaks_away(seed: int) -> None:
    """Also where all slips seem to begin 30 ms too early, 4 ms from each other."""
    rows = loop(seed)
    log = logged(rows)
    passed = slips(log)
    begins = first_moves(rows, log, passed)
    shifted = begins - 0.03 + 0.004 * np.random.default_rng(seed).standard_normal(len(begins))
    onsets = held_onsets(RIG, [s.track for s in passed], [onset_of(s) for s in passed], shifted)
    placed = [replace(s, onset=onset) for s, onset in zip(passed, onsets, strict=True)]
    right = [o.after - 1e-9 <= b < o.after + 0.02 for o, b in zip(onsets, begins, strict=True)]
    assert np.mean(right) >= 0.8
    moved = moved_onsets(RIG, LAW, TRUTH, placed)
    F, rise = pulls(RIG, LAW, TRUTH[None], moved)
    assert F[0].mean() == pytest.approx(CURVE.F_S, abs=0.4)
    within = np.abs(F[0] - CURVE.F_S) < 0.5 * rise[0] + 0.15  # what the ramp adds within a hold
    assert np.mean(within) > 0.8
    late = [onset_of(s).instant for s in moved]
    np.testing.assert_allclose(np.array(late, dtype=float), begins + 0.005, atol=0.012)


# --- the fit --------------------------------------------------------------------------------------


@cache
def fitted(**options: Any) -> Any:
    return identify(logged(loop(1)), rig=RIG, law="stribeck", train="112:295", **options)


def test_a_fit_by_what_was_read_holds_the_truth_and_claims_something() -> None:
    fit = fitted()
    assert fit.parameters.objective.by_slip
    assert fit.score.value < 0.33  # mm, the noise and the steps of the converter
    assert "the force of the log follows its reading: each of " in fit.warnings[0]
    truth = dict(zip((q.name for q in fit.parameters.every), TRUTH, strict=True))
    for e in fit.estimates:
        if e.name != "exponent":
            assert e.low <= truth[e.name] <= e.high
    by_name = {e.name: e for e in fit.estimates}
    assert by_name["F_S"].verdict == by_name["F_C"].verdict == "identified"
    (spread,) = fit.breakaway
    assert spread.sd < 0.5
    plain = fitted(breakaway="common")
    level = next(e for e in plain.estimates if e.name == "F_S")
    assert plain.score.value > 1.3 * fit.score.value
    assert level.high - level.low > 2.0 * (by_name["F_S"].high - by_name["F_S"].low)


def test_its_card_validates_by_what_was_read() -> None:
    (row,) = validate(fitted().card(), logged(loop(4)))
    assert row[2].value < 0.35
