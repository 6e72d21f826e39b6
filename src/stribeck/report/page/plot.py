"""A plot of a page as data: what it can show, without a colour or a line of script."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

#: Heights of plots, CSS pixels.
TALL, MIDDLE, LOW, SMALL = 520, 380, 300, 240


@dataclass(frozen=True)
class View:
    """One thing that a plot can show.

    Args:
        name: What the reader picks it by.
        alt: It in a sentence, with its numbers.
        columns: Numbers by name; None where a line has a gap.
        lines: What is drawn of them.
        spans: (from, to) on the horizontal axis that are shaded: what does not count.
        levels: Horizontal lines.
        verticals: Vertical lines.
        ranges: (least, greatest) of a panel, by its number, where not all has to be seen.
    """

    name: str
    alt: str
    columns: dict[str, Any]
    lines: list[dict[str, Any]]
    spans: list[tuple[float, float]] = field(default_factory=list)
    levels: list[dict[str, Any]] = field(default_factory=list)
    verticals: list[dict[str, Any]] = field(default_factory=list)
    ranges: dict[int, tuple[float, float]] = field(default_factory=dict)


@dataclass(frozen=True)
class Plot:
    """Panels one above the other on one horizontal axis, and what they can show.

    Args:
        id: Of the element.
        title: Its heading.
        x: What the horizontal axis has.
        panels: Label and share of the height of each, from the top.
        views: What it can show, one at a time.
        height: CSS pixels.
        log: Whether its axes are logarithmic.
        note: How to read it, if that needs saying.
        hover: Of what a pointer is told: the "closest" point, or all lines at its x.
    """

    id: str
    title: str
    x: str
    panels: list[tuple[str, float]]
    views: list[View]
    height: int = MIDDLE
    log: bool = False
    note: str = ""
    hover: Literal["closest", "x unified"] = "closest"


@dataclass(frozen=True)
class Group:
    """Plots whose views are picked together.

    Args:
        id: Of the element.
        title: What is picked.
        plots: With as many views each.
    """

    id: str
    title: str
    plots: list[Plot]

    @property
    def names(self) -> list[str]:
        """What can be picked."""
        return [view.name for view in self.plots[0].views]


def line(x: str, y: str, role: str, **more: Any) -> dict[str, Any]:
    """A line of two columns: `kind` line (unless told), dashes, steps, dots, points or band."""
    return {"x": x, "y": y, "role": role, "kind": "line", **more}


def every_plot(groups: Sequence[Group | None]) -> Iterator[Plot]:
    """The plots of groups, in order."""
    for group in groups:
        if group is not None:
            yield from group.plots
