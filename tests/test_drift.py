"""Drift of a fleet: what is compared, what is told, and the gate for a cron job."""

import datetime as dt
import json
from pathlib import Path
from typing import Any

import polars as pl
import pytest

from command import caller
from drift_twins import Twin
from stribeck import InputError, drift
from stribeck.fleet.drift_report import change_text, summary
from stribeck.fleet.drift_verdict import DriftChange
from stribeck.fleet.fleet_table import FILE, FOLDER
from stribeck.fleet.table_columns import SCHEMA, VERSION

START = dt.datetime(2026, 1, 5)  # noqa: DTZ001 - as the table has it
ROW: dict[str, Any] = {
    "machine": "M1", "axis": "x", "parameter": "F_C", "unit": "N", "verdict": "identified",
    "status": "done", "law": "coulomb-viscous", "rig": "forced", "load": None, "schema": VERSION,
    "speed_low": 0.02, "speed_median": 0.05, "speed_high": 0.1, "travel": 0.1,
    "setup_hash": "a", "version": "1.0", "temperature": None,
}  # fmt: skip


def rows(
    twin: Twin, count: int, seed: int, half: float = 0.02, **said: Any
) -> list[dict[str, Any]]:
    """Rows of a fleet's table for a twin whose intervals reach so far to either side."""
    return [
        {
            **ROW,
            "when": START + dt.timedelta(days=day, minutes=k),
            "log": f"log {k}",
            "value": value,
            "low": value - half,
            "high": value + half,
            **said,
        }
        for k, (day, value, _) in enumerate(twin.estimates(count, seed))
    ]


def table(entries: list[dict[str, Any]]) -> pl.DataFrame:
    return pl.DataFrame(entries, schema=SCHEMA)


STEP = Twin(log=0.04, step=0.2, at=30)
STEADY = Twin(log=0.04)


def test_a_step_is_an_alarm_with_its_size_and_what_else_changed() -> None:
    entries = rows(STEP, 40, 1)
    for entry in entries[30:]:
        entry |= {"version": "1.1", "setup_hash": "b"}
    (found,) = drift(table(entries)).parameters
    (alarm,) = found.alarms
    assert found.verdict == "alarm"
    assert START + dt.timedelta(days=30) <= alarm.when < START + dt.timedelta(days=33)
    step = alarm.changes[0]
    assert (step.shape, step.since) == ("step", entries[30]["when"])
    assert step.low < 0.2 < step.high
    assert alarm.also == (
        "the rig's constants, columns or drive", "the version of stribeck",
    )  # fmt: skip


def test_a_change_is_told_with_its_unit_and_beside_what_was_before() -> None:
    step = DriftChange("step", START, size=4.36, low=3.05, high=5.674, level=29.6)
    assert change_text("N", step) == "+4.36 N [3.05, 5.67] (+14.7 %)"
    wear = DriftChange("ramp", START, size=-0.5, low=-0.6, high=-0.4, level=0.1)
    assert change_text("N s/m", wear) == "-0.5 N s/m a week [-0.6, -0.4]"


def test_parameters_come_in_the_order_of_the_table() -> None:
    axes, names = ("x", "y", "z"), ("F_C", "F_V", "M", "offset")
    entries = [
        {**row, "axis": axis, "parameter": name}
        for row in rows(STEADY, 16, 1)
        for axis in axes
        for name in names
    ]
    told = [(p.axis, p.parameter) for p in drift(table(entries)).parameters]
    assert told == [(axis, name) for axis in axes for name in names]


def test_values_that_merely_scatter_raise_no_alarm() -> None:
    entries = rows(Twin(day=0.087, log=0.057, logs=2), 60, 2)
    result = drift(table(entries))
    assert [p.verdict for p in result.parameters] == ["steady"]
    assert result.up == ()
    assert "57 of 60 logs compared, all of like motion" in result.parameters[0].why
    assert "at most 1 a year on 1 axis." in summary(result)


def test_only_identified_rows_are_compared() -> None:
    entries = rows(STEP, 40, 1, verdict="weak", verdict_reason="wide")
    (found,) = drift(table(entries)).parameters
    assert (found.verdict, found.why) == ("undecided", "no row can be compared: 40 weak (wide)")
    assert [p.verdict for p in drift(table(entries), weak=True).parameters] == ["alarm"]


