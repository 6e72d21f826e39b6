"""A force balance as a Fit: its logs and the samples that it uses."""

import numpy as np
import pytest

from stribeck import InputError, Recording, identify, validate


def log(reach: float, seed: int) -> Recording:
    """A 3 kg axis with 20 N of Coulomb and 50 N s/m of viscous friction, to +-reach metres."""
    t = np.arange(0.0, 20.0, 1e-3)
    w = 2 * np.pi * 0.25
    v, a = reach * w * np.cos(w * t), -reach * w * w * np.sin(w * t)
    noise = 0.5 * np.random.default_rng(seed).standard_normal(len(t))
    return Recording(t, reach * np.sin(w * t), force=3 * a + 20 * np.sign(v) + 50 * v + noise)


def test_a_log_outside_every_range_is_refused_not_dropped() -> None:
    wide, narrow = log(0.2, 0), log(0.05, 1)
    with pytest.raises(InputError, match="100:150 holds no motion"):
        identify([wide, narrow], rig="forced", train="100:150")


def test_a_log_that_is_only_held_out_is_no_training_log() -> None:
    wide, narrow = log(0.2, 0), log(0.05, 1)
    both_ways = ["100:150", "150:100"]  # one way alone, an offset looks like friction
    fit = identify([wide, narrow], rig="forced", train=both_ways, holdout="-40:40")
    assert [recording is wide for recording in fit.recordings] == [True]
    assert fit.values["F_C"] == pytest.approx(20.0, rel=0.05)
    assert 0 < fit.used(wide) < len(wide) / 5  # decimated by ten, and part of the strokes
    assert fit.holdout[0].score.value < 10.0


def test_a_fit_is_held_against_another_log() -> None:
    fit = identify(log(0.2, 0), rig="forced")
    ((name, range_name, score),) = validate(fit, log(0.2, 5))
    assert (name, range_name, score.name) == ("recording", "all", "relative_error")
    assert score.value == pytest.approx(fit.score.value, rel=0.2)
    assert fit.values["M"] == pytest.approx(3.0, rel=0.05)
