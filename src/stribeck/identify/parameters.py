"""The parameters of an axis: which are free, which are fixed, and which equal another one."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..constant import out_of_limits
from ..errors import InputError
from ..friction import Law
from ..rig import Rig
from ..rig.rig import in_si, shown_in, stem
from ..space import Array, Param, Space
from .loss import SQUARES, Objective

#: Share of a search range within which a value sits at its end.
AT_END = 1e-3
#: By how much an end of a default range is moved out, linear and logarithmic; how often in a row.
WIDER, WIDER_LOG, WIDENINGS = 2.0, 10.0, 10


@dataclass(frozen=True, eq=False)
class Parameters:
    """Parameters of a friction law on a rig: the free ones, the fixed ones and the tied ones.

    Args:
        rig: The rig.
        law: The friction law.
        every: All k parameters, the law's and then the rig's, in the order of a complete set.
        free: The dim parameters that are estimated, in the same order.
        fixed: Values of the fixed ones, SI, by name.
        tied: Name of the parameter that a tied one equals, by its own name.
        objective: How a model is compared with data.
        bounded: The parameters whose search range is the user's.
        held: The fixed ones that the data cannot tell from others.
    """

    rig: Rig
    law: Law
    every: tuple[Param, ...]
    free: tuple[Param, ...]
    fixed: Mapping[str, float]
    tied: Mapping[str, str]
    objective: Objective = SQUARES
    bounded: frozenset[str] = frozenset()
    held: frozenset[str] = frozenset()

    @classmethod
    def declared(
        cls,
        rig: Rig,
        law: Law,
        every: Sequence[Param] | None = None,
        tied: Mapping[str, str] | None = None,
    ) -> Parameters:
        """Parameters as they are declared: fixed where their declaration holds a value.

        Args:
            rig: The rig.
            law: The law.
            every: All parameters in the order of `rig.parameters(law)`, which is the default.
            tied: `{"F_V-": "F_V+"}` makes the first equal the second.

        Raises:
            InputError: an unknown name is tied, or nothing is left to find.
        """
        every, tied = tuple(every or rig.parameters(law)), dict(tied or {})
        names = [q.name for q in every]
        for a, b in tied.items():
            if a not in names or b not in names or a == b or b in tied:
                raise InputError(f"{a} cannot be tied to {b}")
        free = tuple(q for q in every if q.fixed is None and q.name not in tied)
        if not free:
            raise InputError(f"law {law.name}: no parameter is left to be found")
        fixed = {q.name: q.fixed for q in every if q.fixed is not None and q.name not in tied}
        return cls(rig, law, every, free, fixed, tied)

    @property
    def names(self) -> tuple[str, ...]:
        """All parameters' names, (k,)."""
        return tuple(q.name for q in self.every)

    @property
    def free_places(self) -> list[int]:
        """Places of the free parameters in a complete set, (dim,)."""
        names = self.names
        return [names.index(q.name) for q in self.free]

    @property
    def middle(self) -> Array:
        """The middle of each search range, SI, (dim,)."""
        return np.array([0.5 * (q.lower + q.upper) for q in self.free])

    def full(self, x: Array) -> Array:
        """(n, dim) free values to (n, k) complete parameter sets, SI."""
        x = np.asarray(x, dtype=float)
        at = {p.name: i for i, p in enumerate(self.free)}
        p = np.empty((len(x), len(self.every)))
        for k, param in enumerate(self.every):
            name = self.tied.get(param.name, param.name)
            p[:, k] = x[:, at[name]] if name in at else self.fixed[name]
        return p

    def clipped(self, sets: Array) -> Array:
        """Complete sets, (n, k) or (k,), SI, each value within its search range."""
        return np.clip(sets, [q.lower for q in self.every], [q.upper for q in self.every])

    def widened(self, x: Array) -> Parameters | None:
        """The same with wider ranges where free values (dim,) sit at an end of a default one.

        A range that begins at 0 goes no lower. None where nothing can be widened.
        """
        wider = {
            q.name: wide
            for q, value in zip(self.free, x.tolist(), strict=True)
            if q.name not in self.bounded and (wide := _wider(q, value)) is not None
        }
        return self._over(wider) if wider else None

    def reaching(self, x: Array) -> Parameters:
        """The same with default ranges that are wide enough for free values (dim,)."""
        wider = {}
        for q, value in zip(self.free, x.tolist(), strict=True):
            for _ in range(WIDENINGS):
                wide = None if q.lower <= value <= q.upper else _wider(q, value)
                if wide is None or q.name in self.bounded:
                    break
                wider[q.name] = q = wide  # noqa: PLW2901 - the same parameter
        return self._over(wider) if wider else self

    def _over(self, wider: Mapping[str, Param]) -> Parameters:
        """The same with other ranges of some parameters, by name."""
        every, free = (
            tuple(wider.get(q.name, q) for q in params) for params in (self.every, self.free)
        )
        return replace(self, every=every, free=free)

    def widenings(self) -> tuple[str, ...]:
        """A sentence for each default range that was widened, as an answer sat at its end."""
        default = {q.name: q for q in self.rig.parameters(self.law)}
        return tuple(
            f"the range of {q.name}, {self._range(before)}, was widened to {self._range(q)}, as "
            f"the search came to its end: give a range of your own to keep within it"
            for q in self.free
            if q.name not in self.bounded
            and (before := default.get(q.name)) is not None
            and (q.lower < before.lower or q.upper > before.upper)
        )

    def _range(self, q: Param) -> str:
        low, high = (float(shown_in(self.rig, q, end)) for end in (q.lower, q.upper))
        return f"{low:.4g} to {high:.4g} {self.rig.unit_of(q)}".rstrip()

    def holding(self, values: Mapping[str, float]) -> Parameters:
        """The same with some free parameters held, SI."""
        free = tuple(q for q in self.free if q.name not in values)
        return replace(self, free=free, fixed={**self.fixed, **values})

    def freeing(self, name: str) -> Parameters:
        """The same with a parameter free that is held."""
        names = {q.name for q in self.free} | {name}
        free = tuple(q for q in self.every if q.name in names)
        return replace(self, free=free, fixed={n: x for n, x in self.fixed.items() if n != name})

    def values(self, p: Array) -> dict[str, float]:
        """One complete parameter set by name."""
        return {q.name: float(v) for q, v in zip(self.every, p, strict=True)}


