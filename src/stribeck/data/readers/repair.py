"""Repairs of a log that are made and reported, and faults that are refused with their place."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ...errors import InputError
from ...space import Array
from ..runs import slices
from .raw_table import RawTable, shortened

#: Longest run of empty cells that is interpolated, in samples.
SHORT_GAP = 5
#: Largest share of a channel's samples that is interpolated.
FEW = 0.02
#: Largest share of rows that may repeat a time stamp.
REPEATS = 0.2
#: Fewest samples that make a log.
FEWEST = 10
_IRREGULAR = 0.25  # of the median interval


@dataclass
class Mender:
    """The rows of a log while they are put right.

    Args:
        table: Where they stand.
        channels: Time first, then the channels, SI, (N,).
        extra: Other columns as written, (N,).
        notes: What was done, a sentence each.
    """

    table: RawTable
    channels: dict[str, Array]
    extra: dict[str, Array]
    notes: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.rows: NDArray[np.int64] | range = range(len(self.channels["time"]))

    def mend(self) -> None:
        """All of it, in order.

        Raises:
            InputError: infinities, time that goes back or stands, long gaps, too few samples, or
                a position that never changes.
        """
        self._infinite()
        self._unwritten()
        self._ends()
        self._untimed()
        self._enough()
        self._order()
        self._stopped()
        self._repeats()
        self._edges()
        self._gaps()
        self._extra()
        self._enough()
        self._still()
        self._jitter()

    def _keep(self, rows: NDArray[np.bool_] | slice) -> None:
        self.rows = self.rows[rows] if isinstance(rows, slice) else np.asarray(self.rows)[rows]
        self.channels = {n: a[rows] for n, a in self.channels.items()}
        self.extra = {n: a[rows] for n, a in self.extra.items()}

    def _infinite(self) -> None:
        for name, a in self.channels.items():
            if (infinite := np.isinf(a)).any():
                raise InputError(f"{self._place(infinite)}: {name} is infinite: empty the cell or "
                                 "drop the row")  # fmt: skip

    def _unwritten(self) -> None:
        """A channel that is empty throughout was not recorded; a row that is empty is none."""
        for name in [n for n, a in self.channels.items() if np.isnan(a).all()]:
            if name in ("time", "position"):
                raise InputError(f"the {name} column is empty")
            del self.channels[name]
            self.notes.append(f"the {name} column is empty and was left out")
        empty = np.logical_and.reduce([np.isnan(a) for a in self.channels.values()])
        if empty.any():  # else nothing is copied
            self._keep(~empty)

    def _ends(self) -> None:
        finite = ~np.isnan(self.channels["time"]) & ~np.isnan(self.channels["position"])
        if not finite.any():
            raise InputError("no row has both time and position")
        first, last = int(finite.argmax()), len(finite) - int(finite[::-1].argmax())
        self._trim(first, last, "time or position")

    def _edges(self) -> None:
        """Rows at the ends where a channel is not there yet, or no more."""
        first, last = 0, len(self.rows)
        for name, a in self.channels.items():
            finite = ~np.isnan(a)
            if not finite.any():
                raise InputError(f"{name} is empty wherever time and position are not")
            begins, stop = int(finite.argmax()), len(a) - int(finite[::-1].argmax())
            if max(begins, len(a) - stop) > SHORT_GAP:
                at = (0, begins - 1) if begins > len(a) - stop else (stop, len(a) - 1)
                self._refuse_gap(name, *at)
            first, last = max(first, begins), min(last, stop)
        self._trim(first, last, "a channel")

    def _trim(self, first: int, last: int, reason: str) -> None:
        if cut := len(self.rows) - (last - first):
            self.notes.append(f"{_count(cut, 'row')} without {reason} trimmed at the ends")
            self._keep(slice(first, last))

    def _untimed(self) -> None:
        untimed = np.isnan(self.channels["time"])
        if (n := int(untimed.sum())) > max(SHORT_GAP, FEW * len(untimed)):
            raise InputError(f"time is empty in {n} of {len(untimed)} rows, first in "
                             f"{self._place(untimed)}: fill it in")  # fmt: skip
        if n:
            self.notes.append(f"{_count(n, 'row')} without a time stamp dropped")
            self._keep(~untimed)

    def _order(self) -> None:
        t = self.channels["time"]
        if (t == t[0]).all():
            raise InputError(f"time stands still at {t[0]:g} s in all {len(t)} rows")
        backwards = np.diff(t, prepend=t[0]) < 0
        if backwards.any():
            i = int(backwards.argmax())
            raise InputError(f"{self._place(backwards)}: time goes back from {t[i - 1]:.9g} to "
                             f"{t[i]:.9g} s: sort the log or split it there")  # fmt: skip

    def _stopped(self) -> None:
        """A logger that is shut down may go on writing rows while its clock no longer runs."""
        t = self.channels["time"]
        first = int(np.searchsorted(t, t[-1]))
        if (n := len(t) - 1 - first) > SHORT_GAP:
            self.notes.append(f"{_count(n, 'row')} after the clock stopped at {t[-1]:g} s dropped")
            self._keep(slice(0, first + 1))

    def _repeats(self) -> None:
        t = self.channels["time"]
        repeated = np.diff(t, prepend=-np.inf) == 0
        n = int(repeated.sum())
        if not n:
            return
        if n > REPEATS * len(t):
            raise InputError(f"{n} of {len(t)} rows repeat the time stamp before them, first in "
                             f"{self._place(repeated)}: record time finer")  # fmt: skip
        identical = repeated.copy()
        for a in (*self.channels.values(), *self.extra.values()):
            b = np.roll(a, 1)
            identical &= (a == b) | (np.isnan(a) & np.isnan(b))
        if exact := int(identical.sum()):
            self.notes.append(f"{_count(exact, 'exact duplicate row')} dropped")
        if n > exact:
            self.notes.append(f"{_count(n - exact, 'row')} with a repeated time stamp dropped")
        self._keep(~repeated)

    def _gaps(self) -> None:
        for name, a in self.channels.items():
            n = int(np.isnan(a).sum())
            if not n:
                continue
            for gap in slices(np.isnan(a)):
                if gap.stop - gap.start > SHORT_GAP:
                    self._refuse_gap(name, gap.start, gap.stop - 1)
            if n > max(FEW * len(a), 1):
                raise InputError(f"{name} is empty in {n} of {len(a)} rows, first in "
                                 f"{self._place(np.isnan(a))}: more than {FEW:.0%} is not "
                                 "interpolated")  # fmt: skip
            self.channels[name] = self._filled(a)
            self.notes.append(f"{_count(n, f'empty {name} value')} interpolated")

    def _refuse_gap(self, name: str, first: int, last: int) -> None:
        lines = f"{self.table.place(int(self.rows[first]))} to {self.table.places[self.rows[last]]}"
        raise InputError(f"{name} is empty in {lines}: more than {SHORT_GAP} samples are not "
                         "interpolated: cut the log there")  # fmt: skip

    def _extra(self) -> None:
        """Columns nobody asked for: never a reason to refuse a log."""
        for name, a in list(self.extra.items()):
            invalid = ~np.isfinite(a)
            longest = max((gap.stop - gap.start for gap in slices(invalid)), default=0)
            if longest > SHORT_GAP or invalid.sum() > max(FEW * len(a), 1):
                del self.extra[name]
                self.notes.append(f"column {shortened(name)} left out: it has gaps")
            elif invalid.any():
                self.extra[name] = self._filled(np.where(invalid, np.nan, a))
                self.notes.append(
                    f"{_count(int(invalid.sum()), f'empty {shortened(name)} value')} interpolated"
                )

    def _filled(self, a: Array) -> Array:
        t, finite = self.channels["time"], ~np.isnan(a)
        return np.where(finite, a, np.interp(t, t[finite], a[finite]))

    def _enough(self) -> None:
        if len(self.rows) < FEWEST:
            raise InputError(f"has {_count(len(self.rows), 'usable sample')}, {FEWEST} are needed")

    def _still(self) -> None:
        x = self.channels["position"]
        if (x == x[0]).all():
            raise InputError(f"nothing moves: position is the same in all {len(x)} rows")

    def _jitter(self) -> None:
        dt = np.diff(self.channels["time"])
        low, middle, high = np.quantile(dt, [0.05, 0.5, 0.95])
        if max(high - middle, middle - low) > _IRREGULAR * middle:
            self.notes.append(f"sampling is irregular and kept so: 90 % of the intervals last "
                              f"{low * 1e3:.3g} to {high * 1e3:.3g} ms, half of them more than "
                              f"{middle * 1e3:.3g} ms")  # fmt: skip

    def _place(self, rows: NDArray[np.bool_]) -> str:
        return self.table.place(int(self.rows[int(rows.argmax())]))


def filled_extra(table: RawTable, used: set[str]) -> dict[str, Array]:
    """The columns that became no channel, as written, and single numbers as constant columns."""
    n = len(table.places)
    columns: Mapping[str, Array] = {
        **table.columns,
        **{name: np.full(n, value) for name, value in table.scalars.items()},
    }
    return {name: a for name, a in columns.items()
            if name not in used and name not in table.text and not np.isnan(a).all()}  # fmt: skip


def _count(n: int, noun: str) -> str:
    return f"{n} {noun}{'s' * (n != 1)}"
