"""One generalised Maxwell slip for a direct-drive joint: its loops, its ramps, its sliding.

    python benchmarks/direct_drive_joint.py [--law gms-damped:5] [--show]

The joint is joint 1 of github.com/jorgevchin/Friction-Identification. A law is fitted to one log of
loops below breakaway and to ramps of torque both ways together, by simulating them all; the other
loops and ramps are held out. Three things make that possible:

- **What was before a log is not known**, and bent the contact. Here it is a swing of torque before
  the log begins, to a peak of unknown size and back: one number for each ramp, and none for loops,
  whose first period does not count.
- **Ramps are compared by torque at equal displacement**, as an axis that creeps would else weigh a
  thousand times as much as one that swings. Rows up to 5 mrad count.
- **Loops are compared by position**, as their encoder's step is as wide as the first element, and
  driving a law by it is biased.

Results go to direct_drive_joint.json.
"""

from __future__ import annotations

import argparse
import json
import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import least_squares

from stribeck import Recording, read
from stribeck.data.breakaway import ramps
from stribeck.friction import Law, law_named
from stribeck.report.table import Cell, Table
from stribeck.rig.lookup import rig_named
from stribeck.space import Array

FILE = Path(__file__).with_suffix(".json")
DATA = Path(__file__).parents[2] / "shared" / "data" / "direct_drive"
LOOPS = tuple(f"sig0_j1_6_exp{k}" for k in (1, 2, 3))
TRAINED = ("est_j1_05_exp1", "est_j1_05_exp2", "est_j1_n05", "est_j1_n05_exp4")
HELD_OUT = ("est_j1_05", "est_j1_05_exp3", "est_j1_n05_exp1")
LAWS = ("maxwell-slip:5", "gms-damped:4", "gms-damped:5")
RIG = rig_named("presliding-rotary").set(tolerance=1.0)
#: The inertia that the authors of the data give, kg m^2; loops count from here on, s.
INERTIA, SETTLED = 2.519, 2.0
#: Ramps count up to this displacement, rad, and all of them together as much as one log whose
#: scatter is four times that of the loops: like ramps differ by so much.
FAR, RAMPS = 5e-3, 0.25
#: Displacements at which torques of ramps are told, rad.
TOLD = (1e-3, 2e-3, 5e-3)
#: The swing of torque before a ramp takes so long, s, in so many steps.
BEFORE, STEPS = 10.0, 100
#: Starts of the search, and evaluations of each at most.
STARTS, MOST = 8, 80
#: Ranges, by the head of a parameter's name; all but `offset` and `ratio` by their logarithms.
RANGES = {
    "W": (1e-2, 20.0), "d": (1e-6, 1e-4), "r": (1.2, 30.0), "F_V": (1e-2, 3e3),
    "ratio": (0.2, 5.0), "v_s": (1e-5, 0.1), "tau": (1e-3, 1.0), "sigma": (1.0, 2e4),
}  # fmt: skip
#: Where a search begins, beside levels and ways spread evenly.
BEGIN = {"F_V": 3.0, "v_s": 2e-4, "tau": 0.02, "sigma": 900.0}
LEVEL, FIRST, APART = 10.3, 7e-6, 4.0


@dataclass(frozen=True)
class Joint:
    """The logs that a law is fitted to.

    Args:
        law: Of friction.
        loop: A log of loops.
        rises: Logs of ramps.
    """

    law: Law
    loop: Recording
    rises: tuple[Recording, ...]

    @property
    def names(self) -> list[str]:
        """Of all unknowns: the law's, the offset, and the peak before each ramp."""
        return [*self.law.names, "offset", *("before" for _ in self.rises)]

    def values(self, u: Array) -> Array:
        """Unknowns as they are searched, (n,), in SI."""
        logged = np.array([_logged(name) for name in self.names])
        return np.where(logged, np.exp(np.where(logged, u, 0.0)), u)

    def residuals(self, u: Array) -> Array:
        """Of loops and ramps, each root mean square times its weight."""
        x = self.values(u)
        k = len(self.law.params) + 1
        parts = [loop_misfit(self.law, x[:k], self.loop)]
        weight = RAMPS / np.sqrt(len(self.rises))
        parts += [
            weight * ramp_misfit(self.law, x[:k], log, peak)
            for log, peak in zip(self.rises, x[k:], strict=True)
        ]
        return np.concatenate([part / np.sqrt(len(part)) for part in parts])


def _logged(name: str) -> bool:
    return name not in ("offset", "ratio", "before")


