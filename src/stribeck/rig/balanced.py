"""Rigs whose drive force is measured: friction is what the force balance leaves."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, ClassVar, Literal, Self

import numpy as np
from numba import float64, types

from ..compile_cache import compiled
from ..data.filtering import Filtering
from ..errors import InputError
from ..friction import LOADS, RUB_SIGNATURE, RUB_TYPE, SLIP_TYPE, addressed
from ..friction.law import POSITION, TEMPERATURE
from ..space import Array, Param, contiguous
from .equation import Equation, Input
from .experiments.imposed_motions import strokes
from .experiments.offer import Offer, OperatingRange
from .measured_path import MeasuredPath
from .motion.drives import ADDED, AXIS
from .parts import Part, part_named
from .parts.axis_of_parts import assembled
from .rig import Approach, Rig

if TYPE_CHECKING:
    from ..data.recording import Recording
    from ..friction import Law

_F1 = types.Array(float64, 1, "C", readonly=True)
_F2 = types.Array(float64, 2, "C", readonly=True)

#: A law's loads in words.
_LOAD_WORDS = {
    "drive": "the force of the drive",
    "external": "the force on the axis",
    "normal": "the normal load",
}


@dataclass(frozen=True, eq=False)
class BalancedRig(Rig):
    """force = M a + F_f(v) + offset, with the measured force of the drive.

    A direction-dependent law has a level of its own for each direction, which makes a constant
    offset redundant: the rig drops it there. A rig that balances more says so by its parameters
    and their `columns`.

    Args:
        filtering: How its logs are made ready for the balance.
    """

    approach: ClassVar[Approach] = "force_balance"

    loads: tuple[str, ...] = ("position", "temperature")
    filtering: Filtering = field(default_factory=Filtering)
    scale: str = "the measured force"

    def with_velocity(self, source: Literal["position", "recorded"]) -> Self:
        """The same rig with the velocity from the position, or as it was recorded."""
        return replace(self, filtering=replace(self.filtering, velocity=source))

    def filtering_of(self, law: Law) -> Filtering:
        """How its logs are made ready for a law.

        States are driven by the whole motion, its rests and reversals included, and the corners of
        loops below breakaway are sharp: they take twice the band. Breakaways after rests ring in
        it; else it holds noise more than motion, of which differences of order 2 let less through:
        those of order 6 make sigma_1 of a LuGre law too large by a further 3 %.
        """
        if not law.states:
            return self.filtering
        wide, narrow = 2 * self.filtering.cutoff_hz, self.filtering
        edge = (0.5 * narrow.edge[0], 0.5 * narrow.edge[1])
        return replace(
            narrow,
            cutoff_hz=wide,
            share=2 * narrow.share,
            edge=edge,
            reversals=True,
            slowest=0.0,
            accuracy=6 if law.rests else 2,
        )

    def filter_reach(self, dt: float) -> int:
        """Samples to each side that the low-pass filter mixes with one, at an interval dt, s."""
        return max(self.filtering.edges(1 / dt))

    def parameters(self, law: Law) -> tuple[Param, ...]:
        """As of any rig; the period of a term over position is free, as the residual shows it."""
        return tuple(
            replace(q, fixed=None) if q.name == "pos_period" else q for q in super().parameters(law)
        )

    def own(self, law: Law) -> tuple[Param, ...]:
        """The rig's parameters, without the offset under a law with levels for each direction."""
        return tuple(q for q in self.params if not (law.directional and q.name == "offset"))

    def check_law(self, law: Law) -> None:
        """Refuse a law that a force balance cannot follow.

        Raises:
            InputError: it depends on a load that this rig does not know.
        """
        if unknown := [n for n in law.loads if n not in self.loads]:
            raise InputError(
                f"law {law.name} depends on {_LOAD_WORDS.get(unknown[0], unknown[0])}, which rig "
                f"{self.name} does not tell apart: choose another law or rig"
            )

    def equation(self, law: Law) -> Equation | None:
        """A mass under a force; None where the balance has parameters beside mass and offset."""
        del law
        if {q.name for q in self.params} - {"M", "offset"}:
            return None
        return self.under_force("M a = force − offset − F_f", coefficients)

    def experiments(self, axis: OperatingRange, seconds: float) -> Iterable[Offer]:
        """Strokes that the axis is taken to follow.

        Raises:
            InputError: the law has states, and proposals are judged by static friction.
        """
        if axis.law.states:
            rests = ", each after rests of 0.1 to 10 s" if axis.law.rests else ""
            raise InputError(
                f"law {axis.law.name} on rig {self.name}: experiments are compared for laws "
                "without states; record sines within and beyond the way of the bristles, then "
                f"strokes at several speeds{rests}"
            )
        return strokes(axis, seconds)

    def under_force(
        self,
        text: str,
        coefficients: Callable[[Mapping[str, Any]], tuple[Any, ...]],
        *further: Input,
        constants: tuple[str, ...] = (),
    ) -> Equation:
        """The equation of a mass under a force, with what else acts on it.

        Args:
            text: It, in words and signs.
            coefficients: The constants of its drive, of its parameters and constants by name.
            further: Inputs beside the force.
            constants: Names of the rig's constants that it reads.
        """
        force = Input("force", self.si_unit("force"), "of the drive on the axis", ADDED)
        return Equation(AXIS, text, (force, *further), constants, coefficients)

    def measured(self, recording: Recording) -> Array:
        """The force that the balance explains, N (N m), (N,): that of the drive in a log.

        Raises:
            InputError: it has none, or its position is an angle where this axis is linear, or
                the other way round.
        """
        self.check_turning(recording)
        return self.needed_force(recording)

    def figures(self, recording: Recording) -> Mapping[str, float]:
        """What is told of a log beside its balance, by name with its unit; nothing as a rule."""
        del recording
        return {}

    def load_rows(self, law: Law, recording: Recording, t: Array, position: Array) -> Array:
        """The five LOADS at given times, SI, (len(t), 5); 0 for what the rig does not know.

        Args:
            law: What for: a term may need a channel that logs seldom have.
            recording: The log.
            t: Times, (n,).
            position: Low-passed position at these, (n,).

        Raises:
            InputError: the law depends on a temperature that was not recorded.
        """
        rows = np.zeros((len(t), len(LOADS)))
        rows[:, POSITION] = position
        if recording.temperature is not None:
            rows[:, TEMPERATURE] = np.interp(t, recording.t, recording.temperature)
        elif law.warms:
            raise InputError(
                f"{recording.label}: law {law.name} needs a temperature: map a column to "
                "temperature"
            )
        return rows

    def columns_of(self, a: Array, loads: Array) -> Mapping[str, Array]:
        """What each of the rig's own parameters is multiplied by, (N,) by name."""
        del loads
        return {"M": a, "offset": np.ones(len(a))}

    def force(
        self,
        law: Law,
        p: Array,
        v: Array,
        a: Array,
        loads: Array | None = None,
        friction: Array | None = None,
    ) -> Array:
        """The measured force that a motion takes, N (N m), (N,).

        Args:
            law: The friction law.
            p: (k,) the law's parameters, then the rig's own.
            v: Velocity, (N,); at exactly zero the friction is midway between its two levels.
            a: Acceleration, (N,).
            loads: As `load_rows` gives them, (N, 5); all zero by default.
            friction: The friction in it, (N,), of a law with states, which no velocity tells.
        """
        loads = np.zeros((len(v), len(LOADS))) if loads is None else loads
        columns = self.columns_of(a, loads)
        balance: Array = self.friction(law, p, v, loads) if friction is None else friction
        for value, q in zip(p[len(law.params) :], self.own(law), strict=True):
            if value:
                balance = balance + value * columns[q.name]
        if "cogging" in law.terms:
            balance = balance + wave(p[law.place("cogging")], loads[:, POSITION])
        return balance

    def friction(self, law: Law, p: Array, v: Array, loads: Array | None = None) -> Array:
        """The friction in it, as for `force`, (N,); with states, that of steady sliding."""
        loads = np.zeros((len(v), len(LOADS))) if loads is None else loads
        p = contiguous(p[: len(law.params)])
        v = contiguous(v)
        rub: Array = (
            slips(addressed(law.slip), v, p)
            if law.rub is None or law.states
            else rubs(addressed(law.rub, RUB_SIGNATURE), v, contiguous(loads), p)
        )
        return rub * _factor(law, p, loads) if law.terms else rub

    def friction_along(self, law: Law, p: Array, path: MeasuredPath, loads: Array) -> Array:
        """Friction of a law with states along a path, N (N m), (N,); see `MeasuredPath`."""
        rub = path.friction(law, p)
        return rub * _factor(law, p, loads) if law.terms else rub


