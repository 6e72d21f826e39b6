"""A free curve in a force balance: where its knots lie, and how smooth it is taken to be.

The prior of a curve is a normal distribution of its roughness (`Law.roughness`), of one standard
deviation for all rows. The data choose that: it is the one of the greatest restricted likelihood
(REML: Patterson and Thompson 1971, doi 10.1093/biomet/58.3.545), in which rows count as many as
are independent, times itself, which keeps it off zero, where few knots would have it by chance
(Chung et al. 2013, doi 10.1007/s11336-013-9328-2). Intervals are then those of the curve and its
prior together, which hold for the curve on average over its knots (Wahba 1983, doi
10.1111/j.2517-6161.1983.tb01239.x).
"""

from __future__ import annotations

import numpy as np

from ...friction import law_named
from ...friction.curve import FIRST, LAST, knots_of
from ...space import Array
from ..parameters import Parameters, partition
from ..uncertainty.covariance import quick_look
from . import variable_projection
from .regression import System

#: The first knot is at this quantile of the speeds, the last at the fastest; and the first is at
#: most at this share of the last.
_SLOWEST, _APART = 0.01, 0.5
#: Standard deviations of roughness that are tried, as shares of the greatest level: from a straight
#: line to none at all.
TRIED = np.geomspace(1e-5, 10.0, 121)
#: How far the nearest straight lines are off a curve at a knot, as a share of its roughness there.
CHORD = 1.0 / 6.0


def with_knots(system: System) -> System:
    """The balance with the knots of a free curve over the speeds of its rows.

    Knots that the user has set, or frees, stay.
    """
    parameters = system.parameters
    if parameters.law.roughness is None:
        return system
    speeds = np.abs(np.concatenate([log.pick(log.v) for log in system.logs]))
    fastest = float(speeds.max(initial=0.0))
    if not fastest > 0.0:
        return system
    slowest = float(np.quantile(speeds[speeds > 0.0], _SLOWEST))
    names = [q.name for q in parameters.every if _as_declared(parameters, q.name)]
    last = fastest if LAST in names else parameters.fixed.get(LAST, fastest)
    first = min(slowest, _APART * last) if FIRST in names else parameters.fixed.get(FIRST, 0.0)
    ends = {FIRST: first, LAST: max(last, first / _APART)}
    placed = {name: ends[name] for name in names}
    return System(parameters.holding(placed), system.logs) if placed else system


def of_free_curve(parameters: Parameters) -> Parameters | None:
    """Those of a free curve in place of a law, the rig's own as they are.

    None for a law that reads more than the speed, or that is a free curve itself.
    """
    law, rig = parameters.law, parameters.rig
    if not law.static or law.roughness is not None:
        return None
    own = {q.name for q in rig.own(law)}
    held = {name: value for name, value in parameters.fixed.items() if name in own}
    table = law_named("curve-directional" if law.directional else "curve")
    return partition(rig, table).holding(held)


def _as_declared(parameters: Parameters, name: str) -> bool:
    """Whether an end of the knots is where the law has it, which says nothing of the axis."""
    if name not in (FIRST, LAST):
        return False
    declared = next(q.fixed for q in parameters.law.params if q.name == name)
    return parameters.fixed.get(name) == declared


def with_prior(system: System) -> System:
    """The balance with rows for the roughness of its curve; itself where its law has none."""
    law = system.law
    if law.roughness is None:
        return system
    p, _ = system.solved()
    own = len(law.params) - sum(law.sizes)
    rows = np.zeros((len(law.roughness(p[:own])), len(p)))
    rows[:, :own] = law.roughness(p[:own])
    D = rows[:, system.linear]
    D = D[D.any(axis=1)]
    if not len(D):
        return system
    W, base = system.columns(p[system.shape])
    y = system.y - base
    r = y - W @ p[system.linear]
    variance = float(r @ r) / max(len(r) - W.shape[1], 1)
    if not variance > 0.0:
        return system
    levels = [i for i, place in enumerate(system.linear) if D[:, i].any()]
    look = quick_look(np.ascontiguousarray(W.T), r, [len(log.t) for log in system.logs])
    alike = float(np.mean(look.ratio[levels]))
    scale = float(np.abs(p[np.array(system.linear)[levels]]).max()) or 1.0
    roughness = restricted(W, y, D, variance * alike, scale)
    return System(system.parameters, system.logs, np.sqrt(variance) / roughness * D)


def chord_errors(system: System, p: Array) -> Array:
    """What straight lines between knots leave of a curve, as errors of its levels, (k,).

    The straight lines nearest to a parabola, from knot to knot, miss it at the knots by a sixth of
    what these lie off the chord of their neighbours. The ends, which have no two neighbours, have
    the error of the knot beside them.
    """
    errors = np.zeros(len(p))
    law = system.law
    if law.roughness is None:
        return errors
    own = p[: len(law.params) - sum(law.sizes)]
    rows = law.roughness(own)
    n = len(knots_of(law, p))
    for table, rough in enumerate(np.split(np.abs(rows @ own), len(rows) // (n - 2))):
        errors[table * n : (table + 1) * n] = CHORD * np.concatenate([rough[:1], rough, rough[-1:]])
    return errors


def restricted(W: Array, y: Array, D: Array, variance: float, scale: float) -> float:
    """The standard deviation of D x of the greatest likelihood of y = W x + noise, times itself.

    Args:
        W: (rows, k).
        y: (rows,).
        D: Roughness, (m, k).
        variance: Of the noise of a row, as if rows were independent.
        scale: Of D x.
    """
    lengths = np.linalg.norm(W, axis=0)
    lengths[lengths == 0] = 1.0
    T = variable_projection.triangle(np.column_stack([W / lengths, y])) / np.sqrt(variance)
    R, z, D = T[:-1, :-1], T[:-1, -1], D / lengths
    costs = []
    for tau in scale * TRIED:
        stacked = np.column_stack([np.vstack([R, D / tau]), np.append(z, np.zeros(len(D)))])
        U = np.abs(np.diag(np.linalg.qr(stacked, mode="r")))
        seen = U[:-1] > np.finfo(float).eps * U[:-1].max()
        logs = 2.0 * float(np.sum(np.log(U[:-1][seen]))) + 2.0 * len(D) * float(np.log(tau))
        costs.append(logs + float(U[-1]) ** 2 - 2.0 * float(np.log(tau)))
    return float(scale * TRIED[int(np.argmin(costs))])
