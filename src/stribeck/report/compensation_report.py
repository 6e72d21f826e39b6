"""A compensation that was tried: for the terminal, as JSON, and drawn."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np

from .._version import __version__
from ..compensate.compensator import SETTINGS
from ..compensate.settings import SCHEMA
from ..units import unit
from .figures.style import ACCENT, INK, MEASURED, MODEL, REPEATS, STYLE, legend_above, save
from .folder import write_files
from .format import DASH, json_text, number, unit_label
from .table import Table
from .terminal import console, show_table

if TYPE_CHECKING:
    from pathlib import Path

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ..compensate.compensation import Compensation
    from ..compensate.scale_curve import Onset, ScaleCurve
    from ..compensate.stability import Sliding
    from ..compensate.trial import TrackingTrace

#: File names in a folder of results.
FILE, FIGURE = "compensation.json", "compensation"
_COLOURS = {"reference": ACCENT, "crossover": REPEATS[2], "feedback": MODEL}
#: Curves that lie on each other are told apart by these.
_LINES = {"reference": "-", "crossover": "-", "feedback": (0, (5, 2))}


#: What the marks in the table of scales mean.
LEGEND = "→ best   ! a sign of too much, or worse than without   · nearer than the margin to such"


def show_compensation(compensation: Compensation) -> None:
    """Ratios over scales, what the recommended one does, and what a reader must know."""
    out = console()
    scales, *others = tables(compensation)
    show_table(scales)
    out.print(LEGEND)
    for table in others:
        out.print()
        show_table(table)
    for sentence in sentences(compensation):
        out.print(f"\n{sentence}")


def tables(compensation: Compensation) -> list[Table]:
    """Ratios over scales; of the recommended one, if any, errors by motion, and smoothness."""
    heads = ["scale", *(h for c in compensation.curves for h in (c.mode, "worst axis"))]
    scales = sorted({float(s) for c in compensation.curves for s in c.scales})
    rows = [
        [f"{s:.4g}", *(cell for c in compensation.curves for cell in _cells(c, s))] for s in scales
    ]
    axis = f"{compensation.law} on {compensation.rig.name}"
    title = f"{axis}: RMS tracking error, with compensation over without"
    first = Table.of_texts(title, heads, rows)
    if (curve := compensation.curve) is None:
        return [first]
    return [first, _motions(compensation, curve), _smoothness(compensation, curve)]


def _cells(curve: ScaleCurve, scale: float) -> tuple[str, str]:
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


def _motions(compensation: Compensation, curve: ScaleCurve) -> Table:
    """What the recommended scale does in each motion."""
    assert curve.best is not None  # noqa: S101 - it is recommended
    length = compensation.rig.unit_shown("position")
    rows = []
    for m, name in enumerate(compensation.motions):
        before, after, none = (
            float(unit(length).from_si(rms))
            for rms in (
                curve.rms[0, 0, m],
                curve.rms[curve.best, 0, m],
                compensation.frictionless[m],
            )
        )
        ratios = curve.ratio[curve.best, :, m]
        worst = int(np.argmax(ratios))
        rows.append([
            name, number(before, 3), number(after, 3), number(none, 3), times(float(ratios[0])),
            times(float(ratios[worst])), compensation.plants[worst],
        ])  # fmt: skip
    heads = [
        "motion", f"without/{length}", f"with/{length}", "no friction", "less",
        "on the worst axis", "which is",
    ]  # fmt: skip
    title = f"RMS tracking error at scale {curve.scale:.4g}, {curve.mode}"
    return Table.of_texts(title, heads, rows)


def _smoothness(compensation: Compensation, curve: ScaleCurve) -> Table:
    """How smoothly the axes move, without compensation and at the recommended scale."""
    assert curve.best is not None  # noqa: S101 - it is recommended
    length, speed = (compensation.rig.unit_shown(q) for q in ("position", "velocity"))
    before, after = curve.outcomes[0], curve.outcomes[curve.best]
    rows = []
    for m, name in enumerate(compensation.motions):
        cells = [name]
        for o in (before, after):
            cells += [
                number(float(unit(length).from_si(o.swing[:, m].max())), 3),
                f"{float(o.at_rest[:, m].max()):.0%}",
                number(float(unit(speed).from_si(o.peak[:, m].max())), 3),
            ]
        rows.append(cells)
    heads = [
        "motion", f"swing/{length}", "at rest", f"peak/({speed})", "swing, with", "at rest, with",
        "peak, with",
    ]  # fmt: skip
    title = "lasting swing, share at rest behind a moving reference, peak speed: worst axis"
    return Table.of_texts(title, heads, rows)


def times(ratio: float) -> str:
    """How many times less an error is."""
    return f"{1 / ratio:.3g}×" if 0 < ratio < math.inf else DASH


def sentences(compensation: Compensation) -> list[str]:
    """What the tables do not say."""
    curve = compensation.curve
    texts = []
    if curve is None:
        texts.append(
            "no scale is safe and improves the error of every axis that the card allows: "
            "do not compensate before its intervals are narrower (`stribeck plan` says how)"
        )
        texts += [
            f"{c.mode}: at scale {c.harm.scale:.4g} already, the axis {c.harm.sign} "
            f"({c.harm.plant}, {c.harm.motion})"
            for c in compensation.curves
            if c.harm is not None
        ]
    else:
        at = _asked_at(compensation, curve)
        texts.append(
            f"recommended: scale {curve.scale:.4g}, the law asked at {at}; of "
            f"{len(compensation.plants)} axes that the card allows, the worst keeps "
            f"{float(curve.worst[curve.best]):.0%} of its error"
        )
    texts += [_too_much(c, compensation.margin) for c in compensation.curves]
    texts += _slides(compensation)
    if compensation.compensator is not None:
        c = asdict(compensation.compensator)
        listed = ", ".join(
            f"{s.name} {_setting(compensation, s, float(c[s.name]))}" for s in SETTINGS
        )
        texts.append(f"settings: {listed}")
    sees = [
        f"{word} {number(float(unit(compensation.rig.unit_shown('position')).from_si(value)), 3)} "
        f"{compensation.rig.unit_shown('position')}"
        for word, value in (
            ("resolution", compensation.sensor.resolution),
            ("noise", compensation.sensor.noise),
        )
        if value
    ]
    texts.append(
        f"simulated at a period of {compensation.period * 1e3:g} ms, outputs held between samples, "
        "with "
        f"{'a sensor of ' + ' and '.join(sees) if sees else 'a sensor without steps or noise'}; "
        "what the model of the rig leaves out, such as play and compliance, is not in these figures"
    )
    return [*texts, *compensation.notes]


def _asked_at(compensation: Compensation, curve: ScaleCurve) -> str:
    """At which velocity, in words."""
    if curve.mode == "reference":
        return "the reference's velocity"
    if curve.mode == "feedback" or compensation.compensator is None:
        return "the measured velocity"
    speed = compensation.rig.unit_shown("velocity")
    up_to = number(float(unit(speed).from_si(compensation.compensator.crossover)), 3)
    return f"the measured velocity up to {up_to} {speed}, at a faster reference's beyond"


def _slides(compensation: Compensation) -> list[str]:
    """Steady sliding at the motions' greatest speeds, each speed once."""
    by_speed = {f"{abs(s.speed):.3g}": s for s in compensation.slides}
    if not by_speed:
        return []
    shown = unit(compensation.rig.unit_shown("velocity"))
    slowest_first = sorted(by_speed.values(), key=lambda s: abs(s.speed))
    parts = [_slide(s, shown.from_si(abs(s.speed)), shown.written) for s in slowest_first]
    text = (
        f"steady sliding by the eigenvalues of the loop (small disturbances): {'; '.join(parts)}; "
        "beside sliding that is stable an axis may keep swinging once it is kicked: the motions "
        "above tell"
    )
    return [text]


