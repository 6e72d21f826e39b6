"""A copy of an array into another one, for compiled code.

As an assignment to a slice, it would make numba compile what formats the error of shapes that
differ, text and all: 2.5 s of the first run on a machine.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from . import compiled

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


@compiled(forceinline=True)
def copy_into(target: NDArray[np.float64], source: NDArray[np.float64]) -> None:
    """The elements of one array into another one of one dimension and as many elements."""
    for i in range(len(target)):
        target[i] = source[i]
