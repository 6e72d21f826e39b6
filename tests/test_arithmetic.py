"""Fits whose simulation is too coarse: noticed, refined, and told; on a foreign joint's log."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from foreign import joint as foreign
from foreign.friction import coulomb_viscous
from stribeck import RIGS, Recording, identify
from stribeck.identify import arithmetic
from stribeck.identify.problem import MotionProblem
from stribeck.identify.result import Fit
from stribeck.identify.uncertainty.profile import IntervalEnd
from stribeck.identify.uncertainty.profile_walk import Ended

F_C, F_V, J, G_SIN = 0.6, 0.3, 0.2, 1.0
NOISE = 1e-4


@cache
def log() -> Recording:
    """A joint at its torque limit, its position with a sensor's noise."""
    t = np.linspace(0.0, 6.0, 301)
    command = 0.8 * np.sin(3.0 * t) + 0.6 * (t > 3.0)
    speed = np.gradient(command, t)
    arm = foreign.Joint(J, G_SIN, kp=40.0, kd=3.0, limit=4.0)
    both = coulomb_viscous(F_C, F_V)
    motion = foreign.simulate(arm, both, both, t, command, speed, h=1e-5)
    noise = NOISE * np.random.default_rng(1).standard_normal(len(t))
    return Recording(
        t=t, position=motion.position + noise, velocity=motion.velocity, command=command,
        rotary=True, extra={"qd_cmd_rad_s": speed},
    )  # fmt: skip


def fitted(tolerance: float) -> Fit:
    """The fit with steps that may be off by so much, mrad."""
    rig = RIGS["joint"].set(kp=40.0, kd=3.0, limit=4.0, tolerance=tolerance)
    return identify(
        log(), rig=rig, law="coulomb-viscous", fixed={"g_cos": 0.0, "g_0": 0.0},
        bounds={"F_C": (0.3, 1.0), "F_V": (0.1, 0.6), "J": (0.1, 0.4), "g_sin": (0.5, 1.5)},
        repeats=1, budget=400,
    )  # fmt: skip


def off(fit: Fit) -> float:
    """By how much a parameter is farthest from exact arithmetic, as a share of its half-width."""
    exact = {e.name: e for e in fitted(1e-5).estimates}
    return max(
        abs(e.value - exact[e.name].value) / (0.5 * (exact[e.name].high - exact[e.name].low))
        for e in fit.estimates
        if e.verdict != "fixed"
    )


def test_the_usual_steps_are_fine_enough() -> None:
    fit = fitted(0.001)
    assert not fit.violations
    assert fit.score.value < 1.05e3 * NOISE  # mrad
    assert off(fit) < 0.1


def test_a_coarse_simulation_is_refined_and_the_fit_repeated() -> None:
    fit = fitted(1.0)
    (told,) = (v for v in fit.violations if v.condition == "arithmetic")
    assert not told.caps
    assert "finer steps of the simulation would have moved" in fit.warnings[0]
    assert fit.parameters.rig["tolerance"] < 1e-4
    assert off(fit) < arithmetic.SHARE + 0.1


def test_what_refining_does_not_end_takes_identified_away(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(arithmetic, "ROUNDS", 0)
    fit = fitted(1.0)
    (told,) = (v for v in fit.violations if v.condition == "arithmetic")
    assert told.caps
    assert told.parameters
    for e in fit.estimates:
        if e.name in told.parameters:
            assert e.verdict != "identified"
    assert "still move" in fit.warnings[0]
    assert off(fit) > 1.0


def test_a_fit_short_of_its_minimum_is_off_by_the_way_there() -> None:
    """A quarter of a half-width beside it, as one that rests on a jump of a coarse simulation."""
    fit = fitted(0.001)
    known = fit.uncertainty.profiles.profiles[0]
    x = fit.uncertainty.x.copy()
    x[0] -= 0.25 * (known.high.end - known.value)
    beside = replace(fit.uncertainty, x=x)
    shifts = arithmetic.shifts(fit.residuals, beside)  # type: ignore[arg-type]
    assert shifts[known.name] == pytest.approx(0.25, abs=0.03)


def test_a_motion_that_finer_steps_cannot_simulate_is_off_by_anything(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    fit = fitted(0.001)
    nothing = np.full_like(fit.uncertainty.profiles.residuals, np.nan)
    monkeypatch.setattr(MotionProblem, "residuals", lambda _, x: np.tile(nothing, (len(x), 1)))
    shifts = arithmetic.shifts(fit.residuals, fit.uncertainty)  # type: ignore[arg-type]
    assert shifts
    assert all(np.isinf(s) for s in shifts.values())


def test_a_finer_simulation_that_leaves_the_answer_where_it_was_repeats_no_intervals(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Slopes of a rough misfit promise a step that no refit keeps."""
    plain = fitted(0.001)
    promised = {e.name: 1.0 for e in plain.estimates if e.verdict != "fixed"}
    monkeypatch.setattr(arithmetic, "shifts", lambda problem, uncertain: promised)  # noqa: ARG005
    fit = fitted(0.001)
    assert not fit.violations
    assert [(e.low, e.high) for e in fit.estimates] == [(e.low, e.high) for e in plain.estimates]
    assert fit.uncertainty is not None
    assert plain.uncertainty is not None
    refit = arithmetic.ROWS * (len(promised) + 1) + 2 * arithmetic.TRIED
    assert fit.uncertainty.rows <= plain.uncertainty.rows + refit


def test_a_parameter_beside_an_end_of_its_range_hardly_moves_by_reaching_it() -> None:
    fit = fitted(0.001)
    assert fit.uncertainty is not None
    problem = fit.residuals
    (k,) = (i for i, q in enumerate(fit.uncertainty.profiles.profiles) if q.name == "F_C")
    own = fit.uncertainty.profiles.profiles[k]
    off = np.zeros(len(fit.uncertainty.x))
    off[k] = 1e-4
    sides: dict[Ended, float] = {"threshold": 1.0, "bound": 1e-4 / 0.1}
    for ended, share in sides.items():
        beside = replace(
            own,
            low=IntervalEnd(own.value - 0.2 + 1e-4, "threshold", 1.0),
            high=IntervalEnd(own.value + 1e-4, ended, 0.5),
        )
        profiles = replace(fit.uncertainty.profiles, profiles=(beside,))
        uncertain = replace(fit.uncertainty, profiles=profiles)
        assert arithmetic.shares(problem.space, uncertain, off)["F_C"] == pytest.approx(share)
