"""Delays, drifts and filters between force and motion, on logs of foreign simulators."""

from __future__ import annotations

import sys
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.random import default_rng

from foreign import cascade, cylinder, driven, sensors
from foreign.clock import Array
from foreign.friction import Curve, coulomb_viscous
from foreign.sensors import Table
from foreign.strokes import levels, sines, strokes
from stribeck import InputError, Recording, cli, identify, read_card, select, validate
from stribeck.data.alignment import advanced

ASSUMED = "a delay of the force after the motion is taken to be half a sample at most"
TRUTH = {"F_C": 20.0, "F_V": 60.0, "M": 10.0}


@cache
def motion(kind: str) -> driven.DrivenMotion:
    """10 kg with 20 N and 60 N s/m of friction, in strokes with rests or in two tones."""
    t, command = (
        strokes(np.array([0.05, 0.1, 0.2, 0.3, 0.15]), 0.15)[:2]
        if kind == "strokes"
        else sines(15.0, np.array([0.08, 0.05, 0.03]), np.array([0.25, 0.6, 0.85]))
    )
    curve = coulomb_viscous(TRUTH["F_C"], TRUTH["F_V"])
    loop = driven.Loop(kp=4e4, kd=2e3, mass_ff=9.0, tick=1e-5)
    return driven.simulate(TRUTH["M"], curve, curve, loop, t, command)


def table(kind: str = "strokes", seed: int = 0) -> Table:
    """A log of it, with noise of the force that forgets within 20 samples."""
    rng = default_rng(seed)
    noisy = sensors.noisy(motion(kind)._asdict(), "force", 1.0, rng, memory=20.0)
    return sensors.noisy(noisy, "position", 1e-6, rng)


def log(channels: Table) -> Recording:
    return Recording(channels["t"], channels["position"], force=channels["force"])


def identified(channels: Table, **options: Any) -> Any:
    return identify(log(channels), rig="forced", **options)


def verdicts(fit: Any) -> dict[str, str]:
    return {e.name: e.verdict for e in fit.estimates if e.name in TRUTH}


def told(fit: Any) -> list[str]:
    """What is said of timing."""
    words = ("the motion", "low-passed", "moved back", "one time")
    return [w for w in fit.warnings if any(word in w for word in words) and ASSUMED not in w]


def holds(fit: Any) -> bool:
    """Whether the intervals hold the truths, all of them identified."""
    within = [e.low <= TRUTH[e.name] <= e.high for e in fit.estimates if e.name in TRUTH]
    return all(within) and set(verdicts(fit).values()) == {"identified"}


@pytest.mark.parametrize("kind", ["strokes", "sines"])
@pytest.mark.parametrize("late", [0.02, 0.05, 0.5, -0.05])
def test_a_delay_is_found_to_the_length_of_a_stroke_and_allowed_for(kind: str, late: float) -> None:
    fit = identified(sensors.delayed(table(kind), "force", late))
    assert fit.delay == pytest.approx(late, abs=1e-3 if kind == "strokes" else 6e-3)
    assert holds(fit)
    assert 'delay="off" leaves it' in told(fit)[0]
    assert ("behind" if late > 0 else "ahead of") in told(fit)[0]


@pytest.mark.parametrize("late", [0.002, 0.005, -0.003])
def test_strokes_show_delays_of_some_samples(late: float) -> None:
    fit = identified(sensors.delayed(table(), "force", late))
    assert fit.delay == pytest.approx(late, abs=5e-4)
    assert fit.values["M"] == pytest.approx(TRUTH["M"], rel=0.02)


@pytest.mark.parametrize("kind", ["strokes", "sines"])
@pytest.mark.parametrize("late", [0.0, 0.0005, -0.001])
def test_logs_in_step_to_a_sample_are_left_as_they_are(kind: str, late: float) -> None:
    for seed in range(3):
        fit = identified(sensors.delayed(table(kind, seed), "force", late))
        assert fit.delay == 0.0
        assert told(fit) == []
        assert verdicts(fit) == dict.fromkeys(TRUTH, "identified")
        assert fit.recordings[0].t[-1] == motion(kind).t[-1]