def _wider(q: Param, value: float) -> Param | None:
    """A parameter with a wider range if a value sits at its end; None if not, or at zero."""
    (place,) = Space((q,)).encode(np.array([[value]]))[0]
    factor = WIDER_LOG if q.log else WIDER
    if place > 1 - AT_END and q.upper > 0:
        return replace(q, upper=q.upper * factor)
    if place < AT_END and q.lower > 0:
        return replace(q, lower=q.lower / factor)
    if place < AT_END and q.lower < 0:
        return replace(q, lower=q.lower * factor)
    return None


def partition(
    rig: Rig,
    law: Law,
    *,
    fixed: Mapping[str, float] | None = None,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    tied: Mapping[str, str] | None = None,
    objective: Objective | None = None,
) -> Parameters:
    """Sort a rig's parameters under a law into free, fixed and tied ones.

    Args:
        rig: The rig.
        law: The law.
        fixed: Values by name, in the unit the rig shows; these are not searched.
        bounds: Search ranges by name, in the unit the rig shows; frees a parameter that the
            law holds fixed, such as an exponent.
        tied: `{"F_V-": "F_V+"}` makes the first equal the second.
        objective: How a model is compared with data; squares over whole motions by default.

    Raises:
        InputError: an unknown name, a parameter that is two of these at once, a value or a
            range outside the law's meaning, or nothing left to find.
    """
    _check_loads(rig, law)
    fixed, bounds, tied = dict(fixed or {}), dict(bounds or {}), dict(tied or {})
    every = {p.name: p for p in rig.parameters(law)}
    labels = {rig.label(name): name for name in every}
    fixed = {_named(labels, every, n, rig, law): v for n, v in fixed.items()}
    bounds = {_named(labels, every, n, rig, law): v for n, v in bounds.items()}
    tied = {
        _named(labels, every, a, rig, law): _named(labels, every, b, rig, law)
        for a, b in tied.items()
    }
    _check_possible(rig, every, bounds | {name: (value,) for name, value in fixed.items()})
    for name in every:
        if sum(name in part for part in (fixed, bounds, tied)) > 1:
            raise InputError(f"{name} can be set, bounded or tied, not two of these at once")
    values = {n: p.fixed for n, p in every.items() if p.fixed is not None and n not in bounds}
    values |= {n: in_si(rig, every[n], v) for n, v in fixed.items()}
    for a, b in tied.items():
        if b in tied or a == b or every[a].unit != every[b].unit:
            raise InputError(f"{a} cannot be tied to {b}")
        values.pop(a, None)
    for name, (low, high) in bounds.items():
        p, ends = every[name], (in_si(rig, every[name], low), in_si(rig, every[name], high))
        every[name] = replace(p, lower=ends[0], upper=ends[1], log=p.log and ends[0] > 0)
    free = tuple(p for n, p in every.items() if n not in values and n not in tied)
    if not free:
        raise InputError(f"law {law.name} on rig {rig.name}: no parameter is left to be found")
    for name, value in values.items():
        if not np.isfinite(value):
            raise InputError(f"{name} is set to {value}: it must be a finite number")
        if value < 0 <= every[name].lower:
            raise InputError(f"{name} is set to {value}: it must not be below 0")
    parameters = Parameters(
        rig,
        law,
        tuple(every.values()),
        free,
        values,
        tied,
        objective or SQUARES,
        frozenset(n for n in every if n in bounds or n in rig.bounded or stem(n) in rig.bounded),
    )
    _check_meaning(parameters)
    return parameters


