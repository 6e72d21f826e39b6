"""The main job, end to end: record the twin, identify both directions, validate, compare.

Runs the commands of a user, then prints the twin's true values, which are the published ones,
beside the identified ones. All files go to demo/.
"""

from __future__ import annotations

import json
import shlex
import subprocess
import sys
from pathlib import Path

from rich.console import Console

from stribeck.report.format import number
from stribeck.report.table import Table
from stribeck.report.terminal import show_table

DEMO = Path("demo")
PUBLISHED_J = {"right": 5.3822, "left": 4.2114}
RUNS = {
    "right": ["--train", "112:295", "--holdout", "44:112", "--holdout", "295:352"],
    "left": ["--train", "325:127", "--holdout", "352:325", "--holdout", "127:68"],
}


def stribeck(*words: str) -> None:
    """Show a command and run it."""
    print(f"\n$ stribeck {shlex.join(words)}", flush=True)
    code = subprocess.run([sys.executable, "-m", "stribeck", *words], check=False).returncode  # noqa: S603
    if code:
        sys.exit(code)


def main() -> None:
    """Run the demo from the repository's root."""
    DEMO.mkdir(exist_ok=True)
    log = str(DEMO / "twin.csv")
    stribeck("twin", log, "--direction", "both", "--loop", "ideal")
    stribeck("check", log)
    for side, ranges in RUNS.items():
        stribeck(
            "identify", log, "--rig", "slide-bed", "--exact", "--law", "stribeck", *ranges,
            "--out", str(DEMO / side),
        )  # fmt: skip
    truth = json.loads((DEMO / "twin.truth.json").read_text())["parameters"]
    console = Console(highlight=False, width=100)
    for side, sign in (("right", "+"), ("left", "-")):
        card = json.loads((DEMO / side / "card.json").read_text())
        console.print(
            f"\n[bold]{side}ward[/]: the twin, made with the published values, and what was found"
        )
        show_table(_table(card["parameters"], truth, sign))
        holdout = ", ".join(f"{h['range']} {h['value']:.3g}" for h in card["holdout"])
        console.print(
            f"J = {card['objective']['value']:.3g} mm in training (published for the real bed: "
            f"{PUBLISHED_J[side]} mm), held out {holdout} mm"
        )
    stribeck("export", str(DEMO / "left" / "card.json"), "--to", "c", "--out", str(DEMO / "c"))
    print(
        f"\nCards and figures: {DEMO / 'right'}, {DEMO / 'left'}; open {DEMO / 'left'}/report.html"
    )


def _table(
    estimates: dict[str, dict[str, float]], truth: dict[str, dict[str, float]], sign: str
) -> Table:
    rows = []
    for name, p in estimates.items():
        true = truth[f"{name}{sign}"]["value"]
        rows.append([
            name, number(true), number(p["value"]), f"{p['value'] / true - 1:+.1%}",
            f"{number(p['low'], 4)} to {number(p['high'], 4)}", str(p["unit"]), str(p["verdict"]),
        ])  # fmt: skip
    heads = ["parameter", "true", "identified", "off by", "95 % interval", "unit", "verdict"]
    return Table.of_texts("", heads, rows)


if __name__ == "__main__":
    main()
