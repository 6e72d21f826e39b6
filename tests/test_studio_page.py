"""The studio in a real browser: what it shows, what goes wrong, and nothing on its console."""

from __future__ import annotations

import os
import re
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from browser import CHROMIUM, NO_CHROMIUM
from studio_server import Studio, bed_log, sliding_log, start
from studio_window import Keys, Mouse, Window, chromium, studio, window

__all__ = ["chromium"]
axe = pytest.importorskip("axe_playwright_python.sync_playwright")
pytestmark = pytest.mark.skipif(CHROMIUM is None, reason=NO_CHROMIUM)
STEPS = ("logs", "look", "axis", "fit", "verdict", "out")
#: The first plot of a page, and its first field.
PLOT = "document.querySelector('.canvas').closest('figure').plot"
FIELD = "document.querySelectorAll('.field input')[0].value"
#: The texts of a page; and what a key looks like that has no words in the catalogue.
TEXTS = """(() => {
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  const texts = [];
  while (walker.nextNode()) texts.push(walker.currentNode.data.trim());
  return texts;
})()"""
KEY = re.compile(r"[a-z]+(\.[a-z_]+)+(?<!\.toml)")
#: Impacts of what axe-core finds that are serious.
SERIOUS = {"serious", "critical"}


@pytest.fixture
def log(tmp_path: Path) -> Path:
    return sliding_log(tmp_path / "axis.csv")


def test_a_plot_is_moved_by_keys_and_a_step_begins_at_its_heading(
    chromium: Any, tmp_path: Path, log: Path
) -> None:
    with studio(tmp_path / "home", log) as opened, window(chromium, opened) as w:
        keys = Keys(w)
        w.open(opened.address)
        keys.press("#next")
        w.drawn()
        assert w.heading() == "Look"
        assert w.page.evaluate("document.activeElement.tagName") == "H1"
        keys.to("#main [role=toolbar] button")
        w.page.keyboard.press("+")
        w.until(f"{PLOT}.scales.x.max < 11")
        w.page.keyboard.press("0")
        w.until(f"{PLOT}.scales.x.max > 11")
        w.is_silent()


def test_a_range_and_the_focus_stay_where_they_were_when_the_findings_come(
    chromium: Any, tmp_path: Path, log: Path
) -> None:
    with studio(tmp_path / "home", log) as opened, window(chromium, opened) as w:
        keys, held = Keys(w), list[Any]()
        w.page.route("**/overview", lambda route: held.append(route))  # noqa: PLW0108 - gets attributes
        w.open(opened.address)
        with w.page.expect_request("**/overview"):
            keys.press("#next")
        w.drawn()
        keys.to("#main [role=toolbar] button")
        w.page.keyboard.press("+")
        w.until(f"{PLOT}.scales.x.max < 11")
        assert w.page.locator("h3:text-is('velocity')").count() == 0
        held[0].continue_()
        w.page.wait_for_selector("h3:text-is('velocity')")
        w.drawn()
        w.page.wait_for_selector(".state.good")
        assert w.page.evaluate(f"{PLOT}.scales.x.max") < 11
        w.page.keyboard.press("0")
        w.until(f"{PLOT}.scales.x.max > 11")
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
        w.page.wait_for_selector("text=The log suggests")
        w.page.wait_for_selector("#composition svg")
        w.picture("axis", "#composition")
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
        w.picture("fit", ".job")
        w.page.click("text=Stop and keep")
        w.page.click("text=See the verdict")
        w.page.wait_for_selector("td .chip")
        w.drawn()
        w.page.wait_for_selector("#headline")
        w.page.click("#next")
        w.page.wait_for_selector("#caution:has-text('v_SS')")
        w.page.wait_for_selector("text=where the search was stopped here")
        w.is_silent()


def test_wrong_files_are_told_and_undone(chromium: Any, tmp_path: Path, log: Path) -> None:
    wrong = tmp_path / "wrong.csv"
    wrong.write_bytes(b"\0\1\2\3")
    with studio(tmp_path / "home", log) as opened, window(chromium, opened) as w:
        w.open(opened.address)
        w.page.set_input_files("#files", str(wrong))
        w.page.wait_for_selector("#steps li.locked:has-text('Look')")
        w.page.click("#steps li.locked:has-text('Look')")
        w.page.wait_for_selector("#told:has-text('cannot be read as it is')")
        w.page.goto(f"{w.page.url.rsplit('/', 1)[0]}/look")
        w.page.wait_for_selector("text=cannot be read as it is")
        w.page.click("text=To what is missing")
        w.page.click("text=Undo")
        w.page.wait_for_selector("#steps a:has-text('Look')")
        assert w.elsewhere == []


