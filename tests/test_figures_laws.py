"""The figure of a law: loops of laws with states, friction budgets of laws under load."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from stribeck import identify
from stribeck.data import Recording
from stribeck.friction import law_named
from stribeck.identify.result import Fit
from stribeck.report.contents.gather import Contents
from stribeck.report.contents.law_curve import friction_under, loop
from stribeck.report.figures.fit_figures import fit_figures, law_figure
from stribeck.rig.twin import TestBed

M6 = np.array([0.01, 0.005, 0.02, 1.0, 1.0, 0.2, 0.1, 0.05, 0.03, 0.4, 0.3])


def figure_of_law(fit: Fit) -> Figure:
    return law_figure(Contents(fit))


def test_a_loop_of_coulomb_bristles_is_a_parallelogram() -> None:
    law = law_named("maxwell-slip:1")
    stiff, level = 1e5, 8.0
    p = np.array([{"W_1": level, "d_1": level / stiff, "F_V": 0.0}[q.name] for q in law.params])
    amplitude = 5 * level / stiff
    x, F = loop(law, p, amplitude, 1e-5)
    assert (x.min(), x.max()) == (-amplitude, amplitude)
    assert pytest.approx(level) == F.max()
    assert pytest.approx(-level) == F.min()
    # A closed loop dissipates its area: 4 W (amplitude - d), from the first turn to the last.
    lap = slice(np.argmax(x), None)
    dissipated = np.trapezoid(F[lap], x[lap])
    assert dissipated == pytest.approx(4 * level * (amplitude - level / stiff), rel=0.02)
    # At first the bristle bends by its stiffness.
    assert F[1] / x[1] == pytest.approx(stiff, rel=1e-6)


@pytest.mark.parametrize(
    ("loading", "size", "expected"),
    [
        # Against each other: t_m = 0.5, t_e = -0.5, as strong: Q = K_mq t_m^2.
        ("both", 0.5, 0.01 + 0.15 + 0.02 + 0.04 + 0.4 * 0.25),
        ("drive", 0.5, 0.01 + 0.1 + 0.02 + 0.025),
        ("external", 0.5, 0.01 + 0.05 + 0.02 + 0.015),
        ("both", 0.0, 0.03),
    ],
)
def test_a_level_at_rest_under_load_by_hand(loading: str, size: float, expected: float) -> None:
    assert friction_under(law_named("bam-m6"), M6, 0.0, loading, size) == pytest.approx(
        expected, rel=1e-12
    )


def test_a_speed_takes_the_slow_part_away() -> None:
    law = law_named("bam-m6")
    assert friction_under(law, M6, 40.0, "drive", 0.5) == pytest.approx(
        0.01 + 0.1 + 0.005 * 40, rel=1e-12
    )


@pytest.fixture(scope="module")
def presliding_fit() -> Fit:
    """A fit to a presliding log: a Dahl bristle under a sine of torque."""
    t = np.arange(0.0, 6.0, 0.015)
    torque = 4.0 * np.sin(np.pi * t)
    x = torque / 2e4 + 1e-6 * np.sin(40 * t)
    log = Recording(t, x, force=torque, rotary=True)
    return identify(log, rig="presliding-rotary", law="dahl", budget=120, repeats=1)


def test_presliding_is_drawn_as_loops_of_torque_and_angle(presliding_fit: Fit) -> None:
    figures = fit_figures(Contents(presliding_fit))
    assert set(figures) == {"convergence", "training", "loops", "stribeck_curve"}
    (axes,) = figures["loops"].axes
    measured, model = axes.get_lines()
    log = presliding_fit.recordings[0]
    assert log.force is not None
    np.testing.assert_allclose(np.asarray(measured.get_xdata()), log.position * 1e3)  # mrad
    np.testing.assert_array_equal(measured.get_ydata(), log.force)
    np.testing.assert_array_equal(model.get_ydata(), log.force)
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("Angle / mrad", "Applied torque / N m")
    # The model is drawn at measured less residual: positions are known up to a constant.
    residuals = (np.asarray(measured.get_xdata()) - np.asarray(model.get_xdata()))[
        presliding_fit.train[0].track.score > 0
    ]
    assert np.sqrt(np.mean(residuals**2)) == pytest.approx(presliding_fit.score.value, rel=1e-9)
    assert [a.get_ylabel() for a in figures["training"].axes] == [
        "Angle / mrad", "Residual / mrad", "Applied torque / N m",
    ]  # fmt: skip


def test_a_law_with_states_has_its_steady_curve_and_its_loops(presliding_fit: Fit) -> None:
    left, right = figure_of_law(presliding_fit).axes
    v = np.asarray(left.get_lines()[0].get_xdata()) * 1e-3
    F = np.asarray(left.get_lines()[0].get_ydata())
    p = presliding_fit.p[: len(presliding_fit.law.params)]
    np.testing.assert_allclose(F, presliding_fit.law.friction(v, p))
    wide, narrow = (np.ptp(np.asarray(loop.get_xdata())) for loop in right.get_lines()[:2])
    assert wide == pytest.approx(np.ptp(presliding_fit.recordings[0].position) * 1e3, rel=1e-6)
    assert narrow == pytest.approx(0.35 * wide)
    assert right.get_xlabel() == "Angle / mrad"


@pytest.fixture(scope="module")
def pendulum_fit() -> Fit:
    """A servo pendulum that holds still: enough to draw its law."""
    t = np.arange(0.0, 2.0, 0.01)
    log = Recording(
        t, 0.3 * (1 - np.cos(3 * t)), 0.5 * (1 - np.cos(3 * t)), rotary=True,
        extra={"torque_enable": np.ones(len(t))},
    )  # fmt: skip
    return identify(log, rig="servo-pendulum", law="bam-m3", budget=60, repeats=1)


def test_a_law_under_load_is_drawn_against_the_load(pendulum_fit: Fit) -> None:
    p = np.array([0.02, 0.004, 0.25])
    fit = replace(pendulum_fit, p=np.concatenate([p, pendulum_fit.p[3:]]))
    left, right = figure_of_law(fit).axes
    most = float(np.asarray(right.get_lines()[0].get_xdata())[-1])
    # K_l |t_m - t_e|: twice the load where the one works against the other.
    resting, moving = (np.asarray(a.get_ydata()) for a in right.get_lines()[:2])
    assert resting[0] == pytest.approx(0.02)
    assert resting[-1] == pytest.approx(0.02 + 0.25 * 2 * most)
    speed = float(np.asarray(left.get_lines()[0].get_xdata())[-1])
    np.testing.assert_allclose(moving - resting, 0.004 * speed)
    curves = [np.asarray(a.get_ydata()) for a in left.get_lines()]
    assert [c[0] for c in curves] == pytest.approx([0.02, 0.02 + 0.25 * most, 0.02 + 0.5 * most])
    labels = [a.get_label() for a in right.get_lines()]
    # Motor alone and load alone are one line for this law, and have one name.
    assert labels[0] == "motor against load, at rest"
    assert labels[2] == "motor or load alone, at rest"
    assert len(labels) == 4
    assert right.get_xlabel() == "Torque / N m"


@pytest.mark.parametrize("levels", [(0.5, 0.2), (0.5, 0.0), (0.5, 0.49), (0.02, 0.01)])
def test_names_of_levels_do_not_lie_on_one_another(levels: tuple[float, float]) -> None:
    log = TestBed().run("up", seed=2).recording
    fit = identify(log, rig="slide-bed", train="112:295", budget=40, repeats=1)
    F_S, F_C = levels
    p = {"F_S": F_S, "F_C": F_C, "F_V": 100.0, "v_SS": 1e-3, "exponent": 1.0}
    drawn = replace(fit, p=np.array([p.get(n, 900.0) for n in fit.values]))
    figure = figure_of_law(drawn)
    FigureCanvasAgg(figure).draw()  # type: ignore[no-untyped-call]
    boxes = [text.get_window_extent() for text in figure.axes[0].texts]
    assert len(boxes) == 4
    assert not [1 for k, a in enumerate(boxes) for b in boxes[:k] if a.overlaps(b)]
