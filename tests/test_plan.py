"""Plans: information in closed form, rankings, limits, and achieved against predicted errors."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from dataclasses import replace
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from command import caller
from stribeck import RIGS, Card, InputError, identify, read_card, simulate
from stribeck.data.recording import Recording
from stribeck.friction import LAWS
from stribeck.identify.card_logs import logs_beside
from stribeck.identify.design.current_model import current_model
from stribeck.identify.design.expected_information import twin_study
from stribeck.identify.design.experiment import (
    Experiment,
    PriorBox,
    covariance,
    draws,
    errors,
    factors,
    information,
    information_at,
)
from stribeck.identify.design.plan import Plan, Proposal, plan
from stribeck.report.plan_report import plan_text, show_plan
from stribeck.rig.slide_bed import SLIDE_BED
from stribeck.rig.twin import TestBed
from stribeck.space import Array

RIGHT = TestBed().run("up", seed=4).recording


def line(slopes: Array, noise: float, **fields: Any) -> Experiment:
    """A linear experiment: signals (N,) are slopes (N, dim) times parameters (dim,)."""

    def predict(x: Array) -> Array:
        signals: Array = x @ slopes.T
        return signals

    dim = slopes.shape[1] - fields.get("starts", 0)
    return Experiment(
        "a line", "", 1.0, predict, noise, fields.pop("inflation", np.ones(dim)), **fields
    )


def box(dim: int, width: float = 1e6, prior: float = 1e6) -> PriorBox:
    def all_of_them(x: Array) -> NDArray[np.bool_]:
        return np.ones(len(x), dtype=bool)

    return PriorBox(np.full(dim, -width), np.full(dim, width), np.full(dim, prior), all_of_them)


A = np.random.default_rng(1).standard_normal((40, 3))


# --- information in closed form -----------------------------------------------------------------


def test_the_information_of_a_line_is_its_normal_matrix() -> None:
    matrix = information(line(A, 0.2), np.array([1.0, -2.0, 3.0]), box(3))
    np.testing.assert_allclose(matrix, A.T @ A / 0.04, rtol=1e-6)


def test_an_unknown_start_takes_its_share_of_the_information() -> None:
    # a straight line with slope b from an unknown start: var b = noise^2 / sum (t - mean t)^2
    t = np.linspace(0.0, 2.0, 21)
    e = line(np.column_stack([t, np.ones(21)]), 0.1, starts=1, reach=1e-3)
    error = errors(information(e, np.array([0.7]), box(1)))
    assert error[0] == pytest.approx(0.1 / np.sqrt(np.sum((t - 1.0) ** 2)), rel=1e-6)


def test_repeated_noise_widens_each_error_by_its_own_root() -> None:
    white, rough = line(A, 0.2), line(A, 0.2, inflation=np.array([1.0, 4.0, 9.0]))
    a, b = (errors(information(e, np.ones(3), box(3))) for e in (white, rough))
    np.testing.assert_allclose(b / a, [1.0, 2.0, 3.0], rtol=1e-6)


def test_more_of_the_same_shrinks_by_the_root_of_two() -> None:
    at = np.array([[1.0, -2.0, 3.0], [1.5, -2.5, 2.0]])
    F = information_at(line(A, 0.2), at, box(3))
    np.testing.assert_allclose(factors(F, F), np.sqrt(2.0), rtol=1e-9)
    np.testing.assert_allclose(factors(F, 3 * F), 2.0, rtol=1e-9)


def test_an_experiment_on_one_parameter_shrinks_that_one_as_precisions_add() -> None:
    prior = np.diag([4.0, 25.0])[None]
    added = np.diag([12.0, 0.0])[None]
    np.testing.assert_allclose(factors(prior, added), [2.0, 1.0], rtol=1e-12)


def test_a_correlated_partner_shrinks_with_the_one_that_is_measured() -> None:
    # correlation 0.8: measuring the first exactly leaves the second sqrt(1 - 0.8^2) of its error
    prior = np.linalg.inv(np.array([[1.0, 0.8], [0.8, 1.0]]))[None]
    shrinkage = factors(prior, np.diag([1e12, 0.0])[None])
    assert shrinkage[1] == pytest.approx(1 / 0.6, rel=1e-6)


def test_a_range_of_decades_counts_by_its_logarithm() -> None:
    # y = p: relative error noise / p
    decades = PriorBox(np.array([1e-4]), np.array([1.0]), np.array([5.0]), box(1).physical)
    error = errors(information(line(np.ones((1, 1)), 1e-3), np.array([0.02]), decades))
    assert error[0] == pytest.approx(1e-3 / 0.02, rel=1e-6)


def test_an_experiment_that_can_seldom_be_run_has_no_factor() -> None:
    F = np.array([np.eye(2)] * 5)
    broken = F.copy()
    broken[:3] = np.nan
    assert np.isnan(factors(F, broken)).all()
    broken[2] = 3 * np.eye(2)
    np.testing.assert_allclose(factors(F, broken), np.median([2.0, 1.41421356, 1.41421356]))


def test_draws_have_the_covariance_and_stay_where_points_mean_something() -> None:
    C = np.array([[4.0, 1.2], [1.2, 1.0]])
    open_ = draws(np.zeros(2), C, 4001, box(2), np.random.default_rng(0))
    assert (open_[0] == 0).all()
    np.testing.assert_allclose(np.cov(open_[1:].T), C, atol=0.2)

    def ordered(x: Array) -> NDArray[np.bool_]:
        return np.asarray(x[:, 0] >= x[:, 1], dtype=bool)

    half = PriorBox(np.full(2, -1.0), np.full(2, 1.0), np.ones(2), ordered)
    samples = draws(np.zeros(2), C, 200, half, np.random.default_rng(0))
    assert half.inside(samples).all()
    assert np.ptp(samples[:, 0]) > 1.0


def test_twins_of_a_line_keep_its_promise() -> None:
    limits = PriorBox(np.full(3, -50.0), np.full(3, 50.0), np.full(3, 1e3), box(3).physical)
    B = 3.0 * A
    x = np.array([[1.0, -2.0, 3.0]])
    study = twin_study(line(A, 0.2), line(B, 0.2), limits, x, 200, seed=1)
    np.testing.assert_allclose(study.factors, np.sqrt(10.0), rtol=0.3)
    expected = np.sqrt(np.diag(covariance(A.T @ A / 0.04)))
    np.testing.assert_allclose(study.before.std(axis=0), expected, rtol=0.15)


# --- the slide bed ------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def bed() -> Card:
    return identify(RIGHT, rig=SLIDE_BED.exact(), train="112:295", repeats=1).card()


@pytest.fixture(scope="module")
def planned(bed: Card) -> Plan:
    return plan(bed, RIGHT)


def proposal(proposed: Plan, name: str) -> Proposal:
    return next(p for p in proposed.proposals if p.experiment.name == name)


def factor(p: Proposal, name: str) -> float:
    return next(g.factor for g in p.gains if g.name == name)


def test_a_faster_ramp_leads_and_beats_the_same_again(planned: Plan) -> None:
    best, repetition = planned.proposals[0], proposal(planned, "the same again")
    assert best.experiment.kind == "motion"
    assert best.experiment.name.startswith("ramp ×")
    assert best.score > 1.5 * repetition.score
    assert [p.score for p in planned.proposals] == sorted(
        (p.score for p in planned.proposals), reverse=True
    )
    assert factor(repetition, "F_C") == pytest.approx(np.sqrt(2.0), rel=0.05)


def test_the_best_ramp_really_shrinks_what_it_promises(bed: Card) -> None:
    proposed = plan(bed, RIGHT, check=16, seed=2)
    best = proposed.proposals[0]
    assert best.twin_study is not None
    assert best.twin_study.twins == 16
    at = [i for i, g in enumerate(best.gains) if g.doubtful]
    promised = np.exp(np.mean([np.log(best.gains[i].factor) for i in at]))
    achieved = np.exp(np.mean(np.log(best.twin_study.factors[at])))
    assert achieved > 1.6  # more than any repetition of the log could
    assert 0.4 < achieved / promised < 2.5


def test_a_plan_is_the_same_for_the_same_seed(bed: Card, planned: Plan) -> None:
    assert plan_text(plan(bed, RIGHT)) == plan_text(planned)
    assert plan_text(plan(bed, RIGHT, seed=1)) != plan_text(planned)


def test_what_one_known_force_tells_of_others_is_what_refits_show(planned: Plan) -> None:
    (message,) = [text for text in planned.said if "scale of forces" in text]
    known, told = re.findall(r"if (\w+) were known .* shrink: ([^;]*);", message)[0]
    shrinking = dict(re.findall(r"that of (\w+) (more than ten|[0-9.]+-)fold", told))
    free = identify(RIGHT, rig=SLIDE_BED.exact(), train="112:295", repeats=1)
    value = free.card().parameters[known].value
    held = identify(RIGHT, rig=SLIDE_BED.exact(), train="112:295", repeats=1, fixed={known: value})
    before, after = ({e.name: e.high - e.low for e in fit.estimates} for fit in (free, held))
    assert shrinking
    for q in free.parameters.free:
        if q.name == known:
            continue
        factor = before[q.name] / after[q.name]
        if q.name not in shrinking:
            assert factor < 3.0
        elif shrinking[q.name] == "more than ten":
            assert factor > 5.0
        else:
            assert factor == pytest.approx(float(shrinking[q.name].rstrip("-")), rel=0.5)


def test_one_way_is_not_reversed_and_both_ways_are(planned: Plan) -> None:
    assert "reversal" in dict(planned.left)
    assert "reversal" not in [p.experiment.name for p in planned.proposals]
    two_way_log = TestBed().run("both", seed=3).recording
    fit = identify(two_way_log, rig="slide-bed", law="stribeck-directional",
                   train=["112:295", "325:127"], repeats=1, budget=3000)  # fmt: skip
    names = [p.experiment.name for p in plan(fit.card(), two_way_log, count=3).proposals]
    assert "reversal" in names


def test_a_direction_that_was_never_driven_comes_first() -> None:
    options = {"law": "stribeck-directional", "train": "112:295", "repeats": 1, "budget": 2000}
    proposed = plan(identify(RIGHT, rig="slide-bed", **options).card(), RIGHT, count=3)  # type: ignore[arg-type]
    best, repetition = proposed.proposals[0], proposal(proposed, "the same again")
    assert factor(best, "F_C-") > 3
    assert factor(repetition, "F_C-") == pytest.approx(1.0, abs=0.05)


def test_every_experiment_stays_within_the_travel_and_the_force(bed: Card) -> None:
    model = current_model(bed, [RIGHT])
    assert RIGHT.command is not None
    assert model.axis.shown.low == pytest.approx(0.05)
    assert model.axis.shown.high == pytest.approx(0.35)
    for p in plan(bed, RIGHT).proposals:
        if p.experiment.kind == "motion" and p.experiment.name != "the same again":
            shown = p.experiment.predict(model.axis.x[None])
            assert shown.min() > model.axis.shown.low - 1e-3
            assert shown.max() < model.axis.shown.high + 1e-3
            assert p.experiment.seconds <= 37.5


def test_a_weak_drive_is_not_asked_for_more_than_it_has_shown(bed: Card) -> None:
    assert RIGHT.force is not None
    weak = Recording(
        t=RIGHT.t, position=RIGHT.position, command=RIGHT.command, force=0.5 * RIGHT.force
    )
    proposed = plan(bed, weak, count=2)
    assert [p.experiment.name for p in proposed.proposals if p.experiment.kind == "motion"] == [
        "the same again"
    ]
    assert "the log shows" in dict(proposed.left)["ramp × 5"]


def test_a_finer_sensor_helps_only_against_the_sensors_noise(bed: Card) -> None:
    model = current_model(bed, [RIGHT])
    assert model.axis.sensor == pytest.approx(0.3e-3, rel=0.05)
    experiment = proposal(plan(bed, RIGHT), "finer sensor").experiment
    assert not experiment.words.endswith(" 0 mm")
    remainder = max(model.axis.noise**2 - model.axis.sensor**2, 0.0)
    assert experiment.noise**2 == pytest.approx(
        remainder + min(model.axis.sensor, model.axis.noise) ** 2 / 9
    )


def test_no_finer_sensor_is_asked_for_where_none_has_noise(bed: Card) -> None:
    exact = simulate(bed, RIGHT)
    names = {p.experiment.name for p in plan(bed, exact, count=2).proposals}
    assert "faster sensor" in names
    assert "finer sensor" not in names


def test_a_slow_creep_is_run_in_first(planned: Plan) -> None:
    words = proposal(planned, "breakaway").experiment.words
    assert "to wind up the drive" in words
    assert "0.499 mm/s" in words or "0.5 mm/s" in words


# --- a measured force ---------------------------------------------------------------------------


def stroke_log(speeds: list[float], p: dict[str, float], seed: int = 0) -> Recording:
    """A log of strokes there and back at constant speeds under a Stribeck friction."""
    dt, parts = 1e-3, list[Array]()
    for top in speeds:
        for sign in (1.0, -1.0) * 2:
            n = int(2.0 / len(speeds) / dt)
            ramp = np.minimum(np.minimum(np.arange(n), np.arange(n)[::-1]) * dt * 5.0, top)
            parts.append(sign * ramp)
    v: Array = np.concatenate(parts)
    t: Array = dt * np.arange(len(v), dtype=float)
    a: Array = np.gradient(v, dt)
    law = LAWS["stribeck"]
    q = np.array([p[n] for n in law.names])
    F = np.where(v == 0, 0.0, law.friction(v, q)) + 2.0 * a
    noise = np.random.default_rng(seed).standard_normal(len(v))
    return Recording(t=t, position=np.cumsum(v) * dt, force=F + 0.3 * noise)


TRUTH = {"F_S": 9.0, "F_C": 6.0, "F_V": 30.0, "v_SS": 0.01, "exponent": 1.0}


def test_a_log_at_one_speed_asks_for_several_speeds() -> None:
    log = stroke_log([0.05], TRUTH)
    proposed = plan(identify(log, rig="forced", law="coulomb-viscous").card(), log)
    several, repetition = proposal(proposed, "several speeds"), proposal(proposed, "the same again")
    assert factor(several, "F_V") > 1.5 * factor(repetition, "F_V")
    assert factor(several, "F_V") > 1.2 * factor(proposal(proposed, "one speed"), "F_V")
    assert factor(repetition, "M") == pytest.approx(np.sqrt(2.0), rel=0.05)


def test_a_weak_stribeck_speed_asks_for_slow_motion() -> None:
    log = stroke_log([0.03, 0.5], TRUTH)
    proposed = plan(identify(log, rig="forced", law="stribeck").card(), log)
    names = [p.experiment.name for p in proposed.proposals if p.experiment.kind == "motion"]
    assert names[0] in ("slow speeds", "slow sine", "several speeds")
    slow, fast = proposal(proposed, "slow speeds"), proposal(proposed, "fast speeds")
    assert factor(slow, "F_S") > 4 * factor(fast, "F_S")  # it shows below v_SS alone
    assert factor(proposal(proposed, names[0]), "v_SS") > 1.2 * factor(fast, "v_SS")


def test_strokes_stay_within_travel_speed_and_acceleration() -> None:
    log = stroke_log([0.05, 0.2], TRUTH)
    fit_card = identify(log, rig="forced", law="coulomb-viscous").card()
    model = current_model(fit_card, [log])
    assert model.axis.shown.exposure is not None
    assert model.axis.shown.fastest == pytest.approx(0.2, rel=0.02)
    assert model.axis.shown.exposure.acceleration == pytest.approx(5.0, rel=0.1)
    limit = 1.2 * model.axis.shown.force
    for p in plan(fit_card, log).proposals:
        if p.experiment.kind == "motion":
            assert np.abs(p.experiment.predict(model.axis.x[None])).max() <= limit


def test_pressure_levels_are_offered_to_a_cylinder() -> None:
    dry = stroke_log([0.05, 0.2], TRUTH)
    assert dry.force is not None
    pressure = 2e5 * (1 + 0.04 * np.sin(dry.t))
    direction = np.sign(np.gradient(dry.position, dry.t))
    log = Recording(
        t=dry.t,
        position=dry.position,
        pressure=pressure,
        force=dry.force + 2e-5 * pressure * direction + RIGS["cylinder"].area * pressure,  # type: ignore[attr-defined]
    )
    proposed = plan(identify(log, rig="cylinder", law="coulomb-load").card(), log, count=3)
    levels, repetition = proposal(proposed, "load levels"), proposal(proposed, "the same again")
    assert factor(levels, "mu_p") > 2 * factor(repetition, "mu_p")


# --- messages and refusals ----------------------------------------------------------------------


def interrupted_at(call: int, function: Callable[..., Any]) -> Callable[..., Any]:
    """The function, interrupted at one of its calls."""
    calls = count(1)

    def interrupted(*arguments: Any) -> Any:
        if next(calls) == call:
            raise KeyboardInterrupt
        return function(*arguments)

    return interrupted


def test_ctrl_c_keeps_the_experiments_that_were_looked_at(
    bed: Card, planned: Plan, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = 2  # calls for the data at hand
    stopped = interrupted_at(before + 3, information_at)
    monkeypatch.setattr("stribeck.identify.design.plan.information_at", stopped)
    partial = plan(bed, RIGHT, check=2)
    assert partial.interrupted
    ranks = {p.experiment.name: p.score for p in partial.proposals}
    assert len(ranks) == 2
    assert ranks == {n: proposal(planned, n).score for n in ranks}
    left = {p.experiment.name for p in planned.proposals} - set(ranks)
    assert partial.said[0].startswith("interrupted: not looked at, and not ranked: ")
    assert left <= set(partial.said[0].split(": ")[2].split(", "))
    assert all(p.twin_study is None for p in partial.proposals)
    assert json.loads(plan_text(partial))["interrupted"]
    stopped = interrupted_at(before + 1, information_at)
    monkeypatch.setattr("stribeck.identify.design.plan.information_at", stopped)
    with pytest.raises(KeyboardInterrupt):
        plan(bed, RIGHT)


def test_ctrl_c_among_the_twins_keeps_the_ranking(
    bed: Card, planned: Plan, monkeypatch: pytest.MonkeyPatch
) -> None:
    stopped = interrupted_at(2, twin_study)
    monkeypatch.setattr("stribeck.identify.design.plan.twin_study", stopped)
    partial = plan(bed, RIGHT, check=1)
    assert [p.score for p in partial.proposals] == [p.score for p in planned.proposals]
    assert [p.twin_study is not None for p in partial.proposals[:3]] == [True, False, False]
    names = ", ".join(p.experiment.name for p in planned.proposals[1:3])
    assert partial.said[0] == f"interrupted: not tried on twins: {names}"
    assert not planned.interrupted


def test_an_interrupted_plan_is_told_with_its_status(
    bed: Card, planned: Plan, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    (tmp_path / "card.json").write_text(bed.text(), encoding="utf-8")
    partial = replace(planned, interrupted=True)
    monkeypatch.setattr("stribeck.identify.design.plan.plan", lambda *_, **__: partial)
    monkeypatch.setattr("stribeck.cli.reading.Reading.recordings", lambda *_: [])
    completed = caller(monkeypatch, capsys)("plan", str(tmp_path / "card.json"), "log.csv")
    assert completed.status == 130
    assert completed.err == "stribeck: interrupted: the partial result is printed above\n"
    assert planned.proposals[0].experiment.name in completed.out


def test_json_says_what_the_terminal_says(planned: Plan, capsys: Any) -> None:
    show_plan(planned)
    shown = " ".join(capsys.readouterr().out.split())  # however it is wrapped
    data = json.loads(plan_text(planned))
    assert data["schema"] == "stribeck-plan/1"
    assert [e["name"] for e in data["experiments"]] == [
        p.experiment.name for p in planned.proposals
    ]
    for k, e in enumerate(data["experiments"], 1):
        assert f"{k}. {e['name']}: {e['words']}" in shown
    first = data["experiments"][0]["parameters"]["F_C"]
    interval = data["now"]["F_C"]
    width = interval["high"] - interval["low"]
    expected = first["expected_high"] - first["expected_low"]
    assert expected == pytest.approx(width / first["factor"], rel=1e-6)


def test_logs_are_found_beside_their_card_by_their_hash(tmp_path: Path) -> None:
    log = tmp_path / "run.csv"
    assert RIGHT.command is not None
    rows = np.column_stack([RIGHT.t, RIGHT.position * 1e3, RIGHT.command * 1e3])
    text = "t_s,position_mm,command_mm\n" + "\n".join(",".join(map(repr, r)) for r in rows.tolist())
    log.write_text(text + "\n", encoding="utf-8")
    from stribeck.data import read  # noqa: PLC0415 - for this test alone

    folder = tmp_path / "out"
    folder.mkdir()
    file = folder / "card.json"
    fit_card = identify(read(log), rig="slide-bed", train="112:295", repeats=1, budget=200).card()
    file.write_text(fit_card.text(), encoding="utf-8")
    assert logs_beside(read_card(file), file) == [log]
    log.write_text(text.replace("1", "2"), encoding="utf-8")
    with pytest.raises(InputError, match=r"run\.csv is not beside it: give the log"):
        logs_beside(read_card(file), file)


def without_parameters(fit_card: Card) -> Card:
    fixed = {n: c.model_copy(update={"verdict": "fixed"}) for n, c in fit_card.parameters.items()}
    return fit_card.model_copy(update={"parameters": fixed})


@pytest.mark.parametrize(
    ("change", "options", "message"),
    [
        (without_parameters, {}, "nothing to plan for"),
        (lambda c: c, {"check": -1}, "check must be a whole number >= 0"),
        (lambda c: c, {"seed": -1}, "seed must be"),
        (lambda c: c, {"seconds": 0.0}, "seconds must be a number above 0"),
        (lambda c: c, {"seconds": float("nan")}, "seconds must be a number above 0"),
        (lambda c: c.model_copy(update={"train": ["400:500"]}), {}, "holds no motion"),
    ],
)
def test_what_cannot_be_planned_is_refused_in_a_line(
    bed: Card, change: Callable[[Card], Card], options: dict[str, Any], message: str
) -> None:
    with pytest.raises(InputError, match=message) as caught:
        plan(change(bed), RIGHT, **options)
    assert "\n" not in str(caught.value)


def test_a_stranger_among_the_logs_is_told(bed: Card) -> None:
    from dataclasses import replace  # noqa: PLC0415 - for this test alone

    source = replace(RIGHT.source, file="other.csv", sha256="0" * 64)
    proposed = plan(bed, replace(RIGHT, source=source), count=2)
    assert any("other.csv is not a log" in text for text in proposed.said)


def test_a_terminal_of_80_columns_breaks_no_word(
    planned: Plan, capsys: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    show_plan(planned)
    table, _, rest = capsys.readouterr().out.partition("\n\n")
    (heads,) = [line.split() for line in table.splitlines() if line.startswith("rank")]
    names = [g.name for g in planned.proposals[0].gains]
    assert heads[:4] == ["rank", "experiment", "s", "score"]
    assert sorted(heads[4:]) == sorted(names)
    assert not [s for s in f"{table}\n{rest}".splitlines() if len(s.rstrip()) > 80]
    verdicts = [f"{n} ({planned.cards[n].verdict})" for n in planned.doubtful]
    assert ", ".join(verdicts) in " ".join(rest.split())
