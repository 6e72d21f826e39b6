"""The report of a fit on the terminal: errors of each log, warnings, stick-slip statistics."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stribeck import identify
from stribeck.data import Recording
from stribeck.identify.result import Fit
from stribeck.identify.validate import validate
from stribeck.report.fit_report import LISTED, show_fit
from stribeck.report.misfit import balance_figures, log_errors
from stribeck.report.terminal import gathered, show_warnings
from stribeck.report.validation_report import show_validation
from stribeck.rig.twin import TestBed


@pytest.fixture(scope="module")
def fit() -> Fit:
    logs = [TestBed().run("up", seed=s).recording for s in (1, 2, 3)]
    return identify(
        logs, rig="slide-bed", train="112:200", holdout="200:295", budget=400, repeats=1
    )


def test_the_errors_of_the_logs_make_up_that_of_all(fit: Fit) -> None:
    rows = log_errors(fit)
    assert [name for name, _, _ in rows] == [log.label for log in fit.recordings]
    for part, score in enumerate((fit.score, fit.holdout[0].score)):
        segments = (fit.train, fit.holdout[0].segments)[part]
        counts = [
            sum(float(s.track.score.sum()) for s in segments if s.recording is log)
            for log in fit.recordings
        ]
        squares = [errors[part] ** 2 for _, _, errors in rows]
        pooled = np.sqrt(np.dot(squares, counts) / np.sum(counts))
        assert pooled == pytest.approx(score.value, rel=1e-9)


def test_figures_of_a_balance_have_units() -> None:
    figures = {"relative_error_percent": 4.0, "residual_sd": 2.0, "friction_range_N a_1": 9.0}
    assert balance_figures(figures, "N m") == [
        ["relative error / %", "4"], ["residual sd / N m", "2"], ["friction range / N, a_1", "9"],
    ]  # fmt: skip


def test_each_log_has_a_line(fit: Fit, capsys: pytest.CaptureFixture[str]) -> None:
    show_fit(fit)
    output = capsys.readouterr().out
    _, _, table = output.partition("each log, J / mm")
    lines = table.splitlines()[1:4]
    for line, (name, samples, errors) in zip(lines, log_errors(fit), strict=True):
        assert line.split()[-4:] == [
            name.split()[-1], f"{errors[0]:.4g}", f"{samples:,}", f"{errors[1]:.4g}",
        ]  # fmt: skip


def test_of_very_many_logs_the_worst_have_a_line(
    fit: Fit, capsys: pytest.CaptureFixture[str]
) -> None:
    repeated = replace(fit, recordings=fit.recordings * 8, holdout=(), train=fit.train)
    show_fit(repeated)
    output = capsys.readouterr().out
    worst = max(errors[0] for _, _, errors in log_errors(repeated))
    _, _, table = output.partition(f"the {LISTED} worst of 24 logs, J / mm")
    assert table.count(f" {worst:.4g} ") == 8


def test_how_it_stuck_and_slipped_is_said(fit: Fit, capsys: pytest.CaptureFixture[str]) -> None:
    show_fit(fit)
    output = capsys.readouterr().out
    measured = fit.score.measured
    assert measured is not None
    (line,) = [text for text in output.splitlines() if text.startswith("training, axis")]
    assert line.split()[2:] == [
        str(measured.slips), f"{measured.jump * 1e3:.3g}", f"{measured.stuck:.0%}",
    ]  # fmt: skip


def test_many_validations_are_pooled_as_the_fit_pools_them(
    fit: Fit, capsys: pytest.CaptureFixture[str]
) -> None:
    show_validation(fit.card(), validate(fit, fit.recordings, "200:295"))
    *_, last = capsys.readouterr().out.splitlines()
    score = fit.holdout[0].score
    assert last.split() == [
        "all", "of", "these", f"{score.value:.4g}", f"{score.smooth:.4g}", f"{score.still:.4g}",
        str(score.samples),
    ]  # fmt: skip


def test_what_is_said_of_many_logs_is_said_once() -> None:
    lines = gathered(
        [
            "J is 3 times the noise: look again",
            "a.csv: 90 % of the intervals last 3.4 to 5.4 ms",
            "b.csv: 90 % of the intervals last 3.5 to 7 ms",
            "b.csv: 2 samples were dropped",
            "J is 4 times the noise: look again",
            "c.csv: 12 empty Current_J0 values interpolated",
            "c.csv: 15 empty Current_J1 values interpolated",
            "c.csv: 12 empty Current_J2 values interpolated",
        ]
    )
    assert lines == [
        "J is 3 times the noise: look again",
        "a.csv: 90 % of the intervals last 3.4 to 5.4 ms (and much the same of 1 more log)",
        "b.csv: 2 samples were dropped",
        "J is 4 times the noise: look again",
        "c.csv: 12 empty Current_J0 values interpolated (and 2 more like it)",
    ]


def test_long_warnings_are_paragraphs(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("COLUMNS", "60")
    text = "the model explains little and the rest of this line is here to make it long indeed"
    show_warnings([text], [])
    first, *continuation = capsys.readouterr().out.splitlines()
    assert first.startswith("warning: the model")
    assert continuation
    assert all(line.startswith(" " * 9) and line[9] != " " for line in continuation)
    assert max(map(len, [first, *continuation])) <= 60
    assert " ".join(" ".join([first, *continuation]).split()) == f"warning: {text}"


def test_one_log_has_no_table_of_logs(capsys: pytest.CaptureFixture[str]) -> None:
    log: Recording = TestBed().run("up", seed=1).recording
    show_fit(identify(log, rig="slide-bed", train="112:295", budget=60, repeats=1))
    assert "each log" not in capsys.readouterr().out
