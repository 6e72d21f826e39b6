"""The pages as a site: built without a warning, whole, and silent to every other host."""

from __future__ import annotations

import re
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path

import pytest

import stribeck

DOCS = Path(__file__).parents[1] / "docs"
PATIENCE = 600
#: What a browser fetches by itself when it opens a page, by tag and attribute.
FETCHED = {
    ("script", "src"),
    ("img", "src"),
    ("link", "href"),
    ("iframe", "src"),
    ("source", "src"),
}


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("site")
    built = subprocess.run(
        [sys.executable, "-m", "sphinx", "--nitpicky", "--fail-on-warning", "--keep-going",
         "--quiet", "-d", str(folder / "doctrees"), "-b", "html", str(DOCS), str(folder / "html")],
        check=False, capture_output=True, text=True, timeout=PATIENCE,
    )  # fmt: skip
    assert built.returncode == 0, built.stdout + built.stderr
    return folder / "html"


class Page(HTMLParser):
    """What a page fetches, what it links to, and the anchors that it has."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.fetched: list[str] = []
        self.links: list[str] = []
        self.anchors: set[str] = set()
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        for name, value in attrs:
            if name == "id" and value:
                self.anchors.add(value)
            elif (tag, name) in FETCHED and value:
                self.fetched.append(value)
            elif (tag, name) == ("a", "href") and value:
                self.links.append(value)


def pages(site: Path) -> dict[Path, Page]:
    return {path: Page(path) for path in sorted(site.rglob("*.html"))}


def test_every_page_of_the_docs_is_in_it_and_can_be_searched(site: Path) -> None:
    index = (site / "searchindex.js").read_text(encoding="utf-8")
    for source in [*DOCS.glob("*.md"), *DOCS.glob("exports/*.md"), *DOCS.glob("notebooks/*.ipynb")]:
        name = source.relative_to(DOCS).with_suffix("")
        assert (site / f"{name}.html").is_file(), name
        assert f'"{name}"' in index, name


def test_it_asks_no_other_host(site: Path) -> None:
    for path, page in pages(site).items():
        foreign = [place for place in page.fetched if re.match(r"(?:[a-z]+:)?//", place)]
        assert not foreign, path
    for sheet in site.rglob("*.css"):
        text = sheet.read_text(encoding="utf-8")
        assert not re.findall(r"(?:url\(|@import)\s*[\"']?(?:https?:)?//", text), sheet


def test_every_link_within_it_leads_somewhere(site: Path) -> None:
    all_pages = pages(site)
    for path, page in all_pages.items():
        for link in page.links:
            place, _, anchor = link.partition("#")
            if re.match(r"[a-z]+:", link):
                continue
            target = (path.parent / place).resolve() if place else path
            assert target.is_file(), (path, link)
            if anchor and target in all_pages:
                assert anchor in all_pages[target].anchors, (path, link)


def test_every_public_name_has_an_entry(site: Path) -> None:
    anchors = Page(site / "api.html").anchors
    names = {name for name in stribeck.__all__ if not name.startswith("_")}
    assert {name.lower() for name in names} <= {anchor.replace("-", "_") for anchor in anchors}
