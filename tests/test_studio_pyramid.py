"""Extremes by levels are those of the rows themselves."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stribeck.studio.pyramid import FACTOR, Pyramid, windowed


@given(
    rows=st.integers(10, 60_000), pixels=st.integers(3, 700),
    share=st.tuples(st.floats(0, 1), st.floats(0, 1)), seed=st.integers(0, 2**32 - 1),
)  # fmt: skip
def test_a_plot_keeps_every_extreme(
    rows: int, pixels: int, share: tuple[float, float], seed: int
) -> None:
    rng = np.random.default_rng(seed)
    values = np.cumsum(rng.normal(size=rows))
    values[rng.integers(rows)] += 100.0  # a spike of one sample, which a mean would hide
    t = np.arange(0.0, rows) * 0.01
    since, until = sorted(t[int(s * (rows - 1))] for s in share)
    times, lines, exact = windowed(t, {"x": Pyramid(values)}, since, until, pixels)
    inside = values[(t >= since) & (t <= until)]
    shown = lines["x"]
    assert shown.max() >= inside.max()
    assert shown.min() <= inside.min()
    assert (np.diff(times) > 0).all()
    assert len(times) <= 2 * pixels + 4
    if exact:
        assert set(inside) <= set(shown)
    else:  # what stands there is a value of the log, and not far from where it stands
        places = np.searchsorted(t, times)
        pixel = 2 * (np.diff(places).max() + FACTOR)
        reach = pixel + pixel // FACTOR  # runs that a pixel is made of end beyond it by so much
        for at, value in zip(places, shown, strict=True):
            assert value in values[max(at - reach, 0) : at + reach]


def test_missing_rows_break_the_line() -> None:
    t = np.concatenate([np.arange(0.0, 100.0), np.arange(300.0, 400.0)]) * 0.01
    times, lines, _ = windowed(t, {"x": Pyramid(np.ones(200))}, 0.0, 4.0, 500)
    (gap,) = np.flatnonzero(np.isnan(lines["x"]))
    assert t[99] < times[gap] < t[100]


@pytest.mark.parametrize("rows", [2, 3, 5000, 100_000])
def test_levels_halve_until_they_are_small(rows: int) -> None:
    values = np.random.default_rng(0).normal(size=rows)
    for level, (low, high) in enumerate(Pyramid(values).levels, 1):
        span = FACTOR**level
        assert len(low) == -(-rows // span)
        for k in range(0, len(low), max(len(low) // 7, 1)):
            part = values[k * span : (k + 1) * span]
            assert (low[k], high[k]) == (part.min(), part.max())
