"""A recorded velocity that is not that of the position, looked at a block of samples at a time."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from ...space import Array
from ..outliers import SIGMAS, STEPS
from ..repeated_samples import new_samples
from ..resolution import step
from .fault import Fault, mask, shown_as
from .leaps import leaps

if TYPE_CHECKING:
    from ..recording import Recording

#: How many times as far as its recorded velocity a position goes, the greatest within so many
#: samples to each side, and in which share of the samples.
_FASTER, _ABOUT, _OFTEN = 3.0, 3, 0.002
#: What it goes further is worth a word from this share of the travel.
_MATERIAL = 0.02
#: A recorded velocity has another unit if it goes with the other to this correlation, at a ratio
#: outside of these.
_ALIKE_WAYS, _UNIT = 0.9, (0.8, 1.25)
#: Intervals that are worked on at once.
_BLOCK = 1 << 16


class _Intervals(NamedTuple):
    """Some intervals between samples: the first of them, and what happens in each, (n,)."""

    first: int
    dt: Array
    dx: Array
    way: Array
    fastest: Array


def contradicted(recording: Recording) -> list[Fault]:
    """A recorded velocity that is not that of the position."""
    if recording.velocity is None or len(leaps(recording).at):
        return []
    new = new_samples(recording.position)
    every = slice(None) if new.all() else new
    t, x, v = (y[every] for y in (recording.t, recording.position, recording.velocity))
    if len(x) <= 4 * _ABOUT:
        return []
    if line := _other_unit(recording, t, x, v):
        return [line]
    beside = np.empty(len(x) - 1)
    for some in _intervals(t, x, v):
        np.abs(some.dx - some.way, out=beside[some.first : some.first + len(some.dx)])
    scatter = float(np.median(beside, overwrite_input=True))
    del beside
    tolerance = STEPS * step(recording.position) + SIGMAS * scatter
    tolerance += _MATERIAL * float(np.ptp(x))
    far = _further(t, x, v, tolerance, step(recording.velocity))
    if far.shape[1] < _OFTEN * len(x):
        return []
    places = far[0].astype(int)
    worst = int(np.argmax(far[1]))
    k, reach = int(places[worst]), float(far[2, worst])
    size = float(abs(x[k + 1] - x[k]))
    sentence = (
        f"position goes further than its recorded velocity takes it in {len(places)} samples, by "
        f"{shown_as(recording, 'position', size)} at {t[k]:.4g} s, where that velocity makes at "
        f"most {shown_as(recording, 'position', reach)}: rows are missing there or "
        "out of order, so differences of the position are no velocity"
    )
    own = np.flatnonzero(new)
    rows = mask(len(recording), np.append(own[places], own[places + 1]))
    return [Fault("jump", "position", rows, size, sentence)]


def _intervals(t: Array, x: Array, v: Array) -> Iterator[_Intervals]:
    """All intervals, a block at a time, with the greatest speed about each."""
    n = len(x)
    for k in range(0, n - 1, _BLOCK):
        stop = min(k + _BLOCK, n - 1)
        before, after = max(k - _ABOUT, 0), min(stop + _ABOUT + 1, n)
        edges = (_ABOUT - (k - before), _ABOUT + 1 - (after - stop))
        speed = np.pad(np.abs(v[before:after]), edges, mode="edge")
        fastest = sliding_window_view(speed, 2 * _ABOUT + 2).max(axis=1)
        dt, own = np.diff(t[k : stop + 1]), v[k : stop + 1]
        way = 0.5 * (own[1:] + own[:-1]) * dt
        yield _Intervals(k, dt, np.diff(x[k : stop + 1]), way, fastest)


def _further(t: Array, x: Array, v: Array, tolerance: float, resolved: float) -> Array:
    """Intervals in which the position goes further: number, how far off, reach, (3, far)."""
    pieces = []
    for some in _intervals(t, x, v):
        reach = (some.fastest + resolved) * some.dt
        off = np.abs(some.dx) - _FASTER * reach
        at = np.flatnonzero(off > tolerance)
        pieces.append(np.array([at + some.first, off[at], reach[at]]))
    return np.concatenate(pieces, axis=1)


def _other_unit(recording: Recording, t: Array, x: Array, v: Array) -> Fault | None:
    """A velocity in proportion to the position's, but not the same."""
    lag = 2 * _ABOUT
    count, sums, products = len(x) - lag, np.zeros(2), np.zeros((2, 2))
    for k in range(0, count, _BLOCK):
        at = slice(k, min(k + _BLOCK, count) + lag)
        own = v[at]
        mean = np.convolve(0.5 * (own[1:] + own[:-1]) * np.diff(t[at]), np.ones(lag), "valid")
        both = np.array([mean, x[at][lag:] - x[at][:-lag]])
        sums += both.sum(axis=1)
        products += np.einsum("im,jm->ij", both, both)
    centred = products - np.outer(sums, sums) / count
    if not np.diag(centred).min() > 0.0:
        return None
    ratio = float(products[0, 1] / products[1, 1])
    alike = float(centred[0, 1] / np.sqrt(centred[0, 0] * centred[1, 1]))
    if alike < _ALIKE_WAYS or _UNIT[0] < ratio < _UNIT[1]:
        return None
    sentence = (
        f"the recorded velocity is {ratio:.3g} times that of the position (they go together to "
        f"{alike:.0%}): check its unit, its sign, or the gear between them"
    )
    rows = np.ones(len(recording), dtype=bool)
    return Fault("contradiction", "velocity", rows, ratio, sentence, harmful=False)
