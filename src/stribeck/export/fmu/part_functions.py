"""The parts of an axis in C: their functions, translated from their Python, in order of power."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ...rig.motion.axis_row import SLOTS, WHOLE
from ...rig.motion.drives import INPUTS
from ..code.c import c_functions
from ..code.translation import FunctionSource


def part_functions(row: Sequence[Any]) -> str:
    """A function for each slot of a row of constants: the force that leaves its parts.

    Args:
        row: As `axis_row` makes it, of numbers or of symbols.

    Raises:
        InputError: a part whose source says something that has no place in C.
    """
    chain = row[WHOLE]
    lengths: dict[Any, int] = {}
    for _, function, n in chain.parts:
        lengths[function] = max(lengths.get(function, 0), n)
    names = {f: f"{f.__name__.strip('_')}_{i}" for i, f in enumerate(lengths)}
    entries = [
        FunctionSource(names[f], f, {"u": INPUTS, "c": n, "slope": 2}, ("slope",))
        for f, n in lengths.items()
    ]
    text = [c_functions(entries, "a part of the axis", "part_")]
    for slot in SLOTS:
        calls = [
            f"    F = part_{names[function]}(F, q, v, u, c + {begin}, slope);"
            for at, function, begin in chain.places()
            if at == slot
        ]
        unread = [] if calls else [f"    (void){name};" for name in ("q", "v", "u", "c", "slope")]
        text += [
            f"#define AXIS_HAS_{slot.upper()} {int(bool(calls))}",
            f"static double axis_{slot}(double F, double q, double v, const double *u,",
            "    const double *c, double *slope)",
            "{",
            *calls,
            *unread,
            "    return F;",
            "}",
            "",
        ]
    return "\n".join(text)
