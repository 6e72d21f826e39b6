"""The report of a fit: its contents, its page, its refusals."""

from __future__ import annotations

import base64
import hashlib
import json
import re
import shlex
from collections.abc import Iterator
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.signal

from command import Completed, caller
from stribeck import identify
from stribeck.data.recording import Recording, Source
from stribeck.identify.result import Fit
from stribeck.report.contents.confidence_band import band
from stribeck.report.contents.decimation import corners, rounded
from stribeck.report.contents.gather import LARGEST, Contents
from stribeck.report.contents.law_curve import sides
from stribeck.report.contents.schema import Report, read_report
from stribeck.report.contents.spectrum import autocorrelation, longest_even, power_density
from stribeck.report.page.html_page import render, write_page, write_report
from stribeck.rig.twin import TestBed

NASTY = "<img src=x onerror=alert(1)>&'\".csv"
COMMAND = ["stribeck", "identify", "a log.csv", "--rig", "slide-bed", "--out", "it's"]


@pytest.fixture(scope="module")
def twin() -> Recording:
    return TestBed().run("both", seed=1).recording


@pytest.fixture(scope="module")
def fit(twin: Recording) -> Fit:
    """A fit of the slide bed to a log whose name is markup that the page must escape."""
    log = replace(twin, source=Source(NASTY, "ab" * 32, len(twin)))
    return identify(
        log, rig="slide-bed", train="325:127", holdout=["352:325", "127:68"], budget=600, repeats=2
    )


@pytest.fixture(scope="module")
def report(fit: Fit) -> Report:
    return Contents(fit).report(COMMAND)


@pytest.fixture(scope="module")
def balance_fit() -> Fit:
    """A force balance of a simulated motion: M = 4 kg, F_C = 3 N, F_V = 20 N s/m."""
    t = np.arange(0.0, 8.0, 2e-3)
    x = 0.1 * np.sin(2 * np.pi * 0.5 * t) + 0.04 * np.sin(2 * np.pi * 1.1 * t)
    v, a = np.gradient(x, t), np.gradient(np.gradient(x, t), t)
    noise = np.random.default_rng(3).normal(0.0, 0.2, len(t))
    force = 4.0 * a + 3.0 * np.sign(v) + 20.0 * v + noise
    log = Recording(t, x, force=force, source=Source("made.csv", "cd" * 32, len(t)))
    return identify(log, rig="forced", law="coulomb-viscous", train="0s:6s", holdout="6s:8s")


