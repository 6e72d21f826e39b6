"""Units at the boundary: SI inside, whatever people write outside (pint reads it)."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any

from .errors import InputError

if TYPE_CHECKING:
    import pint

#: Spellings that people use in column heads and that pint would read otherwise or not at all.
_SPELLINGS = {
    "": "dimensionless",
    "1": "dimensionless",
    "-": "dimensionless",
    "%": "percent",
    "Nm": "N m",
    "mNm": "mN m",
    "kNm": "kN m",
    "Ns": "N s",
    "°": "deg",
    "°/s": "deg/s",
    "degC": "degC",
    "°C": "degC",
    "g": "gram",
    "rpm": "rpm",
}


@dataclass(frozen=True)
class Unit:
    """A unit as it is written, its factor and offset to SI, and its SI dimension.

    `si = factor * value + offset`; the offset is other than zero for temperatures alone.
    """

    written: str
    factor: float
    offset: float
    dimension: str

    def to_si(self, value: Any) -> Any:
        """A value (or array) in this unit as SI."""
        return value * self.factor + self.offset if self.offset else value * self.factor

    def from_si(self, value: Any) -> Any:
        """An SI value (or array) in this unit."""
        return (value - self.offset) / self.factor if self.offset else value / self.factor


@cache
def _registry() -> pint.UnitRegistry[float]:
    import pint  # noqa: PLC0415 - a quarter of a second that `--help` need not pay

    return pint.UnitRegistry(autoconvert_offset_to_baseunit=True)


#: What pint may be asked: it computes what it reads, so `9**9**9**9` would never come back.
_LONGEST = 60
_ARITHMETIC = re.compile(r"\d\d\d|[\d)]\s*(\*\*|\^)|(\*\*|\^)\s*[^-\d]")


@cache
def unit(written: str) -> Unit:
    """Read a unit such as `mm/s`, `mm_s`, `N s/mm`, `Nm`, `rad_s2`, `degC`.

    Raises:
        InputError: nobody knows that unit.
    """
    text = _spell(written.strip())
    if len(text) > _LONGEST or _ARITHMETIC.search(text):
        raise InputError(_unknown(written))
    try:
        registry = _registry()
        zero = registry.Quantity(0.0, text).to_base_units()
        one = registry.Quantity(1.0, text).to_base_units()
    except Exception as error:  # pint raises its own, and tokenizer, attribute and type errors
        raise InputError(_unknown(written)) from error
    factor = float(one.magnitude) - float(zero.magnitude)
    return Unit(written, factor, float(zero.magnitude), f"{one.units:~C}")


def _unknown(written: str) -> str:
    return f"unknown unit {written[:_LONGEST]!r}: write it like mm, mm/s, N, N m or A"


def convertible(a: str, b: str) -> bool:
    """Whether two units measure the same kind of quantity (an angle counts as a pure number)."""
    return unit(a).dimension == unit(b).dimension


def _spell(text: str) -> str:
    """A column-head spelling (`mm_s2`, `Nm_s_rad`) in the words pint knows."""
    if text in _SPELLINGS:
        return _SPELLINGS[text]
    if "_" in text:  # the last part divides: mm_s is mm/s, N_s_mm is N s/mm
        *above, below = text.split("_")
        text = f"{' '.join(_SPELLINGS.get(a, a) for a in above)}/({_SPELLINGS.get(below, below)})"
    text = re.sub(r"\b([kmM]?)Nm\b", r"\1N m", text)
    text = text.replace("·", " ").replace("²", "**2").replace("³", "**3").replace("⁻¹", "**-1")
    return re.sub(r"(?<=[A-Za-z])(\d)", r"**\1", text)
