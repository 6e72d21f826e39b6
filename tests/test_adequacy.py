"""Effects that a model leaves out are seen on foreign axes, told with what catches them, and rare
where there are none."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from foreign import driven, sensors
from foreign.friction import Curve, coulomb_viscous
from foreign.strokes import sines, strokes
from stribeck import RIGS, Recording, identify
from stribeck.identify.result import Fit
from stribeck.report.contents.adequacy_records import effect_records
from stribeck.report.contents.gather import Contents
from stribeck.report.contents.schema import Report
from stribeck.report.figures.adequacy_plots import adequacy_groups
from stribeck.report.page.html_page import render

LOOP = driven.Loop(kp=4e4, kd=2e3, ki=1e5, mass_ff=9.0)
TRUTH = {"M": 10.0, "F_C": 20.0, "F_V": 60.0, "offset": 2.0}
#: Characters that the axis of a small plot holds.
LABEL = 26
#: What acts besides, words of its sentence, and of its advice.
FAULTS = {
    "square": (driven.Extras(square=150.0), "square of the speed", "law curve has none"),
    "cogging": (driven.Extras(cogging=4.0, cogging_period=0.031), "as cogging's", "+cogging"),
    "spring": (driven.Extras(spring=100.0, spring_at=0.1), "as a spring's", "[load.spring]"),
    "warming": (driven.Extras(warming=0.4, warming_time=4.0), "friction that drifts", "log the"),
    "wave": (driven.Extras(wave=0.3, wave_period=0.11), "along the travel", "+position"),
}  # fmt: skip


def axis(
    seed: int,
    extras: driven.Extras,
    plus: Curve,
    minus: Curve,
    load: float = 0.0,
    play: float = 0.0,
) -> Recording:
    """Strokes at six speeds, each twice, with force noise that remembers and a stepped encoder.

    A load comes at half of the log; the encoder sits behind a play.
    """
    rng = np.random.default_rng(seed)
    speeds = 0.4 * rng.permutation(np.repeat([0.1, 0.2, 0.35, 0.5, 0.75, 1.0], 2))
    t, x, _ = strokes(speeds, 0.2)
    motion = driven.simulate(10.0, plus, minus, LOOP, t, x, extras._replace(offset=2.0))
    table = sensors.loaded(motion._asdict(), "force", load, 0.5 * t[-1])
    table = sensors.played(table, "position", play)
    table = sensors.noisy(table, "force", 3.0, rng, memory=rng.choice([0.0, 5.0, 20.0]))
    table = sensors.quantised(table, "position", 1e-6)
    return Recording(table["t"], table["position"], force=table["force"])


@cache
def fitted(fault: str, seed: int = 0, load: float = 0.0, play: float = 0.0) -> Fit:
    curve = coulomb_viscous(TRUTH["F_C"], TRUTH["F_V"])
    plus, minus, extras = curve, curve, driven.Extras()
    if fault == "drop":
        plus = minus = Curve(30.0, 20.0, 60.0, 0.03)
    elif fault == "side":
        minus = coulomb_viscous(20.0, 90.0)
    elif fault != "clean":
        extras = FAULTS[fault][0]
    log = axis(seed, extras, plus, minus, load, play)
    return identify(log, rig="forced", law="coulomb-viscous")


def model_sentences(fit: Fit) -> list[str]:
    return [v.sentence for v in fit.violations if v.condition == "model"]


@pytest.mark.parametrize("fault", FAULTS)
def test_an_effect_is_told_with_what_can_be_done(fault: str) -> None:
    _, words, advice = FAULTS[fault]
    (first, *_) = fitted(fault).effects.effects  # type: ignore[union-attr]
    assert first.probability < 1e-4
    if first.shifts:
        sentence = model_sentences(fitted(fault))[0]
        assert words in sentence
        assert advice in sentence
    else:
        assert fault in ("cogging", "wave")


@pytest.mark.parametrize(
    ("fault", "law"),
    [("drop", "use law stribeck"), ("side", "use law coulomb-viscous-directional")],
)
def test_a_law_that_catches_an_effect_is_named(fault: str, law: str) -> None:
    assert any(sentence.endswith(law) for sentence in model_sentences(fitted(fault)))


@pytest.mark.parametrize("fault", [*FAULTS, "drop", "clean"])
def test_no_identified_value_is_off_without_a_word(fault: str) -> None:
    fit = fitted(fault)
    for e in fit.estimates:
        if e.verdict == "identified" and not e.low <= TRUTH[e.name] <= e.high:
            off = abs(e.value / TRUTH[e.name] - 1)
            assert off < 0.03 or any(f"{e.name} may be" in s for s in model_sentences(fit))


def test_friction_that_grows_with_the_square_takes_identified_away() -> None:
    fit = fitted("square")
    viscous = next(e for e in fit.estimates if e.name == "F_V")
    assert abs(viscous.value / TRUTH["F_V"] - 1) > 0.3
    assert (viscous.verdict, viscous.reason) == ("weak", "model")
    assert viscous.low <= TRUTH["F_V"] <= viscous.high


@pytest.mark.parametrize("seed", range(3))
def test_a_load_that_comes_within_a_log_takes_identified_from_the_mass(seed: int) -> None:
    fit = fitted("clean", seed, load=3.0)
    (sentence,) = model_sentences(fit)
    assert "is that of an inertia that changes" in sentence
    at = float(sentence.split(" s after its start")[0].split()[-1])
    assert at == pytest.approx(0.5 * fit.recordings[0].t[-1], rel=0.2)  # between two strokes
    assert "M may be 10" in sentence or "M may be 9.9" in sentence
    mass = next(e for e in fit.estimates if e.name == "M")
    assert mass.verdict == "weak" or mass.value < 1.1 * TRUTH["M"]
    assert mass.low < 1.005 * TRUTH["M"]
    assert all(e.verdict == "identified" for e in fit.estimates if e.name in ("F_C", "F_V"))


@pytest.mark.parametrize("seed", range(3))
def test_play_before_the_encoder_is_told_by_rows_behind_reversals(seed: int) -> None:
    fit = fitted("clean", seed, play=1e-3)
    sentence = next(s for s in model_sentences(fit) if "of reversals as backlash's" in s)
    assert "M may be" in sentence
    mass = next(e for e in fit.estimates if e.name == "M")
    assert mass.verdict == "weak"
    assert mass.low < TRUTH["M"] < 1.01 * mass.high


def test_clean_logs_raise_no_alarm() -> None:
    """One of a hundred might: with these seeds none does."""
    assert not [s for seed in range(3) for s in model_sentences(fitted("clean", seed))]


@pytest.mark.parametrize("seed", range(3))
def test_a_force_that_is_held_for_a_tick_is_no_wave_in_time(seed: int) -> None:
    """Half a tick of 1 ms is most of what 28 kg leave over that are moved by seven times 7.5 N."""
    rng = np.random.default_rng(seed)
    t, x = sines(20.0, np.array([0.129, 0.0286, 0.01256]), np.array([0.472, 1.275, 1.936]))
    curve, loop = Curve(9.1, 7.5, 8.0, 0.0275), driven.Loop(kp=4e5, kd=4.7e3, mass_ff=25.0)
    run = driven.simulate(28.0, curve, curve, loop, t, x, driven.Extras(offset=1.1))._asdict()
    table = sensors.noisy(sensors.noisy(run, "force", 0.025, rng), "position", 6e-8, rng)
    log = Recording(table["t"], table["position"], force=table["force"])
    fit = identify(log, rig="forced", law="stribeck")
    assert not [s for s in model_sentences(fit) if "wave" in s or "backlash" in s]
    mass = next(e for e in fit.estimates if e.name == "M")
    assert mass.low < 28.0 < mass.high


def test_a_joint_by_output_error_shows_the_square_of_the_speed() -> None:
    def fit_of(square: float) -> Fit:
        rng = np.random.default_rng(2)
        t, q = sines(8.0, np.array([0.5, 0.3, 0.2]), np.array([0.2, 0.4, 0.7]), dt=0.01)
        curve, loop = coulomb_viscous(1.2, 0.5), driven.Loop(kp=100.0, kd=4.0, tick=0.01)
        extras = driven.Extras(g_sin=2.0, square=square)
        motion = driven.simulate(0.3, curve, curve, loop, t, q, extras, dt=0.01)
        table = sensors.noisy(motion._asdict(), "position", 1e-4, rng)
        log = Recording(t, table["position"], command=motion.command, rotary=True)
        rig = RIGS["joint"].set(kp=100.0, kd=4.0, hold=1, step=10.0).exact()
        return identify(log, rig=rig, law="coulomb-viscous", budget=1500, repeats=1)

    clean = fit_of(0.0)
    assert not model_sentences(clean)
    assert any("square of the speed" in sentence for sentence in model_sentences(fit_of(0.3)))
    inertia = next(e for e in clean.estimates if e.name == "J")
    assert "raises the misfit J " in inertia.meaning  # and not J, which is the inertia


def test_the_page_shows_bins_and_effects() -> None:
    report = Contents(fitted("square")).report()
    assert Report.model_validate_json(report.text()) == report
    page = render(report)
    assert "What the model leaves out" in page
    assert "grows with the square of the speed" in page
    speed = report.bins[0]
    assert (speed.variable, len(speed.at)) == ("speed", 12)
    outside = [abs(m) > c for m, c in zip(speed.mean, speed.chance, strict=True)]  # type: ignore[arg-type, operator]
    assert sum(outside) >= 6
    assert report.bins[-1].unit == "mm/s²"
    labels = [panel.label for g in adequacy_groups(report) for panel in g.plots[0].panels]
    assert len(labels) == len(report.bins)
    assert max(map(len, labels)) <= LABEL
    clean = Contents(fitted("clean")).report()
    assert not clean.effects
    assert "No pattern was seen" in render(clean)


def test_friction_is_not_drawn_again_where_the_axis_ran_one_way() -> None:
    report = Contents(fitted("clean")).report()
    forces = {b.variable: b for b in report.bins if b.kind == "force"}
    same = [
        forces[b.variable].model_copy(update={"kind": b.kind}) if b.kind == "friction" else b
        for b in report.bins
    ]
    kinds = [b.kind for b in same]
    drawn = adequacy_groups(report.model_copy(update={"bins": same}))
    assert kinds.count("friction") == 2
    assert len(drawn) == len(kinds) - 2
    assert not any("friction" in g.title for g in drawn)


def test_what_an_effect_moves_beyond_a_range_stops_at_its_end() -> None:
    fit = fitted("square")
    assert fit.effects is not None
    (effect, *_) = fit.effects.effects
    far = replace(fit.effects, effects=(replace(effect, shifts={"F_C": -100.0, "M": 0.5}),))
    (record, *_) = effect_records(replace(fit, effects=far))
    friction, mass = record.moves.split(", ")
    assert friction == "F_C to 0 N (the end of its range)"
    assert mass == f"M to {fit.values['M'] + 0.5:.3g} kg"
