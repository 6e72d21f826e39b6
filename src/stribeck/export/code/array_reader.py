"""Reading of a compiled Python function: its source, and the arrays that it names and cuts."""

from __future__ import annotations

import ast
import inspect
import math
import textwrap
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, Protocol

import numpy as np

from ...errors import InputError
from ...rig.motion.part_call import beginning, further
from .folding import by_two
from .function_source import FunctionSource, python_function
from .program import Array, Call, Expression, Item, Kind, Name, Number, ProgramFunction, Truth


class Translator(Protocol):
    """What has been translated so far, as one of its functions sees it."""

    what: str
    functions: dict[str, ProgramFunction]
    entries: dict[str, FunctionSource]
    being_read: list[Callable[..., Any]]
    tables: dict[str, tuple[float, ...]]

    def table(self, name: str, values: np.ndarray[Any, Any]) -> str:
        """The name in the program of a table of numbers."""

    def translated_name(self, source: FunctionSource) -> str:
        """The name in the program of a function that another calls; translated once."""

    def known_value(self, value: Expression) -> Number | Truth | None:
        """What a call gives, of a function that gives the same each time and does no more."""

    def known_results(self, call: Call) -> list[Number | None]:
        """The same of each result of a function that gives several."""


class ArrayReader(ABC):
    """Reads the arrays of one function: by name, and what of them begins and ends where."""

    def __init__(self, translation: Translator, entry: FunctionSource, name: str) -> None:
        self._translation, self._entry, self._name = translation, entry, name
        self._python = python_function(entry.function)
        try:
            lines, self._first = inspect.getsourcelines(self._python)
            self._tree = ast.parse(textwrap.dedent("".join(lines))).body[0]
        except (OSError, TypeError, SyntaxError, IndexError) as error:
            raise InputError(
                f"{translation.what}: cannot be translated: the source of its function "
                f"{getattr(self._python, '__name__', name)!r} is not in a file"
            ) from error
        self._kinds: dict[str, Kind] = {}
        self._variables: dict[str, Name] = {}
        self._arrays: dict[str, Array] = {}
        for array, shape in entry.arrays.items():
            kind: Kind = "whole" if array in entry.whole else "real"
            length, columns = (shape, 1) if isinstance(shape, int) else (math.prod(shape), shape[1])
            self._arrays[array] = Array(array, length, columns=columns, kind=kind)
        #: Local variables that never have but one value, which is known.
        self._fixed: dict[str, Number | Truth] = {}
        #: Values that have names, by that of all of them together.
        self._records: dict[str, dict[str, Name | Number]] = {}
        self._written = set(entry.written or ())
        self._results: tuple[Kind, ...] = ("real",)
        self._known = inspect.getclosurevars(self._python)

    def _array(  # noqa: PLR0911 - one case a line
        self, node: ast.expr
    ) -> Array | None:
        """An array by its name, or what begins within it; None for any other expression."""
        match node:
            case ast.Name(id=name):
                return self._arrays.get(name) or self._table(name)
            case ast.Call(func=ast.Name(id=name), args=[first, *rest]):
                intrinsic, array = self._outside(name), self._array(first)
                if array is None or intrinsic not in (beginning, further):
                    return None
                return self._further(array, sum(self._place(n) for n in rest), 0)
            case ast.Call(func=ast.Attribute(value=table, attr="reshape"), args=[rows, columns]):
                if (array := self._array(table)) is None:
                    return None
                if array.length != self._place(rows) * self._place(columns):
                    raise self._refused(node, f"is no table of {array.length} numbers")
                return replace(array, columns=self._place(columns))
            case ast.Subscript(value=whole, slice=index) if array := self._array(whole):
                return self._part(array, index.elts if isinstance(index, ast.Tuple) else [index])
        return None

    def _part(self, array: Array, places: Sequence[ast.expr]) -> Array | None:
        """A row of a table, or a stretch of a row; None for an element."""
        *row, last = places
        if len(row) > (array.columns > 1):
            raise self._refused(last, f"is no index of {array.name}")
        if array.columns > 1 and not (isinstance(last, ast.Slice) and not row):
            number, rows = self._whole(places[0]), array.length // array.columns
            if isinstance(number, Number) and not 0 <= number.value < rows:
                raise self._refused(places[0], f"is no row of {rows}")
            begin = by_two("*", number, Number(array.columns, "whole"))
            offset = by_two("+", array.offset, begin)
            array = replace(array, length=array.columns, offset=offset, columns=1)
            if not row:
                return array
        return self._stretch(array, last) if isinstance(last, ast.Slice) else None

    def _stretch(self, array: Array, places: ast.Slice) -> Array:
        """Elements of an array, or rows of a table, from one place to another."""
        if places.step is not None:
            raise self._refused(places, "takes not every element")
        rows, wide = array.length // array.columns, array.columns
        low = 0 if places.lower is None else self._place(places.lower)
        high = rows if places.upper is None else self._place(places.upper)
        if not 0 <= low <= high <= rows:
            raise self._refused(places, f"is no part of {rows}")
        return self._further(array, low * wide, (high - low) * wide)

    def _further(self, array: Array, on: int, length: int) -> Array:
        """What begins so many elements on."""
        return replace(array, length=length, offset=by_two("+", array.offset, Number(on, "whole")))

    def _place(self, node: ast.expr) -> int:
        """A whole number that is known."""
        place = self._expression(node)
        if not isinstance(place, Number) or place.kind != "whole":
            raise self._refused(node, "begins or ends where nobody knows")
        return int(place.value)

    def _whole(self, node: ast.expr) -> Expression:
        """An index."""
        place = self._expression(node)
        if place.kind != "whole":
            raise self._refused(node, "is an index that is no whole number")
        return place

    def _item(self, array: Array, node: ast.expr) -> Item:
        """An element, of a table by its row and its column."""
        places = [self._whole(n) for n in (node.elts if isinstance(node, ast.Tuple) else [node])]
        if len(places) != 1 + (array.columns > 1):
            raise self._refused(node, f"is no index of {array.name}")
        index = places[0]
        if array.columns > 1:
            row = by_two("*", index, Number(array.columns, "whole"))
            index = by_two("+", row, places[1])
        if isinstance(index, Number) and not 0 <= index.value < (array.length or math.inf):
            raise self._refused(node, f"reads {array.name}[{index.value}], it has {array.length}")
        return Item(array.name, by_two("+", array.offset, index), array.kind)

    def _table(self, name: str) -> Array | None:
        """A table of numbers among the constants of the module."""
        value = self._outside(name)
        if not (isinstance(value, np.ndarray) and value.dtype == float and value.ndim in (1, 2)):
            return None
        table = self._translation.table(name, value)
        columns = 1 if value.ndim == 1 else value.shape[1]
        return Array(table, value.size, columns=columns)

    def _element(self, item: Item) -> Number | None:
        """An element that is known: a function's address is some number above 0."""
        if not isinstance(item.index, Number):
            return None
        place = int(item.index.value)
        if item.array in self._translation.tables:
            return Number(self._translation.tables[item.array][place])
        value = self._entry.known.get(item.array, {}).get(place)
        if value is None:
            return None
        if item.kind == "whole":
            return Number(int(value), "whole")
        return Number(1.0 if callable(value) else float(value))

    def _known_part(self, array: Array) -> dict[int, Any]:
        """The elements of an array that are known, counted from where it begins."""
        known = self._entry.known.get(array.name, {}) if array.begin >= 0 else {}
        return {place - array.begin: x for place, x in known.items() if place >= array.begin}

    @abstractmethod
    def _expression(self, node: ast.expr) -> Expression:
        """A value."""

    def _outside(self, name: str) -> Any:
        """What a name means that is none of the function's own."""
        for names in (self._known.nonlocals, self._known.globals, self._known.builtins):
            if name in names:
                return names[name]
        return None

    def _refused(self, node: ast.AST, why: str) -> InputError:
        line = self._first + getattr(node, "lineno", 1) - 1
        try:
            text = ast.unparse(node).partition("\n")[0]
        except (ValueError, TypeError, AttributeError):
            text = type(node).__name__
        what, name = self._translation.what, self._python.__name__
        return InputError(f"{what}: cannot be translated: {name}, line {line}: `{text:.60}`: {why}")

    def _writes(self, array: str, node: ast.AST) -> None:
        """An array among the arguments is written."""
        if self._entry.written is not None and array not in self._entry.written:
            raise self._refused(node, f"writes into {array}, which it only reads")
        self._written.add(array)
