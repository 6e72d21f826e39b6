"""The slide bed: numbers of the published sets, effect of its constants, refusals."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

from foreign import slide_bed, slide_bed_events
from foreign.friction import Curve
from stribeck.data.recording import Recording
from stribeck.errors import InputError
from stribeck.friction import LAWS, law_named
from stribeck.rig.motion.command import Drive
from stribeck.rig.motion.track import track
from stribeck.rig.rig import Motion
from stribeck.rig.slide_bed import PUBLISHED, SLIDE_BED, SlideBed, published_both

LAW = LAWS["stribeck"]
SIGN = {"right": 1, "left": -1}
DIRECTIONS = pytest.mark.parametrize("direction", SIGN)


def ramp_motion(rig: SlideBed, direction: str, scheme: str = "fast", dt: float = 2e-5) -> Motion:
    """A minute of ramp at 5 mm/s from rest with the published sets."""
    t = np.arange(0.0, 60.0005, 1e-3)
    ramp = track(Drive.line(0.0, 0.0, 60.0, SIGN[direction] * 5e-3), t, 0.0)
    return rig.move(LAW, PUBLISHED[direction][None], ramp, scheme=scheme, dt=dt)  # type: ignore[arg-type]


def slips(motion: Motion) -> tuple[int, float, float, float]:
    """Number of slips, length of the second, mm, greatest speed, mm/s, share of time stuck."""
    x, v = motion.position[0], motion.velocity[0]
    moving = v != 0
    begins = int((moving[1:] & ~moving[:-1]).sum())
    rests = np.unique(np.round(np.abs(x[~moving]), 9))
    jump = float(np.diff(rests)[1]) if len(rests) > 2 else math.nan
    return begins, 1e3 * jump, 1e3 * float(np.abs(v).max()), float((~moving).mean())


@pytest.mark.parametrize(
    ("direction", "clamp", "count", "jump", "v_max"),
    [
        ("right", 30.0, 10, 26.45, 66.9),
        ("left", 30.0, 7, 37.52, 81.1),
        ("right", math.inf, 10, 26.74, 56.1),
        ("left", math.inf, 7, 37.93, 68.1),
        ("right", 1e9, 10, 26.74, 56.1),
    ],
)
def test_stick_slip_of_the_published_sets(
    direction: str, clamp: float, count: int, jump: float, v_max: float
) -> None:
    statistics = slips(ramp_motion(SLIDE_BED.set(F_m_max=clamp), direction))
    assert statistics[0] == count
    assert statistics[1] == pytest.approx(jump, abs=0.006)
    assert statistics[2] == pytest.approx(v_max, abs=0.06)


@pytest.mark.parametrize("law", ["stribeck", "stribeck-smooth", "stribeck+temperature"])
def test_positions_alone_are_those_of_the_motion(law: str) -> None:
    friction = law_named(law)
    t = np.arange(0.0, 2.0, 1e-2)
    on = track(Drive.line(0.0, 0.0, 2.0, 5e-2), t, 0.0)
    middle = [0.5 * (q.lower + q.upper) for q in SLIDE_BED.parameters(friction)]
    p = np.array([middle, [1.1 * value for value in middle]])
    motion = SLIDE_BED.move(friction, p, on)
    assert np.ptp(motion.position) > 0
    assert np.array_equal(SLIDE_BED.positions(friction, p, on), motion.position)
    finer = SLIDE_BED.finer(8.0, 100.0)
    motion = finer.move(friction, p, on)
    x, v = finer.states(friction, p, on)
    assert np.array_equal(x, motion.position)
    assert np.array_equal(v, motion.velocity)


@pytest.mark.parametrize(("direction", "share"), [("right", 0.883), ("left", 0.906)])
def test_the_published_sets_are_stuck_most_of_the_time(direction: str, share: float) -> None:
    assert slips(ramp_motion(SLIDE_BED, direction))[3] == pytest.approx(share, abs=0.001)


def test_without_motor_inertia_the_rightward_set_slips_once_and_then_slides() -> None:
    motion = ramp_motion(SLIDE_BED.set(J_m=0), "right")
    count, _, v_max, _ = slips(motion)
    assert count == 1
    # D_m still acts; without it too the peak is the 90.2 mm/s of a bare mass.
    assert v_max < 90.2
    assert slips(ramp_motion(SLIDE_BED.set(J_m=0, D_m=0), "right"))[2] == pytest.approx(
        90.2, abs=0.06
    )
    np.testing.assert_allclose(motion.velocity[0, -1000:], 5e-3, rtol=1e-4)


def test_without_motor_inertia_the_leftward_set_sticks_and_slips_all_the_same() -> None:
    count, jump, v_max, _ = slips(ramp_motion(SLIDE_BED.set(J_m=0, D_m=0), "left"))
    assert count == 8
    assert jump == pytest.approx(33.34, abs=0.01)
    assert v_max == pytest.approx(104.7, abs=0.06)


@DIRECTIONS
@pytest.mark.parametrize("F_fm", [15.0, 35.0])
def test_motor_friction_shifts_the_stretch_and_nothing_else(direction: str, F_fm: float) -> None:
    # Later slips by F_fm / (k_hat + k_spring) / u, each the same slip.
    plain, shifted = (
        ramp_motion(SLIDE_BED, direction),
        ramp_motion(SLIDE_BED.set(F_fm=F_fm), direction),
    )
    k = SLIDE_BED["k_hat+" if direction == "right" else "k_hat-"] + PUBLISHED[direction][5]
    later = (F_fm - SLIDE_BED["F_fm"]) / k / 5e-3
    t = plain.t[(plain.t > 11.0) & (plain.t < 50.0)]
    moved = np.interp(t, plain.t, plain.position[0])
    np.testing.assert_allclose(
        np.interp(t + later, shifted.t, shifted.position[0]), moved, atol=5e-5
    )  # between samples of 1 ms at up to 82 mm/s
    assert slips(shifted)[1] == pytest.approx(slips(plain)[1], abs=1e-5)


@pytest.mark.parametrize(("direction", "loss"), [("right", 1.2), ("left", 2.6)])
def test_a_millisecond_before_rest_passes_over_the_band_of_rest(
    direction: str, loss: float
) -> None:
    t = np.arange(0.0, 30.0, 1e-4)
    ramp = track(Drive.line(0.0, 0.0, 30.0, SIGN[direction] * 5e-3), t, 0.0)
    v = np.abs(SLIDE_BED.move(LAW, PUBLISHED[direction][None], ramp).velocity[0])
    last = np.flatnonzero((v[1:] == 0) & (v[:-1] > 0))[1]
    assert 1e3 * (v[last - 10] - v[last]) == pytest.approx(loss, abs=0.06)


@DIRECTIONS
def test_schemes_agree_except_the_printed_one(direction: str) -> None:
    fast = ramp_motion(SLIDE_BED, direction)
    reference = ramp_motion(SLIDE_BED, direction, "reference", 5e-5)
    paper = ramp_motion(SLIDE_BED, direction, "paper", 5e-5)
    assert np.sqrt(np.mean((fast.position - reference.position) ** 2)) < 1e-6
    assert np.sqrt(np.mean((fast.position - paper.position) ** 2)) > 1e-3


@DIRECTIONS
@pytest.mark.parametrize("dp", [None, 0.0182646], ids=["m dv", "(m + K_J) dv"])
def test_published_motions_are_those_of_a_foreign_event_driven_integration(
    direction: str, dp: float | None
) -> None:
    t = np.arange(3661) / 100
    on = track(Drive.line(0.0, 0.0, 36.6, SIGN[direction] * 5e-3), t, 0.0)
    p = PUBLISHED[direction]
    bed = slide_bed.Bed()
    if direction == "left":
        bed = slide_bed.Bed(k_hat_up=bed.k_hat_down, k_spring_up=bed.k_spring_down)
    rig = SLIDE_BED if dp is None else SLIDE_BED.set(dp=dp)
    theirs = slide_bed_events.ramp(bed, Curve(*p[:4]), 5e-3, t, dp or 10.9e-4)
    ours = SIGN[direction] * rig.move(LAW, p[None], on).position[0]
    fine = SIGN[direction] * rig.finer(1.0, 100.0).move(LAW, p[None], on).position[0]
    assert np.ptp(theirs) > 0.1
    assert np.sqrt(np.mean((ours - theirs) ** 2)) < 5e-8
    assert np.abs(fine - theirs).max() < 1e-7
    if dp is not None:  # what the motor's inertia in the dead band does to the motion, mm RMS
        plain = SIGN[direction] * SLIDE_BED.move(LAW, p[None], on).position[0]
        away = 1e3 * np.sqrt(np.mean((plain - theirs) ** 2))
        assert away == pytest.approx({"right": 1.741, "left": 1.461}[direction], abs=2e-3)


def test_an_unknown_scheme_is_refused() -> None:
    with pytest.raises(InputError, match="scheme 'euler'"):
        ramp_motion(SLIDE_BED, "right", "euler")


#: The constants that change a motion up and down again.
MOTION_CONSTANTS = (
    "m", "k_hat+", "k_hat-", "F_fm", "a", "l", "eta_b", "eta_c", "J_m", "D_m", "K_n", "K_v",
    "K_kt", "F_m_max", "dv", "dp",
)  # fmt: skip


@pytest.mark.parametrize("name", MOTION_CONSTANTS)
def test_every_constant_changes_the_motion(name: str) -> None:
    t = np.arange(0.0, 60.0, 0.02)
    there_and_back = track(Drive(np.array([0.0, 30.0, 60.0]), np.array([0.0, 0.15, 0.0])), t, 0.0)
    law, p = LAWS["stribeck-directional"], published_both()[None]
    before = SLIDE_BED.move(law, p, there_and_back).position
    constant = next(c for c in SLIDE_BED.constants if c.name == name)
    after = SLIDE_BED.set(**{name: constant.shown * 1.05}).move(law, p, there_and_back).position
    assert np.abs(after - before).max() > 1e-6


@pytest.mark.parametrize(("name", "factor"), [("step", 0.01), ("tolerance", 1e-3)])
def test_constants_of_the_stepping_matter_to_laws_that_are_stepped(
    name: str, factor: float
) -> None:
    ramp = track(Drive.line(0.0, 0.0, 10.0, 5e-3), np.arange(0.0, 10.0, 0.02), 0.0)
    law = law_named("stribeck+temperature")
    p = np.array([[144.0, 48.0, 958.0, 2e-3, 1.0, 0.0, 293.15, 968.0]])
    rig = SLIDE_BED.set(step=4.0, tolerance=1e-3)
    before = rig.move(law, p, ramp).position
    constant = next(c for c in rig.constants if c.name == name)
    after = rig.set(**{name: constant.shown * factor}).move(law, p, ramp).position
    static = SLIDE_BED.set(dv=1e-4).move(LAWS["stribeck"], p[:, [0, 1, 2, 3, 4, 7]], ramp).position
    assert np.abs(after - static).max() < np.abs(before - static).max()


def test_constants_that_are_not_of_the_motion_are_the_only_others() -> None:
    exempt = {"K_t", "ramp_speed", "step", "tolerance"}
    assert {c.name for c in SLIDE_BED.constants} - set(MOTION_CONSTANTS) == exempt


def test_derived_constants_have_the_values_of_the_nomenclature() -> None:
    assert SLIDE_BED["K_n"] == pytest.approx(7414.16, abs=0.01)
    assert SLIDE_BED["K_v"] == pytest.approx(5555.06, abs=0.01)
    assert SLIDE_BED["K_kt"] == pytest.approx(4.11861e7, rel=1e-5)
    assert SLIDE_BED["K_kt"] * SLIDE_BED["J_m"] == pytest.approx(171.75, abs=0.01)
    assert SLIDE_BED["K_kt"] * SLIDE_BED["D_m"] == pytest.approx(107.08, abs=0.01)
    assert SLIDE_BED["K_t"] * SLIDE_BED["K_v"] == pytest.approx(101.1, abs=0.01)
    assert SLIDE_BED["dp"] == pytest.approx(1.09e-3, rel=1e-9)


def test_derived_constants_follow_the_gear_unless_given() -> None:
    geared = SLIDE_BED.set(a=11.8)
    assert geared["K_n"] == pytest.approx(2 * SLIDE_BED["K_n"])
    assert geared["K_v"] == pytest.approx(2 * SLIDE_BED["K_v"])
    assert geared["K_kt"] == pytest.approx(4 * SLIDE_BED["K_kt"])
    assert SLIDE_BED.set(eta_b=0.405)["K_kt"] == pytest.approx(SLIDE_BED["K_kt"] / 2)
    assert SLIDE_BED.set(a=11.8, K_kt=1e7)["K_kt"] == pytest.approx(1e7)
    assert SLIDE_BED.set(K_v=1000.0)["K_n"] == SLIDE_BED["K_n"]
    assert SLIDE_BED.set(m=5.0, dv=0.2)["dp"] == pytest.approx(1e-3)
    assert SLIDE_BED.set(m=5.0, dp=2e-3)["dp"] == pytest.approx(2e-3)


@pytest.mark.parametrize(
    ("name", "value"),
    [("m", 0.0), ("m", math.nan), ("m", math.inf), ("J_m", -1.0), ("D_m", math.inf),
     ("F_fm", -1.0), ("F_m_max", math.nan), ("dv", -0.1), ("dp", math.inf),
     ("k_hat+", math.inf), ("l", 0.0)],
)  # fmt: skip
def test_a_rig_that_cannot_move_is_refused_by_name(name: str, value: float) -> None:
    ramp = track(Drive.line(0, 0, 1, 1), np.linspace(0, 1, 5), 0.0)
    fault = "must be above zero|must not be below 0|is no number|cannot be simulated"
    with pytest.raises(InputError, match=rf"{re.escape(name)} = [^ ]+ .*({fault})"):
        SLIDE_BED.set(**{name: value}).misfits(LAW, PUBLISHED["right"][None], (ramp,))


def test_columns_that_miss_are_refused_by_name() -> None:
    ramp = track(Drive.line(0, 0, 1, 1), np.linspace(0, 1, 5), 0.0)
    with pytest.raises(InputError, match="F_S, F_C, F_V, v_SS, exponent, k_spring; got 5 columns"):
        SLIDE_BED.misfits(LAW, PUBLISHED["right"][None, :5], (ramp,))


@DIRECTIONS
def test_one_set_a_direction_is_both_sets_in_one(direction: str) -> None:
    ramp = track(Drive.line(0, 0, 40, SIGN[direction] * 5e-3), np.linspace(0, 40, 2001), 0.0)
    alone = SLIDE_BED.move(LAW, PUBLISHED[direction][None], ramp)
    directional = SLIDE_BED.move(LAWS["stribeck-directional"], published_both()[None], ramp)
    np.testing.assert_array_equal(directional.position, alone.position)


def test_a_recording_is_simulated_from_the_mean_of_its_first_rest() -> None:
    # Section 4.3, step 1, where the rest is the whole log.
    rng = np.random.default_rng(4)
    t = np.arange(0.0, 20.0, 0.02)
    position = 0.112 + 1e-3 * rng.standard_normal(len(t))
    recording = Recording(t, position)
    motion = SLIDE_BED.set(ramp_speed=5.0).simulate(LAW, PUBLISHED["right"][None], recording)
    x0 = float(position.mean())
    assert motion.position[0, 0] == pytest.approx(x0, abs=1e-12)
    # The motor's force is k_hat times the stretch: a ramp of 17.5 N/s while the slide is stuck.
    # Its command starts at the mean of the first fifty samples.
    rise = np.diff(motion.force[0, t < 7.0])[1:]
    np.testing.assert_allclose(rise, 17.5 * 0.02, atol=1e-9)


@DIRECTIONS
def test_friction_from_a_motion_is_the_law_again(direction: str) -> None:
    # The inverse of the equation of motion, with accelerations from a fine difference.
    t = np.arange(0.0, 12.0, 1e-4)
    drive = Drive.line(0.0, 0.0, 12.0, SIGN[direction] * 5e-3)
    p = PUBLISHED[direction]
    motion = SLIDE_BED.move(LAW, p[None], track(drive, t, 0.0))
    x, v = motion.position[0], motion.velocity[0]
    inside = np.flatnonzero(np.abs(v) > 2e-3)[5:-5]
    a = np.gradient(v, t)
    F = SLIDE_BED.friction(LAW, p, (drive(t) - x)[inside], v[inside], a[inside])
    assert np.abs(F - LAW.friction(v[inside], p[:5])).max() < 0.5
    assert np.median(np.abs(F - LAW.friction(v[inside], p[:5]))) < 1e-3


def test_random_parameter_sets_fill_the_search_ranges_and_leave_what_is_fixed() -> None:
    law = LAWS["stribeck"]
    p = SLIDE_BED.sample(law, np.random.default_rng(3), 4000)
    for k, q in enumerate(SLIDE_BED.parameters(law)):
        if q.fixed is not None:
            assert (p[:, k] == q.fixed).all()
            continue
        share = (p[:, k] - q.lower) / (q.upper - q.lower)
        # The mean of 4,000 uniform numbers is off by 5 standard deviations once in 1.7 million.
        assert share.mean() == pytest.approx(0.5, abs=5 / np.sqrt(12 * 4000))
        assert 0.0 <= share.min() < 0.01
        assert 0.99 < share.max() <= 1.0


def test_a_constant_of_the_users_is_not_said_to_be_the_papers() -> None:
    sources = {c.name: c.source for c in SLIDE_BED.set(m=24.0, a=4.0, J_m=4.17e-6).constants}
    paper = {c.name: c.source for c in SLIDE_BED.constants}
    assert sources["m"] == sources["a"] == "given"
    assert sources["J_m"] == "given"  # who types the paper's value vouches for it
    assert sources["K_n"] == paper["K_n"]  # it still follows from the others


def test_a_command_that_is_assumed_is_told() -> None:
    t = np.arange(0.0, 60.0, 0.02)
    log = Recording(t=t, position=5e-3 * t)
    (doubt,) = SLIDE_BED.doubts([log])
    assert "a ramp from its beginning at its mean speed, 5 mm/s" in doubt.sentence
    (doubt,) = SLIDE_BED.set(ramp_speed=5.0).doubts([log])  # where it starts is not said
    assert "a ramp from its beginning at 5 mm/s is taken for it" in doubt.sentence
    assert "forces are off by k_hat + k_spring for each mm" in doubt.sentence
    assert not doubt.harmful
    assert [*SLIDE_BED.doubts([Recording(t=t, position=5e-3 * t, command=5e-3 * t)])] == []


def test_no_ramp_is_assumed_for_a_slide_that_goes_both_ways() -> None:
    t = np.arange(0.0, 60.0, 0.02)
    x = 5e-3 * np.minimum(t, 60.0 - t)
    log, n = Recording(t=t, position=x), len(t)
    with pytest.raises(InputError, match="the slide goes both ways"):
        SLIDE_BED.drive(log)
    told = SLIDE_BED.set(ramp_speed=5.0)
    with pytest.raises(
        InputError, match=r"from 0 to 59.98 s the slide goes against a ramp of 5 mm"
    ):
        told.track(log, slice(0, n), 0.0, np.ones(n))
    up, down = slice(0, n // 2), slice(n // 2, n)
    assert told.track(log, up, 0.0, np.ones(n // 2)).knots_x[-1] > 0.0
    with pytest.raises(InputError, match="goes against"):
        told.track(log, down, 0.15, np.ones(n - n // 2))
    back = SLIDE_BED.set(ramp_speed=-5.0)
    assert back.track(log, down, 0.15, np.ones(n - n // 2)).knots_x[-1] < 0.0
    with pytest.raises(InputError, match="goes against"):
        back.track(log, up, 0.0, np.ones(n // 2))


def test_what_the_start_of_an_assumed_ramp_is_off_by_is_in_the_breakaway_force() -> None:
    """As `doubts` tell it: forces are off by k_hat + k_spring for each mm."""
    p, t = PUBLISHED["right"], np.arange(0.0, 60.0, 0.02)
    moved = p.copy()
    moved[0] += (SLIDE_BED["k_hat+"] + p[5]) * 1e-3
    moved[1] += (SLIDE_BED["k_hat+"] + p[5]) * 1e-3
    early, late = (Drive.line(0.0, x, 60.0, 5e-3) for x in (1e-3, 0.0))
    ahead = SLIDE_BED.positions(LAW, moved[None], track(early, t, 0.0))
    relaxed = SLIDE_BED.positions(LAW, p[None], track(late, t, 0.0))
    np.testing.assert_allclose(ahead, relaxed, atol=2e-4)


@pytest.mark.parametrize(
    ("name", "p"),
    [
        ("stribeck", [90.0, 40.0, 900.0, 1e-3, 1.0]),
        ("makkar", [95.0, 3e3, 200.0, 50.0, 3e3, 900.0]),
        ("stribeck+position:2", [90.0, 40.0, 900.0, 1e-3, 1.0, 0.1, 0.05, 0.02, 0.02, 0.01]),
    ],
)
def test_starts_and_constants_of_many_sets_are_those_of_a_rig_set_to_them(
    name: str, p: list[float]
) -> None:
    """From event to event, in steps that samples do not cut, and from sample to sample."""
    law = law_named(name)
    t = np.arange(0.0, 20.005, 0.01)
    stroke = track(Drive.line(0.0, 0.0, 20.0, 5e-3), t, 1e-3)
    starts, masses = np.array([0.0, 1e-3, 1e-3, 2e-3]), np.array([10.9, 12.0, 9.0, 12.0])
    dv = np.array([0.1, 0.1, 0.2, 0.1])  # mm/s
    sets = np.array([[*p, 967.98]] * 4) * np.array([1.0, 1.0, 1.1, 0.9])[:, None]
    together = SLIDE_BED.positions_from(law, sets, stroke, starts, {"m": masses, "dv": 1e-3 * dv})
    for k in range(4):
        rig = SLIDE_BED.set(m=float(masses[k]), dv=float(dv[k]))
        alone = rig.positions(law, sets[k : k + 1], stroke.begun_at(float(starts[k]), 0.0))
        assert together[k].tobytes() == alone[0].tobytes()
    assert len({row.tobytes() for row in together}) == 4
    assert np.ptp(together, axis=1).min() > 1e-3  # they move
