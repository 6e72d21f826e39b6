"""A fit on its way out: every export with its options, what it loses, and the files to keep."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..errors import InputError
from ..export import TARGETS, Exported, export
from ..units import number

#: Letters of a text that the page shows.
SHOWN = 200_000
#: Time stamp of the files in an archive: the same files make the same bytes.
_LONG_AGO = (1980, 1, 1, 0, 0, 0)
#: Options of targets that are given as they are typed.
_OPTIONS = ("name", "points", "speed", "joint")


@dataclass(frozen=True)
class Download:
    """What a target made, and the command that makes it.

    Args:
        target: Its name.
        exported: Its files.
        name: Of a single file, without its extension.
    """

    target: str
    exported: Exported
    name: str

    def shown(self) -> dict[str, Any]:
        """For the page: notes, and the text of each file that is one."""
        files = {}
        for name, data in self.exported.files.items():
            try:
                files[name] = data.decode()[:SHOWN]
            except UnicodeDecodeError:
                files[name] = ""
        sizes = {name: len(data) for name, data in self.exported.files.items()}
        return {"files": files, "sizes": sizes, "notes": list(self.exported.notes),
                "download": self._file()}  # fmt: skip

    def download(self) -> tuple[bytes, str, str]:
        """Bytes, name and kind of the file to keep: several files are one archive."""
        if not self.exported.folder:
            (data,) = self.exported.files.values()
            return data, self._file(), "application/octet-stream"
        packed = io.BytesIO()
        with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
            for name, data in self.exported.files.items():
                archive.writestr(zipfile.ZipInfo(name, _LONG_AGO), data)
        return packed.getvalue(), self._file(), "application/zip"

    def _file(self) -> str:
        return f"{self.name}{'.zip' if self.exported.folder else self.exported.suffix}"


def targets() -> list[dict[str, Any]]:
    """The targets and their options."""
    return [
        {"name": t.name, "doc": t.doc, "options": list(t.options), "needed": list(t.needed),
         "folder": t.folder}
        for t in TARGETS.values()
    ]  # fmt: skip


def exported(card: Path, options: Mapping[str, str], files: Mapping[str, Path]) -> Download:
    """Export a card.

    Args:
        card: Its file.
        options: `to`, those of the target as typed, and `set` with settings as `scale=0.9`.
        files: The files that the home knows, one of which `into` may name.

    Raises:
        InputError: as `export`.
    """
    to = options.get("to", "")
    stated: dict[str, Any] = {n: options[n] for n in _OPTIONS if options.get(n)}
    if "points" in stated:
        stated["points"] = int(number(stated["points"], "points"))
    if "speed" in stated:
        stated["speed"] = number(stated["speed"], "speed")
    if (into := options.get("into")) is not None and into in files:
        stated["into"] = files[into]
    if settings := _settings(options.get("set", "")):
        stated["settings"] = settings
    name = "".join(c if c.isalnum() else "_" for c in options.get("name") or f"friction_{to}")
    return Download(to, export(card, to, **stated), name)


def _settings(text: str) -> dict[str, float]:
    settings = {}
    for part in text.replace(";", ",").split(","):
        if not part.strip():
            continue
        name, equals, value = part.partition("=")
        if not equals:
            raise InputError(f"settings: {part.strip()!r}: write NAME=VALUE, as in scale=0.9")
        settings[name.strip()] = number(value.strip(), name.strip())
    return settings
