"""Every friction law by its properties, the paper's law by its numbers."""

from __future__ import annotations

import math
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stribeck.friction import LAWS, Law, addressed, friction, stick
from stribeck.rig.forced import slips
from stribeck.rig.slide_bed import PUBLISHED
from stribeck.space import Array
from stribeck.units import unit

STRIBECK, DIRECTIONAL = LAWS["stribeck"], LAWS["stribeck-directional"]
SYMMETRIC = [law for law in LAWS.values() if not law.directional]
SPEEDS = np.concatenate([s * np.geomspace(1e-7, 1.0, 60) for s in (1.0, -1.0)])

every = pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
symmetric = pytest.mark.parametrize("law", SYMMETRIC, ids=lambda law: law.name)


def draws(law: Law, n: int, seed: int = 0) -> Array:
    """`n` parameter sets of a law, uniform in its ranges, in a meaningful order."""
    rng = np.random.default_rng(seed)
    lower, upper = np.array([[q.lower, q.upper] for q in law.params]).T
    found: list[Array] = []
    while len(found) < n:
        p = lower + (upper - lower) * rng.random((1, len(lower)))
        if np.all(law.physical(p)):
            found.append(p[0])
    return np.array(found)


@every
def test_friction_opposes_motion_and_never_gives_energy(law: Law) -> None:
    for p in draws(law, 40):
        F = law.friction(SPEEDS, p)
        assert np.isfinite(F).all()
        assert np.all(F * SPEEDS >= 0)


@every
def test_levels_are_the_limits_at_zero_speed(law: Law) -> None:
    for p in draws(law, 40):
        minus, plus = law.levels(p)
        assert minus <= 0 <= plus
        near = law.friction(np.array([-1e-12, 1e-12]), p)
        np.testing.assert_allclose(near, [minus, plus], rtol=1e-5, atol=1e-6)


@symmetric
def test_a_symmetric_law_is_odd(law: Law) -> None:
    for p in draws(law, 40):
        np.testing.assert_array_equal(law.friction(-SPEEDS, p), -law.friction(SPEEDS, p))


@every
def test_every_parameter_changes_the_force(law: Law) -> None:
    (p,) = draws(law, 1, seed=5)
    before = law.friction(SPEEDS, p)
    for k, name in enumerate(law.names):
        other = p.copy()
        other[k] *= 1.01
        assert np.abs(law.friction(SPEEDS, other) - before).max() > 1e-6, name


@every
def test_the_force_is_linear_in_the_parameters_said_to_be(law: Law) -> None:
    linear = np.isin(law.names, law.linear)
    for p in draws(law, 20, seed=1):
        double = np.where(linear, 2 * p, p)
        np.testing.assert_allclose(
            law.friction(SPEEDS, double), 2 * law.friction(SPEEDS, p), rtol=1e-12
        )


@every
def test_other_parameters_bend_the_curve(law: Law) -> None:
    (p,) = draws(law, 1, seed=2)
    F = law.friction(SPEEDS, p)
    for k, name in enumerate(law.names):
        if name not in law.linear:
            double, quadruple = p.copy(), p.copy()
            double[k], quadruple[k] = 2 * p[k], 3 * p[k]
            bend = law.friction(SPEEDS, quadruple) - 2 * law.friction(SPEEDS, double) + F
            assert np.abs(bend).max() > 1e-6, name


@every
def test_a_law_reads_si_units_and_scales_with_them(law: Law) -> None:
    for q in law.params:
        assert unit(q.unit).factor == 1.0, q.name
        assert unit(q.unit).dimension in {
            unit(u).dimension for u in ("N", "N s/m", "m/s", "", "N m", "1/s", "m", "N/m")
        }


@every
def test_a_law_says_what_it_is(law: Law) -> None:
    assert LAWS[law.name] is law
    assert law.doc
    assert law.formula
    assert law.cite
    assert set(law.linear) <= set(law.names)
    assert len(set(law.names)) == len(law.names)


@every
def test_the_order_of_a_law_refuses_what_friction_cannot_be(law: Law) -> None:
    p = draws(law, 5)
    assert np.all(law.physical(p))
    for k, name in enumerate(law.names):
        if name in law.linear:
            negative = p.copy()
            negative[:, k] = -1.0
            assert not np.any(law.physical(negative)), name


def test_static_friction_below_coulomb_is_refused() -> None:
    p = np.array([[50.0, 60.0, 500.0, 1e-3, 1.0], [60.0, 50.0, 500.0, 1e-3, 1.0]])
    assert STRIBECK.physical(p).tolist() == [False, True]


@symmetric
def test_equal_sets_for_both_directions_are_the_symmetric_law(law: Law) -> None:
    directional = LAWS[f"{law.name}-directional"]
    for p in draws(law, 20, seed=3):
        value = dict(zip(law.names, p, strict=True))
        both = np.array([value[name.rstrip("+-")] for name in directional.names])
        np.testing.assert_array_equal(directional.friction(SPEEDS, both), law.friction(SPEEDS, p))


