"""The table of methods, and the one call that minimises a function with any of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import Any

from numpy.random import SeedSequence

from ..errors import InputError
from ..space import Array, Space, box
from .bts import ForagingTabuSearch
from .foraging import AdaptiveForaging, BacterialForaging
from .genetic import GeneticAlgorithm
from .lockstep import lockstep
from .mbts import MemeticTabuSearch
from .random_search import RandomSearch
from .search import Algorithm, Run, Search, Stop
from .stops import Target
from .tabu import AdaptiveTabuSearch, TabuSearch

METHODS: dict[str, type[Algorithm]] = {
    cls.name: cls
    for cls in (
        RandomSearch,
        TabuSearch,
        AdaptiveTabuSearch,
        BacterialForaging,
        AdaptiveForaging,
        GeneticAlgorithm,
        ForagingTabuSearch,
        MemeticTabuSearch,
    )
}


def configure(method: str, /, **settings: Any) -> Algorithm:
    """A method by its name in METHODS, with its settings.

    Raises:
        InputError: there is no such method or setting, or a setting cannot be used.
    """
    if method not in METHODS:
        raise InputError(f"no method {method!r}: there are {', '.join(METHODS)}")
    kind: Any = METHODS[method]
    names = [f.name for f in fields(kind)]
    for name in settings:
        if name not in names:
            raise InputError(f"{method} has no setting {name!r}: it has {', '.join(names)}")
    algorithm: Algorithm = kind(**settings)
    return algorithm


#: Readings that do not depend on the unit of the cost, and the settings whose place they take:
#: stages that begin with a deadlock, a swarm whose step is scaled by its own first costs.
UNIT_FREE: tuple[tuple[dict[str, Any], frozenset[str]], ...] = (
    ({"AR_by": "deadlock"}, frozenset({"AR", "AR_by", "radius_from"})),
    (
        {"alpha": None, "step": 0.1, "d_attract": 0.0, "h_repellant": 0.0},
        frozenset(
            {"alpha", "step", "J_target", "coordinates"}
            | {"d_attract", "w_attract", "h_repellant", "w_repellant"}
        ),
    ),
)


def unit_free(method: str, settings: Mapping[str, Any]) -> dict[str, Any]:
    """Settings, with the readings of UNIT_FREE for the groups of which nothing was given."""
    names = {f.name for f in fields(METHODS[method])} if method in METHODS else set()  # type: ignore[arg-type]
    chosen = dict(settings)
    for reading, group in UNIT_FREE:
        if set(reading) <= names and not group & set(settings):
            chosen |= reading
    return chosen


def minimize(
    cost: Callable[[Array], Array],
    bounds: Space | Array | Sequence[tuple[float, float]],
    *,
    method: str = "mbts",
    budget: int = 10_000,
    target: float | None = None,
    seed: int | SeedSequence = 0,
    stops: Sequence[Stop] = (),
    **settings: Any,
) -> Run:
    """Search for the least cost over a box.

    Some of the paper's constants are costs of its own problem, in mm: the AR stages of `ats`,
    alpha and the signals of `abfo`; `bts` has them all. Here, where nobody knows the unit of the
    cost, the readings in UNIT_FREE take their place, group by group, unless a setting of that
    group is given; `configure(method)` is the method as the paper has it.

    Args:
        cost: (n, dim) values to (n,) costs; rows are independent. What is not finite counts
            as worst. If it has a method `residuals`, (n, dim) values to (n, m), whose root mean
            squares the costs are, `mbts` uses them: a sum of squares is quicker found.
        bounds: A Space, or one (lower, upper) pair a dimension.
        method: A name in METHODS.
        budget: Evaluations (rows) that may be spent.
        target: End when a cost is at or below it.
        seed: Seed of the search.
        stops: Other reasons to end.
        settings: Hyper-parameters of the method.

    Raises:
        InputError: the method, a setting, the bounds or the cost's answer cannot be used.
    """
    space = box(bounds)  # type: ignore[arg-type]
    algorithm = configure(method, **unit_free(method, settings))
    if target is not None:
        stops = [Target(target), *stops]
    search = Search(space, algorithm, budget=budget, seed=seed, stops=stops)
    shown = getattr(cost, "residuals", None)
    problem = _Cost(space, cost) if shown is None else _Squares(space, cost, shown)
    return lockstep(problem, [search])[0]


@dataclass(frozen=True)
class _Cost:
    """A plain function as a problem."""

    space: Space
    function: Callable[[Array], Array]
    name: str = field(default="cost", kw_only=True)

    def __call__(self, x: Array, /) -> Array:
        return self.function(x)


@dataclass(frozen=True)
class _Squares(_Cost):
    """The same with residuals."""

    shown: Callable[[Array], Array]

    def residuals(self, x: Array, /) -> Array:
        return self.shown(x)
