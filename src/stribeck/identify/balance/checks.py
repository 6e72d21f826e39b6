"""What a force balance rests on: faults of a log that least squares would not notice.

Each of these leaves the sum of squares at its minimum and the standard errors small, and the
estimates wrong: a force that lags the motion, spikes, gravity that no parameter stands for, a
force that was computed from the position, a balance that holds at one cut-off alone, speeds that
cannot tell one parameter from another. Each is looked for, and said in a sentence.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ...data.force_channel import EXACT, both_ways
from ...data.force_channel import spikes as single_samples
from ...errors import InputError
from ...friction import TERMS
from ...friction.law import POSITION
from ...space import Array
from ...units import unit
from ..uncertainty.verdict import IDENTIFIED
from . import balance, variable_projection
from .clustered_errors import block_errors

if TYPE_CHECKING:
    from ...data.recording import Recording
    from ..parameters import Parameters
    from ..uncertainty.estimates import Estimate
    from .regression import System
    from .rows import Log, Rows

#: Cut-offs at which a balance is solved again, as shares of its own.
SHARES = (0.7, 0.5, 1 / 3)
#: Delays that are tried, to each side, in periods of the cut-off, and how many.
_REACH, _TRIED = 1.0, 41
#: A delay is told if it takes this share off the residual's sum of squares, and is of more
#: samples than a controller that holds its output makes.
DELAY_GAIN, _HELD = 0.1, 1.25
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


@dataclass(frozen=True, eq=False)
class Doubts:
    """What was found.

    Args:
        said: A sentence each.
        errors: Standard errors for the intervals of all parameters, (k,): never below the robust
            ones, and wide enough for what strokes, logs and other cut-offs give.
        nothing: Whether the logs support nothing better than weak estimates.
    """

    said: tuple[str, ...]
    errors: Array
    nothing: bool

    def widened(
        self, parameters: Parameters, found: balance.Balance, estimates: Sequence[Estimate]
    ) -> tuple[Estimate, ...]:
        """The estimates with intervals that hold what was found here, and verdicts to match."""
        return tuple(self._widened(parameters, found, i, e) for i, e in enumerate(estimates))

    def _widened(
        self, parameters: Parameters, found: balance.Balance, i: int, e: Estimate
    ) -> Estimate:
        if e.verdict == "fixed":
            return e
        if e.verdict == "identified" and self.nothing:
            e = replace(e, verdict="weak")
        error, param = float(self.errors[i]), parameters.every[i]
        if not (np.isfinite(error) and error > found.robust_errors[i]):
            return e
        half = 1.96 * error
        low = max(min(e.low, e.value - half), param.lower)
        high = min(max(e.high, e.value + half), param.upper)
        if (low, high) == (e.low, e.high):
            return e
        sure = e.verdict == "identified" and half <= IDENTIFIED * abs(e.value)
        verdict = e.verdict if sure or e.verdict == "not identifiable" else "weak"
        meaning = f"{e.meaning}; the interval is wide enough for other strokes, logs and cut-offs"
        return replace(e, low=low, high=high, verdict=verdict, meaning=meaning.removeprefix("; "))


def doubts(
    recordings: Sequence[Recording], found: balance.Balance, rows: Sequence[Rows | None]
) -> Doubts:
    """Look for every fault in a solved balance.

    Args:
        recordings: The logs.
        found: Their balance.
        rows: Which samples counted, as for `balance`.
    """
    system = found.system
    commands = [line for log in recordings if (line := function_of_position(log))]
    at_cutoffs, errors = cutoffs(recordings, system, found, rows)
    of_logs, wide = block_errors(found)
    said = [
        *commands,
        *(hidden_load(log, system) for log in recordings),
        offset(system, found),
        delay(system, found),
        spikes(system, found),
        gravity(system, found),
        *speeds(system, found),
        of_logs,
        at_cutoffs,
    ]
    nothing = bool(commands) or found.relative_error > balance.NOTHING
    return Doubts(tuple(line for line in said if line), np.fmax(errors, wide), nothing)


def cutoffs(
    recordings: Sequence[Recording],
    system: System,
    found: balance.Balance,
    rows: Sequence[Rows | None],
) -> tuple[str, Array]:
    """The balance solved again at lower cut-offs: what leaves its interval, and errors that hold.

    A model that holds gives the same parameters whatever band they are read from.
    """
    errors = found.robust_errors.copy()
    rate = max(1.0 / log.dt for log in recordings)
    own = system.rig.filtering
    used = own.cutoff(rate)
    furthest = found.values.copy()
    tried = []
    for share in SHARES:
        longer = own.cutoff_hz / used / share
        lower = replace(
            own, cutoff_hz=share * used, edge=(own.edge[0] * longer, own.edge[1] * longer)
        )
        try:
            again = balance.balance(
                recordings, system.parameters, filtering=lower, rows=rows, near=found.values
            )
        except InputError:  # too few rows are left to tell
            break
        tried.append(share * used)
        # What lies within the other's own error says nothing against this one.
        off = np.abs(again.values - found.values) > _excess(found, again)
        further = np.abs(again.values - found.values) > np.abs(furthest - found.values)
        furthest = np.where(off & further, again.values, furthest)
    moved = [i for i in system.free if furthest[i] != found.values[i]]
    for i in moved:
        errors[i] = max(errors[i], abs(furthest[i] - found.values[i]) / 1.96)
    if not moved:
        return "", errors
    names = ", ".join(_moved(system, found, furthest, i) for i in moved)
    said = (
        f"the estimates depend on the cut-off: between {tried[-1]:.3g} and {used:.3g} Hz {names}; "
        "their intervals are widened to contain that"
    )
    return said, errors


def _excess(found: balance.Balance, again: balance.Balance) -> Array:
    """How far apart two balances of one log may be, 95 %: inf where one of them knows nothing."""
    apart = 1.96 * np.hypot(found.robust_errors, again.robust_errors)
    return np.where(np.isfinite(apart), apart, np.inf)


def _moved(system: System, found: balance.Balance, furthest: Array, i: int) -> str:
    rig, q = system.rig, system.parameters.every[i]
    shown = unit(rig.unit_of(q))
    one, other = (float(shown.from_si(x)) for x in (found.values[i], furthest[i]))
    return f"{rig.label(q.name)} goes from {other:.3g} to {one:.3g} {rig.unit_of(q)}"


def delay(system: System, found: balance.Balance) -> str:
    """A force that is ahead of the motion or behind it, if that explains the logs better."""
    rig = system.rig
    W = _basis(found)
    base = _unmoved(found)
    reach = _REACH / rig.filtering.cutoff(min(_rate(log) for log in system.logs))
    lags = np.linspace(-reach, reach, _TRIED)
    left = np.array([_left(W, system.at_lag(lag) - base) for lag in lags])
    best, now = int(np.argmin(left)), _left(W, system.y - base)
    if not 0 < best < _TRIED - 1 or left[best] > (1 - DELAY_GAIN) * now:
        return ""
    a, b, c = left[best - 1 : best + 2]
    lag = lags[best] + 0.5 * (lags[1] - lags[0]) * (a - c) / (a - 2 * b + c)
    if abs(lag) < _HELD / min(_rate(log) for log in system.logs):
        return ""
    word = "behind" if lag > 0 else "ahead of"
    alike = "; a contact that gives before it slips looks the same" if lag > 0 else ""
    rest = 100 * np.sqrt(left[best] / now)
    return (
        f"the force is {abs(lag) * 1e3:.3g} ms {word} the motion: moved by that, it leaves "
        f"{rest:.0f} % of the residual: align the channels in time{alike}"
    )


def _rate(log: Log) -> float:
    return float(len(log.v) - 1) / float(log.clock[-1] - log.clock[0])


def _basis(found: balance.Balance) -> Array:
    """Columns of one length that span what the parameters do that are free to."""
    W = found.jacobian[:, np.isfinite(np.diag(found.covariance))]
    return np.asarray(W / np.linalg.norm(W, axis=0))


def _unmoved(found: balance.Balance) -> Array:
    """What fixed and stopped parameters and the curve's shape make of the force, (rows,)."""
    system, variances = found.system, np.diag(found.covariance)
    p = found.values.copy()
    for k, i in enumerate(system.free):
        if i in system.linear and np.isfinite(variances[k]):
            p[i] = 0.0
    return found.system.predicted(p[None])[:, 0]


