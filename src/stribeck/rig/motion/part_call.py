"""Compiled functions of an axis's parts, and their calls by addresses in its row of constants.

A part is a function `part(force, q, v, u, c, slope)`: the force that comes to it becomes the force
that leaves it, at the position q and the velocity v, under the inputs u of `drives.AxisInputs` and
its own constants c, in the order in which it declares them. `slope` has two numbers that it brings
up to date, by how much the force falls per unit of position (STIFFNESS) and of velocity (DAMPING).

A row of constants has addresses of functions, so that one compiled stepper serves any axis. They
are whole numbers below 2^53, which a double holds exactly.
"""

from __future__ import annotations

from collections.abc import Callable, MutableSequence
from functools import cache
from typing import Any

from llvmlite import ir
from numba import float64, types
from numba.extending import intrinsic

from ...compile_cache import compiled
from ...friction import addressed

PartFunction = Callable[..., float]
#: The same to who writes a part.
Row = MutableSequence[float]

#: Where a part finds the two slopes of the force.
STIFFNESS, DAMPING = 0, 1
#: The type of a beginning of numbers in compiled code.
NUMBERS = types.CPointer(float64)
#: The compiled signature of a part: numbers, and the beginnings of u, c and slope.
PART_SIGNATURE = float64(float64, float64, float64, NUMBERS, NUMBERS, NUMBERS)


@cache
def address_of(function: PartFunction) -> float:
    """The address of a function's machine code, compiled the first time and kept for others."""
    machine_code = compiled(PART_SIGNATURE)(function)
    return float(addressed(machine_code, PART_SIGNATURE).__wrapper_address__())


@cache
def inlined(function: PartFunction) -> PartFunction:
    """A part as other compiled code takes it in."""
    part: PartFunction = compiled(forceinline=True)(function)
    return part


@intrinsic
def beginning(typing: Any, array: Any) -> Any:
    """Where the numbers of an array begin, which is one word to hand over, not seven."""

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        return context.make_array(signature.args[0])(context, builder, values[0]).data

    del typing
    return NUMBERS(array), generate


@intrinsic
def further(typing: Any, numbers: Any, n: Any) -> Any:
    """The beginning of numbers less the first n."""

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        del context, signature
        return builder.gep(values[0], [values[1]])

    del typing
    return NUMBERS(numbers, n), generate


@intrinsic
def called(
    typing: Any, c: Any, place: Any, force: Any, q: Any, v: Any, u: Any, slope: Any
) -> Any:  # fmt: skip
    """The force that leaves the part whose address stands at a place of a row of constants.

    Behind the address stands where in the row its constants begin.
    """

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        del context, signature
        row, place, force, q, v, inputs, slopes = values
        whole, real = ir.IntType(64), ir.DoubleType()
        after = builder.add(place, ir.Constant(whole, 1))
        address, begin = (
            builder.fptosi(builder.load(builder.gep(row, [i])), whole) for i in (place, after)
        )
        pointer = real.as_pointer()
        kind = ir.FunctionType(real, [real, real, real, pointer, pointer, pointer])
        function = builder.inttoptr(address, kind.as_pointer())
        constants = builder.gep(row, [begin])
        return builder.call(function, [force, q, v, inputs, constants, slopes])

    del typing
    return float64(c, place, force, q, v, u, slope), generate
