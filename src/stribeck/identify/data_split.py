"""What an identification trains on and what it holds out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from ..data.alignment import Delay, checked_delay
from ..data.gate import mended
from ..data.log_list import Columns, Logs, log_list
from ..data.ranges import Range
from ..errors import InputError

if TYPE_CHECKING:
    from ..data.recording import Recording
    from ..rig import Rig


@dataclass(frozen=True, eq=False)
class DataSplit:
    """Recordings, and the ranges of them that are trained on and held out.

    Args:
        recordings: The logs.
        train: Ranges to train on; none means everything.
        holdout: Ranges to validate on.
        delay: By how much the drive of the recordings has been moved back already, s.
        delay_known: How well that is known beforehand, as a standard deviation, s; None where
            nobody has said anything of it.
    """

    recordings: tuple[Recording, ...]
    train: tuple[Range, ...]
    holdout: tuple[Range, ...]
    delay: float = 0.0
    delay_known: float | None = None

    def advanced(self, rig: Rig, seconds: float) -> DataSplit:
        """The same with the drive of a rig moved back by so much more.

        Raises:
            InputError: a log has no force, or nothing is left of it.
        """
        if not seconds:
            return self
        logs = tuple(rig.in_step(log, seconds) for log in self.recordings)
        return replace(self, recordings=logs, delay=self.delay + seconds)

    @property
    def ranges(self) -> tuple[Range, ...]:
        """All ranges, those to train on first."""
        return (*self.train, *self.holdout)


def data_split(
    logs: Logs,
    train: Sequence[Range | str] | Range | str | None,
    holdout: Sequence[Range | str] | Range | str | None,
    rig: Rig,
    *,
    units: Mapping[str, str] | None = None,
    columns: Columns = None,
    subtract: str | None = None,
) -> DataSplit:
    """The data as callers give them: one or several logs, ranges as written or ready.

    Raises:
        InputError: there is no log, one cannot be used, or a range cannot be read.
    """
    return DataSplit(
        tuple(recording_list(logs, rig, units=units, columns=columns, subtract=subtract)),
        tuple(range_list(train, rig)),
        tuple(range_list(holdout, rig)),
    )


def recording_list(
    logs: Logs,
    rig: Rig | None = None,
    *,
    units: Mapping[str, str] | None = None,
    columns: Columns = None,
    subtract: str | None = None,
) -> list[Recording]:
    """One or several logs as a list, what is certainly wrong in them put right and told.

    Args:
        logs: Recordings, paths or frames.
        rig: Whose logs have columns of their own.
        units: As `log_list` takes them.
        columns: The same.
        subtract: The same.
    """
    usual, drive = (None, None) if rig is None else (rig.columns, rig.chain)
    recordings = log_list(
        logs, units=units, columns=columns, usual=usual, subtract=subtract, drive=drive
    )
    if rig is not None and rig.approach != "force_balance":
        refuse_runs(recordings, f"rig {rig.name}")
    for log in recordings:
        if rig is not None and log.known_force is not None and not rig.rests_on_force:
            raise InputError(
                f"{log.label}: {log.known_force.column} is to be subtracted from the force, by "
                f"which rig {rig.name} does not go: leave subtract out"
            )
    return [mended(recording) for recording in recordings]


def log_notes(recordings: Sequence[Recording]) -> tuple[str, ...]:
    """How logs were read and what was mended in them, a sentence each: no warnings."""
    sentences = (f"{log.label}: {note}" for log in recordings for note in log.notes)
    return tuple(dict.fromkeys(sentences))


def steady_tables(
    recordings: Sequence[Recording], ranges: Sequence[Range], delay: Delay, velocity: str = "auto"
) -> bool:
    """Whether logs are tables of steady speeds.

    Args:
        recordings: The logs.
        ranges: All that were asked for.
        delay: Of the force after the motion, as it was asked for.
        velocity: Where it comes from, as it was asked for.

    Raises:
        InputError: some are and some are not, or something was asked of tables that they lack.
    """
    tables = [log for log in recordings if log.runs is not None]
    if tables and len(tables) < len(recordings):
        raise InputError("tables of steady speeds and logs of motions: identify each by itself")
    if tables and (ranges or velocity != "auto" or not isinstance(checked_delay(delay), str)):
        raise InputError(
            f"{tables[0].label}: is a table of steady speeds, which has no positions or times: "
            "leave out ranges, delays and where the velocity comes from"
        )
    return bool(tables)


def refuse_runs(recordings: Sequence[Recording], purpose: str) -> None:
    """Refuse tables of steady speeds where a motion is needed.

    Args:
        recordings: The logs.
        purpose: What needs it, as in `rig slide-bed`.

    Raises:
        InputError: one of them is such a table.
    """
    for log in recordings:
        if log.runs is not None:
            raise InputError(
                f"{log.label}: is a table of steady speeds, without a motion, and {purpose} needs "
                "the log of one: give its samples with their times"
            )


def range_list(ranges: Sequence[Range | str] | Range | str | None, rig: Rig) -> list[Range]:
    """Ranges as written or ready, as a list."""
    if ranges is None:
        return []
    if isinstance(ranges, Range | str):
        ranges = [ranges]
    shown = rig.shows.get("position", "m")
    if not all(isinstance(g, Range | str) for g in ranges):
        raise InputError(f"range {ranges!r}: write it as '112:295' ({shown}) or '10s:40s'")
    return [g if isinstance(g, Range) else Range.parse(g, shown) for g in ranges]


def ranges_or_all(
    ranges: Sequence[Range | str] | Range | str | None, rig: Rig
) -> list[Range | None]:
    """The same, with None, which is everything, where no range was given."""
    return [*range_list(ranges, rig)] or [None]
