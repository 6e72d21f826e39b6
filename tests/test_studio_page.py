"""The studio in a real browser: the whole way by mouse and by keys, and nothing on its console."""

from __future__ import annotations

import os
import re
import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from browser import CHROMIUM, NO_CHROMIUM
from patience import PATIENCE
from studio_server import Studio, bed_log, sliding_log, start

playwright = pytest.importorskip("playwright.sync_api")
axe = pytest.importorskip("axe_playwright_python.sync_playwright")
pytestmark = pytest.mark.skipif(CHROMIUM is None, reason=NO_CHROMIUM)
STEPS = ("logs", "look", "axis", "fit", "verdict", "out")
#: The first plot of a page, its chosen rig, and its first field.
PLOT = "document.querySelector('.canvas').closest('figure').plot"
CHOSEN = "document.querySelector('input[name=rig]:checked')?.value"
FIELD = "document.querySelectorAll('.field input')[0].value"
#: The texts of a page; and what a key looks like that has no words in the catalogue.
TEXTS = """(() => {
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  const texts = [];
  while (walker.nextNode()) texts.push(walker.currentNode.data.trim());
  return texts;
})()"""
KEY = re.compile(r"[a-z]+(\.[a-z_]+)+")
DRAWN = "[...document.querySelectorAll('.canvas')].every((c) => c.querySelector('canvas'))"
#: Impacts of what axe-core finds that are serious.
SERIOUS = {"serious", "critical"}


@pytest.fixture(scope="module")
def chromium() -> Iterator[Any]:
    with playwright.sync_playwright() as driver:
        opened = driver.chromium.launch(
            executable_path=CHROMIUM, args=["--no-sandbox", "--disable-dev-shm-usage"]
        )
        yield opened
        opened.close()


class Window:
    """A window of the studio that remembers what it should not have said or asked for.

    Args:
        context: Of the browser.
        opened: The studio.
    """

    def __init__(self, context: Any, opened: Studio) -> None:
        self.ports = {opened.port}
        self.page = context.new_page()
        self.page.set_default_timeout(1e3 * PATIENCE)
        self.complaints: list[str] = []
        self.elsewhere: list[str] = []
        self.page.on("console", lambda message: self.complaints.append(message.text))
        self.page.on("pageerror", lambda error: self.complaints.append(str(error)))
        self.page.on("request", self._asked)

    def _asked(self, request: Any) -> None:
        own = tuple(f"http://127.0.0.1:{port}/" for port in self.ports)
        if not request.url.startswith((*own, "blob:", "data:")):
            self.elsewhere.append(request.url)

    def open(self, address: str) -> None:
        self.page.goto(address)
        self.page.wait_for_selector("main h1")

    def is_silent(self) -> None:
        assert self.complaints == []
        assert self.elsewhere == []

    def picture(self, name: str) -> None:
        """A picture for docs/studio.md, where a folder for these is stated."""
        if folder := os.environ.get("STRIBECK_PICTURES"):
            self.page.mouse.move(2, 2)
            self.page.screenshot(path=Path(folder) / f"studio-{name}.png")

    def heading(self) -> str:
        return str(self.page.inner_text("main h1"))

    def until(self, condition: str) -> None:
        """Wait until an expression holds; the page's policy lets nothing be evaluated in it."""
        end = time.monotonic() + PATIENCE
        while not self.page.evaluate(condition):
            assert time.monotonic() < end, condition
            self.page.wait_for_timeout(50)

    def drawn(self) -> None:
        """Wait until every plot of the page is drawn."""
        self.page.wait_for_selector(".u-over")
        self.until(
            "[...document.querySelectorAll('.canvas')].every((c) => c.querySelector('canvas'))"
        )


@contextmanager
def window(chromium: Any, opened: Studio, **options: Any) -> Iterator[Window]:
    context = chromium.new_context(**{"viewport": {"width": 1280, "height": 900}} | options)
    try:
        yield Window(context, opened)
    finally:
        context.close()


@pytest.fixture
def log(tmp_path: Path) -> Path:
    return sliding_log(tmp_path / "axis.csv")


@contextmanager
def studio(home: Path, *logs: Path) -> Iterator[Studio]:
    opened = start(home, *logs)
    try:
        yield opened
    finally:
        opened.end()


def identify(page: Any, rig: str) -> None:
    """From the page of logs to the verdict, by mouse."""
    page.click("text=Look at the log")
    page.wait_for_selector(".u-over")
    page.click("text=Describe the axis")
    page.click(f"input[value='{rig}']")
    page.click("#next:not([disabled])")
    page.wait_for_selector("#run")
    page.click("#run")
    page.click("text=See the verdict")
    page.wait_for_selector("td .chip")


