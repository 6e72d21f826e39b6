"""A short slice of `tools/fuzz.py`: damaged inputs are accepted, or refused in one line."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from fuzz import outcome, random_numbers
from fuzz_forks import ForkedProcesses
from fuzz_inputs import TARGETS, prepare
from fuzz_mutation import mutated
from stribeck.bench.campaign import parsed, shipped
from stribeck.data import read
from stribeck.data.readers import isolated
from stribeck.errors import InputError

#: Formats that a process of its own reads.
ISOLATED = ("parquet", "feather", "lerobot", "hdf5", "tdms", "mdf4", "rosbag", "ulog")


@pytest.fixture(scope="module")
def inputs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The files that inputs refer to."""
    folder = tmp_path_factory.mktemp("inputs")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        prepare()
    return folder


@pytest.mark.parametrize("name", [n for n in TARGETS if n != "command"])
def test_a_damaged_input_is_accepted_or_refused_in_one_line(
    name: str, inputs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shutil.copytree(inputs, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    corpus = TARGETS[name].corpus()
    isolated = dict.fromkeys(ISOLATED, 6)
    with ForkedProcesses():
        for number in range({"report": 15, **isolated}.get(name, 60)):
            kind, line = outcome(name, mutated(corpus, random_numbers(name, 0, number)))
            assert kind in {"accepted", "refused"}, line


def test_a_forked_process_reads_as_one_of_its_own(
    inputs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shutil.copytree(inputs, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    whole = TARGETS["hdf5"].corpus()[0]
    files = (whole, whole[: len(whole) // 2])
    started = [outcome("hdf5", data) for data in files]
    with ForkedProcesses() as forked:
        assert [outcome("hdf5", data) for data in files] == started
    assert [kind for kind, _ in started] == ["accepted", "refused"]
    assert 20 < forked.peak < 500


@pytest.mark.parametrize("name", [n for n in TARGETS if n != "command"])
def test_the_corpus_is_accepted(
    name: str, inputs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Else damage is done to what is refused anyway."""
    shutil.copytree(inputs, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    kinds = {outcome(name, data) for data in TARGETS[name].corpus()[:2]}
    assert kinds == {("accepted", "")}


def test_the_same_numbers_make_the_same_input() -> None:
    corpus = TARGETS["text"].corpus()
    first, again, other = (mutated(corpus, random_numbers("text", 3, n)) for n in (7, 7, 8))
    assert first == again
    assert first != other


def test_a_factor_that_takes_a_force_beyond_all_numbers_is_refused(tmp_path: Path) -> None:
    log = tmp_path / "log.csv"
    log.write_text("t_s,x_mm,F_N\n" + "".join(f"{i},{i * i},{i}\n" for i in range(20)))
    factor = {"force": {"column": "F_N", "unit": "kN", "factor": 1e308}}
    with pytest.raises(InputError, match=r"line 3: force is infinite"):
        read(log, columns=factor)


def test_an_efficiency_that_takes_a_force_beyond_all_numbers_is_refused(tmp_path: Path) -> None:
    log = tmp_path / "log.csv"
    log.write_text("t_s,x_mm,F_N\n" + "".join(f"{i},{i * i},{-i}\n" for i in range(20)))
    drive = {"signal": "% of rated force", "rated_force": "1e9 N", "efficiency": 1e-308}
    with pytest.raises(InputError, match="force has values that are not finite"):
        read(log, columns={"force": "F_N [%]"}, drive=drive)


def test_a_setting_called_method_is_refused() -> None:
    with pytest.raises(InputError, match="has no setting 'method'"):
        parsed(shipped()["paper"].replace("step = 0.25", 'method = "tabu"'))


def test_a_setting_of_401_digits_is_refused() -> None:
    with pytest.raises(InputError, match="step must be a number > 0"):
        parsed(shipped()["paper"].replace("step = 0.25", f"step = {'9' * 401}"))


def test_a_library_that_does_not_end_is_ended() -> None:
    """A damaged ULog can make pyulog loop: it has seconds of the processor."""
    code = (
        "import sys; from pathlib import Path; from types import SimpleNamespace as S\n"
        "import library_process as program\n"
        "def loop(*_):\n    while True: pass\n"
        "program._bare_packages()\n"
        "program.answer(S(library_log=loop), Path('x'), {'options': {}}, (1 << 26, 1), None)\n"
    )
    path = os.pathsep.join([str(isolated.PROGRAM.parent), *sys.path])
    ended = subprocess.run(
        [sys.executable, "-c", code], env={**os.environ, "PYTHONPATH": path}, check=False
    )
    assert ended.returncode == -signal.SIGXCPU
