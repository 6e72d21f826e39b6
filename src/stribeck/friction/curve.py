"""Friction over speed as a table: levels at knots, straight lines between them.

No formula: what a drive's own table of friction compensation is, and what formulas are held
against. The knots are spaced by their logarithm; where a force balance is solved, the slowest and
the fastest of them are those of the motion.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, partial
from math import copysign
from typing import Any

import numpy as np

from ..space import Array, Param
from .law import Law, by_direction, slip_law

#: How many knots the law has unless its name says so: `curve:20`.
KNOTS = 12
#: Its last two parameters, the speeds of the first and the last knot, by name.
FIRST, LAST = "v_first", "v_last"


def knot_speeds(n: int, first: float, last: float) -> Array:
    """The speeds of n knots, m/s (rad/s), (n,)."""
    return np.asarray(np.geomspace(first, last, n))


def knots_of(law: Law, p: Array) -> Array:
    """The knots of a law's curve at a parameter set, (n,); none of a law that is a formula."""
    if law.roughness is None:
        return np.zeros(0)
    tables = 2 if law.directional else 1
    n = (len(law.params) - sum(law.sizes) - 2) // tables
    return knot_speeds(n, float(p[tables * n]), float(p[tables * n + 1]))


def _slip_of(n: int) -> Any:
    """The table of n knots, the same both ways; beyond its ends the levels of its ends."""

    def _slip(v: float, p: Array) -> float:
        ratio = (p[n + 1] / p[n]) ** (1.0 / (n - 1))
        speed, knot, F = abs(v), p[n], p[0]
        for i in range(n - 1):
            share = (speed - knot) / (knot * (ratio - 1.0))
            F += min(max(share, 0.0), 1.0) * (p[i + 1] - p[i])
            knot *= ratio
        return copysign(1.0, v) * F  # type: ignore[no-any-return]

    return slip_law(_slip)


def _slip_directional_of(n: int) -> Callable[[float, Array], float]:
    """The same with a table for each direction over the same knots."""

    def _slip_directional(v: float, p: Array) -> float:
        k = 0 if copysign(1.0, v) > 0 else n
        ratio = (p[2 * n + 1] / p[2 * n]) ** (1.0 / (n - 1))
        speed, knot, F = abs(v), p[2 * n], p[k]
        for i in range(n - 1):
            share = (speed - knot) / (knot * (ratio - 1.0))
            F += min(max(share, 0.0), 1.0) * (p[k + i + 1] - p[k + i])
            knot *= ratio
        return copysign(1.0, v) * F  # type: ignore[no-any-return]

    return _slip_directional


def roughness(p: Array, n: int, tables: int) -> Array:
    """Rows over the parameters, (tables (n - 2), k): knots less the chord of their neighbours.

    Straight tables, which are Coulomb and viscous friction, have none. On a logarithmic scale of
    speeds a drop is as rough wherever it lies.
    """
    v = knot_speeds(n, p[tables * n], p[tables * n + 1])
    rows = np.zeros((tables * (n - 2), len(p)))
    for table in range(tables):
        for i in range(1, n - 1):
            share = (v[i] - v[i - 1]) / (v[i + 1] - v[i - 1])
            at = table * n + i
            rows[table * (n - 2) + i - 1, at - 1 : at + 2] = share - 1.0, 1.0, -share
    return rows


@cache
def curve(n: int) -> Law:
    """The law with n knots."""
    return Law(
        name="curve" if n == KNOTS else f"curve:{n}",
        params=(
            *(
                Param(f"F_{i}", 0.0, 1000.0, "N", f"F_{i}", doc=f"friction at knot {i} of {n}")
                for i in range(1, n + 1)
            ),
            Param(FIRST, 1e-6, 1e-3, "m/s", "v_1", True, 1e-4, "speed of the first knot"),
            Param(LAST, 1e-2, 1.0, "m/s", f"v_{{{n}}}", True, 1.0, "speed of the last knot"),
        ),
        slip=_slip_of(n),
        doc=f"a free curve: levels at {n} speeds, straight lines between them",
        formula=f"F = F_i + (F_i+1 − F_i) (|v| − v_i)/(v_i+1 − v_i), sgn v,  v_1 … v_{n} spaced by "
        "their logarithm,  F_1 below and "
        f"F_{n} above them",
        cite="knots and their prior: G. Wahba (1983), doi 10.1111/j.2517-6161.1983.tb01239.x",
        linear=tuple(f"F_{i}" for i in range(1, n + 1)),
        physical=lambda p: np.all(p[:, :n] >= 0, axis=1) & (p[:, n + 1] > p[:, n]),
        roughness=partial(roughness, n=n, tables=1),
    )


@cache
def curve_directional(n: int) -> Law:
    """The law with n knots and a table of its own for each direction."""
    name = "curve-directional" if n == KNOTS else f"curve-directional:{n}"
    return by_direction(
        curve(n), _slip_directional_of(n), name=name,
        roughness=partial(roughness, n=n, tables=2),
    )  # fmt: skip


CURVE = curve(KNOTS)
CURVE_DIRECTIONAL = curve_directional(KNOTS)
