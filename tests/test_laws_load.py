"""Laws that depend on a load: friction budgets by hand, nesting, the loads that each reads."""

from __future__ import annotations

import math

import numpy as np
import pytest

from stribeck.friction import LAWS, LOADS, Law
from stribeck.space import Array, Space

LOADED = [law for law in LAWS.values() if {*law.loads} - {"temperature"}]
loaded = pytest.mark.parametrize("law", LOADED, ids=lambda law: law.name)
SPEEDS = np.concatenate([s * np.geomspace(1e-6, 1.0, 20) for s in (1.0, -1.0)]).tolist()
NONE = np.zeros(0)


def rub(law: Law, v: float, load: Array, p: Array, h: float = 1e-3) -> float:
    if law.rub is None:  # m1 and m2 read no loads
        return float(law.slip(v, p))
    return float(law.rub(v, h, NONE, load, p, np.zeros(0)))


def draws(law: Law, n: int, seed: int = 0) -> Array:
    p = Space(law.params).decode(np.random.default_rng(seed).random((n, len(law.params))))
    assert law.physical(p).all()
    return p


def loads(n: int, seed: int = 1) -> Array:
    return np.random.default_rng(seed).normal(0, 200, (n, len(LOADS)))


@loaded
def test_without_load_it_is_its_slip_curve(law: Law) -> None:
    no_load = np.zeros(5)
    no_load[LOADS.index("position") :] = 0.3, 300.0
    for p in draws(law, 20):
        for v in [*SPEEDS, 0.0, -0.0]:
            assert rub(law, v, no_load, p) == law.slip(v, p)


@loaded
def test_at_rest_it_gives_the_levels_under_the_load(law: Law) -> None:
    for p, load in zip(draws(law, 20), loads(20), strict=True):
        minus, plus = rub(law, -0.0, load, p), rub(law, 0.0, load, p)
        assert plus > law.levels(p)[1]  # a load adds
        assert minus == -plus
        assert math.isclose(rub(law, 1e-30, load, p), plus, rel_tol=1e-9)


@loaded
def test_it_opposes_motion_and_mirrors_with_its_loads(law: Law) -> None:
    for p, load in zip(draws(law, 20), loads(20), strict=True):
        for v in SPEEDS:
            F = rub(law, v, load, p)
            assert F * v > 0
            assert rub(law, -v, -load, p) == -F


@loaded
def test_it_reads_the_loads_that_it_names_and_no_others(law: Law) -> None:
    (p,), (load,) = draws(law, 1), loads(1)
    for k, name in enumerate(LOADS):
        changed_load = load.copy()
        changed_load[k] *= 1.3
        changed = [rub(law, v, changed_load, p) != rub(law, v, load, p) for v in SPEEDS]
        assert any(changed) == (name in law.loads), name


@loaded
def test_no_time_passes_in_it(law: Law) -> None:
    (p,), (load,) = draws(law, 1), loads(1)
    for v in SPEEDS:
        assert rub(law, v, load, p, 0.0) == rub(law, v, load, p, 1e3)


@loaded
def test_every_parameter_matters_under_load(law: Law) -> None:
    (p,) = draws(law, 1)
    for k, name in enumerate(law.names):
        changed = p.copy()
        changed[k] *= 1.01
        off = max(
            abs(rub(law, v, load, changed) - rub(law, v, load, p))
            for v in SPEEDS for load in loads(20)
        )  # fmt: skip
        assert off > 1e-6, name


@loaded
def test_under_load_the_force_is_linear_in_what_is_said_to_be(law: Law) -> None:
    linear = np.isin(law.names, law.linear)
    for p, load in zip(draws(law, 20), loads(20), strict=True):
        for v in SPEEDS[::5]:
            none, once, twice = (rub(law, v, load, np.where(linear, k * p, p)) for k in range(3))
            assert math.isclose(twice - once, once - none, rel_tol=1e-9)


def test_a_seal_rubs_by_its_pressure_in_either_sense() -> None:
    law = LAWS["coulomb-load"]
    p = np.array([9.0, 20.0, 1.2e-5])  # N, N s/m, m^2
    for pressure in (4e5, -4e5):
        load = np.array([1e3, -1e3, pressure, 0.1, 300.0])
        assert math.isclose(rub(law, 0.1, load, p), 9.0 + 4.8 + 2.0)
        assert math.isclose(rub(law, -0.1, load, p), -(9.0 + 4.8 + 2.0))


