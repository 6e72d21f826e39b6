"""How the command line ends when it cannot go on: one line on stderr, and an exit status."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Sequence
from json import dumps
from typing import Any, NoReturn

import typer

#: A message is a line, not a page.
LONGEST = 600


def fail(message: str, status: int) -> NoReturn:
    """Say one line, whatever is in the message, and exit with a status."""
    line = " ".join("".join(c if c.isprintable() else " " for c in message).split())
    if len(line) > LONGEST:  # what is wrong comes last
        line = f"{line[: LONGEST // 2]} ... {line[-LONGEST // 2 :]}"
    typer.echo(f"stribeck: {line}", err=True)
    sys.exit(status)


def show_files(files: Iterable[object], notes: Sequence[str] = (), *, json: bool) -> None:
    """Print the files that were written, a line each, and notes on stderr; or both as JSON."""
    if json:
        document = {"files": [str(file) for file in files], "notes": list(notes)}
        typer.echo(dumps(document, indent=2, ensure_ascii=False))
        return
    for file in files:
        typer.echo(file)
    for note in notes:
        typer.echo(f"note: {note}", err=True)


def _path(error: typer.TyperException) -> str:
    """The command that was misused, as it is typed."""
    context = getattr(error, "ctx", None)
    return "stribeck" if context is None else str(context.command_path)


def misused(error: typer.TyperException) -> str:
    """What the parser found, with the value that it could not take."""
    errors: Any = getattr(error.__cause__, "errors", list)()
    options = getattr(getattr(error, "param", None), "opts", ())
    if not (errors and options):
        return f"{error.format_message().rstrip('.')} (see {_path(error)} --help)"
    kind = {"int_parsing": "a whole number", "float_parsing": "a number"}.get(errors[0]["type"])
    name, value = options[0], errors[0]["input"]
    return f"{name}: {value!r} is not {kind}" if kind else f"{name} {value!r}: {errors[0]['msg']}"
