"""The gate of a log: faults that sensors make of a foreign motion, each told or put right."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from foreign import cylinder, driven, joint, presliding, sensors, servo, slide_bed
from foreign.friction import Curve, coulomb_viscous
from foreign.sensors import Table
from foreign.strokes import even, sines, strokes
from stribeck import RIGS, Recording, identify, read
from stribeck.data import segment
from stribeck.data.gate import faults, mended
from stribeck.data.gate.cut_noise import cut_noise
from stribeck.data.resolution import step as step_of
from stribeck.rig.twin import TestBed
from stribeck.space import Array

REAL = Path(__file__).parents[2] / "shared" / "data"
LOOP = driven.Loop(kp=4e4, kd=2e3, mass_ff=9.0)
BED = (Curve(144.5463, 47.8514, 958.3, 1.0964e-3), Curve(152.2804, 40.4153, 975.7, 3.21475e-3))
ANGLES = ("servo", "swing", "joint")


def _driven(rng: np.random.Generator) -> Table:
    plus, minus = coulomb_viscous(20.0, 60.0), coulomb_viscous(25.0, 90.0)
    motion = driven.simulate(
        10.0, plus, minus, LOOP, *sines(10.0, np.array([0.1, 0.03]), np.array([0.3, 0.7]))
    )
    table = sensors.quantised(motion._asdict(), "position", 1e-6)
    return sensors.noisy(table, "force", 0.3, rng)


def _strokes(rng: np.random.Generator) -> Table:
    both = coulomb_viscous(20.0, 60.0)
    t, command, _ = strokes(np.array([0.05, 0.1, 0.2, 0.3]), 0.2)
    motion = driven.simulate(10.0, both, both, LOOP, t, command)
    table = sensors.quantised(motion._asdict(), "position", 1e-6)
    return sensors.noisy(table, "force", 0.3, rng)


def _bed(rng: np.random.Generator) -> Table:
    times, command = np.array([0.0, 60.0, 62.0, 122.0]), np.array([0.0, 0.3, 0.3, 0.0])
    table = slide_bed.simulate(slide_bed.Bed(), *BED, times, command, 0.0, h=2e-5)._asdict()
    del table["force"]
    return sensors.quantised(sensors.noisy(table, "position", 1e-4, rng), "position", 1e-5)


def _servo(rng: np.random.Generator) -> Table:
    t, goal = sines(6.0, np.array([1.0, 0.3]), np.array([0.4, 1.1]), dt=0.005)
    table = servo.simulate(servo.Servo(), servo.Bam(0.03, 0.008), t, goal)._asdict()
    return sensors.quantised(sensors.noisy(table, "position", 3e-4, rng), "position", 1.534e-3)


def _swing(rng: np.random.Generator) -> Table:
    t = 0.005 * np.arange(1200)
    goal, on = np.where(t < 2.0, 1.2, 0.0), (t < 2.0).astype(float)
    table = servo.simulate(servo.Servo(), servo.Bam(0.01, 0.002), t, goal, on)._asdict()
    return sensors.quantised(sensors.noisy(table, "position", 3e-4, rng), "position", 1.534e-3)


def _joint(rng: np.random.Generator) -> Table:
    t = 0.02 * np.arange(6000)
    arm, rub = joint.Joint(J=0.3, g_sin=1.0, g_cos=2.0), Curve(2.0, 1.2, 0.5, 0.05)
    table = joint.simulate(arm, rub, rub, t, 0.3 * np.sin(0.06 * np.pi * t), h=2e-5)._asdict()
    return sensors.noisy(sensors.quantised(table, "position", 3.835e-4), "force", 0.02, rng)


def _presliding(rng: np.random.Generator) -> Table:
    t = even(10.0, 2e-3)
    law = presliding.LuGre(1.2e6, 600.0, 18.0, 12.0, 2e-2, 50.0)
    force = (2.0 + 0.6 * t) * np.sin(np.pi * t)
    table = presliding.simulate(5.0, law, t, force, dt=2e-3)._asdict()
    return sensors.noisy(table, "position", 3e-8, rng)


def _cylinder(rng: np.random.Generator) -> Table:
    axis = cylinder.Cylinder(M=20.0, F_C=10.0, F_V=300.0, mu_p=5e-5, b=2e-5, offset=3.0)
    t, _, speed = strokes(np.array([0.05, 0.1, 0.2]), 0.05)
    table = cylinder.simulate(axis, t, speed, np.full_like(t, 3e5))._asdict()
    del table["command"]  # a machine's head is none that the log knows
    return sensors.noisy(sensors.quantised(table, "position", 2e-6), "force", 0.1, rng)


MAKERS = {
    "driven": _driven, "strokes": _strokes, "bed": _bed, "servo": _servo, "swing": _swing,
    "joint": _joint, "presliding": _presliding, "cylinder": _cylinder,
}  # fmt: skip


@pytest.fixture(scope="module")
def tables() -> dict[str, Table]:
    return {name: make(np.random.default_rng(7)) for name, make in MAKERS.items()}


def log(table: Table, axis: str) -> Recording:
    names = ("position", "command", "force", "pressure")
    channels: dict[str, Any] = {n: table[n] for n in names if n in table}
    return Recording(t=table["t"], **channels, rotary=axis in ANGLES)


def fastest(table: Table) -> float:
    """When the axis is fastest in the middle fifth of its log."""
    t, n = table["t"], len(table["t"])
    v = np.abs(np.gradient(table["position"], t))[2 * n // 5 : 3 * n // 5]
    return float(t[2 * n // 5 + int(np.argmax(v))])


def kinds(recording: Recording) -> set[str]:
    return {fault.kind for fault in faults(mended(recording)) if fault.harmful}


@pytest.mark.parametrize("axis", MAKERS)
@pytest.mark.parametrize("seed", [1, 2])
def test_a_clean_log_passes(axis: str, seed: int) -> None:
    clean = log(MAKERS[axis](np.random.default_rng(seed)), axis)
    assert mended(clean) is clean
    assert not faults(clean)


@pytest.mark.parametrize("axis", MAKERS)
def test_a_log_is_cut_where_its_position_starts_anew(axis: str, tables: dict[str, Table]) -> None:
    table = tables[axis]
    at = fastest(table)
    start = float(np.interp(at, table["t"], table["position"]))
    for other in (
        sensors.reset(table, "position", at, start + 0.4 * np.ptp(table["position"])),
        sensors.jumped(table, "position", at, -0.1 * np.ptp(table["position"])),
    ):
        whole = log(other, axis)
        kept = mended(whole)
        assert len(kept) < len(whole)
        assert min(abs(kept.t[0] - at), abs(kept.t[-1] - at)) < 0.05
        assert f"at {at:.4g} s" in kept.notes[-1]
        assert not kinds(kept)


@pytest.mark.parametrize(("share", "first"), [(0.4, True), (0.1, False)])
def test_beside_a_command_the_piece_counts_that_stands_to_it_as_before(
    share: float, first: bool, tables: dict[str, Table]
) -> None:
    """Beyond a reset the error of the loop is off by it; a short beginning is not all there is."""
    table = tables["driven"]
    at = float(table["t"][0] + share * np.ptp(table["t"]))
    start = float(np.interp(at, table["t"], table["position"])) + 0.4 * np.ptp(table["position"])
    other = sensors.reset(table, "position", at, start)
    whole = log(other, "driven")
    kept = mended(replace(whole, command=table["command"]))
    assert (kept.t[0] < at) == first
    assert mended(replace(whole, command=None)).t[0] >= at


@pytest.mark.parametrize("axis", MAKERS)
def test_a_position_that_stood_still_and_caught_up_is_cut_out(
    axis: str, tables: dict[str, Table]
) -> None:
    table = tables[axis]
    at, span = fastest(table), float(np.ptp(table["t"]))
    kept = mended(log(sensors.frozen(table, "position", at, at + 0.05 * span), axis))
    assert "stands still" in kept.notes[-1]
    assert kept.t[-1] <= at + 0.01 * span or kept.t[0] >= at + 0.04 * span


@pytest.mark.parametrize("axis", MAKERS)
def test_rows_that_are_missing_are_told_however_the_clock_runs(
    axis: str, tables: dict[str, Table]
) -> None:
    table = tables[axis]
    at, span = fastest(table), float(np.ptp(table["t"]))
    gap = sensors.gap(table, at, at + 0.04 * span)
    (fault,) = faults(mended(log(gap, axis)))
    assert fault.kind == "gap"
    assert fault.size == pytest.approx(0.04 * span, rel=0.1)
    closed = log(gap | {"t": table["t"][: len(gap["t"])]}, axis)
    assert len(mended(closed)) < len(closed)


@pytest.mark.parametrize("axis", MAKERS)
def test_a_wrap_is_undone(axis: str, tables: dict[str, Table]) -> None:
    table = tables[axis]
    x = table["position"]
    low = float(x.min() + 0.3 * np.ptp(x))
    wrap = log(sensors.wrapped(table, "position", low, float(low + 0.5 * np.ptp(x))), axis)
    kept = mended(wrap)
    assert "unwrapped" in kept.notes[-1]
    assert len(kept) == len(wrap)
    noise = 5e-3 * np.ptp(x)
    assert_allclose(kept.position - kept.position[0], x - x[0], atol=noise)


def test_an_angle_that_wraps_once_is_unwrapped_with_its_command() -> None:
    t: Array = 0.002 * np.arange(4000, dtype=float)
    angle = 3.0 * np.sin(t)  # passes pi / 2 + 1
    turned = [np.mod(a + np.pi, 2 * np.pi) - np.pi for a in (angle + 1.0, angle + 1.001)]
    kept = mended(Recording(t, turned[0], turned[1], rotary=True))
    for channel, truth in ((kept.position, angle + 1.0), (kept.command, angle + 1.001)):
        assert channel is not None
        assert_allclose(channel, truth, atol=1e-9)


@pytest.mark.parametrize("peak", [100.0, 250.0, 600.0, 1200.0])
def test_a_motor_that_turns_fast_is_unwrapped(peak: float) -> None:
    """Its wraps are too many to stand apart: one each six samples of the fastest, at 1 kHz."""
    t: Array = 1e-3 * np.arange(8000, dtype=float)
    noise = 1e-3 * np.random.default_rng(2).normal(size=len(t))
    truth = peak / np.pi * (1.0 - np.cos(np.pi * t)) + noise
    table = sensors.quantised({"t": t, "position": truth}, "position", 2 * np.pi / 4096)
    table = sensors.wrapped(table, "position", 0.0, 2 * np.pi)
    kept = mended(Recording(t, table["position"], rotary=True))
    assert "unwrapped" in kept.notes[-1]
    assert_allclose(kept.position - kept.position[0], truth - truth[0], atol=0.01)


def test_an_angle_that_steps_to_and_fro_by_nearly_a_turn_stays() -> None:
    t: Array = 0.1 * np.arange(400, dtype=float)
    angle: Array = 3.13 * np.where(np.arange(400) % 8 < 4, -1.0, 1.0)
    kept = mended(Recording(t, angle, rotary=True))
    assert_allclose(kept.position, angle)
    assert not any("unwrapped" in note for note in kept.notes)


@pytest.mark.parametrize("axis", MAKERS)
@pytest.mark.parametrize("channel", ["position", "force"])
def test_wild_samples_are_replaced(axis: str, channel: str, tables: dict[str, Table]) -> None:
    table = tables[axis]
    if channel not in table:
        pytest.skip("no such channel")
    rng, span = np.random.default_rng(3), float(np.ptp(table[channel]))
    wild = sensors.outlying(table, channel, 0.005, span, rng)
    kept = mended(log(wild, axis))
    hit = np.flatnonzero(wild[channel] != table[channel])
    assert f"{len(hit)} samples of {channel}" in kept.notes[-1]
    assert np.abs(getattr(kept, channel) - table[channel]).max() < 0.2 * span


@pytest.mark.parametrize(
    ("axis", "channel"),
    [(a, c) for a in MAKERS for c in ("position", "force") if (a, c) != ("joint", "position")],
)
def test_a_limit_is_told(axis: str, channel: str, tables: dict[str, Table]) -> None:
    """Not of a joint that sticks: it rests at extremes itself."""
    table = tables[axis]
    if channel not in table:
        pytest.skip("no such channel")
    y = table[channel]
    top = y.min() + 0.9 * np.ptp(y) if channel == "position" else np.quantile(y, 0.85)
    assert kinds(log(table | {channel: np.minimum(y, top)}, axis)) & {"clipping", "frozen"}


@pytest.mark.parametrize("axis", ["strokes", "presliding", "cylinder"])
def test_a_limit_below_the_noise_is_told(axis: str, tables: dict[str, Table]) -> None:
    table, rng = tables[axis], np.random.default_rng(5)
    force = table["force"]
    middle = float(np.median(force))
    half = float(np.quantile(np.abs(force - middle), 0.8))
    clipped = table | {"force": np.clip(force, middle - half, middle + half)}
    noisy = sensors.noisy(clipped, "force", 0.004 * half, rng)
    assert "clipping" in kinds(log(noisy, axis))


@pytest.mark.parametrize("axis", ["driven", "strokes", "joint", "presliding", "cylinder"])
def test_a_force_that_stands_still_or_is_late_is_told(axis: str, tables: dict[str, Table]) -> None:
    table = tables[axis]
    at, span = fastest(table), float(np.ptp(table["t"]))
    assert "frozen" in kinds(log(sensors.frozen(table, "force", at, at + 0.05 * span), axis))
    interval = float(np.median(np.diff(table["t"])))
    (fault,) = faults(mended(log(sensors.held(table, "force", 10 * interval), axis)))
    assert fault.kind == "held"
    assert fault.size == pytest.approx(10 * interval)


def test_a_force_may_stand_still_while_the_axis_does() -> None:
    """A slide that sticks at a command that waits: the motor's force is one value."""
    times, command = np.array([0.0, 60.0, 66.0, 122.0]), np.array([0.0, 0.3, 0.3, 0.0])
    table = slide_bed.simulate(slide_bed.Bed(), *BED, times, command, 0.0, h=2e-5)._asdict()
    rested = log(sensors.noisy(table, "position", 1e-4, np.random.default_rng(1)), "bed")
    assert not faults(mended(rested))


