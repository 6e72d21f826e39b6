"""A known quantity of a rig: its value, where that comes from, and how far it can be trusted."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from typing import Literal, Self

from .errors import InputError
from .units import number, unit

#: Who vouches for a value: the user; the maker of a part of the axis; the source of the rig, whose
#: machine it is of; an inference where that source is silent; nobody, as it is an example that the
#: user is to replace; other constants, from which it follows; a standard; or nobody again, where
#: it is no quantity of the axis but a setting of the simulation.
Origin = Literal[
    "yours", "nameplate", "the paper", "inferred", "example", "derived", "standard", "setting"
]

#: Tolerance of a value that was not given for this axis, as a share of it: of another machine of
#: the kind, of a quantity that even there was inferred, and of an example.
BORROWED: dict[Origin, float] = {"the paper": 0.1, "inferred": 0.5, "example": 0.5}
#: Tolerance of a value on a nameplate or in a catalogue, as a share of it: what makers of servo
#: motors state, as a rule, of torque constants and resistances.
NAMEPLATE = 0.1
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
    """

    name: str
    value: float
    unit: str
    doc: str
    source: str
    origin: Origin = "setting"
    tolerance: float = 0.0

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
        return replace(
            self,
            value=float(written.to_si(shown)),
            tolerance=tolerance * written.factor,
            source="given" if origin == "yours" else f"its {origin}",
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
) -> Constant:
    """A constant in the unit people see.

    Its tolerance is a share of its value: by default what its origin has, 0 for what is counted.
    """
    value = float(unit(written).to_si(shown))
    tolerance = (BORROWED.get(origin, 0.0) if share is None else share) * abs(value)
    return Constant(name, value, written, doc, source, origin, tolerance)


#: What a value with a tolerance is called where there is none.
_WRITTEN = "a number, nor VALUE±TOLERANCE"
_NAMEPLATE: Origin = "nameplate"
_TOLERANCE = re.compile(r"(.+?)(?:±|\+/?-)([^%]+)(%?)")


def toleranced(text: str, place: str) -> tuple[float, float, Origin]:
    """A value, its tolerance and its origin as people write them.

    `20` is exact; `20±5`, `20+-5` and `20±10%` are not; `20 nameplate` has the tolerance of such
    values, `20±5 nameplate` its own.

    Args:
        text: What was written.
        place: Where, for the message.

    Raises:
        InputError: it is not that.
    """
    quantity = text.strip().removesuffix(_NAMEPLATE)
    origin: Origin = "yours" if quantity == text.strip() else _NAMEPLATE
    match = _TOLERANCE.fullmatch("".join(quantity.split()))
    if match is None:
        value = number(quantity, place, whole=text, kind=_WRITTEN)
        return value, NAMEPLATE * abs(value) if origin == _NAMEPLATE else 0.0, origin
    value, tolerance = (
        number(part, place, whole=text, kind=_WRITTEN) for part in match.group(1, 2)
    )
    if tolerance < 0:
        raise InputError(f"{place}: {text!r}: a tolerance is not below 0")
    return value, tolerance * abs(value) / 100 if match[3] else tolerance, origin
