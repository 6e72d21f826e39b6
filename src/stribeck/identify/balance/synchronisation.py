"""Force and motion at one time: a delay that the logs show is allowed for, any other is told."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import TYPE_CHECKING, Literal

import numpy as np

from ...data.alignment import Delay, checked_delay
from ...data.freed_memory import release
from ...errors import InputError
from ...rig.rig import shown_difference
from ...space import Array
from ...units import unit
from ...wording import option
from ..conditions import Violation
from ..data_split import DataSplit
from ..uncertainty.covariance import HALF_WIDTH, correlation_time
from ..uncertainty.verdict import IDENTIFIED
from .balance import NOTHING, Balance, balance
from .channel_delay import ChannelDelay, channel_delay
from .channel_filter import CLEARLY, SURELY, ChannelFilter, channel_filter
from .curve_prior import of_free_curve
from .sensor_bias import acceleration_noise, mass_of
from .training_rows import training_rows
from .velocity_source import VelocitySource, with_velocity

if TYPE_CHECKING:
    from ...data.recording import Recording
    from ..parameters import Parameters
    from .rows import Rows

#: A force that a controller holds from sample to sample is half a sample ahead, and one that is
#: logged a sample late is no fault that moves an estimate: delays up to this many samples are left.
HELD = 1.25
#: A delay is certain beyond so many standard errors, or if it leaves less than this share of the
#: residual's sum of squares and is likely; it is likely beyond so many errors, and told then if it
#: would move an estimate out of its interval.
CERTAIN, MOSTLY, LIKELY = 5.0, 0.5, 2.0
#: What a delay may be that the log does not show, as a standard deviation in samples: that of an
#: output which is held for one.
UNSEEN = 0.5
#: Errors are widened for the delay where that makes them so much larger.
_WIDER = 1.1
#: Of the parameters that a delay moves, those are named that leave their intervals within so many
#: times the delay that the first of them takes.
BESIDE = 5.0
#: Searches for what a move leaves.
_PASSES = 3
#: Share of the cut-off at which a certain delay is looked at again.
LOWER = 0.25
#: Clocks of one log differ in their rate by less: parts whose delays are further apart have matched
#: other strokes, or other slips.
RATE = 0.05


@dataclass(frozen=True, eq=False)
class Synchronised:
    """Logs with force and motion at one time, and their balance.

    Args:
        data: The logs moved, and the ranges.
        recordings: Those of them that are trained on.
        rows: Which of their samples count, as for `balance`.
        solved: Their balance.
        known: How well that was known to the user, as a standard deviation, s; None where he has
            not said it.
        left: What delay is left.
        undecided: Whether a delay that looked certain is left where it is, because the log that was
            moved by it no longer shows it.
        filtered: A filter on a channel that explains the logs beside the delay.
        velocities: What is told of a recorded velocity.
    """

    data: DataSplit
    recordings: tuple[Recording, ...]
    rows: tuple[Rows | None, ...]
    solved: Balance
    known: float | None
    left: ChannelDelay
    undecided: bool
    filtered: ChannelFilter | None
    velocities: tuple[Violation, ...]

    def violations(self) -> list[Violation]:
        """What holds of the delay, and which estimates it biases."""
        return [*self.velocities, *self._delays()]

    def _delays(self) -> list[Violation]:
        left = self.left
        if self.known is not None:
            return [*self._applied(), *self._contradicted()]
        if left.at_edge and certain(left):
            return [_fault(_edge(left))]
        if drifts(left):
            return [_fault(_drift(left))]
        filtered = self.filtered
        if filtered is not None and filtered.ratio < CLEARLY:
            return [_fault(_filter(filtered))]
        violations = [*self._applied(), *self._ambiguous()]
        if certain(left):
            still = " still" if self.data.delay else ""
            moves = f": {option('delay', 'auto')} moves it back"
            violations.append(_fault(f"the force is{still} {_interval(left)}{moves}"))
        elif self.undecided:
            violations.append(_fault(_undecided(left)))
        elif names := self._moved_by_likely():
            text = (
                f"the force may be {_interval(left)}, which would move {self._moves(names)}: "
                f"{option('delay')} takes what is known of it, 0 included"
            )
            violations.append(_fault(text))  # of all, as beyond a reversal no slope tells the move
        elif assumed := self._assumed():
            violations.append(Violation("data", assumed, caps=False))
        return violations

    def _contradicted(self) -> list[Violation]:
        """What is certain by the logs against a delay that was said; what is likely does not count.

        A filter on a channel is no delay, and a fault whatever was said of one.
        """
        left, filtered = self.left, self.filtered
        if filtered is not None and filtered.ratio < CLEARLY:
            return [_fault(_filter(filtered))]
        still = " still" if self.data.delay else ""
        if left.at_edge and certain(left):
            text = _edge(left)
        elif drifts(left):
            text = _drift(left)
        elif certain(left):
            text = (
                f"by the logs the force is{still} {_interval(left)}, against what was said of it: "
                "if they are right, the estimates are not"
            )
        else:
            return []
        return [_fault(text)]

    def _assumed(self) -> str:
        """What is taken of a delay that the logs do not show, where that rules an estimate.

        Empty where every delay that would move an estimate out of its interval would show.
        """
        left, solved = self.left, self.solved
        if self.data.delay or 100 * left.unexplained > NOTHING:
            return ""
        free = solved.system.free
        half = HALF_WIDTH * self.widened(solved.robust_errors)[free]
        known = (half <= IDENTIFIED * np.abs(solved.values[free])) & (left.slopes != 0.0)
        soonest = np.full(len(half), np.inf)
        np.divide(half, np.abs(left.slopes), out=soonest, where=known)
        reach = abs(left.seconds) + HALF_WIDTH * left.error
        first = float(soonest.min(initial=np.inf))
        if not first < reach:
            return ""
        moves = ", ".join(self._each_ms(int(k)) for k in np.flatnonzero(soonest < BESIDE * first))
        return (
            "a delay of the force after the motion is taken to be half a sample at most: the logs "
            f"hardly show one, {moves} for each ms, and {1e3 * first:.2g} ms would be beyond an "
            f"interval: {option('delay')} takes what is known of it, 0 included"
        )

    def _each_ms(self, k: int) -> str:
        """By how much a free parameter moves with the delay."""
        system = self.solved.system
        rig, q = system.rig, system.parameters.every[system.free[k]]
        move = float(shown_difference(rig, q, 1e-3 * float(self.left.slopes[k])))
        word = "rises" if move > 0 else "falls"
        return f"{rig.label(q.name)} {word} {abs(move):.2g} {rig.unit_of(q)}".rstrip()

    def widened(self, errors: Array) -> Array:
        """Standard errors of all parameters, (k,), with what a delay does that is left.

        A delay that the log shows and that is left where it is moves the estimates one way, so that
        it adds to their errors; the rest of what it may be does so at random. Of one that was said
        the log only tells where within its tolerance it is.
        """
        left = self.left
        if self.known == 0.0:
            return errors
        shift, spread = 0.0, left.error
        if self.known and abs(left.seconds) > HALF_WIDTH * float(np.hypot(self.known, left.error)):
            spread = self.known  # what was said holds, and not what the logs say against it
        elif self.known or not self.data.delay:
            unseen = (self.known or UNSEEN * left.sample) ** 2
            seen = max(left.error, 1e-12) ** 2
            shift = left.seconds * unseen / (unseen + seen)
            spread = float(np.sqrt(unseen * seen / (unseen + seen)))
        wide, free = errors.copy(), self.solved.system.free
        wide[free] = np.fmax(
            np.hypot(errors[free], left.slopes * spread),
            np.hypot(self.solved.robust_errors[free], left.slopes * spread)
            + np.abs(left.slopes * shift) / HALF_WIDTH,
        )
        return np.where(wide > _WIDER * errors, wide, errors)

    def _applied(self) -> list[Violation]:
        if not self.data.delay:
            return []
        if self.known is not None:
            text = f"the force is moved back by {1e3 * self.data.delay:.4g} ms, as was said"
        else:
            whole = replace(self.left, seconds=self.data.delay + self.left.seconds)
            advice = f"{option('delay', 'off')} leaves it"
            text = f"the force is {_interval(whole)}, and moved by that: {advice}"
        return [Violation("data", text, caps=False)]

    def _ambiguous(self) -> list[Violation]:
        """A filter that explains the logs as well as a delay, but with other estimates."""
        f, system = self.filtered, self.solved.system
        if f is None or f.ratio > SURELY:
            return []
        tolerance = HALF_WIDTH * self.solved.robust_errors[system.linear]
        names = [
            self.solved.names[i]
            for i, move, within in zip(system.linear, f.moves, tolerance, strict=True)
            if abs(move) > within
        ]
        if not names:
            return []
        label = self.solved.system.rig.label
        text = (
            f"the {f.channel} may as well be low-passed, with a time constant of "
            f"{1e3 * f.seconds:.3g} ms, as the force be moved in time, and then "
            f"{' and '.join(map(label, names))} would be another: log the {f.channel} unfiltered"
        )
        return [Violation("data", text, frozenset(names))]

    def _moved_by_likely(self) -> list[str]:
        """Names of what a delay that is likely moves out of its interval."""
        left, solved = self.left, self.solved
        if not likely(left):
            return []
        free = solved.system.free
        out = np.abs(left.slopes * left.seconds) > HALF_WIDTH * solved.robust_errors[free]
        return [solved.names[i] for i, is_out in zip(free, out, strict=True) if is_out]

    def _moves(self, names: Sequence[str]) -> str:
        system, values = self.solved.system, self.solved.values
        texts = []
        for name in names:
            i = self.solved.names.index(name)
            q = system.parameters.every[i]
            shown = unit(system.rig.unit_of(q))
            moved = values[i] + self.left.slopes[system.free.index(i)] * self.left.seconds
            at, to = (float(shown.from_si(x)) for x in (values[i], moved))
            texts.append(f"{system.rig.label(name)} from {at:.3g} to {to:.3g} {shown.written}")
        return ", ".join(texts)


def synchronised(
    parameters: Parameters, data: DataSplit, delay: Delay, velocity: VelocitySource = "auto"
) -> Synchronised:
    """The logs with force and motion at one time, and their balance.

    Args:
        parameters: Of a law on a rig with a measured force.
        data: The logs as they were recorded.
        delay: Of the force after the motion, s; `auto`: where it is certain it is allowed for;
            `off`: it is told alone.
        velocity: Where it comes from; see `with_velocity`.

    Raises:
        InputError: as `balance`, or a delay that leaves nothing of a log.
    """
    said = checked_delay(delay)
    parameters, velocities = with_velocity(parameters, data, velocity)
    applied, known = (0.0, None) if isinstance(said, str) else said
    filtered: ChannelFilter | None = None
    looked: ChannelDelay | None = None
    moved = data.advanced(parameters.rig, applied)
    recordings, rows, solved = _solved(parameters, moved)
    for passes_left in reversed(range(_PASSES)):
        left = _weighed(parameters, moved, solved, recordings, rows)
        looked = looked or left
        if not certain(left) or left.at_edge or drifts(left):
            break
        if filtered is None and not solved.system.law.states:
            filtered = channel_filter(solved, left.seconds)
        if said != "auto" or (filtered is not None and filtered.ratio < CLEARLY):
            break
        if not passes_left:  # a delay that is left after so many is told
            break
        applied += left.seconds
        del recordings, rows, solved  # before those of the moved logs are made
        moved = data.advanced(parameters.rig, applied)
        recordings, rows, solved = _solved(parameters, moved)
    undecided = False
    if said == "auto" and moved.delay != data.delay and looked is not None:
        whole = _whole(moved.delay - data.delay, left, looked)
        undecided = not certain(whole) or whole.at_edge or drifts(whole)
        if undecided:
            moved, left = data, whole
            recordings, rows, solved = _solved(parameters, moved)
    return Synchronised(
        moved, recordings, rows, solved, known, left, undecided, filtered, velocities
    )


def _weighed(
    parameters: Parameters,
    data: DataSplit,
    solved: Balance,
    recordings: Sequence[Recording],
    rows: Sequence[Rows | None],
) -> ChannelDelay:
    """The delay that solved logs show, certain or likely only as far as the model is better for it.

    What is far from the motion and leaves more is not it: what is near by may be.
    """
    left = _looked_for(solved, recordings, rows)
    evidence = _evidence(parameters, data, left)
    if evidence == "worse":
        left = _looked_for(solved, recordings, rows, near=True)
        evidence = _evidence(parameters, data, left)
    if evidence == "worse":
        return replace(left, error=max(left.error, abs(left.seconds)))
    if evidence == "unsure" and certain(left):
        return replace(left, error=max(left.error, abs(left.seconds) / LIKELY))
    return left


def _looked_for(
    solved: Balance,
    recordings: Sequence[Recording],
    rows: Sequence[Rows | None],
    *,
    near: bool = False,
) -> ChannelDelay:
    """The delay that solved logs show, with an error that holds."""
    left = channel_delay(solved, near=near)
    release(solved.system.samples)
    return _confirmed(left, solved, recordings, rows, near=near) if certain(left) else left


def _evidence(
    parameters: Parameters, data: DataSplit, delay: ChannelDelay
) -> Literal["better", "worse", "unsure", ""]:
    """Whether the model explains logs better, or worse, once their force is moved by a delay.

    Two standard errors' worth is what a delay takes off that is likely at least. A delay may make
    up for a law that is wrong: it has to be worth as much with a free curve in place of the law.
    Empty of a delay that is not likely, or that differs from part to part.
    """
    if not likely(delay) or drifts(delay):
        return ""
    try:
        moved = data.advanced(parameters.rig, delay.seconds)
        logs = tuple(
            log.cut(slice(*np.searchsorted(log.t, [own.t[0], np.nextafter(own.t[-1], np.inf)])))
            for log, own in zip(data.recordings, moved.recordings, strict=True)
        )
        both = training_rows(replace(data, recordings=logs)), training_rows(moved)
        worth = _worth(parameters, *both)
        free = of_free_curve(parameters)
        if free is not None and worth > -(LIKELY**2):
            worth = min(worth, _worth(free, *both))
    except InputError:  # nothing is left of a log, or too few rows
        return "unsure"
    return "better" if worth > LIKELY**2 else "worse" if worth < -(LIKELY**2) else "unsure"


def _worth(
    parameters: Parameters,
    before: tuple[Sequence[Recording], Sequence[Rows | None]],
    after: tuple[Sequence[Recording], Sequence[Rows | None]],
) -> float:
    """What a move of the force is worth: the fall of twice a logarithm of likelihood.

    Both balances are solved anew, of the same samples of the motion: what counts is the fall of the
    sum of squares, of so many residuals as are independent. A move that makes the mass smaller
    leaves less of the motion's error as well, which is no worth.

    Raises:
        InputError: too few rows.
    """
    solved = balance(before[0], parameters, rows=before[1])
    noise = acceleration_noise(solved, *before)
    square, mass, rows = _misfit(solved)
    del solved  # before that of the moved logs is made
    square_after, mass_after, rows_after = _misfit(balance(after[0], parameters, rows=after[1]))
    square -= max(mass**2 - mass_after**2, 0.0) * noise**2
    tiny = float(np.finfo(float).tiny)
    return min(rows, rows_after) * float(np.log(max(square, tiny) / max(square_after, tiny)))


def _misfit(solved: Balance) -> tuple[float, float, float]:
    """Variance of the residuals of a balance, its mass, and how many rows are independent."""
    release(solved.system.samples)
    r = solved.residuals
    independent = len(r) / correlation_time(r, [len(log.t) for log in solved.system.logs])
    return solved.residual_sd**2, mass_of(solved), independent


def _whole(moved: float, left: ChannelDelay, before: ChannelDelay) -> ChannelDelay:
    """The delay of logs that were moved by a time, of what is left, as far as these show it."""
    return replace(
        before,
        seconds=moved + left.seconds,
        error=left.error,
        parts=moved + left.parts,
        part_errors=left.part_errors,
    )


def _confirmed(
    delay: ChannelDelay,
    solved: Balance,
    recordings: Sequence[Recording],
    rows: Sequence[Rows | None],
    *,
    near: bool,
) -> ChannelDelay:
    """A delay with an error that holds at a lower cut-off, too.

    Noise of the position makes a mass too small, which reads as a force that is ahead, and the less
    so the lower the cut-off; the times of two clocks have none.
    """
    parameters = solved.system.parameters
    filtering, rate = solved.system.filtering, max(log.rate for log in solved.system.logs)
    if filtering.passes(rate):
        return delay
    lower = filtering.lowered(LOWER, rate)
    try:
        resolved = balance(recordings, parameters, filtering=lower, rows=rows, start=solved.values)
    except InputError:  # too few rows are left to tell
        return delay
    other = channel_delay(resolved, near=near)
    off = abs(delay.seconds - other.seconds)
    if off <= HALF_WIDTH * float(np.hypot(delay.error, other.error)):
        return delay
    return replace(delay, error=max(delay.error, off / HALF_WIDTH))


def certain(delay: ChannelDelay) -> bool:
    """Whether a delay is longer than a held output makes, and beyond its errors."""
    errors = abs(delay.seconds) / max(delay.error, float(np.finfo(float).tiny))
    sure = errors > CERTAIN or (delay.share < MOSTLY and errors > LIKELY)
    explains = 100 * delay.unexplained < NOTHING
    return sure and explains and abs(delay.seconds) > HELD * delay.sample


def likely(delay: ChannelDelay) -> bool:
    """Whether a delay is longer than a held output makes, and as long as two errors at least."""
    explains = 100 * delay.unexplained <= NOTHING
    return explains and abs(delay.seconds) >= max(LIKELY * delay.error, HELD * delay.sample)


def drifts(delay: ChannelDelay) -> bool:
    """Whether parts of the logs have delays that differ beyond their errors, as clocks may."""
    parts = zip(delay.parts, delay.part_errors, delay.log_parts, strict=True)
    return 100 * delay.unexplained < NOTHING and any(
        abs(a - b) > max(HELD * delay.sample, CERTAIN * float(np.hypot(e, f)))
        and (p.log != q.log or abs(a - b) < RATE * abs(q.begin - p.begin))
        for (a, e, p), (b, f, q) in combinations(parts, 2)
    )


def _solved(
    parameters: Parameters, data: DataSplit
) -> tuple[tuple[Recording, ...], tuple[Rows | None, ...], Balance]:
    recordings, rows = training_rows(data)
    return tuple(recordings), tuple(rows), balance(recordings, parameters, rows=rows)


def _fault(sentence: str) -> Violation:
    return Violation("data", sentence)


def _interval(delay: ChannelDelay) -> str:
    low, high = sorted(abs(delay.seconds + s * HALF_WIDTH * delay.error) for s in (-1, 1))
    if abs(delay.seconds) < HALF_WIDTH * delay.error:
        low = 0.0
    word = "behind" if delay.seconds > 0 else "ahead of"
    size = 1e3 * abs(delay.seconds)
    return f"{size:.3g} ms {word} the motion ({1e3 * low:.3g} to {1e3 * high:.3g} ms)"


def _span(low: float, high: float) -> str:
    """Where a force lies, in ms behind the motion."""
    if low < 0.0 < high:
        return f"anywhere from {-low:.3g} ms ahead of to {high:.3g} ms behind"
    word = "behind" if high > 0.0 else "ahead of"
    near, far = sorted((abs(low), abs(high)))
    return f"{near:.3g} to {far:.3g} ms {word}"


def _edge(delay: ChannelDelay) -> str:
    word = "behind" if delay.seconds > 0 else "ahead of"
    return (
        f"the force is at least {1e3 * delay.reach:.4g} ms {word} the motion, as long as a stroke "
        f"takes: align the channels, or give what is known with {option('delay')}"
    )


def _undecided(delay: ChannelDelay) -> str:
    reach = HALF_WIDTH * delay.error
    low, high = (1e3 * (delay.seconds + side * reach) for side in (-1, 1))
    return (
        f"force and motion seem not to be at one time, but the log does not show by how much: the "
        f"force is {_span(low, high)} the motion: give what is known with {option('delay')}, or "
        f"log a motion with reversals"
    )


def _drift(delay: ChannelDelay) -> str:
    texts = [
        f"{1e3 * seconds:.3g} ms in {part.label}"
        for seconds, part in zip(delay.parts, delay.log_parts, strict=True)
    ]
    return (
        f"the force is not behind the motion by one time: by {', '.join(texts)}: log both on one "
        f"clock, or identify the parts apart with {option('train')}"
    )


def _filter(filtered: ChannelFilter) -> str:
    return (
        f"the {filtered.channel} is low-passed against the other channel, with a time constant of "
        f"{1e3 * filtered.seconds:.3g} ms ({1 / (2 * np.pi * filtered.seconds):.3g} Hz), which no "
        f"delay explains: log the {filtered.channel} unfiltered, or filter both channels alike"
    )