@pytest.mark.parametrize("axis", MAKERS)
def test_a_position_that_is_held_is_told(axis: str, tables: dict[str, Table]) -> None:
    table = tables[axis]
    interval = float(np.median(np.diff(table["t"])))
    assert "held" in kinds(log(sensors.held(table, "position", 5 * interval), axis))


def test_a_recorded_velocity_that_contradicts_its_position_is_told() -> None:
    t: Array = 0.01 * np.arange(3000, dtype=float)
    x, v = 0.1 * np.sin(t), 0.1 * np.cos(t)
    (fault,) = faults(Recording(t, x, velocity=6.3 * v))
    assert fault.size == pytest.approx(6.3, rel=1e-3)
    assert not fault.harmful
    bursts = np.arange(3000) // 10 * 100 + np.arange(3000) % 10  # ten rows, then ninety lost
    far = 0.01 * bursts
    assert "jump" in kinds(Recording(t, 0.1 * np.sin(far), velocity=0.1 * np.cos(far)))


def test_the_top_of_a_swing_is_no_rest(tables: dict[str, Table]) -> None:
    """It swings free from 2 s on and is still at the end."""
    table = tables["swing"]
    recording = log(table, "swing")
    speed = np.abs(table["velocity"])
    for rest in segment(recording).rests:
        if rest.stop < len(recording):
            moved = float(np.trapezoid(speed[rest], table["t"][rest]))
            assert moved < 3 * 1.534e-3, rest


