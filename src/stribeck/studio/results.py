"""Results of jobs as the page shows them: read from the files that a worker has written."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..errors import InputError
from ..report.contents.schema import Report, read_report
from ..text_file import json_document, page

#: The files of a result that can be asked for, and the kind of each.
FILES = ("card.json", "report.json", "report.html", "selection.json", "plan.json",
         "compensation.json", "compensation.png", "compensation.svg")  # fmt: skip
#: What the page shows of a motion.
_OF_A_MOTION = ("label", "part", "rms", "t", "measured", "model", "residual_t", "residual")
_POLICY = re.compile(r'http-equiv="Content-Security-Policy" content="([^"]+)"')
_WHOLE = {"select": "selection.json", "plan": "plan.json", "compensate": "compensation.json"}


def fit_results(kind: str, folder: Path) -> dict[str, Any]:
    """The result of a job.

    Raises:
        InputError: there is none yet, or its file is damaged.
    """
    if kind == "identify":
        return _fit(read_report(folder))
    return _document(folder / _WHOLE[kind])


def _fit(report: Report) -> dict[str, Any]:
    card = report.card
    return {
        "law": card.law,
        "rig": card.rig,
        "objective": card.objective.model_dump(mode="json"),
        "holdout": [h.model_dump(mode="json") for h in card.holdout],
        "parameters": {n: p.model_dump(mode="json") for n, p in card.parameters.items()},
        "warnings": list(card.warnings),
        "notes": list(card.notes),
        "search": card.search.model_dump(mode="json"),
        "units": report.units.model_dump(mode="json"),
        "friction": report.law.model_dump(mode="json"),
        "motions": [
            {name: getattr(motion, name) for name in _OF_A_MOTION} for motion in report.motions
        ],
    }  # fmt: skip


def compared(folders: Mapping[int, Path]) -> list[dict[str, Any]]:
    """Fits side by side: what is read of each, its motions left out."""
    rows = []
    for number, folder in folders.items():
        fit = _fit(read_report(folder))
        fit.pop("motions")
        rows.append({"job": number, **fit})
    return rows


def result_file(folder: Path, name: str) -> tuple[Path, str | None]:
    """A file of a result, and the policy under which a page of it runs.

    Raises:
        InputError: there is no such file.
    """
    if name not in FILES or not (folder / name).is_file():
        raise InputError("there is no such file")
    path = folder / name
    if path.suffix != ".html":
        return path, None
    match = _POLICY.search(path.read_text(encoding="utf-8")[:4000])
    policy = match[1] if match else "default-src 'none'"
    return path, f"{policy.replace('&#39;', chr(39))}; frame-ancestors 'self'"


def _document(path: Path) -> dict[str, Any]:
    try:
        document = json_document(page(path))
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path}: is damaged: begin the job anew") from error
    except InputError as error:
        raise InputError(f"{path}: {error}") from error
    if not isinstance(document, dict):
        raise InputError(f"{path}: is damaged: begin the job anew")
    return document
