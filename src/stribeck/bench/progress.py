"""A campaign while it runs: what is done, what came of it so far, and the time left."""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from statistics import fmean
from types import TracebackType
from typing import IO, Self, TypeVar

from rich import live as rich_live
from rich.console import Console, ConsoleOptions, Group, RenderableType, RenderResult
from rich.progress_bar import ProgressBar
from rich.table import Table
from rich.text import Text

from ..report import duration
from .record import Failure, Job, Record

#: Redraws a second on a terminal.
REFRESH = 4.0
#: Seconds between two lines where there is no terminal; more in a long campaign.
PACE = 5.0
#: Share of the time gone by that may pass between two lines, and the most it comes to, seconds.
SHARE, LONGEST = 1 / 60, 60.0

Cell = tuple[str, str]
T = TypeVar("T")


@dataclass
class Count:
    """How far a cell, or several together, are.

    Args:
        runs: How many there are to be.
        done: How many there are.
        aimed: How many of those had a target.
        met: How many met it.
        failed: How many could not be run.
        seconds: What the done ones took together.
    """

    runs: int = 0
    done: int = 0
    aimed: int = 0
    met: int = 0
    failed: int = 0
    seconds: float = 0.0

    @property
    def open(self) -> int:
        """Runs still to come."""
        return max(0, self.runs - self.done - self.failed)

    @property
    def mean(self) -> float | None:
        """Seconds of a run, over those done."""
        return self.seconds / self.done if self.done else None

    def add(self, record: Record) -> None:
        """Count a record."""
        self.done += 1
        self.aimed += record.job.target is not None
        self.met += record.reached
        self.seconds += record.seconds

    @classmethod
    def together(cls, counts: Iterable[Count]) -> Self:
        """Several together."""
        total = cls()
        for count in counts:
            for name, value in vars(count).items():
                setattr(total, name, getattr(total, name) + value)
        return total


