"""How well the data know each parameter: interval, verdict and meaning, whatever road found it.

Verdicts come from the profile likelihood (`profile`), which moves all parameters: that two of
them go together widens both their intervals, and needs no rule of its own.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Literal

import numpy as np

from ...data.repeated_samples import is_new
from ...data.segmentation import rests
from ...rig.rig import shown_in
from ...space import Array, Param
from .blind_directions import Direction, directions
from .bootstrap import Bootstrap, bootstrap
from .covariance import correlation_time, quick_look
from .descent import Meter, Terrain
from .profile import BUDGET, Ended, Profile, Profiles, profiles, start
from .residuals import Residuals, logs_of, orders_of
from .sensitivity import Weight, half_widths, sentence, share_of_range, weights

if TYPE_CHECKING:
    from ...data.recording import Recording
    from ..parameters import Parameters

__all__ = [
    "Estimate",
    "Uncertainty",
    "bound_warnings",
    "correlation_time",
    "correlation_warnings",
    "estimates",
    "rest_noise",
    "standard_errors",
    "uncertainty",
]

Verdict = Literal["identified", "weak", "not identifiable", "fixed"]

#: Half-width of an interval as a share of the value, up to which a parameter is identified.
IDENTIFIED = 0.1
#: Share of the search range, in the search scale, from which an interval says nothing: nine in ten
#: estimates of other recordings would spread over 1.645 / 1.96 of it, which is most of the range.
ALL_OVER = 2 / 3
#: Correlation above which the data know a combination of two parameters rather than each.
TOGETHER = 0.95
#: Share of the search range within which a parameter counts as sitting at its end.
AT_END = 1e-3
#: An improvement of the misfit below this share is not told.
TOLD = 1e-3
#: Samples of a rest below which it says nothing of the noise, and what is cut off its ends.
FEWEST, CUT = 12, 0.1


@dataclass(frozen=True)
class Estimate:
    """One parameter as it was found, SI.

    Args:
        name: As its rig calls it.
        value: The estimate.
        standard_error: From the slopes at the estimate, for residuals as correlated as they
            are; on the inverse road the literature's, as if they were white. nan for a fixed
            parameter.
        spread: Standard deviation over the repeats that fit as well; nan with fewer than two.
        low: Lower end of the profile's 95 % interval, within the search range.
        high: Upper end.
        at_bound: Which end of its search range it sits at, if any.
        verdict: `identified` if the data set both ends within 10 % of the value. `not
            identifiable` if other recordings of the same kind would give values all over the
            range: the interval takes two thirds of it, or the data end it on neither side; or
            if it rests on another parameter that it may not pass. `weak` otherwise, and at best
            where the model as a whole explains little.
        unit: In which people see it.
        low_ended: Why the interval ends there, see `Side`; None for a fixed parameter.
        high_ended: The same for the upper end.
        meaning: What the parameter does to the fit and what ends its interval, a sentence.
        resampled: The bootstrap's 95 % interval, if it was asked for.
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
    low_ended: Ended | None = None
    high_ended: Ended | None = None
    meaning: str = ""
    resampled: tuple[float, float] | None = None


