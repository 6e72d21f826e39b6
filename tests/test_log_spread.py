"""Several logs of a foreign axis whose friction differs from log to log, and of one whose does not.

The spread of the twins is drawn; noise and motion are those of `foreign`, which shares nothing with
the package.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from scipy import stats

from foreign import driven, joint, sensors, servo
from foreign.clock import Array
from foreign.friction import Curve, coulomb_viscous
from foreign.strokes import even, sines, strokes
from stribeck import RIGS, Fit, Recording, identify
from stribeck.friction import LAWS
from stribeck.identify.balance.balance import balance
from stribeck.identify.balance.force_residuals import BalanceResiduals
from stribeck.identify.balance.regression import System
from stribeck.identify.log_spread import LogPart, LogSpreads, log_spreads
from stribeck.identify.parameters import Parameters
from stribeck.identify.random_effects import random_effects
from stribeck.report.contents.gather import Contents
from stribeck.report.page import fit_tables
from stribeck.rig.balanced import as_balanced

#: Of friction from log to log, as a share.
SPREAD = 0.08
DIFFER = "differ beyond their noise"


def factors(seed: int, logs: int = 6, spread: float = SPREAD) -> Array:
    """Drawn, and scaled to be of just that standard deviation."""
    drawn = np.random.default_rng(seed).standard_normal(logs)
    factor: Array = 1.0 + spread * (drawn - drawn.mean()) / drawn.std(ddof=1)
    return factor


# --- random effects -------------------------------------------------------------------------------


def test_intervals_of_mean_and_spread_hold_them() -> None:
    """Six units with errors of their own, 400 times: 95 %, give or take 2.2."""
    rng = np.random.default_rng(1)
    errors, many = np.array([0.2, 0.5, 1.0, 0.3, 0.7, 0.4]), np.full(6, 1e6)
    means = spreads = 0
    for _ in range(400):
        e = random_effects(
            5.0 + rng.standard_normal(6) + errors * rng.standard_normal(6), errors, many
        )
        means += e.low <= 5.0 <= e.high
        spreads += e.sd_low <= 1.0 <= e.sd_high
        assert e.sd_low <= e.sd <= e.sd_high
    assert stats.binomtest(means, 400, 0.95).pvalue > 0.01
    assert stats.binomtest(spreads, 400, 0.95).pvalue > 0.01


@pytest.mark.parametrize("dof", [4, 1000])
def test_units_that_do_not_differ_seldom_seem_to(dof: int) -> None:
    """Errors that are estimated themselves, from few degrees of freedom: 5 %, give or take 2."""
    rng = np.random.default_rng(2)
    chances = []
    for _ in range(500):
        errors = np.sqrt(rng.chisquare(dof, 5) / dof)
        chances.append(random_effects(rng.standard_normal(5), errors, np.full(5, dof)).chance)
    assert 0.02 < np.mean(np.array(chances) < 0.05) < 0.08


# --- force balances -------------------------------------------------------------------------------


@cache
def slide(factor: float) -> Recording:
    """Strokes of 4 cm at three speeds, without noise; friction by a factor."""
    curve = coulomb_viscous(20.0 * factor, 60.0)
    t, x, _ = strokes(np.array([0.05, 0.1, 0.2]), 0.04)
    loop = driven.Loop(kp=4e4, kd=2e3, mass_ff=9.0, tick=1e-4)
    motion = driven.simulate(10.0, curve, curve, loop, t, x, driven.Extras(offset=3.0))
    return Recording(motion.t, motion.position, force=motion.force)


def slides(values: Array, seed: int, memory: float = 0.0) -> list[Recording]:
    """Logs with noise on the force, that may remember for some samples."""
    rng = np.random.default_rng(seed)
    logs = []
    for factor in values:
        clean = slide(float(factor))
        assert clean.force is not None
        table = {"t": clean.t, "position": clean.position, "force": clean.force}
        table = sensors.noisy(table, "position", 1e-6, rng)
        table = sensors.noisy(table, "force", 0.5, rng, memory)
        logs.append(Recording(table["t"], table["position"], force=table["force"]))
    return logs


def by_themselves(logs: list[Recording]) -> LogSpreads:
    """What the logs of a slide give one by one, without the rest of an identification."""
    parameters = Parameters.declared(as_balanced(RIGS["forced"]), LAWS["coulomb-viscous"])
    solved = balance(logs, parameters)
    x = solved.values[parameters.free_places]
    return log_spreads(parameters, [
        LogPart(log, BalanceResiduals(System(parameters, [filtered])), x)
        for log, filtered in zip(logs, solved.system.logs, strict=True)
    ], solved.robust_errors[parameters.free_places])  # fmt: skip


@cache
def varied_slide() -> Fit:
    return identify(slides(factors(3), 3), rig="forced")


def assert_spread(fit: Fit, name: str, values: Array, deviation: float) -> None:
    """A parameter differs from log to log, and no other: intervals hold mean and spread."""
    assert [s.parameter for s in fit.differing.material] == [name]
    (spread,) = fit.differing.material
    e = spread.effects
    assert e.sd_low <= deviation <= e.sd_high
    assert e.low <= values.mean() <= e.high
    assert e.sd == pytest.approx(values.std(ddof=1), rel=0.25)
    assert spread.values == pytest.approx(values, rel=0.03)
    (estimate,) = [e for e in fit.estimates if e.name == name]
    assert estimate.low <= e.low < e.high <= estimate.high
    (warning,) = [w for w in fit.warnings if DIFFER in w]
    assert f"log to log: {name} " in warning


def test_friction_that_differs_from_log_to_log_is_told() -> None:
    assert_spread(varied_slide(), "F_C", 20.0 * factors(3), 20.0 * SPREAD)


def test_card_and_report_have_the_spread_and_each_log() -> None:
    fit = varied_slide()
    written, report = fit.card(), Contents(fit).report()
    assert written.scope == ""
    assert {n: b.differs for n, b in written.between_logs.items()} == {
        "F_C": True, "F_V": False, "M": False, "offset": False
    }  # fmt: skip
    values = [r.values["F_C"] for r in report.single_logs]
    assert [v[0] for v in values if v] == pytest.approx(20.0 * factors(3), abs=0.2)
    for table in (fit_tables.between_logs(report.card), fit_tables.single_logs(report)):
        assert table is not None
        assert len(table.rows) in (4, 6)


def test_a_fit_of_one_log_says_that_its_intervals_are_of_it() -> None:
    fit = identify(slides(np.ones(1), 0), rig="forced")
    assert fit.differing == LogSpreads() or not fit.differing.spreads
    assert "of this log" in fit.card().scope


@pytest.mark.parametrize("memory", [0.0, 20.0])
def test_logs_of_one_axis_do_not_seem_to_differ(memory: float) -> None:
    """A chance of one in a thousand for each of four parameters."""
    alarms = [by_themselves(slides(np.ones(4), seed, memory)).material for seed in range(20)]
    assert not any(alarms)


# --- output error ---------------------------------------------------------------------------------


def pendulums(values: Array, seed: int) -> list[Recording]:
    """A servo's pendulum, friction by a factor; masses and goals differ from log to log."""
    axis, logs = servo.Servo(armature=3e-3, q_offset=0.02), []
    rng, t = np.random.default_rng(seed), even(5.0, 0.01)
    for k, factor in enumerate(values):
        mass, size, slow = ((0.5, 0.8, 1.2), (0.7, 1.2, 2.0), (0.35, 1.0, 1.6))[k % 3]
        goal = size * np.sin(slow * t) + 0.3 * np.sin(5.0 * t)
        on = (t < 3.5).astype(float)
        bam = servo.Bam(0.02 * factor, 0.008)
        table = servo.simulate(axis._replace(m=mass, l=0.15), bam, t, goal, on)._asdict()
        table = sensors.noisy(table, "position", 1e-3, rng)
        extra = {
            "torque_enable": on,
            "mass": np.full_like(t, mass),
            "length": np.full_like(t, 0.15),
        }
        logs.append(Recording(t, table["position"], command=goal, rotary=True, extra=extra))
    return logs


