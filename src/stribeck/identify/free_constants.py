"""The rig's constants that are not exact, estimated together with the parameters.

A constant with a tolerance is known beforehand, give or take that. The last refinement, and every
statement about uncertainty, has it among the unknowns, held by a prior: so the intervals of the
parameters hold for every value that the constant may have, and say how much of their width is
its doing.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..constant import Constant
from ..optimize import Counted, rms
from ..optimize.slopes import MOST_FANS
from ..rig import Rig
from ..rig.simulated import as_simulated
from ..space import Array, Param, Space
from ..units import unit
from .initial_state import FreeStartProblem
from .parameters import Parameters
from .problem import MotionProblem
from .uncertainty.linearisation import box_of, linearised

#: How far from its value a constant may be estimated, in standard deviations.
REACH = 4.0
#: Nor nearer to 0 than this share of its value, where it cannot be 0.
NEAR_ZERO = 1e-3
#: A constant whose standard deviation moves no parameter by more than this share of the parameter's
#: own standard error is left out: it would widen no interval by more than a hundredth.
MATTERS = 0.1


class FreeConstantsProblem:
    """A motion problem with constants of its rig as further parameters, after all others.

    Residuals are those of the motion problem, and after them one for each constant: its distance
    from the value known beforehand, over the standard deviation of that, times the noise.

    Args:
        problem: The motion problem, with or without free starts.
        constants: Those that are free; each has a tolerance.
        noise: Root mean square of the motion problem's residuals at a good fit, in its unit.
    """

    def __init__(
        self,
        problem: MotionProblem | FreeStartProblem,
        constants: Sequence[Constant],
        noise: float,
    ) -> None:
        self.problem, self.constants, self.noise = problem, tuple(constants), noise
        self.parameters = problem.parameters
        self.name = f"{problem.name}/constants"
        known = [_as_param(c, *problem.parameters.rig.limits(c.name)) for c in constants]
        self.space = Space((*problem.space.params, *known))
        self._ranges = np.array([q.lower for q in known]), np.array([q.upper for q in known])
        self.logs = problem.logs
        own = problem.priors if isinstance(problem, MotionProblem) else 0
        self.rows, self.priors = sum(problem.logs) + own, own + len(self.constants)

    def on(self, rig: Rig) -> FreeConstantsProblem:
        """The same problem on a rig of the same kind with other constants."""
        return FreeConstantsProblem(self.problem.on(rig), self.constants, self.noise)

    def over(self, parameters: Parameters) -> FreeConstantsProblem:
        """The same problem over other free parameters or search ranges."""
        return FreeConstantsProblem(self.problem.over(parameters), self.constants, self.noise)

    def thinned(self) -> FreeConstantsProblem:
        """The problem on fewer samples, for a search; itself where its rig or its law needs all."""
        fewer = self.problem.thinned()
        if fewer is self.problem:
            return self
        noise = self.noise * float(np.sqrt(sum(fewer.logs) / sum(self.logs)))  # priors weigh alike
        return FreeConstantsProblem(fewer, self.constants, noise)

    @property
    def dofs(self) -> Mapping[str, float]:
        """Those of the motion problem."""
        return self.problem.dofs if isinstance(self.problem, MotionProblem) else {}

    @property
    def nominal(self) -> Array:
        """The constants as known beforehand, SI, (constants,)."""
        return np.array([c.value for c in self.constants])

    def __call__(self, x: Array, /) -> Array:
        """(n, dim) points to (n,) root mean squares of their residuals."""
        return rms(self.residuals(x))

    def residuals(self, x: Array, /) -> Array:
        """(n, dim) points to (n, rows + constants) residuals, in the problem's unit."""
        x = np.atleast_2d(x)
        k = len(self.problem.space.params)
        sd = np.array([c.standard_deviation for c in self.constants])
        residuals = np.full((len(x), self.rows + len(self.constants)), np.nan)
        residuals[:, self.rows :] = self.noise * (x[:, k:] - self.nominal) / sd
        if isinstance(self.problem, FreeStartProblem):
            values = np.clip(x[:, k:], *self._ranges)
            own = {c.name: column for c, column in zip(self.constants, values.T, strict=True)}
            residuals[:, : self.rows] = self.problem.residuals(x[:, :k], own)
            return residuals
        for values in np.unique(x[:, k:], axis=0):
            rows = (x[:, k:] == values).all(axis=1)
            residuals[rows, : self.rows] = self._at(values).residuals(x[rows, :k])
        return residuals

    def at(self, x: Array) -> tuple[MotionProblem | FreeStartProblem, Array]:
        """The motion problem with the constants of a point (dim,), and the rest of the point."""
        k = len(self.problem.space.params)
        return self._at(x[k:]), x[:k]

    def _at(self, values: Array) -> MotionProblem | FreeStartProblem:
        """The motion problem on a rig with these constants, SI."""
        values = np.clip(values, *self._ranges)  # which rounding may have left
        by_name = {c.name: float(v) for c, v in zip(self.constants, values, strict=True)}
        return self.problem.on(self.parameters.rig.estimated(by_name))


