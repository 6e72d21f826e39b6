"""The fault table: what it calls a lie and an alarm, and a slice of its rows."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import fault_table
import faults
import run
from fault_row import Row, axis_of, fault
from fault_rows import ROWS
from foreign_axes import noisy


def answer(row: Row, seed: int = 0, *sentences: str, **parameters: Any) -> dict[str, Any]:
    return {
        "key": row.key, "seed": seed, "seconds": 1.0, "sentences": list(sentences),
        "conditions": [], "parameters": parameters,
    }  # fmt: skip


def estimate(value: float, low: float, high: float, verdict: str = "identified") -> dict[str, Any]:
    return {
        "shown": "M", "truth": 10.0, "value": value, "interval": [low, high], "verdict": verdict,
        "reason": None,
    }  # fmt: skip


CLEAN = next(row for row in ROWS if row.clean and row.axis == "forced")
LATE = next(row for row in ROWS if row.perturbation == "force 10 ms late")


# --- rows -----------------------------------------------------------------------------------------


def test_there_are_sixty_rows_and_more_of_every_kind() -> None:
    faulty = [row for row in ROWS if not row.clean]
    kinds = {row.axis for row in ROWS}
    assert len(faulty) >= 60
    assert kinds == set(fault_table.TITLES)
    for kind in kinds:
        assert sum(row.axis == kind for row in faulty) >= 5
        assert sum(row.seeds for row in ROWS if row.axis == kind and row.clean) >= 5
    assert len({row.key for row in ROWS}) == len(ROWS)
    assert len({(row.axis, row.perturbation, row.exact) for row in faulty}) == len(faulty)


def test_a_key_is_of_what_a_row_does_and_not_of_its_words() -> None:
    assert Row(LATE.axis, "another name", "other words", LATE.faults).key == LATE.key
    later = fault("delayed", "force", seconds=11e-3)
    assert Row(LATE.axis, LATE.perturbation, LATE.words, later).key != LATE.key


def test_a_fault_changes_its_channel_alone() -> None:
    rng = np.random.default_rng(0)
    (table,) = noisy(axis_of(CLEAN), rng)
    for one in (row.faults[0] for row in ROWS if row.axis == "forced" and row.faults):
        faulty = one.applied(table, rng)
        changed = {
            name
            for name, values in faulty.items()
            if len(values) != len(table[name]) or not np.array_equal(values, table[name])
        }
        assert changed == ({one.channel} if one.channel else set(table)), one


# --- judging --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("sentences", "estimates", "lies"),
    [
        ((), estimate(11.0, 10.5, 11.5), True),
        ((), estimate(11.0, 9.5, 11.5), False),  # it holds the truth
        ((), estimate(10.2, 10.1, 10.3), False),  # it is near enough
        ((), estimate(11.0, 10.5, 11.5, "weak"), False),
        (("the force is 9 ms behind the motion",), estimate(11.0, 10.5, 11.5), False),
        (("M is biased by something",), estimate(11.0, 10.5, 11.5), False),
        (("MN is something else",), estimate(11.0, 10.5, 11.5), True),
        (("5 rows are late",), estimate(11.0, 10.5, 11.5), True),  # said without a fault, too
    ],
)
def test_what_is_a_silent_lie(
    sentences: tuple[str, ...], estimates: dict[str, Any], lies: bool
) -> None:
    rows = [
        answer(CLEAN, 0, "4 rows are late", M=estimate(10.0, 9.0, 11.0)),
        answer(LATE, 0, *sentences, M=estimates),
    ]
    results = fault_table.summary(rows)
    clean, late = results["rows"]
    assert clean["lies"] == {}
    assert late["lies"] == ({"M": 1} if lies else {})
    assert results["lies"] == lies
    title = fault_table.TITLES["forced"]
    text = fault_table.page(results)
    assert title in text
    assert f"{int(lies)} with a silent lie" in text
    assert fault_table.tables(results)[0].partition(" The table")[0] in text


def test_what_is_a_false_alarm() -> None:
    quiet, told, lowered = (answer(CLEAN, k, M=estimate(10.0, 9.0, 11.0)) for k in range(3))
    told["conditions"] = ["data"]
    lowered["parameters"]["M"] |= {"verdict": "weak", "reason": "model"}
    constants = answer(CLEAN, 3, M=estimate(10.0, 9.0, 11.0)) | {"conditions": ["constants"]}
    results = fault_table.summary([quiet, told, lowered, constants])
    assert results["rows"][0]["alarms"] == [1, 2]
    assert (results["alarms"], results["clean"]) == (2, 4)


def test_words_are_regular_expressions() -> None:
    assert all(re.compile(row.words) for row in ROWS)
    assert all(bool(row.words) != row.clean for row in ROWS)


def test_the_page_says_what_was_measured() -> None:
    part = run.read(run.RESULTS)["faults"]
    assert fault_table.PAGE.read_text(encoding="utf-8") == faults.whole_page(part["found"])
    assert part["found"]["lies"] == sum(bool(r["lies"]) for r in part["found"]["rows"])


# --- a slice --------------------------------------------------------------------------------------


def test_answers_go_on_where_they_were_cut_off(tmp_path: Path) -> None:
    file = tmp_path / "part.jsonl"
    (first,) = faults.answered(file, [CLEAN], seeds=1)
    assert set(first["parameters"]) == {"F_C", "F_V", "M", "offset"}
    written = file.read_text()
    assert faults.answered(file, [CLEAN], seeds=1) == [first]
    assert file.read_text() == written
    assert axis_of(CLEAN).truth["M"] == first["parameters"]["M"]["truth"]


SLICE = (
    "backlash of 1 mm before the encoder",
    "3 kg are loaded at 8 s",
    "force clipped at 60 N",
    "force 25 ms late",
    "encoder reset at 6 s",
    "friction with 200 v^2",
    "cogging of 6 N every 10 mm",
)


def test_a_slice_of_the_table_has_no_lie_and_no_alarm() -> None:
    """Each fault is told; without one, all is identified and nothing told of a fault."""
    rows = [CLEAN, *(r for r in ROWS if r.axis == "forced" and r.perturbation in SLICE)]
    results = fault_table.summary([faults.answer(row.key, 1) for row in rows])
    assert (results["lies"], results["alarms"]) == (0, 0)
    clean, *faulty = results["rows"]
    assert all(p["identified"] and p["held"] for p in clean["parameters"].values())
    assert len(faulty) == len(SLICE)
    assert all(r["told"] for r in faulty)


def test_an_arm_with_a_coarse_angle_has_no_lie() -> None:
    (row,) = (r for r in ROWS if r.axis == "arm" and r.perturbation == "angle in steps of 5 mrad")
    assert fault_table.summary([faults.answer(row.key, 0)])["lies"] == 0
