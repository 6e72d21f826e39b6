"""What all figures of a fit have in common."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from .schema import Report, UnitsRecord


@dataclass(frozen=True)
class Frame:
    """What all figures of a fit have in common.

    Args:
        law: The law's name.
        units: In which units numbers are shown.
        road: Whether motions were simulated, or forces balanced.
        rotary: Whether the axis turns.
        applied: Whether its force is what moves it, and measured.
    """

    law: str
    units: UnitsRecord
    road: Literal["simulation", "inverse"]
    rotary: bool
    applied: bool

    @classmethod
    def of_report(cls, report: Report) -> Frame:
        """That of a report."""
        return cls(report.card.law, report.units, report.road, report.rotary, report.applied)
