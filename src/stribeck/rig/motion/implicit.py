"""Motion under friction of any law: an implicit step for rigs whose drive is known.

The equation of motion is m dv/dt = F(t, q) − d v + F_e(q) − F_f(v, z). One step of h seconds is
backward Euler in the velocity, with the friction and the damping d of the drive implicit, and the
position explicit:

    (m + h d) w + h F_f(w) = m v + h (F + F_e),    q' = q + h w,

one scalar equation for the new velocity w. Where a law sticks, w = 0 solves it as long as the
right-hand side lies between the two breakaway levels times h: nothing has to be told when the
axis stops or breaks away (stick and clip in one rule, and no dead band). Where a law has states,
F_f(w) is its force after h at constant w, which the law integrates itself, exactly or by a rule
that is stable for any h. So a bristle of 10^5 N/m needs no steps of a microsecond.

One step of h and two of h/2 are extrapolated, 2 fine − coarse: second order, and still damped for
infinitely stiff bristles, because both are. Steps divide the interval between two samples evenly.
Where fine and coarse disagree, as when the axis stops, or breaks away under a friction that falls
so steeply with speed that an implicit step would not feel it, a step is halved, and halved again.
Elsewhere the steps do not depend on the parameters, so a misfit stays smooth in them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numba import boolean, float64, int64, types, void

from ...compile_cache import compiled
from ...errors import InputError
from ...friction import RUB_SIGNATURE, RUB_TYPE, SLIP_TYPE, addressed, rub_law
from ...friction.law import (
    DRIVE,
    EXTERNAL,
    NORMAL,
    POSITION,
    TEMPERATURE,
    term_places,
    terms_factor,
)
from ...space import Array
from . import row_pool
from .drives import (
    CASCADE,
    CLAMP,
    DAMPING,
    FORCE,
    INERTIA,
    JOINT,
    SERVO,
    SLIDE,
    CascadeConstants,
    CascadeInputs,
    ForceConstants,
    ForceInputs,
    JointConstants,
    JointInputs,
    ServoConstants,
    ServoInputs,
    SlideConstants,
    SlideInputs,
)
from .row_pool import borrowed

if TYPE_CHECKING:
    from ...friction import Law
    from .track import Track

#: Rows for each further thread: one takes milliseconds.
FEWEST = 2
#: A step is halved so often at most.
FINEST = 14
WHOLE = 1 << FINEST
#: Steps before any is halved, over a whole log: 16 hours in steps of 6 ms.
MOST_STEPS = 10_000_000
#: A motion may take so many halved steps, and so many more for each whole one: seconds at
#: most. It ends there, as if it had run away.
ROOM, EACH = 1 << 20, 64
#: Iterations for the velocity at the end of a step; as a rule 3 to 6 are needed.
_MOST = 80
#: Where they end: change of the velocity, relative.
_FINE = 1e-13
#: Secants that are tried first, how near two of them must come, relative, and rounding.
_FEW, _NEAR, _NOISE = 6, 1e-7, 1e-15
#: The shortest way on which bristles may be stretched at the start, how often it is doubled, a way
#: on which they slide, m or rad, and a time so long, s, that no viscous force counts.
_SHORT, _DOUBLINGS, _LONG, _SLOW = 1e-12, 45, 10.0, 1e6

_F1 = types.Array(float64, 1, "C", readonly=True)
_F2 = types.Array(float64, 2, "C", readonly=True)
_W2 = float64[:, ::1]
_I1 = int64[::1]


def _no_rub(v: float, h: float, z: Array, load: Array, p: Array, out: Array) -> float:  # noqa: ARG001
    """Stands where a law has no states and no loads; it is never called."""
    return 0.0


NO_RUB = rub_law(_no_rub)

# Arrays are handed over by seven words each, which takes longer than most of what follows, so what
# is called in every step is written out in its caller.


@compiled(forceinline=True)
def servo_constants(c: Array) -> ServoConstants:
    """A row of constants by their names."""
    return ServoConstants(c[0], c[1], c[2], c[3], c[4], c[5], c[6])


@compiled(forceinline=True)
def servo_inputs(u: Array) -> ServoInputs:
    """A row of inputs by their names."""
    return ServoInputs(u[0], u[1], u[2], u[3], u[4])


@compiled(forceinline=True)
def joint_constants(c: Array) -> JointConstants:
    """A row of constants by their names."""
    return JointConstants(c[0], c[1], c[2], c[3], c[4], c[5], c[6], c[7])


@compiled(forceinline=True)
def joint_inputs(u: Array) -> JointInputs:
    """A row of inputs by their names."""
    return JointInputs(u[0], u[1], u[2], u[3], u[4])


@compiled(forceinline=True)
def slide_constants(c: Array) -> SlideConstants:
    """A row of constants by their names."""
    return SlideConstants(c[0], c[1], c[2], c[3], c[4], c[5], c[6], c[7], c[8], c[9])


@compiled(forceinline=True)
def cascade_constants(c: Array) -> CascadeConstants:
    """A row of constants by their names."""
    return CascadeConstants(c[0], c[1], c[2], c[3], c[4], c[5], c[6], c[7])


@compiled(forceinline=True)
def driven(
    kind: int, c: Array, u: Array, q: float, v: float, load: Array
) -> tuple[float, float, float]:
    """Mass, force of drive and surroundings without damping, and the drive's damping.

    Writes what a law may depend on into `load`: drive and external force, normal load, position
    and temperature. A drive that holds its force finds it there.
    """
    load[NORMAL], load[POSITION], load[TEMPERATURE] = u[0], q, u[1]
    if kind == SERVO:
        servo, control = servo_constants(c), servo_inputs(u)
        volts = servo.stiffness * (control.goal - q) + control.volts
        volts = min(max(volts, -servo.volts_max), servo.volts_max)
        enabled = 1.0 if control.enabled > 0.5 else 0.0  # noqa: PLR2004 - a flag
        load[EXTERNAL] = -servo.weight * np.sin(q + servo.q_offset)
        load[DRIVE] = enabled * (servo.per_volt * volts - servo.damping * v)
        return servo.J, enabled * servo.per_volt * volts + load[EXTERNAL], enabled * servo.damping
    if kind == JOINT:
        joint, wish = joint_constants(c), joint_inputs(u)
        load[EXTERNAL] = -(joint.g_sin * np.sin(q) + joint.g_cos * np.cos(q) + joint.g_0)
        if joint.hold > 0.0:  # the drive's torque stands there already
            return joint.J, load[DRIVE] + load[EXTERNAL], 0.0
        torque = wish.torque + joint.k_p * (wish.goal - q) + joint.k_d * wish.velocity
        load[DRIVE] = min(max(torque - joint.k_d * v, -joint.limit), joint.limit)
        if abs(torque - joint.k_d * v) >= joint.limit:
            return joint.J, load[DRIVE] + load[EXTERNAL], 0.0
        return joint.J, torque + load[EXTERNAL], joint.k_d
    if kind in (FORCE, CASCADE):
        mass = ForceConstants(c[0], c[1])  # with which a cascade's constants begin, too
        if kind == FORCE:  # the force of a cascade stands there already
            load[DRIVE] = ForceInputs(u[0], u[1], u[2]).force
        load[EXTERNAL] = -mass.offset
        return mass.M, load[DRIVE] - mass.offset, 0.0
    bed, slide = slide_constants(c), SlideInputs(u[0], u[1], u[2], u[3])
    e = slide.command - q
    if e > 0.0:
        spring, motor = bed.k_spring_plus * e, bed.k_hat_plus * e + slide.added
    else:
        spring, motor = bed.k_spring_minus * e, bed.k_hat_minus * e + slide.added
    load[DRIVE] = spring + max(motor - bed.F_fm, 0.0) + min(motor + bed.F_fm, 0.0)
    load[EXTERNAL] = 0.0
    return bed.m, load[DRIVE], 0.0


@compiled(forceinline=True)
def commanded(c: Array, u: Array, q: float, v: float) -> float:
    """The torque that the controller of a joint computes at a sample."""
    joint, wish = joint_constants(c), joint_inputs(u)
    torque = wish.torque + joint.k_p * (wish.goal - q) + joint.k_d * (wish.velocity - v)
    return min(max(torque, -joint.limit), joint.limit)  # type: ignore[no-any-return]


@compiled(forceinline=True)
def _cascade_reset(c: Array, q: float, v: float, last: Array) -> None:
    """What a cascade remembers at its start: an axis that came at a constant velocity."""
    loop = cascade_constants(c)
    last[0] = last[1] = loop.volts_start
    last[2], last[3] = q - loop.T * v, q - 2 * loop.T * v


@compiled(forceinline=True)
def _cascade(c: Array, u: Array, q: float, last: Array) -> float:
    """The force of a cascade's drive from this instant on.

    At a sample k the controller computes

        u_k = clip(k_v (k_p (q_ref,k − q_k) − (q_k − q_k−2) / 2T), ±volts_max),

    whose velocity is a backward difference of the mean of two positions. `last` keeps the voltages
    of the last sample and of the one before, and the positions at these, (4,).
    """
    loop = cascade_constants(c)
    wish = CascadeInputs(u[0], u[1], u[2], u[3], u[4], u[5])
    if wish.sampled > 0.5:  # noqa: PLR2004 - a flag
        volts = loop.k_v * (loop.k_p * (wish.goal - q) - (q - last[3]) / (2 * loop.T))
        last[0], last[1] = min(max(volts, -loop.volts_max), loop.volts_max), last[0]
        last[2], last[3] = q, last[2]
    volts = last[1] if wish.late > 0.5 else last[0]  # noqa: PLR2004 - a flag
    return loop.per_volt * (volts + wish.volts)  # type: ignore[no-any-return]


@compiled(forceinline=True)
def _rubs(
    slip: Any, rub: Any, general: bool, scale: float, v: float, h: float, z: Array, load: Array,
    p: Array, out: Array,
) -> float:  # fmt: skip
    """Friction at the end of a span h at speed v; the states' new values go into `out`."""
    if general:
        return scale * rub(v, h, z, load, p, out)  # type: ignore[no-any-return]
    return scale * slip(v, p)  # type: ignore[no-any-return]


