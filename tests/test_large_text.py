"""Text read in blocks: what a whole read gives, wherever the blocks end."""

from __future__ import annotations

import gzip
import math
import re
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stribeck.data import read
from stribeck.data.readers import delimited
from stribeck.data.readers.delimited import read_text
from stribeck.data.readers.interval import Interval
from stribeck.data.readers.raw_table import RawTable
from stribeck.data.readers.text_blocks import large_text
from stribeck.errors import InputError

#: Blocks shorter than a line, of some lines, and longer than the text.
BLOCKS = (7, 64, 333, 100_000)


def rows(n: int, form: str = "{t:.3f},{x!r},{f!r}") -> list[str]:
    rng = np.random.default_rng(3)
    return [
        form.format(t=0.01 * k, x=float(rng.normal()), f=float(rng.normal()), k=k) for k in range(n)
    ]


def text(head: str, lines: list[str]) -> str:
    return "\n".join([head, *lines]) + "\n"


HEAD = "t [s],x [mm],F [N]"
SEMICOLON = "t [s];x [mm];F [N]"
STAMPED = [f"2024-05-03T23:59:{k // 10 + 50:02d}.{k % 10}00+02:00,{0.1 * k!r},3" for k in range(99)]
TEXTS: dict[str, bytes] = {
    "plain": text(HEAD, rows(50)).encode(),
    "unfinished": text(HEAD, rows(50)).encode()[:-1],
    "returns": text(HEAD, rows(50)).replace("\n", "\r\n").encode(),
    "old": text(HEAD, rows(50)).replace("\n", "\r").encode(),
    "commas": text(SEMICOLON, rows(50, "{t:.3f};{x!r};{f!r}")).replace(".", ",").encode(),
    "trailing": text(SEMICOLON, rows(50, "{t:.3f};{x!r};{f!r};")).encode(),
    "blanks": text("t_s  x_mm\tF_N", rows(50, " {t:.3f}   {x!r}\t{f!r} ")).encode(),
    "comments": text(HEAD, [w for r in rows(30) for w in (r, "# a, comment")]).encode(),
    "blank lines": text(HEAD, [*rows(20), "", *rows(20), ""]).encode(),
    "preamble": text("made by a drive\nno. 5\n\n" + HEAD, rows(50)).encode(),
    "no heads": "\n".join(rows(50)).encode(),
    "long head": text(
        HEAD + "".join(f",channel number {k}" for k in range(60)), [r + ",1" * 60 for r in rows(9)]
    ).encode(),
    "marked": b"\xef\xbb\xbf" + text(HEAD, rows(50)).encode(),
    "wide": text("t [s],Länge 実 [mm],F [N]", rows(50)).encode("utf-16"),
    "wide, reversed": text("t [s],Länge [mm],F [N]", rows(50)).encode("utf-16-be"),
    "utf-8": text("t [s],Position 実位置 [mm],F [N]", rows(40, "{t},{x!r},{f!r}")).encode(),
    "utf-8 words": text(HEAD + ",mode", rows(40, "{t},{x!r},{f!r},実位置実位置")).encode(),
    "latin": text("t [s],Länge [mm],F [N]", rows(50)).encode("latin-1"),
    "latin later": text(HEAD + ",mode", rows(40, "{t},{x!r},{f!r},größer")).encode("latin-1"),
    "words": text(HEAD + ",a", [*rows(20, "{t},{x},{f},1"), *rows(9, "{t},{x},{f},on")]).encode(),
    "quoted lines": text(
        HEAD + ",note", rows(30, '{t},{x!r},{f!r},"first\nsecond, {k}\n\nand ""last"""')
    ).encode(),
    "quoted numbers": text(HEAD, rows(30, '"{t}","{x!r}","{f!r}"')).encode(),
    "empty cells": text(HEAD, [*rows(9), "0.5,,1", "0.6,nan,2", "0.7,N/A,-", *rows(9)]).encode(),
    "dates": text("time,x [mm],F [N]", STAMPED).encode(),
    "of day": text("time,x [mm]", [f"{h:02d}:59:00.25,{h}" for h in (*range(24), 0, 1)]).encode(),
    "dates, then words": text("time,x [mm],F [N]", [*STAMPED, "late,1,2", *STAMPED]).encode(),
    "truth": text(HEAD + ",on", [f"{k},1,2,{k % 3 == 0}" for k in range(40)]).encode(),
    "truth, then numbers": text(HEAD + ",on", [
        *[f"{k},1,2,{k % 3 == 0}" for k in range(40)], *[f"{k},1,2,{k}" for k in range(40)]
    ]).encode(),
    "grouped": text(SEMICOLON, [f"{k},5;{k}.{k:03d};1" for k in range(2, 60)]).encode(),
    "plain, then grouped": text(SEMICOLON, [
        *[f"{k},5;{k}.{k:03d};1" for k in range(2, 60)], "99,5;1.234.567;1"
    ]).encode(),
    "unused": text(HEAD + ",not selected,unused", rows(30, "{t},{x},{f},0,0")).encode(),
    "overruns": text("t_s x_mm", [*rows(20, "{t} {x}"), "overrun", *rows(9, "{t} {x}")]).encode(),
}  # fmt: skip


