"""What commands are given: logs, rigs, cards and constants, as options and as what they stand for."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..errors import InputError
from .arguments import numbers

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ..data import Recording
    from ..identify.card import Card
    from ..identify.parameters import Parameters
    from ..rig import Rig

CardFile = Annotated[Path, typer.Argument(metavar="CARD", help="A card that `identify` wrote.")]
Logs = Annotated[
    list[Path],
    typer.Argument(metavar="LOG...", help="Recordings: CSV, TSV, Parquet, MATLAB, JSON."),
]
Columns = Annotated[
    Path | None,
    typer.Option(metavar="MAP.toml", help="Which column is what, where the heads do not say."),
]
RigName = Annotated[
    str, typer.Option("--rig", metavar="RIG", help="A rig's name (see `rigs`) or a TOML file.")
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
    typer.Option(metavar="A:B", help="Positions (or 10s:40s) to train on."),
]
Seed = Annotated[int | None, typer.Option(metavar="N", help="Seed of the searches.")]


def rig_named(name: str) -> Rig:
    """A shipped rig, or that of a file."""
    from ..rig import RIGS
    from ..rig.custom import rig_file

    if name.lower().endswith(".toml"):
        return rig_file(Path(name))
    if name not in RIGS:
        raise InputError(f"no rig {name!r}: there are {', '.join(RIGS)}, or give a .toml file")
    return RIGS[name]


def law_named(rig: Rig, law: str | None, directional: bool) -> str:
    """The law asked for, by default the rig's first; with parameters for each direction."""
    name = rig.laws[0] if law is None else law
    return f"{name}-directional" if directional and not name.endswith("-directional") else name


def with_constants(rig: Rig, assignments: Sequence[str] | None) -> tuple[Rig, dict[str, float]]:
    """The rig with the constants among `--set`, and the others: parameters to hold."""
    names = [c.name for c in rig.constants]
    values = numbers("--set", assignments)
    return (
        rig.set(**{n: v for n, v in values.items() if n in names}),
        {n: v for n, v in values.items() if n not in names},
    )


def check_held(rig: Rig, law: str, held: Sequence[str]) -> None:
    """Refuse parameters to hold that neither the law nor the rig has."""
    if not held:
        return
    from ..identify.lookup import rig_and_law

    _, parameters = rig_and_law(rig, law)
    names = [q.name for q in rig.parameters(parameters)]
    allowed = {*names, *map(rig.label, names)}
    if strange := [n for n in held if n not in allowed]:
        raise InputError(
            f"--set {strange[0]}: rig {rig.name} has no such constant or parameter: it has "
            f"{', '.join([*(c.name for c in rig.constants), *names])}"
        )


def card_model(path: Path) -> tuple[Card, Parameters, Any]:
    """A card, and the rig, law and values that it stands for."""
    from ..identify.card import read_card

    written = read_card(path)
    try:
        return (written, *written.model())
    except InputError as error:
        raise InputError(f"{path}: {error}") from error


def read_logs(logs: Sequence[Path], rig: Rig | None, columns: Path | None) -> list[Recording]:
    """Recordings, their columns as a map or the rig says; each log only once."""
    from ..data import read

    mapping: Any = columns or (dict(rig.columns) if rig is not None and rig.columns else None)
    recordings = [read(log, columns=mapping, lenient=columns is None) for log in logs]
    labels: dict[str, str] = {}
    for recording in recordings:
        if recording.source.sha256 in labels:
            first = labels[recording.source.sha256]
            raise InputError(f"{recording.label}: the same log as {first}: give it once")
        labels[recording.source.sha256] = recording.label
    return recordings


def file_bytes(file: Path) -> bytes:
    """A file that is to be patched."""
    from ..text_file import page_bytes

    try:
        return page_bytes(file)
    except InputError as error:
        raise InputError(f"{file}: {error}") from error
