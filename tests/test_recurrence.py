"""What a balance leaves out without a name is told where it comes back with the motion."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, partial

import numpy as np
import pytest

from foreign import driven, sensors
from foreign.friction import coulomb_viscous
from foreign.strokes import sines, strokes
from stribeck import Recording, identify
from stribeck.identify.result import Fit

TRUTH = {"M": 12.0, "F_C": 18.0, "F_V": 70.0}
CARRIED = 4.0
WORDS = "comes back wherever position, velocity and acceleration do"


#: What is in the force besides.
UNNAMED: dict[str, Callable[[sensors.Table], sensors.Table]] = {
    "load one way": partial(sensors.carried, channel="force", mass=CARRIED),
    "process force": partial(sensors.pushed, channel="force", size=8.0, low=0.03, high=0.08),
    "braking": partial(sensors.braked, channel="force", size=4.0),
}


@cache
def fitted(fault: str, motion: str, seed: int = 0, memory: float = 0.0) -> Fit:
    rng = np.random.default_rng(seed)
    if motion == "sines":
        t, x = sines(24.0, np.array([0.06, 0.03, 0.01]), np.array([0.31, 0.83, 2.3]))
    else:
        speeds = np.repeat([0.04, 0.08, 0.15, 0.22, 0.3], 3)
        t, x, _ = strokes(speeds, 0.12)
    curve = coulomb_viscous(TRUTH["F_C"], TRUTH["F_V"])
    loop = driven.Loop(kp=4e4, kd=2e3, mass_ff=11.0)
    m = driven.simulate(TRUTH["M"], curve, curve, loop, t, x, driven.Extras(offset=2.0))._asdict()
    m = UNNAMED[fault](m) if fault else m
    m = sensors.noisy(m, "force", 0.4, rng, memory=memory)
    m = sensors.noisy(m, "position", 2e-6, rng)
    log = Recording(m["t"], m["position"], force=m["force"])
    return identify(log, rig="forced", law="coulomb-viscous")


def told(fit: Fit) -> list[str]:
    return [w for w in fit.warnings if WORDS in w]


@pytest.mark.parametrize("motion", ["strokes", "sines"])
@pytest.mark.parametrize("fault", UNNAMED)
def test_what_has_no_name_is_told_with_what_it_may_move(fault: str, motion: str) -> None:
    fit = fitted(fault, motion)
    assert fit.effects is not None
    assert fit.effects.recurrence is not None
    for e in fit.estimates:
        wrong = e.name in TRUTH and not e.low <= TRUTH[e.name] <= e.high
        if e.verdict == "identified" and wrong and abs(e.value / TRUTH[e.name] - 1) > 0.03:
            (sentence,) = told(fit)
            assert f"{e.name} by " in sentence


def test_what_it_would_take_is_about_what_a_value_is_off_by() -> None:
    """Friction that is greater while the axis is braked: F_C is identified, 2 N above the truth."""
    fit = fitted("braking", "sines")
    level = next(e for e in fit.estimates if e.name == "F_C")
    off = abs(level.value - TRUTH["F_C"])
    assert level.verdict == "identified"
    assert off > 1.0
    assert level.value - level.low < off
    (sentence,) = told(fit)
    shown = float(sentence.split("F_C by ")[1].split()[0])
    assert 0.5 * off < shown < 3.0 * off


def test_where_both_masses_are_seen_the_interval_holds_them() -> None:
    """On sines a load that is carried one way stays for some phases."""
    fit = fitted("load one way", "sines")
    mass = next(e for e in fit.estimates if e.name == "M")
    assert mass.verdict == "weak"
    assert mass.low < TRUTH["M"] + 0.1
    assert mass.high > TRUTH["M"] + CARRIED - 0.1
    assert any("an inertia that comes and goes" in w for w in fit.warnings)


@pytest.mark.parametrize("memory", [0.0, 20.0, 60.0])
@pytest.mark.parametrize("motion", ["strokes", "sines"])
@pytest.mark.parametrize("seed", range(3))
def test_noise_does_not_come_back(seed: int, motion: str, memory: float) -> None:
    """However long it remembers: it is predicted worse than by nothing."""
    fit = fitted("", motion, seed, memory)
    assert fit.effects is not None
    assert fit.effects.looks  # it was looked at
    assert fit.effects.recurrence is None
    assert not told(fit)