@compiled(forceinline=True)
def _quick(
    slip: Any, rub: Any, general: bool, scale: float, M: float, P: float, h: float, s: float,
    v: float, z: Array, load: Array, p: Array, out: Array, slopes: Array, at: int, least: float,
) -> float:  # fmt: skip
    """The root of M w + h s F_f(s w) − P near v by secants; nan if they do not lead there.

    `slopes[at]` is how steeply friction rose when it was last asked, which makes the first step
    a good one. Secants that come nearer by a factor of 10^7 have digits to spare.
    """
    w = v
    g = M * w + h * s * _rubs(slip, rub, general, scale, s * w, h, z, load, p, out) - P
    slope = M + h * slopes[at]
    other = w - g / slope
    for _ in range(_FEW):
        if not other > least or other == w:
            break
        g_other = M * other + h * s * _rubs(
            slip, rub, general, scale, s * other, h, z, load, p, out
        )
        g_other -= P
        slope = (g_other - g) / (other - w)
        if not slope > 0.0:
            break
        w, g = other, g_other
        other = w - g / slope
        if abs(other - w) <= _NEAR * abs(other) + _NOISE * abs(P) / slope:
            if not other > least:
                break
            slopes[at] = max((slope - M) / h, -0.5 * M / h)
            return other  # type: ignore[no-any-return]
    slopes[at] = 0.0
    return np.nan


