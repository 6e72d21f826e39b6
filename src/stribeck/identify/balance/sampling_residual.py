"""What sampling leaves of the force of a model that is right: columns of a residual.

A controller holds its output from tick to tick, so that the force is up to half a sample ahead of
what the motion shows; and the low pass of the position rounds what the force does not. Both leave
a residual that goes with the motion, and neither is a term that the model lacks. Each column is as
large as sampling makes it at most.
"""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from ...data.filtering import bridged, low_passed
from ...data.resolution import LONG
from ...space import Array
from .modelled_force import force_signal, slope_over_time
from .regression import stacked

if TYPE_CHECKING:
    from ...data.filtering import Filtering
    from ...data.zero_phase import Signal
    from .balance import Balance
    from .rows import Log


#: A held force is so many samples ahead at most, half of one and some margin; what the low pass
#: takes off a modelled force is left over so many times at most.
AHEAD, ROUNDED = 0.75, 1.5


def sampling_residual(solution: Balance) -> Array:
    """What a force that is held and a motion that is low-passed leave over, (rows, 2).

    Slopes of the modelled force over time, and what the low pass takes off that force. Of laws with
    states and of tables of steady speeds there is neither, of logs beyond `LONG` only the first.

    Args:
        solution: The balance.
    """
    system = solution.system
    if system.law.states or any(log.weight is not None for log in system.logs):
        return np.empty((len(system.y), 0))
    columns = []
    for log in system.logs:
        force = force_signal(system.rig, system.law, log, solution.values)
        held = log.thin(partial(slope_over_time, log, force))
        rounded = _rounded(log, force, system.filtering)
        columns.append(np.column_stack([AHEAD / log.rate * held, ROUNDED * rounded]))
    return stacked(columns)


def _rounded(log: Log, force: Signal, filtering: Filtering) -> Array:
    """What the low pass of the motion takes off a modelled force, (rows,)."""
    if len(log) > LONG:
        return np.zeros(len(log.t))
    whole = bridged(force(slice(0, len(log))), log.unsure)
    gone = whole - low_passed(whole, log.rate, filtering)
    return log.thin(lambda at: gone[at])
