"""The command line: parse, call, print."""

from __future__ import annotations

import atexit
import gc
import io
import math
import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NoReturn, cast

import typer

from .errors import InputError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from .bench.campaign import Campaign
    from .bench.engines import Engine
    from .bench.record import Job
    from .data import Recording
    from .identify.card import Card
    from .identify.found import Fit
    from .identify.problem import Parameters
    from .identify.select import Selection
    from .report.stopwatch import Stopwatch
    from .rig import Rig

app = typer.Typer(
    name="stribeck",
    help="From a motion log to a friction model you can trust.",
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"]},
)

#: Objects made between two looks of the garbage collector: nearly all that a start makes stay,
#: and looking through them every 700, as Python does, takes an eighth of the start.
GC_THRESHOLD = 50_000
#: Options that may be given more than once.
REPEATABLE = frozenset(
    {"--train", "--holdout", "--set", "--bounds", "--tie", "--setting", "--range", "--test"}
)
#: Options that take all that follows up to the next one.
GREEDY = frozenset({"--test"})
FORMS = {
    "--set": "NAME=VALUE",
    "--setting": "NAME=VALUE",
    "--bounds": "NAME=LO:HI",
    "--tie": "NAME=OTHER",
}
#: Standard deviation of an echo that can still be called one, mm: a quarter of the stroke.
NOISIEST = 100.0
#: A message is a line, not a page.
LONGEST = 600

Logs = Annotated[
    list[Path],
    typer.Argument(metavar="LOG...", help="Recordings: CSV, TSV, Parquet, MATLAB, JSON."),
]
Columns = Annotated[
    Path | None,
    typer.Option(metavar="MAP.toml", help="Which column is what, where the heads do not say."),
]
RigName = Annotated[
    str, typer.Option("--rig", metavar="RIG", help="A rig's name (see `rigs`) or a TOML file.")
]
Set = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="NAME=VALUE", help="A rig's constant, or a parameter to hold."),
]
Json = Annotated[bool, typer.Option("--json", help="Print the result as JSON.")]


def main() -> None:
    """Run the command line; whatever the user got wrong is one line and exit status 2."""
    gc.set_threshold(GC_THRESHOLD)
    atexit.register(gc.freeze)  # to look through it all once more at the end takes half a second
    _open_streams()
    try:
        given = _spread(_checked(sys.argv[1:])) or ["--help"]
        with typer.main.get_command(app).make_context("stribeck", given) as context:
            context.command.invoke(context)
    except typer.Exit as done:
        sys.exit(done.exit_code)
    except InputError as error:
        _fail(str(error), 2)
    except typer.TyperException as error:
        _fail(_misused(error), 2)
    except KeyboardInterrupt:
        _fail("interrupted before there was a result: nothing was written", 130)
    except BrokenPipeError:  # the reader of our output has gone
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # nor complain at the end
        sys.exit(141)
    except OSError as error:
        _fail(f"{error.filename or 'output'}: {error.strerror or error}", 2)
    except MemoryError:
        _fail("out of memory: ask for less at once, or take a shorter log", 2)


def _open_streams() -> None:
    """Somewhere to print to, whatever the one who started us closed or can show."""
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:
            setattr(sys, name, Path(os.devnull).open("w", encoding="utf-8"))  # noqa: SIM115
    if isinstance(sys.stdout, io.TextIOWrapper):  # names in a log may not fit its alphabet
        sys.stdout.reconfigure(errors="backslashreplace")


def _fail(message: str, status: int) -> NoReturn:
    line = " ".join("".join(c if c.isprintable() else " " for c in message).split())
    if len(line) > LONGEST:  # what is wrong comes last
        line = f"{line[: LONGEST // 2]} ... {line[-LONGEST // 2 :]}"
    typer.echo(f"stribeck: {line}", err=True)
    sys.exit(status)


def _misused(error: typer.TyperException) -> str:
    """What the parser found, with the value that it could not take."""
    found: Any = getattr(error.__cause__, "errors", list)()
    options = getattr(getattr(error, "param", None), "opts", ())
    if not (found and options):
        return f"{error.format_message().rstrip('.')} (see stribeck --help)"
    kind = {"int_parsing": "a whole number", "float_parsing": "a number"}.get(found[0]["type"])
    name, value = options[0], found[0]["input"]
    return f"{name}: {value!r} is not {kind}" if kind else f"{name} {value!r}: {found[0]['msg']}"


