"""Sums of a parameter and a constant that the data know better than the parameter.

Where a constant of the rig is uncertain, a parameter that moves against it cannot be known better
than the constant; their sum can. In stick-slip behind a motor with friction of its own the slide
breaks away where the drive line pulls with both: the data know F_S + F_fm.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..space import Array, Param, Space
from ..units import convertible
from .free_constants import FreeConstantsProblem, Ruling
from .uncertainty.profile import Profile, Profiles, profiles
from .uncertainty.residuals import orders_of, physical
from .uncertainty.verdict import Reason, Verdict, verdict

#: A sum is looked at where its variance is below this share of the parameter's.
LESS = 0.9
#: Rows that the profile of a sum may evaluate, for each dimension of its problem.
ROWS = 150


@dataclass(frozen=True)
class Combination:
    """The sum of a parameter and a constant, SI.

    Args:
        parameter: The parameter's name.
        constant: The constant's name.
        value: Of the sum.
        low: Lower end of its profile's 95 % interval.
        high: Upper end.
        verdict: As of a parameter.
        unit: In which people see it.
        reason: As of a parameter.
    """

    parameter: str
    constant: str
    value: float
    low: float
    high: float
    verdict: Verdict
    unit: str
    reason: Reason = ""


class SumProblem:
    """A problem with the sum of a parameter and a constant in the parameter's place.

    Args:
        problem: The problem.
        parameter: Name of the parameter.
        constant: Name of the constant.
    """

    def __init__(self, problem: FreeConstantsProblem, parameter: str, constant: str) -> None:
        self._problem = problem
        names = problem.space.names
        self._i, self._j = names.index(parameter), names.index(constant)
        self.name = f"{problem.name}/{parameter}+{constant}"
        params = list(problem.space.params)
        q, c = params[self._i], params[self._j]
        params[self._i] = Param(
            f"{parameter} + {constant}", q.lower + c.lower, q.upper + c.upper, q.unit
        )
        few = problem.dofs.get(parameter)
        self.dofs = {} if few is None else {params[self._i].name: few}
        self.space, self.logs, self.priors = Space(tuple(params)), problem.logs, problem.priors
        self.orders = tuple(pair for pair in orders_of(problem) if self._i not in pair)

    def residuals(self, x: Array, /) -> Array:
        """(n, dim) points to (n, rows) residuals; nan where they mean nothing."""
        parts = self._parts(x)
        residuals = np.full((len(parts), sum(self.logs) + self.priors), np.nan)
        runs = physical(self._problem, parts)
        if runs.any():
            residuals[runs] = self._problem.residuals(parts[runs])
        return residuals

    def physical(self, x: Array) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
        """Which points (n, dim) mean something."""
        return physical(self._problem, self._parts(x))

    def point(self, x: Array) -> Array:
        """A point of the problem, (dim,), as one of this."""
        y = x.copy()
        y[self._i] += x[self._j]
        return y

    def _parts(self, x: Array) -> Array:
        parts = np.atleast_2d(np.asarray(x, dtype=float)).copy()
        parts[:, self._i] -= parts[:, self._j]
        return parts


def combinations(
    problem: FreeConstantsProblem, rulings: Sequence[Ruling], x: Array
) -> tuple[tuple[Combination, ...], int]:
    """The sums that the data know better than their parameters, and how many rows were evaluated.

    Args:
        problem: The problem that was solved.
        rulings: How its constants move its parameters.
        x: Its solution, SI, (dim,).
    """
    params = {q.name: q for q in problem.space.params}
    rig = problem.parameters.rig
    best: dict[str, Ruling] = {}
    for r in rulings:
        same = convertible(params[r.parameter].unit, params[r.constant].unit)
        least = _variance(best[r.parameter]) if r.parameter in best else LESS
        if same and _variance(r) < least:
            best[r.parameter] = r
    result, rows = [], 0
    for r in best.values():
        q = params[r.parameter]
        summed = SumProblem(problem, r.parameter, r.constant)
        name = f"{r.parameter} + {r.constant}"
        profiled: Profiles = profiles(
            summed,
            summed.point(x),
            budget=ROWS * len(x),
            chosen_names=[name],
            keep=True,
        )
        rows += profiled.rows
        (profile,) = profiled.profiles
        judged = _judged(profile, summed.space)
        result.append(
            Combination(
                r.parameter,
                r.constant,
                profile.value,
                profile.low.end,
                profile.high.end,
                judged[0],
                rig.unit_of(q),
                judged[1],
            )
        )
    return tuple(result), rows


def _variance(r: Ruling) -> float:
    """Of the sum of a parameter and a constant, as a share of the parameter's."""
    return 1 + r.share * (2 * r.slope + 1) / r.slope**2 if r.slope else np.inf


def _judged(profile: Profile, space: Space) -> tuple[Verdict, Reason]:
    (param,) = [q for q in space.params if q.name == profile.name]
    return verdict(profile, param)
