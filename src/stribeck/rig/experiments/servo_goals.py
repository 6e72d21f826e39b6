"""Goals of a pendulum on a position-controlled servo."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...space import Array
from .offer import Course, Offer, OperatingRange, clock

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping


def servo_goals(
    axis: OperatingRange, run: Mapping[str, float], gravity: float, seconds: float
) -> Iterator[Offer]:
    """Sines, a chirp, other gains, a dropped and a heavier pendulum.

    Args:
        axis: The axis.
        run: Mass, length, gain and supply voltage of the first log, by their columns.
        gravity: m/s^2.
        seconds: How long each takes.
    """
    reach = 0.5 * (axis.high - axis.low)
    middle = 0.5 * (axis.high + axis.low)
    period = max(2 * np.pi * reach / axis.pace, 2.0)
    t = clock(axis, seconds)
    sine = middle + reach * np.sin(2 * np.pi * t / period)
    slow = middle + reach * np.sin(2 * np.pi * t / (4 * period))

    def offer(name: str, words: str, command: Array, **extra: float | Array) -> Offer:
        return Offer(name, words, [Course(t, command, {**run, **extra})])

    sine_text = f"a sine of ±{axis.place(reach)} about {axis.place(middle)}"
    yield offer("slow sine", f"{sine_text}, {4 * period:.2g} s a turn", slow)
    yield offer("sine", f"{sine_text}, {period:.2g} s a turn", sine)
    for times in (0.25, 4.0):
        kp = times * run["kp"]
        yield offer(f"gain × {times:g}", f"{sine_text}, {period:.2g} s a turn, at kp = {kp:.4g}",
                    sine, kp=kp)  # fmt: skip
    sweep = np.sin(2 * np.pi * (0.2 * t + 0.9 * t**2 / seconds))
    yield offer("chirp", f"a sine of ±{axis.place(0.5 * reach)} about {axis.place(middle)} that "
                "goes from 0.2 to 2 Hz", middle + 0.5 * reach * sweep)  # fmt: skip
    turn = t % 6.0
    lifted = middle + reach * np.clip(turn / 2.0, 0.0, 1.0)
    yield offer(
        "lift and drop",
        f"lift to {axis.place(middle + reach)} within 2 s, hold for 1 s, switch the torque off for "
        "3 s, and again",
        lifted,
        torque_enable=(turn < 3.0).astype(float),  # noqa: PLR2004 - lifted and held
    )
    mass, weight = 2 * run["mass"], gravity * run["length"]
    stall = axis.values["k_t"] * run["vin"] / axis.values["R"]
    if mass * weight > 0.8 * stall:
        refusal = f"{mass:.3g} kg is more than the servo can lift well"
        yield Offer("more mass", "", refusal=refusal)
    else:
        yield offer("more mass", f"{sine_text}, {period:.2g} s a turn, with {mass:.3g} kg", sine,
                    mass=mass)  # fmt: skip
