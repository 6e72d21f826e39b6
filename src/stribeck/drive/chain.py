"""The chain from what a drive records to the force of the axis, and what is known of its numbers.

    signal (% of a base, A, counts, V) -> current -> kt -> torque of the motor
           -> gear, efficiency -> lead -> force at the axis

Rotor inertia is not taken off: it is part of the mass that a force balance identifies.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any, Literal, Self

import numpy as np

from ..constant import Constant
from ..errors import InputError
from ..space import Array
from ..units import Unit, unit
from .chain_numbers import ACTING, EXAMPLES, NUMBERS, ChainNumber, chain_number
from .conventions import convention_named
from .drive_signal import DriveSignal, drive_signal, sized

Side = Literal["axis", "motor"]

#: Keys of a `[drive]` table that are no numbers.
_WORDS = ("signal", "convention", "side", "motion", "reversed")
_CURRENT, _TORQUE, _FORCE = (unit(u).dimension for u in ("A", "N m", "N"))
_COUNT = {unit(u).dimension: n for n, u in enumerate(("count", "count/s", "count/s**2"))}
_ANGLE = {unit(u).dimension: n for n, u in enumerate(("rad", "rad/s", "rad/s**2"))}
_LINEAR, _ROTARY = (("m", "m/s", "m/s**2"), ("rad", "rad/s", "rad/s**2"))
#: No unit of a signal is more, in SI.
_GREATEST = 1e30
#: A word of a table, letters.
_LONGEST = 100
_MOTION = ("position", "command", "velocity", "acceleration")


@dataclass(frozen=True)
class DriveChain:
    """From a drive's signal to the force (torque) at the axis.

    Args:
        signal: What is recorded.
        numbers: By name, of `NUMBERS`.
        side: Where force and friction live: at the axis, behind gear and screw, or at the motor's
            shaft, before them.
        motion: Where position and speed were recorded. Counts, and angles of an axis with a lead,
            are the motor's whatever it says.
        reversed: Whether a positive signal drives towards smaller positions.
        convention: Name of the drive convention that the signal is by; empty if of none.

    Raises:
        InputError: a number that the signal asks for is missing, or two do not fit each other.
    """

    signal: DriveSignal
    numbers: Mapping[str, ChainNumber] = field(default_factory=dict)
    side: Side = "axis"
    motion: Side = "axis"
    reversed: bool = False
    convention: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "numbers", MappingProxyType(dict(self.numbers)))
        if not 0.0 < abs(self.gain) < _GREATEST:
            raise InputError(f"its numbers make {self.gain:g} {self.unit} of one unit: check them")
        if self.side == "motor" and self._has("efficiency", "efficiency_backward"):
            raise InputError("efficiency acts behind the motor: leave it out with side = 'motor'")

    @classmethod
    def of_table(cls, table: Mapping[str, Any], place: str = "drive") -> Self:
        """A chain as a `[drive]` table of a rig or a column map has it.

        ```toml
        [drive]
        signal = "% of rated torque"
        rated_torque = "1.27 N m ± 10 % nameplate"
        gear = 5
        lead = "10 mm"
        ```

        Raises:
            InputError: a word or number that no chain has, or one that is missing.
        """
        if odd := sorted(set(map(str, table)) - {*_WORDS, *NUMBERS}):
            raise InputError(f"{place}: no {odd[0]!r}: there are {', '.join((*_WORDS, *NUMBERS))}")
        stated = dict(table)
        name = _text(stated, "convention", place)
        if name:
            stated = {**convention_named(name, place).table, **stated}
        text = _text(stated, "signal", place)
        if not text:
            raise InputError(
                f"{place}: signal is missing: write what the drive records, as in signal = "
                '"% of rated torque", "A rms", "counts", or a convention (see `stribeck drives`)'
            )
        turned = stated.get("reversed", False)
        if not isinstance(turned, bool):
            raise InputError(f"{place}.reversed: write true or false")
        numbers = {n: chain_number(n, v, f"{place}.{n}") for n, v in stated.items() if n in NUMBERS}
        signal = drive_signal(text, f"{place}.signal")
        try:
            return cls(
                signal,
                numbers,
                _side(stated, "side", place),
                _side(stated, "motion", place),
                turned,
                name,
            )
        except InputError as error:
            raise InputError(f"{place}: {error}") from error

    def table(self) -> dict[str, Any]:
        """The chain as a `[drive]` table, which `of_table` reads back."""
        words = {"convention": self.convention, "signal": self.signal.text}
        sides = {"side": self.side, "motion": self.motion}
        return {
            **{key: word for key, word in words.items() if word},
            **{key: word for key, word in sides.items() if word != "axis"},
            **({"reversed": True} if self.reversed else {}),
            **{name: number.text for name, number in self.numbers.items()},
        }

    @property
    def constants(self) -> tuple[Constant, ...]:
        """The numbers on which the force depends, as constants of a rig."""
        return tuple(self.numbers[n].constant for n in ACTING if n in self.numbers)

    def with_constants(self, constants: Iterable[Constant]) -> Self:
        """The same chain with other values of its numbers; other constants are left aside."""
        known = {c.name: c for c in constants if c.name in self.numbers}
        numbers = {
            n: replace(number, constant=known.get(n, number.constant))
            for n, number in self.numbers.items()
        }
        return replace(self, numbers=numbers)

    def alike(self, other: DriveChain) -> bool:
        """Whether another chain is the same but for the values of its numbers."""
        same = replace(other, numbers=self.numbers) == replace(self, numbers=self.numbers)
        return same and set(self.numbers) == set(other.numbers)

    def exponent(self, name: str) -> int | None:
        """The power of a number with which all forces go; None where it is not one for all."""
        if name in ("efficiency", "efficiency_backward") or name not in self.numbers:
            return None
        moved = self.numbers[name].constant
        other = self.with_constants([replace(moved, value=2.0 * moved.value)])
        return round(math.log2(other.gain / self.gain))

    @property
    def gain(self) -> float:
        """Force (torque, current) for one unit of the signal in SI, without losses."""
        return self._computed[0]

    @property
    def unit(self) -> str:
        """SI unit of its force: N, N m, or A where there is no torque constant."""
        return self._computed[1]

    def resolved(self, channel: str, written: str) -> Unit | None:
        """A column's unit as a multiple of the channel's SI unit at the axis; None if it is none.

        A share or a current as force is converted by the whole chain, counts and angles of the
        motor as position or speed by encoder, gear and lead.

        Raises:
            InputError: counts, and the chain has no counts per turn.
        """
        if channel == "force":
            return self._force(written)
        if channel not in _MOTION:
            return None
        dimension = unit(written).dimension
        if dimension in _COUNT:
            turn = self._value("counts_per_turn")
            if turn is None:
                raise InputError(counts_unknown(written))
            return self._motion(written, _COUNT[dimension], 2 * math.pi / turn)
        moved = self.motion == "motor" or "lead" in self.numbers
        if dimension in _ANGLE and moved and self.side == "axis":
            return self._motion(written, _ANGLE[dimension], unit(written).factor)
        return None

    def losses(self, force: Array, velocity: Array) -> Array:
        """What gear and screw make of each sample of a force, (N,): its share behind them.

        The share is the efficiency where the motor drives, its counterpart's inverse where the
        load does.
        """
        forward = self._value("efficiency")
        backward = self._value("efficiency_backward", forward)
        driving = force * velocity >= 0
        return np.where(driving, forward or 1.0, 1.0 / (backward or 1.0))

    @property
    def lossy(self) -> bool:
        """Whether it states an efficiency."""
        return self._has("efficiency", "efficiency_backward")

    @property
    def rotor_mass(self) -> float:
        """What the rotor adds to the mass (moment of inertia) at the axis, kg (kg m^2)."""
        inertia = self._value("rotor_inertia") or 0.0
        return inertia / self.travel**2 if self.side == "axis" else inertia

    @property
    def known_mass(self) -> Constant | None:
        """The load's mass (moment of inertia) where it is stated."""
        number = self.numbers.get("mass")
        return number.constant if number else None

    def sentence(self, column: str = "") -> str:
        """What the chain does, for a note: signal, numbers, force for a unit, side."""
        start = (
            f"force is {column} ({self.signal.text})" if column else f"force is {self.signal.text}"
        )
        numbers = ", ".join(f"{n} {self.numbers[n].text}" for n in ACTING if n in self.numbers)
        step = unit(self.signal.unit)
        amount = f"1 {self.signal.unit} is {abs(step.factor * self.gain):.4g} {self.unit}"
        if self.unit == "A":
            return (
                f"{start} and stays a current, as the chain has no kt: friction is in {self.size}"
            )
        where = "at the axis" if self.side == "axis" else "at the motor's shaft"
        return f"{start} with {numbers or 'no number'}: {amount} {where}, where friction is"

    @property
    def size(self) -> str:
        """What its amperes are: A, A rms or A peak."""
        number = self.numbers.get(self.signal.base) or self.numbers.get("scale")
        return f"A {number.amplitude if number else self.signal.amplitude}".strip()

    @cached_property
    def _computed(self) -> tuple[float, str]:
        """Force for one unit of the signal, SI, and its unit."""
        gain, dimension, size = self._electrical()
        if dimension == _CURRENT:
            kt = self.numbers.get("kt")
            if kt is None:
                return (-gain if self.reversed else gain), "A"
            gain *= kt.value * _alike(size, kt, self.signal.text)
            dimension = unit(kt.constant.unit.replace("/A", "")).dimension
        if self.side == "axis":
            gain, dimension = self._mechanical(gain, dimension)
        return (-gain if self.reversed else gain), "N" if dimension == _FORCE else "N m"

    def _electrical(self) -> tuple[float, str, str]:
        """Torque, force or current for one unit of the signal, its dimension and amplitude."""
        name = self.signal.base
        if not name and self.signal.dimension in (_CURRENT, _TORQUE, _FORCE):
            return 1.0, self.signal.dimension, self.signal.amplitude
        name = name or "scale"
        number = self.numbers.get(name)
        if number is None:
            raise InputError(
                f"the signal is {self.signal.text}, and {name} is missing: write {name} = "
                f'"{EXAMPLES.get(name, "1.27 N m ± 10 %")}"'
            )
        written = number.constant.unit.removesuffix("/V")
        return number.value, unit(written).dimension, number.amplitude

    def _mechanical(self, gain: float, dimension: str) -> tuple[float, str]:
        """The same behind gear and screw."""
        if dimension == _FORCE:
            if self._has("gear", "lead"):
                raise InputError("a linear motor's force has no gear and no lead: leave them out")
            return gain, dimension
        force = "lead" in self.numbers
        return gain / self.travel, _FORCE if force else _TORQUE

    def factors(self) -> dict[str, float]:
        """The factors of the gain, by what they are."""
        acting = {n: self.numbers[n].value for n in ACTING if n in self.numbers}
        words = {n: f"the factor of {n}" for n in acting}
        result = {words[n]: value for n, value in acting.items() if n not in ("gear", "lead")}
        if self.side == "axis" and "gear" in acting:
            result["the gear ratio"] = acting["gear"]
        if self.side == "axis" and "lead" in acting:
            result["2 π over the lead"] = 2 * math.pi / acting["lead"]
        return result

    @property
    def travel(self) -> float:
        """Motion of the axis for one radian of the motor, m (rad)."""
        gear, lead = self._value("gear", 1.0), self._value("lead")
        return (lead / (2 * math.pi) if lead else 1.0) / (gear or 1.0)

    def _force(self, written: str) -> Unit | None:
        if not self.signal.takes(written):
            return None
        return Unit(
            written, unit(sized(written)[0]).factor * self.gain, 0.0, unit(self.unit).dimension
        )

    def _motion(self, written: str, order: int, factor: float) -> Unit:
        linear = "lead" in self.numbers and self.side == "axis"
        travel = self.travel if self.side == "axis" else 1.0
        name = (_LINEAR if linear else _ROTARY)[order]
        return Unit(written, factor * travel, 0.0, unit(name).dimension)

    def _value(self, name: str, default: float | None = None) -> float | None:
        number = self.numbers.get(name)
        return default if number is None else number.value

    def _has(self, *names: str) -> bool:
        return any(n in self.numbers for n in names)


