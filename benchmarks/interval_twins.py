"""Recordings whose truth is known, for `intervals`: slide beds, EMPS loops and servo pendulums.

Each is a function of its number and of the seed of its sensor noise alone. Noise is white, or a
first-order autoregression that forgets within so many samples.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.random import SeedSequence
from scipy.signal import lfilter

from stribeck import Recording
from stribeck.friction import LAWS, Law
from stribeck.rig import Rig
from stribeck.rig.emps import EMPS
from stribeck.rig.servo_pendulum import SERVO_PENDULUM
from stribeck.rig.slide_bed import SLIDE_BED
from stribeck.rig.twin import TestBed
from stribeck.space import Array, Rng
from twins import NOISE, SLIPS, Side, slips

SEED = 2012
#: Samples (echoes) in which correlated noise falls to 1 / e.
MEMORY = 5.0
#: Rates of slide-bed logs, Hz.
RATE = (20.0, 200.0)
#: What an EMPS twin's truth is drawn from, SI: about the published axis.
LOOP = {"F_C": (10.0, 35.0), "F_V": (100.0, 300.0), "M": (60.0, 140.0), "offset": (-5.0, 5.0)}
#: Standard deviation of its force, N, at 1 kHz; the balance filters most of it away.
FORCE_NOISE, LOOP_SECONDS = (3.0, 30.0), 24.0
#: What a pendulum's truth is drawn from, SI: within the search ranges, about real servos.
SWING = {
    "F_C": (0.005, 0.04), "F_V": (0.002, 0.02), "k_t": (0.2, 0.8), "R": (2.0, 8.0),
    "armature": (1e-3, 8e-3), "q_offset": (-0.05, 0.05),
}  # fmt: skip
#: Its sensor's noise, rad; how many logs, and how long each is.
ANGLE_NOISE, SWINGS, SWING_SECONDS, SWING_RATE = (0.5e-3, 3e-3), 3, 6.0, 100.0


@dataclass(frozen=True, eq=False)
class Known:
    """Recordings of an axis whose parameters are known.

    Args:
        recordings: Of the sensors.
        rig: The axis.
        law: Its friction.
        truth: The free parameters behind the logs, SI, by name.
        noise: Standard deviation of the sensor that is fitted, SI.
        rate: Of the logs, Hz.
    """

    recordings: tuple[Recording, ...]
    rig: Rig
    law: Law
    truth: dict[str, float]
    noise: float
    rate: float


def remembering(rng: Rng, n: int, memory: float) -> Array:
    """Noise of standard deviation 1, (n,), that falls to 1 / e within `memory` samples; 0: white.

    The autoregression is in its stationary state from the first sample on.
    """
    white = rng.standard_normal(n)
    if memory == 0:
        return white
    a = float(np.exp(-1 / memory))
    later = lfilter([np.sqrt(1 - a * a)], [1.0, -a], white[1:], zi=[a * white[0]])[0]
    return np.concatenate([white[:1], later])


@dataclass(frozen=True)
class RememberingBed(TestBed):
    """A test bed whose transducer errs alike from echo to echo.

    Args:
        memory: See `remembering`.
    """

    memory: float = field(default=MEMORY)

    def _transducer(self, t: Array, x: Array, rng: Rng) -> Array:
        echo = np.floor(t * self.echo_rate + 1e-9).astype(int)
        noise = self.echo_noise * remembering(rng, int(echo[-1]) + 1, self.memory)
        position: Array = np.interp(echo / self.echo_rate, t, x) + noise[echo]
        return position


def bed(k: int, *, memory: float = 0.0, seed: int | None = None) -> Known:
    """Slide bed number k, one stroke; even ones rightward, odd ones leftward.

    Args:
        k: Its number.
        memory: Of the transducer's noise.
        seed: Of its noise; a seed of its own for each bed by default.
    """
    rng = np.random.default_rng(SeedSequence((SEED, k)))
    law = LAWS["stribeck"]
    rate = float(np.exp(rng.uniform(*np.log(RATE))))
    noise = float(rng.uniform(*NOISE))
    side: Side = "left" if k % 2 else "right"
    names = [q.name for q in SLIDE_BED.parameters(law)]
    free = [i for i, q in enumerate(SLIDE_BED.parameters(law)) if q.fixed is None]
    p = next(p for p in _sliding(law, rng) if slips(p[free], side) >= SLIPS)
    test_bed = RememberingBed(rate=rate, echo_rate=rate, echo_noise=noise, memory=memory)
    log = test_bed.run(
        "down" if side == "left" else "up", law=law, truth=p, seed=k if seed is None else seed
    )
    truth = {names[i]: float(p[i]) for i in free}
    return Known((log.recording,), SLIDE_BED.exact(), law, truth, noise, rate)


def _sliding(law: Law, rng: Rng) -> Iterator[Array]:
    while True:
        p = SLIDE_BED.sample(law, rng, 1)
        if law.physical(p[:, : len(law.params)])[0]:
            yield p[0]


def loop(k: int, *, memory: float = 0.0, locked: bool = False) -> Known:
    """EMPS loop number k: a sum of sines for a command, noise on the measured force.

    A controller's output is held from one sample to the next. What acts on the motion about a
    sample is the mean of the outputs before and after it, and this is logged.

    Args:
        k: Its number.
        memory: Of the noise.
        locked: Whether the output is logged as the controller writes it, so that the force is half
            a sample ahead of the motion.
    """
    rng = np.random.default_rng(SeedSequence((SEED + 1, k)))
    law = LAWS["coulomb-viscous"]
    p, truth = _drawn(EMPS, law, LOOP, rng)
    noise = float(np.exp(rng.uniform(*np.log(FORCE_NOISE))))
    t = np.arange(0.0, LOOP_SECONDS, EMPS["T"])
    command = sum(
        size * np.sin(2 * np.pi * f * t + rng.uniform(0, 2 * np.pi))
        for size, f in ((0.08, 0.31), (0.03, 0.83), (0.004, 2.3))
    )
    command = np.asarray(command, dtype=float)
    ready = Recording(t=t, position=command, command=command, voltage=np.zeros(len(t)))
    motion = EMPS.simulate(law, p[None], ready)
    force = motion.force[0]
    if not locked:
        force = (force + np.append(force[:1], force[:-1])) / 2
    force = force + noise * remembering(rng, len(t), memory)
    log = Recording(t=t, position=motion.position[0], command=command, voltage=force / EMPS["gtau"])
    return Known((log,), EMPS, law, truth, noise, 1 / EMPS["T"])


def pendulum(k: int) -> Known:
    """Servo pendulum number k: a few logs with other masses and lengths, noise on the angle."""
    rng = np.random.default_rng(SeedSequence((SEED + 2, k)))
    rig, law = SERVO_PENDULUM.exact(), LAWS["coulomb-viscous"]
    p, truth = _drawn(rig, law, SWING, rng)
    noise = float(rng.uniform(*ANGLE_NOISE))
    t = np.arange(0.0, SWING_SECONDS, 1 / SWING_RATE)
    logs = []
    for _ in range(SWINGS):
        size, slow, fast = rng.uniform([0.6, 1.0, 4.0], [1.4, 2.5, 8.0])
        goal = size * np.sin(slow * t) + 0.3 * np.sin(fast * t)
        extra = {
            "mass": np.full(len(t), rng.uniform(0.3, 0.9)),
            "length": np.full(len(t), rng.uniform(0.1, 0.2)),
            # the torque is off for the last third, and the pendulum swings out
            "torque_enable": (t < 2 / 3 * SWING_SECONDS).astype(float),
        }
        empty = Recording(t=t, position=np.zeros(len(t)), command=goal, rotary=True, extra=extra)
        x = rig.simulate(law, p[None], empty).position[0]
        measured = x + noise * rng.standard_normal(len(t))
        logs.append(Recording(t=t, position=measured, command=goal, rotary=True, extra=extra))
    return Known(tuple(logs), rig, law, truth, noise, SWING_RATE)


def _drawn(
    rig: Rig, law: Law, ranges: dict[str, tuple[float, float]], rng: Rng
) -> tuple[Array, dict[str, float]]:
    """A parameter set, (k,), and its free ones by name."""
    params = rig.parameters(law)
    p = np.array([q.fixed if q.fixed is not None else rng.uniform(*ranges[q.name]) for q in params])
    free = [i for i, q in enumerate(params) if q.fixed is None]
    return p, {params[i].name: float(p[i]) for i in free}
