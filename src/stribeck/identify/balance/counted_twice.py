"""A rigid-body torque that is subtracted from the force beside a rig that has an inertia, too."""

from __future__ import annotations

from operator import attrgetter
from typing import TYPE_CHECKING

import numpy as np

from ...units import unit
from ..conditions import Violation

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from ...space import Array
    from .balance import Balance
    from .rows import Log

#: A subtracted force holds an inertia if the acceleration explains this share of what speed and
#: pose leave of it, and more than a thousandth of all; a mass counts twice if the slope over the
#: acceleration is this share of it.
HOLDS, LEAST, TWICE = 0.5, 1e-3, 0.3


def twice_violations(solved: Balance) -> list[Violation]:
    """An inertia that the subtracted force and the rig both have.

    Args:
        solved: The balance.
    """
    parameters = solved.system.parameters
    names = [q.name for q in parameters.every]
    logs = [log for log in solved.system.logs if np.any(log.known)]
    if not logs or "M" not in names:
        return []
    slope = _inertia(logs)
    rig, held = parameters.rig, parameters.fixed.get("M")
    (mass,) = [q for q in parameters.every if q.name == "M"]
    label, written = rig.label("M"), rig.unit_of(mass)
    shown = f"{float(unit(written).from_si(slope)):.3g} {written}"
    if not slope > 0.0:
        return []
    if held is not None:
        if not slope > TWICE * held > 0:
            return []
        value = f"{float(unit(written).from_si(held)):.4g} {written}"
        return [
            Violation(
                "model",
                f"the mass counts twice: {label} is set to {value}, and what is subtracted from "
                f"the force goes with the acceleration by {shown}, too: set {label} to 0, or "
                "subtract nothing",
            )
        ]
    return [
        Violation(
            "model",
            f"what is subtracted from the force goes with the acceleration by {shown}: {label} is "
            f"what that leaves of the inertia, and no inertia of the axis; set {label} to 0 where "
            "it holds all of it",
            frozenset({"M"}),
        )
    ]


def _inertia(logs: Sequence[Log]) -> float:
    """The slope of the known force over the acceleration, SI; 0 where it has none of its own."""

    def picked(values: Callable[[Log], Array]) -> Array:
        return np.concatenate([log.pick(values(log)) for log in logs])

    a, v, x = (picked(attrgetter(name)) for name in ("a", "v", "position"))
    known = picked(lambda log: np.broadcast_to(log.known, (len(log),)))
    pose = np.column_stack([np.ones(len(a)), v, np.sign(v), x, np.sin(x), np.cos(x)])
    own = a - pose @ np.linalg.lstsq(pose, a, rcond=None)[0]
    rest = known - pose @ np.linalg.lstsq(pose, known, rcond=None)[0]
    if not own @ own > 0:
        return 0.0
    slope = float(own @ rest / (own @ own))
    explained = slope**2 * float(own @ own)
    seen = explained > HOLDS * float(rest @ rest)
    return slope if seen and explained > LEAST**2 * float(known @ known) else 0.0
