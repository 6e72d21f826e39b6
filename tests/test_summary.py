"""The page of a campaign: valid HTML, complete, what is missing is named."""

from __future__ import annotations

import base64
import io
import re
from collections import Counter
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure
from PIL import Image

from stribeck.bench.campaign import Campaign, parsed, shipped
from stribeck.bench.campaign_figures import CampaignFigure, draw, figures
from stribeck.bench.record import Failure, Job, Record
from stribeck.bench.run import run
from stribeck.bench.study import Study
from stribeck.bench.summary import command, pictures, write_summary
from stribeck.bench.tables import ranking, summary
from stribeck.report.table import Cell, Table

EVIL = "<script>alert('x')</script>"
FILE = """
name = "small"
doc = "Two methods <b>on</b> two surfaces."
seed = 3
repeats = 3
budget = 400

[[problem]]
surface = ["BF", "SF"]
target = 1.0

[[method]]
name = "bts"
method = "bts"
unit_free = true
settings = { S = 6, N_c = 3 }
on = { BF = { N = 20 } }

[[method]]
name = "random"
method = "random"
problems = ["BF"]
budget_per_dim = 50
"""
VOID = {"meta", "img", "br", "link", "input", "hr"}


class Page(HTMLParser):
    """The page's text, tables and attributes; fails where a tag is not closed in its turn."""

    def __init__(self, text: str) -> None:
        super().__init__(convert_charrefs=True)
        self.open: list[str] = []
        self.count: Counter[str] = Counter()
        self.attributes: list[tuple[str, str, str]] = []
        self.tables: list[list[list[str]]] = []
        self.captions: list[str] = []
        self.text = ""
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.count[tag] += 1
        self.attributes += [(tag, name, value or "") for name, value in attrs]
        if tag == "table":
            self.tables.append([])
        if tag == "caption":
            self.captions.append("")
        if tag == "tr":
            self.tables[-1].append([])
        if tag in {"td", "th"}:
            self.tables[-1][-1].append("")
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if "style" in self.open:
            return
        self.text += data
        if "caption" in self.open:
            self.captions[-1] += data
        elif {"td", "th"} & set(self.open):
            self.tables[-1][-1][-1] += data

    def table(self, caption: str) -> list[list[str]]:
        """The cells of a table, heads first."""
        (rows,) = [t for t, c in zip(self.tables, self.captions, strict=True) if c == caption]
        return [[" ".join(cell.split()) for cell in row] for row in rows]


@pytest.fixture(scope="module")
def campaign() -> Campaign:
    return parsed(FILE)


@pytest.fixture(scope="module")
def jobs(campaign: Campaign) -> list[Job]:
    return list(campaign.jobs())


@pytest.fixture(scope="module")
def records(jobs: list[Job]) -> list[Record]:
    return [run(job) for job in jobs]


def write(
    folder: Path, campaign: Campaign, jobs: list[Job], records: list[Record],
    failures: list[Failure] | None = None, tables: dict[str, Table] | None = None,
    drawn: list[CampaignFigure] | None = None,
) -> str:  # fmt: skip
    file = write_summary(
        folder, campaign, jobs, records, failures or [], tables=tables or {},
        figures=drawn or [], command="stribeck bench small.toml",
    )  # fmt: skip
    return file.read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def page_text(
    campaign: Campaign, jobs: list[Job], records: list[Record],
    tmp_path_factory: pytest.TempPathFactory,
) -> str:  # fmt: skip
    folder = tmp_path_factory.mktemp("page")
    (folder / "figures").mkdir()
    drawn = figures(records, jobs)
    draw(drawn, folder / "figures")
    tables = {"summary": summary(records, jobs), "ranking": ranking(records, jobs)}
    return write(folder, campaign, jobs, records, tables=tables, drawn=drawn)


def test_a_whole_campaign_says_so_and_shows_every_number_of_its_tables(
    page_text: str, jobs: list[Job], records: list[Record]
) -> None:
    page = Page(page_text)
    assert "Complete: all 9 runs are done." in page.text
    assert "Not complete" not in page.text
    assert page.count["h1"] == 1
    table = summary(records, jobs)
    assert page.table(table.title) == [
        list(table.heads),
        *([cell.text for cell in row] for row in table.rows),
    ]
    assert page.text.index("Ranking") < page.text.index(table.title)


