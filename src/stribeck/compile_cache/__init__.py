"""Compiled functions whose machine code is kept on disk, addressed by all that is compiled in.

`compiled` is numba's `njit` with a cache of its own. Numba addresses what it keeps by the file
that defines a function, and goes on using machine code into which functions of other files were
compiled after those have changed. Here the address is a digest of content, of the types that a
function is compiled for, of the versions of Python, NumPy, numba and llvmlite, and of the
processor; so nothing kept is ever out of date, copies of the package share it, and laws that are
typed at a prompt are kept, too. What happens is told to the logger `stribeck`, which prints
nothing until a program listens to it.
"""

from __future__ import annotations

import logging
import os
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from hashlib import sha256
from pathlib import Path
from time import perf_counter
from typing import Any

import llvmlite
import numba
import numpy as np
from numba import njit
from numba.core import event, typeinfer
from numba.core.caching import NullCache
from numba.core.compiler import CompileResult
from numba.core.types import unliteral

from .cache_folder import Folder
from .content import UnknownContentError, digest

__all__ = ["compiled", "tally"]

#: Settings of numba that leave machine code as it is.
_HARMLESS = frozenset({"NUMBA_CACHE_DIR", "NUMBA_NUM_THREADS", "NUMBA_THREADING_LAYER"})

_log = logging.getLogger("stribeck")
_log.addHandler(logging.NullHandler())


def compiled(signature: Any = None, **options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Compile a function like `numba.njit`, with machine code kept across processes.

    Args:
        signature: It is compiled for this one, at once; without, for the types that it is first
            called with, also in other compiled code.
        options: Those of `njit`; division by zero is NumPy's unless `error_model` says otherwise.
            Of two that inline a function, `forceinline` is for one that is called in several
            places: it is optimised by itself first. One that is called in a single place of what
            it is compiled into, and is long, takes `inline="always"`: it becomes part of its
            caller at once, and is not optimised and turned into machine code twice.
    """

    def decorate(function: Callable[..., Any]) -> Any:
        dispatcher = njit(**{"error_model": "numpy", **options})(function)
        dispatcher._cache = _MachineCode(dispatcher)  # noqa: SLF001 - what numba's `enable_caching` sets
        for name in ("get_call_template", "fold_argument_types"):  # of others, and of itself
            setattr(dispatcher, name, _of_types(getattr(dispatcher, name)))
        if signature is not None:
            with typeinfer.register_dispatcher(dispatcher):  # it may call itself
                dispatcher.compile(signature)
            dispatcher.disable_compile()
        return dispatcher

    return decorate


def _of_types(typed: Callable[..., Any]) -> Callable[..., Any]:
    """How a dispatcher types a call in compiled code, whatever the values of the arguments.

    Numba compiles a function, and all that it calls, once more for each constant that it is called
    with; one that calls itself with a constant would crash once it is loaded from disk, as the
    version for that constant is no part of it.
    """

    def plain(args: tuple[Any, ...], kws: Mapping[str, Any]) -> Any:
        return typed(tuple(map(unliteral, args)), {k: unliteral(a) for k, a in kws.items()})

    return plain


@dataclass
class CompileCounts:
    """What this process has loaded from disk and compiled."""

    loaded: int = 0
    compiled: int = 0
    #: Time spent in compiling, s.
    seconds: float = 0.0

    @property
    def path(self) -> Path:
        """The folder in which machine code is kept across processes."""
        return _folder.path

    @property
    def kept(self) -> bool:
        """Whether what this process compiles is there for the next."""
        return _folder.writable == _folder.path


tally = CompileCounts()
_folder = Folder()


class _MachineCode(NullCache):  # type: ignore[misc]
    """The machine code of one function, as numba's dispatchers load and save it."""

    def __init__(self, dispatcher: Any) -> None:
        self._dispatcher = dispatcher
        self._names: dict[Any, str | None] = {}

    @property
    def cache_path(self) -> str:
        return str(_folder.path)

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """A compile result, or None: then numba compiles the function, and saves it."""
        target_context.refresh()
        name = self._name(sig, target_context.codegen())
        data = None if name is None else _folder.load(name)
        if data is not None:
            tally.loaded += 1
            return CompileResult._rebuild(target_context, *data)  # noqa: SLF001 - as numba's own
        if not tally.compiled and tally.kept:
            _log.info("compiling for this machine, once")
        tally.compiled += 1
        return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep a compile result, unless it holds addresses of this process."""
        name = self._names[str(sig)]
        if name is not None and not data.library.has_dynamic_globals:
            _folder.save(name, data._reduce())  # noqa: SLF001 - as numba's own

    def _name(self, sig: Any, codegen: Any) -> str | None:
        """The file's name; None where content cannot be told.

        The name goes into the function's own, too: the linker knows functions by name and a count
        that begins anew in each process, and from one of two functions of one name, one from disk
        and one compiled here, it could lead to the other.
        """
        function = self._dispatcher.py_func
        try:
            content = digest(self._dispatcher, _types(sig))
        except UnknownContentError:
            self._names[str(sig)] = None
            return None
        text = repr((content, codegen.magic_tuple(), _environment()))
        address = sha256(text.encode()).hexdigest()[:32]
        if not self._names:
            function.__qualname__ += f"_{address[:8]}"
        plain = "".join(c for c in function.__name__ if c.isidentifier() or c.isdigit())
        self._names[str(sig)] = f"{plain}-{address}.nbc"
        return self._names[str(sig)]


def _types(sig: Any) -> tuple[Any, ...]:
    """Of the arguments, and of the result where the signature says it."""
    return (*sig.args, sig.return_type) if hasattr(sig, "args") else tuple(sig)


@cache
def _environment() -> tuple[Any, ...]:
    """What machine code depends on beside the function and the processor."""
    settings = {k: v for k, v in os.environ.items() if k.startswith("NUMBA_")}
    return (
        sys.version, np.__version__, numba.__version__, llvmlite.__version__,
        sorted((k, v) for k, v in settings.items() if k not in _HARMLESS),
    )  # fmt: skip


class _CompileTimer(event.Listener):  # type: ignore[misc]
    """Adds up the time that numba compiles; what is compiled on the way is part of it."""

    def __init__(self) -> None:
        self._depth, self._start = 0, 0.0

    def on_start(self, event: Any) -> None:  # noqa: ARG002 - numba's signature
        if not self._depth:
            self._start = perf_counter()
        self._depth += 1

    def on_end(self, event: Any) -> None:  # noqa: ARG002 - numba's signature
        self._depth -= 1
        if not self._depth:
            tally.seconds += perf_counter() - self._start


event.register("numba:compile", _CompileTimer())
