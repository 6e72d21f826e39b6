"""Weights that logs of a pendulum state, against the gravity that their force balance shows.

From log to log the gravity of an arm changes by that of the weight on it alone. What the force
(the current) changes by is therefore the scale of the drive, whatever the arm itself weighs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...data.recording import Recording
from ...space import Array
from ..conditions import Violation
from ..log_spread import LogSpreads
from ..parameters import Parameters

#: Standard gravity, m/s^2.
G = 9.80665
#: The parameter of gravity, and columns in which a log states its weight, kg, and the arm, m.
_GRAVITY, _MASS, _ARM = "g_sin", "mass", "length"
#: A line through fewer logs has no error.
_FEWEST = 3
#: A scale is told if it is off by this share, and beyond its interval.
OFF = 0.1


@dataclass(frozen=True)
class LoadScale:
    """Torque of the known loads for one unit of the fit's torque.

    Args:
        value: N m for one N m of the fit, or for one ampere where friction stays a current.
        low: Lower end of its 95 % interval.
        high: Upper end.
        logs: How many logs it rests on.
    """

    value: float
    low: float
    high: float
    logs: int

    @property
    def tolerance(self) -> float:
        """Twice its standard deviation, as a constant states it."""
        return (self.high - self.low) / 2


def stated_loads(recordings: Sequence[Recording]) -> Array:
    """Torque of gravity on the weights that logs state, N m, (logs,); nan where one states none."""
    loads = np.full(len(recordings), np.nan)
    for k, log in enumerate(recordings):
        mass, arm = log.extra.get(_MASS), log.extra.get(_ARM)
        if mass is not None and arm is not None and not (np.ptp(mass) or np.ptp(arm)):
            loads[k] = mass[0] * arm[0] * G
    return loads


def load_scale(differing: LogSpreads, loads: Array) -> LoadScale | None:
    """The scale that known loads give; None where too few logs know gravity, or loads are alike.

    Weighted least squares of gravity over load, the errors enlarged where the logs scatter more.

    Args:
        differing: What the logs give one by one.
        loads: The torque of gravity on what was put on, N m, (logs,); nan where not known.
    """
    spread = next((s for s in differing.spreads if s.parameter == _GRAVITY), None)
    if spread is None or len(spread.values) != len(loads):
        return None
    known = np.isfinite(spread.values) & np.isfinite(loads) & (spread.errors > 0)
    if known.sum() < _FEWEST or not np.ptp(loads[known]) > 0:
        return None
    from scipy.stats import t as student  # noqa: PLC0415 - slow to import

    weight = 1 / spread.errors[known]
    W = np.column_stack([np.ones(known.sum()), loads[known]]) * weight[:, None]
    y = spread.values[known] * weight
    line, *_ = np.linalg.lstsq(W, y, rcond=None)
    freedom = int(known.sum()) - 2
    excess = max(float(np.sum((y - W @ line) ** 2)) / freedom, 1.0)
    error = float(np.sqrt(excess * np.linalg.inv(W.T @ W)[1, 1]))
    half, slope = float(student.ppf(0.975, freedom)) * error, float(line[1])
    if not slope > half:  # the loads do not show
        return None
    return LoadScale(1 / slope, 1 / (slope + half), 1 / (slope - half), int(known.sum()))


def load_notes(
    parameters: Parameters, recordings: Sequence[Recording], differing: LogSpreads
) -> tuple[list[Violation], list[str]]:
    """What the weights that logs state say of the scale of the forces: what is wrong, and a note.

    Args:
        parameters: Rig, law and what is free.
        recordings: The logs.
        differing: What they give one by one.
    """
    scale = load_scale(differing, stated_loads(recordings))
    if scale is None:
        return [], []
    rig, chain = parameters.rig, parameters.rig.chain
    ends = f"{scale.value:.4g} ({scale.low:.4g} to {scale.high:.4g})"
    if rig.in_amperes and chain is not None:
        kt = scale.value * chain.travel
        stated = f"{kt:.4g} ± {scale.tolerance * chain.travel:.2g} N m/{chain.size}"
        source = f"(identified from {scale.logs} logs with known loads)"
        return [], [f'the loads that the logs state ask for kt = "{stated} {source}"']
    off = not scale.low <= 1 <= scale.high and abs(scale.value - 1) > OFF
    sentence = (
        f"the loads that {scale.logs} logs state pull with {ends} N m for each N m of the measured "
        "torque"
    )
    if not off:
        return [], [sentence]
    advice = "look for a gear or a torque constant that was left out or applied twice"
    return [Violation("constants", f"{sentence}: {advice}")], []
