"""Several files of one run, joined by their time stamps, and folders of logs."""

from __future__ import annotations

import json
from collections.abc import Callable
from datetime import UTC, datetime, timedelta, timezone
from pathlib import Path

import numpy as np
import pytest
from nptdms import ChannelObject, TdmsWriter

from command import Completed, caller
from stribeck import identify
from stribeck.data import Recording, read
from stribeck.data.readers.clock_difference import clock_difference
from stribeck.data.readers.log_contents import contents
from stribeck.data.readers.log_map import FILE
from stribeck.errors import ChoiceError, InputError
from stribeck.identify.card import read_card
from stribeck.identify.card_logs import logs_beside
from stribeck.space import Array

Run = Callable[..., Completed]
#: 2026-03-01 10:00:00 UTC, s since 1970.
NOON = datetime(2026, 3, 1, 10, tzinfo=UTC)
EPOCH = NOON.timestamp()
#: Of the position, and of the force, s.
SLOW: Array = 0.01 * np.arange(1200.0)
FAST: Array = 0.004 * np.arange(2700.0)


def x_of(t: Array) -> Array:
    """Positions, m: two sines that no delay maps onto each other."""
    return np.asarray(0.1 * (1 - np.cos(2.0 * t)) + 0.03 * np.sin(0.7 * t))


def f_of(t: Array) -> Array:
    """2 kg, 4 N of Coulomb friction and 3 N s/m, N."""
    v = 0.2 * np.sin(2.0 * t) + 0.021 * np.cos(0.7 * t)
    a = 0.4 * np.cos(2.0 * t) - 0.0147 * np.sin(0.7 * t)
    return np.asarray(2.0 * a + 4.0 * np.sign(v) + 3.0 * v)


def written(path: Path, **columns: object) -> Path:
    """A CSV of columns, numbers or words."""
    cells = zip(*(list(c) for c in columns.values()), strict=True)  # type: ignore[call-overload]
    rows = (",".join(c if isinstance(c, str) else f"{c:.9f}" for c in row) for row in cells)
    path.parent.mkdir(exist_ok=True, parents=True)
    path.write_text("\n".join([",".join(columns), *rows]) + "\n", encoding="utf-8")
    return path


def two(folder: Path, *, shift: float = 0.0, shared: bool = False, ppm: float = 0.0) -> str:
    """A run of two files, as it is typed; the second one's clock shows `shift` more, and drifts."""
    written(folder / "pos.csv", t_s=SLOW, x_mm=1e3 * x_of(SLOW))
    noise = 0.02 * np.random.default_rng(2).standard_normal(len(FAST))
    more = {"x_mm": 1e3 * x_of(FAST)} if shared else {}
    shown = FAST * (1 + 1e-6 * ppm) + shift
    written(folder / "force.csv", t_s=shown, F_N=f_of(FAST) + noise, **more)
    return str(folder / "pos.csv+force.csv")


def assert_joined(log: Recording) -> None:
    """Its force is that of its positions, instant by instant, but where it jumps."""
    start = SLOW[np.abs(x_of(SLOW) - log.position[0]).argmin()]
    assert start <= 2 * SLOW[1]
    np.testing.assert_allclose(log.position, x_of(log.t + start), atol=1e-7)
    assert log.force is not None
    off = np.abs(log.force - f_of(log.t + start))
    assert np.median(off) < 0.02
    assert (off > 0.2).mean() < 0.02


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Run:
    called = caller(monkeypatch, capsys)
    return lambda *words: called(*map(str, words))


def test_clocks_that_begin_at_zero_are_taken_to_have_begun_at_once(tmp_path: Path) -> None:
    path = two(tmp_path)
    log = read(path)
    assert_joined(log)
    assert log.source.file == "pos.csv+force.csv"
    assert log.t[-1] == pytest.approx(FAST[-1], abs=0.01)
    assert any(
        "begin at zero: they are taken to have begun at once; 10.8 s" in n for n in log.notes
    )
    again = read([tmp_path / "pos.csv", tmp_path / "force.csv"])
    np.testing.assert_array_equal(again.position, log.position)
    assert again.source == log.source


def test_dates_are_compared_whatever_writes_them(tmp_path: Path) -> None:
    """ISO 8601 in one zone, and Unix milliseconds from 1.6 s later on."""
    east = NOON.astimezone(timezone(timedelta(hours=5, minutes=30)))
    stamps = [(east + timedelta(seconds=float(t))).isoformat(timespec="microseconds") for t in SLOW]
    first = written(tmp_path / "pos.csv", time=stamps, x_mm=1e3 * x_of(SLOW))
    late = FAST + 1.6
    second = written(tmp_path / "force.csv", time=1e3 * (EPOCH + late), F_N=f_of(late))
    log = read(f"{first}+{second}")
    assert log.force is not None
    np.testing.assert_allclose(log.position, x_of(log.t + 1.6), atol=1e-6)
    off = np.abs(log.force - f_of(log.t + 1.6))
    assert np.median(off) < 0.01
    assert any("joined by their dates; 10.39 s are in all" in note for note in log.notes)


