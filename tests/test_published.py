"""Recordings to try: the one in the package, and files known by what was published."""

from __future__ import annotations

import json
import shutil
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from command import caller
from conftest import RECORDINGS
from stribeck import read
from stribeck.data.published import published, sample

TOOL = Path(__file__).parents[1] / "tools" / "sample.py"


@pytest.fixture
def stribeck_(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> Any:
    monkeypatch.chdir(tmp_path)
    return caller(monkeypatch, capsys)


def test_the_recording_in_the_package_is_what_its_tool_writes() -> None:
    spec = spec_from_file_location("sample_tool", TOOL)
    assert spec is not None
    assert spec.loader is not None
    tool = module_from_spec(spec)
    spec.loader.exec_module(tool)
    old, new = (
        np.genfromtxt(text.decode().splitlines(), delimiter=",", skip_header=1)
        for text in (sample(), tool.text())
    )
    # A sample on an edge of the sensor may round the other way where the processor is another.
    steps = np.array([1e-6, 1e-6, 0.1, 0.13])
    assert old.shape == new.shape
    assert np.mean(np.any(np.abs(old - new) > steps, axis=1)) < 1e-3


def test_it_is_written_and_the_command_beside_it_identifies_it(stribeck_: Any) -> None:
    written = stribeck_("data", "slide", "--out", "slide.csv")
    assert written.status == 0
    (command,) = [line for line in written.out.splitlines() if line.startswith("stribeck ")]
    assert len(read("slide.csv").t) == 6101
    done = stribeck_(*command.split()[1:], "--json", "--no-figures")
    assert done.status == 0
    breakaway = json.loads(done.out)["parameters"]["F_S"]
    assert breakaway["low"] < 152.2804 < breakaway["high"], "F_S leftward as the paper has it, N"
    assert Path("result/report.html").is_file()


@pytest.mark.recordings("emps")
def test_a_published_file_is_known_by_its_content(stribeck_: Any, tmp_path: Path) -> None:
    shutil.copy(RECORDINGS / "emps" / "DATA_EMPS.mat", tmp_path / "renamed.bin")
    done = stribeck_("data", "emps", "renamed.bin")
    assert done.status == 0
    assert "renamed.bin: DATA_EMPS.mat of emps, as it was published" in done.out
    assert published()["emps"].command in done.out


@pytest.mark.recordings("emps", "bam_xl330")
def test_every_published_file_has_the_size_and_hash_that_is_told() -> None:
    places = {"emps": RECORDINGS / "emps", "xl330": RECORDINGS / "bam_xl330" / "logs"}
    for name, recording in published().items():
        for file in recording.files:
            path = places[name] / file.name
            assert recording.recognised(path) == file
            assert path.stat().st_size == file.size


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (("data", "nobody"), "no recording 'nobody': there are slide, emps, xl330"),
        (("data", "emps", "no.mat"), "no.mat: No such file or directory"),
        (("data", "emps", "--out", "a.csv"),
         "--out: only slide is here: stribeck data slide --out FILE.csv"),
        (("data", "slide", "--out", "a.mat"), "a.mat: is written as CSV: name it a.mat.csv"),
    ],
)  # fmt: skip
def test_what_cannot_be_is_one_line(stribeck_: Any, arguments: tuple[str, ...], line: str) -> None:
    done = stribeck_(*arguments)
    assert done == (2, "", f"stribeck: {line}\n")


def test_another_file_is_refused_with_what_differs(stribeck_: Any, tmp_path: Path) -> None:
    tmp_path.joinpath("DATA_EMPS.mat").write_bytes(b"MATLAB 5.0 MAT-file" * 7)
    done = stribeck_("data", "emps", "DATA_EMPS.mat")
    assert done.status == 2
    assert done.err.startswith(
        "stribeck: DATA_EMPS.mat: has 133 bytes, the published one 626,039: is no file of emps"
    )
    assert done.err.count("\n") == 1
