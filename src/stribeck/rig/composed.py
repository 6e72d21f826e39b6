"""An axis composed of parts: a controller, a motor, a transmission, loads, sensors."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from ..constant import SMALLEST, Constant, constant
from ..errors import InputError
from .composition import POSITION, Block
from .equation import Equation, Input
from .experiments.pushes import pushes
from .motion.drives import (
    ADDED,
    AXIS,
    ENABLED,
    EXTERNAL_FORCE,
    FEED_FORWARD,
    FOLLOWS,
    GOAL,
    GOAL_VELOCITY,
    HELD,
    IDLE,
    INPUTS,
)
from .parts.axis_of_parts import assembled, in_units, motor_turns
from .parts.motion_equation import motion_equations
from .rig import Doubt
from .stepped import SteppedRig

if TYPE_CHECKING:
    from ..data.recording import Recording
    from ..friction import Law
    from ..space import Array, Param
    from .experiments.offer import Course, Offer, OperatingRange
    from .motion.track import Track
    from .parts import Part

#: What a log may say beside its channels, by input, and the column that says so by default.
INPUT_COLUMNS = MappingProxyType(
    {
        "goal_velocity": "command_velocity",
        "feed_forward": "feed_forward",
        "enabled": "torque_enable",
        "external": "external",
    }
)
#: Parts of an axis on which nothing acts but a force.
_PUSHED = frozenset({
    ("controller", "none"), ("motor", "force"), ("transmission", "rigid"), ("load", "mass"),
})  # fmt: skip
#: Share by which a log's samples may be apart from its controller's.
_CLOCK = 0.01
#: Coefficients that act on a sampled controller alone, and what has them.
_SAMPLED = MappingProxyType({
    "ki": "one that integrates",
    "difference": "one that takes differences of positions",
    "resolution": "one that reads the steps of an encoder",
})  # fmt: skip
#: Units of what a motor is asked for, and their names in a log.
_DEMANDS = {"force": ("N", "N m"), "current": ("A", "A"), "voltage": ("V", "V")}


@dataclass(frozen=True, eq=False)
class ComposedRig(SteppedRig):
    """An axis of parts; its constants and its own parameters are their coefficients.

    Args:
        parts: Controller, motor, transmission, loads, sensors.
        input_columns: Columns of what a log may say beside its channels, by input.
        table: What a user composed it of; None for a shipped rig.
    """

    parts: tuple[Part, ...] = ()
    input_columns: Mapping[str, str] = field(default_factory=lambda: INPUT_COLUMNS)
    table: Mapping[str, Any] | None = None

    @classmethod
    def compose(cls, name: str, parts: Iterable[Part], *, rotary: bool, **declared: Any) -> Self:
        """A rig of parts.

        Args:
            name: What it is called.
            parts: A controller, a motor, a transmission, loads, sensors.
            rotary: Whether it turns.
            declared: Whatever else it is declared with; constants come after those of the parts.

        Raises:
            InputError: a part is missing, stands twice, or is of the other kind of axis; two
                parts have a coefficient of the same name.
        """
        parts = in_units(parts, rotary=rotary)
        check_roles(name, parts, rotary)
        stated = [c for p in parts for c in p.coefficients]
        declared["constants"] = (
            *(c.constant for c in stated if c.constant is not None),
            *declared.get("constants", ()),
        )
        declared["params"] = tuple(c.param() for c in stated if c.identified)
        declared.setdefault("applied_force", not any(p.commanded for p in parts))
        return cls(name=name, parts=parts, rotary=rotary, **declared)

    @property
    def further_columns(self) -> frozenset[str]:
        """Those of its inputs, too."""
        return super().further_columns | {*self.input_columns.values()}

    @property
    def commanded(self) -> bool:
        """Whether its position is asked for by a controller."""
        return any(p.commanded for p in self.parts)

    @property
    def composition(self) -> tuple[Block, ...]:
        """Its parts in the order in which power flows."""
        blocks = tuple(
            Block(
                p.role, p.name, p.doc, p.contribution,
                tuple(c.name for c in p.coefficients if c.constant is not None),
            )
            for p in self.parts
        )  # fmt: skip
        return blocks if any(b.role == "sensor" for b in blocks) else (*blocks, POSITION)

    @property
    def demand(self) -> str:
        """What its motor is asked for: "force", "current" or "voltage"."""
        return next(p.drive for p in self.parts if p.role == "motor")

    @property
    def only_pushed(self) -> bool:
        """Whether its parts are an ideal motor, a rigid transmission and masses."""
        return {(p.role, p.name) for p in self.parts} <= _PUSHED

    @property
    def clock(self) -> float | None:
        """The sample time of a controller that integrates or takes differences, s; else None."""
        used = {c.name for c in self.constants if c.value} | {q.name for q in self.params}
        T = self.value_of("T", 0.0)
        return T if T > 0.0 and used & {"ki", "difference"} else None

    @property
    def entry(self) -> int | None:
        """Where a compensator's output enters; None without a controller."""
        return FEED_FORWARD if self.commanded else None

    @property
    def holds_force(self) -> bool:
        """Whether the demand of its controller is held from sample to sample."""
        return self.value_of("hold", FOLLOWS) > FOLLOWS

    def inputs(self, recording: Recording) -> Mapping[str, Array]:
        """What drives the axis, (N,) by input.

        Raises:
            InputError: the log has no command, or no force, current or voltage.
        """
        units, read = self._input_units, read_inputs(self.parts)
        given = {
            name: recording.further(column, units[name])
            for name, column in self.input_columns.items()
            if column in recording.extra and name in read
        }
        if recording.known_force is not None:
            given["external"] = given.get("external", 0.0) - recording.known_force.values
        if not self.commanded:
            return {"added": self._recorded_demand(recording), **given}
        if recording.command is None:
            raise InputError(
                f"{recording.label}: rig {self.name} needs the commanded position: map a column "
                "to command"
            )
        steps = {"goal": recording.command, "feed_forward": np.zeros(len(recording)), **given}
        if any(p.follows_velocity for p in self.parts):
            steps.setdefault("goal_velocity", np.gradient(recording.command, recording.t))
        return steps

    def _absent(self, recording: Recording) -> str:
        """What counts in place of columns that its axis file names and a log lacks."""
        if self.table is None:
            return ""
        counts = {c.name: f"{c.shown:g} {c.unit}".strip() for c in self.constants}
        idle = {"goal_velocity": "the slope of the command", "enabled": "always on"}
        if not any(p.follows_velocity for p in self.parts):
            idle["goal_velocity"] = "0"
        read = {column: (name, counts[name]) for column, name in self.run_columns.items()}
        inputs: Mapping[str, str] = self.table.get("inputs", {})
        read |= {
            c: (name, idle.get(name, "0")) for name, c in inputs.items() if name in INPUT_COLUMNS
        }
        absent = [
            f"{name} ({column!r}) is {value}"
            for column, (name, value) in read.items()
            if column not in recording.extra
        ]
        if not absent:
            return ""
        what = "; ".join(absent)
        return f"{recording.label}: the log lacks columns that the axis file names: {what}"

    def doubts(self, recordings: Sequence[Recording]) -> Iterable[Doubt]:
        """Columns that logs lack, and a controller whose time counts on another clock, too."""
        yield from (Doubt(s, harmful=False) for s in map(self._absent, recordings) if s)
        yield from super().doubts(recordings)
        if (clock := self.clock) is None:
            return
        for log in recordings:
            if abs(log.dt / clock - 1.0) > _CLOCK:
                yield Doubt(
                    f"{log.label}: the controller computes every {1e3 * clock:.4g} ms (T), and is "
                    f"simulated at each sample of the log, every {1e3 * log.dt:.4g} ms: what it "
                    "integrates and what it takes for its velocity are off by that: state T, or "
                    "log each of its samples"
                )

    def _si_unit_of(self, param: Param) -> str:
        """The SI unit of a parameter; those of its parts have that of their axis."""
        own = any(q.name == param.name for q in self.params)
        return param.unit if own else super()._si_unit_of(param)

    def coefficients(self, values: Mapping[str, Any]) -> tuple[Any, ...]:
        """The row of constants of its parts; see `SteppedRig.coefficients`."""
        return assembled(self.parts, values)

    def limits(self, name: str) -> tuple[float, float]:
        """Between which values a constant can be simulated, SI, by its part."""
        return self._limits_of_parts.get(name, super().limits(name))

    @cached_property
    def _limits_of_parts(self) -> Mapping[str, tuple[float, float]]:
        return {c.name: c.limits for part in self.parts for c in part.coefficients}

    def check(self, values: Mapping[str, float]) -> None:
        """Refuse values with which nothing can be simulated."""
        super().check(values)
        for c in (c for part in self.parts for c in part.coefficients if c.choices):
            if c.name in values and (fault := c.fault(values[c.name])):
                raise InputError(f"rig {self.name}: {c.name} = {values[c.name]:g} {fault}")
        if values.get("hold", self.value_of("hold", FOLLOWS)) != FOLLOWS:
            return
        searched = {q.name for q in self.params}
        for name, what in _SAMPLED.items():
            if values.get(name, 0.0) > 0 or name in searched:
                stated = f" = {values[name]:g}" if name in values else ""
                raise InputError(
                    f"rig {self.name}: {name}{stated}: {what} is sampled: a controller with "
                    "hold = 1 or 2"
                )

    def value_of(self, name: str, absent: float) -> float:
        """A coefficient as it is stated, or idle; another value where no part has it."""
        stated = (c.value for c in self.constants if c.name == name)
        idle = (c.idle for p in self.parts for c in p.coefficients if c.name == name)
        return next((value for value in (*stated, *idle) if value is not None), absent)

    def with_constants(self, track: Track, recording: Recording) -> Track:
        """The track with the constants of its run, and the force as this rig's drive makes it."""
        track = super().with_constants(track, recording)
        if self.drive_chain is None or self.commanded:
            return track
        inputs = track.inputs.copy()
        added = self._recorded_demand(recording)
        inputs[ADDED] = np.interp(track.t, recording.t, added)
        return track._replace(inputs=inputs)

    @property
    def motor_friction(self) -> float:
        """Coulomb friction of its motor, which takes its share of a command, N or N m."""
        return self.value_of("F_fm", 0.0)

    def command_per_force(self, law: Law, p: Array) -> float:
        """The demand for a unit of force or torque at the axis."""
        from .motion.drive_force import loop_gains  # noqa: PLC0415 - compiled code that others need not load

        run = np.array([self[name] for name in self.run_columns.values()])
        row = self.constants_of_drive(law, p[None, len(law.params) :], run)[0]
        return 1.0 / float(loop_gains(row)[0])

    def resting(self, track: Track, instant: float, position: float) -> Array | None:
        """Position and inputs at an instant; see `SimulatedRig`. None where it is not commanded."""
        if not self.commanded:
            return None
        stated = track.inputs
        if self.holds_force:
            # Samples from which a demand is computed to its start.
            late = int(self.value_of("hold", HELD)) - HELD
            k = int(np.searchsorted(track.t, instant, side="right")) - 1 - late
            now = stated[:, max(k, 0)]
        else:
            now = np.array([np.interp(instant, track.t, values) for values in stated])
        return np.array([position, *now, *IDLE[len(now) :], *track.given])

    def pull(self, law: Law, p: Array, resting: Array) -> Array:
        """Force of the motor and of what acts on the load; see `SimulatedRig`."""
        if not self.commanded:
            return super().pull(law, p, resting)
        from .motion.force_imbalance import resting_forces  # noqa: PLC0415 - compiled code that others need not load

        own, place = p[:, len(law.params) :], 1 + INPUTS
        forces = np.empty((len(p), len(resting)))
        runs, which = np.unique(resting[:, place:], axis=0, return_inverse=True)
        for i, run in enumerate(runs):
            rows = np.flatnonzero(which.ravel() == i)
            constants = self.constants_of_drive(law, own, run)
            forces[:, rows] = resting_forces(constants, resting[rows, :place])
        return forces

    def experiments(self, axis: OperatingRange, seconds: float) -> Iterable[Offer]:
        """Where a force is applied, sines below breakaway and triangles beyond it; else strokes."""
        if self.commanded or self.demand != "force":
            return super().experiments(axis, seconds)

        def travel(course: Course) -> float:
            track = self.course_track(course, axis.temperature)
            motion = self.move(axis.law, axis.p[None], track)
            return float(np.abs(motion.position - track.x0).max())

        return pushes(axis, travel, seconds)

    def equation(self, law: Law) -> Equation:
        """The parts and what drives them; F_f is friction."""
        del law
        own = {c.name for p in self.parts for c in p.coefficients}
        return Equation(
            AXIS,
            ";  ".join(self.equations()),
            self._simulator_inputs(),
            tuple(c.name for c in self.constants if c.name in own),
            self.coefficients,
            own_step=True,
        )

    def equations(self) -> tuple[str, ...]:
        """The equation of motion that its parts make; see `motion_equations`."""
        return motion_equations(self.parts)

    @property
    def _input_units(self) -> Mapping[str, str]:
        """SI units of its inputs."""
        return {
            "goal_velocity": self.si_unit("velocity"),
            "feed_forward": _DEMANDS[self.demand][motor_turns(self.parts, rotary=self.rotary)],
            "enabled": "",
            "external": self.si_unit("force"),
        }

    def _simulator_inputs(self) -> tuple[Input, ...]:
        """What a simulator has to tell the axis."""
        position, speed = self.si_unit("position"), self.si_unit("velocity")
        units = self._input_units
        asked = units["feed_forward"]
        if not self.commanded:
            return (Input(self.demand, asked, "of the drive", ADDED),)
        inputs = [Input("command", position, "commanded position", GOAL)]
        if any(p.takes_velocity for p in self.parts):
            inputs.append(Input("command_velocity", speed, "its velocity", GOAL_VELOCITY))
        inputs += [
            Input("feed_forward", asked, "added to what the controller asks for", FEED_FORWARD),
            Input("enabled", "", "above 0.5: the motor drives", ENABLED, 1.0, held=True),
            Input("external", self.si_unit("force"), "on the load from outside", EXTERNAL_FORCE),
        ]
        return tuple(inputs)

    def _recorded_demand(self, recording: Recording) -> Array:
        """The force, current or voltage of the drive in a log, (N,).

        Raises:
            InputError: it has none.
        """
        if self.demand == "force":
            return self.needed_force(recording)
        demand = recording.current if self.demand == "current" else recording.voltage
        if demand is None:
            raise InputError(
                f"{recording.label}: rig {self.name} needs the {self.demand} of the motor: map a "
                f"column to {self.demand}"
            )
        return demand


