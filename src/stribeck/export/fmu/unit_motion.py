"""The motion of a unit in C, and how much room it has in its memory."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ...rig.motion.axis_row import Chain
from ..code.c import c_functions
from ..code.function_source import FunctionSource
from .symbol import Symbol


@dataclass(frozen=True)
class UnitMotion:
    """What steps an axis, as `axis.c` calls it.

    Args:
        source: The functions `motion_start`, `motion_advance` and `motion_tell` in C, and all that
            they call.
        memory: How many numbers they keep from step to step.
        modes: How many whole numbers.
        room: How many numbers they have room for within a step.
    """

    source: str
    memory: int
    modes: int
    room: int


def known_constants(row: Sequence[Any]) -> dict[int, Any]:
    """The constants of a drive that no value of the unit changes, by place."""
    values = (x.function if isinstance(x, Chain) else x for x in row)
    return {i: x for i, x in enumerate(values) if not isinstance(x, Symbol)}


def motion_source(
    laws: Sequence[FunctionSource],
    entries: Sequence[Callable[..., Any]],
    what: str,
    **known: Any,
) -> str:
    """Three functions and all that they call, in C.

    Args:
        laws: The functions of friction.
        entries: What starts an axis, passes a step and tells its outputs, in this order.
        what: Whose they are, for messages.
        known: What all three know, as fields of `FunctionSource`.

    Raises:
        InputError: a law or a part whose source says something that has no place in C.
    """
    names = ("start", "advance", "tell")
    sources = [
        FunctionSource(name, entry, written=None, **_of(entry, known))
        for name, entry in zip(names, entries, strict=True)
    ]
    text = c_functions(sources, what, "motion_", laws)
    return f"/* The motion of this axis, translated from the library that made the unit. */\n{text}"


def _of(entry: Callable[..., Any], known: Mapping[str, Any]) -> dict[str, Any]:
    """What is known of the arguments that a function has."""
    names = entry.__annotations__.keys()
    return {
        field: {n: x for n, x in values.items() if n in names}
        if isinstance(values, dict)
        else tuple(n for n in values if n in names)
        for field, values in known.items()
    }
