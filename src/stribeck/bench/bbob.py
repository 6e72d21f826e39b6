"""The 24 noiseless functions of the BBOB suite of the COCO platform, as problems.

A function is evaluated through COCO's bare form, which takes many points at once and gives the
same bits as the suite's problems.

Hansen, Auger, Ros, Mersmann, Tušar, Brockhoff (2021): COCO: a platform for comparing continuous
optimizers in a black-box setting, doi:10.1080/10556788.2020.1808977.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import cached_property
from operator import index
from types import ModuleType
from typing import Any

import numpy as np

from ..errors import InputError
from ..space import Array, Space, box

#: The suite's names of its groups, in its order.
GROUPS = (
    "separable",
    "low or moderate conditioning",
    "high conditioning, unimodal",
    "multi-modal, adequate structure",
    "multi-modal, weak structure",
)
#: The suite's dimensions.
DIMENSIONS = (2, 3, 5, 10, 20, 40)
#: The instances that may be asked for: the suite makes one for every number.
INSTANCES = range(1, 10_000)
#: How far above the minimum a function counts as solved: the suite's last target.
PRECISION = 1e-8


@dataclass(frozen=True)
class Function:
    """What a function of the suite is called.

    Args:
        title: Its name.
        group: One of GROUPS.
    """

    title: str
    group: str


def _functions(*groups: tuple[str, ...]) -> dict[int, Function]:
    named = [Function(t, g) for g, titles in zip(GROUPS, groups, strict=True) for t in titles]
    return dict(enumerate(named, 1))


#: The 24 functions by their number (Finck, Hansen, Ros, Auger 2009, INRIA RR-6829).
FUNCTIONS = _functions(
    ("Sphere", "Ellipsoid", "Rastrigin", "Büche-Rastrigin", "Linear slope"),
    ("Attractive sector", "Step ellipsoid", "Rosenbrock", "Rosenbrock, rotated"),
    ("Ellipsoid, rotated", "Discus", "Bent cigar", "Sharp ridge", "Different powers"),
    (
        "Rastrigin, rotated",
        "Weierstrass",
        "Schaffers F7",
        "Schaffers F7, ill-conditioned",
        "Griewank-Rosenbrock",
    ),
    ("Schwefel", "Gallagher, 101 peaks", "Gallagher, 21 peaks", "Katsuura", "Lunacek bi-Rastrigin"),
)


@dataclass(frozen=True, eq=False)
class Bbob:
    """A function of the suite in one dimension and instance; a Problem that knows its answer.

    Args:
        function: Its number, 1 to 24.
        dim: Number of variables.
        instance: Which shift and rotation of it.
        minimum: The least value.
        evaluate: (n, dim) points to (n,) values.
    """

    function: int
    dim: int
    instance: int
    minimum: float
    evaluate: Callable[[Array], Array] = field(repr=False)

    @property
    def name(self) -> str:
        """Such as "f01-d2-i1"."""
        return f"f{self.function:02d}-d{self.dim}-i{self.instance}"

    @property
    def title(self) -> str:
        """Its name in words."""
        return FUNCTIONS[self.function].title

    @property
    def J_min(self) -> float:
        """The value at or below which it counts as solved."""
        return self.minimum + PRECISION

    @cached_property
    def space(self) -> Space:
        """The suite's region of interest, [-5, 5] in every coordinate."""
        return box([(-5.0, 5.0)] * self.dim)

    def __call__(self, x: Array, /) -> Array:
        """(n, dim) points to (n,) values; rows are independent, bit for bit."""
        return self.evaluate(np.ascontiguousarray(x, dtype=float))


def bbob(function: int, dim: int, instance: int) -> Bbob:
    """A function of the suite.

    Args:
        function: Its number, 1 to 24: see FUNCTIONS.
        dim: One of DIMENSIONS.
        instance: Which shift and rotation of it, one of INSTANCES.

    Raises:
        InputError: there is no such function, or coco-experiment is not installed.
    """
    # COCO ends the process where it is asked for what it does not have.
    function = _one_of("function", function, FUNCTIONS, "1 to 24")
    dim = _one_of("dimension", dim, DIMENSIONS, ", ".join(map(str, DIMENSIONS)))
    instance = _one_of("instance", instance, INSTANCES, f"1 to {INSTANCES[-1]}")
    bare = cocoex().BareProblem("bbob", function, dim, instance)
    return Bbob(function, dim, instance, float(bare.best_value()), bare)


def _one_of(noun: str, value: Any, allowed: Iterable[int], shown: str) -> int:
    try:
        number = index(value)
    except TypeError:
        number = -1
    if number not in allowed:
        raise InputError(f"BBOB has no {noun} {value!r}: it has {shown}")
    return number


def cocoex() -> ModuleType:
    """COCO's own library, which is an extra.

    Raises:
        InputError: it is not installed.
    """
    try:
        return importlib.import_module("cocoex")
    except ImportError:
        raise InputError(
            "coco-experiment is not installed: pip install 'stribeck[bench]'"
        ) from None
