"""The command line: parse, call, print. One function a command; this file starts and ends them."""

from __future__ import annotations

import atexit
import gc
import io
import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Annotated, Any, cast

import typer

from ..errors import InputError
from ..wording import on_command_line
from .arguments import checked, spread
from .campaigns import bench
from .crash import crash
from .exits import fail, misused
from .fits import identify, report, select
from .fleets import drift, fleet
from .interruption import interruption
from .lists import data, drives, laws, methods, readers, rigs, version
from .logs import check, contents, twin
from .models import compensate, export, plan, simulate, validate
from .notices import notices, quiet
from .studio_command import studio
from .warm import warm

#: The commands, in the order in which `--help` lists them.
COMMANDS = (
    twin, contents, check, identify, report, select, validate, plan, compensate, simulate, export, studio,
    fleet, drift, bench, laws, methods, rigs, drives, readers, data, warm, version,
)  # fmt: skip

#: Set by a shell that completes a line.
_COMPLETE = "_STRIBECK_COMPLETE"
#: Objects made between two looks of the garbage collector: the 200,000 that a start makes stay,
#: and looking through them every 700, as Python does, takes an eighth of the start.
GC_THRESHOLD = 300_000


def main() -> None:
    """Run the command line; whatever the user got wrong is one line and exit status 2."""
    gc.set_threshold(GC_THRESHOLD)
    atexit.register(gc.freeze)  # to look through it all once more at the end takes half a second
    os.environ["MPLBACKEND"] = "agg"  # figures are files: whether there are windows is no matter
    _open_streams()
    try:
        with interruption.handled(), quiet(), on_command_line():
            _run()
    except KeyboardInterrupt:  # another one, while the first was told
        sys.exit(interruption.status)


def _run() -> None:
    try:
        if _COMPLETE in os.environ:  # a shell asks what may come next
            command_line()(prog_name="stribeck")
        arguments = spread(checked(sys.argv[1:])) or ["--help"]
        called = [c for c in COMMANDS if c.__name__ == arguments[0]]
        command = command_line(called or COMMANDS)
        with notices(), command.make_context("stribeck", arguments) as context:
            context.command.invoke(context)
    except typer.Exit as done:
        sys.exit(done.exit_code)
    except InputError as error:
        fail(str(error), 2)
    except typer.TyperException as error:
        fail(misused(error), 2)
    except KeyboardInterrupt:
        line = "interrupted before there was a result: nothing was written"
        fail(line, interruption.status)
    except BrokenPipeError:  # the reader of our output has gone
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # nor complain at the end
        sys.exit(141)
    except OSError as error:
        fail(f"{error.filename or 'output'}: {error.strerror or error}", 2)
    except MemoryError:
        fail("out of memory: ask for less at once, or take a shorter log", 2)
    except Exception as error:  # noqa: BLE001 - whatever it is, it is ours
        crash(error)


def command_line(commands: Sequence[Callable[..., None]] = COMMANDS) -> typer.core.TyperGroup:
    """The command line with some of its commands: to build all takes longer than to run some.

    Only all of them are completed by a shell, and only then can that be installed.
    """
    app = typer.Typer(
        name="stribeck",
        help="From a motion log to a friction model you can trust.",
        add_completion=commands is COMMANDS,
        pretty_exceptions_enable=False,
        rich_markup_mode=None,
        context_settings={"help_option_names": ["-h", "--help"]},
    )
    app.callback()(_options)
    for command in commands:
        app.command(short_help=(command.__doc__ or "").partition("\n")[0])(command)
    group = cast("typer.core.TyperGroup", typer.main.get_command(app))
    parameters: list[Any] = [p for c in group.commands.values() for p in c.params]
    for parameter in parameters:
        if parameter.param_type_name == "argument":
            # The name of an argument says what it is: LOG, and not LOG <list[Path]>.
            parameter.display_type_rich = _nothing
    return group


def _nothing(ctx: object) -> None:
    del ctx


def _open_streams() -> None:
    """Somewhere to print to, whatever the one who started us closed or can show."""
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:
            setattr(sys, name, Path(os.devnull).open("w", encoding="utf-8"))  # noqa: SIM115
    if isinstance(sys.stdout, io.TextIOWrapper):  # names in a log may not fit its alphabet
        sys.stdout.reconfigure(errors="backslashreplace")


def _print_version(asked: bool) -> None:
    if asked:
        version()
        raise typer.Exit


def _options(
    version: Annotated[bool, typer.Option("--version", help="Print the version.", is_eager=True, callback=_print_version)] = False,
) -> None:  # fmt: skip
    """From a motion log to a friction model you can trust."""
    del version
