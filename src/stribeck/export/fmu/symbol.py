"""Symbolic arithmetic: the coefficients of an equation as C expressions."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar


@dataclass(frozen=True)
class Symbol:
    """An expression in C.

    Args:
        text: It, in parentheses where it is more than a name.
    """

    __array_ufunc__: ClassVar[None] = None  # a NumPy number leaves the arithmetic to the symbol

    text: str

    def __add__(self, other: Symbol | float) -> Symbol:
        return _written(self, "+", other)

    def __radd__(self, other: float) -> Symbol:
        return _written(other, "+", self)

    def __sub__(self, other: Symbol | float) -> Symbol:
        return _written(self, "-", other)

    def __rsub__(self, other: float) -> Symbol:
        return _written(other, "-", self)

    def __mul__(self, other: Symbol | float) -> Symbol:
        return _written(self, "*", other)

    def __rmul__(self, other: float) -> Symbol:
        return _written(other, "*", self)

    def __truediv__(self, other: Symbol | float) -> Symbol:
        return _written(self, "/", other)

    def __rtruediv__(self, other: float) -> Symbol:
        return _written(other, "/", self)

    def __neg__(self) -> Symbol:
        return Symbol(f"(-{self.text})")

    def __pow__(self, power: int) -> Symbol:
        """A small whole power, as products."""
        product = self
        for _ in range(power - 1):
            product = product * self
        return product


def c_text(value: Symbol | float) -> str:
    """A symbol or a number in C."""
    if isinstance(value, Symbol):
        return value.text
    if math.isfinite(value):
        return repr(float(value))
    return "NAN" if math.isnan(value) else "HUGE_VAL" if value > 0 else "(-HUGE_VAL)"


def _written(left: Symbol | float, operator: str, right: Symbol | float) -> Symbol:
    return Symbol(f"({c_text(left)} {operator} {c_text(right)})")
