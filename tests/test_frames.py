"""Logs in memory: frames, dicts and arrays, held against the same log read from a file."""

from __future__ import annotations

import datetime as dt
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pint
import polars as pl
import pytest

import stribeck
from stribeck import InputError, Recording, check, identify, read, select

N = 400
T = np.arange(N) / 100.0
X = 20.0 * np.sin(2.0 * T)
F = np.cos(2.0 * T)
HEADS = {"t_s": T, "x_mm": X, "F_N": F}
BARE = {"t": T, "x": X, "F": F}
UNITS = {"t": "s", "x": "mm", "F": "N"}


@pytest.fixture(scope="module")
def from_file(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    path = tmp_path_factory.mktemp("log") / "log.parquet"
    pl.DataFrame(HEADS).write_parquet(path)
    return read(path)


def assert_same(recording: Recording, other: Recording) -> None:
    assert recording.channels().keys() == other.channels().keys()
    assert recording.rotary == other.rotary
    np.testing.assert_array_equal(recording.t, other.t)
    for name, values in recording.channels().items():
        np.testing.assert_array_equal(values, other.channels()[name])


def named_array() -> Any:
    return pd.DataFrame(HEADS).to_records(index=False)


def times(**index: Any) -> Any:
    stamps = pd.Timestamp("2026-03-29 01:59:59", **index) + pd.to_timedelta(T, unit="s")
    return pd.DataFrame({"x_mm": X, "F_N": F}, index=stamps)


@pytest.mark.parametrize(
    "frame",
    [
        HEADS,
        {name: values.tolist() for name, values in HEADS.items()},
        pl.DataFrame(HEADS),
        pd.DataFrame(HEADS),
        pd.DataFrame(HEADS).set_index("t_s"),
        pd.DataFrame(HEADS).convert_dtypes(),
        pd.DataFrame(HEADS).astype(object),
        pd.DataFrame(HEADS)[["F_N", "x_mm", "t_s"]],
        named_array(),
    ],
    ids=["dict", "lists", "polars", "pandas", "index", "nullable", "objects", "order",
         "array"],
)  # fmt: skip
def test_a_frame_is_the_log_that_its_file_is(frame: Any, from_file: Recording) -> None:
    assert_same(Recording.of(frame), from_file)


@pytest.mark.parametrize(
    "frame",
    [
        times(),
        times(tz="Europe/Berlin"),  # over the hour that summer time leaves out
        times().reset_index(names="time"),
        pl.DataFrame(HEADS | {"t_s": [dt.timedelta(seconds=t) for t in T]}),
        {**HEADS, "t_s": [dt.timedelta(seconds=t) for t in T]},
        {**HEADS, "t_s": [dt.datetime(2026, 1, 1) + dt.timedelta(seconds=t)  # noqa: DTZ001
                          for t in T]},
    ],
    ids=["index", "zone", "column", "duration", "timedeltas", "datetimes"],
)  # fmt: skip
def test_times_of_day_and_durations_are_seconds(frame: Any, from_file: Recording) -> None:
    recording = Recording.of(frame)
    np.testing.assert_allclose(recording.t, from_file.t, atol=1e-6)
    np.testing.assert_array_equal(recording.position, from_file.position)


@pytest.mark.parametrize("make", [dict, pl.DataFrame, pd.DataFrame])
def test_units_are_said_where_heads_do_not(
    make: Callable[[Any], Any], from_file: Recording
) -> None:
    assert_same(Recording.of(make(BARE), units=UNITS), from_file)
    with pytest.raises(InputError) as refusal:
        Recording.of(make(BARE))
    assert str(refusal.value) == (
        'columns t, x and F without a unit: say it, as in units={"t": "s", "x": "mm", "F": "N"} '
        "(rad, deg or rev where it turns)"
    )


def test_columns_are_said_where_names_do_not(from_file: Recording) -> None:
    odd = {"a": T, "b": X, "c": F}
    columns = {"time": "a", "position": "b", "force": "c"}
    assert_same(
        Recording.of(odd, units={"a": "s", "b": "mm", "c": "N"}, columns=columns), from_file
    )
    with pytest.raises(
        InputError, match=r'column b has no unit: say it, as in units=\{"b": "mm"\}'
    ):
        Recording.of(odd, units={"a": "s"}, columns=columns)


def test_quantities_say_their_units(from_file: Recording) -> None:
    u: Any = pint.UnitRegistry()
    assert_same(Recording.of({"t": T * u.s, "x": X * u.mm, "F": F * u.N}), from_file)
    turned = Recording.of({"t": T * u.s, "angle": X * u.deg})
    np.testing.assert_allclose(turned.position, np.radians(X), rtol=1e-12)
    assert turned.rotary


def test_notes_and_extra_columns_are_those_of_the_file(tmp_path: Path) -> None:
    """Empty cells, a repeated row, a column without a unit, text and a single number."""
    x: list[float | None] = [*X.tolist(), float(X[-1])]
    x[0], x[7] = None, None
    t = [*T.tolist(), float(T[-1])]
    frame = pl.DataFrame({"t_s": t, "x_mm": x, "torque": t, "note": ["a"] * (N + 1)})
    frame.write_csv(tmp_path / "log.csv")
    file = read(tmp_path / "log.csv")
    memory = Recording.of(frame, name="log.csv")
    assert memory.notes == file.notes
    assert len(memory.notes) == 5
    assert_same(memory, file)
    assert memory.label == file.label
    assert list(Recording.of({**HEADS, "gtau": 2.5}).extra) == ["gtau"]


@pytest.mark.parametrize(
    ("frame", "message"),
    [
        ({}, "the frame has no columns"),
        ({"t_s": T, "x_mm": X[:-1]}, "columns t_s and x_mm have 400 and 399 rows"),
        ({"t_s": T, "q_rad": np.zeros((N, 6))}, r"column q_rad has the shape \(400, 6\)"),
        ({"t_s": T, "x_mm": ["far"] * N}, "row 0, column x_mm: 'far' is not a number"),
        ({"t_s": T}, r'no position column among t_s.*columns=\{"position": "head \[mm\]"\}'),
        ({"t_s": [], "x_mm": []}, "the time column is empty"),
        ({1: T, "1": X}, "two columns are called 1"),
        (pd.DataFrame(np.column_stack([T, X]), columns=["x_mm", "x_mm"]), "two columns are called"),
        (pl.DataFrame(HEADS).lazy(), r"the frame is lazy: give frame.collect\(\)"),
        (np.column_stack([T, X]), r"an array of shape \(400, 2\) has no names"),
        (3.0, "no log, but of type float: give a path"),
        (HEADS | {"x_mm": np.where(T == 1, np.inf, X)}, "position is infinite"),
    ],
)
def test_a_frame_that_is_no_log_is_refused_in_a_line(frame: Any, message: str) -> None:
    with pytest.raises(InputError, match=message) as refusal:
        Recording.of(frame)
    assert "\n" not in str(refusal.value)


def test_units_that_belong_to_nothing_are_refused() -> None:
    for units, message in (
        ({"y": "mm"}, "units: no column 'y': there are t_s, x_mm, F_N"),
        ({"x_mm": 3}, "units: x_mm: the unit must be text"),
        ({"x_mm": "parsec-ish"}, "column x_mm"),
    ):
        with pytest.raises(InputError, match=message):
            Recording.of(HEADS, units=units)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="axis 3: "):
        Recording.of({"t_s": T}, name="axis 3")


