"""What a fit says of its misfit: causes that hold, and directions that were driven."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np
import pytest

from stribeck.data.recording import Recording
from stribeck.friction import LAWS
from stribeck.identify.data_split import data_split
from stribeck.identify.fit_warnings import misfit_violations, shared_directions
from stribeck.identify.loss import SQUARES, Objective
from stribeck.identify.parameters import partition
from stribeck.identify.score import Score
from stribeck.identify.segment import SegmentSplit, directions_of, segments, split_segments
from stribeck.identify.uncertainty.estimates import Estimate
from stribeck.rig.experiments.offer import OperatingRange
from stribeck.rig.experiments.ramps import ramps
from stribeck.rig.slide_bed import SLIDE_BED
from stribeck.rig.twin import TestBed

BED = partition(SLIDE_BED, LAWS["stribeck"])
LOG = TestBed().run("up", seed=3).recording
F_S = Estimate("F_S", 1.0, 0.1, 0.0, 0.9, 1.1, None, "weak", "N")
#: mm: half a smooth motion's error, and far above the sensor's noise.
LITTLE, NOISY = (Score("position_rmse", J, "mm", 80.0, 10.0, 500) for J in (6.0, 3.0))


def sentence(score: Score, rivals: int, estimate: Estimate = F_S) -> str:
    (violation,) = misfit_violations(BED, score, [LOG], [estimate], rivals, 3)
    return violation.sentence


@pytest.mark.parametrize("score", [LITTLE, NOISY])
def test_repeats_are_asked_for_where_they_disagree(score: Score) -> None:
    assert "raise repeats" in sentence(score, 1)
    assert "raise repeats" not in sentence(score, 3)


def test_ranges_are_to_be_widened_where_a_parameter_sits_at_their_end() -> None:
    assert "widen" not in sentence(LITTLE, 3)
    at_end = replace(F_S, at_bound="upper")
    assert "widen the range of F_S (bounds)" in sentence(LITTLE, 3, at_end)


def test_a_log_without_noise_has_no_multiple_of_it() -> None:
    """As a simulator writes it: any J is infinitely many times its noise."""
    still = Recording(LOG.t, np.where(LOG.t < LOG.t[-1] / 2, 0.0, 0.1), command=LOG.command)
    (violation,) = misfit_violations(BED, NOISY, [still], [F_S], 3, 3)
    assert violation.sentence.startswith("J is 3 mm, and the log shows no noise: the repeats")
    steps = replace(NOISY, value=1e-5)
    assert not misfit_violations(BED, steps, [still], [F_S], 3, 3)


def shared(name: Literal["up", "both"], *, restart: bool) -> bool:
    """Whether a fit to a log of a twin says that both directions share one parameter set."""
    log = TestBed().run(name, seed=3).recording
    train = tuple(segments([log], SLIDE_BED, None, Objective(restart=restart)))
    split = SegmentSplit(train, ())
    return bool(shared_directions(BED, split.train))


@pytest.mark.parametrize("restart", [False, True])
def test_directions_share_a_set_only_where_both_were_driven(restart: bool) -> None:
    assert not shared("up", restart=restart)
    assert shared("both", restart=restart)


def test_a_rest_between_slips_is_no_direction() -> None:
    pieces = segments([LOG], SLIDE_BED, None, Objective(restart=True))
    assert directions_of(pieces) == {1}


def test_noise_about_a_single_slip_is_no_direction() -> None:
    """It goes about 12 mm, and the noise about its rests has extremes that are 2 mm apart."""
    both = TestBed().run("both", seed=0).recording
    data = data_split(both, ["325:127"], ["352:325"], SLIDE_BED)
    ((_, held_out),) = split_segments(data, SLIDE_BED, SQUARES).holdout
    assert directions_of(held_out) == {-1}


@pytest.mark.parametrize(("direction", "word"), [(1, "growing"), (-1, "falling")])
def test_a_plan_names_the_direction_that_was_driven(direction: int, word: str) -> None:
    axis = OperatingRange(
        LAWS["stribeck"], np.ones(6), {}, {"position": "mm", "velocity": "mm/s", "force": "N"}, (),
        0.01, 0.0, 0.3, 0.005, 0.1, 0.02, 200.0, (direction,),
    )  # fmt: skip
    words = [offer.words for offer in ramps(axis, 60.0) if "from rest: " in offer.words]
    assert words
    assert all(f"in the direction of {word} position" in text for text in words)
    assert axis.shown("position", 3e-5) == "0.03 mm"


@pytest.mark.parametrize("score", [LITTLE, NOISY])
def test_a_single_search_names_the_command_that_makes_more(score: Score) -> None:
    (violation,) = misfit_violations(BED, score, [LOG], [F_S], 1, 1)
    assert "identify with repeats=3" in violation.sentence
    assert "raise" not in violation.sentence
