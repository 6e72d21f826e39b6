"""Checks of a force balance: faults of a log that least squares does not show.

Each of these leaves the sum of squares at its minimum and the standard errors small, and the
estimates wrong: spikes, gravity that no parameter stands for, a
force that was computed from the position, a balance that holds at one cut-off alone, speeds that
cannot tell one parameter from another. Each is looked for, and said in a sentence.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from ...data.force_channel import EXACT, both_ways
from ...data.force_channel import spikes as single_samples
from ...data.zero_phase import BLOCK, Samples
from ...errors import InputError
from ...space import Array
from ...units import percent, unit
from ...wording import option
from ..conditions import Condition, Violation
from ..data_check import data_violations
from ..uncertainty.covariance import HALF_WIDTH
from ..uncertainty.verdict import IDENTIFIED
from . import balance, variable_projection
from .balance import NOTHING
from .clustered_errors import clustered_errors
from .constant_pressure import constant_pressure
from .curve_prior import chord_errors
from .cut_off_voltage import cut_off_voltage
from .modelled_force import force_signal
from .path_error import path_shifts
from .presliding_shown import stiffness_unseen
from .regression import System, stacked

if TYPE_CHECKING:
    from ...data.recording import Recording
    from ..log_spread import LogSpreads
    from ..parameters import Parameters
    from ..uncertainty.estimates import Estimate
    from .rows import Log, Rows
    from .sensor_bias import SensorBias
    from .synchronisation import Synchronised

#: Cut-offs at which a balance is solved again, as shares of its own; and those under a law with
#: states, whose loops have corners that lower ones round.
SHARES, SHARES_STATES = (0.7, 0.5, 1 / 3), (0.7,)
#: Gravity is told to be missing if sine and cosine of the angle take this share off it.
GRAVITY_GAIN = 0.4
#: Speeds of a direction within this ratio, tenth to ninetieth percentile, are one speed.
ONE_SPEED = 1.7
#: Speeds are apart by a fifth, and count where this share of the rows has them; a Stribeck curve
#: of three levels and a speed takes at least so many.
_APART, _SHARE, SPEEDS = 1.2, 0.02, 5
#: An offset is told to flatter the error if without it the error is so many times as large.
_BESIDE = 2.0
#: Rows that make a direction.
_FEW = 10
#: A factor for residuals of a normal distribution: median deviation to standard deviation.
_MAD = 1.4826
#: A relative error above this, percent, is told: the models of the EMPS report leave 3 to 6.
UNEXPLAINED = 25.0


@dataclass(frozen=True, eq=False)
class BalanceChecks:
    """The faults that the checks of a force balance show, and errors that allow for them.

    Args:
        violations: The faults.
        errors: Standard errors for the intervals of all parameters, (k,): never below the robust
            ones, and wide enough for what strokes, logs and other cut-offs give, straight
            lines for a curve, and samples of a motion that drives states.
    """

    violations: tuple[Violation, ...]
    errors: Array

    def widened(
        self, parameters: Parameters, solution: balance.Balance, estimates: Sequence[Estimate]
    ) -> tuple[Estimate, ...]:
        """The estimates with intervals that hold what was found here, and verdicts to match."""
        return tuple(self._widened(parameters, solution, i, e) for i, e in enumerate(estimates))

    def _widened(
        self, parameters: Parameters, solution: balance.Balance, i: int, e: Estimate
    ) -> Estimate:
        if e.verdict == "fixed":
            return e
        error, param = float(self.errors[i]), parameters.every[i]
        if not (np.isfinite(error) and error > solution.robust_errors[i]):
            return e
        half = HALF_WIDTH * error
        low = max(min(e.low, e.value - half), param.lower)
        high = min(max(e.high, e.value + half), param.upper)
        if (low, high) == (e.low, e.high):
            return e
        sure = e.verdict == "identified" and half <= IDENTIFIED * abs(e.value)
        if e.verdict == "identified" and not sure:
            e = replace(e, verdict="weak", reason="wide")
        meaning = f"{e.meaning}; the interval is wide enough for other strokes, logs and cut-offs"
        return replace(e, low=low, high=high, meaning=meaning.removeprefix("; "))


def check_balance(
    synchrony: Synchronised, differing: LogSpreads, bias: SensorBias | None
) -> BalanceChecks:
    """Look for every fault in a solved balance, and in the timing of its channels.

    Args:
        synchrony: The balance with its logs.
        differing: What its logs give one by one.
        bias: What the error of the motion has moved it by.
    """
    recordings, solution = synchrony.recordings, synchrony.solved
    system = solution.system
    at_cutoffs, errors = cutoffs(recordings, solution, synchrony.rows, bias)
    of_logs, clustered = clustered_errors(solution, differing.known_alone)
    errors = np.hypot(np.fmax(errors, clustered), chord_errors(system, solution.values))
    errors += np.abs(path_shifts(solution)) / HALF_WIDTH
    widened = synchrony.widened(errors)
    faults: list[tuple[Condition, str, bool]] = [
        *(("data", function_of_position(log), True) for log in recordings),
        *(("model", hidden_load(log, system), True) for log in recordings),
        ("model", unexplained(solution), solution.relative_error > NOTHING),
        ("model", offset(system, solution), False),
        ("data", spikes(system, solution), False),
        ("model", gravity(system, solution), True),
        *(("data", sentence, False) for sentence in speeds(system, solution, widened)),
        ("data", of_logs, False),
        ("model", at_cutoffs, False),
    ]
    violations = [Violation(c, sentence, caps=caps) for c, sentence, caps in faults if sentence]
    if system.law.states:
        violations += stiffness_unseen(system)
    violations += constant_pressure(solution, recordings, synchrony.rows)
    gate = data_violations(system.rig, recordings, synchrony.rows)
    cut_off = cut_off_voltage(solution, recordings, synchrony.rows)
    gate += [Violation("data", sentence) for sentence in cut_off]
    return BalanceChecks((*gate, *synchrony.violations(), *violations), widened)


def unexplained(solution: balance.Balance) -> str:
    """A share of the force that the model leaves, far above what such models leave."""
    error = solution.relative_error
    if not error > UNEXPLAINED:
        return ""
    lost = ": the log supports nothing better than weak estimates" if error > NOTHING else ""
    return f"{error:.0f} % of the force is not explained by this model{lost}"


def cutoffs(
    recordings: Sequence[Recording],
    solution: balance.Balance,
    rows: Sequence[Rows | None],
    bias: SensorBias | None,
) -> tuple[str, Array]:
    """The balance solved again at lower cut-offs: what leaves its interval, and errors that hold.

    A model that holds gives the same parameters whatever band they are read from, but for what the
    error of the motion moves them by in a wider one.
    """
    system, errors = solution.system, solution.robust_errors.copy()
    rate = max(1.0 / log.dt for log in recordings)
    filtering = system.filtering
    if filtering.passes(rate):
        return "", errors
    used = filtering.cutoff(rate)
    values, further_error = solution.values, np.zeros(len(errors))
    if bias is not None:
        values, further_error = values - bias.shift, bias.error
    furthest = values.copy()
    frequencies = []
    for share in SHARES_STATES if system.law.states else SHARES:
        lower = filtering.lowered(share, rate)
        try:
            resolved = balance.balance(
                recordings, system.parameters, filtering=lower, rows=rows, start=solution.values
            )
        except InputError:  # too few rows are left to tell
            break
        frequencies.append(share * used)
        # What lies within the other's own error says nothing against this one.
        tolerance = _tolerance(np.hypot(solution.robust_errors, further_error), resolved)
        off = np.abs(resolved.values - values) > tolerance
        further = np.abs(resolved.values - values) > np.abs(furthest - values)
        furthest = np.where(off & further, resolved.values, furthest)
        del resolved  # before the next is made
    moved = [i for i in system.free if furthest[i] != values[i]]
    for i in moved:
        errors[i] = max(errors[i], abs(furthest[i] - values[i]) / HALF_WIDTH)
    if not moved:
        return "", errors
    names = ", ".join(_moved(system, values, furthest, i) for i in moved)
    sentence = (
        f"the estimates depend on the cut-off: between {frequencies[-1]:.3g} and {used:.3g} Hz "
        f"{names}; their intervals are widened to contain that"
    )
    return sentence, errors


def _tolerance(errors: Array, resolved: balance.Balance) -> Array:
    """How far apart two balances of one log may be, 95 %: inf where one of them knows nothing."""
    tolerance = HALF_WIDTH * np.hypot(errors, resolved.robust_errors)
    return np.where(np.isfinite(tolerance), tolerance, np.inf)


def _moved(system: System, values: Array, furthest: Array, i: int) -> str:
    rig, q = system.rig, system.parameters.every[i]
    shown = unit(rig.unit_of(q))
    at_cutoff, elsewhere = (float(shown.from_si(x)) for x in (values[i], furthest[i]))
    return f"{rig.label(q.name)} goes from {elsewhere:.3g} to {at_cutoff:.3g} {rig.unit_of(q)}"


def _basis(solution: balance.Balance) -> Array:
    """Columns of one length that span what the parameters do that are free to."""
    W = solution.jacobian[:, np.isfinite(np.diag(solution.covariance))]
    return np.asarray(W / np.linalg.norm(W, axis=0))


def _sum_of_squares_about(W: Array, y: Array) -> float:
    """Sum of squares of y about the span of W."""
    R = variable_projection.triangle(np.column_stack([W, y]))
    return float(R[-1, -1] ** 2)


def spikes(system: System, solution: balance.Balance) -> str:
    """Single samples of the force far from both of their neighbours: least squares follows them."""
    rig, law = system.rig, system.law
    share = single_samples([log.raw for log in system.logs])
    if not share:
        return ""
    blocks = [
        (log, modelled, slice(k, min(k + BLOCK, len(log))))
        for log in system.logs
        for modelled in (force_signal(rig, law, log, solution.values),)
        for k in range(0, len(log), BLOCK)
    ]
    r = np.concatenate([
        log.raw[at] - log.known_at(at) - modelled(at)
        for log, modelled, at in blocks
    ])  # fmt: skip
    r = np.abs(r - np.median(r))
    outliers = float(np.mean(r > 3 * _MAD * np.median(r)))
    return (
        f"the force has spikes: samples that stand away from both neighbours make {share:.0%} of "
        f"its variance, and {outliers:.1%} of the residuals are beyond three robust "
        "standard deviations: least squares follows them"
    )


def gravity(system: System, solution: balance.Balance) -> str:
    """Torque that goes with the sine of the angle, on a rig that has no parameter for it."""
    rig = system.rig
    if not rig.rotary or "g_sin" in solution.names:
        return ""
    W, r = _basis(solution), solution.residuals
    turn = [
        stacked([log.thin(partial(_of_position, log, f)) for log in system.logs])
        for f in (np.sin, np.cos)
    ]
    without, with_gravity = (
        _sum_of_squares_about(W, r),
        _sum_of_squares_about(np.column_stack([W, *turn]), r),
    )
    if with_gravity > (1 - GRAVITY_GAIN) * without:
        return ""
    return (
        f"the torque goes with the sine of the angle: gravity would leave "
        f"{np.sqrt(with_gravity / without):.0%} of the residual: use rig forced-pendulum"
    )


def _of_position(log: Log, f: Callable[[Array], Array], at: Samples) -> Array:
    return f(log.position[at])


def hidden_load(recording: Recording, system: System) -> str:
    """A recorded pressure that the rig leaves in the force."""
    rig = system.rig
    if recording.pressure is None or "normal" in rig.loads:
        return ""
    return (
        f"{recording.label}: the force holds that of the recorded pressure, which rig {rig.name} "
        "takes for offset or friction: use rig cylinder"
    )


def offset(system: System, solution: balance.Balance) -> str:
    """A constant that is most of the force, so that a relative error of all of it looks small."""
    if "offset" not in solution.names:
        return ""
    without = solution.values.copy()
    without[solution.names.index("offset")] = 0.0
    constant = (system.predicted(solution.values[None]) - system.predicted(without[None]))[:, 0]
    varying = float(np.linalg.norm(system.y - constant))
    error = 100 * float(np.linalg.norm(solution.residuals)) / varying if varying > 0 else 0.0
    if error < _BESIDE * solution.relative_error or error < UNEXPLAINED:
        return ""
    return (
        f"most of the force is the constant offset: of what is beside it, {error:.0f} % is not "
        "explained"
    )


def function_of_position(recording: Recording) -> str:
    """A force that is the same both ways at every position, as no friction leaves it."""
    if recording.force is None:
        return ""
    share = both_ways(recording.t, recording.position, recording.force)
    if share is None or share > EXACT:
        return ""
    return (
        f"{recording.label}: the force is a function of the position, the same both ways to "
        f"{percent(share)}: it is a command that was computed from it, not a measurement, and "
        "says nothing of friction"
    )


def speeds(system: System, solution: balance.Balance, errors: Array) -> list[str]:
    """Speeds that do not tell F_V from F_C, or are too few for a curve.

    Args:
        system: The logs and the model.
        solution: Their balance.
        errors: Standard errors for the intervals of all parameters, (k,).
    """
    free = {n.rstrip("+-") for n in solution.free}
    v = np.concatenate([log.pick(log.v) for log in system.logs])
    by_direction = [np.abs(v[sign * v > 0]) for sign in (1, -1) if (sign * v > 0).sum() > _FEW]
    sentences = []
    narrow = bool(by_direction) and all(
        np.quantile(w, 0.9) < ONE_SPEED * np.quantile(w, 0.1) for w in by_direction
    )
    if narrow and {"F_C", "F_V"} <= free and not _told_apart(solution, errors, np.abs(v)):
        shown = unit(system.rig.shows.get("velocity", "m/s"))
        low, high = (float(shown.from_si(np.quantile(np.abs(v), q))) for q in (0.1, 0.9))
        sentences.append(
            f"the speeds are too narrow to tell F_V from F_C ({low:.3g} to {high:.3g} "
            f"{shown.written}): log other speeds, too, or hold the one that is known "
            f"({option('fixed', {'F_V': 0})} where nothing is viscous)"
        )
    if (
        curved(system)
        and (n := max((distinct_speeds(w) for w in by_direction), default=0)) < SPEEDS
    ):
        sentences.append(
            f"too few speeds for a Stribeck curve: the log dwells at {n}, and it takes {SPEEDS}: "
            "record strokes at more speeds, some of them slow"
        )
    return sentences


def _told_apart(solution: balance.Balance, errors: Array, speed: Array) -> bool:
    """Whether each of F_C and F_V v is known to a tenth of both, whatever the speeds are."""
    usual, level, halves = float(np.median(speed)), 0.0, list[float]()
    for name, at in (("F_C", 1.0), ("F_V", usual)):
        places = [i for i in solution.system.free if solution.names[i].rstrip("+-") == name]
        level += at * float(np.abs(solution.values[places]).min())
        halves += (at * HALF_WIDTH * errors[places]).tolist()
    return bool(np.all(np.array(halves) <= IDENTIFIED * level))


def curved(system: System) -> bool:
    """Whether a parameter that shapes the law's curve over speed is to be found."""
    own = len(system.law.params) - sum(system.law.sizes)
    speeds = {"m/s", "rad/s"}
    shaped = [i for i in system.shape if i < own]
    return any(not system.law.states or system.parameters.every[i].unit in speeds for i in shaped)


def distinct_speeds(speed: Array) -> int:
    """How many speeds, a fifth apart, have a fair share of the samples."""
    if not len(speed):
        return 0
    steps = np.floor(np.log(speed / speed.max()) / np.log(_APART))
    _, often = np.unique(steps, return_counts=True)
    return int(np.count_nonzero(often >= _SHARE * len(speed)))
