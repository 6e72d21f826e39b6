"""How a table of text is laid out: separator, heads, decimal mark, where its numbers begin."""

from __future__ import annotations

import csv
import re
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property

from ...errors import InputError
from .heads import is_unit
from .raw_table import unique_names
from .text_encoding import SNIFFED

#: Share of rows of one width from which on a table without heads is one.
_ALIKE = 0.9
#: Numbers from which on a column is one of samples.
_FEWEST = 10
_SEPARATORS = ("\t", ";", ",", "|", " ")
#: What a line begins with that is none of the table.
COMMENTS = ("#", "%", "//")
#: Cells that are empty, in lower case.
MISSING = {"", "nan", "na", "n/a", "#n/a", "null", "none", "-", "--", "?", "nil"}
_NUMBER = re.compile(r"[+-]?(\d+([.,]\d*)?|[.,]\d+)([eE][+-]?\d+)?")
_DATE_OR_GROUPED = re.compile(
    r"\d{1,4}[-/.]\d{1,2}[-/.]\d{1,4}([T ]+\d.*)?|\d{1,2}:\d{2}(:\d.*)?|\d{8}T\d{6}.*|"
    r"[+-]?\d{1,3}([,.' ]\d{3})+([.,]\d*)?"
)
_WORD_AND_UNIT = re.compile(r"[^\s\[(]+(?:\s{0,9}[\[(][^\])]{0,30}[\])])?")


@dataclass(frozen=True)
class TextLayout:
    """The layout of a table.

    Args:
        heads: Names of its columns, units in brackets.
        first: The line where data starts, from 0.
        first_numbers: The first line of numbers, from 0.
        width: Fields in a line.
        separator: Between them; a blank stands for any number of these.
        decimal_comma: Whether numbers have a comma for a point.
    """

    heads: list[str]
    first: int
    first_numbers: int
    width: int
    separator: str
    decimal_comma: bool

    @cached_property
    def names(self) -> list[str]:
        """The heads of all columns, each once; empty where there is none."""
        return unique_names(self.heads + [""] * (self.width - len(self.heads)))


def text_layout(text: bytes) -> TextLayout:
    """The layout of a text.

    Raises:
        InputError: it has no rows of numbers of one width.
    """
    head = text[:SNIFFED].decode(errors="replace")
    lines = head.split("\n")
    lines = lines[:-1] if len(text) > SNIFFED and len(lines) > 1 else lines
    if not any(line.strip() for line in lines):
        raise InputError("is empty")
    for strict, headless in ((True, False), (True, True), (False, False)):
        layouts = [
            x for s in _SEPARATORS
            if (x := _layout(lines, s, strict=strict, headless=headless))
        ]  # fmt: skip
        if layouts:
            return min(layouts, key=lambda x: x.first_numbers)
    if len(text) > SNIFFED and len(lines) == 1:
        raise InputError(f"line 1 is longer than {SNIFFED >> 10} KiB: leave out columns")
    if (single := _single_column(lines)) is not None:
        return single
    raise InputError(_what_is_wrong(lines))


def _single_column(lines: list[str]) -> TextLayout | None:
    """The layout of one number a line below at most one line of words, or None."""
    fields = [line.strip(" \r\t,;") for line in lines]
    filled = [
        i for i, field in enumerate(fields) if field and not field.startswith((*COMMENTS, "---"))
    ]
    headed = bool(filled) and not _is_number(fields[filled[0]])
    rows = filled[headed:]
    if len(rows) < _FEWEST or not all(_is_number(fields[i]) for i in rows):
        return None
    heads = [fields[filled[0]].strip('"') if headed else "column 1"]
    comma = _decimal_comma([fields[i] for i in rows[:100]], "\t")
    ending = lines[rows[0]].rstrip(" \r")[-1]
    separator, width = (ending, 2) if ending in ";,\t" else ("\t", 1)
    return TextLayout(heads, rows[0], rows[0], width, separator, comma)


def _layout(lines: list[str], separator: str, *, strict: bool, headless: bool) -> TextLayout | None:
    """The first row of numbers under a header of as many fields, or without any, or None."""
    heads: list[str] = []
    first = 0
    for i, line in enumerate(lines):
        comment = next((c for c in COMMENTS if line.lstrip().startswith(c)), None)
        fields = split(line.lstrip()[len(comment) :] if comment else line, separator)
        numbers = sum(_is_number(f) or _DATE_OR_GROUPED.fullmatch(f) is not None for f in fields)
        if len(_trimmed(fields)) < 2:  # noqa: PLR2004 - one field is no table
            continue
        if numbers == 0 and not all(map(_is_missing, fields)):
            if heads and i == first and len(fields) == len(heads) > 1:
                heads, first = _with_second(heads, fields), i + 1
            else:
                heads = split(line.lstrip()[len(comment or "") :], separator, heads=True)
                first = i + 1
        elif (
            comment is None
            and _is_row(fields, numbers, strict=strict)
            and ((headless and not heads) or _fit(heads, fields))
        ):
            if headless and _of_width(lines[i:], separator, len(fields)) < _ALIKE:
                return None
            return TextLayout(
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
    rows = [fields for line in filled if _is_numbers(fields := split(line, separator))]
    return sum(len(fields) == width for fields in rows) / len(filled)


def split(line: str, separator: str, *, heads: bool = False) -> list[str]:
    """The fields of a line, without blanks around them; of a line of heads the words with units."""
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
    return field.lower() in MISSING


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
    numbers = [f for line in lines for f in split(line, separator) if _is_number(f)]
    return any("," in f for f in numbers) and not any("." in f for f in numbers)


def _what_is_wrong(lines: list[str]) -> str:
    """Why no table was found."""
    filled = [line for line in lines if line.strip() and not line.lstrip().startswith(COMMENTS)]
    rows = [(line, s) for line in filled for s in _SEPARATORS if _is_numbers(split(line, s))]
    if not rows and len(filled) <= 1:
        return "has a header and no rows of numbers"
    if not rows:
        return "has no rows of at least two numbers: a log needs a header, time and position"
    line, s = rows[0]
    n, heads = len(split(line, s)), len(split(filled[0], s, heads=True))
    hint = ": decimal commas need ; or tab between columns" if n == 2 * heads and s == "," else ""
    return f"line {lines.index(line) + 1} has {n} fields, the header {heads}{hint}"