def test_neither_polars_nor_pandas_is_imported_for_a_dict() -> None:
    code = (
        "import sys; from stribeck import Recording; "
        "Recording.of({'t_s': [i / 10 for i in range(20)], 'x_mm': list(range(20))}); "
        "print({'polars', 'pandas'} & set(sys.modules))"
    )
    told = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert told.stdout.strip() == "set()"


# --- every function takes every log -------------------------------------------------------------


def test_a_file_and_a_frame_are_identified_alike(tmp_path: Path, from_file: Recording) -> None:
    t = np.arange(2000) / 500.0
    v = 0.2 * np.sin(2 * np.pi * t)
    x = -0.2 / (2 * np.pi) * np.cos(2 * np.pi * t)
    force = 3.0 * np.sign(v) + 8.0 * v + 2.0 * 0.2 * 2 * np.pi * np.cos(2 * np.pi * t)
    frame = pl.DataFrame({"t": t, "x": x, "F": force})
    frame.write_csv(tmp_path / "log.csv")
    units = {"t": "s", "x": "m", "F": "N"}
    given = (
        frame,
        pd.DataFrame(frame.to_dict(as_series=False)),
        tmp_path / "log.csv",
        str(tmp_path / "log.csv"),
    )
    fits = [identify(log, units=units, rig="forced", law="coulomb-viscous") for log in given]
    first, *others = fits
    assert all((fit.p == first.p).all() for fit in others)
    F_C = first.p[0]
    low, high = first.intervals["F_C"]
    assert low < F_C < high
    assert pytest.approx(3.0, rel=0.02) == F_C
    assert check(frame, units=units).verdict == check(tmp_path / "log.csv", units=units).verdict
    both = identify([frame, tmp_path / "log.csv"], units=units, rig="forced", law="coulomb-viscous")
    assert [log.label for log in both.recordings] == ["log 1", "log.csv"]
    chosen = select(frame, units=units, rig="forced", laws=["coulomb-viscous"])
    assert chosen.law == "coulomb-viscous"
    with pytest.raises(InputError, match="units and columns are for files and frames"):
        identify(from_file, units=units, rig="forced")
    with pytest.raises(InputError, match="no recording was given"):
        identify([], rig="forced")


def test_a_rig_has_no_default() -> None:
    for function in (identify, select, stribeck.problem):
        with pytest.raises(TypeError, match="rig"):
            function(HEADS)  # type: ignore[call-arg]
