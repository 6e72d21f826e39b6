"""The questions that a new axis of parts asks, and its file."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from pathlib import Path

import typer

from ..errors import InputError
from ..rig.axis_draft import axis_draft
from ..rig.parts import PARTS, part_named


def write_axis(
    path: Path,
    controller: str | None,
    motor: str | None,
    transmission: str | None,
    loads: Sequence[str] | None,
    sensors: Sequence[str] | None,
    *,
    rotary: bool | None,
) -> None:
    """Write the file of a new axis; what no option says is asked on a terminal.

    Raises:
        InputError: the file is there, a part is not, or nobody is there to be asked.
    """
    if path.suffix.lower() != ".toml":
        raise InputError(f"--new {path}: a rig is a .toml file")
    if path.exists():
        raise InputError(f"--new {path}: is there already: choose another name")
    if rotary is None:
        rotary = _asked("--rotary or --linear", "axis", ["linear", "rotary"]) == "rotary"
    chosen: dict[str, str] = {}
    for role, stated in (
        ("controller", controller), ("motor", motor), ("transmission", transmission),
    ):  # fmt: skip
        drive = part_named("controller", chosen["controller"]).drive if chosen else ""
        chosen[role] = stated or _asked(f"--{role}", role, _names(role, rotary, drive))
    loads = loads or [_asked("--load", "load", _names("load", rotary))]
    parts = [part_named(role, name) for role, name in chosen.items()]
    parts += [part_named("load", name) for name in loads]
    parts += [part_named("sensor", name) for name in sensors or ()]
    text = axis_draft(parts, rotary=rotary)
    aside = path.with_name(f".{path.name}.part")
    try:
        with aside.open("w", encoding="utf-8") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        aside.replace(path)
    except OSError as error:
        aside.unlink(missing_ok=True)
        raise InputError(f"--new {path}: {error.strerror or error}") from error
    typer.echo(f"{path}: state what you know; then stribeck rigs {path} shows the axis")


def _names(role: str, rotary: bool, drive: str = "") -> list[str]:
    """The parts of a role that a kind of axis may have, behind a controller with a drive."""
    kinds = (None, rotary)
    return [
        p.name
        for p in PARTS.values()
        if p.role == role and p.rotary in kinds and (role != "motor" or drive in ("", p.drive))
    ]


def _asked(option: str, what: str, names: Sequence[str]) -> str:
    """An answer from the terminal.

    Raises:
        InputError: there is none.
    """
    if not sys.stdin.isatty():
        raise InputError(f"a new axis needs {option}: there are {', '.join(names)}")
    while (answer := typer.prompt(f"{what} ({', '.join(names)})", default=names[0])) not in names:
        typer.echo(f"no {what} {answer!r}")
    return str(answer)
