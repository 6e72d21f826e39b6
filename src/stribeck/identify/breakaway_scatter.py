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
from scipy.special import chdtri

from ..errors import InputError
from ..rig.simulated import as_simulated
from ..space import Array
from ..units import unit
from .onset_levels import onset_levels
from .own_breakaway import column, onset_of, pulls, uniform
from .random_effects import TAIL, spread_of

if TYPE_CHECKING:
    from .parameters import Parameters
    from .segment import Segment

#: Breakaway scatters if its standard deviation, as a share of the mean, certainly exceeds this: a
#: hundredth displaces a slip by less than a tenth of the time between two, and no axis that rests
#: on one level came above it.
SCATTERED = 0.02
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
        slips: How many slips tell it.
        read: Whether it is known what the controller read in some of them.
    """

    share: float
    least: float
    sd: float
    slips: int
    read: bool = False

    @property
    def evident(self) -> bool:
        """Whether breakaway certainly scatters by more than what does not matter."""
        return self.least > SCATTERED


def scatter(parameters: Parameters, slips: Sequence[Segment]) -> Scatter:
    """How the pull at the onsets of slips scatters.

    What a rig's own free parameters (gravity, a spring) can explain of it is taken away, and each
    direction has a mean of its own.

    Raises:
        InputError: that cannot be said; see `onset_levels`.
    """
    levels = onset_levels(parameters, slips)
    sd, least = (
        float(np.sqrt(max(levels.squares / x - levels.rounding, 0.0)))
        for x in (levels.dof, float(chdtri(levels.dof, TAIL)))
    )
    read = any(onset_of(s).instant is not None for s in slips)
    return Scatter(sd / levels.mean, least / levels.mean, sd, levels.slips, read)


def first_weights(parameters: Parameters, slips: Sequence[Segment]) -> BreakawayWeights:
    """Weights to search with: the scatter as it is seen without a fit, and a rough noise."""
    sizes = [float(np.ptp(s.track.measured)) for s in slips]
    noise = (
        _ROUGH * float(np.median(sizes)) / unit(parameters.rig.shows.get("position", "m")).factor
    )
    rig, law = as_simulated(parameters.rig), parameters.law
    try:
        sd = scatter(parameters, slips).sd
    except InputError:
        F, _ = pulls(rig, law, parameters.full(parameters.middle[None]), slips)
        sd = _ROUGH * float(np.mean(np.abs(F)))
    columns = {column(law, s) for s in slips}
    return BreakawayWeights(noise, {parameters.names[k]: sd for k in columns})


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
