"""Check vectors of a translation: inputs, and the values of law and compensator for them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...compensate.compensator import Compensator, compensator_output
from ...errors import InputError
from ...friction import LOADS
from ...friction.law import term_places, terms_factor
from ...space import Array
from ..model import Model

#: Shares of rows in which the axis rests, and in which it moves as its reference does.
_RESTING, _FOLLOWING = 0.1, 0.5
#: Rows of a self-test, and the sample time at which it walks, s.
ROWS, STEP = 256, 1e-3


class CheckVectors(NamedTuple):
    """A walk, row by row from relaxed states.

    Args:
        inputs: Velocity, velocity of the reference, sample time, (n, 3), SI.
        loads: As laws read them, (n, 5).
        forces: What the law says, N or N m, (n,).
        outputs: What the compensator puts out, N or N m, (n,).
        floor: A force beside which rounding is not looked at, N or N m.
    """

    inputs: Array
    loads: Array
    forces: Array
    outputs: Array
    floor: float


def check_vectors(
    model: Model, compensator: Compensator, rows: int = ROWS, seed: int = 0
) -> CheckVectors:
    """Rest, creeping, reversals and speeds as they were seen, in an order that a seed decides."""
    rng = np.random.default_rng(seed)
    low, high = model.speeds or (-1.0, 1.0)
    fast = max(abs(low), abs(high)) or 1.0
    v = fast * rng.choice([-1.0, 1.0], rows) * 10.0 ** rng.uniform(-5.0, 0.0, rows)
    v[rng.random(rows) < _RESTING] = 0.0
    v_ref = np.where(rng.random(rows) < _FOLLOWING, v, fast * rng.uniform(-1.0, 1.0, rows))
    h = STEP * 10.0 ** rng.uniform(-1.0, 1.0, rows)
    loads = rng.uniform(-1.0, 1.0, (rows, len(LOADS))) * _sizes(model)
    loads[:, LOADS.index("temperature")] = rng.uniform(270.0, 340.0, rows)
    return walk(model, compensator, np.column_stack([v, v_ref, h]), loads)


def walk(model: Model, compensator: Compensator, inputs: Array, loads: Array) -> CheckVectors:
    """What the library itself says to given inputs, (n, 3), and loads, (n, 5)."""
    law, p, c = model.law, model.p, compensator.c
    n = max(law.states, 1)
    z, out, states, next_states = np.zeros((4, n))
    rub, before = law.rub if law.rub is not None else law.slip, 0.0
    forces, outputs = np.empty(len(inputs)), np.empty(len(inputs))
    for k, ((v, v_ref, h), load) in enumerate(zip(inputs, loads, strict=True)):
        factor = scale(model, load)
        if law.rub is None:
            forces[k] = factor * law.slip(v, p)
        else:
            forces[k] = factor * rub(v, h, z[: law.states], load, p, out[: law.states])
            z, out = out, z
        before = outputs[k] = compensator_output.py_func(
            law.slip, rub, law.rub is not None, law.states, factor, v_ref, v, h, before,
            states[: law.states], load, p, c, next_states[: law.states],
        )  # fmt: skip
        states, next_states = next_states, states
    if not (np.isfinite(forces).all() and np.isfinite(outputs).all()):
        raise InputError(
            f"{model.source}: law {law.name} gives no finite friction at its values and speeds: "
            "look for a parameter that is far too large or too small"
        )
    floor = 1e-3 * float(np.abs(forces).max())
    return CheckVectors(inputs, loads, forces, outputs, floor)


def scale(model: Model, load: Array) -> float:
    """What the law's terms multiply its friction by under a load, (5,)."""
    return float(terms_factor.py_func(term_places(model.law), model.p, load))


def _sizes(model: Model) -> Array:
    """How large loads are: some times the law's own level, and a turn of the position."""
    level = max(abs(x) for x in model.law.levels(model.p)) or 1.0
    return np.array([5.0 * level, 5.0 * level, 5.0 * level, 1.0, 0.0])
