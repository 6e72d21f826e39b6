"""Laws outside the tables, written in ways that a translation may get wrong, or has to refuse."""

# ruff: noqa: ARG001, FURB136, RET504 - awkward on purpose
from __future__ import annotations

from collections.abc import Callable, Mapping
from math import atan, copysign, exp, pi, sqrt
from typing import Any, NamedTuple

import numpy as np
from numba import boolean, float64, int64, njit

from stribeck.friction import slip_law
from stribeck.friction.law import Law
from stribeck.space import Array, Param

#: Names that are words of one language or another, two of them but for their capitals.
PARAMS = (
    Param("F_S", 0.0, 1000.0, "N", "F_S"),
    Param("f_s", 0.0, 1000.0, "N", "f_s"),
    Param("of", 0.0, 500.0, "N s/m", "o"),
    Param("limit", 1e-3, 1e-1, "m/s", "l"),
    Param("end", 0.0, 1.0, "", "e"),
)


def own_law(slip: Callable[[float, Array], Any], *, compiled: bool = True) -> Law:
    """A law with five parameters, under a name of its own."""
    return Law(
        name="own",
        params=PARAMS,
        slip=slip_law(slip) if compiled else slip,
        doc="a law of one's own",
        formula="F = …",
        cite="nobody",
    )


def hostile(v: float, p: Array) -> Any:
    """A Stribeck curve in the words of other languages. *) */ ' \" { } %"""
    end, of, limit, Limit, e, i, when, time = p[0], p[1], p[2], p[3], 1.0, 0.0, abs(v), 0.0
    lreal, function, loop, _private, double__bar, exp_, y = when, end, of, limit, Limit, 0.0, 0.0
    for j in range(3):
        time += e * j
    if time > 2.5:
        i = function - loop
    pi_ = lreal / double__bar
    y = copysign(1.0, v) * (loop + i * exp(-pi_)) + _private * v + exp_
    return y


def conditions(v: float, p: Array) -> Any:
    a = 1.0 / v if v != 0.0 else 0.0
    b = 2.0 if v != 0.0 and 1.0 / v > 3.0 else (3.0 if v == 0.0 or 0.5 / v < -9.0 else p[4])
    c = 1.0 if 0.0 < v < 1.0 < 1.0 / v else -1.0
    return sqrt(abs(a)) * 1e-3 + b + 10.0 * c if not (v > 2.0 and b < 1.0) else -7.0


def arguments(v: float, p: Array) -> Any:
    s = 1.0 if v >= 0.0 else -1.0
    v = abs(v)
    if v > 0.1:
        v = 0.1 + 0.5 * (v - 0.1)
    return s * (p[1] + p[2] * v)


def whole_numbers(v: float, p: Array) -> Any:
    n, down, total = 4, -7, 0.0
    for i in range(n):
        total += i / n
        down = down + i
        total += down // 3 + (i // 2) * 0.25
        x = i if v > 0.0 else 0.5
        total += x
    down -= 100
    return total + down // 7 + (1 if v < 0.0 else 2)


def loops(v: float, p: Array) -> Any:
    x, n = abs(v), 0.0
    while 1.0 / (x if x > 0.0 else 1.0) > 0.3 and n < 20.0:
        x = 2.0 * x if x > 0.0 else 0.25
        n += 1.0
        if n == 15.0:
            return -n
    return n + x


def powers(v: float, p: Array) -> Any:
    return (
        abs(v) ** 0.5 + abs(v) ** p[4] + v**2 + v**0 + abs(v) ** 3 + min(v, 0.1, p[4]) - max(0, v)
    )


@njit(float64(float64, float64))  # type: ignore[untyped-decorator]
def _saw(v: float, s: float) -> Any:
    s = 2.0 * s
    return s if v > s else v


def calls(v: float, p: Array) -> Any:
    return _saw(v, 0.02) - _saw(-v, _saw(p[4], 0.01)) - -_saw(v, 1.0) * -3.0


def swaps(v: float, p: Array) -> Any:
    a, b, c = abs(v), p[0], 0.0
    a, b = b, a
    a, b, c = 0.5 * b, c + 1.0, a + b
    b = c = c + b
    return (a if v > 0.0 else -a) + b - c * 0.25


@njit(float64(float64, int64, boolean))  # type: ignore[untyped-decorator]
def _raised(v: float, times: int, mirrored: bool) -> float:
    x = -v if mirrored else v
    for _ in range(times):
        x = x * 1.5 + 0.01
    return x


@njit(int64(float64))  # type: ignore[untyped-decorator]
def _region(v: float) -> int:
    return 2 if v > 0.01 else 1


def kinds(v: float, p: Array) -> Any:
    return _raised(v, _region(v), v < 0.0) + p[_region(-v)] * _raised(p[4], 3, False)


def ranges(v: float, p: Array) -> Any:
    """Loops that do not begin at 0, some of them over nothing, and loops over values."""
    n, total = 3 if v > 0.0 else 1, 0.0
    for i in range(1, 4):
        for j in range(i, n + 1):
            total += i * 0.5 + p[j] * v
    for i in range(n, 2):
        total += 7.0 * i
    for k in (2, 0, 4):
        total -= p[k] * 1e-3 if k in (0, 4) else 0.25 * k
        for i in range(k - 1, k + 1):
            total += 0.125 * i
    return total + int(3.7)


