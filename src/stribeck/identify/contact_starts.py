"""Where a search begins that knows where: at a force balance, or where friction holds nothing.

On an axis that nothing but a measured force pushes, the same law along the measured motion explains
that force (`balance`): linear in its levels and found in seconds without a simulation, but biased
by the noise of positions, which the simulated motion is not.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ..errors import InputError
from ..rig.lookup import rig_named
from ..rig.simulated import as_simulated
from ..space import Array, Rng, Space
from .segment import recordings_of

if TYPE_CHECKING:
    from .parameters import Parameters
    from .segment import Segment

#: Starts that are drawn, and by how much they scatter about what the balance shows, as shares of
#: the search ranges.
STARTS, SCATTER = 8, 0.05
#: Starts with less and less friction, each a tenth of the one before.
DECADES = 8
#: A value so near an end of its range, as a share of it, has been stopped there.
_END = 1e-3


def contact_sets(parameters: Parameters, train: tuple[Segment, ...]) -> Array | None:
    """Sets in the unit cube of the free parameters, (n, dim), the balance's first.

    None where the axis is another, the law says nothing of where it may be found, or the logs show
    no friction.
    """
    rig, law = as_simulated(parameters.rig), parameters.law
    if not rig.only_pushed or law.starts is None or law.terms or rig.drive_chain is not None:
        return None
    from .balance.balance import balance  # noqa: PLC0415 - compiled code that others need not load
    from .balance.state_starts import state_starts  # noqa: PLC0415 - as above

    balanced = rig_named("forced-rotary" if rig.rotary else "forced")
    if [q.name for q in balanced.parameters(law)] != [q.name for q in parameters.every]:
        return None
    logs = recordings_of(train)
    rows = [np.zeros(len(log), dtype=bool) for log in logs]
    for s in train:
        rows[next(i for i, log in enumerate(logs) if log is s.recording)][s.rows] = True
    try:
        answer = balance(logs, replace(parameters, rig=balanced), rows=rows)
        near = state_starts(answer.system)
    except InputError:
        return None
    sets = answer.values[None] if near is None else np.vstack([answer.values, near])
    own = len(law.params)
    sets[1:, own:] = answer.values[own:]
    x = parameters.clipped(sets)[:, parameters.free_places]
    return np.clip(Space(parameters.free).encode(x), 0.0, 1.0)


def scattered(sets: Array, rng: Rng) -> Array:
    """Sets and others that scatter about them, (STARTS, dim); what an end has stopped is drawn.

    Args:
        sets: In the unit cube, (n, dim).
        rng: What draws.
    """
    sets = sets[:STARTS]
    more = sets[np.arange(STARTS - len(sets)) % len(sets)]
    stopped = (more < _END) | (more > 1.0 - _END)
    near = more + SCATTER * rng.standard_normal(more.shape)
    drawn = np.where(stopped, rng.random(more.shape), near)
    return np.vstack([sets, np.clip(drawn, 0.0, 1.0)])


def little_friction(parameters: Parameters) -> Callable[[Rng], Array]:
    """What draws sets in the unit cube, (DECADES, dim), of an axis that friction does not hold.

    Ranges of friction that fit any axis begin at zero and end far above what a small one's drive
    can overcome: nearly all of their middle never moves, and nothing there says which way is
    better.

    Args:
        parameters: Free ones of a law and its axis.
    """
    law = {q.name for q in parameters.law.params}
    levels = np.array([q.name in law and not q.log and q.lower == 0.0 for q in parameters.free])

    def drawn(rng: Rng) -> Array:
        sets = rng.random((DECADES, len(levels)))
        shares = 10.0 ** -np.arange(1.0, DECADES + 1.0)
        sets[:, levels] *= shares[:, None]
        return sets

    return drawn
