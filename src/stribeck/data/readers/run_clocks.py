"""The clocks of the files of one run, brought onto one: by stamps, and by a signal that two have.

Dates are compared as such, and so are times of day. Clocks that count from a zero of their own are
taken to be one; where both begin at zero, to have begun at once. A signal that two files have says
by how much their clocks differ, whatever they count: times of the second are corrected by that.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ...space import Array
from .clock_difference import ClockDifference
from .raw_table import shortened
from .stamps import EPOCHS, epoch

Counts = Literal["dates", "times of day", "from a zero of its own"]

_UNIX = EPOCHS[0]
#: A clock that is read this early, in intervals between its samples, begins at zero.
_ZERO = 10.0
#: A difference of clocks below this part of an interval between samples is not corrected, but
#: told: what lies between two samples is on straight lines anyway.
_SLIGHT = 0.1
#: Standard errors by which a difference is sure.
_SURE = 3.0


@dataclass(frozen=True)
class FileClock:
    """When the samples of a file were taken, as it says.

    Args:
        file: Its name.
        span: First and last instant, s on its own clock.
        interval: Between samples, s.
        origin: The instant of its zero, s since 1970 (or midnight); None if it does not say.
    """

    file: str
    span: tuple[float, float]
    interval: float
    origin: float | None = None

    @property
    def counts(self) -> Counts:
        """What it counts."""
        if epoch(self.begins) is _UNIX:
            return "dates"
        return "from a zero of its own" if self.origin is None else "times of day"

    @property
    def begins(self) -> float:
        """Its first instant, s since 1970, midnight or its zero."""
        return self.span[0] + (self.origin or 0.0)


@dataclass(frozen=True)
class CommonClock:
    """A file's clock on that of the run.

    Args:
        shift: What its times are moved by, s.
        difference: What they differ by from the first file's after that.
    """

    shift: float
    difference: ClockDifference | None = None

    def times(self, t: Array) -> Array:
        """Times of the file on the clock of the run."""
        moved = t + self.shift
        return moved if self.difference is None else self.difference.corrected(moved)


def shifts(clocks: Sequence[FileClock]) -> list[float]:
    """What brings each clock onto one, s; clocks that count different things stay as they are."""
    if len({clock.counts for clock in clocks}) > 1 or clocks[0].counts.startswith("from"):
        return [0.0 for _ in clocks]
    zero = min(clock.begins for clock in clocks)
    return [(clock.origin or 0.0) - zero for clock in clocks]


def certain(difference: ClockDifference, clock: FileClock) -> bool:
    """Whether a difference is worth a correction."""
    rate_error = difference.rate_error if np.isfinite(difference.rate_error) else 0.0
    error = difference.offset_error + 0.5 * difference.span * rate_error
    return difference.most > max(_SLIGHT * clock.interval, _SURE * error)


def strangers(first: FileClock, other: FileClock) -> str:
    """Why clocks without a signal in common cannot be joined; empty if they can."""
    if first.counts == other.counts:
        return ""
    return (
        f"{first.file} counts {first.counts} and {other.file} {other.counts}, and no signal is in "
        "both: export the files of a run with stamps of one kind"
    )


def overlap(clocks: Sequence[FileClock], common: Sequence[CommonClock]) -> tuple[float, str]:
    """How long all files were recorded at once, s, and why not, if two of them were at no time."""
    spans = [c.times(np.array(clock.span)) for clock, c in zip(clocks, common, strict=True)]
    last, first = int(np.argmax([s[0] for s in spans])), int(np.argmin([s[1] for s in spans]))
    both = float(spans[first][1] - spans[last][0])
    if both > 0.0:
        return both, ""
    return 0.0, (
        f"{clocks[first].file} ends {-both:.6g} s before {clocks[last].file} begins: files of one "
        "run overlap in time, and those of several runs are given one by one"
    )


def clocks_sentence(clocks: Sequence[FileClock], common: Sequence[CommonClock], both: float) -> str:
    """How the clocks were joined."""
    names = " and ".join(shortened(clock.file) for clock in clocks)
    counts = {clock.counts for clock in clocks}
    if len(counts) > 1:
        how = "are joined by a signal that they have in common"
    elif counts == {"from a zero of its own"}:
        early = all(abs(clock.span[0]) <= _ZERO * clock.interval for clock in clocks)
        how = "have clocks that begin at zero: they are taken to have begun at once" if early else (
            "say no dates: their clocks are taken for one")  # fmt: skip
        if all(c.difference is not None for c in common[1:]):
            how = "are joined by a signal that they have in common"
    else:
        how = f"are joined by their {counts.pop()}"
    return f"{names} {how}; {both:.4g} s are in all of them"


def difference_sentence(
    first: FileClock, other: FileClock, name: str, difference: ClockDifference, *, corrected: bool
) -> str:
    """What a signal in two files says about their clocks."""
    before, after = shortened(first.file), shortened(other.file)
    known = np.isfinite(difference.rate_error)
    late = "ahead of" if difference.offset > 0.0 else "behind"
    drift = f", and drifts by {1e6 * difference.rate:.3g} ± {2e6 * difference.rate_error:.2g} ppm"
    words = (
        f"by {shortened(name)}, which both have, the clock of {after} is "
        f"{1e3 * abs(difference.offset):.4g} ± {2e3 * difference.offset_error:.2g} ms {late} that "
        f"of {before}{drift * int(known)}"
    )
    return f"{words}: its times were corrected" if corrected else f"{words}: left as it is"
