"""Results on disk: what belongs together appears whole or not at all."""

from __future__ import annotations

import os
import re
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING

from ..draft import PREFIX, Draft, settle
from ..errors import InputError
from ..lock_file import NO_LOCKS, remove, taken

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence

    from filelock import FileLock

#: The lock of a folder whose results one process writes.
_LOCK = f"{PREFIX}lock"


def check_folder(folder: Path) -> None:
    """Say before the work starts that its results could not be written.

    Raises:
        InputError: the folder, or one that it lies in, is a file or cannot be written to.
    """
    try:
        place = next(p for p in (folder, *folder.parents) if p.exists())
        usable = os.access(place, os.W_OK | os.X_OK)
    except OSError as error:  # a name too long, say
        raise InputError(f"{folder}: {error.strerror or error}: take another folder") from error
    if not place.is_dir():
        raise InputError(f"{place}: is a file, not a folder: take another name")
    if not usable:
        raise InputError(f"{place}: no permission to write there: take another folder")


def check_file(file: Path, suffix: str = "") -> None:
    """The same for a single file, which has to end in a suffix.

    Raises:
        InputError: also if something else than a file has its name.
    """
    if suffix and file.suffix.lower() != suffix:
        raise InputError(f"{file}: is written as {suffix[1:].upper()}: name it {file}{suffix}")
    try:
        taken = file.exists() and not file.is_file()
    except OSError as error:
        raise InputError(f"{file}: {error.strerror or error}: take another name") from error
    if taken:
        what = "folder: name a file in it" if file.is_dir() else "device: name a file"
        raise InputError(f"{file}: is a {what}")
    check_folder(file.parent)


def write_text(file: Path, text: str) -> None:
    """Write a text file, whole or not at all."""
    write_files(file.parent, lambda place: (place / file.name).write_text(text, encoding="utf-8"))


def write_data(file: Path, data: bytes) -> None:
    """The same for bytes."""
    write_files(file.parent, lambda place: (place / file.name).write_bytes(data))


def write_all(folder: Path, files: Mapping[str, bytes]) -> None:
    """The same for several, by name."""

    def write(place: Path) -> None:
        for name, data in files.items():
            (place / name).write_bytes(data)

    write_files(folder, write)


def write_texts(folder: Path, texts: Mapping[str, str]) -> None:
    """The same for several texts, by name; their lines end as the platform has it."""

    def write(place: Path) -> None:
        for name, text in texts.items():
            (place / name).write_text(text, encoding="utf-8")

    write_files(folder, write)


def with_suffix(file: Path, suffix: str) -> Path:
    """A file's name with its extension, where it has none."""
    return file if file.suffix or not suffix else file.with_name(f"{file.name}{suffix}")


def write_exported(
    files: Mapping[str, bytes], out: str | Path, *, folder: bool, suffix: str
) -> list[Path]:
    """Write what a target exported: one file, or several into a folder.

    Raises:
        InputError: they cannot be written there.
    """
    place = Path(out) if folder else with_suffix(Path(out), suffix)
    if folder:
        check_folder(place)
        with held(place):
            write_all(place, files)
        return [place / name for name in files]
    check_file(place, suffix)
    (data,) = files.values()
    write_data(place, data)
    return [place]


def write_files(folder: Path, write: Callable[[Path], object]) -> None:
    """Let `write` fill an empty folder, then move its files into `folder`, all or none.

    Raises:
        InputError: the disk refuses.
    """
    with _present(folder), _refusals(folder):
        with _draft(folder) as draft:
            write(draft.files)
        draft.publish()


def replace_tree(folder: Path, name: str, write: Callable[[Path], object]) -> None:
    """Let `write` fill an empty folder, which then takes the place of `folder / name`.

    What `write` has not written is no longer there; a reader meets no file that is half written.

    Raises:
        InputError: the disk refuses.
    """
    with _present(folder), _refusals(folder):
        with _draft(folder) as draft:
            place = draft.files / name
            place.mkdir()
            write(place)
            new = {path.relative_to(draft.files) for path in place.rglob("*")}
        files = [path for path in (folder / name).rglob("*") if not path.is_dir()]
        old = {path.relative_to(folder) for path in files} - new
        draft.publish(sorted(map(str, old)))
        for path in sorted((folder / name).rglob("*/"), reverse=True):
            with suppress(OSError):  # not empty
                path.rmdir()


@contextmanager
def _draft(folder: Path) -> Iterator[Draft]:
    """The draft of a folder; discarded where the block that fills it fails."""
    settle(folder)
    draft = Draft(folder)
    try:
        yield draft
    except BaseException:
        draft.discard()
        raise


@contextmanager
def together(folder: Path, *outdated: re.Pattern[str]) -> Iterator[Path]:
    """An empty folder for files that `write_files` and the like write one after the other.

    However the block ends, what it has written then moves into `folder`, and what is outdated
    goes. A process that is killed meanwhile leaves the folder as it was.

    Args:
        folder: Where the files belong; it is made where it is not there.
        outdated: Names of files there that belong to an earlier result.

    Raises:
        InputError: the disk refuses.
    """
    with _present(folder):
        with _refusals(folder):
            settle(folder)
            draft = Draft(folder)
        try:
            yield draft.files
        finally:
            with _refusals(folder):
                _publish(draft, folder, outdated)


def _publish(draft: Draft, folder: Path, outdated: Sequence[re.Pattern[str]]) -> None:
    new = {file.name for file in draft.files.iterdir() if not file.name.startswith(PREFIX)}
    if not new:
        draft.discard()
        return
    old = {file.name for file in folder.iterdir() if file.is_file()} - new
    draft.publish(sorted(name for name in old if any(p.fullmatch(name) for p in outdated)))


@contextmanager
def held(folder: Path | None, *, wait: bool = False) -> Iterator[None]:
    """A folder into which this process alone writes results meanwhile; nothing for None.

    Args:
        folder: The folder; it is made where it is not there.
        wait: Whether to wait while another process holds it.

    Raises:
        InputError: another process writes there, or the disk refuses.
    """
    if folder is None:
        yield
        return
    with _present(folder):
        with _refusals(folder):
            lock = _lock(folder, wait=wait)
        try:
            with _refusals(folder):
                settle(folder)
            yield
        finally:
            if lock is not None:
                remove(folder / _LOCK, lock)


def _lock(folder: Path, *, wait: bool) -> FileLock | None:
    try:
        lock = taken(folder / _LOCK, wait=wait)
    except OSError as error:
        if error.errno in NO_LOCKS:
            return None
        raise
    if lock is None:
        raise InputError(
            f"{folder}: another stribeck is writing its results there: wait for it, or take "
            "another folder"
        )
    return lock


@contextmanager
def _present(folder: Path) -> Iterator[None]:
    """A folder, made where it is not there, and removed again if nothing comes into it."""
    with _refusals(folder):
        new = [p for p in (folder, *folder.parents) if not p.exists()]
        folder.mkdir(parents=True, exist_ok=True)
    try:
        yield
    finally:
        with suppress(OSError):  # not empty: all is well
            for place in new:
                place.rmdir()


@contextmanager
def _refusals(folder: Path) -> Iterator[None]:
    """What the disk refuses, in a line.

    Raises:
        InputError: it does.
    """
    try:
        yield
    except OSError as error:
        drafts = (p.parent for p in (folder, *folder.parents) if p.name.startswith(PREFIX))
        place = next(drafts, folder)  # of a draft, the folder that it is for
        raise InputError(f"{place}: cannot be written: {error.strerror or error}") from error
