"""Files that ask for more memory than a file of their size may, and those that may have it."""

from __future__ import annotations

import io
import json
import struct
import subprocess
import sys
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple, cast

import numpy as np
import polars as pl
import pytest
import scipy.io

from stribeck.compensate.settings import read_settings
from stribeck.data import read
from stribeck.data.readers.budget import ALLOWANCE, EXPANSION, ReadBudget
from stribeck.errors import InputError
from stribeck.identify.card import read_card
from stribeck.report.contents.schema import read_report

#: The most that a process takes that reads a file which is refused, MiB.
MOST = 300
_READER = """
import resource, sys
from pathlib import Path
from stribeck.data import read
from stribeck.errors import InputError
for file in sys.argv[1:]:
    try:
        answer = repr(read(file))
    except InputError as error:
        answer = str(error)
    status = Path("/proc/self/status")
    if status.exists():  # `ru_maxrss` begins with that of the process that started this one
        peak = next(int(x.split()[1]) for x in status.open() if x.startswith("VmHWM"))
    else:
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    others = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
    print(max(peak, others) // 1024, answer)
"""


class Answer(NamedTuple):
    """What a process that read a file says, and the most memory it took until then, MiB."""

    mebibytes: int
    sentence: str


def answers(*files: Path) -> list[Answer]:
    """One process reads the files, smaller ones first, so that each has its own peak."""
    command = [sys.executable, "-P", "-c", _READER, *map(str, files)]
    ended = subprocess.run(command, capture_output=True, text=True, check=True)
    assert ended.stderr == ""
    lines = [line.split(" ", 1) for line in ended.stdout.splitlines()]
    assert len(lines) == len(files)
    return [Answer(int(peak), sentence) for peak, sentence in lines]


def element(kind: int, data: bytes) -> bytes:
    return struct.pack("<II", kind, len(data)) + data + bytes(-len(data) % 8)


def described(name: str, *dims: int) -> bytes:
    """The flags, dimensions and name of a MATLAB matrix of double numbers."""
    flags = element(6, struct.pack("<II", 6, 0))
    return flags + element(5, np.array(dims, "<i4").tobytes()) + element(1, name.encode())


def packed(*elements: bytes) -> bytes:
    """A MATLAB file of compressed elements."""
    head = b"MATLAB 5.0 MAT-file".ljust(124) + struct.pack("<H", 0x0100) + b"IM"
    streams = [zlib.compress(e, 9) for e in elements]
    return head + b"".join(struct.pack("<II", 15, len(s)) + s for s in streams)


def stream(head: bytes, block: bytes, times: int) -> bytes:
    """A zlib stream of a head and so many times a block, which is packed once."""
    first, again = zlib.compressobj(9), zlib.compressobj(9, wbits=-15)
    data = first.compress(head) + first.flush(zlib.Z_FULL_FLUSH)
    data += (again.compress(block) + again.flush(zlib.Z_FULL_FLUSH)) * times
    check = zlib.adler32(head)
    for _ in range(times):
        check = zlib.adler32(block, check)
    return data + zlib.compressobj(9, wbits=-15).flush() + struct.pack(">I", check)


def compressed(*streams: bytes) -> bytes:
    """A MATLAB file of elements that are packed."""
    return packed() + b"".join(struct.pack("<II", 15, len(s)) + s for s in streams)


def many_elements(mebibytes: int) -> bytes:
    """A matrix of elements that have nothing in them, 131,072 a mebibyte."""
    block, head = struct.pack("<II", 9, 0) * (1 << 17), described("x_mm", 1, 1)
    size = len(head) + mebibytes * len(block)
    return compressed(stream(struct.pack("<II", 14, size) + head, block, mebibytes))


def many_zeros(mebibytes: int) -> bytes:
    """As many bytes of zeros in one variable, and in the next."""
    cells = mebibytes << 20
    matrix = described("x_mm", cells, 1) + struct.pack("<II", 2, cells)
    zeros = stream(struct.pack("<II", 14, len(matrix) + cells) + matrix, bytes(1 << 20), mebibytes)
    return compressed(zeros, zeros)


def many_variables() -> bytes:
    one = element(9, bytes(8))
    return packed(*(element(14, described(f"v{i}", 1, 1) + one) for i in range(10_001)))


def wide_matrix() -> bytes:
    cells = element(2, bytes(4_000_000))
    return packed(element(14, described("v", 2, 2_000_000) + cells))


