"""What the figures compute for themselves."""

from pathlib import Path

import numpy as np
import pytest
from scipy.signal import savgol_filter

from stribeck import identify
from stribeck.report.figures import DRAWN, draw, local_quadratics, reach
from stribeck.rig.testbed import TestBed


def test_local_quadratics_are_those_of_savitzky_and_golay() -> None:
    x = np.random.default_rng(0).standard_normal(200)
    inner = slice(4, -4)
    for order, found in enumerate(local_quadratics(x, 9, 0.02)):
        expected = savgol_filter(x, 9, 2, deriv=order, delta=0.02)[inner]
        np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9)


def test_a_fit_is_drawn_under_names_that_are_known(tmp_path: Path) -> None:
    log = TestBed().run("up", seed=2).recording
    fit = identify(log, train="112:295", holdout="44:112", budget=600, repeats=1)
    drawn = draw(fit, tmp_path)
    stems = {"convergence", "training", "holdout_44_112", "friction", "stribeck_curve"}
    assert {file.stem for file in drawn} == stems
    assert all(DRAWN.fullmatch(file.name) for file in drawn)
    assert all(file.stat().st_size > 5000 for file in drawn)
    # The law is drawn up to the speed of the slips, some tens of mm/s.
    assert reach(fit) == pytest.approx(0.07, rel=0.5)


def test_the_same_fit_has_the_same_drawings(tmp_path: Path) -> None:
    log = TestBed().run("up", seed=2).recording
    fit = identify(log, train="112:295", budget=60, repeats=1)
    first, second = (tmp_path / name for name in ("a", "b"))
    first.mkdir()
    second.mkdir()
    for one, other in zip(draw(fit, first), draw(fit, second), strict=True):
        assert one.read_bytes() == other.read_bytes()
