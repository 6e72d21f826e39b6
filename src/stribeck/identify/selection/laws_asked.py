"""What is asked of a comparison of laws whatever the logs say: refused before one is read."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from numbers import Integral
from typing import TYPE_CHECKING

from ...data.alignment import Delay, checked_delay
from ...errors import InputError
from ...rig.lookup import rig_and_law
from ...wording import option
from ..loss import Loss, Objective
from ..parameters import Parameters, partition
from ..request import check_velocity, refuse_idle

if TYPE_CHECKING:
    from ...friction import Law
    from ...rig import Rig
    from ..balance.velocity_source import VelocitySource

#: Each law is fitted anew in each of so many rounds at most.
MOST_FOLDS = 1_000


def checked_comparison(
    axis: Rig,
    *,
    laws: Sequence[str | Law] | None = None,
    fixed: Mapping[str, float] | None = None,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    loss: Loss = "squares",
    seed: int | None = None,
    budget: int | None = None,
    folds: int | None = None,
    delay: Delay = "auto",
    velocity: VelocitySource = "auto",
) -> None:
    """Refuse what no comparison on a rig can have; the arguments are those of `select`.

    Raises:
        InputError: there is no such law, loss, parameter or number of rounds, or one that the rig
            has no use for.
    """
    law_parameters(axis, laws=laws, fixed=fixed, bounds=bounds, loss=loss)
    for name, value, least in (("seed", seed, 0), ("budget", budget, 1), ("folds", folds, 2)):
        if value is not None and (not isinstance(value, Integral) or value < least):
            raise InputError(f"{option(name)} must be a whole number >= {least}, got {value!r}")
    if folds is not None and folds > MOST_FOLDS:
        raise InputError(f"{option('folds')} must be {MOST_FOLDS:,} at most, got {folds}")
    checked_delay(delay)
    check_velocity(axis, velocity)
    if axis.approach == "force_balance":
        idle = {"seed": seed is not None, "budget": budget is not None, "loss": loss != "squares"}
        refuse_idle(axis, [name for name, is_asked in idle.items() if is_asked])


def law_parameters(
    axis: Rig,
    *,
    laws: Sequence[str | Law] | None,
    fixed: Mapping[str, float] | None,
    bounds: Mapping[str, tuple[float, float]] | None,
    loss: Loss,
) -> list[Parameters]:
    """The laws with their parameters, the simplest first.

    Raises:
        InputError: an unknown law, one that is given twice, one with states where forces are
            balanced, or a name that no law knows.
    """
    fixed, bounds, objective = dict(fixed or {}), dict(bounds or {}), Objective(loss)
    chosen = [rig_and_law(axis, law)[1] for law in (axis.laws if laws is None else laws)]
    names = [law.name for law in chosen]
    if twice := [n for n in names if names.count(n) > 1]:
        raise InputError(f"law {twice[0]} is given twice: give it once")
    if not chosen:
        raise InputError("no law was given")
    if axis.approach == "force_balance" and (driven := [law.name for law in chosen if law.states]):
        raise InputError(
            f"law {driven[0]} has inner states, whose balance counts rests and reversals, too: "
            f"their errors are not those of other laws; identify each with {option('holdout')}"
        )
    known_names: set[str] = set()
    result = []
    for law in chosen:
        names_of_law = {n for q in axis.parameters(law) for n in (q.name, axis.label(q.name))}
        known_names |= names_of_law
        result.append(
            partition(
                axis,
                law,
                fixed={n: v for n, v in fixed.items() if n in names_of_law},
                bounds={n: v for n, v in bounds.items() if n in names_of_law},
                objective=objective,
            )
        )
    if strange := [n for n in (*fixed, *bounds) if n not in known_names]:
        raise InputError(
            f"no law here has a parameter {strange[0]!r} on rig {axis.name}: there are "
            f"{', '.join(sorted(known_names))}"
        )
    return sorted(result, key=lambda p: len(p.free))
