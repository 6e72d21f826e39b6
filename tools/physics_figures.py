"""Draw the slide bed's stick-slip over the step, by scheme, for both published sets.

A minute of ramp at 5 mm/s from rest: length of the jumps,
number of slips and share of the time stuck, with the printed explicit procedure, with the plain
reference, and with the fast integrator, which has no step. Writes the figure to docs/figures and
the numbers to docs/data/step_dependence.json.
"""

from __future__ import annotations

import json
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from stribeck.friction import LAWS
from stribeck.report.figures.style import COMMAND, INK, MEASURED, MODEL, STYLE, save
from stribeck.rig.motion import reference
from stribeck.rig.motion.command import Drive
from stribeck.rig.motion.event_driven import trajectories
from stribeck.rig.motion.track import Track, track
from stribeck.rig.slide_bed import PUBLISHED, SLIDE_BED

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from stribeck.space import Array

DOCS = Path(__file__).parents[1] / "docs"
LAW = LAWS["stribeck"]
SECONDS, SPEED = 60.0, 5e-3
REST = 5  # samples
STEPS = np.geomspace(1e-5, 1e-2, 25)
TITLES = {"right": "Rightward", "left": "Leftward"}


@dataclass(frozen=True)
class Slips:
    """Statistics of a minute of ramp: slips, mean and spread of their lengths, share stuck."""

    scheme: str
    step_s: float
    slips: int
    jump_mm: float
    least_mm: float
    most_mm: float
    stuck: float


def minute(direction: str) -> Track:
    """The ramp, sampled at 100 Hz: the reference meets each sample, so no step is longer."""
    t = np.arange(0.0, SECONDS + 5e-3, 1e-2)
    sign = 1 if direction == "right" else -1
    return track(Drive.line(0.0, 0.0, SECONDS, sign * SPEED), t, 0.0)


def slips(scheme: str, step: float, x: Array, v: Array) -> Slips:
    """Statistics of the slips between a motion's rests.

    The printed scheme leaves single steps at rest inside a slip: a rest counts from 50 ms on.
    """
    edges = np.flatnonzero(np.diff(np.concatenate([[0], v == 0, [0]]).astype(int)))
    rests = [(a, b) for a, b in edges.reshape(-1, 2) if b - a >= REST]
    levels = np.abs([x[(a + b) // 2] for a, b in rests])
    jumps = 1e3 * np.diff(levels)
    stuck = sum(b - a for a, b in rests) / len(x)
    moving_last = not rests or rests[-1][1] < len(x)
    least, mean, most = (
        (jumps.min(), jumps.mean(), jumps.max()) if len(jumps) else (np.nan, np.nan, np.nan)
    )
    return Slips(
        scheme,
        step,
        int(len(jumps) + moving_last),
        float(mean),
        float(least),
        float(most),
        float(stuck),
    )


def runs(direction: str) -> list[Slips]:
    """All schemes at all steps for one published set."""
    stroke = minute(direction)
    (p,), (c,) = SLIDE_BED.split(LAW, PUBLISHED[direction])
    (x,), (v,) = trajectories(LAW, p[None], c[None], stroke)
    simulated = [slips("fast", 0.0, x, v)]
    for scheme in ("implicit", "paper"):
        reference.trajectory(LAW, p, c, stroke, 1e-2, scheme)  # compiled before the threads
        with ThreadPoolExecutor() as pool:
            motions = list(
                pool.map(
                    lambda dt, s=scheme: reference.trajectory(LAW, p, c, stroke, dt, s),
                    STEPS,
                )
            )
        for dt, (x, v) in zip(STEPS, motions, strict=True):
            simulated.append(
                slips("reference" if scheme == "implicit" else scheme, float(dt), x, v)
            )
    return simulated


def draw(results: dict[str, list[Slips]]) -> Figure:
    """Three rows (jump, slips, stuck) by two columns (the published sets)."""
    figure = Figure(figsize=(9.2, 7.2), layout="constrained")
    axes = figure.subplots(3, 2, sharex=True, sharey="row")
    for column, (direction, schemes) in enumerate(results.items()):
        paper = [s for s in schemes if s.scheme == "paper"]
        plain = [s for s in schemes if s.scheme == "reference"]
        fast = next(s for s in schemes if s.scheme == "fast")
        for ax, name in zip(axes[:, column], ("jump_mm", "slips", "stuck"), strict=True):
            panel(ax, name, paper, plain, fast)
        axes[0, column].set_title(
            f"{TITLES[direction]}: {fast.jump_mm:.2f} mm, {fast.slips} slips, "
            f"{100 * fast.stuck:.0f} % stuck",
            fontsize=11,
        )
        axes[2, column].set_xlabel("Step / s")
    axes[0, 0].set(ylabel="Jump / mm", ylim=(0, 60))
    axes[1, 0].set(ylabel="Slips in 60 s", ylim=(0, None))
    axes[2, 0].set(ylabel="Time stuck / %", ylim=(0, 100))
    axes[1, 0].annotate("one slip, then\nsteady sliding", (1e-5, 1), (0, 7),
                        textcoords="offset points", color=MODEL, fontsize=9)  # fmt: skip
    axes[0, 1].annotate("the jumps of a bare mass", (1e-5, 33.3), (0, -16),
                        textcoords="offset points", color=MODEL, fontsize=9)  # fmt: skip
    axes[0, 0].legend(loc="lower left", fontsize=9)
    figure.suptitle("What a step decides: stick-slip of the published sets on a 5 mm/s ramp",
                    x=0.01, ha="left", fontsize=13, color=INK)  # fmt: skip
    return figure


def panel(ax: Axes, name: str, paper: list[Slips], plain: list[Slips], fast: Slips) -> None:
    """One quantity against the step."""
    scale = 100.0 if name == "stuck" else 1.0
    value = scale * float(getattr(fast, name))
    ax.axhline(value, color=INK, lw=1.2, label="fast (no step)")
    steps = [s.step_s for s in paper]
    if name == "jump_mm":
        ax.fill_between(
            steps, [s.least_mm for s in paper], [s.most_mm for s in paper], color=COMMAND,
            alpha=0.5, lw=0, label="printed: least to greatest",
        )  # fmt: skip
    ax.plot(
        steps, [scale * getattr(s, name) for s in paper], "o-", color=MODEL, ms=4, lw=1,
        label="printed procedure",
    )  # fmt: skip
    ax.plot(
        [s.step_s for s in plain], [scale * getattr(s, name) for s in plain], "s", mfc="none",
        color=MEASURED, ms=6, label="reference (order 2)",
    )  # fmt: skip
    ax.set_xscale("log")


def main() -> None:
    """Run, draw, write."""
    results = {direction: runs(direction) for direction in PUBLISHED}
    data = {direction: [asdict(s) for s in schemes] for direction, schemes in results.items()}
    text = json.dumps(data, indent=1).replace("NaN", "null")
    (DOCS / "data" / "step_dependence.json").write_text(text + "\n")
    with mpl.rc_context(STYLE):
        files = save(draw(results), DOCS / "figures", "step_dependence")
    for schemes in results.values():
        for s in schemes:
            print(s)
    print(*files, sep="\n")


if __name__ == "__main__":
    main()
