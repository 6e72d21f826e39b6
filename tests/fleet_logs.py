"""Logs of axes with friction, from a formula of motion: no simulator of the package has a part."""

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

#: Of the axes: Coulomb friction N, viscous friction N s/m, mass kg.
TRUE = {"F_C": 12.0, "F_V": 30.0, "m": 4.0}
#: Noise of the force, N.
NOISE = 0.3


def force_log(
    file: Path, seed: int = 0, *, seconds: float = 6.0, rate: float = 200.0, **true: float
) -> None:
    """A log of x = 0.05 m sin(t) + 0.02 m sin(3 t), with the force that this takes, in a file."""
    p = TRUE | true
    t = np.arange(0.0, seconds, 1.0 / rate)
    position = 0.05 * np.sin(t) + 0.02 * np.sin(3 * t)
    velocity = 0.05 * np.cos(t) + 0.06 * np.cos(3 * t)
    acceleration = -0.05 * np.sin(t) - 0.18 * np.sin(3 * t)
    force = p["m"] * acceleration + p["F_C"] * np.sign(velocity) + p["F_V"] * velocity
    force += NOISE * np.random.default_rng(seed).standard_normal(len(t))
    table = np.column_stack([t, position, velocity, force])
    np.savetxt(
        file, table, fmt="%.7g", delimiter=",", comments="",
        header="t [s],x [m],v [m/s],force [N]",
    )  # fmt: skip


def bad_log(file: Path, kind: int) -> None:
    """A log that no identification can use: empty, no table, one row, no force, or not there."""
    texts = [
        "",
        "this is no log\n",
        "t [s],x [m],force [N]\n0,0,0\n",
        "t [s],x [m]\n0,0\n0.1,0.1\n0.2,0.2\n",
    ]
    if kind % 5 < len(texts):
        file.write_text(texts[kind % 5], encoding="utf-8")


def simulated_fleet(folder: Path, axes: int, *, bad: float = 0.2) -> Iterator[dict[str, Any]]:
    """The rows of a manifest of simulated axes, whose logs it writes; so many of them are bad."""
    spoilt = np.random.default_rng(5).permutation(axes) < bad * axes
    for k in range(axes):
        file = folder / f"axis_{k:05}.csv"
        if spoilt[k]:
            bad_log(file, k)
        else:
            force_log(file, k, F_C=TRUE["F_C"] * (1 + 0.3 * np.sin(k)))
        yield {
            "axis": f"axis {k}",
            "machine": f"machine {k % 7}",
            "when": f"2026-{1 + k % 3:02}-15",
            "log": str(file),
            "rig": "forced",
        }


if __name__ == "__main__":  # run a fleet and say so after each axis, to be killed there
    from stribeck.fleet.fleet_run import fleet

    fleet(sys.argv[1], sys.argv[2], progress=lambda _, left: print(left, flush=True))  # noqa: T201
