"""Logs of other people's tools, read as they are; values against the csv module and NumPy."""

from __future__ import annotations

import csv
import gzip
import io
import json
from pathlib import Path

import numpy as np
import pytest

from opened_logs import log_of, table_with, times
from stribeck.data import read
from stribeck.data.readers.raw_table import unique_names
from stribeck.errors import InputError
from stribeck.space import Array

LOGS = Path(__file__).parents[1] / ".." / "shared" / "data" / "logs"
real = pytest.mark.recordings

N = 50
T = 0.002 * np.arange(N)
X = 4.0 * np.sin(20.0 * T) + T
V = 80.0 * np.cos(20.0 * T) + 1.0


def write(folder: Path, content: str, name: str = "log.csv") -> Path:
    path = folder / name
    path.write_text(content, encoding="utf-8")
    return path


# --- TwinCAT Scope --------------------------------------------------------------------------------


def scope_columns(path: Path, separator: str) -> tuple[list[str], list[list[str]], Array]:
    """Names and units of an export's columns, and its samples, by the csv module alone."""
    text = path.read_text(encoding="utf-8")
    rows = list(csv.reader(io.StringIO(text), delimiter=separator))
    at = {row[0]: i for i, row in enumerate(rows) if row}
    names, units = rows[at["Name"]], rows[at["Unit"]]
    body = [row for row in rows[at["Unit Offset"] + 1 :] if row and row != ["EOF"]]
    cells = np.full((len(body), len(names)), np.nan)
    for i, row in enumerate(body):
        for j, cell in enumerate(row):
            if cell.strip():
                cells[i, j] = float(cell.replace(",", "."))
    return names, [units], cells


@real
@pytest.mark.parametrize("name", ["default", "decimal_comma", "double_stamps_excluded", "eof_line"])
def test_twincat_scope(name: str) -> None:
    path = LOGS / "twincat" / f"{name}.csv"
    reader, log = log_of(path)
    assert reader == "twincat"
    heads, (units,), cells = scope_columns(path, "\t")
    clocks = [j for j, head in enumerate(heads) if head == "Name"]
    channels = {c.name: c for c in log.channels}
    assert set(channels) == set(heads) - {"Name"}
    assert len(channels) == 21
    for j, head in enumerate(heads):
        if j in clocks:
            continue
        clock = max(k for k in clocks if k < j)
        rows = np.isfinite(cells[:, clock])
        table = table_with(log, head)
        np.testing.assert_allclose(times(table), 1e-3 * cells[rows, clock], atol=1e-12)
        np.testing.assert_array_equal(table.columns[head], cells[rows, j])
        assert channels[head].unit == (units[j].split(" ")[0] if "None" not in units[j] else None)
    assert channels["func_OS"].rate == pytest.approx(5000.0)
    assert channels["func_freesample"].rate == pytest.approx(200.0)
    assert len({c.clock for c in channels.values()}) == 3


@real
def test_twincat_scope_apart_by_blanks() -> None:
    """Names with blanks in them; values as in the export of the same run apart by tabs."""
    _, log = log_of(LOGS / "twincat" / "separator_1.csv")
    _, other = log_of(LOGS / "twincat" / "decimal_comma.csv")
    assert {c.name for c in log.channels} == {c.name for c in other.channels}
    assert {c.name: c.unit for c in log.channels} == {c.name: c.unit for c in other.channels}
    for name in ("func_OS", "test space", "test space (1)", "var_INT8"):
        np.testing.assert_allclose(
            table_with(log, name).columns[name], table_with(other, name).columns[name]
        )


@real
def test_twincat_scope_packed(tmp_path: Path) -> None:
    plain = LOGS / "twincat" / "default.csv"
    packed = tmp_path / "default.csv.gz"
    packed.write_bytes(gzip.compress(plain.read_bytes()))
    a, b = (table_with(log_of(p)[1], "func_OS").columns["func_OS"] for p in (plain, packed))
    np.testing.assert_array_equal(a, b)


