"""Text tables: separators, decimal commas, preambles and encodings found out, then parsed.

A table of bare numbers goes through NumPy, which is there already, up to a size at which polars
has made up for its start; whatever is larger or less plain is read by polars.
"""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ...errors import InputError
from ...space import Array
from .budget import ReadBudget
from .file_bytes import whole
from .heads import is_unit
from .log_file import Reader, ReadOptions, TablesInMemory
from .raw_table import RawTable, unique_names
from .stamps import seconds

if TYPE_CHECKING:
    import polars as pl

_SNIFFED = 1 << 16
#: Share of rows of one width from which on a table without heads is one.
_ALIKE = 0.9
_HUGE = 1 << 20  # bytes that no line of a log has
_SMALL = 8 << 20  # bytes that NumPy parses in the time that polars takes to start
_BARE = b"0123456789.eE+-\n"
_OVERRUN = re.compile(rb"(?m)^overrun[ \t]*(?:\n|$)")  # as halsampler of LinuxCNC writes it
_SEPARATORS = ("\t", ";", ",", "|", " ")
_COMMENTS = ("#", "%", "//")
_MISSING = {"", "nan", "na", "n/a", "#n/a", "null", "none", "-", "--", "?", "nil"}
_TRUTH = {"true": 1.0, "false": 0.0}
_NULLS = sorted({s for m in _MISSING - {"nan"} for s in (m, m.upper(), m.capitalize())})
_NUMBER = re.compile(r"[+-]?(\d+([.,]\d*)?|[.,]\d+)([eE][+-]?\d+)?")
_DATE_OR_GROUPED = re.compile(
    r"\d{1,4}[-/.]\d{1,2}[-/.]\d{1,4}([T ]+\d.*)?|\d{1,2}:\d{2}(:\d.*)?|\d{8}T\d{6}.*|"
    r"[+-]?\d{1,3}([,.' ]\d{3})+([.,]\d*)?"
)
_WORD_AND_UNIT = re.compile(r"[^\s\[(]+(?:\s{0,9}[\[(][^\])]{0,30}[\])])?")
_CONTROL = re.compile(rb"[\x00-\x08\x0e-\x1a\x1c-\x1f]")
_UNUSED = re.compile(r"(?:not selected|unused|not used|none)(?: #\d+)?", re.IGNORECASE)
_MARKS = ((b"\xff\xfe", "utf-16"), (b"\xfe\xff", "utf-16"), (b"\xef\xbb\xbf", "utf-8-sig"))


class _Converted(NamedTuple):
    """Columns of words as numbers.

    Args:
        frame: The numbers, null where there is none.
        cells: Column -> row and content of the first cell that is no number.
        dates: Columns of dates, in s since the first.
    """

    frame: pl.DataFrame
    cells: dict[str, tuple[int, str]]
    dates: set[str]


@dataclass(frozen=True)
class _Layout:
    heads: list[str]
    first: int  # the line where data starts, from 0
    first_numbers: int  # the first line of numbers, from 0
    width: int
    separator: str
    decimal_comma: bool


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
    layout = _sniff(text)
    _refuse_huge_line(text, layout)
    rows = text.count(b"\n") + 1 - layout.first
    ReadBudget(len(data)).take_cells(rows, layout.width)
    table = _parse(text, layout)
    if overruns:
        note = (f"the sampler overran {overruns} times: samples are missing there, and times by "
                "--rate are too early from the first on")  # fmt: skip
        table = replace(table, notes=(*table.notes, note))
    return table


def _refuse_huge_line(text: bytes, layout: _Layout) -> None:
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


def utf8(data: bytes) -> bytes:
    """The text in UTF-8 with plain line ends.

    Raises:
        InputError: it is no text.
    """
    encoding = next((e for mark, e in _MARKS if data.startswith(mark)), None) or _wide(data)
    try:
        if encoding:
            data = data.decode(encoding).encode()
        elif not data.isascii():
            data.decode()
    except UnicodeDecodeError:
        data = data.decode("latin-1").encode()
    if _CONTROL.search(data, 0, _SNIFFED) or b"\0" in data:
        raise InputError("is not text: export the log as CSV, Parquet or MATLAB 5")
    line_end = b"\r\n" if b"\n" in data else b"\r"
    return data.replace(line_end, b"\n") if b"\r" in data else data


def _wide(data: bytes) -> str | None:
    """UTF-16 without a mark, known by its zero bytes."""
    head = np.frombuffer(data[: _SNIFFED & -2][: len(data) & -2], dtype=np.uint8)
    zero = (head.reshape(-1, 2) == 0).mean(axis=0) if len(head) else np.zeros(2)
    if zero[1] > 0.9 and zero[0] == 0:  # noqa: PLR2004 - Latin text has a zero in each pair
        return "utf-16-le"
    return "utf-16-be" if zero[0] > 0.9 and zero[1] == 0 else None  # noqa: PLR2004


