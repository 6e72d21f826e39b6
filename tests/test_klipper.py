"""The log of Klipper's motan data logger, its messages made and read step by step here."""

from __future__ import annotations

import gzip
import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from command import Completed, caller
from stribeck import InputError, read
from stribeck.data.readers.log_contents import contents
from stribeck.data.readers.log_file import ReadOptions
from stribeck.data.readers.registry import opened

#: Ticks a second of the stepper's board, and mm a step.
FREQUENCY, DISTANCE = 16e6, 0.0125
#: Blocks of queued steps: (interval, count, add) in ticks; a negative count steps back.
BLOCKS = [[[90000, 40, -700], [62000, 200, 0]], [[62000, 40, 650], [90000, -30, -500]]]
ACCELERATIONS = [[1.0 + 0.000625 * k, 100.0 * np.sin(0.1 * k), -9806.65, 3.0] for k in range(400)]
LOADS = [[1.0 + 0.0125 * k, 50.0 + k, 1000 * k, 12] for k in range(80)]
ANGLES = [[1.0 + 0.001 * k, 650 * k] for k in range(300)]


def steps() -> Iterator[tuple[dict[str, Any], list[tuple[float, float]]]]:
    """Each block as Klipper sends it, and time and position after each of its steps."""
    clock, position = 20_000_000, 5.0
    for block in BLOCKS:
        start, ticks, after = position, [], []
        for interval, count, add in block:
            for _ in range(abs(count)):
                clock += interval
                interval += add  # noqa: PLW2901 - as the board counts
                position += DISTANCE if count > 0 else -DISTANCE
                ticks.append(clock)
                after.append(position)
        message = {
            "data": block,
            "start_position": start,
            "start_mcu_position": round(start / DISTANCE),
            "step_distance": DISTANCE,
            "first_clock": ticks[0],
            "first_step_time": ticks[0] / FREQUENCY,
            "last_clock": ticks[-1],
            "last_step_time": ticks[-1] / FREQUENCY,
        }
        yield message, [(t / FREQUENCY, x) for t, x in zip(ticks, after, strict=True)]


def messages(*, loaded: bool = False) -> list[dict[str, Any]]:
    """A session: answers to subscriptions, then what they send, mixed as it comes."""
    heads = {
        "stepq:stepper_x": ["interval", "count", "add"],
        "trapq:toolhead": ["time", "duration", "start_velocity", "acceleration",
                           "start_position", "direction"],
        "adxl345:hotend": ["time", "x_acceleration", "y_acceleration", "z_acceleration"],
        "angle:motor": ["time", "angle"],
    }  # fmt: skip
    sent: dict[str, list[Any]] = {
        "adxl345:hotend": [{"data": ACCELERATIONS[:150]}, {"data": ACCELERATIONS[150:]}],
        "trapq:toolhead": [{"data": [[1.2, 0.5, 0.0, 100.0, [5.0, 0.0, 0.0], [1.0, 0.0, 0.0]]]}],
        "angle:motor": [{"data": ANGLES, "position_offset": 3.1}],
        "stepq:stepper_x": [message for message, _ in steps()],
    }
    if loaded:
        heads["load_cell:bed"] = ["time", "force (g)", "counts", "tare_counts"]
        sent["load_cell:bed"] = [{"data": LOADS}]
    session: list[dict[str, Any]] = [{"id": "info", "result": {"state": "ready"}}]
    session += [{"id": name, "result": {"header": head}} for name, head in heads.items()]
    for k in range(10):
        status: dict[str, Any] = {"toolhead": {"estimated_print_time": 1.0 + 0.25 * k}}
        if k % 3 == 0:
            driver = {"run_current": 0.7 + 0.01 * k, "drv_status": {"sg_result": 100 + k}}
            status["tmc2209 stepper_x"] = driver
        session.append({"q": "status", "params": {"status": status, "eventtime": 3000.0 + k}})
    session += [{"q": name, "params": params} for name, each in sent.items() for params in each]
    return session


def logged(path: Path, session: list[dict[str, Any]], *, cut: int = 0) -> Path:
    data = b"".join(json.dumps(m, separators=(",", ":")).encode() + b"\x03" for m in session)
    path.write_bytes(gzip.compress(data[: len(data) - cut]))
    return path


@pytest.fixture
def log(tmp_path: Path) -> Path:
    return logged(tmp_path / "motan.json.gz", messages())


