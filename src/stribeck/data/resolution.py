"""What a sensor resolves: its quantisation step and its noise.

Noise is taken from third differences, which vanish for smooth motion, over samples as far apart as
the sensor holds a value; the middle of their distribution is used, so that slips do not count.
"""

from __future__ import annotations

from functools import wraps
from typing import TYPE_CHECKING, Protocol
from weakref import ref

import numpy as np

from ..space import Array

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray


#: Of longer channels so many samples are looked at, in so many stretches: a million show steps and
#: noise as well as all do.
LONG, STRETCHES = 1 << 20, 64
_LONGEST_HOLD = 8
#: Share of changes that turn back from which on noise rules a channel (white noise: two thirds).
_TURNING = 0.5
#: Steps for each sample by which a held value is left; share of all changes that do so at least,
#: and how many, to show a hold.
_LEFT, _OFTEN, _FEWEST = 1.5, 0.3, 10
#: How many times as coarse large values are that are rounded to digits, a tenth and some margin.
_DIGIT = 5.0
#: Values lie on a comb if this share of them is within a quarter of its increment; of how many
#: values that is seen, and by how many quarters of a tooth over all of them its increment may be
#: off.
_ON, _QUARTER, _LOOKED_AT, _SLIPS = 0.98, 0.25, 2000, 256
#: A speed is constant where the ways of more than this share of samples are those of the samples
#: before; with nothing else to go by, values are at the teeth of a comb within this share of one.
_SAME_WAY, _EXACT = 0.5, 1e-3
#: A sensor that holds its values keeps most of them for times within this ratio.
_REGULAR = 3.0
_QUIET, _QUIET_SD = 0.3, 0.3853  # 30 % of a normal distribution lie within 0.3853 sd
_CUT, _CUT_VARIANCE = 3.0, 0.9733  # variance that a normal keeps within 3 sd


class Positioned(Protocol):
    """What has positions, as a `Recording` does."""

    @property
    def position(self) -> Array:
        """(N,), m or rad."""


def noise(recording: Positioned) -> float:
    """Standard deviation of the position noise beside quantisation, m or rad."""
    return noise_of(recording.position)


def _remembered(look: Callable[[Array], float]) -> Callable[[Array], float]:
    """A look at a channel, made once for an array that nobody may write to."""
    known: dict[int, tuple[ref[Array], float]] = {}

    @wraps(look)
    def remembered(values: Array) -> float:
        if values.flags.writeable:
            return look(values)
        key = id(values)
        entry = known.get(key)
        if entry is None or entry[0]() is not values:
            entry = known[key] = ref(values, lambda _: known.pop(key, None)), look(values)
        return entry[1]

    return remembered


