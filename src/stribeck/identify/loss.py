"""The loss: whole motions or from rest to rest, squared or absolute residuals."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from ..errors import InputError
from ..space import Array
from ..wording import option

Loss = Literal["squares", "absolute"]
#: Whether slips break away at one level or each at its own; `auto` where the log shows the latter.
Breakaway = Literal["auto", "common", "scattered"]

#: Errors below the knee count by their squares, those above by their size: a share of the widest
#: range of the logs, and by what it is lowered once the search has ended.
KNEE, FINER = 0.01, 0.1


@dataclass(frozen=True)
class Objective:
    """The misfit that an identification minimises.

    Args:
        loss: `squares` of the errors, or their `absolute` size, to which the few segments that a
            model cannot follow matter less.
        restart: Whether the simulation starts anew at every rest. Where slips do not come at the
            same force each time, a simulation of many slips is soon out of step, and says more
            of that than of the friction.
        breakaway: `common` to all slips, or `scattered`: then the slips are simulated one by one,
            each with a breakaway of its own, and F_S is their mean. `auto` is scattered where the
            log shows that slips begin under forces that are not the same, or what the controller
            read.
    """

    loss: Loss = "squares"
    restart: bool = False
    breakaway: Breakaway = "common"

    def __post_init__(self) -> None:
        for name, value, choices in (
            ("loss", self.loss, get_args(Loss)),
            ("breakaway", self.breakaway, get_args(Breakaway)),
        ):
            if value not in choices:
                raise InputError(f"{option(name)} {value!r} is not one of {', '.join(choices)}")

    @property
    def by_slip(self) -> bool:
        """Whether the slips are simulated one by one, each with a breakaway of its own."""
        return self.breakaway == "scattered"

    @property
    def by_leg(self) -> bool:
        """Whether more than one simulation passes through a range of a log."""
        return self.restart or self.by_slip


SQUARES = Objective()


def pseudo_huber(r: Array, knee: float) -> Array:
    """Residuals whose squares grow as r^2 below the knee, and as 2 knee |r| above it.

    The square root of the pseudo-Huber loss (Charbonnier et al. 1997, doi 10.1109/83.551699) with
    the sign of r: what least squares makes of it is nearly least absolute errors.
    """
    loss: Array = r * np.sqrt(2.0 * knee / (np.sqrt(r * r + knee * knee) + knee))
    return loss
