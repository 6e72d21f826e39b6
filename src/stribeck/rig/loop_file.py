"""The loop of an axis as a user states it: gains, period, limits and sensor in a TOML file."""

from __future__ import annotations

import math
import tomllib
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from ..errors import InputError
from ..text_file import page
from ..units import convertible, number, unit
from .position_loop import PositionLoop

if TYPE_CHECKING:
    from pathlib import Path

    from .rig import Rig

_HAS = "kp, kd, derivative, period, delay, limit and [sensor] with resolution and noise"
#: Refusals in words that fit a loop file, in place of the checker's own.
_WORDS = {
    "extra_forbidden": f"a loop file has no such word: it has {_HAS}",
    "finite_number": "must be a finite number",
    "literal_error": 'is "error" (command less position) or "position"',
    "model_type": "must be a table: [sensor]",
}

#: A number in the unit that the rig shows (gains, limits: SI; times: ms), or "number unit".
Quantity = Annotated[float, Field(strict=True)] | Annotated[str, Field(strict=True)]


class _SensorTable(BaseModel):
    model_config = ConfigDict(extra="forbid")

    resolution: Quantity = 0.0
    noise: Quantity = 0.0


class _LoopTable(BaseModel):
    model_config = ConfigDict(extra="forbid")

    kp: Quantity | None = None
    kd: Quantity = 0.0
    derivative: Literal["error", "position"] = "error"
    period: Quantity = 1.0
    delay: Quantity = 0.0
    limit: Quantity | None = None
    sensor: _SensorTable = _SensorTable()


@dataclass(frozen=True)
class StatedLoop:
    """What a loop file says, SI.

    Args:
        controller: The controller; None where the file states no gains.
        period: Sample time, s.
        resolution: A count of the position sensor, m or rad.
        noise: Standard deviation of its readings, m or rad.
    """

    controller: PositionLoop | None = None
    period: float = 1e-3
    resolution: float = 0.0
    noise: float = 0.0


def loop_file(path: Path, rig: Rig) -> StatedLoop:
    """Read the loop of an axis.

    ```toml
    kp = "100 N m/rad"      # numbers without a unit are SI, times ms, the sensor's as the rig shows
    kd = "5 N m s/rad"
    derivative = "error"    # or "position": kd acts on the axis's velocity alone
    period = "1 ms"
    delay = 0               # or one period
    limit = "40 N m"
    [sensor]
    resolution = "0.01 deg"
    noise = 0
    ```

    Raises:
        InputError: no such file, broken TOML, a word or number that a loop has not.
    """
    try:
        table = _LoopTable.model_validate(tomllib.loads(page(path)))
        return _stated(table, rig)
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join(str(part) for part in first["loc"][:2])
        problem = _WORDS.get(first["type"], 'must be a number or text such as "5 N m s/rad"')
        raise InputError(f"{path}: {place}: {problem}") from error
    except InputError as error:
        raise InputError(f"{path}: {error}") from error
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path}: not TOML: {error}") from error


def _stated(table: _LoopTable, rig: Rig) -> StatedLoop:
    force, length = rig.si_unit("force"), rig.si_unit("position")
    shown = rig.unit_shown("position")
    period = _si("period", table.period, "ms", above=True)
    delay = _si("delay", table.delay, "ms")
    if not (delay == 0.0 or math.isclose(delay, period, rel_tol=1e-3)):
        raise InputError(
            f"delay: {1e3 * delay:.4g} ms: a loop is simulated with 0 or one period, "
            f"{1e3 * period:.4g} ms"
        )
    controller = None
    if table.kp is not None:
        limit = table.limit
        controller = PositionLoop(
            kp=_si("kp", table.kp, f"{force}/{length}", above=True),
            kd=_si("kd", table.kd, f"{force} s/{length}"),
            period=period,
            late=delay > 0.0,
            limit=math.inf if limit is None else _si("limit", limit, force, above=True),
            error_derivative=table.derivative == "error",
        )
    elif table.kd != 0.0 or table.limit is not None:
        raise InputError(
            f'kp: is missing: the gain of the position, such as "100 {force}/{length}"'
        )
    return StatedLoop(
        controller,
        period,
        _si("sensor.resolution", table.sensor.resolution, shown),
        _si("sensor.noise", table.sensor.noise, shown),
    )


def _si(place: str, quantity: float | str, written: str, *, above: bool = False) -> float:
    """A quantity in SI; a bare number is in the unit that is written."""
    if isinstance(quantity, str):
        value, _, unit_text = quantity.strip().partition(" ")
        magnitude, stated = number(value, place, whole=quantity), unit_text.strip() or written
        if not convertible(stated, written):
            raise InputError(f"{place}: {quantity!r} is not in a unit such as {written}")
    else:
        magnitude, stated = quantity, written
    si = float(unit(stated).to_si(magnitude))
    if not (math.isfinite(si) and (si > 0.0 if above else si >= 0.0)):
        least = "above 0" if above else "0 or above"
        raise InputError(f"{place}: give a number {least}, got {quantity}")
    return si