@compiled()
def _sliding(  # noqa: C901 - two ways to a bracket
    slip: Any, rub: Any, general: bool, scale: float, M: float, P: float, h: float, v: float,
    z: Array, load: Array, p: Array, out: Array, slopes: Array, at: int,
) -> float:  # fmt: skip
    """The velocity w of the same sign as P that solves M w + h F_f(w) = P, 0 if it sticks.

    All is mirrored so that P > 0. The largest root is taken: from a slide in progress the one
    that continues it. A law that falls with speed may have another one, which is not stable.
    """
    s = 1.0 if P > 0.0 else -1.0
    P = s * P
    if s * v > 0.0:
        w = _quick(slip, rub, general, scale, M, P, h, s, s * v, z, load, p, out, slopes, at, 0.0)
        if w > 0.0:
            return s * w  # type: ignore[no-any-return]
    start = s * h * _rubs(slip, rub, general, scale, s * 0.0, h, z, load, p, out) - P
    low, g_low, high, w = 0.0, start, P / M, s * v
    if not 0.0 < w < high:
        if start >= 0.0:
            return 0.0
        w = min(-start / M, 0.5 * high)
    g = M * w + s * h * _rubs(slip, rub, general, scale, s * w, h, z, load, p, out) - P
    if g >= 0.0 and start >= 0.0:  # a slide in progress may go on where a start could not
        while g > 0.0:
            high, g_high = w, g
            w -= g / M
            if w <= 0.0:
                return 0.0
            g = M * w + s * h * _rubs(slip, rub, general, scale, s * w, h, z, load, p, out) - P
            if high - w <= _FINE * high:
                return s * w  # type: ignore[no-any-return]
            if g >= g_high:
                return 0.0
        low, g_low = w, g
    elif g >= 0.0:
        high, g_high = w, g
    else:
        low, g_low = w, g
        g_high = s * h * _rubs(slip, rub, general, scale, s * high, h, z, load, p, out)
    return s * _root(  # type: ignore[no-any-return]
        slip, rub, general, scale, M, P, h, s, z, load, p, out, low, g_low, high, g_high
    )


