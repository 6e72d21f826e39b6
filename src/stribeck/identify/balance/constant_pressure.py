"""A pressure that does not change: no regressor, but the noise of its sensor.

Least squares takes what a column varies by for what the axis was told, and finds a slope over it.
Where the pressure is one, its force is an offset and the friction that it adds a level: what takes
the one for the other is told, and not identified, however small the standard errors are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ...data.resolution import noise_of, step
from ...space import Array
from ...units import unit
from ..conditions import Violation
from ..uncertainty.verdict import IDENTIFIED
from .regression import System
from .rows import filtered_logs

if TYPE_CHECKING:
    from ...data.recording import Recording
    from .balance import Balance
    from .rows import Rows

#: Singular values below this share of the largest one are those of columns that are one.
_ALIKE = 1e-6
#: A parameter is told from no other if it has this share of such a combination, at least.
_SHARE = 1e-3


def constant_pressure(
    solution: Balance, recordings: Sequence[Recording], rows: Sequence[Rows | None]
) -> list[Violation]:
    """That a recorded pressure does not change, of the parameters that it would have to tell apart.

    By the share of its variance that is its sensor's, least squares makes a slope over it too
    small (Fuller 1987, Measurement Error Models, section 1.1): what is a tenth off is not known.

    Args:
        solution: A solved balance.
        recordings: Its logs.
        rows: Which of their samples count.
    """
    rig = solution.system.rig
    channels = [log.pressure for log in recordings]
    pressures = [p for p in channels if p is not None]
    if "normal" not in rig.loads or len(pressures) < len(channels):
        return []
    values = np.concatenate(pressures)
    noise = max(float(np.hypot(noise_of(p), step(p) / np.sqrt(12))) for p in pressures)
    spread = float(np.std(values))
    if noise**2 < IDENTIFIED * spread**2:
        return []
    mean = float(np.mean(values))
    even = [replace(log, pressure=np.full(len(log), mean)) for log in recordings]
    names = _alike(solution, even, rows)
    if not names:
        return []
    bar = unit("bar")
    varies, of_noise = (float(bar.from_si(x)) for x in (spread, noise))
    *first, last = map(rig.label, names)
    text = (
        f"the pressure does not change: its standard deviation is {varies:.2g} bar, that of its "
        f"sensor's noise {of_noise:.2g} bar, and at one pressure nothing tells "
        f"{', '.join(first)} and {last} apart: log other pressures, or hold what is known of them"
    )
    return [Violation("data", text, frozenset(names))]


def _alike(
    solution: Balance, recordings: Sequence[Recording], rows: Sequence[Rows | None]
) -> list[str]:
    """Free parameters of which some combination does nothing to the force of logs."""
    parameters = solution.system.parameters
    logs = [
        replace(log, counts=own.counts, t=own.t, weight=own.weight)
        for log, own in zip(
            filtered_logs(recordings, parameters, None, rows), solution.system.logs, strict=True
        )
    ]
    W: Array = System(parameters, logs).jacobian(solution.values)
    lengths = np.linalg.norm(W, axis=0)
    seen = np.flatnonzero(lengths > 0.0)
    if not len(seen):
        return []
    _, sizes, combinations = np.linalg.svd(W[:, seen] / lengths[seen], full_matrices=False)
    shares = np.linalg.norm(combinations[sizes < _ALIKE * sizes[0]], axis=0)
    return [solution.free[seen[k]] for k in np.flatnonzero(shares > _SHARE)]
