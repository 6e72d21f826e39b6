"""Several logs of one axis: chance alone rarely makes them seem to follow different laws."""

from __future__ import annotations

import numpy as np
import pytest

from stribeck import Recording
from stribeck.friction import LAWS
from stribeck.identify.balance.balance import balance
from stribeck.identify.balance.clustered_errors import clustered_errors
from stribeck.identify.balance.force_residuals import BalanceResiduals
from stribeck.identify.balance.regression import System
from stribeck.identify.log_spread import LogPart, log_spreads
from stribeck.identify.parameters import Parameters
from stribeck.rig import RIGS
from stribeck.rig.balanced import BalancedRig
from stribeck.space import Rng

DT = 0.01


def log(cycles: int, level: float, rng: Rng) -> Recording:
    """Strokes of half a second; friction differs by chance from stroke to stroke, by 1 N."""
    t = np.arange(0.0, cycles, DT)
    v = np.pi * np.cos(2 * np.pi * t)
    stroke = np.floor(2 * t + 0.5).astype(int)
    levels = level + rng.standard_normal(stroke[-1] + 1)
    x, a = 0.5 * np.sin(2 * np.pi * t), -2 * np.pi**2 * np.sin(2 * np.pi * t)
    return Recording(t, x, force=levels[stroke] * np.sign(v) + 5 * v + 2 * a)


def doubted(cycles: tuple[int, ...], levels: tuple[float, ...], seed: int) -> tuple[bool, bool]:
    """Whether the logs seem to differ by either of the two tests, and by both."""
    rig, rng = RIGS["forced"], np.random.default_rng(seed)
    assert isinstance(rig, BalancedRig)
    logs = [log(n, level, rng) for n, level in zip(cycles, levels, strict=True)]
    parameters = Parameters.declared(rig, LAWS["coulomb-viscous"])
    solved = balance(logs, parameters)
    x = solved.values[parameters.free_places]
    spreads = log_spreads(parameters, [
        LogPart(recording, BalanceResiduals(System(parameters, [filtered])), x)
        for recording, filtered in zip(logs, solved.system.logs, strict=True)
    ], solved.robust_errors[parameters.free_places])  # fmt: skip
    notes, _ = clustered_errors(solved)
    of_levels = "the friction of the logs does not follow one law" in notes
    differ = "F_C" in {s.parameter for s in spreads.material}
    return differ or of_levels, differ and of_levels


@pytest.mark.parametrize("cycles", [(6, 6, 6), (60, 3, 3)])
def test_logs_of_one_law_are_not_doubted_whatever_their_lengths(cycles: tuple[int, ...]) -> None:
    # A chance of one in a thousand each.
    assert not any(doubted(cycles, (20.0, 20.0, 20.0), seed)[0] for seed in range(20))


@pytest.mark.parametrize("cycles", [(6, 6, 6), (60, 3, 3)])
def test_a_log_of_another_level_is_told(cycles: tuple[int, ...]) -> None:
    assert all(doubted(cycles, (20.0, 20.0, 30.0), seed)[1] for seed in range(5))
