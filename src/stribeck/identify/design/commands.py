"""What a servo, a joint or a pushed axis can do next: commands and forces as functions of time."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...rig.joint import JointRig
from ...rig.servo_pendulum import ServoPendulum
from ...space import Array
from .proposals import (
    HOLD,
    Course,
    Left,
    course,
    moved,
    simulated,
    there_and_back,
    thinned,
    tracks,
    within,
)

if TYPE_CHECKING:
    from .experiment import Experiment
    from .operating_range import Axis

Offer = tuple["Experiment", Sequence[Course]]

#: Speeds of strokes, as multiples of the log's mean one.
SPEEDS = (0.2, 0.5, 2.0)
#: Forces of sines below breakaway, as shares of it.
SHARES = (0.2, 0.4, 0.6, 0.8)
#: How far beyond breakaway a ramp of force goes, and how far beyond the log's travel the axis may
#: go then, as multiples of that travel.
BEYOND, ROOM = 1.05, 20.0


def servo_pendulum(axis: Axis, seconds: float, left: Left) -> list[Experiment]:
    """Candidates of a pendulum on a servo."""
    axis = thinned(axis, seconds)
    return list(within(axis, _servo(axis, seconds, left), left, 0.25))


def joint(axis: Axis, seconds: float, left: Left) -> list[Experiment]:
    """Candidates of a joint."""
    axis = thinned(axis, seconds)
    return list(within(axis, _joint(axis, seconds), left, 0.25))


def presliding(axis: Axis, seconds: float, left: Left) -> list[Experiment]:
    """Candidates of an axis under a measured force."""
    axis = thinned(axis, seconds)
    return list(within(axis, _pushes(axis, seconds), left, ROOM))


def _servo(axis: Axis, seconds: float, left: Left) -> Iterator[Offer]:
    rig = axis.parameters.rig
    assert isinstance(rig, ServoPendulum)  # noqa: S101 - asked before
    log = axis.logs[0]

    def of_run(column: str, constant: str) -> float:
        return float(log.extra[column][0]) if column in log.extra else rig[constant]

    run = {"mass": of_run("mass", "m"), "length": of_run("length", "l"),
           "kp": of_run("kp", "kp"), "vin": of_run("vin", "vin")}  # fmt: skip
    reach = 0.5 * (axis.high - axis.low)
    middle = 0.5 * (axis.high + axis.low)
    period = max(2 * np.pi * reach / axis.pace, 2.0)
    clock = _clock(axis, seconds)
    sine = middle + reach * np.sin(2 * np.pi * clock / period)
    slow = middle + reach * np.sin(2 * np.pi * clock / (4 * period))

    def offer(name: str, words: str, command: Array, **extra: float | Array) -> Offer:
        courses = [Course(clock, command, run | extra)]
        return simulated(axis, name, words, courses), courses

    about = f"a sine of ±{axis.place(reach)} about {axis.place(middle)}"
    yield offer("slow sine", f"{about}, {4 * period:.2g} s a turn", slow)
    yield offer("sine", f"{about}, {period:.2g} s a turn", sine)
    for times in (0.25, 4.0):
        kp = times * run["kp"]
        yield offer(f"gain × {times:g}", f"{about}, {period:.2g} s a turn, at kp = {kp:.4g}",
                    sine, kp=kp)  # fmt: skip
    sweep = np.sin(2 * np.pi * (0.2 * clock + 0.9 * clock**2 / seconds))
    yield offer("chirp", f"a sine of ±{axis.place(0.5 * reach)} about {axis.place(middle)} that "
                "goes from 0.2 to 2 Hz", middle + 0.5 * reach * sweep)  # fmt: skip
    turn = clock % 6.0
    lifted = middle + reach * np.clip(turn / 2.0, 0.0, 1.0)
    yield offer(
        "lift and drop",
        f"lift to {axis.place(middle + reach)} within 2 s, hold for 1 s, switch the torque off for "
        "3 s, and again",
        lifted,
        torque_enable=(turn < 3.0).astype(float),  # noqa: PLR2004 - lifted and held
    )
    mass, weight = 2 * run["mass"], rig["g"] * run["length"]
    stall = axis.value("k_t") * run["vin"] / axis.value("R")
    if mass * weight > 0.8 * stall:
        left.append(("more mass", f"{mass:.3g} kg is more than the servo can lift well"))
    else:
        yield offer("more mass", f"{about}, {period:.2g} s a turn, with {mass:.3g} kg", sine,
                    mass=mass)  # fmt: skip


def _joint(axis: Axis, seconds: float) -> Iterator[Offer]:
    assert isinstance(axis.parameters.rig, JointRig)  # noqa: S101 - asked before
    low, high, pace = axis.low, axis.high, axis.pace
    ends = f"between {axis.place(low)} and {axis.place(high)}"

    def offer(name: str, words: str, t: Sequence[float], x: Sequence[float]) -> Offer:
        courses = [course(axis, t, x)]
        return simulated(axis, name, words, courses), courses

    for times in SPEEDS:
        v = times * pace
        yield offer(f"strokes × {times:g}", f"strokes {ends} at {axis.rate(v)}",
                    *there_and_back(low, high, [v], seconds))  # fmt: skip
    several = [s * pace for s in (0.1, 0.3, 1.0, 2.0)]
    listed = ", ".join(axis.rate(v).split()[0] for v in several[:-1])
    yield offer("several speeds", f"strokes {ends} at {listed} and {axis.rate(several[-1])}",
                *there_and_back(low, high, several, seconds))  # fmt: skip
    third = (high - low) / 3
    yield offer("reversals", f"short strokes between {axis.place(low + third)} and "
                f"{axis.place(high - third)} at {axis.rate(0.3 * pace)}",
                *there_and_back(low + third, high - third, [0.3 * pace], seconds))  # fmt: skip
    steps = np.concatenate([np.linspace(low, high, 6), np.linspace(high, low, 6)[1:]])
    dwell = (seconds - HOLD) / (len(steps) - 1)
    move = min(0.5 * dwell, (high - low) / 5 / pace)
    t, x = [0.0, HOLD], [steps[0], steps[0]]
    for step in steps[1:]:
        t += [t[-1] + move, t[-1] + dwell]
        x += [step, step]
    yield offer("staircase", f"from {axis.place(low)} to {axis.place(high)} and back in steps of "
                f"{axis.place((high - low) / 5)}, {dwell:.2g} s each", t, x)  # fmt: skip


def _pushes(axis: Axis, seconds: float) -> Iterator[Offer]:
    forces = np.concatenate([log.force for log in axis.logs if log.force is not None])
    offset = axis.value("offset")
    parameters = axis.parameters
    level = parameters.law.levels(parameters.full(axis.x[None])[0, : len(parameters.law.params)])[1]
    clock = _clock(axis, seconds)
    log = axis.logs[0]
    assert log.force is not None  # noqa: S101 - the rig needs it
    turns = np.count_nonzero(np.diff(np.sign(log.force - float(np.mean(log.force)))) != 0)
    period = 2 * float(log.t[-1] - log.t[0]) / max(int(turns), 2)
    period = min(period, seconds / 3)
    seen = float(np.abs(forces - offset).max())

    def offer(name: str, words: str, force: Array) -> Offer:
        courses = [Course(clock, offset + force, {}, axis.logs[0].position[0], force=True)]
        return simulated(axis, name, words, courses), courses

    def sine(amplitude: Array | float, turn: float) -> Array:
        return amplitude * np.sin(2 * np.pi * clock / turn)

    most = 0.8 * level
    yield offer("sine to 80 %", f"a sine of ±{axis.push(most)}, 80 % of breakaway, {period:.3g} s "
                "a turn", sine(most, period))  # fmt: skip
    share = np.array(SHARES)[np.minimum((clock / seconds * 4).astype(int), 3)]
    listed = ", ".join(axis.push(s * level).split()[0] for s in SHARES[:-1])
    yield offer("several amplitudes", f"sines of ±{listed} and {axis.push(most)} one after the "
                f"other, {period:.3g} s a turn", sine(share * level, period))  # fmt: skip
    yield offer("fast sine", f"a sine of ±{axis.push(seen)}, {period / 5:.3g} s a turn",
                sine(seen, period / 5))  # fmt: skip
    peak = BEYOND * level
    tooth = np.interp(clock % period, [0, period / 4, 3 * period / 4, period], [0, peak, -peak, 0])
    on = tracks(axis, [Course(clock, offset + tooth, {}, axis.logs[0].position[0], force=True)])[0]
    goes = float(np.abs(moved(axis, on, axis.x[None]).position - on.x0).max())
    name = "ramp through breakaway"
    yield offer(name, f"triangles of force of ±{axis.push(peak)}, just beyond breakaway, "
                f"{period:.3g} s a turn: the axis goes {axis.place(goes)}", tooth)  # fmt: skip


def _clock(axis: Axis, seconds: float) -> Array:
    clock: Array = axis.interval * np.arange(int(seconds / axis.interval) + 1, dtype=float)
    return clock
