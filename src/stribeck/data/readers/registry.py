"""All readers: those here, and those that other packages declare as `stribeck.readers`."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path

from ...errors import InputError
from .file_bytes import checked, head
from .log_file import LogFile, Reader, ReadOptions

#: The modules of the readers, each with its `READER`; what says most about itself before the rest,
#: plain text last.
_MODULES = (
    "parquet", "feather", "lerobot", "npz", "hdf5_file", "tdms", "mdf4", "ros_bag", "ulog",
    "matlab_file", "twincat", "codesys", "lvm", "signal_express", "klipper", "json_log",
    "delimited",
)  # fmt: skip
#: Of other packages: objects that are a `Reader`.
ENTRY_POINTS = "stribeck.readers"
#: First bytes of what no reader opens.
_REFUSED = {
    b"\x1f\x8b": "a broken gzip archive: copy or export it again",
    b"PK\x03\x04": "a zip or Excel file: save it as CSV",
    b"\xd0\xcf\x11\xe0": "an Excel file: save it as CSV",
    b"%PDF": "a PDF: export the log as CSV",
}


@cache
def readers() -> Mapping[str, Reader]:
    """Readers by name, in the order in which they are asked: those of other packages first.

    Raises:
        InputError: another package declares one that cannot be loaded.
    """
    declared = [_declared(entry) for entry in entry_points(group=ENTRY_POINTS)]
    own = [import_module(f".{name}", __package__).READER for name in _MODULES]
    return {reader.name: reader for reader in (*declared, *own)}


def _declared(entry: EntryPoint) -> Reader:
    package = entry.dist.name if entry.dist is not None else entry.value
    try:
        reader = entry.load()
    except Exception as error:  # a package of somebody else
        raise InputError(
            f"the reader {entry.name} of {package} cannot be loaded ({error}): mend or remove "
            f"{package}"
        ) from error
    if not isinstance(reader, Reader):
        raise InputError(f"{entry.value} of {package} is no Reader: mend or remove {package}")
    return reader


def is_log_folder(path: Path) -> bool:
    """Whether a folder is one log of a format."""
    return any(reader.folders and reader.opens(path, b"") for reader in readers().values())


def opened(path: Path, options: ReadOptions) -> tuple[Reader, LogFile]:
    """The reader of a file, known by its content, and the file as it opens it.

    Raises:
        InputError: it is not there, of no format that is read, or broken.
    """
    first = head(checked(path))
    for reader in readers().values():
        if (reader.folders or not path.is_dir()) and reader.opens(path, first):
            return reader, reader.open(path, options)
    if path.is_dir():
        raise InputError("is a folder: name a log in it")
    if kind := next((words for magic, words in _REFUSED.items() if first.startswith(magic)), None):
        raise InputError(f"is {kind}")
    raise InputError(f"is not text and of no other format that is read: {', '.join(readers())}")
