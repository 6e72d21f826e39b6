"""What the sampling of a motion does to a law with states that it drives.

Within a sample a contact may break away or come to rest, and no sample says when. The law is driven
once more by every other sample, and what that moves the estimates by is taken for what the samples
between those there are would.
"""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from ...space import Array

if TYPE_CHECKING:
    from ...data.zero_phase import Samples
    from .balance import Balance


def path_shifts(solution: Balance) -> Array:
    """By how much the estimates move where the path has half of its samples, (k,), to first order.

    0 for a law without states, and for what is not seen.
    """
    system, p = solution.system, solution.values
    shifts = np.zeros(len(p))
    law, rig = system.law, system.rig
    seen = np.isfinite(np.diag(solution.covariance))
    if not law.states or not seen.any():
        return shifts
    moved = []
    for log in system.logs:
        assert log.path is not None  # noqa: S101 - a law with states is driven along one
        loads = log.loads(log.clock, log.position[:])
        coarse = np.interp(
            log.clock,
            log.clock[::2],
            rig.friction_along(law, p, log.path.thinned(), loads[::2]),
        )
        fine = rig.friction_along(law, p, log.path, loads)
        moved.append(log.thin(partial(_at, coarse - fine)))
    J = solution.jacobian[:, seen]
    lengths = np.linalg.norm(J, axis=0)
    lengths[lengths == 0] = 1.0
    step = np.linalg.lstsq(J / lengths, np.concatenate(moved), rcond=1e-9)[0] / lengths
    shifts[np.array(system.free)[seen]] = step
    return shifts


def _at(signal: Array, at: Samples) -> Array:
    return np.asarray(signal[at])
