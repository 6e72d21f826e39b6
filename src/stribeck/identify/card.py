"""The card: an identified model as a file that people and programs can read, and read back."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Literal, Protocol

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from ..constant import Origin
from ..drive import DriveChain
from ..errors import InputError
from ..friction import law_named
from ..presenters import presenter
from ..rig import RIGS, Rig
from ..rig.axis_table import composed_axis
from ..rig.balanced import as_balanced
from ..rig.composed import ComposedRig
from ..rig.rig import shown_in
from ..space import Param
from ..text_file import json_document, page
from ..units import convertible, unit
from .conditions import Condition
from .loss import Objective
from .parameters import Parameters, partition
from .uncertainty.profile_walk import Ended
from .uncertainty.verdict import Reason, Verdict, verdict_text

#: What a person is told instead of the checker's own words.
_WORDS = {
    "extra_forbidden": "a card has no such field",
    "missing": "is missing",
    "finite_number": "must be a finite number",
    "float_type": "must be a number",
    "int_type": "must be a whole number",
    "string_type": "must be text",
    "dict_type": "must be an object",
    "model_type": "must be an object",
    "model_attributes_type": "must be an object",
    "list_type": "must be a list",
}

Finite = Annotated[float, Field(allow_inf_nan=False)]


#: A speed below this share of the greatest one is no motion in that direction.
ONE_WAY = 0.02


def directions_between(low: float, high: float) -> frozenset[int]:
    """The directions, +1 and -1, of motion between a least and a greatest velocity."""
    least = ONE_WAY * max(abs(low), abs(high))
    return frozenset(way for way, speed in ((1, high), (-1, -low)) if speed > least)


class _CardEntry(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


class ParameterCard(_CardEntry):
    """One parameter, in the unit given.

    `others_at_low` and `others_at_high` are the other parameters as refitted where it is at that
    end of its interval, each in its own unit; empty where they hardly move.
    """

    value: Finite
    unit: str
    low: Finite | None
    high: Finite | None
    others_at_low: dict[str, Finite] = {}
    others_at_high: dict[str, Finite] = {}
    standard_error: Finite | None = None
    spread: Finite | None = None
    at_bound: Literal["lower", "upper"] | None
    verdict: Verdict
    reason: Reason = ""
    borderline: bool = False
    low_ended: Ended | None = None
    high_ended: Ended | None = None
    resampled: list[Finite] | None = None
    meaning: str = ""

    @property
    def verdict_text(self) -> str:
        """The verdict with its reason, for people."""
        return verdict_text(self.verdict, self.reason, borderline=self.borderline)


class SampledCard(_CardEntry):
    """Median and central 95 % interval of one parameter's samples, in the unit of its parameter."""

    median: Finite
    low: Finite
    high: Finite


class PosteriorCard(_CardEntry):
    """Samples of the posterior: how many, the share of steps taken, whether walkers settled."""

    samples: int
    accepted: Finite
    settled: bool
    parameters: dict[str, SampledCard]


class StaircaseCard(_CardEntry):
    """How the axis, or the model, stuck and slipped: slips, their median in m or rad, a share."""

    slips: int
    jump: Finite
    stuck: Finite


class ObjectiveCard(_CardEntry):
    """The misfit on the training data."""

    name: Literal["position_rmse", "position_mae", "relative_error"]
    value: Finite
    unit: str
    baselines: dict[str, Finite] = {}
    samples: int
    restart: bool = False
    breakaway: Literal["common", "scattered"] = "common"
    staircase: dict[Literal["measured", "modelled"], StaircaseCard] = {}


class HoldoutCard(_CardEntry):
    """The misfit on a range that was not trained on, and what that tests."""

    range: str
    tests: str = ""
    moves: bool = True
    value: Finite
    unit: str
    baselines: dict[str, Finite] = {}
    samples: int
    staircase: dict[Literal["measured", "modelled"], StaircaseCard] = {}


class SearchCard(_CardEntry):
    """How the answer was searched for."""

    method: str
    seed: int | None
    evaluations: int
    seconds: Finite
    ended: str
    repeats: list[Finite] = []


class DataCard(_CardEntry):
    """A log that was used."""

    file: str
    sha256: str
    rows: int
    used: int


class SpeedsCard(_CardEntry):
    """Least and greatest velocity of the training data: where the law has been seen."""

    low: Finite
    high: Finite
    unit: str

    @property
    def directions(self) -> frozenset[int]:
        """The directions, +1 and -1, in which the axis moved."""
        return directions_between(self.low, self.high)

    @property
    def one_way(self) -> str:
        """Which direction was not seen, in a sentence; empty if both were, or neither."""
        if len(self.directions) != 1:
            return ""
        side = "<" if self.directions == {1} else ">"
        return (
            f"the training data ran one way ({self.low:.4g} to {self.high:.4g} {self.unit}): "
            f"nothing was seen of friction at v {side} 0"
        )


