"""Messages of Klipper's API server as motan's data logger keeps them (`NAME.json.gz`).

Each is JSON and ended by the character 3. A subscription is answered by a message with its `id`,
which names the columns, and followed by messages with the same name as `q`. Three kinds are
channels: the steps of a motor, whose position holds until the next one; rows of a sensor
(accelerometer, angle, load cell), the first number of which is its time; and numbers of the status,
at the print time that the message states. Format: docs/API_Server.md, scripts/motan/data_logger.py
and readlog.py of github.com/Klipper3d/klipper.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import InputError
from ...space import Array
from .arrays import TimedSeries, by_times
from .budget import CELL, ReadBudget, refuse_many
from .file_bytes import whole
from .log_file import Reader, ReadOptions, TablesInMemory
from .raw_table import printable, shortened

_END = b"\x03"
_BEGINS = re.compile(rb'\s*\{\s*"(?:id|q|result|params)"')
#: Bytes of a decoded message, as a multiple of its own.
_DECODED = 12
#: Units of sensors' columns, and of what the status of a driver calls so.
_UNITS = {"acceleration": "mm/s**2", "current": "A", "temperature": "degC", "velocity": "mm/s"}
_AXIS = re.compile(r"\b([xyz])_acceleration$")
#: Numbers from here on are no measurements.
_BEYOND = 1e300
#: Counts of an angle sensor in a turn.
_TURN = 65536.0
_NO_FORCE = (
    "no channel is a force: positions are those of the steps sent, currents those that a driver "
    "was set to; a load cell or a motor's measured current would be one"
)


def _opens(_path: Path, head: bytes) -> bool:
    return _END in head and _BEGINS.match(head) is not None


def _open(path: Path, _options: ReadOptions) -> TablesInMemory:
    data = whole(path)
    budget = ReadBudget(len(data))
    budget.take(_DECODED * len(data), "its messages")
    messages, broken = _messages(data)
    columns = _columns(messages)
    status: dict[str, list[tuple[float, float]]] = {}
    rows: dict[str, list[Any]] = {}
    for message in messages:
        name, params = message.get("q"), message.get("params")
        if not isinstance(name, str) or not isinstance(params, Mapping):
            continue
        if name == "status":
            _take_status(params, status)
        elif isinstance(params.get("data"), list):
            rows.setdefault(name, []).append(params)
    refuse_many(len(status) + sum(len(columns.get(n, ())) for n in rows), "channels")
    series: list[TimedSeries] = []
    planned = False
    for name, blocks in rows.items():
        if name.startswith("stepq:"):
            series.append(_steps(name.partition(":")[2], blocks, budget))
        elif name.startswith("trapq:"):
            planned = True
        elif name in columns and columns[name][0] == "time":
            series += _sensor(name, columns[name], blocks)
    series += [_held(name, values) for name, values in status.items() if len(values) > 1]
    if not series:
        raise InputError("has no steps, no samples of a sensor and no status that changes")
    notes = [_NO_FORCE] if not any("force" in s.name for s in series) else []
    notes += [f"{broken} messages cannot be read and were left out"] * (broken > 0)
    notes += ["moves of the planner were left out: the steps are their positions"] * planned
    return TablesInMemory(tuple(by_times(series, word="sample")), tuple(notes))


READER = Reader(
    "klipper", "Klipper, the log of motan's data_logger.py", (".json.gz", ".json"), _opens, _open
)


def _messages(data: bytes) -> tuple[list[Mapping[str, Any]], int]:
    """The messages that can be read, and how many cannot."""
    *parts, rest = data.split(_END)  # what no character ends was not all written
    messages: list[Mapping[str, Any]] = []
    broken = int(bool(rest.strip()))
    for part in parts:
        try:
            message = json.loads(part)
        except (ValueError, RecursionError):
            message = None
        if isinstance(message, Mapping):
            messages.append(message)
        else:
            broken += 1
    return messages, broken


def _columns(messages: list[Mapping[str, Any]]) -> dict[str, list[str]]:
    """The columns of each subscription, as the answer to it names them."""
    result: dict[str, list[str]] = {}
    for message in messages:
        name, answer = message.get("id"), message.get("result")
        header = answer.get("header") if isinstance(answer, Mapping) else None
        if isinstance(name, str) and isinstance(header, list) and header:
            result[name] = [printable(str(h)) for h in header]
    return result


def _steps(name: str, blocks: list[Any], budget: ReadBudget) -> TimedSeries:
    """The position of a motor after each step, s and mm.

    A block has queued steps (interval, count, add), in ticks of a clock: each interval is longer
    than the one before by `add`, and a count below zero steps back.

    Raises:
        InputError: a block lacks something, or the steps take more memory than a read may.
    """
    t, x = [], []
    for block in blocks:
        try:
            queued = np.array(block["data"], dtype=float).reshape(-1, 3)
            ends = [float(block[k]) for k in ("first_step_time", "last_step_time")]
            clocks = [float(block[k]) for k in ("first_clock", "last_clock")]
            start, distance = float(block["start_position"]), float(block["step_distance"])
        except (KeyError, TypeError, ValueError, OverflowError) as error:
            raise InputError(f"{shortened(name)}: a message of its steps is not whole: log "
                             "again") from error  # fmt: skip
        if not len(queued):
            continue
        counts = np.abs(queued[:, 1])
        if not np.isfinite(queued).all() or not (counts < 1 << 31).all():
            raise InputError(f"{shortened(name)}: its steps are no numbers of steps: log again")
        budget.take(int(counts.sum()) * 6 * CELL, "its steps")
        which = np.repeat(np.arange(len(queued)), counts.astype(np.int64))
        k = np.arange(len(which)) - (np.cumsum(counts) - counts)[which]
        with np.errstate(over="ignore", invalid="ignore"):
            ticks = np.cumsum(queued[which, 0] + k * queued[which, 2]) - queued[0, 0]
        span = clocks[1] - clocks[0]
        second = (ends[1] - ends[0]) / span if span > 0 else 0.0
        with np.errstate(over="ignore", invalid="ignore"):
            t.append(ends[0] + ticks * second)
            x.append(start + distance * np.cumsum(np.sign(queued[which, 1])))
    times = np.concatenate(t) if t else np.empty(0)
    values = np.concatenate(x) if x else np.empty(0)
    if not np.isfinite(times).all():
        raise InputError(f"{shortened(name)}: the times of its steps are no numbers: log again")
    return TimedSeries(f"{printable(name)} position", times, values, "mm")


def _sensor(name: str, columns: list[str], blocks: list[Any]) -> Iterator[TimedSeries]:
    """The channels of a sensor, of which the first column is the time.

    Raises:
        InputError: a row has another number of columns, or something that is no number.
    """
    try:
        rows = np.array([row for block in blocks for row in block["data"]], dtype=float)
        rows = rows.reshape(-1, len(columns))
        rows = rows[np.isfinite(rows[:, 0])]
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError(f"{shortened(name)}: its rows are not {len(columns)} numbers "
                         "each: log again") from error  # fmt: skip
    sensor = printable(name.partition(":")[2])
    for k, column in enumerate(columns[1:], 1):
        if name.startswith("angle:") and column == "angle":
            yield TimedSeries(f"{sensor} angle", rows[:, 0], rows[:, k] / _TURN, "rev")
        else:
            bare, unit = _with_unit(column)
            yield TimedSeries(f"{sensor} {bare}", rows[:, 0], rows[:, k], unit)


def _with_unit(column: str) -> tuple[str, str]:
    """A column and its unit: as its head says it, or as Klipper has it; grams are of weight.

    An accelerometer's axes are no axis of the machine: they are called as in Klipper's own CSV.
    """
    bare = column.partition("(")[0].strip()
    unit = next((u for word, u in _UNITS.items() if bare.endswith(word)), "")
    return _AXIS.sub(r"accel_\1", bare), "gf" if column.endswith("(g)") else unit


def _take_status(params: Mapping[str, Any], values: dict[str, list[tuple[float, float]]]) -> None:
    """The numbers of a status message at its print time, if it states one."""
    status = params.get("status")
    if not isinstance(status, Mapping):
        return
    toolhead = status.get("toolhead")
    t: Any = toolhead.get("estimated_print_time") if isinstance(toolhead, Mapping) else None
    if not _is_number(t):
        return
    for thing, fields in status.items():
        for field, value in fields.items() if isinstance(fields, Mapping) else ():
            more = value.items() if isinstance(value, Mapping) else [("", value)]
            for part, number in more:
                if _is_number(number) and "print_time" not in field:
                    name = printable(" ".join(filter(None, (str(thing), str(field), str(part)))))
                    values.setdefault(name, []).append((float(t), float(number)))


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < _BEYOND


def _held(name: str, values: list[tuple[float, float]]) -> TimedSeries:
    """A number of the status, at the times at which it was told."""
    times, numbers = (np.array(v) for v in zip(*values, strict=True))
    later: Array = np.array([True, *(b > a for a, b in pairwise(times))])
    _, unit = _with_unit(name)
    return TimedSeries(name, times[later], numbers[later], unit)
