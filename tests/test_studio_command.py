"""The command that opens the studio says in a line what it cannot do."""

import importlib.util
import socket
from collections.abc import Callable
from importlib.machinery import ModuleSpec
from pathlib import Path

import pytest

from command import Completed, caller
from stribeck.cli import studio_command


@pytest.fixture
def run(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Callable[..., Completed]:
    return caller(monkeypatch, capsys)


@pytest.mark.parametrize("package", ["starlette", "uvicorn"])
def test_without_the_extra_it_says_what_to_install(
    run: Callable[..., Completed], monkeypatch: pytest.MonkeyPatch, package: str
) -> None:
    def find(name: str) -> ModuleSpec | None:
        return None if name == package else importlib.util.find_spec(name)

    monkeypatch.setattr(studio_command, "find_spec", find)
    completed = run("studio", "--no-browser")
    assert completed.status == 2
    assert (
        completed.err == f"stribeck: the studio needs {package}: pip install 'stribeck[studio]'\n"
    )


@pytest.mark.parametrize(
    ("words", "line"),
    [
        (["--port", "70000"], "--port 70000"),
        (["--port", "-1"], "--port -1"),
        (["nowhere.csv"], "nowhere.csv: no such file"),
        (["--host", "0.0.0.0"], "name the one address"),  # noqa: S104 - it is refused
        (["--host", "::"], "name the one address"),
        (["--host", "no.such.host.invalid"], "--host no.such.host.invalid"),
    ],
)
def test_what_cannot_be_is_refused(
    run: Callable[..., Completed], tmp_path: Path, words: list[str], line: str
) -> None:
    completed = run("studio", *words, "--home", str(tmp_path / "home"), "--no-browser")
    assert completed.status == 2
    assert line in completed.err
    assert "Traceback" not in completed.err


def test_a_port_that_is_taken_is_refused(run: Callable[..., Completed], tmp_path: Path) -> None:
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = str(other.getsockname()[1])
        completed = run("studio", "--port", port, "--home", str(tmp_path), "--no-browser")
    assert completed.status == 2
    assert f"--port {port}" in completed.err


def test_a_home_that_is_a_file_is_refused(run: Callable[..., Completed], tmp_path: Path) -> None:
    (tmp_path / "file").write_text("x", encoding="utf-8")
    completed = run("studio", "--home", str(tmp_path / "file"), "--no-browser")
    assert completed.status == 2
    assert "file" in completed.err
    assert completed.err.count("\n") == 1
