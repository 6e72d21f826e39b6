"""The card: a fit returns from JSON unchanged, and a malformed card is refused."""

import copy
import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from stribeck import RIGS, Card, Fit, InputError, identify, problem, read_card, simulate
from stribeck.export.model import as_model
from stribeck.identify.card import kind_of
from stribeck.identify.conditions import Violation
from stribeck.identify.problem import MotionProblem
from stribeck.identify.score import scores
from stribeck.rig.custom import rig_file
from stribeck.rig.twin import TestBed

LOG = TestBed().run("both", seed=4).recording


def quick(**options: Any) -> Fit:
    return identify(LOG, budget=40, repeats=2, **{"rig": "slide-bed", **options})


FIT = quick(train="112:295", holdout="352:325")


def test_conditions_that_do_not_hold_are_on_the_card() -> None:
    names = frozenset({"F_C", "F_V"})
    violations = (
        Violation("model", "friction bends with speed", names),
        Violation("data", "spikes", caps=False),
    )
    (weak, *others) = FIT.estimates
    judged = (replace(weak, verdict="weak", reason="model"), *others)
    written = replace(FIT, violations=violations, estimates=judged).card()
    data = json.loads(written.text())
    assert data["conditions"] == [
        {"condition": "model", "sentence": "friction bends with speed",
         "parameters": ["F_C", "F_V"], "caps": True},
        {"condition": "data", "sentence": "spikes", "parameters": None, "caps": False},
    ]  # fmt: skip
    assert Card.model_validate(data) == written
    assert written.parameters[weak.name].verdict_text == "weak (model)"
    assert "weak (model)" in "\n".join(as_model(written).head())


def test_a_log_of_an_angle_is_no_log_of_a_slides_card() -> None:
    message = "position is an angle, and rig slide-bed is linear: take a log of that rig"
    with pytest.raises(InputError, match=message):
        simulate(FIT, replace(LOG, rotary=True))


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"law": "stribeck-directional"},
        {"law": "coulomb-viscous"},
        {"rig": RIGS["slide-bed"].set(m=12.5, F_fm=20.0)},
        {"rig": RIGS["slide-bed"].set(l=4.0, eta_b=0.7)},
        {"fixed": {"F_S": 150.0}},
        {"bounds": {"exponent": (0.5, 2.0)}},
        {"law": "stribeck-directional", "tie": {"F_C-": "F_C+"}},
    ],
    ids=["plain", "directional", "coulomb", "mass", "gear", "held", "exponent", "tied"],
)
def test_a_card_is_the_model_that_was_fitted(options: Any, tmp_path: Path) -> None:
    fit = quick(train="112:295", **options)
    file = tmp_path / "card.json"
    file.write_text(fit.card().text(), encoding="utf-8")
    read_back = read_card(file)
    assert read_back == fit.card()
    parameters, p = read_back.model()
    np.testing.assert_allclose(p, fit.p, rtol=1e-14)
    assert scores(parameters, p, fit.train).value == pytest.approx(fit.score.value, rel=1e-12)
    # What is searched is summed in another order (prefix sums over rests): not bit for bit.
    cost = MotionProblem(parameters, fit.train)(
        p[[-1]][None]
    )  # the one parameter that is left free
    assert cost[0] == pytest.approx(fit.score.value, rel=1e-9)


def test_a_fit_on_the_inverse_road_has_a_card_too(tmp_path: Path) -> None:
    fit = identify(LOG, rig="forced", law="coulomb-viscous")
    file = tmp_path / "card.json"
    file.write_text(fit.card().text(), encoding="utf-8")
    read_back = read_card(file)
    assert read_back == fit.card()
    assert read_back.objective.name == "relative_error"
    np.testing.assert_allclose(read_back.model()[1], fit.p, rtol=1e-14)


def test_numbers_are_in_the_unit_beside_them() -> None:
    parameters = FIT.card().parameters
    assert {n: q.unit for n, q in parameters.items()} == {
        "F_S": "N", "F_C": "N", "F_V": "N s/mm", "v_SS": "mm/s", "k_spring": "N/mm",
    }  # fmt: skip
    assert parameters["v_SS"].value == pytest.approx(FIT.values["v_SS"] * 1e3, rel=1e-14)
    assert parameters["F_V"].value == pytest.approx(FIT.values["F_V"] / 1e3, rel=1e-14)
    assert parameters["k_spring"].value == pytest.approx(FIT.values["k_spring"] / 1e3, rel=1e-14)


