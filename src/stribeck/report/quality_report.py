"""What is in a log, for the terminal and as JSON."""

from __future__ import annotations

from dataclasses import fields
from typing import TYPE_CHECKING

from .format import json_text
from .table import Table
from .terminal import show_table

if TYPE_CHECKING:
    from ..data.quality import Quality


def show_quality(quality: Quality) -> None:
    """Print what is in a log."""
    heads = [quality.file or "recording", ""]
    show_table(Table.of_texts("", heads, quality.lines(), labels=(0, 1)))


def quality_text(quality: Quality) -> str:
    """The same as JSON, SI."""
    values = {f.name: getattr(quality, f.name) for f in fields(quality)}
    return json_text({"schema": "stribeck-quality/1", **values})
