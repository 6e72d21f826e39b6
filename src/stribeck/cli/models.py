"""Commands that take a card: hold a model against logs, use it, hand it on."""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, cast

import typer

from ..errors import InputError
from .completions import rig_names, target_names
from .exits import fail, show_files
from .inputs import (
    CardFile,
    Json,
    Logs,
    above_zero,
    card_model,
    delay_value,
    each_once,
    numbers,
)
from .interruption import interruption
from .notices import warn_of_doubts
from .reading import Reading, reads_logs

if TYPE_CHECKING:
    from ..identify.card import Card as WrittenCard


@reads_logs
def validate(
    card: CardFile,
    logs: Logs,
    range_: Annotated[list[str] | None, typer.Option("--range", metavar="A:B", help="Positions or times; all by default.")] = None,
    max_error: Annotated[float | None, typer.Option(metavar="X", help="Exit with status 1 above this error; no limit by default.")] = None,
    delay: Annotated[str, typer.Option(metavar="auto|off|MS", help="By how many ms the force (or command) is after the motion; auto takes what the card says of its own logs.")] = "auto",
    json: Json = False,
    reading: Reading = Reading(),  # noqa: B008 - options of its own
) -> None:  # fmt: skip
    """Hold an identified model against other recordings."""
    from ..identify.validate import untrained_directions
    from ..identify.validate import validate as validated
    from ..report.validation_report import show_validation, validation_text

    if max_error is not None:
        above_zero("--max-error", max_error)
    each_once("--range", range_)
    late = delay_value(delay)
    written, parameters, _ = card_model(card)
    recordings = reading.recordings(logs, parameters.rig)
    rows = validated(written, recordings, range_ or None, delay=late)
    for sentence in untrained_directions(written, recordings, range_ or None):
        typer.echo(f"warning: {sentence}", err=True)
    warn_of_doubts(parameters.rig, recordings)
    if late == "auto" and written.delay:
        typer.echo(
            f"note: the force (or command) is taken to be {1e3 * written.delay:.4g} ms after the "
            "motion, as in the card's own logs: --delay says otherwise",
            err=True,
        )
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


@reads_logs
def plan(
    card: CardFile,
    logs: Annotated[list[Path] | None, typer.Argument(metavar="LOG", help="The logs of the card; by default those that it names, beside it.")] = None,
    seconds: Annotated[float | None, typer.Option(metavar="S", help="Length of an experiment; as long as the data, two minutes at most, by default.")] = None,
    check: Annotated[int, typer.Option(metavar="N", help="Try the best three on N twins, simulated and refitted; none by default.", show_default=False)] = 0,
    seed: Annotated[int, typer.Option(metavar="N", help="Seed of the draws and twins.")] = 0,
    json: Json = False,
    reading: Reading = Reading(),  # noqa: B008 - options of its own
) -> None:  # fmt: skip
    """Rank experiments by how much they would tell of what is badly known."""
    from ..identify.card import read_card
    from ..identify.card_logs import logs_beside

    if seconds is not None:
        above_zero("--seconds", seconds)
    logs = logs or logs_beside(read_card(card), card)
    written, parameters, _ = card_model(card)
    recordings = reading.recordings(logs, parameters.rig)

    # Compiled code is loaded once the logs are known to be there.
    from ..identify.design.plan import plan as planned
    from ..report.plan_report import plan_text, show_plan

    result = planned(written, recordings, seconds=seconds, check=check, seed=seed)
    if json:
        typer.echo(plan_text(result), nl=False)
    else:
        show_plan(result)
    if result.interrupted:
        fail("interrupted: the partial result is printed above", interruption.status)


