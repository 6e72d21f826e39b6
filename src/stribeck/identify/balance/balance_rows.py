"""The residual of a force balance, row by row, as its adequacy is judged by."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..adequacy.residual_rows import ResidualRows
from .regression import accelerations
from .sampling_residual import sampling_residual

if TYPE_CHECKING:
    from ..uncertainty.estimates import Estimate
    from .balance import Balance
    from .noisier_balance import NoisierBalance
    from .sensor_bias import SensorBias


def balance_rows(
    solution: Balance,
    estimates: Sequence[Estimate],
    bias: SensorBias | None,
    noisier: NoisierBalance,
) -> ResidualRows:
    """The residual of a solved balance beside its motion.

    The error of the motion leaves a residual, too: what moves a parameter by less than that error
    does is no sign of a term that the model lacks, so half-widths hold both.

    Args:
        solution: The balance.
        estimates: Of all its parameters, in their order.
        bias: What the error of the motion has moved it by.
        noisier: The same with that error added once more.
    """
    logs, free = solution.system.logs, solution.system.free
    half_widths = np.array([0.5 * (estimates[i].high - estimates[i].low) for i in free])
    if bias is not None:
        half_widths += np.abs(bias.shift[free])
    return ResidualRows(
        log=np.repeat(np.arange(len(logs)), [len(log.t) for log in logs]),
        t=np.concatenate([log.t for log in logs]),
        position=np.concatenate([log.pick(log.position) for log in logs]),
        velocity=np.concatenate([log.pick(log.v) for log in logs]),
        acceleration=np.concatenate([log.pick(log.a) for log in logs]),
        residual=solution.residuals,
        jacobian=solution.jacobian,
        names=tuple(solution.names[i] for i in free),
        values=solution.values[free],
        half_widths=half_widths,
        sampling=sampling_residual(solution),
        thinned=accelerations(logs),
        noisier=noisier,
        place=np.arange(len(solution.residuals), dtype=np.int32),
    )
