"""What rubs: friction laws, each one declaration. A new law is a file and its name in LAWS."""

from functools import cache
from typing import cast

from ..errors import InputError
from .coulomb import COULOMB_VISCOUS, COULOMB_VISCOUS_DIRECTIONAL
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
from .stribeck import STRIBECK, STRIBECK_DIRECTIONAL

__all__ = [
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
        STRIBECK,
        STRIBECK_DIRECTIONAL,
    )
}


@cache
def law_named(name: str) -> Law:
    """A shipped law by its name, with terms after a plus: `stribeck+temperature`.

    Raises:
        InputError: there is no such law or term.
    """
    stem, *terms = name.split("+")
    if stem not in LAWS:
        raise InputError(f"no law {stem!r}: there are {', '.join(LAWS)}")
    law = LAWS[stem]
    for term in terms:
        law = law.with_term(cast("Term", term))
    return law
