"""The residual of a force balance, row by row, as its adequacy is judged by."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..adequacy.residual_rows import ResidualRows
from .regression import accelerations
from .sampling_residual import sampling_residual

if TYPE_CHECKING:
    from ...space import Array
    from ..uncertainty.estimates import Estimate
    from .balance import Balance
    from .regression import System
    from .sensor_bias import SensorBias


#: Bytes of what is drawn that are kept.
KEPT = 1 << 25


class _Drawn:
    """Acceleration, residual and Jacobian of a balance with the error of its motion added again.

    All patterns of inertia are looked at in the same ones, which take longer than anything else of
    a look: they are kept, unless they are many.

    Args:
        solution: The balance.
        noisier: As of `balance_rows`.
    """

    def __init__(self, solution: Balance, noisier: Callable[[], Iterator[System]]) -> None:
        self._solution, self._noisier = solution, noisier
        self._kept: list[tuple[Array, Array, Array]] = []

    def __call__(self) -> Iterator[tuple[Array, Array, Array]]:
        if self._kept:
            yield from self._kept
            return
        drawn: list[tuple[Array, Array, Array]] = []
        room, values = KEPT, self._solution.values
        for system in self._noisier():
            residual = system.y - system.predicted(values[None])[:, 0]
            draw = accelerations(system.logs), residual, system.jacobian(values)
            room -= sum(a.nbytes for a in draw)
            if room >= 0:
                drawn.append(draw)
            yield draw
        if room >= 0:
            self._kept = drawn


def balance_rows(
    solution: Balance,
    estimates: Sequence[Estimate],
    bias: SensorBias | None,
    noisier: Callable[[], Iterator[System]],
) -> ResidualRows:
    """The residual of a solved balance beside its motion.

    The error of the motion leaves a residual, too: what moves a parameter by less than that error
    does is no sign of a term that the model lacks, so half-widths hold both.

    Args:
        solution: The balance.
        estimates: Of all its parameters, in their order.
        bias: What the error of the motion has moved it by.
        noisier: The balance with that error added once more, as `noisier_systems` makes it.
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
        noisier=_Drawn(solution, noisier),
        place=np.arange(len(solution.residuals), dtype=np.int32),
    )
