"""What rubs: friction laws, each one declaration. A new law is a file and its name in LAWS."""

from collections.abc import Callable
from functools import cache
from typing import cast

from ..errors import InputError
from .bam import BAM_M1, BAM_M2, BAM_M3, BAM_M4, BAM_M5, BAM_M6
from .coulomb import COULOMB_VISCOUS, COULOMB_VISCOUS_DIRECTIONAL
from .dahl import DAHL
from .elasto_plastic import ELASTO_PLASTIC
from .gms import GMS, gms
from .karnopp import KARNOPP, KARNOPP_DIRECTIONAL
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
from .load import COULOMB_LOAD
from .lugre import LUGRE
from .makkar import MAKKAR, MAKKAR_DIRECTIONAL
from .maxwell import MAXWELL_SLIP, maxwell_slip
from .rational import STRIBECK_RATIONAL, STRIBECK_RATIONAL_DIRECTIONAL
from .smooth import STRIBECK_SMOOTH, STRIBECK_SMOOTH_DIRECTIONAL
from .stribeck import (
    STRIBECK,
    STRIBECK_DIRECTIONAL,
    STRIBECK_FREE,
    STRIBECK_FREE_DIRECTIONAL,
    STRIBECK_GAUSS,
    STRIBECK_GAUSS_DIRECTIONAL,
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

LAWS: dict[str, Law] = {
    law.name: law
    for law in (
        COULOMB_VISCOUS,
        COULOMB_VISCOUS_DIRECTIONAL,
        COULOMB_LOAD,
        STRIBECK,
        STRIBECK_DIRECTIONAL,
        STRIBECK_GAUSS,
        STRIBECK_GAUSS_DIRECTIONAL,
        STRIBECK_FREE,
        STRIBECK_FREE_DIRECTIONAL,
        STRIBECK_RATIONAL,
        STRIBECK_RATIONAL_DIRECTIONAL,
        STRIBECK_SMOOTH,
        STRIBECK_SMOOTH_DIRECTIONAL,
        MAKKAR,
        MAKKAR_DIRECTIONAL,
        KARNOPP,
        KARNOPP_DIRECTIONAL,
        DAHL,
        LUGRE,
        ELASTO_PLASTIC,
        MAXWELL_SLIP,
        GMS,
        BAM_M1,
        BAM_M2,
        BAM_M3,
        BAM_M4,
        BAM_M5,
        BAM_M6,
    )
}

#: Laws of as many elements as their name says, after a colon: `maxwell-slip:6`.
ELEMENTS: dict[str, Callable[[int], Law]] = {"maxwell-slip": maxwell_slip, "gms": gms}
_MOST_ELEMENTS = 20


@cache
def law_named(name: str) -> Law:
    """A law by its name: `stribeck`, `maxwell-slip:6` (elements), `stribeck+temperature` (terms).

    Raises:
        InputError: there is no such law or term, or it cannot have so many elements.
    """
    whole, *terms = name.split("+")
    stem, colon, count = whole.partition(":")
    if stem not in LAWS:
        raise InputError(f"no law {stem!r}: there are {', '.join(LAWS)}")
    law = _of_elements(stem, count) if colon else LAWS[stem]
    for term in terms:
        law = law.with_term(cast("Term", term))
    return law


def _of_elements(stem: str, count: str) -> Law:
    """A law with a number of elements of the user's choice."""
    if stem not in ELEMENTS:
        raise InputError(
            f"law {stem}:{count}: only {', '.join(ELEMENTS)} have a number of elements"
        )
    if not (count.isascii() and count.isdigit() and 1 <= int(count) <= _MOST_ELEMENTS):
        raise InputError(
            f"law {stem}:{count}: the number of elements goes from 1 to {_MOST_ELEMENTS}, "
            f"as in {stem}:6"
        )
    return ELEMENTS[stem](int(count))
