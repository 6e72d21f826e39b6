"""Pulls beside an axis, of a rhythm that its motion does not have, are told; slow noise is not."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from foreign import driven, sensors
from foreign.friction import coulomb_viscous
from foreign.strokes import sines
from stribeck import Recording, identify
from stribeck.identify.adequacy.bins import signs
from stribeck.identify.adequacy.patterns import tone
from stribeck.identify.adequacy.residual_rows import ResidualRows, blocks
from stribeck.identify.result import Fit

LOOP = driven.Loop(kp=4e4, kd=2e3, ki=1e5, mass_ff=9.0)
TRUTH = {"M": 10.0, "F_C": 20.0, "F_V": 60.0}


def log(seed: int, pull: float, frequency: float, extras: driven.Extras, *, one: bool) -> Recording:
    """Sines of one frequency or of three, 24 s, with a pull on the force that begins anywhere."""
    rng = np.random.default_rng(seed)
    sizes, tones = ([0.1], [0.4]) if one else ([0.09, 0.04, 0.015], [0.31, 0.83, 2.1])
    both = coulomb_viscous(TRUTH["F_C"], TRUTH["F_V"])
    t, x = sines(24.0, np.array(sizes), np.array(tones))
    table = driven.simulate(10.0, both, both, LOOP, t, x, extras)._asdict()
    turn = 2 * np.pi * (frequency * table["t"] + rng.uniform())
    table = sensors.noisy(
        table | {"force": table["force"] + pull * np.sin(turn)}, "force", 0.5, rng
    )
    table = sensors.quantised(table, "position", 1e-6)
    return Recording(table["t"], table["position"], force=table["force"])


@cache
def fitted(
    pull: float, frequency: float, logs: int, *, one: bool = False, cogging: float = 0.0
) -> Fit:
    extras = driven.Extras(cogging=cogging, cogging_period=0.2)
    made = [log(k, pull, frequency, extras, one=one) for k in range(logs)]
    return identify(made, rig="forced", law="coulomb-viscous")


def waves(fit: Fit) -> list[str]:
    """What is told of waves in time."""
    return [v.sentence for v in fit.violations if "wave in time" in v.sentence]


@pytest.mark.parametrize("logs", [1, 3])
@pytest.mark.parametrize("frequency", [0.23, 0.57, 1.4])
def test_a_pull_is_told_with_its_period_and_intervals_hold_the_truth(
    frequency: float, logs: int
) -> None:
    """Each log has it at another phase."""
    fit = fitted(6.0, frequency, logs)
    assert fit.effects is not None
    (first, *_) = fit.effects.effects
    assert first.pattern == "tone"
    assert first.scale == pytest.approx(1.0 / frequency, rel=0.01)
    assert first.size == pytest.approx(6.0 / np.sqrt(2.0), rel=0.25)
    (sentence,) = waves(fit)
    assert "something beside the axis pulls" in sentence
    for e in fit.estimates:
        if e.name in TRUTH:
            assert e.low <= TRUTH[e.name] <= e.high, e.name


@pytest.mark.parametrize("one", [False, True])
def test_an_axis_alone_has_none(one: bool) -> None:
    assert waves(fitted(0.0, 1.0, 1, one=one)) == []


def test_what_goes_with_the_motion_is_none_though_its_residual_is_a_tone() -> None:
    """Cogging of the period of a sine's travel makes a third and a fifth harmonic of it."""
    fit = fitted(0.0, 1.0, 1, one=True, cogging=6.0)
    assert fit.effects is not None
    assert ("position", "wave") in [(e.variable, e.pattern) for e in fit.effects.effects]
    assert waves(fit) == []


def test_a_gap_of_a_year_takes_no_spectrum() -> None:
    """At 100 Hz that would be a table of three thousand million instants."""
    t = 0.01 * np.arange(4000.0)
    t[2000:] += 3e7
    v, a = np.cos(2 * np.pi * 0.31 * t), -np.sin(2 * np.pi * 0.31 * t)
    rows = ResidualRows(
        np.zeros(4000, dtype=np.intp), t, a, v, a, np.sin(2 * np.pi * 1.3 * t), v[:, None],
        ("F_V",), np.ones(1), np.ones(1),
    )  # fmt: skip
    block = blocks(rows)
    assert tone(rows, block, signs(block)) is None


@pytest.mark.parametrize("memory", [1, 20, 100, 400])
def test_noise_that_forgets_slowly_has_none(memory: int) -> None:
    """Rows of 40 s at 100 Hz, in two logs; a memory of 400 rows is a tenth of each."""
    heard = 0
    for seed in range(60):
        rng = np.random.default_rng(seed)
        noise, keep = rng.normal(size=8000), np.exp(-1.0 / memory)
        for k in range(1, len(noise)):
            noise[k] += keep * noise[k - 1]
        t = np.tile(0.01 * np.arange(4000), 2)
        v = np.cos(2 * np.pi * 0.31 * t) + 0.4 * np.cos(2 * np.pi * 0.83 * t)
        x, a = np.cumsum(v) * 0.01, np.gradient(v, 0.01)
        rows = ResidualRows(
            np.repeat([0, 1], 4000), t, x, v, a, noise, np.column_stack([a, v, np.sign(v)]),
            ("M", "F_V", "F_C"), np.ones(3), np.ones(3),
        )  # fmt: skip
        block = blocks(rows)
        found = tone(rows, block, signs(block))
        heard += found is not None and found[1] <= 1e-3
    assert heard == 0
