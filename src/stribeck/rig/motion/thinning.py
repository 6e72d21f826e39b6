"""Tracks of fewer samples: enough for a search to come near its answer.

Logs are sampled more finely than a smooth motion has to be simulated, and a step ends at every
sample, because the inputs of the drive are known there. A search that looks for a basin may pass
several samples at a step; what it ends with is refitted on all of them.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from .track import Track

#: By how much an input may be off between the samples that are kept, and the measured position by
#: its root mean square, as shares of their standard deviations.
INPUT, POSITION = 0.005, 0.02
#: So many samples of each motion are left at least; and thinning that leaves more than this share
#: of all samples is not worth its while.
FEWEST, WORTH = 100, 0.7
#: Rounding of a step in samples.
_NEARLY = 1e-6


def thinned(tracks: Sequence[Track], step: float) -> list[Track] | None:
    """The tracks with samples no closer than a step, s, where their inputs allow that.

    None where that leaves most of the samples, or other motions than were measured.
    """
    counts = [int(np.count_nonzero(track.score)) for track in tracks]
    every = min(
        *(int(step / float(np.median(np.diff(track.t))) + _NEARLY) for track in tracks),
        min(counts) // FEWEST,
    )
    if every < 2:  # noqa: PLR2004 - each sample
        return None
    kept = [_kept(track, every) for track in tracks]
    before = sum(len(track.t) for track in tracks)
    if not all(map(len, kept)) or sum(map(len, kept)) > WORTH * before:
        return None
    return [_of_samples(track, k, every) for track, k in zip(tracks, kept, strict=True)]


def _kept(track: Track, every: int) -> NDArray[np.intp]:
    """Every n-th sample, the last, and those without which an input would be another.

    None at all where the measured motion is quicker than that.
    """
    t, N = track.t, len(track.t)
    keep = np.zeros(N, dtype=bool)
    keep[::every] = keep[-1] = True
    off = track.measured - np.interp(t, t[keep], track.measured[keep])
    if float(np.sqrt(np.mean(off * off))) > POSITION * float(np.std(track.measured)):
        return np.empty(0, dtype=np.intp)
    needed = np.zeros(N, dtype=bool)
    for a, held in zip(track.inputs, track.held, strict=True):
        if held:
            needed[1:] |= np.diff(a) != 0.0
        else:
            needed |= np.abs(a - np.interp(t, t[keep], a[keep])) > INPUT * float(np.std(a))
    return np.flatnonzero(keep | needed)


def _of_samples(track: Track, kept: NDArray[np.intp], every: int) -> Track:
    """A track of those samples; those beside every n-th one do not count."""
    return track.of_samples(kept, np.where(kept % every == 0, track.score[kept], 0.0))