def _slide(s: Sliding, speed: float, written: str) -> str:
    state = "stable" if s.stable else "unstable"
    other = "unstable" if s.stable else "stable"
    turn = f"{other} with feedback from scale {s.edge:.3g}" if s.edge is not None else (
        f"{state} with feedback at any scale"
    )  # fmt: skip
    falls = "falls" if s.slope < 0 else "rises"
    return f"at {number(float(speed), 3)} {written}, where friction {falls}, {state}, {turn}"


def _too_much(curve: ScaleCurve, margin: float) -> str:
    if curve.onset is None:
        head = f"{curve.mode}: no sign of too much up to scale {curve.scales[-1]:.4g}"
        worse = curve.scales[(curve.scales > 0) & (curve.worst > 1.0)]
        at = ", ".join(f"{s:.4g}" for s in worse)
        return f"{head}, but worse than without on an axis at {at}" if len(worse) else head
    o = curve.onset
    return (
        f"{curve.mode}: too much from scale {o.scale:.4g}, where the axis {o.sign} "
        f"({o.plant}, {o.motion}); {margin:g} is kept from it"
    )


def _setting(compensation: Compensation, s: Any, value: float) -> str:
    written_in = s.rotary if compensation.rig.rotary else s.unit
    return f"{number(value, 4)} {written_in}".strip()