def settings(
    unit: str, tolerance: float = 0.001, source: str = "docs/rigs.md"
) -> tuple[Constant, ...]:
    """The step and the tolerance of a simulation, the latter in a unit of the position."""
    return (
        constant(
            "step", 20.0, "ms", "longest step of the simulation", "docs/rigs.md", least=SMALLEST
        ),
        constant(
            "tolerance", tolerance, unit, "way by which a step may be off", source, least=SMALLEST
        ),
    )


def read_inputs(parts: Iterable[Part]) -> tuple[str, ...]:
    """Of `INPUT_COLUMNS` those that an axis of parts reads."""
    parts = tuple(parts)
    absent = {
        "goal_velocity": not any(p.takes_velocity for p in parts),
        "feed_forward": not any(p.commanded for p in parts),
    }
    return tuple(name for name in INPUT_COLUMNS if not absent.get(name))


def check_roles(name: str, parts: tuple[Part, ...], rotary: bool) -> None:
    """Refuse parts that make no axis."""
    for role in ("controller", "motor", "transmission"):
        if (n := sum(p.role == role for p in parts)) != 1:
            raise InputError(f"rig {name}: an axis has one {role}, this one {n or 'none'}")
    if not any(p.role == "load" for p in parts):
        raise InputError(f"rig {name}: an axis has a load, this one none")
    if not any(p.stated(c) for p in parts for c in p.inertia):
        raise InputError(
            f"rig {name}: nothing of it has an inertia: it takes a load.mass, load.inertia or "
            "load.pendulum, or the armature of its motor"
        )
    controller, motor = (next(p for p in parts if p.role == r) for r in ("controller", "motor"))
    if controller.drive not in ("", motor.drive):
        raise InputError(
            f"rig {name}: controller.{controller.name} sets a {controller.drive}, and "
            f"motor.{motor.name} takes a {motor.drive}"
        )
    _check_names(name, parts, rotary)


def _check_names(name: str, parts: tuple[Part, ...], rotary: bool) -> None:
    """Refuse parts of the other kind of axis, and two coefficients of one name."""
    kinds = ("linear", "rotary")
    owners: dict[str, Part] = {}
    for p in parts:
        if p.rotary is not None and p.rotary != rotary:
            raise InputError(
                f"rig {name}: {p.role}.{p.name} is of {kinds[p.rotary]} axes, and this one is "
                f"{kinds[rotary]}"
            )
        for c in p.coefficients:
            if c.name in owners:
                other = owners[c.name]
                raise InputError(
                    f"rig {name}: {other.role}.{other.name} and {p.role}.{p.name} both have a "
                    f"{c.name}"
                )
            owners[c.name] = p
