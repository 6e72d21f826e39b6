"""Waves over position in the residual of a force balance: where the search of their period starts.

A period has as many local minima as the travel has periods. So the residual of the law without its
terms over position is regressed on waves of every period that the travel and the speeds can show:
a periodogram over position (Lomb 1976, doi 10.1007/BF00648343), of uneven samples, with all
harmonics at once. The best period and the amplitudes there are where the search starts.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ...data.filtering import DECIMATION_GAIN
from ...friction.law import HARMONIC
from ...space import Array, Param
from .modelled_force import friction_signal
from .regression import System

if TYPE_CHECKING:
    from collections.abc import Mapping

#: Rows that a periodogram looks at, and periods that it tries at most.
_ROWS, _PERIODS = 2_000, 4_000
#: Periods are apart by this share of a wave over the whole travel.
_APART = 0.2
#: The shortest period that explains nearly as much as the best one is it: twice the period with
#: twice the harmonics explains all that the period does.
_NEARLY = 0.95


def wave_start(system: System) -> Array | None:
    """A complete set, SI, near the best one, of a law with terms over position; else None."""
    law, names = system.law, system.parameters.names
    places = {t: law.place(t) for t in HARMONIC if t in law.terms}
    free = set(system.free)
    if not any(i in free for place in places.values() for i in range(place.start, place.stop)):
        return None
    parameters = system.parameters
    held = {
        names[i]: 0.0 if i < place.stop - 1 else _middle(parameters.every[i], parameters.fixed)
        for place in places.values()
        for i in range(place.start, place.stop)
    }
    left = tuple(q for q in parameters.free if q.name not in held)
    if not left:
        return None
    plain = replace(parameters, free=left, fixed=dict(parameters.fixed) | held)
    base = System(plain, system.logs)
    p, _ = base.solved()
    every = max(len(base.y) // _ROWS, 1)
    W = base.jacobian(p)[::every]
    Q = np.linalg.qr(W / np.maximum(np.linalg.norm(W, axis=0), np.finfo(float).tiny))[0]
    r = (base.y - base.predicted(p[None])[:, 0])[::every]
    x = np.concatenate([log.pick(log.position) for log in base.logs])[::every]
    gains = [np.full(len(log.t), 1 if log.factor == 1 else DECIMATION_GAIN) for log in base.logs]
    size = np.concatenate(gains)[::every]
    for term, place in places.items():
        amplitude = size
        if term == "position":
            rub = np.concatenate([
                friction_signal(base.rig, law, log, p)(log.places) for log in base.logs
            ])  # fmt: skip
            amplitude = size * rub[::every]
        last = place.stop - 1
        periods = np.array([parameters.fixed.get(names[last], np.nan)])
        if last in free:
            periods = _periods(base, x, parameters.every[last])
        harmonics = (place.stop - place.start) // 2
        gain = np.array([_explained(_columns(x, q, harmonics, amplitude), Q, r) for q in periods])
        best = periods[_shortest(gain)]
        columns = _columns(x, best, harmonics, amplitude)
        free_columns = columns - Q @ (Q.T @ columns)
        coefficients = np.linalg.lstsq(free_columns, r, rcond=None)[0]
        p[place.start : last], p[last] = coefficients, best
        r = r - free_columns @ coefficients
    for i in free:
        p[i] = min(max(p[i], parameters.every[i].lower), parameters.every[i].upper)
    return p


def _middle(period: Param, fixed: Mapping[str, float]) -> float:
    return fixed.get(period.name, float(np.sqrt(period.lower * period.upper)))


def _periods(system: System, x: Array, period: Param) -> Array:
    """The periods to try, the longest first: from the whole travel down to what filters leave."""
    travel = float(np.ptp(x))
    rate = min((len(log) - 1) / float(log.clock[-1] - log.clock[0]) for log in system.logs)
    v = np.abs(np.concatenate([log.pick(log.v) for log in system.logs]))
    slow = float(np.quantile(v[v > 0], 0.25)) if (v > 0).any() else 1.0
    shortest = max(slow / system.rig.filtering.cutoff(rate), period.lower)
    least = 1 / min(travel, period.upper)
    most = max(1 / shortest, least)
    n = int(np.clip((most - least) * travel / _APART, 1, _PERIODS)) + 1
    waves: Array = 1 / np.linspace(least, min(most, least + n * _APART / travel), n)
    return waves


def _columns(x: Array, period: float, harmonics: int, amplitude: Array) -> Array:
    """Cosine and sine of each harmonic, times what they multiply, (rows, 2 harmonics)."""
    turn = 2 * np.pi * x / period
    waves = [f(k * turn) for k in range(1, harmonics + 1) for f in (np.cos, np.sin)]
    return np.column_stack(waves) * amplitude[:, None]


def _explained(columns: Array, Q: Array, r: Array) -> float:
    """By how much the sum of squares of r falls, beside what Q spans, (rows, k)."""
    free = columns - Q @ (Q.T @ columns)
    solved, *_ = np.linalg.lstsq(free.T @ free, free.T @ r, rcond=1e-9)
    return float(solved @ (free.T @ r))


def _shortest(gain: Array) -> int:
    """The last local maximum that explains nearly as much as the greatest."""
    around = np.concatenate([[-np.inf], gain, [-np.inf]])
    peaks = (gain >= around[:-2]) & (gain >= around[2:]) & (gain >= _NEARLY * gain.max())
    return int(np.flatnonzero(peaks)[-1])
