"""How every figure of the project looks, and how it becomes files."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

if TYPE_CHECKING:
    from pathlib import Path

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ...rig import Rig
    from ...space import Array

INK, MEASURED, MODEL, COMMAND, ACCENT = "#1b1f24", "#7a8794", "#c2410c", "#b8c0c8", "#1d4ed8"
#: Lines of their own, such as the repeats of a search.
REPEATS = ("#c2410c", "#1d4ed8", "#0f766e", "#7c3aed", "#b45309", "#475569")
#: Dots per inch of a PNG, and of the clouds of points in an SVG.
DPI, RASTER_DPI = 160, 100
STYLE: Any = {
    "font.size": 10,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": INK,
    "axes.labelcolor": INK,
    "axes.titlesize": 11,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.grid": True,
    "grid.color": "#e5e9ed",
    "grid.linewidth": 0.7,
    "xtick.color": INK,
    "ytick.color": INK,
    "legend.frameon": False,
    "lines.linewidth": 1.5,
    "svg.hashsalt": "stribeck",  # the same figure has the same bytes
    "svg.fonttype": "none",
}


def save(figure: Figure, folder: Path, name: str) -> list[Path]:
    """Write a figure as PNG and SVG."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: PLC0415 - pages need none

    figure.set_dpi(DPI)
    FigureCanvasAgg(figure)
    if (layout := figure.get_layout_engine()) is not None:
        layout.execute(figure)
        figure.set_layout_engine(None)  # else each file would be laid out, and drawn twice for it
        for axes in figure.axes:  # nor is there anything left for a title to evade
            if (title := axes.get_title("left")) and not axes.yaxis.get_offset_text().get_text():
                axes.set_title(title, loc="left", y=1.0)
    files = [folder / f"{name}.png", folder / f"{name}.svg"]
    figure.savefig(files[0], dpi=DPI, metadata={"Software": None})
    figure.savefig(files[1], dpi=RASTER_DPI, metadata={"Date": None, "Creator": None})
    return files


def one(width: float, height: float) -> tuple[Figure, Axes]:
    """A figure of one diagram, in inches."""
    from matplotlib.figure import Figure  # noqa: PLC0415 - as above

    figure = Figure(figsize=(width, height), layout="constrained")
    return figure, figure.subplots()


def legend_above(figure: Figure, axes: Axes) -> None:
    """The legend of a diagram in a line above all, where no data are."""
    handles, labels = axes.get_legend_handles_labels()
    named = dict(zip(labels, handles, strict=True))
    figure.legend(
        named.values(), named, loc="outside upper right", ncols=len(named), fontsize=9,
        markerscale=2.5, columnspacing=1.6, handlelength=1.6,
    )  # fmt: skip


def shown(rig: Rig, quantity: Literal["position", "velocity"]) -> str:
    """The unit in which a rig's figures have a position or a velocity."""
    return rig.unit_shown(quantity)


def force_unit(rig: Rig) -> str:
    """The unit of its forces or torques."""
    return "N m" if rig.rotary else "N"


def written(name: str) -> str:
    """A unit as a label has it."""
    return (
        name.replace("urad", "µrad")
        .replace("um", "µm")
        .replace("mm/s", "mm s⁻¹")
        .replace("**2", "²")
    )


def short(text: str, most: int) -> str:
    """A name of at most so many letters; what is left out is its middle."""
    if len(text) <= most:
        return text
    head = (most - 1) // 2
    return f"{text[:head]}…{text[len(text) - (most - 1 - head) :]}"


def thinned(t: Array, y: Array, bins: int) -> tuple[Array, Array]:
    """A long line by the least and greatest point of each of so many spans; gaps (nan) stay."""
    if len(t) <= 2 * bins:
        return t, y
    kept = [np.flatnonzero(~np.isfinite(y)), np.array([0, len(t) - 1])]
    edges = np.linspace(0, len(t), bins + 1).astype(int)
    for a, b in itertools.pairwise(edges):
        if (there := np.flatnonzero(np.isfinite(y[a:b]))).size:
            part = y[a:b][there]
            kept.append(a + there[[part.argmin(), part.argmax()]])
    rows = np.unique(np.concatenate(kept))
    return t[rows], y[rows]
