"""The velocity that solves an implicit step: M w + h F_f(w) = P, under friction of any law."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ...compile_cache import compiled
from ...friction import RUB_SIGNATURE, addressed, rub_law, slip_law
from ...space import Array

if TYPE_CHECKING:
    from ...friction import Law

#: Iterations for the velocity; as a rule 2 to 4 are needed.
_MOST = 80
#: Where they end: change of the velocity, relative.
_FINE = 1e-13
#: Secants that are tried first, how near two of them must come, relative, and rounding.
_FEW, _NEAR, _NOISE = 6, 1e-7, 1e-15
#: A first step as short as this, relative, is the last: a slope over it would be one of rounding.
_SAME = 1e-12


def _no_rub(v: float, h: float, z: Array, load: Array, p: Array, out: Array) -> float:  # noqa: ARG001
    """Stands where a law has no states and no loads; it is never called."""
    return 0.0


_NO_RUB = rub_law(_no_rub)


def no_slip(v: float, p: Array) -> float:  # noqa: ARG001
    """Stands for the law of a side without friction; it is never called."""
    return 0.0


def calls_of(law: Law | None) -> tuple[Any, Any, bool]:
    """A law's `slip` and `rub` as compiled code calls them, and whether `rub` is what counts."""
    slip, rub = (slip_law(no_slip), None) if law is None else (law.slip, law.rub)
    general = rub is not None
    return addressed(slip), addressed(rub if general else _NO_RUB, RUB_SIGNATURE), general


@compiled(forceinline=True)
def rubs(
    slip: Any, rub: Any, general: bool, scale: float, v: float, h: float, z: Array, load: Array,
    p: Array, out: Array,
) -> float:  # fmt: skip
    """Friction at the end of a span h at speed v; the states' new values go into `out`."""
    if general:
        return scale * rub(v, h, z, load, p, out)  # type: ignore[no-any-return]
    return scale * slip(v, p)  # type: ignore[no-any-return]


@compiled(forceinline=True)
def _quick(
    slip: Any, rub: Any, general: bool, scale: float, M: float, P: float, h: float, s: float,
    v: float, z: Array, load: Array, p: Array, out: Array, slopes: Array, at: int, least: float,
) -> float:  # fmt: skip
    """The root of M w + h s F_f(s w) − P near v by secants; nan if they do not lead there.

    `slopes[at]` is how steeply friction rose when it was last asked, which makes the first step
    a good one. Secants that come nearer by a factor of 10^7 have digits to spare.
    """
    w = v
    g = M * w + h * s * rubs(slip, rub, general, scale, s * w, h, z, load, p, out) - P
    slope = M + h * slopes[at]
    other = w - g / slope
    if other > least and abs(other - w) <= _SAME * abs(other) + _NOISE * abs(P) / slope:
        return other  # type: ignore[no-any-return]
    for _ in range(_FEW):
        if not other > least or other == w:
            break
        g_other = M * other + h * s * rubs(slip, rub, general, scale, s * other, h, z, load, p, out)
        g_other -= P
        slope = (g_other - g) / (other - w)
        if not slope > 0.0:
            break
        w, g = other, g_other
        other = w - g / slope
        if abs(other - w) <= _NEAR * abs(other) + _NOISE * abs(P) / slope:
            if not other > least:
                break
            slopes[at] = max((slope - M) / h, -0.5 * M / h)
            return other  # type: ignore[no-any-return]
    slopes[at] = 0.0
    return np.nan


@compiled()
def _sliding(
    slip: Any, rub: Any, general: bool, scale: float, M: float, P: float, h: float, v: float,
    z: Array, load: Array, p: Array, out: Array,
) -> float:  # fmt: skip
    """The velocity w of the same sign as P that solves M w + h F_f(w) = P, 0 if it sticks.

    All is mirrored so that P > 0. The largest root is taken: from a slide in progress the one
    that continues it. A law that falls with speed may have another one, which is not stable.
    """
    s = 1.0 if P > 0.0 else -1.0
    P = s * P
    start = s * h * rubs(slip, rub, general, scale, s * 0.0, h, z, load, p, out) - P
    low, g_low, high, w = 0.0, start, P / M, s * v
    if not 0.0 < w < high:
        if start >= 0.0:
            return 0.0
        w = min(-start / M, 0.5 * high)
    g = M * w + s * h * rubs(slip, rub, general, scale, s * w, h, z, load, p, out) - P
    if g >= 0.0 and start >= 0.0:  # a slide in progress may go on where a start could not
        g_high = g
        while g > 0.0:
            high, g_high = w, g
            w -= g / M
            if w <= 0.0:
                return 0.0
            g = M * w + s * h * rubs(slip, rub, general, scale, s * w, h, z, load, p, out) - P
            if high - w <= _FINE * high:
                return s * w  # type: ignore[no-any-return]
            if g >= g_high:
                return 0.0
        low, g_low = w, g
    elif g >= 0.0:
        high, g_high = w, g
    else:
        low, g_low = w, g
        g_high = s * h * rubs(slip, rub, general, scale, s * high, h, z, load, p, out)
    return s * _root(  # type: ignore[no-any-return]
        slip, rub, general, scale, M, P, h, s, z, load, p, out, low, g_low, high, g_high
    )


