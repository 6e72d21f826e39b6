"""Lines on stderr: that the package compiles, how long that took, what a log is not good for."""

from __future__ import annotations

import logging
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import typer

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ..data.recording import Recording
    from ..rig import Rig


def warn_of_doubts(rig: Rig, recordings: Sequence[Recording]) -> None:
    """Print what a rig does not hold for in logs, and what it takes in place of what they lack."""
    for doubt in rig.doubts(recordings):
        typer.echo(f"warning: {doubt.sentence}", err=True)


@contextmanager
def notices() -> Iterator[None]:
    """Print what is logged meanwhile, and at the end what was compiled."""
    logger, handler = logging.getLogger("stribeck"), logging.StreamHandler(sys.stderr)
    drawing = logging.getLogger("matplotlib")
    handler.setFormatter(logging.Formatter("stribeck: %(message)s"))
    level = logger.level
    logger.addHandler(handler)
    logger.setLevel(logging.INFO)
    drawing.addFilter(_is_error)
    count, seconds = _compiled()
    try:
        yield
    finally:
        total, until = _compiled()
        if total > count:
            logger.info("compiled %d functions in %.1f s", total - count, until - seconds)
        logger.removeHandler(handler)
        logger.setLevel(level)
        drawing.removeFilter(_is_error)


@contextmanager
def quiet() -> Iterator[None]:
    """Warnings of libraries are not printed meanwhile, unless Python was asked to show them.

    What makes them errors, as the tests do, goes on doing so.
    """
    before = warnings.showwarning
    if not sys.warnoptions:
        warnings.showwarning = _unseen
    try:
        yield
    finally:
        warnings.showwarning = before


def _unseen(*_: object, **__: object) -> None:
    """What a library remarks on its way says nothing to who waits for a result."""


def _is_error(record: logging.LogRecord) -> bool:
    """Where there is no home matplotlib takes a temporary folder, and warns of it in two lines."""
    return record.levelno >= logging.ERROR


def _compiled() -> tuple[int, float]:
    """How many functions this process has compiled so far, and the seconds that it took."""
    if "stribeck.compile_cache" not in sys.modules:  # numba is not imported to say none
        return 0, 0.0
    from ..compile_cache import tally

    return tally.compiled, tally.seconds
