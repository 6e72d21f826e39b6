"""Logs whose motion tips: a little further along a parameter it is another motion.

A pendulum that comes to rest near its upper point falls to one side or to the other, and a
parameter decides which by its last digits. A misfit has a cliff there. If the model leaves
something out, the least misfit likes to lie at the very edge, where the motion hangs for as long as
that of the log; intervals then end at the cliff, as narrow as it is near, whatever the noise is.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..wording import option
from .conditions import Violation
from .initial_state import FreeStartProblem

if TYPE_CHECKING:
    from ..data.recording import Recording
    from ..space import Array
    from .problem import MotionProblem

#: Two distances along a parameter, in shares of its search range. A motion tips between them if at
#: the second the misfit of its log is so many times that of the answer, and so many times what the
#: first one promises of it, and if that raises the misfit of all by this share. How soon a
#: pendulum falls changes fast before it stays, so that much is promised of some that tip.
NEAR, FAR = 1e-5, 1e-4
TIMES, BEYOND, MATERIAL = 3.0, 1.5, 0.01


def tipping_violations(
    problem: MotionProblem | FreeStartProblem, x: Array
) -> tuple[list[Violation], int]:
    """What is said of a log that tips beside an answer; and the rows evaluated.

    Args:
        problem: The problem solved.
        x: The answer, SI, (dim,).
    """
    motion, x = problem.at(x) if isinstance(problem, FreeStartProblem) else (problem, x)
    if motion.weights is not None:  # slips that each have a breakaway of their own
        return [], 0
    recordings = [segment.recording for segment in motion.train]
    rows = 1
    edges: dict[int, tuple[float, str, Array]] = {}
    for name, there, rise, tips in _neighbours(motion, x):
        rows += 2
        for k in np.flatnonzero(tips).tolist():
            if rise > max(1.0 + MATERIAL, edges.get(k, (1.0,))[0]):
                edges[k] = rise, name, there
    if not edges:
        return [], rows
    k, (_, name, there) = max(edges.items(), key=lambda item: item[1][0])
    names = list(dict.fromkeys(recordings[i].label for i in sorted(edges)))
    return [Violation("model", _sentence(motion, x, recordings[k], name, there, names))], rows


def _neighbours(
    motion: MotionProblem, x: Array
) -> Iterator[tuple[str, Array, float, NDArray[np.bool_]]]:
    """The places at FAR: parameter, place, misfit over that of the answer, segments that tip."""
    (u,) = motion.space.encode(x[None])
    starts = np.cumsum([0, *motion.logs[:-1]])
    at = motion.residuals(x[None])[0]
    least = np.add.reduceat(at**2, starts)
    for i, name in enumerate(motion.space.names):
        for side in (1.0, -1.0):
            places = np.tile(u, (2, 1))
            places[:, i] += side * np.array([NEAR, FAR])
            if not 0.0 <= places[1, i] <= 1.0:
                continue
            there = motion.space.decode(places)
            near, far = motion.residuals(there)
            if not np.isfinite([near[0], far[0]]).all():
                continue
            promised = np.add.reduceat((at + FAR / NEAR * (near - at)) ** 2, starts)
            squares = np.add.reduceat(far**2, starts)
            tips = squares > np.fmax(TIMES**2 * least, BEYOND**2 * promised)
            yield name, there[1], float(np.sqrt(squares.sum() / least.sum())), tips


def _sentence(
    motion: MotionProblem, x: Array, log: Recording, name: str, there: Array, names: list[str]
) -> str:
    alone = motion.of_log(log)
    label, way = motion.parameters.rig.label(name), "more" if (there > x).any() else "less"
    others = f" ({', '.join(names)} do)" if len(names) > 1 else ""
    return (
        f"{log.label} tips{others}: its error is {alone.reported(x):.3g} {motion.unit}, and "
        f"{alone.reported(there):.3g} {motion.unit} with {100 * FAR:g} % of its range {way} of "
        f"{label}: the answer balances a motion on an edge, and intervals end there whatever the "
        f"noise is; leave the log out, or train on what comes before it tips ({option('train')})"
    )