def test_a_session_begins_with_a_file_in_any_language(
    chromium: Any, tmp_path: Path, log: Path
) -> None:
    with studio(tmp_path / "home") as opened, window(chromium, opened) as w:
        w.open(opened.address)
        w.page.select_option("#head select", "de")
        w.page.wait_for_selector("h1:has-text('Sitzungen')")
        w.page.set_input_files("#first-files", str(log))
        w.page.wait_for_selector("#read:has-text('Kraft')")
        assert w.page.inner_text("#head .session") == "axis.csv"
        w.page.click("#head .home")
        w.page.wait_for_selector("#main a:has-text('axis.csv')")
        w.is_silent()


def test_a_warning_leads_to_the_field_that_it_names(chromium: Any, finished: Studio) -> None:
    with window(chromium, finished) as w:
        enter(w, finished, "verdict")
        w.page.click("button.way >> nth=0")
        w.until("document.activeElement.id.startsWith('fit-')")
        assert w.heading() == "Fit"
        w.is_silent()


def test_a_range_behind_the_end_is_told_at_once(chromium: Any, tmp_path: Path, log: Path) -> None:
    with studio(tmp_path / "home", log) as opened, window(chromium, opened) as w:
        w.open(opened.address)
        w.open(w.page.url.replace("/logs", "/axis"))
        w.page.click("input[value='forced']")
        w.page.click("#next:not([disabled])")
        w.drawn()
        w.page.fill("#fit-train", "0,5s:2s; 900s:1000s")
        w.page.keyboard.press("Tab")
        w.page.wait_for_selector(".state.warn:has-text('900s:1000s is beyond the end')")
        assert w.page.locator(".state.warn").count() == 1
        w.until(f"{FIELD} === '0.5s:2s; 900s:1000s'")
        w.is_silent()


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


def test_what_was_begun_before_a_redraw_goes_on_behind_it(
    chromium: Any, tmp_path: Path, log: Path
) -> None:
    """A press, a text half typed and an open choice of files, while another window has its say."""
    file = tmp_path / "rig.toml"
    file.write_text('kind = "forced"\n')
    exact = "#main .check input"
    with studio(tmp_path / "home", log) as opened, window(chromium, opened) as w:
        w.open(opened.address)
        other = Window(w.page.context, opened)
        other.open(w.page.url.replace("/logs", "/axis"))
        w.open(other.page.url)
        other.page.click("input[value='slide-bed']")
        w.page.wait_for_selector("input[value='slide-bed']:checked")

        w.page.hover("input[value='forced']")
        w.page.mouse.down()
        other.page.click(exact)
        w.page.wait_for_selector(f"{exact}:checked")
        w.page.mouse.up()
        other.page.wait_for_selector("input[value='forced']:checked")
        other.page.click("text=Undo")
        w.page.wait_for_selector("input[value='slide-bed']:checked")

        w.page.click("#main input.short >> nth=0")
        w.page.keyboard.type("12")
        other.page.click(exact)
        w.page.wait_for_selector(f"{exact}:not(:checked)")
        w.page.keyboard.type("3")
        assert w.page.input_value("#main input.short >> nth=0") == "123"

        w.page.keyboard.press("Tab")
        other.until("document.querySelector('#main input.short').value === '123'")
        other.page.click("#main input.short >> nth=0")  # and nothing is typed there
        w.page.fill("#main input.short >> nth=0", "77")
        w.page.keyboard.press("Tab")
        other.until("document.querySelector('#main input.short').value === '77'")
        assert other.page.evaluate("document.activeElement.matches('#main input.short')")

        with w.page.expect_file_chooser() as chosen:
            w.page.click("#rig-file")
        other.page.click(exact)
        w.page.wait_for_selector(f"{exact}:checked")
        chosen.value.set_files(str(file))
        other.page.wait_for_selector("input[value='axis.toml']:checked")
        w.is_silent()
        other.is_silent()


