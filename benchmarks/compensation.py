"""Recommended compensators in foreign closed loops: what swings, and what is gained.

    python benchmarks/compensation.py [slide-bed|joint|servo ...]          # measures
    python benchmarks/compensation.py --show [onset|cost]                  # prints the tables

A card of each axis is compensated with `compensate`'s motions and sensors; what is recommended
then runs in `tests/foreign/compensated.py`, on every axis that the card allows and on the true
one, along ramps of five speeds, both ways, and sines. Judged there, in the plainest way, is
whether an axis swings on or rests behind its reference where it does neither without
compensation. Results go to compensation.json, axis by axis.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.signal import find_peaks

import foreign_path  # noqa: F401 - before what it finds
from foreign import joint as joints
from foreign import servo as servos
from foreign.compensated import (
    Loop,
    LoopMotion,
    Settings,
    ramp,
    simulate_bed,
    simulate_loop,
    sine,
    stands,
    swing,
)
from foreign.friction import Curve
from foreign.slide_bed import Bed
from stribeck import RIGS, Card, identify, read, read_card
from stribeck.compensate.closed_loop import IDEAL, Sensor
from stribeck.compensate.compensation import Compensation, compensate
from stribeck.compensate.compensator import Compensator
from stribeck.compensate.corners import plants
from stribeck.compensate.scale_curve import MARGIN
from stribeck.data.recording import Recording
from stribeck.report.folder import write_text
from stribeck.report.format import number
from stribeck.report.table import Table
from stribeck.report.terminal import show_table
from stribeck.rig.slide_bed import PUBLISHED
from stribeck.space import Array

FILE = Path(__file__).with_name("compensation.json")
DATA = Path(__file__).parents[2] / "shared" / "data"
#: Seconds of a ramp, and rows of it in which an axis settles, and which are judged.
LONG, SHARE = 40.0, 0.3
#: Sample time, s. Below which recommended scale it is told what the whole friction would do.
PERIOD, ENOUGH = 1e-3, 0.8
#: A swing counts from this share of the greatest error without compensation, and lasts that keeps
#: the second one from one part of a ramp to the next. Turns of the error in the last part of a
#: ramp, and in the last cycle of a sine.
FLOOR, LASTING, TURNS = 0.01, 0.8, (4, 12)
#: An axis that is so many times its command's travel away (0.1 m or rad at least) has run away.
FAR = 100.0

#: RMS error, floor and whether it hunts, by axis and motion.
Baselines = Mapping[tuple[str, str], tuple[float, float, bool]]
#: Who tells the onset.
ENDS = ("stribeck", "foreign")

Run = Callable[[Array, Settings, Array, float], LoopMotion]


class Seen(NamedTuple):
    """How a compensator sees its axis, and how often, s."""

    sensor: Sensor
    period: float = PERIOD


@dataclass(frozen=True)
class Case:
    """An axis with its card.

    Args:
        written: The card.
        run: A foreign motion of a parameter set, compensator, command, and its sample time.
        truth: The true parameter set, SI, where it is known.
        speeds: Of the ramps, m/s or rad/s.
        travel: Longest way of a ramp, m or rad.
        slow: The speed that `compensate` is told, where the card's logs do not say.
        sensors: By name.
        unit: Of errors, and how many of it an SI one is.
    """

    written: Card
    run: Run
    truth: Array | None
    speeds: tuple[float, ...]
    travel: float
    slow: float
    sensors: Mapping[str, Seen]
    unit: tuple[str, float]


def curve(p: Array) -> Curve:
    """Friction of a parameter set of Stribeck's or Coulomb's law."""
    return Curve(p[0], p[1], p[2], p[3])


def _bed() -> Case:
    """The card of the README, and the published set that made its log."""
    written = read_card("demo/left/card.json")
    _, p = written.model()

    def run(axis: Array, s: Settings, command: Array, period: float) -> LoopMotion:
        bed = Bed(k_spring_up=axis[-1], k_spring_down=axis[-1])
        c, m = curve(axis), curve(p)
        return simulate_bed(bed, c, c, (m, m), s, command, period, h=5e-5)

    sensors = {
        "noise 0.3 mm": Seen(Sensor(noise=3e-4)),
        "steps of 0.0977 mm": Seen(Sensor(9.77e-5)),
        "these every 20 ms": Seen(Sensor(9.77e-5), 0.02),
        "steps of 1 um": Seen(Sensor(1e-6)),
    }  # fmt: skip
    speeds = (2e-3, 5e-3, 10e-3, 20e-3, 50e-3)
    return Case(
        written, run, np.array(PUBLISHED["left"]), speeds, np.inf, 5e-3, sensors, ("mm", 1e3)
    )


def _pd(written: Card, loop_of: Callable[[Array], Loop], width: int) -> Run:
    """Foreign motions of a mass under control."""
    _, p = written.model()

    def friction(values: Array) -> Curve:
        if width == 2:  # noqa: PLR2004 - Coulomb's and viscous friction
            return Curve(values[0], values[0], values[1])
        return curve(values)

    def run(axis: Array, s: Settings, command: Array, period: float) -> LoopMotion:
        c, m = friction(axis), friction(p)
        return simulate_loop(loop_of(axis), c, c, (m, m), s, command, period, h=1e-4)

    return run


def _joint() -> Case:
    """A soft joint that sticks, identified from a foreign log."""
    J, kp, kd = 0.08, 7.0, 0.5
    truth = Curve(0.58, 0.34, 0.12, 0.06)
    t = 0.01 * np.arange(4001.0)
    command = 0.4 * np.sin(0.5 * t) + 0.1 * np.sin(2.1 * t)
    moved = joints.simulate(
        joints.Joint(J, g_sin=0.3, kp=kp, kd=kd), truth, truth, t, command, h=1e-4
    )
    rng = np.random.default_rng(3)
    log = Recording(
        t=t, position=moved.position + 1e-5 * rng.standard_normal(len(t)), command=command,
        rotary=True,
    )  # fmt: skip
    rig = RIGS["joint"].set(kp=kp, kd=kd)
    written = identify(log, rig=rig, law="stribeck", seed=1).card()
    run = _pd(written, lambda a: Loop(a[5], kp, kd, g_sin=a[6], g_cos=a[7], g_0=a[8]), 5)
    true = np.array([0.58, 0.34, 0.12, 0.06, 1.0, J, 0.3, 0.0, 0.0])
    return Case(
        written, run, true, (0.02, 0.05, 0.1, 0.2, 0.5), 3.0, 0.05,
        {"noise 0.1 mrad": Seen(Sensor(noise=1e-4)), "14 bits": Seen(Sensor(2.0 * np.pi / 2**14))},
        ("mrad", 1e3),
    )  # fmt: skip


def _servo(*, motor: bool = True) -> Case:
    """A pendulum on a servo, identified from a foreign log.

    Args:
        motor: Whether k_t and R are known: a position alone tells their ratio at most.
    """
    constants = servos.Servo()
    t = 5e-3 * np.arange(2401.0)
    goal = 0.8 * np.sin(1.2 * t) + 0.3 * np.sin(5.0 * t)
    bam = servos.Bam(K_c=0.04, K_v=0.02, K_cs=0.03, w_s=0.1)
    moved = servos.simulate(constants, bam, t, goal, h=5e-5)
    rng = np.random.default_rng(5)
    log = Recording(
        t=t, position=moved.position + 1e-4 * rng.standard_normal(len(t)), command=goal, rotary=True
    )
    values = {n: getattr(constants, n) for n in ("m", "l", "kp", "vin", "duty", "g")}
    rig = RIGS["servo-pendulum"].set(**values)
    fixed = {"k_t": constants.k_t, "R": constants.R} if motor else {}
    written = identify(log, rig=rig, law="stribeck", fixed=fixed, seed=1).card()
    names = [q.name for q in written.model()[0].every]

    def loop_of(a: Array) -> Loop:
        v = dict(zip(names, a.tolist(), strict=True))
        per_volt = v["k_t"] / v["R"]
        stiff = constants.vin * constants.duty * constants.kp
        weight = constants.m * constants.g * constants.l
        return Loop(
            constants.m * constants.l**2 + v["armature"], per_volt * stiff,
            limit=per_volt * constants.vin, brake=v["k_t"] ** 2 / v["R"],
            g_sin=weight * np.cos(v["q_offset"]), g_cos=weight * np.sin(v["q_offset"]),
        )  # fmt: skip

    sensors = {
        "noise 0.5 mrad": Seen(Sensor(noise=5e-4)), "12 bits": Seen(Sensor(2.0 * np.pi / 2**12))
    }  # fmt: skip
    known = {"F_S": 0.07, "F_C": 0.04, "F_V": 0.02, "v_SS": 0.1, "exponent": 1.0, "q_offset": 0.0}
    known |= {"k_t": constants.k_t, "R": constants.R, "armature": constants.armature}
    return Case(
        written, _pd(written, loop_of, 5), np.array([known[n] for n in names]),
        (0.02, 0.05, 0.1, 0.2, 0.5), 3.0, 0.1,
        sensors if motor else {},
        ("mrad", 1e3),
    )  # fmt: skip


def _emps() -> Case:
    """The published slide; its velocity is a difference of positions here."""
    rig = RIGS["emps"]
    log = read(DATA / "emps" / "DATA_EMPS.mat", columns=dict(rig.columns))
    written = identify(log, rig=rig, law="coulomb-viscous").card()
    per_speed = rig["gtau"] * rig["kv"]
    run = _pd(
        written,
        lambda a: Loop(
            a[2], per_speed * rig["kp"], per_speed, rate=0.0, limit=rig["gtau"] * rig["u_max"],
            hold=2.0, difference=1.0, g_0=a[3],
        ),
        2,
    )  # fmt: skip
    return Case(
        written, run, None, (2e-3, 5e-3, 10e-3, 20e-3, 50e-3), 0.5, 0.02,
        {"noise 10 um": Seen(Sensor(noise=1e-5)), "steps of 1 um": Seen(Sensor(1e-6))}, ("mm", 1e3),
    )  # fmt: skip


CASES: dict[str, Callable[[], Case]] = {
    "slide-bed": _bed, "joint": _joint, "servo": _servo,
    "servo-unknown-motor": partial(_servo, motor=False), "emps": _emps,
}  # fmt: skip


# --- judged ---------------------------------------------------------------------------------------


def commands(case: Case, period: float) -> dict[str, Array]:
    """Ramps of all speeds, both ways, and sines of twice the first three speeds."""
    scale = case.unit[1]
    result = {}
    for v in case.speeds:
        for sign in (1.0, -1.0):
            seconds = min(LONG, case.travel / v)
            result[f"ramp {sign * v * scale:g}"] = ramp(sign * v, seconds, 0.0, period)
    for v in case.speeds[:3]:
        result[f"sine {2 * v * scale:g}"] = sine(
            2 * v, min(5.0 * v, case.travel / 2), 3, 0.0, period
        )
    return result


def hunts(name: str, command: Array, moved: LoopMotion, floor: float) -> bool:
    """Whether an axis runs away, or swings on or rests behind its reference at a motion's end."""
    away = np.abs(moved.position - command[0]).max()
    if not away < FAR * max(float(np.ptp(command)), 0.1) or stands(command, moved) > 0.0:
        return True
    on_ramp = name.startswith("ramp")
    last = (command - moved.position)[-int(len(command) * (SHARE if on_ramp else 1 / 3)) :]
    turns = sum(len(find_peaks(e, prominence=floor)[0]) for e in (last, -last))
    if on_ramp:  # gravity turns an error, too, but not so often
        after, before = swing(command, moved, SHARE)
        return turns >= TURNS[0] and after > floor and after >= LASTING * before
    return turns >= TURNS[1]


