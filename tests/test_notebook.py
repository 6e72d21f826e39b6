"""Results as a notebook shows them, and what a fit answers of itself."""

from __future__ import annotations

import math
import struct
from collections.abc import Callable
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
import pytest

from stribeck import (
    Card,
    Fit,
    InputError,
    Recording,
    check,
    compensate,
    identify,
    plan,
    report,
    select,
    simulate,
    twin,
)

NASTY = "<script>alert(1)</script>&\"'.csv"
T = np.arange(0.0, 8.0, 4e-3)
X = 0.1 * np.sin(np.pi * T) + 0.04 * np.sin(2.2 * np.pi * T)
V, A = np.gradient(X, T), np.gradient(np.gradient(X, T), T)
NOISE = 0.2 * np.random.default_rng(5).standard_normal(len(T))
FRAME = {"t_s": T, "x_m": X, "F_N": 4.0 * A + 3.0 * np.sign(V) + 20.0 * V + NOISE, "<b>": T}


@pytest.fixture(scope="module")
def log() -> Recording:
    return Recording.of(FRAME, name=NASTY)


@pytest.fixture(scope="module")
def fit(log: Recording) -> Fit:
    return identify(log, rig="forced", law="coulomb-viscous", holdout="6s:8s")


class Tables(HTMLParser):
    """The rows of all tables of a piece of HTML; other tags must be closed and known."""

    KNOWN = frozenset(
        {
            "p",
            "b",
            "div",
            "table",
            "caption",
            "thead",
            "tbody",
            "tr",
            "th",
            "td",
            "span",
            "ul",
            "li",
        }
    )

    def __init__(self, text: str) -> None:
        super().__init__()
        self.rows: list[list[str]] = []
        self.open: list[str] = []
        self.text = ""
        self.feed(text)
        assert self.open == []

    def handle_starttag(self, tag: str, attrs: Any) -> None:
        assert tag in self.KNOWN, f"<{tag} {attrs}>"
        self.open.append(tag)
        if tag == "tr":
            self.rows.append([])
        elif tag in ("th", "td"):
            self.rows[-1].append("")

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.text += data
        if {"th", "td"} & set(self.open):
            self.rows[-1][-1] += data


def shown(result: Any) -> Tables:
    return Tables(result._repr_html_())


def test_a_fit_shows_its_parameters_misfit_and_warnings(fit: Fit) -> None:
    page = shown(fit)
    names = [row[0] for row in page.rows]
    assert {"F_C", "F_V", "M", "training", "held out, 6s:8s"} <= set(names)
    (row,) = [row for row in page.rows if row[0] == "M"]
    assert float(row[1]) == pytest.approx(4.0, rel=0.01)
    assert all(warning in page.text for warning in fit.warnings[:1])
    assert shown(fit.card()).rows == page.rows


def test_a_recording_shows_its_channels_and_what_was_mended(log: Recording) -> None:
    rows = {row[0]: row[1:] for row in shown(log).rows}
    assert rows["position"][0] == "mm"
    assert float(rows["position"][2]) == pytest.approx(1e3 * X.max(), rel=1e-3)
    assert rows["force"][0] == "N"
    assert "<b>" in rows  # as text
    assert NASTY in shown(log).text
    assert shown(check(log)).rows


def test_a_comparison_and_a_plan_show_their_tables(log: Recording, fit: Fit) -> None:
    selection = select(log, rig="forced", laws=["coulomb-viscous", "stribeck"], folds=2)
    page = shown(selection)
    assert [row[1] for row in page.rows[1:]] == ["coulomb-viscous", "stribeck"]
    assert selection.sentences[0] in page.text
    proposed = plan(fit, count=1)
    page = shown(proposed)
    assert [row[1] for row in page.rows[1:]] == [p.experiment.name for p in proposed.proposals]
    assert proposed.proposals[0].experiment.words in page.text


