"""Text tables, parsed by their layout.

A table of bare numbers goes through NumPy, which is there already, up to a size at which polars
has made up for its start; whatever is larger or less plain is read by polars.
"""

from __future__ import annotations

import io
import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ...errors import InputError
from ...space import Array
from ...wording import option
from .budget import ReadBudget
from .file_bytes import whole
from .log_file import Reader, ReadOptions, TablesInMemory
from .raw_table import RawTable, unique_names
from .stamps import instants
from .text_encoding import SNIFFED, is_text, utf8
from .text_layout import COMMENTS, MISSING, TextLayout, split, text_layout

if TYPE_CHECKING:
    import polars as pl

_HUGE = 1 << 20  # bytes that no line of a log has
_SMALL = 8 << 20  # bytes that NumPy parses in the time that polars takes to start
_BARE = b"0123456789.eE+-\n"
_OVERRUN = re.compile(rb"(?m)^overrun[ \t]*(?:\n|$)")  # as halsampler of LinuxCNC writes it
_TRUTH = {"true": 1.0, "false": 0.0}
_NULLS = sorted({s for m in MISSING - {"nan"} for s in (m, m.upper(), m.capitalize())})
_UNUSED = re.compile(r"(?:not selected|unused|not used|none)(?: #\d+)?", re.IGNORECASE)


class _Converted(NamedTuple):
    """Columns of words as numbers.

    Args:
        frame: The numbers, null where there is none.
        cells: Column -> row and content of the first cell that is no number.
        dates: Column of dates, in s since the first -> the instant of that.
    """

    frame: pl.DataFrame
    cells: dict[str, tuple[int, str]]
    dates: dict[str, float]


def read_text(data: bytes) -> RawTable:
    """A table of text: CSV, TSV or columns apart by blanks, in any usual encoding.

    Raises:
        InputError: it is not text, not a header with rows of numbers of one length below it, or
            too large a table.
    """
    text = utf8(data)
    overruns = 0
    if b"overrun" in text:
        text, overruns = _OVERRUN.subn(b"", text)
    layout = text_layout(text)
    _refuse_huge_line(text, layout)
    rows = text.count(b"\n") + 1 - layout.first
    ReadBudget(len(data)).take_cells(rows, layout.width)
    table = _parse(text, layout)
    if overruns:
        note = (f"the sampler overran {overruns} times: samples are missing there, and times by "
                f"{option('columns', {'rate': 'HZ'})} are too early from the first on")  # fmt: skip
        table = replace(table, notes=(*table.notes, note))
    return table


def _refuse_huge_line(text: bytes, layout: TextLayout) -> None:
    """Refuse a line of many MiB before anything copies it.

    Raises:
        InputError: there is one.
    """
    for start in range(0, len(text), _HUGE):
        if len(text) - start >= _HUGE and text.find(b"\n", start, start + _HUGE) < 0:
            begin, end = text.rfind(b"\n", 0, start) + 1, text.find(b"\n", start)
            fields = text.count(layout.separator.encode(), begin, None if end < 0 else end) + 1
            line = text.count(b"\n", 0, begin) + 1
            if layout.separator == " " or fields == layout.width:
                raise InputError(f"line {line} is longer than {_HUGE >> 20} MiB: is it a log?")
            raise InputError(f"line {line} has {fields} fields, the header {len(layout.heads)}")


def _parse(text: bytes, layout: TextLayout) -> RawTable:
    body = text.split(b"\n", layout.first)[layout.first]
    comment = next((c for c in COMMENTS if b"\n" + c.encode() in b"\n" + body[:SNIFFED]), "#")
    heads = _heads(layout)
    if (bare := _bare(body, layout)) is not None:
        names = (h or f"column {i}" for i, h in enumerate(heads, 1))
        lines = np.arange(len(bare)) + layout.first + 1
        return RawTable(dict(zip(names, bare.T.copy(), strict=True)), lines, "line")
    frame = _numbers(body, layout, comment)
    cells: dict[str, tuple[int, str]] = {}
    dates: dict[str, float] = {}
    if frame is None:
        _refuse_long_rows(body, layout, comment)
        frame, cells, dates = _words(body, layout, comment)
    lines = _places(body, layout, comment, frame.height)
    _refuse_short_rows(body, layout, frame, lines)
    columns = {}
    for i, series in enumerate(frame.iter_columns()):
        values = series.to_numpy().astype(float, copy=False)
        if heads[i] or not np.isnan(values).all() or series.name in cells:
            columns[heads[i] or f"column {i + 1}"] = values
    unused = [name for name in columns if _UNUSED.fullmatch(name)]
    for name in unused:
        del columns[name]
    notes = (f"{len(unused)} channels are not selected",) if unused else ()
    written = {str(i): head or f"column {i + 1}" for i, head in enumerate(heads)}
    no_numbers = {written[i]: (f"line {lines[row]}", cell) for i, (row, cell) in cells.items()}
    units = {written[i]: "s" for i in dates}
    origins = {written[i]: origin for i, origin in dates.items()}
    return RawTable(columns, lines, "line", no_numbers, units=units, notes=notes, dates=origins)


def _heads(layout: TextLayout) -> list[str]:
    return unique_names(layout.heads + [""] * (layout.width - len(layout.heads)))


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


def _scan(
    body: bytes, layout: TextLayout, comment: str, dtype: Any, **options: Any
) -> pl.DataFrame:
    import polars as pl  # noqa: PLC0415 - a fifth of a second that `--help` need not pay

    if layout.separator == " ":
        body = re.sub(rb"(?m)^\t|\t$", b"", re.sub(rb"[ \t]+", b"\t", body))
    return pl.read_csv(
        io.BytesIO(body),
        has_header=False,
        schema={str(i): dtype for i in range(layout.width)},
        separator="\t" if layout.separator == " " else layout.separator,
        quote_char='"' if b'"' in body else None,
        comment_prefix=comment,
        missing_columns="insert",
        **options,
    )


