"""A check of expected information: twins of the data and of an experiment, with noise, refitted."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.random import SeedSequence

from ...optimize import rms
from ...space import Array, Param, Space
from ..polish import polish
from .experiment import Experiment, PriorBox

#: Rounds of a refit, and how far a start may move, in standard deviations of a sample.
REFITS, ROOM = 40, 4.0
#: By how much the sum of squares, noise being 1, must be less for another end to count.
BETTER = 1.0
#: The most a noise may resemble the sample before.
PERSISTENT = 0.97


@dataclass(frozen=True, eq=False)
class TwinStudy:
    """The errors of refits of twins, without and with an experiment.

    Args:
        factors: By what factor it really shrinks the error of each parameter: medians of
            absolute errors over twins, without it by with it, (dim,).
        before: Errors of refits of the data alone, in the scales of the box, (twins, dim).
        after: The same with the experiment, (twins, dim).
    """

    factors: Array
    before: Array
    after: Array

    @property
    def twins(self) -> int:
        """How many there were."""
        return len(self.before)


def twin_study(
    data: Experiment, experiment: Experiment, box: PriorBox, at: Array, n: int, seed: int
) -> TwinStudy:
    """Try out an experiment on twins.

    A twin's truth is one of the parameter sets that the data allow; what the data and the
    experiment would show of it is simulated, gets noise, and is refitted from the fit, and from
    the truth too: the better end counts, but what the data do not see stays as it was fitted.

    Args:
        data: The data at hand.
        experiment: The experiment.
        box: Of the parameters.
        at: Parameter sets that the data allow, (n, dim), the fit first.
        n: Twins.
        seed: Of the noise.
    """
    before: list[Array] = []
    after: list[Array] = []
    for k, stream in enumerate(SeedSequence(seed).spawn(n)):
        rng = np.random.default_rng(stream)
        truth = at[1 + k % (len(at) - 1)] if len(at) > 1 else at[0]
        shown = [_shown(e, truth, rng) for e in (data, experiment)]
        for errors, count in ((before, 1), (after, 2)):
            refitted = _best([data, experiment][:count], shown[:count], (at[0], truth), box)
            errors.append(box.scaled(refitted) - box.scaled(truth))
    errors_before, errors_after = np.array(before), np.array(after)
    with np.errstate(invalid="ignore", divide="ignore"):
        factors = np.median(np.abs(errors_before), axis=0) / np.median(np.abs(errors_after), axis=0)
    return TwinStudy(factors, errors_before, errors_after)


def _shown(experiment: Experiment, truth: Array, rng: np.random.Generator) -> Array:
    """What an experiment shows of a truth, with noise as correlated as it is."""
    from scipy.signal import lfilter  # noqa: PLC0415 - slow to import

    at_start = np.concatenate([truth, np.zeros(experiment.starts)])
    clean: Array = experiment.predict(at_start[None])[0]
    time = float(np.median(experiment.inflation))
    a = min((time - 1) / (time + 1), PERSISTENT) if time > 1 else 0.0
    white = rng.standard_normal(len(clean)) * np.sqrt(1 - a * a)
    white[0] /= np.sqrt(1 - a * a)
    scale = experiment.noise if time >= 1 else experiment.noise * np.sqrt(time)
    noisy: Array = clean + scale * np.asarray(lfilter([1.0], [1.0, -a], white), dtype=float)
    return noisy


def _best(
    experiments: list[Experiment], shown: list[Array], starts: tuple[Array, Array], box: PriorBox
) -> Array:
    """Parameters that fit what was shown: refitted from the first place unless the other wins."""
    problem = _Refit(experiments, shown, box)
    (a, cost), (b, cost_b) = (problem.solved(x) for x in starts)
    return b if cost_b < cost - BETTER else a


class _Refit:
    """Experiments and what they have shown, as a problem of least squares, noise being 1.

    Args:
        experiments: The experiments.
        shown: What each has shown.
        box: Of the parameters; the starts of the experiments come behind these.
    """

    def __init__(self, experiments: list[Experiment], shown: list[Array], box: PriorBox) -> None:
        self.name = "twin"
        self._experiments, self._shown, self._box = experiments, shown, box
        ends = zip(box.lower.tolist(), box.upper.tolist(), box.log.tolist(), strict=True)
        self._dim = len(box.lower)
        starts = [ROOM * e.noise for e in experiments for _ in range(e.starts)]
        self.space = Space((
            *(Param(f"x{i}", a, b, log=by) for i, (a, b, by) in enumerate(ends)),
            *(Param(f"start{i}", -r, r) for i, r in enumerate(starts)),
        ))  # fmt: skip

    def __call__(self, x: Array, /) -> Array:
        """(n, dim) points to (n,) root mean squares."""
        return rms(self.residuals(x))

    def residuals(self, x: Array, /) -> Array:
        """(n, dim) points to (n, N) residuals; nan where a point means nothing."""
        physical, blocks, at = self._box.physical(x[:, : self._dim]), [], self._dim
        for e, y in zip(self._experiments, self._shown, strict=True):
            rows = np.full((len(x), len(y)), np.nan)
            columns = np.hstack([x[physical, : self._dim], x[physical, at : at + e.starts]])
            if len(columns):
                time = float(np.median(e.inflation))
                rows[physical] = (y - e.predict(columns)) / (e.noise * np.sqrt(time))
            blocks.append(rows)
            at += e.starts
        return np.concatenate(blocks, axis=1)

    def solved(self, start: Array) -> tuple[Array, float]:
        """The parameters of the best fit near a place, and its sum of squares."""
        x = np.concatenate([start, np.zeros(self.space.dim - self._dim)])
        polished = polish(self, x, None, REFITS * (self.space.dim + 1))
        samples = sum(len(y) for y in self._shown)
        return polished.x[: self._dim], polished.cost**2 * samples
