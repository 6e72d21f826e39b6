"""The paper's linear slide bed: a mass pulled through a spring and a P-controlled motor."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, reduce
from typing import TYPE_CHECKING, Any, Literal, Self

import numpy as np
from numpy.typing import NDArray

from ..constant import SMALLEST, Constant, Stated, constant
from ..errors import InputError
from ..space import Array, Param
from ..wording import option
from .composition import POSITION, Block
from .controller import Controller
from .equation import Equation, Input
from .experiments.offer import Offer, OperatingRange
from .experiments.ramps import ramps
from .loop_reading import read_stretch
from .motion import event_driven, reference
from .motion.command import Drive, ways
from .motion.drives import (
    F_FM,
    K_HAT_M,
    K_HAT_P,
    K_SPRING_M,
    K_SPRING_P,
    SLIDE,
    SLIDE_ADDED,
    SLIDE_COMMAND,
    SlideConstants,
)
from .motion.held_slip import HeldCourse, held_slips
from .motion.track import Track
from .rig import Doubt, Motion
from .simulated import SimulatedRig

if TYPE_CHECKING:
    from ..data.recording import Recording
    from ..friction import Law

Scheme = Literal["fast", "reference", "paper"]

_PAPER = "Sarasiri, Suthamno, Sujitjorn (2012), doi 10.1155/2012/238563"
#: What the beginning of a slip is open by at least, as a share of a controller's hold.
_READ = 0.1
#: Samples for each knot of its command from which on a creeping slide is stepped between knots.
KNOT_SAMPLES = 8
#: The way by which a step may be off, m.
TOLERANCE = 1e-10


def _constants() -> tuple[Constant, ...]:
    m, dv = 10.90, 0.1
    a, lead, eta_b, eta_c = 5.9, 5.0, 0.81, 0.925
    K_n = 2 * math.pi * a / (lead * 1e-3)
    K_v = K_n * eta_b * eta_c
    named, section = "nomenclature", "section 4.3"
    derived = "from the constants above (nomenclature)"
    return (
        constant("m", m, "kg", "mass of the slide", "section 4.4", "the paper", least=SMALLEST),
        constant("k_hat+", 3.5, "N/mm", "controller gain, stretch > 0 (ramp up)", section,
                 "the paper", least=0.0),
        constant("k_hat-", 2.8, "N/mm", "controller gain, stretch < 0 (ramp down)", section,
                 "the paper", least=0.0),
        constant("F_fm", 23.5, "N", "friction of the motor, at the screw",
                 "0.60 oz-in of a motor of this class times K_v; not in the paper",
                 "inferred", least=0.0),
        constant("a", a, "", "gear ratio", named, "the paper", 0.0,
                 least=SMALLEST),
        constant("l", lead, "mm", "ball screw lead", named, "the paper", 0.0,
                 least=SMALLEST),
        constant("eta_b", eta_b, "", "gear box efficiency", named, "the paper", 0.0,
                 least=SMALLEST),
        constant("eta_c", eta_c, "", "ball screw efficiency", named, "the paper", 0.0,
                 least=SMALLEST),
        constant("J_m", 4.17e-6, "kg m**2", "inertia of the motor", named, "the paper", least=0.0),
        constant("D_m", 2.60e-6, "N m s/rad", "viscous friction of the motor", named, "the paper",
                 least=0.0),
        constant("K_t", 18.2e-3, "N m/A", "torque constant (printed N/A)", named, "the paper", 0.0),
        constant("K_n", K_n, "rad/m", "slide to motor speed, 2 pi a / l", derived, "derived"),
        constant("K_v", K_v, "1/m", "motor torque to screw force, K_n eta_b eta_c", derived,
                 "derived"),
        constant("K_kt", K_n * K_v, "1/m**2", "motor inertia to slide mass, K_n K_v", derived,
                 "derived", least=0.0),
        constant("F_m_max", 30.0, "N", "clamp of the motor's inertia and damping force", section,
                 "the paper", least=0.0),
        constant("dv", dv, "mm/s", "velocity band of rest", "nomenclature", least=0.0),
        constant("dp", m * dv * 1e-3, "N s", "impulse that ends rest, m dv", derived, "derived",
                 least=0.0),
        constant("ramp_speed", 0.0, "mm/s",
                 "speed of the command where a log has none; 0: the log's mean speed", section),
        constant("step", 10.0, "ms",
                 "longest step where a law reads more than speed, or never sticks", "docs/rigs.md",
                 least=SMALLEST),
        # So small that a slip starts when it should: under a friction that falls by more than
        # m/step, an implicit step does not feel that rest is not stable, and lingers.
        constant("tolerance", TOLERANCE * 1e3, "mm", "way by which such a step may be off",
                 "docs/rigs.md", least=SMALLEST),
    )  # fmt: skip


#: The constants that follow from others: name, those that it follows from, formula.
_GEAR: tuple[tuple[str, tuple[str, ...], Callable[..., float]], ...] = (
    ("K_n", ("a", "l"), lambda a, lead: 2 * math.pi * a / lead if lead > 0 else math.nan),
    ("K_v", ("K_n", "eta_b", "eta_c"), lambda K_n, eta_b, eta_c: K_n * eta_b * eta_c),
    ("K_kt", ("K_n", "K_v"), lambda K_n, K_v: K_n * K_v),
    ("dp", ("m", "dv"), lambda m, dv: m * dv),
)


@dataclass(frozen=True, eq=False)
class SlideBed(SimulatedRig):
    """Section 4 of the paper, read as docs/physics.md says: implicit motor inertia, then clamped.

    m a = F_motor - F_f_motor + F_sp - F_m - F_f with the stretch e = x_i - x_d, F_motor = k_hat e,
    F_sp = k_spring e, F_f_motor = clip(F_motor, F_fm), F_m = clip(K_kt (J_m a + D_m v), 30 N).
    k_hat depends on the direction of the pull (3.5 rightward, 2.8 N/mm leftward), so does
    k_spring under a direction-dependent law.
    """

    free_start: bool = True
    overtravel: float = 1.0
    hand_gauge: bool = True
    known_scale: bool = True

    def set(self, **values: Stated) -> Self:
        """The same rig with constants of the user's, in the units it shows.

        K_n, K_v, K_kt and dp follow from others (nomenclature) unless set themselves.
        """
        rig = super().set(**values)
        return rig.estimated({name: rig[name] for name in values})

    def estimated(self, values: Mapping[str, float]) -> Self:
        """As `Rig.estimated`; K_n, K_v, K_kt and dp follow from others."""
        known = dict(values)
        for name, parts, formula in _GEAR:
            if name not in values and not known.keys().isdisjoint(parts):
                known[name] = formula(*(known[p] if p in known else self[p] for p in parts))
        return super().estimated(known)

    @property
    def slip_tolerance(self) -> float:
        """The error allowed in a step of a slip, as a share of the usual one.

        A smaller `tolerance` than the default one reduces it in proportion; a larger one does not
        raise it, as slips are cheap.
        """
        return min(self["tolerance"] / TOLERANCE, 1.0)

    def own(self, law: Law) -> tuple[Param, ...]:
        """k_spring; one for each direction if the law's parameters are."""
        if not law.directional:
            return self.params
        (k,) = self.params
        return tuple(
            Param(f"{k.name}{sign}", k.lower, k.upper, k.unit, f"{k.symbol}^{{{sign}}}", doc=k.doc)
            for sign in "+-"
        )

    def split(
        self, law: Law, p: Array, constants: Mapping[str, Array] | None = None
    ) -> tuple[Array, Array]:
        """Parameter sets (n, k) as the law's (n, k_law) and the kernel's constants (n, 11).

        Args:
            law: The law.
            p: The sets.
            constants: Of the rig, SI by name, (n,), that each set has a value of its own of.

        Raises:
            InputError: a mass or stiffness that cannot be simulated, or columns missing.
        """
        p, k = self.parameter_sets(law, p), len(law.params)
        c = np.repeat(self._kernel_constants[None], len(p), axis=0)
        for rows, rig in self._with_each(constants or {}):
            c[rows] = rig._kernel_constants  # noqa: SLF001 - of its own class
        c[:, K_SPRING_P], c[:, K_SPRING_M] = p[:, k], p[:, -1]
        return p[:, :k], c

    def _with_each(
        self, constants: Mapping[str, Array]
    ) -> Iterator[tuple[NDArray[np.bool_], SlideBed]]:
        """The rig with each distinct set of some constants, SI by name, (n,), and whose it is."""
        if not constants:
            return
        table = np.column_stack(list(constants.values()))
        for values in np.unique(table, axis=0):
            by_name = dict(zip(constants, values.tolist(), strict=True))
            yield (table == values).all(axis=1), self.estimated(by_name)

    @cached_property
    def _kernel_constants(self) -> Array:
        """The kernel's constants, (11,), without k_spring, which is a candidate's own."""
        for name in ("m", "J_m", "D_m", "K_kt", "dv", "dp", "k_hat+", "k_hat-"):
            if not np.isfinite(self[name]):
                raise InputError(f"rig {self.name}: {name} = {self[name]} cannot be simulated")
        values = {c.name: c.value for c in self.constants} | {"k_spring": 0.0}
        if not self["F_m_max"] > 0:
            values["K_kt"] = 0.0  # a clamp at 0 N leaves no motor
        return np.array(_coefficients(values))

    def drive(self, recording: Recording) -> Drive:
        """The command x_i of a recording: its column or the paper's ramp.

        Raises:
            InputError: the log has neither a command nor a mean speed, as it goes both ways.
        """
        if recording.command is None and not self["ramp_speed"]:
            x = recording.position
            if all(ways(x, float(np.ptp(x)))):
                raise InputError(
                    f"{recording.label}: no command is in the log, and the slide goes both ways, "
                    "which no ramp asks for: map a column to command, or say how fast the ramp was "
                    f"({option('constants', {'ramp_speed': 10})} for 10 mm/s) and train on one way"
                )
        return Drive.of(recording, self["ramp_speed"])

    def doubts(self, recordings: Sequence[Recording]) -> Iterable[Doubt]:
        """A ramp from where a log begins, where that has no command."""
        for log in recordings:
            if log.command is None:
                yield Doubt(self._ramp_taken(log), harmful=False)

    def _ramp_taken(self, recording: Recording) -> str:
        start = f"{recording.label}: no command is in the log: a ramp from its beginning"
        error = (
            "the slide's drive line is taken as relaxed there, and where it is not, forces are off "
            "by k_hat + k_spring for each mm, which no interval knows of"
        )
        if speed := self["ramp_speed"]:
            ramp = f"{start} at {1e3 * speed:.3g} mm/s is taken for it: {error}"
            return f"{ramp}: map a column to command"
        speed = float(np.diff(self.drive(recording).x)[0]) / float(np.ptp(recording.t))
        return (
            f"{start} at its mean speed, {1e3 * speed:.3g} mm/s, is taken for it: {error}: map a "
            "column to command, or say at least how fast it was "
            f"({option('constants', {'ramp_speed': 10})} for 10 mm/s)"
        )

    def track(self, recording: Recording, rows: slice, x0: float, score: Array) -> Track:
        """As `SimulatedRig.track`, with the temperature where the log has it.

        Raises:
            InputError: the log has no command, and a ramp is no model of its motion.
        """
        track = super().track(recording, rows, x0, score)
        if recording.command is None:
            self._check_ramp(recording, rows, track)
        if recording.temperature is not None:
            track = with_inputs(track)
            track.inputs[1] = recording.temperature[rows]
        return track

    def _check_ramp(self, recording: Recording, rows: slice, track: Track) -> None:
        """Refuse a ramp that a slide does not follow."""
        up, down = ways(recording.position[rows], float(np.ptp(recording.position)))
        against = down if track.knots_x[-1] > track.knots_x[0] else up
        if against:
            t, speed = recording.t[rows], self["ramp_speed"]
            ramp = f"a ramp of {1e3 * speed:.3g} mm/s" if speed else "a ramp"
            raise InputError(
                f"{recording.label}: no command is in the log, and from {t[0]:.4g} to {t[-1]:.4g} "
                f"s the slide goes against {ramp}: map a column to command, or take only a part of "
                "the log in which it goes with the ramp"
            )

    def experiments(self, axis: OperatingRange, seconds: float) -> Iterable[Offer]:
        """Ramps, rests and reversals."""
        return ramps(axis, seconds)

    def drive_force(self, recording: Recording) -> Array | None:
        """As recorded, else as the motor's current would show it."""
        if recording.force is None and recording.command is not None:
            return self.motor_force(recording.command - recording.position)
        return recording.force

    def motor_force(self, e: Array) -> Array:
        """F_motor = k_hat e, the force that the motor current shows, at stretches e (m)."""
        return np.where(e > 0, self["k_hat+"], self["k_hat-"]) * e

    def controller(self) -> Controller:
        """The P controller of the motor: a compensator adds to F_motor, before its friction."""
        friction = self["F_fm"]

        def track(recording: Recording) -> Track:
            x, n = recording.position, len(recording)
            return with_inputs(self.track(recording, slice(0, n), float(x[0]), np.ones(n)))

        def constants(law: Law, p: Array, track: Track) -> Array:
            del track
            return self.split(law, p)[1]

        return Controller(
            SLIDE, SLIDE_ADDED, self["step"], self["tolerance"], track, constants,
            friction=friction if np.isfinite(friction) else 0.0,
        )  # fmt: skip

    @property
    def composition(self) -> tuple[Block, ...]:
        """Its P controller, a motor with friction, inertia and damping, a screw, and the slide."""
        return (
            Block("controller", "p", "proportional to the error of the position",
                  "F_motor = k_hat (command − position)", ("k_hat+", "k_hat-")),
            Block("motor", "force", "with friction, inertia and damping of its own",
                  "dead zone(F_motor, F_fm) − clip(K_kt (J_m a + D_m v), F_m_max)",
                  ("F_fm", "J_m", "D_m", "K_t", "F_m_max")),
            Block("transmission", "screw", "a gear box and a ball screw", "",
                  ("a", "l", "eta_b", "eta_c", "K_n", "K_v", "K_kt")),
            Block("load", "mass", "the slide", "m a = F − F_f", ("m", "dv", "dp")),
            Block("load", "spring", "the compliance between command and slide",
                  "k_spring (command − position)"),
            POSITION,
        )  # fmt: skip

    def equation(self, law: Law) -> Equation:
        """The slide behind its drive line; F_f is friction.

        Raises:
            InputError: a constant that cannot be simulated.
        """
        _ = self._kernel_constants
        names = ("m", "k_hat+", "k_hat-", "F_fm", "J_m", "D_m", "K_kt", "F_m_max")
        return Equation(
            SLIDE,
            "m a = k_spring e + dead zone(k_hat e + added_force, F_fm) − F_m − F_f, "
            "e = command − position, F_m = clip(K_kt (J_m a + D_m v), F_m_max)",
            (
                Input("command", "m", "commanded position x_i", SLIDE_COMMAND),
                Input("added_force", "N", "added to the motor's force", SLIDE_ADDED, held=True),
            ),
            (*names, "dv", "dp") if _jumps(law) else names,  # how such a slide stops and starts
            _coefficients,
            "what the drive does to the axis, F_m apart",  # its inertia and damping are not in it
        )

    def move(
        self, law: Law, p: Array, track: Track, *, scheme: Scheme = "fast", dt: float = 1e-5
    ) -> Motion:
        """Motion over a prepared track, from rest at its start.

        Args:
            law: Any friction law.
            p: (n, k) parameter sets: the law's parameters, then the rig's own.
            track: Command and sample times.
            scheme: `fast`, `reference` (plain fixed steps) or `paper` (the printed procedure).
            dt: Step of the last two, s.
        """
        if scheme == "fast":
            x, v = self.states(law, p, track)
        elif not law.static:
            raise InputError(f"scheme {scheme} takes laws without states, loads and terms")
        elif scheme in ("reference", "paper"):
            inner = "implicit" if scheme == "reference" else "paper"
            pairs = [
                reference.trajectory(law, a, b, track, dt, inner)
                for a, b in zip(*self.split(law, p), strict=True)
            ]
            x, v = (np.array(part) for part in zip(*pairs, strict=True))
        else:
            raise InputError(f"scheme {scheme!r} is not one of fast, reference, paper")
        command = np.interp(track.t, track.knots_t, track.knots_x)
        return Motion(track.t, x, v, self.motor_force(command - x))

    def as_read(self, track: Track, recording: Recording, rows: slice) -> Track:
        """As `SimulatedRig.as_read`: by the flicker of the logged force at rest."""
        stretch = read_stretch(recording, (self["k_hat+"], self["k_hat-"]))
        return track if stretch is None else track._replace(stretch=stretch[rows])

    def rough_pull(self, track: Track, position: float) -> Array:
        """Motor and spring; see `SimulatedRig`."""
        (spring,) = self.params
        e = np.interp(track.t, track.knots_t, track.knots_x) - position
        return self.motor_force(track.stretch) + 0.5 * (spring.lower + spring.upper) * e

    def held_slips(
        self, law: Law, p: Array, track: Track, instants: Array, direction: int
    ) -> Motion:
        """As `SimulatedRig.held_slips`; a law that does not jump is no law of slips."""
        laws, c = self.split(law, p)
        changes = np.flatnonzero(np.diff(track.stretch)) + 1
        inner = (track.knots_t > track.t[0]) & (track.knots_t < track.t[-1])
        edges = np.unique(np.concatenate([track.t[:1], track.t[changes], track.knots_t[inner]]))
        edges = np.append(edges, track.t[-1])
        at = np.searchsorted(track.t, edges, side="right") - 1
        course = HeldCourse(
            edges, np.interp(edges, track.knots_t, track.knots_x), track.stretch[at]
        )
        x, v = held_slips(
            law, laws, c, course, instants, direction, track.t, track.x0, self.slip_tolerance
        )
        return Motion(track.t, x, v, np.tile(self.motor_force(track.stretch), (len(x), 1)))

    def breakaway_delay(self, excess: Array, length: float) -> tuple[Array, Array]:
        """As `SimulatedRig.breakaway_delay`: dp over an excess anywhere below what it may be."""
        least = np.minimum(self["dp"] / np.maximum(excess, 1e-9), length)  # at the whole excess
        with np.errstate(divide="ignore", invalid="ignore"):
            mean = np.where(least > 0.0, least * (1.0 + np.log(length / least)), 0.0)
        variance = np.maximum(least * (2.0 * length - least) - mean**2, 0.0)
        return mean, np.hypot(np.sqrt(variance), _READ * length)

    def resting(self, track: Track, instant: float, position: float) -> Array:
        """The stretch at an instant, and as the controller reads it; see `SimulatedRig`."""
        e = float(np.interp(instant, track.knots_t, track.knots_x)) - position
        if not track.stretch.size:
            return np.array([e, e])
        at = max(int(np.searchsorted(track.t, instant, side="right")) - 1, 0)
        return np.array([e, float(track.stretch[at])])

    def pull(self, law: Law, p: Array, resting: Array) -> Array:
        """Spring and motor, less its friction, at stretches and readings; see `SimulatedRig`."""
        _, c = self.split(law, p)
        (e, read), c = resting.T, c[:, :, None]
        motor = np.where(read > 0, c[:, K_HAT_P], c[:, K_HAT_M]) * read
        k_spring = np.where(e > 0, c[:, K_SPRING_P], c[:, K_SPRING_M])
        pull: Array = motor - np.clip(motor, -c[:, F_FM], c[:, F_FM]) + k_spring * e
        return pull

    def positions_from(
        self, law: Law, p: Array, track: Track, starts: Array, constants: Mapping[str, Array]
    ) -> Array:
        """All in one call where steps need not end at samples; see `SimulatedRig`."""
        if _by_events(law, track):
            laws, c = self.split(law, p, constants)
            return _kernel(law).trajectories(law, laws, c, track, self.slip_tolerance, starts)[0]  # type: ignore[no-any-return]
        positions = np.empty((len(p), len(track.t)))
        for rows, rig in self._with_each({**constants, "start": starts}):
            begun = track.begun_at(float(starts[rows][0]), track.v0)
            positions[rows] = rig.positions(law, p[rows], begun)
        return positions

    def states(self, law: Law, p: Array, track: Track) -> tuple[Array, Array]:
        """Positions and velocities alone: a search needs no forces; see `SimulatedRig`."""
        laws, c = self.split(law, p)
        if _by_events(law, track):
            x, v = _kernel(law).trajectories(law, laws, c, track, self.slip_tolerance)
            return x, v
        from .motion.implicit import motions  # noqa: PLC0415 - compiled code that others need not load

        x, v, _ = motions(law, SLIDE, laws, c, with_inputs(track), self["step"], self["tolerance"])
        return x, v

    def misfits(self, law: Law, p: Array, tracks: Sequence[Track]) -> Array:
        """Sums of squared position misfits over tracks, m^2, (n,); nan where one cannot run."""
        laws, c = self.split(law, p)
        if not all(_by_events(law, track) for track in tracks):
            return super().misfits(law, p, tracks)
        kernel = _kernel(law)
        each = (kernel.misfits(law, laws, c, track, self.slip_tolerance) for track in tracks)
        total: Array = reduce(np.add, each)
        return total

    def imbalance(
        self, law: Law, p: Array, track: Track, motion: tuple[Array, Array, Array]
    ) -> Array | None:
        """As `SimulatedRig.imbalance`; by what the controller read where that is known."""
        if not (track.stretch.size and law.static):
            return super().imbalance(law, p, track, motion)
        from .balanced import slips  # noqa: PLC0415 - compiled code that others need not load

        x, v, a = motion
        e = np.interp(track.t, track.knots_t, track.knots_x) - x
        drive = self.pull(law, p, np.column_stack([e, track.stretch]))
        left = drive - self._motor(v, a) - self["m"] * a
        return np.array(
            [own - slips(law.slip, v, np.ascontiguousarray(row))
             for own, row in zip(left, p, strict=True)]
        )  # fmt: skip

    def friction(self, law: Law, p: Array, e: Array, v: Array, a: Array) -> Array:
        """Measured friction: what is left of the drive force at stretches e, speeds v, and a.

        The inverse of the equation of motion, for the points of figure 9.
        """
        drive: Array = self.pull(law, p, np.column_stack([e, e]))[0]
        return drive - self._motor(v, a) - self["m"] * a

    def _motor(self, v: Array, a: Array) -> Array:
        """F_m, what accelerates and damps the motor, at speeds v and accelerations a."""
        force: Array = self["K_kt"] * (self["J_m"] * a + self["D_m"] * v)
        return np.clip(force, -self["F_m_max"], self["F_m_max"])


