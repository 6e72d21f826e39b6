"""The axis of a co-simulation unit: what moves it, and each of its values with unit and start."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from ...errors import InputError
from ...rig.balanced import BalancedRig
from ...rig.cylinder import Cylinder
from ...rig.joint import JointRig
from ...rig.presliding import PreslidingRig
from ...rig.rig import Rig
from ...rig.servo_pendulum import ServoPendulum
from ...rig.slide_bed import SlideBed
from ...rig.stepped import SteppedRig
from ...space import Param
from ...units import convertible, unit
from ..model import Model, identifier

Drive = Literal["AXIS_SLIDE", "AXIS_SERVO", "AXIS_JOINT", "AXIS_FORCE"]

#: Places among a drive's inputs, as its step reads them: two loads, then three of its own.
_NORMAL, _TEMPERATURE, _FIRST, _SECOND, _THIRD = range(5)
#: Longest step, s, and way by which a step may be off, m or rad, where a rig has none of its own.
_STEP, _TOLERANCE = 1e-3, 1e-7
#: Speeds between which a law may fall, m/s or rad/s, and a step that is short enough for any, s.
_SPEEDS, _SHORTEST = (1e-6, 10.0), 1e-6
#: The constants that each drive reads.
_CONSTANTS: dict[Drive, tuple[str, ...]] = {
    "AXIS_SLIDE": ("m", "k_hat+", "k_hat-", "F_fm", "J_m", "D_m", "K_kt", "F_m_max"),
    "AXIS_SERVO": ("m", "l", "kp", "vin", "duty", "g"),
    "AXIS_JOINT": ("kp", "kd", "gain", "limit", "hold"),
    "AXIS_FORCE": ("bore",),
}
#: SI units of those in which constants are shown.
_SCALED = {"mm": "m", "um": "m", "ms": "s", "us": "s", "mrad": "rad", "deg": "rad"}


@dataclass(frozen=True)
class Value:
    """A variable of the unit, SI.

    Args:
        name: As a simulator shows it.
        role: What it is for.
        unit: SI, "" for a pure number.
        doc: Its meaning, and for an identified parameter how well it is known.
        start: None where it is calculated.
        low: Least value of its search range.
        high: Greatest.
        fixed: Whether it stays as it is at the start; held between steps, for an input.
        place: Of an input among the drive's.
        symbols: What the C calls it.
    """

    name: str
    role: Literal["output", "input", "setting", "law", "parameter"]
    unit: str
    doc: str
    start: float | None = None
    low: float | None = None
    high: float | None = None
    fixed: bool = False
    place: int = 0
    symbols: tuple[str, ...] = ()


@dataclass(frozen=True)
class Axis:
    """An axis as it is exported.

    Args:
        drive: What moves it.
        motion: Its equation of motion, in words and signs.
        values: Outputs, inputs, settings, the law's parameters, the rig's; value references
            count them.
    """

    drive: Drive
    motion: str
    values: tuple[Value, ...]

    def of(self, *roles: str) -> list[Value]:
        """The values of some roles."""
        return [v for v in self.values if v.role in roles]

    def first(self, role: str) -> int:
        """Where the values of a role begin."""
        return next(i for i, v in enumerate(self.values) if v.role == role)


def axis(model: Model) -> Axis:
    """The axis of a model.

    Raises:
        InputError: its rig has no equation of motion that could be stepped.
    """
    if isinstance(model.rig, SlideBed):
        model.rig.split(model.law, model.values)  # refuses what cannot be simulated
    drive, motion = _drive(model.rig)
    values = [
        *_outputs(model), *_inputs(model, drive), *_settings(model),
        *_identified(model), *_constants(model, drive),
    ]  # fmt: skip
    taken: set[str] = set()
    unique = []
    for v in values:
        name = v.name
        while name in taken:
            name += "_"
        taken.add(name)
        unique.append(replace(v, name=name))
    return Axis(drive, motion, tuple(unique))


def _drive(rig: Rig) -> tuple[Drive, str]:
    """What moves a rig, and how; F_f is friction."""
    match rig:
        case SlideBed():
            return "AXIS_SLIDE", (
                "m a = k_spring e + dead zone(k_hat e + added_force, F_fm) − F_m − F_f, "
                "e = command − position, F_m = clip(K_kt (J_m a + D_m v), F_m_max)"
            )
        case ServoPendulum():
            return "AXIS_SERVO", (
                "(m l² + armature) a = torque_on (k_t V/R − k_t² v/R) − m g l sin(q + q_offset) "
                "− F_f, V = clip(vin duty kp (goal − q) + added_voltage, vin)"
            )
        case JointRig():
            return "AXIS_JOINT", (
                "J a = clip(feed_forward + gain (kp (command − q) + kd (command_velocity − v)), "
                "limit) − g_sin sin q − g_cos cos q − g_0 − F_f"
            )
        case Cylinder():
            return "AXIS_FORCE", "M a = force − (π bore²/4 + b) pressure − offset − F_f"
        case BalancedRig() | PreslidingRig():
            turned = "g_sin" in {q.name for q in rig.params}
            weight = " − g_sin sin q − g_cos cos q" if turned else ""
            return "AXIS_FORCE", f"M a = force{weight} − offset − F_f"
    raise InputError(f"fmu: rig {rig.name} has no equation of motion that could be stepped")


def _outputs(model: Model) -> Iterator[Value]:
    way = "rad" if model.rig.rotary else "m"
    yield Value("position", "output", way, "position")
    yield Value("velocity", "output", model.speed_unit, "velocity")
    drives = "what the drive does to the axis"
    if isinstance(model.rig, SlideBed):
        drives += ", F_m apart"  # the motor's inertia and damping are not in it
    yield Value("drive", "output", model.force_unit, drives)
    rubs = "friction, with the sign of the velocity; at rest, of the pull that it balances"
    yield Value("friction", "output", model.force_unit, rubs)


def _inputs(model: Model, drive: Drive) -> Iterator[Value]:
    way, force = "rad" if model.rig.rotary else "m", model.force_unit

    def made(name: str, written: str, doc: str, place: int, start: float = 0.0, *,
             held: bool = False) -> Value:  # fmt: skip
        return Value(name, "input", written, doc, start, fixed=held, place=place)

    if drive == "AXIS_SLIDE":
        yield made("command", way, "commanded position x_i", _FIRST)
        yield made("added_force", force, "added to the motor's force", _SECOND, held=True)
    elif drive == "AXIS_SERVO":
        yield made("goal", way, "goal of the servo", _FIRST)
        yield made("torque_on", "", "above 0.5: the servo drives", _SECOND, 1.0, held=True)
        yield made("added_voltage", "V", "added to the servo's voltage", _THIRD, held=True)
    elif drive == "AXIS_JOINT":
        yield made("command", way, "commanded angle", _FIRST)
        yield made("command_velocity", model.speed_unit, "its velocity", _SECOND)
        yield made("feed_forward", force, "torque added to the controller's", _THIRD)
    else:
        yield made("force", force, "of the drive on the axis", _FIRST)
    if isinstance(model.rig, Cylinder):
        yield made("pressure", "Pa", "gauge pressure against the rod's force", _NORMAL)
    elif "normal" in model.law.loads:
        yield made("normal_load", "", "normal load, as the law counts it", _NORMAL)
    if "temperature" in model.law.terms:
        yield made("temperature", "K", "temperature that friction depends on", _TEMPERATURE, 293.15)


def _settings(model: Model) -> Iterator[Value]:
    """Where it starts, and how it is stepped: fixed when the simulation begins."""
    way = "rad" if model.rig.rotary else "m"
    rig_has = {c.name: c.value for c in model.rig.constants}
    step = longest(model, rig_has.get("step", _STEP))
    for name, written, doc, start in (
        ("position_start", way, "position at the start", 0.0),
        ("velocity_start", model.speed_unit, "velocity at the start", 0.0),
        ("step", "s", "longest step inside a communication step", step),
        ("tolerance", way, "way by which such a step may be off",
         rig_has.get("tolerance", _TOLERANCE)),
    ):  # fmt: skip
        yield Value(name, "setting", written, doc, start, fixed=True)


def longest(model: Model, step: float) -> float:
    """The longest step, s, at which an axis breaks away when its law says so.

    A friction that falls with speed by more than mass over step hides from an implicit step that
    rest is not stable. A rig that was identified by such steps keeps its own; so does a law with
    states, which does not jump.
    """
    law, p = model.law, model.p
    if law.states or isinstance(model.rig, SteppedRig) or not (law.static and law.sticks):
        return step
    by = model.parameters.every[len(law.params) :]
    own = zip(by, model.values[len(law.params) :].tolist(), strict=True)
    masses = [value for q, value in own if q.name == "M"]
    mass = masses[0] if masses else model.rig["m"]
    v = np.geomspace(*_SPEEDS, 400)
    fall = max(float(np.max(-np.diff(s * law.friction(s * v, p)) / np.diff(v))) for s in (1, -1))
    return max(min(step, 0.5 * mass / fall), _SHORTEST) if fall > 0.0 and mass > 0.0 else step


def _identified(model: Model) -> Iterator[Value]:
    named = [name for name, _ in model.named()]
    every, k = model.parameters.every, len(model.law.params)
    labels = [*named, *(identifier(model.rig.label(q.name)) for q in every[k:])]
    for i, (name, q, value) in enumerate(zip(labels, every, model.values.tolist(), strict=True)):
        symbol = identifier(q.name)
        both = [f"{symbol}_pos", f"{symbol}_neg"] if q.name == "k_spring" else []
        inside = q.lower <= value <= q.upper
        yield Value(
            name,
            "law" if i < k else "parameter",
            q.unit,
            known(model, q),
            value,
            q.lower if inside else None,
            q.upper if inside else None,
            symbols=() if i < k else (symbol, *both),
        )


def known(model: Model, q: Param) -> str:
    """What a parameter means, its interval and the verdict on it."""
    given = model.card.parameters.get(model.rig.label(q.name))
    said = q.doc or q.name
    if given is None:
        return f"{said}; as the law has it"
    if given.low is not None and given.high is not None:
        low, high = (float(unit(given.unit).to_si(x)) for x in (given.low, given.high))
        said += f"; 95 % interval {low:.6g} to {high:.6g}"
    return f"{said}; {given.verdict}"


def _constants(model: Model, drive: Drive) -> Iterator[Value]:
    wanted = _CONSTANTS[drive]
    if drive == "AXIS_SLIDE" and model.law.static and model.law.sticks:
        wanted = (*wanted, "dv")  # how such a slide stops and starts
    for c in model.rig.constants:
        if c.name in wanted and not math.isnan(c.value):
            name = identifier(c.name)
            yield Value(
                name, "parameter", si(c.unit), f"{c.doc}; a constant of the rig", c.value,
                symbols=(name,),
            )  # fmt: skip


def si(written: str) -> str:
    """The SI unit of a quantity that is shown in another."""
    made = re.sub(r"[A-Za-z]+", lambda word: _SCALED.get(word[0], word[0]), written)
    if not (convertible(made, written) and unit(made).factor == 1.0):
        raise InputError(f"fmu: {written!r} has no SI unit here")
    return made