def settings_of(c: Compensator, sensor: Sensor) -> Settings:
    """A compensator as the foreign loop takes it."""
    return Settings(
        c.scale, float(c.feedback), c.dead_band, c.reference_band, c.drive, c.crossover,
        sensor.resolution, sensor.noise,
    )  # fmt: skip


def axes_of(case: Case) -> dict[str, Array]:
    """What the card allows, and the truth."""
    parameters, p = case.written.model()
    axes, _ = plants(case.written, parameters, p)
    return axes | ({} if case.truth is None else {"truth": case.truth})


def baselines(case: Case, period: float) -> Baselines:
    """RMS, floor and whether it hunts, of each axis and motion without compensation."""
    result = {}
    for axis, p in axes_of(case).items():
        for name, command in commands(case, period).items():
            moved = case.run(p, Settings(), command, period)
            error = command - moved.position
            floor = FLOOR * float(np.abs(error).max())
            rms = float(np.sqrt(np.mean(error * error)))
            result[axis, name] = rms, floor, hunts(name, command, moved, floor)
    return result


def judged(case: Case, settings: Settings, period: float, without: Baselines) -> dict[str, Any]:
    """Motions that hunt only with compensation, how far the ramps among them swing, and the gain.

    The gain is by motion: worst axis, truth.
    """
    new, farthest, gains = [], 0.0, dict[str, dict[str, float]]()
    for axis, p in axes_of(case).items():
        for name, command in commands(case, period).items():
            moved = case.run(p, settings, command, period)
            rms, floor, hunted = without[axis, name]
            if hunts(name, command, moved, floor) and not hunted:
                new.append(f"{axis}, {name}")
                if name.startswith("ramp"):
                    farthest = max(farthest, swing(command, moved, SHARE)[0])
            error = command - moved.position
            gains.setdefault(name, {})[axis] = rms / float(np.sqrt(np.mean(error * error)))
    return {
        "hunts": new,
        "swing": farthest * case.unit[1],
        "motions": len(without),
        "without": sum(hunted for _, _, hunted in without.values()),
        "gain": {
            name: {
                "worst": min(by_axis.values()),
                "truth": by_axis.get("truth", by_axis["as identified"]),
            }
            for name, by_axis in gains.items()
        },
    }


