"""The onset of a slip under a force that is held and flickers: the reading that broke it away.

A force that goes by a noisy reading does not rise from one hold to the next, so that it breaks an
axis away where it is greater than ever before in the rest. That says more of the breakaway than
when the slip begins does: it lies between what the axis bore and what it did not. Where slips break
away at one level, that level says under which reading each does, and where motions leave that open
(a slip that begins early and goes slowly at first looks like one that begins late), the pattern of
the readings does not.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ..space import Array

if TYPE_CHECKING:
    from ..data.departures import SlipOnset
    from ..rig.motion.track import Track
    from ..rig.simulated import SimulatedRig

#: A slip begins early in its hold: one that seems to in the last share of it belongs to the next.
_LATE = 0.25
#: Holds by which one slip's onset may be off before there is a fit, by which all may be together,
#: and by which they may differ (root mean square) where they break away at one level.
_FAR, _SHIFT, _APART = 3.0, 2.0, 0.75


@dataclass(frozen=True, eq=False)
class _Holds:
    """The holds of a force over a slip and the rest before it.

    Args:
        t: When each begins, s.
        until: When it ends.
        pull: In the direction of the slip, N.
        borne: The greatest before each, N.
    """

    t: Array
    until: Array
    pull: Array
    borne: Array

    @property
    def span(self) -> float:
        return float(np.median(np.diff(self.t)))


def held_onset(rig: SimulatedRig, track: Track, onset: SlipOnset, instant: float) -> SlipOnset:
    """An onset at about an instant, by the stretch that the controller read.

    It lies in the hold of that instant, or in the nearest under which the axis is pulled harder
    than before.

    Args:
        rig: The rig.
        track: Of the slip, with its rest before.
        onset: Where it rests and in which direction it goes.
        instant: s.
    """
    holds = _holds(rig, track, onset)
    if holds is None:
        return onset
    return _placed(onset, holds, _nearest(holds, instant), instant)


def held_onsets(
    rig: SimulatedRig, tracks: Sequence[Track], onsets: Sequence[SlipOnset], instants: Array
) -> list[SlipOnset]:
    """Onsets of the slips of one log in one direction at about some instants.

    Those of one breakaway level for all of them if there is one at which they begin in time with
    each other; else each by itself.

    Args:
        rig: The rig.
        tracks: Of the slips.
        onsets: Where they rest and in which direction they go.
        instants: s, (slips,).
    """
    every = [_holds(rig, track, onset) for track, onset in zip(tracks, onsets, strict=True)]
    known = [holds for holds in every if holds is not None]
    if len(known) < len(every):
        return list(onsets)
    at = _of_one_level(known, instants)
    if at is None:
        at = [_nearest(holds, instant) for holds, instant in zip(known, instants, strict=True)]
    return [_placed(*each) for each in zip(onsets, known, at, instants.tolist(), strict=True)]


def _holds(rig: SimulatedRig, track: Track, onset: SlipOnset) -> _Holds | None:
    begins = np.append(0, np.flatnonzero(np.diff(track.stretch)) + 1)
    if len(begins) < 3:  # noqa: PLR2004 - one before, and one beside
        return None
    pull = onset.direction * rig.rough_pull(track, onset.position)[begins]
    until = np.append(track.t[begins[1:]], track.t[-1])
    borne = np.append(-np.inf, np.maximum.accumulate(pull)[:-1])
    return _Holds(track.t[begins], until, pull, borne)


def _nearest(holds: _Holds, instant: float) -> int:
    """The hold of an instant, or the nearest that pulls harder than any before."""
    own = min(max(int(np.searchsorted(holds.t, instant, side="right")) - 1, 1), len(holds.t) - 2)
    away = np.maximum(np.maximum(holds.t - instant, instant - holds.until), 0.0)
    away[own + 1 :] -= _LATE * holds.span
    away[holds.pull <= holds.borne] = np.inf
    away[0] = np.inf
    at = int(np.argmin(away))
    return own if away[at] > _FAR * holds.span else at


def _of_one_level(every: Sequence[_Holds], instants: Array) -> list[int] | None:
    """The holds that one level tells; None where no level is in time with the instants."""
    span = float(np.median([holds.span for holds in every]))
    near = [
        holds.pull[1:][np.abs(holds.t[1:] - instant) < 4.0 * _FAR * span]
        for holds, instant in zip(every, instants, strict=True)
    ]
    best: tuple[float, list[int]] | None = None
    for level in np.unique(np.concatenate(near)) - 1e-9:
        at = [int(np.argmax(holds.pull > level)) for holds in every]
        off = np.array(
            [t - h.t[k] - 0.5 * span for t, h, k in zip(instants, every, at, strict=True)]
        )
        apart = float(np.std(off)) / span
        cost = len(off) * (apart / _APART) ** 2 + (float(off.mean()) / (_SHIFT * span)) ** 2
        if min(at) > 0 and apart < _APART and (best is None or cost < best[0]):
            best = cost, at
    return None if best is None else best[1]


def _placed(onset: SlipOnset, holds: _Holds, at: int, instant: float) -> SlipOnset:
    return replace(
        onset,
        before=float(holds.t[int(np.argmax(holds.pull[:at]))]),
        after=float(holds.t[at]),
        instant=float(np.clip(instant, holds.t[at], holds.until[at])),
    )
