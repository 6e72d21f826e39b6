"""Where the studio keeps sessions, logs and jobs: one SQLite file, and folders beside it.

A change is on the disk when its call returns. Kill the studio at any moment: it opens where it was.
A job is claimed by a worker that holds a lock of its own, as the runs of a campaign are; a claim of
a worker that is gone is nobody's.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import secrets
import sqlite3
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Self, get_args

from ..bench.database import transaction
from ..bench.lock import Owner, alive
from ..errors import InputError
from ..text_file import json_document
from .choices import Choices, Kind, choices_from

#: "strs": marks a SQLite file as a home's; and the version of the tables below.
APPLICATION, SCHEMA = 0x73747273, 1
#: Seconds to wait for another process that writes.
PATIENCE = 10.0
#: Starts of a job after which it is given up: its worker died each time.
STARTS = 3
#: Steps back that a session remembers.
HISTORY = 500

_FILE, _SECRET, _LOGS, _RESULTS = "studio.sqlite", "secret", "logs", "results"
_TABLES = (
    """CREATE TABLE logs (
  id TEXT NOT NULL PRIMARY KEY,  -- of the path: 16 hexadecimal digits
  name TEXT NOT NULL,            -- as people know it
  path TEXT NOT NULL,
  size INTEGER NOT NULL
)""",
    """CREATE TABLE sessions (
  id TEXT NOT NULL PRIMARY KEY,
  name TEXT NOT NULL,
  created TEXT NOT NULL,         -- UTC
  step INTEGER NOT NULL          -- which of its states holds
)""",
    """CREATE TABLE states (
  session TEXT NOT NULL REFERENCES sessions (id),
  step INTEGER NOT NULL,
  choices TEXT NOT NULL,         -- JSON
  PRIMARY KEY (session, step)
)""",
    """CREATE TABLE jobs (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  session TEXT NOT NULL REFERENCES sessions (id),
  kind TEXT NOT NULL,
  request TEXT NOT NULL,         -- JSON: the choices as they were
  parent INTEGER REFERENCES jobs (id),  -- the fit that it is about
  state TEXT NOT NULL,           -- waiting, running, done, failed
  owner TEXT,                    -- the file that its worker holds a lock on
  starts INTEGER NOT NULL DEFAULT 0,
  cancelled INTEGER NOT NULL DEFAULT 0,
  progress TEXT NOT NULL DEFAULT '{}',  -- JSON
  message TEXT NOT NULL DEFAULT '',
  created TEXT NOT NULL,
  ended TEXT
)""",
)


_OF_A_JOB = (
    "id, session, kind, request, parent, state, cancelled, progress, message, created, ended"
)


@dataclass(frozen=True)
class StoredLog:
    """A log that the home knows.

    Args:
        id: By which sessions name it.
        name: As people know it.
        path: Where it is.
        size: Bytes.
    """

    id: str
    name: str
    path: Path
    size: int


@dataclass(frozen=True)
class Session:
    """A session as it stands.

    Args:
        id: Its name in addresses.
        name: As people call it.
        created: When, UTC.
        step: Number of its state.
        choices: What is chosen.
        undo: Whether there is a state before it.
        redo: Whether there is one after it.
    """

    id: str
    name: str
    created: str
    step: int
    choices: Choices
    undo: bool
    redo: bool


@dataclass(frozen=True)
class SessionJob:
    """Work for a worker.

    Args:
        id: Its number.
        session: Whose it is.
        kind: What is to be done.
        choices: The choices as they were when it was asked for.
        parent: The fit that it is about.
        state: `waiting`, `running`, `done` or `failed`.
        cancelled: Whether it is to end.
        progress: How far it is.
        message: Why it failed.
        created: When it was asked for, UTC.
        ended: When it ended, UTC.
    """

    id: int
    session: str
    kind: Kind
    choices: Choices
    parent: int | None
    state: str
    cancelled: bool
    progress: Mapping[str, Any]
    message: str
    created: str
    ended: str | None


class Home:
    """The folder of the studio; each thread and each process opens its own.

    Args:
        folder: Where it is; it is made where it is not there.

    Raises:
        InputError: from every method: the folder or its file cannot be used. What was kept stays.
    """

    def __init__(self, folder: Path) -> None:
        self.folder, self.file = folder, folder / _FILE
        with self._plainly():
            folder.mkdir(parents=True, exist_ok=True)
            for name in (_LOGS, _RESULTS):
                (folder / name).mkdir(exist_ok=True)
            self._db = sqlite3.connect(
                self.file, timeout=PATIENCE, isolation_level=None, check_same_thread=False
            )
            self._make()

    def close(self) -> None:
        """Let go of the file."""
        self._db.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *raised: object) -> None:
        self.close()

    def _make(self) -> None:
        ((application,),) = self._db.execute("PRAGMA application_id")
        ((schema,),) = self._db.execute("PRAGMA user_version")
        ((tables,),) = self._db.execute("SELECT count(*) FROM sqlite_schema")
        if (application, schema) == (APPLICATION, SCHEMA):
            self._db.execute("PRAGMA foreign_keys = ON")
            return
        if tables or application:
            raise InputError(
                f"{self.file}: is not a studio's, or of another version: take another --home"
            )
        self._db.execute("PRAGMA journal_mode = WAL")
        with self._writing():
            ((tables,),) = self._db.execute("SELECT count(*) FROM sqlite_schema")
            if not tables:
                for table in _TABLES:
                    self._db.execute(table)
                self._db.execute(f"PRAGMA application_id = {APPLICATION}")
                self._db.execute(f"PRAGMA user_version = {SCHEMA}")

    def secret(self) -> str:
        """What the cookie of the studio's page says; the same after a restart."""
        path = self.folder / _SECRET
        with self._plainly():
            with contextlib.suppress(FileExistsError):
                place = os.open(path, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o600)
                with os.fdopen(place, "w", encoding="ascii") as file:
                    file.write(secrets.token_urlsafe(32))
            text = path.read_text(encoding="ascii").strip()
        if len(text) < 32:  # noqa: PLR2004 - a secret that is short is damaged
            raise InputError(f"{path}: is damaged: remove it, and open the studio anew")
        return text

    # Logs.

    def keep_log(self, name: str, path: Path) -> StoredLog:
        """Know a log by its path; the same path has the same id."""
        key = hashlib.sha256(os.fsencode(path)).hexdigest()[:16]
        with self._plainly():
            size = sum(f.stat().st_size for f in _files(path))
        with self._writing():
            self._db.execute(
                "INSERT INTO logs VALUES (?, ?, ?, ?) "
                "ON CONFLICT (id) DO UPDATE SET name = excluded.name, size = excluded.size",
                (key, name, str(path), size),
            )
        return StoredLog(key, name, path, size)

    def log_folder(self) -> Path:
        """A new folder for a log that is uploaded."""
        path = self.folder / _LOGS / secrets.token_hex(8)
        with self._plainly():
            path.mkdir()
        return path

    def logs(self) -> dict[str, StoredLog]:
        """All logs, by id."""
        with self._plainly():
            rows = self._db.execute("SELECT id, name, path, size FROM logs").fetchall()
        return {i: StoredLog(i, name, Path(path), size) for i, name, path, size in rows}

    # Sessions.

    def begin(self, name: str, choices: Choices) -> Session:
        """A new session."""
        key = secrets.token_hex(6)
        with self._writing():
            self._db.execute("INSERT INTO sessions VALUES (?, ?, ?, 0)", (key, name, _now()))
            self._db.execute("INSERT INTO states VALUES (?, 0, ?)", (key, _text(choices)))
        return self.session(key)

    def sessions(self) -> list[tuple[str, str, str]]:
        """Id, name and day of each session, the latest first; one without a name has its log's."""
        with self._plainly():
            return self._db.execute(
                "SELECT s.id, coalesce(nullif(s.name, ''), l.name, ''), s.created "
                "FROM sessions s LEFT JOIN states t ON t.session = s.id AND t.step = s.step "
                "LEFT JOIN logs l ON l.id = CASE WHEN json_valid(t.choices) "
                "THEN json_extract(t.choices, '$.logs[0].id') END "
                "ORDER BY s.created DESC, s.rowid DESC"
            ).fetchall()

    def session(self, key: str) -> Session:
        """A session as it stands.

        Raises:
            InputError: there is none, or its state is damaged.
        """
        with self._plainly():
            row = self._db.execute(
                "SELECT s.name, s.created, s.step, t.choices, "
                "(SELECT min(step) FROM states WHERE session = s.id) < s.step, "
                "(SELECT max(step) FROM states WHERE session = s.id) > s.step "
                "FROM sessions s JOIN states t ON t.session = s.id AND t.step = s.step "
                "WHERE s.id = ?",
                (key,),
            ).fetchone()
        if row is None:
            raise InputError("there is no such session")
        name, created, step, text, undo, redo = row
        return Session(key, name, created, step, self._choices(text), bool(undo), bool(redo))

    def change(self, key: str, changes: Mapping[str, Any], step: int | None = None) -> Session:
        """Replace some choices; what was undone before is gone.

        Args:
            key: The session.
            changes: Choice -> its new value.
            step: The state that the caller saw; None for whichever holds.

        Raises:
            InputError: a choice cannot have that value, or the session has moved on meanwhile.
        """
        with self._writing():
            before = self.session(key)
            if step is not None and step != before.step:
                raise InputError("the session was changed in another window: look at it again")
            after = before.choices.changed(dict(changes))
            if "logs" in changes and {log.id for log in after.logs} - set(self.logs()):
                raise InputError("logs: there is no such log")
            if after != before.choices:
                new = before.step + 1
                self._db.execute("DELETE FROM states WHERE session = ? AND step >= ?", (key, new))
                self._db.execute("INSERT INTO states VALUES (?, ?, ?)", (key, new, _text(after)))
                self._db.execute("UPDATE sessions SET step = ? WHERE id = ?", (new, key))
                self._db.execute(
                    "DELETE FROM states WHERE session = ? AND step < ?", (key, new - HISTORY)
                )
        return self.session(key)

    def turn(self, key: str, steps: int) -> Session:
        """Go to the state before (-1) or after (1)."""
        with self._writing():
            self._db.execute(
                "UPDATE sessions SET step = step + ? WHERE id = ? AND EXISTS "
                "(SELECT 1 FROM states WHERE session = sessions.id "
                "AND step = sessions.step + ?)",
                (steps, key, steps),
            )
        return self.session(key)

    # Jobs.

    def ask(self, session: str, kind: Kind, parent: int | None = None) -> SessionJob:
        """Work on a session's choices as they are now."""
        with self._writing():
            choices = self.session(session).choices
            cursor = self._db.execute(
                "INSERT INTO jobs (session, kind, request, parent, state, created) "
                "VALUES (?, ?, ?, ?, 'waiting', ?)",
                (session, kind, _text(choices), parent, _now()),
            )
        return self.job(int(cursor.lastrowid or 0))

    def job(self, number: int) -> SessionJob:
        """A job.

        Raises:
            InputError: there is none of that number.
        """
        # SQLite's numbers have 64 bits; an address may have any.
        if abs(number) < 1 << 63 and (jobs := self._jobs("id = ?", number)):
            return jobs[0]
        raise InputError("there is no such job")

    def jobs(self, session: str) -> list[SessionJob]:
        """The jobs of a session, in order."""
        return self._jobs("session = ?", session)

    def unfinished(self) -> list[SessionJob]:
        """The jobs that wait or run; a job whose worker is gone waits again, or is given up."""
        with self._writing():
            running = self._db.execute(
                "SELECT id, owner, starts FROM jobs WHERE state = 'running'"
            ).fetchall()
            for number, owner, starts in running:
                if alive(self.file, owner):
                    continue
                if starts < STARTS:
                    self._db.execute(
                        "UPDATE jobs SET state = 'waiting', owner = NULL WHERE id = ?", (number,)
                    )
                else:
                    self._finish(number, "failed", "its worker ended without a word, three times")
        return self._jobs("state IN ('waiting', 'running')")

    def claim(self, number: int, owner: Owner) -> bool:
        """Take a waiting job for a worker; False if it waits no longer."""
        with self._writing():
            return bool(
                self._db.execute(
                    "UPDATE jobs SET state = 'running', owner = ?, starts = starts + 1 "
                    "WHERE id = ? AND state = 'waiting'",
                    (owner.name, number),
                ).rowcount
            )

    def cancel(self, number: int) -> None:
        """Ask a job to end; one that waits ends at once."""
        with self._writing():
            self._db.execute("UPDATE jobs SET cancelled = 1 WHERE id = ?", (number,))
            self._db.execute(
                "UPDATE jobs SET state = 'failed', message = 'cancelled before it began', "
                "ended = ? WHERE id = ? AND state = 'waiting'",
                (_now(), number),
            )

    def report(self, number: int, progress: Mapping[str, Any]) -> None:
        """Say how far a job is; it need not outlast a power cut."""
        with self._writing(lasting=False):
            self._db.execute(
                "UPDATE jobs SET progress = ? WHERE id = ?", (json.dumps(progress), number)
            )

    def end(self, number: int, state: str, message: str = "") -> None:
        """A job is `done`, or has `failed` for a reason."""
        with self._writing():
            self._finish(number, state, message)

    def results(self, number: int) -> Path:
        """The folder of a job's results."""
        return self.folder / _RESULTS / str(number)

    def _finish(self, number: int, state: str, message: str) -> None:
        self._db.execute(
            "UPDATE jobs SET state = ?, message = ?, ended = ?, owner = NULL WHERE id = ?",
            (state, message, _now(), number),
        )

    def _jobs(self, condition: str, *values: object) -> list[SessionJob]:
        with self._plainly():
            rows = self._db.execute(
                f"SELECT {_OF_A_JOB} FROM jobs WHERE {condition} ORDER BY id",  # noqa: S608 - ours
                values,
            ).fetchall()
        return [self._job(row) for row in rows]

    def _job(self, row: tuple[Any, ...]) -> SessionJob:
        number, session, kind, request, parent, state, cancelled, progress, *rest = row
        if kind not in get_args(Kind):
            raise InputError(f"{self.file}: is damaged: job {number} is of no kind")
        try:
            far = json_document(progress)
        except (ValueError, RecursionError) as error:
            raise InputError(f"{self.file}: is damaged: progress of job {number}") from error
        choices = self._choices(request)
        return SessionJob(
            number, session, kind, choices, parent, state, bool(cancelled), far, *rest
        )

    def _choices(self, text: str) -> Choices:
        try:
            return choices_from(json_document(text))
        except (InputError, ValueError, TypeError, RecursionError) as error:
            raise InputError(
                f"{self.file}: the choices of a session are damaged: {error}"
            ) from error

    @contextlib.contextmanager
    def _writing(self, *, lasting: bool = True) -> Iterator[None]:
        """All or nothing; within another, a part of it."""
        with self._plainly():
            if self._db.in_transaction:
                yield
                return
            with transaction(self._db, lasting=lasting):
                yield

    @contextlib.contextmanager
    def _plainly(self) -> Iterator[None]:
        """What SQLite and the disk refuse, in a line."""
        try:
            yield
        except sqlite3.DatabaseError as error:
            line = " ".join(str(error).split())
            raise InputError(
                f"{self.file}: cannot be used ({line}): mend it, or take another --home"
            ) from error
        except OSError as error:
            raise InputError(
                f"{error.filename or self.folder}: {error.strerror or error}"
            ) from error


def _files(path: Path) -> list[Path]:
    return [f for f in path.rglob("*") if f.is_file()] if path.is_dir() else [path]


def _text(choices: Choices) -> str:
    return choices.model_dump_json(exclude_defaults=True)


def _now() -> str:
    return datetime.now(UTC).isoformat(" ", "seconds")