SCOPE = """Name\tdrive
File\tC:\\axis.csv
Starttime of export\t132959733843760000\tMonday\t15:56:24
Endtime of export\t132959733853750000\tMonday\t15:56:25


Name\tActPos\tName\tActTorque
SymbolComment\t\tSymbolComment\t
Data-Type\tREAL64\tData-Type\tREAL32
SampleTime[ms]\t2\tSampleTime[ms]\t1
Unit\tmm (Length)\tUnit\tNm (Torque)

"""


def scope(torque: Array) -> str:
    fine = 0.5 * np.arange(2 * len(X))
    rows = []
    for k, t in enumerate(fine):
        position = f"{2 * k}\t{X[k]:.17g}" if k < len(X) else " \t "
        rows.append(f"{position}\t{2 * t}\t{torque[k]:.17g}")
    return SCOPE + "\n".join(rows) + "\nEOF\n"


def test_a_scope_with_two_clocks_is_a_recording(tmp_path: Path) -> None:
    """A ramp keeps its values where a channel twice as fast is averaged."""
    torque: Array = 0.25 * np.arange(2.0 * N)
    path = write(tmp_path, scope(torque).replace("Nm (Torque)", "N (Force)"))
    log = read(path)
    np.testing.assert_allclose(log.t, T[: len(log)], atol=1e-12)
    np.testing.assert_allclose(log.position, 1e-3 * X[: len(log)])
    assert log.force is not None
    np.testing.assert_allclose(log.force[1:-1], torque[2:-2:2][: len(log) - 2], atol=1e-12)
    assert any("ActTorque, measured each 1 ms: averaged" in note for note in log.notes)


def test_a_scope_without_samples_is_refused(tmp_path: Path) -> None:
    path = write(tmp_path, SCOPE.rstrip("\n") + "\n\n")
    with pytest.raises(InputError, match="has heads and no samples"):
        read(path)
    with pytest.raises(InputError, match="has heads and no samples"):
        read(write(tmp_path, SCOPE.rstrip("\n") + "\n "))


def test_a_channel_of_a_scope_without_samples_is_refused(tmp_path: Path) -> None:
    rows = "".join(f"{2 * k}\t{x:.17g}\t \t \n" for k, x in enumerate(X))
    with pytest.raises(InputError, match="no samples of ActTorque: name other channels"):
        read(write(tmp_path, SCOPE.replace("Nm (Torque)", "N (Force)") + rows + "EOF\n"))


def test_a_scope_whose_heads_do_not_end_is_refused(tmp_path: Path) -> None:
    path = write(tmp_path, SCOPE.rstrip("\n"))
    with pytest.raises(InputError, match="its heads do not end"):
        read(path)


# --- CODESYS --------------------------------------------------------------------------------------


@real
def test_codesys_trace() -> None:
    path = LOGS / "codesys" / "sinto.trace.csv"
    series: dict[str, list[list[float]]] = {}
    for line in path.read_text(encoding="utf-8").splitlines():
        key, *cells = line.split(";")
        if key.endswith(".Variable"):
            series[cells[0].strip()] = []
        elif not key.strip() and len(cells) == 2:
            list(series.values())[-1].append([float(c) for c in cells])
    reader, log = log_of(path, time_unit="ms")
    assert reader == "codesys"
    assert [c.name for c in log.channels] == list(series)
    for name, pairs in series.items():
        table = table_with(log, name)
        np.testing.assert_allclose(times(table), 1e-3 * np.array(pairs)[:, 0])
        np.testing.assert_array_equal(table.columns[name], np.array(pairs)[:, 1])


def test_a_variable_of_5000_digits_is_a_name(tmp_path: Path) -> None:
    text = trace(1).replace("0.Variable", f"{'1' * 5000}.Variable")
    _, log = log_of(write(tmp_path, text, "log.trace.csv"), time_unit="ms")
    assert any(c.name.startswith("variable 0") for c in log.channels)


def trace(scale: int) -> str:
    body = "[key]; [value]\nVersion; 1\n"
    for k, (name, values) in enumerate({"axis.fActPos": X, "axis.fForce": V}.items()):
        rows = "\n".join(
            f"; {round(1e3 * t) * scale}; {v:.17g}" for t, v in zip(T, values, strict=True)
        )
        body += f"{k}.Variable; {name}\n{k}.Data; \n{rows}\n"
    return body