@compiled()
def _root(  # noqa: C901 - one step of many cases
    slip: Any, rub: Any, general: bool, scale: float, M: float, P: float, h: float, s: float,
    z: Array, load: Array, p: Array, out: Array, low: float, g_low: float, high: float,
    g_high: float,
) -> float:  # fmt: skip
    """The root of M w + h s F_f(s w) − P between two points of opposite sign.

    False position as improved by Anderson and Björck (1973, doi 10.1007/BF01951936).
    """
    if g_low == 0.0:
        return low
    if g_high == 0.0:
        return high
    side = 0
    w = low
    for k in range(_MOST):
        # Past a score of tries, every other one halves the bracket: no law can do worse then.
        w = low - g_low * (high - low) / (g_high - g_low)
        if not low < w < high or (k > 20 and k % 2):  # noqa: PLR2004
            w = 0.5 * (low + high)
        g = M * w + h * s * _rubs(slip, rub, general, scale, s * w, h, z, load, p, out) - P
        if g == 0.0 or high - low <= _FINE * (abs(low) + abs(high)):
            return w
        if g < 0.0:
            if side < 0:
                m = 1.0 - g / g_low
                g_high *= m if m > 0.0 else 0.5
            if w - low <= _FINE * abs(w) and k > 0:
                return w
            low, g_low, side = w, g, -1
        else:
            if side > 0:
                m = 1.0 - g / g_high
                g_low *= m if m > 0.0 else 0.5
            if high - w <= _FINE * abs(w) and k > 0:
                return w
            high, g_high, side = w, g, 1
    return w


@compiled()
def _bristled(
    slip: Any, rub: Any, scale: float, M: float, P: float, h: float, v: float, z: Array,
    load: Array, p: Array, out: Array, slopes: Array, at: int,
) -> float:  # fmt: skip
    """The velocity w that solves M w + h F_f(w) = P for a law with states.

    Steps of growing length, downhill from the velocity before, until the residual changes sign:
    where a law that falls with speed has several roots, that is the next one on the way.
    """
    w = _quick(slip, rub, True, scale, M, P, h, 1.0, v, z, load, p, out, slopes, at, -np.inf)
    if not np.isnan(w):
        return w  # type: ignore[no-any-return]
    w = v
    g = M * w + h * scale * rub(w, h, z, load, p, out) - P
    if g == 0.0:
        return w
    step = -g / M
    for _ in range(_MOST):
        other = w + step
        g_other = M * other + h * scale * rub(other, h, z, load, p, out) - P
        if (g_other >= 0.0) != (g > 0.0) or g_other == 0.0:
            if g > 0.0:
                w, g, other, g_other = other, g_other, w, g
            return _root(  # type: ignore[no-any-return]
                slip, rub, True, scale, M, P, h, 1.0, z, load, p, out, w, g, other, g_other
            )
        w, g, step = other, g_other, 2.0 * step
    return w  # type: ignore[no-any-return]


