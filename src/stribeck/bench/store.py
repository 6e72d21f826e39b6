"""The jobs of a campaign and their records in one SQLite file, see `job_store`."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, NamedTuple, Self

import numpy as np

from ..errors import InputError
from .database import DatabaseSchema, damaged, plainly
from .job_store import SHARED_TABLES, JobStore
from .record import Failure, Job, Record, Steps

# The tables speak for themselves in a `sqlite3` shell. `cost` has no type on purpose: in a REAL
# column SQLite keeps -0.0 as 0.
_TABLES = {
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
}
#: "strb" marks the file of a campaign.
SCHEMA = DatabaseSchema(
    0x73747262,
    1,
    {**SHARED_TABLES, **_TABLES},
    "campaign",
    frozenset({"campaign", "seed", "text"}),
)

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


class Store(JobStore[Job, Record | Failure]):
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

    SCHEMA = SCHEMA
    LABELS = ("problem", "algorithm", "repeat")

    def __init__(self, file: Path, db: sqlite3.Connection) -> None:
        super().__init__(file, db)
        meta = self.meta
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
        meta = {"campaign": campaign, "seed": str(seed), "text": text}
        return cls._opened(file, meta, must_exist=must_exist).of_campaign(campaign, seed, text)

    def of_campaign(self, campaign: str, seed: int, text: str) -> Self:
        """The same, now with this text of its campaign; closed if it is another's.

        Raises:
            InputError: it is of another campaign or seed.
        """
        try:
            self._check_same(campaign, seed)
            with self._writing():
                self._db.execute("UPDATE meta SET value = ? WHERE name = 'text'", (text,))
            self.text = text
        except BaseException:
            self._db.close()
            raise
        return self

    @classmethod
    def read(cls, file: Path) -> Self:
        """Open a store to look at all it has, also while it is being written.

        Raises:
            InputError: there is none, or it cannot be read.
        """
        return cls._to_look(file)

    def _parsed(self, text: str) -> Job:
        return Job.parse(text)

    def _check_given(self) -> None:
        """Refuse a run whose labels are those of another problem, method or budget."""
        if stranger := self._db.execute(_OTHER).fetchone():
            raise InputError(f"{self.file}: {_differ(*map(Job.parse, stranger))}")

    def keep(self, outcome: Record | Failure) -> None:
        """Keep a record, or that a job was given up."""
        if isinstance(outcome, Record):
            self.commit(outcome)
        else:
            self.fail(outcome)

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
            self._finish(job.key)

    def fail(self, failure: Failure) -> None:
        """Give a job up. The next `open` tries it again."""
        self._give_up(failure.job.key, failure.message)

    def records(self) -> Iterator[Record]:
        """The records of the wanted jobs, cell by cell, bit for bit as they were committed."""
        with plainly(self.file):
            keys = self._db.execute(_ORDER).fetchall()
            for key in keys:
                if row := self._db.execute(_RECORD, key).fetchone():
                    yield self._whole(row)

    def failures(self) -> list[Failure]:
        """The wanted jobs that were given up, in that order."""
        return [Failure(job, message) for job, message in self._given_up()]

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
