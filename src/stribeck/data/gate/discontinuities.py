"""Positions that wrap, start anew or stray for a sample; forces that stray for a sample."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ...space import Array
from ..outliers import force_strays
from ..resolution import step
from .fault import Fault, Kind, mask, shown_as
from .leaps import MOSTLY, WIDEST, Leaps, leaps, turns

if TYPE_CHECKING:
    from ..recording import Recording

#: A leap of an angle is a turn, and leaps are of one modulus, within this share of it.
ALIKE = 0.02
#: A log that leaps more often is not cut: nothing says which piece has the origin.
PIECES = 5
#: A piece that stands to the command as the log's beginning does is kept where it has at least this
#: share of the longest's samples.
ORIGIN = 0.2
#: The longest piece of a cut log must hold so many samples.
FEWEST = 20
#: Samples of one value before a leap from which on the sensor stood, and the move made up for it.
STOOD = 5
#: Times that a note lists.
_LISTED = 3
#: A command goes along with a leap to this share of it where rows are missing.
ALONG = 0.3


def strays(x: Array, found: Leaps) -> NDArray[np.intp]:
    """Samples that leap away and back within three samples."""
    samples: list[int] = []
    k = 0
    while k + 1 < len(found.at):
        i, j = int(found.at[k]), int(found.at[k + 1])
        left = abs(found.size[k] + found.size[k + 1])
        returns = left <= 0.2 * abs(found.size[k]) + found.tolerance
        if j - i <= WIDEST and returns and abs(x[j + 1] - x[i]) < abs(x[i + 1] - x[i]):
            samples += range(i + 1, j + 1)
            k += 2
        else:
            k += 1
    return np.array(samples, dtype=np.intp)


def modulus(recording: Recording, found: Leaps) -> float:
    """What a position wraps by, if that is certain; else 0.

    An angle wraps by a turn. A length wraps if it leaps from one end of its range to the other, by
    one amount twice and more, or once by a power of two of its steps, as counters do.
    """
    x, sizes = recording.position, np.abs(found.size)
    if not len(sizes):
        return 0.0
    turn = 2 * np.pi
    against = np.sign(found.size) * found.speed * recording.dt <= found.tolerance
    if not np.mean(against) >= MOSTLY:
        return 0.0
    if recording.rotary and np.all(np.abs(sizes - turn) <= ALIKE * turn):
        return float(turn)
    size = float(np.median(sizes))
    edge = ALIKE * size + found.tolerance + _way(recording, found)
    one = np.all(np.abs(sizes - size) <= ALIKE * size + found.tolerance)
    full = np.ptp(x) <= size + edge and np.all(_at_ends(x, found.at, edge))
    if not (one and full):
        return 0.0
    if (q := step(x)) > 0:
        power = q * 2.0 ** np.round(np.log2(size / q))
        if power >= 2**8 * q and abs(size - power) <= found.tolerance + 1e-3 * size:
            return float(power)
    return size if len(sizes) > 1 else 0.0


def _way(recording: Recording, found: Leaps) -> float:
    """What the axis travels in two samples about a leap."""
    return 2 * float(np.max(np.abs(found.speed))) * recording.dt


def _at_ends(x: Array, at: NDArray[np.intp], edge: float) -> NDArray[np.bool_]:
    low, high = float(x.min()), float(x.max())
    first, second = x[at], x[at + 1]
    return ((first >= high - edge) & (second <= low + edge)) | (
        (first <= low + edge) & (second >= high - edge)
    )


def unwrapped(x: Array, at: NDArray[np.intp], size: Array, by: float) -> Array:
    """A position without its wraps."""
    turns = np.zeros(len(x))
    turns[at + 1] = -np.sign(size)
    return x + by * np.cumsum(turns)


def without_strays(recording: Recording) -> tuple[Recording, list[str]]:
    """The log with stray samples of position and force replaced by their neighbours' line."""
    notes = []
    found = strays(recording.position, leaps(recording))
    if len(found):
        off = _stand_out(recording, recording.position, found)
        recording = replace(recording, position=_bridged(recording.t, recording.position, found))
        notes.append(_strays_told(recording, "position", found, off))
    if recording.force is not None and len(found := force_strays(recording.force)):
        off = _stand_out(recording, recording.force, found)
        recording = replace(recording, force=_bridged(recording.t, recording.force, found))
        notes.append(_strays_told(recording, "force", found, off))
    return recording, notes


def _bridged(t: Array, y: Array, rows: NDArray[np.intp]) -> Array:
    kept = ~mask(len(y), rows)
    return np.where(kept, y, np.interp(t, t[kept], y[kept]))


def _stand_out(recording: Recording, y: Array, rows: NDArray[np.intp]) -> float:
    return float(np.median(np.abs(y - _bridged(recording.t, y, rows))[rows]))


