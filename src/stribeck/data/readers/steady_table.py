"""Tables of mean speed and mean force, a row each run at constant speed: no times, no positions."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import InputError
from ...space import Array
from ...units import unit
from ...wording import option
from ..steady_runs import MOST, SteadyRuns
from .choice import Choice, kinds_of, refuse_unfit
from .column_map import Entry
from .columns import Heads, choose, mapped_choice, ranked, without_unit
from .heads import Head, meanings
from .raw_table import RawTable, shortened
from .repair import filled_extra
from .signal_choice import signal_of

#: Words of a head that say no more than that its numbers are means.
_MEAN = {"mean", "avg", "average", "mittel", "mittelwert", "moyenne", "media"}
#: Words for the spread of the force within a run, for the error of its mean, and for samples.
_SPREAD = {"sd", "std", "stdev", "stddev", "sigma", "deviation", "streuung"}
_ERROR = {"se", "sem", "stderr"}
_COUNT = {"n", "count", "samples", "number", "anzahl"}
#: Fewest runs: two levels and the spread about them.
FEWEST = 3
#: What a table of runs has beside the channels of an axis.
_BESIDE = ("force error", "force deviation", "count")


def chosen_columns(
    heads: Heads, mapped: Mapping[str, Entry]
) -> tuple[dict[str, Choice], list[str]]:
    """Channel -> column, of a log or of a table of steady speeds, and notes; see `choose`.

    Raises:
        InputError: as `choose`.
    """
    runs = _runs(heads, mapped)
    return (runs, []) if runs else choose(heads, mapped)


def is_steady(heads: Heads, chosen: Mapping[str, Choice]) -> bool:
    """Whether what was chosen are the columns of a table of steady speeds."""
    return not heads.timed and "time" not in chosen


def _runs(heads: Heads, mapped: Mapping[str, Entry]) -> dict[str, Choice]:
    """Speed, force and what a table has beside them; empty where the heads are those of a log.

    Raises:
        InputError: speed or force has no unit, or one that does not fit.
    """
    rows = max((c.count for c in heads.columns.values()), default=0)
    if heads.timed or {"time", "position", "command"} & set(mapped) or not 0 < rows <= MOST:
        return {}
    names = {h: _plain(heads.head(h)) for h in heads.bare}
    if any(
        {"time", "position"} & set(meanings(_with_unit(heads, head))) for head in names.values()
    ):
        return {}
    chosen = {channel: mapped_choice(heads, channel, e) for channel, e in mapped.items()}
    beside = _beside(heads, names, {c.column for c in chosen.values()})
    free = {h: v for h, v in names.items() if h not in {c.column for c in chosen.values()}}
    free = {h: v for h, v in free.items() if h not in beside}
    for channel in ("velocity", "force", "temperature"):
        if channel in chosen:
            continue
        rotary = chosen["velocity"].rotary if "velocity" in chosen else None
        if choice := ranked(heads, free, channel, heads.kinds(channel, rotary=rotary)):
            chosen[channel] = choice
    if heads.drive is not None and "velocity" in chosen:
        chosen |= signal_of(heads.drive, chosen, rotary=chosen["velocity"].rotary)
    if lacking := [c for c in ("velocity", "force") if c not in chosen]:
        named = {c: [h for h, v in free.items() if c in meanings(v)] for c in ("velocity", "force")}
        if all(named[c] or c in chosen for c in named):
            first = named[lacking[0]][0]
            raise InputError(without_unit(free, first, lacking[0], chosen))
        return {}
    rotary = chosen["velocity"].rotary
    for channel, choice in chosen.items():
        refuse_unfit(channel, choice, heads.kinds(channel, rotary=rotary))
    return chosen | _stated(heads, names, beside, chosen["force"])


def _plain(head: Head) -> Head:
    """A head without words that say that it is a mean."""
    return replace(head, stem="_".join(w for w in head.stem.split("_") if w not in _MEAN))


def _with_unit(heads: Heads, head: Head) -> Head:
    """A head whose letter stands for something else where its unit does: `t [degC]` is no time."""
    for channel in ("time", "position"):
        fits = head.unit is None or (
            (known := heads.known(channel, head.unit)) is not None
            and known.dimension in kinds_of(channel)
        )
        if channel in meanings(head) and not fits:
            return replace(head, stem="")
    return head


def _beside(heads: Heads, names: Mapping[str, Head], taken: set[str]) -> dict[str, str]:
    """Column -> what it says of the runs, of `_BESIDE`."""
    result: dict[str, str] = {}
    for h, head in names.items():
        words = set(re.split(r"_", head.stem))
        rest = "_".join(w for w in head.stem.split("_") if w not in _SPREAD | _ERROR)
        of_force = not rest or "force" in meanings(replace(head, stem=rest))
        if h in taken:
            continue
        if words & (_SPREAD | _ERROR) and of_force:
            result[h] = "force error" if words & _ERROR else "force deviation"
        elif words <= _COUNT and heads.head(h).unit is None:
            result[h] = "count"
    return result


def _stated(
    heads: Heads, names: Mapping[str, Head], beside: Mapping[str, str], force: Choice
) -> dict[str, Choice]:
    """Columns of the error of the mean force, or of its spread and the samples of a run."""
    stated: dict[str, Choice] = {}
    for name in _BESIDE:
        columns = [h for h, kind in beside.items() if kind == name]
        if not columns or (name == "force deviation" and "force error" in stated):
            continue
        if name == "count":
            stated[name] = Choice(columns[0], unit("1"), reason="by its head")
            continue
        known = heads.known("force", names[columns[0]].unit or force.unit.written)
        if known is not None and known.dimension == force.unit.dimension:
            stated[name] = Choice(columns[0], known, reason="by its head")
    return stated


def steady_arguments(
    table: RawTable, chosen: Mapping[str, Choice], notes: tuple[str, ...]
) -> dict[str, Any]:
    """The arguments of a `Recording` of runs, in the order of their speeds, but for the source.

    Raises:
        InputError: a standard deviation or a count is not above 0.
    """
    channels = {n: c.values(table) for n, c in chosen.items() if n not in _BESIDE}
    valid = np.isfinite(channels["velocity"]) & np.isfinite(channels["force"])
    errors, weighed = _errors(table, chosen, valid)
    rows = np.flatnonzero(valid)
    if len(rows) < FEWEST:
        raise InputError(
            f"has {len(rows)} rows with speed and force, and no column is a time or a position: a "
            f"table of steady speeds takes {FEWEST} runs, a log its times"
        )
    rows = rows[np.argsort(channels["velocity"][rows], kind="stable")]
    sentence = (
        "each row is taken as a run at constant speed, as no column is a time or a position; of "
        f"a log, {option('columns', {'rate': 500})} says the samples a second"
    )
    told = (sentence, weighed) if weighed else (sentence,)
    if lost := int((~valid).sum()):
        told = (*told, f"{lost} row{'s' * (lost != 1)} without speed or force left out")
    columns = {c.column for c in chosen.values()}
    return {
        "t": np.arange(float(len(rows))),
        "position": np.zeros(len(rows)),
        **{name: values[rows] for name, values in channels.items()},
        "extra": {
            n: a[rows]
            for n, a in filled_extra(table, columns).items()
            if np.isfinite(a[rows]).all()
        },
        "rotary": chosen["velocity"].rotary,
        "runs": SteadyRuns(None if errors is None else errors[rows]),
        "notes": (*table.notes, *told, *notes),
    }


def _errors(
    table: RawTable, chosen: Mapping[str, Choice], valid: NDArray[np.bool_]
) -> tuple[Array | None, str]:
    """Standard errors of the mean forces, (N,), as the table states them, and a word on it."""
    if (error := chosen.get("force error")) is not None:
        return _positive(table, error, valid), f"runs count by {shortened(error.column)}"
    deviation, count = chosen.get("force deviation"), chosen.get("count")
    if deviation is None:
        return None, ""
    spread, name = _positive(table, deviation, valid), shortened(deviation.column)
    if count is None:
        return spread, f"runs count by {name}, as no column says of how many samples they are"
    samples = _positive(table, count, valid)
    return spread / np.sqrt(samples), f"runs count by {name} / sqrt({shortened(count.column)})"


def _positive(table: RawTable, choice: Choice, valid: NDArray[np.bool_]) -> Array:
    values = choice.values(table)
    if len(wrong := np.flatnonzero(valid & ~(values > 0))):
        raise InputError(
            f"{table.place(int(wrong[0]))}, column {shortened(choice.column)}: must be above 0: "
            "correct it, or rename the column"
        )
    return np.abs(values)