@compiled(forceinline=True)
def _step(
    slip: Any, rub: Any, general: bool, states: int, kind: int, p: Array, term: Array, c: Array,
    u: Array, h: float, q: float, v: float, z: Array, load: Array, out: Array, slopes: Array,
    at: int,
) -> float:  # fmt: skip
    """The velocity after a step of h under the inputs u at its end; new states into `out`."""
    mass, F, d = driven(kind, c, u, q, v, load)
    scale = terms_factor(term, p, load)
    if kind == SLIDE and (c[INERTIA] > 0.0 or c[DAMPING] > 0.0):
        # The motor's inertia and damping, clamped: implicit, and outside the clamp a constant.
        M, P = mass + c[INERTIA] + h * c[DAMPING], (mass + c[INERTIA]) * v + h * F
        w = _solved(slip, rub, general, states, scale, M, P, h, v, z, load, p, out, slopes, at)
        motor = c[INERTIA] * (w - v) / h + c[DAMPING] * w
        if abs(motor) > c[CLAMP]:
            P = mass * v + h * (F - np.copysign(c[CLAMP], motor))
            w = _solved(
                slip, rub, general, states, scale, mass, P, h, v, z, load, p, out, slopes, at
            )
        return w  # type: ignore[no-any-return]
    M, P = mass + h * d, mass * v + h * F
    return _solved(slip, rub, general, states, scale, M, P, h, v, z, load, p, out, slopes, at)  # type: ignore[no-any-return]


@compiled(forceinline=True)
def _solved(
    slip: Any, rub: Any, general: bool, states: int, scale: float, M: float, P: float, h: float,
    v: float, z: Array, load: Array, p: Array, out: Array, slopes: Array, at: int,
) -> float:  # fmt: skip
    if states > 0:
        w = _bristled(slip, rub, scale, M, P, h, v, z, load, p, out, slopes, at)
        rub(w, h, z, load, p, out)
        return w  # type: ignore[no-any-return]
    if P == 0.0:
        return 0.0
    return _sliding(slip, rub, general, scale, M, P, h, v, z, load, p, out, slopes, at)  # type: ignore[no-any-return]


@compiled(forceinline=True)
def mixed(inputs: Array, held: Array, k: int, share: float, u: Array) -> None:
    """The inputs at a share of the interval after sample k: between its ends, or held."""
    for i in range(len(u)):
        u[i] = inputs[i, k]
        if share > 0.0 and held[i] == 0:
            u[i] += share * (inputs[i, k + 1] - u[i])


@compiled()
def begun(
    rub: Any, scale: float, F: float, v: float, load: Array, p: Array, relaxed: Array, z: Array
) -> None:
    """The states of a law where a motion starts, into `z`.

    In motion, those of steady sliding. At rest, those on the way from relaxed bristles on which
    the friction balances the force F, or those of a long way if it never does.
    """
    relaxed[:] = 0.0
    if v != 0.0:
        rub(v, _LONG / abs(v), relaxed, load, p, z)
        return
    s, low, high = np.copysign(1.0, F), 0.0, _SHORT
    for _ in range(_DOUBLINGS):
        if s * scale * rub(s * high / _SLOW, _SLOW, relaxed, load, p, z) >= s * F:
            break
        low, high = high, 2.0 * high
    for _ in range(_DOUBLINGS):
        way = 0.5 * (low + high)
        if s * scale * rub(s * way / _SLOW, _SLOW, relaxed, load, p, z) < s * F:
            low = way
        else:
            high = way
    rub(s * low / _SLOW, _SLOW, relaxed, load, p, z)


