"""What a delay of the measured motion means for estimates, and what is told of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from ..rig.rig import shown_difference
from ..space import Param
from ..wording import either, option
from .conditions import Violation
from .initial_state import FreeStartProblem
from .moved_estimates import refit_text
from .segment import recordings_of
from .uncertainty.covariance import HALF_WIDTH
from .uncertainty.verdict import IDENTIFIED

if TYPE_CHECKING:
    from .combinations import Combination
    from .motion_delay import MotionDelay
    from .parameters import Parameters
    from .polish import Polished
    from .problem import MotionProblem
    from .uncertainty.estimates import Estimate

#: A delay beyond this share of the reach is at its edge.
EDGE = 0.98
#: An interval is widened for the delay where that makes its half-width so much larger, and that is
#: told where the half-width is then above this share of the value.
WIDER, MATERIAL = 1.1, 0.01
#: Where nothing is said of a delay and the log does not show it, it is told what moves out of its
#: interval within so many of its standard deviations: ten samples.
BEYOND = 20.0

#: A parameter, or its sum with a constant.
Known = TypeVar("Known", "Estimate", "Combination")


@dataclass(frozen=True)
class _DelayedEstimate:
    """An estimate, or its sum with a constant, that a delay moves.

    Args:
        name: As its rig calls it.
        param: The parameter.
        slope: By how much it rises for each second, SI.
        half_width: Of its interval, SI.
    """

    name: str
    param: Param
    slope: float
    half_width: float


def with_delay(
    problem: MotionProblem | FreeStartProblem,
    estimates: Sequence[Estimate],
    sums: Sequence[Combination],
    delay: MotionDelay | None,
) -> tuple[tuple[Estimate, ...], tuple[Combination, ...], list[Violation]]:
    """Estimates and sums whose intervals hold what a delay may be, and what is told of it.

    A delay that takes away most of the misfit is told with what it biases, which no interval holds.

    Args:
        problem: The problem solved.
        estimates: As in `parameters.every`.
        sums: Of a parameter and a constant.
        delay: As the fit shows it; None where it cannot.
    """
    if isinstance(problem, FreeStartProblem):
        problem = problem.problem
    if delay is None or (delay.refit is None and not delay.known):
        return tuple(estimates), tuple(sums), []
    if delay.refit is not None:
        told = [_violation(problem, estimates, delay, delay.refit)]
        return tuple(estimates), tuple(sums), told
    parameters = problem.parameters
    slopes = _slopes(parameters, delay)
    moved: list[_DelayedEstimate] = []
    judged = []
    for q, e in zip(parameters.every, estimates, strict=True):
        slope = slopes.get(q.name, 0.0)
        low, high = _interval(e, delay, slope)
        held = _holding(e, max(low, min(q.lower, e.low)), min(high, max(q.upper, e.high)))
        judged.append(held)
        moved += _moved(delay, e.name, q, slope, (e, held))
    added = []
    params = {q.name: q for q in parameters.every}
    for c in sums:
        slope, q = slopes.get(c.parameter, 0.0), params[c.parameter]
        total = _holding(c, *_interval(c, delay, slope))
        added.append(total)
        name = f"{parameters.rig.label(q.name)} + {c.constant}"
        moved += _moved(delay, name, q, slope, (c, total))
    told = [Violation("data", _sentence(problem, delay, moved), frozenset(), caps=False)]
    return tuple(judged), tuple(added), told if moved else []


def _slopes(parameters: Parameters, delay: MotionDelay) -> dict[str, float]:
    """By how much parameters rise for each second, SI, by name; those that are tied, too."""
    free = {q.name: float(s) for q, s in zip(parameters.free, delay.slopes, strict=True)}
    sources = {q.name: parameters.tied.get(q.name, q.name) for q in parameters.every}
    return {name: free[source] for name, source in sources.items() if source in free}


def _interval(e: Estimate | Combination, delay: MotionDelay, slope: float) -> tuple[float, float]:
    """The interval of an estimate with the delays that there may be."""
    shift, spread = slope * delay.shift, HALF_WIDTH * abs(slope) * delay.spread
    low = e.value - float(np.hypot(e.value - e.low, spread)) + min(shift, 0.0)
    high = e.value + float(np.hypot(e.high - e.value, spread)) + max(shift, 0.0)
    return low, high


def _holding(e: Known, low: float, high: float) -> Known:
    """An estimate with a wider interval, where it is one and material."""
    if e.verdict in ("fixed", "not identifiable"):
        return e
    before, after = (max(e.value - a, b - e.value) for a, b in ((e.low, e.high), (low, high)))
    if after <= WIDER * before:
        return e
    if after > IDENTIFIED * abs(e.value) and e.verdict == "identified":
        return replace(e, low=low, high=high, verdict="weak", reason="wide")
    return replace(e, low=low, high=high)


def _moved(
    delay: MotionDelay, name: str, q: Param, slope: float, estimates: tuple[Known, Known]
) -> list[_DelayedEstimate]:
    """An estimate, before and after, if it is told what a delay does to it; else none."""
    before, after = estimates
    half = 0.5 * (after.high - after.low)
    if delay.shown or delay.said:
        told = after is not before and half > MATERIAL * abs(after.value)
    else:
        told = half < abs(slope) * BEYOND * delay.known
    return (
        [_DelayedEstimate(name, q, slope, half)] if told and before.verdict == "identified" else []
    )


# --- in words -------------------------------------------------------------------------------------


def _sentence(problem: MotionProblem, delay: MotionDelay, moved: Sequence[_DelayedEstimate]) -> str:
    source = "was said" if delay.said else "is assumed (a sample)"
    prior = f"0 ± {2e3 * delay.known:.3g} ms {source}"
    changes = ", ".join(_change(problem, m) for m in moved)
    logs = "log" if len(recordings_of(problem.train)) == 1 else "logs"
    later = f"later than its {_drive(problem)}"
    if delay.shown:
        shows = f"{1e3 * delay.seconds:.2g} ± {1e3 * HALF_WIDTH * delay.error:.2g} ms"
        return (
            f"by the {logs} the motion was recorded {shows} {later}, {prior} beforehand, and "
            f"intervals hold that: {changes} for each ms: {_advice()}"
        )
    soonest = 1e3 * min((m.half_width / abs(m.slope) for m in moved), default=0.0)
    return (
        f"the {logs} cannot show how much {later} the motion was recorded, {prior}: {changes} for "
        f"each ms, and {float(f'{soonest:.2g}'):g} ms would be beyond an interval: {_advice()}"
    )


def _advice() -> str:
    """How a delay is said, and its sign."""
    said = either("--delay MS or MS±TOLERANCE", "delay=SECONDS or (SECONDS, TOLERANCE)")
    return f"{said} says it, 0 for none, below 0 where the motion is late"


def _change(problem: MotionProblem, m: _DelayedEstimate) -> str:
    rig = problem.parameters.rig
    change = float(shown_difference(rig, m.param, 1e-3 * m.slope))
    verb = "rises" if change > 0 else "falls"
    return f"{m.name} {verb} {abs(change):.2g} {rig.unit_of(m.param)}".rstrip()


def _drive(problem: MotionProblem) -> str:
    return "force" if problem.parameters.rig.applied_force else "command"


def _violation(
    problem: MotionProblem, judged: Sequence[Estimate], delay: MotionDelay, refit: Polished
) -> Violation:
    """The delay that takes away most of a misfit, with what it biases."""
    seconds = float(refit.x[-1])
    changes, moved = refit_text(problem, judged, refit, delay.misfit)
    at_least = "at least " if abs(seconds) > EDGE * delay.reach else ""
    side = "behind" if seconds > 0 else "ahead of"
    sentence = (
        f"the motion was measured {at_least}{1e3 * abs(seconds):.3g} ms {side} its "
        f"{_drive(problem)}: {changes}: {option('delay', float(f'{-seconds:.3g}'))} moves it back"
    )
    return Violation("data", sentence, caps=moved)  # a refit close by moves less than a fit
