"""What is asked of an identification whatever the logs say: refused before one of them is read."""

from __future__ import annotations

from collections.abc import Mapping
from numbers import Integral
from typing import TYPE_CHECKING, Any, get_args

from ..data.alignment import Delay, checked_delay
from ..errors import InputError
from ..wording import option
from .loss import Breakaway, Loss, Objective
from .parameters import partition
from .search_settings import SearchSettings

if TYPE_CHECKING:
    from ..friction import Law
    from ..rig import Rig
    from .balance.velocity_source import VelocitySource

#: Refits of redrawn residuals and samples of the posterior at most: a thousand times the usual.
MOST_DRAWS, MOST_SAMPLES = 200_000, 20_000_000


def checked_request(
    rig: Rig,
    law: Law,
    *,
    search: Mapping[str, Any],
    fixed: Mapping[str, float] | None = None,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    tie: Mapping[str, str] | None = None,
    loss: Loss = "squares",
    restart: bool = False,
    delay: Delay = "auto",
    velocity: VelocitySource = "auto",
    breakaway: Breakaway = "auto",
    bootstrap: int = 0,
    posterior: int = 0,
) -> tuple[Objective, SearchSettings]:
    """The misfit and the search that are asked for; the arguments are those of `identify`.

    Args:
        rig: The axis.
        law: The law.
        search: Arguments of `SearchSettings`; None for what is not asked for.
        fixed: As for `identify`, like the rest.
        bounds: The same.
        tie: The same.
        loss: The same.
        restart: The same.
        delay: The same.
        velocity: The same.
        breakaway: The same.
        bootstrap: The same.
        posterior: The same.

    Raises:
        InputError: there is no such method, loss, parameter or the like, or one that the rig has
            no use for.
    """
    objective = Objective(loss, restart, breakaway)
    partition(rig, law, fixed=fixed, bounds=bounds, tied=tie, objective=objective)
    for name, count, most in (
        ("bootstrap", bootstrap, MOST_DRAWS),
        ("posterior", posterior, MOST_SAMPLES),
    ):
        if not isinstance(count, Integral) or count < 0:
            raise InputError(f"{option(name)} must be a whole number >= 0, got {count!r}")
        if count > most:
            raise InputError(f"{option(name)} must be {most:,} at most, got {count}")
    asked = {name: value for name, value in search.items() if value is not None}
    checked_delay(delay)
    check_velocity(rig, velocity)
    if rig.approach == "force_balance":
        idle = {"loss": loss != "squares", "restart": restart, "breakaway": breakaway != "auto"}
        refuse_idle(rig, [*asked, *(name for name, is_asked in idle.items() if is_asked)])
    return objective, SearchSettings(**asked)


def check_velocity(rig: Rig, velocity: VelocitySource) -> None:
    """Refuse a source of the velocity that there is not, or on a rig that reads none.

    Raises:
        InputError: it is one.
    """
    from .balance.velocity_source import VelocitySource  # noqa: PLC0415 - compiled code with it

    sources = get_args(VelocitySource)
    if velocity not in sources:
        raise InputError(f"{option('velocity')} {velocity!r}: give {', '.join(sources)}")
    if velocity != "auto" and rig.approach != "force_balance":
        raise InputError(f"rig {rig.name} is simulated: it reads no velocity of a log")


def refuse_idle(rig: Rig, names: list[str]) -> None:
    """Refuse arguments of a search on a rig that is solved without one.

    Raises:
        InputError: there is one.
    """
    if names:
        raise InputError(
            f"rig {rig.name} is solved by least squares, without a search: "
            f"{', '.join(map(option, names))} does not apply"
        )
