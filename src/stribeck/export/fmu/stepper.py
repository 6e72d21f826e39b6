"""The constants of the stepper, as its C reads them: those of `rig.motion`, by the names there."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from ...rig.motion import explicit_step, implicit, passage, velocity

#: By the module that says what they are for.
_CONSTANTS = {
    passage: (
        "FINEST", "STIFF", "FAST", "SWING", "GROW", "GROW_DAMPED", "CLOSE", "LOOKS", "STOPS",
        "INSTANT", "_NONE",
    ),
    explicit_step: ("MILD", "DISTINCT", "SURE"),
    implicit: ("ROOM", "EACH", "_SHORT", "_DOUBLINGS", "_LONG", "_SLOW"),
    velocity: ("_MOST", "_FINE", "_FEW", "_NEAR", "_SAME", "_NOISE"),
}  # fmt: skip

#: By their names in C. The looks for a breakaway have a name of their own: MOST is that of roots.
STEPPER: Mapping[str, float] = MappingProxyType(
    {
        **{n.lstrip("_"): getattr(m, n) for m, names in _CONSTANTS.items() for n in names},
        "INSTANTS": passage.MOST,
    }
)
