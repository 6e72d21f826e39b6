"""The motion of an identified model under the command of a log."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..data.log_list import Columns, Log, recording_of
from ..data.recording import Recording, Source
from ..errors import InputError
from .card import read_card
from .data_split import refuse_runs

if TYPE_CHECKING:
    from .validate import IdentifiedModel


def simulate(
    model: IdentifiedModel | str | Path,
    log: Log,
    *,
    units: Mapping[str, str] | None = None,
    columns: Columns = None,
    subtract: str | None = None,
) -> Recording:
    """Simulate an identified model under the command of a log.

    Args:
        model: A card, its file, or a fit.
        log: A log whose command (or force, where one is applied) is followed, as `identify` takes
            it.
        units: Unit by column, as for `identify`.
        columns: Column by channel, as for `identify`.
        subtract: As for `identify`; by default what the card says.

    Returns:
        Time, position, velocity and force of the drive, SI, and the command that was followed.

    Raises:
        InputError: no such card, a log that lacks what the rig needs, or values that cannot be
            simulated on it.
    """
    model = read_card(model) if isinstance(model, str | Path) else model
    parameters, p = model.model()
    rig = parameters.rig
    recording = recording_of(
        log, units=units, columns=columns, usual=rig.columns, subtract=subtract, drive=rig.chain
    )
    refuse_runs([recording], "a simulation")
    rig.check_turning(recording, "take a log of that rig")
    motion = rig.simulate(parameters.law, p[None], recording)
    if not (np.isfinite(motion.position).all() and np.isfinite(motion.force).all()):
        raise InputError(f"{recording.label}: the model cannot be simulated on it: check the card")
    same = len(motion.t) == len(recording) and bool((motion.t == recording.t).all())
    return Recording(
        t=motion.t,
        position=motion.position[0],
        command=recording.command if same else None,
        velocity=motion.velocity[0],
        force=motion.force[0],
        rotary=recording.rotary,
        source=Source(f"{recording.label}, simulated", "", len(motion.t)),
    )
