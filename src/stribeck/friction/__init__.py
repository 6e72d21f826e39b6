"""What rubs: friction laws, each one declaration. A new law is a file and its name in LAWS."""

from .coulomb import COULOMB_VISCOUS, COULOMB_VISCOUS_DIRECTIONAL
from .law import SLIP_TYPE, Law, addressed, friction, slip_law, stick
from .stribeck import STRIBECK, STRIBECK_DIRECTIONAL

__all__ = ["LAWS", "SLIP_TYPE", "Law", "addressed", "friction", "slip_law", "stick"]

LAWS: dict[str, Law] = {
    law.name: law
    for law in (
        COULOMB_VISCOUS,
        COULOMB_VISCOUS_DIRECTIONAL,
        STRIBECK,
        STRIBECK_DIRECTIONAL,
    )
}