def _coefficients(values: Mapping[str, Any]) -> Sequence[Any]:
    """The kernel's constants; dv and dp are those of a slide that jumps."""
    plus, minus = (values["k_spring" if "k_spring" in values else f"k_spring{s}"] for s in "+-")
    return SlideConstants(
        values["m"], values["k_hat+"], values["k_hat-"], plus, minus, values["F_fm"],
        values["K_kt"] * values["J_m"], values["K_kt"] * values["D_m"], values["F_m_max"],
        values.get("dv", 0.0), values.get("dp", 0.0),
    )  # fmt: skip


def _jumps(law: Law) -> bool:
    """Whether a slide rests and slips under a law: the kernel goes from one event to the next."""
    return law.static and law.sticks


def _by_events(law: Law, track: Track) -> bool:
    """Whether steps need not end at samples: the law reads nothing that a log tells of each.

    A law that never sticks is stepped from knot to knot of the command; where that has many, as a
    sampled sine, the samples are as few.
    """
    if _jumps(law):
        return True
    rare = KNOT_SAMPLES * len(track.knots_t) <= len(track.t)
    return rare and not (law.sticks or law.terms or law.loads)


def _kernel(law: Law) -> Any:
    """The compiled motions of a slide: of one that sticks, and of one that creeps."""
    if _jumps(law):
        return event_driven
    from .motion import stiff_slide  # noqa: PLC0415 - compiled code that others need not load

    return stiff_slide


