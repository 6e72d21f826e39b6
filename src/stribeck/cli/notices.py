"""What the package logs, as lines on stderr: that it compiles, and how long that took."""

from __future__ import annotations

import logging
import sys
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def notices() -> Iterator[None]:
    """Print what is logged meanwhile, and at the end what was compiled."""
    logger, handler = logging.getLogger("stribeck"), logging.StreamHandler(sys.stderr)
    handler.setFormatter(logging.Formatter("stribeck: %(message)s"))
    level = logger.level
    logger.addHandler(handler)
    logger.setLevel(logging.INFO)
    try:
        yield
    finally:
        if "stribeck.compile_cache" in sys.modules:  # else nothing was compiled
            from ..compile_cache import tally

            tally.tell()
        logger.removeHandler(handler)
        logger.setLevel(level)
