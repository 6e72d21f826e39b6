"""A torque-limited pendulum with a spiky torque: intervals must be wide, with the reason."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stribeck import cli, identify, read
from stribeck.data import check

DATA = Path(__file__).parents[2] / "shared" / "data" / "dfki_pendulum"
pytestmark = pytest.mark.recordings("dfki_pendulum")
COLUMNS = {
    "time": "time [s]", "position": "position [rad]", "velocity": "velocity [rad/s]",
    "force": "torque [Nm]",
}  # fmt: skip
#: Published least squares; its friction is F_C atan(100 v), its gravity 9.81 m c sin q.
PUBLISHED = {"M": 0.06259, "g_sin": 9.81 * 0.1022, "F_V": 0.04707, "F_C": 0.1839 * np.pi / 2,
             "offset": -0.07586}  # fmt: skip


def log(name: str) -> Any:
    return read(DATA / f"{name}_measured.csv", columns=COLUMNS)


@pytest.fixture(scope="module")
def fit() -> Any:
    return identify(log("sysid"), rig="forced-pendulum", fixed={"g_cos": 0.0})


@pytest.mark.parametrize("name", list(PUBLISHED))
def test_wide_intervals_contain_the_published_values(fit: Any, name: str) -> None:
    e = next(e for e in fit.estimates if e.name == fit.rig.label(name))
    # The published F_C is at an end of its interval, which the cut-off nearly widens.
    slack = 0.01 * (e.high - e.low)
    assert e.low - slack < PUBLISHED[name] < e.high + slack
    assert e.verdict in ("weak", "not identifiable")
    assert max(e.high - e.value, e.value - e.low) > 0.5 * abs(e.value)


@pytest.mark.parametrize(
    "words",
    [
        "% of the force is not explained by this model: the log supports nothing better than weak",
        "the force has spikes: samples that stand away from both neighbours make 72% of its",
        "the estimates depend on the cut-off",
    ],
)
def test_it_says_why(fit: Any, words: str) -> None:
    assert any(words in w for w in fit.warnings)


def test_no_delay_is_certain_where_most_of_the_torque_is_not_explained(fit: Any) -> None:
    assert fit.delay == 0.0
    assert not any("delay" in w for w in fit.warnings)


def test_the_commands_say_so_and_validation_fails(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    columns = tmp_path / "map.toml"
    lines = [f'{channel} = "{head}"' for channel, head in COLUMNS.items()]
    columns.write_text("\n".join(["[columns]", *lines]))
    file, folder = str(DATA / "sysid_measured.csv"), str(tmp_path / "fit")

    def run(*arguments: str) -> int:
        monkeypatch.setattr(sys, "argv", ["stribeck", *arguments, "--columns", str(columns)])
        try:
            cli.main()
        except SystemExit as end:
            return int(end.code or 0)
        return 0

    assert (
        run("identify", file, "--rig", "forced-pendulum", "--set", "g_cos=0", "--out", folder) == 0
    )
    printed = capsys.readouterr().out
    assert "identified" not in printed.replace("not identifiable", "")
    assert run("validate", f"{folder}/card.json", file, "--max-error", "30") == 1
    assert "the model does not hold" in capsys.readouterr().err
    assert run("check", file) == 0
    assert "of its variance is spikes" in capsys.readouterr().out


@pytest.mark.parametrize("name", ["sysid", "gravity_comp", "energy_shaping"])
def test_no_log_is_called_stick_slip(name: str) -> None:
    assert any(line.startswith("no stick-slip") for line in check(log(name)).verdict)


def test_gravity_compensation_is_a_command_and_not_a_measurement() -> None:
    verdict = check(log("gravity_comp")).verdict
    assert any("an exact function of the position" in line for line in verdict)
    assert not any("road is open" in line for line in verdict)
    fit = identify(log("gravity_comp"), rig="forced-pendulum", fixed={"g_cos": 0.0})
    assert any("it is a command that was computed from it" in w for w in fit.warnings)
    assert all(e.verdict != "identified" for e in fit.estimates)


def test_swings_are_told_from_slips() -> None:
    assert any("swings or single moves" in line for line in check(log("energy_shaping")).verdict)
