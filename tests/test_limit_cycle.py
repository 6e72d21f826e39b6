"""Limit cycles of compensated axes, held against a closed loop that shares nothing with ours."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from foreign.compensated import Loop, Settings, ramp, simulate_bed, simulate_loop, stands, swing
from foreign.friction import Curve
from foreign.slide_bed import Bed
from stribeck import LAWS, RIGS
from stribeck.compensate.closed_loop import Reference, compensated
from stribeck.compensate.compensation import compensate
from stribeck.compensate.compensator import Compensator
from stribeck.compensate.reference_motions import references
from stribeck.compensate.stability import flow, radius, sliding
from stribeck.rig.controller import LinearLoop
from stribeck.rig.slide_bed import PUBLISHED, SLIDE_BED
from test_compensation import bed, card_of, only

H = 1e-3
LEFT = np.array(PUBLISHED["left"])
CURVE = Curve(*LEFT[:4])
BED = Bed(k_spring_up=LEFT[5], k_spring_down=LEFT[5])
#: The compensator of docs/compensation.md on both sides.
SHAPE = {"dead_band": 5e-6, "reference_band": 5e-6, "drive": 23.5}


def on_the_bed(command: Any, scale: float, mode: str) -> tuple[Any, Any]:
    """Positions of the left set under a compensator that believes it: ours, and the foreign one."""
    crossover = 0.0115 if mode == "crossover" else 0.0
    motion = Reference("ramp", H * np.arange(float(len(command))), command)
    ours = Compensator(scale=scale, feedback=mode != "reference", crossover=crossover, **SHAPE)
    law = LAWS["stribeck"]
    moved = compensated(SLIDE_BED, law, LEFT[None], motion, [ours], (law, LEFT))
    theirs = Settings(scale, float(mode != "reference"), crossover=crossover, **SHAPE)
    foreign = simulate_bed(BED, CURVE, CURVE, (CURVE, CURVE), theirs, command)
    return moved.position[0], foreign


@pytest.mark.parametrize(
    ("scale", "mode", "swings"),
    [(0.0, "reference", 0.0), (1.0, "reference", 0.0), (0.5, "feedback", 16.0e-3),
     (1.0, "crossover", 0.0)],
)  # fmt: skip
def test_feedback_keeps_an_axis_swinging_that_slides_smoothly_without(
    scale: float, mode: str, swings: float
) -> None:
    """20 mm/s, where the friction of the slide rises: a limit cycle beside stable sliding."""
    command = ramp(0.02, 20.0)
    ours, foreign = on_the_bed(command, scale, mode)
    last = slice(-6000, None)
    assert swing(command, foreign, 6000 / len(command))[0] == pytest.approx(swings, abs=3e-4)
    assert np.ptp((command - ours)[last]) == pytest.approx(swings, abs=3e-4)
    assert (stands(command, foreign) > 0.0) == (swings > 0.0)


def test_it_is_seen_and_another_mode_recommended() -> None:
    fast = references(0.005, 0.05, 0.0, H, 1.46)[1]
    believed = bed()
    parts = {
        n: believed.parameters[n].model_copy(update={"value": float(v)})
        for n, v in zip(
            ("F_S", "F_C", "F_V", "v_SS", "k_spring"), (*LEFT[:4], LEFT[5]), strict=True
        )
    }
    result = compensate(
        believed.model_copy(update={"parameters": parts}), reference=fast, scale=0.5
    )
    onset = only(result, "feedback").onset
    assert onset is not None
    assert onset.sign == "sticks and slips"
    assert result.mode == "reference"
    assert [c.mode for c in result.curves] == ["reference", "feedback"]  # friction rises there
    assert only(result, "feedback").swing[1] == pytest.approx(16.0e-3, rel=0.2)
    assert only(result, "reference").swing[1] == 0.0
    outcome = only(result, "feedback").outcomes[1]
    assert outcome.swing[0, 0] == pytest.approx(16.0e-3, rel=0.2)
    assert outcome.at_rest[0, 0] > 0.3
    assert outcome.peak[0, 0] > 0.05


JOINT = {"kp": 40.0, "kd": 2.0}
PLAIN = dict.fromkeys(("g_sin", "g_cos", "g_0"), (0.0, None, None, "N m"))


def test_the_onset_of_hunting_is_that_of_a_foreign_loop() -> None:
    """A joint of 0.5 kg m² and 8 N m s/rad that is compensated by more than its friction."""
    believed = card_of(
        "coulomb-viscous", "joint",
        {"F_C": (1.0, None, None, "N m"), "F_V": (8.0, None, None, "N m s/rad"),
         "J": (0.5, None, None, "kg m**2"), **PLAIN},
        kp=(40.0, "N m/rad"), kd=(2.0, "N m s/rad"),
    )  # fmt: skip
    onset = only(compensate(believed, speed=0.5, mode="feedback"), "feedback").onset
    assert onset is not None
    curve, command = Curve(1.0, 1.0, 8.0), ramp(0.5, 30.0)

    def hunts(scale: float) -> bool:
        moved = simulate_loop(
            Loop(0.5, **JOINT), curve, curve, (curve, curve),
            Settings(scale, 1.0, 5e-4, 5e-4), command, h=1e-4,
        )  # fmt: skip
        after, before = swing(command, moved, 1 / 3)
        return after > 1e-3 and after >= 0.8 * before

    low, high = 0.9, 1.5
    assert not hunts(low)
    assert hunts(high)
    while high - low > 0.01:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if hunts(middle) else (middle, high)
    assert onset.scale == pytest.approx(high, abs=0.05)


# --- eigenvalues --------------------------------------------------------------------------------


def test_eigenvalues_are_those_of_a_damped_swing() -> None:
    """From sample to sample a mode of decay d lessens by exp(-d h)."""
    loop = LinearLoop(2.0, 3.0, 50.0)
    step = flow(loop, 1.0, 1e-3)
    assert radius(loop, step, 0.0, 1e-3) == pytest.approx(
        np.exp(-1e-3 * 4.0 / (2 * 2.0)), abs=1e-12
    )
    assert loop.period == pytest.approx(2 * np.pi / 5.0)


@pytest.mark.parametrize("F_V", [3.0, 8.0])
def test_the_edge_of_stability_is_the_line_of_algebra(F_V: float) -> None:
    s = sliding(
        LinearLoop(0.5, 2.0, 40.0), LAWS["coulomb-viscous"], np.array([1.0, F_V]), 0.5, 1e-5
    )
    assert s.stable
    assert s.slope == pytest.approx(F_V, rel=1e-6)
    assert s.edge == pytest.approx(1.0 + 2.0 / F_V, abs=5e-3)


@pytest.mark.parametrize("hold", [0, 1, 2])
def test_the_edge_is_that_of_the_simulated_loop(hold: int) -> None:
    """A controller that holds, and one that is late, lose damping: 8 ms of it here."""
    h, F_V = 8e-3, 8.0
    p = np.array([0.0, F_V])
    edge = sliding(LinearLoop(0.5, 2.0, 40.0, hold), LAWS["coulomb-viscous"], p, 0.5, h).edge
    assert edge is not None
    curve, command = Curve(0.0, 0.0, F_V), ramp(0.5, 40.0, period=h)

    def decays(scale: float) -> bool:
        moved = simulate_loop(
            Loop(0.5, **JOINT, hold=float(hold)), curve, curve, (curve, curve),
            Settings(scale, 1.0), command, period=h, h=1e-4,
        )  # fmt: skip
        after, before = swing(command, moved, 0.3)
        return after < before

    assert decays(edge - 0.03)
    assert not decays(edge + 0.03)


def test_where_friction_falls_sliding_is_unstable_and_feedback_mends_it() -> None:
    loop = SLIDE_BED.controller().linear(LAWS["stribeck"], LEFT, _track())
    s = sliding(loop, LAWS["stribeck"], LEFT, 0.005, H)
    assert (s.slope < 0.0, s.stable) == (True, False)
    assert s.edge is not None
    assert 0.9 < s.edge < 1.0
    fast = sliding(loop, LAWS["stribeck"], LEFT, -0.05, H)
    assert (fast.slope > 0.0, fast.stable) == (True, True)


def _track() -> Any:
    from stribeck.data.recording import Recording  # noqa: PLC0415

    t = H * np.arange(3.0)
    return SLIDE_BED.controller().track(Recording(t=t, position=t, command=t))


def test_every_rig_with_a_controller_has_a_linear_loop() -> None:
    for name in ("slide-bed", "joint", "servo-pendulum", "emps"):
        rig = RIGS[name]
        controller = rig.controller()
        assert controller is not None
        law = LAWS["coulomb-viscous"]
        p = np.array([0.5 * (q.lower + q.upper) for q in rig.parameters(law)])
        from stribeck.data.recording import Recording  # noqa: PLC0415

        t = H * np.arange(3.0)
        track = controller.track(Recording(t=t, position=t, command=t, rotary=rig.rotary))
        loop = controller.linear(law, p, track)
        assert loop.mass > 0.0
        assert loop.stiffness > 0.0
        assert loop.period > 0.0
