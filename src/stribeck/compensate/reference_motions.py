"""Reference motions on which a compensation is tried: ramps with rests, faster ramps, a sine."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..errors import InputError
from .closed_loop import Reference

if TYPE_CHECKING:
    from ..data.recording import Recording
    from ..space import Array

#: A ramp lasts so long, s, where the logs do not end it earlier; rests between them, s.
LONG, REST = 20.0, 1.0
#: The faster ramp, in times of the slow one's speed; the sine's greatest speed, the same.
FAST, SINE = 4.0, 2.0
#: A ramp lasts so many periods of the loop at least: four in which the axis catches up, and twice
#: four to tell a swing that lasts from one that decays.
CYCLES = 12.0
#: Samples of a reference at most, and at least in each of its ramps.
MOST, FEWEST = 1_000_000, 20


def references(
    speed: float, travel: float, x0: float, h: float, period: float = 0.0
) -> tuple[Reference, ...]:
    """A slow ramp there and back, a faster one, and a sine that reverses four times.

    The ramps rest at both ends and where they turn. One that would end before a swing of the loop
    can be told from a transient goes on beyond the travel.

    Args:
        speed: Of the slow ramp, m/s or rad/s.
        travel: How far it goes, m or rad.
        x0: Where it starts.
        h: Sample time of the controller, s.
        period: Of the loop's own swing, s.

    Raises:
        InputError: a ramp has so few samples that nothing is controlled, or so many that nobody
            would wait.
    """
    takes = [max(travel / (times * speed), CYCLES * period) for times in (1.0, FAST)]
    for seconds in takes:
        if not FEWEST <= seconds / h <= MOST:
            raise InputError(
                f"a ramp of {seconds:.3g} s has {seconds / h:.3g} samples at a period of "
                f"{h * 1e3:g} ms: choose speed and period so that it has {FEWEST} to {MOST:,}"
            )
    return (
        _ramps("ramp", speed, speed * takes[0], x0, h),
        _ramps("fast ramp", FAST * speed, FAST * speed * takes[1], x0, h),
        _sine("sine", SINE * speed, travel / 4, x0, h),
    )


def _ramps(name: str, speed: float, travel: float, x0: float, h: float) -> Reference:
    takes = travel / speed
    knots = np.cumsum([0.0, REST, takes, REST, takes, REST])
    t = np.arange(0.0, knots[-1] + h / 2, h)
    return Reference(name, t, np.interp(t, knots, x0 + travel * np.array([0, 0, 1, 1, 0, 0])))


def _sine(name: str, speed: float, amplitude: float, x0: float, h: float) -> Reference:
    """Two periods of a cosine from rest: its greatest speed is `speed`."""
    w = speed / amplitude
    t = np.arange(0.0, 4 * np.pi / w + 2 * REST + h / 2, h)
    phase = np.clip(t - REST, 0.0, 4 * np.pi / w) * w
    x: Array = x0 + amplitude * (1 - np.cos(phase))
    return Reference(name, t, x)


def followed(recording: Recording, h: float) -> Reference:
    """The command of a log at the samples of the controller.

    Raises:
        InputError: it has none, or too many samples at this period.
    """
    if recording.command is None:
        raise InputError(f"{recording.label}: it has no command to follow: map a column to command")
    span = float(recording.t[-1] - recording.t[0])
    if not FEWEST <= span / h <= MOST:
        raise InputError(
            f"{recording.label}: {span:.3g} s are {span / h:.3g} samples at a period of "
            f"{h * 1e3:g} ms: it takes {FEWEST} to {MOST:,}"
        )
    t = h * np.arange(int(span / h + 1e-9) + 1, dtype=float)
    return Reference(
        recording.label, t, np.interp(t, recording.t - recording.t[0], recording.command)
    )
