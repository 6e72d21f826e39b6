"""A pneumatic or hydraulic cylinder: the pressure drives it, and presses its seals on as well."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ..constant import SMALLEST, constant
from ..data.filtering import Filtering
from ..errors import InputError
from ..friction.law import NORMAL
from ..space import Array, Param
from .balanced import BalancedRig, coefficients
from .equation import Equation, Input
from .forced import FORCED
from .motion.drives import NORMAL_LOAD
from .motion.part_call import Row
from .parts import Coefficient, Part

if TYPE_CHECKING:
    from ..data.recording import Recording
    from ..friction import Law

#: Speeds below this share of the fastest tenth are a reversal, not a stroke.
_STROKE = 0.1
#: Samples each way over which the speed of a stroke is taken.
_REACH = 10


@dataclass(frozen=True, eq=False)
class Cylinder(BalancedRig):
    """F - p A = M a + F_f(v; p) + b p + offset, A = pi bore^2 / 4.

    F is the force of the rod, positive the way in which the position grows, p the gauge pressure
    that opposes it. The load of a law is the pressure, Pa, so that its `mu` is an area: friction
    per unit of pressure. b p is the share of the pressure's force that A does not have: a bore, a
    rod or a gauge that is a little off, or a seal that rubs more one way than the other.
    """

    @property
    def area(self) -> float:
        """Area of the piston, m^2."""
        return float(np.pi / 4 * self["bore"] ** 2)

    def measured(self, recording: Recording) -> Array:
        """The measured force without the pressure's, N, (N,).

        Raises:
            InputError: the log lacks force or pressure, or its position is an angle.
        """
        return super().measured(recording) - self.area * self._pressure(recording)

    def load_rows(self, law: Law, recording: Recording, t: Array, position: Array) -> Array:
        """As for every axis, with the pressure as the normal load."""
        rows = super().load_rows(law, recording, t, position)
        rows[:, NORMAL] = np.interp(t, recording.t, self._pressure(recording))
        return rows

    def columns_of(self, a: Array, loads: Array) -> Mapping[str, Array]:
        """As for every axis, and the pressure."""
        return {**super().columns_of(a, loads), "b": loads[:, NORMAL]}

    def figures(self, recording: Recording) -> Mapping[str, float]:
        """The friction range of a log that moves both ways."""
        try:
            return {"friction_range_N": self.friction_range(recording)}
        except InputError:
            return {}

    def friction_range(self, recording: Recording) -> float:
        """Mean friction of the strokes out less that of the strokes back, N.

        That is twice the friction if it is the same both ways, whatever offset the sensors have.
        Velocity is a central difference over 10 samples each way, and samples slower than a tenth
        of the stroke are left out.

        Raises:
            InputError: the log lacks force or pressure, or moves one way only.
        """
        t, x, rub = recording.t, recording.position, self.measured(recording)
        n = min(_REACH, (len(x) - 1) // 2)
        v = (x[2 * n :] - x[: -2 * n]) / (t[2 * n :] - t[: -2 * n])
        slowest = _STROKE * float(np.quantile(np.abs(v), 0.9))
        out, inward = (rub[n:-n][sign * v > slowest] for sign in (1, -1))
        if not (len(out) and len(inward)):
            raise InputError(f"{recording.label}: a friction range needs strokes both ways")
        return float(out.mean() - inward.mean())

    def equation(self, law: Law) -> Equation:
        """The rod under its force and the pressure; F_f is friction."""
        del law
        pressure = Input("pressure", "Pa", "gauge pressure against the rod's force", NORMAL_LOAD)
        return self.under_force(
            "M a = force − (π bore²/4 + b) pressure − offset − F_f",
            lambda values: coefficients(values, _PISTON),
            pressure,
            constants=("bore",),
        )

    def _pressure(self, recording: Recording) -> Array:
        if recording.pressure is None:
            raise InputError(
                f"{recording.label}: rig {self.name} needs the pressure in the cylinder: map a "
                'column to pressure, as in pressure = "p [bar]"'
            )
        return recording.pressure

    def _ranged(self, param: Param) -> Param:
        """Friction per unit of pressure is an area."""
        ranged = super()._ranged(param)
        return replace(ranged, unit="m**2") if param.name == "mu" else ranged


def _piston(force: float, q: float, v: float, u: Row, c: Row, slope: Row) -> float:
    """Less the pressure's force on the area c[0]."""
    return force - c[0] * u[NORMAL_LOAD]


_PISTON = Part(
    name="piston",
    role="load",
    doc="the pressure against the rod's force",
    equation="− (π bore²/4 + b) pressure",
    coefficients=(
        Coefficient("bore", "m", "diameter of the piston"),
        Coefficient("b", "m**2", "area that the bore leaves out", 0.0),
    ),
    function=_piston,
    constants=lambda values: (np.pi / 4 * values["bore"] ** 2 + values["b"],),
    slot="load",
)

#: 1 N/bar, m^2.
PER_BAR = 1e-5

CYLINDER = Cylinder(
    name="cylinder",
    doc="a pneumatic or hydraulic cylinder whose rod force and pressure were measured",
    cite=FORCED.cite,
    scale="the measured force (mu and b to that over the measured pressure)",
    constants=(
        constant(
            "bore",
            25.0,
            "mm",
            "diameter of the piston",
            "a choice: set your own",
            "example",
            least=SMALLEST,
        ),
    ),
    params=(
        *FORCED.params,
        Param(
            "b",
            -1000 * PER_BAR,
            1000 * PER_BAR,
            "m**2",
            "b",
            doc="force per unit of pressure that the bore leaves out",
        ),
    ),
    laws=("coulomb-load", *FORCED.laws),
    ranges={**FORCED.ranges, "mu": (0.0, 1000 * PER_BAR)},
    shows={**FORCED.shows, "mu": "N/bar", "b": "N/bar"},
    labels={"mu": "mu_p"},
    loads=(*FORCED.loads, "normal"),
    filtering=Filtering(slowest=1e-3),
)