def test_the_whole_way_by_mouse(chromium: Any, tmp_path: Path, log: Path) -> None:
    with studio(tmp_path / "home") as opened, window(chromium, opened) as w:
        w.open(opened.address)
        w.page.fill("#name", "my axis")
        w.page.click("text=New session")
        w.page.wait_for_selector("#files")
        w.page.set_input_files("#files", str(log))
        w.page.wait_for_selector("text=Columns and what they are taken for")
        w.picture("logs")
        identify(w.page, "forced")
        row = w.page.inner_text("tr:has(th:text-is('M'))")
        assert float(row.split("\t")[1]) == pytest.approx(2.0, rel=0.02)
        assert "identified" in row
        w.drawn()
        w.page.click("text=Take it out")
        w.page.wait_for_selector("pre:has-text('FUNCTION_BLOCK')")
        w.picture("out")
        with w.page.expect_download() as download:
            w.page.click("a.download")
        assert "FUNCTION_BLOCK" in Path(download.value.path()).read_text(encoding="utf-8")
        command = w.page.inner_text(".copy pre")
        assert command.startswith("stribeck identify axis.csv --rig forced")
        w.is_silent()


def test_the_whole_way_by_keys(chromium: Any, tmp_path: Path, log: Path) -> None:
    """No pointer: Tab, Enter, Space and arrows, and always a focus that can be seen."""

    with studio(tmp_path / "home", log) as opened, window(chromium, opened) as w:
        w.open(opened.address)
        w.page.wait_for_selector("text=Look at the log")

        def tab_to(selector: str) -> None:
            w.page.wait_for_selector(selector)
            for _ in range(200):
                w.page.keyboard.press("Tab")
                if w.page.evaluate("(s) => document.activeElement.matches(s)", selector):
                    outline = w.page.evaluate(
                        "() => getComputedStyle(document.activeElement).outlineStyle"
                    )
                    assert outline != "none", selector
                    return
            raise AssertionError(f"{selector} cannot be reached by Tab")

        tab_to("#main button.main")
        w.page.keyboard.press("Enter")
        w.drawn()
        assert w.heading() == "Look"
        assert w.page.evaluate("document.activeElement.tagName") == "H1"
        tab_to("#main [role=toolbar] button")
        w.page.keyboard.press("+")
        w.until(f"{PLOT}.scales.x.max < 11")
        tab_to("#main button.main")
        w.page.keyboard.press("Enter")
        tab_to("#main input[name=rig]")
        w.page.keyboard.press("Space")
        for _ in range(12):
            if w.page.evaluate(CHOSEN) == "forced":
                break
            w.page.keyboard.press("ArrowDown")
            w.page.wait_for_timeout(100)
        w.page.wait_for_selector("#next:not([disabled])")
        tab_to("#next")
        w.page.keyboard.press("Enter")
        tab_to("#run")
        w.page.keyboard.press("Enter")
        tab_to(".job button.main")
        w.page.keyboard.press("Enter")
        w.page.wait_for_selector("td .chip")
        assert w.heading() == "Verdict"
        tab_to("#main button.main")
        w.page.keyboard.press("Enter")
        w.page.wait_for_selector("pre:has-text('FUNCTION_BLOCK')")
        w.is_silent()


def test_a_search_is_drawn_as_it_goes_stopped_and_kept(chromium: Any, tmp_path: Path) -> None:
    bed = bed_log(tmp_path / "bed.csv")
    with studio(tmp_path / "home", bed) as opened, window(chromium, opened) as w:
        w.open(opened.address)
        w.page.click("text=Look at the log")
        w.page.wait_for_selector(".tiles:has-text('slips')")
        w.drawn()
        w.picture("look")
        w.page.click("text=Describe the axis")
        w.page.click("input[value='slide-bed']")
        w.page.wait_for_selector("tr.untouched:has-text('F_fm')")
        w.page.fill("input[aria-label^='F_fm:']", "20±5")
        w.page.keyboard.press("Tab")
        w.page.wait_for_selector("tr:not(.untouched):has-text('F_fm')")
        w.picture("axis")
        w.page.click("#next:not([disabled])")
        w.drawn()
        box = w.page.locator(".u-over").first.bounding_box()
        w.page.mouse.move(box["x"] + 0.3 * box["width"], box["y"] + 40)
        w.page.mouse.down()
        w.page.mouse.move(box["x"] + 0.6 * box["width"], box["y"] + 50, steps=4)
        w.page.mouse.up()
        w.until(f"/^[\\d.]+s:[\\d.]+s$/.test({FIELD})")
        w.page.click("text=Search, loss, delay")
        w.page.locator(".field:has-text('Evaluations at most') input").fill("100000000")
        w.page.locator(".field:has-text('Search method') select").select_option("bts")
        w.page.click("#run")
        w.page.wait_for_selector(".job .u-over")
        w.page.locator(".job").scroll_into_view_if_needed()
        w.picture("fit")
        w.page.click("text=Stop and keep")
        w.page.click("text=See the verdict")
        w.page.wait_for_selector("td .chip")
        w.drawn()
        w.picture("verdict")
        w.is_silent()


