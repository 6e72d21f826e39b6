"""Recordings to try things on, for the terminal: where they are, and whether a file is one."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from ..data.published import SAMPLE, published, published_named, sample
from ..errors import InputError
from .folder import check_file, write_text
from .table import Table
from .terminal import console, show_table

_SAMPLE = "the paper's test bed, simulated with its sensors: 122 s at 50 Hz, both directions"
_COMMAND = (
    "stribeck identify {} --rig slide-bed --exact --train 325:127 --holdout 352:325 "
    "--holdout 127:68 --out result"
)


def show_data(name: str | None, paths: Sequence[Path], out: Path | None) -> None:
    """List the recordings, show one, write the one that is here, or know files by their content.

    Raises:
        InputError: no such recording, a file is not one, or it cannot be written.
    """
    if name == SAMPLE:
        _show_sample(paths, out)
        return
    if out is not None:
        raise InputError(f"--out: only {SAMPLE} is here: stribeck data {SAMPLE} --out FILE.csv")
    screen = console()
    if name is None:
        rows = [[SAMPLE, _SAMPLE, "in the package"]]
        rows += [[r.name, r.axis, r.licence] for r in published().values()]
        heads = ["recording", "axis", "licence"]
        show_table(Table.of_texts("", heads, rows, labels=range(3)))
        return
    recording = published_named(name)
    if paths:
        known = [(path, recording.recognised(path).name) for path in paths]
        _show_commands(
            *(f"{path}: {file} of {name}, as it was published" for path, file in known),
            f"\n{recording.command}",
        )
        return
    screen.print(f"{name}: {recording.axis}\n")
    screen.print(f"published   {recording.citation}")
    screen.print(f"where       {recording.address}")
    screen.print(f"licence     {recording.licence}\n")
    rows = [[file.name, f"{file.size:,}", file.sha256] for file in recording.files]
    show_table(Table.of_texts("", ["file", "bytes", "SHA-256"], rows, labels=(0, 2)))
    _show_commands(
        "",
        f"stribeck data {name} FILE...    # are these the published ones?",
        recording.command,
    )


def _show_sample(paths: Sequence[Path], out: Path | None) -> None:
    if paths:
        raise InputError(f"{SAMPLE}: is in the package: --out FILE.csv writes it")
    if out is not None:
        check_file(out, ".csv")
        write_text(out, sample().decode())
    screen = console()
    screen.print(f"{SAMPLE}: {_SAMPLE}")
    _show_commands(
        f"{out} written" if out else f"\nstribeck data {SAMPLE} --out {SAMPLE}.csv",
        _COMMAND.format(out or f"{SAMPLE}.csv"),
    )


def _show_commands(*lines: str) -> None:
    """Lines to copy: a narrow terminal breaks them, not we."""
    for line in lines:
        console().print(line, soft_wrap=True)


def data_text(name: str | None) -> str:
    """Published recordings as JSON, by name."""
    chosen = published().values() if name in (None, SAMPLE) else [published_named(str(name))]
    entries = {r.name: {k: v for k, v in asdict(r).items() if k != "name"} for r in chosen}
    return json.dumps(entries, indent=2, ensure_ascii=False)
