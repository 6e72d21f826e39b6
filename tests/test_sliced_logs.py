"""HDF5, MDF and Parquet in pieces: what the library reads at once, wherever the pieces end."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
import pytest

from stribeck.data import read
from stribeck.data.readers import hdf5_file, mdf4
from stribeck.data.readers import parquet as parquet_file
from stribeck.data.readers.interval import Interval
from stribeck.data.readers.log_file import ReadOptions
from stribeck.data.readers.registry import opened
from stribeck.data.readers.sliced_log import SlicedLog, filled
from stribeck.space import Array

N = 1000


def signals(n: int) -> dict[str, Array]:
    t = 5 + 0.01 * np.arange(n)
    return {"t [s]": t, "x [mm]": np.sin(t), "F [N]": np.cos(3 * t)}


def hdf5(path: Path, n: int = N) -> dict[str, Array]:
    """Vectors in chunks and in one piece, a matrix, records, and a scalar."""
    h5py: Any = pytest.importorskip("h5py")
    columns = signals(n)
    rng = np.random.default_rng(1)
    matrix = rng.standard_normal((n, 3))
    records = np.zeros(n, dtype=[("a", "f4"), ("b", "i2")])
    records["a"], records["b"] = rng.standard_normal(n), rng.integers(0, 99, n)
    with h5py.File(path, "w") as file:
        for k, (name, values) in enumerate(columns.items()):
            file.create_dataset(name, data=values, chunks=(37,) if k else None, compression="gzip"
                                if k else None)  # fmt: skip
        file["m"], file["r"], file["kp"] = matrix, records, 3.5
    columns |= {f"m_{k}": matrix[:, k - 1] for k in (1, 2, 3)}
    return columns | {f"r/{f}": records[f].astype(float) for f in ("a", "b")}


def mf4(path: Path, n: int = N, *, compression: int = 0) -> dict[str, Array]:
    """A group of three channels."""
    asammdf: Any = pytest.importorskip("asammdf")
    columns = signals(n)
    t = columns.pop("t [s]")
    with asammdf.MDF(version="4.10") as file:
        file.append([
            asammdf.Signal(a, t, name=h.split(" [")[0], unit=h.split("[")[1][:-1])
            for h, a in columns.items()
        ])  # fmt: skip
        file.save(path, overwrite=True, compression=compression)
    return {"": t, **{h.split(" [")[0]: a for h, a in columns.items()}}


def parquet(path: Path, n: int = N) -> dict[str, Array]:
    """Row groups of 100 rows, as polars writes them."""
    columns = signals(n)
    pl.DataFrame(columns).write_parquet(path, row_group_size=100)
    return columns


@pytest.mark.parametrize("block", [1, 7, 64, 5000])
def test_hdf5_in_pieces_is_what_was_written(
    block: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(hdf5_file, "_BLOCK", block)
    columns = hdf5(tmp_path / "log.h5")
    log = hdf5_file.library_log(tmp_path / "log.h5", ReadOptions())
    assert {c.name for c in log.channels} == {*columns, "kp"}
    (table,) = log.tables()
    for name, values in columns.items():
        np.testing.assert_array_equal(table.columns[name], values)
        (alone,) = log.tables([name])
        np.testing.assert_array_equal(alone.columns[name], values)
    assert table.scalars == {"kp": 3.5}


@pytest.mark.parametrize("compression", [0, 2])
def test_mdf_is_what_was_written(compression: int, tmp_path: Path) -> None:
    columns = mf4(tmp_path / "log.mf4", compression=compression)
    (table,) = mdf4.library_log(tmp_path / "log.mf4", ReadOptions()).tables()
    assert table.t is not None
    np.testing.assert_array_equal(table.t, columns.pop(""))
    assert {n: a.tolist() for n, a in table.columns.items()} == {
        n: a.tolist() for n, a in columns.items()
    }


def rows_of(log: SlicedLog, names: list[str], interval: Interval) -> range:
    (part,) = log.parts(names, interval)
    table = filled(part, log.pieces(names, part.rows))
    np.testing.assert_array_equal(table.places, np.array(part.rows) + 1)
    return part.rows


@pytest.mark.parametrize(("first", "last"), [(0, 0), (3, 5), (200, 399), (990, 999)])
def test_an_interval_has_its_rows_and_sixteen_beside(first: int, last: int, tmp_path: Path) -> None:
    wanted = range(max(first - 16, 0), min(last + 17, N))
    t = hdf5(tmp_path / "log.h5")["t [s]"]
    log = hdf5_file.library_log(tmp_path / "log.h5", ReadOptions())
    names = ["t [s]", "F [N]"]
    assert rows_of(log, names, Interval("t [s]", t[first], t[last])) == wanted
    assert rows_of(log, ["F [N]"], Interval("t [s]", t[first], t[last])) == range(N)
    mf4(tmp_path / "log.mf4")
    timed = mdf4.library_log(tmp_path / "log.mf4", ReadOptions())
    assert rows_of(timed, ["x", "F"], Interval("", t[first], t[last])) == wanted
    parquet(tmp_path / "log.parquet")
    frame = parquet_file.library_log(tmp_path / "log.parquet", ReadOptions())
    assert rows_of(frame, names, Interval("t [s]", t[first], t[last])) == wanted
    assert rows_of(frame, names, Interval("t [s]", t[-1] + 1, t[-1] + 2)) == range(0)


def test_a_part_of_a_parquet_file_takes_no_more_than_its_row_groups(tmp_path: Path) -> None:
    """Of a file whose middle is gone the beginning is read, and no more."""
    columns = parquet(tmp_path / "log.parquet")
    written = (tmp_path / "log.parquet").read_bytes()
    frame = parquet_file.library_log(tmp_path / "log.parquet", ReadOptions())
    assert {c.name: c.ends for c in frame.channels} == {
        n: (a[0], a[-1]) for n, a in columns.items()
    }
    middle, gone = len(written) // 2, 4000
    broken = written[:middle] + bytes(gone) + written[middle + gone :]
    (tmp_path / "log.parquet").write_bytes(broken)
    (part,) = frame.pieces(list(columns), range(10, 20))
    for name, values in columns.items():
        np.testing.assert_array_equal(part.columns[name], values[10:20])
    with pytest.raises(pl.exceptions.PolarsError):
        list(frame.pieces(list(columns), range(N)))


def test_channels_of_mdf_that_are_marked_invalid_are_no_numbers(tmp_path: Path) -> None:
    asammdf: Any = pytest.importorskip("asammdf")
    t, x = 0.01 * np.arange(N), np.sin(np.arange(N))
    marked = np.arange(N) % 7 == 3
    path = tmp_path / "log.mf4"
    with asammdf.MDF(version="4.10") as file:
        file.append([asammdf.Signal(x, t, name="x", unit="mm", invalidation_bits=marked),
                     asammdf.Signal(2 * x, t, name="F", unit="N")])  # fmt: skip
        file.save(path, overwrite=True)
    (table,) = mdf4.library_log(path, ReadOptions()).tables()
    np.testing.assert_array_equal(table.columns["x"], np.where(marked, np.nan, x))
    np.testing.assert_array_equal(table.columns["F"], 2 * x)


@pytest.mark.parametrize("kind", ["h5", "mf4", "parquet"])
def test_a_window_is_read_by_the_process_of_the_library(kind: str, tmp_path: Path) -> None:
    n = 400_000  # more than come with the contents
    path = tmp_path / f"log.{kind}"
    {"h5": hdf5, "mf4": mf4, "parquet": parquet}[kind](path, n)
    columns = signals(n)
    part = read(f"{path}@100s:102s")
    np.testing.assert_allclose(part.position, 1e-3 * columns["x [mm]"][10_000:10_200])
    assert part.force is not None
    np.testing.assert_array_equal(part.force, columns["F [N]"][10_000:10_200])
    whole = read(path)
    np.testing.assert_array_equal(whole.position[10_000:10_200], part.position)
    reader, log = opened(path, ReadOptions())
    assert reader.name == {"h5": "hdf5", "mf4": "mdf4", "parquet": "parquet"}[kind]
    assert hasattr(log, "part")
