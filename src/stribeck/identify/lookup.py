"""Rigs, laws, recordings and ranges by the names that callers give, or their defaults."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from ..data.ranges import Range
from ..errors import InputError
from ..friction import Law, law_named
from ..rig import RIGS, Rig
from ..rig.custom import rig_file

if TYPE_CHECKING:
    from ..data.recording import Recording


def rig_and_law(rig: str | Rig, law: str | Law | None) -> tuple[Rig, Law]:
    """A rig and a law, looked up where they are names; a rig may be a .toml file, too.

    Raises:
        InputError: there is none of that name.
    """
    if isinstance(rig, str) and rig.endswith(".toml"):
        rig = rig_file(Path(rig))
    elif isinstance(rig, str):
        if rig not in RIGS:
            raise InputError(f"no rig {rig!r}: there are {', '.join(RIGS)}, or give a .toml file")
        rig = RIGS[rig]
    law = law or rig.laws[0]
    if isinstance(law, str):
        law = law_named(law)
    return rig, law


def recording_list(recordings: Recording | Sequence[Recording]) -> list[Recording]:
    """One or several recordings as a list."""
    logs = list(recordings) if isinstance(recordings, Sequence) else [recordings]
    if not logs:
        raise InputError("no recording was given")
    return logs


def range_list(ranges: Sequence[Range | str] | Range | str | None, rig: Rig) -> list[Range]:
    """Ranges as written or ready, as a list."""
    if ranges is None:
        return []
    if isinstance(ranges, Range | str):
        ranges = [ranges]
    shown = rig.shows.get("position", "m")
    if not all(isinstance(g, Range | str) for g in ranges):
        raise InputError(f"range {ranges!r}: write it as '112:295' ({shown}) or '10s:40s'")
    return [g if isinstance(g, Range) else Range.parse(g, shown) for g in ranges]


def ranges_or_all(
    ranges: Sequence[Range | str] | Range | str | None, rig: Rig
) -> list[Range | None]:
    """The same, with None, which is everything, where no range was given."""
    return [*range_list(ranges, rig)] or [None]
