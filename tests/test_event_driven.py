"""The fast integrator against closed forms, against the plain reference, and against itself."""

from __future__ import annotations

import math
import threading

import numpy as np
import pytest

from patience import PATIENCE
from stribeck.friction import LAWS, Law
from stribeck.optimize.slopes import SHORT
from stribeck.rig.motion import reference, row_pool
from stribeck.rig.motion.command import Drive
from stribeck.rig.motion.drives import CLAMP, F_FM
from stribeck.rig.motion.event_driven import misfits, trajectories
from stribeck.rig.motion.track import Track, track
from stribeck.rig.slide_bed import PUBLISHED, SLIDE_BED, SlideBed, published_both
from stribeck.space import Array

COULOMB, STRIBECK = LAWS["coulomb-viscous"], LAWS["stribeck"]
DIRECTIONAL = LAWS["stribeck-directional"]

#: No motor, no dead band, one stiffness of 2 N/mm: a mass on a spring.
SPRING = SLIDE_BED.set(**{"J_m": 0, "D_m": 0, "F_fm": 0, "dv": 0, "k_hat+": 0, "k_hat-": 0})
K, M = 2000.0, 10.9
W = math.sqrt(K / M)
T = np.linspace(0.0, 3.0, 601)


def motion(
    rig: SlideBed, law: Law, p: list[float] | Array, command: Track, tolerance: float = 1.0
) -> tuple[Array, Array]:
    laws, c = rig.split(law, np.array([p]))
    x, v = trajectories(law, laws, c, command, tolerance)
    return x[0], v[0]


def resting_command(t: Array, x0: float) -> Track:
    """A command that stays at zero, for a slide released at rest from x0."""
    return track(Drive.line(0.0, 0.0, 1.0, 0.0), t, x0)


def box(n: int, seed: int) -> Array:
    """Parameter sets of the slide bed under the Stribeck law, uniform in its search ranges."""
    params = SLIDE_BED.parameters(STRIBECK)
    lower, upper = np.array([[q.lower, q.upper] for q in params]).T
    p: Array = lower + (upper - lower) * np.random.default_rng(seed).random((n, len(lower)))
    for k, q in enumerate(params):
        if q.fixed is not None:
            p[:, k] = q.fixed
    return p


def ramp(direction: int, seconds: float = 36.6, rate: float = 100.0) -> Track:
    """A ramp of 5 mm/s from the start of the paper's identification."""
    t = np.arange(round(seconds * rate) + 1) / rate
    x0 = 0.112 if direction > 0 else 0.325
    return track(Drive.line(0.0, x0, seconds, direction * 5e-3), t, x0)


# --- closed forms ---


@pytest.mark.parametrize("x0", [0.01, -0.01])
def test_a_free_mass_on_a_spring_swings_as_a_cosine(x0: float) -> None:
    x, v = motion(SPRING, COULOMB, [0, 0, K], resting_command(T, x0))
    np.testing.assert_allclose(x, x0 * np.cos(W * T), atol=2e-7)
    np.testing.assert_allclose(v[1:], -x0 * W * np.sin(W * T[1:]), atol=3e-6)


def test_viscous_friction_damps_the_swing() -> None:
    F_V = 60.0
    g = F_V / (2 * M)
    w = math.sqrt(W * W - g * g)
    x, _ = motion(SPRING, COULOMB, [0, F_V, K], resting_command(T, 0.01))
    exact = 0.01 * np.exp(-g * T) * (np.cos(w * T) + g / w * np.sin(w * T))
    np.testing.assert_allclose(x, exact, atol=2e-7)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_coulomb_friction_swings_about_shifted_centres_until_it_holds(sign: float) -> None:
    # Each half swing takes 2 F_C / k off the amplitude: 10, 6, 2 mm with F_C / k = 2 mm.
    x, v = motion(SPRING, COULOMB, [4.0, 0, K], resting_command(T, sign * 0.010))
    first, second = math.pi / W, 2 * math.pi / W
    exact = np.where(
        first > T, 2e-3 + 8e-3 * np.cos(W * T),
        np.where(second > T, -2e-3 + 4e-3 * np.cos(W * T), 2e-3),
    )  # fmt: skip
    np.testing.assert_allclose(x, sign * exact, atol=2e-7)
    assert not v[second * 1.01 < T].any()


