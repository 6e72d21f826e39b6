"""Commands about logs: make one, look at one."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, cast

import typer

from ..errors import InputError
from .completions import rig_names
from .exits import show_files
from .inputs import Json, above_zero
from .reading import Reading, reads_logs

if TYPE_CHECKING:
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
    json: Json = False,
    reading: Reading = Reading(),  # noqa: B008 - options of its own
) -> None:
    """Say what is in a log, and what it is good enough for."""
    from ..data import check as quality_of
    from ..report.quality_report import quality_text, show_quality
    from ..rig.lookup import rig_named

    recording = reading.recording(log, rig_named(rig) if rig is not None else None)
    quality = quality_of(recording)
    if json:
        typer.echo(quality_text(quality), nl=False)
    else:
        show_quality(quality)


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