def test_the_page_says_what_was_compared(page_text: str) -> None:
    page = Page(page_text)
    methods = page.table("Methods")
    assert methods[1][:2] == ["bts", "bts"]
    assert "unit-free readings" in methods[1][2]
    assert "S = 6, N_c = 3" in methods[1][2]
    assert "BF: N = 20" in methods[1][2]
    assert methods[2] == ["random", "random", "none", "BF", "50 × dimension"]
    problems = page.table("Problems")
    assert problems[1][2:] == ["-2 to 2 in 2 variables", "0", "1", "400"]
    assert problems[2][3:] == ["0.9980038", "1", "400"]
    for text in ("3", "stribeck bench small.toml", "NumPy", 'doc = "Two methods'):
        assert text in page.text


def test_nothing_is_fetched_and_nothing_runs(page_text: str) -> None:
    page = Page(page_text)
    assert not re.search(
        r"https?://|//\w|@import|url\(", re.sub(r'src="data:[^"]*"', "", page_text)
    )
    assert not {"script", "link", "iframe", "object"} & set(page.count)
    assert not [name for _, name, _ in page.attributes if name.startswith("on")]
    sources = [v for tag, name, v in page.attributes if (tag, name) == ("img", "src")]
    assert len(sources) == page.count["figure"] == 5  # one method on both: no profile
    for source in sources:
        head, data = source.split(",")
        assert head == "data:image/png;base64"
        assert base64.b64decode(data, validate=True)[:4] == b"\x89PNG"


def test_figures_and_tables_can_be_read_without_seeing_them(page_text: str) -> None:
    page = Page(page_text)
    alts = [v for tag, name, v in page.attributes if (tag, name) == ("img", "alt")]
    assert len(alts) == page.count["img"]
    assert all(len(alt) > 40 for alt in alts)
    assert page.count["caption"] == page.count["table"]
    assert all(page.captions)
    scopes = Counter(v for tag, name, v in page.attributes if (tag, name) == ("th", "scope"))
    assert sum(scopes.values()) == page.count["th"]
    assert "prefers-color-scheme: dark" in page_text
    ids = [v for _, name, v in page.attributes if name == "id"]
    targets = [v for tag, name, v in page.attributes if (tag, name) == ("a", "href")]
    assert {t[1:] for t in targets if t.startswith("#")} == set(ids)


def test_what_failed_and_what_is_missing_comes_first(
    campaign: Campaign, jobs: list[Job], records: list[Record], tmp_path: Path
) -> None:
    text = write(tmp_path, campaign, jobs, records[:5], [Failure(jobs[6], "the bed is gone")])
    page = Page(text)
    start = " ".join(page.text.split("What was compared")[0].split())
    assert "Not complete: 5 of 9 runs are done. 1 could not be run. 3 are still to be run." in start
    failed = page.table("Runs that could not be run")
    assert failed[1:] == [[*jobs[6].cell, str(jobs[6].repeat + 1), "the bed is gone"]]
    missing = page.table("Runs still to be run")[1:]
    assert Counter({(p, m): int(n) for p, m, n in missing}) == Counter(
        jobs[k].cell for k in (5, 7, 8)
    )


def test_a_failure_that_was_mended_since_is_no_failure(
    campaign: Campaign, jobs: list[Job], records: list[Record], tmp_path: Path
) -> None:
    page = Page(write(tmp_path, campaign, jobs, records, [Failure(jobs[0], "once")]))
    assert "Complete: all 9 runs" in page.text
    assert "once" not in page.text


def test_of_many_failures_some_are_listed_and_all_are_counted(tmp_path: Path) -> None:
    larger = parsed(FILE.replace("repeats = 3", "repeats = 40"))
    jobs = list(larger.jobs())
    page = Page(write(tmp_path, larger, jobs, [], [Failure(job, "no") for job in jobs]))
    assert "120 could not be run." in page.text
    assert len(page.table("Runs that could not be run, the first 50")) == 51


def test_a_campaign_of_which_nothing_is_done_has_a_page(
    campaign: Campaign, jobs: list[Job], tmp_path: Path
) -> None:
    page = Page(write(tmp_path, campaign, jobs, []))
    assert "0 of 9 runs are done" in page.text
    assert page.text.count("There are none.") == 2  # tables, figures


