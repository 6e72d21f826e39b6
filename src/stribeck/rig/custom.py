"""Rigs of the user's: a small TOML file over a shipped kind, or an axis of parts."""

from __future__ import annotations

import tomllib
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from ..constant import Origin, toleranced
from ..data.readers.column_map import mapping
from ..drive import DriveChain
from ..errors import InputError
from ..friction import law_named
from ..text_file import page
from . import RIGS
from .axis_table import ROLES, Finite, composed_axis
from .rig import Rig
from .search_ranges import with_ranges

if TYPE_CHECKING:
    from pathlib import Path

#: Refusals in words that fit a rig file, in place of the checker's own.
_WORDS = {
    "extra_forbidden": "a rig file has no such word: a variant of a shipped rig has kind, name, "
    "doc, law, constants, ranges, columns and drive; an axis of parts name, doc, law, rotary, "
    "controller, motor, transmission, load, sensor, friction, inputs, ranges, shows, columns, "
    "drive, step and tolerance",
    "missing": "is missing",
    "finite_number": "must be a finite number",
    "float_type": "must be a number",
    "too_short": "must be a pair [low, high]",
    "too_long": "must be a pair [low, high]",
    "tuple_type": "must be a pair [low, high]",
    "string_type": "must be text in quotes",
    "dict_type": "must be a table such as { name = value }",
}

#: How deep a coefficient stands, and what it may be.
_COEFFICIENT = 3
_STATED = (
    'must be a finite number, text as "12±4", { free = [low, high] } or '
    '{ column = "HEAD", value = 1.0 }'
)


class _RigFile(BaseModel):
    """The schema of a rig file; numbers are in the units that the kind shows."""

    model_config = ConfigDict(extra="forbid")

    kind: str
    name: str | None = None
    doc: str | None = None
    law: str | None = None
    constants: dict[str, Finite | Annotated[str, Field(strict=True)]] = {}
    ranges: dict[str, tuple[Finite, Finite]] = {}
    columns: dict[str, Any] = {}
    drive: dict[str, Any] | None = None


def rig_file(path: Path) -> Rig:
    """Read a rig from a TOML file: an axis of parts, or `kind` and what differs from that rig.

    ```toml
    kind = "slide-bed"
    law = "stribeck"
    # in the units that `stribeck rigs slide-bed` shows:
    constants = { m = 24.0, F_fm = "12±4", J_m = "4e-6 nameplate" }
    ranges = { F_S = [20, 90], F_C = [5, 60] }
    columns = { position = "actual [mm]", command = "setpoint [mm]" }
    ```

    A `[drive]` table says how the drive's signal becomes the force at the axis; see `DriveChain`.

    Raises:
        InputError: no such file, broken TOML, or a word or number that the kind does not know.
    """
    try:
        data = tomllib.loads(page(path))
    except InputError as error:
        raise InputError(f"{path}: {error}") from error
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path}: not TOML: {error}") from error
    return rig_of_table(data, path)


def rig_of_table(data: dict[str, Any], path: Path) -> Rig:
    """The rig that the content of a rig file states.

    Args:
        data: The content.
        path: The file, for its name and for messages.

    Raises:
        InputError: as `rig_file`.
    """
    try:
        if "kind" not in data:
            return _of_parts(data, path.stem)
        content = _RigFile.model_validate(data)
        return _rig(content, path.stem if content.name is None else content.name)
    except ValidationError as error:
        first = error.errors()[0]
        if first["loc"][0] in ROLES and len(first["loc"]) > _COEFFICIENT:
            # One of several kinds of value: the checker tells what each of them lacks.
            place = ".".join(str(part) for part in first["loc"][:_COEFFICIENT])
            raise InputError(f"{path}: {place}: {_STATED}") from error
        place = ".".join(str(part) for part in first["loc"])
        pair = len(first["loc"]) > 1 and first["type"] == "missing"
        problem = _WORDS.get("too_short" if pair else first["type"], first["msg"])
        raise InputError(f"{path}: {place}: {problem}") from error
    except InputError as error:
        raise InputError(f"{path}: {error}") from error


def _of_parts(data: dict[str, Any], name: str) -> Rig:
    """An axis composed of parts."""
    if not any(role in data for role in ("controller", "motor", "transmission", "load")):
        raise InputError(
            "kind: is missing: name the shipped rig that this one is a variant of, as in kind = "
            '"joint", or compose an axis of parts: it begins with a [load.mass] or [load.inertia]'
        )
    rig = composed_axis(data, name)
    _check_name(rig.name)
    if not rig.doc.isprintable():
        raise InputError("doc: give a line of printable characters")
    mapping(dict(rig.columns))  # says which channels there are
    chain = data.get("drive")
    return rig if chain is None else rig.driven(DriveChain.of_table(chain))


def _check_name(name: str) -> None:
    if name in RIGS:
        raise InputError(f"name {name!r} is that of a shipped rig: choose another")
    if not name.strip() or not name.isprintable():
        raise InputError(f"name {name!r}: give a name of printable characters")


def _rig(content: _RigFile, name: str) -> Rig:
    if content.kind not in RIGS:
        raise InputError(f"no kind {content.kind!r}: there are {', '.join(RIGS)}")
    kind = RIGS[content.kind]
    if name != content.kind:
        _check_name(name)
    mapping(content.columns)  # says which channels there are
    laws = kind.laws
    if content.law is not None:
        law_named(content.law)  # says which laws there are
        laws = (content.law, *(law for law in kind.laws if law != content.law))
    chain = None if content.drive is None else DriveChain.of_table(content.drive)
    rig = kind.set(
        **{
            n: _toleranced(n, value) if isinstance(value, str) else value
            for n, value in content.constants.items()
        }
    )
    if content.doc is not None and not content.doc.isprintable():
        raise InputError("doc: give a line of printable characters")
    custom = replace(
        with_ranges(rig, content.ranges, laws),
        name=name,
        doc=content.doc or rig.doc,
        laws=laws,
        columns={**rig.columns, **content.columns},
    )
    return custom if chain is None else custom.driven(chain)


def _toleranced(name: str, text: str) -> tuple[float, float, Origin]:
    """A constant's value and tolerance from text; a number alone is no text in TOML."""
    stated = toleranced(text, f"constants.{name}")
    if not stated[1] > 0:
        raise InputError(f"constants.{name}: {text!r} is a number in quotes, or has no tolerance")
    return stated