def believed(case: Case, sensor: Sensor, period: float) -> Compensator:
    """The compensator's settings beside scale and mode, from the words of docs/compensation.md."""
    noisy = 3.0 * np.sqrt(2.0) * sensor.noise  # of a difference of two readings
    rests = 1e-3 * case.slow
    constants = case.written.constants
    drive = case.written.model()[0].rig["F_fm"] if "F_fm" in constants else 0.0
    return Compensator(
        dead_band=max((1.5 * sensor.resolution + noisy) / period, rests),
        reference_band=rests, drive=drive,
    )  # fmt: skip


def there_and_back(speed: float, seconds: float, period: float) -> Array:
    """A ramp that turns after a quarter of its time: what lasts at its end has lasted since."""
    there = ramp(speed, seconds / 4, 0.0, period)
    way_back = speed * period * np.arange(1.0, round(0.75 * seconds / period) + 1)
    return np.concatenate([there, there[-1] - way_back])


def settling(case: Case, period: float) -> list[tuple[Array, str, Array, float]]:
    """Axes and motions at the speeds of `compensate` that settle without compensation; floors."""
    axes = [p for n, p in axes_of(case).items() if n != "truth"]
    amplitude = min(5.0 * case.slow, case.travel / 2)
    motions = {"sine": sine(2 * case.slow, amplitude, 3, 0.0, period)}
    for v in (case.slow, 4 * case.slow):
        seconds = min(LONG, case.travel / v)
        for sign in (1.0, -1.0):
            motions[f"ramp {sign * v}"] = ramp(sign * v, seconds, 0.0, period)
            motions[f"ramp back {sign * v}"] = there_and_back(sign * v, seconds, period)
    result = []
    for p in axes:
        for name, command in motions.items():
            free = case.run(p, Settings(), command, period)
            floor = FLOOR * float(np.abs(command - free.position).max())
            if not hunts(name, command, free, floor):
                result.append((p, name, command, floor))
    return result


