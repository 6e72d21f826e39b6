"""Laws with states: exact flows, steady sliding, presliding, energy, and convergence."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from stribeck.friction import LAWS, Law, law_named
from stribeck.space import Array, Space

DYNAMIC = [law for law in LAWS.values() if law.states]
LAWS_OF_BRISTLES = ["dahl", "lugre", "elasto-plastic"]
NONE = np.zeros(5)

dynamic = pytest.mark.parametrize("law", DYNAMIC, ids=lambda law: law.name)

#: Parameter sets of one contact: 12 N of Coulomb friction, 18 N static, some 10 µm of presliding.
SETS: dict[str, list[float]] = {
    "dahl": [1.2e6, 12, 1, 50],
    "lugre": [1.2e6, 60, 18, 12, 2e-3, 50],
    "elasto-plastic": [1.2e6, 60, 18, 12, 2e-3, 50, 0.6],
    "lugre-film": [1.2e6, 60, 18, 12, 2e-3, 50, 1e-2, 0.05, 0.02],
    "armstrong": [1.2e6, 18, 12, 2e-3, 50, 0.5, 0.01],
    "maxwell-slip": [4, 3, 3, 2, 2e-6, 2, 2.5, 3, 50],
    "gms": [4, 3, 3, 2, 2e-6, 2, 2.5, 3, 50, 1.5, 2e-3, 5e-3],
    "gms-damped": [4, 3, 3, 2, 2e-6, 2, 2.5, 3, 50, 1.5, 2e-3, 5e-3, 60],
}


def walk(law: Law, p: Array, v: Array, h: Array, z: Array | None = None) -> tuple[Array, Array]:
    """Force and states at the ends of spans of constant velocity."""
    z = np.zeros(law.states) if z is None else z.copy()
    F, states = np.empty(len(v)), np.empty((len(v), law.states))
    for k in range(len(v)):
        F[k] = law.rub(v[k], h[k], z, NONE, p, states[k])
        z = states[k]
    return F, states


def random_sets(law: Law, n: int, seed: int) -> Array:
    """`n` parameter sets, uniform in the search ranges."""
    u = np.random.default_rng(seed).random((20 * n, len(law.params)))
    p = Space(law.params).decode(u)
    sets: Array = p[law.physical(p)][:n]
    return sets


def active_sets(law: Law) -> list[Array]:
    """Parameter sets, each parameter active in at least one: SETS, else random ones."""
    return [np.array(SETS[law.name])] if law.name in SETS else list(random_sets(law, 20, 13))


def sliding(p: Array, law: Law) -> Array:
    """The sets with Dahl's exponent at most 1: above it, steady sliding takes kilometres."""
    if law.name == "dahl":
        p[:, 2] = np.minimum(p[:, 2], 1.0)
    return p


def strokes() -> tuple[Array, Array]:
    """There and back over 1 nm to 10 mm, slowly and fast, in twelve uneven spans a stroke."""
    length = np.repeat(np.geomspace(1e-9, 1e-2, 24), 4)
    v = np.tile([2e-4, -2e-4, 5e-3, -5e-3], 24)
    uneven = np.tile([0.5, 1.0, 3.0, 0.3], 3)
    speeds = np.multiply.outer(v, uneven)
    return speeds.ravel(), (length[:, None] / 12 / np.abs(speeds)).ravel()


# --- the flow -------------------------------------------------------------------------------------


@dynamic
def test_a_span_of_no_time_leaves_the_states_as_they_are(law: Law) -> None:
    rng = np.random.default_rng(1)
    for p in random_sets(law, 10, 1):
        _, states = walk(law, p, *strokes())
        for z in states[rng.integers(0, len(states), 5)]:
            out = np.full(law.states, np.nan)
            assert np.isfinite(law.rub(rng.normal(0, 1e-2), 0.0, z, NONE, p, out))
            np.testing.assert_array_equal(out, z)