def _left(W: Array, y: Array) -> float:
    """Sum of squares of y about the span of W."""
    R = variable_projection.triangle(np.column_stack([W, y]))
    return float(R[-1, -1] ** 2)


def spikes(system: System, found: balance.Balance) -> str:
    """Single samples of the force far from both of their neighbours: least squares follows them."""
    rig, law = system.rig, system.law
    share = single_samples([log.raw for log in system.logs])
    if not share:
        return ""
    left = [log.raw - rig.force(law, found.values, log.v, log.a, log.loads) for log in system.logs]
    r = np.concatenate(left)
    r = np.abs(r - np.median(r))
    far = float(np.mean(r > 3 * _MAD * np.median(r)))
    return (
        f"the force has spikes: samples that stand away from both neighbours make {share:.0%} of "
        f"its variance, and {far:.1%} of the residuals are beyond three robust "
        "standard deviations: least squares follows them"
    )


def gravity(system: System, found: balance.Balance) -> str:
    """Torque that goes with the sine of the angle, on a rig that has no parameter for it."""
    rig = system.rig
    if not rig.rotary or "g_sin" in found.names:
        return ""
    W, r = _basis(found), found.residuals
    turn = [
        np.concatenate([log.thin(f(log.loads[:, POSITION])) for log in system.logs])
        for f in (np.sin, np.cos)
    ]
    now, then = _left(W, r), _left(np.column_stack([W, *turn]), r)
    if then > (1 - GRAVITY_GAIN) * now:
        return ""
    return (
        f"the torque goes with the sine of the angle: gravity would leave "
        f"{np.sqrt(then / now):.0%} of the residual: use rig forced-pendulum"
    )


