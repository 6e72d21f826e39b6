"""What commands are given: options, and the values, logs, rigs and cards that they stand for."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, cast

import typer

from ..errors import InputError
from ..units import interval, number
from .completions import rig_names

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ..data.alignment import Delay
    from ..identify.card import Card
    from ..identify.parameters import Parameters
    from ..rig import Rig

CardFile = Annotated[
    Path, typer.Argument(metavar="CARD", help="A card that `identify` wrote, or its folder.")
]
Logs = Annotated[
    list[Path],
    typer.Argument(
        metavar="LOG",
        help="Recordings, or a folder of them; axis.csv@10s:40s is a part of one, pos.csv+force.csv "
        "one of two files.",
    ),
]
RigName = Annotated[
    str | None,
    typer.Option(
        "--rig",
        metavar="RIG",
        help="A rig's name (see `rigs`) or a TOML file; without it the log's likely one is told.",
        autocompletion=rig_names,
    ),
]
Set = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="NAME=VALUE", help="A rig's constant, or a parameter to hold."),
]
Json = Annotated[bool, typer.Option("--json", help="Print the result as JSON.")]
Bounds = Annotated[
    list[str] | None,
    typer.Option(metavar="NAME=LO:HI", help="Search range of a parameter."),
]
Train = Annotated[
    list[str] | None,
    typer.Option(metavar="A:B", help="Positions (or 10s:40s) to train on; all by default."),
]
Exact = Annotated[
    bool,
    typer.Option("--exact", help="The rig's constants are this axis's own, without a tolerance."),
]
LossOption = Annotated[
    str,
    typer.Option("--loss", metavar="squares|absolute", help="What of the errors counts."),
]
DelayText = Annotated[
    str,
    typer.Option(
        "--delay",
        metavar="auto|off|MS[±TOL]",
        help="By how many ms the force (or command) is after the motion; auto looks for it.",
    ),
]
Seed = Annotated[int | None, typer.Option(metavar="N", help="Seed of the searches; 0 by default.")]

#: No setting of a method is a greater whole number.
LARGEST_SETTING = 10**15
#: How the values of options are written that name what they are about.
FORMS = {
    "--set": "NAME=VALUE",
    "--setting": "NAME=VALUE",
    "--bounds": "NAME=LO:HI",
    "--tie": "NAME=OTHER",
}


def pairs(option: str, values: Sequence[str] | None) -> list[tuple[str, str]]:
    """The names and values of `NAME=VALUE`, each name once."""
    result = []
    for text in values or []:
        name, equals, value = text.partition("=")
        if not (name.strip() and equals and value.strip()):
            raise InputError(f"{option} {text!r}: write {FORMS[option]}")
        result.append((name.strip(), value.strip()))
    names = [n for n, _ in result]
    if twice := {n for n in names if names.count(n) > 1}:
        raise InputError(f"{option}: {', '.join(sorted(twice))} is given twice: give it once")
    return result


def numbers(option: str, values: Sequence[str] | None) -> dict[str, float]:
    """The same where all values are numbers."""
    return {name: number(text, f"{option} {name}") for name, text in pairs(option, values)}


def intervals(option: str, values: Sequence[str] | None) -> dict[str, tuple[float, float]]:
    """The same where they are `LO:HI`."""
    return {name: interval(text, f"{option} {name}") for name, text in pairs(option, values)}


def each_once(option: str, values: Sequence[str] | None) -> None:
    """Refuse a value that is given twice."""
    bare = ["".join(text.split()) for text in values or []]
    if twice := {text for text in bare if bare.count(text) > 1}:
        raise InputError(f"{option} {min(twice)} is given twice: give it once")


def above_zero(option: str, value: float) -> None:
    """Refuse a number that is not above 0."""
    if not 0 < value < math.inf:
        raise InputError(f"{option}: give a number above 0, got {value:g}")


def delay_value(text: str) -> Delay:
    """A delay as it is typed: auto, off or milliseconds, exactly or with a tolerance."""
    from ..constant import toleranced

    if text in ("auto", "off"):
        return cast("Delay", text)
    value, tolerance, _ = toleranced(text, "--delay", "auto, off, a number of ms, nor MS±TOLERANCE")
    return 1e-3 * value, 1e-3 * tolerance


def setting_value(text: str) -> Any:
    """A setting as its method takes it: a number, None, pairs such as [[8, 0.01]], or a word."""
    from json import loads

    for kind in (int, float, loads):
        try:
            value = kind(text)
        except (ValueError, RecursionError):
            continue
        if isinstance(value, int) and abs(value) > LARGEST_SETTING:
            raise InputError(f"--setting {text[:20]}...: a number of {len(text)} digits")
        return value
    return None if text == "None" else text


def law_name(rig: Rig, law: str | None, directional: bool) -> str:
    """Name of the law asked for, by default the rig's first; with parameters for each direction."""
    name = rig.laws[0] if law is None else law
    return f"{name}-directional" if directional and not name.endswith("-directional") else name


def with_constants(
    rig: Rig, assignments: Sequence[str] | None, *, exact: bool = False
) -> tuple[Rig, dict[str, float]]:
    """The rig with the constants among `--set`, and the others: parameters to hold.

    With `exact` the constants that are not set are exact, too.
    """
    from ..constant import toleranced
    from ..drive import refuse_without_drive

    names = [c.name for c in rig.constants]
    texts = pairs("--set", assignments)
    for name in (n for n, _ in texts if n not in names):
        refuse_without_drive(name, rig.name)
    constants = {n: toleranced(text, f"--set {n}") for n, text in texts if n in names}
    alone = "a number: a parameter is held at one, and only constants have tolerances"
    held = {n: number(text, f"--set {n}", kind=alone) for n, text in texts if n not in names}
    return (rig.exact() if exact else rig).set(**constants), held


def check_held(rig: Rig, law: str, held: Sequence[str]) -> None:
    """Refuse parameters to hold that neither the law nor the rig has."""
    if not held:
        return
    from ..friction import law_named

    names = [q.name for q in rig.parameters(law_named(law))]
    allowed = {*names, *map(rig.label, names)}
    if strange := [n for n in held if n not in allowed]:
        known = [*(c.name for c in rig.constants), *names]
        alike = [n for n in known if n.lower() == strange[0].lower()]
        meant = f" (is {alike[0]} meant?)" if alike else ""
        raise InputError(
            f"--set {strange[0]}: rig {rig.name} has no such constant or parameter{meant}: it has "
            f"{', '.join(known)}"
        )


def card_model(path: Path) -> tuple[Card, Parameters, Any]:
    """A card, and the rig, law and values that it stands for."""
    from ..identify.card import read_card

    written = read_card(path)
    try:
        return (written, *written.model())
    except InputError as error:
        raise InputError(f"{path}: {error}") from error


def check_there(logs: Sequence[Path]) -> None:
    """Refuse a log that is not there, before the code that reads and simulates is loaded."""
    for log in logs:
        try:
            log.stat()
        except FileNotFoundError as error:
            if "@" in log.name or "+" in str(log):  # a part or several: their reader knows
                continue
            raise InputError(f"{log.name}: no such file in {log.parent}") from error
        except OSError:  # whatever it is, its reader says it
            return
