"""Conditions of the estimates: what becomes of them where one does not hold."""

from __future__ import annotations

from dataclasses import replace

from stribeck.friction import LAWS
from stribeck.identify.conditions import Violation, lowered, sentences
from stribeck.identify.parameters import Parameters, partition
from stribeck.identify.uncertainty.estimates import Estimate
from stribeck.rig import RIGS


def bed(tied: dict[str, str] | None = None) -> tuple[Parameters, tuple[Estimate, ...]]:
    """Parameters of a slide bed, all of them identified."""
    parameters = partition(RIGS["slide-bed"], LAWS["stribeck"], tied=tied)
    identified = Estimate("", 1.0, 0.01, 0.0, 0.98, 1.02, None, "identified", "N")
    return parameters, tuple(replace(identified, name=q.name) for q in parameters.every)


def verdicts(estimates: tuple[Estimate, ...]) -> dict[str, tuple[str, str]]:
    return {e.name: (e.verdict, e.reason) for e in estimates}


def test_a_violation_lowers_what_it_concerns_and_gives_the_reason() -> None:
    parameters, estimates = bed()
    violation = Violation("model", "viscous friction bends", frozenset({"F_V"}))
    judged = verdicts(lowered(parameters, estimates, [violation]))
    assert judged.pop("F_V") == ("weak", "model")
    assert set(judged.values()) == {("identified", "")}


def test_one_that_names_nothing_concerns_all_and_one_that_is_told_none() -> None:
    parameters, estimates = bed()
    every = lowered(parameters, estimates, [Violation("data", "a reset")])
    assert set(verdicts(every).values()) == {("weak", "data")}
    assert lowered(parameters, estimates, [Violation("data", "spikes", caps=False)]) == estimates


def test_the_first_is_the_reason_and_what_is_worse_stays() -> None:
    parameters, estimates = bed()
    blind = replace(estimates[0], verdict="not identifiable", reason="wide")
    found = [
        Violation("arithmetic", "a step"),
        Violation("data", "a gap"),
        Violation("data", "a gap"),
    ]
    judged = lowered(parameters, (blind, *estimates[1:]), found)
    assert (judged[0].verdict, judged[0].reason) == ("not identifiable", "wide")
    assert {e.reason for e in judged[1:]} == {"arithmetic"}
    assert sentences(found) == ["a step", "a gap"]


def test_a_tied_parameter_falls_with_the_other() -> None:
    parameters, estimates = bed({"F_C": "F_S"})
    judged = verdicts(lowered(parameters, estimates, [Violation("data", "x", frozenset({"F_S"}))]))
    assert judged["F_C"] == judged["F_S"] == ("weak", "data")


def test_a_width_near_the_limit_is_borderline() -> None:
    _, (e, *_) = bed()
    assert not e.borderline
    assert replace(e, low=0.91, high=1.09).borderline
    assert replace(e, low=0.89, high=1.05, verdict="weak", reason="wide").borderline
    assert not replace(e, low=0.5, high=1.5, verdict="weak", reason="wide").borderline
    assert not replace(e, low=0.91, high=1.09, verdict="weak", reason="data").borderline


def test_a_share_of_the_range_near_the_limit_is_borderline() -> None:
    """Two thirds of the search range make an interval say nothing; so do 0.67 and 0.66 of it."""
    parameters, estimates = bed()
    param = next(q for q in parameters.free if q.name == "F_C")
    e = replace(estimates[0], value=60.0, verdict="weak", reason="constants", searched=param)
    width = param.upper - param.lower

    def of(share: float, **changes: str) -> bool:
        low = param.lower + 0.1 * width
        return replace(e, low=low, high=low + share * width, **changes).borderline  # type: ignore[arg-type]

    assert of(0.6)
    assert of(0.7, verdict="not identifiable", reason="wide")
    assert not of(0.3)
    assert not of(0.88, verdict="not identifiable", reason="wide")
    assert not of(0.7, verdict="not identifiable", reason="rests on another")
