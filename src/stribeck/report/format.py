"""How numbers, units, times and names are written for people, and values for JSON."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping
from dataclasses import is_dataclass
from typing import Any

#: What stands where there is no number.
DASH = "–"
#: Powers of ten for which a grouped number is written out, and not as 1.2e-9.
_WRITTEN_OUT = range(-3, 6)
#: Decimals of a value written out beside its error.
_DECIMALS = 5


def number(value: float | None, digits: int = 5) -> str:
    """A number with so many significant digits: "0.0123", "1.2e-09"; a dash where there is none."""
    return DASH if value is None or not math.isfinite(value) else f"{value:.{digits}g}"


def with_error(value: float, error: float) -> str:
    """A value and its standard error, to the error's second digit: "10.007 ± 0.012"."""
    if not (math.isfinite(value) and math.isfinite(error) and error > 0):
        return f"{number(value, 4)} ± {number(error, 2)}"
    digits = 1 - int(f"{error:.1e}".partition("e")[2])
    if not 0 <= digits <= _DECIMALS:
        return f"{number(value, 4)} ± {number(error, 2)}"
    return f"{value:.{digits}f} ± {error:.{digits}f}"


def grouped(value: float | None, digits: int = 4) -> str:
    """A number with its thousands apart: "1,234", "0.0123", "1.2e-9", "∞", or a dash."""
    if value is None or math.isnan(value):
        return DASH
    if math.isinf(value):
        return "∞" if value > 0 else "-∞"
    if value == 0 or (isinstance(value, int) and abs(value) < 10**6):
        return f"{value:,.0f}"
    power = int(f"{value:.{digits - 1}e}".partition("e")[2])
    if power not in _WRITTEN_OUT:
        mantissa, _, exponent = f"{value:.{min(digits, 4) - 1}e}".partition("e")
        return f"{mantissa}e{int(exponent)}"
    return f"{value:,.{max(digits - 1 - power, 0)}f}"


def as_entered(value: float) -> str:
    """A number as a person types it: "1e-8", "0.9980038"."""
    return re.sub(r"e([+-])0*", r"e\1", f"{value:.7g}").replace("e+", "e")


def duration(seconds: float) -> str:
    """A time as people say it: "40 s", "7 min", "1 h 20 min", "2 d 3 h"."""
    if seconds < 99.5:  # noqa: PLR2004
        return f"{seconds:.1f} s" if seconds < 9.95 else f"{seconds:.0f} s"  # noqa: PLR2004
    minutes = round(seconds / 60)
    hours, days = divmod(minutes, 60), divmod(round(minutes / 60), 24)
    if not hours[0]:
        return f"{minutes} min"
    (whole, rest), units = (hours, ("h", "min")) if minutes < 24 * 60 else (days, ("d", "h"))
    return f"{whole} {units[0]}" + (f" {rest} {units[1]}" if rest else "")


def unit_label(unit: str) -> str:
    """A unit as labels have it: "kg m²", "µm/s"."""
    return unit.replace("urad", "µrad").replace("um", "µm").replace("**2", "²")


def abbreviated(text: str, most: int) -> str:
    """A name of at most so many letters; what is left out is its middle."""
    if len(text) <= most:
        return text
    head = (most - 1) // 2
    return f"{text[:head]}…{text[len(text) - (most - 1 - head) :]}"


def json_text(data: Mapping[str, Any]) -> str:
    """A document as JSON, to be read by people too; null stands for what is not finite."""
    return json.dumps(_plain(data), indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def _plain(value: Any) -> Any:
    """A value as JSON has it: a slice as its two ends, what is not finite as null."""
    if is_dataclass(value):
        return {name: _plain(v) for name, v in vars(value).items()}
    if isinstance(value, slice):
        return [value.start, value.stop]
    if isinstance(value, Mapping):
        return {str(key): _plain(v) for key, v in value.items()}
    if isinstance(value, tuple | list):
        return [_plain(v) for v in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value
