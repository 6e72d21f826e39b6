"""What a comparison of laws comes to, in sentences: what is taken, what was learnt by heart."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from .candidate import Candidate
from .nesting import INGREDIENTS, step
from .paired_test import COARSE, FEWEST, MARGIN, Paired

#: Correlation of neighbours, and samples of correlation time, below which residuals pass as white.
_LAG, _TIME = 0.1, 1.5
#: What a training error gains at least to be worth a word.
_GAIN = 1e-3


@dataclass(frozen=True)
class Finding:
    """Whether an ingredient is warranted.

    Args:
        ingredient: One of `INGREDIENTS`.
        without: The law without it.
        within: The law with it.
        training: Relative change of the training error if it is left out.
        held: The held-out error without it against that with it.
        warranted: Whether leaving it out makes the held-out error worse.
    """

    ingredient: str
    without: str
    within: str
    training: float
    held: Paired
    warranted: bool

    @property
    def text(self) -> str:
        """In a sentence."""
        what = INGREDIENTS[self.ingredient]
        said = f"{what[0].upper()}{what[1:]}: "
        pair = f"{self.without} against {self.within}"
        change = percent(self.held.change)
        if self.warranted:
            return f"{said}warranted. Without it the held-out error is {change} greater ({pair})."
        if self.held.change > MARGIN:
            return (
                f"{said}not proven. Without it the held-out error is {change} greater, but "
                f"{_doubt(self.held)} ({pair})."
            )
        less = f"{percent(max(self.training, 0.0))} in training"
        if self.held.change < 0:
            return (
                f"{said}not warranted. It gains {less} and loses {percent(-self.held.change)} on "
                f"what was held out ({pair})."
            )
        return f"{said}not warranted. It gains {less} and {change} on what was held out ({pair})."


def percent(share: float) -> str:
    """0.0413 as `4.1 %`, 2.0 as `a factor of 3`."""
    if not np.isfinite(share):
        return "beyond measure"
    if share > 1:
        return f"a factor of {share + 1:.2g}"
    return "under 0.05 %" if abs(share) < 5e-4 else f"{100 * share:.2g} %"  # noqa: PLR2004


def _doubt(held: Paired) -> str:
    if np.isnan(held.p):
        return f"{held.blocks} blocks are too few to tell"
    return f"{held.blocks} blocks do not tell that from chance (p = {held.p:.2g})"


def findings(
    laws: Sequence[tuple[str, int]],
    has: Sequence[frozenset[str]],
    taken: int,
    compare: Callable[[int, int], Paired],
    errors: Sequence[float],
) -> tuple[Finding, ...]:
    """Each ingredient by the pair of laws that differ in it alone, the nearest to what is taken.

    Args:
        laws: Name and number of free parameters of each law.
        has: Its ingredients.
        taken: The law that is recommended.
        compare: The simpler of two laws against the richer.
        errors: Training errors.
    """
    pairs: dict[str, list[tuple[int, int]]] = {}
    for i in range(len(laws)):
        for j in range(len(laws)):
            if (new := step(has[i], has[j])) is not None:
                pairs.setdefault(new, []).append((i, j))
    found = []
    for ingredient in INGREDIENTS:
        if ingredient not in pairs:
            continue
        i, j = min(
            pairs[ingredient],
            key=lambda p: (taken not in p, laws[p[1]][1] - laws[p[0]][1], laws[p[0]][1], p),
        )
        held = compare(i, j)
        gain = errors[i] / errors[j] - 1 if errors[j] > 0 else 0.0
        found.append(Finding(ingredient, laws[i][0], laws[j][0], gain, held, held.worse))
    return tuple(found)


def sentences(
    laws: Sequence[Candidate],
    taken: int,
    best: int,
    found: Sequence[Finding],
    blocks: int,
    left: Sequence[str],
) -> tuple[str, ...]:
    """The recommendation and its reasons, the most important first."""
    said = [_recommendation(laws, taken, best)]
    if left:
        said.append(
            f"Interrupted: {', '.join(left)} {'was' if len(left) == 1 else 'were'} not compared."
        )
    said += [
        _left_behind(one, laws[best]) for one in laws if one.worse and one.free <= laws[best].free
    ]
    said += _by_heart(laws)
    said += [f.text for f in found]
    if blocks < FEWEST and len(laws) > 1:
        said.append(
            f"Only {blocks} block{'s' * (blocks != 1)} of what was held out can be taken as "
            f"independent: there nothing was tested, and {COARSE:.0%} more error counted "
            "as worse. Hold out more."
        )
    said += _doubts(laws[taken])
    return (*said, _colour(laws))


def _recommendation(laws: Sequence[Candidate], taken: int, best: int) -> str:
    one, top = laws[taken], laws[best]
    if len(laws) == 1:
        return f"{one.name} is the only law that was fitted: there is nothing to choose from."
    if taken == best:
        simpler = [law for law in laws if law.free < one.free]
        why = "and every simpler law is worse" if simpler else "and is the simplest"
        return f"{one.name} is recommended: it has the least held-out error, {why}."
    assert one.against is not None  # noqa: S101 - only the best has none
    if one.against.change > MARGIN:
        return (
            f"{one.name} is recommended, with a reservation: its held-out error is "
            f"{percent(one.against.change)} greater than that of {top.name}, but "
            f"{_doubt(one.against)}. Hold out more data to decide."
        )
    return (
        f"{one.name} is recommended: the simplest law whose held-out error is not worse than the "
        f"best's ({top.name}: {percent(one.against.change)} between them)."
    )


def _left_behind(one: Candidate, top: Candidate) -> str:
    assert one.against is not None  # noqa: S101 - only the best has none
    against = one.against
    chance = "" if np.isnan(against.p) else f" (p = {against.p:.1g}, {against.blocks} blocks)"
    by = percent(against.change)
    return f"{one.name} is {by} worse on what was held out than {top.name}{chance}."


def _by_heart(laws: Sequence[Candidate]) -> list[str]:
    """Laws that train better than a simpler one and do worse on what they have not seen."""
    said = []
    for rich in laws:
        simpler = [
            s
            for s in laws
            if s.free < rich.free
            and s.ingredients <= rich.ingredients
            and rich.error < s.error * (1 - _GAIN)
            and rich.held > s.held * (1 + _GAIN)
        ]
        if not simpler:
            continue
        s = min(simpler, key=lambda law: law.held)
        lost = rich.held / s.held - 1
        verdict = "it learnt the noise" if lost > MARGIN else "what it learnt does not carry over"
        said.append(
            f"{rich.name} trains {percent(1 - rich.error / s.error)} better than {s.name} and is "
            f"{percent(lost)} worse on what was held out: {verdict}."
        )
    return said


def _doubts(one: Candidate) -> list[str]:
    if not one.unseen:
        return []
    names = ", ".join(one.unseen)
    return [f"Of {one.name}, the data do not identify {names}: read nothing into the values."]


def _colour(laws: Sequence[Candidate]) -> str:
    """How white the residuals are."""
    white = [c for c in laws if abs(c.white.lag_1) < _LAG and c.white.time < _TIME]
    if white:
        return f"Training residuals pass as white: {', '.join(c.name for c in white)}."
    best = min(laws, key=lambda c: c.white.time)
    return (
        "No law leaves white residuals: neighbours correlate by "
        f"{min(c.white.lag_1 for c in laws):.2f} at least, and {best.white.time:.3g} samples count "
        "as one. The models leave something out; AICc and BIC count samples in effect."
    )
