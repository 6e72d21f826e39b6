"""Whether a fitted model holds: its misfit on data that it has not seen."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ..rig.rig import Simulated
from ..space import Array
from .balance import balance_scores
from .problem import Parameters, parts, stretches
from .score import Score, scores

if TYPE_CHECKING:
    from ..data.ranges import Range
    from ..data.recording import Recording


def validate(
    made: Parameters,
    p: Array,
    recordings: Sequence[Recording],
    within: Sequence[Range | str] | Range | str | None = None,
) -> list[tuple[str, str, Score]]:
    """The misfit of a complete parameter set (SI) on recordings: (log, range, score) a row.

    Args:
        made: Rig and law, as a card's `model()` gives them.
        p: (k,) parameters.
        recordings: Logs to hold the model against.
        within: Ranges to look at; each log as a whole by default.

    Raises:
        InputError: a log lacks what the rig needs, or holds no motion in a range.
    """
    wanted = parts(within, made.rig)
    if isinstance(made.rig, Simulated):
        return [
            (
                log.label,
                r.text if r is not None else "all",
                scores(made, p, stretches([log], made.rig, r)),
            )
            for log in recordings
            for r in wanted
        ]
    return [
        (log.label, r.text if r is not None else "all", balance_scores(made, p, log, r))
        for log in recordings
        for r in wanted
    ]
