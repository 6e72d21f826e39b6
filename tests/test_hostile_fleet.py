"""Manifests, stores and tables that somebody has spoilt: one line, and nothing changed."""

import datetime as dt
import errno
import os
import shutil
import sqlite3
from collections.abc import Callable
from pathlib import Path
from typing import Any

import polars as pl
import pytest

from command import caller
from fleet_logs import force_log
from stribeck import InputError, fleet, read
from stribeck.data.readers.log_map import LogMap, save_map, saved_maps
from stribeck.fleet.axis_job import axis_jobs
from stribeck.fleet.axis_run import axis_record
from stribeck.fleet.drift import drift
from stribeck.fleet.fleet_page import write_drift_page
from stribeck.fleet.fleet_table import FILE, FOLDER, read_table
from stribeck.fleet.manifest import read_manifest
from stribeck.fleet.parquet_file import parquet_frame

LOGS = 5
FIRST = dt.datetime(2026, 3, 1)  # noqa: DTZ001 - as a table has it


@pytest.fixture(scope="module")
def rows(tmp_path_factory: pytest.TempPathFactory) -> list[dict[str, Any]]:
    """An axis of five days."""
    folder = tmp_path_factory.mktemp("logs")
    for k in range(LOGS):
        force_log(folder / f"x{k}.csv", k, seconds=3.0, rate=100.0)
    return [
        {
            "axis": "x", "log": str(folder / f"x{k}.csv"), "rig": "forced",
            "law": "coulomb-viscous", "when": FIRST + dt.timedelta(days=k),
        }
        for k in range(LOGS)
    ]  # fmt: skip


