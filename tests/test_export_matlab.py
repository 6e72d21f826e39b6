"""MATLAB: every law has the same values in GNU Octave."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from exported import BUSY, DAHLS, VARIANTS, model_of, model_with, rude
from own_laws import AWKWARD, HOSTILE, UNKNOWN, own_law
from stribeck.compensate.compensator import Compensator
from stribeck.errors import InputError
from stribeck.export.code.check_vectors import check_vectors
from stribeck.export.code.matlab import matlab
from stribeck.export.model import Model
from stribeck.friction import LAWS
from stribeck.space import Array

OCTAVE = shutil.which("octave-cli") or shutil.which("octave")
needs_octave = pytest.mark.skipif(OCTAVE is None, reason="there is no GNU Octave here")
SPEEDS = (-0.3, -2e-3, 0.0, 1e-9, 0.05, 0.7, 3.0)

#: Walks the functions of a law through the rows of a file: v, v_ref, h, loads.
WALK = """
function walk(name)
rows = load([name '.txt']);
law = str2func(name);
compensator = str2func([name '_compensator']);
z = []; s = [];
said = zeros(size(rows, 1), 3);
for i = 1:size(rows, 1)
    r = rows(i, :);
    [said(i, 1), z] = law(r(1), r(3), z, r(4:8)');
    [said(i, 2), s] = compensator(r(2), r(1), r(3), s, r(4:8)');
    said(i, 3) = law(r(1));
end
f = fopen([name '.out'], 'w');
fprintf(f, '%.17g %.17g %.17g\\n', said');
fclose(f);
end
"""


def run(folder: Path, *names: str) -> dict[str, Array]:
    """Octave's results for laws and rows in a folder: friction, compensation, steady friction."""
    (folder / "walk.m").write_text(WALK)
    calls = "; ".join(f"walk('{name}')" for name in names)
    completed = subprocess.run(
        [str(OCTAVE), "--no-init-file", "--no-history", "--quiet", "--eval", calls],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )
    assert completed.returncode == 0, completed.stderr
    assert completed.stderr == ""
    return {name: np.loadtxt(folder / f"{name}.out", ndmin=2) for name in names}


def write_law(folder: Path, model: Model, name: str, rows: Array, compensator: Compensator) -> None:
    for file, text in matlab(model, name, compensator).items():
        (folder / file).write_bytes(text)
    np.savetxt(folder / f"{name}.txt", rows, fmt="%.17g")


@needs_octave
def test_octave_says_what_every_law_says(tmp_path: Path) -> None:
    cases: dict[str, tuple[Model, Any]] = {}
    for i, law in enumerate((*LAWS, *VARIANTS, *DAHLS)):
        model = model_of(law)
        for compensator, kind in ((BUSY, "busy"), (Compensator(feedback=False), "plain")):
            vectors = check_vectors(model, compensator, 128, seed=i)
            write_law(
                tmp_path,
                model,
                f"l{i}_{kind}",
                np.hstack([vectors.inputs, vectors.loads]),
                compensator,
            )
            cases[f"l{i}_{kind}"] = model, vectors
    for name, rows in run(tmp_path, *cases).items():
        model, vectors = cases[name]
        tolerance = 1e-9 if model.law.states else 1e-12
        for computed, expected in ((rows[:, 0], vectors.forces), (rows[:, 1], vectors.outputs)):
            worst = np.max(np.abs(computed - expected) / (np.abs(expected) + vectors.floor))
            assert worst < tolerance, (model.law.name, name)


@needs_octave
def test_steady_sliding_and_zeros_with_a_sign(tmp_path: Path) -> None:
    v = np.array([-0.0, 0.0, -0.02, 0.02])
    names = [n for n in LAWS if model_of(n).law.rub is None or model_of(n).law.states]
    for i, name in enumerate(names):
        rows = np.column_stack([v, v, np.full(4, 1e-3), np.zeros((4, 5))])
        write_law(tmp_path, model_of(name), f"l{i}", rows, BUSY)
    results = run(tmp_path, *(f"l{i}" for i in range(len(names))))
    for i, name in enumerate(names):
        model = model_of(name)
        expected = [model.law.slip(x, model.p) for x in v.tolist()]
        np.testing.assert_allclose(results[f"l{i}"][:, 2], expected, rtol=1e-12, err_msg=name)


@needs_octave
def test_awkward_python_and_the_words_of_the_language(tmp_path: Path) -> None:
    cases = {**AWKWARD, "hostile": HOSTILE}
    laws = {f"l{i}": own_law(function) for i, function in enumerate(cases.values())}
    rows = np.column_stack([SPEEDS, SPEEDS, np.full((7, 1), 1e-3), np.zeros((7, 5))])
    for name, law in laws.items():
        write_law(tmp_path, model_with(law), name, rows, BUSY)
    results = run(tmp_path, *laws)
    for case, (name, law) in zip(cases, laws.items(), strict=True):
        expected = [law.slip(v, model_with(law).p) for v in SPEEDS]
        np.testing.assert_allclose(
            results[name][:, 0], expected, rtol=1e-12, atol=1e-12, err_msg=case
        )


@needs_octave
def test_states_and_parameters_go_in_and_out(tmp_path: Path) -> None:
    model = model_of("maxwell-slip")
    for file, text in matlab(model).items():
        (tmp_path / file).write_bytes(text)
    script = (
        "[~, z, p] = friction(0); printf('%.17g ', z, p); p(9) = 2 * p(9);"
        "[F, z] = friction(1e-3, 1e-3, z, [], p); printf('%.17g ', F, z)"
    )
    completed = subprocess.run(
        [str(OCTAVE), "--no-init-file", "--no-history", "--quiet", "--eval", script],
        cwd=tmp_path, capture_output=True, text=True, check=True,
    )  # fmt: skip
    printed = np.array(completed.stdout.split(), float)
    p, states = model.p.copy(), np.zeros(4)
    np.testing.assert_array_equal(printed[:13], [0.0, 0.0, 0.0, 0.0, *p])
    p[8] *= 2.0
    rub: Any = model.law.rub
    force = rub(1e-3, 1e-3, np.zeros(4), np.zeros(5), p, states)
    np.testing.assert_allclose(printed[13:], [force, *states], rtol=1e-12)


def test_all_is_ascii_and_what_a_card_says_stays_in_its_comment() -> None:
    files = matlab(rude(model_of("stribeck", warnings=["%{", "−1\nF = 0;", "%}"])))
    assert list(files) == ["friction.m", "friction_compensator.m"]
    for text in files.values():
        assert text.isascii()
    head = files["friction.m"].decode().partition("if nargin")[0].splitlines()
    assert all(line.startswith("%   ") or line == "%" for line in head[1:])
    assert any("F = 0;" in line for line in head)


@pytest.mark.parametrize("name", ["1st", "a-b", "end", "exp", "p", "_a", "", "x" * 50])
def test_a_name_that_matlab_does_not_take(name: str) -> None:
    with pytest.raises(InputError, match="MATLAB takes letters") as refused:
        matlab(model_of("stribeck"), name)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("case", list(UNKNOWN))
def test_what_cannot_be_translated_is_refused_with_its_line(case: str) -> None:
    with pytest.raises(InputError, match=r"line \d+: `"):
        matlab(model_with(own_law(UNKNOWN[case], compiled=False)))
