"""Creep and drift of the position, in fits by output error whose forces cannot be looked at.

A law with states has no equation error: its bristles add up the noise of the position. What creeps
under a constant force, or a sensor whose zero drifts, is seen in the position itself, as an error
that goes with time. Where chance does not explain it, fit and drift are refined together.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..errors import InputError
from ..optimize import rms
from ..optimize.lockstep import Counted
from ..space import Array, Param, Space
from ..units import percent
from ..wording import option
from .adequacy.bins import t_probability
from .conditions import Violation
from .initial_state import FreeStartProblem
from .moved_estimates import refit_text
from .polish import polish
from .problem import MotionProblem
from .uncertainty.linearisation import box_of, linearised

if TYPE_CHECKING:
    from ..optimize.trust_region import Iterate
    from .uncertainty.estimates import Estimate

#: Shares of a log within which a drift dies away; it may also go on evenly.
TIMES = (0.1, 0.3, 1.0)
#: Greatest probability of chance, and the least share of the variance that is spoken of; without a
#: drift chance explains some thousandths of it.
CHANCE, LEAST = 1e-4, 0.1
#: Blocks of the rows, each of which counts once.
BLOCKS = 48
#: Greatest size of a drift, in ranges of the residual.
MOST = 10.0
#: Evaluations of the refit for each unknown.
ROWS = 30


class DriftingProblem:
    """A motion problem with a drift of its measured position as further parameters, the last.

    Args:
        problem: The motion problem.
        columns: The drift's shapes, of the size 1, (samples, k).
        most: The greatest size of each, in the problem's unit.
    """

    def __init__(self, problem: MotionProblem, columns: Array, most: float) -> None:
        self.problem, self.parameters, self.columns = problem, problem.parameters, columns
        self.name, self.logs = f"{problem.name}/drift", problem.logs
        drifts = (Param(f"drift_{k}", -most, most, "") for k in range(columns.shape[1]))
        self.space = Space((*problem.space.params, *drifts))

    def __call__(self, x: Array, /) -> Array:
        """(n, dim) points to (n,) root mean squares of their residuals."""
        return rms(self.residuals(x))

    def residuals(self, x: Array, /) -> Array:
        """(n, dim) points to (n, samples) residuals, in the problem's unit."""
        x = np.atleast_2d(x)
        k = len(self.problem.space.params)
        return self.problem.residuals(x[:, :k]) - x[:, k:] @ self.columns.T


def drift_violations(
    problem: MotionProblem | FreeStartProblem, x: Array, judged: Sequence[Estimate]
) -> tuple[list[Violation], int]:
    """The drift that position errors show, with what it biases; and the rows evaluated.

    Args:
        problem: The problem solved, its constants as they were estimated.
        x: The fit, SI, (dim,).
        judged: Its estimates, as in `parameters.every`.
    """
    states = problem.parameters.law.states
    if isinstance(problem, FreeStartProblem) or problem.weights is not None or not states:
        return [], 0
    counted = Counted(problem, 3 * (len(x) + 1))
    try:
        fit = linearised(counted, box_of(problem), x)
    except InputError:
        return [], counted.rows
    column, share = _drift(problem, fit)
    if column is None:
        return [], counted.rows
    drifting = DriftingProblem(problem, column[:, None], MOST * float(np.ptp(fit.r)))
    start = float(rms(fit.r[None])[0])
    refit = polish(drifting, np.append(x, 0.0), start, ROWS * (len(x) + 1))
    rows = counted.rows + refit.evaluations
    changes, _ = refit_text(problem, judged, refit, start)
    sentence = (
        f"the measured position drifts beside the model's ({percent(share)} of the variance): "
        f"{changes}: the axis creeps or the sensor's zero moves; train on shorter parts "
        f"({option('train')})"
    )
    # The refit starts at the fit: one with the drift in it all along might end farther off.
    return [Violation("model", sentence)], rows


def _drift(problem: MotionProblem, fit: Iterate) -> tuple[Array | None, float]:
    """The drift that explains most of the residuals, (samples,), and the share; None by chance."""
    basis = np.linalg.qr(fit.J.T)[0]
    block = np.arange(len(fit.r)) * BLOCKS // len(fit.r)
    r = fit.r - basis @ (basis.T @ fit.r)
    best: Array | None = None
    share = LEAST
    for column in _shapes(problem):
        left = column - basis @ (basis.T @ column)
        length, total = float(left @ left), float(r @ r)
        gain = float(left @ r) ** 2 / (length * total) if length * total > 0 else 0.0
        if gain > share and t_probability(left[:, None], r, block)[0] <= CHANCE:
            best, share = column, gain
    return best, share


def _shapes(problem: MotionProblem) -> list[Array]:
    """Drifts over the time since each motion began, about their means, (samples,) each."""
    times = [s.track.t[s.track.score > 0] - s.track.t[0] for s in problem.train]
    since = np.concatenate(times)
    since /= since.max()
    shapes = [since, *(np.exp(-since / share) for share in TIMES)]
    return [shape - shape.mean() for shape in shapes]
