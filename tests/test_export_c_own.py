"""C99 of laws outside the tables: awkward Python, and words of C in names and comments."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

from exported import model_with, rude
from own_laws import AWKWARD, HOSTILE, UNKNOWN, WIDE, own_law
from stribeck.errors import InputError
from stribeck.export.code.c import c, c_functions
from stribeck.export.code.function_source import FunctionSource
from stribeck.export.code.lowering import Restrictions, lowered
from stribeck.export.code.matlab import matlab
from stribeck.export.code.modelica import modelica
from stribeck.export.code.st import st
from stribeck.export.code.translation import translate
from stribeck.export.model import Model
from stribeck.space import Array

CC = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
STRICT = ("-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wshadow", "-Werror")
CASES = {**AWKWARD, "hostile": HOSTILE, **WIDE}


@pytest.mark.skipif(CC is None, reason="there is no C compiler here")
@pytest.mark.parametrize("case", list(CASES))
def test_its_self_test_passes(case: str, tmp_path: Path) -> None:
    for file, text in c(rude(model_with(own_law(CASES[case])))).items():
        (tmp_path / file).write_bytes(text)
    command = [str(CC), *STRICT, "friction.c", "selftest.c", "-lm", "-o", "t"]
    build = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert build.returncode == 0, build.stderr
    run = subprocess.run([tmp_path / "t"], capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stdout
    assert run.stdout == "0 of 256 rows differ\n"


@pytest.mark.parametrize("case", list(UNKNOWN))
def test_what_cannot_be_translated_is_refused_with_its_line(case: str) -> None:
    with pytest.raises(InputError, match=r"line \d+: `") as refused:
        c(model_with(own_law(UNKNOWN[case], compiled=False)))
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("case", list(WIDE))
@pytest.mark.parametrize("language", [matlab, modelica, st])
def test_what_only_c_is_told_other_languages_refuse(
    language: Callable[[Model], object], case: str
) -> None:
    with pytest.raises(InputError, match="only C is told") as refused:
        language(model_with(own_law(WIDE[case])))
    assert "\n" not in str(refused.value)


def _moved_on(mode: Array, before: Array) -> int:
    """Whole numbers in arrays, one of which is known."""
    before[:] = mode
    for side in (0, 1):
        if mode[side] == 0:
            mode[side] = 1 if mode[2] > 0 else -1
    return int(mode[0] + before[0])


def test_arrays_of_whole_numbers_are_what_only_c_is_told() -> None:
    lengths: dict[str, int | tuple[int, int]] = {"mode": 3, "before": 3}
    source = FunctionSource("moved_on", _moved_on, lengths, None, known={"mode": {2: 5}},
                            whole=("mode", "before"))  # fmt: skip
    text = c_functions([source], "a test", "test_")
    assert "int test_moved_on(int *mode, int *before)" in text
    assert "mode[1] = 1;" in text
    with pytest.raises(InputError, match=r"arrays of whole numbers .* are what only C is told"):
        lowered(translate([source], "a test"), Restrictions())
