"""Findings of a comparison of laws, in sentences: the recommendation and its reasons."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ...wording import option
from .candidate import Candidate
from .nesting import INGREDIENTS, step
from .paired_test import COARSE, FEWEST, MARGIN, MATERIAL, Paired
from .range_ends import End

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
        range_ends: Parameters of one of the two laws that an end of a search range holds, so that
            they cannot be compared.
    """

    ingredient: str
    without: str
    within: str
    training: float
    held: Paired
    warranted: bool
    range_ends: tuple[str, ...] = ()

    @property
    def text(self) -> str:
        """In a sentence."""
        ingredient = INGREDIENTS[self.ingredient]
        head = f"{ingredient[0].upper()}{ingredient[1:]}: "
        pair = f"{self.without} against {self.within}"
        change = percent(self.held.change)
        if self.range_ends:
            return (
                f"{head}cannot be told ({pair}): {', '.join(self.range_ends)}, which keeps its "
                f"error up. Widen that range ({option('bounds')})."
            )
        moved = self.held.friction
        friction = "" if np.isnan(moved) else f", and friction differs by up to {percent(moved)}"
        if self.warranted:
            return (
                f"{head}warranted. Without it the held-out error is {change} greater"
                f"{friction} ({pair})."
            )
        if moved <= MATERIAL:
            return (
                f"{head}not warranted. It moves the friction by {percent(moved)} at most within "
                f"the motion of the log; the held-out error is {percent(abs(self.held.change))} "
                f"{'greater' if self.held.change >= 0 else 'less'} without it ({pair})."
            )
        if self.held.change > MARGIN:
            return (
                f"{head}not proven. Without it the held-out error is {change} greater, but "
                f"{_doubt(self.held)} ({pair})."
            )
        gain = f"{percent(max(self.training, 0.0))} in training"
        if self.held.change < 0:
            return (
                f"{head}not warranted. It gains {gain} and loses {percent(-self.held.change)} on "
                f"what was held out ({pair})."
            )
        return f"{head}not warranted. It gains {gain} and {change} on what was held out ({pair})."


def percent(share: float) -> str:
    """0.0413 as `4.1 %`, 2.0 as `a factor of 3`."""
    if not np.isfinite(share):
        return "beyond measure"
    if share > 1:
        return f"a factor of {share + 1:.2g}"
    return "under 0.05 %" if abs(share) < 5e-4 else f"{100 * share:.2g} %"  # noqa: PLR2004


def _doubt(paired: Paired) -> str:
    if np.isnan(paired.p):
        return f"{paired.blocks} blocks are too few to tell"
    return f"{paired.blocks} blocks do not tell that from chance (p = {paired.p:.2g})"


def findings(
    laws: Sequence[tuple[str, int]],
    has: Sequence[frozenset[str]],
    recommended: int,
    compare: Callable[[int, int], Paired],
    errors: Sequence[float],
    ends: Sequence[Mapping[str, End]],
) -> tuple[Finding, ...]:
    """Each ingredient by the pair of laws that differ in it alone, the nearest to what is taken.

    Args:
        laws: Name and number of free parameters of each law.
        has: Its ingredients.
        recommended: The law that is recommended.
        compare: The simpler of two laws against the richer.
        errors: Training errors.
        ends: Parameters that an end of a search range holds.
    """
    pairs: dict[str, list[tuple[int, int]]] = {}
    for i in range(len(laws)):
        for j in range(len(laws)):
            if (added := step(has[i], has[j])) is not None:
                pairs.setdefault(added, []).append((i, j))
    results = []
    for ingredient in INGREDIENTS:
        if ingredient not in pairs:
            continue
        i, j = min(
            pairs[ingredient],
            key=lambda p: (recommended not in p, laws[p[1]][1] - laws[p[0]][1], laws[p[0]][1], p),
        )
        paired = compare(i, j)
        gain = errors[i] / errors[j] - 1 if errors[j] > 0 else 0.0
        held = i if paired.worse else j  # the range of the other takes nothing from the answer
        at_end = tuple(_at_end(laws[held][0], n, end) for n, end in ends[held].items())
        results.append(
            Finding(
                ingredient,
                laws[i][0],
                laws[j][0],
                gain,
                paired,
                paired.worse and not at_end,
                at_end,
            )
        )
    return tuple(results)


