"""A rig: its constants, its own free parameters, and its answers to what every command asks."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any, ClassVar, Literal, Self

import numpy as np

from ..constant import Constant, Origin, Stated, out_of_limits
from ..data.alignment import MOTION_CHANNELS, advanced
from ..data.force_channel import force_left_out
from ..data.power_flow import loss_factors
from ..data.recording import Recording
from ..drive import DriveChain, refuse_without_drive
from ..errors import InputError
from ..friction import Law
from ..space import Array, Param, Rng
from ..units import convertible, unit
from ..wording import option
from .composition import POSITION, Block
from .controller import Controller
from .equation import Equation
from .experiments.offer import Offer, OperatingRange
from .position_loop import PositionLoop

Approach = Literal["output_error", "force_balance"]


#: What a unit of a linear axis is on a rotary one.
_ROTARY = {
    "N": "N m",
    "N s/m": "N m s/rad",
    "m/s": "rad/s",
    "m": "rad",
    "1/m": "1/rad",
    "N/m": "N m/rad",
    "kg": "kg m**2",
}
#: Currents are so much smaller than forces: what their search ranges are of these.
_PER_NEWTON = 1e-3
#: What a unit is where forces stay currents.
_ELECTRIC = {
    "N": "A",
    "N m": "A",
    "N s/m": "A s/m",
    "N m s/rad": "A s/rad",
    "N/m": "A/m",
    "N m/rad": "A/rad",
    "kg": "A s**2/m",
    "kg m**2": "A s**2/rad",
}
#: Rigs that there are for a rotary axis, too, by another name.
_BOTH, _TURNS = ("forced", "presliding"), "-rotary"
#: The end of a name of one direction or of one element.
_SUFFIX = re.compile(r"(?<=^[A-Za-z])_\d+$|[+-]$")


def stem(name: str) -> str:
    """What the parameters of both directions are called together, or those of all elements.

    `F_S+` is one of F_S, `W_3` one of W.
    """
    return _SUFFIX.sub("", name)


@dataclass(frozen=True)
class Doubt:
    """What a rig does not hold for in logs.

    Args:
        sentence: What, by how much, and what can be done.
        harmful: Whether no value is identified for it; if not, it is only told.
    """

    sentence: str
    harmful: bool = True


@dataclass(frozen=True, eq=False)
class Motion:
    """Simulated trajectories of n parameter sets over N samples, SI.

    Args:
        t: Sample times, (N,).
        position: (n, N).
        velocity: (n, N).
        force: Force of the drive on the axis, (n, N).
    """

    t: Array
    position: Array
    velocity: Array
    force: Array


@dataclass(frozen=True, eq=False)
class Rig:
    """A kind of axis with its constants.

    What a subclass does not answer stays as here: None, or a refusal in one line.

    Args:
        name: The name it is listed under.
        doc: What it is, in a line.
        cite: Its source.
        constants: Known quantities.
        params: Free parameters of its own, beside the law's, SI.
        laws: Laws it was made for; the first is the default. Every other law works too.
        ranges: Search ranges (lower, upper) that replace a law's own, SI, by parameter, or by
            the stem of several: F_S is for F_S+ and F_S-, W for W_1, W_2 and so on.
        bounded: The parameters, or stems of several, whose range is the user's.
        shows: The unit in which people see a parameter or quantity, by name; SI where silent.
        labels: What the rig's literature calls a parameter, by the law's name for it.
        columns: Columns of its log format: channel -> "head", "head [unit]", or a table as the
            reader of logs takes it.
        rotary: Whether the axis turns: forces are then torques, masses moments of inertia.
        loads: Which loads a law may read here, of `friction.LOADS`.
        applied_force: Whether a force is applied and measured instead of a motion commanded.
        hand_gauge: Whether its breakaway force can be measured with a force gauge by hand.
        known_scale: Whether known gains and a known mass alone set the scale of its forces.
        scale: The channel that forces, masses and stiffnesses are in proportion to; empty where
            constants set the scale.
        loop: The controller around an axis that was identified without one.
        drive_chain: The chain from what its drive records to the force at the axis, as stated; the
            numbers that act are constants of the rig.
    """

    #: How its laws are identified: by simulating the motion, or by a balance of measured forces.
    approach: ClassVar[Approach]

    name: str
    doc: str
    cite: str
    constants: tuple[Constant, ...] = ()
    params: tuple[Param, ...] = ()
    laws: tuple[str, ...] = ("stribeck",)
    ranges: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    bounded: frozenset[str] = frozenset()
    shows: Mapping[str, str] = field(default_factory=dict)
    labels: Mapping[str, str] = field(default_factory=dict)
    columns: Mapping[str, Any] = field(default_factory=dict)
    rotary: bool = False
    loads: tuple[str, ...] = ()
    applied_force: bool = False
    hand_gauge: bool = False
    known_scale: bool = False
    scale: str = ""
    loop: PositionLoop | None = None
    drive_chain: DriveChain | None = None

    def __post_init__(self) -> None:
        for name in ("ranges", "shows", "labels", "columns"):
            object.__setattr__(self, name, MappingProxyType(dict(getattr(self, name))))

    def in_step(self, recording: Recording, seconds: float) -> Recording:
        """A log whose drive was measured so much later than its motion, with both at one time.

        A measured force is moved back; where a motion is commanded, the measured one the other way.

        Raises:
            InputError: as `advanced`.
        """
        if self.approach == "force_balance" or self.applied_force:
            return advanced(recording, seconds)
        return advanced(recording, -seconds, MOTION_CHANNELS)

    def __getitem__(self, name: str) -> float:
        """A constant's value, SI.

        Raises:
            InputError: the rig has no such constant.
        """
        for c in self.constants:
            if c.name == name:
                return c.value
        refuse_without_drive(name, self.name)
        raise InputError(
            f"rig {self.name} has no constant {name!r}: it has {self._constants()}; a parameter is "
            f"held by {option('fixed', {name: 'VALUE'})}"
        )

    def set(self, **values: Stated) -> Self:
        """The same rig with constants of the user's, in the units it shows.

        A number is exact; of a pair the second is the tolerance; a third says who vouches for it.
        """
        for name in values:
            self[name]
        rig = self._with(
            c.with_value(*_stated(values[c.name])) if c.name in values else c
            for c in self.constants
        )
        rig.check({c.name: c.value for c in rig.constants})
        return rig

    def exact(self) -> Self:
        """The same rig with all its constants taken as exact."""
        return self._with(c.exact() for c in self.constants)

    def estimated(self, values: Mapping[str, float]) -> Self:
        """The same rig with other values of constants, SI; what is known of them stays."""
        return self._with(
            replace(c, value=values[c.name]) if values.get(c.name, c.value) != c.value else c
            for c in self.constants
        )

    def limits(self, name: str) -> tuple[float, float]:
        """Between which values a constant can be simulated, SI."""
        return next((c.least for c in self.constants if c.name == name), -np.inf), np.inf

    def check(self, values: Mapping[str, float]) -> None:
        """Refuse constants, SI by name, with which nothing can be simulated.

        Raises:
            InputError: one of them.
        """
        for c in self.constants:
            value = values.get(c.name, c.value)
            if fault := out_of_limits(value, *self.limits(c.name)):
                shown = f"{unit(c.unit).from_si(value):g} {c.unit}".strip()
                raise InputError(f"rig {self.name}: {c.name} = {shown} {fault}")

    @property
    def composition(self) -> tuple[Block, ...]:
        """Its parts in the order in which power flows; here a load under a measured force."""
        drive = (
            () if self.drive_chain is None else tuple(c.name for c in self.drive_chain.constants)
        )
        others = tuple(c.name for c in self.constants if c.name not in drive)
        what = "torque" if self.rotary else "force"
        return (
            Block("motor", "measured", f"the {what} of the drive, as it was measured", "", drive),
            Block("load", "inertia" if self.rotary else "mass", self.doc, "", others),
            POSITION,
        )

    @property
    def further_columns(self) -> frozenset[str]:
        """Heads of its logs that it reads beside their channels."""
        return frozenset()

    @property
    def rests_on_force(self) -> bool:
        """Whether its fits rest on a measured force."""
        return self.approach == "force_balance" or self.applied_force

    def driven(self, chain: DriveChain) -> Self:
        """The same rig behind a drive, the chain's numbers among its constants.

        Raises:
            InputError: it has another drive, or a constant of the same name.
        """
        if self.drive_chain is not None:
            raise InputError(f"rig {self.name} has a drive already: state one")
        names = {c.name for c in self.constants}
        if clash := [c.name for c in chain.constants if c.name in names]:
            raise InputError(f"rig {self.name} and its drive both have a constant {clash[0]}")
        further = chain.constants if self.rests_on_force else ()
        return replace(self, drive_chain=chain, constants=(*self.constants, *further))

    @property
    def chain(self) -> DriveChain | None:
        """The chain of its drive with the numbers as its constants have them now."""
        return None if self.drive_chain is None else self.drive_chain.with_constants(self.constants)

    def behind(self, recordings: Iterable[Recording]) -> Self:
        """The same rig behind the drive that its logs came through.

        Raises:
            InputError: the logs came through different chains.
        """
        rig = self
        for log in recordings:
            if log.drive is None:
                continue
            if rig.drive_chain is None:
                rig = rig.driven(log.drive)
            elif not rig.drive_chain.alike(log.drive):
                raise InputError(
                    f"{log.label}: its force came through another drive chain than that of "
                    "the rig or of the logs before it: identify them one by one"
                )
        return rig

    def force_of(self, recording: Recording) -> Array | None:
        """The force of the drive in a log, (N,), by the chain as this rig has it; None if none."""
        force, now = recording.force, self.chain
        if force is None or now is None or not self.rests_on_force:
            return force
        then = recording.drive or self.drive_chain
        if then is None or then == now:
            return force
        force = force * (now.gain / then.gain)
        if now.lossy:
            motion = recording.t, recording.position, recording.velocity
            before = loss_factors(then, *motion, force)  # signs are all that it reads of a force
            force = force * loss_factors(now, *motion, force) / before
        return force

    def needed_force(self, recording: Recording) -> Array:
        """The same, (N,), for a rig that cannot do without.

        Raises:
            InputError: the log has none; what may stand for it is told.
        """
        force = self.force_of(recording)
        if force is not None:
            return force
        if left := force_left_out(recording):
            hint = f": {left}"
        elif recording.current is not None:
            hint = ': map a column to force, or its current with a [drive] table (signal = "A", kt)'
        else:
            hint = ": map a column to force"
        raise InputError(
            f"{recording.label}: rig {self.name} needs the measured force of the drive{hint}"
        )

    def doubts(self, recordings: Sequence[Recording]) -> Iterable[Doubt]:
        """What it does not hold for in logs, and what it takes in place of what they lack."""
        del recordings
        return ()

    @property
    def in_amperes(self) -> bool:
        """Whether its forces are a motor's current, because the chain has no torque constant."""
        return self.drive_chain is not None and self.drive_chain.unit == "A" and self.rests_on_force

    def check_turning(self, recording: Recording, instead: str = "") -> None:
        """Refuse a log of an angle where this axis is linear, or the other way round.

        Args:
            recording: The log.
            instead: What to do where the axis is settled; by default to use the rig for such logs.

        Raises:
            InputError: it is one.
        """
        if recording.rotary == self.rotary:
            return
        kinds = ("an angle", "linear") if recording.rotary else ("a length", "rotary")
        kind, name = _TURNS if recording.rotary else "", self.name.removesuffix(_TURNS)
        force = "torque" if recording.rotary else "force"
        use = name + kind if name in _BOTH else f"forced{kind} if the {force} was measured"
        raise InputError(
            f"{recording.label}: position is {kinds[0]}, and rig {self.name} is {kinds[1]}: "
            f"{instead or f'use {use}'}"
        )

    def check_newtons(self, purpose: str) -> None:
        """Refuse what takes forces where there are only currents.

        Args:
            purpose: What takes them, for the message.

        Raises:
            InputError: friction is in amperes.
        """
        if self.in_amperes:
            raise InputError(
                f"friction is in A, as the drive's chain has no kt, and {purpose} takes "
                f'{"N m" if self.rotary else "N"}: state kt = "0.52 N m/A rms" in its [drive] '
                "table and identify again"
            )

    @property
    def uncertain(self) -> tuple[Constant, ...]:
        """The constants that have a tolerance."""
        return tuple(c for c in self.constants if c.tolerance > 0)

    def _with(self, constants: Iterable[Constant]) -> Self:
        return replace(self, constants=tuple(constants))

    def parameters(self, law: Law) -> tuple[Param, ...]:
        """The law's parameters and then the rig's own, with this rig's search ranges."""
        return tuple(self._ranged(q) for q in (*law.params, *self.own(law)))

    def sample(self, law: Law, rng: Rng, n: int) -> Array:
        """(n, k) parameter sets, SI, uniform in the search ranges; what is fixed stays so."""
        p = np.empty((n, len(self.parameters(law))))
        for k, q in enumerate(self.parameters(law)):
            p[:, k] = rng.uniform(q.lower, q.upper, n) if q.fixed is None else q.fixed
        return p

    def parameter_sets(self, law: Law, p: Array) -> Array:
        """Parameter sets as (n, k).

        Raises:
            InputError: their columns are not this law's and rig's.
        """
        p = np.atleast_2d(np.asarray(p, dtype=float))
        if p.shape[1] != len(law.params) + len(self.own(law)):
            raise InputError(
                f"rig {self.name}, law {law.name}: parameters are "
                f"{', '.join(q.name for q in self.parameters(law))}; got {p.shape[1]} columns"
            )
        return p

    def own(self, law: Law) -> tuple[Param, ...]:
        """The rig's own free parameters beside a law's (a rig may drop what a law makes idle)."""
        del law
        return self.params

    def unit_of(self, param: Param) -> str:
        """The unit in which people see a parameter."""
        return self.shows.get(param.name, self.shows.get(stem(param.name), param.unit))

    def unit_shown(self, quantity: Literal["position", "velocity"]) -> str:
        """The unit in which people see a position or a velocity of its axis."""
        return self.shows.get(quantity, self.si_unit(quantity))

    def label(self, name: str) -> str:
        """What people see a parameter called."""
        stem = name.rstrip("+-")
        return self.labels.get(stem, stem) + name[len(stem) :]

    def simulate(self, law: Law, p: Array, recording: Recording) -> Motion:
        """The motion of (n, k) parameter sets under a recording's command: n trajectories.

        Raises:
            InputError: the recording lacks what the rig needs, or the rig cannot be simulated.
        """
        del law, p
        raise InputError(f"rig {self.name} cannot be simulated from {recording.label}")

    def filter_reach(self, dt: float) -> int:
        """Samples to each side that the filters of its logs mix with one, at an interval dt, s."""
        del dt
        return 0

    def controller(self) -> Controller | None:
        """The controller of its loop, as a compensator adds to it; None where it has none."""
        return None if self.loop is None else self.loop.controller(self.name, self.own)

    def drive_friction(self) -> float:
        """Coulomb friction of its drive itself, N or N m; 0 where it has none."""
        controller = self.controller()
        return 0.0 if controller is None else controller.friction

    def equation(self, law: Law) -> Equation | None:
        """Its equation of motion under a law, as a stepper takes it; None where it has none."""
        del law
        return None

    def experiments(self, axis: OperatingRange, seconds: float) -> Iterable[Offer]:
        """Experiments that would tell more of the axis, each of some seconds.

        Raises:
            InputError: it knows of none.
        """
        del axis, seconds
        raise InputError(f"rig {self.name}: there are no experiments to choose from for it")

    def si_unit(self, quantity: Literal["position", "velocity", "force"]) -> str:
        """The SI unit of a quantity of its axis."""
        if quantity == "force" and self.in_amperes:
            return "A"
        linear = {"position": "m", "velocity": "m/s", "force": "N"}[quantity]
        return _ROTARY[linear] if self.rotary else linear

    def _ranged(self, param: Param) -> Param:
        declared = (param.lower, param.upper)
        lower, upper = self.ranges.get(param.name, self.ranges.get(stem(param.name), declared))
        written = self._si_unit_of(param)
        if self.in_amperes and written in _ELECTRIC:
            weight = self.rotary and written == "kg"  # at an arm, whose length is in m
            written = "A s**2/m**2" if weight else _ELECTRIC[written]
            if not {param.name, stem(param.name)} & self.bounded:
                lower, upper = _PER_NEWTON * lower, _PER_NEWTON * upper
        return replace(param, lower=lower, upper=upper, log=param.log and lower > 0, unit=written)

    def _si_unit_of(self, param: Param) -> str:
        """The SI unit of a parameter, which is declared with that of a linear axis."""
        return _ROTARY.get(param.unit, param.unit) if self.rotary else param.unit

    def _constants(self) -> str:
        return ", ".join(c.name for c in self.constants) or "none"


def _stated(
    value: Stated,
) -> tuple[float, float] | tuple[float, float, Origin]:
    return value if isinstance(value, tuple) else (value, 0.0)


def shown_in(rig: Rig, param: Param, value: Any) -> Any:
    """An SI value of a parameter in the unit its rig shows."""
    return unit(rig.unit_of(param)).from_si(value)


def shown_difference(rig: Rig, param: Param, difference: Any) -> Any:
    """A difference of two values of a parameter, SI, in the unit its rig shows."""
    return shown_in(rig, param, difference) - shown_in(rig, param, 0.0)


def in_si(rig: Rig, param: Param, value: float) -> float:
    """A value that a person wrote in the unit the rig shows, as SI."""
    if not convertible(rig.unit_of(param), param.unit):
        raise InputError(f"rig {rig.name}: {param.name} cannot be shown in {rig.unit_of(param)}")
    return float(unit(rig.unit_of(param)).to_si(value))
