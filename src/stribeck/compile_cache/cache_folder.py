"""The folder of machine code, and a temporary one where it cannot be written.

It is `stribeck` in NUMBA_CACHE_DIR if that is set, else in the user's cache folder. It is made
private to the user, and what others could have written is not read: loading machine code is
running it. Root's files are read: an image may bring them along. Files unused for longest are
removed when all of them take too much.
"""

from __future__ import annotations

import atexit
import logging
import os
import shutil
import tempfile
import time
from contextlib import suppress
from functools import cached_property
from pathlib import Path
from stat import S_IMODE
from typing import Any

from numba import config
from numba.core.caching import IndexDataCacheFile
from numba.misc.appdirs import AppDirs

#: What all files take at most, bytes; everything there is to compile takes 10 MB.
MOST_BYTES = 128 << 20
#: So old may the mark of a file's last use be, s.
_DAY = 86_400.0
#: What a folder that is read may not allow: to be written by its group or by others.
_WRITABLE_BY_OTHERS = 0o022

_log = logging.getLogger("stribeck")


class Folder:
    """Files of machine code, each under a name that tells its content."""

    def __init__(self) -> None:
        self._pruned = False

    @cached_property
    def path(self) -> Path:
        """Where machine code is kept across processes, if it can be."""
        if config.CACHE_DIR:
            return Path(config.CACHE_DIR).absolute() / "stribeck"
        return Path(AppDirs("stribeck", appauthor=False).user_cache_dir) / "compiled"

    @cached_property
    def _refusal(self) -> str:
        """Why nothing is read from the path, or nothing; it is made where there is none."""
        if not self.path.is_absolute():
            return "there is no home"
        try:
            self.path.mkdir(mode=0o700, parents=True, exist_ok=True)
            status = self.path.stat()
        except OSError as error:
            return error.strerror or str(error)
        strange = hasattr(os, "geteuid") and status.st_uid not in {0, os.geteuid()}
        if strange or (os.name == "posix" and S_IMODE(status.st_mode) & _WRITABLE_BY_OTHERS):
            return "others can write there"
        return ""

    @cached_property
    def writable(self) -> Path | None:
        """The folder to write to: the path, a temporary one, or None where neither can be."""
        reason = self._refusal
        if not reason:
            try:
                tempfile.TemporaryFile(dir=self.path).close()
            except OSError as error:
                reason = error.strerror or str(error)
            else:
                return self.path
        return self._temporary(reason)

    def load(self, name: str) -> Any:
        """What was saved under a name, or None."""
        if self._refusal:
            return None
        try:
            data = _files(self.path)._load_data(name)  # noqa: SLF001 - the name says it all: no index
        except FileNotFoundError:
            return None
        except Exception:  # noqa: BLE001 - unreadable or damaged, in whatever way: compiled anew
            return None
        with suppress(OSError):
            if time.time() - (self.path / name).stat().st_mtime > _DAY:
                os.utime(self.path / name)
        return data

    def save(self, name: str, data: Any) -> None:
        """Keep data under a name; what can be kept nowhere is compiled in each process."""
        if self.writable is None:
            return
        try:
            _files(self.writable)._save_data(name, data)  # noqa: SLF001 - written aside, then renamed
        except OSError as error:
            if self.writable == self.path:  # full, as a rule
                self.writable = self._temporary(error.strerror or str(error))
                self.save(name, data)
        else:
            self._prune()

    def _temporary(self, reason: str) -> Path | None:
        """A folder that is removed when the process ends; processes that it starts share it."""
        _log.warning(
            "cannot keep compiled code in %s (%s): compiling into a temporary folder, "
            "for this run alone", self.path, reason,
        )  # fmt: skip
        try:
            above = tempfile.mkdtemp(prefix="stribeck-")
        except OSError:
            return None
        atexit.register(_remove, above, os.getpid())
        os.environ["NUMBA_CACHE_DIR"] = above
        path = Path(above) / "stribeck"
        path.mkdir(mode=0o700)
        return path

    def _prune(self) -> None:
        """Remove the files unused for longest, once a process, where all take too much."""
        if self._pruned or self.writable != self.path:
            return
        self._pruned = True
        with suppress(OSError):  # another process removes them, too
            files = [(p.stat().st_mtime, p.stat().st_size, p) for p in self.path.iterdir()]
            excess = sum(size for _, size, _ in files) - MOST_BYTES
            for _, size, path in sorted(files):
                if excess <= 0:
                    break
                path.unlink()
                excess -= size


def _files(path: Path) -> Any:
    return IndexDataCacheFile(str(path), "", None)


def _remove(path: str, process: int) -> None:
    if os.getpid() == process:  # not at the end of a fork of it
        shutil.rmtree(path, ignore_errors=True)
