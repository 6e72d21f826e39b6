"""The last line of defence: an error that nobody foresaw is one line, with its details in a file."""

from __future__ import annotations

import os
import platform
import sys
import traceback
from pathlib import Path
from typing import NoReturn

from .._version import __version__
from .exits import fail

#: The exit status of an error in the program itself, as sysexits.h has it.
CRASHED = 70


def crash(error: Exception) -> NoReturn:
    """Write down what is known of an error of ours, name the file in one line, and exit with 70.

    An error that settings of the environment explain is theirs, and its status is 2.
    """
    if fault := _environment_fault():
        fail(fault, 2)
    name = type(error).__name__
    try:
        place = f"the details, to be reported, are in {_details(error)}"
    except OSError:
        frame = traceback.extract_tb(error.__traceback__)[-1]
        place = f"it happened in {Path(frame.filename).name}, line {frame.lineno}"
    fail(f"this is an error in stribeck itself ({name}: {error!s:.200}): {place}", CRASHED)


def _environment_fault() -> str:
    """Which setting of numba's no compiled model can run with, or nothing."""
    if os.environ.get("NUMBA_DISABLE_JIT", "0") not in ("", "0"):
        return "NUMBA_DISABLE_JIT is set, but models run compiled: unset it"
    threads = os.environ.get("NUMBA_NUM_THREADS", "1")
    if not threads.isdecimal() or int(threads) < 1:
        return f"NUMBA_NUM_THREADS={threads}: set a number of threads above 0, or unset it"
    return ""


def _details(error: Exception) -> Path:
    """A new file with the command, the versions and the traceback."""
    import tempfile  # no other command pays for it

    lines = [
        f"stribeck {__version__}, Python {platform.python_version()}, {platform.platform()}",
        f"arguments: {sys.argv[1:]!r}",
        "",
        *traceback.format_exception(error),
    ]
    with tempfile.NamedTemporaryFile(
        "w", prefix="stribeck-error-", suffix=".txt", delete=False,
        encoding="utf-8", errors="backslashreplace",
    ) as file:  # fmt: skip
        file.write("\n".join(lines))
    return Path(file.name)