def fitted_pendulums(values: Array, seed: int) -> Fit:
    axis = servo.Servo()
    rig = RIGS["servo-pendulum"].set(kp=axis.kp, vin=axis.vin).exact()
    return identify(pendulums(values, seed), rig=rig, law="coulomb-viscous", repeats=1)


def test_friction_of_a_servo_that_differs_from_log_to_log_is_told() -> None:
    values = factors(4)
    assert_spread(fitted_pendulums(values, 4), "F_C", 0.02 * values, 0.02 * SPREAD)


def test_logs_of_one_servo_do_not_differ() -> None:
    fit = fitted_pendulums(np.ones(4), 5)
    assert not [w for w in fit.warnings if DIFFER in w]
    assert not fit.differing.apart


def test_friction_of_a_joint_that_differs_from_log_to_log_is_told() -> None:
    axis = joint.Joint(J=0.2, g_sin=1.0, kp=70.0, kd=4.4)
    t, command = sines(10.0, np.array([0.6, 0.25]), np.array([0.25, 0.7]), dt=0.01)
    values, rng, logs = factors(6, logs=4, spread=0.15), np.random.default_rng(6), []
    for factor in values:
        curve = Curve(0.6 * factor, 0.6 * factor, 0.3, 0.1)
        motion = joint.simulate(axis, curve, curve, t, command, np.gradient(command, t))
        table = sensors.noisy(motion._asdict(), "position", 3e-4, rng)
        logs.append(Recording(t, table["position"], command=command, rotary=True))
    rig = RIGS["joint"].set(kp=70.0, kd=4.4).exact()
    level = {"g_cos": 0.0, "g_0": 0.0}
    fit = identify(logs, rig=rig, law="coulomb-viscous", fixed=level, repeats=1)
    assert_spread(fit, "F_C", 0.6 * values, 0.6 * 0.15)
