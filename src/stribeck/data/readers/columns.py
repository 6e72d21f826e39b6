"""The channel of each column: by the mapping where there is one, by its head elsewhere."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace

from ...drive import DriveChain
from ...errors import InputError
from ...units import Unit, unit
from ...wording import either, is_command_line, option
from ..channels import CHANNELS
from .choice import (
    Choice,
    kinds_of,
    refuse_unfit,
    says_turn,
    unit_of_column,
    usual_unit,
)
from .column_map import Entry
from .heads import Head, meanings, take_apart
from .log_file import Channel, LogFile
from .raw_table import listed, shortened
from .signal_choice import signal_of
from .stamps import Epoch, epoch

#: What is said beside an example in mm.
_TURNING = " (rad, deg or rev where it turns)"
#: Names that a refusal lists; the command line shows all of them above it.
_NAMED = 6


@dataclass(frozen=True)
class Heads:
    """The names in a log from which channels are chosen.

    Args:
        columns: Name -> channel, in the order of the file.
        scalars: The same of single numbers.
        timed: Whether the log has times of its own, so that no column has to.
        bare: Name -> the name without the joint that was asked for; columns of another joint or of
            none, but for times, are not in it.
        order: All names, as `contents` numbers them.
        drive: The chain from what the drive recorded to the force at the axis.
    """

    columns: Mapping[str, Channel]
    scalars: Mapping[str, Channel]
    timed: bool
    bare: Mapping[str, str]
    order: tuple[str, ...] = ()
    drive: DriveChain | None = None

    @classmethod
    def of(
        cls,
        log: LogFile,
        joint: str | None,
        units: Mapping[str, str],
        *,
        timed: bool,
        drive: DriveChain | None = None,
    ) -> Heads:
        """Those of a log, with units that the caller states.

        Raises:
            InputError: no channel names the joint, or a unit is of no channel or no text.
        """
        channels = [replace(c, unit=units.get(c.name, c.unit)) for c in log.channels]
        columns = {c.name: c for c in channels if not c.constant}
        for name, written in units.items():
            if all(name != c.name for c in channels):
                names = listed([c.name for c in channels])
                raise InputError(f"units: no column {shortened(str(name))!r}: there are {names}")
            if not isinstance(written, str):
                raise InputError(f'units: {shortened(name)}: the unit must be text such as "mm"')
        return cls(
            columns,
            {c.name: c for c in channels if c.constant},
            timed,
            _bare(columns, joint),
            tuple(c.name for c in channels),
            drive,
        )

    def unit(self, channel: str, column: str, written: str) -> Unit:
        """What a column is in, at the axis.

        Raises:
            InputError: nobody knows it, or how to get to the axis from there.
        """
        try:
            through = self.drive.resolved(channel, written) if self.drive else None
        except InputError as error:
            raise InputError(f"column {shortened(column)} {error}") from error
        return through or unit_of_column(channel, column, written)

    def known(self, channel: str, written: str) -> Unit | None:
        """The same, None if nobody knows it."""
        try:
            return self.unit(channel, "", written)
        except InputError:
            return None

    def kinds(self, channel: str, *, rotary: bool | None = None) -> tuple[str, ...]:
        """The dimensions that fit a channel, in SI units; a drive's force may be a current."""
        kinds = kinds_of(channel, rotary=rotary)
        if channel == "force" and self.drive is not None and self.drive.unit == "A":
            kinds += (unit(self.drive.unit).dimension,)
        return kinds

    def head(self, written: str) -> Head:
        """The name and unit of a column, its joint left out."""
        head = take_apart(self.bare.get(written, written))
        channel = self.columns.get(written) or self.scalars.get(written)
        stated = None if channel is None else channel.unit
        return Head(head.stem, stated or head.unit)

    def there(self, column: str) -> str | None:
        """The name that a column goes by: its own, or its number in the file; None if none."""
        if column in self.columns or column in self.scalars:
            return column
        if column.isdecimal() and 1 <= int(column) <= len(self.order):
            return self.order[int(column) - 1]
        return None


