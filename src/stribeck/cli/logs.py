"""Commands about logs: make one, look at one."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, cast

import typer

from ..errors import InputError
from .completions import rig_names
from .exits import show_files
from .inputs import Json, above_zero
from .likely_rig import identify_command
from .notices import warn_of_doubts
from .reading import Reading, reads_logs

if TYPE_CHECKING:
    from ..data import Quality, Recording
    from ..rig.twin import Held, Loop, Mode

#: Standard deviation of an echo that can still be called one, mm: a quarter of the stroke.
NOISIEST = 100.0


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
    loop: Annotated[
        str,
        typer.Option(
            metavar="sensors|ideal",
            help="What the controller goes by: what it reads, as in figure 3, or the position itself.",
        ),
    ] = "sensors",
    mode: Annotated[
        str,
        typer.Option(
            metavar="control|test|home", help="Ramps; or the whole range and then home; or home."
        ),
    ] = "control",
    drive: Annotated[
        str,
        typer.Option(metavar="current|voltage", help="What the drive holds from sample to sample."),
    ] = "current",
    supply: Annotated[float, typer.Option(metavar="V", help="Voltage of the supply.")] = 24.0,
    json: Annotated[bool, typer.Option("--json", help="Print the files written as JSON.")] = False,
) -> None:
    """Record the paper's test bed, simulated with its sensors; the truth is written beside the log."""
    from ..report.motion_file import write_twin
    from ..rig.twin import TestBed

    options = {"--speed": speed, "--rate": rate, "--echo-rate": echo_rate, "--supply": supply}
    for option, value in options.items():
        above_zero(option, value)
    if not 0 <= noise <= NOISIEST:
        raise InputError(f"--noise: give 0 to {NOISIEST:g} mm, got {noise:g}")
    bed = TestBed(
        speed=speed * 1e-3, echo_noise=noise * 1e-3, rate=rate, echo_rate=echo_rate,
        loop=cast("Loop", loop), mode=cast("Mode", mode), held=cast("Held", drive), supply=supply,
    )  # fmt: skip
    show_files(write_twin(bed, direction, seed, out), json=json)


@reads_logs
def check(
    log: Annotated[Path, typer.Argument(metavar="LOG", help="A recording.")],
    rig: Annotated[
        str | None,
        typer.Option(metavar="RIG", help="Read the log as this rig's.", autocompletion=rig_names),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Write the page check.html and check.json there."),
    ] = None,
    quiet: Annotated[
        bool, typer.Option("--quiet", help="Print no result: what goes wrong alone.")
    ] = False,
    json: Json = False,
    reading: Reading = Reading(),  # noqa: B008 - options of its own
) -> None:
    """Say what is in a log, and what it is good enough for."""
    from ..data import check as quality_of
    from ..report.folder import check_folder
    from ..report.quality_report import quality_text, show_quality
    from ..rig.lookup import rig_named

    if quiet and out is None and not json:
        raise InputError("--quiet: then nothing is left of the result: give --out DIR, or --json")
    if out is not None:
        check_folder(out)
    axis = rig_named(rig) if rig is not None else None
    recording = reading.recording(log, axis)
    quality = quality_of(recording)
    if axis is not None:
        try:
            warn_of_doubts(axis, [recording])
        except InputError as error:  # a log is looked at, whatever the rig makes of it
            typer.echo(f"warning: {error}", err=True)
    if json:
        typer.echo(quality_text(quality), nl=False)
    elif not quiet:
        show_quality(quality)
    if out is not None:
        _write_check(log, rig, recording, quality, reading, out)
        if not (json or quiet):
            typer.echo(f"\npage in {out / 'check.html'}")


def _write_check(
    log: Path, rig: str | None, recording: Recording, quality: Quality, reading: Reading, out: Path
) -> None:
    from ..data.readers.log_contents import contents as contents_of
    from ..report.folder import held
    from ..report.page.log_page import write_check
    from ..rig.lookup import rig_named

    usual = dict(rig_named(rig).columns) if rig is not None else {}
    channels = contents_of(log, columns=reading.map() or usual or None, **reading.words)
    command = identify_command(sys.argv[1:], rig or quality.rig)
    with held(out):
        write_check(recording, quality, channels, command, out)


@reads_logs
def contents(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A log, or a folder that is one.")],
    json: Json = False,
    reading: Reading = Reading(),  # noqa: B008 - options of its own
) -> None:
    """Say which channels a log has, and what would be taken for what."""
    from ..data.readers.log_contents import contents as contents_of
    from ..report.contents_report import contents_text, show_contents

    result = contents_of(file, columns=reading.map(), **reading.words)
    if json:
        typer.echo(contents_text(result), nl=False)
    else:
        show_contents(result)
