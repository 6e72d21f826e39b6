"""What the page of a fit shows, as a file: `report.json`, from which the page can be made again."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from ...errors import InputError
from ...identify.card import Card, read_card
from ...text_file import json_document, page

#: Names of the files that a folder has of a fit.
OF_A_FIT = re.compile(
    r"card\.json|report\.(json|html)"
    r"|(convergence|training(_\d+)?|holdout_.+|force(_\d+)?|friction|stribeck_curve|slips|loops)"
    r"\.(png|svg)"
)
#: The file's name in its folder, and the schema that this program writes and reads.
FILE, SCHEMA = "report.json", "stribeck-report/1"
#: Samples of a line, entries of a list, motions and letters of a text at most.
LONGEST, MANY, MOTIONS, LETTERS = 40_000, 4_000, 400, 20_000

Number = Annotated[float, Field(allow_inf_nan=False)]
Series = Annotated[list[Number | None], Field(max_length=LONGEST)]
Text = Annotated[str, Field(max_length=LETTERS)]


class _StrictRecord(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


class StrokeRecord(_StrictRecord):
    """A run in one direction: times in s, travel and mean speed as shown."""

    start: Number
    stop: Number
    direction: Literal[-1, 1]
    travel: Number
    speed: Number


class RestRecord(_StrictRecord):
    """A stay: times in s, the level as shown."""

    start: Number
    stop: Number
    level: Number


class SlipRecord(_StrictRecord):
    """A jump from rest to rest: times in s, levels and greatest speed as shown."""

    start: Number
    stop: Number
    begin: Number
    end: Number
    jump: Number
    speed: Number


class LogRecord(_StrictRecord):
    """A log as it was measured: what `check` says of it, and where it strokes, rests and slips."""

    label: Text
    lines: Annotated[list[tuple[Text, Text]], Field(max_length=MANY)]
    t: Series
    position: Series
    command: Series | None = None
    strokes: Annotated[list[StrokeRecord], Field(max_length=MANY)] = []
    rests: Annotated[list[RestRecord], Field(max_length=MANY)] = []
    slips: Annotated[list[SlipRecord], Field(max_length=MANY)] = []


class MotionRecord(_StrictRecord):
    """A stretch of a log beside the model; a motion, or the force of a force balance.

    `part` is "training", or the range that was held out. All of the first block have one length;
    gaps are null. The residual has times of its own: the samples that count.
    """

    label: Text
    part: Text
    rms: Number | None
    t: Series
    measured: Series
    model: Series
    command: Series | None = None
    velocity: Series | None = None
    force: Series | None = None
    force_model: Series | None = None
    unscored: Annotated[list[tuple[Number, Number]], Field(max_length=MANY)] = []
    residual_t: Series = []
    residual: Series = []
    frequency: Series = []
    density: Series = []
    lag: Series = []
    correlation: Series = []
    counted: int = 0


class SideRecord(_StrictRecord):
    """A law's curve to one side of rest, its 95 % band, and whether data went that way."""

    velocity: Series
    friction: Series
    low: Series | None = None
    high: Series | None = None
    seen: bool = True


class CurveRecord(_StrictRecord):
    """A named line."""

    name: Text
    x: Series
    y: Series


class LawRecord(_StrictRecord):
    """The identified law: its curve, what the data imply, loops of slow strokes, loads."""

    doc: Text
    cite: Text
    formula: Text
    curve: Annotated[list[SideRecord], Field(max_length=2)]
    band: Literal["intervals", "bootstrap"] | None = None
    cloud_velocity: Series = []
    cloud_friction: Series = []
    pace: Number | None = None
    loops: Annotated[list[CurveRecord], Field(max_length=8)] = []
    loads: Annotated[list[CurveRecord], Field(max_length=16)] = []
    load: Text = ""


class ProfileRecord(_StrictRecord):
    """How the fit suffers as a parameter moves, the others refitted: in thresholds, as shown."""

    name: Text
    unit: Text
    value: Number
    low: Number | None
    high: Number | None
    values: Series
    rises: Series


class RunRecord(_StrictRecord):
    """One repeat of a search: its best misfit where that fell, and the parameters it ended at."""

    searched: Number | None
    cost: Number | None
    evaluations: int
    polishing: int
    ended: Text
    seconds: Number
    parameters: dict[Text, Number]
    at: Annotated[list[int], Field(max_length=LONGEST)]
    best: Series


class ErrorRecord(_StrictRecord):
    """The misfit on a log: in training, and on each range held out; null where it was not used."""

    log: Text
    samples: int
    errors: Annotated[list[Number | None], Field(max_length=MANY)]


