"""Rigs that are simulated step by step: a known drive, friction of any law, many logs at once."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ..constant import GIVEN
from ..data.resolution import noise, step
from ..data.segmentation import rests
from ..errors import InputError
from ..space import Array
from ..units import unit
from .controller import Controller, per_newton
from .motion.axis_row import rows
from .motion.command import Drive
from .motion.drives import AXIS, IDLE, AxisInputs
from .motion.thinning import thinned
from .motion.track import Track
from .rig import Doubt, Motion
from .simulated import SimulatedRig

if TYPE_CHECKING:
    from ..data.recording import Recording
    from ..friction import Law

#: Share of a constant by which a log's own may change.
_CONSTANT = 0.02
#: Samples that a velocity at the start is taken from where none was recorded.
_FEW = 8


@dataclass(frozen=True, eq=False)
class SteppedRig(SimulatedRig):
    """A rig that is stepped through its motion: a subclass states inputs and coefficients.

    Its constant `step` is the longest step, s; `tolerance` the way by which a step may be off, m
    or rad. The states of a law start where the force of the first sample pushes an axis with
    relaxed bristles. A rig with `history` starts at rest.
    """

    from_rest: bool = False
    holds: bool = False  # an encoder repeats itself where the axis rests
    run_columns: Mapping[str, str] = field(default_factory=dict)
    #: Inputs that keep their value until the next sample; the others are linear between samples.
    held: ClassVar[frozenset[str]] = frozenset({"enabled", "sampled", "late"})

    @property
    def entry(self) -> int | None:
        """Which input a compensator's output is added to; None where there is no controller."""
        return None

    @property
    def motor_friction(self) -> float:
        """Coulomb friction of its motor, which takes its share of a command, N or N m."""
        return 0.0

    def thinned(self, tracks: Sequence[Track]) -> list[Track] | None:
        """Tracks with samples no closer than its step; none where its controller is sampled."""
        return None if self.holds_force else thinned(tracks, self["step"])

    def inputs(self, recording: Recording) -> Mapping[str, Array]:
        """What drives the axis, (N,) by the names of `AxisInputs`.

        Raises:
            InputError: the log lacks one.
        """
        del recording
        raise InputError(f"rig {self.name} does not say what drives it")

    @property
    def further_columns(self) -> frozenset[str]:
        """Those that state constants of a run."""
        return frozenset(self.run_columns)

    def run_constants(self, recording: Recording) -> Array:
        """The constants that `run_columns` names, as a log states them, else the rig's."""
        stated = self.stated(recording)
        return np.array([stated.get(name, self[name]) for name in self.run_columns.values()])

    def stated(self, recording: Recording) -> Mapping[str, float]:
        """The constants that a log states itself, SI by name: the median of their columns.

        Raises:
            InputError: as `stated_over`, or one that it cannot be.
        """
        stated = {name: middle for name, (_, middle, _) in self._stated_ends(recording).items()}
        try:
            self.check({c.name: c.value for c in self.constants} | stated)
        except InputError as error:
            raise InputError(f"{recording.label}: stated by a column: {error}") from error
        return stated

    def _stated_ends(self, recording: Recording) -> Mapping[str, tuple[float, float, float]]:
        """Least, median and greatest of the columns in which a log states constants, SI by name.

        Raises:
            InputError: one has another unit.
        """
        units = {c.name: c.unit for c in self.constants}
        return {
            name: recording.ends_of(column, units[name])
            for column, name in self.run_columns.items()
            if column in recording.extra
        }

    def doubts(self, recordings: Sequence[Recording]) -> Iterable[Doubt]:
        """Constants of logs that change within one, and set ones that a log states otherwise."""
        written = {c.name: unit(c.unit) for c in self.constants}
        for log in recordings:
            for name, ends in self._stated_ends(log).items():
                if ends[2] - ends[0] > _CONSTANT * abs(ends[1]):
                    low, middle, high = (f"{written[name].from_si(x):.3g}" for x in ends)
                    yield Doubt(
                        f"{log.label}: the column that states {name} goes from {low} to {high} "
                        f"{written[name].written}".rstrip()
                        + f": its median, {middle}, counts for all of the log: identify from parts "
                        "in which it stays (LOG@10s:40s)"
                    )
        for c in (c for c in self.constants if c.source == GIVEN):
            stated = (self.stated(log).get(c.name) for log in recordings)
            others = sorted({x for x in stated if x is not None and (x != c.value or c.tolerance)})
            if others:
                shown = ", ".join(f"{written[c.name].from_si(x):.4g}" for x in others)
                yield Doubt(
                    f"{c.name} is set to {c.shown:.4g} {c.unit}".rstrip()
                    + f", and logs state it in a column of theirs ({shown}), which counts",
                    harmful=False,
                )

    def coefficients(self, values: Mapping[str, Any]) -> Sequence[Any]:
        """The row of constants of its drive, the mass that moves first.

        As `parts.axis_of_parts.assembled` makes it of the parts of an axis.

        Args:
            values: The rig's constants, those that a log states in their place, and its own
                parameters, by name: floats, arrays (n,), or symbols of another language. Plain
                arithmetic serves for all.
        """
        del values
        raise InputError(f"rig {self.name} does not say the constants of its drive")

    def constants_of_drive(self, law: Law, own: Array, run: Array) -> Array:
        """The constants of the drive, (n, constants).

        Args:
            law: The law.
            own: The rig's own parameters, (n, k).
            run: What the log states of its run, as `run_constants` gives it.
        """
        by_name = {c.name: c.value for c in self.constants}
        by_name |= dict(zip(self.run_columns.values(), run.tolist(), strict=True))
        self.check(by_name)
        parameters = {q.name: own[:, k] for k, q in enumerate(self.own(law))}
        return rows(self.coefficients({**by_name, **parameters}), len(own))

    def constants_over(self, law: Law, own: Array, tracks: Sequence[Track]) -> Array:
        """The constants of the drive over tracks, (tracks, n, constants); many logs state the same.

        Args:
            law: The law.
            own: The rig's own parameters, (n, k).
            tracks: What their logs state of their runs counts.
        """
        runs = {track.given.tobytes(): track.given for track in tracks}
        c = {key: self.constants_of_drive(law, own, run) for key, run in runs.items()}
        return np.array([c[track.given.tobytes()] for track in tracks])

    def controller(self) -> Controller | None:
        """Its own loop, if it says which input a compensator's output is added to."""
        if self.entry is None:
            return super().controller()

        def track(recording: Recording) -> Track:
            x, n = recording.position, len(recording)
            return self.track(recording, slice(0, n), float(x[0]), np.ones(n))._replace(v0=0.0)

        def constants(law: Law, p: Array, track: Track) -> Array:
            return self.constants_of_drive(law, p[:, len(law.params) :], track.given)

        return Controller(
            AXIS,
            self.entry,
            self["step"],
            self["tolerance"],
            track,
            constants,
            self.command_per_force,
            self.motor_friction,
        )

    def command_per_force(self, law: Law, p: Array) -> float:
        """What its controller commands for a unit of force or torque at the axis."""
        return per_newton(law, p)

    def drive(self, recording: Recording) -> Drive:
        """The command of a log; where it has none, the position at its start, held."""
        if recording.command is not None:
            return Drive.sampled(recording.t, recording.command)
        t, x = recording.t, float(recording.position[0])
        return Drive(np.array([t[0], t[-1]]), np.array([x, x]))

    def track(self, recording: Recording, rows: slice, x0: float, score: Array) -> Track:
        """Samples, inputs and start of a stretch; see `SimulatedRig.track`."""
        self.check_turning(recording)
        stated = dict(self.inputs(recording))
        if recording.temperature is not None:
            stated.setdefault("temperature", recording.temperature)
        places = {AxisInputs._fields.index(name): a for name, a in stated.items()}
        used = 1 + max(places)
        table = np.repeat(np.array(IDLE[:used])[:, None], rows.stop - rows.start, axis=1)
        for place, values in places.items():
            table[place] = values[rows]
        held = np.array([name in self.held for name in AxisInputs._fields], dtype=float)
        return (
            super()
            .track(recording, rows, x0, score)
            ._replace(
                v0=self.velocity_at(recording, rows.start) or 0.0,
                inputs=table,
                held=held[:used],
                given=self.run_constants(recording),
            )
        )

    def velocity_at(self, recording: Recording, row: int) -> float | None:
        """As the axis moves there; see `SimulatedRig.velocity_at`."""
        return None if self.history else _velocity(recording, row)

    def with_constants(self, track: Track, recording: Recording) -> Track:
        """The track with the constants of its run; see `SimulatedRig.with_constants`."""
        stated = [column in recording.extra for column in self.run_columns]
        ours = [self[name] for name in self.run_columns.values()]
        return track._replace(given=np.where(stated, track.given, ours))

    def move(self, law: Law, p: Array, track: Track) -> Motion:
        """Motion over a prepared track from its measured start; see `SimulatedRig.move`.

        Raises:
            InputError: parameters that are not this law's and rig's, or a constant that cannot be.
        """
        return Motion(track.t, *self._motions(law, p, (track,)))

    def positions_over(self, law: Law, p: Array, tracks: Sequence[Track]) -> Array:
        """The positions over several tracks, simulated together; see `SimulatedRig`."""
        p, c, exact = self._prepared(law, p, tracks)
        if not exact.all():
            return self._moved(law, p, c, exact, tracks)[0]
        from .motion.spring_motion import spring_positions  # noqa: PLC0415 - compiled code that others need not load

        return spring_positions(law, p, c, tracks)

    def _motions(self, law: Law, p: Array, tracks: Sequence[Track]) -> tuple[Array, Array, Array]:
        """Position, velocity and drive force over tracks; see `motions_over`."""
        return self._moved(law, *self._prepared(law, p, tracks), tracks)

    def _prepared(
        self, law: Law, p: Array, tracks: Sequence[Track]
    ) -> tuple[Array, Array, NDArray[np.bool_]]:
        """Parameters of the law, (n, k), constants, (tracks, n, ...), and which motions are exact.

        Args:
            law: The friction.
            p: Complete sets.
            tracks: What is simulated.
        """
        p, k = self.checked(law, p), len(law.params)
        c = self.constants_over(law, p[:, k:], tracks)
        return p[:, :k], c, self._exact(law, p[:, :k], c, tracks)

    def _moved(
        self, law: Law, p: Array, c: Array, exact: NDArray[np.bool_], tracks: Sequence[Track]
    ) -> tuple[Array, Array, Array]:
        """The motions of what `_prepared` gives."""
        from .motion.implicit import motions_over  # noqa: PLC0415 - compiled code that others need not load

        settings = self["step"], self["tolerance"]
        if not exact.any():
            return motions_over(law, AXIS, p, c, tracks, *settings)
        from .motion.spring_motion import spring_motions  # noqa: PLC0415 - as above

        if exact.all():
            return spring_motions(law, p, c, tracks)
        motion = np.empty((3, len(p), sum(len(track.t) for track in tracks)))
        motion[:, exact] = spring_motions(law, p[exact], c[:, exact], tracks)
        motion[:, ~exact] = motions_over(law, AXIS, p[~exact], c[:, ~exact], tracks, *settings)
        return motion[0], motion[1], motion[2]

    def _exact(self, law: Law, p: Array, c: Array, tracks: Sequence[Track]) -> NDArray[np.bool_]:
        """Which candidates move on springs as their exact motion is cheap to know, (n,)."""
        if law.elements is None or not self.only_pushed:
            return np.zeros(len(p), dtype=bool)
        from .motion.spring_motion import MOST_SWING, swings  # noqa: PLC0415 - as in `_motions`

        return swings(law, p, c, tracks) <= MOST_SWING

    def checked(self, law: Law, p: Array) -> Array:
        """Parameter sets as (n, k).

        Raises:
            InputError: they are not this law's and rig's, or the rig's steps are none.
        """
        p = self.parameter_sets(law, p)
        step, tolerance = self["step"], self["tolerance"]
        if not (0 < step < np.inf and tolerance > 0):
            raise InputError(f"rig {self.name}: step = {step} s, tolerance = {tolerance}: "
                             "both must be above zero")  # fmt: skip
        return p

    def imbalance(
        self, law: Law, p: Array, track: Track, motion: tuple[Array, Array, Array]
    ) -> Array | None:
        """Drive and surroundings less inertia and friction; see `SimulatedRig.imbalance`."""
        from .motion.force_imbalance import imbalances  # noqa: PLC0415 - as in `move`

        k = len(law.params)
        c = self.constants_of_drive(law, p[:, k:], track.given)
        return imbalances(law, AXIS, p[:, :k], c, track, motion)

    def simulate(self, law: Law, p: Array, recording: Recording) -> Motion:
        """The motion under a recording's inputs, from its first sample."""
        rows = slice(0, len(recording))
        x0 = float(recording.position[0])
        return self.move(law, p, self.track(recording, rows, x0, np.ones(len(recording))))


def _velocity(recording: Recording, row: int) -> float:
    """The velocity at a sample: 0 where the axis rests, else as recorded or as it moves there."""
    if any(r.start <= row < r.stop for r in rests(recording)):
        return 0.0
    if recording.velocity is not None:
        return float(recording.velocity[row])
    rows = slice(row, row + _FEW)
    t, x = recording.t[rows], recording.position[rows]
    resolution = 2.5 * step(recording.position) + 6.0 * noise(recording)
    return float(np.polyfit(t - t[0], x, 2)[-2]) if np.ptp(x) > resolution else 0.0
