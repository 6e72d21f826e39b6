"""Axes of drawn parameters, for `intervals`: each a function of its number alone."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.random import SeedSequence

import foreign_path  # noqa: F401 - before what it finds
from foreign import combined, cylinder, driven, joint, presliding, servo, slide_bed
from foreign.friction import Curve, coulomb_viscous
from foreign.strokes import sines
from foreign_axes import Axis, arm, bed, both, bristles, coupled, forced, pendulum, rod
from stribeck import RIGS
from stribeck.space import Rng

SEED = 2012
Ranges = Mapping[str, tuple[float, float]]

#: A bed's friction, and the stiffness of its drive line: the search ranges.
SLIDE: Ranges = {
    "F_S": (100.0, 180.0), "F_C": (40.0, 80.0), "F_V": (400.0, 1000.0), "v_SS": (1e-3, 7e-3),
    "k_spring": (100.0, 1500.0),
}  # fmt: skip
#: Seconds from sample to sample, and noise; a motion with at least so many slips is stick-slip.
BED_STEPS, BED_NOISE, SLIPS = (0.05, 0.02, 0.01, 0.005), (0.05e-3, 0.5e-3), 4
#: Largest draw of a constant, in standard deviations: its tolerance.
WITHIN = 2.0


def _rng(study: int, k: int) -> Rng:
    return np.random.default_rng(SeedSequence((SEED + study, k)))


def _drawn(rng: Rng, ranges: Ranges) -> dict[str, float]:
    return {name: float(rng.uniform(*ends)) for name, ends in ranges.items()}


def slide(k: int) -> Axis:
    """Slide bed number k, in turn rightward and leftward, its constants within their tolerances."""
    rng, right = _rng(0, k), k % 2 == 0
    dt, noise = float(rng.choice(BED_STEPS)), float(rng.uniform(*BED_NOISE))
    while True:
        p = _drawn(rng, SLIDE)
        spring = p["k_spring"]
        constants = drawn_constants(rng)._replace(k_spring_up=spring, k_spring_down=spring)
        curve = Curve(p["F_S"], p["F_C"], p["F_V"], p["v_SS"])
        axis = bed(constants, curve, right=right, dt=dt, noise=noise)
        if _slips(axis) >= SLIPS:
            return axis


def drawn_constants(rng: Rng) -> slide_bed.Bed:
    """Of a bed that is like the paper's: each constant normal, within its tolerance."""
    known = {c.name: c for c in RIGS["slide-bed"].constants}
    drawn = {}
    for name, c in known.items():
        far = rng.standard_normal()
        while abs(far) > WITHIN:
            far = rng.standard_normal()
        drawn[name] = c.value + far * c.standard_deviation
    return slide_bed.Bed(
        m=drawn["m"], k_hat_up=drawn["k_hat+"], k_hat_down=drawn["k_hat-"], F_fm=drawn["F_fm"],
        K_J=known["K_kt"].value * drawn["J_m"], K_D=known["K_kt"].value * drawn["D_m"],
        F_m_max=drawn["F_m_max"], dv=known["dv"].value, dp=drawn["m"] * known["dv"].value,
    )  # fmt: skip


def _slips(axis: Axis) -> int:
    (table,) = axis.tables
    moves = table["velocity"] != 0.0
    return int(np.sum(~moves[:-1] & moves[1:]))


def balance(k: int) -> Axis:
    """Forced slide number k: a sum of sines for a command, noise on the measured force."""
    rng = _rng(1, k)
    p = _drawn(rng, {"M": (3.0, 30.0), "F_C": (5.0, 40.0), "F_V": (20.0, 200.0)})
    sizes = np.array([0.08, 0.03, 0.004]) * rng.uniform(0.6, 1.4, 3)
    command = sines(24.0, sizes, np.array([0.31, 0.83, 2.3]) * rng.uniform(0.8, 1.2, 3))
    offset = driven.Extras(offset=float(rng.uniform(-5.0, 5.0)))
    noise = float(np.exp(rng.uniform(*np.log([0.5, 5.0]))))
    curve = coulomb_viscous(p["F_C"], p["F_V"])
    return forced(p["M"], curve, extras=offset, command=command, noise=noise)


