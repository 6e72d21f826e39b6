"""Friction and force that vary with position, on a foreign axis whose period and size are known."""

from __future__ import annotations

from functools import cache
from math import cos, pi, sin

import numpy as np
import pytest

from foreign import driven, friction, strokes
from stribeck import InputError, identify, select
from stribeck.data.recording import Recording
from stribeck.friction import law_named
from stribeck.friction.law import POSITION, term_places, terms_factor
from stribeck.identify.result import Fit
from stribeck.rig.balanced import wave

#: Of the axis: N, N s/m, kg.
F_C, F_V, MASS = 20.0, 100.0, 20.0
WAVE, WAVE_PERIOD = 0.2, 0.012
COGGING, COGGING_PERIOD = 4.0, 0.016


@cache
def log(name: str, tick: float = 1e-4) -> Recording:
    """Strokes of 15 cm at three speeds, with white noise on force and position, 1 kHz.

    The drive holds its force for a tick. The log has what it sets at each sample, so that with a
    tick of a sample the force is half a sample ahead of what acts.
    """
    extras = {
        "wave": driven.Extras(wave=WAVE, wave_period=WAVE_PERIOD),
        "cogging": driven.Extras(cogging=COGGING, cogging_period=COGGING_PERIOD),
    }[name]
    t, x, _ = strokes.strokes(np.array([0.04, 0.08, 0.2]), 0.15)
    curve = friction.coulomb_viscous(F_C, F_V)
    loop = driven.Loop(kp=4e5, kd=4e3, mass_ff=MASS, tick=tick)
    motion = driven.simulate(MASS, curve, curve, loop, t, x, extras)
    rng = np.random.default_rng(0)
    white = rng.standard_normal((2, len(motion.t)))
    return Recording(
        t=motion.t, position=motion.position + 1e-6 * white[0], force=motion.force + 0.3 * white[1]
    )


def assert_known(fit: Fit, truth: dict[str, float]) -> None:
    """The intervals hold the truth but for 2 in 1000 of it, and are narrow.

    Intervals are of noise: on this axis M comes out 1 in 1000 low without any.
    """
    estimates = {e.name: e for e in fit.estimates}
    for name, value in truth.items():
        e = estimates[name]
        slack = 0.002 * abs(value)
        assert e.low - slack <= value <= e.high + slack, (name, e.low, e.high)
        assert e.high - e.low <= 0.2 * abs(value) or e.verdict != "identified"


def test_friction_that_varies_with_position_is_found_with_its_period() -> None:
    fit = identify(log("wave"), rig="forced", law="coulomb-viscous+position")
    truth = {"F_C": F_C, "F_V": F_V, "M": MASS, "pos_cos": WAVE, "pos_sin": 0.0}
    assert_known(fit, truth | {"pos_period": WAVE_PERIOD})
    verdicts = {e.name: e.verdict for e in fit.estimates}
    assert verdicts["pos_cos"] == verdicts["pos_period"] == "identified"
    assert not [w for w in fit.warnings if "ended at" in w]


@pytest.mark.parametrize(("name", "term"), [("wave", "position"), ("cogging", "cogging")])
def test_intervals_hold_what_half_a_sample_moves(name: str, term: str) -> None:
    """A force that is held for a sample moves F_C by 0.2 % and F_V by 0.7 %."""
    fit = identify(log(name, 1e-3), rig="forced", law=f"coulomb-viscous+{term}")
    for e in fit.estimates:
        if e.name in ("F_C", "F_V", "M"):
            assert e.low <= {"F_C": F_C, "F_V": F_V, "M": MASS}[e.name] <= e.high
            assert e.verdict == "identified"


def test_a_law_with_a_curve_and_a_wave_can_be_run() -> None:
    held = {"v_SS": 1.0, "pos_period": WAVE_PERIOD}
    fit = identify(log("wave"), rig="forced", law="stribeck+position:2", fixed=held)
    values = {e.name: e.value for e in fit.estimates}
    assert values["pos_cos"] == pytest.approx(WAVE, rel=0.05)
    assert abs(values["pos_cos_2"]) < 0.02


def test_cogging_is_the_same_both_ways_and_is_found_with_its_period() -> None:
    fit = identify(log("cogging"), rig="forced", law="coulomb-viscous+cogging")
    truth = {"F_C": F_C, "F_V": F_V, "M": MASS, "cog_sin": COGGING, "cog_cos": 0.0}
    assert_known(fit, truth | {"cog_period": COGGING_PERIOD})
    cogging = next(e for e in fit.estimates if e.name == "cog_period")
    assert cogging.verdict == "identified"


def test_the_term_that_the_axis_has_is_warranted() -> None:
    laws = ["coulomb-viscous", "coulomb-viscous+cogging"]
    selection = select(log("cogging"), rig="forced", laws=laws, folds=2)
    assert selection.law == "coulomb-viscous+cogging"
    assert [(f.ingredient, f.warranted) for f in selection.findings] == [("cogging", True)]


def test_compiled_and_plain_waves_agree() -> None:
    law = law_named("coulomb-viscous+temperature+position:3")
    rng = np.random.default_rng(2)
    amplitudes = rng.uniform(-0.1, 0.1, 6)
    p = np.concatenate([[20.0, 100.0, 0.0, 293.15], amplitudes, [0.07]])
    for x in rng.uniform(-1, 1, 5):
        load = np.zeros(5)
        load[POSITION], load[4] = x, 293.15
        by_hand = 1 + sum(
            amplitudes[2 * k] * cos(2 * pi * (k + 1) * x / 0.07)
            + amplitudes[2 * k + 1] * sin(2 * pi * (k + 1) * x / 0.07)
            for k in range(3)
        )
        assert terms_factor(term_places(law), p, load) == pytest.approx(by_hand, rel=1e-12)
        assert 1 + wave(p[law.place("position")], np.array([x]))[0] == pytest.approx(by_hand)


@pytest.mark.parametrize(
    ("law", "message"),
    [
        ("stribeck+temperature:2", "position and cogging have 1 to 6 harmonics"),
        ("stribeck+position:7", "have 1 to 6 harmonics"),
        ("stribeck+position:x", "'x' is no number of harmonics"),
        ("stribeck+cogging+cogging", "each once"),
    ],
)
def test_what_is_no_term_is_refused(law: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        law_named(law)


def test_cogging_takes_a_measured_force() -> None:
    with pytest.raises(InputError, match="cogging is told from a measured force"):
        identify(log("cogging"), rig="slide-bed", law="stribeck+cogging")
