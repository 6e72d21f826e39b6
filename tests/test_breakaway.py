"""Breakaway of force ramps and presliding stiffness, of axes whose values are known."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from stribeck.data import Recording
from stribeck.data.breakaway import levels, presliding, ramps
from stribeck.errors import InputError
from stribeck.friction import LAWS
from stribeck.rig import RIGS
from stribeck.space import Array

T: Array = np.arange(3000, dtype=float) * 0.01


def slides(at: float, rate: float = 0.5, stiffness: float = 2e4) -> Recording:
    """A spring until the ramp reaches `at`, and from there on half a parabola."""
    u = rate * T
    after = np.maximum(T - at / abs(rate), 0.0)
    x = np.minimum(np.abs(u), at) / stiffness + 0.01 * after**2
    return Recording(T, np.sign(rate) * x, force=u, rotary=True)


@pytest.mark.parametrize("at", [4.0, 8.0, 12.0])
@pytest.mark.parametrize("rate", [0.5, -0.5])
def test_the_breakaway_of_a_ramp_is_where_sliding_sets_in(at: float, rate: float) -> None:
    (ramp,) = ramps(slides(at, rate))
    assert ramp.rate == pytest.approx(rate, rel=1e-6)
    assert ramp.reached == pytest.approx(rate * 29.99, rel=1e-6)
    assert ramp.by_speed is not None
    assert ramp.by_stiffness is not None
    # A hundredth of the ramp is what its speed is taken over.
    assert abs(ramp.by_speed) == pytest.approx(at, abs=0.15)
    assert abs(ramp.by_stiffness) == pytest.approx(at, abs=0.15)
    assert np.sign(ramp.by_speed) == np.sign(rate)


def test_the_breakaway_of_bristles_is_their_static_friction() -> None:
    s0, s1, F_S, F_C, v_s = 1e5, 300.0, 20.0, 12.0, 0.01

    def slope(t: float, y: Array) -> list[float]:
        v, z = y[1], y[2]
        level = F_C + (F_S - F_C) * np.exp(-((v / v_s) ** 2))
        dz = v - s0 * abs(v) / level * z
        return [v, t - s0 * z - s1 * dz - 50.0 * v, dz]  # 1 kg, 1 N/s

    motion = solve_ivp(slope, (0.0, T[-1]), [0.0, 0.0, 0.0], "LSODA", T, rtol=1e-8, atol=1e-11)
    (ramp,) = ramps(Recording(T, motion.y[0], force=1.0 * T))
    # Bristles are 1 / (1 - F/F_S) as compliant as at first: a hundred times at 0.99 F_S, and at
    # a speed of twice the mean somewhat earlier. Both are breakaway.
    assert ramp.by_stiffness == pytest.approx(0.99 * F_S, rel=0.01)
    assert 0.8 * F_S < (ramp.by_speed or 0.0) < 0.99 * F_S


def test_no_unit_of_time_force_or_position_matters() -> None:
    ramp = ramps(slides(8.0))[0]
    log = slides(8.0)
    assert log.force is not None
    scaled = ramps(Recording(1e-2 * T, 30 * log.position, force=1e3 * log.force))[0]
    assert scaled.by_speed == pytest.approx(1e3 * (ramp.by_speed or 0), rel=1e-9)
    assert scaled.by_stiffness == pytest.approx(1e3 * (ramp.by_stiffness or 0), rel=1e-9)


def test_a_ramp_that_ends_below_breakaway_says_so() -> None:
    creeps = 1e-5 * T + 1e-7 * T**2  # top speed is 1.3 of the mean
    (ramp,) = ramps(Recording(T, creeps, force=0.5 * T))
    assert (ramp.by_speed, ramp.by_stiffness, ramp.levels) == (None, None, ())
    (level,) = levels([Recording(T, creeps, force=0.5 * T)])
    assert level.values == ()
    assert level.censored == pytest.approx((0.5 * T[-1],))
    assert np.isnan(level.mean)


def test_a_sensor_with_coarse_steps_changes_little() -> None:
    log = slides(8.0)
    coarse = Recording(T, 6e-6 * np.round(log.position / 6e-6), force=log.force, rotary=True)
    assert ramps(coarse)[0].by_speed == pytest.approx(ramps(log)[0].by_speed or 0, rel=0.02)


def test_levels_of_several_ramps_tell_their_spread() -> None:
    logs = [slides(at, rate) for at, rate in ((8.0, 0.5), (9.0, 0.5), (10.0, -0.5))]
    up, down = levels(logs)
    assert (up.direction, down.direction) == (1, -1)
    assert len(up.values) == 2
    assert up.high - up.low == pytest.approx(1.0, abs=0.6)
    assert up.low < up.mean < up.high
    assert down.mean == pytest.approx(abs(ramps(logs[2])[0].by_speed or 0))
    with pytest.raises(InputError, match="no ramp of a measured force"):
        levels([Recording(T, np.sin(T), force=np.sin(T))])


@pytest.mark.parametrize(
    "force",
    [
        np.sin(T),
        np.sign(np.sin(T)) * 3.0,
        np.random.default_rng(0).normal(size=len(T)),
        np.exp(T / 3),
    ],
)
def test_what_is_no_ramp(force: Array) -> None:
    assert ramps(Recording(T, 0.1 * np.sin(T), force=force)) == ()


def test_a_log_without_force_has_none() -> None:
    assert ramps(Recording(T, T)) == ()
    assert presliding(Recording(T, T)) is None


def loop(amplitude: float, travel: float, rotary: bool = True) -> Recording:
    """Force and position of a hysteresis loop that settles after its first cycle."""
    w = 2 * np.pi / 3.0
    first = np.where(T < 3.0, 0.4 * travel * np.sin(np.pi * T / 3.0), 0.0)
    x = 0.5 * travel * np.sin(w * T - 0.3)
    return Recording(T, x + first, force=amplitude * np.sin(w * T), rotary=rotary)


def test_stiffness_is_the_slope_between_the_tips_of_settled_cycles() -> None:
    cycles = presliding(loop(6.0, 3e-4))
    assert cycles is not None
    assert cycles.cycles == 9
    assert cycles.amplitude == pytest.approx(6.0, rel=1e-4)
    assert cycles.stiffness == pytest.approx(12.0 / 3e-4, rel=1e-3)
    assert cycles.half == pytest.approx(6.0 / 3e-4, rel=1e-3)


@pytest.mark.parametrize(
    ("law", "p"),
    [
        ("lugre", [2e7, 1e3, 150.0, 100.0, 1e-3, 0.0]),
        ("dahl", [2e7, 100.0, 1.0, 0.0]),
        ("elasto-plastic", [2e7, 1e3, 150.0, 100.0, 1e-3, 0.0, 0.5]),
    ],
)
def test_cycles_tell_the_stiffness_that_a_law_has(law: str, p: list[float]) -> None:
    t = np.arange(0.0, 20.0, 0.02)
    stiffnesses = []
    for amplitude in (10.0, 60.0):
        force = amplitude * np.sin(2 * np.pi * t / 4)
        log = Recording(t, 1e-12 * np.sin(t), force=force)
        x = RIGS["presliding"].simulate(LAWS[law], np.array([[*p, 1.0, 0.0]]), log).position[0]
        cycles = presliding(Recording(t, x, force=force))
        assert cycles is not None
        stiffnesses.append(cycles.stiffness)
    assert stiffnesses[0] == pytest.approx(2e7, rel=0.01)
    assert 1e7 < stiffnesses[1] <= 2e7 * (1 + 1e-3)


def test_a_swing_and_a_driven_mass_are_no_presliding() -> None:
    assert presliding(loop(6.0, 0.5)) is None  # half a radian
    w = 2 * np.pi / 3.0
    mass = Recording(T, 1e-4 * np.sin(w * T), force=-3.0 * np.sin(w * T), rotary=True)
    assert presliding(mass) is None  # against the position: inertia
    uneven = Recording(T, 1e-4 * np.sin(w * T), force=np.sin(w * T) * (1 + T / 20), rotary=True)
    assert presliding(uneven) is None
