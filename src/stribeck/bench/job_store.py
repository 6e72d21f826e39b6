"""Jobs and what became of them in one SQLite file, whatever the jobs are.

A finished job is in the file before another begins. Kill the process at any moment, start it
again, and it goes on: what is there is not run again, and the file ends with the same records.
Several processes may work on one file at once (on one machine: SQLite's log is shared memory).
"""

from __future__ import annotations

import contextlib
import sqlite3
from abc import abstractmethod
from collections.abc import Iterable, Iterator
from itertools import count
from pathlib import Path
from typing import Any, ClassVar, Generic, Self, TypeVar

from ..errors import InputError
from .database import DatabaseSchema, connect, damaged, exists, make, plainly, transaction
from .lock import Owner, alive
from .work_item import WorkItem

#: The tables that every store has beside `jobs` and `records`, whose `key` and `job` are digests.
SHARED_TABLES = {
    "meta": "CREATE TABLE meta (name TEXT PRIMARY KEY, value NOT NULL)",
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

# What this connection looks at: the jobs it was given, in that order, those of them that are not
# known to be done, and those of the last `add`. All vanish with the connection.
_WANTED = """
CREATE TEMP TABLE wanted (key TEXT PRIMARY KEY, position INTEGER NOT NULL);
CREATE TEMP TABLE waiting (position INTEGER PRIMARY KEY, key TEXT NOT NULL UNIQUE);
CREATE TEMP TABLE given (position INTEGER PRIMARY KEY, key, {labels}, text);
"""
_ALL = "CREATE TEMP VIEW wanted AS SELECT key, position FROM main.jobs"

_CLAIM = """
SELECT w.position, w.key, j.text FROM waiting w CROSS JOIN jobs j ON j.key = w.key
WHERE w.key NOT IN (SELECT job FROM records) AND w.key NOT IN (SELECT job FROM claims)
  AND w.key NOT IN (SELECT job FROM failures WHERE id > ?)
ORDER BY w.position LIMIT 1"""
_BUSY = """
SELECT count(*) FROM waiting
WHERE key NOT IN (SELECT job FROM records) AND key NOT IN (SELECT job FROM failures WHERE id > ?)
  AND key NOT IN (SELECT job FROM claims WHERE owner = ?)"""


J = TypeVar("J", bound=WorkItem[Any])
Outcome = TypeVar("Outcome")


class JobStore(Generic[J, Outcome]):
    """A store; `_opened` to run, `_to_look` to look.

    Attributes:
        file: Where it is.
        meta: What it says of itself.

    Raises:
        InputError: from every method: the file cannot be read or written. One line that says why;
            what was committed stays.
    """

    SCHEMA: ClassVar[DatabaseSchema]
    #: The columns of `jobs` between `key` and `position`.
    LABELS: ClassVar[tuple[str, ...]]

    def __init__(self, file: Path, db: sqlite3.Connection) -> None:
        self.file, self._db = file, db
        self._owner: Owner | None = None
        self._next = count()
        with plainly(file):
            self.meta = dict(db.execute("SELECT name, value FROM meta"))
            ((self._since,),) = db.execute("SELECT coalesce(max(id), 0) FROM failures")

    @classmethod
    def _opened(cls, file: Path, meta: dict[str, str], *, must_exist: bool = False) -> Self:
        """The store to run its jobs; made if it is not there."""
        if not exists(file, cls.SCHEMA):
            if must_exist:
                raise InputError(
                    f"{file}: there is no store to go on with: run the {cls.SCHEMA.work} first"
                )
            make(file, cls.SCHEMA, meta)
        store = cls(file, connect(file, cls.SCHEMA))
        try:
            store._db.executescript(_WANTED.format(labels=", ".join(cls.LABELS)))
        except BaseException:
            store._db.close()
            raise
        return store

    @classmethod
    def _to_look(cls, file: Path) -> Self:
        """The store to look at all it has, also while it is being written."""
        if not exists(file, cls.SCHEMA):
            raise InputError(f"{file}: there is no store: run the {cls.SCHEMA.work} first")
        store = cls(file, connect(file, cls.SCHEMA))
        store._db.execute(_ALL)
        store._db.execute("PRAGMA query_only = ON")
        return store

    @abstractmethod
    def _parsed(self, text: str) -> J:
        """The job whose text this is."""

    @abstractmethod
    def keep(self, outcome: Outcome) -> None:
        """Keep what became of a job. It is on the disk when this returns."""

    def _check_given(self) -> None:
        """Refuse jobs that do not go with those of the store; called in a transaction."""

    def close(self) -> None:
        """Let go of what was claimed, and of the file; a second time nothing is left to do."""
        owner, self._owner = self._owner, None
        if owner:
            # On a full disk the claims stay: without their owner they are nobody's.
            with contextlib.suppress(InputError), self._writing():
                self._db.execute("DELETE FROM claims WHERE owner = ?", (owner.name,))
            owner.close()
        self._db.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *raised: object) -> None:
        self.close()

    def add(self, jobs: Iterable[J]) -> None:
        """Say which jobs are wanted; those that are new are added.

        Of a store that holds more, the rest is left alone and not counted.
        """
        rows = ((next(self._next), j.key, *j.labels, j.text) for j in jobs)
        labels, marks = ", ".join(self.LABELS), ", ".join("?" * (len(self.LABELS) + 3))
        db = self._db
        with plainly(self.file):
            db.execute("DELETE FROM given")
            db.executemany(f"INSERT INTO given VALUES ({marks})", rows)  # noqa: S608 - marks alone
        with self._writing():
            db.execute(
                f"INSERT INTO jobs SELECT key, {labels}, position + "  # noqa: S608 - our columns
                "(SELECT coalesce(max(position) + 1, 0) FROM jobs) - "
                "(SELECT min(position) FROM given), text FROM given WHERE true ORDER BY position "
                "ON CONFLICT DO NOTHING"
            )
            self._check_given()
            db.execute("INSERT OR IGNORE INTO wanted SELECT key, position FROM given")
            db.execute(
                "INSERT OR IGNORE INTO waiting SELECT position, key FROM given "
                "WHERE key NOT IN (SELECT job FROM records)"
            )

    def left(self) -> int:
        """How many of the wanted jobs have no record yet."""
        return self._count("waiting WHERE key NOT IN (SELECT job FROM records)")

    def claim(self) -> J | None:
        """The next job to run, from now on this process's; None if there is none now.

        It has no record, was not given up since this store was opened, and no living process has
        claimed it.
        """
        with self._writing(lasting=False):
            if not self._owner:
                self._owner = Owner(self.file)
            self._free_the_dead()
            row = self._db.execute(_CLAIM, (self._since,)).fetchone()
            if not row:
                return None
            position, key, text = row
            # Passed over once is enough: jobs that other processes have finished meanwhile.
            self._db.execute(
                "DELETE FROM waiting WHERE position < ? "
                "AND EXISTS (SELECT 1 FROM records WHERE job = key)",
                (position,),
            )
            self._db.execute("INSERT INTO claims VALUES (?, ?)", (key, self._owner.name))
        return self._whole_job(key, text)

    def _whole_job(self, key: str, text: str) -> J:
        """A job as it was added.

        Raises:
            InputError: its row was changed by hand.
        """
        try:
            job = self._parsed(text)
        except (ValueError, TypeError, KeyError, AttributeError) as error:
            raise InputError(damaged(self.file, f"a job cannot be read: {error!r}")) from error
        if job.key != key:
            raise InputError(damaged(self.file, f"job {key} is not what it was"))
        return job

    def _finish(self, key: str) -> None:
        """A job has a record: nobody waits for it."""
        self._db.execute("DELETE FROM waiting WHERE key = ?", (key,))
        self._db.execute("DELETE FROM failures WHERE job = ?", (key,))
        self._db.execute("DELETE FROM claims WHERE job = ?", (key,))

    def _give_up(self, key: str, message: str) -> None:
        """A job has no record, for a reason. The next `open` tries it again."""
        with self._writing():
            self._db.execute(
                "INSERT OR REPLACE INTO failures (job, message) VALUES (?, ?)", (key, message)
            )
            self._db.execute("DELETE FROM claims WHERE job = ?", (key,))

    def _given_up(self) -> list[tuple[J, str]]:
        """The wanted jobs that were given up, in that order, and why."""
        with plainly(self.file):
            rows = self._db.execute(
                "SELECT j.text, f.message FROM failures f JOIN jobs j ON j.key = f.job "
                "WHERE f.job IN (SELECT key FROM wanted) ORDER BY f.id"
            ).fetchall()
        return [(self._parsed(text), message) for text, message in rows]

    def busy(self) -> int:
        """How many jobs others are at, asked once `claim` has returned None.

        They are the wanted jobs that are not done, not given up and not claimed by this process;
        0 says that nothing will come back. A job that its process has just let go of counts too:
        claim it.
        """
        with plainly(self.file):
            mine = (self._since, self._owner.name if self._owner else "")
            ((jobs,),) = self._db.execute(_BUSY, mine)
        return int(jobs)

    def _free_the_dead(self) -> None:
        for (name,) in self._db.execute("SELECT DISTINCT owner FROM claims").fetchall():
            if not alive(self.file, name):
                self._db.execute("DELETE FROM claims WHERE owner = ?", (name,))

    def _count(self, table: str) -> int:
        with plainly(self.file):
            ((n,),) = self._db.execute(f"SELECT count(*) FROM {table}")  # noqa: S608
        return int(n)

    def _safe(self) -> int | None:
        with contextlib.suppress(InputError):
            return self._count("records")
        return None

    @contextlib.contextmanager
    def _writing(self, *, lasting: bool = True) -> Iterator[None]:
        """All or nothing; a claim need not outlast a power cut and does not wait for the disk."""
        with plainly(self.file, self._safe), transaction(self._db, lasting=lasting):
            yield