def cylinders(k: int) -> Axis:
    """Cylinder number k at three pressures."""
    rng = _rng(2, k)
    p = _drawn(rng, {
        "M": (10.0, 40.0), "F_C": (5.0, 30.0), "F_V": (100.0, 500.0), "mu_p": (2e-5, 1e-4),
        "b": (-3e-5, 3e-5), "offset": (-5.0, 5.0),
    })  # fmt: skip
    pressures = np.sort(rng.uniform([5e4, 2e5, 4e5], [1.5e5, 3.5e5, 8e5])).tolist()
    return rod(cylinder.Cylinder(**p), pressures, noise=float(rng.uniform(0.2, 2.0)))


def swing(k: int) -> Axis:
    """Servo pendulum number k, the duty of its servo within its tolerance."""
    rng = _rng(3, k)
    p = _drawn(rng, {
        "k_t": (0.2, 0.8), "R": (2.0, 8.0), "armature": (1e-3, 8e-3), "q_offset": (-0.05, 0.05)
    })  # fmt: skip
    (duty,) = (c for c in RIGS["servo-pendulum"].constants if c.name == "duty")
    far = float(np.clip(rng.standard_normal(), -WITHIN, WITHIN))
    axis = servo.Servo(**p, duty=duty.value + far * duty.standard_deviation)
    bam = servo.Bam(float(rng.uniform(0.005, 0.04)), float(rng.uniform(0.002, 0.02)))
    low, high = [0.3, 0.1, 0.6, 1.0, 4.0], [0.9, 0.2, 1.4, 2.5, 8.0]
    runs = [tuple(rng.uniform(low, high).tolist()) for _ in range(3)]
    return pendulum(axis, bam, runs=runs, noise=float(rng.uniform(0.5e-3, 3e-3)))


def robot(k: int) -> Axis:
    """Robot joint number k, its gains known."""
    rng = _rng(4, k)
    p = _drawn(rng, {
        "J": (0.05, 0.5), "g_sin": (-2.0, 2.0), "g_cos": (-2.0, 2.0), "g_0": (-0.5, 0.5),
        "kp": (50.0, 100.0), "kd": (3.0, 6.0),
    })  # fmt: skip
    F_C = float(rng.uniform(0.3, 1.0))
    curve = Curve(
        F_C * rng.uniform(1.2, 2.2), F_C, float(rng.uniform(0.1, 0.5)),
        float(rng.uniform(0.03, 0.2)),
    )  # fmt: skip
    return arm(joint.Joint(**p), curve, noise=float(rng.uniform(0.2e-3, 1e-3)))


def dahl(k: int) -> Axis:
    """Dahl's bristles number k, which slide in the end."""
    rng = _rng(5, k)
    sigma_0, F_C = float(np.exp(rng.uniform(*np.log([3e5, 3e6])))), float(rng.uniform(8.0, 20.0))
    law = presliding.dahl(sigma_0, F_C, float(rng.uniform(20.0, 100.0)))
    mass, noise = float(rng.uniform(5.0, 30.0)), float(rng.uniform(0.01, 0.05)) * F_C / sigma_0
    return bristles(law, "dahl", mass, peak=1.1 * F_C, noise=noise)


def lugre(k: int) -> Axis:
    """LuGre's bristles number k, which slide in the end."""
    rng = _rng(6, k)
    sigma_0, F_C = float(np.exp(rng.uniform(*np.log([3e5, 3e6])))), float(rng.uniform(8.0, 15.0))
    law = presliding.LuGre(
        sigma_0, float(rng.uniform(200.0, 2000.0)), F_C * rng.uniform(1.1, 1.5), F_C,
        float(rng.uniform(5e-3, 5e-2)), float(rng.uniform(20.0, 100.0)),
    )  # fmt: skip
    mass, noise = float(rng.uniform(5.0, 30.0)), float(rng.uniform(0.01, 0.05)) * F_C / sigma_0
    return bristles(law, "lugre", mass, peak=1.15 * law.F_S, noise=noise)