def test_a_trace_asks_for_its_unit_of_time(tmp_path: Path) -> None:
    path = write(tmp_path, trace(1000), "axis.trace.csv")
    columns = {"position": "axis.fActPos [mm]", "force": "axis.fForce [N]"}
    with pytest.raises(InputError, match=r'give columns={"time_unit": "ms"} or us$'):
        read(path, columns=columns)
    log = read(path, columns=columns, time_unit="us")
    np.testing.assert_allclose(log.t, T, atol=1e-12)
    np.testing.assert_allclose(log.position, 1e-3 * X)


def test_a_trace_with_a_word_in_it_is_refused(tmp_path: Path) -> None:
    path = write(tmp_path, trace(1).replace("; 4; ", "; 4; x"), "axis.trace.csv")
    with pytest.raises(InputError, match=r"line 7: 'x.*' is not a number"):
        read(path)


# --- text -----------------------------------------------------------------------------------------


@real
def test_mr_configurator() -> None:
    path = LOGS / "mr_configurator" / "a3MR.csv"
    cells = np.loadtxt(path, delimiter=",", skiprows=5)
    _, log = log_of(path)
    table = table_with(log, "Torque")
    for name, k in {"Time [ms]": 0, "Servo motor speed": 1, "Torque": 2, "INP": 8}.items():
        np.testing.assert_allclose(table.columns[name][:1024], cells[:, k])  # a blank line is last
    assert [n for n in table.columns if n.startswith("Not selected")] == []
    assert any("11 channels are not selected" in note for note in log.problems)


@real
def test_a_robots_log_without_heads() -> None:
    path = LOGS / "universal_robots" / "ur10e_headless.csv"
    cells = np.loadtxt(path, delimiter=",")
    log = read(path, columns={"time": "1 [s]", "position": "2 [rad]", "current": "14 [A]"})
    np.testing.assert_allclose(log.t, cells[:, 0] - cells[0, 0], atol=1e-9)
    np.testing.assert_allclose(log.position, cells[:, 1])
    assert log.current is not None
    np.testing.assert_allclose(log.current, cells[:, 13])


@real
def test_a_log_with_dates_decimal_commas_and_empty_columns() -> None:
    path = LOGS / "universal_robots" / "ur3_cobotops_4000.csv"
    with path.open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file, delimiter=";"))
    _, log = log_of(path)
    table = table_with(log, "Current_J3")
    assert table.columns["Timestamp"][1] == pytest.approx(1.005)  # 08:17:21.847, 08:17:22.852
    assert table.columns["Timestamp"][-1] == pytest.approx(6 * 3600 + 21 * 60 + 27.122)
    expected = [
        float(r["Current_J3"].replace(",", ".")) if r["Current_J3"] else np.nan for r in rows
    ]
    np.testing.assert_allclose(table.columns["Current_J3"], expected)
    assert len(table.columns) == 24


@real
def test_plotjuggler_samples() -> None:
    _, log = log_of(LOGS / "plotjuggler" / "simple_parse_timestamp.csv")
    table = table_with(log, "timestamp")
    np.testing.assert_allclose(table.columns["timestamp"], [0.0, 0.2, 0.4, 0.6, 0.61], atol=1e-9)
    np.testing.assert_array_equal(table.columns["A"], [np.nan, 4.0, 5.0, 6.0, 7.0])
    motor = LOGS / "plotjuggler" / "motor_data.csv"
    cells = np.loadtxt(motor, delimiter=",", skiprows=1)
    table = table_with(log_of(motor)[1], "torque")
    np.testing.assert_array_equal(np.column_stack(list(table.columns.values())), cells)


