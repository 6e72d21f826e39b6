"""The friction law: named bounded parameters and one compiled scalar function."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cache, cached_property
from math import cos, pi, sin
from types import MappingProxyType
from typing import Any, Literal, NamedTuple

import numpy as np
from numba import float64, types
from numba.extending import typeof_impl

from ..compile_cache import compiled
from ..errors import InputError
from ..space import Array, Param, contiguous
from .yield_spectrum import Spectrum

#: The compiled signature of every static law: slip friction in N at a speed, with parameters p.
#: Kernels take a law as a *value* of this type, so a law compiles once and no kernel per law.
SLIP_SIGNATURE = float64(float64, types.Array(float64, 1, "C", readonly=True))
SLIP_TYPE = types.FunctionType(SLIP_SIGNATURE)

Slip = Callable[[float, Array], float]

_READ = types.Array(float64, 1, "C", readonly=True)
#: The compiled signature of a law with states or loads: rub(v, h, z, load, p, out) -> force.
RUB_SIGNATURE = float64(float64, float64, _READ, _READ, _READ, types.Array(float64, 1, "C"))
RUB_TYPE = types.FunctionType(RUB_SIGNATURE)

#: What a law may depend on beside velocity, in the order in which `rub` reads it: force of the
#: drive and of everything else on the axis (N or N m, signed), the normal load (in the rig's own
#: SI unit, such as Pa), position (m or rad) and temperature (K).
LOADS = ("drive", "external", "normal", "position", "temperature")
#: Where each of LOADS stands in the `load` of `rub`.
DRIVE, EXTERNAL, NORMAL, POSITION, TEMPERATURE = range(len(LOADS))

Term = Literal["position", "temperature", "cogging"]
#: What any law may have besides, and the parameters that this adds. `position` and `temperature`
#: multiply all of the friction; `cogging` is a force over position, the same both ways.
TERMS: Mapping[Term, tuple[Param, ...]] = MappingProxyType(
    {
        "position": (
            Param("pos_cos", -0.9, 0.9, "", "c_x", doc="share of friction that goes with cos"),
            Param("pos_sin", -0.9, 0.9, "", "s_x", doc="share of friction that goes with sin"),
            Param("pos_period", 1e-4, 10.0, "m", "\\lambda", True, 5e-3,
                  "period of the position term: a lead, a pitch, a turn"),
        ),
        "temperature": (
            Param("temp_slope", -0.1, 0.1, "1/K", "\\beta", doc="change of friction per kelvin"),
            Param("temp_ref", 200.0, 500.0, "K", "T_0", fixed=293.15,
                  doc="temperature at which the law's own parameters hold"),
        ),
        "cogging": (
            Param("cog_cos", -1e6, 1e6, "N", "C_x", doc="force that goes with cos"),
            Param("cog_sin", -1e6, 1e6, "N", "S_x", doc="force that goes with sin"),
            Param("cog_period", 1e-4, 10.0, "m", "\\lambda_c", True,
                  doc="period of the cogging: a pole pitch, a tooth, a turn"),
        ),
    }
)  # fmt: skip

#: Terms with harmonics, after a colon: `stribeck+position:2` has the period and its half.
HARMONIC: tuple[Term, ...] = ("position", "cogging")
MOST_HARMONICS = 6

#: What the terms do to the friction F, in the names of their parameters.
_FORMULAS: Mapping[Term, str] = MappingProxyType(
    {
        "position": "all of F times 1 + pos_cos cos(2πx/pos_period) + pos_sin sin(2πx/pos_period)",
        "temperature": "all of F times 1 + temp_slope (T − temp_ref)",
        "cogging": "besides F a force cog_cos cos(2πx/cog_period) + cog_sin sin(2πx/cog_period)",
    }
)


def term_params(term: Term, harmonics: int) -> tuple[Param, ...]:
    """The parameters of a term: an amplitude pair a harmonic, `pos_cos_2` of the second."""
    if term not in HARMONIC:
        return TERMS[term]
    cos, sin, period = TERMS[term]
    pairs = [
        replace(q, name=f"{q.name}_{k}", symbol=f"{q.symbol}_{k}", doc=f"{q.doc} of 1/{k} of it")
        if k > 1
        else q
        for k in range(1, harmonics + 1)
        for q in (cos, sin)
    ]
    return (*pairs, period)


@compiled()
def temperature_factor(T: float, temp_slope: float, temp_ref: float) -> float:
    """The factor of the term `temperature` at a temperature T, K."""
    return 1.0 + temp_slope * (T - temp_ref)


@compiled(forceinline=True)
def terms_factor(places: Array, p: Array, load: Array) -> float:
    """The factor of all terms of a law under the loads (5,); `places` as `term_places` has them."""
    scale = 1.0
    if places[0] >= 0:
        angle = 2.0 * pi * load[POSITION] / p[places[0] + 2 * places[2]]
        order = 0.0
        for k in range(places[2]):
            order += 1.0
            scale += p[places[0] + 2 * k] * cos(order * angle)
            scale += p[places[0] + 2 * k + 1] * sin(order * angle)
    if places[1] >= 0:
        scale *= temperature_factor(load[TEMPERATURE], p[places[1]], p[places[1] + 1])
    return max(scale, 0.0)


@cache
def slip_law(function: Callable[..., float]) -> Any:
    """Compile a static law `slip(v, p) -> force`; its machine code is kept across processes."""
    return compiled(SLIP_SIGNATURE)(function)


@cache
def rub_law(function: Callable[..., float]) -> Any:
    """Compile a law with states or loads `rub(v, h, z, load, p, out) -> force`, kept likewise."""
    return compiled(RUB_SIGNATURE)(function)


class Addressed(types.WrapperAddressProtocol):  # type: ignore[misc]
    """A compiled law as kernels are best given it: its address and its type are looked up once.

    Given the law itself, numba asks for the address in every call, in Python and under a lock of
    the compiler's: that takes as long as half a simulation, and a Ctrl-C that arrives inside may
    leave the lock held, so that the next thread waits for ever.
    """

    def __init__(self, compiled: Any, signature: Any) -> None:
        self._compiled, self._signature = compiled, signature  # kept alive with its machine code
        self.type = types.FunctionType(signature)
        result = compiled.get_compile_result(signature)
        self._address = result.library.get_pointer_to_function(
            result.fndesc.llvm_cfunc_wrapper_name
        )

    def __wrapper_address__(self) -> int:
        return int(self._address)

    def signature(self) -> Any:
        """Of the law, as numba asks for it."""
        return self._signature


@typeof_impl.register(Addressed)
def _type_of(law: Addressed, context: Any) -> Any:
    """Its type; numba would make a new one in every call."""
    del context
    return law.type


@cache
def addressed(compiled: Any, signature: Any = SLIP_SIGNATURE) -> Addressed:
    """The compiled law by its address, looked up the first time."""
    return Addressed(compiled, signature)


class RigidLimit(NamedTuple):
    """What a law approaches as it rises from rest ever more steeply: a law that sticks.

    Simulated at a fraction of the cost and with fewer local minima, its answer shows where the
    other one's is.

    law: It.
    sets: Its parameters (k,) to parameter sets (n, m) of the other law without terms that come
        close to it, from the softest to the stiffest. Those out of a search range count at its end.
    """

    law: Law
    sets: Callable[[Array], Array]


@dataclass(frozen=True)
class Law:
    """A friction law and its parameters, in the order in which `slip` reads them.

    `slip(v, p)` is the friction force in slip, with the sign of the velocity `v` (it opposes
    motion once subtracted from the driving force, as in equation (4.4)). At rest the sign of
    the zero says which way motion is about to start: `slip(+0.0, p)` is the breakaway level
    F_S+ and `slip(-0.0, p)` is F_S- of equation (4.1). One scalar function is the whole law.

    A law with inner states, or one that depends on loads, has a second one, `rub(v, h, z, load,
    p, out)`: the friction force at the end of a span of h seconds passed at constant velocity v,
    from the states z, (states,), which it advances into `out`, exactly or by a rule that is
    stable for any h; at h = 0 the states stay. `load` has the five of LOADS. With states the
    force is continuous through rest, and what holds the axis is the states' own; without, it
    sticks as a static law does, with `rub` at +0.0 and -0.0 as its breakaway levels. Its `slip`
    is then the friction of steady sliding without load.

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
        rub: The compiled law where it has states or loads; see `rub_law`.
        states: How many states it has.
        loads: Which of LOADS it reads.
        terms: Which of TERMS it has; their parameters come last in `params`.
        sizes: How many parameters each of them has.
        starts: Parameter sets without terms, (n, k), near one whose contact has a spectrum, where
            a search begins; None for a law that says nothing of it.
        roughness: Rows over a parameter set (k,) without terms, (m, k), whose products with it
            are small where the curve is smooth; None for a law of few parameters.
        rests: Whether its breakaway depends on how long it has rested.
        elements: Of a law that is Maxwell elements beside viscous friction and nothing else: their
            levels, N (N m), and the displacements at which they yield, m (rad), (n, m) each, and
            F_V, (n,), of parameter sets (n, k).
        rigid_limit: The law that it approaches as it rises from rest more steeply; None for one
            that sticks.
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
    rub: Any = None
    states: int = 0
    loads: tuple[str, ...] = ()
    terms: tuple[Term, ...] = ()
    sizes: tuple[int, ...] = ()
    starts: Callable[[Spectrum], Array] | None = None
    roughness: Callable[[Array], Array] | None = None
    rests: bool = False
    elements: Callable[[Array], tuple[Array, Array, Array]] | None = None
    rigid_limit: RigidLimit | None = None

    @property
    def static(self) -> bool:
        """Whether `slip` says it all: no states, no loads, no terms."""
        return self.rub is None and not self.terms

    @property
    def warms(self) -> bool:
        """Whether it depends on the temperature."""
        return "temperature" in (*self.loads, *self.terms)

    @cached_property
    def sticks(self) -> bool:
        """Whether it has levels of its own that hold an axis at rest: no states, not all zero."""
        upper = np.array([q.upper if q.fixed is None else q.fixed for q in self.params])
        return self.states == 0 and any(self.levels(upper))

    def place(self, term: Term) -> slice:
        """Where the parameters of one of its terms stand in `params`."""
        at = self.terms.index(term)
        first = len(self.params) - sum(self.sizes[at:])
        return slice(first, first + self.sizes[at])

    def with_term(self, term: Term, harmonics: int = 1) -> Law:
        """The same law with a term that has parameters of its own, see `TERMS`.

        Args:
            term: Which.
            harmonics: Of a term over position.

        Raises:
            InputError: there is no such term, the law has it already, or it has no harmonics.
        """
        if term not in TERMS or term in self.terms:
            raise InputError(f"law {self.name}: cannot add a term {term!r}: there are "
                             f"{', '.join(TERMS)}, each once")  # fmt: skip
        if harmonics != 1 and (term not in HARMONIC or not 1 < harmonics <= MOST_HARMONICS):
            raise InputError(
                f"law {self.name}+{term}:{harmonics}: {' and '.join(HARMONIC)} have 1 to "
                f"{MOST_HARMONICS} harmonics, other terms none"
            )
        k, symmetric, added = len(self.params), self.physical, term_params(term, harmonics)
        several = f", and of {harmonics - 1} more with x times 2 and so on" if harmonics > 1 else ""
        forces = tuple(q.name for q in added[:-1]) if term == "cogging" else ()
        return replace(
            self,
            name=f"{self.name}+{term}" + (f":{harmonics}" if harmonics > 1 else ""),
            params=self.params + added,
            doc=f"{self.doc}; {'with' if forces else 'depending on'} {term}",
            formula=f"{self.formula},  {_FORMULAS[term]}{several}",
            terms=(*self.terms, term),
            sizes=(*self.sizes, len(added)),
            linear=self.linear + forces,
            physical=lambda p: symmetric(p[:, :k]),
        )

    @property
    def names(self) -> tuple[str, ...]:
        """Parameter names in the order of `p`."""
        return tuple(p.name for p in self.params)

    def friction(self, v: Array, p: Array) -> Array:
        """Slip friction over an array of speeds, equation (4.2); `p` is one parameter set."""
        p = contiguous(p)
        return np.array([self.slip(float(s), p) for s in np.ravel(v)]).reshape(np.shape(v))

    def levels(self, p: Array) -> tuple[float, float]:
        """The breakaway levels (F_S-, F_S+) of equation (4.1), in N; F_S- is negative."""
        p = contiguous(p)
        return float(self.slip(-0.0, p)), float(self.slip(0.0, p))


