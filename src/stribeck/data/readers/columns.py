"""The channel of each column: by the mapping where there is one, by its head elsewhere."""

from __future__ import annotations

import re
import sys
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import InputError
from ...space import Array
from ...text_file import page
from ...units import Unit, unit
from ..channels import CHANNELS
from .heads import Head, meanings, take_apart
from .raw_table import RawTable, listed, printable, shortened

#: One entry of a mapping: "head", "head [unit]", or a table of column, unit and factor.
Entry = str | Mapping[str, str | float]

_LENGTH, _ANGLE = "m", "rad"
_ALSO = {"rad/s": "1/s", "rad/s**2": "1/s**2"}  # an angle may go unsaid
_EXAMPLE = {"time": "t [s]", "position": "x [mm]"}


@dataclass(frozen=True)
class Choice:
    """The column of a channel: SI value = unit.to_si(factor * cell); a factor may be a column."""

    column: str
    unit: Unit
    factor: float | str = 1.0

    def values(self, table: RawTable) -> Array:
        """The channel in SI, NaN where a cell is empty.

        Raises:
            InputError: the column has text, or its factor is not there.
        """
        for name in (self.column, self.factor):
            if name in table.text:
                row, cell = table.text[str(name)]
                raise InputError(
                    f"{table.place(row)}, column {shortened(str(name))}: {shortened(cell)!r} is "
                    "not a number: correct it or empty the cell"
                )
        with np.errstate(over="ignore", invalid="ignore"):  # infinities are refused, with their row
            return np.asarray(self.unit.to_si(_cells(table, self.column) * self._scale(table)))

    def _scale(self, table: RawTable) -> float | Array:
        return _cells(table, self.factor) if isinstance(self.factor, str) else self.factor


def mapping(columns: Mapping[str, Any] | str | Path | None) -> Mapping[str, Entry]:
    """A mapping from a dict or a TOML file (its `[columns]` table, or the whole of it).

    Raises:
        InputError: the file is missing or not TOML, a key is no channel, an entry makes no sense.
    """
    if columns is None:
        return {}
    if isinstance(columns, Mapping):
        name, read = "columns", columns
    else:
        name, read = _toml(Path(columns))
    for channel, entry in read.items():
        if channel not in ("time", *CHANNELS):
            raise InputError(f"{name}: no channel {shortened(str(channel))!r}: there are time, "
                             f"{', '.join(CHANNELS)}")  # fmt: skip
        _checked(f"{name}: {channel}", entry)
    return read


def _toml(file: Path) -> tuple[str, Mapping[str, Entry]]:
    name = printable(file.name)
    try:
        read = tomllib.loads(page(file))
    except InputError as error:
        raise InputError(f"{name}: cannot read the mapping: {error}") from error
    except (ValueError, RecursionError) as error:  # TOML and UTF-8 errors are ValueErrors
        raise InputError(f"{name}: the mapping is not TOML: {printable(str(error))}") from error
    table = read.get("columns", read)
    if not isinstance(table, dict):
        raise InputError(f'{name}: columns must be a table such as position = "x [mm]"')
    if not table:
        raise InputError(f'{name}: the mapping is empty: write position = "x [mm]", say')
    return name, table


def _checked(place: str, entry: object) -> None:
    if isinstance(entry, str):
        return
    if not isinstance(entry, Mapping) or not isinstance(entry.get("column"), str):
        raise InputError(f'{place}: write "head [unit]" or {{column = "head", unit = "N"}}')
    if odd := set(entry) - {"column", "unit", "factor"}:
        raise InputError(f"{place}: {min(map(str, odd))!r} is none of column, unit, factor")
    if not isinstance(entry.get("unit", ""), str):
        raise InputError(f'{place}: the unit must be text such as "mm"')
    factor = entry.get("factor", 1.0)
    number = isinstance(factor, (int, float)) and not isinstance(factor, bool)
    # TOML has integers of any length: none that no float can be is a factor.
    if not isinstance(factor, str) and not (number and 0 < abs(factor) <= sys.float_info.max):
        raise InputError(f"{place}: factor must be a number other than 0, or a column's name")


