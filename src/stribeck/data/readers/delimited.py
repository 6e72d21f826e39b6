"""Text tables, parsed by their layout.

A table of bare numbers goes through NumPy, which is there already, up to a size at which polars
has made up for its start; whatever is larger or less plain is read by polars, and a large file a
block at a time.
"""

from __future__ import annotations

import io
from dataclasses import replace
from pathlib import Path

import numpy as np

from ...space import Array
from .budget import ReadBudget
from .file_bytes import whole
from .log_file import LogFile, Reader, ReadOptions, TablesInMemory
from .raw_table import RawTable
from .text_blocks import LARGE, large_text
from .text_columns import WordColumn
from .text_encoding import is_text, utf8
from .text_layout import TextLayout, text_layout
from .text_rows import TextRows, comment_mark, refuse_huge_line
from .text_table import overrun_note, text_table, without_overruns

_SMALL = 8 << 20  # bytes that NumPy parses in the time that polars takes to start
_BARE = b"0123456789.eE+-\n"


def read_text(data: bytes) -> RawTable:
    """A table of text: CSV, TSV or columns apart by blanks, in any usual encoding.

    Raises:
        InputError: it is not text, not a header with rows of numbers of one length below it, or
            too large a table.
    """
    text, overruns = without_overruns(utf8(data))
    layout = text_layout(text)
    refuse_huge_line(text, layout)
    rows = text.count(b"\n") + 1 - layout.first
    ReadBudget(len(data)).take_cells(rows, layout.width)
    table = _parse(text, layout)
    return replace(table, notes=(*table.notes, *overrun_note(overruns)))


def _parse(text: bytes, layout: TextLayout) -> RawTable:
    body = text.split(b"\n", layout.first)[layout.first]
    if (bare := _bare(body, layout)) is not None:
        lines = np.arange(len(bare)) + layout.first + 1
        return text_table(dict(enumerate(bare.T.copy())), lines, layout, {})
    state = {i: WordColumn(decimal_comma=layout.decimal_comma) for i in range(layout.width)}
    rows = TextRows(body, layout, comment_mark(body), layout.first + 1)
    frame = rows.columns(state)
    rows.refuse_short_rows(frame)
    columns = {int(s.name): state[int(s.name)].whole(s.to_numpy()) for s in frame.iter_columns()}
    return text_table(columns, rows.places(frame.height), layout, state)


def _bare(body: bytes, layout: TextLayout) -> Array | None:
    """The rows of a small table, (N, width), if there is a plain number in every cell."""
    separator = layout.separator.encode()
    if (
        len(body) > _SMALL
        or separator == b" "
        or layout.decimal_comma
        or body.translate(None, _BARE + separator)
    ):
        return None
    try:
        rows = np.loadtxt(io.BytesIO(body), delimiter=layout.separator, comments=None, ndmin=2)
    except ValueError:
        return None
    lines = body.count(b"\n") + (not body.endswith(b"\n"))
    return rows if rows.shape == (lines, layout.width) else None  # else some are empty


def _opens(_path: Path, head: bytes) -> bool:
    return is_text(head)


def _open(path: Path, _options: ReadOptions) -> LogFile:
    if path.stat().st_size > LARGE:
        return large_text(path)
    return TablesInMemory((read_text(whole(path)),))


READER = Reader(
    "text",
    "columns of text: CSV, TSV, blanks; with or without heads, preamble and units",
    (".csv", ".tsv", ".txt", ".dat", ".asc", ".log", ".tab"),
    _opens,
    _open,
)
