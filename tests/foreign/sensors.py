"""What a log makes of a motion: noise, steps, and faults.

A table is a dict of channels, arrays of one length, with the instants under "t" (`motion._asdict()`
of any simulator). Every function returns a new table; chance comes from the caller's generator.
"""

from __future__ import annotations

import numpy as np
from numpy.random import Generator
from scipy.signal import lfilter

from .clock import Array

Table = dict[str, Array]


# --- sampling, noise, steps -----------------------------------------------------------------------


def sampled(table: Table, dt: float, rng: Generator | None = None, jitter: float = 0.0) -> Table:
    """Every channel at instants dt apart, each off by at most `jitter` dt, straight in between."""
    t = table["t"]
    instants = t[0] + dt * np.arange(int((t[-1] - t[0]) / dt + 1e-9) + 1)
    if rng is not None and jitter > 0.0:
        instants[1:-1] += dt * jitter * rng.uniform(-1.0, 1.0, len(instants) - 2)
    return {name: np.interp(instants, t, values) for name, values in table.items()} | {
        "t": instants
    }


def noisy(table: Table, channel: str, sd: float, rng: Generator, memory: float = 0.0) -> Table:
    """Gaussian noise: white, or AR(1) that forgets within `memory` samples (to 1/e)."""
    white = rng.standard_normal(len(table["t"]))
    return table | {channel: table[channel] + sd * autoregressive(white, memory)}


def autoregressive(white: Array, memory: float) -> Array:
    """AR(1) of unit variance from unit white noise, in its steady state from the first sample."""
    if memory <= 0.0:
        return white
    keep = np.exp(-1.0 / memory)
    fresh = np.sqrt(1.0 - keep**2) * white
    fresh[0] = white[0]
    noise: Array = lfilter([1.0], [1.0, -keep], fresh)
    return noise


def quantised(table: Table, channel: str, step: float) -> Table:
    """The nearest whole number of steps."""
    return table | {channel: step * np.round(table[channel] / step)}


# --- faults of a value ----------------------------------------------------------------------------


def clipped(table: Table, channel: str, limit: float) -> Table:
    """Within plus and minus the limit."""
    return table | {channel: np.clip(table[channel], -limit, limit)}


def reset(table: Table, channel: str, at: float, to: float = 0.0) -> Table:
    """An encoder that counts from `to` again, from the instant `at` on."""
    values, i = table[channel].copy(), int(np.searchsorted(table["t"], at))
    values[i:] += to - values[i]
    return table | {channel: values}


def wrapped(table: Table, channel: str, low: float, high: float) -> Table:
    """A counter that goes on at the other end of its range."""
    return table | {channel: low + np.mod(table[channel] - low, high - low)}


def scaled(table: Table, channel: str, gain: float) -> Table:
    """A sensor whose gain is off."""
    return table | {channel: gain * table[channel]}


def played(table: Table, channel: str, width: float) -> Table:
    """Behind a play of a width: it follows once the play is taken up."""
    values = table[channel].copy()
    for i in range(1, len(values)):
        values[i] = min(max(values[i - 1], values[i] - width / 2), values[i] + width / 2)
    return table | {channel: values}


def loaded(table: Table, channel: str, mass: float, at: float) -> Table:
    """A force with that of a mass besides, picked up at an instant, along the same motion."""
    pull = mass * np.gradient(table["velocity"], table["t"])
    return table | {channel: table[channel] + pull * (table["t"] >= at)}


