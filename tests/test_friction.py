"""Properties of every friction law; published numbers of the paper's law."""

from __future__ import annotations

import math
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from patience import PATIENCE
from stribeck import InputError
from stribeck.friction import LAWS, LOADS, TERMS, Law, addressed, friction, law_named, stick
from stribeck.rig.balanced import slips
from stribeck.rig.slide_bed import PUBLISHED
from stribeck.space import Array, Space
from stribeck.units import unit

STRIBECK = LAWS["stribeck"]
SYMMETRIC = [law for law in LAWS.values() if not law.directional]
TWINNED = [law for law in SYMMETRIC if f"{law.name}-directional" in LAWS]
STATIC = [law for law in LAWS.values() if law.static]
SPEEDS = np.concatenate([s * np.geomspace(1e-7, 1.0, 60) for s in (1.0, -1.0)])

every_law = pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
symmetric = pytest.mark.parametrize("law", SYMMETRIC, ids=lambda law: law.name)
twinned = pytest.mark.parametrize("law", TWINNED, ids=lambda law: law.name)
static = pytest.mark.parametrize("law", STATIC, ids=lambda law: law.name)


def draws(law: Law, n: int, seed: int = 0) -> Array:
    """`n` parameter sets of a law, uniform in its search ranges, in a meaningful order."""
    u = np.random.default_rng(seed).random((20 * n, len(law.params)))
    p = Space(law.params).decode(u)
    sets: Array = p[law.physical(p)][:n]
    return sets


@every_law
def test_friction_opposes_motion_and_never_gives_energy(law: Law) -> None:
    for p in draws(law, 40):
        F = law.friction(SPEEDS, p)
        assert np.isfinite(F).all()
        assert np.all(F * SPEEDS >= 0)


@every_law
def test_levels_are_the_limits_at_zero_speed(law: Law) -> None:
    for p in draws(law, 40):
        minus, plus = law.levels(p)
        assert minus <= 0 <= plus
        limits = law.friction(np.array([-1e-20, 1e-20]), p)
        np.testing.assert_allclose(limits, [minus, plus], rtol=1e-5, atol=1e-6)


@symmetric
def test_a_symmetric_law_is_odd(law: Law) -> None:
    for p in draws(law, 40):
        np.testing.assert_array_equal(law.friction(-SPEEDS, p), -law.friction(SPEEDS, p))


@static
def test_every_parameter_changes_the_force(law: Law) -> None:
    (p,) = draws(law, 1, seed=5)
    before = law.friction(SPEEDS, p)
    for k, name in enumerate(law.names):
        changed = p.copy()
        changed[k] *= 1.5
        assert np.abs(law.friction(SPEEDS, changed) - before).max() > 1e-6, name


@every_law
def test_the_force_is_linear_in_the_parameters_said_to_be(law: Law) -> None:
    linear = np.isin(law.names, law.linear)
    for p in draws(law, 20, seed=1):
        none, once, twice = (law.friction(SPEEDS, np.where(linear, k * p, p)) for k in range(3))
        np.testing.assert_allclose(twice - once, once - none, rtol=1e-9, atol=1e-9)
        if set(law.linear) >= {"F_C", "F_V"}:  # without its levels nothing rubs
            assert not none.any()


@static
def test_other_parameters_bend_the_curve(law: Law) -> None:
    (p,) = draws(law, 1, seed=2)
    F = law.friction(SPEEDS, p)
    for k, name in enumerate(law.names):
        if name not in law.linear:
            double, quadruple = p.copy(), p.copy()
            double[k], quadruple[k] = 2 * p[k], 3 * p[k]
            bend = law.friction(SPEEDS, quadruple) - 2 * law.friction(SPEEDS, double) + F
            assert np.abs(bend).max() > 1e-6, name


@every_law
def test_a_law_reads_si_units_and_scales_with_them(law: Law) -> None:
    for q in law.params:
        assert unit(q.unit).factor == 1.0, q.name
        assert unit(q.unit).dimension in {
            unit(u).dimension
            for u in ("N", "N s/m", "m/s", "", "s/m", "s", "m", "N/m", "1/N", "1/K", "K")
        }


@every_law
def test_a_law_says_what_it_is(law: Law) -> None:
    assert LAWS[law.name] is law
    assert law.doc
    assert law.formula
    assert law.cite
    assert set(law.linear) <= set(law.names)
    assert len(set(law.names)) == len(law.names)


@every_law
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


