"""The table of export targets that the command line, the documentation and the tests use."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

from ..compensate.compensator import SETTINGS, Compensator
from ..compensate.settings import read_settings
from ..errors import InputError
from ..identify.card import Card, Carded
from ..presenters import presenter
from ..text_file import page_bytes
from ..units import percent, unit
from ..wording import either, option
from .model import Model, model_of

#: Targets that move a joint.
_ONE_MASS = ("mjcf", "urdf", "usd")
#: Targets that have all of an axis.
_WHOLE = ("fmu", "json")


class Exported(NamedTuple):
    """The files of a target.

    Args:
        files: Their contents by name; a single one may be named otherwise by who writes it.
        notes: What is lost on the way, and by how much, a sentence each.
        folder: Whether the files belong into a folder, and are not a single one.
        suffix: Of a single file.
    """

    files: dict[str, bytes]
    notes: tuple[str, ...] = ()
    folder: bool = False
    suffix: str = ""

    def __repr__(self) -> str:
        sizes = (f"{name}, {len(content):,} bytes" for name, content in self.files.items())
        return f"<{'; '.join(sizes)}; write(PATH) puts them there>"

    def write(self, out: str | Path) -> list[Path]:
        """Write the files, all or none, and return their paths.

        Args:
            out: A file, where the target is one, to which its extension is added if it has none;
                elsewhere a folder.

        Raises:
            InputError: they cannot be written there.
        """
        written: list[Path] = presenter("files")(
            self.files, out, folder=self.folder, suffix=self.suffix
        )
        return written


@dataclass(frozen=True)
class ExportTarget:
    """An export target: what it makes of a model, and the options it takes.

    Args:
        name: As `--to` takes it.
        doc: What comes out, in a line.
        make: Makes it of a model and the options given.
        options: The options that it takes.
        needed: Those that it cannot do without.
        folder: Whether several files come out.
        text: Whether a single file is text that may go to a terminal.
        suffix: Of a single file.
    """

    name: str
    doc: str
    make: Callable[..., Exported]
    options: tuple[str, ...] = ()
    needed: tuple[str, ...] = ()
    folder: bool = False
    text: bool = True
    suffix: str = ""


def export(
    model: Model | Card | Carded | str | Path,
    to: str,
    *,
    name: str | None = None,
    settings: Mapping[str, float] | None = None,
    compensation: Compensator | str | Path | None = None,
    points: int | None = None,
    speed: float | None = None,
    into: str | Path | None = None,
    joint: str | None = None,
) -> Exported:
    """An identified model for a controller, a drive or a simulator.

    Args:
        model: A fit, its card, or the file of one.
        to: A name in `TARGETS`: c, st, plcopen, table, mjcf, urdf, usd, fmu, modelica, matlab,
            json.
        name: What functions and files are called.
        settings: Of the compensator, by name, as in `{"scale": 0.9}`; of mjcf: lugre, firm,
            armature; of usd: metres, kilograms (a unit of the stage).
        compensation: The compensator that the settings start from, such as that of a
            `Compensation`, or the compensation.json that `compensate --out` left.
        points: Of a table, 20 by default.
        speed: Last speed of a table, in the unit that the rig shows.
        into: Your MJCF or URDF file or USD stage, which stays as it is.
        joint: The joint of it to patch; of usd without `into`, the path of its prim.

    Returns:
        The files; `write` puts them somewhere.

    Raises:
        InputError: no such target, an option that it has no use for or lacks, or a model that it
            cannot say.
    """
    target = TARGETS.get(to)
    if target is None:
        raise InputError(f"no target {to!r}: there are {', '.join(TARGETS)}")
    options = {
        "name": name, "settings": settings, "compensation": compensation, "points": points,
        "speed": speed, "into": into, "joint": joint,
    }  # fmt: skip
    known: dict[str, Any] = {o: value for o, value in options.items() if value is not None}
    for keyword in known:
        if keyword not in target.options:
            takes = ", ".join(map(_typed, target.options)) or "no options"
            raise InputError(f"{_typed(keyword)} means nothing to {to}: it takes {takes}")
    for keyword in target.needed:
        if keyword not in known:
            raise InputError(f"{to}: give {_typed(keyword)}: {target.doc}")
    if isinstance(compensation, str | Path):
        known["compensation"] = read_settings(compensation)
    if into is not None:
        known["into"] = Path(into)
    ready = model_of(model)
    notes = _of_one_side(ready, to)
    exported = target.make(ready, **known)
    return exported._replace(
        folder=target.folder, suffix=target.suffix, notes=(*notes, *exported.notes)
    )


def _of_one_side(model: Model, to: str) -> tuple[str, ...]:
    """What is lost of an axis of two masses.

    Raises:
        InputError: the target moves a joint, which has one mass.
    """
    if model.side and to in _ONE_MASS:
        raise InputError(
            f"{to}: a joint there has one mass and no play, and rig {model.rig.name} has two "
            "masses: it goes to fmu whole, its law alone to c, st, matlab, modelica or a table"
        )
    return () if not model.side or to in _WHOLE else (model.side,)


def _typed(keyword: str) -> str:
    """An argument of `export` as a message names it."""
    return either("--set", keyword) if keyword == "settings" else option(keyword)


def compensator(
    model: Model,
    settings: Mapping[str, float] | None = None,
    compensation: Compensator | None = None,
) -> Compensator:
    """A compensator of settings in the units in which the model's rig shows speeds.

    Args:
        model: Whose friction it compensates.
        settings: Values that differ from those of `compensation`, by name.
        compensation: Where they start from: `read_settings` reads what `compensate` recommended. By
            default a feed-forward from the reference's velocity, at full scale, which also
            overcomes the friction of the rig's drive.

    Raises:
        InputError: no such setting, or a value that it cannot have.
    """
    known = {s.name: s for s in SETTINGS}
    values: dict[str, Any] = {}
    for name, value in (settings or {}).items():
        if name not in known:
            raise InputError(f"no setting {name!r}: there are {', '.join(known)}")
        if name == "feedback" and value not in (0.0, 1.0):
            raise InputError(f"feedback is 0 or 1, got {value:g}")
        speed = known[name].unit == "m/s"
        shown = model.rig.shows.get("velocity", model.speed_unit) if speed else ""
        values[name] = bool(value) if name == "feedback" else float(unit(shown).to_si(value))
    if compensation is None:
        compensation = Compensator(feedback=False, drive=model.rig.drive_friction())
    return replace(compensation, **values)


def _language(
    language: str, name: str, doc: str, *, folder: bool = False, suffix: str = ""
) -> ExportTarget:
    """A programming language: the function of its name in the file `code/` has of it.

    Args:
        language: The target, the file and its function, which makes files of a model, a name and
            a compensator.
        name: Of what is exported, unless another is given.
        doc: As of ExportTarget; `folder` and `suffix` likewise.
        folder: Whether several files come out.
        suffix: Of a single file.
    """

    def make(model: Model, name: str = name, **given: Any) -> Exported:
        files = getattr(import_module(f"{__package__}.code.{language}"), language)
        return Exported(files(model, name, compensator(model, **given)))

    return ExportTarget(
        language, doc, make, ("name", "settings", "compensation"), folder=folder, suffix=suffix
    )


def _table(model: Model, points: int | None = None, speed: float | None = None) -> Exported:
    from .drive_table import POINTS, table, text  # noqa: PLC0415 - the same

    shown = model.rig.shows.get("velocity", model.speed_unit)
    far = None if speed is None else float(unit(shown).to_si(speed))
    drive_table = table(model, POINTS if points is None else points, far)
    worst = max(drive_table.plus.worst, drive_table.minus.worst)
    note = (
        f"the table is off by at most {worst:.3g} {model.force_unit}, "
        f"{percent(worst / drive_table.largest)} of the largest friction"
    )
    return Exported({"friction.csv": text(model, drive_table).encode()}, (note,))


#: What may be asked of an MJCF file beside a level and a damping.
_MJCF = ("lugre", "firm", "armature")


def _mjcf(
    model: Model, into: Path, joint: str, settings: Mapping[str, float] | None = None
) -> Exported:
    from .robot.mjcf import mjcf  # noqa: PLC0415 - the same

    chosen: dict[str, Any] = {}
    for name, value in (settings or {}).items():
        if name not in _MJCF:
            raise InputError(f"no setting {name!r}: there are {', '.join(_MJCF)}")
        if value not in (0.0, 1.0):
            raise InputError(f"{name} is 0 or 1, got {value:g}")
        chosen[name] = bool(value)
    return _patched(partial(mjcf, **chosen), model, into, joint)


def _urdf(model: Model, into: Path, joint: str) -> Exported:
    from .robot.urdf import urdf  # noqa: PLC0415 - the same

    return _patched(urdf, model, into, joint)


def _patched(
    patch: Callable[[Model, bytes, str], tuple[bytes, list[str]]],
    model: Model,
    into: Path,
    joint: str,
) -> Exported:
    model.rig.check_newtons("the model of a robot")
    with _naming(into):
        patched, notes = patch(model, page_bytes(into), joint)
    return Exported({str(into): patched}, tuple(notes))


def _usd(
    model: Model, joint: str, into: Path | None = None, settings: Mapping[str, float] | None = None
) -> Exported:
    from .robot.usd import usd  # noqa: PLC0415 - the same
    from .robot.usd_stage import StageUnits  # noqa: PLC0415 - the same

    model.rig.check_newtons("the model of a robot")
    for name, value in (settings or {}).items():
        if name not in StageUnits._fields:
            raise InputError(f"no setting {name!r}: there are {', '.join(StageUnits._fields)}")
        if not 0 < value < math.inf:
            raise InputError(f"{name} is above 0, got {value:g}")
    units = StageUnits(**settings) if settings else None
    with _naming(into):
        layer, notes = usd(model, joint, into, units)
    return Exported({"friction.usda": layer}, tuple(notes))


@contextmanager
def _naming(file: Path | None) -> Iterator[None]:
    """Refusals of what is done to a file begin with its name."""
    try:
        yield
    except InputError as error:
        raise InputError(f"{file}: {error}" if file else str(error)) from error


def _fmu(model: Model, name: str = "friction") -> Exported:
    model.rig.check_newtons("a functional mock-up unit")
    from .fmu.build import fmu  # noqa: PLC0415 - the same

    return Exported({f"{name}.fmu": fmu(model, name)})


def _json(model: Model) -> Exported:
    return Exported({"card.json": model.card.text().encode()})


_PATCH = ("into", "joint")
TARGETS: Mapping[str, ExportTarget] = {
    target.name: target
    for target in (
        _language(
            "c", "friction", "C99: a header, a source with a compensator, and a self-test",
            folder=True,
        ),
        _language(
            "st", "Friction", "IEC 61131-3 Structured Text: function blocks of law and compensator",
            suffix=".st",
        ),
        _language("plcopen", "Friction", "the same blocks as PLCopen TC6 XML", suffix=".xml"),
        ExportTarget(
            "table", "a look-up table for a drive, its points placed for the least error", _table,
            ("points", "speed"), suffix=".csv",
        ),
        ExportTarget(
            "mjcf", "your MuJoCo model, one joint of it patched", _mjcf, (*_PATCH, "settings"),
            _PATCH, suffix=".xml",
        ),
        ExportTarget(
            "urdf", "your robot description, one joint of it patched", _urdf, _PATCH, _PATCH,
            suffix=".urdf",
        ),
        ExportTarget(
            "usd", "a USD layer over a joint of your stage, for PhysX and Newton", _usd,
            (*_PATCH, "settings"), ("joint",), suffix=".usda",
        ),
        ExportTarget(
            "fmu", "a co-simulation unit of axis and friction, compiled for this platform", _fmu,
            ("name",), text=False, suffix=".fmu",
        ),
        _language("modelica", "Friction", "a Modelica package", suffix=".mo"),
        _language(
            "matlab", "friction", "MATLAB (and Octave) functions of law and compensator",
            folder=True,
        ),
        ExportTarget("json", "the card, checked and written anew", _json, suffix=".json"),
    )
}  # fmt: skip
