"""The EMPS closed loop, simulated with the identified model: ours beside the published errors."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from stribeck import LAWS, Recording, identify, read
from stribeck.data.filtering import even, smooth
from stribeck.rig.emps import EMPS, LoopMotion

DATA = Path("../shared/data/emps")
PUBLISHED = {
    "DATA_EMPS.mat": (0.013752, 0.22911, 8.6036, 5.848),
    "DATA_EMPS_PULSES.mat": (0.0080248, 0.47888, 19.8152, 8.9409),
}


def relative_errors(motion: LoopMotion, log: Recording) -> list[float]:
    """100 ||measured - simulated|| / ||measured||, as the report's validation counts it.

    Of the low-passed position, its central difference, that of this one, and the raw force.
    """
    at = even(log, EMPS.measured(log))
    first, last = EMPS.filtering.edges(at.rate)
    rows = slice(first, len(at.t) - last)
    simulated = (motion.position, motion.velocity, motion.acceleration, motion.force)
    measured = (*smooth(at.position, at.rate, EMPS.filtering), at.force)
    return [
        float(100 * np.linalg.norm((m - s[0])[rows]) / np.linalg.norm(m[rows]))
        for m, s in zip(measured, simulated, strict=True)
    ]


def main() -> None:
    """Identify on the first recording, simulate both, print the relative errors."""
    rig, law = EMPS, LAWS["coulomb-viscous"]
    fit = identify(read(DATA / "DATA_EMPS.mat", columns=rig.columns), rig=rig, law=law)
    print(f"{'relative error / %':24}" + "".join(f"{n:>12}" for n in ("q", "v", "a", "F")))
    for name, published in PUBLISHED.items():
        log = read(DATA / name, columns=rig.columns)
        errors = relative_errors(rig.simulate(law, fit.p[None], log), log)
        print(f"{name:24}" + "".join(f"{e:12.6g}" for e in errors))
        print(f"{'  published':24}" + "".join(f"{e:12.6g}" for e in published))


if __name__ == "__main__":
    main()
