"""What was measured and what the model did, as a reader sees it: in the units of its rig."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...data.segmentation import segment
from ...rig.simulated import SimulatedRig, as_simulated
from ...units import unit
from ..format import abbreviated

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from ...data.recording import Recording
    from ...data.segmentation import Slip
    from ...identify.balance.balance import Signals
    from ...identify.result import Fit
    from ...identify.segment import Segment
    from ...rig import Motion, Rig
    from ...space import Array

#: A rest on either side lasts at least this share of the slip's time.
_RESTED = 0.3
#: Rows of a force balance are apart beyond so many of their steps, and beyond this share of them.
_APART, _GAP = 3.0, 0.005


@dataclass(frozen=True, eq=False)
class MotionTraces:
    """What was measured and modelled over a part of a log, in the units that its rig shows.

    Args:
        label: The log, and what of it.
        log: The recording.
        t: Times of the samples, s, (N,); nan between legs that are simulated each by itself.
        measured: Position (or force, of a force balance), (N,).
        model: The same of the model.
        scored: Which samples count.
        command: Commanded position, (N,), where there is one.
        force: Force of the drive as measured, (N,), where it was.
        force_model: The same of the model, where it has one.
        velocity: Velocity, (N,), of a force balance.
    """

    label: str
    log: Recording
    t: Array
    measured: Array
    model: Array
    scored: NDArray[np.bool_]
    command: Array | None = None
    force: Array | None = None
    force_model: Array | None = None
    velocity: Array | None = None

    @property
    def residual(self) -> Array:
        """Measured minus modelled."""
        return self.measured - self.model

    @property
    def rms(self) -> float:
        """Of the residual over what counts; nan where nothing does."""
        counted = self.residual[self.scored]
        return float(np.sqrt(np.mean(counted**2))) if len(counted) else float("nan")


def motion_traces(
    fit: Fit, segments: Sequence[Segment], motions: Sequence[Motion]
) -> list[MotionTraces]:
    """The segments of a range as they are drawn.

    Where every rest starts a simulation, the legs of a log are one motion.
    """
    rig = as_simulated(fit.rig)
    traces = [_traces(rig, s, m, fit) for s, m in zip(segments, motions, strict=True)]
    if not fit.parameters.objective.by_leg:
        return traces
    legs: dict[int, list[MotionTraces]] = {}
    for leg in traces:
        legs.setdefault(id(leg.log), []).append(leg)
    return [_joined(parts) for parts in legs.values()]


def balance_traces(rig: Rig, log: Recording, signals: Signals) -> MotionTraces:
    """The force balance of a log: the measured force beside the predicted one, every row.

    A gap parts rows that others lie between which do not count: rests, and what is left out.
    """
    b, scale = signals, unit(rig.unit_shown("velocity")).factor
    steps = np.diff(b.t)
    shortest = max(_APART * float(np.median(steps)), _GAP * float(np.ptp(b.t))) if len(steps) else 0
    at = np.flatnonzero(steps > shortest) + 1

    def parted(a: Array) -> Array:
        return np.insert(a, at, np.nan)

    return MotionTraces(
        log.label, log, parted(b.t), parted(b.measured), parted(b.predicted),
        np.insert(np.ones(len(b.t), dtype=bool), at, values=False),
        velocity=parted(b.velocity / scale),
    )  # fmt: skip


def _traces(rig: SimulatedRig, s: Segment, motion: Motion, fit: Fit) -> MotionTraces:
    scale = unit(rig.unit_shown("position")).factor
    counts = s.track.score > 0
    x, model = s.track.measured / scale, motion.position[0] / scale
    if rig.floating:  # positions are known up to a constant
        model = model + np.mean((x - model)[counts])
    command = None
    if not rig.applied_force and not _uncommanded(rig, s.recording):
        command = np.interp(s.track.t, s.track.knots_t, s.track.knots_x) / scale
    rows = slice(s.begin, s.rows.stop)
    measured = s.recording.force
    return MotionTraces(
        _label(rig, fit, s), s.recording, s.track.t, x, model, counts, command,
        None if measured is None else measured[rows], motion.force[0],
    )  # fmt: skip


def _uncommanded(rig: SimulatedRig, log: Recording) -> bool:
    """Whether there is no command: only rigs that start from rest derive one of their own."""
    return log.command is None and not rig.from_rest


def _label(rig: SimulatedRig, fit: Fit, s: Segment) -> str:
    """What a segment is called: where a ramp went, else the log and its times if it is a part."""
    log = s.recording
    if rig.from_rest and len(fit.recordings) == 1 and not fit.parameters.objective.by_leg:
        length = fit.rig.unit_shown("position")
        x = log.position[s.rows] / unit(length).factor
        way = "rightward" if s.direction > 0 else "leftward"
        return f"{way}, {x[0]:.0f} to {x[-1]:.0f} {length}"
    name = abbreviated(log.label, 44)
    if s.rows.stop - s.rows.start > 0.99 * len(log):
        return name
    return f"{name}, {log.t[s.rows.start]:.4g} to {log.t[s.rows.stop - 1]:.4g} s"


def _joined(legs: Sequence[MotionTraces]) -> MotionTraces:
    """The legs of a log one after the other, with gaps between."""
    name = legs[0].label.partition(", ")[0]

    def chain(arrays: Sequence[Array]) -> Array:
        return np.concatenate([part for a in arrays for part in (a, [np.nan])])

    def chain_known(arrays: Sequence[Array | None]) -> Array | None:
        known = [a for a in arrays if a is not None]
        return chain(known) if len(known) == len(legs) else None

    return MotionTraces(
        f"{name}, from rest to rest" if len(legs) > 1 else name,
        legs[0].log,
        chain([leg.t for leg in legs]),
        chain([leg.measured for leg in legs]),
        chain([leg.model for leg in legs]),
        np.concatenate([part for leg in legs for part in (leg.scored, [False])]),
        chain_known([leg.command for leg in legs]),
        chain_known([leg.force for leg in legs]),
        chain_known([leg.force_model for leg in legs]),
    )


def stuck_slips(log: Recording) -> list[Slip]:
    """The slips that lead from one true rest to another: not the turns of a free swing."""
    segments, t = segment(log), log.t

    def rested(row: int, slip: Slip) -> bool:
        """Whether the axis rests at a sample, for a good part of the time of the slip."""
        least = _RESTED * float(t[slip.stop] - t[slip.start])
        return any(
            r.start <= row + 1 and row - 1 <= r.stop - 1 and t[r.stop - 1] - t[r.start] >= least
            for r in segments.rests
        )

    return [s for s in segments.slips if rested(s.start, s) and rested(s.stop, s)]


def covers(r: MotionTraces, start: float, stop: float) -> bool:
    """Whether a slip lies in what was simulated and counts."""
    inside = (r.t >= start) & (r.t <= stop) & r.scored
    return bool(inside.any() and start >= np.nanmin(r.t) and stop <= np.nanmax(r.t))
