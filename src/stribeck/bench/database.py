"""The SQLite file of a campaign: created, opened and checked; its errors as messages."""

from __future__ import annotations

import contextlib
import errno
import os
import sqlite3
from collections.abc import Callable, Iterator
from pathlib import Path

from .._version import __version__
from ..draft import Draft
from ..errors import InputError

#: "strb": marks a SQLite file as ours.
APPLICATION = 0x73747262
#: The version of the tables below.
SCHEMA = 1
#: Seconds to wait for another process that writes.
PATIENCE = 5.0

_NO_ROOM = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG}

# The tables speak for themselves in a `sqlite3` shell. A file is known by these very words: to
# change one, even of a comment, is another SCHEMA. `cost` has no type on purpose: in a REAL column
# SQLite keeps -0.0 as 0.
_TABLES = {
    "meta": "CREATE TABLE meta (name TEXT PRIMARY KEY, value NOT NULL)",
    "jobs": """CREATE TABLE jobs (
  key TEXT NOT NULL PRIMARY KEY,  -- digest of text
  problem TEXT NOT NULL,
  algorithm TEXT NOT NULL,
  repeat INTEGER NOT NULL,
  position INTEGER NOT NULL,  -- in which order they were added
  text TEXT NOT NULL,         -- JSON: all that decides the run
  UNIQUE (problem, algorithm, repeat)
)""",
    "records": """CREATE TABLE records (
  job TEXT NOT NULL PRIMARY KEY REFERENCES jobs (key),
  problem TEXT NOT NULL,
  algorithm TEXT NOT NULL,
  repeat INTEGER NOT NULL,
  cost NOT NULL,                -- the least met; Inf if no point could be run
  evaluations INTEGER NOT NULL,
  ended TEXT NOT NULL,          -- target, budget, or the method's own word
  reached INTEGER NOT NULL,     -- 1 if the target was met
  failed INTEGER NOT NULL,      -- costs that were not finite
  x TEXT NOT NULL,              -- JSON: the best point
  rounds TEXT NOT NULL,         -- JSON: rounds of search by stage
  events TEXT NOT NULL,         -- JSON: how often the method said what
  seconds REAL NOT NULL,
  finished TEXT NOT NULL        -- UTC
)""",
    "traces": """CREATE TABLE traces (  -- the improvements of a run, little-endian
  job TEXT NOT NULL PRIMARY KEY REFERENCES records (job),
  evaluations BLOB NOT NULL,  -- int64
  rounds BLOB NOT NULL,       -- int64
  costs BLOB NOT NULL         -- float64
)""",
    "claims": """CREATE TABLE claims (  -- jobs being run
  job TEXT NOT NULL PRIMARY KEY REFERENCES jobs (key),
  owner TEXT NOT NULL         -- the file that the process holds a lock on
)""",
    "failures": """CREATE TABLE failures (  -- jobs given up; the next run tries them again
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  job TEXT NOT NULL UNIQUE REFERENCES jobs (key),
  message TEXT NOT NULL
)""",
}


def exists(file: Path) -> bool:
    """Whether a file is there; says why if it is no store of ours, from its head alone."""
    try:
        if file.is_dir():
            raise InputError(f"{file}: is a folder, not a store: name a file")
        if not file.exists():
            return False
        with file.open("rb") as opened:
            head = opened.read(100)
    except OSError as error:
        raise InputError(f"{file}: cannot be read: {error.strerror or error}") from error
    application = int.from_bytes(head[68:72], "big")
    schema = int.from_bytes(head[60:64], "big")
    if not head:
        raise InputError(f"{file}: is empty, not a store: remove it or take another --out")
    if not head.startswith(b"SQLite format 3\0"):
        raise InputError(f"{file}: is not a store of a campaign: take another --out")
    if application != APPLICATION:
        raise InputError(f"{file}: is a database of another program: take another --out")
    if schema != SCHEMA:
        age = "a newer" if schema > SCHEMA else "an older"
        raise InputError(
            f"{file}: was written by {age} stribeck (schema {schema}; this one reads {SCHEMA}): "
            "take that version or another --out"
        )
    return True


def make(file: Path, meta: dict[str, str]) -> None:
    """Make a store beside its place and move it there whole: nobody ever meets half of one."""
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        aside = Draft(file.parent)
        try:
            draft = aside.files / "store"
            with plainly(file), contextlib.closing(sqlite3.connect(draft)) as db:
                db.execute("PRAGMA journal_mode = WAL")
                db.execute("BEGIN")
                db.execute(f"PRAGMA application_id = {APPLICATION}")
                db.execute(f"PRAGMA user_version = {SCHEMA}")
                for table in _TABLES.values():
                    db.execute(table)
                meta = {**meta, "stribeck": __version__}
                db.executemany("INSERT INTO meta VALUES (?, ?)", meta.items())
                db.commit()
            _place(draft, file)
        finally:
            aside.discard()
    except OSError as error:
        if error.errno in _NO_ROOM:
            raise InputError(_full(file, lambda: None)) from error
        raise InputError(f"{file}: cannot be made: {error.strerror or error}") from error