@pytest.fixture(scope="module")
def whole(rows: list[dict[str, Any]], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The fleet's folder; tests spoil copies."""
    folder = tmp_path_factory.mktemp("whole") / "plant"
    fleet(rows, folder)
    return folder


BAD_ROWS: dict[str, tuple[dict[str, Any], str]] = {
    "a count of days": ({"when": 46083}, "column when: 46083 is no time"),
    "seconds since 1970": ({"when": 1.77e9}, "column when: 1770000000.0 is no time"),
    "before the year 1": ({"when": "0001-01-01T00:00+14:00"}, "column when: '0001-01-01T00:00+14"),
    "after 9999": ({"when": "9999-12-31T23:59-14:00"}, "column when: '9999-12-31T23:59-14"),
    "true for 1 °C": ({"temperature": True}, "column temperature: True is not a number"),
    "nan °C": ({"temperature": float("nan")}, "column temperature: nan is not a number"),
    "turned text": ({"axis": "a\u202eb"}, "column axis: 'a\\u202eb' has a character that cannot"),
    "a line": ({"machine": "a\u2028b"}, "column machine: 'a\\u2028b' has a character that cannot"),
    "240 bytes": ({"machine": "é" * 45}, "is too long for the name of a folder: shorten it"),
    "two stars": ({"log": "a/**b/*.csv"}, "axis x: log: 'a/**b/*.csv' is no pattern of paths"),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD_ROWS)
def test_a_row_that_cannot_be_kept_is_refused_before_anything_runs(
    name: str, rows: list[dict[str, Any]], tmp_path: Path
) -> None:
    cells, message = BAD_ROWS[name]
    with pytest.raises(InputError) as refused:
        fleet([{**rows[0], **cells}], tmp_path / "out")
    assert message in str(refused.value)
    assert not (tmp_path / "out").exists()


BAD_TOML = {
    '[[pattern]]\nlog = ""': "pattern 1: log: '' is no pattern of paths",
    '[[pattern]]\nlog = "/"': "pattern 1: log: '/' is no pattern of paths",
    '[[pattern]]\nlog = "a/**b/{axis}.csv"': "pattern 1: log: '**b/*.csv' is no pattern of paths",
    '[[pattern]]\nlog = "{axis}_{when}.log"\nwhen_format = "%Y%Y"': "'2026' is not a time written",
    "axis = 3": "axis must be a table: [[axis]] begins one",
    '[[axis]]\naxis = "x"\nlog = "x"\nrig = "forced"\ndrive = "no_toml.txt"': "txt: not TOML: ",
    '[[axis]]\naxis = "x"\nlog = "x"\nrig = "forced"\ndrive = "drive.toml"': "drive must be a tab",
}


@pytest.mark.parametrize("text", BAD_TOML)
def test_a_toml_manifest_that_cannot_be_used_is_refused(text: str, tmp_path: Path) -> None:
    (tmp_path / "x_2026.log").touch()
    (tmp_path / "no_toml.txt").write_text("a = = 3", encoding="utf-8")
    (tmp_path / "drive.toml").write_text("drive = 3", encoding="utf-8")
    file = tmp_path / "fleet.toml"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as refused:
        read_manifest(file)
    assert str(refused.value).startswith(f"{file}: ")
    assert BAD_TOML[text] in str(refused.value)


def test_fields_of_a_pattern_may_stand_beside_each_other(tmp_path: Path) -> None:
    (tmp_path / "x2026-03-01.csv").touch()
    (tmp_path / "fleet.toml").write_text(
        '[[pattern]]\nrig = "forced"\nlog = "{axis}{when}.csv"\n', encoding="utf-8"
    )
    with pytest.raises(InputError, match=r"pattern 1, file 1: column when: '1' is no time"):
        read_manifest(tmp_path / "fleet.toml")


def test_cells_are_what_they_are_without_the_blanks_around_them(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text(
        "axis, log, rig, load, law\nx, x.csv , forced, 2,\ny, y.csv, forced, ,\n", encoding="utf-8"
    )
    first, second = read_manifest(tmp_path / "a.csv").rows
    assert (first.log, first.rig, first.load, first.law) == ("x.csv", "forced", "2", None)
    assert second.load is None
    (numbers,) = read_manifest([{"axis": 7.0, "log": "x", "rig": "forced", "load": 1.5}]).rows
    assert (numbers.axis, numbers.load) == ("7", "1.5")


def test_text_of_another_encoding_says_how_to_save_it(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("axis,log,rig\nx,x.csv,forced\n", encoding="utf-16")
    with pytest.raises(InputError, match="is not UTF-8 text: save it as CSV UTF-8"):
        read_manifest(tmp_path / "a.csv")


SPOILT_STORES = {
    "UPDATE records SET text = (SELECT text FROM records LIMIT 1)": "the outcome of another job",
    "UPDATE records SET status = 'refused'": "a record says done, its row refused",
    "UPDATE records SET text = json_set(text, '$.status', 'well')": "no record has status 'well'",
    "UPDATE records SET text = json_set(text, '$.card', null)": "no record has status 'done'",
    "UPDATE records SET text = json_set(text, '$.card', 'x')": "the records of - from x 2026-03-01",
    "UPDATE records SET text = json_set(text, '$.card.parameters.F_C.value', 'x')": "are damaged",
    "UPDATE records SET text = json_set(text, '$.card.parameters.F_C.value', null)": "is missing",
    "UPDATE records SET text = json_set(text, '$.card.parameters', json('{}'))": "without param",
    "UPDATE records SET text = json_set(text, '$.motion', json('{}'))": "are damaged ('low')",
    "UPDATE jobs SET text = '{}'": "a job cannot be read",
    "UPDATE jobs SET text = '{}'; DELETE FROM records": "a job cannot be read",
    "UPDATE jobs SET text = json_set(text, '$.logs[0][0]', 'y')": "is not what it was",
    "UPDATE jobs SET text = json_set(text, '$.row.axis', 'y'); DELETE FROM records": "is not what",
}


@pytest.mark.parametrize("statements", SPOILT_STORES)
def test_a_store_that_was_changed_by_hand_is_told_and_leaves_the_table(
    statements: str, rows: list[dict[str, Any]], whole: Path, tmp_path: Path
) -> None:
    plant = tmp_path / "plant"
    shutil.copytree(whole, plant)
    db = sqlite3.connect(plant / "store.sqlite")
    db.executescript(statements)
    db.close()
    with pytest.raises(InputError) as refused:
        fleet(rows, plant)
    assert str(refused.value).startswith(str(plant))
    assert SPOILT_STORES[statements] in str(refused.value)
    assert read_table(plant).equals(read_table(whole))


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes with names here")
def test_a_pipe_in_the_place_of_a_store_is_not_waited_for(
    rows: list[dict[str, Any]], tmp_path: Path
) -> None:
    os.mkfifo(tmp_path / "store.sqlite")
    with pytest.raises(InputError, match=r"store\.sqlite: is no regular file"):
        fleet(rows, tmp_path)


def _with(name: str, value: Any) -> Callable[[pl.DataFrame], pl.DataFrame]:
    """A frame whose second row has a cell changed."""
    here = pl.int_range(pl.len()) == 1
    return lambda frame: frame.with_columns(
        pl.when(here).then(pl.lit(value)).otherwise(pl.col(name)).alias(name)
    )


SPOILT_TABLES: dict[str, tuple[Callable[[pl.DataFrame], pl.DataFrame], str]] = {
    "text": (lambda f: f.cast({"value": pl.String}), "column value is String: it has to be Float"),
    "dates": (lambda f: f.cast({"when": pl.Date}), "column when is Date: it has to be Datetime"),
    "zone": (lambda f: f.cast({"when": pl.Datetime("us", "UTC")}), "column when is Datetime"),
    "no unit": (lambda f: f.drop("unit"), "has no column unit"),
    "nan": (_with("value", float("nan")), "row 2: value is no number to compare"),
    "infinite": (_with("high", float("inf")), "row 2: high is no number to compare"),
    "huge": (_with("low", -1e300), "row 2: low is no number to compare"),
    "swapped": (lambda f: f.rename({"low": "high", "high": "low"}), "row 1: low is above high"),
    "null": (_with("value", None), "row 2: value is missing"),
    "nameless": (_with("axis", None), "row 2: axis is missing"),
    "newer": (_with("schema", "stribeck-fleet/2"), "is of version stribeck-fleet/2: this program"),
    "versionless": (lambda f: f.drop("schema"), "has no column schema: is it the table of a fleet"),
}  # fmt: skip


@pytest.mark.parametrize("name", SPOILT_TABLES)
def test_a_table_that_was_changed_by_hand_is_told_with_file_and_row(
    name: str, whole: Path, tmp_path: Path
) -> None:
    change, message = SPOILT_TABLES[name]
    shutil.copytree(whole / FOLDER, tmp_path / FOLDER)
    (file,) = tmp_path.rglob(FILE)
    change(pl.read_parquet(file, hive_partitioning=False)).write_parquet(file)
    with pytest.raises(InputError) as refused:
        drift(tmp_path)
    assert str(refused.value).startswith(f"{file}: {message}")
    with pytest.raises(InputError) as refused:
        drift(change(read_table(whole)))
    assert message in str(refused.value)


def test_what_another_program_has_written_again_is_read(whole: Path, tmp_path: Path) -> None:
    shutil.copytree(whole / FOLDER, tmp_path / FOLDER)
    (file,) = tmp_path.rglob(FILE)
    frame = pl.read_parquet(file, hive_partitioning=False)
    other = frame.cast({"when": pl.Datetime("ns"), "verdict": pl.Categorical, "joint": pl.Null})
    other.with_columns(note=pl.lit("seen")).write_parquet(file)
    assert read_table(tmp_path).equals(read_table(whole))


@pytest.mark.parametrize("text", [b"", b"axis,when\nx,1\n"])
def test_a_partition_that_is_no_table_is_not_passed_over(
    text: bytes, whole: Path, tmp_path: Path
) -> None:
    shutil.copytree(whole / FOLDER, tmp_path / FOLDER)
    other = tmp_path / FOLDER / "machine=other" / "month=2026-01" / FILE
    other.parent.mkdir(parents=True)
    other.write_bytes(text)
    with pytest.raises(InputError) as refused:
        drift(tmp_path)
    assert str(refused.value).startswith(f"{other}: cannot be read (")


@pytest.mark.parametrize("folder", ["run=7", "a[1]", "a*", "a{b}", "a?"])
def test_any_folder_may_hold_a_fleet(folder: str, whole: Path, tmp_path: Path) -> None:
    shutil.copytree(whole, tmp_path / folder / "plant")
    shutil.copytree(whole, tmp_path / "ab1" / "plant")  # which the others would match as patterns
    assert read_table(tmp_path / folder / "plant").equals(read_table(whole))


def test_a_machine_is_called_as_its_manifest_calls_it(
    rows: list[dict[str, Any]], tmp_path: Path
) -> None:
    names = ["__HIVE_DEFAULT_PARTITION__", "..", "a/b", "%2F", "a=b", "null", "<b>", "é*?"]
    fleet([{**rows[0], "machine": name} for name in names], tmp_path)
    assert read_table(tmp_path)["machine"].unique().sort().to_list() == sorted(names)
    assert len(list((tmp_path / FOLDER).iterdir())) == len(names)
    page = (tmp_path / "index.html").read_text(encoding="utf-8")
    assert ">&lt;b&gt;</th>" in page
    assert "<b></th>" not in page


def test_since_with_a_zone_is_compared_as_utc(whole: Path) -> None:
    zone = dt.timezone(dt.timedelta(hours=2))
    result = drift(whole, since=dt.datetime(2026, 3, 3, 1, 30, tzinfo=zone))
    assert result.since == dt.datetime(2026, 3, 2, 23, 30)  # noqa: DTZ001 - as the table has it


def test_limits_that_nothing_would_leave_are_refused(whole: Path) -> None:
    with pytest.raises(InputError, match=r"false_alarms: no limits are so wide: give at least \d"):
        drift(whole, false_alarms=1e-9, weak=True)


@pytest.mark.parametrize("year", [1, 9999])
def test_a_picture_has_the_days_of_the_table(year: int, whole: Path, tmp_path: Path) -> None:
    times = (pl.col("when") - FIRST + dt.datetime(year, 12, 20)).alias("when")  # noqa: DTZ001
    page = write_drift_page(drift(read_table(whole).with_columns(times), weak=True), tmp_path)
    text = page.read_text(encoding="utf-8")
    assert f">{year:04}-12-20</text>" in text
    assert f">{year:04}-12-24</text>" in text


def test_a_map_laid_beside_a_refused_log_has_it_identified(
    rows: list[dict[str, Any]], tmp_path: Path
) -> None:
    text = Path(rows[0]["log"]).read_text(encoding="utf-8").partition("\n")[2]
    (tmp_path / "x.csv").write_text(f"t [s],a [m],b [m/s],c [N]\n{text}", encoding="utf-8")
    row = {"axis": "x", "log": str(tmp_path / "x.csv"), "rig": "forced", "law": "coulomb-viscous"}
    assert fleet([row], tmp_path / "out").refused == 1
    columns = {"position": "a [m]", "velocity": "b [m/s]", "force": "c [N]"}
    read(tmp_path / "x.csv", columns=columns, keep_map=True)
    assert fleet([row], tmp_path / "out").done == 1
    assert [j.maps for j in axis_jobs(read_manifest(rows))] == [()] * LOGS


def test_what_is_no_longer_as_the_job_names_it_is_tried_again(
    rows: list[dict[str, Any]], tmp_path: Path
) -> None:
    log = tmp_path / "x.csv"
    log.write_text("being written", encoding="utf-8")
    (job,) = axis_jobs(read_manifest([{**rows[0], "log": str(log)}]))
    assert axis_record(job).status == "refused"
    log.write_text("being written, still", encoding="utf-8")
    record = axis_record(job)
    assert record.status == "failed"
    assert record.reason.endswith("(a log, its map or the rig has changed meanwhile)")


def test_a_log_is_tried_again_when_its_library_is_installed(
    rows: list[dict[str, Any]], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pl.read_csv(rows[0]["log"]).write_parquet(tmp_path / "x.parquet")
    row = {**rows[0], "log": str(tmp_path / "x.parquet")}
    with monkeypatch.context() as absent:
        absent.setattr("stribeck.data.readers.isolated.find_spec", lambda _: None)
        result = fleet([row], tmp_path / "out")
    assert result.failed == 1
    assert "pip install" in result.table()["reason"][0]
    assert fleet([row], tmp_path / "out").done == 1


def test_a_log_that_must_not_be_read_is_another_when_it_may(
    rows: list[dict[str, Any]], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("stribeck.fleet.axis_job.os.access", lambda *_: False)
    (job, *_) = axis_jobs(read_manifest(rows))
    assert job.logs == ((rows[0]["log"], None, None),)


@pytest.mark.parametrize("name", ["..", ".", "a/../../b", "x@home", "%2E%2E"])
def test_a_report_stays_in_the_folder_of_its_fleet(
    name: str, rows: list[dict[str, Any]], tmp_path: Path
) -> None:
    row = {k: v for k, v in rows[0].items() if k != "when"} | {"machine": name, "axis": name}
    page = fleet([row], tmp_path / "out").report([row], f"{name}/{name}")
    place = page.resolve().relative_to((tmp_path / "out" / "reports").resolve())
    assert len(place.parts) == 4  # machine, axis, time, page


def test_a_report_of_no_axis_is_refused_before_the_work(
    rows: list[dict[str, Any]],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    pl.DataFrame(rows).write_csv(tmp_path / "m.csv")
    run = caller(monkeypatch, capsys)
    shown = run("fleet", str(tmp_path / "m.csv"), "--out", str(tmp_path / "out"), "--report", "y")
    assert (shown.status, shown.out) == (2, "")
    assert shown.err == "stribeck: report y: the manifest has no such axis or time\n"
    assert not (tmp_path / "out").exists()


def test_a_map_that_the_disk_cannot_take_leaves_the_maps_that_there_are(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    save_map(tmp_path, ["a"], LogMap.of({"position": "a [m]"}))
    write = Path.write_text

    def full(file: Path, text: str, **words: Any) -> int:
        write(file, text[: len(text) // 2], **words)
        raise OSError(errno.ENOSPC, "No space left on device")

    with monkeypatch.context() as disk:
        disk.setattr(Path, "write_text", full)
        with pytest.raises(OSError, match="No space left"):
            save_map(tmp_path, ["b"], LogMap.of({"position": "b [m]"}))
    assert [heads for heads, _ in saved_maps(tmp_path)] == [["a"]]
    assert len(list(tmp_path.iterdir())) == 1  # nothing of the draft is left


def test_a_damaged_parquet_file_fails_without_a_word_of_its_library(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "rows.parquet"
    frame = pl.DataFrame({"axis": ["x"] * 48, "value": [float(k) for k in range(48)]})
    frame.write_parquet(file, compression="uncompressed", statistics=False)
    whole, panics = file.read_bytes(), 0
    for k in range(20, 120):  # heads of pages, most of them
        file.write_bytes(whole[:k] + b"\0" + whole[k + 1 :])
        try:
            parquet_frame(file)
        except pl.exceptions.PanicException:
            panics += 1
        except pl.exceptions.PolarsError:
            pass
    assert panics  # which polars tells by itself: a dozen lines each
    assert capfd.readouterr().err == ""
    os.write(2, b"others are heard\n")
    assert capfd.readouterr().err == "others are heard\n"


def test_a_fleet_from_a_damaged_manifest_is_refused_in_one_line(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "plant.parquet"
    frame = pl.DataFrame({"axis": ["x"] * 48, "log": ["x.csv"] * 48, "rig": ["forced"] * 48})
    frame.write_parquet(file, compression="uncompressed", statistics=False)
    whole = file.read_bytes()
    file.write_bytes(whole[:27] + b"\0" + whole[28:])
    run = caller(monkeypatch, capfd)
    status, _, err = run("fleet", str(file), "--out", str(tmp_path / "plant"))
    assert (status, len(err.splitlines())) == (2, 1)
