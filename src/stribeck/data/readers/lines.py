"""The lines of a text file in blocks, of any usual encoding, packed or not.

A block ends at a line end outside of quotes, so that no line, no character of several bytes and no
quoted cell lies in two.
"""

from __future__ import annotations

import gzip
import zlib
from codecs import getincrementaldecoder
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from ...errors import InputError
from .budget import ALLOWANCE, EXPANSION
from .file_bytes import BROKEN_GZIP, GZIP
from .text_encoding import NO_TEXT, encoding_mark
from .text_layout import TextLayout
from .text_rows import HUGE, LINE_FEED, QUOTE, count, refuse_huge_line
from .text_table import without_overruns

_RETURN = 13


class LineBlock(NamedTuple):
    """Some lines.

    Args:
        at: Where they begin, bytes.
        size: Their bytes.
        line: The number of the first.
        overruns: How many of them only say that the sampler was too late; these are not counted.
    """

    at: int
    size: int
    line: int
    overruns: int


@dataclass(frozen=True)
class Encoding:
    """How the characters of a file are written.

    Args:
        name: As Python calls it.
        mark: Bytes before the first.
        end: The character that ends a line.
    """

    name: str
    mark: int
    end: int

    @classmethod
    def of(cls, head: bytes, otherwise: str) -> Encoding:
        """That of the first bytes of a file; `otherwise` where they have no mark of one."""
        name, mark = encoding_mark(head) or (otherwise, 0)
        unit = cls(name, mark, LINE_FEED)
        ends = {LINE_FEED, _RETURN} & set(np.unique(unit.units(head[mark:])).tolist())
        return cls(name, mark, _RETURN if ends == {_RETURN} else LINE_FEED)

    def units(self, raw: bytes) -> NDArray[np.unsignedinteger]:
        """Bytes, or pairs of them, of which each character is one at least."""
        kind = {"utf-16-le": "<u2", "utf-16-be": ">u2"}.get(self.name, "u1")
        return np.frombuffer(raw, kind, count=len(raw) // np.dtype(kind).itemsize)

    def text(self, raw: bytes, *, torn: bool = False) -> bytes:
        """The same in UTF-8 with plain line ends.

        Args:
            raw: Bytes of the file.
            torn: Whether they may end within a character, which is left out then.

        Raises:
            UnicodeDecodeError: it is not so written.
            InputError: it is no text.
        """
        if torn:
            raw = getincrementaldecoder(self.name)().decode(raw).encode()
        elif self.name != "utf-8":
            raw = raw.decode(self.name).encode()
        elif not raw.isascii():
            raw.decode()
        if b"\0" in raw:
            raise InputError(NO_TEXT)
        if b"\r" in raw:
            raw = raw.replace(b"\r" if self.end == _RETURN else b"\r\n", b"\n")
        return raw

    def cut(self, raw: bytes) -> int:
        """The bytes up to the last line end outside of quotes, 0 if there is none."""
        units = self.units(raw)
        ends = np.flatnonzero(units == self.end)
        quotes = units == QUOTE
        if quotes.any():
            ends = ends[np.cumsum(quotes)[ends] % 2 == 0]
        return (int(ends[-1]) + 1) * units.itemsize if len(ends) else 0

    def after(self, raw: bytes, lines: int) -> int:
        """The bytes of so many lines."""
        units = self.units(raw)
        ends = np.flatnonzero(units == self.end)
        return (int(ends[lines - 1]) + 1) * units.itemsize if lines else 0


@dataclass(frozen=True)
class LinedFile:
    """The lines of a file.

    Args:
        path: Its path.
        encoding: Of its characters.
        block: Bytes of a block, about.
    """

    path: Path
    encoding: Encoding
    block: int

    @property
    def size(self) -> int:
        """Bytes of the file on its disk."""
        return self.path.stat().st_size

    def head(self, count: int) -> bytes:
        """The first bytes behind its mark."""
        with unpacked(self.path) as file:
            file.seek(self.encoding.mark)
            return file.read(count)

    def blocks(self, at: int, layout: TextLayout) -> Iterator[tuple[LineBlock, bytes]]:
        """The blocks of its rows with their lines in UTF-8, from their first byte on.

        Raises:
            UnicodeDecodeError: it is not of this encoding.
            InputError: it is no text, or has a line or a quoted cell of many MiB.
        """
        line, rest = layout.first + 1, b""
        most = ALLOWANCE + EXPANSION * self.size
        with unpacked(self.path) as file:
            file.seek(at)
            wanted = self.block
            while True:
                raw = rest + file.read(wanted - len(rest))
                ended = len(raw) < wanted
                cut = len(raw) if ended else self.encoding.cut(raw)
                if cut == 0 and not ended:
                    self._refuse_endless(raw, layout, line)
                    wanted, rest = 2 * wanted, raw
                    continue
                if not cut:
                    return
                text = self.encoding.text(raw[:cut])
                refuse_huge_line(text, layout, line)
                text, overruns = without_overruns(text)
                yield LineBlock(at, cut, line, overruns), text
                at, rest = at + cut, raw[cut:]
                wanted = max(self.block, 2 * len(rest))
                line += count(text, LINE_FEED)
                if at > most:
                    raise InputError("unpacks to more than a log does: unpack it first")

    def _refuse_endless(self, raw: bytes, layout: TextLayout, line: int) -> None:
        if len(raw) > max(2 * HUGE, self.block):
            refuse_huge_line(self.encoding.text(raw[: len(raw) & -2]), layout, line)
            raise InputError(
                f"has a quote behind line {line - 1} that is not closed: save it as plain CSV"
            )

    def each(
        self, blocks: Sequence[LineBlock], most: int | None = None
    ) -> Iterator[tuple[LineBlock, bytes]]:
        """Blocks with their lines in UTF-8, or with the first of these, `most` bytes about."""
        with unpacked(self.path) as file:
            for block in blocks:
                file.seek(block.at)
                raw = file.read(block.size if most is None else min(most, block.size))
                cut = len(raw) if most is None else self.encoding.cut(raw)
                if not cut:
                    raw += file.read(block.size - len(raw))
                yield block, without_overruns(self.encoding.text(raw[: cut or len(raw)]))[0]


@contextmanager
def unpacked(path: Path) -> Iterator[BinaryIO]:
    """A file, or what is packed in it with gzip.

    Raises:
        InputError: it cannot be unpacked.
    """
    with path.open("rb") as file:
        packed = file.read(len(GZIP)) == GZIP
        file.seek(0)
        if not packed:
            yield file
            return
        try:
            with gzip.open(file) as stream:
                yield cast("BinaryIO", stream)
        except (OSError, EOFError, zlib.error) as error:
            raise InputError(BROKEN_GZIP) from error
