"""Small logs of all formats, made by their libraries or by the published layout, to be damaged.

    python tools/fuzz_logs.py FOLDER

writes them as FOLDER/FORMAT-NUMBER: a process of its own, as the libraries take more memory than
a read may.
"""

from __future__ import annotations

import io
import json
import struct
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import polars as pl
from asammdf import MDF, Signal
from nptdms import ChannelObject, TdmsWriter
from rosbags import rosbag1, rosbag2
from rosbags.typesys import Stores, get_typestore

_ROWS = 40
_T = np.arange(_ROWS) * 0.01
_X = np.round(100 * _T**2, 3)
_F = np.round(np.sin(9 * _T), 4)
_ARRAYS = {"t_s": _T, "x_mm": _X, "F_N": _F}


def _dataset(folder: Path) -> None:
    """A LeRobot dataset without its data."""
    (folder / "meta").mkdir(parents=True, exist_ok=True)
    (folder / "data" / "chunk-000").mkdir(parents=True, exist_ok=True)
    feature = {"dtype": "float32", "shape": [2], "names": ["elbow.pos", "wrist.pos"]}
    info = {"codebase_version": "v3.0", "features": {"observation.state": feature}}
    (folder / "meta" / "info.json").write_text(json.dumps(info), encoding="utf-8")


def _twincat() -> list[bytes]:
    heads = (
        "Name\tdrive\nFile\ta.csv\nStarttime of export\t132959733843760000\n\n\n"
        "Name\tActPos\tName\tActTorque\nData-Type\tREAL64\tData-Type\tREAL32\n"
        "SampleTime[ms]\t10\tSampleTime[ms]\t10\nUnit\tmm (Length)\tUnit\tN (Force)\n\n"
    )
    rows = [f"{1e3 * t:g}\t{x}\t{1e3 * t:g}\t{f}" for t, x, f in zip(_T, _X, _F, strict=True)]
    text = heads + "\n".join(rows) + "\nEOF\n"
    return [text.encode(), text.replace(".", ",").encode(), text.replace("\t", ";").encode()]


def _codesys() -> list[bytes]:
    body = "[key]; [value]\nVersion; 1\n"
    for k, (name, values) in enumerate({"x": _X, "f": _F}.items()):
        rows = "\n".join(f"; {1e3 * t:g}; {v}" for t, v in zip(_T, values, strict=True))
        body += f"{k}.Variable; {name}\n{k}.Data; \n{rows}\n"
    return [body.encode()]


def _klipper() -> list[bytes]:
    heads = {"adxl345:hot": ["time", "x_acceleration"], "load_cell:bed": ["time", "force (g)"]}
    messages: list[Any] = [{"id": n, "result": {"header": h}} for n, h in heads.items()]
    rows = {n: [[t, v] for t, v in zip(_T, _F, strict=True)] for n in heads}
    messages += [{"q": n, "params": {"data": data}} for n, data in rows.items()]
    steps = {"data": [[400, 20, 3], [500, -9, -2]], "first_clock": 400, "last_clock": 14000,
             "first_step_time": 0.0, "last_step_time": _T[-1], "start_position": 1.0,
             "step_distance": 0.01}  # fmt: skip
    messages.append({"q": "stepq:x", "params": steps})
    for t in (_T[0], _T[-1]):
        status = {"toolhead": {"estimated_print_time": t}, "tmc2209 x": {"run_current": t}}
        messages.append({"q": "status", "params": {"status": status}})
    return [b"".join(json.dumps(m).encode() + b"\x03" for m in messages)]


def _lvm() -> list[bytes]:
    end = "***End_of_Header***\t\n"
    heads = f"LabVIEW Measurement\t\nSeparator\tTab\nX_Columns\tOne\n{end}\n"
    heads += f"Channels\t2\t\nY_Unit_Label\tmm\tN\nX0\t0\t0\nDelta_X\t0.01\t0.01\n{end}"
    rows = "\n".join(f"{t:g}\t{x}\t{f}" for t, x, f in zip(_T, _X, _F, strict=True))
    names = "X_Value\tposition\tforce\tComment\n"
    express = "channel names:\nposition [mm]\tforce [N]\ndt:\n0.01\t0.01\ndata:\n"
    express += "\n".join(f"{x}\t{f}" for x, f in zip(_X, _F, strict=True))
    return [f"{heads}{names}{rows}\n".encode(), express.encode()]


def _signal_express() -> list[bytes]:
    rows = "\n".join(f"{x}\t{f}" for x, f in zip(_X, _F, strict=True))
    text = (
        "channel names:\nx [mm]\tF [N]\nstart times:\n2023-11-14 22:13:20.000\t"
        f"2023-11-14 22:13:20.000\ndt:\n0.010000\t0.010000\ndata:\n{rows}\n"
    )
    return [text.encode(), text.replace(".", ",").encode()]


def _npz() -> list[bytes]:
    files = []
    for save in (np.savez, np.savez_compressed):
        buffer = io.BytesIO()
        save(buffer, **_ARRAYS, q=np.ones((_ROWS, 2)), k=3.0)
        files.append(buffer.getvalue())
    return files


def _feather() -> list[bytes]:
    buffers = io.BytesIO(), io.BytesIO()
    pl.DataFrame(_ARRAYS).write_ipc(buffers[0])
    pl.DataFrame({**_ARRAYS, "w": ["on"] * _ROWS}).write_ipc(buffers[1], compression="zstd")
    return [b.getvalue() for b in buffers]


