"""A fit as one page: a file that needs no other and no network, with plots that can be zoomed."""

from __future__ import annotations

import base64
import gzip
import hashlib
import json
import shlex
from dataclasses import asdict
from functools import cache
from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from ...errors import InputError
from ..figures.style import ACCENT, COMMAND, INK, MEASURED, MODEL, REPEATS
from ..folder import write_files
from ..terminal import gathered, number
from . import fit_plots, fit_tables
from .plot import Group, every_plot
from .schema import FILE, Report, read_report

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ...identify.result import Fit

#: The page's name in its folder.
PAGE = "report.html"
#: How hard the drawing library is packed: harder takes twice the time for a hundredth of the size.
_PACKED = 5
#: What lines are drawn in, by role: on a light page and on a dark one.
COLOURS: dict[str, tuple[str, str]] = {
    "ink": (INK, "#e6eaee"),
    "measured": (MEASURED, "#93a1af"),
    "model": (MODEL, "#ff8a4c"),
    "command": (COMMAND, "#64707c"),
    "accent": (ACCENT, "#8ab4ff"),
    **{
        f"repeat{k}": pair
        for k, pair in enumerate(
            zip(
                REPEATS,
                ("#ff8a4c", "#8ab4ff", "#2dd4bf", "#b794ff", "#fbbf24", "#a3b1bf"),
                strict=True,
            )
        )
    },
}


def write_report(fit: Fit, folder: Path, command: Sequence[str] = ()) -> Report:
    """Write `report.json` and `report.html` of a fit into a folder.

    Args:
        fit: What was found.
        folder: Where.
        command: What was typed, word by word, to be repeated.

    Returns:
        What was written.

    Raises:
        InputError: the disk refuses, or the fit has no card.
    """
    from .contents import account  # noqa: PLC0415 - a page that is made again needs no fit

    report = account(fit, command)
    texts = {FILE: report.text(), PAGE: render(report)}

    def write(place: Path) -> None:
        for name, text in texts.items():
            (place / name).write_text(text, encoding="utf-8")

    write_files(folder, write)
    return report


def write_page(folder: Path) -> Path:
    """Make the page again from the `report.json` in a folder.

    Returns:
        The file.

    Raises:
        InputError: there is no report, it is damaged or newer, or the disk refuses.
    """
    report = read_report(folder)
    try:
        with np.errstate(all="ignore"):
            text = render(report)
    except InputError:
        raise
    except (ArithmeticError, LookupError, TypeError, ValueError) as error:
        # Each part is as it should be, but a person has edited what belongs together.
        raise InputError(
            f"{folder / FILE}: is damaged, its numbers do not fit together: write it with "
            "`identify ... --out DIR`"
        ) from error
    write_files(folder, lambda place: (place / PAGE).write_text(text, encoding="utf-8"))
    return folder / PAGE


def render(report: Report) -> str:
    """The page as text: HTML with all it needs inside."""
    groups: dict[str, list[Group]] = {
        "log": _one(fit_plots.log_group(report)),
        "fit": fit_plots.fit_groups(report),
        "residual": _one(fit_plots.residual_group(report)),
        "friction": fit_plots.friction_groups(report),
        "profile": fit_plots.profile_groups(report),
        "convergence": _one(fit_plots.convergence_group(report)),
    }
    script, library = _asset("page.js"), _library()
    specs = {p.id: asdict(p) for own in groups.values() for p in every_plot(own)}
    return _environment().get_template("page.html.j2").render(
        report=report,
        card=report.card,
        title=f"{report.card.law} friction on {report.card.rig}",
        answer=answer(report),
        tiles=tiles(report),
        warnings=gathered(report.card.warnings),
        groups=groups,
        tables=fit_tables,
        facts=facts(report),
        command=shlex.join(report.command),
        colours=COLOURS,
        style=Markup(_asset("page.css")),  # noqa: S704 - our own file
        script=Markup(script),  # noqa: S704 - our own file
        plots=Markup(inert(specs)),  # noqa: S704 - cannot end its element
        library=library[0],
        policy="; ".join((
            "default-src 'none'",
            f"script-src '{_hash(script)}' '{library[1]}'",
            "style-src 'unsafe-inline'",
            "img-src data: blob:",
            "base-uri 'none'",
            "form-action 'none'",
        )),
    )  # fmt: skip


