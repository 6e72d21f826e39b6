"""Bacterial foraging: Passino's (2002), and with the adaptive step of the paper."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from ..space import Array, Rng, Space
from .hyperparameters import choice, even, number, positive, whole
from .moves import Moves, Note
from .unit_cube import Coordinates, Walls, inside, squares, widths


@dataclass(frozen=True, kw_only=True)
class Chemotaxis(ABC):
    """How a swarm of cells moves: Steps 3 to 5 of the paper's section 2.3.

    All cells tumble together and then swim together, each as far as it improves. The signals
    J_cc a cell compares come from the swarm as it stood when the chemotactic step began, with
    the cell's own member where the cell is now; J_cc enters that comparison (and a cell's
    health) and nothing else.

    Args:
        S: Cells.
        N_c: Chemotactic steps of a lifetime.
        N_s: Longest swim, in steps after the tumble.
        d_attract: Depth of the attractant a cell releases.
        w_attract: Width of its signal: the rate of decay with squared distance.
        h_repellant: Height of its repellent.
        w_repellant: Width of that signal.
        improve: Which cost counts as improved: "<" J_last (Step 5) or "<=" (section 4.4).
        swim: Whether a swim ends at the first failure, which is kept ("stop"), or takes N_s
            steps in any case ("always", a reading of section 4.4).
        walls: What happens to a step out of the range: "clip" to it, or "reflect".
        coordinates: Whether step lengths and the distances of J_cc are fractions of the range
            ("unit") or "raw" values.
    """

    S: int = 30
    N_c: int = 20
    N_s: int = 4
    d_attract: float = 0.1
    w_attract: float = 0.2
    h_repellant: float = 0.1
    w_repellant: float = 0.1
    improve: Literal["<", "<="] = "<"
    swim: Literal["stop", "always"] = "stop"
    walls: Walls = "clip"
    coordinates: Coordinates = "unit"

    def __post_init__(self) -> None:
        whole(self, 1, "S", "N_c")
        whole(self, 0, "N_s")
        number(self, "d_attract", "w_attract", "h_repellant", "w_repellant", low=0.0)
        choice(self, "improve", "<", "<=")
        choice(self, "swim", "stop", "always")
        choice(self, "walls", "clip", "reflect")
        choice(self, "coordinates", "unit", "raw")

    @abstractmethod
    def step_length(self, J: Array, J_first: Array) -> Array:
        """C(i, j) of each cell, shape (S,), from its cost J(i, j) and the first swarm's."""

    def chemotaxis(
        self, theta: Array, J: Array, C: Array, width: Array, rng: Rng, note: Note
    ) -> Moves[tuple[Array, Array, Array]]:
        """One chemotactic step of all cells: a tumble, then swims. Steps 3 to 5.

        Args:
            theta: The cells' places in the unit cube, shape (S, p).
            J: Their costs, without J_cc, shape (S,).
            C: Their step lengths, shape (S,).
            width: Length of each side of the cube, see `cube.widths`.
            rng: Source of the tumbles.
            note: Takes what every batch asks for.

        Returns:
            Their new places, costs without J_cc, and costs with it, equation (2.1).
        """
        swarm, cells = theta, np.arange(len(theta))

        # Step 4: tumble in a random direction, equation (2.3). This step is always taken.
        Delta = rng.uniform(-1.0, 1.0, theta.shape)
        step = (C / np.sqrt((Delta**2).sum(axis=1)))[:, None] * Delta / width
        tumbled = inside(theta + step, self.walls)

        # Step 3: J(i, j) = J(i, j) + J_cc, equation (2.1), before the tumble and after it; the
        # signals of both places in one call.
        pairs = np.concatenate([theta, tumbled]), np.concatenate([cells, cells])
        J_cc = self.J_cc(*pairs, swarm, width)
        J_last = J + J_cc[: len(cells)]
        theta, J = tumbled, (yield tumbled)
        J_next = J + J_cc[len(cells) :]

        # Step 5: swim on in the same direction while that improves, N_s times at most.
        for _ in range(self.N_s):
            if self.swim == "stop":  # a cell that has stopped fails this test ever after
                fit = J_next < J_last if self.improve == "<" else J_next <= J_last
                cells = fit.nonzero()[0]
            if not len(cells):
                break
            np.minimum(J_last, J_next, out=J_last)
            swum = inside(theta.take(cells, axis=0) + step.take(cells, axis=0), self.walls)
            note(stage="foraging", event="swim")
            costs = yield swum
            theta[cells], J[cells] = swum, costs
            J_next[cells] = costs + self.J_cc(swum, cells, swarm, width)
        return theta, J, J_next

    def J_cc(self, theta: Array, cells: NDArray[np.intp], swarm: Array, width: Array) -> Array:
        """Cell-to-cell signals, equation (2.1), summed over the swarm, the cell included.

        Args:
            theta: Places, shape (n, p).
            cells: Which cells of the swarm they are, shape (n,).
            swarm: The places of all cells, shape (S, p).
            width: Length of each side of the cube.
        """
        if not (self.d_attract or self.h_repellant):
            return np.zeros(len(theta))
        raw = self.coordinates == "raw"  # otherwise every side is 1
        distance2 = squares(theta * width, swarm * width) if raw else squares(theta, swarm)
        if theta is not swarm:  # its own member moves with it
            distance2[np.arange(len(cells)), cells] = 0.0
        attract = distance2 * -self.w_attract  # in place: these are the search's largest arrays
        np.exp(attract, out=attract)
        attract *= self.d_attract
        repel = np.multiply(distance2, -self.w_repellant, out=distance2)
        np.exp(repel, out=repel)
        repel *= self.h_repellant
        repel -= attract
        J_cc: Array = repel.sum(axis=1)
        return J_cc


