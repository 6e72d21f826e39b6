"""What is in a log, for the terminal and as JSON."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ..rig.lookup import rig_of_heads
from ..wording import option
from .format import DASH, grouped, json_text
from .table import Table
from .terminal import console, show_table

if TYPE_CHECKING:
    from ..data.readers.log_contents import LogContents
    from ..data.readers.log_file import Channel


#: Channels that are shown beside a refusal.
MOST = 40


def contents_table(contents: LogContents, most: int | None = None) -> Table:
    """Its channels, and which of them are taken for what.

    Args:
        contents: What is in a log.
        most: Channels shown at most, those first whose names say something; all by default.
    """
    taken = {c.column: f"{channel}, {c.reason}" for channel, c in contents.taken.items()}
    rows = [
        [
            str(number),
            c.name,
            c.unit or _head_unit(contents, c.name) or DASH,
            f"{c.count:,}",
            DASH if c.rate is None else grouped(c.rate),
            *((DASH, DASH) if c.ends is None else (f"{end:.6g}" for end in c.ends)),
            taken.get(c.name) or _guess(contents, c),
        ]
        for number, c in enumerate(contents.channels, 1)
    ]
    note = ""
    if most is not None and len(rows) > most:
        note = f"of {len(rows):,} channels; `stribeck contents` lists all"
        rows = [row for row in rows if row[-1]][:most] or rows[:most]
    heads = ["#", "channel", "unit", "samples", "rate / Hz", "first", "last", "taken as"]
    title = f"{contents.file}: {contents.format}"
    return Table.of_texts(title, heads, rows, labels=(1, 2, 7), note=note)


def _guess(contents: LogContents, channel: Channel) -> str:
    """What a column may be that was not taken."""
    if channel.is_time:
        return f"time of {channel.clock}"
    names = " or ".join(contents.guesses.get(channel.name, ()))
    return f"{names}?{' (no unit)' * (channel.unit is None)}" if names else ""


def _head_unit(contents: LogContents, name: str) -> str:
    """The unit of a column that is taken, which its head or a map says."""
    return next((c.unit.written for c in contents.taken.values() if c.column == name), "")


def show_contents(contents: LogContents) -> None:
    """Print what is in a log, and what is open."""
    show_table(contents_table(contents))
    out = console()
    for sentence in contents.problems:
        out.print(f"note: {sentence}")
    lacking = f"no recording yet: {contents.lacking}{or_rig(contents)}"
    out.print(lacking if contents.lacking else _ready(contents))


def or_rig(contents: LogContents) -> str:
    """The rig whose logs have the heads of a log, as another way to say which column is which."""
    like = rig_of_heads([c.name for c in contents.channels])
    return f"; or {option('rig', like)}, whose logs have these heads" if like else ""


def _ready(contents: LogContents) -> str:
    names = ", ".join(f"{channel} from {c.column}" for channel, c in contents.taken.items())
    rows = "" if _timed(contents) else ": each row a run at constant speed"
    return f"check and identify take {names}{rows}"


def _timed(contents: LogContents) -> bool:
    """Whether its rows have times; they are runs at constant speed elsewhere."""
    return "time" in contents.taken or any(c.rate is not None for c in contents.channels)


def contents_text(contents: LogContents) -> str:
    """The same as JSON."""
    return json_text(
        {
            "schema": "stribeck-contents/1",
            "file": contents.file,
            "format": contents.format,
            "channels": [_channel(contents, c) for c in contents.channels],
            "taken": {
                name: {"column": c.column, "unit": c.unit.written, "reason": c.reason}
                for name, c in contents.taken.items()
            },
            "guesses": {name: list(channels) for name, channels in contents.guesses.items()},
            "problems": [*contents.problems, *([contents.lacking] if contents.lacking else [])],
        }
    )


def _channel(contents: LogContents, channel: Channel) -> dict[str, Any]:
    span, ends = channel.span or (None, None), channel.ends or (None, None)
    return {
        "name": channel.name,
        "unit": channel.unit or _head_unit(contents, channel.name) or None,
        "count": channel.count,
        "rate": channel.rate,
        "clock": channel.clock or None,
        "start": span[0],
        "end": span[1],
        "first": ends[0],
        "last": ends[1],
        "constant": channel.constant,
    }
