"""Long lines with few points: what a reader sees, zoomed in a little, stays where it is.

Of every span of samples the first, the last, the least and the greatest are kept (M4: Jugel,
Jerzak, Hackenbroich and Markl 2014, doi 10.14778/2732951.2732953), and the one that is farthest
from the chord: the corner of a staircase is none of the four.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ...space import Array

#: Spans that a line is cut into, tried one after the other until few enough points are left.
_SPANS = tuple(int(8000 / 2 ** (k / 2)) for k in range(20))


def corners(lines: Sequence[Array], most: int) -> NDArray[np.int64]:
    """Which samples of several lines over the same times to keep, at most about so many.

    Args:
        lines: (N,) each; nan where a line has a gap, whose samples are kept.
        most: As many points as may be kept, beside those of gaps.

    Returns:
        Rising row numbers; all rows where there are no more than `most`.
    """
    n = len(lines[0])
    if n <= most:
        return np.arange(n)
    gaps = np.flatnonzero(np.any([~np.isfinite(y) for y in lines], axis=0))
    rows = np.arange(0)
    for spans in _SPANS:
        rows = np.unique(np.concatenate([_marks(y, min(spans, n)) for y in lines]))
        if len(rows) <= most:
            break
    return np.union1d(rows, gaps)


def _marks(y: Array, spans: int) -> NDArray[np.int64]:
    """First, last, least, greatest and farthest from the chord of each span."""
    n = len(y)
    width = -(-n // spans)
    rows = np.minimum(np.arange(-(-n // width) * width), n - 1).reshape(-1, width)
    # A gap is no extreme; a line that is all gap has the first sample of its span.
    known = np.isfinite(y)[rows]
    part = np.where(known, y[rows], 0.0)
    chord = part[:, :1] + (part[:, -1:] - part[:, :1]) * np.linspace(0.0, 1.0, width)
    columns = [
        np.zeros(len(rows), dtype=np.int64),
        np.full(len(rows), width - 1),
        np.where(known, part, np.inf).argmin(axis=1),
        np.where(known, part, -np.inf).argmax(axis=1),
        np.where(known, np.abs(part - chord), -1.0).argmax(axis=1),
    ]
    return np.concatenate([rows[np.arange(len(rows)), k] for k in columns])


def listed(y: Array) -> list[float | None]:
    """The values in full; None where there is none."""
    return [v if v == v else None for v in y.tolist()]  # noqa: PLR0124 - nan is not itself


def rounded(y: Array, digits: int = 6) -> list[float | None]:
    """The values with so many digits of the span they cover; None where there is none."""
    finite = np.isfinite(y)
    if not finite.any():
        return [None] * len(y)
    values = y[finite]
    size = float(np.ptp(values)) or float(np.abs(values[0])) or 1.0
    places = digits - 1 - int(np.floor(np.log10(size)))
    # Beyond 300 places a power of ten is no double; nothing measured is that small.
    short = np.round(y, places) + 0.0 if abs(places) < 300 else y  # noqa: PLR2004
    if finite.all():
        return [float(v) for v in short.tolist()]
    return [v if ok else None for v, ok in zip(short.tolist(), finite.tolist(), strict=True)]


@dataclass(frozen=True)
class Detail:
    """How finely a fit is shown.

    Args:
        speeds: Of a law's curve, each way from rest.
        cloud: Points of a cloud at most.
        loads: Points of a line of the law under load.
        rounds: Whether numbers have as many digits as can be seen, or all.
    """

    speeds: int
    cloud: int
    loads: int
    rounds: bool

    def series(self, y: Array, digits: int = 6) -> list[float | None]:
        """Values as a report has them, to so many digits of their span."""
        return rounded(y, digits) if self.rounds else listed(y)


#: For the page, whose file has to stay small, and for print.
PAGE, PRINT = Detail(48, 2_500, 60, rounds=True), Detail(400, 20_000, 200, rounds=False)
