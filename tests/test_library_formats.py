"""Logs that other people's libraries read: values against those libraries, on files they write."""

from __future__ import annotations

import struct
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from asammdf import MDF, Signal
from nptdms import ChannelObject, TdmsFile, TdmsWriter
from pyulog import ULog
from rosbags import rosbag1, rosbag2
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore

from opened_logs import log_of, table_of, times
from stribeck.data import read
from stribeck.data.readers.log_file import LogFile
from stribeck.data.readers.registry import readers
from stribeck.errors import InputError
from stribeck.space import Array

LOGS = Path(__file__).parents[1] / ".." / "shared" / "data" / "logs"
real = pytest.mark.recordings

N = 50
T = 0.002 * np.arange(N)
X = 4.0 * np.sin(20.0 * T) + T
F = 30.0 * np.cos(20.0 * T)


def channel(log: LogFile, name: str) -> Any:
    return next(c for c in log.channels if c.name == name)


def test_a_library_that_is_not_there_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("stribeck.data.readers.isolated.find_spec", lambda _: None)
    starts = {
        "an HDF5 file": b"\x89HDF\r\n\x1a\n",
        "a TDMS file": b"TDSm",
        "an MDF file": b"MDF     4.10",
        "a ROS bag": b"\x89MCAP0\r\n",
        "a ULog file": b"ULog\x01\x12\x35",
    }
    for content, start in starts.items():
        (tmp_path / "log.csv").write_bytes(start + bytes(99))
        with pytest.raises(InputError) as caught:
            read(tmp_path / "log.csv")
        assert str(caught.value) == f'log.csv: is {content}: pip install "stribeck[logs]"'


def test_lgpl_libraries_are_named_so() -> None:
    licences = {r.name: r.library for r in readers().values() if r.extra}
    assert {n for n, words in licences.items() if "LGPL" in words} == {"tdms", "mdf4"}
    assert all("(" in words for words in licences.values())


# --- HDF5 and MATLAB 7.3 --------------------------------------------------------------------------


def test_hdf5_datasets_are_channels_by_path(tmp_path: Path) -> None:
    path = tmp_path / "axis.h5"
    q = np.column_stack([X, 2.0 * X, F])
    records = np.zeros(N, dtype=[("t", "f8"), ("word", "S3"), ("f", "f4")])
    records["f"] = F
    with h5py.File(path, "w") as file:
        file["axis/t"] = T
        file["axis/x"] = X
        file["axis/x"].attrs["units"] = "mm"
        file.create_dataset("axis/f", data=F, chunks=(16,), compression="gzip").attrs["unit"] = b"N"
        file["arm/q"] = q
        file["arm/rows"] = q.T
        file["records"] = records
        file["words"] = np.array([b"a"] * N)
        file["image"] = np.zeros((N, 3, 3))
        file["mass"] = 24.0
        file["again"] = h5py.SoftLink("/axis/x")
        file["elsewhere"] = h5py.ExternalLink("other.h5", "x")
        file["axis/itself"] = file["/"]
    reader, log = log_of(path)
    assert reader == "hdf5"
    expected = {"axis/t", "axis/x", "axis/f", *(f"arm/{n}_{k}" for n in ("q", "rows")
                for k in (1, 2, 3)), "records/t", "records/f", "mass"}  # fmt: skip
    assert {c.name for c in log.channels} == expected
    assert channel(log, "axis/x").unit == "mm"
    assert channel(log, "axis/f").ends == (F[0], F[-1])
    assert channel(log, "mass").constant
    assert log.problems == ("left out, not columns of numbers: image, words",)
    for name, values in {"axis/f": F, "arm/q_2": 2.0 * X, "arm/rows_3": F}.items():
        np.testing.assert_array_equal(table_of(log, name).columns[name], values)
    np.testing.assert_array_equal(table_of(log, "records/f").columns["records/f"], records["f"])
    recording = read(path, columns={"time": "axis/t [s]", "position": "axis/x", "force": "axis/f"})
    np.testing.assert_allclose(recording.position, 1e-3 * X)
    assert recording.force is not None
    np.testing.assert_array_equal(recording.force, F)


def test_an_episode_of_robomimic_is_a_log(tmp_path: Path) -> None:
    path = tmp_path / "demos.hdf5"
    with h5py.File(path, "w") as file:
        for k in range(2):
            file[f"data/demo_{k}/obs/robot0_joint_pos"] = np.column_stack([X, X + k])
            file[f"data/demo_{k}/actions"] = np.column_stack([F, F + k])
    _, log = log_of(path, episode="demo_1")
    assert [c.name for c in log.channels] == [
        "actions_1", "actions_2", "obs/robot0_joint_pos_1", "obs/robot0_joint_pos_2",
    ]  # fmt: skip
    np.testing.assert_array_equal(
        table_of(log, "obs/robot0_joint_pos_2").columns["obs/robot0_joint_pos_2"], X + 1
    )
    with pytest.raises(InputError, match="has no group demo_7: there are data/, data/demo_0/"):
        log_of(path, episode="demo_7")


