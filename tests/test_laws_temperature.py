"""Laws whose levels and viscosity depend on temperature, each by its own."""

from __future__ import annotations

import math

import numpy as np
import pytest

from stribeck import LAWS, InputError, Recording, identify
from stribeck.friction import LOADS
from stribeck.space import Array

NAMES = ("coulomb-viscous-temperature", "stribeck-temperature")
SETS = {
    "coulomb-viscous-temperature": np.array([12.0, 400.0, -0.004, 0.03, 293.15]),
    "stribeck-temperature": np.array([20.0, 12.0, 400.0, 0.02, 1.0, -0.004, 0.03, 293.15]),
}
every = pytest.mark.parametrize("name", NAMES)


def friction(name: str, v: float, T: float, other: float = 0.0) -> float:
    """At a temperature, the other loads all at one value."""
    load = np.full(len(LOADS), other)
    load[LOADS.index("temperature")] = T
    none = np.zeros(0)
    return float(LAWS[name].rub(v, 1e-3, none, load, SETS[name], none))


@every
@pytest.mark.parametrize("v", [0.0, -0.0, 1e-3, -0.02, 0.1])
def test_at_its_reference_it_is_the_law_without_temperature(name: str, v: float) -> None:
    assert friction(name, v, 293.15, other=7.0) == LAWS[name].slip(v, SETS[name])


@every
def test_levels_and_viscosity_have_factors_of_their_own(name: str) -> None:
    rise = 25.0
    level = friction(name, 0.0, 293.15)
    warm_level = friction(name, 0.0, 293.15 + rise)
    assert math.isclose(warm_level, level * (1.0 - 0.004 * rise), rel_tol=1e-12)
    fast = 50.0  # no drop is left
    viscous = friction(name, fast, 293.15 + rise) - 12.0 * (1.0 - 0.004 * rise)
    assert math.isclose(viscous, 400.0 * math.exp(-0.03 * rise) * fast, rel_tol=1e-12)
    assert friction(name, 1e-30, 2000.0) >= 0.0  # friction drives nothing


def motion() -> tuple[Array, Array, Array, Array, Array]:
    """Two minutes to and fro at speeds up to 0.3 m/s, while the axis warms by 20 K."""
    t = np.arange(0.0, 120.0, 2e-3)
    w = 2 * np.pi * np.array([0.11, 0.37])
    size = np.array([[0.25], [0.06]])
    x = (size * np.sin(np.outer(w, t))).sum(axis=0)
    v = (size * w[:, None] * np.cos(np.outer(w, t))).sum(axis=0)
    a = -(size * (w**2)[:, None] * np.sin(np.outer(w, t))).sum(axis=0)
    return t, x, v, a, 293.15 + 20.0 * (1.0 - np.exp(-t / 40.0))


def test_a_log_of_an_axis_that_warms_up_gives_both_back() -> None:
    t, x, v, a, T = motion()
    warmer = T - 293.15
    force = 15.0 * a + 12.0 * (1.0 - 0.004 * warmer) * np.sign(v)
    force += (
        90.0 * np.exp(-0.03 * warmer) * v + 1.5 + 0.3 * np.random.default_rng(1).normal(size=len(t))
    )
    log = Recording(t=t, position=x, force=force, temperature=T)
    fit = identify(log, rig="forced", law="coulomb-viscous-temperature")
    truth = {"F_C": 12.0, "F_V": 90.0, "level_slope": -0.004, "visc_slope": 0.03, "M": 15.0,
             "offset": 1.5}  # fmt: skip
    found = {q.name: e for q, e in zip(fit.parameters.every, fit.estimates, strict=True)}
    held = [found[name].low <= value <= found[name].high for name, value in truth.items()]
    assert sum(held) >= 5  # of six intervals of 95 %
    assert {name: found[name].value for name in truth} == pytest.approx(truth, rel=0.02)
    one_factor = identify(log, rig="forced", law="coulomb-viscous+temperature")
    assert one_factor.score.value > 1.1 * fit.score.value


def test_a_log_without_a_temperature_is_refused() -> None:
    t, x, _, a, _ = motion()
    log = Recording(t=t, position=x, force=15.0 * a)
    with pytest.raises(InputError, match="needs a temperature: map a column to temperature"):
        identify(log, rig="forced", law="stribeck-temperature")
