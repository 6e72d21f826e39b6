"""The identification as a problem for a search: parameters in, misfit of the motion out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..data.log_list import Logs
from ..data.ranges import Range
from ..errors import InputError
from ..friction import Law
from ..optimize import rms
from ..rig import Rig
from ..rig.lookup import rig_and_law
from ..rig.simulated import as_simulated
from ..space import Array, Space
from ..units import unit
from .breakaway_scatter import BreakawayWeights, first_weights, level_columns
from .data_split import ranges_or_all, recording_list
from .known_holds import place_in_hold
from .loss import FINER, KNEE, Breakaway, Loss, Objective, pseudo_huber
from .own_breakaway import onset_inputs, pulls, simulated_slip, uniform
from .parameters import Parameters, partition
from .segment import Segment, segments

if TYPE_CHECKING:
    from ..data.recording import Recording


class MotionProblem:
    """Output error: J (4.5), the RMS of measured minus simulated position, pooled over segments.

    A problem for any search: `problem(x)` with (n, dim) rows of free parameters, SI, in the
    order of `problem.space`, returns (n,) costs in the unit in which the rig shows positions
    (mm for the slide bed, as in the paper). A point that is not physical, or that cannot be
    simulated, costs nan. Rows are independent bit for bit, however many a call has.

    Under the loss `absolute`, residuals go through `pseudo_huber`, so that the sum of their
    squares grows as that of the errors' sizes, and J is the RMS of the result. Where the rig
    knows positions only up to a constant, each segment's residuals have mean zero; where the state
    in which a segment begins is estimated, what another state would change is taken out of them.

    Where each slip has a breakaway of its own, a segment is a slip, and after the residuals of the
    motions there is one for each slip: its breakaway less the mean, over the standard deviation
    of that, times the noise (`weights`). Where it is known what the controller of a loop read,
    there is another for each slip, once these are settled: how long after its controller has read
    it begins, less how long that takes on average, over the standard deviation, times the noise.

    `scale` is `unit` in SI, `logs` how many residuals each segment has, in order; with slips, those
    of all motions. `priors` counts those of onsets: a random effect is drawn anew for each slip,
    whatever the errors of its motion are like.
    """

    def __init__(self, parameters: Parameters, train: Sequence[Segment]) -> None:
        self._rig = as_simulated(parameters.rig)
        self.name = f"{parameters.rig.name}/{parameters.law.name}"
        self.parameters = parameters
        for segment in train:
            if parameters.law.warms and segment.recording.temperature is None:
                raise InputError(
                    f"{segment.recording.label}: law {parameters.law.name} needs a temperature: "
                    "map a column to temperature"
                )
        self.space = Space(parameters.free)
        self.weights: BreakawayWeights | None = None
        if parameters.objective.by_slip:
            self.weights = first_weights(parameters, tuple(train))
        self._train_on(train)
        self.unit = parameters.rig.shows.get("position", "m")
        self.scale = unit(self.unit).factor
        widest = max(float(np.ptp(s.recording.position)) for s in train)
        self._bend = KNEE * widest / self.scale
        self._knee = self._bend if parameters.objective.loss == "absolute" else np.inf

    def _train_on(self, train: Sequence[Segment]) -> None:
        self.train = tuple(train)
        self.logs = tuple(int(s.track.sums[0, -1]) for s in train)
        self.samples, self.priors = sum(self.logs), 0
        freed = any(s.start_directions is not None for s in self.train)
        self._plain = not (self._rig.floating or freed or self.weights is not None)
        if self.weights is not None:
            self._onsets = onset_inputs(self._rig, self.train)
            places = {k: place_in_hold(s) for k, s in enumerate(self.train)}
            held = [(k, *place) for k, place in places.items() if place is not None]
            self._holds = held if self.weights.settled else []
            self.logs = (self.samples,)
            self.priors = len(self.train) + len(self._holds)

    def __call__(self, x: Array, /) -> Array:
        """(n, dim) free parameter sets to (n,) values of J."""
        x = np.atleast_2d(x)
        if not self._plain or np.isfinite(self._knee):
            return rms(self.residuals(x))
        p, physical = self._physical(x)
        law = self.parameters.law
        sse = np.full(len(p), np.nan)
        if physical.any():
            sse[physical] = self._rig.misfits(law, p[physical], [s.track for s in self.train])
        cost: Array = np.sqrt(sse / self.samples) / self.scale
        return cost

    def residuals(self, x: Array, /) -> Array:
        """(n, dim) free parameter sets to (n, samples) residuals, in `unit`; J is their RMS."""
        x = np.atleast_2d(x)
        if self.weights is not None:
            return self._slip_residuals(x, self.weights)
        p, physical = self._physical(x)
        if physical.all():
            return self._misfits(p)
        result = np.full((len(p), self.samples), np.nan)
        if physical.any():
            result[physical] = self._misfits(p[physical])
        return result

    def _misfits(self, p: Array) -> Array:
        """Those of complete sets that can be simulated, (n, samples)."""
        tracks = [s.track for s in self.train]
        positions = self._rig.positions_over(self.parameters.law, p, tracks)
        ends = np.cumsum([len(track.t) for track in tracks])[:-1]
        parts = zip(np.split(positions, ends, axis=1), self.train, strict=True)
        misfits = [self._misfit(*part) for part in parts]
        return np.concatenate(misfits, axis=1) if len(misfits) > 1 else misfits[0]

    def _slip_residuals(self, x: Array, weights: BreakawayWeights) -> Array:
        """Of the motion of each slip under its own breakaway, and then of the breakaways."""
        p, physical = self._physical(x)
        result = np.full((len(p), self.samples + self.priors), np.nan)
        p = p[physical]
        if not len(p):
            return result
        law = self.parameters.law
        F, rise = pulls(self._rig, law, p, self.train, self._onsets)
        good = weights.settled
        slips = [
            simulated_slip(self._rig, law, p, s, F[:, k], rise[:, k], rough=not good, levelled=good)
            for k, s in enumerate(self.train)
        ]
        blocks = [self._misfit(x.position, s) for x, s in zip(slips, self.train, strict=True)]
        columns = level_columns(self.parameters, self.train)
        sd = np.array([weights.sd[self.parameters.names[k]] for k in columns])
        off = np.stack([slip.breakaway for slip in slips], axis=1) - p[:, columns]
        blocks.append(weights.noise * off / np.hypot(sd, uniform(rise)))
        for k, since, length in self._holds:
            later, open_by = self._rig.breakaway_delay(np.abs(rise[:, k]), length)
            blocks.append((weights.noise * (since + slips[k].late - later) / open_by)[:, None])
        result[physical] = np.concatenate(blocks, axis=1)
        return result

    def segment_residuals(self, x: Array, segment: Segment, late: float = 0.0) -> Array:
        """The residuals of one segment, (n, its samples that count); nan where not physical.

        Args:
            x: (n, dim) free parameter sets.
            segment: The segment.
            late: By how much later than its drive the motion was measured, s.
        """
        p, physical = self._physical(x)
        residuals = np.full((len(p), int(np.count_nonzero(segment.track.score))), np.nan)
        if physical.any():
            if late:
                positions = self._later(p[physical], segment, late)
            else:
                positions = self._rig.positions(self.parameters.law, p[physical], segment.track)
            residuals[physical] = self._misfit(positions, segment)
        return residuals

    def started_residuals(
        self, x: Array, segment: Segment, starts: Array, constants: Mapping[str, Array]
    ) -> Array:
        """The residuals of one segment from other starts; see `segment_residuals`.

        Args:
            x: (n, dim) free parameter sets.
            segment: The segment.
            starts: Where each starts, m, (n,).
            constants: Of the rig, SI by name, (n,), that each set has a value of its own of.
        """
        p, physical = self._physical(x)
        residuals = np.full((len(p), int(np.count_nonzero(segment.track.score))), np.nan)
        if physical.any():
            own = {name: values[physical] for name, values in constants.items()}
            track, law = segment.track, self.parameters.law
            positions = self._rig.positions_from(law, p[physical], track, starts[physical], own)
            residuals[physical] = self._misfit(positions, segment)
        return residuals

    def _later(self, p: Array, segment: Segment, late: float) -> Array:
        """Positions that were measured so much later, between samples with their velocities."""
        from scipy.interpolate import CubicHermiteSpline  # noqa: PLC0415 - slow to import

        t = segment.track.t
        x, v = self._rig.states(self.parameters.law, p, segment.track)
        positions: Array = CubicHermiteSpline(t, x, v, axis=1)(np.clip(t - late, t[0], t[-1]))
        return positions

    def _misfit(self, positions: Array, segment: Segment) -> Array:
        """Measured less simulated positions of a segment, as the loss counts them."""
        track = segment.track
        residuals: Array = track.measured - positions
        if not track.score.all():
            residuals = residuals.take(np.flatnonzero(track.score), axis=1)
        residuals /= self.scale
        if track.reading.weight != 1.0:
            residuals *= track.reading.weight
        if self._rig.floating:
            residuals -= residuals.mean(axis=1, keepdims=True)
        if (U := segment.start_directions) is not None:
            # einsum, not BLAS, whose sums depend on how many rows there are
            shares = np.einsum("nm,mk->nk", residuals, U)
            residuals -= np.einsum("nk,mk->nm", shares, U)
        return pseudo_huber(residuals, self._knee) if np.isfinite(self._knee) else residuals

    def on(self, rig: Rig) -> MotionProblem:
        """The same problem on a rig of the same kind with other constants."""
        other = copy(self)
        other.parameters = replace(self.parameters, rig=rig)
        simulated = as_simulated(rig)
        other._rig = simulated  # noqa: SLF001 - of its own class
        other.train = tuple(
            replace(s, track=simulated.with_constants(s.track, s.recording)) for s in self.train
        )
        return other

    def weighed(self, weights: BreakawayWeights, train: Sequence[Segment]) -> MotionProblem:
        """The same problem with other weights of its slips' breakaway, and other onsets."""
        other = copy(self)
        other.weights = weights
        other._train_on(train)  # noqa: SLF001 - of its own class
        return other

    def of_log(self, log: Recording) -> MotionProblem:
        """The same problem on the segments of one of its logs."""
        return self.of_segments([s for s in self.train if s.recording is log])

    def of_segments(self, train: Sequence[Segment]) -> MotionProblem:
        """The same problem on other segments."""
        other = copy(self)
        other._train_on(train)  # noqa: SLF001 - of its own class
        return other

    def noise_of(self, x: Array) -> float:
        """Root mean square of the residuals of the motions at a point (dim,), in `unit`."""
        residuals = self.residuals(x[None])
        return float(rms(residuals[:, : self.samples])[0])

    @property
    def dofs(self) -> Mapping[str, float]:
        """Degrees of freedom of parameters that few slips determine, by name."""
        return {} if self.weights is None else self.weights.dof

    def over(self, parameters: Parameters) -> MotionProblem:
        """The same problem over other free parameters or search ranges."""
        other = copy(self)
        other.parameters, other.space = parameters, Space(parameters.free)
        return other

    def widened(self, x: Array) -> MotionProblem | None:
        """The same problem over wider ranges; see `Parameters.widened`."""
        wider = self.parameters.widened(x)
        return None if wider is None else self.over(wider)

    def thinned(self) -> MotionProblem:
        """The problem on fewer samples, for a search; itself where its rig or its law needs all."""
        tracks = None
        if self.weights is None and not self.parameters.law.states:
            tracks = self._rig.thinned([s.track for s in self.train])
        if tracks is None:
            return self
        pairs = zip(self.train, tracks, strict=True)
        return self.of_segments(
            [replace(s, track=track, start_directions=None) for s, track in pairs]
        )

    def by_other_loss(self) -> MotionProblem:
        """The same problem by squares where this one has absolute errors, and the other way."""
        other = copy(self)
        other._knee = np.inf if np.isfinite(self._knee) else self._bend  # noqa: SLF001 - of its own class
        return other

    def reported(self, x: Array) -> float:
        """What a fit reports as its misfit at a point (dim,): J, or the mean absolute error."""
        if self.parameters.objective.loss == "squares":
            return float(self(x[None])[0])
        plain = copy(self)
        plain._knee = np.inf  # noqa: SLF001 - of its own class
        return float(np.mean(np.abs(plain.residuals(x[None]))))

    def finer(self) -> MotionProblem:
        """The same problem with a lower knee of the pseudo-Huber loss: nearly absolute errors."""
        finer = copy(self)
        finer._knee = self._knee * FINER  # noqa: SLF001 - of its own class
        return finer

    def _physical(self, x: Array) -> tuple[Array, NDArray[np.bool_]]:
        p, law = self.parameters.full(x), self.parameters.law
        return p, np.asarray(law.physical(p[:, : len(law.params)]), dtype=bool)


