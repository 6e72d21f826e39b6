"""The way of an axis of two masses from one sample to the next: steps between events.

Between events the rates are smooth: steps are those of Dormand and Prince (1980, doi
10.1016/0771-050X(80)90013-3), of order 5 with an error of order 4, and as long as the tolerance
allows. Under laws with states, which are stiff, they are implicit (`coupled_implicit`). A step that
ends beyond an event, or has a stage beyond one, is taken again, shorter: the straight line through
what is left to the event tells how much, and twice as much is tried where it fell short, so that
the event is enclosed in a share SHARP of a whole step. It happens at the end of that.

A side that slides stops where its velocity is zero: it sticks, if the force is not beyond its
breakaway level, and else it goes on, forward or backward. A side that sticks breaks away where the
force passes that level. The coupling leaves its flank where its force falls to zero, with the
twist that its damper leaves in the spring.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ...compile_cache import compiled
from ...compile_cache.copies import copy_into
from ...friction.law import DRIVE, EXTERNAL
from ...space import Array
from .coupled_implicit import FURTHER, POWER, implicit_step
from .coupled_rates import (
    EVENTS,
    FLANK,
    FRICTION,
    LOAD,
    LOAD_STATES,
    MOTOR,
    MOTOR_STATES,
    Q_M,
    STATE,
    V_M,
    Q,
    V,
    coupled_rates,
    twist_left,
)
from .coupling import FREE, PLAY
from .drive_force import mixed

#: Rows of the room that a passage needs.
ROWS = FURTHER + 4
#: Stages of a step.
STAGES = 7
#: An event is enclosed in this share of the longest step.
SHARP = 1e-7
#: The error after which a step is no longer and no shorter, as a share of the tolerance, and how
#: much of what would give that it is, and by how much it may grow or shrink.
AIM, SAFE, GROW, SHRINK = 0.5, 0.9, 5.0, 0.2
#: Beyond which a motion has run away, m or rad, and per second.
FAR = 1e12
#: What is left of an interval that is none, as a share.
_NONE = 1e-12

#: Nodes, weights of the stages, and weights of the error (order 5 less order 4).
_NODES = np.array([0.0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1.0, 1.0])
_WEIGHTS = np.array(
    [
        [0, 0, 0, 0, 0, 0],
        [1 / 5, 0, 0, 0, 0, 0],
        [3 / 40, 9 / 40, 0, 0, 0, 0],
        [44 / 45, -56 / 15, 32 / 9, 0, 0, 0],
        [19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729, 0, 0],
        [9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656, 0],
        [35 / 384, 0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84],
    ]
)
_ERROR = np.array(
    [71 / 57600, 0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40]
)  # fmt: skip


@compiled()
def _stepped(  # noqa: C901 - the stages of one method
    slip_m: Any, rub_m: Any, p_m: Array, term_m: Array, slip: Any, rub: Any, p: Array,
    term: Array, c: Array, inputs: Array, held: Array, k: int,
    begin: float, share: float, h: float, y: Array, twist: float, mode: Array, u: Array,
    load_m: Array, load: Array, rates: Array, at: Array, g: Array,
) -> tuple[float, float]:  # fmt: skip
    """A step of h seconds, the share of an interval: its error, and which stage.

    The state after it goes into `at`, the distances from events there into `g`; `rates` (7, 4)
    begins with those at the start and ends with those at the end. The stage is the node of the
    first one, but the last, at which an event is past; 2 where none is.
    """
    early, none = 2.0, at[:0]
    for i in range(1, STAGES):
        for m in range(STATE):
            total = 0.0
            for j in range(i):
                total += _WEIGHTS[i, j] * rates[j, m]
            at[m] = y[m] + h * total
        if i != STAGES - 1:  # the last two are at the same instant
            mixed(inputs, held, k, begin + _NODES[i] * share, u)
        left = twist_left(c, mode[FLANK], twist, _NODES[i] * h)
        coupled_rates(
            slip_m, rub_m, p_m, term_m, slip, rub, p, term, c, u, at, left,
            mode, load_m, load, none, none, 0.0, none, none, rates[i], g,
        )  # fmt: skip
        if i < STAGES - 2 and early > 1.0:
            # A velocity may pass zero and come back; a level or a flank is not to be passed.
            for e in range(EVENTS):
                if g[e] > 0.0 and (e == 2 or mode[e] == 0):  # noqa: PLR2004 - the coupling's
                    early = _NODES[i]
    error_q, error_v = 0.0, 0.0
    for m in range(STATE):
        total = 0.0
        for j in range(STAGES):
            total += _ERROR[j] * rates[j, m]
        if m in (Q_M, Q):
            error_q += abs(h * total)
        else:
            error_v += abs(h * total)
    return error_q + h * error_v, early


@compiled(forceinline=True)
def _towards(
    before: Array, beyond: Array, ahead: float, fell_short: bool, looks: int, sharp: float
) -> float:
    """The step towards an event that is past after a step of `ahead`, as a share.

    Args:
        before: Distances from events now.
        beyond: The same after `ahead`.
        ahead: As a share of the interval.
        fell_short: Whether the step before ended short of the event.
        looks: For it so far.
        sharp: The least step.
    """
    if ahead <= sharp:
        return ahead
    if looks % 4 == 3:  # noqa: PLR2004 - halved at least that often
        return 0.5 * ahead
    near = ahead
    for e in range(EVENTS):
        if beyond[e] > 0.0:
            near = min(
                near, ahead * before[e] / (before[e] - beyond[e]) if before[e] < 0.0 else 0.0
            )
    if fell_short:
        near *= 2.0
    return min(near + 0.5 * sharp, ahead)


@compiled(forceinline=True)
def _switched(c: Array, y: Array, twist: float, mode: Array, g: Array) -> float:
    """The modes after the events that are past; the twist left in the spring."""
    if g[2] > 0.0:
        ahead = y[Q_M] - y[Q]
        half = 0.5 * c[PLAY]
        if mode[FLANK] == FREE:
            mode[FLANK] = 1 if ahead - twist > 0.0 else -1
        else:
            twist = ahead - mode[FLANK] * half
            mode[FLANK] = FREE
    for side in (MOTOR, LOAD):
        if g[side] > 0.0 and mode[side] != 0:
            mode[side] = 0
            y[V_M if side == MOTOR else V] = 0.0
    return twist


@compiled(forceinline=True)
def _pulled(load: Array) -> int:
    """Which way the force on a side at rest pulls."""
    return 1 if load[DRIVE] + load[EXTERNAL] - load[FRICTION] > 0.0 else -1


@compiled(forceinline=True)
def _past(g: Array) -> bool:
    """Whether an event is past."""
    for e in range(EVENTS):  # noqa: SIM110 - compiled
        if g[e] > 0.0:
            return True
    return False


@compiled(forceinline=True)
def near(y: Array) -> bool:
    """Whether a state has not run away."""
    for m in range(len(y)):  # noqa: SIM110 - compiled
        if not abs(y[m]) < FAR:
            return False
    return True


@compiled(inline="always")
def _begin(
    slip_m: Any, rub_m: Any, p_m: Array, term_m: Array, slip: Any, rub: Any, p: Array,
    term: Array, c: Array, u: Array, y: Array, twist: float, mode: Array, load_m: Array,
    load: Array, out: Array, rates: Array, before: Array,
) -> None:  # fmt: skip
    """The rates and the distances from events where modes may be new: what can, breaks away."""
    own = STATE + mode[MOTOR_STATES]
    for _ in range(2):  # under its modes as they are, and as they are then
        coupled_rates(
            slip_m, rub_m, p_m, term_m, slip, rub, p, term, c, u, y, twist, mode, load_m, load,
            y[STATE:own], y[own:], 0.0, out[STATE:own], out[own:], rates[0], before,
        )  # fmt: skip
        stays = True
        if mode[MOTOR] == 0 and before[MOTOR] > 0.0:
            mode[MOTOR], stays = _pulled(load_m), False
        if mode[LOAD] == 0 and before[LOAD] > 0.0:
            mode[LOAD], stays = _pulled(load), False
        if stays:
            return


@compiled(inline="always")
def coupled_passage(  # noqa: C901, PLR0912, PLR0915 - one loop of many cases
    slip_m: Any, rub_m: Any, p_m: Array, term_m: Array, slip: Any, rub: Any, p: Array,
    term: Array, c: Array, inputs: Array, held: Array, k: int, n: int, span: float,
    tolerance: float, y: Array, twist: float, mode: Array, u: Array, load_m: Array, load: Array,
    rates: Array, room: Array, memory: Array, piece: float, steps_left: int,
) -> tuple[float, float, int]:  # fmt: skip
    """From sample k to the next: the twist, the last whole step as a share, and steps still left.

    The state goes on in `y`, positions and velocities before the states of the motor's law and of
    the load's, the modes in `mode`. No step is longer than an nth of the interval. Where no steps
    are left, the state is nan. `room`, (ROWS, states), and `memory` are those of `implicit_step`.
    """
    done, longest, ahead, fell_short, looks, fresh = 0.0, 1.0 / n, np.inf, False, 0, True
    power, bristled = POWER, mode[MOTOR_STATES] + mode[LOAD_STATES] > 0
    at, g = room[FURTHER], room[FURTHER + 1, :EVENTS]
    before, beyond = room[FURTHER + 2, :EVENTS], room[FURTHER + 3, :EVENTS]
    while done < 1.0 - _NONE:
        if steps_left <= 0:
            y[:] = np.nan
            return twist, piece, 0
        steps_left -= 1
        if fresh:
            mixed(inputs, held, k, done, u)
            _begin(
                slip_m, rub_m, p_m, term_m, slip, rub, p, term, c, u, y, twist,
                mode, load_m, load, at, rates, before,
            )  # fmt: skip
            fresh = False
        if ahead < np.inf:
            share = _towards(before, beyond, ahead, fell_short, looks, SHARP * longest)
            looks += 1
        else:
            share = min(piece, longest, 1.0 - done)
        if bristled:
            error, early, power = implicit_step(
                slip_m, rub_m, p_m, term_m, slip, rub, p, term, c, inputs, held,
                k, done, share, share * span, y, twist, mode, u, load_m, load, rates, at, g, room,
                memory,
            )  # fmt: skip
        else:
            error, early = _stepped(
                slip_m, rub_m, p_m, term_m, slip, rub, p, term, c, inputs, held, k,
                done, share, share * span, y, twist, mode, u, load_m, load, rates, at, g,
            )  # fmt: skip
        error *= longest / share  # of a whole step
        sharp = share <= SHARP * longest
        if not error <= tolerance and not sharp:
            fraction = SHRINK
            if error < np.inf:
                fraction = max(SHRINK, SAFE * (AIM * tolerance / error) ** power)
            piece, ahead, fell_short, looks = fraction * share, np.inf, False, 0
            continue
        past = _past(g)
        if past and not sharp:
            ahead, fell_short = share, False
            copy_into(beyond, g)
            continue
        if early < 1.0 and not past and not sharp:
            piece = early * share
            continue
        copy_into(y, at)
        twist = twist_left(c, mode[FLANK], twist, share * span)
        done += share
        if not near(y):
            y[:] = np.nan
            return twist, piece, steps_left
        if past:
            twist = _switched(c, y, twist, mode, g)
            fresh, ahead, fell_short, looks = True, np.inf, False, 0
            continue
        copy_into(rates[0], rates[STAGES - 1])
        copy_into(before, g)
        fell_short = True
        if share < ahead < np.inf:
            ahead -= share
        elif ahead < np.inf:  # the event is not there, to rounding
            ahead, looks = np.inf, 0
        else:
            growth = SAFE * (AIM * tolerance / max(error, 1e-300)) ** power
            piece = share * min(GROW, max(SHRINK, growth))
    return twist, piece, steps_left