def _bare(columns: Mapping[str, Channel], joint: str | None) -> dict[str, str]:
    """Name -> the name without the joint, of what may be a channel."""
    bare = {n: n for n in columns} if joint is None else _of_joint(columns, joint)
    return {n: name for n, name in bare.items() if not columns[n].is_time}


def _of_joint(columns: Mapping[str, Channel], joint: str) -> dict[str, str]:
    """Columns that name a joint, without it; and those that are times."""
    own = re.escape(joint)
    token = rf"(?<!\d)0*{own}(?!\d)" if joint.isdecimal() else rf"(?<![^\W_]){own}(?![^\W_])"
    search = re.compile(rf"[\W_]*{token}[\])}}]*", re.IGNORECASE)
    bare = {n: search.sub("_", n, count=1).strip("_") for n in columns if search.search(n)}
    if not bare:
        raise InputError(
            f"no column names the joint {shortened(joint)}: there are {listed(list(columns))}"
        )
    times = {n: n for n in columns if "time" in meanings(take_apart(n)) and n not in bare}
    return times | bare


def choose(heads: Heads, mapped: Mapping[str, Entry]) -> tuple[dict[str, Choice], list[str]]:
    """Channel -> column, time and position first, and notes on what found no place.

    A column is a candidate for a channel if its name says so and its unit fits. Names that say
    *measured* go before plain ones, plain before commanded; two candidates of one rank are
    refused. A mapped channel takes what the mapping says; its column serves no other channel
    unless that is mapped too. A log with a velocity and no position has none: it is the integral.

    Raises:
        InputError: no time or position, an unknown or unfit unit, or two columns for a channel.
    """
    chosen = {channel: mapped_choice(heads, channel, entry) for channel, entry in mapped.items()}
    for channel, c in chosen.items():
        refuse_unfit(channel, c, heads.kinds(channel))
    used = {c.column for c in chosen.values()}
    names = {h: heads.head(h) for h in heads.columns if h not in used and h in heads.bare}
    for channel in ("time", "position"):
        if channel in chosen or (channel == "time" and heads.timed):
            continue
        if channel == "position" and (velocity := _velocity(heads, names, chosen)):
            chosen["velocity"] = velocity
            continue
        chosen[channel] = _needed(heads, names, channel, kinds_of(channel), chosen)
    first = chosen.get("position") or chosen["velocity"]
    rotary = first.rotary
    for channel in (n for n in CHANNELS if n not in chosen):
        kinds = heads.kinds(channel, rotary=rotary)
        if channel == "position":
            continue
        if candidates := ranked(heads, names, channel, kinds):
            chosen[channel] = candidates
    if heads.drive is not None:
        chosen |= signal_of(heads.drive, chosen, rotary=rotary)
    for channel, c in chosen.items():
        refuse_unfit(channel, c, heads.kinds(channel, rotary=rotary))
    return chosen, _unfit(names, chosen, rotary=rotary)


def time_choice(heads: Heads, mapped: Entry | None = None) -> Choice:
    """The column of times: the one that a map says, if it is there, or that the heads tell.

    Raises:
        InputError: there is none, or its unit is unknown or measures no time.
    """
    if mapped is not None and is_there(heads, mapped):
        choice = mapped_choice(heads, "time", mapped)
        refuse_unfit("time", choice, kinds_of("time"))
        return choice
    names = {h: heads.head(h) for h in heads.columns}
    return _needed(heads, names, "time", kinds_of("time"), {})


def _velocity(
    heads: Heads, names: Mapping[str, Head], chosen: Mapping[str, Choice]
) -> Choice | None:
    """The velocity of a log in which no column is called a position."""
    if any("position" in meanings(head) for head in names.values()):
        return None
    return chosen.get("velocity") or ranked(heads, names, "velocity", heads.kinds("velocity"))


def is_there(heads: Heads, entry: Entry) -> bool:
    """Whether a log has the column that an entry of a mapping names."""
    return named_column(heads, entry)[0] is not None