def test_another_unit_of_the_same_kind_is_the_same_value() -> None:
    data = json.loads(FIT.card().text())
    q = data["parameters"]["v_SS"]
    q["value"], q["unit"] = q["value"] / 10.0, "cm/s"
    np.testing.assert_allclose(Card.model_validate(data).model()[1], FIT.p, rtol=1e-12)


def test_the_training_cost_can_be_asked_again() -> None:
    cost = problem(LOG, rig=FIT.rig, train="112:295")(FIT.p[[0, 1, 2, 3, 5]][None])
    assert cost[0] == pytest.approx(FIT.card().objective.value, rel=1e-9)


@pytest.mark.parametrize("name", RIGS)
def test_a_variant_knows_what_it_is_a_variant_of(name: str, tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    file.write_text(f'kind = "{name}"\n')
    assert kind_of(RIGS[name]) == name
    assert kind_of(rig_file(file)) == name


VALUES = st.one_of(
    st.none(), st.booleans(), st.integers(-(10**20), 10**20), st.floats(), st.text(max_size=8),
    st.sampled_from(["mm", "N", "kg/s", "stribeck", "slide-bed", "forced", "nan", "1e400"]),
    st.lists(st.integers(), max_size=2),
    st.dictionaries(st.text(max_size=3), st.floats(), max_size=2),
)  # fmt: skip


def places(value: Any, at: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Every place in a JSON value."""
    inside: list[Any] = []
    if isinstance(value, dict):
        inside = list(value.items())
    elif isinstance(value, list):
        inside = list(enumerate(value))
    return [at] * bool(at) + [p for key, part in inside for p in places(part, (*at, key))]


PLAIN = json.loads(FIT.card().text())
PLAIN["constants"] = {"m": {"value": 11.0, "unit": "kg"}}


@settings(max_examples=300, suppress_health_check=[HealthCheck.too_slow])
@given(data=st.data())
def test_an_edited_card_is_a_card_or_one_line(
    data: st.DataObject, tmp_path_factory: pytest.TempPathFactory
) -> None:
    edited = copy.deepcopy(PLAIN)
    for _ in range(data.draw(st.integers(1, 3))):
        *parents, last = data.draw(st.sampled_from(places(edited)))
        parent = edited
        for key in parents:
            parent = parent[key]
        if data.draw(st.booleans()):
            parent[last] = data.draw(VALUES)
        else:
            del parent[last]
    file = tmp_path_factory.getbasetemp() / "edited.json"
    file.write_text(json.dumps(edited), encoding="utf-8", errors="replace")
    try:
        parameters, p = read_card(file).model()
    except InputError as error:
        assert "\n" not in str(error)  # noqa: PT017 - either way is right, nothing else is
        return
    assert np.isfinite(p).all()
    assert bool(parameters.law.physical(p[None, : len(parameters.law.params)])[0])


@given(text=st.binary(max_size=60))
@settings(max_examples=100)
def test_bytes_that_are_no_card(text: bytes, tmp_path_factory: pytest.TempPathFactory) -> None:
    file = tmp_path_factory.getbasetemp() / "bytes.json"
    file.write_bytes(text)
    with pytest.raises(InputError, match=r"not a card|not UTF-8"):
        read_card(file)


def test_a_repeat_that_could_not_be_simulated_has_no_cost_on_the_card() -> None:
    best, *_ = FIT.search.polished
    search = replace(FIT.search, polished=(best, replace(best, cost=math.inf)))
    assert replace(FIT, search=search).card().search.repeats == [best.cost]


def test_a_card_has_no_number_that_json_has_not() -> None:
    def refuse(word: str) -> float:
        raise AssertionError(word)

    json.loads(FIT.card().text(), parse_constant=refuse)
    assert any(math.isnan(e.spread) for e in FIT.estimates)  # there was one to leave out
