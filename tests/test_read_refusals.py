"""Logs that are refused, in one line that names the file, the place and the remedy."""

from __future__ import annotations

import io
import os
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, cast

import numpy as np
import polars as pl
import pytest
import scipy.io
from hypothesis import example, given, settings
from hypothesis import strategies as st

from stribeck.data import Recording, read
from stribeck.errors import InputError

N = 30
ROWS = [f"{i * 0.01:.2f},{i * i * 0.1:.1f}" for i in range(N)]
PLAIN = "\n".join(["t_s,x_mm", *ROWS]) + "\n"


def refusal(path: Path, columns: Any = None) -> str:
    with pytest.raises(InputError) as caught:
        read(path, columns=columns)
    message = str(caught.value)
    assert message.isprintable()  # one line, and nothing that a terminal would obey
    assert len(message) < 600
    return message


def test_a_json_log_of_more_names_than_a_log_has_is_refused(tmp_path: Path) -> None:
    # A cell for every record and name would be gigabytes, from a file of some 100 kB.
    file = tmp_path / "wide.json"
    file.write_text("[" + ",".join(f'{{"k{i}": 1}}' for i in range(10_001)) + "]")
    assert "wide.json: has 10,001 names in its records, and 10,000 is the most" in refusal(file)


def with_row(number: int, row: str) -> str:
    """The plain log with another line `number` (the head is line 1)."""
    lines = PLAIN.split("\n")
    lines[number - 1] = row
    return "\n".join(lines)


def headed(head: str, *cells: str) -> str:
    return "\n".join([head, *(",".join((row, *cells)) for row in ROWS)])


BAD_TEXT = {
    "empty": ("", "is empty"),
    "blank": ("\n\n  \n", "is empty"),
    "only a header": ("t_s,x_mm\n", "no rows of numbers"),
    "no header": ("\n".join(ROWS), "no heads: name its columns by number"),
    "prose": ("Dear colleague,\nthe log follows.\n", "rows of"),
    "one column": ("x_mm\n" + "\n".join(map(str, range(N))), "no time column among x_mm"),
    "too few samples": ("\n".join(PLAIN.split("\n")[:5]), "4 usable samples"),
    "a row too long": (with_row(7, "0.05,2.5,9"), "line 7 has 3 fields"),
    "a row too short": (with_row(7, "0.05"), "line 7 has 1 field"),
    "cut off": (PLAIN[:-8] + "\n0.2", "fields, the header 2"),
    "a word in a cell": (with_row(9, "0.07,Fehler"), "line 9, column x_mm: 'Fehler'"),
    "a word in the first row": (with_row(2, "0.00,ERR"), "line 2, column x_mm: 'ERR'"),
    "a word in time": (with_row(9, "soon,4.9"), "line 9, column t_s: 'soon'"),
    "a long word": (with_row(9, "0.07," + "z" * 5000), "zzz..."),
    "an escape sequence": (with_row(9, "0.07,\x1b[31mred"), "line 9, column x_mm"),
    "two decimal points": (with_row(9, "0.07,4.9.1"), "'4.9.1'"),
    "clock times": (with_row(9, "12:30:01,4.9"), "'12:30:01'"),
    "infinity": (with_row(9, "0.07,inf"), "line 9: position is infinite"),
    "minus infinity": (with_row(9, "0.07,-inf"), "line 9: position is infinite"),
    "overflow": (with_row(9, "0.07,1e999"), "line 9: position is infinite"),
    "infinite time": (with_row(9, "inf,4.9"), "line 9: time is infinite"),
    "time back": (with_row(9, "0.01,4.9"), "line 9: time goes back from 0.06 to 0.01 s"),
    "time stands": ("t_s,x_mm\n" + "\n".join(f"1,{i}" for i in range(N)), "time stands still"),
    "time too coarse": (
        "t_s,x_mm\n" + "\n".join(f"{i // 3},{i}" for i in range(N)),
        "20 of 30 rows repeat the time stamp",
    ),
    "no motion": ("t_s,x_mm\n" + "\n".join(f"{i},5" for i in range(N)), "nothing moves"),
    "a long gap": (
        "t_s,x_mm\n" + "\n".join(f"{i},{'' if 9 < i < 16 else i}" for i in range(N)),
        "line 12 to 17",
    ),
    "many gaps": (
        "t_s,x_mm\n" + "\n".join(f"{i},{'' if i % 5 == 2 else i}" for i in range(N)),
        "more than 2%",
    ),
    "empty position": ("t_s,x_mm,y\n" + "\n".join(f"{i},,1" for i in range(N)), "is empty"),
    "much time missing": (
        "t_s,x_mm\n" + "\n".join(f"{'' if i % 3 == 1 else i},{i}" for i in range(N)),
        "time is empty in",
    ),
    "no time": (headed("sample,x_mm"), "no time column among sample, x_mm"),
    "no position": (headed("t_s,F_N"), "no position column among t_s, F_N"),
    "no units": (headed("time,position"), "time and position without a unit"),
    "no unit of time": (headed("time,x_mm"), "column time without a unit"),
    "no unit of position": (headed("t_s,position"), "column position without a unit"),
    "unknown unit": (headed("t_s,position [furlongz]"), "unknown unit 'furlongz'"),
    "unknown unit of time": (headed("time [jiffiez],x_mm"), "unknown unit 'jiffiez'"),
    "a unit that computes": (headed("t_s,x [9**9**9**9]"), "unknown unit"),
    "position in newtons": (headed("t_s,position_N"), "position_N is in N"),
    "position in counts": (headed("t_s,position [counts]"), "position [counts] is in counts"),
    "time in metres": (headed("time [m],x_mm"), "time [m] is in m"),
    "two positions": (headed("t_s,x_mm,position_mm", "1"), "x_mm and position_mm"),
    "two forces": (headed("t_s,x_mm,F_N,force_kN", "1", "2"), "F_N and force_kN"),
    "decimal commas between commas": (
        "t_s,x_mm\n" + "\n".join(f"0,{i},1,{i}" for i in range(10, 10 + N)),
        "decimal commas need ; or tab",
    ),
}  # fmt: skip


