"""A law that is smooth through rest, or bends, is searched from the law that it approaches."""

from __future__ import annotations

import numpy as np
import pytest

from stribeck.data.recording import Recording
from stribeck.friction import LAWS, Law
from stribeck.identify.fit_warnings import noise_floor
from stribeck.identify.multistart import multistart
from stribeck.identify.parameters import partition
from stribeck.identify.problem import problem
from stribeck.identify.search_settings import SearchSettings
from stribeck.identify.selection.nesting import carried
from stribeck.rig import RIGS
from stribeck.rig.twin import TestBed

LIMITED = [name for name in LAWS if LAWS[name].rigid_limit is not None]
#: Levels, viscous friction and Stribeck velocity of a slide, and the same of its other direction.
FORWARD, BACK = (140.0, 48.0, 900.0, 1e-3), (120.0, 40.0, 700.0, 2e-3)


@pytest.fixture(scope="module")
def log() -> Recording:
    return TestBed(loop="ideal").run("both").recording


def sets_near(law: Law) -> tuple[np.ndarray, Law, np.ndarray]:
    assert law.rigid_limit is not None
    limit = law.rigid_limit.law
    exponent = limit.params[-1].fixed
    p = np.array([*FORWARD, *BACK, exponent] if law.directional else [*FORWARD, exponent])
    return law.rigid_limit.sets(p), limit, p


@pytest.mark.parametrize("name", LIMITED)
def test_sets_near_the_limit_slide_as_it_does(name: str) -> None:
    law = LAWS[name]
    sets, limit, p = sets_near(law)
    assert law.physical(sets).all()
    fast = np.array([0.2, -0.2])  # beyond every drop
    for each in sets:
        assert law.friction(fast, each) == pytest.approx(limit.friction(fast, p), rel=1e-3)


@pytest.mark.parametrize("name", LIMITED)
def test_the_stiffest_set_breaks_away_near_the_level_of_the_limit(name: str) -> None:
    law = LAWS[name]
    sets, limit, p = sets_near(law)
    speeds = np.geomspace(1e-8, 1e-2, 200)
    for sign, level in zip((-1.0, 1.0), limit.levels(p), strict=True):
        peak = np.max(np.abs(law.friction(sign * speeds, sets[-1])))
        assert peak == pytest.approx(abs(level), rel=0.02)


def test_values_outside_a_range_come_to_its_end_and_the_others_stay() -> None:
    rig = RIGS["slide-bed"]
    simple, rich = partition(rig, LAWS["stribeck"]), partition(rig, LAWS["makkar"])
    points = np.array(carried(simple, np.array([140.0, 48.0, 900.0, 1e-5, 1.0, 850.0]), rich))
    names = rich.names
    ranges = {q.name: (q.lower, q.upper) for q in rich.free}
    assert points[:, names.index("g1")] == pytest.approx(92.0)
    assert points[:, names.index("g4")] == pytest.approx(48.0)
    assert points[:, names.index("k_spring")] == pytest.approx(850.0)
    assert points[-1, names.index("g2")] == pytest.approx(ranges["g2"][1])


@pytest.mark.parametrize("seed", [0, 1, 2])
@pytest.mark.parametrize("law", ["makkar", "lugre"])
def test_a_creeping_law_finds_the_slips_of_the_bed(log: Recording, law: str, seed: int) -> None:
    # From anywhere in the box Makkar's ended at 6.84 mm in all three, a slide that creeps along.
    sought = problem(log, rig="slide-bed", law=law, train="112:295")
    optimum = multistart(sought, SearchSettings(seed=seed))
    noise = noise_floor(RIGS["slide-bed"], [log])
    assert float(optimum.problem(optimum.x[None])[0]) < 1.2 * noise
    assert optimum.search.evaluations < 8_000
