"""What a person reads on the terminal."""

from __future__ import annotations

import json
import math
import os
import signal
import sys
import threading
import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields, is_dataclass
from typing import TYPE_CHECKING, Any, Self

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table
from rich.text import Text

from ..rig.rig import shown_in

if TYPE_CHECKING:
    from ..data.quality import Quality
    from ..identify.card import Card
    from ..identify.found import Fit
    from ..optimize import Search
    from .stopwatch import Stopwatch

#: Seconds between lines of progress where there is no terminal.
PACE = 2.0
#: Columns of a line that nobody wraps.
UNCUT = 1000


class _Out(Console):
    """A console that leaves a broken pipe to the command line."""

    def on_broken_pipe(self) -> None:
        raise BrokenPipeError


def console() -> Console:
    """Standard output; where it is no terminal, lines are as long as they need to be."""
    wide = sys.stdout.isatty() or "COLUMNS" in os.environ
    return _Out(highlight=False, markup=False, emoji=False, width=None if wide else UNCUT)


def grid(
    title: str, heads: Sequence[str], rows: Iterable[Sequence[str]], *, left: int = 1
) -> Table:
    """A plain table; the first `left` columns are text, the others numbers."""
    table = Table(
        title=title or None, title_justify="left", title_style="bold", box=None, pad_edge=False
    )
    for k, head in enumerate(heads):
        table.add_column(head, justify="left" if k < left else "right", overflow="fold")
    for row in rows:
        table.add_row(*row)
    return table


def number(value: float, digits: int = 5) -> str:
    """A number for a table; a dash where there is none."""
    return f"{value:.{digits}g}" if math.isfinite(value) else "–"


def show_fit(fit: Fit) -> None:
    """The parameters, the misfit beside its baselines, what was held out, and the warnings."""
    out = console()
    rows = []
    for q, e in zip(fit.parameters.every, fit.estimates, strict=True):
        if e.verdict == "fixed" and q.fixed == e.value:
            continue
        shown = float(shown_in(fit.rig, q, e.value))
        factor = shown / e.value if e.value else float(shown_in(fit.rig, q, 1.0))
        rows.append([
            e.name, number(shown), e.unit, number(e.standard_error * factor, 3),
            number(e.spread * factor, 3), e.at_bound or "", e.verdict,
        ])  # fmt: skip
    heads = ["parameter", "value", "unit", "std. error", "spread", "at bound", "verdict"]
    table = grid(f"{fit.law.name} on {fit.rig.name}", heads, rows)
    table.columns[2].justify = table.columns[5].justify = table.columns[6].justify = "left"
    out.print(table)
    out.print()
    out.print(_scores(fit))
    if fit.balance is not None:
        figures = fit.balance.figures()
        out.print()
        out.print(
            grid(
                "",
                ["force balance", ""],
                [[n.replace("_", " "), number(v)] for n, v in figures.items()],
            )
        )
    else:
        out.print(
            f"\n{fit.method}, seed {fit.seed}: {fit.evaluations:,} evaluations in {len(fit.runs)} "
            f"repeat{'s' * (len(fit.runs) > 1)}, {fit.seconds:.1f} s, ended: {fit.ended}"
        )
    for warning in fit.warnings:
        out.print(Text.assemble(("warning:", "yellow"), " ", warning))


def show_time(clock: Stopwatch) -> None:
    """Where the time went, in a quiet line."""
    console().print(Text(clock.line(), style="dim"))


def _scores(fit: Fit) -> Table:
    s = fit.score
    trained = ", ".join(r.text for r in fit.train_ranges) or "all"
    rows = [[f"training {trained}", *_score_cells(s)]]
    rows += [
        [f"held out {h.within.text if h.within else 'all'}", *_score_cells(h.score)]
        for h in fit.holdout
    ]
    named = "J" if s.name == "position_rmse" else s.name.replace("_", " ")
    heads = [f"{named} / {s.unit}", "model", "smooth, no stick-slip", "never moves", "samples"]
    if not math.isfinite(s.smooth):
        rows = [[row[0], row[1], row[-1]] for row in rows]
        heads = [heads[0], heads[1], heads[-1]]
    return grid("", heads, rows)


def _score_cells(score: Any) -> list[str]:
    return [
        number(score.value, 4),
        number(score.smooth, 4),
        number(score.still, 4),
        str(score.samples),
    ]