def _sniff(text: bytes) -> _Layout:
    head = text[:_SNIFFED].decode(errors="replace")
    lines = head.split("\n")
    lines = lines[:-1] if len(text) > _SNIFFED and len(lines) > 1 else lines
    if not any(line.strip() for line in lines):
        raise InputError("is empty")
    for strict, headless in ((True, False), (True, True), (False, False)):
        layouts = [
            x for s in _SEPARATORS
            if (x := _layout(lines, s, strict=strict, headless=headless))
        ]  # fmt: skip
        if layouts:
            return min(layouts, key=lambda x: x.first_numbers)
    if len(text) > _SNIFFED and len(lines) == 1:
        raise InputError(f"line 1 is longer than {_SNIFFED >> 10} KiB: leave out columns")
    raise InputError(_what_is_wrong(lines))


def _layout(lines: list[str], separator: str, *, strict: bool, headless: bool) -> _Layout | None:
    """The first row of numbers under a header of as many fields, or without any, or None."""
    heads: list[str] = []
    first = 0
    for i, line in enumerate(lines):
        comment = next((c for c in _COMMENTS if line.lstrip().startswith(c)), None)
        fields = _split(line.lstrip()[len(comment) :] if comment else line, separator)
        numbers = sum(_is_number(f) or _DATE_OR_GROUPED.fullmatch(f) is not None for f in fields)
        if len(_trimmed(fields)) < 2:  # noqa: PLR2004 - one field is no table
            continue
        if numbers == 0 and not all(map(_is_missing, fields)):
            if heads and i == first and len(fields) == len(heads) > 1:
                heads, first = _with_second(heads, fields), i + 1
            else:
                heads = _split(line.lstrip()[len(comment or "") :], separator, heads=True)
                first = i + 1
        elif (
            comment is None
            and _is_row(fields, numbers, strict=strict)
            and ((headless and not heads) or _fit(heads, fields))
        ):
            if headless and _of_width(lines[i:], separator, len(fields)) < _ALIKE:
                return None
            return _Layout(
                [f"column {k}" for k, _ in enumerate(_trimmed(fields), 1)]
                if headless
                else _trimmed(heads),
                i if headless else first,
                i,
                max(len(heads), len(fields)),
                separator,
                separator != "," and _decimal_comma(lines[i : i + 100], separator),
            )
    return None


def _of_width(lines: list[str], separator: str, width: int) -> float:
    """The share of lines that are rows of numbers of one width."""
    filled = [line for line in lines if line.strip()]
    rows = [fields for line in filled if _is_numbers(fields := _split(line, separator))]
    return sum(len(fields) == width for fields in rows) / len(filled)


def _split(line: str, separator: str, *, heads: bool = False) -> list[str]:
    line = line.strip(" \r")
    if separator == " ":
        return _WORD_AND_UNIT.findall(line) if heads else line.split()
    fields = line.split(separator)
    if '"' in line:
        with suppress(csv.Error):  # a damaged line: its quotes are characters like any other
            fields = next(csv.reader([line], delimiter=separator), [])
    return [f.strip() for f in fields]


def _trimmed(fields: list[str]) -> list[str]:
    n = len(fields)
    while n and not fields[n - 1]:
        n -= 1
    return fields[:n]


def _is_number(field: str) -> bool:
    return _NUMBER.fullmatch(field) is not None


def _is_missing(field: str) -> bool:
    return field.lower() in _MISSING


def _is_row(fields: list[str], numbers: int, *, strict: bool) -> bool:
    missing = sum(map(_is_missing, fields))
    return numbers >= 2 - (missing > 0) and (numbers + missing == len(fields) or not strict)


def _is_numbers(fields: list[str]) -> bool:
    return len(fields) > 1 and _is_row(fields, sum(map(_is_number, fields)), strict=True)


def _fit(heads: list[str], fields: list[str]) -> bool:
    return bool(heads) and (
        len(heads) == len(fields) or len(_trimmed(heads)) == len(_trimmed(fields))
    )


def _with_second(heads: list[str], second: list[str]) -> list[str]:
    """Heads with a row beneath them that has units, or what each channel measures."""
    return [_with_cell(h, cell) for h, cell in zip(heads, second, strict=True)]


def _with_cell(head: str, cell: str) -> str:
    bare = cell.strip("[]()")
    if is_unit(bare):
        return f"{head} [{bare}]"
    return head if _is_missing(cell) else cell


def _decimal_comma(lines: list[str], separator: str) -> bool:
    numbers = [f for line in lines for f in _split(line, separator) if _is_number(f)]
    return any("," in f for f in numbers) and not any("." in f for f in numbers)


def _what_is_wrong(lines: list[str]) -> str:
    """Why no table was found."""
    filled = [line for line in lines if line.strip() and not line.lstrip().startswith(_COMMENTS)]
    rows = [(line, s) for line in filled for s in _SEPARATORS if _is_numbers(_split(line, s))]
    if not rows and len(filled) <= 1:
        return "has a header and no rows of numbers"
    if not rows:
        return "has no rows of at least two numbers: a log needs a header, time and position"
    line, s = rows[0]
    n, heads = len(_split(line, s)), len(_split(filled[0], s, heads=True))
    hint = ": decimal commas need ; or tab between columns" if n == 2 * heads and s == "," else ""
    return f"line {lines.index(line) + 1} has {n} fields, the header {heads}{hint}"