def test_the_motor_adds_its_reflected_inertia() -> None:
    heavy = SPRING.set(J_m=4.17e-6, F_m_max=math.inf)
    w = math.sqrt(K / (M + SLIDE_BED["K_kt"] * 4.17e-6))
    x, _ = motion(heavy, COULOMB, [0, 0, K], resting_command(T, 0.01))
    np.testing.assert_allclose(x, 0.01 * np.cos(w * T), atol=2e-7)


def test_a_clamped_motor_is_a_constant_force_while_the_pull_is_strong() -> None:
    # 100 mm of stretch pull with 200 N; the clamp holds until the pull falls to 31.9 N.
    rig = SPRING.set(J_m=4.17e-6, F_m_max=30.0)
    K_J = SLIDE_BED["K_kt"] * 4.17e-6
    release = 30.0 * (M + K_J) / K_J / K  # the stretch where the clamp lets go
    end = math.acos((release - 0.015) / (0.1 - 0.015)) / W
    t = np.linspace(0, end, 200)
    x, _ = motion(rig, COULOMB, [0, 0, K], resting_command(t, -0.1))
    np.testing.assert_allclose(-x, 0.015 + 0.085 * np.cos(W * t), atol=2e-7)


def test_the_motors_own_friction_is_a_dead_zone_of_its_force() -> None:
    # k_hat = 3 N/mm behind 15 N: below 5 mm of stretch only k_spring pulls.
    rig = SPRING.set(**{"k_hat+": 3.0, "k_hat-": 3.0, "F_fm": 15.0})
    inside, _ = motion(rig, COULOMB, [0, 0, K], resting_command(T, 4.9e-3))
    np.testing.assert_allclose(inside, 4.9e-3 * np.cos(W * T), atol=2e-7)
    # Beyond, it starts as a swing of stiffness k_hat + k_spring about F_fm / (k_hat + k_spring).
    w = math.sqrt((K + 3000.0) / M)
    end = math.acos((5e-3 - 3e-3) / (10e-3 - 3e-3)) / w
    short = np.linspace(0, end, 200)
    outside, _ = motion(rig, COULOMB, [0, 0, K], resting_command(short, 10e-3))
    np.testing.assert_allclose(outside, 3e-3 + 7e-3 * np.cos(w * short), atol=2e-7)


@pytest.mark.parametrize(("direction", "sign"), [("right", 1), ("left", -1)])
def test_breakaway_comes_when_the_ramp_and_then_the_dead_band_say(
    direction: str, sign: int
) -> None:
    p, u, dv, dp = PUBLISHED[direction], 5e-3, SLIDE_BED["dv"], SLIDE_BED["dp"]
    k = SLIDE_BED["k_hat+" if sign > 0 else "k_hat-"] + p[5]
    reach = (p[0] + SLIDE_BED["F_fm"]) / k
    instant = reach / u + math.sqrt(2 * dp / (k * u))
    t = np.array([0.0, instant - 1e-9, instant + 1e-9, instant + 1e-3])
    _, v = motion(SLIDE_BED, STRIBECK, p, track(Drive.line(0, 0, 60, sign * u), t, 0.0))
    assert v[1] == 0.0
    assert v[2] * sign == pytest.approx(dv, rel=1e-4)
    assert v[3] * sign > dv


@pytest.mark.parametrize(("direction", "sign"), [("right", 1), ("left", -1)])
def test_time_between_slips(direction: str, sign: int) -> None:
    # From rest, the ramp has to make up what the slip took, and then the dead band's time.
    p, u = PUBLISHED[direction], 5e-3
    t = np.arange(0, 60, 1e-4)
    x, v = motion(SLIDE_BED, STRIBECK, p, track(Drive.line(0, 0, 60, sign * u), t, 0.0))
    moving = v != 0
    begin = np.flatnonzero(moving[1:] & ~moving[:-1]) + 1
    end = np.flatnonzero(~moving[1:] & moving[:-1]) + 1
    k = SLIDE_BED["k_hat+" if sign > 0 else "k_hat-"] + p[5]
    after = u * t[end[:-1]] - abs(x[end[:-1]])
    reach = (p[0] + SLIDE_BED["F_fm"]) / k
    wait = (reach - after) / u + math.sqrt(2 * SLIDE_BED["dp"] / (k * u))
    np.testing.assert_allclose(t[begin[1:]] - t[end[:-1]], wait, atol=2.5e-4)


