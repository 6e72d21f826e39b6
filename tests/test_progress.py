"""The progress of a campaign: its counts, its estimate of the time left, its output."""

import io

import numpy as np
import pytest
from rich.console import Console

from stribeck.bench.progress import PACE, Live, Tally
from stribeck.bench.record import Failure, Job, Record, Steps
from stribeck.report.format import duration

PROBLEMS = [f"f{k:02}-d{d}" for d in (2, 3, 5) for k in range(1, 25)]
METHODS = ["bts", "bts-restart", "ats", "ats-restart", "abfo"]


class Clock:
    """A clock that advances by hand, s."""

    def __init__(self) -> None:
        self.now = 1000.0

    def __call__(self) -> float:
        return self.now


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def job(problem: str, method: str, repeat: int = 0, target: float | None = 1e-8) -> Job:
    return Job(problem, method, repeat, 1, 100, target, 0.0, {}, {"name": method})


def record(job: Job, seconds: float, cost: float = 0.0) -> Record:
    steps = Steps(np.array([1]), np.array([1]), np.array([cost]))
    return Record(job, (0.0, 0.0), cost, 100, "budget", 0, {}, {}, steps, seconds)


def jobs(problems: list[str], methods: list[str], repeats: int) -> list[Job]:
    return [job(p, m, r) for r in range(repeats) for p in problems for m in methods]


def test_nothing_is_foretold_before_the_first_run() -> None:
    tally = Tally(jobs(["A"], ["x"], 4), clock=Clock())
    assert tally.seconds_left() is None
    assert tally.line() == "0/4 runs"


def test_time_left_is_that_of_each_cells_own_runs_over_the_workers() -> None:
    clock = Clock()
    campaign_jobs = jobs(["A"], ["quick", "slow"], 10)
    tally = Tally(campaign_jobs, workers=2, clock=clock)
    for repeat in range(4):  # 0.1 s and 100 s: both workers are always busy
        tally.finished(record(job("A", "quick", repeat), 0.1))
        tally.finished(record(job("A", "slow", repeat), 100.0))
    clock.now += 4 * 100.1 / 2
    assert tally.seconds_left() == pytest.approx(6 * 100.1 / 2)
    assert tally.share() == pytest.approx(0.4)
    assert tally.line() == "8/20 runs, 40 % of the work, 5 min left"


def test_work_counts_by_seconds_and_not_by_runs() -> None:
    tally = Tally(jobs(["A"], ["quick", "slow"], 10), clock=Clock())
    for repeat in range(10):
        tally.finished(record(job("A", "quick", repeat), 0.01))
    tally.finished(record(job("A", "slow"), 10.0))
    share = tally.share()
    assert share is not None
    assert share == pytest.approx((0.1 + 10.0) / (0.1 + 100.0))
    assert share < tally.total.done / tally.total.runs / 2


def test_a_cell_not_yet_seen_is_foretold_by_its_problem_and_its_method() -> None:
    tally = Tally(jobs(["easy", "hard"], ["quick", "slow"], 2), clock=Clock())
    for p, m, seconds in (("easy", "quick", 1.0), ("easy", "slow", 4.0), ("hard", "quick", 9.0)):
        tally.finished(record(job(p, m), seconds))
    expected = tally.seconds()
    assert expected is not None
    overall = 36.0 ** (1 / 3)
    by_hand = 9.0 * 4.0 / overall  # its row's mean and its column's, over the mean of all
    assert expected["hard", "slow"] == pytest.approx(by_hand)
    assert expected["hard", "quick"] == pytest.approx(9.0)


def test_time_left_falls_while_a_run_is_in_progress_and_never_below_nothing() -> None:
    clock = Clock()
    tally = Tally(jobs(["A"], ["x"], 3), clock=clock)
    tally.finished(record(job("A", "x"), 60.0))
    clock.now += 60.0
    assert tally.seconds_left() == pytest.approx(120.0)
    clock.now += 30.0
    assert tally.seconds_left() == pytest.approx(90.0)
    clock.now += 500.0
    remaining = tally.seconds_left()
    assert remaining is not None
    assert remaining >= 0.0


def test_the_cost_of_handing_out_many_short_runs_is_foretold_too() -> None:
    clock = Clock()
    tally = Tally(jobs(["A"], ["x"], 2000), clock=clock)
    for repeat in range(1000):
        tally.finished(record(job("A", "x", repeat), 0.001))
        clock.now += 0.01
    assert tally.seconds_left() == pytest.approx(10.0, rel=0.01)


def test_records_from_before_are_counted_but_took_none_of_this_time() -> None:
    clock = Clock()
    campaign_jobs = jobs(["A"], ["x"], 10)
    tally = Tally(campaign_jobs, [record(j, 5.0) for j in campaign_jobs[:8]], clock=clock)
    assert tally.seconds_left() == pytest.approx(10.0)
    clock.now += 2.0
    assert tally.seconds_left() == pytest.approx(8.0)


