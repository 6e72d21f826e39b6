"""A picture of the package: floors, rooms and the imports between them, read from the code.

`python tools/architecture_figure.py` writes docs/figures/architecture.png and .svg, and prints the
table of docs/architecture.md; the floors test holds that page against the same reading.
"""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.patches import FancyArrowPatch, FancyBboxPatch

from structure import FLOORS, GRAPH, MODULES, ROOMS

FIGURES = Path(__file__).parents[1] / "docs" / "figures"
#: What a package is, in words short enough for its box.
WORDS = {
    "cli": "parse, call, print",
    "studio": "the local page",
    "fleet": "many axes",
    "bench": "campaigns of search methods",
    "report": "tables, figures, the page",
    "export": "code, robot files, FMUs",
    "compensate": "compensator in closed loop",
    "identify": "fit, card, uncertainty, choice, design",
    "rig": "kinds of axis and how they move",
    "friction": "laws",
    "data": "logs",
    "monitoring": "control charts",
    "optimize": "search methods",
}
#: Half the width of the ground floor.
MIDDLE = 6.0
#: The modules of the ground floor, in one box.
GROUND = tuple(name for name, floor in FLOORS.items() if floor == 0)
INK, SOFT, FILL, ARROW = "#1f2933", "#52606d", "#eef3f8", "#7b8794"


def uses() -> dict[tuple[str, str], int]:
    """Counts of the imports from one package to another; the ground floor is `ground`."""
    counts: dict[tuple[str, str], int] = {}
    for name, targets in GRAPH.items():
        package = _box(name)
        for target in targets:
            if (imported := _box(target)) != package and package != "__main__":
                counts[package, imported] = counts.get((package, imported), 0) + 1
    return counts


def _box(name: str) -> str:
    package = name.split(".", maxsplit=1)[0]
    return "ground" if package in GROUND else package


def places() -> dict[str, tuple[float, float, float]]:
    """Left end, bottom and width of each box: floors from the bottom up, side by side on one."""
    rows: dict[int, list[str]] = {}
    for name, floor in FLOORS.items():
        if floor > 0 and name != "__main__":
            rows.setdefault(floor, []).append(name)
    boxes = {"ground": (0.0, 0.0, 12.0)}
    for height, floor in enumerate(sorted(rows), start=1):
        names = rows[floor]
        width = (12.0 - 0.5 * (len(names) - 1)) / len(names) if len(names) > 1 else 7.0
        left = 0.0 if len(names) > 1 else 2.5
        for k, name in enumerate(names):
            boxes[name] = (left + k * (width + 0.5), 1.55 * height, width)
    return boxes


def draw(axes: Axes) -> None:
    """Boxes with their rooms, and an arrow for each pair of packages."""
    boxes = places()
    for name, (left, bottom, width) in boxes.items():
        shape = FancyBboxPatch(
            (left, bottom), width, 1.0, boxstyle="round,pad=0,rounding_size=0.12",
            facecolor=FILL, edgecolor=INK, linewidth=1.0, zorder=3,
        )  # fmt: skip
        axes.add_patch(shape)
        half = (len(GROUND) + 1) // 2  # on two lines: one is wider than the box
        lines = (" · ".join(GROUND[:half]), " · ".join(GROUND[half:]))
        head = "\n".join(lines) if name == "ground" else name
        files = sum(1 for module in MODULES if _box(module) == name)
        words = "" if name == "ground" else f"{WORDS[name]}, {files} files"
        rooms = " | ".join(f"{room}/" for room in ROOMS.get(name, ()))
        middle = left + width / 2
        axes.text(middle, bottom + (0.72 if rooms else 0.64 if words else 0.5), head, ha="center",
                  va="center", weight="bold", color=INK, zorder=4)  # fmt: skip
        axes.text(middle, bottom + (0.44 if rooms else 0.32), words, ha="center", va="center",
                  color=SOFT, size=8, zorder=4)  # fmt: skip
        axes.text(middle, bottom + 0.2, rooms, ha="center", va="center", color=SOFT, size=7.5,
                  zorder=4)  # fmt: skip
    for (package, imported), count in sorted(uses().items()):
        if imported == "ground":
            continue  # everything stands on it
        (left, bottom, width), (o_left, o_bottom, o_width) = boxes[package], boxes[imported]
        distant = round((bottom - o_bottom) / 1.55) > 1
        side = 1 if (o_left + o_width / 2) >= MIDDLE else -1
        start = (left + width / 2 + (side * width * 0.44 if distant else 0.0), bottom)
        end = (o_left + o_width / 2 + (side * o_width * 0.44 if distant else 0.0), o_bottom + 1.0)
        axes.add_patch(FancyArrowPatch(
            start, end, arrowstyle="-|>", mutation_scale=9, color=ARROW,
            alpha=0.35 if distant else 0.9, linewidth=0.6 + 0.05 * min(count, 40),
            shrinkA=0, shrinkB=1,
            connectionstyle=f"arc3,rad={-0.28 * side if distant else 0.0}", zorder=2,
        ))  # fmt: skip
    axes.set_xlim(-0.5, 12.5)
    axes.set_ylim(-0.2, max(bottom for _, bottom, _ in boxes.values()) + 1.2)
    axes.set_aspect("equal")
    axes.axis("off")


def table() -> list[str]:
    """The floors as a Markdown table: floor, package, rooms, and what it imports."""
    rows = ["| floor | package | rooms | imports |", "|---|---|---|---|"]
    counts = uses()
    for name, floor in sorted(FLOORS.items(), key=lambda item: (-item[1], item[0])):
        if name in GROUND or name == "__main__":
            continue
        targets = sorted(imported for package, imported in counts if package == name)
        rooms = ", ".join(f"`{room}`" for room in ROOMS.get(name, ())) or "–"
        imports = ", ".join(f"`{imported}`" for imported in targets if imported != "ground")
        rows.append(f"| {floor} | `{name}` | {rooms} | {imports or '–'} |")
    rows.append(f"| 0 | {', '.join(f'`{name}`' for name in GROUND)} | – | – |")
    return rows


def main() -> None:
    """Draw the picture and print the table."""
    mpl.use("Agg")
    mpl.rcParams["svg.hashsalt"] = "stribeck"
    figure, axes = plt.subplots(figsize=(9.5, 9.0), layout="constrained")
    draw(axes)
    for suffix in ("png", "svg"):
        figure.savefig(FIGURES / f"architecture.{suffix}", dpi=150, metadata=(
            {"Date": None} if suffix == "svg" else {"Software": None}))  # fmt: skip
    print("\n".join(table()))


if __name__ == "__main__":
    main()