def _checked(given: list[str]) -> list[str]:
    """The arguments, unless one is empty or an option that holds one value has two.

    An empty argument is a shell variable without a value; the last of two options would win
    silently.
    """
    options = [text.partition("=")[0] for text in given if text.startswith("--")]
    for text in given:
        if not text.strip() or (text.startswith("--") and text.endswith("=")):
            raise InputError(f"an argument is empty: {text or repr(text)} needs a value")
    for name in options:
        if name not in REPEATABLE and options.count(name) > 1:
            raise InputError(f"{name} is given twice: give it once")
    return given


def _spread(given: list[str]) -> list[str]:
    """The arguments with `--test A B` written as `--test A --test B`, as shells expand names."""
    spread: list[str] = []
    taking, fresh = "", False
    for text in given:
        if text.startswith("-"):
            taking, fresh = (text, True) if text in GREEDY else ("", False)
        elif taking and not fresh:
            spread.append(taking)
        else:
            fresh = False
        spread.append(text)
    return spread


def _print_version(asked: bool) -> None:
    if asked:
        version()
        raise typer.Exit


@app.callback()
def options(
    version: Annotated[bool, typer.Option("--version", help="Print the version.", is_eager=True, callback=_print_version)] = False,
) -> None:  # fmt: skip
    """From a motion log to a friction model you can trust."""
    del version


@app.command()
def twin(
    out: Annotated[Path, typer.Argument(metavar="OUT.csv", help="The log to write.")],
    direction: Annotated[
        str, typer.Option(metavar="up|down|both", help="Ramp up, down, or up and down.")
    ] = "both",
    seed: Annotated[int, typer.Option(metavar="N", help="Seed of the sensor noise.")] = 0,
    speed: Annotated[float, typer.Option(metavar="MM/S", help="Speed of the ramp.")] = 5.0,
    noise: Annotated[float, typer.Option(metavar="MM", help="Noise of an ultrasonic echo.")] = 0.3,
    rate: Annotated[float, typer.Option(metavar="HZ", help="Rate of the log.")] = 100.0,
    echo_rate: Annotated[float, typer.Option(metavar="HZ", help="Rate of the transducer.")] = 50.0,
) -> None:
    """Record the paper's test bed, simulated with its sensors; the truth is written beside the log."""
    from .report.twin import write_twin
    from .rig.testbed import TestBed

    given = {"--speed": speed, "--rate": rate, "--echo-rate": echo_rate}
    for option, value in given.items():
        _above_zero(option, value)
    if not 0 <= noise <= NOISIEST:
        raise InputError(f"--noise: give 0 to {NOISIEST:g} mm, got {noise:g}")
    bed = TestBed(speed=speed * 1e-3, echo_noise=noise * 1e-3, rate=rate, echo_rate=echo_rate)
    for file in write_twin(bed, direction, seed, out):
        typer.echo(file)


@app.command()
def check(
    log: Annotated[Path, typer.Argument(metavar="LOG", help="A recording.")],
    columns: Columns = None,
    rig: Annotated[
        str | None, typer.Option(metavar="RIG", help="Read the log as this rig's.")
    ] = None,
    json: Json = False,
) -> None:
    """Say what is in a log, and what it is good enough for."""
    from .data import check as looked_at
    from .report.terminal import quality_text, show_quality

    (recording,) = _read([log], _rig(rig) if rig is not None else None, columns)
    quality = looked_at(recording)
    if json:
        typer.echo(quality_text(quality), nl=False)
    else:
        show_quality(quality)


