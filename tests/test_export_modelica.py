"""Modelica: every law has the same values there."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from pymoca import parser

from exported import BUSY, DAHLS, VARIANTS, model_of, model_with, rude
from modelica_interpreter import Block, ModelicaError, Package
from own_laws import AWKWARD, HOSTILE, UNKNOWN, own_law
from stribeck.compensate.compensator import Compensator
from stribeck.errors import InputError
from stribeck.export.code.check_vectors import CheckVectors, check_vectors
from stribeck.export.code.modelica import modelica
from stribeck.export.model import Model
from stribeck.friction import LAWS, LOADS


def text_of(model: Model, compensator: Compensator | None = None) -> str:
    return modelica(model, compensator=compensator)["Friction.mo"].decode("ascii")


def walked(
    model: Model, block: Block, vectors: CheckVectors, output: str, *, reference: bool
) -> list[float]:
    """An output of a block at the instants of a walk whose sample times are the block's h."""
    read = (*model.law.loads, *model.law.terms)
    values = []
    for (v, v_ref, h), row in zip(vectors.inputs.tolist(), vectors.loads.tolist(), strict=True):
        if "h" in block.values:
            block.values["h"] = h
        loads = {f"load_{x}": row[i] for i, x in enumerate(LOADS) if x in read}
        block.step(v=v, **({"v_ref": v_ref} if reference else {}), **loads)
        values.append(block.values[output])
    return values


def agrees(model: Model, computed: list[float], expected: Any, floor: float) -> None:
    tolerance = 1e-9 if model.law.states else 1e-12
    np.testing.assert_array_less(
        np.abs(computed - expected), tolerance * (np.abs(expected) + floor)
    )


@pytest.mark.parametrize("name", [*LAWS, *VARIANTS, *DAHLS])
def test_the_blocks_say_what_the_law_says(name: str) -> None:
    model = model_of(name)
    for seed, compensator in enumerate((BUSY, Compensator(feedback=False))):
        vectors = check_vectors(model, compensator, 200, seed)
        package = Package(text_of(model, compensator), "Friction")
        law = walked(model, Block(package, "Law"), vectors, "force", reference=False)
        agrees(model, law, vectors.forces, vectors.floor)
        u = walked(model, Block(package, "Compensator"), vectors, "u", reference=True)
        agrees(model, u, vectors.outputs, vectors.floor)


@pytest.mark.parametrize(
    ("name", "law", "function"), [("expm1", "lugre", math.expm1), ("log1p", "dahl", math.log1p)]
)
def test_own_mathematics_is_right_to_the_last_places(
    name: str, law: str, function: Callable[[float], float]
) -> None:
    package = Package(text_of(model_of(law)), "Friction")
    small = 10.0 ** np.linspace(-20.0, math.log10(0.999), 400)
    for x in (*small.tolist(), *(-small).tolist(), 0.0, 0.25, -0.25, 0.5, -0.5):
        (value,) = package.call(name, [x])
        assert value == pytest.approx(function(x), rel=2e-15 if abs(x) < 0.5 else 4e-15, abs=0.0), x


def test_a_law_with_states_is_sampled_at_the_end_of_each_span() -> None:
    package = Package(text_of(model_of("dahl")), "Friction")
    assert Block(package, "Law", h=2e-3).sampled() == [2e-3, 2e-3]
    assert Block(package, "Compensator", h=2e-3).sampled() == [0.0, 2e-3]


def test_parameters_can_be_changed() -> None:
    model = model_of("stribeck")
    package = Package(text_of(model), "Friction")
    as_found, changed = Block(package, "Law"), Block(package, "Law", F_V=0.0)
    for block in (as_found, changed):
        block.step(v=0.05)
    viscous = model.p[2] * 0.05
    difference = as_found.values["force"] - changed.values["force"]
    assert difference == pytest.approx(viscous, rel=1e-12)
    with pytest.raises(ModelicaError, match="has no"):
        Block(package, "Law", F_X=1.0)


@pytest.mark.parametrize("case", list(AWKWARD))
def test_awkward_python_keeps_its_meaning(case: str) -> None:
    law = own_law(AWKWARD[case])
    block = Block(Package(text_of(model_with(law)), "Friction"), "Law")
    for v in (-0.3, -2e-3, 0.0, 1e-9, 0.05, 0.7, 3.0):
        block.step(v=v)
        expected = law.slip(v, model_with(law).p)
        assert block.values["force"] == pytest.approx(expected, rel=1e-12, abs=1e-12), v


def test_names_that_are_words_of_the_language() -> None:
    law = own_law(HOSTILE)
    block = Block(Package(text_of(model_with(law)), "Friction"), "Law")
    for v in (-0.02, 0.0, 0.3):
        block.step(v=v)
        expected = law.slip(v, model_with(law).p)
        assert block.values["force"] == pytest.approx(expected, rel=1e-12)


def test_no_string_ends_early_and_all_is_ascii() -> None:
    text = text_of(rude(model_of("coulomb-viscous")))
    assert text.isascii()
    assert list(parser.parse(text).classes)[-1] == "Friction"
    assert 'rig Fuhrung -1 *) (* */ /* ]]&gt; &lt;b&gt; &amp; \\" \\\\ \\\\\\"' in text


@pytest.mark.parametrize("name", [*LAWS, "calls", "conditions"])
def test_no_sign_stands_behind_an_operator(name: str) -> None:
    """The language has `a * (-b)` alone, which pymoca's grammar does not insist on."""
    model = model_of(name) if name in LAWS else model_with(own_law(AWKWARD[name]))
    code = text_of(model).partition("  annotation(")[0]
    assert re.findall(r"[-+*/^] -", re.sub(r'"[^"\n]*"', "", code)) == []


@pytest.mark.parametrize("name", ["1st", "a-b", "end", "Real", "v", "_a", "", "x" * 70])
def test_a_name_that_modelica_does_not_take(name: str) -> None:
    with pytest.raises(InputError, match="Modelica takes letters") as refused:
        modelica(model_of("stribeck"), name)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("case", list(UNKNOWN))
def test_what_cannot_be_translated_is_refused_with_its_line(case: str) -> None:
    with pytest.raises(InputError, match=r"line \d+: `"):
        modelica(model_with(own_law(UNKNOWN[case], compiled=False)))
