"""A stroke made ready to be simulated and compared with what was measured."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...errors import InputError
from ...space import Array, contiguous

if TYPE_CHECKING:
    from collections.abc import Sequence

    from .command import Drive

#: Knots of a command whose least and greatest are kept together.
RUN = 64


class SideReading(NamedTuple):
    """What is measured of an axis whose motor and load move apart.

    Args:
        by_motor: Whether it is the motor's position, not the load's.
        ahead: By how much the motor is ahead of the load at the start, m or rad; nan if unknown.
        zero: By how much the motor's position is read higher than it is.
        aligned: Whether zeros are not known, so that the measured mean is the simulated one.
        weight: Of its residuals, beside those of the load's position.
    """

    by_motor: bool = False
    ahead: float = np.nan
    zero: float = 0.0
    aligned: bool = False
    weight: float = 1.0


class Track(NamedTuple):
    """One stroke to simulate: its command, its samples, and what was measured there.

    Args:
        knots_t: Command knots, s.
        knots_x: Command at the knots, m.
        t: Sample times, s; the motion starts at rest at `t[0]`.
        x0: Position at the start, m.
        measured: Measured position at the samples, m.
        score: 1.0 for a sample that counts in the misfit, 0.0 for one that does not.
        sums: Prefix sums of score * (1, d, d^2) with d = measured - x0, shape (3, N + 1).
        extremes: Least and greatest command from each RUN-th knot to the next, m, (2, K / RUN);
            may be left out.
        v0: Velocity at the start, m/s.
        inputs: What else drives the axis at the samples, (m, N), for rigs that step through them.
        held: Which of the inputs keep a value until the next sample, (m,); the others are linear
            between samples.
        given: What the log says of its axis, SI, in the order in which its rig reads it.
        stretch: Command less position as the controller read it, held until it did again, at the
            samples, m, (N,); empty where it goes by the position itself.
        reading: What is measured, where an axis has two masses.
    """

    knots_t: Array
    knots_x: Array
    t: Array
    x0: float
    measured: Array
    score: Array
    sums: Array
    extremes: Array = np.empty((2, 0))
    v0: float = 0.0
    inputs: Array = np.empty((0, 0))
    held: Array = np.empty(0)
    given: Array = np.empty(0)
    stretch: Array = np.empty(0)
    reading: SideReading = SideReading()

    def of_samples(self, rows: slice | NDArray[np.intp], score: Array | None = None) -> Track:
        """The same motion at some of the samples, with a score of their own if there is one."""
        score, measured = self.score[rows] if score is None else score, self.measured[rows]
        return self._replace(
            t=self.t[rows],
            measured=measured,
            score=score,
            sums=prefix_sums(score, measured - self.x0),
            inputs=np.ascontiguousarray(self.inputs[:, rows]),
            stretch=self.stretch[rows] if len(self.stretch) else self.stretch,
        )

    def begun_at(self, x0: float, v0: float) -> Track:
        """The same samples of a motion that starts at another position, m, and velocity, m/s."""
        return self._replace(x0=x0, v0=v0, sums=prefix_sums(self.score, self.measured - x0))


def track(
    drive: Drive, t: Array, x0: float, measured: Array | None = None, score: Array | None = None
) -> Track:
    """Prepare a stroke: contiguous arrays and prefix sums.

    Raises:
        InputError: no samples or no command, times or positions that are not finite numbers, or
            not one value for each time.
    """
    t, knots_t, x = contiguous(t), contiguous(drive.t), contiguous(drive.x)
    measured = np.zeros(len(t)) if measured is None else contiguous(measured)
    score = np.ones(len(t)) if score is None else contiguous(score)
    for name, times, values in (
        ("measured", t, measured), ("score", t, score), ("command", knots_t, x),
    ):  # fmt: skip
        if not (times.ndim == 1 and times.size and values.shape == times.shape):
            raise InputError(
                f"a track needs one {name} value for each of its times: got {values.shape} for "
                f"{times.shape}"
            )
        if not (np.isfinite(times).all() and np.isfinite(values).all()):
            raise InputError(f"a track's {name} and its times must be finite numbers")
    if not np.isfinite(x0):
        raise InputError(f"a track starts at a finite position, got {x0}")
    sums = prefix_sums(score, measured - x0)
    return Track(knots_t, x, t, float(x0), measured, score, sums, extremes(x))


class JoinedTracks(NamedTuple):
    """The samples of several tracks, one track after the other, as compiled code takes them.

    Args:
        t: Times since the start of each, s, (N,).
        first: The first sample of each, and how many there are, (tracks + 1,).
        inputs: Of all, (m, N).
        held: Which of them keep a value until the next sample, 1 for these, (m,).
        start: Position and velocity of each of n candidates at the start of each track; the
            candidates of the first track, then those of the next, (tracks n, 2).
    """

    t: Array
    first: NDArray[np.int64]
    inputs: Array
    held: NDArray[np.int64]
    start: Array


def joined_tracks(tracks: Sequence[Track], n: int) -> JoinedTracks:
    """Tracks to be moved along by n candidates each."""
    return JoinedTracks(
        np.concatenate([track.t - track.t[0] for track in tracks]),
        np.concatenate([[0], np.cumsum([len(track.t) for track in tracks])]),
        contiguous(np.concatenate([track.inputs for track in tracks], axis=1)),
        tracks[0].held.astype(np.int64),
        contiguous(np.repeat([[track.x0, track.v0] for track in tracks], n, axis=0)),
    )


def prefix_sums(score: Array, d: Array) -> Array:
    """Prefix sums of score * (1, d, d^2), (3, N + 1)."""
    sums = np.zeros((3, len(d) + 1))
    np.cumsum(np.stack([score, score * d, score * d * d]), axis=1, out=sums[:, 1:])
    return sums


def extremes(x: Array) -> Array:
    """Least and greatest of a command from each RUN-th knot to the next, both with it; (2, R)."""
    inner = (len(x) - 1) // RUN
    runs = x[: inner * RUN].reshape(inner, RUN)
    ends = x[RUN::RUN][:inner]
    return np.stack([np.minimum(runs.min(axis=1), ends), np.maximum(runs.max(axis=1), ends)])