@app.command()
def identify(
    logs: Logs,
    rig: RigName,
    law: Annotated[str | None, typer.Option(metavar="L", help="A friction law (see `laws`).")] = None,
    directional: Annotated[bool, typer.Option("--directional", help="Parameters for each direction.")] = False,
    method: Annotated[str | None, typer.Option(metavar="M", help="A search method (see `methods`).")] = None,
    train: Annotated[list[str] | None, typer.Option(metavar="A:B", help="Positions (or 10s:40s) to train on.")] = None,
    holdout: Annotated[list[str] | None, typer.Option(metavar="A:B", help="Positions (or times) to validate on.")] = None,
    set_: Set = None,
    bounds: Annotated[list[str] | None, typer.Option(metavar="NAME=LO:HI", help="Search range of a parameter.")] = None,
    tie: Annotated[list[str] | None, typer.Option(metavar="NAME=OTHER", help="Make one parameter equal another.")] = None,
    setting: Annotated[list[str] | None, typer.Option(metavar="NAME=VALUE", help="A setting of the method.")] = None,
    seed: Annotated[int | None, typer.Option(metavar="N", help="Seed of the searches.")] = None,
    budget: Annotated[int | None, typer.Option(metavar="N", help="Evaluations for each repeat.")] = None,
    repeats: Annotated[int | None, typer.Option(metavar="N", help="Independent searches.")] = None,
    target: Annotated[float | None, typer.Option(metavar="J", help="End a search at this J.")] = None,
    paper: Annotated[bool, typer.Option("--paper", help="The paper's run: to J < 4.5 or 1000 rounds, one search, no polishing.")] = False,
    loss: Annotated[str, typer.Option(metavar="squares|absolute", help="What of the errors counts.")] = "squares",
    restart: Annotated[bool, typer.Option("--restart", help="Simulate from rest to rest, not through.")] = False,
    bootstrap: Annotated[int, typer.Option(metavar="N", help="Refits of redrawn residuals (200, say).")] = 0,
    columns: Columns = None,
    out: Annotated[Path | None, typer.Option(metavar="DIR", help="Write card.json, figures and report.html there.")] = None,
    json: Json = False,
) -> None:  # fmt: skip
    """Identify the friction of an axis from recordings of it."""
    from .identify.fit import identify as identified
    from .report.folder import check_folder
    from .report.stopwatch import Stopwatch
    from .report.terminal import Watch

    clock = Stopwatch.of_process()
    if out is not None:
        check_folder(out)
    chosen, fixed = _set(_rig(rig), law, directional, set_ or [])
    ends = {n: _interval(v, n) for n, v in _pairs("--bounds", bounds)}
    ties = dict(_pairs("--tie", tie))
    settings = {n: _value(v) for n, v in _pairs("--setting", setting)}
    _each_once("--train", train)
    _each_once("--holdout", holdout)
    if target is not None:
        _above_zero("--target", target)
    if bootstrap < 0:
        raise InputError(f"--bootstrap: give a whole number of refits, got {bootstrap}")
    asked: dict[str, Any] = {
        "method": method,
        "target": target,
        "budget": budget,
        "repeats": repeats,
    }
    if paper:
        asked = _paper(chosen, asked | {"setting": setting})
    clock.lap("start-up")
    recordings = _read(logs, chosen, columns)
    clock.lap("reading")
    with Watch(chosen.shows.get("position", "m")) as watch:
        fit = identified(
            recordings,
            rig=chosen,
            law=_law(chosen, law, directional),
            train=train or None,
            holdout=holdout or None,
            fixed=fixed,
            bounds=ends,
            tied=ties,
            seed=seed,
            settings=settings,
            loss=cast("Any", loss),
            restart=restart,
            draws=bootstrap,
            look=watch,
            **asked,
        )
    clock.lap("search", fit.seconds)
    clock.lap("uncertainty")
    _tell(fit, out, json, clock)


def _tell(fit: Fit, out: Path | None, json: bool, clock: Stopwatch) -> None:
    from .identify.card import card
    from .report.folder import write_figures, write_text
    from .report.page import write_report
    from .report.terminal import show_fit, show_time

    text = card(fit).text()
    unwritten: InputError | None = None
    try:
        if out is not None:
            write_text(out / "card.json", text)  # first: whatever happens, the numbers are safe
    except InputError as error:  # hours of search are still told
        unwritten = error
    if json:
        typer.echo(text, nl=False)
    else:
        show_fit(fit)
    sys.stdout.flush()  # to be read while the figures are drawn
    if unwritten is not None:
        raise unwritten
    clock.lap("card")
    if out is not None:
        try:
            write_figures(fit, out)
            clock.lap("figures")
            write_report(fit, out, ["stribeck", *sys.argv[1:]])
        except KeyboardInterrupt:
            _fail(f"interrupted: the result is in {out}, without all of its figures", 130)
        clock.lap("report")
    if not json:
        if out is not None:
            typer.echo(f"\ncard, figures and report.html in {out}")
        show_time(clock)
    if fit.ended == "interrupted":
        where = f"in {out / 'card.json'}" if out is not None else "printed above"
        _fail(f"interrupted: the partial result is {where}", 130)


@app.command()
def report(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="A folder that `identify --out` wrote.")],
) -> None:  # fmt: skip
    """Make the page of a fit again from its report.json: one file, to look at and to print."""
    from .report.page import write_page

    typer.echo(write_page(folder))


