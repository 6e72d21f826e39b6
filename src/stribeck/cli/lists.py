"""Commands that list what there is."""

from __future__ import annotations

from typing import Annotated

import typer


def laws(name: Annotated[str | None, typer.Argument(metavar="NAME")] = None) -> None:
    """List the friction laws, or explain one."""
    from ..report.registries import show_laws

    show_laws(name)


def methods(name: Annotated[str | None, typer.Argument(metavar="NAME")] = None) -> None:
    """List the search methods, or explain one."""
    from ..report.registries import show_methods

    show_methods(name)


def rigs(name: Annotated[str | None, typer.Argument(metavar="NAME")] = None) -> None:
    """List the rigs, or show one with its constants."""
    from ..report.registries import show_rigs
    from ..rig.lookup import rig_named

    show_rigs(rig_named(name) if name is not None else None)


def drives(
    name: Annotated[str | None, typer.Argument(metavar="NAME")] = None,
    json: Annotated[bool, typer.Option("--json", help="Print the result as JSON.")] = False,
) -> None:
    """List what drives record of their torque, or explain one convention with its document."""
    from ..report.registries import drives_text, show_drives

    if json:
        typer.echo(drives_text(name))
    else:
        show_drives(name)


def version() -> None:
    """Print the version."""
    from .._version import __version__

    typer.echo(__version__)
