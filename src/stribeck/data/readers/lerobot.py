"""LeRobot datasets (v2.0 to v3.0), a folder: an episode is a log.

`meta/info.json` names the features and their elements, which become channels: `observation.state`
with the name `elbow.pos` is `observation.state/elbow.pos`. No units stand in it. Episodes lie in a
Parquet file each (v2), or several in one (v3); each row has its `episode_index`.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from ...errors import InputError
from ...wording import option
from .budget import WIDEST
from .frame_log import frame_log
from .isolated import IsolatedFormat
from .log_file import Reader, ReadOptions
from .raw_table import shortened, unique_names
from .sliced_log import SlicedLog

LIBRARIES = ("polars",)
_INFO = Path("meta", "info.json")
_EPISODE = "episode_index"
_LARGEST = 16 << 20  # bytes of info.json
_UNITS = {"timestamp": "s"}
_DEEPEST = 4


def library_log(path: Path, options: ReadOptions) -> SlicedLog:
    """An episode, in a process of its own.

    Raises:
        InputError: there are several and none is named, or none of the number.
    """
    import polars as pl  # noqa: PLC0415 - a fifth of a second that `--help` need not pay

    info = _info(path)
    features = info.get("features")
    files = sorted(path.glob("data/chunk-*/*.parquet"))
    if not isinstance(features, Mapping) or not files:
        raise InputError("is a LeRobot dataset without data: copy it again, with its data folder")
    lazy = pl.scan_parquet(files, missing_columns="insert", extra_columns="ignore")
    if _EPISODE in lazy.collect_schema():
        lazy = _episode(lazy, options.episode)
    names = {n: _channels(n, f) for n, f in features.items() if isinstance(f, Mapping)}
    return frame_log(lazy, names, _UNITS)


_FORMAT = IsolatedFormat("lerobot", LIBRARIES, "a LeRobot dataset", extra="")


def _opens(path: Path, _head: bytes) -> bool:
    return (path / _INFO).is_file()


READER = Reader(
    "lerobot",
    "LeRobot dataset, a folder (v2.0 to v3.0), an episode at a time",
    (),
    _opens,
    _FORMAT.open,
    folders=True,
)


def _info(path: Path) -> Mapping[str, Any]:
    file = path / _INFO
    if file.stat().st_size > _LARGEST:
        raise InputError("has a meta/info.json of more than 16 MiB: is it a LeRobot dataset?")
    try:
        info = json.loads(file.read_bytes())
    except (ValueError, RecursionError) as error:
        raise InputError("has a meta/info.json that is no JSON: copy it again") from error
    if not isinstance(info, Mapping):
        raise InputError("has a meta/info.json that says nothing of features: copy it again")
    return info


def _episode(lazy: Any, part: str | None) -> Any:
    """The rows of an episode."""
    import polars as pl  # noqa: PLC0415 - as above

    column = pl.col(_EPISODE)
    first, last, count = lazy.select(
        column.min().alias("first"), column.max().alias("last"), column.n_unique().alias("count")
    ).collect().row(0)  # fmt: skip
    if part is None and count == 1:
        return lazy
    if part is None:
        named = option("columns", {"episode": str(first)})
        raise InputError(f"has {count} episodes, {first} to {last}: name one, as in {named}")
    if not part.isdecimal() or not first <= int(part) <= last:
        raise InputError(f"has no episode {shortened(part)}: there are {first} to {last}")
    return lazy.filter(column == int(part))


def _channels(name: str, feature: Mapping[str, Any]) -> list[str]:
    """The channels of a feature that is a list of numbers."""
    shape = feature.get("shape")
    if not (isinstance(shape, list) and len(shape) == 1 and isinstance(shape[0], int)):
        return []
    width = min(max(shape[0], 0), WIDEST)
    texts = unique_names(list(_texts(feature.get("names"))))
    if len(texts) == width:
        return [f"{name}/{text}" for text in texts]
    return [f"{name}/{i}" for i in range(1, width + 1)]


def _texts(names: Any, depth: int = 0) -> Iterator[str]:
    """Names in a list, in lists, in an object by kind, or with their places, in their order."""
    if isinstance(names, str):
        yield names
    elif isinstance(names, Mapping) and names and all(isinstance(v, int) for v in names.values()):
        yield from sorted(names, key=lambda name: names[name])
    elif isinstance(names, Mapping) and depth < _DEEPEST:
        for entry in names.values():
            yield from _texts(entry, depth + 1)
    elif isinstance(names, list) and depth < _DEEPEST:
        for entry in names:
            yield from _texts(entry, depth + 1)