@app.command()
def select(
    logs: Logs,
    rig: RigName,
    laws: Annotated[str | None, typer.Option(metavar="A,B,...", help="Laws to compare; those of the rig by default.")] = None,
    train: Annotated[list[str] | None, typer.Option(metavar="A:B", help="Positions (or 10s:40s) to train on.")] = None,
    holdout: Annotated[list[str] | None, typer.Option(metavar="A:B", help="Positions (or times) to hold out.")] = None,
    test: Annotated[list[Path] | None, typer.Option(metavar="LOG...", help="Other logs to hold out as a whole.")] = None,
    set_: Set = None,
    bounds: Annotated[list[str] | None, typer.Option(metavar="NAME=LO:HI", help="Search range of a parameter.")] = None,
    seed: Annotated[int | None, typer.Option(metavar="N", help="Seed of the searches.")] = None,
    budget: Annotated[int | None, typer.Option(metavar="N", help="Evaluations for each fit.")] = None,
    folds: Annotated[int | None, typer.Option(metavar="K", help="Rounds, where nothing is given to hold out; 5 by default.")] = None,
    columns: Columns = None,
    out: Annotated[Path | None, typer.Option(metavar="DIR", help="Write selection.json, the card of the recommended law and a figure there.")] = None,
    json: Json = False,
) -> None:  # fmt: skip
    """Compare friction laws on data held out, and recommend the simplest that holds."""
    from .identify.select import select as selected
    from .report.folder import check_folder
    from .report.selection import Climb

    if out is not None:
        check_folder(out)
    ladder = None if laws is None else [name.strip() for name in laws.split(",") if name.strip()]
    chosen, fixed = _constants(_rig(rig), set_ or [])
    ends = {n: _interval(v, n) for n, v in _pairs("--bounds", bounds)}
    _each_once("--train", train)
    _each_once("--holdout", holdout)
    recordings = _read([*logs, *(test or [])], chosen, columns)
    with Climb(chosen.shows.get("position", "m")) as climb:
        selection = selected(
            recordings[: len(logs)],
            rig=chosen,
            laws=ladder,
            train=train or None,
            holdout=holdout or None,
            test=recordings[len(logs) :] or None,
            fixed=fixed,
            bounds=ends,
            seed=seed,
            budget=budget,
            folds=folds,
            look=climb.look,
        )
    _tell_selection(selection, out, json)


def _tell_selection(selection: Selection, out: Path | None, json: bool) -> None:
    from .report.selection import selection_text, show_selection, write_figure, write_selection

    unwritten: InputError | None = None
    try:
        if out is not None:
            write_selection(selection, out)
    except InputError as error:  # the work is still told
        unwritten = error
    if json:
        typer.echo(selection_text(selection), nl=False)
    else:
        show_selection(selection)
    sys.stdout.flush()
    if unwritten is not None:
        raise unwritten
    if out is not None:
        try:
            write_figure(selection, out)
        except KeyboardInterrupt:
            _fail(f"interrupted: the result is in {out}, without its figure", 130)
        if not json:
            typer.echo(f"\ncomparison, card of {selection.law} and figure in {out}")
    if selection.left:
        where = f"in {out}" if out is not None else "printed above"
        left = ", ".join(selection.left)
        _fail(f"interrupted: the partial result is {where}, without {left}", 130)


@app.command()
def validate(
    card: Annotated[Path, typer.Argument(metavar="CARD", help="A card that `identify` wrote.")],
    logs: Logs,
    range_: Annotated[list[str] | None, typer.Option("--range", metavar="A:B", help="Positions or times; all by default.")] = None,
    max_error: Annotated[float | None, typer.Option(metavar="X", help="Exit with status 1 above this error.")] = None,
    columns: Columns = None,
    json: Json = False,
) -> None:  # fmt: skip
    """Hold an identified model against other recordings."""
    from .identify.validate import validate as validated
    from .report.terminal import show_validation, validation_text

    if max_error is not None:
        _above_zero("--max-error", max_error)
    _each_once("--range", range_)
    written, made, _ = _card(card)
    recordings = _read(logs, made.rig, columns)
    rows = validated(written, recordings, range_ or None)
    for log, _, score in rows:
        if not math.isfinite(score.value):
            raise InputError(f"{card}: its values cannot be simulated on {log}: check the card")
    if json:
        typer.echo(validation_text(written, rows), nl=False)
    else:
        show_validation(written, rows)
    worst = max(score.value for _, _, score in rows)
    if max_error is not None and not worst <= max_error:
        typer.echo(
            f"stribeck: the model does not hold: {worst:.4g} is above {max_error:g}", err=True
        )
        raise typer.Exit(1)