def test_filetime_and_the_start_of_a_waveform_are_dates(tmp_path: Path) -> None:
    ticks = np.round((EPOCH + 11_644_473_600 + SLOW) * 1e7).astype(np.int64)
    written(tmp_path / "pos.csv", time=[str(n) for n in ticks], x_mm=1e3 * x_of(SLOW))
    start = np.datetime64("2026-03-01T10:00:00.5", "us")
    properties = {"wf_increment": 0.004, "wf_samples": 1, "wf_start_time": start}
    with TdmsWriter(str(tmp_path / "force.tdms")) as writer:
        channel = {**properties, "unit_string": "N"}
        writer.write_segment([ChannelObject("axis", "force", f_of(FAST + 0.5), channel)])
    log = read([tmp_path / "pos.csv", tmp_path / "force.tdms"])
    assert log.force is not None
    np.testing.assert_allclose(log.position, x_of(log.t + 0.5), atol=2e-6)
    assert np.median(np.abs(log.force - f_of(log.t + 0.5))) < 0.01


@pytest.mark.parametrize(("shift", "ppm"), [(0.0352, 150.0), (412.0, 0.0), (-0.8, -300.0)])
def test_a_signal_in_both_tells_how_the_clocks_differ(
    tmp_path: Path, shift: float, ppm: float
) -> None:
    log = read(two(tmp_path, shift=shift, shared=True, ppm=ppm))
    assert_joined(log)
    note = next(n for n in log.notes if "which both have" in n)
    offset, drift = shift + 5.4 * 1e-6 * ppm, float(note.split("drifts by ")[1].split()[0])
    told = float(note.split("force.csv is ")[1].split()[0]) * (-1 if " behind " in note else 1)
    assert told == pytest.approx(1e3 * offset, rel=1e-3, abs=0.1)
    assert drift == pytest.approx(ppm, abs=5.0)
    assert note.endswith("its times were corrected")


def test_clocks_that_agree_are_left(tmp_path: Path) -> None:
    log = read(two(tmp_path, shared=True))
    assert_joined(log)
    assert next(n for n in log.notes if "which both have" in n).endswith("left as it is")


def test_signals_that_are_not_one_say_nothing() -> None:
    rng = np.random.default_rng(3)
    walks = (np.cumsum(rng.standard_normal(len(SLOW))) for _ in range(2))
    assert clock_difference(SLOW, next(walks), SLOW, next(walks)) is None
    assert clock_difference(SLOW, np.ones(len(SLOW)), SLOW, x_of(SLOW)) is None


def test_files_that_do_not_overlap_are_refused_in_a_line(tmp_path: Path, run: Run) -> None:
    path = two(tmp_path, shift=500.0)
    with pytest.raises(InputError, match=r"pos\.csv ends 488\.01 s before force\.csv begins"):
        read(path)
    assert contents(path).lacking.startswith("pos.csv ends 488.01 s before")
    done = run("identify", path, "--rig", "forced")
    assert done.status == 2
    assert done.err.rstrip().rpartition("\n")[2].startswith("stribeck: pos.csv+force.csv: pos.csv ")


def test_a_date_and_a_count_are_no_clock(tmp_path: Path) -> None:
    path = two(tmp_path)
    written(tmp_path / "force.csv", t_s=EPOCH + FAST, F_N=f_of(FAST))
    with pytest.raises(InputError, match=r"pos\.csv counts from a zero of its own and force\.csv "
                       "dates, and no signal is in both"):  # fmt: skip
        read(path)


def test_what_is_in_a_run(tmp_path: Path, run: Run) -> None:
    done = run("contents", two(tmp_path, shared=True), "--json")
    answer = json.loads(done.out)
    assert answer["file"] == "pos.csv+force.csv"
    assert answer["format"] == "text+text"
    assert [c["name"] for c in answer["channels"]] == ["t_s", "x_mm", "2/t_s", "F_N", "2/x_mm"]
    assert [c["clock"] for c in answer["channels"]] == ["pos.csv"] * 2 + ["force.csv"] * 3
    assert answer["taken"]["position"]["column"] == "x_mm"
    assert "time" not in answer["taken"]
    assert "x_mm of force.csv is called 2/x_mm here" in answer["problems"]


