"""What a person reads on the terminal."""

from __future__ import annotations

import json
import math
import os
import re
import signal
import sys
import textwrap
import threading
import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields, is_dataclass
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table
from rich.text import Text

from ..identify.score import scores
from ..rig.rig import shown_in
from ..units import unit

if TYPE_CHECKING:
    from ..data.quality import Quality
    from ..identify.card import Card
    from ..identify.result import Fit
    from ..identify.score import Score
    from ..optimize import Search
    from .stopwatch import Stopwatch

#: Seconds between lines of progress where there is no terminal.
PACE = 2.0
#: Columns of a line that nobody wraps.
UNCUT = 1000


#: How many logs are listed one by one, from and up to, and what stands before a warning.
SEVERAL, LISTED = 2, 20
_HEAD = "warning: "


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


def _parameters(fit: Fit) -> Table:
    """Each parameter with its interval and verdict; published errors where there are some."""
    rows = []
    for q, e in zip(fit.parameters.every, fit.estimates, strict=True):
        if e.verdict == "fixed" and q.fixed == e.value:
            continue

        def shown(x: float, q: Any = q) -> float:
            return float(shown_in(fit.rig, q, x))

        free = e.verdict != "fixed"
        rows.append([
            e.name, number(shown(e.value)), e.unit,
            _end(shown(e.low), e.low_ended) if free else "–",
            _end(shown(e.high), e.high_ended) if free else "–",
            *([number(shown(e.standard_error) - shown(0.0), 3)] if fit.balance else []),
            e.verdict,
        ])  # fmt: skip
    errors = ["std. error"] if fit.balance else []
    heads = ["parameter", "value", "unit", "95 % from", "to", *errors, "verdict"]
    table = grid(f"{fit.law.name} on {fit.rig.name}", heads, rows)
    table.columns[2].justify = table.columns[-1].justify = "left"
    return table


def _end(value: float, ended: str | None) -> str:
    """An end of an interval, and what stopped it if it was not the data."""
    words = {"bound": "range", "flat": "range", "budget": "guessed", "unrunnable": "fails"}
    said = words.get(ended or "threshold", ended)
    return number(value, 4) if ended in (None, "threshold") else f"{number(value, 4)} ({said})"


def show_fit(fit: Fit) -> None:
    """The parameters, the misfit beside its baselines, what was held out, and the warnings."""
    out = console()
    out.print(_parameters(fit))
    for e in fit.estimates:
        if e.verdict in ("weak", "not identifiable") and e.meaning:
            said = re.sub("^(Doubling|Halving)", lambda first: first[0].lower(), e.meaning)
            _paragraph(f"{e.name} is {e.verdict}: {said}", "  ")
    for part in (_scores(fit), _staircases(fit), _logs(fit)):
        if part is not None:
            out.print()
            out.print(part)
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
    show_warnings(fit.warnings)


def show_warnings(warnings: Sequence[str]) -> None:
    """Warnings, a paragraph each; what is said of several logs is said once."""
    for warning in gathered(warnings):
        _paragraph(warning, _HEAD)


def _paragraph(said: str, head: str) -> None:
    """A paragraph that hangs beside its head."""
    out = console()
    lines = textwrap.wrap(said, max(40, out.width - len(head)), break_on_hyphens=False)
    for k, line in enumerate(lines or [""]):
        out.print(Text.assemble((head, "yellow") if k == 0 else " " * len(head), line))


def gathered(warnings: Sequence[str]) -> list[str]:
    """Warnings of which those that differ in the log and in numbers only are told by the first."""
    alike: dict[str, list[str]] = {}
    for warning in warnings:
        log, colon, note = warning.partition(": ")
        about = colon and not re.search(r"\s", log) and "." in log  # the name of a file
        key = re.sub(r"\d+(\.\d+)?", "#", note) if about else warning
        alike.setdefault(key, []).append(warning)
    return [
        first
        if not more
        else f"{first} (and much the same of {len(more)} more log{'s' * (len(more) > 1)})"
        for first, *more in alike.values()
    ]


def show_time(clock: Stopwatch) -> None:
    """Where the time went, in a quiet line."""
    console().print(Text(clock.line(), style="dim"))


