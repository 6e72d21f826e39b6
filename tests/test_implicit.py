"""Rigs on the implicit stepper: closed forms, reference integrators, order, stick, refusals."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from stribeck.data.recording import Recording
from stribeck.errors import InputError
from stribeck.friction import LAWS, Law, law_named, slip_law
from stribeck.identify.parameters import partition
from stribeck.identify.problem import problem
from stribeck.rig import RIGS
from stribeck.rig.motion.command import Drive
from stribeck.rig.motion.track import Track, track
from stribeck.rig.simulated import SimulatedRig
from stribeck.rig.slide_bed import SLIDE_BED
from stribeck.rig.stepped import SteppedRig
from stribeck.space import Array, Param

COULOMB, STRIBECK, LUGRE = LAWS["coulomb-viscous"], LAWS["stribeck"], LAWS["lugre"]
G = 9.80665


def rig(name: str) -> SteppedRig:
    stepped_rig = RIGS[name]
    assert isinstance(stepped_rig, SteppedRig)
    return stepped_rig


def track_of(axis: SimulatedRig, log: Recording) -> Track:
    rows = slice(0, len(log))
    return axis.track(log, rows, float(log.position[0]), np.ones(len(log)))


def forced_log(t: Array, F: Array, v0: float = 0.0) -> Recording:
    """A log of an axis under a force; its positions only say where and how fast it starts."""
    return Recording(t=t, position=v0 * t + 1e-9 * np.sin(t), velocity=np.full(len(t), v0), force=F)


def motion_of(law: Law, p: list[float], log: Recording, **set_: float) -> tuple[Array, Array]:
    axis = rig("presliding").set(**set_) if set_ else rig("presliding")
    log_track = track_of(axis, log)
    if log.velocity is not None:
        log_track = log_track._replace(v0=float(log.velocity[0]), x0=0.0)
    motion = axis.move(law, np.array([p]), log_track)
    return motion.position[0], motion.velocity[0]


# --- closed forms -------------------------------------------------------------------------------


def test_a_constant_push_is_the_exponential_of_viscous_friction() -> None:
    t = np.linspace(0.0, 2.0, 41)
    x, v = motion_of(COULOMB, [3.0, 4.0, 2.0, 0.0], forced_log(t, np.full(41, 11.0)), step=1.0)
    top, rate = (11.0 - 3.0) / 4.0, 4.0 / 2.0
    np.testing.assert_allclose(v, top * (1 - np.exp(-rate * t)), atol=1e-6)
    np.testing.assert_allclose(x, top * (t - (1 - np.exp(-rate * t)) / rate), atol=1e-6)


def test_coasting_stops_where_the_closed_form_does_and_stays() -> None:
    t = np.linspace(0.0, 1.0, 101)
    x, v = motion_of(COULOMB, [3.0, 0.0, 2.0, 0.0], forced_log(t, np.zeros(101), v0=0.9), step=1.0)
    assert x[-1] == pytest.approx(0.9**2 * 2.0 / (2 * 3.0), abs=1e-7)
    assert np.ptp(x[t > 0.61]) == 0.0
    assert (v[t > 0.61] == 0.0).all()


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_what_sticks_breaks_away_at_its_own_level(sign: float) -> None:
    t = np.linspace(0.0, 10.0, 1001)
    directional = LAWS["coulomb-viscous-directional"]
    # Levels 3 N rightward, 5 N leftward; the ramp passes them after 3 s and 5 s.
    axis = rig("presliding")
    p = np.array([[3.0, 10.0, 5.0, 10.0, 2.0, 0.0]])
    x = axis.move(directional, p, track_of(axis, forced_log(t, sign * t))).position[0]
    moving = t[np.abs(x - x[0]) > 1e-7][0]
    assert moving == pytest.approx(3.0 if sign > 0 else 5.0, abs=0.05)
    assert (x[t < moving - 0.06] == x[0]).all()


def test_a_pendulum_without_friction_keeps_its_energy() -> None:
    servo = rig("servo-pendulum").set(tolerance=1e-4, step=1.0)
    t = np.linspace(0.0, 3.0, 301)
    off = Recording(
        t=t, position=1.0 + 1e-9 * t, velocity=np.full(301, 1e-9), command=np.zeros(301),
        extra={"torque_enable": np.zeros(301)}, rotary=True,
    )  # fmt: skip
    p = np.array([[0.0, 0.0, 0.3, 3.0, 0.002, 0.0]])
    motion = servo.move(COULOMB, p, track_of(servo, off))
    J, m, length = 0.49 * 0.01 + 0.002, 0.49, 0.1
    energy = 0.5 * J * motion.velocity[0] ** 2 - m * G * length * np.cos(motion.position[0])
    assert np.ptp(motion.position[0]) > 1.9  # it swings
    assert np.ptp(energy) < 1e-4 * m * G * length
    # The small swing has the period of a physical pendulum.
    small = Recording(
        t=t, position=0.01 + 1e-9 * t, velocity=np.full(301, 1e-9), command=np.zeros(301),
        extra={"torque_enable": np.zeros(301)}, rotary=True,
    )  # fmt: skip
    x = servo.move(COULOMB, p, track_of(servo, small)).position[0]
    omega = np.sqrt(m * G * length / J)
    np.testing.assert_allclose(x, 0.01 * np.cos(omega * t), atol=1e-5)


def test_a_servo_holds_where_gravity_and_its_spring_balance() -> None:
    servo = rig("servo-pendulum")
    t = np.linspace(0.0, 6.0, 601)
    log = Recording(t=t, position=np.zeros(601) + 1e-9 * t, command=np.full(601, 0.8), rotary=True)
    p = np.array([[0.0, 0.01, 0.3, 3.0, 0.002, 0.05]])
    at = servo.move(COULOMB, p, track_of(servo, log)).position[0, -1]
    volts = servo["vin"] * servo["kp"] * servo["duty"] * (0.8 - at)
    assert abs(volts) < servo["vin"]
    assert 0.3 / 3.0 * volts == pytest.approx(0.49 * G * 0.1 * np.sin(at + 0.05), rel=1e-6)


def test_a_saturated_servo_gives_no_more_than_its_supply() -> None:
    servo = rig("servo-pendulum")
    t = np.linspace(0.0, 0.05, 51)
    p = np.array([[0.0, 0.0, 0.3, 3.0, 0.002, 0.0]])
    forces = []
    for goal in (3.0, 30.0):
        log = Recording(t=t, position=1e-9 * t, command=np.full(51, goal), rotary=True)
        forces.append(servo.move(COULOMB, p, track_of(servo, log)).force[0])
    np.testing.assert_array_equal(forces[0], forces[1])
    assert forces[0][0] == pytest.approx(0.3 * 7.4 / 3.0)


def test_the_torque_of_a_joint_is_limited() -> None:
    joint = rig("joint").set(limit=2.0)
    t = np.linspace(0.0, 1.0, 101)
    log = Recording(t=t, position=1e-9 * t, command=np.full(101, 1.0), rotary=True)
    p = np.array([[0.0, 0.0, 0.5, 0.0, 0.0, 0.0]])
    motion = joint.move(COULOMB, p, track_of(joint, log))
    assert np.abs(motion.force).max() == 2.0
    np.testing.assert_allclose(motion.position[0][t < 0.4], 2.0 * t[t < 0.4] ** 2, atol=1e-6)


def test_a_joint_rests_where_its_gains_carry_its_weight() -> None:
    joint = rig("joint").set(kp=50.0, kd=4.0, gain=0.5)
    t = np.linspace(0.0, 20.0, 401)
    ahead = np.full(401, 0.7)
    log = Recording(t=t, position=0.2 + 1e-9 * t, command=np.full(401, 0.5),
                    extra={"tau_ff_Nm": ahead}, rotary=True)  # fmt: skip
    p = np.array([[0.0, 0.3, 0.1, 2.0, 1.0, -0.4]])
    q = joint.move(COULOMB, p, track_of(joint, log)).position[0, -1]
    weight = 2.0 * np.sin(q) + np.cos(q) - 0.4
    assert 0.7 + 0.5 * 50.0 * (0.5 - q) == pytest.approx(weight, rel=1e-6)


# --- other integrators --------------------------------------------------------------------------


def test_lugre_is_what_a_stiff_solver_finds() -> None:
    sigma_0, sigma_1, F_S, F_C, v_s, F_V, M = 1e5, 300.0, 1.5, 1.0, 1e-3, 0.4, 1.0
    t = np.linspace(0.0, 4.0, 401)
    force = 1.4 * np.sin(2.0 * t) + 0.1 * t
    at, slopes = force.tolist(), (np.diff(force) / 0.01).tolist()

    def F(time: float) -> float:
        i = min(int(100.0 * time), 399)
        return float(at[i] + slopes[i] * (time - 0.01 * i))

    def rates(time: float, y: Array) -> list[float]:
        _, v, z = y.tolist()
        g = F_C + (F_S - F_C) * math.exp(-((v / v_s) ** 2))
        dz = v - sigma_0 * abs(v) * z / g
        return [v, (F(time) - sigma_0 * z - sigma_1 * dz - F_V * v) / M, dz]

    solution = solve_ivp(rates, (0.0, 4.0), [0.0, 0.0, 0.0], "Radau", t, rtol=1e-9, atol=1e-13,
                      max_step=2e-3)  # fmt: skip
    assert np.ptp(solution.y[0]) > 0.05  # it slides
    log = forced_log(t, force)
    x, v = motion_of(LUGRE, [sigma_0, sigma_1, F_S, F_C, v_s, F_V, M, 0.0], log, step=0.5)
    assert np.abs(x - solution.y[0]).max() < 2e-4 * np.ptp(solution.y[0])
    assert np.abs(v - solution.y[1]).max() < 2e-3 * np.ptp(solution.y[1])


def test_a_static_law_that_is_stepped_is_what_the_fast_kernel_finds() -> None:
    p = np.array([[144.5463, 47.8514, 958.3, 1.0964e-3, 1.0, 967.98]])
    ramp = track(Drive.line(0.0, 0.1, 20.0, 5e-3), np.arange(0.0, 20.0, 0.02), 0.1)
    # The kernel's dead band of rest, 0.1 mm/s, ends slips 0.5 mm late; stepping has none.
    fast = SLIDE_BED.set(dv=1e-4).move(STRIBECK, p, ramp).position
    idle = np.hstack([p[:, :5], [[0.0, 293.15]], p[:, 5:]])
    stepped = SLIDE_BED.set(step=0.05).move(law_named("stribeck+temperature"), idle, ramp).position
    assert np.ptp(fast) > 0.05
    assert np.sqrt(np.mean((fast - stepped) ** 2)) < 2e-5  # of jumps of 27 mm


def test_errors_fall_with_the_fourth_power_of_the_step() -> None:
    t = np.linspace(0.0, 2.0, 11)
    log = forced_log(t, 9.0 + np.sin(3.0 * t))
    p = [3.0, 2.0, 4.0, 5e-2, 1.0, 2.0, 0.0]
    runs = [
        motion_of(STRIBECK, p, log, step=h, tolerance=1e9)[0][-1] for h in (40.0, 20.0, 10.0, 0.5)
    ]
    errors = np.abs(np.array(runs[:3]) - runs[3])
    orders = np.log2(errors[:-1] / errors[1:])
    assert ((orders > 3.5) & (orders < 4.5)).all(), orders


@slip_law
def _two_levels(v: float, p: Array) -> float:
    return math.copysign(p[0] + (p[1] if abs(v) > p[2] else 0.0), v)


@pytest.mark.parametrize("share", [0.05, 0.2, 0.3, 0.45, 0.5, 0.55, 0.7, 0.8, 0.95])
def test_a_jump_of_friction_within_a_step_is_enclosed(share: float) -> None:
    """Friction rises from 3 to 7 N at 1 m/s, at any place of a step: 4, then 2 m/s², closed form.

    A step that took the jump for a bend would be off by up to a third of 4 N over 20 ms: 0.3 mm.
    """
    law = Law(
        "two levels", tuple(Param(name, 0.0, 10.0, "N") for name in ("low", "rise", "at")),
        _two_levels, "", "", "",
    )  # fmt: skip
    t = np.linspace(0.0, 0.4, 21)
    start = 1.0 - 4.0 * (10 + share) * 0.02
    x, v = motion_of(law, [3.0, 4.0, 1.0, 2.0, 0.0], forced_log(t, np.full(21, 11.0), v0=start),
                     step=20.0)  # fmt: skip
    early, late = np.minimum(t, (10 + share) * 0.02), np.maximum(t - (10 + share) * 0.02, 0.0)
    np.testing.assert_allclose(v, start + 4.0 * early + 2.0 * late, atol=2e-5)
    exact = start * early + 2.0 * early**2 + 1.0 * late + late**2
    np.testing.assert_allclose(x, exact, atol=5e-6)


def test_a_brisk_servo_is_what_a_stiff_solver_finds() -> None:
    """No stop, no corner: steps of 10 ms are explicit, their errors far below the tolerance."""
    axis = rig("servo-pendulum")
    t = np.linspace(0.0, 0.16, 17)
    log = Recording(
        t=t, position=0.1 + 3.0 * t + 1e-9 * np.sin(t), velocity=np.full(17, 3.0),
        command=0.6 + 3.0 * t, rotary=True,
    )  # fmt: skip
    law, p = (
        LAWS["bam-m4"],
        np.array([0.012, 0.01, 0.02, 1.5, 1.2, 0.1, 0.15, 0.41, 8.6, 2e-3, 0.01]),
    )
    segment = track_of(axis, log)._replace(v0=3.0)
    x = axis.move(law, p[None], segment).position[0]
    K_c, K_v, K_cs, w_s, alpha, K_l, K_ls, k_t, R, armature, offset = p.tolist()
    m, length, gain, duty, g = (axis[name] for name in ("m", "l", "kp", "duty", "g"))

    def slope(now: float, state: Array) -> list[float]:
        q, w = state
        volts = axis["vin"] * gain * duty * (0.6 + 3.0 * now - q)
        drive, weight = k_t / R * (volts - k_t * w), -m * g * length * math.sin(q + offset)
        pressed, slow = abs(drive - weight), math.exp(-(abs(w / w_s) ** alpha))
        friction = K_c + K_v * w + K_l * pressed + slow * (K_cs + K_ls * pressed)
        return [w, (drive + weight - friction) / (m * length**2 + armature)]

    y = solve_ivp(slope, (0.0, 0.16), [0.1, 3.0], "DOP853", t, rtol=1e-12, atol=1e-13).y
    assert y[1].min() > 0.5
    assert np.abs(axis["vin"] * gain * duty * (0.6 + 3.0 * t - y[0])).max() < axis["vin"]
    np.testing.assert_allclose(x, y[0], atol=2e-7)


@pytest.mark.parametrize("step", [0.5, 1.0, 2.0, 3.0, 5.0, 20.0])
def test_a_mass_that_swings_on_its_bristles_never_swings_up(step: float) -> None:
    """1000 rad/s, undamped: what is not followed may fade, but not grow, however long a step is."""
    t = np.linspace(0.0, 4.0, 201)
    push = np.where(t < 0.1, 10.0, 0.0)
    x, _ = motion_of(
        LAWS["dahl"], [1e6, 900.0, 1.0, 0.0, 1.0, 0.0], forced_log(t, push),
        step=step, tolerance=1e9,
    )  # fmt: skip
    early, late = np.ptp(x[(t > 0.2) & (t < 1.0)]), np.ptp(x[t > 3.0])
    assert late <= 1.01 * early


def test_a_reversal_without_a_rest_is_located() -> None:
    """A push that reverses a slide within a step, closed form; steps are as long as samples."""
    t = np.linspace(0.0, 2.0, 7)
    x, v = motion_of(
        COULOMB, [3.0, 0.0, 2.0, 0.0], forced_log(t, np.full(7, -5.0), v0=2.1), step=1000.0
    )
    stop = 2.1 / 4.0
    away, back = t < stop, np.maximum(t - stop, 0.0)
    exact = np.where(away, 2.1 * t - 2.0 * t**2, 0.5 * 2.1 * stop - 0.5 * back**2)
    np.testing.assert_allclose(x, exact, atol=1e-10)
    np.testing.assert_allclose(v, np.where(away, 2.1 - 4.0 * t, -back), atol=1e-9)


def test_a_breakaway_within_a_step_is_located() -> None:
    """A force that grows by 1 N/s passes 3 N between two samples: M d²x/dt² = t − 3."""
    t = np.linspace(0.0, 6.8, 5)
    x, _ = motion_of(COULOMB, [3.0, 0.0, 2.0, 0.0], forced_log(t, t.copy()), step=5000.0)
    np.testing.assert_allclose(x - x[0], np.maximum(t - 3.0, 0.0) ** 3 / 12.0, atol=1e-9)


@pytest.mark.parametrize("name", [n for n, law in LAWS.items() if law.states])
def test_every_law_with_states_converges_with_the_step(name: str) -> None:
    law, t = LAWS[name], np.linspace(0.0, 3.0, 61)
    axis = rig("presliding")
    log = forced_log(t, 60.0 * np.sin(3.0 * t))
    p = middle_parameters(law)
    levels = law.levels(p)
    p = np.concatenate([p, [5.0, 0.0]])
    assert levels[1] < 60.0 * 0.99  # or it would never slide
    log_track = track_of(axis, log)
    runs = [
        axis.set(step=h, tolerance=1e9).move(law, p[None], log_track).position[0]
        for h in (8.0, 4.0, 2.0, 1.0, 0.02)
    ]
    errors = [np.abs(run - runs[-1]).max() for run in runs[:-1]]
    assert errors[-1] < 2e-3 * np.ptp(runs[-1])
    assert errors[-1] < 0.5 * errors[0]


def middle_parameters(law: Law) -> Array:
    """A parameter set that slides at some 40 N: 40 N levels, and otherwise the middle of ranges."""
    p = np.empty(len(law.params))
    for k, q in enumerate(law.params):
        low, high = q.lower, q.upper
        middle = np.sqrt(low * high) if q.log else 0.5 * (low + high)
        p[k] = middle if q.fixed is None else q.fixed
    scale = 40.0 / law.levels(p)[1] if law.levels(p)[1] > 0 else 1.0
    for k, q in enumerate(law.params):
        if q.unit in ("N", "N s/m", "N/m"):
            p[k] *= scale
    return p


# --- stick, starts, rows ------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["dahl", "lugre", "elasto-plastic"])
def test_bristles_carry_the_force_of_the_first_sample(name: str) -> None:
    law, t = LAWS[name], np.linspace(0.0, 2.0, 101)
    p = np.concatenate([middle_parameters(law), [5.0, 0.0]])
    F = 0.5 * law.levels(p[: len(law.params)])[1]
    axis = rig("presliding")
    x = axis.move(law, p[None], track_of(axis, forced_log(t, np.full(101, F)))).position[0]
    released = axis.move(
        law, p[None], track_of(axis, forced_log(t, np.linspace(F, 0.0, 101)))
    ).position[0]
    assert np.ptp(x) < 0.02 * np.ptp(released)  # it was at rest under that force, and stays there


def test_rows_do_not_depend_on_their_company() -> None:
    servo, t = rig("servo-pendulum"), np.linspace(0.0, 2.0, 201)
    log = Recording(t=t, position=1e-9 * t, command=np.sin(4.0 * t), rotary=True)
    log_track = track_of(servo, log)
    p = servo.sample(STRIBECK, np.random.default_rng(0), 23)
    together = servo.move(STRIBECK, p, log_track).position
    separate = np.concatenate([servo.move(STRIBECK, row[None], log_track).position for row in p])
    assert np.array_equal(together, separate)
    assert len(np.unique(together[:, -1])) == 23


def test_a_term_scales_the_friction_of_any_law() -> None:
    t = np.linspace(0.0, 2.0, 201)
    F = 9.0 * np.sin(3.0 * t)
    warm = Recording(t=t, position=1e-9 * t, force=F, temperature=np.full(201, 303.15))
    axis = rig("presliding")
    p = [6.0, 4.0, 3.0, 1e-2, 1.0]
    termed = [[*p, 0.02, 293.15, 2.0, 0.0]]
    law = law_named("stribeck+temperature")
    x = axis.move(law, np.array(termed), track_of(axis, warm)).position
    scaled = [[*(1.2 * np.array(p[:3])), *p[3:], 2.0, 0.0]]
    y = axis.move(STRIBECK, np.array(scaled), track_of(axis, warm)).position
    np.testing.assert_allclose(x, y, atol=1e-12)
    assert np.ptp(x) > 1e-3


def test_friction_may_depend_on_position() -> None:
    t = np.linspace(0.0, 40.0, 2001)
    law = law_named("coulomb-viscous+position")
    # F_C 3 N, F_V 100 N s/m, a quarter of it up and down over 5 mm: a push of 5 N goes on.
    p = [3.0, 100.0, 0.25, 0.0, 5e-3, 0.05, 0.0]
    x, v = motion_of(law, p, forced_log(t, np.full(2001, 5.0)))
    steady = (t > 20.0) & (v > 0)
    share = 1.0 + 0.25 * np.cos(2 * np.pi * x / 5e-3)
    np.testing.assert_allclose(v[steady], ((5.0 / share - 3.0) / 100.0)[steady], rtol=0.05)
    assert np.ptp(v[steady]) > 5e-3


def test_a_torque_that_is_off_neither_drives_nor_brakes() -> None:
    servo, t = rig("servo-pendulum"), np.linspace(0.0, 1.0, 101)
    enabled = (t < 0.5).astype(float)
    log = Recording(t=t, position=1e-9 * t, command=np.full(101, 1.0),
                    extra={"torque_enable": enabled}, rotary=True)  # fmt: skip
    p = np.array([[0.0, 0.0, 0.3, 3.0, 0.002, 0.0]])
    force = servo.move(COULOMB, p, track_of(servo, log)).force[0]
    assert (force[enabled == 0] == 0.0).all()
    assert np.abs(force[enabled == 1]).max() > 0.1


def test_a_log_says_its_own_mass_length_gain_and_supply() -> None:
    servo, t = rig("servo-pendulum"), np.linspace(0.0, 1.0, 101)
    constants = {"mass": 0.7, "length": 0.2, "kp": 100.0, "vin": 6.0}
    log = Recording(t=t, position=1e-9 * t, command=np.sin(t), rotary=True,
                    extra={n: np.full(101, v) for n, v in constants.items()})  # fmt: skip
    bare = Recording(t=t, position=1e-9 * t, command=np.sin(t), rotary=True)
    p = np.array([[0.01, 0.01, 0.3, 3.0, 0.002, 0.0]])
    adjusted = servo.set(m=0.7, l=0.2, kp=100.0, vin=6.0)
    x = servo.move(COULOMB, p, track_of(servo, log)).position
    assert np.array_equal(x, adjusted.move(COULOMB, p, track_of(adjusted, bare)).position)
    assert not np.array_equal(x, servo.move(COULOMB, p, track_of(servo, bare)).position)


def test_a_range_starts_from_the_measured_state() -> None:
    joint, t = rig("joint"), np.linspace(0.0, 4.0, 401)
    x = np.sin(t)
    log = Recording(t=t, position=x, command=x, rotary=True)
    objective = problem(log, rig=joint, law="coulomb-viscous", train="2s:3s")
    (stretch,) = objective.train
    assert stretch.track.x0 == x[200]
    assert stretch.track.v0 == pytest.approx(np.cos(2.0), abs=0.02)
    assert objective.samples == 100


# --- refusals -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "rotary", "message"),
    [
        ("servo-pendulum", True, "needs the commanded position"),
        ("joint", True, "needs the commanded position"),
        ("presliding", False, "needs the measured force"),
        ("presliding", True, "position is an angle"),
        ("joint", False, "position is a length"),
    ],
)
def test_logs_that_do_not_fit_are_refused(name: str, rotary: bool, message: str) -> None:
    t = np.linspace(0.0, 1.0, 101)
    with pytest.raises(InputError, match=message):
        problem(Recording(t=t, position=np.sin(t), rotary=rotary), rig=name, law="coulomb-viscous")


def test_a_law_that_needs_a_load_that_a_rig_does_not_know_is_refused() -> None:
    with pytest.raises(InputError, match="depends on the normal load, which rig joint"):
        partition(RIGS["joint"], LAWS["coulomb-load"])


def test_a_temperature_term_needs_a_temperature() -> None:
    t = np.linspace(0.0, 1.0, 101)
    log = Recording(t=t, position=np.sin(t), command=np.sin(t), rotary=True)
    with pytest.raises(InputError, match="needs a temperature"):
        problem(log, rig="joint", law="coulomb-viscous+temperature")


@pytest.mark.parametrize("constants", [{"step": 0.0}, {"step": np.inf}, {"tolerance": 0.0}])
def test_steps_must_be_above_zero(constants: dict[str, float]) -> None:
    t = np.linspace(0.0, 1.0, 101)
    with pytest.raises(InputError, match="must be above zero"):
        motion_of(COULOMB, [3.0, 0.0, 2.0, 0.0], forced_log(t, np.zeros(101)), **constants)


@pytest.mark.parametrize("step", [1e-9, 1e-300])
def test_steps_that_nobody_would_wait_for_are_refused(step: float) -> None:
    t = np.linspace(0.0, 100.0, 101)
    with pytest.raises(InputError, match="10,000,000 is the most: set a longer step, or split"):
        motion_of(COULOMB, [3.0, 0.0, 2.0, 0.0], forced_log(t, np.zeros(101)), step=step)


def test_a_log_that_pauses_for_weeks_is_refused() -> None:
    t = np.concatenate([np.linspace(0.0, 1.0, 101), np.linspace(2e6, 2e6 + 1.0, 101)])
    with pytest.raises(InputError, match=r"2e\+06 s in steps of 0.02 s.*split the log"):
        motion_of(COULOMB, [3.0, 0.0, 2.0, 0.0], forced_log(t, np.zeros(202)))


def test_a_motion_of_too_many_halved_steps_is_given_up() -> None:
    # No step keeps a tolerance below rounding: each interval asks for its 2^16 steps, and more
    # than a million are not made.
    t = np.linspace(0.0, 20.0, 1001)
    push = forced_log(t, 5.0 + 4.0 * np.sin(3.0 * t))
    x, _ = motion_of(COULOMB, [3.0, 4.0, 2.0, 0.0], push, tolerance=1e-30)
    finite = np.isfinite(x)
    assert 10 < finite.sum() < 200
    assert finite[: finite.sum()].all()
    plain, _ = motion_of(COULOMB, [3.0, 4.0, 2.0, 0.0], push)
    np.testing.assert_allclose(x[finite], plain[finite], atol=1e-5)


def test_too_few_parameters_are_refused() -> None:
    t = np.linspace(0.0, 1.0, 101)
    with pytest.raises(InputError, match="parameters are F_C, F_V, M, offset; got 3 columns"):
        motion_of(COULOMB, [3.0, 0.0, 2.0], forced_log(t, np.zeros(101)))
