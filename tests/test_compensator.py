"""The compensator's definition, by hand: the speed that it takes, and its output."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from stribeck.compensate.compensator import (
    SETTINGS,
    TINY,
    Compensator,
    evaluation_velocity,
    sensor_dead_band,
    shaped_output,
)
from stribeck.errors import InputError

FORWARD, FEEDBACK = Compensator(feedback=False, dead_band=1e-3).c, Compensator(dead_band=1e-3).c
CROSSOVER = Compensator(dead_band=1e-3, crossover=0.01).c


@pytest.mark.parametrize(
    ("v_ref", "v", "c", "speed"),
    [
        (0.02, -0.3, FORWARD, 0.02),  # feed-forward does not look at the axis
        (0.0, 0.3, FORWARD, 0.0),
        (0.02, -0.3, FEEDBACK, -0.3),  # feedback goes with the axis, even against the reference
        (-0.02, 0.0011, FEEDBACK, 0.0011),
        (0.02, 0.001, FEEDBACK, TINY),  # rests: pushed the way the reference goes
        (0.02, -0.0009, FEEDBACK, TINY),
        (-0.02, 0.0009, FEEDBACK, -TINY),
        (0.009, 0.004, CROSSOVER, 0.004),  # a slow reference: as with feedback
        (0.009, 0.0009, CROSSOVER, TINY),
        (0.009, 0.3, CROSSOVER, 0.01),  # no further than where friction falls
        (0.009, -0.3, CROSSOVER, -0.01),
        (-0.02, 0.004, CROSSOVER, -0.02),  # a fast one: at the reference's
        (0.02, 0.0, CROSSOVER, 0.02),
    ],
)
def test_the_law_is_evaluated_at(v_ref: float, v: float, c: Any, speed: float) -> None:
    assert evaluation_velocity(v_ref, v, c) == speed


def output(
    force: float, v_ref: float, before: float = 0.0, h: float = 0.01, **set_: float
) -> float:
    compensator = Compensator(**{"scale": 0.5, "reference_band": 1.0, "smoothing": 2.0, **set_})  # type: ignore[arg-type]
    return float(shaped_output(force, v_ref, h, before, compensator.c))


def test_the_output_grows_with_the_references_speed_and_rests_with_it() -> None:
    speeds = (0.0, 0.99, 1.0, 1.5, 2.0, 3.0, 50.0)
    assert [output(8.0, v) for v in speeds] == [0.0, 0.0, 0.0, 1.0, 2.0, 4.0, 4.0]
    assert [output(-8.0, -v) for v in speeds] == [0.0, 0.0, 0.0, -1.0, -2.0, -4.0, -4.0]


def test_the_sensors_dead_band_is_none_of_the_reference() -> None:
    assert output(8.0, 3.0, dead_band=1e3) == 4.0
    assert output(8.0, 3.0, dead_band=1e3, reference_band=4.0) == 0.0


def test_without_smoothing_the_output_is_a_step() -> None:
    assert output(8.0, 1.0, smoothing=0.0) == 0.0
    assert output(8.0, 1.0 + 1e-12, smoothing=0.0) == 4.0


def test_what_the_drive_eats_is_added_on_the_side_of_the_friction() -> None:
    assert output(8.0, 9.0, drive=2.0) == 5.0
    assert output(-8.0, 9.0, drive=2.0) == -5.0  # also where that is against the reference
    assert output(0.0, 9.0, drive=2.0) == 0.0


def test_the_output_changes_and_reaches_no_further_than_it_may() -> None:
    assert output(80.0, 9.0, slew=300.0, h=0.01) == 3.0
    assert output(80.0, 9.0, before=39.0, slew=300.0) == 40.0
    assert output(-80.0, 9.0, before=39.0, slew=300.0) == 36.0
    assert output(80.0, 0.0, before=39.0, slew=300.0) == 36.0  # also where the reference stops
    assert output(80.0, 9.0, limit=7.0) == 7.0
    assert output(-80.0, 9.0, limit=7.0) == -7.0
    assert output(-80.0, 9.0, before=6.0, slew=1e4, limit=7.0) == -7.0


def test_compiled_and_plain_python_are_the_same_function() -> None:
    rng = np.random.default_rng(5)
    for _ in range(300):
        c = np.abs(rng.normal(size=10)) * rng.integers(0, 2, 10)
        c[7] = TINY
        force, v_ref, v, before = rng.normal(size=4)
        assert evaluation_velocity(v_ref, v, c) == evaluation_velocity.py_func(v_ref, v, c)
        arguments = (force, v_ref, 0.01, before, c)
        assert shaped_output(*arguments) == shaped_output.py_func(*arguments)


def test_every_setting_stands_in_its_own_place() -> None:
    values = {s.name: 0.1 * k + 0.1 for k, s in enumerate(SETTINGS)} | {"feedback": True}
    c = Compensator(**values).c  # type: ignore[arg-type]
    assert [s.index for s in SETTINGS] == list(range(len(c)))
    assert all(c[s.index] == float(values[s.name]) for s in SETTINGS)


@pytest.mark.parametrize("name", [s.name for s in SETTINGS if s.name != "feedback"])
@pytest.mark.parametrize("value", [-1.0, np.nan, np.inf])
def test_settings_that_cannot_be_are_refused(name: str, value: float) -> None:
    with pytest.raises(InputError, match=name):
        Compensator(**{name: value})  # type: ignore[arg-type]


def test_a_law_is_not_asked_at_rest_itself() -> None:
    with pytest.raises(InputError, match="beside rest"):
        Compensator(rest=0.0)


def test_an_axis_that_trembles_between_two_counts_is_seen_to_rest() -> None:
    resolution, h = 2e-6, 1e-3
    assert resolution / h < sensor_dead_band(resolution, h) < 2 * resolution / h