def many_scalars() -> bytes:
    """A log of 100,000 rows with single numbers that become columns of as many rows."""
    axis = {"t_s": np.arange(100_000.0), "x_mm": np.arange(100_000.0) % 7}
    buffer = io.BytesIO()
    scalars = {f"v{i}": 1.0 for i in range(5000)}
    scipy.io.savemat(cast("str", buffer), {**axis, **scalars}, do_compression=True)
    return buffer.getvalue()


def new_names(rows: int, names: int) -> bytes:
    records = [{f"k{i}": 1} if i < names else {} for i in range(rows)]
    return json.dumps(records, separators=(",", ":")).encode()


def table(width: int, rows: int, row: str) -> bytes:
    head = ",".join(["t_s", "x_mm", *(f"c{i}" for i in range(width - 2))])
    return "\n".join([head, *["1,2" + ",1" * (width - 2)] * 2, *[row] * rows]).encode()


def parquet(**columns: Any) -> bytes:
    buffer = io.BytesIO()
    pl.DataFrame(columns).write_parquet(buffer)
    return buffer.getvalue()


def damaged_parquet() -> bytes:
    """A page whose first run of validity bits claims more rows than fit in memory."""
    data = bytearray(parquet(t_s=np.arange(30) * 0.01, x_mm=np.arange(30) ** 2.0))
    at = data.index(bytes([2, 0, 0, 0, 60, 1]))  # length of the runs, one run of 30 ones
    data[at + 4 : at + 6] = b"\xff\xff"
    return bytes(data)


def still() -> bytes:
    """Within the budget: 600,000 rows of a log in which nothing moves."""
    n = 600_000
    buffer = io.BytesIO()
    log = {"t_s": np.arange(n, dtype="i4"), "x_mm": np.zeros(n, dtype="i1")}
    scipy.io.savemat(cast("str", buffer), log, do_compression=True)
    return buffer.getvalue()


HOSTILE: dict[str, tuple[Callable[[], bytes], str]] = {
    "elements.mat": (lambda: many_elements(17), "is a broken MATLAB file"),
    "more.mat": (lambda: many_elements(135), "the numbers up to x_mm need 135 MiB of memory"),
    "zeros.mat": (lambda: many_zeros(57), "the numbers up to x_mm need 1.39 GiB of memory, and 69"),
    "bomb.mat": (lambda: many_zeros(1500), "need 36.6 GiB of memory, and 206 MiB is the most"),
    "variables.mat": (many_variables, "has 10,001 variables"),
    "still.mat": (still, "nothing moves: position is the same in all 600000 rows"),
    "matrix.mat": (wide_matrix, "has 2,000,000 columns in v"),
    "scalars.mat": (many_scalars, "100,000 rows of 5,002 columns need 11.2 GiB"),
    "names.json": (lambda: new_names(99_999, 9_999), "99,999 rows of 9,999 columns need 22.4 GiB"),
    "new.json": (lambda: new_names(26_000, 26_000), "has 10,001 names in its records"),
    "lists.json": (lambda: b"[[" + b"[]," * 3_000_000 + b"[]]]", "its lists need"),
    "entries.json": (lambda: b"[" + b"[]," * 200_000 + b"[]]", "has no list of records"),
    "objects.json": (lambda: b"[" + b"{}," * 200_000 + b"{}]", "have no numbers in them"),
    "head.csv": (lambda: b"t_s,x_mm" + b",a" * 3_000_000, "line 1 is longer than 64 KiB"),
    "line.csv": (lambda: table(2, 1, "1," * 3_000_000), "line 4 has 3000001 fields, the header 2"),
    "longer.csv": (
        lambda: table(2, 1, "1," * 50_000_000),
        "line 4 has 50000001 fields, the header 2",
    ),
    "columns.csv": (
        lambda: table(6_000, 300_000, "1,2"),
        "300,002 rows of 6,000 columns need 40.2 GiB",
    ),
    "same.csv": (
        lambda: b"t_s,x_mm" + b",a" * 9_000 + b"\n" + b"1," * 9_001 + b"2" + b"\n",
        "has 1 usable sample",
    ),
    "quote.csv": (lambda: table(2, 20, "1,2") + b'\n"' + b"1,2\n" * 500_000, "read as a table"),
    "zeros.parquet": (
        lambda: parquet(t_s=np.zeros(5_000_000), x_mm=np.zeros(5_000_000)),
        "5,000,000 rows of 2 columns need 458 MiB of memory, and 65.5 MiB is the most",
    ),
    "texts.parquet": (
        lambda: parquet(t_s=[0.0] * 9, x_mm=[1.0] * 9, w=["a" * 50_000_000] * 3 + [None] * 6),
        "polars cannot read",
    ),
    "damaged.parquet": (damaged_parquet, "is a Parquet file that polars cannot read"),
}