def same(one: RawTable, other: RawTable) -> None:
    assert list(one.columns) == list(other.columns)
    for name, values in one.columns.items():
        np.testing.assert_array_equal(values, other.columns[name], name)
    np.testing.assert_array_equal(one.places, other.places)
    assert (one.text, one.units, one.dates) == (other.text, other.units, other.dates)


@pytest.mark.parametrize("name", TEXTS)
@pytest.mark.parametrize(("block", "packed"), [*((b, False) for b in BLOCKS), (64, True)])
def test_blocks_give_the_same_bits_as_a_whole_read(
    name: str, block: int, packed: bool, tmp_path: Path
) -> None:
    path = tmp_path / "log.csv"
    path.write_bytes(gzip.compress(TEXTS[name]) if packed else TEXTS[name])
    whole = read_text(TEXTS[name])
    log = large_text(path, block)
    (table,) = log.tables()
    same(whole, table)
    assert [c.name for c in log.channels] == list(whole.columns)
    assert {c.count for c in log.channels} == {len(whole.places)}
    assert set(whole.notes) == set(log.problems)
    for column in whole.columns:
        (alone,) = log.tables([column])
        np.testing.assert_array_equal(alone.columns[column], whole.columns[column])


def refusal(data: bytes, path: Path, block: int) -> str:
    path.write_bytes(data)
    with pytest.raises(InputError) as caught:
        large_text(path, block).tables(["t [s]"])
    return str(caught.value)


@pytest.mark.parametrize("block", BLOCKS)
@pytest.mark.parametrize(
    ("lines", "words"),
    [
        ([*rows(40), "0.4,1.5"], "line 42 has 2 fields, the header 3"),
        ([*rows(20), "0.4,1.5", *rows(20)], "line 22 has 2 fields, the header 3"),
        ([*rows(20), "0.4,1.5,2.5,3.5", *rows(20)], "line 22 has 4 fields, the header 3"),
        ([*rows(20), "1,2,3,4", "1,2", *rows(20)], "line 2[23] has [24] fields, the header 3"),
        ([*rows(20), "1\0,2,3"], "is not text"),
    ],
)
def test_torn_lines_are_refused_with_their_place(
    lines: list[str], words: str, block: int, tmp_path: Path
) -> None:
    data = text(HEAD, lines).encode()
    with pytest.raises(InputError, match=words):
        read_text(data)
    assert re.search(words, refusal(data, tmp_path / "log.csv", block))


