"""The threads that share the rows of a call: whoever is free takes the next row.

The caller works too, so that a short call does not wait for anybody, and candidates that differ
in cost leave nobody idle. Which thread does a row never matters to what comes out.
"""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import Any

import numpy as np
from numba import int64, njit
from numba.core import cgutils
from numba.extending import intrinsic

#: Fewest rows for which another thread is woken: waking it costs about as much as a row.
FEWEST = 4


def threads() -> int:
    """How many threads share the candidates: the cores there are, or OMP_NUM_THREADS if fewer."""
    n = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    told = os.environ.get("OMP_NUM_THREADS", "")  # how one tells a program that it is not alone
    return min(n, int(told)) if told.isdecimal() and int(told) > 0 else n


@intrinsic  # type: ignore[untyped-decorator]
def _next(typing: Any, counter: Any) -> Any:
    """The value of a shared counter, which grows by one in the same instant."""

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        array = context.make_array(signature.args[0])(context, builder, values[0])
        one = context.get_constant(int64, 1)
        return builder.atomic_rmw("add", array.data, one, "monotonic")

    del typing
    return int64(counter), generate


@intrinsic  # type: ignore[untyped-decorator]
def lent(typing: Any, array: Any) -> Any:
    """The same array without its owner: what is made of it is not counted, which takes locks.

    For inner loops whose caller holds the array.
    """

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        made = context.make_array(signature.args[0])(context, builder, values[0])
        made.meminfo = cgutils.get_null_value(made.meminfo.type)
        made.parent = cgutils.get_null_value(made.parent.type)
        return made._getvalue()  # noqa: SLF001 - numba's name for it

    del typing
    return array(array), generate


@njit(int64(int64[::1]), cache=True)
def take(counter: Any) -> int:
    """The next row that nobody has taken."""
    return _next(counter)  # type: ignore[no-any-return]


@cache
def _workers() -> tuple[ThreadPoolExecutor, int]:
    n = threads()
    return ThreadPoolExecutor(max(1, n - 1), thread_name_prefix="stribeck"), n


if hasattr(os, "register_at_fork"):  # a child has none of its parent's threads
    os.register_at_fork(after_in_child=_workers.cache_clear)


def share(work: Any, rows: int, arguments: tuple[Any, ...]) -> None:
    """Run `work(*arguments, counter)` in this thread and the others until no row is left.

    Args:
        work: Takes rows from the counter (`take`) until it passes the last one.
        rows: How many there are.
        arguments: What it is called with, before the counter.
    """
    pool, n = _workers()
    counter = np.zeros(1, dtype=np.int64)
    others = min(n - 1, rows // FEWEST)
    jobs = [pool.submit(work, *arguments, counter) for _ in range(others)]
    work(*arguments, counter)
    for job in jobs:
        if not job.cancel():  # one that never began has nothing left to do
            job.result()
