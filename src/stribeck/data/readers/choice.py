"""What a channel is taken from: a column, its unit and a factor; and which units fit a channel."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from ...drive import chain_needed
from ...errors import InputError
from ...space import Array
from ...units import Unit, unit
from ..channels import CHANNELS
from .column_map import Entry
from .raw_table import RawTable, shortened

#: Names of columns that are of something that turns.
_TURNS = re.compile(
    r"(?<![^\W_])(q|qm|qd|theta|phi|tau|trq)(?![^\W_])|angle|angul|winkel|rotary|joint|motor|servo|"
    r"spindle|drehzahl|torque|moment|couple|coppia|転|转|トルク|矩"
)
_SPEED_OF_MOTOR = re.compile(r"motor|servo|spindle|drehzahl|転|转")
_ALSO = {"rad/s": "1/s", "rad/s**2": "1/s**2"}  # an angle may go unsaid


@dataclass(frozen=True)
class Choice:
    """The column of a channel: SI value = unit.to_si(factor * cell).

    Args:
        column: Its name in the log.
        unit: Of its cells times the factor.
        factor: A number, or the name of a column or constant.
        reason: Why it was taken, for people.
        dated: Whether its numbers are dates, and the unit a clock's tick.
    """

    column: str
    unit: Unit
    factor: float | str = 1.0
    reason: str = "mapped"
    dated: bool = False

    def entry(self) -> Entry | None:
        """The same as a map has it; None of dates, whose clock is known anew."""
        if self.dated:
            return None
        factor = {} if self.factor == 1.0 else {"factor": self.factor}
        return {"column": self.column, "unit": self.unit.written, **factor}

    @property
    def rotary(self) -> bool:
        """Whether its unit is one of angles."""
        return self.unit.dimension.startswith(("rad", "1/"))

    def values(self, table: RawTable) -> Array:
        """The channel in SI, NaN where a cell is empty.

        Raises:
            InputError: the column has text, or its factor is not there.
        """
        for name in (self.column, self.factor):
            if name in table.text:
                place, cell = table.text[str(name)]
                raise InputError(
                    f"{place}, column {shortened(str(name))}: {shortened(cell)!r} is "
                    "not a number: correct it or empty the cell"
                )
        with np.errstate(over="ignore", invalid="ignore"):  # infinities are refused, with their row
            return np.asarray(self.unit.to_si(_cells(table, self.column) * self._scale(table)))

    def _scale(self, table: RawTable) -> float | Array:
        return _cells(table, self.factor) if isinstance(self.factor, str) else self.factor


def kinds_of(channel: str, *, rotary: bool | None = None) -> tuple[str, ...]:
    """The dimensions that fit a channel, in SI units."""
    if channel == "time":
        return ("s",)
    linear, angular = (unit(u).dimension for u in CHANNELS[channel])
    kinds = {None: (linear, angular), True: (angular,), False: (linear,)}[rotary]
    return kinds + tuple(_ALSO[k] for k in kinds if k in _ALSO)


def unit_of_column(channel: str, column: str, written: str) -> Unit:
    """A unit as a column states it.

    Raises:
        InputError: nobody knows it.
    """
    try:
        return unit(_spelt(channel, written))
    except InputError as error:
        raise InputError(f"column {shortened(column)}: {error}") from error


def known_unit(channel: str, written: str) -> Unit | None:
    """The same, None if nobody knows it."""
    try:
        return unit(_spelt(channel, written))
    except InputError:
        return None


def _spelt(channel: str, written: str) -> str:
    """C is the coulomb, except that nobody logs a temperature in coulombs."""
    return {"C": "degC"}.get(written, written) if channel == "temperature" else written


def refuse_unfit(channel: str, choice: Choice, kinds: tuple[str, ...]) -> None:
    """Refuse a column whose unit does not measure what its channel is.

    Raises:
        InputError: its dimension is none of the kinds.
    """
    if choice.unit.dimension not in kinds:
        column, written = shortened(choice.column), shortened(choice.unit.written)
        if needed := chain_needed(channel, choice.unit.written):
            raise InputError(f"column {column} {needed}")
        raise InputError(
            f"column {column} is in {written or 'no unit'}, which does not measure "
            f"{_kind_words(channel, kinds)}: map it as {channel} = "
            f'{{column = "{column}", factor = ..., unit = "{_unit_among(channel, kinds)}"}}'
        )


def _unit_among(channel: str, kinds: tuple[str, ...]) -> str:
    """The unit that an example shows for a channel of an axis whose kind is known."""
    usual = usual_unit(channel)
    if channel == "time" or unit(usual).dimension in kinds:
        return usual
    return CHANNELS[channel][1]


def _kind_words(channel: str, kinds: tuple[str, ...]) -> str:
    words = {"m": "a length", "rad": "an angle", "s": "time"}
    if channel in ("position", "command", "time"):
        return " or ".join(words[k] for k in kinds)
    return f"the {channel} of {'an angular' if 'rad' in kinds[0] else 'this'} axis"


def usual_unit(channel: str, column: str = "", *, rotary: bool | None = None) -> str:
    """The unit that an example shows for a channel.

    Args:
        channel: Of an axis.
        column: Its column, whose name may say that it turns.
        rotary: Whether the axis turns; None where that is not known.
    """
    if channel == "time":
        return "s"
    if channel == "velocity" and _SPEED_OF_MOTOR.search(column.lower()):
        return "r/min"
    turns = says_turn(column) if rotary is None else rotary
    return {("position", False): "mm", ("command", False): "mm"}.get(
        (channel, turns), CHANNELS[channel][turns]
    )


def says_turn(column: str) -> bool:
    """Whether the name of a column is one of an axis that turns."""
    return _TURNS.search(column.lower()) is not None


def _cells(table: RawTable, name: str) -> Array:
    return (
        table.columns[name]
        if name in table.columns
        else np.full(len(table.places), table.scalars[name])
    )