@pytest.fixture(scope="module")
def refusals(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Answer]:
    folder = tmp_path_factory.mktemp("hostile")
    for name, (content, _) in HOSTILE.items():
        (folder / name).write_bytes(content())
    return dict(zip(HOSTILE, answers(*(folder / name for name in HOSTILE)), strict=True))


@pytest.mark.parametrize(("name", "reason"), [(n, r) for n, (_, r) in HOSTILE.items()])
def test_a_file_that_asks_for_too_much_is_refused_within_bounds(
    name: str, reason: str, refusals: dict[str, Answer]
) -> None:
    assert refusals[name].sentence.startswith(f"{name}: ")
    assert reason in refusals[name].sentence
    assert refusals[name].mebibytes < MOST


def test_the_refusal_says_what_a_read_may_take() -> None:
    budget = ReadBudget(3 << 20)
    assert budget.total == ALLOWANCE + EXPANSION * (3 << 20)
    budget.take(budget.total, "numbers")
    with pytest.raises(InputError) as caught:
        budget.take(1, "numbers")
    assert str(caught.value) == (
        "numbers need 208 MiB of memory, and 208 MiB is the most for a file of 3 MiB: leave out "
        "columns that are not needed, or save it uncompressed"
    )


def test_what_a_log_leaves_out_takes_nothing(tmp_path: Path) -> None:
    """A cell array, a structure and lists beside the log are not unpacked."""
    t = np.arange(1000) * 0.01
    buffer = io.BytesIO()
    cell = np.empty(1, dtype=object)
    cell[0] = np.zeros(10_000_000)
    more = {"cell": cell, "structure": {"x_mm": np.zeros(9)}}
    scipy.io.savemat(cast("str", buffer), {"t_s": t, "x_mm": t**2, **more}, do_compression=True)
    (tmp_path / "log.mat").write_bytes(buffer.getvalue())
    lists = pl.Series([np.zeros(10_000_000), *[np.zeros(1)] * 999])
    (tmp_path / "log.parquet").write_bytes(parquet(t_s=t, x_mm=t**2, lists=lists))
    for peak, sentence in answers(tmp_path / "log.mat", tmp_path / "log.parquet"):
        assert "1000 samples" in sentence
        assert peak < MOST


def test_a_log_of_the_usual_compression_is_read(tmp_path: Path) -> None:
    """Several columns that stand still take next to nothing in the file."""
    t = np.arange(500_000) * 0.001
    x = np.round(np.sin(t) * 100, 3)
    constant = {f"c{i}": np.ones(len(t)) for i in range(8)}
    scipy.io.savemat(tmp_path / "a.mat", {"t_s": t, "x_mm": x, **constant}, do_compression=True)
    (tmp_path / "a.parquet").write_bytes(parquet(t_s=t, x_mm=x, **constant))
    for name in ("a.mat", "a.parquet"):
        recording = read(tmp_path / name)
        assert (len(recording), len(recording.extra)) == (500_000, 8)


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("log.json", '[{"t_s": 1, "x_mm": 2}, {"t_s": 1, "x_mm": 2, "t_s": 3}]'),
        ("log.json", '{"log": [{"t_s": 1, "x_mm": 2}], "a": 1, "a": 2}'),
        ("log.json", '{"log": [{"t_s": 1, "x_mm": 2}], "a": {"b": 1, "b": 2}}'),
        ("card.json", '{"schema": "stribeck-card/1", "schema": "stribeck-card/1"}'),
        ("report.json", '{"schema": "stribeck-report/1", "fit": {"a": 1, "a": 1}}'),
        ("compensation.json", '{"schema": 1, "recommended": {"a": 1, "a": 1}}'),
    ],
)
def test_a_name_that_stands_twice_in_json_is_refused(name: str, text: str, tmp_path: Path) -> None:
    file = tmp_path / name
    file.write_text(text)
    readers = {"card.json": read_card, "compensation.json": read_settings}
    with pytest.raises(InputError, match=r"the name '\w+' stands twice in one object: keep one"):
        read_report(tmp_path) if name == "report.json" else readers.get(name, read)(file)
