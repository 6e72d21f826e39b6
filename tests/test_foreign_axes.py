"""The foreign simulators against closed forms, energy, and themselves at half the step."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from foreign import cascade, cylinder, driven, joint, presliding, servo, slide_bed
from foreign.clock import Array
from foreign.friction import Curve, coulomb_viscous
from foreign.strokes import even, ramp, sines, strokes

STRIBECK = Curve(F_S=20.0, F_C=12.0, F_V=40.0, v_SS=0.01, exponent=1.5)


def test_nothing_here_imports_stribeck() -> None:
    for file in (Path(__file__).parent / "foreign").glob("*.py"):
        imports = [x for x in file.read_text().splitlines() if x.startswith(("import ", "from "))]
        assert not [x for x in imports if "stribeck" in x], file


# --- slide bed ------------------------------------------------------------------------------------

RIGHT = Curve(144.5463, 47.8514, 958.3, 1.0964e-3)
LEFT = Curve(152.2804, 40.4153, 975.7, 3.21475e-3)


@pytest.mark.parametrize(
    ("curve", "speed", "slips", "jump", "fastest", "stuck"),
    [
        (RIGHT, 5e-3, 10, 26.45e-3, 66.9e-3, 0.88),
        (LEFT, -5e-3, 7, 37.52e-3, 81.1e-3, 0.91),
    ],
)
def test_the_published_sets_slip_as_the_page_says(
    curve: Curve, speed: float, slips: int, jump: float, fastest: float, stuck: float
) -> None:  # fmt: skip
    """docs/physics.md, "What the published sets do"."""
    motion = slide_bed.simulate(slide_bed.Bed(), curve, curve, *ramp(60.0, speed), 0.0)
    moving = motion.velocity != 0.0
    starts = np.flatnonzero(np.diff(moving.astype(int)) > 0)
    assert len(starts) == slips
    rests = motion.position[starts]
    assert np.abs(np.diff(rests)) == pytest.approx(jump, abs=8e-6)
    assert np.abs(motion.velocity).max() == pytest.approx(fastest, abs=1e-4)
    assert 1.0 - moving.mean() == pytest.approx(stuck, abs=0.01)


@pytest.mark.parametrize("F_fm", [0.0, 23.5])
def test_a_bed_breaks_away_when_the_springs_pull_that_much(F_fm: float) -> None:
    bed = slide_bed.Bed(F_fm=F_fm, dv=0.0, dp=0.0)
    motion = slide_bed.simulate(bed, RIGHT, LEFT, *ramp(9.0, 5e-3), 0.0, dt=1e-3)
    begin = motion.t[np.argmax(motion.velocity > 0.0)]
    assert begin == pytest.approx((RIGHT.F_S + F_fm) / ((3500.0 + 967.98) * 5e-3), abs=2e-3)


def test_a_bed_spends_what_its_drive_puts_in() -> None:
    bed = slide_bed.Bed(
        K_J=0.0, K_D=0.0, dv=0.0, dp=0.0
    )  # a bare mass: all friction is the slide's
    motion = slide_bed.simulate(
        bed, RIGHT, LEFT, np.array([0.0, 7.8]), np.array([0.0, 0.039]), 0.0,
        dt=1e-4, h=1e-5,
    )  # fmt: skip
    v = motion.velocity
    friction = (RIGHT.F_C + (RIGHT.F_S - RIGHT.F_C) * np.exp(-v / RIGHT.v_SS)) + RIGHT.F_V * v
    work = np.trapezoid(v * motion.drive, motion.t)
    heat = np.trapezoid(v * friction, motion.t)
    assert v.max() > 0.05
    assert work == pytest.approx(heat + 0.5 * bed.m * v[-1] ** 2, rel=1e-3)


# --- a driven mass --------------------------------------------------------------------------------


def full_force(force: float) -> driven.Loop:
    """A loop that pushes with all it has."""
    return driven.Loop(kp=1e9, kd=0.0, limit=force)


def test_a_constant_force_comes_to_its_terminal_velocity() -> None:
    curve = coulomb_viscous(12.0, 40.0)
    motion = driven.simulate(
        10.0, curve, curve, full_force(18.0), np.array([0.0, 1.0]), np.array([0.0, 1e3])
    )
    lag = motion.t - 1e-3  # the loop sees no error before its second tick
    expected = 6.0 / 40.0 * (1.0 - np.exp(-40.0 / 10.0 * lag))
    assert_allclose(motion.velocity[1:], expected[1:], atol=1e-5)


def test_levels_hold_up_to_the_breakaway_of_their_direction() -> None:
    minus = STRIBECK._replace(F_S=10.0, F_C=8.0)
    for force, moves in ((19.9, 0), (20.1, 1), (-9.9, 0), (-10.1, -1)):
        motion = driven.simulate(
            10.0, STRIBECK, minus, full_force(abs(force)), np.array([0.0, 0.2]),
            np.array([0.0, np.sign(force) * 1e3]),
        )  # fmt: skip
        assert np.sign(motion.position[-1]) == moves
        assert motion.friction[50] == pytest.approx(force, rel=0.02)


LOOP = driven.Loop(kp=4e4, kd=2e3, ki=1e5, mass_ff=9.0, tick=1e-3)
EXTRAS = {
    "none": driven.Extras(),
    "pendulum": driven.Extras(g_sin=6.0, g_cos=3.0, offset=-2.0),
    "square": driven.Extras(square=300.0),
    "cogging": driven.Extras(cogging=4.0, cogging_period=0.01),
    "wave": driven.Extras(wave=0.4, wave_period=0.02),
    "spring": driven.Extras(spring=150.0, spring_at=0.02),
    "warming": driven.Extras(warming=0.5, warming_time=0.4),
}


@pytest.mark.parametrize("name", EXTRAS)
def test_forces_balance_at_every_step(name: str) -> None:
    """M dv/dt = F less all that is said to act, written out in numpy."""
    extras, plus, minus = EXTRAS[name], STRIBECK, Curve(15.0, 9.0, 60.0, 0.02)
    t, x_c, _ = strokes(np.array([0.05, 0.2]), 0.04, ramp=0.05, pause=0.05)
    m = driven.simulate(10.0, plus, minus, LOOP, t, x_c, extras, dt=1e-4, h=1e-4)
    x, v = m.position, m.velocity

    def curve(c: Curve) -> Array:
        drop = np.exp(-((np.abs(v) / c.v_SS) ** c.exponent))
        level = c.F_C + (c.F_S - c.F_C) * drop + c.F_V * np.abs(v) + extras.square * v**2
        factor = 1.0 + extras.wave * np.cos(2.0 * np.pi * x / extras.wave_period)
        return level * factor * (1.0 + extras.warming * np.exp(-m.t / extras.warming_time))

    drive = m.force - extras.offset - extras.spring * (x - extras.spring_at)
    drive -= extras.g_sin * np.sin(x) + extras.g_cos * np.cos(x)
    drive -= extras.cogging * np.sin(2.0 * np.pi * x / extras.cogging_period)
    friction = np.where(v > 0.0, curve(plus), -curve(minus))
    slides = (v[:-1] * v[1:] > 0.0) & (v[:-1] != 0.0)
    assert slides.mean() > 0.5
    acceleration = np.diff(v) / 1e-4
    assert_allclose((drive - friction)[:-1][slides], 10.0 * acceleration[slides], atol=1e-8)
    rests = (v[:-1] == 0.0) & (v[1:] == 0.0)
    assert_allclose(m.friction[:-1][rests], drive[:-1][rests], atol=1e-9)


# --- servo ----------------------------------------------------------------------------------------

OFF = np.zeros(2001)
TIME = even(2.0, 1e-3)


def test_a_free_swing_loses_what_coulomb_friction_takes() -> None:
    """From turning point to turning point: m g l (cos q1 - cos q0) = K_c (|q0| + |q1|)."""
    s, K_c = servo.Servo(), 0.01
    m = servo.simulate(s, servo.Bam(K_c, 0.0), TIME, OFF, OFF, start=(1.2, 0.0), h=2e-6)
    turn = np.flatnonzero(m.velocity[:-1] * m.velocity[1:] < 0.0)[0]
    q1 = float(m.position[turn : turn + 2].min())
    lost = s.m * s.g * s.l * (np.cos(q1) - np.cos(1.2))
    assert q1 < -1.0
    assert lost == pytest.approx(K_c * (1.2 - q1), rel=1e-4)


def test_without_gravity_a_coast_ends_where_coulomb_says() -> None:
    s, K_c = servo.Servo(g=0.0), 0.02
    m = servo.simulate(s, servo.Bam(K_c, 0.0), TIME, OFF, OFF, start=(0.0, 3.0))
    inertia = s.m * s.l**2 + s.armature
    assert m.position[-1] == pytest.approx(0.5 * inertia * 9.0 / K_c, rel=1e-4)
    assert m.t[np.argmax(m.velocity == 0.0)] == pytest.approx(inertia * 3.0 / K_c, abs=2e-3)


def test_full_duty_ends_at_the_speed_that_the_winding_allows() -> None:
    s, bam = servo.Servo(g=0.0), servo.Bam(0.05, 0.01)
    m = servo.simulate(s, bam, TIME, np.full_like(TIME, 1e6))
    level = (s.k_t * s.vin / s.R - bam.K_c) / (bam.K_v + s.k_t**2 / s.R)
    assert m.velocity[-1] == pytest.approx(level, rel=1e-6)


def test_load_holds_a_weight_that_friction_alone_would_drop() -> None:
    """A held weight has t_e = -t_m, so gears press by 2 t_m; the drive may err by that share."""
    s = servo.Servo()
    q = 0.8
    t_e = -s.m * s.g * s.l * np.sin(q)
    share = s.R * -t_e / (s.k_t * s.vin)  # the duty that just balances
    goal = np.full_like(TIME, q + 1.1 * share / (s.duty * s.kp))
    least = 0.1 / 2.1  # a tenth of the load is to be borne, 2.1 times the load presses
    for K, still in ((1.05 * least, True), (0.95 * least, False)):
        m = servo.simulate(s, servo.Bam(0.0, 0.0, K_m=K, K_e=K), TIME, goal, start=(q, 0.0))
        assert (m.position[-1] == q) == still


# --- joint ----------------------------------------------------------------------------------------

FREE = coulomb_viscous(0.0)


def test_a_joint_under_pd_alone_swings_as_a_damped_oscillator() -> None:
    arm = joint.Joint(J=0.5, kp=50.0, kd=2.0)
    m = joint.simulate(arm, FREE, FREE, TIME, np.zeros_like(TIME), start=0.3)
    decay = 2.0 / (2.0 * 0.5)
    turn = np.sqrt(50.0 / 0.5 - decay**2)
    exact = 0.3 * np.exp(-decay * TIME) * (np.cos(turn * TIME) + decay / turn * np.sin(turn * TIME))
    assert_allclose(m.position, exact, atol=2e-5)


@pytest.mark.parametrize("hold", [1.0, 2.0])
def test_a_held_torque_is_the_one_of_its_sample_or_of_the_last(hold: float) -> None:
    t = np.concatenate([[0.0], np.cumsum(np.tile([0.02, 0.03], 20))])
    arm = joint.Joint(J=0.5, kp=10.0, kd=1.0, hold=hold)
    m = joint.simulate(arm, FREE, FREE, t, np.zeros_like(t), start=0.3, h=1e-6)
    q, w, last = 0.3, 0.0, None
    for k, span in enumerate(np.diff(t)):
        computed = -10.0 * q - w
        torque = computed if hold == 1.0 or last is None else last
        last = computed
        assert (m.position[k], m.velocity[k]) == pytest.approx((q, w), abs=5e-5)
        q += w * span + torque / 0.5 * span**2 / 2.0
        w += torque / 0.5 * span


def test_a_joint_waits_until_its_loop_asks_for_breakaway() -> None:
    arm = joint.Joint(J=0.1, g_sin=3.0, g_cos=2.0, g_0=0.4, kp=100.0, kd=0.0, gain=0.5)
    curve = Curve(2.0, 1.0, 0.1, 0.1)
    q0 = 0.4
    gravity = 3.0 * np.sin(q0) + 2.0 * np.cos(q0) + 0.4
    t = TIME
    start = gravity / 50.0  # the error at which gravity is just borne
    m = joint.simulate(arm, curve, curve, t, q0 + start + 0.05 * t, start=q0)
    assert t[np.argmax(m.velocity > 0.0)] == pytest.approx(2.0 / (50.0 * 0.05), abs=2e-3)


def test_each_slip_may_have_a_breakaway_of_its_own() -> None:
    factors = np.array([1.0, 1.3, 0.8])
    t = even(12.0, 1e-3)
    arm = joint.Joint(J=0.02, kp=30.0, kd=0.05)
    curve = Curve(1.0, 0.4, 0.01, 0.02)
    m = joint.simulate(arm, curve, curve, t, 0.05 * t, scatter=factors)
    begins = np.flatnonzero((m.velocity[:-1] == 0.0) & (m.velocity[1:] > 0.0))
    assert len(begins) > 5
    torques = m.force[begins]  # within a sample of breakaway, in which the command adds 1.5 mN m
    assert_allclose(torques, np.resize(factors, len(begins)), atol=2e-3)


# --- presliding -----------------------------------------------------------------------------------

LUGRE = presliding.LuGre(sigma_0=1e6, sigma_1=300.0, F_S=18.0, F_C=12.0, v_s=5e-3, F_V=50.0)


def test_dahl_out_of_rest_is_an_exponential() -> None:
    law, t = presliding.dahl(1e6, 12.0), np.array([0.0, 1.0])
    m = presliding.simulate(1.0, law, t, 11.0 * t)
    expected = 12.0 * (1.0 - np.exp(-1e6 * m.position / 12.0))
    assert_allclose(m.friction, expected, atol=1e-4)
    assert_allclose(m.friction[500:], m.force[500:], atol=0.02)  # slow: inertia is little


@pytest.mark.parametrize("speed", [1e-3, 5e-3, 2e-2])
def test_lugre_slides_on_its_stribeck_curve(speed: float) -> None:
    """Viscous enough that sliding is stable at any speed."""
    t, end = ramp(0.5, speed)
    m = presliding.simulate(1.0, LUGRE._replace(F_V=2e3), t, 0.0 * t, end, spring=1e6)
    curve = 12.0 + 6.0 * np.exp(-((speed / 5e-3) ** 2)) + 2e3 * speed
    assert m.velocity[-1] == pytest.approx(speed, rel=1e-6)
    assert m.friction[-1] == pytest.approx(curve, rel=1e-6)


def test_maxwell_slip_is_a_broken_line_and_unloads_at_twice_its_scale() -> None:
    levels, yields = np.array([3.0, 4.0, 5.0]), np.array([1e-6, 4e-6, 1.2e-5])
    t = np.array([0.0, 1.0, 3.0])
    m = presliding.simulate(0.1, (levels, yields, 20.0), t, np.array([0.0, 11.0, -11.0]))

    def virgin(x: Array) -> Array:
        broken: Array = np.minimum(x[:, None] / yields, 1.0) @ levels
        return broken

    turn = int(np.argmax(m.position))
    assert_allclose(m.friction[:turn], virgin(m.position[:turn]), atol=0.03)
    way = m.position[turn] - m.position[turn:]
    assert_allclose(m.friction[turn:], m.friction[turn] - 2.0 * virgin(way / 2.0), atol=0.03)


def test_bristles_spend_what_the_force_puts_in() -> None:
    t, force = sines(1.0, np.array([14.0]), np.array([3.0]))
    m = presliding.simulate(1.0, LUGRE, t, force, dt=1e-5)
    work = np.trapezoid(m.velocity * m.force, m.t)
    heat = np.trapezoid(m.velocity * m.friction, m.t)
    assert work == pytest.approx(heat + 0.5 * m.velocity[-1] ** 2, rel=1e-4)
    assert heat > 0.0


# --- cascade --------------------------------------------------------------------------------------


@pytest.mark.parametrize("late", [0, 1])
def test_a_cascade_without_friction_is_a_recursion(late: int) -> None:
    axis = cascade.Cascade(M=20.0, offset=2.0, kp=40.0, kv=50.0, gtau=30.0, delay=late * 1e-3)
    command = np.linspace(0.0, 0.05, 400) ** 2
    m = cascade.simulate(axis, FREE, FREE, command, h=1e-6)
    x, v, positions, volts = 0.0, 0.0, [0.0, 0.0, 0.0], [0.0]
    for k in range(400):
        assert m.position[k] == pytest.approx(x, abs=1e-8)
        positions.append(x)
        speed = (positions[-1] - positions[-3]) / 2e-3
        volts.append(float(np.clip(50.0 * (40.0 * (command[k] - x) - speed), -10.0, 10.0)))
        a = (30.0 * volts[-1 - late] - 2.0) / 20.0
        x, v = x + 1e-3 * v + 0.5e-6 * a, v + 1e-3 * a


# --- cylinder -------------------------------------------------------------------------------------

CYLINDER = cylinder.Cylinder(M=2.0, F_C=10.0, F_V=300.0, mu_p=5e-5, b=2e-5, offset=3.0, bore=0.025)


def test_a_steady_stroke_shows_the_friction_of_its_pressure() -> None:
    t, _, speed = strokes(np.array([0.05]), 0.02)
    for p in (1e5, 6e5):
        m = cylinder.simulate(CYLINDER, t, speed, np.full_like(t, p))
        area = np.pi * 0.025**2 / 4.0
        assert m.force[0] - p * area == pytest.approx(2e-5 * p + 3.0)
        balance = m.force - p * area - 2e-5 * p - 3.0
        for sign in (1.0, -1.0):
            steady = np.abs(m.velocity - sign * 0.05) < 1e-7
            assert steady.sum() > 50
            assert_allclose(balance[steady], sign * (10.0 + 5e-5 * p + 15.0), atol=0.01)


# --- the step -------------------------------------------------------------------------------------

TRAVEL, STROKE, SPEED = strokes(np.array([0.05, 0.2]), 0.02, ramp=0.05, pause=0.05)
ANGLE = sines(2.0, np.array([0.6]), np.array([0.5]))[1]
BAM = servo.Bam(0.02, 0.01, 0.03, 0.3, 1.0, 0.1, 0.2, 0.05, 0.1, 0.2, 0.3)
ARM = joint.Joint(J=0.05, g_sin=1.0, g_cos=2.0, kp=20.0, kd=0.5)
RUB = Curve(1.2, 0.7, 0.3, 0.1)
AXES: dict[str, Callable[[float], Array]] = {
    "slide bed": lambda h: slide_bed.simulate(
        slide_bed.Bed(), RIGHT, LEFT, *ramp(15.0, 5e-3), 0.0, h=h
    ).position,
    "driven": lambda h: driven.simulate(
        10.0, STRIBECK, STRIBECK, LOOP, TRAVEL, STROKE, h=h
    ).position,
    "cascade": lambda h: cascade.simulate(
        cascade.Cascade(delay=0.0), STRIBECK, STRIBECK, 0.1 * ANGLE, h=h
    ).position,
    "servo": lambda h: servo.simulate(servo.Servo(), BAM, TIME, ANGLE, h=h).position,
    "joint": lambda h: joint.simulate(ARM, RUB, RUB, TIME, ANGLE, h=h).position,
    "LuGre": lambda h: presliding.simulate(
        1.0, LUGRE, *sines(1.0, np.array([14.0]), np.array([2.0])), h=h
    ).position,
    "cylinder": lambda h: cylinder.simulate(
        CYLINDER, TRAVEL, SPEED, 4e5 + 1e5 * np.sin(20.0 * TRAVEL), h=h
    ).position,
}  # fmt: skip


@pytest.mark.parametrize("axis", AXES)
def test_a_quarter_of_the_step_has_a_quarter_of_the_error(axis: str) -> None:
    """Beside a step of h/16: (4 h - h/4) / (h - h/4) = 5 for a method of first order."""
    coarse, fine, finest = (AXES[axis](h) for h in (4e-5, 1e-5, 2.5e-6))
    coarse_error, error = (float(np.sqrt(np.mean((x - finest) ** 2))) for x in (coarse, fine))
    assert 3.5 < coarse_error / error < 7.0
    assert error < 3e-5 * np.ptp(finest)
