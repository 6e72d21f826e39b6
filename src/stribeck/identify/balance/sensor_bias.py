"""What the error of a measured motion does to the estimates, and estimates without it.

It does not average out: acceleration from a noisy or coarse position makes a mass too small, and
where the motion drives the states of a law, a path that is longer than the axis went wears bristles
out. So the same error is added once more, by chance, and what that moves the estimates by is
taken off them (simulation and extrapolation: Cook and Stefanski 1994, doi 10.2307/2290994; one
step of Gauss and Newton takes the place of a refit).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ...data.filtering import motion_noise
from ...friction.law import LOADS
from ...space import Array, Param
from ...units import unit
from ..conditions import Violation
from ..uncertainty.covariance import HALF_WIDTH
from ..uncertainty.verdict import IDENTIFIED
from . import variable_projection
from .balance import prediction
from .noisier_balance import DRAWS, SEED, error_of, noisier_logs
from .regression import accelerations

if TYPE_CHECKING:
    from ...data.filtering import Filtering
    from ...data.recording import Recording
    from ..uncertainty.estimates import Estimate
    from .balance import Balance
    from .noisier_balance import NoisierBalance, NoisierRows
    from .rows import Rows

#: Standard deviation of what the extrapolation leaves, as a share of what it takes off.
LEFT = 0.25
#: A move is told from this share of the half-width of an interval.
TOLD = 0.5
#: Moves of fewer standard errors than this, under a law without states, stay where they are.
MOVES = 0.1
#: From this share of a value on, one step of an extrapolation does not take a move off.
BEYOND = 0.25


@dataclass(frozen=True, eq=False)
class SensorBias:
    """What the error of the motion has moved the estimates by.

    Args:
        shift: Of all parameters, SI, (k,): what is to be taken off.
        error: Standard error of that, (k,).
    """

    shift: Array
    error: Array

    def without(self, solved: Balance) -> Balance:
        """A balance with parameters that the error of the motion has not moved."""
        values = solved.values - self.shift
        predicted = prediction(solved.system, values)
        return replace(
            solved,
            values=values,
            relative_error=predicted.relative_error,
            residual_sd=predicted.residual_sd,
            residuals=solved.system.y - solved.system.predicted(values[None])[:, 0],
        )

    def moved(self, estimates: Sequence[Estimate], every: Sequence[Param]) -> tuple[Estimate, ...]:
        """Estimates whose intervals are moved along, and widened by what is not known of it.

        Args:
            estimates: Of all parameters.
            every: Their declarations, in the same order.
        """
        return tuple(
            e if e.verdict == "fixed" else _moved(e, q, float(s), HALF_WIDTH * float(sd))
            for e, q, s, sd in zip(estimates, every, self.shift, self.error, strict=True)
        )

    def violations(self, solved: Balance, estimates: Sequence[Estimate]) -> list[Violation]:
        """What was taken off, a sentence, of the balance as it was solved."""
        parts, beyond = [], []
        for i, e in enumerate(estimates):
            half = 0.5 * (e.high - e.low)
            if e.verdict == "fixed" or not abs(self.shift[i]) > TOLD * half:
                continue
            if abs(self.shift[i]) > BEYOND * abs(solved.values[i]):
                beyond.append(solved.names[i])
            shown = unit(e.unit)
            was, now = (float(shown.from_si(x)) for x in (solved.values[i], e.value))
            parts.append(f"{e.name} from {was:.4g} to {now:.4g} {e.unit}".rstrip())
        if not parts:
            return []
        text = f"the error of the {_measured(solved)} is taken off: that moves {', '.join(parts)}"
        return [Violation("data", text, caps=False), *_beyond(solved, beyond)]


def _measured(solved: Balance) -> str:
    """The channel that the motion comes from."""
    return solved.system.filtering.velocity.replace("recorded", "recorded velocity")


def _beyond(solved: Balance, names: Sequence[str]) -> list[Violation]:
    """What moves too far to be taken off, and what shows it."""
    if not names:
        return []
    rig, measured = solved.system.rig, _measured(solved)
    remedy = f"record a finer {measured}, or faster motion"
    if solved.system.law.states:
        remedy = (
            "a law that is driven by such a motion is biased: rig "
            f"presliding{'-rotary' * rig.rotary} simulates it from the force instead"
        )
    text = (
        f"the error of the {measured} moves {' and '.join(map(rig.label, names))} by more than "
        f"{BEYOND:.0%}, which one step does not take off: {remedy}"
    )
    return [Violation("data", text, frozenset(names))]


def _moved(e: Estimate, q: Param, shift: float, further: float) -> Estimate:
    value = e.value - shift
    low = max(value - float(np.hypot(e.value - e.low, further)), q.lower)
    high = min(value + float(np.hypot(e.high - e.value, further)), q.upper)
    e = replace(e, value=value, low=low, high=high)
    if e.verdict == "identified" and max(value - low, high - value) > IDENTIFIED * abs(value):
        return replace(e, verdict="weak", reason="wide")
    return e


def sensor_bias(
    solved: Balance, recordings: Sequence[Recording], noisier: NoisierBalance
) -> SensorBias | None:
    """What the error of the motion has moved the estimates of a solved balance by.

    Args:
        solved: The balance.
        recordings: Its logs.
        noisier: The same with that error added once more.

    Returns:
        None under a law without states where it moves nothing by `MOVES` of a standard error.
    """
    static, free = not solved.system.law.states, solved.system.free
    least = MOVES * solved.robust_errors[free]
    if static and not np.any(_dilution(solved, recordings) * np.abs(solved.values[free]) > least):
        return None
    moves = np.array([_move(solved, drawn) for drawn in noisier()])
    if static and not np.any(np.abs(moves.mean(axis=0)) > least):
        return None
    shift = np.zeros(len(solved.values))
    error = np.zeros(len(solved.values))
    shift[free] = moves.mean(axis=0)
    error[free] = np.hypot(
        moves.std(axis=0, ddof=1) / np.sqrt(DRAWS), LEFT * np.abs(moves.mean(axis=0))
    )
    return _allowed(solved, shift, error)


def _dilution(solved: Balance, recordings: Sequence[Recording]) -> float:
    """The largest share of a log's squared velocities or accelerations that is noise.

    By it, at most, least squares makes the slopes over them too small (Fuller 1987, Measurement
    Error Models, section 1.1).
    """
    filtering, share = solved.system.filtering, 0.0
    for recording, log in zip(recordings, solved.system.logs, strict=True):
        noise = motion_noise(error_of(_source(recording, filtering)), log.rate, filtering)
        for sd, channel in ((noise.v, log.v), (noise.a, log.a)):
            square = float(np.mean(log.pick(channel) ** 2)) if len(log.places) else 0.0
            share = max(share, min(sd**2 / square, 1.0) if square else 0.0)
    return share


def acceleration_noise(
    solved: Balance, recordings: Sequence[Recording], rows: Sequence[Rows | None]
) -> float:
    """Standard deviation of what the motion's error makes of the acceleration, m/s^2 (rad/s^2).

    Args:
        solved: A balance.
        recordings: Its logs.
        rows: Which of their samples count.
    """
    logs = solved.system.logs
    noisier = noisier_logs(solved, recordings, rows, np.random.default_rng(SEED))
    return float(np.std(accelerations(noisier) - accelerations(logs)))


def mass_of(solved: Balance) -> float:
    """What a balance multiplies the acceleration by, kg (kg m^2)."""
    rig, law = solved.system.rig, solved.system.law
    columns = rig.columns_of(np.array([0.0, 1.0]), np.zeros((2, len(LOADS))))
    own = zip(rig.own(law), solved.values[len(law.params) :], strict=True)
    return sum(float(value * np.ptp(columns[q.name])) for q, value in own)


def _source(recording: Recording, filtering: Filtering) -> Array:
    """The channel that velocities come from."""
    if filtering.velocity == "recorded" and recording.velocity is not None:
        return recording.velocity
    return recording.position


def _move(solved: Balance, drawn: NoisierRows) -> Array:
    """By how much the free parameters move with the error added once more, (free,)."""
    J = drawn.jacobian
    seen = np.isfinite(np.diag(solved.covariance))
    move = np.zeros(J.shape[1])
    J = J if seen.all() else J[:, seen]
    move[seen] = variable_projection.least_squares(J, drawn.residual)
    return move


def _allowed(solved: Balance, shift: Array, error: Array) -> SensorBias:
    """As much of a shift as leaves the law physical and its parameters in their ranges."""
    parameters = solved.system.parameters
    value = parameters.clipped(solved.values - shift)
    value = np.where(np.isin(np.arange(len(value)), solved.system.free), value, solved.values)
    law = parameters.law
    if not np.all(law.physical(value[None, : len(law.params)])):
        return SensorBias(np.zeros_like(shift), np.hypot(error, np.abs(shift) / HALF_WIDTH))
    return SensorBias(solved.values - value, error)