def test_wrong_files_are_told_and_undone(chromium: Any, tmp_path: Path, log: Path) -> None:
    wrong = tmp_path / "wrong.csv"
    wrong.write_bytes(b"\0\1\2\3")
    with studio(tmp_path / "home", log) as opened, window(chromium, opened) as w:
        w.open(opened.address)
        w.page.set_input_files("#files", str(wrong))
        w.page.wait_for_selector("#steps li.locked:has-text('Look')")
        w.page.goto(f"{w.page.url.rsplit('/', 1)[0]}/look")
        w.page.wait_for_selector("text=cannot be read as it is")
        w.page.click("text=To what is missing")
        w.page.click("text=Undo")
        w.page.wait_for_selector("#steps a:has-text('Look')")
        assert w.elsewhere == []


def test_two_windows_show_the_same(chromium: Any, tmp_path: Path, log: Path) -> None:
    with studio(tmp_path / "home", log) as opened, window(chromium, opened) as w:
        w.open(opened.address)
        other = Window(w.page.context, opened)
        other.open(w.page.url.replace("/logs", "/axis"))
        w.open(w.page.url.replace("/logs", "/axis"))
        other.page.click("input[value='forced']")
        w.page.wait_for_selector("input[value='forced']:checked")
        w.page.click("text=Undo")
        other.until("!document.querySelector('input[name=rig]:checked')")
        w.is_silent()
        other.is_silent()


def test_a_page_goes_on_after_its_studio_was_killed(
    chromium: Any, tmp_path: Path, log: Path
) -> None:
    opened = start(tmp_path / "home", log)
    with window(chromium, opened) as w:
        w.open(opened.address)
        w.open(w.page.url.replace("/logs", "/axis"))
        w.page.click("input[value='forced']")
        w.page.wait_for_selector("#next:not([disabled])")
        os.kill(opened.process.pid, signal.SIGKILL)
        opened.end()
        w.page.click("input[value='emps']")
        w.page.wait_for_selector("text=does not answer")
        again = start(tmp_path / "home")
        try:
            w.ports.add(again.port)
            w.open(re.sub(r":\d+/", f":{again.port}/", w.page.url))
            assert w.page.is_checked("input[value='forced']")
            assert w.elsewhere == []
        finally:
            again.end()


@pytest.mark.parametrize("theme", ["light", "dark"])
@pytest.mark.parametrize(("width", "language"), [(1280, "en"), (390, "de"), (390, "zh")])
def test_every_step_can_be_read_by_everybody(
    chromium: Any, finished: Studio, theme: str, width: int, language: str
) -> None:
    """No serious finding of axe-core, nothing beside the page, no word without a translation."""
    size = {"width": width, "height": 900}
    with window(chromium, finished, viewport=size, color_scheme=theme, locale=language) as w:
        name, _, value = finished.cookie.partition("=")
        place = f"http://127.0.0.1:{finished.port}"
        w.page.context.add_cookies([{"name": name, "value": value, "url": place}])
        session = finished.session.rsplit("/", 1)[1]
        for step in STEPS:
            w.open(f"{place}/s/{session}/{step}")
            if step in ("look", "fit", "verdict"):
                w.drawn()
            if step == "logs":
                w.page.wait_for_selector("#channels table")
            if step == "out":
                w.page.wait_for_selector(".copy pre")
            wide = w.page.evaluate("document.documentElement.scrollWidth - innerWidth")
            assert wide <= 0, step
            results = axe.Axe().run(w.page).response["violations"]
            serious = [
                (each["id"], [node["html"][:200] for node in each["nodes"][:3]])
                for each in results
                if each["impact"] in SERIOUS
            ]
            assert serious == [], step
            keys = [text for text in w.page.evaluate(TEXTS) if KEY.fullmatch(text)]
            assert keys == [], step
        w.is_silent()


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Studio]:
    """A studio with a fit that is done."""
    folder = tmp_path_factory.mktemp("studio")
    with studio(folder / "home", sliding_log(folder / "Axis 1.csv")) as opened:
        opened.enter()
        opened.choose(rig="forced", law="coulomb-viscous")
        opened.until(opened.work("identify")["id"], "done")
        yield opened


@pytest.mark.recordings("logs")
def test_a_twincat_file_as_it_is(chromium: Any, tmp_path: Path) -> None:
    folder = Path(__file__).parents[2] / "shared" / "data" / "logs"
    (file, *_) = sorted((folder / "twincat").glob("*.csv"))
    with studio(tmp_path / "home") as opened, window(chromium, opened) as w:
        w.open(opened.address)
        w.page.click("text=New session")
        w.page.set_input_files("#files", str(file))
        w.page.wait_for_selector("#channels table")
        assert "twincat" in w.page.inner_text("#channels").lower()
        w.is_silent()
