"""Whether the arithmetic of a fit by simulation is exact enough for its intervals.

The answer is simulated once more, much finer. By how much that moves the residuals says, through
their slopes, by how much each parameter would move if the fit were repeated: one Gauss-Newton step.
Where that is a fair part of an interval the simulation is refined and the fit repeated from its
answer, which is near. Where the floor of a misfit is rough, slopes promise a step that no refit
keeps: a finer simulation that leaves the answer where it was leaves its intervals, too. Where it is
too rough to walk along, all ends are guesses, which no finer steps are worth.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..optimize.trust_region import Iterate
from ..rig.simulated import as_simulated
from ..wording import option
from .conditions import Violation
from .polish import polish
from .uncertainty.linearisation import box_of

if TYPE_CHECKING:
    from ..rig.simulated import SimulatedRig
    from ..space import Array, Space
    from .free_constants import FreeConstantsProblem
    from .initial_state import FreeStartProblem
    from .multistart import Optimum
    from .problem import MotionProblem
    from .uncertainty.assessment import Uncertainty

#: Share of its half-width by which the arithmetic may move a parameter: an interval of 95 % that is
#: displaced by a fifth holds at least 93 %.
SHARE = 0.2
#: The simulation that an answer is tried with has steps and tolerances shorter by these factors.
FINER = (8.0, 100.0)
#: The same from one refinement to the next one tried, how many are, and how often a fit is repeated
#: at most.
REFINED, TRIED, ROUNDS = (2.0, 30.0), 3, 2
#: Rows that it takes to see by how much parameters are moved.
SHIFTS = 2
#: Rows of a refit for each parameter: it starts at an answer that is nearly right.
ROWS = 30


#: How well the parameters of an optimum are known, and how many rows that took.
Profiling = Callable[["Optimum"], tuple["Uncertainty", int]]


class Checked(NamedTuple):
    """An optimum, how well its parameters are known, and what is to be told of its arithmetic."""

    optimum: Optimum
    uncertain: Uncertainty
    violations: Sequence[Violation] = ()


@dataclass(frozen=True)
class _Solution:
    """An optimum with its uncertainty, and how far its arithmetic is off.

    Args:
        optimum: Where the fit ended.
        uncertain: How well its parameters are known.
        shifts: By how much a finer simulation would move each parameter, by name, as a share of
            its half-width; inf where it cannot be run.
    """

    optimum: Optimum
    uncertain: Uncertainty
    shifts: Mapping[str, float]

    @property
    def worst(self) -> float:
        return max(self.shifts.values(), default=0.0)


def exact_enough(
    optimum: Optimum, uncertain: Uncertainty, profile: Profiling
) -> tuple[Checked, int]:
    """A fit whose arithmetic is exact enough, refined and repeated if it has to be; and the rows.

    With what is to be told of it: that it was refined, or that this did not help.

    Args:
        optimum: Where the fit ended.
        uncertain: How well its parameters are known.
        profile: The same for another optimum.
    """
    first = answer = best = _Solution(optimum, uncertain, shifts(optimum.problem, uncertain))
    spent = SHIFTS
    for _ in range(ROUNDS):
        if answer.worst <= SHARE or answer.uncertain.profiles.rough:
            break
        refit, rows = _refit(answer)
        spent += rows
        moved = shares(refit.problem.space, answer.uncertain, refit.x - answer.uncertain.x)
        if max(moved.values(), default=0.0) <= SHARE:  # where it was: not the arithmetic's
            answer = replace(answer, shifts=moved)
        else:
            uncertain, rows = profile(refit)
            answer = _Solution(refit, uncertain, shifts(refit.problem, uncertain))
            spent += rows + SHIFTS
        if answer.worst <= best.worst:
            best = answer
    return Checked(best.optimum, best.uncertain, _violations(first, best)), spent


def shifts(
    problem: MotionProblem | FreeStartProblem | FreeConstantsProblem, uncertain: Uncertainty
) -> dict[str, float]:
    """By how much a finer simulation would move each parameter; see `_Solution`.

    None by anything where a motion is exact, whatever its steps.
    """
    rig = as_simulated(problem.parameters.rig)
    now, finer = (
        each.residuals(uncertain.x[None])[0] for each in (problem, problem.on(rig.finer(*FINER)))
    )
    if np.array_equal(now, finer):
        return {p.name: 0.0 for p in uncertain.profiles.profiles}
    return _shifts_to(finer, problem, uncertain)


def _shifts_to(
    residuals: Array,
    problem: MotionProblem | FreeStartProblem | FreeConstantsProblem,
    uncertain: Uncertainty,
) -> dict[str, float]:
    """By how much residuals (m,) in place of the fit's move each parameter; see `_Solution`.

    One Gauss-Newton step from the fit, within ranges and orders. A fit that has come to rest on a
    jump of a coarse simulation, short of its minimum, moves too.
    """
    profiles = uncertain.profiles
    if not np.isfinite(residuals).all():
        return {p.name: np.inf for p in profiles.profiles}
    box = box_of(problem)
    u = box.u(uncertain.x)
    fit = replace(Iterate.at(u, residuals), J=profiles.J)
    step, _ = fit.step(box, range(box.dim), 1.0)
    return shares(box.space, uncertain, box.x(np.clip(u + step, 0.0, 1.0)) - box.x(u))


def shares(space: Space, uncertain: Uncertainty, off: Array) -> dict[str, float]:
    """Changes of all parameters, SI, (dim,), as shares of half-widths, by name.

    The half-width is that of the side that a parameter moves to; where that ends with the range,
    half of both sides if that is more.
    """
    by_name = dict(zip(space.names, off.tolist(), strict=True))
    result = {}
    for p in uncertain.profiles.profiles:
        shift = by_name[p.name]
        side = p.high if shift > 0.0 else p.low
        width = abs(side.end - p.value)
        if side.ended in ("bound", "flat"):  # nothing goes beyond it, however near it is
            width = max(width, 0.5 * (p.high.end - p.low.end))
        if width > 0.0:
            result[p.name] = abs(shift) / width
    return result


def _refined(answer: _Solution) -> tuple[SimulatedRig, int]:
    """The rig with the coarsest steps from which a finer simulation moves little; and the rows.

    The finest ones that are tried, if none are.
    """
    problem, rig = answer.optimum.problem, _rig(answer.optimum)
    spent = 0
    for _ in range(TRIED):
        rig, spent = rig.finer(*REFINED), spent + 2
        now, finer = (
            problem.on(r).residuals(answer.uncertain.x[None])[0] for r in (rig, rig.finer(*FINER))
        )
        off = _shifts_to(finer - now, problem, answer.uncertain)
        if max(off.values(), default=0.0) <= 0.5 * SHARE:  # the other half is for the new answer
            break
    return rig, spent


def _refit(answer: _Solution) -> tuple[Optimum, int]:
    """The optimum refitted from the answer with a finer simulation; and the rows."""
    rig, tried = _refined(answer)
    problem = answer.optimum.problem.on(rig)
    polished = polish(problem, answer.uncertain.x, None, ROWS * (problem.space.dim + 1))
    refit = replace(answer.optimum, problem=problem, x=polished.x)
    return refit, tried + polished.evaluations


def _rig(optimum: Optimum) -> SimulatedRig:
    return as_simulated(optimum.problem.parameters.rig)


def _violations(first: _Solution, best: _Solution) -> list[Violation]:
    rig, violations = _rig(best.optimum), []
    if best.optimum is not first.optimum:
        violations.append(
            Violation(
                "arithmetic",
                f"finer steps of the simulation would have moved {_largest(first)}: it was refined "
                f"to {rig.fineness} and the fit repeated",
                caps=False,
            )
        )
    if best.worst > SHARE:
        violations.append(
            Violation(
                "arithmetic",
                f"finer steps of the simulation than {rig.fineness} still move {_largest(best)}: "
                f"its interval is too narrow by that; set finer ones ({option('constants')}, "
                "docs/rigs.md)",
                frozenset(name for name, shift in best.shifts.items() if shift > SHARE),
            )
        )
    return violations


def _largest(answer: _Solution) -> str:
    """The parameter that moves most, and by how much."""
    rig, every = _rig(answer.optimum), answer.optimum.problem.parameters.every
    name = max(answer.shifts, key=answer.shifts.__getitem__)
    label = next((rig.label(q.name) for q in every if q.name == name), name)
    shift = answer.shifts[name]
    if not np.isfinite(shift):
        return "the motion beyond what can be simulated"
    return f"{label} by {shift:.2g} of the half-width of its interval"
