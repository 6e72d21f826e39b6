"""Units at the boundary: SI inside, whatever people write outside.

Products and quotients of everyday units are read here, all others by pint, whose registry takes
longer to build than most logs to read. What both can read is the same from both, bit for bit.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from itertools import chain
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
    "‰": "permille",
    "1/1000": "permille",
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
    "secs": "s",
    "N-m": "N m",
    "N.m": "N m",
    "min-1": "rpm",
    "min^-1": "rpm",
    "1/min": "rpm",
    "rev": "turn",
    "revs": "turn",
    **dict.fromkeys(("inc", "incs", "cnt", "cnts", "pls", "pulse", "pulses"), "count"),
}
#: Percent below which a share is none to anybody.
_LEAST_PERCENT = 0.01
#: A turn in the speeds of drives: `r/min`, `U/min`. Alone, some of them are other units.
_TURN = re.compile(r"(?:rev|r|tr|U|Umdr|rot)/(min|s)")


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


_NEWTON = {"kg": 1, "m": 1, "s": -2}
_PASCAL = {"kg": 1, "m": -1, "s": -2}
_VOLT = {"kg": 1, "m": 2, "s": -3, "A": -1}
#: Everyday units: the factor to SI, and the powers of the base units.
EVERYDAY: dict[str, tuple[float, dict[str, int]]] = {
    "dimensionless": (1.0, {}), "percent": (1e-2, {}),
    "m": (1.0, {"m": 1}), "mm": (1e-3, {"m": 1}), "um": (1e-6, {"m": 1}), "cm": (1e-2, {"m": 1}),
    "s": (1.0, {"s": 1}), "ms": (1e-3, {"s": 1}), "us": (1e-6, {"s": 1}), "Hz": (1.0, {"s": -1}),
    "rad": (1.0, {"rad": 1}), "mrad": (1e-3, {"rad": 1}), "urad": (1e-6, {"rad": 1}),
    "deg": (math.radians(1), {"rad": 1}),
    "kg": (1.0, {"kg": 1}), "K": (1.0, {"K": 1}),
    "N": (1.0, _NEWTON), "mN": (1e-3, _NEWTON), "kN": (1e3, _NEWTON),
    "Pa": (1.0, _PASCAL), "bar": (1e5, _PASCAL), "count": (1.0, {"count": 1}),
    "A": (1.0, {"A": 1}), "mA": (1e-3, {"A": 1}), "V": (1.0, _VOLT), "mV": (1e-3, _VOLT),
    "rpm": (math.pi / 30, {"rad": 1, "s": -1}),
}  # fmt: skip
_WORD = r"[A-Za-z]+(?:\*\*[23])?"
_QUOTIENT = re.compile(
    rf"(1|{_WORD}(?:[ *]{_WORD})*)((?:/{_WORD})*)(?:/\(({_WORD}(?: {_WORD})*)\))?"
)


def _everyday(written: str, text: str) -> Unit | None:
    """A unit such as `N s/mm` if it is made of everyday ones, of which one may be scaled."""
    if text == "degC":
        return Unit(written, 1.0, 273.15, "K")
    match = _QUOTIENT.fullmatch(text)
    if match is None:
        return None
    numerator = re.sub(r"(?<!\*)\*(?=[A-Za-z])", " ", match[1].removeprefix("1"))
    denominator = f"{match[2].replace('/', ' ')} {match[3] or ''}"
    scale, powers = 1.0, dict.fromkeys(("A", "count", "K", "kg", "m", "rad", "s"), 0)
    for word, sign in chain(
        ((w, 1) for w in numerator.split()), ((w, -1) for w in denominator.split())
    ):
        name, _, power = word.partition("**")
        factor, parts = EVERYDAY.get(name, (0.0, {}))
        times = sign * int(power or 1)
        if factor != 1.0:
            if not factor or scale != 1.0 or abs(times) > 1:  # pint rounds in its own order
                return None
            scale = factor**times
        for base, n in parts.items():
            powers[base] += n * times
    return Unit(written, scale, 0.0, _dimension(powers))


def _dimension(powers: dict[str, int]) -> str:
    """Powers of the base units as pint writes them: `kg*m/s**2`."""

    def product(sign: int) -> Iterator[str]:
        for base, n in powers.items():
            if n * sign > 0:
                yield base if abs(n) == 1 else f"{base}**{abs(n)}"

    numerator, denominator = "*".join(product(1)), "/".join(product(-1))
    return f"{numerator or '1'}/{denominator}" if denominator else numerator


@cache
def _registry() -> pint.UnitRegistry[float]:
    import pint  # noqa: PLC0415 - a quarter of a second that `--help` need not pay

    return pint.UnitRegistry(autoconvert_offset_to_baseunit=True)


#: A word of so many letters is not part of another unit: in `inc/s`, `count`.
_WORDY = 3
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
    if everyday := _everyday(written, text):
        return everyday
    return _asked(written, text)


def _asked(written: str, text: str) -> Unit:
    """What pint says."""
    try:
        registry = _registry()
        zero = registry.Quantity(0.0, text).to_base_units()
        quantity = registry.Quantity(1.0, text).to_base_units()
    except Exception as error:  # pint raises its own, and tokenizer, attribute and type errors
        raise InputError(_unknown(written)) from error
    factor = float(quantity.magnitude) - float(zero.magnitude)
    return Unit(written, factor, float(zero.magnitude), f"{quantity.units:~C}")


def _unknown(written: str) -> str:
    return f"unknown unit {written[:_LONGEST]!r}: write it like mm, mm/s, N, N m or A"


def percent(share: float) -> str:
    """A share for people: two digits, or all of those before the point."""
    value = 100.0 * share
    if abs(value) < _LEAST_PERCENT:
        return f"less than {_LEAST_PERCENT:g} %"
    return f"{two_digits(value)} %"


def two_digits(value: float) -> str:
    """A number for people: two digits, or all of those before the point."""
    return f"{value:.0f}" if abs(value) >= 10 else f"{value:.2g}"  # noqa: PLR2004 - two digits


def convertible(a: str, b: str) -> bool:
    """Whether two units measure the same kind of quantity (an angle counts as a pure number)."""
    return unit(a).dimension == unit(b).dimension


def _spell(text: str) -> str:
    """A column-head spelling (`mm_s2`, `Nm_s_rad`) in the words pint knows."""
    if text in _SPELLINGS:
        return _SPELLINGS[text]
    if turn := _TURN.fullmatch(text):
        return f"turn/{turn[1]}"
    words = re.split(r"([^A-Za-z]+)", text)
    text = "".join(w if len(w) < _WORDY else _SPELLINGS.get(w, w) for w in words)
    if "_" in text:  # the last part divides: mm_s is mm/s, N_s_mm is N s/mm
        *numerators, denominator = text.split("_")
        top = " ".join(_SPELLINGS.get(a, a) for a in numerators)
        text = f"{top}/({_SPELLINGS.get(denominator, denominator)})"
    text = re.sub(r"\b([kmM]?)Nm\b", r"\1N m", text)
    text = text.replace("·", " ").replace("²", "**2").replace("³", "**3").replace("⁻¹", "**-1")
    return re.sub(r"(?<=[A-Za-z])(\d)", r"**\1", text)


#: A number with a comma for its point; and one whose comma may as well part thousands.
_COMMA = re.compile(r"\s*[+-]?\d*,\d+(?:[eE][+-]?\d+)?\s*")
_THOUSANDS = re.compile(r"\s*[+-]?[1-9]\d{0,2},\d{3}\s*")


def number(text: str, place: str, *, whole: str | None = None, kind: str = "a number") -> float:
    """A finite number that a person wrote, with a point or a comma.

    Args:
        text: It.
        place: Where it stands, for the message.
        whole: The text that it is a part of, for the message; itself by default.
        kind: What should stand there, for the message.

    Raises:
        InputError: it is no number, not finite, or has a comma that may part thousands.
    """
    written = text if whole is None else whole
    if _THOUSANDS.fullmatch(text):
        few, many = text.strip().replace(",", "."), text.strip().replace(",", "")
        raise InputError(f"{place}: {written!r} is {few} or {many}: write it without a comma")
    try:
        value = float(text.replace(",", ".") if _COMMA.fullmatch(text) else text)
    except ValueError:
        raise InputError(f"{place}: {written!r} is not {kind}") from None
    if not math.isfinite(value):
        raise InputError(f"{place}: {written!r} is not a finite number")
    return value


def interval(text: str, place: str) -> tuple[float, float]:
    """Two finite numbers that a person wrote as `LO:HI`.

    Args:
        text: They.
        place: Where they stand, for the message.

    Raises:
        InputError: there are not two, or one is no number.
    """
    low, colon, high = text.partition(":")
    if not colon:
        raise InputError(f"{place}={text}: write NAME=LO:HI")
    return number(low, place), number(high, place)
