"""A campaign file: which methods on which problems, how often, how far."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from importlib.resources import files
from itertools import product
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from ..errors import InputError
from ..optimize import METHODS, configure
from ..optimize.methods import unit_free
from ..space import Array
from ..text_file import page
from .bbob import FUNCTIONS
from .problems import SLIDE_BED, TRAINING, BenchProblem, answer, problem
from .record import Job
from .surfaces import SURFACES
from .third_party import PEERS
from .third_party import chosen as peer

#: Runs of a campaign beyond which a file is more likely wrong than ambitious.
MOST = 1_000_000

#: A number that a table and an axis can hold; a whole one that any program reads exactly.
Finite = Annotated[float, Field(allow_inf_nan=False, ge=-1e100, le=1e100)]
Whole = Annotated[int, Field(strict=True, ge=1, le=2**53)]
Seed = Annotated[int, Field(strict=True, ge=0, le=2**53)]
Label = Annotated[str, Field(min_length=1, max_length=60, pattern=r"^[\w.+ -]+$")]
Settings = dict[str, Any]


class _StrictTable(BaseModel):
    """A table that has no other words than these."""

    model_config = ConfigDict(extra="forbid")


class _Budget(_StrictTable):
    """How many evaluations a run may spend."""

    budget: Whole | None = None
    budget_per_dim: Whole | None = None


class _ProblemTable(_Budget):
    """`[[problem]]`: one problem, or all that its lists span."""

    name: Label | None = None
    surface: str | list[str] | None = None
    bbob: Whole | list[Whole] | None = None
    dim: Whole | list[Whole] = 2
    twin: Seed | Literal["each"] | None = None
    direction: str | list[str] = "right"
    instance: Whole | Literal["each"] = "each"
    target: Finite | Literal["none"] | None = None


class _MethodTable(_Budget):
    """`[[method]]`: a method with its settings, on all problems or on some."""

    name: Label
    method: str | None = None
    like: str | None = None
    unit_free: bool = False
    settings: Settings = {}
    on: dict[str, Settings] = {}
    problems: list[str] | None = None


class _Precisions(_StrictTable):
    """`targets = { from = 1e2, to = 1e-8, count = 51 }`: evenly spaced on a log axis."""

    first: Finite = Field(alias="from", gt=0)
    last: Finite = Field(alias="to", gt=0)
    count: Annotated[int, Field(strict=True, ge=1, le=10_000)] = 51


class _File(_Budget):
    """The whole file."""

    name: Label
    doc: str = ""
    seed: Seed = 0
    repeats: Whole = 1
    reference: str | None = None
    targets: list[Annotated[Finite, Field(gt=0)]] | _Precisions = _Precisions.model_validate(
        {"from": 1e2, "to": 1e-8}
    )
    problem: Annotated[list[_ProblemTable], Field(min_length=1)]
    method: Annotated[list[_MethodTable], Field(min_length=1)]


@dataclass(frozen=True)
class Task:
    """A problem of a campaign.

    Args:
        label: Its name in tables.
        spec: What `problem` makes it of; "each" stands for a value that changes with the repeat.
        budget: Evaluations a run may spend.
        target: Where a run ends; None takes the problem's own.
        open_end: A run goes on to its budget whatever it has found.
    """

    label: str
    spec: Mapping[str, Any]
    budget: int
    target: float | None = None
    open_end: bool = False

    def surface(self, repeat: int) -> dict[str, Any]:
        """The problem's table in one of the repeats."""
        first = {"twin": 0, "instance": 1}  # instances of the suite count from 1
        return {k: first[k] + repeat if v == "each" else v for k, v in self.spec.items()}

    @property
    def dim(self) -> int:
        """Its dimension."""
        return self.problem(0).space.dim

    def problem(self, repeat: int) -> BenchProblem:
        """The problem itself."""
        return problem(self.surface(repeat))


