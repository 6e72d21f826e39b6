"""Which logs and samples a force balance counts."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...data.ranges import Range, windows
from ...data.segmentation import segment
from ...errors import InputError
from ..data_split import recording_list

if TYPE_CHECKING:
    from ...data.recording import Recording
    from ..data_split import DataSplit
    from .rows import Rows


def training_rows(data: DataSplit) -> tuple[list[Recording], list[Rows | None]]:
    """The logs that are trained on, and which of their samples count (None: all).

    Raises:
        InputError: a log passes none of the ranges, neither of those that are held out.
    """
    recordings, rows = counting(data.recordings, data.train)
    for log in data.recordings:
        if not any(log is used for used in recordings):
            counting([log], data.ranges)  # says why not
    return recordings, rows


def counting(
    logs: Sequence[Recording], ranges: Sequence[Range]
) -> tuple[list[Recording], list[Rows | None]]:
    """The logs that pass the ranges, and which of their samples count (None: all).

    Raises:
        InputError: no log passes any of the ranges.
    """
    logs = recording_list(logs)
    if not ranges:
        return logs, [None] * len(logs)
    chosen: list[Recording] = []
    masks: list[Rows | None] = []
    refused: InputError | None = None
    for log in logs:
        mask = np.zeros(len(log), dtype=bool)
        segmentation = segment(log)
        for r in ranges:
            try:
                for window in windows(log, r, segmentation):
                    mask[window.rows] = True
            except InputError as error:  # told by the caller, unless another log passes
                refused = refused or error
        if mask.any():
            chosen.append(log)
            masks.append(mask)
    if not chosen and refused is not None:
        raise refused
    return chosen, masks