@pytest.mark.parametrize(("content", "reason"), BAD_TEXT.values(), ids=BAD_TEXT.keys())
def test_text_that_is_no_log(content: str, reason: str, tmp_path: Path) -> None:
    path = tmp_path / "bad.csv"
    path.write_text(content, encoding="utf-8")
    message = refusal(path)
    assert message.startswith("bad.csv: ")
    assert reason in message


def parquet(frame: pl.DataFrame) -> bytes:
    buffer = io.BytesIO()
    frame.write_parquet(buffer)
    return buffer.getvalue()


def matlab(**variables: Any) -> bytes:
    buffer = io.BytesIO()
    scipy.io.savemat(cast("str", buffer), variables)
    return buffer.getvalue()


T = np.arange(N) * 0.01
FRAME = pl.DataFrame({"t_s": T, "x_mm": T**2})
REVERSED = FRAME.with_columns(pl.Series("t_s", np.where(np.arange(N) == 20, 0.0, T)))


def claimed() -> bytes:
    """A small MATLAB file that claims a vector of 2^31 - 1 numbers."""
    data = bytearray(matlab(t_s=T))
    at = data.index(np.array([1, N], dtype="<i4").tobytes())
    data[at : at + 8] = np.array([1, 2**31 - 1], dtype="<i4").tobytes()
    return bytes(data)


BAD_BYTES: dict[str, tuple[str, Callable[[], bytes], str]] = {
    "binary": ("a.csv", lambda: bytes(range(256)) * 9, "is not text"),
    "excel": ("a.csv", lambda: b"PK\x03\x04" + bytes(99), "save it as CSV"),
    "old excel": ("a.csv", lambda: b"\xd0\xcf\x11\xe0" + bytes(99), "save it as CSV"),
    "gzip": ("a.csv", lambda: b"\x1f\x8b" + bytes(99), "broken gzip"),
    "tdms": ("a.txt", lambda: b"TDSm" + bytes(99), "is a TDMS file that nptdms cannot"),
    "unknown kind": ("a.xlsx", lambda: b"PK\x03\x04", "a zip or Excel file"),
    "truncated parquet": ("a.parquet", lambda: parquet(FRAME)[:-40], "copy or export it again"),
    "hollow parquet": ("a.parquet", lambda: b"PAR1" + bytes(60) + b"PAR1", "polars cannot read"),
    "parquet, time back": ("a.parquet", lambda: parquet(REVERSED), "row 21: time goes back"),
    "parquet of words": (
        "a.parquet",
        lambda: parquet(FRAME.with_columns(pl.lit("on").alias("x_mm"))),
        "row 1, column x_mm: 'on'",
    ),
    "parquet without rows": ("a.parquet", lambda: parquet(FRAME.clear()), "is empty"),
    "matlab 7.3": ("a.mat", lambda: b"MATLAB 7.3 MAT-file" + bytes(600), "that h5py cannot"),
    "hdf5": ("a.mat", lambda: b"\x89HDF\r\n\x1a\n" + bytes(600), "an HDF5 file that h5py cannot"),
    "truncated matlab": ("a.mat", lambda: matlab(t_s=T, x_mm=T)[:-100], "broken MATLAB"),
    "matlab, only its head": ("a.mat", lambda: matlab(t_s=T)[:128], "no vectors"),
    "matlab structure": ("a.mat", lambda: matlab(log={"t": T}), "no vectors of numbers (only log"),
    "matlab words": ("a.mat", lambda: matlab(t_s="now", x_mm="here"), "no vectors"),
    "matlab, complex": ("a.mat", lambda: matlab(t_s=T * 1j), "only t_s (complex numbers)"),
    "matlab without units": ("a.mat", lambda: matlab(t=T, q=T), "t and q without a unit"),
    "matlab that claims too much": ("a.mat", claimed, "broken MATLAB"),
}  # fmt: skip


