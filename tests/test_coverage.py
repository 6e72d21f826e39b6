"""The benchmark of intervals: its axes, its counts, and its resumption."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import interval_axes
import intervals
import resumable
import run
from foreign_axes import Axis, noisy, recordings
from stribeck import RIGS, InputError, identify


def estimate(
    truth: float, low: float, high: float, verdict: str = "identified", **entries: Any
) -> dict[str, Any]:
    """One parameter of a row."""
    return {
        "truth": truth, "value": 10.0, "error": 2.0, "interval": [low, high],
        "verdict": verdict, "resampled": None,
    } | entries  # fmt: skip


def row(k: int, study: str = "bed", **parameters: dict[str, Any]) -> dict[str, Any]:
    return {"study": study, "k": k, "seconds": 1.0, "parameters": parameters}


# --- axes -----------------------------------------------------------------------------------------


def test_an_axis_is_a_function_of_its_number() -> None:
    first, repeated, neighbour = (interval_axes.slide(k) for k in (2, 2, 3))
    assert first.truth == repeated.truth != neighbour.truth
    x, y = (axis.tables[0]["position"] for axis in (first, repeated))
    assert np.array_equal(x, y)
    assert x[-1] > x[0] + 0.15  # rightward
    left = neighbour.tables[0]["position"]
    assert left[-1] < left[0] - 0.15


def test_constants_of_beds_are_spread_as_their_tolerances_say() -> None:
    """A normal distribution within two standard deviations has 0.88 of them for its own."""
    rng = np.random.default_rng(0)
    beds = [interval_axes.drawn_constants(rng) for _ in range(3000)]
    known = {c.name: c for c in RIGS["slide-bed"].constants}
    for name, values in (("F_fm", [b.F_fm for b in beds]), ("k_hat+", [b.k_hat_up for b in beds])):
        off = np.array(values) - known[name].value
        assert np.abs(off).max() < known[name].tolerance
        assert off.std() == pytest.approx(0.88 * known[name].tolerance / 2, rel=0.05)


@pytest.mark.parametrize("draw", [interval_axes.balance, interval_axes.cylinders])
def test_balances_find_the_truth_without_noise(draw: Callable[[int], Axis]) -> None:
    axis = draw(0)
    fit = identify(recordings(axis, axis.tables), rig=RIGS[axis.rig].set(**axis.given))
    for name, truth in axis.truth.items():
        assert fit.values[name] == pytest.approx(truth, rel=0.02, abs=0.1), name


def test_pendulums_swing_with_loads_of_their_own() -> None:
    axis = interval_axes.swing(4)
    logs = recordings(axis, axis.tables)
    assert len({(log.extra["mass"][0], log.extra["length"][0]) for log in logs}) == 3
    for log in logs:
        off = log.extra["torque_enable"] == 0
        assert np.ptp(log.position) > 0.5
        assert 0.2 < off.mean() < 0.5


@pytest.mark.parametrize("draw", [interval_axes.dahl, interval_axes.lugre])
def test_bristles_slide_in_the_end(draw: Callable[[int], Axis]) -> None:
    (table,) = draw(0).tables
    slid = np.abs(table["velocity"]).max()
    assert slid > 5 * np.abs(table["velocity"][: len(table["t"]) // 2]).max()


# --- counting -------------------------------------------------------------------------------------


def test_the_interval_of_a_share_is_wilsons() -> None:
    """Closed forms at the ends, z^2 / (n + z^2); and Agresti and Coull's 81 of 263."""
    z2 = 1.959964**2
    assert intervals.binomial(0, 20) == pytest.approx((0.0, z2 / (20 + z2)), abs=1e-6)
    assert intervals.binomial(20, 20) == pytest.approx((20 / (20 + z2), 1.0), abs=1e-6)
    assert intervals.binomial(81, 263) == pytest.approx((0.2553, 0.3662), abs=1e-4)


def test_truths_are_counted_by_verdict() -> None:
    rows = [
        row(0, F=estimate(10, 9, 11), G=estimate(4, 5, 6, "weak")),
        row(1, F=estimate(12, 9, 11), G=estimate(5, 5, 6, "weak", resampled=[0.0, 4.9])),
        row(2, F=estimate(9, 9, 13, "weak"), G=estimate(7, 0, 9, "not identifiable")),
    ]
    counts = intervals.study(rows)
    F, G, together = (counts["parameters"][n] for n in ("F", "G", "all"))
    assert (F["identified"]["held"], F["identified"]["of"]) == (1, 2)
    assert (F["weak"]["held"], F["weak"]["of"]) == (1, 1)
    assert F["weak"]["half_width"] == pytest.approx(0.2)
    assert (G["weak"]["held"], G["weak"]["of"]) == (1, 2)
    assert G["not identifiable"]["held"] == 1
    assert (G["bootstrap"]["every"]["held"], G["bootstrap"]["every"]["of"]) == (0, 1)
    assert G["bootstrap"]["identified"]["of"] == 0
    assert F["bootstrap"] is None
    assert (together["every"]["held"], together["every"]["of"]) == (4, 6)
    assert F["z"] == pytest.approx(0.5 / 0.6745)  # of 0, 1 and 0.5
    assert counts["missed"] == ["0 G weak", "1 F identified"]