def test_what_is_assumed_of_a_delay_is_said_where_the_log_hardly_shows_one() -> None:
    """Strokes with rests show one; two tones do not, until it is said."""
    spoken = [
        any(ASSUMED in w for w in identified(table(kind), **options).warnings)
        for kind, options in (("strokes", {}), ("sines", {}), ("sines", {"delay": 0.0}))
    ]
    assert spoken == [False, True, False]


def test_off_tells_a_delay_alone_and_a_number_is_taken_as_it_is() -> None:
    late = sensors.delayed(table(), "force", 0.03)
    off, known, wrong = (identified(late, delay=d) for d in ("off", 0.03, 0.01))
    assert off.delay == 0.0
    assert 'delay="auto" moves it back' in told(off)[0]
    assert "identified" not in verdicts(off).values()
    assert (known.delay, known.search.ended) == (0.03, "solved")
    assert holds(known)
    assert "still 20 ms behind" in told(wrong)[1]
    assert told(wrong)[1].endswith("if they are right, the estimates are not")
    assert "identified" not in verdicts(wrong).values()


@pytest.mark.parametrize("delay", [0.01, (0.01, 1e-4)])
def test_a_delay_that_is_said_outweighs_one_that_the_log_may_show(delay: Any) -> None:
    """Of two tones under a force of 6 N of noise, of which 24 ms are likely and 10 ms are true."""
    rng = default_rng(0)
    noisy = sensors.noisy(motion("sines")._asdict(), "force", 6.0, rng, memory=20.0)
    late = sensors.delayed(sensors.noisy(noisy, "position", 1e-6, rng), "force", 0.01)
    looked, said = identified(late), identified(late, delay=delay)
    assert "may be" in told(looked)[0]
    assert "identified" not in verdicts(looked).values()
    assert told(said) == ["the force is moved back by 10 ms, as was said"]
    assert verdicts(said)["M"] == "identified"
    assert said.intervals["M"][0] < 10.0 < said.intervals["M"][1]


def test_a_law_that_is_wrong_is_no_delay() -> None:
    """What it leaves over of a force that grows with the speed squared reads as one of 2 ms."""
    t, command = levels([
        run for v in (0.05, 0.1, 0.2, 0.3)
        for run in ((v, 0.6, 0.15), (-v, 0.6, 0.3), (0.0, 0.2, 0.15))
    ])  # fmt: skip
    curve, loop = coulomb_viscous(30.0, 60.0), driven.Loop(kp=4e4, kd=2e3, mass_ff=20.0, tick=1e-5)
    extras = driven.Extras(square=300.0)
    run = driven.simulate(20.0, curve, curve, loop, t, command, extras)._asdict()
    fit = identified(sensors.noisy(run, "force", 0.2, default_rng(1)))
    assert told(fit) == []
    assert verdicts(fit)["M"] == "identified"
    assert fit.intervals["M"][0] < 20.0 < fit.intervals["M"][1]
    assert verdicts(fit)["F_V"] != "identified"


def pulled(seed: int) -> Table:
    """10 kg that are pulled through a spring of 800 N/m at 5 mm/s, and stick and slip."""
    t, command = levels([(5e-3, 29.0, 0.5), (-5e-3, 29.0, 1.0)], 1e-2)
    curve, loop = Curve(20.0, 10.0, 100.0, 5e-3), driven.Loop(kp=800.0, kd=0.0, tick=2e-4)
    run = driven.simulate(10.0, curve, curve, loop, t, command, dt=1e-2, h=2e-5)._asdict()
    rng = default_rng(seed)
    return sensors.noisy(sensors.noisy(run, "force", 0.1, rng), "position", 2e-5, rng)