def test_matlab_7_3(tmp_path: Path) -> None:
    """As MATLAB lays it out: behind a block of its own, transposed, cells as references."""
    path = tmp_path / "axis.mat"
    with h5py.File(path, "w", userblock_size=512) as file:

        def save(name: str, values: Any, kind: str) -> Any:
            file[name] = values
            file[name].attrs["MATLAB_class"] = np.bytes_(kind)
            return file[name]

        save("t_s", T[None, :], "double")
        save("x_mm", X[:, None], "double")
        save("q", np.stack([X, F]), "single")
        save("gain", np.array([[3.0]]), "double")
        save("name", np.array([[97], [98]], dtype="u2"), "char")
        save("cells", np.array([[file["t_s"].ref]], dtype=h5py.ref_dtype), "cell")
        file["#refs#/a"] = T
    with path.open("r+b") as raw:
        raw.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\0\2IM")
    reader, log = log_of(path)
    assert reader == "hdf5"
    assert [c.name for c in log.channels] == ["q_1", "q_2", "t_s", "x_mm", "gain"]
    recording = read(path)
    np.testing.assert_allclose(recording.position, 1e-3 * X)
    np.testing.assert_allclose(recording.extra["q_2"], F)
    np.testing.assert_array_equal(recording.extra["gain"], 3.0)


def test_a_broken_hdf5_file_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "axis.h5"
    with h5py.File(path, "w") as file:
        file["x"] = np.zeros(10_000)
    path.write_bytes(path.read_bytes()[:3000])
    with pytest.raises(InputError, match="is an HDF5 file that h5py cannot read"):
        read(path)


# --- TDMS -----------------------------------------------------------------------------------------


@real
def test_a_recording_of_labview() -> None:
    path = LOGS / "tdms" / "raw1.tdms"
    reader, log = log_of(path)
    assert reader == "tdms"
    (group,) = TdmsFile.read(path).groups()
    assert {c.name for c in log.channels} == {f"{group.name}/{c.name}" for c in group.channels()}
    for own in group.channels():
        name = f"{group.name}/{own.name}"
        table = table_of(log, name)
        values = table.columns[name]
        np.testing.assert_array_equal(values, own[:])
        np.testing.assert_allclose(times(table), own.time_track())
        assert channel(log, f"{group.name}/{own.name}").unit == own.properties["unit_string"]


def test_tdms_waveforms_are_clocks(tmp_path: Path) -> None:
    path = tmp_path / "axis.bin"
    start = np.datetime64("2026-03-01T10:00:00", "us")
    late = start + np.timedelta64(4, "ms")

    def wave(name: str, values: Array, begin: np.datetime64, step: float, unit: str) -> Any:
        properties = {"wf_start_time": begin, "wf_increment": step, "wf_start_offset": 0.0,
                      "wf_samples": 1, "unit_string": unit}  # fmt: skip
        return ChannelObject("axis", name, values, properties=properties)

    with TdmsWriter(str(path)) as writer:
        writer.write_segment([
            wave("position", X, start, 0.002, "mm"),
            wave("force", F, late, 0.002, "N"),
            ChannelObject("axis", "word", ["a", "b"]),
        ])  # fmt: skip
    _, log = log_of(path)
    assert log.problems == ("left out, not numbers: axis/word",)
    assert channel(log, "axis/force").span == pytest.approx((0.004, 0.102))
    recording = read(path)
    assert recording.force is not None
    np.testing.assert_allclose(recording.position, 1e-3 * X[2:])
    np.testing.assert_allclose(recording.force, F[:-2], atol=1e-9)


# --- MDF ------------------------------------------------------------------------------------------


@real
def test_a_recording_of_a_measurement_system() -> None:
    path = LOGS / "mf4" / "ASAP2_Demo_V171.mf4"
    reader, log = log_of(path)
    assert reader == "mdf4"
    oracle: Any = MDF(path)
    assert {c.count for c in log.channels} == {2, 124, 1240, 12402}
    compared = 0
    tables = log.tables()
    for table in tables:
        group = int(table.clock.split()[1])
        for index, own in enumerate(oracle.groups[group].channels):
            if own.name not in table.columns:
                continue
            signal = oracle.get(group=group, index=index)
            np.testing.assert_array_equal(table.t, signal.timestamps)
            if signal.samples.dtype.kind in "iufb":
                np.testing.assert_array_equal(table.columns[own.name], signal.samples)
                assert table.units.get(own.name, "") == signal.unit.strip()
                compared += 1
    assert compared > 25
    oracle.close()