def named_column(heads: Heads, entry: Entry) -> tuple[str | None, str | None]:
    """The column that an entry names, None if there is none, and the unit that it states."""
    column = str(entry if isinstance(entry, str) else entry["column"])
    written = None if isinstance(entry, str) else entry.get("unit")
    name = heads.there(column)
    bracketed = re.fullmatch(r"(.*?)\s*\[([^\[\]]*)\]\s*", column)
    if name is None and bracketed:
        name, written = heads.there(bracketed[1]), written or bracketed[2]
    return name, None if written is None else str(written)


def mapped_choice(heads: Heads, channel: str, entry: Entry) -> Choice:
    """The column that an entry of a mapping names for a channel.

    Raises:
        InputError: there is no such column, or it has no unit.
    """
    column, written = named_column(heads, entry)
    if column is None:
        name = shortened(str(entry if isinstance(entry, str) else entry["column"]))
        raise InputError(
            f"the mapping says {channel} = {name!r}, but there is no such column: "
            f"there are {listed({**heads.columns, **heads.scalars})}"
        )
    if written is None:
        written = heads.head(column).unit
    if written is None and channel == "time" and (clock := _epoch(heads, column)):
        return _dated(column, clock)
    if written is None:
        raise InputError(_unmapped_unit(column, channel))
    factor = 1.0 if isinstance(entry, str) else entry.get("factor", 1.0)
    if isinstance(factor, str) and factor not in {**heads.columns, **heads.scalars}:
        raise InputError(f"the mapping says {channel} has the factor {shortened(factor)!r}, but "
                         "there is no such column or number")  # fmt: skip
    return Choice(column, heads.unit(channel, column, written), factor)


def _unmapped_unit(column: str, channel: str) -> str:
    name, example = shortened(column), usual_unit(channel, column)
    mapped = f"say it, as in {option('columns', {channel: f'{name} [{example}]'})}"
    stated = f"say it, as in {option('units', {name: example})}"
    return f"column {name} has no unit: {either(mapped, stated)}"


def _epoch(heads: Heads, column: str) -> Epoch | None:
    """The clock of a column whose first and last number are dates."""
    channel = heads.columns.get(column)
    if channel is None or channel.ends is None:
        return None
    first, last = map(epoch, channel.ends)
    return first if first == last else None


def _dated(column: str, clock: Epoch) -> Choice:
    tick = Unit(clock.title, clock.tick, 0.0, "s")
    return Choice(column, tick, reason=f"dates: {clock.title}", dated=True)


def _needed(
    heads: Heads,
    names: Mapping[str, Head],
    channel: str,
    kinds: tuple[str, ...],
    chosen: Mapping[str, Choice],
) -> Choice:
    """The column of time or position, or why there is none."""
    if candidates := ranked(heads, names, channel, kinds):
        return candidates
    named = [h for h, head in names.items() if channel in meanings(head)]
    if bare := [h for h in named if names[h].unit is None]:
        if channel == "time" and (clock := _epoch(heads, bare[0])):
            return _dated(bare[0], clock)
        raise InputError(without_unit(names, bare[0], channel, chosen))
    for h in named:
        refuse_unfit(channel, Choice(h, heads.unit(channel, h, names[h].unit or "")), kinds)
    if channel == "position" and not named:
        unsaid = [h for h, head in names.items() if "velocity" in meanings(head) and not head.unit]
        if unsaid:
            raise InputError(without_unit(names, unsaid[0], "velocity", chosen))
    if next(iter(heads.columns), "") == "column 1":
        raise InputError(
            "has no heads: name its columns by number, as in "
            f"{option('columns', {'time': '1 [s]', 'position': '2 [mm]'})}"
        )
    raise InputError(_nothing_named(heads, names, channel, kinds))


