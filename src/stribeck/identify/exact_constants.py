"""What a fit owes to constants that are taken as exact: they have no tolerance to carry."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from ..constant import COVERAGE, Constant
from ..errors import InputError
from ..optimize import rms
from ..rig import Rig
from ..rig.rig import shown_difference
from ..space import Array
from ..units import percent
from .free_constants import FreeConstantsProblem, constant_slopes, stated_by_logs
from .initial_state import FreeStartProblem
from .parameters import Parameters
from .problem import MotionProblem
from .uncertainty.estimates import Estimate

#: A constant is named where an error of it moves an identified parameter by at least this share of
#: that error, both relative: 10 % by 3 %.
NAMED = 0.3
#: The error that is told, relative.
ERROR = 0.1
#: The step over which slopes are taken, relative to the constant.
STEP = 0.01
#: What a parameter's meaning says of constants with a tolerance that are told only together.
NOT_APART = "which the data do not tell apart"
#: Slopes of parameters over a constant, SI, by the names of both.
Slopes = Mapping[str, Mapping[str, float]]


def is_exact(c: Constant) -> bool:
    """Whether a constant is a quantity of the axis, taken as exact, that could be otherwise."""
    return (
        c.origin not in ("setting", "derived", "standard", "counted")
        and not c.tolerance
        and bool(c.value)
    )


def exact_slopes(problem: MotionProblem | FreeStartProblem, x: Array) -> tuple[Slopes, int]:
    """Slopes of a fit's free parameters over its rig's constants, all other parameters refitted.

    Over the exact ones; and over those with a tolerance, each with the others held, where there
    are several that the data might not tell apart. And how many rows were evaluated.

    Args:
        problem: The motion problem.
        x: Its solution, SI, (dim,).
    """
    stated = stated_by_logs(problem)
    rig = problem.parameters.rig
    uncertain = {c.name for c in rig.uncertain if c.value}
    exact = [
        replace(c, tolerance=COVERAGE * STEP * abs(c.value))
        for c in rig.constants
        if (is_exact(c) or (c.name in uncertain and len(uncertain) > 1)) and c.name not in stated
    ]
    noise = float(rms(problem.residuals(x[None]))[0])
    if not exact or not noise > 0:
        return {}, 1
    pretended = FreeConstantsProblem(problem, exact, noise)
    try:
        slopes, _, rows = constant_slopes(pretended, np.concatenate([x, pretended.nominal]))
    except InputError:  # too few rows to tell so many apart
        return {}, 1
    names = [q.name for q in problem.parameters.free]
    return {
        c.name: dict(zip(names, column.tolist(), strict=True))
        for c, column in zip(exact, slopes.T, strict=True)
    }, 1 + rows


def exact_constants(
    parameters: Parameters,
    estimates: Sequence[Estimate],
    slopes: Slopes,
    stated: Iterable[str] = (),
) -> list[str]:
    """A sentence that names what identified parameters stand on: exact constants, values set.

    And one that says what constants with a tolerance do, where the data do not tell them apart.

    Args:
        parameters: Theirs.
        estimates: As in `parameters.every`.
        slopes: Of the parameters over the exact constants, and over parameters that are set.
        stated: Names of constants that the logs state, which a rig cannot set elsewhere.
    """
    exact = dict(parameters.fixed)
    exact |= {c.name: c.value for c in parameters.rig.constants if not c.tolerance > 0}
    identified = [e.verdict == "identified" for e in estimates]
    ordered = _clauses(parameters, estimates, slopes, exact, identified)
    names = sorted(stated) if any(identified) else []
    if names:
        ordered.append(f"the logs state {_listed(names)}")
    sentences = []
    if ordered:
        sentences = [f"taken as exact, so that no interval knows of an error: {'; '.join(ordered)}"]
    uncertain = {c.name: c.value for c in parameters.rig.constants if c.tolerance > 0}
    together = [NOT_APART in (e.meaning or "") for e in estimates]
    if clauses := _clauses(parameters, estimates, slopes, uncertain, together, absolute=True):
        sentences.append(
            "what each constant does while the other ones stay as they are: " + "; ".join(clauses)
        )
    return sentences


def _clauses(
    parameters: Parameters,
    estimates: Sequence[Estimate],
    slopes: Slopes,
    values: Mapping[str, float],
    chosen: Sequence[bool],
    *,
    absolute: bool = False,
) -> list[str]:
    """What errors of constants, and of parameters that are set, move, the most moving ones first.

    Args:
        parameters: Theirs.
        estimates: As in `parameters.every`.
        slopes: Of the parameters over them.
        values: Theirs, SI, by name.
        chosen: Whether an estimate is told of.
        absolute: Whether in the unit of the estimate, as of one that may be zero; else in per cent.
    """
    clauses: dict[str, float] = {}
    for name, over in slopes.items():
        if name not in values:
            continue
        moved: dict[str, float] = {}
        for q, e, told in zip(parameters.every, estimates, chosen, strict=True):
            if told and e.value and q.name in over:
                share = over[q.name] * values[name] / e.value
                if abs(share) >= NAMED:
                    change = shown_difference(parameters.rig, q, ERROR * share * e.value)
                    amount = f"{change:.2g} {e.unit}" if absolute else percent(ERROR * share)
                    moved[f"{e.name} by {amount.rstrip()}"] = abs(share)
        if moved:
            clause = (
                f"{100 * ERROR:.0f} % of {parameters.rig.label(name)} moves {_listed([*moved])}"
            )
            clauses[clause] = max(moved.values())
    return sorted(clauses, key=lambda clause: -clauses[clause])


def scale(rig: Rig) -> list[str]:
    """A sentence that names what sets the scale of all forces, where no motion can tell it."""
    if not rig.scale or (rig.drive_chain is not None and rig.rests_on_force):
        return []
    proportional = f"forces, masses and stiffnesses are in proportion to {rig.scale}"
    return [
        f"{proportional}: if that is {100 * ERROR:.0f} % off, so are they, and no motion shows it"
    ]


def _listed(phrases: Sequence[str]) -> str:
    *first, last = phrases
    return f"{', '.join(first)} and {last}" if first else last