def answer(report: Report) -> str:
    """What was found, in a line."""
    card = report.card
    own = card.objective
    logs, what = len(card.data), fit_tables.misfit(report)
    source = f"{logs} logs" if logs > 1 else card.data[0].file or "a recording"
    said = f"From {source}: {what} {number(own.value, 3)} {own.unit} in training"
    smooth = own.baselines.get("smooth")
    if smooth is not None:
        said += f" (the best smooth motion without stick-slip: {number(smooth, 3)} {own.unit})"
    if card.holdout:
        held = ", ".join(f"{number(h.value, 3)} {h.unit} on {h.range}" for h in card.holdout)
        said += f"; held out: {held}"
    return f"{said}. {_verdicts(report)}."


def _verdicts(report: Report) -> str:
    """How many parameters are known how well."""
    seen = [p.verdict for p in report.card.parameters.values() if p.verdict != "fixed"]
    if not seen:
        return "No parameter was free"
    counts = {v: seen.count(v) for v in ("identified", "weak", "not identifiable")}
    if counts["identified"] == len(seen):
        return f"All {len(seen)} parameters are identified" if len(seen) > 1 else "It is identified"
    said = [f"{n or 'none'} {v}" for v, n in counts.items() if n or v == "identified"]
    return f"Of {len(seen)} parameters: {', '.join(said)}"


def tiles(report: Report) -> list[tuple[str, str]]:
    """The numbers that are looked for first."""
    card = report.card
    own = card.objective
    made = [(f"{fit_tables.misfit(report)}, training", f"{number(own.value, 3)} {own.unit}")]
    made += [(f"held out {h.range}", f"{number(h.value, 3)} {h.unit}") for h in card.holdout[:3]]
    free = [p for p in card.parameters.values() if p.verdict != "fixed"]
    if free:
        good = sum(p.verdict == "identified" for p in free)
        made.append(("parameters identified", f"{good} of {len(free)}"))
    return made


def facts(report: Report) -> list[tuple[str, str]]:
    """What the numbers hang on."""
    card = report.card
    search = card.search
    found = [("Law", f"{card.law}: {report.law.doc}"), ("Formula", report.law.formula)]
    if report.law.cite:
        found.append(("Source", report.law.cite))
    found.append(("Rig", f"{card.rig}: {report.about}"))
    if card.constants:
        said = ", ".join(
            f"{n} = {number(c.value)} {c.unit}".rstrip() for n, c in card.constants.items()
        )
        found.append(("Constants set", said))
    found.append(("Trained on", ", ".join(card.train) or "everything"))
    if search.seed is None:
        found.append(("Method", f"{search.method}, which leaves nothing to search"))
    else:
        ended = search.ended.replace("_", " ")
        spent = f"{search.evaluations:,} evaluations in {search.seconds:.1f} s"
        found.append(("Search", f"{search.method}, seed {search.seed}: {spent}, ended: {ended}"))
    made = ", ".join(f"{name} {version}" for name, version in report.software.items())
    return [*found, ("Made with", made)]


def inert(value: Any) -> str:
    """A value as JSON that no page can take for anything else: no tag begins in it."""
    text = json.dumps(value, ensure_ascii=False, separators=(",", ":"), allow_nan=False)
    return text.replace("<", "\\u003c")


def _one(group: Group | None) -> list[Group]:
    return [] if group is None else [group]


def _hash(text: str) -> str:
    """What a page that allows no other script calls this one."""
    return "sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode("ascii")


@cache
def _library() -> tuple[str, str]:
    """plotly.js, packed, as text; and its hash.

    It is read from where the package lies, without running that.
    """
    spec = find_spec("plotly")
    places = spec.submodule_search_locations if spec is not None else None
    file = Path(next(iter(places or [""]))) / "package_data" / "plotly.min.js"
    try:
        text = file.read_text(encoding="utf-8")
    except OSError as error:
        raise InputError(f"plotly.js is not there: pip install 'plotly>=6' ({error})") from error
    packed = gzip.compress(text.encode(), _PACKED, mtime=0)  # the same page has the same bytes
    return base64.b64encode(packed).decode("ascii"), _hash(text)


@cache
def _asset(name: str) -> str:
    return (files("stribeck.report.page") / "assets" / name).read_text(encoding="utf-8")


@cache
def _environment() -> Environment:
    return Environment(
        loader=PackageLoader("stribeck.report.page", "assets"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
