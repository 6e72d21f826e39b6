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


def identify_command(arguments: Sequence[str], rig: str) -> str:
    """The command that identifies what `check` was asked about; empty without a rig.

    Args:
        arguments: Of `check`, as typed, its name first.
        rig: The rig.
    """
    if not rig:
        return ""
    words, skipped = [], False
    for word in arguments[1:]:
        if not skipped and not word.startswith(tuple(f"{o}=" for o in _WITH_VALUE)):
            words += [word] if word not in (*_WITH_VALUE, *_ALONE) else []
        skipped = not skipped and word in _WITH_VALUE
    return shlex.join(["stribeck", "identify", *words, "--rig", rig, "--out", "result"])


def no_rig(logs: Sequence[Path], reading: Reading, *, json: bool) -> NoReturn:
    """List the rigs with the one that the first log suggests, say the whole command, and exit."""
    from ..data import check
    from ..report.registries import show_rigs

    recording = reading.recordings(logs[:1], None)[0]
    quality = check(recording)
    if not json:
        show_rigs(None, likely=quality.rig)
    if not quality.rig:
        fail(f"--rig: {recording.label} suggests none: {quality.rig_reason}", 2)
    words = ["stribeck", *sys.argv[1:], "--rig", quality.rig]
    fail(
        f"--rig: {recording.label} suggests {quality.rig} ({quality.rig_reason}): {shlex.join(words)}",
        2,
    )
