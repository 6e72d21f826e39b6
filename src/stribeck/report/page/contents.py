"""The account of a fit: everything that its page shows, gathered while the fit is at hand."""

from __future__ import annotations

import itertools
import platform
from importlib.metadata import version
from typing import TYPE_CHECKING

import numpy as np

from ..._version import __version__
from ...data.quality import check
from ...data.segmentation import segment
from ...errors import InputError
from ...identify.balance import balance
from ...identify.balance.balanced_fit import counting
from ...identify.card import card
from ...identify.score import simulated
from ...rig.balanced import as_balanced
from ...rig.rig import shown_in
from ...units import unit
from ..confidence_band import band
from ..curve_data import greatest_load, implied, loads, loop, own, reach, sides, stroke, under
from ..decimation import corners, rounded
from ..figures.style import force_unit, shown, written
from ..motion_traces import Traces, traces
from ..spectrum import autocorrelation, even, welch
from ..terminal import log_errors
from .schema import (
    LETTERS,
    LONGEST,
    MANY,
    MOTIONS,
    CurveRecord,
    DrawsRecord,
    ErrorRecord,
    LawRecord,
    LogRecord,
    MotionRecord,
    ProfileRecord,
    Report,
    RestRecord,
    RunRecord,
    SideRecord,
    SlipRecord,
    StrokeRecord,
    UnitsRecord,
)

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from ...data.recording import Recording
    from ...data.segmentation import Slip
    from ...identify.balance.balance import Signals
    from ...identify.result import Fit
    from ...space import Array

#: Logs shown at most, and motions of one range; of more, those with the greatest errors.
MOST = 24
#: Samples kept of all motions, of all logs, and of one of either; points of a cloud.
ROOM, LOGS, EACH, CLOUD = 30_000, 20_000, 6_000, 2_500
#: Bytes of a report at most: with less room it is tried again.
LARGEST = 3 << 20
#: Speeds of a curve each way, and points of a line of the law under load.
_SPEEDS, _LINE = 48, 60
#: Points of an autocorrelation, and the share of a signal over which it is looked at.
_LAGS, _SHARE = 400, 4
_DIGITS = 7


def account(fit: Fit, command: Sequence[str] = ()) -> Report:
    """Gather a fit.

    Args:
        fit: What was found.
        command: What was typed, word by word, to be repeated.

    Returns:
        Its report, of at most LARGEST bytes as a file as a rule: long lines are thinned until it
        is.

    Raises:
        InputError: the fit has no card.
    """
    share = 1.0
    made = _account(fit, command, share)
    while len(made.text()) > LARGEST and share > 0.1:  # noqa: PLR2004 - then it is no use
        share /= 2
        made = _account(fit, command, share)
    return made


