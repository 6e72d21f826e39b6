"""Channels of several clocks on the grid of one of them.

The grid is the clock of the position. A channel that is slower is interpolated between its samples,
a command is as it was set last; one that is more than one and a half times as fast is averaged over
each interval of the grid, so that less from above half its rate folds down. A grid much faster than
the force is thinned: what is faster in the motion than in the force would be friction or no mass.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ...errors import InputError
from ...space import Array
from ..channels import LARGEST
from ..outliers import force_strays
from ..resampling import averaged, interpolated
from .raw_table import RawTable, listed

#: From how many samples to an interval of the grid on a channel is averaged.
_FASTER = 1.5
_SLACK = 1e-3
#: Samples of a grid to an interval of the force, at most: the low pass of a balance, at a tenth of
#: the grid's rate (`filtering`), then smears a reversal over as many samples of the force as the
#: polynomials between these go through, and rows so near are left out.
_FINEST = 2
#: A turn of an angle that starts anew is a step of this share of its range, at least.
_TURN = 0.5
#: A force is away, and not slow, for so many times its median and its mean interval.
_AWAY = 10.0
#: How many samples a grid has at least.
_FEWEST = 2


def joined(
    tables: Sequence[RawTable], grid: str, held: frozenset[str] = frozenset(), force: str = ""
) -> RawTable:
    """One table on the clock of the channel `grid`; what is beyond all numbers becomes infinite.

    Args:
        tables: A table a clock, in s of one common time.
        grid: Name of a column.
        held: Columns that keep their value until the next sample.
        force: The column of the measured force; empty without one.

    Raises:
        InputError: the clocks have no time in common.
    """
    base = next(table for table in tables if grid in table.columns)
    others = [t for t in tables if t is not base]
    scalars = {n: v for table in tables for n, v in table.scalars.items()}
    others = [t for t in others if t.columns]
    if not others:
        return replace(base, scalars=scalars)
    if base.t is None or any(t.t is None for t in others):
        raise InputError(f"{listed([grid])} and other channels share no clock: name fewer channels")
    for table in (base, *others):
        if table.t is None or not np.isfinite(table.t).any():
            raise InputError(f"no samples of {listed(list(table.columns))}: name other channels")
    base = _thinned(base, next((t for t in others if force in t.columns), None), grid)
    assert base.t is not None  # noqa: S101 - as was checked
    rows = _common(base, others)
    columns = {n: a[rows] for n, a in base.columns.items()}
    others = [_without_strays(other, force) for other in others]
    notes = [note for table in (base, *others) for note in table.notes]
    for other in others:
        with np.errstate(over="ignore", invalid="ignore"):
            columns |= {
                n: _resampled(base.t[rows], other, n, hold=n in held) for n in other.columns
            }
            if force in other.columns:
                columns[force][_away(base.t[rows], other, force)] = np.nan
        notes.append(_sentence(base, other, held))
    return replace(
        base, columns=columns, t=base.t[rows], places=base.places[rows], scalars=scalars,
        text={n: c for table in tables for n, c in table.text.items()},
        units={n: u for table in tables for n, u in table.units.items()}, notes=tuple(notes),
    )  # fmt: skip


def _thinned(base: RawTable, forces: RawTable | None, grid: str) -> RawTable:
    """The base with so few samples to one of the force, where that is in a slower table."""
    if forces is None:
        return base
    assert base.t is not None  # noqa: S101 - as was checked
    assert forces.t is not None  # noqa: S101 - as was checked
    own, finest = (1.0 + _SLACK) * _interval(forces.t), _FINEST * _interval(base.t)
    if not 0.0 < 2.0 * finest <= own <= finest * len(base.t) / _FEWEST:
        return base
    position = base.columns[grid][np.isfinite(base.columns[grid])]
    if not len(position):
        return base  # which is told where it is taken
    with np.errstate(over="ignore", invalid="ignore"):
        turns = np.abs(np.diff(position)).max(initial=0.0) > _TURN * np.ptp(position)
    if turns:  # what is left out of an angle that starts anew cannot be unwrapped
        return base
    every = int(own / finest)
    first = int(np.searchsorted(base.t, forces.t[0] - _SLACK * _interval(base.t))) % every
    rows = slice(first, None, every)
    note = f"{listed([grid])}: one of {every} samples is read, as the force is slower"
    return replace(
        base, columns={n: a[rows] for n, a in base.columns.items()}, t=base.t[rows],
        places=base.places[rows], notes=(*base.notes, note),
    )  # fmt: skip


def _common(base: RawTable, others: Sequence[RawTable]) -> slice:
    """Rows of the base at which all others were recorded."""
    assert base.t is not None  # noqa: S101 - as was checked
    since = max(float(np.nanmin(t.t)) for t in others if t.t is not None)
    until = min(float(np.nanmax(t.t)) for t in others if t.t is not None)
    slack = _SLACK * _interval(base.t)  # times are rounded
    first = np.searchsorted(base.t, since - slack)
    last = np.searchsorted(base.t, until + slack, side="right")
    if last - first < _FEWEST:
        spans = [_span(table) for table in (base, *others)]
        raise InputError(
            f"its channels have no time in common: {'; '.join(dict.fromkeys(spans))}: log them "
            "in one session, or choose channels that were"
        )
    return slice(int(first), int(last))


def _span(table: RawTable) -> str:
    """What was measured when."""
    assert table.t is not None  # noqa: S101 - as was checked
    first, last = float(np.nanmin(table.t)), float(np.nanmax(table.t))
    return f"{listed(list(table.columns), 3)} from {first:.6g} to {last:.6g} s"


def _resampled(grid: Array, other: RawTable, name: str, *, hold: bool) -> Array:
    """A column at the instants of the grid; infinite beside a sample that is."""
    assert other.t is not None  # noqa: S101 - as was checked
    column = other.columns[name]
    finite = np.isfinite(column) & np.isfinite(other.t)
    t, values = other.t[finite], column[finite]
    if len(t) == 0:
        return np.full(len(grid), np.nan)
    if hold:
        resampled = values[np.maximum(np.searchsorted(t, grid, side="right") - 1, 0)]
    elif _interval(t) * _FASTER < _interval(grid):
        resampled = averaged(grid, t, values)
    else:
        resampled = interpolated(grid, t, values)
    infinite = other.t[np.isinf(column) & np.isfinite(other.t)]
    resampled[np.minimum(np.searchsorted(grid, infinite), len(grid) - 1)] = np.inf
    return resampled


def _away(grid: Array, other: RawTable, name: str) -> NDArray[np.bool_]:
    """Where a column was not measured for long, (n,)."""
    assert other.t is not None  # noqa: S101 - as was checked
    t = other.t[np.isfinite(other.columns[name]) & np.isfinite(other.t)]
    if len(t) < 2:  # noqa: PLR2004 - an interval
        return np.zeros(len(grid), dtype=bool)
    usual = max(_interval(t), float(t[-1] - t[0]) / (len(t) - 1))
    long = np.concatenate([[False], np.diff(t) > _AWAY * usual, [False]])
    after = np.searchsorted(t, grid)
    return np.asarray(long[after] & (t[np.minimum(after, len(t) - 1)] > grid))


def _without_strays(other: RawTable, force: str) -> RawTable:
    """A table whose force lacks single wild samples, which would spread over those around."""
    if force not in other.columns:
        return other
    finite = np.flatnonzero(np.isfinite(other.columns[force]))
    if not len(finite) or np.abs(other.columns[force][finite]).max() > LARGEST:
        return other  # is refused with its place
    wild = finite[force_strays(other.columns[force][finite])]
    if not len(wild):
        return other
    column = other.columns[force].copy()
    column[wild] = np.nan
    several = f"{len(wild)} wild samples" if len(wild) > 1 else "1 wild sample"
    note = f"{several} of {listed([force])} left out, first in {other.place(int(wild[0]))}"
    return replace(other, columns={**other.columns, force: column}, notes=(*other.notes, note))


def _interval(t: Array) -> float:
    return float(np.median(np.diff(t))) if len(t) > 1 else np.inf


def _sentence(base: RawTable, other: RawTable, held: frozenset[str]) -> str:
    """How channels of another clock were brought onto the grid."""
    assert base.t is not None  # noqa: S101 - as was checked
    assert other.t is not None  # noqa: S101 - as was checked
    names = list(other.columns)
    own, grid = _interval(other.t), _interval(base.t)
    if own * _FASTER < grid:
        how = f"averaged over the {1e3 * grid:.4g} ms between positions"
    elif held.issuperset(names):
        how = "held until the next sample"
    else:
        how = "interpolated between its samples"
    return f"{listed(names)}, measured each {1e3 * own:.4g} ms: {how}"
