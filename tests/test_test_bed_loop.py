"""The test bed's loop closed through its sensors, as figure 3 draws it, against a foreign one."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np
import pytest
from numpy.random import SeedSequence

from foreign import slide_bed, slide_bed_loop
from foreign.friction import Curve
from stribeck.errors import InputError
from stribeck.friction import LAWS
from stribeck.rig.motion import sampled_loop
from stribeck.rig.slide_bed import SLIDE_BED
from stribeck.rig.twin import TestBed

BED = TestBed(loop="sensors", speed=0.015)
RIGHT, LEFT = (
    Curve(144.5463, 47.8514, 958.3, 1.0964e-3),
    Curve(152.2804, 40.4153, 975.7, 3.21475e-3),
)


@pytest.mark.parametrize(
    ("held", "supply"), [("current", 24.0), ("current", 11.0), ("voltage", 24.0)]
)
def test_the_loop_is_that_of_a_foreign_simulation(
    held: Literal["current", "voltage"], supply: float
) -> None:
    bed = replace(BED, held=held, supply=supply, current_noise=0.0, bits=32)
    twin, ideal = bed.run("up", seed=4), replace(bed, loop="ideal").run("up", seed=4)
    log, n = twin.recording, 1501
    drive, x0 = bed.drive("up")
    draws = np.random.default_rng(SeedSequence(4).spawn(2)[0])
    noise = bed.echo_noise * draws.standard_normal(int(log.t[-1] * 50) + 2)
    loop = slide_bed_loop.Loop(voltage=held == "voltage", supply=supply, levels=2**32)
    times, command = drive.t[drive.t <= 21.0], drive.x[: np.count_nonzero(drive.t <= 21.0)]

    def positions(h: float) -> np.ndarray:
        return slide_bed_loop.simulate(
            slide_bed.Bed(), loop, RIGHT, LEFT, times, command, x0, noise, h=h
        )  # fmt: skip

    coarse, fine = positions(1e-5), positions(5e-6)
    theirs = (2.0 * fine - coarse)[:, :n]
    assert np.ptp(theirs[0]) > 0.1
    assert np.abs(twin.motion.position[0, :n] - theirs[0]).max() < 1e-5
    assert np.sqrt(np.mean((twin.motion.position[0, :n] - theirs[0]) ** 2)) < 2e-6
    resting = (theirs[1] == 0.0) & (fine[1, :n] == 0.0)
    np.testing.assert_allclose(log.position[:n], fine[2, :n], atol=2e-5)
    assert log.current is not None
    np.testing.assert_allclose(log.current[:n][resting], fine[3, :n][resting], atol=1e-5)
    np.testing.assert_allclose(log.command[:n], fine[4, :n], atol=1e-12)  # type: ignore[index]
    away = np.sqrt(np.mean((twin.motion.position - ideal.motion.position) ** 2))
    assert away > 5e-5


def test_laws_share_the_machine_code_of_the_loop() -> None:
    bed = replace(BED, speed=1.0)
    before = bed.run("up", seed=1).motion
    truth = np.array([50.0, 900.0, 554.0])
    after = bed.run("up", seed=1, law=LAWS["coulomb-viscous"], truth=truth).motion
    assert not np.array_equal(after.position, before.position)
    assert len(sampled_loop.run.nopython_signatures) == 1


def test_a_weak_supply_and_a_held_voltage_slow_a_slip() -> None:
    fast, weak, braked = (
        np.abs(bed.run("up", seed=1).motion.velocity).max()
        for bed in (BED, replace(BED, supply=11.0), replace(BED, held="voltage"))
    )
    assert weak < 0.95 * fast
    assert braked < 0.8 * fast
    # The motor's speed at the peak of a slip, and its back-EMF there.
    assert 450.0 < fast * SLIDE_BED["K_n"] < 700.0
    assert 8.0 < fast * SLIDE_BED["K_n"] * SLIDE_BED["K_t"] < 13.0


def test_modes_move_the_reflector_as_the_paper_says() -> None:
    test, home = (replace(BED, mode=mode).run(seed=2) for mode in ("test", "home"))
    whole = test.motion.position[0]
    assert whole.min() < 0.004
    assert whole.max() > 0.396
    for twin in (test, home):
        assert twin.motion.velocity[0, -1] == 0.0
        assert twin.motion.position[0, -1] == pytest.approx(BED.home, abs=3e-3)


@pytest.mark.parametrize(
    ("setting", "message"),
    [({"loop": "open"}, "loop 'open'"), ({"mode": "jog"}, "mode 'jog'"), ({"held": "x"}, "held"),
     ({"supply": 0.0}, "supply"), ({"mode": "home", "loop": "ideal"}, "sensors"),
     ({"resistance": -1.0}, "resistance")],
)  # fmt: skip
def test_loops_that_cannot_be_are_refused(setting: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        replace(BED, **setting)  # type: ignore[arg-type]