def moved(law: Law, x: Array, log: Recording) -> Array:
    """Simulated positions of a log, m, (N,)."""
    p = np.append(x[:-1], [INERTIA, x[-1]])
    return np.asarray(RIG.simulate(law, p[None], log).position[0])


def loop_misfit(law: Law, x: Array, log: Recording) -> Array:
    """Position less simulated, up to a constant, over the standard deviation of the position."""
    rows = log.t >= SETTLED
    off = (log.position - moved(law, x, log))[rows]
    return np.asarray((off - off.mean()) / np.std(log.position[rows]))


def after(log: Recording, peak: float) -> Recording:
    """A log with a swing of torque before it, from 0 to a peak and back to where it begins."""
    assert log.force is not None  # noqa: S101 - all have a torque
    t = np.arange(-STEPS, 0) * BEFORE / STEPS + log.t[0]
    s = np.arange(STEPS) / STEPS
    force = np.where(s < 0.5, 2.0 * s * peak, peak + (2.0 * s - 1.0) * (log.force[0] - peak))  # noqa: PLR2004
    return Recording(
        t=np.append(t, log.t),
        position=np.append(np.full(STEPS, log.position[0]), log.position),
        force=np.append(force, log.force),
        rotary=True,
    )


def ramp_misfit(law: Law, x: Array, log: Recording, peak: float) -> Array:
    """Torque less the simulated one at equal displacement, over its standard deviation."""
    assert log.force is not None  # noqa: S101 - as above
    way = 1.0 if log.force[-1] > 0 else -1.0
    far = np.maximum.accumulate(way * (log.position - log.position[0]))
    q = moved(law, x, after(log, peak))[STEPS:]
    model = np.maximum.accumulate(way * (q - q[0])) + 1e-12 * np.arange(len(q))
    rows = (far < FAR) & (np.abs(log.force) > 0.5)  # noqa: PLR2004 - N m, beyond the encoder's step
    torque = np.interp(far[rows], model, log.force)
    return np.asarray((log.force[rows] - torque) / np.std(log.force[rows]))


def fitted(joint: Joint, seed: int) -> Array:
    """The best set of some starts, in SI: the law's, the offset, the peaks before the ramps."""
    rng = np.random.default_rng(seed)
    law, names = joint.law, joint.names
    n = sum(name.startswith("W_") for name in law.names)
    heads = [name.split("_")[0] if name[:2] in ("W_", "d_", "r_") else name for name in names]
    ends = np.array([RANGES.get(head, (-12.0, 12.0)) for head in heads])
    ends[heads.index("offset")] = -2.0, 2.0
    logged = [_logged(name) for name in names]
    ends[logged] = np.log(ends[logged])
    best, cost = np.empty(0), np.inf
    for _ in range(STARTS):
        first = dict.fromkeys(("offset",), 0.0) | {"ratio": 0.9 if "damped" in law.name else 1.1}
        W = np.geomspace(1.0, 3.0, n) * np.exp(rng.normal(0.0, 0.2, n))
        u = []
        rises = iter(joint.rises)
        for name, head, log in zip(names, heads, logged, strict=True):
            if head == "W":
                value = LEVEL * W[int(name[2:]) - 1] / W.sum()
            elif head == "before":
                value = -5.0 * float(np.sign(_last(next(rises))))
            else:
                value = {"d": FIRST, "r": APART, **BEGIN}.get(head, first.get(head, 0.0))
                value *= float(np.exp(rng.normal(0.0, 0.1)))
            u.append(np.log(value) if log else value)
        start = np.clip(u, ends[:, 0] + 1e-6, ends[:, 1] - 1e-6)
        answer = least_squares(
            joint.residuals,
            start,
            bounds=(ends[:, 0], ends[:, 1]),
            diff_step=np.full(len(start), 1e-4),
            max_nfev=MOST,
            x_scale="jac",
        )
        if answer.cost < cost:
            best, cost = joint.values(answer.x), answer.cost
    return best


def _last(log: Recording) -> float:
    assert log.force is not None  # noqa: S101 - as above
    return float(log.force[-1])


def broke_away(log: Recording) -> list[float]:
    """The torques at which a ramp breaks away by both definitions, N m."""
    return [round(x, 2) for b in ramps(log) for x in b.levels]


def torques(log: Recording, motion: Array) -> list[float]:
    """The torques at which a ramp has gone each of TOLD, N m; `motion` is where it is, rad."""
    assert log.force is not None  # noqa: S101 - as above
    far = np.abs(motion - motion[0])
    return [round(float(log.force[np.argmax(far >= x)]), 2) for x in TOLD]


