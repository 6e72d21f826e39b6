"""Commands that identify: one law, or the best of several; and the page of a fit."""

from __future__ import annotations

import logging
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..errors import InputError
from .completions import law_names, laws_named, method_names
from .exits import fail, show_files
from .inputs import (
    Bounds,
    DelayText,
    Exact,
    Json,
    Logs,
    LossOption,
    RigName,
    Seed,
    Set,
    Train,
    above_zero,
    check_held,
    check_there,
    delay_value,
    each_once,
    intervals,
    law_name,
    pairs,
    setting_value,
    with_constants,
)
from .interruption import interruption
from .likely_rig import no_rig
from .reading import Reading, reads_logs

if TYPE_CHECKING:
    from collections.abc import Callable

    from ..identify.result import Fit
    from ..identify.selection.select import Selection
    from ..report.stopwatch import Stopwatch
    from ..rig import Rig


@reads_logs
def identify(
    logs: Logs,
    rig: RigName = None,
    law: Annotated[str | None, typer.Option(metavar="LAW", help="A friction law (see `laws`); the rig's first by default.", autocompletion=law_names)] = None,
    directional: Annotated[bool, typer.Option("--directional", help="Parameters for each direction.")] = False,
    method: Annotated[str | None, typer.Option(metavar="METHOD", help="A search method (see `methods`); mbts by default.", autocompletion=method_names)] = None,
    train: Train = None,
    holdout: Annotated[list[str] | None, typer.Option(metavar="A:B", help="Positions (or times) to validate on; none by default.")] = None,
    set_: Set = None,
    exact: Exact = False,
    bounds: Bounds = None,
    tie: Annotated[list[str] | None, typer.Option(metavar="NAME=OTHER", help="Make one parameter equal another.")] = None,
    setting: Annotated[list[str] | None, typer.Option(metavar="NAME=VALUE", help="A setting of the method.")] = None,
    seed: Seed = None,
    budget: Annotated[int | None, typer.Option(metavar="N", help="Evaluations for each repeat; 8000 by default.")] = None,
    repeats: Annotated[int | None, typer.Option(metavar="N", help="Independent searches; 3 by default.")] = None,
    target: Annotated[float | None, typer.Option(metavar="J", help="End a search at this J; none by default.")] = None,
    paper: Annotated[bool, typer.Option("--paper", help="The paper's run: to J < 4.5 or 1000 rounds, one search, no polishing.")] = False,
    loss: LossOption = "squares",
    restart: Annotated[bool, typer.Option("--restart", help="Simulate from rest to rest, not through.")] = False,
    delay: DelayText = "auto",
    velocity: Annotated[str, typer.Option(metavar="auto|recorded|position", help="The velocity of a force balance.")] = "auto",
    breakaway: Annotated[str, typer.Option(metavar="auto|common|scattered", help="One breakaway, or each slip's own.")] = "auto",
    bootstrap: Annotated[int, typer.Option(metavar="N", help="Refits of redrawn residuals (200, say); none by default.", show_default=False)] = 0,
    posterior: Annotated[int, typer.Option(metavar="N", help="Samples of the posterior (20000, say); none by default.", show_default=False)] = 0,
    out: Annotated[Path | None, typer.Option(metavar="DIR", help="Write card.json, figures and report.html there.")] = None,
    figures: Annotated[bool, typer.Option("--figures/--no-figures", help="Whether figures are drawn into --out; the page has its own.")] = True,
    quiet: Annotated[bool, typer.Option("--quiet", help="Print no result and no progress: what goes wrong alone.")] = False,
    json: Json = False,
    reading: Reading = Reading(),  # noqa: B008 - options of its own
) -> None:  # fmt: skip
    """Identify the friction of an axis from recordings of it."""
    check_there(logs)
    rig = rig or no_rig(logs, reading, json=json)
    if quiet and out is None and not json:
        raise InputError("--quiet: then nothing is left of the result: give --out DIR, or --json")
    if quiet:
        logging.getLogger("stribeck").setLevel(logging.WARNING)  # nor what is compiled
    if not figures and out is None:
        raise InputError("--no-figures: figures are drawn with --out DIR alone")

    from ..report.folder import check_folder, held
    from ..report.search_progress import SearchProgress
    from ..report.stopwatch import Stopwatch
    from ..rig.lookup import rig_named

    if out is not None:
        check_folder(out)
    chosen, fixed = with_constants(rig_named(rig), set_, exact=exact)
    name = law_name(chosen, law, directional)
    check_held(chosen, name, list(fixed))
    ends = intervals("--bounds", bounds)
    ties = dict(pairs("--tie", tie))
    settings = {n: setting_value(v) for n, v in pairs("--setting", setting)}
    each_once("--train", train)
    each_once("--holdout", holdout)
    late = delay_value(delay)
    if target is not None:
        above_zero("--target", target)
    if bootstrap < 0:
        raise InputError(f"--bootstrap: give a whole number of refits, got {bootstrap}")
    if posterior < 0:
        raise InputError(f"--posterior: give a whole number of samples, got {posterior}")
    options: dict[str, Any] = {
        "method": method,
        "target": target,
        "budget": budget,
        "repeats": repeats,
    }
    if paper:
        options = _paper(chosen, options | {"setting": setting})

    from ..identify.fit import identify as identified
    from ..identify.request import checked_request
    from ..rig.lookup import rig_and_law

    asked: dict[str, Any] = {
        "fixed": fixed, "bounds": ends, "tie": ties, "loss": loss, "restart": restart,
        "delay": late, "velocity": velocity, "breakaway": breakaway, "bootstrap": bootstrap,
        "posterior": posterior,
    }  # fmt: skip
    search = {**options, "seed": seed, "settings": settings or None}
    checked_request(*rig_and_law(chosen, name), search=search, **asked)
    clock = Stopwatch.of_process()
    clock.lap("start-up")
    recordings = reading.recordings(logs, chosen)
    clock.lap("reading")
    with held(out):
        with SearchProgress(chosen.unit_shown("position"), quiet=quiet) as progress:
            fit = identified(
                recordings,
                rig=chosen,
                law=name,
                train=train or None,
                holdout=holdout or None,
                progress=progress,
                **asked,
                **search,
            )
        clock.lap("search", fit.search.seconds)
        clock.lap("uncertainty")
        _tell(fit, out, clock, json=json, quiet=quiet, figures=figures)


