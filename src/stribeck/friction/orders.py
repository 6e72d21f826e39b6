"""Order relations of a law, such as F_S >= F_C, as pairs of parameters."""

from __future__ import annotations

from itertools import permutations

import numpy as np

from ..space import Array
from .law import Law

#: Parameter i may not fall below parameter j.
Order = tuple[int, int]


def orders(law: Law, *, nonlinear: bool = False) -> list[Order]:
    """The pairs (i, j) of parameters for which `law.physical` demands p_i >= p_j.

    Asked of the law itself: with all levels equal it must hold, with p_j raised it must not, and
    with p_i raised too it must hold again.

    Args:
        law: The law.
        nonlinear: Whether parameters that the law is not linear in are asked about, too.
    """
    p = np.array([0.5 * (q.lower + q.upper) if q.fixed is None else q.fixed for q in law.params])
    own = law.params[: len(law.params) - sum(law.sizes)]  # terms are in no order
    among = [i for i, q in enumerate(own) if nonlinear or q.name in law.linear]
    for unit in {law.params[i].unit for i in among}:
        same_unit = [i for i in among if law.params[i].unit == unit]
        p[same_unit] = min(p[same_unit])
    if not _holds(law, p):
        return []
    return [
        (i, j)
        for i, j in permutations(among, 2)
        if law.params[i].unit == law.params[j].unit
        and not _holds(law, _raised(p, j))
        and _holds(law, _raised(p, i, j))
    ]


def _holds(law: Law, p: Array) -> bool:
    return bool(np.all(law.physical(p[None])))


def _raised(p: Array, *at: int) -> Array:
    q = p.copy()
    q[list(at)] *= 1.01
    return q