@reads_logs
def compensate(
    card: CardFile,
    rig: Annotated[str | None, typer.Option(metavar="RIG", help="The axis to compensate; the card's by default.", autocompletion=rig_names)] = None,
    loop: Annotated[Path | None, typer.Option(metavar="FILE.toml", help="Gains, period, delay, limit and sensor of its position loop.")] = None,
    speed: Annotated[float | None, typer.Option(metavar="V", help="Of the slowest motion, in the rig's unit; the card's logs' by default.")] = None,
    period: Annotated[float | None, typer.Option(metavar="MS", help="Sample time of the controller; 1 ms by default.")] = None,
    mode: Annotated[str | None, typer.Option(metavar="reference|crossover|feedback", help="Velocity at which the law is asked; all are tried by default.")] = None,
    scale: Annotated[float | None, typer.Option(metavar="S", help="Try this share of the friction only.")] = None,
    reference: Annotated[Path | None, typer.Option(metavar="LOG", help="Follow the command of a log.")] = None,
    resolution: Annotated[float | None, typer.Option(metavar="X", help="A count of the position sensor, in the rig's unit.")] = None,
    noise: Annotated[float | None, typer.Option(metavar="X", help="Noise of the position sensor, in the rig's unit.")] = None,
    out: Annotated[Path | None, typer.Option(metavar="DIR", help="Write compensation.json and a figure there.")] = None,
    json: Json = False,
    reading: Reading = Reading(),  # noqa: B008 - options of its own
) -> None:  # fmt: skip
    """Say how much of a friction may be compensated, and what that gains."""
    from ..report.folder import check_folder, held
    from ..rig.lookup import rig_named
    from ..rig.loop_file import StatedLoop, loop_file
    from ..units import unit

    if out is not None:
        check_folder(out)
    if period is not None:
        above_zero("--period", period)
    if mode not in (None, "reference", "crossover", "feedback"):
        raise InputError(f"--mode {mode!r} is not one of reference, crossover, feedback")
    if speed is not None and reference is not None:
        raise InputError("--speed and --reference both say what to follow: give one")
    written, parameters, _ = card_model(card)
    rig_used = parameters.rig if rig is None else rig_named(rig)
    stated = StatedLoop() if loop is None else loop_file(loop, rig_used)
    logs = _followed_logs(written, card, reference, speed)

    # Compiled code is loaded once the files are known to be there.
    from ..compensate.closed_loop import Sensor
    from ..compensate.compensation import around
    from ..compensate.compensation import compensate as tried
    from ..compensate.reference_motions import followed
    from ..report.compensation_report import (
        compensation_text,
        show_compensation,
        write_compensation,
    )

    around(rig_used, stated.controller)
    recordings = reading.recordings(logs, rig_used)
    sample = stated.period if period is None else period * 1e-3
    to_si = unit(rig_used.unit_shown("position")).to_si
    per_second = unit(rig_used.unit_shown("velocity")).to_si
    with held(out):
        result = tried(
            written,
            None if rig is None else rig_used,
            loop=stated.controller,
            logs=recordings or None,
            speed=None if speed is None else float(per_second(speed)),
            period=sample,
            mode=cast("Any", mode),
            scale=scale,
            reference=None if reference is None else followed(recordings[0], sample),
            sensor=Sensor(
                stated.resolution if resolution is None else float(to_si(resolution)),
                stated.noise if noise is None else float(to_si(noise)),
            ),
            progress=lambda doing: typer.echo(f"trying {doing}", err=True),
        )
        if json:
            typer.echo(compensation_text(result), nl=False)
        else:
            show_compensation(result)
        sys.stdout.flush()
        if out is not None:
            write_compensation(result, out)
            if not json:
                typer.echo(f"\ncompensation and figure in {out}")
    if result.mode is None:
        raise typer.Exit(1)


def _followed_logs(
    written: WrittenCard, card: Path, reference: Path | None, speed: float | None
) -> list[Path]:
    """The log to follow, or those of a card that does not remember how they moved."""
    from ..identify.card_logs import logs_beside

    if reference is not None:
        return [reference]
    if speed is not None or written.pace is not None:
        return []
    try:
        return logs_beside(written, card)
    except InputError as error:
        raise InputError(
            f"{card}: its logs are not beside it: give --speed or --reference"
        ) from error