@pytest.mark.parametrize("seed", [3, 6, 20])
def test_a_delay_that_explains_no_more_than_none_is_neither_allowed_for_nor_told(seed: int) -> None:
    """Of some ten slips the samples that slide agree at a lag of seconds, and the balance does not.

    Moved by it, the balance leaves three times as much.
    """
    fit = identified(pulled(seed))
    assert fit.delay == 0.0
    assert told(fit) == []
    assert fit.values["M"] == pytest.approx(10.0, rel=0.05)
    assert not any("moves it back" in w for w in identified(pulled(seed), delay="off").warnings)


@pytest.mark.parametrize(("stiff", "seed"), [
    (True, 5), (True, 6), (True, 24), (True, 27), (False, 20), (False, 23), (False, 28),
])  # fmt: skip
def test_slips_that_are_like_each_other_show_no_delay_and_no_drift(stiff: bool, seed: int) -> None:
    """A third of such a log has some slips, each of which fits another one.

    By Coulomb friction, without the drop that they come from, a delay explains more than none; a
    smaller mass does, too, of which the noise of the acceleration makes less.
    """
    v, k, mass, curve, dt, span = (
        (4e-3, 5000.0, 20.0, Curve(40.0, 25.0, 300.0, 4e-3), 2e-3, 15.0) if stiff else
        (1e-2, 3000.0, 5.0, Curve(25.0, 15.0, 50.0, 1e-2), 4e-3, 6.0)
    )  # fmt: skip
    t, command = levels([(v, span, 0.5), (-v, span, 1.0)], dt)
    loop = driven.Loop(kp=k, kd=0.0, tick=2e-4)
    run = driven.simulate(mass, curve, curve, loop, t, command, dt=dt, h=2e-5)._asdict()
    rng = default_rng(seed)
    fit = identified(sensors.noisy(sensors.noisy(run, "force", 0.1, rng), "position", 2e-5, rng))
    assert fit.delay == 0.0
    assert told(fit) == []


def test_the_search_ends_at_a_stroke_and_says_so() -> None:
    fit = identified(sensors.delayed(table(), "force", 1.1))
    assert "at least 1070 ms behind" in told(fit)[0]
    assert "identified" not in verdicts(fit).values()
    assert fit.delay == 0.0


def test_rests_are_no_strokes() -> None:
    """A cascade holds its axis still with noise of both signs: the search reaches over strokes."""
    curve = coulomb_viscous(20.3935, 203.5034)
    _, command, _ = strokes(np.tile([0.2, 0.4], 3), 0.2)
    run = cascade.simulate(cascade.Cascade(delay=0.0), curve, curve, command)._asdict()
    rng = default_rng(0)
    run = sensors.noisy(sensors.noisy(run, "voltage", 0.05, rng), "position", 1e-6, rng)
    late = sensors.delayed(run, "voltage", 0.02)
    fit = identify(
        Recording(late["t"], late["position"], command=late["command"], voltage=late["voltage"]),
        rig="emps",
    )
    assert fit.delay == pytest.approx(0.0195, abs=2e-4)  # half a tick is the held output's
    assert fit.values["M"] == pytest.approx(95.109, rel=0.005)


@pytest.mark.parametrize("seed", range(3))
def test_a_coarse_position_has_no_delay_of_seconds(seed: int) -> None:
    """Of 1 mm steps a twentieth of the rows know their direction: strokes are those of the motion.

    Over lags of several strokes some lag always fits what few rows there are.
    """
    speeds = np.tile([0.05, 0.1, 0.15, 0.2, 0.3], 2)
    t, command, _ = strokes(speeds, 0.08)
    curve, loop = coulomb_viscous(20.0, 60.0), driven.Loop(kp=4e4, kd=2e3, mass_ff=9.0, tick=1e-4)
    run = driven.simulate(10.0, curve, curve, loop, t, command, driven.Extras(offset=3.0))
    coarse = sensors.noisy(run._asdict(), "force", 0.5, default_rng(seed))
    fit = identified(sensors.quantised(coarse, "position", 1e-3))
    assert fit.delay == 0.0
    assert told(fit) == []
    assert "identified" not in verdicts(fit).values()


