"""A log from a file, whatever its format and heads: a `Recording` in SI, or one line why not."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from ...drive import DriveChain
from ...errors import InputError
from ..recording import Recording, Source
from . import file_bytes
from .assembly import assembled
from .budget import ReadBudget
from .isolated import size_on_disk
from .log_map import FILE, LogMap, save_map
from .log_path import LogPath
from .opening import opened_as
from .raw_table import printable


def read(
    path: str | Path | Sequence[str | Path],
    *,
    units: Mapping[str, str] | None = None,
    columns: Mapping[str, Any] | str | Path | None = None,
    joint: str | None = None,
    rate: float | None = None,
    time_unit: str | None = None,
    stamp: str | None = None,
    episode: str | None = None,
    subtract: str | None = None,
    drive: DriveChain | Mapping[str, Any] | None = None,
    lenient: bool = False,
    others: Collection[str] = (),
    keep_map: bool = False,
) -> Recording:
    """Read a log of any format of `readers`.

    Columns are known by their heads, which say the unit: `Time [ms]`, `position_mm`, `q_cmd_rad`,
    `tau_meas_Nm`. Where names are other, `columns` maps channels to them:
    `{"position": "qm [m]", "force": {"column": "vir", "factor": "gtau", "unit": "N"}}`, as a dict
    or a TOML file. Every other numeric column is kept in `extra` as written, and so is every
    single number of a MATLAB or JSON file, as a constant column, unless the log is large. Defects
    that do no harm are mended and told in `notes`; the others are refused. Time counts from the
    first sample. A log without a position but with a velocity gets the integral of that.

    Args:
        path: The file, or a folder that is one log; `axis.csv@10s:40s` for a part of it;
            `pos.csv+force.csv`, or a list, for the files of one run, joined by their time stamps.
        units: Unit by column, as in `{"t": "s", "x": "mm"}`, where the heads do not say it.
        columns: Channel -> "head", "head [unit]", a column's number, or a table with `column`, and,
            if wanted, `unit` and `factor` (a number or the name of a column); or the TOML file
            that says so.
        joint: The joint whose columns are taken, by name or number, where a log has several.
        rate: Samples a second of a log without times.
        time_unit: Of times whose unit the format leaves open: ms or us, say.
        stamp: Which time of a message counts: its `header`'s, or that of its `log`.
        episode: Which of several logs in a file or folder is read: its number, or its group.
        subtract: The column of a known force that is taken off the measured one, with its unit if
            the head does not say it: `tau_rigid [N m]`.
        drive: The chain from what the drive recorded to the force at the axis, or its table, as a
            TOML file has it in `[drive]`.
        lenient: Whether a mapped column that is not there is no reason to refuse a log: a rig
            says where its logs may have a channel, and asks for it if it needs it.
        others: Heads of columns that are no channels, whatever they are called: a rig reads them
            from `extra`.
        keep_map: Whether what was chosen is kept beside the log, for others with the same heads.

    Raises:
        InputError: the log cannot be used; the line says what is wrong, where, and what to do.
    """
    words = {"joint": joint, "rate": rate, "time_unit": time_unit, "stamp": stamp,
             "episode": episode, "subtract": subtract}  # fmt: skip
    stated = LogMap.of(columns).with_words(words).driven(drive)
    log = LogPath.of(path)
    try:
        opened = opened_as(log, stated, words, beside=columns is None or lenient, units=units)
        log, files = opened.path, opened.path.files
        used, lenient = opened.map, lenient and not opened.saved
        assembly = assembled(
            opened.log, replace(used, columns=opened.columns), log.window,
            ReadBudget(size_on_disk(*files)), units=units, lenient=lenient, others=others,
        )  # fmt: skip
        complete = opened.complete(assembly.columns)
        if keep_map:
            save_map(files[0].parent, opened.heads, complete)
        told = used != LogMap() and (not lenient or any(words.values()))
        source = Source(
            log.name,
            file_bytes.sha256(*files),
            assembly.rows,
            complete.table() if told else {},
        )
        notes = [f"columns are as {FILE} beside it says"] if opened.saved else []
        arguments = assembly.arguments
        recording = Recording(
            **{**arguments, "notes": (*notes, *arguments["notes"])}, source=source
        )
        if used.drive is None or not assembly.signal:
            return recording
        return recording.through(used.drive, assembly.signal)
    except InputError as error:
        bare = replace(log, written="").name
        sentence = str(error).removeprefix(f"{bare}: ")
        raise type(error)(printable(f"{bare}: {sentence}")) from error
