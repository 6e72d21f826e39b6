"""Estimates that a refit with something more in the model moves, in words."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ..rig import Rig
from ..rig.rig import shown_in
from ..space import Param

if TYPE_CHECKING:
    from .polish import Polished
    from .problem import MotionProblem
    from .uncertainty.estimates import Estimate


def may_be(rig: Rig, q: Param, e: Estimate, value: float) -> str:
    """What an estimate would be instead, SI, beside what it is."""
    instead, now = (float(shown_in(rig, q, x)) for x in (value, e.value))
    return f"{e.name} may be {instead:.3g}, not {now:.3g} {e.unit}".rstrip()


def refit_text(
    problem: MotionProblem, estimates: Sequence[Estimate], refit: Polished, before: float
) -> tuple[str, bool]:
    """What a refit with one more unknown changes; and whether estimates leave their intervals.

    Args:
        problem: The problem without it.
        estimates: As in `parameters.every`.
        refit: Its free parameters, and the further unknown after them.
        before: J without it.
    """
    parameters = problem.parameters
    values = parameters.full(refit.x[None, :-1])[0].tolist()
    moved = [
        may_be(parameters.rig, q, e, value)
        for q, e, value in zip(parameters.every, estimates, values, strict=True)
        if e.verdict != "fixed" and not e.low <= value <= e.high
    ]
    misfit = f"with that J is {refit.cost:.3g}, not {before:.3g} {problem.unit}"
    return ", and ".join([misfit, " and ".join(moved)]) if moved else misfit, bool(moved)