@pytest.mark.parametrize(("name", "content", "reason"), BAD_BYTES.values(), ids=BAD_BYTES.keys())
def test_bytes_that_are_no_log(
    name: str, content: Callable[[], bytes], reason: str, tmp_path: Path
) -> None:
    path = tmp_path / name
    path.write_bytes(content())
    message = refusal(path)
    assert message.startswith(f"{name}: ")
    assert reason in message


def test_paths_that_are_no_log(tmp_path: Path) -> None:
    assert "no such file" in refusal(tmp_path / "missing.csv")
    assert "is a folder" in refusal(tmp_path)
    assert "cannot be read" in refusal(Path("zero\0byte.csv"))
    assert "cannot be read" in refusal(tmp_path / ("n" * 300 + ".csv"))
    os.mkfifo(tmp_path / "pipe.csv")
    assert "not a regular file" in refusal(tmp_path / "pipe.csv")


def test_a_file_larger_than_the_limit_is_refused_unread(tmp_path: Path) -> None:
    path = tmp_path / "huge.json"
    with path.open("wb") as f:
        f.write(b'[{"t_s": 0, "x_m": 1},'.ljust(5000, b"\n"))
        f.truncate((2 << 30) + 1)  # sparse: takes no room
    said = refusal(path)
    assert "larger than 2 GiB" in said
    assert "save it as Parquet or HDF5" in said


@pytest.mark.skipif(os.geteuid() == 0, reason="root may read everything")
def test_a_file_without_permission(tmp_path: Path) -> None:
    path = tmp_path / "mine.csv"
    path.write_text(PLAIN)
    path.chmod(0)
    assert "Permission denied" in refusal(path)


@pytest.mark.parametrize("share", [0.0, 0.01, 0.1, 0.5, 0.9, 0.999])
def test_a_parquet_file_that_was_cut_off(share: float) -> None:
    whole = parquet(FRAME)
    assert isinstance(outcome(whole[: int(share * len(whole))], ".parquet"), str)


def test_a_hostile_name_stays_in_one_line(tmp_path: Path) -> None:
    path = tmp_path / "a\n\x1b[31mb.csv"
    path.write_text("")
    assert "is empty" in refusal(path)


BAD_MAPPINGS: dict[str, tuple[Any, str]] = {
    "absent column": ({"force": "load [N]"}, "no such column: there are t_s, x_mm"),
    "absent factor": ({"force": {"column": "x_mm", "unit": "N", "factor": "k"}}, "factor 'k'"),
    "no such channel": ({"torque": "x_mm"}, "no channel 'torque'"),
    "no unit": ({"force": "y"}, 'say it, as in units={"y": "N"}'),
    "unknown unit": ({"force": "y [Nn]"}, "unknown unit 'Nn'"),
    "wrong dimension": ({"force": "y [mm]"}, "does not measure the force"),
    "torque on a slide": ({"force": "y [Nm]"}, "does not measure the force"),
    "position in seconds": ({"position": "t_s"}, "does not measure a length or an angle"),
    "angle and length": ({"command": "y [deg]"}, "does not measure a length"),
    "factor zero": ({"force": {"column": "y", "factor": 0}}, "factor must be"),
    "factor nan": ({"force": {"column": "y", "factor": float("nan")}}, "factor must be"),
    "factor of 401 digits": ({"force": {"column": "y", "factor": 10**400}}, "factor must be"),
    "factor true": ({"force": {"column": "y", "factor": True}}, "factor must be"),
    "unit a number": ({"force": {"column": "y", "unit": 3}}, "unit must be text"),
    "misspelt key": ({"force": {"column": "y", "scale": 3}}, "'scale' is none of"),
    "no column": ({"force": {"unit": "N"}}, "write"),
    "a list": ({"force": ["y"]}, "write"),
    "a number": ({"force": 3}, "write"),
    "none": ({"force": None}, "write"),
}  # fmt: skip


