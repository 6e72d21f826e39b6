"""The tables of a campaign, in all their forms."""

from __future__ import annotations

import csv
import io
import math
import re
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stribeck.bench.record import Job, Record, Steps
from stribeck.bench.statistics import IntervalEstimate
from stribeck.bench.tables import (
    comparisons,
    interval,
    overall,
    ranking,
    solutions,
    summary,
)
from stribeck.errors import InputError
from stribeck.report.format import grouped
from stribeck.report.table import Cell, Table

if TYPE_CHECKING:
    from collections.abc import Callable


def run(
    problem: str,
    algorithm: str,
    repeat: int,
    evaluations: int,
    cost: float,
    target: float | None = 1.0,
    minimum: float = 0.0,
    budget: int = 1000,
) -> Record:
    spec, method = {"surface": problem}, {"name": "bts", "settings": {}}
    job = Job(problem, algorithm, repeat, 1, budget, target, minimum, spec, method)
    return Record(
        job=job,
        x=(0.5, 0.5),
        cost=cost,
        evaluations=evaluations,
        ended="budget",
        failed=0,
        rounds={"foraging": 20, "tabu": 4},
        events={"backtrack": 2, "dispersal": 9},
        steps=Steps(np.array([evaluations]), np.array([1]), np.array([cost])),
        seconds=0.25,
    )


#: On BF `quick` always succeeds, `slow` half the time and later; SF has no target.
RECORDS = [
    *(run("BF", "quick", k, 100 + 10 * k, 0.1 * (k + 1)) for k in range(10)),
    *(run("BF", "slow_er", k, 500 + k, 0.2 if k % 2 else 2.0 + k) for k in range(10)),
    *(run("SF", "quick", k, 900, -1e-9 * (k + 1), target=None) for k in range(10)),
]
JOBS = [
    run(p, a, k, 1, 0.0, 1.0 if p == "BF" else None).job
    for p in ("BF", "SF")
    for a in ("slow_er", "quick")
    for k in range(10)
]
TABLES = [summary, solutions, comparisons, overall, ranking]


def text(table: Table, row: int) -> dict[str, str]:
    return {head: cell.text for head, cell in zip(table.heads, table.rows[row], strict=True)}


class TestNumbers:
    @pytest.mark.parametrize(
        ("value", "digits", "shown"),
        [
            (1234.4, 4, "1,234"),
            (12345.6, 4, "12,346"),
            (999_999, 4, "999,999"),
            (999_999.9, 4, "1.000e6"),
            (-186.73091, 7, "-186.7309"),
            (1.2345e-9, 2, "1.2e-9"),
            (1.2346e-9, 7, "1.235e-9"),
            (0.001, 2, "0.0010"),
            (0.0, 3, "0"),
            (math.inf, 3, "∞"),
            (math.nan, 3, "–"),
            (None, 3, "–"),
        ],
    )
    def test_number(self, value: float | None, digits: int, shown: str) -> None:
        assert grouped(value, digits) == shown

    @given(st.floats(1e-300, 1e300), st.integers(2, 4))
    def test_what_is_shown_is_the_number(self, value: float, digits: int) -> None:
        shown = float(grouped(value, digits).replace(",", ""))
        assert shown == pytest.approx(value, rel=0.51 * 10 ** (1 - digits))

    def test_interval(self) -> None:
        assert interval(IntervalEstimate(1234.0, 1100.0, 1400.0)) == "1,234 (1,100 to 1,400)"
        assert interval(IntervalEstimate(math.inf, 3210.0, math.inf)) == "∞ (at least 3,210)"
        assert interval(IntervalEstimate(5.0, math.nan, math.nan), 2) == "5.0"
        assert interval(IntervalEstimate(math.nan, math.nan, math.nan)) == "–"


ENDS = {"low": -3.4, "high": 5.0}


