"""A compensation that was tried: for the terminal, as JSON, and drawn."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np

from .._version import __version__
from ..compensate.compensator import SETTINGS
from ..compensate.settings import SCHEMA
from ..units import unit
from .figures.style import ACCENT, INK, MEASURED, MODEL, STYLE, legend_above, save, shown, written
from .folder import write_files
from .terminal import console, grid, number

if TYPE_CHECKING:
    from pathlib import Path

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ..compensate.compensation import Compensation, Curve, Onset
    from ..compensate.trial import Trace
    from ..space import Array

#: File names in a folder of results.
FILE, FIGURE = "compensation.json", "compensation"
_COLOURS = {"reference": ACCENT, "feedback": MODEL}


def show_compensation(made: Compensation) -> None:
    """Ratios over scales, what the recommended one does, and what a reader must know."""
    out = console()
    heads = ["scale", *(h for c in made.curves for h in (c.mode, "worst axis"))]
    scales = sorted({float(s) for c in made.curves for s in c.scales})
    rows = [[f"{s:.4g}", *(cell for c in made.curves for cell in _cells(c, s))] for s in scales]
    title = f"{made.law} on {made.rig.name}: RMS tracking error, with compensation over without"
    out.print(grid(title, heads, rows))
    out.print("→ best   ! shows a sign of too much   · nearer than the margin to one that does")
    if (curve := made.curve) is not None:
        out.print()
        out.print(_motions(made, curve))
    for said in sentences(made):
        out.print(f"\n{said}")


def _cells(curve: Curve, scale: float) -> tuple[str, str]:
    """The greatest ratio over motions of the identified axis, and of all axes."""
    at = np.flatnonzero(curve.scales == scale)
    if not len(at):
        return "", ""
    k = int(at[0])
    mark = "→ " if k == curve.best else ""
    if scale > 0 and not curve.safe[k]:
        too_much = curve.onset is not None and scale >= curve.onset.scale
        mark = "! " if too_much or curve.worst[k] > 1.0 else "· "
    return number(float(curve.ratio[k, 0].max()), 3), f"{mark}{number(float(curve.worst[k]), 3)}"


def _motions(made: Compensation, curve: Curve) -> Any:
    """What the recommended scale does in each motion."""
    assert curve.best is not None  # noqa: S101 - it is recommended
    length = shown(made.rig, "position")
    rows = []
    for m, name in enumerate(made.motions):
        before, after, none = (
            float(unit(length).from_si(rms))
            for rms in (curve.rms[0, 0, m], curve.rms[curve.best, 0, m], made.frictionless[m])
        )
        ratios = curve.ratio[curve.best, :, m]
        worst = int(np.argmax(ratios))
        rows.append([
            name, number(before, 3), number(after, 3), number(none, 3), times(float(ratios[0])),
            times(float(ratios[worst])), made.plants[worst],
        ])  # fmt: skip
    heads = [
        "motion", f"without/{length}", f"with/{length}", "no friction", "less",
        "on the worst axis", "which is",
    ]  # fmt: skip
    return grid(
        f"RMS tracking error at scale {curve.scale:.4g}, {curve.mode}",
        heads,
        rows,
    )


def times(ratio: float) -> str:
    """How many times less an error is."""
    return f"{1 / ratio:.3g}×" if 0 < ratio < math.inf else "–"


def sentences(made: Compensation) -> list[str]:
    """What the tables do not say."""
    curve = made.curve
    said = []
    if curve is None:
        said.append(
            "no scale is safe and improves the error of every axis that the card allows: "
            "do not compensate before its intervals are narrower (`stribeck plan` says how)"
        )
        said += [
            f"{c.mode}: at scale {c.harm.scale:.4g} already, the axis {c.harm.sign} "
            f"({c.harm.plant}, {c.harm.motion})"
            for c in made.curves
            if c.harm is not None
        ]
    else:
        at = "measured velocity" if curve.mode == "feedback" else "reference's velocity"
        said.append(
            f"recommended: scale {curve.scale:.4g}, the law asked at the {at}; of "
            f"{len(made.plants)} axes that the card allows, the worst keeps "
            f"{float(curve.worst[curve.best]):.0%} of its error"
        )
    said += [_too_much(c, made.margin) for c in made.curves]
    if made.compensator is not None:
        c = asdict(made.compensator)
        listed = ", ".join(f"{s.name} {_setting(made, s, float(c[s.name]))}" for s in SETTINGS)
        said.append(f"settings: {listed}")
    sees = [
        f"{word} {number(float(unit(shown(made.rig, 'position')).from_si(value)), 3)} "
        f"{shown(made.rig, 'position')}"
        for word, value in (("resolution", made.sensor.resolution), ("noise", made.sensor.noise))
        if value
    ]
    said.append(
        f"simulated at a period of {made.period * 1e3:g} ms, outputs held between samples, with "
        f"{'a sensor of ' + ' and '.join(sees) if sees else 'a sensor without steps or noise'}; "
        "what the model of the rig leaves out, such as play and compliance, is not in these figures"
    )
    return [*said, *made.notes]


def _too_much(curve: Curve, margin: float) -> str:
    if curve.onset is None:
        return f"{curve.mode}: no sign of too much up to scale {curve.scales[-1]:.4g}"
    o = curve.onset
    return (
        f"{curve.mode}: too much from scale {o.scale:.4g}, where the axis {o.sign} "
        f"({o.plant}, {o.motion}); {margin:g} is kept from it"
    )


def _setting(made: Compensation, s: Any, value: float) -> str:
    written_in = s.rotary if made.rig.rotary else s.unit
    return f"{number(value, 4)} {written_in}".strip()


def compensation_text(made: Compensation) -> str:
    """The same as JSON; errors in SI."""
    curve = made.curve
    said: dict[str, Any] = {
        "schema": SCHEMA,
        "law": made.law,
        "rig": made.rig.name,
        "period": made.period,
        "sensor": asdict(made.sensor),
        "motions": list(made.motions),
        "axes": list(made.plants),
        "frictionless": made.frictionless.tolist(),
        "margin": made.margin,
        "recommended": None
        if curve is None or made.compensator is None
        else {
            "mode": curve.mode,
            "scale": curve.scale,
            "worst_ratio": float(curve.worst[curve.best]),
            "settings": {
                s.name: {
                    "value": float(getattr(made.compensator, s.name)),
                    "unit": s.rotary if made.rig.rotary else s.unit,
                }
                for s in SETTINGS
            },
        },
        "modes": {c.mode: _curve(c) for c in made.curves},
        "notes": list(made.notes),
        "software": {"stribeck": __version__},
    }
    return json.dumps(said, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def _curve(curve: Curve) -> dict[str, Any]:
    return {
        "scale": curve.scale,
        "onset": _sign(curve.onset),
        "harm": _sign(curve.harm),
        "scales": curve.scales.tolist(),
        "safe": [bool(s) for s in curve.safe],
        "worst_ratio": _finite(curve.worst),
        "rms": [[_finite(axis) for axis in at] for at in curve.rms],
    }


def _sign(onset: Onset | None) -> dict[str, Any] | None:
    return None if onset is None else {
        "scale": onset.scale, "sign": onset.sign, "axis": onset.plant, "motion": onset.motion,
    }  # fmt: skip


def _finite(values: Array) -> list[float | None]:
    """Numbers for JSON; null where an axis ran away."""
    return [v if math.isfinite(v) else None for v in values.tolist()]


def write_compensation(made: Compensation, folder: Path) -> None:
    """Write the JSON and the picture into a folder."""
    import matplotlib as mpl  # noqa: PLC0415 - comes late on purpose

    def write(place: Path) -> None:
        (place / FILE).write_text(compensation_text(made), encoding="utf-8")
        save(figure(made), place, FIGURE)

    with mpl.rc_context(STYLE):
        write_files(folder, write)


def figure(made: Compensation) -> Figure:
    """Error over time without and with, and the ratio of errors over the scale."""
    from matplotlib.figure import Figure  # noqa: PLC0415 - comes late on purpose

    drawn = Figure(figsize=(9.0, 7.2), layout="constrained")
    top, bottom = drawn.subplots(2, 1, height_ratios=[1.0, 1.1])
    _error(top, made, made.traces[0])
    _ratios(bottom, made, made.curves)
    legend_above(drawn, top)
    return drawn


def _error(axes: Axes, made: Compensation, trace: Trace) -> None:
    length = shown(made.rig, "position")
    from_si = unit(length).from_si
    axes.plot(trace.t, from_si(trace.without), color=MEASURED, label="without compensation")
    if made.curve is not None:
        name = f"scale {made.curve.scale:.4g}, {made.curve.mode}"
        axes.plot(trace.t, from_si(trace.compensated), color=_COLOURS[made.curve.mode], label=name)
    axes.axhline(0.0, color=INK, linewidth=0.7)
    axes.set(
        title=f"Tracking error, {trace.motion}", xlabel="time / s",
        ylabel=f"command − position / {written(length)}",
    )  # fmt: skip
    axes.margins(x=0.0)


def _ratios(axes: Axes, made: Compensation, curves: Sequence[Curve]) -> None:
    for c in curves:
        colour = _COLOURS[c.mode]
        there = np.isfinite(c.ratio[:, 0]).all(axis=1)
        least, most = c.ratio.max(axis=2).min(axis=1), c.worst
        axes.fill_between(
            c.scales, least, np.where(np.isfinite(most), most, 10.0), color=colour, alpha=0.15,
            linewidth=0,
        )  # fmt: skip
        axes.plot(
            c.scales[there], c.ratio[there, 0].max(axis=1), color=colour,
            label=f"{c.mode}: as identified, all axes",
        )  # fmt: skip
        if c.onset is not None:
            axes.axvspan(
                c.onset.scale, c.scales[-1], facecolor="none", edgecolor=colour, alpha=0.35,
                hatch="//", linewidth=0,
            )  # fmt: skip
            axes.annotate(
                f"{c.mode}: {c.onset.sign}", (c.onset.scale, 0.97), xytext=(-4, 0),
                xycoords=("data", "axes fraction"), textcoords="offset points", rotation=90,
                ha="right", va="top", color=colour, fontsize=9,
            )  # fmt: skip
        if c.best is not None and c is made.curve:
            axes.plot(c.scales[c.best], most[c.best], "o", color=colour)
            axes.annotate(
                f"recommended {c.scale:.4g}", (float(c.scales[c.best]), float(most[c.best])),
                xytext=(-40, -70), textcoords="offset points", ha="right", color=colour, fontsize=9,
                arrowprops={"arrowstyle": "-", "color": colour, "linewidth": 0.7},
            )  # fmt: skip
    axes.axhline(1.0, color=INK, linewidth=0.7)
    axes.set_yscale("log")
    every = np.concatenate([c.ratio.max(axis=2).ravel() for c in curves])
    finite = every[np.isfinite(every)]
    axes.set_ylim(
        max(0.5 * float(finite.min()), 1e-4), min(1.3 * max(float(finite.max()), 1.0), 10)
    )
    axes.set(
        title="Worst motion's error over that without; bands: every axis that the card allows",
        xlabel="scale: share of the model's friction that is compensated",
        ylabel="RMS ratio",
    )
    axes.legend(loc="lower left", fontsize=9)
    axes.margins(x=0.0)