class PaceCard(_CardEntry):
    """How the slowest log moves, SI: its speed as `identify.pace` says, how far, and from where."""

    speed: Annotated[float, Field(allow_inf_nan=False, gt=0.0)]
    travel: Annotated[float, Field(allow_inf_nan=False, gt=0.0)]
    start: Finite


class ConstantCard(_CardEntry):
    """A constant of the rig, with who vouches for it and by how much it may be off.

    Cards of version 0.1 have those that differ from the shipped ones alone, and no tolerance.
    """

    value: Finite
    unit: str
    origin: Origin = "yours"
    tolerance: Finite = 0.0


class CombinationCard(_CardEntry):
    """The sum of a parameter and a constant, or a ratio of parameters, in the unit given."""

    value: Finite
    unit: str
    low: Finite
    high: Finite
    verdict: Verdict
    reason: Reason = ""

    @property
    def verdict_text(self) -> str:
        """The verdict with its reason, for people."""
        return verdict_text(self.verdict, self.reason)


class BreakawayCard(_CardEntry):
    """How a breakaway level varies from slip to slip: its mean is the parameter of that name.

    Standard deviation of the breakaway of single slips, with its 95 % interval, in the unit given.
    """

    unit: str
    sd: Finite
    low: Finite
    high: Finite
    slips: int


class LogSpreadCard(_CardEntry):
    """How a parameter differs from log to log, in the unit given, with 95 % intervals.

    The mean over the logs that know it by themselves and the standard deviation from log to log,
    what the noise makes of it taken out; `chance` is that of so great differences between logs that
    do not differ, and `differs` says whether they certainly do, and by more than a hundredth.
    """

    unit: str
    mean: Finite
    low: Finite
    high: Finite
    sd: Finite
    sd_low: Finite
    sd_high: Finite
    logs: int
    chance: Finite
    differs: bool


class ConditionCard(_CardEntry):
    """A condition of the estimates that does not hold, with the parameters it biases.

    `parameters` is null where it concerns all; `caps` says whether it takes "identified" away.
    """

    condition: Condition
    sentence: str
    parameters: list[str] | None
    caps: bool


