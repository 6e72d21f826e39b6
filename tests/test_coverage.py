"""The benchmark of intervals: its twins, its counts, and its resumption."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import interval_twins
import intervals
import run
from interval_twins import bed, loop, pendulum, remembering
from stribeck import InputError, identify


def estimate(
    truth: float, low: float, high: float, verdict: str = "identified", **entries: Any
) -> dict[str, Any]:
    """One parameter of a row."""
    return {
        "truth": truth, "value": 10.0, "at": 0.5, "error": 2.0, "interval": [low, high],
        "verdict": verdict, "resampled": None,
    } | entries  # fmt: skip


def row(k: int, study: str = "bed", **parameters: dict[str, Any]) -> dict[str, Any]:
    return {"study": study, "k": k, "seconds": 1.0, "parameters": parameters}


# --- twins ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("memory", [5.0, 50.0])
def test_noise_forgets_as_fast_as_is_said(memory: float) -> None:
    """A million samples of memory m are a million / 2m free ones: two percent is five sigma."""
    r = remembering(np.random.default_rng(1), 1_000_000, memory)
    lag = int(memory)
    assert np.mean(r[lag:] * r[:-lag]) == pytest.approx(math.exp(-1), abs=0.02)
    assert np.std(r) == pytest.approx(1.0, abs=0.02)
    first = [remembering(np.random.default_rng(s), 2, memory)[0] for s in range(4_000)]
    assert np.std(first) == pytest.approx(1.0, abs=0.05)  # no run-in


def test_a_bed_is_a_function_of_its_number_and_its_noise_of_the_seed() -> None:
    first, repeated, reseeded, neighbour = bed(2), bed(2), bed(2, seed=7), bed(3)
    assert first.truth == repeated.truth == reseeded.truth != neighbour.truth
    x, y = (b.recordings[0].position for b in (first, reseeded))
    assert np.array_equal(x, repeated.recordings[0].position)
    # Rests show the noise of both; a converter's step of 0.098 mm comes on top.
    steady = slice(0, int(0.9 * first.rate))
    assert np.std(x[steady] - y[steady]) == pytest.approx(
        math.sqrt(2) * math.hypot(first.noise, 0.4e-3 / 4.096 / math.sqrt(12)), rel=0.25
    )
    assert x[-1] > x[0] + 0.25  # rightward
    assert neighbour.recordings[0].position[-1] < neighbour.recordings[0].position[0] - 0.25


def test_a_force_that_is_logged_as_held_is_half_a_sample_ahead(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Without noise the balance finds the truth from the one log, and is misled by the other."""
    monkeypatch.setattr(interval_twins, "FORCE_NOISE", (1e-3, 1.001e-3))
    off = {}
    for locked in (False, True):
        axis = loop(1, locked=locked)
        fit = identify(list(axis.recordings), rig=axis.rig, law=axis.law)
        named = dict(zip([q.name for q in fit.parameters.every], fit.p, strict=True))
        off[locked] = abs(named["M"] / axis.truth["M"] - 1)
    assert off[False] < 5e-4
    assert off[True] > 1.5e-3


def test_pendulums_swing_with_loads_of_their_own() -> None:
    axis = pendulum(4)
    assert len(axis.recordings) == interval_twins.SWINGS
    loads = {(log.extra["mass"][0], log.extra["length"][0]) for log in axis.recordings}
    assert len(loads) == interval_twins.SWINGS
    for log in axis.recordings:
        off = log.extra["torque_enable"] == 0
        assert np.ptp(log.position) > 0.5
        assert 0.2 < off.mean() < 0.5


def test_the_bootstrap_of_a_bed_spreads_as_its_standard_errors_say() -> None:
    """Along a curved valley refits need many steps; those that end early stay near the fit."""
    axis = bed(7)
    fit = identify(list(axis.recordings), rig=axis.rig, law=axis.law, draws=intervals.DRAWS)
    drawn = fit.uncertainty.bootstrap
    assert drawn is not None
    share = drawn.draws[:, :5].std(axis=0) / fit.uncertainty.errors[:5]
    assert share.min() > 0.75  # of 60 draws the standard deviation is known to 9 %
    assert share.max() < 1.35


# --- counting -------------------------------------------------------------------------------------


