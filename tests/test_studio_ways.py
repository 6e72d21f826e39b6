"""The whole way through the studio, from the file of a drive to code, by mouse and by keys alone.

What a way ends with is known: from how the log was made, or from what was published. Searches have
small budgets: the way is under test here, and not the search.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from browser import CHROMIUM, NO_CHROMIUM
from conftest import RECORDINGS
from stribeck.space import Array
from studio_server import bed_log
from studio_window import Hand, Keys, Mouse, chromium, studio, window

__all__ = ["chromium"]
pytestmark = pytest.mark.skipif(CHROMIUM is None, reason=NO_CHROMIUM)
RIGS = Path(__file__).parents[1] / "docs" / "rigs"
#: A screw of 10 mm behind a motor whose 1000 ‰ are 5 N m, in N for one ‰: 2 π 5 N m / (1000 10 mm).
PER_MILLE = 2 * np.pi * 5.0 / (1000 * 0.010)
SCOPE = """Name\tpress
File\tC:\\press.csv
Starttime of export\t132959733843760000\tMonday\t15:56:24
Endtime of export\t132959733853750000\tMonday\t15:56:25


Name\tActPos\tActTorque
SymbolComment\t\t
Data-Type\tREAL64\tREAL32
SampleTime[ms]\t2\t2
Unit\tmm (Length)\t(None)

