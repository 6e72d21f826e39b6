"""What a comparison of laws rests on: directions, search ranges, the loss, and friction itself."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from foreign import driven, friction, strokes
from stribeck import InputError, select
from stribeck.data.recording import Recording
from stribeck.identify.selection.findings import Finding
from stribeck.identify.selection.paired_test import MATERIAL, Paired, paired
from stribeck.rig.forced import FORCED
from test_select_truth import FIXED, LADDER, swings
from test_select_truth import log as balanced_log

LAWS = ["coulomb-viscous", "coulomb-viscous-directional", "stribeck"]


def one_way_log() -> Recording:
    """A driven mass that goes to greater positions at four speeds, its force measured."""
    speed = np.repeat([0.02, 0.05, 0.1, 0.2], 1500)
    speed = np.convolve(speed, np.hanning(300) / np.hanning(300).sum(), mode="same")
    t = 1e-3 * np.arange(len(speed))
    curve = friction.coulomb_viscous(20.0, 100.0)
    loop = driven.Loop(kp=4e5, kd=4e3, mass_ff=20.0)
    motion = driven.simulate(20.0, curve, curve, loop, t, np.cumsum(speed) * 1e-3)
    force = motion.force + 0.5 * np.random.default_rng(1).standard_normal(len(motion.t))
    return Recording(t=motion.t, position=motion.position, force=force)


def test_directions_are_not_compared_on_a_log_that_goes_one_way() -> None:
    log = one_way_log()
    selection = select(log, rig="forced", laws=LAWS[:2], train="1s:4s", holdout="4s:5.5s")
    assert selection.excluded == ("coulomb-viscous-directional",)
    assert [c.name for c in selection.candidates] == ["coulomb-viscous"]
    assert not selection.findings
    assert selection.sentences[1] == (
        "Whether friction differs between directions cannot be asked: the logs run to greater "
        "positions only. Not fitted: coulomb-viscous-directional."
    )
    with pytest.raises(InputError, match="run to greater positions only"):
        select(
            log, rig="forced", laws=["coulomb-viscous-directional"], train="1s:4s",
            holdout="4s:5.5s",
        )  # fmt: skip


def test_logs_of_both_directions_have_both() -> None:
    log = balanced_log("coulomb-viscous", 0)
    assert select(log, rig="forced", laws=LAWS[:2]).excluded == ()


def test_a_law_held_by_a_range_is_not_compared_as_if_it_were_free() -> None:
    log = balanced_log("coulomb-viscous", 0, noise=0.5)  # F_V is 100 N s/m
    held = select(log, rig="forced", laws=LADDER, fixed=FIXED, bounds={"F_V": (150.0, 500.0)})
    simple = held["coulomb-viscous"]
    assert simple.range_ends == {"F_V": "lower"}
    assert simple.worse
    (stribeck,) = (f for f in held.findings if f.ingredient == "stribeck")
    assert not stribeck.warranted
    assert "coulomb-viscous is held by the lower end of the range of F_V" in stribeck.text
    assert any("so that the comparison holds for these ranges alone" in s for s in held.sentences)
    free = select(log, rig="forced", laws=LADDER, fixed=FIXED)
    assert free["coulomb-viscous"].range_ends == {}
    assert free.law == "coulomb-viscous"


def test_friction_that_hardly_moves_does_not_matter_however_quiet_the_sensor() -> None:
    rng = np.random.default_rng(0)
    noise = [0.01 * rng.standard_normal(4000)]
    shifted = [noise[0] + 0.01]  # the error is 41 % greater, and beyond doubt
    assert paired(shifted, noise).worse
    immaterial = paired(shifted, noise, friction=0.4 * MATERIAL)
    assert immaterial.p < 1e-6
    assert not immaterial.worse
    # And what moves friction matters, however much noise hides it.
    loud = [rng.standard_normal(400_000)]
    moved = [loud[0] + 0.1 * np.sign(rng.standard_normal(400_000))]
    assert not paired(moved, loud).worse  # 0.5 % of the error
    assert paired(moved, loud, friction=0.1).worse


def test_the_change_of_friction_is_that_of_the_curves() -> None:
    # F_V is 60 forward and 160 N s/m back, F_C 20 and 23 N: the symmetric law is off by so much.
    selection = select(balanced_log("coulomb-viscous-directional", 0), rig="forced", laws=LAWS[:2])
    (asymmetry,) = selection.findings
    assert asymmetry.warranted
    speed = 0.15  # m/s, near the greatest of the log
    assert asymmetry.held.friction == pytest.approx(50 * speed / (20 + 110 * 0.05), rel=0.5)


def test_laws_compare_by_the_size_of_their_errors() -> None:
    selection = select(
        swings(), rig="servo-pendulum", laws=["coulomb-viscous", "bam-m3"], train="0s:3s",
        holdout="3s:5s", budget=60, loss="absolute",
    )  # fmt: skip
    fit = selection["bam-m3"].fit
    assert fit.score.name == "position_mae"
    assert selection["bam-m3"].error == pytest.approx(fit.score.value, rel=1e-9)
    assert selection["bam-m3"].held == pytest.approx(fit.holdout[0].score.value, rel=1e-3)
    with pytest.raises(InputError, match="loss does not apply"):
        select(balanced_log("stribeck", 0), rig="forced", loss="absolute")


def test_a_default_range_does_not_hold_a_law() -> None:
    log = balanced_log("coulomb-viscous", 0, noise=0.5)  # F_C is 20 N
    narrow = replace(FORCED, ranges=dict(FORCED.ranges) | {"F_C": (0.0, 3.0), "F_S": (0.0, 3.0)})
    selection = select(log, rig=narrow, laws=LADDER, fixed=FIXED)
    assert selection.law == "coulomb-viscous"
    assert not any(c.range_ends for c in selection.candidates)
    values = {e.name: e.value for e in selection.fit.estimates}
    assert values["F_C"] == pytest.approx(20.0, rel=0.01)


@pytest.mark.parametrize(("square", "falls"), [(300.0, False), (0.0, True)])
def test_a_drop_that_only_bends_the_curve_is_told(square: float, falls: bool) -> None:
    """Friction that grows with the square of the speed, least at rest; and one with a true drop."""
    rest = 45.0 if falls else 30.0
    curve = friction.Curve(rest, 30.0, 60.0, 0.02)
    t, x = strokes.sines(40.0, np.array([0.08, 0.03, 0.004]), np.array([0.31, 0.83, 2.3]))
    loop = driven.Loop(kp=4e4, kd=2e3, mass_ff=9.0, tick=1e-4)
    motion = driven.simulate(10.0, curve, curve, loop, t, x, driven.Extras(square=square))
    force = motion.force + 0.3 * np.random.default_rng(1).standard_normal(len(motion.t))
    log = Recording(t=motion.t[::4], position=motion.position[::4], force=force[::4])
    selection = select(log, rig="forced", laws=["coulomb-viscous", "stribeck"])
    assert selection.candidates[selection.chosen].name == "stribeck"
    told = [s for s in selection.sentences if "stands for another bend" in s]
    assert bool(told) is not falls


def test_a_change_for_the_better_has_no_sign() -> None:
    better = Paired(-0.18, float("nan"), float("nan"), float("nan"), 2, friction=0.001)
    text = Finding("stribeck", "coulomb-viscous", "stribeck", 0.01, better, warranted=False).text
    assert "the held-out error is 18 % less without it" in text
