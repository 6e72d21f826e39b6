"""A window of the studio in the system's Chromium, driven by Playwright."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from browser import CHROMIUM
from patience import PATIENCE
from studio_server import Studio, start

playwright = pytest.importorskip("playwright.sync_api")


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
        self.files: list[str] = []  # what is chosen when the page asks for files
        self.page.on("filechooser", lambda chooser: chooser.set_files(self.files))

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

    def picture(self, name: str, top: str = "body") -> None:
        """A picture for docs/studio.md from some element on, where a folder for these is stated."""
        at_once = "{behavior: 'instant'}"
        self.page.evaluate(f"document.querySelector({top!r}).scrollIntoView({at_once})")
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


class Mouse:
    """Somebody who points and clicks; the keys are for texts alone.

    Args:
        window: What is in front of them.
    """

    def __init__(self, window: Window) -> None:
        self.window, self.page = window, window.page

    def press(self, selector: str) -> None:
        self.page.click(selector)

    def type(self, selector: str, text: str) -> None:
        self.page.click(selector)
        self.page.keyboard.press("Control+A")
        self.page.keyboard.insert_text(text)
        self.page.click("main h1")  # elsewhere, which is when a field is read

    def choose(self, selector: str, value: str) -> None:
        self.page.select_option(selector, value)

    def pick(self, name: str, value: str) -> None:
        self.page.click(f"input[name={name}][value='{value}']")

    def files(self, selector: str, *files: Path) -> None:
        self.window.files = [str(file) for file in files]
        self.page.click(selector)


class Keys:
    """Somebody without a pointer: Tab, Enter, Space and arrows; their focus is always seen.

    Args:
        window: What is in front of them.
    """

    def __init__(self, window: Window) -> None:
        self.window, self.page = window, window.page

    def to(self, selector: str) -> None:
        """Move the focus to an element by Tab."""
        self.page.wait_for_selector(selector)
        for _ in range(400):
            self.page.keyboard.press("Tab")
            if self.page.evaluate("(s) => document.activeElement.matches(s)", selector):
                outline = "() => getComputedStyle(document.activeElement).outlineStyle"
                assert self.page.evaluate(outline) != "none", selector
                return
        raise AssertionError(f"{selector} cannot be reached by Tab")

    def press(self, selector: str) -> None:
        self.to(selector)
        self.page.keyboard.press("Enter")

    def type(self, selector: str, text: str) -> None:
        self.to(selector)
        self.page.keyboard.press("Control+A")
        self.page.keyboard.insert_text(text)
        self.page.keyboard.press("Tab")

    def choose(self, selector: str, value: str) -> None:
        self.to(selector)
        read = f"document.querySelector({selector!r}).value"
        for _ in range(60):
            if self.page.evaluate(read) == value:
                return
            self.page.keyboard.press("ArrowDown")
            self.page.wait_for_timeout(30)
        raise AssertionError(f"{selector} has no {value}")

    def pick(self, name: str, value: str) -> None:
        self.to(f"input[name={name}]")
        self.page.keyboard.press("Space")
        chosen = f"document.querySelector('input[name={name}]:checked')?.value"
        for _ in range(20):
            if self.page.evaluate(chosen) == value:
                return
            self.page.keyboard.press("ArrowDown")
            self.page.wait_for_timeout(100)
        raise AssertionError(f"{name} has no {value}")

    def files(self, selector: str, *files: Path) -> None:
        self.window.files = [str(file) for file in files]
        self.press(selector)


Hand = Mouse | Keys


@contextmanager
def window(chromium: Any, opened: Studio, **options: Any) -> Iterator[Window]:
    context = chromium.new_context(**{"viewport": {"width": 1280, "height": 900}} | options)
    try:
        yield Window(context, opened)
    finally:
        context.close()


@contextmanager
def studio(home: Path, *logs: Path) -> Iterator[Studio]:
    opened = start(home, *logs)
    try:
        yield opened
    finally:
        opened.end()
