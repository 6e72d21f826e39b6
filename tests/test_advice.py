"""What a refusal of a log advises is exact: typed as it stands, it is understood."""

from __future__ import annotations

import re
import shlex
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from command import Completed, caller
from stribeck.report.contents_report import MOST

Run = Callable[..., Completed]
N = 600
T = 0.01 * np.arange(N)
X = 20.0 * np.sin(T)


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Run:
    called = caller(monkeypatch, capsys)
    return lambda *words: called(*map(str, words))


def log(folder: Path, heads: str, columns: int = 2, name: str = "log.csv") -> Path:
    rest = "".join(f",{k}" for k in range(3, columns + 1))
    rows = (f"{t:.2f},{x:.6g}{rest}" for t, x in zip(T, X, strict=True))
    path = folder / name
    path.write_text("\n".join([heads, *rows]) + "\n", encoding="utf-8")
    return path


def advised(line: str) -> list[str]:
    """The options `--column` of a refusal, as a shell takes them."""
    return [w for o in re.findall(r'--column \w+="[^"]*"', line) for w in shlex.split(o)]


@pytest.mark.parametrize(
    ("heads", "option"),
    [
        ("time,pos", 'position="pos [mm]"'),
        ("time,angle", 'position="angle [rad]"'),
        ("Time [ms],Servo motor speed", 'velocity="Servo motor speed [r/min]"'),
        ("t_s,Carriage [mm]", 'position="Carriage [mm]"'),
        ("t_s,Carriage [deg]", 'position="Carriage [deg]"'),
    ],
)
def test_the_advice_typed_as_it_stands_reads_the_log(
    heads: str, option: str, tmp_path: Path, run: Run
) -> None:
    path = log(tmp_path, heads)
    refused = run("check", path)
    assert refused.status == 2
    line = refused.err.splitlines()[-1]
    assert option in line
    done = run("check", path, *advised(line))
    assert done.status == 0, done.err


def test_the_rig_whose_logs_have_these_heads_is_told(tmp_path: Path, run: Run) -> None:
    heads = "timestamp,position,speed,goal_position,input_volts,temp"
    path = log(tmp_path, heads, 6)
    refused = run("check", path)
    assert refused.err.rstrip().endswith("or --rig servo-pendulum, whose logs have these heads")
    assert run("check", path, "--rig", "servo-pendulum").status == 0


def test_a_mapping_that_is_the_rigs_is_told_from_ones_own(tmp_path: Path, run: Run) -> None:
    path = log(tmp_path, "t_s,q_rad")
    line = run("check", path, "--rig", "servo-pendulum").err.splitlines()[-1]
    assert "rig servo-pendulum has that mapping: --column CHANNEL=HEAD says another" in line


def test_a_log_is_looked_at_that_its_rig_cannot_simulate(tmp_path: Path, run: Run) -> None:
    done = run("check", log(tmp_path, "time [s],pos [mm]"), "--rig", "slide-bed")
    assert done.status == 0
    assert done.err.startswith("warning: log.csv: no command is in the log, and the slide goes")
    assert "samples" in done.out


def test_a_refusal_shows_no_more_channels_than_one_reads(tmp_path: Path, run: Run) -> None:
    many = 100
    heads = ",".join(["time", "a_pos", *(f"b{k}" for k in range(3, many + 1))])
    refused = run("check", log(tmp_path, heads, many))
    assert len(refused.err.splitlines()) < MOST
    assert "of 100 channels" in refused.err
    assert "a_pos" in refused.err


def test_a_number_is_that_of_contents(tmp_path: Path, run: Run) -> None:
    path = tmp_path / "log.json"
    pairs = ", ".join(f'{{"a": {t:.2f}, "b": {x:.6g}}}' for t, x in zip(T, X, strict=True))
    path.write_text(f'{{"mass": 0.5, "rows": [{pairs}]}}', encoding="utf-8")
    table = run("contents", path).out
    numbers = {row.split()[1]: row.split()[0] for row in table.splitlines() if row[:1].isdigit()}
    words = [f"time={numbers['a']} [s]", f"position={numbers['b']} [mm]"]
    done = run("check", path, "--column", words[0], "--column", words[1])
    assert done.status == 0, done.err
    assert "-20 mm to 20 mm" in done.out


def test_help_is_that_of_the_command(run: Run) -> None:
    for words in (["identify", "a.csv", "--traim", "1:2"], ["export", "card.json"]):
        assert f"(see stribeck {words[0]} --help)" in run(*words).err


@pytest.mark.parametrize(
    ("head", "words"),
    [
        ("Torque [%]", ["column Torque [%] is in % of what a [drive] table", "`stribeck drives`"]),
        ("Torque", ["column Torque has no unit", "`stribeck drives`"]),
        ("Iq [A]", ["or its current with a [drive] table"]),
        ("z [mm]", ["map a column to force"]),
    ],
)
def test_a_missing_force_is_told_with_what_may_stand_for_it(
    head: str, words: list[str], tmp_path: Path, run: Run
) -> None:
    line = run("identify", log(tmp_path, f"t_s,x_mm,{head}", 3), "--rig", "forced").err
    assert "rig forced needs the measured force of the drive" in line
    assert all(w in line for w in words), line


def test_an_angle_is_sent_to_the_rotary_rig(tmp_path: Path, run: Run) -> None:
    path = log(tmp_path, "t_s,q_rad,tau_Nm", 3)
    assert "use forced-rotary" in run("identify", path, "--rig", "forced").err


def test_columns_without_units_are_told_together(tmp_path: Path, run: Run) -> None:
    out = run("check", log(tmp_path, "t_s,x_mm,velocity,accel", 4)).out
    text = (
        "columns velocity (velocity), accel (acceleration) have no unit and were not taken: say it,"
        ' as in --column velocity="velocity [m/s]" --column acceleration="accel [m/s**2]"'
    )
    assert text in " ".join(out.split())