def test_the_interval_of_a_share_is_clopper_and_pearsons() -> None:
    """Closed forms at the ends: 1 - (alpha / 2)^(1 / n); and a table's 81 of 263 for the middle."""
    assert intervals.binomial(0, 20) == pytest.approx((0.0, 1 - 0.025 ** (1 / 20)))
    assert intervals.binomial(20, 20) == pytest.approx((0.025 ** (1 / 20), 1.0))
    low, high = intervals.binomial(81, 263)  # Agresti and Coull's worked case
    assert (low, high) == pytest.approx((0.2527, 0.3676), abs=1e-4)


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
        (84, 100, "outside, but within their binomial interval: F (84/100)"),
        (80, 100, "missed by F (80/100)"),
        (30, 30, "outside, but within their binomial interval: F (30/30)"),
        (400, 400, "missed by F (400/400)"),  # its binomial interval begins at 99.1 %
    ],
)
def test_goal_by_share_and_by_what_so_many_can_tell(hits: int, trials: int, sentence: str) -> None:
    rows = [row(k, F=estimate(10, 9 if k < hits else 11, 12)) for k in range(trials)]
    (text,) = intervals.tables({"studies": {"bed": intervals.study(rows)}, "spread": []})
    assert f"of the identified: {sentence}." in text


def test_estimates_spread_from_the_fifth_to_the_ninety_fifth_percentile() -> None:
    beds = len(intervals.BEDS)
    rows = [
        row(k, F=estimate(1, 0, 2, "weak" if k < 3 * beds else "identified", at=k // beds / 10))
        for k in range(11 * beds)
    ]
    spreads = intervals.spread(rows)
    assert [s["bed"] for s in spreads] == list(intervals.BEDS)
    assert spreads[0]["spread"] == pytest.approx(0.9)
    first = spreads[0]
    assert (first["verdict"], first["so_often"], first["seeds"]) == ("identified", 8, 11)


# --- a run ----------------------------------------------------------------------------------------


def test_a_run_goes_on_where_it_was_cut_off(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "part.jsonl"
    calls: list[tuple[str, int]] = []

    def identified_row(study: str, k: int) -> dict[str, Any]:
        if len(calls) == 2:
            raise KeyboardInterrupt
        calls.append((study, k))
        return row(k, study)

    monkeypatch.setattr(intervals, "identified_row", identified_row)
    monkeypatch.setattr(intervals, "cores", lambda: 1)
    pairs = [("bed", 0), ("bed", 1), ("loop", 0)]
    with pytest.raises(KeyboardInterrupt):
        intervals.identified(file, pairs)
    with file.open("a", encoding="utf-8") as stream:
        stream.write('{"study": "loop", "k":')  # the machine went down while it wrote
    calls.clear()
    rows = intervals.identified(file, pairs)
    assert calls == [("loop", 0)]
    assert [(r["study"], r["k"]) for r in rows] == pairs
    assert [(r["study"], r["k"]) for r in intervals.read(file)] == pairs


def test_a_recording_that_is_refused_is_counted_and_costs_no_other(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def refused(*_: Any, **__: Any) -> None:
        raise InputError("the axis never rests")

    monkeypatch.setattr(intervals, "identify", refused)
    rows = [intervals.identified_row("loop", 0), row(1, "loop", F=estimate(10, 9, 11))]
    counts = intervals.study(rows)
    assert (counts["recordings"], counts["refused"]) == (2, 1)
    assert counts["parameters"]["F"]["every"]["of"] == 1
    (text,) = intervals.tables({"studies": {"loop": counts}, "spread": []})
    assert "1 were refused: “the axis never rests”." in text


def test_what_is_found_of_a_loop_stands_in_its_row() -> None:
    """The row is the fit's own figures, and its tables can be made."""
    axis = loop(0)
    fit = identify(list(axis.recordings), rig=axis.rig, law=axis.law, draws=intervals.DRAWS)
    parameters = json.loads(json.dumps(intervals.identified_row("loop", 0)))["parameters"]
    assert list(parameters) == list(axis.truth) == ["F_C", "F_V", "M", "offset"]
    for e, (name, p) in zip(fit.estimates, [*parameters.items()], strict=False):
        assert p["truth"] == pytest.approx(axis.truth[name], rel=1e-6)
        assert p["interval"] == pytest.approx([e.low, e.high], rel=1e-6)
        assert p["resampled"] == pytest.approx(list(e.resampled or ()), rel=1e-6)
        assert p["verdict"] == e.verdict
    (text,) = intervals.tables(intervals.summary([row(0, "loop", **parameters)]))
    assert "F\\_C" in text
    assert "bootstrap" in text


def test_published_counts_add_up() -> None:
    part = run.read(run.RESULTS)["intervals"]
    for name, counted in part["found"]["studies"].items():
        by_parameter = [c for n, c in counted["parameters"].items() if n != "all"]
        assert counted["recordings"] == intervals.STUDIES[name].count[part["quick"]]
        for c in (*by_parameter, counted["parameters"]["all"]):
            assert sum(c[v]["of"] for v in intervals.VERDICTS) == c["every"]["of"]
            assert sum(c[v]["held"] for v in intervals.VERDICTS) == c["every"]["held"]
        missing = sum(c["every"]["of"] - c["every"]["held"] for c in by_parameter)
        assert missing == len(counted["missed"])
