"""What a fit says of the rig's constants: which rule a parameter, and which are not the user's."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations

from ..constant import BORROWED
from ..rig.rig import shown_difference
from ..units import percent, unit
from ..wording import either, option
from .exact_constants import NOT_APART
from .free_constants import FreeConstantsProblem, Ruling
from .parameters import Parameters
from .uncertainty.estimates import Estimate
from .uncertainty.residuals import Residuals

#: A constant is said to rule a parameter where it makes this share of its variance.
RULES = 0.1
#: A parameter in the unit of a constant changes by so much a unit; any other, by so much for this
#: share of the constant.
STEP = 0.1
#: The reason why its interval is wide, where constants make this share of it.
MOST = 0.5
#: From this correlation on the data tell two constants only together; and shares of a variance that
#: add up to more are not of constants that are apart.
TOGETHER, SUM = 0.5, 1.01


def with_rulings(
    parameters: Parameters, estimates: Sequence[Estimate], rulings: Sequence[Ruling]
) -> tuple[Estimate, ...]:
    """Estimates whose meaning says which constants rule them.

    Constants that the data tell only together have slopes and shares along their common direction,
    which are those of none of them by itself: they are named without, and `exact_constants` says
    what each of them does.
    """
    joint = _told_together(rulings)
    result = []
    for q, e in zip(parameters.every, estimates, strict=True):
        name = parameters.tied.get(q.name, q.name)
        ruling = [r for r in rulings if r.parameter == name and r.share >= RULES]
        ruling.sort(key=lambda r: -r.share)
        names = {r.constant for r in ruling}
        together = {c for pair in joint if pair <= names for c in pair}
        if sum(r.share for r in ruling) > SUM:  # only what depends on each other shares so much
            together = names
        alone = [r for r in ruling if r.constant not in together]
        clauses = [_clause(parameters, r, e.unit) for r in alone]
        if together:
            listed = " and ".join(r.constant for r in ruling if r.constant in together)
            clauses.append(f"goes with {listed}, {NOT_APART}")
        text = f"{e.meaning}; it {', '.join(clauses)}" if clauses and e.meaning else e.meaning
        most = max((r.share for r in ruling if r.constant in together), default=0.0)
        ruled = e.reason == "wide" and most + sum(r.share for r in alone) >= MOST
        result.append(replace(e, meaning=text, reason="constants" if ruled else e.reason))
    return tuple(result)


def _told_together(rulings: Sequence[Ruling]) -> frozenset[frozenset[str]]:
    """Pairs of constants whose correlation, with the data, is above `TOGETHER` at the least.

    Two that make the shares a and b of the variance of one parameter have a correlation of at
    least sqrt(a b) - sqrt((1 - a) (1 - b)).
    """
    by_parameter: dict[str, list[Ruling]] = {}
    for r in rulings:
        by_parameter.setdefault(r.parameter, []).append(r)
    return frozenset(
        frozenset({r.constant, s.constant})
        for of_one in by_parameter.values()
        for r, s in combinations(of_one, 2)
        if math.sqrt(r.share * s.share) - math.sqrt(max((1 - r.share) * (1 - s.share), 0.0))
        > TOGETHER
    )


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
