"""A table, and the forms in which it is written: terminal, text, Markdown, LaTeX, CSV, HTML."""

from __future__ import annotations

import csv
import io
import math
import re
import textwrap
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Self, TypeAlias

from .format import DASH, grouped

if TYPE_CHECKING:
    from markupsafe import Markup
    from rich.table import Table as RichTable

Value: TypeAlias = float | str | None
#: Columns of a line of the text form's note.
_WIDTH = 100


@dataclass(frozen=True)
class Cell:
    """One place of a table.

    Args:
        text: As it is shown.
        value: In full; None where there is none.
        parts: Further values that the text shows, such as an interval's ends; in a CSV file
            each has a column of its own.
    """

    text: str
    value: Value = None
    parts: Mapping[str, float] = field(default_factory=dict)

    @classmethod
    def label(cls, text: str) -> Self:
        """A name, or a sentence."""
        return cls(text, text)

    @classmethod
    def number(cls, value: float, digits: int = 4) -> Self:
        """A number; nan says that there is none."""
        return cls(grouped(value, digits), None if math.isnan(value) else value)


@dataclass(frozen=True)
class Table:
    """A table.

    Args:
        title: What it shows, in one line.
        heads: The columns' heads.
        rows: As many cells a row as there are heads; the first one names its row.
        note: What a reader must know to read it right.
        labels: Columns of text, by number, which stand to the left; None where the values tell.
        sentences: Columns of sentences, which may be broken.
        unbroken: Columns whose text is never broken.
        chosen: The row that stands out.
    """

    title: str
    heads: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]
    note: str = ""
    labels: frozenset[int] | None = None
    sentences: frozenset[int] = frozenset()
    unbroken: frozenset[int] = frozenset()
    chosen: int | None = None

    @classmethod
    def of_texts(
        cls,
        title: str,
        heads: Sequence[str],
        rows: Iterable[Sequence[str]],
        labels: Iterable[int] = (0,),
        *,
        note: str = "",
        sentences: Iterable[int] = (),
        unbroken: Iterable[int] = (),
        chosen: int | None = None,
    ) -> Self:
        """A table of what is shown alone; all columns but `labels` are numbers."""
        names = frozenset(labels)
        return cls(
            title,
            tuple(heads),
            tuple(tuple(_read(text, k in names) for k, text in enumerate(row)) for row in rows),
            note,
            names,
            frozenset(sentences),
            frozenset(unbroken),
            chosen,
        )

    @property
    def numeric(self) -> list[bool]:
        """Which columns are of numbers, and stand to the right."""
        if self.labels is not None:
            return [k not in self.labels for k in range(len(self.heads))]
        columns = zip(*self.rows, strict=True) if self.rows else [()] * len(self.heads)
        return [
            any(isinstance(c.value, int | float) for c in column)
            and not any(isinstance(c.value, str) for c in column)
            for column in columns
        ]

    def terminal(self) -> RichTable:
        """For the terminal, as wide as that is, without the title: long cells are folded."""
        from rich.table import Table as RichTable  # noqa: PLC0415 - files need none

        table = RichTable(box=None, pad_edge=False)
        for k, (head, numeric) in enumerate(zip(self.heads, self.numeric, strict=True)):
            table.add_column(
                head,
                justify="right" if numeric else "left",
                overflow="fold",
                no_wrap=k in self.unbroken,
            )
        for k, row in enumerate(self.rows):
            table.add_row(*(c.text for c in row), style="bold" if k == self.chosen else None)
        return table

    def text(self) -> str:
        """For a file that is read as it stands: columns aligned, numbers to the right."""
        lines = [self.heads, *([c.text for c in row] for row in self.rows)]
        widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
        sides = [str.rjust if numeric else str.ljust for numeric in self.numeric]
        shown = [
            "  ".join(side(t, w) for side, t, w in zip(sides, line, widths, strict=True)).rstrip()
            for line in lines
        ]
        rule = "  ".join("-" * w for w in widths)
        end = [textwrap.fill(line, _WIDTH) for line in self._end]
        return "\n".join([self.title, "", shown[0], rule, *shown[1:], *end]) + "\n"

    def markdown(self) -> str:
        """For a page in Markdown, as GitHub reads tables."""
        marks = ["---:" if numeric else "---" for numeric in self.numeric]
        lines = [
            list(map(_in_markdown, self.heads)),
            marks,
            *([_in_markdown(c.text) for c in row] for row in self.rows),
        ]
        body = [f"| {' | '.join(line)} |" for line in lines]
        end = list(map(_in_markdown, self._end))
        return "\n".join([f"**{_in_markdown(self.title)}**", "", *body, *end]) + "\n"

    def latex(self) -> str:
        """For a paper: a `table` that needs no package."""
        columns = "".join("r" if numeric else "l" for numeric in self.numeric)
        body = [" & ".join(_cell_in_latex(c) for c in row) + r" \\" for row in self.rows]
        lines = [
            r"\begin{table}",
            rf"\caption{{{_in_latex(self.title)}}}",
            rf"\begin{{tabular}}{{{columns}}}",
            r"\hline",
            " & ".join(map(_in_latex, self.heads)) + r" \\",
            r"\hline",
            *body,
            r"\hline",
            r"\end{tabular}",
            *([rf"\par {_in_latex(self.note)}"] if self.note else []),
            r"\end{table}",
        ]
        return "\n".join(lines) + "\n"

    def csv(self) -> str:
        """For other programs: values in full, every part in a column of its own."""
        heads, rows = self._in_full()
        out = io.StringIO()
        csv.writer(out, lineterminator="\n").writerows([heads, *rows])
        return out.getvalue()

    def document(self) -> dict[str, Any]:
        """The same for JSON."""
        heads, rows = self._in_full()
        return {"title": self.title, "note": self.note, "heads": heads, "rows": rows}

    def _in_full(self) -> tuple[list[str], list[list[Value]]]:
        """Heads and values, every part in a column of its own."""
        parts = [
            list(dict.fromkeys(name for cell in column for name in cell.parts))
            for column in zip(*self.rows, strict=True)
        ] or [[] for _ in self.heads]
        named = list(zip(self.heads, parts, strict=True))
        heads = [f"{head} {name}".rstrip() for head, names in named for name in ("", *names)]
        rows = [
            [
                value
                for cell, names in zip(row, parts, strict=True)
                for value in (cell.value, *(cell.parts.get(n) for n in names))
            ]
            for row in self.rows
        ]
        return heads, rows

    def html(self) -> Markup:
        """For a page: a `table` in a box that scrolls, its note below; what is shown is escaped."""
        from markupsafe import Markup, escape  # noqa: PLC0415 - files and terminals need none

        right = [numeric and k > 0 for k, numeric in enumerate(self.numeric)]
        title = escape(self.title)
        heads = "".join(
            f'<th scope="col"{_class("n" if side else "")}>{escape(head)}</th>'
            for head, side in zip(self.heads, right, strict=True)
        )
        lines = [
            f'<div class="scroll" tabindex="0" role="region" aria-label="{title}">',
            "<table>",
            f"<caption>{title}</caption>",
            f"<thead><tr>{heads}</tr></thead>",
            "<tbody>",
        ]
        for row in self.rows:
            first, *rest = (escape(cell.text) for cell in row)
            cells = [self._html_cell(k, text, right=right[k]) for k, text in enumerate(rest, 1)]
            lines.append(f'<tr><th scope="row">{first}</th>{"".join(cells)}</tr>')
        lines += ["</tbody>", "</table>", "</div>"]
        if self.note:
            lines.append(f'<p class="note">{escape(self.note)}</p>')
        return Markup("\n".join(lines))  # noqa: S704 - every text in it is escaped

    def _html_cell(self, column: int, text: str, *, right: bool) -> str:
        from markupsafe import escape  # noqa: PLC0415 - as above

        head = f' data-head="{escape(self.heads[column])}"'
        if self.heads[column] == "verdict":
            chip = f'<span class="chip {text.split(" ", maxsplit=1)[0]}">{text}</span>'
            return f"<td{head}>{chip}</td>"
        kind = "n" if right else ""
        if column in self.sentences:
            kind = "wide" if column == len(self.heads) - 1 else "narrow"
        elif self.heads[column] == "SHA-256":
            kind = "hash"
        return f"<td{_class(kind)}{head}>{text}</td>"

    @property
    def _end(self) -> list[str]:
        return ["", self.note] if self.note else []