class Card(_CardEntry):
    """An identified friction model, version 1 of the schema.

    `stated` has the constants that the logs state in place of the rig's: least and greatest, in the
    unit that `constants` has them in.
    """

    schema_: Literal["stribeck-card/1"] = Field(default="stribeck-card/1", alias="schema")
    law: str
    rig: str
    kind: str
    axis: dict[str, Any] | None = None
    constants: dict[str, ConstantCard] = {}
    stated: dict[str, Annotated[list[Finite], Field(min_length=2, max_length=2)]] = {}
    columns: dict[str, Any] = {}
    drive: dict[str, Any] | None = None
    parameters: dict[str, ParameterCard]
    combinations: dict[str, CombinationCard] = {}
    breakaway: dict[str, BreakawayCard] = {}
    between_logs: dict[str, LogSpreadCard] = {}
    scope: str = ""
    conditions: list[ConditionCard] = []
    objective: ObjectiveCard
    train: list[str] = []
    speeds: SpeedsCard | None = None
    pace: PaceCard | None = None
    holdout: list[HoldoutCard] = []
    search: SearchCard
    balance: dict[str, Finite] = {}
    posterior: PosteriorCard | None = None
    force_delay_ms: Finite = 0.0
    velocity: Literal["recorded"] | None = None
    data: list[DataCard]
    warnings: list[str] = []
    notes: list[str] = []
    software: dict[str, str]

    def text(self) -> str:
        """The card as JSON, as it stands in a file."""
        optional = {
            "posterior": self.posterior,
            "pace": self.pace,
            "force_delay_ms": self.force_delay_ms or None,
            "velocity": self.velocity,
            "drive": self.drive,
            "axis": self.axis,
            "stated": self.stated or None,
        }
        absent = {name for name, value in optional.items() if value is None}
        data = self.model_dump(by_alias=True, exclude=absent)
        return json.dumps(data, indent=2, ensure_ascii=False) + "\n"

    def write(self, path: str | Path) -> Path:
        """Write the card to a file, which `read_card` reads.

        Raises:
            OSError: it cannot be written.
        """
        file = Path(path)
        file.write_text(self.text(), encoding="utf-8")
        return file

    def __repr__(self) -> str:
        values = ", ".join(f"{n} = {p.value:.5g} {p.unit}" for n, p in self.parameters.items())
        score = f"{self.objective.name} = {self.objective.value:.4g} {self.objective.unit}"
        return f"<Card of {self.law} on {self.rig}: {values}; {score}>"

    def __str__(self) -> str:
        return repr(self)

    def _repr_html_(self) -> str:
        return str(presenter("card_html")(self))

    @property
    def delay(self) -> float:
        """By how much the drive was behind the motion in its logs, s."""
        return 1e-3 * self.force_delay_ms

    def model(self) -> tuple[Parameters, np.ndarray]:
        """The rig, law and parameter set of the card, ready to be simulated.

        Raises:
            InputError: it names a rig, law or parameter that is not there, or its values are
                no friction law.
        """
        shipped, law = self._shipped(), law_named(self.law)
        if self.drive is not None:
            shipped = shipped.driven(DriveChain.of_table(self.drive))
        rig: Rig = replace(
            _with_constants(shipped, self._counting()),
            name=self.rig,
            columns=self.columns or shipped.columns,
        )
        if self.velocity is not None:
            rig = as_balanced(rig).with_velocity(self.velocity)
        every = rig.parameters(law)
        needed = {rig.label(q.name) for q in every if q.fixed is None}
        labels = {rig.label(q.name) for q in every}
        if missing := sorted(needed - set(self.parameters)):
            raise InputError(f"parameter {missing[0]} is missing")
        if strange := sorted(set(self.parameters) - labels):
            raise InputError(
                f"no parameter {strange[0]!r} in law {law.name} on rig {self.kind}: there are "
                f"{', '.join(sorted(labels))}"
            )
        self._check_speeds(rig)
        p = np.array([self._value(rig, q) for q in every])
        if not bool(np.all(law.physical(p[None, : len(law.params)]))):
            raise InputError(
                f"its values make no {law.name} friction: look for F_S below F_C, or a value "
                "that must be above zero"
            )
        values = {q.name: float(shown_in(rig, q, v)) for q, v in zip(every, p, strict=True)}
        # One parameter is left free, so that the parts which need one can be used; it is not
        # searched for.
        last = [q.name for q in every if q.fixed is None][-1]
        absolute = self.objective.name == "position_mae"
        objective = Objective(
            "absolute" if absolute else "squares", self.objective.restart, self.objective.breakaway
        )
        fixed = {n: v for n, v in values.items() if n != last}
        parameters = partition(rig, law, fixed=fixed, objective=objective)
        return parameters, p

    def _counting(self) -> dict[str, ConstantCard]:
        """Its constants; what all logs have stated alike counts in place of the rig's."""
        return {
            name: entry.model_copy(update={"value": self.stated[name][0]})
            if name in self.stated and self.stated[name][0] == self.stated[name][1]
            else entry
            for name, entry in self.constants.items()
        }

    def _shipped(self) -> Rig:
        """The rig that its own is a variant of: a shipped one, or that of its parts."""
        if self.axis is not None:
            try:
                return composed_axis(self.axis, self.rig)
            except ValidationError as error:
                first = error.errors()[0]
                place = ".".join(str(part) for part in first["loc"])
                raise InputError(f"axis.{place}: {first['msg']}") from error
        if self.kind not in RIGS:
            raise InputError(f"no rig {self.kind!r}: there are {', '.join(RIGS)}")
        return RIGS[self.kind]

    def _check_speeds(self, rig: Rig) -> None:
        """Raises InputError where the speeds are none of this rig, or in the wrong order."""
        if self.speeds is None:
            return
        try:
            fits = convertible(self.speeds.unit, "rad/s" if rig.rotary else "m/s")
        except InputError as error:
            raise InputError(f"speeds: {error}") from error
        if not fits:
            raise InputError(f"speeds: {self.speeds.unit!r} is not the unit of a velocity here")
        if not self.speeds.low <= self.speeds.high:
            raise InputError(f"speeds: {self.speeds.low:g} to {self.speeds.high:g} is no range")

    def _value(self, rig: Rig, param: Param) -> float:
        """A parameter's value, SI; what a card leaves out is as its law holds it."""
        entry = self.parameters.get(rig.label(param.name))
        if entry is None:
            return float(param.fixed or 0.0)
        return _si(rig.label(param.name), entry, rig.unit_of(param))