def choose(table: RawTable, mapped: Mapping[str, Entry]) -> tuple[dict[str, Choice], list[str]]:
    """Channel -> column for a table, time and position first, and notes on what found no place.

    A column is a candidate for a channel if its name says so and its unit fits. Names that say
    *measured* go before plain ones, plain before commanded; two candidates of one rank are
    refused. A mapped channel takes what the mapping says; its column serves no other channel
    unless that is mapped too.

    Raises:
        InputError: no time or position, an unknown or unfit unit, or two columns for a channel.
    """
    chosen = {channel: _mapped(table, channel, entry) for channel, entry in mapped.items()}
    for channel, c in chosen.items():
        _fitting(channel, c, _kinds(channel))
    used = {c.column for c in chosen.values()}
    heads = {h: _head(table, h) for h in table.columns if h not in used}
    for channel in ("time", "position"):
        if channel not in chosen:
            chosen[channel] = _needed(table, heads, channel, _kinds(channel), chosen)
    rotary = chosen["position"].unit.dimension == _ANGLE
    for channel in (n for n in CHANNELS if n not in chosen):
        if candidates := _ranked(heads, channel, _kinds(channel, rotary=rotary)):
            chosen[channel] = candidates
    for channel, c in chosen.items():
        _fitting(channel, c, _kinds(channel, rotary=rotary))
    return chosen, list(_unfit(heads, chosen))


def _kinds(channel: str, *, rotary: bool | None = None) -> tuple[str, ...]:
    """The dimensions that fit a channel, in SI units."""
    if channel == "time":
        return ("s",)
    linear, angular = (unit(u).dimension for u in CHANNELS[channel])
    kinds = {None: (linear, angular), True: (angular,), False: (linear,)}[rotary]
    return kinds + tuple(_ALSO[k] for k in kinds if k in _ALSO)


def _head(table: RawTable, written: str) -> Head:
    head = take_apart(written)
    return Head(head.stem, table.units.get(written, head.unit))


def is_there(table: RawTable, entry: Entry) -> bool:
    """Whether a table has the column that an entry of a mapping names."""
    column = str(entry if isinstance(entry, str) else entry["column"])
    bare = re.fullmatch(r"(.*?)\s*\[([^\[\]]*)\]\s*", column)
    return any(c in table.columns or c in table.scalars for c in (column, bare[1] if bare else ""))


def _mapped(table: RawTable, channel: str, entry: Entry) -> Choice:
    if isinstance(entry, str):
        entry = {"column": entry}
    column, written = str(entry["column"]), entry.get("unit")
    if column not in table.columns and column not in table.scalars:
        bare = re.fullmatch(r"(.*?)\s*\[([^\[\]]*)\]\s*", column)
        if not bare or bare[1] not in table.columns:
            raise InputError(
                f"the mapping says {channel} = {shortened(column)!r}, but there is no such column: "
                f"there are {listed({**table.columns, **table.scalars})}"
            )
        column, written = bare[1], written or bare[2]
    if written is None:
        written = _head(table, column).unit
    if written is None:
        raise InputError(_unmapped_unit(table, column, channel))
    factor = entry.get("factor", 1.0)
    if isinstance(factor, str) and factor not in {**table.columns, **table.scalars}:
        raise InputError(f"the mapping says {channel} has the factor {shortened(factor)!r}, but "
                         "there is no such column or number")  # fmt: skip
    return Choice(column, _unit(channel, column, str(written)), factor)


def _unmapped_unit(table: RawTable, column: str, channel: str) -> str:
    name, example = shortened(column), _unit_of(channel)
    if table.in_memory:
        return f'column {name} has no unit: say it, as in units={{"{name}": "{example}"}}'
    return f'column {name} has no unit: map it as {channel} = "{name} [{example}]"'


def _needed(
    table: RawTable,
    heads: Mapping[str, Head],
    channel: str,
    kinds: tuple[str, ...],
    chosen: Mapping[str, Choice],
) -> Choice:
    """The column of time or position, or why there is none."""
    if candidates := _ranked(heads, channel, kinds):
        return candidates
    named = [h for h, head in heads.items() if channel in meanings(head)]
    if bare := [h for h in named if heads[h].unit is None]:
        raise InputError(_without_unit(table, heads, bare[0], channel, chosen))
    for h in named:
        _fitting(channel, Choice(h, _unit(channel, h, heads[h].unit or "")), kinds)
    key = f'"{channel}":' if table.in_memory else f"{channel} ="
    raise InputError(
        f"no {channel} column among {listed(table.columns) or 'none'}: name it like "
        f'"{_EXAMPLE[channel]}" or map it: columns = {{{key} "head [{_unit_of(channel)}]"}}'
    )