def _parse(text: bytes, layout: _Layout) -> RawTable:
    body = text.split(b"\n", layout.first)[layout.first]
    comment = next((c for c in _COMMENTS if b"\n" + c.encode() in b"\n" + body[:_SNIFFED]), "#")
    heads = _heads(layout)
    if (bare := _bare(body, layout)) is not None:
        names = (h or f"column {i}" for i, h in enumerate(heads, 1))
        lines = np.arange(len(bare)) + layout.first + 1
        return RawTable(dict(zip(names, bare.T.copy(), strict=True)), lines, "line")
    frame = _numbers(body, layout, comment)
    cells: dict[str, tuple[int, str]] = {}
    dates: set[str] = set()
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
    no_numbers = {written[i]: cell for i, cell in cells.items()}
    units = {written[i]: "s" for i in dates}
    return RawTable(columns, lines, "line", no_numbers, units=units, notes=notes)


def _heads(layout: _Layout) -> list[str]:
    return unique_names(layout.heads + [""] * (layout.width - len(layout.heads)))


def _bare(body: bytes, layout: _Layout) -> Array | None:
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


def _scan(body: bytes, layout: _Layout, comment: str, dtype: Any, **options: Any) -> pl.DataFrame:
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


def _numbers(body: bytes, layout: _Layout, comment: str) -> pl.DataFrame | None:
    """The body as numbers, or None if something in it is no number."""
    import polars as pl  # noqa: PLC0415 - as above

    try:
        return _scan(body, layout, comment, pl.Float64, null_values=_NULLS,
                     decimal_comma=layout.decimal_comma)  # fmt: skip
    except (pl.exceptions.PolarsError, pl.exceptions.PanicException):
        return None


def _words(body: bytes, layout: _Layout, comment: str) -> _Converted:
    """The body with what is no number left empty, and the first such cell of each column."""
    import polars as pl  # noqa: PLC0415 - as above

    try:
        frame = _scan(body, layout, comment, pl.String)
    except (pl.exceptions.PolarsError, pl.exceptions.PanicException) as error:
        raise InputError("cannot be read as a table: save it as plain CSV") from error
    numbers, cells, dates = [], {}, set()
    for series in frame.iter_columns():  # one by one: each is text and its lower case on the way
        words = series.str.strip_chars().str.strip_chars('"')
        missing = words.str.to_lowercase().is_in(sorted(_MISSING))
        words = pl.select(pl.when(~missing).then(words)).to_series()
        plain = words.str.replace(",", ".", literal=True) if layout.decimal_comma else words
        values = plain.cast(pl.Float64, strict=False)
        text = words.is_not_null() & values.is_null()
        if text.any() and (t := seconds(words)) is not None:
            dates.add(series.name)
            values = pl.Series(series.name, t, nan_to_null=True)
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


def _places(body: bytes, layout: _Layout, comment: str, rows: int) -> np.ndarray[Any, Any]:
    """The line number of each row."""
    mark = comment.encode()
    if b"\n" + mark not in b"\n" + body:
        return np.arange(rows) + layout.first + 1
    filled = (number for number, line in _numbered(body, layout) if not line.startswith(mark))
    lines = np.fromiter(filled, dtype=np.int64)[:rows]
    after = (lines[-1] if len(lines) else 0) + 1
    return np.append(lines, np.arange(rows - len(lines)) + after)  # never too few


def _numbered(body: bytes, layout: _Layout) -> Iterator[tuple[int, bytes]]:
    """The lines of the body with their numbers; a list of them all would be ten times as long."""
    return enumerate(io.BytesIO(body), layout.first + 1)


def _width(line: bytes, separator: str) -> int:
    """The number of fields in a line."""
    if len(line) > _SNIFFED:  # its fields would take fifty times its bytes
        return line.count(separator.encode()) + 1
    return len(_split(line.decode(errors="replace").rstrip("\n"), separator))


def _refuse_long_rows(body: bytes, layout: _Layout, comment: str) -> None:
    for i, line in _numbered(body, layout):
        if line.count(layout.separator.encode()) < layout.width and layout.separator != " ":
            continue
        width = _width(line, layout.separator)
        if width > layout.width and not line.startswith(comment.encode()):
            raise InputError(f"line {i} has {width} fields, the header {len(layout.heads)}")


def _refuse_short_rows(
    body: bytes, layout: _Layout, frame: pl.DataFrame, numbers: np.ndarray[Any, Any]
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
    marked = head.startswith(tuple(mark for mark, _ in _MARKS)) or _wide(head) is not None
    return marked or not (_CONTROL.search(head) or b"\0" in head)


def _open(path: Path, _options: ReadOptions) -> TablesInMemory:
    return TablesInMemory((read_text(whole(path)),))


READER = Reader(
    "text",
    "columns of text: CSV, TSV, blanks; with or without heads, preamble and units",
    (".csv", ".tsv", ".txt", ".dat", ".asc", ".log", ".tab"),
    _opens,
    _open,
)