def test_a_failure_is_not_left_to_do() -> None:
    tally = Tally(jobs(["A"], ["x"], 2), clock=Clock())
    tally.finished(record(job("A", "x", 0), 1.0))
    tally.failed(Failure(job("A", "x", 1), "no"))
    assert tally.seconds_left() == 0.0
    assert tally.last_line() == "1/2 runs, 1 met their target, 1 failed in 0.0 s"


def test_success_counts_only_runs_with_a_target() -> None:
    tally = Tally([job("A", "x", 0), job("A", "x", 1, target=None)], clock=Clock())
    tally.finished(record(job("A", "x", 0), 1.0, cost=1.0))
    tally.finished(record(job("A", "x", 1, target=None), 1.0, cost=0.0))
    assert (tally.total.aimed, tally.total.met) == (1, 0)


def test_without_a_terminal_there_is_a_line_every_few_seconds_and_one_at_the_end() -> None:
    clock, out = Clock(), io.StringIO()
    campaign_jobs = jobs(["A"], ["x"], 100)
    with Live("paper", campaign_jobs, workers=1, file=out, clock=clock) as live:
        for k in campaign_jobs:
            clock.now += 0.5
            live.finished(record(k, 0.5))
    lines = out.getvalue().splitlines()
    assert lines[0] == "10/100 runs, 10 % of the work, 45 s left"
    assert len(lines) == 50 / PACE + 1
    assert lines[-1] == "paper: 100/100 runs, 100 met their target in 50 s"


def test_a_run_cut_short_says_so_and_failures_say_why_at_once() -> None:
    out = io.StringIO()

    def cut_short() -> None:
        with Live("paper", jobs(["A"], ["x"], 5), file=out, clock=Clock()) as live:
            live.failed(Failure(job("A", "x", 0), "the bed\nis gone"))
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        cut_short()
    first, last = out.getvalue().splitlines()
    assert first == "failed: A x 0: the bed is gone"
    assert last == "paper: stopped: 0/5 runs, 1 failed in 0.0 s"


def test_waiting_for_others_is_said() -> None:
    clock, out = Clock(), io.StringIO()
    with Live("paper", jobs(["A"], ["x"], 5), file=out, clock=clock) as live:
        clock.now += 2 * PACE
        live.waiting(1)
    assert "waiting for 1 run of other processes" in out.getvalue()


@pytest.mark.parametrize(("columns", "lines"), [(60, 24), (80, 24), (200, 100), (30, 8), (20, 3)])
def test_a_picture_never_overflows_the_terminal(
    columns: int, lines: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", str(columns))
    monkeypatch.setenv("LINES", str(lines))
    monkeypatch.setenv("TERM", "xterm")
    campaign_jobs = jobs(PROBLEMS, METHODS, 2)
    live = Live("the campaign", campaign_jobs, workers=2, file=Terminal(), clock=Clock())
    for k in campaign_jobs[:400]:
        live.tally.finished(record(k, 1.0))
    live.failed(Failure(campaign_jobs[400], "a long reason " * 20))
    live.waiting(3)
    out = Console(file=io.StringIO(), width=columns, height=lines)
    out.print(live.picture())
    drawn = out.file.getvalue().splitlines()  # type: ignore[attr-defined]
    assert max(map(len, drawn)) <= columns
    assert len(drawn) <= lines
    text = "\n".join(drawn)
    assert "400/720 runs" in text or columns < 60  # cut, but there
    shown = {200: "f24-d5", 80: "bts-restart", 60: "bts-restart"}.get(columns, "")
    assert shown in text


def test_labels_are_shown_as_they_are_and_not_read_as_markup() -> None:
    live = Live("[red]x[/red]", jobs(["[bold]P"], ["[i]m"], 1), file=Terminal(), clock=Clock())
    out = Console(file=io.StringIO(), width=100, height=30)
    out.print(live.picture())
    drawn = out.file.getvalue()  # type: ignore[attr-defined]
    assert all(label in drawn for label in ("[red]x[/red]", "[bold]P", "[i]m"))


@pytest.mark.parametrize(
    ("seconds", "text"),
    [
        (0.04, "0.0 s"), (9.94, "9.9 s"), (9.96, "10 s"), (99.4, "99 s"), (99.6, "2 min"),
        (7 * 60, "7 min"), (3569, "59 min"), (3571, "1 h"), (4800, "1 h 20 min"),
        (86_399, "1 d"), (97_200, "1 d 3 h"),
    ],
)  # fmt: skip
def test_times_are_said_as_people_say_them(seconds: float, text: str) -> None:
    assert duration(seconds) == text
