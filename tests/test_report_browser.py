"""The page of a fit in a real browser: drawn, in bounds, and silent to console and network."""

from __future__ import annotations

import base64
import gzip
import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from browser import CHROMIUM, NO_CHROMIUM, Browser, browser
from stribeck import identify
from stribeck.data.recording import Source
from stribeck.report.contents.gather import Contents
from stribeck.report.page.html_page import write_report
from stribeck.rig.twin import TestBed

pytestmark = pytest.mark.skipif(CHROMIUM is None, reason=NO_CHROMIUM)
#: A name of a log that Plotly could take for a link, or a page for a tag.
NASTY = "<b onclick=alert(1)>a</b><a href='https://example.org'>log</a>.csv"


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The page of a fit to two logs with parts held out: four motions, so that lists appear."""
    folder = tmp_path_factory.mktemp("report")
    logs = [
        replace(TestBed().run("up", seed=k).recording, source=Source(name, f"{k}" * 64, 9))
        for k, name in ((1, NASTY), (2, "other.csv"))
    ]
    fit = identify(logs, rig="slide-bed", train="112:295", holdout="44:112", budget=400, repeats=2)
    write_report(Contents(fit).report(["stribeck", "identify"]), folder)
    return folder / "report.html"


@pytest.fixture(scope="module")
def window(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    with browser(tmp_path_factory.mktemp("profile")) as opened:
        yield opened


@pytest.fixture
def desk_page(window: Browser, page: Path) -> Browser:
    """The page in a desktop window, light theme."""
    window.size(1280, 900)
    window.open(page)
    return window


def plots(window: Browser) -> dict[str, Any]:
    """For each plot the number of traces drawn as lines or marks, and whether it has axes."""
    drawn: dict[str, Any] = window.run(
        """Object.fromEntries([...document.querySelectorAll('.canvas')].map((place) => [place.id, {
          paths: [...place.querySelectorAll('.main-svg .trace path')]
            .filter((path) => (path.getAttribute('d') || '').length > 3).length,
          ticks: place.querySelectorAll('.main-svg .xtick, .main-svg .ytick').length,
          wide: place.querySelector('.main-svg').getBoundingClientRect().width,
        }]))"""
    )
    return drawn


def test_every_plot_is_drawn_without_complaint_or_request(desk_page: Browser, page: Path) -> None:
    assert desk_page.run("document.documentElement.dataset.state") == "drawn"
    assert desk_page.complaints == []
    assert desk_page.requests == [page.resolve().as_uri()]
    named = desk_page.run("Object.keys(JSON.parse(document.getElementById('plots').textContent))")
    drawn = plots(desk_page)
    assert list(drawn) == named
    assert {"log-plot", "fit-0", "residual-0", "residual-1", "residual-2", "friction-curve",
            "profile-1", "convergence-plot"} <= set(drawn)  # fmt: skip
    for name, plot in drawn.items():
        assert plot["paths"] >= 1, name
        assert plot["ticks"] >= 4, name


def test_the_parameters_stand_in_full_on_a_desk(desk_page: Browser) -> None:
    wide = desk_page.run(
        """[...document.querySelectorAll('.scroll')]
        .map(box => [box.ariaLabel, box.scrollWidth - box.clientWidth])"""
    )
    assert dict(wide)["Parameters"] == 0


@pytest.mark.parametrize("dark", [False, True])
def test_nothing_is_wider_than_a_phone(window: Browser, page: Path, *, dark: bool) -> None:
    window.size(390, 844, dark=dark, phone=True)
    window.open(page)
    width = "Math.max(document.documentElement.scrollWidth, document.body.scrollWidth)"
    assert window.run(width) == 390
    assert all(plot["wide"] <= 390 for plot in plots(window).values())
    assert window.complaints == []


def test_parameters_are_cards_on_a_phone_and_a_table_on_a_desk(window: Browser, page: Path) -> None:
    """Each cell stands below the other beside its head, and is as wide as the screen allows."""
    look = """[...document.querySelectorAll('.cards tbody tr:first-child > *')].map((cell) => ({
      left: cell.getBoundingClientRect().left, top: cell.getBoundingClientRect().top,
      head: getComputedStyle(cell, '::before').content,
    }))"""
    window.size(390, 844, phone=True)
    window.open(page)
    name, *cells = window.run(look)
    assert len({cell["left"] for cell in cells}) == 1
    assert [cell["top"] for cell in cells] == sorted(cell["top"] for cell in cells)
    assert cells[0]["head"] == '"value"'
    assert cells[-2]["head"] == '"verdict"'
    assert window.run("document.querySelector('.cards thead').getBoundingClientRect().width") <= 1
    window.size(1280, 900)
    window.open(page)
    name, *cells = window.run(look)
    assert {cell["top"] for cell in cells} == {name["top"]}
    assert {cell["head"] for cell in cells} == {"none"}


def test_names_of_logs_are_text_wherever_they_stand(desk_page: Browser) -> None:
    assert (
        desk_page.run("document.querySelectorAll('main b[onclick], main a[href^=http]').length")
        == 0
    )
    assert NASTY in desk_page.run("document.body.innerText")


def test_the_page_starts_in_the_theme_of_the_system(window: Browser, page: Path) -> None:
    shades = []
    for dark in (False, True):
        window.size(1280, 900, dark=dark)
        window.open(page)
        shades.append(window.run("getComputedStyle(document.body).backgroundColor"))
        assert window.run(PAPER) == shades[-1]
    assert shades[0] == "rgb(255, 255, 255)"
    assert shades[1] != shades[0]


DARK = [{"name": "prefers-color-scheme", "value": "dark"}]
#: The background of a plot.
PAPER = "getComputedStyle(document.querySelector('#fit-0 .main-svg')).backgroundColor"


def test_the_theme_changes_by_keyboard(desk_page: Browser) -> None:
    for _ in range(2):  # past the link that skips to the report
        desk_page.press("Tab", 9)
    assert desk_page.run("document.activeElement.id") == "theme"
    light = desk_page.run(PAPER)
    assert desk_page.run("document.activeElement.textContent") == "Dark theme"
    desk_page.press("Enter", 13, "\r")
    assert desk_page.run("document.documentElement.dataset.theme") == "dark"
    assert desk_page.run("document.activeElement.textContent") == "Light theme"
    dark = desk_page.run(PAPER)
    assert dark != light
    desk_page.press(" ", 32, " ")
    assert desk_page.run(PAPER) == light


def test_the_first_stop_of_the_keyboard_skips_to_the_report(desk_page: Browser) -> None:
    desk_page.press("Tab", 9)
    assert desk_page.run("document.activeElement.textContent") == "Skip to the report"
    assert desk_page.run("document.activeElement.getBoundingClientRect().left") >= 0
    desk_page.press("Enter", 13, "\r")
    assert desk_page.run("document.activeElement.id") == "main"


def test_keys_zoom_and_show_all_again(desk_page: Browser) -> None:
    reach = "document.getElementById('log-plot')._fullLayout.xaxis.range"
    desk_page.run("document.getElementById('log-plot').focus()")
    a, b = desk_page.run(reach)
    desk_page.press("+", 187, "+")
    zoomed = desk_page.run(reach)
    assert zoomed == pytest.approx([a + 0.2 * (b - a), b - 0.2 * (b - a)])
    desk_page.press("ArrowRight", 39)
    assert desk_page.run(reach)[0] == pytest.approx(zoomed[0] + 0.25 * (zoomed[1] - zoomed[0]))
    desk_page.press("0", 48, "0")
    assert desk_page.run(f"new Promise((go) => setTimeout(() => go({reach}), 200))") == [a, b]


def test_a_picked_motion_is_drawn_and_told(desk_page: Browser) -> None:
    alternative_text = "document.getElementById('fit-0-alt').textContent"
    first = desk_page.run(alternative_text)
    count = desk_page.run("document.getElementById('fit-pick').length")
    assert count == 4
    desk_page.run(
        "(() => { const pick = document.getElementById('fit-pick'); pick.selectedIndex = 3;"
        " pick.dispatchEvent(new Event('change')); })()"
    )
    assert desk_page.run(alternative_text) != first
    assert "other.csv" in desk_page.run(alternative_text)
    specs = json.loads(desk_page.run("document.getElementById('plots').textContent"))
    view = specs["fit-0"]["views"][3]
    name = next(line["y"] for line in view["lines"] if line["name"] == "model")
    expected = view["columns"][name][:5]
    drawn = "document.getElementById('fit-0').data.find((t) => t.name === 'model').y"
    assert desk_page.run(f"[...{drawn}].slice(0, 5)") == expected


@pytest.mark.parametrize("aside", [0.0, 2.0])
def test_a_slip_under_the_pointer_is_told(desk_page: Browser, aside: float) -> None:
    """The pointer goes to where the third slip is drawn, which is on the line of the samples."""
    desk_page.ask("Input.dispatchMouseEvent", type="mouseMoved", x=1, y=1)
    x, y = desk_page.run(
        """(() => { const place = document.getElementById('log-plot');
          place.scrollIntoView({ block: 'center', behavior: 'instant' });
          const slip = place.data.find((t) => t.text && t.text[0].startsWith('slip'));
          const { xaxis, yaxis } = place._fullLayout, box = place.getBoundingClientRect();
          globalThis.hovered = new Promise((go) => place.once('plotly_hover', () => go(1)));
          return [box.left + xaxis._offset + xaxis.d2p(slip.x[2]),
                  box.top + yaxis._offset + yaxis.d2p(slip.y[2])]; })()"""
    )
    desk_page.ask("Input.dispatchMouseEvent", type="mouseMoved", x=x + aside, y=y)
    hover_text = desk_page.run(
        "hovered.then(() => document.querySelector('#log-plot .hovertext').textContent)"
    )
    assert hover_text.startswith("slip 3: starts at")
    assert "jump" in hover_text
    assert "greatest speed" in hover_text


def test_paper_is_light_and_no_plot_is_cut(window: Browser, page: Path) -> None:
    window.size(1280, 900, dark=True)
    window.open(page)
    window.run("dispatchEvent(new Event('beforeprint'))")
    window.ask("Emulation.setEmulatedMedia", media="print", features=DARK)
    assert window.run("getComputedStyle(document.body).backgroundColor") in (
        "rgb(255, 255, 255)",
        "rgba(0, 0, 0, 0)",
    )
    paper = 186 / 25.4 * 96  # A4 less its margins, CSS pixels
    assert all(plot["wide"] <= paper for plot in plots(window).values())
    breaks = "[...document.querySelectorAll('figure')].map((f) => getComputedStyle(f).breakInside)"
    assert set(window.run(breaks)) == {"avoid"}
    window.ask("Emulation.setEmulatedMedia", media="screen", features=DARK)
    window.run("dispatchEvent(new Event('afterprint'))")
    assert window.run(PAPER) != "rgb(255, 255, 255)"


def test_another_library_is_not_run_and_the_page_still_says_all(
    window: Browser, page: Path, tmp_path: Path
) -> None:
    """The page's policy names the hash of what it may run."""
    library = base64.b64encode(gzip.compress(b"globalThis.Plotly = { react() {} };")).decode()
    text = page.read_text(encoding="utf-8")
    start = text.index('id="library">') + len('id="library">')
    broken = tmp_path / "broken.html"
    broken.write_text(text[:start] + library + text[text.index("</script>", start) :], "utf-8")
    window.size(1280, 900)
    window.open(broken)
    assert window.run("typeof Plotly") == "undefined"
    assert window.run("document.documentElement.dataset.state") == "failed"
    message = window.run("document.querySelector('#log-plot').textContent")
    assert message.startswith("No plot: the drawing library did not start")
    assert "slips, the median slip" in window.run("document.body.innerText")


def test_a_browser_that_cannot_unpack_says_so(window: Browser, page: Path) -> None:
    window.size(1280, 900)
    script = window.ask(
        "Page.addScriptToEvaluateOnNewDocument", source="delete globalThis.DecompressionStream"
    )
    window.open(page)
    window.ask("Page.removeScriptToEvaluateOnNewDocument", identifier=script["identifier"])
    assert "this browser cannot unpack" in window.run("document.body.innerText")
