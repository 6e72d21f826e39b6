"""The jobs of a campaign and their records in one SQLite file.

A finished run is in the file before another begins. Kill the process at any moment, start it
again, and it goes on: what is there is not run again, and the file ends with the same records.
Several processes may work on one file at once (on one machine: SQLite's log is shared memory).
"""

from __future__ import annotations

import contextlib
import json
import sqlite3
from collections.abc import Iterable, Iterator
from datetime import UTC, datetime
from itertools import count
from pathlib import Path
from typing import Any, NamedTuple, Self

import numpy as np

from ..errors import InputError
from .database import connect, damaged, exists, make, plainly, transaction
from .lock import Owner, alive
from .record import Failure, Job, Record, Steps

# What this connection looks at: the jobs it was given, in that order, those of them that are not
# known to be done, and those of the last `add`. All vanish with the connection.
_WANTED = """
CREATE TEMP TABLE wanted (key TEXT PRIMARY KEY, position INTEGER NOT NULL);
CREATE TEMP TABLE waiting (position INTEGER PRIMARY KEY, key TEXT NOT NULL UNIQUE);
CREATE TEMP TABLE given (position INTEGER PRIMARY KEY, key, problem, algorithm, repeat, text);
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
_OTHER = """
SELECT j.text, g.text FROM given g JOIN jobs j USING (problem, algorithm, repeat)
WHERE j.key <> g.key ORDER BY g.position LIMIT 1"""
# Cell by cell in the order of their first job, whatever order the jobs were added in.
_ORDER = """
SELECT key FROM (
  SELECT w.key, j.repeat,
    min(w.position) OVER (PARTITION BY j.problem) AS problem,
    min(w.position) OVER (PARTITION BY j.problem, j.algorithm) AS cell
  FROM wanted w JOIN jobs j ON j.key = w.key
) ORDER BY problem, cell, repeat"""
_RECORD = """
SELECT j.text, r.x, r.cost, r.evaluations, r.ended, r.failed, r.rounds, r.events, r.seconds,
  t.evaluations, t.rounds, t.costs
FROM records r JOIN jobs j ON j.key = r.job LEFT JOIN traces t ON t.job = r.job WHERE r.job = ?"""
_PROGRESS = """
SELECT j.problem, j.algorithm, count(r.job), total(r.reached), total(r.seconds), count(*),
  count(f.job), total(r.evaluations), min(r.cost)