STAMPS = {
    "iso": [f"2026-03-01T23:59:59.{900 + 2 * k:03d}Z" for k in range(N)],
    "slashes": [f"03/28/2026 10:11:32.{2 * k:03d}" for k in range(N)],
    "points": [f"28.03.2026 10:11:32.{2 * k:03d}" for k in range(N)],
    "midnight": [f"{(86399.95 + t) % 86400 // 3600:02.0f}:"
                 f"{(86399.95 + t) % 3600 // 60:02.0f}:{(86399.95 + t) % 60:06.3f}" for t in T],
    "unix s": [f"{1_770_000_000 + t:.3f}" for t in T],
    "unix ms": [str(1_770_000_000_000 + round(1e3 * t)) for t in T],
    "unix us": [str(1_770_000_000_000_000 + round(1e6 * t)) for t in T],
    "unix ns": [str(1_770_000_000_000_000_000 + round(1e9 * t)) for t in T],
    "filetime": [str(133_000_000_000_000_000 + round(1e7 * t)) for t in T],
}  # fmt: skip


@pytest.mark.parametrize("kind", STAMPS)
def test_dates(kind: str, tmp_path: Path) -> None:
    rows = "\n".join(f"{s};{x:.17g}" for s, x in zip(STAMPS[kind], X, strict=True))
    log = read(write(tmp_path, f"timestamp;x [mm]\n{rows}\n"))
    np.testing.assert_allclose(log.t, T, atol=2e-6)  # FILETIME in float64 has steps of 1.6 us


def test_marks_each_three_digits(tmp_path: Path) -> None:
    x = 1000.0 * X + 5000.0
    rows = "\n".join(f'{t:.3f};"{v:,.4f}"' for t, v in zip(T, x, strict=True))
    log = read(write(tmp_path, f"t [s];x [um]\n{rows}\n"))
    np.testing.assert_allclose(log.position, 1e-6 * x, atol=1e-9)


def test_second_heads_second_names_and_heads_twice(tmp_path: Path) -> None:
    rows = "\n".join(f"{1e3 * t},{x},{v},1,2" for t, x, v in zip(T, X, V, strict=True))
    text = f"Drive 1\nTime,Analog 1,Analog 2,a,a\nms,mm,Torque,,\n{rows}\n"
    _, log = log_of(write(tmp_path, text))
    assert [c.name for c in log.channels] == ["Time [ms]", "Analog 1 [mm]", "Torque", "a", "a #2"]
    assert unique_names(["a", "b", "a", "a", "", ""]) == ["a", "b", "a #2", "a #3", "", ""]


def test_a_log_without_times_needs_a_rate(tmp_path: Path) -> None:
    path = write(
        tmp_path, "x_mm,v_mm_s\n" + "\n".join(f"{x},{v}" for x, v in zip(X, V, strict=True))
    )
    with pytest.raises(InputError, match=r'columns={"rate": 500}'):
        read(path)
    np.testing.assert_allclose(read(path, rate=500.0).t, T, atol=1e-12)
    with pytest.raises(InputError, match="a number of Hz above 0"):
        read(path, rate=0.0)


def test_a_sampler_that_overran(tmp_path: Path) -> None:
    """halsampler of LinuxCNC: no heads, numbers of samples if asked for, lines `overrun`."""
    rows = [f"{k} {x:.17g} {v:.17g} 1" for k, (x, v) in enumerate(zip(X, V, strict=True))]
    path = write(tmp_path, "\n".join([*rows[:20], "overrun", *rows[20:]]) + "\n")
    log = read(path, columns={"position": "2 [mm]", "velocity": "3 [mm/s]"}, rate=500.0)
    np.testing.assert_allclose(log.position, 1e-3 * X)
    np.testing.assert_allclose(log.t, T, atol=1e-12)
    assert any("the sampler overran 1 times" in note for note in log.notes)


def test_an_accelerometer_of_klipper(tmp_path: Path) -> None:
    rows = "\n".join(f"{t:.6f},{x:.6f},{v:.6f},9806.65" for t, x, v in zip(T, X, V, strict=True))
    _, log = log_of(write(tmp_path, f"#time,accel_x,accel_y,accel_z\n{rows}\n"))
    table = table_with(log, "accel_y")
    assert list(table.columns) == ["time", "accel_x", "accel_y", "accel_z"]
    np.testing.assert_allclose(table.columns["accel_y"], V, atol=1e-6)


