"""A user's rig: a class with `move` alone is simulated and identified as any other."""

import os
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

from stribeck import LAWS, InputError, Law, Param, Recording, identify, problem
from stribeck.constant import constant
from stribeck.report.contents.gather import Contents
from stribeck.report.figures.fit_figures import draw_fit
from stribeck.rig.motion.event_driven import misfits
from stribeck.rig.motion.track import Track
from stribeck.rig.rig import Motion
from stribeck.rig.simulated import SimulatedRig
from stribeck.rig.slide_bed import PUBLISHED, SLIDE_BED
from stribeck.rig.twin import TestBed
from stribeck.space import Array


@dataclass(frozen=True, eq=False)
class Dragged(SimulatedRig):
    """A massless sledge on a spring: it moves as soon as the spring force exceeds friction."""

    def move(self, law: Law, p: Array, track: Track) -> Motion:
        command = np.interp(track.t, track.knots_t, track.knots_x)
        x = np.full((len(p), len(track.t)), track.x0)
        for row, parameters in enumerate(p):
            low, high = (level / parameters[-1] for level in law.levels(parameters[:-1]))
            for k in range(1, len(track.t)):
                x[row, k] = min(max(x[row, k - 1], command[k] - high), command[k] - low)
        return Motion(track.t, x, np.gradient(x, track.t, axis=1), p[:, -1:] * (command - x))


SLEDGE = Dragged(
    name="sledge",
    doc="a weightless sledge on a spring",
    cite="this test",
    constants=(constant("m", 0.0, "kg", "mass", "weightless"),),
    params=(Param("k", 100.0, 1000.0, "N/m", doc="spring"),),
    laws=("coulomb-viscous",),
    ranges={"F_C": (1.0, 10.0)},
    shows={"position": "mm", "velocity": "mm/s"},
)


@pytest.fixture
def log() -> Recording:
    t = np.arange(0.0, 20.0, 0.05)
    command = 0.05 * np.sin(2 * np.pi * t / 10.0)
    track = Track(t, command, t, 0.0, t, t, t[None])
    x = SLEDGE.move(LAWS["coulomb-viscous"], np.array([[4.0, 0.0, 400.0]]), track).position[0]
    return Recording(
        t, x + 1e-5 * np.random.default_rng(0).standard_normal(len(t)), command=command
    )


def test_it_is_identified_and_drawn(log: Recording, tmp_path: Path) -> None:
    fit = identify(
        log, rig=SLEDGE, fixed={"F_V": 0.0, "k": 400.0}, method="random", budget=60, repeats=1
    )
    assert fit.values["F_C"] == pytest.approx(4.0, rel=0.01)
    assert fit.score.value < 0.05 * fit.score.smooth
    drawn = {file.stem for file in draw_fit(Contents(fit), tmp_path)}
    assert drawn == {"convergence", "training", "stribeck_curve"}  # it cannot say its friction


def test_its_misfit_follows_from_its_motion(log: Recording) -> None:
    objective = problem(log, rig=SLEDGE)
    x = objective.space.decode(objective.space.sample(np.random.default_rng(1), 5))
    np.testing.assert_allclose(
        objective(x), np.sqrt(np.mean(objective.residuals(x) ** 2, axis=1)), rtol=1e-12
    )


def test_it_is_as_fine_as_its_constants_say() -> None:
    assert SLEDGE.finer(8.0, 100.0).constants == SLEDGE.constants
    stepped = replace(
        SLEDGE,
        constants=(
            *SLEDGE.constants,
            constant("tolerance", 2.0, "um", "way by which a step may be off", "this test"),
            constant("step", 4.0, "ms", "longest step", "this test"),
        ),
    )
    assert stepped.fineness == "step = 4 ms, tolerance = 2 um"
    finer = stepped.finer(8.0, 100.0)
    assert finer["step"] == pytest.approx(0.5e-3)
    assert finer["tolerance"] == pytest.approx(2e-8)
    assert finer["m"] == SLEDGE["m"]


def test_one_that_does_not_say_how_it_moves_is_refused(log: Recording) -> None:
    motionless = SimulatedRig(name="still", doc="", cite="", laws=("coulomb-viscous",))
    with pytest.raises(InputError, match="does not say how it moves"):
        identify(log, rig=motionless, budget=10, repeats=1)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system cannot fork")
@pytest.mark.filterwarnings("ignore:This process.*is multi-threaded:DeprecationWarning")
def test_a_forked_child_simulates_too() -> None:
    """A forked child has none of its parent's threads, and must not wait for them."""
    track = (
        problem(TestBed().run("up", seed=1).recording, rig="slide-bed", train="112:295")
        .train[0]
        .track
    )
    p, c = SLIDE_BED.split(LAWS["stribeck"], np.tile(PUBLISHED["right"], (64, 1)))
    expected = misfits(LAWS["stribeck"], p, c, track)
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        squares = misfits(LAWS["stribeck"], p, c, track)
        os.write(writer, b"same" if np.array_equal(squares, expected) else b"other")
        os._exit(0)
    os.close(writer)
    reply = os.read(reader, 10)
    os.waitpid(child, 0)
    assert reply == b"same"
