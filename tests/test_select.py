"""The parts of a comparison of laws: embedding, splits, paired tests, criteria, refusals."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from stribeck import LAWS, RIGS, InputError, select
from stribeck.data.recording import Recording
from stribeck.friction import law_named
from stribeck.identify.data_split import range_list
from stribeck.identify.parameters import partition
from stribeck.identify.selection.folds import Splits, splits
from stribeck.identify.selection.nesting import embedded, ingredients, step
from stribeck.identify.selection.paired_test import criteria, paired, whiteness
from stribeck.rig.forced import FORCED
from stribeck.space import Array

Count = NDArray[np.int_]


def strokes(n: int, *, seconds: float = 20.0, rate: float = 200.0) -> tuple[Array, Array]:
    """Times and a position that goes to and fro, `n` strokes."""
    t = np.arange(round(seconds * rate)) / rate
    return t, 0.1 * np.cos(np.pi * n * t / seconds)


def log(
    p: dict[str, float],
    law: str = "coulomb-viscous",
    *,
    n: int = 12,
    noise: float = 0.0,
    seed: int = 0,
    seconds: float = 20.0,
) -> Recording:
    """A log of a force balance with white noise on the force."""
    t, x = strokes(n, seconds=seconds)
    w = np.pi * n / seconds
    v, a = -0.1 * w * np.sin(w * t), -0.1 * w * w * np.cos(w * t)
    friction_law = LAWS[law]
    names = [q.name for q in FORCED.parameters(friction_law)]
    force = FORCED.force(friction_law, np.array([p[name] for name in names]), v, a)
    force = force + noise * np.random.default_rng(seed).standard_normal(len(t))
    return Recording(t=t, position=x, force=force)


PLAIN = {"F_C": 20.0, "F_V": 100.0, "M": 50.0, "offset": -3.0}


# --- one law in another ---------------------------------------------------------------------------

NESTED = [
    ("coulomb-viscous", "stribeck"),
    ("coulomb-viscous", "coulomb-viscous-directional"),
    ("coulomb-viscous", "stribeck-gauss-directional"),
    ("coulomb-viscous", "bam-m1"),
    ("coulomb-viscous", "bam-m2"),
    ("coulomb-viscous", "stribeck-free+position+temperature"),
    ("stribeck", "stribeck-directional"),
    ("stribeck", "stribeck-free"),
    ("stribeck", "bam-m2"),
    ("stribeck-gauss", "stribeck-free"),
    ("coulomb-viscous-directional", "stribeck-directional"),
    ("bam-m1", "bam-m2"),
]


@pytest.mark.parametrize(("simple", "rich"), NESTED)
def test_a_simpler_law_stands_unchanged_in_a_richer_one(simple: str, rich: str) -> None:
    # Wide enough that nothing is clipped: the offset may exceed no level.
    unbounded = replace(FORCED, ranges={})
    small = partition(unbounded, law_named(simple))
    large = partition(unbounded, law_named(rich))
    rng = np.random.default_rng(3)
    for _ in range(5):
        p = unbounded.sample(small.law, rng, 1)[0]
        values = small.values(p)
        if "offset" in values:
            p[[q.name for q in small.every].index("offset")] = rng.uniform(-1.0, 1.0)
        if "F_S" in values:
            p[:2] = np.sort(p[:2])[::-1]
        x = embedded(small, p, large)
        q = large.full(x[None])[0]
        v = np.array([-0.09, -0.01, -1e-4, 1e-4, 0.01, 0.09])
        a, loads = np.linspace(-1, 1, 6), np.zeros((6, 5))
        loads[:, 3], loads[:, 4] = np.linspace(0, 1, 6), 300.0
        ours = unbounded.force(large.law, q, v, a, loads)
        np.testing.assert_allclose(ours, unbounded.force(small.law, p, v, a, loads), rtol=1e-9)


def test_bam_laws_of_one_load_stand_in_those_of_two() -> None:
    rig = RIGS["servo-pendulum"]
    rng = np.random.default_rng(0)
    chain = [partition(rig, LAWS[f"bam-m{k}"]) for k in (3, 4, 5, 6)]
    p = rig.sample(chain[0].law, rng, 1)[0]
    load = np.array([0.3, -0.2, 0.0, 0.0, 0.0])
    empty = np.empty(0)
    last = None
    for small, large in pairwise(chain):
        q = large.full(embedded(small, p, large)[None])[0]
        for v in (-2.0, 0.01, 1.0):
            force = small.law.rub(v, 0.0, empty, load, np.ascontiguousarray(p), empty)
            assert large.law.rub(v, 0.0, empty, load, q, empty) == pytest.approx(force, rel=1e-12)
        p, last = q, force
    assert last is not None
    assert last > 0


def test_what_a_law_has_more_than_another() -> None:
    def has(name: str) -> frozenset[str]:
        law = law_named(name)
        return ingredients(law, [q.name for q in law.params if q.fixed is None])

    assert has("coulomb-viscous") == has("bam-m1") == frozenset()
    assert step(has("coulomb-viscous"), has("coulomb-viscous-directional")) == "asymmetry"
    assert step(has("coulomb-viscous"), has("stribeck-free")) == "stribeck"
    assert step(has("stribeck"), has("stribeck-free")) == "exponent"
    assert step(has("bam-m1"), has("bam-m3")) == "load"
    assert step(has("bam-m2"), has("bam-m4")) == "load"
    assert step(has("bam-m4"), has("bam-m5")) == "two loads"
    assert step(has("bam-m5"), has("bam-m6")) == "squares"
    assert step(has("stribeck"), has("lugre")) == "states"
    assert step(has("stribeck"), has("stribeck+temperature")) == "temperature"
    assert step(has("coulomb-viscous"), has("stribeck-directional")) is None
    assert step(has("stribeck"), has("coulomb-viscous")) is None


# --- splits ---------------------------------------------------------------------------------------


def masks(split: Splits, logs: list[Recording]) -> list[tuple[Count, Count]]:
    """For each round, how often each sample of all logs is trained on and held out."""
    rounds = []
    for r in split.rounds:
        counts = []
        for part in (r.train, r.held):
            count = {id(log_): np.zeros(len(log_), dtype=int) for log_ in logs}
            for p in part:
                count[id(p.recording)] += p.mask()
            counts.append(np.concatenate([count[id(log_)] for log_ in logs]))
        rounds.append((counts[0], counts[1]))
    return rounds


@pytest.mark.parametrize(
    ("rig", "n", "logs", "folds", "kind"),
    [
        ("forced", 12, 1, 5, "strokes"),
        ("forced", 3, 1, 5, "time"),
        ("forced", 12, 2, 4, "strokes"),
        ("forced", 12, 7, 5, "logs"),
        ("presliding", 3, 1, 6, "time"),
    ],
)
def test_folds_never_share_samples(rig: str, n: int, logs: int, folds: int, kind: str) -> None:
    recordings = [log(PLAIN, n=n, seed=k) for k in range(logs)]
    split = splits(recordings, RIGS[rig], [], [], [], folds)
    assert split.kind == kind
    assert len(split.rounds) == folds
    round_masks = masks(split, recordings)
    for train, out in round_masks:
        assert train.max() == out.max() == 1
        assert not (train & out).any()
        assert out.sum() > 0
    np.testing.assert_array_equal(sum(out for _, out in round_masks), 1)  # each is held out once
    # The rest is the reach of the filters beside the held-out samples: 49 ms at 100 Hz, ten
    # times longer at a cut-off of a fifth.
    unused = sum(int((1 - train - out).sum()) for train, out in round_masks)
    if kind == "logs" or rig == "presliding":
        assert unused == 0
    else:
        edges = sum(int(np.count_nonzero(np.diff(out))) for _, out in round_masks)
        assert 0 < unused <= edges * max(FORCED.filtering.edges(200.0))


def test_folds_of_strokes_hold_whole_strokes_out() -> None:
    recording = log(PLAIN, n=12)
    split = splits([recording], RIGS["forced"], [], [], [], 3)
    cuts = [np.flatnonzero(np.diff(out)) + 1 for _, out in masks(split, [recording])]
    turns = np.flatnonzero(np.diff(np.sign(np.diff(recording.position)))) + 1
    for at in np.concatenate(cuts):
        assert np.abs(turns - at).min() <= 25  # an eighth of a second, of strokes of 1.7 s


def test_logs_that_run_one_way_each_are_cut_in_time() -> None:
    up, down = log(PLAIN, n=1), log(PLAIN, n=1)
    down = replace(down, position=-down.position)
    recordings = [up, down, *(log(PLAIN, n=1, seed=k) for k in (1, 2))]
    assert splits(recordings, RIGS["forced"], [], [], [], 4).kind == "time"
    assert splits([*recordings, down], RIGS["forced"], [], [], [], 5).kind == "logs"


def test_hold_outs_and_tests_are_held_out_in_one_round() -> None:
    recording, test_log = log(PLAIN), log(PLAIN, seed=1)
    rig = RIGS["forced"]
    split = splits(
        [recording], rig, range_list("0s:10s", rig), range_list("10s:15s", rig), [test_log], 5
    )
    ((train, out),) = masks(split, [recording, test_log])
    assert train.sum() == 2000
    assert out.sum() == 1000 + len(test_log)
    assert not (train & out).any()


def test_hold_outs_that_were_trained_on_are_refused() -> None:
    recording, rig = log(PLAIN), RIGS["forced"]
    with pytest.raises(InputError, match="hold-out 10s:15s overlaps the training data"):
        splits([recording], rig, [], range_list("10s:15s", rig), [], 5)
    with pytest.raises(InputError, match="is trained on and tested"):
        splits([recording], rig, [], [], [recording], 5)
    with pytest.raises(InputError, match="too short for 30 folds"):
        splits([log(PLAIN, seconds=1.2)], rig, [], [], [], 30)


# --- paired tests -------------------------------------------------------------------------------


def coloured(rng: np.random.Generator, n: int, phi: float) -> Array:
    from scipy.signal import lfilter  # noqa: PLC0415 - as the package does

    noise: Array = lfilter([np.sqrt(1 - phi**2)], [1, -phi], rng.standard_normal(n + 200))[200:]
    return noise


def test_the_same_residuals_are_not_worse() -> None:
    r = [coloured(np.random.default_rng(0), 500, 0.5)]
    outcome = paired(r, r)
    assert (outcome.change, outcome.low, outcome.high, outcome.worse) == (0.0, 0.0, 0.0, False)
    assert outcome.p == 1.0
    zero = [np.zeros(50)]
    assert not paired(zero, zero).worse


def test_a_constant_factor_is_found_exactly() -> None:
    r = [coloured(np.random.default_rng(k), 300, 0.5) for k in range(3)]
    outcome = paired([1.05 * residuals for residuals in r], r)
    assert outcome.change == pytest.approx(0.05, rel=1e-9)
    assert outcome.worse
    assert not paired([1.009 * residuals for residuals in r], r).worse  # less than matters
    assert not paired(r, [1.05 * residuals for residuals in r]).worse


def test_a_law_that_cannot_be_run_is_worse() -> None:
    r, lost = [np.ones(50)], [np.full(50, np.nan)]
    assert paired(lost, r).worse
    assert not paired(r, lost).worse


def test_two_blocks_test_nothing_and_a_tenth_decides() -> None:
    r = [np.linspace(0.1, 1.0, 10), np.linspace(0.1, 1.0, 10)]  # all of a piece
    outcome = paired([1.11 * residuals for residuals in r], r)
    assert outcome.blocks == 2
    assert np.isnan(outcome.p)
    assert outcome.worse
    assert not paired([1.09 * residuals for residuals in r], r).worse


@pytest.mark.parametrize("phi", [0.0, 0.9])
def test_the_test_keeps_its_size_and_its_power(phi: float) -> None:
    # Two models that are equally wrong but for 1 %, the edge of the hypothesis; their errors
    # share half of the variance. Of 400 such pairs 20 are expected beyond 5 %, and more than 40
    # with probability 2e-5. The interval at 90 % misses 40, and more than 72 with 1e-6.
    rng = np.random.default_rng(11)
    false_alarms = missed = detections = 0
    for _ in range(400):
        shared, a, b = (coloured(rng, 1500, phi) for _ in range(3))
        first, second = [shared + a], [shared + b]
        outcome = paired([1.01 * first[0]], second)
        false_alarms += outcome.worse
        missed += not outcome.low <= 0.01 <= outcome.high
        detections += paired([1.5 * first[0]], second).worse
    assert false_alarms <= 40
    assert missed <= 72
    assert detections >= 360


def test_whiteness_tells_noise_from_colour() -> None:
    rng = np.random.default_rng(5)
    # p is uniform in white noise: of 200, ten below 5 %, more than 22 with probability 2e-4.
    low = sum(whiteness(rng.standard_normal(400), (400,)).p < 0.05 for _ in range(200))
    assert low <= 22
    verdict = whiteness(coloured(rng, 50_000, 0.8), (50_000,))
    assert verdict.lag_1 == pytest.approx(0.8, abs=0.02)
    assert verdict.time == pytest.approx(9.0, rel=0.25)  # (1 + phi) / (1 - phi)
    assert verdict.p < 1e-100
    # Logs that lie side by side in the array do not correlate across their edge.
    ramp = np.concatenate([np.full(300, 1.0), np.full(300, -1.0)])
    assert whiteness(ramp + 0.1 * rng.standard_normal(600), (300, 300)).lag_1 < 0.2
    assert whiteness(ramp + 0.1 * rng.standard_normal(600), (600,)).lag_1 > 0.9


def test_criteria_by_hand() -> None:
    values = criteria(4.0, 2, 20.0)  # k = 3 with the variance
    assert values.aicc == pytest.approx(20 * np.log(4) + 6 + 24 / 16)
    assert values.bic == pytest.approx(20 * np.log(4) + 3 * np.log(20))
    assert criteria(4.0, 2, 4.0).aicc == np.inf


# --- refusals -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"laws": ["nonsense"]}, "no law 'nonsense'"),
        ({"laws": ["coulomb-viscous", "coulomb-viscous"]}, "coulomb-viscous is given twice"),
        ({"laws": []}, "no law was given"),
        ({"laws": ["lugre"]}, "inner states"),
        ({"seed": 1}, "solved by least squares, without a search: seed does not apply"),
        ({"folds": 1}, "folds must be a whole number >= 2"),
        ({"folds": 3, "holdout": "0s:5s", "train": "6s:20s"}, "folds are for data"),
        ({"bounds": {"sigma": (0, 1)}}, "no law here has a parameter 'sigma'"),
        ({"holdout": "0s:5s"}, "overlaps the training data"),
        ({"holdout": "5s:500000s", "train": "7e3s:8e3s"}, "range 7e3s:8e3s holds no motion"),
    ],
)
def test_what_cannot_be_compared_is_refused(options: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        select(log(PLAIN), rig="forced", **options)


def test_residuals_that_alternate_are_no_sign_of_what_is_left_out() -> None:
    """An exact law under the noise of a position, which is differentiated twice."""
    rng, t = np.random.default_rng(8), np.arange(20_000) / 1000.0
    w, w2 = 2 * np.pi * 0.5, 2 * np.pi * 0.13
    v = 0.05 * w * np.cos(w * t) + 0.03 * w2 * np.cos(w2 * t)
    a = -0.05 * w**2 * np.sin(w * t) - 0.03 * w2**2 * np.sin(w2 * t)
    x = 0.05 * np.sin(w * t) + 0.03 * np.sin(w2 * t) + 2e-6 * rng.standard_normal(len(t))
    force = 25 * np.sign(v) + 40 * v + 12 * a + 0.3 * rng.standard_normal(len(t))
    recording = Recording(t=t, position=x, force=force)
    selection = select(recording, rig="forced", laws=["coulomb-viscous", "stribeck"])
    (told,) = [line for line in selection.sentences if "residuals" in line]
    assert told.startswith("Training residuals alternate")
    assert "no sign of what is left out by coulomb-viscous" in told
