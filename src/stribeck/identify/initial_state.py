"""Where each motion starts, found together with the parameters.

A simulation starts where the sensor saw the axis rest, give or take the sensor's noise. In
stick-slip that little matters: a start that is off by a tenth of a millimetre shifts every slip of
the stroke, and the parameters bend to make up for it. So the last refinement, and every statement
about uncertainty, has the start of each segment among the unknowns. They are as much part of the
data as of the model: a rest before the range counts as samples of its start.
"""

from __future__ import annotations

from collections.abc import Mapping
from copy import copy
from dataclasses import replace

import numpy as np

from ..data.repeated_samples import is_new
from ..data.resolution import noise, step
from ..optimize import rms
from ..rig import Rig
from ..rig.simulated import as_simulated
from ..space import Array, Param, Space
from .parameters import Parameters
from .problem import MotionProblem
from .segment import Segment

#: How far a start may lie from where it was seen, in standard errors of that, and in quantisation
#: steps of the sensor.
_SIGMAS, _STEPS = 6.0, 1.0
#: The least range of a start, as a share of the way that the axis goes.
_LEAST = 1e-6


class FreeStartProblem:
    """A motion problem with the start of each segment as a further parameter, in its order.

    The parameters of the motion come first. Residuals are those of the motion problem, each
    segment's after one for the rest before it: sqrt(n) (start − mean of its n samples).

    Args:
        problem: The motion problem.
    """

    def __init__(self, problem: MotionProblem) -> None:
        self.problem, self.parameters = problem, problem.parameters
        self.name = f"{problem.name}/starts"
        self._seen = [_measured_start(s) for s in problem.train]
        starts = tuple(
            Param(f"start_{k}", mean - reach, mean + reach, "m")
            for k, (mean, _, reach) in enumerate(self._seen, 1)
        )
        self.space = Space((*problem.space.params, *starts))
        self.logs = tuple(n + 1 for n in problem.logs)

    def on(self, rig: Rig) -> FreeStartProblem:
        """The same problem on a rig of the same kind with other constants."""
        other = copy(self)
        other.problem = self.problem.on(rig)
        other.parameters = other.problem.parameters
        return other

    def over(self, parameters: Parameters) -> FreeStartProblem:
        """The same problem over other free parameters or search ranges."""
        return FreeStartProblem(self.problem.over(parameters))

    def at(self, x: Array) -> tuple[MotionProblem, Array]:
        """The motion problem from the starts of a point (dim,), and the rest of the point."""
        k = len(self.problem.space.params)
        motion = copy(self.problem)
        motion.train = tuple(
            started_at(s, float(x0)) for s, x0 in zip(motion.train, x[k:], strict=True)
        )
        return motion, x[:k]

    def thinned(self) -> FreeStartProblem:
        """The problem itself: motions that depend on their start so much need all samples."""
        return self

    @property
    def nominal(self) -> Array:
        """The starts as they were seen, (segments,)."""
        return np.array([s.track.x0 for s in self.problem.train])

    def __call__(self, x: Array, /) -> Array:
        """(n, dim) points to (n,) root mean squares of their residuals."""
        return rms(self.residuals(x))

    def residuals(self, x: Array, /, constants: Mapping[str, Array] | None = None) -> Array:
        """(n, dim) points to (n, samples + segments) residuals, in the problem's unit.

        Args:
            x: The points.
            constants: Of the rig, SI by name, (n,), that each point has a value of its own of.
        """
        x = np.atleast_2d(x)
        k = len(self.problem.space.params)
        blocks = []
        for at, segment in enumerate(self.problem.train):
            starts = x[:, k + at]
            mean, n, _ = self._seen[at]
            blocks.append((np.sqrt(n) * (starts - mean) / self.problem.scale)[:, None])
            blocks.append(
                self.problem.started_residuals(x[:, :k], segment, starts, constants or {})
            )
        return np.concatenate(blocks, axis=1)


def started_at(segment: Segment, x0: float) -> Segment:
    """The same segment from another start."""
    return replace(segment, track=segment.track.begun_at(x0, segment.track.v0))


def _measured_start(segment: Segment) -> tuple[float, float, float]:
    """Mean of the samples at rest before those that count, how many they are, and a range.

    Without such samples the start is known from the fit alone.
    """
    log, track = segment.recording, segment.track
    anew = is_new(log)[segment.still]
    n = int(anew.sum())
    sd, q = noise(log), step(log.position)
    mean = float(log.position[segment.still][anew].mean()) if n else track.x0
    reach = _SIGMAS * sd / np.sqrt(max(n, 1)) + _STEPS * q + _LEAST * float(np.ptp(log.position))
    return mean, float(n), reach + abs(mean - track.x0)


def free_starts(problem: MotionProblem) -> bool:
    """Whether the starts of a problem are unknowns: its rig says so.

    A slip by itself starts from the mean of a whole rest, and when it begins is seen.
    """
    return as_simulated(problem.parameters.rig).free_start and problem.weights is None
