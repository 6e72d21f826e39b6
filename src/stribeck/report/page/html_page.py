"""A fit as one page: a file that needs no other and no network, with plots that can be zoomed."""

from __future__ import annotations

import base64
import gzip
import hashlib
import json
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from ..._version import __version__
from ...errors import InputError
from ...identify.card import HoldoutCard, ObjectiveCard
from ..contents.schema import FILE, Report, read_report
from ..figures.adequacy_plots import adequacy_groups
from ..figures.law_plots import friction_groups
from ..figures.log_plots import log_group
from ..figures.motion_plots import fit_groups
from ..figures.plot import Group, every_plot
from ..figures.residual_plots import residual_group
from ..figures.search_plots import convergence_group, profile_groups
from ..figures.style import COLOURS
from ..folder import write_texts
from ..format import number, unit_label
from ..terminal import gathered
from . import fit_tables

#: The page's name in its folder.
PAGE = "report.html"
#: How hard the drawing library is packed: harder takes twice the time for a hundredth of the size.
_PACKED = 5


def write_report(report: Report, folder: Path) -> None:
    """Write `report.json` and `report.html` into a folder.

    Raises:
        InputError: the disk refuses.
    """
    write_texts(folder, {FILE: report.text(), PAGE: render(report)})


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
    write_texts(folder, {PAGE: text})
    return folder / PAGE


def render(report: Report) -> str:
    """The page as text: HTML with all it needs inside."""
    groups: dict[str, list[Group]] = {  # in the order of the page
        "friction": friction_groups(report),
        "fit": fit_groups(report),
        "residual": _listed(residual_group(report)),
        "adequacy": adequacy_groups(report),
        "profile": profile_groups(report),
        "convergence": _listed(convergence_group(report)),
        "log": _listed(log_group(report)),
    }
    return laid_out(
        "page.html.j2",
        groups,
        "stribeck report",
        f"{report.card.law} friction on {report.card.rig}",
        answer(report),
        report=report,
        card=report.card,
        tiles=tiles(report),
        warnings=gathered(report.card.warnings),
        notes=gathered(report.card.notes),
        tables=fit_tables,
        facts=facts(report),
        command=shlex.join(report.command),
    )


def laid_out(
    template: str,
    groups: Mapping[str, Sequence[Group]],
    kind: str,
    title: str,
    lead: str,
    **values: Any,
) -> str:
    """A page as text: HTML with its plots and all they need inside.

    Args:
        template: Its template, which extends `layout.html.j2`.
        groups: Its plots, in their order.
        kind: What the page is.
        title: Its heading.
        lead: What stands under that.
        values: What else its template shows.
    """
    script = _asset("page.js")
    specs = {p.id: _spec(p) for plots in groups.values() for p in every_plot(plots)}
    library = _library() if specs else ("", "")
    scripts = " ".join(f"'{text}'" for text in (_hash(script), library[1]) if text)
    return _environment().get_template(template).render(
        **values,
        groups=groups,
        kind=kind,
        title=title,
        answer=lead,
        version=__version__,
        colours=COLOURS,
        style=Markup(_asset("page.css")),  # noqa: S704 - our own file
        script=Markup(script),  # noqa: S704 - our own file
        plots=Markup(inert(specs)),  # noqa: S704 - cannot end its element
        library=library[0],
        policy="; ".join((
            "default-src 'none'",
            f"script-src {scripts}",
            "style-src 'unsafe-inline'",
            "img-src data: blob:",
            "base-uri 'none'",
            "form-action 'none'",
        )),
    )  # fmt: skip


def style_sheet() -> str:
    """The style sheet of all pages: colours of both themes, and rules."""
    theme = _environment().get_template("theme.css.j2").render(colours=COLOURS)
    return f"{theme}\n{_asset('page.css')}"


def answer(report: Report) -> str:
    """The result in a line."""
    card = report.card
    score = card.objective
    logs, misfit = len(card.data), fit_tables.misfit(report.card)
    source = f"{logs} logs" if logs > 1 else card.data[0].file or "a recording"
    text = f"From {source}: {misfit} {_error(score)} in training"
    smooth = score.baselines.get("smooth")
    if smooth is not None:
        smooth_error = f"{number(smooth, 3)} {unit_label(score.unit)}"
        text += f" (the best smooth motion without stick-slip: {smooth_error})"
    if card.holdout:
        held_out = ", ".join(f"{_error(h)} on {h.range}{_idle(h)}" for h in card.holdout)
        text += f"; held out: {held_out}"
    return f"{text}. {_verdicts(report)}."