class TestForms:
    ODD = Table(
        "50 % of a_b & c",
        ("name_1", "cost"),
        (
            (Cell("a|b_c", "a|b_c"), Cell("1.2e-9 (-3.4 to 5)", 1.2e-9, ENDS)),
            (Cell("f01-d2 #{x}", "f01-d2 #{x}"), Cell("–")),
            (Cell('say "x", y', 'say "x", y'), Cell("∞", math.inf)),
        ),
        "p < 2^(1-k)",
    )  # fmt: skip

    def test_plain_is_aligned(self) -> None:
        title, _, heads, rule, *rows, _, note = self.ODD.text().splitlines()
        assert (title, note) == (self.ODD.title, self.ODD.note)
        assert {len(line) for line in (heads, rule, *rows)} == {len(rule)}
        assert rows[2].startswith('say "x", y ')
        assert rows[2].endswith(" ∞")

    def test_markdown_parses_back(self) -> None:
        lines = [x for x in self.ODD.markdown().splitlines() if x.startswith("|")]
        parsed = [
            [re.sub(r"\\(.)", r"\1", c.strip()) for c in re.split(r"(?<!\\)\|", x)[1:-1]]
            for x in lines
        ]
        assert parsed[0] == ["name_1", "cost"]
        assert parsed[1] == ["---", "---:"]
        assert parsed[2:] == [[c.text for c in row] for row in self.ODD.rows]

    def test_latex_escapes_words_and_sets_numbers(self) -> None:
        latex = self.ODD.latex()
        assert r"\caption{50 \% of a\_b \& c}" in latex
        assert r"a|b\_c & $1.2\times10^{-9}$ ($-3.4$ to 5) \\" in latex
        assert r"f01-d2 \#\{x\} & -- \\" in latex
        assert r"& $\infty$ \\" in latex
        assert r"p $<$ 2\textasciicircum{}(1-k)" in latex

    @given(st.text(max_size=20))
    def test_latex_leaves_no_character_that_has_a_meaning(self, label: str) -> None:
        line = Table("", ("x",), ((Cell.label(label),),)).latex().split(r"\hline" + "\n")[2]
        bare = re.sub(
            r"\\[&%$#_{}]|\\text\w+\{\}|\$(<|>|\\infty)\$", "", line.removesuffix(" \\\\\n")
        )
        assert not set(bare) & set("&%$#_{}\\~^<>")

    def test_csv_parses_back_in_full(self) -> None:
        head, *rows = csv.reader(io.StringIO(self.ODD.csv()))
        assert head == ["name_1", "cost", "cost low", "cost high"]
        assert rows[0][0] == "a|b_c"
        assert [float(v) for v in rows[0][1:]] == [1.2e-9, -3.4, 5.0]
        assert rows[1] == ["f01-d2 #{x}", "", "", ""]
        assert rows[2] == ['say "x", y', "inf", "", ""]

    @pytest.mark.parametrize("make", TABLES)
    def test_every_table_in_every_form_whatever_the_order(self, make: Callable[..., Table]) -> None:
        table_in_order, reordered = make(RECORDS, JOBS), make(RECORDS[::-1], JOBS)
        assert table_in_order == reordered
        assert make(RECORDS) == make(RECORDS[::-1])
        for table in (table_in_order, make([]), make(RECORDS[:3], JOBS)):
            assert table.text().count("\n") >= len(table.rows) + 4
            assert len([x for x in table.markdown().splitlines() if x[:1] == "|"]) == 2 + len(
                table.rows
            )
            assert len(list(csv.reader(io.StringIO(table.csv())))) == 1 + len(table.rows)
            columns = re.findall(r"begin\{tabular\}\{([lr]+)\}", table.latex())
            assert len(columns[0]) == len(table.heads)