def counts_unknown(written: str) -> str:
    """What to write where a column is in counts and nobody says how many make a turn."""
    return (
        f"is in {written}: write counts_per_turn = 65536 (counts for a turn of the motor), with "
        'lead = "10 mm" on a linear axis and gear = 5 where there is one, in a [drive] table'
    )


def _alike(size: str, kt: ChainNumber, text: str) -> float:
    """What turns amperes of one size into those that a torque constant is for."""
    if size == kt.amplitude:
        return 1.0
    if not (size and kt.amplitude):
        known, unknown = ("kt", text) if kt.amplitude else (text, "kt")
        raise InputError(
            f"{known} says whether its amperes are rms or peak, and {unknown} does not: write "
            '"A rms" or "A peak" in both, as in kt = "0.52 N m/A rms"'
        )
    return math.sqrt(2.0) if size == "rms" else math.sqrt(0.5)


def _text(table: Mapping[str, Any], key: str, place: str) -> str:
    value = table.get(key, "")
    if not isinstance(value, str):
        raise InputError(f"{place}.{key}: must be text in quotes")
    if len(value) > _LONGEST:
        raise InputError(f"{place}.{key}: {value[:40]!r}... is too long")
    return value.strip()


def _side(table: Mapping[str, Any], key: str, place: str) -> Side:
    value = table.get(key, "axis")
    if value not in ("axis", "motor"):
        raise InputError(f'{place}.{key}: {value!r}: write "axis" or "motor"')
    return value  # type: ignore[no-any-return]
