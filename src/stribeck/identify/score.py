"""The misfit of a model on data, with the baselines without a model."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from ..rig.simulated import as_simulated
from ..space import Array
from ..units import unit
from .held_out_scope import Scope, held_out_scope
from .own_breakaway import slip_motion
from .stick_slip_statistics import StickSlipStatistics, stick_slip_statistics

if TYPE_CHECKING:
    from ..data.ranges import Range
    from ..rig import Motion
    from .parameters import Parameters
    from .segment import Segment


@dataclass(frozen=True)
class Score:
    """A misfit and its two baselines.

    Args:
        name: What was measured: `position_rmse`, J (4.5), `position_mae`, the mean size of the
            same errors, or `relative_error` of the force.
        value: The model's.
        unit: Of the three.
        still: Of an axis that never moves.
        smooth: Of the best smooth motion without stick-slip, a line in the command.
        samples: That count.
        measured: How the axis stuck and slipped, where it did and the whole motion was simulated.
        modelled: How the model did.
    """

    name: Literal["position_rmse", "position_mae", "relative_error"]
    value: float
    unit: str
    still: float
    smooth: float
    samples: int
    measured: StickSlipStatistics | None = None
    modelled: StickSlipStatistics | None = None

    def baselines(self) -> dict[str, float]:
        """Those that there are."""
        named = {"still": self.still, "smooth": self.smooth}
        return {n: v for n, v in named.items() if math.isfinite(v)}


@dataclass(frozen=True, eq=False)
class HeldOut:
    """The score of one range, and the simulated motion behind it.

    Args:
        within: The range; None for all of a log.
        score: Its score.
        segments: Where in the recordings it lies.
        motions: What the model did there, a motion a segment.
        scope: What it tests.
    """

    within: Range | None
    score: Score
    segments: tuple[Segment, ...]
    motions: tuple[Motion, ...]
    scope: Scope = Scope("", moves=True)  # noqa: RUF009 - a tuple


def held_out(
    parameters: Parameters, p: Array, part: Range | None, segments: Sequence[Segment]
) -> HeldOut:
    """Score a complete parameter set (SI) on the segments of a range."""
    motions = tuple(simulated(parameters, p, segments))
    scope = held_out_scope(((s.recording, s.rows) for s in segments), parameters.rig)
    return HeldOut(part, scores(parameters, p, segments), tuple(segments), motions, scope)


def simulated(parameters: Parameters, p: Array, segments: Sequence[Segment]) -> list[Motion]:
    """The model's motion over each segment."""
    rig = as_simulated(parameters.rig)
    return [slip_motion(rig, parameters.law, p[None], s) for s in segments]


def scores(parameters: Parameters, p: Array, segments: Sequence[Segment]) -> Score:
    """J (4.5) over segments, or the mean absolute error if that is the measure; and baselines."""
    written = parameters.rig.shows.get("position", "m")
    motions = simulated(parameters, p, segments)
    floating = as_simulated(parameters.rig).floating
    model, still, smooth = [], [], []
    for s, motion in zip(segments, motions, strict=True):
        counts = s.track.score > 0
        if not counts.any():  # a rest from beginning to end, of a sensor without noise
            continue
        x = s.track.measured[counts]
        command = np.interp(s.track.t, s.track.knots_t, s.track.knots_x)[counts]
        off = x - motion.position[0][counts]
        model.append(off - off.mean() if floating else off)
        still.append(x - (x.mean() if floating else s.track.x0))
        smooth.append(_about_a_line(command, x))
    absolute = parameters.objective.loss == "absolute"
    sizes = [
        float(unit(written).from_si(np.mean(np.abs(r)) if absolute else np.sqrt(np.mean(r * r))))
        for r in (np.concatenate(part) for part in (model, still, smooth))
    ]
    stairs = (
        (None, None) if parameters.objective.by_leg else stick_slip_statistics(segments, motions)
    )
    name: Literal["position_rmse", "position_mae"]
    name = "position_mae" if absolute else "position_rmse"
    return Score(name, sizes[0], written, sizes[1], sizes[2], sum(map(len, model)), *stairs)


def _about_a_line(command: Array, x: Array) -> Array:
    """What the best a + b command leaves."""
    regressors = np.column_stack([np.ones(len(x)), command - command.mean()])
    weights, *_ = np.linalg.lstsq(regressors, x, rcond=None)
    residual: Array = x - regressors @ weights
    return residual
