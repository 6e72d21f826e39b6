"""The condition that data are what they seem: what the gate finds in the samples that count."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..constant import GIVEN
from ..data.gate import faults
from ..rig.composed import ComposedRig
from ..rig.simulated import SimulatedRig
from ..rig.two_masses import TwoMassRig
from ..units import unit
from .conditions import Violation

if TYPE_CHECKING:
    from ..data.gate import Fault
    from ..data.recording import Recording
    from ..rig import Rig
    from .segment import Segment

#: Share by which a log's samples may be apart from its controller's.
_CLOCK = 0.01
_ZERO = (
    "the play's middle is taken to be in the middle of what the two encoders differ by, and a load "
    "that pulls to one side (gravity, a spring, an offset) twists the shaft there: state zero, of "
    "[sensor.motor]"
)
#: Share of a constant by which a log's own may change.
_CONSTANT = 0.02
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
    assumed = [Violation("data", s, caps=False) for s in map(rig.assumed, recordings) if s]
    if isinstance(rig, SimulatedRig):
        assumed += [Violation("data", s) for log in recordings for s in _inconstant(rig, log)]
        assumed += [Violation("data", s, caps=False) for s in _overruled(rig, recordings)]
    if isinstance(rig, ComposedRig):
        assumed += [Violation("data", s) for log in recordings for s in _other_clock(rig, log)]
    if isinstance(rig, TwoMassRig) and rig.loses_its_zero:
        assumed.append(Violation("data", _ZERO))
    return assumed + [
        Violation("data", f"{log.label}: {fault.sentence}", caps=fault.harmful)
        for log, samples in zip(recordings, rows, strict=True)
        for fault in faults(log)
        if _read(rig, fault) and fault.rows[slice(None) if samples is None else samples].any()
    ]


def _other_clock(rig: ComposedRig, log: Recording) -> list[str]:
    """That a controller whose time counts has another clock than its log."""
    if rig.clock is None or abs(log.dt / rig.clock - 1.0) <= _CLOCK:
        return []
    sentence = (
        f"{log.label}: the controller computes every {1e3 * rig.clock:.4g} ms (T), and is "
        f"simulated at each sample of the log, every {1e3 * log.dt:.4g} ms: what it integrates and "
        "what it takes for its velocity are off by that: state T, or log each of its samples"
    )
    return [sentence]


def _overruled(rig: SimulatedRig, logs: Sequence[Recording]) -> list[str]:
    """Constants that somebody has set and a log states otherwise: the log's count."""
    sentences = []
    for c in (c for c in rig.constants if c.source == GIVEN):
        values = [stated[c.name] for log in logs if c.name in (stated := rig.stated(log))]
        others = sorted({x for x in values if x != c.value or c.tolerance})
        if others:
            shown = unit(c.unit)
            stated_as = ", ".join(f"{shown.from_si(x):.4g}" for x in others)
            sentences.append(
                f"{c.name} is set to {c.shown:.4g} {c.unit}".rstrip()
                + f", and logs state it in a column of theirs ({stated_as}), which counts"
            )
    return sentences


def _inconstant(rig: SimulatedRig, log: Recording) -> list[str]:
    """What of a log's own constants is none."""
    written = {c.name: unit(c.unit) for c in rig.constants}
    sentences = []
    for name, values in rig.stated_over(log).items():
        low, middle, high = np.percentile(values, (0.0, 50.0, 100.0))
        if high - low > _CONSTANT * abs(middle):
            least, median, most = (f"{written[name].from_si(x):.3g}" for x in (low, middle, high))
            sentences.append(
                f"{log.label}: the column that states {name} goes from {least} to {most} "
                f"{written[name].written}".rstrip()
                + f": its median, {median}, counts for all of the log: identify from parts in "
                "which it stays (LOG@10s:40s)"
            )
    return sentences


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
