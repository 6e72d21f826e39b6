"""The scale of a compensation of identified friction, tried on every axis that a card allows.

The compensator believes the card. The axes that it is tried on are the card's and those at the
ends of its intervals, so what comes out holds for more than a perfect model, though not for every
combination of parameters within their intervals. Each is driven over several reference motions at
a range of scales (the share of the model's friction that is compensated), once with the law asked
at the reference's velocity and once at the measured one, beside the same axis without
compensation.

The recommended scale is the one with the least worst RMS ratio (with over without, over all axes
and motions) among those that show no sign of too much (`hunting`) anywhere, lie at least MARGIN
below the first scale that does, and are not above WHOLE: what more than the whole friction gains
is the loop's own lag, which is not friction's to mend. The law is asked at the reference's
velocity, which needs no sensor, where that is as good.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ..errors import InputError
from ..identify.card import constant_cards, kind_of
from .closed_loop import IDEAL, controlled, drive_friction
from .compensator import TINY, Compensator, sensor_dead_band
from .corners import plants
from .limit_cycle import SIGNS, Sign
from .reference_motions import LONG, paced, references
from .trial import Mode, TrackingTrace, Trial, Tried, ratios

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from numpy.typing import NDArray

    from ..data.recording import Recording
    from ..friction import Law
    from ..identify.card import Card
    from ..identify.parameters import Parameters
    from ..rig import Rig
    from ..space import Array
    from .closed_loop import Reference, Sensor

MODES: tuple[Mode, ...] = ("reference", "feedback")

#: Tried that are tried before it is looked closer; 0 is the axis without compensation.
SCALES = (0.0, 0.5, 0.7, 0.8, 0.9, 0.95, 1.0, 1.05, 1.1, 1.2, 1.35, 1.5)
#: The recommended scale stays so far below the first one with a sign of too much.
MARGIN = 0.05
#: No more than all of the model's friction is recommended.
WHOLE = 1.0
#: Where it does too much, and the worst error is so many times that without, no more is tried.
_HOPELESS = 2.0
#: How near the first scale with a sign is found, and the best one.
_NEAR = 0.0125
#: The simpler mode is recommended if its worst ratio is at most so many times the other's.
AS_GOOD = 1.1
#: Dead band of a sensor without steps, as a share of the slowest reference's speed.
_STILL = 1e-3
#: A law that gives less than this share of its greatest friction beside rest has no level there.
_LEVEL = 0.5


@dataclass(frozen=True)
class Onset:
    """Where a compensation begins to do too much.

    Args:
        scale: The least scale that was seen to.
        sign: What was seen; the worst, of several.
        plant: On which axis.
        motion: Under which reference.
    """

    scale: float
    sign: Sign
    plant: str
    motion: str


@dataclass(frozen=True, eq=False)
class ScaleCurve:
    """One mode over all scales.

    Args:
        mode: At which velocity the law is asked.
        scales: Rising, the first is 0, (S,).
        rms: RMS tracking error, m or rad, (S, P, M) for P axes and M motions; inf where an axis
            ran away.
        onset: The first sign of too much, if there is one.
        harm: The first sign at all: also that an axis follows worse than without.
        safe: Whether a scale shows no sign, and keeps the margin, (S,).
        best: Which scale is recommended, if one improves every axis in every motion.
    """

    mode: Mode
    scales: Array
    rms: Array
    onset: Onset | None
    harm: Onset | None
    safe: NDArray[np.bool_]
    best: int | None

    @property
    def ratio(self) -> Array:
        """RMS error over that without compensation, (S, P, M)."""
        return ratios(self.rms)

    @property
    def worst(self) -> Array:
        """The greatest ratio of all axes and motions, (S,)."""
        greatest: Array = self.ratio.max(axis=(1, 2))
        return greatest

    @property
    def scale(self) -> float | None:
        """The recommended scale."""
        return None if self.best is None else float(self.scales[self.best])


@dataclass(frozen=True, eq=False)
class Compensation:
    """What was tried, and what is recommended.

    Args:
        law: The law's name.
        rig: The rig; its units are those that people are shown.
        period: Sample time of the controller, s.
        sensor: How the compensator sees.
        motions: Names of the reference motions, (M,).
        plants: Names of the axes, (P,); the first is the identified one.
        curves: One for each mode that was tried.
        frictionless: RMS tracking error of the identified axis had it no friction, m or rad, (M,).
        mode: The recommended mode; None where no scale is safe and better.
        compensator: Its settings.
        margin: Between the recommended scale and the first sign.
        traces: What the recommended compensator does to the identified axis.
        notes: What else a reader must know.
    """

    law: str
    rig: Rig
    period: float
    sensor: Sensor
    motions: tuple[str, ...]
    plants: tuple[str, ...]
    curves: tuple[ScaleCurve, ...]
    frictionless: Array
    mode: Mode | None
    compensator: Compensator | None
    margin: float
    traces: tuple[TrackingTrace, ...]
    notes: tuple[str, ...]

    @property
    def curve(self) -> ScaleCurve | None:
        """Of the recommended mode."""
        return next((c for c in self.curves if c.mode == self.mode), None)


def compensation(
    card: Card,
    rig: Rig | None = None,
    *,
    recordings: Sequence[Recording] = (),
    speed: float | None = None,
    period: float = 1e-3,
    mode: Mode | None = None,
    scale: float | None = None,
    reference: Reference | None = None,
    sensor: Sensor = IDEAL,
    beside: Mapping[str, Array] | None = None,
    progress: Callable[[str], object] | None = None,
) -> Compensation:
    """Try compensations of an identified friction, and recommend one.

    Args:
        card: What was identified.
        rig: The axis that is to be compensated; the card's own by default. It must have the
            parameters of the card.
        recordings: Logs whose command sets speed and travel of the reference motions.
        speed: Of the slowest, m/s or rad/s, in place of the logs'.
        period: Sample time of the controller, s.
        mode: Try this one only.
        scale: Try this scale only.
        reference: Follow this in place of the usual motions.
        sensor: How the compensator sees the position.
        beside: Further axes to try, parameter sets by name, SI.
        progress: Called with what is being tried.

    Raises:
        InputError: a rig without a controller, a card that is not of this rig, or no speed.
    """
    if not 0 < period < np.inf:
        raise InputError(f"period: give a time above 0 s, got {period:g}")
    if scale is not None and not 0 < scale < np.inf:
        raise InputError(f"scale: give a number above 0, got {scale:g}")
    if rig is not None:
        controlled(rig)
    parameters, p = _card_on(card, rig).model()
    controlled(parameters.rig)
    axes, notes = plants(card, parameters, p)
    if card.speeds is not None and card.speeds.one_way:
        notes.append(f"{card.speeds.one_way}: what is tried and recommended holds one way only")
    axes |= beside or {}
    motions = (
        (reference,) if reference is not None else _motions(parameters, recordings, speed, period)
    )
    shape = _shape(parameters, p, motions, sensor, notes)
    trial = Trial(parameters.rig, parameters.law, p, axes, motions, shape, sensor)
    curves = []
    for each_mode in MODES if mode is None else (mode,):
        if progress is not None:
            progress(f"{each_mode}: {len(axes)} axes, {len(motions)} motions")
        curves.append(_curve(trial, each_mode, scale))
    chosen = _chosen(curves)
    settings = None
    if chosen is not None and chosen.scale is not None:
        settings = replace(shape, scale=chosen.scale, feedback=chosen.mode == "feedback")
    return Compensation(
        parameters.law.name, parameters.rig, period, sensor, tuple(m.name for m in motions),
        tuple(axes), tuple(curves), trial.frictionless(), None if chosen is None else chosen.mode,
        settings, MARGIN, trial.traces(settings), tuple(notes),
    )  # fmt: skip


def _card_on(card: Card, rig: Rig | None) -> Card:
    """The card as if it had been identified on another rig of the same parameters."""
    if rig is None:
        return card
    kind = kind_of(rig)
    if odd := [c.name for c in rig.constants if not np.isfinite(c.value)]:
        raise InputError(f"rig {rig.name}: {odd[0]} is not a finite number: a card cannot say that")
    return card.model_copy(
        update={"rig": rig.name, "kind": kind, "constants": constant_cards(rig), "columns": {}}
    )


def _motions(
    parameters: Parameters, recordings: Sequence[Recording], speed: float | None, period: float
) -> tuple[Reference, ...]:
    if speed is not None and not 0 < speed < np.inf:
        raise InputError(f"speed: give a number above 0, got {speed:g}")
    pace = paced(recordings)
    if pace is None and speed is None:
        raise InputError(
            f"rig {parameters.rig.name}: no log says how fast the axis is driven: give the speed "
            "of the slowest motion, or a reference to follow"
        )
    slowest, travel, x0 = pace or (0.0, np.inf, 0.0)
    slow = slowest if speed is None else speed
    return references(slow, min(travel, LONG * slow), x0, period)


def _shape(
    parameters: Parameters, p: Array, motions: Sequence[Reference], sensor: Sensor, notes: list[str]
) -> Compensator:
    """The settings beside scale and mode: what the drive eats, what counts as rest."""
    h = motions[0].h
    moving = [np.abs(m.v)[np.abs(m.v) > 1e-3 * np.abs(m.v).max()] for m in motions]
    if not all(len(v) for v in moving):
        raise InputError(f"reference {motions[0].name}: it does not move: nothing to compensate")
    slowest = min(float(np.median(v)) for v in moving)
    dead_band = sensor_dead_band(sensor.resolution, h) + 3.0 * np.sqrt(2.0) * sensor.noise / h
    dead_band = float(f"{max(dead_band, _STILL * slowest):.4g}")  # a setting that people read
    if dead_band > 0.5 * slowest:
        notes.append(
            f"at a period of {h * 1e3:g} ms the sensor does not tell the slowest motion from rest: "
            "take a longer period or a finer sensor for feedback"
        )
    return Compensator(
        dead_band=dead_band,
        drive=drive_friction(parameters.rig),
        rest=_rest(parameters.law, p, slowest),
    )


def _rest(law: Law, p: Array, slowest: float) -> float:
    """The speed at which a resting axis asks a law: beside rest, or where a smooth one peaks."""
    speeds = np.geomspace(TINY, slowest, 200)
    friction = law.friction(speeds, p[: len(law.params)])
    if friction[0] >= _LEVEL * friction.max():
        return TINY
    return float(speeds[int(np.argmax(friction))])


def _curve(trial: Trial, mode: Mode, scale: float | None) -> ScaleCurve:
    trials = Tried(trial, mode)
    grid = SCALES[1:] if scale is None else (scale, scale + MARGIN)
    for s in grid:
        trials.at(s)
        if trials.too_much(s) and trials.worst(s) > _HOPELESS:
            break  # nothing is learnt from axes that hunt more
    first = next((s for s in trials.scales if s and trials.too_much(s)), None)
    if first is not None and scale is None:
        last_safe = max(s for s in trials.scales if s < first)
        while first - last_safe > _NEAR:
            middle = round(0.5 * (first + last_safe), 4)
            first, last_safe = (middle, last_safe) if trials.too_much(middle) else (first, middle)
    limit = np.inf if first is None else first - MARGIN
    if scale is None:
        _closer(trials, min(limit, WHOLE))
    scales = trials.scales
    rms = np.stack([trials.at(s)[0] for s in scales])
    safe = np.array([s > 0 and s <= limit + 1e-9 and not trials.at(s)[1] for s in scales])
    if scale is not None:
        safe &= np.isclose(scales, scale)
    worst = np.array([trials.worst(s) for s in scales])
    most = WHOLE if scale is None else scale
    improving = np.flatnonzero(safe & (worst < 1.0) & (np.array(scales) <= most))
    best = int(improving[np.argmin(worst[improving])]) if len(improving) else None
    harmful = next((s for s in scales if trials.at(s)[1]), None)
    return ScaleCurve(
        mode, np.array(scales), rms, _sign(trial, trials, first), _sign(trial, trials, harmful),
        safe, best,
    )  # fmt: skip


def _closer(trials: Tried, limit: float) -> None:
    """Try scales around the best one, and the greatest that keeps the margin."""
    if np.isfinite(limit) and limit > 0:
        trials.at(np.floor(limit / _NEAR + 1e-9) * _NEAR)
    while True:
        scales = [s for s in trials.scales if 0 < s <= limit + 1e-9]
        if not scales:
            return
        best = min(scales, key=trials.worst)
        k = scales.index(best)
        neighbours = [scales[j] for j in (k - 1, k + 1) if 0 <= j < len(scales)]
        to_refine = [s for s in neighbours if abs(s - best) > 2 * _NEAR]
        if not to_refine:
            return
        for s in to_refine:
            trials.at(0.5 * (s + best))


def _sign(trial: Trial, trials: Tried, first: float | None) -> Onset | None:
    if first is None:
        return None
    sign, plant, motion = min(trials.at(first)[1], key=lambda signed: SIGNS.index(signed[0]))
    return Onset(first, sign, list(trial.axes)[plant], trial.motions[motion].name)


def _chosen(curves: Sequence[ScaleCurve]) -> ScaleCurve | None:
    """The mode that is recommended: the simpler one if it is as good."""
    usable = [c for c in curves if c.best is not None]
    if not usable:
        return None
    least = min(c.worst[c.best] for c in usable)
    return next(c for c in usable if c.worst[c.best] <= AS_GOOD * least)  # the simpler comes first
