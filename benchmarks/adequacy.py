"""How often what a model leaves out is told, on foreign axes: power per fault, and false alarms.

    python benchmarks/adequacy.py [--first SEED] [--kinds balance ...] [--out FILE]

Axes are drawn at random (mass, friction, speeds, gains), moved by the simulators of
`tests/foreign`, which share nothing with stribeck, and logged with noise that may remember for 60
samples, steps, and held channels. Each is fitted without the fault in the model.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import foreign_path  # noqa: F401 - before what it finds
from foreign import driven, sensors, servo, slide_bed
from foreign.friction import Curve, coulomb_viscous
from foreign.strokes import ramp, sines, strokes
from stribeck import RIGS, Recording, identify

Case = tuple[Recording, dict[str, Any], dict[str, float]]
LOOP = driven.Loop(kp=4e4, kd=2e3, ki=1e5)
#: A coin, and how often a channel is held; when a servo lets go, s.
COIN, HELD, LETS_GO = 0.5, 0.3, 8.0
#: Seed of the first log of each row: those from 0 on are the logs on which the filter and the
#: variance of a pattern were settled.
FIRST = 1000
#: An identified value that is off by less is nothing to speak of.
OFF = 0.03


def chosen(fault: str, F_C: float, F_V: float, top: float, travel: float, rng: Any) -> Any:
    """Friction to the right and to the left, and what acts besides, of the size of friction."""
    plus = minus = coulomb_viscous(F_C, F_V)
    extras: dict[str, float] = {}
    if fault == "square":
        extras["square"] = rng.uniform(0.5, 1.0) * F_V / top
    elif fault == "drop":
        plus = minus = Curve(1.5 * F_C, F_C, F_V, top * rng.uniform(0.05, 0.2))
    elif fault.startswith("cogging"):
        period = {"long": 1.5, "middle": 7.0, "short": 23.0}[fault.split()[1]]
        extras |= {"cogging": 0.15 * F_C, "cogging_period": travel / period}
    elif fault == "wave":
        extras |= {"wave": 0.25, "wave_period": travel / rng.uniform(1.0, 6.0)}
    elif fault == "spring":
        extras |= {"spring": 0.5 * F_C / travel}
    elif fault == "warming":
        extras |= {"warming": 0.35, "warming_time": rng.uniform(2.0, 12.0)}
    elif fault == "side":
        minus = coulomb_viscous(F_C, 1.5 * F_V)
    return plus, minus, extras


def balance(seed: int, fault: str) -> Case:
    """A linear axis with a measured force: strokes at six speeds, or a sum of sines."""
    rng = np.random.default_rng(seed)
    M, F_C, F_V = rng.uniform(3, 20), rng.uniform(8, 40), rng.uniform(20, 150)
    offset, top, travel = rng.uniform(-3, 3), rng.uniform(0.15, 0.6), rng.uniform(0.1, 0.3)
    plus, minus, extras = chosen(fault, F_C, F_V, top, travel, rng)
    if rng.integers(2):
        t, x = sines(15.0, 0.5 * travel * np.array([0.6, 0.3, 0.2]),
                     np.array([0.31, 0.53, 0.87]) * rng.uniform(0.7, 1.3, 3))  # fmt: skip
    else:
        speeds = top * np.array([0.1, 0.2, 0.35, 0.5, 0.75, 1.0])
        t, x, _ = strokes(np.concatenate([rng.permutation(speeds) for _ in range(2)]), travel)
    motion = driven.simulate(M, plus, minus, LOOP._replace(mass_ff=0.9 * M), t, x,
                             driven.Extras(offset=offset, **extras))  # fmt: skip
    table = {name: motion._asdict()[name] for name in ("t", "position", "force")}
    memory = float(rng.choice([0, 0, 5, 20, 60]))
    table = sensors.noisy(table, "force", rng.uniform(0.05, 0.4) * F_C, rng, memory)
    if rng.random() < COIN:
        table = sensors.quantised(table, "force", 0.05 * F_C)
    table = sensors.quantised(table, "position", float(rng.choice([1e-6, 5e-6, 2e-5])))
    if rng.random() < HELD:
        table = sensors.held(table, "force", 0.004)
    log = Recording(table["t"], table["position"], force=table["force"])
    truth = {"M": M, "F_C": F_C, "F_V": F_V, "offset": offset}
    return log, {"rig": "forced", "law": "coulomb-viscous"}, truth


def joint(seed: int, fault: str) -> Case:
    """A joint under PD control that follows a sum of sines; only the angle is measured."""
    rng = np.random.default_rng(seed)
    J, F_C, F_V, g = rng.uniform((0.1, 0.5, 0.2, 0.5), (0.5, 2.0, 1.0, 3.0))
    dt, kp = float(rng.choice([0.005, 0.01])), rng.uniform(60, 150)
    kd = 0.84 * np.sqrt(kp * J)
    t, x = sines(12.0, rng.uniform(0.6, 1.2) * np.array([0.6, 0.3, 0.2]),
                 np.array([0.21, 0.37, 0.61]) * rng.uniform(0.7, 1.3, 3), dt)  # fmt: skip
    top, travel = float(np.abs(np.gradient(x, t)).max()), float(np.ptp(x))
    plus, minus, extras = chosen(fault, F_C, F_V, top, travel, rng)
    motion = driven.simulate(J, plus, minus, driven.Loop(kp=kp, kd=kd, tick=dt), t, x,
                             driven.Extras(g_sin=g, **extras), dt=dt)  # fmt: skip
    table = motion._asdict()
    noise = float(rng.choice([2e-5, 1e-4, 3e-4]))
    table = sensors.noisy(table, "position", noise, rng, float(rng.choice([0, 0, 5])))
    if rng.random() < COIN:
        table = sensors.quantised(table, "position", 2 * noise)
    log = Recording(t, table["position"], command=motion.command, rotary=True)
    rig = RIGS["joint"].set(kp=kp, kd=kd, hold=1, step=10.0).exact()
    truth = {"J": J, "F_C": F_C, "F_V": F_V, "g_sin": g}
    return log, {"rig": rig, "law": "coulomb-viscous"}, truth


def pendulum(seed: int, fault: str) -> Case:
    """A servo pendulum, half of them with two seconds of free swing; only the angle is measured."""
    rng = np.random.default_rng(seed)
    axis = servo.Servo(*rng.uniform((0.3, 0.1, 1e-3, 0.3, 3.0), (0.6, 0.1, 5e-3, 0.6, 6.0)))
    K_c, K_v = rng.uniform((0.01, 0.003), (0.03, 0.012))
    bam = {
        "drop": servo.Bam(K_c, K_v, K_cs=0.8 * K_c, w_s=0.6),
        "load": servo.Bam(K_c, K_v, K_m=0.06, K_e=0.06),
    }.get(fault, servo.Bam(K_c, K_v))
    t, goal = sines(10.0, np.array([0.6, 0.4, 0.2]) * rng.uniform(0.7, 1.2),
                    np.array([0.23, 0.51, 0.9]) * rng.uniform(0.8, 1.2, 3), dt=0.01)  # fmt: skip
    on = (t < LETS_GO).astype(float) if rng.random() < COIN else np.ones_like(t)
    table = servo.simulate(axis, bam, t, goal, on)._asdict()
    noise, memory = float(rng.choice([2e-4, 1e-3])), float(rng.choice([0, 3]))
    table = sensors.noisy(table, "position", noise, rng, memory)
    if rng.random() < COIN:
        table = sensors.quantised(table, "position", 1.5e-3)
    extra = {"torque_enable": on, "mass": np.full(len(t), axis.m)}
    log = Recording(t, table["position"], command=goal, rotary=True, extra=extra)
    rig = RIGS["servo-pendulum"].set(step=10.0).exact()
    truth = {"F_C": K_c, "F_V": K_v, "k_t": axis.k_t, "R": axis.R, "armature": axis.armature}
    return log, {"rig": rig, "law": "coulomb-viscous"}, truth


def bed(seed: int, fault: str) -> Case:
    """The paper's slide bed in stick-slip on a ramp; its constants are exact."""
    del fault
    rng = np.random.default_rng(seed)
    low, high = (120, 45, 600, 1.2e-3), (160, 70, 950, 5e-3)
    curve = Curve(*rng.uniform(low, high))
    motion = slide_bed.simulate(slide_bed.Bed(), curve, curve,
                                *ramp(50.0, rng.uniform(4e-3, 8e-3)), 0.0)  # fmt: skip
    noise, memory = float(rng.choice([5e-5, 2e-4])), float(rng.choice([0, 3]))
    table = sensors.noisy(motion._asdict(), "position", noise, rng, memory)
    log = Recording(motion.t, table["position"], command=motion.command)
    truth = {**curve._asdict(), "k_spring": slide_bed.Bed().k_spring_up}
    return log, {"rig": RIGS["slide-bed"].exact(), "law": "stribeck"}, truth


