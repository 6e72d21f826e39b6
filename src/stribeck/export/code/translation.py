"""Translation of compiled Python into a program that other languages can express.

A law, a part of an axis and the stepper are compiled functions whose source is Python. `translate`
reads that source, follows it into the functions that it calls, and gives back functions of a few
kinds of statements over three kinds of values, real, whole and truth. What a dialect prints is
thereby the function itself, not a second copy of it. Whatever has no place in the few kinds is
refused, with the line that has it.

A function is translated anew for each kind of arguments that it is called with: those that are
known (numbers, truths, functions) are no arguments any more, and what they rule out is left out. An
argument or a result is a whole number or a truth where its annotation says `int` or `bool`, and
several values where it names a NamedTuple. A loop over values that are known is its body for each;
arrays are cut where that is known (`array_reader`), and those of a module are tables.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from .function_source import FunctionSource
from .program import (
    MATH_FUNCTIONS,
    Array,
    Call,
    Expression,
    Item,
    Number,
    Program,
    ProgramFunction,
    Return,
    Truth,
    expressions,
)
from .statement_reader import StatementReader


def translate(
    entries: Sequence[FunctionSource], what: str, before: Sequence[FunctionSource] = ()
) -> Program:
    """Translate functions and all that they call.

    Args:
        entries: The functions.
        what: Whose they are, for messages.
        before: Functions that they may call by name: those that they call are there.

    Raises:
        InputError: a source that is not there, or says something that has no place in a program.
    """
    translation = _Translation(what, frozenset(entry.name for entry in (*before, *entries)))
    for entry in (*before, *entries):
        translation.add(entry)
    names = tuple(e.name for e in entries)
    used = set(names)
    for f in reversed(translation.functions.values()):  # each after those that it calls
        if f.name in used:
            used |= {x.name for x in expressions(f.body) if isinstance(x, Call)}
    functions = tuple(f for f in translation.functions.values() if f.name in used)
    read = {x.array for f in functions for x in expressions(f.body) if isinstance(x, Item)}
    read |= {x.name for f in functions for x in expressions(f.body) if isinstance(x, Array)}
    tables = {name: values for name, values in translation.tables.items() if name in read}
    return Program(functions, names, tuple(name for name in MATH_FUNCTIONS if name in used), tables)


class _Translation:
    """What has been translated so far."""

    def __init__(self, what: str, reserved: frozenset[str]) -> None:
        self.what, self._reserved = what, reserved | MATH_FUNCTIONS.keys()
        self.functions: dict[str, ProgramFunction] = {}
        self.entries: dict[str, FunctionSource] = {}
        self.tables: dict[str, tuple[float, ...]] = {}
        self._names: dict[tuple[Any, ...], str] = {}
        #: Functions that are being read: what they call must not lead back to them.
        self.being_read: list[Callable[..., Any]] = []

    def add(self, entry: FunctionSource) -> None:
        """Translate an entry under its own name."""
        self.entries[entry.name] = entry
        self.functions[entry.name] = StatementReader(self, entry, entry.name).function()

    def translated_name(self, source: FunctionSource) -> str:
        """The name in the program of a function that another calls; translated once.

        Args:
            source: It, by the name that its caller calls it.
        """
        if source.key not in self._names:
            unique = source.name.lstrip("_")
            while unique in self._names.values() or unique in self._reserved:
                unique += "_"
            self._names[source.key] = unique
            self.add(replace(source, name=unique))
        return self._names[source.key]

    def table(self, name: str, values: np.ndarray[Any, Any]) -> str:
        """The name in the program of a table of numbers.

        Args:
            name: Its name in its module.
            values: (n,), or (rows, columns), which stand one after the other.
        """
        numbers, unique = tuple(values.ravel().tolist()), f"table_{name.strip('_').lower()}"
        while self.tables.get(unique, numbers) != numbers:
            unique += "_"
        self.tables[unique] = numbers
        return unique

    def known_value(self, value: Expression) -> Number | Truth | None:
        """What a call gives, of a function that gives the same each time and does no more."""
        function = self.functions.get(value.name) if isinstance(value, Call) else None
        match function and function.body:
            case (Return(value=Number() | Truth() as known, more=()),):
                return known
        return None

    def known_results(self, call: Call) -> list[Number | None]:
        """The same of each result of a function that gives several."""
        function = self.functions[call.name]
        match function.body:
            case (Return(value=value, more=more),):
                return [x if isinstance(x, Number) else None for x in (value, *more)]
        return [None for _ in function.results]
