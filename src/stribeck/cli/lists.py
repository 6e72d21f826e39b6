"""Commands that list what there is."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ..errors import InputError
from .completions import (
    drive_names,
    law_names,
    method_names,
    reader_names,
    recording_names,
    rig_names,
)  # fmt: skip
from .inputs import Json


def laws(
    name: Annotated[str | None, typer.Argument(metavar="NAME", help="The law to explain; all are listed by default.", autocompletion=law_names)] = None,
    json: Json = False,
) -> None:  # fmt: skip
    """List the friction laws, or explain one."""
    if json:
        from ..report.registry_documents import laws_text

        typer.echo(laws_text(name), nl=False)
        return
    from ..report.registries import show_laws

    show_laws(name)


def methods(
    name: Annotated[str | None, typer.Argument(metavar="NAME", help="The method to explain; all are listed by default.", autocompletion=method_names)] = None,
    json: Json = False,
) -> None:  # fmt: skip
    """List the search methods, or explain one."""
    if json:
        from ..report.registry_documents import methods_text

        typer.echo(methods_text(name), nl=False)
        return
    from ..report.registries import show_methods

    show_methods(name)


def rigs(
    name: Annotated[str | None, typer.Argument(metavar="NAME", help="The rig, or its TOML file, to show; all are listed by default.", autocompletion=rig_names)] = None,
    json: Json = False,
    parts: Annotated[bool, typer.Option("--parts", help="List the parts that an axis is composed of.")] = False,
    new: Annotated[Path | None, typer.Option("--new", metavar="FILE.toml", help="Write the file of a new axis of parts.")] = None,
    controller: Annotated[str | None, typer.Option(metavar="PART", help="Of a new axis; see --parts.")] = None,
    motor: Annotated[str | None, typer.Option(metavar="PART", help="Of a new axis.")] = None,
    transmission: Annotated[str | None, typer.Option(metavar="PART", help="Of a new axis.")] = None,
    load: Annotated[list[str] | None, typer.Option(metavar="PART", help="Of a new axis; may be given again.")] = None,
    sensor: Annotated[list[str] | None, typer.Option(metavar="PART", help="Of a new axis.")] = None,
    rotary: Annotated[bool | None, typer.Option("--rotary/--linear", help="Whether a new axis turns.")] = None,
) -> None:  # fmt: skip
    """List the rigs, show one with its constants, or write the file of a new axis of parts."""
    of_new = {"--controller": controller, "--motor": motor, "--transmission": transmission,
              "--load": load, "--sensor": sensor, "--rotary": rotary}  # fmt: skip
    if new is None and (stray := [n for n, value in of_new.items() if value is not None]):
        raise InputError(f"{stray[0]}: is of a new axis: give --new FILE.toml as well")
    if new is not None:
        if name is not None:
            raise InputError(
                f"--new writes an axis of parts: leave {name} out; a variant of a shipped rig is a "
                'file that begins with kind = "NAME"'
            )
        from .new_axis import write_axis

        write_axis(new, controller, motor, transmission, load, sensor, rotary=rotary)
        return
    if parts:
        if json or name is not None:
            raise InputError("--parts lists all parts, for people: leave the rest out")
        from ..report.registries import show_parts

        show_parts()
        return
    from ..rig.lookup import rig_named

    rig = rig_named(name) if name is not None else None
    if json:
        from ..report.registry_documents import rigs_text

        typer.echo(rigs_text(rig), nl=False)
        return
    from ..report.registries import show_rigs

    show_rigs(rig)


def drives(
    name: Annotated[str | None, typer.Argument(metavar="NAME", help="The convention to explain; all are listed by default.", autocompletion=drive_names)] = None,
    json: Json = False,
) -> None:  # fmt: skip
    """List what drives record of their torque, or explain one convention with its document."""
    from ..report.registries import drives_text, show_drives

    if json:
        typer.echo(drives_text(name))
    else:
        show_drives(name)


def readers(
    name: Annotated[str | None, typer.Argument(metavar="NAME", help="The format to explain; all are listed by default.", autocompletion=reader_names)] = None,
    json: Json = False,
) -> None:  # fmt: skip
    """List the formats of logs, or show one with what it needs."""
    from ..report.registries import readers_text, show_readers

    if json:
        typer.echo(readers_text(name))
    else:
        show_readers(name)


def data(
    name: Annotated[str | None, typer.Argument(metavar="NAME", help="The recording to show; all are listed by default.", autocompletion=recording_names)] = None,
    paths: Annotated[list[Path] | None, typer.Argument(metavar="FILE...", help="Files that may be those of a published recording: their hashes tell.")] = None,
    out: Annotated[Path | None, typer.Option(metavar="FILE.csv", help="Write the recording that the package brings.")] = None,
    json: Json = False,
) -> None:  # fmt: skip
    """List recordings to try: where real ones are published, and whether a file is one of them."""
    from ..report.published_report import data_text, show_data

    if json:
        typer.echo(data_text(name))
    else:
        show_data(name, paths or [], out)


def version(json: Json = False) -> None:
    """Print the version."""
    from .._version import __version__

    if json:
        from ..report.format import json_text

        typer.echo(json_text({"version": __version__}), nl=False)
    else:
        typer.echo(__version__)
