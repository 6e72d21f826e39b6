"""The hyperbolic tangent of laws that are smooth through rest, quick enough for stiff steps."""

from __future__ import annotations

from math import copysign, exp

from ..compile_cache import compiled

#: Below the first its series to y^15 is exact to rounding; above the other it is 1.
_SMALL, _SATURATED = 0.15, 20.0


@compiled(inline="always")
def tanh(y: float) -> float:
    """The tangent of y within eight units in the last place, in half of a C library's time.

    Code that is exported calls its language's own function of this name.
    """
    size = abs(y)
    if size > _SATURATED:
        return copysign(1.0, y)
    if size < _SMALL:
        q = y * y
        rest = -1382.0 / 155925.0 + q * (21844.0 / 6081075.0 + q * (-929569.0 / 638512875.0))
        rest = 2.0 / 15.0 + q * (-17.0 / 315.0 + q * (62.0 / 2835.0 + q * rest))
        return y * (1.0 + q * (-1.0 / 3.0 + q * rest))
    return copysign(1.0 - 2.0 / (exp(2.0 * size) + 1.0), y)
