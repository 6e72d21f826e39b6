"""How every figure of the project looks, and how it becomes files."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pathlib import Path

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


INK, MEASURED, MODEL, COMMAND, ACCENT = "#1b1f24", "#7a8794", "#c2410c", "#b8c0c8", "#1d4ed8"
#: Lines of their own, such as the repeats of a search.
REPEATS = ("#c2410c", "#1d4ed8", "#0f766e", "#7c3aed", "#b45309", "#475569")
#: What lines are drawn in, by role: on a light page and in print, and on a dark page.
COLOURS: dict[str, tuple[str, str]] = {
    "ink": (INK, "#e6eaee"),
    "measured": (MEASURED, "#93a1af"),
    "model": (MODEL, "#ff8a4c"),
    "command": (COMMAND, "#64707c"),
    "accent": (ACCENT, "#8ab4ff"),
    **{
        f"repeat{k}": pair
        for k, pair in enumerate(
            zip(
                REPEATS,
                ("#ff8a4c", "#8ab4ff", "#2dd4bf", "#b794ff", "#fbbf24", "#a3b1bf"),
                strict=True,
            )
        )
    },
}
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


def legend_above(figure: Figure, axes: Axes, columns: int | None = None) -> None:
    """The legend of a diagram above all, where no data are: in a line, or in so many columns."""
    handles, labels = axes.get_legend_handles_labels()
    named = dict(zip(labels, handles, strict=True))
    figure.legend(
        named.values(), named, loc="outside upper right", ncols=columns or len(named), fontsize=9,
        markerscale=2.5, columnspacing=1.6, handlelength=1.6,
    )  # fmt: skip