@dataclass(frozen=True)
class Entry:
    """A method of a campaign.

    Args:
        label: Its name in tables.
        method: Its name in METHODS, or among the peers.
        settings: Its settings on all problems.
        on: What differs on some of them.
        unit_free: Whether readings that do not depend on the unit of a cost take the place of
            the paper's constants, see `optimize.methods.unit_free`.
        problems: The labels of the problems it is run on; None for all.
        budget: Evaluations a run may spend; None takes the problem's.
        budget_per_dim: The same times the dimension.
    """

    label: str
    method: str
    settings: Settings = field(default_factory=dict)
    on: Mapping[str, Settings] = field(default_factory=dict)
    unit_free: bool = False
    problems: tuple[str, ...] | None = None
    budget: int | None = None
    budget_per_dim: int | None = None

    def table(self, label: str) -> dict[str, Any]:
        """What a job carries of it on a problem: name and settings."""
        settings = self.settings | self.on.get(label, {})
        if self.unit_free:
            settings = unit_free(self.method, settings)
        return {"name": self.method, "settings": settings}

    def runs_on(self, label: str) -> bool:
        """Whether it is run on a problem."""
        return self.problems is None or label in self.problems


@dataclass(frozen=True)
class Campaign:
    """Methods on problems, each `repeats` times: a table of jobs.

    Args:
        name: Its name.
        doc: What it is for.
        seed: All of its random numbers hang on it.
        repeats: Runs of a cell.
        precisions: Distances from the minimum that the ECDF looks at, falling; shape (k,).
        tasks: The problems.
        entries: The methods.
        reference: The method that the others are compared with.
        text: The file it was read from.
    """

    name: str
    doc: str
    seed: int
    repeats: int
    precisions: Array = field(repr=False)
    tasks: tuple[Task, ...]
    entries: tuple[Entry, ...]
    reference: str
    text: str = field(default="", repr=False)

    def __post_init__(self) -> None:
        if (runs := self.repeats * len(self.cells)) > MOST:
            raise InputError(f"asks for {runs:,} runs: at most {MOST:,} make a campaign")

    def jobs(self) -> Iterator[Job]:
        """Every job: repeats outermost, so that a campaign cut short has some of every cell."""
        for repeat in range(self.repeats):
            for task in self.tasks:
                spec = task.surface(repeat)
                minimum, J_min = answer(spec)
                target = J_min if task.target is None else task.target
                for entry in self.entries:
                    if entry.runs_on(task.label):
                        yield Job(
                            problem=task.label,
                            algorithm=entry.label,
                            repeat=repeat,
                            seed=self.seed,
                            budget=self.budget(task, entry),
                            target=None if task.open_end else target,
                            minimum=minimum,
                            surface=spec,
                            method=entry.table(task.label),
                        )

    def budget(self, task: Task, entry: Entry) -> int:
        """Evaluations a run of the method on the problem may spend."""
        if entry.budget_per_dim is not None:
            return entry.budget_per_dim * task.dim
        return task.budget if entry.budget is None else entry.budget

    def targets(self, jobs: Iterable[Job]) -> dict[str, Array]:
        """The precisions that the ECDF looks at, by problem.

        A run ends at its target: what lies beyond, nobody tried to reach.
        """
        precisions: dict[str, Array] = {}
        for job in jobs:
            if job.problem not in precisions:
                last = 0.0 if job.target is None else job.target - (job.minimum or 0.0)
                precisions[job.problem] = np.unique(np.maximum(self.precisions, last))[::-1]
        return precisions

    def trials(self, repeats: int) -> Campaign:
        """The same with another number of repeats.

        Raises:
            InputError: there is not at least one, or they are too many.
        """
        if repeats < 1:
            raise InputError(f"--trials must be at least 1, got {repeats}")
        return replace(self, repeats=repeats)

    @property
    def cells(self) -> list[tuple[str, str]]:
        """(problem, algorithm) of every cell, in order."""
        return [(t.label, e.label) for t in self.tasks for e in self.entries if e.runs_on(t.label)]


def shipped() -> dict[str, str]:
    """The campaigns that come with the package: name to text."""
    folder = files("stribeck.bench").joinpath("campaigns")
    campaigns = {
        f.name.removesuffix(".toml"): f for f in folder.iterdir() if f.name.endswith(".toml")
    }
    return {name: campaigns[name].read_text(encoding="utf-8") for name in sorted(campaigns)}


def campaign(source: str | Path) -> Campaign:
    """A campaign by its name among `shipped`, or from a TOML file.

    Raises:
        InputError: no such campaign, or something in the file cannot be used: one line that
            says what and where.
    """
    if isinstance(source, str) and source in (ours := shipped()):
        text = ours[source]
    elif str(source).endswith(".toml"):
        try:
            text = page(Path(source))
        except InputError as error:
            raise InputError(f"{source}: {error}") from error
    else:
        raise InputError(
            f"no campaign {str(source)!r}: there are {', '.join(shipped())}; "
            "one of your own is a file that ends in .toml"
        )
    try:
        return parsed(text)
    except InputError as error:
        raise InputError(f"{source}: {error}") from error


