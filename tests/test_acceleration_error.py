"""Slow strokes before fast ones, by a noisy position: no inertia that changes, and none that hides.

Noise of the acceleration makes the inertia of slow strokes smaller than that of fast ones.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest

from foreign import driven, sensors
from foreign.friction import coulomb_viscous
from foreign.strokes import strokes
from stribeck import Recording, identify
from stribeck.friction import law_named
from stribeck.identify.balance import noisier_balance
from stribeck.identify.balance.balance import balance
from stribeck.identify.balance.balance_rows import balance_rows
from stribeck.identify.balance.noisier_balance import DRAWS, NoisierBalance, noisier_logs
from stribeck.identify.parameters import partition
from stribeck.identify.result import Fit
from stribeck.rig.lookup import rig_named

MASS = 12.0
SPEEDS = np.repeat((0.005, 0.01, 0.02, 0.05, 0.1, 0.15, 0.25), 2)


@cache
def fitted(noise: float, seed: int, load: float = 0.0) -> tuple[Fit, float]:
    """A balance, and the time at which a load of some kg is picked up."""
    rng = np.random.default_rng(seed)
    t, x, _ = strokes(SPEEDS, 0.12)
    curve, at = coulomb_viscous(18.0, 70.0), 0.97 * t[-1]
    loop = driven.Loop(kp=4e4, kd=2e3, mass_ff=11.0)
    m = driven.simulate(MASS, curve, curve, loop, t, x, driven.Extras(offset=2.0))._asdict()
    m = sensors.loaded(m, "force", load, at)
    m = sensors.noisy(sensors.noisy(m, "force", 0.4, rng), "position", noise, rng)
    log = Recording(m["t"], m["position"], force=m["force"])
    return identify(log, rig="forced", law="coulomb-viscous"), at


def inertias(fit: Fit) -> list[float]:
    """Times at which an inertia is told to change."""
    assert fit.effects is not None
    return [e.scale for e in fit.effects.effects if e.kind == "inertia"]


@pytest.mark.parametrize("noise", [2e-6, 5e-6])
@pytest.mark.parametrize("seed", range(2))
def test_noise_is_no_inertia_that_changes(noise: float, seed: int) -> None:
    """And what it takes off the mass is put back, at 5 um 4 % of it."""
    fit, _ = fitted(noise, seed)
    assert not inertias(fit)
    mass = next(e for e in fit.estimates if e.name == "M")
    assert mass.verdict == "identified"
    assert mass.low < MASS < mass.high
    assert mass.value == pytest.approx(MASS, rel=0.01)


@pytest.mark.parametrize("noise", [2e-6, 5e-6])
@pytest.mark.parametrize("seed", range(2))
def test_a_load_is_still_told_with_its_time(noise: float, seed: int) -> None:
    fit, at = fitted(noise, seed, 2.0)
    assert inertias(fit)[0] == pytest.approx(at, abs=3.0)
    mass = next(e for e in fit.estimates if e.name == "M")
    assert mass.low < MASS
    assert mass.high > MASS + 2.0


@pytest.mark.parametrize(("room", "times"), [(1 << 25, 1), (1000, 2)])
def test_what_is_drawn_is_the_same_each_time_and_kept_unless_it_is_much(
    monkeypatch: pytest.MonkeyPatch, room: int, times: int
) -> None:
    monkeypatch.setattr(noisier_balance, "KEPT", room)
    rng = np.random.default_rng(2)
    t = np.arange(0.0, 20.0, 2e-3)
    x, v = 0.05 * np.sin(2.0 * t), 0.1 * np.cos(2.0 * t)
    force = MASS * -0.2 * np.sin(2.0 * t) + 18.0 * np.sign(v) + rng.normal(0.0, 0.4, len(t))
    log = Recording(t, x + rng.normal(0.0, 2e-6, len(t)), force=force)
    law = law_named("coulomb-viscous")
    solved = balance(log, partition(rig_named("forced"), law))
    estimates = identify(log, rig="forced", law=law).estimates
    logs_drawn = []

    def counted(*arguments: Any) -> Any:
        logs_drawn.append(1)
        return noisier_logs(*arguments)

    monkeypatch.setattr(noisier_balance, "noisier_logs", counted)
    noisier = NoisierBalance(solved, [log], [None])
    rows = balance_rows(solved, estimates, None, noisier)
    assert rows.noisier is not None
    first, second = list(rows.noisier()), list(rows.noisier())
    assert len(logs_drawn) == DRAWS * times
    assert len(first) == len(second) == DRAWS
    for before, after in zip(first, second, strict=True):
        assert [a.tobytes() for a in before] == [a.tobytes() for a in after]
    assert first[0][1].tobytes() != first[1][1].tobytes()
