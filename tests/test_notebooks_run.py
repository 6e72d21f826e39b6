"""The notebooks of the docs, run as a reader runs them."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

import nbformat
import pytest

import notebooks
from stribeck.export import TARGETS

ROOT = Path(__file__).parents[1]


def code(document: Any) -> list[Any]:
    return [cell for cell in document.cells if cell.cell_type == "code"]


def kinds(cell: Any) -> list[set[str]]:
    """What each output of a cell is made of."""
    return [set(output.get("data", {"stream": ""})) for output in cell.outputs]


@pytest.mark.parametrize("notebook", notebooks.NOTEBOOKS, ids=lambda p: p.stem)
def test_a_notebook_runs_and_is_kept_with_what_it_shows(notebook: Path, tmp_path: Path) -> None:
    command = [sys.executable, "tools/notebooks.py", "--out", str(tmp_path), str(notebook)]
    subprocess.run(command, cwd=ROOT, check=True, capture_output=True)
    again = nbformat.read(tmp_path / notebook.name, as_version=4)  # type: ignore[no-untyped-call]
    kept = nbformat.read(notebook, as_version=4)  # type: ignore[no-untyped-call]
    assert [c.source for c in again.cells] == [c.source for c in kept.cells]
    assert [kinds(c) for c in code(again)] == [kinds(c) for c in code(kept)]
    assert str(ROOT.parent) not in notebook.read_text(encoding="utf-8")


def test_the_first_axis_goes_from_a_frame_to_c_in_fifteen_lines() -> None:
    (notebook,) = [n for n in notebooks.NOTEBOOKS if n.stem == "first_axis"]
    cells = code(nbformat.read(notebook, as_version=4))  # type: ignore[no-untyped-call]
    lines = [line for cell in cells for line in cell.source.splitlines() if line.strip()]
    assert len(lines) == 15
    assert "pl.DataFrame(" in "\n".join(lines)
    assert TARGETS["c"].folder
    shown = [kinds(cell) for cell in cells]
    assert {"text/html", "text/plain"} in shown[1]  # the log
    assert {"text/html", "text/plain"} in shown[2]  # the fit
    assert {"image/png", "text/plain"} in shown[3]  # a figure
    assert "Friction of an axis: law stribeck" in cells[-1].outputs[0].text
