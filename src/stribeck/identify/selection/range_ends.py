"""Ends of search ranges: where they keep the misfit of a law up, and what lies beyond.

A law whose answer sits at an end of a range is no fit of that law: a richer law beside it gains by
making up for the range. An answer at the end of a default range goes on beyond it; a range of the
user's is kept, and what it costs is tried out.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Generic, Literal, TypeVar

from ..parameters import Parameters

if TYPE_CHECKING:
    from ...space import Array

T = TypeVar("T")
End = Literal["lower", "upper"]

#: How often ranges are widened in a row; and the share of the misfit that must be gained beyond
#: an end for it to have held the law.
WIDENINGS, GAIN = 10, 1e-3


@dataclass(frozen=True, eq=False)
class RangedAnswer(Generic[T]):
    """A trained set of parameters.

    Args:
        parameters: With the search ranges that it was found in.
        x: The free ones, SI, (dim,).
        cost: Its misfit.
        solution: What the method has of it besides.
    """

    parameters: Parameters
    x: Array
    cost: float
    solution: T


def beyond(
    answer: RangedAnswer[T], solve: Callable[[Parameters, RangedAnswer[T]], RangedAnswer[T]]
) -> tuple[RangedAnswer[T], dict[str, End]]:
    """An answer in ranges so wide that they do not hold it, and the ends of ranges that still do.

    Args:
        answer: Where training ended.
        solve: Trains with other ranges, from an answer on.

    Returns:
        The answer, and by name the parameters whose range keeps its misfit up.
    """
    for _ in range(WIDENINGS):
        wider = answer.parameters.widened(answer.x)
        if wider is None:
            break
        further = solve(wider, answer)
        if further.cost > (1 - GAIN) * answer.cost:
            break
        answer = further
    free = replace(answer.parameters, bounded=frozenset())
    wider = free.widened(answer.x)
    if wider is None:
        return answer, {}
    further = solve(wider, answer)
    if further.cost > (1 - GAIN) * answer.cost:
        return answer, {}
    ends: dict[str, End] = {}
    for q, value in zip(answer.parameters.free, further.x.tolist(), strict=True):
        if not q.lower <= value <= q.upper:
            ends[q.name] = "lower" if value < q.lower else "upper"
    return answer, ends


def with_ranges_of(parameters: Parameters, others: Mapping[str, tuple[float, float]]) -> Parameters:
    """Default ranges at least as wide as others by name, so that a simpler law's answer fits in."""
    wide = {
        q.name: replace(q, lower=min(q.lower, low), upper=max(q.upper, high))
        for q in parameters.free
        if q.name in others and q.name not in parameters.bounded
        for low, high in [others[q.name]]
        if low > 0 or not q.log
    }
    every, free = (
        tuple(wide.get(q.name, q) for q in params) for params in (parameters.every, parameters.free)
    )
    return replace(parameters, every=every, free=free)