@app.command()
def plan(
    card: Annotated[Path, typer.Argument(metavar="CARD", help="A card that `identify` wrote.")],
    logs: Annotated[list[Path] | None, typer.Argument(metavar="LOG...", help="The logs of the card; by default those that it names, beside it.")] = None,
    seconds: Annotated[float | None, typer.Option(metavar="S", help="Length of an experiment; as long as the data, two minutes at most, by default.")] = None,
    check: Annotated[int, typer.Option(metavar="N", help="Try the best three on N twins, simulated and refitted.")] = 0,
    seed: Annotated[int, typer.Option(metavar="N", help="Seed of the draws and twins.")] = 0,
    columns: Columns = None,
    json: Json = False,
) -> None:  # fmt: skip
    """Rank experiments by how much they would tell of what is badly known."""
    from .identify.model import logs_beside
    from .identify.plan import plan as planned
    from .report.planning import plan_text, show_plan

    if seconds is not None:
        _above_zero("--seconds", seconds)
    written, made, _ = _card(card)
    recordings = _read(logs or logs_beside(written, card), made.rig, columns)
    found = planned(written, recordings, seconds=seconds, check=check, seed=seed)
    if json:
        typer.echo(plan_text(found), nl=False)
    else:
        show_plan(found)


@app.command()
def compensate(
    card: Annotated[Path, typer.Argument(metavar="CARD", help="A card that `identify` wrote.")],
    rig: Annotated[str | None, typer.Option(metavar="RIG", help="The axis to compensate; the card's by default.")] = None,
    speed: Annotated[float | None, typer.Option(metavar="V", help="Of the slowest motion, in the rig's unit; the card's logs' by default.")] = None,
    period: Annotated[float, typer.Option(metavar="MS", help="Sample time of the controller.")] = 1.0,
    mode: Annotated[str | None, typer.Option(metavar="reference|feedback", help="Velocity at which the law is asked; both are tried by default.")] = None,
    scale: Annotated[float | None, typer.Option(metavar="S", help="Try this share of the friction only.")] = None,
    reference: Annotated[Path | None, typer.Option(metavar="LOG", help="Follow the command of a log.")] = None,
    resolution: Annotated[float, typer.Option(metavar="X", help="A count of the position sensor, in the rig's unit.")] = 0.0,
    noise: Annotated[float, typer.Option(metavar="X", help="Noise of the position sensor, in the rig's unit.")] = 0.0,
    columns: Columns = None,
    out: Annotated[Path | None, typer.Option(metavar="DIR", help="Write compensation.json and a figure there.")] = None,
    json: Json = False,
) -> None:  # fmt: skip
    """Say how much of a friction may be compensated, and what that gains."""
    from .export.compensation import compensation
    from .export.references import followed
    from .identify.model import logs_beside
    from .report.compensation import compensation_text, show_compensation, write_compensation
    from .report.folder import check_folder
    from .rig.compensated import Sensor, controlled
    from .units import unit

    if out is not None:
        check_folder(out)
    _above_zero("--period", period)
    if mode not in (None, "reference", "feedback"):
        raise InputError(f"--mode {mode!r} is not one of reference, feedback")
    if speed is not None and reference is not None:
        raise InputError("--speed and --reference both say what to follow: give one")
    written, made, _ = _card(card)
    on = made.rig if rig is None else _rig(rig)
    controlled(on)
    logs = [] if reference is None else [reference]
    if speed is None and reference is None:
        try:
            logs = logs_beside(written, card)
        except InputError as error:
            raise InputError(
                f"{card}: its logs are not beside it: give --speed or --reference"
            ) from error
    recordings = _read(logs, on, columns)
    follow = None if reference is None else followed(recordings[0], period * 1e-3)
    to_si = unit(on.shows.get("position", "rad" if on.rotary else "m")).to_si
    per_second = unit(on.shows.get("velocity", "rad/s" if on.rotary else "m/s")).to_si
    found = compensation(
        written,
        None if rig is None else on,
        recordings=recordings,
        speed=None if speed is None else float(per_second(speed)),
        period=period * 1e-3,
        mode=cast("Any", mode),
        scale=scale,
        reference=follow,
        sensor=Sensor(float(to_si(resolution)), float(to_si(noise))),
        look=lambda doing: typer.echo(f"trying {doing}", err=True),
    )
    if json:
        typer.echo(compensation_text(found), nl=False)
    else:
        show_compensation(found)
    sys.stdout.flush()
    if out is not None:
        write_compensation(found, out)
        if not json:
            typer.echo(f"\ncompensation and figure in {out}")
    if found.mode is None:
        raise typer.Exit(1)


