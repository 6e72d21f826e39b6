"""Trials of a compensation: axes simulated at a scale, beside those without compensation.

`Trial` holds what stays the same while scales and modes are tried; `Tried` remembers the scales of
one mode, so that none is simulated twice.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Literal

import numpy as np

from ..friction import LAWS
from .closed_loop import compensated
from .corners import IDENTIFIED
from .limit_cycle import Sign, floors, signs, stretches, swings

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from ..friction import Law
    from ..rig import Rig
    from ..space import Array
    from .closed_loop import Reference, Sensor
    from .compensator import Compensator

Mode = Literal["reference", "feedback"]

#: Points of a trace that is kept to be drawn.
_DRAWN = 4000


@dataclass(frozen=True, eq=False)
class TrackingTrace:
    """The identified axis over a motion, without compensation and with the recommended one.

    Args:
        motion: Its name.
        t: s, (N,).
        reference: m or rad, (N,).
        without: Error, command minus position, m or rad, (N,).
        compensated: The same with compensation.
        output: What the compensator puts out, N or N m, (N,).
    """

    motion: str
    t: Array
    reference: Array
    without: Array
    compensated: Array
    output: Array


@dataclass(frozen=True, eq=False)
class Baseline:
    """The axes without compensation: errors (P, M), and by motion floors (P,) and signs."""

    rms: Array
    floors: tuple[Array, ...]
    signs: tuple[Mapping[Sign, NDArray[np.bool_]], ...]


@dataclass(frozen=True, eq=False)
class Trial:
    """Axes, motions and a compensator's shape, ready to be tried at a scale.

    Args:
        rig: The axes' rig.
        law: Their friction's law, which the compensator asks, too.
        believed: The parameter set that the compensator believes, SI, (k,).
        axes: Parameter sets of the axes by name; one is IDENTIFIED.
        motions: What they follow.
        shape: The compensator's settings beside scale and mode.
        sensor: How it sees.
    """

    rig: Rig
    law: Law
    believed: Array
    axes: Mapping[str, Array]
    motions: tuple[Reference, ...]
    shape: Compensator
    sensor: Sensor

    def tried(
        self, scale: float, mode: Mode, baseline: Baseline | None
    ) -> tuple[Array, list[tuple[Sign, int, int]], Baseline]:
        """RMS errors (P, M), the signs by axis and motion, and what was seen."""
        rms = np.empty((len(self.axes), len(self.motions)))
        signs_seen, baselines = [], []
        for m, motion in enumerate(self.motions):
            moved = compensated(
                self.rig, self.law, np.array(list(self.axes.values())), motion,
                [replace(self.shape, scale=scale, feedback=mode == "feedback")],
                (self.law, self.believed), self.sensor,
            )  # fmt: skip
            error = motion.x - moved.position
            rms[:, m] = np.nan_to_num(np.sqrt(np.mean(error * error, axis=1)), nan=np.inf)
            floor = (
                floors(motion, moved.position, self.sensor.resolution)
                if baseline is None
                else baseline.floors[m]
            )
            parts = stretches(motion, self.shape.dead_band)
            seen_here = signs(
                motion, parts, moved.position, moved.velocity, self.shape.dead_band, floor,
                self.calm[m],
            )  # fmt: skip
            if baseline is not None:
                seen_here = {k: v & ~baseline.signs[m][k] for k, v in seen_here.items()}
                worse = (rms[:, m] > baseline.rms[:, m]) & ~seen_here["runs away"]
                seen_here["is worse"] = worse
                signs_seen += [
                    (k, int(i), m) for k, v in seen_here.items() for i in np.flatnonzero(v)
                ]
            baselines.append((floor, seen_here))
        measured = Baseline(rms, tuple(f for f, _ in baselines), tuple(s for _, s in baselines))
        return rms, signs_seen, measured

    def frictionless(self) -> Array:
        """RMS errors of the identified axis without any friction, (M,): the loop's own."""
        return np.array(
            [np.sqrt(np.mean((m.x - self._viscous(m, 0.0)[0]) ** 2)) for m in self.motions]
        )

    @cached_property
    def calm(self) -> tuple[Array, ...]:
        """How far the errors swing, (P, stretches) for each motion, where nothing can hunt.

        The friction is a viscous one, as large as the believed one at the motion's speed: it
        falls nowhere, and damps. What swings then is what gravity makes of the loop.
        """
        return tuple(
            swings(m, stretches(m, self.shape.dead_band), self._viscous(m, 1.0))
            for m in self.motions
        )

    def _viscous(self, motion: Reference, share: float) -> Array:
        """Positions of the axes with a viscous friction in place of the law, (P, N)."""
        law = LAWS["coulomb-viscous-directional" if self.law.directional else "coulomb-viscous"]
        rig_parameters = np.array(list(self.axes.values()))[:, len(self.law.params) :]
        fastest = float(np.abs(motion.v).max())
        forces = np.abs(self.law.friction(np.array([fastest, -fastest]), self.believed[
            : len(self.law.params)])) / fastest  # fmt: skip
        levels = [0.0, forces[0], 0.0, forces[1]] if self.law.directional else [0.0, forces.mean()]
        axes = np.hstack(
            [np.tile(share * np.array(levels), (len(rig_parameters), 1)), rig_parameters]
        )
        off = [replace(self.shape, scale=0.0)]
        return compensated(self.rig, law, axes, motion, off, (law, axes[0])).position

    def traces(self, settings: Compensator | None) -> tuple[TrackingTrace, ...]:
        """The identified axis over each motion, thinned."""
        result = []
        plant = self.axes[IDENTIFIED]
        for motion in self.motions:
            pair = [replace(self.shape, scale=0.0), settings or replace(self.shape, scale=0.0)]
            moved = compensated(
                self.rig, self.law, np.array([plant, plant]), motion, pair,
                (self.law, self.believed), self.sensor,
            )  # fmt: skip
            thinned = slice(None, None, max(len(motion.t) // _DRAWN, 1))
            error = motion.x - moved.position
            result.append(
                TrackingTrace(
                    motion.name, motion.t[thinned], motion.x[thinned], error[0, thinned],
                    error[1, thinned], moved.output[1, thinned],
                )
            )  # fmt: skip
        return tuple(result)


class Tried:
    """The scales that one mode was tried at: errors, and signs by axis and motion."""

    def __init__(self, trial: Trial, mode: Mode) -> None:
        self._trial, self._mode = trial, mode
        rms, _, self._baseline = trial.tried(0.0, mode, None)
        self._found: dict[float, tuple[Array, list[tuple[Sign, int, int]]]] = {0.0: (rms, [])}

    @property
    def scales(self) -> list[float]:
        """Those that were tried, rising."""
        return sorted(self._found)

    def at(self, scale: float) -> tuple[Array, list[tuple[Sign, int, int]]]:
        """What happens at a scale."""
        scale = round(scale, 4)
        if scale not in self._found:
            rms, observed, _ = self._trial.tried(scale, self._mode, self._baseline)
            self._found[scale] = (rms, observed)
        return self._found[scale]

    def too_much(self, scale: float) -> bool:
        """Whether a scale shows a sign other than a greater error."""
        return any(sign != "is worse" for sign, _, _ in self.at(scale)[1])

    def worst(self, scale: float) -> float:
        """Greatest ratio of errors at a scale."""
        return float(ratios(np.stack([self.at(0.0)[0], self.at(scale)[0]]))[1].max())


def ratios(rms: Array) -> Array:
    """RMS errors (S, P, M) over those at the first scale; 1 where both are nothing."""
    without = rms[:1]
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(rms == without, 1.0, rms / without)