def coefficients(values: Mapping[str, Any], *loads: Part) -> tuple[Any, ...]:
    """The row of constants of a mass under a force, of its parameters by name.

    Args:
        values: The parameters.
        loads: What acts on it beside a constant force.
    """
    parts = (part_named("motor", "force"), part_named("load", "mass"), *loads)
    return assembled(parts, values)


def as_balanced(rig: Rig) -> BalancedRig:
    """A rig as one whose forces are balanced.

    Raises:
        InputError: it is identified by simulation.
    """
    if not isinstance(rig, BalancedRig):
        raise InputError(f"rig {rig.name} is identified by simulation: it has no force balance")
    return rig


def _factor(law: Law, p: Array, loads: Array) -> Array:
    """What a law's terms multiply its friction by, (N,): not below 0, or it would drive."""
    factor = np.ones(len(loads))
    if "position" in law.terms:
        factor += wave(p[law.place("position")], loads[:, POSITION])
    if "temperature" in law.terms:
        slope, reference = p[law.place("temperature")]
        factor *= 1 + slope * (loads[:, TEMPERATURE] - reference)
    return np.maximum(factor, 0.0)


def wave(p: Array, x: Array) -> Array:
    """A sum of harmonics over positions, (N,): pairs of cosine and sine, and the period last."""
    turn = 2 * np.pi * x / p[-1]
    total = np.zeros(len(x))
    for k in range(len(p) // 2):
        total += p[2 * k] * np.cos((k + 1) * turn) + p[2 * k + 1] * np.sin((k + 1) * turn)
    return total


@compiled(float64[::1](SLIP_TYPE, _F1, _F1))
def slips(slip: Any, v: Array, p: Array) -> Array:
    """Slip friction over speeds; at exactly zero, midway between the two breakaway levels."""
    at_rest = 0.5 * (slip(0.0, p) + slip(-0.0, p))
    out = np.empty(len(v))
    for i in range(len(v)):
        out[i] = at_rest if v[i] == 0.0 else slip(v[i], p)
    return out


@compiled(float64[::1](RUB_TYPE, _F1, _F2, _F1))
def rubs(rub: Any, v: Array, loads: Array, p: Array) -> Array:
    """The same for a law that reads loads and has no states."""
    none = np.empty(0)
    out = np.empty(len(v))
    for i in range(len(v)):
        if v[i] == 0.0:
            forward = rub(0.0, 0.0, none, loads[i], p, none)
            out[i] = 0.5 * (forward + rub(-0.0, 0.0, none, loads[i], p, none))
        else:
            out[i] = rub(v[i], 0.0, none, loads[i], p, none)
    return out