def parsed(text: str) -> Campaign:
    """A campaign from the text of its file.

    Raises:
        InputError: see `campaign`.
    """
    try:
        content = _File.model_validate(tomllib.loads(text))
    except ValidationError as error:
        raise InputError(_first(error)) from error
    except (ValueError, RecursionError) as error:
        raise InputError(f"not TOML: {error}") from error
    tasks = tuple(task for p in content.problem for task in _tasks(p, content))
    labels = [t.label for t in tasks]
    _once(labels, "problem")
    _once([m.name for m in content.method], "method")
    result = Campaign(
        name=content.name,
        doc=" ".join(content.doc.split()),
        seed=content.seed,
        repeats=content.repeats,
        precisions=_precisions(content.targets),
        tasks=tasks,
        entries=tuple(_entries(content.method, labels)),
        reference=content.reference or content.method[0].name,
        text=text,
    )
    if result.reference not in (names := [e.label for e in result.entries]):
        raise InputError(f"reference: no method {result.reference!r}: there are {_few(names)}")
    if not result.cells:
        raise InputError("no method is run on any problem")
    for task in tasks:
        task.problem(0)  # says what is wrong with it
        for entry in result.entries:
            if entry.runs_on(task.label):
                _check_method(entry, task)
    return result


def _tasks(entry: _ProblemTable, file: _File) -> Iterator[Task]:
    """All problems that the lists of a table span."""
    if (entry.surface is None) == (entry.bbob is None):
        raise InputError("problem: name a surface or a bbob function, one of them")
    if idle := sorted(entry.model_fields_set & _idle(entry)):
        raise InputError(f"problem: {idle[0]}: means nothing here: leave it out")
    for spec in _bbob(entry) if entry.bbob is not None else _surfaces(entry):
        label = entry.name or _label(spec)
        task = Task(label, spec, 1, None if entry.target == "none" else entry.target)
        yield replace(task, budget=_budget(task, entry, file), open_end=entry.target == "none")


def _idle(entry: _ProblemTable) -> set[str]:
    """The words that decide nothing for a table's problems."""
    if entry.bbob is not None:
        return {"twin", "direction"}
    names, idle = _listed(entry.surface), {"instance"}
    if SLIDE_BED not in names:
        idle.add("direction")
    if names == [SLIDE_BED]:
        idle.add("dim")
    return idle


def _surfaces(entry: _ProblemTable) -> Iterator[dict[str, Any]]:
    for name in _listed(entry.surface):
        if name == SLIDE_BED:
            for direction in _listed(entry.direction):
                if direction not in TRAINING:
                    raise InputError(
                        f"problem: direction: no {direction!r}: there are {', '.join(TRAINING)}"
                    )
                yield {"surface": name, "direction": direction, "twin": entry.twin}
        elif name in SURFACES:
            for dim in _listed(entry.dim):
                yield {"surface": name, "dim": dim, "twin": entry.twin}
        else:
            names = ", ".join([*SURFACES, SLIDE_BED])
            raise InputError(f"problem: no surface {name!r}: there are {names}")


def _bbob(entry: _ProblemTable) -> Iterator[dict[str, Any]]:
    for dim, function in product(_listed(entry.dim), _listed(entry.bbob)):
        if function not in FUNCTIONS:
            raise InputError(f"problem: bbob has functions 1 to 24, got {function}")
        yield {"bbob": function, "dim": dim, "instance": entry.instance}


def _label(spec: Mapping[str, Any]) -> str:
    if "bbob" in spec:
        instance = "" if spec["instance"] == "each" else f"-i{spec['instance']}"
        return f"f{spec['bbob']:02}-d{spec['dim']}{instance}"
    if spec["surface"] == SLIDE_BED:
        stem = f"{SLIDE_BED}-{spec['direction']}"
    else:
        stem = spec["surface"] + (f"-d{spec['dim']}" if spec["dim"] != 2 else "")  # noqa: PLR2004
    twin = spec["twin"]
    return stem if twin is None else f"{stem}-twin" + ("" if twin == "each" else str(twin))


