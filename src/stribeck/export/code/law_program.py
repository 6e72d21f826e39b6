"""The program of a friction law and its compensator: the functions that every language prints.

- `steady(v, p)`: friction of steady sliding, `Law.slip`;
- `rubbed(v, h, z, load, p, out)`: `Law.rub`, of a law with states or loads;
- `factor(p, load)`: `terms_factor`, of a law with terms;
- `compensator_output(factor, v_ref, v, h, before, z, load, p, c, out)`: the compensator.

Each is translated from its one Python source. `z` and `out` are there for a law with states only,
`load` for one with loads, `factor` as an argument for one with terms.
"""

from __future__ import annotations

from ...compensate.compensator import SETTINGS, compensator_output
from ...friction import LOADS, Law
from ...friction.law import term_places, terms_factor
from .function_source import FunctionSource
from .program import Program
from .translation import translate


def law_entries(law: Law) -> list[FunctionSource]:
    """`steady`, and `rubbed` of a law that has it."""
    drop, arrays = _arguments(law)
    entries = [FunctionSource("steady", law.slip, {"p": len(law.params)})]
    if law.rub is not None:
        unread = (*drop, *(() if law.states else ("h",)))
        written = ("out",) if law.states else ()
        entries.append(FunctionSource("rubbed", law.rub, arrays, written, unread))
    return entries


def law_program(law: Law, *, compensator: bool = True) -> Program:
    """The functions of a law, and of a compensator that evaluates it.

    Raises:
        InputError: its source says something that has no place in a program.
    """
    drop, arrays = _arguments(law)
    entries = law_entries(law)
    if law.terms:
        places = tuple(term_places(law).tolist())
        lengths = {"p": len(law.params), "load": len(LOADS)}
        entries.append(
            FunctionSource("factor", terms_factor, lengths, constants={"places": places})
        )
    if compensator:
        constants = {"general": law.rub is not None, "states": law.states}
        entries.append(
            FunctionSource(
                "compensator_output",
                compensator_output,
                {**arrays, "c": len(SETTINGS)},
                ("out",) if law.states else (),
                drop,
                constants if law.terms else {**constants, "factor": 1.0},
                {"slip": "steady", "rub": "rubbed"},
            )
        )
    return translate(entries, f"law {law.name}")


def _arguments(law: Law) -> tuple[tuple[str, ...], dict[str, int | tuple[int, int]]]:
    """Arguments that the functions of a law do not have, and lengths of their arrays."""
    drop = (*(() if law.states else ("z", "out")), *(() if law.loads else ("load",)))
    lengths = {"p": len(law.params), "z": law.states, "load": len(LOADS), "out": law.states}
    return drop, {name: length for name, length in lengths.items() if name not in drop}
