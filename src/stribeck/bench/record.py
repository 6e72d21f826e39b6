"""A job, everything that decides one run of a search, and its record, all that is kept of it.

Glossary: a *campaign* compares *methods* on *problems*; a method on a problem is a *cell*, run
`repeats` times. One such run is a *job*; what is kept of it is its *record*.
"""

from __future__ import annotations

import hashlib
import json
import zlib
from collections import Counter
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from typing import Any, Self

import numpy as np
from numpy.random import SeedSequence
from numpy.typing import NDArray

from ..optimize import Trace
from ..space import Array

Counts = NDArray[np.int64]
#: The methods with a stage of tabu search that can meet a deadlock.
TABU = frozenset({"ats", "bts"})


@dataclass(frozen=True, eq=False)
class Job:
    """One run of one method on one problem. Its text holds all that its record depends on.

    Args:
        problem: The problem's label in the campaign.
        algorithm: The method's label.
        repeat: Which of the cell's runs, from 0.
        seed: The campaign's seed.
        budget: Evaluations (rows) that may be spent, exactly.
        target: Cost at or below which the run ends; None to go on.
        minimum: The least cost there is, where it is known. It decides nothing in the run.
        surface: What `bench.problems.problem` makes the problem of.
        method: What `bench.runner.run` makes the search of: its name and settings.
    """

    problem: str
    algorithm: str
    repeat: int
    seed: int
    budget: int
    target: float | None
    minimum: float | None
    surface: Mapping[str, Any]
    method: Mapping[str, Any]

    @cached_property
    def text(self) -> str:
        """The job as canonical JSON: equal jobs have equal texts."""
        return json.dumps(asdict(self), sort_keys=True, separators=(",", ":"))

    @cached_property
    def key(self) -> str:
        """The job's identity: a digest of its text."""
        return hashlib.sha256(self.text.encode()).hexdigest()[:32]

    @property
    def cell(self) -> tuple[str, str]:
        """(problem, algorithm)."""
        return self.problem, self.algorithm

    @property
    def labels(self) -> tuple[str, str, int]:
        """(problem, algorithm, repeat): what names the run in its campaign."""
        return self.problem, self.algorithm, self.repeat

    def seeds(self) -> SeedSequence:
        """The job's own stream of random numbers.

        It hangs on the labels and the repeat alone, so a campaign to which a method or a
        problem is added keeps the records it has.
        """
        labels = (zlib.crc32(self.problem.encode()), zlib.crc32(self.algorithm.encode()))
        return SeedSequence(self.seed, spawn_key=(*labels, self.repeat))

    @classmethod
    def parse(cls, text: str) -> Self:
        """The job whose `text` this is."""
        return cls(**json.loads(text))

    def done(self, line: str) -> Record | Failure:
        """Its record, from its text.

        Raises:
            ValueError: it is not the record of this job.
        """
        record = Record.parse(line)
        if record.job.key != self.key:
            raise ValueError(f"the outcome of another job: {record.job.cell}")
        return record

    def failed(self, message: str) -> Record | Failure:
        """That it could not be run, for a reason."""
        return Failure(self, message)


@dataclass(frozen=True, eq=False)
class Steps:
    """The improvements of a run: its convergence curve, without the evaluations between.

    Args:
        evaluations: At which evaluation, from 1, each new best cost was met; shape (k,).
        rounds: Rounds of search begun by then; shape (k,).
        costs: The best costs, falling; shape (k,).
    """

    evaluations: Counts
    rounds: Counts
    costs: Array

    @classmethod
    def of(cls, trace: Trace) -> Self:
        """The improvements in a trace."""
        best = trace.convergence()
        at = np.flatnonzero(best < np.concatenate([[np.inf], best[:-1]]))
        round_counts = np.cumsum(["round" in note for note in trace.notes], dtype=np.int64)
        step = np.searchsorted(trace.ends, at, side="right")
        return cls((at + 1).astype(np.int64), round_counts[step], best[at])

    def reached(self, cost: float) -> int | None:
        """Evaluations until the first cost at or below `cost`; None if there is none."""
        hit = np.flatnonzero(self.costs <= cost)
        return int(self.evaluations[hit[0]]) if len(hit) else None


@dataclass(frozen=True, eq=False)
class Record:
    """What is kept of a run. All of it but `seconds` is a pure function of the job.

    Args:
        job: What was run.
        x: The best point, physical values.
        cost: Its cost; inf if no point could be run.
        evaluations: Rows of cost evaluated.
        ended: Why it ended: "target", "budget", or the method's own word.
        failed: How many costs were not finite.
        rounds: Rounds of search by stage; the stage is "" where a method has only one.
        events: How often the method said what: "backtrack", "restart", "dispersal", ...
        steps: The improvements.
        seconds: Wall-clock time of the run.
    """

    job: Job
    x: tuple[float, ...]
    cost: float
    evaluations: int
    ended: str
    failed: int
    rounds: dict[str, int]
    events: dict[str, int]
    steps: Steps = field(repr=False)
    seconds: float = 0.0

    @property
    def reached(self) -> bool:
        """Whether the run met its target."""
        return self.job.target is not None and self.cost <= self.job.target

    @property
    def search_rounds(self) -> int:
        """The rounds that Table 4 counts: of a method with a stage of tabu search, that stage's.

        Of such a run that ends before it, none.
        """
        return self.rounds.get("tabu", 0) if self._tabu else sum(self.rounds.values())

    @property
    def entrapments(self) -> int | None:
        """Deadlocks: how often tabu search had to go back or begin anew; None without it."""
        events = self.events
        return events.get("backtrack", 0) + events.get("restart", 0) if self._tabu else None

    @property
    def _tabu(self) -> bool:
        return self.job.method.get("name") in TABU

    @classmethod
    def of(cls, job: Job, trace: Trace, x: Array, ended: str, seconds: float) -> Self:
        """The record of a run, from its trace."""
        rounds = Counter(n.get("stage", "") for n in trace.notes if "round" in n)
        events = Counter(n["event"] for n in trace.notes if "event" in n)
        return cls(
            job=job,
            x=tuple(map(float, x)),
            cost=trace.cost,
            evaluations=len(trace),
            ended=ended,
            failed=trace.failed,
            rounds=dict(sorted(rounds.items())),
            events=dict(sorted(events.items())),
            steps=Steps.of(trace),
            seconds=seconds,
        )

    @property
    def text(self) -> str:
        """The record as one line of JSON; numbers come back bit for bit."""
        fields = {
            "job": self.job.text,
            "x": self.x,
            "cost": self.cost,
            "evaluations": self.evaluations,
            "ended": self.ended,
            "failed": self.failed,
            "rounds": self.rounds,
            "events": self.events,
            "seconds": self.seconds,
            "steps": [values.tolist() for values in vars(self.steps).values()],
        }
        return json.dumps(fields, separators=(",", ":"))

    @classmethod
    def parse(cls, text: str) -> Self:
        """The record whose `text` this is."""
        fields = json.loads(text)
        evaluations, rounds, costs = fields.pop("steps")
        steps = Steps(
            np.array(evaluations, dtype=np.int64),
            np.array(rounds, dtype=np.int64),
            np.array(costs, dtype=float),
        )
        fields |= {"job": Job.parse(fields["job"]), "x": tuple(fields["x"]), "steps": steps}
        return cls(**fields)

    @property
    def content(self) -> str:
        """The record without the time it took: what two runs of a job have in common."""
        return replace(self, seconds=0.0).text


@dataclass(frozen=True)
class Failure:
    """A job that could not be run.

    Args:
        job: Which.
        message: Why, in one line.
    """

    job: Job
    message: str
