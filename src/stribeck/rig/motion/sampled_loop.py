"""The test bed's loop, closed through its sensors: a sampled controller before motor and slide.

From one instant to the next (an echo, a sample of the controller, a row of the log, a corner of the
command) the demand of the controller is held and the command is a straight line. A stuck slide is
passed in closed form, a slip in steps of the classical Runge-Kutta method of fourth order; its end
is located inside a step by a straight line.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ...compile_cache import compiled
from ...space import Array
from .drives import BAND, CLAMP, DAMPING, F_FM, IMPULSE, INERTIA, K_SPRING_M, K_SPRING_P, MASS
from .event_driven import command_at

#: What happens at an instant: the transducer renews its value, the controller reads, a row is
#: logged; added up.
ECHO, SAMPLE, ROW = 1, 2, 4
#: Longest step of a slip, s.
STEP = 2e-5
#: Where the rows of the log are kept: position, velocity, held echo, current, command.
POSITION, VELOCITY, HEARD, CURRENT, COMMAND = range(5)


class BedMotor(NamedTuple):
    """Controller and motor, seen from the slide.

    Args:
        gain_plus: Current per stretch above zero, A/m.
        gain_minus: Below zero.
        force: Force per current, K_t K_v, N/A.
        back_emf: Voltage per velocity of the slide, K_t K_n, V s/m.
        resistance: Of the winding, ohm.
        supply: Largest voltage, V.
        limit: Largest current, A.
        held_voltage: Whether the drive holds a voltage; else a current, as far as the supply goes.
    """

    gain_plus: float
    gain_minus: float
    force: float
    back_emf: float
    resistance: float
    supply: float
    limit: float
    held_voltage: bool


class Converter(NamedTuple):
    """The converter that reads the transducer: its span, m, and its number of levels."""

    low: float
    high: float
    levels: float


class CommandPath(NamedTuple):
    """Where the command goes.

    Args:
        t: Its corners, s; none where it goes for targets.
        x: Command there, m.
        targets: Where it goes one after the other until the *reading* is there, m.
        speed: At which it does, m/s.
    """

    t: Array
    x: Array
    targets: Array
    speed: float


@compiled()
def current(motor: BedMotor, demand: float, v: float) -> float:
    """Current of the motor, A, at a demanded one and a velocity of the slide."""
    emf = motor.back_emf * v
    amperes = min(max(demand, -motor.limit), motor.limit)
    if motor.held_voltage:
        volts = min(max(motor.resistance * amperes, -motor.supply), motor.supply)
        amperes = (volts - emf) / motor.resistance
    else:
        least, most = -motor.supply - emf, motor.supply - emf
        amperes = min(max(amperes, least / motor.resistance), most / motor.resistance)
    return min(max(amperes, -motor.limit), motor.limit)


@compiled()
def _dead_zone(force: float, friction: float) -> float:
    """What the motor's own friction leaves of its force (section 4.3, step 2)."""
    return force - min(max(force, -friction), friction)


@compiled()
def _leaves(low: float, high: float, span: float, P: float, dp: float) -> tuple[float, float]:
    """When an excess force that changes evenly ends a rest, s; and the impulse after the span.

    Args:
        low: Force beyond breakaway at the start, N; below zero within the levels.
        high: At the end.
        span: Between them, s.
        P: Impulse at the start, N s.
        dp: The impulse that ends rest.
    """
    if low <= 0.0 and high <= 0.0:
        return np.inf, 0.0
    growth, begin, end = (high - low) / span, 0.0, span
    if low <= 0.0:
        begin, low, P = -low / growth, 0.0, 0.0
    elif high < 0.0:
        end = -low / growth
    root = low * low + 2.0 * growth * (dp - P)
    if root >= 0.0 and low + np.sqrt(root) > 0.0:
        at = begin + 2.0 * (dp - P) / (low + np.sqrt(root))
        if at <= end:
            return at, 0.0
    if high <= 0.0:
        return np.inf, 0.0
    return np.inf, P + (low + 0.5 * growth * (end - begin)) * (end - begin)


@compiled()
def _drive(c: Array, motor: BedMotor, demand: float, e: float, v: float) -> float:
    """What pulls at the slide: the motor's force less its friction, and the spring, N."""
    force = _dead_zone(motor.force * current(motor, demand, v), c[F_FM])
    return force + (c[K_SPRING_P] if e > 0.0 else c[K_SPRING_M]) * e  # type: ignore[no-any-return]


@compiled()
def _acceleration(
    slip: Any, p: Array, c: Array, motor: BedMotor, demand: float, e: float, v: float, s: float
) -> float:
    """Acceleration in slip in direction s; friction stays on its side of zero speed."""
    net = _drive(c, motor, demand, e, v) - slip(v if s * v > 0.0 else s * 0.0, p)
    a = (net - c[DAMPING] * v) / (c[MASS] + c[INERTIA])
    inertia = c[INERTIA] * a + c[DAMPING] * v
    if abs(inertia) > c[CLAMP]:
        return (net - math.copysign(c[CLAMP], inertia)) / c[MASS]  # type: ignore[no-any-return]
    return a  # type: ignore[no-any-return]


