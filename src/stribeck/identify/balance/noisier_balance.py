"""A balance with the error of its motion added once more, by chance, several times.

By what that changes, what the error has changed itself is known: of the estimates (`sensor_bias`),
and of what shows a pattern of inertia.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...data.freed_memory import release
from ...data.resolution import noise_of, step
from ...space import Array
from .regression import System, accelerations
from .rows import filtered_logs
from .settled_rows import rows_of

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from ...data.filtering import Filtering
    from ...data.recording import Recording
    from .balance import Balance
    from .rows import Log, Rows

#: Times that the error is added, and the seed of the chance that draws it.
DRAWS, SEED = 4, 1994
#: Bytes of what is drawn that are kept.
KEPT = 1 << 25


class NoisierRows(NamedTuple):
    """Rows of a balance with the error of the motion added once more.

    Args:
        acceleration: Thinned, as the force is, (rows,).
        residual: Measured less modelled force, (rows,).
        jacobian: Slopes of the modelled force over the free parameters, (rows, free).
    """

    acceleration: Array
    residual: Array
    jacobian: Array


class NoisierBalance:
    """Draws a solved balance's rows with more error: the same ones each time that it is called.

    What moves the estimates is seen in them, and every pattern of inertia is looked at in them, and
    to draw them takes longer than any of these looks: they are kept, unless they are many.

    Args:
        solved: The balance.
        recordings: Its logs.
        rows: Which of their samples count.
    """

    def __init__(
        self, solved: Balance, recordings: Sequence[Recording], rows: Sequence[Rows | None]
    ) -> None:
        self._solved, self._recordings, self._rows = solved, recordings, rows
        self._kept: list[NoisierRows] = []

    def __call__(self) -> Iterator[NoisierRows]:
        """The rows of each draw."""
        if self._kept:
            yield from self._kept
            return
        rng, kept, room = np.random.default_rng(SEED), list[NoisierRows](), KEPT
        for _ in range(DRAWS):
            drawn = self._drawn(rng)
            room -= sum(column.nbytes for column in drawn)
            if room >= 0:
                kept.append(drawn)
            yield drawn
        if room >= 0:
            self._kept = kept

    def _drawn(self, rng: np.random.Generator) -> NoisierRows:
        solved = self._solved
        release(solved.system.samples)  # what a balance and its delay took
        logs = noisier_logs(solved, self._recordings, self._rows, rng)
        system = System(solved.system.parameters, logs)
        J = system.jacobian(solved.values)
        residual = system.y - system.predicted(solved.values[None])[:, 0]
        return NoisierRows(accelerations(logs), residual, J)


def noisier_logs(
    solved: Balance,
    recordings: Sequence[Recording],
    rows: Sequence[Rows | None],
    rng: np.random.Generator,
) -> list[Log]:
    """The filtered logs of a balance with as much error again, at the same rows."""
    noisier = [_noisier(log, solved.system.filtering, rng) for log in recordings]
    logs = filtered_logs(noisier, solved.system.parameters, None, rows)
    return rows_of(logs, solved.system.logs)


def error_of(channel: Array) -> float:
    """Standard deviation of a channel's noise and of its steps."""
    return float(np.hypot(noise_of(channel), step(channel) / np.sqrt(12)))


def _noisier(log: Recording, filtering: Filtering, rng: np.random.Generator) -> Recording:
    """A log with as much error again on its position, and on its velocity where that is used."""
    position = _with_error(log.position, rng)
    if log.velocity is None or filtering.velocity != "recorded":
        return replace(log, position=position)
    return replace(log, position=position, velocity=_with_error(log.velocity, rng))


def _with_error(channel: Array, rng: np.random.Generator) -> Array:
    """A channel with as much error again, in one array that a recording need not copy."""
    noisy = rng.standard_normal(len(channel))
    noisy *= error_of(channel)
    noisy += channel
    noisy.setflags(write=False)
    return noisy