def test_a_clock_that_drifts_is_told_by_thirds() -> None:
    fit = identified(sensors.drifting(table(), "force", -0.025, 0.025))
    (sentence,) = told(fit)
    assert all(f"the {which} third of the log" in sentence for which in ("first", "second", "last"))
    late = [float(text.split(" ms in")[0].split()[-1]) for text in sentence.split(" third")[:3]]
    assert late == sorted(late)
    assert late[2] - late[0] > 25
    assert "identified" not in verdicts(fit).values()
    assert fit.delay == 0.0


@pytest.mark.parametrize("channel", ["force", "position"])
def test_a_filter_on_one_channel_is_no_delay(channel: str) -> None:
    cutoff = 5.0
    fit = identified(sensors.low_passed(table(), channel, cutoff))
    (sentence,) = told(fit)
    assert f"the {channel} is low-passed" in sentence
    at = float(sentence.split(" Hz")[0].split("(")[-1])
    assert at == pytest.approx(cutoff, rel=0.15)
    assert "identified" not in verdicts(fit).values()


def test_a_light_rod_is_weighed_where_it_is_and_not_about_reversals() -> None:
    axis = cylinder.Cylinder(M=2.0, F_C=10.0, F_V=300.0, mu_p=5e-5, b=2e-5, offset=3.0)
    t, _, speed = strokes(np.array([0.05, 0.1, 0.2]), 0.05)
    rng = default_rng(5)

    def measured(p: float) -> Recording:
        m = cylinder.simulate(axis, t, speed, np.full_like(t, p))._asdict()
        m = sensors.noisy(sensors.noisy(m, "force", 0.5, rng, 20.0), "position", 1e-6, rng)
        return Recording(m["t"], m["position"], force=m["force"], pressure=m["pressure"])

    fit = identify([measured(p) for p in (1e5, 3e5, 6e5)], rig="cylinder")
    mass = next(e for e in fit.estimates if e.name == "M")
    assert mass.value == pytest.approx(2.0, rel=0.06)
    assert mass.low < 2.0 < mass.high
    assert fit.delay == 0.0


# Moving a log


def test_what_is_moved_is_read_where_it_belongs() -> None:
    t = np.arange(0.0, 2.0, 0.01)
    late = Recording(t, np.sin(t), force=np.cos(t - 0.053), current=t - 0.053, velocity=np.cos(t))
    moved = advanced(late, 0.053)
    assert moved.force is not None
    assert moved.current is not None
    np.testing.assert_allclose(moved.force, np.cos(moved.t), atol=2e-5)
    np.testing.assert_allclose(moved.current, moved.t, atol=1e-12)
    np.testing.assert_array_equal(moved.position, np.sin(moved.t))
    assert moved.t[-1] + 0.053 <= t[-1] + 1e-9
    assert advanced(late, 0.0) is late
    ahead = advanced(Recording(t, np.sin(t), force=np.cos(t + 0.02)), -0.02)
    np.testing.assert_allclose(np.asarray(ahead.force), np.cos(ahead.t), atol=2e-5)
    assert ahead.t[0] >= 0.02 - 1e-9


@pytest.mark.parametrize(
    ("delay", "words"),
    [
        ("soon", "give auto, off or a time"),
        (float("nan"), "give a time"),
        (1e3, "leaves nothing"),
        (None, "give seconds, or seconds and a tolerance"),
        ((0.0, 1.0, 2.0), "give seconds, or seconds and a tolerance"),
        ((0.0, -1.0), "a tolerance in seconds, 0 or more"),
    ],
)
def test_refusals(delay: Any, words: str) -> None:
    with pytest.raises(InputError, match=words):
        identified(table(), delay=delay)


