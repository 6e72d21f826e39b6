"""The column that holds what a drive recorded of its force."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from ...drive import DriveChain
from ...errors import InputError
from .choice import Choice
from .raw_table import shortened

#: Channels that may be a drive's signal where no column is called a force.
_SIGNALS = ("current", "voltage")


def signal_of(
    chain: DriveChain, chosen: Mapping[str, Choice], *, rotary: bool
) -> dict[str, Choice]:
    """The force of a log behind a drive: its force column, or its current or voltage.

    Args:
        chain: The drive's.
        chosen: Channel -> column so far.
        rotary: Whether its position is an angle.

    Raises:
        InputError: the chain ends in a torque on a linear axis, or the other way round; or the
            force column is a force as it stands, and the chain would come on top.
    """
    if chain.unit == ("N" if rotary else "N m"):
        says = (
            "the position is an angle: leave out lead, or record the position of the slide"
            if rotary
            else 'the position is a length: state the lead, as in lead = "10 mm"'
        )
        raise InputError(f"the [drive] table ends in {chain.unit}, and {says}")
    force = chosen.get("force")
    if force is None:
        for channel in _SIGNALS:
            choice = chosen.get(channel)
            if choice is not None and (unit := chain.resolved("force", choice.unit.written)):
                return {"force": replace(choice, unit=unit, reason="what the drive recorded")}
        return {}
    if chain.resolved("force", force.unit.written) is None:
        raise InputError(
            f"column {shortened(force.column)} is in {force.unit.written}, and the [drive] table "
            f"starts from {chain.signal.text}: a chain is applied once: leave it out, or map the "
            f'column of the signal, as in force = "head [{chain.signal.unit}]"'
        )
    return {}
