"""Threads that simulate the rows of a call; each takes the next row not yet taken.

The calling thread works too, so a short call waits for no other, and rows that differ in cost
leave no thread idle. Results do not depend on which thread does a row.

Waking a thread takes as long as a row or two, so a thread that has just worked looks out for the
next call for a moment before it sleeps, and the caller for the last row of the others. Neither
holds Python's lock meanwhile.
"""

from __future__ import annotations

import os
from functools import cache
from queue import Empty, SimpleQueue
from threading import Lock, Thread
from typing import Any

import numpy as np
from numba import boolean, int64
from numba.core import cgutils
from numba.extending import intrinsic

from ...compile_cache import compiled

#: Fewest rows for which another thread is woken, and fewest samples of them all.
FEWEST, FEWEST_SAMPLES = 4, 2_000
#: Calls at a time whose beginning waiting threads see, and looks that they take before they sleep:
#: some 0.1 ms.
SLOTS, LOOKS = 8, 10_000


def threads() -> int:
    """How many threads share the candidates: the cores there are, or OMP_NUM_THREADS if fewer."""
    n = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    setting = os.environ.get("OMP_NUM_THREADS", "")  # how one tells a program that it is not alone
    return min(n, int(setting)) if setting.isdecimal() and int(setting) > 0 else n


@intrinsic
def _next(typing: Any, counter: Any) -> Any:
    """The value of a shared counter, which grows by one in the same instant."""

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        array = context.make_array(signature.args[0])(context, builder, values[0])
        increment = context.get_constant(int64, 1)
        return builder.atomic_rmw("add", array.data, increment, "acq_rel")

    del typing
    return int64(counter), generate


@intrinsic
def _look(typing: Any, counter: Any) -> Any:
    """The value of a shared counter, read anew each time."""

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        array = context.make_array(signature.args[0])(context, builder, values[0])
        return builder.load_atomic(array.data, "acquire", 8)

    del typing
    return int64(counter), generate


@intrinsic
def borrowed(typing: Any, array: Any) -> Any:
    """The same array without its owner: what is made of it is not counted, which takes locks.

    For inner loops whose caller holds the array.
    """

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        view = context.make_array(signature.args[0])(context, builder, values[0])
        view.meminfo = cgutils.get_null_value(view.meminfo.type)
        view.parent = cgutils.get_null_value(view.parent.type)
        return view._getvalue()  # noqa: SLF001 - numba's name for it

    del typing
    return array(array), generate


@compiled()
def next_row(counter: Any) -> int:
    """The next row that no thread has taken."""
    return _next(counter)  # type: ignore[no-any-return]


@compiled(boolean(int64[::1], int64), nogil=True)
def _comes_to(counter: Any, value: int) -> bool:
    """Whether a counter reaches a value while one looks."""
    for _ in range(LOOKS):  # noqa: SIM110 - numba has no generators inside a function
        if _look(counter) >= value:
            return True
    return False


@compiled(boolean(int64[:, ::1]), nogil=True)
def _any_starts(counters: Any) -> bool:
    """Whether one of the counters starts from 0 while one looks."""
    idle = np.zeros(len(counters), np.bool_)
    for _ in range(LOOKS):
        for k in range(len(counters)):
            if _look(counters[k]) == 0:
                idle[k] = True
            elif idle[k]:
                return True
    return False


class RowPool:
    """Threads that wait for work, one fewer than `n`: the caller is one of them."""

    def __init__(self, n: int) -> None:
        self.n = n
        self._counters = np.zeros((SLOTS, 8), dtype=np.int64)  # each in a cache line of its own
        self._free = list(range(SLOTS))
        self._jobs: SimpleQueue[_PoolCall | None] = SimpleQueue()
        for k in range(1, n):
            Thread(target=self._serve, name=f"stribeck-{k}", daemon=True).start()

    def share(self, work: Any, rows: int, arguments: tuple[Any, ...], fewest: int = FEWEST) -> None:
        """Run `work(*arguments, counter)` in this thread and the others until no row is left.

        Args:
            work: Takes rows from the counter (`next_row`) until it passes the last one.
            rows: How many there are.
            arguments: What it is called with, before the counter.
            fewest: Rows for each further thread; fewer where a row takes long.
        """
        try:
            slot = self._free.pop()
        except IndexError:  # more calls at a time than are looked out for
            slot, counter = -1, np.zeros(8, dtype=np.int64)
        else:
            counter = self._counters[slot]
            counter[0] = 0
        call = (work, (*arguments, counter))
        jobs = [_PoolCall(call) for _ in range(min(self.n - 1, rows // fewest))]
        for job in jobs:
            self._jobs.put(job)
        try:
            work(*call[1])
        finally:
            started = [job for job in jobs if not job.withdrawn()]
            # Everybody takes one number too many: then the rows are done.
            if started and not _comes_to(counter, rows + 1 + len(started)):
                for job in started:
                    job.finish()
            if slot >= 0:
                self._free.append(slot)

    def dismiss(self) -> None:
        """Let the threads go."""
        for _ in range(1, self.n):
            self._jobs.put(None)

    def _serve(self) -> None:
        job = self._jobs.get()
        while job is not None:
            job.run()
            try:
                job = self._jobs.get_nowait()
            except Empty:
                _any_starts(self._counters)
                job = self._jobs.get()


class _PoolCall:
    """A call for another thread; it is dropped if none has started it when the caller is done."""

    def __init__(self, call: tuple[Any, tuple[Any, ...]]) -> None:
        self._calls = [call]
        self._ended: SimpleQueue[BaseException | None] = SimpleQueue()

    def run(self) -> None:
        try:
            work, arguments = self._calls.pop()
        except IndexError:  # the caller did it all
            return
        try:
            work(*arguments)
        except BaseException as error:  # noqa: BLE001 - raised where the work was asked for
            self._ended.put(error)
        else:
            self._ended.put(None)

    def withdrawn(self) -> bool:
        """Take the call back; False if a thread has started it."""
        try:
            self._calls.pop()
        except IndexError:
            return False
        return True

    def finish(self) -> None:
        """Wait until it has ended."""
        error = self._ended.get()
        if error is not None:
            raise error from None


@cache
def _pool_of_process() -> RowPool:
    return RowPool(threads())


def pool() -> RowPool:
    """The pool of this process."""
    with _POOL_LOCK:
        return _pool_of_process()


_POOL_LOCK = Lock()


def _alone() -> None:
    """A child has none of its parent's threads, and none of its locks."""
    global _POOL_LOCK  # noqa: PLW0603
    _POOL_LOCK = Lock()
    _pool_of_process.cache_clear()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_alone)
