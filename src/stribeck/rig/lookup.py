"""Rigs and laws by the names that callers give, by default, or by the heads of logs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from ..constant import Stated
from ..data.readers.heads import take_apart
from ..errors import InputError
from ..friction import Law, law_named
from . import RIGS
from .rig import Rig


def rig_named(name: str) -> Rig:
    """A shipped rig, or that of a .toml file.

    Raises:
        InputError: there is none of that name, or the file is no rig.
    """
    if name.lower().endswith(".toml"):
        from .custom import rig_file  # noqa: PLC0415 - its checker takes time to load

        return rig_file(Path(name))
    if name not in RIGS:
        raise InputError(f"no rig {name!r}: there are {', '.join(RIGS)}, or give a .toml file")
    return RIGS[name]


def rig_and_law(
    rig: str | Rig,
    law: str | Law | None,
    constants: Mapping[str, Stated] | None = None,
    *,
    exact: bool = False,
) -> tuple[Rig, Law]:
    """A rig and a law, looked up where they are names; by default the rig's first law.

    Args:
        rig: A rig, its name, or a .toml file.
        law: A law or its name.
        constants: Constants of the rig that are the user's, as `Rig.set` takes them.
        exact: Whether the others are exact, too.

    Raises:
        InputError: there is none of that name.
    """
    rig = rig_named(rig) if isinstance(rig, str) else rig
    rig = (rig.exact() if exact else rig).set(**(constants or {}))
    law = law or rig.laws[0]
    return rig, law_named(law) if isinstance(law, str) else law


def rig_of_heads(names: Sequence[str]) -> str | None:
    """The rig whose logs have columns of such names, None if none has."""
    there = {*names, *(take_apart(name).stem for name in names)}
    for rig in RIGS.values():
        heads = [c if isinstance(c, str) else c["column"] for c in (rig.columns or {}).values()]
        if heads and all(take_apart(str(head)).stem in there for head in heads):
            return rig.name
    return None
