"""Friction laws, each one declaration. A new law is a file and its name in `_FILES`."""

from collections.abc import Callable, Iterator, Mapping
from functools import cache
from importlib import import_module
from types import MappingProxyType
from typing import Any, cast

from ..errors import InputError
from .law import (
    LOADS,
    RUB_SIGNATURE,
    RUB_TYPE,
    SLIP_TYPE,
    TERMS,
    Law,
    Term,
    addressed,
    friction,
    rub_law,
    slip_law,
    stick,
)

__all__ = [
    "ELEMENTS",
    "LAWS",
    "LOADS",
    "RUB_SIGNATURE",
    "RUB_TYPE",
    "SLIP_TYPE",
    "TERMS",
    "Law",
    "addressed",
    "friction",
    "law_named",
    "rub_law",
    "slip_law",
    "stick",
]

#: Every shipped law, in the order in which people see them, and the file that declares it under
#: the same name in capitals.
_FILES = {
    "coulomb-viscous": "coulomb",
    "coulomb-viscous-directional": "coulomb",
    "coulomb-load": "load",
    "coulomb-viscous-temperature": "temperature",
    "stribeck": "stribeck",
    "stribeck-directional": "stribeck",
    "stribeck-temperature": "temperature",
    "stribeck-gauss": "stribeck",
    "stribeck-gauss-directional": "stribeck",
    "stribeck-free": "stribeck",
    "stribeck-free-directional": "stribeck",
    "stribeck-rational": "rational",
    "stribeck-rational-directional": "rational",
    "stribeck-smooth": "smooth",
    "stribeck-smooth-directional": "smooth",
    "makkar": "makkar",
    "makkar-directional": "makkar",
    "karnopp": "karnopp",
    "karnopp-directional": "karnopp",
    "curve": "curve",
    "curve-directional": "curve",
    "dahl": "dahl",
    "lugre": "lugre",
    "lugre-film": "film",
    "elasto-plastic": "elasto_plastic",
    "armstrong": "armstrong",
    "maxwell-slip": "maxwell",
    "gms": "gms",
    "gms-damped": "gms",
    "bam-m1": "bam",
    "bam-m2": "bam",
    "bam-m3": "bam",
    "bam-m4": "bam",
    "bam-m5": "bam",
    "bam-m6": "bam",
}

#: Laws of as many elements or knots as their name says, after a colon, and how few and how many
#: of them: `maxwell-slip:6`.
ELEMENTS: Mapping[str, tuple[str, int, int]] = MappingProxyType(
    {
        "maxwell-slip": ("elements", 1, 20),
        "gms": ("elements", 1, 20),
        "gms-damped": ("elements", 1, 20),
        "curve": ("knots", 3, 40),
        "curve-directional": ("knots", 3, 40),
    }
)


class Laws(Mapping[str, Law]):
    """The shipped laws by name. A law is loaded when it is asked for: compiled ones take time."""

    def __getitem__(self, name: str) -> Law:
        law: Law = _declared(name, name.upper())
        return law

    def __iter__(self) -> Iterator[str]:
        return iter(_FILES)

    def __len__(self) -> int:
        return len(_FILES)

    def __contains__(self, name: object) -> bool:
        return name in _FILES


LAWS = Laws()


@cache
def law_named(name: str) -> Law:
    """A law by its name: `stribeck`, `maxwell-slip:6` (elements), `stribeck+position:2` (terms).

    Raises:
        InputError: there is no such law or term, or it cannot have so many elements.
    """
    stem_name, *terms = name.split("+")
    stem, colon, count = stem_name.partition(":")
    if stem not in LAWS:
        raise InputError(f"no law {stem!r}: there are {', '.join(LAWS)}")
    law = _of_elements(stem, count) if colon else LAWS[stem]
    for term in terms:
        term_name, colon, count = term.partition(":")
        if colon and not (count.isdecimal() and len(count) == 1):
            raise InputError(f"law {name}: {count!r} is no number of harmonics")
        law = law.with_term(cast("Term", term_name), int(count) if colon else 1)
    return law


def _of_elements(stem: str, count: str) -> Law:
    """A law with a number of elements or knots of the user's choice."""
    if stem not in ELEMENTS:
        raise InputError(f"law {stem}:{count}: only {', '.join(ELEMENTS)} have a number")
    parts, fewest, most = ELEMENTS[stem]
    if count not in map(str, range(fewest, most + 1)):
        raise InputError(
            f"law {stem}:{count}: the number of {parts} goes from {fewest} to {most}, "
            f"as in {stem}:6"
        )
    factory: Callable[[int], Law] = _declared(stem, stem)
    return factory(int(count))


def _declared(law: str, name: str) -> Any:
    """What the file of a law declares under a name."""
    return getattr(import_module(f".{_FILES[law]}", __name__), name.replace("-", "_"))
