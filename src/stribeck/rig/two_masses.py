"""An axis of parts whose motor and load move apart: a compliant transmission, with play."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ..constant import constant
from ..data.resolution import noise, step
from ..data.segmentation import rests
from ..errors import InputError
from ..friction import law_named
from ..units import convertible, unit
from .composed import ComposedRig
from .equation import Equation
from .motion.axis_row import rows
from .motion.coupling import LOAD_ROW, MOTOR_ROW, ZERO, CouplingConstants, coupled_row
from .motion.drives import TWO_MASSES
from .motion.track import SideReading, Track, prefix_sums
from .parts.axis_of_parts import completed, contributions, mass_row
from .parts.motion_equation import Side, coupled_equations
from .rig import Doubt, Motion

if TYPE_CHECKING:
    from collections.abc import Iterable

    from ..data.recording import Recording
    from ..friction import Law
    from ..space import Array, Param
    from .controller import Controller
    from .parts import Part

#: Sensors of one side each, and what a column with the motor's position is called.
SIDES = ("motor", "load")
MOTOR_POSITION = "motor_position"
#: What the motor's encoder shows more than the load's: coefficients of its sensor.
READING = ("per_load", "zero")
#: What the parameters of the motor's friction are called, after the law's own names for them.
OF_MOTOR = "_motor"
#: Way by which a step may be off under laws without states where nobody says, um or mrad: the rule
#: is of order 5, so that a tenth of it takes 1.6 times as long.
TOLERANCE = 0.02
#: Extremes of the way by which a motor is ahead, percentiles: the play's middle is between them.
_EXTREMES = (2.0, 98.0)
#: Share of that way that a flank is near.
_BAND = 0.25
#: Samples of a rest over which the start of a motion is a mean, at most.
_STILL = 50
#: The unit in the head of a column.
_HEAD_UNIT = re.compile(r"\[([^\[\]]+)\]\s*$")
#: What each log tells its rig and a user tells a simulator: the zero of a motor's encoder, and
#: where in its play a motion starts.
_ZERO = (
    "by how much the motor's encoder, over per_load, shows more than the load's in the middle of "
    "the play (of a log the mean of the greatest and the least such difference); the controller "
    "reads motor_position + zero where by_load is 0"
)
_START = "where in the play the motor is at a start at rest, −1 to 1"
#: Which signs are friction, and of what, by the side that has one.
_FRICTIONS = {
    "load": "F_f is friction",
    "motor": "F_f,m is friction, on the motor's side",
    "both": "F_f is friction of the load, F_f,m of the motor's side",
}
#: What a sensor's steps are as noise, root mean square.
_STEP = 12.0**-0.5


@dataclass(frozen=True, eq=False)
class TwoMassRig(ComposedRig):
    """An axis of two masses; friction acts on the load, on the motor, or on both.

    Its position is the load's where that has an encoder, or none is stated; else the motor's, in
    the load's unit. With an encoder on both sides, a log has the motor's in a column of its own.

    Args:
        friction_side: Where friction is.
        motor_law: The motor's own law, where both sides have friction; the load's by default.
        motor_column: Column of a log with the motor's position, where both are read.
    """

    friction_side: Side = "load"
    motor_law: str = ""
    motor_column: str = MOTOR_POSITION

    @property
    def further_columns(self) -> frozenset[str]:
        """The motor's position, too."""
        return super().further_columns | {self.motor_column}

    @property
    def encoders(self) -> Side:
        """Which sides are read."""
        read = {p.name for p in self.parts if p.role == "sensor" and p.name in SIDES}
        return "both" if len(read) > 1 else "motor" if read == {"motor"} else "load"

    def law_of_motor(self, law: Law) -> Law | None:
        """The law of the friction on the motor's side, of a law of the axis."""
        if self.friction_side == "both":
            return law_named(self.motor_law) if self.motor_law else law
        return law if self.friction_side == "motor" else None

    def own(self, law: Law) -> tuple[Param, ...]:
        """Its own parameters and, where both sides have friction, those of the motor's."""
        if self.friction_side != "both":
            return self.params
        motor = self.law_of_motor(law) or law
        named = (
            replace(q, name=q.name + OF_MOTOR, symbol="", doc=f"{q.doc}, on the motor's side")
            for q in motor.params
        )
        return (*self.params, *named)

    def check(self, values: Mapping[str, float]) -> None:
        """Refuse values with which nothing can be simulated."""
        super().check(values)
        if values.get("armature", 1.0) <= 0.0:
            raise InputError(
                f"rig {self.name}: armature = 0: the motor of an axis of two masses has an inertia"
            )
        if values.get("F_fm", 0.0) > 0.0 or any(q.name == "F_fm" for q in self.params):
            raise InputError(
                f"rig {self.name}: F_fm: friction of a motor with inertia is a law: [friction] "
                'side = "both"'
            )

    def constants_of_drive(self, law: Law, own: Array, run: Array) -> Array:
        """The rows of coupling, motor and load in one; see `coupled_row`."""
        by_name = {c.name: c.value for c in self.constants}
        by_name |= dict(zip(self.run_columns.values(), run.tolist(), strict=True))
        self.check(by_name)
        parameters = {q.name: own[:, k] for k, q in enumerate(self.own(law))}
        row = self.coupled_coefficients(by_name | parameters)
        masses = row[MOTOR_ROW], row[row[LOAD_ROW]]
        for side, mass in zip(("motor: state armature", "load"), masses, strict=True):
            if np.ndim(mass) == 0 and not mass > 0.0:
                raise InputError(
                    f"rig {self.name}: an axis of two masses needs an inertia above zero of the "
                    f"{side}"
                )
        return rows(row, len(own))

    def coupled_coefficients(self, values: Mapping[str, Any]) -> tuple[Any, ...]:
        """The rows of coupling, motor and load in one, as `coupled_row` makes it.

        Args:
            values: As of `coefficients`.
        """
        values = completed(self.parts, values)
        roles: dict[str, list[Part]] = {"motor": [], "load": [], "transmission": []}
        for part in self.parts:
            role = "transmission" if part.name in SIDES and part.role == "sensor" else part.role
            of_motor = role in ("controller", "sensor") or part.of_motor
            roles["motor" if of_motor else role].append(part)
        # What no motor is asked for is no force.
        motor, load = (
            mass_row(roles[mass], values, **fields)
            for mass, fields in (("motor", {}), ("load", {"force_limit": 0.0}))
        )
        coupling = CouplingConstants(**contributions(values, roles["transmission"]))
        return coupled_row(coupling, motor, load)

    def track(self, recording: Recording, rows: slice, x0: float, score: Array) -> Track:
        """Samples, inputs and start of a stretch, of the encoder that `position` is."""
        track = super().track(recording, rows, x0, score)
        reading = SideReading(by_motor=self.encoders == "motor", zero=self.stated_zero or 0.0)
        motor = self._motor_position(recording)
        if motor is not None:
            start = rows.start + np.flatnonzero(_still(recording, rows))[:_STILL]
            reading = self._read(recording, motor, start, x0)
        return track._replace(reading=reading)

    def readings(self, track: Track, recording: Recording, rows: slice) -> tuple[Track, ...]:
        """The load's track, and the motor's where both are read; see `SimulatedRig.readings`.

        Raises:
            InputError: the log lacks the motor's position.
        """
        motor = self._motor_position(recording)
        if self.encoders != "both":
            return (track,)
        if motor is None:
            raise InputError(
                f"{recording.label}: rig {self.name} reads both sides, and there is no column "
                f'{self.motor_column!r}: name the motor\'s in [inputs] motor_position = "HEAD"'
            )
        noises = [
            float(np.hypot(noise(log), step(log.position) * _STEP))
            for log in (recording, replace(recording, position=motor))
        ]
        weight = noises[0] / noises[1] if min(noises) > 0.0 else 1.0
        score = track.score.copy()
        score[: _forgotten(motor - recording.position, rows)] = 0.0
        reading = track.reading._replace(aligned=self.stated_zero is None)
        return tuple(
            track._replace(
                measured=measured,
                score=score,
                sums=prefix_sums(score, measured - track.x0),
                reading=shown,
            )
            for measured, shown in (
                (track.measured, reading),
                (
                    np.ascontiguousarray(motor[rows]),
                    reading._replace(by_motor=True, weight=weight),
                ),
            )
        )

    @property
    def stated_zero(self) -> float | None:
        """The zero of the motor's encoder, SI; None where each log tells it."""
        value = self.value_of("zero", np.nan)
        return value if np.isfinite(value) else None

    def doubts(self, recordings: Sequence[Recording]) -> Iterable[Doubt]:
        """A middle of the play that is told by logs in which a load pulls to one side, too."""
        yield from super().doubts(recordings)
        pulls = any(p.stated(name) for p in self.parts if p.role == "load" for name in p.forces)
        if pulls and self.encoders == "both" and self.stated_zero is None:
            yield Doubt(
                "the play's middle is taken to be in the middle of what the two encoders differ "
                "by, and a load that pulls to one side (gravity, a spring, an offset) twists the "
                "shaft there: state zero, of [sensor.motor]"
            )

    @property
    def per_load(self) -> float:
        """What the motor's encoder shows for a unit of the load's position."""
        return self.value_of("per_load", 1.0)

    def _motor_position(self, recording: Recording) -> Array | None:
        """The motor's position in a log, in the load's unit, (N,)."""
        if self.encoders != "both" or self.motor_column not in recording.extra:
            return None
        self._check_scale(recording)
        motor: Array = np.asarray(recording.extra[self.motor_column], dtype=float) / self.per_load
        if not np.isfinite(motor).all():
            raise InputError(
                f"{recording.label}: {self.motor_column}: a position that is no finite number"
            )
        return motor

    def _check_scale(self, recording: Recording) -> None:
        """Refuse a motor's position that its head has in a unit of which nobody speaks.

        Raises:
            InputError: its head has mm, say, and no `per_load` is stated.
        """
        way, head = self.si_unit("position"), _HEAD_UNIT.search(self.motor_column)
        if head is None or any(c.name == "per_load" for c in self.constants):
            return
        try:
            factor = unit(head[1]).factor if convertible(head[1], way) else 1.0
        except InputError:  # nobody knows that unit
            return
        if factor != 1.0:
            raise InputError(
                f"{recording.label}: {self.motor_column}: the motor's position is read as it is "
                f"written: state what it shows for 1 {way} of the load, [sensor.motor] per_load = "
                f"{1.0 / factor:.10g}, times the ratio where it counts the motor's own way"
            )

    def _read(self, recording: Recording, motor: Array, start: Array, x0: float) -> SideReading:
        """How far the motor is ahead at a start, and what it shows more than the load's."""
        difference = motor - recording.position
        zero = float(np.mean(np.percentile(difference, _EXTREMES)))
        if self.stated_zero is not None:
            zero = self.stated_zero
        ahead = float(difference[start].mean()) - zero
        return SideReading(ahead=ahead, zero=float(motor[start].mean()) - x0 - ahead)

    def thinned(self, tracks: Sequence[Track]) -> list[Track] | None:
        """None where two encoders read one motion."""
        return None if self.encoders == "both" else super().thinned(tracks)

    def move(self, law: Law, p: Array, track: Track) -> Motion:
        """The motion of the side that a track has measured; see `SimulatedRig.move`."""
        q_m, v_m, q, v, F = self._both(law, p, (track,))
        velocity = v_m if track.reading.by_motor else v
        return Motion(track.t, _as_read(q_m, q, track), velocity, F)

    def sides(self, law: Law, p: Array, track: Track) -> tuple[Motion, Motion]:
        """The motions of the motor, as its encoder reads it, and of the load, over a track."""
        q_m, v_m, q, v, F = self._both(law, p, (track,))
        return Motion(track.t, q_m + track.reading.zero, v_m, F), Motion(track.t, q, v, F)

    def positions_over(self, law: Law, p: Array, tracks: Sequence[Track]) -> Array:
        """The positions over several tracks as they were read, each motion simulated once."""
        distinct: list[Track] = []
        places = []
        for track in tracks:
            place = next((i for i, o in enumerate(distinct) if _same_motion(o, track)), None)
            if place is None:
                place = len(distinct)
                distinct.append(track)
            places.append(place)
        q_m, _, q, _, _ = self._both(law, p, distinct)
        ends = np.cumsum([len(track.t) for track in distinct])[:-1]
        parts = list(zip(np.split(q_m, ends, axis=1), np.split(q, ends, axis=1), strict=True))
        read = [_as_read(*parts[i], track) for i, track in zip(places, tracks, strict=True)]
        return np.concatenate(read, axis=1)

    def _both(
        self, law: Law, p: Array, tracks: Sequence[Track]
    ) -> tuple[Array, Array, Array, Array, Array]:
        """Positions and velocities of motor and load over tracks, and the motor's force."""
        p = self.checked(law, p)
        k = len(law.params)
        from .motion.coupled_motions import motions_of_two  # noqa: PLC0415 - compiled code that others need not load

        own = p[:, k:]
        c = self.constants_over(law, own, tracks)
        c[:, :, ZERO] = np.array([track.reading.zero for track in tracks])[:, None]
        motor = self.law_of_motor(law)
        friction = {"load": own[:, :0], "motor": p[:, :k]}.get(
            self.friction_side, own[:, len(self.params) :]
        )
        laws = (motor, None if self.friction_side == "motor" else law)
        shares = (friction, p[:, :k])
        motion = motions_of_two(laws, shares, c, tracks, self["step"], self["tolerance"])
        if self.friction_side == "both" and motor is not None:
            unphysical = ~np.asarray(motor.physical(friction), dtype=bool)
            for part in motion:
                part[unphysical] = np.nan
        return motion

    def imbalance(
        self, law: Law, p: Array, track: Track, motion: tuple[Array, Array, Array]
    ) -> Array | None:
        """None: what is left over of the motion of one mass is the other's."""
        del law, p, track, motion
        return None

    def resting(self, track: Track, instant: float, position: float) -> Array | None:
        """None: what the spring carries at a rest is not in a log."""
        del track, instant, position
        return None

    def controller(self) -> Controller | None:
        """None: what a compensator does to a loop is tried on one mass."""
        return None

    def equation(self, law: Law) -> Equation:
        """The parts and what drives them."""
        one = super().equation(law)
        further = []
        if self.commanded and self.encoders == "both":
            zero = self.stated_zero or 0.0
            further.append(constant("zero", zero, self.si_unit("position"), _ZERO, "each log"))
        stated = {c.name for c in self.constants} | {q.name for q in self.params}
        if "start" not in stated:
            further.append(constant("start", 0.0, "", _START, "each log"))
        return replace(
            one,
            drive=TWO_MASSES,
            friction=_FRICTIONS[self.friction_side],
            constants=tuple(n for n in one.constants if n not in READING),
            coefficients=self._read_coefficients,
            further=tuple(further),
        )

    def equations(self) -> tuple[str, ...]:
        """Those of both masses."""
        of_motor = "(q_m + zero)" if self.encoders == "both" else "q_m"
        read = "q" if self.value_of("by_load", 0.0) else of_motor
        return coupled_equations(self.parts, friction=self.friction_side, read=read)

    def _read_coefficients(self, values: Mapping[str, Any]) -> tuple[Any, ...]:
        """The same as `coupled_coefficients`, with the zero of the motor's encoder."""
        row = list(self.coupled_coefficients(values))
        row[ZERO] = values.get("zero", 0.0)
        return tuple(row)


