"""Bacterial foraging-tabu search (BTS): the paper's section 2.3, step by step."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite
from typing import ClassVar, Literal

from ..space import Rng, Space
from .foraging import AdaptiveChemotaxis
from .hyperparameters import choice
from .moves import Moves, Note, best_of
from .tabu import AdaptiveTabuSearch
from .unit_cube import widths


@dataclass(frozen=True, kw_only=True)
class ForagingTabuSearch(AdaptiveChemotaxis, AdaptiveTabuSearch):
    """Bacteria find an elite initial solution; adaptive tabu search tracks the minimum down.

    Sarasiri, Suthamno, Sujitjorn (2012), doi 10.1155/2012/238563. Its procedural list:

        1      search parameters                            the settings below
        2      S initial solutions                          forage
        3      J + J_cc                        (2.1)        chemotaxis, J_cc    in foraging.py
        4      tumble by C Delta/|Delta|  (2.2) (2.3)       step_length, chemotaxis
        5      swim while J falls, N_s times                chemotaxis
        6      N_c times Steps 3 to 5                       forage
        7      S0 is the place of the least J               moves
        8-10   N neighbours within R, the best, the TL      refine              in tabu.py
        11     BT: back into the TL on a deadlock  (Alg. 1) refine
        12     end on J or count_max                        a Target; refine
        13     AR: a smaller R near a minimum      (Alg. 2) radius
        14     count, and back to Step 8                    refine

    There is no reproduction (section 2.3 says why) and no elimination. The defaults are those of
    section 4.4, with lengths as fractions of the search ranges. The settings of the foraging
    stage are explained at `AdaptiveChemotaxis` and `Chemotaxis`, those of the tabu stage at
    `AdaptiveTabuSearch`.

    Args:
        start: Where the cells start in Step 2: "spread" over the search space, or all at the
            "best" of S random places.
    """

    name: ClassVar[str] = "bts"
    start: Literal["spread", "best"] = "spread"

    def __post_init__(self) -> None:
        AdaptiveChemotaxis.__post_init__(self)
        AdaptiveTabuSearch.__post_init__(self)
        choice(self, "start", "spread", "best")

    def moves(self, space: Space, rng: Rng, note: Note) -> Moves[str | None]:
        """Yield the cells' places, then the neighbourhoods of tabu search."""
        count = 0
        while count != self.count_max:
            # Step 7: S0 is best_theta, the place of the least J (raw, without J_cc) so far.
            S0, J0 = yield from best_of(self.forage(space, rng, note))
            if not isfinite(J0):
                continue  # no cell met a place that can be run: none of them is a solution
            note(event="hand-over")
            # Steps 8 to 14. With deadlock="restart" it comes back for another foraging stage.
            count = yield from self.refine(S0, J0, count, space, rng, note)
        return "count_max"

    def forage(self, space: Space, rng: Rng, note: Note) -> Moves[None]:
        """Steps 2 to 6: S cells take N_c chemotactic steps."""
        width = widths(space, self.coordinates)

        # Step 2: S solutions at random.
        note(stage="foraging", start=True)
        theta = space.sample(rng, self.S)
        J = yield theta
        J_first = J.copy()
        if self.start == "best":
            k = J.argmin()
            theta[:], J[:] = theta[k], J[k]

        for j in range(1, self.N_c + 1):  # Step 6
            note(stage="foraging", round=j)
            # Steps 3 to 5, equations (2.1) and (2.3), with the adaptive step C(i, j) of (2.2).
            C = self.step_length(J, J_first)
            theta, J, _ = yield from self.chemotaxis(theta, J, C, width, rng, note)