def test_mdf_groups_are_clocks(tmp_path: Path) -> None:
    path = tmp_path / "axis.mf4"
    fine = 0.001 * np.arange(2 * N)
    file: Any = MDF(version="4.10")
    file.append([Signal(X, T, unit="mm", name="Position"), Signal(F, T, unit="N", name="Force")])
    file.append([Signal(fine**2, fine, name="Spindle"), Signal(fine, fine, name="Force")])
    file.save(path)
    file.close()
    _, log = log_of(path)
    assert [c.name for c in log.channels] == ["Position", "Force", "Spindle", "Force #2"]
    assert channel(log, "Spindle").rate == pytest.approx(1000.0)
    recording = read(path)
    np.testing.assert_allclose(recording.position, 1e-3 * X)
    assert recording.force is not None
    np.testing.assert_array_equal(recording.force, F)


# --- ROS ------------------------------------------------------------------------------------------


@real
@pytest.mark.parametrize("name", ["rosbag2", "rosbag2/rosbag2_test_0.db3"])
def test_a_recording_of_ros_2(name: str) -> None:
    path = LOGS / name
    reader, log = log_of(path)
    assert reader == "rosbag"
    assert len(log.channels) == 81
    tables = {t.clock: t for t in log.tables()}
    store = get_typestore(Stores.LATEST)
    with AnyReader([path], default_typestore=store) as bag:
        connection, log_time, raw = next(m for m in bag.messages() if m[0].topic == "/imu")
        message: Any = bag.deserialize(raw, connection.msgtype)
        stamp = message.header.stamp.sec * 10**9 + message.header.stamp.nanosec
        start = bag.start_time
    table = tables["/imu"]
    assert len(table.places) == 1565
    assert table.t is not None
    assert table.t[0] == pytest.approx(1e-9 * (stamp - start), abs=1e-9)
    assert table.columns["/imu/orientation/w"][0] == message.orientation.w
    assert table.columns["/imu/angular_velocity_covariance/9"][0] == pytest.approx(
        message.angular_velocity_covariance[8]
    )
    _, by_log = log_of(path, stamp="log")
    (other,) = by_log.tables(["/imu/orientation/w"])
    assert other.t is not None
    assert other.t[0] == pytest.approx(1e-9 * (log_time - start), abs=1e-9)


STORE = get_typestore(Stores.ROS2_HUMBLE)
ROS_1 = get_typestore(Stores.ROS1_NOETIC)
#: The clock of the robot runs 1 % fast, so that stamps and log part by half a sample at the end.
STAMPS = 1_770_000_000_000_000_000 + np.round(1e9 * T).astype(int)
LOG_TIMES = 1_770_000_000_000_000_000 + np.round(1.01e9 * T + 2e6).astype(int)