def test_a_record_a_line(tmp_path: Path) -> None:
    records = [{"t_s": t, "x_mm": x} for t, x in zip(T.tolist(), X.tolist(), strict=True)]
    lines = [json.dumps(r) for r in records]
    path = write(tmp_path, "\n".join(lines) + "\n", "log.jsonl")
    np.testing.assert_allclose(read(path).position, 1e-3 * X)
    with pytest.raises(InputError, match="is no JSON, or not all of it"):
        read(write(tmp_path, "\n".join(lines)[:-9], "log.jsonl"))


def test_a_velocity_alone_is_integrated(tmp_path: Path) -> None:
    rows = "\n".join(f"{t:.3f},{v:.17g},3" for t, v in zip(T, V, strict=True))
    log = read(write(tmp_path, f"t_s,v_mm_s,F_N\n{rows}\n"))
    np.testing.assert_allclose(log.position, 1e-3 * (X - X[0]), atol=2e-6)  # the trapezia's error
    assert not log.rotary
    assert any("is the integral of v_mm_s" in note for note in log.notes)
    columns = {"velocity": "n_rpm", "force": "M_Nm"}
    spindle = read(write(tmp_path, f"t_s,n_rpm,M_Nm\n{rows}\n"), columns=columns)
    assert spindle.rotary
    assert spindle.velocity is not None
    np.testing.assert_allclose(spindle.velocity, V * 2.0 * np.pi / 60.0)


JOINTS = "t_s,q1_rad,q2_rad,tau_1_Nm,tau_2_Nm"


@pytest.mark.parametrize(
    ("heads", "joint"),
    [
        (JOINTS, "2"),
        ("t_s,elbow.position_rad,wrist.position_rad,elbow.effort_Nm,wrist.effort_Nm", "wrist"),
        ("t_s,X1_Position_rad,Y1_Position_rad,X1_Torque_Nm,Y1_Torque_Nm", "Y1"),
        ("t_s,Position_J0_rad,Position_J1_rad,Torque_J0_Nm,Torque_J1_Nm", "J1"),
        ("t_s,state[0].q_rad,state[1].q_rad,state[0].tau_Nm,state[1].tau_Nm", "1"),
    ],
)
def test_a_joint_of_several(heads: str, joint: str, tmp_path: Path) -> None:
    rows = "\n".join(
        f"{t:.3f},{v:.17g},{x:.17g},1,{2 + k}"
        for k, (t, x, v) in enumerate(zip(T, X, V, strict=True))
    )
    path = write(tmp_path, f"{heads}\n{rows}\n")
    log = read(path, joint=joint)
    np.testing.assert_allclose(log.position, X)
    assert log.force is not None
    np.testing.assert_allclose(log.force, 2.0 + np.arange(N))
    with pytest.raises(InputError, match="no column names the joint 7"):
        read(path, joint="7")


def test_a_window_of_a_log(tmp_path: Path) -> None:
    rows = "\n".join(f"{5 + t:.3f},{x:.17g}" for t, x in zip(T, X, strict=True))
    path = write(tmp_path, f"t_s,x_mm\n{rows}\n")
    part = read(f"{path}@0.02s:0.06s")
    np.testing.assert_allclose(part.position, 1e-3 * X[10:30])
    np.testing.assert_allclose(part.t, T[:20], atol=1e-9)
    with pytest.raises(InputError, match=r"3s:4s holds 0 samples: the log lasts 0\.098 s"):
        read(f"{path}@3s:4s")
    with pytest.raises(InputError, match="is no time"):
        read(f"{path}@4s:3s")


def test_a_wrong_extension_is_no_obstacle(tmp_path: Path) -> None:
    rows = "\n".join(f"{t:.3f},{x:.17g}" for t, x in zip(T, X, strict=True))
    for name in ("log.mat", "log.parquet", "log", "log.xyz", "log.json"):
        np.testing.assert_allclose(
            read(write(tmp_path, f"t_s,x_mm\n{rows}\n", name)).position, 1e-3 * X
        )
    records = [{"t [s]": t, "x [mm]": x} for t, x in zip(T.tolist(), X.tolist(), strict=True)]
    np.testing.assert_allclose(
        read(write(tmp_path, json.dumps(records), "log.csv")).position, 1e-3 * X
    )
