"""Any axis whose drive force was measured: friction is what the force balance leaves."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numba import float64, njit, types

from ..data.filtering import Filtering
from ..errors import InputError
from ..friction import SLIP_TYPE
from ..space import Array, Param
from .rig import Rig

if TYPE_CHECKING:
    from ..data.recording import Recording
    from ..friction import Law

_F1 = types.Array(float64, 1, "C", readonly=True)


@dataclass(frozen=True, eq=False)
class Forced(Rig):
    """force = M a + F_f(v) + offset, with the measured force of the drive.

    A direction-dependent law has a level of its own for each direction, which makes a constant
    offset redundant: the rig drops it there.

    Args:
        filtering: How its logs are made ready for the balance.
    """

    filtering: Filtering = field(default_factory=Filtering)

    def own(self, law: Law) -> tuple[Param, ...]:
        """M and offset; M alone under a law with parameters for each direction."""
        mass, offset = self.params
        return (mass,) if law.directional else (mass, offset)

    def measured(self, recording: Recording) -> Array:
        """The force of the drive in a log, N (N m), (N,).

        Raises:
            InputError: it has none, or its position is an angle where this axis is linear, or
                the other way round.
        """
        if recording.rotary != self.rotary:
            kinds = ("an angle", "linear") if recording.rotary else ("a length", "rotary")
            raise InputError(
                f"{recording.label}: position is {kinds[0]}, and rig {self.name} is {kinds[1]}: "
                "use the rig that fits the axis"
            )
        if recording.force is None:
            raise InputError(
                f"{recording.label}: rig {self.name} needs the measured force of the drive: "
                "map a column to force"
            )
        return recording.force

    def force(self, law: Law, p: Array, v: Array, a: Array) -> Array:
        """The drive force that a motion takes, N (N m), (N,).

        Args:
            law: The friction law.
            p: (k,) the law's parameters, then the rig's own.
            v: Velocity, (N,); at exactly zero the friction is midway between its two levels.
            a: Acceleration, (N,).
        """
        k = len(law.params)
        mass, offset = p[k], (0.0 if law.directional else p[k + 1])
        balance: Array = mass * a + self.friction(law, p, v) + offset
        return balance

    def friction(self, law: Law, p: Array, v: Array) -> Array:
        """The friction in it, as for `force`, (N,)."""
        p = np.ascontiguousarray(p[: len(law.params)], dtype=float)
        rub: Array = slips(law.slip, np.ascontiguousarray(v, dtype=float), p)
        return rub


@njit(float64[::1](SLIP_TYPE, _F1, _F1), cache=True, error_model="numpy")
def slips(slip: Any, v: Array, p: Array) -> Array:
    """Slip friction over speeds; at exactly zero, midway between the two breakaway levels."""
    rest = 0.5 * (slip(0.0, p) + slip(-0.0, p))
    out = np.empty(len(v))
    for i in range(len(v)):
        out[i] = rest if v[i] == 0.0 else slip(v[i], p)
    return out


#: Wide enough for a press and for a finger joint: least squares needs no narrow box.
_RANGES = {
    "F_S": (0.0, 1e6),
    "F_C": (0.0, 1e6),
    "F_V": (0.0, 1e7),
    "v_SS": (1e-5, 1.0),
}

FORCED = Forced(
    name="forced",
    road="inverse",
    doc="any linear axis whose drive force was measured",
    cite="Newton's second law",
    params=(
        Param("M", 0.0, 1e6, "kg", "M", doc="moving mass"),
        Param("offset", -1e6, 1e6, "N", "F_0", doc="constant force: weight, sensor offset"),
    ),
    laws=(
        "coulomb-viscous",
        "coulomb-viscous-directional",
        "stribeck",
        "stribeck-directional",
    ),
    ranges=_RANGES,
    shows={"position": "mm", "velocity": "mm/s", "v_SS": "mm/s"},
)

FORCED_ROTARY = Forced(
    name="forced-rotary",
    road="inverse",
    doc="any rotary axis whose drive torque was measured",
    cite=FORCED.cite,
    params=(
        Param("M", 0.0, 1e6, "kg m**2", "J", doc="moment of inertia about the axis"),
        Param("offset", -1e6, 1e6, "N m", "T_0", doc="constant torque: sensor offset"),
    ),
    laws=FORCED.laws,
    ranges=_RANGES | {"v_SS": (1e-4, 10.0)},
    shows={"position": "deg", "velocity": "deg/s", "v_SS": "deg/s"},
    labels={"M": "J"},
    rotary=True,
)
