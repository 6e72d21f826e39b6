"""The uncertainty of all parameters of a fit, by either method."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ...optimize.lockstep import Counted
from ...optimize.slopes import MOST_FANS
from ...space import Array
from ...units import percent
from .blind_directions import Direction, directions
from .bootstrap import Bootstrap, bootstrap
from .covariance import quick_look
from .linearisation import box_of, linearised
from .profile import BUDGET, Profile, Profiles, profiles
from .residuals import Residuals, logs_of
from .sensitivity import Sensitivity, distinct, sensitivities

if TYPE_CHECKING:
    from ..parameters import Parameters

#: An improvement of the misfit below this share is not noted.
NOTED = 1e-3


@dataclass(frozen=True, eq=False)
class Uncertainty:
    """All that is known about how well a fit is known.

    Args:
        x: The fit, SI, (dim,): a better one than was given, if the profiles met one.
        profiles: Of the parameters asked about.
        sensitivities: What setting each elsewhere does to the fit.
        directions: Joint moves that the data do not notice.
        errors: Standard errors of all parameters, SI, (dim,).
        correlation: Of all parameters, (dim, dim).
        bootstrap: Refits of drawn data, if asked for.
        rows: Rows evaluated.
    """

    x: Array
    profiles: Profiles
    sensitivities: tuple[Sensitivity, ...]
    directions: tuple[Direction, ...]
    errors: Array
    correlation: Array
    bootstrap: Bootstrap | None
    rows: int

    def without_rows(self) -> Uncertainty:
        """The same without residuals and their slopes, of which a long log has millions."""
        empty = np.zeros((len(self.x), 0))
        return replace(self, profiles=replace(self.profiles, J=empty, residuals=np.zeros(0)))

    def by_name(self) -> dict[str, tuple[Profile, Sensitivity]]:
        """Profile and sensitivity of each parameter asked about."""
        pairs = zip(self.profiles.profiles, self.sensitivities, strict=True)
        return {p.name: (p, s) for p, s in pairs}

    def notes(self, parameters: Parameters, misfit: str = "J") -> list[str]:
        """What a reader must know, a sentence each."""
        sentences = []
        misfit = distinct(misfit, [parameters.rig.label(q.name) for q in parameters.every])
        squares, before = self.profiles.squares, self.profiles.before
        gain = 1 - np.sqrt(squares / before) if before > 0 else 0.0
        if self.profiles.improved and gain > NOTED:
            sentences.append(
                f"the profiles met a fit with {percent(gain)} less {misfit} than the search "
                "had found; it was taken: raise the budget or the repeats"
            )
        if self.profiles.rough:
            sentences.append(
                f"{misfit} is rough: parameters that differ in the eleventh digit change it by "
                "more than a refit is told by, so that all intervals are guesses from its slopes"
            )
        elif not self.profiles.complete:
            sentences.append(
                "some intervals are extrapolated: the profiles spent their evaluations"
            )
        sentences += [
            d.text([parameters.rig.label(n) for n in d.names], misfit) for d in self.directions
        ]
        return sentences


def uncertainty(
    problem: Residuals,
    x: Array,
    *,
    among: int | None = None,
    budget: int = BUDGET,
    draws: int = 0,
    seed: int = 0,
    keep: bool = False,
    modes: Sequence[Array] = (),
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
        modes: Near other minima that may explain the data as well, SI, (dim,) each.

    Raises:
        InputError: the fit cannot be run, or has no more rows than parameters.
    """
    box = box_of(problem)
    names = box.space.names[:among]
    profiled = profiles(problem, x, budget=budget, chosen_names=names, keep=keep, modes=modes)
    drawn = bootstrap(problem, profiled.x, n=draws, seed=seed) if draws else None
    scale = box.scale(box.u(profiled.x))
    effects, spent = sensitivities(problem, profiled)
    return Uncertainty(
        profiled.x,
        profiled,
        effects,
        directions(box.space, profiled),
        profiled.quick.errors * scale,
        profiled.quick.correlation,
        drawn,
        profiled.rows + spent + (drawn.rows if drawn else 0),
    )


def standard_errors(problem: Residuals, x: Array) -> tuple[Array, Array]:
    """Standard errors (SI) and correlations of the free parameters at an estimate.

    The usual covariance of nonlinear least squares, each parameter's widened for residuals that
    correlate; see `covariance`. It is a quick look: linear, and blind to what the rig's model
    leaves out. inf where the data do not see a parameter.
    """
    box = box_of(problem)
    fit = linearised(Counted(problem, 1 + MOST_FANS * (box.dim + 1)), box, x)
    quick = quick_look(fit.J, fit.r, logs_of(problem, len(fit.r)))
    return quick.errors * box.scale(fit.u), quick.correlation
