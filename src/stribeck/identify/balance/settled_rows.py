"""Rows in which the friction of a law with states does not hang on what was before the log.

What an axis did before its log, or in a gap of it, bent its bristles in a way that nobody knows. A
slide wipes that out. Until then a log is taken to begin relaxed, where it shows that it does.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from .regression import System

if TYPE_CHECKING:
    from ...space import Array
    from .rows import Log

#: Friction hangs on what was before where that moves it by more than this share of its level.
_SHARE = 0.02
#: Rows that hang on it count where their residuals are at most so many times those of the others.
_AS_GOOD = 1.5


def settled(system: System, p: Array) -> System:
    """A balance without the rows that hang on what was before, unless they show a relaxed start.

    Args:
        system: Of a law with states.
        p: A complete set near its solution, SI, (k,).
    """
    residuals = system.y - system.predicted(p[None])[:, 0]
    ends = np.cumsum([len(log.t) for log in system.logs])
    parts = np.split(residuals, ends[:-1])
    logs = [_settled(system, log, p, r) for log, r in zip(system.logs, parts, strict=True)]
    if all(a is b for a, b in zip(logs, system.logs, strict=True)):
        return system
    return System(system.parameters, logs)


def rows_of(logs: Sequence[Log], others: Sequence[Log]) -> list[Log]:
    """Logs with the rows that count in others, of the same samples.

    A signal is bridged where the others are: its ends would be as noisy as full-rate samples are.
    Their loads are those of the others, whose recordings are kept anyway: of a noisier copy of a
    long log nothing is left once it is filtered.
    """
    return [
        replace(
            log,
            counts=other.counts,
            t=other.t,
            weight=other.weight,
            loads=other.loads,
            unsure=other.unsure,
        )
        for log, other in zip(logs, others, strict=True)
    ]


def _settled(system: System, log: Log, p: Array, residuals: Array) -> Log:
    if log.path is None:
        return log
    memory = log.path.memory(system.law, p)
    hangs = (memory > _SHARE * memory.max())[log.places]
    if not hangs.any():
        return log
    if hangs.all():
        note = f"{log.label}: no slide wipes out what was before it: it is taken to begin relaxed"
        return log if note in log.notes else replace(log, notes=(*log.notes, note))
    rms = [float(np.sqrt(np.mean(residuals[rows] ** 2))) for rows in (hangs, ~hangs)]
    if rms[0] <= _AS_GOOD * rms[1]:
        return log
    counts = log.counts.copy()
    counts[np.flatnonzero(counts)[hangs]] = False
    seconds = np.count_nonzero(hangs) / log.row_rate
    note = (
        f"{log.label}: {seconds:.3g} s of it do not count, in which friction hangs on what was "
        "before the log or in its gaps"
    )
    return replace(log, counts=counts, t=log.t[~hangs], notes=(*log.notes, note))
