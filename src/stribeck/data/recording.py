"""What was measured: the channels of one log, in SI, checked and read-only."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import Any, Self

import numpy as np

from ..drive import DriveChain
from ..errors import InputError
from ..presenters import presenter
from ..space import Array
from ..units import unit
from .channels import CHANNELS, LARGEST
from .frames import Frame, frame_table
from .known_force import KnownForce
from .power_flow import loss_factors
from .readers.assembly import assembled
from .readers.choice import known_unit, unit_of_column
from .readers.heads import named_by_stem, take_apart
from .readers.log_file import TablesInMemory
from .readers.log_map import LogMap
from .readers.raw_table import listed, printable, shortened
from .steady_runs import SteadyRuns


def _is_sealed(base: object) -> bool:
    """Whether what an array looks into is an array of a recording, which nobody writes to."""
    return isinstance(base, np.ndarray) and base.base is None and not base.flags.writeable


@dataclass(frozen=True)
class Source:
    """Where a recording came from, so that a card can say so.

    Args:
        file: File name without its folder, with its window if a part was read; empty for arrays
            from memory.
        sha256: Hash of the file's bytes; empty for arrays from memory.
        rows: Rows of data in the file.
        map: How it was read, as `read` takes it for `columns`; empty where heads said it all.
    """

    file: str = ""
    sha256: str = ""
    rows: int = 0
    map: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, eq=False, repr=False)
class Recording:
    """One log of one axis, SI units, arrays read-only and of one length.

    Args:
        t: Time, s, strictly increasing.
        position: Measured position, m (rad if `rotary`).
        command: Commanded position, as `position`; None if not recorded.
        velocity: Measured velocity.
        acceleration: Measured acceleration.
        force: Force (torque) of the drive on the axis, N (N m).
        current: Motor current, A.
        voltage: Controller output or motor voltage, V.
        temperature: K.
        pressure: Gauge pressure in a cylinder, Pa.
        back_pressure: That in its other chamber, which drives the rod back, Pa.
        extra: Further numeric columns by their name in the log, as written there.
        rotary: Whether position is an angle.
        source: The file it was read from.
        notes: What was mended on the way in, a sentence each.
        drive: The chain by which the force was made of what the drive recorded; None where the
            force was measured as such.
        runs: Set where this is a table of runs at constant speed: a row is a run, its velocity
            and force are means, its position is 0, and t counts the runs.
        known_force: A force that is taken off the measured one before friction is looked for.

    Raises:
        InputError: fewer than two samples, lengths that differ, a value that is not finite or
            beyond all measure, or time that does not increase.
    """

    t: Array
    position: Array
    command: Array | None = None
    velocity: Array | None = None
    acceleration: Array | None = None
    force: Array | None = None
    current: Array | None = None
    voltage: Array | None = None
    temperature: Array | None = None
    pressure: Array | None = None
    extra: Mapping[str, Array] = field(default_factory=dict)
    rotary: bool = False
    source: Source = field(default_factory=Source)
    notes: tuple[str, ...] = ()
    drive: DriveChain | None = None
    runs: SteadyRuns | None = None
    known_force: KnownForce | None = None
    back_pressure: Array | None = None

    def __post_init__(self) -> None:
        for name in ("t", *CHANNELS):
            if getattr(self, name) is not None:
                values = self._checked(name, getattr(self, name))
                if max(values.max(), -values.min()) > LARGEST:
                    raise InputError(
                        f"{self.label}: {name} has values beyond {LARGEST:g}: check its unit, or "
                        "leave out the rows that mark missing values"
                    )
                object.__setattr__(self, name, values)
        extra = {name: self._checked(name, a) for name, a in self.extra.items()}
        object.__setattr__(self, "extra", MappingProxyType(extra))
        if self.known_force is not None:
            known = self.known_force
            values = self._checked(known.column, known.values)
            object.__setattr__(self, "known_force", KnownForce(known.column, values))
        if not (self.t[1:] > self.t[:-1]).all():
            raise InputError(f"{self.label}: time does not increase")

    def _checked(self, name: str, values: Array) -> Array:
        a = np.asarray(values, dtype=float)
        own = not a.flags.writeable and (a.base is None or _is_sealed(a.base))
        if not (own and a.flags.c_contiguous):
            a = a.copy()  # nobody else may write to it, and compiled code reads it in order
        if a.ndim != 1 or len(a) != len(self.t) or len(a) < 2:  # noqa: PLR2004 - a motion needs two
            raise InputError(f"{self.label}: {name} has shape {a.shape}, time {np.shape(self.t)}")
        if not np.isfinite(a).all():
            raise InputError(f"{self.label}: {name} has values that are not finite")
        a.setflags(write=False)
        return a

    @classmethod
    def of(
        cls,
        frame: Frame,
        *,
        units: Mapping[str, str] | None = None,
        columns: Mapping[str, Any] | str | Path | None = None,
        drive: DriveChain | Mapping[str, Any] | None = None,
        subtract: str | None = None,
        lenient: bool = False,
        name: str = "",
    ) -> Self:
        """A log in memory: a frame of polars or pandas, a dict of columns, a named array.

        Its columns are known, mended and refused as those of a file are: by heads such as
        `position_mm`, or by what is said here.

        Args:
            frame: Columns of equal length, (N,) each.
            units: Unit by column, as in `{"t": "s", "x": "mm"}`, where the heads do not say it.
            columns: Column by channel, as in `{"position": "x"}`, where the heads do not say it;
                as `read` takes it.
            drive: As for `read`.
            subtract: As for `read`.
            lenient: As for `read`.
            name: How messages and cards call it.

        Raises:
            InputError: the frame cannot be used as a log; the line says why, and what to do.
        """
        try:
            table = frame_table(frame)
            used = LogMap.of(columns).with_words({"subtract": subtract}).driven(drive)
            assembly = assembled(TablesInMemory((table,)), used, units=units, lenient=lenient)
            source = Source(printable(name), "", assembly.rows)
            recording = cls(**assembly.arguments, source=source)
            if used.drive is None or not assembly.signal:
                return recording
            return recording.through(used.drive, assembly.signal)
        except InputError as error:
            label = f"{printable(name)}: " * bool(name)
            raise type(error)(printable(f"{label}{str(error).removeprefix(label)}")) from error

    def through(self, chain: DriveChain, column: str = "") -> Self:
        """The same log behind a drive: its force was the signal times the gain of the chain.

        Args:
            chain: The drive's; its losses are still to be taken off.
            column: The signal's head, for the note.

        Raises:
            InputError: it has no force, or one that a chain has been applied to.
        """
        if self.drive is not None:
            raise InputError(
                f"{self.label}: its force came through a drive chain already: apply it once"
            )
        if self.force is None:
            raise InputError(
                f"{self.label}: no column is the drive's {chain.signal.text}: map it, as in "
                f'force = "head [{chain.signal.unit}]"'
            )
        share = loss_factors(chain, self.t, self.position, self.velocity, self.force)
        notes = (*self.notes, chain.sentence(column))
        with np.errstate(over="ignore"):  # what is beyond all numbers is refused as such
            force = self.force * share
        return replace(self, force=force, drive=chain, notes=notes)

    def less(self, column: str) -> Self:
        """The same log with one of its other columns to be taken off the force.

        Args:
            column: Its head in `extra`, with the unit if that does not say it: `tau_rigid [N m]`.

        Raises:
            InputError: it has no force or no such column, or the unit is none of a force.
        """
        if self.force is None:
            raise InputError(f"{self.label}: it has no force to subtract {shortened(column)} from")
        name = column if column in self.extra else named_by_stem(column, self.extra)
        if name is None:
            raise InputError(
                f"{self.label}: subtract: there is no column {shortened(column)!r}: there are "
                f"{listed(dict(self.extra)) or 'none beside its channels'}"
            )
        currents = self.drive is not None and self.drive.unit == "A"
        usual = "A" if currents else CHANNELS["force"][self.rotary]
        stated = take_apart(column).unit or take_apart(name).unit
        if stated is None:
            raise InputError(
                f"{self.label}: subtract: column {shortened(name)} has no unit: write it as "
                f'"{shortened(name)} [{usual}]"'
            )
        written = unit_of_column("force", name, stated)
        if written.dimension != unit(usual).dimension:
            raise InputError(
                f"{self.label}: column {shortened(name)} is in {written.written}, and the force in "
                f"{usual}: subtract a force"
            )
        known = KnownForce.of(name, written, np.asarray(written.to_si(self.extra[name])))
        return replace(self, known_force=known, notes=(*self.notes, known.sentence))

    def further(self, column: str, si: str) -> Array:
        """One of its other columns, (N,), in an SI unit.

        A unit in the head is converted from; without one, and where the quantity is a number alone,
        values count as they are written.

        Args:
            column: Its head in `extra`.
            si: The unit of what it is read as; empty for a number alone.

        Raises:
            InputError: its unit is of another dimension.
        """
        values = self.extra[column]
        stated = take_apart(column).unit
        written = None if stated is None else known_unit("", stated)
        if written is not None and written.dimension == unit(si).dimension:
            with np.errstate(over="ignore"):
                values = np.asarray(written.to_si(values))
            if not np.isfinite(values).all():
                raise InputError(f"{self.label}: column {shortened(column)}: is beyond all numbers")
            return values
        if stated is not None and si and column.rstrip().endswith(("]", ")")):
            raise InputError(
                f"{self.label}: column {shortened(column)} is in {stated}, and what is read from "
                f"it in {si}"
            )
        return values

    def ends_of(self, column: str, si: str) -> tuple[float, float, float]:
        """Least, median and greatest of one of its other columns, as `further` reads it."""
        key = (column, si)
        if key not in self._ends:
            low, middle, high = np.percentile(self.further(column, si), (0.0, 50.0, 100.0)).tolist()
            self._ends[key] = low, middle, high
        return self._ends[key]

    @cached_property
    def _ends(self) -> dict[tuple[str, str], tuple[float, float, float]]:
        """What `ends_of` has looked up: a log of many segments is asked for each."""
        return {}

    def __len__(self) -> int:
        return len(self.t)

    def __repr__(self) -> str:
        seconds, names = self.t[-1] - self.t[0], ", ".join(self.channels())
        if self.runs is not None:
            return f"<Recording {self.label}: {len(self)} runs at constant speed>"
        return f"<Recording {self.label}: {len(self)} samples in {seconds:.4g} s, {names}>"

    def _repr_html_(self) -> str:
        return str(presenter("recording_html")(self))

    @property
    def label(self) -> str:
        """How messages name it."""
        return self.source.file or "recording"

    @cached_property
    def dt(self) -> float:
        """Median sampling interval, s."""
        return float(np.median(np.diff(self.t)))

    def si_unit(self, channel: str) -> str:
        """The SI unit of a channel; a force is in A where its drive has no torque constant."""
        if channel == "force" and self.drive is not None:
            return self.drive.unit
        return CHANNELS[channel][self.rotary]

    def channels(self) -> dict[str, Array]:
        """The named channels that were recorded, position first."""
        return {n: getattr(self, n) for n in CHANNELS if getattr(self, n) is not None}

    def cut(self, rows: slice) -> Recording:
        """The samples of a slice, as a recording of its own."""
        channels = {
            f.name: getattr(self, f.name)[rows]
            for f in fields(self)
            if f.name in ("t", *CHANNELS) and getattr(self, f.name) is not None
        }
        runs = None if self.runs is None else self.runs.cut(rows)
        known = None if self.known_force is None else self.known_force.cut(rows)
        extra = {n: a[rows] for n, a in self.extra.items()}
        return replace(self, **channels, extra=extra, runs=runs, known_force=known)