@app.command()
def simulate(
    card: Annotated[Path, typer.Argument(metavar="CARD", help="A card that `identify` wrote.")],
    log: Annotated[
        Path, typer.Argument(metavar="LOG", help="A recording whose command is to be followed.")
    ],
    out: Annotated[Path, typer.Option(metavar="FILE.csv", help="Where to write the motion.")],
    columns: Columns = None,
) -> None:
    """Simulate an identified model under the command of a log."""
    from .report.twin import check_motion, write_motion

    check_motion(out, log)
    _, made, p = _card(card)
    (recording,) = _read([log], made.rig, columns)
    write_motion(made, p, recording, out)
    typer.echo(out)


@app.command()
def export(
    card: Annotated[Path, typer.Argument(metavar="CARD", help="A card that `identify` wrote.")],
    to: Annotated[str, typer.Option(metavar="FORMAT", help="c, st, plcopen, table, mjcf, urdf, fmu, modelica, matlab or json.")],
    out: Annotated[Path | None, typer.Option(metavar="PATH", help="The file (c, matlab: the folder) to write; a text goes to the terminal without it.")] = None,
    name: Annotated[str | None, typer.Option(metavar="NAME", help="What functions and files are called.")] = None,
    set_: Annotated[list[str] | None, typer.Option("--set", metavar="NAME=VALUE", help="A setting of the compensator: scale=0.9, feedback=1, dead_band=0.1 ...; of mjcf: lugre=1, firm=1, armature=1.")] = None,
    compensation: Annotated[Path | None, typer.Option(metavar="FILE", help="Settings as `compensate --out` left them, compensation.json.")] = None,
    points: Annotated[int | None, typer.Option(metavar="N", help="Points of a table, 20 by default.")] = None,
    speed: Annotated[float | None, typer.Option(metavar="V", help="Last speed of a table, in the rig's unit.")] = None,
    into: Annotated[Path | None, typer.Option(metavar="FILE", help="Your MJCF or URDF file; it stays as it is.")] = None,
    joint: Annotated[str | None, typer.Option(metavar="NAME", help="The joint of it to patch.")] = None,
) -> None:  # fmt: skip
    """Write an identified model for a controller, a drive or a simulator."""
    from .export import TARGETS, Source, exported, read_model
    from .export.settings import read_settings
    from .report.folder import check_file, check_folder, write_data, write_files

    target = TARGETS.get(to)
    if target is None:
        raise InputError(f"--to {to}: there are {', '.join(TARGETS)}")
    if out is None and (target.folder or not target.text):
        raise InputError(f"--to {to}: give --out, a {'folder' if target.folder else 'file'}")
    if out is not None:
        check_folder(out) if target.folder else check_file(out, target.suffix)
    settings = {n: _float(v, f"--set {n}") for n, v in _pairs("--set", set_)}
    made = exported(
        read_model(card),
        to,
        name=name,
        settings=settings or None,
        compensation=None if compensation is None else read_settings(compensation),
        points=points,
        fastest=speed,
        source=None if into is None else Source(str(into), _bytes(into)),
        joint=joint,
    )
    if target.folder:
        assert out is not None  # noqa: S101 - seen to above

        def write(place: Path) -> None:
            for file, data in made.files.items():
                (place / file).write_bytes(data)

        write_files(out, write)
        for file in made.files:
            typer.echo(out / file)
    else:
        (data,) = made.files.values()
        if out is None:
            typer.echo(data, nl=False)
        else:
            write_data(out, data)
            typer.echo(out)
    for note in made.notes:
        typer.echo(f"note: {note}", err=True)


@app.command()
def bench(
    campaign: Annotated[str, typer.Argument(metavar="paper|twins|bbob|FILE.toml", help="A shipped campaign (paper, twins, bbob) or a file.")],
    trials: Annotated[int | None, typer.Option(metavar="N", help="Runs of every cell, in place of the file's.")] = None,
    engine: Annotated[str, typer.Option(metavar="E", help="here, processes[:N] or dask://HOST:PORT.")] = "processes",
    out: Annotated[Path | None, typer.Option(metavar="DIR", help="Where the store and the results go; bench-NAME by default.")] = None,
    resume: Annotated[bool, typer.Option("--resume", help="Insist on a store that is there; without it one is begun or gone on with.")] = False,
    coco: Annotated[bool, typer.Option("--coco", help="Write BBOB runs as COCO's own data too, and its report.")] = False,
    show: Annotated[bool, typer.Option("--show", help="Print the campaign's file and stop.")] = False,
    status: Annotated[bool, typer.Option("--status", help="Say what is done and what is left, and stop.")] = False,
) -> None:  # fmt: skip
    """Compare search methods: the paper's study, or any campaign."""
    from .bench.campaign import campaign as found
    from .bench.engines import engine as chosen

    made = found(campaign)
    if show:
        typer.echo(made.text, nl=False)
        return
    if coco and not any("bbob" in task.spec for task in made.tasks):
        raise InputError(f"--coco: campaign {made.name} has no problem of BBOB")
    if status:
        from .bench.store import Store
        from .report.study import status as said

        with Store.read((out or Path(f"bench-{made.name}")) / "store.sqlite") as store:
            typer.echo(said(store.progress()).plain(), nl=False)
        return
    made = made if trials is None else made.trials(trials)
    _bench(made, chosen(engine), out or Path(f"bench-{made.name}"), resume, coco)


