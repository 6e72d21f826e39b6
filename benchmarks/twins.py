"""Twenty-two identifications whose truth is known, the same ones every time.

Two are the demo's twin, up and down. Twenty have true parameters uniform in the rig's own search
ranges, drawn again until the slide sticks and slips at least three times in the training range;
an echo with noise uniform in 0.05 to 0.5 mm; a log, and a transducer as fast as the log, at a rate
log-uniform in 20 to 1,000 Hz; and the two directions in turn.

The best known J of each is in best_known.json, which best_known.py writes.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.random import SeedSequence

from stribeck.bench.problems import TRAINING
from stribeck.data.ranges import Range
from stribeck.friction import LAWS
from stribeck.identify.problem import MotionProblem, problem
from stribeck.rig.motion.track import track
from stribeck.rig.slide_bed import PUBLISHED, SLIDE_BED, published_both
from stribeck.rig.twin import TestBed
from stribeck.space import Array, Space

Side = Literal["right", "left"]

FILE = Path(__file__).with_name("best_known.json")
#: An answer is found when J is within this share of the best known.
TOLERANCE = 0.005
RANDOM, SEED = 20, 2012
#: A motion with at least so many slips in the training range is stick-slip.
SLIPS = 3
NOISE, RATE = (0.05e-3, 0.5e-3), (20.0, 1000.0)
LAW = LAWS["stribeck"]
#: The twins' slide, with the dead band (m + K_J) dv with which their best J were searched.
SLIDE = SLIDE_BED.set(dp=(SLIDE_BED["m"] + SLIDE_BED["K_kt"] * SLIDE_BED["J_m"]) * SLIDE_BED["dv"])
_PARAMETERS = SLIDE.parameters(LAW)


@dataclass(frozen=True, eq=False)
class Twin:
    """An identification whose truth is known.

    Args:
        name: "demo-right", "demo-left", "random-01", ...
        side: The direction it is identified from.
        bed: The test bed that recorded it.
        truth: The free parameters behind the log, SI, in the order of the problem's space.
        seed: Of the sensor noise.
        demo: Whether it is the demo's, a run up and down with a parameter set each.
    """

    name: str
    side: Side
    bed: TestBed = field(repr=False)
    truth: Array
    seed: int
    demo: bool = False

    @cached_property
    def problem(self) -> MotionProblem:
        """J in mm over the five parameters; `residuals` shows what it is the RMS of."""
        if self.demo:
            log = self.bed.run("both", truth=published_both(), seed=self.seed)
        else:
            log = self.bed.run(
                "up" if self.side == "right" else "down",
                law=LAW,
                truth=_full(self.truth),
                seed=self.seed,
            )
        return problem(log.recording, rig=SLIDE, law=LAW, train=TRAINING[self.side])

    @property
    def best(self) -> float:
        """The least J known, mm."""
        return float(_best_known()[self.name]["J"])

    @property
    def best_x(self) -> Array:
        """Parameters at the least J known, SI."""
        return np.array(_best_known()[self.name]["x"])

    @property
    def target(self) -> float:
        """J at which it counts as identified, mm."""
        return self.best * (1 + TOLERANCE)


def twins(*, demo: bool = True, random: bool = True) -> list[Twin]:
    """The demo's two twins and the twenty random ones."""
    return [*(_demo() if demo else ()), *(_random() if random else ())]


def _best_known() -> dict[str, dict[str, Any]]:
    minima: dict[str, dict[str, Any]] = json.loads(FILE.read_text(encoding="utf-8"))["twins"]
    return minima


def _demo() -> Iterator[Twin]:
    for side in ("right", "left"):
        yield Twin(
            f"demo-{side}", side, TestBed(SLIDE), PUBLISHED[side][_free()], seed=0, demo=True
        )


def _random() -> Iterator[Twin]:
    for k, stream in enumerate(SeedSequence(SEED).spawn(RANDOM), 1):
        rng = np.random.default_rng(stream)
        side: Side = "right" if k % 2 else "left"
        noise = rng.uniform(*NOISE)
        rate = float(np.exp(rng.uniform(*np.log(RATE))))
        bed = TestBed(SLIDE, rate=rate, echo_rate=rate, echo_noise=noise)
        space = Space(tuple(p for p in _PARAMETERS if p.fixed is None))
        truth = next(x for x in _draws(space, rng) if slips(x, side) >= SLIPS)
        yield Twin(f"random-{k:02d}", side, bed, truth, seed=k)


def _draws(space: Space, rng: np.random.Generator) -> Iterator[Array]:
    while True:
        yield space.decode(space.sample(rng, 1))[0]


def slips(truth: Array, side: Side) -> int:
    """Number of starts from rest in the training range, by the slide's true motion."""
    bed = TestBed(SLIDE)
    drive, x0 = bed.drive("up" if side == "right" else "down")
    t = np.arange(0.0, drive.t[-1], 1e-3)
    motion = bed.rig.move(LAW, _full(truth)[None], track(drive, t, x0))
    moves = motion.velocity[0] != 0.0
    starts = np.flatnonzero(moves[1:] & ~moves[:-1])
    training = Range.parse(TRAINING[side], "mm")
    low, high = sorted((training.start, training.stop))
    x = motion.position[0, starts]
    return int(((low <= x) & (x <= high)).sum())


def _full(free: Array) -> Array:
    p = np.array([q.fixed if q.fixed is not None else np.nan for q in _PARAMETERS])
    p[_free()] = free
    return p


def _free() -> list[int]:
    return [i for i, q in enumerate(_PARAMETERS) if q.fixed is None]
