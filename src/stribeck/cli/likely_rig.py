"""A command without a rig: the rigs, the one that the log suggests, and the command with it."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import NoReturn

from .exits import fail
from .reading import Reading

#: Options of `check` that `identify` need not have from it: with a value, and without.
_WITH_VALUE, _ALONE = ("--out", "--rig"), ("--json", "--quiet")
#: Options that say which column is which, which a rig says too.
_OF_COLUMNS = ("--column", "--columns")


def identify_command(arguments: Sequence[str], rig: str) -> str:
    """The command that identifies what `check` was asked about; empty without a rig.

    Args:
        arguments: Of `check`, as typed, its name first.
        rig: The rig.
    """
    if not rig:
        return ""
    words = [w for w in _without(arguments[1:], _WITH_VALUE) if w not in _ALONE]
    return shlex.join(["stribeck", "identify", *words, "--rig", rig, "--out", "result"])


def _without(words: Sequence[str], options: Sequence[str]) -> list[str]:
    """The words of a command without some options and their values."""
    kept, skipped = [], False
    for word in words:
        if not skipped and not word.startswith(tuple(f"{o}=" for o in options)):
            kept += [word] if word not in options else []
        skipped = not skipped and word in options
    return kept


def no_rig(logs: Sequence[Path], reading: Reading, *, json: bool) -> NoReturn:
    """List the rigs with the one that the first log suggests, say the whole command, and exit."""
    from ..data import check
    from ..data.readers.log_contents import contents
    from ..data.readers.opening import each_run
    from ..report.registries import show_rigs
    from ..rig.lookup import rig_of_heads

    recording = reading.recordings(logs[:1], None)[0]
    quality = check(recording)
    rig, reason, words = quality.rig, quality.rig_reason, sys.argv[1:]
    if not rig:
        (run, *_) = each_run(logs[0], reading.map())
        heads = contents(run, columns=reading.map(), **reading.words).channels
        if like := rig_of_heads([c.name for c in heads]):
            rig, reason = like, "whose logs have these heads"
            words = _without(words, _OF_COLUMNS)
    if not json:
        show_rigs(None, likely=rig)
    if not rig:
        fail(f"--rig: {recording.label} suggests none: {reason}", 2)
    command = shlex.join(["stribeck", *words, "--rig", rig])
    fail(f"--rig: {recording.label} suggests {rig} ({reason}): {command}", 2)