def two_masses(parts: Iterable[Part]) -> bool:
    """Whether parts make an axis of two masses."""
    return any(p.role == "transmission" and p.name == "compliant" for p in parts)


def _as_read(q_m: Array, q: Array, track: Track) -> Array:
    """What the encoder of a track shows of the positions of motor and load, (n, N)."""
    reading = track.reading
    position = q_m + reading.zero if reading.by_motor else q
    counts = track.score > 0
    if reading.aligned and counts.any():
        position = position + (track.measured - position)[:, counts].mean(axis=1, keepdims=True)
    return position


def _same_motion(one: Track, other: Track) -> bool:
    """Whether two tracks are of one motion, read by two encoders."""
    return (
        one.inputs is other.inputs
        and (one.x0, one.v0, one.reading.ahead) == (other.x0, other.v0, other.reading.ahead)
        and one.given is other.given
    )


def _forgotten(ahead: Array, rows: slice) -> int:
    """Samples of a track after which it does not matter any more where its play began.

    By then the motor has been ahead and behind, by the measured way by which it is: at both flanks.
    """
    low, high = np.percentile(ahead, _EXTREMES)
    band = _BAND * (high - low)
    within = ahead[rows]
    first = [np.flatnonzero(side) for side in (within < low + band, within > high - band)]
    return int(max(side[0] for side in first)) if all(map(len, first)) else 0


def _still(recording: Recording, rows: slice) -> Array:
    """Which of the samples of a track are those of the rest in which it starts; else the first."""
    still = np.zeros(rows.stop - rows.start, dtype=bool)
    still[0] = True
    for rest in rests(recording):
        if rest.start <= rows.start < rest.stop:
            still[: rest.stop - rows.start] = True
    return still
