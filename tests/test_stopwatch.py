"""The stopwatch: every second counts in exactly one lap."""

from __future__ import annotations

import subprocess
import sys
import time

from hypothesis import given
from hypothesis import strategies as st

from stribeck.report.stopwatch import Stopwatch

AGE = """
import time
began = time.perf_counter()
from stribeck.report.stopwatch import process_age
print(time.perf_counter() - began, process_age())
"""


@given(
    st.lists(st.tuples(st.sampled_from("abc"), st.integers(0, 9), st.integers(0, 9) | st.none()))
)
def test_laps_add_up_to_what_has_passed_when_the_last_takes_all(
    laps: list[tuple[str, int, int | None]],
) -> None:
    clock = [100.0]
    watch = Stopwatch(began=98.0, now=lambda: clock[0])
    for name, later, seconds in laps:
        clock[0] += later
        watch.lap(name, seconds)
        assert watch.total <= clock[0] - 98.0
    watch.lap("rest")
    assert watch.total == clock[0] - 98.0
    assert all(seconds >= 0 for seconds in watch.laps.values())


def test_a_lap_may_be_a_part_of_the_time_and_the_next_takes_the_rest() -> None:
    clock = [0.0]
    watch = Stopwatch(began=0.0, now=lambda: clock[0])
    clock[0] = 5.0
    watch.lap("search", 3.0)
    watch.lap("uncertainty")
    assert watch.line() == "5.00 s: search 3.00, uncertainty 2.00"


def test_a_process_is_no_older_than_the_time_since_it_was_asked_for() -> None:
    start_time = time.perf_counter()
    completed = subprocess.run(
        [sys.executable, "-c", AGE], check=True, capture_output=True, text=True
    )
    tick = 0.02  # of the system's clock, which counts hundredths
    # Python's own start comes before its first line.
    own_age, age = map(float, completed.stdout.split())
    assert own_age < age < time.perf_counter() - start_time + tick
