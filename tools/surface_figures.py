"""Pictures of the test surfaces, as in Table 1 of the paper, and of their twins."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
from matplotlib.colors import LightSource, LinearSegmentedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Polygon
from matplotlib.ticker import MaxNLocator

from stribeck.bench.surfaces import SURFACES, Moved, Surface, surface
from stribeck.report.figures.style import ACCENT, INK, MEASURED, MODEL, STYLE, save

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from stribeck.space import Array

#: Low is dark; marks in MODEL's colour stand out on all of it.
_DEPTH = LinearSegmentedColormap.from_list("depth", ["#0b1f4b", ACCENT, "#8fb4f0", "#f3f6fa"])
_PALE = LinearSegmentedColormap.from_list("pale", ["#6f7fa6", "#86a5ee", "#c3d6f7", "#f8fafc"])
_ABOVE_RANGE = "#e6ddd1"  # above all values that the surface itself has
_POINTS = 161  # along an edge: eight a wave of Shubert's fastest
_LIGHT = LightSource(azdeg=315, altdeg=50)


def draw_surfaces(folder: Path) -> list[Path]:
    """Draw the five surfaces of Table 1, each and all on a sheet, as PNG and SVG.

    Returns:
        The files: `surface_NAME` for each and `surfaces`, the sheet.
    """
    folder.mkdir(parents=True, exist_ok=True)
    with mpl.rc_context(STYLE):
        figures = {f"surface_{name}": relief(s) for name, s in SURFACES.items()}
        figures["surfaces"] = sheet()
        return [file for name, figure in figures.items() for file in save(figure, folder, name)]


def draw_twins(seed: int, folder: Path) -> list[Path]:
    """Draw each surface above its twin of a seed, on one sheet, as PNG and SVG.

    Returns:
        The files, `twins_SEED`.
    """
    folder.mkdir(parents=True, exist_ok=True)
    with mpl.rc_context(STYLE):
        return save(twins(seed), folder, f"twins_{seed}")


def relief(s: Surface) -> Figure:
    """A surface of two variables in 3-D, over its map."""
    figure = Figure(figsize=(7.2, 6.0), dpi=160)
    axes: Any = figure.add_axes((-0.02, 0.03, 0.98, 0.91), projection="3d")
    _relief(s, axes)
    axes.set_zlabel("Cost", labelpad=8)
    figure.text(0.04, 0.955, f"{s.title} surface ({s.name})", size=14, weight="bold", color=INK)
    figure.text(0.04, 0.915, _answer(s), size=10, color=MODEL)
    return figure


def sheet() -> Figure:
    """The five surfaces on one sheet, with their rows of Table 1."""
    figure = Figure(figsize=(13.0, 8.6), dpi=160)
    for k, s in enumerate(SURFACES.values()):
        left, bottom = 0.005 + k % 3 / 3, 0.51 - k // 3 * 0.49
        axes: Any = figure.add_axes((left, bottom, 0.305, 0.42), projection="3d")
        _relief(s, axes, ticks=3)
        figure.text(left + 0.02, bottom + 0.44, f"{s.title} ({s.name})", size=13, weight="bold")
        figure.text(left + 0.02, bottom + 0.415, _answer(s), size=9, color=MODEL)
    _facts(figure)
    return figure


def twins(seed: int) -> Figure:
    """The five surfaces as maps, above their twins of a seed."""
    figure = Figure(figsize=(16.0, 7.8), dpi=160, layout="constrained")
    figure.suptitle(
        f"The five surfaces and, below, their twins of seed {seed}: shifted and rotated",
        x=0.008, y=0.99, ha="left", size=14, weight="bold", color=INK,
    )  # fmt: skip
    grid = figure.subplots(2, len(SURFACES))
    for (above, below), original in zip(grid.T, SURFACES.values(), strict=True):
        _map(original, original, above)
        filled = _map(surface(original.name, twin=seed), original, below)
        bar = figure.colorbar(
            filled, ax=[above, below], location="bottom", aspect=28, shrink=0.85, pad=0.03
        )
        bar.set_ticks(_ticks(original))
        bar.set_label("Cost")
    figure.text(
        0.992, 0.985, "orange: where it is least   ·   dashed: wall of the surface's own box"
        "   ·   sand: above all values of the surface",
        ha="right", va="top", size=10, color=MODEL,
    )  # fmt: skip
    return figure


def _relief(s: Surface, axes: Any, ticks: int = 5) -> None:
    x, y, cost = _grid(s)
    low, high = float(cost.min()), float(cost.max())
    floor = low - 0.6 * (high - low)
    lit = _LIGHT.shade(cost, _DEPTH, vert_exag=0.6 * s.half / (high - low), blend_mode="soft")
    axes.computed_zorder = False  # the map lies under the relief, and its marks on the map
    filled = axes.contourf(x, y, cost, 14, zdir="z", offset=floor, cmap=_PALE, antialiased=False)
    filled.set(rasterized=True, zorder=1)
    axes.plot(*s.optima.T, np.full(len(s.optima), floor), "o", color=MODEL, ms=4.5, mec="white",
              mew=0.6, zorder=2)  # fmt: skip
    axes.plot_surface(x, y, cost, facecolors=lit, rcount=_POINTS, ccount=_POINTS, linewidth=0,
                      antialiased=False, rasterized=True, zorder=3)  # fmt: skip
    axes.set(xlabel="$x_1$", ylabel="$x_2$", zlim=(floor, high))
    axes.set_xticks(np.linspace(-s.half, s.half, ticks))
    axes.set_yticks(np.linspace(-s.half, s.half, ticks))
    axes.set_zticks([t for t in _ticks(s) if t <= high])
    axes.view_init(elev=24, azim=-58)
    axes.set_box_aspect((1, 1, 0.85), zoom=1.02)
    for axis in (axes.xaxis, axes.yaxis, axes.zaxis):
        axis.set_pane_color((1, 1, 1, 0))
        axis.line.set_color(MEASURED)
    axes.tick_params(labelsize=9, pad=1)


def _map(s: Surface, original: Surface, axes: Axes) -> Any:
    """A surface or a twin as a contour map, in the colours of the surface's own values."""
    x, y, cost = _grid(s)
    shades = Normalize(original.minimum, original.ceiling)
    levels = np.linspace(original.minimum, original.ceiling, 15)
    levels[0] -= 1e-9 * original.ceiling  # rounding must not leave a hole where it is least
    filled = axes.contourf(
        x, y, cost, levels, cmap=_DEPTH.with_extremes(over=_ABOVE_RANGE), norm=shades, extend="max"
    )
    filled.set(rasterized=True)
    if isinstance(s.function, Moved):
        corners = original.half * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
        wall = s.function.images(corners)
        axes.add_patch(Polygon(wall, fill=False, ls="--", lw=1.2, ec=INK))
    axes.plot(*s.optima.T, "o", color=MODEL, ms=6, mec="white", mew=0.9)
    axes.set(xlim=(-s.half, s.half), ylim=(-s.half, s.half), aspect="equal")
    axes.set(xlabel="$x_1$", ylabel="$x_2$", title=s.title)
    axes.set_xticks(np.linspace(-s.half, s.half, 5))
    axes.set_yticks(np.linspace(-s.half, s.half, 5))
    axes.grid(visible=False)
    return filled


