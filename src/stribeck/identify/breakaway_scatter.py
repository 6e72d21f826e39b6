"""Breakaway that differs from slip to slip: whether it does, its mean, and its spread.

A random effect: the breakaway of slip i is F_S,i = F_S + e_i with e_i normal of standard deviation
s (a mean is what F_S of a law can be, and normal and lognormal can hardly be told apart below a
spread of 30 %). It is seen at the onset with an error sigma_i of the sampling, and h parameters are
determined by the onsets: the spread is that of `random_effects` with n - h degrees of freedom.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import lsq_linear
from scipy.special import chdtri

from ..errors import InputError
from ..rig.simulated import as_simulated
from ..space import Array
from ..units import unit
from .own_breakaway import breakaway_columns, column, onset_of, pulls
from .random_effects import TAIL, spread_of

if TYPE_CHECKING:
    from .parameters import Parameters
    from .segment import Segment

#: Breakaway scatters if its standard deviation, as a share of the mean, certainly exceeds this: a
#: hundredth displaces a slip by less than a tenth of the time between two, and no axis that rests
#: on one level came above it.
SCATTERED = 0.02
#: Fewer slips tell no scatter.
FEWEST = 6
#: Nor do those whose pull rises by this share of itself from one sample to the next.
OPEN = 0.5
#: Noise of a motion as a share of its slips, and of a breakaway, before there is a fit.
_ROUGH = 0.03


@dataclass(frozen=True)
class Spread:
    """How a breakaway level varies from slip to slip, SI.

    Args:
        parameter: Name of the level.
        mean: Its mean.
        sd: Standard deviation of the breakaway of single slips.
        low: Lower end of its 95 % interval.
        high: Upper end.
        slips: How many there were.
        dof: Degrees of freedom of the standard deviation.
    """

    parameter: str
    mean: float
    sd: float
    low: float
    high: float
    slips: int
    dof: float


@dataclass(frozen=True)
class BreakawayWeights:
    """What the onsets of slips weigh beside the residuals of their motion.

    Args:
        noise: Root mean square of the residuals of the motion, in their unit.
        sd: Standard deviation of the breakaway by name of its parameter, SI.
        dof: Degrees of freedom of that, by name.
        settled: Whether these, and the onsets, are those of a good fit.
    """

    noise: float
    sd: Mapping[str, float] = field(default_factory=dict)
    dof: Mapping[str, float] = field(default_factory=dict)
    settled: bool = False


@dataclass(frozen=True)
class Scatter:
    """The scatter of the forces under which slips begin, whatever the law.

    Args:
        share: Standard deviation over the mean.
        least: Lower end of its 95 % interval.
        sd: Standard deviation, N or N m.
        slips: How many slips there are.
    """

    share: float
    least: float
    sd: float
    slips: int

    @property
    def evident(self) -> bool:
        """Whether breakaway certainly scatters by more than what does not matter."""
        return self.least > SCATTERED


@dataclass(frozen=True)
class OnsetLevels:
    """What a regression of the pull at the onsets of slips tells, whatever the law.

    Args:
        values: Breakaway levels and the rig's free parameters that pull at an axis at rest: value
            and standard error by name, SI.
        mean: Mean breakaway, N or N m.
        squares: Sum of the squared deviations of single slips, N^2.
        rounding: Mean square of their errors by sampling.
        dof: Degrees of freedom.
    """

    values: Mapping[str, tuple[float, float]]
    mean: float
    squares: float
    rounding: float
    dof: int


def scatter(parameters: Parameters, slips: Sequence[Segment]) -> Scatter | None:
    """How the pull at the onsets of slips scatters; None where that cannot be said.

    What a rig's own free parameters (gravity, a spring) can explain of it is taken away, and each
    direction has a mean of its own.
    """
    seen = onset_levels(parameters, slips)
    if seen is None:
        return None
    sd, least = (
        float(np.sqrt(max(seen.squares / x - seen.rounding, 0.0)))
        for x in (seen.dof, float(chdtri(seen.dof, TAIL)))
    )
    return Scatter(sd / seen.mean, least / seen.mean, sd, len(slips))


def onset_levels(parameters: Parameters, slips: Sequence[Segment]) -> OnsetLevels | None:
    """The regression of the pull at onsets on levels and the rig's free parameters; None if none.

    It takes six slips and more, and a rig that says what pulls at an axis at rest. A motion that
    begins while the pull does not rise is none that breaks away, and under a step of the pull it
    may have broken away anywhere: these count for nothing here.
    """
    rig, law = as_simulated(parameters.rig), parameters.law
    if len(slips) < FEWEST:
        return None
    k, s = len(law.params), np.array([onset_of(x).direction for x in slips])
    own = [q for q in parameters.free if q.name in {w.name for w in parameters.every[k:]}]
    middle = np.array([0.5 * (q.lower + q.upper) for q in parameters.free])
    at = [parameters.free.index(q) for q in own]
    probes = np.tile(middle, (1 + len(own), 1))
    for row, i in enumerate(at, 1):
        probes[row, i] = parameters.free[i].upper
    p = parameters.full(probes)
    try:
        F, rise = (a.T for a in pulls(rig, law, p, slips))
    except InputError:
        return None
    rising = (rise[:, 0] > 0.0) & (rise[:, 0] < OPEN * np.abs(F[:, 0]))
    F, rise, s = F[rising], rise[rising], s[rising]
    if len(s) < FEWEST:
        return None
    slopes = F[:, 1:] - F[:, :1]  # over half of a range
    ways = [way for way in (-1, 1) if (s == way).any()]
    seen = np.ptp(slopes, axis=0) > 0
    A = np.column_stack([*(s == way for way in ways), -slopes[:, seen]]).astype(float)
    ends = np.full(A.shape[1], np.inf)
    ends[len(ways) :] = 1.0
    solution = lsq_linear(A, F[:, 0], (-ends, ends))
    off = F[:, 0] - A @ solution.x
    dof = len(s) - int(np.linalg.matrix_rank(A))
    mean = abs(float(solution.x[: len(ways)].mean()))
    if dof < 1 or not mean > 0:
        return None
    squares = float(off @ off)
    errors = np.sqrt(squares / dof * np.clip(np.diag(np.linalg.pinv(A.T @ A)), 0.0, None))
    values = {
        q.name: (
            middle[i] + solution.x[j] * (q.upper - middle[i]), errors[j] * (q.upper - middle[i])
        )
        for j, (q, i) in enumerate(
            ((q, i) for q, i, known in zip(own, at, seen, strict=True) if known), len(ways)
        )
    }  # fmt: skip
    columns = breakaway_columns(law)
    names = [] if columns is None else [parameters.names[c] for c in columns]
    for name in dict.fromkeys(names):
        js = [j for j, way in enumerate(ways) if names[way > 0] == name]
        if js:
            level = float(np.mean(solution.x[js]))
            values[name] = level, float(np.sqrt(np.mean(np.square(errors[js]))))
    noise = float(np.mean(np.square(uniform(rise[:, 0]))))
    return OnsetLevels(values, mean, squares, noise, dof)


def first_weights(parameters: Parameters, slips: Sequence[Segment]) -> BreakawayWeights:
    """Weights to search with: the scatter as it is seen without a fit, and a rough noise."""
    scattered = scatter(parameters, slips)
    sizes = [float(np.ptp(s.track.measured)) for s in slips]
    noise = (
        _ROUGH * float(np.median(sizes)) / unit(parameters.rig.shows.get("position", "m")).factor
    )
    rig, law = as_simulated(parameters.rig), parameters.law
    if scattered is None:
        middle = np.array([[0.5 * (q.lower + q.upper) for q in parameters.free]])
        F, _ = pulls(rig, law, parameters.full(middle), slips)
        sd = _ROUGH * float(np.mean(np.abs(F)))
    else:
        sd = scattered.sd
    columns = {column(law, s) for s in slips}
    return BreakawayWeights(noise, {parameters.names[k]: sd for k in columns})


def uniform(rise: Array) -> Array:
    """The standard deviation of what lies somewhere between two ends so far apart."""
    sd: Array = np.abs(rise) / np.sqrt(12.0)
    return sd


def level_columns(parameters: Parameters, slips: Sequence[Segment]) -> Array:
    """The column of the breakaway level of each slip in a complete parameter set, (slips,)."""
    return np.array([column(parameters.law, s) for s in slips])


def spreads(
    parameters: Parameters, p: Array, slips: Sequence[Segment], taken: Array
) -> tuple[Spread, ...]:
    """The spread of each breakaway level about its mean in a complete parameter set, (k,).

    Args:
        parameters: Rig and law.
        p: The set.
        slips: Its slips.
        taken: Of how many degrees of freedom the fit has deprived each slip, (slips,).
    """
    F, rise = pulls(as_simulated(parameters.rig), parameters.law, p[None], slips)
    error = uniform(rise)
    columns, result = level_columns(parameters, slips), []
    for k in dict.fromkeys(columns.tolist()):
        mine = columns == k
        dof = max(float(mine.sum() - taken[mine].sum()), 1.0)
        mean = float(p[k])
        ends = spread_of(F[0, mine], error[0, mine], dof, mean)
        result.append(Spread(parameters.names[k], mean, *ends, int(mine.sum()), dof))
    return tuple(result)