@dataclass(frozen=True, kw_only=True)
class AdaptiveChemotaxis(Chemotaxis):
    """Chemotaxis with the step of equation (2.2): long where the cost is high.

    The other settings are explained at `Chemotaxis`.

    Args:
        alpha: The cost at which a step is half its longest. None takes the (upper) median of
            the first swarm, which does not depend on the unit of the cost.
        J_target: The cost aimed at: (2.2) as printed has 0, the text "a large deviation of
            the cost value from the targeted one".
        step: The longest step. (2.2) as printed has 1.
    """

    alpha: float | None = 1e3
    J_target: float = 0.0
    step: float = 1.0

    def __post_init__(self) -> None:
        super().__post_init__()
        positive(self, "step", *(["alpha"] if self.alpha is not None else []))
        number(self, "J_target")

    def step_length(self, J: Array, J_first: Array) -> Array:
        """Equation (2.2), its second form: it also holds for a cell that cannot be run."""
        alpha = self.alpha if self.alpha is not None else self._median(J_first)
        with np.errstate(divide="ignore"):  # at the target the step is zero
            C: Array = self.step / (1.0 + alpha / np.abs(J - self.J_target))
        return C

    def _median(self, J_first: Array) -> float:
        runs = np.sort(np.abs(J_first[np.isfinite(J_first)] - self.J_target))
        return float(runs[len(runs) // 2]) or 1.0 if len(runs) else 1.0


@dataclass(frozen=True, kw_only=True)
class BacterialForaging(Chemotaxis):
    """Bacterial foraging optimization with the constants of Passino (2002).

    The other settings are explained at `Chemotaxis`.

    Args:
        C: Length of a step.
        N_re: Reproductions.
        N_ed: Elimination-dispersal events.
        P_ed: Probability with which an event disperses a cell.
    """

    name: ClassVar[str] = "bfo"
    S: int = 50
    N_c: int = 100
    w_repellant: float = 10.0
    C: float = 0.1
    N_re: int = 4
    N_ed: int = 2
    P_ed: float = 0.25

    def __post_init__(self) -> None:
        super().__post_init__()
        positive(self, "C")
        _check_life(self)

    def step_length(self, J: Array, J_first: Array) -> Array:
        """The same for every cell."""
        del J_first
        return np.full(len(J), self.C)

    def moves(self, space: Space, rng: Rng, note: Note) -> Moves[str | None]:
        """Yield the first swarm, then its steps through all lifetimes and events."""
        return live(self, self.N_re, self.N_ed, self.P_ed, space, rng, note)


@dataclass(frozen=True, kw_only=True)
class AdaptiveForaging(AdaptiveChemotaxis):
    """Adaptive bacterial foraging optimization, the paper's section 2.2.

    The other settings are explained at `AdaptiveChemotaxis` and `Chemotaxis`.

    Args:
        N_re: Reproductions.
        N_ed: Elimination-dispersal events.
        P_ed: Probability with which an event disperses a cell.
    """

    name: ClassVar[str] = "abfo"
    N_re: int = 4
    N_ed: int = 2
    P_ed: float = 0.25

    def __post_init__(self) -> None:
        super().__post_init__()
        _check_life(self)

    def moves(self, space: Space, rng: Rng, note: Note) -> Moves[str | None]:
        """Yield the first swarm, then its steps through all lifetimes and events."""
        return live(self, self.N_re, self.N_ed, self.P_ed, space, rng, note)


def live(
    swarm: Chemotaxis, N_re: int, N_ed: int, P_ed: float, space: Space, rng: Rng, note: Note
) -> Moves[str | None]:
    """Chemotaxis within reproduction within elimination and dispersal (Passino, 2002).

    Health is a cell's sum of J(i, j), J_cc included, over its lifetime: where it was born and
    where each of its N_c steps ended, j = 1 to N_c + 1. The healthier half
    splits in place, the others die. Dispersal takes any cell, with probability P_ed: the
    paper's "the healthy ones are dispersed" departs from its own source.
    """
    width, count = widths(space, swarm.coordinates), 0
    theta = space.sample(rng, swarm.S)
    J = J_first = yield theta
    J_first = J_first.copy()
    for _ in range(N_ed):
        for _ in range(N_re):
            health = J + swarm.J_cc(theta, np.arange(swarm.S), theta, width)
            for _ in range(swarm.N_c):
                count += 1
                note(stage="foraging", round=count)
                C = swarm.step_length(J, J_first)
                theta, J, J_next = yield from swarm.chemotaxis(theta, J, C, width, rng, note)
                with np.errstate(over="ignore"):  # a penalty near the largest float
                    health += J_next
            healthiest = np.argsort(health, kind="stable")[: swarm.S // 2]  # S_r = S/2
            theta, J = np.tile(theta[healthiest], (2, 1)), np.tile(J[healthiest], 2)
            note(event="reproduction")
        gone = rng.random(swarm.S) < P_ed
        if gone.any():
            theta[gone] = space.sample(rng, int(gone.sum()))
            note(stage="foraging", event="dispersal")
            J[gone] = yield theta[gone]
    return "N_ed"


def _check_life(cells: BacterialForaging | AdaptiveForaging) -> None:
    whole(cells, 1, "N_re", "N_ed")
    number(cells, "P_ed", low=0.0, high=1.0)
    even(cells, "S")  # half of the cells split