def joint_state(store: Any, stamp: int, names: list[str], x: float, f: float) -> Any:
    types = store.types
    time = types["builtin_interfaces/msg/Time"](sec=stamp // 10**9, nanosec=stamp % 10**9)
    number = {"seq": 0} if "seq" in types["std_msgs/msg/Header"].__dataclass_fields__ else {}
    header = types["std_msgs/msg/Header"](stamp=time, frame_id="", **number)
    arrays = (np.array([k * v for k in range(1, len(names) + 1)]) for v in (x, 0.5 * x, f))
    position, velocity, effort = arrays
    return types["sensor_msgs/msg/JointState"](
        header=header, name=names, position=position, velocity=velocity, effort=effort
    )


def write_bag(writer: Any, store: Any, serialise: Any) -> None:
    """Two publishers of one topic, with other joints each."""
    kind = "sensor_msgs/msg/JointState"
    with writer:
        connection = writer.add_connection("/joint_states", kind, typestore=store)
        for k in range(N):
            for names in (["elbow", "wrist"], ["gripper"]):
                message = joint_state(store, int(STAMPS[k]), names, X[k], F[k])
                writer.write(connection, int(LOG_TIMES[k]), serialise(message, kind))


def make_bag(folder: Path, kind: str) -> Path:
    if kind == "ros 1":
        path = folder / "log.bag"
        write_bag(rosbag1.Writer(path), ROS_1, ROS_1.serialize_ros1)
        return path
    plugin = rosbag2.StoragePlugin.MCAP if "mcap" in kind else rosbag2.StoragePlugin.SQLITE3
    path = folder / "log"
    write_bag(rosbag2.Writer(path, version=9, storage_plugin=plugin), STORE, STORE.serialize_cdr)
    return path if "folder" in kind else next(p for p in path.iterdir() if p.suffix != ".yaml")


@pytest.mark.parametrize("kind", ["ros 1", "sqlite3 folder", "sqlite3", "mcap folder", "mcap"])
def test_joint_states_by_the_name_of_the_joint(kind: str, tmp_path: Path) -> None:
    path = make_bag(tmp_path, kind)
    reader, log = log_of(path)
    assert reader == "rosbag"
    assert [c.name for c in log.channels] == [
        f"/joint_states/{joint}/{quantity}"
        for joints in (["elbow", "wrist"], ["gripper"])
        for quantity in ("position", "velocity", "effort")
        for joint in joints
    ]
    assert channel(log, "/joint_states/wrist/position").ends == (2.0 * X[0], 2.0 * X[-1])
    recording = read(path, joint="wrist")
    np.testing.assert_allclose(recording.t, T, atol=1e-7)
    np.testing.assert_allclose(recording.position, 2.0 * X)
    assert recording.rotary
    assert recording.force is not None
    np.testing.assert_allclose(recording.force, 2.0 * F)
    by_log = read(path, joint="wrist", stamp="log")
    np.testing.assert_allclose(by_log.t, 1.01 * T, atol=1e-7)


def test_clocks_that_part_are_told(tmp_path: Path) -> None:
    times = 0.02 * np.arange(400)
    path = tmp_path / "log.bag"
    kind = "sensor_msgs/msg/JointState"
    with rosbag1.Writer(path) as writer:
        connection = writer.add_connection("/js", kind, typestore=ROS_1)
        for t in times:
            message = joint_state(ROS_1, int(1e9 * (1000.0 + t)), ["a"], 1.0, 2.0)
            raw = ROS_1.serialize_ros1(message, kind)
            writer.write(connection, int(1e9 * (1000.0 + 1.005 * t)), raw)
    _, log = log_of(path)
    (sentence,) = (p for p in log.problems if "apart" in p)
    parted, lasting = (float(w) for w in (sentence.split()[10], sentence.split()[14]))
    assert 1e-3 * parted / lasting == pytest.approx(0.005, rel=0.03)
    assert 'the header stamps are used; compare columns={"stamp": "log"}' in sentence


def test_a_bag_by_another_name(tmp_path: Path) -> None:
    path = make_bag(tmp_path, "mcap").rename(tmp_path / "log.csv")
    assert len(log_of(path)[1].channels) == 9


# --- ULog -----------------------------------------------------------------------------------------


@real
def test_a_recording_of_a_flight_controller() -> None:
    path = LOGS / "ulog" / "sample_log_small.ulg"
    reader, log = log_of(path)
    assert reader == "ulog"
    several = {d.name for d in ULog(str(path)).data_list if d.multi_id}
    tables = {t.clock: t for t in log.tables()}
    for topic in ULog(str(path)).data_list:
        clock = f"{topic.name}.{topic.multi_id}" if topic.name in several else topic.name
        table = tables[clock]
        np.testing.assert_allclose(times(table), 1e-6 * topic.data["timestamp"], rtol=1e-15)
        fields = set(topic.data) - {"timestamp"}
        assert set(table.columns) == {f"{clock}/{field}" for field in fields}
        for name in fields:
            np.testing.assert_array_equal(table.columns[f"{clock}/{name}"], topic.data[name])
    assert "the logger dropped out 1 times" in log.problems[0]


def ulog(topics: Mapping[int, tuple[str, int]], rows: list[tuple[int, int, float]]) -> bytes:
    """By the published format: a format, subscriptions, data of (id, time in us, number)."""

    def message(kind: bytes, body: bytes) -> bytes:
        return struct.pack("<Hc", len(body), kind) + body

    data = b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 1000)
    data += message(b"B", bytes(40))
    data += message(b"F", b"axis:uint64_t timestamp;float x;")
    for number, (name, instance) in topics.items():
        data += message(b"A", struct.pack("<BH", instance, number) + name.encode())
    for number, t, x in rows:
        data += message(b"D", struct.pack("<HQf", number, t, x))
    return data


def test_instances_of_a_topic_are_apart(tmp_path: Path) -> None:
    path = tmp_path / "log.ulg"
    rows = [(k % 2, 1000 + 500 * k, float(k)) for k in range(2 * N)]
    path.write_bytes(ulog({0: ("axis", 0), 1: ("axis", 1)}, rows))
    _, log = log_of(path)
    assert [c.name for c in log.channels] == ["axis.0/x", "axis.1/x"]
    table = table_of(log, "axis.1/x")
    values = table.columns["axis.1/x"]
    np.testing.assert_array_equal(values, np.arange(1.0, 2 * N, 2))
    np.testing.assert_allclose(times(table), 1e-6 * (1500.0 + 1000.0 * np.arange(float(N))))
    assert channel(log, "axis.0/x").rate == pytest.approx(1000.0)
