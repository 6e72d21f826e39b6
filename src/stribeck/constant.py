"""A known quantity of a rig: its value, where that comes from, and how far it can be trusted."""

from __future__ import annotations

import math
import re
import sys
from dataclasses import dataclass, replace
from typing import Literal, Self

from .errors import InputError
from .units import number, unit

#: Who vouches for a value: the user; the maker of a part of the axis; the source of the rig, whose
#: machine it is of; an inference where that source is silent; nobody, as it is an example that the
#: user is to replace; other constants, from which it follows; a standard; a count, as of teeth; or
#: nobody again, where it is no quantity of the axis but a setting of the simulation.
Origin = Literal[
    "yours",
    "nameplate",
    "the paper",
    "inferred",
    "example",
    "derived",
    "standard",
    "counted",
    "setting",
]

#: Tolerance of a value that was not given for this axis, as a share of it: of another machine of
#: the kind, of a quantity that even there was inferred, and of an example.
BORROWED: dict[Origin, float] = {"the paper": 0.1, "inferred": 0.5, "example": 0.5}
#: Tolerance of a value on a nameplate or in a catalogue, as a share of it: what makers of servo
#: motors state, as a rule, of torque constants and resistances.
NAMEPLATE = 0.1
#: Source of a constant that the user has set.
GIVEN = "given"
#: The least value of what has to be above zero.
SMALLEST = sys.float_info.min
#: A tolerance is twice a standard deviation (an expanded uncertainty with k = 2).
COVERAGE = 2.0


#: A constant as a person gives it: exact; with a tolerance; and with who vouches for it.
Stated = float | tuple[float, float] | tuple[float, float, Origin]


@dataclass(frozen=True)
class Constant:
    """A known quantity of a rig.

    Args:
        name: As the source names it.
        value: In SI (units are converted where a person reads or writes them).
        unit: The unit in which people see it and `--set` reads it.
        doc: Its meaning.
        source: Where the value comes from, for a reader.
        origin: Who vouches for it.
        tolerance: By how much the true value may differ from it, SI: twice a standard deviation;
            0 where it is exact.
        least: The least value with which something can be simulated, SI.
    """

    name: str
    value: float
    unit: str
    doc: str
    source: str
    origin: Origin = "setting"
    tolerance: float = 0.0
    least: float = -math.inf

    @property
    def shown(self) -> float:
        """The value in the unit people see."""
        return float(unit(self.unit).from_si(self.value))

    @property
    def shown_tolerance(self) -> float:
        """The tolerance in the unit people see."""
        return self.tolerance / unit(self.unit).factor

    @property
    def standard_deviation(self) -> float:
        """Of what is known of the value beforehand, SI; 0 where it is exact."""
        return self.tolerance / COVERAGE

    def with_value(self, shown: float, tolerance: float = 0.0, origin: Origin = "yours") -> Self:
        """The same quantity as the user gives it, in the unit people see, or its maker.

        Raises:
            InputError: a tolerance of what is no quantity of the axis.
        """
        if tolerance and self.origin == "setting":
            raise InputError(f"{self.name} is a setting of the simulation: it has no tolerance")
        written = unit(self.unit)
        if not math.isfinite(tolerance):
            raise InputError(f"{self.name}: its tolerance is no finite number")
        return replace(
            self,
            value=float(written.to_si(shown)),
            tolerance=tolerance * written.factor,
            source=GIVEN if origin == "yours" else f"its {origin}",
            origin=self.origin if self.origin == "setting" else origin,
        )

    def exact(self) -> Self:
        """The same value, taken as exact."""
        return replace(self, tolerance=0.0)


def constant(
    name: str,
    shown: float,
    written: str,
    doc: str,
    source: str,
    origin: Origin = "setting",
    share: float | None = None,
    least: float = -math.inf,
) -> Constant:
    """A constant in the unit people see; `least` is SI.

    Its tolerance is a share of its value: by default what its origin has, 0 for what is counted.
    """
    value = float(unit(written).to_si(shown))
    tolerance = (BORROWED.get(origin, 0.0) if share is None else share) * abs(value)
    return Constant(name, value, written, doc, source, origin, tolerance, least)


