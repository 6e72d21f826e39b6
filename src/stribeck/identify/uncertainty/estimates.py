"""Estimates: each parameter with value, interval, verdict and meaning in words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Literal

import numpy as np

from ...rig.rig import shown_in, stem
from ...space import Array, Param, Space
from ..parameters import AT_END
from .profile import Profile
from .profile_walk import Ended
from .residuals import Residuals, orders_of
from .sensitivity import distinct, sentence
from .verdict import ALL_OVER, IDENTIFIED, Reason, Verdict, share_of_range, verdict

if TYPE_CHECKING:
    from ..parameters import Parameters
    from .assessment import Uncertainty

#: Correlation above which the data know a combination of two parameters rather than each.
TOGETHER = 0.95
#: A verdict that rests on the width of an interval is borderline where that is within this factor
#: of the limit: the width of 95 % intervals differs so much from one recording to the next.
BORDERLINE = 1.25
#: Reasons of a verdict that no width changes.
UNMOVED = ("rests on another", "guessed")
#: Parameters that say at which speed friction drops from F_S to F_C.
_PLACES_OF_A_DROP = frozenset({"v_s", "v_SS"})


@dataclass(frozen=True)
class Estimate:
    """One parameter as it was found, SI.

    Args:
        name: As its rig calls it.
        value: The estimate.
        standard_error: From the slopes at the estimate, for residuals as correlated as they
            are; by force balance the literature's, as if they were white. nan for a fixed
            parameter.
        spread: Standard deviation over the repeats that fit as well; nan with fewer than two.
        low: Lower end of the profile's 95 % interval, within the search range.
        high: Upper end.
        at_bound: Which end of its search range it sits at, if any.
        verdict: `identified` if the data set both ends within 10 % of the value. `not
            identifiable` if other recordings of the same kind would give values all over the
            range: the interval takes two thirds of it, or the data end it on neither side; or
            if it rests on another parameter that it may not pass. `weak` otherwise, and at best
            where a condition of the fit does not hold; see `conditions`.
        unit: In which people see it.
        reason: Why it is not identified; empty if it is, or was fixed.
        low_ended: Why the interval ends there, see `IntervalEnd`; None for a fixed parameter.
        high_ended: The same for the upper end.
        meaning: What the parameter does to the fit and what ends its interval, a sentence.
        resampled: The bootstrap's 95 % interval, if it was asked for.
        searched: The parameter with its search range; None for a fixed one.
    """

    name: str
    value: float
    standard_error: float
    spread: float
    low: float
    high: float
    at_bound: Literal["lower", "upper"] | None
    verdict: Verdict
    unit: str
    reason: Reason = ""
    low_ended: Ended | None = None
    high_ended: Ended | None = None
    meaning: str = ""
    resampled: tuple[float, float] | None = None
    searched: Param | None = None

    @property
    def borderline(self) -> bool:
        """Whether the next recording of the same kind may well have the other verdict."""
        if self.verdict == "identified" or (self.verdict == "weak" and self.reason == "wide"):
            width = max(self.value - self.low, self.high - self.value)
            if _near(width, IDENTIFIED * abs(self.value)):
                return True
        if self.searched is None or self.verdict == "identified" or self.reason in UNMOVED:
            return False
        return _near(share_of_range(self.low, self.high, self.searched), ALL_OVER)


def _near(width: float, limit: float) -> bool:
    return limit / BORDERLINE < width < limit * BORDERLINE


def estimates(
    parameters: Parameters,
    p: Array,
    uncertain: Uncertainty,
    spread: Array | None = None,
    *,
    errors: Array | None = None,
    ends: Mapping[str, str] | None = None,
    resting: Mapping[str, str] = MappingProxyType({}),
    misfit: str = "J",
) -> tuple[Estimate, ...]:
    """Every parameter with its interval, its bound and a verdict, as in `parameters.every`.

    Args:
        parameters: Which parameters were free.
        p: The complete parameter set, SI, (k,).
        uncertain: How well the free ones are known; they come first in its problem.
        spread: Their standard deviations over repeats, SI, nan where there are none, (dim,).
        errors: Standard errors to be shown in place of those of `uncertain`, SI, (dim,).
        ends: Which end of its range a parameter sits at, by name, if that is known; else what
            lies within a thousandth of a range of its end, and is not held off it by the data,
            counts as sitting there.
        resting: On which other parameter one rests, by name: the law's order forbids it to pass,
            as F_S may not fall below F_C. Then nothing in the data asks for a difference.
        misfit: What the root mean square of the residuals is called.
    """
    free = {q.name: i for i, q in enumerate(parameters.free)}
    by_name = uncertain.by_name()
    misfit = distinct(misfit, [parameters.rig.label(q.name) for q in parameters.every])
    drawn = uncertain.bootstrap
    result = []
    for param, value in zip(parameters.every, p.tolist(), strict=True):
        label, written = parameters.rig.label(param.name), parameters.rig.unit_of(param)
        source = parameters.tied.get(param.name, param.name)
        i = free.get(source)
        if i is None:
            nan = float("nan")
            result.append(Estimate(label, value, nan, nan, value, value, None, "fixed", written))
            continue
        profile, effect = by_name[source]
        judged: tuple[Verdict, Reason] = ("not identifiable", "rests on another")
        if source not in resting:
            judged = verdict(profile, parameters.free[i])
        at = _stopped(value, param, profile) if ends is None else _named(ends, param.name)

        def show(x: float, q: Param = param, written: str = written) -> str:
            return f"{float(shown_in(parameters.rig, q, x)):.4g} {written}".rstrip()

        result.append(
            Estimate(
                label,
                value,
                float((uncertain.errors if errors is None else errors)[i]),
                float("nan") if spread is None else float(spread[i]),
                profile.low.end,
                profile.high.end,
                at,
                judged[0],
                written,
                judged[1],
                profile.low.ended,
                profile.high.ended,
                _rests(label, parameters.rig.label(resting[source]))
                if source in resting
                else sentence(label, profile, effect, show, misfit),
                None if drawn is None else (float(drawn.low[i]), float(drawn.high[i])),
                parameters.free[i],
            )
        )
    return tuple(result)


def _rests(name: str, other: str) -> str:
    return f"{name} rests on {other}: nothing in the data asks for a difference between the two"


def resting(problem: Residuals, x: Array) -> dict[str, str]:
    """Which parameters rest on which others at a fit, SI, (dim,): the orders that hold it."""
    names, width = problem.space.names, problem.space.upper - problem.space.lower
    return {
        names[i]: names[j]
        for i, j in orders_of(problem)
        if x[i] - x[j] <= AT_END * AT_END * max(width[i], width[j])
    }


def _named(ends: Mapping[str, str], name: str) -> Literal["lower", "upper"] | None:
    at = ends.get(name)
    return None if at is None else ("lower" if at == "lower" else "upper")


def range_end(value: float, param: Param) -> Literal["lower", "upper"] | None:
    """Which end of its search range a value sits at, in the scale in which it is searched."""
    place = float(Space((param,)).encode(np.array([[value]]))[0, 0])
    if place < AT_END:
        return "lower"
    return "upper" if place > 1.0 - AT_END else None


def _stopped(value: float, param: Param, profile: Profile) -> Literal["lower", "upper"] | None:
    """Which end of its search range stops a value, if one does.

    One that the data hold off the end is not stopped by it, however near it is: a default range is
    wide enough for a press.
    """
    at = range_end(value, param)
    side = profile.low if at == "lower" else profile.high
    return None if side.ended == "threshold" else at


def bound_warnings(estimates: Sequence[Estimate]) -> list[str]:
    """A sentence for every parameter that ended at an end of its search range."""
    return [
        f"{e.name} ended at 0, the least that it may be: the data would have it negative, so doubt "
        "the value, or the law"
        if e.at_bound == "lower" and e.value == 0.0
        else f"{e.name} ended at the {e.at_bound} end of its range: widen the range or doubt the "
        "value"
        for e in estimates
        if e.at_bound
    ]


def without_partners(
    parameters: Parameters, estimates: Sequence[Estimate], correlation: Array
) -> tuple[Estimate, ...]:
    """Estimates of which none is identified that the data know only together with another one.

    Args:
        parameters: Theirs.
        estimates: As in `parameters.every`.
        correlation: Of the free ones, (dim, dim).
    """
    verdicts = {q.name: e.verdict for q, e in zip(parameters.every, estimates, strict=True)}
    unknown = [verdicts[q.name] == "not identifiable" for q in parameters.free]
    together = (np.abs(correlation) > TOGETHER) & np.array(unknown)
    at = {q.name: i for i, q in enumerate(parameters.free)}
    result = []
    for q, e in zip(parameters.every, estimates, strict=True):
        i = at.get(parameters.tied.get(q.name, q.name))
        if e.verdict == "identified" and i is not None and together[i].any():
            result.append(replace(e, verdict="weak", reason="rests on another"))
        else:
            result.append(e)
    return tuple(result)


def without_levels_of_an_unseen_drop(
    parameters: Parameters, estimates: Sequence[Estimate]
) -> tuple[Estimate, ...]:
    """Estimates of which the level after a drop is not identified if that may be below all speeds.

    Bristles give way gradually, so that a log without a drop shows one level: that after a drop
    below its speeds, or that before one above them. A search ends in one of the two; the other
    costs as much, and there the level that was named is anywhere.

    Args:
        parameters: Theirs.
        estimates: As in `parameters.every`.
    """
    if not parameters.law.states:
        return tuple(estimates)
    places = [
        e
        for q, e in zip(parameters.every, estimates, strict=True)
        if q.name in _PLACES_OF_A_DROP and e.verdict != "fixed"
    ]
    open_ends = {
        level: e.name
        for e in places
        for ended, level in ((e.low_ended, "F_C"), (e.high_ended, "F_S"))
        if ended in ("bound", "flat")
    }
    result = []
    for q, e in zip(parameters.every, estimates, strict=True):
        place = open_ends.get(stem(q.name))
        if place is not None and e.verdict == "identified":
            meaning = (
                f"{e.meaning}; {place} may be at an end of its range, and the one level that the "
                "log shows may as well be the other of F_S and F_C"
            )
            result.append(replace(e, verdict="weak", reason="rests on another", meaning=meaning))
        else:
            result.append(e)
    return tuple(result)


def correlation_warnings(parameters: Parameters, correlation: Array) -> list[str]:
    """A sentence for the parameters that the data cannot tell apart."""
    names = [parameters.rig.label(q.name) for q in parameters.free]
    pairs = [
        f"{names[i]} and {names[j]} ({correlation[i, j]:+.3f})"
        for i in range(len(names))
        for j in range(i)
        if abs(correlation[i, j]) > TOGETHER
    ]
    if not pairs:
        return []
    return [f"the data hardly tell apart {', '.join(pairs)}: trust their combination, not each"]
