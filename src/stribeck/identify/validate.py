"""Whether a fitted model holds: its misfit on data that it has not seen."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Protocol

from ..rig.rig import Simulated
from ..space import Array
from .balance import balance_scores
from .problem import Parameters, listed, parts
from .score import Score, scores
from .stretch import stretches

if TYPE_CHECKING:
    from ..data.ranges import Range
    from ..data.recording import Recording


class Model(Protocol):
    """What can be held against data: a card, or a fit."""

    def model(self) -> tuple[Parameters, Array]:
        """Rig and law, and the complete parameter set, SI."""


def validate(
    model: Model,
    recordings: Recording | Sequence[Recording],
    within: Sequence[Range | str] | Range | str | None = None,
) -> list[tuple[str, str, Score]]:
    """The misfit of an identified model on recordings: (log, range, score) a row.

    Args:
        model: A card or a fit.
        recordings: Logs to hold the model against.
        within: Ranges to look at; each log as a whole by default.

    Raises:
        InputError: a log lacks what the rig needs, or holds no motion in a range.
    """
    made, p = model.model()
    return [
        (log.label, r.text if r is not None else "all", _score(made, p, log, r))
        for log in listed(recordings)
        for r in parts(within, made.rig)
    ]


def _score(made: Parameters, p: Array, log: Recording, within: Range | None) -> Score:
    if isinstance(made.rig, Simulated):
        on = stretches([log], made.rig, within, restart=made.measure.restart)
        return scores(made, p, on)
    return balance_scores(made, p, log, within)
