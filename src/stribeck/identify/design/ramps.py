"""What a slide bed can do next: ramps of other speeds, rests, reversals; and better sensors."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from .proposals import HOLD, Course, Left, course, ramp, simulated, thinned, within

if TYPE_CHECKING:
    from .experiment import Experiment
    from .operating_range import Axis

Offer = tuple["Experiment", Sequence[Course]]

#: Why an axis is not reversed that was driven one way.
ONE_WAY = (
    "the data go one way, and nothing says that friction is the same on the way back: record both "
    "ways and identify --directional"
)
#: Speeds of ramps, as multiples of the one in the log.
SPEEDS = (0.2, 0.5, 2.0, 5.0)
#: Speeds of the staircase of speeds.
STAIRS = (0.25, 0.5, 1.0, 2.0, 4.0)
#: The slowest ramp, its pauses, and how long it runs between them, s.
CREEP, PAUSE, RUN = 0.1, 2.0, 10.0
#: How long moves between rests are, s.
MOVE = 1.5


def slide_bed(axis: Axis, ways: Sequence[int], seconds: float, left: Left) -> list[Experiment]:
    """Candidates of a slide bed.

    Args:
        axis: The axis.
        ways: Directions in which the model holds, +1 or -1 or both.
        seconds: How long each may take.
        left: Takes what was left out, and why.
    """
    axis = thinned(axis, seconds)
    if len(ways) == 1:
        left.append(("reversal", ONE_WAY))
    return list(within(axis, _offers(axis, ways, seconds), left))


def _offers(axis: Axis, ways: Sequence[int], seconds: float) -> Iterator[Offer]:
    for times in SPEEDS:
        name, speed = f"ramp × {_share(times)}", times * axis.pace
        yield (_slow if times < 1 else _ramps)(axis, ways, speed, seconds, name)
    if len(ways) > 1:
        yield _reversal(axis, ways[0], seconds)
    yield _knots(axis, ways, seconds, "breakaway", *_creep(axis))
    yield _knots(axis, ways, seconds, "starts from rest", *_rests(axis))
    yield _stairs(axis, ways, seconds)


def _run_in(axis: Axis) -> float:
    """Way at the pace of the log that winds the drive up, before a slow motion."""
    return axis.lag if axis.lag < 0.4 * (axis.high - axis.low) else 0.0


def _slow(axis: Axis, ways: Sequence[int], speed: float, seconds: float, name: str) -> Offer:
    words = f"a ramp at {axis.rate(speed)}"
    return _knots(axis, ways, seconds, name, words, [(1.0, speed)])


def _creep(axis: Axis) -> tuple[str, list[tuple[float, float]]]:
    v = CREEP * axis.pace
    words = f"{axis.rate(v)} for {RUN:g} s and a pause of {PAUSE:g} s, again and again"
    return words, [(RUN, v), (PAUSE, 0.0)]


def _rests(axis: Axis) -> tuple[str, list[tuple[float, float]]]:
    words = f"{axis.rate(axis.pace)} for {MOVE:g} s and a rest of {PAUSE:g} s, again and again"
    return words, [(MOVE, axis.pace), (PAUSE, 0.0)]


def _knots(
    axis: Axis,
    ways: Sequence[int],
    seconds: float,
    name: str,
    words: str,
    cycle: Sequence[tuple[float, float]],
) -> Offer:
    """A cycle of (seconds, speed), repeated after a run-in until time or travel is used up."""
    lead, courses = _run_in(axis), []
    for way in ways:
        x, end = _ends(axis, way, np.inf)
        t, at = [0.0, HOLD], [x, x]
        if lead:
            t.append(t[-1] + lead / axis.pace)
            at.append(x + way * lead)
        k = 0
        while t[-1] < seconds / len(ways) - 1e-9:
            span, speed = cycle[k % len(cycle)]
            span = min(span if len(cycle) > 1 else np.inf, seconds / len(ways) - t[-1])
            span = min(span, abs(end - at[-1]) / speed) if speed else span
            if not span > 1e-9:  # noqa: PLR2004 - the travel is used up
                break
            t.append(t[-1] + span)
            at.append(at[-1] + way * speed * span)
            k += 1
        courses.append(course(axis, t, at))
    begin = f"from {axis.place(courses[0].command[0])}, {_each(ways)}, from rest: "
    first = (
        f"{axis.rate(axis.pace)} over {axis.place(lead)} to wind up the drive, then "
        if lead
        else ""
    )
    return simulated(axis, name, begin + first + words, courses), courses


def _share(times: float) -> str:
    return f"{times:g}" if times >= 1 else f"1/{1 / times:g}"


def _ends(axis: Axis, way: int, length: float) -> tuple[float, float]:
    """Where a stroke of some length begins and ends."""
    length = min(length, axis.high - axis.low)
    return (axis.low, axis.low + length) if way > 0 else (axis.high, axis.high - length)


def _each(ways: Sequence[int]) -> str:
    """Directions in words."""
    if len(ways) > 1:
        return "each way"
    return "in the direction of growing position" if ways[0] > 0 else "in the other direction"


def _ramps(axis: Axis, ways: Sequence[int], speed: float, seconds: float, name: str) -> Offer:
    share = seconds / len(ways)
    travel = axis.high - axis.low
    length = min(travel, speed * (share - HOLD))
    cycle = HOLD + length / speed
    many = max(1, int((share + length / speed) // (cycle + length / speed)))
    courses = [ramp(axis, *_ends(axis, way, length), speed) for way in ways for _ in range(many)]
    first, last = _ends(axis, ways[0], length)
    count = "one ramp" if many == 1 else f"{many} ramps"
    both = " each way" if len(ways) > 1 else ""
    back = ", back at the same speed, unrecorded" if many > 1 else ""
    words = (
        f"{count}{both} from {axis.place(first)} to {axis.place(last)} at {axis.rate(speed)}, "
        f"each from rest{back}"
        if many > 1
        else f"{count}{both} from {axis.place(first)} to {axis.place(last)} at {axis.rate(speed)}, "
        "from rest"
    )
    took = len(ways) * (many * cycle + (many - 1) * length / speed)
    return simulated(axis, name, words, courses, seconds=took), courses


def _reversal(axis: Axis, way: int, seconds: float) -> Offer:
    half = (seconds - HOLD) / 2
    a, b = _ends(axis, way, axis.pace * half)
    turn = abs(b - a) / axis.pace
    courses = [course(axis, [0.0, HOLD, HOLD + turn, HOLD + 2 * turn], [a, a, b, a])]
    words = (
        f"a ramp from {axis.place(a)} to {axis.place(b)} at {axis.rate(axis.pace)} and back at "
        "once, recorded both ways"
    )
    return simulated(axis, "reversal", words, courses), courses


def _stairs(axis: Axis, ways: Sequence[int], seconds: float) -> Offer:
    lead, pace = _run_in(axis), axis.pace * np.array(STAIRS)
    share = seconds / len(ways) - HOLD - lead / axis.pace
    room = axis.high - axis.low - lead
    step = min(max(share, 0.2 * seconds / len(ways)) / float(np.sum(1 / pace)), room / len(pace))
    cycle = [(step / v, v) for v in pace.tolist()]
    listed = ", ".join(axis.rate(v).split()[0] for v in pace[:-1])
    words = f"{listed} and {axis.rate(pace[-1])} one after the other, {axis.place(step)} at each"
    return _knots(axis, ways, seconds, "speeds in steps", words, cycle)
