"""A voltage cut off below noise, and a drive at its limit, on logs of a foreign cascade."""

from __future__ import annotations

import numpy as np
import pytest

from foreign import sensors
from foreign.clock import Array
from foreign_axes import emps
from stribeck import RIGS, Recording, identify
from stribeck.identify.result import Fit

AXIS = emps()


def fitted(limit: float, noise: float, seed: int) -> Fit:
    """The slide under a cascade whose drive gives 10 V at most; its voltage as it was measured."""
    (run,) = AXIS.tables
    rng = np.random.default_rng(seed)
    run = sensors.noisy(run, "position", 1e-6, rng)
    run = sensors.noisy(sensors.clipped(run, "voltage", limit), "voltage", noise, rng)
    log = Recording(run["t"], run["position"], command=run["command"], voltage=run["voltage"])
    return identify(log, rig=RIGS["emps"], law="coulomb-viscous")


def cut_off(fit: Fit) -> list[str]:
    return [w for w in fit.warnings if "cut off" in w]


@pytest.mark.parametrize(("limit", "times"), [(3.0, 10 / 3), (6.0, 10 / 6)])
def test_what_others_ask_for_tells_a_measurement_that_is_cut_off(
    limit: float, times: float
) -> None:
    fit = fitted(limit, 0.05, 0)
    (sentence,) = cut_off(fit)
    assert float(sentence.split("ask for ")[1].split()[0]) == pytest.approx(times, rel=0.1)
    assert "identified" not in {e.verdict for e in fit.estimates}


@pytest.mark.parametrize("noise", [0.02, 0.05, 0.2])
def test_a_drive_at_its_limit_is_not_cut_off(noise: float) -> None:
    """It gives 10 V for a sixth of the log, which is what moves the slide."""
    voltage: Array = AXIS.tables[0]["voltage"]
    assert np.mean(np.abs(voltage) > 9.9) > 0.1
    fit = fitted(np.inf, noise, 1)
    mass = next(e for e in fit.estimates if e.name == "M")
    assert cut_off(fit) == []
    assert mass.verdict == "identified"
    assert mass.low < AXIS.truth["M"] < mass.high