def test_what_is_clipped_is_not_identified() -> None:
    """The same log twice, once with a fifth of its force cut off, which biases."""
    plus, minus = coulomb_viscous(20.0, 60.0), coulomb_viscous(25.0, 90.0)
    t, command = sines(10.0, np.array([0.1, 0.03]), np.array([0.3, 0.7]))
    motion = driven.simulate(10.0, plus, minus, LOOP._replace(tick=1e-5), t, command)
    table = sensors.noisy(motion._asdict(), "force", 0.3, np.random.default_rng(2))
    limits = np.quantile(table["force"], [0.1, 0.9])
    fits = [
        identify(log(channels, "driven"), rig="forced", law="coulomb-viscous-directional")
        for channels in (table, table | {"force": np.clip(table["force"], *limits)})
    ]
    told = [[v for v in fit.violations if "cut off" in v.sentence] for fit in fits]
    assert [len(v) for v in told] == [0, 1]
    assert {e.verdict for e in fits[1].estimates} == {"weak"}
    truth = {"F_C+": 20.0, "F_V+": 60.0, "F_C-": 25.0, "F_V-": 90.0, "M": 10.0}
    assert max(abs(fits[1].values[n] / x - 1.0) for n, x in truth.items()) > 0.05
    assert "data" in {e.reason for e in fits[1].estimates}
    assert "force is cut off" in fits[1].warnings[0]


