"""Logs that are read: formats, heads, dialects, repairs, published data."""

from __future__ import annotations

import hashlib
import io
import struct
from pathlib import Path

import numpy as np
import polars as pl
import pytest
import scipy.io
from hypothesis import given, settings
from hypothesis import strategies as st

from stribeck.data import Recording, read
from stribeck.data.readers.delimited import read_text
from stribeck.data.readers.heads import Head, meanings, take_apart
from stribeck.data.readers.log_contents import contents
from stribeck.data.readers.matlab_file import read_matlab
from stribeck.data.readers.repair import SHORT_GAP
from stribeck.errors import InputError

REAL = Path(__file__).parents[1] / ".." / "shared" / "data"
real = pytest.mark.recordings

N = 40
T = np.arange(N) * 0.01
X = 5.0 * np.sin(3.0 * T) + 0.001 * np.arange(N)  # mm
EMPS = {
    "time": "t [s]",
    "position": "qm [m]",
    "command": "qg [m]",
    "voltage": "vir [V]",
    "force": {"column": "vir", "factor": "gtau", "unit": "N"},
}


def table(
    heads: str = "t_s,x_mm", *, separator: str = ",", end: str = "\n", comma: bool = False
) -> str:
    rows = [f"{t:.6g}{separator}{x:.6g}" for t, x in zip(T, X, strict=True)]
    rows = [r.replace(".", ",") for r in rows] if comma else rows
    return end.join([heads.replace(",", separator), *rows]) + end


def write(folder: Path, content: str | bytes, name: str = "log.csv") -> Path:
    path = folder / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


def assert_same(recording: Recording) -> None:
    np.testing.assert_allclose(recording.t, T, atol=1e-9)
    np.testing.assert_allclose(recording.position, X * 1e-3, atol=1e-8)


@pytest.mark.parametrize(
    ("head", "stem", "unit"),
    [
        ("t_s", "t", "s"),
        ("time [ms]", "time", "ms"),
        ("Time (s)", "time", "s"),
        ("Position [mm]", "position", "mm"),
        ("position_mm", "position", "mm"),
        ("qd_rad_s", "qd", "rad_s"),
        ("qdd_rad_s2", "qdd", "rad_s2"),
        ("q_cmd_rad", "q_cmd", "rad"),
        ("tau_meas_Nm", "tau_meas", "Nm"),
        ("tau_N_m", "tau", "N m"),
        ("velocity_mm_s", "velocity", "mm_s"),
        ("vel (deg/s)", "vel", "deg/s"),
        ("speed [1/min]", "speed", "1/min"),
        ("Weg / mm", "weg", "mm"),
        ("ActPos [mm]", "act_pos", "mm"),
        ("Temp [°C]", "temp", "°C"),
        ("b [N/(mm/s)]", "b", "N/(mm/s)"),
        ("position", "position", None),
        ("x_m_s_mm_s", "x_m_s", "mm_s"),
        ("m", "m", None),
        ("", "", None),
    ],
)
def test_a_head_is_taken_apart(head: str, stem: str, unit: str | None) -> None:
    assert take_apart(head) == Head(stem, unit)


@pytest.mark.parametrize(
    ("stem", "expected"),
    [
        ("tau_meas", {"force": 0}),
        ("tau", {"force": 1}),
        ("tau_cmd", {"force": 3}),
        ("q_cmd", {"command": 1}),
        ("position_actual", {"position": 0}),
        ("qd_cmd", {}),
        ("tau_ff", {}),
        ("setpoint", {"command": 1}),
        ("qd", {"command": 1, "velocity": 1}),
        ("clean", {}),
    ],
)
def test_what_a_name_may_mean(stem: str, expected: dict[str, int]) -> None:
    assert meanings(Head(stem, None)) == expected


