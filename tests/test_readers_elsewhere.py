"""Readers that other packages declare: the one of the page on logs, installed beside stribeck."""

from __future__ import annotations

import re
import subprocess
import sys
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest

from stribeck.data.readers import registry
from stribeck.errors import InputError

PAGE = Path(__file__).parents[1] / "docs" / "logs.md"
_PROGRAM = """
import sys
sys.path.insert(0, sys.argv[1])
from stribeck.data import read
from stribeck.report.registries import show_readers
show_readers("scope")
log = read(sys.argv[2])
print(len(log), log.position[-1], log.force[-1], log.t[-1])
"""


def test_a_reader_of_another_package(tmp_path: Path) -> None:
    """A package as pip lays it out: a module, and a folder with its entry points."""
    (source,) = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    (points,) = re.findall(r"```toml\n.*?\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    (tmp_path / "my_package.py").write_text(source)
    information = tmp_path / "my_package-1.0.dist-info"
    information.mkdir()
    (information / "METADATA").write_text("Metadata-Version: 2.1\nName: my_package\nVersion: 1.0\n")
    text = points.replace('"', "")
    (information / "entry_points.txt").write_text(f"[stribeck.readers]\n{text}")
    log = tmp_path / "log.csv"
    log.write_text("SCOPE1\n" + "\n".join(f"{0.1 * k * k} {k}" for k in range(40)))
    command = [sys.executable, "-P", "-c", _PROGRAM, str(tmp_path), str(log)]
    ended = subprocess.run(command, capture_output=True, text=True, check=True)
    first, *_, last = ended.stdout.splitlines()
    assert first == "scope: Scope of ours"
    count, position, force, t = last.split()
    assert count == "40"
    expected = [1e-4 * 39**2, 39.0, 0.039]
    assert [float(w) for w in (position, force, t)] == pytest.approx(expected)


@pytest.mark.parametrize(
    ("value", "sentence"),
    [
        ("no_such_module:READER", "the reader scope of no_such_module:READER cannot be loaded"),
        ("math:pi", "math:pi of math:pi is no Reader: mend or remove math:pi"),
    ],
)
def test_a_reader_that_is_none_is_named(
    value: str, sentence: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    entry = EntryPoint("scope", value, registry.ENTRY_POINTS)
    monkeypatch.setattr(registry, "entry_points", lambda **_: [entry])
    registry.readers.cache_clear()
    with pytest.raises(InputError, match=sentence):
        registry.readers()
    registry.readers.cache_clear()
