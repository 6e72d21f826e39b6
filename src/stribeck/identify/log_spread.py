"""How parameters differ from log to log, for fits of several logs by either method.

Each log is fitted by itself from the common answer, with what no log knows better than another
(constants of the rig) as it is there. What these fits give differs by their errors, and by what
the axis does differently from one log to the next: temperature, lubrication, load. The latter is a
random effect (`random_effects`). Where it is there, a parameter is the mean of an axis that varies,
and its interval is that of few logs, whatever the number of their samples.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ..errors import InputError
from ..optimize.lockstep import AskTell, Counted, lockstep
from ..optimize.trust_region import Iterate, minimise
from ..rig.rig import shown_difference
from ..space import Array, Param
from .conditions import Violation
from .random_effects import RandomEffects, random_effects
from .uncertainty.covariance import first_below_zero, quick_look
from .uncertainty.estimates import Estimate
from .uncertainty.linearisation import box_of, linearised
from .uncertainty.residuals import Residuals, logs_of, orders_of
from .uncertainty.verdict import IDENTIFIED

if TYPE_CHECKING:
    from ..data.recording import Recording
    from .parameters import Parameters

#: Logs are told to differ in a parameter if chance shows such differences less often than this.
CHANCE = 1e-3
#: A standard deviation from log to log below this share of the mean matters to nobody.
MATERIAL = 0.01
#: A common misfit above this many times that of the logs by themselves is no chance: a parameter
#: for each log takes a thousandth off the noise of a thousand samples.
APART = 1.5
#: Evaluations of the fit of a single log for each parameter and one, and the share of its sum of
#: squares that is not worth a step.
ROWS, GAIN = 12, 1e-6
#: A log starts anew from the answer of another one that leaves less than this share of its own sum
#: of squares; so many others are tried.
BETTER, OTHERS = 0.99, 8
#: Single logs know a parameter by themselves if they have this share of what all have together:
#: what only a comparison of logs tells (a slope over their pressures) has a fiftieth or less.
ALONE = 0.1
#: Least degrees of freedom of an error, and least error as a share of the value (of the range: what
#: is as near to an end of it has stopped there).
_FEW, _EXACT = 2.0, 1e-9


@dataclass(frozen=True, eq=False)
class LogPart:
    """One log of a fit: the problem that it is by itself, and the common answer in it.

    Args:
        log: The log.
        problem: Its residuals; the free parameters come first, what is its own follows.
        x: The answer, SI, (dim,).
        starts: Where else its fit may start, SI, (dim,) each.
    """

    log: Recording
    problem: Residuals
    x: Array
    starts: tuple[Array, ...] = ()


@dataclass(frozen=True, eq=False)
class LogSpread:
    """How a parameter differs from log to log, SI.

    Args:
        parameter: Its name.
        effects: Mean, and spread from log to log, of the logs that know it.
        values: Of each log by itself, nan where that does not know it, (logs,).
        errors: Standard errors of these.
        share: Of what all logs together know of it, what they know one by one.
    """

    parameter: str
    effects: RandomEffects
    values: Array
    errors: Array
    share: float

    @property
    def alone(self) -> bool:
        """Whether logs know it by themselves: else they cannot be seen to differ in it."""
        return ALONE < self.share < np.inf

    @property
    def material(self) -> bool:
        """Whether the logs certainly differ, and by more than what does not matter."""
        e = self.effects
        return self.alone and e.chance < CHANCE and e.sd > MATERIAL * abs(e.mean)


@dataclass(frozen=True, eq=False)
class LogSpreads:
    """What the logs of a fit give one by one.

    Args:
        logs: Their labels.
        spreads: Of each free parameter that two logs or more know by themselves.
        misfit: Root mean square of the residuals under the common answer, over that of the logs
            by themselves.
        rows: Rows evaluated, each of all logs.
    """

    logs: tuple[str, ...] = ()
    spreads: tuple[LogSpread, ...] = ()
    misfit: float = 1.0
    rows: int = 0

    @property
    def material(self) -> tuple[LogSpread, ...]:
        """Of the parameters in which the logs differ."""
        return tuple(s for s in self.spreads if s.material)

    @property
    def apart(self) -> bool:
        """Whether no common answer is near those of the logs, whatever it is that differs."""
        return self.misfit > APART

    @property
    def known_alone(self) -> frozenset[str]:
        """The parameters that logs by themselves know about as well as all of them together."""
        return frozenset(s.parameter for s in self.spreads if s.alone)


def log_spreads(parameters: Parameters, parts: Sequence[LogPart], together: Array) -> LogSpreads:
    """What each log gives by itself, and how that differs.

    Args:
        parameters: The free ones come first in each part.
        parts: The logs.
        together: Standard errors of the free parameters by all logs, SI, (free,).
    """
    if len(parts) < 2:  # noqa: PLR2004 - one log is no sample of logs
        return LogSpreads()
    refits, misfit, rows = _refitted(parts, len(parameters.free))
    nothing = (np.full(len(parameters.free), np.nan), np.full(len(parameters.free), np.inf), _FEW)
    known = [
        nothing if refit is None else _known(part, refit, parameters)
        for part, refit in zip(parts, refits, strict=True)
    ]
    values, errors, dofs = (np.array(column) for column in zip(*known, strict=True))
    spreads = []
    for i, q in enumerate(parameters.free):
        knows = np.isfinite(errors[:, i])
        if np.count_nonzero(knows) < 2:  # noqa: PLR2004 - as above
            continue
        effects = random_effects(values[knows, i], errors[knows, i], dofs[knows])
        value, error = (np.where(knows, column[:, i], np.nan) for column in (values, errors))
        share = float(together[i] ** 2 * np.sum(errors[knows, i] ** -2.0))
        spreads.append(LogSpread(q.name, effects, value, error, share))
    labels = tuple(part.log.label for part in parts)
    return LogSpreads(labels, tuple(spreads), misfit, rows)


def _refitted(parts: Sequence[LogPart], free: int) -> tuple[list[Iterate | None], float, int]:
    """Each log fitted by itself, None where it cannot be; and what that cost.

    With the misfit together over that of these fits, and how many rows of all logs were evaluated.
    """
    counted = [Counted(p.problem, 4 * ROWS * (len(p.x) + 1)) for p in parts]
    refits = [_refit(c, p, p.x) for c, p in zip(counted, parts, strict=True)]
    answers = [
        (k, box_of(p.problem).x(r.u)[:free])
        for k, (p, r) in enumerate(zip(parts, refits, strict=True))
        if r is not None
    ]
    for k, (c, part) in enumerate(zip(counted, parts, strict=True)):
        others, own = [a for j, a in answers if j != k], refits[k]
        if own is None or not others:
            continue
        own_starts = part.starts[0] if part.starts else part.x
        tried = [
            np.concatenate([a, own_starts[free:]]) for a in others[:: -(-len(others) // OTHERS)]
        ]
        starts = np.array([*part.starts, *tried])
        squares = np.square(c.residuals(starts)).sum(axis=1)
        best = int(np.argmin(np.where(np.isfinite(squares), squares, np.inf)))
        if squares[best] < BETTER * own.squares:
            again = _refit(c, part, starts[best])
            refits[k] = own if again is None or again.squares > own.squares else again
    fitted = [(c.visited[0][1], r.squares) for c, r in zip(counted, refits, strict=True) if r]
    together, alone = np.sum(fitted, axis=0) if fitted else (1.0, 1.0)
    misfit = float(np.sqrt(together / alone)) if alone > 0 else 1.0
    return refits, misfit, round(sum(c.rows for c in counted) / len(parts))


def _refit(counted: Counted, part: LogPart, x: Array) -> Iterate | None:
    """The fit of a log by itself from a start, with slopes; None if it has too few rows for it."""
    box = box_of(part.problem)
    try:
        start = linearised(counted, box, x)
    except InputError:
        return None
    moves = minimise(start, box, tolerance=GAIN, rows=ROWS * (box.dim + 1))
    (end,) = lockstep(counted, [AskTell("log", box.space, moves)])
    if end is None or end[0].age == 0:
        return start if end is None else end[0]
    return linearised(counted, box, box.x(end[0].u))


def _known(part: LogPart, refit: Iterate, parameters: Parameters) -> tuple[Array, Array, float]:
    """Values of the free parameters, their errors (inf where unknown), and how many these rest on.

    What ends at an end of its range, or rests on another parameter, is not known.
    """
    box, free = box_of(part.problem), len(parameters.free)
    logs = logs_of(part.problem, len(refit.r))
    look = quick_look(refit.J, refit.r, logs)
    x = box.x(refit.u)
    stopped = ~((refit.u > _EXACT) & (refit.u < 1 - _EXACT))[:free]
    for i, j in orders_of(part.problem):
        stopped[i] |= x[i] - x[j] <= _EXACT * abs(x[i])
    errors = (look.errors * box.scale(refit.u))[:free]
    errors = np.fmax(errors, _EXACT * np.abs(x[:free]))
    errors[stopped | (errors == 0.0)] = np.inf
    rows = sum(logs)
    blocks = rows / (2.0 * first_below_zero(refit.r[:rows], logs))
    return x[:free], errors, max(blocks, _FEW)


def spread_over_logs(
    parameters: Parameters, estimates: Sequence[Estimate], differing: LogSpreads
) -> tuple[tuple[Estimate, ...], list[Violation]]:
    """Estimates whose intervals hold the means over logs that differ, and what is told of them.

    Args:
        parameters: Theirs.
        estimates: As in `parameters.every`.
        differing: What the logs give one by one.
    """
    material = {s.parameter for s in differing.material}
    apart = differing.apart
    spreads = {s.parameter: s for s in differing.spreads if s.material or (apart and s.alone)}
    result = list(estimates)
    texts = []
    for k, (q, e) in enumerate(zip(parameters.every, estimates, strict=True)):
        s = spreads.get(parameters.tied.get(q.name, q.name))
        if s is None or e.verdict == "fixed":
            continue
        result[k] = _widened(e, s.effects, q.lower, q.upper)
        if s.parameter in material:
            texts.append(_text(parameters, q, e, s.effects))
    if not spreads:
        return tuple(result), []
    what = (
        f"standard deviation from log to log: {', '.join(texts)}"
        if texts
        else f"the misfit of all is {differing.misfit:.2g} times that of each by itself, and no "
        "parameter that differs for certain is seen"
    )
    sentence = (
        f"the {len(differing.logs)} logs differ beyond their noise, {what}: the intervals of these "
        "are of the mean of an axis that varies, with each log as one observation; fit a log alone "
        "for what it had"
    )
    return tuple(result), [Violation("model", sentence, frozenset(spreads), caps=False)]


def _text(parameters: Parameters, q: Param, e: Estimate, effects: RandomEffects) -> str:
    sd, low, high = (
        float(shown_difference(parameters.rig, q, x))
        for x in (effects.sd, effects.sd_low, effects.sd_high)
    )
    return f"{e.name} {sd:.2g} {e.unit}".rstrip() + f" ({low:.2g} to {high:.2g})"


def _widened(e: Estimate, effects: RandomEffects, lower: float, upper: float) -> Estimate:
    """An estimate whose interval holds that of the mean over logs."""
    low, high = max(min(e.low, effects.low), lower), min(max(e.high, effects.high), upper)
    wide = max(e.value - low, high - e.value) > IDENTIFIED * abs(e.value)
    meaning = f"{e.meaning}; the interval takes each log as one observation".removeprefix("; ")
    e = replace(e, low=low, high=high, meaning=meaning)
    if wide and e.verdict == "identified":
        return replace(e, verdict="weak", reason="wide")
    return e