@pytest.mark.parametrize(("columns", "reason"), BAD_MAPPINGS.values(), ids=BAD_MAPPINGS.keys())
def test_mappings_that_make_no_sense(columns: Any, reason: str, tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text(headed("t_s,x_mm,y", "1"))
    assert reason in refusal(path, columns)


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (b"position = ", "is not TOML"),
        (b"\xff\xfe\x00", "is not UTF-8 text"),
        (b"columns = 3", "must be a table"),
        (b"[" * 5000, "is not TOML"),
        (b"force = 3", "map.toml: force: write"),
    ],
)
def test_mapping_files_that_are_broken(content: bytes, reason: str, tmp_path: Path) -> None:
    path, toml = tmp_path / "log.csv", tmp_path / "map.toml"
    path.write_text(PLAIN)
    toml.write_bytes(content)
    message = refusal(path, toml)
    assert message.startswith("map.toml: ")
    assert reason in message


def test_a_mapping_file_that_is_missing(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text(PLAIN)
    assert refusal(path, tmp_path / "no.toml").startswith("no.toml: cannot read")


def outcome(content: bytes, suffix: str) -> Recording | str:
    """A recording or one printable line; anything else fails the test."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"fuzz{suffix}"
        path.write_bytes(content)
        try:
            return read(path)
        except InputError as error:
            message = str(error)
    assert message.startswith(f"fuzz{suffix}: ")
    assert message.isprintable()
    return message


@settings(max_examples=150)
@given(st.binary(max_size=400), st.sampled_from([".csv", ".txt", ".parquet", ".mat"]))
def test_any_bytes_are_read_or_refused(content: bytes, suffix: str) -> None:
    outcome(content, suffix)


_CELL = st.one_of(
    st.floats().map(str),
    st.integers().map(str),
    st.text(max_size=8),
    st.sampled_from(["", "nan", "inf", "-", '"', "1,5", "#", "0x1p3", "1_000", "1e5", "٣"]),
)


@settings(max_examples=200)
@example([(0, 1, '\r"')], ",", "utf-8")
@example([(1, 1, '"' + 200_000 * "1")], ";", "utf-8")  # beyond what a quoted field may have
@given(
    st.lists(st.tuples(st.integers(0, N), st.integers(0, 1), _CELL), max_size=4),
    st.sampled_from([",", ";", "\t", " "]),
    st.sampled_from(["utf-8", "utf-16", "latin-1"]),
)
def test_a_log_with_damaged_cells(
    damage: list[tuple[int, int, str]], separator: str, encoding: str
) -> None:
    cells = [row.split(",") for row in PLAIN.split()]
    for row, column, cell in damage:
        cells[row][column] = cell
    content = "\n".join(separator.join(row) for row in cells)
    outcome(content.encode(encoding, errors="replace"), ".csv")


def packed() -> bytes:
    buffer = io.BytesIO()
    scipy.io.savemat(cast("str", buffer), {"t_s": T, "x_mm": T**2}, do_compression=True)
    return buffer.getvalue()


@settings(max_examples=200)
@given(st.sampled_from([".csv", ".mat", "packed.mat"]), st.data())
def test_a_log_with_damaged_bytes(suffix: str, data: st.DataObject) -> None:
    whole = {".csv": PLAIN.encode(), ".mat": matlab(t_s=T, x_mm=T**2), "packed.mat": packed()}
    content = bytearray(whole[suffix])
    for _ in range(data.draw(st.integers(1, 4))):
        content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    cut = data.draw(st.integers(0, len(content)))
    outcome(bytes(content[cut:] if data.draw(st.booleans()) else content), suffix)


def test_a_refusal_names_its_log_once(tmp_path: Path) -> None:
    file = tmp_path / "log.csv"
    file.write_text("t_s,x_mm\n" + "".join(f"{k},{10.0 ** (4 * k)}\n" for k in range(20)))
    with pytest.raises(InputError, match=r"^log\.csv: position has values beyond"):
        read(file)