@symmetric
def test_a_direction_reads_its_own_set(law: Law) -> None:
    directional = LAWS[f"{law.name}-directional"]
    right, left = draws(law, 2, seed=4)
    value = {
        f"{name}{sign}": p[k]
        for sign, p in (("+", right), ("-", left))
        for k, name in enumerate(law.names)
    }
    shared = [n for n in directional.names if n not in value]
    for name in shared:
        left[law.names.index(name)] = right[law.names.index(name)]
        value[name] = right[law.names.index(name)]
    both = np.array([value[name] for name in directional.names])
    F = directional.friction(SPEEDS, both)
    np.testing.assert_array_equal(F[SPEEDS > 0], law.friction(SPEEDS[SPEEDS > 0], right))
    np.testing.assert_array_equal(F[SPEEDS < 0], law.friction(SPEEDS[SPEEDS < 0], left))
    assert directional.levels(both) == (law.levels(left)[0], law.levels(right)[1])


@pytest.mark.parametrize(
    ("direction", "v", "force"),
    [
        # 47.8514 + 96.6949 exp(-v/1.0964 mm/s) + 0.9583 N s/mm v, by hand
        ("right", 0.0, 144.5463),
        ("right", 1.0964e-3, 47.8514 + 96.6949 / math.e + 1.05068),
        ("right", 5e-3, 53.65414),
        ("right", -5e-3, -53.65414),
        ("left", 5e-3, 40.4153 + 111.8651 * math.exp(-5 / 3.21475) + 4.8785),
        ("left", 100e-3, 40.4153 + 97.57),
    ],
)
def test_equation_4_2_by_hand_with_the_published_sets(
    direction: str, v: float, force: float
) -> None:
    F = STRIBECK.friction(np.array([v]), PUBLISHED[direction][:5])[0]
    assert math.isclose(F, force, rel_tol=2e-6)


def test_minimum_of_the_published_slip_curves() -> None:
    # v* = v_SS ln((F_S - F_C) / (F_V v_SS)): 4.958 mm/s and 11.49 mm/s.
    v = np.arange(1e-3, 20e-3, 1e-6)
    for direction, least in (("right", 4.958e-3), ("left", 11.49e-3)):
        F = STRIBECK.friction(v, PUBLISHED[direction][:5])
        assert math.isclose(v[np.argmin(F)], least, abs_tol=5e-6)


def test_exponents_meet_at_the_stribeck_velocity_and_part_elsewhere() -> None:
    p = np.array([100.0, 40.0, 0.0, 2e-3, 1.0])
    gauss = np.array([100.0, 40.0, 0.0, 2e-3, 2.0])
    v = np.array([1e-3, 2e-3, 4e-3])
    one, two = STRIBECK.friction(v, p), STRIBECK.friction(v, gauss)
    np.testing.assert_allclose(one, 40 + 60 * np.exp([-0.5, -1.0, -2.0]), rtol=1e-14)
    np.testing.assert_allclose(two, 40 + 60 * np.exp([-0.25, -1.0, -4.0]), rtol=1e-14)


def test_stribeck_without_its_drop_is_coulomb_with_a_viscous_term() -> None:
    for F_C, F_V in draws(LAWS["coulomb-viscous"], 20):
        p = np.array([F_C, F_C, F_V, 1e-3, 1.0])
        np.testing.assert_allclose(
            STRIBECK.friction(SPEEDS, p),
            LAWS["coulomb-viscous"].friction(SPEEDS, np.array([F_C, F_V])),
            rtol=1e-13,
        )


@given(st.floats(-500, 500), st.floats(0, 200), st.floats(0, 200))
def test_equation_4_1_balances_up_to_breakaway(F_in: float, below: float, above: float) -> None:
    F = stick(F_in, -below, above)
    if -below <= F_in <= above:
        assert F_in == F
    else:
        assert (above if F_in > above else -below) == F


@settings(max_examples=50)
@given(st.floats(-300, 300), st.sampled_from([-5e-3, -1e-9, 0.0, -0.0, 1e-9, 5e-3]))
def test_equation_4_3_sticks_at_rest_and_slips_otherwise(F_in: float, v: float) -> None:
    p = PUBLISHED["right"][:5]
    F = friction(STRIBECK, v, F_in, p)
    if v == 0:
        assert min(max(F_in, -144.5463), 144.5463) == F
    else:
        assert STRIBECK.friction(np.array([v]), p)[0] == F


def test_laws_come_compiled_from_the_disk_of_an_earlier_process() -> None:
    code = (
        "from stribeck.friction import LAWS\n"
        "print(*(name for name, law in LAWS.items() if not law.slip.stats.cache_hits))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60
    )
    assert done.stdout.strip() == ""


@every
def test_a_kernel_that_is_given_an_address_calls_the_law_behind_it(law: Law) -> None:
    """The same bits as the law itself, and one address however often it is asked for."""
    assert addressed(law.slip) is addressed(law.slip)
    p = np.array([q.lower + 0.3 * (q.upper - q.lower) for q in law.params])
    v = np.array([-1e-2, -1e-300, 1e-300, 3e-4, 2e-2])
    through = slips(addressed(law.slip), v, p)
    assert np.array_equal(through, [law.slip(s, p) for s in v.tolist()])
