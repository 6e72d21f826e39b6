"""Rows of the force balance: logs filtered and decimated, and only the samples that count."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...data.derived_channel import Inner, SampledChannel, Slope, picked
from ...data.filtering import (
    DECIMATION_GAIN,
    Bridged,
    Filtering,
    Gaps,
    PositionError,
    SmoothMotion,
    decimated,
    even,
    kept,
    low_passed,
    position_error,
    smooth_motion,
    unsure_of_direction,
    velocity_error,
)
from ...data.motion_path import motion_path
from ...data.resolution import noise_of, step
from ...data.zero_phase import BLOCK, Samples, Signal
from ...errors import InputError
from ...friction.law import HARMONIC
from ...rig.balanced import BalancedRig, as_balanced
from ...rig.measured_path import MeasuredPath
from ...space import Array
from ...wording import option

if TYPE_CHECKING:
    from ...data.recording import Recording
    from ...data.steady_runs import SteadyRuns
    from ...friction import Law
    from ..parameters import Parameters

#: Samples of a log that count: a mask over them or a slice of them.
Rows = slice | NDArray[np.bool_]

#: Fewest rows of a log; the decimation filter needs three samples of each.
_LEAST = 10
#: A row is at rest below this share of the top speed; worth a note if more than that share are.
_REST_SPEED, _REST_SHARE = 0.005, 0.1


class FilteredMotion(NamedTuple):
    """Filtered motion at some samples: velocity, acceleration, (n,), and the loads, (n, 5)."""

    v: Array
    a: Array
    loads: Array


@dataclass(frozen=True, eq=False)
class Log:
    """A filtered log: its clock to its raw force at full rate, t and force at rows that count.

    What depends on its motion is worked out a block of samples at a time, and kept at the rows
    alone: a signal is a function of samples.

    `force` is without the known one, which is taken off at the instants of the motion. Rows of a
    table of steady speeds have a weight each, by which their force is multiplied. A law with states
    is driven along `path`.
    """

    clock: Array
    v: SampledChannel
    a: SampledChannel
    position: SampledChannel
    raw: Array
    factor: int
    unsure: NDArray[np.bool_]
    blur: int
    counts: NDArray[np.bool_]
    t: Array
    notes: tuple[str, ...]
    label: str
    figures: Mapping[str, float]
    loads: Callable[[Array, Array], Array]
    weight: Array | None = None
    known: Array | float = 0.0
    path: MeasuredPath | None = None

    def __len__(self) -> int:
        return len(self.clock)

    @cached_property
    def force(self) -> Array:
        """The measured force at the rows that count, without the known one."""
        return self.thin(lambda at: self.raw[at] - self.known_at(at))

    def known_at(self, at: Samples) -> Array | float:
        """The known force at some samples."""
        return self.known[at] if isinstance(self.known, np.ndarray) else self.known

    @property
    def row_clock(self) -> Array:
        """Time of each row, before some are left out."""
        return self.clock[kept(len(self.clock), self.factor)]

    @property
    def rate(self) -> float:
        """Samples a second."""
        return float(len(self.clock) - 1) / float(self.clock[-1] - self.clock[0])

    @property
    def row_rate(self) -> float:
        """Rows a second, before some are left out."""
        return self.rate / self.factor

    @cached_property
    def places(self) -> NDArray[np.intp]:
        """The samples of the rows that count."""
        rows = kept(len(self.clock), self.factor)
        return np.asarray(rows.start + self.factor * np.flatnonzero(self.counts))

    def motion(self, at: Samples) -> FilteredMotion:
        """The motion at some samples."""
        if self._is_short:
            v, a, loads = self._whole_motion
            return FilteredMotion(v[at], a[at], loads[at])
        loads = self.loads(self.clock[at], self.position[at])
        return FilteredMotion(self.v[at], self.a[at], loads)

    @property
    def _is_short(self) -> bool:
        """Whether all of it is no more than a block: then what is asked for in parts is kept."""
        return len(self) <= BLOCK

    @cached_property
    def _whole_motion(self) -> FilteredMotion:
        every = slice(0, len(self))
        return FilteredMotion(
            self.v[every], self.a[every], self.loads(self.clock[every], self.position[every])
        )

    @cached_property
    def _gaps(self) -> Gaps:
        return Gaps(self.unsure)

    def bridged(self, signal: Signal) -> Signal:
        """A signal with straight lines where the direction of motion is not known."""
        return Bridged(signal, self._gaps)

    def thin(self, signal: Signal) -> Array:
        """A signal at full rate bridged, decimated, and only the rows that count."""
        if self._is_short:
            whole = signal(slice(0, len(self)))

            def signal(at: Samples) -> Array:
                return whole[at]

        thinned: Array = decimated(self.bridged(signal), len(self), self.factor)[self.counts]
        return thinned if self.weight is None else (thinned.T * self.weight).T

    @property
    def gain(self) -> float | Array:
        """By what forces are smaller, or count more, than they were measured."""
        if self.weight is not None:
            return self.weight
        return 1.0 if self.factor == 1 else DECIMATION_GAIN

    def pick(self, x: SampledChannel) -> Array:
        """The samples of a full-rate channel at the rows, as they are."""
        return picked(x, self.places)


def filtered_logs(
    recordings: Recording | Sequence[Recording],
    parameters: Parameters,
    filtering: Filtering | None,
    rows: Sequence[Rows | None] | None,
) -> list[Log]:
    """Each recording filtered and decimated; see `balance` for the arguments.

    Raises:
        InputError: a law that the rig does not know the loads of, no recording, no measured force,
            or too few samples or rows.
    """
    logs = list(recordings) if isinstance(recordings, Sequence) else [recordings]
    if not logs:
        raise InputError("no recording was given")
    rig, law = as_balanced(parameters.rig), parameters.law
    rig.check_law(law)
    rows = [None] * len(logs) if rows is None else rows
    if len(rows) != len(logs):
        raise InputError(f"rows are given for {len(rows)} of {len(logs)} recordings")
    filtering = filtering or rig.filtering_of(law)
    filtered = [_log(r, law, rig, filtering, w) for r, w in zip(logs, rows, strict=True)]
    if sum(len(log.t) for log in filtered) < 2:  # noqa: PLR2004 - a spread needs two
        if all(log.unsure.all() for log in filtered):
            raise InputError(
                f"{logs[0].label}: the velocity is nowhere beyond its own error, so that no row "
                "shows which way the axis moves: record faster strokes or a finer position"
            )
        raise InputError(f"{logs[0].label}: {_too_short(logs, filtered[0], filtering, rows)}")
    return filtered


def _too_short(
    recordings: Sequence[Recording],
    log: Log,
    filtering: Filtering,
    rows: Sequence[Rows | None],
) -> str:
    """Why fewer than two rows count, and what gives more."""
    chosen = [(r, w) for r, w in zip(recordings, rows, strict=True) if w is not None]
    asked = f" of the {sum(len(r.t[w]) for r, w in chosen)} samples asked for" if chosen else ""
    first, last = (samples / log.rate for samples in filtering.edges(log.rate))
    return (
        f"fewer than 2 rows are left{asked}: a force balance takes one every "
        f"{1 / log.row_rate:.3g} s, but for the first {first:.3g} s and the last {last:.3g} s of a "
        "log and where the axis rests or turns round: "
        f"{'widen the range' if chosen else 'log more motion'}"
    )


def _log(
    recording: Recording, law: Law, rig: BalancedRig, filtering: Filtering, rows: Rows | None
) -> Log:
    if recording.runs is not None:
        return _run_rows(recording, recording.runs, law, rig, rows)
    log = even(recording, rig.measured(recording))
    first, last = filtering.edges(log.rate)
    factor = filtering.factor(log.rate)
    inner = slice(first, len(log.t) - last)
    if len(log.t[inner]) < _LEAST * max(factor, 3):
        raise InputError(
            f"{recording.label}: {len(log.t)} samples at {log.rate:.4g} Hz are too few to filter: "
            f"a force balance needs {first + last + _LEAST * max(factor, 3)} of them or more"
        )
    motion = smooth_motion(log.position, log.rate, filtering)
    source = recording.position
    if filtering.velocity == "recorded":
        if log.velocity is None or recording.velocity is None:
            raise InputError(f"{recording.label}: no velocity was recorded: map a column to it")
        recorded, source = low_passed(log.velocity, log.rate, filtering), recording.velocity
        slope = Slope(recorded, log.rate, filtering.differences(log.rate))
        motion = SmoothMotion(motion.position, recorded, slope)
    q, v, a = (Inner(channel, first, last) for channel in motion)
    chosen = np.zeros(len(recording), dtype=bool)
    chosen[slice(None) if rows is None else rows] = True
    thin = kept(len(v), factor)
    counts = log.counts(chosen, slice(first + thin.start, len(log.t) - last, factor))
    del chosen
    counts &= np.abs(v[thin]) >= filtering.slowest
    unsure = np.zeros(len(v), dtype=bool)
    if not filtering.reversals:
        error = velocity_error(noise_of(source), step(source), log.rate, filtering)
        unsure = unsure_of_direction(v, log.rate, filtering, error)
        counts &= ~unsure[thin]
    t = log.t[inner][thin][counts]
    path = None
    if law.states:
        x = recording.position
        off = position_error(noise_of(x), step(x), log.rate, filtering)
        seen = None if log.known is None else log.known[inner]
        path = measured_path(q[:], v[:], log.rate, off, seen)
    known = log.less[inner] if isinstance(log.less, np.ndarray) else log.less
    notes = log.notes
    if not law.states:
        notes += _rests(recording.label, np.abs(v[thin][counts]))
    return Log(
        log.t[inner],
        v,
        a,
        q,
        log.force[inner],
        factor,
        unsure,
        filtering.blur(log.rate),
        counts,
        t,
        notes,
        recording.label,
        rig.figures(recording),
        partial(rig.load_rows, law, recording),
        known=known,
        path=path,
    )


def measured_path(
    q: Array, v: Array, rate: float, error: PositionError, known: NDArray[np.bool_] | None
) -> MeasuredPath:
    """How a low-passed motion drives states.

    Args:
        q: Position, (N,).
        v: Velocity, (N,).
        rate: Samples a second.
        error: Of the position.
        known: False inside gaps of the log, (N,); None where there are none.
    """
    starts = np.zeros(1, dtype=np.int64)
    if known is not None:
        starts = np.concatenate([starts, np.flatnonzero(known[1:] & ~known[:-1]) + 1])
    path = motion_path(q, 2 * error.most, error.sd)
    way = np.diff(path, prepend=path[0])
    return MeasuredPath(way, v, 1.0 / rate, starts, error.most)


def _run_rows(
    recording: Recording, runs: SteadyRuns, law: Law, rig: BalancedRig, rows: Rows | None
) -> Log:
    """Runs at constant speed as the rows that they are: nothing is filtered or accelerates."""
    own = {q.name for q in rig.params}
    if own - {"M", "offset"} or set(HARMONIC) & set(law.terms) or recording.velocity is None:
        raise InputError(
            f"{recording.label}: is a table of steady speeds, which has no positions: rig "
            f"{rig.name} with law {law.name} needs a log of a motion"
        )
    n, force = len(recording), rig.measured(recording)
    counts = np.zeros(n, dtype=bool)
    counts[slice(None) if rows is None else rows] = True
    weight, none = runs.weights(n)[counts], np.zeros(n, dtype=bool)
    return Log(
        clock=recording.t,
        v=recording.velocity,
        a=np.zeros(n),
        position=recording.position,
        raw=force,
        factor=1,
        unsure=none,
        blur=0,
        counts=counts,
        t=recording.t[counts],
        notes=(),
        label=recording.label,
        figures=rig.figures(recording),
        loads=partial(rig.load_rows, law, recording),
        weight=weight,
    )


def _rests(label: str, speed: Array) -> tuple[str, ...]:
    share = float(np.mean(speed < _REST_SPEED * speed.max())) if len(speed) else 0.0
    if share <= _REST_SHARE:
        return ()
    sentence = f"{share:.0%} of the rows are at or near rest, where friction is not that of slip"
    return (f"{label}: {sentence}: leave them out with {option('train')}",)
