"""Slips with a breakaway of their own: what pulled at the axis as each began, and how it went on.

The force under which a resting axis begins to slip is seen without simulating it: it is what drive
and surroundings pull with at the onset. So each slip tells its own breakaway F_S,i, given the
rig's parameters; simulated with it, from the rest before, a slip begins when the measured one did.
What its onset may be off by within a sample, and its rest within a step of the sensor, shifts all
of the slip, and is taken out of its residuals.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from ..data.departures import SlipOnset
from ..errors import InputError
from ..friction import Law
from ..friction.orders import orders
from ..rig.rig import Motion, stem
from ..rig.simulated import SimulatedRig
from ..space import Array
from .known_holds import moved_holds

if TYPE_CHECKING:
    from .segment import Segment

#: Name of the level at which an axis breaks away, in every law that has one of its own.
BREAKAWAY = "F_S"
#: By how much the onset of a simulated slip may be moved: as long as the first part of its way
#: took, and at least so many sampling intervals. And how often it is moved.
_MOVED, _MOVES = 2.0, 4
#: Times that a slip is simulated only to see when it begins, where that is not known well.
_PASSES = 2
#: By how much later a slip is begun to see what that changes, s.
_LATER = 1e-4


def onset_of(segment: Segment) -> SlipOnset:
    """The onset of a segment that is a slip.

    Raises:
        InputError: it is none.
    """
    if segment.onset is None:
        raise InputError("a whole motion has no breakaway of one slip")
    return segment.onset


def breakaway_columns(law: Law) -> tuple[int, int] | None:
    """Columns of a law's breakaway level leftward and rightward; None if it has none of its own.

    A law with states breaks away gradually, and one without F_S where it also slides.
    """
    if not (law.static and law.sticks):
        return None
    names = law.names
    if BREAKAWAY in names:
        return names.index(BREAKAWAY), names.index(BREAKAWAY)
    split = [n for n in names if stem(n) == BREAKAWAY]
    if len(split) != 2:  # noqa: PLR2004 - one a direction
        return None
    return names.index(f"{BREAKAWAY}-"), names.index(f"{BREAKAWAY}+")


def column(law: Law, segment: Segment) -> int:
    """The column of the breakaway level in a complete parameter set, for the slip of a segment."""
    columns = breakaway_columns(law)
    if columns is None:
        raise InputError(f"law {law.name} has no breakaway level of its own")
    return columns[onset_of(segment).direction > 0]


def onset_inputs(rig: SimulatedRig, segments: Sequence[Segment]) -> Array:
    """What pulls at the axis as slips begin, as `pull` of the rig reads it, (2 slips, m).

    First what each still bore, then what it no longer did.

    Raises:
        InputError: the rig does not know what pulls at an axis at rest.
    """
    onsets = [onset_of(s) for s in segments]
    rows = [
        rig.resting(s.track, instant, o.position)
        for instants in ([o.before for o in onsets], [o.after for o in onsets])
        for s, o, instant in zip(segments, onsets, instants, strict=True)
    ]
    known = [row for row in rows if row is not None]
    if len(known) < len(rows):
        raise InputError(f"rig {rig.name} does not say what pulls at an axis at rest")
    return np.array(known)


def pulls(
    rig: SimulatedRig, law: Law, p: Array, segments: Sequence[Segment], inputs: Array | None = None
) -> tuple[Array, Array]:
    """What pulled at the axis in the direction of each slip as it began; and how far it is open.

    Args:
        rig: The rig.
        law: The law.
        p: (n, k) complete parameter sets, SI.
        segments: Slips.
        inputs: Their `onset_inputs`, if these are known already.

    Returns:
        N or N m, (n, slips): half-way between what was borne and what was not, and the second
        less the first.
    """
    inputs = onset_inputs(rig, segments) if inputs is None else inputs
    before, after = np.split(rig.pull(law, p, inputs), 2, axis=1)
    directions = np.array([onset_of(s).direction for s in segments])
    return 0.5 * directions * (before + after), directions * (after - before)


def uniform(rise: Array) -> Array:
    """The standard deviation of what lies somewhere between two ends so far apart."""
    sd: Array = np.abs(rise) / np.sqrt(12.0)
    return sd


def simulated_slip(
    rig: SimulatedRig, law: Law, p: Array, segment: Segment, F: Array, rise: Array, *,
    rough: bool = False, levelled: bool = True,
) -> SimulatedSlip:  # fmt: skip
    """A slip that breaks away under what pulled at its measured onset.

    Args:
        rig: The rig.
        law: The law; its breakaway level is replaced.
        p: (n, k) complete parameter sets, SI.
        segment: A slip.
        F: Its breakaway, (n,), N or N m.
        rise: By how much that is open, (n,); see `pulls`.
        rough: Whether the onset may be so far off that the slip is simulated anew from where it
            fits best.
        levelled: Whether it may lie as much higher or lower as its rest is uncertain.
    """
    onset = onset_of(segment)
    if not levelled:
        segment = replace(segment, onset=replace(onset, uncertain=0.0))
    rate = rise / (onset.after - onset.before)
    held = onset.instant is not None  # then the pull says under which of its readings
    if held or (rig.holds_force and not rough):  # it tells the sample
        rate = np.zeros_like(F)
    later = np.zeros_like(F)
    best: SimulatedSlip | None = None
    for _ in range(1 + (_PASSES if rough else 0)):
        slip = _timed(rig, law, p, segment, F + later * rate, later)
        late = later + slip.late
        taken = later if rig.holds_force else late
        slip = replace(slip, late=late, breakaway=F + taken * rate)
        best = slip if best is None else _nearer(segment, best, slip)
        later = late
    assert best is not None  # noqa: S101 - there is one pass at least
    return best


@dataclass(frozen=True, eq=False)
class SimulatedSlip:
    """A slip as it was simulated, in time with the measured one.

    Args:
        position: m or rad, (n, N).
        velocity: m/s or rad/s, (n, N).
        late: By how much it begins later than its onset has it, s, (n,).
        breakaway: Under which it so begins, N or N m, (n,).
    """

    position: Array
    velocity: Array
    late: Array
    breakaway: Array


def _nearer(segment: Segment, a: SimulatedSlip, b: SimulatedSlip) -> SimulatedSlip:
    """Of each row the one of two simulations that is nearer to the measured slip; a if neither."""
    first, second = unexplained(segment, a), unexplained(segment, b)
    nearer = (second < first) | ~np.isfinite(first)
    return SimulatedSlip(
        np.where(nearer[:, None], b.position, a.position),
        np.where(nearer[:, None], b.velocity, a.velocity),
        np.where(nearer, b.late, a.late),
        np.where(nearer, b.breakaway, a.breakaway),
    )


def unexplained(segment: Segment, slip: SimulatedSlip) -> Array:
    """Sum of squares of the measured less the simulated positions that count, m^2, (n,)."""
    off = (segment.track.measured - slip.position)[:, segment.track.score > 0]
    squares: Array = np.einsum("nm,nm->n", off, off)
    return squares


def _timed(
    rig: SimulatedRig, law: Law, p: Array, segment: Segment, F: Array, later: Array
) -> SimulatedSlip:
    """Slips under a breakaway, as much later, and higher, as they fit best.

    Higher or lower by no more than the level at which the axis rested is uncertain.

    Args:
        rig: The rig.
        law: The law.
        p: (n, k) complete parameter sets.
        segment: The slip.
        F: Its breakaway, (n,).
        later: Than its onset, where a held force leaves that open, s, (n,).
    """
    onset, counts = onset_of(segment), segment.track.score > 0
    own = with_breakaway(law, p, segment, F)
    if onset.instant is None:
        x, v = rig.states(law, own, segment.track)
        speeds = v
    else:
        x, v, speeds = _held(rig, law, own, segment, onset.instant + later)
    off, speed = segment.track.measured - x, speeds
    if not counts.all():
        off, speed = off[:, counts], speed[:, counts]
    most, uncertain = max(_MOVED * (onset.after - onset.before), onset.seconds), onset.uncertain
    shift = np.zeros(len(x))
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        if uncertain > 0:
            mean = off.mean(axis=1)
            late = _later(off - mean[:, None], speed - speed.mean(axis=1, keepdims=True), most)
            shift = np.clip(mean + late * speed.mean(axis=1), -uncertain, uncertain)
            shift[~np.isfinite(shift)] = 0.0
        late = _later(off - shift[:, None], speed, most)
    return SimulatedSlip(x + shift[:, None] - late[:, None] * speeds, v, late, F)


def _held(
    rig: SimulatedRig, law: Law, p: Array, segment: Segment, instants: Array
) -> tuple[Array, Array, Array]:
    """Positions and velocities of slips that begin at some instants; what each second later takes.

    A force that is held is not late with the slip, so that this is not its velocity.
    """
    onset = onset_of(segment)
    twice = np.concatenate([instants, instants + _LATER])
    motion = rig.held_slips(law, np.tile(p, (2, 1)), segment.track, twice, onset.direction)
    x, after = np.split(motion.position, 2)
    return x, motion.velocity[: len(p)], (x - after) / _LATER


def _later(off: Array, speed: Array, most: float) -> Array:
    """By how much later motions would leave least of what they are off by, s, (n,)."""
    late = -np.einsum("nm,nm->n", off, speed) / np.einsum("nm,nm->n", speed, speed)
    return np.where(np.isfinite(late), np.minimum(np.maximum(late, -most), most), 0.0)


def with_breakaway(law: Law, p: Array, segment: Segment, breakaway: Array) -> Array:
    """Complete parameter sets (n, k) with the breakaway (n,) of a slip, not below sliding."""
    own, k = p.copy(), column(law, segment)
    own[:, k] = breakaway
    for j in _floors(law, k):
        np.maximum(own[:, k], own[:, j], out=own[:, k])
    return own


def slip_motion(rig: SimulatedRig, law: Law, p: Array, segment: Segment) -> Motion:
    """The motion of complete parameter sets (n, k) over a slip, or over a whole segment."""
    if segment.onset is None:
        return rig.move(law, p, segment.track)
    F, rise = pulls(rig, law, p, [segment])
    slip = simulated_slip(rig, law, p, segment, F[:, 0], rise[:, 0], rough=True)
    own = with_breakaway(law, p, segment, slip.breakaway)
    if (instant := segment.onset.instant) is None:
        motion = rig.move(law, own, segment.track)
    else:
        instants = instant + slip.late
        motion = rig.held_slips(law, own, segment.track, instants, segment.onset.direction)
    return replace(motion, position=slip.position, velocity=slip.velocity)


def moved_onsets(
    rig: SimulatedRig, law: Law, p: Array, segments: Sequence[Segment]
) -> tuple[Segment, ...]:
    """Slips with their onsets where a complete parameter set (k,) has them.

    Under a held force, at the nearest sample. Each move begins anew from the last one, and where it
    ends by the next simulation may be a worse place: the onset that leaves least of its slip stays.
    Those under forces that are known to be held are placed together, so that the last ones stay.
    """
    moved, best = list(segments), list(segments)
    least = np.full(len(moved), np.inf)
    for k in range(1 + _MOVES):
        left = [
            float(unexplained(s, slip)[0])
            for s, slip in zip(moved, _each_simulated(rig, law, p, moved), strict=True)
        ]
        for i, s in enumerate(moved):
            if left[i] < least[i] or onset_of(s).instant is not None:
                best[i], least[i] = s, left[i]
        if k < _MOVES:
            slips = _each_simulated(rig, law, p, moved, rough=True)
            late = [float(slip.late[0]) for slip in slips]
            held = moved_holds(rig, moved, late)
            moved = [
                replace(s, onset=held[i] if i in held else _moved(rig, s, late[i]))
                for i, s in enumerate(moved)
            ]
    return tuple(best)


def _each_simulated(
    rig: SimulatedRig, law: Law, p: Array, slips: Sequence[Segment], *, rough: bool = False
) -> list[SimulatedSlip]:
    """Slips of one complete parameter set (k,), each under its own breakaway."""
    F, rise = pulls(rig, law, p[None], slips)
    return [
        simulated_slip(rig, law, p[None], s, F[:, k], rise[:, k], rough=rough)
        for k, s in enumerate(slips)
    ]


def _moved(rig: SimulatedRig, segment: Segment, by: float) -> SlipOnset:
    """The onset of a slip some seconds later, within its samples."""
    onset, t = onset_of(segment), segment.track.t
    if rig.holds_force:
        at = min(max(int(np.argmin(np.abs(t - onset.after - by))), 1), len(t) - 1)
        return replace(onset, before=float(t[at - 1]), after=float(t[at]))
    by = float(np.clip(by, t[0] - onset.before, t[-1] - onset.after))
    return replace(onset, before=onset.before + by, after=onset.after + by)


@cache
def _floors(law: Law, k: int) -> tuple[int, ...]:
    """Columns of the levels that the level of a column may not fall below."""
    return tuple(j for i, j in orders(law) if i == k)
