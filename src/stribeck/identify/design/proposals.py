"""Experiments that an axis can do: what to run next, by the kind of its rig."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ...data.recording import Recording
from ...rig.simulated import as_simulated
from ...space import Array
from .experiment import Experiment

if TYPE_CHECKING:
    from ...rig import Motion
    from ...rig.motion.track import Track
    from .operating_range import Axis

#: Seconds of rest before a stroke from rest.
HOLD = 1.0
#: Samples of an experiment at most: a faster clock than that is thinned out.
MOST = 6000
#: By how much a drive may be asked for more force than the log shows.
MARGIN = 1.2


@dataclass(frozen=True, eq=False)
class Course:
    """What is asked of an axis from one start on.

    Args:
        t: Times, s, from 0.
        command: Position or force that is asked for, SI, (N,).
        extra: Further channels of the log that it would make, by name.
        start: Where the axis is at first, SI; where the command is by default.
        force: Whether the command is a force.
    """

    t: Array
    command: Array
    extra: dict[str, Any]
    start: float | None = None
    force: bool = False


def course(
    axis: Axis, t: Sequence[float], x: Sequence[float], *, start: float | None = None, **extra: Any
) -> Course:
    """A command that is linear between knots, at the sampling interval of the axis."""
    seconds = float(t[-1])
    clock: Array = axis.interval * np.arange(max(int(seconds / axis.interval), 2) + 1, dtype=float)
    return Course(clock, np.interp(clock, t, x), extra, start)


def tracks(axis: Axis, courses: Sequence[Course]) -> list[Track]:
    """Courses made ready to be simulated."""
    rig = as_simulated(axis.parameters.rig)
    warm = [log.temperature for log in axis.logs if log.temperature is not None]
    made = []
    for c in courses:
        x0 = float(c.command[0]) if c.start is None else c.start
        n = len(c.t)
        log = Recording(
            t=c.t,
            position=np.full(n, x0),
            command=None if c.force else c.command,
            force=c.command if c.force else None,
            temperature=np.full(n, float(warm[0].mean())) if warm else None,
            extra={k: np.broadcast_to(v, (n,)) for k, v in c.extra.items()},
            rotary=rig.rotary,
        )
        with np.errstate(divide="ignore", invalid="ignore"):  # the speed at a start is not asked
            made.append(rig.track(log, slice(0, n), x0, np.ones(n))._replace(v0=0.0))
    return made


def moved(axis: Axis, on: Track, x: Array) -> Motion:
    """The motion of (n, dim) free parameter sets over a track."""
    rig, parameters = as_simulated(axis.parameters.rig), axis.parameters
    return rig.move(parameters.law, parameters.full(x), on)


def predictor(axis: Axis, on: Sequence[Track]) -> Callable[[Array], Array]:
    """Positions over tracks; each may have its start, as a difference, behind the parameters."""
    dim = len(axis.x)

    def predict(rows: Array) -> Array:
        found = []
        for k, track in enumerate(on):
            part = np.full((len(rows), len(track.t)), np.nan)
            starts = rows[:, dim + k] if rows.shape[1] > dim else np.zeros(len(rows))
            for start in np.unique(starts):
                same = starts == start
                from_there = track._replace(x0=track.x0 + float(start))
                part[same] = moved(axis, from_there, rows[same, :dim]).position
            found.append(part)
        return np.concatenate(found, axis=1)

    return predict


def simulated(
    axis: Axis, name: str, words: str, courses: Sequence[Course], **more: Any
) -> Experiment:
    """An experiment of the simulation road."""
    on = tracks(axis, courses)
    seconds = float(sum(c.t[-1] for c in courses))
    free = as_simulated(axis.parameters.rig).free_start
    made = Experiment(
        name,
        words,
        seconds,
        predictor(axis, on),
        axis.noise,
        axis.inflation,
        len(on) if free else 0,
        1e-6 * (axis.high - axis.low),
    )
    return replace(made, **more)


def strain(axis: Axis, courses: Sequence[Course]) -> tuple[float, float, float]:
    """Greatest force of the drive, least and greatest position over courses, as fitted."""
    motions = [moved(axis, on, axis.x[None]) for on in tracks(axis, courses)]
    return (
        max(float(np.abs(m.force).max()) for m in motions),
        min(float(m.position.min()) for m in motions),
        max(float(m.position.max()) for m in motions),
    )


def ramp(axis: Axis, low: float, high: float, speed: float, hold: float = HOLD) -> Course:
    """From rest, one stroke at one speed, from `low` to `high` or back if they are swapped."""
    end = hold + abs(high - low) / speed
    return course(axis, [0.0, hold, end], [low, low, high])


def there_and_back(
    low: float, high: float, pace: Sequence[float], seconds: float
) -> tuple[list[float], list[float]]:
    """Knots of strokes between two ends for `seconds`, each speed an equal share of the time."""
    t, x = [0.0, HOLD], [low, low]
    goal = high
    for k, speed in enumerate(pace, 1):
        until = HOLD + (seconds - HOLD) * k / len(pace)
        while t[-1] < until * (1 - 1e-9):
            step = min(abs(goal - x[-1]) / speed, until - t[-1])
            t.append(t[-1] + step)
            x.append(x[-1] + np.sign(goal - x[-1]) * speed * step)
            if abs(x[-1] - goal) < 1e-9 * abs(high - low):
                goal = low if goal == high else high
    return t, x


def thinned(axis: Axis, seconds: float) -> Axis:
    """The axis with at most MOST samples in an experiment, each worth several."""
    share = seconds / MOST / axis.interval
    if share <= 1:
        return axis
    return replace(axis, interval=share * axis.interval, noise=axis.noise / np.sqrt(share))


#: Names of experiments that were left out, and why.
Left = list[tuple[str, str]]


def within(
    axis: Axis,
    offered: Iterator[tuple[Experiment, Sequence[Course]]],
    left: Left,
    room: float = 1.0,
) -> Iterator[Experiment]:
    """Those that stay within the travel and the force that the log shows; others are told."""
    low, high = axis.low, axis.high
    spare = room * (high - low)
    for experiment, courses in offered:
        force, least, most = strain(axis, courses)
        if not np.isfinite([force, least, most]).all():
            left.append((experiment.name, "the model cannot be simulated there"))
        elif force > MARGIN * axis.force:
            left.append(
                (
                    experiment.name,
                    f"it takes {axis.push(force)}, the log shows {axis.push(axis.force)} at most",
                )
            )
        elif least < low - spare or most > high + spare:
            end = least if least < low - spare else most
            seen = f"the log from {axis.place(low)} to {axis.place(high)}"
            left.append((experiment.name, f"it goes to {axis.place(end)}, {seen}"))
        else:
            yield experiment