def test_what_has_no_line_ends_is_refused_before_it_is_in_memory(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    line = text(HEAD, rows(40)).encode() + b"1," * (4 << 20)
    assert "line 42 has " in refusal(line, path, 1 << 16)
    quote = text(HEAD, [*rows(40), '"1,2,3', *["1,2,3"] * 700_000]).encode()
    assert refusal(quote, path, 1 << 16) == (
        "has a quote behind line 41 that is not closed: save it as plain CSV"
    )


def test_a_torn_archive_is_refused(tmp_path: Path) -> None:
    packed = gzip.compress(text(HEAD, rows(4000)).encode())
    assert "broken gzip archive" in refusal(packed[: len(packed) // 2], tmp_path / "log.csv.gz", 64)


@pytest.mark.parametrize("name", ["plain", "blanks", "comments", "wide", "dates", "quoted lines"])
@pytest.mark.parametrize("packed", [False, True])
def test_an_interval_is_read_with_its_neighbours_alone(
    name: str, packed: bool, tmp_path: Path
) -> None:
    path = tmp_path / "log.csv"
    path.write_bytes(gzip.compress(TEXTS[name]) if packed else TEXTS[name])
    whole = read_text(TEXTS[name])
    time, *others = whole.columns
    t = whole.columns[time]
    for first, last in ((20, 24), (0, 3), (len(t) - 4, len(t) - 1), (5, len(t) - 3)):
        (part,) = large_text(path, 100).part(others, Interval(time, t[first], t[last]))
        near = slice(max(first - 16, 0), last + 17)
        for column in whole.columns:
            np.testing.assert_array_equal(part.columns[column], whole.columns[column][near])
        np.testing.assert_array_equal(part.places, whole.places[near])


cells = st.sampled_from(
    ["0", "1.5", "-2e3", "", "nan", "on", "1,5", '"1"', '"a\nb"', "TRUE", "1.234.567", "12:30:00"]
)


@given(st.lists(st.lists(cells, min_size=3, max_size=3), max_size=12), st.integers(5, 80))
@settings(max_examples=150, deadline=None)
def test_any_cells_are_read_alike(table: list[list[str]], block: int) -> None:
    data = text(HEAD, ["0,1,2", "1,2,3", *(",".join(row) for row in table)]).encode()
    import tempfile  # noqa: PLC0415 - hypothesis runs a function many times in one `tmp_path`

    with tempfile.NamedTemporaryFile() as file:
        file.write(data)
        file.flush()
        try:
            whole = read_text(data)
        except InputError:
            with pytest.raises(InputError):
                large_text(Path(file.name), block).tables()
            return
        same(whole, large_text(Path(file.name), block).tables()[0])


def test_large_files_are_opened_in_blocks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "log.csv"
    path.write_bytes(TEXTS["plain"])
    monkeypatch.setattr(delimited, "LARGE", 100)
    blocks = read(path)
    monkeypatch.setattr(delimited, "LARGE", 1 << 30)
    whole = read(path)
    np.testing.assert_array_equal(blocks.position, whole.position)
    assert blocks.notes == whole.notes


def moving(n: int) -> bytes:
    """A log of n rows at 100 Hz from 5 s on, with a column of words."""
    t = [5 + 0.01 * k for k in range(n)]
    lines = [f"{a:.2f},{math.sin(a)!r},{math.cos(a)!r},idle" for a in t]
    return text("t [s],x [mm],v [mm/s],mode", lines).encode()


@pytest.mark.parametrize("large", [False, True])
def test_a_window_of_a_large_log_is_that_of_a_small_one(
    large: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "log.csv"
    path.write_bytes(moving(3000))
    monkeypatch.setattr(delimited, "LARGE", 100 if large else 1 << 30)
    monkeypatch.setattr(delimited, "large_text", partial(large_text, block=5000))
    part = read(f"{path}@10s:12.5s")
    np.testing.assert_allclose(part.position, 1e-3 * np.sin(np.arange(15.0, 17.495, 0.01)))
    assert part.t[0] == 0.0
    assert part.source is not None
    assert part.source.rows == 3000
    with pytest.raises(InputError, match=r"200s:300s holds 0 samples: the log lasts 29.99 s"):
        read(f"{path}@200s:300s")


def test_a_window_is_read_without_the_rest(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "log.csv"
    path.write_bytes(moving(3000).replace(b"\n30.00,", b"\n30.00,torn"))
    monkeypatch.setattr(delimited, "LARGE", 100)
    monkeypatch.setattr(delimited, "large_text", partial(large_text, block=5000))
    assert len(read(f"{path}@10s:12.5s")) == 250
    with pytest.raises(InputError, match="line 2502, column x"):
        read(path)
