"""Messages name options by the words of who asked: typed ones, or keywords of Python."""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stribeck
from command import caller
from stribeck.compensate.closed_loop import controlled
from stribeck.wording import either, on_command_line, option

SOURCE = Path(stribeck.__file__).parent
#: Rooms that only the command line calls; the studio shows the command that does the same.
TYPED = ("cli", "bench", "studio", "report/registries.py", "report/published_report.py")
LINEAR = np.linspace(0.0, 1.0, 400)


def messages(tree: ast.Module) -> Iterator[tuple[int, str]]:
    """Line and text of each string but docstrings and what `either` has for the command line."""
    apart = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            apart.add(id(node.value))
        if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "either":
            apart |= {id(part) for part in ast.walk(node.args[0])}
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in apart:
            yield node.lineno, node.value


def test_below_the_command_line_no_message_spells_an_option() -> None:
    spelled = re.compile(r"(?<![\w!<-])--[a-z][a-z-]+\b(?! -->)")
    files = [f for f in SOURCE.rglob("*.py") if "wording" not in f.name]
    below = [f for f in files if not f.relative_to(SOURCE).as_posix().startswith(TYPED)]
    typed = [
        f"{file.relative_to(SOURCE)}:{line}: {text}"
        for file in below
        for line, text in messages(ast.parse(file.read_text()))
        if spelled.search(text) and not re.search(r"`\w+ [^`]*--", text)  # a whole command
    ]
    assert typed == []


@pytest.mark.parametrize(
    ("keyword", "value", "python", "command"),
    [
        ("train", None, "train", "--train"),
        ("repeats", 3, "repeats=3", "--repeats 3"),
        ("max_error", 0.5, "max_error=0.5", "--max-error 0.5"),
        ("delay", 0.0125, "delay=0.0125", "--delay 12.5"),  # s, and ms
        ("delay", "auto", 'delay="auto"', "--delay auto"),
        ("fixed", {"F_V+": 0}, 'fixed={"F_V+": 0}', "--set F_V+=0"),
        ("constants", {"NAME": "VALUE"}, 'constants={"NAME": VALUE}', "--set NAME=VALUE"),
        ("columns", {"rate": 500}, 'columns={"rate": 500}', "--rate 500"),
        ("columns", {"time_unit": "ms"}, 'columns={"time_unit": "ms"}', "--time-unit ms"),
        (
            "columns",
            {"time": "1 [s]", "position": "2 [mm]"},
            'columns={"time": "1 [s]", "position": "2 [mm]"}',
            '--column time="1 [s]" --column position="2 [mm]"',
        ),
    ],
)
def test_an_option_in_both_spellings(keyword: str, value: Any, python: str, command: str) -> None:
    assert option(keyword, value) == python
    with on_command_line():
        assert option(keyword, value) == command
        with on_command_line(entered=False):
            assert option(keyword, value) == python
    assert option(keyword, value) == python


def test_the_command_line_is_left_by_an_error_too() -> None:
    with pytest.raises(KeyError), on_command_line():
        raise KeyError
    assert either("typed", "called") == "called"


# --- the same refusal at both doors -------------------------------------------------------------


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Any:
    monkeypatch.chdir(tmp_path)
    return caller(monkeypatch, capsys)


def refused(call: Callable[[], object]) -> str:
    with pytest.raises(stribeck.InputError) as error:
        call()
    return str(error.value)


@pytest.fixture
def card(tmp_path: Path) -> Path:
    """A card of an axis with Coulomb and viscous friction."""
    t = np.arange(0, 8, 0.004)
    v = 0.2 * np.sin(2 * t)
    force = 4.0 * np.sign(v) + 10.0 * v + 0.8 * np.cos(2 * t)
    log = {"t": t, "x": 0.1 * (1 - np.cos(2 * t)), "F": force}
    fit = stribeck.identify(
        log, units={"t": "s", "x": "m", "F": "N"}, rig="forced", law="coulomb-viscous"
    )
    file = tmp_path / "card.json"
    file.write_text(fit.card().text())
    return file


def test_export_names_its_arguments_and_its_options(run: Any, card: Path) -> None:
    assert refused(lambda: stribeck.export(card, "c", speed=1.0)) == (
        "speed means nothing to c: it takes name, settings, compensation"
    )
    typed = run("export", "card.json", "--to", "c", "--speed", "1", "--out", "c")
    assert typed.err == (
        "stribeck: --speed means nothing to c: it takes --name, --set, --compensation\n"
    )
    assert "urdf: give into: " in refused(lambda: stribeck.export(card, "urdf"))
    assert "urdf: give --into: " in run("export", "card.json", "--to", "urdf", "--out", "u").err


def test_a_rig_without_a_controller_asks_for_a_loop(run: Any, card: Path) -> None:
    told = refused(lambda: controlled(stribeck.RIGS["forced"]))
    assert told.endswith("state its gains kp and kd as loop=PositionLoop(kp, kd)")
    assert "(--loop FILE.toml)" in run("compensate", "card.json", "--speed", "1").err
    assert refused(lambda: stribeck.compensate(card)) == told


def test_a_log_without_times_asks_for_its_rate(run: Any, tmp_path: Path) -> None:
    columns = np.column_stack([LINEAR, LINEAR])
    np.savetxt(tmp_path / "bare.csv", columns, header="x [mm],F [N]", comments="", delimiter=",")
    told = refused(lambda: stribeck.read(tmp_path / "bare.csv"))
    assert told.endswith(
        'columns={"time": "head [s]"}, or at what rate it was recorded: columns={"rate": 500} (Hz)'
    )
    typed = run("check", "bare.csv").err
    assert '--column time="head [s]", or at what rate it was recorded: --rate 500 (Hz)' in typed


def test_what_reads_in_a_process_of_its_own_names_them_too(run: Any, tmp_path: Path) -> None:
    polars = pytest.importorskip("polars")
    root = tmp_path / "set"
    (root / "meta").mkdir(parents=True)
    (root / "meta" / "info.json").write_text(
        '{"codebase_version": "v3.0", "fps": 30, "features": '
        '{"action": {"dtype": "float32", "shape": [1], "names": ["q"]}}}'
    )
    data = root / "data" / "chunk-000"
    data.mkdir(parents=True)
    frame = polars.DataFrame(
        {
            "timestamp": np.tile(np.arange(50) / 30, 2),
            "episode_index": np.repeat([0, 1], 50),
            "action": [[v] for v in LINEAR[:100]],
        }
    )
    frame.write_parquet(data / "file-000.parquet")
    assert 'name one, as in columns={"episode": "0"}' in refused(lambda: stribeck.read(root))
    assert "name one, as in --episode 0" in run("check", "set").err
