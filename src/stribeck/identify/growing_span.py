"""Two masses under a recorded force: an answer from longer and longer beginnings of their motion.

Where no controller holds an axis to its command, an error of its friction grows with the square of
the time, and what the two masses do to each other is lost beside it: J over a whole log has minima
that have nothing to do with play and stiffness. Over its beginning there is less to drift, so a
descent there comes near, and each next one begins where the last has ended.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ..rig.two_masses import TwoMassRig
from .nested_answers import descended
from .refinement import Refined

if TYPE_CHECKING:
    from .problem import MotionProblem
    from .segment import Segment

#: Shares of the samples that count, one after the other, and the fewest for each parameter.
SHARES, FEWEST = (1 / 8, 1 / 4, 1 / 2, 3 / 4), 8


def growing_span(problem: MotionProblem, best: Refined) -> Refined:
    """The best of an answer and of the descents over longer and longer beginnings.

    Args:
        problem: Its J is minimised.
        best: The answer so far.
    """
    rig, space = problem.parameters.rig, problem.space
    if not isinstance(rig, TwoMassRig) or rig.commanded or problem.weights is not None:
        return best
    spent, starts = best.evaluations, [best.x, space.decode(np.full((1, space.dim), 0.5))[0]]
    for share in SHARES:
        if share * problem.samples < FEWEST * space.dim:
            continue
        end = descended(problem.of_segments(_begun(problem.train, share)), starts)
        starts, spent = [end.x], spent + end.evaluations
    end = descended(problem, [*starts, best.x])
    return replace(end if end.cost < best.cost else best, evaluations=spent + end.evaluations)


def _begun(train: Sequence[Segment], share: float) -> list[Segment]:
    """Segments up to a share of their samples that count; tracks of one motion keep its inputs."""
    inputs: dict[int, np.ndarray] = {}
    result = []
    for segment in train:
        track = segment.track
        counts = np.flatnonzero(track.score)
        n = int(counts[int(share * (len(counts) - 1))]) + 1
        shared = inputs.setdefault(id(track.inputs), np.ascontiguousarray(track.inputs[:, :n]))
        begun = track.of_samples(slice(n))._replace(inputs=shared)
        rows = slice(segment.rows.start, min(segment.rows.stop, segment.begin + n))
        result.append(replace(segment, track=begun, rows=rows))
    return result