def term_places(law: Law) -> Array:
    """Where the parameters of the position and of the temperature term begin, and harmonics, (3,).

    -1 for a term that the law has not.
    """
    first = [law.place(t).start if t in law.terms else -1 for t in ("position", "temperature")]
    harmonics = law.sizes[law.terms.index("position")] // 2 if first[0] >= 0 else 0
    return np.array([*first, harmonics], dtype=np.int64)


def stick(F_in: float, F_S_minus: float, F_S_plus: float) -> float:
    """Stick friction, equation (4.1): whatever balances the applied force, up to breakaway."""
    return min(max(F_in, F_S_minus), F_S_plus)


def friction(law: Law, v: float, F_in: float, p: Array) -> float:
    """Friction in its compact form, equation (4.3): stick at rest, slip otherwise."""
    if v == 0.0:
        return stick(F_in, *law.levels(p))
    return float(law.slip(v, contiguous(p)))


def by_direction(
    law: Law,
    function: Any,
    *,
    split_names: tuple[str, ...] | None = None,
    name: str = "",
    roughness: Callable[[Array], Array] | None = None,
    limit: Law | None = None,
) -> Law:
    """The direction-dependent variant of a law: `+` parameters for v > 0, `-` for v < 0.

    Args:
        law: The symmetric law.
        function: The directional law: reads the `+` set, then the `-` set, then shared ones.
        split_names: Parameters that differ between directions; all but fixed ones by default.
        name: What it is listed under; that of the law with `-directional` by default.
        roughness: As of `Law`, over the parameters of both directions.
        limit: The rigid limit's own variant.
    """
    split_names = split_names or tuple(q.name for q in law.params if q.fixed is None)
    split = [q for q in law.params if q.name in split_names]
    shared = [q for q in law.params if q.name not in split_names]
    params = [_signed(q, sign) for sign in "+-" for q in split] + shared
    k, n = len(split), len(params)

    def physical(p: Array) -> Any:
        common = p[:, 2 * k : n]
        plus, minus = (np.hstack([p[:, i : i + k], common]) for i in (0, k))
        return np.logical_and(law.physical(plus), law.physical(minus))

    return Law(
        name=name or f"{law.name}-directional",
        params=tuple(params),
        slip=slip_law(function),
        doc=f"{law.name} with parameters of its own for each direction",
        formula=f"{law.formula},  parameters + for v > 0 and − for v < 0",
        cite=law.cite,
        directional=True,
        linear=tuple(f"{name}{sign}" for sign in "+-" for name in law.linear),
        physical=physical,
        roughness=roughness,
        rigid_limit=None if limit is None else _limit_by_direction(law, limit),
    )


def _limit_by_direction(law: Law, directional: Law) -> RigidLimit | None:
    """The rigid limit of a law whose directions share no parameter."""
    if law.rigid_limit is None:
        return None
    names, sets_of_one = law.rigid_limit.law.names, law.rigid_limit.sets

    def sets(p: Array) -> Array:
        value = dict(zip(directional.names, p.tolist(), strict=True))
        sides = [[value.get(f"{n}{sign}", value.get(n)) for n in names] for sign in "+-"]
        return np.hstack([sets_of_one(np.array(side)) for side in sides])

    return RigidLimit(directional, sets)


def _signed(param: Param, sign: str) -> Param:
    symbol = param.symbol or param.name
    side = "rightward (v > 0)" if sign == "+" else "leftward (v < 0)"
    return Param(
        f"{param.name}{sign}",
        param.lower,
        param.upper,
        param.unit,
        f"{symbol}^{{{sign}}}",
        param.log,
        param.fixed,
        f"{param.doc}, {side}",
    )
