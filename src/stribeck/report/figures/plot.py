"""A figure as data: what it shows, without a colour; drawn as PNG and SVG, and by the page."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal, TypeAlias

#: Heights of plots, CSS pixels.
TALL, MIDDLE, LOW, SMALL = 520, 380, 300, 240

Kind: TypeAlias = Literal[
    "line", "dashes", "dotted", "steps", "marks", "dots", "points", "rings", "band"
]
Column: TypeAlias = Sequence[float | None]


@dataclass(frozen=True)
class Line:
    """A line of two columns, or the points of it.

    Args:
        x: The name of the column that goes to the right.
        y: Of that which goes up.
        role: What it is drawn as: ink, measured, model, command, accent, repeat0 to repeat5.
        name: What the legend calls it.
        kind: How it is drawn; `marks` is a line with its samples, `dots` a cloud, `rings` are
            points that leave their middle open.
        panel: The number of its panel.
        low: The column that a band begins at; it ends at `y`.
        wide: Whether it is drawn wide, beneath others.
        same: Whether a line before has its name in the legend already.
        silent: Whether a pointer over it is told nothing.
        hover: What a pointer over each of its points is told.
        symbols: The mark of each of its points.
    """

    x: str
    y: str
    role: str
    name: str
    kind: Kind = "line"
    panel: int = 0
    low: str | None = None
    wide: bool = False
    same: bool = False
    silent: bool = False
    hover: Sequence[str] | None = None
    symbols: Sequence[str] | None = None


@dataclass(frozen=True)
class Rule:
    """A straight line across a panel at a value, or down all panels.

    Args:
        at: The value.
        role: As a line has it.
        dash: Whether it is broken.
        name: What stands at its end.
        panel: The number of the panel that it crosses.
    """

    at: float
    role: str = "ink"
    dash: bool = False
    name: str | None = None
    panel: int = 0


@dataclass(frozen=True)
class Note:
    """Words beside a point of the first panel; `F_{S+}` is F with S+ below.

    Args:
        x: Where, on the horizontal axis.
        y: Where, on the vertical one.
        text: The words.
        role: As a line has it.
        side: On which side of the point they stand.
        above: Whether above it or below.
        away: By how much farther up (or, below zero, down), CSS pixels.
    """

    x: float
    y: float
    text: str
    role: str
    side: Literal["left", "right"]
    above: bool
    away: float = 0.0


@dataclass(frozen=True)
class Panel:
    """A vertical axis.

    Args:
        label: What it has.
        share: Its share of the height.
        title: What stands above it.
    """

    label: str
    share: float = 1.0
    title: str = ""


@dataclass(frozen=True)
class View:
    """One thing that a plot can show.

    Args:
        name: What the reader picks it by.
        alt: It in a sentence, with its numbers.
        columns: Numbers by name; None where a line has a gap.
        lines: What is drawn of them.
        spans: (from, to) on the horizontal axis that are shaded.
        shaded: What they are.
        levels: Horizontal rules.
        verticals: Vertical rules.
        ranges: (least, greatest) of a panel, by its number, where not all has to be seen.
        notes: Words beside points.
        remark: A number that belongs to its name.
    """

    name: str
    alt: str
    columns: Mapping[str, Column]
    lines: Sequence[Line]
    spans: Sequence[tuple[float, float]] = ()
    levels: Sequence[Rule] = ()
    verticals: Sequence[Rule] = ()
    ranges: Mapping[int, tuple[float, float]] = field(default_factory=dict)
    notes: Sequence[Note] = ()
    remark: str = ""
    shaded: str = "not scored"


@dataclass(frozen=True)
class Plot:
    """Panels one above the other on one horizontal axis, and what they can show.

    Args:
        id: Of the element, or of the file.
        title: Its heading.
        x: What the horizontal axis has.
        panels: From the top.
        views: What it can show, one at a time; on paper, side by side.
        height: CSS pixels.
        log: Whether its axes are logarithmic.
        note: How to read it, if that needs saying.
        hover: Of what a pointer is told: the "closest" point, or all lines at its x.
    """

    id: str
    title: str
    x: str
    panels: Sequence[Panel]
    views: Sequence[View]
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
    plots: Sequence[Plot]

    @property
    def names(self) -> list[str]:
        """What can be picked."""
        return [view.name for view in self.plots[0].views]


def every_plot(groups: Sequence[Group]) -> Iterator[Plot]:
    """The plots of groups, in order."""
    for group in groups:
        yield from group.plots
