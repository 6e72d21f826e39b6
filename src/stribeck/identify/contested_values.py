"""Values that parameters are set to, against what the data give for these once they are free.

A value that is set has no interval, and no condition of a fit asks whether it is right: others
bend around it, and what it leaves over looks like a delay, a drop of friction or play. So each
parameter is freed once more beside the fit. The data contest its value where they determine
another one, and the fit is better for that by more than noise. Where they do not, what rests on it
is named. A model that leaves something out bends to make up for it whatever is free: then a value
is contested only if that is most of what was left.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..errors import InputError
from ..optimize import Counted
from ..optimize.slopes import MOST_FANS
from ..rig.rig import shown_in
from .adequacy.effects import OF_INTERVAL, OF_VALUE
from .conditions import Violation
from .exact_constants import Slopes
from .fit_warnings import NOISY
from .free_constants import FreeConstantsProblem
from .initial_state import FreeStartProblem
from .moved_estimates import may_be
from .parameters import AT_END
from .polish import polish
from .uncertainty.assessment import standard_errors
from .uncertainty.covariance import BLIND, HALF_WIDTH
from .uncertainty.linearisation import box_of, linearised
from .uncertainty.profile import profiles

if TYPE_CHECKING:
    from ..space import Array, Param
    from .parameters import Parameters
    from .problem import MotionProblem
    from .uncertainty.estimates import Estimate

#: A value is contested where it lies so many times farther from the estimate as the end of the 95 %
#: interval on its side, and by more than this share of the greater of both.
BEYOND, APART = 1.5, 0.01
#: It is told where other estimates bend around it, or the sum of squares falls by the first share;
#: where the misfit stays beyond the noise, or the estimate at an end of its range, by the second.
GAIN, MOST = 0.05, 0.5
#: Evaluations of a refit by output error, and of the profile of what it frees, for each unknown.
ROWS, PROFILE = 15, 60


@dataclass(frozen=True)
class FreedValue:
    """What the data give for a parameter that is set.

    Args:
        name: The parameter's.
        value: Its estimate, SI.
        low: Lower end of the 95 % interval.
        high: Upper end.
        values: All parameters with it free, SI, (k,).
        gain: The share by which the sum of squares falls.
        misfit: What becomes of the misfit, in words.
        adequate: Whether it is known that the model leaves nothing out with it free: then what it
            leaves over is the value's doing.
    """

    name: str
    value: float
    low: float
    high: float
    values: Array
    gain: float
    misfit: str
    adequate: bool = False

    def contests(self, fixed: float) -> bool:
        """Whether it says that the value is another one."""
        half = self.high - self.value if fixed > self.value else self.value - self.low
        least = max(BEYOND * half, APART * max(abs(self.value), abs(fixed)))
        return abs(self.value - fixed) > least


def fixed_values(parameters: Parameters) -> dict[str, float]:
    """The values set of parameters that would be searched, SI, by name."""
    return {
        q.name: parameters.fixed[q.name]
        for q in parameters.every
        if q.fixed is None and q.name in parameters.fixed and q.name not in parameters.held
    }


def contested(
    parameters: Parameters, freed: FreedValue, judged: Sequence[Estimate]
) -> Violation | None:
    """What is told of a value that the data contest, and of estimates that bend around it.

    None if they do not contest it.

    Args:
        parameters: Of the fit, the value set.
        freed: What the data give for it.
        judged: Estimates of the fit, as in `parameters.every`.
    """
    fixed = parameters.fixed[freed.name]
    if not freed.contests(fixed):
        return None
    rig = parameters.rig
    (q,) = (q for q in parameters.every if q.name == freed.name)
    label, unit = rig.label(q.name), rig.unit_of(q)
    shown = [float(shown_in(rig, q, x)) for x in (fixed, freed.value, freed.low, freed.high)]
    at, value, low, high = (f"{x:.5g}" for x in shown)
    moved = {
        q.name: may_be(rig, q, e, x)
        for q, e, x in zip(parameters.every, judged, freed.values.tolist(), strict=True)
        if e.verdict != "fixed" and _moves(q, e, x)
    }
    if not moved and not freed.gain > GAIN:
        return None
    others = f", and {' and '.join(moved.values())}" if moved else ""
    sentence = (
        f"{label} is set to {at} {unit}".rstrip()
        + f", and the data give {value} ({low} to {high}) {unit}".rstrip()
        + f": with that {freed.misfit}{others}: leave {label} free, or find out why they differ"
    )
    return Violation("constants", sentence, frozenset(moved), caps=bool(moved))


def _moves(q: Param, e: Estimate, value: float) -> bool:
    half = 0.5 * (e.high - e.low)
    least = max(OF_INTERVAL * half, OF_VALUE * abs(e.value), 1e-9 * (q.upper - q.lower))
    return abs(value - e.value) > least


def contested_by_motion(
    problem: MotionProblem | FreeStartProblem | FreeConstantsProblem,
    x: Array,
    judged: Sequence[Estimate],
    noise: float,
) -> tuple[list[Violation], int]:
    """The values that the motion contests; and the rows evaluated.

    Args:
        problem: The problem solved, its uncertain constants among the unknowns.
        x: The fit, SI, (dim,).
        judged: Its estimates, as in `parameters.every`.
        noise: Of the sensors, in the unit of J.
    """
    violations, rows = [], 0
    for name in fixed_values(problem.parameters):
        freed, spent = _freed(problem, x, name, noise)
        rows += spent
        violation = None if freed is None else contested(problem.parameters, freed, judged)
        violations += [] if violation is None else [violation]
    return violations, rows


def _freed(
    problem: MotionProblem | FreeStartProblem | FreeConstantsProblem,
    x: Array,
    name: str,
    noise: float,
) -> tuple[FreedValue | None, int]:
    """What the motion gives for a parameter that is set, if that explains more; and the rows."""
    parameters = problem.parameters.freeing(name)
    dim = len(parameters.free)
    place = [q.name for q in parameters.free].index(name)
    start = np.insert(x, place, problem.parameters.fixed[name])
    parameters = parameters.reaching(start[:dim])
    freed = problem.over(parameters)
    each = len(start) + 1
    before = float(problem(x[None])[0])
    refit = polish(freed, start, before, ROWS * each)
    rows = 1 + refit.evaluations
    now, was = _reported(freed, refit.x), _reported(problem, x)
    gain = 1.0 - (refit.cost / before) ** 2
    (u,) = freed.space.encode(refit.x[None])
    at_end = not AT_END < u[place] < 1.0 - AT_END
    if gain < MOST and (now > NOISY * noise or at_end):
        return None, rows
    try:
        errors, _ = standard_errors(freed, refit.x)
        rows += each
        if abs(refit.x[place] - start[place]) <= HALF_WIDTH * float(errors[place]):
            return None, rows
        budget = PROFILE * each
        profiled = profiles(freed, refit.x, budget=budget, chosen_names=[name], keep=True)
    except InputError:  # too few rows to tell so many apart
        return None, rows
    rows += profiled.rows
    (profile,) = profiled.profiles
    unit = parameters.rig.unit_shown("position")
    misfit = f"J is {now:.3g}, not {was:.3g} {unit}"
    values = parameters.full(refit.x[None, :dim])[0]
    low, high = profile.low.end, profile.high.end
    return FreedValue(name, profile.value, low, high, values, gain, misfit), rows


def value_slopes(problem: MotionProblem | FreeStartProblem, x: Array) -> tuple[Slopes, int]:
    """Slopes of a fit's free parameters over the values set, all others refitted; and the rows.

    Args:
        problem: The motion problem.
        x: Its solution, SI, (dim,).
    """
    names, values = problem.space.names, fixed_values(problem.parameters)
    if not values:
        return {}, 0
    parameters, start = problem.parameters, dict(zip(names, x.tolist(), strict=True)) | values
    for name in values:
        parameters = parameters.freeing(name)
    at = np.array([start[q.name] for q in problem.over(parameters).space.params])
    freed = problem.over(parameters.reaching(at[: len(parameters.free)]))
    box = box_of(freed)
    counted = Counted(freed, 1 + MOST_FANS * (box.dim + 1))
    try:
        fit = linearised(counted, box, at)
    except InputError:  # too few rows to tell so many apart
        return {}, counted.rows
    J = dict(zip(freed.space.names, fit.J / box.scale(fit.u)[:, None], strict=True))
    return slopes_over([J[n] for n in names], {n: J[n] for n in values}, names), counted.rows


def slopes_over(
    columns: Sequence[Array], over: Mapping[str, Array], names: Sequence[str]
) -> Slopes:
    """Slopes of parameters over others from the slopes of the residuals, SI, by the names of both.

    Args:
        columns: Slopes of the residuals over the parameters that are refitted, (rows,) each.
        over: Those over the others, by name.
        names: Of the parameters that are refitted.
    """
    W = np.column_stack(columns)
    lengths = np.linalg.norm(W, axis=0)
    lengths[lengths == 0] = 1.0
    return {
        name: dict(zip(names, moved.tolist(), strict=True))
        for name, column in over.items()
        for moved in (np.linalg.lstsq(W / lengths, -column, rcond=np.sqrt(BLIND))[0] / lengths,)
    }


def _reported(problem: MotionProblem | FreeStartProblem | FreeConstantsProblem, x: Array) -> float:
    """The misfit of the motion alone that a fit reports of a point (dim,)."""
    if isinstance(problem, FreeConstantsProblem):
        problem, x = problem.at(x)
    if isinstance(problem, FreeStartProblem):
        problem, x = problem.at(x)
    return problem.reported(x)
