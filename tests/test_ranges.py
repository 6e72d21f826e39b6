"""Ranges of positions and times: units, the samples inside, the start of a simulation."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stribeck import InputError, Recording
from stribeck.data.ranges import FEWEST, Range, Window, start_of, windows
from stribeck.data.segmentation import segment
from stribeck.rig.twin import TestBed

BOTH = TestBed().run("both", seed=2).recording
NUMBERS = st.floats(-1e6, 1e6, allow_nan=False)


@given(a=NUMBERS, b=NUMBERS)
def test_a_bare_number_is_a_position_in_the_unit_shown(a: float, b: float) -> None:
    text = f"{a!r}:{b!r}"
    if a * 1e-3 == b * 1e-3:
        with pytest.raises(InputError, match="is empty"):
            Range.parse(text, "mm")
        return
    parsed = Range.parse(text, "mm")
    assert (parsed.start, parsed.stop) == pytest.approx((a * 1e-3, b * 1e-3))
    assert not parsed.timed
    assert parsed.direction == (1 if b > a else -1)


@pytest.mark.parametrize(
    ("text", "shown", "start", "stop", "timed"),
    [
        ("112:295", "mm", 0.112, 0.295, False),
        ("112:295mm", "m", 0.112, 0.295, False),
        ("11.2cm:0.295m", "mm", 0.112, 0.295, False),
        (" .5 : -1e1 ", "m", 0.5, -10.0, False),
        ("10s:40s", "mm", 10.0, 40.0, True),
        ("10:40s", "mm", 10.0, 40.0, True),
        ("500ms:1min", "mm", 0.5, 60.0, True),
        ("-90deg:90deg", "rad", -np.pi / 2, np.pi / 2, False),
        ("0:180", "deg", 0.0, np.pi, False),
    ],
)
def test_units(text: str, shown: str, start: float, stop: float, timed: bool) -> None:
    parsed = Range.parse(text, shown)
    assert (parsed.start, parsed.stop) == pytest.approx((start, stop))
    assert parsed.timed == timed
    assert parsed.text == "".join(text.split())  # it names files and rows of a table


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("", "write A:B"),
        ("112", "write A:B"),
        ("112:", "write A:B"),
        ("112:295:300", "write A:B"),
        ("nan:5", "write A:B"),
        ("inf:5", "write A:B"),
        ("1:2\x00", "write A:B"),
        ("1e999:5", "finite"),
        ("1:-1e999", "finite"),
        ("5:5", "is empty"),
        ("50mm:5cm", "is empty"),
        ("40s:10s", "earlier time first"),
        ("10s:40mm", "both in s"),
        ("10N:40N", "both in s"),
        ("10deg:40deg", "both in s"),
        ("10foo:40foo", "unknown unit 'foo'"),
    ],
)
def test_what_is_refused(text: str, word: str) -> None:
    with pytest.raises(InputError, match=word) as refused:
        Range.parse(text, "mm")
    assert repr(text) in str(refused.value)


@given(text=st.text(max_size=20))
def test_any_text_is_a_range_or_one_line(text: str) -> None:
    try:
        parsed = Range.parse(text, "mm")
    except InputError as error:
        assert len(str(error).splitlines()) == 1  # noqa: PT017 - either way is right
        return
    assert parsed.start != parsed.stop


@pytest.mark.parametrize(("text", "direction"), [("112:295", 1), ("295:112", -1)])
def test_a_range_of_positions_is_the_stroke_that_runs_its_way(text: str, direction: int) -> None:
    (window,) = windows(BOTH, Range.parse(text, "mm"))
    x = BOTH.position[window.rows]
    assert (x[-1] - x[0]) * direction > 0.15
    assert BOTH.command is not None
    command = np.diff(BOTH.command[window.rows])
    assert (command * direction >= -1e-12).all()
    # From the first sample inside to the one before the first beyond.
    low, high = 0.112, 0.295
    assert low <= x[0] <= high
    assert (x * direction <= (high if direction > 0 else -low)).all()


def test_ranges_that_meet_share_no_sample() -> None:
    first, second = (windows(BOTH, Range.parse(text, "mm"))[0] for text in ("60:112", "112:295"))
    assert first.rows.start < first.rows.stop <= second.rows.start
    assert first.since == second.since  # of one stroke


def test_a_range_of_times_is_a_slice_of_the_clock() -> None:
    (window,) = windows(BOTH, Range.parse("10s:40s", "mm"))
    t = BOTH.t[window.rows]
    assert 10.0 <= t[0] < t[-1] < 40.0
    assert len(t) == 3000
    assert windows(BOTH, None) == [Window(slice(0, len(BOTH)), 0)]


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("900:1000", "no rightward stroke"),
        ("1000:900", "no leftward stroke"),
        ("500s:600s", "0 to 122 s"),
        ("10s:10.05s", r"holds 5 samples, 10 are needed"),
    ],
)
def test_a_range_that_holds_nothing(text: str, word: str) -> None:
    with pytest.raises(InputError, match=word) as refused:
        windows(BOTH, Range.parse(text, "mm"))
    assert text in str(refused.value)


def test_a_model_starts_at_the_last_rest_before_a_range() -> None:
    segmentation = segment(BOTH)
    for text in ("112:295", "150:250", "325:127"):
        for window in windows(BOTH, Range.parse(text, "mm"), segmentation):
            start = start_of(segmentation, window)
            assert start is not None
            assert window.since <= start.rest.stop
            assert start.rest.start <= start.rows.start
            assert start.rows.stop == window.rows.stop
            rest = BOTH.position[start.rest]
            assert len(rest) >= FEWEST
            assert np.ptp(rest) < 12 * 0.3e-3  # noise of the echo alone: 12 sd of it
            nearer = [
                r
                for r in segmentation.rests
                if start.rest.stop < r.start < r.stop < window.rows.start
            ]
            assert not nearer


def test_an_axis_that_never_rests_has_no_start() -> None:
    t = np.arange(0.0, 5.0, 0.01)
    moving = Recording(t=t, position=0.01 * t)
    assert start_of(segment(moving), windows(moving, None)[0]) is None