@compiled()
def _root(  # noqa: C901 - one step of many cases
    slip: Any, rub: Any, general: bool, scale: float, M: float, P: float, h: float, s: float,
    z: Array, load: Array, p: Array, out: Array, low: float, g_low: float, high: float,
    g_high: float,
) -> float:  # fmt: skip
    """The root of M w + h s F_f(s w) − P between two points of opposite sign.

    False position as improved by Anderson and Björck (1973, doi 10.1007/BF01951936).
    """
    if g_low == 0.0:
        return low
    if g_high == 0.0:
        return high
    side = 0
    w = low
    for k in range(_MOST):
        # Past a score of tries, every other one halves the bracket: no law can do worse then.
        w = low - g_low * (high - low) / (g_high - g_low)
        if not low < w < high or (k > 20 and k % 2 == 1):  # noqa: PLR2004
            w = 0.5 * (low + high)
        g = M * w + h * s * rubs(slip, rub, general, scale, s * w, h, z, load, p, out) - P
        if g == 0.0 or high - low <= _FINE * (abs(low) + abs(high)):
            return w
        if g < 0.0:
            if side < 0:
                m = 1.0 - g / g_low
                g_high *= m if m > 0.0 else 0.5
            if w - low <= _FINE * abs(w) and k > 0:
                return w
            low, g_low, side = w, g, -1
        else:
            if side > 0:
                m = 1.0 - g / g_high
                g_low *= m if m > 0.0 else 0.5
            if high - w <= _FINE * abs(w) and k > 0:
                return w
            high, g_high, side = w, g, 1
    return w


@compiled()
def downhill(
    slip: Any, rub: Any, general: bool, scale: float, M: float, P: float, h: float, v: float,
    z: Array, load: Array, p: Array, out: Array,
) -> float:  # fmt: skip
    """The velocity w that solves M w + h F_f(w) = P under friction that has no jump at rest.

    Steps of growing length, downhill from the velocity before, until the residual changes sign:
    where a law that falls with speed has several roots, that is the next one on the way.
    """
    w = v
    g = M * w + h * rubs(slip, rub, general, scale, w, h, z, load, p, out) - P
    if g == 0.0:
        return w
    step = -g / M
    for _ in range(_MOST):
        other = w + step
        g_other = M * other + h * rubs(slip, rub, general, scale, other, h, z, load, p, out) - P
        if (g_other >= 0.0) != (g > 0.0) or g_other == 0.0:
            if g > 0.0:
                w, g, other, g_other = other, g_other, w, g
            return _root(  # type: ignore[no-any-return]
                slip, rub, general, scale, M, P, h, 1.0, z, load, p, out, w, g, other, g_other
            )
        w, g, step = other, g_other, 2.0 * step
    return w


@compiled()
def _bristled(
    slip: Any, rub: Any, scale: float, M: float, P: float, h: float, v: float, z: Array,
    load: Array, p: Array, out: Array, slopes: Array, at: int,
) -> float:  # fmt: skip
    """The velocity w that solves M w + h F_f(w) = P for a law with states."""
    w = _quick(slip, rub, True, scale, M, P, h, 1.0, v, z, load, p, out, slopes, at, -np.inf)
    if not np.isnan(w):
        return w  # type: ignore[no-any-return]
    return downhill(slip, rub, True, scale, M, P, h, v, z, load, p, out)  # type: ignore[no-any-return]


@compiled(forceinline=True)
def solved(
    slip: Any, rub: Any, general: bool, states: int, scale: float, M: float, P: float, h: float,
    v: float, z: Array, load: Array, p: Array, out: Array, slopes: Array, at: int,
) -> float:  # fmt: skip
    """The velocity w that solves M w + h F_f(w) = P, looked for from v on."""
    if states > 0:
        return _bristled(slip, rub, scale, M, P, h, v, z, load, p, out, slopes, at)  # type: ignore[no-any-return]
    if P == 0.0:
        return 0.0
    s = 1.0 if P > 0.0 else -1.0
    if s * v > 0.0:
        w = _quick(
            slip, rub, general, scale, M, s * P, h, s, s * v, z, load, p, out, slopes, at, 0.0
        )
        if w > 0.0:
            return s * w  # type: ignore[no-any-return]
    return _sliding(slip, rub, general, scale, M, P, h, v, z, load, p, out)  # type: ignore[no-any-return]
