"""Periods and orders of ripple, as the forces show them that a fit leaves over.

A wave over the position fits its neighbours worse and worse and then better again, so that J has a
minimum wherever so many waves more or less fit on the travel. The residual forces are linear in the
wave's amplitudes: at each order on a grid their squares that it takes, with small changes of the
other parameters, are solved for, and the search goes on from the orders that take most.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ..rig.composed import ComposedRig
from ..rig.parts.axis_of_parts import completed
from .adequacy.equation_error import equation_error
from .nested_answers import descended
from .refinement import Refined

if TYPE_CHECKING:
    from ..rig.parts import Part
    from ..space import Array
    from .adequacy.residual_rows import ResidualRows
    from .problem import MotionProblem

#: Places on the grid for one wave more on the travel, how many there are at most, and how many of
#: the orders that take most the search goes on from.
FINE, MOST, STARTS = 8, 8_000, 6


def ripple_orders(problem: MotionProblem, best: Refined) -> Refined:
    """The best of the descents from the orders of ripple that forces show, and of an answer.

    Args:
        problem: Its J is minimised.
        best: The answer so far.
    """
    rig, names = problem.parameters.rig, problem.space.names
    if not isinstance(rig, ComposedRig) or problem.weights is not None:
        return best
    for part in rig.parts:
        if part.wave is None or not set(part.wave) <= set(names):
            continue
        places = [names.index(name) for name in part.wave]
        flat = best.x.copy()
        flat[places[1:]] = 0.0
        rows = equation_error(
            problem.parameters, problem.parameters.full(flat[None])[0], problem.train
        )
        starts = [] if rows is None else _starts(problem, part, places, flat, rows)
        if starts:
            end = descended(problem, starts)
            spent = best.evaluations + end.evaluations
            best = replace(end if end.cost < best.cost else best, evaluations=spent)
    return best


def _starts(
    problem: MotionProblem, part: Part, places: list[int], flat: Array, rows: ResidualRows
) -> list[Array]:
    """Points with the orders that take most of the squares of the residual forces, SI, (dim,).

    Args:
        problem: Whose parameters they are.
        part: The ripple.
        places: Of its order, its cosine and its sine among the free parameters.
        flat: The point without the ripple.
        rows: The forces that it leaves over.
    """
    params, parameters = problem.space.params, problem.parameters
    order = params[places[0]]
    known = {c.name: c.value for c in parameters.rig.constants}
    values = known | parameters.values(parameters.full(flat[None])[0])
    others = np.delete(rows.jacobian, places, axis=1)
    Q, _ = np.linalg.qr(others[:, np.abs(others).max(axis=0) > 0.0])
    left = rows.residual - Q @ (Q.T @ rows.residual)

    def constants(at: float) -> Any:
        unit = dict.fromkeys(part.wave[1:], 1.0) if part.wave else {}
        return part.constants(_of_axis(problem, values | unit | {order.name: at}))

    slow, fast = sorted(float(constants(at)[0]) for at in (order.lower, order.upper))
    step = 2.0 * np.pi / (FINE * max(float(np.ptp(rows.position)), 1e-300))
    turns = np.linspace(slow, fast, int(np.clip((fast - slow) / step, 2, MOST)))
    # An order or a period: the angle for a unit of position goes with it, or with its inverse.
    inverse = constants(order.lower)[0] > constants(order.upper)[0]
    scale = float(constants(order.upper)[0]) * (order.upper if inverse else 1.0 / order.upper)
    amplitudes, taken = np.empty((len(turns), 2)), np.empty(len(turns))
    for i, turn in enumerate(turns):
        wave = np.column_stack([np.cos(turn * rows.position), np.sin(turn * rows.position)])
        wave -= Q @ (Q.T @ wave)
        amplitudes[i] = np.linalg.lstsq(wave, left, rcond=None)[0]
        taken[i] = float(left @ (wave @ amplitudes[i]))
    padded = np.concatenate([[-np.inf], taken, [-np.inf]])
    peaks = np.flatnonzero((padded[1:-1] >= padded[:-2]) & (padded[1:-1] >= padded[2:]))
    chosen = peaks[np.argsort(-taken[peaks], kind="stable")[:STARTS]]
    points = []
    for i in chosen:
        point = flat.copy()
        point[places[0]] = np.clip(
            scale / turns[i] if inverse else turns[i] / scale, order.lower, order.upper
        )
        point[places[1:]] = amplitudes[i] / np.array(constants(point[places[0]])[1:3])
        lower, upper = (
            [getattr(q, end) for q in problem.space.params] for end in ("lower", "upper")
        )
        points.append(np.clip(point, lower, upper))
    return points


def _of_axis(problem: MotionProblem, values: dict[str, float]) -> dict[str, Any]:
    """The values of all parts of its rig."""
    rig = problem.parameters.rig
    assert isinstance(rig, ComposedRig)  # noqa: S101 - the caller's
    return completed(rig.parts, values)
