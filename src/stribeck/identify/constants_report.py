"""What a fit says of the rig's constants: which rule a parameter, and which are not the user's."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ..constant import BORROWED
from ..rig.rig import shown_difference
from ..units import unit
from ..wording import either, option
from .free_constants import FreeConstantsProblem, Ruling
from .parameters import Parameters
from .uncertainty.blind_directions import percent
from .uncertainty.estimates import Estimate
from .uncertainty.residuals import Residuals

#: A constant is said to rule a parameter where it makes this share of its variance.
RULES = 0.1
#: A parameter in the unit of a constant changes by so much a unit; any other, by so much for this
#: share of the constant.
STEP = 0.1
#: The reason why its interval is wide, where constants make this share of it.
MOST = 0.5


def with_rulings(
    parameters: Parameters, estimates: Sequence[Estimate], rulings: Sequence[Ruling]
) -> tuple[Estimate, ...]:
    """Estimates whose meaning says which constants rule them."""
    result = []
    for q, e in zip(parameters.every, estimates, strict=True):
        name = parameters.tied.get(q.name, q.name)
        ruling = [r for r in rulings if r.parameter == name and r.share >= RULES]
        ruling.sort(key=lambda r: -r.share)
        clauses = [_clause(parameters, r, e.unit) for r in ruling]
        text = f"{e.meaning}; it {', '.join(clauses)}" if clauses and e.meaning else e.meaning
        ruled = e.reason == "wide" and sum(r.share for r in ruling) >= MOST
        result.append(replace(e, meaning=text, reason="constants" if ruled else e.reason))
    return tuple(result)


def _clause(parameters: Parameters, r: Ruling, written: str) -> str:
    rig = parameters.rig
    (param,) = [q for q in parameters.every if q.name == r.parameter]
    (c,) = [c for c in rig.constants if c.name == r.constant]
    alike = c.unit == written or c.value == 0.0
    step = unit(c.unit).factor if alike else STEP * abs(c.value)
    change = float(shown_difference(rig, param, r.slope * step))
    verb = "rises" if change > 0 else "falls"
    amount = f"{abs(change):.2g} {written}".rstrip()
    each = f"each {c.unit or '1'}" if alike else f"{100 * STEP:g} %"
    return f"{verb} {amount} for {each} of {r.constant} ({percent(r.share)} of its variance)"


def borrowed(problem: Residuals) -> list[str]:
    """A sentence that names the constants of somebody else's machine on which a fit rests."""
    if not isinstance(problem, FreeConstantsProblem):
        return []
    foreign = [c for c in problem.constants if c.origin in BORROWED]
    if not foreign:
        return []
    values = ", ".join(
        f"{c.name} = {c.shown:.4g} ± {c.shown_tolerance:.2g} {c.unit}".rstrip() for c in foreign
    )
    stated = option("constants", {"NAME": "VALUE"})
    toleranced = either("NAME=VALUE±TOLERANCE", 'constants={"NAME": (VALUE, TOLERANCE)}')
    sentence = (
        f"constants not of this axis but of the rig's source: {values}; intervals carry these "
        f"tolerances: give your own ({stated}, or {toleranced})"
    )
    return [sentence]
