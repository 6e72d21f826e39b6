"""A pneumatic or hydraulic cylinder driven by the pressures in its two chambers."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ..constant import SMALLEST, constant
from ..data.filtering import Filtering
from ..errors import InputError
from ..friction.law import NORMAL
from ..space import Array, Param
from .balanced import BalancedRig, coefficients
from .cylinder import PER_BAR
from .equation import Equation, Input
from .forced import FORCED
from .motion.drives import NORMAL_LOAD

if TYPE_CHECKING:
    from ..data.recording import Recording
    from ..friction import Law


@dataclass(frozen=True, eq=False)
class TwoChambers(BalancedRig):
    """p A - p_b (A - A_r) = M a + F_f(v; p - p_b) + offset, A = pi bore^2/4, A_r = pi rod^2/4.

    p is the gauge pressure that drives the rod out, the way in which the position grows, p_b that
    of the chamber with the rod in it. The load of a law is the difference of the two, Pa, which is
    what presses a piston's seal on: its `mu` is an area.
    """

    @property
    def areas(self) -> tuple[float, float]:
        """Areas that the two pressures act on, m^2.

        Raises:
            InputError: the rod is as wide as the bore.
        """
        if not 0.0 <= self["rod"] < self["bore"]:
            raise InputError(
                f"rig {self.name}: rod = {1e3 * self['rod']:g} mm: it is thinner than the bore, "
                f"{1e3 * self['bore']:g} mm, and 0 where a rod goes through both chambers"
            )
        whole = float(np.pi / 4 * self["bore"] ** 2)
        return whole, whole - float(np.pi / 4 * self["rod"] ** 2)

    def measured(self, recording: Recording) -> Array:
        """The force of both pressures on the rod, N, (N,).

        Raises:
            InputError: the log lacks a pressure, or its position is an angle.
        """
        self.check_turning(recording)
        pressure, back = self._pressures(recording)
        whole, ring = self.areas
        return np.asarray(whole * pressure - ring * back)

    def load_rows(self, law: Law, recording: Recording, t: Array, position: Array) -> Array:
        """As for every axis, with the difference of the pressures as the normal load."""
        rows = super().load_rows(law, recording, t, position)
        pressure, back = self._pressures(recording)
        rows[:, NORMAL] = np.interp(t, recording.t, pressure - back)
        return rows

    def equation(self, law: Law) -> Equation:
        """The rod under the force of both pressures; F_f is friction."""
        del law
        return self.under_force(
            "M a = force − offset − F_f,  force = p π bore²/4 − p_b π (bore² − rod²)/4",
            coefficients,
            Input("pressure", "Pa", "difference of the two pressures", NORMAL_LOAD),
            constants=("bore", "rod"),
        )

    def _pressures(self, recording: Recording) -> tuple[Array, Array]:
        pressure, back = recording.pressure, recording.back_pressure
        if pressure is None or back is None:
            lacks = "pressure" if pressure is None else "back_pressure"
            raise InputError(
                f"{recording.label}: rig {self.name} needs the pressures in both chambers: map a "
                f'column to {lacks}, as in {lacks} = "p [bar]"'
            )
        return pressure, back

    def _ranged(self, param: Param) -> Param:
        """Friction per unit of pressure is an area."""
        ranged = super()._ranged(param)
        return replace(ranged, unit="m**2") if param.name == "mu" else ranged


#: Where the sizes that it comes with are from.
_OWN = "a choice: set your own"

TWO_CHAMBERS = TwoChambers(
    name="two-chambers",
    doc="a pneumatic or hydraulic cylinder whose two chamber pressures were measured",
    cite=FORCED.cite,
    scale="the areas of the piston",
    constants=(
        constant("bore", 25.0, "mm", "diameter of the piston", _OWN, "example", least=SMALLEST),
        constant(
            "rod",
            10.0,
            "mm",
            "diameter of the rod, in the chamber of p_b",
            _OWN,
            "example",
            least=0.0,
        ),
    ),
    params=FORCED.params,
    laws=("coulomb-load", *FORCED.laws),
    ranges={**FORCED.ranges, "mu": (0.0, 1000 * PER_BAR)},
    shows={**FORCED.shows, "mu": "N/bar"},
    labels={"mu": "mu_p"},
    loads=(*FORCED.loads, "normal"),
    filtering=Filtering(slowest=1e-3),
)
