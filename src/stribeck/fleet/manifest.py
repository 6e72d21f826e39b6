"""Manifests: which axes there are, in TOML, CSV or Parquet."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

import polars as pl
from pydantic import ValidationError

from ..drive import DriveChain
from ..errors import InputError
from ..friction import law_named
from ..rig.lookup import rig_named
from ..text_file import page
from .manifest_row import ManifestRow
from .parquet_file import parquet_frame
from .row_pattern import matched_rows

#: What is taken for a manifest.
ManifestSource: TypeAlias = str | Path | pl.DataFrame | Sequence[Mapping[str, Any]]
_COLUMNS = tuple(ManifestRow.model_fields)
_TABLES = ("defaults", "axis", "pattern")
#: What a person is told instead of the checker's own words.
_WORDS = {
    "missing": "is missing: a row needs axis, log and rig",
    "datetime_from_date_parsing": "is no time: write 2026-01-31 or 2026-01-31T08:00",
    "datetime_parsing": "is no time: write 2026-01-31 or 2026-01-31T08:00",
    "datetime_type": "is no time: write 2026-01-31 or 2026-01-31T08:00",
    "value_error": "is no time: write 2026-01-31 or 2026-01-31T08:00",
    "float_parsing": "is not a number",
    "string_too_short": "is empty",
    "string_type": "must be text",
    "greater_than": "is below the absolute zero: give °C",
    "finite_number": "is not a number",
    "string_pattern_mismatch": "has a character that cannot be seen: remove it",
    "string_unicode": "is not text",
}


@dataclass(frozen=True)
class Manifest:
    """Which identifications are wanted.

    Args:
        rows: One each, with the number by which the manifest's reader knows it.
        folder: Where the paths of logs, rigs, columns and drives start.
    """

    rows: tuple[ManifestRow, ...]
    folder: Path


def read_manifest(source: ManifestSource) -> Manifest:
    """A manifest from a file, a frame, or rows as dicts.

    Args:
        source: A TOML file with `[[axis]]` and `[[pattern]]` over `[defaults]`; a CSV or Parquet
            file with a row each; or such rows, whose paths start from the working folder.

    Raises:
        InputError: it cannot be read, or a row cannot be used: one line with row and column.
    """
    if isinstance(source, str | Path):
        file = Path(source)
        try:
            return Manifest(_checked(_rows_of_file(file), file.parent), file.parent)
        except InputError as error:
            raise InputError(f"{file}: {error}") from error
    table = source.iter_rows(named=True) if isinstance(source, pl.DataFrame) else source
    rows = ((f"row {k}", row) for k, row in enumerate(table, 1))
    return Manifest(_checked(rows, Path()), Path())


def _rows_of_file(file: Path) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """The rows of a file, each with how it is called in a message."""
    match file.suffix.lower():
        case ".toml":
            yield from _rows_of_toml(page(file), file.parent)
        case ".csv" | ".parquet":
            frame = _frame(file)
            for k, row in enumerate(frame.iter_rows(named=True), 1):
                yield f"row {k}", row
        case _:
            raise InputError("a manifest is a file that ends in .toml, .csv or .parquet")


def _frame(file: Path) -> pl.DataFrame:
    if not file.is_file():
        raise InputError("no such file")
    try:
        if file.suffix.lower() == ".parquet":
            return parquet_frame(file)
        with file.open(encoding="utf-8-sig") as opened:
            head = opened.readline(1 << 16)
        separator = ";" if head.count(";") > head.count(",") else ","
        frame = pl.read_csv(file, infer_schema=False, separator=separator)
    except UnicodeDecodeError as error:
        raise InputError("is not UTF-8 text: save it as CSV UTF-8") from error
    except (pl.exceptions.PolarsError, pl.exceptions.PanicException, OSError) as error:
        line = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise InputError(f"cannot be read as {file.suffix[1:].upper()}: {line:.200}") from error
    cells = frame.rename(str.strip).with_columns(pl.all().str.strip_chars())
    return cells.with_columns(pl.all().replace("", None))


def _rows_of_toml(text: str, folder: Path) -> Iterator[tuple[str, Mapping[str, Any]]]:
    content = _loaded(text)
    if strange := [name for name in content if name not in _TABLES]:
        raise InputError(f"no table {strange[0]!r}: there are [defaults], [[axis]] and [[pattern]]")
    defaults = content.get("defaults", {})
    tables = {name: content.get(name, []) for name in ("axis", "pattern")}
    for name, entries in {"defaults": [defaults], **tables}.items():
        if not isinstance(entries, list) or not all(isinstance(e, dict) for e in entries):
            head = "[defaults]" if name == "defaults" else f"[[{name}]]"
            raise InputError(f"{name} must be a table: {head} begins one")
    for k, row in enumerate(tables["axis"], 1):
        yield f"axis {k}", {**defaults, **row}
    for k, row in enumerate(tables["pattern"], 1):
        stated, form = dict(row), row.get("when_format")
        stated.pop("when_format", None)
        if not isinstance(stated.get("log"), str) or not isinstance(form, str | None):
            raise InputError(f'pattern {k}: write log = "logs/{{machine}}/{{axis}}/{{when}}.csv"')
        try:
            for n, fields in enumerate(matched_rows(stated["log"], folder, form), 1):
                yield f"pattern {k}, file {n}", {**defaults, **stated, **fields}
        except InputError as error:
            raise InputError(f"pattern {k}: {error}") from error


def _checked(
    rows: Iterable[tuple[str, Mapping[str, Any]]], folder: Path
) -> tuple[ManifestRow, ...]:
    """The rows, each as it should be and none twice."""
    checks, result = _Checks(folder), list[ManifestRow]()
    names: dict[tuple[object, ...], str] = {}
    for name, row in rows:
        stated = {column: value for column, value in row.items() if value is not None}
        try:
            _check_columns(row)
            checked = ManifestRow.model_validate(stated)
            checks(checked)
        except ValidationError as error:
            raise InputError(f"{name}: {_first(error)}") from error
        except InputError as error:
            raise InputError(f"{name}: {error}") from error
        key = (checked.machine, checked.axis, checked.when, checked.log, checked.joint)
        if key in names:
            raise InputError(
                f"{name}: the same machine, axis, time and log as {names[key]}: keep one"
            )
        names[key] = name
        result.append(checked)
    if not result:
        raise InputError("has no rows")
    return tuple(result)


def _check_columns(row: Mapping[str, Any]) -> None:
    if strange := [column for column in row if column not in _COLUMNS]:
        there = ", ".join(_COLUMNS)
        raise InputError(f"column {strange[0]}: is no column: there are {there}")


class _Checks:
    """Looks up what rows name, each name once."""

    def __init__(self, folder: Path) -> None:
        self._folder, self._right = folder, set[tuple[str, str]]()

    def __call__(self, row: ManifestRow) -> None:
        """Refuse a rig, law, map or drive that there is not.

        Raises:
            InputError: its line starts with the column.
        """
        for column in ("rig", "law", "columns", "drive"):
            value = getattr(row, column)
            if value is None or (key := (column, repr(value))) in self._right:
                continue
            try:
                stated_table(column, value, self._folder)
            except InputError as error:
                raise InputError(f"column {column}: {error}") from error
            self._right.add(key)


def stated_table(column: str, value: Any, folder: Path) -> dict[str, Any]:
    """What a row names as a table that needs no file, for `columns` and `drive`; else empty.

    Raises:
        InputError: it is not there, or cannot be what it should be.
    """
    from ..data.readers.log_map import LogMap  # noqa: PLC0415 - readers take time to load

    if column == "rig":
        rig_named(rig_path(value, folder))
    elif column == "law":
        law_named(value)
    elif column == "columns":
        return LogMap.of(folder / value if isinstance(value, str) else value).table()
    else:
        table = _toml(folder / value) if isinstance(value, str) else value
        chain = table.get("drive", table)
        if not isinstance(chain, Mapping):
            raise InputError('drive must be a table: [drive], signal = "A rms", say')
        return DriveChain.of_table(chain).table()
    return {}


def rig_path(name: str, folder: Path) -> str:
    """The name of a shipped rig as it is, that of a file from the folder of its manifest."""
    return str((folder / name).absolute()) if name.lower().endswith(".toml") else name


def _toml(file: Path) -> dict[str, Any]:
    try:
        return _loaded(page(file))
    except InputError as error:
        raise InputError(f"{file.name}: {error}") from error


def _loaded(text: str) -> dict[str, Any]:
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise InputError(f"not TOML: {error}") from error


def _first(error: ValidationError) -> str:
    """The first thing that is wrong with a row, in words."""
    first = error.errors()[0]
    column = str(first["loc"][0]) if first["loc"] else "row"
    words = _WORDS.get(first["type"], first["msg"])
    told = "" if first["type"] == "missing" else f"{first['input']!r:.60} "
    return f"column {column}: {told}{words}"