def problem(
    logs: Logs,
    *,
    rig: str | Rig,
    law: str | Law | None = None,
    train: Sequence[Range | str] | Range | str | None = None,
    fixed: Mapping[str, float] | None = None,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    tie: Mapping[str, str] | None = None,
    loss: Loss = "squares",
    restart: bool = False,
    breakaway: Breakaway = "common",
) -> MotionProblem:
    """The problem that `identify` searches on a rig whose law is identified by output error.

    Args:
        logs: One or several logs of the axis, as `identify` takes them.
        rig: A rig or its name in RIGS.
        law: A law or its name in LAWS; by default the rig's first.
        train: Ranges to use, as `112:295`; by default everything.
        fixed: See `partition`.
        bounds: See `partition`.
        tie: See `partition`.
        loss: See `Objective`.
        restart: See `Objective`.
        breakaway: `common` or `scattered`; see `Objective`.

    Raises:
        InputError: a rig that is solved without a search, or what `identify` refuses.
    """
    rig, law = rig_and_law(rig, law)
    rig = as_simulated(rig)
    objective = Objective(loss, restart, breakaway)
    recordings = recording_list(logs, rig)
    rig = rig.behind(recordings)
    parameters = partition(rig, law, fixed=fixed, bounds=bounds, tied=tie, objective=objective)
    train_segments = [
        s for r in ranges_or_all(train, rig) for s in segments(recordings, rig, r, objective)
    ]
    return MotionProblem(parameters, train_segments)