def test_no_text_of_a_campaign_becomes_markup(
    campaign: Campaign, jobs: list[Job], records: list[Record], tmp_path: Path
) -> None:
    table = Table(EVIL, (EVIL, "n"), ((Cell.label(EVIL), Cell("1", 1.0)),), EVIL)
    text = write(
        tmp_path, campaign, jobs, records[:-1], [Failure(jobs[-1], EVIL)], {f"a/{EVIL}": table}
    )
    page = Page(text)
    assert "script" not in page.count
    assert page.count["b"] == Page(text.replace(EVIL, "")).count["b"]
    assert page.table(EVIL) == [[EVIL, "n"], [EVIL, "1"]]
    assert page.table("Runs that could not be run")[1][-1] == EVIL
    assert "Two methods <b>on</b> two surfaces." in page.text
    hrefs = [v for tag, name, v in page.attributes if (tag, name) == ("a", "href")]
    assert not [h for h in hrefs if "<" in h or "'" in h]


def test_a_long_table_is_folded(
    campaign: Campaign, jobs: list[Job], records: list[Record], tmp_path: Path
) -> None:
    rows = tuple((Cell(f"p{k}", f"p{k}"), Cell("–", None), Cell("7.5", 7.5)) for k in range(200))
    table = Table("Long", ("problem", "nothing", "n"), rows)
    text = write(tmp_path, campaign, jobs, records, tables={"long": table})
    assert re.search(r"<details>\s*<summary>Long: 200 rows</summary>", text)
    assert len(Page(text).table("Long")) == 201
    assert text.count('<td class="n" data-head="n">7.5</td>') == 200
    assert '<td class="n">–</td>' not in text  # a column of dashes is not one of numbers


def test_large_pictures_are_made_to_fit(tmp_path: Path) -> None:
    figure = Figure(figsize=(3, 3))
    axes = figure.subplots()
    axes.imshow([[(i * 37 + j * j * 11) % 101 for i in range(300)] for j in range(300)])
    noise = CampaignFigure("noise", "Noise", "Nothing to see.", figure)
    draw([noise], tmp_path)
    (full,) = pictures([noise], tmp_path)
    (small,) = pictures([noise], tmp_path, limit=len(full.source) // 2)
    assert len(small.source) <= len(full.source) // 2
    assert (small.width, small.height) == (full.width, full.height) == (288, 288)


def test_a_rare_colour_of_a_picture_stays(tmp_path: Path) -> None:
    figure = Figure(figsize=(6, 6))
    axes = figure.subplots()
    axes.imshow([[i * j for i in range(200)] for j in range(200)], cmap="Greys")
    axes.plot([100], [100], "*", color="#ffd92f", ms=9)
    star = CampaignFigure("star", "Star", "A star on a hill.", figure)
    draw([star], tmp_path)
    (picture,) = pictures([star], tmp_path)
    with Image.open(io.BytesIO(base64.b64decode(picture.source.split(",")[1]))) as image:
        shown = np.asarray(image.convert("RGB")).astype(int)
    with Image.open(tmp_path / "star.png") as image:
        drawn = np.asarray(image.convert("RGB")).astype(int)
    assert np.abs(shown - drawn).max() <= 32
    assert (np.abs(shown - [0xFF, 0xD9, 0x2F]).max(axis=2) <= 8).sum() > 100


def test_the_same_campaign_has_the_same_page(
    campaign: Campaign, jobs: list[Job], records: list[Record], tmp_path: Path
) -> None:
    first = write(tmp_path, campaign, jobs, records)
    assert write(tmp_path, campaign, jobs, records) == first


def test_the_page_says_how_to_make_the_campaign_again(campaign: Campaign) -> None:
    assert command(campaign) == "stribeck bench campaign.toml"
    assert command(campaign.trials(7)) == "stribeck bench campaign.toml --trials 7"
    (name, text), *_ = shipped().items()
    assert command(parsed(text)) == f"stribeck bench {name}"
    assert command(replace(campaign, text="")) == ""  # made in Python


def test_a_study_writes_the_page_beside_its_files(tmp_path: Path) -> None:
    tiny = parsed(FILE.replace("repeats = 3", "repeats = 1").replace('"BF", "SF"', '"BF"'))
    jobs = list(tiny.jobs())
    Study(tiny, jobs, [run(jobs[0])], [Failure(jobs[1], "gone")]).write(tmp_path)
    page = Page((tmp_path / "summary.html").read_text(encoding="utf-8"))
    assert "Not complete: 1 of 2 runs are done. 1 could not be run." in page.text
    assert "stribeck bench campaign.toml" in page.text
    assert page.count["figure"] == len(list((tmp_path / "figures").glob("*.png")))
    files = [v for tag, name, v in page.attributes if (tag, name) == ("a", "href")]
    assert all((tmp_path / f).is_file() for f in files if not f.startswith("#"))
    assert (tmp_path / "summary.html").stat().st_size < 6_000_000
