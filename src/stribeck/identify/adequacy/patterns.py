"""Patterns that a residual may follow: what a model leaves out, by its name and its columns."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ...space import Array
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
    def change(cls, rows: ResidualRows, kind: Kind, at: float) -> Pattern:
        """A change for good some time after the start of a log."""
        return cls("change", lambda: carrier(rows, kind) * (rows.since >= at), at)

    def finer(self, rows: ResidualRows, kind: Kind) -> list[Pattern]:
        """The same with the scales between its own and the next ones; itself if it has none."""
        if self.name != "change":
            return [self]
        before = rows.since < self.scale
        share = np.sum(rows.acceleration[before] ** 2) / np.sum(rows.acceleration**2)
        reach = (LATEST - EARLIEST) / (CHANGES - 1)
        ends = np.clip([share - reach, share + reach], EARLIEST, LATEST)
        times = _times_of_shares(rows, ends)
        nearby = np.linspace(times[0], times[-1], FINER)
        return [self, *(Pattern.change(rows, kind, at) for at in nearby.tolist())]


def _wave(rows: ResidualRows, kind: Kind, period: float) -> Array:
    turn = 2 * np.pi * rows.position / period
    columns = np.column_stack([np.cos(turn), np.sin(turn)])
    return np.asarray(columns * carrier(rows, kind)[:, None])


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
    energy = np.cumsum(rows.acceleration[order] ** 2)
    at = np.searchsorted(energy, shares * energy[-1])
    times: list[float] = np.unique(rows.since[order][np.minimum(at, len(order) - 1)]).tolist()
    return times


def carrier(rows: ResidualRows, kind: Kind) -> Array:
    """What a residual of a kind goes along, of the size 1, (rows,)."""
    if kind == "friction":
        return rows.direction
    if kind == "force":
        return np.ones(len(rows))
    size = float(np.sqrt(np.mean(rows.acceleration**2)))
    return rows.acceleration / (size or 1.0)


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
