"""The paper's five test surfaces (Table 1) and its search settings for them (Tables 2 and 3)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..space import Array, Space, box


@dataclass(frozen=True)
class Surface:
    """A test function of two variables on a square box; a Problem that knows its answer.

    Args:
        name: The paper's abbreviation.
        title: Its full name.
        half: The box is [-half, half] in both coordinates.
        J_min: The cost at or below which the paper ends a search.
        minimum: The least value.
        optima: Where it is taken, shape (k, 2).
        function: (n,) and (n,) coordinates to (n,) values.
        settings: The paper's hyper-parameters by method, for `METHODS[method](**settings)`.
    """

    name: str
    title: str
    half: float
    J_min: float
    minimum: float
    optima: tuple[tuple[float, float], ...] = field(repr=False)
    function: Callable[[Array, Array], Array] = field(repr=False)
    settings: dict[str, dict[str, Any]] = field(repr=False, hash=False)

    @property
    def space(self) -> Space:
        """The search space of Table 1."""
        return box([(-self.half, self.half)] * 2)

    def __call__(self, x: Array, /) -> Array:
        """(n, 2) points to (n,) values; rows are independent, bit for bit."""
        x1, x2 = np.ascontiguousarray(x.T)
        return self.function(x1, x2)


def bohachevsky(x: Array, y: Array) -> Array:
    """BF of Table 1."""
    waves = 0.3 * np.cos(3 * np.pi * x) + 0.4 * np.cos(4 * np.pi * y)
    cost: Array = x**2 + 2 * y**2 - waves + 0.7
    return cost


def rastrigin(x: Array, y: Array) -> Array:
    """RF of Table 1."""
    waves = 10 * np.cos(2 * np.pi * x) + 10 * np.cos(2 * np.pi * y)
    cost: Array = x**2 + y**2 - waves + 20
    return cost


# Table 1's matrix a_ij: the holes of the second row follow one another along the first.
_HOLES = np.array([(a1, a2) for a2 in range(-32, 33, 16) for a1 in range(-32, 33, 16)], dtype=float)


def foxholes(x: Array, y: Array) -> Array:
    """Shekel's foxholes, SF of Table 1."""
    j = np.arange(1, 26)
    sixth = (x[:, None] - _HOLES[:, 0]) ** 6 + (y[:, None] - _HOLES[:, 1]) ** 6
    holes: Array = (1.0 / (j + sixth)).sum(axis=1)
    return 1.0 / (1.0 / 500.0 + holes)


def schwefel(x: Array, y: Array) -> Array:
    """SchF of Table 1, with the |x| that its print lost: sin sqrt|x|."""
    return 418.9829 * 2 - x * np.sin(np.sqrt(np.abs(x))) - y * np.sin(np.sqrt(np.abs(y)))


def shubert(x: Array, y: Array) -> Array:
    """ShuF of Table 1."""
    return _shubert(x) * _shubert(y)


def _shubert(x: Array) -> Array:
    return sum((i * np.cos((i + 1) * x + i) for i in range(2, 6)), start=np.cos(2 * x + 1))


def _paper(
    N_c: int, alpha: float, w_repellant: float, R: float, *stages: tuple[float, float]
) -> dict[str, dict[str, Any]]:
    """A row of Table 3 and a row of Table 2 as settings of the three methods.

    Their lengths R and C are in the units of the function, hence `coordinates="raw"`: the
    printed numbers stand as they are, and J_cc's widths need no conversion either.
    """
    tabu = {"N": 30, "R": R, "BT": 5, "n_re_back": 5, "AR": stages, "count_max": 10_000}
    swarm = {"S": 30, "N_s": 4, "alpha": alpha, "w_repellant": w_repellant}
    swarm |= {"d_attract": 0.1, "h_repellant": 0.1, "w_attract": 0.2}
    life = {"N_c": N_c, "N_re": 4, "N_ed": 2, "P_ed": 0.25}
    raw = {"coordinates": "raw"}
    return {
        "ats": tabu | raw,
        "abfo": swarm | life | raw,
        "bts": swarm | {"N_c": 20} | tabu | raw,  # "with N_c = 20, in particular" (section 3)
    }


# The first coordinate takes Shubert's one-dimensional sum to its largest value and the second to
# its least, or the other way round; both repeat every 2 pi.
_HIGH = [-0.8003211004719731 + 2 * np.pi * k for k in (-1, 0, 1)]
_LOW = [-1.425128428319761 + 2 * np.pi * k for k in (-1, 0, 1)]
_SHUBERT = tuple(p for a in _HIGH for b in _LOW for p in ((a, b), (b, a)))

SURFACES: dict[str, Surface] = {
    s.name: s
    for s in (
        Surface(
            "BF",
            "Bohachevsky",
            half=2.0,
            J_min=1e-9,
            minimum=0.0,
            optima=((0.0, 0.0),),
            function=bohachevsky,
            # Inferred: Table 2's row is lost after count_max. Same box and kind of J_min as RF.
            settings=_paper(20, 10.0, 1.0, 0.2, (0.1, 2e-3), (1e-3, 2e-4)),
        ),
        Surface(
            "RF",
            "Rastrigin",
            half=2.0,
            J_min=1e-8,
            minimum=0.0,
            optima=((0.0, 0.0),),
            function=rastrigin,
            # Inferred: Table 2 prints the radii, the costs below which they hold are lost.
            settings=_paper(200, 100.0, 1.0, 0.2, (0.1, 2e-3), (1e-3, 2e-4)),
        ),
        Surface(
            "SF",
            "Shekel's foxholes",
            half=40.0,
            J_min=0.9990,
            minimum=0.9980038377944496,
            optima=((-31.97833, -31.97833),),
            function=foxholes,
            settings=_paper(500, 0.01, 10.0, 0.8, (5.0, 0.5), (2.0, 0.1)),
        ),
        Surface(
            "SchF",
            "Schwefel",
            half=500.0,
            J_min=1e-1,
            minimum=2.5455132458773733e-05,
            optima=((420.9687463599821, 420.9687463599821),),
            function=schwefel,
            settings=_paper(2000, 1.0, 10.0, 50.0, (100.0, 25.0), (10.0, 10.0), (1.0, 1.0)),
        ),
        Surface(
            "ShuF",
            "Shubert",
            half=10.0,
            J_min=-186.73,
            minimum=-186.7309088310240,
            optima=_SHUBERT,
            function=shubert,
            settings=_paper(1000, 1.0, 10.0, 1.0, (1.0, 1e-2), (-1.0, 1e-3)),
        ),
    )
}