def test_steady_sliding_has_the_stretch_that_friction_asks_for() -> None:
    # Coulomb friction alone cannot stick again under viscous damping strong enough.
    F_C, F_V, u = 20.0, 3000.0, 5e-3
    t = np.linspace(0, 40, 401)
    command = track(Drive.line(0, 0, 40, u), t, 0.0)
    x, v = motion(SPRING, COULOMB, [F_C, F_V, K], command)
    assert v[-1] == pytest.approx(u, rel=1e-5)
    assert u * t[-1] - x[-1] == pytest.approx((F_C + F_V * u) / K, rel=1e-5)


def test_a_slide_that_never_breaks_loose_stays_and_scores_what_was_measured() -> None:
    t = np.linspace(0, 5, 101)
    measured = 0.1 + 1e-3 * np.sin(t)
    command = track(Drive.line(0, 0.1, 5, 5e-3), t, 0.1, measured)  # 25 mm: not enough
    x, v = motion(SLIDE_BED, STRIBECK, PUBLISHED["right"], command)
    assert (x == 0.1).all()
    assert not v.any()
    (sse,) = SLIDE_BED.misfits(STRIBECK, PUBLISHED["right"][None], (command,))
    assert sse == pytest.approx(np.sum((measured - 0.1) ** 2), rel=1e-10)


@pytest.mark.parametrize("law", [COULOMB, STRIBECK], ids=lambda law: law.name)
def test_energy_is_accounted_for_and_friction_makes_none(law: Law) -> None:
    # Drive force F(e) has a potential U(e); with the clamp open the motor is mass and damping:
    # work of the command = change of U + kinetic energy + what friction and D_m take.
    rig = SLIDE_BED.set(dv=0, F_m_max=math.inf)
    rng = np.random.default_rng(11)
    t = np.arange(0.0, 8.0, 2e-4)
    mass, D = rig["m"] + rig["K_kt"] * rig["J_m"], rig["K_kt"] * rig["D_m"]
    for _ in range(12):
        F_C, F_V, k = rng.uniform(5, 60), rng.uniform(100, 900), rng.uniform(100, 1500)
        p = [F_C, F_V, k] if law is COULOMB else [2 * F_C, F_C, F_V, 2e-3, 1.0, k]
        knots = np.array([0.0, 2.0, 4.5, 8.0])
        drive = Drive(knots, rng.uniform(-0.05, 0.05, 4))
        command = track(drive, t, rng.uniform(-0.05, 0.05))
        x, v = motion(rig, law, p, command)
        laws, c = rig.split(law, np.array([p]))
        e = drive(t) - x
        F = np.array([reference.drive(c[0], s) for s in e])
        work = np.sum(0.5 * (F[1:] + F[:-1]) * np.diff(drive(t)))
        potential = np.sum(0.5 * (F[1:] + F[:-1]) * np.diff(e))
        lost = (law.friction(v, laws[0]) + D * v) * v
        assert (lost >= 0).all()
        dissipated = np.sum(0.5 * (lost[1:] + lost[:-1])) * 2e-4
        kinetic = 0.5 * mass * (v[-1] ** 2 - v[0] ** 2)
        scale = np.sum(np.abs(0.5 * (F[1:] + F[:-1]) * np.diff(x))) + 1e-3
        assert work == pytest.approx(potential + kinetic + dissipated, abs=2e-4 * scale)


# --- symmetries and what must not matter ---