def test_rows_of_other_motion_are_not_compared_with_each_other() -> None:
    slow = rows(STEADY, 20, 1)
    fast = rows(Twin(level=1.8, log=0.04), 20, 51, speed_high=0.3)
    for k, entry in enumerate(fast):
        entry["when"] = START + dt.timedelta(days=20 + k)
    (found,) = drift(table([*slow, *fast])).parameters
    assert found.verdict == "steady"
    assert "2 kinds of motion, law, rig or load, each with its own level" in found.why
    (mixed,) = drift(table([*slow, *fast]), like=4.0).parameters
    assert mixed.verdict == "alarm"


def test_a_known_temperature_is_taken_out() -> None:
    twin = Twin(log=0.03, slope=-0.03, season=8.0)
    entries = rows(twin, 200, 6)
    assert drift(table(entries)).up
    for entry, (_, _, warmth) in zip(entries, twin.estimates(200, 6), strict=True):
        entry["temperature"] = warmth
    (found,) = drift(table(entries)).parameters
    assert found.temperature
    assert not found.alarms


def test_wear_that_goes_with_temperature_is_not_called_steady_without_a_word() -> None:
    entries = rows(Twin(log=0.03, wear=0.005), 80, 3)
    for k, entry in enumerate(entries):
        entry["temperature"] = 20.0 + 0.2 * k
    (found,) = drift(table(entries)).parameters
    assert not found.alarms  # nothing tells it from what temperature does
    assert "100% of the temperature's variance goes with time or with one step" in found.why
    assert "taken out, 0.026 N/°C [0.024, 0.028]" in found.why  # 0.005 a log by 0.2 °C a log
    for entry in entries[3:5]:
        entry["temperature"] = None
    (unknown,) = drift(table(entries)).parameters
    assert "temperature not taken out, as 2 of 80 logs have none" in unknown.why
    assert unknown.alarms


def test_where_all_goes_into_levels_and_temperature_nothing_is_steady() -> None:
    entries = rows(STEADY, 4, 1)
    for k, entry in enumerate(entries):
        entry["temperature"] = 20.0 + k * k
    (found,) = drift(table(entries)).parameters
    assert found.verdict == "undecided"
    assert found.why.endswith("none is left to be compared")


def test_a_log_that_lies_apart_waits_for_another() -> None:
    entries = rows(STEADY, 30, 1)
    entries[-1] |= {"value": 1.8, "low": 1.78, "high": 1.82}
    (found,) = drift(table(entries)).parameters
    assert found.verdict == "steady"
    assert "above what was expected, which another one has to confirm" in found.why


def test_rows_that_nothing_is_like_are_told() -> None:
    entries = rows(STEADY, 3, 1)
    (few,) = drift(table(entries)).parameters
    assert few.why == (
        "3 of 3 rows are identified, at most 3 of them of like motion, law, rig and load: "
        "from 4 on they are compared"
    )
    undated = [{**entry, "when": None} for entry in rows(STEADY, 9, 1)]
    (without,) = drift(table(undated)).parameters
    assert without.why.endswith("none with a time")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [({"false_alarms": 0.0}, "^false_alarms: give a number above 0"),
     ({"like": 0.5}, "^like: give a factor of at least 1")],
)  # fmt: skip
def test_numbers_that_make_no_sense_are_refused(arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        drift(table(rows(STEADY, 5, 1)), **arguments)


def test_the_command_is_a_gate(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    run = caller(monkeypatch, capsys)
    place = tmp_path / FOLDER / "machine=M1" / "month=2026-01"
    place.mkdir(parents=True)
    table(rows(STEP, 40, 1)).drop("machine", "month").write_parquet(place / FILE)
    shown = run("drift", str(tmp_path))
    assert shown.status == 1
    assert "1 alarm up." in shown.out
    assert "M1 x F_C: alarm. 36 of 40 logs compared" in shown.out
    page = (tmp_path / "drift.html").read_text(encoding="utf-8")
    assert page.count('class="alarm"') == 1
    assert page.count('class="dot"') == 40
    document = json.loads(run("drift", str(tmp_path), "--json").out)
    assert document["schema"] == "stribeck-drift/1"
    assert document["alarms_up"] == len(document["parameters"][0]["alarms"]) == 1
    later = run("drift", str(tmp_path), "--since", "2026-03-01")
    assert (later.status, "0 alarms up" in later.out) == (0, True)
    refused = run("drift", str(tmp_path / "nothing"))
    assert (refused.status, refused.out) == (2, "")
    assert "there is no table" in refused.err
