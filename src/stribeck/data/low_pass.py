"""Low passes of Butterworth and Chebyshev, as second-order sections.

scipy.signal has them, too, for most of a second of start-up, which every command would wait for.

A prototype's poles, of cut-off 1 rad/s, are moved to the cut-off and taken to sampled time by the
bilinear transform s = 2 (z − 1) / (z + 1), by which all zeros come to lie at z = −1; the cut-off is
warped beforehand to where that leaves it. (Parks and Burrus 1987, Digital Filter Design, chapter 7,
ISBN 0-471-82896-3.)
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..space import Array

#: A pole is real whose imaginary part is below this share of it.
_REAL = 1e-10


def butterworth(order: int, cutoff: float) -> Array:
    """Sections (n, 6) of the low pass that is flattest at 0 Hz.

    Args:
        order: Its order, at least 1.
        cutoff: Where half of the power is left, as a share of the rate, below 1/2.
    """
    return _sections(-np.exp(1j * _angles(order)), 1.0, cutoff)


def chebyshev(order: int, ripple: float, cutoff: float) -> Array:
    """Sections (n, 6) of a low pass that is steeper, and ripples in what it passes.

    Args:
        order: Its order, at least 1.
        ripple: How much it takes away there at most, dB.
        cutoff: Where it takes away more, as a share of the rate, below 1/2.
    """
    depth = np.sqrt(10.0 ** (0.1 * ripple) - 1.0)
    poles = -np.sinh(np.arcsinh(1.0 / depth) / order + 1j * _angles(order))
    gain = float(np.prod(-poles).real)
    return _sections(poles, gain if order % 2 else gain / np.sqrt(1.0 + depth**2), cutoff)


def settled(sections: Array) -> Array:
    """The states (n, 2) that sections (n, 6) have settled to under a constant 1."""
    states, level = np.empty((len(sections), 2)), 1.0
    for state, (b0, b1, b2, _, a1, a2) in zip(states, sections, strict=True):
        after = level * (b0 + b1 + b2) / (1.0 + a1 + a2)
        state[1] = b2 * level - a2 * after
        state[0] = after - b0 * level
        level = after
    return states


def _angles(order: int) -> Array:
    """Those of the poles of a prototype from the negative real axis, (order,)."""
    return np.pi * np.arange(1 - order, order, 2) / (2 * order)


def _sections(poles: NDArray[np.complex128], gain: float, cutoff: float) -> Array:
    """Sections of a prototype, the most resonant one last; all of its gain is in the first."""
    warped = 4.0 * np.tan(np.pi * cutoff)
    poles, gain = warped * poles, gain * warped ** len(poles)
    gain *= float((1.0 / np.prod(4.0 - poles)).real)
    poles = (4.0 + poles) / (4.0 - poles)
    upper = poles[poles.imag > _REAL * np.abs(poles)]
    upper = upper[np.argsort(np.abs(upper))]
    sections = [[1.0, 2.0, 1.0, 1.0, -2.0 * p.real, abs(p) ** 2] for p in upper]
    if len(poles) % 2:
        alone = float(poles[np.argmin(np.abs(poles.imag))].real)
        sections.insert(0, [1.0, 1.0, 0.0, 1.0, -alone, 0.0])
    result = np.array(sections)
    result[0, :3] *= gain
    return result
