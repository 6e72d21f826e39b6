"""Axes with friction that share nothing with stribeck: what its answers are held against.

Each file is one axis, written from the equations in `docs/` and in the plainest way there is:
fixed tiny steps (velocity first, then position with the new velocity: Euler's rule, first order;
half a step, half the error), an axis at rest that stays while its drive lies within the breakaway
levels, and a velocity that would change its sign within a step is zero first. Nothing here imports
stribeck. All is SI; on a rotary axis read torque, rad and inertia.

A simulator returns a NamedTuple of arrays, one value a sample; `._asdict()` of it is the table of
channels that `sensors` makes a log of. A sample holds the state at its instant and the force that
acts from then on.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any, TypeVar

from numba import njit

__all__ = ["compiled"]

F = TypeVar("F", bound=Callable[..., Any])


def compiled(function: F) -> F:
    """The function, compiled at its first call and kept on disk."""
    return njit(cache=True)(function)  # type: ignore[no-any-return]


def _drop_stale() -> None:
    """Numba notices a change in a function's own file, not in what it calls."""
    here = Path(__file__).parent
    newest = max(file.stat().st_mtime for file in here.glob("*.py"))
    for kept in (here / "__pycache__").glob("*.nb[ic]"):
        with suppress(FileNotFoundError):  # another process is at it, too
            if kept.stat().st_mtime < newest:
                kept.unlink()


_drop_stale()
