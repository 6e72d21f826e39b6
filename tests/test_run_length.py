"""Run lengths of control charts against published tables."""

import numpy as np
import pytest

from stribeck.monitoring.run_length import (
    cusum_limit,
    cusum_run_length,
    ewma_limit,
    ewma_run_length,
)


@pytest.mark.parametrize(
    ("h", "shift", "published"),
    # Montgomery, Introduction to Statistical Quality Control, table of ARLs at k = 0.5, after
    # Lucas and Crosier 1982, doi 10.1080/00401706.1982.10487759.
    [(4, 0, 168), (4, 0.5, 26.6), (4, 1, 8.38), (4, 2, 3.34), (4, 4, 1.71),
     (5, 0, 465), (5, 0.5, 38.0), (5, 1, 10.4), (5, 2, 4.01), (5, 4, 2.01)],
)  # fmt: skip
def test_cusum_runs_as_long_as_published(h: float, shift: float, published: float) -> None:
    assert cusum_run_length(0.5, h, shift) == pytest.approx(published, rel=0.004)


@pytest.mark.parametrize(
    ("share", "limit", "shift", "published"),
    # Lucas and Saccucci 1990, table 3, doi 10.1080/00401706.1990.10484583.
    [(0.4, 3.054, 0, 500), (0.4, 3.054, 1, 14.3), (0.25, 2.998, 0, 500), (0.25, 2.998, 1, 11.1),
     (0.1, 2.814, 0, 500), (0.1, 2.814, 0.5, 31.3), (0.1, 2.814, 1, 10.3), (0.1, 2.814, 2, 4.36)],
)  # fmt: skip
def test_ewma_runs_as_long_as_published(
    share: float, limit: float, shift: float, published: float
) -> None:
    assert ewma_run_length(share, limit, shift) == pytest.approx(published, rel=0.006)


@pytest.mark.parametrize("length", [5.0, 100.0, 730.0, 1e5])
def test_limits_give_the_run_length_that_was_asked_for(length: float) -> None:
    assert cusum_run_length(1.0, cusum_limit(1.0, length)) == pytest.approx(length, rel=1e-4)
    assert ewma_run_length(0.1, ewma_limit(0.1, length)) == pytest.approx(length, rel=1e-4)


def test_values_that_count_for_at_most_so_much_run_as_long_as_simulated() -> None:
    """Both charts stepped value by value, 4,000 runs: means are within four of their errors."""
    k, h, share, limit, most = 1.0, 1.5, 0.1, 2.1, 1.0 + 0.75 * 1.5
    draw = np.random.default_rng(11)
    up, down, average, alive = np.zeros(4000), np.zeros(4000), np.zeros(4000), np.ones((2, 4000))
    lengths = np.zeros((2, 4000))
    while alive.any():
        z = np.clip(draw.normal(size=4000), -most, most)
        lengths += alive
        up, down = np.maximum(0.0, up + z - k), np.maximum(0.0, down - z - k)
        average = (1.0 - share) * average + share * z
        alive[0] *= np.maximum(up, down) <= h
        alive[1] *= np.abs(average) <= limit * np.sqrt(share / (2.0 - share))
    errors = lengths.std(axis=1) / np.sqrt(4000)
    cusum = cusum_run_length(k, h, most=most)
    ewma = ewma_run_length(share, limit, most=most)
    assert (np.abs(lengths.mean(axis=1) - [cusum, ewma]) < 4.0 * errors).all()
    assert cusum > 1.3 * cusum_run_length(k, h)