def test_the_tolerance_of_a_delay_is_in_the_intervals() -> None:
    late = sensors.delayed(table(), "force", 0.001)
    exact, known = identified(late, delay=0.0), identified(late, delay=(0.0, 0.004))
    assert exact.values == known.values
    assert not holds(exact)
    assert holds(known)


def test_a_log_without_a_force_has_none_to_move() -> None:
    t: Array = np.arange(0.0, 2.0, 0.01)
    with pytest.raises(InputError, match="no force that a delay could move"):
        advanced(Recording(t, np.sin(t)), 0.1)


# Select, cards and the command line


def test_laws_are_compared_in_step() -> None:
    late = log(sensors.delayed(table("sines"), "force", 0.05))
    selection = select(late, rig="forced", laws=["coulomb-viscous", "stribeck"])
    assert selection.fit.delay == pytest.approx(0.05, abs=4e-3)
    assert selection.law == "coulomb-viscous"


def test_a_card_keeps_the_delay_and_validation_uses_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    late = sensors.delayed(table("sines"), "force", 0.05)
    file, out = tmp_path / "log.csv", tmp_path / "fit"
    rows = np.column_stack([late["t"], late["position"], late["force"]])
    np.savetxt(file, rows, delimiter=",", header="t_s,x_m,force_N", comments="", fmt="%.9g")

    def run(*arguments: str) -> str:
        monkeypatch.setattr(sys, "argv", ["stribeck", *arguments])
        status: Any = 0
        try:
            cli.main()
        except SystemExit as end:
            status = end.code or 0
        text = capsys.readouterr()
        return " ".join(f"{status} {text.out} {text.err}".split())

    assert "moved by that: --delay off" in run(
        "identify", str(file), "--rig", "forced", "--out", str(out)
    )
    card = read_card(out / "card.json")
    assert card.delay == pytest.approx(0.05, abs=4e-3)
    other = log(sensors.delayed(table("sines", seed=1), "force", 0.05))
    in_step, off = (validate(card, other, delay=d)[0][2].value for d in ("auto", "off"))
    assert in_step < 0.3 * off
    argument = str(out / "card.json")
    assert run("validate", argument, str(file), "--max-error", "15").startswith("0")
    assert run("validate", argument, str(file), "--max-error", "15", "--delay", "off")[0] == "1"
    assert run("validate", argument, str(file), "--max-error", "15", "--delay", "50")[0] == "0"
    assert run("identify", str(file), "--rig", "forced", "--delay", "x").startswith("2")


@pytest.mark.parametrize("late", [-0.003, 0.003, 0.006])
@pytest.mark.parametrize("size", [0.06, 0.2])
def test_a_delay_that_slow_motion_hides_is_never_passed_over_in_silence(
    size: float, late: float
) -> None:
    """Of two slow tones it is some per cent of the mass, and hardly a change of the residual."""
    t = np.arange(0.0, 24.0, 1e-3)
    w = np.array([[1.3], [2.6]])
    reach = size * np.array([[1.0], [0.3]])
    for seed in range(2):
        rng = np.random.default_rng(seed)
        phase = rng.uniform(0, 2 * np.pi, (2, 1))
        x = (reach * np.sin(w * t + phase)).sum(axis=0) + 1e-6 * rng.standard_normal(len(t))
        v = (reach * w * np.cos(w * (t - late) + phase)).sum(axis=0)
        a = -(reach * w * w * np.sin(w * (t - late) + phase)).sum(axis=0)
        force = 10 * a + 20 * np.sign(v) + 60 * v + 0.5 * rng.standard_normal(len(t))
        fit = identify(Recording(t, x, force=force), rig="forced")
        spoken = " ".join(w for w in fit.warnings if "delay" in w)
        for e in fit.estimates:
            if e.verdict == "identified" and e.name in TRUTH:
                assert e.low <= TRUTH[e.name] <= e.high or spoken