def test_each_static_law_has_a_twin_with_parameters_for_each_direction() -> None:
    alone = {law.name for law in SYMMETRIC if law.static} - {law.name for law in TWINNED}
    assert alone == {"bam-m1", "bam-m2"}  # coulomb-viscous and stribeck under BAM's names


@twinned
def test_equal_sets_for_both_directions_are_the_symmetric_law(law: Law) -> None:
    directional = LAWS[f"{law.name}-directional"]
    for p in draws(law, 20, seed=3):
        value = dict(zip(law.names, p, strict=True))
        doubled = np.array([value[name.rstrip("+-")] for name in directional.names])
        np.testing.assert_array_equal(
            directional.friction(SPEEDS, doubled), law.friction(SPEEDS, p)
        )


@twinned
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
    combined = np.array([value[name] for name in directional.names])
    F = directional.friction(SPEEDS, combined)
    np.testing.assert_array_equal(F[SPEEDS > 0], law.friction(SPEEDS[SPEEDS > 0], right))
    np.testing.assert_array_equal(F[SPEEDS < 0], law.friction(SPEEDS[SPEEDS < 0], left))
    assert directional.levels(combined) == (law.levels(left)[0], law.levels(right)[1])


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
    exponential, gaussian = STRIBECK.friction(v, p), STRIBECK.friction(v, gauss)
    np.testing.assert_allclose(exponential, 40 + 60 * np.exp([-0.5, -1.0, -2.0]), rtol=1e-14)
    np.testing.assert_allclose(gaussian, 40 + 60 * np.exp([-0.25, -1.0, -4.0]), rtol=1e-14)


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
        "for name, law in LAWS.items():\n"
        "    if not all(f.stats.cache_hits for f in (law.slip, law.rub) if f):\n"
        "        print(name)"
    )
    completed = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=PATIENCE
    )
    assert completed.stdout.strip() == ""


E = math.e
BY_HAND = [
    # each at the speed at which its formula is a number that one can check without a computer
    ("stribeck-gauss", [100, 40, 500, 2e-3, 2], 4e-3, 40 + 60 * E**-4 + 2),
    ("stribeck-free", [100, 40, 500, 1e-3, 0.5], 4e-3, 40 + 60 * E**-2 + 2),
    ("stribeck-rational", [100, 40, 500, 2e-3, 2], 4e-3, 40 + 60 / 5 + 2),
    ("stribeck-rational", [100, 40, 500, 2e-3, 3], -4e-3, -(40 + 60 / 9 + 2)),
    ("stribeck-smooth", [100, 40, 500, 2e-3], 2e-3, 60 + 40 * math.tanh(10) + 1),
    ("stribeck-smooth", [100, 40, 500, 2e-3], -4e-3, -(60 * 2 * E**-1.5 + 40 + 2)),
    ("karnopp", [100, 40, 500, 1e-3], 0.99e-3, 100),
    ("karnopp", [100, 40, 500, 1e-3], -2e-3, -(40 + 1)),
    # the published example: tanh(1), tanh(0.1)
    ("makkar", [0.25, 100, 10, 0.1, 100, 0.01], 1e-2, 0.25 * (0.761594156 - 0.099667995)
     + 0.1 * 0.761594156 + 1e-4),
    ("bam-m2", [0.1, 2, 0.2, 0.5, 3], 1.0, 0.1 + 2 + 0.2 * E**-8),
    ("lugre", [1e5, 316, 1.5, 1, 1e-3, 0.4], 2e-3, 1 + 0.5 * E**-4 + 0.8e-3),
    ("gms", [1, 2, 3, 4, 1e-6, 2, 2, 2, 5, 1.5, 1e-3, 0.1], -1e-3, -10 * (1 + 0.5 / E) - 5e-3),
    ("maxwell-slip", [1, 2, 3, 4, 1e-6, 2, 2, 2, 5], 1e-3, 10 + 5e-3),
    ("dahl", [1e6, 30, 1, 500], 2e-3, 31),
]  # fmt: skip


@pytest.mark.parametrize(("name", "p", "v", "force"), BY_HAND)
def test_sliding_friction_by_hand(name: str, p: list[float], v: float, force: float) -> None:
    assert math.isclose(LAWS[name].friction(np.array([v]), np.array(p))[0], force, rel_tol=1e-7)


@pytest.mark.parametrize("law", [LAWS["stribeck-smooth"], LAWS["makkar"]], ids=lambda law: law.name)
def test_smooth_laws_never_stick_and_are_straight_through_rest(law: Law) -> None:
    (p,) = draws(law, 1, seed=6)
    assert law.levels(p) == (0.0, 0.0)
    once, twice = law.friction(np.array([1e-10, 2e-10]), p)
    assert once > 0
    assert math.isclose(twice, 2 * once, rel_tol=1e-5)


