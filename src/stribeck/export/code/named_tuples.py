"""NamedTuples in compiled Python: several values that have names, where others have none."""

from __future__ import annotations

import ast
import inspect
from collections.abc import Callable, Mapping
from typing import Any

from .program import Kind


def record_fields(function: Callable[..., Any], annotation: ast.expr | None) -> dict[str, Kind]:
    """The kinds of the values of a NamedTuple that an annotation names; none of anything else."""
    name = annotation.id if isinstance(annotation, ast.Name) else ""
    record = getattr(function, "__globals__", {}).get(name)
    if not (inspect.isclass(record) and issubclass(record, tuple)):
        return {}
    fields: tuple[str, ...] = getattr(record, "_fields", ())
    return {name: kind_of(str(record.__annotations__[name])) for name in fields}


def kind_of(annotation: str) -> Kind:
    """The kind of a value, by its annotation."""
    words: Mapping[str, Kind] = {"int": "whole", "bool": "truth"}
    return words.get(annotation, "real")


def field_name(record: str, field: str) -> str:
    """What a value of a NamedTuple is called where there is none."""
    return f"{record}_{field}"