def measured(name: str) -> dict[str, Any]:
    """Errors on all loops and breakaways of all ramps of a law trained on each loop in turn."""
    law = law_named(name)
    logs = {key: read(DATA / f"{key}.csv") for key in (*LOOPS, *TRAINED, *HELD_OUT)}
    fits = []
    for key in LOOPS:
        start = time.process_time()
        joint = Joint(law, logs[key], tuple(logs[ramp] for ramp in TRAINED))
        x = fitted(joint, 1)
        k = len(law.params) + 1
        errors = {
            loop: float(np.sqrt(np.mean(loop_misfit(law, x[:k], logs[loop]) ** 2)))
            for loop in LOOPS
        }
        peaks = dict(zip(TRAINED, x[k:].tolist(), strict=True))
        away, gone = {}, {}
        for ramp in (*TRAINED, *HELD_OUT):
            log = after(logs[ramp], peaks.get(ramp, 0.0))
            motion = replace(log, position=moved(law, x[:k], log)).cut(slice(STEPS, None))
            away[ramp] = {"log": broke_away(logs[ramp]), "law": broke_away(motion)}
            gone[ramp] = {
                "log": torques(logs[ramp], logs[ramp].position),
                "law": torques(motion, motion.position),
            }
        fits.append({
            "loop": key, "errors": errors, "breakaway": away, "torque": gone, "before": peaks,
            "parameters": dict(zip([*law.names, "offset"], x[:k].tolist(), strict=True)),
            "seconds": time.process_time() - start,
        })  # fmt: skip
        print(name, key, {k: round(v, 4) for k, v in errors.items()}, flush=True)
    return {"law": name, "fits": fits}


def tables(results: list[dict[str, Any]]) -> list[Table]:
    """Errors on held-out loops, and breakaways and torques of held-out ramps, by law."""
    rows, ways, gone = [], [], []
    for law in results:
        fits = law["fits"]
        own = [fit["errors"][fit["loop"]] for fit in fits]
        other = [e for fit in fits for k, e in fit["errors"].items() if k != fit["loop"]]
        seconds = float(np.median([fit["seconds"] for fit in fits]))
        cells = [Cell.number(float(x), 3) for x in (np.median(own), np.median(other), max(other))]
        rows.append((Cell.label(law["law"]), *cells, Cell.number(seconds, 2)))
        for ramp in HELD_OUT:
            levels = [fit["breakaway"][ramp]["law"] for fit in fits]
            logged = " and ".join(f"{x:.1f}" for x in fits[0]["breakaway"][ramp]["log"])
            texts = (law["law"], ramp, logged, _level(levels, 0), _level(levels, 1))
            ways.append(tuple(map(Cell.label, texts)))
            told = np.median([fit["torque"][ramp]["law"] for fit in fits], axis=0)
            of_log = fits[0]["torque"][ramp]["log"]
            pairs = [f"{a:.1f} ({b:.1f})" for a, b in zip(told, of_log, strict=True)]
            gone.append(tuple(map(Cell.label, (law["law"], ramp, *pairs))))
    return [
        Table(
            "One law for loops and ramps: the error of the angle, as a share of its deviation",
            ("law", "own loop", "other loops", "worst", "seconds"),
            tuple(rows),
        ),
        Table(
            "Breakaway of ramps that were held out, N m: medians over the three fits",
            ("law", "ramp", "measured", "by speed", "by stiffness"),
            tuple(ways),
        ),
        Table(
            "Torque at which ramps that were held out have gone so far, N m, and measured",
            ("law", "ramp", *(f"{x * 1e3:.0f} mrad" for x in TOLD)),
            tuple(gone),
        ),
    ]


def _level(levels: list[list[float]], k: int) -> str:
    values = [v[k] for v in levels if len(v) > k]
    return f"{np.median(values):.1f}" if values else "none"


def main() -> None:
    """Fit, keep, show."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--law", action="append", help="by default all that are compared")
    parser.add_argument("--show", action="store_true", help="what is kept, without a fit")
    arguments = parser.parse_args()
    kept = json.loads(FILE.read_text()) if FILE.exists() else []
    if not arguments.show:
        for name in arguments.law or LAWS:
            kept = [law for law in kept if law["law"] != name] + [measured(name)]
        FILE.write_text(json.dumps(kept, indent=1) + "\n")
    for table in tables(kept):
        print(table.text())


if __name__ == "__main__":
    main()
