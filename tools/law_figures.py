"""Draw the catalogue of friction laws: docs/figures/laws-*.png, which docs/laws.md shows.

Static laws by their force over speed; laws with states by their presliding loops, their departure
from rest, and their lag behind a changing speed; laws under load by their force over the load.
"""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from stribeck.friction import LAWS, Law
from stribeck.report.figures.style import ACCENT, COMMAND, INK, MODEL, STYLE, save

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from stribeck.space import Array

FIGURES = Path(__file__).parents[1] / "docs" / "figures"

#: One contact under every static law: 100 N to start, 40 N to keep on, 2 mm/s between the two.
STATIC: dict[str, tuple[list[float], str]] = {
    "coulomb-viscous": ([40, 1500], "one level"),
    "stribeck": ([100, 40, 1500, 2e-3, 1], "exponent 1"),
    "stribeck-gauss": ([100, 40, 1500, 2e-3, 2], "exponent 2"),
    "stribeck-free": ([100, 40, 1500, 2e-3, 0.5], "0.5, 1, 3"),
    "stribeck-rational": ([100, 40, 1500, 2e-3, 2], "a power's tail"),
    "stribeck-smooth": ([100, 40, 1500, 7e-4], "zero at rest"),
    "makkar": ([60, 3000, 400, 40, 3000, 1500], "zero at rest"),
    "karnopp": ([100, 40, 1500, 1e-3], "a band"),
    "curve": ([95, 88, 77, 62, 50, 46, 44, 45, 46, 48, 50, 53, 2e-4, 8e-3], "12 knots"),
}

#: One contact under every law with states: 12 N to keep on, 18 N to start, a few µm of presliding.
DYNAMIC: dict[str, list[float]] = {
    "dahl": [6e6, 12, 1, 300],
    "lugre": [6e6, 300, 18, 12, 2e-3, 300],
    "elasto-plastic": [6e6, 300, 18, 12, 2e-3, 300, 0.6],
    "armstrong": [6e6, 18, 12, 2e-3, 300, 1.0, 0.02],
    "maxwell-slip": [3, 3, 3, 3, 5e-7, 2, 2, 2, 300],
    "gms": [3, 3, 3, 3, 5e-7, 2, 2, 2, 300, 1.5, 2e-3, 0.02],
}

#: A Dynamixel MX-106, N m and rad/s, as its authors publish it (arXiv 2410.08650).
MX106: dict[str, list[float]] = {
    "bam-m1": [0.1035, 0.0352],
    "bam-m2": [2.8e-6, 0.0596, 0.1174, 1.849, 1.741],
    "bam-m4": [0, 0.051, 0.105, 1.62, 1.32, 0.00915, 0.2224],
    "bam-m6": [0, 0.0507, 0.122, 1.746, 1.143, 0.198, 0.0222, 0.1986, 0.0871, 0.01, 7.3e-5],
}
SHADES = {"bam-m1": COMMAND, "bam-m2": INK, "bam-m4": ACCENT, "bam-m6": MODEL}


def static() -> Figure:
    """Force over speed, each beside the paper's law."""
    figure = Figure(figsize=(9.2, 7.0), layout="constrained")
    axes = figure.subplots(3, 3, sharex=True, sharey=True)
    v = np.concatenate([-np.geomspace(1e-7, 8e-3, 900)[::-1], np.geomspace(1e-7, 8e-3, 900)])
    stribeck = LAWS["stribeck"].friction(v, np.array(STATIC["stribeck"][0]))
    for ax, (name, (p, caption)) in zip(axes.flat, STATIC.items(), strict=True):
        ax.plot(1e3 * v, stribeck, color=COMMAND, lw=1.2)
        if name == "stribeck-free":
            for exponent in (1.0, 3.0):
                shape = np.array([*p[:4], exponent])
                ax.plot(1e3 * v, LAWS[name].friction(v, shape), color=MODEL, lw=0.9, alpha=0.6)
        ax.plot(1e3 * v, LAWS[name].friction(v, np.array(p)), color=MODEL)
        ax.set_title(name)
        ax.text(0.97, 0.06, caption, transform=ax.transAxes, ha="right", fontsize=9, color=INK)
    for ax in axes[-1]:
        ax.set_xlabel("Speed / (mm/s)")
    for ax in axes[:, 0]:
        ax.set_ylabel("Friction / N")
    figure.suptitle("Static laws: F_S 100 N, F_C 40 N, 2 mm/s between (grey: stribeck)",
                    x=0.01, ha="left", fontsize=12, color=INK)  # fmt: skip
    return figure


def walk(law: Law, p: list[float], x: Array, h: float) -> tuple[Array, Array]:
    """Friction along positions h seconds apart, and the speeds between them."""
    v = np.diff(x) / h
    z, following, none = np.zeros(law.states), np.zeros(law.states), np.zeros(5)
    F = np.empty(len(v))
    for k, speed in enumerate(v):
        F[k] = law.rub(speed, h, z, none, np.array(p, dtype=float), following)
        z, following = following, z
    return F, v


