"""A step of two masses under laws with states: implicit in the velocities of both.

The velocities w_m and w of motor and load at the share θ of a step of h seconds solve

    w_m = v_m + θh a_m,    w = v + θh a,

a_m and a the accelerations (`coupled_rates`) at the positions q + θh w, the velocities w, the
inputs at that instant and under friction F_f(w, z after θh); then

    v' = v + (w − v) / θ,    q' = q + h w,    z' = z after h at the velocity w.

It is the rule of `passage` for one mass, with its θ = 1/2 + 0.003 y⁴, y the angle by which bristles
or the coupling swing in the step, and θ = 1 where velocities decay within it. One step and two of
half the length are extrapolated, to order 4 (order 2 with θ = 1), and Simpson's rule with the
accelerations at the start, the middle and the end tells the error.

Both velocities are found at once by Newton's method with the slopes of drive and coupling, and of
each side's friction by a secant: friction of one side depends on its velocity alone. A step of
which they do not come out is tried again, shorter: the shorter, the more inertia alone decides.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ...compile_cache import compiled
from ...space import Array
from .axis_row import DAMP, STIFF
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
from .coupling import FREE, LOAD_ROW, MOTOR_ROW, coupling_constants
from .drive_force import mixed
from .passage import STIFF as STIFF_DECAY
from .passage import SWING

#: Where `memory` keeps of each side how steeply its friction rose in half a step and in a whole
#: one, at which rate that lets its velocity decay, 1/s, and the square of that at which its
#: bristles swing, rad²/s².
SLOPE, SLOPE_COARSE, DECAY, SPRING = range(4)
REMEMBERED = 4
#: Rows of the room for a step: the state after one step, after half of it and after two halves, an
#: instant in between, how far that is from events, and what a passage needs.
COARSE, HALF, FINE, BETWEEN, DISTANCES, FURTHER = range(6)
#: Iterations for two velocities, how near two of them come, relative, and rounding, of what a
#: velocity is the sum of.
_MOST, _NEAR, _NOISE = 16, 1e-7, 1e-15
#: What numbers are rounded by, relative: no error of a step.
_ROUNDING = 4e-16
#: How the error falls with the length of a step: of order 4 and of order 2.
POWER, POWER_DAMPED = 0.2, 0.5


@compiled()
def _advanced(  # noqa: C901, PLR0915 - the equations of both sides
    slip_m: Any, rub_m: Any, p_m: Array, term_m: Array, slip: Any, rub: Any, p: Array,
    term: Array, c: Array, u: Array, y: Array, twist: float, mode: Array, load_m: Array,
    load: Array, span: float, h: float, w_m: float, w: float, memory: Array, at: int,
    near: Array, rate: Array, g: Array, out: Array,
) -> tuple[float, float, bool]:  # fmt: skip
    """The velocities at the span, θh, of a step of h, and whether they were found.

    The state after the step goes into `out`.

    Args:
        slip_m: As all further ones to `load` for `coupled_rates`.
        rub_m: See there.
        p_m: See there.
        term_m: See there.
        slip: See there.
        rub: See there.
        p: See there.
        term: See there.
        c: See there.
        u: At the span.
        y: The state before: positions and velocities, states of the motor's and the load's law.
        twist: Of the spring at the span, where the coupling is between its flanks.
        mode: See there.
        load_m: See there.
        load: See there.
        span: θh, s.
        h: s.
        w_m: Where the motor's velocity is looked for, as the next one.
        w: The load's.
        memory: Of both sides, (2, 4).
        at: Which slope of it, SLOPE or SLOPE_COARSE.
        near: Room for positions and velocities.
        rate: Room for rates, (4,).
        g: Room for distances, (3,).
        out: The state after.
    """
    coupling, states_m, states = coupling_constants(c), mode[MOTOR_STATES], mode[LOAD_STATES]
    own, end = STATE + states_m, STATE + states_m + states
    stiff, damp = 0.0, 0.0
    if mode[FLANK] != FREE:
        stiff, damp = coupling.stiffness, coupling.damping
    mass_m, mass = c[MOTOR_ROW], c[int(c[LOAD_ROW])]
    moves_m, moves = mode[MOTOR] != 0, mode[LOAD] != 0
    w_m, w = w_m if moves_m else 0.0, w if moves else 0.0
    slope_m, slope = memory[MOTOR, at], memory[LOAD, at]
    old_m, old, f_m, f = w_m, w, 0.0, 0.0
    for i in range(_MOST):
        near[Q_M], near[V_M] = y[Q_M] + span * w_m, w_m
        near[Q], near[V] = y[Q] + span * w, w
        T = coupled_rates(
            slip_m, rub_m, p_m, term_m, slip, rub, p, term, c, u, near, twist, mode, load_m, load,
            y[STATE:own], y[own:end], span, out[STATE:own], out[own:end], rate, g,
        )  # fmt: skip
        if i > 0 and w_m != old_m:
            slope_m = max((load_m[FRICTION] - f_m) / (w_m - old_m), -0.5 * mass_m / span)
        if i > 0 and w != old:
            slope = max((load[FRICTION] - f) / (w - old), -0.5 * mass / span)
        old_m, old, f_m, f = w_m, w, load_m[FRICTION], load[FRICTION]
        off_m, off = y[V_M] + span * rate[V_M] - w_m, y[V] + span * rate[V] - w
        share = coupling.forward if T * w >= 0.0 else coupling.backward
        s_m, s = span / mass_m, span / mass
        between = damp + span * stiff
        J_mm = 1.0 + s_m * (slope_m + load_m[DAMP] + between)
        J_mq, J_qm = -s_m * between, -s * share * between
        if coupling.by_load > 0.5:  # noqa: PLR2004 - a flag
            J_mq += s_m * span * load_m[STIFF]
        else:
            J_mm += s_m * span * load_m[STIFF]
        J = 1.0 + s * (slope + load[DAMP] + span * load[STIFF] + share * between)
        if not moves_m:
            J_mm, J_mq, off_m = 1.0, 0.0, 0.0
        if not moves:
            J, J_qm, off = 1.0, 0.0, 0.0
        scale = J_mm * J - J_mq * J_qm
        if not scale > 0.0:
            break
        change_m, change = (J * off_m - J_mq * off) / scale, (J_mm * off - J_qm * off_m) / scale
        w_m, w = w_m + change_m, w + change
        noise_m = abs(y[V_M]) + s_m * (abs(load_m[FRICTION]) + abs(T))
        noise = abs(y[V]) + s * (abs(load[FRICTION]) + abs(T))
        if (
            abs(change_m) <= _NEAR * abs(w_m) + _NOISE * noise_m / J_mm
            and abs(change) <= _NEAR * abs(w) + _NOISE * noise / J
        ):
            memory[MOTOR, at], memory[LOAD, at] = slope_m, slope
            theta = span / h
            out[Q_M], out[Q] = y[Q_M] + h * w_m, y[Q] + h * w
            out[V_M], out[V] = y[V_M] + (w_m - y[V_M]) / theta, y[V] + (w - y[V]) / theta
            if states_m > 0:
                rub_m(w_m, h, y[STATE:own], load_m, p_m, out[STATE:own])
            if states > 0:
                rub(w, h, y[own:end], load, p, out[own:end])
            return w_m, w, True
    memory[MOTOR, at] = memory[LOAD, at] = 0.0
    return w_m, w, False


@compiled(forceinline=True)
def _keep_rates(memory: Array, side: int, mass: float, theta: float, h: float) -> None:
    """Keep how friction of a side resists and springs back; see `passage`."""
    slope, coarse = memory[side, SLOPE], memory[side, SLOPE_COARSE]
    if slope == 0.0 or coarse == 0.0:  # unknown
        return
    memory[side, SPRING] = max((coarse - slope) / (0.5 * theta * h * mass), 0.0)
    memory[side, DECAY] = (2.0 * slope - coarse) / mass


@compiled(forceinline=True)
def _swings(c: Array, mode: Array, memory: Array) -> float:
    """The square of the fastest that bristles or the coupling swing, rad²/s², at most."""
    coupling, square = coupling_constants(c), memory[MOTOR, SPRING] + memory[LOAD, SPRING]
    if mode[FLANK] != FREE:
        square += coupling.stiffness * (1.0 / c[MOTOR_ROW] + 1.0 / c[int(c[LOAD_ROW])])
    return square  # type: ignore[no-any-return]


@compiled(inline="always")
def implicit_step(  # noqa: C901 - the stages of one method
    slip_m: Any, rub_m: Any, p_m: Array, term_m: Array, slip: Any, rub: Any, p: Array,
    term: Array, c: Array, inputs: Array, held: Array, k: int, begin: float, share: float,
    h: float, y: Array, twist: float, mode: Array, u: Array, load_m: Array, load: Array,
    rates: Array, at: Array, g: Array, room: Array, memory: Array,
) -> tuple[float, float, float]:  # fmt: skip
    """A step of h seconds, a share of an interval: its error, its stage past an event, its power.

    As `coupled_passage` has explicit ones: the state after it goes into `at`, the distances from
    events there into `g`; `rates` begins with those at the start and ends with those at the end.
    The power of the error to which the length of the next step goes is told. The error is inf where
    the step could not be taken.
    """
    own = STATE + mode[MOTOR_STATES]
    end = own + mode[LOAD_STATES]
    mass_m, mass = c[MOTOR_ROW], c[int(c[LOAD_ROW])]
    decay = max(
        memory[MOTOR, DECAY] + load_m[DAMP] / mass_m, memory[LOAD, DECAY] + load[DAMP] / mass
    )
    damped, square = decay * h > STIFF_DECAY, _swings(c, mode, memory) * h * h
    theta = 1.0 if damped else min(0.5 + SWING * square * square, 1.0)
    shift, weight = theta * h, (4.0 * theta - 1.0) / 3.0
    coarse, half, fine, between = room[COARSE], room[HALF], room[FINE], room[BETWEEN]
    rate = rates[1]
    mixed(inputs, held, k, begin + theta * share, u)
    w_m, w, found = _advanced(
        slip_m, rub_m, p_m, term_m, slip, rub, p, term, c, u, y,
        twist_left(c, mode[FLANK], twist, shift), mode, load_m, load, shift, h,
        y[V_M] + shift * rates[0, V_M], y[V] + shift * rates[0, V], memory, SLOPE_COARSE,
        between, rate, g, coarse,
    )  # fmt: skip
    if not found:
        return np.inf, 2.0, POWER
    mixed(inputs, held, k, begin + 0.5 * theta * share, u)
    w_1m, w_1, found = _advanced(
        slip_m, rub_m, p_m, term_m, slip, rub, p, term, c, u, y,
        twist_left(c, mode[FLANK], twist, 0.5 * shift), mode, load_m, load, 0.5 * shift, 0.5 * h,
        0.5 * (y[V_M] + w_m), 0.5 * (y[V] + w), memory, SLOPE, between, rate, g, half,
    )  # fmt: skip
    if not found:
        return np.inf, 2.0, POWER
    mixed(inputs, held, k, begin + 0.5 * (1.0 + theta) * share, u)
    _, _, found = _advanced(
        slip_m, rub_m, p_m, term_m, slip, rub, p, term, c, u, half,
        twist_left(c, mode[FLANK], twist, 0.5 * (1.0 + theta) * h), mode, load_m, load,
        0.5 * shift, 0.5 * h, w_m if damped else 2.0 * w_m - w_1m, w if damped else 2.0 * w - w_1,
        memory, SLOPE, between, rate, g, fine,
    )  # fmt: skip
    if not found:
        return np.inf, 2.0, POWER
    _keep_rates(memory, MOTOR, mass_m, theta, h)
    _keep_rates(memory, LOAD, mass, theta, h)
    for i in range(end):
        at[i] = fine[i] + weight * (fine[i] - coarse[i])
        if i >= STATE:
            half[i] += 0.5 * weight * (fine[i] - coarse[i])
    mixed(inputs, held, k, begin + share, u)
    last = rates[len(rates) - 1]
    coupled_rates(
        slip_m, rub_m, p_m, term_m, slip, rub, p, term, c, u, at,
        twist_left(c, mode[FLANK], twist, h), mode, load_m, load, at[STATE:own],
        at[own:end], 0.0, between[STATE:own], between[own:end], last, g,
    )  # fmt: skip
    if theta == 1.0:
        error = h * (abs(fine[V_M] - coarse[V_M]) + abs(fine[V] - coarse[V]))
        for m in (Q_M, Q):
            middle = half[m + 1] + 0.5 * (fine[m + 1] - coarse[m + 1])
            error += abs(y[m] + h * (y[m + 1] + 4.0 * middle + at[m + 1]) / 6.0 - at[m])
        return error, 2.0, POWER_DAMPED
    for m in (Q_M, Q):
        v, v_1 = m + 1, at[m + 1]
        between[v] = 0.5 * (y[v] + v_1) + 0.125 * h * (rates[0, v] - last[v])
        between[m] = 0.5 * (y[m] + at[m]) + 0.125 * h * (y[v] - v_1)
    mixed(inputs, held, k, begin + 0.5 * share, u)
    beyond = room[DISTANCES, :EVENTS]
    coupled_rates(
        slip_m, rub_m, p_m, term_m, slip, rub, p, term, c, u, between,
        twist_left(c, mode[FLANK], twist, 0.5 * h), mode, load_m, load, half[STATE:own],
        half[own:end], 0.0, between[STATE:own], between[own:end], rate, beyond,
    )  # fmt: skip
    early, error = 2.0, 0.0
    for e in range(EVENTS):  # a velocity may pass zero and come back, a level or a flank not
        if beyond[e] > 0.0 and (e == 2 or mode[e] == 0):  # noqa: PLR2004 - the coupling's
            early = 0.5
    for m in (Q_M, Q):
        v = m + 1
        a_0, a_m, a_1 = rates[0, v], rate[v], last[v]
        error += h * abs(y[v] + h * (a_0 + 4.0 * a_m + a_1) / 6.0 - at[v])
        error += abs(y[m] + h * (y[v] + h * (a_0 + 2.0 * a_m) / 6.0) - at[m])
        error -= _ROUNDING * (abs(at[m]) + h * abs(at[v]))
    return max(error, 0.0), early, POWER
