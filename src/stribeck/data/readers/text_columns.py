"""A column of words as numbers, by one rule for all of it, whatever the pieces that it comes in.

The rules, in order: plain numbers; dates and times of day, in each form in which the first word can
be read; true and false; numbers with a mark each three digits. Where none fits, the column has
text, and what is a plain number in it stays one.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING

from ...space import Array
from .stamps import StampForm, past_midnight, stamp_forms
from .text_layout import MISSING

if TYPE_CHECKING:
    import polars as pl

_TRUTH = {"true": 1.0, "false": 0.0}
_Rule = Callable[["pl.Series"], "pl.Series | None"]


class WordColumn:
    """The rule by which a column's words are numbers, as the pieces so far have it.

    Args:
        decimal_comma: Whether numbers have a comma for a point.

    `text` is the row and the content of the first cell that no rule fits, None while there is none.
    `outdated` says that a later piece changed the rule: earlier ones have to be converted again.
    """

    def __init__(self, *, decimal_comma: bool) -> None:
        self._comma = decimal_comma
        self._rules: list[tuple[_Rule, StampForm | None]] | None = None
        self._rule, self._used = 0, False
        self.text: tuple[int, str] | None = None
        self.outdated = False

    @property
    def plain(self) -> bool:
        """Whether all words so far are plain numbers."""
        return self._rule == 0

    @property
    def stamps(self) -> StampForm | None:
        """The form of its dates or times of day, None if it has none."""
        rules = self._rules or []
        return rules[self._rule][1] if self._rule < len(rules) else None

    def restart(self) -> None:
        """Begin with the first piece again, by the rule that the pieces so far came to."""
        self._used, self.text, self.outdated = False, None, False

    def passed(self, numbers: pl.Series) -> pl.Series:
        """The next piece, which was read as plain numbers."""
        self._used |= numbers.null_count() < numbers.len()
        return numbers

    def numbers(self, cells: pl.Series, row: int) -> pl.Series:
        """The next piece as numbers, null where a cell is empty or has text.

        Args:
            cells: The words.
            row: The number of the first.
        """
        import polars as pl  # noqa: PLC0415 - a fifth of a second that `--help` need not pay

        words = cells.str.strip_chars().str.strip_chars('"')
        missing = words.str.to_lowercase().is_in(sorted(MISSING))
        words = pl.select(pl.when(~missing).then(words)).to_series()
        values = self._plain(words) if self._rule == 0 else None
        if values is None:
            values = self._by_rules(words, row)
        self._used |= words.null_count() < words.len()
        return values.alias(cells.name)

    def _by_rules(self, words: pl.Series, row: int) -> pl.Series:
        if self._rules is None:
            rest: list[_Rule] = [_truth, partial(_grouped, decimal_comma=self._comma)]
            forms = [(partial(_since_first, form), form) for form in stamp_forms(words)]
            self._rules = [(self._plain, None), *forms, *((rule, None) for rule in rest)]
        while self._rule < len(self._rules):
            values = self._rules[self._rule][0](words)
            if values is not None:
                return values
            self._rule += 1
            self.outdated |= self._used
        values = self._cast(words)
        text = words.is_not_null() & values.is_null()
        if self.text is None and text.any():
            first = int(text.arg_true()[0])
            self.text = row + first, str(words[first])
        return values

    def _cast(self, words: pl.Series) -> pl.Series:
        import polars as pl  # noqa: PLC0415 - as above

        plain = words.str.replace(",", ".", literal=True) if self._comma else words
        return plain.cast(pl.Float64, strict=False)

    def _plain(self, words: pl.Series) -> pl.Series | None:
        values = self._cast(words)
        return values if values.null_count() == words.null_count() else None

    def whole(self, values: Array) -> Array:
        """The column of all pieces: times of day that go back went past midnight."""
        return past_midnight(values) if self.stamps is not None and self.stamps.of_day else values


def _since_first(form: StampForm, words: pl.Series) -> pl.Series | None:
    import polars as pl  # noqa: PLC0415 - as above

    t = form.since_first(words)
    return None if t is None else pl.Series("", t, nan_to_null=True)


def _truth(words: pl.Series) -> pl.Series | None:
    import polars as pl  # noqa: PLC0415 - as above

    values = words.str.to_lowercase().replace_strict(_TRUTH, default=None, return_dtype=pl.Float64)
    return values if values.null_count() == words.null_count() else None


def _grouped(words: pl.Series, *, decimal_comma: bool) -> pl.Series | None:
    """Numbers with a mark each three digits."""
    import polars as pl  # noqa: PLC0415 - as above

    point = "," if decimal_comma else "."
    mark = r"[.' \u{a0}\u{202f}]" if decimal_comma else r"[,' \u{a0}\u{202f}]"
    grouped = rf"^[+-]?\d{{1,3}}(?:{mark}\d{{3}})*(?:[{point}]\d*)?$|^[+-]?\d*[{point}]?\d*$"
    if not words.drop_nulls().str.contains(grouped).all():
        return None
    plain = words.str.replace_all(mark, "").str.replace(point, ".", literal=True)
    values = plain.cast(pl.Float64, strict=False)
    return values if values.null_count() == words.null_count() else None
