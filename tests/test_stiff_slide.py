"""Slides that creep: against explicit steps elsewhere, the stepper, energy and symmetry."""

from __future__ import annotations

import numpy as np
import pytest

from foreign import creeping_slide
from foreign.slide_bed import Bed
from stribeck.friction import LAWS, Law, law_named
from stribeck.rig.motion import implicit, stiff_slide
from stribeck.rig.motion.command import Drive
from stribeck.rig.motion.drives import CLAMP, F_FM, MASS, SLIDE
from stribeck.rig.motion.track import Track, track
from stribeck.rig.slide_bed import KNOT_SAMPLES, SLIDE_BED, with_inputs
from stribeck.space import Array

MAKKAR, LUGRE = LAWS["makkar"], LAWS["lugre"]
CREEPING = [
    law for law in LAWS.values() if not (law.sticks or law.loads or law.terms)
] + [law_named("maxwell-slip:2")]  # fmt: skip
#: A drop of friction that makes the slide jump; rises at rest that explicit steps still follow.
SETS = {
    "makkar": [95.0, 3e3, 200.0, 50.0, 3e3, 900.0],
    "lugre": [1e5, 3e3, 145.0, 50.0, 2e-3, 900.0],
}
K_SPRING = 967.98


def there_and_back(seconds: float = 40.0, start: float = 0.05) -> tuple[Array, Array]:
    """A rest, a ramp of 5 mm/s and the way back."""
    times = np.array([0.0, 1.0, 0.6 * seconds, seconds])
    way = 5e-3 * (times - 1.0)[2]
    return times, start + np.array([0.0, 0.0, way, way - 5e-3 * 0.4 * seconds])


def motion(
    law: Law, p: list[float] | Array, command: Track, tolerance: float = 1.0
) -> tuple[Array, Array]:
    laws, c = SLIDE_BED.split(law, np.array([p]))
    x, v = stiff_slide.trajectories(law, laws, c, command, tolerance)
    return x[0], v[0]


def of_path(times: Array, x: Array, rate: float = 100.0) -> Track:
    t = np.arange(round(times[-1] * rate) + 1) / rate
    return track(Drive(times, x), t, float(x[0]))


def bed() -> Bed:
    """The slide bed's own constants, one spring for both directions."""
    return Bed(
        m=SLIDE_BED["m"], k_hat_up=SLIDE_BED["k_hat+"], k_hat_down=SLIDE_BED["k_hat-"],
        k_spring_up=K_SPRING, k_spring_down=K_SPRING, F_fm=SLIDE_BED["F_fm"],
        K_J=SLIDE_BED["K_kt"] * SLIDE_BED["J_m"], K_D=SLIDE_BED["K_kt"] * SLIDE_BED["D_m"],
        F_m_max=SLIDE_BED["F_m_max"],
    )  # fmt: skip


@pytest.mark.parametrize("name", SETS)
def test_explicit_steps_of_microseconds_come_to_it_at_second_order(name: str) -> None:
    times, command = there_and_back()
    x, v = motion(LAWS[name], [*SETS[name], K_SPRING], of_path(times, command), 1e-2)
    assert (np.abs(v) > 20e-3).sum() > 20  # it jumps
    errors = []
    for h in (4e-5, 2e-5, 1e-5):
        other, _ = creeping_slide.simulate(bed(), name, np.array(SETS[name]), times, command, h)
        errors.append(np.sqrt(np.mean((other - x) ** 2)))
    assert errors[-1] < 3e-7, errors
    assert errors[0] / errors[1] > 3.0 or errors[0] < 1e-7, errors
    usual, _ = motion(LAWS[name], [*SETS[name], K_SPRING], of_path(times, command))
    assert np.sqrt(np.mean((usual - x) ** 2)) < 2e-6


@pytest.mark.parametrize("law", CREEPING, ids=lambda law: law.name)
def test_what_the_stepper_of_all_rigs_finds_is_found_in_fewer_steps(law: Law) -> None:
    times, command = there_and_back(30.0)
    ramp = of_path(times, command)
    p = SLIDE_BED.sample(law, np.random.default_rng(5), 4)
    laws, c = SLIDE_BED.split(law, p)
    x, _ = stiff_slide.trajectories(law, laws, c, ramp)
    stepped, _, _ = implicit.motions(law, SLIDE, laws, c, with_inputs(ramp), 2e-3, 1e-11)
    off = np.sqrt(np.mean((x - stepped) ** 2, axis=1))
    # One slide in some overtakes its command so slowly that any error of its start shows.
    assert np.median(off) < 3e-6, off


@pytest.mark.parametrize("law", [MAKKAR, LUGRE], ids=lambda law: law.name)
def test_the_motion_converges_with_its_tolerance(law: Law) -> None:
    times, command = there_and_back()
    ramp = of_path(times, command)
    p = [*SETS[law.name], K_SPRING]
    exact, _ = motion(law, p, ramp, 1e-4)
    errors = [np.sqrt(np.mean((motion(law, p, ramp, r)[0] - exact) ** 2)) for r in (100.0, 0.01)]
    assert errors[1] < 0.01 * errors[0], errors
    assert errors[1] < 5e-8, errors


@pytest.mark.parametrize(
    "law", [law for law in CREEPING if not law.directional], ids=lambda law: law.name
)
def test_left_is_the_mirror_of_right(law: Law) -> None:
    times, command = there_and_back(20.0, 0.0)
    p = SLIDE_BED.sample(law, np.random.default_rng(2), 1)
    laws, c = SLIDE_BED.split(law, p)
    c[:, 2] = c[:, 1]  # one stiffness of the motor
    x, _ = stiff_slide.trajectories(law, laws, c, of_path(times, command))
    mirrored, _ = stiff_slide.trajectories(law, laws, c, of_path(times, -command))
    # A stretch of zero counts as below zero, so that the two begin with other steps: they are as
    # far apart as a motion with finer steps is from either.
    fine, _ = stiff_slide.trajectories(law, laws, c, of_path(times, command), 1e-2)
    assert np.abs(mirrored + x).max() < 1e-6 + 5.0 * np.abs(fine - x).max()
    assert np.ptp(x) > 1e-5


