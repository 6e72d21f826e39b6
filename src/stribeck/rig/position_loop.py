"""A sampled position controller around any axis with a mass."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..errors import InputError
from .controller import Controller
from .motion.axis_row import rows
from .motion.drives import (
    AXIS,
    FEED_FORWARD,
    GOAL,
    GOAL_VELOCITY,
    HELD,
    LATE,
)
from .motion.track import Track
from .parts import part_named
from .parts.axis_of_parts import assembled

if TYPE_CHECKING:
    from ..data.recording import Recording
    from ..friction import Law
    from ..space import Array, Param

#: The loop and what it moves.
_LOOP = (
    part_named("controller", "pd"),
    part_named("motor", "force"),
    part_named("load", "inertia"),
)
#: Way by which a step of a trial may be off, m and rad.
_TOLERANCE = 1e-9
#: What rigs call the mass, a constant force, and gravity's two.
_MASS, _OFFSET, _GRAVITY = ("M", "J"), ("offset", "g_0"), ("g_sin", "g_cos")


@dataclass(frozen=True)
class PositionLoop:
    """A proportional-derivative controller, sampled: what it computes is held for a sample.

    force = clip(kp (command − position) + kd (command's velocity − velocity), ±limit)

    A cascade of a position loop K_v and a velocity loop K_p is kp = K_v K_p, kd = K_p, with the
    derivative of the velocity alone.

    Args:
        kp: N/m or N m/rad.
        kd: N s/m or N m s/rad.
        period: Sample time, s.
        late: Whether the force acts a sample after the one that it is computed from.
        limit: Largest force, N or N m.
        error_derivative: Whether kd acts on the error's velocity, not on that of the axis alone.
    """

    kp: float
    kd: float = 0.0
    period: float = 1e-3
    late: bool = False
    limit: float = np.inf
    error_derivative: bool = True

    def controller(self, name: str, own: Callable[[Law], tuple[Param, ...]]) -> Controller:
        """The loop as the implicit stepper runs it, around an axis.

        Args:
            name: Of its rig.
            own: The rig's own parameters beside a law's.
        """

        def track(recording: Recording) -> Track:
            return goal_track(recording, with_velocity=self.error_derivative)

        def constants(law: Law, p: Array, track: Track) -> Array:
            del track
            values = dict(zip((q.name for q in own(law)), p[:, len(law.params) :].T, strict=True))
            mass = next((values[n] for n in _MASS if n in values), None)
            if mass is None:
                raise InputError(f"rig {name}: its card has no mass to close a loop around")
            constant = next((values[n] for n in _OFFSET if n in values), 0.0)
            g_sin, g_cos = (values.get(n, 0.0) for n in _GRAVITY)
            loop = assembled(
                _LOOP,
                {
                    "kp": self.kp, "kd": self.kd, "limit": self.limit, "J": mass, "g_sin": g_sin,
                    "g_cos": g_cos, "g_0": constant, "hold": LATE if self.late else HELD,
                },
            )  # fmt: skip
            return rows(loop, len(p))

        return Controller(AXIS, FEED_FORWARD, self.period, _TOLERANCE, track, constants)


def goal_track(recording: Recording, *, with_velocity: bool) -> Track:
    """The motion that a recording's position asks of a loop, with its velocity or without."""
    t, x = recording.t, recording.position
    inputs = np.zeros((FEED_FORWARD + 1, len(t)))
    inputs[GOAL] = x
    if with_velocity:
        inputs[GOAL_VELOCITY, :-1] = np.diff(x) / np.diff(t)
    return Track(
        t, x, t, float(x[0]), x, np.ones(len(t)), np.zeros((3, len(t) + 1)),
        inputs=inputs, held=np.array([0.0, 0.0, 1.0, 1.0, 1.0, 1.0]),
    )  # fmt: skip
