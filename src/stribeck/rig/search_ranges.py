"""Search ranges that a rig file states, by what people see parameters called."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TypeVar

from ..constant import out_of_limits
from ..errors import InputError
from ..friction import LAWS, law_named
from .rig import Rig, in_si, stem

_Rig = TypeVar("_Rig", bound=Rig)


def with_ranges(
    rig: _Rig, ranges: Mapping[str, tuple[float, float]], laws: Sequence[str] | None = None
) -> _Rig:
    """The rig with search ranges of the user's.

    Args:
        rig: A rig.
        ranges: Pairs (lower, upper) in the units that it shows, by a parameter's label, or by the
            stem of both directions or of all elements of a law.
        laws: Whose parameters; all laws by default.

    Raises:
        InputError: there is no such parameter, or the first of a pair is not below the second.
    """
    if not ranges:
        return rig
    names = LAWS if laws is None else laws
    params = {q.name: q for law in names for q in rig.parameters(law_named(law))}
    by_label = {rig.label(q): q for q in params}
    stems = {stem(q.name): q for q in params.values()}
    chosen = {}
    for label, (low, high) in ranges.items():
        key = by_label.get(label, label)
        param = params.get(key) or stems.get(key)
        if param is None and laws is None:
            raise InputError(f"ranges: no law has a parameter {label!r}")
        if param is None:
            raise InputError(f"ranges: no parameter {label!r}: there are {', '.join(by_label)}")
        if not low < high:
            raise InputError(f"ranges: {label}: {low} is not below {high}")
        chosen[key] = (in_si(rig, param, low), in_si(rig, param, high))
        for end, written in zip(chosen[key], (low, high), strict=True):
            if fault := out_of_limits(end, *rig.limits(key)):
                raise InputError(f"ranges: {label}: an end is {written:g}: it {fault}")
    return replace(rig, ranges={**rig.ranges, **chosen}, bounded=rig.bounded | frozenset(chosen))
