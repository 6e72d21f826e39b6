"""A delay of the measured motion after its drive, in fits by output error.

A motion that was logged late by tau is off by about tau times the velocity, which parameters make
up for as well as they can. Where commands turn and speeds change, viscous friction and inertia take
most of it and something is left over: the log shows the delay, and where the slopes at the fit say
that it would take away much of the misfit, fit and delay are refined together. Where a command
goes on at one speed v, the motion lags it by v tau in every rest and every slip alike: that is the
stretch k v tau of a spring, F_S and F_C take all of it, and no log shows it.

So a delay is a constant of the log: 0, give or take what is known of it beforehand. That is half a
sample as a standard deviation where nobody says more, as of the force in a balance. The intervals
of the parameters hold what is left of it beside what the log shows.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..errors import InputError
from ..optimize.lockstep import Counted
from ..rig.simulated import as_simulated
from ..space import Array
from .delayed_problem import DelayedProblem
from .initial_state import FreeStartProblem
from .polish import Polished, polish
from .problem import MotionProblem
from .uncertainty.covariance import quick_look
from .uncertainty.linearisation import box_of, linearised
from .uncertainty.residuals import logs_of

if TYPE_CHECKING:
    from ..optimize.trust_region import Iterate
    from .parameters import Parameters
    from .uncertainty.estimates import Estimate

#: A delay is looked for up to this share of a log's length, either way.
REACH = 0.02
#: It is told if it leaves at most this share of the sum of squares (clean logs of joints, beds,
#: pendulums and bristles keep 0.98 and more, those of a rough model 0.85); the slopes may promise a
#: little less, as the misfit is not linear in it.
LEAVES, PROMISED = 0.8, 0.85
#: Evaluations of the refit for each unknown.
ROWS = 30
#: What a delay may be where nobody has said it, as a standard deviation in samples.
UNSEEN = 0.5
#: A delay is refined if the slopes have it move an estimate by this share of its half-width.
MOVES = 0.5


@dataclass(frozen=True, eq=False)
class MotionDelay:
    """By how much later than its drive the motion of logs was measured, as a fit shows it.

    Args:
        seconds: The delay that explains the logs best.
        error: Its standard error; inf where the logs do not show it.
        known: What is known of it beforehand, as a standard deviation, s; 0 where it was said
            exactly.
        said: Whether the user has said it.
        slopes: By how much the free parameters rise for each second of it, all others refitted,
            SI, (free,).
        reach: How far was searched to each side, s.
        misfit: J without it, in the problem's unit.
        refit: The free parameters with it, where it takes away most of the misfit; else None.
    """

    seconds: float
    error: float
    known: float
    said: bool
    slopes: Array
    reach: float
    misfit: float
    refit: Polished | None

    @property
    def shown(self) -> bool:
        """Whether the logs tell more of it than is known beforehand."""
        return self.error < self.known

    @property
    def shift(self) -> float:
        """The mean of the delay by what is known beforehand and by the logs, s."""
        prior, seen = self.known**2, self.error**2
        return self.seconds * prior / (prior + seen) if np.isfinite(seen) and prior else 0.0

    @property
    def spread(self) -> float:
        """The standard deviation of the same, s."""
        if not np.isfinite(self.error):
            return self.known
        return float(self.known * self.error / max(np.hypot(self.known, self.error), 1e-300))


def motion_delay(
    problem: MotionProblem | FreeStartProblem,
    x: Array,
    judged: Sequence[Estimate],
    known: float | None,
) -> tuple[MotionDelay | None, int]:
    """The delay of the motion that a fit shows; and the rows evaluated.

    None where a controller is known to have read the position by itself, or to have held its force
    from sample to sample while slips are fitted one by one.

    Args:
        problem: The problem solved, its constants as they were estimated.
        x: The fit, SI, (dim,); starts stay where they are.
        judged: Its estimates, as in `parameters.every`.
        known: What was said of the delay, as a standard deviation, s; None where nothing was.
    """
    if isinstance(problem, FreeStartProblem):
        problem, x = problem.at(x)
    held = problem.weights is not None and as_simulated(problem.parameters.rig).holds_force
    if held or any(s.track.stretch.size for s in problem.train):
        return None, 0
    reach = REACH * min(float(np.ptp(s.recording.t)) for s in problem.train)
    delayed, at = DelayedProblem(problem, reach), np.append(x, 0.0)
    counted = Counted(delayed, 6 * len(at) + 2)
    try:
        fit = linearised(counted, box_of(delayed), at)
    except InputError:
        return None, counted.rows
    seconds, error, slopes = _delay(delayed, fit)
    start = float(delayed(at[None])[0])
    rows = 1
    refit: Polished | None = None
    by_slip = problem.weights is not None
    told = _promised(fit) <= PROMISED and not by_slip
    if told or (abs(seconds) > error and _moves(problem.parameters, judged, slopes * seconds)):
        refined = polish(delayed, at, start, ROWS * len(at))
        rows += refined.evaluations
        if told and refined.cost**2 <= LEAVES * start**2:
            refit = refined
        seconds = float(refined.x[-1])
        if abs(seconds) > error:  # what a refit changes, as the misfit is not linear in it
            slopes = (refined.x - at)[: len(slopes)] / seconds
        with suppress(InputError):  # that of the slopes at the fit stands
            error = _delay(delayed, linearised(counted, box_of(delayed), refined.x))[1]
    sample = max(s.recording.dt for s in problem.train)
    delay = MotionDelay(
        seconds=seconds,
        error=error,
        known=UNSEEN * sample if known is None else known,
        said=known is not None,
        slopes=slopes,
        reach=reach,
        misfit=start,
        refit=refit,
    )
    return delay, rows + counted.rows


def _delay(delayed: DelayedProblem, fit: Iterate) -> tuple[float, float, Array]:
    """The delay by the slopes at a fit, its standard error, and the slopes of the parameters."""
    box, free = box_of(delayed), len(delayed.parameters.free)
    scale = box.scale(fit.u)
    look = quick_look(fit.J, fit.r, logs_of(delayed, len(fit.r)))
    step = -float(look.curvature[-1] @ (fit.J @ fit.r)) * scale[-1]
    Jx = fit.J[:-1]
    slopes = -np.linalg.pinv(Jx @ Jx.T, hermitian=True) @ (Jx @ fit.J[-1])
    si = (slopes * scale[:-1] / scale[-1])[:free]
    seconds = float(box.x(fit.u)[-1]) + step
    error = float(look.errors[-1] * scale[-1])
    return float(np.clip(seconds, -delayed.space.upper[-1], delayed.space.upper[-1])), error, si


def _promised(fit: Iterate) -> float:
    """The share of the sum of squares that a delay leaves by the slopes, beside the others."""
    left = [fit.r - J.T @ np.linalg.lstsq(J.T, fit.r, rcond=None)[0] for J in (fit.J[:-1], fit.J)]
    without, with_delay = (float(r @ r) for r in left)
    return with_delay / max(without, np.finfo(float).tiny)


def _moves(parameters: Parameters, judged: Sequence[Estimate], moves: Array) -> bool:
    """Whether moves of the free parameters, SI, are material beside their intervals."""
    at = {q.name: k for k, q in enumerate(parameters.free)}
    return any(
        abs(moves[at[q.name]]) > MOVES * 0.5 * (e.high - e.low)
        for q, e in zip(parameters.every, judged, strict=True)
        if q.name in at and e.verdict == "identified"
    )