def _facts(figure: Figure) -> None:
    """Table 1 in the sixth place of the sheet."""
    left, top, line = 0.69, 0.40, 0.042
    figure.text(left, top, "Table 1", size=13, weight="bold", color=INK)
    columns = (0.0, 0.062, 0.125, 0.205)
    for k, row in enumerate([("", "Box", "J_min", "Least value"), *map(_row, SURFACES.values())]):
        for shift, word in zip(columns, row, strict=True):
            weight = "bold" if not shift or not k else "normal"
            text = word.replace("J_min", "$J_{min}$")
            figure.text(left + shift, top - (k + 1.3) * line, text, size=11, weight=weight)
    figure.text(left, top - 7.5 * line, "Orange: where the surface is least.", size=10, color=MODEL)


def _row(s: Surface) -> tuple[str, ...]:
    return s.name, f"±{s.half:g}", _number(s.J_min), _number(s.minimum)


def _answer(s: Surface) -> str:
    """The least value and its place."""
    if len(s.optima) > 1:
        return f"Least value {_number(s.minimum)} at {len(s.optima)} places"
    place = ", ".join(_number(float(c)) for c in s.optima[0])
    return f"Least value {_number(s.minimum)} at ({place})"


def _number(value: float) -> str:
    return f"{value:.7g}".replace("-", "−") if abs(value) >= 1e-3 else _small(value)  # noqa: PLR2004


def _small(value: float) -> str:
    """Powers of ten as such."""
    if value == 0:
        return "0"
    digits, power = f"{value:.4e}".split("e")
    raised = f"10^{{{int(power)}}}"
    front = digits.rstrip("0").rstrip(".")
    return f"${raised}$" if front == "1" else f"${front} \\times {raised}$"


def _ticks(s: Surface) -> list[float]:
    """Round numbers on the way from the least to the greatest value."""
    ticks = MaxNLocator(4).tick_values(s.minimum, s.ceiling)
    return [float(t) for t in ticks if s.minimum - 0.02 * s.ceiling <= t <= s.ceiling]


def _grid(s: Surface) -> tuple[Array, Array, Array]:
    edge = np.linspace(-s.half, s.half, _POINTS)
    x, y = np.meshgrid(edge, edge)
    cost = s(np.stack([x.ravel(), y.ravel()], axis=1)).reshape(x.shape)
    return x, y, cost
