"""A force that is known beforehand, such as a rigid-body torque, and taken off the measured one."""

from __future__ import annotations

from dataclasses import dataclass, replace

from ..space import Array
from ..units import Unit
from .readers.heads import take_apart


@dataclass(frozen=True, eq=False)
class KnownForce:
    """What a column of a log says of the force that friction has no part in.

    Args:
        column: Its head and unit, as `read` takes it.
        values: N (N m; A where forces stay currents), at the instants of the motion, (N,).
    """

    column: str
    values: Array

    def cut(self, rows: slice) -> KnownForce:
        """The same over a slice of the samples."""
        return replace(self, values=self.values[rows])

    @classmethod
    def of(cls, head: str, unit: Unit, values: Array) -> KnownForce:
        """That of a column whose cells are in a unit."""
        stated = take_apart(head).unit is not None
        return cls(head if stated else f"{head} [{unit.written}]", values)

    @property
    def sentence(self) -> str:
        """What is told of it."""
        return f"{self.column} is subtracted from the force: the balance explains what that leaves"
