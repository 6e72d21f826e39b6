"""A servo with a pendulum: published parameters, committed fits, laws that contain others."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest

import axes
import axis_servo
from stated_model import StatedModel
from stribeck import RIGS, identify, read, validate
from stribeck.data.recording import Recording
from stribeck.friction import law_named
from stribeck.identify.loss import Objective
from stribeck.identify.parameters import partition

HOME = axis_servo.LOGS.parent
pytestmark = pytest.mark.recordings("bam_xl330")
RIG = RIGS["servo-pendulum"]
#: The authors' names of the parameters.
CALLED = {
    "k_t": "kt", "K_c": "friction_base", "K_v": "friction_viscous", "K_cs": "friction_stribeck",
    "w_s": "dtheta_stribeck", "K_m": "load_friction_motor", "K_e": "load_friction_external",
    "K_ms": "load_friction_motor_stribeck", "K_es": "load_friction_external_stribeck",
    "K_mq": "load_friction_motor_quad", "K_eq": "load_friction_external_quad",
}  # fmt: skip


def results(part: str) -> dict[str, Any]:
    document: dict[str, Any] = json.loads(axes.FILE.read_text(encoding="utf-8"))
    return {k.rpartition("/")[2]: v for k, v in document.items() if k.startswith(f"servo/{part}")}


@pytest.fixture(scope="module")
def logs() -> list[Recording]:
    files = sorted(axis_servo.LOGS.glob("*.json"))
    assert len(files) == 16
    return [read(file, columns=dict(RIG.columns)) for file in files]


def error(law: str, values: dict[str, float], logs: list[Recording]) -> float:
    """Mean over the logs of the mean absolute errors that `validate` prints, mrad."""
    parameters = partition(RIG, law_named(law), objective=Objective("absolute"))
    p = np.array([values[q.name] for q in parameters.every])
    return float(
        np.mean([score.value for _, _, score in validate(StatedModel(parameters, p), logs)])
    )


@pytest.mark.parametrize(("model", "published"), sorted(axis_servo.PUBLISHED.items()))
def test_published_parameters_err_as_published(
    model: str, published: float, logs: list[Recording]
) -> None:
    """The authors' simulator resamples to 5 ms and steps explicitly; this one does neither."""
    published_values = json.loads(
        (HOME / "published" / "at_recording" / f"{model}.json").read_text()
    )
    law = f"bam-{model}"
    values = {
        q.name: published_values[CALLED.get(q.name, q.name)] for q in RIG.parameters(law_named(law))
    }
    assert error(law, values, logs) == pytest.approx(published, rel=0.04)


def test_committed_fits_err_as_the_tables_say(logs: list[Recording]) -> None:
    fits = results("identify/")
    assert "m1" in fits
    for name, fit in fits.items():
        values = {n: row[0] for n, row in fit["estimates"].items()}
        assert error(axis_servo.LAWS[name], values, logs) == pytest.approx(fit["mae"], rel=1e-4)


@pytest.mark.parametrize("name", sorted(results("identify/")))
def test_identify_is_no_worse_than_a_local_simplex(name: str) -> None:
    mae = {n: fit["mae"] for n, fit in results("identify/").items()}
    assert mae[name] <= axis_servo.SIMPLEX.get(name, mae["m1"]) + 0.1


def test_plain_friction_is_identified_again(
    logs: list[Recording], monkeypatch: pytest.MonkeyPatch
) -> None:
    # The question is not how sure it is.
    monkeypatch.setattr("stribeck.identify.output_error.PROFILES", 100)
    fit = identify(
        logs, rig=RIG, law="coulomb-viscous", loss="absolute", seed=5, repeats=1, budget=700
    )
    error_again = np.mean([score.value for _, _, score in validate(fit, logs)])
    assert error_again == pytest.approx(results("identify/")["m1"]["mae"], rel=0.01)
    # J is 64 times the noise, and squares have another answer, with another duty: it is told.
    by_squares = {"k_t": 0.435, "R": 7.33, "F_C": 0.0388, "F_V": 0.00294}
    estimates = {e.name: e for e in fit.estimates}
    assert all(e.verdict != "identified" or e.low <= by_squares[n] <= e.high
               for n, e in estimates.items() if n in by_squares)  # fmt: skip
    (sentence,) = (w for w in fit.warnings if w.startswith('loss="squares" puts'))
    assert "R at 7." in sentence


@pytest.mark.parametrize(
    "split", [s for s in results("squares/") if s.partition("+")[0] not in ("800", "none")]
)
def test_friction_that_grows_with_the_load_predicts_an_unseen_gain(
    split: str, logs: list[Recording]
) -> None:
    fits, gain = results("squares/")[split], int(split.partition("+")[0])
    assert fits["m3"]["test"] < fits["m1"]["test"]
    unseen = [log for log in logs if round(float(log.extra["kp"][0])) == gain]
    assert len(unseen) == 4
    assert error("bam-m3", fits["m3"]["p"], unseen) == pytest.approx(fits["m3"]["test"], rel=1e-4)


def test_the_choice_looks_at_no_log_of_the_unseen_gain() -> None:
    """A table in which the unseen gain would choose otherwise."""
    names = list(axis_servo.LAWS)

    def row(**tests: float) -> dict[str, Any]:
        return {n: {"test": tests.get(n, 50.0)} for n in names}

    splits = {
        "absolute/800": row(m1=10.0, m3=90.0), "squares/800": row(m1=10.0, m3=90.0),
        **{f"absolute/{g}+800": row(m3=20.0) for g in (100, 200, 400)},
        **{f"squares/{g}+800": row(m3=30.0, m6=25.0) for g in (100, 200, 400)},
    }  # fmt: skip
    chosen = axis_servo.choice(splits)
    assert (chosen["loss"], chosen["law"]) == ("absolute", "m3")
    assert chosen["tests"]["absolute"]["m3"] == 90.0


def test_the_tables_show_what_is_kept() -> None:
    text = "\n".join(axis_servo.tables({"identify": results("identify/"), "splits": {}}))
    assert f"{results('identify/')['m1']['mae']:.1f}" in text
