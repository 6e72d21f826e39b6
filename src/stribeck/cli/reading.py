"""The options that say how logs are read, the same for every command that reads some."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, get_type_hints

import typer

from ..errors import ChoiceError, InputError

if TYPE_CHECKING:
    from ..data import Recording
    from ..rig import Rig


@dataclass(frozen=True)
class Reading:
    """How logs are read.

    Args:
        columns: A map from channels to columns, as a TOML file.
        column: The same, `CHANNEL=HEAD` each; these go before the file's.
        joint: The joint whose columns are taken.
        rate: Of logs without times, Hz.
        time_unit: Of times whose unit the format leaves open.
        stamp: Which time of a message counts.
        episode: Which of several logs in a file or folder is read.
        subtract: The column of a known force that is taken off the measured one.
        save_map: Whether what is chosen is kept beside the log.
    """

    columns: Annotated[
        Path | None,
        typer.Option(metavar="MAP.toml", help="Which column is what, where the heads do not say."),
    ] = None
    column: Annotated[
        list[str] | None,
        typer.Option(
            metavar="CHANNEL=HEAD",
            help='The same for one channel: position="ActPos [mm]", or force=3 by number.',
        ),
    ] = None
    joint: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help="Whose columns to take, where a log has several joints; by name or number.",
        ),
    ] = None
    rate: Annotated[
        float | None, typer.Option(metavar="HZ", help="Rate of a log without times.")
    ] = None
    time_unit: Annotated[
        str | None, typer.Option(metavar="ms|us|s", help="Unit of times that a format leaves open.")
    ] = None
    stamp: Annotated[
        str | None, typer.Option(metavar="header|log", help="Which time of a message counts.")
    ] = None
    episode: Annotated[
        str | None,
        typer.Option(
            metavar="NAME", help="Which log to read of a file or folder that has several."
        ),
    ] = None
    subtract: Annotated[
        str | None,
        typer.Option(
            metavar="COLUMN",
            help="A known force, such as a rigid-body torque, that is taken off the measured one.",
        ),
    ] = None
    save_map: Annotated[bool, typer.Option("--save-map", help="Keep what was chosen beside the log, for the next with the same heads.")] = False  # fmt: skip

    def map(self) -> dict[str, Any] | None:
        """Which column is which channel, as `read` takes it; None where nothing is said."""
        from ..data.readers.log_map import LogMap

        stated = LogMap.of(self.columns).table() if self.columns is not None else {"columns": {}}
        columns = {**stated["columns"], **_pairs(self.column)}
        table = {**stated, "columns": columns}
        return table if columns or len(table) > 1 else None

    @property
    def words(self) -> dict[str, Any]:
        """What else `read` and `contents` take."""
        names = ("joint", "rate", "time_unit", "stamp", "episode", "subtract")
        return {name: getattr(self, name) for name in names}

    def recordings(self, logs: Sequence[Path], rig: Rig | None) -> list[Recording]:
        """Logs, their columns as is said here, or kept beside them, or as the rig says."""
        from ..data.readers.opening import each_run

        every = [run for log in logs for run in each_run(log, self.map())]
        recordings = [self.recording(run, rig) for run in every]
        names: dict[tuple[str, int], str] = {}
        for recording in recordings:
            key = recording.source.sha256, hash(recording.position.tobytes())
            if key in names:
                first = names[key]
                raise InputError(f"{recording.label}: the same log as {first}: give it once")
            names[key] = recording.label
        return recordings

    def recording(self, log: Path | str, rig: Rig | None) -> Recording:
        """One log; where its channels cannot be told, what is in it is printed.

        Raises:
            InputError: as `read`.
        """
        from ..rig.log_reading import read_for

        stated = self.map()
        try:
            return read_for(rig, log, stated, keep_map=self.save_map, **self.words)
        except ChoiceError as error:
            from ..data.readers.log_contents import contents
            from ..report.contents_report import MOST, contents_table, or_rig

            result = contents(log, columns=stated, **self.words)
            typer.echo(contents_table(result, MOST).text(), err=True)
            more = or_rig(result) if rig is None else ""
            if stated is None and rig is not None and rig.columns:
                more = f" (rig {rig.name} has that mapping: --column CHANNEL=HEAD says another)"
            raise ChoiceError(f"{error}{more}") from error


def _pairs(texts: Sequence[str] | None) -> dict[str, str]:
    from .inputs import pairs

    return dict(pairs("--column", texts))


def reads_logs(command: Callable[..., None]) -> Callable[..., None]:
    """The command with the options of `Reading`, which it is handed as `reading`."""
    hints = get_type_hints(command, include_extras=True)
    options = get_type_hints(Reading, include_extras=True)
    own = [
        p.replace(annotation=hints[name], kind=inspect.Parameter.KEYWORD_ONLY)
        for name, p in inspect.signature(command).parameters.items()
        if name != "reading"
    ]
    added = [
        inspect.Parameter(
            f.name, inspect.Parameter.KEYWORD_ONLY, default=f.default, annotation=options[f.name]
        )
        for f in fields(Reading)
    ]

    @wraps(command)
    def run(**values: Any) -> None:
        reading = Reading(**{p.name: values.pop(p.name) for p in added})
        command(**values, reading=reading)

    run.__signature__ = inspect.Signature([*own, *added])  # type: ignore[attr-defined]
    run.__annotations__ = {p.name: p.annotation for p in (*own, *added)}
    del run.__wrapped__
    return run
