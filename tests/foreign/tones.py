"""A rail carriage that follows exact tones up to 7.3 Hz: nothing is simulated.

85 kg under 20 N of Coulomb and 214 N s/m of viscous friction; the force has noise of 2 N.
"""

from __future__ import annotations

import numpy as np

from .clock import Array

TRUTH = {"F_C": 20.0, "F_V": 214.0, "M": 85.0}
TONES = (0.31, 0.83, 1.7, 3.1, 4.7, 7.3)
NOISE = 2.0


def axis(
    rate: float = 1000.0, seconds: float = 20.0, seed: int = 20261126
) -> tuple[Array, Array, Array]:
    """Time, s, position, m, and force, N, at a rate in Hz, (N,) each."""
    t = np.arange(round(seconds * rate)) / rate
    x, v, a = np.zeros((3, len(t)))
    for f in TONES:
        w, size = 2 * np.pi * f, 0.08 * np.exp(-0.25 * f) / f
        x += size * np.sin(w * t + 1.3 * f)
        v += size * w * np.cos(w * t + 1.3 * f)
        a -= size * w**2 * np.sin(w * t + 1.3 * f)
    force = TRUTH["M"] * a + TRUTH["F_C"] * np.sign(v) + TRUTH["F_V"] * v
    return t, x, force + NOISE * np.random.default_rng(seed).standard_normal(len(t))
