"""Lines of a text table whose layout is known, as columns; lines too long or too short refused."""

from __future__ import annotations

import io
import re
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...errors import InputError
from .text_columns import WordColumn
from .text_encoding import SNIFFED
from .text_layout import COMMENTS, MISSING, TextLayout, split

if TYPE_CHECKING:
    import polars as pl

#: Bytes that no line of a log has.
HUGE = 1 << 20
#: Codes of characters.
LINE_FEED, QUOTE = 10, 34
_NULLS = sorted({s for m in MISSING - {"nan"} for s in (m, m.upper(), m.capitalize())})
_NO_TABLE = "cannot be read as a table: save it as plain CSV"


def comment_mark(body: bytes) -> str:
    """What comments among the rows of a table begin with, as its first lines show."""
    return next((c for c in COMMENTS if b"\n" + c.encode() in b"\n" + body[:SNIFFED]), "#")


def count(text: bytes, character: int) -> int:
    """How often a character stands in a text; at several times the speed of its method."""
    return int(np.count_nonzero(np.frombuffer(text, np.uint8) == character))


def refuse_huge_line(text: bytes, layout: TextLayout, first: int = 1) -> None:
    """Refuse a line of many MiB before anything copies it.

    Args:
        text: Lines.
        layout: Theirs.
        first: The number of the first.

    Raises:
        InputError: there is one.
    """
    for start in range(0, len(text), HUGE):
        if len(text) - start >= HUGE and text.find(b"\n", start, start + HUGE) < 0:
            begin, end = text.rfind(b"\n", 0, start) + 1, text.find(b"\n", start)
            fields = text.count(layout.separator.encode(), begin, None if end < 0 else end) + 1
            line = text.count(b"\n", 0, begin) + first
            if layout.separator == " " or fields == layout.width:
                raise InputError(f"line {line} is longer than {HUGE >> 20} MiB: is it a log?")
            raise InputError(f"line {line} has {fields} fields, the header {len(layout.heads)}")


