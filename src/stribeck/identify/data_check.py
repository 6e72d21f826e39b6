"""The condition that data are what they seem: what the gate finds in the samples that count."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..data.gate import faults
from .conditions import Violation

if TYPE_CHECKING:
    from ..data.gate import Fault
    from ..data.recording import Recording
    from ..rig import Rig
    from .segment import Segment

#: Samples of a log: a mask over them, a slice, or all of them.
Samples = NDArray[np.bool_] | slice | None


def data_violations(
    rig: Rig, recordings: Sequence[Recording], rows: Sequence[Samples]
) -> list[Violation]:
    """What is wrong with the channels that a rig reads, in the samples that count.

    Args:
        rig: It.
        recordings: The logs, as `recording_list` gives them.
        rows: The samples of each that count.
    """
    doubts = [Violation("data", d.sentence, caps=d.harmful) for d in rig.doubts(recordings)]
    return doubts + [
        Violation("data", f"{log.label}: {fault.sentence}", caps=fault.harmful)
        for log, samples in zip(recordings, rows, strict=True)
        for fault in faults(log)
        if _read(rig, fault) and fault.rows[slice(None) if samples is None else samples].any()
    ]


def trained_samples(recordings: Sequence[Recording], train: Sequence[Segment]) -> list[Samples]:
    """The samples of each log that segments of it cover."""
    masks = []
    for log in recordings:
        mask = np.zeros(len(log), dtype=bool)
        for segment in train:
            if segment.recording is log:
                mask[segment.rows] = True
        masks.append(mask)
    return list(masks)


def _read(rig: Rig, fault: Fault) -> bool:
    """Whether a rig reads what a fault is of, and does not allow for it itself."""
    if fault.kind == "held" and fault.channel == "position":
        return not getattr(rig, "holds", False)
    if rig.approach == "force_balance":
        return fault.channel in ("position", "force", "voltage", "pressure", "back_pressure")
    if fault.channel == "force":
        return rig.applied_force
    if fault.channel == "velocity":
        return not getattr(rig, "from_rest", True)  # it starts with the measured state
    return fault.channel in ("position", "time")
