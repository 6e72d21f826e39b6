"""Validation: the misfit of a fitted model on data that it was not trained on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from ..data.alignment import Delay, checked_delay
from ..data.log_list import Columns, Logs
from ..rig.simulated import as_simulated
from ..space import Array
from ..wording import option
from .balance.force_balance import balance_scores
from .card import read_card
from .data_split import ranges_or_all, recording_list
from .parameters import Parameters
from .score import Score, scores
from .segment import directions_of, segments

if TYPE_CHECKING:
    from ..data.ranges import Range
    from ..data.recording import Recording
    from .card import Card


class IdentifiedModel(Protocol):
    """What can be held against data: a card, or a fit."""

    @property
    def delay(self) -> float:
        """By how much the force was behind the motion in its logs, s."""

    def model(self) -> tuple[Parameters, Array]:
        """Rig and law, and the complete parameter set, SI."""


def validate(
    model: IdentifiedModel | str | Path,
    logs: Logs,
    within: Sequence[Range | str] | Range | str | None = None,
    *,
    delay: Delay = "auto",
    units: Mapping[str, str] | None = None,
    columns: Columns = None,
    subtract: str | None = None,
) -> list[tuple[str, str, Score]]:
    """The misfit of an identified model on recordings: (log, range, score) a row.

    Args:
        model: A card, its file, or a fit.
        logs: Logs to hold the model against, as `identify` takes them.
        within: Ranges to look at; each log as a whole by default.
        delay: Of the force after the motion in these logs, s; `auto`: as in the model's own;
            `off`: none.
        units: Unit by column, as for `identify`.
        columns: Column by channel, as for `identify`.
        subtract: As for `identify`; by default what the card says.

    Raises:
        InputError: no such card, or a log lacks what the rig needs, or holds no motion in a range.
    """
    model = read_card(model) if isinstance(model, str | Path) else model
    parameters, p = model.model()
    named = {"auto": model.delay, "off": 0.0}
    checked = checked_delay(delay)
    seconds = named[checked] if isinstance(checked, str) else checked[0]
    recordings = recording_list(
        logs, parameters.rig, units=units, columns=columns, subtract=subtract
    )
    return [
        (log.label, r.text if r is not None else "all", _score(parameters, p, log, r))
        for log in (parameters.rig.in_step(log, seconds) for log in recordings)
        for r in ranges_or_all(within, parameters.rig)
    ]


def untrained_directions(
    card: Card,
    recordings: Sequence[Recording],
    within: Sequence[Range | str] | Range | str | None = None,
) -> list[str]:
    """Where an axis goes in a direction that its card was not trained on, a sentence a range.

    Only where both directions share one set of parameters: then nothing in the card says that
    the other one rubs alike.
    """
    parameters, _ = card.model()
    trained = card.speeds
    if trained is None or parameters.law.directional or parameters.rig.approach == "force_balance":
        return []
    rig = as_simulated(parameters.rig)
    directions = trained.directions
    if not rig.from_rest or len(directions) != 1:
        return []
    sentences = []
    for log in recordings:
        for r in ranges_or_all(within, rig):
            if directions_of(segments([log], rig, r)) - directions:
                extent = "as a whole" if r is None else f"over {r.text}"
                alone = not directions_of(segments([log], rig, r)) & directions
                which = "" if r is not None else f": {option('within')} tells which part"
                sentences.append(
                    f"{log.label} {extent} {'' if alone else 'also '}runs the other way than the "
                    f"card was trained on ({trained.low:.4g} to {trained.high:.4g} "
                    f"{trained.unit}){which}"
                )
    return sentences


def _score(parameters: Parameters, p: Array, log: Recording, part: Range | None) -> Score:
    if parameters.rig.approach == "output_error":
        passed = segments([log], as_simulated(parameters.rig), part, parameters.objective)
        return scores(parameters, p, passed)
    return balance_scores(parameters, p, log, part)