def out_of_limits(value: float, least: float, most: float) -> str:
    """What is wrong with a value that has limits, or nothing."""
    if math.isnan(value):
        return "is no number"
    if value < least:
        if least == SMALLEST:
            return "must be above zero"
        return f"must not be below {least:g}"
    return f"must not be above {most:g}" if value > most else ""


#: What a value with a tolerance is called where there is none.
_WRITTEN = "a number, nor VALUE±TOLERANCE"
_NAMEPLATE: Origin = "nameplate"
#: A quantity is a line, not a page: a pattern may take the square of its length.
_LONGEST, _QUANTITY = 500, "a number with its unit, tolerance and source"
_SOURCED = re.compile(r"(.*\S)\s+\(([^()]+)\)\s*")
_SPLIT = re.compile(r"±|\+/?-")
_NUMBER = re.compile(
    r"([+-]?(?:\d+[.,]?\d*|[.,]\d+)(?:[eE][+-]?\d+)?|[+-]?[A-Za-z]+)\s*([^\d\s+-].*)?"
)


@dataclass(frozen=True)
class Quantity:
    """A number as a person writes it, with all that he says of it.

    Args:
        value: In `unit`.
        unit: As written; empty where there is none.
        tolerance: In `unit`; 0 where it is exact.
        origin: Who vouches for it.
        source: Where it stands, in words; empty where that is not said.
    """

    value: float
    unit: str = ""
    tolerance: float = 0.0
    origin: Origin = "yours"
    source: str = ""


def quantity(text: str, place: str, kind: str = _WRITTEN) -> Quantity:
    """A quantity as people write it: a value, its unit, tolerance, origin and source.

    `20` is exact; `20±5`, `20+-5` and `20±10%` are not; `20 nameplate` has the tolerance of such
    values, `20±5 nameplate` its own; `0.52 Nm/A ± 5 % (data sheet)` has a unit and a source.

    Args:
        text: What was written.
        place: Where, for the message.
        kind: What it is not, in the message, where it is none.

    Raises:
        InputError: it is not that.
    """
    if len(text) > _LONGEST:
        raise InputError(f"{place}: {text[:40]!r}... is too long for {_QUANTITY}")
    stated = _SOURCED.fullmatch(text)
    source = stated[2].strip() if stated else ""
    plain = (stated[1] if stated else text).strip()
    numbers = plain.removesuffix(_NAMEPLATE).strip()
    origin: Origin = "yours" if numbers == plain else _NAMEPLATE
    parts = _SPLIT.split(numbers)
    value, written = _split(parts[0], place, text, kind)
    if len(parts) == 1:
        tolerance = NAMEPLATE * abs(value) if origin == _NAMEPLATE else 0.0
        return Quantity(value, written, tolerance, origin, source)
    if len(parts) > 2:  # noqa: PLR2004 - a value and its tolerance
        raise InputError(f"{place}: {text!r} has two tolerances")
    tolerance, after = _split(parts[1], place, text, kind)
    if tolerance < 0:
        raise InputError(f"{place}: {text!r}: a tolerance is not below 0")
    relative = after.startswith("%") and written != "%"
    after = after[1:].strip() if relative else after
    if relative:
        tolerance *= abs(value) / 100
    if after and written and after != written:
        raise InputError(f"{place}: {text!r} is in {written}, and its tolerance in {after}")
    return Quantity(value, written or after, tolerance, origin, source)


def _split(part: str, place: str, whole: str, kind: str) -> tuple[float, str]:
    """A number and the unit behind it."""
    match = _NUMBER.fullmatch(part.strip())
    if match is None:
        raise InputError(f"{place}: {whole!r} is not {kind}")
    return number(match[1], place, whole=whole, kind=kind), (match[2] or "").strip()


def toleranced(text: str, place: str, kind: str = _WRITTEN) -> tuple[float, float, Origin]:
    """A value, its tolerance and its origin as `quantity` reads them, without a unit.

    Args:
        text: What was written.
        place: Where, for the message.
        kind: What it is not, in the message, where it is none.

    Raises:
        InputError: it is not that.
    """
    stated = quantity(text, place, kind)
    if stated.unit or stated.source:
        raise InputError(f"{place}: {text!r} is not {kind}")
    return stated.value, stated.tolerance, stated.origin
