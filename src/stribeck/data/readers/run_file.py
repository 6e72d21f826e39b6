"""One of the files of a run, with its times."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...errors import InputError
from ...space import Array
from ...wording import option
from .choice import Choice
from .column_map import Entry
from .columns import Heads, time_choice
from .log_file import Channel, LogFile, ReadOptions, timing
from .raw_table import RawTable, shortened
from .run_clocks import FileClock
from .stamps import epoch

#: The most rows of a file whose time goes back or stands: a share.
_DISORDER = 0.2


@dataclass(frozen=True, eq=False)
class RunFile:
    """A file of a run.

    Args:
        name: Of the file.
        log: As its reader opened it.
        names: Its channels -> what they are called in the run.
        time: Its column of times; None if the format has a clock, or the rate is said.
        rate: Of a file without times, Hz.
        beside: The file whose times it has, where it says none and has as many rows.
        timeless: Whether it has one column, and that is no time.
        lacking: What has to be said before it has times.
    """

    name: str
    log: LogFile
    names: Mapping[str, str]
    time: Choice | None = None
    rate: float | None = None
    beside: RunFile | None = None
    timeless: bool = False
    lacking: str = ""

    @classmethod
    def of(
        cls,
        name: str,
        log: LogFile,
        names: Mapping[str, str],
        options: ReadOptions,
        time: Entry | None,
        units: Mapping[str, str],
    ) -> RunFile:
        """A file with its times, as far as they can be told.

        Args:
            name: Of the file.
            log: As its reader opened it.
            names: Its channels -> what they are called in the run.
            options: What it may not say about itself.
            time: The column of times, as a map says it; counts where it is there.
            units: Unit by column, where the heads do not say it.
        """
        plain = cls(name, log, names)
        if log.lacking:
            return replace(plain, lacking=f"{name}: {log.lacking}")
        if any(c.clock for c in log.channels):
            return plain
        own = {n: u for n, u in units.items() if any(n == c.name for c in log.channels)}
        try:
            return replace(plain, time=time_choice(Heads.of(log, None, own, timed=False), time))
        except InputError as error:
            if options.rate is not None:
                return replace(plain, rate=options.rate)
            alone = sum(not c.constant for c in log.channels) == 1
            return replace(plain, timeless=alone, lacking=f"{name}: {error}")

    def timed_by(self, others: Sequence[RunFile]) -> RunFile:
        """The same with the times of another file, where it has none and another has as many rows.

        Args:
            others: The files of the run.
        """
        if not self.timeless:
            return self
        timed = [file for file in others if not file.lacking]
        same = next((f for f in timed if f.rows == self.rows), None)
        if same is not None:
            return replace(self, beside=same, timeless=False, lacking="")
        counts = " or ".join(f"the {file.rows} of {shortened(file.name)}" for file in timed)
        why = f"has {self.rows} rows, not {counts}" if timed else "so does every file of the run"
        text = (
            f"{self.name}: says no times, and {why}: say at what rate it was recorded, "
            f"{option('columns', {'rate': 500})} (Hz), or export it with its times"
        )
        return replace(self, lacking=text)

    @property
    def rows(self) -> int:
        """How many rows it has."""
        return max((c.count for c in self.log.channels if not c.constant), default=0)

    def clock(self) -> FileClock:
        """When its samples were taken, as it says.

        Raises:
            InputError: it has fewer than two instants.
        """
        if self.beside is not None:
            return replace(self.beside.clock(), file=self.name)
        columns = [c for c in self.log.channels if not c.constant]
        first = {self.time.column} if self.time is not None else {c.name for c in columns[:1]}
        table = next((t for t in self.tables(first) if t.t is not None and len(t.t) > 1), None)
        if table is None or table.t is None:
            raise InputError(f"{self.name} has fewer than two instants")
        spans = [c.span for c in columns if c.span is not None] or [(table.t[0], table.t[-1])]
        span = float(min(s[0] for s in spans)), float(max(s[1] for s in spans))
        rate, _ = timing(table.t)
        return FileClock(self.name, span, 1.0 / rate if rate else 0.0, self._origin(table))

    def _origin(self, table: RawTable) -> float | None:
        """The instant at which its clock shows 0, if it says so."""
        if self.time is None:
            return table.began
        if not self.time.dated:
            return table.dates.get(self.time.column)
        first = epoch(float(table.columns[self.time.column][0]))
        return None if first is None else -first.origin

    def channels(self, span: tuple[float, float], interval: float) -> Iterator[Channel]:
        """Its channels as they are called in the run.

        Args:
            span: First and last instant of its column of times, s on the clock of the run.
            interval: Between its samples, s.
        """
        for c in self.log.channels:
            own = replace(c, name=self.names[c.name])
            if c.constant or c.clock or self.lacking:
                yield replace(own, clock=f"{self.name} {c.clock}" if c.clock else "")
                continue
            is_time = self.time is not None and c.name == self.time.column
            rate = float(f"{1.0 / interval:.9g}") if interval else None
            yield replace(own, clock=self.name, rate=rate, span=span, is_time=is_time)

    def tables(self, names: Collection[str]) -> Iterator[RawTable]:
        """Tables of channels with times, s on the file's clock, in order; named as in the file."""
        times = set() if self.time is None else {self.time.column}
        for table in self.log.tables({*names, *times}):
            timed = table
            if self.time is not None and self.time.column in table.columns:
                timed = replace(table, t=self.time.values(table))
            elif table.t is None and self.rate is not None:
                timed = replace(table, t=np.arange(len(table.places)) / self.rate)
            elif table.t is None and self.beside is not None:
                timed = replace(table, t=self.beside.times(len(table.places)))
            yield _in_order(timed, self.name)

    def times(self, count: int) -> Array:
        """The instants of its rows, s on its clock, (count,)."""
        wanted = {self.time.column} if self.time is not None else {self.log.channels[0].name}
        for table in self.log.tables(wanted):
            t = self.time.values(table) if self.time is not None else table.t
            if t is None and self.rate is not None:
                t = np.arange(len(table.places)) / self.rate
            if t is not None and len(t) == count:
                return t
        raise InputError(f"{self.name} has not the {count} instants of the file beside it")

    def signal(self, name: str) -> tuple[Array, Array]:
        """Times and values of a channel, empty where it has no times."""
        for table in self.tables({name}):
            if name in table.columns and table.t is not None:
                return table.t, table.columns[name]
        return np.empty(0), np.empty(0)

    def called(self, table: RawTable, wanted: Collection[str]) -> RawTable:
        """Channels of a table, named as in the run."""
        names = {n: name for n, name in self.names.items() if n in wanted}
        return replace(
            table,
            columns={names[n]: a for n, a in table.columns.items() if n in names},
            scalars={names[n]: v for n, v in table.scalars.items() if n in names},
            units={names[n]: u for n, u in table.units.items() if n in names},
            text={
                names[n]: (f"{shortened(self.name)}, {place}", cell)
                for n, (place, cell) in table.text.items()
                if n in names
            },
            word=f"{shortened(self.name)}, {table.word}",
            clock=f"{self.name} {table.clock}".strip(),
            notes=(),
            dates={},
        )


def _in_order(table: RawTable, name: str) -> RawTable:
    """The rows whose time goes on.

    Raises:
        InputError: too many do not.
    """
    if table.t is None or len(table.t) == 0:
        return table
    finite = np.where(np.isfinite(table.t), table.t, -np.inf)
    before = np.concatenate([[-np.inf], np.maximum.accumulate(finite)[:-1]])
    rows = finite > before
    if rows.all():
        return table
    if (~rows).sum() > _DISORDER * len(rows):
        row = int((~rows).argmax())
        raise InputError(f"{name}, {table.place(row)}: time goes back, stands or is missing: sort "
                         "the log or split it there")  # fmt: skip
    return replace(
        table,
        columns={n: a[rows] for n, a in table.columns.items()},
        t=table.t[rows],
        places=np.asarray(table.places)[rows],
    )