def _without_unit(
    table: RawTable,
    heads: Mapping[str, Head],
    first: str,
    channel: str,
    chosen: Mapping[str, Choice],
) -> str:
    lacking = {channel: shortened(first)}
    # Of a file the channels that it cannot do without are said at once, of a frame all of them.
    others = CHANNELS if table.in_memory else ["position"] if channel == "time" else []
    for other in (c for c in others if c not in {*chosen, *lacking}):
        bare = [h for h, head in heads.items() if other in meanings(head) and not head.unit]
        if bare and shortened(bare[0]) not in lacking.values():
            lacking[other] = shortened(bare[0])
    *rest, last = lacking.values()
    names, several = f"{', '.join(rest)} and {last}" if rest else last, "s" * bool(rest)
    if table.in_memory:
        units = ", ".join(f'"{h}": "{_unit_of(c)}"' for c, h in lacking.items())
        return f"column{several} {names} without a unit: say it, as in units={{{units}}}"
    fix = ", ".join(f'{c} = "{h} [{_unit_of(c)}]"' for c, h in lacking.items())
    return (
        f"column{several} {names} without a unit: write it in the head, as in "
        f"{lacking[channel]} [{_unit_of(channel)}], or map it: columns = {{{fix}}}"
    )


def _ranked(heads: Mapping[str, Head], channel: str, kinds: tuple[str, ...]) -> Choice | None:
    """The best candidate by name and unit."""
    ranked = []
    for h, head in heads.items():
        rank = meanings(head).get(channel)
        if rank is not None and head.unit is not None and (u := _known(channel, head.unit)):
            ranked += [(rank, h, u)] * (u.dimension in kinds)
    if not ranked:
        return None
    best = min(rank for rank, _, _ in ranked)
    first, *rivals = [(h, u) for rank, h, u in ranked if rank == best]
    if rivals:
        a, b = shortened(first[0]), shortened(rivals[0][0])
        raise InputError(
            f"columns {a} and {b} both look like the {channel}: map one, as in columns = "
            f'{{{channel} = "{a}"}}'
        )
    return Choice(*first)


def _unit(channel: str, column: str, written: str) -> Unit:
    try:
        return unit(_spelt(channel, written))
    except InputError as error:
        raise InputError(f"column {shortened(column)}: {error}") from error


def _known(channel: str, written: str) -> Unit | None:
    try:
        return unit(_spelt(channel, written))
    except InputError:
        return None


def _spelt(channel: str, written: str) -> str:
    """C is the coulomb, except that nobody logs a temperature in coulombs."""
    return {"C": "degC"}.get(written, written) if channel == "temperature" else written


def _fitting(channel: str, choice: Choice, kinds: tuple[str, ...]) -> None:
    if choice.unit.dimension not in kinds:
        column, written = shortened(choice.column), shortened(choice.unit.written)
        raise InputError(
            f"column {column} is in {written or 'no unit'}, which does not measure "
            f"{_kind_words(channel, kinds)}: map it as {channel} = "
            f'{{column = "{column}", factor = ..., unit = "{_unit_of(channel)}"}}'
        )


def _kind_words(channel: str, kinds: tuple[str, ...]) -> str:
    words = {"m": "a length", "rad": "an angle", "s": "time"}
    if channel in ("position", "command", "time"):
        return " or ".join(words[k] for k in kinds)
    return f"the {channel} of {'an angular' if 'rad' in kinds[0] else 'this'} axis"


def _unit_of(channel: str) -> str:
    return {"time": "s", "position": "mm", "command": "mm"}.get(channel) or CHANNELS[channel][0]


def _unfit(heads: Mapping[str, Head], chosen: Mapping[str, Choice]) -> list[str]:
    """A word on each empty channel that a column names in vain."""
    used = {c.column for c in chosen.values()}
    notes = []
    for channel in CHANNELS:
        named = [h for h, head in heads.items() if channel in meanings(head) and h not in used]
        if channel not in chosen and named:
            reason = (
                "has no unit" if heads[named[0]].unit is None else "is in a unit that does not fit"
            )
            notes.append(f"column {shortened(named[0])} {reason} and was not taken as {channel}")
    return notes


def _cells(table: RawTable, name: str) -> Array:
    return (
        table.columns[name]
        if name in table.columns
        else np.full(len(table.places), table.scalars[name])
    )