def _idle(held_out: HoldoutCard) -> str:
    return "" if held_out.moves else " (which tests nothing: the axis does not move there)"


def _error(score: ObjectiveCard | HoldoutCard) -> str:
    return f"{number(score.value, 3)} {unit_label(score.unit)}"


def _verdicts(report: Report) -> str:
    """How many parameters are known how well."""
    verdicts = [p.verdict for p in report.card.parameters.values() if p.verdict != "fixed"]
    if not verdicts:
        return "No parameter was free"
    counts = {v: verdicts.count(v) for v in ("identified", "weak", "not identifiable")}
    if counts["identified"] == len(verdicts):
        return (
            f"All {len(verdicts)} parameters are identified"
            if len(verdicts) > 1
            else "It is identified"
        )
    parts = [f"{n or 'none'} {v}" for v, n in counts.items() if n or v == "identified"]
    return f"Of {len(verdicts)} parameters: {', '.join(parts)}"


def tiles(report: Report) -> list[tuple[str, str]]:
    """The numbers that are looked for first."""
    card = report.card
    score = card.objective
    name = f"{fit_tables.misfit(report.card)}, training"
    shown = [(name, _error(score))]
    shown += [
        (f"held out {h.range}", _error(h) if h.moves else "tests nothing") for h in card.holdout[:3]
    ]
    free = [p for p in card.parameters.values() if p.verdict != "fixed"]
    if free:
        identified = sum(p.verdict == "identified" for p in free)
        shown.append(("parameters identified", f"{identified} of {len(free)}"))
    return shown


def facts(report: Report) -> list[tuple[str, str]]:
    """What the numbers depend on."""
    card = report.card
    search = card.search
    rows = [("Law", f"{card.law}: {report.law.doc}"), ("Formula", report.law.formula)]
    if report.law.cite:
        rows.append(("Source", report.law.cite))
    rows.append(("Rig", f"{card.rig}: {report.about}"))
    if report.equation:
        rows.append(("Equation of motion", ";  ".join(report.equation)))
    if subtracted := card.columns.get("subtract"):
        rows.append(("Subtracted from the force", str(subtracted)))
    rows.append(("Trained on", ", ".join(card.train) or "everything"))
    if search.seed is None:
        rows.append(("Method", f"{search.method}, which leaves nothing to search"))
    else:
        ended = search.ended.replace("_", " ")
        spent = f"{search.evaluations:,} evaluations in {search.seconds:.1f} s"
        rows.append(("Search", f"{search.method}, seed {search.seed}: {spent}, ended: {ended}"))
    software = ", ".join(f"{name} {version}" for name, version in report.software.items())
    return [*rows, ("Made with", software)]


def inert(value: Any) -> str:
    """A value as JSON that no page can take for anything else: no tag begins in it."""
    text = json.dumps(value, ensure_ascii=False, separators=(",", ":"), allow_nan=False)
    return text.replace("<", "\\u003c")


def _listed(group: Group | None) -> list[Group]:
    return [] if group is None else [group]


def _spec(part: Any) -> Any:
    """A plot as the page's script reads it; what a line does not say is left out."""
    if is_dataclass(part):
        values = ((f.name, getattr(part, f.name)) for f in fields(part))
        return {name: _spec(v) for name, v in values if v is not None and v is not False}
    if isinstance(part, Mapping):
        return {str(name): _spec(v) for name, v in part.items()}
    if isinstance(part, list | tuple):
        return [_spec(v) for v in part] if part and not isinstance(part[0], float) else part
    return part


def _hash(text: str) -> str:
    """What a page that allows no other script calls this one."""
    return "sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode("ascii")


@cache
def _library() -> tuple[str, str]:
    """plotly.js with its plots of lines and points alone, packed, as text; and its hash."""
    text = _asset("vendor/plotly-basic.min.js")
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