class SingleLogRecord(_StrictRecord):
    """What a log gives by itself: value and standard error of each parameter as shown.

    Null where the log does not know the parameter.
    """

    log: Text
    values: dict[Text, tuple[Number, Number] | None]


class BinsRecord(_StrictRecord):
    """Mean residual force in equal-count bins of a variable, and half the band of chance, SI."""

    variable: Text
    kind: Literal["force", "friction", "inertia"]
    unit: Text
    at: Series
    mean: Series
    chance: Series
    share: Number
    probability: Number


class EffectRecord(_StrictRecord):
    """A pattern of the residual that chance does not explain, and the parameters it moves.

    `size` is the root mean square of its force, `share` that of the residual's variance.
    """

    text: Text
    share: Number
    size: Number
    probability: Number
    moves: Text


class DrawsRecord(_StrictRecord):
    """The bootstrap behind `resampled` of the card: data sets drawn, failed, length of a block."""

    drawn: int
    failed: int
    block: int


class UnitsRecord(_StrictRecord):
    """In which units numbers are shown."""

    position: Text
    velocity: Text
    force: Text


class Report(_StrictRecord):
    """Everything that the page of a fit shows, version 1 of the schema.

    `unshown` and `hidden` count the logs and the motions that were left out.
    """

    schema_: Literal["stribeck-report/1"] = Field(default="stribeck-report/1", alias="schema")
    card: Card
    road: Literal["simulation", "inverse"]
    rotary: bool
    applied: bool
    about: Text
    equation: Annotated[list[Text], Field(max_length=16)] = []
    units: UnitsRecord
    logs: Annotated[list[LogRecord], Field(max_length=100)]
    unshown: int = 0
    motions: Annotated[list[MotionRecord], Field(max_length=MOTIONS)]
    hidden: int = 0
    law: LawRecord
    profiles: Annotated[list[ProfileRecord], Field(max_length=MANY)]
    runs: Annotated[list[RunRecord], Field(max_length=MANY)]
    errors: Annotated[list[ErrorRecord], Field(max_length=MANY)] = []
    single_logs: Annotated[list[SingleLogRecord], Field(max_length=MANY)] = []
    bins: Annotated[list[BinsRecord], Field(max_length=16)] = []
    effects: Annotated[list[EffectRecord], Field(max_length=16)] = []
    draws: DrawsRecord | None = None
    command: Annotated[list[Text], Field(max_length=MANY)] = []
    software: dict[Text, Text]

    def text(self) -> str:
        """The report as JSON, as it stands in a file."""
        return self.model_dump_json(by_alias=True) + "\n"


_AGAIN = "write it with `identify ... --out DIR`"


def check_report_folder(folder: Path) -> None:
    """Say that a folder is not there.

    Raises:
        InputError: it is not.
    """
    if not folder.is_dir():
        raise InputError(f"{folder}: no such folder: {_AGAIN}")


def read_report(folder: str | Path) -> Report:
    """Read the report in a folder that `identify --out` wrote.

    Raises:
        InputError: no such file, not a report, damaged, of a newer schema, or of another fit than
            the card beside it.
    """
    file = Path(folder) / FILE
    check_report_folder(file.parent)
    report = _read(file)
    beside = file.with_name("card.json")
    if beside.exists() and read_card(beside) != report.card:
        raise InputError(
            f"{folder}: card.json and {FILE} are not of one fit: {_AGAIN}, or take the folder as "
            "it was written"
        )
    return report


def _read(file: Path) -> Report:
    try:
        text = page(file)
    except InputError as error:
        raise InputError(f"{file}: {error}: {_AGAIN}") from error
    try:
        data = json_document(text)
    except InputError as error:
        raise InputError(f"{file}: {error}: {_AGAIN}") from error
    except (ValueError, RecursionError) as error:
        raise InputError(f"{file}: is damaged, it is no JSON: {_AGAIN}") from error
    schema = data.get("schema") if isinstance(data, dict) else None
    if not str(schema or "").startswith("stribeck-report/"):
        raise InputError(f"{file}: not a report: it has no schema {SCHEMA}")
    if schema != SCHEMA:
        raise InputError(
            f"{file}: its schema is {schema!s:.40}, this program reads {SCHEMA}: take a newer "
            f"stribeck, or {_AGAIN}"
        )
    try:
        return Report.model_validate_json(text)
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(str(part) for part in first["loc"])
        raise InputError(f"{file}: is damaged at {where}: {first['msg']}: {_AGAIN}") from error