def _bench(made: Campaign, at: Engine, folder: Path, resume: bool, coco: bool) -> None:
    from .bench.conduct import conduct
    from .bench.record import Failure, Record
    from .bench.store import Store
    from .report.folder import check_folder
    from .report.live import Live
    from .report.study import Study

    check_folder(folder)
    file = folder / "store.sqlite"
    with Store.open(
        file, campaign=made.name, seed=made.seed, text=made.text, must_exist=resume
    ) as store:
        jobs = list(made.jobs())
        store.add(jobs)
        try:
            with Live(made.name, jobs, store.records(), workers=at.workers) as live:
                for outcome in conduct(store, at):
                    if isinstance(outcome, Record):
                        live.done(outcome)
                    elif isinstance(outcome, Failure):
                        live.failed(outcome)
                    else:
                        live.waiting(outcome)
            records, failures = list(store.records()), store.failures()
        except KeyboardInterrupt:
            _fail(
                f"interrupted: {store.left()} runs are left, the others are safe in {file}; "
                "the same command goes on",
                130,
            )
    try:
        study = Study(made, jobs, records, failures)
        study.write(folder)
        typer.echo(study.text(), nl=False)
        if coco:
            _coco([r.job for r in records if "bbob" in r.job.surface], folder / "coco")
    except KeyboardInterrupt:
        _fail(f"interrupted: the runs are safe in {file}; the same command goes on", 130)
    typer.echo(f"\nstore, tables, figures and summary.html in {folder}")
    if failures:
        typer.echo(f"stribeck: {len(failures)} runs failed: see the summary", err=True)
        raise typer.Exit(1)


def _coco(jobs: list[Job], folder: Path) -> None:
    from shutil import rmtree

    from .bench.coco import observe, postprocess

    rmtree(folder / "exdata", ignore_errors=True)  # the same again, or what a kill cut short
    for done, _ in enumerate(observe(jobs, folder), 1):
        if done % 100 == 0 or done == len(jobs):
            typer.echo(f"{done:,}/{len(jobs):,} runs in COCO's own form", err=True)
    typer.echo(f"COCO's report: {postprocess(folder)}")


@app.command()
def laws(name: Annotated[str | None, typer.Argument(metavar="NAME")] = None) -> None:
    """List the friction laws, or explain one."""
    from .report.lists import show_laws

    show_laws(name)


@app.command()
def methods(name: Annotated[str | None, typer.Argument(metavar="NAME")] = None) -> None:
    """List the search methods, or explain one."""
    from .report.lists import show_methods

    show_methods(name)


@app.command()
def rigs(name: Annotated[str | None, typer.Argument(metavar="NAME")] = None) -> None:
    """List the rigs, or show one with its constants."""
    from .report.lists import show_rigs

    show_rigs(_rig(name) if name is not None else None)


@app.command()
def version() -> None:
    """Print the version."""
    from . import __version__

    typer.echo(__version__)


def _rig(name: str) -> Rig:
    from .rig import RIGS
    from .rig.custom import rig_file

    if name.lower().endswith(".toml"):
        return rig_file(Path(name))
    if name not in RIGS:
        raise InputError(f"no rig {name!r}: there are {', '.join(RIGS)}, or give a .toml file")
    return RIGS[name]


def _law(rig: Rig, law: str | None, directional: bool) -> str:
    name = rig.laws[0] if law is None else law
    return f"{name}-directional" if directional and not name.endswith("-directional") else name