def _account(fit: Fit, command: Sequence[str], share: float) -> Report:
    logs = fit.recordings
    kept = _kept(fit)
    room = max(min(EACH, LOGS // len(kept)), 100)
    rig = fit.rig
    several = len(logs) > 1
    motions, hidden = _motions(fit, share)
    return Report(
        card=card(fit),
        road="simulation" if fit.balance is None else "inverse",
        rotary=rig.rotary,
        applied=rig.applied_force,
        about=rig.doc,
        units=UnitsRecord(
            position=written(shown(rig, "position")),
            velocity=written(shown(rig, "velocity")),
            force=force_unit(rig),
        ),
        logs=[_log(fit, logs[k], int(share * room)) for k in kept],
        unshown=len(logs) - len(kept),
        motions=motions,
        hidden=hidden,
        law=_law(fit),
        profiles=list(_profiles(fit)),
        runs=list(_runs(fit)),
        errors=[
            ErrorRecord(log=log, samples=n, errors=[e if np.isfinite(e) else None for e in errors])
            for log, n, errors in (log_errors(fit) if several else [])[:MANY]
        ],
        draws=_draws(fit),
        command=[word[:LETTERS] for word in command[:MANY]],
        software={
            "stribeck": __version__,
            "Python": platform.python_version(),
            **{name: version(name) for name in ("numpy", "scipy", "numba")},
        },
    )


def _kept(fit: Fit) -> list[int]:
    """Which logs are shown: those with the greatest errors, in order."""
    if len(fit.recordings) <= MOST:
        return list(range(len(fit.recordings)))
    worst = [np.nanmax([*errors, -np.inf]) for _, _, errors in log_errors(fit)]
    return sorted(sorted(range(len(worst)), key=lambda k: -worst[k])[:MOST])


def _log(fit: Fit, log: Recording, most: int) -> LogRecord:
    length, speed = (unit(shown(fit.rig, q)).factor for q in ("position", "velocity"))
    seen, t, x = segment(log), log.t, log.position / length
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
            for s in seen.strokes[:MANY]
        ],
        rests=[
            RestRecord(start=float(t[r.start]), stop=float(t[r.stop - 1]), level=float(x[r].mean()))
            for r in seen.rests[:MANY]
        ],
        slips=[_slip(s, t, x, length, speed) for s in seen.slips[:MANY]],
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


def _motions(fit: Fit, share: float) -> tuple[list[MotionRecord], int]:
    """What was measured and modelled, in training and on each range held out; how many are not."""
    parts = list(_parts(fit) if fit.balance is None else _balances(fit))
    count = sum(min(len(seen), MOST) for _, seen in parts)
    most = int(share * max(min(EACH, ROOM // max(count, 1)), 100))
    made: list[MotionRecord] = []
    for part, seen in parts:
        worst = sorted(range(len(seen)), key=lambda k: -_size(seen[k][0]))[:MOST]
        made += [_motion(part, *seen[k], most) for k in sorted(worst)]
    return made[:MOTIONS], sum(len(seen) for _, seen in parts) - len(made[:MOTIONS])


def _size(r: Traces) -> float:
    return r.rms if r.scored.any() and np.isfinite(r.rms) else 0.0


def _parts(fit: Fit) -> Iterator[tuple[str, list[tuple[Traces, Array | None]]]]:
    motions = simulated(fit.parameters, fit.p, fit.train)
    yield "training", [(r, None) for r in traces(fit, fit.train, motions)]
    for held in fit.holdout:
        text = held.within.text if held.within else "all"
        yield text, [(r, None) for r in traces(fit, held.segments, held.motions)]


def _balances(fit: Fit) -> Iterator[tuple[str, list[tuple[Traces, Array | None]]]]:
    assert fit.balance is not None  # noqa: S101 - called for such fits only
    scale = unit(shown(fit.rig, "velocity")).factor

    def seen(log: Recording, b: Signals) -> tuple[Traces, Array]:
        every = np.ones(len(b.t), dtype=bool)
        return Traces(log.label, log, b.t, b.measured, b.predicted, every), b.velocity / scale

    yield (
        "training",
        [seen(log, b) for log, b in zip(fit.recordings, fit.balance.signals, strict=True)],
    )
    rig = as_balanced(fit.rig)
    for held in fit.holdout:
        if held.within is None:
            continue
        try:
            logs, rows = counting(fit.recordings, [held.within])
        except InputError:  # the range lies in logs that were not trained on
            continue
        found = balance.validate(logs, fit.law, rig, fit.p, rows=rows)
        yield held.within.text, [seen(log, b) for log, b in zip(logs, found.signals, strict=True)]


def _motion(part: str, r: Traces, velocity: Array | None, most: int) -> MotionRecord:
    lines = [r.measured, r.model, *(a for a in (r.command, r.force) if a is not None)]
    rows = corners(lines, most)

    def of(a: Array | None) -> list[float | None] | None:
        return None if a is None else rounded(a[rows])

    # What does not count is left out of the residual, the gaps between legs are not.
    kept = np.flatnonzero(r.scored | ~np.isfinite(r.t))
    t, left = r.t[kept], r.residual[kept]
    few = corners([left], most // 2)
    frequency, density, lag, correlation, counted = _pattern(t, left)
    return MotionRecord(
        label=r.label,
        part=part,
        rms=r.rms if r.scored.any() and np.isfinite(r.rms) else None,
        t=rounded(r.t[rows], _DIGITS),
        measured=rounded(r.measured[rows]),
        model=rounded(r.model[rows]),
        command=of(r.command),
        velocity=of(velocity),
        force=of(r.force),
        force_model=of(r.force_model),
        unscored=_unscored(r),
        residual_t=rounded(t[few], _DIGITS),
        residual=rounded(left[few], 5),
        frequency=rounded(frequency),
        density=[float(f"{d:.5g}") for d in density.tolist()],
        lag=rounded(lag),
        correlation=rounded(correlation, 4),
        counted=counted,
    )


def _unscored(r: Traces) -> list[tuple[float, float]]:
    """The stretches before, between and after those that count, longer than a few samples."""
    at = np.flatnonzero(r.scored)
    if not len(at):
        return []
    t = r.t
    seconds = float(np.nanmax(t) - np.nanmin(t))
    ends = [(0, int(at[0])), (int(at[-1]), len(t) - 1)]
    ends += [(int(a), int(b)) for a, b in itertools.pairwise(at) if b - a > 1]
    spans = [(float(t[a]), float(t[b])) for a, b in ends]
    return [(a, b) for a, b in sorted(spans) if b - a > 0.01 * seconds]  # nan never is


def _pattern(t: Array, left: Array) -> tuple[Array, Array, Array, Array, int]:
    """Density and autocorrelation of a residual; empty where it is too short."""
    none = np.zeros(0)
    if (found := even(t, left)) is None:
        return none, none, none, none, 0
    step, y = found
    frequency, density = welch(y, step)
    lags = min(len(y) // _SHARE, LONGEST)
    every = max(1, lags // _LAGS)
    correlation = autocorrelation(y)[:lags:every]
    lag = step * every * np.arange(float(len(correlation)))
    return frequency[1:], density[1:], lag, correlation, len(y)


def _law(fit: Fit) -> LawRecord:
    scale = unit(shown(fit.rig, "velocity")).factor
    fast, p = reach(fit), own(fit)
    cloud = implied(fit)
    low, high = -fast, fast
    if cloud is not None:
        low, high = min(float(cloud[0].min()), 0.0), max(float(cloud[0].max()), 0.0)
    seen = sides(low, high, _SPEEDS)
    found = band(fit, seen)
    curve = []
    for k, v in enumerate(seen):
        ends = (None, None) if found is None else tuple(rounded(F) for F in found[1][k])
        curve.append(
            SideRecord(
                velocity=rounded(v / scale, 8),
                friction=rounded(fit.law.friction(v, p)),
                low=ends[0],
                high=ends[1],
            )
        )
    every = 1 if cloud is None else -(-len(cloud[0]) // CLOUD)
    loaded = any(load in ("drive", "external", "normal") for load in fit.law.loads)
    pace, loops = _loops(fit) if fit.law.states else (None, [])
    return LawRecord(
        doc=fit.law.doc,
        cite=fit.law.cite,
        formula=fit.law.formula,
        curve=curve,
        band=None if found is None else found[0],
        cloud_velocity=[] if cloud is None else rounded(cloud[0][::every] / scale, 5),
        cloud_friction=[] if cloud is None else rounded(cloud[1][::every], 5),
        pace=pace,
        loops=loops,
        loads=_loads(fit, fast, scale) if loaded else [],
        load=_load(fit)[0] if loaded else "",
    )


def _loops(fit: Fit) -> tuple[float, list[CurveRecord]]:
    way, pace = stroke(fit)
    length, speed = (unit(shown(fit.rig, q)).factor for q in ("position", "velocity"))
    made = []
    for part, name in ((1.0, "to and fro"), (0.35, "a third as far")):
        x, F = loop(fit.law, own(fit), part * way, pace)
        made.append(CurveRecord(name=name, x=rounded(x / length), y=rounded(F)))
    return pace / speed, made


def _load(fit: Fit) -> tuple[str, float]:
    """What a law is loaded by, with its unit, and how large that is in SI."""
    if "normal" not in fit.law.loads:
        return f"{'Torque' if fit.rig.rotary else 'Force'} / {force_unit(fit.rig)}", 1.0
    if any(log.pressure is not None for log in fit.recordings):
        return "Pressure / bar", unit("bar").factor
    return "Normal load", 1.0


def _loads(fit: Fit, fast: float, scale: float) -> list[CurveRecord]:
    """Friction against load at rest and at the greatest speed, for each way of loading."""
    p = own(fit)
    across = np.linspace(0.0, greatest_load(fit), _LINE)
    moving = f"{fast / scale:.3g} {written(shown(fit.rig, 'velocity'))}"
    made: dict[str, tuple[str, Array]] = {}
    for name, way in loads(fit.law).items():
        for at, v in (("at rest", 0.0), (f"at {moving}", fast)):
            F = np.array([under(fit.law, p, v, way, x) for x in across])
            twin = next((n for n, (a, y) in made.items() if a == at and np.allclose(y, F)), None)
            if twin is None:
                made[f"{name}, {at}"] = (at, F)
            else:  # two lines on one another have one name
                other = twin.removesuffix(f", {at}").removesuffix(" alone")
                made[f"{other} or {name}, {at}"] = made.pop(twin)
    return [
        CurveRecord(name=name, x=rounded(across / _load(fit)[1]), y=rounded(F))
        for name, (_, F) in made.items()
    ]


def _profiles(fit: Fit) -> Iterator[ProfileRecord]:
    if fit.known is None:
        return
    seen = fit.known.by_name()
    ends = {q.name: e for q, e in zip(fit.parameters.every, fit.estimates, strict=True)}
    for q in fit.parameters.free:
        e, (profile, _) = ends[q.name], seen[q.name]

        def as_shown(x: float, q: object = q) -> float:
            return float(shown_in(fit.rig, q, x))  # type: ignore[arg-type]

        if not np.isfinite(e.value):
            continue
        good = np.isfinite(profile.values) & np.isfinite(profile.rises)
        yield ProfileRecord(
            name=e.name,
            unit=written(e.unit),
            value=as_shown(e.value),
            low=as_shown(e.low) if np.isfinite(e.low) else None,
            high=as_shown(e.high) if np.isfinite(e.high) else None,
            values=[as_shown(float(v)) for v in profile.values[good]],
            rises=[float(f"{z:.5g}") for z in profile.rises[good]],
        )


def _runs(fit: Fit) -> Iterator[RunRecord]:
    """The repeats, the best first; convergence by the places where the best cost fell."""
    done = fit.polished or (None,) * len(fit.runs)
    for run, polished in zip(fit.runs[:MANY], done, strict=False):
        x = run.x if polished is None else polished.x
        cost = run.cost if polished is None else polished.cost
        best = run.trace.convergence()
        fell = np.flatnonzero(np.diff(best, prepend=np.inf) < 0)[-LONGEST:]
        values = zip(fit.parameters.free, x, strict=False)
        yield RunRecord(
            searched=run.cost if np.isfinite(run.cost) else None,
            cost=cost if np.isfinite(cost) else None,
            evaluations=run.evaluations,
            polishing=0 if polished is None else polished.evaluations,
            ended=run.ended,
            seconds=run.seconds,
            parameters={fit.rig.label(q.name): float(shown_in(fit.rig, q, v)) for q, v in values},
            at=[int(k) + 1 for k in fell],
            best=[float(f"{f:.6g}") for f in best[fell]],
        )


def _draws(fit: Fit) -> DrawsRecord | None:
    drawn = fit.known.bootstrap if fit.known is not None else None
    if drawn is None:
        return None
    return DrawsRecord(
        drawn=len(drawn.draws) + drawn.failed, failed=drawn.failed, block=drawn.block
    )
