"""Where a search in presliding begins: at the force balance of the same law."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from foreign import presliding
from stribeck import Recording, identify
from stribeck.friction import law_named
from stribeck.identify.contact_starts import STARTS, contact_sets, scattered
from stribeck.identify.data_split import DataSplit
from stribeck.identify.parameters import Parameters
from stribeck.identify.segment import split_segments
from stribeck.rig.presliding import PRESLIDING
from stribeck.space import Space

TRUTH = {"W_1": 4.0, "d_1": 2e-6, "F_V": 80.0, "M": 8.0, "offset": 0.3}


@pytest.fixture(scope="module")
def log() -> Recording:
    """Growing cycles of 4 s at 1 kHz by explicit steps, positions with noise of 20 nm.

    The second element never yields: only its stiffness is to be seen.
    """
    t = np.asarray(1e-3 * np.arange(4000), dtype=np.float64)
    force = (3.0 + 1.3 * t) * np.sin(2.0 * np.pi * 1.0 * t)
    contact = (np.array([4.0, 5.0]), np.array([2e-6, 8e-6]), 80.0)
    m = presliding.simulate(8.0, contact, t, force, offset=0.3)
    noise = 2e-8 * np.random.default_rng(3).standard_normal(len(t))
    return Recording(t=t, position=m.position + noise, force=force)


def problem_of(log: Recording) -> tuple[Parameters, Any]:
    parameters = Parameters.declared(PRESLIDING, law_named("maxwell-slip:2"))
    segments = split_segments(DataSplit((log,), (), ()), PRESLIDING, parameters.objective)
    return parameters, tuple(segments.train)


def test_the_balance_is_near_the_truth_and_the_first_start(log: Recording) -> None:
    """What yields, how stiff the rest is, within a tenth, and the mass, without a simulation."""
    parameters, train = problem_of(log)
    sets = contact_sets(parameters, train)
    assert sets is not None
    first = Space(parameters.free).decode(sets[:1])[0]
    near = dict(zip((q.name for q in parameters.free), first, strict=True))
    assert near["M"] == pytest.approx(8.0, rel=0.25)
    for name in ("W_1", "d_1"):
        assert near[name] == pytest.approx(TRUTH[name], rel=0.1)
    assert near["W_2"] / (near["d_1"] * near["r_2"]) == pytest.approx(5.0 / 8e-6, rel=0.1)
    starts = scattered(sets, np.random.default_rng(0))
    assert len(starts) == STARTS
    np.testing.assert_array_equal(starts[: len(sets)], sets)


def test_an_identification_takes_few_motions_and_holds_the_truth(log: Recording) -> None:
    """Under 2,500 evaluations: two searches that begin at the balance."""
    fit = identify(log, rig="presliding", law="maxwell-slip:2")
    assert fit.search.evaluations < 2_500
    assert fit.score.value == pytest.approx(0.02, rel=0.03)
    for name in ("W_1", "d_1", "F_V", "M", "offset"):
        e = next(e for e in fit.estimates if e.name == name)
        assert abs(e.value - TRUTH[name]) < 4.0 * e.standard_error


def test_an_axis_that_is_not_only_pushed_is_searched_as_before(log: Recording) -> None:
    parameters, train = problem_of(log)
    term = Parameters.declared(PRESLIDING, law_named("maxwell-slip:2").with_term("cogging"))
    assert contact_sets(term, train) is None
    still = Recording(t=log.t, position=np.full(len(log), 1e-6), force=log.force)
    assert contact_sets(parameters, problem_of(still)[1]) is None
