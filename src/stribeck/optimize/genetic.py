"""A real-coded genetic algorithm with the operators of the MATLAB toolbox the paper used."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from ..space import Array, Rng, Space
from .hyperparameters import choice, number, positive, whole
from .moves import Moves, Note
from .unit_cube import Walls, inside

#: How far heuristic crossover goes from the worse parent, in ways to the better one.
HEURISTIC = 1.2


@dataclass(frozen=True, kw_only=True)
class GeneticAlgorithm:
    """Elites stay; the others are children by scattered crossover or Gaussian mutation.

    The paper names "MATLAB-GA Toolbox" and no settings, so these are the defaults of its
    period: rank scaling, stochastic uniform selection, scattered crossover, and a mutation
    whose spread shrinks linearly to zero over `generations`. There the run ends; here a new
    population is drawn and a new run begins (event "restart"), so that any budget is used.

    Args:
        population: Individuals.
        elite: Best individuals that live on unchanged; they are not evaluated again.
        crossover: Share of the other children made by crossover; mutation makes the rest.
        scale: Standard deviation of a mutation in the first generation, of the range.
        shrink: Share of `scale` that is gone after `generations`.
        generations: Generations of a run.
        crossing: How a child comes of two parents: "scattered", each gene from one or the other;
            "intermediate", a random place between them; "heuristic", beyond the better one by a
            fifth of the way from the worse.
        first: Where the first individuals are drawn: in the "range", or between 0 and 1 in every
            coordinate ("unit"), the toolbox's default where nobody sets it. A mutation's `scale`
            is of the same.
        walls: What happens to a mutant outside the range: "clip" to it, or "reflect".
    """

    name: ClassVar[str] = "ga"
    population: int = 20
    elite: int = 2
    crossover: float = 0.8
    scale: float = 1.0
    shrink: float = 1.0
    generations: int = 100
    crossing: Literal["scattered", "intermediate", "heuristic"] = "scattered"
    first: Literal["range", "unit"] = "range"
    walls: Walls = "clip"

    def __post_init__(self) -> None:
        whole(self, 2, "population")
        whole(self, 0, "elite")
        whole(self, 1, "generations")
        number(self, "elite", high=self.population - 1)
        number(self, "crossover", "shrink", low=0.0, high=1.0)
        positive(self, "scale")
        choice(self, "crossing", "scattered", "intermediate", "heuristic")
        choice(self, "first", "range", "unit")
        choice(self, "walls", "clip", "reflect")

    def moves(self, space: Space, rng: Rng, note: Note) -> Moves[str | None]:
        """Yield the first population, then each generation's children."""
        low, width = self._first(space)
        while True:
            alive = low + width * space.sample(rng, self.population)
            costs = yield alive
            for generation in range(1, self.generations + 1):
                best = costs.argsort(kind="stable")[: self.elite]
                elite, elite_costs = alive.take(best, axis=0), costs.take(best)
                note(round=generation)
                children = self.children(alive, costs, generation, rng, width)
                alive = np.concatenate([elite, children])
                costs = np.concatenate([elite_costs, (yield children)])
            note(event="restart")

    def _first(self, space: Space) -> tuple[Array, Array]:
        """The least corner of the box of the first individuals in the cube, and its sides."""
        corners = np.array([[0.0], [1.0]]) * np.ones(space.dim)
        if self.first == "unit":
            corners = space.encode(np.clip(corners, space.lower, space.upper))
        return corners[0], corners[1] - corners[0]

    def children(
        self, alive: Array, costs: Array, generation: int, rng: Rng, width: Array | float = 1.0
    ) -> Array:
        """The generation's new individuals, shape (population - elite, dim)."""
        n = self.population - self.elite
        crossed = round(self.crossover * n)
        drawn = stochastic_uniform(expectation(costs), 2 * crossed + (n - crossed), rng)
        parents = alive.take(drawn, axis=0)
        mother, father = parents[:crossed], parents[crossed : 2 * crossed]
        spread = self.scale * (1.0 - self.shrink * generation / self.generations)
        mutant = parents[2 * crossed :]
        mutant += spread * width * rng.standard_normal(mutant.shape)
        if self.crossing == "scattered":
            crossbred = scattered(mother, father, rng)
        elif self.crossing == "intermediate":
            crossbred = mother + rng.random((crossed, 1)) * (father - mother)
        else:
            of_parents = costs.take(drawn)
            better = (of_parents[:crossed] <= of_parents[crossed : 2 * crossed])[:, None]
            best, worst = np.where(better, mother, father), np.where(better, father, mother)
            crossbred = inside(worst + HEURISTIC * (best - worst), self.walls)
        return np.concatenate([crossbred, inside(mutant, self.walls)])


def expectation(costs: Array) -> Array:
    """Each individual's share of parenthood: 1/sqrt(rank), the cheapest ranks first."""
    share = np.empty(len(costs))
    share[costs.argsort(kind="stable")] = 1.0 / np.sqrt(np.arange(1, len(costs) + 1))
    expected: Array = share / share.sum()
    return expected


def stochastic_uniform(share: Array, n: int, rng: Rng) -> NDArray[np.intp]:
    """`n` parents at even paces along a line on which each individual owns its share.

    One random start serves all, so an individual is drawn floor or ceil of `n` times its share.
    """
    paces = (rng.random() + np.arange(n)) / n
    drawn = share.cumsum().searchsorted(paces, side="right")
    return rng.permutation(np.minimum(drawn, len(share) - 1))


def scattered(mother: Array, father: Array, rng: Rng) -> Array:
    """Children that take each gene from one parent or the other, by a fair coin."""
    return np.where(rng.random(mother.shape) < 0.5, mother, father)  # noqa: PLR2004
