"""From columns to channels: a raw table chosen from, in SI, mended, with notes on what was done."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..channels import CHANNELS
from .columns import Choice, Entry, choose, is_there
from .raw_table import RawTable, shortened
from .repair import Mender, filled_extra


def assembled(
    table: RawTable, mapped: Mapping[str, Entry], *, lenient: bool = False
) -> dict[str, Any]:
    """The arguments of a `Recording`, but for its source.

    Args:
        table: Columns as they stand in a file or a frame.
        mapped: Channel -> column, where heads do not say it.
        lenient: Whether a mapped column that is not there is no reason to refuse; time and
            position must be.

    Raises:
        InputError: a column that is needed is not there or has no unit, or the rows are no log.
    """
    if lenient:
        mapped = {
            channel: entry
            for channel, entry in mapped.items()
            if channel in ("time", "position") or is_there(table, entry)
        }
    chosen, notes = choose(table, mapped)
    channels = {name: chosen[name].values(table) for name in ("time", *CHANNELS) if name in chosen}
    used = {c.column for c in chosen.values()}
    mender = Mender(table, channels, filled_extra(table, used), list(table.notes))
    mender.notes += [f"column {shortened(n)} left out: it has text" for n in table.text]
    mender.mend()
    return {
        "t": mender.channels.pop("time"),
        **mender.channels,
        "extra": mender.extra,
        "rotary": chosen["position"].unit.dimension == "rad",
        "notes": (*mender.notes, *notes, *_scaled(chosen)),
    }


def _scaled(chosen: Mapping[str, Choice]) -> list[str]:
    """A word on a force that is another quantity times a number."""
    force = chosen.get("force")
    if force is None or isinstance(force.factor, str) or abs(force.factor) == 1:
        return []
    note = (
        f"force is {shortened(force.column)} times {force.factor:g}: every parameter of force and "
        "mass scales with that factor, and is no better known than it is"
    )
    return [note]
