"""Axes that move one way only: what is friction there and what a constant force."""

from __future__ import annotations

from functools import cache
from itertools import pairwise

import numpy as np
import pytest

from foreign import driven, sensors
from foreign.friction import coulomb_viscous
from stribeck import Recording, identify, select
from stribeck.identify.adequacy.patterns import patterns
from stribeck.identify.adequacy.residual_rows import ResidualRows

LOOP = driven.Loop(kp=4e4, kd=2e3, ki=1e5, mass_ff=9.0)
F_C, F_V, OFFSET = 20.0, 60.0, 2.0


@cache
def conveyor() -> Recording:
    """Speeds between rest and 0.4 m/s, all of them forwards, with force noise."""
    rng = np.random.default_rng(1)
    levels = [0.0, *rng.permutation([0.02, 0.05, 0.1, 0.2, 0.3, 0.4] * 2).tolist(), 0.0]
    dt, runs = 1e-3, []
    for a, b in pairwise(levels):
        runs += [np.linspace(a, b, int(abs(b - a) / dt) + 1), np.full(600, b)]
    v = np.concatenate(runs)
    x = np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) * dt)])
    curve = coulomb_viscous(F_C, F_V)
    extras = driven.Extras(offset=OFFSET)
    table = driven.simulate(10.0, curve, curve, LOOP, dt * np.arange(len(v)), x, extras)._asdict()
    table = sensors.noisy(table, "force", 3.0, rng, memory=5.0)
    table = sensors.quantised(table, "position", 1e-6)
    return Recording(table["t"], table["position"], force=table["force"])


def test_an_offset_is_held_and_told() -> None:
    fit = identify(conveyor(), rig="forced", law="coulomb-viscous")
    estimates = dict(zip(fit.parameters.names, fit.estimates, strict=True))
    assert estimates["F_C"].value == pytest.approx(F_C + OFFSET, rel=0.02)
    assert (estimates["F_C"].verdict, estimates["F_C"].reason) == ("weak", "data")
    assert estimates["offset"].verdict == "fixed"
    assert estimates["F_V"].verdict == "identified"
    assert "one way only" in fit.warnings[0]
    assert "offset is held at 0 and is part of F_C" in fit.warnings[0]


def test_an_offset_that_is_known_leaves_the_friction_identified() -> None:
    fit = identify(conveyor(), rig="forced", law="coulomb-viscous", fixed={"offset": OFFSET})
    estimates = dict(zip(fit.parameters.names, fit.estimates, strict=True))
    assert estimates["F_C"].value == pytest.approx(F_C, rel=0.02)
    assert estimates["F_C"].verdict == "identified"
    assert not any("one way" in w for w in fit.warnings)


def test_a_range_for_the_offset_leaves_it_free() -> None:
    fit = identify(conveyor(), rig="forced", law="coulomb-viscous", bounds={"offset": (-5, 5)})
    low, high = fit.intervals["F_C"]
    assert low < F_C < high
    assert high - low > 9


def test_laws_are_compared_without_an_offset() -> None:
    laws = ["coulomb-viscous", "stribeck", "coulomb-viscous-directional"]
    selection = select(conveyor(), rig="forced", laws=laws)
    assert selection.excluded == ("coulomb-viscous-directional",)
    assert all("offset" not in {q.name for q in c.parameters.free} for c in selection.candidates)


@pytest.mark.parametrize(("back", "is_asked"), [(0, False), (3, False), (40, True)])
def test_a_difference_of_directions_is_asked_of_both(back: int, is_asked: bool) -> None:
    n = 400
    v = 0.1 + 0.05 * np.sin(np.arange(n))
    v[:back] *= -1
    zero = np.zeros(n)
    rows = ResidualRows(
        log=np.zeros(n, dtype=np.intp), t=np.linspace(0.0, 4.0, n), position=np.cumsum(v),
        velocity=v, acceleration=zero, residual=zero, jacobian=zero[:, None], names=("F_C",),
        values=np.ones(1), half_widths=np.ones(1),
    )  # fmt: skip
    names = {p.name for p in patterns(rows, "speed", "force")}
    assert ("side" in names) == is_asked
    assert "drop" in names
