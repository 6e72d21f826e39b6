"""Rows of the force balance: logs filtered and decimated, and only the samples that count."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ...data.filtering import (
    DECIMATION_GAIN,
    Filtering,
    bridged,
    decimate,
    difference,
    even,
    kept,
    low_passed,
    smooth,
    unsure_of_direction,
    velocity_error,
)
from ...data.resolution import noise_of, step
from ...errors import InputError
from ...rig.balanced import BalancedRig, as_balanced
from ...space import Array

if TYPE_CHECKING:
    from ...data.recording import Recording
    from ...data.steady_runs import SteadyRuns
    from ...friction import Law
    from ..parameters import Parameters

#: Terms of a law that go with the position.
POSITION_LAWS = frozenset({"position", "cogging"})
#: Samples of a log that count: a mask over them or a slice of them.
Rows = slice | NDArray[np.bool_]

#: Fewest rows of a log; the decimation filter needs three samples of each.
_LEAST = 10
#: A row is at rest below this share of the top speed; worth a note if more than that share are.
_REST_SPEED, _REST_SHARE = 0.005, 0.1


@dataclass(frozen=True, eq=False)
class Log:
    """A filtered log: its clock to its raw force at full rate, t and force at rows that count.

    `force` is without the known one, which is taken off at the instants of the motion. Rows of a
    table of steady speeds have a weight each, by which their force is multiplied.
    """

    clock: Array
    v: Array
    a: Array
    loads: Array
    raw: Array
    factor: int
    unsure: NDArray[np.bool_]
    blur: int
    counts: NDArray[np.bool_]
    t: Array
    force: Array
    notes: tuple[str, ...]
    label: str
    figures: Mapping[str, float]
    weight: Array | None = None
    known: Array | float = 0.0

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

    def thin(self, x: Array) -> Array:
        """Full-rate columns (N, ...) bridged, decimated, and only the rows that count."""
        thinned: Array = decimate(bridged(x, self.unsure), self.factor)[self.counts]
        return thinned if self.weight is None else (thinned.T * self.weight).T

    def net(self, lag: float) -> Array:
        """The force that was measured `lag` seconds later than the motion, less the known one."""
        return np.asarray(np.interp(self.clock + lag, self.clock, self.raw) - self.known)

    @property
    def gain(self) -> float | Array:
        """By what forces are smaller, or count more, than they were measured."""
        if self.weight is not None:
            return self.weight
        return 1.0 if self.factor == 1 else DECIMATION_GAIN

    def pick(self, x: Array) -> Array:
        """The samples of a full-rate signal at the rows, as they are."""
        picked: Array = x[kept(len(x), self.factor)][self.counts]
        return picked


def filtered_logs(
    recordings: Recording | Sequence[Recording],
    parameters: Parameters,
    filtering: Filtering | None,
    rows: Sequence[Rows | None] | None,
) -> list[Log]:
    """Each recording filtered and decimated; see `balance` for the arguments.

    Raises:
        InputError: a law that a force balance cannot follow, no recording, no measured force, or
            too few samples or rows.
    """
    logs = list(recordings) if isinstance(recordings, Sequence) else [recordings]
    if not logs:
        raise InputError("no recording was given")
    rig, law = as_balanced(parameters.rig), parameters.law
    rig.check_law(law)
    rows = [None] * len(logs) if rows is None else rows
    if len(rows) != len(logs):
        raise InputError(f"rows are given for {len(rows)} of {len(logs)} recordings")
    filtering = filtering or rig.filtering
    filtered = [_log(r, law, rig, filtering, w) for r, w in zip(logs, rows, strict=True)]
    if sum(len(log.t) for log in filtered) < 2:  # noqa: PLR2004 - a spread needs two
        if all(log.unsure.all() for log in filtered):
            raise InputError(
                f"{logs[0].label}: the velocity is nowhere beyond its own error, so that no row "
                "shows which way the axis moves: record faster strokes or a finer position"
            )
        raise InputError(f"{logs[0].label}: no rows are left: widen the range or drop less")
    return filtered


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
            "the force balance needs a longer log"
        )
    q, v, a = smooth(log.position, log.rate, filtering)
    source = recording.position
    if filtering.velocity == "recorded":
        if log.velocity is None or recording.velocity is None:
            raise InputError(f"{recording.label}: no velocity was recorded: map a column to it")
        v, source = low_passed(log.velocity, log.rate, filtering), recording.velocity
        a = difference(v, log.rate)
    q, v, a = q[inner], v[inner], a[inner]
    loads = rig.load_rows(law, recording, log.t[inner], q)
    chosen = np.zeros(len(recording), dtype=bool)
    chosen[slice(None) if rows is None else rows] = True
    thin = kept(len(v), factor)
    counts = (chosen[log.nearest] & log.known)[inner][thin]
    counts &= np.abs(v[thin]) >= filtering.slowest
    unsure = np.zeros(len(v), dtype=bool)
    if not filtering.reversals:
        error = velocity_error(noise_of(source), step(source), log.rate, filtering)
        unsure = unsure_of_direction(v, log.rate, filtering, error)
        counts &= ~unsure[thin]
    t = log.t[inner][thin][counts]
    known = log.less[inner] if isinstance(log.less, np.ndarray) else log.less
    force = decimate(bridged(log.force[inner] - known, unsure), factor)[counts]
    notes = log.notes + _rests(recording.label, np.abs(v[thin][counts]))
    return Log(
        log.t[inner],
        v,
        a,
        loads,
        log.force[inner],
        factor,
        unsure,
        filtering.blur(log.rate),
        counts,
        t,
        force,
        notes,
        recording.label,
        rig.figures(recording),
        known=known,
    )


def _run_rows(
    recording: Recording, runs: SteadyRuns, law: Law, rig: BalancedRig, rows: Rows | None
) -> Log:
    """Runs at constant speed as the rows that they are: nothing is filtered or accelerates."""
    own = {q.name for q in rig.params}
    if own - {"M", "offset"} or POSITION_LAWS & set(law.terms) or recording.velocity is None:
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
        loads=rig.load_rows(law, recording, recording.t, recording.position),
        raw=force,
        factor=1,
        unsure=none,
        blur=0,
        counts=counts,
        t=recording.t[counts],
        force=force[counts] * weight,
        notes=(),
        label=recording.label,
        figures=rig.figures(recording),
        weight=weight,
    )


def _rests(label: str, speed: Array) -> tuple[str, ...]:
    share = float(np.mean(speed < _REST_SPEED * speed.max())) if len(speed) else 0.0
    if share <= _REST_SHARE:
        return ()
    sentence = f"{share:.0%} of the rows are at or near rest, where friction is not that of slip"
    return (f"{label}: {sentence}: leave them out with --train",)
