"""The free curve: its table, its prior, its balance of foreign motions, and formulas beside it."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from exported import model_of
from foreign import driven, strokes
from foreign.friction import Curve, level
from stribeck import Fit, Recording, identify, select
from stribeck.export.drive_table import table
from stribeck.friction import law_named
from stribeck.friction.curve import knots_of
from stribeck.identify.balance import curve_prior
from stribeck.rig.forced import FORCED

#: A drop that is over at 30 mm/s, and a slide of 10 kg that runs at 2 to 200 mm/s.
DROP, MASS = Curve(40.0, 25.0, 60.0, 1e-2), 10.0
SPEEDS = np.geomspace(2e-3, 0.2, 8)


@cache
def foreign_log() -> Recording:
    """Strokes at all speeds by a simulator that shares nothing with this package."""
    times, positions, _ = strokes.strokes(SPEEDS, 0.02)
    loop = driven.Loop(kp=4e4, kd=2e3, mass_ff=9.0, tick=1e-4)
    motion = driven.simulate(MASS, DROP, DROP, loop, times, positions)
    rng = np.random.default_rng(3)
    noisy = [x + s * rng.standard_normal(len(x))
             for x, s in ((motion.position, 1e-6), (motion.force, 0.3))]  # fmt: skip
    return Recording(t=motion.t, position=noisy[0], force=noisy[1])


@cache
def fit() -> Fit:
    return identify(foreign_log(), rig="forced", law="curve")


def test_the_law_is_linear_interpolation_between_its_knots() -> None:
    law = law_named("curve:5")
    p = np.array([10.0, 8.0, 6.0, 7.0, 20.0, 1e-3, 0.1])
    knots = np.geomspace(1e-3, 0.1, 5)
    np.testing.assert_allclose(knots_of(law, p), knots, rtol=1e-14)
    v = np.concatenate([np.geomspace(1e-5, 1.0, 500), knots])
    np.testing.assert_allclose(law.friction(v, p), np.interp(v, knots, p[:5]), rtol=1e-12)
    assert law.levels(p) == (-10.0, 10.0)


def test_coulomb_and_viscous_friction_has_no_roughness() -> None:
    law = law_named("curve-directional:6")
    v = np.geomspace(1e-3, 0.2, 6)
    straight = np.concatenate([20 + 90 * v, 15 + 40 * v, [1e-3, 0.2]])
    assert law.roughness is not None
    np.testing.assert_allclose(law.roughness(straight) @ straight, 0.0, atol=1e-13)
    bent = straight.copy()
    bent[3] += 2.0  # what a knot lies off the line is its roughness
    assert (law.roughness(bent) @ bent)[2] == pytest.approx(2.0)


def test_the_weight_of_the_prior_is_that_of_the_restricted_likelihood() -> None:
    """Known in closed form where every contrast is seen by itself: a normal of both variances."""
    rng = np.random.default_rng(5)
    m, noise = 30, 0.4
    D = np.eye(m)
    d = 1.5 * rng.standard_normal(m) + noise * rng.standard_normal(m)

    def cost(log_tau: float) -> float:
        total = np.exp(2 * log_tau) + noise**2
        return float(m * np.log(total) + d @ d / total - 2 * log_tau)

    best = np.exp(minimize_scalar(cost, bounds=(-6.0, 4.0), method="bounded").x)
    chosen = curve_prior.restricted(np.eye(m), d, D, noise**2, 1.0)
    step = curve_prior.TRIED[1] / curve_prior.TRIED[0]
    assert chosen == pytest.approx(best, rel=step - 1.0)
    assert chosen == pytest.approx(1.5, rel=0.25)


def test_levels_of_a_table_without_noise_are_found_exactly() -> None:
    law = law_named("curve:5")
    t = np.arange(0.0, 40.0, 1e-3)
    w = 0.5
    x, v, a = (0.1 * f for f in (np.sin(w * t), w * np.cos(w * t), -w * w * np.sin(w * t)))
    p = np.array([30.0, 26.0, 22.0, 25.0, 31.0, 1e-3, 0.05, 12.0, 2.0])
    force = FORCED.force(law, p, v, a)
    found = identify(
        Recording(t=t, position=x, force=force), rig="forced", law=law,
        fixed={"v_first": 1.0, "v_last": 50.0},
    )  # fmt: skip
    values = np.array([e.value for e in found.estimates])
    np.testing.assert_allclose(values[1:5], p[1:5], rtol=2e-3)
    assert found.values["M"] == pytest.approx(12.0, rel=2e-3)


def test_a_curve_holds_the_friction_of_a_foreign_axis_at_its_knots() -> None:
    found = fit()
    p = np.array([e.value for e in found.estimates])
    knots = knots_of(found.parameters.law, p)
    assert knots[0] < SPEEDS[1]
    assert knots[-1] > 0.95 * SPEEDS[-1]
    friction = np.array([level(v, DROP) for v in knots])
    estimates = found.estimates[: len(knots)]
    held = [e.low <= F <= e.high for e, F in zip(estimates, friction, strict=True)]
    assert sum(held) >= len(knots) - 1
    assert np.abs(p[: len(knots)] / friction - 1.0).max() < 0.02
    mass = next(e for e in found.estimates if e.value == found.values["M"])
    assert mass.low <= MASS <= mass.high


def test_speeds_that_the_log_has_not_are_known_less() -> None:
    """Between strokes at two speeds the prior alone holds the curve, and the intervals say so."""
    times, positions, _ = strokes.strokes(np.tile([2e-3, 0.2], 2), 0.02)
    loop = driven.Loop(kp=4e4, kd=2e3, mass_ff=9.0, tick=1e-4)
    motion = driven.simulate(MASS, DROP, DROP, loop, times, positions)
    force = motion.force + 0.3 * np.random.default_rng(4).standard_normal(len(motion.t))
    log = Recording(t=motion.t, position=motion.position, force=force)
    found = identify(log, rig="forced", law="curve:10")
    half = np.array([0.5 * (e.high - e.low) / e.value for e in found.estimates[:10]])
    assert np.isfinite(half).all()
    assert np.median(half[2:6]) > 3 * max(half[0], half[-1])


@pytest.mark.parametrize(
    ("ends", "knots"),
    [({"v_last": 1.0}, (5e-4, 1e-3)), ({"v_first": 300.0}, (0.3, 0.6))],
)
def test_an_end_that_is_set_keeps_the_other_on_its_side(
    ends: dict[str, float], knots: tuple[float, float]
) -> None:
    """A last knot below the slowest motion, mm/s, or a first one beyond the fastest."""
    fit = identify(foreign_log(), rig="forced", law="curve:5", fixed=ends)
    assert knots_of(fit.parameters.law, fit.p)[[0, -1]] == pytest.approx(knots)
    levels = [e for e in fit.estimates if e.name.startswith("F_")]
    assert {e.verdict for e in levels[1:-1]}.isdisjoint({"identified"})
    assert fit.warnings


def test_select_holds_a_formula_against_the_free_curve() -> None:
    chosen = select([foreign_log()], rig="forced", laws=["coulomb-viscous"], folds=2)
    assert chosen.curve is not None
    off = {k.speed: k.difference for k in chosen.curve.knots if k.differs}
    truth = {v: 35.1 / level(v, DROP) - 1.0 for v in off}  # a level and no slope, as it has to fall
    assert len(off) >= 10
    assert off == pytest.approx(truth, abs=0.01)
    assert "coulomb-viscous is within 3 % of it" in chosen.curve.sentence
    assert "but from 6.16 mm/s on (+28 %), up to " in chosen.curve.sentence
    assert chosen.sentences[-1] == chosen.curve.sentence
    drop = select([foreign_log()], rig="forced", laws=["stribeck"], folds=2).curve
    assert drop is not None
    assert not any(k.differs for k in drop.knots if k.speed > 3e-3)
    assert select([foreign_log()], rig="forced", laws=["curve:6"], folds=2).curve is None


def test_a_drive_holds_the_curve_without_an_error_at_its_own_knots() -> None:
    model = model_of("curve")
    knots = knots_of(model.law, model.p)
    lookup = table(model, len(knots) + 1, float(knots[-1]))
    np.testing.assert_allclose(lookup.plus.speeds[1:], knots, rtol=1e-9)
    assert lookup.plus.worst < 1e-6 * lookup.largest