def _check_possible(
    rig: Rig, every: Mapping[str, Param], written: Mapping[str, Sequence[float]]
) -> None:
    """Refuse values, in the units that a rig shows, that a parameter of it cannot have."""
    for name, values in written.items():
        for value in values:
            if fault := out_of_limits(in_si(rig, every[name], value), *rig.limits(name)):
                raise InputError(f"{name} = {value:g} {fault}")


def _check_loads(rig: Rig, law: Law) -> None:
    if "cogging" in law.terms and rig.approach == "output_error":
        raise InputError(
            f"law {law.name}: cogging is told from a measured force, and rig {rig.name} simulates "
            "the motion: choose a rig with a measured force, or leave +cogging away"
        )
    if unknown := [load for load in law.loads if load not in rig.loads]:
        raise InputError(
            f"law {law.name} depends on the {unknown[0]} load, which rig {rig.name} does not know"
        )


def _named(
    labels: Mapping[str, str], every: Mapping[str, Param], name: str, rig: Rig, law: Law
) -> str:
    """A parameter's own name, given that or what its rig calls it."""
    if name in every:
        return name
    if any(c.name == name for c in rig.constants):
        raise InputError(
            f"{name} is a constant of rig {rig.name}, no parameter: set it by constants="
            f'{{"{name}": VALUE}} or {{"{name}": (VALUE, TOLERANCE)}}, or rig.set({name}=VALUE)'
        )
    if name not in labels:
        raise InputError(
            f"law {law.name} on rig {rig.name} has no parameter {name!r}: "
            f"it has {', '.join(labels)}"
        )
    return labels[name]


def _check_meaning(parameters: Parameters) -> None:
    """Some point of the search box must be a law that means something."""
    k = len(parameters.law.params)
    corners = Space(parameters.free).sample(np.random.default_rng(0), 256)
    sample = parameters.full(np.vstack([Space(parameters.free).decode(corners)]))
    if not parameters.law.physical(sample[:, :k]).any():
        raise InputError(
            f"law {parameters.law.name}: no parameter set in these ranges is physical: "
            + ", ".join(_shown_ranges(parameters))
        )


def _shown_ranges(parameters: Parameters) -> Iterator[str]:
    """What a law's own parameters are held at, and their ranges where they are free."""
    rig, law = parameters.rig, {q.name for q in parameters.law.params}
    for q in (q for q in parameters.every if q.name in law and q.name not in parameters.tied):
        ends = (parameters.fixed[q.name],) if q.name in parameters.fixed else (q.lower, q.upper)
        shown = " to ".join(f"{shown_in(rig, q, x):g}" for x in ends)
        yield f"{rig.label(q.name)} = {shown} {rig.unit_of(q)}".rstrip()
