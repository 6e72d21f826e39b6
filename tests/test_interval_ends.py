"""The other parameters at the ends of intervals: what the data know stays as it is."""

from __future__ import annotations

import numpy as np
import pytest

from stribeck import RIGS, Card, Recording, identify
from stribeck.space import Array

#: Mean speed of a log, m/s.
SPEED = 0.02


def pushed() -> Card:
    """The card of a slide pushed one way, faster and slower than a mean speed, of noisy force."""
    rng = np.random.default_rng(4)
    t: Array = 0.005 * np.arange(4000.0)
    x = SPEED * t - 0.003 * np.cos(2.0 * t) - 0.0008 * np.cos(5.3 * t + 1.0)
    v = SPEED + 0.006 * np.sin(2.0 * t) + 0.00424 * np.sin(5.3 * t + 1.0)
    a = 0.012 * np.cos(2.0 * t) + 0.022472 * np.cos(5.3 * t + 1.0)
    force = 20.0 + 100.0 * v + 50.0 * a + 0.5 * rng.standard_normal(len(t))
    log = Recording(t=t, position=x, force=force)
    fit = identify(log, rig="forced", law="coulomb-viscous", fixed={"offset": 0.0}, delay="off")
    return fit.card()


def test_the_force_at_the_speed_of_the_log_is_known_at_every_end() -> None:
    """F_C + F_V v is what such a log knows; either of them alone it knows less well."""
    F_C, F_V = (pushed().parameters[n] for n in ("F_C", "F_V"))
    known = F_C.value + F_V.value * SPEED
    for end, others in ((F_C.low, F_C.others_at_low), (F_C.high, F_C.others_at_high)):
        assert end is not None
        assert abs(end - F_C.value) > 0.03
        assert end + others["F_V"] * SPEED == pytest.approx(known, abs=0.01)
    for end, others in ((F_V.low, F_V.others_at_low), (F_V.high, F_V.others_at_high)):
        assert end is not None
        assert abs(end - F_V.value) * SPEED > 0.03
        assert others["F_C"] + end * SPEED == pytest.approx(known, abs=0.01)


def test_a_parameter_that_goes_with_none_has_no_others() -> None:
    """An inertia that a torque of many tones shows has nothing to do with the friction."""
    rng = np.random.default_rng(4)
    t: Array = 0.005 * np.arange(4000.0)
    q = np.sin(2.0 * t) + 0.3 * np.sin(5.0 * t)
    v = 2.0 * np.cos(2.0 * t) + 1.5 * np.cos(5.0 * t)
    a = -4.0 * np.sin(2.0 * t) - 7.5 * np.sin(5.0 * t)
    force = 0.5 * np.sign(v) + 0.2 * v + 0.3 * a
    log = Recording(t=t, position=q, force=force + 0.05 * rng.standard_normal(len(t)), rotary=True)
    written = identify(log, rig=RIGS["forced-rotary"], law="coulomb-viscous", delay="off").card()
    inertia = written.parameters["J"]
    assert (inertia.others_at_low, inertia.others_at_high) == ({}, {})
