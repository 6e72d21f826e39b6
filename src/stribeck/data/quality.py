"""What is in a log, and what it is good enough for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from ..space import Array
from ..units import unit
from .breakaway import Breakaway, Presliding, presliding, ramps
from .force_channel import EXACT, both_ways, spikes
from .recording import CHANNELS
from .segmentation import Segments, Slip, Stroke, segment, step

if TYPE_CHECKING:
    from .recording import Recording

_GAP = 3.0  # median intervals
#: A channel that may clip is suspected if it sits at an extreme this long, for this share of rows.
_CLIPS = ("velocity", "force", "current", "voltage")
_FLAT, _FLAT_SHARE = 5, 0.002
_FEW_SLIPS, _STICKY = 3, 0.1
_ONE_SPEED = 1.7
_MANY = 1e4  # millimetres or milliradians: better in metres or radians
_COARSE = 5  # samples in a slip
#: Slips are those of stick-slip if most are shorter than this share of the stroke they lie in.
_OF_STROKE = 0.5
#: Below so many steps (or widths of the noise) of the sensor in all, travel gives no velocity.
_TRAVEL = 200
_DISTINCT = 8  # values of a channel below which one that repeats is no clipping
_SHOWN = {"m": "mm", "rad": "mrad", "m/s": "mm/s", "rad/s": "mrad/s", "m/s**2": "mm/s**2",
          "rad/s**2": "rad/s**2", "Pa": "bar"}  # fmt: skip


_MOVED = (
    "no stick-slip: the force is a function of the position, so the axis rests and moves as it is "
    "moved by hand or swings"
)


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
        spans: Channel -> least and greatest value.
        steps: Channel -> quantisation step, 0 if there is none to be seen.
        noise: Standard deviation of the position noise beside quantisation.
        strokes: Runs in one direction.
        speeds: What 10, 50 and 90 % of the moving time stay below.
        stuck: Share of the time at rest.
        rests: How many rests.
        slips: Jumps from rest to rest.
        clipped: Channel -> share of samples at an extreme, where that looks like saturation.
        breakaways: Ramps of a measured force, and where the axis broke away in them.
        presliding: Stiffness of the contact, if force cycles below breakaway; else None.
        notes: What was mended when the log was read.
        verdict: What the log is good enough for and what not, a sentence each.
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
    spans: Mapping[str, tuple[float, float]]
    steps: Mapping[str, float]
    noise: float
    strokes: tuple[Stroke, ...]
    speeds: tuple[float, float, float]
    stuck: float
    rests: int
    slips: tuple[Slip, ...]
    clipped: Mapping[str, float]
    breakaways: tuple[Breakaway, ...]
    presliding: Presliding | None
    notes: tuple[str, ...]
    verdict: tuple[str, ...]

    @property
    def median_jump(self) -> float:
        """Median size of the slips, m or rad; 0 without slips."""
        return float(np.median([abs(s.jump) for s in self.slips])) if self.slips else 0.0

    @property
    def directions(self) -> tuple[int, ...]:
        """The directions of the strokes, each once: (-1, 1), (1,) or (-1,)."""
        return tuple(sorted({s.direction for s in self.strokes}))

    def lines(self) -> list[tuple[str, str]]:
        """What a person reads: (what, value) in units of the workshop, the verdict last."""
        x = CHANNELS["position"][self.rotary]
        v = CHANNELS["velocity"][self.rotary]
        table = [
            ("samples", f"{self.rows} in {self.duration:.4g} s, {self.rate:.4g} Hz"),
            ("jitter", f"{self.jitter:.1%} of the interval"),
            (
                "gaps",
                f"{self.gaps}, longest {self.longest_gap * 1e3:.3g} ms" if self.gaps else "none",
            ),
            *((name, self._span(name)) for name in self.channels),
            ("position noise", _shown(self.noise, x)),
            ("strokes", self._strokes(v)),
            (
                "speeds while moving",
                " / ".join(_shown(s, v) for s in self.speeds) + " (10/50/90 %)",
            ),
            ("stuck", f"{self.stuck:.0%} of the time, {self.rests} rests"),
            (
                "slips",
                f"{len(self.slips)}, median {_shown(self.median_jump, x)}"
                if self.slips
                else "none",
            ),
            *(("suspected clipping", f"{n}: {s:.1%} of samples") for n, s in self.clipped.items()),
            *(("breakaway", self._breakaway(b)) for b in self.breakaways),
            *([("presliding", self._presliding(self.presliding))] if self.presliding else []),
            *(("mended", note) for note in self.notes),
        ]
        return table + [("verdict", line) for line in self.verdict]

    def _span(self, name: str) -> str:
        si = CHANNELS[name][self.rotary]
        low, high = self.spans[name]
        comb = f", step {_shown(self.steps[name], si)}" if self.steps[name] else ""
        return f"{_shown(low, si)} to {_shown(high, si)}{comb}"

    def _breakaway(self, b: Breakaway) -> str:
        F = CHANNELS["force"][self.rotary]
        ramp = f"a ramp of {_shown(b.rate, F)}/s to {_shown(b.reached, F)}"
        if b.by_speed is None:
            return f"none below {_shown(abs(b.reached), F)}, in {ramp}"
        by_stiffness = (
            "" if b.by_stiffness is None else f" ({_shown(b.by_stiffness, F)} by stiffness)"
        )
        return f"at {_shown(b.by_speed, F)} by speed{by_stiffness}, in {ramp}"

    def _presliding(self, presliding: Presliding) -> str:
        F, x = CHANNELS["force"][self.rotary], CHANNELS["position"][self.rotary]
        return (
            f"sigma_0 at least {presliding.stiffness:.5g} {F}/{x}, the slope between the tips: ±"
            f"{_shown(presliding.amplitude, F)} over {_shown(presliding.travel, x)} peak to peak, "
            f"{presliding.cycles} settled cycles; amplitude over peak to peak is half of that, "
            f"{presliding.half:.5g} {F}/{x}"
        )

    def _strokes(self, v: str) -> str:
        phrases = []
        for sign, name in ((1, "up"), (-1, "down")):
            if speeds := [s.speed for s in self.strokes if s.direction == sign]:
                phrases.append(f"{len(speeds)} {name} at {_shown(float(np.median(speeds)), v)}")
        return ", ".join(phrases) or "none"


def check(recording: Recording) -> Quality:
    """Measure a log and judge it. Nothing is changed, nothing is random."""
    segments = segment(recording)
    dt = np.diff(recording.t)
    middle = float(np.median(dt))
    gaps = dt[dt > _GAP * middle]
    channels = recording.channels()
    clipped = {n: s for n in _CLIPS if n in channels and (s := _clipped(channels[n]))}
    velocity = _moving(recording, segments)
    speeds = np.quantile(np.abs(velocity), [0.1, 0.5, 0.9]).tolist()
    breakaways, cycles = ramps(recording), presliding(recording)
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
        spans=MappingProxyType({n: (float(a.min()), float(a.max())) for n, a in channels.items()}),
        steps=MappingProxyType({n: step(a) for n, a in channels.items()}),
        noise=segments.noise,
        strokes=segments.strokes,
        speeds=(speeds[0], speeds[1], speeds[2]),
        stuck=segments.stuck,
        rests=len(segments.rests),
        slips=segments.slips,
        clipped=MappingProxyType(clipped),
        breakaways=breakaways,
        presliding=cycles,
        notes=recording.notes,
        verdict=tuple(
            _verdict(recording, segments, velocity, clipped, _tested(breakaways, cycles))
        ),
    )


def _clipped(a: Array) -> float:
    """The share of samples at an extreme, if they come in runs too long for chance; else 0."""
    if len(np.unique(a)) < _DISTINCT:
        return 0.0  # a step that was held, or a sensor that hardly moved
    for extreme in (a.max(), a.min()):
        at = a == extreme
        edges = np.flatnonzero(np.diff(at.astype(np.int8), prepend=0, append=0))
        lengths = edges[1::2] - edges[::2]
        flat = lengths[lengths >= _FLAT].sum() / len(a)
        if extreme != 0 and a.min() < a.max() and flat > _FLAT_SHARE:
            return float(flat)
    return 0.0


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


def _tested(breakaways: tuple[Breakaway, ...], cycles: Presliding | None) -> str:
    """What a log of force below or up to breakaway is called; empty for any other."""
    if breakaways:
        broke = any(b.by_speed is not None for b in breakaways)
        return "a ramp of force to breakaway" if broke else "a ramp of force below breakaway"
    return "" if cycles is None else "cycles of force below breakaway"


def _verdict(
    recording: Recording,
    segments: Segments,
    velocity: Array,
    clipped: Mapping[str, float],
    tested: str,
) -> list[str]:
    sticky = not tested and _sticky(segments)
    coarse = "" if sticky or tested else _coarse(recording, segments)
    notes = [
        _on_sticking(recording, segments, tested, coarse, sticky=sticky),
        _on_force(recording, tested, coarse),
        _on_pressure(recording),
        _on_command(recording),
    ]
    signs = {s.direction for s in segments.strokes}
    if len(signs) == 1:
        notes.append("moves one way only: nothing can be said about the other direction, and an "
                    "offset looks like friction")  # fmt: skip
    slips_few = len(segments.slips) < _FEW_SLIPS and not tested and not coarse
    if slips_few and all(_one_speed(velocity * sign) for sign in (1, -1)):
        notes.append("one speed a direction: viscous friction cannot be told from Coulomb friction")
    if sticky and (n := np.median([s.stop - s.start for s in segments.slips])) < _COARSE:
        notes.append(f"slips last {n:.0f} samples: too few to see their speed, F_V and v_SS will "
                     "be weak")  # fmt: skip
    notes += [f"{name} sits at its limit in {share:.1%} of the samples: it may be clipped"
             for name, share in clipped.items()]  # fmt: skip
    return [line for line in notes if line]


def _sticky(segments: Segments) -> bool:
    """Whether the axis sticks and slips: several slips, most of them a part of their stroke."""
    return (
        len(segments.slips) >= _FEW_SLIPS
        and segments.stuck > _STICKY
        and 2 * _steps(segments) >= len(segments.slips)
    )


def _steps(segments: Segments) -> int:
    """How many slips are a part of the stroke they lie in: a swing or a move is all of it."""
    steps = 0
    for slip in segments.slips:
        middle = (slip.start + slip.stop) // 2
        stroke = next((s for s in segments.strokes if s.rows.start <= middle < s.rows.stop), None)
        steps += stroke is None or abs(slip.jump) < _OF_STROKE * stroke.travel
    return steps


def _coarse(recording: Recording, segments: Segments) -> str:
    """Why travel is too short to be differentiated, if it is."""
    resolution = float(np.hypot(segments.step, 3.5 * segments.noise))
    count = float(np.ptp(recording.position)) / resolution if resolution > 0 else np.inf
    return f"the whole travel is {count:.0f} steps of the sensor" if count < _TRAVEL else ""


def _by_position(recording: Recording) -> bool:
    if recording.force is None:
        return False
    share = both_ways(recording.t, recording.position, recording.force)
    return share is not None and share <= EXACT


def _on_sticking(
    recording: Recording, segments: Segments, tested: str, coarse: str, *, sticky: bool
) -> str:
    n = len(segments.slips)
    if tested:
        return f"{tested}: no stick-slip, Stribeck parameters cannot be identified"
    if coarse or _by_position(recording):
        return f"hardly any motion: {coarse}" if coarse else _MOVED
    if sticky:
        jump = float(np.median([abs(s.jump) for s in segments.slips]))
        size = _shown(jump, CHANNELS["position"][recording.rotary])
        return (f"stick-slip present: {n} slips of {size}, stuck {segments.stuck:.0%} of the time: "
                "Stribeck parameters can be identified by simulation")  # fmt: skip
    if n and 2 * _steps(segments) < n:
        return (f"no stick-slip: {n} move{'s' * (n != 1)} from rest to rest, each about a whole "
                "stroke: swings or single moves")  # fmt: skip
    if n:
        return (f"hardly any stick-slip: {n} slip{'s' * (n != 1)}, stuck {segments.stuck:.0%} of "
                "the time: Stribeck parameters will be weak at best")  # fmt: skip
    return "no stick-slip: breakaway and Stribeck parameters cannot be identified"


def _on_force(recording: Recording, tested: str, coarse: str) -> str:
    if recording.force is not None:
        if tested or coarse:
            simulated = f"rig presliding{'-rotary' * recording.rotary} simulates it"
            warning = f"as {tested}" if tested else coarse
            return f"force measured, but {warning}: the force-balance road is closed, {simulated}"
        if _by_position(recording):
            return ("force is an exact function of the position, a command and not a measurement: "
                    "the force-balance road is closed")  # fmt: skip
        spiky = spikes([recording.force])
        hard = (
            f", but {spiky:.0%} of its variance is spikes: expect wide intervals" if spiky else ""
        )
        return f"force measured: the force-balance road is open (mass, Coulomb, viscous){hard}"
    if substitutes := [n for n in ("current", "voltage") if getattr(recording, n) is not None]:
        return (f"no measured force: the force-balance road is closed unless {substitutes[0]} is "
                "mapped to force by its factor")  # fmt: skip
    return "no measured force: the force-balance road is closed"


def _on_pressure(recording: Recording) -> str:
    if recording.pressure is None or recording.force is None:
        return ""
    return "pressure recorded: rig cylinder takes its share off the force, every other leaves it in"


def _on_command(recording: Recording) -> str:
    if recording.command is not None:
        return "command recorded: motion can be simulated from it"
    return "no command: a simulation must assume one (the mean of the first samples and a ramp)"


def _one_speed(velocity: Array) -> bool:
    """Whether nearly all motion in the positive direction is equally fast."""
    low, high = np.quantile(velocity[velocity > 0], [0.1, 0.9]) if (velocity > 0).any() else (1, 1)
    return bool(high < _ONE_SPEED * low)


def _shown(si: float, written: str) -> str:
    shown = _SHOWN.get(written, written)
    value = float(unit(shown).from_si(si))
    if abs(value) >= _MANY:
        value, shown = si, written
    return f"{value:.4g} {shown.replace('**2', '²')}"
