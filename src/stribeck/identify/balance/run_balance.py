"""Static friction of a table of steady speeds: mean force over mean speed, a row a run.

The balance is that of a log without acceleration, force = F_f(v) + offset, by weighted least
squares. A run counts by the error of its mean and by what runs scatter beside that (Paule and
Mandel 1982, doi 10.6028/jres.087.022); intervals are Student's, of the rows less the parameters.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from ...data.recording import Recording
from ...data.steady_runs import SteadyRuns
from ...errors import InputError
from ...space import Array
from ..adequacy.effects import OF_INTERVAL, OF_VALUE, Effect, Effects
from ..conditions import Violation
from ..data_split import DataSplit
from ..log_spread import log_spreads
from ..parameters import Parameters
from ..result import Fit
from ..uncertainty.assessment import uncertainty
from ..uncertainty.estimates import Estimate
from . import balance
from .balance import Balance
from .checks import SPEEDS, BalanceChecks, curved, distinct_speeds, unexplained
from .constant_slopes import constant_slopes
from .force_balance import SolvedLogs, fit_with_set_values, log_parts
from .force_residuals import BalanceResiduals
from .one_way import without_offset
from .regression import stacked

if TYPE_CHECKING:
    from collections.abc import Callable

    from ...data.zero_phase import Samples
    from .rows import Log

MASS = "M"
#: A curve that the law lacks is told if chance shows it less often than this, all shapes together.
CHANCE = 0.01
#: Degrees of freedom below which nothing can be said of such a curve.
FREEDOM = 4
#: Quantiles of the speeds below which friction may drop with speed.
_DROPS = (0.1, 0.25, 0.5)
#: Halvings of the interval that the scatter from run to run is searched in: to a hundredth.
_HALVINGS = 9
#: The scatter is told where it is so many times the errors that the table states.
_BEYOND = 2.0


def solve_runs(parameters: Parameters, data: DataSplit, *, draws: int = 0) -> Fit:
    """Identify a law from one or several tables of steady speeds.

    Args:
        parameters: Of a law on a rig with a measured force.
        data: The tables.
        draws: Data sets of a block bootstrap.

    Raises:
        InputError: too few rows, or parameters of which a table says nothing.
    """
    return fit_with_set_values(parameters, draws, lambda asked, drawn: _solved(asked, data, drawn))


def _solved(parameters: Parameters, data: DataSplit, draws: int) -> SolvedLogs:
    """The balance of `solve_runs` with all that its fit is judged by."""
    logs = data.recordings
    parameters = without_mass(parameters)
    if len({int(np.sign(v)) for log in logs for v in _speeds(log)} - {0}) == 1:
        parameters = without_offset(parameters)
    if not parameters.free:
        raise InputError(f"{logs[0].label}: no parameter is left to be found")
    recordings, scatter = weighted(parameters, logs)
    solved = balance.balance(recordings, parameters)
    residuals = BalanceResiduals(solved.system)
    x = solved.values[parameters.free_places]
    uncertain = uncertainty(residuals, x, keep=True, draws=draws)
    slopes = constant_slopes(solved, lambda p: balance.balance(recordings, p, start=solved.values))
    differing = log_spreads(
        parameters,
        log_parts(recordings, solved, x),
        solved.robust_errors[parameters.free_places],
    )
    violations = (
        *_at_constant_speed(parameters),
        *_scattered(parameters, logs, scatter),
        *_faults(solved),
    )
    return SolvedLogs(
        data,
        tuple(recordings),
        solved,
        residuals,
        uncertain,
        BalanceChecks(violations, solved.robust_errors),
        slopes,
        differing,
        lambda judged: curves(solved, judged),
    )


def without_mass(parameters: Parameters) -> Parameters:
    """The parameters with the mass held at 0: at constant speed nothing accelerates."""
    if MASS not in {q.name for q in parameters.free}:
        return parameters
    return replace(parameters.holding({MASS: 0.0}), held=parameters.held | {MASS})


def _at_constant_speed(parameters: Parameters) -> list[Violation]:
    """What holding the mass means, where it is held for that reason."""
    if MASS not in parameters.held:
        return []
    sentence = (
        f"at constant speed nothing accelerates: {parameters.rig.label(MASS)} is taken as 0, and "
        "the table says nothing of it"
    )
    return [Violation("data", sentence, caps=False)]


def _speeds(log: Recording) -> Array:
    return np.zeros(0) if log.velocity is None else log.velocity


def weighted(parameters: Parameters, logs: Sequence[Recording]) -> tuple[list[Recording], float]:
    """Tables whose errors hold what runs scatter beside them, and that scatter, N (N m).

    Paule and Mandel's: the scatter at which the weighted squares are their degrees of freedom.
    """
    if any(log.runs is None or log.runs.errors is None for log in logs):
        return [replace(log, runs=SteadyRuns()) for log in logs], 0.0

    def with_scatter(size: float) -> list[Recording]:
        return [
            replace(log, runs=SteadyRuns(np.hypot(log.runs.errors, size)))
            for log in logs
            if log.runs is not None and log.runs.errors is not None
        ]

    plain = balance.balance([replace(log, runs=SteadyRuns()) for log in logs], parameters)

    def excess(size: float) -> float:
        tables = with_scatter(size)
        solved = balance.balance(tables, parameters, start=plain.values)
        errors = np.concatenate([log.runs.errors for log in tables if log.runs is not None])
        weights = np.concatenate([log.gain for log in solved.system.logs])
        squares = float(np.sum((solved.residuals / weights / errors) ** 2))
        return squares - (len(errors) - len(solved.free))

    if excess(0.0) <= 0.0:
        return list(logs), 0.0
    low, high = 0.0, 4.0 * plain.residual_sd
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if excess(middle) > 0.0 else (low, middle)
    return with_scatter(high), high


def _scattered(
    parameters: Parameters, logs: Sequence[Recording], scatter: float
) -> list[Violation]:
    """What runs scatter beyond the errors that their table states."""
    stated = [log.runs.errors for log in logs if log.runs is not None]
    errors = [e for e in stated if e is not None]
    typical = float(np.median(np.concatenate(errors))) if errors else np.inf
    if not scatter > _BEYOND * typical:
        return []
    force = parameters.rig.si_unit("force")
    sentence = (
        f"the runs scatter by {scatter:.3g} {force} about the law, beyond the {typical:.2g} "
        f"{force} that the table states: they count by both"
    )
    return [Violation("data", sentence, caps=False)]


def _faults(solved: Balance) -> list[Violation]:
    """Speeds that are too few for a law, and a law that explains too little."""
    system = solved.system
    faults = []
    if sentence := unexplained(solved):
        faults.append(Violation("model", sentence, caps=solved.relative_error > balance.NOTHING))
    v = np.concatenate([log.pick(log.v) for log in system.logs])
    most = max(distinct_speeds(np.abs(v[sign * v > 0])) for sign in (1, -1))
    if curved(system) and most < SPEEDS:
        faults.append(
            Violation(
                "data",
                f"too few speeds for a Stribeck curve: the table has {most}, and it takes "
                f"{SPEEDS}: run at more speeds, some of them slow",
                caps=False,
            )
        )
    return faults


def _shaped(log: Log, shape: Callable[[Array], Array], at: Samples) -> Array:
    return shape(log.v[at])


def curves(solved: Balance, judged: Sequence[Estimate]) -> Effects:
    """The curve over speed that a law lacks, if chance does not explain it and it matters.

    Student's test of each shape beside the law, the least probability times their number.

    Args:
        solved: The balance.
        judged: Estimates of all parameters, in their order.
    """
    system = solved.system
    r, J = solved.residuals, solved.jacobian
    freedom = len(r) - J.shape[1] - 1
    if freedom < FREEDOM or not r @ r > 0:
        return Effects((), (), float("nan"))
    shapes = {
        name: stacked([log.thin(partial(_shaped, log, shape)) for log in system.logs])
        for name, shape in _shapes(np.concatenate([log.pick(log.v) for log in system.logs])).items()
    }
    tested = {key: _tested(J, r, column, freedom) for key, column in shapes.items()}
    key, (chance, moves, share) = min(tested.items(), key=lambda item: item[1][0])
    chance = min(1.0, chance * len(tested))
    if chance > CHANCE:
        return Effects((), (), float("nan"))
    shifts = {}
    for place, move in zip(system.free, moves, strict=True):
        e = judged[place]
        half = 0.5 * (e.high - e.low)
        if abs(move) > max(OF_INTERVAL * half, OF_VALUE * abs(solved.values[place])):
            shifts[solved.names[place]] = float(move)
    pattern, scale = key
    size = float(np.sqrt(share * np.mean(r**2)))
    effect = Effect("speed", "force", pattern, scale, share, chance, shifts, size=size)
    return Effects((), (effect,), float(np.sqrt(np.mean(r**2))))


def _shapes(v: Array) -> dict[tuple[str, float], Callable[[Array], Array]]:
    """Name and scale of curves over speed that a law may lack."""
    nan = float("nan")
    shapes: dict[tuple[str, float], Callable[[Array], Array]] = {
        ("square", nan): lambda w: w * np.abs(w),
    }
    if v.min() < 0 < v.max():
        shapes["side", nan] = np.abs
    for q in _DROPS:
        scale = float(np.quantile(np.abs(v[v != 0]), q))

        def drop(w: Array, scale: float = scale) -> Array:
            return np.sign(w) * np.exp(-np.abs(w) / scale)

        shapes["drop", scale] = drop
    return shapes


def _tested(J: Array, r: Array, column: Array, freedom: int) -> tuple[float, Array, float]:
    """Probability of a column beside those of J, what it moves their x by, its share of r²."""
    from scipy.special import stdtr  # noqa: PLC0415 - slow to import

    lengths = np.linalg.norm(J, axis=0)
    lengths[lengths == 0] = 1.0
    scaled = J / lengths
    along = np.linalg.lstsq(scaled, column, rcond=1e-9)[0]
    rest = column - scaled @ along
    if not rest @ rest > 1e-8 * (column @ column):
        return 1.0, np.zeros(J.shape[1]), 0.0
    size = float(rest @ r / (rest @ rest))
    share = size * float(rest @ r) / float(r @ r)
    left = max(float(r @ r) * (1.0 - share), np.finfo(float).tiny)
    t = abs(size) * np.sqrt(rest @ rest) / np.sqrt(left / freedom)
    return float(2.0 * stdtr(freedom, -t)), -size * along / lengths, share
