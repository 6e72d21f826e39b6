"""The slide bed of `slide_bed.py` on a ramp, from event to event: no steps, no dead reckoning.

At rest nothing moves but the command, so that the instant at which a slip begins is solved for; in
a slip SciPy's implicit Runge-Kutta pair (Radau, order 5) integrates, and the ends of the pieces on
which the equation is smooth (rest, clamp, dead zone of the motor) are events that it locates.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

from .clock import Array
from .friction import Curve
from .slide_bed import Bed

#: How far a piece of a slip begins beyond the corner at which the one before ended, s.
PAST = 1e-9


class Ramp(NamedTuple):
    """A bed whose command leaves zero at t = 0; its constants of the motion to the right count."""

    bed: Bed
    curve: Curve
    speed: float

    def net(self, e: float, v: float) -> float:
        """Drive less friction, at a stretch and a speed."""
        motor = max(self.bed.k_hat_up * e - self.bed.F_fm, 0.0)
        F_S, F_C, F_V, v_SS = self.curve[:4]
        friction = F_C + (F_S - F_C) * np.exp(-v / v_SS) + F_V * v
        return float(motor + self.bed.k_spring_up * e - friction)

    def motor(self, e: float, v: float) -> float:
        """Force of the motor's inertia and damping, were there no clamp."""
        a = (self.net(e, v) - self.bed.K_D * v) / (self.bed.m + self.bed.K_J)
        return self.bed.K_J * a + self.bed.K_D * v

    def rates(self, t: float, state: Any, clamped: float) -> list[float]:
        """Velocity and acceleration in slip; the sign of the clamp in force, or 0."""
        x, v = state
        force = self.net(self.speed * t - x, v)
        if clamped != 0.0:
            return [v, (force - clamped * self.bed.F_m_max) / self.bed.m]
        return [v, (force - self.bed.K_D * v) / (self.bed.m + self.bed.K_J)]

    def corners(self) -> list[Any]:
        """Events: the stop, the clamp, the end of the dead zone of the motor."""
        zone = self.bed.F_fm / self.bed.k_hat_up

        def stop(_: float, y: Array, _clamped: float) -> float:
            return float(y[1] - self.bed.dv)

        def clamp(t: float, y: Array, _clamped: float) -> float:
            return abs(self.motor(self.speed * t - y[0], y[1])) - self.bed.F_m_max

        def bend(t: float, y: Array, _clamped: float) -> float:
            return float(self.speed * t - y[0] - zone)

        stop.direction = -1.0  # type: ignore[attr-defined]
        events: list[Any] = [stop, clamp, bend]
        for event in events:
            event.terminal = True
        return events


def ramp(bed: Bed, curve: Curve, speed: float, t: Array, dp: float) -> Array:
    """Positions at the times t, m, of a slide that rests at zero, along the motion.

    Args:
        bed: Constants.
        curve: Friction, with exponent 1.
        speed: Of the command, m/s, above zero.
        t: Times, s, increasing from 0.
        dp: The impulse that ends rest, N s.
    """
    on, stiff = Ramp(bed, curve, speed), bed.k_hat_up + bed.k_spring_up
    reach = (curve.F_S + bed.F_fm) / stiff  # the stretch at which the drive equals F_S
    wait = np.sqrt(2.0 * dp / (stiff * speed))  # stiff u wait^2 / 2 = dp
    positions, now, x = np.zeros(len(t)), 0.0, 0.0
    while True:
        begin = (x + reach) / speed + wait
        positions[(t >= now) & (t <= begin)] = x
        now, state, slips = begin, [x, bed.dv], True
        while slips:
            if now >= t[-1]:
                return positions
            pulled = on.motor(speed * now - state[0], state[1])
            clamped = float(np.sign(pulled)) if abs(pulled) > bed.F_m_max else 0.0
            piece = solve_ivp(
                on.rates, (now, t[-1] + 1.0), state, "Radau", dense_output=True,
                events=on.corners(), rtol=1e-9, atol=1e-12, args=(clamped,),
            )  # fmt: skip
            rows = (t >= now) & (t <= piece.t[-1])
            if rows.any():
                positions[rows] = piece.sol(t[rows])[0]  # type: ignore[misc]
            now, state = float(piece.t[-1]), [float(y) for y in piece.y[:, -1]]
            slips = len(piece.t_events[0]) == 0  # type: ignore[index]
            if slips:  # past the corner, so that its event is not met again
                v, a = on.rates(now, state, clamped)
                now, state = now + PAST, [state[0] + PAST * v, state[1] + PAST * a]
        x = state[0]
