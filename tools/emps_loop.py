"""The EMPS closed loop, simulated with the identified model: ours beside the published errors."""

from __future__ import annotations

from pathlib import Path

from stribeck import LAWS, identify, read
from stribeck.rig.emps import EMPS

DATA = Path("../shared/data/emps")
PUBLISHED = {
    "DATA_EMPS.mat": (0.013752, 0.22911, 8.6036, 5.848),
    "DATA_EMPS_PULSES.mat": (0.0080248, 0.47888, 19.8152, 8.9409),
}


def main() -> None:
    """Identify on the first recording, simulate both, print the relative errors."""
    rig, law = EMPS, LAWS["coulomb-viscous"]
    fit = identify(read(DATA / "DATA_EMPS.mat", columns=rig.columns), rig=rig, law=law)
    print(f"{'relative error / %':24}" + "".join(f"{n:>12}" for n in ("q", "v", "a", "F")))
    for name, published in PUBLISHED.items():
        log = read(DATA / name, columns=rig.columns)
        ours = rig.relative_errors(rig.simulate(law, fit.p[None], log), log)[0]
        errors = (ours.position, ours.velocity, ours.acceleration, ours.force)
        print(f"{name:24}" + "".join(f"{e:12.6g}" for e in errors))
        print(f"{'  published':24}" + "".join(f"{e:12.6g}" for e in published))


if __name__ == "__main__":
    main()