def stretches(values: Array) -> Array:
    """Stretches of a long channel, end to end, all of a shorter one."""
    n = len(values)
    if n <= LONG:
        return values
    starts = np.linspace(0, n - LONG // STRETCHES, STRETCHES).astype(int)
    return np.concatenate([values[k : k + LONG // STRETCHES] for k in starts])


@_remembered
def step(values: Array) -> float:
    """The quantisation step of a channel: the increment whose multiples its values are, or 0.

    Values of a quantised channel lie on a comb, so most neighbours among the distinct values are
    small multiples of one increment, and all of them are; those of a continuous one are not. At a
    constant speed the samples of a continuous one are a comb, too, but each run is another, and
    starts and stops are off it. Where values are rounded to so many digits, the increment grows
    with them: it is that of the larger half.
    """
    values = stretches(values)
    fine = _increment(values)
    sizes = np.abs(values)
    larger = values[sizes > np.median(sizes)]
    if not fine or len(np.unique(larger)) < _FEWEST:
        return fine
    coarse = _increment(larger)
    return coarse if coarse >= _DIGIT * fine else fine


def _increment(values: Array) -> float:
    increment = _spacing(values)
    return 0.0 if increment and _paced(values, increment) else increment


def _spacing(values: Array) -> float:
    distinct = np.unique(values)
    some, gaps = distinct[:: -(-len(distinct) // _LOOKED_AT)].copy(), np.diff(distinct)
    del distinct  # of a long log it is much to keep
    gaps = gaps[gaps > 1e-9 * max(float(np.ptp(values)), 1e-300)]
    if len(gaps) < 4:  # noqa: PLR2004 - fewer distinct values show no comb
        often = np.count_nonzero(np.diff(values)) > 3 * len(gaps)  # flickers, is not set anew
        return float(gaps.min()) if len(gaps) and often else 0.0
    least = float(np.quantile(gaps, 0.1))  # a printed step is 4 here and 5 there: take their mean
    increment, off = _comb(gaps, float(gaps[gaps < 1.6 * least].mean()), 8 * least)
    regular = off < 0.25  # noqa: PLR2004 - half of that is what chance gives
    if regular and _holds(some, increment):
        return increment
    for k in range(2, 6):  # in fast motion neighbours may be some steps apart
        increment, off = _comb(gaps, least / k, 8 * least)
        fine = off < 0.1 and len(gaps) > 20  # noqa: PLR2004 - finer combs fit more by chance
        if fine and _holds(some, increment):
            return increment
    # at constant speeds the way per sample hides the sensor's steps but for starts and stops
    finest = float(gaps.min())
    return finest if regular and _holds(some, finest) else 0.0


def _paced(values: Array, increment: float) -> bool:
    """Whether an increment is the way per sample at a constant speed, and no sensor's.

    Then one sample after another goes on by as many teeth as the one before, and those that do not
    are off the comb: a sensor's are on it while the axis starts and stops, too.
    """
    ways = np.diff(values) / increment
    teeth = np.rint(ways)
    off, again = np.abs(ways - teeth)[1:], teeth[1:] == teeth[:-1]
    moving = teeth[1:] != 0.0
    if not moving.any() or np.mean(again[moving]) <= _SAME_WAY:
        return False
    changing = off[~again & (np.abs(ways[1:]) > _EXACT)]
    if len(changing) < _FEWEST:
        return bool(np.quantile(off, _ON) > _EXACT)
    return bool(np.quantile(changing, 0.9) > _QUARTER)


def _comb(gaps: Array, guess: float, limit: float) -> tuple[float, float]:
    """The increment nearest to a guess, and how far nine of ten gaps keep to its multiples."""
    small = gaps[gaps < limit]
    if len(small) < len(gaps) / 8:
        return 0.0, 1.0
    for _ in range(2):
        guess = float(small.sum() / max(np.rint(small / guess).sum(), 1.0))
    return guess, float(np.quantile(np.abs(small / guess - np.rint(small / guess)), 0.9))


def _holds(some: Array, increment: float) -> bool:
    """Whether distinct values, in order, lie on one comb, and not those of each run on another.

    Its increment is known but for some teeth over all of the values: it is where these are most of
    one phase.
    """
    x = some - some[0]
    span = float(x[-1])
    slips = np.arange(-_SLIPS, _SLIPS + 1)
    teeth = span / increment + slips[np.abs(slips) < 2.0 * span / increment] / 4.0
    phasors = _phasors(x / span, teeth)
    best = int(np.argmax(np.abs(phasors)))
    place = x * (teeth[best] / span) - np.angle(phasors[best]) / (2.0 * np.pi)
    tooth = np.rint(place)
    slope, start = np.polyfit(tooth, place, 1)
    off = np.abs(place - slope * tooth - start)
    return bool(np.quantile(off, _ON) < _QUARTER)


def _phasors(x: Array, teeth: Array) -> NDArray[np.complex128]:
    """The mean of exp(2πi k x) for each number of teeth k; these are evenly spaced.

    As products of phases for each so many of them, and for those between: most exponentials are not
    asked for.
    """
    each = int(np.ceil(np.sqrt(len(teeth))))
    begins, between = teeth[::each], teeth[:each] - teeth[0]
    coarse, fine = (np.exp(2j * np.pi * k[:, None] * x) for k in (begins, between))
    means: NDArray[np.complex128] = np.matmul(coarse, fine.T).ravel()[: len(teeth)] / len(x)
    return means


@_remembered
def noise_of(x: Array) -> float:
    """Standard deviation of a channel's noise beside quantisation."""
    q = step(x)
    x = stretches(x)
    k = _hold(x, q)
    if len(x) <= 3 * k + 2:
        return 0.0
    z = x[3 * k :] - 3 * x[2 * k : -k] + 3 * x[k : -2 * k] - x[: -3 * k]
    scale = float(np.quantile(np.abs(z), _QUIET)) / _QUIET_SD
    middle = z[np.abs(z) <= _CUT * scale]
    variance = float(np.mean(middle**2)) / (20 * _CUT_VARIANCE) if scale else 0.0
    return float(np.sqrt(max(variance - q**2 / 12, 0.0)))


def _hold(x: Array, q: float) -> int:
    """For how many samples a sensor that is read too often repeats a value, as a rule.

    Where noise turns a value about, any value that stays is one that is held. Elsewhere a coarse
    sensor repeats values, too, while the motion is slow: only those count then that were left by
    more than the motion of so many samples makes steps.
    """
    changes = np.flatnonzero(np.diff(x))
    lengths, jumps = np.diff(changes), np.diff(x)[changes[1:]]
    turning = np.mean(jumps[1:] * jumps[:-1] < 0) if len(jumps) > 1 else 0.0
    if turning < _TURNING:
        telling = np.abs(jumps) > _LEFT * q * lengths
        if telling.sum() < _OFTEN * len(telling):
            return 1
        lengths = lengths[telling]
    if len(lengths) <= _FEWEST:
        return 1
    short, long = np.quantile(lengths, [0.2, 0.8])
    if long > _REGULAR * short:
        return 1  # an axis that rests now and then, no clock
    return int(min(long, _LONGEST_HOLD))
