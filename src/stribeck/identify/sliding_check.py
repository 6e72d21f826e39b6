"""Logs in which the axis never slid, and the parameters that they cannot determine."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from ..data.breakaway import presliding, ramps
from ..rig.rig import stem

if TYPE_CHECKING:
    from ..data.recording import Recording
    from .parameters import Parameters
    from .uncertainty.estimates import Estimate

#: What only sliding shows, by the names that laws give it.
_SLIDING = ("F_S", "F_C", "v_SS", "v_s", "ratio", "tau")
#: Levels of elements: they add up to what the contact was seen to hold.
_LEVEL = "W"


def never_slid(parameters: Parameters, recordings: Sequence[Recording]) -> list[str]:
    """A sentence where no recording has a force that moved the axis out of presliding.

    A law fits the loops all the same, with a level towards which they flatten; but a contact
    that creeps flattens long before it breaks away, so that this level is none.
    """
    if not recordings or not all(map(_below_breakaway, recordings)):
        return []
    free = [q.name for q in parameters.free]
    names = [parameters.rig.label(n) for n in free if n.rstrip("+-") in _SLIDING]
    sentences = []
    if names:
        listed = " and ".join(x for x in (", ".join(names[:-1]), names[-1]) if x)
        logs_text = "this log" if len(recordings) == 1 else "these logs"
        sentences.append(f"{listed} cannot be known from {logs_text}")
    if any(stem(n) == _LEVEL for n in free):
        sentences.append(f"the levels {_LEVEL}_i do not add up to its breakaway")
    return [f"the axis never slid: {'; '.join(sentences)}"] if sentences else []


def mark_never_slid(
    parameters: Parameters, estimates: Sequence[Estimate], recordings: Sequence[Recording]
) -> tuple[Estimate, ...]:
    """The estimates, with no parameter called identified that only sliding shows and none saw.

    An end of its interval that is a guess is that of its range: nothing in the logs is nearer.
    """
    if not recordings or not all(map(_below_breakaway, recordings)):
        return tuple(estimates)
    hidden = {
        parameters.rig.label(q.name) for q in parameters.free if q.name.rstrip("+-") in _SLIDING
    }
    meaning = "the axis never slid: what fits the loops is the level towards which they flatten"
    return tuple(
        replace(_as_open(e), verdict="not identifiable", reason="data", meaning=meaning)
        if e.name in hidden
        else e
        for e in estimates
    )


def _as_open(e: Estimate) -> Estimate:
    """An estimate whose interval reaches the range's end where its own end is a guess."""
    q = e.searched
    if q is not None and e.low_ended == "budget":
        e = replace(e, low=q.lower, low_ended="bound")
    if q is not None and e.high_ended == "budget":
        e = replace(e, high=q.upper, high_ended="bound")
    return e


def _below_breakaway(recording: Recording) -> bool:
    """Whether the force of a log went round or up below breakaway."""
    rising = ramps(recording)
    if rising:
        return all(ramp.by_speed is None for ramp in rising)
    return presliding(recording) is not None