FROM wanted w JOIN jobs j ON j.key = w.key
LEFT JOIN records r ON r.job = w.key LEFT JOIN failures f ON f.job = w.key
GROUP BY j.problem, j.algorithm ORDER BY min(w.position)"""


class Progress(NamedTuple):
    """How far a cell is.

    Args:
        problem: The problem's label.
        algorithm: The method's label.
        done: Runs finished.
        reached: Of these, how many met their target.
        seconds: What they took in all.
        jobs: Runs there are to be.
        given_up: Runs that could not be made.
        evaluations: What the finished ones spent in all.
        best: Their least cost; None while there is none.
    """

    problem: str
    algorithm: str
    done: int
    reached: int
    seconds: float
    jobs: int
    given_up: int
    evaluations: int
    best: float | None


class Store:
    """The store of one campaign; `open` it to run, `read` it to look.

    Attributes:
        file: Where it is.
        campaign: The campaign's name.
        seed: Its seed.
        text: The campaign file as it was when the store was last opened to run.

    Raises:
        InputError: from every method: the file cannot be read or written. One line that says why;
            what was committed stays.
    """

    def __init__(self, file: Path, db: sqlite3.Connection) -> None:
        self.file, self._db = file, db
        self._owner: Owner | None = None
        self._next = count()
        with plainly(file):
            meta = dict(db.execute("SELECT name, value FROM meta"))
            ((self._since,),) = db.execute("SELECT coalesce(max(id), 0) FROM failures")
        self.campaign, self.seed, self.text = meta["campaign"], int(meta["seed"]), meta["text"]

    @classmethod
    def open(
        cls, file: Path, *, campaign: str, seed: int, text: str = "", must_exist: bool = False
    ) -> Self:
        """Open the store of a campaign to run it; make it if it is not there.

        Args:
            file: Its folder is made too if only that is missing.
            campaign: The campaign's name.
            seed: Its seed.
            text: Its file, kept for whoever reads the store.
            must_exist: Make nothing.

        Raises:
            InputError: it is not a store, of another campaign, damaged, or cannot be used.
        """
        if not exists(file):
            if must_exist:
                raise InputError(f"{file}: there is no store to go on with: run the campaign first")
            make(file, {"campaign": campaign, "seed": str(seed), "text": text})
        store = cls(file, connect(file))
        try:
            store._check_same(campaign, seed)
            with store._writing():
                store._db.execute("UPDATE meta SET value = ? WHERE name = 'text'", (text,))
            store._db.executescript(_WANTED)
            store.text = text
        except BaseException:
            store._db.close()
            raise
        return store

    @classmethod
    def read(cls, file: Path) -> Self:
        """Open a store to look at all it has, also while it is being written.

        Raises:
            InputError: there is none, or it cannot be read.
        """
        if not exists(file):
            raise InputError(f"{file}: there is no store: run the campaign first")
        store = cls(file, connect(file))
        store._db.execute(_ALL)
        store._db.execute("PRAGMA query_only = ON")
        return store

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

    def add(self, jobs: Iterable[Job]) -> None:
        """Say which jobs are wanted; those that are new are added.

        Of a store that holds more, the rest is left alone and not counted.

        Raises:
            InputError: a run of these labels is there, of another problem, method or budget.
        """
        rows = ((next(self._next), j.key, *j.cell, j.repeat, j.text) for j in jobs)
        db = self._db
        with plainly(self.file):
            db.execute("DELETE FROM given")
            db.executemany("INSERT INTO given VALUES (?, ?, ?, ?, ?, ?)", rows)
        with self._writing():
            db.execute(
                "INSERT INTO jobs SELECT key, problem, algorithm, repeat, position + "
                "(SELECT coalesce(max(position) + 1, 0) FROM jobs) - "
                "(SELECT min(position) FROM given), text FROM given WHERE true ORDER BY position "
                "ON CONFLICT DO NOTHING"
            )
            if stranger := db.execute(_OTHER).fetchone():
                raise InputError(f"{self.file}: {_differ(*map(Job.parse, stranger))}")
            db.execute("INSERT OR IGNORE INTO wanted SELECT key, position FROM given")
            db.execute(
                "INSERT OR IGNORE INTO waiting SELECT position, key FROM given "
                "WHERE key NOT IN (SELECT job FROM records)"
            )

    def left(self) -> int:
        """How many of the wanted jobs have no record yet."""
        return self._count("waiting WHERE key NOT IN (SELECT job FROM records)")

    def claim(self) -> Job | None:
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
            # Passed over once is enough: runs that other processes have finished meanwhile.
            self._db.execute(
                "DELETE FROM waiting WHERE position < ? "
                "AND EXISTS (SELECT 1 FROM records WHERE job = key)",
                (position,),
            )
            self._db.execute("INSERT INTO claims VALUES (?, ?)", (key, self._owner.name))
        return Job.parse(text)

    def commit(self, record: Record) -> None:
        """Keep a record. It is on the disk when this returns; doing it again changes nothing."""
        job, steps = record.job, record.steps
        row = (
            job.key,
            *job.cell,
            job.repeat,
            record.cost,
            record.evaluations,
            record.ended,
            record.reached,
            record.failed,
            *(json.dumps(v) for v in (record.x, record.rounds, record.events)),
            record.seconds,
            datetime.now(UTC).isoformat(" ", "seconds"),
        )
        trace = (job.key, _blob(steps.evaluations), _blob(steps.rounds), _blob(steps.costs))
        marks = ", ".join("?" * len(row))
        with self._writing():
            inserted = self._db.execute(f"INSERT OR IGNORE INTO records VALUES ({marks})", row)  # noqa: S608
            if inserted.rowcount:
                self._db.execute("INSERT INTO traces VALUES (?, ?, ?, ?)", trace)
            self._db.execute("DELETE FROM waiting WHERE key = ?", (job.key,))
            self._db.execute("DELETE FROM failures WHERE job = ?", (job.key,))
            self._db.execute("DELETE FROM claims WHERE job = ?", (job.key,))

    def fail(self, failure: Failure) -> None:
        """Give a job up. The next `open` tries it again."""
        with self._writing():
            self._db.execute(
                "INSERT OR REPLACE INTO failures (job, message) VALUES (?, ?)",
                (failure.job.key, failure.message),
            )
            self._db.execute("DELETE FROM claims WHERE job = ?", (failure.job.key,))

    def records(self) -> Iterator[Record]:
        """The records of the wanted jobs, cell by cell, bit for bit as they were committed."""
        with plainly(self.file):
            keys = self._db.execute(_ORDER).fetchall()
            for key in keys:
                if row := self._db.execute(_RECORD, key).fetchone():
                    yield self._whole(row)

    def failures(self) -> list[Failure]:
        """The wanted jobs that were given up, in that order."""
        with plainly(self.file):
            rows = self._db.execute(
                "SELECT j.text, f.message FROM failures f JOIN jobs j ON j.key = f.job "
                "WHERE f.job IN (SELECT key FROM wanted) ORDER BY f.id"
            ).fetchall()
        return [Failure(Job.parse(text), message) for text, message in rows]

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

    def progress(self) -> list[Progress]:
        """How far each cell is, in order."""
        with plainly(self.file):
            rows = self._db.execute(_PROGRESS).fetchall()
        return [
            Progress(p, a, done, int(reached), seconds, jobs, given_up, int(spent), best)
            for p, a, done, reached, seconds, jobs, given_up, spent, best in rows
        ]

    def _whole(self, row: tuple[Any, ...]) -> Record:
        try:
            return _record(row)
        except (ValueError, TypeError, KeyError) as error:  # rows that were changed by hand
            raise InputError(damaged(self.file, f"a record cannot be read: {error}")) from error

    def _check_same(self, campaign: str, seed: int) -> None:
        if (self.campaign, self.seed) != (campaign, seed):
            raise InputError(
                f"{self.file}: is the store of campaign {self.campaign!r} with seed {self.seed}, "
                f"not of {campaign!r} with seed {seed}: take another --out"
            )

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


def _differ(stored: Job, new_job: Job) -> str:
    """What a run in the store and one of the same name in the campaign differ in."""
    name, stored_value, new_value = _difference(json.loads(stored.text), json.loads(new_job.text))
    return (
        f"{new_job.algorithm} on {new_job.problem}: {name} {_short(stored_value)} in the store, "
        f"{_short(new_value)} in the campaign: take another --out or give the method another name"
    )


def _difference(stored: Any, new: Any, name: str = "") -> tuple[str, Any, Any]:
    """The innermost first difference of two unequal JSON values, and its name."""
    if isinstance(stored, dict) and isinstance(new, dict):
        for key in sorted({*stored, *new}):
            stored_value, new_value = stored.get(key), new.get(key)
            if json.dumps(stored_value, sort_keys=True) != json.dumps(new_value, sort_keys=True):
                return _difference(stored_value, new_value, f"{name}.{key}".lstrip("."))
    return name, stored, new


def _short(value: Any, most: int = 60) -> str:
    text = json.dumps(value)
    return text if len(text) <= most else text[: most - 3] + "..."


def _blob(values: np.ndarray[Any, Any]) -> bytes:
    return values.astype(values.dtype.newbyteorder("<"), copy=False).tobytes()


def _record(row: tuple[Any, ...]) -> Record:
    job, x, cost, evaluations, ended, failed, rounds, events, seconds, *steps = row
    return Record(
        job=Job.parse(job),
        x=tuple(json.loads(x)),
        cost=cost,
        evaluations=evaluations,
        ended=ended,
        failed=failed,
        rounds=json.loads(rounds),
        events=json.loads(events),
        seconds=seconds,
        steps=Steps(
            np.frombuffer(steps[0], "<i8").astype(np.int64),
            np.frombuffer(steps[1], "<i8").astype(np.int64),
            np.frombuffer(steps[2], "<f8").astype(np.float64),
        ),
    )
