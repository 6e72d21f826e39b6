"""A load that comes and goes is told with both its inertias, and friction with its range."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Literal

import numpy as np
import pytest

from foreign import driven, sensors
from foreign.friction import coulomb_viscous
from foreign.strokes import sines, strokes
from stribeck import Recording, identify
from stribeck.identify.adequacy.phase_changes import PhaseChanges, phase_changes
from stribeck.identify.adequacy.remainder import Remainder
from stribeck.identify.adequacy.residual_rows import ResidualRows
from stribeck.identify.result import Fit
from stribeck.space import Array

EMPTY, LOAD = 12.0, 3.0


def motion(kind: str, seed: int) -> tuple[Array, Array]:
    """Times and positions that are asked for."""
    rng = np.random.default_rng(100 + seed)
    if kind == "strokes":
        t, x, _ = strokes(rng.choice([0.1, 0.15, 0.2, 0.25], 24), 0.12)
        return t, x
    return sines(30.0, np.array([0.05, 0.03, 0.012]), rng.uniform(0.9, 1.1, 3) * [0.23, 0.61, 1.37])


def moved(t: Array, x: Array) -> sensors.Table:
    """How the axis moves that is asked for positions, without a load."""
    curve = coulomb_viscous(18.0, 70.0)
    loop = driven.Loop(kp=4e4, kd=2e3, mass_ff=11.0)
    return driven.simulate(EMPTY, curve, curve, loop, t, x, driven.Extras(offset=2.0))._asdict()


def balanced(m: sensors.Table, rng: np.random.Generator, memory: float) -> Fit:
    """A balance of its log, whose noise of the force remembers for so many samples."""
    m = sensors.noisy(m, "force", 0.6, rng, memory=memory)
    m = sensors.noisy(m, "position", 1e-6, rng)
    log = Recording(m["t"], m["position"], force=m["force"])
    return identify(log, rig="forced", law="coulomb-viscous")


@cache
def fitted(kind: str, seed: int, load: float, stays: float, memory: float = 0.0) -> Fit:
    """A balance of an axis whose load stays for so many seconds, and is away for as long."""
    rng = np.random.default_rng(seed)
    t, x = motion(kind, seed)
    return balanced(sensors.fetched(moved(t, x), "force", load, stays), rng, memory)


def patterns(fit: Fit) -> list[str]:
    assert fit.effects is not None
    return [e.pattern for e in fit.effects.effects if e.kind == "inertia"]


@pytest.mark.parametrize(("kind", "stays"), [("strokes", 3.0), ("sines", 2.5), ("sines", 4.0)])
@pytest.mark.parametrize("seed", range(2))
def test_a_load_that_comes_and_goes_is_told_with_both_inertias(
    kind: str, stays: float, seed: int
) -> None:
    fit = fitted(kind, seed, LOAD, stays)
    assert "intermittent" in patterns(fit)
    mass = next(e for e in fit.estimates if e.name == "M")
    assert mass.verdict != "identified"
    assert mass.low <= 1.02 * EMPTY
    assert mass.high >= 0.98 * (EMPTY + LOAD)
    told = [w for w in fit.warnings if "comes and goes" in w]
    assert "at its other end" in told[0]


@pytest.mark.parametrize("kind", ["strokes", "sines"])
@pytest.mark.parametrize(("seed", "memory"), [(0, 0.0), (1, 20.0), (2, 60.0)])
def test_one_inertia_does_not(kind: str, seed: int, memory: float) -> None:
    """However long the noise of the force remembers."""
    fit = fitted(kind, seed, 0.0, 3.0, memory)
    assert patterns(fit) == []
    mass = next(e for e in fit.estimates if e.name == "M")
    assert mass.verdict == "identified"
    assert mass.low < EMPTY < mass.high


def test_a_load_that_stays_is_a_change() -> None:
    fit = fitted("sines", 0, LOAD, 16.0)
    assert patterns(fit)[:1] == ["change"]


def rows_of(inertia: Array, noise: float, logs: int, seed: int) -> ResidualRows:
    """Residuals of an axis whose inertia differs from its model's by so much, (rows,)."""
    rng, n = np.random.default_rng(seed), len(inertia)
    t = np.linspace(0.0, 1e-2 * n, n)
    turns = 2 * np.pi * np.outer(t, rng.uniform(0.9, 1.1, 2) * [1.3, 3.1])
    a = np.sum(np.cos(turns + rng.uniform(0.0, 6.0, 2)), axis=1)
    d = np.sign(np.sin(0.7 * t))
    return ResidualRows(
        log=np.arange(n) * logs // n,
        t=t,
        position=np.zeros(n),
        velocity=0.1 * d,
        acceleration=a,
        residual=inertia * a + noise * rng.standard_normal(n),
        jacobian=np.column_stack([a, d]),
        names=("M", "F_C"),
        values=np.array([5.0, 2.0]),
        half_widths=np.array([0.1, 0.1]),
    )