def _place(draft: Path, file: Path) -> None:
    """Give a finished file its name, unless another process has just made one of that name."""
    try:
        os.link(draft, file)
    except FileExistsError:
        return
    except OSError:  # a file system without links
        if not file.exists():
            draft.rename(file)


def connect(file: Path) -> sqlite3.Connection:
    """A connection to a store that is whole.

    Raises:
        InputError: it is damaged, or cannot be opened.
    """
    with plainly(file):
        if _log(file).exists():  # of a process at work, or killed: not to be merged into a wreck
            with contextlib.closing(_connected(file, "ro")) as db:
                _check(file, db)
        db = _connected(file, "rw")
        try:
            _check(file, db)
            db.execute("PRAGMA foreign_keys = ON")
            db.execute("PRAGMA temp_store = MEMORY")
        except BaseException:
            db.close()
            raise
    return db


def _connected(file: Path, mode: str) -> sqlite3.Connection:
    address = f"{file.absolute().as_uri()}?mode={mode}"
    if not os.access(file.parent, os.W_OK) and not _log(file).exists():
        address += "&immutable=1"  # nobody writes here, and SQLite could not lay its log beside it
    return sqlite3.connect(address, uri=True, timeout=PATIENCE, isolation_level=None)


def _log(file: Path) -> Path:
    return file.with_name(file.name + "-wal")


def _check(file: Path, db: sqlite3.Connection) -> None:
    (word,) = db.execute("PRAGMA quick_check(1)").fetchone()
    if word != "ok":
        raise InputError(damaged(file, str(word)))
    tables = dict(db.execute("SELECT name, sql FROM sqlite_schema WHERE type = 'table'"))
    if differing := [name for name, sql in _TABLES.items() if tables.get(name) != sql]:
        raise InputError(damaged(file, f"table {differing[0]!r} is missing or not as it was"))
    meta = dict(db.execute("SELECT name, value FROM meta"))
    if not {"campaign", "seed", "text"} <= set(meta) or not str(meta["seed"]).isdecimal():
        raise InputError(damaged(file, "it does not say which campaign it is of"))


@contextlib.contextmanager
def plainly(file: Path, safe: Callable[[], int | None] = lambda: None) -> Iterator[None]:
    """Turn what SQLite and the disk refuse into one line for a person."""
    try:
        yield
    except sqlite3.Error as error:
        code = getattr(error, "sqlite_errorcode", 0) & 0xFF
        raise InputError(_refusal(file, code, error, safe)) from error
    except OSError as error:
        if error.errno in _NO_ROOM:
            raise InputError(_full(file, safe)) from error
        raise InputError(f"{file}: {error.strerror or error}") from error


@contextlib.contextmanager
def transaction(db: sqlite3.Connection, *, lasting: bool = True) -> Iterator[None]:
    """All or nothing.

    Args:
        db: A connection that commits by itself elsewhere.
        lasting: Whether it has to outlast a power cut, and waits for the disk.
    """
    db.execute(f"PRAGMA synchronous = {'FULL' if lasting else 'NORMAL'}")
    try:  # around BEGIN too: Ctrl-C may come right after it
        db.execute("BEGIN IMMEDIATE")
        yield
        db.execute("COMMIT")
    except BaseException:
        if db.in_transaction:
            db.execute("ROLLBACK")
        raise


def _refusal(file: Path, code: int, error: sqlite3.Error, safe: Callable[[], int | None]) -> str:
    match code:
        case sqlite3.SQLITE_FULL:
            return _full(file, safe)
        case sqlite3.SQLITE_IOERR:
            return _full(file, safe, "the disk is full or failing")
        case sqlite3.SQLITE_BUSY | sqlite3.SQLITE_LOCKED:
            return f"{file}: is locked by another program: close it and give the same command again"
        case sqlite3.SQLITE_READONLY | sqlite3.SQLITE_PERM | sqlite3.SQLITE_CANTOPEN:
            return f"{file}: cannot be written: make it and its folder writable"
        case sqlite3.SQLITE_CORRUPT | sqlite3.SQLITE_NOTADB:
            return damaged(file, str(error))
        case _:
            raise error


def _full(file: Path, safe: Callable[[], int | None], trouble: str = "the disk is full") -> str:
    if not file.exists():
        return f"{trouble}: {file} cannot be made; make room and give the same command again"
    runs = safe()
    state = "the finished runs are" if runs is None else f"{runs} finished runs are"
    return f"{trouble}: {state} safe in {file}; make room and give the same command again"


def damaged(file: Path, trouble: str) -> str:
    """The line for a person."""
    line = " ".join(trouble.split())
    return f"{file}: is damaged ({line}): restore a copy or take another --out"
