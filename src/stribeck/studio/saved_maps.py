"""Maps of channels that are kept for the next log with the same heads.

They are in the home as they are beside logs: one file, which the commands read, too.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ..data.readers.log_contents import contents
from ..data.readers.log_map import WORDS, LogMap, save_map, saved_maps
from ..errors import InputError
from .choices import Choices
from .session_request import Request

#: The choices that a map is made of.
MAPPED = ("columns", "drive", *WORDS)


def keep(folder: Path, heads: Sequence[str], request: Request) -> None:
    """Keep how a session reads its logs, for logs with the same heads.

    Raises:
        InputError: nothing is chosen that could be kept, or the disk refuses.
    """
    if not is_mapped(request.choices):
        raise InputError(
            "nothing is chosen of the columns yet: what is known by its name is not kept"
        )
    used = LogMap.of(request.map).with_words(request.words)
    try:
        save_map(folder, heads, used)
    except OSError as error:
        raise InputError(f"the map cannot be kept: {error.strerror or error}") from error


def is_kept(folder: Path, heads: Sequence[str], choices: Choices) -> bool:
    """Whether a session reads logs with these heads as a kept map says."""
    return is_mapped(choices) and _of_heads(folder, heads) == _mapped(choices)


def recalled(folder: Path, log: Path, choices: Choices) -> dict[str, Any]:
    """What a kept map chooses for the first log of a session; empty where there is none."""
    if choices.logs or is_mapped(choices) or not saved_maps(folder):
        return {}
    try:
        heads = [c.name for c in contents(log).channels]
    except InputError:  # it says so itself, on its own page
        return {}
    return dict(_of_heads(folder, heads))


def is_mapped(choices: Choices) -> bool:
    """Whether anything of how logs are read was chosen."""
    return bool(_mapped(choices))


def _of_heads(folder: Path, heads: Sequence[str]) -> Mapping[str, Any]:
    for known, used in saved_maps(folder):
        if list(heads) == known:
            return _mapped(Choices().changed(used.table()))
    return {}


def _mapped(choices: Choices) -> Mapping[str, Any]:
    return {n: v for n in MAPPED if (v := choices.model_dump(mode="json")[n])}
