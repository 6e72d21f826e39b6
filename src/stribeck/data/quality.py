"""What is in a log, and what it is good enough for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from ..space import Array
from ..units import unit
from .recording import CHANNELS
from .segment import Segments, Slip, Stroke, segment, step

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
_SHOWN = {"m": "mm", "rad": "mrad", "m/s": "mm/s", "rad/s": "mrad/s", "m/s**2": "mm/s**2",
          "rad/s**2": "rad/s**2"}  # fmt: skip


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
            *(("mended", note) for note in self.notes),
        ]
        return table + [("verdict", line) for line in self.verdict]

    def _span(self, name: str) -> str:
        si = CHANNELS[name][self.rotary]
        low, high = self.spans[name]
        comb = f", step {_shown(self.steps[name], si)}" if self.steps[name] else ""
        return f"{_shown(low, si)} to {_shown(high, si)}{comb}"

    def _strokes(self, v: str) -> str:
        said = []
        for sign, name in ((1, "up"), (-1, "down")):
            if speeds := [s.speed for s in self.strokes if s.direction == sign]:
                said.append(f"{len(speeds)} {name} at {_shown(float(np.median(speeds)), v)}")
        return ", ".join(said) or "none"


def check(recording: Recording) -> Quality:
    """Measure a log and judge it. Nothing is changed, nothing is random."""
    found = segment(recording)
    dt = np.diff(recording.t)
    middle = float(np.median(dt))
    gaps = dt[dt > _GAP * middle]
    channels = recording.channels()
    clipped = {n: s for n in _CLIPS if n in channels and (s := _clipped(channels[n]))}
    velocity = _moving(recording, found)
    speeds = np.quantile(np.abs(velocity), [0.1, 0.5, 0.9]).tolist()
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
        noise=found.noise,
        strokes=found.strokes,
        speeds=(speeds[0], speeds[1], speeds[2]),
        stuck=found.stuck,
        rests=len(found.rests),
        slips=found.slips,
        clipped=MappingProxyType(clipped),
        notes=recording.notes,
        verdict=tuple(_verdict(recording, found, velocity, clipped)),
    )


def _clipped(a: Array) -> float:
    """The share of samples at an extreme, if they come in runs too long for chance; else 0."""
    for extreme in (a.max(), a.min()):
        at = a == extreme
        edges = np.flatnonzero(np.diff(at.astype(np.int8), prepend=0, append=0))
        lengths = edges[1::2] - edges[::2]
        flat = lengths[lengths >= _FLAT].sum() / len(a)
        if extreme != 0 and a.min() < a.max() and flat > _FLAT_SHARE:
            return float(flat)
    return 0.0


def _moving(recording: Recording, found: Segments) -> Array:
    """Velocities while moving, over a lag at which noise makes no more than a tenth of the pace."""
    t, x = recording.t, recording.position
    pace = np.median([s.speed for s in found.strokes]) if found.strokes else 0.0
    fuzz = np.hypot(found.noise, found.step / 3.5)
    lag = int(np.ceil(14 * fuzz / (pace * recording.dt))) if pace else 1
    lag = min(max(lag, 1), max(1, len(x) // 10))
    moving = np.ones(len(x), dtype=bool)
    for rest in found.rests:
        moving[rest] = False
    both = moving[lag:] | moving[:-lag]
    velocity = (x[lag:] - x[:-lag]) / (t[lag:] - t[:-lag])
    return np.asarray(velocity[both]) if both.any() else np.zeros(1)


def _verdict(
    recording: Recording, found: Segments, velocity: Array, clipped: Mapping[str, float]
) -> list[str]:
    said = [_on_sticking(recording, found), _on_force(recording), _on_command(recording)]
    signs = {s.direction for s in found.strokes}
    if len(signs) == 1:
        said.append("moves one way only: nothing can be said about the other direction, and an "
                    "offset looks like friction")  # fmt: skip
    if len(found.slips) < _FEW_SLIPS and all(_one_speed(velocity * sign) for sign in (1, -1)):
        said.append("one speed a direction: viscous friction cannot be told from Coulomb friction")
    if found.slips and (n := np.median([s.stop - s.start for s in found.slips])) < _COARSE:
        said.append(f"slips last {n:.0f} samples: too few to see their speed, F_V and v_SS will be "
                    "weak")  # fmt: skip
    said += [f"{name} sits at its limit in {share:.1%} of the samples: it may be clipped"
             for name, share in clipped.items()]  # fmt: skip
    return [line for line in said if line]


def _on_sticking(recording: Recording, found: Segments) -> str:
    n = len(found.slips)
    if n >= _FEW_SLIPS and found.stuck > _STICKY:
        jump = float(np.median([abs(s.jump) for s in found.slips]))
        size = _shown(jump, CHANNELS["position"][recording.rotary])
        return (f"stick-slip present: {n} slips of {size}, stuck {found.stuck:.0%} of the time: "
                "Stribeck parameters can be identified by simulation")  # fmt: skip
    if n:
        return (f"hardly any stick-slip: {n} slip{'s' * (n != 1)}, stuck {found.stuck:.0%} of the "
                "time: Stribeck parameters will be weak at best")  # fmt: skip
    return "no stick-slip: breakaway and Stribeck parameters cannot be identified"


def _on_force(recording: Recording) -> str:
    if recording.force is not None:
        return "force measured: the force-balance road is open (mass, Coulomb, viscous)"
    if other := [n for n in ("current", "voltage") if getattr(recording, n) is not None]:
        return (f"no measured force: the force-balance road is closed unless {other[0]} is mapped "
                "to force by its factor")  # fmt: skip
    return "no measured force: the force-balance road is closed"


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
