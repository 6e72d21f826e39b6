"""A rotary axis that carries a weight, its torque measured: a pendulum, a joint of an arm."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..friction.law import POSITION
from ..space import Array, Param
from .balanced import BalancedRig, coefficients
from .equation import Equation
from .forced import FORCED_ROTARY
from .parts import part_named

if TYPE_CHECKING:
    from ..friction import Law


@dataclass(frozen=True, eq=False)
class ForcedPendulum(BalancedRig):
    """torque = J a + F_f(v) + g_sin sin q + g_cos cos q + offset.

    g_sin is m g l for a pendulum whose angle counts from where it hangs. Where the zero of the
    angle is known to be there, `g_cos` is best held at 0.
    """

    def columns_of(self, a: Array, loads: Array) -> Mapping[str, Array]:
        """As for every axis, and gravity's two."""
        q = loads[:, POSITION]
        return {**super().columns_of(a, loads), "g_sin": np.sin(q), "g_cos": np.cos(q)}

    def equation(self, law: Law) -> Equation:
        """A pendulum under a torque; F_f is friction."""
        del law
        return self.under_force(
            "M a = force − g_sin sin q − g_cos cos q − offset − F_f",
            lambda values: coefficients({**values, "J": 0.0}, part_named("load", "inertia")),
        )


FORCED_PENDULUM = ForcedPendulum(
    name="forced-pendulum",
    doc="a rotary axis with a weight on it whose drive torque was measured",
    cite=FORCED_ROTARY.cite,
    params=(
        *FORCED_ROTARY.params,
        Param("g_sin", -1e6, 1e6, "N m", "g_s", doc="gravity: torque that goes with sin q"),
        Param("g_cos", -1e6, 1e6, "N m", "g_c", doc="gravity: torque that goes with cos q"),
    ),
    laws=FORCED_ROTARY.laws,
    ranges=FORCED_ROTARY.ranges,
    shows=FORCED_ROTARY.shows,
    labels=FORCED_ROTARY.labels,
    rotary=True,
)