def driven_gms(k: int) -> Axis:
    """Generalised Maxwell elements number k, presliding and sliding in one log."""
    rng = _rng(7, k)
    p = _driven(rng)
    first, ratio = float(rng.uniform(0.3, 0.7)), float(rng.uniform(3.0, 6.0))
    yields = p["way"] * float(rng.uniform(0.4, 0.7)) * np.array([1.0, ratio])
    tau = float(np.exp(rng.uniform(*np.log([5e-3, 3e-2]))))
    law = combined.Elements(
        p["F_C"] * np.array([first, 1.0 - first]), yields, p["F_V"], p["drop"], p["v_s"], tau
    )
    return _behind_encoder(law, p, 2.0 * float(yields[0]))


def driven_lugre(k: int) -> Axis:
    """LuGre's bristles number k, presliding and sliding in one log."""
    rng = _rng(8, k)
    p = _driven(rng)
    law = presliding.LuGre(
        p["F_C"] / p["way"], float(rng.uniform(200.0, 2000.0)), p["F_C"] * p["drop"], p["F_C"],
        p["v_s"], p["F_V"],
    )  # fmt: skip
    return _behind_encoder(law, p, p["way"])


def _driven(rng: Rng) -> dict[str, float]:
    """What both kinds have: F_C over the way of bristles of 0.3 to 3 N/um, and the rest."""
    p = _drawn(rng, {
        "F_C": (8.0, 20.0), "M": (5.0, 30.0), "F_V": (20.0, 200.0), "drop": (1.1, 1.5),
        "offset": (-2.0, 2.0),
    })  # fmt: skip
    p["way"] = p["F_C"] / float(np.exp(rng.uniform(*np.log([3e5, 3e6]))))
    p["v_s"] = float(np.exp(rng.uniform(*np.log([2e-3, 1e-2]))))
    p["step"] = float(np.exp(rng.uniform(*np.log([0.002, 0.02]))))
    return p


def _behind_encoder(
    law: presliding.LuGre | combined.Elements, p: Mapping[str, float], way: float
) -> Axis:
    """Its log: an encoder's step of 0.2 to 2 % of the way, noise of half of that, 1 % of F_C."""
    return both(law, p["M"], way, offset=p["offset"], noise=0.01 * p["F_C"], step=p["step"] * way)


def two_masses(k: int) -> Axis:
    """Two masses number k behind an encoder each: 3 s of sines under a loop of 8 to 14 Hz."""
    rng = _rng(9, k)
    p = _drawn(rng, {
        "M_m": (1.0, 3.0), "M": (3.0, 10.0), "F_C": (5.0, 30.0), "F_V": (10.0, 60.0),
        "F_C_motor": (5.0, 30.0), "F_V_motor": (10.0, 60.0),
    })  # fmt: skip
    p["play"] = float(np.exp(rng.uniform(*np.log([2e-5, 4e-4]))))
    swing = 2.0 * np.pi * float(rng.uniform(50.0, 110.0))  # of the two against each other
    reduced = p["M_m"] * p["M"] / (p["M_m"] + p["M"])
    p["stiffness"] = reduced * swing**2
    p["damping"] = 2.0 * float(rng.uniform(0.02, 0.08)) * reduced * swing
    loop = 2.0 * np.pi * float(rng.uniform(8.0, 14.0))
    p["kp"] = (p["M_m"] + p["M"]) * loop**2
    p["kd"] = 1.4 * (p["M_m"] + p["M"]) * loop
    t = np.arange(0.0, 3.0, 2e-3)
    goal = np.zeros(len(t))
    for size, rate in zip(
        rng.uniform([5e-3, 2e-3], [15e-3, 5e-3]), rng.uniform([0.8, 2.5], [1.5, 4.0]), strict=True
    ):
        goal += size * np.sin(2.0 * np.pi * rate * t + rng.uniform(0.0, 2.0 * np.pi))
    noise = np.exp(rng.uniform(np.log([5e-7, 5e-7]), np.log([2e-6, 5e-6])))
    goal = np.minimum(t / 0.5, 1.0) * goal
    return coupled(p, (t, goal), (float(noise[0]), float(noise[1])))
