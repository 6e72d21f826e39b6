"""The equation of motion that parts make, in the letters of their coefficients.

A term stands in it whose coefficient an axis states or identifies; what other letters are is told
in its last line.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Literal

from .part import Part, summed

Side = Literal["load", "motor", "both"]
#: Position and velocity of a load, as words of an equation.
_MOVES = re.compile(r"(?<![\w.])([qv])(?!\w)")


def motion_equations(parts: Sequence[Part]) -> tuple[str, ...]:
    """The lines for one mass; F_f is friction.

    Args:
        parts: In the order in which power flows.
    """
    uneven = any(p.slot == "way" for p in parts)
    moved = sorted(parts, key=lambda p: p.role != "load")
    force = "F dq_m/dq" if uneven else "F"
    driving = _relations(p for p in parts if p.role in ("controller", "motor", "transmission"))
    lines = [
        *(map(_of_motor, driving) if uneven else driving),
        f"{_inertia(moved)} a = {force}{_forces(parts)} − F_f",
        *_relations(_others(parts)),
    ]
    return _complete(parts, lines)


def coupled_equations(parts: Sequence[Part], *, friction: Side, read: str) -> tuple[str, ...]:
    """The lines for two masses: F_f is friction of the load, F_f,m of the motor.

    Args:
        parts: In the order in which power flows.
        friction: Where friction is.
        read: The position that the controller reads.
    """
    motor = [p for p in parts if p.role == "motor" or p.of_motor]
    load = [p for p in parts if p.role == "load" and not p.of_motor]
    resisted = " − F_f,m" if friction != "load" else ""
    braked = " − F_f" if friction != "motor" else ""
    driving = _relations(p for p in parts if p.role in ("controller", "motor"))
    lines = [
        *(_of_motor(line, read) for line in driving),
        *_relations(p for p in parts if p.role == "transmission"),
        f"{_inertia(motor)} a_m = F_m{_of_motor(_forces(motor), read)} − T{resisted}",
        f"{_inertia(load)} a = F{_forces(load)}{braked}",
        *_relations(_others(parts)),
    ]
    return _complete(parts, lines)


def _others(parts: Iterable[Part]) -> Iterable[Part]:
    return (p for p in parts if p.role in ("load", "sensor"))


def _relations(parts: Iterable[Part]) -> list[str]:
    """What parts say of demands, forces and readings."""
    texts = (p.equation + "".join(_present(p, p.clauses)) for p in parts)
    return [line for text in texts if text for line in text.split("; ")]


def _inertia(parts: Iterable[Part]) -> str:
    return summed(term for p in parts for term in _present(p, p.inertia))


def _forces(parts: Iterable[Part]) -> str:
    return "".join(f" {term}" for p in parts for term in _present(p, p.forces))


def _present(part: Part, terms: Mapping[str, str]) -> list[str]:
    """The terms whose coefficient an axis has."""
    return [term for name, term in terms.items() if part.stated(name)]


def _of_motor(text: str, read: str = "q_m") -> str:
    """An equation of the load's position and velocity in those that are read of the motor."""
    return _MOVES.sub(lambda sign: read if sign[1] == "q" else "v_m", text)


def _complete(parts: Iterable[Part], lines: Sequence[str]) -> tuple[str, ...]:
    """The lines, and what letters of theirs are that an axis says nothing of."""
    words = {word for line in lines for word in re.findall(r"[^\W\d]\w*", line)}
    idle = [
        f"{c.name} = {c.idle:g}".replace("inf", "∞")
        for p in parts
        for c in p.coefficients
        if c.name in words and not p.stated(c.name) and not math.isnan(c.idle or 0.0)
    ]
    return (*lines, *([f"not stated: {', '.join(idle)}"] if idle else []))