@pytest.mark.parametrize(
    ("hits", "trials", "sentence"),
    [
        (95, 100, "met by each"),
        (
            90,
            100,
            "outside, but within the interval of their share: F (90/100), all (90/100), every",
        ),
        (80, 100, "missed by F (80/100), all (80/100), every estimate (80/100)"),
        (30, 30, "outside, but within the interval of their share: F (30/30)"),
        (400, 400, "missed by F (400/400)"),  # its interval begins at 99.0 %
    ],
)
def test_goal_by_share_and_by_what_so_many_can_tell(hits: int, trials: int, sentence: str) -> None:
    rows = [row(k, F=estimate(10, 9 if k < hits else 11, 12)) for k in range(trials)]
    (text,) = intervals.tables({"studies": {"bed": intervals.study(rows)}})
    assert f"of the identified, and of all: {sentence}" in text


# --- a run ----------------------------------------------------------------------------------------


def test_a_run_goes_on_where_it_was_cut_off(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "part.jsonl"
    calls: list[tuple[str, int]] = []

    def work(study: str, k: int) -> dict[str, Any]:
        if len(calls) == 2:
            raise KeyboardInterrupt
        calls.append((study, k))
        return row(k, study)

    def named(answer: dict[str, Any]) -> tuple[str, int]:
        return answer["study"], answer["k"]

    monkeypatch.setattr(resumable, "cores", lambda: 1)
    jobs = [("bed", 0), ("bed", 1), ("balance", 0)]
    with pytest.raises(KeyboardInterrupt):
        resumable.completed(file, jobs, work, named)
    with file.open("a", encoding="utf-8") as stream:
        stream.write('{"study": "balance", "k":')  # the machine went down while it wrote
    calls.clear()
    rows = resumable.completed(file, jobs, work, named)
    assert calls == [("balance", 0)]
    assert [named(r) for r in rows] == jobs
    assert [named(r) for r in resumable.lines(file)] == jobs


def test_a_recording_that_is_refused_is_counted_and_costs_no_other(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def refused(*_: Any, **__: Any) -> None:
        raise InputError("the axis never rests")

    monkeypatch.setattr(intervals, "identify", refused)
    rows = [intervals.identified_row("balance", 0), row(1, "balance", F=estimate(10, 9, 11))]
    counts = intervals.study(rows)
    assert (counts["recordings"], counts["refused"]) == (2, 1)
    assert counts["parameters"]["F"]["every"]["of"] == 1
    (text,) = intervals.tables({"studies": {"balance": counts}})
    assert "1 were refused: “the axis never rests”." in text


def test_an_identification_stands_in_its_row() -> None:
    """The row is the fit's own figures, and its tables can be made."""
    axis = interval_axes.balance(0)
    rng = np.random.default_rng(0)
    logs = recordings(axis, noisy(axis, rng, intervals.MEMORY))
    fit = identify(logs, rig=axis.rig, law=axis.law, bootstrap=intervals.DRAWS)
    parameters = json.loads(json.dumps(intervals.identified_row("balance", 0)))["parameters"]
    assert list(parameters) == list(axis.truth) == ["F_C", "F_V", "M", "offset"]
    for e, (name, p) in zip(fit.estimates, [*parameters.items()], strict=False):
        assert p["truth"] == pytest.approx(axis.truth[name], rel=1e-6)
        assert p["interval"] == pytest.approx([e.low, e.high], rel=1e-6)
        assert p["resampled"] == pytest.approx(list(e.resampled or ()), rel=1e-6)
        assert p["verdict"] == e.verdict
    (text,) = intervals.tables(intervals.summary([row(0, "balance", **parameters)]))
    assert "F\\_C" in text
    assert "bootstrap" in text


def test_published_counts_add_up() -> None:
    part = run.read(run.RESULTS)["intervals"]
    for name, counted in part["found"]["studies"].items():
        by_parameter = [c for n, c in counted["parameters"].items() if n != "all"]
        assert name in intervals.STUDIES
        for c in (*by_parameter, counted["parameters"]["all"]):
            assert sum(c[v]["of"] for v in intervals.VERDICTS) == c["every"]["of"]
            assert sum(c[v]["held"] for v in intervals.VERDICTS) == c["every"]["held"]
        missing = sum(c["every"]["of"] - c["every"]["held"] for c in by_parameter)
        assert missing == len(counted["missed"])