def test_only_samples_that_count_count(tables: dict[str, Table]) -> None:
    """A force that froze in the second half says nothing against the first."""
    frozen = log(sensors.frozen(tables["driven"], "force", 7.0, 7.6), "driven")
    for train, told in (("0s:6.5s", False), ("0s:8s", True)):
        fit = identify(frozen, rig="forced", law="coulomb-viscous-directional", train=train)
        assert any("force stands still" in w for w in fit.warnings) == told


def test_a_log_that_is_cut_gives_what_its_clean_piece_gives(tables: dict[str, Table]) -> None:
    table = tables["driven"]
    jumped = log(sensors.jumped(table, "position", 6.0, 0.05), "driven")
    fit = identify(jumped, rig="forced", law="coulomb-viscous-directional")
    assert fit.values["F_C+"] == pytest.approx(20.0, rel=0.03)
    assert fit.values["M"] == pytest.approx(10.0, rel=0.03)
    assert any("cut there" in note for note in fit.notes)


@pytest.mark.recordings
@pytest.mark.parametrize(
    "file",
    [
        *(f"openarm/collect_joint_{k}.csv" for k in (1, 3, 4)),
        *(f"pneumatic/{n}.csv" for n in ("Kidney_1bar", "O-ring257_7bar", "X-ring257_5bar")),
        *(f"direct_drive/{n}.csv" for n in ("est_j1_n05_exp2", "sig0_j1_6_exp1", "sig1_j1_6_exp1")),
    ],
)
def test_logs_of_real_axes_pass(file: str) -> None:
    assert not kinds(read(REAL / file))


