"""The loss: whole motions or from rest to rest, squared or absolute residuals."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from ..errors import InputError
from ..space import Array

Loss = Literal["squares", "absolute"]

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
    """

    loss: Loss = "squares"
    restart: bool = False

    def __post_init__(self) -> None:
        if self.loss not in get_args(Loss):
            raise InputError(f"loss {self.loss!r} is not one of {', '.join(get_args(Loss))}")


SQUARES = Objective()


def pseudo_huber(r: Array, knee: float) -> Array:
    """Residuals whose squares grow as r^2 below the knee, and as 2 knee |r| above it.

    The square root of the pseudo-Huber loss (Charbonnier et al. 1997, doi 10.1109/83.551699) with
    the sign of r: what least squares makes of it is nearly least absolute errors.
    """
    loss: Array = r * np.sqrt(2.0 * knee / (np.sqrt(r * r + knee * knee) + knee))
    return loss
