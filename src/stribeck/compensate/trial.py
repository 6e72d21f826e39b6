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
from .limit_cycle import Observed, Sign, Stretch, floors, observed, stretches, swings

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from ..friction import Law
    from ..rig import Rig
    from ..space import Array
    from .closed_loop import Reference, Sensor
    from .compensator import Compensator

Mode = Literal["reference", "crossover", "feedback"]

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
class Outcome:
    """What axes do at a scale of one mode, (P, M) for P axes and M motions.

    Args:
        rms: RMS error, m or rad; inf where an axis ran away.
        signs: Signs that are not there without compensation, by axis and motion.
        observed: By motion, stretch by stretch.
        floors: By motion how much is looked at, (P,).
    """

    rms: Array
    signs: tuple[tuple[Sign, int, int], ...]
    observed: tuple[Observed, ...]
    floors: tuple[Array, ...]

    @property
    def swing(self) -> Array:
        """How far the error swings where that lasts, m or rad; the worst stretch, (P, M)."""
        return np.column_stack([o.swing.max(axis=1, initial=0.0) for o in self.observed])

    @property
    def at_rest(self) -> Array:
        """Share of the time in which the axis rests while the reference moves, (P, M)."""
        return np.column_stack([o.at_rest for o in self.observed])

    @property
    def peak(self) -> Array:
        """Greatest speed, m/s or rad/s, (P, M)."""
        return np.column_stack([o.peak for o in self.observed])


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

    def settings(self, scale: float, mode: Mode) -> Compensator:
        """The compensator at a scale of a mode."""
        crossover = self.shape.crossover if mode == "crossover" else 0.0
        return replace(self.shape, scale=scale, feedback=mode != "reference", crossover=crossover)

    def tried(self, scale: float, mode: Mode, baseline: Outcome | None) -> Outcome:
        """What the axes do, with the signs that a baseline does not show."""
        still = self.shape.reference_band
        rms = np.empty((len(self.axes), len(self.motions)))
        signs: list[tuple[Sign, int, int]] = []
        each, looked_at = [], []
        for m, motion in enumerate(self.motions):
            moved = compensated(
                self.rig, self.law, np.array(list(self.axes.values())), motion,
                [self.settings(scale, mode)], (self.law, self.believed), self.sensor,
            )  # fmt: skip
            error = motion.x - moved.position
            rms[:, m] = np.nan_to_num(np.sqrt(np.mean(error * error, axis=1)), nan=np.inf)
            floor = (
                floors(motion, moved.position, self.sensor.resolution)
                if baseline is None
                else baseline.floors[m]
            )
            looked = observed(
                motion, self.parts[m], moved.position, moved.velocity, still, floor, self.calm[m]
            )
            if baseline is not None:
                beyond = looked.beyond(baseline.observed[m])
                beyond["is worse"] = (rms[:, m] > baseline.rms[:, m]) & ~beyond["runs away"]
                signs += [(k, int(i), m) for k, v in beyond.items() for i in np.flatnonzero(v)]
            each.append(looked)
            looked_at.append(floor)
        return Outcome(rms, tuple(signs), tuple(each), tuple(looked_at))

    def frictionless(self) -> Array:
        """RMS errors of the identified axis without any friction, (M,): the loop's own."""
        axis = [self.axes[IDENTIFIED]]
        return np.array(
            [np.sqrt(np.mean((m.x - self._viscous(axis, m, 0.0)[0]) ** 2)) for m in self.motions]
        )

    @cached_property
    def parts(self) -> tuple[list[Stretch], ...]:
        """The stretches of each motion."""
        return tuple(stretches(m, self.shape.reference_band) for m in self.motions)

    @cached_property
    def calm(self) -> tuple[Array, ...]:
        """How far the errors swing, (P, stretches) for each motion, where nothing can hunt.

        The friction is a viscous one, as large as the believed one at the motion's speed: it
        falls nowhere, and damps. What swings then is what gravity makes of the loop.
        """
        axes = list(self.axes.values())
        return tuple(
            swings(m, parts, self._viscous(axes, m, 1.0))
            for m, parts in zip(self.motions, self.parts, strict=True)
        )

    def _viscous(self, plants: Sequence[Array], motion: Reference, share: float) -> Array:
        """Positions of n axes with a viscous friction in place of the law, (n, N)."""
        law = LAWS["coulomb-viscous-directional" if self.law.directional else "coulomb-viscous"]
        rig_parameters = np.array(plants)[:, len(self.law.params) :]
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
    """The scales that one mode was tried at.

    Args:
        trial: What is tried.
        mode: At which velocity the law is asked.
        baseline: The axes without compensation, which no mode changes.
    """

    def __init__(self, trial: Trial, mode: Mode, baseline: Outcome) -> None:
        self._trial, self._mode = trial, mode
        self._outcomes: dict[float, Outcome] = {0.0: baseline}

    @property
    def scales(self) -> list[float]:
        """Those that were tried, rising."""
        return sorted(self._outcomes)

    def at(self, scale: float) -> Outcome:
        """What happens at a scale."""
        scale = round(scale, 4)
        if scale not in self._outcomes:
            self._outcomes[scale] = self._trial.tried(scale, self._mode, self._outcomes[0.0])
        return self._outcomes[scale]

    def too_much(self, scale: float) -> bool:
        """Whether a scale shows a sign other than a greater error."""
        return any(sign != "is worse" for sign, _, _ in self.at(scale).signs)

    def worst(self, scale: float) -> float:
        """Greatest ratio of errors at a scale."""
        return float(ratios(np.stack([self.at(0.0).rms, self.at(scale).rms]))[1].max())


def ratios(rms: Array) -> Array:
    """RMS errors (S, P, M) over those at the first scale; 1 where both are nothing."""
    without = rms[:1]
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(rms == without, 1.0, rms / without)
