"""Structured Text: every law has the same values on a controller."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest

from exported import BUSY, DAHLS, VARIANTS, model_of, model_with, rude
from own_laws import AWKWARD, HOSTILE, UNKNOWN, own_law
from st_interpreter import Controller, Instance
from st_parser import IecError, parsed
from stribeck.compensate.compensator import SETTINGS, Compensator
from stribeck.errors import InputError
from stribeck.export.code.check_vectors import CheckVectors, check_vectors, walk
from stribeck.export.code.st import st
from stribeck.export.model import Model
from stribeck.friction import LAWS, LOADS

PLAIN = Compensator(feedback=False)


@cache
def text_of(name: str) -> str:
    return st(model_of(name))["Friction.st"].decode("ascii")


def loads_of(model: Model, row: Any) -> dict[str, float]:
    read = (*model.law.loads, *model.law.terms)
    return {f"load_{x}": float(row[i]) for i, x in enumerate(LOADS) if x in read}


def law_on(block: Instance, model: Model, vectors: CheckVectors) -> list[float]:
    """The forces of the law's block over the rows of a walk."""
    forces = []
    for (v, _, h), loads in zip(vectors.inputs.tolist(), vectors.loads, strict=True):
        block(v=v, **({"h": h} if model.law.states else {}), **loads_of(model, loads))
        forces.append(block.output("force"))
    return forces


def compensator_on(block: Instance, model: Model, vectors: CheckVectors) -> list[float]:
    outputs = []
    for (v, v_ref, h), loads in zip(vectors.inputs.tolist(), vectors.loads, strict=True):
        block(v=v, v_ref=v_ref, h=h, **loads_of(model, loads))
        outputs.append(block.output("u"))
    return outputs


def settings_of(compensator: Compensator) -> dict[str, float | bool]:
    named = {s.name: float(getattr(compensator, s.name)) for s in SETTINGS}
    named["largest"] = named.pop("limit")
    return {**named, "feedback": compensator.feedback}


def agrees(model: Model, computed: list[float], expected: Any, floor: float) -> None:
    tolerance = 1e-9 if model.law.states else 1e-12
    np.testing.assert_array_less(
        np.abs(computed - expected), tolerance * (np.abs(expected) + floor)
    )


@pytest.mark.parametrize("name", [*LAWS, *VARIANTS, *DAHLS])
def test_a_controller_says_what_the_law_says(name: str) -> None:
    model, controller = model_of(name), Controller(text_of(name))
    for compensator, rows, seed in ((PLAIN, 256, 0), (BUSY, 600, 1)):
        vectors = check_vectors(model, compensator, rows, seed)
        agrees(
            model,
            law_on(controller.instance("Friction"), model, vectors),
            vectors.forces,
            vectors.floor,
        )
        block = controller.instance("Friction_compensator")
        if compensator is BUSY:
            with pytest.raises(IecError, match="no input"):
                block(limit=1.0)
            block(enable=False, **settings_of(compensator))
            assert block.output("u") == 0.0
            block(enable=True)
            block = controller.instance("Friction_compensator")
            for key, value in settings_of(compensator).items():
                block.write(key, value)
        agrees(model, compensator_on(block, model, vectors), vectors.outputs, vectors.floor)


@pytest.mark.parametrize("name", ["lugre", "elasto-plastic", "gms", "stribeck", "bam-m4"])
def test_a_smooth_motion_with_reversals(name: str) -> None:
    model, controller = model_of(name), Controller(text_of(name))
    t = 1e-3 * np.arange(800)
    v = 2e-3 * np.sin(2 * np.pi * 2.5 * t) + 4e-4 * np.sin(2 * np.pi * 31.0 * t)
    loads = np.column_stack([20.0 * np.sin(3.0 * t), 5.0 * np.cos(7.0 * t), *np.ones((3, 800))])
    vectors = walk(model, BUSY, np.column_stack([v, v, np.full(800, 1e-3)]), loads)
    agrees(
        model,
        law_on(controller.instance("Friction"), model, vectors),
        vectors.forces,
        vectors.floor,
    )


@pytest.mark.parametrize(
    ("name", "law", "function"),
    [
        ("expm1", "lugre", math.expm1),
        ("log1p", "dahl", math.log1p),
        ("tanh", "makkar", math.tanh),
    ],
)
def test_own_mathematics_is_right_to_the_last_places(
    name: str, law: str, function: Callable[[float], float]
) -> None:
    controller = Controller(text_of(law))
    small = 10.0 ** np.linspace(-20.0, math.log10(0.999), 400)
    large = [] if name == "log1p" else [-700.0, -21.0, -20.0, 20.0, 21.0, 300.0]
    for x in (*small.tolist(), *(-small).tolist(), 0.0, 0.25, -0.25, 0.5, -0.5, *large):
        value = controller.call(f"Friction_{name}", float(x))
        assert value == pytest.approx(function(x), rel=2e-15 if abs(x) < 0.5 else 4e-15, abs=0.0), x