def onset(
    case: Case, result: Compensation, settles: list[tuple[Array, str, Array, float]]
) -> dict[str, Any]:
    """Where feedback begins to hunt: by `compensate`, and in the foreign loop."""
    (feedback,) = [c for c in result.curves if c.mode == "feedback"]
    sensor, period = result.sensor, result.period
    shape = believed(case, sensor, period)

    def foreign(scale: float) -> bool:
        s = settings_of(replace(shape, scale=scale), sensor)
        return any(
            hunts(
                name, command, case.run(p, s, command, period), max(floor, 2.0 * sensor.resolution)
            )
            for p, name, command, floor in settles
        )

    tried = float(feedback.scales[-1])
    told = {"stribeck": None if feedback.onset is None else feedback.onset.scale, "tried": tried}
    low, high = 0.0, tried + MARGIN
    if not foreign(high):
        return told | {"foreign": None}
    while high - low > 0.0125:  # noqa: PLR2004 - a quarter of what is asked
        middle = 0.5 * (low + high)
        low, high = (low, middle) if foreign(middle) else (middle, high)
    return told | {"foreign": high}


def measured(case: Case) -> dict[str, Any]:
    """All of an axis."""
    began = time.process_time()
    recommended = {
        name: compensate(case.written, speed=case.slow, sensor=seen.sensor, period=seen.period)
        for name, seen in {"ideal": Seen(IDEAL), **case.sensors}.items()
    }
    seconds = (time.process_time() - began) / len(recommended)
    periods = {result.period for result in recommended.values()}
    every = {period: (baselines(case, period), settling(case, period)) for period in periods}
    by_sensor = {}
    for name, result in recommended.items():
        c = result.compensator
        without, settles = every[result.period]
        by_sensor[name] = {
            "mode": result.mode,
            "scale": None if c is None else c.scale,
            "axes": len(result.plants),
            **(
                {}
                if c is None
                else judged(case, settings_of(c, result.sensor), result.period, without)
            ),
            "onset": onset(case, result, settles),
            "more": more(case, result, without),
        }
    return {
        "law": case.written.law, "seconds": round(seconds, 1), "unit": case.unit[0],
        "truth": case.truth is not None, "slow": case.slow * case.unit[1], "sensors": by_sensor,
    }  # fmt: skip