def changes_of(
    rows: ResidualRows, kind: Literal["inertia", "friction"] = "inertia"
) -> PhaseChanges | None:
    return phase_changes(Remainder(rows, np.empty((len(rows), 0))), kind, 1.0)


def test_chance_is_as_often_as_it_is_said() -> None:
    """Of 400 clean logs a share p has a probability below p, but that there are two looks."""
    n = 1500
    p = np.array([
        change.probability
        for seed in range(400)
        if (change := changes_of(rows_of(np.zeros(n), 1.0, 1 + seed % 3, seed))) is not None
    ])  # fmt: skip
    assert len(p) > 390
    for level in (0.2, 0.05, 0.01):
        assert np.mean(p < level) <= level + 3 * np.sqrt(level / len(p))
    assert p.min() > 1e-4


def stroke_rows(seed: int, memory: float, count: int = 24) -> ResidualRows:
    """Residuals of strokes at random speeds, noise alone that remembers for so many rows."""
    rng = np.random.default_rng(seed)
    speeds = rng.choice([0.1, 0.15, 0.2, 0.25], count)
    t, x, v = (channel[::10] for channel in strokes(speeds, 0.12))
    slides = np.abs(v) > 0.01 * np.abs(v).max()
    t, x, v, a = (channel[slides] for channel in (t, x, v, np.gradient(v, t)))
    n = len(t)
    return ResidualRows(
        log=np.zeros(n, dtype=np.intp),
        t=t,
        position=x,
        velocity=v,
        acceleration=a,
        residual=sensors.autoregressive(rng.standard_normal(n), memory),
        jacobian=np.column_stack([a, v, np.sign(v), np.ones(n)]),
        names=("M", "F_V", "F_C", "offset"),
        values=np.ones(4),
        half_widths=np.ones(4),
    )


@pytest.mark.parametrize("memory", [0.0, 12.0, 50.0, 100.0])
def test_noise_makes_no_load_however_long_it_remembers(memory: float) -> None:
    """Memory of the length of a phase, 10 rows, and more makes small chances too frequent."""
    changes = [changes_of(stroke_rows(seed, memory)) for seed in range(300)]
    p = np.array([change.probability for change in changes if change is not None])
    assert len(p) == len(changes)
    assert p.min() > 1e-4


def test_how_much_and_where_in_each_log() -> None:
    n = 3000
    present = np.arange(n) // 250 % 2 == 1
    changes = changes_of(rows_of(2.0 * present, 0.5, 2, 0))
    assert changes is not None
    assert changes.probability < 1e-5
    assert changes.greatest - changes.least == pytest.approx(2.0, rel=0.1)
    assert np.mean((changes.more > 0) == present) > 0.9


