"""The logs of a fit by output error, each as the problem that it is by itself."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from ..space import Array
from .fit_warnings import NOISY, noise_floor
from .initial_state import FreeStartProblem
from .log_spread import LogPart
from .multistart import Optimum, multistart
from .problem import MotionProblem
from .search_settings import SearchSettings, sticks_and_slips
from .segment import recordings_of


def single_logs(
    problem: MotionProblem | FreeStartProblem, x: Array, answers: Mapping[int, Array]
) -> list[LogPart]:
    """The logs of a problem, its constants as they were estimated, each by itself at a fit.

    Args:
        problem: It.
        x: The fit, SI, (dim,).
        answers: Where else a log may start from, by its `id`, SI, (its dim,).
    """
    motion = problem.problem if isinstance(problem, FreeStartProblem) else problem
    dim, parts = len(motion.space.params), []
    for log in recordings_of(motion.train):
        part = motion.of_log(log)
        starts = (answers[id(log)],) if id(log) in answers else ()
        if isinstance(problem, FreeStartProblem):
            own = [k for k, s in enumerate(motion.train, dim) if s.recording is log]
            parts.append(LogPart(log, FreeStartProblem(part), x[[*range(dim), *own]], starts))
        else:
            parts.append(LogPart(log, part, x, starts))
    return parts


def answers_alone(optimum: Optimum, settings: SearchSettings) -> tuple[dict[int, Array], int]:
    """What a search has for each log by itself, by its `id`, SI; and rows, each of all logs.

    Nothing where the common answer is near that of each log: where all are fitted to their noise,
    and where no slip can come at another time.
    """
    whole = optimum.problem
    motion = whole.problem if isinstance(whole, FreeStartProblem) else whole
    if not isinstance(motion, MotionProblem) or motion.parameters.objective.by_slip:
        return {}, 0
    logs = recordings_of(motion.train)
    if len(logs) == 1 or not sticks_and_slips(motion):
        return {}, 0
    noise = motion.noise_of(optimum.x[: motion.space.dim])
    if noise <= NOISY * noise_floor(motion.parameters.rig, logs):
        return {}, 1
    alone = replace(settings, repeats=1)
    answers, evaluations = {}, 0
    for log in logs:
        own = multistart(motion.of_log(log), alone)
        answers[id(log)] = own.x
        evaluations += own.search.evaluations
    return answers, 1 + evaluations // len(logs)