@pytest.mark.recordings("bam_xl330")
def test_logs_of_a_real_servo_pass() -> None:
    for file in sorted((REAL / "bam_xl330" / "logs").glob("*.json")):
        assert not faults(mended(read(file, columns=dict(RIGS["servo-pendulum"].columns)))), file


@pytest.mark.recordings("openarm")
def test_a_serial_link_that_repeats_values_is_told() -> None:
    found = faults(mended(read(REAL / "openarm" / "identification_joint_2.csv")))
    assert {"position", "force"} <= {f.channel for f in found if f.kind == "held"}


@pytest.mark.parametrize(
    ("factor", "words"),
    [(1e-3, "mm and m"), (1e3, "mm and m"), (np.pi / 180, "degrees and radians")],
)
def test_a_command_in_another_unit_is_told(factor: float, words: str) -> None:
    log = TestBed().run("up", seed=3).recording
    other = replace(log, position=factor * log.position, velocity=None)
    (sentence,) = (f.sentence for f in faults(other) if f.channel == "command")
    assert words in sentence


def test_an_axis_that_goes_less_far_than_its_command_is_no_other_unit() -> None:
    log = TestBed().run("both", seed=3).recording
    for share in (0.3, 1.0, 3.0):
        other = replace(log, position=share * log.position, velocity=None)
        assert not [f for f in faults(other) if f.channel == "command"]


