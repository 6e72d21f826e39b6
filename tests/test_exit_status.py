"""How commands end that cannot go on: a status, one line, and nothing else."""

from __future__ import annotations

import importlib
import os
import re
import signal
import subprocess
import sys
import threading
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from command import caller
from patience import PATIENCE
from stribeck.report.search_progress import SearchProgress
from test_select_truth import write_directional_logs


@pytest.fixture
def stribeck_(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Any:
    """Run a command in a folder with a short log of measured forces."""
    write_directional_logs(tmp_path, "a", 5.0)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr("tempfile.tempdir", None)
    return caller(monkeypatch, capsys)


FORCED = ("--rig", "forced", "--law", "coulomb-viscous")


def crash(*_: object) -> None:
    raise OverflowError("cannot\nconvert")


def test_an_error_of_ours_is_one_line_with_its_details_in_a_file(
    stribeck_: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("stribeck.report.registries.show_laws", crash)
    completed = stribeck_("laws")
    assert completed.status == 70
    assert completed.out == ""
    (line,) = completed.err.splitlines()
    pattern = (
        r"stribeck: this is an error in stribeck itself \(OverflowError: cannot convert\): the "
        r"details, to be reported, are in (\S+stribeck-error-\S+\.txt)"
    )
    match = re.fullmatch(pattern, line)
    assert match is not None, line
    details = Path(match[1]).read_text(encoding="utf-8")
    assert "arguments: ['laws']" in details
    assert details.rstrip().endswith("OverflowError: cannot\nconvert")
    assert "in crash" in details


def test_an_error_of_ours_is_one_line_where_no_file_can_be_written(
    stribeck_: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refused(*_: object, **__: object) -> None:
        raise OSError(30, "Read-only file system")

    monkeypatch.setattr("stribeck.report.registries.show_laws", crash)
    monkeypatch.setattr("tempfile.NamedTemporaryFile", refused)
    completed = stribeck_("laws")
    assert completed.status == 70
    (line,) = completed.err.splitlines()
    assert "it happened in test_exit_status.py, line " in line


DIGITS = "1" + "0" * 400


@pytest.mark.parametrize(
    "options",
    [
        ("--bootstrap", DIGITS),
        ("--posterior", DIGITS),
        ("--repeats", DIGITS, "--rig", "slide-bed"),
        ("--setting", f"R={DIGITS}", "--rig", "slide-bed"),
        ("--columns", "map.toml"),
    ],
)
def test_a_number_of_401_digits_is_refused(
    stribeck_: Any, tmp_path: Path, options: tuple[str, ...]
) -> None:
    channel = f'{{column = "position", unit = "m", factor = {DIGITS}}}'
    (tmp_path / "map.toml").write_text(f"position = {channel}\n", encoding="utf-8")
    rig = () if "--rig" in options else FORCED
    completed = stribeck_("identify", "a.csv", *rig, *options)
    assert completed.status == 2, completed.err
    (line,) = completed.err.splitlines()
    assert line.startswith("stribeck: ")


def test_folds_without_number_are_refused(stribeck_: Any) -> None:
    completed = stribeck_("select", "a.csv", "--rig", "forced", "--folds", DIGITS)
    assert completed.status == 2
    assert "folds must be 1,000 at most" in completed.err


@pytest.mark.skipif(sys.platform != "linux", reason="file names of any bytes are Linux's")
def test_a_log_whose_name_is_no_text_is_identified_and_shown(stribeck_: Any) -> None:
    name = os.fsdecode(b"bad\xff.csv")
    Path("a.csv").rename(name)
    completed = stribeck_("identify", name, *FORCED, "--out", "fit")
    assert completed.status == 0, completed.err
    assert stribeck_("report", "fit").status == 0
    assert "bad .csv" in Path("fit/report.html").read_text(encoding="utf-8")


def run(*arguments: str, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "stribeck", *arguments],
        capture_output=True, text=True, check=False, env=os.environ | environment,
        timeout=PATIENCE,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("variable", "value", "line"),
    [
        ("NUMBA_DISABLE_JIT", "1", "stribeck: NUMBA_DISABLE_JIT is set, but models run compiled"),
        ("NUMBA_NUM_THREADS", "0", "stribeck: NUMBA_NUM_THREADS=0: set a number of threads"),
    ],
)
def test_settings_that_no_model_can_run_with_are_told(variable: str, value: str, line: str) -> None:
    completed = run("laws", "stribeck", **{variable: value})
    assert completed.returncode == 2
    (said,) = completed.stderr.splitlines()
    assert said.startswith(line)


def test_figures_need_no_windows(stribeck_: Any) -> None:
    assert stribeck_("laws").status == 0
    completed = run("identify", "a.csv", *FORCED, "--out", "fit", MPLBACKEND="nonsense")
    assert completed.returncode == 0, completed.stderr
    assert Path("fit/friction.png").exists()


def test_warnings_of_libraries_do_not_reach_the_user(
    stribeck_: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    def noisy() -> None:
        warnings.warn("overflow encountered in exp", RuntimeWarning, stacklevel=1)

    monkeypatch.setattr("stribeck.cli.COMMANDS", (noisy,))
    with warnings.catch_warnings():
        warnings.simplefilter("always")
        before = warnings.showwarning
        assert stribeck_("noisy") == (0, "", "")
        assert warnings.showwarning is before
    assert stribeck_("noisy").status == 70  # what makes a warning an error goes on doing so


# --- SIGTERM as Ctrl-C ----------------------------------------------------------------------------


@pytest.fixture
def heeded() -> Iterator[None]:
    """Ctrl-C as Python has it at first: what a shell starts in the background ignores it."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.skipif(os.name != "posix", reason="signals as POSIX has them")
@pytest.mark.usefixtures("heeded")
@pytest.mark.parametrize(("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_signals_end_a_command_with_their_status(
    stribeck_: Any, monkeypatch: pytest.MonkeyPatch, number: int, status: int
) -> None:
    before = signal.getsignal(signal.SIGTERM)
    monkeypatch.setattr(
        "stribeck.report.registries.show_laws", lambda _: signal.raise_signal(number)
    )
    completed = stribeck_("laws")
    line = "stribeck: interrupted before there was a result: nothing was written\n"
    assert completed == (status, "", line)
    assert signal.getsignal(signal.SIGTERM) is before


@pytest.mark.skipif(os.name != "posix", reason="signals as POSIX has them")
@pytest.mark.usefixtures("heeded")
def test_a_signal_amid_an_import_waits_for_its_end_and_ends_a_wait_after_it(
    stribeck_: Any, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Cut short, an import leaves submodules behind, and the next import of the module fails."""
    (tmp_path / "interrupted_module.py").write_text(
        "import signal\nsignal.raise_signal(signal.SIGTERM)\nwhole = True\n", encoding="utf-8"
    )
    monkeypatch.syspath_prepend(str(tmp_path))

    def importing(_: object) -> None:
        module = importlib.import_module("interrupted_module")
        steps.append(module.whole)
        threading.Event().wait(PATIENCE)  # for the signal, which comes again and wakes this up
        steps.append("waited in vain")

    steps: list[object] = []
    monkeypatch.setattr("stribeck.report.registries.show_laws", importing)
    assert stribeck_("laws").status == 143
    assert steps == [True]


class Going:
    """A search that has not ended."""

    ended, trace, budget, shown = None, (), 1, 1.0


@pytest.mark.skipif(os.name != "posix", reason="signals as POSIX has them")
def test_sigterm_ends_a_search_between_two_steps(
    stribeck_: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    steps = []

    def searching(_: object) -> None:
        with SearchProgress("mm") as progress:
            for step in range(3):
                progress([Going()])  # type: ignore[list-item]
                signal.raise_signal(signal.SIGTERM)
                steps.append(step)

    monkeypatch.setattr("stribeck.report.registries.show_laws", searching)
    assert stribeck_("laws").status == 143
    assert steps == [0]