def show_validation(card: Card, rows: Sequence[tuple[str, str, Any]]) -> None:
    """A card's misfit on logs and ranges: (log, range, score) a row."""
    unit = rows[0][2].unit if rows else ""
    name = rows[0][2].name.replace("_", " ") if rows else ""
    cells = [[log, within, *_score_cells(score)] for log, within, score in rows]
    heads = ["log", "range", f"{name} / {unit}", "smooth", "never moves", "samples"]
    console().print(grid(f"{card.law} on {card.rig}", heads, cells, left=2))


def validation_text(card: Card, rows: Sequence[tuple[str, str, Any]]) -> str:
    """The same as JSON."""
    found = [
        {"log": log, "range": within, "name": s.name, "value": s.value, "unit": s.unit,
         "samples": s.samples, "baselines": s.baselines()}
        for log, within, s in rows
    ]  # fmt: skip
    said = {"schema": "stribeck-validation/1", "law": card.law, "rig": card.rig, "scores": found}
    return json.dumps(said, indent=2, ensure_ascii=False) + "\n"


def show_quality(quality: Quality) -> None:
    """What is in a log."""
    table = grid("", [quality.file or "recording", ""], quality.lines(), left=2)
    console().print(table)


def quality_text(quality: Quality) -> str:
    """The same as JSON, SI."""
    said: dict[str, Any] = {"schema": "stribeck-quality/1"}
    for f in fields(quality):
        said[f.name] = _plain(getattr(quality, f.name))
    return json.dumps(said, indent=2, ensure_ascii=False) + "\n"


def _plain(value: Any) -> Any:
    """A value as JSON has it: a slice as its two ends, what is not finite as null."""
    if is_dataclass(value):
        return {n: _plain(v) for n, v in vars(value).items()}
    if isinstance(value, slice):
        return [value.start, value.stop]
    if isinstance(value, Mapping):
        return {str(k): _plain(v) for k, v in value.items()}
    if isinstance(value, tuple | list):
        return [_plain(v) for v in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value


class Watch:
    """A progress bar on a terminal, plain lines elsewhere; both on standard error.

    While it is entered, Ctrl-C ends a search between two steps, where its record is whole; a
    second one, or one outside the search, interrupts at once.
    """

    def __init__(self, unit: str) -> None:
        self._unit, self._told = unit, time.monotonic()
        self._bar: Progress | None = None
        self._searching = self._asked = False
        self._before: Any = None

    def __enter__(self) -> Self:
        usual = signal.getsignal(signal.SIGINT) is signal.default_int_handler
        if usual and threading.current_thread() is threading.main_thread():
            self._before = signal.signal(signal.SIGINT, self._interrupt)
        return self

    def __exit__(self, *_: object) -> None:
        if self._before is not None:
            signal.signal(signal.SIGINT, self._before)
        if self._bar is not None:
            self._bar.stop()

    def __call__(self, searches: Sequence[Search]) -> None:
        """Say how far the searches are.

        Raises:
            KeyboardInterrupt: Ctrl-C was pressed during the step.
        """
        self._searching = not self._asked and any(s.ended is None for s in searches)
        if self._asked:
            raise KeyboardInterrupt
        done = sum(len(s.trace) for s in searches)
        total = sum(s.budget if s.ended is None else len(s.trace) for s in searches)
        best = f"{number(min(s.trace.cost for s in searches), 4)} {self._unit}"
        if sys.stderr.isatty():
            self._draw(done, total, best)
        elif time.monotonic() - self._told >= PACE:
            self._told = time.monotonic()
            print(f"{done:,}/{total:,} evaluations, best J {best}", file=sys.stderr, flush=True)  # noqa: T201

    def _interrupt(self, *_: object) -> None:
        if not self._searching or self._asked:
            raise KeyboardInterrupt
        self._asked = True

    def _draw(self, done: int, total: int, best: str) -> None:
        if self._bar is None:
            self._bar = Progress(
                TextColumn("{task.description}"), BarColumn(bar_width=24),
                TextColumn("{task.completed:,}/{task.total:,} evaluations"),
                TextColumn("best J {task.fields[best]}"), TimeElapsedColumn(),
                console=Console(stderr=True), transient=True,
            )  # fmt: skip
            self._bar.add_task("searching", total=total, best="")
            self._bar.start()
        (task,) = self._bar.task_ids
        doing = "searching" if self._searching else "polishing"
        self._bar.update(task, description=doing, completed=done, total=total, best=best)
