"""The experiments that a rig offers, made ready to be ranked, within what its logs show."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ...friction import LOADS
from ...rig.balanced import as_balanced
from ...rig.experiments.offer import ImposedMotion, Offer
from ...rig.simulated import as_simulated
from ...space import Array
from .experiment import Experiment

if TYPE_CHECKING:
    from ...rig.motion.track import Track
    from .identified_axis import IdentifiedAxis

#: Samples of an experiment at most: a faster clock than that is thinned out.
MOST = 6000
#: By how much a drive may be asked for more force than the log shows.
MARGIN = 1.2

#: Names of experiments that were left out, and why.
Refusals = list[tuple[str, str]]
#: Where position, temperature and normal load stand among the loads.
_NORMAL, _POSITION, _TEMPERATURE = (LOADS.index(n) for n in ("normal", "position", "temperature"))


def proposals(axis: IdentifiedAxis, seconds: float, refusals: Refusals) -> list[Experiment]:
    """The experiments of an axis that stay within the force and travel of its logs.

    Args:
        axis: The axis.
        seconds: How long each may take.
        refusals: Takes what was left out, and why.

    Raises:
        InputError: its rig knows of none.
    """
    rig = axis.parameters.rig
    simulated = rig.approach == "output_error"
    axis = _thinned(axis, seconds) if simulated else axis
    experiments = []
    for offer in rig.experiments(axis.shown, seconds):
        experiment, refusal = None, offer.refusal
        if not refusal:
            experiment, refusal = (_simulated if simulated else _imposed)(axis, offer)
        if experiment is None or refusal:
            refusals.append((offer.name, refusal))
        else:
            experiments.append(experiment)
    return experiments


def _thinned(axis: IdentifiedAxis, seconds: float) -> IdentifiedAxis:
    """The axis with at most MOST samples in an experiment, each worth several."""
    share = seconds / MOST / axis.shown.interval
    if share <= 1:
        return axis
    shown = replace(axis.shown, interval=share * axis.shown.interval)
    return replace(axis, shown=shown, noise=axis.noise / np.sqrt(share))


def _simulated(axis: IdentifiedAxis, offer: Offer) -> tuple[Experiment, str]:
    """An experiment of commands, and why it cannot be done."""
    rig, shown = as_simulated(axis.parameters.rig), axis.shown
    tracks = [rig.course_track(c, shown.temperature) for c in offer.courses]
    seconds = float(sum(c.t[-1] for c in offer.courses))
    experiment = Experiment(
        offer.name,
        offer.words,
        seconds if offer.seconds is None else offer.seconds,
        _predictor(axis, tracks),
        axis.noise,
        axis.inflation,
        len(tracks) if rig.free_start else 0,
        1e-6 * (shown.high - shown.low),
    )
    motions = [rig.move(shown.law, shown.p[None], track) for track in tracks]
    force = max(float(np.abs(m.force).max()) for m in motions)
    least = min(float(m.position.min()) for m in motions)
    most = max(float(m.position.max()) for m in motions)
    spare = rig.overtravel * (shown.high - shown.low)
    refusal = ""
    if not np.isfinite([force, least, most]).all():
        refusal = "the model cannot be simulated there"
    elif force > MARGIN * shown.force:
        refusal = _too_much(axis, force)
    elif least < shown.low - spare or most > shown.high + spare:
        end = least if least < shown.low - spare else most
        travel = f"the log from {shown.place(shown.low)} to {shown.place(shown.high)}"
        refusal = f"it goes to {shown.place(end)}, {travel}"
    return experiment, refusal


def _too_much(axis: IdentifiedAxis, force: float) -> str:
    most = axis.shown.push(axis.shown.force)
    return f"it takes {axis.shown.push(force)}, the log shows {most} at most"


def _predictor(axis: IdentifiedAxis, tracks: Sequence[Track]) -> Callable[[Array], Array]:
    """Positions over tracks; each may have its start, as a difference, behind the parameters."""
    rig, parameters, dim = as_simulated(axis.parameters.rig), axis.parameters, len(axis.x)

    def predict(rows: Array) -> Array:
        parts = []
        for k, track in enumerate(tracks):
            part = np.full((len(rows), len(track.t)), np.nan)
            starts = rows[:, dim + k] if rows.shape[1] > dim else np.zeros(len(rows))
            for start in np.unique(starts):
                matching = starts == start
                moved = track._replace(x0=track.x0 + float(start))
                p = parameters.full(rows[matching, :dim])
                part[matching] = rig.move(parameters.law, p, moved).position
            parts.append(part)
        return np.concatenate(parts, axis=1)

    return predict


def _imposed(axis: IdentifiedAxis, offer: Offer) -> tuple[Experiment, str]:
    """An experiment of a motion that the axis follows, and why it cannot be done."""
    rig, shown, motion = as_balanced(axis.parameters.rig), axis.shown, offer.motion
    assert motion is not None  # noqa: S101 - rigs whose forces are balanced offer motions
    loads = _loads(axis, motion)
    v, a = motion.velocity, motion.acceleration
    keep = (np.abs(v) >= rig.filtering.slowest) & (v != 0)
    v, a, loads = (np.ascontiguousarray(part[keep]) for part in (v, a, loads))

    def predict(x: Array) -> Array:
        full = axis.parameters.full(x[:, : len(axis.x)])
        return np.array([rig.force(axis.parameters.law, p, v, a, loads) for p in full])

    seconds = shown.interval * len(motion.position)
    experiment = Experiment(offer.name, offer.words, seconds, predict, axis.noise, axis.inflation)
    predicted = predict(axis.x[None])
    if not predicted.size:
        return experiment, "all of it is slower than the balance uses"
    force = float(np.abs(predicted).max())
    if not np.isfinite(force):
        return experiment, "the model cannot be run there"
    return experiment, _too_much(axis, force) if force > MARGIN * shown.force else ""


def _loads(axis: IdentifiedAxis, motion: ImposedMotion) -> Array:
    """The loads along a motion, (N, 5)."""
    exposure = axis.shown.exposure
    assert exposure is not None  # noqa: S101 - known where a force was measured
    loads = np.zeros((len(motion.velocity), len(LOADS)))
    loads[:, _POSITION], loads[:, _TEMPERATURE] = motion.position, exposure.temperature
    if motion.normal is not None:
        loads[:, _NORMAL] = motion.normal
    elif exposure.normal is not None:
        loads[:, _NORMAL] = np.mean(exposure.normal)
    return loads