def compensation_text(compensation: Compensation) -> str:
    """The same as JSON; errors in SI, null where an axis ran away."""
    curve = compensation.curve
    document: dict[str, Any] = {
        "schema": SCHEMA,
        "law": compensation.law,
        "rig": compensation.rig.name,
        "period": compensation.period,
        "sensor": asdict(compensation.sensor),
        "motions": list(compensation.motions),
        "axes": list(compensation.plants),
        "frictionless": compensation.frictionless.tolist(),
        "sliding": [asdict(s) for s in compensation.slides],
        "margin": compensation.margin,
        "recommended": None
        if curve is None or compensation.compensator is None
        else {
            "mode": curve.mode,
            "scale": curve.scale,
            "worst_ratio": float(curve.worst[curve.best]),
            "settings": {
                s.name: {
                    "value": float(getattr(compensation.compensator, s.name)),
                    "unit": s.rotary if compensation.rig.rotary else s.unit,
                }
                for s in SETTINGS
            },
        },
        "modes": {c.mode: _curve(c) for c in compensation.curves},
        "notes": list(compensation.notes),
        "software": {"stribeck": __version__},
    }
    return json_text(document)


def _curve(curve: ScaleCurve) -> dict[str, Any]:
    return {
        "scale": curve.scale,
        "onset": _sign(curve.onset),
        "harm": _sign(curve.harm),
        "scales": curve.scales.tolist(),
        "safe": [bool(s) for s in curve.safe],
        "worst_ratio": curve.worst.tolist(),
        "rms": curve.rms.tolist(),
        "swing": [o.swing.tolist() for o in curve.outcomes],
        "at_rest": [o.at_rest.tolist() for o in curve.outcomes],
        "peak": [o.peak.tolist() for o in curve.outcomes],
    }


def _sign(onset: Onset | None) -> dict[str, Any] | None:
    return None if onset is None else {
        "scale": onset.scale, "sign": onset.sign, "axis": onset.plant, "motion": onset.motion,
    }  # fmt: skip


def write_compensation(compensation: Compensation, folder: Path) -> None:
    """Write the JSON and the picture into a folder."""
    import matplotlib as mpl  # noqa: PLC0415 - comes late on purpose

    def write(place: Path) -> None:
        (place / FILE).write_text(compensation_text(compensation), encoding="utf-8")
        save(figure(compensation), place, FIGURE)

    with mpl.rc_context(STYLE):
        write_files(folder, write)


def figure(compensation: Compensation) -> Figure:
    """Error over time without and with, and the ratio of errors over the scale."""
    from matplotlib.figure import Figure  # noqa: PLC0415 - comes late on purpose

    drawn = Figure(figsize=(9.0, 9.4), layout="constrained")
    top, middle, bottom = drawn.subplots(3, 1, height_ratios=[1.0, 1.1, 0.6])
    _error(top, compensation, compensation.traces[0])
    _ratios(middle, compensation, compensation.curves)
    _swings(bottom, compensation)
    bottom.sharex(middle)
    legend_above(drawn, top)
    drawn.legend(*middle.get_legend_handles_labels(), loc="outside lower left", ncols=3, fontsize=9)
    return drawn