@dataclass(frozen=True, eq=False)
class Uncertainty:
    """All that is known about how well a fit is known.

    Args:
        x: The fit, SI, (dim,): a better one than was given, if the profiles met one.
        profiles: Of the parameters asked about.
        weights: What setting each elsewhere does to the fit.
        directions: Joint moves that the data do not notice.
        errors: Standard errors of all parameters, SI, (dim,).
        correlation: Of all parameters, (dim, dim).
        bootstrap: Refits of drawn data, if asked for.
        rows: Rows evaluated.
    """

    x: Array
    profiles: Profiles
    weights: tuple[Weight, ...]
    directions: tuple[Direction, ...]
    errors: Array
    correlation: Array
    bootstrap: Bootstrap | None
    rows: int

    def by_name(self) -> dict[str, tuple[Profile, Weight]]:
        """Profile and weight of each parameter asked about."""
        pairs = zip(self.profiles.profiles, self.weights, strict=True)
        return {p.name: (p, w) for p, w in pairs}

    def notes(self, parameters: Parameters, misfit: str = "J") -> list[str]:
        """What a reader must know, a sentence each."""
        said = []
        squares, before = self.profiles.squares, self.profiles.before
        gain = 1 - np.sqrt(squares / before) if before > 0 else 0.0
        if self.profiles.improved and gain > TOLD:
            said.append(
                f"the profiles met a fit with {100 * gain:.2g} % less {misfit} than the search "
                "had found; it was taken: raise the budget or the repeats"
            )
        if not self.profiles.complete:
            said.append("some intervals are extrapolated: the profiles spent their evaluations")
        said += [
            d.text([parameters.rig.label(n) for n in d.names], misfit) for d in self.directions
        ]
        return said


def uncertainty(
    problem: Residuals,
    x: Array,
    *,
    among: int | None = None,
    budget: int = BUDGET,
    draws: int = 0,
    seed: int = 0,
    keep: bool = False,
) -> Uncertainty:
    """Everything about how well a fit is known.

    Args:
        problem: Its residuals; see `Residuals`.
        x: The fit, SI, (dim,).
        among: How many parameters, the first ones, are asked about; the others (the starts of
            motions, say) are refitted and no more. All by default.
        budget: Rows that the profiles may evaluate.
        draws: Data sets of a bootstrap; none by default.
        seed: Of the bootstrap.
        keep: Whether the fit stays as it is, whatever better one is met.

    Raises:
        InputError: the fit cannot be run, or has no more rows than parameters.
    """
    terrain = Terrain(problem)
    names = terrain.space.names[:among]
    found = profiles(problem, x, budget=budget, which=names, keep=keep)
    drawn = bootstrap(problem, found.x, n=draws, seed=seed) if draws else None
    slope = terrain.slope(terrain.u(found.x))
    weighed, spent = weights(problem, found)
    return Uncertainty(
        found.x,
        found,
        weighed,
        directions(terrain.space, found),
        found.look.errors * slope,
        found.look.correlation,
        drawn,
        found.rows + spent + (drawn.rows if drawn else 0),
    )


def estimates(
    parameters: Parameters,
    p: Array,
    found: Uncertainty,
    spread: Array | None = None,
    *,
    errors: Array | None = None,
    ends: Mapping[str, str] | None = None,
    resting: Mapping[str, str] = MappingProxyType({}),
    doubtful: bool = False,
    misfit: str = "J",
) -> tuple[Estimate, ...]:
    """Every parameter with its interval, its bound and a verdict, in `parameters.every`'s order.

    Args:
        parameters: Which parameters were free.
        p: The complete parameter set, SI, (k,).
        found: How well the free ones are known; they come first in its problem.
        spread: Their standard deviations over repeats, SI, nan where there are none, (dim,).
        errors: Standard errors to be told in place of those of `found`, SI, (dim,).
        ends: Which end of its range a parameter sits at, by name, if that is known; else what
            lies within a thousandth of a range of its end counts as sitting there.
        resting: On which other parameter one rests, by name: the law's order forbids it to pass,
            as F_S may not fall below F_C. Then nothing in the data asks for a difference.
        doubtful: Whether the fit as a whole holds so badly that it identifies nothing.
        misfit: What the root mean square of the residuals is called.
    """
    free = {q.name: i for i, q in enumerate(parameters.free)}
    seen = found.by_name()
    drawn = found.bootstrap
    made_of = []
    for param, value in zip(parameters.every, p.tolist(), strict=True):
        label, written = parameters.rig.label(param.name), parameters.rig.unit_of(param)
        own = parameters.tied.get(param.name, param.name)
        i = free.get(own)
        if i is None:
            nan = float("nan")
            made_of.append(Estimate(label, value, nan, nan, value, value, None, "fixed", written))
            continue
        profile, weight = seen[own]
        at = _end(value, param.lower, param.upper) if ends is None else _named(ends, param.name)

        def show(x: float, q: Param = param, written: str = written) -> str:
            return f"{float(shown_in(parameters.rig, q, x)):.4g} {written}".rstrip()

        made_of.append(
            Estimate(
                label,
                value,
                float((found.errors if errors is None else errors)[i]),
                float("nan") if spread is None else float(spread[i]),
                profile.low.end,
                profile.high.end,
                at,
                "not identifiable"
                if own in resting
                else verdict(profile, parameters.free[i], doubtful=doubtful),
                written,
                profile.low.ended,
                profile.high.ended,
                _rests(label, parameters.rig.label(resting[own]))
                if own in resting
                else sentence(label, profile, weight, show, misfit),
                None if drawn is None else (float(drawn.low[i]), float(drawn.high[i])),
            )
        )
    return tuple(made_of)


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


