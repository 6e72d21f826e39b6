"""The comparison of two checkouts' results: what differs, apart from times."""

from __future__ import annotations

import json
import math
import zipfile
from io import BytesIO
from typing import Any

import pytest

from result_differences import (
    Difference,
    file_differences,
    printed_differences,
    without_progress,
)


def printed(before: str, after: str) -> list[Difference]:
    return list(printed_differences("stdout", before, after))


def files(name: str, before: str, after: str) -> list[Difference]:
    return list(file_differences(name, before.encode(), after.encode()))


@pytest.mark.parametrize(
    "text",
    [
        "mbts, seed 0: 3,529 evaluations in 3 repeats, {} s, ended: settled",
        "{}.11 s: start-up 0.{}, reading 0.02, search 0.44, uncertainty 0.70, card 0.06",
        "{}.11 s: start-up 0.{}, search 0.44, figures 5.77, report\n0.{}",
        "samples in effect; fits took {} s",
        "paper: 94/94 runs, 48 met their target in {} min",
        "| search time, BTS less than ATS | 37.15 | {} |",
        '  "seconds": {},',
        "joint     stribeck   1.59e+03 mrad    1.1 mrad   0.22   {}.5 ms",
    ],
)
def test_what_something_took_is_no_difference(text: str) -> None:
    assert not printed(text.replace("{}", "8"), text.replace("{}", "17"))


def test_a_digit_is_a_difference_and_how_large_is_told() -> None:
    (diff,) = printed("a\nF_C  41.191  N  41.9", "a\nF_C  41.192  N  41.9")
    assert diff.field == "stdout:2"
    assert diff.relative == pytest.approx(1 / 41192)
    assert not diff.spacing


def test_a_word_is_a_difference_without_a_size() -> None:
    (diff,) = printed("F_C 41 weak", "F_C 41 identified")
    assert math.isnan(diff.relative)


def test_spacing_is_told_apart_in_print_and_counts_in_a_file() -> None:
    (diff,) = printed("a  b", "a b")
    assert diff.spacing
    (diff,) = files("friction.st", "a  b", "a b")
    assert not diff.spacing


def test_a_line_more_is_a_difference() -> None:
    (diff,) = printed("a\nb", "a\nb\nwarning: c")
    assert (diff.before, diff.after) == ("absent", "warning: c")


def card(value: float, seconds: float, **fields: Any) -> str:
    """The text of a short card."""
    search = {"seconds": seconds, "evaluations": 7}
    content = {"F_C": {"value": value, "low": None}, "search": search, "software": {"a": seconds}}
    return json.dumps(content | {"trace": [0.1 * k for k in range(20)]} | fields)


def test_a_card_is_compared_field_by_field() -> None:
    assert not files("card.json", card(0.1, 1.0), card(0.1, 2.0))
    (diff,) = files("card.json", card(0.1, 1.0), card(0.1 + 1e-16, 2.0))
    assert diff.field == "card.json:F_C.value"
    assert 0 < diff.relative < 1e-15


def test_a_long_list_is_told_by_its_largest_difference() -> None:
    trace = [0.1 * k for k in range(20)]
    trace[3] *= 1 + 1e-9
    trace[7] *= 1.5
    (diff,) = files("card.json", card(1, 1), card(1, 1, trace=trace))
    assert diff.field == "card.json:trace[7] (2 of 20)"
    assert diff.relative == pytest.approx(1 / 3)


def test_a_field_more_and_a_type_are_differences() -> None:
    fields = [d.field for d in files("card.json", card(1, 1), card(1, 1, low=None))]
    assert fields == ["card.json:low"]
    assert files("card.json", '{"a": 1}', '{"a": 1.0}')
    assert files("card.json", '{"a": 1}', '{"a": true}')
    assert files("card.json", '{"a": NaN}', '{"a": 1.0}')


def test_seconds_of_a_table_are_passed_over_and_nothing_beside() -> None:
    head = "function,time/s published,ours,rounds,ours,seconds\n"
    assert not files("t.csv", head + "BF,1,2.5,3,4,5", head + "BF,1,2.6,3,4,6")
    assert not files("p.csv", "what,ours\nsearch time,1", "what,ours\nsearch time,2")
    (diff,) = files("t.csv", head + "BF,1,2.5,3,4,5", head + "BF,1,2.6,3,4.5,6")
    assert (diff.field, diff.before, diff.after) == ("t.csv: ours, row 1 (1 of 1)", "4", "4.5")


def archive(source: str, guid: str) -> bytes:
    content = BytesIO()
    with zipfile.ZipFile(content, "w") as fmu:
        fmu.writestr("sources/axis.c", f'{source}\n#define AXIS_GUID "{{{guid}}}"\n')
        fmu.writestr("binaries/linux64/friction.so", guid.encode())
    return content.getvalue()


def test_a_unit_is_its_sources() -> None:
    a, b = "0" * 32, "f" * 32
    assert not list(file_differences("a.fmu", archive("x", a), archive("x", b)))
    (diff,) = file_differences("a.fmu", archive("x", a), archive("y", b))
    assert diff.field == "a.fmu!sources/axis.c:1"


def test_progress_comes_by_the_clock_and_is_passed_over() -> None:
    text = "1,273/24,000 evaluations, best J 0.003725 mrad\nstribeck\nstribeck\nnote: a\n"
    assert without_progress(text) == "stribeck\nnote: a"