class Tally:
    """The cells of a campaign, counted, and what is left of it estimated.

    Args:
        jobs: All jobs of the campaign.
        done: Records there are from before.
        workers: Runs that go on at the same time.
        clock: Seconds, from anywhere.
    """

    def __init__(
        self,
        jobs: Iterable[Job],
        done: Iterable[Record] = (),
        *,
        workers: int = 1,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.workers, self._clock = max(1, workers), clock
        self.cells: dict[Cell, Count] = {}
        for job in jobs:
            self.cells.setdefault(job.cell, Count()).runs += 1
        for record in done:
            self._cell(record.job).add(record)
        self._before = Count.together(self.cells.values())
        self._began = clock()

    def finished(self, record: Record) -> None:
        """Count a record."""
        self._cell(record.job).add(record)

    def failed(self, failure: Failure) -> None:
        """Count a failure."""
        self._cell(failure.job).failed += 1

    @property
    def total(self) -> Count:
        """All cells together."""
        return Count.together(list(self.cells.values()))

    @property
    def elapsed(self) -> float:
        """Seconds since the start."""
        return self._clock() - self._began

    def along(self, axis: int) -> dict[str, Count]:
        """The cells of each problem (axis 0) or each method (axis 1) together, in order."""
        return {
            label: Count.together(counts) for label, counts in _grouped(self.cells, axis).items()
        }

    def seconds(self) -> dict[Cell, float] | None:
        """Seconds that a run of each cell takes; None before any is done.

        The mean of the cell's done runs. A cell without one stands to the geometric mean of all
        as its problem's cells do, times as its method's cells do: costs of runs differ by
        factors, and both decide them.
        """
        logs = {c: math.log(max(n.mean, 1e-6)) for c, n in self.cells.items() if n.mean is not None}
        if not logs:
            return None
        overall = fmean(logs.values())
        by = [
            {label: fmean(durations) - overall for label, durations in _grouped(logs, axis).items()}
            for axis in (0, 1)
        ]
        return {
            (problem, method): math.exp(
                logs.get(
                    (problem, method),
                    overall + by[0].get(problem, 0.0) + by[1].get(method, 0.0),
                )
            )
            for problem, method in self.cells
        }

    def share(self) -> float | None:
        """How much of the work is done, 0 to 1, in seconds of runs; None before any is."""
        if (seconds := self.seconds()) is None:
            return None
        done = sum(seconds[c] * (n.runs - n.open) for c, n in self.cells.items())
        whole = sum(seconds[c] * max(n.runs, n.done + n.failed) for c, n in self.cells.items())
        return done / whole

    def seconds_left(self) -> float | None:
        """Seconds until the last run ends; None before the first has.

        The seconds of the runs to come, over the workers. Of the workers' time that no done run
        accounts for, as much as the longest runs can explain is the share already done of the
        runs in progress; the rest is what it costs to hand out a run, and is counted for every
        one to come.
        """
        total, seconds = self.total, self.seconds()
        if not total.open:
            return 0.0
        if seconds is None:
            return None
        open_cells = {c: n.open for c, n in self.cells.items() if n.open}
        busy = min(self.workers, total.open)
        idle = max(0.0, self.workers * self.elapsed - (total.seconds - self._before.seconds))
        makespan = min(idle, busy * max(seconds[c] for c in open_cells))
        finished = total.done + total.failed - self._before.done - self._before.failed
        handing = (idle - makespan) / finished if finished else 0.0
        work = sum(n * (seconds[c] + handing) for c, n in open_cells.items())
        return max(0.0, work - makespan) / busy

    def line(self) -> str:
        """All of it in a line."""
        total, share, remaining = self.total, self.share(), self.seconds_left()
        phrases = [f"{total.done:,}/{total.runs:,} runs"]
        if share is not None and total.open:
            phrases.append(f"{min(99, int(100 * share))} % of the work")
        if remaining is not None and total.open:
            phrases.append(f"{duration(remaining)} left" if remaining >= 1 else "nearly done")
        if total.failed:
            phrases.append(f"{total.failed:,} failed")
        return ", ".join(phrases)

    def last_line(self) -> str:
        """The same when it is over."""
        total = self.total
        state = "" if not total.open else "stopped: "
        return f"{state}{self.line_of(total)} in {duration(self.elapsed)}"

    @staticmethod
    def line_of(count: Count) -> str:
        """Done, met and failed."""
        phrases = [f"{count.done:,}/{count.runs:,} runs"]
        if count.aimed:
            phrases.append(f"{count.met:,} met their target")
        if count.failed:
            phrases.append(f"{count.failed:,} failed")
        return ", ".join(phrases)

    def _cell(self, job: Job) -> Count:
        return self.cells.setdefault(job.cell, Count())


class Live:
    """A view of a campaign on standard error: a table on a terminal, lines elsewhere.

    Args:
        title: The campaign's name.
        jobs: All its jobs.
        done: Records there are from before.
        workers: Runs that go on at the same time.
        file: Where to write; None is standard error.
        clock: Seconds, from anywhere.
    """

    def __init__(
        self,
        title: str,
        jobs: Iterable[Job],
        done: Iterable[Record] = (),
        *,
        workers: int = 1,
        file: IO[str] | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.tally = Tally(jobs, done, workers=workers, clock=clock)
        self._title, self._clock = title, clock
        self._told = clock()
        self._busy_elsewhere, self._trouble = 0, ""
        self._out = Console(
            file=file or sys.stderr, highlight=False, markup=False, emoji=False, soft_wrap=False
        )
        self._drawn = self._out.is_terminal and not self._out.is_dumb_terminal
        self._live: rich_live.Live | None = None

    def __enter__(self) -> Self:
        if self._drawn:
            self._live = rich_live.Live(
                get_renderable=self.picture,
                console=self._out,
                refresh_per_second=REFRESH,
                transient=True,
            )
            self._live.start()
        elif self.tally.total.done:
            self._say(f"{self._title}: {self.tally.line()}")
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        at: TracebackType | None,
    ) -> None:
        if self._live is not None:
            self._live.stop()
        self._say(f"{self._title}: {self.tally.last_line()}")

    def finished(self, record: Record) -> None:
        """A run is done."""
        self.tally.finished(record)
        self._busy_elsewhere = 0
        self._step()

    def failed(self, failure: Failure) -> None:
        """A job could not be run."""
        self.tally.failed(failure)
        job = failure.job
        message = " ".join(failure.message.split())
        self._trouble = f"{job.problem} {job.algorithm} {job.repeat}: {message}"
        if not self._drawn:
            self._say(f"failed: {self._trouble}")
        self._step()

    def waiting(self, runs: int) -> None:
        """Nothing is left but what other processes are busy with."""
        self._busy_elsewhere = runs
        self._step()

    def picture(self) -> RenderableType:
        """What a terminal shows now: as much detail as there is room for."""
        return _ProgressPanel(self.tally, self._title, self._told_beside())

    def _told_beside(self) -> list[Text]:
        """What is shown below the table."""
        lines = []
        if self._busy_elsewhere:
            lines.append(Text(_waiting(self._busy_elsewhere), style="yellow"))
        if self._trouble:
            lines.append(Text(f"failed last: {self._trouble}", style="red"))
        for text in lines:
            text.no_wrap, text.overflow = True, "ellipsis"
        return lines

    def _step(self) -> None:
        now = self._clock()
        pace = max(PACE, min(LONGEST, SHARE * self.tally.elapsed))
        if self._drawn or now - self._told < pace:
            return
        self._told = now
        busy = f", {_waiting(self._busy_elsewhere)}" if self._busy_elsewhere else ""
        self._say(self.tally.line() + busy)

    def _say(self, line: str) -> None:
        self._out.file.write(line + "\n")
        self._out.file.flush()


@dataclass(frozen=True)
class _ProgressPanel:
    """The picture on a terminal: as much detail as there is room for."""

    tally: Tally
    title: str
    beside: Sequence[Text] = field(default=())

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        width, height = options.max_width, console.size.height
        top = Text(self.title, style="bold", no_wrap=True, overflow="ellipsis")
        line = Text(self.tally.line(), no_wrap=True, overflow="ellipsis")
        room = height - len(self.beside) - 4  # title, bar, line, and the cursor's
        if room < 0:
            yield line
            return
        parts: list[RenderableType] = [top, *self._table(width, room)]
        total, share = self.tally.total, self.tally.share() or 0.0
        share = share if total.open else 1.0
        bar = Table.grid()
        bar.add_row(ProgressBar(total=1.0, completed=share, width=min(width, 60)))
        yield Group(*parts, bar, line, *self.beside)

    def _table(self, width: int, room: int) -> list[RenderableType]:
        """Problems by methods, else a line a method, else a shorter one, else nothing."""
        for build in (self._grid, self._methods, self._short):
            heads, rows, styles = build()
            needed = sum(max(map(len, column)) + 2 for column in zip(heads, *rows, strict=True))
            if len(rows) + 1 <= room and needed <= width:
                return [_table(heads, rows, styles)]
        return []

    def _grid(self) -> _Rows:
        problems, methods = (list(self.tally.along(axis)) for axis in (0, 1))
        cells = self.tally.cells
        rows, styles = [], []
        for p in problems:
            counts = [cells.get((p, m)) for m in methods]
            rows.append([p, *("" if n is None else _text(n) for n in counts)])
            styles.append(["", *("" if n is None else _style(n) for n in counts)])
        return ["", *methods], rows, styles

    def _methods(self) -> _Rows:
        heads = ["method", "runs", "met target", "failed", "s a run", "problems"]
        finished = _grouped({c: not n.open for c, n in self.tally.cells.items()}, 1)
        rows, styles = [], []
        for method, n in self.tally.along(1).items():
            mean = "" if n.mean is None else f"{n.mean:.3f}"
            record = finished[method]
            runs, failed = f"{n.done:,}/{n.runs:,}", f"{n.failed:,}" if n.failed else ""
            rows.append([method, runs, _met(n), failed, mean, f"{sum(record)}/{len(record)}"])
            styles.append([_style(n)] * len(heads))
        return heads, rows, styles

    def _short(self) -> _Rows:
        counts = self.tally.along(1)
        rows = [[method, f"{n.done:,}/{n.runs:,}", _met(n)] for method, n in counts.items()]
        return ["method", "runs", "met"], rows, [[_style(n)] * 3 for n in counts.values()]


#: A table's heads, its rows, and the style of each of their places.
_Rows = tuple[list[str], list[list[str]], list[list[str]]]


def _table(heads: list[str], rows: list[list[str]], styles: list[list[str]]) -> Table:
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0), header_style="dim")
    for k, head in enumerate(heads):
        table.add_column(Text(head), justify="left" if k == 0 else "right", no_wrap=True)
    for row, style in zip(rows, styles, strict=True):
        table.add_row(*(Text(cell, style=s) for cell, s in zip(row, style, strict=True)))
    return table


def _text(n: Count) -> str:
    """A cell of the grid: done of all until all are, and how many met the target."""
    done = f"{n.done}/{n.runs}" if n.open or n.failed else f"{n.done}"
    return f"{done} {_met(n):>5}" + (f" !{n.failed}" if n.failed else "")


def _met(n: Count) -> str:
    return f"{100 * n.met / n.aimed:.0f} %" if n.aimed else "–"


def _style(n: Count) -> str:
    if n.failed:
        return "red"
    if not n.open:
        return "green"
    return "" if n.done else "dim"


def _waiting(runs: int) -> str:
    return f"waiting for {runs:,} run{'s' * (runs != 1)} of other processes"


def _grouped(values: Mapping[Cell, T], axis: int) -> dict[str, list[T]]:
    groups: dict[str, list[T]] = {}
    for cell, value in values.items():
        groups.setdefault(cell[axis], []).append(value)
    return groups
