"""A command without a rig: the rigs, the one that the log suggests, and the command with it."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import NoReturn

from .exits import fail
from .reading import Reading


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
