"""Effects that a model leaves out: patterns of its residual, and the parameters they bias.

An effect counts if chance does not explain it and if it is material. Chance is judged by blocks of
rows (`bins`): in twelve equal-count bins of speed, position, time and acceleration, which see
anything, and along patterns with a name, which see less and that sooner. What sampling leaves is
taken out before. Material is what moves a parameter by a good part of its interval once the pattern
is estimated with it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ...space import Array
from .acceleration_error import without_motion_error
from .bins import Binned, between, bin_of, binned, probability, signs, t_probability
from .patterns import Kind, Pattern, Variable, carrier, patterns, tone, wave_shares
from .phase_changes import phase_changes
from .recurrence import SEEN, Recurrence, recurrence
from .remainder import Remainder
from .residual_rows import FEWEST, ROWS, ResidualRows, blocks
from .reversals import CONCENTRATED, ROWS_BEHIND, behind_reversals, mark_of_reversals

#: Greatest probability of chance, of bins and of a named pattern: the looks at a clean log and
#: the patterns then raise a false alarm in one of a hundred, material or not.
CHANCE, CHANCE_NAMED = 1e-3, 1e-4
#: An effect is material if it moves a parameter by so much of its interval's half-width, and by so
#: much of its value.
OF_INTERVAL, OF_VALUE = 0.5, 0.01
#: A pattern names an effect if it explains this share of what the bins explain.
NAMED = 0.5
#: Patterns of the same name that explain this share of what the best does are as good.
ALIKE = 0.9
#: Effects looked for, one after the other, each in what the last has left.
MOST = 3
#: Numbers in the patterns that are looked at together, at most.
NUMBERS = 1 << 21

#: What is looked at.
LOOKS: tuple[tuple[Variable, Kind], ...] = (
    ("speed", "force"), ("position", "force"), ("position", "friction"), ("time", "force"),
    ("time", "friction"), ("time", "inertia"), ("acceleration", "force"),
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class Effect:
    """A pattern of a residual that chance does not explain.

    Args:
        variable: What it goes with.
        kind: Whether it is a force, friction, whose sign is the velocity's, or an inertia's.
        pattern: `square`, `side`, `drop`, `slope`, `wave`, `drift`, `change`, `intermittent`,
            `tone`, `load`, `play`, or `turn` where sampling leaves as much; empty for another.
        scale: A period, a speed or a time that shapes it, SI; nan where none does.
        share: Of the residual's variance that it explains.
        probability: That chance explains as much.
        shifts: What the parameters change by if it is estimated with them, SI, by name: those
            alone that it moves materially.
        others: What they change by with other scales of the pattern that explain nearly as much.
        opposite: What they change by at its other end, where it comes and goes, as `shifts`.
        size: Root mean square of the force that it makes, N (N m).
    """

    variable: Variable | Literal["reversal"]
    kind: Kind
    pattern: str
    scale: float
    share: float
    probability: float
    shifts: dict[str, float] = field(default_factory=dict)
    others: tuple[dict[str, float], ...] = ()
    opposite: dict[str, float] = field(default_factory=dict)
    size: float = 0.0


@dataclass(frozen=True, eq=False)
class BinnedResidual:
    """A residual in bins of a variable, as the fit leaves it."""

    variable: Variable
    kind: Kind
    bins: Binned


@dataclass(frozen=True, eq=False)
class Effects:
    """All that is seen in a residual.

    Args:
        looks: The residual in bins of every variable; none if there are too few rows.
        effects: Those that chance does not explain, in the order in which they were seen.
        noise: Root mean square of the residual in the rows looked at, N (N m).
        recurrence: What the residual has again wherever the motion has, material effects taken
            out; None where there is nothing, and in the equation error of a simulated motion.
    """

    looks: tuple[BinnedResidual, ...]
    effects: tuple[Effect, ...]
    noise: float
    recurrence: Recurrence | None = None


def effects(rows: ResidualRows) -> Effects:
    """The effects in a residual."""
    rows = rows.sliding()
    if len(rows) < ROWS or not (rows.residual @ rows.residual) > 0:
        return Effects((), (), float("nan"))
    block = blocks(rows)
    if block.max() + 1 < FEWEST:
        return Effects((), (), float("nan"))
    flips, k, noise = signs(block), len(rows.names), float(np.sqrt(np.mean(rows.residual**2)))
    most = _no_terms(rows).shape[1]
    rows = _with_what_sampling_leaves(rows)
    sampled = 0 < most == _no_terms(rows).shape[1]
    remainder = Remainder(rows, _no_terms(rows))
    looks = first = _looks(remainder.rows, block, flips)
    result = _at_reversals(rows, remainder, block, flips, "turn" if sampled else "play")
    if result:
        away = behind_reversals(rows) == ROWS_BEHIND
        rows, block = rows.rows(away), block[away]
        remainder = Remainder(rows, _no_terms(rows))
        looks = _looks(remainder.rows, block, flips)
    columns = material = _no_terms(rows)
    while len(result) < MOST:
        candidates = [c for look in looks if (c := _seen(remainder, look, block, flips))]
        if not candidates:
            break
        effect, pattern = max(candidates, key=lambda c: c[0].share)
        before, columns = remainder, np.column_stack([columns, pattern])
        remainder = Remainder(rows, columns)
        shifts = dict(zip(rows.names, (remainder.x[:k] - before.x[:k]).tolist(), strict=True))
        gone = before.rows.residual - remainder.rows.residual
        # Which of the scales that fit as well it is, nobody knows: the greatest shift counts.
        shifts = _material(rows, [shifts, *effect.others])
        opposite = _material(rows, [effect.opposite])
        size = float(np.sqrt(np.mean(gone**2)))
        result.append(replace(effect, shifts=shifts, opposite=opposite, size=size))
        material = np.column_stack([material, pattern]) if shifts else material
        looks = _looks(remainder.rows, block, flips)
    return Effects(first, tuple(result), noise, _recurrence(rows, material, block))


def _recurrence(rows: ResidualRows, columns: Array, block: NDArray[np.intp]) -> Recurrence | None:
    """What recurs in what parameters and columns, (rows, k), leave of some of the rows."""
    if rows.other is not None:
        return None
    some = np.arange(len(rows)) % max(len(rows) // SEEN, 1) == 0
    return recurrence(Remainder(rows.rows(some), columns[some]).rows, block[some])


def _with_what_sampling_leaves(rows: ResidualRows) -> ResidualRows:
    """The rows with those columns of sampling alone that are in a residual as they may be.

    What has more of them than sampling makes has it from elsewhere: play does.
    """
    k, columns = len(rows.names), _no_terms(rows)
    while columns.shape[1]:
        sizes = np.abs(Remainder(rows, columns).x[k:])
        if sizes.max() <= 1.0:
            break
        columns = np.delete(columns, int(sizes.argmax()), axis=1)
    return replace(rows, sampling=columns)


def _no_terms(rows: ResidualRows) -> Array:
    """Columns of a residual that stand for no term of a model, (rows, any)."""
    return np.empty((len(rows), 0)) if rows.sampling is None else rows.sampling


def _at_reversals(
    rows: ResidualRows,
    remainder: Remainder,
    block: NDArray[np.intp],
    flips: Array,
    pattern: Literal["play", "turn"],
) -> list[Effect]:
    """The effect of rows right behind reversals, if there is one: what leaving them out changes.

    In the equation error of a simulated motion it is not looked for: its filter is longer.
    """
    if rows.other is not None:
        return []
    share, chance = mark_of_reversals(remainder.rows, block, flips)
    if not (share > CONCENTRATED and chance <= CHANCE):
        return []
    behind = behind_reversals(rows) < ROWS_BEHIND
    others = rows.rows(~behind)
    x = Remainder(others, _no_terms(others)).x
    shifts = _material(rows, [dict(zip(rows.names, x[: len(rows.names)].tolist(), strict=True))])
    size = float(np.sqrt(np.sum(rows.residual[behind] ** 2) / len(rows)))
    reach = ROWS_BEHIND * float(np.median(np.diff(rows.t)))
    return [Effect("reversal", "force", pattern, reach, share, chance, shifts, size=size)]


def _looks(rows: ResidualRows, block: NDArray[np.intp], flips: Array) -> tuple[BinnedResidual, ...]:
    return tuple(
        BinnedResidual(
            variable, kind, binned(rows.variable(variable), _signed(rows, kind), block, flips)
        )
        for variable, kind in LOOKS
    )


def _signed(rows: ResidualRows, kind: Kind) -> Array:
    return rows.residual * carrier(rows, kind)


def _seen(
    remainder: Remainder, look: BinnedResidual, block: NDArray[np.intp], flips: Array
) -> tuple[Effect, Array] | None:
    """The effect of a look, or where that has no name, what comes and goes from phase to phase.

    Each phase has a number of its own there: a pattern of one goes before it.
    """
    candidate = _candidate(remainder, look, block, flips)
    if look.variable != "time" or look.kind == "force" or (candidate and candidate[0].pattern):
        return candidate
    unsteady = _unsteady(remainder, look.kind)
    if candidate and unsteady and unsteady[0].share < NAMED * candidate[0].share:
        return candidate
    return unsteady or candidate


def _candidate(
    remainder: Remainder, look: BinnedResidual, block: NDArray[np.intp], flips: Array
) -> tuple[Effect, Array] | None:
    """The effect that a look shows, and its columns, (rows, k); None if chance would show it."""
    rows, bins = remainder.rows, look.bins
    known = list(patterns(rows, look.variable, look.kind))
    chances = _chances(remainder, known, block, look.kind)
    if look.variable == "position":
        periods, shares, trials = wave_shares(rows, look.kind, block, flips)
        if len(periods):
            best = int(shares.argmax())
            known.append(Pattern.wave(rows, look.kind, float(periods[best])))
            # a thousandth by bins is a ten-thousandth by name
            chances.append(CHANCE_NAMED / CHANCE * probability(float(shares[best]), trials))
    if (look.variable, look.kind) == ("time", "force") and (heard := tone(rows, block, flips)):
        known.append(heard[0])
        chances.append(CHANCE_NAMED / CHANCE * heard[1])
    seen = bins.probability <= CHANCE
    named = [i for i, p in enumerate(chances) if p <= CHANCE_NAMED]
    if not (seen or named):
        return None
    if look.kind == "inertia" and rows.noisier is not None:
        steps = Pattern("", partial(_steps, rows, look))
        gains, (*chances, by_bins) = without_motion_error(remainder, [*known, steps], block)
        seen = seen and by_bins <= CHANCE_NAMED
        named = [i for i, p in enumerate(chances) if p <= CHANCE_NAMED]
        if not (seen or named):
            return None
    else:
        gains = [_gain(remainder, p.columns) for p in known]
    among = range(len(known)) if seen else named
    best = max(among, key=lambda i: gains[i])
    if seen and gains[best] < NAMED * bins.share:
        pattern, share, alike = Pattern("", partial(_steps, rows, look)), bins.share, []
    else:
        finer = known[best].finer(rows, look.kind)
        share, pattern = max(
            ((_gain(remainder, p.columns), p) for p in finer), key=lambda pair: pair[0]
        )
        alike = [
            known[i]
            for i in among
            if gains[i] >= ALIKE * share and i != best and known[i].name == pattern.name
        ]
    least = min([bins.probability, *(chances[i] for i in named)])
    effect = Effect(
        look.variable, look.kind, pattern.name, pattern.scale, share, least,
        others=tuple(_shifts(remainder, p.columns) for p in alike),
    )  # fmt: skip
    return effect, pattern.columns


def _unsteady(
    remainder: Remainder, kind: Literal["inertia", "friction"]
) -> tuple[Effect, Array] | None:
    """What comes and goes, as seen from the farther of its two ends, and its columns.

    None if chance would show it. In the equation error of a simulated motion it is not looked for:
    neighbours there share their filter.
    """
    rows = remainder.rows
    changes = phase_changes(remainder, kind, CHANCE_NAMED) if rows.other is None else None
    if changes is None:
        return None
    along = rows.inertial if kind == "inertia" else rows.direction
    ends = sorted((changes.least, changes.greatest), key=abs, reverse=True)
    farther, nearer = (along * (changes.more - end) for end in ends)
    share = _gain(remainder, farther[:, None])
    effect = Effect(
        "time", kind, "intermittent", float("nan"), share, changes.probability,
        opposite=_shifts(remainder, nearer),
    )  # fmt: skip
    return effect, farther


def _shifts(remainder: Remainder, columns: Array) -> dict[str, float]:
    """What the parameters change by if columns are estimated, too, SI, by name."""
    rows = remainder.rows
    x = Remainder(rows, np.column_stack([_no_terms(rows), columns])).x[: len(rows.names)]
    return dict(zip(rows.names, x.tolist(), strict=True))


def _material(rows: ResidualRows, shifts: Sequence[dict[str, float]]) -> dict[str, float]:
    """Of each parameter, the greatest of some shifts, if that is material, SI, by name."""
    result: dict[str, float] = {}
    for name, value, half in zip(rows.names, rows.values, rows.half_widths, strict=True):
        least = max(OF_INTERVAL * half, OF_VALUE * abs(value))
        greatest = max((s.get(name, 0.0) for s in shifts), key=abs, default=0.0)
        if abs(greatest) > least:
            result[name] = greatest
    return result


def _chances(
    remainder: Remainder, known: Sequence[Pattern], block: NDArray[np.intp], kind: Kind
) -> list[float]:
    """The probability that a residual goes along each pattern of one column by chance."""
    r, uneven = remainder.rows.residual, kind == "inertia"
    chances: list[float] = []
    at_once = max(NUMBERS // max(len(r), 1), 1)
    for first in range(0, len(known), at_once):
        columns = np.column_stack([p.columns for p in known[first : first + at_once]])
        columns = remainder.without(columns)
        chances += t_probability(columns, r, block, uneven=uneven).tolist()
    return chances


def _gain(remainder: Remainder, columns: Array) -> float:
    """The share of a residual's sum of squares that goes if columns are estimated, too."""
    C, r = remainder.without(columns), remainder.rows.residual
    lengths = np.sqrt(np.einsum("ij,ij->j", C, C))
    lengths[lengths <= 1e-6 * np.sqrt(np.einsum("ij,ij->j", columns, columns))] = np.inf
    C = C / lengths
    inner = np.einsum("ij,i->j", C, r)
    x = np.linalg.pinv(np.einsum("ij,ik->jk", C, C), rcond=1e-9, hermitian=True) @ inner
    return float(x @ inner) / float(r @ r)


def _steps(rows: ResidualRows, look: BinnedResidual) -> Array:
    """The bins' mean residual as one column: a pattern without a name."""
    which = bin_of(rows.variable(look.variable))
    along = carrier(rows, look.kind)
    size = np.maximum(between(along**2, which), np.finfo(float).tiny)
    return np.asarray(between(_signed(rows, look.kind), which) / size * along)
