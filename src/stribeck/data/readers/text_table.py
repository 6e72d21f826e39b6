"""A table from the columns of a text, with what their heads and words say of them."""

from __future__ import annotations

import re
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from ...space import Array
from ...wording import option
from .raw_table import RawTable
from .text_columns import WordColumn
from .text_layout import TextLayout

_OVERRUN = re.compile(rb"(?m)^overrun[ \t]*(?:\n|$)")  # as halsampler of LinuxCNC writes it
_UNUSED = re.compile(r"(?:not selected|unused|not used|none)(?: #\d+)?", re.IGNORECASE)


def without_overruns(text: bytes) -> tuple[bytes, int]:
    """Lines without those of a sampler that was too late, and how many these were."""
    if b"v" not in text or b"overrun" not in text:  # a letter alone is quickly looked for
        return text, 0
    return _OVERRUN.subn(b"", text)


def overrun_note(count: int) -> tuple[str, ...]:
    """A sentence on lines of a sampler that was too late."""
    if not count:
        return ()
    note = (f"the sampler overran {count} times: samples are missing there, and times by "
            f"{option('columns', {'rate': 'HZ'})} are too early from the first on")  # fmt: skip
    return (note,)


def named(
    columns: Mapping[int, Array], layout: TextLayout, state: Mapping[int, WordColumn]
) -> dict[int, str]:
    """Place of a column -> its name; of an empty column without a head, or one not used, none."""
    names = {}
    for i, values in columns.items():
        head = layout.names[i]
        if head or not np.isnan(values).all() or (i in state and state[i].text is not None):
            names[i] = head or f"column {i + 1}"
    return {i: name for i, name in names.items() if not _UNUSED.fullmatch(name)}


def unused_note(layout: TextLayout) -> tuple[str, ...]:
    """A sentence on columns whose heads say that they are not used."""
    count = sum(_UNUSED.fullmatch(head) is not None for head in layout.names)
    return (f"{count} channels are not selected",) if count else ()


def text_table(
    columns: Mapping[int, Array],
    places: NDArray[np.int64] | range,
    layout: TextLayout,
    state: Mapping[int, WordColumn],
    names: Mapping[int, str] | None = None,
) -> RawTable:
    """The table of columns by their place.

    Args:
        columns: Place -> values, (N,).
        places: The line of each row.
        layout: Of the text.
        state: How words of each column became numbers.
        names: Of each column; of all that have any if none are given.
    """
    names = named(columns, layout, state) if names is None else names
    stamps = {n: form for i, n in names.items() if i in state and (form := state[i].stamps)}
    text = {n: cell for i, n in names.items() if i in state and (cell := state[i].text)}
    return RawTable(
        {names[i]: values for i, values in columns.items() if i in names},
        places,
        "line",
        {n: (f"line {places[row]}", cell) for n, (row, cell) in text.items()},
        units=dict.fromkeys(stamps, "s"),
        notes=unused_note(layout),
        dates={n: form.origin for n, form in stamps.items()},
    )
