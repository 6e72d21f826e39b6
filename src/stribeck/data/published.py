"""Recordings to try things on: real axes that others published, and one that the package brings."""

from __future__ import annotations

import gzip
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from pathlib import Path

from ..errors import InputError
from .readers.file_bytes import sha256

#: The recording that the package brings: the paper's test bed, simulated with its sensors.
SAMPLE = "slide"


@dataclass(frozen=True)
class PublishedFile:
    """A file as it was published: its name, its size in bytes and the SHA-256 of its bytes."""

    name: str
    size: int
    sha256: str


@dataclass(frozen=True)
class PublishedRecording:
    """A recording of a real axis that can be had from those who made it.

    Args:
        name: As it is called here.
        axis: What was recorded.
        citation: Who published it, and where.
        address: Where the files are.
        licence: Under which terms.
        command: What identifies it, in the folder of its files.
        files: Its files.
    """

    name: str
    axis: str
    citation: str
    address: str
    licence: str
    command: str
    files: tuple[PublishedFile, ...]

    def recognised(self, path: Path) -> PublishedFile:
        """The published file that a file is by its content, whatever it is called.

        Raises:
            InputError: it cannot be read, or it is none of them.
        """
        try:
            digest, size = sha256(path), path.stat().st_size
        except OSError as error:
            raise InputError(f"{path}: {error.strerror}") from error
        for file in self.files:
            if file.sha256 == digest:
                return file
        sizes = [file.size for file in self.files if file.name == path.name]
        other = f" has {size:,} bytes, the published one {sizes[0]:,}:" if sizes else ""
        raise InputError(
            f"{path}:{other} is no file of {self.name} as it was published: "
            f"take it from {self.address}"
        )


@cache
def published() -> Mapping[str, PublishedRecording]:
    """Published recordings by name."""
    text = (files("stribeck.data") / "published.toml").read_text(encoding="utf-8")
    return {
        name: PublishedRecording(
            name, **{**table, "files": tuple(PublishedFile(**file) for file in table["files"])}
        )
        for name, table in tomllib.loads(text).items()
    }


def published_named(name: str) -> PublishedRecording:
    """A published recording.

    Raises:
        InputError: there is none of that name.
    """
    if name not in published():
        raise InputError(f"no recording {name!r}: there are {', '.join([SAMPLE, *published()])}")
    return published()[name]


def sample() -> bytes:
    """The text of the recording that the package brings: a CSV of 122 s at 50 Hz."""
    return gzip.decompress((files("stribeck.data") / "samples" / f"{SAMPLE}.csv.gz").read_bytes())
