"""What is in a log, and what it is good enough for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from ..presenters import presenter
from ..space import Array
from .breakaway import Breakaway, Presliding, presliding, ramps
from .channels import CHANNELS
from .gate import faults, mended
from .gate.fault import shown
from .log_list import Columns, Log, recording_of
from .resolution import step
from .segmentation import Segments, Slip, Stroke, segment
from .verdicts import ForceTests, likely_rig, verdicts

if TYPE_CHECKING:
    from .recording import Recording

#: An interval so many times the median one is a gap.
GAP = 3.0
#: Share of a slip that a recorded velocity makes at least where positions are known to jump.
_SEEN = 0.5


@dataclass(frozen=True, eq=False)
class Quality:
    """A log in numbers, SI.

    Args:
        file: Its name.
        rows: Samples.
        duration: s.
        rate: Samples per second, from the median interval.
        jitter: How far nine of ten intervals keep to the median one, as a share of it.
        gaps: Intervals longer than three median ones.
        longest_gap: s; 0 without gaps.
        rotary: Whether position is an angle.
        channels: Channels that were recorded.
        units: Channel -> SI unit; a force may stay in amperes.
        spans: Channel -> least and greatest value.
        steps: Channel -> quantisation step, 0 if there is none to be seen.
        noise: Standard deviation of the position noise beside quantisation.
        strokes: Runs in one direction; none in a table of steady speeds, which has no positions.
        speeds: What 10, 50 and 90 % of the moving time stay below.
        stuck: Share of the time at rest.
        rests: How many rests.
        slips: Jumps from rest to rest.
        faults: Channels that are not what they seem, a sentence each.
        breakaways: Ramps of a measured force, and where the axis broke away in them.
        presliding: Stiffness of the contact, if force cycles below breakaway; else None.
        notes: How the log was read, and what was mended.
        verdict: What the log is good enough for and what not, a sentence each.
        rig: The rig that it suggests; empty where none does.
        rig_reason: Why.
    """

    file: str
    rows: int
    duration: float
    rate: float
    jitter: float
    gaps: int
    longest_gap: float
    rotary: bool
    channels: tuple[str, ...]
    units: Mapping[str, str]
    spans: Mapping[str, tuple[float, float]]
    steps: Mapping[str, float]
    noise: float
    strokes: tuple[Stroke, ...]
    speeds: tuple[float, float, float]
    stuck: float
    rests: int
    slips: tuple[Slip, ...]
    faults: tuple[str, ...]
    breakaways: tuple[Breakaway, ...]
    presliding: Presliding | None
    notes: tuple[str, ...]
    verdict: tuple[str, ...]
    rig: str = ""
    rig_reason: str = ""

    @property
    def median_jump(self) -> float:
        """Median size of the slips, m or rad; 0 without slips."""
        return float(np.median([abs(s.jump) for s in self.slips])) if self.slips else 0.0

    @property
    def directions(self) -> tuple[int, ...]:
        """The directions of the strokes, each once: (-1, 1), (1,) or (-1,)."""
        return tuple(sorted({s.direction for s in self.strokes}))

    def __repr__(self) -> str:
        moves = f"strokes: {len(self.strokes)}, slips: {len(self.slips)}"
        likely = f"; likely rig: {self.rig}" * bool(self.rig)
        samples = f"{self.rows} samples in {self.duration:.4g} s"
        return f"<Quality of {self.file or 'recording'}: {samples}, {moves}{likely}>"

    def __str__(self) -> str:
        lines = self.lines()
        width = max(len(what) for what, _ in lines)
        return "\n".join([self.file, *(f"{what:{width}}  {value}" for what, value in lines)])

    def _repr_html_(self) -> str:
        return str(presenter("quality_html")(self))

    def lines(self) -> list[tuple[str, str]]:
        """What a person reads: (what, value) in units of the workshop, the verdict last."""
        x = CHANNELS["position"][self.rotary]
        v = CHANNELS["velocity"][self.rotary]
        if "position" not in self.channels:
            return self._run_lines()
        table = [
            ("samples", f"{self.rows} in {self.duration:.4g} s, {self.rate:.4g} Hz"),
            ("jitter", f"{self.jitter:.1%} of the interval"),
            (
                "gaps",
                f"{self.gaps}, longest {self.longest_gap * 1e3:.3g} ms" if self.gaps else "none",
            ),
            *((name, self._span(name)) for name in self.channels),
            ("position noise", shown(self.noise, x)),
            ("strokes", self._strokes(v)),
            (
                "speeds while moving",
                " / ".join(shown(s, v) for s in self.speeds) + " (10/50/90 %)",
            ),
            ("stuck", f"{self.stuck:.0%} of the time, {self.rests} rest{'s' * (self.rests != 1)}"),
            (
                "slips",
                f"{len(self.slips)}, median {shown(self.median_jump, x)}" if self.slips else "none",
            ),
            *(("breakaway", self._breakaway(b)) for b in self.breakaways),
            *([("presliding", self._presliding(self.presliding))] if self.presliding else []),
            *(("note", note) for note in self.notes),
            *(("fault", sentence) for sentence in self.faults),
        ]
        likely = [("likely rig", f"{self.rig}: {self.rig_reason}")] * bool(self.rig)
        return [*table, *(("verdict", line) for line in self.verdict), *likely]

    def _run_lines(self) -> list[tuple[str, str]]:
        """The same of a table of steady speeds."""
        return [
            ("runs", f"{self.rows} at constant speed, each a mean"),
            *((name, self._span(name)) for name in self.channels),
            *(("note", note) for note in self.notes),
            *(("verdict", line) for line in self.verdict),
            ("likely rig", f"{self.rig}: {self.rig_reason}"),
        ]

    def _span(self, name: str) -> str:
        si = self.units[name]
        low, high = self.spans[name]
        comb = f", step {shown(self.steps[name], si)}" if self.steps[name] else ""
        return f"{shown(low, si)} to {shown(high, si)}{comb}"

    def _breakaway(self, b: Breakaway) -> str:
        F = self.units["force"]
        ramp = f"a ramp of {shown(b.rate, F)}/s to {shown(b.reached, F)}"
        if b.by_speed is None:
            return f"none below {shown(abs(b.reached), F)}, in {ramp}"
        by_stiffness = (
            "" if b.by_stiffness is None else f" ({shown(b.by_stiffness, F)} by stiffness)"
        )
        return f"at {shown(b.by_speed, F)} by speed{by_stiffness}, in {ramp}"

    def _presliding(self, presliding: Presliding) -> str:
        F, x = self.units["force"], self.units["position"]
        return (
            f"sigma_0 at least {presliding.stiffness:.5g} {F}/{x}, the slope between the tips: ±"
            f"{shown(presliding.amplitude, F)} over {shown(presliding.travel, x)} peak to peak, "
            f"{presliding.cycles} settled cycles; amplitude over peak to peak is half of that, "
            f"{presliding.half:.5g} {F}/{x}"
        )

    def _strokes(self, v: str) -> str:
        phrases = []
        for sign, name in ((1, "up"), (-1, "down")):
            if speeds := [s.speed for s in self.strokes if s.direction == sign]:
                phrases.append(f"{len(speeds)} {name} at {shown(float(np.median(speeds)), v)}")
        return ", ".join(phrases) or "none"


def check(
    log: Log,
    *,
    units: Mapping[str, str] | None = None,
    columns: Columns = None,
    subtract: str | None = None,
) -> Quality:
    """Measure a log and judge it: what is certain is put right first. Nothing is random.

    Args:
        log: A recording, the path of a file, a frame of polars or pandas, or a dict of columns.
        units: Unit by column, as in `{"t": "s", "x": "mm"}`, where the heads do not say it.
        columns: Column by channel, as in `{"position": "x"}`, where the heads do not say it.
        subtract: The column of a known force that is taken off the measured one.

    Raises:
        InputError: the log cannot be used.
    """
    recording = recording_of(log, units=units, columns=columns, subtract=subtract)
    if recording.runs is not None:
        return _runs_quality(recording)
    recording = mended(recording)
    segments = seen_segments(recording)
    dt = np.diff(recording.t)
    middle = float(np.median(dt))
    gaps = dt[dt > GAP * middle]
    channels = recording.channels()
    speeds = np.quantile(np.abs(_moving(recording, segments)), [0.1, 0.5, 0.9]).tolist()
    tests = ForceTests(ramps(recording), presliding(recording))
    rig, reason = likely_rig(recording, segments, tests)
    return Quality(
        file=recording.label,
        rows=len(recording),
        duration=float(recording.t[-1] - recording.t[0]),
        rate=1.0 / middle,
        jitter=float(np.quantile(np.abs(dt / middle - 1.0), 0.9)),
        gaps=len(gaps),
        longest_gap=float(gaps.max()) if len(gaps) else 0.0,
        rotary=recording.rotary,
        channels=tuple(channels),
        units=MappingProxyType({n: recording.si_unit(n) for n in channels}),
        spans=MappingProxyType({n: (float(a.min()), float(a.max())) for n, a in channels.items()}),
        steps=MappingProxyType({n: step(a) for n, a in channels.items()}),
        noise=segments.noise,
        strokes=segments.strokes,
        speeds=(speeds[0], speeds[1], speeds[2]),
        stuck=segments.stuck,
        rests=len(segments.rests),
        slips=segments.slips,
        breakaways=tests.ramps,
        presliding=tests.cycles,
        notes=recording.notes,
        faults=tuple(fault.sentence for fault in faults(recording)),
        verdict=tuple(verdicts(recording, segments, tests, speeds[0])),
        rig=rig,
        rig_reason=reason,
    )


def _runs_quality(recording: Recording) -> Quality:
    """A table of steady speeds in numbers, and what it is good enough for."""
    channels = {n: a for n, a in recording.channels().items() if n != "position"}
    v = channels["velocity"]
    low, middle, high = np.quantile(np.abs(v), [0.1, 0.5, 0.9]).tolist()
    ways = [int((v > 0).sum()), int((v < 0).sum())]
    both = f"both directions ({ways[0]} up, {ways[1]} down)" if all(ways) else "one direction"
    return Quality(
        file=recording.label,
        rows=len(recording),
        duration=0.0,
        rate=0.0,
        jitter=0.0,
        gaps=0,
        longest_gap=0.0,
        rotary=recording.rotary,
        channels=tuple(channels),
        units=MappingProxyType({n: recording.si_unit(n) for n in channels}),
        spans=MappingProxyType({n: (float(a.min()), float(a.max())) for n, a in channels.items()}),
        steps=MappingProxyType(dict.fromkeys(channels, 0.0)),
        noise=0.0,
        strokes=(),
        speeds=(low, middle, high),
        stuck=0.0,
        rests=0,
        slips=(),
        breakaways=(),
        presliding=None,
        notes=recording.notes,
        faults=(),
        verdict=(f"static laws can be identified: {len(v)} speeds, {both}; nothing accelerates",),
        rig=f"forced{'-rotary' * recording.rotary}",
        rig_reason="speeds and forces of runs at constant speed",
    )


def seen_segments(recording: Recording) -> Segments:
    """Strokes, rests and slips of a log that has been mended; a jump of its position is no slip."""
    return _without_leaps(recording, segment(recording))


def _without_leaps(recording: Recording, segments: Segments) -> Segments:
    """The same without slips that are jumps of the position: rows are missing, no axis moved."""
    jumps = [fault.rows for fault in faults(recording) if fault.kind == "jump"]
    if not jumps:
        return segments
    slips = [
        s
        for s in segments.slips
        if not any(rows[s.start : s.stop + 1].any() for rows in jumps) and _is_seen(recording, s)
    ]
    return replace(segments, slips=tuple(slips))


def _is_seen(recording: Recording, slip: Slip) -> bool:
    """Whether the recorded velocity makes a good part of a slip; True without one."""
    if recording.velocity is None:
        return True
    rows = slice(max(slip.start - 1, 0), slip.stop + 2)
    way = float(np.trapezoid(recording.velocity[rows], recording.t[rows]))
    return bool(way * np.sign(slip.jump) >= _SEEN * abs(slip.jump))


def _moving(recording: Recording, segments: Segments) -> Array:
    """Velocities while moving, over a lag at which noise makes no more than a tenth of the pace."""
    t, x = recording.t, recording.position
    pace = np.median([s.speed for s in segments.strokes]) if segments.strokes else 0.0
    fuzz = np.hypot(segments.noise, segments.step / 3.5)
    lag = int(np.ceil(14 * fuzz / (pace * recording.dt))) if pace else 1
    lag = min(max(lag, 1), max(1, len(x) // 10))
    moving = np.ones(len(x), dtype=bool)
    for rest in segments.rests:
        moving[rest] = False
    paired = moving[lag:] | moving[:-lag]
    velocity = (x[lag:] - x[:-lag]) / (t[lag:] - t[:-lag])
    return np.asarray(velocity[paired]) if paired.any() else np.zeros(1)
