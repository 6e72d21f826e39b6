"""What was measured and what the model did, as a reader sees it: in the units of its rig."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..data.segmentation import segment
from ..rig.simulated import SimulatedRig, as_simulated
from ..units import unit
from .figures.style import short, shown

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from ..data.recording import Recording
    from ..data.segmentation import Slip
    from ..identify.result import Fit
    from ..identify.segment import Segment
    from ..rig import Motion
    from ..space import Array

#: A rest on either side lasts at least this share of the slip's time.
_RESTED = 0.3


@dataclass(frozen=True, eq=False)
class Traces:
    """What was measured and modelled over a stretch of a log, in the units that its rig shows.

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

    @property
    def residual(self) -> Array:
        """Measured minus modelled."""
        return self.measured - self.model

    @property
    def rms(self) -> float:
        """Of the residual over what counts."""
        return float(np.sqrt(np.mean(self.residual[self.scored] ** 2)))


def traces(fit: Fit, on: Sequence[Segment], motions: Sequence[Motion]) -> list[Traces]:
    """The stretches of a range as they are drawn.

    Where every rest starts a simulation, the legs of a log are one motion.
    """
    rig = as_simulated(fit.rig)
    made = [_trace(rig, s, m, fit) for s, m in zip(on, motions, strict=True)]
    if not fit.parameters.objective.restart:
        return made
    together: dict[int, list[Traces]] = {}
    for part in made:
        together.setdefault(id(part.log), []).append(part)
    return [_joined(parts) for parts in together.values()]


def _trace(rig: SimulatedRig, s: Segment, motion: Motion, fit: Fit) -> Traces:
    scale = unit(shown(rig, "position")).factor
    counts = s.track.score > 0
    x, model = s.track.measured / scale, motion.position[0] / scale
    if rig.floating:  # positions are known up to a constant
        model = model + np.mean((x - model)[counts])
    command = None
    if not rig.applied_force and not _aimless(rig, s.recording):
        command = np.interp(s.track.t, s.track.knots_t, s.track.knots_x) / scale
    rows = slice(s.begin, s.rows.stop)
    measured = s.recording.force
    return Traces(
        _label(rig, fit, s), s.recording, s.track.t, x, model, counts, command,
        None if measured is None else measured[rows], motion.force[0],
    )  # fmt: skip


def _aimless(rig: SimulatedRig, log: Recording) -> bool:
    """Whether there is no command: only rigs that start from rest make one of their own."""
    return log.command is None and not rig.from_rest


def _label(rig: SimulatedRig, fit: Fit, s: Segment) -> str:
    """What a stretch is called: where a ramp went, else the log and its times if it is a part."""
    log = s.recording
    if rig.from_rest and len(fit.recordings) == 1 and not fit.parameters.objective.restart:
        x = log.position[s.rows] / unit(shown(fit.rig, "position")).factor
        way = "rightward" if s.direction > 0 else "leftward"
        return f"{way}, {x[0]:.0f} to {x[-1]:.0f} {shown(fit.rig, 'position')}"
    name = short(log.label, 44)
    if s.rows.stop - s.rows.start > 0.99 * len(log):
        return name
    return f"{name}, {log.t[s.rows.start]:.4g} to {log.t[s.rows.stop - 1]:.4g} s"


def _joined(parts: Sequence[Traces]) -> Traces:
    """The legs of a log one after the other, with gaps between."""
    name = parts[0].label.partition(", ")[0]

    def chain(arrays: Sequence[Array | None]) -> Array | None:
        there = [a for a in arrays if a is not None]
        if len(there) < len(parts):
            return None
        return np.concatenate([part for a in there for part in (a, [np.nan])])

    def whole(arrays: Sequence[Array]) -> Array:
        made = chain(arrays)
        assert made is not None  # noqa: S101 - each leg has these
        return made

    return Traces(
        f"{name}, from rest to rest" if len(parts) > 1 else name,
        parts[0].log,
        whole([p.t for p in parts]),
        whole([p.measured for p in parts]),
        whole([p.model for p in parts]),
        np.concatenate([part for p in parts for part in (p.scored, [False])]),
        chain([p.command for p in parts]),
        chain([p.force for p in parts]),
        chain([p.force_model for p in parts]),
    )


def stuck_slips(log: Recording) -> list[Slip]:
    """The slips that lead from one true rest to another: not the turns of a free swing."""
    seen, t = segment(log), log.t

    def rested(row: int, slip: Slip) -> bool:
        """Whether the axis rests about a sample, for a good part of the time of the slip."""
        least = _RESTED * float(t[slip.stop] - t[slip.start])
        return any(
            r.start <= row + 1 and row - 1 <= r.stop - 1 and t[r.stop - 1] - t[r.start] >= least
            for r in seen.rests
        )

    return [s for s in seen.slips if rested(s.start, s) and rested(s.stop, s)]


def whole(r: Traces, start: float, stop: float) -> bool:
    """Whether a slip lies in what was simulated and counts."""
    near = (r.t >= start) & (r.t <= stop) & r.scored
    return bool(near.any() and start >= np.nanmin(r.t) and stop <= np.nanmax(r.t))
