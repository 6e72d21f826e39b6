"""From an opened log to channels: chosen, on one clock, in SI, mended, with notes on it all."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ...errors import ChoiceError, InputError
from ...space import Array
from ..channels import CHANNELS
from ..known_force import KnownForce
from ..resampling import integral
from .budget import CELL, ReadBudget
from .choice import Choice
from .column_map import Entry
from .columns import Heads, is_there, named_column
from .heads import named_by_stem
from .joined import joined
from .log_file import LogFile, LogInParts
from .log_map import LogMap
from .log_span import LogSpan, no_samples
from .raw_table import RawTable, listed, shortened
from .repair import Mender, filled_extra
from .slower_columns import by_rate
from .steady_table import chosen_columns, is_steady, steady_arguments

#: Cells that are kept beside the channels, for whoever names them later.
_EXTRAS = (1 << 30) // CELL
#: Samples by which the first one is after zero before that is told.
_LATE = 10
#: Channels that keep their value until the next sample.
_HELD = ("command",)
#: What messages call the force that is taken off the measured one.
_KNOWN = "the force to subtract"
#: What a map may say.
KNOWN = ("time", *CHANNELS)


class Assembly(NamedTuple):
    """What a log came to.

    Args:
        arguments: Of its `Recording`, but for the source.
        rows: Rows of the table that they are from.
        columns: Channel -> column, all that were taken.
        signal: The column that its force is made of by a drive chain; empty without one.
    """

    arguments: dict[str, Any]
    rows: int
    columns: dict[str, Entry]
    signal: str = ""


def assembled(
    log: LogFile,
    used: LogMap,
    window: tuple[float, float] | None = None,
    budget: ReadBudget | None = None,
    *,
    units: Mapping[str, str] | None = None,
    lenient: bool = False,
    others: Collection[str] = (),
) -> Assembly:
    """The arguments of a `Recording`, but for its source.

    Args:
        log: What a reader opened, or a frame.
        used: Channel -> column, where the heads do not say it, and what else they do not.
        window: Of the log, s from its start.
        budget: Of the read; None for arrays that are in memory.
        units: Unit by column, where the heads do not say it.
        lenient: Whether a mapped column that is not there is no reason to refuse; time and
            position must be.
        others: Heads of columns that are no channels, whatever they are called.

    Raises:
        ChoiceError: a column that is needed is not there or has no unit.
        InputError: the rows are no log.
    """
    if log.lacking:
        raise ChoiceError(log.lacking)
    timed = any(c.clock for c in log.channels) or used.rate is not None
    heads = Heads.of(log, used.joint, units or {}, timed=timed, drive=used.drive)
    heads = replace(heads, bare={n: b for n, b in heads.bare.items() if n not in others})
    mapped = _present(heads, used.columns) if lenient else used.columns
    try:
        chosen, notes = chosen_columns(heads, mapped)
    except InputError as error:
        raise ChoiceError(str(error)) from error
    known = None if used.subtract is None else _known_force(heads, used.subtract, chosen)
    wanted = {c.column for c in chosen.values()} | ({known.column} if known else set())
    wanted |= {c.factor for c in chosen.values() if isinstance(c.factor, str)}
    grid = (chosen.get("position") or chosen["velocity"]).column
    steady = is_steady(heads, chosen)
    if steady and window is not None:
        raise InputError("is a table of steady speeds, without times: give it as a whole")
    span = None if steady else LogSpan.of(heads, wanted, grid, chosen)
    table = _table(log, heads, wanted, grid, chosen, _Wanted(span, window))
    if "time" not in chosen and table.t is None and used.rate is not None:
        table = replace(table, t=np.arange(len(table.places)) / used.rate)
    if budget is not None:  # a scalar becomes a column
        budget.take_cells(len(table.places), len(table.columns) + len(table.scalars))
    if steady:
        if known is not None:
            raise InputError("is a table of steady speeds: give forces without what is to be "
                             "subtracted")  # fmt: skip
        arguments = steady_arguments(table, chosen, (*notes, *log.problems))
    else:
        arguments = _mended(table, chosen, (*notes, *log.problems), _Wanted(span, window), known)
    columns = {n: e for n, c in chosen.items() if n in KNOWN and (e := c.entry())}
    signal = chosen["force"].column if used.drive and "force" in chosen else ""
    rows = len(table.places) if span is None else span.rows
    return Assembly(arguments, rows, columns, signal)


def _known_force(heads: Heads, entry: str, chosen: Mapping[str, Choice]) -> Choice:
    """The column of a force that is taken off the measured one.

    Raises:
        InputError: there is no such column, or it is not in a unit of the force.
    """
    force = chosen.get("force")
    if force is None:
        raise InputError("subtract: no column is the force that it is taken off: map one to force")
    column, written = named_column(heads, entry)
    column = column or named_by_stem(entry, heads.columns)
    if column is None:
        raise InputError(
            f"subtract: there is no column {shortened(entry)!r}: there are {listed(heads.columns)}"
        )
    written = written or heads.head(column).unit
    if written is None:
        raise InputError(
            f'subtract: column {shortened(column)} has no unit: write it as "{shortened(column)} '
            f'[{force.unit.written}]"'
        )
    choice = Choice(
        column, heads.unit("force", column, written), reason="subtracted from the force"
    )
    if choice.unit.dimension != force.unit.dimension:
        raise InputError(
            f"subtract: column {shortened(column)} is in {written}, and the force in "
            f"{force.unit.written}: subtract a force"
        )
    if column == force.column:
        raise InputError(f"subtract: column {shortened(column)} is the force itself")
    return choice


class _Wanted(NamedTuple):
    """The part of a log that is wanted: its span, if that is known, and s from its begin."""

    span: LogSpan | None
    window: tuple[float, float] | None


def _table(
    log: LogFile,
    heads: Heads,
    wanted: set[str],
    grid: str,
    chosen: Mapping[str, Choice],
    part: _Wanted,
) -> RawTable:
    """The columns that are used, and others as long as these are few, on one clock.

    Of a window no more than its rows and some beside them are read, where the log can tell them.
    """
    tables, everything = _tables(log, heads, wanted, part)
    time = chosen.get("time")
    tables = tuple(t for table in tables for t in by_rate(table, time, grid, wanted))
    apart = [t for t in tables if grid in t.columns or wanted.intersection(t.columns)]
    others = {n: v for t in tables for n, v in t.scalars.items()}
    held = frozenset(chosen[c].column for c in _HELD if c in chosen)
    apart = [
        t if grid in t.columns else replace(
            t, columns={n: a for n, a in t.columns.items() if n in wanted}
        )
        for t in apart
    ]  # fmt: skip
    force = chosen["force"].column if "force" in chosen else ""
    table = replace(joined(apart, grid, held, force), scalars=others)
    table = replace(table, columns=dict(table.columns))  # its own, from which they are taken
    left = [n for n in heads.columns if n not in table.columns]
    if left and not everything:
        note = f"{len(left)} columns that no channel needs were left out"
        table = replace(table, notes=(*table.notes, note))
    return table


def _tables(
    log: LogFile, heads: Heads, wanted: set[str], part: _Wanted
) -> tuple[tuple[RawTable, ...], bool]:
    """The columns that are used, and others as long as these are few, and whether they are.

    Raises:
        InputError: they take too much memory, or are broken.
    """
    span, window = part
    rows = max((c.count for c in heads.columns.values()), default=0)
    if span is None or window is None or not isinstance(log, LogInParts):
        everything = rows * len(heads.columns) <= _EXTRAS
        if span is not None and not everything:
            span.refuse_much(rows, len(wanted))
        return log.tables(None if everything else {*wanted, *heads.scalars}), everything
    rows = span.rows_in(window)
    everything = rows * len(heads.columns) <= _EXTRAS
    if not everything:
        span.refuse_much(rows, len(wanted))
    names = {*heads.columns, *heads.scalars} if everything else {*wanted, *heads.scalars}
    return log.part(names, span.interval(window)), everything


def _present(heads: Heads, mapped: Mapping[str, Entry]) -> dict[str, Entry]:
    """The mapping without channels whose column is not there; time and position must be."""
    return {
        channel: entry
        for channel, entry in mapped.items()
        if channel in ("time", "position") or is_there(heads, entry)
    }


def _mended(
    table: RawTable,
    chosen: Mapping[str, Choice],
    notes: tuple[str, ...],
    part: _Wanted,
    known: Choice | None,
) -> dict[str, Any]:
    """Channels and other columns in SI from the chosen columns, their defects mended and told."""
    channels = _taken(table, chosen, known)
    if "time" not in channels:
        assert table.t is not None  # noqa: S101 - a log without times has a rate
        channels = {"time": table.t, **channels}
    begin = _begin(channels["time"]) if part.span is None else part.span.first
    mender = Mender(table, channels, {}, list(table.notes))
    if "position" not in channels:
        mender.channels = {**channels, "position": _integral(channels)}
        mender.notes.append(
            f"position is the integral of {shortened(chosen['velocity'].column)}, from 0: it "
            "drifts, and nothing that depends on position can be told"
        )
    del channels  # what the mender replaces is no longer needed
    mender.extra = filled_extra(table, {c.column for c in chosen.values()})
    if table.text:
        several = len(table.text) > 1
        left = f"column{'s' * several} {listed(table.text)} left out"
        mender.notes.append(f"{left}: {'they have' if several else 'it has'} text")
    mender.mend()
    t = mender.channels.pop("time")
    since = float(t[0]) if part.window is None else begin
    if abs(since) > _LATE * float(np.median(np.diff(t))):
        mender.notes.append(f"time counts from the first sample, {since:.9g} s on the log's clock")
    rows = _rows(t - since, part)
    force = None
    if known is not None:
        force = KnownForce.of(known.column, known.unit, mender.channels.pop(_KNOWN)[rows])
        mender.notes.append(force.sentence)
    return {
        "t": _sealed(t[rows] - t[rows][0], slice(0, rows.stop - rows.start)),
        **{name: _sealed(values, rows) for name, values in mender.channels.items()},
        "extra": {name: values[rows] for name, values in mender.extra.items()},
        "known_force": force,
        "rotary": (chosen.get("position") or chosen["velocity"]).rotary,
        "notes": (*mender.notes, *(n for n in notes if n not in mender.notes), *_scaled(chosen)),
    }


def _integral(channels: Mapping[str, Array]) -> Array:
    """Positions from velocities, from 0; nan where one of both is missing."""
    t, v = channels["time"], channels["velocity"]
    valid = np.isfinite(t) & np.isfinite(v)
    x = np.full(len(t), np.nan)
    x[valid] = integral(t[valid], v[valid])
    return x


def _taken(table: RawTable, chosen: Mapping[str, Choice], known: Choice | None) -> dict[str, Array]:
    """The channels in SI; a column that no other needs leaves its table, and its memory."""
    order = [(name, chosen[name]) for name in ("time", *CHANNELS) if name in chosen]
    order += [] if known is None else [(_KNOWN, known)]
    channels: dict[str, Array] = {}
    for k, (name, choice) in enumerate(order):
        channels[name] = choice.values(table)
        later = {n for _, c in order[k + 1 :] for n in (c.column, c.factor)}
        if isinstance(table.columns, dict) and choice.column not in later:
            table.columns.pop(choice.column, None)
    return channels


def _sealed(values: Array, rows: slice) -> Array:
    """An array of a recording's own: all of one that nobody else has, or a copy of a part."""
    if rows.start or rows.stop < len(values) or values.base is not None:
        values = values[rows].copy()
    values.setflags(write=False)
    return values


def _begin(t: Array) -> float:
    """The first instant of a log."""
    finite = t[np.isfinite(t)]
    return float(finite[0]) if len(finite) else 0.0


def _rows(t: Array, part: _Wanted) -> slice:
    """The samples of a window, s from the start.

    Raises:
        InputError: there are fewer than two.
    """
    span, window = part
    if window is None:
        return slice(0, len(t))
    tolerance = 1e-6 * float(np.median(np.diff(t)))
    first, last = np.searchsorted(t, [end - tolerance for end in window])
    if last - first < 2:  # noqa: PLR2004 - a motion needs two
        seconds = float(t[-1]) if span is None else span.seconds
        raise InputError(no_samples(window, int(last - first), seconds))
    return slice(int(first), int(last))


def _scaled(chosen: Mapping[str, Choice]) -> list[str]:
    """A word on a force that is another quantity times a number."""
    force = chosen.get("force")
    if force is None or isinstance(force.factor, str) or abs(force.factor) == 1:
        return []
    note = (
        f"force is {shortened(force.column)} times {force.factor:g}: every parameter of force and "
        "mass scales with that factor, and is no better known than it is"
    )
    return [note]
