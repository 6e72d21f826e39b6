"""The memory that one read may take: an allowance, and a multiple of the file's own size."""

from __future__ import annotations

from dataclasses import dataclass

from ...errors import InputError

#: No larger file is read: bytes.
LARGEST = 2 << 30
#: What any read may take beside the file: bytes, 700,000 rows of two columns.
ALLOWANCE = 64 << 20
#: Bytes beyond that for each byte of the file. A column that moves is packed to a third at best,
#: and one that stands still to nothing: there may be seven of these for each of those.
EXPANSION = 48
#: More than this is never taken, whatever the file: bytes.
MOST = 8 << 30
#: The most columns, variables or names of a log.
MOST_COLUMNS = 10_000
#: The most columns of a matrix, or entries of a list: a wider one is an image or a map.
WIDEST = 512
#: A number in the table, in SI, and in the recording: bytes.
CELL = 24


@dataclass
class ReadBudget:
    """The bytes of memory that a read may still take.

    Args:
        size: Of the file, bytes.
        taken: So far, bytes.
    """

    size: int
    taken: int = 0

    @property
    def total(self) -> int:
        """What the whole read may take, bytes."""
        return min(ALLOWANCE + EXPANSION * self.size, MOST)

    @property
    def most(self) -> str:
        """The same for a message."""
        return _written(self.total)

    def take(self, needed: int, content: str) -> None:
        """Count `needed` bytes before they are taken; `content` says for what, in the plural.

        Raises:
            InputError: all that was counted is more than the budget.
        """
        self.taken += needed
        if self.taken > self.total:
            raise InputError(
                f"{content} need {_written(self.taken)} of memory, and {self.most} is "
                f"the most for a file of {_written(self.size)}: leave out columns that are not "
                "needed, or save it uncompressed"
            )

    def take_cells(self, rows: int, columns: int) -> None:
        """Count a table of numbers, with the places of its rows as two more columns.

        Raises:
            InputError: too many columns, or more than the budget.
        """
        refuse_many(columns, "columns")
        self.take(rows * (columns + 2) * CELL, f"{rows:,} rows of {columns:,} columns")


def refuse_rows(rows: int, columns: int, rate: float) -> None:
    """Refuse more rows of a log than any read may take, and say how long a part of it may be.

    Args:
        rows: That are asked for.
        columns: The same.
        rate: Of the log, Hz.

    Raises:
        InputError: they take more than `MOST`.
    """
    each = (columns + 2) * CELL
    if rows * each > MOST:
        seconds = float(f"{0.95 * MOST / each / rate:.2g}")
        raise InputError(
            f"{rows:,} rows of {columns} columns need {_written(rows * each)} of memory, and "
            f"{_written(MOST)} is the most: give parts of the log of up to {seconds:g} s, as in "
            f"LOG@0s:{seconds:g}s"
        )


def refuse_many(count: int, content: str) -> None:
    """Refuse more columns, variables or names than a log has.

    Raises:
        InputError: there are more than `MOST_COLUMNS`.
    """
    if count > MOST_COLUMNS:
        raise InputError(
            f"has {count:,} {content}, and {MOST_COLUMNS:,} is the most: is each row a sample?"
        )


def _written(size: int) -> str:
    """A size as people read it: three digits and a binary unit."""
    value, unit = float(size), "bytes"
    for larger in ("KiB", "MiB", "GiB", "TiB"):
        if value < 1000:  # noqa: PLR2004 - three digits
            break
        value, unit = value / 1024, larger
    return f"{value:.3g} {unit}"
