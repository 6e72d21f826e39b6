"""The axes that a card allows: what was identified, and each end of each interval."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..units import unit

if TYPE_CHECKING:
    from ..identify.card import Card
    from ..identify.parameters import Parameters
    from ..space import Array

#: What is called so is the axis as identified.
IDENTIFIED = "as identified"


def plants(card: Card, parameters: Parameters, p: Array) -> tuple[dict[str, Array], list[str]]:
    """Parameter sets of axes by name, SI, and what could not be tried, in words.

    The identified axis; each end of each interval, the other parameters as identified; and all
    of the law's parameters at their low ends at once, and at their high ones.

    Args:
        card: Says the intervals.
        parameters: Its rig and law.
        p: Its parameter set, (k,).
    """
    rig, law = parameters.rig, parameters.law
    axes: dict[str, Array] = {IDENTIFIED: p}
    open_: list[str] = []
    low, high = p.copy(), p.copy()
    for k, q in enumerate(rig.parameters(law)):
        name = rig.label(q.name)
        entry = card.parameters.get(name)
        if entry is None or entry.verdict == "fixed":
            continue
        for word, value, ends in (("low", entry.low, low), ("high", entry.high, high)):
            if value is None:
                open_.append(f"{name} {word}")
                continue
            corner = p.copy()
            corner[k] = float(unit(entry.unit).to_si(value))
            if k < len(law.params):
                ends[k] = corner[k]
            if corner[k] != p[k]:
                axes[f"{name} {word}"] = corner
    for word, ends in (("low", low), ("high", high)):
        if not np.array_equal(ends, p):
            axes[f"all friction {word}"] = ends
    n = len(law.params)
    odd = [name for name, corner in axes.items() if not np.all(law.physical(corner[None, :n]))]
    notes = [f"ends that the card leaves open were not tried: {', '.join(open_)}"] if open_ else []
    for name in odd:
        del axes[name]
        notes.append(f"{name}: no friction of law {law.name}, so it was not tried")
    return axes, notes
