"""A voltage whose measurement a limit cuts off, told from a drive that is at its limit.

Both are flat at an extreme while the motion goes on. The drive at its limit applies what is logged,
and the model that the other samples show asks for no more; a measurement that is cut off misses
what it asks for. Noise of a later stage hides neither.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ...data.gate import limits_below_noise
from ...data.runs import within
from ...errors import InputError
from .balance import Balance, balance
from .modelled_force import force_signal

if TYPE_CHECKING:
    from ...data.recording import Recording
    from .rows import Rows

#: A model asks for more than a limit from this share of it on; the models of the EMPS report leave
#: 3 to 6 %. Samples at a limit of which it is asked.
_MORE, _SAMPLES = 0.1, 20_000


def cut_off_voltage(
    solution: Balance, recordings: Sequence[Recording], rows: Sequence[Rows | None]
) -> list[str]:
    """What is told of logs whose voltage is cut off below noise, a sentence each.

    Args:
        solution: The balance of the logs.
        recordings: The logs.
        rows: Which of their samples count, as for `balance`.
    """
    system = solution.system
    flat = [_at_limits(recording) for recording in recordings]
    if not any(mask.any() for mask in flat):
        return []
    others = [
        _without(counted, recording, mask, log.blur)
        for counted, recording, mask, log in zip(rows, recordings, flat, system.logs, strict=True)
    ]
    try:
        free = balance(
            recordings, system.parameters, filtering=system.filtering, rows=others,
            start=solution.values,
        )  # fmt: skip
    except InputError:  # too few samples are left to show a model
        return []
    sentences = []
    for log, recording, mask in zip(system.logs, recordings, flat, strict=True):
        if not mask.any():
            continue
        at = np.flatnonzero(mask[np.searchsorted(recording.t, log.clock).clip(max=len(mask) - 1)])
        at = at[:: max(len(at) // _SAMPLES, 1)]
        model = force_signal(system.rig, system.law, log, free.values)
        asked = (model(at) + log.known_at(at)) / log.raw[at]
        times = float(np.median(asked))
        if times > 1.0 + _MORE:
            sentences.append(
                f"{log.label}: the voltage is cut off at a limit, below noise, in "
                f"{mask.mean():.1%} of the samples: the others ask for {times:.2g} times as much "
                "there; raise the range of its measurement, or train on ranges that keep below it"
            )
    return sentences


def _at_limits(recording: Recording) -> NDArray[np.bool_]:
    """The samples at which the voltage of a log is flat at an extreme, below noise, (N,)."""
    if recording.voltage is None:
        return np.zeros(len(recording), dtype=bool)
    top, bottom = limits_below_noise(recording.t, recording.position, recording.voltage)
    return top | bottom


def _without(
    counted: Rows | None, recording: Recording, flat: NDArray[np.bool_], reach: int
) -> NDArray[np.bool_]:
    """Samples that count and have no voltage as high as at a limit within some samples."""
    mask = np.zeros(len(flat), dtype=bool)
    mask[slice(None) if counted is None else counted] = True
    if flat.any() and recording.voltage is not None:
        size = np.abs(recording.voltage)
        mask &= ~within(size >= size[flat].min(), reach)
    return mask