@njit  # type: ignore[untyped-decorator]
def _counted(v: float, most: int, odd: bool) -> tuple[float, int, bool]:
    """Several results, jumps, and an argument that is known in each call."""
    rest, steps = abs(v), 0
    for i in range(most):
        if odd and i % 2 == 0:
            continue
        if rest < 1e-3 or i in (7, 8):
            break
        rest, steps = 0.5 * rest, steps + 1
    return rest, steps, rest < 1e-3


def wide(v: float, p: Array) -> Any:
    rest, steps, small = _counted(v, 12, False)
    _, more, _ = _counted(3.0 * v, 9, True)
    bound = np.inf if small else 0.5
    x = np.round(20.0 * v) + min(rest, bound)
    return x + p[steps % 3] + 10.0 * more if not np.isnan(x) else 0.0


_STEPS = np.array([0.5, 0.25, -1.0, 2.0])
_GRID = np.array([[1.0, 2.0, 3.0], [-4.0, 5.0, 0.5]])


class Pair(NamedTuple):
    """Two numbers that belong together, and how many there were."""

    low: Any
    high: Any
    n: int = 2


@njit  # type: ignore[untyped-decorator]
def _pair(row: Array) -> Pair:
    return Pair(min(row[0], row[1]), max(row[0], row[1]), 2)


@njit  # type: ignore[untyped-decorator]
def _between(pair: Pair, share: float) -> float:
    return pair.low + share * (pair.high - pair.low) * pair.n  # type: ignore[no-any-return]


@njit  # type: ignore[untyped-decorator]
def _both(v: float, p: Array) -> tuple[float, float]:
    return _ends(v, p[1:])  # type: ignore[no-any-return]


@njit  # type: ignore[untyped-decorator]
def _ends(v: float, p: Array) -> tuple[float, float]:
    return v * p[0], p[len(p) - 1]


def parts(v: float, p: Array) -> Any:
    """Tables, rows and stretches of arrays, and values that have names."""
    total, first = 0.0, p[:2]
    for i in range(len(_STEPS)):
        total += _STEPS[i] * v
    for i in range(2):
        row = _GRID[i]
        pair = _pair(_GRID[i, 1:])
        total += row[0] + _between(pair, 0.25 * i) + pair.n + _GRID[1, i + 1]
    levels = _pair(first)
    low, high = _both(v, p[1:4])
    table = p[:4].reshape(2, 2)
    return total + _between(levels, v) + low - high + table[1, 0] * _STEPS[2]


HOSTILE = hostile
AWKWARD: Mapping[str, Callable[[float, Array], Any]] = {
    "conditions": conditions,
    "arguments": arguments,
    "whole numbers": whole_numbers,
    "loops": loops,
    "powers": powers,
    "calls": calls,
    "swaps": swaps,
    "kinds": kinds,
    "ranges": ranges,
}
#: What only C is told.
WIDE: Mapping[str, Callable[[float, Array], Any]] = {"wide": wide, "parts": parts}


def _knows_interp(v: float, p: Array) -> Any:
    return float(np.interp(v, [0.0, 1.0], [p[0], p[1]]))


def _knows_atan(v: float, p: Array) -> Any:
    return p[0] * atan(v / p[3]) * 2.0 / pi


def _lists(v: float, p: Array) -> Any:
    return sum([p[i] * v for i in range(2)])


def _recurs(v: float, p: Array) -> Any:
    return p[0] * _halved(v)


def _halved(v: float) -> Any:
    return v if abs(v) < 1e-3 else 0.5 * _halved(0.5 * v)


def _after(v: float, p: Array) -> Any:
    for i in range(3):
        v += p[i]
    return v + i


def _counts(v: float, p: Array) -> Any:
    for i in range(3):
        v += p[i]
        i += 1  # noqa: PLW2901 - that is the point
    return v


def _raises(v: float, p: Array) -> Any:
    if v > p[3]:
        raise ValueError
    return v


def _falls_through(v: float, p: Array) -> Any:  # noqa: RET503
    if v > 0.0:
        return p[0]


def _part_of_unknown_length(v: float, p: Array) -> Any:
    n = 2 if v > 0.0 else 1
    return _ends(v, p[n:])[0]


def _every_other(v: float, p: Array) -> Any:
    part = p[::2]
    return v * part[0]


def _no_row(v: float, p: Array) -> Any:
    row = _GRID[2]
    return v * row[0]


def _jumps(v: float, p: Array) -> Any:
    for k in (0, 1, 2):
        if p[k] > v:
            break
        v += p[k]
    return v


def _values_not_known(v: float, p: Array) -> Any:
    total = 0.0
    for x in (v, p[0]):
        total += x
    return total


def _no_pair(v: float, p: Array) -> Any:
    return _between(v, 0.5)


def _two_pairs(v: float, p: Array) -> Any:
    pair = _pair(p)
    if v > 0.0:
        pair = _pair(p[1:])
    return v * pair.low


UNKNOWN: Mapping[str, Callable[[float, Array], Any]] = {
    "numpy": _knows_interp,
    "a function we do not know": _knows_atan,
    "a list": _lists,
    "a recursion": _recurs,
    "a loop's variable after it": _after,
    "a loop's variable changed": _counts,
    "an exception": _raises,
    "no value": _falls_through,
    "a part of unknown length": _part_of_unknown_length,
    "every other element": _every_other,
    "a row that is not there": _no_row,
    "a jump in a loop over values": _jumps,
    "a loop over values that are not known": _values_not_known,
    "a number for a NamedTuple": _no_pair,
    "a NamedTuple that is assigned twice": _two_pairs,
}
