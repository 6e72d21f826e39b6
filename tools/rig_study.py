"""Measure the error of stepped motions: default step and tolerance against ever finer ones.

    python tools/rig_study.py [--orders]

For every rig that steps, and laws of each kind, a typical motion is simulated. Step and tolerance
are then halved until nothing changes any more; the table holds the defaults' difference from that
limit. `--orders` shows instead how the errors of servos' laws fall with the step alone.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from stribeck.data import Recording
from stribeck.friction import law_named
from stribeck.rig import RIGS
from stribeck.rig.simulated import SimulatedRig
from stribeck.units import unit

if TYPE_CHECKING:
    from stribeck.space import Array

#: Halvings at most, and the change, as a share of the defaults' error, that is nothing.
MOST, NOTHING = 9, 0.02
#: When the servo lets go, s.
LET_GO = 4.0


@dataclass(frozen=True)
class Case:
    """A motion to be simulated: the rig, the law, a log that drives it, and parameters, SI."""

    rig: str
    law: str
    log: Recording
    p: dict[str, float]


def creep(t: Array) -> Array:
    """Positions of a log; only the first is used, which is 0."""
    return 1e-4 * t


def swing() -> Recording:
    """A servo lifts a weight by a sine, and lets go after four seconds: 6 s at 185 Hz."""
    t = np.arange(0.0, 6.0, 1 / 185)
    goal = 1.6 * np.sin(2 * np.pi * 0.3 * t) + 0.3 * np.sin(2 * np.pi * 1.1 * t)
    return Recording(t, creep(t), goal, velocity=0 * t, rotary=True,
                     extra={"torque_enable": (t < LET_GO).astype(float)})  # fmt: skip


def staircase() -> Recording:
    """A joint follows a slow command with a soft loop, and sticks and slips: 60 s at 33 Hz."""
    t = np.arange(0.0, 60.0, 0.03)
    goal = 0.8 * np.sin(2 * np.pi * t / 40.0)
    return Recording(t, creep(t), goal, velocity=0 * t, rotary=True)


def sine(size: float, *, rotary: bool) -> Recording:
    """A force below breakaway, two seconds a period: 10 s at 67 Hz."""
    t = np.arange(0.0, 10.0, 0.015)
    force = size * np.sin(np.pi * t)
    return Recording(t, creep(t), force=force, velocity=0 * t, rotary=rotary)


def ramp() -> Recording:
    """The command of the slide bed: 5 mm/s, 30 s at 50 Hz."""
    t = np.arange(0.0, 30.0, 0.02)
    return Recording(t, creep(t), 5e-3 * t)


SERVO = {"k_t": 0.38, "R": 4.5, "armature": 1.7e-3, "q_offset": 0.01}
JOINT = {"J": 0.05, "g_sin": 0.1, "g_cos": 0.1, "g_0": 0.0}
STRIBECK = {"F_S": 0.6, "F_C": 0.3, "F_V": 0.1, "v_SS": 0.02, "exponent": 1.0}
LUGRE = {"sigma_0": 21e3, "sigma_1": 100.0, "F_S": 12.0, "F_C": 11.0, "F_V": 3.0, "v_s": 1e-2}
MAXWELL = {
    "W_1": 2.0, "W_2": 3.0, "W_3": 3.0, "W_4": 3.0, "d_1": 3e-5, "r_2": 3.0, "r_3": 3.0,
    "r_4": 3.0, "F_V": 3.0,
}  # fmt: skip
GMS = MAXWELL | {"ratio": 1.2, "v_s": 1e-2, "tau": 1e-2}
BED = {"k_spring": 968.0}
BAM = {"K_c": 0.01, "K_v": 0.005}
SLOW = {"K_cs": 0.02, "w_s": 1.0, "alpha": 1.0, "K_m": 0.2, "K_e": 0.2, "K_ms": 0.1, "K_es": 0.1}

CASES = [
    Case("servo-pendulum", "bam-m1", swing(), BAM | SERVO),
    Case("servo-pendulum", "bam-m3", swing(), BAM | {"K_l": 0.2} | SERVO),
    Case("servo-pendulum", "bam-m6", swing(), BAM | SLOW | {"K_mq": 0.1, "K_eq": 0.1} | SERVO),
    Case("joint", "coulomb-viscous", staircase(), {"F_C": 0.4, "F_V": 0.2} | JOINT),
    Case("joint", "stribeck", staircase(), STRIBECK | JOINT),
    Case("presliding-rotary", "lugre", sine(6.0, rotary=True), LUGRE | {"M": 0.5, "offset": 0.2}),
    Case("presliding-rotary", "maxwell-slip", sine(6.0, rotary=True),
         MAXWELL | {"M": 0.5, "offset": 0.2}),
    Case("presliding-rotary", "gms", sine(6.0, rotary=True), GMS | {"M": 0.5, "offset": 0.2}),
    Case("presliding", "maxwell-slip", sine(6.0, rotary=False),
         MAXWELL | {"M": 5.0, "offset": 0.2}),
    Case("slide-bed", "lugre", ramp(),
         {"sigma_0": 1e6, "sigma_1": 1e3, "F_S": 145.0, "F_C": 48.0, "F_V": 950.0, "v_s": 1.5e-3}
         | BED),
    Case("slide-bed", "elasto-plastic", ramp(),
         {"sigma_0": 1e6, "sigma_1": 1e3, "F_S": 145.0, "F_C": 48.0, "F_V": 950.0, "v_s": 1.5e-3,
          "elastic": 0.7} | BED),
]  # fmt: skip


def main() -> None:
    """Print the table."""
    print(
        f"{'rig':18s} {'law':16s} {'travel':>12s} {'greatest error':>16s} {'rms':>9s} {'time':>8s}"
    )
    for case in CASES:
        print(row(case))


def orders() -> None:
    """Print by what factor the error falls with steps four times shorter, no step halved.

    m6 counts the square of the weaker of two opposed forces, by K_mq where that is the motor's and
    by K_eq where it is the other: where both are equally strong its friction jumps, unless these
    two are equal.
    """
    print(f"{'law':8s} {'K_mq':>5s} {'K_eq':>5s}  rms error / mrad at 5.4, 1.35, 0.34 ms  factors")
    slow = BAM | SLOW | SERVO
    for law, p in (
        ("bam-m4", BAM | {"K_cs": 0.02, "w_s": 1.0, "alpha": 1.0, "K_l": 0.2, "K_ls": 0.1} | SERVO),
        ("bam-m5", slow),
        *(
            ("bam-m6", slow | {"K_mq": a, "K_eq": b})
            for a, b in ((0.1, 0.1), (0.1, 0.8), (0.8, 0.1))
        ),
    ):
        case = Case("servo-pendulum", law, swing(), p)
        rig = RIGS[case.rig]
        values = np.array([[p[q.name] for q in rig.parameters(law_named(law))]])
        exact = at(rig.set(step=0.02, tolerance=1e-6), case, values, 0)
        loose = rig.set(step=5.45, tolerance=1e9)
        errors = [1e3 * np.std(at(loose, case, values, k) - exact) for k in (0, 2, 4)]
        factors = ", ".join(f"{a / b:.1f}" for a, b in pairwise(errors))
        shown = (f"{p[n]:5.1f}" if n in p else " " * 5 for n in ("K_mq", "K_eq"))
        print(law.ljust(8), *shown, " " + "  ".join(f"{e:.1e}" for e in errors).ljust(39), factors)


def row(case: Case) -> str:
    """A line of the table."""
    rig, law = RIGS[case.rig], law_named(case.law)
    p = np.array([[case.p[q.name] for q in rig.parameters(law)]])
    moved, seconds = at(rig, case, p, 0), clocked(rig, case, p)
    finer = [at(rig, case, p, 1)]
    for k in range(2, MOST + 1):
        finer.append(at(rig, case, p, k))
        if np.abs(finer[-1] - finer[-2]).max() < NOTHING * np.abs(moved - finer[-1]).max():
            break
    written = rig.shows["position"]
    scale = unit(written).factor
    off = (moved - finer[-1]) / scale
    travel = f"{np.ptp(finer[-1]) / scale:.3g} {written}"
    worst = f"{np.abs(off).max():.2g} {written}"
    return (
        f"{rig.name:18s} {law.name:16s} {travel:>12s} {worst:>16s} "
        f"{np.sqrt(np.mean(off**2)):9.2g} {1e3 * seconds:5.1f} ms"
    )


def at(rig: object, case: Case, p: Array, halvings: int) -> Array:
    """The motion with step and tolerance halved `halvings` times, (N,)."""
    assert isinstance(rig, SimulatedRig)  # noqa: S101 - all cases are
    shown = {c.name: c.shown for c in rig.constants}
    refined = rig.set(**{n: shown[n] / 2**halvings for n in ("step", "tolerance")})
    everything = slice(0, len(case.log))
    segment = refined.track(case.log, everything, 0.0, np.ones(len(case.log)))
    moved: Array = refined.move(law_named(case.law), p, segment).position[0]
    return moved


def clocked(rig: object, case: Case, p: Array) -> float:
    """Seconds of a simulation, the least of five."""
    seconds = []
    for _ in range(5):
        start_time = time.perf_counter()
        at(rig, case, p, 0)
        seconds.append(time.perf_counter() - start_time)
    return min(seconds)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--orders", action="store_true")
    (orders if parser.parse_args().orders else main)()