#: A Dynamixel MX-106 as published for m6: K_c, K_v, K_cs, w_s, alpha, K_m, K_e, K_ms, K_es, K_mq,
#: K_eq.
MX106 = [0.0, 0.0507, 0.122, 1.746, 1.143, 0.198, 0.0222, 0.1986, 0.0871, 0.0100, 7.3e-5]


@pytest.mark.parametrize(
    ("w", "t_m", "t_e", "budget"),
    [
        # at rest, E = 1: |K_m t_m - K_e t_e| + K_cs + |K_ms t_m - K_es t_e| + Q
        (0.0, 2.0, 0.0, 0.396 + 0.122 + 0.3972),
        (0.0, 0.0, -2.0, 0.0444 + 0.122 + 0.1742),
        # opposed, the motor stronger: Q = K_eq t_e^2
        (0.0, 2.0, -1.0, 0.4182 + 0.122 + 0.4843 + 7.3e-5),
        # opposed, the motor weaker: Q = K_mq t_m^2
        (0.0, 1.0, -2.0, 0.2424 + 0.122 + 0.3728 + 0.01),
        # the same way: no Q, and the two shares cancel in part
        (0.0, 1.0, 2.0, 0.1536 + 0.122 + 0.0244),
        # at w = w_s, E = 1/e
        (1.746, 2.0, -1.0, 0.0507 * 1.746 + 0.4182 + (0.122 + 0.4843 + 7.3e-5) / math.e),
    ],
)
def test_m6_by_hand(w: float, t_m: float, t_e: float, budget: float) -> None:
    load = np.array([t_m, t_e, 0.0, 0.0, 0.0])
    assert math.isclose(rub(LAWS["bam-m6"], w, load, np.array(MX106)), budget, rel_tol=1e-12)
    assert math.isclose(rub(LAWS["bam-m6"], -w, -load, np.array(MX106)), -budget, rel_tol=1e-12)


def test_m4_by_hand() -> None:
    # MX-106 as published for m4, w twice w_s: E = exp(-2^1.32)
    p = np.array([0.0, 0.051, 0.105, 1.62, 1.32, 0.00915, 0.2224])
    E = math.exp(-(2**1.32))
    load = np.array([1.5, -2.5, 0.0, 0.0, 0.0])
    expected = 0.051 * 3.24 + 0.00915 * 4 + E * (0.105 + 0.2224 * 4)
    assert math.isclose(rub(LAWS["bam-m4"], 3.24, load, p), expected, rel_tol=1e-12)


#: Values of the greater law, numbers or parameters of the smaller, at which both are equal.
NESTED = [
    ("bam-m6", "bam-m5", {"K_mq": 0.0, "K_eq": 0.0}),
    ("bam-m5", "bam-m4", {"K_m": "K_l", "K_e": "K_l", "K_ms": "K_ls", "K_es": "K_ls"}),
    ("bam-m4", "bam-m3", {"K_cs": 0.0, "K_ls": 0.0, "w_s": 0.1, "alpha": 1.0}),
    ("bam-m4", "bam-m2", {"K_l": 0.0, "K_ls": 0.0}),
    ("bam-m3", "bam-m1", {"K_l": 0.0}),
    ("bam-m2", "bam-m1", {"K_cs": 0.0, "w_s": 0.1, "alpha": 1.0}),
    ("bam-m1", "coulomb-viscous", {"K_c": "F_C", "K_v": "F_V"}),
    ("coulomb-load", "coulomb-viscous", {"mu": 0.0}),
]


@pytest.mark.parametrize(("greater", "smaller", "mapping"), NESTED)
def test_each_law_contains_the_one_before(
    greater: str, smaller: str, mapping: dict[str, str | float]
) -> None:
    big, small = LAWS[greater], LAWS[smaller]
    for p, load in zip(draws(small, 20), loads(20), strict=True):
        value: dict[str, float] = dict(zip(small.names, p.tolist(), strict=True))
        for name, source in mapping.items():
            value[name] = value[source] if isinstance(source, str) else source
        q = np.array([value[name] for name in big.names])
        for v in [*SPEEDS, 0.0, -0.0]:
            assert math.isclose(
                rub(big, v, load, q), rub(small, v, load, p), rel_tol=1e-12, abs_tol=1e-12
            )


def test_a_gear_rubs_more_the_more_its_ends_work_against_each_other() -> None:
    p = draws(LAWS["bam-m4"], 10)
    for q in p:
        holding = rub(LAWS["bam-m4"], 1e-3, np.array([50.0, -50.0, 0, 0, 0]), q)
        helping = rub(LAWS["bam-m4"], 1e-3, np.array([50.0, 50.0, 0, 0, 0]), q)
        assert helping == LAWS["bam-m4"].slip(1e-3, q) < holding
