"""A carriage that follows exact tones up to 7.3 Hz: nothing is simulated."""

from __future__ import annotations

import numpy as np

from stribeck.space import Array

TONES = (0.31, 0.83, 1.7, 3.1, 4.7, 7.3)


def axis(rate: float = 1000.0, seconds: float = 20.0) -> tuple[Array, Array, Array]:
    """Time, position and force of 85 kg under 20 N and 214 N s/m, with noise of 2 N."""
    t = np.arange(round(seconds * rate)) / rate
    x, v, a = np.zeros((3, len(t)))
    for f in TONES:
        w, size = 2 * np.pi * f, 0.08 * np.exp(-0.25 * f) / f
        x += size * np.sin(w * t + 1.3 * f)
        v += size * w * np.cos(w * t + 1.3 * f)
        a -= size * w**2 * np.sin(w * t + 1.3 * f)
    rng = np.random.default_rng(20261126)
    return t, x, 85.0 * a + 20.0 * np.sign(v) + 214.0 * v + 2.0 * rng.standard_normal(len(t))