@cache
def sliding() -> driven.DrivenMotion:
    """10 kg with 20 N and 60 N s/m, in two tones: over half of the force is beyond 28 N."""
    curve, loop = coulomb_viscous(20.0, 60.0), driven.Loop(kp=4e4, kd=2e3, mass_ff=9.0, tick=1e-4)
    t, command = sines(15.0, np.array([0.08, 0.05, 0.03]), np.array([0.25, 0.6, 0.85]))
    return driven.simulate(10.0, curve, curve, loop, t, command)


def noisy_force(noise: float, limit: float, seed: int, step: float = 0.0) -> Recording:
    """Its force with noise, cut off at a limit, and read in steps."""
    rng = np.random.default_rng(seed)
    table = sensors.noisy(sliding()._asdict(), "force", noise, rng)
    force = np.clip(table["force"], -limit, limit)
    force = step * np.round(force / step) if step else force
    return Recording(table["t"], table["position"], force=force)


@pytest.mark.parametrize("step", [0.0, 0.1])
@pytest.mark.parametrize("noise", [0.5, 2.0, 4.0])
def test_a_limit_that_cuts_noise_off_is_told(noise: float, step: float) -> None:
    """Samples stand at the limit one by one; what lay beyond it is counted to a twentieth."""
    for seed in range(3):
        (fault,) = faults(noisy_force(noise, 28.0, seed, step))
        whole = noisy_force(noise, np.inf, seed).force
        assert whole is not None
        beyond = np.abs(whole) >= 28.0 - step / 2
        assert fault.kind == "clipping"
        assert fault.size == pytest.approx(float(beyond.mean()), rel=0.05)


@pytest.mark.parametrize("share", [0.03, 0.1, 0.2])
@pytest.mark.parametrize("noise", [1.0, 2.0, 4.0])
def test_a_limit_is_told_below_the_noise_of_a_later_stage(noise: float, share: float) -> None:
    """What is cut off is read with noise of its own, a fifth of the channel's at most."""
    for seed in range(3):
        cut = noisy_force(noise, 28.0, seed)
        assert cut.force is not None
        later = np.random.default_rng(seed + 10).standard_normal(len(cut))
        force = cut.force + share * noise * later
        (fault,) = faults(Recording(cut.t, cut.position, force=force))
        whole = noisy_force(noise, np.inf, seed).force
        assert whole is not None
        assert fault.kind == "clipping"
        assert 0.4 < fault.size / float(np.mean(np.abs(whole) >= 28.0)) < 1.25  # a side at least


@pytest.mark.parametrize("noise", [0.02, 0.2, 1.0, 3.0])
def test_the_crests_of_no_motion_are_taken_for_a_limit(noise: float) -> None:
    """Sines, triangles, jumps, levels, an output at its limit; noise all along or in motion."""
    t = 0.001 * np.arange(20_000)
    phase = 2 * np.pi * 0.7 * t
    fast = 3.0 * np.sin(2 * np.pi * 90.0 * t)
    shapes = (
        20.0 * np.sin(phase),
        20.0 * np.arcsin(np.sin(phase)),
        12.0 * np.sign(np.cos(phase)) + 8.0 * np.cos(phase),
        np.clip(60.0 * np.sin(phase), -20.0, 20.0),
        20.0 * np.sign(np.sin(3 * phase)),
        4.0 * np.floor(5.0 * np.sin(phase)),
        20.0 * np.sin(2 * np.pi * (0.1 * t + 0.3 * t * t)),
        np.where(np.sin(phase) > 0.8, 20.0, 20.0 * np.sin(phase) + fast),
        np.full(len(t), 15.0),
    )
    for seed, shape in enumerate(shapes):
        white = np.random.default_rng(seed).standard_normal(len(t))
        for force in (shape + noise * white, shape + noise * np.abs(np.cos(phase)) * white):
            for side in (force, -force):
                assert not cut_noise(side, step_of(side)).any()


@pytest.mark.parametrize("step", [0.0, 0.01, 0.25, 1.0, 5.0])
def test_noise_that_no_limit_cuts_off_is_not_told(step: float) -> None:
    for noise in (0.5, 2.0, 4.0):
        for seed in range(5):
            assert kinds(noisy_force(noise, np.inf, seed, step)) & {"clipping"} == set()
