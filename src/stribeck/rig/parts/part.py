"""A part of an axis: its coefficients, what it reads of a log, and what it does to the motion."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any, Literal, Self

import numpy as np

from ...constant import SMALLEST, Constant, Origin, constant, out_of_limits
from ...errors import InputError
from ...space import Param
from ..motion.axis_row import Slot, Stage
from ..motion.part_call import PartFunction

Role = Literal["controller", "motor", "transmission", "load", "sensor"]
#: Where a part of a role acts where it does not say so itself.
_SLOTS: Mapping[Role, Slot] = MappingProxyType(
    {
        "controller": "demand",
        "motor": "motor",
        "transmission": "transmission",
        "load": "position",
    }
)


@dataclass(frozen=True)
class Coefficient:
    """A quantity of a part: stated, to be identified within a range, or idle.

    Args:
        name: What it is called in rigs, cards and files.
        unit: SI unit on a linear axis.
        doc: Its meaning in half a line.
        idle: Its value where nobody speaks of it; None for one that an axis cannot do without.
        lower: Least value that is searched for, in its unit.
        upper: Greatest.
        log: Whether the range is searched on a logarithmic scale.
        symbol: How a figure prints it.
        rotary: Unit on a rotary axis, where that is another.
        at_motor: Whether that is its unit wherever the motor turns, as behind a screw.
        positive: Whether nothing can be simulated with a value of 0 or below.
        least: Least value that such a thing can have.
        most: Greatest.
        setting: Whether it is a choice and no quantity, so that nothing identifies it.
        choices: The values that such a choice has; any where empty.
        constant: Where its value is stated.
        free: Whether it is stated to be identified.
    """

    name: str
    unit: str
    doc: str
    idle: float | None = None
    lower: float = -np.inf
    upper: float = np.inf
    log: bool = False
    symbol: str = ""
    rotary: str = ""
    at_motor: bool = False
    positive: bool = False
    least: float = -np.inf
    most: float = np.inf
    setting: bool = False
    choices: tuple[float, ...] = ()
    constant: Constant | None = None
    free: bool = False

    def written(self, rotary: bool) -> str:
        """Its SI unit on an axis of a kind."""
        return self.rotary if rotary and self.rotary else self.unit

    def on(self, *, rotary: bool, turning: bool) -> Self:
        """The same quantity in its unit on an axis of a kind.

        Args:
            rotary: Whether the axis turns.
            turning: Whether its motor does.
        """
        written, stated = self.written(turning if self.at_motor else rotary), self.constant
        if stated is not None and stated.unit == self.unit:  # else it is of its axis already
            stated = replace(stated, unit=written)
        return replace(self, unit=written, rotary="", constant=stated)

    def known(
        self,
        shown: float,
        source: str,
        origin: Origin = "yours",
        *,
        unit: str | None = None,
        share: float | None = None,
        doc: str = "",
    ) -> Self:
        """The same quantity with a value.

        Args:
            shown: The value, in the unit.
            source: Where it comes from, in words.
            origin: Who vouches for it.
            unit: In which people see it; its own by default.
            share: Of the value by which it may be off; that of the origin by default.
            doc: Its meaning on this axis, where more is known of it.
        """
        written = self.unit if unit is None else unit
        stated = constant(self.name, shown, written, doc or self.doc, source, origin, share)
        return replace(self, constant=stated, free=False)

    def searched(self, lower: float, upper: float, *, log: bool | None = None) -> Self:
        """The same quantity, to be identified within a range, SI."""
        logarithmic = (self.log if log is None else log) and lower > 0
        return replace(self, constant=None, free=True, lower=lower, upper=upper, log=logarithmic)

    @property
    def limits(self) -> tuple[float, float]:
        """The least and the greatest value that such a thing can have."""
        return max(self.least, SMALLEST) if self.positive else self.least, self.most

    def fault(self, value: float) -> str:
        """What is wrong with a value, or nothing."""
        if self.choices and value not in self.choices:
            *others, last = (f"{choice:g}" for choice in self.choices)
            return f"must be {', '.join(others)} or {last} ({self.doc})"
        return out_of_limits(value, *self.limits)

    @property
    def identified(self) -> bool:
        """Whether it is to be identified: as stated, or because an axis cannot do without."""
        return self.free or (self.constant is None and self.idle is None)

    def param(self) -> Param:
        """It as a parameter of a rig."""
        return Param(
            self.name, self.lower, self.upper, self.unit, self.symbol, self.log, doc=self.doc
        )


@dataclass(frozen=True, eq=False)
class Part:
    """A part as it is declared.

    Args:
        name: What a file calls it.
        role: What it is of an axis.
        doc: What it is, in a line.
        coefficients: Its quantities.
        equation: What it says of demands, forces and readings, in the letters of its coefficients.
        clauses: What follows that where a coefficient is stated.
        inertia: Its terms of the inertia at the load, by the coefficient without which each is 0.
        forces: Its terms of the balance of forces at the load, with their signs, likewise.
        terms: What they make of the fields of `AxisConstants`, of all values of the axis by name,
            with `ratio`, the motor's speed over the load's: plain arithmetic, of floats, of arrays,
            or of symbols of another language. The inertias M of parts add up.
        function: Its physics, a function as `motion.part_call` has them; None where it has none.
        constants: What the function reads, in order, of the same values.
        wave: Coefficients of one that goes with a sine of the position: its period or order, its
            cosine and its sine; the first three of its constants are then the angle that belongs to
            a unit of position, and these amplitudes at the load.
        slot: Where it acts; by default where its role does, a load by its position alone.
        commanded: Whether it needs a commanded position.
        takes_velocity: Whether it takes the command's velocity, too; none where a log has none.
        follows_velocity: Whether it needs that, which is the command's slope where a log has none.
        drive: What a motor is asked for, and a log has to tell where there is no controller:
            "force", "current" or "voltage"; of a controller, what alone it can ask for.
        rotary: Whether it is of rotary axes alone (True), of linear ones (False), or of both.
        of_motor: Whether it acts on the motor where that moves apart from the load.
    """

    name: str
    role: Role
    doc: str
    coefficients: tuple[Coefficient, ...]
    equation: str = ""
    clauses: Mapping[str, str] = field(default_factory=dict)
    inertia: Mapping[str, str] = field(default_factory=dict)
    forces: Mapping[str, str] = field(default_factory=dict)
    terms: Callable[[Mapping[str, Any]], Mapping[str, Any]] = lambda values: {}  # noqa: ARG005 - nothing of the axis as a whole
    function: PartFunction | None = None
    constants: Callable[[Mapping[str, Any]], Sequence[Any]] = lambda values: ()  # noqa: ARG005 - none
    wave: tuple[str, str, str] | None = None
    slot: Slot | None = None
    commanded: bool = False
    takes_velocity: bool = False
    follows_velocity: bool = False
    drive: str = ""
    rotary: bool | None = None
    of_motor: bool = False

    def __getitem__(self, name: str) -> Coefficient:
        """One of its coefficients.

        Raises:
            InputError: it has no such coefficient.
        """
        for c in self.coefficients:
            if c.name == name:
                return c
        names = ", ".join(c.name for c in self.coefficients) or "none"
        raise InputError(f"{self.role}.{self.name} has no {name!r}: it has {names}")

    @property
    def contribution(self) -> str:
        """All that it contributes to an equation of motion, in words and signs."""
        texts = [self.equation + "".join(self.clauses.values())]
        forces = " ".join(self.forces.values())
        if self.role == "load" and self.inertia:
            texts.insert(0, f"{summed(self.inertia.values())} a = F {forces} − F_f")
        else:
            texts = [forces, *texts, *(f"inertia {term}" for term in self.inertia.values())]
        return "; ".join(text for text in texts if text)

    def stated(self, name: str) -> bool:
        """Whether an axis states one of its coefficients, or identifies it."""
        return self[name].constant is not None or self[name].identified

    def stage(self, values: Mapping[str, Any]) -> Stage | None:
        """The part as it acts, of the values of the axis; None where it has no physics."""
        if self.function is None:
            return None
        return Stage(self.slot or _SLOTS[self.role], self.function, self.constants(values))

    def on(self, *, rotary: bool, turning: bool) -> Self:
        """The same part with the units of an axis of a kind; see `Coefficient.on`."""
        units = {"rotary": rotary, "turning": turning}
        return replace(self, coefficients=tuple(c.on(**units) for c in self.coefficients))

    def with_coefficients(self, *stated: Coefficient) -> Self:
        """The same part with other values or ranges of some coefficients."""
        by_name = {c.name: c for c in stated}
        for name in by_name:
            self[name]
        return replace(self, coefficients=tuple(by_name.get(c.name, c) for c in self.coefficients))


def summed(terms: Iterable[str]) -> str:
    """A sum of terms as a factor."""
    text = " + ".join(terms)
    return f"({text})" if " + " in text else text
