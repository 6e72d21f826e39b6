"""The paper's test bed (section 4.1, figure 3), simulated with its sensors: the twin.

A PC closes the position loop as a P-controller over a bipolar drive, a DC motor with gearbox and
a ball screw; an ultrasonic transducer looks at a reflector on the slide, a second-order
differentiator makes a speed signal from it, a current sensor watches the motor, and a 12-bit
converter reads all three. The controller goes by what the converter read, and holds its demand from
one sample to the next. The slide obeys the slide bed's equation of motion; what is logged is what
the sensors saw. The truth is kept apart from the log.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Literal, get_args

import numpy as np
from numpy.random import SeedSequence
from numpy.typing import NDArray

from ..data.recording import Recording
from ..errors import InputError
from ..friction import LAWS, Law
from ..friction.law import addressed
from ..space import Array
from ..wording import option
from .motion import sampled_loop
from .motion.command import Drive
from .motion.sampled_loop import BedMotor, CommandPath, Converter
from .motion.track import track
from .rig import Motion
from .slide_bed import SLIDE_BED, SlideBed, published_both

Direction = Literal["up", "down", "both"]
#: Control mode, and what the motion control circuit does before it (section 4.1).
Mode = Literal["control", "test", "home"]
Loop = Literal["sensors", "ideal"]
Held = Literal["current", "voltage"]

#: Settings of the closed loop that are above zero.
_OF_THE_LOOP = ("loop_rate", "supply", "resistance", "current_limit", "move_speed")
#: How near the ends of the range a test move goes, m; how long a move may take, in multiples of
#: what its command takes over the whole range.
_MARGIN, _LONGEST = 1e-3, 5.0

#: Spans that the zero-span circuits map onto the converter (the paper states 0 to 400 mm).
POSITION_SPAN = (0.0, 0.4)
VELOCITY_SPAN = (-0.5, 0.5)
CURRENT_SPAN = (-2.5, 2.5)


@dataclass(frozen=True)
class TestBed:
    """The sensors and the ramp of the test bed; what the paper leaves open is marked inferred.

    Args:
        rig: The slide.
        low: Lower end of the ramp, m (section 4.1: 50 mm).
        high: Upper end, m (350 mm).
        speed: Speed of the ramp, m/s (section 4.5: 5 mm/s).
        hold: Rest of the command before and after the ramp, s (inferred).
        start_low: Where the slide rests before a ramp up, m (section 4.5.2: data from 44 mm).
        start_high: Where it rests before a ramp down, m (data from 352 mm).
        rate: Rate of the log, Hz (inferred).
        echo_rate: Rate at which the ultrasonic transducer renews its value, Hz (inferred from
            the 14 to 140 Hz of the maker's sensors).
        echo_noise: Standard deviation of an echo, m (inferred).
        current_noise: Standard deviation of the current sensor, A (inferred).
        corner: Corner frequency of the second-order differentiator, Hz (inferred).
        bits: Resolution of the converter (section 4.1: 12).
        loop: Whether the controller goes by what it reads, as in figure 3 (`sensors`), or by the
            position itself at all times (`ideal`); what follows is of the former.
        loop_rate: Rate of the controller, Hz (inferred: that of the transducer).
        held: What the drive holds from sample to sample (inferred: the current, as section 4.3
            has a force that goes with the stretch).
        supply: Voltage of the supply, V (inferred).
        resistance: Of the motor's winding, ohm (inferred: 2.5 to 8 in a motor of this class).
        current_limit: Largest current, A (inferred: the span of the current sensor).
        home: Where the reflector is placed, m (section 4.1: the middle of 0 to 400 mm).
        move_speed: Speed of the command in the modes test and home, m/s (inferred).
        mode: Ramps; or the whole range and then home, or home alone.
    """

    __test__ = False  # not a test, whatever its name looks like to pytest

    rig: SlideBed = SLIDE_BED
    low: float = 0.050
    high: float = 0.350
    speed: float = 0.005
    hold: float = 1.0
    start_low: float = 0.044
    start_high: float = 0.352
    rate: float = 100.0
    echo_rate: float = 50.0
    echo_noise: float = 0.3e-3
    current_noise: float = 5e-3
    corner: float = 5.0
    bits: int = 12
    loop: Loop = "ideal"
    loop_rate: float = 50.0
    held: Held = "current"
    supply: float = 24.0
    resistance: float = 5.0
    current_limit: float = 2.5
    home: float = 0.200
    move_speed: float = 0.020
    mode: Mode = "control"

    def __post_init__(self) -> None:
        for name in ("rate", "echo_rate", "corner", "speed", *_OF_THE_LOOP):
            if not getattr(self, name) > 0:
                raise InputError(f"test bed: {name} must be above zero")
        for name in ("echo_noise", "current_noise", "hold"):
            if not getattr(self, name) >= 0:
                raise InputError(f"test bed: {name} must not be below zero")
        for name, known in (("loop", Loop), ("mode", Mode), ("held", Held)):
            if getattr(self, name) not in get_args(known):
                raise InputError(
                    f"test bed: {name} {getattr(self, name)!r} is not one of "
                    f"{', '.join(get_args(known))}"
                )
        if self.mode != "control" and self.loop == "ideal":
            raise InputError("test bed: moves by what is read need a loop closed through sensors")
        if self.corner >= self.rate / 2:
            raise InputError("test bed: the differentiator's corner is above half the log's rate")

    def drive(self, direction: Direction) -> tuple[Drive, float]:
        """The command of a run and where the slide rests before it."""
        if direction == "up":
            return Drive.path([self.low, self.high], self.speed, hold=self.hold), self.start_low
        if direction == "down":
            return Drive.path([self.high, self.low], self.speed, hold=self.hold), self.start_high
        if direction == "both":
            path = [self.low, self.high, self.low]
            return Drive.path(path, self.speed, hold=self.hold), self.start_low
        raise InputError(f"direction {direction!r} is not one of up, down, both")

    def run(
        self,
        direction: Direction = "both",
        *,
        law: Law = LAWS["stribeck-directional"],
        truth: Array | None = None,
        seed: int = 0,
    ) -> Twin:
        """Record a run.

        Args:
            direction: A ramp up, a ramp down, or up and then down.
            law: The slide's friction.
            truth: (k,) parameters, the law's and then the rig's; by default the paper's two
                published sets, one for each direction.
            seed: Of the sensor noise.
        """
        p = published_both() if truth is None else np.asarray(truth, dtype=float)
        echo, amperes = (np.random.default_rng(s) for s in SeedSequence(seed).spawn(2))
        per_ampere = self.rig["K_t"] * self.rig["K_v"]
        if self.loop == "ideal":
            drive, x0 = self.drive(direction)
            t = np.arange(0.0, drive.t[-1] + 0.5 / self.rate, 1.0 / self.rate)
            motion, command = self.rig.move(law, p[None], track(drive, t, x0)), drive(t)
            echoed = self._transducer(t, motion.position[0], echo)
        else:
            motion, command, echoed = self._closed(direction, law, p, echo)
        t = motion.t
        current = motion.force[0] / per_ampere
        current = current + self.current_noise * amperes.standard_normal(len(t))
        amperes_read = self._convert(current, CURRENT_SPAN)
        return Twin(
            Recording(
                t=t,
                position=self._convert(echoed, POSITION_SPAN),
                command=command,
                velocity=self._convert(self._differentiate(echoed), VELOCITY_SPAN),
                current=amperes_read,
                force=amperes_read * per_ampere,
            ),
            motion,
            law,
            p,
            seed,
            self,
        )

    def _closed(
        self, direction: Direction, law: Law, p: Array, rng: np.random.Generator
    ) -> tuple[Motion, Array, Array]:
        """The motion of the loop as figure 3 draws it, its command, and the echoes."""
        if not (law.static and law.sticks):
            raise InputError(
                f"law {law.name} does not rest by itself: the test bed runs it in an ideal loop "
                f"alone ({option('loop', 'ideal')})"
            )
        laws, c = self.rig.split(law, p)
        course, x0, seconds = self._course(direction)
        instants, kinds = self._instants(course, seconds)
        noise = self.echo_noise * rng.standard_normal(np.count_nonzero(kinds & sampled_loop.ECHO))
        t = instants[(kinds & sampled_loop.ROW) > 0]
        rows = np.zeros((5, len(t)))
        n = sampled_loop.run(
            addressed(law.slip), laws[0], c[0], self._motor(),
            Converter(*POSITION_SPAN, 2.0**self.bits), course, x0, instants, kinds, noise, rows,
        )  # fmt: skip
        if n == len(t) and self.mode != "control":
            raise InputError(
                f"test bed: the reflector does not get where it is to go within {seconds:.3g} s: "
                "its drive is too weak or its command too slow"
            )
        x, v, echoed, current, command = rows[:, :n]
        force = current * self.rig["K_t"] * self.rig["K_v"]
        return Motion(t[:n], x[None], v[None], force[None]), command, echoed

    def _course(self, direction: Direction) -> tuple[CommandPath, float, float]:
        """Where the command goes, where the slide rests at first, and how long a run may take."""
        drive, x0 = self.drive(direction)
        if self.mode == "control":
            return CommandPath(drive.t, drive.x, np.empty(0), 0.0), x0, float(drive.t[-1])
        low, high = POSITION_SPAN
        ends = [low + _MARGIN, high - _MARGIN] if self.mode == "test" else []
        seconds = _LONGEST * (len(ends) + 1) * (high - low) / self.move_speed
        targets = np.array([*ends, self.home])
        return CommandPath(np.zeros(1), np.zeros(1), targets, self.move_speed), x0, seconds

    def _instants(self, course: CommandPath, seconds: float) -> tuple[Array, NDArray[np.int64]]:
        """When something happens, and what."""
        kinds = {sampled_loop.ECHO: self.echo_rate, sampled_loop.SAMPLE: self.loop_rate,
                 sampled_loop.ROW: self.rate}  # fmt: skip
        times = {k: np.arange(math.floor(seconds * f + 0.5) + 1) / f for k, f in kinds.items()}
        instants = np.unique(np.round(np.concatenate([*times.values(), course.t]), 12))
        happens = np.zeros(len(instants), dtype=np.int64)
        for kind, at in times.items():
            happens[np.searchsorted(instants, np.round(at, 12))] |= kind
        return instants, happens

    def _motor(self) -> BedMotor:
        """Controller and motor, seen from the slide."""
        K_t, K_v, K_n = self.rig["K_t"], self.rig["K_v"], self.rig["K_n"]
        per_ampere = K_t * K_v
        return BedMotor(
            self.rig["k_hat+"] / per_ampere, self.rig["k_hat-"] / per_ampere, per_ampere, K_t * K_n,
            self.resistance, self.supply, self.current_limit, self.held == "voltage",
        )  # fmt: skip

    def _transducer(self, t: Array, x: Array, rng: np.random.Generator) -> Array:
        """The distance of the last echo: noisy, and held until the next."""
        echo = np.floor(t * self.echo_rate + 1e-9).astype(int)
        noise = self.echo_noise * rng.standard_normal(echo[-1] + 1)
        distance: Array = np.interp(echo / self.echo_rate, t, x) + noise[echo]
        return distance

    def _differentiate(self, x: Array) -> Array:
        """The analogue differentiator s w^2 / (s^2 + sqrt(2) w s + w^2), sampled (bilinear)."""
        from scipy.signal import bilinear, lfilter  # noqa: PLC0415 - slow to import

        w = 2 * np.pi * self.corner
        b, a = bilinear([w * w, 0.0], [1.0, np.sqrt(2.0) * w, w * w], self.rate)
        return np.asarray(lfilter(b, a, x - x[0]), dtype=float)

    def _convert(self, values: Array, span: tuple[float, float]) -> Array:
        """A signal as the analogue-to-digital converter reads it over its span."""
        low, high = span
        levels = 2**self.bits
        code = np.clip(np.floor((values - low) / (high - low) * levels), 0, levels - 1)
        read: Array = low + (code + 0.5) * (high - low) / levels
        return read


@dataclass(frozen=True, eq=False)
class Twin:
    """A simulated recording and the truth behind it.

    Args:
        recording: What the sensors saw.
        motion: What really happened.
        law: The true friction law.
        truth: Its parameters and then the rig's, SI.
        seed: Of the sensor noise.
        bed: The test bed.
    """

    recording: Recording
    motion: Motion
    law: Law
    truth: Array
    seed: int
    bed: TestBed = field(repr=False)


def twin(
    direction: Direction = "both",
    *,
    seed: int = 0,
    speed: float = 5e-3,
    noise: float = 0.3e-3,
    rate: float = 100.0,
    echo_rate: float = 50.0,
    loop: Loop = "sensors",
    mode: Mode = "control",
    drive: Held = "current",
    supply: float = 24.0,
) -> Twin:
    """Record the paper's test bed (section 4.1, figure 3), simulated with its sensors.

    Args:
        direction: Ramp up, down, or both: up and then down.
        seed: Of the sensor noise.
        speed: Of the ramp, m/s.
        noise: Standard deviation of an ultrasonic echo, m.
        rate: Of the log, Hz.
        echo_rate: Of the transducer, Hz.
        loop: What the controller goes by: what it reads (`sensors`), or the position (`ideal`).
        mode: Ramps (`control`); or the whole range and then home (`test`); or `home`.
        drive: What the drive holds from sample to sample: `current` or `voltage`.
        supply: Voltage of the supply, V.

    Returns:
        The log as `recording`, and the truth: `law`, its parameters `truth` and what really
        happened, `motion`.

    Raises:
        InputError: a setting that the test bed cannot have.
    """
    bed = TestBed(
        speed=speed, echo_noise=noise, rate=rate, echo_rate=echo_rate,
        loop=loop, mode=mode, held=drive, supply=supply,
    )  # fmt: skip
    return bed.run(direction, seed=seed)
