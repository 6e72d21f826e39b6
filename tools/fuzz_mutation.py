"""Damage to an input, of bytes and of what they say, the same for the same random numbers."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from random import Random

#: Pieces that readers have to think about: quotes, line ends, signs, numbers beyond all measure.
_PIECES = tuple(
    piece.encode()
    for piece in (
        '"', "'", "\r", "\n", "\r\n", '\r"', "\n\n", "\t", " ", ",", ";", "#", "//", "%", "[", "]",
        "{", "}", "<", ">", "&", "=", ":", "-", "±", "\ufeff", "\x00", "\x1b[31m", "٣", "😀", "nan",
        "inf", "-inf", "1e999", "-0.0", "1e-320", "0x1p3", "1_000", "9" * 401, "null", "true",
        '"a": 1, "a": 2', "\\u0000", "\\ud800", "<!--", "]]>", "&#0;", "--", "--out", "--set",
        "F_S=", "1:2", "[" * 1500, '{"a":' * 1500,
    )
)  # fmt: skip
_NUMBER = re.compile(rb"-?\d+(?:\.\d+)?(?:[eE][+-]?\d+)?")
_NUMBERS = (
    b"0", b"-1", b"1e308", b"1e-308", b"nan", b"NaN", b"Infinity", b"1e999", b'"x"', b"null",
    b"9" * 401, b"4294967296", b"-2147483648", b"0.1", b"true", b"[]", b"{}", b"1" * 5000,
)  # fmt: skip
_WORD = re.compile(rb"[A-Za-z_]{2,}")
_LONGEST = 1 << 20


def mutated(corpus: Sequence[bytes], random: Random) -> bytes:
    """An input of the corpus with one to eight pieces of damage."""
    data = random.choice(corpus)
    for _ in range(random.choice((1, 1, 1, 2, 2, 3, 5, 8))):
        data = random.choice(_DAMAGE)(data, corpus, random)[:_LONGEST]
    return data


def _byte(data: bytes, _: Sequence[bytes], random: Random) -> bytes:
    at = random.randrange(len(data) + 1)
    return data[:at] + bytes([random.randrange(256)]) + data[at + 1 :]


def _bit(data: bytes, _: Sequence[bytes], random: Random) -> bytes:
    if not data:
        return data
    at = random.randrange(len(data))
    return data[:at] + bytes([data[at] ^ 1 << random.randrange(8)]) + data[at + 1 :]


def _extreme(data: bytes, _: Sequence[bytes], random: Random) -> bytes:
    """A field of 1, 2, 4 or 8 bytes that has its least or largest number, or nearly."""
    width = random.choice((1, 2, 4, 8))
    at = random.randrange(len(data) + 1)
    field = random.choice((b"\x00", b"\xff", b"\x7f", b"\x80")) * width
    return data[:at] + field + data[at + width :]


def _inserted(data: bytes, _: Sequence[bytes], random: Random) -> bytes:
    at = random.randrange(len(data) + 1)
    return data[:at] + random.choice(_PIECES) + data[at:]


def _cut(data: bytes, _: Sequence[bytes], random: Random) -> bytes:
    a, b = sorted(random.randrange(len(data) + 1) for _ in "ab")
    return data[:a] + data[min(b, a + random.choice((1, 4, 16, 100, 10_000))) :]


def _ended(data: bytes, _: Sequence[bytes], random: Random) -> bytes:
    return data[: random.randrange(len(data) + 1)]


def _repeated(data: bytes, _: Sequence[bytes], random: Random) -> bytes:
    a, b = sorted(random.randrange(len(data) + 1) for _ in "ab")
    return data[:b] + data[a:b] * random.choice((1, 1, 3, 50)) + data[b:]


def _spliced(data: bytes, corpus: Sequence[bytes], random: Random) -> bytes:
    other = random.choice(corpus)
    return data[: random.randrange(len(data) + 1)] + other[random.randrange(len(other) + 1) :]


def _number(data: bytes, _: Sequence[bytes], random: Random) -> bytes:
    return _replaced(_NUMBER, data, random.choice(_NUMBERS), random)


def _word(data: bytes, _: Sequence[bytes], random: Random) -> bytes:
    words = _WORD.findall(data[:4096])
    return _replaced(_WORD, data, random.choice([*words, b"x", b"nan", b""]), random)


def _replaced(pattern: re.Pattern[bytes], data: bytes, by: bytes, random: Random) -> bytes:
    place = pattern.search(data, random.randrange(len(data) + 1)) or pattern.search(data)
    if place is None:
        return data + by
    return data[: place.start()] + by + data[place.end() :]


_DAMAGE: tuple[Callable[[bytes, Sequence[bytes], Random], bytes], ...] = (
    _byte, _bit, _bit, _extreme, _inserted, _inserted, _cut, _ended, _repeated, _spliced, _number,
    _number, _word,
)  # fmt: skip