def more(case: Case, result: Compensation, without: Baselines) -> dict[str, Any]:
    """What the whole friction would do where less of it is recommended, by mode."""
    c = result.compensator
    if c is None or c.scale > ENOUGH:
        return {}
    shape = replace(c, scale=1.0, feedback=True)
    modes = {"feedback": replace(shape, crossover=0.0), "crossover": shape}
    return {
        f"{name} 1": judged(case, settings_of(settings, result.sensor), result.period, without)
        for name, settings in modes.items()
        if name == "feedback" or shape.crossover
    }


# --- shown ----------------------------------------------------------------------------------------


def show(which: str) -> None:
    """The tables of what is on file."""
    results = json.loads(FILE.read_text(encoding="utf-8"))
    if which == "onset":
        rows = [
            [name, sensor, *(_scale(s["onset"][k], s["onset"]["tried"]) for k in ENDS)]
            for name, r in results.items()
            for sensor, s in r["sensors"].items()
        ]
        heads = ["axis", "sensor", "compensate", "foreign loop"]
        show_table(Table.of_texts("scale from which feedback keeps an axis swinging", heads, rows))
        return
    if which == "cost":
        show_cost(results)
        return
    rows = []
    for name, r in results.items():
        for sensor, s in r["sensors"].items():
            if s["scale"] is None:
                rows.append([name, sensor, "none"])
                continue
            fastest = max(float(m.split()[1]) for m in s["gain"] if m.startswith("ramp"))
            slow, fast = (_gain(s["gain"], speed) for speed in (r["slow"], fastest))
            rows.append([
                name, sensor, f"{s['mode']} {s['scale']:.3g}", f"{s['without']}/{s['motions']}",
                str(len(s["hunts"])), slow[0], slow[1] if r["truth"] else "", fast[0],
            ])  # fmt: skip
    heads = ["axis", "sensor", "recommended", "without", "only with", "slow", "truth", "fast"]
    show_table(Table.of_texts("recommended compensators in foreign loops", heads, rows))


def show_cost(results: Mapping[str, Any]) -> None:
    """What is recommended, where that is less than the friction, beside the whole of it."""
    rows = []
    for name, r in results.items():
        for sensor, s in r["sensors"].items():
            if not s["more"]:
                continue
            for settings, tried in {f"{s['mode']} {s['scale']:.3g}": s, **s["more"]}.items():
                hunts = len(tried["hunts"])
                swings = f"{number(tried['swing'], 3)} {r['unit']}" if tried["swing"] else "none"
                gain = _gain(tried["gain"], r["slow"])
                rows.append([name, sensor, settings, *gain, str(hunts), swings])
    heads = ["axis", "sensor", "compensator", "slow", "truth", "only with", "swing"]
    show_table(Table.of_texts("the recommended compensator, and the whole friction", heads, rows))


def _scale(value: float | None, tried: float) -> str:
    return f"none to {tried:.4g}" if value is None else f"{value:.3f}"


def _gain(gains: Mapping[str, Mapping[str, float]], speed: float) -> list[str]:
    """How many times less the error is on both ramps of a speed: worst axis, truth."""
    both = [gains[f"ramp {sign * speed:g}"] for sign in (1.0, -1.0)]
    return [f"{number(min(g[k] for g in both), 3)}×" for k in ("worst", "truth")]


def main() -> None:
    """Measure the axes named, or show what is on file."""
    words = sys.argv[1:]
    if words[:1] == ["--show"]:
        show(words[1] if len(words) > 1 else "")
        return
    results = json.loads(FILE.read_text(encoding="utf-8")) if FILE.exists() else {}
    for name in words or CASES:
        results[name] = measured(CASES[name]())
        write_text(FILE, json.dumps(results, indent=1))
        print(name, json.dumps({k: v for k, v in results[name].items() if k != "sensors"}))


if __name__ == "__main__":
    main()
