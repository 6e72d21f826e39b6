"""Patterns that a residual may follow: what a model leaves out, by its name and its columns."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ...space import Array
from .bins import between, bin_of, probability
from .residual_rows import ResidualRows

Variable = Literal["speed", "position", "time", "acceleration"]
#: What is binned: a force as it is, as friction, with the sign of the velocity taken out, or as
#: that of an inertia, in proportion to the acceleration.
Kind = Literal["force", "friction", "inertia"]

#: Speeds at which a drop has fallen to 1 / e, and times of warming, as shares of the greatest.
DROPS, WARMINGS = (0.02, 0.05, 0.12, 0.3), (0.1, 0.3)
#: What an inertia does is seen where it accelerates: it may change where so many shares of the
#: squared accelerations lie before, from one share to another; and, closer, at so many times.
CHANGES, EARLIEST, LATEST, FINER = 18, 0.15, 0.85, 24
#: Waves over the travel: steps of this many, up to so many, of at least so many rows each.
WAVE_STEP, MOST_WAVES, WAVE_ROWS = 0.5, 60.0, 4.0
#: Share of the rows each way from which on a difference of the directions can be asked for; with
#: fewer it is a pattern of the few strokes that go the other way.
EACH_WAY = 0.02
#: Rows of which waves are taken at most.
WAVE_SAMPLES = 6000
#: Share of a residual that a tone makes up, and of a tone that the motion makes up, if it is none
#: of its own; periods of it in each log, steps of a period between two that are looked at, and
#: rows of trials of chance that are worked on at once.
TONE, PERIODS, TONE_STEP, TRIALS = 0.5, 4.0, 0.25, 64
#: Share of a motion that a tone makes up from which on it is the motion's.
OF_MOTION = 0.1
#: A log that lasts so many times as long as its rows has gaps that no spectrum is worth.
SPARSE = 16.0


@dataclass(frozen=True, eq=False)
class Pattern:
    """A pattern of a residual over a variable.

    Args:
        name: What it is called.
        make: Makes its columns.
        scale: A period, a speed or a time that shapes it, SI; nan where none does.
    """

    name: str
    make: Callable[[], Array]
    scale: float = float("nan")

    @property
    def columns(self) -> Array:
        """Forces of size 1, (rows, k): made anew, since dozens of patterns of long logs are many.

        Those of `patterns` have one column.
        """
        columns = self.make()
        return columns if columns.ndim > 1 else columns[:, None]

    @classmethod
    def wave(cls, rows: ResidualRows, kind: Kind, period: float) -> Pattern:
        """A wave over the position, its two phases."""
        return cls("wave", partial(_wave, rows, kind, period), period)

    @classmethod
    def tone(cls, rows: ResidualRows, period: float) -> Pattern:
        """A wave over time, its two phases in each log."""
        return cls("tone", partial(_tone, rows, period), period)

    @classmethod
    def change(cls, rows: ResidualRows, kind: Kind, at: float) -> Pattern:
        """A change for good some time after the start of a log."""
        return cls("change", lambda: carrier(rows, kind) * (rows.since >= at), at)

    def finer(self, rows: ResidualRows, kind: Kind) -> list[Pattern]:
        """The same with the scales between its own and the next ones; itself if it has none."""
        if self.name == "tone":
            off = np.linspace(-1.0, 1.0, FINER) / float(rows.since.max())
            return [self, *(Pattern.tone(rows, 1.0 / (1.0 / self.scale + f)) for f in off.tolist())]
        if self.name != "change":
            return [self]
        before = rows.since < self.scale
        share = np.sum(rows.inertial[before] ** 2) / np.sum(rows.inertial**2)
        reach = (LATEST - EARLIEST) / (CHANGES - 1)
        ends = np.clip([share - reach, share + reach], EARLIEST, LATEST)
        times = _times_of_shares(rows, ends)
        nearby = np.linspace(times[0], times[-1], FINER)
        return [self, *(Pattern.change(rows, kind, at) for at in nearby.tolist())]


def _wave(rows: ResidualRows, kind: Kind, period: float) -> Array:
    turn = 2 * np.pi * rows.position / period
    columns = np.column_stack([np.cos(turn), np.sin(turn)])
    return np.asarray(columns * carrier(rows, kind)[:, None])


def _tone(rows: ResidualRows, period: float) -> Array:
    turn = 2 * np.pi * rows.since / period
    _, which = np.unique(rows.log, return_inverse=True)
    own = which[:, None] == np.arange(which.max() + 1)
    return np.column_stack([np.cos(turn)[:, None] * own, np.sin(turn)[:, None] * own])


def patterns(rows: ResidualRows, variable: Variable, kind: Kind) -> Iterator[Pattern]:
    """The patterns of one column that are known of a variable.

    Args:
        rows: The rows.
        variable: Which.
        kind: As a force, or as friction.
    """
    v, t = rows.velocity, rows.since
    if variable == "speed":
        top = float(np.abs(v).max())
        yield Pattern("square", lambda: v * np.abs(v))
        if min(np.mean(v > 0), np.mean(v < 0)) > EACH_WAY:
            yield Pattern("side", lambda: np.abs(v))
        for share in DROPS:
            yield Pattern("drop", partial(_drop, rows, share * top), share * top)
    elif variable == "position":
        middle = 0.5 * (rows.position.min() + rows.position.max())
        yield Pattern("slope", lambda: carrier(rows, kind) * (rows.position - middle))
    elif variable == "time":
        yield Pattern("drift", lambda: carrier(rows, kind) * t)
        for share in WARMINGS:
            yield Pattern("drift", partial(_warming, rows, kind, share * float(t.max())))
        if kind == "inertia":
            shares = np.linspace(EARLIEST, LATEST, CHANGES)
            for at in _times_of_shares(rows, shares):
                yield Pattern.change(rows, kind, at)
    else:
        yield Pattern("load", lambda: np.abs(rows.acceleration))


def _drop(rows: ResidualRows, speed: float) -> Array:
    return np.asarray(rows.direction * np.exp(-np.abs(rows.velocity) / speed))


def _warming(rows: ResidualRows, kind: Kind, seconds: float) -> Array:
    return np.asarray(carrier(rows, kind) * np.exp(-rows.since / seconds))


def _times_of_shares(rows: ResidualRows, shares: Array) -> list[float]:
    """Times since the start of a log before which shares of the squared accelerations lie."""
    order = np.argsort(rows.since, kind="stable")
    energy = np.cumsum(rows.inertial[order] ** 2)
    at = np.searchsorted(energy, shares * energy[-1])
    times: list[float] = np.unique(rows.since[order][np.minimum(at, len(order) - 1)]).tolist()
    return times


def carrier(rows: ResidualRows, kind: Kind) -> Array:
    """What a residual of a kind goes along, of the size 1, (rows,)."""
    if kind == "friction":
        return rows.direction
    if kind == "force":
        return np.ones(len(rows))
    size = float(np.sqrt(np.mean(rows.inertial**2)))
    return rows.inertial / (size or 1.0)


def wave_shares(
    rows: ResidualRows, kind: Kind, blocks: NDArray[np.intp], flips: Array
) -> tuple[Array, Array, Array]:
    """Periods of waves over the position, the share of the residual that each explains, (periods,).

    And what the strongest of them explains in trials of chance, (FLIPS,).
    """
    every = -(-len(rows) // WAVE_SAMPLES)
    x, r = rows.position[::every], rows.residual[::every] * carrier(rows, kind)[::every]
    travel, spacing = float(np.ptp(x)), float(np.median(np.abs(np.diff(x))))
    if not (travel > 0 and spacing > 0):
        return np.empty((0,)), np.empty(0), np.empty(0)
    waves = np.arange(1.0, min(MOST_WAVES, travel / (WAVE_ROWS * spacing)), WAVE_STEP)
    if not len(waves):
        return np.empty(0), np.empty(0), np.empty(0)
    turn = np.outer(x - x[0], 2 * np.pi * waves / travel)
    terms = np.concatenate([np.cos(turn), np.sin(turn)], axis=1) * r[:, None]
    block = blocks[::every]
    starts = np.flatnonzero(np.diff(block, prepend=-1))
    cells = np.zeros((flips.shape[1], 2 * len(waves)))
    cells[block[starts]] = np.add.reduceat(terms, starts, axis=0)
    total = 0.5 * float(r @ r) * len(r)

    def strength(sums: Array) -> Array:
        squares = sums**2 / total
        return squares[..., : len(waves)] + squares[..., len(waves) :]

    chance = strength(np.einsum("fb,bm->fm", flips, cells)).max(axis=1)
    return travel / waves, strength(cells.sum(axis=0)), chance


def tone(
    rows: ResidualRows, blocks: NDArray[np.intp], flips: Array
) -> tuple[Pattern, float] | None:
    """A tone that makes up most of a residual, with the probability that chance does.

    What pulls beside the axis has a rhythm of its own: a tone that goes with the axis's position
    and speed is none.
    """
    every = -(-len(rows) // WAVE_SAMPLES)
    r, t, block = rows.residual[::every], rows.since[::every], blocks[::every]
    _, log, count = np.unique(rows.log[::every], return_inverse=True, return_counts=True)
    step = np.diff(t)[np.diff(log) == 0]
    shortest = min(float(np.ptp(t[log == k])) for k in range(len(count)))
    if not (len(step) and np.median(step) > 0 and shortest > 0):
        return None
    interval = float(np.median(step))
    if t.max() > SPARSE * len(t) * interval:
        return None
    at = np.rint(t / interval).astype(np.intp)
    length = 1 << int(np.ceil(np.log2((at.max() + 1) / TONE_STEP)))
    waves = np.arange(length // 2 + 1)
    sought = (waves >= PERIODS * length * interval / shortest) & (waves <= length / WAVE_ROWS)
    if not sought.any():
        return None
    weight = np.sqrt(2.0 / (count * (r @ r)))

    def spectrum(chosen: NDArray[np.bool_], k: int) -> NDArray[np.complex128]:
        """Of some rows of a log, (waves,): its squares are shares of the residual."""
        values = np.bincount(at[chosen], weight[k] * r[chosen])
        shown: NDArray[np.complex128] = np.fft.rfft(values, length)[sought]
        return shown

    shares = sum(np.abs(spectrum(log == k, k)) ** 2 for k in range(len(count)))
    best = int(np.argmax(shares))
    share = float(np.asarray(shares)[best])
    if share < TONE:
        return None
    pattern = Pattern.tone(rows, length * interval / float(waves[sought][best]))
    if _is_of_motion(rows, pattern.columns):
        return None
    trials = np.zeros(len(flips))
    of_log = [np.unique(block[log == k]) for k in range(len(count))]
    cells = [
        np.stack([spectrum((block == b) & (log == k), k) for b in own])
        for k, own in enumerate(of_log)
    ]
    for k in range(0, len(flips), TRIALS):
        some = flips[k : k + TRIALS]
        strength = sum(np.abs(some[:, b] @ c) ** 2 for b, c in zip(of_log, cells, strict=True))
        trials[k : k + TRIALS] = np.asarray(strength).max(axis=1)
    return pattern, probability(share, trials)


def _is_of_motion(rows: ResidualRows, columns: Array) -> bool:
    """Whether a motion has the rhythm of some columns.

    Where the axis is, or how fast, makes up most of what they are; or they make up a good part of
    what it does.
    """
    places = 2 * bin_of(rows.position) + (rows.velocity > 0)
    speeds = 2 * bin_of(rows.velocity) + (rows.acceleration > 0)
    for which in (places, speeds):
        means = np.column_stack([between(column, which) for column in columns.T])
        if np.sum(means**2) > TONE * np.sum(columns**2):
            return True
    lengths = np.sqrt(np.sum(columns**2, axis=0))
    for channel in (rows.velocity, rows.acceleration):
        inner = np.einsum("ij,i->j", columns, channel) / lengths
        if inner @ inner > OF_MOTION * (channel @ channel):
            return True
    return False
