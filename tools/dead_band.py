"""What the dead band of rest does to the motion of the published sets, and the printed procedure.

A ramp of 5 mm/s from rest for 36.6 s, sampled at 100 Hz. First: the distance of the motions with
dp = (m + K_J) dv and with no dead band from that with dp = m dv. Then the printed procedure at a
step of 1 ms, with the position integrated after the velocity or before it, for F_S as published
and for 100 neighbours of it, a billionth apart.
"""

from __future__ import annotations

import numpy as np

from stribeck.friction import LAWS
from stribeck.report.table import Table
from stribeck.rig.motion import reference
from stribeck.rig.motion.command import Drive
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
    procedure, rows = reference.compiled("paper"), []
    for late, order in ((True, "v, then x"), (False, "x, then v")):
        for direction, sign in SIGN.items():
            on = ramp(sign)
            equation = motion(SLIDE_BED, direction, on)
            (p,), (c,) = SLIDE_BED.split(LAW, PUBLISHED[direction])
            away = []
            for k in range(NEIGHBOURS):
                p[0] = PUBLISHED[direction][0] * (1.0 + APART * (k - NEIGHBOURS // 2))
                x, _ = procedure(LAW.slip, p, c, on.knots_t, on.knots_x, on.t, on.x0, STEP, late)
                away.append(distance(equation, x))
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