def test_karnopp_is_stribeck_from_afar_and_static_within_its_band() -> None:
    # Far below and far above their velocities both are at F_S and at Coulomb's line.
    p, q = np.array([90.0, 30.0, 200.0, 1e-3]), np.array([90.0, 30.0, 200.0, 1e-3, 2.0])
    v = np.array([1e-9, 1e-6, 1e-2, 1e-1])
    np.testing.assert_allclose(
        LAWS["karnopp"].friction(v, p), LAWS["stribeck-gauss"].friction(v, q), rtol=1e-5
    )


def test_a_law_has_as_many_elements_as_its_name_says() -> None:
    for stem, states in (("maxwell-slip", 1), ("gms", 2), ("gms-damped", 2)):
        assert law_named(f"{stem}:4") is LAWS[stem]
        six = law_named(f"{stem}:6")
        assert six.name == f"{stem}:6"
        assert six.states == 6 * states
        assert [name for name in six.names if name.startswith("W_")] == [
            f"W_{i}" for i in range(1, 7)
        ]
        p = draws(six, 1)[0]
        F_C = p[:6].sum() * (p[six.names.index("ratio")] if "ratio" in six.names else 1.0)
        assert math.isclose(six.levels(p)[1], F_C, rel_tol=1e-14)


@pytest.mark.parametrize("stem", ["maxwell-slip", "gms", "gms-damped"])
def test_kernels_tell_laws_of_different_numbers_of_elements_apart(stem: str) -> None:
    # Compiled here or on disk, in any order: an address leads to the right one.
    for n in (6, 2, 4, 6, 1):
        law = law_named(f"{stem}:{n}")
        p = draws(law, 1)[0]
        ratio = p[law.names.index("ratio")] if "ratio" in law.names else 1.0
        through = slips(addressed(law.slip), np.array([1e-9]), p)
        viscous = p[law.names.index("F_V")] * 1e-9
        assert math.isclose(through[0], p[:n].sum() * ratio + viscous, rel_tol=1e-9)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("stribek", "no law 'stribek': there are coulomb-viscous, "),
        ("stribeck:3", "law stribeck:3: only maxwell-slip, gms, gms-damped, curve, curve-direct"),
        ("gms:0", "law gms:0: the number of elements goes from 1 to 20, as in gms:6"),
        ("gms:²", "law gms:²: the number of elements goes from 1 to 20, as in gms:6"),
        (f"gms:{10**4299}0", "law gms:1000"),
        ("maxwell-slip:", "law maxwell-slip:: the number of elements goes from 1 to 20"),
        ("stribeck+wind", "law stribeck: cannot add a term 'wind': there are position, temp"),
        ("gms:6+position+position", "law gms:6+position: cannot add a term 'position'"),
    ],
)
def test_a_name_that_means_no_law_is_refused_in_a_line(name: str, message: str) -> None:
    with pytest.raises(InputError) as refused:
        law_named(name)
    assert str(refused.value).startswith(message)
    assert "\n" not in str(refused.value)


@every_law
def test_terms_leave_a_law_its_function_and_add_their_parameters(law: Law) -> None:
    termed = law_named(f"{law.name}+temperature+position")
    assert termed.slip is law.slip
    assert termed.rub is law.rub
    assert termed.params == law.params + TERMS["temperature"] + TERMS["position"]
    assert termed.params[termed.place("temperature")] == TERMS["temperature"]
    p = draws(termed, 4, seed=7)
    assert len(p) == 4
    for q in p:  # a law does not look at what follows its own parameters
        np.testing.assert_array_equal(
            termed.friction(SPEEDS, q), law.friction(SPEEDS, q[: len(law.params)])
        )


@every_law
def test_loads_that_a_law_reads_are_among_the_loads_there_are(law: Law) -> None:
    assert set(law.loads) <= set(LOADS)
    assert (law.rub is None) == (law.states == 0 and not law.loads)


@every_law
def test_a_kernel_that_is_given_an_address_calls_the_law_behind_it(law: Law) -> None:
    """The same bits as the law itself, and one address at every call."""
    assert addressed(law.slip) is addressed(law.slip)
    p = np.array([q.lower + 0.3 * (q.upper - q.lower) for q in law.params])
    v = np.array([-1e-2, -1e-300, 1e-300, 3e-4, 2e-2])
    through = slips(addressed(law.slip), v, p)
    assert np.array_equal(through, [law.slip(s, p) for s in v.tolist()])
