"""Folders of logs: the files of one run, or a run a file.

A file is a log by its extension. Logs that have the same channels are runs; logs of which each has
a channel that no other has are files of one run. Whatever else is in a folder has to be named.
"""

from __future__ import annotations

from pathlib import Path

from ...errors import InputError
from .log_file import ReadOptions
from .log_map import FILE
from .raw_table import listed, printable
from .registry import is_log_folder, opened, readers

_MOST = 100


def runs(path: Path, options: ReadOptions) -> list[tuple[Path, ...]]:
    """The runs in a folder, each as its files; a path of another kind is a run of its own.

    Raises:
        InputError: there are no logs in it, one of them is none, or they are neither runs of the
            same channels nor files of one.
    """
    try:
        single = not path.is_dir() or is_log_folder(path)
    except (OSError, ValueError):  # no name that the system takes: its reader says so
        single = True
    if single:
        return [(path,)]
    files = _logs(path)
    channels = []
    for file in files:
        try:
            channels.append({c.name for c in opened(file, options)[1].channels})
        except InputError as error:
            text = str(error).removeprefix(f"{printable(file.name)}: ")
            raise InputError(f"{printable(file.name)} in it {text}: name the logs") from error
    if all(names == channels[0] for names in channels):
        return [(file,) for file in files]
    alone = [
        names.difference(*(other for other in channels if other is not names)) for names in channels
    ]
    if all(alone):
        return [tuple(files)]
    raise InputError(
        f"is a folder of {listed([f.name for f in files])}, which are neither runs with the same "
        "channels nor files of one run with channels of their own: name them, those of one run as "
        "a.csv+b.csv"
    )


def _logs(folder: Path) -> list[Path]:
    suffixes = {s for reader in readers().values() for s in reader.suffixes}
    files = [
        file
        for file in sorted(folder.iterdir())
        if file.is_file()
        and file.name != FILE
        and not file.name.startswith(".")
        and Path(file.name.lower().removesuffix(".gz")).suffix in suffixes
    ]
    if not files:
        raise InputError("is a folder without logs: name a log")
    if len(files) > _MOST:
        raise InputError(f"is a folder of {len(files)} logs, and {_MOST} is the most: name some")
    return files
