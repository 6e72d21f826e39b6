"""Blind directions: combinations of parameters that the data hardly determine, in words.

Which parameter leads one is read off the slopes: the eigenvectors of their curvature, for relative
changes, that noise hides. What is reported is read off its profile, where the others were
refitted: a valley of the misfit is curved, and a straight way leaves it soon.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...space import Array, Space
from ...units import percent
from .profile import Profile, Profiles

#: The move that is reported is the least of at least this, relative, that a profile has visited.
MOVE = 0.1
#: Greatest relative rise of the misfit that people would not notice.
UNSEEN = 0.01
#: Components below this share of the largest one are not reported.
SMALL = 0.1
#: A value smaller than this share of its range is moved by shares of the range.
NOUGHT = 1e-3


@dataclass(frozen=True, eq=False)
class Direction:
    """A joint move of parameters that the data do not notice.

    Args:
        names: The parameters that move, the one that leads first, then by size.
        changes: By how much, relative to the value (to the range, where the value is near 0).
        misfit: Relative change of the misfit, a root mean square, at the end of the move.
    """

    names: tuple[str, ...]
    changes: tuple[float, ...]
    misfit: float

    def text(self, labels: Sequence[str] | None = None, misfit: str = "J") -> str:
        """The direction as a sentence, the parameters by other names if given."""
        moves = [
            f"{n} {'+' if c > 0 else '−'}{percent(abs(c))}"
            for n, c in zip(labels or self.names, self.changes, strict=True)
        ]
        changes = f"changes {misfit} by {percent(abs(self.misfit))}"
        if len(moves) == 1:
            return f"{moves[0]} {changes}: the data hardly see it"
        return (
            f"{moves[0]} together with {', '.join(moves[1:])} {changes}: "
            "only their combination is known"
        )


def directions(space: Space, profiles: Profiles) -> tuple[Direction, ...]:
    """The joint moves of the parameters profiled that the data do not notice, weakest first.

    Args:
        space: Of the problem.
        profiles: Its profiles.
    """
    x, width = profiles.x, space.upper - space.lower
    scale = np.where(np.abs(x) < NOUGHT * width, width, np.abs(x))
    rows = [space.names.index(p.name) for p in profiles.profiles]
    values, vectors = _curvature(space, profiles, scale, rows)
    hidden_moves: list[Direction] = []
    led: set[int] = set()
    for value, vector in zip(values, vectors.T, strict=True):
        leader = int(np.argmax(np.abs(vector)))
        hidden = value * (MOVE / abs(vector[leader])) ** 2 < profiles.profiles[leader].threshold
        if not hidden or leader in led:
            continue
        led.add(leader)
        move = _move(profiles.profiles[leader], x, scale, rows, leader)
        if move is not None and move[1] <= ((1 + UNSEEN) ** 2 - 1) * profiles.squares:
            changes, rise = move
            order = [leader, *(int(i) for i in np.argsort(-np.abs(changes), kind="stable"))]
            least = SMALL * abs(changes[leader])
            keep = [i for i in dict.fromkeys(order) if i == leader or abs(changes[i]) >= least]
            worse = rise / profiles.squares if profiles.squares > 0 else 0.0
            hidden_moves.append(
                Direction(
                    tuple(space.names[rows[i]] for i in keep),
                    tuple(float(changes[i]) for i in keep),
                    float(np.sqrt(1 + worse) - 1),
                )
            )
    return tuple(hidden_moves)


def _curvature(
    space: Space, profiles: Profiles, scale: Array, rows: Sequence[int]
) -> tuple[Array, Array]:
    """Eigenvalues and vectors of the curvature for relative changes of the parameters profiled.

    The others follow at their best: the Schur complement takes them out.
    """
    forward = space.encode(profiles.x[None] + np.diag(1e-7 * (space.upper - space.lower)))
    backward = space.encode(profiles.x[None] - np.diag(1e-7 * (space.upper - space.lower)))
    step = space.decode(forward) - space.decode(backward)
    dudx = np.diag(forward - backward) / np.diag(step)
    J = profiles.J * (dudx * scale)[:, None]
    A = np.einsum("im,jm->ij", J, J)
    others = [i for i in range(space.dim) if i not in rows]
    inner = A[np.ix_(rows, rows)]
    if others:
        across = A[np.ix_(others, rows)]
        inner = inner - across.T @ np.linalg.pinv(A[np.ix_(others, others)], rcond=1e-12) @ across
    values, vectors = np.linalg.eigh(inner)
    return np.maximum(values, 0.0), vectors


def _move(
    profile: Profile, x: Array, scale: Array, rows: Sequence[int], leader: int
) -> tuple[Array, float] | None:
    """Relative changes at a place of the leader's profile that noise explains, and the rise there.

    The place with the least move of at least MOVE; None if there is none.
    """
    changes = ((profile.places - x) / scale)[:, rows]
    moves = np.abs(changes[:, leader])
    hidden = np.flatnonzero((profile.rises <= 1.1) & (moves >= MOVE))  # noqa: PLR2004 - ends
    if not len(hidden):
        return None
    best = hidden[np.argmin(moves[hidden])]
    return changes[best], float(profile.rises[best]) * profile.threshold
