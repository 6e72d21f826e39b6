"""Ramps of a slide that a slow command pulls: other speeds, rests, reversals."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...wording import either
from .offer import HOLD, Course, Offer, OperatingRange, course

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

#: Speeds of ramps, as multiples of the one in the log.
SPEEDS = (0.2, 0.5, 2.0, 5.0)
#: Speeds of the staircase of speeds.
STAIRS = (0.25, 0.5, 1.0, 2.0, 4.0)
#: The slowest ramp, its pauses, and how long it runs between them, s.
CREEP, PAUSE, RUN = 0.1, 2.0, 10.0
#: Pauses and rests where breakaway depends on them, s.
PAUSES = (0.2, 1.0, 5.0)
#: How long moves between rests are, s.
MOVE = 1.5


def ramps(axis: OperatingRange, seconds: float) -> Iterator[Offer]:
    """Ramps, rests and reversals in the directions in which the model holds.

    Args:
        axis: The axis.
        seconds: How long each may take.
    """
    directions = axis.directions
    if len(directions) == 1:
        yield Offer("reversal", "", refusal=_one_way())
    for times in SPEEDS:
        name, speed = f"ramp × {_share(times)}", times * axis.pace
        yield (_slow if times < 1 else _ramps)(axis, directions, speed, seconds, name)
    if len(directions) > 1:
        yield _reversal(axis, directions[0], seconds)
    yield _knots(axis, directions, seconds, "breakaway", *_creep(axis))
    yield _knots(axis, directions, seconds, "starts from rest", *_rests(axis))
    yield _stairs(axis, directions, seconds)


def _one_way() -> str:
    """Why an axis is not reversed that was driven one way."""
    directional = either("identify --directional", 'identify with law="NAME-directional"')
    return (
        "the data go one way, and nothing says that friction is the same on the way back: record "
        f"both ways and {directional}"
    )


def _run_in(axis: OperatingRange) -> float:
    """Way at the pace of the log that winds the drive up, before a slow motion."""
    return axis.lag if axis.lag < 0.4 * (axis.high - axis.low) else 0.0


def _slow(
    axis: OperatingRange, directions: Sequence[int], speed: float, seconds: float, name: str
) -> Offer:
    words = f"a ramp at {axis.rate(speed)}"
    return _knots(axis, directions, seconds, name, words, [(1.0, speed)])


def _creep(axis: OperatingRange) -> tuple[str, list[tuple[float, float]]]:
    v = CREEP * axis.pace
    words = f"{axis.rate(v)} for {RUN:g} s and {_pauses(axis, 'a pause')}"
    return words, _cycle(axis, RUN, v)


def _rests(axis: OperatingRange) -> tuple[str, list[tuple[float, float]]]:
    words = f"{axis.rate(axis.pace)} for {MOVE:g} s and {_pauses(axis, 'a rest')}"
    return words, _cycle(axis, MOVE, axis.pace)


def _cycle(axis: OperatingRange, seconds: float, speed: float) -> list[tuple[float, float]]:
    """Moves and pauses in turn, (seconds, speed)."""
    pauses = PAUSES if axis.law.rests else (PAUSE,)
    return [knot for pause in pauses for knot in ((seconds, speed), (pause, 0.0))]


def _pauses(axis: OperatingRange, name: str) -> str:
    if not axis.law.rests:
        return f"{name} of {PAUSE:g} s, again and again"
    *others, last = (f"{pause:g}" for pause in PAUSES)
    return f"{name} of {', '.join(others)} and {last} s in turn, again and again"


def _knots(
    axis: OperatingRange,
    directions: Sequence[int],
    seconds: float,
    name: str,
    words: str,
    cycle: Sequence[tuple[float, float]],
) -> Offer:
    """A cycle of (seconds, speed), repeated after a run-in until time or travel is used up."""
    lead, courses = _run_in(axis), []
    for direction in directions:
        x, end = _ends(axis, direction, np.inf)
        t, at = [0.0, HOLD], [x, x]
        if lead:
            t.append(t[-1] + lead / axis.pace)
            at.append(x + direction * lead)
        k = 0
        while t[-1] < seconds / len(directions) - 1e-9:
            span, speed = cycle[k % len(cycle)]
            span = min(span if len(cycle) > 1 else np.inf, seconds / len(directions) - t[-1])
            span = min(span, abs(end - at[-1]) / speed) if speed else span
            if not span > 1e-9:  # noqa: PLR2004 - the travel is used up
                break
            t.append(t[-1] + span)
            at.append(at[-1] + direction * speed * span)
            k += 1
        courses.append(course(axis, t, at))
    begin = f"from {axis.place(courses[0].command[0])}, {_each(directions)}, from rest: "
    first = (
        f"{axis.rate(axis.pace)} over {axis.place(lead)} to wind up the drive, then "
        if lead
        else ""
    )
    return Offer(name, begin + first + words, courses)


def _share(times: float) -> str:
    return f"{times:g}" if times >= 1 else f"1/{1 / times:g}"


def _ends(axis: OperatingRange, direction: int, length: float) -> tuple[float, float]:
    """Where a stroke of some length begins and ends."""
    length = min(length, axis.high - axis.low)
    return (axis.low, axis.low + length) if direction > 0 else (axis.high, axis.high - length)


def _each(directions: Sequence[int]) -> str:
    """Directions in words."""
    if len(directions) > 1:
        return "each way"
    return f"in the direction of {'growing' if directions[0] > 0 else 'falling'} position"


def _ramps(
    axis: OperatingRange, directions: Sequence[int], speed: float, seconds: float, name: str
) -> Offer:
    share = seconds / len(directions)
    travel = axis.high - axis.low
    length = min(travel, speed * (share - HOLD))
    cycle = HOLD + length / speed
    n_ramps = max(1, int((share + length / speed) // (cycle + length / speed)))
    courses = [
        _ramp(axis, *_ends(axis, direction, length), speed)
        for direction in directions
        for _ in range(n_ramps)
    ]
    first, last = _ends(axis, directions[0], length)
    count = "one ramp" if n_ramps == 1 else f"{n_ramps} ramps"
    each_direction = " each way" if len(directions) > 1 else ""
    return_text = ", back at the same speed, unrecorded" if n_ramps > 1 else ""
    course = f"from {axis.place(first)} to {axis.place(last)} at {axis.rate(speed)}"
    words = (
        f"{count}{each_direction} {course}, each from rest{return_text}"
        if n_ramps > 1
        else f"{count}{each_direction} {course}, from rest"
    )
    took = len(directions) * (n_ramps * cycle + (n_ramps - 1) * length / speed)
    return Offer(name, words, courses, seconds=took)


def _ramp(axis: OperatingRange, low: float, high: float, speed: float) -> Course:
    """From rest, one stroke at one speed, from `low` to `high` or back if they are swapped."""
    end = HOLD + abs(high - low) / speed
    return course(axis, [0.0, HOLD, end], [low, low, high])


def _reversal(axis: OperatingRange, direction: int, seconds: float) -> Offer:
    half = (seconds - HOLD) / 2
    a, b = _ends(axis, direction, axis.pace * half)
    turn = abs(b - a) / axis.pace
    courses = [course(axis, [0.0, HOLD, HOLD + turn, HOLD + 2 * turn], [a, a, b, a])]
    words = (
        f"a ramp from {axis.place(a)} to {axis.place(b)} at {axis.rate(axis.pace)} and back at "
        "once, recorded both ways"
    )
    return Offer("reversal", words, courses)


def _stairs(axis: OperatingRange, directions: Sequence[int], seconds: float) -> Offer:
    lead, pace = _run_in(axis), axis.pace * np.array(STAIRS)
    share = seconds / len(directions) - HOLD - lead / axis.pace
    room = axis.high - axis.low - lead
    step = min(
        max(share, 0.2 * seconds / len(directions)) / float(np.sum(1 / pace)), room / len(pace)
    )
    speeds = pace.tolist()
    cycle = [(step / v, v) for v in speeds]
    words = f"{axis.listed('velocity', speeds)} one after the other, {axis.place(step)} at each"
    return _knots(axis, directions, seconds, "speeds in steps", words, cycle)