@pytest.mark.parametrize("memory", [0.0, 12.0, 50.0, 100.0, 1000.0])
def test_noise_makes_no_friction_however_long_it_remembers(memory: float) -> None:
    """Of two strokes it adds to the friction of one, and takes as much from that of the other."""
    changes = [changes_of(stroke_rows(seed, memory, 40), "friction") for seed in range(300)]
    p = np.array([change.probability for change in changes if change is not None])
    assert len(p) == len(changes)
    for level in (0.2, 0.05, 0.01):
        assert np.mean(p < level) <= level + 3 * np.sqrt(level / len(p))
    assert p.min() > 1e-4


@pytest.mark.parametrize("period", [7.0, 30.0, 200.0])
def test_a_zero_that_drifts_is_no_friction(period: float) -> None:
    rows = stroke_rows(0, 0.0, 40)
    zero = 20.0 * np.sin(2 * np.pi * rows.t / period)
    change = changes_of(replace(rows, residual=rows.residual + zero), "friction")
    assert change is not None
    assert change.probability > 0.5


@pytest.mark.parametrize("misfit", ["speed", "place"])
def test_what_goes_with_the_speed_or_the_place_of_strokes_is_not_told_as_wandering(
    misfit: str,
) -> None:
    """Neighbours are as fast as each other, or at like places, where an experiment goes on so."""
    rows = stroke_rows(0, 0.0, 40)
    stroke = np.cumsum(np.diff(rows.direction, prepend=rows.direction[0]) != 0)
    again = {
        "speed": replace(rows, velocity=rows.direction * (0.1 + 0.005 * stroke)),
        "place": replace(rows, position=rows.position + 0.01 * stroke),
    }[misfit]
    along = 30.0 * np.abs(again.velocity) if misfit == "speed" else 10.0 * again.position
    change = changes_of(replace(again, residual=rows.residual + rows.direction * along), "friction")
    assert change is not None
    assert change.probability > 1e-3


def wandering(kind: str, seed: int, size: float, memory: float = 0.0) -> tuple[Fit, Array]:
    """A balance of an axis with a friction of 18 N that rises and falls, and that friction."""
    rng = np.random.default_rng(seed)
    if kind == "strokes":
        t, x, _ = strokes(rng.choice([0.1, 0.15, 0.2, 0.25], 40), 0.12)
    else:
        t, x = sines(60.0, np.array([0.05, 0.03]), rng.uniform(0.9, 1.1, 2) * [0.35, 0.91])
    steady = moved(t, x)
    m = sensors.wandered(steady, "force", size, 19.0)
    more = (m["force"] - steady["force"]) * np.sign(m["velocity"])
    return balanced(m, rng, memory), 18.0 + more[np.abs(m["velocity"]) > 1e-3]


@pytest.mark.parametrize("kind", ["strokes", "sines"])
@pytest.mark.parametrize("seed", range(2))
def test_friction_that_wanders_is_told_with_its_range(kind: str, seed: int) -> None:
    fit, true = wandering(kind, seed, 4.0)
    least, low, high, greatest = np.quantile(true, [0.0, 0.2, 0.8, 1.0])
    friction = next(e for e in fit.estimates if e.name == "F_C")
    assert friction.verdict != "identified"
    assert least < friction.low < low
    assert high < friction.high < greatest
    assert sum("rises and falls from stroke to stroke" in w for w in fit.warnings) == 1


@pytest.mark.parametrize("kind", ["strokes", "sines"])
@pytest.mark.parametrize(("seed", "memory"), [(0, 0.0), (1, 60.0), (2, 600.0)])
def test_friction_that_does_not_is_identified(kind: str, seed: int, memory: float) -> None:
    fit, _ = wandering(kind, seed, 0.0, memory)
    friction = next(e for e in fit.estimates if e.name == "F_C")
    assert friction.verdict == "identified"
    assert friction.low < 18.0 < friction.high
    assert not any("stroke to stroke" in w for w in fit.warnings)
