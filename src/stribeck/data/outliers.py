"""Samples that stand apart from all others of their channel."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..space import Array
from .resolution import noise_of, step

#: Share of the samples that may stand apart, and how many may in any log.
SHARE, MOST = 0.02, 8
#: What stands apart does by more than so many steps and standard deviations of the sensor.
STEPS, SIGMAS = 3.0, 12.0
#: Single samples of a force stray if they stand so many times as far out as any other,
_FAR = 4.0
#: and by this share of the channel's range.
_WILD = 0.02
#: Samples that are worked on at once.
_BLOCK = 1 << 16


def force_strays(u: Array) -> NDArray[np.intp]:
    """Single samples of a force that stand out from both neighbours, far beyond all others."""
    out = np.zeros(max(len(u) - 2, 0))
    for k in range(0, len(out), _BLOCK):
        d = np.diff(u[k : k + _BLOCK + 2])
        both = np.minimum(np.abs(d[:-1]), np.abs(d[1:]))
        out[k : k + _BLOCK] = np.where(d[:-1] * d[1:] < 0, both, 0.0)
    far = largest(out, _FAR, max(MOST, int(SHARE * len(u))))
    least = max(STEPS * step(u) + SIGMAS * noise_of(u), _WILD * float(np.ptp(u)))
    return np.sort(far[out[far] > least] + 1)


def largest(sizes: Array, ratio: float, most: int) -> NDArray[np.intp]:
    """The places of what stands apart, largest first; see `apart`.

    Args:
        sizes: (N,).
        ratio: By which it exceeds all else.
        most: How many at most.
    """
    places = np.arange(len(sizes))
    if len(sizes) > most + 1:
        least = np.partition(sizes, len(sizes) - most - 1)[len(sizes) - most - 1]
        places = np.flatnonzero(sizes >= least)
    order = places[np.argsort(sizes[places])[::-1]][: most + 1]
    return order[: apart(sizes[order], ratio, most)]


def apart(sizes: Array, ratio: float, most: int) -> int:
    """How many of the largest stand apart: each is `ratio` times the largest of the rest.

    Args:
        sizes: In falling order.
        ratio: By which the last of them exceeds the next.
        most: Count that they never exceed.
    """
    most = min(most, len(sizes) - 1)
    if most < 1:
        return 0
    apart = np.flatnonzero(sizes[:most] >= ratio * sizes[1 : most + 1])
    apart = apart[sizes[apart] > 0]
    return int(apart[-1]) + 1 if len(apart) else 0
