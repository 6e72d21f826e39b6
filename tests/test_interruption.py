"""Ctrl-C after a search: whatever it cuts short, the answer stays, and is told to be unfinished."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest

from foreign import slide_bed
from foreign.friction import Curve
from stribeck import Fit, Recording, identify
from stribeck.identify.free_constants import FreeConstantsProblem
from stribeck.identify.uncertainty.assessment import uncertainty
from stribeck.identify.work import Work

#: What follows the search of a fit by output error, in turn, and what a fit has of it.
STAGES = {
    "output_error.answers_alone": "",
    "output_error.with_free_constants": "constants",
    "output_error.uncertainty": "intervals",
    "output_error.exact_enough": "",
    "output_error_fit.combinations": "combinations",
    "output_error_fit.log_spreads": "",
    "output_error_fit.contested_by_motion": "",
    "output_error_fit.drift_violations": "",
    "output_error_fit.motion_delay": "",
    "output_error_fit.exact_slopes": "",
    "output_error_fit.value_slopes": "",
    "output_error_fit.equation_error": "effects",
    "output_error_fit.effects": "effects",
}


@cache
def log() -> Recording:
    """A ramp up on a foreign slide bed."""
    curve = Curve(130.0, 60.0, 958.3, 2e-3)
    times, command = np.array([0.0, 30.0]), np.array([0.05, 0.2])
    motion = slide_bed.simulate(
        slide_bed.Bed(), curve, curve, times, command, 0.044, dt=0.02, h=2e-5
    )
    noise = 3e-4 * np.random.default_rng(1).standard_normal(len(motion.t))
    return Recording(t=motion.t, position=motion.position + noise, command=motion.command)


def fitted() -> Fit:
    return identify(log(), rig="slide-bed", law="stribeck", repeats=1, budget=300)


def parts(fit: Fit) -> set[str]:
    """What a fit has of what follows its search."""
    every = {
        "constants": isinstance(fit.residuals, FreeConstantsProblem),
        "intervals": fit.uncertainty.profiles.complete,
        "combinations": bool(fit.combinations),
        "effects": fit.effects is not None,
    }
    return {name for name, there in every.items() if there}


def test_a_fit_that_nobody_interrupts_has_all_of_it() -> None:
    fit = fitted()
    assert parts(fit) == {"constants", "intervals", "combinations", "effects"}
    assert fit.search.ended != "interrupted"
    assert not any(w.startswith("interrupted") for w in fit.warnings)


@pytest.mark.parametrize("stage", STAGES)
def test_ctrl_c_keeps_the_answer(stage: str, monkeypatch: pytest.MonkeyPatch) -> None:
    begun = []

    def interrupted(*args: Any, **options: Any) -> Any:
        begun.append(stage)
        if len(begun) > 1:  # a rough estimate of how well the answer is known follows
            return uncertainty(*args, **options)
        raise KeyboardInterrupt

    monkeypatch.setattr(f"stribeck.identify.{stage}", interrupted)
    fit = fitted()
    assert begun
    assert fit.search.ended == "interrupted"
    assert fit.warnings[0].startswith("interrupted")
    assert fit.score.value < 1.0
    assert all(np.isfinite((e.low, e.value, e.high)).all() for e in fit.estimates)
    before = {STAGES[s] for s in list(STAGES)[: list(STAGES).index(stage)]}
    assert parts(fit) == before - {"", STAGES[stage]}


def test_ctrl_c_while_a_refined_fit_is_profiled_keeps_the_first(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The intervals are whole: those of the fit before its simulation was refined."""
    begun = []

    def interrupted(*args: Any, **options: Any) -> Any:
        begun.append(options)
        if len(begun) > 1:
            raise KeyboardInterrupt
        return uncertainty(*args, **options)

    monkeypatch.setattr("stribeck.identify.output_error.uncertainty", interrupted)
    monkeypatch.setattr("stribeck.identify.arithmetic.SHARE", 0.0)
    fit = fitted()
    assert len(begun) == 2
    assert fit.search.ended == "interrupted"
    assert not any("finer steps" in w for w in fit.warnings)
    assert parts(fit) == {"constants", "intervals"}


# --- the mechanism --------------------------------------------------------------------------------


def test_rows_of_all_parts_are_counted() -> None:
    work = Work()
    assert work.result(lambda: ("a", 3), "") == "a"
    assert work.result(lambda: ("b", 4), "") == "b"
    assert (work.rows, work.interrupted) == (7, False)


def test_after_ctrl_c_no_part_begins() -> None:
    def interrupted() -> tuple[str, int]:
        raise KeyboardInterrupt

    work = Work(rows=2)
    assert work.result(interrupted, "without") == "without"
    assert work.result(lambda: ("b", 4), "without") == "without"
    assert (work.rows, work.interrupted) == (2, True)