FAULTS = ("square", "drop", "cogging long", "cogging middle", "cogging short", "wave", "spring",
          "warming", "side")  # fmt: skip
#: The kinds of axes, how many clean logs, the faults, and how many logs of each.
KINDS: dict[str, tuple[Callable[[int, str], Case], int, tuple[str, ...], int]] = {
    "balance": (balance, 60, FAULTS, 6),
    "joint": (joint, 20, ("square", "drop", "cogging middle", "spring", "warming", "side"), 4),
    "servo": (pendulum, 12, ("drop", "load"), 5),
    "slide bed": (bed, 12, (), 0),
}

#: What is counted: logs with an effect, logs with an estimate that it makes weak, logs with an
#: identified value that is off, or off without a word; and intervals that are identified, and
#: those of them that miss the truth.
COLUMNS = ("told", "weak", "off", "silent", "identified", "missed")


def judged(make: Callable[[int, str], Case], seed: int, fault: str) -> list[int]:
    """What is told of a log and how right it is, as `COLUMNS` has it."""
    log, arguments, truth = make(seed, fault)
    search: dict[str, Any] = {} if arguments["rig"] == "forced" else {"budget": 1500, "repeats": 1}
    fit = identify(log, **arguments, **search)
    effects = fit.effects.effects if fit.effects is not None else ()
    told = {name for e in effects for name in e.shifts}
    weak = any(e.reason == "model" for e in fit.estimates)
    known = [e for e in fit.estimates if e.verdict == "identified" and e.name in truth]
    missed = [e for e in known if not e.low <= truth[e.name] <= e.high]
    off = {e.name for e in missed if abs(e.value / truth[e.name] - 1) > OFF}
    return [bool(told), weak, bool(off), bool(off - told), len(known), len(missed)]


def main() -> None:
    """Run all, and write what came out."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", default=str(Path(__file__).with_name("adequacy.json")))
    parser.add_argument("--first", type=int, default=FIRST, help="seed of the first log of a row")
    parser.add_argument("--kinds", nargs="*", choices=list(KINDS), help="all by default")
    options = parser.parse_args()
    out, first = Path(options.out), options.first
    rows: list[dict[str, Any]] = []
    for kind in options.kinds or KINDS:
        make, clean, faults, each = KINDS[kind]
        for fault, n in (("none", clean), *((fault, each) for fault in faults)):
            results = np.array([judged(make, first + k, fault) for k in range(n)])
            counts = dict(zip(COLUMNS, results.sum(axis=0).tolist(), strict=True))
            rows.append({"axis": kind, "fault": fault, "logs": n, **counts})
            print(*rows[-1].values(), sep=" | ", flush=True)
            out.write_text(json.dumps(rows, indent=1) + "\n")


if __name__ == "__main__":
    main()
