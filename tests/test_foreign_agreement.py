"""Our simulations beside the foreign ones, which share no line with them.

The foreign answer is that for a step of zero, 2 x(h/2) - x(h), as its error is of first order. Ours
has its default steps: a fifth of a good sensor's noise is the most by which it may differ. Balances
do not simulate: they have to find what made a clean log.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from foreign import cascade, cylinder, driven, joint, presliding, servo, slide_bed
from foreign.clock import Array
from foreign.friction import Curve, coulomb_viscous
from foreign.strokes import even, sines, strokes
from stribeck import RIGS, Recording, identify
from stribeck.friction import law_named
from stribeck.rig.balanced import as_balanced
from stribeck.rig.simulated import as_simulated


def limit(position: Callable[[float], Array], h: float) -> Array:
    """A foreign motion for steps that shrink to nothing."""
    answer: Array = 2.0 * position(h / 2.0) - position(h)
    return answer


def ours(rig: str, law: str, p: list[float], log: Recording, **constants: float) -> Array:
    """Our motion from rest at the first position of a log."""
    axis = as_simulated(RIGS[rig].set(**constants))
    track = axis.track(log, slice(0, len(log)), float(log.position[0]), np.ones(len(log)))
    motion = axis.move(law_named(law), np.array([p]), track._replace(v0=0.0))
    answer: Array = motion.position[0]
    return answer


def error(ours: Array, theirs: Array) -> float:
    return float(np.abs(ours - theirs).max())


# --- slide bed ------------------------------------------------------------------------------------


@pytest.mark.parametrize("exponent", [0.6, 1.0, 2.0])
def test_slide_bed(exponent: float) -> None:
    """A ramp up, a stop and a ramp down, all parameters of their own for each direction."""
    right, left = (144.5463, 47.8514, 958.3, 1.0964e-3), (152.2804, 40.4153, 975.7, 3.21475e-3)
    times, command = np.array([0.0, 20.0, 21.0, 45.0]), np.array([0.0, 0.1, 0.1, -0.05])

    def motion(h: float) -> slide_bed.BedMotion:
        plus, minus = (Curve(*p, exponent) for p in (right, left))
        return slide_bed.simulate(slide_bed.Bed(), plus, minus, times, command, 0.0, h=h)

    theirs, m = limit(lambda h: motion(h).position, 1e-5), motion(1e-5)
    log = Recording(t=m.t, position=m.position, command=m.command)
    p = [*right, *left, exponent, 967.98, 553.84]
    assert np.abs(m.velocity).max() > 0.05
    assert np.ptp(theirs) > 0.07
    assert error(ours("slide-bed", "stribeck-directional", p, log), theirs) < 1e-6


# --- joint ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("logged", [False, True])
@pytest.mark.parametrize("hold", [0, 1, 2])
def test_joint(hold: int, logged: bool) -> None:
    """Slow enough to stick and slip, irregular samples.

    Without columns for them the command's velocity is its central difference and nothing is fed
    forward; with them, torque and velocity are straight lines between samples, too.
    """
    rng = np.random.default_rng(3)
    t = np.concatenate([[0.0], np.cumsum(np.round(rng.uniform(0.01, 0.02, 600), 4))])
    phase = 0.3 * 2.0 * np.pi * t
    command, speed = 0.8 * np.sin(phase), np.gradient(0.8 * np.sin(phase), t)
    ahead, extra = np.zeros_like(t), {}
    if logged:
        speed, ahead = (
            0.8 * 0.6 * np.pi * np.cos(phase),
            2.0 * np.cos(command) + 0.5 * np.sin(7 * t),
        )
        extra = {"qd_cmd_rad_s": speed, "tau_ff_Nm": ahead}
    both = Curve(1.0, 0.6, 0.3, 0.1)
    arm = joint.Joint(0.2, 1.0, 2.0, 0.3, kp=70.0, kd=4.4, gain=0.5, limit=2.9, hold=hold)

    def position(h: float) -> Array:
        return joint.simulate(arm, both, both, t, command, speed, ahead, h=h).position

    log = Recording(t=t, position=command, command=command, extra=extra, rotary=True)
    answer = ours(
        "joint", "stribeck", [*both, 0.2, 1.0, 2.0, 0.3], log,
        kp=70.0, kd=4.4, gain=0.5, limit=2.9, hold=hold,
    )  # fmt: skip
    assert error(answer, limit(position, 1e-5)) < 2e-5


# --- servo ----------------------------------------------------------------------------------------

#: Parameters by law, and the same as a foreign one.
BAM: dict[str, tuple[list[float], servo.Bam]] = {
    "bam-m1": ([0.03, 0.008], servo.Bam(0.03, 0.008)),
    "bam-m4": (
        [0.01, 0.008, 0.02, 0.8, 1.3, 0.15, 0.1],
        servo.Bam(0.01, 0.008, 0.02, 0.8, 1.3, 0.15, 0.15, 0.1, 0.1),
    ),
    "bam-m6": (
        [0.01, 0.008, 0.02, 0.8, 1.3, 0.1, 0.2, 0.05, 0.1, 0.3, 0.2],
        servo.Bam(0.01, 0.008, 0.02, 0.8, 1.3, 0.1, 0.2, 0.05, 0.1, 0.3, 0.2),
    ),
}


@pytest.mark.parametrize("law", BAM)
def test_servo(law: str) -> None:
    """A goal that is a straight line between samples; the last third swings free."""
    p, bam = BAM[law]
    t, goal = sines(4.0, np.array([1.2, 0.3]), np.array([0.4, 1.7]), dt=0.01)
    enabled = (t < 2.7).astype(float)
    axis = servo.Servo(kp=300.0, q_offset=0.03)

    def position(h: float) -> Array:
        return servo.simulate(axis, bam, t, goal, enabled, start=(0.2, 0.0), h=h).position

    log = Recording(
        t=t, position=np.full_like(t, 0.2), command=goal, rotary=True,
        extra={"torque_enable": enabled, "kp": np.full_like(t, 300.0)},
    )  # fmt: skip
    whole = [*p, axis.k_t, axis.R, axis.armature, axis.q_offset]
    assert error(ours("servo-pendulum", law, whole, log), limit(position, 1e-5)) < 6e-5


# --- presliding -----------------------------------------------------------------------------------

LUGRE = presliding.LuGre(1.2e6, 600.0, 18.0, 12.0, 2e-2, 50.0)
LEVELS, RATIOS = [3.0, 4.0, 5.0, 6.0], [4.0, 3.0, 1.7]
BRISTLES: dict[str, tuple[list[float], Any]] = {
    "lugre": ([*LUGRE], LUGRE),
    "dahl": ([1.2e6, 14.0, 1.0, 50.0], presliding.dahl(1.2e6, 14.0, 50.0)),
    "maxwell-slip": (
        [*LEVELS, 1e-6, *RATIOS, 50.0],
        (np.array(LEVELS), 1e-6 * np.cumprod([1.0, *RATIOS]), 50.0),
    ),
}


@pytest.mark.parametrize("law", BRISTLES)
def test_presliding(law: str) -> None:
    """Growing cycles of force below breakaway, from a bristle that the first force has bent."""
    p, bristle = BRISTLES[law]
    t = even(2.0, 2e-3)
    force = 2.0 + (2.0 + 4.0 * t) * np.sin(2.0 * np.pi * 1.5 * t)

    def position(h: float) -> Array:
        return presliding.simulate(5.0, bristle, t, force, offset=0.5, dt=2e-3, h=h).position

    log = Recording(t=t, position=np.zeros_like(t), force=force)
    answer = ours("presliding", law, [*p, 5.0, 0.5], log)
    theirs = limit(position, 1e-5)
    assert np.ptp(theirs) > 6e-6
    assert error(answer, theirs) < 3e-8


# --- EMPS -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("delay", [0.0, 0.3e-3, 1e-3])
def test_cascade(delay: float) -> None:
    axis = cascade.Cascade(delay=delay)
    t, command = sines(3.0, np.array([0.1, 0.02]), np.array([0.4, 1.1]))
    curve = (30.0, 20.39, 203.5, 5e-3)
    both = Curve(*curve)

    def position(h: float) -> Array:
        return cascade.simulate(axis, both, both, command, h=h).position

    log = Recording(t=t, position=np.zeros_like(t), command=command)
    motion = RIGS["emps"].set(delay=1e3 * delay).simulate(
        law_named("stribeck"), np.array([[*curve, 1.0, axis.M, axis.offset]]), log
    )  # fmt: skip
    assert error(motion.position[0], limit(position, 1e-5)) < 5e-6


# --- force balances -------------------------------------------------------------------------------


def values(fit: Any, names: tuple[str, ...]) -> list[float]:
    return [float(fit.values[name]) for name in names]


def test_forced() -> None:
    """A loop as fast as its steps: its force is no half tick early.

    It hardly rests: a balance counts rows at rest, where friction is not that of sliding.
    """
    plus, minus = coulomb_viscous(20.0, 60.0), coulomb_viscous(25.0, 90.0)
    t, command = sines(10.0, np.array([0.1, 0.03]), np.array([0.3, 0.7]))
    loop = driven.Loop(kp=4e4, kd=2e3, mass_ff=9.0, tick=1e-5)
    m = driven.simulate(10.0, plus, minus, loop, t, command)
    fit = identify(
        Recording(t=m.t, position=m.position, force=m.force),
        rig="forced", law="coulomb-viscous-directional",
    )  # fmt: skip
    answers = values(fit, ("F_C+", "F_V+", "F_C-", "F_V-", "M"))
    assert answers == pytest.approx([20.0, 60.0, 25.0, 90.0, 10.0], rel=0.01)


def test_forced_pendulum() -> None:
    curve = coulomb_viscous(0.5, 0.2)
    t, command, _ = strokes(np.array([0.5, 1.0, 2.0]), 1.6)
    loop = driven.Loop(kp=400.0, kd=20.0, tick=1e-5)
    extras = driven.Extras(offset=0.1, g_sin=2.0, g_cos=0.5)
    m = driven.simulate(0.3, curve, curve, loop, t, command - 0.8, extras)
    fit = identify(
        Recording(t=m.t, position=m.position, force=m.force, rotary=True),
        rig="forced-pendulum", law="coulomb-viscous",
    )  # fmt: skip
    answers = values(fit, ("F_C", "F_V", "M", "offset", "g_sin", "g_cos"))
    assert answers == pytest.approx([0.5, 0.2, 0.3, 0.1, 2.0, 0.5], rel=0.01)


def cylinder_logs(axis: cylinder.Cylinder) -> list[Recording]:
    """Strokes at three speeds under three pressures."""
    t, _, speed = strokes(np.array([0.05, 0.1, 0.2]), 0.05)
    motions = [cylinder.simulate(axis, t, speed, np.full_like(t, p)) for p in (1e5, 3e5, 6e5)]
    return [
        Recording(t=m.t, position=m.position, force=m.force, pressure=m.pressure) for m in motions
    ]


def test_cylinder() -> None:
    """A rod heavy enough to be weighed by strokes such as these."""
    axis = cylinder.Cylinder(M=20.0, F_C=10.0, F_V=300.0, mu_p=5e-5, b=2e-5, offset=3.0)
    fit = identify(cylinder_logs(axis), rig="cylinder")
    answers = values(fit, ("F_C", "F_V", "mu", "M", "offset", "b"))
    assert answers == pytest.approx([10.0, 300.0, 5e-5, 20.0, 3.0, 2e-5], rel=0.01)


def test_rows_about_reversals_make_a_light_rod_too_heavy() -> None:
    """Where the sign of the velocity is not known, a balance takes friction for inertia."""
    logs = cylinder_logs(
        cylinder.Cylinder(M=2.0, F_C=10.0, F_V=300.0, mu_p=5e-5, b=2e-5, offset=3.0)
    )
    rig = as_balanced(RIGS["cylinder"])
    kept = replace(rig, filtering=replace(rig.filtering, reversals=True))
    (without,) = values(identify(logs, rig=rig), ("M",))
    (with_them,) = values(identify(logs, rig=kept), ("M",))
    assert without == pytest.approx(2.0, rel=3e-3)
    assert 1.06 < with_them / 2.0 < 1.12
