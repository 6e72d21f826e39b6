"""A co-simulation unit (FMI 2.0) of axis and friction, compiled for this platform, with sources.

The axis is stepped by the functions of `rig.motion` that step it here, translated into C
(`unit_one_mass`, `unit_two_masses`); by hand are the functions of FMI and what they call of an
axis. FMI 2.0, since every tool that loads units loads those.
"""

from __future__ import annotations

import hashlib
import io
import os
import re
import shutil
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Mapping
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

from ..._version import __version__
from ...draft import Draft, settle
from ...errors import InputError
from ...rig.motion.drives import ENABLED, INPUTS
from ...rig.motion.implicit import MOST_STEPS
from ..model import Model
from .axis import Axis, axis
from .description import described, page
from .symbol import Symbol, c_text
from .unit_motion import UnitMotion
from .unit_one_mass import one_mass_motion
from .unit_two_masses import two_mass_motion

#: The C that is the same for every axis, and what of it is compiled.
_OWN = ("axis.h", "axis.c", "fmi2.h", "fmi2.c")
_COMPILED = ["axis.c", "fmi2.c"]
#: Folder and ending of a binary, by the platform.
_PLATFORMS = {
    "linux": ("linux64", "so"),
    "darwin": ("darwin64", "dylib"),
    "win32": ("win64", "dll"),
}
#: A compiler that needs longer than that, s, is stuck.
_PATIENCE = 120.0
#: The only time of day that a file in the archive has, so that equal models make equal bytes.
_EPOCH = (1980, 1, 1, 0, 0, 0)


def fmu(model: Model, name: str = "friction", *, binary: bool = True) -> bytes:
    """The unit: a zip archive, the same bytes for the same model and compiler.

    Args:
        model: What was identified.
        name: The model identifier.
        binary: Whether to compile for this platform; else the sources alone go out.

    Raises:
        InputError: a name that C does not take, a law or rig that cannot be translated, or a
            compiler that is not there or fails.
    """
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]{0,40}", name):
        raise InputError(
            f"name {name!r}: a unit takes letters, digits and _, beginning with a letter, up to 41"
        )
    fmu_axis = axis(model)
    sources = _sources(model, fmu_axis)
    digest = hashlib.sha256(b"\0".join(sources[n] for n in sorted(sources)))
    digest.update(f"{name}\0{model.sha256}\0{__version__}".encode())
    guid = f"{{{digest.hexdigest()[:32]}}}"
    sources["axis_model.h"] += f'#define AXIS_GUID "{guid}"\n'.encode()
    files = {
        "modelDescription.xml": described(model, fmu_axis, name, guid, _COMPILED),
        "documentation/index.html": page(model, fmu_axis, name).encode(),
        "documentation/licenses/license.txt": _licence().encode(),
        "resources/card.json": model.card.text().encode(),
        **{f"sources/{n}": text for n, text in sources.items()},
    }
    if binary:
        folder, ending = _platform()
        files[f"binaries/{folder}/{name}.{ending}"] = _built(sources, f"{name}.{ending}")
    return _zipped(files)


def _sources(model: Model, fmu_axis: Axis) -> dict[str, bytes]:
    """Names and contents of the C files, without the unit's GUID."""
    folder = Path(__file__).parent / "fmu_c"
    motion = (
        one_mass_motion(model.law, fmu_axis.drive, fmu_axis.row)
        if fmu_axis.sides is None
        else two_mass_motion(*fmu_axis.sides, fmu_axis.parameters, fmu_axis.row)
    )
    return {
        **{n: (folder / n).read_bytes() for n in _OWN},
        "axis_model.h": _values(fmu_axis, motion).encode(),
        "axis_motion.h": motion.source.encode(),
    }


