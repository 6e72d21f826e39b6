"""Tables of mean speed and mean force: a row a run at constant speed, no times and no positions."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

from command import Completed, caller
from foreign.friction import Curve, coulomb_viscous, level
from stribeck import Fit, InputError, Recording, check, identify, plan, select, validate
from stribeck.data.readers.log_contents import contents
from stribeck.report.contents_report import contents_text
from stribeck.space import Array

#: N, N s/m, m/s, N.
CURVE, OFFSET = Curve(35.0, 20.0, 60.0, 0.01, 1.0), 2.0


def speeds(n: int, *, both: bool = True) -> Array:
    """Speeds of n runs, a decade and more of them, each way."""
    v: Array = np.geomspace(1e-3, 0.2, n // (1 + both))
    return np.concatenate([v, -v]) if both else v


def forces(v: Array, curve: Curve, noise: float | Array, seed: int = 1) -> Array:
    """What runs at these speeds take on average."""
    ideal = [np.sign(speed) * level(abs(speed), curve) + OFFSET for speed in v]
    return np.array(ideal) + np.random.default_rng(seed).normal(0.0, noise, len(v))


def table(folder: Path, columns: dict[str, Array], name: str = "table.csv") -> Path:
    """A file of columns."""
    rows = zip(*columns.values(), strict=True)
    lines = [",".join(columns), *(",".join(f"{x:.9g}" for x in row) for row in rows)]
    (folder / name).write_text("\n".join(lines) + "\n")
    return folder / name


@pytest.fixture
def stribeck(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str],
             tmp_path: Path) -> Callable[..., Completed]:  # fmt: skip
    """The command line in an empty folder."""
    monkeypatch.chdir(tmp_path)
    return caller(monkeypatch, capsys)


def violated(fit: Fit) -> str:
    """What a fit tells of its conditions."""
    return " ".join(v.sentence for v in fit.violations)


def test_a_table_without_times_is_one_of_runs(tmp_path: Path) -> None:
    v = speeds(20)
    n: Array = np.arange(len(v), dtype=float) + 50.0
    spread: Array = np.linspace(1, 2, len(v))
    columns = {"mean_speed_mm_s": 1e3 * v, "mean_force_N": forces(v, CURVE, 0.5),
               "force_std_N": spread, "n": n}  # fmt: skip
    recording = Recording.of(columns)
    order = np.argsort(v, kind="stable")
    assert recording.velocity == pytest.approx(v[order])
    assert recording.force == pytest.approx(columns["mean_force_N"][order])
    assert recording.runs is not None
    assert recording.runs.errors is not None
    assert recording.runs.errors == pytest.approx((spread / np.sqrt(n))[order])
    assert any("run at constant speed" in note for note in recording.notes)
    result = contents(table(tmp_path, columns))
    assert not result.lacking
    assert result.taken["force"].column == "mean_force_N"
    assert "force deviation" in contents_text(result)
    quality = check(recording)
    assert quality.rig == "forced"
    assert quality.verdict[0].startswith("static laws can be identified: 20 speeds, both")


def test_intervals_are_students_where_nothing_is_known_of_the_errors() -> None:
    v = speeds(10)
    F = forces(v, coulomb_viscous(20.0, 60.0), 0.5)
    fit = identify({"v [m/s]": v, "F [N]": F}, rig="forced")
    W = np.column_stack([np.sign(v), v, np.ones(len(v))])
    x, squares, *_ = np.linalg.lstsq(W, F, rcond=None)
    dof = len(v) - 3
    half = stats.t.ppf(0.975, dof) * np.sqrt(np.diag(np.linalg.inv(W.T @ W)) * squares[0] / dof)
    for k, name in enumerate(("F_C", "F_V", "offset")):
        low, high = fit.intervals[name]
        assert fit.values[name] == pytest.approx(x[k])
        assert half[k] <= 1.001 * 0.5 * (high - low) < 2 * half[k]
    assert fit.intervals.keys() == {"F_C", "F_V", "offset"}  # nothing is said of a mass
    assert "nothing accelerates: M is taken as 0" in violated(fit)


def test_runs_count_by_their_errors_and_by_what_they_scatter_beside() -> None:
    v = speeds(30)
    errors = np.where(np.arange(len(v)) % 2, 0.1, 3.0)
    weighted = {"v [m/s]": v, "F [N]": forces(v, coulomb_viscous(20.0, 60.0), errors),
                "se [N]": errors}  # fmt: skip
    fit = identify(weighted, rig="forced")
    W = np.column_stack([np.sign(v), v, np.ones(len(v))]) / errors[:, None]
    x = np.linalg.lstsq(W, weighted["F [N]"] / errors, rcond=None)[0]
    assert fit.values["F_C"] == pytest.approx(x[0], abs=0.1)
    plain = identify({k: weighted[k] for k in ("v [m/s]", "F [N]")}, rig="forced")
    assert np.ptp(fit.intervals["F_C"]) < 0.3 * np.ptp(plain.intervals["F_C"])
    # Errors that claim a thousandth do not take over: runs scatter by 0.5 N.
    claimed = {"v [m/s]": v, "F [N]": forces(v, coulomb_viscous(20.0, 60.0), 0.5),
               "se [N]": 1e-3 * errors}  # fmt: skip
    fit = identify(claimed, rig="forced")
    assert "the runs scatter by 0." in violated(fit)
    plain = identify({k: claimed[k] for k in ("v [m/s]", "F [N]")}, rig="forced")
    assert fit.values["F_C"] == pytest.approx(plain.values["F_C"], abs=0.02)


def test_a_stribeck_curve_and_a_law_that_lacks_it() -> None:
    v = speeds(30)
    log = {"v [m/s]": v, "F [N]": forces(v, CURVE, 0.3)}
    fit = identify(log, rig="forced", law="stribeck")
    for name, value in CURVE._asdict().items():
        if name in fit.intervals:
            low, high = fit.intervals[name]
            assert low <= value <= high
    assert not any(v.caps for v in fit.violations)
    lacking = identify(log, rig="forced", law="coulomb-viscous")
    assert "falls with speed below" in violated(lacking)
    assert "use law stribeck" in violated(lacking)
    assert not any(e.verdict == "identified" for e in lacking.estimates)


def test_a_clean_table_raises_few_alarms() -> None:
    v = speeds(16)
    alarms = [
        any(
            x.caps
            for x in identify(
                {"v [m/s]": v, "F [N]": forces(v, coulomb_viscous(20.0, 60.0), 0.5, seed)},
                rig="forced",
            ).violations
        )
        for seed in range(15)
    ]
    assert sum(alarms) <= 1


def test_one_direction_cannot_tell_a_weight() -> None:
    v = speeds(12, both=False)
    fit = identify({"v [m/s]": v, "F [N]": forces(v, CURVE, 0.3)}, rig="forced", law="stribeck")
    assert "the axis moves one way only" in violated(fit)
    assert "offset" not in fit.intervals
    verdicts = {e.name: (e.verdict, e.reason) for e in fit.estimates}
    assert verdicts["F_C"] == ("weak", "data")  # a weight of any size is part of it
    few = identify({"v [m/s]": v[::4], "F [N]": forces(v[::4], CURVE, 0.3)}, rig="forced",
                   fixed={"F_V": 60.0})  # fmt: skip
    assert few.estimates[0].verdict != "identified"  # two degrees of freedom


def test_a_table_goes_to_a_card_and_a_page(
    stribeck: Callable[..., Completed], tmp_path: Path
) -> None:
    v = speeds(20)
    table(tmp_path, {"Drehzahl [1/min]": 1e3 * v, "Drehmoment [Nm]": forces(v, CURVE, 0.2)})
    asked = stribeck("identify", "table.csv")
    assert asked.status == 2
    assert "stribeck identify table.csv --rig forced-rotary" in asked.err
    done = stribeck("identify", "table.csv", "--rig", "forced-rotary", "--out", "result")
    assert done.status == 0
    assert "M is taken" not in done.out
    assert "J is taken as 0" in done.out
    page = (tmp_path / "result/report.html").read_text()
    assert "run at constant speed" in page
    assert (tmp_path / "result/friction.png").stat().st_size > 0
    assert not (tmp_path / "result/force.png").exists()  # there is no time to draw it over
    (row,) = validate("result/card.json", "table.csv")
    card_error = identify("table.csv", rig="forced-rotary").score.value
    assert row[2].value == pytest.approx(card_error)


@pytest.mark.parametrize(
    ("curve", "law"), [(CURVE, "stribeck"), (coulomb_viscous(20.0, 60.0), "coulomb-viscous")]
)
def test_the_law_of_a_table_is_selected(curve: Curve, law: str) -> None:
    """Over six tables of each kind: the drop at low speeds is warranted where it is there."""
    for seed in range(6):
        v = speeds(30)
        table = {"v [m/s]": v, "F [N]": forces(v, curve, 0.3, seed)}
        chosen = select(table, rig="forced", laws=["coulomb-viscous", "stribeck"])
        assert chosen.law == law
        assert chosen.splits.text == "runs in turn, in 5 rounds"
        assert "at constant speed nothing accelerates" in violated(chosen.fit)
        alone = identify(table, rig="forced", law=law)
        assert chosen.fit.values["F_C"] == pytest.approx(alone.values["F_C"], rel=1e-3)
        assert chosen.fit.intervals.keys() == alone.intervals.keys()


def test_a_run_that_is_held_out_is_not_trained_on() -> None:
    """The held-out error of a line is that of leaving out every fifth run of each direction."""
    v = speeds(20)
    F = forces(v, coulomb_viscous(20.0, 60.0), 0.5)
    order = np.argsort(v)
    v, F = v[order], F[order]
    W = np.column_stack([np.sign(v), v, np.ones(len(v))])
    rank = np.concatenate([np.arange(10)[::-1], np.arange(10)]) % 5
    left = np.empty(len(v))
    for k in range(5):
        x = np.linalg.lstsq(W[rank != k], F[rank != k], rcond=None)[0]
        left[rank == k] = (F - W @ x)[rank == k]
    chosen = select({"v [m/s]": v, "F [N]": F}, rig="forced", laws=["coulomb-viscous"])
    expected = 100 * np.sqrt((left @ left) / (F @ F))
    assert chosen["coulomb-viscous"].held == pytest.approx(expected, rel=1e-6)


def test_laws_for_each_direction_are_left_out_where_runs_go_one_way() -> None:
    v = speeds(20, both=False)
    table = {"v [m/s]": v, "F [N]": forces(v, coulomb_viscous(20.0, 60.0), 0.3)}
    laws = ["coulomb-viscous", "coulomb-viscous-directional"]
    chosen = select(table, rig="forced", laws=laws)
    assert chosen.excluded == ("coulomb-viscous-directional",)
    assert "the axis moves one way only" in violated(chosen.fit)
    assert chosen.fit.values["F_C"] == pytest.approx(20.0 + OFFSET, abs=0.5)


def test_a_table_is_selected_on_the_command_line(
    tmp_path: Path, stribeck: Callable[..., Completed]
) -> None:
    v = speeds(30)
    table(tmp_path, {"v_mm_s": 1e3 * v, "F_N": forces(v, CURVE, 0.3)})
    done = stribeck("select", "table.csv", "--rig", "forced", "--out", "chosen")
    assert done.status == 0
    assert "stribeck is recommended" in done.out
    assert "runs in turn, in 5 rounds" in done.out
    (row,) = validate("chosen/card.json", "table.csv")
    assert row[2].value < 2.0


def test_what_needs_a_motion_refuses_a_table() -> None:
    v = speeds(20)
    log = {"v [m/s]": v, "F [N]": forces(v, CURVE, 0.3)}
    with pytest.raises(InputError, match="table of steady speeds, without a motion, and rig slide"):
        identify(log, rig="slide-bed")
    for asked in ({"train": "0s:3s"}, {"delay": 0.01}, {"velocity": "recorded"}):
        for run in (identify, select):
            with pytest.raises(InputError, match="no positions or times: leave out ranges, delays"):
                run(log, rig="forced", **asked)
    with pytest.raises(InputError, match="no positions: rig forced-pendulum"):
        identify({"v [rad/s]": v, "F [N m]": log["F [N]"]}, rig="forced-pendulum")
    fit = identify(log, rig="forced")
    with pytest.raises(InputError, match="and a plan of experiments needs the log of one"):
        plan(fit)


@pytest.mark.parametrize(
    ("columns", "sentence"),
    [
        ({"v [m/s]": np.arange(400.0), "F [N]": np.ones(400)}, "no time column among"),
        ({"v [m/s]": np.arange(20.0)}, "no time column among"),
        ({"v": np.arange(1.0, 21.0), "force [N]": np.ones(20)}, "column v without a unit"),
        ({"v [m/s]": np.ones(2), "F [N]": np.ones(2)}, "takes 3 runs, a log its times"),
        (
            {"v [m/s]": np.arange(20.0), "F [N]": np.ones(20), "sd [N]": np.zeros(20)},
            "must be above 0",
        ),
    ],
)
def test_what_is_no_table_is_refused_in_a_line(columns: dict[str, Array], sentence: str) -> None:
    with pytest.raises(InputError) as refused:
        Recording.of(columns)
    assert sentence in str(refused.value)


def test_a_log_with_a_rate_is_no_table() -> None:
    t = 0.01 * np.arange(100)
    log = {"v [m/s]": np.sin(t), "F [N]": np.sign(np.sin(t))}
    assert Recording.of(log, columns={"rate": 100.0}).runs is None