@dataclass(frozen=True)
class TextRows:
    """Rows of a table.

    Args:
        body: Their lines.
        layout: Of the table.
        comment: What lines that are none begin with.
        line: The number of the first line, from 1.
    """

    body: bytes
    layout: TextLayout
    comment: str
    line: int

    def columns(self, state: Mapping[int, WordColumn], row: int = 0) -> pl.DataFrame:
        """Some columns as numbers, named by their place, null where a cell is none.

        Args:
            state: Place of a column -> how its words became numbers in the rows before.
            row: The number of the first row.

        Raises:
            InputError: a row is too long, or it is no table.
        """
        import polars as pl  # noqa: PLC0415 - a fifth of a second that `--help` need not pay

        words = {i for i, column in state.items() if not column.plain}
        frame = self._numbers(state, words)
        if frame is None:
            self.refuse_long_rows()
            words = set(state)
            frame = self._words(state)
        columns = []
        for series in frame.iter_columns():  # one by one: text takes much memory
            place = int(series.name)
            column = state[place]
            columns.append(column.numbers(series, row) if place in words else column.passed(series))
        return pl.DataFrame(columns)

    def count(self) -> int:
        """How many rows there are."""
        mark = self.comment.encode()
        if self._spans_lines:
            return sum(not line.startswith(mark) for _, line in self._numbered())
        lines = count(self.body, LINE_FEED)
        comments = 0 if mark not in self.body else self.body.count(b"\n" + mark)
        comments += self.body.startswith(mark)
        return lines + (bool(self.body) and not self.body.endswith(b"\n")) - comments

    def may_be_long(self, rows: int) -> bool:
        """Whether there may be a row of more fields than the table has columns, among so many.

        Not if separators are no more than all rows have, and none of these may lack one.
        """
        layout = self.layout
        if layout.separator == " ":
            return False  # all columns are parsed, which shows it
        most = rows * (layout.width - 1)
        return layout.width > len(layout.heads) or count(self.body, ord(layout.separator)) > most

    def _numbers(self, kept: Collection[int], words: Collection[int]) -> pl.DataFrame | None:
        """Columns of numbers, some as words, or None if something in the others is no number."""
        import polars as pl  # noqa: PLC0415 - as above

        kinds = [pl.String if i in words else pl.Float64 for i in range(self.layout.width)]
        try:
            return self._scan(kept, kinds, null_values=_NULLS,
                              decimal_comma=self.layout.decimal_comma)  # fmt: skip
        except (pl.exceptions.PolarsError, pl.exceptions.PanicException):
            return None

    def _words(self, kept: Collection[int]) -> pl.DataFrame:
        import polars as pl  # noqa: PLC0415 - as above

        try:
            return self._scan(kept, [pl.String] * self.layout.width)
        except (pl.exceptions.PolarsError, pl.exceptions.PanicException) as error:
            raise InputError(_NO_TABLE) from error

    def _scan(self, kept: Collection[int], kinds: list[Any], **options: Any) -> pl.DataFrame:
        import polars as pl  # noqa: PLC0415 - as above

        body, separator = self.body, self.layout.separator
        if separator == " ":
            body = re.sub(rb"(?m)^\t|\t$", b"", re.sub(rb"[ \t]+", b"\t", body))
        chosen = sorted(kept) if len(kept) < len(kinds) and separator != " " else None
        frame = pl.read_csv(
            body,
            has_header=False,
            schema={str(i): kind for i, kind in enumerate(kinds)},
            columns=chosen,
            separator="\t" if separator == " " else separator,
            quote_char='"' if b'"' in body else None,
            comment_prefix=self.comment if self.comment.encode() in body else None,
            missing_columns="insert",
            **options,
        )
        return frame if chosen is not None else frame.select([str(i) for i in sorted(kept)])

    def places(self, rows: int) -> NDArray[np.int64] | range:
        """The line number of each row."""
        mark = self.comment.encode()
        commented = mark in self.body and b"\n" + mark in b"\n" + self.body
        if not commented and not self._spans_lines:
            return range(self.line, self.line + rows)
        filled = (number for number, line in self._numbered() if not line.startswith(mark))
        lines = np.fromiter(filled, dtype=np.int64)[:rows]
        after = (lines[-1] if len(lines) else 0) + 1
        return np.append(lines, np.arange(rows - len(lines)) + after)  # never too few

    @cached_property
    def _spans_lines(self) -> bool:
        """Whether a quoted cell has a line end in it."""
        if b'"' not in self.body:
            return False
        characters = np.frombuffer(self.body, np.uint8)
        return bool((np.cumsum(characters == QUOTE)[characters == LINE_FEED] % 2).any())

    def _numbered(self) -> Iterator[tuple[int, bytes]]:
        """Rows with the number of their first line; a list of them would be ten times as long."""
        lines = enumerate(io.BytesIO(self.body), self.line)
        if not self._spans_lines:
            yield from lines
            return
        begin = 0
        for number, line in lines:
            end, quotes = begin + len(line), line.count(b'"')
            while quotes % 2 and (following := next(lines, None)) is not None:
                end += len(following[1])
                quotes += following[1].count(b'"')
            yield number, self.body[begin:end]
            begin = end

    def _width(self, line: bytes) -> int:
        """The number of fields in a line."""
        separator = self.layout.separator
        if len(line) > SNIFFED:  # its fields would take fifty times its bytes
            return line.count(separator.encode()) + 1
        return len(split(line.decode(errors="replace").rstrip("\n"), separator))

    def refuse_long_rows(self) -> None:
        """Refuse a row of more fields than the table has columns.

        Raises:
            InputError: there is one.
        """
        layout = self.layout
        for i, line in self._numbered():
            if line.count(layout.separator.encode()) < layout.width and layout.separator != " ":
                continue
            width = 0 if line.count(b'"') % 2 else self._width(line)  # a quote that is not closed
            if width > layout.width and not line.startswith(self.comment.encode()):
                raise InputError(f"line {i} has {width} fields, the header {len(layout.heads)}")

    def refuse_short_rows(self, frame: pl.DataFrame) -> None:
        """Polars fills a row that ends early; a log that was cut off is none with gaps.

        Args:
            frame: What the rows were read as, with the column of the last head.

        Raises:
            InputError: a row has fewer fields than the table has heads.
        """
        heads = len(self.layout.heads)
        open_ended = frame[str(heads - 1)].is_null()
        if not open_ended.any():
            return
        lines = self._numbered()
        for number in np.asarray(self.places(frame.height))[open_ended.to_numpy()]:
            line = next((line for i, line in lines if i == number), b"")
            if line.strip() and (width := self._width(line)) < heads:
                raise InputError(f"line {number} has {width} fields, the header {heads}")