"""


def press(interval: float) -> tuple[Array, Array, Array]:
    """Times, positions and forces, SI, of a press of 40 kg with friction 60 N + 300 N s/m."""
    t = np.arange(0.0, 8.0, interval)
    w = 2 * np.pi * 0.6
    x, v, a = 0.1 * np.sin(w * t), 0.1 * w * np.cos(w * t), -0.1 * w * w * np.sin(w * t)
    force = 40.0 * a + 60.0 * np.tanh(v / 1e-4) + 300.0 * v
    return t, x, force + np.random.default_rng(5).normal(0.0, 0.5, len(t))


def scope(folder: Path) -> list[Path]:
    """A TwinCAT scope of a press, torque in ‰."""
    t, x, force = press(2e-3)
    rows = [
        f"{1e3 * each[0]:.6g}\t{1e3 * each[1]:.9g}\t{each[2] / PER_MILLE:.6g}"
        for each in np.stack([t, x, force], axis=1)
    ]
    file = folder / "press.csv"
    file.write_text(SCOPE + "\n".join(rows) + "\nEOF\n", encoding="utf-8")
    return [file]


def of_a_press(hand: Hand) -> None:
    """Torque has no unit and is given one that says nothing; then the drive is described."""
    hand.type("input[aria-label='ActTorque: unit']", "‰")
    hand.choose("#drive-convention", "ax5000")
    hand.type("#drive-peak_torque", "5 N m")
    hand.type("#drive-lead", "10 mm")


def plc(folder: Path) -> list[Path]:
    """The same press as a German PLC exports it: cp1252, decimal commas, torque at a quarter."""
    t, x, force = press(1e-3)
    lines = ["Zeit [ms];Lageistwert [mm];Momentenistwert [‰]"]
    for k, (at, way, push) in enumerate(zip(1e3 * t, 1e3 * x, force / PER_MILLE, strict=True)):
        torque = f"{push:.6g}" if k % 4 == 0 else ""
        lines.append(f"{at:.6g};{way:.9g};{torque}".replace(".", ","))
    file = folder / "Presse.csv"
    file.write_bytes("\r\n".join([*lines, ""]).encode("cp1252"))
    return [file]


def of_a_plc(hand: Hand) -> None:
    """Torque stands with its unit, and numbers are typed as a German types them."""
    hand.press("#also")
    hand.press("#to-drive")
    hand.choose("#drive-convention", "cia402-torque")
    hand.type("#drive-rated_torque", "5,0 Nm")
    hand.type("#drive-lead", "10 mm")


@dataclass(frozen=True)
class Way:
    """A way through the studio.

    Args:
        logs: The logs, some of which are made in a folder.
        read: What has to be said so that they are read.
        axis: What has to be said of the axis.
        search: Budget; 0 for an axis whose fit is no search.
        train: What is trained on; everything where empty.
        known: Parameters with what they are, and by which share a fit may miss it.
    """

    logs: Callable[[Path], list[Path]]
    read: Callable[[Hand], None] | None
    axis: Callable[[Hand], None] | None
    search: int
    train: str
    known: dict[str, tuple[float, float]]


WAYS = {
    "twincat": Way(
        scope, of_a_press, lambda hand: hand.pick("rig", "forced"), 0, "",
        {"M": (40.0, 0.02), "F_C": (60.0, 0.05), "F_V": (300.0, 0.05)},
    ),
    "plc": Way(
        plc, of_a_plc, lambda hand: hand.pick("rig", "forced"), 0, "",
        {"M": (40.0, 0.02), "F_C": (60.0, 0.05), "F_V": (300.0, 0.05)},
    ),
    "twin": Way(
        lambda folder: [bed_log(folder / "twin.csv")], None,
        lambda hand: hand.pick("rig", "slide-bed"), 60, "112:200", {},
    ),
    "emps": Way(
        lambda _: [RECORDINGS / "emps" / "DATA_EMPS.mat"],
        lambda hand: hand.press("#as-rig"), None, 0, "", {"M": (95.1089, 1e-4)},
    ),
    "openarm": Way(
        lambda _: [RECORDINGS / "openarm" / "collect_joint_3.csv"], None,
        lambda hand: hand.files("#rig-file", RIGS / "openarm_joint_3.toml"), 40, "0s:4s", {},
    ),
    "xl330": Way(
        lambda _: sorted((RECORDINGS / "bam_xl330" / "logs").glob("*.json"))[:16],
        lambda hand: hand.press("#as-rig"), None, 20, "0s:1s", {},
    ),
}  # fmt: skip
REAL = {"emps": "emps", "openarm": "openarm", "xl330": "bam_xl330"}


def marks(name: str) -> list[pytest.MarkDecorator]:
    """The recordings that a way needs."""
    return [pytest.mark.recordings(REAL[name])] if name in REAL else []


@pytest.mark.parametrize(
    ("name", "hands"),
    [pytest.param(name, hands, marks=marks(name)) for name in WAYS for hands in (Mouse, Keys)],
)
def test_the_whole_way(chromium: Any, tmp_path: Path, name: str, hands: type[Mouse | Keys]) -> None:
    way, pictured = WAYS[name], (name, hands) == ("twincat", Mouse)
    with studio(tmp_path / "home") as opened, window(chromium, opened) as w:
        hand, page = hands(w), w.page
        w.open(opened.address)
        hand.type("#name", name)
        hand.press("form button")
        logs = way.logs(tmp_path)
        hand.files("#files", *logs)
        w.until(f"document.querySelectorAll('th button.link').length === {len(logs)}")
        page.wait_for_selector("#channels table")
        if way.read:
            way.read(hand)
            page.wait_for_selector("#next")
            page.wait_for_selector("#channels:not(:has(#lacking))")
        if pictured:
            w.picture("logs", "#channels table")
        hand.press("#next")
        w.drawn()
        hand.press("#next")
        page.wait_for_selector("input[name=rig]")
        if way.axis:
            way.axis(hand)
        page.wait_for_selector(".composition")
        hand.press("#next:not([disabled])")
        w.drawn()
        if way.train:
            hand.type("#fit-train", way.train)
        if way.search:
            hand.press("#fit-more")
            hand.type("#fit-budget", str(way.search))
            hand.type("#fit-repeats", "1")
            w.until(f"document.querySelector('#duration').textContent.includes(' {way.search} ')")
        hand.press("#run")
        hand.press(".job button.main")
        page.wait_for_selector("td .chip")
        for parameter, (value, share) in way.known.items():
            cells = page.inner_text(f"tr:has(th:text-is('{parameter}'))").split("\t")
            assert float(cells[2]) == pytest.approx(value, rel=share)
        if pictured:
            w.picture("verdict")
        hand.press("#next")
        page.wait_for_selector("pre:has-text('FUNCTION_BLOCK')")
        page.wait_for_selector(".copy pre:has-text('stribeck identify')")
        if pictured:
            w.picture("out")
        with page.expect_download() as download:
            hand.press("a.download")
        block = Path(download.value.path()).read_text(encoding="utf-8")
        assert re.search(r"FUNCTION_BLOCK \w+", block)
        w.is_silent()