def _tell(
    fit: Fit, out: Path | None, clock: Stopwatch, *, json: bool, quiet: bool, figures: bool
) -> None:
    from ..report.fit_report import show_fit
    from ..report.terminal import show_time

    text = fit.card().text()

    def show() -> None:
        if json:
            typer.echo(text, nl=False)
        elif not quiet:
            show_fit(fit)
        sys.stdout.flush()  # to be read while the figures are drawn
        clock.lap("card")

    if out is None:
        show()
    else:
        _write(fit, text, out, clock, show, figures=figures)
    if not (json or quiet):
        if out is not None:
            typer.echo(f"\ncard{', figures' * figures} and report.html in {out}")
        show_time(clock)
    if fit.search.ended == "interrupted":
        place = f"in {out / 'card.json'}" if out is not None else "printed above"
        fail(f"interrupted: the partial result is {place}", interruption.status)


def _write(
    fit: Fit,
    card: str,
    out: Path,
    clock: Stopwatch,
    show: Callable[[], None],
    *,
    figures: bool,
) -> None:
    """Write a fit into its folder: its card in place of an older fit, then what can be made anew.

    It is shown before its figures are drawn.
    """
    from ..data.readers.raw_table import printable
    from ..report.contents.gather import Contents
    from ..report.contents.schema import OF_A_FIT
    from ..report.folder import together, write_text

    written = shown = False
    try:
        with together(out, OF_A_FIT) as place:
            write_text(place / "card.json", card)  # hours of search, and a fit without figures
            written = True
        show()
        shown = True
        from ..report.figures.fit_figures import write_figures
        from ..report.page.html_page import write_report

        contents = Contents(fit)
        write_report(contents.report(["stribeck", *map(printable, sys.argv[1:])]), out)
        clock.lap("report")
        if figures:
            write_figures(contents, out)
        clock.lap("figures")
    except KeyboardInterrupt:
        if not written:
            raise
        fail(
            f"interrupted: the result is in {out}, without all of its figures", interruption.status
        )
    except InputError:
        if not shown:  # hours of search are still told
            show()
        raise


def _paper(rig: Rig, settings: dict[str, Any]) -> dict[str, Any]:
    from ..bench.problems import PAPER_TARGET

    if rig.approach != "output_error":
        raise InputError(f"--paper is a search, and rig {rig.name} is solved by least squares")
    if clashing := [f"--{n}" for n, v in settings.items() if v]:
        raise InputError(f"--paper fixes the method and its end: leave out {', '.join(clashing)}")
    return {
        "method": "bts",
        "target": PAPER_TARGET,
        "budget": 10**6,
        "repeats": 1,
        "polishing": False,
    }


def report(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="A folder that `identify --out` wrote.")],
    json: Annotated[bool, typer.Option("--json", help="Print the file written as JSON.")] = False,
) -> None:  # fmt: skip
    """Make the page of a fit again from its report.json: one file, to look at and to print."""
    from ..report.contents.schema import check_report_folder
    from ..report.folder import held
    from ..report.page.html_page import write_page

    check_report_folder(folder)
    with held(folder):
        show_files([write_page(folder)], json=json)