@pytest.mark.parametrize(
    "content",
    [
        table(),
        table(separator=";"),
        table(separator="\t"),
        table(separator="|"),
        table(separator=" "),
        table(separator=";", comma=True),
        table(separator="\t", comma=True),
        table(end="\r\n"),
        table(end="\r"),
        table("\ufefft_s,x_mm"),
        table().encode("utf-16"),
        table().encode("utf-16-le"),
        table("t [s],x [mm]").encode("utf-16-be"),
        table("t_s,x_mm,"),
        table('"t_s","x_mm"'),
        table("# t_s,x_mm"),
        "Rig 7; operator: N. N.\n# a remark, with commas\n\n" + table(),
        table("t,x\ns,mm"),
        table("t,x\n[s],[mm]"),
        table("t_s,x_mm,").replace("\n0", ",\n0"),
        table() + "\n\n\n",
        table().replace("\n0.2,", "\n# a remark\n0.2,"),
        table().replace(",", " , "),
        "\n".join(f'"{a}","{b}"' for a, b in (r.split(",") for r in table().split())),
    ],
)
def test_every_dialect_says_the_same(content: str | bytes, tmp_path: Path) -> None:
    assert_same(read(write(tmp_path, content)))


def test_latin_1_heads(tmp_path: Path) -> None:
    heads = "t_s,x_mm,Kühlung\n"
    rows = "".join(f"{t:.6g},{x:.6g},20\n" for t, x in zip(T, X, strict=True))
    recording = read(write(tmp_path, (heads + rows).encode("latin-1")))
    assert_same(recording)
    assert list(recording.extra) == ["Kühlung"]


def test_a_sign_of_windows_in_a_unit(tmp_path: Path) -> None:
    """Drives of Windows programs write torque in per mille as byte 0x89, which Latin-1 lacks."""
    rows = "".join(f"{1e6 * t:.6g},{x:.6g},20\n" for t, x in zip(T, X, strict=True))
    file = write(tmp_path, ("Zeit [µs],Weg [mm],M [‰]\n" + rows).encode("cp1252"))
    assert [c.unit for c in contents(file).channels] == ["µs", "mm", "‰"]


