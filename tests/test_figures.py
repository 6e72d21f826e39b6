"""The figures of a fit: what they compute and what they draw."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.text import Text
from scipy.signal import savgol_filter

from stribeck import RIGS, Recording, identify
from stribeck.identify.balance.balance import Signals
from stribeck.identify.result import Fit
from stribeck.identify.score import simulated
from stribeck.report.contents.decimation import corners
from stribeck.report.contents.gather import Contents
from stribeck.report.contents.law_curve import local_quadratics, reach
from stribeck.report.contents.motion_traces import (
    MotionTraces,
    balance_traces,
    motion_traces,
    stuck_slips,
)
from stribeck.report.contents.schema import OF_A_FIT
from stribeck.report.figures.drawing import draw_views
from stribeck.report.figures.fit_figures import draw_fit, fit_figures
from stribeck.report.figures.printed_motions import MOST, many_plot, slips_plot
from stribeck.report.figures.style import STYLE
from stribeck.report.format import abbreviated, with_error
from stribeck.rig.twin import TestBed


@pytest.fixture(scope="module")
def fit() -> Fit:
    log = TestBed().run("up", seed=2).recording
    return identify(log, rig="slide-bed", train="112:295", holdout="44:112", budget=600, repeats=1)


@pytest.fixture(scope="module")
def figures_by_name(fit: Fit) -> dict[str, Figure]:
    return figures(fit)


def figures(fit: Fit) -> dict[str, Figure]:
    return fit_figures(Contents(fit))


def draw(fit: Fit, folder: Path) -> list[Path]:
    return draw_fit(Contents(fit), folder)


def line(figure: Figure, axes: int, label: str) -> tuple[Any, Any]:
    """The data of the line with a label."""
    (curve,) = [a for a in figure.axes[axes].get_lines() if a.get_label() == label]
    return np.asarray(curve.get_xdata()), np.asarray(curve.get_ydata())


def legend(figure: Figure) -> list[str]:
    (legend_,) = figure.legends
    return [text.get_text() for text in legend_.get_texts()]


def text_extents(figure: Figure) -> list[Any]:
    """Extents of all texts of a figure but the tick labels, in pixels."""
    figure.canvas.draw()  # positions are final only once drawn
    renderer = figure.canvas.get_renderer()  # type: ignore[attr-defined]
    texts = [t for part in figure.legends for t in part.get_texts()] + list(figure.texts)
    for axes in figure.axes:
        texts += [axes.xaxis.label, axes.yaxis.label, *axes.texts]
        texts += [child for child in axes.get_children() if isinstance(child, Text)]
    visible = {id(t): t for t in texts if t.get_visible() and t.get_text()}
    return [t.get_window_extent(renderer) for t in visible.values()]


def test_local_quadratics_are_those_of_savitzky_and_golay() -> None:
    x = np.random.default_rng(0).standard_normal(200)
    inner = slice(4, -4)
    for order, derivative in enumerate(local_quadratics(x, 9, 0.02)):
        expected = savgol_filter(x, 9, 2, deriv=order, delta=0.02)[inner]
        np.testing.assert_allclose(derivative, expected, rtol=1e-9, atol=1e-9)


def test_a_fit_is_drawn_under_names_that_are_known(fit: Fit, tmp_path: Path) -> None:
    files = draw(fit, tmp_path)
    stems = {"convergence", "training", "holdout_44_112", "friction", "stribeck_curve", "slips"}
    assert {file.stem for file in files} == stems
    assert all(OF_A_FIT.fullmatch(file.name) for file in files)
    assert all(file.stat().st_size > 5000 for file in files)
    # The law is drawn up to the speed of the slips, some tens of mm/s.
    assert reach(fit) == pytest.approx(0.07, rel=0.5)


def test_the_same_fit_has_the_same_drawings(tmp_path: Path) -> None:
    log = TestBed().run("up", seed=2).recording
    fit = identify(log, rig="slide-bed", train="112:295", budget=60, repeats=1)
    first, second = (tmp_path / name for name in ("a", "b"))
    first.mkdir()
    second.mkdir()
    for drawing, repetition in zip(draw(fit, first), draw(fit, second), strict=True):
        assert drawing.read_bytes() == repetition.read_bytes()


def test_a_motion_is_drawn_as_it_was_measured_and_modelled(
    fit: Fit, figures_by_name: dict[str, Figure]
) -> None:
    figure, (stretch,) = figures_by_name["training"], fit.train
    (motion,) = simulated(fit.parameters, fit.p, fit.train)
    t, x = line(figure, 0, "measured")
    np.testing.assert_array_equal(t, stretch.track.t)
    np.testing.assert_allclose(x, stretch.track.measured * 1e3)
    t, x = line(figure, 0, "model")
    np.testing.assert_allclose(x, np.interp(t, stretch.track.t, motion.position[0] * 1e3))
    t, command = line(figure, 0, "command")
    np.testing.assert_allclose(np.diff(command) / np.diff(t), 5.0, rtol=1e-6)  # mm/s, the ramp
    labels = [axes.get_ylabel() for axes in figure.axes]
    assert labels == ["Displacement / mm", "Residual / mm", "Motor force / N"]
    assert figure.axes[0].get_title("left") == "Training: rightward, 112 to 295 mm"
    assert figure.axes[1].get_title("left") == f"RMS {fit.score.value:.3g} mm"
    assert legend(figure) == ["command", "measured", "model", "not scored"]


def test_slips_are_drawn_large_from_rest_to_rest(
    fit: Fit, figures_by_name: dict[str, Figure]
) -> None:
    figure = figures_by_name["slips"]
    titles = [axes.get_title("left") for axes in figure.axes]
    starts = [fit.recordings[0].t[s.start] for s in stuck_slips(fit.recordings[0])]
    assert titles
    assert {f"at {t:.4g} s" for t in starts} >= set(titles)
    for k in range(len(titles)):
        t, x = line(figure, k, "measured")
        before, after = x[t < 0], x[t > 0.7 * t[-1]]
        # The axis rests on both sides (0.3 mm of noise) and goes some twenty mm between.
        assert before.std() < 0.6 > after.std()
        assert abs(after.mean() - before.mean()) > 10
        low, high = figure.axes[k].get_ylim()
        assert low < x.min() < x.max() < high


def test_free_swings_are_no_slips() -> None:
    log = TestBed().run("up", seed=2).recording
    t = log.t
    swing = replace(log, position=0.05 * np.sin(3.0 * t), command=np.zeros(len(t)))
    assert len(stuck_slips(log)) > 4
    assert stuck_slips(swing) == []


def test_the_curve_names_the_levels_that_were_found(
    fit: Fit, figures_by_name: dict[str, Figure]
) -> None:
    axes = figures_by_name["stribeck_curve"].axes[0]
    labels = [text.get_text() for text in axes.texts]
    F_S, F_C = fit.values["F_S"], fit.values["F_C"]
    assert f"$F_{{S+}}$ = {F_S:.4g} N" in labels
    assert f"$F_{{S-}}$ = {-F_S:.4g} N" in labels
    assert labels.count(f"$F_C$ = {F_C:.4g} N, slope $F_V$") == 2
    v, F = line(figures_by_name["stribeck_curve"], 0, "law: stribeck")
    p = fit.values
    slip = F_C + (F_S - F_C) * np.exp(-v * 1e-3 / p["v_SS"]) + p["F_V"] * v * 1e-3
    np.testing.assert_allclose(F, slip, rtol=1e-9)


@pytest.mark.parametrize("name", ["training", "holdout_44_112", "convergence", "friction", "slips"])
def test_no_text_lies_on_another(
    figures_by_name: dict[str, Figure], name: str, tmp_path: Path
) -> None:
    from stribeck.report.figures.style import save  # noqa: PLC0415 - it gives the figure its canvas

    with mpl.rc_context(STYLE):
        save(figures_by_name[name], tmp_path, name)
        extents = text_extents(figures_by_name[name])
    overlapping = [(a, b) for k, a in enumerate(extents) for b in extents[:k] if a.overlaps(b)]
    assert overlapping == []
    width, height = figures_by_name[name].get_size_inches() * figures_by_name[name].dpi
    assert all(b.x0 >= 0 and b.y0 >= 0 and b.x1 <= width and b.y1 <= height for b in extents)


def trace(error: float, label: str = "log") -> MotionTraces:
    log = TestBed().run("up", seed=2).recording
    t = np.linspace(0.0, 6.0, 2000)
    x = 100 * np.sin(t)
    counts = np.ones(len(t), dtype=bool)
    return MotionTraces(label, log, t, x, x - error, counts, 3 * x)


def figure_of_motions(motions: list[MotionTraces], fit: Fit, title: str) -> Figure:
    records = [Contents(fit).printed_motion("training", r) for r in motions]
    return draw_views(many_plot(records, title, "Angle / mrad", "mrad"), 4)


def test_many_motions_share_a_figure_and_a_scale_of_errors(fit: Fit) -> None:
    errors = [3.0, -1.0, 5.0, 2.0, 0.5]
    figure = figure_of_motions([trace(e, f"log {e}") for e in errors], fit, "Training")
    panels, strips = figure.axes[::2], figure.axes[1::2]
    assert [a.get_title("left") for a in panels] == [f"log {e}" for e in errors]
    assert [a.get_title("right") for a in panels] == [f"RMS {abs(e):.3g}" for e in errors]
    assert len({a.get_ylim() for a in strips}) == 1
    assert strips[0].get_ylim()[1] > 5.0
    for a, e in zip(strips, errors, strict=True):
        np.testing.assert_allclose(np.asarray(a.get_lines()[0].get_ydata()), e)


def test_of_very_many_motions_the_worst_are_drawn_and_all_are_counted(fit: Fit) -> None:
    errors = np.arange(1.0, 41.0)
    figure = figure_of_motions([trace(e, f"{e:.0f}") for e in errors], fit, "Held out")
    shown = [a.get_title("left") for a in figure.axes[::2]]
    assert shown == [f"{e:.0f}" for e in errors[-MOST:]]
    assert f"the {MOST} of 40 with the greatest errors" in figure.texts[0].get_text()


def test_legs_between_rests_are_one_motion_with_gaps() -> None:
    log = TestBed().run("up", seed=2).recording
    fit = identify(log, rig="slide-bed", train="112:295", budget=200, repeats=1, restart=True)
    assert len(fit.train) > 3
    (joined,) = motion_traces(fit, fit.train, simulated(fit.parameters, fit.p, fit.train))
    assert np.isnan(joined.t).sum() == len(fit.train)
    assert joined.scored.sum() == fit.score.samples
    assert joined.rms == pytest.approx(fit.score.value, rel=1e-9)
    assert "training" in figures(fit)


def test_too_few_slips_have_no_figure(fit: Fit) -> None:
    traces = motion_traces(fit, fit.train, simulated(fit.parameters, fit.p, fit.train))
    cut = traces[0].t < stuck_time(fit, 2)
    first = replace(
        traces[0], t=traces[0].t[cut], measured=traces[0].measured[cut], model=traces[0].model[cut],
        scored=traces[0].scored[cut],
    )  # fmt: skip
    assert slips_plot(Contents(fit).frame, [first]) is None


def stuck_time(fit: Fit, k: int) -> float:
    """The start time of the k-th slip of the training data, s."""
    log, t0 = fit.recordings[0], float(fit.train[0].track.t[0])
    starts = [float(log.t[s.start]) for s in stuck_slips(log)]
    return [t for t in starts if t > t0][k]


def test_a_thinned_line_keeps_its_peaks_its_gaps_and_its_ends() -> None:
    t = np.arange(100_000) / 1000
    y = np.sin(t)
    y[54_321], y[70_000] = 9.0, np.nan
    rows = corners([y], 605)
    times, values = t[rows], y[rows]
    assert len(times) <= 606  # and the gap
    assert values[times == 54.321] == 9.0
    assert np.isnan(values[times == 70.0]).all()
    assert (times[0], times[-1]) == (t[0], t[-1])
    assert np.interp(times[:100], t, y) == pytest.approx(values[:100])


def test_a_long_name_loses_its_middle() -> None:
    assert abbreviated("short.csv", 20) == "short.csv"
    assert abbreviated("a-very-long-name-of-a-recording.csv", 15) == "a-very-…ing.csv"


@pytest.mark.parametrize(
    ("value", "error", "text"),
    [
        (10.0004, 0.0121, "10.000 ± 0.012"),
        (59.83, 0.1996, "59.83 ± 0.20"),
        (2.9999, 0.0996, "3.00 ± 0.10"),
        (1234.5, 56.0, "1234 ± 56"),
        (203456.0, 1146.0, "2.035e+05 ± 1.1e+03"),
        (1.2345e-7, 3e-9, "1.235e-07 ± 3e-09"),
        (5.0, 0.0, "5 ± 0"),
    ],
)
def test_a_value_has_the_digits_of_its_error(value: float, error: float, text: str) -> None:
    assert with_error(value, error) == text


def test_rows_of_a_balance_are_apart_where_others_do_not_count() -> None:
    t = np.concatenate([np.arange(0.0, 10.0, 0.1), np.arange(30.0, 40.0, 0.1)])
    log = Recording(t, np.sin(t), force=np.cos(t))
    signals = Signals(t, np.cos(t), np.sin(t), np.cos(t), np.cos(t), np.cos(t))
    traces = balance_traces(RIGS["forced"], log, signals)
    assert np.flatnonzero(np.isnan(traces.t)).tolist() == [100]
    assert np.isnan(traces.measured[100])
    assert not traces.scored[100]
    assert traces.rms == 0.0
    assert traces.scored.sum() == 200
