"""What the dead band of rest does to the motion of the published sets, and the printed procedure.

A ramp of 5 mm/s from rest for 36.6 s, sampled at 100 Hz. First: the distance of the motions with
dp = (m + K_J) dv and with no dead band from that with dp = m dv. Then the printed procedure at a
step of 1 ms, with the position integrated after the velocity or before it, for F_S as published
and for 100 neighbours of it, a billionth apart.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from stribeck.friction import LAWS
from stribeck.report.table import Table
from stribeck.rig.motion.command import Drive
from stribeck.rig.motion.drives import (
    CLAMP,
    DAMPING,
    F_FM,
    IMPULSE,
    INERTIA,
    K_HAT_M,
    K_HAT_P,
    K_SPRING_M,
    K_SPRING_P,
    MASS,
)
from stribeck.rig.motion.track import Track, track
from stribeck.rig.slide_bed import PUBLISHED, SLIDE_BED, SlideBed
from stribeck.space import Array

LAW = LAWS["stribeck"]
SECONDS, SPEED, STEP = 36.6, 5e-3, 1e-3
NEIGHBOURS, APART = 101, 1e-9
SIGN = {"right": 1, "left": -1}


def motion(rig: SlideBed, direction: str, on: Track) -> Array:
    """Positions, m."""
    position: Array = rig.move(LAW, PUBLISHED[direction][None], on).position[0]
    return position


def distance(x: Array, y: Array) -> float:
    """RMS, mm."""
    return 1e3 * float(np.sqrt(np.mean((x - y) ** 2)))


@njit  # type: ignore[untyped-decorator]
def printed(p: Array, c: Array, steps: int, dt: float, late: bool) -> Array:
    """Positions along a ramp by steps 1 to 5 of section 4.3, in their order; the first at 0.

    Args:
        p: F_S, F_C, F_V, v_SS.
        c: The constants of the slide bed, those of its rightward motion in force.
        steps: How many.
        dt: Their length, s.
        late: Whether the position is integrated after the velocity, with the new one.
    """
    x, v, a, P, positions = 0.0, 0.0, 0.0, 0.0, np.zeros(steps + 1)
    for i in range(steps):
        e = SPEED * i * dt - x
        F_motor = c[K_HAT_P] * e
        F_f_motor = min(max(F_motor, -c[F_FM]), c[F_FM])
        F_m_motor = min(max(c[INERTIA] * a + c[DAMPING] * v, -c[CLAMP]), c[CLAMP])
        F_in = F_motor - F_f_motor - F_m_motor + c[K_SPRING_P] * e
        if v == 0.0:
            F_f = min(max(F_in, -p[0]), p[0])
        else:
            F_f = (p[1] + (p[0] - p[1]) * np.exp(-abs(v) / p[3])) * np.sign(v) + p[2] * v
        P += (F_in - F_f) * dt
        v_next = 0.0 if abs(P) < c[IMPULSE] else P / c[MASS]
        x += (v_next if late else v) * dt
        v, a = v_next, (v_next - v) / dt
        positions[i + 1] = x
    return positions


def ramp(sign: int) -> Track:
    """The ramp to one side."""
    t = np.arange(round(100 * SECONDS) + 1) / 100
    return track(Drive.line(0.0, 0.0, SECONDS, sign * SPEED), t, 0.0)


def dead_bands() -> Table:
    """The motion by its dead band."""
    inertia = SLIDE_BED["K_kt"] * SLIDE_BED["J_m"]
    bands = {"(m + K_J) dv": (SLIDE_BED["m"] + inertia) * SLIDE_BED["dv"], "none": 0.0}
    rows = []
    for name, dp in bands.items():
        cells = [name, f"{1e3 * dp:.2f}"]
        for direction, sign in SIGN.items():
            moved = (
                motion(rig, direction, ramp(sign)) for rig in (SLIDE_BED, SLIDE_BED.set(dp=dp))
            )
            cells.append(f"{distance(*moved):.2f}")
        rows.append(cells)
    title = "Distance from the motion with dp = m dv = 1.09 mN s, RMS"
    return Table.of_texts(title, ("dp", "mN s", "right / mm", "left / mm"), rows)


def printed_procedure() -> Table:
    """The printed procedure by the order of its last statements, over neighbours of F_S."""
    rows = []
    for late, order in ((True, "v, then x"), (False, "x, then v")):
        for direction, sign in SIGN.items():
            right_motion = motion(SLIDE_BED, direction, ramp(sign))
            (p,), (c,) = SLIDE_BED.split(LAW, PUBLISHED[direction])
            if direction == "left":  # its mirror image
                c[[K_HAT_P, K_SPRING_P]] = c[[K_HAT_M, K_SPRING_M]]
            steps, each = round(SECONDS / STEP), round(0.01 / STEP)
            away = []
            for k in range(NEIGHBOURS):
                p[0] = PUBLISHED[direction][0] * (1.0 + APART * (k - NEIGHBOURS // 2))
                positions = printed(p, c, steps, STEP, late)[::each]
                away.append(distance(right_motion, sign * positions))
            quantiles = np.percentile(away, [10, 50, 90])
            rows.append(
                [order, direction, *(f"{x:.1f}" for x in (min(away), *quantiles, max(away)))]
            )
    title = f"The printed procedure at {1e3 * STEP:.0f} ms: RMS distance from that motion, mm"
    heads = ("order", "set", "least", "10 %", "median", "90 %", "most")
    return Table.of_texts(title, heads, rows, (0, 1))


def main() -> None:
    """Print both tables."""
    print(dead_bands().text().rstrip(), printed_procedure().text().rstrip(), sep="\n\n")


if __name__ == "__main__":
    main()
