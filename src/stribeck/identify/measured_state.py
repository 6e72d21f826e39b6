"""The state in which a log begins, estimated together with the parameters.

A motion that does not begin at a rest is simulated from the measured state: from a sample with its
noise, and from a velocity that no sensor may have seen. What these are off by fades away in the
first part of the motion, and until then looks like friction or inertia. So the state is estimated
at a good fit, and the two directions in which another state would move the motion are taken out of
the residuals: to first order that is the same as to have the states among the unknowns, at no
further dimension for the search and the profiles.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..data.resolution import noise, step
from ..rig.simulated import as_simulated
from ..space import Array
from .fit_warnings import NOISY, noise_floor
from .initial_state import started_at
from .polish import Polished, polish
from .problem import MotionProblem
from .segment import Segment, recordings_of

#: Estimates of the state, each from the one before.
ROUNDS = 4
#: A direction in which a state off by as much as the sensor's noise moves a motion by no more than
#: this share of the noise, as a root of the sum of squares, is left in the residuals.
SLIGHT = 0.1
#: Beyond the noise, states are worth a refit if they take this share of the misfit away.
EXPLAINS = 0.5
#: Samples over which a velocity is measured, for the step by which it is varied; the least step of
#: a position, as a share of the way that the axis goes.
SAMPLES, LEAST = 8, 1e-6
#: Motions that an estimate takes, and evaluations a parameter of the refit after it.
VARIANTS, _REFIT = 5, 25


def with_states(problem: MotionProblem, x: Array) -> tuple[MotionProblem, Array, int]:
    """The problem with the states estimated in which its motions begin, refitted; and the rows.

    The problem itself where its motions begin at rests or with the log, where it does not count
    squares, and where a misfit beyond the noise remains: what is wrong there is not the start.

    Args:
        problem: The motion problem.
        x: A good fit, SI, (dim,).
    """
    rig = as_simulated(problem.parameters.rig)
    squares = problem.parameters.objective.loss == "squares"
    if rig.from_rest or rig.history or problem.weights is not None or not squares:
        return problem, x, 0
    floor = NOISY * noise_floor(problem.parameters.rig, recordings_of(problem.train))
    started, best, rows = problem, Polished(x, float(problem(x[None])[0]), 1), 1
    for _ in range(ROUNDS):
        train, moved = _estimated(started, best.x)
        other, rows = started.of_segments(train), rows + VARIANTS + 1
        if not float(other(best.x[None])[0]) < max(floor, EXPLAINS * best.cost):
            break
        refit = polish(other, best.x, None, _REFIT * len(x))
        rows += refit.evaluations
        if started is not problem and not refit.cost < best.cost:
            break
        started, best = other, refit
        if not moved:
            break
    return (started, best.x, rows) if best.cost <= floor else (problem, x, rows)


def _estimated(problem: MotionProblem, x: Array) -> tuple[list[Segment], bool]:
    """The segments of a problem from their estimated states, and whether one has moved by much."""
    train, moved = [], False
    for s in problem.train:
        steps = _steps(s)
        plain = replace(s, start_directions=None)
        residuals = problem.segment_residuals(x[None], plain)[0]
        D = np.stack([_direction(problem, x, plain, *h) for h in steps], axis=1)
        sizes, sensor = np.linalg.norm(D, axis=0), steps[0][0] / problem.scale
        kept = np.isfinite(sizes) & (sizes > SLIGHT * sensor)
        if not (kept.any() and np.isfinite(residuals).all()):
            train.append(plain)
            continue
        shares, *_ = np.linalg.lstsq(D[:, kept], residuals, rcond=None)
        by = np.zeros(2)
        by[kept] = -shares
        moved |= bool((np.abs(by) > SLIGHT).any())
        state = started_at(plain, plain.track.x0 + by[0] * steps[0][0])
        track = state.track._replace(v0=state.track.v0 + by[1] * steps[1][1])
        directions = np.linalg.qr(D[:, kept])[0]
        train.append(replace(state, track=track, start_directions=directions))
    return train, moved


def _steps(segment: Segment) -> tuple[tuple[float, float], tuple[float, float]]:
    """Steps of position and of velocity by as much as the sensor's noise may be behind them, SI.

    The second is nothing where the axis rests.
    """
    log, t = segment.recording, segment.track.t
    sensor = float(np.hypot(noise(log), step(log.position) / np.sqrt(12.0)))
    sensor = max(sensor, LEAST * float(np.ptp(log.position)))
    moves = segment.track.v0 != 0.0
    return (sensor, 0.0), (0.0, moves * 2.0 * sensor / float(t[min(SAMPLES, len(t) - 1)] - t[0]))


def _direction(problem: MotionProblem, x: Array, segment: Segment, dx: float, dv: float) -> Array:
    """By how much such a step moves the residuals of a segment, (its samples that count,)."""
    track = segment.track
    up, down = (
        problem.segment_residuals(
            x[None],
            replace(segment, track=track._replace(x0=track.x0 + k * dx, v0=track.v0 + k * dv)),
        )[0]
        for k in (1.0, -1.0)
    )
    half: Array = 0.5 * (up - down)
    return half
