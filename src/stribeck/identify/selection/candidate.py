"""A candidate: a law with its errors in a comparison of laws."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property

from ..parameters import Parameters
from ..result import Fit
from .paired_test import Criteria, Paired, Whiteness
from .range_ends import End


@dataclass(frozen=True, eq=False)
class Candidate:
    """One law of a comparison, with its errors.

    Args:
        parameters: Its parameters.
        error: Its misfit on all that may be trained on, J or percent.
        held: Its error on what was held out.
        criteria: Of Akaike and Schwarz.
        white: How far its training residuals are from white noise.
        unseen: Parameters that the data do not identify.
        against: Held-out error against the best law's; None for that one.
        worse: Whether it is worse than the best law.
        range_ends: Parameters that an end of a search range holds, as people see them.
        ingredients: What it has beyond a level and a slope.
        evaluations: Of the cost, all rounds together.
        seconds: They took.
        conclude: Makes its fit.
    """

    parameters: Parameters
    error: float
    held: float
    criteria: Criteria
    white: Whiteness
    unseen: tuple[str, ...]
    against: Paired | None
    worse: bool
    range_ends: Mapping[str, End]
    ingredients: frozenset[str]
    evaluations: int
    seconds: float
    conclude: Callable[[], Fit] = field(repr=False)

    @cached_property
    def fit(self) -> Fit:
        """Fitted to all that may be trained on, with all that an identification says of it."""
        return self.conclude()

    @property
    def name(self) -> str:
        """The law's."""
        return self.parameters.law.name

    @property
    def free(self) -> int:
        """How many parameters were found."""
        return len(self.parameters.free)
