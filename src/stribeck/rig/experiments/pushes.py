"""Forces on an axis whose force is applied and measured."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...space import Array
from .offer import Course, Offer, OperatingRange, clock

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

#: Forces of sines below breakaway, as shares of it.
SHARES = (0.2, 0.4, 0.6, 0.8)
#: How far beyond breakaway a ramp of force goes, as a multiple of it.
BEYOND = 1.05


def pushes(
    axis: OperatingRange, travel: Callable[[Course], float], seconds: float
) -> Iterator[Offer]:
    """Sines of force below breakaway, and triangles just beyond it.

    Args:
        axis: The axis.
        travel: How far a course takes it, m or rad.
        seconds: How long each takes.
    """
    forces = np.concatenate([log.force for log in axis.logs if log.force is not None])
    offset = axis.values["offset"]
    level = axis.law.levels(axis.p[: len(axis.law.params)])[1]
    t = clock(axis, seconds)
    log = axis.logs[0]
    assert log.force is not None  # noqa: S101 - the rig needs it
    turns = np.count_nonzero(np.diff(np.sign(log.force - float(np.mean(log.force)))) != 0)
    period = 2 * float(log.t[-1] - log.t[0]) / max(int(turns), 2)
    period = min(period, seconds / 3)
    greatest = float(np.abs(forces - offset).max())

    def pushed(force: Array) -> Course:
        return Course(t, offset + force, start=log.position[0], force=True)

    def offer(name: str, words: str, force: Array) -> Offer:
        return Offer(name, words, [pushed(force)])

    def sine(amplitude: Array | float, turn: float) -> Array:
        return amplitude * np.sin(2 * np.pi * t / turn)

    most = 0.8 * level
    yield offer("sine to 80 %", f"a sine of ±{axis.push(most)}, 80 % of breakaway, {period:.3g} s "
                "a turn", sine(most, period))  # fmt: skip
    share = np.array(SHARES)[np.minimum((t / seconds * 4).astype(int), 3)]
    listed = axis.listed("force", [s * level for s in SHARES])
    yield offer("several amplitudes", f"sines of ±{listed} one after the other, {period:.3g} s a "
                "turn", sine(share * level, period))  # fmt: skip
    yield offer("fast sine", f"a sine of ±{axis.push(greatest)}, {period / 5:.3g} s a turn",
                sine(greatest, period / 5))  # fmt: skip
    peak = BEYOND * level
    tooth = np.interp(t % period, [0, period / 4, 3 * period / 4, period], [0, peak, -peak, 0])
    distance = travel(pushed(tooth))
    name = "ramp through breakaway"
    yield offer(name, f"triangles of force of ±{axis.push(peak)}, just beyond breakaway, "
                f"{period:.3g} s a turn: the axis goes {axis.place(distance)}", tooth)  # fmt: skip