def _set(
    rig: Rig, law: str | None, directional: bool, given: Sequence[str]
) -> tuple[Rig, dict[str, float]]:
    """Sort `--set` into the rig's constants and parameters to hold."""
    known = [c.name for c in rig.constants]
    constants: dict[str, float] = {}
    fixed: dict[str, float] = {}
    for name, text in _pairs("--set", given):
        (constants if name in known else fixed)[name] = _float(text, f"--set {name}")
    if fixed:
        from .identify.problem import chosen

        _, about = chosen(rig, _law(rig, law, directional))
        names = {rig.label(q.name) for q in rig.parameters(about)} | {
            q.name for q in rig.parameters(about)
        }
        if strange := [n for n in fixed if n not in names]:
            raise InputError(
                f"--set {strange[0]}: rig {rig.name} has no such constant or parameter: it has "
                f"{', '.join([*known, *(q.name for q in rig.parameters(about))])}"
            )
    return rig.set(**constants), fixed


def _constants(rig: Rig, given: Sequence[str]) -> tuple[Rig, dict[str, float]]:
    """The same where there are several laws: which of them knows a parameter is asked later."""
    known = [c.name for c in rig.constants]
    pairs = [(n, _float(text, f"--set {n}")) for n, text in _pairs("--set", given)]
    return (
        rig.set(**{n: v for n, v in pairs if n in known}),
        {n: v for n, v in pairs if n not in known},
    )


def _paper(rig: Rig, asked: dict[str, Any]) -> dict[str, Any]:
    from .identify.fit import PAPER_TARGET

    if rig.road != "simulation":
        raise InputError(f"--paper is a search, and rig {rig.name} is solved by least squares")
    if both := [f"--{n}" for n, v in asked.items() if v]:
        raise InputError(f"--paper fixes the method and its end: leave out {', '.join(both)}")
    return {
        "method": "bts",
        "target": PAPER_TARGET,
        "budget": 10**6,
        "repeats": 1,
        "polishing": False,
    }


def _card(path: Path) -> tuple[Card, Parameters, Any]:
    """A card, and the rig, law and values that it stands for."""
    from .identify.card import read_card

    written = read_card(path)
    try:
        return (written, *written.model())
    except InputError as error:
        raise InputError(f"{path}: {error}") from error


def _read(logs: Sequence[Path], rig: Rig | None, columns: Path | None) -> list[Recording]:
    from .data import read

    mapping: Any = columns or (dict(rig.columns) if rig is not None and rig.columns else None)
    recordings = [read(log, columns=mapping, lenient=columns is None) for log in logs]
    seen: dict[str, str] = {}
    for recording in recordings:
        if recording.source.sha256 in seen:
            first = seen[recording.source.sha256]
            raise InputError(f"{recording.label}: the same log as {first}: give it once")
        seen[recording.source.sha256] = recording.label
    return recordings


def _bytes(file: Path) -> bytes:
    """A file that is to be patched."""
    from .data.page import page_bytes

    try:
        return page_bytes(file)
    except InputError as error:
        raise InputError(f"{file}: {error}") from error


def _pairs(option: str, given: Sequence[str] | None) -> list[tuple[str, str]]:
    found = []
    for text in given or []:
        name, equals, value = text.partition("=")
        if not (name.strip() and equals and value.strip()):
            raise InputError(f"{option} {text!r}: write {FORMS[option]}")
        found.append((name.strip(), value.strip()))
    names = [n for n, _ in found]
    if twice := {n for n in names if names.count(n) > 1}:
        raise InputError(f"{option}: {', '.join(sorted(twice))} is given twice: give it once")
    return found


def _each_once(option: str, given: Sequence[str] | None) -> None:
    bare = ["".join(text.split()) for text in given or []]
    if twice := {text for text in bare if bare.count(text) > 1}:
        raise InputError(f"{option} {min(twice)} is given twice: give it once")


def _above_zero(option: str, value: float) -> None:
    if not 0 < value < math.inf:
        raise InputError(f"{option}: give a number above 0, got {value:g}")


def _interval(text: str, name: str) -> tuple[float, float]:
    low, colon, high = text.partition(":")
    if not colon:
        raise InputError(f"--bounds {name}={text}: write NAME=LO:HI")
    return _float(low, f"--bounds {name}"), _float(high, f"--bounds {name}")


def _float(text: str, where: str) -> float:
    try:
        value = float(text)
    except ValueError:
        raise InputError(f"{where}: {text!r} is not a number") from None
    if not math.isfinite(value):
        raise InputError(f"{where}: {text!r} is not a finite number")
    return value


def _value(text: str) -> Any:
    """A setting as its method takes it: a number, None, pairs such as [[8, 0.01]], or a word."""
    from json import loads

    for kind in (int, float, loads):
        try:
            return kind(text)
        except (ValueError, RecursionError):
            continue
    return None if text == "None" else text