def verdict(profile: Profile, param: Param, *, doubtful: bool = False) -> Verdict:
    """What a profile says of a parameter; see `Estimate`."""
    down, up = half_widths(profile)
    size = abs(profile.value)
    closed = [side.ended not in ("bound", "flat") for side in (profile.low, profile.high)]
    guessed = "budget" in (profile.low.ended, profile.high.ended)  # too wide, as a rule
    if not guessed and (share_of_range(profile, param) >= ALL_OVER or not any(closed)):
        return "not identifiable"
    by_data = profile.low.ended == profile.high.ended == "threshold"
    if by_data and max(down, up) <= IDENTIFIED * size and not doubtful:
        return "identified"
    return "weak"


def _named(ends: Mapping[str, str], name: str) -> Literal["lower", "upper"] | None:
    at = ends.get(name)
    return None if at is None else ("lower" if at == "lower" else "upper")


def _end(value: float, lower: float, upper: float) -> Literal["lower", "upper"] | None:
    width = upper - lower
    if value - lower < AT_END * width:
        return "lower"
    return "upper" if upper - value < AT_END * width else None


def standard_errors(problem: Residuals, x: Array) -> tuple[Array, Array]:
    """Standard errors (SI) and correlations of the free parameters at an estimate.

    The usual covariance of nonlinear least squares, each parameter's widened for residuals that
    correlate; see `covariance`. It is a quick look: linear, and blind to what the rig's model
    leaves out. inf where the data do not see a parameter.
    """
    terrain = Terrain(problem)
    place = start(Meter(problem, 3 * terrain.dim + 1), terrain, x)
    look = quick_look(place.J, place.r, logs_of(problem, len(place.r)))
    return look.errors * terrain.slope(place.u), look.correlation


def rest_noise(recordings: Sequence[Recording]) -> float:
    """Standard deviation of the position while axes rest, m or rad; nan without rests.

    It is what the sensor does to a position that does not change, quantisation included, about
    a line through each rest; samples that a sensor merely holds are left out.
    """
    squares, count = 0.0, 0
    for log in recordings:
        anew = is_new(log)
        for rest in rests(log):
            n = rest.stop - rest.start
            inner = slice(rest.start + int(CUT * n), rest.stop - int(CUT * n))
            keep = anew[inner]
            if int(keep.sum()) < FEWEST:
                continue
            x, t = log.position[inner][keep], log.t[inner][keep]
            W = np.column_stack([np.ones(len(t)), t - t.mean()])
            weights_of = np.linalg.lstsq(W, x - x[0], rcond=None)[0]
            squares += float(np.sum((x - x[0] - W @ weights_of) ** 2))
            count += len(t) - 2
    return float(np.sqrt(squares / count)) if count else float("nan")


def bound_warnings(estimates: Sequence[Estimate]) -> list[str]:
    """A sentence for every parameter that ended at an end of its search range."""
    return [
        f"{e.name} ended at the {e.at_bound} end of its range: widen the range or doubt the value"
        for e in estimates
        if e.at_bound
    ]


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
