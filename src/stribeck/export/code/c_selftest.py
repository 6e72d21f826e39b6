"""The self-test of exported C: a program that walks law and compensator, and compares."""

from __future__ import annotations

from collections.abc import Sequence

from ...friction import LOADS
from ..model import Model, folded
from .check_vectors import CheckVectors

#: Largest difference that the self-test allows, relative: laws without and with states.
TOLERANCE, TOLERANCE_STATES = 1e-12, 1e-9


def selftest(model: Model, name: str, vectors: CheckVectors) -> str:
    """A program that compares exported C with numbers of the library that made it.

    Args:
        model: The model exported.
        name: Of the C files.
        vectors: The inputs, and the law's and the compensator's values for them.
    """
    law = model.law
    loads = len(LOADS) if law.loads or law.terms else 0
    rows = [
        "    {" + ", ".join(repr(float(x)) for x in (*row, *load, force, output)) + "},"
        for row, load, force, output in zip(
            vectors.inputs, vectors.loads[:, :loads], vectors.forces, vectors.outputs, strict=True
        )
    ]
    tolerance = TOLERANCE_STATES if law.states else TOLERANCE
    return "\n".join(
        [
            comment(
                [
                    f"Checks {name}.c against numbers of the library that made it; returns 0.",
                    "",
                    f"cc -std=c99 {name}.c selftest.c -lm && ./a.out",
                ]
            ),
            f'#include "{name}.h"',
            "",
            "#include <math.h>",
            "#include <stdio.h>",
            "",
            "/* v, v_ref, h" + (", loads" if loads else "") + ", friction, compensation. */",
            f"static const double rows[{len(rows)}][{5 + loads}] = {{",
            *rows,
            "};",
            "",
            "static int differs(double got, double want)",
            "{",
            f"    return !(fabs(got - want) <= {tolerance!r} * (fabs(want) + {vectors.floor!r}));",
            "}",
            "",
            *_main(name, len(rows), loads),
        ]
    )


def _main(name: str, rows: int, loads: int) -> list[str]:
    setting = [
        f"        for (j = 0; j < {loads}; j++) {{",
        "            law.load[j] = compensator.law.load[j] = row[3 + j];",
        "        }",
    ]
    return [
        "int main(void)",
        "{",
        f"    {name}_law law;",
        f"    {name}_compensator compensator;",
        f"    int i{', j' if loads else ''}, wrong = 0;",
        f"    {name}_init(&law);",
        f"    {name}_compensator_init(&compensator);",
        f"    for (i = 0; i < {rows}; i++) {{",
        "        const double *row = rows[i];",
        *(setting if loads else []),
        f"        double F = {name}_force(&law, row[0], row[2]);",
        f"        double u = {name}_compensate(&compensator, row[1], row[0], row[2]);",
        f"        if (differs(F, row[{3 + loads}]) || differs(u, row[{4 + loads}])) {{",
        "            wrong++;",
        '            printf("row %d: %.17g, %.17g\\n", i, F, u);',
        "        }",
        "    }",
        f'    printf("%d of {rows} rows differ\\n", wrong);',
        "    return wrong != 0;",
        "}",
        "",
    ]


def comment(lines: Sequence[str]) -> str:
    """A comment at the head of a file."""
    safe = [harmless(line) for line in lines]
    wrapped = [w for s in safe for w in folded(s, 96)]
    return "\n".join(["/*", *(f" * {line}".rstrip() for line in wrapped), " */"])


def harmless(text: str) -> str:
    """A text without the signs that begin or end a comment, and without C's trigraphs."""
    return text.replace("*/", "* /").replace("/*", "/ *").replace("??", "? ?").replace("??", "? ?")