def hidden_load(recording: Recording, system: System) -> str:
    """A recorded pressure that the rig leaves in the force."""
    rig = system.rig
    if recording.pressure is None or "normal" in rig.loads:
        return ""
    return (
        f"{recording.label}: the force holds that of the recorded pressure, which rig {rig.name} "
        "takes for offset or friction: use rig cylinder"
    )


def offset(system: System, found: balance.Balance) -> str:
    """A constant that is most of the force, so that a relative error of all of it looks small."""
    if "offset" not in found.names:
        return ""
    p = np.zeros(len(found.values))
    at = found.names.index("offset")
    p[at] = found.values[at]
    own = np.zeros(len(p))
    constant = (system.predicted(p[None]) - system.predicted(own[None]))[:, 0]
    beside = float(np.linalg.norm(system.y - constant))
    error = 100 * float(np.linalg.norm(found.residuals)) / beside if beside > 0 else 0.0
    if error < _BESIDE * found.relative_error or error < balance.UNEXPLAINED:
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
        f"{100 * share:.2g} %: it is a command that was computed from it, not a measurement, and "
        "says nothing of friction"
    )


def speeds(system: System, found: balance.Balance) -> list[str]:
    """Speeds that cannot tell F_V from F_C, or are too few for a curve."""
    free = {n.rstrip("+-") for n in found.free}
    v = np.concatenate([log.pick(log.v) for log in system.logs])
    ways = [np.abs(v[sign * v > 0]) for sign in (1, -1) if (sign * v > 0).sum() > _FEW]
    said = []
    narrow = bool(ways) and all(np.quantile(w, 0.9) < ONE_SPEED * np.quantile(w, 0.1) for w in ways)
    if narrow and {"F_C", "F_V"} <= free:
        shown = unit(system.rig.shows.get("velocity", "m/s"))
        low, high = (float(shown.from_si(np.quantile(np.abs(v), q))) for q in (0.1, 0.9))
        said.append(
            f"the speeds are too narrow to tell F_V from F_C ({low:.3g} to {high:.3g} "
            f"{shown.written}): hold one, as with --set F_V=0"
        )
    if _curved(system) and (n := max((_distinct(w) for w in ways), default=0)) < SPEEDS:
        said.append(
            f"too few speeds for a Stribeck curve: the log dwells at {n}, and it takes {SPEEDS}: "
            "record strokes at more speeds, some of them slow"
        )
    return said


def _curved(system: System) -> bool:
    """Whether a parameter that shapes the law's curve over speed is to be found."""
    of_terms = {q.name for parameters in TERMS.values() for q in parameters}
    return any(system.parameters.every[i].name not in of_terms for i in system.shape)


def _distinct(speed: Array) -> int:
    """How many speeds, a fifth apart, have a fair share of the samples."""
    if not len(speed):
        return 0
    steps = np.floor(np.log(speed / speed.max()) / np.log(_APART))
    _, often = np.unique(steps, return_counts=True)
    return int(np.count_nonzero(often >= _SHARE * len(speed)))