def test_parameters_are_the_identified_ones_and_can_be_retuned() -> None:
    model = model_of("stribeck")
    block = Controller(text_of("stribeck")).instance("Friction")
    assert [block.value(n) for n, _ in model.named()] == model.p.tolist()
    block(v=1e-3)
    before = block.output("force")
    block.write("F_C", float(model.p[1]) + 10.0)
    block.write("F_S", float(model.p[0]) + 10.0)
    block(v=1e-3)
    assert block.output("force") == pytest.approx(before + 10.0, rel=1e-12)


def test_settings_stand_in_the_text() -> None:
    text = st(model_of("stribeck"), compensator=BUSY)["Friction.st"].decode()
    block = Controller(text).instance("Friction_compensator")
    assert {k: block.value(k) for k in settings_of(BUSY)} == settings_of(BUSY)


def test_states_are_kept_relaxed_and_left_alone() -> None:
    block = Controller(text_of("lugre")).instance("Friction")
    block(v=1e-3, h=1e-4)
    first = block.output("force")
    block(v=1e-3, h=1e-4)
    assert block.output("force") > first
    states = list(block.value("z"))
    block(v=1e-3, h=1e-4, steady=True)
    model = model_of("lugre")
    assert block.output("force") == pytest.approx(model.law.slip(1e-3, model.p), rel=1e-12)
    assert block.value("z") == states
    block(v=1e-3, h=1e-4, steady=False, reset=True)
    assert block.output("force") == first


def test_a_disabled_compensator_forgets() -> None:
    block = Controller(text_of("lugre")).instance("Friction_compensator")
    moving = {"v_ref": 1e-2, "v": 1e-2, "h": 1e-4}
    block(**moving)
    first = block.output("u")
    block(**moving)
    assert block.output("u") != first
    block(enable=False)
    assert block.output("u") == 0.0
    block(enable=True, **moving)
    assert block.output("u") == first


def test_two_instances_share_nothing() -> None:
    controller = Controller(text_of("dahl"))
    first, second = controller.instance("Friction"), controller.instance("Friction")
    first(v=1e-3, h=1e-3)
    second(v=-1e-3, h=1e-3)
    assert first.output("force") == -second.output("force")


@pytest.mark.parametrize("case", list(AWKWARD))
def test_awkward_python_keeps_its_meaning(case: str) -> None:
    law = own_law(AWKWARD[case])
    controller = Controller(st(model_with(law))["Friction.st"].decode())
    block = controller.instance("Friction")
    for v in (-0.3, -2e-3, 0.0, 1e-9, 0.05, 0.7, 3.0):
        block(v=v)
        expected = law.slip(v, model_with(law).p)
        assert block.output("force") == pytest.approx(expected, rel=1e-12, abs=1e-12), v


@pytest.mark.parametrize("name", [*LAWS, "calls", "conditions"])
def test_no_sign_stands_behind_an_operator(name: str) -> None:
    """Some compilers do not read `a * -b`, though the standard's grammar has it."""
    model = model_of(name) if name in LAWS else model_with(own_law(AWKWARD[name]))
    code = re.sub(r"\(\*.*?\*\)", "", st(model)["Friction.st"].decode(), flags=re.DOTALL)
    assert re.findall(r"[-+*/] (?:LREAL#)?-", code) == []


def test_names_that_are_words_of_the_language() -> None:
    law = own_law(HOSTILE)
    text = st(model_with(law))["Friction.st"].decode()
    block = Controller(text).instance("Friction")
    for v in (-0.02, 0.0, 0.3):
        block(v=v)
        assert block.output("force") == pytest.approx(law.slip(v, model_with(law).p), rel=1e-12)


def test_no_comment_ends_early_and_all_is_ascii() -> None:
    text = st(rude(model_of("coulomb-viscous", warnings=["ends *) here, (* begins"])))[
        "Friction.st"
    ]
    assert text.isascii()
    names = [unit.name for unit in parsed(text.decode())]
    assert names[-2:] == ["Friction", "Friction_compensator"]
    assert "rig Fuhrung -1 * ) ( * * / / * ]]>" in text.decode()


@pytest.mark.parametrize(
    "name", ["1st", "a__b", "_a", "a_", "FOR", "limit", "Axis-1", "", "v", "x" * 30]
)
def test_a_name_that_a_controller_does_not_take(name: str) -> None:
    with pytest.raises(InputError, match="a controller takes letters") as refused:
        st(model_of("stribeck"), name)
    assert "\n" not in str(refused.value)


def test_units_are_called_after_the_name() -> None:
    text = st(model_of("lugre"), "Axis_X")
    controller = Controller(text["Axis_X.st"].decode())
    assert all(name.startswith("axis_x") for name in controller.units)


@pytest.mark.parametrize("case", list(UNKNOWN))
def test_what_cannot_be_translated_is_refused_with_its_line(case: str) -> None:
    with pytest.raises(InputError, match=r"line \d+: `") as refused:
        st(model_with(own_law(UNKNOWN[case], compiled=False)))
    assert "\n" not in str(refused.value)
