"""Logs whose force is a drive's signal: what a column's unit becomes, and what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from stribeck import InputError, Recording
from stribeck.data import read

T = np.arange(0.0, 1.0, 0.01)
MR = Path(__file__).parents[2] / "shared/data/logs/mr_configurator/a3MR.csv"


def written(folder: Path, heads: str, *columns: np.ndarray) -> Path:
    file = folder / "axis.csv"
    rows = np.column_stack([T, *columns])
    lines = [f"t [s],{heads}", *(",".join(f"{x:.9g}" for x in row) for row in rows)]
    file.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return file


def map_file(folder: Path, text: str) -> Path:
    file = folder / "map.toml"
    file.write_text(text, encoding="utf-8")
    return file


MOTION, PERCENT = 100.0 * np.sin(5 * T), 20.0 * np.sin(7 * T)
DRIVE = '[drive]\nsignal = "% of rated torque"\nrated_torque = "1.27 N m"\nlead = "10 mm"\n'
#: 1.27 N m times 2 pi a turn over 10 mm a turn, a hundredth.
PER_CENT = 1.27 * 2 * np.pi / 0.01 / 100


def test_percent_of_a_head_becomes_the_force_by_the_table_of_a_map(tmp_path: Path) -> None:
    log = written(tmp_path, "x [mm],Torque [%]", MOTION, PERCENT)
    recording = read(log, columns=map_file(tmp_path, DRIVE))
    assert recording.force is not None
    np.testing.assert_allclose(recording.force, PER_CENT * PERCENT, rtol=1e-6, atol=1e-9)
    assert recording.drive is not None
    assert recording.drive.table()["rated_torque"] == "1.27 N m"
    assert any("force is Torque [%] (% of rated torque)" in note for note in recording.notes)


def test_per_mille_and_a_current_are_understood(tmp_path: Path) -> None:
    log = written(tmp_path, "x [mm],tau [‰]", MOTION, 10 * PERCENT)
    recording = read(log, columns=map_file(tmp_path, DRIVE))
    assert recording.force is not None
    np.testing.assert_allclose(recording.force, PER_CENT * PERCENT, rtol=1e-6, atol=1e-9)
    table = {"signal": "A rms", "kt": "0.5 N m/A rms", "lead": "10 mm"}
    log = written(tmp_path, "x [mm],motor current [mA]", MOTION, 1e3 * PERCENT)
    recording = read(log, drive=table)
    assert recording.force is not None
    np.testing.assert_allclose(recording.force, 0.5 * 2 * np.pi / 0.01 * PERCENT, rtol=1e-6)
    assert recording.current is not None


def test_counts_and_turns_of_the_motor_become_travel(tmp_path: Path) -> None:
    turns = MOTION / 10.0
    table = {"signal": "N m", "lead": "10 mm", "counts_per_turn": 4096}
    log = written(tmp_path, "position [inc],speed [r/min],torque [Nm]", 4096 * turns, turns, T)
    recording = read(log, drive=table)
    np.testing.assert_allclose(recording.position, 1e-3 * MOTION, rtol=1e-6, atol=1e-9)
    assert recording.velocity is not None
    np.testing.assert_allclose(recording.velocity, 0.01 / 60 * turns, rtol=1e-6, atol=1e-9)
    assert not recording.rotary


def test_a_frame_goes_through_the_same_chain() -> None:
    frame = {"t": T, "x": MOTION, "tau": PERCENT}
    table = {"signal": "% of rated torque", "rated_torque": "1.27 N m", "lead": "10 mm"}
    recording = Recording.of(frame, units={"t": "s", "x": "mm", "tau": "%"}, drive=table)
    assert recording.force is not None
    np.testing.assert_allclose(recording.force, PER_CENT * PERCENT, rtol=1e-9)


def test_percent_alone_is_refused_with_what_it_can_mean(tmp_path: Path) -> None:
    log = written(tmp_path, "x [mm],Torque [%]", MOTION, PERCENT)
    with pytest.raises(InputError, match=r"column Torque .*does not say of what") as refused:
        read(log, columns={"force": "Torque [%]"})
    line = str(refused.value)
    assert 'signal = "% of rated torque", rated_torque = "' in line
    assert 'signal = "% of rated current", rated_current = "' in line
    notes = read(log).notes  # nobody asked for the force
    assert any("a [drive] table would say" in note for note in notes)


@pytest.mark.parametrize(
    ("heads", "drive", "says"),
    [
        ("x [inc],Torque [Nm]", None, "counts_per_turn"),
        ("x [inc],Torque [Nm]", {"signal": "N m"}, "counts_per_turn"),
        ("x [mm],Torque [N]", {"signal": "A", "kt": "1 N m/A", "lead": "1 mm"}, "applied once"),
        ("x [mm],Torque [%]", {"signal": "% of peak torque", "peak_torque": "1 N m"}, "lead"),
    ],
)
def test_what_cannot_be_is_refused_in_a_line(
    tmp_path: Path, heads: str, drive: dict[str, str] | None, says: str
) -> None:
    log = written(tmp_path, heads, MOTION, PERCENT)
    with pytest.raises(InputError, match=says) as refused:
        read(log, drive=drive)
    assert "\n" not in str(refused.value)


def test_a_rig_and_a_map_do_not_both_state_a_drive(tmp_path: Path) -> None:
    log = written(tmp_path, "x [mm],Torque [%]", MOTION, PERCENT)
    other = {"signal": "% of rated torque", "rated_torque": "2 N m", "lead": "10 mm"}
    with pytest.raises(InputError, match="both state a drive"):
        read(log, columns=map_file(tmp_path, DRIVE), drive=other)


#: 100 % of a motor of 1.3 N m by five conventions, N m, as their documents have it.
HUNDRED = {
    "mitsubishi-mr": ({"rated_torque": "1.3 N m"}, 1.3),
    "ax8000": ({"standstill_torque": "1.43 N m"}, 1.43),
    "ax5000": ({"peak_torque": "3.8 N m"}, 3.8),
    "el72x1-rms": ({"rated_current": "2.6 A rms", "kt": "0.52 N m/A rms"}, 2.6 * 0.52),
    "el72x1-peak": ({"rated_current": "2.6 A peak", "kt": "0.52 N m/A rms"}, 2.6 * 0.52 / 2**0.5),
}


@pytest.mark.skipif(not MR.exists(), reason="../shared/data is not there")
def test_five_meanings_of_percent_are_five_forces_on_one_recording() -> None:
    columns = {"velocity": "Servo motor speed [r/min]", "force": "Torque [%]"}
    lines = MR.read_text(encoding="utf-8").splitlines()[5:]
    percent = np.array([float(line.split(",")[2]) for line in lines if line.strip()])
    for name, (numbers, hundred) in HUNDRED.items():
        log = read(MR, columns=columns, drive={"convention": name, **numbers})
        assert log.force is not None
        np.testing.assert_allclose(log.force, hundred / 100 * percent, rtol=1e-12)
        assert log.velocity is not None
        assert log.velocity.min() == pytest.approx(-1981 * 2 * np.pi / 60, rel=0.01)