@dynamic
def test_one_span_is_many_shorter_ones(law: Law) -> None:
    rng = np.random.default_rng(2)
    for p in random_sets(law, 10, 2):
        _, states = walk(law, p, *strokes())
        for z in states[rng.integers(0, len(states), 8)]:
            v, h = rng.choice([-1, 1]) * 10 ** rng.uniform(-6, 0), 10 ** rng.uniform(-6, 1)
            (once,), (at_once,) = walk(law, p, np.array([v]), np.array([h]), z)
            F, steps = walk(law, p, np.full(7, v), np.full(7, h / 7), z)
            level = abs(law.slip(0.0, p)) + abs(law.slip(v, p))
            # Two have no closed form all the way: the elasto-plastic bristle, and one on a film
            # that moves while it bends, which takes the film in 16 parts.
            close = {"elasto-plastic": 1e-7, "lugre-film": 3e-3}.get(law.name, 1e-10)
            assert abs(F[-1] - once) <= close * (level + abs(once))
            np.testing.assert_allclose(
                steps[-1], at_once, rtol=close, atol=close * np.abs(states).max()
            )


@dynamic
def test_nothing_runs_away_however_long_the_span_and_whatever_the_speed(law: Law) -> None:
    speeds = [s * v for v in (0.0, 1e-300, 1e-12, 1e-3, 1.0, 1e6) for s in (1.0, -1.0)]
    spans = [0.0, 1e-12, 1e-3, 1e3, 1e9]
    rng = np.random.default_rng(3)
    for p in sliding(random_sets(law, 8, 3), law):
        z = np.zeros(law.states)
        for _ in range(300):
            v, h = rng.choice(speeds), rng.choice(spans)
            out = np.full(law.states, np.nan)
            F = law.rub(v, h, z, NONE, p, out)
            assert math.isfinite(F)
            assert np.isfinite(out).all()
            if abs(v) * h > 1e3:  # a way of a kilometre and more: steady
                # Armstrong's drop stays as short as the rest before the slide has left it.
                short = out[2] * (p[1] - p[2]) * 1.001 if law.name == "armstrong" else 0.0
                assert math.isclose(F, law.slip(v, p), rel_tol=1e-9, abs_tol=short)
            z = out


