"""The identifications of a fleet and their records in one SQLite file, see `job_store`."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Self

from ..bench.database import DatabaseSchema, damaged, plainly
from ..bench.job_store import SHARED_TABLES, JobStore
from ..errors import InputError
from .axis_job import AxisJob, AxisRecord

#: The store's name in its folder.
FILE = "store.sqlite"
_TABLES = {
    "jobs": """CREATE TABLE jobs (
  key TEXT NOT NULL PRIMARY KEY,  -- digest of text
  machine TEXT NOT NULL,
  axis TEXT NOT NULL,
  "when" TEXT NOT NULL,       -- ISO 8601; empty where it is not known
  position INTEGER NOT NULL,  -- in which order they were added
  text TEXT NOT NULL          -- JSON: all that decides the identification
)""",
    "records": """CREATE TABLE records (
  job TEXT NOT NULL PRIMARY KEY REFERENCES jobs (key),
  status TEXT NOT NULL,       -- done or refused
  text TEXT NOT NULL          -- JSON: card, motion, reason, seconds
)""",
}
#: In the order of the table: by machine, month, axis and time, whatever the manifest's.
_ORDER = """
SELECT j.key FROM wanted w JOIN jobs j ON j.key = w.key
ORDER BY j.machine, substr(j."when", 1, 7), j.axis, j."when", j.key"""
_OUTCOME = """
SELECT j.text, r.status, r.text, f.message FROM jobs j LEFT JOIN records r ON r.job = j.key
LEFT JOIN failures f ON f.job = j.key WHERE j.key = ?"""
_COUNTS = """
SELECT r.status, count(*) FROM wanted w JOIN records r ON r.job = w.key GROUP BY r.status"""


class FleetStore(JobStore[AxisJob, AxisRecord]):
    """The store of a fleet; `open` it to run."""

    #: "strf" marks the file of a fleet.
    SCHEMA = DatabaseSchema(0x73747266, 1, {**SHARED_TABLES, **_TABLES}, "fleet")
    LABELS = ("machine", "axis", '"when"')

    @classmethod
    def open(cls, folder: Path) -> Self:
        """Open the store in a folder; make it if it is not there.

        Raises:
            InputError: it is not a store, damaged, or cannot be used.
        """
        return cls._opened(folder / FILE, {})

    def _parsed(self, text: str) -> AxisJob:
        return AxisJob.parse(text)

    def keep(self, outcome: AxisRecord) -> None:
        """Keep a record; one that failed is tried again by the next `open`."""
        if outcome.status == "failed":
            self._give_up(outcome.job.key, outcome.reason)
            return
        with self._writing():
            self._db.execute(
                "INSERT OR IGNORE INTO records VALUES (?, ?, ?)",
                (outcome.job.key, outcome.status, outcome.text),
            )
            self._finish(outcome.job.key)

    def outcomes(self) -> Iterator[AxisRecord]:
        """What became of the wanted jobs, in the order of the table; those still open left out."""
        with plainly(self.file):
            for key in self._db.execute(_ORDER).fetchall():
                text, status, record, message = self._db.execute(_OUTCOME, key).fetchone()
                if record is None and message is None:
                    continue
                job = self._whole_job(key[0], text)
                yield job.failed(message) if record is None else self._whole(job, status, record)

    def _whole(self, job: AxisJob, status: str, text: str) -> AxisRecord:
        """The record of a job.

        Raises:
            InputError: its row was changed by hand.
        """
        try:
            record = job.done(text)
        except (ValueError, TypeError, KeyError) as error:
            raise InputError(damaged(self.file, f"a record cannot be read: {error}")) from error
        if record.status != status:
            words = f"a record says {record.status}, its row {status}"
            raise InputError(damaged(self.file, words))
        return record

    def counts(self) -> dict[str, int]:
        """How many of the wanted jobs are done, and how many refused."""
        with plainly(self.file):
            return dict(self._db.execute(_COUNTS).fetchall())