def _numbers(body: bytes, layout: TextLayout, comment: str) -> pl.DataFrame | None:
    """The body as numbers, or None if something in it is no number."""
    import polars as pl  # noqa: PLC0415 - as above

    try:
        return _scan(body, layout, comment, pl.Float64, null_values=_NULLS,
                     decimal_comma=layout.decimal_comma)  # fmt: skip
    except (pl.exceptions.PolarsError, pl.exceptions.PanicException):
        return None


def _words(body: bytes, layout: TextLayout, comment: str) -> _Converted:
    """The body with what is no number left empty, and the first such cell of each column."""
    import polars as pl  # noqa: PLC0415 - as above

    try:
        frame = _scan(body, layout, comment, pl.String)
    except (pl.exceptions.PolarsError, pl.exceptions.PanicException) as error:
        raise InputError("cannot be read as a table: save it as plain CSV") from error
    numbers, cells, dates = [], {}, {}
    for series in frame.iter_columns():  # one by one: each is text and its lower case on the way
        words = series.str.strip_chars().str.strip_chars('"')
        missing = words.str.to_lowercase().is_in(sorted(MISSING))
        words = pl.select(pl.when(~missing).then(words)).to_series()
        plain = words.str.replace(",", ".", literal=True) if layout.decimal_comma else words
        values = plain.cast(pl.Float64, strict=False)
        text = words.is_not_null() & values.is_null()
        if text.any() and (since := instants(words)) is not None:
            dates[series.name] = since.origin
            values = pl.Series(series.name, since.t, nan_to_null=True)
        elif text.any() and (other := _other_numbers(words, decimal_comma=layout.decimal_comma)):
            (values,) = other
        elif text.any():
            row = int(text.arg_true()[0])
            cells[series.name] = (row, str(words[row]))
        numbers.append(values)
    return _Converted(pl.DataFrame(numbers), cells, dates)


def _other_numbers(words: pl.Series, *, decimal_comma: bool) -> tuple[pl.Series] | None:
    """True and false, or numbers with a mark each three digits; None if they are neither."""
    import polars as pl  # noqa: PLC0415 - as above

    values = words.str.to_lowercase().replace_strict(_TRUTH, default=None, return_dtype=pl.Float64)
    if values.null_count() == words.null_count():
        return (values,)
    point = "," if decimal_comma else "."
    mark = r"[.' \u{a0}\u{202f}]" if decimal_comma else r"[,' \u{a0}\u{202f}]"
    grouped = rf"^[+-]?\d{{1,3}}(?:{mark}\d{{3}})*(?:[{point}]\d*)?$|^[+-]?\d*[{point}]?\d*$"
    if not words.drop_nulls().str.contains(grouped).all():
        return None
    plain = words.str.replace_all(mark, "").str.replace(point, ".", literal=True)
    values = plain.cast(pl.Float64, strict=False)
    return (values,) if values.null_count() == words.null_count() else None


def _places(body: bytes, layout: TextLayout, comment: str, rows: int) -> np.ndarray[Any, Any]:
    """The line number of each row."""
    mark = comment.encode()
    if b"\n" + mark not in b"\n" + body:
        return np.arange(rows) + layout.first + 1
    filled = (number for number, line in _numbered(body, layout) if not line.startswith(mark))
    lines = np.fromiter(filled, dtype=np.int64)[:rows]
    after = (lines[-1] if len(lines) else 0) + 1
    return np.append(lines, np.arange(rows - len(lines)) + after)  # never too few


def _numbered(body: bytes, layout: TextLayout) -> Iterator[tuple[int, bytes]]:
    """The lines of the body with their numbers; a list of them all would be ten times as long."""
    return enumerate(io.BytesIO(body), layout.first + 1)


def _width(line: bytes, separator: str) -> int:
    """The number of fields in a line."""
    if len(line) > SNIFFED:  # its fields would take fifty times its bytes
        return line.count(separator.encode()) + 1
    return len(split(line.decode(errors="replace").rstrip("\n"), separator))


def _refuse_long_rows(body: bytes, layout: TextLayout, comment: str) -> None:
    for i, line in _numbered(body, layout):
        if line.count(layout.separator.encode()) < layout.width and layout.separator != " ":
            continue
        width = _width(line, layout.separator)
        if width > layout.width and not line.startswith(comment.encode()):
            raise InputError(f"line {i} has {width} fields, the header {len(layout.heads)}")


def _refuse_short_rows(
    body: bytes, layout: TextLayout, frame: pl.DataFrame, numbers: np.ndarray[Any, Any]
) -> None:
    """Polars fills a row that ends early; a log that was cut off is none with gaps."""
    open_ended = frame[frame.columns[len(layout.heads) - 1]].is_null()
    if not open_ended.any():
        return
    lines = _numbered(body, layout)
    for number in numbers[open_ended.to_numpy()]:
        line = next((line for i, line in lines if i == number), b"")
        if line.strip() and (width := _width(line, layout.separator)) < len(layout.heads):
            raise InputError(f"line {number} has {width} fields, the header {len(layout.heads)}")


def _opens(_path: Path, head: bytes) -> bool:
    return is_text(head)


def _open(path: Path, _options: ReadOptions) -> TablesInMemory:
    return TablesInMemory((read_text(whole(path)),))


READER = Reader(
    "text",
    "columns of text: CSV, TSV, blanks; with or without heads, preamble and units",
    (".csv", ".tsv", ".txt", ".dat", ".asc", ".log", ".tab"),
    _opens,
    _open,
)