def dynamic() -> Figure:
    """A row for each law: presliding loops, departure from rest, and an oscillating speed."""
    figure = Figure(figsize=(9.2, 13.0), layout="constrained")
    axes = figure.subplots(len(DYNAMIC), 3, sharey="col")
    for row, (name, p) in zip(axes, DYNAMIC.items(), strict=True):
        law = LAWS[name]
        loops(row[0], law, p)
        # From rest to 4 mm/s, with a time constant of 10 ms.
        t = np.arange(0, 0.04, 1e-5)
        x = 4e-3 * (t - 0.01 * (1 - np.exp(-t / 0.01)))
        F, _ = walk(law, p, x, 1e-5)
        row[1].plot(1e6 * x[1:], F, color=MODEL)
        row[1].axhline(law.slip(4e-3, np.array(p, dtype=float)), color=COMMAND, lw=1.2)
        # Sliding on, at 0.2 to 8 mm/s, slowly and fast.
        for period, shade in ((2.0, ACCENT), (0.1, MODEL)):
            h = period / 4000
            t = np.arange(0, 2 * period, h)
            angle = 2 * math.pi * t / period
            x = 4.1e-3 * t - 3.9e-3 * np.sin(angle) * period / (2 * math.pi)
            F, v = walk(law, p, x, h)
            row[2].plot(1e3 * v[4000:], F[4000:], color=shade, lw=1.2,
                        label=f"once in {period:g} s")  # fmt: skip
        row[0].set(ylabel="Friction / N", title=name)
    heads = ("Presliding", "Out of rest, to 4 mm/s", "Sliding at a changing speed")
    for ax, head in zip(axes[0], heads, strict=True):
        ax.annotate(head, (0, 1), (0, 26), xycoords="axes fraction",
                    textcoords="offset points", fontsize=11, color=INK)  # fmt: skip
    for ax, label in zip(
        axes[-1], ("Displacement / µm", "Displacement / µm", "Speed / (mm/s)"), strict=True
    ):
        ax.set_xlabel(label)
    axes[0, 2].legend(loc="lower right", fontsize=9)
    return figure


def loops(ax: Axes, law: Law, p: list[float]) -> None:
    """Loops within presliding: 6 µm, then 2 µm inside it, at up to 0.1 mm/s."""
    turns = [0.0, 6e-6, -6e-6, 6e-6, 1e-6, 4e-6, -6e-6, 6e-6]
    x = np.concatenate([a + (b - a) * np.linspace(0, 1, 400)[:-1] for a, b in pairwise(turns)])
    F, _ = walk(law, p, x, 1e-3)
    ax.plot(1e6 * x[1:], F, color=MODEL, lw=1.2)


def load() -> Figure:
    """Friction under load: a gear's, and a seal's."""
    figure = Figure(figsize=(9.2, 3.4), layout="constrained")
    axes = figure.subplots(1, 3)
    torque = np.linspace(-2, 4, 601)
    for ax, w in zip(axes[:2], (0.0, 5.0), strict=True):
        for name, p in MX106.items():
            law = LAWS[name]
            values = np.array(p, dtype=float)
            F = [
                law.slip(w, values) if law.rub is None else
                law.rub(w, 0.0, np.zeros(0), np.array([m, -1.0, 0, 0, 0]), values, np.zeros(0))
                for m in torque.tolist()
            ]  # fmt: skip
            ax.plot(torque, F, color=SHADES[name], label=name)
        ax.axvline(1.0, color=INK, lw=0.7, ls=":")
        ax.set(xlabel="Motor torque / N m", title=f"A servo at {w:g} rad/s",
               ylim=(0, 1.9))  # fmt: skip
        ax.title.set_fontsize(10)
    axes[0].set_ylabel("Friction budget / N m")
    axes[0].legend(loc="upper left", fontsize=9)
    seal, tight = LAWS["coulomb-load"], np.array([9.0, 40.0, 1.0e-5])
    v = np.array([-0.2, -1e-9, 1e-9, 0.2])
    for bar, shade in ((0, COMMAND), (2, ACCENT), (6, MODEL)):
        loads = np.array([0, 0, 1e5 * bar, 0, 0])
        F = [seal.rub(s, 0.0, np.zeros(0), loads, tight, np.zeros(0)) for s in v.tolist()]
        axes[2].plot(v, F, color=shade, label=f"{bar} bar")
    axes[2].set(xlabel="Speed / (m/s)", ylabel="Friction / N", title="coulomb-load: a seal")
    axes[2].title.set_fontsize(10)
    axes[2].legend(loc="upper left", fontsize=9)
    return figure


def main() -> None:
    """Draw and write the PNGs."""
    with mpl.rc_context(STYLE):
        for name, figure in (("static", static()), ("dynamic", dynamic()), ("load", load())):
            png, svg = save(figure, FIGURES, f"laws-{name}")
            svg.unlink()
            print(png)


if __name__ == "__main__":
    main()