def _with_constants(shipped: Rig, entries: Mapping[str, ConstantCard]) -> Rig:
    """A shipped rig with the constants of a card."""
    for name in entries:
        shipped[name]  # says which there are
    constants = []
    for c in shipped.constants:
        if (entry := entries.get(c.name)) is not None:
            read = _si(c.name, entry, c.unit)
            value = c.value if entry.value == c.shown else read
            tolerance = entry.tolerance * unit(entry.unit).factor
            source = c.source if entry.origin == c.origin else "its card"
            c = replace(  # noqa: PLW2901
                c, value=value, tolerance=tolerance, origin=entry.origin, source=source
            )
        constants.append(c)
    rig = replace(shipped, constants=tuple(constants))
    rig.check({c.name: c.value for c in constants})
    return rig


def constant_cards(rig: Rig) -> dict[str, ConstantCard]:
    """All constants of a rig's axis, and settings of its simulation where they were changed."""
    shipped = {c.name: c.value for c in origin_of(rig).constants}
    return {
        c.name: ConstantCard(
            value=c.shown, unit=c.unit, origin=c.origin, tolerance=c.shown_tolerance
        )
        for c in rig.constants
        if c.origin != "setting" or c.value != shipped[c.name]
    }


def _si(name: str, entry: ParameterCard | ConstantCard, written: str) -> float:
    try:
        fits = convertible(entry.unit, written)
    except InputError as error:
        raise InputError(f"{name}: {error}") from error
    if not fits:
        raise InputError(f"{name}: its unit is {entry.unit!r}, it should be {written!r}")
    value = float(unit(entry.unit).to_si(entry.value))
    if not math.isfinite(value):
        raise InputError(f"{name}: {entry.value:g} {entry.unit} is not a finite number in SI")
    return value


#: The kind of a rig that a user composed of parts.
COMPOSED = "composed"


def origin_of(rig: Rig) -> Rig:
    """The shipped rig that a rig is a variant of, or the rig of its parts alone."""
    table = axis_table(rig)
    return RIGS[kind_of(rig)] if table is None else composed_axis(table, rig.name)


def axis_table(rig: Rig) -> dict[str, Any] | None:
    """What a user composed a rig of; None for a variant of a shipped one."""
    if isinstance(rig, ComposedRig) and rig.table is not None:
        return dict(rig.table)
    return None


def kind_of(rig: Rig) -> str:
    """The name of the shipped rig that a rig is a variant of; "composed" for one of parts."""
    if axis_table(rig) is not None:
        return COMPOSED
    names: list[str] = sorted(RIGS, key=lambda n: n != rig.name)  # its own, so no other is loaded
    for name in names:
        shipped = RIGS[name]
        if type(shipped) is type(rig) and (shipped.params, shipped.shows) == (
            rig.params,
            rig.shows,
        ):
            return name
    raise InputError(f"rig {rig.name} is no variant of a shipped rig: there is no card of it")


class Carded(Protocol):
    """What has a card: a fit."""

    def card(self) -> Card:
        """It."""


def card_of(model: Card | Carded | str | Path) -> Card:
    """The card of a fit, of a file, or itself.

    Raises:
        InputError: no such file, or it is no card.
    """
    if isinstance(model, Card):
        return model
    return read_card(model) if isinstance(model, str | Path) else model.card()


def card_file(path: str | Path) -> Path:
    """The file of a card; that in it where a folder is named which `identify --out` wrote."""
    inside = Path(path) / "card.json"
    return inside if inside.is_file() else Path(path)


def read_card(path: str | Path) -> Card:
    """Read a card from a file.

    Args:
        path: The file, or the folder that `identify --out` wrote.

    Raises:
        InputError: no such file, not a card, a newer schema, or values that cannot be.
    """
    path = card_file(path)
    try:
        data = json_document(page(path))
        json.dumps(data, ensure_ascii=False).encode()
    except InputError as error:
        raise InputError(f"{path}: {error}") from error
    except UnicodeEncodeError as error:  # JSON can say half a character, no other file can
        raise InputError(f"{path}: has half a character in a text: write it anew") from error
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path}: not a card: it is no JSON") from error
    if not isinstance(data, Mapping) or not str(data.get("schema", "")).startswith(
        "stribeck-card/"
    ):
        raise InputError(f"{path}: not a card: it has no schema stribeck-card/1")
    if data["schema"] != "stribeck-card/1":
        raise InputError(
            f"{path}: its schema is {data['schema']!s:.40}, this program reads stribeck-card/1: "
            "write it again with `identify`"
        )
    try:
        return Card.model_validate(data)
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(str(part) for part in first["loc"])
        raise InputError(f"{path}: {where}: {_WORDS.get(first['type'], first['msg'])}") from error