@compiled(forceinline=True)
def passed(
    slip: Any, rub: Any, general: bool, states: int, kind: int, p: Array, term: Array, c: Array,
    inputs: Array, held: Array, k: int, n: int, span: float, tolerance: float, q: float, v: float,
    z: Array, coarse: Array, half: Array, fine: Array, u: Array, load: Array, slopes: Array,
    steps_left: int,
) -> tuple[float, float, int]:  # fmt: skip
    """Position and velocity after the interval that begins with sample k, and steps still left.

    It is passed in n steps and their halves; the states go on in `z`. Where no steps are left for
    all of it, position and velocity are nan.
    """
    base = span / n
    for j in range(n):
        at, level = 0, 0  # how far the step has been passed, in its 2^-FINEST parts
        while at < WHOLE and steps_left > 0:
            steps_left -= 1
            share = WHOLE >> level
            h = base * (share / WHOLE)
            mixed(inputs, held, k, (j + (at + 0.5 * share) / WHOLE) / n, u)
            v_half = _step(
                slip, rub, general, states, kind, p, term, c, u, 0.5 * h, q, v, z, load, half,
                slopes, 0,
            )  # fmt: skip
            q_half = q + 0.5 * h * v_half
            mixed(inputs, held, k, (j + (at + share) / WHOLE) / n, u)
            v_fine = _step(
                slip, rub, general, states, kind, p, term, c, u, 0.5 * h, q_half, v_half, half,
                load, fine, slopes, 0,
            )  # fmt: skip
            v_coarse = _step(
                slip, rub, general, states, kind, p, term, c, u, h, q, v, z, load, coarse, slopes,
                1,
            )  # fmt: skip
            # Under a held force an axis may stop, or reverse without a rest, while coarse and fine
            # agree: each takes one sign of friction for all of its step.
            ends = kind == CASCADE and v != 0.0 and v * v_fine <= 0.0
            if (h * abs(v_fine - v_coarse) > tolerance or ends) and level < FINEST:
                level += 1
                continue
            q = 2.0 * (q_half + 0.5 * h * v_fine) - (q + h * v_coarse)
            v = 2.0 * v_fine - v_coarse
            if states == 0 and v * v_fine <= 0.0:  # extrapolated past the stop
                v = v_fine
            for i in range(states):
                z[i] = 2.0 * fine[i] - coarse[i]
            at += share
            if level > 0 and at % (2 * share) == 0:
                level -= 1
        if at < WHOLE:  # no steps are left for the rest of the way
            return np.nan, np.nan, steps_left
    return q, v, steps_left


@compiled(forceinline=True)
def started(
    rub: Any, states: int, kind: int, p: Array, term: Array, c: Array, inputs: Array, held: Array,
    hold: float, q: float, v: float, u: Array, load: Array, relaxed: Array, z: Array,
) -> float:  # fmt: skip
    """The torque that a joint's controller computed at the first sample; states into `z`."""
    mixed(inputs, held, 0, 0.0, u)
    torque = commanded(c, u, q, v) if hold > 0.0 else 0.0
    load[DRIVE] = torque
    _, F, d = driven(kind, c, u, q, v, load)
    if states > 0:
        begun(rub, terms_factor(term, p, load), F - d * v, v, load, p, relaxed, z)
    return torque