class Page(HTMLParser):
    """The tags of a page, and its words outside of scripts and styles."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.words: list[str] = []
        self._inside: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        if tag in ("script", "style"):
            self._inside.append(tag)

    def handle_endtag(self, tag: str) -> None:
        if self._inside and tag == self._inside[-1]:
            self._inside.pop()

    def handle_data(self, data: str) -> None:
        if not self._inside:
            self.words.append(data)

    @property
    def text(self) -> str:
        return " ".join(" ".join(self.words).split())

    def named(self, tag: str) -> list[dict[str, str | None]]:
        return [attributes for name, attributes in self.tags if name == tag]


def specs(page: str) -> dict[str, Any]:
    """The plots of a page, as its script reads them."""
    match = re.search(r'<script type="application/json" id="plots">(.*?)</script>', page, re.DOTALL)
    assert match is not None
    plots: dict[str, Any] = json.loads(match[1])
    return plots


def test_what_is_written_is_read_back_the_same(fit: Fit, report: Report, tmp_path: Path) -> None:
    write_report(Contents(fit).report(COMMAND), tmp_path / "new")
    assert read_report(tmp_path / "new") == report
    first = (tmp_path / "new" / "report.html").read_bytes()
    assert write_page(tmp_path / "new").read_bytes() == first == render(report).encode()
    assert sorted(f.name for f in (tmp_path / "new").iterdir()) == ["report.html", "report.json"]


def test_the_page_asks_the_network_for_nothing(report: Report) -> None:
    page = Page(render(report))
    assert not [a for t, a in page.tags if t in ("link", "iframe", "img", "object", "base")]
    assert not [a for a in page.named("script") if "src" in a]
    assert all(str(a["href"]).startswith("#") for a in page.named("a"))
    (policy,) = [a["content"] for a in page.named("meta") if "http-equiv" in a]
    rules = dict(part.split(" ", 1) for part in str(policy).split("; "))
    assert rules["default-src"] == "'none'"
    assert "unsafe" not in rules["script-src"]
    assert "http" not in str(policy)


def test_only_the_script_of_the_page_may_run(report: Report) -> None:
    page = render(report)
    script = page[page.rindex("<script>") + 8 : page.rindex("</script>")]
    printed = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    (policy,) = [a["content"] for a in Page(page).named("meta") if "http-equiv" in a]
    assert f"'sha256-{printed}'" in str(policy)


def test_a_log_with_a_nasty_name_stays_a_name(report: Report) -> None:
    page = render(report)
    assert NASTY not in page
    assert NASTY in Page(page).text
    assert "<" not in page[page.index('id="plots">') + 11 : page.index("</script>")]
    assert any(NASTY in view["name"] for p in specs(page).values() for view in p["views"])
    assert shlex.join(COMMAND) in Page(page).text


def test_a_warning_is_first_and_escaped(report: Report) -> None:
    card = report.card.model_copy(update={"warnings": ["</li><script>alert(1)</script>"]})
    page = Page(render(report.model_copy(update={"card": card})))
    assert "</li><script>alert(1)</script>" in page.text
    assert len(page.named("script")) == 3
    assert page.text.index("1 warning") < page.text.index("What was measured")


def test_no_warning_is_said_too(report: Report) -> None:
    card = report.card.model_copy(update={"warnings": []})
    assert "No warnings" in Page(render(report.model_copy(update={"card": card}))).text


def test_sections_come_in_the_order_in_which_they_are_asked_for(report: Report) -> None:
    page = Page(render(report))
    expected = ["warnings", "parameters", "friction", "fit", "baselines", "residuals", "adequacy",
              "profiles", "search", "measured", "strokes", "provenance"]  # fmt: skip
    assert [a["id"] for a in page.named("h2")] == expected
    links = [str(a["href"]).removeprefix("#") for a in page.named("a")]
    assert links == ["main", *expected[1:]]


def test_the_misfit_is_explained_where_it_stands(report: Report, balance_fit: Fit) -> None:
    text = Page(render(report)).text
    assert text.index("J, training") < text.index("J is the root mean square of measured less")
    assert text.index("J is the root mean square") < text.index("95 % from")
    balanced = Page(render(Contents(balance_fit).report())).text
    assert "The relative error is that of the force" in balanced
    assert "J is the root" not in balanced


def test_what_a_held_out_range_tests_is_told(report: Report) -> None:
    text = Page(render(report)).text
    first, second = report.card.holdout
    assert first.tests in text
    assert second.tests in text
    seconds, travel, slips = second.tests.split(", ")
    assert seconds.endswith(" s")
    assert 45 < float(travel.split(" ")[0]) < 60  # 127 to 68 mm, by whole slips
    assert slips == "1 slip"  # which ends in it; no rest follows the last one
    idle = first.model_copy(update={"moves": False})
    card = report.card.model_copy(update={"holdout": [idle]})
    page = Page(render(report.model_copy(update={"card": card}))).text
    assert "which tests nothing: the axis does not move there" in page
    assert "tests nothing" not in text


def test_what_has_nothing_to_say_is_absent(balance_fit: Fit) -> None:
    page = Page(render(Contents(balance_fit).report()))
    ids = [a["id"] for a in page.named("h2")]
    assert "search" not in ids
    assert "bootstrap" not in ids
    assert "To make it again" not in page.text  # nobody typed anything


def test_every_plot_is_told_in_a_sentence_with_numbers(report: Report) -> None:
    page = render(report)
    tags = Page(page)
    described = {
        a["id"]: a["aria-describedby"] for a in tags.named("div") if a.get("class") == "canvas"
    }
    assert set(described) == set(specs(page))
    assert {a["id"] for a in tags.named("span") if "id" in a} >= set(described.values())
    for plot in specs(page).values():
        for view in plot["views"]:
            assert re.search(r"\d", view["alt"]), plot["id"]
            assert view["alt"].endswith(".")


def test_columns_of_a_line_have_one_length(report: Report) -> None:
    for plot in specs(render(report)).values():
        for view in plot["views"]:
            for line in view["lines"]:
                lengths = {len(view["columns"][line[k]]) for k in ("x", "y", "low") if k in line}
                lengths |= {len(line["hover"])} if "hover" in line else set()
                assert len(lengths) == 1, (plot["id"], line["name"])
                assert line.get("panel", 0) < len(plot["panels"])


def test_a_slip_is_told_by_start_jump_duration_and_speed(fit: Fit, report: Report) -> None:
    view = specs(render(report))["log-plot"]["views"][0]
    (slip_rows,) = [
        line["hover"] for line in view["lines"] if line["name"] == "slip" and "hover" in line
    ]
    (log,) = report.logs
    assert len(slip_rows) == len(log.slips) > 10
    slip, x = log.slips[0], fit.recordings[0].position * 1e3
    t = fit.recordings[0].t
    moved = x[np.searchsorted(t, slip.stop)] - x[np.searchsorted(t, slip.start)]
    assert slip.jump == pytest.approx(moved, abs=1.5)  # mm: levels, not single echoes
    assert slip_rows[0] == (
        f"slip 1: starts at {slip.start:.5g} s\njump {slip.jump:.4g} mm in "
        f"{slip.stop - slip.start:.3g} s\ngreatest speed {slip.speed:.3g} mm/s"
    )


def test_traces_are_those_of_the_fit(fit: Fit, report: Report) -> None:
    training, *holdouts = report.motions
    assert [m.part for m in report.motions] == ["training", "352:325", "127:68"]
    track = fit.train[0].track
    t, x = np.array(training.t, dtype=float), np.array(training.measured, dtype=float)
    np.testing.assert_allclose(np.interp(t, track.t, track.measured) * 1e3, x, atol=1e-3)
    assert training.rms == pytest.approx(fit.score.value, rel=1e-6)
    assert [m.rms for m in holdouts] == pytest.approx(
        [h.score.value for h in fit.holdout], rel=1e-6
    )
    model = fit.holdout[0].motions[0]
    simulated = np.interp(np.array(holdouts[0].t, dtype=float), model.t, model.position[0]) * 1e3
    np.testing.assert_allclose(simulated, np.array(holdouts[0].model, dtype=float), atol=1e-3)


def test_what_did_not_count_is_shaded_and_has_no_residual(fit: Fit, report: Report) -> None:
    ((a, b),) = report.motions[0].unscored
    track = fit.train[0].track
    assert a == track.t[0]
    assert b == track.t[track.score > 0][0]
    assert min(v for v in report.motions[0].residual_t if v is not None) >= b - 1e-3


def test_interval_and_profile_meet(report: Report) -> None:
    for p in report.profiles:
        on_card = report.card.parameters[p.name]
        assert (on_card.value, on_card.low, on_card.high) == (p.value, p.low, p.high)
        at, rises = np.array(p.values, dtype=float), np.array(p.rises, dtype=float)
        assert np.interp(p.value, at, rises) == pytest.approx(0.0, abs=0.05)
        if on_card.low_ended == "threshold":
            assert p.low is not None
            assert np.interp(p.low, at, rises) == pytest.approx(1.0, abs=0.15)


def test_convergence_falls_to_what_the_repeat_found(report: Report) -> None:
    assert len(report.runs) == 2
    for run in report.runs:
        best = [v for v in run.best if v is not None]
        assert best == sorted(best, reverse=True)
        assert best[-1] == pytest.approx(run.searched, rel=1e-5)
        assert run.at[-1] <= run.evaluations


def test_a_force_balance_shows_force_velocity_and_cloud(balance_fit: Fit) -> None:
    report = Contents(balance_fit).report()
    assert [m.part for m in report.motions] == ["training", "6s:8s"]
    training, holdout = report.motions
    residuals = np.array([v for v in holdout.residual if v is not None])
    measured = np.array(holdout.measured, dtype=float)
    value = 100 * np.linalg.norm(residuals) / np.linalg.norm(measured)
    assert value == pytest.approx(balance_fit.holdout[0].score.value, rel=0.05)
    assert training.velocity is not None
    v, F = (
        np.array(a, dtype=float) for a in (report.law.cloud_velocity, report.law.cloud_friction)
    )
    v = v / 1000  # shown in mm/s
    fast = np.abs(v) > 0.3 * np.abs(v).max()
    np.testing.assert_allclose(F[fast], 3.0 * np.sign(v[fast]) + 20.0 * v[fast], atol=1.0)


def test_the_band_of_a_straight_law_is_that_of_its_covariance(balance_fit: Fit) -> None:
    """F_C + F_V v: the standard error at v is sqrt(var F_C + 2 v cov + v² var F_V)."""
    (v, _) = sides(-0.5, 0.5, 20)
    bands = band(balance_fit, [v])
    assert bands is not None
    source, ((low, high),) = bands
    assert source == "intervals"
    e = {estimate.name: estimate for estimate in balance_fit.estimates}
    half = {n: (e[n].high - e[n].low) / 2 for n in ("F_C", "F_V")}
    names = [q.name for q in balance_fit.parameters.free]
    i, j = names.index("F_C"), names.index("F_V")
    shared = balance_fit.uncertainty.correlation[i, j] * half["F_C"] * half["F_V"]
    expected = np.sqrt(half["F_C"] ** 2 + 2 * v * shared + (v * half["F_V"]) ** 2)
    np.testing.assert_allclose((high - low) / 2, expected, rtol=0.2)  # 300 draws
    best = balance_fit.values["F_C"] + balance_fit.values["F_V"] * v
    assert (low < best).all()
    assert (best < high).all()


def test_a_bootstrap_is_told_beside_the_profiles(balance_fit: Fit) -> None:
    refitted = identify(balance_fit.recordings, rig="forced", law="coulomb-viscous", bootstrap=80)
    report = Contents(refitted).report()
    assert report.law.band == "bootstrap"
    assert report.draws is not None
    page = Page(render(report))
    assert "Bootstrap intervals" in page.text
    assert f"{report.draws.drawn} data sets" in page.text


def test_a_posterior_stands_beside_the_profiles(balance_fit: Fit) -> None:
    pytest.importorskip("emcee")
    refitted = identify(balance_fit.recordings, rig="forced", law="coulomb-viscous", posterior=500)
    report = Contents(refitted).report()
    assert report.card.posterior is not None
    page = Page(render(report))
    assert "posterior from" in page.text
    assert "500 samples" in page.text


@pytest.fixture(scope="module")
def four_log_fit(balance_fit: Fit) -> Fit:
    """A fit to four logs: three parts of one, and the whole."""
    (log,) = balance_fit.recordings
    logs = [
        replace(log.cut(slice(k * 800, k * 800 + 1600)), source=Source(f"{k}.csv", f"{k}" * 64, 9))
        for k in range(3)
    ] + [replace(log, source=Source("whole.csv", "e" * 64, len(log)))]
    return identify(logs, rig="forced", law="coulomb-viscous")


def test_many_logs_share_a_plot(four_log_fit: Fit) -> None:
    page = render(Contents(four_log_fit).report())
    plots = specs(page)
    assert [view["name"] for view in plots["fit-0"]["views"]] == [
        f"Training: {name}.csv" for name in ("0", "1", "2", "whole")
    ]
    assert len(Page(page).named("select")) == 3
    assert "Each log" in Page(page).text


def test_of_too_many_the_worst_are_shown_and_the_others_counted(
    four_log_fit: Fit, monkeypatch: pytest.MonkeyPatch
) -> None:
    errors = {m.label: m.rms for m in Contents(four_log_fit).report().motions}
    monkeypatch.setattr("stribeck.report.contents.gather.MOST", 2)
    report = Contents(four_log_fit).report()
    worst = sorted(errors, key=lambda name: -(errors[name] or 0.0))[:2]
    assert {m.label for m in report.motions} == set(worst)
    assert (report.hidden, report.unshown) == (2, 2)
    text = Page(render(report)).text
    assert "2 more motions with smaller errors are not shown" in text
    assert "2 more logs with smaller errors are not shown" in text


def test_a_report_stays_small_whatever_the_log(balance_fit: Fit) -> None:
    (log,) = balance_fit.recordings
    t = np.arange(0.0, 90.0, 1e-3)
    x = np.interp(t % 8.0, log.t, log.position) + 1e-6 * np.sin(1e3 * t)
    F = np.interp(t % 8.0, log.t, np.asarray(log.force))
    logs = [
        Recording(t, x * (1 + 0.01 * k), force=F, source=Source(f"{k}.csv", f"{k:064d}", len(t)))
        for k in range(3)
    ]
    report = Contents(identify(logs, rig="forced", law="coulomb-viscous")).report()
    assert len(report.text()) <= LARGEST
    assert len(render(report)) < 6e6


def test_a_staircase_keeps_its_corners() -> None:
    t = np.linspace(0.0, 100.0, 100_001)
    knots_t = np.array([0.0, 12.34, 12.9, 47.111, 47.6, 100.0])
    knots_x = np.array([0.0, 0.0, 30.0, 30.0, 55.0, 55.0])
    x = np.interp(t, knots_t, knots_x)
    rows = corners([x], 2000)
    assert len(rows) <= 2000
    np.testing.assert_allclose(np.interp(t, t[rows], x[rows]), x, atol=0.02)
    spiked = x.copy()
    spiked[77_777], spiked[3_333] = 99.0, -7.0
    rows = corners([spiked], 2000)
    assert {77_777, 3_333, 0, 100_000} <= set(rows.tolist())


def test_lines_over_the_same_times_keep_the_corners_of_each() -> None:
    n = 50_000
    first, second = np.zeros(n), np.zeros(n)
    first[11_111], second[33_333] = 1.0, -1.0
    second[20_000:20_003] = np.nan
    rows = set(corners([first, second], 1000).tolist())
    assert {11_111, 33_333, 20_000, 20_001, 20_002} <= rows


def test_short_lines_are_kept_whole() -> None:
    assert corners([np.arange(50.0)], 50).tolist() == list(range(50))


@pytest.mark.parametrize("scale", [1e-12, 1.0, 1e9])
def test_rounding_is_to_the_span(scale: float) -> None:
    y = scale * (5.0 + np.random.default_rng(0).uniform(0.0, 1.0, 100))
    y[7] = np.nan
    short = rounded(y, 6)
    assert short[7] is None
    numbers = np.array([v for v in short if v is not None])
    assert np.abs(numbers - y[np.isfinite(y)]).max() <= 1e-5 * scale
    assert rounded(np.full(3, np.nan)) == [None] * 3
    assert rounded(np.zeros(2)) == [0.0, 0.0]


def test_densities_are_those_of_scipy() -> None:
    y = np.random.default_rng(5).normal(size=3000).cumsum()
    f, density = power_density(y, 0.01)
    width = 2 * (len(f) - 1)
    frequencies, expected = scipy.signal.welch(y, 100.0, "hann", width, detrend="constant")
    np.testing.assert_allclose(f, frequencies, rtol=1e-12)
    np.testing.assert_allclose(density, expected, rtol=1e-9)


def test_the_density_of_white_noise_adds_up_to_its_variance() -> None:
    y = np.random.default_rng(6).normal(0.0, 2.0, 20_000)
    f, density = power_density(y, 0.002)
    assert density.sum() * f[1] == pytest.approx(4.0, rel=0.05)


def test_a_swing_that_rings_on_correlates_with_itself() -> None:
    t = np.arange(0.0, 20.0, 0.01)
    r = autocorrelation(np.cos(2 * np.pi * t))
    assert r[0] == pytest.approx(1.0)
    assert r[50] == pytest.approx(-1.0, abs=0.05)
    assert r[100] == pytest.approx(1.0, abs=0.06)


def test_gaps_part_a_signal_and_the_longest_part_is_taken() -> None:
    t = np.concatenate([np.arange(0.0, 1.0, 0.01), [np.nan], np.arange(5.0, 9.0, 0.01)])
    longest = longest_even(t, np.where(t < 3, 100.0, t))
    assert longest is not None
    step, y = longest
    assert step == pytest.approx(0.01)
    np.testing.assert_allclose(y, np.arange(5.0, 9.0, 0.01), atol=1e-9)
    assert longest_even(np.arange(20.0), np.arange(20.0)) is None


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Iterator[Any]:
    return caller(monkeypatch, capsys)  # type: ignore[return-value]


def refused(completed: Completed) -> str:
    assert completed.status == 2
    assert completed.out == ""
    (line,) = completed.err.splitlines()
    assert line.startswith("stribeck: ")
    return line


def test_the_command_makes_the_page_again(run: Any, report: Report, tmp_path: Path) -> None:
    (tmp_path / "report.json").write_text(report.text(), encoding="utf-8")
    completed = run("report", str(tmp_path))
    assert (completed.status, completed.out.strip()) == (0, str(tmp_path / "report.html"))
    assert (tmp_path / "report.html").read_text(encoding="utf-8") == render(report)


def test_no_folder_and_no_report_are_one_line(run: Any, tmp_path: Path) -> None:
    assert "no such folder" in refused(run("report", str(tmp_path / "nowhere")))
    assert "report.json: no such file" in refused(run("report", str(tmp_path)))
    (tmp_path / "report.json").mkdir()
    assert "is a folder" in refused(run("report", str(tmp_path)))


@pytest.mark.parametrize(
    ("change", "line"),
    [
        ({"schema": "stribeck-report/2"}, "its schema is stribeck-report/2"),
        ({"schema": "stribeck-card/1"}, "not a report"),
        ({"road": "sideways"}, "damaged at road"),
        ({"surprise": 1}, "damaged at surprise"),
        ({"motions": [{"label": "a"}]}, "damaged at motions.0"),
        ({"command": ["x" * 30_000]}, "damaged at command.0"),
    ],
)
def test_a_damaged_or_newer_report_is_one_line(
    run: Any, report: Report, tmp_path: Path, change: dict[str, Any], line: str
) -> None:
    data = json.loads(report.text()) | change
    (tmp_path / "report.json").write_text(json.dumps(data), encoding="utf-8")
    assert line in refused(run("report", str(tmp_path)))
    assert not (tmp_path / "report.html").exists()


@pytest.mark.parametrize(
    ("part", "line"), [("logs", "position"), ("motions", "t"), ("profiles", "rises")]
)
def test_lines_cut_short_are_one_line(
    run: Any, report: Report, tmp_path: Path, part: str, line: str
) -> None:
    data = json.loads(report.text())
    data[part][0][line] = []
    (tmp_path / "report.json").write_text(json.dumps(data), encoding="utf-8")
    assert "do not fit together" in refused(run("report", str(tmp_path)))
    assert not (tmp_path / "report.html").exists()


@pytest.mark.parametrize("text", ["", "{", "[1]", "null", "\x00\xff", '{"a": ' * 50_000])
def test_what_is_no_report_at_all_is_one_line(run: Any, tmp_path: Path, text: str) -> None:
    (tmp_path / "report.json").write_bytes(text.encode("latin-1"))
    refused(run("report", str(tmp_path)))


def test_a_number_that_is_none_is_refused(run: Any, report: Report, tmp_path: Path) -> None:
    text = re.sub(r'"rms":[0-9.]+', '"rms":NaN', report.text(), count=1)
    (tmp_path / "report.json").write_text(text, encoding="utf-8")
    assert "damaged" in refused(run("report", str(tmp_path)))


def test_a_page_that_cannot_be_written_is_one_line(
    run: Any, report: Report, tmp_path: Path
) -> None:
    (tmp_path / "report.json").write_text(report.text(), encoding="utf-8")
    (tmp_path / "report.html").mkdir()
    (tmp_path / "report.html" / "full").touch()
    assert "cannot be written" in refused(run("report", str(tmp_path)))


def test_identify_writes_the_page_and_what_was_typed(
    run: Any, balance_fit: Fit, tmp_path: Path
) -> None:
    (log,) = balance_fit.recordings
    file = tmp_path / "a log.csv"
    head = "time [s],position [m],force [N]"
    rows = np.column_stack([log.t, log.position, np.asarray(log.force)])
    np.savetxt(file, rows, delimiter=",", header=head, comments="", fmt="%.9g")
    arguments = ["identify", str(file), "--rig", "forced", "--out", str(tmp_path / "out")]
    completed = run(*arguments)
    assert (completed.status, completed.err) == (0, "")
    assert "report.html" in completed.out
    report = read_report(tmp_path / "out")
    assert report.command == ["stribeck", *arguments]
    page = Page((tmp_path / "out" / "report.html").read_text(encoding="utf-8"))
    assert shlex.join(["stribeck", *arguments]) in page.text
    assert report.card.data[0].sha256 == hashlib.sha256(file.read_bytes()).hexdigest()
    assert report.card.data[0].sha256 in page.text
