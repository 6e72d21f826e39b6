"""Rigs that are simulated: a new one says how it moves, and the rest follows from that."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from ..data.recording import Recording
from ..data.segmentation import rests
from ..errors import InputError
from ..friction import Law
from ..space import Array
from .experiments.commanded_strokes import commanded_strokes
from .experiments.offer import Course, Offer, OperatingRange
from .motion.command import Drive
from .motion.track import Track
from .motion.track import track as prepared
from .rig import Approach, Motion, Rig


@dataclass(frozen=True, eq=False)
class SimulatedRig(Rig):
    """A rig whose laws are identified by output error: by simulating its motion.

    A new one says how it `move`s. The rest follows from that, and may be done faster. Constants
    named `step` and `tolerance` are those of its simulation.

    Args:
        from_rest: Whether a simulation can only start where the axis rests. Else it starts from
            the measured state at the first sample of a range.
        free_start: Whether a motion depends so much on where it starts that this is found
            together with the parameters.
        history: Whether what came before a range matters so much that a simulation starts with
            the log.
        floating: Whether positions are known only up to a constant, which is left open.
        holds: Whether the position sensor may be slower than the log, so that it repeats itself.
        overtravel: How far beyond the travel of the logs an experiment may take the axis, in
            multiples of that travel.
    """

    approach: ClassVar[Approach] = "output_error"

    loads: tuple[str, ...] = ("drive", "external", "position", "temperature")
    from_rest: bool = True
    free_start: bool = False
    history: bool = False
    floating: bool = False
    holds: bool = True
    overtravel: float = 0.25

    def track(self, recording: Recording, rows: slice, x0: float, score: Array) -> Track:
        """The samples of a recording made ready to be simulated, from a start at position x0.

        Args:
            recording: The log.
            rows: Its samples, the start first.
            x0: Position at the start, m (rad).
            score: 1 for a sample that counts, 0 for one that does not.
        """
        x = recording.position
        return prepared(self.drive(recording), recording.t[rows], x0, x[rows], score)

    def velocity_at(self, recording: Recording, row: int) -> float | None:
        """With which velocity, m/s or rad/s, a motion may begin as it was measured at a sample.

        None where no motion begins amid a log.
        """
        del recording, row
        return None

    def readings(self, track: Track, recording: Recording, rows: slice) -> tuple[Track, ...]:
        """The tracks of a motion, one for each sensor of a log that has read it.

        Args:
            track: As `track` has it.
            recording: The log.
            rows: Its samples in the track.
        """
        del recording, rows
        return (track,)

    def stated(self, recording: Recording) -> Mapping[str, float]:
        """The constants that a log states itself, SI by name: these count, not the rig's."""
        del recording
        return {}

    def with_constants(self, track: Track, recording: Recording) -> Track:
        """A track that a rig of this kind with other constants has prepared, with this rig's."""
        del recording
        return track

    def thinned(self, tracks: Sequence[Track]) -> list[Track] | None:
        """Tracks of fewer samples, on which a search is quicker; None where there are none."""
        del tracks
        return None

    def finer(self, step: float, tolerance: float) -> Self:
        """The same rig with a shorter `step` and a smaller `tolerance`, where it has these."""
        factors = {"step": step, "tolerance": tolerance}
        finer = {c.name: c.value / factors[c.name] for c in self.constants if c.name in factors}
        return self.estimated(finer)

    @property
    def fineness(self) -> str:
        """Its step and its tolerance, as it shows them."""
        shown = {c.name: f"{c.name} = {c.shown:.3g} {c.unit}" for c in self.constants}
        return ", ".join(shown[name] for name in ("step", "tolerance") if name in shown)

    def move(self, law: Law, p: Array, track: Track) -> Motion:
        """The motion of (n, k) parameter sets over a prepared track, from rest at its start."""
        del law, p, track
        raise InputError(f"rig {self.name} does not say how it moves")

    @property
    def only_pushed(self) -> bool:
        """Whether nothing acts on its mass but a force that a log states, and friction."""
        return False

    @property
    def holds_force(self) -> bool:
        """Whether the force of the drive changes at samples alone."""
        return False

    def as_read(self, track: Track, recording: Recording, rows: slice) -> Track:
        """A track with the stretch that its controller read, where the log of its rows tells it."""
        del recording, rows
        return track

    def rough_pull(self, track: Track, position: float) -> Array:
        """What roughly pulls at an axis at rest at the samples of a track with a stretch, (N,).

        As `pull` has it in the middle of the search ranges.
        """
        del track, position
        raise InputError(f"rig {self.name} does not say what its controller reads")

    def held_slips(
        self, law: Law, p: Array, track: Track, instants: Array, direction: int
    ) -> Motion:
        """The motion of (n, k) parameter sets over a track with a stretch.

        Args:
            law: The law.
            p: Parameter sets.
            track: The track.
            instants: At which each breaks away from where it starts, s, (n,).
            direction: In which they do, +1 or -1.
        """
        del law, p, track, instants, direction
        raise InputError(f"rig {self.name} does not say what its controller reads")

    def breakaway_delay(self, excess: Array, length: float) -> tuple[Array, Array]:
        """How long a slip takes to begin under a force that is held: mean and sd, s, (n,) each.

        Args:
            excess: What it may exceed it by at most, N, (n,).
            length: Of the hold, s.
        """
        del excess, length
        raise InputError(f"rig {self.name} does not say what its controller reads")

    def resting(self, track: Track, instant: float, position: float) -> Array | None:
        """What pulls at an axis at rest, as `pull` reads it, (m,); None if the rig cannot say.

        Args:
            track: A prepared track that holds the instant.
            instant: Time, s; where the drive holds its force, the force from then on.
            position: Where the axis rests, m or rad.
        """
        del track, instant, position
        return None

    def pull(self, law: Law, p: Array, resting: Array) -> Array:
        """The force on an axis at rest, friction apart, N or N m, (n, instants).

        Args:
            law: The law, for what else depends on it.
            p: (n, k) complete parameter sets, SI.
            resting: The axis at some instants, (instants, m), as `resting` has it.
        """
        del law, p, resting
        raise InputError(f"rig {self.name} does not say what pulls at an axis at rest")

    def states(self, law: Law, p: Array, track: Track) -> tuple[Array, Array]:
        """Positions and velocities of (n, k) parameter sets over a track, SI, (n, N) each."""
        motion = self.move(law, p, track)
        return motion.position, motion.velocity

    def positions(self, law: Law, p: Array, track: Track) -> Array:
        """The positions of that motion alone, m, (n, N)."""
        return self.states(law, p, track)[0]

    def positions_over(self, law: Law, p: Array, tracks: Sequence[Track]) -> Array:
        """The positions over several tracks, one after the other, m, (n, their samples)."""
        return np.concatenate([self.positions(law, p, track) for track in tracks], axis=1)

    def positions_from(
        self, law: Law, p: Array, track: Track, starts: Array, constants: Mapping[str, Array]
    ) -> Array:
        """The positions of sets that differ in where they start and in constants, m, (n, N).

        For a rig with a `free_start`.

        Args:
            law: The law.
            p: (n, k) complete parameter sets.
            track: A prepared track.
            starts: Position of each at its start, m, (n,).
            constants: Of the rig, SI by name, (n,), that each set has a value of its own of.
        """
        del law, p, track, starts, constants
        raise InputError(f"rig {self.name} does not simulate starts of its own")

    def drive(self, recording: Recording) -> Drive:
        """What a recording's command asks of the axis."""
        return Drive.of(recording)

    def course_track(self, course: Course, temperature: float | None = None) -> Track:
        """A course of an experiment made ready to be simulated, from rest at its start."""
        x0 = float(course.command[0]) if course.start is None else course.start
        n = len(course.t)
        log = Recording(
            t=course.t,
            position=np.full(n, x0),
            command=None if course.force else course.command,
            force=course.command if course.force else None,
            temperature=None if temperature is None else np.full(n, temperature),
            extra={k: np.broadcast_to(v, (n,)) for k, v in course.extra.items()},
            rotary=self.rotary,
        )
        with np.errstate(divide="ignore", invalid="ignore"):  # it starts at rest, whatever speed
            return self.track(log, slice(0, n), x0, np.ones(n))._replace(v0=0.0)

    def experiments(self, axis: OperatingRange, seconds: float) -> Iterable[Offer]:
        """Strokes, where its position is commanded."""
        if all(log.command is None for log in axis.logs):
            return super().experiments(axis, seconds)
        return commanded_strokes(axis, seconds)

    def drive_force(self, recording: Recording) -> Array | None:
        """The force of the drive that a log shows, (N,); None where it shows none."""
        return recording.force

    def misfits(self, law: Law, p: Array, tracks: Sequence[Track]) -> Array:
        """Sums of squared position misfits over tracks, m^2, (n,); nan where one cannot run."""
        measured = np.concatenate([track.measured for track in tracks])
        score = np.concatenate([t.score * t.reading.weight**2 for t in tracks])
        error = measured - self.positions_over(law, p, tracks)
        total: Array = (score * error * error).sum(axis=1)
        return total

    def friction(self, law: Law, p: Array, e: Array, v: Array, a: Array) -> Array | None:
        """The friction that a measured motion implies; None if this rig cannot say.

        Args:
            law: The law, for what else depends on it.
            p: (k,) parameters.
            e: Command minus position, m, (N,).
            v: Velocity, m/s, (N,).
            a: Acceleration, m/s^2, (N,).
        """
        del law, p, e, v, a
        return None

    def imbalance(
        self, law: Law, p: Array, track: Track, motion: tuple[Array, Array, Array]
    ) -> Array | None:
        """The force that a measured motion leaves out of balance, N (N m), (n, N).

        None if this rig cannot say.

        Args:
            law: The law.
            p: (n, k) parameter sets.
            track: Times, command and inputs at N samples.
            motion: Position, velocity and acceleration there, SI, (N,) each.
        """
        from .balanced import slips  # noqa: PLC0415 - compiled code that others need not load

        if not law.static:
            return None
        x, v, a = motion
        e = np.interp(track.t, track.knots_t, track.knots_x) - x
        result = []
        for row in p:
            implied = self.friction(law, row, e, v, a)
            if implied is None:
                return None
            result.append(implied - slips(law.slip, v, np.ascontiguousarray(row)))
        return np.array(result)

    def simulate(self, law: Law, p: Array, recording: Recording) -> Motion:
        """The motion under a recording's command, from its first rest.

        Where none is seen, from the mean of the first 50 samples (the paper's section 4.3, step 1).
        """
        first = next(iter(rests(recording)), slice(0, 50))
        x0 = float(recording.position[first].mean())
        n = len(recording)
        return self.move(law, p, self.track(recording, slice(0, n), x0, np.ones(n)))


def as_simulated(rig: Rig) -> SimulatedRig:
    """A rig as one that is simulated.

    Raises:
        InputError: it is identified by force balance.
    """
    if not isinstance(rig, SimulatedRig):
        raise InputError(
            f"rig {rig.name} is identified by force balance: it poses no search problem"
        )
    return rig
