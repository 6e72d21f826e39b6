"""What a log is good enough for and what not, a sentence each with its evidence."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from .breakaway import PRESLIDING, STILL, Breakaway, Presliding
from .force_channel import EXACT, both_ways, force_left_out, spikes
from .gate import faults
from .gate.fault import shown
from .segmentation import Segments, strokes

if TYPE_CHECKING:
    from .recording import Recording

_FEW_SLIPS, _STICKY = 3, 0.1
#: Slips of a log of force ramps: more of them, for each ramp, and stick-slip is what it shows.
_PER_RAMP = 5
#: Strokes one way are of one speed if their velocities, each over this share of its stroke, lie
#: within this ratio, tenth to ninetieth percentile.
_OVER, _ONE_SPEED = 0.1, 1.7
_COARSE = 5  # samples in a slip
#: Slips are those of stick-slip if most are shorter than this share of the stroke they lie in.
_OF_STROKE = 0.5
#: Below so many steps (or widths of the noise) of the sensor in all, travel gives no velocity;
#: below so many it does not show presliding either.
_TRAVEL, _NOTHING = 200, 10
#: Little is seen of an axis that rests for this share of the time.
_RESTS = 0.5


@dataclass(frozen=True)
class ForceTests:
    """Tests with a force below or up to breakaway that a log holds.

    Args:
        ramps: Ramps of the force.
        cycles: Cycles below breakaway; None if there are none.
    """

    ramps: tuple[Breakaway, ...]
    cycles: Presliding | None

    def of(self, slips: int) -> str:
        """What the log is then; empty if it holds no such test, or stick-slip beside it."""
        if self.ramps:
            if slips > _PER_RAMP * len(self.ramps):
                return ""
            broke = any(b.by_speed is not None for b in self.ramps)
            return "a ramp of force to breakaway" if broke else "a ramp of force below breakaway"
        return "" if self.cycles is None else "cycles of force below breakaway"


def verdicts(recording: Recording, segments: Segments, tests: ForceTests, slow: float) -> list[str]:
    """What a log is good enough for and what not.

    Args:
        recording: The log, mended.
        segments: Its strokes, rests and slips.
        tests: Its ramps and cycles of force.
        slow: The speed that a tenth of the moving time stays below, m/s (rad/s).
    """
    tested = tests.of(len(segments.slips))
    sticky = not tested and _sticky(segments)
    coarse = "" if sticky or tested else _coarse(recording, segments)
    steady = "" if segments.slips or tested or coarse else _one_speed(recording)
    notes = [
        _on_sticking(recording, segments, tested, coarse, slow, sticky=sticky),
        _on_force(recording, segments, tested, coarse, steady=bool(steady)),
        _on_pressure(recording),
        _on_command(recording),
        _on_directions(recording),
        _on_resolution(recording, segments),
        steady,
        _on_short_slips(segments) if sticky else "",
    ]
    return [line for line in notes if line]


def likely_rig(recording: Recording, segments: Segments, tests: ForceTests) -> tuple[str, str]:
    """The rig that a log suggests, empty where none does, and why.

    Args:
        recording: The log, mended.
        segments: Its strokes, rests and slips.
        tests: Its ramps and cycles of force.
    """
    tested = tests.of(len(segments.slips))
    turned = "-rotary" * recording.rotary
    sticky = not tested and _sticky(segments)
    measured = recording.force is not None and bool(np.ptp(recording.force) > 0)
    if tested:
        return f"presliding{turned}", tested
    balanced = measured and not _by_position(recording)
    if sticky and not recording.rotary and not (balanced and segments.stuck <= _RESTS):
        return "slide-bed", f"stick-slip, {_slips(recording, segments)}"
    if balanced:
        if coarse := _coarse(recording, segments):
            return f"presliding{turned}", f"force measured, {coarse}"
        pressed = recording.pressure is not None and not recording.rotary
        return ("cylinder", "force and pressure measured") if pressed else (
            f"forced{turned}", "force measured"
        )  # fmt: skip
    if recording.pressure is not None and recording.back_pressure is not None:
        return "two-chambers", "the pressures in both chambers measured"
    return _without_force(recording)


def _without_force(recording: Recording) -> tuple[str, str]:
    """The rig of a log that does not stick and has no measured force, and why."""
    if recording.rotary and recording.command is not None:
        voltage = recording.voltage is not None
        return ("servo-pendulum" if voltage else "joint",
                f"command{' and voltage' * voltage} recorded, no force")  # fmt: skip
    lacking = "no measured force" if recording.force is None else "its force is no measurement"
    substitutes = [n for n in ("current", "voltage") if getattr(recording, n) is not None]
    way = (
        f"map {substitutes[0]} to force by its factor"
        if substitutes
        else force_left_out(recording) or "record the force of its drive, or its current"
    )
    return "", f"{lacking} and no stick-slip: {way}"


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
    resolution, travel = _resolution(recording, segments), float(np.ptp(recording.position))
    if not travel < _TRAVEL * resolution or travel > STILL[recording.rotary]:
        return ""
    x = recording.si_unit("position")
    return (
        f"the whole travel of {shown(travel, x)} is {travel / resolution:.0f} times what the "
        f"sensor resolves ({shown(resolution, x)})"
    )


def _on_resolution(recording: Recording, segments: Segments) -> str:
    """A word on a sensor that is coarse beside a travel that is motion."""
    resolution, travel = _resolution(recording, segments), float(np.ptp(recording.position))
    if not travel < _TRAVEL * resolution or travel <= STILL[recording.rotary]:
        return ""
    x = recording.si_unit("position")
    recorded = recording.velocity is not None
    better = ", the recorded velocity is to be preferred" if recorded else ""
    return (
        f"position is coarse: {shown(travel, x)} of travel are {travel / resolution:.0f} times "
        f"what the sensor resolves ({shown(resolution, x)}): its differences make a poor "
        f"velocity{better}"
    )


def _resolution(recording: Recording, segments: Segments) -> float:
    """What the sensor tells apart: a step, or the width of its noise, which leaps would hide."""
    if any(fault.kind == "jump" for fault in faults(recording)):
        return segments.step
    return float(np.hypot(segments.step, 3.5 * segments.noise))


def _by_position(recording: Recording) -> bool:
    if recording.force is None:
        return False
    share = both_ways(recording.t, recording.position, recording.force)
    return share is not None and share <= EXACT


def _slips(recording: Recording, segments: Segments) -> str:
    """The slips in a few words."""
    n = len(segments.slips)
    jump = float(np.median([abs(s.jump) for s in segments.slips]))
    size = shown(jump, recording.si_unit("position"))
    return f"{n} slip{'s' * (n != 1)} of {size}"


def _on_sticking(
    recording: Recording, segments: Segments, tested: str, coarse: str, slow: float, *,
    sticky: bool,
) -> str:  # fmt: skip
    n, stuck = len(segments.slips), f"stuck {segments.stuck:.0%} of the time"
    if tested:
        after = f", then {_slips(recording, segments)}" if n else ", without slips"
        return f"{tested}{after}: Stribeck parameters cannot be identified"
    if coarse:
        return f"hardly any motion: {coarse}"
    if _by_position(recording):
        return (
            "no stick-slip: the force is a function of the position, so the axis rests and moves "
            "as it is moved by hand or swings"
        )
    if sticky:
        return (f"stick-slip present: {_slips(recording, segments)}, {stuck}: Stribeck parameters "
                "can be identified by simulation")  # fmt: skip
    return _on_few_slips(recording, segments, stuck, _slow_sliding(recording, segments, slow))


def _slow_sliding(recording: Recording, segments: Segments, slow: float) -> str:
    """How far a log shows low speeds without stick-slip: by a force, or by a motion that is driven.

    An axis that rests most of the time and does not slip shows hardly more than that it rests.
    """
    forced = recording.force is not None and bool(np.ptp(recording.force) > 0)
    moved = recording.command is not None and segments.stuck <= _RESTS
    if _before_breakaway(recording) or not (forced or moved):
        return ""
    return (
        "breakaway and the drop after it are known as far as the axis slides slowly: a tenth of "
        f"the moving time is below {shown(slow, recording.si_unit('velocity'))}"
    )


def _before_breakaway(recording: Recording) -> bool:
    """Whether the whole travel is no more than bristles may give way."""
    return float(np.ptp(recording.position)) <= PRESLIDING[recording.rotary]


def _on_few_slips(recording: Recording, segments: Segments, stuck: str, sliding: str) -> str:
    n = len(segments.slips)
    if not n:
        known = sliding or "breakaway and Stribeck parameters cannot be identified"
        return f"no stick-slip (no slip from rest to rest, {stuck}): {known}"
    if 2 * _steps(segments) < n:
        return (f"no stick-slip: {n} move{'s' * (n != 1)} from rest to rest, each about a whole "
                "stroke: swings or single moves")  # fmt: skip
    known = sliding or "Stribeck parameters will be weak at best"
    if n == 1:
        size = shown(abs(segments.slips[0].jump), recording.si_unit("position"))
        return (
            f"no stick-slip: one move of {size} from rest to rest, not repeated, {stuck}: {known}"
        )
    return f"hardly any stick-slip: {_slips(recording, segments)}, {stuck}: {known}"


def _on_force(
    recording: Recording, segments: Segments, tested: str, coarse: str, *, steady: bool
) -> str:
    if recording.force is None:
        return _on_substitutes(recording)
    if not np.ptp(recording.force) > 0:
        value = shown(float(recording.force[0]), recording.si_unit("force"))
        return f"force is {value} in every sample, no measurement: no force balance is possible"
    if tested or coarse:
        rig = f"rig presliding{'-rotary' * recording.rotary}"
        x = float(np.ptp(recording.position))
        enough = tested or x > _NOTHING * _resolution(recording, segments)
        reason = f"as {tested}" if tested else coarse
        simulated = f", {rig} simulates it" if enough else ""
        return f"force measured, but {reason}: no force balance is possible{simulated}"
    if _by_position(recording):
        return ("force is an exact function of the position, a command and not a measurement: "
                "no force balance is possible")  # fmt: skip
    known = "mass, Coulomb" if steady else "mass, Coulomb, viscous"
    doubts = []
    if spiky := spikes([recording.force]):
        doubts.append(f"{spiky:.0%} of its variance is spikes: expect wide intervals")
    if segments.stuck > _RESTS:
        doubts.append(f"the axis rests {segments.stuck:.0%} of the time, where it says nothing")
    if _before_breakaway(recording):
        travel = shown(float(np.ptp(recording.position)), recording.si_unit("position"))
        doubts.append(
            f"the whole travel of {travel} may lie before breakaway, where a law with states is "
            "needed (lugre, gms:2)"
        )
    but = f", but {' and '.join(doubts)}" if doubts else ""
    return f"force measured: a force balance is possible ({known}){but}"


def _on_substitutes(recording: Recording) -> str:
    if substitutes := [n for n in ("current", "voltage") if getattr(recording, n) is not None]:
        return (f"no measured force: no force balance is possible unless {substitutes[0]} is "
                "mapped to force by its factor")  # fmt: skip
    left = force_left_out(recording)
    return f"no measured force: no force balance is possible{': ' * bool(left)}{left}"


def _on_pressure(recording: Recording) -> str:
    if recording.pressure is None or recording.force is None:
        return ""
    return "pressure recorded: rig cylinder takes its share off the force, every other leaves it in"


def _on_command(recording: Recording) -> str:
    if recording.command is not None:
        return "command recorded: motion can be simulated from it"
    if recording.force is not None:
        return "no command recorded: rigs with a measured force need none"
    return ("no command recorded: rig slide-bed assumes one (the mean of the first samples and a "
            "ramp), other controlled rigs need it")  # fmt: skip


def _on_directions(recording: Recording) -> str:
    """A word on an axis that only ever goes one way, wherever its command goes."""
    runs = strokes(replace(recording, command=None))
    directions = {s.direction for s in runs}
    if len(directions) != 1:
        return ""
    way = "up" if directions == {1} else "down"
    n = len(runs)
    return (f"moves one way only ({n} stroke{'s' * (n != 1)} {way}): nothing can be said about the "
            "other direction, and an offset looks like friction")  # fmt: skip


def _one_speed(recording: Recording) -> str:
    """A word on strokes that are of one speed in each direction, if they are."""
    v = recording.si_unit("velocity")
    x, t, spans = recording.position, recording.t, []
    runs = strokes(replace(recording, command=None))
    for direction in (1, -1):
        speeds: list[float] = []
        for rows in (s.rows for s in runs if s.direction == direction):
            lag = max(1, int(_OVER * (rows.stop - rows.start)))
            way = np.abs(x[rows][lag:] - x[rows][:-lag])
            speeds += (way / (t[rows][lag:] - t[rows][:-lag])).tolist()
        if not speeds:
            continue
        low, high = np.quantile(speeds, [0.1, 0.9])
        if high >= _ONE_SPEED * low:
            return ""
        spans.append(f"{shown(low, v)} to {shown(high, v)} {'up' if direction > 0 else 'down'}")
    if not spans:
        return ""
    return (f"one speed a direction ({', '.join(spans)}): only starts and stops tell viscous "
            "friction from Coulomb friction")  # fmt: skip


def _on_short_slips(segments: Segments) -> str:
    n = float(np.median([s.stop - s.start for s in segments.slips]))
    if n >= _COARSE:
        return ""
    return f"slips last {n:.0f} samples: too few to see their speed, F_V and v_SS will be weak"