def test_a_field_stays_where_it_is_when_an_answer_makes_the_page_shorter(
    chromium: Any, tmp_path: Path
) -> None:
    """A drive that lacks less has less told above and below its form; the page was at its end."""
    rows = [f"{k * 0.01:.2f},{np.sin(k * 0.05):.5f},{k % 7}" for k in range(500)]
    file = tmp_path / "share.csv"
    file.write_text("\n".join(["time [s],position [mm],torque [%]", *rows]) + "\n")
    top = "document.querySelector('#drive-lead').getBoundingClientRect().top"
    with studio(tmp_path / "home", file) as opened, window(chromium, opened) as w:
        hand, held = Mouse(w), list[Any]()
        w.open(opened.address)
        hand.choose("select[aria-label^='torque']", "force")
        hand.choose("#drive-convention", "ax5000")
        hand.press("#drive-peak_torque")
        w.page.keyboard.insert_text("5 N m")
        w.page.evaluate("scrollTo(0, document.documentElement.scrollHeight)")
        w.page.route("**/api/sessions/*", lambda route: held.append(route))  # noqa: PLW0108 - gets attributes
        with w.page.expect_request(lambda request: request.method == "PATCH"):
            hand.press("#drive-lead")
        before, height = w.page.evaluate(f"[{top}, document.querySelector('.drive').offsetHeight]")
        held[0].continue_()
        w.page.unroute("**/api/sessions/*")
        w.until(f"document.querySelector('.drive').offsetHeight < {height}")
        assert w.page.evaluate(top) == pytest.approx(before, abs=1.0)
        w.page.keyboard.insert_text("10 mm")
        w.page.keyboard.press("Tab")
        w.page.wait_for_selector("#channels:not(:has(#lacking))")
        w.is_silent()


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
        for step in STEPS:
            enter(w, finished, step)
            if step in ("look", "fit", "verdict"):
                w.drawn()
            if step == "logs":
                w.page.wait_for_selector("#channels table")
            if step == "axis":
                w.page.wait_for_selector("svg.composition")
            if step == "fit":
                w.until("/0[.,\u202f]?0/.test(document.querySelector('#duration').textContent)")
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


def test_what_is_known_of_a_part_is_asked_in_the_unit_that_its_axis_reads(
    chromium: Any, finished: Studio
) -> None:
    """The motor in front of a screw turns: its inertia is in kg m², on an axis that slides."""
    read = finished.ask("GET", finished.session).json["axis"]["constants"]
    with window(chromium, finished) as w:
        enter(w, finished, "axis")
        w.page.wait_for_selector("tr[data-key='motor force armature']")
        rows = w.page.eval_on_selector_all(
            "tr[data-key^='motor '], tr[data-key^='transmission '], tr[data-key^='load ']",
            "rows => rows.map(r => [r.dataset.key.split(' ')[2], r.cells[2].innerText])",
        )
        asked = dict(rows)
        for name in asked.keys() & read.keys():
            assert asked[name] == (read[name]["unit"] or "1"), name
        assert (asked["armature"], asked["F_max"], asked["k_spring"]) == ("kg m**2", "N m", "N/m")
        w.is_silent()


def enter(w: Window, opened: Studio, step: str) -> None:
    """Open a step of the session of a studio that others have entered."""
    name, _, value = opened.cookie.partition("=")
    place = f"http://127.0.0.1:{opened.port}"
    w.page.context.add_cookies([{"name": name, "value": value, "url": place}])
    w.open(f"{place}/s/{opened.session.rsplit('/', 1)[1]}/{step}")


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Studio]:
    """A studio with a fit that is done, and then an axis of parts behind a drive."""
    folder = tmp_path_factory.mktemp("studio")
    with studio(folder / "home", sliding_log(folder / "Axis 1.csv")) as opened:
        opened.enter()
        opened.choose(rig="forced", law="coulomb-viscous")
        opened.until(opened.work("identify")["id"], "done")
        parts = {
            "controller": {"none": {}}, "motor": {"force": {"F_max": "80 nameplate"}},
            "transmission": {"screw": {"lead": 0.01}},
            "sensor": {"lead-error": {"err_period": 0.01, "err_sin": 1e-5}},
            "load": {"mass": {}, "spring": {"k_spring": 1}},
        }  # fmt: skip
        state = opened.choose(rig="axis.toml", axis=parts, law="", drive={"signal": "N"})
        assert [step["name"] for step in state["steps"] if step["lock"]] == []
        yield opened


@pytest.mark.recordings("logs")
def test_a_twincat_file_as_it_is(chromium: Any, tmp_path: Path) -> None:
    folder = Path(__file__).parents[2] / "shared" / "data" / "logs"
    (file, *_) = sorted((folder / "twincat").glob("*.csv"))
    with studio(tmp_path / "home") as opened, window(chromium, opened) as w:
        w.open(opened.address)
        w.page.click("form button")
        w.page.set_input_files("#files", str(file))
        w.page.wait_for_selector("#channels table")
        assert "twincat" in w.page.inner_text("#channels").lower()
        w.is_silent()