def test_left_is_the_mirror_of_right() -> None:
    rng = np.random.default_rng(3)
    for _ in range(20):
        right, left = box(2, int(rng.integers(1 << 30)))
        p = np.concatenate([right[:4], left[:4], [1.0], [right[5], left[5]]])
        q = np.concatenate([left[:4], right[:4], [1.0], [left[5], right[5]]])
        mirrored = SLIDE_BED.set(**{"k_hat+": 2.8, "k_hat-": 3.5})
        drive = Drive(np.array([0.0, 9.0, 18.0, 20.0]), rng.uniform(-0.06, 0.06, 4))
        t = np.linspace(0, 20, 801)
        x, v = motion(SLIDE_BED, DIRECTIONAL, p, track(drive, t, 0.0))
        y, w = motion(mirrored, DIRECTIONAL, q, track(Drive(drive.t, -drive.x), t, 0.0))
        np.testing.assert_allclose(y, -x, atol=1e-9)
        np.testing.assert_allclose(w, -v, atol=1e-7)


def test_rows_are_the_same_bits_whatever_the_batch_and_the_threads(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    command = ramp(1, 20)
    laws, c = SLIDE_BED.split(STRIBECK, box(41, 5))
    alone = np.array(
        [misfits(STRIBECK, a[None], b[None], command)[0] for a, b in zip(laws, c, strict=True)]
    )
    x = trajectories(STRIBECK, laws, c, command)[0]
    for n in (1, 2, 7):
        pool = row_pool.RowPool(n)
        monkeypatch.setattr(row_pool, "pool", lambda pool=pool: pool)
        for _ in range(10):  # whichever thread takes a row
            assert misfits(STRIBECK, laws, c, command).tobytes() == alone.tobytes()
        assert trajectories(STRIBECK, laws, c, command)[0].tobytes() == x.tobytes()
        pool.dismiss()
    monkeypatch.undo()
    order = np.random.default_rng(0).permutation(41)
    assert misfits(STRIBECK, laws[order], c[order], command).tobytes() == alone[order].tobytes()


@pytest.mark.parametrize("masked", [False, True])
def test_misfits_are_the_squares_of_the_residuals(masked: bool) -> None:
    rng = np.random.default_rng(8)
    base = ramp(-1)
    measured = 0.325 - 5e-3 * base.t + 5e-3 * rng.standard_normal(len(base.t))
    score = (rng.random(len(base.t)) < 0.4).astype(float) if masked else np.ones(len(base.t))
    command = track(Drive(base.knots_t, base.knots_x), base.t, base.x0, measured, score)
    laws, c = SLIDE_BED.split(STRIBECK, box(50, 9))
    x, _ = trajectories(STRIBECK, laws, c, command)
    np.testing.assert_allclose(
        misfits(STRIBECK, laws, c, command), ((x - measured) ** 2 * score).sum(axis=1), rtol=1e-10
    )


def test_sampling_does_not_change_the_motion() -> None:
    fine = ramp(1, 36.0, 1000.0)
    coarse = ramp(1, 36.0, 10.0)
    x, _ = motion(SLIDE_BED, STRIBECK, PUBLISHED["right"], fine)
    y, _ = motion(SLIDE_BED, STRIBECK, PUBLISHED["right"], coarse)
    np.testing.assert_allclose(y, x[::100], atol=1e-12)


def test_knots_on_a_line_do_not_change_the_motion() -> None:
    command = ramp(1)
    knots = Drive(command.t, command.t * 5e-3 + 0.112)
    x, _ = motion(SLIDE_BED, STRIBECK, PUBLISHED["right"], command)
    y, _ = motion(SLIDE_BED, STRIBECK, PUBLISHED["right"], track(knots, command.t, 0.112))
    np.testing.assert_allclose(y, x, atol=1e-7)


def test_uneven_samples_see_the_same_motion() -> None:
    fine = ramp(1, 36.0, 1000.0)
    x, v = motion(SLIDE_BED, STRIBECK, PUBLISHED["right"], fine)
    rng = np.random.default_rng(4)
    sparse = np.sort(np.append(0, rng.choice(len(fine.t), 300, replace=False)))
    gaps = np.concatenate([np.arange(0, 3000), np.arange(30000, 30040), np.arange(35990, 36000)])
    for at in (sparse, np.unique(np.exp(rng.uniform(0, 10.4, 500)).astype(int)), gaps):
        at = np.unique(np.append(0, at))  # noqa: PLW2901 - a motion starts at its first sample
        command = track(Drive(fine.knots_t, fine.knots_x), fine.t[at], fine.x0)
        y, w = motion(SLIDE_BED, STRIBECK, PUBLISHED["right"], command)
        np.testing.assert_allclose(y, x[at], atol=1e-12)
        np.testing.assert_allclose(w, v[at], atol=1e-9)


@pytest.mark.parametrize("knots", [2, 63, 64, 65, 129, 4001])
@pytest.mark.parametrize("dv", [0.0, 0.1])
def test_runs_of_the_command_are_only_passed_where_nothing_happens(knots: int, dv: float) -> None:
    rig, rng = SLIDE_BED.set(dv=dv), np.random.default_rng(knots)
    at = np.sort(rng.uniform(0.0, 60.0, knots))
    to = 0.06 * np.sin(0.3 * at) + 1e-3 * rng.standard_normal(knots)
    command = track(Drive(at, to), np.linspace(0.0, 60.0, 601), 0.0)
    p = published_both()
    x, _ = motion(rig, DIRECTIONAL, p, command)
    y, _ = motion(rig, DIRECTIONAL, p, command._replace(extremes=np.empty((2, 0))))
    assert x.tobytes() == y.tobytes()
    if knots > 2:
        assert np.ptp(x) > 1e-2


def test_a_slip_read_again_is_the_slip_integrated_again() -> None:
    # A corner too small to matter, once a second, and every slip is another one.
    command = ramp(1)
    knots = np.arange(0.0, 37.0, 0.2)
    bend = 1e-10 * np.random.default_rng(1).standard_normal(len(knots))
    cornered = track(Drive(knots, 0.112 + 5e-3 * knots + bend), command.t, 0.112)
    laws, c = SLIDE_BED.split(STRIBECK, box(30, 3))
    x, _ = trajectories(STRIBECK, laws, c, command)
    y, _ = trajectories(STRIBECK, laws, c, cornered)
    assert max(rms(a, b) for a, b in zip(x, y, strict=True)) < 2e-7


def test_finite_differences_see_the_motion_and_not_the_integrator() -> None:
    # Steps as least squares takes them. A share of tools/kernel_study.py.
    command = ramp(-1)
    params = SLIDE_BED.parameters(STRIBECK)
    for p in box(20, 21):
        sets = np.repeat(p[None], 6, axis=0)
        for i, k in enumerate((0, 1, 2, 3, 5)):
            sets[i + 1, k] += SHORT * (params[k].upper - params[k].lower)
        laws, c = SLIDE_BED.split(STRIBECK, sets)
        x, _ = trajectories(STRIBECK, laws, c, command)
        y, _ = trajectories(STRIBECK, laws, c, command, 1e-4)
        slopes = y[1:] - y[0]
        errors = np.linalg.norm(x[1:] - x[0] - slopes, axis=1)
        assert (errors < 2e-3 * np.linalg.norm(slopes, axis=1)).all(), p


def test_a_clock_that_counts_from_1970_changes_nothing() -> None:
    command = ramp(-1)
    late = command._replace(t=command.t + 1.75e9, knots_t=command.knots_t + 1.75e9)
    x, _ = motion(SLIDE_BED, STRIBECK, PUBLISHED["left"], command)
    y, _ = motion(SLIDE_BED, STRIBECK, PUBLISHED["left"], late)
    np.testing.assert_allclose(y, x, atol=1e-7)  # such a clock ticks in 0.24 us
    z, _ = reference.trajectory(
        STRIBECK,
        PUBLISHED["left"][:5],
        SLIDE_BED.split(STRIBECK, PUBLISHED["left"])[1][0],
        late,
        1e-4,
    )
    assert np.abs(z - x).max() < 1e-4


@pytest.mark.parametrize("hours", [0, 3, 100])
@pytest.mark.parametrize("k_spring", [0.0, 968.0])
@pytest.mark.parametrize("F_S", [0.0, 144.5463])
def test_a_long_wait_before_the_ramp_changes_nothing(
    hours: int, k_spring: float, F_S: float
) -> None:
    # Late on a clock its last digit is coarse; with k_spring = 0 and no friction the slide breaks
    # loose exactly where the motor's dead zone ends.
    wait = 3600.0 * hours
    p = PUBLISHED["right"].copy()
    p[0], p[1], p[5] = F_S, min(F_S, p[1]), k_spring
    after = np.linspace(0, 40, 401)
    turns = np.array([0.0, 12.0, 24.0, 36.0])
    command = np.array([0.0, 0.06, -0.06, 0.06])
    at_once = track(Drive(turns, command), after, 0.0)
    late = track(
        Drive(np.append(0.0, wait + 1.0 + turns), np.append(0.0, command)),
        np.append(0.0, wait + 1.0 + after),
        0.0,
    )
    x, _ = motion(SLIDE_BED, STRIBECK, p, at_once)
    y, _ = motion(SLIDE_BED, STRIBECK, p, late)
    np.testing.assert_allclose(y[1:], x, atol=2e-8)


# --- the threads ---


def test_what_fails_in_another_thread_fails_for_the_caller() -> None:
    pool, started = row_pool.RowPool(2), threading.Event()
    me = threading.current_thread()

    def work(counter: Array) -> None:
        del counter
        if threading.current_thread() is not me:
            started.set()
            raise MemoryError("no room")
        assert started.wait(PATIENCE)

    with pytest.raises(MemoryError, match="no room"):
        pool.share(work, 100, ())
    pool.dismiss()


def test_a_caller_does_not_wait_for_threads_that_are_busy_elsewhere() -> None:
    pool, started, go_on = row_pool.RowPool(2), threading.Event(), threading.Event()
    callers = {threading.current_thread()}

    def long(counter: Array) -> None:
        del counter
        if threading.current_thread() not in callers:
            started.set()
            assert go_on.wait(PATIENCE)
        assert started.wait(PATIENCE)

    def short(counter: Array) -> None:
        while row_pool.next_row(counter) < 100:
            pass

    caller = threading.Thread(target=pool.share, args=(long, 100, ()))
    callers.add(caller)
    caller.start()
    assert started.wait(PATIENCE)
    pool.share(short, 100, ())
    assert caller.is_alive()
    go_on.set()
    caller.join(PATIENCE)
    assert not caller.is_alive()
    pool.dismiss()


# --- what cannot be simulated ---


@pytest.mark.parametrize(
    ("column", "constant"),
    [
        (column, constant)
        for column in range(10)
        for constant in (math.nan, math.inf, -1.0)
        if constant != math.inf or column not in (F_FM, CLAMP)  # a limit may be open
    ],
)
def test_an_impossible_constant_gives_nan_and_no_hang(column: int, constant: float) -> None:
    command = ramp(1, 20)
    laws, c = SLIDE_BED.split(STRIBECK, np.array([PUBLISHED["right"]] * 3))
    finite = misfits(STRIBECK, laws, c, command)
    c[1, column] = constant
    sse = misfits(STRIBECK, laws, c, command)
    assert np.isnan(sse[1])
    assert sse[0] == finite[0] == sse[2]


@pytest.mark.parametrize(
    ("name", "value"),
    [("F_S", math.nan), ("F_S", math.inf), ("F_S", -1.0), ("F_C", math.nan), ("F_V", math.nan),
     ("v_SS", 0.0), ("v_SS", math.nan), ("exponent", math.nan), ("F_V", 1e300), ("F_V", -1e12)],
)  # fmt: skip
def test_an_impossible_law_gives_nan_and_no_hang(name: str, value: float) -> None:
    p = np.array([PUBLISHED["right"]] * 3)
    p[1, STRIBECK.names.index(name)] = value
    sse = SLIDE_BED.misfits(STRIBECK, p, (ramp(1, 20),))
    assert np.isnan(sse).tolist() == [False, True, False]


def test_no_candidates_no_costs() -> None:
    assert SLIDE_BED.misfits(STRIBECK, np.empty((0, 6)), (ramp(1, 20),)).shape == (0,)


# --- against the reference ---


def rms(x: Array, y: Array) -> float:
    return float(np.sqrt(np.mean((x - y) ** 2)))


@pytest.mark.parametrize("direction", [1, -1])
def test_fast_and_reference_agree_within_a_micrometre_over_the_box(direction: int) -> None:
    # A share of tools/kernel_study.py, which does 1,000 sets a direction.
    command, p = ramp(direction), box(60, 100 + direction)
    laws, c = SLIDE_BED.split(STRIBECK, p)
    x, _ = trajectories(STRIBECK, laws, c, command)
    for k in range(len(p)):
        y, _ = reference.trajectory(STRIBECK, laws[k], c[k], command, 4e-5)
        assert rms(x[k], y) < 1e-6, p[k]


def test_the_reference_converges_to_the_fast_motion_at_second_order() -> None:
    command = ramp(1)
    laws, c = SLIDE_BED.split(STRIBECK, box(10, 77))
    x, _ = trajectories(STRIBECK, laws, c, command, 1e-3)
    steps = np.array([1e-4, 5e-5, 2.5e-5])  # coarser ones do not resolve the slow end of a slip
    error = [
        np.median([
            rms(x[k], reference.trajectory(STRIBECK, laws[k], c[k], command, dt)[0])
            for k in range(len(laws))
        ])
        for dt in steps
    ]  # fmt: skip
    order = np.polyfit(np.log(steps), np.log(error), 1)[0]
    assert 1.9 < order < 2.1


def test_the_fast_motion_converges_with_its_tolerance() -> None:
    command = ramp(-1)
    laws, c = SLIDE_BED.split(STRIBECK, box(40, 78))
    best, _ = trajectories(STRIBECK, laws, c, command, 1e-4)
    worst = [
        np.abs(trajectories(STRIBECK, laws, c, command, s)[0] - best).max() for s in (100, 1, 0.01)
    ]
    assert worst[0] > 5 * worst[1] > 25 * worst[2]
    assert worst[1] < 1e-6


def test_the_printed_scheme_does_not_converge() -> None:
    command = ramp(1)
    (p,), (c,) = SLIDE_BED.split(STRIBECK, PUBLISHED["right"])
    (x,), _ = trajectories(STRIBECK, p[None], c[None], command)
    for dt in (1e-3, 1e-4, 1e-5):
        y, _ = reference.trajectory(STRIBECK, p, c, command, dt, "paper")
        assert rms(x, y) > 1e-3, dt


def test_the_compiled_reference_is_the_plain_one() -> None:
    command = ramp(1, 9.0)
    (p,), (c,) = SLIDE_BED.split(STRIBECK, PUBLISHED["right"] * [0.5, 1, 1, 1, 1, 1])
    plain, _ = reference.implicit(
        STRIBECK.slip, p, c, command.knots_t, command.knots_x, command.t, command.x0, 5e-4
    )
    fast, _ = reference.trajectory(STRIBECK, p, c, command, 5e-4)
    assert np.ptp(plain) > 5e-3
    np.testing.assert_allclose(plain, fast, atol=1e-12)


@pytest.mark.parametrize(
    "points",
    [
        [(0, 0), (7.45, 0.0372), (20, 0.0372)],
        [(0, 0), (7.9, 0.04), (16, -0.05), (20, -0.05)],
        [(0, 0), (7.6, 0.038), (8.0, -0.08), (20, 0.0)],
        [(0, 0.0375), (3, 0.0375), (6, 0.0), (20, -0.06)],
        [(0, 0.2), (20, 0.2)],
        [(0, 0), (0.1, 0.03), (0.2, -0.03), (0.3, 0.1), (20, 0.1)],
    ],
    ids=["stops at breakaway", "reverses", "reverses hard", "waits", "beyond breakaway", "jerks"],
)  # fmt: skip
@pytest.mark.parametrize("dv", [0.0, 0.1, 1.0])
def test_commands_that_stop_turn_and_jerk(points: list[tuple[float, float]], dv: float) -> None:
    knots = np.array(points, dtype=float)
    rig = SLIDE_BED.set(dv=dv)
    p = np.concatenate([PUBLISHED["right"][:4], PUBLISHED["left"][:4], [1.0, 968.0, 554.0]])
    command = track(Drive(knots[:, 0].copy(), knots[:, 1].copy()), np.linspace(0, 20, 1001), 0.0)
    x, _ = motion(rig, DIRECTIONAL, p, command)
    laws, c = rig.split(DIRECTIONAL, p)
    y, _ = reference.trajectory(DIRECTIONAL, laws[0], c[0], command, 5e-5)
    assert rms(x, y) < 2e-6


@pytest.mark.parametrize("seed", range(40))
def test_odd_rigs_and_laws_under_odd_commands(seed: int) -> None:
    """No motor or an open clamp, no or a wide dead zone and dead band, no friction on a side."""
    rng = np.random.default_rng(seed)
    at = np.concatenate([[0.0], np.cumsum(rng.exponential(2.0, 5) + 0.05)])
    to = 0.1 + np.cumsum(np.concatenate([[0.0], rng.normal(0, 0.03, 5) * rng.integers(0, 2, 5)]))
    rig = SLIDE_BED.set(
        **{
            "J_m": float(rng.choice([0, 1e-6, 4.17e-6])),
            "D_m": float(rng.choice([0, 2.6e-6])),
            "F_fm": float(rng.choice([0, 23.5, 60, 200])),
            "F_m_max": float(rng.choice([0, 5, 30, math.inf])),
            "dv": float(rng.choice([0, 0.01, 0.1, 1.0])),
            "dp": float(rng.choice([0, 1e-4, 1.09e-3, 0.01826, 0.1826])),
            "k_hat+": float(rng.choice([0, 1.0, 3.5])),
            "k_hat-": float(rng.choice([0, 2.8, 3.5])),
        }
    )

    def one_side() -> list[float]:
        F_C = rng.uniform(0, 80) * rng.integers(0, 2)
        F_S = F_C + rng.uniform(1, 100)
        return [F_S, F_C, rng.uniform(0, 1000) * rng.integers(0, 2), rng.uniform(5e-4, 2e-2)]

    p = [*one_side(), *one_side(), float(rng.choice([1.0, 2.0])), *rng.uniform(50, 1500, 2)]
    command = track(Drive(at, to), np.linspace(0, 10, 501), 0.1 + rng.normal(0, 0.02))
    x, _ = motion(rig, DIRECTIONAL, p, command)
    laws, c = rig.split(DIRECTIONAL, np.array(p))
    y, _ = reference.trajectory(DIRECTIONAL, laws[0], c[0], command, 2.5e-5)
    assert rms(x, y) < 5e-6


def test_a_piece_entered_at_one_bend_may_be_left_by_the_other() -> None:
    # The command stops with the slide level with it at speed: e = 0 exactly, and the step that
    # starts there crosses the dead zone of the motor's own friction.
    rig = SLIDE_BED.set(**{"k_hat-": 3.5})
    drive = Drive(
        np.array([0.0, 1.2195, 3.6623, 5.0993, 5.2467]), np.array([0.1, 0.1, 0.099, 0.099, 0.1444])
    )
    p = [13.08, 13.08, 0.0, 0.016, 43.8, 0.0, 323.8, 0.0096, 2.0, 107.5, 520.8]
    command = track(drive, np.linspace(0, 10, 501), 0.0864)
    x, _ = motion(rig, DIRECTIONAL, p, command)
    laws, c = rig.split(DIRECTIONAL, np.array(p))
    y, _ = reference.trajectory(DIRECTIONAL, laws[0], c[0], command, 2.5e-5)
    assert rms(x, y) < 2e-6


@pytest.mark.parametrize(
    ("setting", "threads"), [("1", 1), ("9999", None), ("", None), ("0", None), ("2,1", None)]
)
def test_the_kernel_takes_no_more_threads_than_it_is_told(
    setting: str, threads: int | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("OMP_NUM_THREADS", raising=False)
    all_of_them = row_pool.threads()
    monkeypatch.setenv("OMP_NUM_THREADS", setting)
    assert row_pool.threads() == (threads or all_of_them)
