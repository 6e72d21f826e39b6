"""A SQLite file of jobs and records: created, opened and checked; its errors as messages."""

from __future__ import annotations

import contextlib
import errno
import os
import sqlite3
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from .._version import __version__
from ..draft import Draft
from ..errors import InputError

#: Seconds to wait for another process that writes.
PATIENCE = 5.0

_NO_ROOM = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG}


@dataclass(frozen=True)
class DatabaseSchema:
    """What a store's file consists of.

    Args:
        application: Number that marks a SQLite file as such a store.
        version: Of the tables.
        tables: Statement by the name of the table that it creates. A file is known by these very
            words: to change one, even of a comment, is another version.
        work: What the store is of, in messages: "campaign".
        meta: Names that the table `meta` has to have.
    """

    application: int
    version: int
    tables: Mapping[str, str]
    work: str
    meta: frozenset[str] = frozenset()


def exists(file: Path, schema: DatabaseSchema) -> bool:
    """Whether a file is there; says why if it is no store of ours, from its head alone."""
    try:
        if file.is_dir():
            raise InputError(f"{file}: is a folder, not a store: name a file")
        if not file.exists():
            return False
        if not file.is_file():  # a pipe would be waited for
            raise InputError(f"{file}: is no regular file: take another --out")
        with file.open("rb") as opened:
            head = opened.read(100)
    except OSError as error:
        raise InputError(f"{file}: cannot be read: {error.strerror or error}") from error
    application = int.from_bytes(head[68:72], "big")
    version = int.from_bytes(head[60:64], "big")
    if not head:
        raise InputError(f"{file}: is empty, not a store: remove it or take another --out")
    if not head.startswith(b"SQLite format 3\0"):
        raise InputError(f"{file}: is not a store of a {schema.work}: take another --out")
    if application != schema.application:
        raise InputError(f"{file}: is a database of another program: take another --out")
    if version != schema.version:
        age = "a newer" if version > schema.version else "an older"
        raise InputError(
            f"{file}: was written by {age} stribeck (schema {version}; this one reads "
            f"{schema.version}): take that version or another --out"
        )
    return True


def make(file: Path, schema: DatabaseSchema, meta: dict[str, str]) -> None:
    """Make a store beside its place and move it there whole: nobody ever meets half of one."""
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        aside = Draft(file.parent)
        try:
            draft = aside.files / "store"
            with plainly(file), contextlib.closing(sqlite3.connect(draft)) as db:
                db.execute("PRAGMA journal_mode = WAL")
                db.execute("BEGIN")
                db.execute(f"PRAGMA application_id = {schema.application}")
                db.execute(f"PRAGMA user_version = {schema.version}")
                for table in schema.tables.values():
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


def connect(file: Path, schema: DatabaseSchema) -> sqlite3.Connection:
    """A connection to a store that is whole.

    Raises:
        InputError: it is damaged, or cannot be opened.
    """
    with plainly(file):
        if _log(file).exists():  # of a process at work, or killed: not to be merged into a wreck
            with contextlib.closing(_connected(file, "ro")) as db:
                _check(file, db, schema)
        db = _connected(file, "rw")
        try:
            _check(file, db, schema)
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


def _check(file: Path, db: sqlite3.Connection, schema: DatabaseSchema) -> None:
    (word,) = db.execute("PRAGMA quick_check(1)").fetchone()
    if word != "ok":
        raise InputError(damaged(file, str(word)))
    tables = dict(db.execute("SELECT name, sql FROM sqlite_schema WHERE type = 'table'"))
    if differing := [name for name, sql in schema.tables.items() if tables.get(name) != sql]:
        raise InputError(damaged(file, f"table {differing[0]!r} is missing or not as it was"))
    meta = dict(db.execute("SELECT name, value FROM meta"))
    if not schema.meta <= set(meta) or not str(meta.get("seed", 0)).isdecimal():
        raise InputError(damaged(file, f"it does not say which {schema.work} it is of"))


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
