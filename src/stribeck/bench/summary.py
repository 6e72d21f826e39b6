"""A campaign on one page: what was compared, what came of it, what is missing."""

from __future__ import annotations

import base64
import io
import platform
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
import scipy
from jinja2 import Environment, PackageLoader, StrictUndefined, Template
from PIL import Image

from .._version import __version__
from ..report import FORMS, Table, as_entered, duration
from ..report.folder import write_text
from .campaign import parsed, shipped
from .record import Failure, Job, Record

if TYPE_CHECKING:
    from ..space import Space
    from .campaign import Campaign, Entry, Task
    from .campaign_figures import CampaignFigure

#: The page's name in its folder.
PAGE = "summary.html"
#: Bytes that all pictures together may take, as they stand in the page.
PICTURES = 4_800_000
#: Scales at which pictures are tried, until they fit.
SCALES = (1.0, 0.75, 0.5, 0.35, 0.25)
#: Colours kept of a picture; rows of a table that stand open; failures listed.
COLOURS, OPEN, LISTED = 256, 60, 50


@dataclass(frozen=True)
class Picture:
    """A figure as the page has it: a PNG in the text of the page."""

    name: str
    title: str
    caption: str
    source: str
    width: int
    height: int


def write_summary(
    folder: Path,
    campaign: Campaign,
    jobs: Sequence[Job],
    records: Sequence[Record],
    failures: Sequence[Failure],
    *,
    tables: Mapping[str, Table],
    figures: Sequence[CampaignFigure],
    command: str = "",
) -> Path:
    """Write `summary.html` into a folder: one file that needs no other, no network, no script.

    Args:
        folder: Where; its `figures` folder has the PNG of every figure already.
        campaign: What was compared.
        jobs: All its jobs.
        records: Those that are done.
        failures: Those that could not be run.
        tables: Tables by the name of their file.
        figures: The figures.
        command: What was typed, to be repeated.

    Returns:
        The file.

    Raises:
        InputError: the disk refuses.
    """
    done = {r.job.key for r in records}
    failed = [f for f in failures if f.job.key not in done]
    ended = done | {f.job.key for f in failed}
    text = _template().render(
        name=campaign.name,
        doc=campaign.doc,
        jobs=len(jobs),
        records=len(records),
        failures=failed[:LISTED],
        failed=len(failed),
        missing=_missing([job for job in jobs if job.key not in ended]),
        unrunnable=_unrunnable(records),
        facts=_facts(campaign, records, command),
        methods=[_method(entry) for entry in campaign.entries],
        problems=[_problem(task) for task in campaign.tasks],
        tables=[
            (name, tables[name], len(tables[name].rows) <= OPEN)
            for name in sorted(tables, key=lambda name: name != "ranking")  # the result first
        ],
        pictures=pictures(figures, folder / "figures"),
        file=campaign.text,
        endings=sorted(FORMS),
    )
    write_text(folder / PAGE, text)
    return folder / PAGE


def command(campaign: Campaign) -> str:
    """What makes the campaign again; one that is not shipped from its copy beside the page."""
    name, text = campaign.name, campaign.text
    if not text:  # made in Python: there is no file to run
        return ""
    source = name if shipped().get(name) == text else "campaign.toml"
    cut = campaign.repeats != parsed(text).repeats
    return f"stribeck bench {source}" + f" --trials {campaign.repeats}" * cut


def pictures(
    figures: Sequence[CampaignFigure], folder: Path, limit: int = PICTURES
) -> list[Picture]:
    """The figures as PNGs in text, smaller where they would make the page too large."""
    shown: list[Picture] = []
    for scale in SCALES:
        shown = [_picture(figure, folder / f"{figure.name}.png", scale) for figure in figures]
        if sum(len(picture.source) for picture in shown) <= limit:
            break
    return shown