def test_a_card_names_both_files_and_validates_on_them(tmp_path: Path, run: Run) -> None:
    path, out = two(tmp_path), tmp_path / "fit"
    done = run("identify", f"{path}@0.5s:9.5s", "--rig", "forced", "--out", out)
    assert done.status == 0, done.err
    card = read_card(out / "card.json")
    assert card.data[0].file == "pos.csv+force.csv@0.5s:9.5s"
    assert card.parameters["F_C"].value == pytest.approx(4.0, rel=0.02)
    (log,) = logs_beside(card, out / "card.json")
    again = read(log)
    assert again.source.sha256 == card.data[0].sha256
    assert again.t[-1] == pytest.approx(9.0, abs=0.02)
    assert run("validate", out / "card.json", path).status == 0


def test_a_map_of_a_run_is_kept_for_the_next(tmp_path: Path, run: Run) -> None:
    """Its columns of times are in it: without them the files could not be joined."""
    for name in ("a", "b"):
        written(tmp_path / f"{name}_pos.csv", clock=SLOW, way=1e3 * x_of(SLOW))
        written(tmp_path / f"{name}_force.csv", clock=FAST, load=f_of(FAST))
    path = f"{tmp_path}/a_pos.csv+a_force.csv"
    with pytest.raises(ChoiceError, match=r"a_pos\.csv: no time column among clock, way"):
        read(path)
    options = [w for c in ("time=clock [s]", "position=way [mm]", "force=load [N]")
               for w in ("--column", c)]  # fmt: skip
    done = run("check", path, *options, "--save-map")
    assert done.status == 0, done.err
    assert (tmp_path / FILE).is_file()
    assert_joined(read(f"{tmp_path}/b_pos.csv+b_force.csv"))


def test_a_file_without_times_has_a_rate(tmp_path: Path) -> None:
    written(tmp_path / "pos.csv", t_s=SLOW, x_mm=1e3 * x_of(SLOW))
    written(tmp_path / "force.csv", F_N=f_of(FAST), motor_degC=40 + 0 * FAST)
    assert_joined(read(f"{tmp_path}/pos.csv+force.csv", rate=250.0))


def test_a_file_whose_time_goes_back_is_refused_with_its_line(tmp_path: Path) -> None:
    path = two(tmp_path)
    back = np.concatenate([FAST[:1350], FAST[:1350]])
    written(tmp_path / "force.csv", t_s=back, F_N=f_of(back))
    with pytest.raises(InputError, match=r"force\.csv, line 1352: time goes back"):
        read(path)


def test_a_folder_of_the_files_of_a_run(tmp_path: Path, run: Run) -> None:
    two(tmp_path / "run")
    log = read(tmp_path / "run")
    assert_joined(log)
    assert log.source.file == "force.csv+pos.csv"
    (tmp_path / "run" / "notes.md").write_text("which is no log", encoding="utf-8")
    assert run("check", tmp_path / "run").status == 0


def test_a_folder_of_runs(tmp_path: Path, run: Run) -> None:
    for k, end in enumerate((900, 1200)):
        t = SLOW[:end]
        written(tmp_path / "runs" / f"{k}.csv", t_s=t, x_mm=1e3 * x_of(t), F_N=f_of(t))
    with pytest.raises(InputError, match=r"runs: is a folder of 2 runs \(0\.csv, 1\.csv\): name"):
        read(tmp_path / "runs")
    fit = identify(tmp_path / "runs", rig="forced")
    assert [log.label for log in fit.recordings] == ["0.csv", "1.csv"]
    out = tmp_path / "fit"
    assert run("identify", tmp_path / "runs", "--rig", "forced", "--out", out).status == 0
    assert [d.file for d in read_card(out / "card.json").data] == ["0.csv", "1.csv"]
    assert run("check", tmp_path / "runs").status == 2


def test_a_folder_that_cannot_be_told_is_refused(tmp_path: Path) -> None:
    folder = tmp_path / "mixed"
    written(folder / "a.csv", t_s=SLOW, x_mm=x_of(SLOW))
    written(folder / "b.csv", t_s=SLOW, x_mm=x_of(SLOW), F_N=f_of(SLOW))
    with pytest.raises(InputError, match="neither runs with the same channels nor files of one"):
        read(folder)
    (tmp_path / "empty").mkdir()
    with pytest.raises(InputError, match="empty: is a folder without logs"):
        read(tmp_path / "empty")