#: The forms of a file, by its ending.
FORMS = {"txt": Table.text, "md": Table.markdown, "tex": Table.latex, "csv": Table.csv}


def _read(text: str, label: bool) -> Cell:
    """A cell of its text: what reads as a number is one."""
    if label or not text:
        return Cell(text, text)
    if text == DASH:
        return Cell(text)
    try:
        return Cell(text, float(text.replace(",", "")))
    except ValueError:
        return Cell(text, text)


def _class(name: str) -> str:
    return f' class="{name}"' if name else ""


def _in_markdown(text: str) -> str:
    return re.sub(r"([\\`*_|<>\[\]])", r"\\\1", text)


_LATEX = {
    "\\": r"\textbackslash{}",
    **{c: f"\\{c}" for c in "&%$#_{}"},
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "<": "$<$",
    ">": "$>$",
    "∞": r"$\infty$",
    "–": "--",
}  # fmt: skip


def _in_latex(text: str) -> str:
    return "".join(_LATEX.get(c, c) for c in text)


def _cell_in_latex(cell: Cell) -> str:
    if isinstance(cell.value, str):
        return _in_latex(cell.text)
    marked = re.split(r"(-?\d[\d,]*(?:\.\d+)?e-?\d+|-(?:\d[\d,]*(?:\.\d+)?|∞))", cell.text)
    return "".join(_math(t) if i % 2 else _in_latex(t) for i, t in enumerate(marked))


def _math(token: str) -> str:
    mantissa, _, power = token.replace("∞", r"\infty").partition("e")
    return f"${mantissa}\\times10^{{{power}}}$" if power else f"${mantissa}$"
