"""An experiment: the slopes of its signals, and its Fisher information.

An experiment is what a model predicts of it, the noise of one of its samples and how much of
that noise is repetition. Its Fisher information adds to that of the data at hand. In stick-slip
that is a local figure: slips come earlier or later with the parameters, or not at all. So it is
asked at several parameter sets that the data allow, and medians are told.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ...space import Array

Kind = Literal["motion", "sensor", "gauge"]

#: Finite difference: this share of a range, but no more than that share of a value; and the
#: least share of a range, below which it would be rounding.
STEP, OF_VALUE, LEAST = 1e-6, 1e-4, 1e-10
#: From this ratio of its ends on, a range is one of a logarithm.
DECADES = 100.0
#: Tries to draw a parameter set that the data allow, before it is brought nearer to the fit.
TRIES = 100


@dataclass(frozen=True, eq=False)
class Experiment:
    """A candidate, or the data at hand.

    Args:
        name: In few words.
        words: What a technician does, in a sentence.
        seconds: How long it takes.
        predict: (n, dim + starts) free parameters, SI, and then starts, to (n, N) signals;
            nan where a model cannot be run. Only differences count.
        noise: Standard deviation of a row of the signals.
        inflation: How many times the variance of each estimate is that of white noise, (dim,).
        starts: How many unknown starts it has: differences from where motions begin.
        reach: Finite difference of a start.
        kind: `motion`; `sensor` if it takes another sensor; `gauge` if a quantity is measured by
            hand.
    """

    name: str
    words: str
    seconds: float
    predict: Callable[[Array], Array]
    noise: float
    inflation: Array
    starts: int = 0
    reach: float = 1e-7
    kind: Kind = "motion"


@dataclass(frozen=True, eq=False)
class PriorBox:
    """The free parameters and what is known of them beside any data.

    A parameter whose range spans two decades or more is known, drawn and told by its logarithm,
    the others as they are: that is a parameter's scale here.

    Args:
        lower: Ends of the search ranges, SI, (dim,).
        upper: The others.
        prior: Standard deviations of what is known beside any data, in these scales, (dim,).
        physical: Which of (n, dim) points, SI, mean something.
    """

    lower: Array
    upper: Array
    prior: Array
    physical: Callable[[Array], NDArray[np.bool_]]

    @property
    def log(self) -> NDArray[np.bool_]:
        """Which parameters count by their logarithm."""
        return decades(self.lower, self.upper)

    @property
    def prior_information(self) -> Array:
        """The information beside any data, (dim, dim)."""
        return np.diag(1.0 / self.prior**2)

    def scaled(self, x: Array) -> Array:
        """Points, SI, (..., dim), in the scales of the parameters."""
        s: Array = np.where(self.log, np.log(np.where(self.log, x, 1.0)), x)
        return s

    def plain(self, s: Array) -> Array:
        """The other way round."""
        x: Array = np.where(self.log, np.exp(np.where(self.log, s, 0.0)), s)
        return x

    def pace(self, x: Array) -> Array:
        """How fast a point, SI, (dim,), goes as the scales do."""
        return np.where(self.log, x, 1.0)

    def inside(self, x: Array) -> NDArray[np.bool_]:
        """Which of (n, dim) points are in the box and mean something."""
        bounded = ((x >= self.lower) & (x <= self.upper)).all(axis=1)
        return np.asarray(bounded & self.physical(x), dtype=bool)

    def steps(self, x: Array) -> Array:
        """Finite differences at a point, SI, (dim,)."""
        width = self.upper - self.lower
        size = np.where(x == 0.0, np.inf, OF_VALUE * np.abs(x))
        return np.minimum(STEP * width, np.maximum(size, LEAST * width))


def decades(lower: Array, upper: Array) -> NDArray[np.bool_]:
    """Which ranges span two decades or more, and so count by the logarithm."""
    positive = lower > 0
    wide_ranges: NDArray[np.bool_] = positive & (upper >= DECADES * np.where(positive, lower, 1.0))
    return wide_ranges


def slopes(experiment: Experiment, x: Array, box: PriorBox) -> Array:
    """Slopes of what an experiment shows at x (dim,): (dim + starts, N); nan where it cannot run.

    Central differences, one-sided where a neighbour means nothing.
    """
    dim, n = len(x), len(x) + experiment.starts
    h = np.concatenate([box.steps(x), np.full(experiment.starts, experiment.reach)])
    at = np.zeros(n)
    at[:dim] = x
    rows = np.vstack([at[None], at + np.diag(h), at - np.diag(h)])
    physical = box.physical(rows[:, :dim])
    signals = experiment.predict(rows[physical])
    f = np.full((len(rows), signals.shape[1]), np.nan)
    f[physical] = signals
    forward, backward = f[1 : n + 1], f[n + 1 :]
    J = (forward - backward) / (2 * h[:, None])
    J = np.where(np.isnan(J), (forward - f[0]) / h[:, None], J)
    complete: Array = np.where(np.isnan(J), (f[0] - backward) / h[:, None], J)
    return complete


def information(experiment: Experiment, x: Array, box: PriorBox) -> Array:
    """What an experiment tells of the parameters near x, SI, in their scales; (dim, dim).

    Its starts are at their best.
    """
    J, dim = slopes(experiment, x, box), len(x)
    J[:dim] *= box.pace(x)[:, None]
    A = np.einsum("im,jm->ij", J, J) / experiment.noise**2
    if experiment.starts:
        across = A[:dim, dim:]
        A = A[:dim, :dim] - across @ np.linalg.pinv(A[dim:, dim:], hermitian=True) @ across.T
    widened = np.sqrt(experiment.inflation)
    inflated: Array = A / np.outer(widened, widened)
    return inflated


def errors(*parts: Array) -> Array:
    """Standard errors from information that adds up, (dim,); scaled, as units differ widely."""
    deviations: Array = np.sqrt(np.diag(covariance(*parts)))
    return deviations


def covariance(*parts: Array) -> Array:
    """The inverse of information that adds up."""
    total = np.sum(parts, axis=0)
    scale = 1.0 / np.sqrt(np.diag(total))
    inverse = np.linalg.inv(total * np.outer(scale, scale))
    symmetric: Array = 0.5 * (inverse + inverse.T) * np.outer(scale, scale)
    return symmetric


def draws(x: Array, C: Array, n: int, box: PriorBox, rng: np.random.Generator) -> Array:
    """The fit and n - 1 parameter sets that the data allow, (n, dim).

    They are drawn with the covariance C, in the parameters' scales. One that leaves the box or
    means nothing is drawn again, and in the end brought nearer to the fit.
    """
    size = np.sqrt(np.diag(C))
    values, vectors = np.linalg.eigh(C / np.outer(size, size))
    root = size[:, None] * vectors * np.sqrt(np.maximum(values, 0.0))
    fit, points = box.scaled(x), [x]
    for _ in range(n - 1):
        tries = box.plain(fit + rng.standard_normal((TRIES, len(x))) @ root.T)
        allowed = np.flatnonzero(box.inside(tries))
        point = tries[allowed[0]] if len(allowed) else tries[0]
        while not box.inside(point[None])[0] and not np.allclose(point, x, rtol=1e-9, atol=0.0):
            point = box.plain(fit + 0.5 * (box.scaled(point) - fit))
        points.append(point)
    return np.array(points)


def information_at(experiment: Experiment, at: Array, box: PriorBox) -> Array:
    """Information at parameter sets (n, dim): (n, dim, dim), nan where it cannot be run."""
    return np.array([information(experiment, x, box) for x in at])


def factors(data: Array, further: Array) -> Array:
    """By what factor further information shrinks each standard error, (dim,): medians over draws.

    nan if the experiment cannot be run at half of them.

    Args:
        data: Information of the data at hand and the ranges at each draw, (n, dim, dim).
        further: Of the experiment, in the same order; nan where it cannot be run.
    """
    runnable = np.isfinite(further).all(axis=(1, 2))
    if 2 * np.count_nonzero(runnable) < len(further):
        return np.full(data.shape[1], np.nan)
    ratios = [
        errors(a) / errors(a, b) for a, b in zip(data[runnable], further[runnable], strict=True)
    ]
    medians: Array = np.median(ratios, axis=0)
    return medians
