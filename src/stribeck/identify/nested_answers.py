"""Answers of the laws that a law contains, as places from which its own search may start.

A law that contains another one explains the data at least as well, so it may never end above it.
A search in few dimensions is quick and finds its minimum as a rule; the answer is then a point of
the richer law's space, from which descents go on.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ..errors import InputError
from ..friction import Law, law_named
from ..optimize.lockstep import Counted
from ..optimize.slopes import MOST_FANS
from ..space import Array, Param
from .parameters import Parameters
from .polish import best_descent
from .problem import MotionProblem
from .refinement import MANY, Refined, turned
from .selection.nesting import carried, ingredients, synonym
from .uncertainty.linearisation import box_of, linearised

#: How many of the answers are refined, the best first.
STARTS = 2
#: Evaluations a parameter of one descent, and after how many only the best of all go on.
DESCENT, FIRST = 25, 8
#: A parameter does not matter where its slopes are below this share of the steepest ones; descents
#: then begin with it at these places of its search range, too.
BLIND, PLACES = 1e-9, (0.15, 0.45, 0.75)

#: Searches a problem of a law that contains no other: its answer.
Solve = Callable[[MotionProblem], Refined]
#: Answers of laws over their ranges, SI, (dim,).
Answers = dict[tuple[str, tuple[Param, ...]], Array]


def contained(parameters: Parameters) -> list[Parameters]:
    """The laws of the rig that a law contains, with its own ranges and values, simplest first.

    Those with a part of its ingredients, one for each part; a law with a free exponent stands for
    the one without. Whether the richer law is ever equal to them shows at the points themselves.
    """
    law, own = parameters.law, _ingredients(parameters)
    chosen: dict[frozenset[str], Parameters] = {}
    for name in parameters.rig.laws:
        simple = law_named(name)
        if simple.name == law.name or (simple.states > 0) != (law.states > 0):
            continue
        try:
            nested = _restricted(parameters, simple)
        except InputError:  # nothing would be left to find
            continue
        if len(nested.free) < len(parameters.free) and (has := _ingredients(nested)) < own:
            chosen.setdefault(has, nested)
    coarse = {has - {"exponent"} for has in chosen if "exponent" in has}
    left = [nested for has, nested in chosen.items() if has not in coarse - {frozenset()}]
    limit = rigid_limit(parameters)
    if limit is not None and not law.states:  # not contained, but as near as it likes to be
        left.append(limit)
    return sorted(left, key=lambda nested: len(nested.free))


def is_rich(problem: MotionProblem) -> bool:
    """Whether a problem has many parameters, and a law that contains others.

    Few evaluations for each of them lead from the answers of these to places that a search of the
    whole box meets by luck. (Of four repeats for bam-m6 on the XL330's logs, of 2,600 evaluations
    each, one ended at 44.3 mrad, the others at 66 to 98; descents from contained laws, 8,000 with
    those that led to these, ended at 42.6 and 44.0.)
    """
    return problem.space.dim >= MANY and bool(contained(problem.parameters))


def nested_answers(
    problem: MotionProblem, solve: Solve, met: Answers | None = None
) -> tuple[list[Array], int]:
    """The answers of the laws that a problem's law contains, as points of its space, SI, (dim,).

    And the evaluations spent. Laws that contain others among them start from these.

    Args:
        problem: The richer law's.
        solve: Searches the laws that contain no other.
        met: Answers that are known, on the same samples; others are added.
    """
    answers: list[tuple[Parameters, Array]] = []
    met = {} if met is None else met
    spent = 0
    for parameters in contained(problem.parameters):
        law = (parameters.law.name, parameters.free)
        if law not in met:
            simple = MotionProblem(parameters, problem.train)
            starts = [
                point
                for p, x in answers
                if _ingredients(p) < _ingredients(parameters)
                for point in carried(p, p.full(x[None])[0], parameters)
            ]
            answer = solve(simple) if not starts else descended(simple, starts)
            spent += answer.evaluations
            met[law] = answer.x
        answers.append((parameters, met[law]))
    rich = problem.parameters
    return [point for p, x in answers for point in carried(p, p.full(x[None])[0], rich)], spent


def richest(parameters: Parameters) -> Parameters | None:
    """The contained law of the most parameters, where these are many; None if there is none.

    In fewer dimensions a search on some of the samples finds the minimum as a rule.
    """
    many = [nested for nested in contained(parameters) if len(nested.free) >= MANY]
    return many[-1] if many else None


def rigid_limit(parameters: Parameters) -> Parameters | None:
    """The law that a law approaches as it rises from rest more steeply, on the same rig.

    With what both have as it is there; None where there is none, or nothing of it to be found.
    """
    limit = parameters.law.rigid_limit
    if limit is None:
        return None
    try:
        return _restricted(parameters, limit.law)
    except InputError:
        return None


def descended(problem: MotionProblem, starts: list[Array]) -> Refined:
    """The best minimum below some points, SI: descents from the best of them."""
    costs = problem(np.array(starts))
    order = [int(k) for k in np.argsort(costs, kind="stable")[:STARTS] if np.isfinite(costs[k])]
    if not order:
        return Refined(starts[0], np.inf, len(starts))
    allowance = DESCENT * problem.space.dim
    same, spent = _of_the_same_cost(problem, starts[order[0]])
    places = np.array([*same, *(starts[k] for k in order)])
    best = best_descent(problem, places, ((len(places), FIRST), (STARTS, DESCENT - FIRST)))
    spent += len(starts) + best.evaluations
    return turned(problem, best.x, best.cost, allowance, spent)


def _of_the_same_cost(problem: MotionProblem, x: Array) -> tuple[list[Array], int]:
    """Points, SI, that differ from one in parameters that do not matter there; and the rows.

    A drop of friction that is nil has no speed; once it grows, it matters where it lies, and a
    descent that begins with the wrong speed leaves it nil.
    """
    box = box_of(problem)
    counted = Counted(problem, 1 + MOST_FANS * (box.dim + 1))
    try:
        at = linearised(counted, box, x)
    except InputError:
        return [], counted.rows
    sizes = np.abs(at.J).max(axis=1)
    blind = sizes <= BLIND * sizes.max()
    points = []
    for place in PLACES if blind.any() else ():
        u = at.u.copy()
        u[blind] = place
        points.append(box.x(u))
    return points, counted.rows


def _ingredients(parameters: Parameters) -> frozenset[str]:
    return ingredients(parameters.law, (q.name for q in parameters.free))


def _restricted(rich: Parameters, law: Law) -> Parameters:
    """A simpler law on the same rig, with the ranges and values of what both have."""
    named = {synonym(q.name): q for q in rich.every}

    def own(q: Param) -> Param:
        same = named.get(synonym(q.name))
        if same is None or same.unit != q.unit:
            return q
        fixed = rich.fixed.get(same.name)
        return replace(q, lower=same.lower, upper=same.upper, log=same.log, fixed=fixed)

    every = tuple(own(q) for q in rich.rig.parameters(law))
    names = {q.name for q in every}
    tied = {a: b for a, b in rich.tied.items() if {a, b} <= names}
    declared = Parameters.declared(rich.rig, law, every, tied)
    return replace(declared, objective=rich.objective, bounded=rich.bounded)
