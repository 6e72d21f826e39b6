"""The conditions under which estimates hold, and what becomes of them where one does not.

An interval is a statement about a model and its data. It holds if the data are what they seem, the
constants of the rig are right, the model leaves nothing out, the arithmetic is exact enough and
the search met the best fit. Each is tested where it can be; one that does not hold is told, and
takes "identified" away from the parameters that it biases.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from .parameters import Parameters
    from .uncertainty.estimates import Estimate

Condition = Literal["data", "constants", "model", "arithmetic", "search"]


@dataclass(frozen=True)
class Violation:
    """A condition of the estimates that does not hold.

    Args:
        condition: Which.
        sentence: What fails, where, by how much, and what can be done.
        parameters: Names of those whose estimates it biases, as in `Parameters.every`; None: all.
        caps: Whether they are weak at best; if not, it is only told.
    """

    condition: Condition
    sentence: str
    parameters: frozenset[str] | None = None
    caps: bool = True

    def concerns(self, name: str) -> bool:
        """Whether it takes "identified" away from a parameter."""
        return self.caps and (self.parameters is None or name in self.parameters)


def lowered(
    parameters: Parameters, estimates: Sequence[Estimate], violations: Sequence[Violation]
) -> tuple[Estimate, ...]:
    """Estimates of which none is identified that a violation concerns.

    Args:
        parameters: Theirs; one that is tied stands or falls with the other.
        estimates: As in `parameters.every`.
        violations: Of the fit; the first that concerns a parameter is the reason.
    """
    result = []
    for q, e in zip(parameters.every, estimates, strict=True):
        names = (q.name, parameters.tied.get(q.name, q.name))
        reason = next((v.condition for v in violations if any(map(v.concerns, names))), None)
        if e.verdict == "identified" and reason is not None:
            result.append(replace(e, verdict="weak", reason=reason))
        else:
            result.append(e)
    return tuple(result)


def sentences(violations: Sequence[Violation]) -> list[str]:
    """What is told of them, each sentence once."""
    return list(dict.fromkeys(v.sentence for v in violations))