@dynamic
@pytest.mark.parametrize("excess", [3.0, 1e3, 1e9])
def test_where_an_explicit_step_blows_up_the_bristle_stays_below_static_friction(
    law: Law, excess: float
) -> None:
    # sigma_0 |v| h / s(v) >> 2: each span of a reversing motion is `excess` steady holding_forces.
    for p in random_sets(law, 20, 4):
        F_S = law.slip(0.0, p)
        if law.name == "gms-damped":  # whose level may rise from rest, up to that of Coulomb
            F_S = max(F_S, p[:4].sum())
        for v in (1e-5, 1e-2):
            signs = np.where(np.arange(40) // 3 % 2, -1.0, 1.0)
            distance = excess * 1e-3
            holding_forces = [
                law.rub(0.0, 0.0, z, NONE, p, np.empty(law.states))
                for z in walk(law, p, signs * v, np.full(40, distance / v))[1]
            ]
            assert np.abs(holding_forces).max() <= F_S * (1 + 1e-12)


@dynamic
def test_a_long_slide_ends_at_the_slip_curve(law: Law) -> None:
    for p in sliding(random_sets(law, 20, 5), law):
        for v in (-0.3, -1e-3, 1e-4, 2e-2):
            (F,), _ = walk(law, p, np.array([v]), np.array([1e4 / abs(v)]))
            assert math.isclose(F, law.slip(v, p), rel_tol=1e-12)


@dynamic
def test_the_force_is_odd(law: Law) -> None:
    v, h = strokes()
    for p in random_sets(law, 5, 6):
        np.testing.assert_array_equal(walk(law, p, -v, h)[0], -walk(law, p, v, h)[0])


@dynamic
def test_every_parameter_matters_on_the_way(law: Law) -> None:
    def matters(p: Array, k: int) -> bool:
        before, changed = walk(law, p, *strokes())[0], p.copy()
        changed[k] *= 1.1
        change: float = np.abs(walk(law, changed, *strokes())[0] - before).max()
        return change > 1e-3 * float(np.std(before))

    for k, name in enumerate(law.names):
        assert any(matters(p, k) for p in active_sets(law)), name


@dynamic
def test_the_force_is_linear_on_the_way_in_what_is_said_to_be_and_in_nothing_else(law: Law) -> None:
    linear = np.isin(law.names, law.linear)
    for p in random_sets(law, 5, 8):
        F = [walk(law, np.where(linear, k * p, p), *strokes())[0] for k in (0.5, 1.0, 1.5)]
        np.testing.assert_allclose(F[2] - F[1], F[1] - F[0], rtol=1e-7, atol=1e-9)

    def bends(p: Array, k: int) -> bool:
        factor = np.where(np.arange(len(p)) == k, 0.2, 0.0)
        F = [walk(law, p * (1 + m * factor), *strokes())[0] for m in range(3)]
        bend: float = np.abs(F[2] - 2 * F[1] + F[0]).max()
        return bend > 1e-6 * float(np.abs(F[1]).max())

    for k in np.flatnonzero(~linear).tolist():
        assert any(bends(p, k) for p in active_sets(law)), law.names[k]


# --- against the equations, solved by scipy ------------------------------------------------------


def swing(t: Any) -> Any:
    """A velocity that turns within presliding and then slides: 3 to 60 µm at 20 Hz."""
    return (3e-6 + 6e-5 * t / 0.2) * 125 * np.cos(125 * t)


def dahl_rate(p: list[float]) -> Callable[[float, float], float]:
    def rate(v: float, z: float) -> float:
        u = 1 - p[0] * z / p[1] * np.sign(v)
        return float(v * abs(u) ** p[2] * np.sign(u))

    return rate


def lugre_rate(p: list[float]) -> Callable[[float, float], float]:
    def rate(v: float, z: float) -> float:
        g = p[3] + (p[2] - p[3]) * math.exp(-((v / p[4]) ** 2))
        return v - p[0] * abs(v) * z / g

    return rate


def elasto_plastic_rate(p: list[float]) -> Callable[[float, float], float]:
    def rate(v: float, z: float) -> float:
        z_ss = (p[3] + (p[2] - p[3]) * math.exp(-((v / p[4]) ** 2))) / p[0]
        z_ba, a = p[6] * p[3] / p[0], abs(z)
        if a <= z_ba or z * v < 0:
            alpha = 0.0
        elif a >= z_ss:
            alpha = 1.0
        else:
            alpha = 0.5 * math.sin(math.pi * (a - (z_ss + z_ba) / 2) / (z_ss - z_ba)) + 0.5
        return v * (1 - alpha * a / z_ss)

    return rate


RATES = {"dahl": dahl_rate, "lugre": lugre_rate, "elasto-plastic": elasto_plastic_rate}


@pytest.mark.parametrize(
    ("name", "shape"),
    [(name, None) for name in LAWS_OF_BRISTLES] + [("dahl", 1.7)],
)
def test_bristles_follow_their_equation_with_an_error_of_second_order(
    name: str, shape: float | None
) -> None:
    law, values = LAWS[name], [*SETS[name]]
    if shape is not None:
        values[2] = shape
    p, rate, T = np.array(values), RATES[name](values), 0.2
    solution = solve_ivp(
        lambda t, z: [1e6 * rate(swing(t), 1e-6 * z[0])], (0, T), [0.0],
        method="RK45", rtol=1e-9, atol=1e-9, max_step=2e-4, dense_output=True,
    )  # fmt: skip
    errors = []
    for n in (400, 800, 1600, 3200):
        t = np.linspace(0, T, n + 1)
        _, z = walk(law, p, swing(0.5 * (t[1:] + t[:-1])), np.diff(t))
        exact = 1e-6 * solution.sol(t[1:])[0]  # type: ignore[misc]  # dense_output was asked for
        errors.append(np.sqrt(np.mean((z[:, 0] - exact) ** 2)) * p[0] / 12)
    assert errors[-1] < 3e-4  # of Coulomb friction
    assert np.log2(errors[0] / errors[-1]) / 3 > 1.85


def gms_by_hand(p: list[float], v: list[float], h: float) -> list[float]:
    """GMS as published, in N, with alpha_i, k_i, sigma_i and C, by tiny explicit steps.

    Without what sigma_i adds to an element that slides, C (sgn v - F_i/(alpha_i s))/k_i sigma_i.
    """
    W, d = p[:4], np.cumprod(p[4:8]).tolist()
    F_V, ratio, v_s, tau, sigma = [*p[8:], 0.0][:5]
    F_C = sum(W)
    C = F_C / tau
    F, slides, forces, before = [0.0] * 4, [False] * 4, [], 0.0
    for speed in v:
        s = F_C * (1 + (ratio - 1) * math.exp(-((speed / v_s) ** 2)))
        sign = 1.0 if speed > 0 else -1.0
        for i in range(4):
            alpha, k = W[i] / F_C, W[i] / d[i]
            slides[i] = (slides[i] and before * speed > 0) or F[i] * sign >= alpha * s
            F[i] += h * (C * alpha * (sign - F[i] / (alpha * s)) if slides[i] else k * speed)
        before = speed
        damping = sum(sigma * w / F_C for w, x in zip(W, slides, strict=True) if not x)
        forces.append(sum(F) + (F_V + damping) * speed)
    return forces


@pytest.mark.parametrize("name", ["gms", "gms-damped"])
def test_gms_is_what_its_published_equations_say(name: str) -> None:
    h, n, substeps, p = 1e-6, 4000, 50, SETS[name]
    fine = gms_by_hand(p, swing((np.arange(n * substeps) + 0.5) * h).tolist(), h)
    ends = substeps * h * np.arange(1, n + 1)
    v = swing(ends - 0.5 * substeps * h)
    F, states = walk(LAWS[name], np.array(p), v, np.full(n, substeps * h))
    # What goes with the speed is of the end, not of half-way.
    share = (1.0 - states[:, 4:]) @ np.array(p[:4]) / sum(p[:4])
    F += (50 + [*p, 0.0][12] * share) * (swing(ends) - v)
    off = F - fine[substeps - 1 :: substeps]
    assert np.sqrt(np.mean(off**2)) < 2e-3 * 12


def film_by_hand(p: list[float], v: list[float], h: float) -> list[float]:
    """LuGre's law on a film as published, by tiny explicit steps."""
    sigma_0, sigma_1, F_S, F_C, v_s, F_V, v_b, tau_p, tau_n = p
    K = (1 - F_C / F_S) * v_b ** (-2 / 3)
    z, film, forces = 0.0, 0.0, []
    for speed in v:
        steady = K * min(abs(speed), v_b) ** (2 / 3)
        film += h * (steady - film) / (tau_p if film <= steady else tau_n)
        g = F_C + ((1 - film) * F_S - F_C) * math.exp(-((speed / v_s) ** 2))
        bending = speed - sigma_0 * abs(speed) * z / g
        z += h * bending
        forces.append(sigma_0 * z + sigma_1 * bending + F_V * speed)
    return forces


def test_a_film_is_what_its_published_equations_say() -> None:
    h, n, substeps, p = 1e-6, 4000, 50, SETS["lugre-film"]
    fine = film_by_hand(p, swing((np.arange(n * substeps) + 0.5) * h).tolist(), h)
    ends = substeps * h * np.arange(1, n + 1)
    v = swing(ends - 0.5 * substeps * h)
    F, _ = walk(LAWS["lugre-film"], np.array(p), v, np.full(n, substeps * h))
    F += (p[5] + p[1]) * (swing(ends) - v)  # what goes with the speed is of the end
    off = F - fine[substeps - 1 :: substeps]
    assert np.sqrt(np.mean(off**2)) < 2e-3 * 12


def test_on_a_film_friction_is_greater_on_the_way_up_than_on_the_way_down() -> None:
    """A slide whose speed swings between 0.5 and 3 mm/s, once a second, one way."""
    law, p = LAWS["lugre-film"], np.array([*SETS["lugre-film"][:7], 0.2, 0.2])
    t = 1e-3 * np.arange(3000)
    v = 1.75e-3 - 1.25e-3 * np.cos(2 * np.pi * t)
    F, _ = walk(law, p, v, np.full(len(t), 1e-3))
    with_film = np.median(F[2000:2500] - F[2500:][::-1])  # at the same speeds, up less down
    assert with_film > 0.02 * 12
    at_once = np.array([*p[:7], 1e-6, 1e-6])
    F, _ = walk(law, at_once, v, np.full(len(t), 1e-3))
    assert np.median(F[2000:2500] - F[2500:][::-1]) < 0.5 * with_film  # what the bristle has


# --- presliding -----------------------------------------------------------------------------------


@pytest.mark.parametrize("exponent", [0.0, 0.5, 1.0, 1.0 + 1e-9, 2.0])
def test_dahl_is_its_closed_form(exponent: float) -> None:
    sigma_0, F_C = 1e6, 20.0
    x = np.linspace(0, 4e-5, 41)[1:]
    k = sigma_0 * x / F_C
    u = {0.0: np.maximum(1 - k, 0), 0.5: np.maximum(1 - k / 2, 0) ** 2, 2.0: 1 / (1 + k)}
    expected = F_C * (1 - u.get(exponent, np.exp(-k)))
    p = np.array([sigma_0, F_C, exponent, 0.0])
    F, _ = walk(LAWS["dahl"], p, np.full(40, 1e-4), np.full(40, 1e-2))
    np.testing.assert_allclose(F, expected, rtol=1e-7, atol=1e-12)


@pytest.mark.parametrize("name", LAWS_OF_BRISTLES)
def test_a_bristle_is_a_spring_of_its_stiffness_as_long_as_little_moves(name: str) -> None:
    p = np.array(SETS[name])
    F, _ = walk(LAWS[name], p, np.array([1e-9]), np.array([1.0]))  # 1 nm at 1 nm/s
    assert math.isclose(F[0], 1.2e6 * 1e-9, rel_tol=2e-4)


def masing(W: Array, d: Array, turns: Array, x: float) -> float:
    """A Maxwell-slip force by the rules of Masing: turning points (from 0) and a position.

    From a turn on, the curve is the virgin one at twice the scale; a loop that closes is
    forgotten, and beyond all turns the virgin curve goes on.
    """

    def virgin(y: float) -> float:
        return float(np.sum(W * np.clip(y / d, -1, 1)))

    history = [0.0]
    for x_next in [*turns, x]:
        while len(history) > 1:
            last = history[-1]
            if len(history) == 2:  # the virgin curve is symmetric
                if abs(x_next) >= abs(last) and x_next * last <= 0:
                    history = [0.0]
                    continue
            elif (x_next - history[-2]) * (history[-2] - last) >= 0:
                del history[-2:]
                continue
            break
        history.append(x_next)
    F = virgin(history[1])
    for a, b in pairwise(history[1:]):
        F += 2 * virgin((b - a) / 2)
    return F


def test_maxwell_slip_unloads_along_the_virgin_curve_at_twice_its_scale() -> None:
    values = np.array(SETS["maxwell-slip"])
    W, d = values[:4], np.cumprod(values[4:8])
    values[8] = 0.0
    rng = np.random.default_rng(11)
    for _ in range(30):
        turns = rng.uniform(-1.5, 1.5, 6) * d[3] * 10 ** rng.uniform(-1.5, 0, 6)
        turns[1::2] = -np.sign(turns[0]) * np.abs(turns[1::2])
        turns[::2] = np.sign(turns[0]) * np.abs(turns[::2])
        steps = np.diff(turns, prepend=0.0)
        F, _ = walk(LAWS["maxwell-slip"], values, steps, np.ones(6))
        expected = [masing(W, d, turns[:k], turns[k]) for k in range(6)]
        np.testing.assert_allclose(F, expected, rtol=1e-9, atol=1e-9)


def test_two_sets_of_maxwell_elements_are_not_one_law_in_another_order() -> None:
    # Yield distances grow with the number of the element, so a permutation is another set of W.
    d = np.cumprod(np.array(SETS["maxwell-slip"])[4:8])
    assert (np.diff(d) > 0).all()
    for q in random_sets(LAWS["maxwell-slip"], 20, 12):
        assert (np.diff(np.cumprod(q[4:8])) > 0).all()


def test_gms_without_a_drop_is_maxwell_slip_whatever_its_lag() -> None:
    v, h = strokes()
    plain, general = LAWS["maxwell-slip"], LAWS["gms"]
    for p in random_sets(plain, 5, 13):
        for tau in (1e-4, 1.0):
            q = np.concatenate([p, [1.0, 1e-3, tau]])
            np.testing.assert_allclose(
                walk(general, q, v, h)[0], walk(plain, p, v, h)[0], rtol=1e-9, atol=1e-9
            )


def test_a_sliding_gms_element_follows_its_level_with_its_lag() -> None:
    law = law_named("gms:1")
    W, ratio, v_s, tau = 10.0, 1.6, 1e-3, 0.02
    p = np.array([W, 1e-6, 0.0, ratio, v_s, tau])

    def level(v: float) -> float:
        return 1 + (ratio - 1) * math.exp(-((v / v_s) ** 2))

    slow, fast = 5e-4, 2e-3
    t = np.array([1e-3, 5e-3, 2e-2])
    _, (z,) = walk(law, p, np.array([slow]), np.array([1.0]))
    up, _ = walk(law, p, np.full(3, fast), np.diff(t, prepend=0.0), z)
    drop = (level(slow) - level(fast)) * np.exp(-t / (tau * level(fast)))
    np.testing.assert_allclose(up, W * (level(fast) + drop), rtol=1e-12)
    # As fast as it can: always on the slip curve.
    p[-1] = 1e-12
    F, _ = walk(law, p, np.array([slow, fast, slow]), np.full(3, 1e-3), z)
    np.testing.assert_allclose(F, law.friction(np.array([slow, fast, slow]), p), rtol=1e-12)


def ramp_response(law: Law, p: Array, rate: float, seconds: float, h: float) -> tuple[Any, Any]:
    """1 kg under a force that grows from rest: force and velocity, by implicit steps."""
    z, out, v = np.zeros(law.states), np.zeros(law.states), 0.0
    F, speeds = rate * np.arange(1, round(seconds / h) + 1) * h, []
    for force in F:
        low, high = v - 1e-3, v + h * force + 1e-3
        for _ in range(60):  # 1 kg (w - v)/h + friction - force grows with w
            w = 0.5 * (low + high)
            if (w - v) / h + law.rub(w, h, z, NONE, p, out) > force:
                high = w
            else:
                low = w
        law.rub(v := 0.5 * (low + high), h, z, NONE, p, out)
        z, out = out.copy(), z
        speeds.append(v)
    return F, np.array(speeds)


@pytest.mark.parametrize("name", ["lugre", "elasto-plastic"])
def test_a_mass_breaks_away_at_static_friction(name: str) -> None:
    # The contact of the 1995 paper, Table I: F_C 1 N, F_S 1.5 N, pulled by 0.5 N/s.
    p = np.array([1e5, math.sqrt(1e5), 1.5, 1.0, 1e-3, 0.4, 0.5])[: len(LAWS[name].params)]
    F, v = ramp_response(LAWS[name], p, 0.5, 3.4, 1e-3)
    broke = F[np.argmax(v > 1e-3)]
    assert 1.47 < broke < 1.53
    assert np.abs(v[F < 1.2]).max() < 3e-5


def test_an_elastic_contact_holds_what_a_lugre_bristle_lets_creep() -> None:
    # 10,000 nudges of 0.1 µm about a deflection of half the Coulomb one.
    n, nudge = 10_000, 1e-7
    v = np.concatenate([[5e-6], np.tile([nudge, -nudge], n)])
    remainder = {}
    for name in ("lugre", "elasto-plastic"):
        p = np.array(SETS[name])
        p[1] = p[5] = 0.0
        F, _ = walk(LAWS[name], p, v, np.ones(len(v)))
        remainder[name] = F[-1] / F[0]
    assert math.isclose(remainder["elasto-plastic"], 1.0, rel_tol=1e-9)
    assert remainder["lugre"] < 0.1  # it has crept back to where nothing pulls


# --- energy ---------------------------------------------------------------------------------------


def loops(rng: np.random.Generator) -> list[tuple[Array, float]]:
    """Velocities of closed motions over one period, presliding to sliding, and their steps."""
    n = 600
    phase = 2 * math.pi * (np.arange(n) + 0.5) / n
    motions = []
    for amplitude in (1e-7, 2e-6, 1e-5, 1e-4, 5e-3):
        for period in (0.05, 2.0):
            scale, h = amplitude * 2 * math.pi / period, period / n
            motions.append((scale * np.cos(phase), h))
            c, s = rng.normal(size=(2, 5))
            wild = sum(c[k] * np.cos((k + 1) * phase) + s[k] * np.sin((k + 1) * phase)
                       for k in range(5))  # fmt: skip
            motions.append((scale * wild, h))
    return motions


@dynamic
def test_friction_takes_energy_from_every_closed_motion_once_it_has_settled(law: Law) -> None:
    rng = np.random.default_rng(14)
    sets = [active_sets(law)[0], *random_sets(law, 6, 14)]
    for p in sets:
        if "sigma_1" in law.names:
            # Known of LuGre (Barabanov and Ortega 2000, doi 10.1109/9.847131): more damping than
            # F_V F_C / (F_S - F_C) can feed energy back.
            i = {name: k for k, name in enumerate(law.names)}
            drop = p[i["F_S"]] / p[i["F_C"]] - 1
            p[i["sigma_1"]] = min(p[i["sigma_1"]], p[i["F_V"]] / drop)
        for v, h in loops(rng):
            F, _ = walk(law, p, np.tile(v, 6), np.full(6 * len(v), h))
            work, turned = h * F[-len(v) :] @ v, h * np.abs(F[-len(v) :]) @ np.abs(v)
            assert work >= -1e-9 * turned