def fetched(table: Table, channel: str, mass: float, stays: float) -> Table:
    """A force with that of a mass besides, there for some seconds and away for as many."""
    pull = mass * np.gradient(table["velocity"], table["t"])
    return table | {channel: table[channel] + pull * (table["t"] // stays % 2 == 1)}


def carried(table: Table, channel: str, mass: float) -> Table:
    """A force with that of a mass besides, carried to the right and not back."""
    pull = mass * np.gradient(table["velocity"], table["t"])
    return table | {channel: table[channel] + pull * (table["velocity"] > 0.0)}


def braked(table: Table, channel: str, size: float) -> Table:
    """A force with friction besides that is there while the motion slows down."""
    v, a = table["velocity"], np.gradient(table["velocity"], table["t"])
    return table | {channel: table[channel] + size * np.sign(v) * (a * v < 0.0)}


def pushed(table: Table, channel: str, size: float, low: float, high: float) -> Table:
    """A force with one besides that acts between two positions, on the way to the right."""
    x = table["position"]
    acts = (x > low) & (x < high) & (table["velocity"] > 0.0)
    return table | {channel: table[channel] + size * acts}


def wandered(table: Table, channel: str, size: float, seconds: float) -> Table:
    """A force with friction besides that rises and falls, in two periods that hardly meet again."""
    phases = 2.0 * np.pi * table["t"] / seconds
    more = 0.5 * size * (np.sin(phases) + np.sin(0.61 * phases))
    return table | {channel: table[channel] + more * np.sign(table["velocity"])}


def frozen(table: Table, channel: str, start: float, stop: float) -> Table:
    """The value at `start` until `stop`."""
    values, (i, j) = table[channel].copy(), np.searchsorted(table["t"], (start, stop))
    values[i:j] = values[i]
    return table | {channel: values}


def jumped(table: Table, channel: str, at: float, by: float) -> Table:
    """Off by `by` from an instant on."""
    return table | {channel: table[channel] + by * (table["t"] >= at)}


def outlying(table: Table, channel: str, share: float, size: float, rng: Generator) -> Table:
    """A share of the samples, at least one, off by `size` either way."""
    values = table[channel].copy()
    hit = rng.choice(len(values), max(round(share * len(values)), 1), replace=False)
    values[hit] += size * rng.choice([-1.0, 1.0], len(hit))
    return table | {channel: values}


def gap(table: Table, start: float, stop: float) -> Table:
    """Without the rows from `start` to before `stop`."""
    kept = (table["t"] < start) | (table["t"] >= stop)
    return {name: values[kept] for name, values in table.items()}


# --- faults of a channel's time -------------------------------------------------------------------


def held(table: Table, channel: str, period: float, phase: float = 0.0) -> Table:
    """A channel that is renewed once a period, slower than the log, and repeats in between."""
    t = table["t"]
    renewed = np.floor((t - t[0] - phase) / period + 1e-9) * period + phase + t[0]
    return table | {channel: np.interp(renewed, t, table[channel])}


def aliased(table: Table, channel: str, amplitude: float, frequency: float) -> Table:
    """A ripple, as a sampler without a filter sees it if it is faster than half the sampling."""
    ripple = amplitude * np.sin(2.0 * np.pi * frequency * table["t"])
    return table | {channel: table[channel] + ripple}


def delayed(table: Table, channel: str, seconds: float) -> Table:
    """Late by so much (early, if negative); ends repeat the first or last value."""
    return table | {channel: np.interp(table["t"] - seconds, table["t"], table[channel])}


def drifting(table: Table, channel: str, first: float, last: float) -> Table:
    """A channel on a clock of its own: late by `first` seconds at first and by `last` at last."""
    t = table["t"]
    late = first + (last - first) * (t - t[0]) / (t[-1] - t[0])
    return table | {channel: np.interp(t - late, t, table[channel])}


def low_passed(table: Table, channel: str, cutoff: float) -> Table:
    """A first-order filter of a cut-off in Hz, exact for a value that is held between samples."""
    t, values = table["t"], table[channel].copy()
    share = 1.0 - np.exp(-2.0 * np.pi * cutoff * np.diff(t))
    for i in range(1, len(values)):
        values[i] = values[i - 1] + share[i - 1] * (values[i] - values[i - 1])
    return table | {channel: values}
