"""Channels of a log moved in time against the others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from ..constant import COVERAGE
from ..errors import InputError
from .resampling import interpolated

if TYPE_CHECKING:
    from .recording import Recording

#: What the delay of a force is: looked for and allowed for, left, or so many seconds, exactly or
#: with a tolerance, which is twice a standard deviation.
Delay = float | tuple[float, float] | Literal["auto", "off"]

#: Channels that are measured with the force, not with the motion.
FORCE_CHANNELS = ("force", "current", "voltage", "pressure", "back_pressure")
#: Channels of the motion.
MOTION_CHANNELS = ("position", "velocity", "acceleration")
#: Fewest samples that are left of a log.
_LEAST = 10


def checked_delay(delay: Delay) -> tuple[float, float] | Literal["auto", "off"]:
    """A delay as callers give it: a word, or seconds and their standard deviation.

    Raises:
        InputError: it is neither `auto`, `off` nor a time, or its tolerance is below zero.
    """
    if isinstance(delay, str):
        if delay not in ("auto", "off"):
            raise InputError(f"delay {delay!r}: give auto, off or a time in seconds")
        return delay
    try:
        seconds, tolerance = map(float, delay if isinstance(delay, Sequence) else (delay, 0.0))
    except (TypeError, ValueError) as error:
        raise InputError(f"delay {delay!r}: give seconds, or seconds and a tolerance") from error
    if not np.isfinite(seconds):
        raise InputError(f"delay {seconds}: give a time in seconds")
    if not 0.0 <= tolerance < np.inf:
        raise InputError(f"delay {seconds} ± {tolerance}: give a tolerance in seconds, 0 or more")
    return seconds, tolerance / COVERAGE


def advanced(
    recording: Recording, seconds: float, moved: Sequence[str] = FORCE_CHANNELS
) -> Recording:
    """A log of which some channels were measured so much later than the others, all at one time.

    They are interpolated where they belong, and samples for which they were not recorded are left
    out.

    Raises:
        InputError: the log has no such channel, or is not longer than the delay.
    """
    if seconds == 0.0:
        return recording
    channels = [name for name in moved if getattr(recording, name) is not None]
    if not channels:
        raise InputError(f"{recording.label}: it has no force that a delay could move")
    t = recording.t
    first, last = np.searchsorted(t + seconds, [t[0], t[-1] + 1e-9 * recording.dt])
    if last - first < _LEAST:
        raise InputError(
            f"{recording.label}: a delay of {1e3 * seconds:.4g} ms leaves nothing of "
            f"{t[-1] - t[0]:.4g} s"
        )
    rows = slice(int(first), int(last))
    at = t[rows] + seconds
    values: dict[str, Any] = {
        name: interpolated(at, t, getattr(recording, name)) for name in channels
    }
    return replace(recording.cut(rows), **values)
