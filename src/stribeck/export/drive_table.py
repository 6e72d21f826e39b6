"""A friction table for a drive: n speeds and levels, the speeds placed where the curve needs them.

Drives have room for a few points (5, 16, 20) and interpolate between them. Where the points stand
is chosen by dynamic programming over a fine grid: no choice of grid points has a smaller greatest
error of interpolation between points of the curve. Then the levels are moved off the curve, by a
linear program, to where the greatest error is least; about half of it is left.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import InputError
from ..friction.curve import knots_of
from ..space import Array
from ..units import percent, unit
from .model import Model

#: Points a drive has room for, unless told otherwise; at least and at most.
POINTS, FEWEST, MOST = 20, 2, 1000
#: Speeds that points may have, and between two of them, speeds at which the error is looked at.
_GRID, _BETWEEN = 240, 8
#: Between two of those, speeds at which the error that is stated is looked for.
_STATED = 16
#: The slowest speed of the grid, as a share of the fastest; below it lies only rest.
_SLOWEST = 1e-4
#: A knot of a law that is a table, from here on, is the last speed.
_LAST = 1.0 - 1e-9


@dataclass(frozen=True, eq=False)
class DirectionTable:
    """The table of one direction.

    Args:
        speeds: Rising from 0, m/s or rad/s, (n,).
        levels: Friction there, without sign, N or N m, (n,).
        worst: Greatest error of interpolation up to the last speed, N or N m.
        rms: Its root mean square over speeds.
    """

    speeds: Array
    levels: Array
    worst: float
    rms: float


@dataclass(frozen=True, eq=False)
class DriveTable:
    """Both directions of a table; one and the same for a law that is symmetric.

    Args:
        plus: For v > 0.
        minus: For v < 0.
        largest: The largest friction of the curve itself, N or N m.
    """

    plus: DirectionTable
    minus: DirectionTable
    largest: float

    @property
    def symmetric(self) -> bool:
        """Whether both directions have one table."""
        return self.plus is self.minus


def table(model: Model, points: int = POINTS, fastest: float | None = None) -> DriveTable:
    """The best table of a model's steady sliding, without load.

    Args:
        model: What was identified.
        points: Of each direction.
        fastest: The last speed, m/s or rad/s; as fast as the training data went by default.

    Raises:
        InputError: a number of points or a speed that makes no table.
    """
    if not FEWEST <= points <= MOST:
        raise InputError(f"a table has {FEWEST} to {MOST} points, got {points}")
    fast = _fastest(model, fastest)
    law, p = model.law, model.p
    knots = knots_of(law, p)  # of a law that is a table: no others hold it without an error
    plus = _side(lambda v: law.friction(v, p), points, fast[1], knots)
    same = fast[0] == fast[1] and np.array_equal(
        law.friction(_grid(fast[1]), p), -law.friction(-_grid(fast[1]), p)
    )
    minus = plus if same else _side(lambda v: -law.friction(-v, p), points, fast[0], knots)
    largest = max(float(np.abs(law.friction(s * _grid(f), p)).max()) for s, f in
                  ((1.0, fast[1]), (-1.0, fast[0])))  # fmt: skip
    return DriveTable(plus, minus, largest)


def _fastest(model: Model, speed: float | None) -> tuple[float, float]:
    """The last speed leftward and rightward."""
    if speed is not None:
        if not (np.isfinite(speed) and speed > 0):
            raise InputError(f"the last speed of a table must be above 0, got {speed:g}")
        return speed, speed
    if model.speeds is None:
        raise InputError("the card does not say how fast the axis was: give the last speed")
    low, high = model.speeds
    if not model.law.directional:
        return (max(-low, high),) * 2
    if not (low < 0.0 < high):
        raise InputError("the data ran in one direction only: give the last speed of the table")
    return -low, high


def _grid(fast: float) -> Array:
    """Speeds from 0 on: dense where curves bend, near rest, and evenly spread."""
    half = _GRID // 2
    return np.unique(np.concatenate([
        [0.0], fast * np.geomspace(_SLOWEST, 1.0, half), fast * np.linspace(0.0, 1.0, _GRID - half)
    ]))  # fmt: skip


def _side(
    curve: Callable[[Array], Array], points: int, fast: float, knots: Array
) -> DirectionTable:
    """One direction."""
    v = np.unique(np.append(_grid(fast), knots[knots < _LAST * fast]))
    fine = np.unique(
        np.concatenate([v[:-1] + s * np.diff(v) for s in np.arange(_BETWEEN) / _BETWEEN] + [v[-1:]])
    )
    F, curve_levels = np.asarray(curve(v), float), np.asarray(curve(fine), float)
    knots = v[_placed(v, F, fine, curve_levels, min(points, len(v)))]
    levels = _levelled(knots, fine, curve_levels, np.interp(knots, v, F))
    # The levels were moved to where the error is least at `fine`: it is a little more between.
    shares = np.arange(_STATED * (len(fine) - 1) + 1) / _STATED
    between = np.interp(shares, np.arange(len(fine)), fine)
    off = np.interp(between, knots, levels) - np.asarray(curve(between), float)
    weight = np.gradient(between)
    rms = float(np.sqrt(np.sum(weight * off**2) / np.sum(weight)))
    return DirectionTable(knots, levels, float(np.abs(off).max()), rms)


def _placed(v: Array, F: Array, fine: Array, levels: Array, points: int) -> Array:
    """Which grid points a table of the least greatest error has, by dynamic programming."""
    n = len(v)
    cost = np.full((n, n), np.inf)  # the greatest error of a chord from i to j
    places = np.searchsorted(fine, v)
    for i in range(n - 1):
        inner = slice(places[i], None)
        rise = (levels[inner] - F[i])[None]
        distance = (fine[inner] - v[i])[None]
        slope = (F[i + 1 :] - F[i]) / (v[i + 1 :] - v[i])
        error = np.abs(rise - slope[:, None] * distance)
        reached = np.maximum.accumulate(error, axis=1)
        cost[i, i + 1 :] = reached[np.arange(n - 1 - i), places[i + 1 :] - places[i]]
    best = np.full((points, n), np.inf)
    previous = np.zeros((points, n), dtype=int)
    best[0, 0] = 0.0
    for k in range(1, points):
        through = np.maximum(best[k - 1][:, None], cost)
        previous[k] = np.argmin(through, axis=0)
        best[k] = through[previous[k], np.arange(n)]
    k = int(np.argmin(best[:, -1]))
    chosen = [n - 1]
    while k:
        chosen.append(int(previous[k, chosen[-1]]))
        k -= 1
    return np.array(chosen[::-1])


def _levelled(knots: Array, fine: Array, levels: Array, curve_levels: Array) -> Array:
    """The levels at given speeds that have the least greatest error."""
    from scipy.optimize import linprog  # noqa: PLC0415 - slow to import
    from scipy.sparse import csr_matrix, hstack, vstack  # noqa: PLC0415 - the same

    n, m = len(knots), len(fine)
    right = np.clip(np.searchsorted(knots, fine, side="left"), 1, n - 1)
    share = (fine - knots[right - 1]) / (knots[right] - knots[right - 1])
    rows = np.repeat(np.arange(m), 2)
    columns = np.column_stack([right - 1, right]).ravel()
    A = csr_matrix((np.column_stack([1 - share, share]).ravel(), (rows, columns)), shape=(m, n))
    ones = csr_matrix(np.ones((m, 1)))
    size = max(float(np.abs(levels).max()), 1e-300)
    off: Any = vstack([hstack([A, -ones]), hstack([-A, -ones])])
    solution = linprog(
        np.append(np.zeros(n), 1.0),
        A_ub=off,
        b_ub=np.concatenate([levels, -levels]) / size,
        bounds=[(None, None)] * n + [(0.0, None)],
        method="highs",
    )
    return curve_levels if solution.x is None else size * solution.x[:n]


def text(model: Model, drive_table: DriveTable) -> str:
    """The table as CSV, in the units in which the rig shows speeds; its errors in its head."""
    written = model.rig.shows.get("velocity", model.speed_unit)
    from_si = unit(written).from_si
    force = model.force_unit
    other = "" if written == model.speed_unit else f"the speeds of the table: {written}"
    lines = [*(f"# {line}".rstrip() for line in model.head(other)), "#"]
    for name, side in (("v > 0", drive_table.plus), ("v < 0", drive_table.minus)):
        which = "both directions" if drive_table.symmetric else name
        lines.append(
            f"# {which}: {len(side.speeds)} points, greatest error {side.worst:.3g} {force} "
            f"({percent(side.worst / drive_table.largest)} of the largest friction), RMS "
            f"{side.rms:.3g} {force}"
        )
        if drive_table.symmetric:
            break
    lines += _not_held(model)
    if drive_table.symmetric:
        lines.append(f"speed / ({written}),friction / ({force})")
        rows = [(drive_table.plus.speeds, drive_table.plus.levels)]
    else:
        lines.append(
            f"speed + / ({written}),friction + / ({force}),speed - / ({written}),"
            f"friction - / ({force})"
        )
        rows = [(s.speeds, s.levels) for s in (drive_table.plus, drive_table.minus)]
    for k in range(max(len(s) for s, _ in rows)):
        cells = []
        for speeds, levels in rows:
            cells += (
                [f"{float(from_si(speeds[k])):.9g}", f"{levels[k]:.9g}"]
                if k < len(speeds)
                else ["", ""]
            )
        lines.append(",".join(cells))
    return "\n".join(lines) + "\n"


def _not_held(model: Model) -> list[str]:
    """What a table does not hold."""
    law, missing = model.law, []
    if law.states:
        missing.append("presliding and its memory: this is steady sliding")
    if loads := [name for name in law.loads if name != "temperature"]:
        missing.append(f"the dependence on {', '.join(loads)}: this is without load")
    if "temperature" in law.loads:
        missing.append("the dependence on temperature: this is at T_ref")
    if law.terms:
        missing.append(f"the dependence on {', '.join(law.terms)}: all of it is multiplied by it")
    return [f"# Not in the table: {'; '.join(missing)}."] if missing else []
