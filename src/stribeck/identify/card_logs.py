"""The logs of a card, looked for beside its file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from ..data.readers.file_bytes import sha256
from ..data.readers.log_path import LogPath
from ..errors import InputError

if TYPE_CHECKING:
    from .card import Card


def logs_beside(card: Card, path: Path) -> list[Path]:
    """The logs of a card, by name and hash: in its folder, the one above, or the current one.

    Raises:
        InputError: one of them is in none of these.
    """
    logs = []
    for d in card.data:
        places = [path.parent / d.file, path.parent.parent / d.file, Path(d.file)]
        matching = [p for p in places if d.file and _is(p, d.sha256)]
        if not matching:
            raise InputError(
                f"{path}: its log {d.file or 'from memory'} is not beside it: give the log after "
                "the card"
            )
        logs.append(matching[0])
    return logs


def _is(log: Path, digest: str) -> bool:
    files = LogPath.of(log).files
    return all(file.exists() for file in files) and sha256(*files) == digest