def _picture(drawn: CampaignFigure, file: Path, scale: float) -> Picture:
    with Image.open(file) as image:
        plain = image.convert("RGB")
    # What the page shows at most: a picture is twice as sharp as a common screen.
    size = (max(1, round(plain.width * scale)), max(1, round(plain.height * scale)))
    if size != plain.size:
        plain = plain.resize(size, Image.Resampling.LANCZOS)
    out = io.BytesIO()
    few = plain.quantize(COLOURS, method=Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
    few.save(out, "PNG", optimize=True)  # coverage: a rare colour is a mark, and must stay
    source = "data:image/png;base64," + base64.b64encode(out.getvalue()).decode("ascii")
    shown = drawn.figure.get_size_inches() * 96  # CSS pixels
    return Picture(drawn.name, drawn.title, drawn.caption, source, round(shown[0]), round(shown[1]))


@lru_cache(maxsize=1)
def _template() -> Template:
    environment = Environment(
        loader=PackageLoader("stribeck.bench", ""),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["count"] = lambda n: f"{n:,}"
    return environment.get_template(f"{PAGE}.j2")


def _missing(jobs: Sequence[Job]) -> list[tuple[str, str, int]]:
    """(problem, method, runs) of every cell that is not complete."""
    return [(*cell, runs) for cell, runs in Counter(job.cell for job in jobs).items()]


def _unrunnable(records: Sequence[Record]) -> tuple[int, int]:
    """Evaluations whose cost was not a finite number, and the runs that met any."""
    return sum(r.failed for r in records), sum(r.failed > 0 for r in records)


def _facts(campaign: Campaign, records: Sequence[Record], typed: str) -> list[tuple[str, str]]:
    """What the numbers depend on."""
    evaluations = sum(r.evaluations for r in records)
    facts = [
        ("Runs of a cell", f"{campaign.repeats:,}"),
        ("Seed", f"{campaign.seed}, and from it one for each run, by its labels and its number"),
        ("Target precisions", _span(campaign.precisions)),
        ("Reference", f"{campaign.reference}, with which the others are compared"),
        (
            "Work",
            f"{evaluations:,} evaluations, {duration(sum(r.seconds for r in records))} of runs",
        ),
        ("Made with", _software()),
    ]
    return [*facts, ("To make it again", typed)] if typed else facts


def _span(values: Any) -> str:
    first, last = as_entered(values[0]), as_entered(values[-1])
    several = f"{len(values)}, from {first} to {last}"
    return f"{several if len(values) > 1 else first} above the minimum, where that is known"


def _software() -> str:
    parts = {
        "stribeck": __version__,
        "Python": platform.python_version(),
        "NumPy": np.__version__,
        "SciPy": scipy.__version__,
        "Matplotlib": mpl.__version__,
    }
    return ", ".join(f"{name} {version}" for name, version in parts.items())


def _method(entry: Entry) -> dict[str, Any]:
    """A line of the table of methods."""
    budget = ""
    if entry.budget is not None:
        budget = f"{entry.budget:,}"
    if entry.budget_per_dim is not None:
        budget = f"{entry.budget_per_dim:,} × dimension"
    return {
        "label": entry.label,
        "method": entry.method,
        "settings": [("", _settings(entry.settings))] * bool(entry.settings)
        + [(label, _settings(settings)) for label, settings in entry.on.items()],
        "unit_free": entry.unit_free,
        "problems": "all" if entry.problems is None else ", ".join(entry.problems),
        "budget": budget or "the problem's",
    }


def _settings(settings: Mapping[str, Any]) -> str:
    return ", ".join(f"{name} = {_value(value)}" for name, value in settings.items())


def _value(value: Any) -> str:
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(_value, value)) + "]"
    if isinstance(value, float):
        return as_entered(value)
    return str(value)


def _problem(task: Task) -> dict[str, Any]:
    """A line of the table of problems."""
    first = task.problem(0)
    target = task.target if task.target is not None else first.J_min
    spec = ", ".join(f"{k} {v}" for k, v in task.spec.items() if v is not None)
    return {
        "label": task.label,
        "what": spec.removeprefix("surface "),
        "box": _box(first.space),
        "minimum": "not known" if first.minimum is None else as_entered(first.minimum),
        "target": "none" if task.open_end or target is None else as_entered(target),
        "budget": f"{task.budget:,}",
    }


def _box(space: Space) -> str:
    """The ranges: one for all variables where they are the same."""
    ranges = [f"{q.lower:g} to {q.upper:g}{f' {q.unit}' * bool(q.unit)}" for q in space.params]
    if len(set(ranges)) == 1:
        return f"{ranges[0]} in {len(ranges)} variable{'s' * (len(ranges) > 1)}"
    return ", ".join(f"{q.name} {r}" for q, r in zip(space.params, ranges, strict=True))
