"""Low passes against those of SciPy, and against what they are defined by."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
from scipy.signal import butter, cheby1, sosfilt, sosfiltfilt, sosfreqz

from stribeck.data.low_pass import butterworth, chebyshev, settled
from stribeck.data.zero_phase import zero_phase

CUTOFFS = (1e-4, 0.003, 0.1, 0.3, 0.49)


@pytest.mark.parametrize("order", range(1, 11))
@pytest.mark.parametrize("cutoff", CUTOFFS)
def test_a_butterworth_is_scipys(order: int, cutoff: float) -> None:
    """The same sections; of an odd order SciPy gives the zeros of two to each other."""
    ours, theirs = butterworth(order, cutoff), butter(order, cutoff, fs=1.0, output="sos")
    assert ours.shape == theirs.shape
    np.testing.assert_allclose(ours[:, 3:], theirs[:, 3:], rtol=1e-14)
    if order % 2 == 0:
        np.testing.assert_allclose(ours, theirs, rtol=1e-14)
    f = np.array([0.1, 0.7, 1.0, 1.4]) * cutoff
    f = f[f < 0.5]
    (_, a), (_, b) = sosfreqz(ours, f, fs=1.0), sosfreqz(theirs, f, fs=1.0)
    np.testing.assert_allclose(a, b, rtol=1e-6)


@pytest.mark.parametrize("order", [1, 2, 4, 7])
def test_half_the_power_is_left_at_the_cut_off_of_a_butterworth(order: int) -> None:
    _, response = sosfreqz(butterworth(order, 0.07), [0.0, 0.07], fs=1.0)
    np.testing.assert_allclose(np.abs(response), [1.0, np.sqrt(0.5)], rtol=1e-10)


@pytest.mark.parametrize("order", [3, 8])
@pytest.mark.parametrize("cutoff", [0.004, 0.04, 0.2])
def test_a_chebyshev_is_scipys_and_ripples_as_it_says(order: int, cutoff: float) -> None:
    ours = chebyshev(order, 0.05, cutoff)
    theirs = cheby1(order, 0.05, 2.0 * cutoff, output="sos")
    np.testing.assert_allclose(ours[:, 3:], theirs[:, 3:], rtol=1e-14)
    _, response = sosfreqz(ours, np.linspace(0.0, cutoff, 500), fs=1.0)
    size = 20.0 * np.log10(np.abs(response))
    np.testing.assert_allclose([size.max(), size.min()], [0.0, -0.05], atol=1e-4)


@pytest.mark.parametrize(
    "sections", [butterworth(4, 0.02), butterworth(5, 0.1), butterworth(1, 0.3)]
)
def test_sections_that_have_settled_pass_a_constant_on(sections: np.ndarray) -> None:
    states = settled(sections)
    y, after = sosfilt(sections, np.full(500, 3.0), zi=3.0 * states)
    np.testing.assert_allclose(y, 3.0, rtol=1e-9)
    np.testing.assert_allclose(after, 3.0 * states, rtol=1e-8)


@pytest.mark.parametrize("order", [2, 4, 5])
def test_both_ways_it_is_what_scipy_makes_of_a_column(order: int) -> None:
    t = np.arange(3000) * 1e-3
    x = np.sin(9.0 * t) + 0.01 * np.random.default_rng(0).standard_normal(len(t))
    ours = zero_phase(
        butterworth(order, 0.02), lambda at: x[at], len(x), 3 * order, slice(0, len(x), 1)
    )[:, 0]
    theirs = sosfiltfilt(butter(order, 0.02, fs=1.0, output="sos"), x, padlen=3 * order)
    np.testing.assert_allclose(ours, theirs, atol=1e-10)


def test_an_identification_loads_neither_scipys_signal_nor_its_stats() -> None:
    """Each of them takes half a second to import."""
    code = (
        "import sys, numpy as np; from stribeck import Recording, identify; "
        "t = np.arange(0.0, 10.0, 5e-3); v = np.cos(2.0 * t); "
        "force = -24.0 * np.sin(2.0 * t) + 18.0 * np.sign(v); "
        "fit = identify(Recording(t, 0.5 * np.sin(2.0 * t), force=force), rig='forced'); "
        "print(fit.balance is not None, {'scipy.signal', 'scipy.stats'} & set(sys.modules))"
    )
    completed = subprocess.run(
        [sys.executable, "-c", code], check=True, capture_output=True, text=True
    )
    assert completed.stdout.strip() == "True set()"
