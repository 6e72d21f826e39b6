"""Checks of hyper-parameters; each error names the method, the setting and its limits."""

from __future__ import annotations

import math
import sys
from itertools import pairwise
from numbers import Integral
from typing import Any, NoReturn

import numpy as np

from ..errors import InputError


def whole(owner: Any, least: int, *names: str) -> None:
    """The named settings are whole numbers of at least `least`."""
    for name in names:
        value = getattr(owner, name)
        if isinstance(value, bool) or not isinstance(value, Integral) or value < least:
            _refuse(owner, name, f"a whole number >= {least}")


def number(owner: Any, *names: str, low: float = -math.inf, high: float = math.inf) -> None:
    """The named settings are finite numbers from `low` to `high`."""
    for name in names:
        value = getattr(owner, name)
        if not (_real(value) and low <= value <= high):
            _refuse(owner, name, f"a number from {low:g} to {high:g}")


def positive(owner: Any, *names: str) -> None:
    """The named settings are finite numbers above zero."""
    for name in names:
        value = getattr(owner, name)
        if not (_real(value) and value > 0):
            _refuse(owner, name, "a number > 0")


def choice(owner: Any, name: str, *allowed: str) -> None:
    """The named setting is one of the words allowed."""
    if getattr(owner, name) not in allowed:
        _refuse(owner, name, " or ".join(map(repr, allowed)))


def stages(owner: Any, name: str) -> None:
    """The named setting is (epsilon, radius) stages, both falling; lists become tuples."""
    try:
        pairs = tuple((float(epsilon), float(radius)) for epsilon, radius in getattr(owner, name))
    except (TypeError, ValueError, OverflowError):
        _refuse(owner, name, "(epsilon, radius) pairs")
    falling = all(e1 > e2 and r1 > r2 for (e1, r1), (e2, r2) in pairwise(pairs))
    numbers = not any(math.isnan(value) for pair in pairs for value in pair)
    if not (numbers and falling) or any(not radius > 0 for _, radius in pairs):
        _refuse(owner, name, "(epsilon, radius) pairs, both falling, radius > 0")
    object.__setattr__(owner, name, pairs)  # a file gives lists; a frozen value is hashable


def even(owner: Any, name: str) -> None:
    """The named setting is an even number."""
    if getattr(owner, name) % 2:
        _refuse(owner, name, "even")


def _real(value: Any) -> bool:
    if isinstance(value, int):  # a file may have one that is no floating-point number
        return abs(value) <= sys.float_info.max
    return isinstance(value, float | np.number) and math.isfinite(value)


def _refuse(owner: Any, name: str, requirement: str) -> NoReturn:
    raise InputError(f"{owner.name}: {name} must be {requirement}, got {getattr(owner, name)!r}")
