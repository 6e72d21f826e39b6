"""What a friction law is: named bounded parameters and one compiled scalar function."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numba import float64, njit, types

from ..space import Array, Param

#: The compiled signature of every static law: slip friction in N at a speed, with parameters p.
#: Kernels take a law as a *value* of this type, so a law compiles once and no kernel per law.
SLIP_SIGNATURE = float64(float64, types.Array(float64, 1, "C", readonly=True))
SLIP_TYPE = types.FunctionType(SLIP_SIGNATURE)

Slip = Callable[[float, Array], float]


def slip_law(function: Callable[..., float]) -> Any:
    """Compile a static law `slip(v, p) -> force`, cached on disk across processes."""
    return njit(SLIP_SIGNATURE, cache=True, error_model="numpy")(function)


class Addressed(types.WrapperAddressProtocol):  # type: ignore[misc]
    """A compiled law as kernels are best given it: its address is looked up once.

    Given the law itself, numba asks for the address in every call, in Python and under a lock of
    the compiler's: that takes as long as half a simulation, and a Ctrl-C that arrives inside may
    leave the lock held, so that the next thread waits for ever.
    """

    def __init__(self, slip: Any) -> None:
        self._slip = slip  # kept alive with its machine code
        found = slip.get_compile_result(SLIP_SIGNATURE)
        self._address = found.library.get_pointer_to_function(found.fndesc.llvm_cfunc_wrapper_name)

    def __wrapper_address__(self) -> int:
        return int(self._address)

    def signature(self) -> Any:
        """Of the law, as numba asks for it."""
        return SLIP_SIGNATURE


@cache
def addressed(slip: Any) -> Addressed:
    """The compiled law by its address, looked up the first time."""
    return Addressed(slip)


@dataclass(frozen=True)
class Law:
    """A friction law and its parameters, in the order in which `slip` reads them.

    `slip(v, p)` is the friction force in slip, with the sign of the velocity `v` (it opposes
    motion once subtracted from the driving force, as in equation (4.4)). At rest the sign of
    the zero says which way motion is about to start: `slip(+0.0, p)` is the breakaway level
    F_S+ and `slip(-0.0, p)` is F_S- of equation (4.1). One scalar function is the whole law.

    Args:
        name: The name it is listed under.
        params: Its parameters, SI, in the order of `p`.
        slip: The compiled law; see `slip_law`.
        doc: What it says, in a line.
        formula: The same as a formula, plain text.
        cite: Where it comes from.
        directional: Whether it has a parameter set of its own for each direction.
        linear: Names of the parameters it is linear in (the others shape the curve).
        physical: Whether parameters (n, k) are in a meaningful order, such as F_S >= F_C.
    """

    name: str
    params: tuple[Param, ...]
    slip: Any
    doc: str
    formula: str
    cite: str
    directional: bool = False
    linear: tuple[str, ...] = ()
    physical: Callable[[Array], Any] = lambda p: np.ones(len(p), dtype=bool)

    @property
    def names(self) -> tuple[str, ...]:
        """Parameter names in the order of `p`."""
        return tuple(p.name for p in self.params)

    def friction(self, v: Array, p: Array) -> Array:
        """Slip friction over an array of speeds, equation (4.2); `p` is one parameter set."""
        p = np.ascontiguousarray(p, dtype=float)
        return np.array([self.slip(float(s), p) for s in np.ravel(v)]).reshape(np.shape(v))

    def levels(self, p: Array) -> tuple[float, float]:
        """The breakaway levels (F_S-, F_S+) of equation (4.1), in N; F_S- is negative."""
        p = np.ascontiguousarray(p, dtype=float)
        return float(self.slip(-0.0, p)), float(self.slip(0.0, p))


def stick(F_in: float, F_S_minus: float, F_S_plus: float) -> float:
    """Stick friction, equation (4.1): whatever balances the applied force, up to breakaway."""
    return min(max(F_in, F_S_minus), F_S_plus)


def friction(law: Law, v: float, F_in: float, p: Array) -> float:
    """Friction in its compact form, equation (4.3): stick at rest, slip otherwise."""
    if v == 0.0:
        return stick(F_in, *law.levels(p))
    return float(law.slip(v, np.ascontiguousarray(p, dtype=float)))


def by_direction(
    law: Law, function: Callable[..., float], *, apart: tuple[str, ...] | None = None
) -> Law:
    """The direction-dependent variant of a law: `+` parameters for v > 0, `-` for v < 0.

    Args:
        law: The symmetric law.
        function: The directional law: reads the `+` set, then the `-` set, then shared ones.
        apart: Parameters that differ between directions; all but fixed ones by default.
    """
    apart = apart or tuple(q.name for q in law.params if q.fixed is None)
    split = [q for q in law.params if q.name in apart]
    shared = [q for q in law.params if q.name not in apart]
    params = [_signed(q, sign) for sign in "+-" for q in split] + shared
    k, n = len(split), len(params)

    def physical(p: Array) -> Any:
        common = p[:, 2 * k : n]
        plus, minus = (np.hstack([p[:, i : i + k], common]) for i in (0, k))
        return np.logical_and(law.physical(plus), law.physical(minus))

    return Law(
        name=f"{law.name}-directional",
        params=tuple(params),
        slip=slip_law(function),
        doc=f"{law.doc}, with parameters of its own for each direction",
        formula=f"{law.formula}, parameters + for v > 0 and − for v < 0",
        cite=law.cite,
        directional=True,
        linear=tuple(f"{name}{sign}" for sign in "+-" for name in law.linear),
        physical=physical,
    )


def _signed(param: Param, sign: str) -> Param:
    symbol = param.symbol or param.name
    where = "rightward (v > 0)" if sign == "+" else "leftward (v < 0)"
    return Param(
        f"{param.name}{sign}",
        param.lower,
        param.upper,
        param.unit,
        f"{symbol}^{{{sign}}}",
        param.log,
        param.fixed,
        f"{param.doc}, {where}",
    )