def _lerobot() -> list[bytes]:
    buffer = io.BytesIO()
    states = [[x, f] for x, f in zip(_X, _F, strict=True)]
    pl.DataFrame(
        {"observation.state": states, "timestamp": _T, "episode_index": [0] * _ROWS}
    ).write_parquet(buffer)
    return [buffer.getvalue()]


def _written(write: Callable[[Path], None], suffix: str) -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"log{suffix}"
        write(path)
        return path.read_bytes()


def _hdf5() -> list[bytes]:
    def write(path: Path, **options: Any) -> None:
        with h5py.File(path, "w") as file:
            for name, values in _ARRAYS.items():
                file.create_dataset(f"axis/{name}", data=values, **options).attrs["doc"] = "a"
            file["gain"] = 3.0

    packed = {"chunks": (16,), "compression": "gzip"}
    return [_written(write, ".h5"), _written(lambda path: write(path, **packed), ".h5")]


def _tdms() -> list[bytes]:
    def write(path: Path) -> None:
        with TdmsWriter(str(path)) as writer:
            properties = {"wf_increment": 0.01, "wf_start_offset": 0.0, "wf_samples": 1}
            writer.write_segment([
                ChannelObject("axis", name, values, {**properties, "unit_string": unit})
                for name, values, unit in (("position", _X, "mm"), ("force", _F, "N"))
            ])  # fmt: skip

    return [_written(write, ".tdms")]


def _mdf4() -> list[bytes]:
    def write(path: Path) -> None:
        file: Any = MDF(version="4.10")
        names = (("Position", _X, "mm"), ("Force", _F, "N"))
        file.append([Signal(v, _T, unit=u, name=n) for n, v, u in names])
        file.save(path)
        file.close()

    return [_written(write, ".mf4")]


def _rosbag() -> list[bytes]:
    store = get_typestore(Stores.ROS1_NOETIC)
    types: Any = store.types
    kind = "sensor_msgs/msg/JointState"

    def write(path: Path) -> None:
        with rosbag1.Writer(path) as writer:
            connection = writer.add_connection("/js", kind, typestore=store)
            for k, (x, f) in enumerate(zip(_X, _F, strict=True)):
                stamp = types["builtin_interfaces/msg/Time"](sec=1000, nanosec=10_000_000 * k)
                header = types["std_msgs/msg/Header"](seq=k, stamp=stamp, frame_id="")
                arrays = (np.array([v]) for v in (x, 0.0, f))
                state = types[kind](header, ["elbow"], *arrays)
                writer.write(
                    connection, 10**12 + 10**7 * k, bytes(store.serialize_ros1(state, kind))
                )

    return [_written(write, ".bag")]


def _ros2(suffix: str, plugin: rosbag2.StoragePlugin) -> list[bytes]:
    store = get_typestore(Stores.ROS2_HUMBLE)
    types: Any = store.types
    kind = "sensor_msgs/msg/JointState"
    with tempfile.TemporaryDirectory() as folder:
        bag = Path(folder) / "bag"
        with rosbag2.Writer(bag, version=9, storage_plugin=plugin) as writer:
            connection = writer.add_connection("/js", kind, typestore=store)
            for k, (x, f) in enumerate(zip(_X, _F, strict=True)):
                stamp = types["builtin_interfaces/msg/Time"](sec=1000, nanosec=10**7 * k)
                header = types["std_msgs/msg/Header"](stamp=stamp, frame_id="")
                arrays = (np.array([v]) for v in (x, 0.0, f))
                state = types[kind](header, ["elbow"], *arrays)
                data = bytes(store.serialize_cdr(state, kind))
                writer.write(connection, 10**12 + 10**7 * k, data)
        return [file.read_bytes() for file in bag.iterdir() if file.name.endswith(suffix)]


def _ulog() -> list[bytes]:
    def message(kind: bytes, body: bytes) -> bytes:
        return struct.pack("<Hc", len(body), kind) + body

    data = b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 1000) + message(b"B", bytes(40))
    data += message(b"F", b"axis:uint64_t timestamp;float x;")
    for instance in range(2):
        data += message(b"A", struct.pack("<BH", instance, instance) + b"axis")
    for k in range(2 * _ROWS):
        data += message(b"D", struct.pack("<HQf", k % 2, 1000 + 5000 * k, k * k))
    return [data]


#: Format -> its files.
CORPORA: dict[str, Callable[[], list[bytes]]] = {
    "twincat": _twincat, "codesys": _codesys, "klipper": _klipper, "lvm": _lvm, "npz": _npz,
    "feather": _feather,
    "signalexpress": _signal_express,
    "lerobot": _lerobot, "hdf5": _hdf5, "tdms": _tdms, "mdf4": _mdf4, "rosbag": _rosbag,
    "db3": lambda: _ros2(".db3", rosbag2.StoragePlugin.SQLITE3),
    "mcap": lambda: _ros2(".mcap", rosbag2.StoragePlugin.MCAP),
    "ulog": _ulog,
}  # fmt: skip


def main() -> None:
    """Write all of them."""
    folder = Path(sys.argv[1])
    folder.mkdir()
    for name, corpus in CORPORA.items():
        for k, data in enumerate(corpus()):
            (folder / f"{name}-{k}").write_bytes(data)
    _dataset(Path("dataset"))


if __name__ == "__main__":
    main()
