"""Whole traces of the bacteria and of tabu search, worked out by hand, line by line.

The equations are those of the paper (doi 10.1155/2012/238563), section 2: J_cc (2.1), the step
C = |J|/(|J| + alpha) (2.2), the tumble theta + C Delta/|Delta| (2.3), Algorithm 1 (BT) and
Algorithm 2 (AR). Every cost is J = x^2 + 2 y^2 of the point. Lengths are "raw", and the
numbers of the random generator are written down: directions are 3-4-5 triangles, so that
Delta/|Delta| is (0.6, 0.8) and the like, and each line needs a pocket calculator at most.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, cast

import numpy as np
import pytest

from stribeck.optimize import (
    AdaptiveForaging,
    AdaptiveTabuSearch,
    BacterialForaging,
    ForagingTabuSearch,
    Search,
    TabuSearch,
)
from stribeck.space import box

if TYPE_CHECKING:
    from stribeck.optimize import Algorithm, Moves, Note
    from stribeck.space import Array, Rng, Space

Points = list[tuple[float, float]]


class ScriptedGenerator:
    """A random generator that returns given numbers of [0, 1], one array a call."""

    def __init__(self, *draws: Any) -> None:
        self.draws = [np.array(d, dtype=float) for d in draws]

    def random(self, shape: int | tuple[int, ...]) -> Array:
        unit_draws = self.draws.pop(0)
        assert unit_draws.shape == ((shape,) if isinstance(shape, int) else shape)
        return unit_draws

    def uniform(self, low: float, high: float, shape: tuple[int, ...]) -> Array:
        return low + (high - low) * self.random(shape)


@dataclass(frozen=True)
class ScriptedAlgorithm:
    """An algorithm with the numbers that it draws."""

    algorithm: Algorithm
    rng: ScriptedGenerator

    @property
    def name(self) -> str:
        return self.algorithm.name

    def moves(self, space: Space, rng: Rng, note: Note) -> Moves[str | None]:
        del rng
        return self.algorithm.moves(space, cast("Rng", self.rng), note)


def run_search(
    algorithm: Algorithm, bounds: list[tuple[float, float]], budget: int, *draws: Any
) -> tuple[list[Array], Search]:
    """The batches of points that a search evaluates, and the search itself."""
    rng = ScriptedGenerator(*draws)
    search = Search(box(bounds), ScriptedAlgorithm(algorithm, rng), budget=budget, seed=0)
    batches = []
    while not search.ended:
        batches.append(search.ask())
        search.tell(batches[-1][:, 0] ** 2 + 2 * batches[-1][:, 1] ** 2)
    assert not rng.draws  # as many draws as the paper has
    return batches, search


def check(batches: list[Array], expected: list[Points]) -> None:
    assert [len(points) for points in batches] == [len(points) for points in expected]
    for k, (points, expected_points) in enumerate(zip(batches, expected, strict=True)):
        assert np.allclose(points, expected_points, rtol=0, atol=1e-11), f"batch {k}"


def unit_draws(directions: Points) -> list[list[float]]:
    """Directions in [-1, 1], as numbers in [0, 1]."""
    return [[(1 + a) / 2, (1 + b) / 2] for a, b in directions]


# --- bacteria with a step of one length


def test_bfo_three_chemotactic_steps_reproduction_and_dispersal() -> None:
    # Cells a and b, C = 0.5, N_s = 3, no signals (J_cc = 0), x in [-2, 2] and y in [-1, 1].
    # "J" is the cost of the point evaluated; the swim test is Step 5's J(i, j+1) < J_last.
    swarm = BacterialForaging(
        S=2, N_c=3, N_s=3, C=0.5, d_attract=0.0, h_repellant=0.0, N_re=1, N_ed=2, P_ed=0.25,
        coordinates="raw",
    )  # fmt: skip
    batches, search = run_search(
        swarm,
        [(-2, 2), (-1, 1)],
        21,
        [[(1.0 + 2) / 4, (0.8 + 1) / 2], [(1.8 + 2) / 4, (-0.8 + 1) / 2]],  # Step 2
        unit_draws([(-0.75, -1.0), (1.0, 0.75)]),  # directions (-0.6, -0.8) and (0.8, 0.6)
        unit_draws([(1.0, -0.75), (-0.5, 0.0)]),  # (0.8, -0.6) and (-1, 0)
        unit_draws([(0.375, -0.5), (0.75, 1.0)]),  # (0.6, -0.8) and (0.6, 0.8)
        [0.9, 0.1],  # of P_ed = 0.25: a stays, b is dispersed,
        [[0.5, 0.75]],  # to (0, 0.5)
        unit_draws([(-0.75, 1.0), (1.0, 0.0)]),  # (-0.6, 0.8) and (1, 0)
    )
    expected: list[Points] = [
        # Step 2. J = 1 + 2 * 0.64 = 2.28 and 3.24 + 2 * 0.64 = 4.52.
        [(1.0, 0.8), (1.8, -0.8)],
        # j = 1, tumble (2.3): a by 0.5 (-0.6, -0.8) = (-0.3, -0.4); b by (0.4, 0.3) to x = 2.2,
        # which is beyond the wall: 2. J = 0.49 + 0.32 = 0.81 < 2.28; 4 + 0.5 = 4.5 < 4.52.
        [(1.0 - 0.3, 0.8 - 0.4), (2.0, -0.8 + 0.3)],
        # Both swim. J = 0.16 + 0 < 0.81; 4 + 2 * 0.04 = 4.08 < 4.5.
        [(0.7 - 0.3, 0.4 - 0.4), (2.0, -0.5 + 0.3)],
        # J = 0.01 + 2 * 0.16 = 0.33: not < J_last = 0.16 (though < 2.28), so a stays here, where
        # it failed. b: 4 + 2 * 0.01 = 4.02 < 4.08.
        [(0.4 - 0.3, 0.0 - 0.4), (2.0, -0.2 + 0.3)],
        # b's swim m = 3 = N_s. J = 4 + 2 * 0.16 = 4.32.
        [(2.0, 0.1 + 0.3)],
        # j = 2: a by (0.4, -0.3), b by (-0.5, 0). J = 0.25 + 0.98 = 1.23, not < 0.33: a stops at
        # once. b: 2.25 + 0.32 = 2.57 < 4.32.
        [(0.1 + 0.4, -0.4 - 0.3), (2.0 - 0.5, 0.4)],
        # J = 1 + 0.32 = 1.32 < 2.57; 0.25 + 0.32 = 0.57 < 1.32; 0 + 0.32 < 0.57. The next would
        # be as good again, but m = N_s.
        [(1.5 - 0.5, 0.4)],
        [(1.0 - 0.5, 0.4)],
        [(0.5 - 0.5, 0.4)],
        # j = 3: a by (0.3, -0.4) to y = -1.1, beyond the wall: -1. b by (0.3, 0.4).
        # J = 0.64 + 2 = 2.64, not < 1.23; 0.09 + 2 * 0.64 = 1.37, not < 0.32.
        [(0.5 + 0.3, -1.0), (0.0 + 0.3, 0.4 + 0.4)],
        # Reproduction: health of a 0.33 + 1.23 + 2.64 = 4.2, of b 4.32 + 0.32 + 1.37 = 6.01. So
        # a splits, though b is at the better place. Dispersal takes the second of them.
        # J = 0 + 2 * 0.25 = 0.5.
        [(0.0, 0.5)],
        # Next lifetime, j = 1: a by (-0.3, 0.4), the other by (0.5, 0).
        # J = 0.25 + 0.72 = 0.97 < 2.64; 0.25 + 0.5 = 0.75, not < 0.5.
        [(0.8 - 0.3, -1.0 + 0.4), (0.0 + 0.5, 0.5)],
        # J = 0.04 + 0.08 = 0.12 < 0.97; the other had started from 0.5, not from a's 2.64.
        [(0.5 - 0.3, -0.6 + 0.4)],
        [(0.2 - 0.3, -0.2 + 0.4)],
    ]
    check(batches, expected)
    costs = [2.28, 4.52, 0.81, 4.5, 0.16, 4.08, 0.33, 4.02, 4.32, 1.23, 2.57, 1.32, 0.57, 0.32]
    costs += [2.64, 1.37, 0.5, 0.97, 0.75, 0.12, 0.09]
    # The costs above.
    assert np.allclose(search.trace.f, costs, rtol=0, atol=1e-11)


# --- bacteria with the step of (2.2) and the signals of Table 3, BF

BF: dict[str, Any] = {
    "S": 2,
    "alpha": 10.0,
    "d_attract": 0.1,
    "w_attract": 0.2,
    "h_repellant": 0.1,
    "w_repellant": 1.0,
    "coordinates": "raw",
}


def J_cc(repels: float, attracts: float) -> float:
    # (2.1) for two cells: the cell's own member is -0.1 exp(0) + 0.1 exp(0) = 0, the other's is
    # -0.1 exp(-0.2 D) + 0.1 exp(-1 D) at the squared distance D.
    return -0.1 * attracts + 0.1 * repels


@pytest.mark.parametrize(
    ("D", "repels", "attracts"),
    [
        (0.5, 0.606530659713, 0.904837418036),
        (0.758922674411, 0.468170527510, 0.859173382693),
        (0.462845508984, 0.629489875527, 0.911586216542),
        (0.840591098550, 0.431455415369, 0.845253903107),
        (1.250059192974, 0.286487838291, 0.778791563219),
        (1.751736892983, 0.173472378676, 0.704443338672),
    ],
)
def test_the_exponentials_below(D: float, repels: float, attracts: float) -> None:
    assert math.isclose(repels, math.exp(-D), abs_tol=2e-12)
    assert math.isclose(attracts, math.exp(-0.2 * D), abs_tol=2e-12)


def test_abfo_three_chemotactic_steps_where_the_signals_decide() -> None:
    batches, _ = run_search(
        AdaptiveForaging(**BF, N_c=3, N_s=2, N_re=2, N_ed=1),
        [(-2, 2), (-2, 2)],
        13,
        [[3.5 / 4, 2 / 4], [4 / 4, 2.5 / 4]],  # Step 2: a = (1.5, 0), b = (2, 0.5)
        unit_draws([(0.5, -0.375), (0.5, 0.375)]),  # directions (0.8, -0.6) and (0.8, 0.6)
        unit_draws([(0.0, 0.5), (0.375, 0.5)]),  # (0, 1) and (0.6, 0.8)
        unit_draws([(0.0, -0.5), (-0.25, 0.0)]),  # (0, -1) and (-1, 0)
        unit_draws([(-0.5, 0.375), (0.0, 0.5)]),  # (-0.8, 0.6) and (0, 1)
    )
    # j = 1. J = 2.25 and 4 + 0.5 = 4.5; C = 2.25/12.25 = 9/49 and 4.5/14.5 = 9/29 (2.2).
    # D = 0.25 + 0.25 = 0.5 for both. Tumble (2.3); b to x = 2.248, beyond the wall: 2.
    last_a = 2.25 + J_cc(0.606530659713, 0.904837418036)  # 2.220169
    last_b = 4.50 + J_cc(0.606530659713, 0.904837418036)  # 4.470169
    a1 = (1.5 + 9 / 49 * 0.8, 0.0 - 9 / 49 * 0.6)  # (1.646939, -0.110204)
    b1 = (2.0, 0.5 + 9 / 29 * 0.6)  # (2, 0.686207)
    J_a1 = a1[0] ** 2 + 2 * a1[1] ** 2  # 2.736697
    J_b1 = 4 + 2 * b1[1] ** 2  # 4.941760
    # No signal of two cells is below -0.0535, so both got worse and stop at once.
    assert J_a1 - 0.0535 > last_a
    assert J_b1 - 0.0535 > last_b

    # j = 2. (2.2) has the raw cost: 0.214867 and 0.330735. With J_cc it would be 0.212450.
    C_a, C_b = J_a1 / (J_a1 + 10), J_b1 / (J_b1 + 10)
    a2 = (a1[0], a1[1] + C_a)  # (1.646939, 0.104663)
    b2 = (2.0, b1[1] + 0.8 * C_b)  # (2, 0.950795), from x = 2.198: the wall again
    J_a2 = a2[0] ** 2 + 2 * a2[1] ** 2  # 2.734316
    J_b2 = 4 + 2 * b2[1] ** 2  # 5.808021
    # a to b1: D = 0.353061^2 + 0.796411^2 = 0.758923 before, 0.353061^2 + 0.581544^2 = 0.462846.
    last_a = J_a1 + J_cc(0.468170527510, 0.859173382693)  # 2.697597
    next_a = J_a2 + J_cc(0.629489875527, 0.911586216542)  # 2.706106
    assert J_a2 < J_a1  # the cost alone would let a swim,
    assert next_a > last_a  # the signals stop it: Step 5 compares (2.1)
    assert J_b2 - 0.0535 > J_b1

    # j = 3. C = 0.214720 and 0.367410.
    C_a, C_b = J_a2 / (J_a2 + 10), J_b2 / (J_b2 + 10)
    a3 = (a2[0], a2[1] - C_a)  # (1.646939, -0.110057)
    b3 = (2.0 - C_b, b2[1])  # (1.632590, 0.950795)
    J_a3 = a3[0] ** 2 + 2 * a3[1] ** 2  # 2.736633
    # a to b2: D = 0.353061^2 + 0.846132^2 = 0.840591 before, 0.353061^2 + 1.060852^2 = 1.250059.
    last_a = J_a2 + J_cc(0.431455415369, 0.845253903107)  # 2.692936
    next_a = J_a3 + J_cc(0.286487838291, 0.778791563219)  # 2.687402
    assert J_a3 > J_a2  # the cost alone would stop a,
    assert next_a < last_a  # the signals let it swim
    a4 = (a2[0], a2[1] - 2 * C_a)  # (1.646939, -0.324778), 2.923368; D = 1.751737 now
    J_a4 = a4[0] ** 2 + 2 * a4[1] ** 2
    assert J_a4 + J_cc(0.173472378676, 0.704443338672) > next_a  # 2.870271: a stops, here
    b4, b5 = (2.0 - 2 * C_b, b2[1]), (2.0 - 3 * C_b, b2[1])
    # b pays x^2 less each time, far more than signals weigh: 5.808, 4.473, 3.409, 2.614. It
    # ends because m = N_s = 2.
    assert b3[0] ** 2 < 4 - 0.0535
    assert b4[0] ** 2 < b3[0] ** 2 - 0.0535

    # Reproduction: a's health 2.707 + 2.706 + 2.870 against b's 4.904 + 5.759 + 2.564: a splits.
    # j = 1 again, C = 2.923368/12.923368 = 0.226208 for both.
    C_a = J_a4 / (J_a4 + 10)
    expected: list[Points] = [
        [(1.5, 0.0), (2.0, 0.5)],
        [a1, b1],
        [a2, b2],
        [a3, b3],
        [a4, b4],
        [b5],
        [(a4[0] - 0.8 * C_a, a4[1] + 0.6 * C_a), (a4[0], a4[1] + C_a)],
    ]
    check(batches, expected)


def test_the_step_is_of_the_cost_and_not_of_the_signals() -> None:
    # As loud as a cost: d = 4, h = 0. J = 1 and 2 * 0.25 = 0.5, so C = 1/11 and 0.5/10.5 = 1/21.
    # J_cc = -4 - 4 exp(-0.25) = -7.12 would make it 6.12/16.12 and 6.62/16.62.
    swarm = AdaptiveForaging(
        **BF | {"d_attract": 4.0, "h_repellant": 0.0}, N_c=1, N_s=0, N_re=1, N_ed=1
    )
    start = [[3 / 4, 2 / 4], [2 / 4, 2.5 / 4]]  # (1, 0) and (0, 0.5)
    batches, _ = run_search(
        swarm, [(-2, 2), (-2, 2)], 4, start, unit_draws([(0.375, 0.5), (-0.5, 0.375)])
    )
    check(
        batches,
        [
            [(1.0, 0.0), (0.0, 0.5)],
            [(1.0 + 0.6 / 11, 0.8 / 11), (-0.8 / 21, 0.5 + 0.6 / 21)],
        ],
    )


def test_the_swarm_of_2_1_has_the_cell_itself() -> None:
    # d = 0.3, h = 0.1. Two cells 2 apart, D = 4; the tumble of 0.5 takes a to D = 6.25 from
    # where b was, and b to D = 2.25 from where a was; each has -0.3 + 0.1 for itself. A
    # constant for all cells changes no comparison: it shows in the result of the step, the health.
    swarm = AdaptiveForaging(**BF | {"d_attract": 0.3}, N_s=0)
    moves = swarm.chemotaxis(
        np.array([[0.25, 0.5], [0.75, 0.5]]),  # x = -1 and 1 of [-2, 2]
        np.array([7.0, 7.0]),
        np.array([0.5, 0.5]),
        np.array([4.0, 4.0]),
        cast("Rng", ScriptedGenerator(unit_draws([(-0.5, 0.0), (-0.5, 0.0)]))),
        lambda **entries: entries.clear(),
    )
    assert np.allclose(next(moves), [[0.125, 0.5], [0.625, 0.5]], rtol=0, atol=1e-12)
    with pytest.raises(StopIteration) as end:
        moves.send(np.array([2.0, 3.0]))
    # exp(-1.25) = 0.286504796860, exp(-6.25) = 0.001930454136;
    # exp(-0.45) = 0.637628151622, exp(-2.25) = 0.105399224562.
    J_a = 2 - 0.2 - 0.3 * 0.286504796860 + 0.1 * 0.001930454136
    J_b = 3 - 0.2 - 0.3 * 0.637628151622 + 0.1 * 0.105399224562
    assert np.allclose(end.value.value[2], [J_a, J_b], rtol=0, atol=1e-11)


# --- tabu search


def test_ts_five_rounds() -> None:
    # N = 3, R = 1, a visited point bans 0.3 about it for 2 rounds. x in [-5, 3], y in [-2, 2].
    batches, _ = run_search(
        TabuSearch(N=3, R=1.0, tenure=2, r_tabu=0.3, coordinates="raw"),
        [(-5, 3), (-2, 2)],
        19,
        [[7 / 8, 3 / 4]],
        unit_draws([(-1.0, 0.0), (0.0, -1.0), (0.5, 1.0)]),
        unit_draws([(0.0, 0.0), (1.0, -0.25), (-1.0, 1.0)]),
        unit_draws([(1.0, -1.0), (0.75, -1.0), (-0.5, 0.5)]),
        unit_draws([(0.5, 0.0), (0.75, 0.5), (-0.75, 0.75)]),
        unit_draws([(-0.5, 0.25), (0.0, -0.25), (0.0, 0.25)]),
        unit_draws([(1.0, 0.0), (0.0, 1.0), (0.0, 0.0)]),
    )
    expected: list[Points] = [
        [(2.0, 1.0)],  # 6; visited, tabu in rounds 1 and 2
        # Round 1: 3, 4, 14.25. The first improves. Best 3. (1, 1) is tabu in rounds 2 and 3.
        [(1.0, 1.0), (2.0, 0.0), (2.5, 2.0)],
        # Round 2: 3, 5.125, 8. (1, 1) is tabu, and equals the best without beating it. The next
        # is 0.25 from (2, 1), tabu still. So the dearest, worse than where it stands.
        [(1.0, 1.0), (2.0, 0.75), (0.0, 2.0)],
        # Round 3: 3 at (1, 1), tabu; 0.5625 + 2 = 2.5625, 0.25 from (1, 1) and so tabu, but
        # below the best, 3: aspiration. Without it, 0.25 + 8 = 8.25 (y = 2.5, beyond the wall).
        [(1.0, 1.0), (0.75, 1.0), (-0.5, 2.0)],
        # Round 4: 1.5625 + 2 = 3.5625, 0.25 from (1, 1), whose two rounds are over, and 0.5
        # from (0.75, 1): free. 2.25 + 4.5 = 6.75; (0, 1.75): 6.125.
        [(1.25, 1.0), (1.5, 1.5), (0.0, 1.75)],
        # Round 5, tabu (0.75, 1) and (1.25, 1): 0.5625 + 3.125 = 3.6875, tabu by the former;
        # 1.5625 + 1.125 = 2.6875 and 4.6875, tabu by the latter; none below the best, 2.5625.
        # The ban that ends first gives way: (0.75, 1.25).
        [(0.75, 1.25), (1.25, 0.75), (1.25, 1.25)],
        [(1.75, 1.25), (0.75, 2.0), (0.75, 1.25)],  # Round 6 is about it; y = 2.25 is clipped
    ]
    check(batches, expected)


def test_ats_through_two_deadlocks_and_two_radius_stages() -> None:
    # N = 3, R = 1, BT = n_re_back = 2, R = 0.5 below a cost of 3 and 0.25 below 1.
    # x in [-1, 3], y in [-0.5, 1.5]. Ranked list: RANK(TL), cheapest first.
    batches, search = run_search(
        AdaptiveTabuSearch(
            N=3, R=1.0, BT=2, n_re_back=2, AR=((3.0, 0.5), (1.0, 0.25)), coordinates="raw"
        ),
        [(-1, 3), (-0.5, 1.5)],
        34,
        [[3 / 4, 1.5 / 2]],
        unit_draws([(-1.0, 0.0), (0.0, -1.0), (1.0, 1.0)]),
        unit_draws([(0.5, 0.0), (0.0, 0.0), (0.0, 0.5)]),
        unit_draws([(0.5, 0.5), (0.5, -0.25), (-1.0, 1.0)]),
        unit_draws([(0.5, 0.0), (0.0, 0.5), (-0.25, 0.125)]),
        unit_draws([(0.25, 0.0), (0.0, 0.125), (0.5, 0.5)]),
        unit_draws([(0.0, -1.0), (0.5, 0.0), (0.0, 0.5)]),
        unit_draws([(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0)]),
        unit_draws([(1.0, 0.0), (0.0, -1.0), (1.0, 1.0)]),
        unit_draws([(1.0, -1.0), (1.0, 0.0), (1.0, 0.0)]),
        unit_draws([(1.0, 0.0), (0.0, -1.0), (0.0, -0.5)]),
        unit_draws([(0.0, 1.0), (-1.0, 0.0), (1.0, 1.0)]),
    )
    expected: list[Points] = [
        [(2.0, 1.0)],  # S0, J0 = 6
        # Round 1, R = 1: 3, 4, 13.5 (y = 2, clipped). 3 < 6: TL 6 (Step 10), S0 = (1, 1).
        # Algorithm 2: the best error 3 is not below 3, R stays.
        [(1.0, 1.0), (2.0, 0.0), (3.0, 1.5)],
        # Round 2, R = 1: 4.25, 3, 5.5. 3 is not below 3: TL 3, 6; n = 1.
        [(1.5, 1.0), (1.0, 1.0), (1.0, 1.5)],
        # Round 3, R = 1: 6.75, 2.25 + 1.125 = 3.375, 4.5 (y = 2, clipped). n = 2 = BT. TL 3,
        # 3.375, 6: the 2nd is S0 = (1.5, 0.75) of J0 = 3.375 (Algorithm 1); n = 0.
        [(1.5, 1.5), (1.5, 0.75), (0.0, 1.5)],
        # Round 4, R = 1: 5.125, 5.375, 1.5625 + 1.53125 = 3.09375 < 3.375: S0, n = 0. The best
        # error is still 3.
        [(2.0, 0.75), (1.5, 1.25), (1.25, 0.875)],
        # Round 5, R = 1: 3.78125, 3.5625, 6.84375: not below 3.09375; n = 1.
        [(1.5, 0.875), (1.25, 1.0), (1.75, 1.375)],
        # Round 6, R = 1: 1.5625 + 0.03125 = 1.59375: S0, n = 0. Below 3: R = 0.5.
        [(1.25, -0.125), (1.75, 0.875), (1.25, 1.375)],
        # Round 7, R = 0.5: 3.09375, 0.59375, 1.84375. S0. Below 1: R = 0.25.
        [(1.75, -0.125), (0.75, -0.125), (1.25, 0.375)],
        # Round 8, R = 0.25: 1.03125, 0.84375, 1.03125. n = 1; TL 0.84375, 1.59375, 3, ...
        [(1.0, -0.125), (0.75, -0.375), (1.0, 0.125)],
        # Round 9, R = 0.25: 1.28125, 1.03125, 1.03125. n = 2 = BT; TL 0.84375, 1.03125, ...: the
        # 2nd is S0 = (1, -0.125). J0 is above 1 again, the best error is not: R = 0.25.
        [(1.0, -0.375), (1.0, -0.125), (1.0, -0.125)],
        # Round 10, R = 0.25: 1.59375, 1.28125, 1.125: not below 1.03125; n = 1, no deadlock yet.
        [(1.25, -0.125), (1.0, -0.375), (1.0, -0.25)],
        [(1.0, 0.125), (0.75, -0.125), (1.25, 0.125)],  # Round 11, R = 0.25
    ]
    check(batches, expected)
    notes = search.trace.notes
    assert [k for k, n in enumerate(notes) if n.get("event") == "backtrack"] == [4, 10]
    assert [n["radius"] for n in notes[1:]] == [1, 1, 1, 1, 1, 1, 0.5, 0.25, 0.25, 0.25, 0.25]


# --- the hand-over


def test_bts_hands_over_the_least_cost_without_signals_and_where_it_was_met() -> None:
    # One chemotactic step, N_s = 1, of a = (-0.25, 1), J = 2.0625, C = 33/193; b = (2, 1),
    # J = 6, C = 6/16. Then tabu search, N = 3, R = 0.5.
    batches, search = run_search(
        ForagingTabuSearch(**BF, N_c=1, N_s=1, N=3, R=0.5, AR=()),
        [(-2, 2), (-2, 2)],
        11,
        [[1.75 / 4, 3 / 4], [4 / 4, 3 / 4]],
        unit_draws([(0.5, 0.0), (0.0, 0.5)]),
        unit_draws([(0.0, -1 / 128), (0.5, 0.5), (-0.5, 0.5)]),
        unit_draws([(0.5, 0.0), (0.0, 0.5), (-0.5, 0.0)]),
    )
    C = 2.0625 / 12.0625
    met, final = -0.25 + C, -0.25 + 2 * C  # x: -0.079016, 0.091969
    J_met, J_final = met**2 + 2, final**2 + 2  # 2.006243, 2.008458
    # The signal of b, D = 4.322306 and 3.640582: exp(-D) = 0.013269, 0.026237 and
    # exp(-0.2 D) = 0.421296, 0.482837; J + J_cc = 1.965441 there, 1.962798 where it ended.
    cc_met = J_cc(math.exp(-((2 - met) ** 2)), math.exp(-0.2 * (2 - met) ** 2))
    cc_final = J_cc(math.exp(-((2 - final) ** 2)), math.exp(-0.2 * (2 - final) ** 2))
    assert J_met < J_final
    assert J_met + cc_met > J_final + cc_final
    # Step 7 takes the least J, so S0 = (met, 1). Steps 8 to 10: J1 = met^2 + 2 (255/256)^2 =
    # 1.990649 is below J0 = 2.006243, not below J0 + J_cc = 1.965441. S0 moves.
    y = 1 - 1 / 256
    assert J_met + cc_met < met**2 + 2 * y**2 < J_met
    expected: list[Points] = [
        [(-0.25, 1.0), (2.0, 1.0)],
        [(met, 1.0), (2.0, 1.375)],
        [(final, 1.0)],
        [(met, y), (met + 0.25, 1.25), (met - 0.25, 1.25)],
        [(met + 0.25, y), (met, y + 0.25), (met - 0.25, y)],
    ]
    check(batches, expected)
    assert search.trace.notes[3]["event"] == "hand-over"


def test_health_counts_the_place_a_cell_was_born_at() -> None:
    # Passino (2002): J_health = sum of J(i, j) for j = 1 to N_c + 1. With N_c = 1 and no signals:
    # 10 + 2 = 12 against 1 + 3 = 4, so the second cell splits, though the first ended lower.
    bfo = BacterialForaging(
        S=2, N_c=1, N_s=0, N_re=2, N_ed=1, C=0.01, d_attract=0.0, h_repellant=0.0
    )
    search = Search(box([(0.0, 1.0)] * 2), bfo, budget=6, seed=3)
    search.ask()
    search.tell(np.array([10.0, 1.0]))
    second = search.ask()[1].copy()
    search.tell(np.array([2.0, 3.0]))
    # Both tumble from where the second cell ended, each by a step of length C.
    gap = np.linalg.norm(search.ask() - second, axis=1)
    assert np.allclose(gap, 0.01, atol=1e-12)
