"""A measured motion as it drives states: its path, its friction, and what was before it."""

from __future__ import annotations

import numpy as np
import pytest

from foreign import combined
from foreign.driven import Loop
from foreign.presliding import LuGre
from foreign.strokes import sines
from stribeck.data.motion_path import motion_path, turns
from stribeck.friction import law_named
from stribeck.friction.yield_spectrum import Spectrum
from stribeck.rig.measured_path import MeasuredPath, elements_along
from stribeck.space import Array

T = np.arange(0.0, 4.0, 1e-3)


def path(x: Array, starts: tuple[int, ...] = (0,), dt: float = 1e-3) -> MeasuredPath:
    v = np.gradient(x, dt)
    return MeasuredPath(np.diff(x, prepend=x[0]), v, dt, np.array(starts, dtype=np.int64), 0.0)


# --- the path -------------------------------------------------------------------------------------


def test_noise_makes_no_way() -> None:
    """A sine of two cycles is 8 amplitudes long; its noise alone goes a hundred."""
    x = np.sin(np.pi * T)
    noisy = x + 0.02 * np.random.default_rng(3).standard_normal(len(T))
    length = np.abs(np.diff(motion_path(noisy, 0.16, 0.02))).sum()
    assert np.abs(np.diff(noisy)).sum() > 80.0
    assert length == pytest.approx(8.0, rel=0.05)


def test_what_turns_back_by_less_than_the_threshold_is_no_reversal() -> None:
    x = T + 0.05 * np.sin(40.0 * T)  # turns back by 0.04 each time
    assert len(turns(x, 0.08)) == 2
    assert len(turns(x, 0.01)) == 2 + int(2 * 40.0 * 4.0 / (2.0 * np.pi) + 0.5)
    assert (np.diff(motion_path(x, 0.08, 0.0)) >= 0.0).all()


def test_the_path_of_a_clean_motion_is_itself() -> None:
    x = np.sin(5.0 * T) + 0.3 * np.sin(17.0 * T)
    np.testing.assert_array_equal(motion_path(x, 1e-6, 0.0), x)


@pytest.mark.parametrize("seed", range(6))
def test_the_ends_of_noisy_strokes_are_cut(seed: int) -> None:
    """The farthest sample of a stroke lies 2 sd too far, as does a monotone path; cut, one."""
    x = np.sin(np.pi * np.arange(0.0, 20.0, 1e-3))
    noisy = x + 0.01 * np.random.default_rng(seed).standard_normal(len(x))
    ends = turns(noisy, 0.08)[1:-1]
    assert len(ends) == 20  # noise before the first stroke is no turn
    paths = (noisy, *(motion_path(noisy, 0.08, sd) for sd in (0.0, 0.01)))
    far = [np.abs(p[ends]).mean() for p in paths]
    assert far == pytest.approx([1.022, 1.02, 1.01], abs=0.004)


# --- friction along it ----------------------------------------------------------------------------


def test_maxwell_elements_are_iwans_loops() -> None:
    """Masing: back from the virgin curve F(x) it goes by F(X) - 2 F((X - x)/2)."""
    law, p = law_named("maxwell-slip:2"), np.array([2.0, 3.0, 0.1, 4.0, 0.0])
    x = np.concatenate([np.linspace(0.0, 0.3, 301), np.linspace(0.3, -0.3, 601)[1:]])

    def virgin(way: Array) -> Array:
        return 2.0 * np.minimum(way / 0.1, 1.0) + 3.0 * np.minimum(way / 0.4, 1.0)

    back = virgin(np.array([0.3])) - 2.0 * virgin((0.3 - x[301:]) / 2.0)
    friction = path(x).friction(law, p)
    np.testing.assert_allclose(friction[:301], virgin(x[:301]), atol=1e-9)
    np.testing.assert_allclose(friction[301:], back, atol=1e-9)
    shares = elements_along(path(x).way, np.zeros(1, dtype=np.int64), np.array([0.1, 0.4]))
    np.testing.assert_allclose(shares @ [2.0, 3.0], friction, atol=1e-9)


@pytest.mark.parametrize("name", ["lugre", "gms:2"])
def test_friction_along_a_foreign_motion(name: str) -> None:
    """Driven by the motion of a foreign axis, our friction is the one that acted there."""
    times, command = sines(4.0, np.array([30e-6, 4e-3]), np.array([3.0, 0.4]))
    own: LuGre | combined.Elements
    if name == "lugre":
        own = LuGre(5e5, 800.0, 14.0, 10.0, 5e-3, 60.0)
        p = np.array(own)
    else:
        own = combined.Elements(
            np.array([4.0, 6.0]), np.array([4e-6, 16e-6]), 60.0, 1.3, 5e-3, 0.01
        )
        p = np.array([4.0, 6.0, 4e-6, 4.0, 60.0, 1.3, 5e-3, 0.01])
    m = combined.simulate(10.0, own, Loop(kp=4e5, kd=3e3, tick=1e-4), times, command, h=5e-6)
    driven = MeasuredPath(
        np.diff(m.position, prepend=m.position[0]), m.velocity, 1e-3,
        np.zeros(1, dtype=np.int64), 0.0,
    )  # fmt: skip
    friction = driven.friction(law_named(name), p)
    assert np.sqrt(np.mean((friction - m.friction) ** 2)) < 0.004 * np.abs(m.friction).max()


def test_a_slide_wipes_out_what_was_before() -> None:
    """An element of yield d forgets once the axis has gone 2 d one way."""
    law, p = law_named("maxwell-slip:1"), np.array([5.0, 0.1, 0.0])
    driven = path(0.1 * T, starts=(0, 2500))
    unknown = driven.memory(law, p)
    assert unknown[0] == pytest.approx(10.0)
    assert unknown[1000] == pytest.approx(5.0, abs=0.01)
    assert (unknown[2001:2500] < 1e-9).all()
    assert unknown[2500] == pytest.approx(10.0)


# --- the spectrum ---------------------------------------------------------------------------------


def test_a_spectrum_merges_to_fewer_elements() -> None:
    yields = np.array([1.0, 1.2, 30.0, 40.0, 500.0])
    levels = np.array([2.0, 2.0, 1.0, 1.0, 0.0])
    spectrum = Spectrum(yields, levels, np.array([1.0]))
    W, d = spectrum.merged(2)
    np.testing.assert_allclose(W, [4.0, 2.0])
    np.testing.assert_allclose(d, np.sqrt([1.2, 1200.0]))
    assert spectrum.level == 6.0
    assert spectrum.way == 1.2
    W, d = Spectrum(np.array([8.0]), np.array([3.0]), np.array([1.0])).merged(3)
    assert W.sum() == pytest.approx(3.0)
    assert (np.diff(d) > 0).all()


def test_a_drop_with_speed_is_no_element() -> None:
    """Of a spectrum that was seen, 2 % of the friction yields after a hundred times the way."""
    yields, levels = np.array([27e-6, 80e-6, 138e-6, 11e-3]), np.array([6.12, 7.73, 1.09, 0.28])
    spectrum = Spectrum(yields, levels, np.array([1.0]))
    assert spectrum.merged(2)[1][1] == pytest.approx(11e-3)
    W, d = spectrum.without_tail().merged(2)
    np.testing.assert_allclose(W, levels[:2])
    np.testing.assert_allclose(d, yields[:2])