def sentences(
    laws: Sequence[Candidate],
    recommended: int,
    best: int,
    results: Sequence[Finding],
    blocks: int,
    skipped: Sequence[str],
    one_way: str,
) -> tuple[str, ...]:
    """The recommendation and its reasons, the most important first."""
    texts = [_recommendation(laws, recommended, best), *([one_way] if one_way else [])]
    texts += [
        f"{_at_end(law.name, n, end)}: beyond it its error is less, so that the comparison holds "
        f"for these ranges alone. Widen it ({option('bounds')})."
        for law in laws
        for n, end in law.range_ends.items()
    ]
    if skipped:
        texts.append(
            f"Interrupted: {', '.join(skipped)} "
            f"{'was' if len(skipped) == 1 else 'were'} not compared."
        )
    texts += [_worse(law, laws[best]) for law in laws if law.worse and law.free <= laws[best].free]
    texts += _overfitted(laws)
    texts += [f.text for f in results]
    if blocks < FEWEST and len(laws) > 1:
        texts.append(
            f"Only {blocks} block{'s' * (blocks != 1)} of what was held out can be taken as "
            f"independent: there nothing was tested, and {COARSE:.0%} more error counted "
            "as worse. Hold out more."
        )
    texts += _not_identified(laws[recommended])
    return (*texts, _colour(laws))


def _recommendation(laws: Sequence[Candidate], recommended: int, best: int) -> str:
    chosen, top = laws[recommended], laws[best]
    if len(laws) == 1:
        return f"{chosen.name} is the only law that was fitted: there is nothing to choose from."
    if recommended == best:
        simpler = [law for law in laws if law.free < chosen.free]
        reason = "and every simpler law is worse" if simpler else "and is the simplest"
        return f"{chosen.name} is recommended: it has the least held-out error, {reason}."
    assert chosen.against is not None  # noqa: S101 - only the best has none
    if chosen.against.change > MARGIN:
        return (
            f"{chosen.name} is recommended, with a reservation: its held-out error is "
            f"{percent(chosen.against.change)} greater than that of {top.name}, but "
            f"{_doubt(chosen.against)}. Hold out more data to decide."
        )
    return (
        f"{chosen.name} is recommended: the simplest law whose held-out error is not worse than "
        f"the best's ({top.name}: {percent(abs(chosen.against.change))} between them)."
    )


def _at_end(law: str, name: str, end: End) -> str:
    return f"{law} is held by the {end} end of the range of {name}"


def _worse(law: Candidate, top: Candidate) -> str:
    assert law.against is not None  # noqa: S101 - only the best has none
    against = law.against
    chance = "" if np.isnan(against.p) else f" (p = {against.p:.1g}, {against.blocks} blocks)"
    by = percent(against.change)
    return f"{law.name} is {by} worse on what was held out than {top.name}{chance}."


def _overfitted(laws: Sequence[Candidate]) -> list[str]:
    """Laws that train better than a simpler one and do worse on what they have not seen."""
    texts = []
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
        texts.append(
            f"{rich.name} trains {percent(1 - rich.error / s.error)} better than {s.name} and is "
            f"{percent(lost)} worse on what was held out: {verdict}."
        )
    return texts


def _not_identified(law: Candidate) -> list[str]:
    if not law.unseen:
        return []
    names = ", ".join(law.unseen)
    return [f"Of {law.name}, the data do not identify {names}: read nothing into the values."]


def _colour(laws: Sequence[Candidate]) -> str:
    """How white the residuals are."""
    white = [c for c in laws if abs(c.white.lag_1) < _LAG and c.white.time < _TIME]
    if white:
        return f"Training residuals pass as white: {', '.join(c.name for c in white)}."
    alternating = [c for c in laws if c.white.lag_1 <= -_LAG and c.white.time < _TIME]
    if alternating:
        return (
            "Training residuals alternate, as differentiated noise does (neighbours correlate by "
            f"{min(c.white.lag_1 for c in alternating):.2f}): no sign of what is left out by "
            f"{', '.join(c.name for c in alternating)}."
        )
    best = min(laws, key=lambda c: c.white.time)
    return (
        "No law leaves white residuals: neighbours correlate by "
        f"{min(c.white.lag_1 for c in laws):.2f} at least, and {best.white.time:.3g} samples count "
        "as one. The models leave something out; AICc and BIC count samples in effect."
    )