@pytest.mark.parametrize("law", [MAKKAR, LUGRE], ids=lambda law: law.name)
def test_energy_is_accounted_for_and_friction_makes_none(law: Law) -> None:
    """A mass on a spring: what the command puts in is kinetic, elastic, or rubbed away."""
    times, command = there_and_back(20.0)
    p, rate = np.array([[*SETS[law.name], K_SPRING]]), 4000.0
    laws, c = SLIDE_BED.split(law, p)
    c[:] = 0.0
    c[:, MASS], c[:, 3:5], c[:, [F_FM, CLAMP]] = 10.9, 2000.0, np.inf
    t = of_path(times, command, rate).t
    x, v = (a[0] for a in stiff_slide.trajectories(law, laws, c, of_path(times, command, rate)))
    e = np.interp(t, times, command) - x
    steps = np.searchsorted(times, t, side="right") - 1
    rates = np.append(np.diff(command) / np.diff(times), 0.0)[steps]
    put_in = np.concatenate([[0.0], np.cumsum(0.5 * (2000.0 * e[1:] + 2000.0 * e[:-1])
                                              * rates[:-1] / rate)])  # fmt: skip
    rubbed = put_in - 0.5 * 10.9 * v**2 - 0.5 * 2000.0 * e**2
    assert rubbed[-1] > 0.05
    slack = 1e-4 * rubbed[-1]
    if law.states:  # a bristle gives back no more than it holds
        slack += 0.5 * (SETS["lugre"][2] ** 2) / SETS["lugre"][0]
        assert (np.maximum.accumulate(rubbed) - rubbed).max() < slack
    else:
        power = np.array([law.slip(float(w), laws[0]) * w for w in v])
        own = np.concatenate([[0.0], np.cumsum(0.5 * (power[1:] + power[:-1]) / rate)])
        assert np.abs(own - rubbed).max() < 2e-3 * rubbed[-1]
        assert np.diff(rubbed).min() > -slack


def test_a_slip_read_again_is_the_slip_integrated_again() -> None:
    """Corners of the command that bend nothing part a ramp: each slip is then a first one."""
    t = np.arange(6001) / 100.0
    ramp = track(Drive.line(0.0, 0.05, 60.0, 5e-3), t, 0.05)
    knots = np.arange(0.0, 60.01, 2.5)
    parted = track(Drive(knots, 0.05 + 5e-3 * knots), t, 0.05)
    for name, p in SETS.items():
        x, v = motion(LAWS[name], [*p, K_SPRING], ramp)
        assert (np.diff(np.sign(v - 5e-3)) > 0).sum() > 5  # slips
        again, _ = motion(LAWS[name], [*p, K_SPRING], parted)
        assert np.sqrt(np.mean((x - again) ** 2)) < 5e-6


def test_sampling_does_not_change_the_motion() -> None:
    times, command = there_and_back()
    p = [*SETS["lugre"], K_SPRING]
    fine, coarse = (motion(LUGRE, p, of_path(times, command, r))[0] for r in (1000.0, 100.0))
    np.testing.assert_array_equal(fine[::10], coarse)


def test_misfits_are_the_squares_of_the_residuals() -> None:
    times, command = there_and_back()
    laws, c = SLIDE_BED.split(MAKKAR, np.array([[*SETS["makkar"], K_SPRING]] * 3))
    ramp = of_path(times, command)
    x, _ = stiff_slide.trajectories(MAKKAR, laws, c, ramp)
    score = (np.arange(len(ramp.t)) % 3 > 0).astype(float)
    measured = x[0] + 1e-3 * np.sin(ramp.t)
    scored = track(Drive(times, command), ramp.t, ramp.x0, measured, score)
    sse = stiff_slide.misfits(MAKKAR, laws, c, scored)
    np.testing.assert_allclose(sse, (score * (measured - x[0]) ** 2).sum(), rtol=1e-9)


@pytest.mark.parametrize("value", [np.nan, np.inf, -1.0])
def test_what_is_impossible_gives_nan_and_no_hang(value: float) -> None:
    times, command = there_and_back(10.0)
    laws, c = SLIDE_BED.split(LUGRE, np.array([[*SETS["lugre"], K_SPRING]]))
    c[:, MASS] = value
    assert np.isnan(stiff_slide.misfits(LUGRE, laws, c, of_path(times, command))).all()
    p = laws.copy()
    p[:, 0] = np.nan
    _, c = SLIDE_BED.split(LUGRE, np.array([[*SETS["lugre"], K_SPRING]]))
    assert np.isnan(stiff_slide.misfits(LUGRE, p, c, of_path(times, command))).all()


def test_a_command_of_many_corners_is_stepped_as_its_samples_are() -> None:
    t = np.arange(2001) / 100.0
    sine = 0.05 + 0.01 * np.sin(t)
    p = np.array([[*SETS["lugre"], K_SPRING]])
    x = SLIDE_BED.move(LUGRE, p, track(Drive(t, sine), t, 0.05)).position
    laws, c = SLIDE_BED.split(LUGRE, p)
    events, _ = stiff_slide.trajectories(LUGRE, laws, c, track(Drive(t, sine), t, 0.05))
    assert len(t) < KNOT_SAMPLES * len(t)
    assert np.sqrt(np.mean((x - events) ** 2)) < 1e-6
