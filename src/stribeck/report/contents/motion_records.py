"""Logs and motions as a report has them: thinned lines, segments, spectra of residuals."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from ...data.quality import check
from ...data.segmentation import segment
from ...errors import InputError
from ...identify.balance import balance
from ...identify.balance.training_rows import counting
from ...identify.score import simulated
from ...rig.balanced import as_balanced
from ...units import unit
from .decimation import PAGE, Detail, corners, rounded
from .motion_traces import MotionTraces, balance_traces, motion_traces
from .schema import LONGEST, MANY, LogRecord, MotionRecord, RestRecord, SlipRecord, StrokeRecord
from .spectrum import autocorrelation, longest_even, power_density

if TYPE_CHECKING:
    from collections.abc import Iterator

    from ...data.recording import Recording
    from ...data.segmentation import Slip
    from ...identify.result import Fit
    from ...space import Array

#: Points of an autocorrelation, and the share of a signal over which it is computed.
_LAGS, _SHARE = 400, 4
#: Digits of times, of the span that they cover.
_DIGITS = 7
_QUANTITIES: tuple[Literal["position"], Literal["velocity"]] = ("position", "velocity")


def simulated_traces(fit: Fit) -> Iterator[tuple[str, list[MotionTraces]]]:
    """The simulated motions, of the training data and of each range held out."""
    yield "training", motion_traces(fit, fit.train, simulated(fit.parameters, fit.p, fit.train))
    for held_out in fit.holdout:
        name = held_out.within.text if held_out.within else "all"
        yield name, motion_traces(fit, held_out.segments, held_out.motions)


def balanced_traces(fit: Fit) -> Iterator[tuple[str, list[MotionTraces]]]:
    """The force balance of each log, of the training data and of each range held out."""
    assert fit.balance is not None  # noqa: S101 - called for such fits only
    rig = as_balanced(fit.rig)
    both = zip(fit.recordings, fit.balance.signals, strict=True)
    yield "training", [balance_traces(rig, log, b) for log, b in both]
    for held_out in fit.holdout:
        if held_out.within is None:
            continue
        try:
            logs, rows = counting(fit.recordings, [held_out.within])
        except InputError:  # the range lies in logs that were not trained on
            continue
        validated = balance.validate(logs, fit.parameters, fit.p, rows=rows)
        both = zip(logs, validated.signals, strict=True)
        yield held_out.within.text, [balance_traces(rig, log, b) for log, b in both]


def log_record(fit: Fit, log: Recording, most: int) -> LogRecord:
    """A log as it was measured, by at most so many samples."""
    if log.runs is not None:
        return LogRecord(
            label=log.label, lines=check(log).lines(), t=[], position=[], command=None, strokes=[],
            rests=[], slips=[],
        )  # fmt: skip
    length, speed = (unit(fit.rig.unit_shown(q)).factor for q in _QUANTITIES)
    segments, t, x = segment(log), log.t, log.position / length
    rows = corners([x], most)
    floating = log.command is None
    return LogRecord(
        label=log.label,
        lines=check(log).lines(),
        t=rounded(t[rows], _DIGITS),
        position=rounded(x[rows]),
        command=None if floating else rounded(np.asarray(log.command)[rows] / length),
        strokes=[
            StrokeRecord(
                start=float(t[s.rows.start]),
                stop=float(t[s.rows.stop - 1]),
                direction=1 if s.direction > 0 else -1,
                travel=s.travel / length,
                speed=s.speed / speed,
            )
            for s in segments.strokes[:MANY]
        ],
        rests=[
            RestRecord(start=float(t[r.start]), stop=float(t[r.stop - 1]), level=float(x[r].mean()))
            for r in segments.rests[:MANY]
        ],
        slips=[_slip(s, t, x, length, speed) for s in segments.slips[:MANY]],
    )


def _slip(s: Slip, t: Array, x: Array, length: float, speed: float) -> SlipRecord:
    return SlipRecord(
        start=float(t[s.start]),
        stop=float(t[s.stop]),
        begin=float(x[s.start]),
        end=float(x[s.stop]),
        jump=s.jump / length,
        speed=s.peak_speed / speed,
    )


def motion_lines(r: MotionTraces, most: int, detail: Detail) -> dict[str, Any]:
    """The fields of a record that are lines over time, of at most so many samples."""
    rows = corners([r.measured, r.model, *(a for a in (r.command, r.force) if a is not None)], most)

    def series(a: Array | None) -> list[float | None] | None:
        return None if a is None else detail.series(a[rows])

    t, residual = _residual(r)
    few = corners([residual], most // 2)
    return {
        "rms": r.rms if np.isfinite(r.rms) else None,
        "t": detail.series(r.t[rows], _DIGITS),
        "measured": series(r.measured),
        "model": series(r.model),
        "command": series(r.command),
        "velocity": series(r.velocity),
        "force": series(r.force),
        "force_model": series(r.force_model),
        "unscored": _unscored(r),
        "residual_t": detail.series(t[few], _DIGITS),
        "residual": detail.series(residual[few], 5),
    }


def _residual(r: MotionTraces) -> tuple[Array, Array]:
    """Times and residual of what counts, and the gaps between legs."""
    rows = np.flatnonzero(r.scored | ~np.isfinite(r.t))
    return r.t[rows], r.residual[rows]


def motion_record(part: str, r: MotionTraces, most: int) -> MotionRecord:
    """A motion with its residual's spectra, by at most so many samples."""
    frequency, density, lag, correlation, counted = _pattern(*_residual(r))
    return MotionRecord(
        label=r.label,
        part=part,
        **motion_lines(r, most, PAGE),
        frequency=rounded(frequency),
        density=[float(f"{d:.5g}") for d in density.tolist()],
        lag=rounded(lag),
        correlation=rounded(correlation, 4),
        counted=counted,
    )


def _unscored(r: MotionTraces) -> list[tuple[float, float]]:
    """The times before, between and after what counts, longer than a few samples."""
    counts = np.flatnonzero(r.scored)
    if not len(counts):
        return []
    t = r.t
    seconds = float(np.nanmax(t) - np.nanmin(t))
    ends = [(0, int(counts[0])), (int(counts[-1]), len(t) - 1)]
    ends += [(int(a), int(b)) for a, b in itertools.pairwise(counts) if b - a > 1]
    spans = [(float(t[a]), float(t[b])) for a, b in ends]
    return [(a, b) for a, b in sorted(spans) if b - a > 0.01 * seconds]  # nan never is


def _pattern(t: Array, residual: Array) -> tuple[Array, Array, Array, Array, int]:
    """Density and autocorrelation of a residual; empty where it is too short."""
    none = np.zeros(0)
    if (even := longest_even(t, residual)) is None:
        return none, none, none, none, 0
    step, y = even
    frequency, density = power_density(y, step)
    lags = min(len(y) // _SHARE, LONGEST)
    every = max(1, lags // _LAGS)
    correlation = autocorrelation(y)[:lags:every]
    lag = step * every * np.arange(float(len(correlation)))
    return frequency[1:], density[1:], lag, correlation, len(y)
