"""The command that opens the studio."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path
from typing import Annotated

import typer

from ..errors import InputError

#: The packages of the extra.
_NEEDED = ("starlette", "uvicorn")
#: Ports there are.
_PORTS = 65536


def studio(
    logs: Annotated[list[Path] | None, typer.Argument(metavar="[LOG]...", help="Logs to begin with; they are read where they are.")] = None,
    port: Annotated[int, typer.Option(metavar="P", help="Where to listen; a free port by default.", show_default=False)] = 0,
    home: Annotated[Path | None, typer.Option(metavar="DIR", help="Where sessions are kept; .stribeck-studio in your home by default.")] = None,
    host: Annotated[str, typer.Option(metavar="ADDRESS", help="The address to listen on; others than this machine's own can be reached from elsewhere.")] = "127.0.0.1",
    browser: Annotated[bool, typer.Option("--browser/--no-browser", help="Whether to open the page.")] = True,
) -> None:  # fmt: skip
    """Open the studio: a local page from a log to a report and to code for a controller."""
    if missing := [name for name in _NEEDED if find_spec(name) is None]:
        raise InputError(f"the studio needs {missing[0]}: pip install 'stribeck[studio]'")
    if not 0 <= port < _PORTS:
        raise InputError(f"--port {port}: give 0 to {_PORTS - 1}")
    from ..studio.server import is_loopback, serve

    if not is_loopback(host):
        typer.echo(
            f"warning: --host {host}: the studio can be reached from other machines, unencrypted; "
            "who has its address, or listens, has its logs",
            err=True,
        )
    folder = Path.home() / ".stribeck-studio" if home is None else home
    serve(logs or [], home=folder, port=port, host=host, browser=browser, tell=typer.echo)