def test_steps_are_where_and_when_the_board_made_them(log: Path) -> None:
    recording = read(log, columns={"position": "stepper_x position"})
    true = np.array([pair for _, pairs in steps() for pair in pairs])
    np.testing.assert_allclose(recording.t, true[:, 0] - true[0, 0], atol=1e-9)
    np.testing.assert_allclose(recording.position, 1e-3 * true[:, 1], atol=1e-12)


def test_sensors_and_the_drivers_state_have_clocks_of_their_own(log: Path) -> None:
    reader, file = opened(log, ReadOptions())
    assert reader.name == "klipper"
    channels = {c.name: c for c in file.channels}
    assert {n: c.unit for n, c in channels.items() if c.unit} == {
        "stepper_x position": "mm",
        "hotend accel_x": "mm/s**2",
        "hotend accel_y": "mm/s**2",
        "hotend accel_z": "mm/s**2",
        "motor angle": "rev",
        "tmc2209 stepper_x run_current": "A",
    }
    tables = {name: t for t in file.tables() for name in t.columns}
    rows = np.array(ACCELERATIONS)
    hotend = tables["hotend accel_x"]
    np.testing.assert_allclose(hotend.columns["hotend accel_x"], rows[:, 1])
    assert hotend.t is not None
    np.testing.assert_allclose(hotend.t, rows[:, 0])
    angle = tables["motor angle"].columns["motor angle"]
    np.testing.assert_allclose(angle, np.array(ANGLES)[:, 1] / 65536)
    guard = tables["tmc2209 stepper_x drv_status sg_result"]
    assert guard.t is not None
    assert guard.t.tolist() == [1.0, 1.75, 2.5, 3.25]
    assert guard.columns["tmc2209 stepper_x drv_status sg_result"].tolist() == [100, 103, 106, 109]


def test_contents_say_that_a_force_is_missing(
    log: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    run: Callable[..., Completed] = caller(monkeypatch, capsys)
    told = run("contents", str(log), "--json")
    answer = json.loads(told.out)
    assert answer["format"] == "klipper"
    assert any("no channel is a force" in problem for problem in answer["problems"])
    assert any("moves of the planner were left out" in problem for problem in answer["problems"])


def test_a_load_cell_is_a_force(tmp_path: Path) -> None:
    log = logged(tmp_path / "motan.json.gz", messages(loaded=True))
    assert not any("no channel is a force" in problem for problem in contents(log).problems)
    columns = {"position": "stepper_x position", "force": "bed force"}
    recording = read(log, columns=columns)
    assert recording.force is not None
    first = next(t for _, pairs in steps() for t, _ in pairs)
    grams = np.interp(recording.t + first, np.array(LOADS)[:, 0], np.array(LOADS)[:, 1])
    np.testing.assert_allclose(recording.force, 9.80665e-3 * grams, rtol=1e-9)


def test_a_log_that_was_cut_off_tells_what_it_lost(tmp_path: Path) -> None:
    log = logged(tmp_path / "motan.json.gz", messages(), cut=40)
    found = contents(log)
    assert "1 messages cannot be read and were left out" in found.problems
    (channel,) = (c for c in found.channels if c.name == "stepper_x position")
    assert channel.count == 240  # the second block of steps was not whole


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"data": [[1, 2]]}, "a message of its steps is not whole"),
        ({"data": [[1, 1e12, 0]]}, "no numbers of steps"),
        ({"first_clock": 10**400}, "a message of its steps is not whole"),
        ({"step_distance": None}, "a message of its steps is not whole"),
        ({"data": [[1, 2_000_000_000, 0]]}, "need .* of memory"),
    ],
)
def test_damaged_steps_are_refused_in_a_line(
    change: dict[str, Any], words: str, tmp_path: Path
) -> None:
    session = messages()
    session[-1]["params"] |= change
    with pytest.raises(InputError, match=words):
        read(logged(tmp_path / "motan.json.gz", session))


def test_sensors_of_another_session_are_named_with_their_times(tmp_path: Path) -> None:
    """A load cell that was logged after the motor moved: no rule joins the two."""
    path = tmp_path / "log.json.gz"
    session = json.loads(json.dumps(messages(loaded=True)))
    for message in session:
        if message.get("q") == "load_cell:bed":
            for row in message["params"]["data"]:
                row[0] += 100.0
    path.write_bytes(gzip.compress(b"".join(json.dumps(m).encode() + b"\x03" for m in session)))
    with pytest.raises(InputError) as refused:
        read(path, columns={"position": "stepper_x position"})
    words = str(refused.value)
    assert "stepper_x position from 1.25562 to 2.55772 s; bed force from 101 to 101.987 s" in words
    assert "log them in one session" in words
