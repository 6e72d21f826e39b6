"""From a measured position to velocity and acceleration, without delay, and to fewer samples.

The filtering of inverse dynamics identification (Janot, Gautier, Brunot, Data Set and Reference
Models of EMPS, 2019): the position low-passed forwards and backwards, central differences, then
both sides of the force balance decimated in parallel, so that what the decimation filter does to
one side it does to the other.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np

from ..errors import InputError
from ..space import Array
from .derived_channel import SampledChannel, Shifted, Slope
from .low_pass import butterworth, chebyshev
from .resampling import GAP, interpolated
from .runs import runs, within
from .zero_phase import BLOCK, Samples, Signal, zero_phase

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .recording import Recording

#: Sampling instants may be off their grid by this share of an interval (EMPS: 3e-5).
JITTER = 0.01
#: A log is as long as so many times its samples at their median interval, at most.
_SPARSEST = 50.0
#: The cut-off stays at or below this share of the sampling rate: there a difference still sees all
#: of a velocity (one of order 2 94 %), and the report's own 100 Hz at 1 kHz is this share.
CUTOFF_SHARE = 0.1
#: Decimation filter (Chebyshev): order, ripple in dB, edge as a share of the new Nyquist frequency.
_ORDER, _RIPPLE, _EDGE = 8, 0.05, 0.8
#: The decimation filter runs both ways, and at rest it lies at the bottom of its ripple each time.
DECIMATION_GAIN = 10 ** (-2 * _RIPPLE / 20)
#: A velocity has the sign that it shows beyond so many standard deviations of its noise.
_SIGMAS = 3.0
#: A filter reaches as far as so much of the energy of its response, which is followed for so many
#: periods of its cut-off: farther out it leaves a tenth of an amplitude that is small itself.
_ENERGY, _LONG = 0.95, 30


@dataclass(frozen=True)
class Filtering:
    """How a log is made ready for the force balance. All of it is free of delay.

    Args:
        order: Of the Butterworth low-pass on the position (run both ways, so twice that).
        cutoff_hz: Its cut-off, Hz; a log sampled below ten times that gets a tenth of its rate.
        edge: Time dropped at the start and at the end, s, where filter and differences lack
            neighbours; longer as the cut-off is lower.
        decimation: Samples that become one; by default the rate over the cut-off, so that the
            rows kept reach to 0.4 of it.
        slowest: Rows at a lower speed are dropped, m/s (rad/s): friction at rest is whatever
            balances the drive, and no law of slip explains it.
        reversals: Whether rows about a change of direction stay, where the sign of the velocity
            is not known to the error of its estimate (`unsure_of_direction`).
        velocity: Differences of the position, or the channel that was recorded, low-passed alike.
        share: The cut-off's greatest share of the sampling rate.
        accuracy: Order of accuracy of the differences, 2 or 6. Those of order 6 are true to 2 % up
            to the fifth of the sampling rate, where those of order 2 lose a quarter of a velocity;
            at a seventeenth of it these lose 2.2 % of one, 4.4 % of an acceleration.

    The report's own, for 1 kHz, is `Filtering(edge=(0.049, 0.0), reversals=True, accuracy=2)`: 4th
    order at 100 Hz, the first 49 samples dropped and none at the end, every 10th sample kept,
    reversals too.
    """

    order: int = 4
    cutoff_hz: float = 100.0
    edge: tuple[float, float] = (0.049, 0.049)
    decimation: int | None = None
    slowest: float = 0.0
    reversals: bool = False
    velocity: Literal["position", "recorded"] = "position"
    share: float = CUTOFF_SHARE
    accuracy: Literal[2, 6] = 6

    def __post_init__(self) -> None:
        if not 1 <= self.order <= 10:  # noqa: PLR2004 - above, the filter rings for seconds
            raise InputError(f"filtering: order {self.order} is not within 1:10")
        if not (np.isfinite(self.cutoff_hz) and self.cutoff_hz > 0):
            raise InputError(f"filtering: cutoff_hz {self.cutoff_hz} is not above zero")
        if not (min(self.edge) >= 0 and np.isfinite(max(self.edge))):
            raise InputError(f"filtering: edge {self.edge} must be two times of 0 s or more")
        if self.decimation is not None and self.decimation < 1:
            raise InputError(f"filtering: decimation {self.decimation} is below 1")
        if not self.slowest >= 0:
            raise InputError(f"filtering: slowest {self.slowest} is below zero")
        if self.accuracy not in (2, 6):
            raise InputError(f"filtering: accuracy {self.accuracy} is neither 2 nor 6")

    def cutoff(self, rate: float) -> float:
        """The cut-off for a sampling rate, both in Hz; half of it where there is no low pass."""
        share = self.share if self.velocity == "position" else 0.5
        return min(self.cutoff_hz, share * rate)

    def passes(self, rate: float) -> bool:
        """Whether nothing is low-passed: a velocity that is no difference needs it not so far."""
        return self.cutoff(rate) >= 0.5 * rate

    def differences(self, rate: float) -> int:
        """Order of the differences at a sampling rate in Hz.

        A velocity that nothing low-passes has corners, over which those of order 6 ring.
        """
        return 2 if self.passes(rate) else self.accuracy

    def factor(self, rate: float) -> int:
        """Samples that become one at a sampling rate in Hz."""
        if self.passes(rate):
            return self.decimation or 1
        return self.decimation or max(1, round(rate / self.cutoff(rate)))

    def blur(self, rate: float) -> int:
        """Samples to each side over which the low pass smears a kink of the position."""
        if self.passes(rate):
            return 0
        return extent(_low_pass_response(self.order, self.cutoff(rate) / rate))

    def lowered(self, share: float, rate: float) -> Filtering:
        """The same with a share of the cut-off that it has at a sampling rate in Hz."""
        used = share * self.cutoff(rate)
        longer = self.cutoff_hz / used
        return replace(self, cutoff_hz=used, edge=(self.edge[0] * longer, self.edge[1] * longer))

    def edges(self, rate: float) -> tuple[int, int]:
        """Samples dropped at the start and at the end."""
        longer = rate * self.cutoff_hz / self.cutoff(rate)
        return round(self.edge[0] * longer), round(self.edge[1] * longer)


@dataclass(frozen=True, eq=False)
class Even:
    """Channels of a log on an even grid of time.

    Args:
        t: Time, s, (N,).
        position: (N,).
        force: (N,); nan where it was not measured.
        nearest: The sample of the log nearest to each, (N,); None where each is a sample.
        known: False inside gaps of the log, (N,); None where there are none.
        rate: Samples a second.
        velocity: As it was recorded, (N,); None where it was not.
        less: The known force that is taken off the measured one, (N,) or 0.
        notes: What was done to the log, a sentence each.
    """

    t: Array
    position: Array
    force: Array
    nearest: NDArray[np.intp] | None
    known: NDArray[np.bool_] | None
    rate: float
    velocity: Array | None = None
    less: Array | float = 0.0
    notes: tuple[str, ...] = ()

    def counts(self, chosen: NDArray[np.bool_], at: slice) -> NDArray[np.bool_]:
        """Whether samples of the grid were measured, and are chosen as samples of the log."""
        if self.nearest is None or self.known is None:
            return chosen[at].copy()
        return np.asarray(chosen[self.nearest[at]] & self.known[at])


def even(recording: Recording, force: Array) -> Even:
    """A log on an even grid: itself, or resampled where its sampling is irregular.

    Position is resampled by a cubic spline, because it is differentiated twice afterwards, the
    other channels are interpolated one sample after the other, all at the log's median interval.

    Raises:
        InputError: nearly all of it lies in gaps.
    """
    t, n = recording.t, len(recording)
    less = 0.0 if recording.known_force is None else recording.known_force.values
    step = float(t[-1] - t[0]) / (n - 1)
    if all(
        np.abs(t[k : k + BLOCK] - (t[0] + step * np.arange(k, min(k + BLOCK, n)))).max()
        <= JITTER * step
        for k in range(0, n, BLOCK)
    ):
        rate = _round_rate(1.0 / step)
        return Even(t, recording.position, force, None, None, rate, recording.velocity, less)
    from scipy.interpolate import CubicSpline  # noqa: PLC0415 - most logs never need it

    step = recording.dt
    if t[-1] - t[0] > _SPARSEST * n * step:
        longest = int(np.argmax(np.diff(t)))
        raise InputError(
            f"{recording.label}: its times leave most of {t[-1] - t[0]:.4g} s out, most between "
            f"{t[longest]:.6g} and {t[longest + 1]:.6g} s: cut the log there"
        )
    grid = t[0] + step * np.arange(int((t[-1] - t[0]) / step * (1 + 1e-12)) + 1)
    after = np.clip(np.searchsorted(t, grid, side="left"), 1, n - 1)
    nearest = np.where(grid - t[after - 1] < t[after] - grid, after - 1, after)
    known = (t[after] - t[after - 1] <= GAP * step) | (np.abs(grid - t[nearest]) < JITTER * step)
    note = f"{recording.label}: sampled irregularly, resampled at {1 / step:.6g} Hz"
    if not known.all():
        note += f"; {100 * np.mean(~known):.2g} % of it lies in gaps and is not used"
    return Even(
        grid,
        np.asarray(CubicSpline(t, recording.position)(grid)),
        interpolated(grid, t, force),
        nearest,
        known,
        1.0 / step,
        None if recording.velocity is None else interpolated(grid, t, recording.velocity),
        interpolated(grid, t, less) if isinstance(less, np.ndarray) else less,
        (note,),
    )


def _round_rate(rate: float) -> float:
    """A rate without the rounding of the clock that stamped the log (999.9999 Hz is 1 kHz)."""
    rounded = round(rate)
    return float(rounded) if rounded and abs(rate - rounded) < 1e-6 * rate else rate


class SmoothMotion(NamedTuple):
    """A low-passed position, m (rad), with its first and second slope over time, (N,) each."""

    position: SampledChannel
    velocity: SampledChannel
    acceleration: SampledChannel


def smooth_motion(position: Array, rate: float, filtering: Filtering) -> SmoothMotion:
    """A position low-passed, velocity and acceleration by central differences as they are needed.

    Raises:
        InputError: too few samples for the filter.
    """
    padding = 3 * filtering.order
    if len(position) <= padding:
        raise InputError(f"{len(position)} samples are too few to filter: give more than {padding}")
    order = filtering.differences(rate)
    if filtering.passes(rate):
        v = Slope(position, rate, order)
        return SmoothMotion(position, v, Slope(v, rate, order))
    sections = butterworth(filtering.order, filtering.cutoff(rate) / rate)
    # The filter starts from the first sample, so that an offset of metres costs no digits.
    first, n = position[0], len(position)
    q = zero_phase(sections, lambda at: position[at] - first, n, padding, slice(0, n, 1))[:, 0]
    v = Slope(q, rate, order)
    return SmoothMotion(Shifted(q, float(first)), v, Slope(v, rate, order))


def smooth(position: Array, rate: float, filtering: Filtering) -> tuple[Array, Array, Array]:
    """The same as arrays: position, velocity, acceleration, (N,) each.

    Raises:
        InputError: too few samples for the filter.
    """
    q, v, a = (channel[:] for channel in smooth_motion(position, rate, filtering))
    return q, v, a


def unsure_of_direction(
    v: SampledChannel, rate: float, filtering: Filtering, error: float
) -> NDArray[np.bool_]:
    """Where a low-passed velocity does not tell which way the axis moves, (N,).

    There it is within the error of its estimate. So it is for as long about each change of sign
    as the low pass smears a kink, as it is that which reverses, not the axis; at rest its ringing
    does.

    Args:
        v: As `smooth_motion` returns it, (N,).
        rate: Samples a second.
        filtering: The low pass.
        error: `velocity_error`, m/s (rad/s).
    """
    unsure, n = np.zeros(len(v), dtype=bool), len(v)
    for k in range(0, n, BLOCK):
        some = v[slice(k, min(k + BLOCK + 1, n))]  # with the first of the next block
        here = unsure[k : k + len(some)]
        here |= (some <= error) & (some >= -error)
        for way in (some > 0, some < 0):
            turns = way[1:] != way[:-1]
            here[1:] |= turns
            here[:-1] |= turns
    return within(unsure, filtering.blur(rate))


def velocity_error(noise: float, step: float, rate: float, filtering: Filtering) -> float:
    """How far a low-passed velocity may be off, m/s (rad/s).

    Three standard deviations of the noise that the low pass leaves, and the peak that it makes of
    one quantisation step.

    Args:
        noise: Standard deviation of what the velocity comes from: the position, or itself.
        step: Quantisation step of the same.
        rate: Samples a second.
        filtering: The low pass.
    """
    if filtering.passes(rate):
        return _SIGMAS * noise + 0.5 * step
    low_pass = _low_pass_response(filtering.order, filtering.cutoff(rate) / rate)
    if filtering.velocity == "recorded":
        return _SIGMAS * noise * float(np.linalg.norm(low_pass)) + 0.5 * step
    rms = float(np.linalg.norm(Slope(low_pass, rate, filtering.differences(rate))[:]))
    return _SIGMAS * noise * rms + step * rate * float(low_pass.max())


class MotionNoise(NamedTuple):
    """Standard deviations of the noise of a low-passed motion: velocity and acceleration, SI."""

    v: float
    a: float


def motion_noise(sd: float, rate: float, filtering: Filtering) -> MotionNoise:
    """What white noise leaves in velocity and acceleration.

    Args:
        sd: Its standard deviation in what they come from: the position, or the recorded velocity.
        rate: Samples a second.
        filtering: The low pass.
    """
    response = np.eye(1, 25, 12)[0]
    if not filtering.passes(rate):
        response = _low_pass_response(filtering.order, filtering.cutoff(rate) / rate)
    order = filtering.differences(rate)
    v = response if filtering.velocity == "recorded" else Slope(response, rate, order)[:]
    a = Slope(v, rate, order)[:]
    return MotionNoise(sd * float(np.linalg.norm(v)), sd * float(np.linalg.norm(a)))


class PositionError(NamedTuple):
    """How far a low-passed position is off, m (rad): its standard deviation, and at most."""

    sd: float
    most: float


def position_error(noise: float, step: float, rate: float, filtering: Filtering) -> PositionError:
    """The error of a low-passed position, as `velocity_error`."""
    left = 1.0
    if not filtering.passes(rate):
        low_pass = _low_pass_response(filtering.order, filtering.cutoff(rate) / rate)
        left = float(np.linalg.norm(low_pass))
    sd = left * float(np.hypot(noise, step / np.sqrt(12)))
    return PositionError(sd, _SIGMAS * left * noise + 0.5 * step)


class Gaps:
    """Gaps in a channel, none if all of it is one.

    Args:
        marked: Samples that lie in one, (N,).

    `starts` has the first sample of each, `left` and `right` the samples beside them: at an end of
    the channel both are that on the other side.
    """

    def __init__(self, marked: NDArray[np.bool_]) -> None:
        self.marked = np.zeros_like(marked) if marked.all() else marked
        self.starts, stops = runs(self.marked)
        before = self.starts - 1
        self.left = np.where(before < 0, np.minimum(stops, len(marked) - 1), before)
        self.right = np.where(stops == len(marked), np.maximum(before, 0), stops)


class Bridged:
    """A signal with straight lines across gaps; they end level with their edges.

    It is linear in the signal, so that a balance whose sides are bridged alike holds as before, and
    what a filter mixes into its neighbours from a gap is alike on both sides.

    Args:
        signal: Columns of N samples.
        gaps: Where it is not known.
    """

    def __init__(self, signal: Signal, gaps: Gaps) -> None:
        self._signal, self._gaps = signal, gaps
        self._edges = tuple(signal(at) for at in (gaps.left, gaps.right))

    def __call__(self, rows: Samples) -> Array:
        """Some samples, (len(rows), ...)."""
        x = self._signal(rows)
        gaps = self._gaps
        flagged = np.flatnonzero(gaps.marked[rows])
        if not len(flagged):
            return x
        at = flagged + rows.start if isinstance(rows, slice) else rows[flagged]
        run = np.searchsorted(gaps.starts, at, side="right") - 1
        left, right = gaps.left[run], gaps.right[run]
        share = np.where(right > left, (at - left) / np.maximum(right - left, 1), 0.0)
        share = share.reshape(-1, *(1,) * (x.ndim - 1))
        result = x.copy()
        before, after = (edge[run] for edge in self._edges)
        result[flagged] = (1.0 - share) * before + share * after
        return result


def bridged(x: Array, gaps: NDArray[np.bool_]) -> Array:
    """Columns (N, ...) with straight lines across gaps, (N,); see `Bridged`."""
    return Bridged(lambda at: x[at], Gaps(gaps))(slice(0, len(x)))


def extent(response: Array) -> int:
    """Samples to each side of its middle within which a response has 95 % of its energy."""
    middle = len(response) // 2
    energy = response[middle:] ** 2 + response[middle::-1] ** 2
    energy[0] /= 2
    return int(np.searchsorted(np.cumsum(energy), _ENERGY * energy.sum()))


@cache
def _low_pass_response(order: int, share: float) -> Array:
    """The position's low pass of an impulse, both ways; the cut-off a share of the rate."""
    impulse = np.zeros(2 * round(_LONG / share) + 1)
    impulse[len(impulse) // 2] = 1.0
    every = slice(0, len(impulse), 1)
    sections = butterworth(order, share)
    return zero_phase(sections, lambda at: impulse[at], len(impulse), 3 * order, every)[:, 0]


def low_passed(x: Array, rate: float, filtering: Filtering) -> Array:
    """A channel through the same low pass, (N,)."""
    return x if filtering.passes(rate) else smooth_motion(x, rate, filtering).position[:]


#: Fewest samples that can be decimated: the filter mirrors all but one of them at the ends.
DECIMABLE = 3 * _ORDER + 1


def decimate(x: Array, factor: int) -> Array:
    """Columns (N, ...) low-passed without delay and thinned to (ceil(N / factor), ...).

    The last sample is always kept. A constant comes out 1.1 % smaller (`DECIMATION_GAIN`), as
    every column does, so that a balance of forces stays one.
    """
    return x if factor == 1 else decimated(lambda at: x[at], len(x), factor)


def decimated(signal: Signal, n: int, factor: int) -> Array:
    """The same of a signal of n samples, which is asked for a block of them at a time."""
    if factor == 1:
        return np.concatenate([
            signal(slice(k, min(k + BLOCK, n))) for k in range(0, n, BLOCK)
        ])  # fmt: skip
    thin = zero_phase(_decimation(factor), signal, n, DECIMABLE - 1, kept(n, factor))
    return thin[:, 0] if signal(slice(0, 1)).ndim == 1 else thin


@cache
def _decimation(factor: int) -> Array:
    """The low pass before thinning, second-order sections, (n, 6); a search asks for it often."""
    return chebyshev(_ORDER, _RIPPLE, 0.5 * _EDGE / factor)


def kept(n: int, factor: int) -> slice:
    """Which of n samples `decimate` keeps."""
    return slice((n - 1) % factor, n, factor)
