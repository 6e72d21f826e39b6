"""The axes that a card allows: what was identified, and each end of each interval."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..errors import InputError
from ..rig.rig import in_si
from ..units import unit

if TYPE_CHECKING:
    from ..identify.card import Card, ParameterCard
    from ..identify.parameters import Parameters
    from ..space import Array

#: What is called so is the axis as identified.
IDENTIFIED = "as identified"


def plants(card: Card, parameters: Parameters, p: Array) -> tuple[dict[str, Array], list[str]]:
    """Parameter sets of axes by name, SI, and what could not be tried, in words.

    The identified axis; each end of each interval, with the others as the card has them there,
    refitted where they move with it and else as identified; and all of the law's parameters at
    their low ends at once, and at their high ones, with the rig's own as at those of these ends
    that move them farthest.

    Args:
        card: Says the intervals.
        parameters: Its rig and law.
        p: Its parameter set, (k,).

    Raises:
        InputError: the card names a parameter beside an end that its rig and law do not have.
    """
    rig, law = parameters.rig, parameters.law
    labels = [rig.label(q.name) for q in rig.parameters(law)]
    n = len(law.params)
    axes: dict[str, Array] = {IDENTIFIED: p}
    open_: list[str] = []
    together = {"low": p.copy(), "high": p.copy()}
    for k, name in enumerate(labels):
        entry = card.parameters.get(name)
        if entry is None or entry.verdict == "fixed":
            continue
        for word, ends in together.items():
            corner = _corner(parameters, p, labels, k, entry, word)
            if corner is None:
                open_.append(f"{name} {word}")
                continue
            if k < n:
                ends[k] = corner[k]
                farther = np.abs(corner[n:] - p[n:]) > np.abs(ends[n:] - p[n:])
                ends[n:] = np.where(farther, corner[n:], ends[n:])
            if corner[k] != p[k]:
                axes[f"{name} {word}"] = corner
    for word, ends in together.items():
        if not np.array_equal(ends, p):
            axes[f"all friction {word}"] = ends
    odd = [name for name, corner in axes.items() if not np.all(law.physical(corner[None, :n]))]
    notes = [f"ends that the card leaves open were not tried: {', '.join(open_)}"] if open_ else []
    for name in odd:
        del axes[name]
        notes.append(f"{name}: no friction of law {law.name}, so it was not tried")
    return axes, notes


def _corner(
    parameters: Parameters, p: Array, labels: list[str], k: int, entry: ParameterCard, word: str
) -> Array | None:
    """The parameter set with the kth at an end of its interval; None where that is open."""
    low = word == "low"
    end = entry.low if low else entry.high
    if end is None:
        return None
    corner = p.copy()
    for label, value in (entry.others_at_low if low else entry.others_at_high).items():
        if label not in labels:
            raise InputError(f"{labels[k]}: beside its {word} end stands {label!r}, no parameter")
        at = labels.index(label)
        corner[at] = float(in_si(parameters.rig, parameters.every[at], value))
    corner[k] = float(unit(entry.unit).to_si(end))
    return corner
