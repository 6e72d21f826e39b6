"""Positions that creep, in fits of laws with states, on logs of a foreign simulator."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from numpy.random import default_rng

from foreign import presliding, sensors
from foreign.clock import Array
from foreign.strokes import even
from stribeck import Recording, identify

TRUTH = {"sigma_0": 1.2e6, "F_C": 14.0, "M": 15.0, "offset": 0.5}
T = even(4.0, 2e-3)


@cache
def motion() -> Any:
    force = 2.0 + (1.0 + 3.0 * T) * np.sin(2.0 * np.pi * 1.5 * T)
    law = presliding.dahl(1.2e6, 14.0, 50.0)
    return presliding.simulate(15.0, law, T, force, offset=0.5, dt=2e-3)


def fitted(creep: Array, seed: int = 0) -> Any:
    table = motion()._asdict()
    table = table | {"position": table["position"] + creep}
    table = sensors.noisy(table, "position", 0.4e-6, default_rng(seed))
    log = Recording(table["t"], table["position"], force=table["force"])
    bounds = {"M": (1.0, 100.0), "F_C": (8.0, 20.0)}
    return identify(log, rig="presliding", law="dahl", repeats=1, budget=2000, bounds=bounds)


def told(fit: Any) -> list[str]:
    return [v.sentence for v in fit.violations if "the measured position drifts" in v.sentence]


@pytest.mark.parametrize(
    "creep",
    [4e-6 * np.sin(2.0 * np.pi * 0.06 * T), 1e-6 * np.log1p(T / 0.05), -4e-6 * T / T[-1]],
    ids=["slow wave", "logarithm", "line"],
)
def test_creep_is_told_and_what_it_biases_is_not_identified(creep: Array) -> None:
    fit = fitted(creep)
    (sentence,) = told(fit)
    J, before = (float(sentence.split(word)[1].split()[0].strip(",")) for word in ("J is", "not"))
    assert pytest.approx(0.4, rel=0.06) == J
    assert before == pytest.approx(fit.score.value, rel=0.01)
    assert "train on shorter parts" in sentence
    for e in fit.estimates:
        if e.verdict == "identified" and not e.low <= TRUTH[e.name] <= e.high:
            assert abs(e.value / TRUTH[e.name] - 1) < 0.03


@pytest.mark.parametrize("seed", range(3))
def test_what_does_not_creep_has_no_drift(seed: int) -> None:
    assert not told(fitted(np.zeros_like(T), seed))