def test_paths_of_runs(tmp_path: Path) -> None:
    plain = written(tmp_path / "a+b.csv", t_s=SLOW, x_mm=1e3 * x_of(SLOW))
    assert read(plain).source.file == "a+b.csv"
    with pytest.raises(InputError, match=r"absent\.csv: no such file"):
        read(f"{plain}+absent.csv")
    with pytest.raises(InputError, match=r"pos\.csv stands twice"):
        read([Path(two(tmp_path)).with_name("pos.csv")] * 2)
    with pytest.raises(InputError, match="behind its last file"):
        read(f"{tmp_path}/pos.csv@1s:2s+force.csv")


def test_text_among_the_numbers_is_told_with_its_file_and_line(tmp_path: Path) -> None:
    path = two(tmp_path)
    lines = (tmp_path / "force.csv").read_text().splitlines()
    lines[2500] = lines[2500].split(",")[0] + ",fault"
    (tmp_path / "force.csv").write_text("\n".join(lines))
    with pytest.raises(InputError, match=r"force\.csv, line 2501, column F_N: 'fault' is not a nu"):
        read(path)


def test_numbers_beyond_all_measure_are_refused(tmp_path: Path) -> None:
    path = two(tmp_path, shared=True)
    lines = (tmp_path / "force.csv").read_text().splitlines()
    lines[700] = lines[700].split(",")[0] + ",1e308,-1e308"
    (tmp_path / "force.csv").write_text("\n".join(lines))
    with pytest.raises(InputError, match=r"force (is infinite|has values beyond)"):
        read(path)


# --- files without times ------------------------------------------------------------------------


def alone(path: Path, head: str, values: Array) -> Path:
    """A file of one column."""
    path.write_text("\n".join([*([head] if head else []), *(f"{v:.9f}" for v in values)]) + "\n")
    return path


@pytest.mark.parametrize("head", ["F [N]", ""])
@pytest.mark.parametrize("start", [0.0, EPOCH])
def test_a_file_of_values_has_the_times_of_one_with_as_many(
    head: str, start: float, tmp_path: Path
) -> None:
    written(tmp_path / "pos.csv", t_s=start + SLOW, x_mm=1e3 * x_of(SLOW))
    alone(tmp_path / "force.csv", head, f_of(SLOW))
    columns = None if head else {"force": "column 1 [N]"}
    log = read(str(tmp_path / "pos.csv+force.csv"), columns=columns)
    np.testing.assert_allclose(log.position, x_of(SLOW), atol=1e-7)
    assert log.force is not None
    np.testing.assert_allclose(log.force, f_of(SLOW), atol=1e-7)
    assert "force.csv says no times: its 1200 rows are at those of pos.csv" in log.notes


def test_a_file_of_values_with_another_count_takes_a_rate(tmp_path: Path, run: Run) -> None:
    written(tmp_path / "pos.csv", t_s=SLOW, x_mm=1e3 * x_of(SLOW))
    alone(tmp_path / "force.csv", "F [N]", f_of(FAST))
    path = tmp_path / "pos.csv+force.csv"
    told = run("check", path)
    assert told.status == 2
    assert (
        "force.csv: says no times, and has 2700 rows, not the 1200 of pos.csv: say at what rate it "
        "was recorded, --rate 500 (Hz), or export it with its times"
    ) in told.err
    assert run("check", path, "--rate", "250").status == 0
    assert_joined(read(path, rate=250.0))
    alone(tmp_path / "pos.csv", "x [mm]", x_of(SLOW))
    with pytest.raises(ChoiceError, match="says no times, and so does every file of the run"):
        read(path)


@pytest.mark.parametrize("ending", ["", ";", "\t"])
def test_a_column_alone_is_a_log_at_a_rate(ending: str, tmp_path: Path) -> None:
    rows = [f"{1e3 * x:.6f}{ending}" for x in x_of(FAST)]
    for point in ".,"[: 1 + (ending == ";")]:
        text = "\n".join([f"x [mm]{ending}", *rows]).replace(".", point)
        (tmp_path / "x.csv").write_text(text + "\n")
        log = read(tmp_path / "x.csv", rate=250.0)
        np.testing.assert_allclose(log.position, x_of(FAST), atol=1e-8)
        np.testing.assert_allclose(log.t, FAST, atol=1e-9)


@pytest.mark.parametrize("text", ["a\nb\n1\n2\n3\n", "word\n" * 40, "x\n1\n2\n"])
def test_a_few_numbers_or_words_are_no_column(text: str, tmp_path: Path) -> None:
    (tmp_path / "a.txt").write_text(text)
    with pytest.raises(InputError, match="has no rows of at least two numbers"):
        read(tmp_path / "a.txt")