@reads_logs
def select(
    logs: Logs,
    rig: RigName = None,
    laws: Annotated[str | None, typer.Option(metavar="A,B,...", help="Laws to compare; those of the rig by default.", autocompletion=laws_named)] = None,
    train: Train = None,
    holdout: Annotated[list[str] | None, typer.Option(metavar="A:B", help="Positions (or times) to hold out; by default logs, or parts of them, in turn.")] = None,
    test: Annotated[list[Path] | None, typer.Option(metavar="LOG", help="Other logs to hold out as a whole.")] = None,
    set_: Set = None,
    exact: Exact = False,
    bounds: Bounds = None,
    seed: Seed = None,
    budget: Annotated[int | None, typer.Option(metavar="N", help="Evaluations for each fit; 4000 by default.")] = None,
    delay: DelayText = "auto",
    velocity: Annotated[str, typer.Option(metavar="auto|recorded|position", help="The velocity of a force balance.")] = "auto",
    folds: Annotated[int | None, typer.Option(metavar="K", help="Rounds, where nothing is given to hold out; 5 by default.")] = None,
    loss: LossOption = "squares",
    out: Annotated[Path | None, typer.Option(metavar="DIR", help="Write selection.json, the card of the recommended law and a figure there.")] = None,
    json: Json = False,
    reading: Reading = Reading(),  # noqa: B008 - options of its own
) -> None:  # fmt: skip
    """Compare friction laws on data held out, and recommend the simplest that holds."""
    check_there([*logs, *(test or [])])
    rig = rig or no_rig(logs, reading, json=json)

    from ..report.folder import check_folder, held
    from ..report.search_progress import SelectionProgress
    from ..rig.lookup import rig_named

    if out is not None:
        check_folder(out)
    names = None if laws is None else [name.strip() for name in laws.split(",") if name.strip()]
    chosen, fixed = with_constants(rig_named(rig), set_, exact=exact)
    ends = intervals("--bounds", bounds)
    each_once("--train", train)
    each_once("--holdout", holdout)
    late = delay_value(delay)

    from ..identify.selection.laws_asked import checked_comparison
    from ..identify.selection.select import select as selected

    asked: dict[str, Any] = {
        "laws": names, "fixed": fixed, "bounds": ends, "seed": seed, "budget": budget,
        "folds": folds, "loss": loss, "delay": late, "velocity": velocity,
    }  # fmt: skip
    checked_comparison(chosen, **asked)
    recordings = reading.recordings([*logs, *(test or [])], chosen)
    with held(out):
        with SelectionProgress(chosen.unit_shown("position")) as progress:
            selection = selected(
                recordings[: len(logs)],
                rig=chosen,
                train=train or None,
                holdout=holdout or None,
                test=recordings[len(logs) :] or None,
                progress=progress.step,
                **asked,
            )
        _tell_selection(selection, out, json)


def _tell_selection(selection: Selection, out: Path | None, json: bool) -> None:
    from ..report.selection_report import selection_text, show_selection

    def show() -> None:
        if json:
            typer.echo(selection_text(selection), nl=False)
        else:
            show_selection(selection)
        sys.stdout.flush()

    if out is None:
        show()
    else:
        _write_selection(selection, out, show)
        if not json:
            typer.echo(f"\ncomparison, card of {selection.law} and figure in {out}")
    if selection.interrupted:
        place = f"in {out}" if out is not None else "printed above"
        if selection.skipped:
            place += f", without {', '.join(selection.skipped)}"
        result = "partial result" if selection.skipped else "result"
        fail(f"interrupted: the {result} is {place}", interruption.status)


def _write_selection(selection: Selection, out: Path, show: Callable[[], None]) -> None:
    """Write a comparison into its folder in place of older results, then its card and figure.

    It is shown before these are made.
    """
    from ..report.contents.schema import OF_A_FIT
    from ..report.folder import together
    from ..report.selection_report import OF_A_SELECTION, write_card, write_figure, write_selection

    left = ["comparison", f"card of {selection.law}", "figure"]
    shown = False
    try:
        with together(out, OF_A_FIT, OF_A_SELECTION) as place:
            write_selection(selection, place)
            left.pop(0)
        show()
        shown = True
        write_card(selection, out)
        left.pop(0)
        write_figure(selection, out)
    except KeyboardInterrupt:
        if "comparison" in left:
            raise
        missing = " and ".join(left)
        fail(f"interrupted: the result is in {out}, without its {missing}", interruption.status)
    except InputError:
        if not shown:  # the work is still told
            show()
        raise
