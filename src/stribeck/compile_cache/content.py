"""The content of a compiled function as a digest: equal digests mean equal machine code.

Content is the bytecode and the constants of the function and of every function that it calls, in
whatever file, with the values of the globals that they read and the options that they are compiled
with. Line numbers, comments, docstrings and the place of a file are not. What belongs to Python,
NumPy or numba counts by its name: their versions are part of the address of every function.
"""

from __future__ import annotations

import inspect
import os
import sys
from collections.abc import Iterator, Sequence
from functools import cache
from hashlib import sha256
from pathlib import Path
from types import CodeType, FunctionType, ModuleType
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numba.core import types
from numba.core.dispatcher import Dispatcher

#: Libraries that count by name, beside Python's own.
_LIBRARIES = frozenset({"numba", "llvmlite", "numpy"})
#: Kinds of constants that their `repr` tells from any other.
_PLAIN = (type(None), type(...), bool, int, float, complex, str, bytes, range)


class UnknownContentError(Exception):
    """A value that compiled code reads and whose content cannot be told."""


_local: WeakKeyDictionary[Any, tuple[bytes, tuple[Any, ...]]] = WeakKeyDictionary()


def digest(function: Any, arguments: Sequence[Any]) -> str:
    """The content of a function compiled for types of its arguments, 64 hexadecimal digits.

    Raises:
        UnknownContentError: it reads a global whose content cannot be told.
    """
    reached: list[Any] = [function]
    place = {function: 0}

    def lines(text: bytes, callees: Sequence[Any]) -> Iterator[bytes]:
        yield text
        for other in callees:
            if other not in place:
                place[other] = len(reached)
                reached.append(other)
            yield b"\0%d" % place[other]

    callees: list[Any] = []
    text = "\0".join(part for each in arguments for part in _type(each, callees)).encode()
    total = sha256(b"".join(lines(text, callees)))
    for each in reached:  # it grows on the way
        if each not in _local:
            _local[each] = _content(each)
        for line in lines(*_local[each]):
            total.update(line)
    return total.hexdigest()


def _content(function: Any) -> tuple[bytes, tuple[Any, ...]]:
    """A function's own content, and the functions that it refers to, in the order of reference."""
    callees: list[Any] = []
    plain = _plain(function)
    parts = [type(function).__name__]
    if isinstance(function, Dispatcher):
        parts += _value(dict(function.targetoptions), callees, ())
    else:  # numba translates a plain function by what its file, as a rule, registers for it
        parts.append(_source(plain))
    names = tuple(_names(plain.__code__))
    cells = tuple(cell.cell_contents for cell in plain.__closure__ or ())
    parts += _value((plain.__defaults__, plain.__kwdefaults__, cells), callees, names)
    parts += _code(plain.__code__, plain.__doc__, callees)
    for name in names:
        if name in plain.__globals__:  # else it is a builtin's or an attribute's
            parts += (name, *_value(plain.__globals__[name], callees, names))
    return "\0".join(parts).encode(), tuple(callees)


def _names(code: CodeType) -> Iterator[str]:
    """The names of globals and attributes in a function and in those that it defines."""
    yield from code.co_names
    for value in code.co_consts:
        if isinstance(value, CodeType):
            yield from _names(value)


def _code(code: CodeType, doc: str | None, callees: list[Any]) -> Iterator[str]:
    shape = (code.co_argcount, code.co_posonlyargcount, code.co_kwonlyargcount, code.co_flags)
    yield repr((code.co_code, getattr(code, "co_exceptiontable", b""), shape, code.co_names,
                code.co_varnames, code.co_freevars, code.co_cellvars))  # fmt: skip
    for value in code.co_consts:
        if isinstance(value, CodeType):
            yield from _code(value, None, callees)
        elif doc is None or value != doc:
            yield from _value(value, callees, ())


def _value(value: Any, callees: list[Any], names: Sequence[str]) -> Iterator[str]:  # noqa: C901, PLR0912 - a kind a case
    """What tells a constant, the value of a global or an option from any other.

    Functions are added to `callees`; of a module, the attributes in `names` count.
    """
    kind = type(value)
    yield kind.__qualname__
    if kind in _PLAIN:
        yield repr(value)
    elif isinstance(value, np.ndarray | np.generic) and not value.dtype.hasobject:
        yield repr((value.dtype.descr, value.shape, value.tobytes()))
    elif isinstance(value, tuple | list):
        yield repr((len(value), getattr(value, "_fields", ())))
        for each in value:
            yield from _value(each, callees, names)
    elif isinstance(value, dict):
        for key in sorted(value):
            yield from _value((key, value[key]), callees, names)
    elif isinstance(value, set | frozenset):
        yield from _value(sorted(value), callees, names)
    elif isinstance(value, types.Type):
        yield from _type(value, callees)
    elif isinstance(value, ModuleType):
        yield value.__name__
        if not _versioned(value.__name__):
            for name in names:
                if hasattr(value, name):
                    yield from (name, *_value(getattr(value, name), callees, names))
    elif _versioned(_module(value)) and _name(value):
        yield repr((getattr(value, "__module__", None), _name(value)))
    elif isinstance(value, type) and issubclass(value, tuple) and hasattr(value, "_fields"):
        yield repr((value.__qualname__, value._fields))
        yield from _value(getattr(value, "_field_defaults", {}), callees, names)
    elif isinstance(_plain(value), FunctionType):
        callees.append(value)
    else:
        raise UnknownContentError(f"a global of type {kind.__qualname__}: {value!r}")


def _type(kind: Any, callees: list[Any]) -> Iterator[str]:
    """What tells a numba type from any other: its name, and what the name leaves out."""
    if isinstance(kind, types.Dispatcher):
        callees.append(kind.dispatcher)
        return
    yield str(kind)
    if isinstance(kind, types.BaseNamedTuple):
        yield repr(tuple(kind.fields))
    for each in kind.types if isinstance(kind, types.BaseTuple) else ():
        yield from _type(each, callees)


def _plain(value: Any) -> Any:
    """The Python function that was compiled or made an intrinsic; else the value itself."""
    return getattr(value, "py_func", getattr(value, "__wrapped__", value))


def _module(value: Any) -> str:
    """The name of the module that defines a value; of a function at a prompt it may be empty."""
    plain = _plain(value)
    if isinstance(plain, FunctionType):
        return str(plain.__globals__.get("__name__", ""))
    return str(getattr(value, "__module__", None) or type(value).__module__)


def _name(value: Any) -> str | None:
    name = getattr(value, "__qualname__", None) or getattr(value, "__name__", None)
    return name if isinstance(name, str) else None


def _versioned(module: str) -> bool:
    """Whether a module belongs to Python or to a library that counts by name."""
    return _is_versioned(module.partition(".")[0])


@cache
def _is_versioned(package: str) -> bool:
    if package not in sys.stdlib_module_names:
        return package in _LIBRARIES
    file = getattr(sys.modules.get(package), "__file__", None)  # one's own may have such a name
    return file is None or Path(file).is_relative_to(Path(os.__file__).parent)


def _source(function: FunctionType) -> str:
    try:
        return Path(inspect.getfile(function)).read_text(encoding="utf-8", errors="replace")
    except (OSError, TypeError):
        return ""
