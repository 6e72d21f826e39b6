"""A compiled Python function that is to be translated, and what is known of its arguments."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class FunctionSource:
    """A function to be translated.

    Args:
        name: Its name in the program.
        function: Python, or compiled by numba.
        arrays: Length of each array among its arguments, by argument; rows and columns of a table;
            0 for numbers of which only the beginning is handed over.
        written: The arrays that it may write; None for any.
        drop: Arguments that are dropped: the function must not read them.
        constants: Arguments whose values are known, numbers or tuples of numbers: they are no
            arguments in the program, and branches that they rule out are not translated.
        functions: Arguments that are functions: the names of entries translated before this one.
        known: Elements of its arrays whose values are known, by place: numbers, or functions that
            stand there by their addresses, as in a row of `rig.motion.axis_row`.
        whole: The arrays of whole numbers.
    """

    name: str
    function: Any
    arrays: Mapping[str, int | tuple[int, int]] = field(default_factory=dict)
    written: tuple[str, ...] | None = ()
    drop: tuple[str, ...] = ()
    constants: Mapping[str, float | tuple[int, ...]] = field(default_factory=dict)
    functions: Mapping[str, str] = field(default_factory=dict)
    known: Mapping[str, Mapping[int, Any]] = field(default_factory=dict)
    whole: tuple[str, ...] = ()

    @property
    def absent(self) -> frozenset[str]:
        """Arguments of the function that its translation does not have."""
        return frozenset((*self.drop, *self.constants, *self.functions))

    @property
    def key(self) -> tuple[Any, ...]:
        """What tells one translation of a function from another."""
        mappings = (self.arrays, self.constants, self.functions)
        known = ((name, *places.items()) for name, places in self.known.items())
        named = (tuple(mapping.items()) for mapping in mappings)
        return python_function(self.function), self.drop, self.whole, *named, *known


def python_function(function: Any) -> Callable[..., Any]:
    """The Python function behind a compiled one."""
    python: Callable[..., Any] = getattr(function, "py_func", function)
    return python