def _nothing_named(
    heads: Heads, names: Mapping[str, Head], channel: str, kinds: tuple[str, ...]
) -> str:
    """That no head says time or position, and how to say which is."""
    among = f"no {channel} column among {listed(heads.columns, _NAMED) or 'none'}"
    example = f"head [{usual_unit(channel)}]"
    fitting = [
        h
        for h, head in names.items()
        if head.unit and not meanings(head)
        if (u := heads.known(channel, head.unit)) and u.dimension in kinds
    ]
    other = {
        "time": f", or at what rate it was recorded: {option('columns', {'rate': 500})} (Hz)",
        "position": f"; a velocity does, too: {option('columns', {'velocity': 'head [mm/s]'})}",
    }
    if fitting:
        return f"{among}: say which it is, as in {option('columns', {channel: fitting[0]})}"
    return (
        f"{among}: say which it is, by its head or its number, and its unit: "
        f"{option('columns', {channel: example})}{other.get(channel, '')}"
    )


def without_unit(
    names: Mapping[str, Head],
    first: str,
    channel: str,
    chosen: Mapping[str, Choice],
) -> str:
    """Why columns without units cannot be taken, and how to say them."""
    lacking = {channel: shortened(first)}
    # A command line is told the channels that a log cannot do without, a program all of them.
    needed = ["position"] if channel == "time" else []
    others = needed if is_command_line() else CHANNELS
    for other in (c for c in others if c not in {*chosen, *lacking}):
        bare = [h for h, head in names.items() if other in meanings(head) and not head.unit]
        if bare and shortened(bare[0]) not in lacking.values():
            lacking[other] = shortened(bare[0])
    *rest, last = lacking.values()
    together, several = f"{', '.join(rest)} and {last}" if rest else last, "s" * bool(rest)
    turns = any(map(says_turn, lacking.values())) or None
    said = _units_said({h: (c, usual_unit(c, h, rotary=turns)) for c, h in lacking.items()})
    turning = _TURNING if "position" in lacking and not turns else ""
    return f"column{several} {together} without a unit: say it, as in {said}{turning}"


def _units_said(columns: Mapping[str, tuple[str, str]]) -> str:
    """How to say the units of columns, as they are typed or as Python has it.

    Args:
        columns: Column -> its channel and its unit.
    """
    if is_command_line():
        return option("columns", {c: f"{h} [{u}]" for h, (c, u) in columns.items()})
    return option("units", {h: u for h, (_, u) in columns.items()})


def ranked(
    heads: Heads, names: Mapping[str, Head], channel: str, kinds: tuple[str, ...]
) -> Choice | None:
    """The best candidate by name and unit."""
    ranked = []
    for h, head in names.items():
        rank = meanings(head).get(channel)
        if rank is not None and head.unit is not None and (u := heads.known(channel, head.unit)):
            ranked += [(rank, h, u)] * (u.dimension in kinds)
    if not ranked:
        return None
    best = min(rank for rank, _, _ in ranked)
    first, *rivals = [(h, u) for rank, h, u in ranked if rank == best]
    if rivals:
        a, b = shortened(first[0]), shortened(rivals[0][0])
        raise InputError(
            f"columns {a} and {b} both look like the {channel}: map one, as in "
            f"{option('columns', {channel: a})}"
        )
    return Choice(*first, reason="by its head")


def _unfit(heads: Mapping[str, Head], chosen: Mapping[str, Choice], *, rotary: bool) -> list[str]:
    """A word on each empty channel that a column names in vain; those without units together."""
    used = {c.column for c in chosen.values()}
    notes, bare = [], dict[str, tuple[str, str]]()
    for channel in CHANNELS:
        named = [h for h, head in heads.items() if channel in meanings(head) and h not in used]
        if channel not in chosen and named:
            written = heads[named[0]].unit
            reason = "has no unit" if written is None else "is in a unit that does not fit"
            if channel == "force" and written in ("%", "‰"):
                reason = f"is in {written} of what a [drive] table would say"
            if written is None and channel != "force":
                bare[shortened(named[0])] = channel, usual_unit(channel, named[0], rotary=rotary)
            else:
                notes.append(
                    f"column {shortened(named[0])} {reason} and was not taken as {channel}"
                )
    if bare:
        several = len(bare) > 1
        columns = ", ".join(f"{h} ({c})" for h, (c, _) in bare.items())
        notes.append(
            f"column{'s' * several} {columns} {'have' if several else 'has'} no unit and "
            f"{'were' if several else 'was'} not taken: say it, as in {_units_said(bare)}"
        )
    return notes
