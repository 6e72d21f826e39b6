"""Columns of numbers in text whose layout is known; a cell that is no number is empty."""

from __future__ import annotations

import io
import re
from typing import TYPE_CHECKING, Any

from ...errors import InputError

if TYPE_CHECKING:
    import polars as pl

_NULLS = ["", " "]


def number_columns(body: bytes, width: int, separator: str) -> pl.DataFrame:
    """Columns `0`, `1` and on; a row that ends early has empty cells.

    Raises:
        InputError: it is no table.
    """
    import polars as pl  # noqa: PLC0415 - a fifth of a second that `--help` need not pay

    sample = body[: 1 << 16]
    comma = separator != "," and b"," in sample and b"." not in sample
    comma |= separator == "," and re.search(rb'"-?\d+,\d+"', sample) is not None
    options: dict[str, Any] = {
        "separator": separator,
        "has_header": False,
        "null_values": _NULLS,
        "missing_columns": "insert",
        "quote_char": '"' if b'"' in body else None,
    }
    names = [str(i) for i in range(width)]
    try:
        return pl.read_csv(
            io.BytesIO(body),
            schema=dict.fromkeys(names, pl.Float64),
            decimal_comma=comma,
            **options,
        )
    except (pl.exceptions.PolarsError, pl.exceptions.PanicException):
        pass
    try:
        words = pl.read_csv(
            io.BytesIO(body),
            schema=dict.fromkeys(names, pl.String),
            truncate_ragged_lines=True,
            **options,
        )
    except (pl.exceptions.PolarsError, pl.exceptions.PanicException) as error:
        raise InputError("its samples cannot be read as columns: export it again") from error
    mixed = pl.col(pl.String).str.strip_chars().str.replace(",", ".", literal=True)
    return words.select(mixed.cast(pl.Float64, strict=False))