def with_inputs(track: Track) -> Track:
    """A track with its command at the samples, too, as the implicit stepper reads it.

    The last input is what is added to the motor's force, held for a sample.
    """
    if track.inputs.size:
        return track
    inputs = np.zeros((4, len(track.t)))
    inputs[2] = np.interp(track.t, track.knots_t, track.knots_x)
    return track._replace(inputs=inputs, held=np.array([0.0, 0.0, 0.0, 1.0]))


SLIDE_BED = SlideBed(
    name="slide-bed",
    doc="a slide on a ball screw that follows a slow ramp under P control, and sticks and slips",
    cite=_PAPER,
    constants=_constants(),
    params=(
        Param("k_spring", 100.0, 1500.0, "N/m", "k_{spring}", doc="stiffness of the drive line"),
    ),
    laws=("stribeck", "stribeck-directional", "coulomb-viscous", "coulomb-viscous-directional"),
    ranges={
        "F_S": (100.0, 180.0),
        "F_C": (40.0, 80.0),
        "F": (40.0, 180.0),
        "F_V": (400.0, 1000.0),
        "v_SS": (1e-3, 7e-3),
    },
    shows={
        "position": "mm",
        "velocity": "mm/s",
        "force": "N",
        "F_V": "N s/mm",
        "v_SS": "mm/s",
        "k_spring": "N/mm",
    },
)

#: What the paper identified (section 4.5.1), SI, in the order of the slide bed's parameters
#: under the law `stribeck`: F_S, F_C, F_V, v_SS, exponent, k_spring.
PUBLISHED = {
    "right": np.array([144.5463, 47.8514, 958.3, 1.0964e-3, 1.0, 967.98]),
    "left": np.array([152.2804, 40.4153, 975.7, 3.21475e-3, 1.0, 553.84]),
}


def published_both() -> Array:
    """Both published sets as one parameter set of `stribeck-directional`."""
    right, left = PUBLISHED["right"], PUBLISHED["left"]
    return np.concatenate([right[:4], left[:4], [1.0], [right[5], left[5]]])
