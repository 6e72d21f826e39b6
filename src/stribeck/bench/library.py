"""Libraries of the extra `bench`, imported when a search needs them."""

from __future__ import annotations

import importlib
from typing import Any

from ..errors import InputError


def library(module: str) -> Any:
    """A module of an installed library.

    Raises:
        InputError: it is not installed.
    """
    try:
        return importlib.import_module(module)
    except ImportError:
        name = module.partition(".")[0]
        raise InputError(f"{name} is not installed: pip install 'stribeck[bench]'") from None
