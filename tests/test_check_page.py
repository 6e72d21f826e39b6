"""The page of a log that `check --out` writes."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from command import Completed, caller
from stribeck import Recording
from stribeck.cli.likely_rig import identify_command
from stribeck.data import check
from stribeck.data.gate import faults, mended
from stribeck.data.quality import seen_segments
from stribeck.report.figures.overview_plots import DrawnLog, overview_groups
from stribeck.report.page.log_page import check_page
from stribeck.space import Array


@pytest.fixture
def stribeck(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str],
             tmp_path: Path) -> Callable[..., Completed]:  # fmt: skip
    """The command line in an empty folder."""
    monkeypatch.chdir(tmp_path)
    return caller(monkeypatch, capsys)


def staircase(n: int = 4000) -> Recording:
    """Stick and slip under a slow command, a force, two seconds missing, some of it frozen."""
    rng = np.random.default_rng(1)
    t: Array = 0.01 * np.arange(n, dtype=float)
    slips, lasting = 0.5 + np.arange(0, t[-1], 1.0) + 0.2 * rng.random(int(t[-1]) + 1), 0.08
    heights = 4e-3 * (0.8 + 0.4 * rng.random(len(slips)))
    share = np.clip((t[:, None] - slips) / lasting, 0.0, 1.0)
    x = (share * heights).sum(axis=1) + 2e-6 * rng.standard_normal(n)
    command: Array = 4e-3 * t
    force = 5.0 + 500.0 * (command - x)
    t = np.where(t >= t[-1] - 3.0, t + 2.0, t)
    return Recording(t, x, command=command, force=force)


def plots(page: str) -> dict[str, Any]:
    """What the page's script draws, by the name of the plot."""
    found = re.search(r'id="plots">(.*?)</script>', page, re.DOTALL)
    assert found is not None
    drawn: dict[str, Any] = json.loads(found[1])
    return drawn


def test_the_page_marks_what_check_sees() -> None:
    log = staircase()
    quality = check(log)
    page = check_page(log, quality, None, "stribeck identify axis.csv --rig slide-bed --out result")
    drawn = plots(page)
    (view,) = drawn["log-plot"]["views"]
    names = {line["name"] for line in view["lines"]}
    assert {"position", "command", "force", "rest", "slip", "stroke"} <= names
    assert any(name.startswith("velocity") for name in names)
    ((begin, end),) = view["spans"]
    assert end - begin == pytest.approx(2.01)
    assert len(view["columns"]["slip_t"]) == len(quality.slips) > 20
    assert "stribeck identify axis.csv --rig slide-bed --out result" in page
    for sentence in quality.verdict:
        assert sentence.replace("'", "&#39;") in page
    for sentence in quality.faults:
        assert sentence in page
    assert "it goes one way" in page


def test_findings_stand_at_their_places() -> None:
    log = mended(staircase())
    drawn = DrawnLog(log, seen_segments(log), faults(log))
    assert drawn.faults
    (plot, *_) = [p for group in overview_groups(drawn) for p in group.plots]
    (view,) = plot.views
    rings = [line for line in view.lines if line.name == "finding"]
    assert len(rings) == len(drawn.faults)
    for fault, ring in zip(drawn.faults, rings, strict=True):
        times = view.columns[ring.x]
        assert ring.hover == [fault.sentence] * len(times)
        places = drawn.places(fault)
        assert all(a <= t <= b for t, (a, b) in zip(times, places, strict=False) if t is not None)


def test_a_long_log_makes_a_small_page() -> None:
    n = 300_000
    t: Array = 1e-3 * np.arange(n, dtype=float)
    rng = np.random.default_rng(1)
    log = Recording(t, np.sin(t) + 1e-6 * rng.standard_normal(n), force=rng.standard_normal(n))
    page = check_page(log, check(log), None, "")
    (view,) = plots(page)["log-plot"]["views"]
    assert len(view["columns"]["t"]) <= 8000
    assert max(view["columns"]["F"]) == pytest.approx(log.force.max(), rel=1e-5)  # type: ignore[union-attr]
    assert len(page) < 3 << 20


def test_check_writes_it_for_any_log(stribeck: Callable[..., Completed], tmp_path: Path) -> None:
    t = 0.01 * np.arange(600)
    channels = zip(t, 10 * np.sin(t), np.cos(t), strict=True)
    rows = [f"{a:.3f},{b:.6f},{c:.4f}" for a, b, c in channels]
    (tmp_path / "axis.csv").write_text("\n".join(["t_s,x_mm,F_N", *rows]) + "\n")
    shown = stribeck("check", "axis.csv", "--out", "page")
    assert shown.status == 0
    assert shown.out.rstrip().endswith("page in page/check.html")
    page = (tmp_path / "page/check.html").read_text()
    assert "stribeck identify axis.csv --rig forced --out result" in page
    assert "position, by its head" in page  # the table of channels
    assert sorted(p.name for p in (tmp_path / "page").iterdir()) == ["check.html", "check.json"]
    quiet = stribeck("check", "axis.csv", "--out", "page", "--quiet")
    assert (quiet.status, quiet.out) == (0, "")
    printed = stribeck("check", "axis.csv", "--out", "page", "--json")
    assert json.loads(printed.out) == json.loads((tmp_path / "page/check.json").read_text())
    refused = stribeck("check", "axis.csv", "--quiet")
    assert (refused.status, "nothing is left" in refused.err) == (2, True)
    nowhere = stribeck("check", "axis.csv", "--out", "axis.csv")
    assert nowhere.status == 2
    assert nowhere.out == ""
    (tmp_path / "table.csv").write_text("v_mm_s,F_N\n1,3\n2,4\n-1,-3\n-2,-4\n")
    table = stribeck("check", "table.csv", "--out", "table")
    assert table.status == 0
    assert "4 runs at constant speed" in (tmp_path / "table/check.html").read_text()


@pytest.mark.parametrize(
    ("typed", "command"),
    [
        ("check a.csv --out page --json", "stribeck identify a.csv --rig forced --out result"),
        (
            "check a.csv --out=page --joint 2 --rig=forced",
            "stribeck identify a.csv --joint 2 --rig forced --out result",
        ),
        (
            "check --quiet --rig forced --rate 500 a.csv",
            "stribeck identify --rate 500 a.csv --rig forced --out result",
        ),
    ],
)
def test_the_command_keeps_how_the_log_is_read(typed: str, command: str) -> None:
    assert identify_command(typed.split(), "forced") == command
    assert not identify_command(typed.split(), "")


def test_the_page_of_a_table_says_nothing_of_what_was_not_looked_at() -> None:
    v = np.array([-0.1, -0.01, -0.001, 0.001, 0.01, 0.1])
    table = Recording.of({"v [m/s]": v, "F [N]": 20.0 * np.sign(v) + 60.0 * v})
    page = check_page(table, check(table), None, "")
    assert "What the gate tells" not in page
    assert "what they seem" not in page
    assert "half of the runs are below" in page


def test_missing_rows_are_told_beside_the_findings() -> None:
    log = staircase()
    page = check_page(log, check(log), None, "")
    assert "Rows are missing in 1 place, at most 2.01 s at a time." in page
