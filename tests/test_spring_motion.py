"""The exact motion of a mass on Maxwell elements: closed forms, explicit steps, ours."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm

from foreign import presliding
from stribeck import Recording
from stribeck.friction import law_named
from stribeck.rig.motion.drives import AXIS, FORCE_LIMIT
from stribeck.rig.motion.implicit import motions_over
from stribeck.rig.motion.spring_motion import MOST_SWING, response, spring_motions, swings
from stribeck.rig.motion.track import Track
from stribeck.rig.presliding import PRESLIDING as RIG

ONE, TWO = law_named("maxwell-slip:1"), law_named("maxwell-slip:2")


def pushed(t: Any, force: Any) -> Recording:
    """A log of a force, at rest."""
    t, force = np.asarray(t, dtype=np.float64), np.asarray(force, dtype=np.float64)
    return Recording(t=t, position=np.zeros_like(t), force=force)


def track(t: Any, force: Any) -> Track:
    return RIG.track(pushed(t, force), slice(0, len(t)), 0.0, np.ones(len(t)))


@pytest.mark.parametrize("stiffness", [0.0, 1e-4, 0.2, 3.0, 900.0])
@pytest.mark.parametrize("damping", [0.0, 1e-3, 0.3, 2.0, 80.0])
def test_response_is_a_matrix_exponential(damping: float, stiffness: float) -> None:
    """y of y'' + 2γ y' + ω² y = v δ + u + r τ, from the exponential of its four states."""
    A = np.array([
        [0.0, 1.0, 0.0, 0.0], [-stiffness, -damping, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0], [0.0] * 4
    ])  # fmt: skip
    for tau in (1e-3, 0.3, 1.0):
        E = expm(tau * A)
        want = [E[1, 1], E[0, 1], E[0, 2], E[0, 3]]
        assert response(damping, stiffness, tau) == pytest.approx(want, rel=1e-10, abs=1e-14)


def test_an_element_swings_yields_and_swings_on() -> None:
    """A step of force on one element: a cosine up to its yield, a parabola, from the turn a cosine.

    The force rises within a nanosecond, too short to matter.
    """
    M, W, d, F = 2.0, 3.0, 1e-6, 2.0
    K, w = W / d, np.sqrt(W / d / M)
    t = np.concatenate([[0.0, 1e-9], np.linspace(2e-9, 6.0 / w, 400)])
    force = np.where(t > 0.0, F, 0.0)
    log = pushed(t, force)
    moved = RIG.simulate(ONE, np.array([[W, d, 0.0, M, 0.0]]), log).position[0]
    yields = np.arccos(1.0 - d * K / F) / w
    v = F / K * w * np.sin(w * yields)
    turns = yields + v * M / (W - F)
    top = d + 0.5 * v * v * M / (W - F)
    expected = np.where(
        t < yields,
        F / K * (1.0 - np.cos(w * t)),
        np.where(
            t < turns,
            d + v * (t - yields) - 0.5 * (W - F) / M * (t - yields) ** 2,
            top - (W - F) / K * (1.0 - np.cos(w * (t - turns))),
        ),
    )
    assert (expected > d).any()
    assert t[-1] > turns
    np.testing.assert_allclose(moved, expected, rtol=0.0, atol=1e-6 * top)


def test_random_axes_move_as_explicit_steps_move_them() -> None:
    """Two elements under uneven cycles that end in sliding; a foreign simulator by steps of 2 µs.

    Its explicit steps err by their length; extrapolated from two lengths they agree to 1e-5.
    """
    rng = np.random.default_rng(5)
    t = 2e-3 * np.arange(301)
    force = (0.5 + 10.0 * t) * np.sin(2.0 * np.pi * 4.0 * t) + 1.5 * np.sin(2.0 * np.pi * 31.0 * t)
    for _ in range(6):
        W, d, r = rng.uniform(1.0, 4.0, 2), 10 ** rng.uniform(-6.0, -5.0), rng.uniform(2.0, 8.0)
        F_V, M, offset = rng.uniform(0.0, 300.0), rng.uniform(1.0, 20.0), rng.uniform(-0.3, 0.3)
        contact = (W, d * np.array([1.0, r]), F_V)
        coarse, fine = (
            presliding.simulate(M, contact, t, force, offset=offset, dt=2e-3, h=h).position
            for h in (4e-6, 2e-6)
        )
        own = RIG.simulate(
            TWO,
            np.array([[*W, d, r, F_V, M, offset]]),
            pushed(t, force),
        ).position[0]
        far = float(np.ptp(own))
        assert np.abs(own - (2.0 * fine - coarse)).max() < 1e-5 * far


def test_exact_motions_and_steps_agree_where_one_takes_over_from_the_other() -> None:
    """Sets that swing by up to 10 rad between samples: both within 1e-3 of the way they go."""
    t = 5e-3 * np.arange(200)
    force = (1.0 + 2.0 * t) * np.sin(2.0 * np.pi * 2.0 * t)
    tracks = (track(t, force),)
    p = np.array([
        [1.0, 2.0, 2e-6, 5.0, 200.0, M, 0.1] for M in np.geomspace(0.3, 3000.0, 9)
    ])  # fmt: skip
    c = RIG.constants_over(TWO, p[:, 5:], tracks)
    swing = swings(TWO, p[:, :5], c, tracks)
    assert swing.min() < 0.1
    assert swing.max() > 0.7 * MOST_SWING
    exact, _, F = spring_motions(TWO, p[:, :5], c, tracks)
    stepped, _, G = motions_over(TWO, AXIS, p[:, :5], c, tracks, 20e-3, 1e-11)
    far = np.ptp(exact, axis=1)
    assert (np.abs(exact - stepped).max(axis=1) < 1e-3 * far).all()
    np.testing.assert_allclose(F, G, rtol=1e-12)


def test_a_motor_with_limits_or_a_term_is_stepped() -> None:
    """What is not a mass under a force on springs is not taken for one."""
    t = 1e-3 * np.arange(50)
    tracks = (track(t, np.sin(t)),)
    p = np.array([[1.0, 2.0, 2e-6, 5.0, 200.0]])
    c = RIG.constants_over(TWO, np.array([[1.0, 0.0]]), tracks)
    assert np.isfinite(swings(TWO, p, c, tracks)).all()
    assert np.isnan(swings(law_named("gms:2"), p, c, tracks)).all()
    assert np.isnan(swings(TWO.with_term("temperature"), p, c, tracks)).all()
    c[:, :, FORCE_LIMIT] = 5.0
    assert np.isnan(swings(TWO, p, c, tracks)).all()
