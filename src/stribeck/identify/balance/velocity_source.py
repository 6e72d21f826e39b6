"""Where the velocity of a force balance comes from: differences of the position, or a channel."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Literal

import numpy as np

from ...errors import InputError
from ...rig.balanced import as_balanced
from ...space import Array
from ...wording import option
from ..conditions import Violation
from .balance import balance
from .training_rows import training_rows

if TYPE_CHECKING:
    from ...data.recording import Recording
    from ..data_split import DataSplit
    from ..parameters import Parameters

#: The recorded channel, differences of the position, or whichever explains the force better.
VelocitySource = Literal["auto", "recorded", "position"]

#: A recorded velocity is used where it leaves less than this share of what the position's leaves.
BETTER = 0.8
#: It has another scale where what it integrates to is off the position's way by this share, and by
#: so many times the share that goes with nothing of the position.
OFF, BEYOND = 0.03, 4.0


def velocity_scale(recording: Recording) -> float:
    """The ratio of a recorded velocity to that of the position; 1 where it may be 1.

    By what the velocity integrates to, over the position, a straight line over time taken off both:
    that hangs on no difference of the position, on no zero of the velocity, and on no lag or low
    pass that is short beside a stroke.
    """
    if recording.velocity is None:
        return 1.0
    t, v = recording.t, recording.velocity
    way = np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) * np.diff(t))])
    x, way = (_unsteady(t, y) for y in (recording.position, way))
    if not (travel := float(np.sqrt(x @ x))) > 0.0:
        return 1.0
    ratio = float(x @ way) / travel**2
    left = float(np.linalg.norm(way - ratio * x)) / travel
    return ratio if abs(ratio - 1.0) > max(OFF, BEYOND * left) else 1.0


def _unsteady(t: Array, y: Array) -> Array:
    """What is left of a channel once a straight line over time is taken off, (N,)."""
    t, y = t - t.mean(), y - y.mean()
    line: Array = y - (t @ y) / (t @ t) * t
    return line


def with_velocity(
    parameters: Parameters, data: DataSplit, source: VelocitySource
) -> tuple[Parameters, tuple[Violation, ...]]:
    """Parameters on a rig that reads a velocity, and what is told of it.

    A recorded velocity is an estimate of a drive, late and smooth as a rule, and the position's
    differences are noise where it is coarse or slowly sampled. By `auto` the one is taken that
    leaves less of the force: the recorded one only where it leaves clearly less.

    Args:
        parameters: Of a law on a rig with a measured force.
        data: The logs.
        source: Which velocity.

    Raises:
        InputError: an unknown source.
    """
    if source not in ("auto", "recorded", "position"):
        raise InputError(f"velocity {source!r}: give auto, recorded or position")
    read = as_balanced(parameters.rig).with_velocity
    if source != "auto":
        return replace(parameters, rig=read(source)), ()
    if any(log.velocity is None for log in data.recordings):
        return parameters, ()
    recorded = replace(parameters, rig=read("recorded"))
    by_channel, by_position = (_unexplained(p, data) for p in (recorded, parameters))
    used = by_channel < BETTER * by_position
    word, other = ("used", "position") if used else ("not used", "recorded")
    text = (
        f"the recorded velocity is {word}: with it the model leaves {by_channel:.3g} % of the "
        f"force, with that of the position {by_position:.3g} %, and it is used below "
        f"{100 * BETTER:.0f} % of that; {option('velocity', other)} takes the other"
    )
    if not used:
        return parameters, (Violation("data", text, caps=False),)
    off = max((velocity_scale(log) for log in data.recordings), key=lambda ratio: abs(ratio - 1.0))
    if off != 1.0:
        text += (
            f"; but it is {off:.3g} times that of the position: where its scale is the wrong one, "
            "inertia and viscous friction are off by as much"
        )
    return recorded, (Violation("data", text, caps=off != 1.0),)


def _unexplained(parameters: Parameters, data: DataSplit) -> float:
    """Relative error of the force, percent; inf where no balance can be solved."""
    recordings, rows = training_rows(data)
    try:
        return balance(recordings, parameters, rows=rows).relative_error
    except InputError:
        return float("inf")
