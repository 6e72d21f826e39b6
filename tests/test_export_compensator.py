"""The compensator has one source: a change of its Python changes every export."""

from __future__ import annotations

import importlib.util
import inspect
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from exported import SHAPED, model_of
from st_interpreter import Controller
from stribeck.compensate import compensator
from stribeck.export.code import check_vectors, law_program
from stribeck.export.targets import TARGETS, export

CC = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
#: Targets that have the compensator, and what makes them.
CODE = [name for name, target in TARGETS.items() if "compensation" in target.options]
#: A law without and one with states, one with loads and terms.
MODELS = ("stribeck", "lugre", "bam-m4+temperature+position")


def loaded(folder: Path, old: str, new: str, monkeypatch: pytest.MonkeyPatch) -> Any:
    """The compensator's module with a change in its text."""
    text = inspect.getsource(compensator).replace("from ..", "from stribeck.")
    assert text.count(old) == 1
    path = folder / "changed_compensator.py"
    path.write_text(text.replace(old, new).replace("cache=True, ", ""))
    spec = importlib.util.spec_from_file_location(path.stem, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, path.stem, module)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(params=["the velocity", "the friction", "the shape"])
def changed(request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """A change in each of the compensator's functions, in effect for a test."""
    old, new = {
        "the velocity": ("return min(max(v, -c", "return 2.0 * min(max(v, -c"),
        "the friction": ("shaped_output(force, v_ref, h", "shaped_output(3.0 * force, v_ref, h"),
        "the shape": ("out = c[SCALE] * share", "out = 0.5 * c[SCALE] * share"),
    }[request.param]
    function = loaded(tmp_path, old, new, monkeypatch).compensator_output
    monkeypatch.setattr(law_program, "compensator_output", function)
    monkeypatch.setattr(check_vectors, "compensator_output", function)
    return str(request.param)


@pytest.fixture(scope="module")
def before() -> dict[tuple[str, str], dict[str, bytes]]:
    """Every export of the models with the compensator unchanged."""
    return {(law, to): files(law, to) for law in MODELS for to in CODE}


def files(law: str, to: str) -> dict[str, bytes]:
    return export(model_of(law), to, compensation=SHAPED).files


def test_a_change_is_in_every_export(
    before: dict[tuple[str, str], dict[str, bytes]], changed: str
) -> None:
    for (law, to), original in before.items():
        changed_files = files(law, to)
        assert changed_files.keys() == original.keys()
        assert any(changed_files[name] != original[name] for name in original), (law, to, changed)


@pytest.mark.skipif(CC is None, reason="there is no C compiler here")
@pytest.mark.parametrize("law", MODELS)
def test_exported_c_computes_the_change(law: str, changed: str, tmp_path: Path) -> None:
    del changed  # the self-test's numbers are those of the changed Python
    for name, text in files(law, "c").items():
        (tmp_path / name).write_bytes(text)
    command = [str(CC), "-std=c99", "friction.c", "selftest.c", "-lm", "-o", "t"]
    subprocess.run(command, cwd=tmp_path, check=True)
    completed = subprocess.run([tmp_path / "t"], capture_output=True, text=True, check=False)
    assert completed.stdout == "0 of 256 rows differ\n"


def test_structured_text_computes_the_change(
    before: dict[tuple[str, str], dict[str, bytes]], changed: str
) -> None:
    del changed
    moving = {"v_ref": 1e-2, "v": 2e-2, "h": 1e-3, "slew": 0.0}
    outputs = []
    for text in (before["stribeck", "st"], files("stribeck", "st")):
        block = Controller(text["Friction.st"].decode()).instance("Friction_compensator")
        block(**moving)
        outputs.append(block.output("u"))
    assert outputs[0] != outputs[1]


def test_code_for_a_controller_compiles_no_stepper() -> None:
    code = (
        "import sys\n"
        "from exported import model_of\n"
        "from stribeck.export.targets import export\n"
        "export(model_of('stribeck').card, 'st')\n"
        "print(*sys.modules)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], check=True, capture_output=True, text=True,
        cwd=Path(__file__).parent,
    )  # fmt: skip
    loaded = set(done.stdout.split())
    assert "stribeck.export.code.st" in loaded
    steppers = {"stribeck.compensate.closed_loop", "stribeck.rig.motion.implicit"}
    assert not steppers & loaded, "minutes of compiling before a text is printed"