def _strays_told(recording: Recording, name: str, rows: NDArray[np.intp], off: float) -> str:
    times = ", ".join(f"{s:.4g}" for s in recording.t[rows[:_LISTED]])
    times += ", ..." if len(rows) > _LISTED else ""
    several = f"{len(rows)} samples of {name} are" if len(rows) > 1 else f"1 sample of {name} is"
    return (
        f"{several} {shown_as(recording, name, off)} off their neighbours (at {times} s): replaced "
        "by straight lines"
    )


def without_wraps(recording: Recording) -> tuple[Recording, list[str]]:
    """The log with its position unwrapped, and its command by the same modulus, if certain."""
    found = leaps(recording)
    by = modulus(recording, found)
    if not by and recording.rotary:
        found = turns(recording)
        by = modulus(recording, found)
    if not by:
        return recording, []
    goal = recording.command
    if goal is not None:
        d = np.diff(goal)
        at = np.flatnonzero(np.abs(np.abs(d) - by) <= ALIKE * by)
        goal = unwrapped(goal, at, d[at], by)
    count = f"{len(found.at)} time{'s' * (len(found.at) != 1)}"
    first = recording.t[found.at[0] + 1]
    note = (
        f"position wraps {count} by {shown_as(recording, 'position', by)}, first at {first:.4g} s: "
        "unwrapped"
    )
    x = unwrapped(recording.position, found.at, found.size, by)
    return replace(recording, position=x, command=goal), [note]


def without_breaks(recording: Recording) -> tuple[Recording, list[str]]:
    """The longest piece of a log whose position breaks off, with its origin where it was.

    Beyond a reset or a jump the position no longer stands to the command as before: where there is
    a command, a piece that does counts, unless it is short beside the longest.
    """
    found = leaps(recording)
    if not 0 < len(found.at) <= PIECES:
        return recording, []
    first, pieces, origins = 0, [], [True]
    for k, i in enumerate(found.at.tolist()):
        kind = _kind(recording, found, k)
        stop = i + 1 - (_stood(recording.position, i) if kind == "frozen" else 0)
        pieces.append((first, max(stop, first)))
        origins.append(origins[-1] and kind in {"frozen", "missing rows"})
        first = i + 1
    pieces.append((first, len(recording)))
    a, b = max(pieces, key=_length)
    if recording.command is not None:
        right = [piece for piece, origin in zip(pieces, origins, strict=True) if origin]
        c, d = max(right, key=_length)
        a, b = (c, d) if d - c >= ORIGIN * (b - a) else (a, b)
    if b - a < FEWEST:
        return recording, []
    kept = recording.cut(slice(a, b))
    breaks = "; ".join(_break_told(recording, found, j) for j in range(len(found.at)))
    note = f"{breaks}: cut there, {kept.t[0]:.4g} to {kept.t[-1]:.4g} s kept"
    return kept, [note]


def _length(piece: tuple[int, int]) -> int:
    return piece[1] - piece[0]


def broken(recording: Recording) -> list[Fault]:
    """Leaps that could not be mended, one fault for all."""
    found = leaps(recording)
    if not len(found.at):
        return []
    rows = mask(len(recording), np.concatenate([found.at, found.at + 1]))
    size = float(np.abs(found.size).max())
    sentence = (
        f"position jumps {len(found.at)} times, by up to {shown_as(recording, 'position', size)}, "
        f"first at {recording.t[found.at[0] + 1]:.4g} s: give ranges of time between the jumps, or "
        "repair the log"
    )
    return [Fault("jump", "position", rows, size, sentence)]


def _break_told(recording: Recording, found: Leaps, k: int) -> str:
    i, size = int(found.at[k]), float(found.size[k])
    place = f"at {recording.t[i + 1]:.4g} s (sample {i + 2})"
    by = shown_as(recording, "position", abs(size))
    kind = _kind(recording, found, k)
    if kind == "reset":
        return f"position starts anew at 0 {place}, {by} off"
    if kind == "frozen":
        since = recording.t[i + 1 - _stood(recording.position, i)]
        return f"position stands still from {since:.4g} s until it jumps by {by} {place}"
    if kind == "missing rows":
        return f"position and command jump together by {by} {place}: rows are missing there"
    return f"position jumps by {by} {place}, further than any motion of the log goes in a sample"


def _kind(recording: Recording, found: Leaps, k: int) -> Kind:
    """What a leap looks like."""
    x, i, size = recording.position, int(found.at[k]), float(found.size[k])
    tolerance = found.tolerance + abs(found.speed[k]) * 2 * recording.dt
    if abs(x[i + 1]) <= tolerance and abs(x[i]) > 2 * tolerance:
        return "reset"
    if _stood(x, i) >= STOOD:
        return "frozen"
    goal = recording.command
    if goal is not None and abs((goal[i + 1] - goal[i]) - size) <= ALONG * abs(size):
        return "missing rows"
    return "jump"


def _stood(x: Array, i: int) -> int:
    """How many samples up to one have its value."""
    other = np.flatnonzero(x[: i + 1] != x[i])
    return i + 1 if not len(other) else i - int(other[-1])