def _scores(fit: Fit) -> Table:
    s = fit.score
    trained = ", ".join(r.text for r in fit.train_ranges) or "all"
    rows = [[f"training {trained}", *_score_cells(s)]]
    rows += [[f"held out {_within(h)}", *_score_cells(h.score)] for h in fit.holdout]
    heads = [_error(s), "model", "smooth, no stick-slip", "never moves", "samples"]
    if not math.isfinite(s.smooth):
        rows = [[row[0], row[1], row[-1]] for row in rows]
        heads = [heads[0], heads[1], heads[-1]]
    return grid("", heads, rows)


def _staircases(fit: Fit) -> Table | None:
    """How often and how far the axis slipped, and how the model did."""
    rows = []
    every = [("training", fit.score), *((f"held out {_within(h)}", h.score) for h in fit.holdout)]
    shown = fit.rig.unit_shown("position")
    for name, score in every:
        for who, s in (("axis", score.measured), ("model", score.modelled)):
            if s is not None:
                jump = float(unit(shown).from_si(s.jump))
                rows.append([f"{name}, {who}", str(s.slips), number(jump, 3), f"{s.stuck:.0%}"])
    heads = ["stick-slip", "slips", f"median jump / {shown}", "time at rest"]
    return grid("", heads, rows) if rows else None


def _within(held: Any) -> str:
    return held.within.text if held.within else "all"


def _logs(fit: Fit) -> Table | None:
    """The error on each log, where there are several; the greatest of very many."""
    if len(fit.recordings) < SEVERAL:
        return None
    rows = log_errors(fit)
    held = any(math.isfinite(error) for _, _, errors in rows for error in errors[1:])
    order = sorted(range(len(rows)), key=lambda k: np.nan_to_num(-_worst(rows[k][2])))[:LISTED]
    which = "each log" if len(rows) <= LISTED else f"the {LISTED} worst of {len(rows)} logs"
    heads = [f"{which}, {_error(fit.score)}", "training", "samples", "held out"]
    cells = [
        [log, number(errors[0], 4), f"{samples:,}", number(_worst(errors[1:]), 4)][: 3 + held]
        for log, samples, errors in (rows[k] for k in sorted(order))
    ]
    return grid("", heads[: 3 + held], cells)


def _worst(errors: Sequence[float]) -> float:
    return max((e for e in errors if math.isfinite(e)), default=math.nan)


def log_errors(fit: Fit) -> list[tuple[str, int, list[float]]]:
    """The misfit on each log: (log, samples trained on, misfits); nan where it was not used.

    The misfits are on the training data and then on each range held out, as `fit.score` has them.
    """
    found = []
    for k, log in enumerate(fit.recordings):
        errors = []
        if fit.balance is not None:
            b = fit.balance.signals[k]
            left = float(np.linalg.norm(b.measured - b.predicted) / np.linalg.norm(b.measured))
            errors = [100.0 * left]
        else:
            for on in (fit.train, *(h.segments for h in fit.holdout)):
                own = [s for s in on if s.recording is log]
                errors.append(scores(fit.parameters, fit.p, own).value if own else math.nan)
        found.append((log.label, fit.used(log), errors))
    return found


def _error(score: Score) -> str:
    """The misfit of a score as tables have it."""
    said = {"position_rmse": "J", "position_mae": "mean size of the error"}
    return f"{said.get(score.name, score.name.replace('_', ' '))} / {score.unit}"


def _score_cells(score: Any) -> list[str]:
    return [
        number(score.value, 4),
        number(score.smooth, 4),
        number(score.still, 4),
        str(score.samples),
    ]


def show_validation(card: Card, rows: Sequence[tuple[str, str, Any]]) -> None:
    """A card's misfit on logs and ranges: (log, range, score) a row."""
    cells = [[log, within, *_score_cells(score)] for log, within, score in rows]
    error = _error(rows[0][2]) if rows else ""
    heads = ["log", "range", error, "smooth", "never moves", "samples"]
    if (pooled := _pooled([score for _, _, score in rows])) is not None:
        cells.append(["all of these", "", *pooled])
    console().print(grid(f"{card.law} on {card.rig}", heads, cells, left=2))


def _pooled(every: Sequence[Score]) -> list[str] | None:
    """One misfit of many, where it can be had from theirs; None for one, and for forces."""
    n = [s.samples for s in every]
    power = {"position_rmse": 2, "position_mae": 1}.get(every[0].name if every else "")
    if power is None or len(every) < SEVERAL:
        return None
    kinds = ([getattr(s, part) for s in every] for part in ("value", "smooth", "still"))
    means = [float(np.average(np.power(v, power), weights=n)) ** (1 / power) for v in kinds]
    return [*(number(m, 4) for m in means), str(sum(n))]


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
