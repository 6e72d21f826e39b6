"""Slopes over the step at which both sides agree best, and what they say of constants."""

from __future__ import annotations

import re
from typing import Any
from zlib import crc32

import numpy as np
import pytest
from numpy.random import default_rng

from foreign import sensors, servo, slide_bed
from foreign.clock import Array
from foreign.friction import Curve
from foreign.strokes import even, ramp
from stribeck import RIGS, InputError, Recording, identify
from stribeck.identify.uncertainty.central_slopes import central_slopes
from stribeck.space import Param, Space


class Model:
    """Residuals with known slopes, rough by `rough` and bent beyond steps of `bend`."""

    def __init__(self, rough: float = 0.0, bend: float = np.inf) -> None:
        self.space = Space((Param("a", -10.0, 10.0, ""), Param("b", -10.0, 10.0, "")))
        self.slopes = default_rng(0).standard_normal((2, 50))
        self.rough, self.bend = rough, bend

    def residuals(self, x: Array, /) -> Array:
        """(n, 2) points to (n, 50); nan where the second coordinate is below 2."""
        far = np.abs(x - 2.0)
        r = (
            x @ self.slopes
            + self.slopes[::-1][:1] * (far**2).sum(axis=1, keepdims=True) / self.bend
        )
        noise = [default_rng(crc32(row.tobytes())).standard_normal(50) for row in x]
        return np.asarray(np.where(x[:, 1:] < 2.0, np.nan, r + self.rough * np.array(noise)))


@pytest.mark.parametrize(
    ("rough", "bend", "error"), [(0.0, np.inf, 1e-9), (1e-8, np.inf, 1e-4), (0.0, 1e-5, 0.2)]
)
def test_slopes_of_what_is_rough_or_bent(rough: float, bend: float, error: float) -> None:
    model = Model(rough, bend)
    x = np.array([2.0, 2.0 + 3e-3])
    slopes, r, rows = central_slopes(model, x, np.ones(2))
    assert rows == 17
    np.testing.assert_array_equal(r, model.residuals(x[None])[0])
    if np.isfinite(bend):  # the second point lies on the bend: its own tangent counts
        model.slopes = model.slopes + np.array([[0.0], [6e-3 / bend]]) * model.slopes[::-1][:1]
    np.testing.assert_allclose(slopes, model.slopes, atol=error * np.abs(model.slopes).max())


def test_slopes_at_an_end_are_of_one_side() -> None:
    model = Model()
    slopes, _, _ = central_slopes(model, np.array([2.0, 2.0]), np.ones(2))
    np.testing.assert_allclose(slopes, model.slopes, atol=1e-8)
    with pytest.raises(InputError, match="cannot be run"):
        central_slopes(model, np.array([2.0, 1.0]), np.ones(2))


# --- what is said of constants --------------------------------------------------------------------


def moves(fit: Any, constant: str) -> dict[str, float]:
    """By how much 10 % of a constant move parameters, %, as the fit tells it."""
    (sentence,) = [w for w in fit.warnings if w.startswith("taken as exact")]
    clause = next(c for c in re.split("[:;] ", sentence) if f"10 % of {constant} moves" in c)
    return {n: float(v) for n, v in re.findall(r"(\w+) by (-?[\d.e+]+) %", clause)}


def test_the_gain_of_a_servo_moves_its_motor_alone() -> None:
    """Volts are kp times the error: k_t / R falls as kp rises, and k_t^2 / R stays."""
    axis, t = servo.Servo(armature=3e-3, m=0.5, l=0.1), even(6.0, 0.01)
    goal = 0.8 * np.sin(1.2 * t) + 0.3 * np.sin(5.0 * t)
    table = servo.simulate(axis, servo.Bam(0.02, 0.008), t, goal, (t < 4.0).astype(float))
    noisy = sensors.noisy(table._asdict(), "position", 1e-3, default_rng(0))
    extra = {"mass": np.full_like(t, 0.5), "length": np.full_like(t, 0.1)}
    log = Recording(
        t, noisy["position"], command=goal, rotary=True,
        extra=extra | {"torque_enable": (t < 4.0).astype(float)},
    )  # fmt: skip
    rig = RIGS["servo-pendulum"].set(kp=axis.kp, vin=axis.vin).exact()
    fit = identify(log, rig=rig, law="coulomb-viscous", repeats=1, budget=1500)
    for constant in ("kp", "duty"):
        told = moves(fit, constant)
        assert told == {"k_t": pytest.approx(10.0, abs=1.0), "R": pytest.approx(20.0, abs=1.0)}


def test_the_gain_of_a_slide_bed_moves_its_spring_alone() -> None:
    """On a ramp up motor and spring are one spring, k_hat + k_spring, behind a dead zone."""
    curve = Curve(130.0, 60.0, 958.3, 2e-3)
    times, way = ramp(60.0, 5e-3)
    motion = slide_bed.simulate(slide_bed.Bed(), curve, curve, times, way, -0.006, 0.02, h=2e-5)
    noisy = sensors.noisy(motion._asdict(), "position", 5e-5, default_rng(0))
    log = Recording(noisy["t"], noisy["position"], command=noisy["command"])
    fit = identify(log, rig=RIGS["slide-bed"].exact(), law="stribeck", repeats=1)
    told = moves(fit, "k_hat+")
    share = 3500.0 / fit.values["k_spring"]
    assert told == {"k_spring": pytest.approx(-10.0 * share, rel=0.05)}