@compiled()
def _slip_step(
    slip: Any, p: Array, c: Array, motor: BedMotor, demand: float, e: float, rate: float, v: float,
    s: float, h: float,
) -> tuple[float, float]:  # fmt: skip
    """Travel and velocity after a step."""
    a1 = _acceleration(slip, p, c, motor, demand, e, v, s)
    v2 = v + 0.5 * h * a1
    a2 = _acceleration(slip, p, c, motor, demand, e + 0.5 * h * (rate - v), v2, s)
    v3 = v + 0.5 * h * a2
    a3 = _acceleration(slip, p, c, motor, demand, e + 0.5 * h * (rate - v2), v3, s)
    v4 = v + h * a3
    a4 = _acceleration(slip, p, c, motor, demand, e + h * (rate - v3), v4, s)
    way = h * (v + 2.0 * v2 + 2.0 * v3 + v4) / 6.0
    return way, v + h * (a1 + 2.0 * a2 + 2.0 * a3 + a4) / 6.0


@compiled()
def _passed(
    slip: Any, p: Array, c: Array, motor: BedMotor, demand: float, e: float, rate: float,
    span: float, v: float, s: float, up: float, down: float,
) -> tuple[float, float, float, float, float]:  # fmt: skip
    """The slide after a span with one demand: travel, velocity, direction, impulses at rest.

    Args:
        slip: The law.
        p: Its parameters.
        c: Constants of the slide.
        motor: Controller and motor.
        demand: Current asked for, A.
        e: Stretch at the start, m.
        rate: Speed of the command, m/s.
        span: s.
        v: Velocity, m/s.
        s: Its direction; 0.0 at rest.
        up: Impulse of what exceeds the breakaway level, N s.
        down: The same to the other side.
    """
    left, x = span, 0.0
    while left > 0.0:
        if s == 0.0:
            low = _drive(c, motor, demand, e, 0.0)
            high = _drive(c, motor, demand, e + rate * left, 0.0)
            at, up = _leaves(low - slip(0.0, p), high - slip(0.0, p), left, up, c[IMPULSE])
            if at < np.inf:
                s = 1.0
            else:
                level = slip(-0.0, p)
                at, down = _leaves(level - low, level - high, left, down, c[IMPULSE])
                if at == np.inf:
                    return x, 0.0, 0.0, up, down
                s = -1.0
            v, up, down = s * c[BAND], 0.0, 0.0
            left, e = left - at, e + rate * at
            continue
        h = left / math.ceil(left / STEP - 1e-9)
        way, faster = _slip_step(slip, p, c, motor, demand, e, rate, v, s, h)
        if s * faster < c[BAND]:
            share = (s * v - c[BAND]) / (s * v - s * faster)
            h = max(share * h, 1e-9)
            way, faster, s = 0.5 * h * (v + s * c[BAND]), 0.0, 0.0
        x, v, left, e = x + way, faster, left - h, e + rate * h - way
    return x, v, s, up, down


@compiled()
def _converted(echo: float, reading: Converter) -> float:
    """The position that the controller reads, m."""
    step = (reading.high - reading.low) / reading.levels
    code = min(max(math.floor((echo - reading.low) / step), 0.0), reading.levels - 1.0)
    return reading.low + (code + 0.5) * step


@compiled()
def _aimed(course: CommandPath, target: int, rate: float, reading: float) -> tuple[int, float]:
    """The target that a reading leaves to go for and the rate towards it; 0.0 behind the last."""
    while target < len(course.targets):
        rest = course.targets[target] - reading
        if rate == 0.0:
            rate = math.copysign(course.speed, rest)
        if rest * rate >= 0.0:
            return target, rate
        target, rate = target + 1, 0.0
    return target, 0.0


@compiled()
def run(
    slip: Any, p: Array, c: Array, motor: BedMotor, reading: Converter, course: CommandPath,
    x0: float, instants: Array, kinds: Array, noise: Array, rows: Array,
) -> int:  # fmt: skip
    """Run the loop from rest; fill the rows of the log, and return how many there are.

    A course of targets ends with its last one: the command is then what was read, and stays.

    Args:
        slip: The law.
        p: Its parameters.
        c: Constants of the slide.
        motor: Controller and motor.
        reading: The converter.
        course: Where the command goes.
        x0: Where the slide rests at first, m.
        instants: Times, s, increasing.
        kinds: What happens there.
        noise: Of each echo, m.
        rows: (5, N), is written.
    """
    x, v, s, up, down = x0, 0.0, 0.0, 0.0, 0.0
    echo, demand, echoes, row, target = x0, 0.0, 0, 0, 0
    goal, rate, ends = x0, 0.0, np.inf
    for k in range(len(instants)):
        now = instants[k]
        if kinds[k] & ECHO:
            echo, echoes = x + noise[echoes], echoes + 1
        if len(course.targets) == 0:
            j = np.searchsorted(course.t, now + 1e-12, side="right")
            goal, rate, _ = command_at(course.t, course.x, j, now)
        if kinds[k] & SAMPLE:
            seen = _converted(echo, reading)
            if target < len(course.targets):
                ahead = _aimed(course, target, rate, seen)
                if ahead != (target, rate):  # from what is read to the next target
                    goal, (target, rate) = seen, ahead
                    if target == len(course.targets):
                        ends = now + 1.0
            e = goal - seen
            demand = (motor.gain_plus if e > 0.0 else motor.gain_minus) * e
        if kinds[k] & ROW:
            rows[POSITION, row], rows[VELOCITY, row], rows[HEARD, row] = x, v, echo
            rows[CURRENT, row], rows[COMMAND, row] = current(motor, demand, v), goal
            row += 1
        if now >= ends or k + 1 == len(instants):
            break
        span = instants[k + 1] - now
        way, v, s, up, down = _passed(
            slip, p, c, motor, demand, goal - x, rate, span, v, s, up, down
        )
        x, goal = x + way, goal + rate * span
    return row