def two_rates(slow: str, step: int, late: int = 0) -> str:
    """A log of which one column is written in every k-th row alone, from one of these on."""
    force = np.cos(3.0 * T)
    lines = ["t_s;x_mm;F_N;mode"]
    for k, (t, x, f) in enumerate(zip(T, X, force, strict=True)):
        there = k % step == late
        cells = (f"{x:.9g}" if there or slow != "x_mm" else "",
                 f"{f:.9g}" if there or slow != "F_N" else "")  # fmt: skip
        lines.append(f"{t:.6g};{cells[0]};{cells[1]};auto".replace(".", ","))
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize(
    ("step", "late", "every"), [(2, 0, 1), (3, 2, 1), (4, 0, 2), (4, 3, 2), (6, 1, 3)]
)
def test_a_force_that_is_slower_is_read_between_its_samples(
    step: int, late: int, every: int, tmp_path: Path
) -> None:
    """Of the positions there are two to one of the force, or a few more."""
    recording = read(write(tmp_path, two_rates("F_N", step, late)))
    own = np.arange(late, (N - 1 - late) // step * step + late + 1, every)
    np.testing.assert_allclose(recording.t, T[own] - T[own[0]], atol=1e-9)
    np.testing.assert_allclose(recording.position, X[own] * 1e-3, atol=1e-9)
    assert recording.force is not None
    w = 3.0 * step * (T[1] - T[0])
    np.testing.assert_allclose(recording.force, np.cos(3.0 * T[own]), atol=w**6 / 20 + 1e-8)
    assert f"F_N, measured each {10 * step} ms: interpolated between its samples" in recording.notes
    thinned = f"x_mm: one of {every} samples is read, as the force is slower"
    assert (thinned in recording.notes) == (every > 1)


def test_a_slower_force_is_joined_by_rows_where_stamps_are_rounded(tmp_path: Path) -> None:
    """Two rows have the same stamp, but not where one of two is read."""
    lines = two_rates("F_N", 4).splitlines()
    rounded = [
        f"{2 * (k // 2) * (T[1] - T[0]):.6g}".replace(".", ",") + line[line.index(";") :]
        for k, line in enumerate(lines[1:])
    ]
    recording = read(write(tmp_path, "\n".join([lines[0], *rounded])))
    np.testing.assert_allclose(np.diff(recording.t), 2 * (T[1] - T[0]), atol=1e-9)
    assert recording.force is not None
    own = np.arange(0, 2 * len(recording), 2)
    np.testing.assert_allclose(recording.force, np.cos(3.0 * T[own]), atol=1e-5)


def test_an_infinite_cell_of_a_slower_force_is_refused(tmp_path: Path) -> None:
    lines = two_rates("F_N", 4).splitlines()
    lines[17] = ";".join([*lines[17].split(";")[:2], "inf", "auto"])
    with pytest.raises(InputError, match=r"line 18: force is infinite"):
        read(write(tmp_path, "\n".join(lines)))


@pytest.mark.parametrize(
    ("position", "reason"), [("", "position column is empty"), ("1e308", "position has values")]
)
def test_positions_that_are_none_beside_a_slower_force(
    position: str, reason: str, tmp_path: Path
) -> None:
    lines = [line.split(";") for line in two_rates("F_N", 6).splitlines()]
    for k, cells in enumerate(lines[1:]):
        cells[1] = position and f"{'-' * (k % 2)}{position}"
    with pytest.raises(InputError, match=reason):
        read(write(tmp_path, "\n".join(map(";".join, lines))))


def test_another_column_that_is_slower_is_read_between_its_samples(tmp_path: Path) -> None:
    head = "t_s;x_mm;I_A"
    rows = [
        f"{t:.6g};{x:.9g};{k if k % 4 == 0 else ''}"
        for k, (t, x) in enumerate(zip(T, X, strict=True))
    ]
    recording = read(write(tmp_path, "\n".join([head, *rows]) + "\n"))
    assert recording.current is not None
    np.testing.assert_allclose(recording.t, T[: len(recording.t)], atol=1e-9)
    np.testing.assert_allclose(recording.current, np.arange(len(recording.t)), atol=1e-9)
    assert any("I_A, measured each 40 ms: interpolated" in note for note in recording.notes)


def test_a_position_at_a_lower_rate_is_the_clock_of_the_log(tmp_path: Path) -> None:
    """What is faster is averaged, so that nothing above half of the lower rate folds down."""
    recording = read(write(tmp_path, two_rates("x_mm", 4)))
    np.testing.assert_allclose(recording.t, T[: 4 * len(recording.t) : 4], atol=1e-9)
    np.testing.assert_allclose(recording.position, X[::4] * 1e-3, atol=1e-9)
    assert recording.force is not None
    # The mean of a cosine over 40 ms is 6e-4 too small, which is given back.
    inner = slice(3, -3)
    np.testing.assert_allclose(recording.force[inner], np.cos(3.0 * T[::4][inner]), atol=1e-6)


def test_the_rate_of_a_slower_column_is_its_own(tmp_path: Path) -> None:
    rates = {c.name: c.rate for c in contents(write(tmp_path, two_rates("F_N", 4))).channels}
    assert rates["x_mm"] == pytest.approx(100.0)
    assert rates["F_N"] == pytest.approx(25.0, rel=0.1)


def test_a_slower_column_that_is_away_for_long_has_a_gap(tmp_path: Path) -> None:
    lines = two_rates("F_N", 2).splitlines()
    gone = [
        f"{line.rsplit(';', 2)[0]};;auto" if 8 < k < 26 else line for k, line in enumerate(lines)
    ]
    with pytest.raises(InputError, match="force is empty in line"):
        read(write(tmp_path, "\n".join(gone)))


@pytest.mark.parametrize(
    ("heads", "factor"),
    [("t_s,x_m", 1.0), ("t_s,x_um", 1e-6), ("t_s,q_rad", 1.0), ("t_s,pos_deg", np.pi / 180)],
)
def test_positions_come_in_si(heads: str, factor: float, tmp_path: Path) -> None:
    recording = read(write(tmp_path, table(heads)))
    np.testing.assert_allclose(recording.position, X * factor, rtol=1e-5, atol=1e-9)
    assert recording.rotary == heads.endswith(("rad", "deg"))


@pytest.mark.parametrize(("unit", "second"), [("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("min", 60)])
def test_time_comes_in_seconds(unit: str, second: float, tmp_path: Path) -> None:
    recording = read(write(tmp_path, table(f"time [{unit}],x_mm")))
    np.testing.assert_allclose(recording.t, T * second, rtol=1e-9)


def columns(**channels: np.ndarray) -> pl.DataFrame:
    return pl.DataFrame({"t_s": T, "x_mm": X} | channels)


def test_all_channels_find_their_place(tmp_path: Path) -> None:
    signal = np.arange(N) / 7
    path = tmp_path / "all.csv"
    columns(
        command_mm=signal, velocity_mm_s=signal, acc_mm_s2=signal, force_N=signal,
        current_mA=signal, u_V=signal, temperature_degC=signal, tau_cmd_Nm=signal, note=signal,
    ).write_csv(path)  # fmt: skip
    r = read(path)
    milli = ("command", "velocity", "acceleration", "current")
    for name, factor in {**dict.fromkeys(milli, 1e-3), "force": 1, "voltage": 1}.items():
        np.testing.assert_allclose(getattr(r, name), signal * factor, rtol=1e-12)
    assert r.temperature is not None
    np.testing.assert_allclose(r.temperature, signal + 273.15)
    assert list(r.extra) == ["tau_cmd_Nm", "note"]
    np.testing.assert_array_equal(r.extra["note"], signal)


def test_what_is_measured_goes_before_what_is_commanded(tmp_path: Path) -> None:
    signal = np.arange(N) / 7
    path = tmp_path / "log.csv"
    columns(F_cmd_N=signal, F_meas_N=2 * signal, F_N=3 * signal).write_csv(path)
    r = read(path)
    assert r.force is not None
    np.testing.assert_array_equal(r.force, 2 * signal)


def test_a_unit_that_does_not_fit_leaves_a_channel_empty_and_says_so(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    columns(torque_Nm=T).write_csv(path)
    r = read(path)
    assert r.force is None
    assert list(r.extra) == ["torque_Nm"]
    assert any("torque_Nm" in note for note in r.notes)


def test_parquet(tmp_path: Path) -> None:
    path = tmp_path / "log.parquet"
    columns(flag=np.arange(N) % 2 == 0).write_parquet(path)
    r = read(path)
    assert_same(r)
    assert r.extra["flag"].sum() == N / 2


def test_parquet_with_a_clock(tmp_path: Path) -> None:
    path = tmp_path / "log.parquet"
    clock = pl.Series("time", (T * 1e6).round().astype(np.int64)).cast(pl.Duration("us"))
    columns().with_columns(clock).drop("t_s").write_parquet(path)
    assert_same(read(path))


def test_an_error_of_what_reads_parquet_is_no_fault_of_the_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    program = tmp_path / "program.py"
    program.write_text("raise LookupError('of ours')")
    monkeypatch.setattr("stribeck.data.readers.isolated.PROGRAM", program)
    path = tmp_path / "log.parquet"
    columns().write_parquet(path)
    with pytest.raises(RuntimeError, match="LookupError: of ours"):
        read(path)


@pytest.mark.parametrize("packed", [False, True])
def test_matlab(packed: bool, tmp_path: Path) -> None:
    path = tmp_path / "log.mat"
    arrays = {"t_s": T, "x_mm": X[:, None], "gain": 3.5, "pair": np.stack([T, X], 1), "who": "me"}
    scipy.io.savemat(path, arrays, do_compression=packed)
    r = read(path)
    assert_same(r)
    np.testing.assert_array_equal(r.extra["gain"], 3.5)
    np.testing.assert_array_equal(r.extra["pair_2"], X)


def test_a_matlab_structure_is_left_out_and_named(tmp_path: Path) -> None:
    path = tmp_path / "log.mat"
    scipy.io.savemat(path, {"t_s": T, "x_mm": X, "setup": {"a": 1}})
    r = read(path)
    assert_same(r)
    assert any("setup" in note for note in r.notes)


def test_a_mapping_names_columns_units_and_factors(tmp_path: Path) -> None:
    path = write(tmp_path, table("a,b"))
    mapped = {"time": "a [s]", "position": {"column": "b", "unit": "m", "factor": 1e-3}}
    assert_same(read(path, columns=mapped))


def test_a_factor_may_be_a_column(tmp_path: Path) -> None:
    path = tmp_path / "log.mat"
    scipy.io.savemat(path, {"t_s": T, "x_mm": X, "u": T, "k": 2.0, "s": X})
    for factor, expected in (("k", 2 * T), ("s", X * T), (-3, -3 * T)):
        r = read(path, columns={"force": {"column": "u", "unit": "N", "factor": factor}})
        assert r.force is not None
        np.testing.assert_allclose(r.force, expected, rtol=1e-12)


@pytest.mark.parametrize("head", ["", "[columns]\n"])
def test_a_mapping_may_be_a_toml_file(head: str, tmp_path: Path) -> None:
    toml = write(tmp_path, head + 'time = "a [s]"\nposition = "b [mm]"\n', "map.toml")
    assert_same(read(write(tmp_path, table("a,b")), columns=toml))


def test_a_head_with_its_unit_may_be_mapped_as_it_stands(tmp_path: Path) -> None:
    path = write(tmp_path, table("Zyklus [ms],Schlitten 1 [mm]"))
    r = read(path, columns={"time": "Zyklus [ms]", "position": "Schlitten 1 [mm]"})
    np.testing.assert_allclose(r.position, X * 1e-3, atol=1e-8)


def lines(*changes: tuple[int, str]) -> str:
    rows = table().split("\n")
    for i, row in changes:
        rows[i] = row
    return "\n".join(rows)


def test_exact_duplicates_are_dropped_and_counted(tmp_path: Path) -> None:
    rows = table().split("\n")
    r = read(write(tmp_path, "\n".join([*rows[:6], rows[5], *rows[6:]])))
    assert_same(r)
    assert "1 exact duplicate row dropped" in r.notes
    assert r.source.rows == N + 1 + 1 - 1


@pytest.mark.parametrize("word", ["", "nan", "NaN", "NAN", "NA", "null", "NULL", "N/A", "-"])
def test_short_gaps_are_interpolated_and_counted(word: str, tmp_path: Path) -> None:
    r = read(write(tmp_path, lines((21, f"0.2,{word}"))))
    assert r.position[20] == pytest.approx((X[19] + X[21]) / 2e3, abs=1e-8)
    assert "1 empty position value interpolated" in r.notes


def test_empty_ends_are_trimmed_and_counted(tmp_path: Path) -> None:
    r = read(write(tmp_path, lines((1, "0,"), (2, "0.01,nan"), (N, "0.39,"))))
    np.testing.assert_allclose(r.t, T[2:-1] - T[2], atol=1e-9)
    assert "3 rows without time or position trimmed at the ends" in r.notes


def test_jitter_is_kept_and_reported(tmp_path: Path) -> None:
    t = np.cumsum(np.where(np.arange(N) % 2, 0.01, 0.03))
    path = tmp_path / "log.csv"
    columns().with_columns(pl.Series("t_s", t)).write_csv(path)
    r = read(path)
    np.testing.assert_allclose(r.t, t - t[0], atol=1e-15)
    assert any("irregular" in note for note in r.notes)


def test_time_counts_from_the_first_sample(tmp_path: Path) -> None:
    columns().with_columns(pl.Series("t_s", T + 7.5)).write_csv(tmp_path / "log.csv")
    r = read(tmp_path / "log.csv")
    np.testing.assert_allclose(r.t, T, atol=1e-12)
    assert "time counts from the first sample, 7.5 s on the log's clock" in r.notes


def test_rows_after_the_clock_stopped_are_dropped(tmp_path: Path) -> None:
    r = read(write(tmp_path, table() + "".join(f"0.39,{i}\n" for i in range(30))))
    assert_same(r)
    assert any("30 rows after the clock stopped" in note for note in r.notes)


def test_columns_of_words_or_with_holes_never_stop_a_log(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    holes = np.where(np.arange(N) % 3, np.nan, 1.0)
    columns(mode=np.array(["run"] * N), empty=np.full(N, np.nan), holes=holes).write_csv(path)
    r = read(path)
    assert_same(r)
    assert not r.extra
    assert any("mode" in note for note in r.notes)
    assert any("holes" in note for note in r.notes)


def test_the_source_says_what_was_read(tmp_path: Path) -> None:
    path = write(tmp_path, table())
    source = read(path).source
    assert source.file == "log.csv"
    assert source.sha256 == hashlib.sha256(path.read_bytes()).hexdigest()
    assert source.rows == N


def test_reading_twice_gives_the_same_bits(tmp_path: Path) -> None:
    path = write(tmp_path, table())
    a, b = read(path), read(path)
    assert a.t.tobytes() == b.t.tobytes()
    assert a.position.tobytes() == b.position.tobytes()


@settings(max_examples=30)
@given(
    st.lists(st.floats(-1e6, 1e6, allow_nan=False), min_size=12, max_size=40, unique=True),
    st.sampled_from([",", ";", "\t"]),
)
def test_numbers_come_through_unchanged(values: list[float], separator: str) -> None:
    x = np.array(values)
    frame = pl.DataFrame({"t_s": np.arange(len(x)) * 0.5, "x_m": x})
    buffer = io.BytesIO()
    frame.write_csv(buffer, separator=separator)
    np.testing.assert_array_equal(read_text(buffer.getvalue()).columns["x_m"], x)


def outcome(text: str) -> tuple[object, ...]:
    try:
        table = read_text(text.encode())
    except InputError as error:
        return (str(error),)
    columns = {name: values.tobytes() for name, values in table.columns.items()}
    return columns, list(table.places), table.text, table.notes


@given(
    st.lists(
        st.lists(
            st.floats(allow_nan=False).map(repr) | st.text("0123.eE+-", max_size=5),
            min_size=1,
            max_size=3,
        ).map(",".join),
        max_size=6,
    ),
    st.booleans(),
)
@settings(max_examples=300)
def test_a_small_table_is_read_as_a_large_one_is(rows: list[str], ended: bool) -> None:
    text = "\n".join(["t [s],x [mm]", "0,1.5", *rows]) + "\n" * ended
    small = outcome(text)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("stribeck.data.readers.delimited._SMALL", -1)
        assert small == outcome(text)


def test_a_gap_as_long_as_allowed_is_filled_and_one_longer_is_not(tmp_path: Path) -> None:
    n = 600
    t = np.arange(n) * 0.01
    for length in (SHORT_GAP, SHORT_GAP + 1):
        x = np.sin(t)
        x[100 : 100 + length] = np.nan
        path = tmp_path / f"{length}.csv"
        pl.DataFrame({"t_s": t, "x_m": x}).write_csv(path)
        if length == SHORT_GAP:
            np.testing.assert_allclose(read(path).position, np.sin(t), atol=1e-3)
        else:
            with pytest.raises(InputError, match="line 102 to 107"):
                read(path)


@real
@pytest.mark.parametrize(
    ("file", "rows", "channel", "row", "value"),
    [
        ("openarm/collect_joint_1.csv", 3146, "position", 0, -0.06346989),
        ("openarm/collect_joint_1.csv", 3146, "force", 1, -0.06593323),
        ("openarm/collect_joint_1.csv", 3146, "command", 2, -0.06346702),
        ("openarm/collect_joint_3.csv", 3146, "velocity", 0, -0.00488472),
        ("openarm/identification_joint_2.csv", 10225, "acceleration", 2, -4.440892e-16),
        ("direct_drive/est_j1_05.csv", 2006, "velocity", 0, np.deg2rad(9.4471)),
        ("direct_drive/sig0_j1_6_exp1.csv", 668, "force", 1, 0.4226),
        ("pneumatic/Kidney_1bar.csv", 5833, "position", 0, 4e-6),
        ("pneumatic/Kidney_1bar.csv", 5833, "force", 1, 50.269),
    ],
)
def test_real_csv(file: str, rows: int, channel: str, row: int, value: float) -> None:
    r = read(REAL / file)
    assert len(r) == rows
    assert getattr(r, channel)[row] == pytest.approx(value, rel=1e-12)


@real
def test_the_other_columns_of_a_real_log_are_kept() -> None:
    r = read(REAL / "pneumatic/Kidney_1bar.csv")
    assert list(r.extra) == ["laser_V", "pressure_V", "force_V"]
    assert r.t[1] == pytest.approx(0.01)
    assert r.pressure is not None
    assert r.pressure[0] == pytest.approx(97200.0)
    assert read(REAL / "openarm/collect_joint_1.csv").rotary


@real
@pytest.mark.parametrize("file", ["DATA_EMPS", "DATA_EMPS_PULSES"])
def test_emps(file: str) -> None:
    path = REAL / "emps" / f"{file}.mat"
    raw = {k: v.ravel() for k, v in scipy.io.loadmat(path).items() if not k.startswith("__")}
    r = read(path, columns=EMPS)
    np.testing.assert_array_equal(r.position, raw["qm"])
    np.testing.assert_array_equal(r.command, raw["qg"])
    np.testing.assert_array_equal(r.voltage, raw["vir"])
    assert r.force is not None
    np.testing.assert_allclose(r.force, raw["gtau"] * raw["vir"], rtol=1e-12)
    assert r.extra["kv"][0] == 243.45
    np.testing.assert_allclose(r.extra["gtau"], 35.15065, rtol=1e-6)
    assert not r.rotary
    if "pulses_N" in raw:
        assert set(r.extra["pulses_N"]) == {0.0, 5.0}


@real
def test_a_log_without_units_is_read_through_a_mapping() -> None:
    path = REAL / "dfki_pendulum/sysid_measured.csv"
    with pytest.raises(InputError, match=r'without a unit: say it, as in units={"time": "s", "pos'):
        read(path)
    mapped = {"time": "time [s]", "position": "position [rad]", "velocity": "velocity [rad/s]",
              "force": "torque [Nm]"}  # fmt: skip
    r = read(path, columns=mapped)
    assert r.force is not None
    assert r.force[1] == pytest.approx(-1.318681318681313996e-02, rel=1e-12)
    assert r.rotary


@pytest.mark.parametrize("packed", [False, True])
@pytest.mark.parametrize("kind", ["f8", "f4", "i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8", "?"])
def test_matlab_numbers_of_every_kind(packed: bool, kind: str, tmp_path: Path) -> None:
    path = tmp_path / "log.mat"
    values = (np.arange(N) % 100).astype(kind)
    arrays = {"t_s": T, "x_mm": X, "a": values, "b": values.reshape(8, 5), "none": np.zeros((0, 3))}
    scipy.io.savemat(path, arrays, do_compression=packed)
    r = read(path)
    np.testing.assert_array_equal(r.extra["a"], values)
    assert any("b_1" in note for note in r.notes)


def test_matlab_from_a_big_endian_machine() -> None:
    def element(kind: int, data: bytes) -> bytes:
        return struct.pack(">II", kind, len(data)) + data + bytes(-len(data) % 8)

    def matrix(name: str, values: np.ndarray) -> bytes:
        return element(
            14,
            element(6, struct.pack(">II", 6, 0))
            + element(5, struct.pack(">ii", len(values), 1))
            + element(1, name.encode())
            + element(9, values.astype(">f8").tobytes()),
        )

    head = b"MATLAB 5.0 MAT-file".ljust(124) + b"\x01\x00MI"
    columns = read_matlab(head + matrix("t_s", T) + matrix("x_mm", X)).columns
    np.testing.assert_array_equal(columns["t_s"], T)
    np.testing.assert_array_equal(columns["x_mm"], X)


def test_a_rigs_log_may_lack_channels_that_it_does_not_need(tmp_path: Path) -> None:
    log = tmp_path / "run.csv"
    log.write_text("clock,angle\n" + "".join(f"{k / 100},{k * k}\n" for k in range(20)))
    mapping = {"time": "clock [s]", "position": "angle [rad]", "velocity": "speed [rad/s]"}
    assert read(log, columns=mapping, lenient=True).velocity is None
    with pytest.raises(InputError, match="the mapping says velocity"):
        read(log, columns=mapping)
    with pytest.raises(InputError, match="the mapping says position"):
        read(log, columns={**mapping, "position": "place [rad]"}, lenient=True)
