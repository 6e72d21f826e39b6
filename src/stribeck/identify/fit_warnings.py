"""Warnings about a fit by output error."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..data.recording import Recording
from ..friction import LAWS
from ..rig import Rig
from ..rig.simulated import as_simulated
from ..rig.two_masses import TwoMassRig
from ..units import unit
from ..wording import option
from .conditions import Violation
from .exact_constants import scale
from .parameters import Parameters
from .score import Score
from .segment import Segment, SegmentSplit, directions_of, recordings_of
from .sliding_check import never_slid
from .uncertainty.estimates import Estimate
from .uncertainty.sensor_noise import sensor_noise

#: A repeat of the search confirms an answer if its misfit is within this factor of the best.
RIVAL = 1.1
#: A misfit above this share of the best smooth motion's explains little.
LITTLE = 0.5
#: A misfit above this many times the sensor's own noise leaves something unexplained, if it is also
#: above this share of an unmoved axis' misfit: below that the steps of a simulation show.
NOISY, NOISELESS = 1.5, 1e-5


def _resting(score: Score, floor: float) -> list[str]:
    if score.still > NOISY * floor:
        return []
    fault = "the axis hardly moves in what was trained on: that supports nothing"
    return [f"{fault}, train on a range in which it moves"]


def explains_little(parameters: Parameters, score: Score) -> bool:
    """Whether a smooth motion, or none where each segment is a slip, does nearly as well."""
    baseline = score.still if parameters.objective.by_leg else score.smooth
    return score.value >= LITTLE * baseline


def misfit_violations(
    parameters: Parameters,
    score: Score,
    recordings: Sequence[Recording],
    estimates: Sequence[Estimate],
    rivals: int,
    repeats: int,
) -> list[Violation]:
    """What a misfit beyond the noise says of a fit by output error, and what its cause may be.

    Args:
        parameters: Rig and law.
        score: The misfit.
        recordings: The logs.
        estimates: The parameters; one at an end of its range is a cause.
        rivals: Repeats of the search that explain the data as well as the best; only one leaves
            the search as a cause.
        repeats: All of them.
    """
    search = "" if rivals > 1 else _unconfirmed(repeats)
    rig = parameters.rig
    if isinstance(rig, TwoMassRig) and not rig.commanded:
        sentence = (
            "no controller holds the two masses, so that where in its play and how fast the motion "
            "began moves all that follows, which no interval knows: log the axis in a loop, with "
            "its command, and state [controller]"
        )
        return [Violation("model", sentence)]
    if explains_little(parameters, score):
        ends = [f"the range of {e.name} ({option('bounds')})" for e in estimates if e.at_bound]
        causes = [
            *([_more(repeats)] if search else []),
            *([f"widen {' and '.join(ends)}"] if ends else []),
            "check the rig's constants and the units of the log",
        ]
        beside = (
            f"an axis that never moves has {score.still:.3g} {score.unit}"
            if parameters.objective.by_leg
            else f"a smooth motion without stick-slip has {score.smooth:.3g} {score.unit}"
        )
        sentence = (
            f"the model explains little: J is {score.value:.3g} {score.unit}, {beside}: "
            f"{', or '.join(causes)}"
        )
        return [Violation("model", sentence)]
    floor = noise_floor(parameters.rig, recordings)
    if score.value > max(NOISY * floor, NOISELESS * score.still):
        rest = (
            "how a slip goes on is not all in law and rig"
            if parameters.objective.by_slip
            else "the rig leaves something out"
        )
        sentence = f"{_beside(score, floor)}: {search or 'the repeats agree, so that '}{rest}"
        # Single slips have no phase to lose: what the true model leaves of them is the noise.
        return [Violation("model", sentence, caps=parameters.objective.by_slip)]
    return []


def _beside(score: Score, floor: float) -> str:
    """J beside the noise of the sensor; a simulator's log may have none."""
    if not floor:
        return f"J is {score.value:.3g} {score.unit}, and the log shows no noise"
    times = f"{score.value / floor:.2g} times the noise of the sensor"
    return f"J is {times} ({floor:.3g} {score.unit})"


def _unconfirmed(repeats: int) -> str:
    once = (
        "a single search was made" if repeats == 1 else f"at most 1 of {repeats} repeats reached it"
    )
    return f"{once} and may have missed the best fit ({_more(repeats)}), or "


def _more(repeats: int) -> str:
    """What to do where repeats do not confirm each other; a comparison of laws makes one each."""
    return f"identify with {option('repeats', 3)}" if repeats == 1 else f"raise {option('repeats')}"


def noise_floor(rig: Rig, logs: Sequence[Recording]) -> float:
    """What the sensors alone leave of J: noise and quantisation, in the unit of J.

    Third differences of the motion show it, and rests where they are flat; over logs it is a root
    of the mean square, as J is.
    """
    floor = float(np.sqrt(np.mean(np.square([sensor_noise(log) for log in logs]))))
    return float(unit(rig.shows.get("position", "m")).from_si(floor))


def output_error_warnings(
    parameters: Parameters,
    score: Score,
    segments: SegmentSplit,
    recordings: Sequence[Recording],
    rivals: int,
    repeats: int,
) -> list[str]:
    """What a reader must know about a fit by output error, a sentence each.

    Args:
        parameters: Rig and law.
        score: Its misfit.
        segments: What was trained on and held out.
        recordings: The logs.
        rivals: Repeats of the search that explain the data as well as the best.
        repeats: All of them.
    """
    train, tests = segments.train, segments.holdout
    warnings = never_slid(parameters, recordings_of(train))
    warnings += _resting(score, noise_floor(parameters.rig, recordings))
    if rivals < 2 <= repeats:  # noqa: PLR2004 - an answer found once is not confirmed
        warnings.append(
            f"only {rivals} of {repeats} repeats came within {RIVAL - 1:.0%} of the best J: the "
            f"answer is not confirmed; raise {option('repeats')}"
        )
    trained = directions_of(train)
    rig = as_simulated(parameters.rig)
    one_way = rig.from_rest and not parameters.law.directional
    for part, held_out in tests:
        if any(_overlap(a, b) for a in held_out for b in train):
            warnings.append(
                f"hold-out {part.text} overlaps the training data: there its error says "
                "nothing about new data"
            )
        if one_way and directions_of(held_out) - trained:
            warnings.append(f"hold-out {part.text} runs in a direction that was not trained on")
    warnings += scale(rig)
    return warnings


def shared_directions(parameters: Parameters, train: Sequence[Segment]) -> list[str]:
    """A word on a parameter set that stands for both directions of an axis from rest to rest."""
    one, other = not parameters.law.directional, f"{parameters.law.name}-directional"
    if not (one and other in LAWS and as_simulated(parameters.rig).from_rest):
        return []
    if len(directions_of(train)) == 1:
        return []
    return [f"both directions share one parameter set: use law {other}, or train on one direction"]


def _overlap(a: Segment, b: Segment) -> bool:
    """Whether two segments share samples."""
    shared = min(a.rows.stop, b.rows.stop) - max(a.rows.start, b.rows.start)
    return a.recording is b.recording and shared > 0
