"""The free curve that the recommended law of a force balance is held against.

A formula may be the best of those compared and still be wrong at some speeds. The same logs are
balanced with a table of friction over speed (`curve`), whose knots know no formula, and the law is
compared with it knot by knot: by the difference, and by what the data know of the knot.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import groupby
from typing import TYPE_CHECKING

import numpy as np

from ...errors import InputError
from ...friction.curve import knots_of
from ...units import Unit, unit
from ..balance.balance import solved
from ..balance.curve_prior import chord_errors, of_free_curve
from ..balance.regression import System
from ..uncertainty.covariance import HALF_WIDTH
from .nesting import ingredients

if TYPE_CHECKING:
    from ..balance.balance import Balance
    from .trained_law import TrainedLaw

#: A difference below this share of the friction is none.
WITHIN = 0.03
#: What is said of a law with a drop where the free curve has none.
_BENT = (
    " The curve nowhere falls with speed by more than its errors: what the law has as a drop from "
    "rest stands for another bend, and its levels are none of the axis's."
)
#: So many stretches of speeds are told of, those of the greatest differences.
TOLD = 3


@dataclass(frozen=True)
class Knot:
    """A knot of the free curve, SI.

    Args:
        speed: With the sign of the direction where the law has parameters for each.
        level: Friction there, without sign.
        low: Lower end of its 95 % interval.
        high: Upper end.
        law: What the law has there.
    """

    speed: float
    level: float
    low: float
    high: float
    law: float

    @property
    def difference(self) -> float:
        """Of the law from the curve, as a share of it."""
        return self.law / self.level - 1.0 if self.level > 0.0 else float("inf")

    @property
    def differs(self) -> bool:
        """Whether the law is off by more than matters, and more than the data leave open."""
        return abs(self.difference) > WITHIN and not self.low <= self.law <= self.high


@dataclass(frozen=True)
class FreeCurve:
    """The free curve of the training data, and the law beside it.

    Args:
        knots: Of both directions, the slowest first.
        error: Of its force on the training data, percent.
        sentence: Where the law differs from it.
    """

    knots: tuple[Knot, ...]
    error: float
    sentence: str


def free_curve(trained: TrainedLaw) -> FreeCurve | None:
    """The free curve beside a trained law; None where it has none.

    A law that is simulated, that reads more than the speed, or that is a free curve itself has
    none, and neither have too few rows.
    """
    law, balanced = trained.parameters.law, trained.balance
    parameters = None if balanced is None else of_free_curve(balanced.system.parameters)
    if balanced is None or parameters is None:
        return None
    try:
        curve = solved(System(parameters, balanced.system.logs))
    except InputError:
        return None
    errors = np.hypot(curve.robust_errors, chord_errors(curve.system, curve.values))
    speeds = knots_of(parameters.law, curve.values)
    n = len(speeds)
    knots: list[Knot] = []
    for k, way in enumerate((1.0, -1.0) if law.directional else (1.0,)):
        levels = way * law.friction(way * speeds, trained.p[: len(law.params)])
        for i, (speed, level) in enumerate(zip(speeds, levels, strict=True)):
            at = k * n + i
            half = HALF_WIDTH * float(errors[at])
            value = float(curve.values[at])
            knots.append(Knot(way * float(speed), value, value - half, value + half, float(level)))
    return FreeCurve(tuple(knots), curve.relative_error, _sentence(trained, curve, knots))


def _sentence(trained: TrainedLaw, curve: Balance, knots: list[Knot]) -> str:
    """Where the law is within a share of the curve, and where it is not."""
    head = (
        f"Held against a free curve of {len(knots)} knots (which leaves "
        f"{curve.relative_error:.3g} % of the force): {trained.parameters.law.name} is within "
        f"{100 * WITHIN:.0f} % of it, or of what the data know of it,"
    )
    ordered = sorted(knots, key=lambda k: k.speed)
    runs = [list(run) for off, run in groupby(ordered, key=lambda k: k.differs) if off]
    bent = "" if _falls(knots) or not _drops(trained) else _BENT
    if not runs:
        return f"{head} at every speed.{bent}"
    runs.sort(key=lambda run: -max(abs(k.difference) for k in run))
    shown = unit(trained.parameters.rig.unit_shown("velocity"))
    places = [_place(run, ordered, shown) for run in runs[:TOLD]]
    more = f" and {len(runs) - TOLD} more" if len(runs) > TOLD else ""
    return f"{head} but {', '.join(places)}{more}.{bent}"


def _drops(trained: TrainedLaw) -> bool:
    """Whether a law has a level at rest above that at speed."""
    return "stribeck" in ingredients(trained.parameters.law, trained.parameters.names)


def _falls(knots: list[Knot]) -> bool:
    """Whether friction is less at a knot than at a slower one, beyond what the data leave open."""
    return any(
        slow.low > fast.high
        for slow in knots
        for fast in knots
        if slow.speed * fast.speed > 0.0 and abs(slow.speed) < abs(fast.speed)
    )


def _place(run: list[Knot], ordered: list[Knot], shown: Unit) -> str:
    """A run of knots, its speeds and the greatest difference."""
    worst = max(run, key=lambda k: abs(k.difference))
    first, last = (f"{float(shown.from_si(k.speed)):.3g}" for k in (run[0], run[-1]))
    if run[0] is ordered[0] and run[0].speed > 0.0:
        speeds = f"up to {last} {shown.written}"
    elif run[-1] is ordered[-1] and len(run) > 1:
        speeds = f"from {first} {shown.written} on"
    else:
        speeds = f"at {first}" if len(run) == 1 else f"from {first} to {last}"
        speeds = f"{speeds} {shown.written}"
    return f"{speeds} ({100 * worst.difference:+.2g} %)"