class TestCampaign:
    def test_summary_by_hand(self) -> None:
        table = summary(RECORDS, JOBS)
        assert [(r[0].text, r[1].text) for r in table.rows] == [
            ("BF", "slow_er"), ("BF", "quick"), ("SF", "slow_er"), ("SF", "quick")
        ]  # fmt: skip
        quick = text(table, 1)
        assert quick["success"] == "10/10 (72 to 100 %)"
        assert quick["ERT"].startswith("145.0 (")
        assert quick["evaluations"] == "145.0"
        assert (quick["rounds"], quick["entrapments"], quick["seconds"]) == (
            "4.000",
            "2.000",
            "0.250",
        )
        assert table.rows[0][4].value == pytest.approx(sum(range(500, 510)) / 5)

    def test_what_is_missing_is_said(self) -> None:
        table = summary(RECORDS[:3], JOBS)
        assert text(table, 1)["runs"] == "3 of 10"
        assert set(list(text(table, 2).values())[3:]) == {"–"}
        assert text(table, 2)["runs"] == "0 of 10"
        assert "3,10" in table.csv()

    def test_no_target_is_no_success(self) -> None:
        assert text(summary(RECORDS, JOBS), 3)["success"] == "–"

    def test_solutions_by_hand(self) -> None:
        table = solutions(RECORDS, JOBS)
        costs = 0.1 * np.arange(1, 11)
        values = [c.value for c in table.rows[1][3:]]
        assert values == pytest.approx([0.55, 0.1, 1.0, np.std(costs, ddof=1)])
        assert text(table, 3)["min"] == "-1.000e-8"

    def test_costs_of_a_minimum_that_moves_are_those_above_it(self) -> None:
        runs = [run("f01", "a", k, 5, 100.0 * k + 2.0**-k, minimum=100.0 * k) for k in range(3)]
        table = solutions([*runs, *RECORDS])
        assert [c.value for c in table.rows[3][3:6]] == pytest.approx([1.75 / 3, 0.25, 1.0])
        assert table.note.endswith("differs from run to run: f01.")
        assert solutions(RECORDS).rows == table.rows[:3]

    def test_only_tabu_search_can_meet_a_deadlock(self) -> None:
        ga = run("BF", "ga", 0, 5, 2.0)
        ga = replace(ga, job=replace(ga.job, method={"name": "ga", "settings": {}}))
        assert text(summary([ga]), 0)["entrapments"] == "–"

    def test_budgets_that_differ_are_named(self) -> None:
        long_runs = [run("BF", "long", k, 9, 5.0 + k, budget=9000) for k in range(2)]
        short_runs = [run("BF", "short", k, 9, 5.0 + k, budget=10) for k in range(2)]
        word = "Allowed other budgets than most: short fewer evaluations; long more evaluations."
        for make in (summary, comparisons, overall, ranking):
            assert "other budgets" not in make(RECORDS).note
            assert make([*RECORDS, *long_runs, *short_runs]).note.endswith(word)

    def test_targets_met_count_to_the_budget_that_all_had(self) -> None:
        late = [run("BF", "long", k, 1002 + k, 1e-9, budget=9000) for k in range(2)]
        soon = [run("BF", m, k, 10 + k, 1e-9) for k in range(2) for m in ("a", "b")]
        met = {r[1].text: r[3].value for r in ranking([*late, *soon]).rows}
        assert met == {"a": 1.0, "b": 1.0, "long": 0.0}

    def test_one_run_repeated_is_no_sample(self) -> None:
        repeated = [run("BF", "direct", k, 16, 0.5) for k in range(3)]
        for make in (summary, comparisons, ranking):
            assert "Nothing in direct is random" in make([*RECORDS, *repeated]).note
            assert "random" not in make([*RECORDS, repeated[0]]).note

    def test_a_cost_that_was_never_finite(self) -> None:
        table = solutions([run("BF", "a", 0, 5, math.inf), run("BF", "a", 1, 5, 2.0)])
        assert [c.text for c in table.rows[0][3:]] == ["∞", "2.000000", "∞", "–"]

    def test_comparisons(self) -> None:
        table = comparisons(RECORDS, JOBS)
        first, second = text(table, 0), text(table, 1)
        assert (first["first"], first["second"]) == ("slow_er", "quick")
        assert first["test"] == "unpaired, 10 and 10"
        assert first["A12"].startswith("0.00 (0.00 to ")
        assert first["better"] == "quick"
        assert table.rows[0][4].value == table.rows[0][5].value  # a family of the one test made
        assert {second["p"], second["A12"], second["better"]} == {"–"}
        assert "1 in all" in table.note

    def test_a_reference(self) -> None:
        assert text(comparisons(RECORDS, JOBS, reference="quick"), 0)["second"] == "slow_er"
        with pytest.raises(InputError, match="no method 'ga' to compare with: there are slow_er"):
            overall(RECORDS, JOBS, reference="ga")

    def test_overall(self) -> None:
        row = text(overall(RECORDS, JOBS), 0)
        assert (row["problems"], row["won"], row["lost"]) == ("1", "0", "1")
        assert row["p"] == "1.0"
        assert row["better"] == "–"

    def test_ranking(self) -> None:
        table = ranking(RECORDS, JOBS)
        assert [r[1].text for r in table.rows] == ["quick", "slow_er"]
        assert (text(table, 0)["fastest"], text(table, 1)["fastest"]) == ("1.0", "0")
        assert "On 1 of 2 problems" in table.note
        # Of 51 precisions from 1e2 to 1e-8 a cost of c meets those of at least c: 1e2 is met by
        # all ten runs, 1e0 by the quick ones only.
        costs = [r.cost for r in RECORDS if r.job.cell == ("BF", "quick")]
        met = sum(c <= p for c in costs for p in np.geomspace(1e2, 1e-8, 51)) / (51 * 10)
        assert math.isclose(float(table.rows[0][3].value or 0), met)
        on_bf_only = [j for j in JOBS if j.cell != ("SF", "slow_er")]
        meant_for_one = ranking(RECORDS, on_bf_only)
        assert [(r[0].text, r[1].text) for r in meant_for_one.rows] == [
            ("1", "quick"), ("–", "slow_er")
        ]  # fmt: skip
        assert "On 2 of 2 problems" in meant_for_one.note
        alone = ranking(RECORDS[:10], JOBS)
        assert [r[0].text for r in alone.rows] == ["1", "–"]