def _budget(task: Task, *levels: _Budget) -> int:
    """The budget of the first level that has one."""
    for level in levels:
        if level.budget is not None and level.budget_per_dim is not None:
            raise InputError("give budget or budget_per_dim, not both")
        if level.budget is not None:
            return level.budget
        if level.budget_per_dim is not None:
            return level.budget_per_dim * task.dim
    raise InputError(f"problem {task.label!r} has no budget: give one for all, budget = 10000")


def _entries(methods: list[_MethodTable], labels: list[str]) -> Iterator[Entry]:
    """The methods in order, each with what it takes over from the one it is like."""
    entries: dict[str, Entry] = {}
    for method in methods:
        place = f"method {method.name!r}"
        if (method.method is None) == (method.like is None):
            raise InputError(f"{place}: give its method, or the one above that it is like")
        for label in [*method.on, *(method.problems or [])]:
            if label not in labels:
                raise InputError(f"{place}: no problem {label!r}: there are {_few(labels)}")
        if method.budget is not None and method.budget_per_dim is not None:
            raise InputError(f"{place}: give budget or budget_per_dim, not both")
        if method.like is not None and method.like not in entries:
            raise InputError(f"{place}: no method {method.like!r} above it to be like")
        parent = entries[method.like] if method.like is not None else Entry("", str(method.method))
        own_budget = method.budget is not None or method.budget_per_dim is not None
        entries[method.name] = Entry(
            label=method.name,
            method=parent.method,
            settings=parent.settings | method.settings,
            on={k: parent.on.get(k, {}) | method.on.get(k, {}) for k in {**parent.on, **method.on}},
            unit_free=parent.unit_free or method.unit_free,
            problems=parent.problems if method.problems is None else tuple(method.problems),
            budget=method.budget if own_budget else parent.budget,
            budget_per_dim=method.budget_per_dim if own_budget else parent.budget_per_dim,
        )
        if method.unit_free and entries[method.name].method in PEERS:
            raise InputError(f"{place}: unit_free is for our own methods: {', '.join(METHODS)}")
        try:
            json.dumps([entries[method.name].settings, entries[method.name].on], allow_nan=False)
        except (TypeError, ValueError) as error:
            raise InputError(f"{place}: settings: {error}") from error
        yield entries[method.name]


def _check_method(entry: Entry, task: Task) -> None:
    table = entry.table(task.label)
    try:
        if entry.method in METHODS:
            configure(entry.method, **table["settings"])
        else:
            peer(entry.method, table["settings"])
    except InputError as error:
        raise InputError(f"method {entry.label!r} on {task.label}: {error}") from error


def _precisions(precisions: list[float] | _Precisions) -> Array:
    if isinstance(precisions, _Precisions):
        ends = precisions.first, precisions.last
        return np.geomspace(max(ends), min(ends), precisions.count)
    if not precisions:
        raise InputError("targets: give at least one precision")
    return np.array(sorted(set(precisions), reverse=True))


def _listed(value: Any) -> list[Any]:
    return value if isinstance(value, list) else [value]


def _once(labels: list[str], kind: str) -> None:
    if doubled := [label for label in dict.fromkeys(labels) if labels.count(label) > 1]:
        raise InputError(f"{kind} {doubled[0]!r} is there twice: give one of them another name")


def _few(labels: list[str], most: int = 8) -> str:
    return ", ".join(labels[:most]) + (", ..." if len(labels) > most else "")


#: What a person is told instead of the checker's own words.
_WORDS = {
    "missing": "is missing",
    "extra_forbidden": "there is no such word here",
    "string_pattern_mismatch": "may have letters, digits, space and . + - _ only",
    "too_short": "needs at least one",
}


def _first(error: ValidationError) -> str:
    """The first thing wrong, as one line."""
    first = error.errors()[0]
    # A union reports each of its members: the path ends where the file's own words end.
    path = [p for p in first["loc"] if isinstance(p, int) or str(p).isidentifier()]
    place = "".join(f"[{p + 1}]" if isinstance(p, int) else f".{p}" for p in path).lstrip(".")
    message = _WORDS.get(first["type"], first["msg"][:1].lower() + first["msg"][1:])
    value = "" if first["type"] in _WORDS else f", got {first['input']!r}"
    return f"{place}: {message}{value}"
