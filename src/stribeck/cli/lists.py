"""Commands that list what there is."""

from __future__ import annotations

from typing import Annotated

import typer

from .completions import drive_names, law_names, method_names, reader_names, rig_names
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
) -> None:  # fmt: skip
    """List the rigs, or show one with its constants."""
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


def version(json: Json = False) -> None:
    """Print the version."""
    from .._version import __version__

    if json:
        from ..report.format import json_text

        typer.echo(json_text({"version": __version__}), nl=False)
    else:
        typer.echo(__version__)
