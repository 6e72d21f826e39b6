"""A motion problem with the delay of its measured motion after its drive as a further unknown."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ..optimize import rms
from ..rig.simulated import as_simulated
from ..space import Array, Param, Space
from .initial_state import started_at

if TYPE_CHECKING:
    from ..rig.motion.track import Track
    from .problem import MotionProblem
    from .segment import Segment


class DelayedProblem:
    """A motion problem with the delay of its measured motion as a further parameter, the last.

    Args:
        problem: The motion problem, with its starts as they are.
        reach: The longest delay to either side, s.
    """

    def __init__(self, problem: MotionProblem, reach: float) -> None:
        self.problem, self.parameters = problem, problem.parameters
        self.name = f"{problem.name}/delay"
        self.logs, self.priors, self.dofs = problem.logs, problem.priors, problem.dofs
        delay = Param("delay", -reach, reach, "s")
        self.space = Space((*problem.space.params, delay))

    def __call__(self, x: Array, /) -> Array:
        """(n, dim) points to (n,) root mean squares of their residuals."""
        return rms(self.residuals(x))

    def residuals(self, x: Array, /) -> Array:
        """(n, dim) points to (n, rows) residuals, in the problem's unit."""
        x = np.atleast_2d(x)
        result = np.full((len(x), sum(self.logs) + self.priors), np.nan)
        for seconds in np.unique(x[:, -1]).tolist():
            rows = x[:, -1] == seconds
            result[rows] = self._at(x[rows, :-1], seconds)
        return result

    def _at(self, x: Array, seconds: float) -> Array:
        """The residuals under one delay, (n, rows).

        Where a command alone drives the axis, that comes later, which is exact; so it does where
        each slip has a breakaway of its own, whose instant is measured, too. Elsewhere the
        simulated motion is read between its samples: the measured one has noise, which would
        average out there.
        """
        by_slip = self.problem.weights is not None
        if by_slip or not any(s.track.inputs.size for s in self.problem.train):
            return self._commanded(seconds).residuals(x)
        blocks = [
            self.problem.segment_residuals(x, self._started(segment, seconds), late=seconds)
            for segment in self.problem.train
        ]
        return np.concatenate(blocks, axis=1)

    def _started(self, segment: Segment, seconds: float) -> Segment:
        """A segment from where its motion is seen so much later."""
        log, at = segment.recording, segment.track.t[0]
        if as_simulated(self.parameters.rig).from_rest:
            return segment
        start, there = np.interp([at, at + seconds], log.t, log.position)
        return started_at(segment, segment.track.x0 + float(there - start))

    def _commanded(self, seconds: float) -> MotionProblem:
        """The motion problem under a command that comes so much later."""
        train = [replace(s, track=_driven_later(s.track, seconds)) for s in self.problem.train]
        weights = self.problem.weights
        if weights is not None:
            return self.problem.weighed(weights, train)
        return self.problem.of_segments(train)


def _driven_later(track: Track, seconds: float) -> Track:
    """A track whose command, and what else drives the axis at the samples, comes so much later."""
    inputs = track.inputs
    if inputs.size:
        inputs = np.array([np.interp(track.t - seconds, track.t, row) for row in inputs])
    return track._replace(knots_t=track.knots_t + seconds, inputs=inputs)
