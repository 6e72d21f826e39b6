"""The page of a fit as one call: of a fit at hand, or of a folder that has its report."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ...errors import InputError
from ...identify.result import Fit
from ..contents.gather import Contents
from ..folder import check_file, held, write_text
from .html_page import render, write_page


def report(model: Fit | str | Path, out: str | Path | None = None) -> Path:
    """Write the page of a fit: one file of HTML, to look at and to print, that needs no other.

    Args:
        model: A fit, or a folder that `identify --out` wrote, whose page is made again from its
            report.json.
        out: The file, which ends in .html; of a folder its own page, report.html.

    Returns:
        The file.

    Raises:
        InputError: there is no report in the folder, no place for the page, or the fit has no
            card.
    """
    if isinstance(model, Fit):
        if out is None:
            raise InputError('report: name a file for the page, as in report(fit, "x.html")')
        return _write(model, Path(out))
    if out is not None:
        raise InputError("report: the page of a folder is written into it: leave the file out")
    folder = Path(model)
    with held(folder):
        return write_page(folder)


def _write(fit: Fit, file: Path) -> Path:
    check_file(file, ".html")
    with np.errstate(all="ignore"):
        text = render(Contents(fit).report())
    write_text(file, text)
    return file
