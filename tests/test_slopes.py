"""Slopes of rough residuals against those they have, and what they say of constants."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from numpy.random import default_rng

import interval_axes
from foreign import sensors, servo, slide_bed
from foreign.clock import Array
from foreign.friction import Curve
from foreign.strokes import even, ramp
from foreign_axes import noisy, recordings
from stribeck import RIGS, Recording, identify
from stribeck.identify.free_constants import FreeConstantsProblem
from stribeck.optimize import Answer, rms
from stribeck.optimize.moves import Detailed, SpentError
from stribeck.optimize.slopes import MOST_FANS, Slopes, slopes
from stribeck.rig.simulated import as_simulated

Residuals = Callable[[Array], Array]  # (n, dim) of the unit cube to (n, m)


@dataclass(frozen=True)
class Model:
    """Residuals of known slopes, two of which are alike but for a thousandth.

    Args:
        jump: What each jump changes a residual by; `apart` is how far one is from the next.
        noise: Of each residual at each point, anew wherever that is.
        bend: Second derivative in each coordinate and between any two.
        corner: The point, (3,), that a jump passes.
    """

    jump: float = 0.0
    apart: float = 1e-6
    noise: float = 0.0
    bend: float = 0.0
    corner: tuple[float, ...] = ()

    @property
    def slopes(self) -> Array:
        a, b, c = default_rng(0).standard_normal((3, 200))
        return np.array([100 * a, 100 * (a + 1e-3 * b), 50 * c])

    def residuals(self, u: Array) -> Array:
        r = (u - 0.4) @ self.slopes + default_rng(1).standard_normal(200)
        r += self.bend * (u - 0.4).sum(axis=1, keepdims=True) ** 2
        if self.jump:
            at = u @ np.array([1.0, 1.3, -0.7]) / self.apart
            offset = (
                -float(np.array(self.corner) @ [1.0, 1.3, -0.7]) / self.apart
                if self.corner
                else 0.3
            )
            pieces = np.floor(at + offset).astype(int) % 2**31
            r += self.jump * np.array([default_rng(k).standard_normal(200) for k in pieces])
        if self.noise:
            bits = [np.frombuffer(row.tobytes(), dtype=np.uint32) for row in u]
            r += self.noise * np.array([default_rng(b).standard_normal(200) for b in bits])
        return np.asarray(r)


def taken(residuals: Residuals, u: Array, budget: float = np.inf) -> tuple[Array, int]:
    """Slopes at a point, and the evaluations that they took."""
    found, rows = taken_with(residuals, u, None, budget, own=False)
    return found.J, rows


def taken_with(
    residuals: Residuals, u: Array, lengths: Array | None, budget: float = np.inf, *,
    own: bool = True,
) -> tuple[Slopes, int]:  # fmt: skip
    """The same where each coordinate may have its own length, from those that served nearby."""
    moves, rows = slopes(u, residuals(u[None])[0], lengths, own=own), 0
    try:
        batch = next(moves)
        while True:
            assert isinstance(batch, Detailed)
            rows += len(batch.points)
            if rows > budget:
                moves.throw(SpentError())
            shown = residuals(batch.points)
            costs = rms(shown)
            batch = moves.send(Answer(np.where(np.isfinite(costs), costs, np.inf), shown))
    except StopIteration as done:
        return done.value, rows


def worst(J: Array, exact: Array) -> float:
    """Error of slopes, relative to the exact ones, in the direction in which it is largest."""
    values, vectors = np.linalg.eigh(exact @ exact.T)
    return float(np.linalg.norm((vectors / np.sqrt(values)).T @ (J - exact), 2))


def forward(residuals: Residuals, u: Array, h: float) -> Array:
    return (residuals(u + h * np.eye(len(u))) - residuals(u[None])) / h


@pytest.mark.parametrize(
    ("model", "fans"),
    [
        (Model(), 1),
        (Model(bend=1e4), 1),  # a valley narrower than a thousandth of the range
        (Model(jump=1e-4), 1),  # a servo's roughness
        (Model(jump=1e-4, corner=(0.5, 0.4, 0.3)), 2),  # beside a jump, as descents end
        (Model(noise=1e-10, bend=1e3), 4),  # bristles'
    ],
)
def test_slopes_of_what_is_rough_or_bent(model: Model, fans: int) -> None:
    u = np.array([0.5, 0.4, 0.3])
    exact = model.slopes + 2 * model.bend * float(np.sum(u - 0.4))
    J, rows = taken(model.residuals, u)
    assert worst(J, exact) < 0.1
    assert rows <= 4 * fans + 1


def test_longer_differences_show_the_jumps() -> None:
    model, u = Model(jump=1e-3), np.array([0.5, 0.4, 0.3])
    for h in (1e-6, 1e-5, 1e-4, 1e-3):
        assert worst(forward(model.residuals, u, h), model.slopes) > 1.0
    assert worst(taken(model.residuals, u)[0], model.slopes) < 1e-3


def test_dense_jumps_are_averaged() -> None:
    """Where each difference meets thousands of jumps, a length counts that outweighs them."""
    model, u = Model(jump=1e-6, apart=1e-13), np.array([0.5, 0.4, 0.3])
    J, rows = taken(model.residuals, u)
    np.testing.assert_allclose(np.linalg.norm(J - model.slopes, axis=1), 0.0, atol=0.5)
    assert rows <= 4 * MOST_FANS


def test_where_no_length_serves_all_each_coordinate_has_its_own() -> None:
    """Of one that changes a thousand times as much, and is bent where another is still rough."""
    rng = default_rng(5)
    scale = np.array([1e5, 1e2, 1e2])
    exact, bend = scale[:, None] * rng.standard_normal((3, 200)), rng.standard_normal(200)
    noise = default_rng(6).standard_normal(200)

    def residuals(u: Array) -> Array:
        off = [default_rng(np.frombuffer(row.tobytes(), np.uint32)) for row in u]
        rough = 0.01 * np.array([each.standard_normal(200) for each in off])
        curved = 6e10 * (u[:, :1] - 0.5) ** 3
        return np.asarray(noise + (u - [0.5, 0.4, 0.5]) @ exact + curved * bend + rough)

    def errors(J: Array) -> Array:
        return np.asarray(np.linalg.norm(J - exact, axis=1) / np.linalg.norm(exact, axis=1))

    u = np.array([0.5, 0.4, 0.5])
    own, rows = taken_with(residuals, u, None)
    assert own.lengths is not None
    assert rows <= 4 * MOST_FANS
    assert errors(own.J).max() < 0.15
    for length in (1e-6, 1e-5, 1e-4, 1e-3):
        alike = 0.5 * (forward(residuals, u, length) + forward(residuals, u, -length))
        assert errors(alike).max() > 0.3
    again, rows = taken_with(residuals, u + 1e-7, own.lengths)
    assert rows == 2 * 4
    assert errors(again.J).max() < 0.15


def test_slopes_at_an_end_are_of_the_other_side() -> None:
    def edge(u: Array) -> Array:
        return np.where(u[:, :1] > 0.5, np.nan, Model().residuals(u))

    J, rows = taken(edge, np.array([0.5, 1.0, 0.0]))
    np.testing.assert_allclose(J, Model().slopes, atol=1e-3)
    assert rows == 3 + 1 + 1


def test_what_cannot_be_run_has_no_slope_and_a_budget_ends_with_the_best_so_far() -> None:
    def line(u: Array) -> Array:
        return np.where(u[:, :1] != 0.5, np.nan, Model(jump=1e-4, apart=1e-9).residuals(u))

    J, _ = taken(line, np.array([0.5, 0.4, 0.3]), budget=6)
    assert not J[0].any()
    assert J[1:].any(axis=1).all()
    with pytest.raises(SpentError):
        taken(line, np.array([0.5, 0.4, 0.3]), budget=1)


def test_slopes_of_a_servo_are_those_of_a_much_finer_simulation() -> None:
    """Pendulum 6 of the study of coverage, whose k_t, R and duty nearly replace each other."""
    axis = interval_axes.swing(6)
    rig = RIGS[axis.rig].set(**axis.given)
    logs = recordings(axis, noisy(axis, default_rng(6), 0.0))
    fit = identify(logs, rig=rig, law=axis.law)
    for name, e in zip(axis.truth, (e for e in fit.estimates if e.verdict != "fixed"), strict=True):
        assert e.low < axis.truth[name] < e.high, name
    own = fit.residuals
    assert isinstance(own, FreeConstantsProblem)
    space, finer = own.space, own.on(as_simulated(rig).finer(8.0, 1e4))
    (u,) = space.encode(fit.uncertainty.x[None])
    h = 1e-4 * np.eye(len(u))
    up, down = (finer.residuals(space.decode(u + step)) for step in (h, -h))
    exact = (up - down) / 2e-4

    # Long steps that a small tolerance halves here and there make the residuals jump within the
    # 1e-6 of a plain difference; none of these jumps may reach the slopes.
    halved = own.on(as_simulated(rig).finer(0.25, 2500.0))

    def residuals(u: Array, problem: Any = own) -> Array:
        values: Array = problem.residuals(space.decode(u))
        return values

    def rough(u: Array) -> Array:
        return residuals(u, halved)

    assert worst(taken(residuals, u)[0], exact) < 0.1
    assert worst(forward(rough, u, 1e-6), exact) > 1.0
    assert worst(taken(rough, u)[0], exact) < 0.1


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
