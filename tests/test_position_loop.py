"""A loop stated in a file: from a card without a controller to exported code, and refusals."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from command import Completed, caller
from foreign.compensated import Loop, Settings, simulate_loop
from foreign.driven import Loop as Driver
from foreign.driven import simulate
from foreign.friction import Curve
from stribeck import LAWS, RIGS, InputError
from stribeck.compensate.closed_loop import Reference, compensated
from stribeck.compensate.compensator import Compensator
from stribeck.rig.loop_file import StatedLoop, loop_file
from stribeck.rig.position_loop import PositionLoop

ROTARY = RIGS["forced-rotary"]
LOOP = """
kp = "40 N m/rad"
kd = "2 N m s/rad"
period = "1 ms"
limit = "50 N m"
[sensor]
resolution = "0.001 deg"
"""


@pytest.fixture
def stribeck(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Callable[..., Completed]:
    return caller(monkeypatch, capsys)


def stated(folder: Path, text: str, rig: Any = ROTARY) -> StatedLoop:
    file = folder / "loop.toml"
    file.write_text(text, encoding="utf-8")
    return loop_file(file, rig)


def test_a_loop_file_says_gains_period_limit_and_sensor_with_their_units(tmp_path: Path) -> None:
    loop = stated(tmp_path, LOOP)
    assert loop.controller == PositionLoop(40.0, 2.0, 1e-3, limit=50.0)
    assert loop.resolution == pytest.approx(np.radians(1e-3))
    bare = stated(tmp_path, 'kp = 5e4\nkd = 300\nperiod = 2\ndelay = 2\nderivative = "position"',
                  RIGS["forced"])  # fmt: skip
    assert bare.controller == PositionLoop(5e4, 300.0, 2e-3, late=True, error_derivative=False)
    assert stated(tmp_path, "period = 4").controller is None


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("kd = 5", "kp: is missing"),
        ("kp = -1", "kp: give a number above 0"),
        ('kp = "5 N/m"', "kp: '5 N/m' is not in a unit such as N m/rad"),
        ('kp = "stiff"', "kp: 'stiff' is not a number"),
        ("kp = 5\ndelay = 0.4", "0 or one period"),
        ("kp = 5\nki = 3", "a loop file has no such word"),
        ('kp = 5\nderivative = "both"', "derivative"),
        ("kp = 5\nsensor = 3", "sensor"),
        ("kp = true", "kp"),
        ("kp = [", "not TOML"),
        ("kp = nan", "kp: give a number above 0"),
    ],
)
def test_what_is_no_loop_is_one_line(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(InputError, match=r"loop\.toml: ") as refusal:
        stated(tmp_path, text)
    assert message in str(refusal.value)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize("late", [False, True])
def test_the_stated_loop_moves_as_a_foreign_one_does(late: bool) -> None:
    p = np.array([1.0, 3.0, 0.5, 0.4])  # F_C, F_V, inertia, constant torque
    t = 1e-3 * np.arange(3000.0)
    command = 0.2 * (1.0 - np.cos(np.pi * t))
    loop = PositionLoop(40.0, 2.0, 1e-3, late=late)
    from dataclasses import replace  # noqa: PLC0415

    law = LAWS["coulomb-viscous"]
    settings = Compensator(scale=0.7, feedback=False)
    moved = compensated(
        replace(ROTARY, loop=loop), law, p[None], Reference("sine", t, command), [settings],
        (law, p),
    )  # fmt: skip
    curve = Curve(1.0, 1.0, 3.0)
    foreign = simulate_loop(
        Loop(0.5, 40.0, 2.0, hold=2.0 if late else 1.0, g_0=0.4), curve, curve, (curve, curve),
        Settings(0.7, 0.0), command,
    )  # fmt: skip
    error = command - foreign.position
    assert np.abs(moved.position[0] - foreign.position).max() < 0.01 * np.abs(error).max()


def log_of_an_arm(folder: Path) -> Path:
    """0.5 kg m² under 1.2 N m and 0.8 N m s/rad, there and back at several speeds, 12 s."""
    t = 1e-3 * np.arange(12001)
    command = 0.6 * np.sin(1.5 * t) + 0.3 * np.sin(4.0 * t)
    curve = Curve(1.2, 1.2, 0.8)
    motion = simulate(0.5, curve, curve, Driver(kp=400.0, kd=40.0), t, command, h=1e-4)
    rng = np.random.default_rng(4)
    file = folder / "arm.csv"
    table = np.column_stack([
        motion.t, motion.position + 1e-5 * rng.standard_normal(len(t)),
        motion.force + 0.02 * rng.standard_normal(len(t)),
    ])  # fmt: skip
    heads = "time [s],position [rad],force [N m]"
    np.savetxt(file, table, fmt="%.7f", delimiter=",", header=heads, comments="")
    return file


def test_from_a_card_of_measured_torques_to_exported_code(stribeck: Any, tmp_path: Path) -> None:
    log = log_of_an_arm(tmp_path)
    there = tmp_path / "there"
    options = ("--rig", "forced-rotary", "--law", "coulomb-viscous", "--out", str(there))
    assert stribeck("identify", str(log), *options).status == 0
    card = tmp_path / "elsewhere.json"  # without its log
    shutil.copy(there / "card.json", card)
    log.unlink()

    refused = stribeck("compensate", str(card))
    assert refused.status == 2
    assert refused.err.count("\n") == 1
    assert "--loop FILE.toml" in refused.err

    (tmp_path / "loop.toml").write_text(LOOP, encoding="utf-8")
    out = tmp_path / "compensation"
    done = stribeck(
        "compensate", str(card), "--loop", str(tmp_path / "loop.toml"), "--mode", "reference",
        "--scale", "0.9", "--out", str(out), "--json",
    )  # fmt: skip
    assert (done.status, json.loads(done.out)["recommended"]["scale"]) == (0, 0.9)
    document = json.loads((out / "compensation.json").read_text(encoding="utf-8"))
    assert document["sensor"]["resolution"] == pytest.approx(np.radians(1e-3))

    code = tmp_path / "c"
    exported = stribeck(
        "export", str(card), "--to", "c", "--out", str(code),
        "--compensation", str(out / "compensation.json"),
    )  # fmt: skip
    assert exported.status == 0
    source = (code / "friction.c").read_text(encoding="utf-8")
    settings = document["recommended"]["settings"]
    for name in ("scale", "reference_band", "dead_band", "crossover"):
        assert f"[FRICTION_{name.upper()}] = {settings[name]['value']!r};" in source


def test_gains_are_not_stated_twice(stribeck: Any, tmp_path: Path) -> None:
    from test_compensation import robot, written_to  # noqa: PLC0415

    file = written_to(tmp_path, robot((3.0, None, None), F_C=1.0))
    (tmp_path / "loop.toml").write_text(LOOP, encoding="utf-8")
    refused = stribeck("compensate", file, "--speed", "0.2", "--loop", str(tmp_path / "loop.toml"))
    assert refused.status == 2
    assert "has a controller with gains of its own" in refused.err
