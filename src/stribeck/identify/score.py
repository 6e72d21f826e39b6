"""The misfit of a model on data, beside what could be had without it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from ..rig.rig import Simulated
from ..space import Array
from ..units import unit

if TYPE_CHECKING:
    from ..data.ranges import Range
    from ..rig import Motion
    from .problem import Parameters, Stretch


@dataclass(frozen=True)
class Score:
    """A misfit and its two baselines.

    Args:
        name: What was measured: `position_rmse`, J (4.5), or `relative_error` of the force.
        value: The model's.
        unit: Of the three.
        still: Of an axis that never moves.
        smooth: Of the best smooth motion without stick-slip, a line in the command.
        samples: That count.
    """

    name: Literal["position_rmse", "relative_error"]
    value: float
    unit: str
    still: float
    smooth: float
    samples: int

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
        stretches: Where in the recordings it lies.
        motions: What the model did there, a motion a stretch.
    """

    within: Range | None
    score: Score
    stretches: tuple[Stretch, ...]
    motions: tuple[Motion, ...]


def held_out(made: Parameters, p: Array, within: Range | None, on: Sequence[Stretch]) -> HeldOut:
    """Score a complete parameter set (SI) on the stretches of a range."""
    motions = tuple(simulated(made, p, on))
    return HeldOut(within, scores(made, p, on), tuple(on), motions)


def simulated(made: Parameters, p: Array, on: Sequence[Stretch]) -> list[Motion]:
    """The model's motion over each stretch."""
    rig = made.rig
    assert isinstance(rig, Simulated)  # noqa: S101 - stretches are made for such rigs only
    return [rig.move(made.law, p[None], s.track) for s in on]


def scores(made: Parameters, p: Array, on: Sequence[Stretch]) -> Score:
    """J (4.5) over stretches, and its baselines."""
    written = made.rig.shows.get("position", "m")
    motions = simulated(made, p, on)
    total = sum(int(s.track.sums[0, -1]) for s in on)
    model = still = smooth = 0.0
    for s, motion in zip(on, motions, strict=True):
        counts = s.track.score > 0
        x = s.track.measured[counts]
        command = np.interp(s.track.t, s.track.knots_t, s.track.knots_x)[counts]
        model += float(np.sum((x - motion.position[0][counts]) ** 2))
        still += float(np.sum((x - s.track.x0) ** 2))
        smooth += _line_misfit(command, x)
    rms = [float(unit(written).from_si(np.sqrt(sse / total))) for sse in (model, still, smooth)]
    return Score("position_rmse", rms[0], written, rms[1], rms[2], total)


def _line_misfit(command: Array, x: Array) -> float:
    """Sum of squares about the best a + b command."""
    regressors = np.column_stack([np.ones(len(x)), command - command.mean()])
    weights, *_ = np.linalg.lstsq(regressors, x, rcond=None)
    return float(np.sum((x - regressors @ weights) ** 2))
