"""Axes of parts under Coulomb and viscous friction, by plain small steps.

The equations are written out anew from the declarations of the parts, one after the other, and
stepped explicitly; Coulomb friction stops an axis within a step and holds what it can hold. Nothing
is shared with the stepper under test.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
GRAVITY = 9.80665


@dataclass
class Loop:
    """A controller and what it remembers.

    Args:
        kind: pd, damped, pwm, cascade or none.
        values: Coefficients by name.
        integral: What it has integrated of its demand.
        held: Demands of the last sample and of the one before.
    """

    kind: str
    values: dict[str, float]
    integral: float = 0.0
    held: list[float] = field(default_factory=list)

    def demand(self, wish: dict[str, float], q: float, v: float, fresh: bool) -> float:
        """What it asks for now; `fresh` at a sample of the log."""
        get, values = self.values.get, self.values
        if self.kind == "none":
            return wish["added"]
        e, w = wish["goal"] - q, wish.get("goal_velocity", 0.0)
        if self.kind == "pwm":
            demand = values["vin"] * values["duty"] * values["kp"] * e
        elif self.kind == "cascade":
            demand = values["kv"] * (values["kp"] * e - v)
        else:
            w = w if self.kind == "pd" else 0.0
            demand = get("gain_p", 1.0) * values["kp"] * e + get("kd", 0.0) * (w - v)
        limit = get("vin", get("limit", math.inf))
        if not get("hold", 0.0):
            return min(max(demand + wish.get("feed_forward", 0.0), -limit), limit)
        if fresh:
            self.integral += get("ki", 0.0) * get("T", 0.0) * demand
            now = min(max(demand + self.integral, -limit), limit)
            self.held = [now, self.held[0] if self.held else now]
        return self.held[0] if values["hold"] == 1.0 else self.held[1]


def motor(values: dict[str, float], kind: str, ratio: float, demand: float, v: float) -> float:
    """The motor's force at the load, after its limits, its friction and the gear's losses."""
    get = values.get
    if kind == "force":
        force, most = ratio * demand, ratio * get("F_max", math.inf)
    else:
        per_ampere = ratio * values["k_t"]
        current = (demand - per_ampere * v) / values["R"] if kind == "voltage" else demand
        force, most = per_ampere * current, per_ampere * get("I_max", math.inf)
    force = min(max(force, -most), most)
    force = math.copysign(max(abs(force) - get("F_fm", 0.0), 0.0), force)
    if force * v < 0.0:
        return force / get("eta_back", 1.0)
    return force * get("eta", 1.0)


def load(values: dict[str, float], q: float) -> float:
    """What acts on the load beside the motor and friction."""
    get = values.get
    force = -get("offset", 0.0) - get("g_0", 0.0)
    force -= get("g_sin", 0.0) * math.sin(q) + get("g_cos", 0.0) * math.cos(q)
    force -= get("k_spring", 0.0) * (q - get("q_spring", 0.0))
    if "rip_period" in values:
        x = 2 * math.pi * q / values["rip_period"]
        for k, name in ((1, ""), (2, "2")):
            force -= get(f"rip_cos{name}", 0.0) * math.cos(k * x)
            force -= get(f"rip_sin{name}", 0.0) * math.sin(k * x)
    if "l" in values:
        weight = (values["m"] + get("m_arm", 0.0) / 2) * GRAVITY * values["l"]
        force -= weight * math.sin(q + get("q_offset", 0.0))
    return force


def cogging(values: dict[str, float], ratio: float, q: float) -> float:
    """The motor's own, as a force on the load."""
    turn = values.get("cog_order", 0.0) * ratio * q
    wave = values.get("cog_cos", 0.0) * math.cos(turn) + values.get("cog_sin", 0.0) * math.sin(turn)
    return -ratio * wave


def uneven(values: dict[str, float], q: float) -> tuple[float, float]:
    """Position of the motor at one of the load, and its derivative by a difference."""
    if "err_period" not in values:
        return q, 1.0

    def way(q: float) -> float:
        x = 2 * math.pi * q / values["err_period"]
        error = values.get("err_cos", 0.0) * math.cos(x) + values.get("err_sin", 0.0) * math.sin(x)
        return q - error

    h = 1e-5 * values["err_period"]
    return way(q), (way(q + h) - way(q - h)) / (2 * h)


def inertia(values: dict[str, float], ratio: float) -> float:
    """All that moves, at the load."""
    get = values.get
    total = get("M", 0.0) + get("J", 0.0) + get("armature", 0.0) * ratio * ratio
    if "l" in values:
        total += (values["m"] + get("m_arm", 0.0) / 3) * values["l"] ** 2
    return total


def simulate(
    values: dict[str, float], t: Array, inputs: dict[str, Array], controller: str, kind: str,
    sub: int,
) -> Array:  # fmt: skip
    """Positions at the samples, (N,), from rest at 0.

    Args:
        values: Coefficients of all parts and F_C, F_V of the friction, by name.
        t: Samples, (N,).
        inputs: (N,) by name; linear between samples, `enabled` held.
        controller: Its part's name.
        kind: The motor's.
        sub: Steps from sample to sample.
    """
    q, v, out = 0.0, 0.0, np.empty(len(t))
    ratio = 2 * math.pi / values["lead"] if "lead" in values else values.get("gear_ratio", 1.0)
    M, loop = inertia(values, ratio), Loop(controller, values)
    for k in range(len(t)):
        out[k] = q
        if k + 1 == len(t):
            break
        h = (t[k + 1] - t[k]) / sub
        rows = {n: (float(x[k]), float(x[k + 1])) for n, x in inputs.items()}
        for i in range(sub):
            wish = {n: a + (i / sub) * (b - a) for n, (a, b) in rows.items()}
            q_m, share = uneven(values, q)
            demand = loop.demand(wish, q_m, share * v, i == 0)
            force = share * motor(values, kind, ratio, demand, share * v)
            if rows.get("enabled", (1.0, 1.0))[0] < 0.5:
                force = 0.0
            total = force + load(values, q) + cogging(values, ratio, q)
            total += wish.get("external", 0.0) - values["F_V"] * v
            free, stop = v + h * total / M, h * values["F_C"] / M
            v = 0.0 if abs(free) <= stop else free - math.copysign(stop, free)
            q += h * v
    return out
