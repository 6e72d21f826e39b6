"""What a column of a drive may mean, and the lines to write where its unit does not say it."""

from __future__ import annotations

from ..errors import InputError
from ..units import unit
from ..wording import either
from .chain import counts_unknown
from .chain_numbers import ACTING, EXAMPLES, example_of

_SHARE = unit("%").dimension
_COUNT = unit("count").dimension
_CURRENT = unit("A").dimension


def chain_needed(channel: str, written: str) -> str | None:
    """What to write to make a channel of a column in such a unit; None where no chain would help.

    Args:
        channel: As recordings name it.
        written: The unit of the column.
    """
    if channel == "force":
        return missing_chain(written)
    if channel in ("position", "command", "velocity", "acceleration"):
        return counts_unknown(written) if "count" in unit(written).dimension else None
    return None


def missing_chain(written: str) -> str | None:
    """What to write to make a force of a column in such a unit; None where no chain would help.

    Args:
        written: The unit of the column.
    """
    dimension = unit(written).dimension
    share = written.strip()
    if dimension == _SHARE and share not in ("", "1", "-", "dimensionless"):
        torque, current = (_line(share, q) for q in ("torque", "current"))
        return (
            f"is in {share}, which does not say of what: {_table()} "
            f'with {torque}; or with {current}, kt = "{EXAMPLES["kt"]}"; or the same '
            "of standstill_torque, peak_torque, standstill_current, peak_current; and lead and "
            "gear where there are: `stribeck drives` lists what makers mean"
        )
    if dimension == _COUNT:
        return (
            f'is in {written.strip()}: {_table()} with signal = "counts" and scale = '
            '"2.69 mA" (what one is) and kt = "1.8 N m/A"'
        )
    if dimension == _CURRENT:
        return (
            f'is a current: {_table()} with signal = "A rms" (or "A peak", or "A" '
            'of a direct current) and kt = "0.52 N m/A rms"; without kt friction is in A'
        )
    return None


def _table() -> str:
    """Where a drive is described."""
    place = either("in a map of columns (--columns MAP.toml)", "as drive={...} of `read`")
    return f"write a [drive] table, {place} or in the rig's file,"


def _line(share: str, quantity: str) -> str:
    """How a share of a rated quantity is written."""
    example = EXAMPLES.get(f"rated_{quantity}", "1.27 N m ± 10 %")
    return f'signal = "{share} of rated {quantity}", rated_{quantity} = "{example}"'


def refuse_without_drive(name: str, rig: str) -> None:
    """Refuse a number of a drive that is set for a rig without one.

    Raises:
        InputError: it is one.
    """
    if name in ACTING:
        raise InputError(
            f"{name} is a number of a drive, and rig {rig} states none: a [drive] in the map of "
            f'the logs is written there, {name} = "{example_of(name)}", or the whole [drive] in '
            "the rig's file, where it can be set"
        )
