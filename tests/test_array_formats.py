"""Arrays and frames as logs: NumPy, Parquet, Feather, LeRobot; values as they were written."""

from __future__ import annotations

import io
import json
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
import pytest

from opened_logs import log_of, table_of
from stribeck.data import read
from stribeck.errors import InputError

N = 50
T = 0.002 * np.arange(N)
X = 4.0 * np.sin(20.0 * T) + T
F = 30.0 * np.cos(20.0 * T)


# --- NumPy ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("save", [np.savez, np.savez_compressed])
def test_npz(save: Any, tmp_path: Path) -> None:
    path = tmp_path / "log.npz"
    q = np.column_stack([X, 2.0 * X]).astype("f4")
    save(path, t_s=T, x_mm=X, F_N=F, q=q, mass=24.0, name="axis", image=np.zeros((N, 9, 9)),
         run=np.arange(9), anything=np.array([None]))  # fmt: skip
    reader, log = log_of(path)
    assert reader == "numpy"
    names = [c.name for c in log.channels]
    assert names == ["t_s", "x_mm", "F_N", "q_1", "q_2", "run", "mass"]
    assert log.problems == ("left out, not columns of numbers: name, image, anything",)
    np.testing.assert_array_equal(table_of(log, "q_2").columns["q_2"], q[:, 1])
    recording = read(path)
    np.testing.assert_allclose(recording.position, 1e-3 * X)
    assert recording.force is not None
    np.testing.assert_array_equal(recording.force, F)
    np.testing.assert_array_equal(recording.extra["mass"], 24.0)
    assert "run" not in recording.extra


def test_npy(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    records = np.zeros(N, dtype=[("t_s", "f8"), ("x_mm", "f8"), ("word", "U3")])
    records["t_s"], records["x_mm"] = T, X
    with path.open("wb") as file:
        np.save(file, records)
    np.testing.assert_allclose(read(path).position, 1e-3 * X)
    with path.open("wb") as file:
        np.save(file, np.column_stack([T, X]))
    columns = {"time": "1 [s]", "position": "column 2 [mm]"}
    np.testing.assert_allclose(read(path, columns=columns).position, 1e-3 * X)


def test_objects_in_npy_are_not_loaded(tmp_path: Path) -> None:
    path = tmp_path / "log.npy"
    np.save(path, np.array([{"a": 1}], dtype=object), allow_pickle=True)
    with pytest.raises(InputError, match="has no arrays of numbers as columns"):
        read(path)


def bomb(shape: str, size: int) -> bytes:
    """An archive whose array claims a shape."""
    head = f"{{'descr': '|u1', 'fortran_order': False, 'shape': {shape}, }}\n".encode()
    data = b"\x93NUMPY\x01\x00" + len(head).to_bytes(2, "little") + head + bytes(size)
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("t_s.npy", data)
    return buffer.getvalue()


def test_an_archive_that_unpacks_to_too_much_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "log.npz"
    path.write_bytes(bomb("(90000000,)", 90_000_000))
    with pytest.raises(InputError, match=r"need .* of memory, and .* is the most"):
        read(path, columns={"time": "t_s", "position": "t_s [mm]"})
    path.write_bytes(bomb("(90000000,)", 9))
    with pytest.raises(InputError, match="is a broken NumPy file"):
        read(path)


# --- Parquet and Feather --------------------------------------------------------------------------


def frame() -> pl.DataFrame:
    return pl.DataFrame({
        "t_s": T,
        "x_mm": X,
        "F_N": F,
        "q": [[a, b] for a, b in zip(X, F, strict=True)],
        "pair": pl.Series(np.column_stack([F, X]), dtype=pl.Array(pl.Float32, 2)),
        "word": ["on"] * N,
        "mix": [{"a": 1}] * N,
    })  # fmt: skip


@pytest.mark.parametrize("kind", ["parquet", "feather"])
def test_lists_of_one_length_are_columns(kind: str, tmp_path: Path) -> None:
    path = tmp_path / "log"
    frame().write_parquet(path) if kind == "parquet" else frame().write_ipc(path)
    reader, log = log_of(path)
    assert reader == kind
    names = ["t_s", "x_mm", "F_N", "pair_1", "pair_2", "word"]
    assert [c.name for c in log.channels] == names
    assert log.text == {"word": ("row 1", "on")}
    np.testing.assert_array_equal(table_of(log, "pair_2").columns["pair_2"], X.astype("f4"))
    recording = read(path)
    np.testing.assert_allclose(recording.position, 1e-3 * X)
    assert any("left out, not numbers: q, mix" in note for note in recording.notes)


def test_a_feather_file_that_was_cut_off(tmp_path: Path) -> None:
    path = tmp_path / "log.feather"
    frame().write_ipc(path)
    path.write_bytes(path.read_bytes()[:600])
    with pytest.raises(InputError, match="is a Feather file that polars cannot read"):
        read(path)


# --- LeRobot --------------------------------------------------------------------------------------


def episode(k: int) -> pl.DataFrame:
    return pl.DataFrame({
        "observation.state": [[x + k, -x] for x in X],
        "action": [[x + k + 0.1, -x] for x in X],
        "timestamp": T.astype("f4"),
        "frame_index": np.arange(N),
        "episode_index": [k] * N,
    })  # fmt: skip


def dataset(folder: Path, version: str) -> Path:
    """Two episodes: a file each (v2.1), or both in one (v3.0)."""
    folder = folder / "dataset"
    data = folder / "data" / "chunk-000"
    data.mkdir(parents=True)
    (folder / "meta").mkdir()
    names: Any = ["elbow.pos", "wrist.pos"]
    names = names if version == "v3.0" else {"motors": names}
    feature = {"dtype": "float32", "shape": [2], "names": names}
    info = {"codebase_version": version, "fps": 500, "features": {
        "observation.state": feature, "action": feature,
        "timestamp": {"dtype": "float32", "shape": [1], "names": None},
    }}  # fmt: skip
    (folder / "meta" / "info.json").write_text(json.dumps(info))
    if version == "v3.0":
        pl.concat([episode(0), episode(1)]).write_parquet(data / "file-000.parquet")
    else:
        for k in range(2):
            episode(k).write_parquet(data / f"episode_{k:06d}.parquet")
    return folder


@pytest.mark.parametrize("version", ["v2.1", "v3.0"])
def test_an_episode_of_lerobot_is_a_log(version: str, tmp_path: Path) -> None:
    path = dataset(tmp_path, version)
    with pytest.raises(InputError, match=r'has 2 episodes, 0 to 1: .* columns={"episode": "0"}$'):
        log_of(path)
    with pytest.raises(InputError, match="has no episode 7: there are 0 to 1"):
        log_of(path, episode="7")
    reader, log = log_of(path, episode="1")
    assert reader == "lerobot"
    assert [c.name for c in log.channels] == [
        "observation.state/elbow.pos", "observation.state/wrist.pos",
        "action/elbow.pos", "action/wrist.pos", "timestamp", "frame_index", "episode_index",
    ]  # fmt: skip
    columns = {
        "position": "observation.state/elbow.pos [rad]",
        "command": "action/elbow.pos [rad]",
    }
    recording = read(path, columns=columns, episode="1")
    np.testing.assert_allclose(recording.position, X + 1)
    assert recording.command is not None
    np.testing.assert_allclose(recording.command, X + 1.1)
    np.testing.assert_allclose(recording.t, T, atol=1e-7)