def _error(axes: Axes, compensation: Compensation, trace: TrackingTrace) -> None:
    length = compensation.rig.unit_shown("position")
    from_si = unit(length).from_si
    axes.plot(trace.t, from_si(trace.without), color=MEASURED, label="without compensation")
    if compensation.curve is not None:
        name = f"scale {compensation.curve.scale:.4g}, {compensation.curve.mode}"
        axes.plot(
            trace.t, from_si(trace.compensated), color=_COLOURS[compensation.curve.mode], label=name
        )
    axes.axhline(0.0, color=INK, linewidth=0.7)
    axes.set(
        title=f"Tracking error, {trace.motion}", xlabel="time / s",
        ylabel=f"command − position / {unit_label(length)}",
    )  # fmt: skip
    axes.margins(x=0.0)


def _swings(axes: Axes, compensation: Compensation) -> None:
    """The greatest lasting swing over the scale, where there is none without."""
    length = compensation.rig.unit_shown("position")
    for c in compensation.curves:
        swing = unit(length).from_si(c.swing)
        axes.plot(
            c.scales, swing, marker=".", color=_COLOURS[c.mode], linestyle=_LINES[c.mode],
            clip_on=False,
        )  # fmt: skip
        if c is compensation.curve and c.best is not None:
            axes.plot(c.scales[c.best], swing[c.best], "o", color=_COLOURS[c.mode], clip_on=False)
    axes.set(
        title="Greatest lasting swing where axes settle without compensation",
        xlabel="scale: share of the model's friction that is compensated",
        ylabel=f"swing / {unit_label(length)}",
    )
    axes.set_ylim(bottom=0.0)
    axes.margins(x=0.0)


def _ratios(axes: Axes, compensation: Compensation, curves: Sequence[ScaleCurve]) -> None:
    for c in curves:
        colour = _COLOURS[c.mode]
        known = np.isfinite(c.ratio[:, 0]).all(axis=1)
        least, most = c.ratio.max(axis=2).min(axis=1), c.worst
        axes.fill_between(
            c.scales, least, np.where(np.isfinite(most), most, 10.0), color=colour, alpha=0.15,
            linewidth=0,
        )  # fmt: skip
        axes.plot(
            c.scales[known], c.ratio[known, 0].max(axis=1), color=colour, linestyle=_LINES[c.mode],
            label=c.mode,
        )  # fmt: skip
        if c.onset is not None:
            axes.axvline(c.onset.scale, color=colour, linewidth=0.9, linestyle="--")
            axes.axvspan(
                c.onset.scale, c.scales[-1], facecolor="none", edgecolor=colour, alpha=0.35,
                hatch="//", linewidth=0, label=f"{c.mode} {c.onset.sign} from {c.onset.scale:.3g}",
            )  # fmt: skip
        if c.best is not None and c is compensation.curve:
            axes.plot(
                c.scales[c.best], most[c.best], "o", color=colour, linestyle="none", clip_on=False,
                label=f"recommended: {c.mode}, {c.scale:.4g}",
            )  # fmt: skip
    axes.axhline(1.0, color=INK, linewidth=0.7)
    axes.set_yscale("log", subs=(2, 5))
    for ticks in (axes.yaxis.set_major_formatter, axes.yaxis.set_minor_formatter):
        ticks("{x:g}")
    every = np.concatenate([c.ratio.max(axis=2).ravel() for c in curves])
    finite = every[np.isfinite(every)]
    axes.set_ylim(
        max(0.5 * float(finite.min()), 1e-4), min(1.3 * max(float(finite.max()), 1.0), 10)
    )
    axes.set(
        title="Worst motion's error over that without; line: axis as identified, "
        f"band: {len(compensation.plants)} axes",
        ylabel="RMS ratio",
    )
    axes.margins(x=0.0)
