"""Identification slip by slip: where a log calls for it, and what its slips' breakaway weighs."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ..errors import InputError
from ..optimize.lockstep import Counted
from ..rig.simulated import as_simulated
from ..space import Array
from ..wording import option
from .breakaway_scatter import BreakawayWeights, Scatter, Spread, scatter, spreads
from .known_holds import is_held
from .own_breakaway import BREAKAWAY, breakaway_columns, moved_onsets
from .polish import polish
from .problem import MotionProblem
from .segment import Segment, segments
from .uncertainty.covariance import quick_look
from .uncertainty.linearisation import box_of, linearised

if TYPE_CHECKING:
    from .data_split import DataSplit
    from .parameters import Parameters
    from .uncertainty.profile import Profiles

#: How often weights and onsets are renewed at the best fit, and what its refit may cost for each
#: parameter.
_ROUNDS, _REFIT = 3, 60
#: Least share of the variance of a level that its slips are taken to give.
_LEAST = 0.01
#: Other minima are settled up to this many times the least misfit, and those within this share of
#: each other are one; a round that brings less is the last.
NEARLY, SAME = 2.0, 0.01


def by_slip_where_needed(
    parameters: Parameters, data: DataSplit
) -> tuple[Parameters, Scatter | None]:
    """The parameters with breakaway common or scattered, and the scatter if the log shows one.

    Where a log tells what its controller read, slip by slip is the way to go by that.

    Raises:
        InputError: scattered breakaway is asked for where the slips do not tell it.
    """
    objective = parameters.objective
    scattered = replace(objective, breakaway="scattered")
    common = replace(objective, breakaway="common")
    if objective.breakaway == "common":
        return parameters, None
    rig, law = as_simulated(parameters.rig), parameters.law
    has_level = breakaway_columns(law) is not None
    if objective.by_slip and not has_level:
        raise InputError(
            f"law {law.name} has no breakaway level {BREAKAWAY} of its own, that could differ "
            f"from slip to slip: leave out {option('breakaway', 'scattered')}, or take a stribeck "
            "law"
        )
    slips: list[Segment] = []
    with suppress(InputError):  # without slips there is nothing to ask
        ranges = data.train or (None,)
        slips = [s for r in ranges for s in segments(data.recordings, rig, r, scattered)]
    try:
        observed = scatter(parameters, slips)
    except InputError:
        if objective.by_slip:
            raise
        return replace(parameters, objective=common), None
    if objective.by_slip or (has_level and observed.read):
        return replace(parameters, objective=scattered), observed
    if not observed.evident:
        return replace(parameters, objective=common), None
    return replace(parameters, objective=scattered if has_level else common), observed


def scatter_sentence(parameters: Parameters, seen: Scatter | None) -> list[str]:
    """What a reader is told of slips that are fitted one by one, or should be."""
    if seen is None:
        return []
    sentences = _scattered(parameters, seen) if seen.evident else []
    if seen.read and parameters.objective.by_slip:
        sentences.append(
            f"the force of the log follows its reading: each of {seen.slips} slips is simulated "
            "under the force that the controller held, and J is that of single slips; "
            f"{option('breakaway', 'common')} takes the log for one motion in a loop that sees the "
            "axis without a sensor"
        )
    return sentences


def _scattered(parameters: Parameters, seen: Scatter) -> list[str]:
    fact = f"breakaway scatters by {seen.share:.0%} from slip to slip ({seen.slips} slips)"
    if parameters.objective.by_slip:
        sentence = (
            f"{fact}: each slip has a breakaway of its own, F_S is their mean, and J is that of "
            f"single slips; {option('breakaway', 'common')} has one for all"
        )
    else:
        sentence = f"{fact}: law {parameters.law.name} has no level that could, stribeck has F_S"
    return [sentence]


def settled_slips(
    problem: MotionProblem, starts: Sequence[tuple[Array, float]]
) -> tuple[MotionProblem, Array, int]:
    """The problem with weights and onsets as they are at its best fit, that fit, and rows spent.

    Where slips begin is part of a fit, so that the best one before may not be the best after:
    other minima that are nearly as good are settled, too.

    Args:
        problem: Of slips, with rough weights.
        starts: Good fits, SI, (dim,) each, and their costs, the best first.
    """
    least, costs = starts[0][1], list[float]()
    ends = []
    for x, cost in starts:
        if cost <= NEARLY * least and not any(abs(cost - c) <= SAME * c for c in costs):
            costs.append(cost)
            ends.append(_settled(problem, x))
    settled_problem, x, _ = min(ends, key=lambda end: end[0].noise_of(end[1]))
    return settled_problem, x, sum(end[2] for end in ends)


def _settled(problem: MotionProblem, x: Array) -> tuple[MotionProblem, Array, int]:
    spent, ends = 0, []
    for _ in range(_ROUNDS):
        problem, rows = renewed(problem, x)
        refit = polish(problem, x, None, _REFIT * problem.space.dim)
        x, spent = refit.x, spent + rows + 1 + refit.evaluations
        ends.append((problem.noise_of(x), problem, x))
        if len(ends) > 1 and ends[-1][0] > (1.0 - SAME) * ends[-2][0]:
            break
    _, problem, x = min(ends, key=lambda end: end[0])
    problem, rows = _weighed_at(problem, x)
    return problem, x, spent + rows


def renewed(problem: MotionProblem, x: Array) -> tuple[MotionProblem, int]:
    """The problem with its onsets, its noise and the spreads of its breakaway as a fit has them."""
    parameters = problem.parameters
    p = parameters.full(x[None])[0]
    train = moved_onsets(as_simulated(parameters.rig), parameters.law, p, problem.train)
    assert problem.weights is not None  # noqa: S101 - it has slips
    return _weighed_at(problem.weighed(problem.weights, train), x)


def _weighed_at(problem: MotionProblem, x: Array) -> tuple[MotionProblem, int]:
    """The problem with its noise and the spreads of its breakaway as a fit has them; rows."""
    parameters, weights, train = problem.parameters, problem.weights, problem.train
    assert weights is not None  # noqa: S101 - it has slips
    noise = problem.noise_of(x)
    first = problem.weighed(replace(weights, noise=noise), train)
    counted = Counted(first, 3 * len(x) + 2)
    at = linearised(counted, box_of(first), x)
    look = quick_look(at.J, at.r, first.logs)
    own = spreads(
        parameters,
        parameters.full(x[None])[0],
        train,
        _leverage(at.J, look.curvature, first.samples, len(train)),
    )
    shares = _shares(parameters, look.curvature, at.J, first.samples, train)
    weighed = BreakawayWeights(
        noise,
        {s.parameter: s.sd for s in own},
        {s.parameter: _effective(s.dof, shares.get(s.parameter, 1.0)) for s in own},
        settled=True,
    )
    return problem.weighed(weighed, train), counted.rows + 1


def _shares(
    parameters: Parameters, curvature: Array, J: Array, data: int, slips: Sequence[Segment]
) -> dict[str, float]:
    """The share of the variance of each free parameter that the onsets of slips give.

    None where it is not known what the controller read: an onset is then seen by its motion.

    Args:
        parameters: Rig and law.
        curvature: Pseudo-inverse of that of the misfit, (dim, dim).
        J: Slopes of the residuals, (dim, N).
        data: Rows before those of the breakaways.
        slips: The slips.
    """
    if not all(is_held(s) for s in slips):
        return {}
    names = [q.name for q in parameters.free]
    rows = J[:, data : data + len(slips)]
    given = np.square(curvature[: len(names)] @ rows).sum(axis=1)
    return dict(zip(names, (given / np.diag(curvature)[: len(names)]).tolist(), strict=True))


def _effective(dof: float, share: float) -> float:
    """Degrees of freedom of a level of whose variance slips give a share (Satterthwaite 1946).

    The rest comes from samples, of which there are many.
    """
    return float(dof / max(min(share, 1.0), _LEAST) ** 2)


def fitted_spreads(
    parameters: Parameters, p: Array, slips: Sequence[Segment], profiles: Profiles
) -> tuple[Spread, ...]:
    """How breakaway varies from slip to slip at a fit; nothing if it is common to all.

    Args:
        parameters: Rig and law.
        p: The fit, a complete parameter set, SI, (k,).
        slips: Its slips.
        profiles: Its profiles, by which each slip's share in it is known.
    """
    if not parameters.objective.by_slip:
        return ()
    data = sum(profiles.logs)
    return spreads(
        parameters, p, slips, _leverage(profiles.J, profiles.quick.curvature, data, len(slips))
    )


def _leverage(J: Array, curvature: Array, data: int, slips: int) -> Array:
    """Leverage of the `slips` rows after the first `data` rows, of slopes J (dim, N), (slips,)."""
    rows = J[:, data : data + slips]
    leverage: Array = np.clip(np.einsum("im,ij,jm->m", rows, curvature, rows), 0.0, 1.0)
    return leverage