@compiled(
    void(
        SLIP_TYPE, RUB_TYPE, boolean, int64, int64, _F2, _I1, _F2, _F1, _F2, _I1, _I1, _F2,
        float64, _W2, _W2, _W2, _I1,
    ),
    nogil=True,
)  # fmt: skip
def _rows(  # a loop over candidates and samples
    slip: Any, rub: Any, general: bool, states: int, kind: int, p: Array, term: Array, c: Array,
    t: Array, inputs: Array, held: Array, parts: Array, start: Array, tolerance: float,
    out_q: Array, out_v: Array, out_F: Array, counter: Array,
) -> None:  # fmt: skip
    """Simulate the rows that no thread has taken yet, one after the other, until none is left."""
    m = len(inputs)
    term, t, parts = borrowed(term), borrowed(t), borrowed(parts)
    inputs, held, start = borrowed(inputs), borrowed(held), borrowed(start)
    states_owner = np.empty((6, max(states, 1)))
    u_owner, load_owner = np.empty(m), np.empty(5)
    slopes_owner, last_owner = np.empty(2), np.empty(4)
    u, load, slopes = borrowed(u_owner), borrowed(load_owner), borrowed(slopes_owner)
    last = borrowed(last_owner)
    z, coarse, half, fine = (
        borrowed(states_owner[0]), borrowed(states_owner[1]), borrowed(states_owner[2]),
        borrowed(states_owner[3]),
    )  # fmt: skip
    while True:
        row = row_pool.next_row(counter)
        if row >= len(p):
            states_owner[0, 0] = u_owner[0] = load_owner[0] = slopes_owner[0] = 0.0  # kept alive
            last_owner[0] = 0.0
            return
        a, b = borrowed(p[row]), borrowed(c[row])
        q, v = start[row, 0], start[row, 1]
        slopes[:] = 0.0
        steps_left = ROOM + EACH * parts.sum()
        hold = joint_constants(b).hold if kind == JOINT else 0.0
        last_torque = started(
            rub, states, kind, a, term, b, inputs, held, hold, q, v, u, load, coarse, z
        )
        if kind == CASCADE:
            _cascade_reset(b, q, v, last)
        for k in range(len(t)):
            mixed(inputs, held, k, 0.0, u)
            if hold > 0.0:
                torque = commanded(b, u, q, v)
                load[DRIVE] = torque if hold == 1.0 else last_torque
                last_torque = torque
            elif kind == CASCADE:
                load[DRIVE] = _cascade(b, u, q, last)
            driven(kind, b, u, q, v, load)
            out_q[row, k], out_v[row, k], out_F[row, k] = q, v, load[DRIVE]
            if k == len(t) - 1 or not (abs(q) < 1e12 and abs(v) < 1e12):  # noqa: PLR2004
                break
            q, v, steps_left = passed(
                slip, rub, general, states, kind, a, term, b, inputs, held, k, parts[k],
                t[k + 1] - t[k], tolerance, q, v, z, coarse, half, fine, u, load, slopes,
                steps_left,
            )  # fmt: skip


def motions(
    law: Law, kind: int, p: Array, c: Array, track: Track, step: float, tolerance: float
) -> tuple[Array, Array, Array]:
    """Position, velocity and drive force, (n, N) each; nan from where a motion runs away.

    Nan stands, too, from where a motion takes too many steps.

    Args:
        law: Any friction law.
        kind: The kind of drive.
        p: (n, k) parameters of the law.
        c: (n, WIDTH) constants of the drive.
        track: Sample times, inputs (m, N), which of them are held, and the start.
        step: No step is longer, s.
        tolerance: Steps are halved until the way of a coarse and a fine one differ by less, m
            or rad.

    Raises:
        InputError: so many steps that nobody would wait for them.
    """
    n, N = len(p), len(track.t)
    q, v, F = np.full((3, n, N), np.nan)
    if not n:
        return q, v, F
    t = np.ascontiguousarray(track.t - track.t[0])
    with np.errstate(over="ignore"):
        many = np.maximum(np.ceil(np.diff(t) / step - 1e-9), 1)
    if not many.sum() <= MOST_STEPS:
        raise InputError(
            f"{t[-1]:.6g} s in steps of {step:.3g} s are {many.sum():.3g} steps, and "
            f"{MOST_STEPS:,} is the most: set a longer step, or split the log at its gaps"
        )
    parts = many.astype(np.int64)
    start = np.column_stack([np.full(n, track.x0), np.full(n, track.v0)])
    general = law.rub is not None
    row_pool.pool().share(
        _rows, n,
        (
            addressed(law.slip), addressed(law.rub if general else NO_RUB, RUB_SIGNATURE),
            general, law.states, kind, _ready(p), term_places(law), _ready(c), t,
            _ready(track.inputs), track.held.astype(np.int64), parts, start, tolerance, q, v, F,
        ),
        max(FEWEST, row_pool.FEWEST_SAMPLES // max(N, 1)),
    )  # fmt: skip
    return q, v, F


def _ready(a: Any) -> Array:
    return np.ascontiguousarray(a, dtype=float)
