"""The figures of a fit: what an engineer puts into a talk."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import matplotlib as mpl

from ...errors import InputError
from ..contents.decimation import PRINT
from ..contents.frame import Frame
from ..contents.gather import Contents
from ..contents.schema import MotionRecord
from ..folder import write_files
from .drawing import draw, draw_row, draw_views
from .law_plots import (
    curve_plot,
    levels_plot,
    load_curves_plot,
    loads_plot,
    loops_plot,
    near_rest,
)
from .motion_plots import APART, quantity_label, residual_unit
from .printed_motions import applied_loops_plot, many_plot, motion_plot, slips_plot
from .search_plots import convergence_plot
from .style import STYLE, save

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from matplotlib.figure import Figure

    from ...identify.result import Fit


def write_figures(contents: Contents, folder: Path) -> None:
    """Draw a fit's figures into a folder, all or none.

    Raises:
        InputError: the disk refuses.
    """
    write_files(folder, lambda place: draw_fit(contents, place))


def draw_fit(contents: Contents, folder: Path) -> list[Path]:
    """Draw every figure that a fit has, as PNG and SVG, and return the files."""
    with mpl.rc_context(STYLE):
        drawers = _drawers(contents)
        return [file for name, draws in drawers.items() for file in save(draws(), folder, name)]


def fit_figure(fit: Fit, kind: str) -> Figure:
    """One figure of a fit, by the name of its files.

    Raises:
        InputError: the fit has no such figure.
    """
    with mpl.rc_context(STYLE):
        drawers = _drawers(Contents(fit))
        if kind not in drawers:
            raise InputError(f"no figure {kind!r} of this fit: there are {', '.join(drawers)}")
        return drawers[kind]()


def fit_figures(contents: Contents) -> dict[str, Figure]:
    """Every figure that a fit has, by the name of its files."""
    with mpl.rc_context(STYLE):
        return {name: draws() for name, draws in _drawers(contents).items()}


def _drawers(contents: Contents) -> dict[str, Callable[[], Figure]]:
    """What draws each figure that a fit has, by the name of its files."""
    balanced = contents.frame.road == "inverse"
    figures = _balance(contents) if balanced else _simulation(contents)
    return figures | {"stribeck_curve": partial(law_figure, contents)}


def _simulation(contents: Contents) -> dict[str, Callable[[], Figure]]:
    fit, frame = contents.fit, contents.frame
    figures: dict[str, Callable[[], Figure]] = {}
    runs, smooth = contents.runs(), fit.score.baselines().get("smooth")
    convergence = convergence_plot(runs, fit.score.unit, smooth, printed=True)
    if convergence is not None:
        title = f"Convergence of {fit.search.method}"
        polished = any(run.polishing for run in runs)
        x = f"Evaluations of J; dot: {'after polishing' if polished else 'where it ended'}"
        figures["convergence"] = partial(draw, replace(convergence, title=title, x=x, height=400))
    for part, traces in contents.motions:
        records = [contents.printed_motion(part, r) for r in traces]
        name, heading = "training", "Training"
        if part != "training":
            name, heading = f"holdout_{part.replace(':', '_')}", "Held out"
        figures |= _motions(frame, records, name, heading)
    (_, training), *_ = contents.motions
    if fit.rig.applied_force:
        loops = applied_loops_plot(
            frame, [contents.printed_motion("training", r) for r in training]
        )
        figures["loops"] = (
            partial(draw, loops) if len(loops.views) == 1 else partial(draw_views, loops, 3)
        )
    elif (slips := slips_plot(frame, training)) is not None:
        figures["slips"] = partial(draw_views, slips, 3)
    if contents.cloud is not None:
        law = contents.law(PRINT)
        figures["friction"] = partial(draw, curve_plot(frame, law, "Friction against velocity"))
    return figures


def _motions(
    frame: Frame, records: list[MotionRecord], name: str, heading: str
) -> dict[str, Callable[[], Figure]]:
    """Few motions a figure each, many in one."""
    if len(records) > APART:
        return {name: partial(_many, frame, records, f"{heading}: {len(records)} motions")}
    return {
        name if len(records) == 1 else f"{name}_{k}": partial(
            draw, motion_plot(frame, m, f"{heading}: {m.label}")
        )
        for k, m in enumerate(records, 1)
    }


def _many(frame: Frame, records: list[MotionRecord], title: str) -> Figure:
    plot = many_plot(records, title, quantity_label(frame), residual_unit(frame))
    return draw_views(plot, 4 if len(plot.views) > 6 else 3)  # noqa: PLR2004 - a matter of taste


def _balance(contents: Contents) -> dict[str, Callable[[], Figure]]:
    """The figures of a force balance: force and residual in time, and friction against speed."""
    balance, frame = contents.fit.balance, contents.frame
    assert balance is not None  # noqa: S101 - drawn for such fits only
    error = f"elative error {balance.relative_error:.4g} %"
    (_, training), *_ = contents.motions
    records = [contents.printed_motion("training", r) for r in training]
    if len(records) > APART:
        title = f"Force balance: {len(records)} logs, r{error}"
        figures: dict[str, Callable[[], Figure]] = {"force": partial(_many, frame, records, title)}
    else:
        figures = {
            "force" if len(records) == 1 else f"force_{k}": partial(
                draw, motion_plot(frame, m, f"Force balance: {m.label}", f"R{error}")
            )
            for k, m in enumerate(records, 1)
        }
    law = contents.law(PRINT)
    curve = curve_plot(frame, law, "Friction against velocity")
    return {**figures, "friction": partial(draw, curve)}


def law_figure(contents: Contents) -> Figure:
    """The figure that suits a law: with states, under load, or a curve with its levels."""
    fit, frame = contents.fit, contents.frame
    if fit.law.states:
        law = contents.law(PRINT, (-contents.fast, contents.fast))
        steady = curve_plot(frame, law, "Steady sliding", cloud=False)
        loops = loops_plot(frame, law)
        pace = f"{law.pace:.2g} {frame.units.position}/s"
        plots = [steady, replace(loops, title=f"Slow strokes, {pace}")]
        return draw_row(f"{fit.law.name}: the identified law", plots)
    if any(load in ("drive", "external", "normal") for load in fit.law.loads):
        law = contents.law(PRINT)
        curves = load_curves_plot(fit, frame, contents.fast)
        loads = replace(loads_plot(frame, law), title="Level against load")
        return draw_row(f"{fit.law.name}: friction under load", [curves, loads], share_y=True)
    far = near_rest(fit, contents.fast)
    return draw(levels_plot(fit, frame, contents.law(PRINT, (-far, far))))