def _values(fmu_axis: Axis, motion: UnitMotion) -> str:
    """Where the values of this axis stand, and how they start, as a header."""
    inputs = fmu_axis.of("input")
    setting = fmu_axis.first("setting")
    law = fmu_axis.first("law")
    held = {v.place for v in inputs if v.fixed}
    defined: dict[str, object] = {
        "AXIS_MEMORY": motion.memory,
        "AXIS_MODES": motion.modes,
        "AXIS_ROOM": motion.room,
        "AXIS_MOST_STEPS": MOST_STEPS,
        "AXIS_VALUES": len(fmu_axis.values),
        "AXIS_FIRST_INPUT": fmu_axis.first("input"),
        "AXIS_INPUTS": len(inputs),
        "AXIS_PLACES": f"{{{', '.join(str(v.place) for v in inputs)}}}",
        "AXIS_HELD": f"{{{', '.join(str(float(i in held)) for i in range(INPUTS))}}}",
        "AXIS_PLACES_OF_INPUTS": INPUTS,
        "AXIS_ENABLED": ENABLED,
        "AXIS_WIDTH": len(fmu_axis.row),
        "AXIS_POSITION": fmu_axis.first("output"),
        "AXIS_POSITION_START": setting,
        "AXIS_VELOCITY_START": setting + 1,
        "AXIS_STEP": setting + 2,
        "AXIS_TOLERANCE": setting + 3,
        "AXIS_LAW": law,
    }
    defined |= {f"R_{value.symbol}": i for i, value in enumerate(fmu_axis.values) if value.symbol}
    symbols = {i: x for i, x in enumerate(fmu_axis.row) if isinstance(x, Symbol | float | int)}
    constants = " ".join(f"c[{i}] = {c_text(x)};" for i, x in symbols.items())
    defined["AXIS_CONSTANTS_FROM(r)"] = constants
    starts = ", ".join(c_text(v.start or 0.0) for v in fmu_axis.values)
    return "\n".join(
        [
            "/* This axis: where its values stand. */",
            *(f"#define {name} {value}" for name, value in defined.items()),
            f"#define AXIS_START_VALUES {{{starts}}}",
            "",
        ]
    )


def _platform() -> tuple[str, str]:
    platform = _PLATFORMS.get(sys.platform)
    if platform is None or sys.maxsize < 2**32:
        raise InputError(f"fmu: FMI 2.0 has no name for the platform {sys.platform}")
    return platform


def _built(sources: Mapping[str, bytes], target: str) -> bytes:
    """The sources compiled for this platform."""
    compiler = next(filter(None, map(shutil.which, ("cc", "gcc", "clang"))), None)
    if compiler is None:
        raise InputError("fmu: there is no C compiler (cc, gcc or clang) on the path: install one")
    above = Path(tempfile.gettempdir())
    settle(above)
    draft = Draft(above)
    try:
        return _compiled(compiler, draft.files, sources, target)
    finally:
        draft.discard()


def _compiled(compiler: str, folder: Path, sources: Mapping[str, bytes], target: str) -> bytes:
    """The sources compiled in an empty folder."""
    for name, text in sources.items():
        (folder / name).write_bytes(text)
    command = [
        compiler, "-std=c99", "-O2", "-fPIC", "-shared", "-fvisibility=hidden",
        *_COMPILED, "-lm", "-o", target,
    ]  # fmt: skip
    try:
        done = subprocess.run(  # noqa: S603 - found on the path, no shell
            command, cwd=folder, capture_output=True, timeout=_PATIENCE, check=False,
            env=os.environ | {"TMPDIR": str(folder)},  # a killed compiler leaves files there
        )  # fmt: skip
    except (OSError, subprocess.TimeoutExpired) as error:
        raise InputError(f"fmu: {compiler} did not run: {error}") from error
    if done.returncode:
        errors = done.stderr.decode(errors="replace").strip().splitlines() or ["it said nothing"]
        raise InputError(f"fmu: {compiler} failed: {errors[0]:.200}")
    return (folder / target).read_bytes()


def _licence() -> str:
    """What the sources in a unit may be used for."""
    try:
        text = distribution("stribeck").read_text("licenses/LICENSE")
    except PackageNotFoundError:
        text = None
    head = f"The C sources of this unit were made by stribeck {__version__}, BSD-3-Clause.\n"
    return f"{head}\n{text}" if text else head


def _zipped(files: Mapping[str, bytes]) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in sorted(files):
            entry = zipfile.ZipInfo(name, _EPOCH)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.create_system = 3  # permissions as Unix has them, wherever it is made
            entry.external_attr = (0o755 if name.startswith("binaries/") else 0o644) << 16
            archive.writestr(entry, files[name])
    return buffer.getvalue()
