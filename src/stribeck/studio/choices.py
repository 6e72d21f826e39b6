"""What a person has chosen in a session: the document that every step reads and changes."""

from __future__ import annotations

import json
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationError

from ..errors import InputError
from ..identify.loss import Breakaway, Loss

#: Letters of a text, and entries of a list, at most.
LETTERS, MANY = 400, 400

#: The same of a description of an axis as JSON, and tables within tables in it.
AXIS_LETTERS, DEEP = 20_000, 6
#: The name of a session's own axis among the rigs, and of its file beside the logs.
AXIS = "axis.toml"


def _bounded(axis: dict[str, Any]) -> dict[str, Any]:
    """A description of an axis that is no longer and no deeper than one is."""
    level: list[Any] = [axis]
    for _ in range(DEEP):
        level = [v for x in level for v in (x.values() if isinstance(x, dict) else x)
                 if isinstance(v, dict | list)]  # fmt: skip
    if level or len(json.dumps(axis)) > AXIS_LETTERS:
        raise ValueError("is too long, or nested too deeply, for an axis")
    return axis


Text = Annotated[str, Field(max_length=LETTERS)]
Name = Annotated[str, Field(max_length=LETTERS, min_length=1)]
Axis = Annotated[dict[str, Any], AfterValidator(_bounded)]


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


class LogChoice(_Strict):
    """A log of the session.

    Args:
        id: By which the home knows the file.
        window: The part that is read, as in `10s:40s`; empty for all of it.
    """

    id: Annotated[str, Field(pattern=r"^[0-9a-f]{16}$")]
    window: Text = ""


class Choices(_Strict):
    """All choices of a session; what is empty or None is left to the defaults.

    Args:
        logs: The logs, in order.
        columns: Channel -> column, with its unit if its head does not say it, as `read` takes it.
        joint: Whose columns are taken, where logs have several joints.
        rate: Of logs without times, Hz.
        time_unit: Of times whose unit a format leaves open.
        stamp: Which time of a message counts.
        episode: Which of several logs in a file is read.
        subtract: The column of a known force.
        drive: The chain from what the drive recorded to the force, as a `[drive]` table has it.
        rig: Name of the rig; `axis.toml` for the axis below.
        axis: An axis of its own, as a rig file has it: of parts, or a variant of a shipped rig.
        constants: Constants that are this axis's, as typed: `20±5`.
        exact: Whether the other constants are exact.
        law: Name of the law; the rig's first where empty.
        directional: Whether each direction has parameters of its own.
        fixed: Parameters to hold, as typed.
        bounds: Search ranges, as typed: `1:40`.
        train: Ranges to train on.
        holdout: Ranges to validate on.
        method: Search method.
        seed: Its seed.
        repeats: Its independent searches.
        budget: Its evaluations at most.
        loss: What of the errors counts.
        breakaway: One breakaway, or each slip's own.
        velocity: Of a force balance, where it comes from.
        delay: As typed: `auto`, `off`, or milliseconds.
        laws: Laws that `select` compares; those of the rig where empty.
        folds: Parts that `select` holds out in turn.
        target: The format of an export.
    """

    logs: Annotated[tuple[LogChoice, ...], Field(max_length=MANY)] = ()
    columns: Annotated[dict[Name, Name], Field(max_length=16)] = {}
    joint: Text = ""
    rate: Annotated[float, Field(gt=0, le=1e9, allow_inf_nan=False)] | None = None
    time_unit: Text = ""
    stamp: Text = ""
    episode: Text = ""
    subtract: Text = ""
    drive: Annotated[dict[Name, Name | bool], Field(max_length=40)] = {}
    rig: Text = ""
    axis: Axis = {}
    constants: Annotated[dict[Name, Name], Field(max_length=100)] = {}
    exact: bool = False
    law: Text = ""
    directional: bool = False
    fixed: Annotated[dict[Name, Name], Field(max_length=100)] = {}
    bounds: Annotated[dict[Name, Name], Field(max_length=100)] = {}
    train: Annotated[tuple[Name, ...], Field(max_length=100)] = ()
    holdout: Annotated[tuple[Name, ...], Field(max_length=100)] = ()
    method: Text = ""
    seed: Annotated[int, Field(ge=0, le=2**63)] | None = None
    repeats: Annotated[int, Field(ge=1, le=1000)] | None = None
    budget: Annotated[int, Field(ge=1, le=10**9)] | None = None
    loss: Loss = "squares"
    breakaway: Breakaway = "auto"
    velocity: Literal["auto", "recorded", "position"] = "auto"
    delay: Text = "auto"
    laws: Annotated[tuple[Name, ...], Field(max_length=40)] = ()
    folds: Annotated[int, Field(ge=2, le=100)] | None = None
    target: Text = ""

    def changed(self, changes: dict[str, Any]) -> Choices:
        """The same with some choices replaced.

        Raises:
            InputError: there is no such choice, or it cannot have that value.
        """
        return choices_from({**self.model_dump(mode="json"), **changes})

    def same_fit(self, other: Choices) -> bool:
        """Whether another session's choices would make the same fit."""
        return self.model_copy(update=_ASIDE) == other.model_copy(update=_ASIDE)


def choices_from(document: object) -> Choices:
    """The choices that a JSON document states.

    Raises:
        InputError: it states something else.
    """
    try:
        return Choices.model_validate_json(_json(document))
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join(str(part) for part in first["loc"]) or "the choices"
        raise InputError(f"{place}: {first['msg']}") from error


def _json(document: object) -> str:
    try:
        return json.dumps(document, allow_nan=False)
    except (TypeError, ValueError) as error:
        raise InputError(f"the choices: {error}") from error


#: Choices that no fit depends on.
_ASIDE: dict[str, Any] = {"laws": (), "folds": None, "target": ""}
#: What a worker can be asked to do.
Kind = Literal["estimate", "identify", "select", "plan", "compensate"]