@reads_logs
def simulate(
    card: CardFile,
    log: Annotated[
        Path, typer.Argument(metavar="LOG", help="A recording whose command is to be followed.")
    ],
    out: Annotated[Path, typer.Option(metavar="FILE.csv", help="Where to write the motion.")],
    json: Json = False,
    reading: Reading = Reading(),  # noqa: B008 - options of its own
) -> None:
    """Simulate an identified model under the command of a log."""
    from ..identify.simulate import simulate as simulated
    from ..report.motion_file import check_motion, write_motion

    check_motion(out, log)
    written, parameters, _ = card_model(card)
    recording = reading.recording(log, parameters.rig)
    motion = simulated(written, recording)
    warn_of_doubts(parameters.rig, [recording])
    write_motion(parameters.rig, motion, out)
    show_files([out], json=json)


def export(
    card: CardFile,
    to: Annotated[str, typer.Option(metavar="FORMAT", help="c, st, plcopen, table, mjcf, urdf, usd, fmu, modelica, matlab or json.", autocompletion=target_names)],
    out: Annotated[Path | None, typer.Option(metavar="PATH", help="The file (c, matlab: the folder) to write; a text goes to the terminal without it.")] = None,
    name: Annotated[str | None, typer.Option(metavar="NAME", help="What functions and files are called.")] = None,
    set_: Annotated[list[str] | None, typer.Option("--set", metavar="NAME=VALUE", help="A setting of the compensator: scale=0.9, feedback=1, dead_band=0.1 ...; of mjcf: lugre=1, firm=1, armature=1; of usd: metres=0.01, kilograms=1.")] = None,
    compensation: Annotated[Path | None, typer.Option(metavar="FILE", help="Settings as `compensate --out` left them, compensation.json.")] = None,
    points: Annotated[int | None, typer.Option(metavar="N", help="Points of a table, 20 by default.")] = None,
    speed: Annotated[float | None, typer.Option(metavar="V", help="Last speed of a table, in the rig's unit.")] = None,
    into: Annotated[Path | None, typer.Option(metavar="FILE", help="Your MJCF or URDF file or USD stage; it stays as it is.")] = None,
    joint: Annotated[str | None, typer.Option(metavar="NAME", help="The joint of it to patch; of usd without --into, the path of its prim.")] = None,
    json: Annotated[bool, typer.Option("--json", help="Print the files written and the notes as JSON.")] = False,
) -> None:  # fmt: skip
    """Write an identified model for a controller, a drive or a simulator."""
    from ..export import TARGETS
    from ..export import export as exported
    from ..report.folder import check_file, check_folder, with_suffix

    target = TARGETS.get(to)
    if target is None:
        raise InputError(f"--to {to}: there are {', '.join(TARGETS)}")
    if out is None and json:
        raise InputError("--json: a text is printed as it is: give --out with it")
    if out is None and (target.folder or not target.text):
        raise InputError(f"--to {to}: give --out, a {'folder' if target.folder else 'file'}")
    if out is not None:
        out = out if target.folder else with_suffix(out, target.suffix)
        check_folder(out) if target.folder else check_file(out, target.suffix)
        for source in (card, into, compensation):
            if source is not None and out.exists() and source.exists() and out.samefile(source):
                raise InputError(f"--out {out}: is what is read: write to another place")
    settings = numbers("--set", set_)
    files = exported(
        card,
        to,
        name=name,
        settings=settings or None,
        compensation=compensation,
        points=points,
        speed=speed,
        into=into,
        joint=joint,
    )
    if out is None:
        (data,) = files.files.values()
        typer.echo(data, nl=False)
    show_files([] if out is None else files.write(out), files.notes, json=json)