@dataclass(frozen=True)
class Ruling:
    """How a constant moves a parameter.

    Args:
        parameter: The parameter's name.
        constant: The constant's name.
        slope: Change of the parameter, the others refitted, for a change of the constant, SI.
        share: Of the parameter's variance that the constant's tolerance makes, 0 to 1.
    """

    parameter: str
    constant: str
    slope: float
    share: float


def with_free_constants(
    problem: MotionProblem | FreeStartProblem, x: Array
) -> tuple[MotionProblem | FreeStartProblem | FreeConstantsProblem, Array, int]:
    """The problem with those of its rig's uncertain constants free that matter.

    And the point in it, and how many rows were evaluated.

    Args:
        problem: The motion problem.
        x: A good fit, SI, (dim,).
    """
    stated = stated_by_logs(problem)
    constants = [c for c in problem.parameters.rig.uncertain if c.name not in stated]
    if not constants:
        return problem, x, 0
    noise = float(rms(problem.residuals(x[None]))[0])
    if not noise > 0:
        return problem, x, 1
    whole = FreeConstantsProblem(problem, constants, noise)
    slopes, errors, rows = constant_slopes(whole, np.concatenate([x, whole.nominal]))
    sd = np.array([c.standard_deviation for c in constants])
    with np.errstate(divide="ignore", invalid="ignore"):
        effect = np.abs(slopes) * sd / errors[:, None]
    matters = (effect > MATTERS).any(axis=0)
    chosen = [c for c, does in zip(constants, matters, strict=True) if does]
    if not chosen:
        return problem, x, 1 + rows
    reduced = FreeConstantsProblem(problem, chosen, noise)
    return reduced, np.concatenate([x, reduced.nominal]), 1 + rows


def rulings(problem: FreeConstantsProblem, x: Array, curvature: Array) -> list[Ruling]:
    """How the constants move the parameters at a fit, all others refitted.

    Args:
        problem: The problem that was solved.
        x: The fit, SI, (dim,).
        curvature: Covariance of all its parameters over the unit cube, up to a factor, (dim, dim).
    """
    box, k = box_of(problem), len(problem.problem.space.params)
    scale = box.scale(box.u(x))
    C = curvature * np.outer(scale, scale)
    result = []
    for i, q in enumerate(problem.parameters.free):
        for j, c in enumerate(problem.constants, k):
            if C[i, i] > 0 and C[j, j] > 0:
                slope, share = C[i, j] / C[j, j], C[i, j] ** 2 / (C[i, i] * C[j, j])
                result.append(Ruling(q.name, c.name, float(slope), float(share)))
    return result


def stated_by_logs(problem: MotionProblem | FreeStartProblem) -> frozenset[str]:
    """Names of the constants that all logs of a problem state themselves."""
    rig = as_simulated(problem.parameters.rig)
    train = problem.problem.train if isinstance(problem, FreeStartProblem) else problem.train
    return frozenset.intersection(*(frozenset(rig.stated(s.recording)) for s in train))


def constant_slopes(problem: FreeConstantsProblem, x: Array) -> tuple[Array, Array, int]:
    """Slopes of the free parameters over the constants, all others refitted, SI.

    (free, constants), and the standard errors of the free parameters with the constants held,
    (free,); and how many rows were evaluated.

    Args:
        problem: The problem.
        x: A good fit, SI, (dim,).
    """
    box, k = box_of(problem), len(problem.problem.space.params)
    counted = Counted(problem, 1 + MOST_FANS * (box.dim + 1))
    fit = linearised(counted, box, x)
    Jx, Jc = np.split(fit.J[:, : problem.rows], [k])
    C = np.linalg.pinv(np.einsum("im,jm->ij", Jx, Jx), hermitian=True)
    slopes = -C @ np.einsum("im,jm->ij", Jx, Jc)
    errors = problem.noise * np.sqrt(np.maximum(np.diag(C), 0.0))
    free, scale = len(problem.parameters.free), box.scale(fit.u)
    si = slopes * scale[:k, None] / scale[None, k:]
    return si[:free], (errors * scale[:k])[:free], counted.rows


def _as_param(c: Constant, least: float, most: float) -> Param:
    """A constant as a parameter, within what it can be: `least` and `most`, SI."""
    reach = REACH * c.standard_deviation
    lower = max(c.value - reach, 0.0 if c.value >= 0 else -np.inf, least)
    if least > 0:
        lower = max(lower, NEAR_ZERO * c.value)
    return Param(c.name, lower, min(c.value + reach, most), unit(c.unit).dimension, doc=c.doc)
