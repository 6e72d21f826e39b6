"""Commands: arrays of times and positions."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .clock import Array


def even(span: float, dt: float) -> Array:
    """Instants from 0 to `span`, both included."""
    return dt * np.arange(round(span / dt) + 1)


def strokes(
    speeds: Array, length: float, ramp: float = 0.1, pause: float = 0.1, dt: float = 1e-3
) -> tuple[Array, Array, Array]:
    """Times, positions and speeds: there and back once at each speed, with rests between.

    The speed rises and falls within `ramp` seconds as a raised cosine, so the acceleration has no
    jump.
    """
    rise = 0.5 - 0.5 * np.cos(np.pi * np.arange(round(ramp / dt)) * dt / ramp)
    rest = np.zeros(round(pause / dt))
    pieces = [rest]
    for speed in speeds:
        flat = np.ones(max(round((length / speed - ramp) / dt), 0))
        stroke = speed * np.concatenate([rise, flat, 1.0 - rise])
        pieces += [stroke, rest, -stroke, rest]
    velocity = np.concatenate(pieces)
    steps = 0.5 * dt * (velocity[1:] + velocity[:-1])
    return dt * np.arange(len(velocity)), np.concatenate([[0.0], np.cumsum(steps)]), velocity


def sines(
    span: float, amplitudes: Array, frequencies: Array, dt: float = 1e-3
) -> tuple[Array, Array]:
    """A sum of sines, each at zero at first."""
    t = even(span, dt)
    return t, np.sin(2.0 * np.pi * np.outer(t, frequencies)) @ np.asarray(amplitudes, float)


def levels(runs: Sequence[tuple[float, float, float]], dt: float = 1e-3) -> tuple[Array, Array]:
    """Times and positions of speeds that are held in turn, from rest.

    Args:
        runs: A speed, for how long it is held, and how long the way to it takes, each.
        dt: From sample to sample.
    """
    speeds = [np.zeros(1)]
    for speed, span, rise in runs:
        share = np.arange(1, round(rise / dt) + 1) * dt / rise
        before = speeds[-1][-1]
        speeds.append(before + (speed - before) * share**2 * (3.0 - 2.0 * share))
        speeds.append(np.full(round(span / dt), speed))
    v = np.concatenate(speeds)
    steps = 0.5 * dt * (v[1:] + v[:-1])
    return dt * np.arange(len(v)), np.concatenate([[0.0], np.cumsum(steps)])


def ramp(span: float, speed: float) -> tuple[Array, Array]:
    """A straight line from 0."""
    return np.array([0.0, span]), np.array([0.0, speed * span])


def combined(
    span: float, way: float, speeds: Array, below: float = 1.0 / 3.0, dt: float = 1e-3
) -> tuple[Array, Array]:
    """Two sines that grow from a third of a way to four times it, then strokes at each speed.

    `below` is the share of the span that the sines take. Strokes last a second each way.
    """
    t = even(span, dt)
    first = below * span
    grow = way * np.interp(t, [0.0, first], [0.3, 4.0]) * np.clip((first - t) / 0.2, 0.0, 1.0)
    waves = np.sin(2.0 * np.pi * 0.55 * t) + 0.4 * np.sin(2.0 * np.pi * 1.25 * t)
    s = np.maximum(t - first, 0.0)
    each = (span - first) / len(speeds)
    place = np.minimum((s / each).astype(int), len(speeds) - 1)
    left = each - (s - place * each)
    edge = np.clip(np.minimum(s - place * each, left) / 0.05, 0.0, 1.0)
    v = speeds[place] * np.tanh(8.0 * np.sin(np.pi * (s - place * each))) * edge
    return t, grow * waves + dt * np.cumsum(v)
