"""The scales of one mode: which do too much, which is the best that does not."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from .limit_cycle import SIGNS, Sign
from .trial import Mode, Outcome, Trial, Tried, ratios

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ..space import Array

#: Scales that are tried before it is looked closer; 0 is the axis without compensation.
SCALES = (0.0, 0.5, 0.75, 0.9, 1.0, 1.1, 1.3)
#: The recommended scale stays so far below the first one with a sign of too much.
MARGIN = 0.05
#: No more than all of the model's friction is recommended.
WHOLE = 1.0
#: How near the first scale with a sign is looked for, and the best one.
_NEAR = 0.025


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
        outcomes: What the axes did at each.
        onset: The first sign of too much, if there is one.
        harm: The first sign at all: also that an axis follows worse than without.
        safe: Whether a scale shows no sign, and keeps the margin, (S,).
        best: Which scale is recommended, if one improves every axis in every motion.
    """

    mode: Mode
    scales: Array
    outcomes: tuple[Outcome, ...]
    onset: Onset | None
    harm: Onset | None
    safe: NDArray[np.bool_]
    best: int | None

    @property
    def rms(self) -> Array:
        """RMS tracking error, m or rad, (S, P, M) of P axes and M motions; inf: it ran away."""
        return np.stack([o.rms for o in self.outcomes])

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
    def swing(self) -> Array:
        """Greatest lasting swing where axes settle without compensation, m or rad, (S,)."""
        before = self.outcomes[0].observed
        greatest: Array = np.array([
            max(
                float(np.where(b.unsettled, 0.0, a.swing).max(initial=0.0))
                for a, b in zip(o.observed, before, strict=True)
            )
            for o in self.outcomes
        ])  # fmt: skip
        return greatest

    @property
    def scale(self) -> float | None:
        """The recommended scale."""
        return None if self.best is None else float(self.scales[self.best])


def scale_curve(trial: Trial, mode: Mode, baseline: Outcome, scale: float | None) -> ScaleCurve:
    """Try one mode.

    Args:
        trial: What is tried.
        mode: At which velocity the law is asked.
        baseline: The axes without compensation.
        scale: Try this one only, and the one that is a margin above.
    """
    trials = Tried(trial, mode, baseline)
    for s in SCALES[1:] if scale is None else (scale, scale + MARGIN):
        if trials.too_much(s):
            break  # nothing beyond is recommended
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
    safe = np.array([s > 0 and s <= limit + 1e-9 and not trials.at(s).signs for s in scales])
    if scale is not None:
        safe &= np.isclose(scales, scale)
    worst = np.array([trials.worst(s) for s in scales])
    most = WHOLE if scale is None else scale
    improving = np.flatnonzero(safe & (worst < 1.0) & (np.array(scales) <= most))
    best = int(improving[np.argmin(worst[improving])]) if len(improving) else None
    harmful = next((s for s in scales if trials.at(s).signs), None)
    return ScaleCurve(
        mode, np.array(scales), tuple(trials.at(s) for s in scales), _sign(trial, trials, first),
        _sign(trial, trials, harmful), safe, best,
    )  # fmt: skip


def _closer(trials: Tried, limit: float) -> None:
    """Try scales around the best one, and the greatest that keeps the margin."""
    if np.isfinite(limit) and limit >= _NEAR:
        trials.at(np.floor(limit / _NEAR + 1e-9) * _NEAR)
    while True:
        scales = [s for s in trials.scales if 0 < s <= limit + 1e-9]
        if not scales:
            return
        best = min(scales, key=trials.worst)
        k = scales.index(best)
        neighbours = [scales[j] for j in (k - 1, k + 1) if 0 <= j < len(scales)]
        to_refine = [s for s in neighbours if abs(s - best) > 2 * _NEAR + 1e-9]
        if not to_refine:
            return
        for s in to_refine:
            trials.at(0.5 * (s + best))


def _sign(trial: Trial, trials: Tried, first: float | None) -> Onset | None:
    if first is None:
        return None
    sign, plant, motion = min(trials.at(first).signs, key=lambda signed: SIGNS.index(signed[0]))
    return Onset(first, sign, list(trial.axes)[plant], trial.motions[motion].name)
