"""A delay of the measured motion after its drive, in fits by output error.

A motion that was logged late by tau is off by about tau times the velocity, which parameters make
up for as well as they can: viscous friction and inertia take most of it. So the delay is made an
unknown among the others: where the slopes at the fit say that it would take away much of the
misfit, fit and delay are refined together.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..errors import InputError
from ..optimize import rms
from ..optimize.lockstep import Counted
from ..rig.simulated import as_simulated
from ..space import Array, Param, Space
from ..wording import option
from .conditions import Violation
from .initial_state import FreeStartProblem, started_at
from .moved_estimates import refit_text
from .polish import polish
from .problem import MotionProblem
from .uncertainty.linearisation import box_of, linearised

if TYPE_CHECKING:
    from ..optimize.trust_region import Iterate
    from .polish import Polished
    from .segment import Segment
    from .uncertainty.estimates import Estimate

#: A delay is looked for up to this share of a log's length, either way.
REACH = 0.02
#: It is told if it leaves at most this share of the sum of squares (clean logs of joints, beds,
#: pendulums and bristles keep 0.98 and more, those of a rough model 0.85); the slopes may promise a
#: little less, as the misfit is not linear in it.
LEAVES, PROMISED = 0.8, 0.85
#: A delay beyond this share of the reach is at its edge.
EDGE = 0.98
#: Evaluations of the refit for each unknown.
ROWS = 30


class DelayedProblem:
    """A motion problem with the delay of its measured motion as a further parameter, the last.

    Args:
        problem: The motion problem, with its starts as they are.
        reach: The longest delay to either side, s.
    """

    def __init__(self, problem: MotionProblem, reach: float) -> None:
        self.problem, self.parameters = problem, problem.parameters
        self.name = f"{problem.name}/delay"
        self.logs = problem.logs
        delay = Param("delay", -reach, reach, "s")
        self.space = Space((*problem.space.params, delay))

    def __call__(self, x: Array, /) -> Array:
        """(n, dim) points to (n,) root mean squares of their residuals."""
        return rms(self.residuals(x))

    def residuals(self, x: Array, /) -> Array:
        """(n, dim) points to (n, samples) residuals, in the problem's unit.

        The simulated motion is read between its samples: the measured one has noise, which would
        average out there.
        """
        x = np.atleast_2d(x)
        blocks = [
            np.full((len(x), int(np.count_nonzero(s.track.score))), np.nan)
            for s in self.problem.train
        ]
        for seconds in np.unique(x[:, -1]).tolist():
            rows = x[:, -1] == seconds
            for block, segment in zip(blocks, self.problem.train, strict=True):
                block[rows] = self.problem.segment_residuals(
                    x[rows, :-1], self._started(segment, seconds), late=seconds
                )
        return np.concatenate(blocks, axis=1)

    def _started(self, segment: Segment, seconds: float) -> Segment:
        """A segment from where its motion is seen so much later."""
        log, at = segment.recording, segment.track.t[0]
        if as_simulated(self.parameters.rig).from_rest:
            return segment
        start, there = np.interp([at, at + seconds], log.t, log.position)
        return started_at(segment, segment.track.x0 + float(there - start))


def delay_violations(
    problem: MotionProblem | FreeStartProblem, x: Array, judged: Sequence[Estimate]
) -> tuple[list[Violation], int]:
    """The delay that takes away most of a misfit, with what it biases; and the rows evaluated.

    Args:
        problem: The problem solved, its constants as they were estimated.
        x: The fit, SI, (dim,); starts stay where they are.
        judged: Its estimates, as in `parameters.every`.
    """
    if isinstance(problem, FreeStartProblem):
        problem, x = problem.at(x)
    if problem.weights is not None:  # slips, each with a start of its own
        return [], 0
    reach = REACH * min(float(np.ptp(s.recording.t)) for s in problem.train)
    delayed, at = DelayedProblem(problem, reach), np.append(x, 0.0)
    counted = Counted(delayed, 3 * len(at) + 1)
    try:
        fit = linearised(counted, box_of(delayed), at)
    except InputError:
        return [], counted.rows
    if _promised(fit) > PROMISED:
        return [], counted.rows
    start = float(delayed(at[None])[0])
    refit = polish(delayed, at, start, ROWS * len(at))
    rows = counted.rows + 1 + refit.evaluations
    if refit.cost**2 > LEAVES * start**2:
        return [], rows
    return [_violation(problem, judged, refit, start, reach)], rows


def _promised(fit: Iterate) -> float:
    """The share of the sum of squares that a delay leaves by the slopes, beside the others."""
    left = [fit.r - J.T @ np.linalg.lstsq(J.T, fit.r, rcond=None)[0] for J in (fit.J[:-1], fit.J)]
    without, with_delay = (float(r @ r) for r in left)
    return with_delay / max(without, np.finfo(float).tiny)


def _violation(
    problem: MotionProblem, judged: Sequence[Estimate], refit: Polished, start: float, reach: float
) -> Violation:
    seconds = float(refit.x[-1])
    changes, moved = refit_text(problem, judged, refit, start)
    at_least = "at least " if abs(seconds) > EDGE * reach else ""
    side = "behind" if seconds > 0 else "ahead of"
    drive = "force" if problem.parameters.rig.applied_force else "command"
    sentence = (
        f"the motion was measured {at_least}{1e3 * abs(seconds):.3g} ms {side} its {drive}: "
        f"{changes}: {option('delay', float(f'{-seconds:.3g}'))} moves it back"
    )
    return Violation("data", sentence, caps=moved)  # a refit close by moves less than a fit