def test_a_compensation_shows_its_scales_and_what_is_recommended() -> None:
    log = twin("down", seed=3, loop="ideal").recording
    slide = identify(log, rig="slide-bed", train="325:200", exact=True, budget=400, repeats=1)
    tried = compensate(slide, mode="reference")
    page = shown(tried)
    (curve,) = tried.curves
    scales = [float(row[0]) for row in page.rows[1 : len(curve.scales) + 1]]
    assert scales == pytest.approx(sorted(curve.scales.tolist()), rel=1e-3)
    assert tried.compensator is not None
    assert f"Compensate by reference at scale {tried.compensator.scale:.4g}" in page.text
    assert repr(tried) == (
        f"<Compensation of stribeck on slide-bed: reference, scale {tried.compensator.scale:.4g}>"
    )


def test_a_table_is_a_frame_in_the_units_of_the_card(fit: Fit) -> None:
    table, card = fit.table(), fit.card()
    assert isinstance(table, pl.DataFrame)
    assert table["parameter"].to_list() == list(card.parameters)
    for row in table.iter_rows(named=True):
        entry = card.parameters[row["parameter"]]
        assert {*row} > {"low_ended", "high_ended", "standard_error"}
        for column in {*row} - {"parameter"}:
            assert row[column] == getattr(entry, column)


def test_intervals_are_those_of_the_card_in_si(fit: Fit) -> None:
    assert set(fit.intervals) == {"F_C", "F_V", "M", "offset"}
    for name, (low, high) in fit.intervals.items():
        assert low < fit.values[name] < high
        entry = fit.card().parameters[name]
        assert (entry.low, entry.high) == (low, high)  # rig `forced` shows SI
    held = identify(FRAME, rig="forced", law="coulomb-viscous", fixed={"M": 4.0})
    assert "M" not in held.intervals
    (mass,) = held.table().filter(pl.col("parameter") == "M").iter_rows(named=True)
    assert mass["low"] is mass["high"] is mass["low_ended"] is mass["high_ended"] is None


def test_a_figure_is_a_picture_in_a_notebook(fit: Fit) -> None:
    figure: Any = fit.plot("friction")
    picture = figure._repr_png_()
    assert picture.startswith(b"\x89PNG")
    width, height = struct.unpack(">II", picture[16:24])
    assert 600 < width < 3000
    assert height > 300
    assert fit.plot().axes[0].get_xlabel().startswith("Velocity")
    with pytest.raises(InputError, match="no figure 'nope' of this fit: there are force, friction"):
        fit.plot("nope")


def test_a_report_is_a_page_at_the_path(fit: Fit, tmp_path: Path) -> None:
    for write in (fit.report, lambda path: report(fit, path)):
        file = write(tmp_path / "x.html")
        assert file == tmp_path / "x.html"
        assert "coulomb-viscous friction on forced" in file.read_text(encoding="utf-8")
        assert [p.name for p in tmp_path.iterdir()] == ["x.html"]
        file.unlink()
    with pytest.raises(InputError, match="name it"):
        fit.report(tmp_path / "x.pdf")
    with pytest.raises(InputError, match="name a file"):
        report(fit)


@pytest.mark.parametrize("of", [lambda fit: fit, lambda fit: fit.card()])
def test_a_misfit_that_is_no_number_is_told_and_not_raised(of: Callable[..., Any]) -> None:
    """What shows itself in a notebook must not raise; a card of such a fit cannot be."""
    from dataclasses import replace  # noqa: PLC0415

    fit = identify(FRAME, rig="forced", law="coulomb-viscous")
    broken = replace(fit, score=replace(fit.score, value=math.nan))
    assert "the misfit is not a finite number" in shown(broken).text
    assert isinstance(of(fit), Fit | Card)


def test_a_simulation_is_a_recording_under_the_command() -> None:
    t = np.arange(0.0, 6.0, 0.01)
    command = np.where(t < 1, 0.1, 0.1 + 5e-3 * (t - 1))
    bed = Recording(t, command, command=command)
    fit = identify(
        {"t_s": t, "x_mm": 1e3 * command, "x_d_mm": 1e3 * command}, rig="slide-bed", budget=20,
        repeats=1, fixed={"k_spring": 1.0},
    )  # fmt: skip
    motion = simulate(fit, bed)
    assert motion.label == "recording, simulated"
    np.testing.assert_array_equal(motion.command, command)
    assert motion.velocity is not None
    way = np.cumsum(motion.velocity) * 0.01
    np.testing.assert_allclose(way - way[0], motion.position - motion.position[0], atol=2e-3)
