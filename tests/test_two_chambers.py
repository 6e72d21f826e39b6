"""A cylinder by the pressures in its two chambers: a foreign simulator's rod comes back."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from foreign import chambers
from stribeck import InputError, Recording, identify
from stribeck.data.quality import check
from stribeck.rig.two_chambers import TWO_CHAMBERS

AXIS = chambers.Chambers(M=8.0, F_C=15.0, F_V=250.0, mu=1e-4, offset=2.0)
RIG = TWO_CHAMBERS.set(bore=50.0, rod=20.0)


def log(seed: int = 0) -> Recording:
    """A rod that goes to and fro for 20 s, its pressures swinging by 4 bar, with noise."""
    t = np.asarray(1e-3 * np.arange(20_000), dtype=np.float64)
    command = 0.06 * np.sin(2 * np.pi * 0.4 * t) + 0.01 * np.sin(2 * np.pi * 1.3 * t)
    m = chambers.simulate(AXIS, command, 2e5 * np.sin(2 * np.pi * 0.07 * t))
    rng = np.random.default_rng(seed)
    pressure, back = (
        p + 200.0 * rng.standard_normal(len(t)) for p in (m.pressure, m.back_pressure)
    )
    x = m.position + 1e-6 * rng.standard_normal(len(t))
    return Recording(t=t, position=x, pressure=pressure, back_pressure=back)


def test_mass_friction_and_its_share_of_the_pressure_difference_come_back() -> None:
    fit = identify(log(), rig=RIG, law="coulomb-load")
    truth = AXIS._asdict()
    for name, rel in (("M", 0.02), ("F_C", 0.05), ("F_V", 0.03), ("mu", 0.05)):
        assert fit.values[name] == pytest.approx(truth[name], rel=rel), name
    missed = [
        q.name
        for q, e in zip(fit.parameters.every, fit.estimates, strict=True)
        if not e.low <= truth[q.name] <= e.high
    ]
    assert not missed
    assert {e.name for e in fit.estimates} == {"F_C", "F_V", "mu_p", "M", "offset"}


def test_a_log_of_two_pressures_is_known_as_one() -> None:
    assert check(log()).rig == "two-chambers"


def test_a_log_without_a_pressure_is_refused_in_a_line() -> None:
    whole = log()
    for lacking, told in (
        (replace(whole, pressure=None), "map a column to pressure, as"),
        (replace(whole, back_pressure=None), "map a column to back_pressure, as"),
    ):
        with pytest.raises(InputError, match=told) as refusal:
            identify(lacking, rig=RIG)
        assert "\n" not in str(refusal.value)


def test_a_rod_as_thick_as_the_bore_is_refused() -> None:
    with pytest.raises(InputError, match="it is thinner than the bore, 50 mm"):
        identify(log(), rig=TWO_CHAMBERS.set(bore=50.0, rod=50.0))
