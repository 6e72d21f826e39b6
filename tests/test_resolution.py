"""What a sensor resolves: steps of all its values, and not the way that a motion takes a sample."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from foreign import driven, sensors
from foreign.clock import Array
from foreign.friction import coulomb_viscous
from foreign.sensors import Table
from foreign.strokes import levels
from stribeck import Recording, identify
from stribeck.data.resolution import noise_of, step

FINE = 1e-6


@cache
def motion(speeds: tuple[float, ...]) -> driven.DrivenMotion:
    """20 kg with 30 N and 100 N s/m of friction, each speed for a second."""
    t, command = levels([*((v, 1.0, 0.2) for v in speeds), (0.0, 0.3, 0.2)])
    curve, loop = coulomb_viscous(30.0, 100.0), driven.Loop(kp=4e4, kd=2e3, mass_ff=20.0, tick=1e-5)
    return driven.simulate(20.0, curve, curve, loop, t, command)


def table(speeds: tuple[float, ...], size: float) -> Table:
    run = sensors.noisy(motion(speeds)._asdict(), "force", 0.2, np.random.default_rng(1))
    return sensors.quantised(run, "position", size)


def position(speeds: tuple[float, ...], size: float) -> Array:
    return table(speeds, size)["position"]


@pytest.mark.parametrize(
    "speeds", [(0.05, 0.1, 0.2), (0.055, 0.11, 0.22), (0.05, -0.05), (0.2, 0.1, 0.05, -0.35)]
)
def test_the_way_per_sample_at_a_constant_speed_is_no_step(speeds: tuple[float, ...]) -> None:
    assert step(position(speeds, FINE)) in (0.0, pytest.approx(FINE, rel=1e-3))
    assert step(motion(speeds).command) == 0.0


@pytest.mark.parametrize("size", [5e-5, 2e-4, 1e-3])
@pytest.mark.parametrize("speeds", [(0.05, 0.1, 0.2), (0.05, -0.1, 0.2, -0.3)])
def test_steps_of_a_coarse_sensor_are_seen(speeds: tuple[float, ...], size: float) -> None:
    x = position(speeds, size)
    assert step(x) == pytest.approx(size, rel=1e-6)
    kept = np.random.default_rng(0).random(len(x)) < 0.6
    kept[len(x) // 3 : len(x) // 2] = False  # rows that were lost
    assert step(x[kept]) == pytest.approx(size, rel=1e-6)
    printed: Array = np.round(x, 5 if size > 1e-4 else 6)
    assert step(printed) == pytest.approx(size, rel=1e-6)


@pytest.mark.parametrize("speed", [0.05, 0.1])
def test_one_long_stroke_at_a_constant_speed_hides_no_step(speed: float) -> None:
    """Nearly all samples are five or ten steps apart; those of its start and its stop are not."""
    t, command = levels([(speed, 4.0, 0.1), (0.0, 0.2, 0.1)])
    curve, loop = coulomb_viscous(30.0, 100.0), driven.Loop(kp=4e4, kd=2e3, mass_ff=20.0, tick=1e-4)
    run = driven.simulate(20.0, curve, curve, loop, t, command)._asdict()
    assert step(sensors.quantised(run, "position", 1e-5)["position"]) == pytest.approx(1e-5)


def test_steps_that_were_printed_in_few_digits_are_seen() -> None:
    """Counts of 45.8 um in hundredths of a millimetre: neighbours are 4 or 5 apart."""
    size = 3.0 / 2**16
    x: Array = np.round(position((0.05, -0.1, 0.2), size), 5)
    assert step(x) == pytest.approx(size, rel=1e-3)


def test_no_error_of_the_position_is_taken_off_where_there_is_none() -> None:
    channels = table((0.05, 0.1, 0.2), FINE)
    log = Recording(channels["t"], channels["position"], force=channels["force"])
    fit = identify(log, rig="forced", law="coulomb-viscous")
    assert fit.values["M"] == pytest.approx(20.0, rel=5e-3)
    mass = next(e for e in fit.estimates if e.name == "M")
    assert (mass.verdict, mass.low < 20.0 < mass.high) == ("identified", True)
    assert not any("taken off" in w or "depend on the cut-off" in w for w in fit.warnings)
    assert noise_of(log.position) < 1e-6
