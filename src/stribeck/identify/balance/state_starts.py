"""Where the search for a law with states begins: the spectrum of the contact, read off the logs."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from ...errors import InputError
from ...friction.yield_spectrum import Spectrum
from ...rig.measured_path import elements_along
from ...space import Array, Param
from . import variable_projection

if TYPE_CHECKING:
    from ...data.zero_phase import Samples
    from ..parameters import Parameters
    from .regression import System
    from .rows import Log

#: Yield displacements of a spectrum: so many to a decade, down to this share of the longest stroke.
_TO_A_DECADE, _LEAST_SHARE = 4, 1e-6
#: Levels below this share of all are none.
_NONE = 1e-3
#: A share of the force, root mean square, above which a spectrum explains nothing.
_UNEXPLAINED = 0.98
#: No level of friction is above this many times the greatest force.
_TIMES = 3.0
#: Quantiles of the speeds at which a level may drop.
_QUANTILES = (0.2, 0.5, 0.8)
#: Speeds below this share of the greatest one are no sliding.
_REST = 1e-3


def state_starts(system: System) -> Array | None:
    """Complete sets, SI, (n, k), near the best one; None for a law that says nothing of it.

    Raises:
        InputError: the motion shows no friction.
    """
    law, parameters = system.law, system.parameters
    if law.starts is None or not law.states:
        return None
    own = law.starts(contact_spectrum(system))
    sets = np.tile(parameters.full(parameters.middle[None])[0], (len(own), 1))
    sets[:, : own.shape[1]] = own
    return parameters.full(parameters.clipped(sets)[:, parameters.free_places])


def within_force(system: System) -> Parameters:
    """The parameters, levels that shape the friction within a few times the measured force."""
    parameters = system.parameters
    greatest = max(float(np.abs(log.raw).max()) for log in system.logs)
    shape = {parameters.every[i].name for i in system.shape} - parameters.bounded

    def within(q: Param) -> Param:
        level = q.name in shape and q.unit == system.rig.si_unit("force") and not q.log
        return replace(q, upper=min(q.upper, _TIMES * greatest)) if level else q

    return replace(
        parameters,
        every=tuple(map(within, parameters.every)),
        free=tuple(map(within, parameters.free)),
    )


def contact_spectrum(system: System) -> Spectrum:
    """The spectrum that logs show, with mass, offset and viscous friction beside it.

    Raises:
        InputError: the motion never reverses, or shows no friction.
    """
    from scipy.optimize import nnls  # noqa: PLC0415 - slow to import

    if not any(log.path is not None and log.path.reverses for log in system.logs):
        raise InputError(
            f"{system.logs[0].label}: the motion never turns back by more than its position may be "
            f"off: law {system.law.name} takes reversals, slow ones among them"
        )
    yields = _yields(system)
    parts = []
    for log in system.logs:
        if log.path is not None:
            shares = elements_along(log.path.way, log.path.starts, yields)
            parts.append(log.thin(partial(_columns, log, shares)))
    W = np.concatenate(parts)
    lengths = np.linalg.norm(W, axis=0)
    lengths[lengths == 0] = 1.0
    T = variable_projection.triangle(np.column_stack([W / lengths, system.y]))
    x, unexplained = nnls(T[:-1, :-1], T[:-1, -1])
    levels = (x / lengths)[: len(yields)]
    levels[levels < _NONE * levels.sum()] = 0.0
    varying = system.y - system.y.mean()
    left = float(np.hypot(unexplained, T[-1, -1]))
    if not levels.any() or left > _UNEXPLAINED * float(np.linalg.norm(varying)):
        raise InputError(
            f"{system.logs[0].label}: the force does not go with the motion as friction and "
            "inertia do: check the signs, units and clocks of both"
        )
    v = np.abs(np.concatenate([log.pick(log.v) for log in system.logs]))
    v = v[v > _REST * v.max()]
    return Spectrum(yields, levels, np.quantile(v, _QUANTILES))


def _yields(system: System) -> Array:
    """Displacements from what the sensor may be off up to the longest way without a reversal."""
    least = min(float(log.path.error) for log in system.logs if log.path is not None)
    most = max(float(np.ptp(log.position[:])) for log in system.logs)
    least = max(least, _LEAST_SHARE * most)
    n = max(int(np.ceil(_TO_A_DECADE * np.log10(most / least))), 1) + 1
    return np.geomspace(least, most, n)


def _columns(log: Log, shares: Array, at: Samples) -> Array:
    """Elements, viscous friction, mass, and an offset both ways."""
    one = np.ones(len(shares[at]))
    return np.column_stack([shares[at], log.v[at], log.a[at], one, -one])
