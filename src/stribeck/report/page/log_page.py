"""The page of a log: what is in it, what it is good enough for, and how to go on."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from ...data.channels import CHANNELS
from ...data.gate import faults, mended
from ...data.gate.fault import SHOWN
from ...data.quality import seen_segments
from ...units import unit
from ..contents_report import contents_table
from ..figures.overview_plots import DrawnLog, overview_groups, run_groups
from ..folder import write_texts
from ..format import number, unit_label
from ..quality_report import quality_text
from ..table import Table
from .html_page import laid_out

if TYPE_CHECKING:
    from ...data.quality import Quality
    from ...data.readers.log_contents import LogContents
    from ...data.recording import Recording

#: What `check --out` writes.
PAGE, VALUES = "check.html", "check.json"
#: Speeds within this ratio are one.
ONE_SPEED = 1.7
#: Places of a finding that are listed.
_PLACES = 3


def write_check(
    recording: Recording,
    quality: Quality,
    contents: LogContents | None,
    command: str,
    folder: Path,
) -> None:
    """Write `check.html` and `check.json` into a folder, both or none.

    Args:
        recording: The log.
        quality: What `check` says of it.
        contents: Its channels; None of a log in memory.
        command: That identifies it; empty where no rig is suggested.
        folder: Where to.

    Raises:
        InputError: the disk refuses.
    """
    page = check_page(recording, quality, contents, command)
    write_texts(folder, {PAGE: page, VALUES: quality_text(quality)})


def check_page(
    recording: Recording, quality: Quality, contents: LogContents | None, command: str
) -> str:
    """The page as text: HTML with all it needs inside."""
    if recording.runs is not None:
        drawn, groups = None, run_groups(recording)
    else:
        log = mended(recording)
        drawn = DrawnLog(log, seen_segments(log), faults(log))
        groups = overview_groups(drawn)
    lines = [line for line in quality.lines() if line[0] not in ("verdict", "likely rig", "fault")]
    return laid_out(
        "log.html.j2",
        {"log": groups},
        "stribeck check",
        quality.file or "A recording",
        _lead(quality),
        quality=quality,
        inspected=drawn is not None,
        findings=None if drawn is None else _findings(drawn),
        missing=_missing(quality),
        covered=_covered(quality),
        shows=_shows(quality),
        channels=None if contents is None else contents_table(contents),
        problems=() if contents is None else contents.problems,
        lines=lines,
        command=command,
        tiles=_tiles(quality),
    )


def _lead(quality: Quality) -> str:
    rig = f"It suggests rig {quality.rig}: {quality.rig_reason}" if quality.rig else (
        f"It suggests no rig: {quality.rig_reason}"
    )  # fmt: skip
    count = len(quality.faults)
    if "position" not in quality.channels:
        state = "Means of runs at constant speed"
    elif count:
        state = f"{count} finding{'s' * (count != 1)} in its channels"
    else:
        state = _missing(quality) or "Its channels are what they seem"
    return f"{state}. {rig}."


def _missing(quality: Quality) -> str:
    """Where rows are missing; empty where none are."""
    if not quality.gaps:
        return ""
    places = f"{quality.gaps} place{'s' * (quality.gaps != 1)}"
    return f"Rows are missing in {places}, at most {quality.longest_gap:.3g} s at a time"


def _tiles(quality: Quality) -> list[tuple[str, str]]:
    """The numbers that are looked for first."""
    if "position" not in quality.channels:
        return [("runs at constant speed", str(quality.rows))]
    return [
        ("length", f"{quality.duration:.4g} s"),
        ("rate", f"{quality.rate:.4g} Hz"),
        ("strokes", str(len(quality.strokes))),
        ("slips", str(len(quality.slips))),
        ("of the time at rest", f"{quality.stuck:.0%}"),
    ]


def _findings(log: DrawnLog) -> Table | None:
    """What the gate tells, with when."""
    rows = []
    for fault in log.faults:
        places = log.places(fault)
        shown = [f"{a:.4g}" if b <= a else f"{a:.4g} to {b:.4g}" for a, b in places[:_PLACES]]
        more = f" and {len(places) - _PLACES} more" * (len(places) > _PLACES)
        harm = "biases estimates from there" if fault.harmful else "is told alone"
        rows.append([fault.channel, f"{', '.join(shown)} s{more}", fault.sentence, harm])
    heads = ["channel", "when", "what", "effect"]
    if not rows:
        return None
    return Table.of_texts("Findings", heads, rows, labels=(0, 1, 2, 3), sentences=(2,))


def _shows(quality: Quality) -> list[str]:
    """What its speeds and forces can show, and what not, a sentence each."""
    runs = "position" not in quality.channels
    low, high = quality.spans["velocity"] if runs else (-1.0, 1.0)
    ways = {s.direction for s in quality.strokes}
    both = low < 0 < high if runs else len(ways) == 2  # noqa: PLR2004 - directions
    sentences = [
        "it goes both ways: friction of each direction can be told from a constant force"
        if both
        else "it goes one way: friction cannot be told from a constant force, and nothing is seen "
        "of the other direction"
    ]
    slow, _, fast = quality.speeds
    if slow > 0:
        ratio = f"its speeds span a factor of {fast / slow:.2g} (a tenth to nine tenths of them)"
        sentences.append(
            f"{ratio}: F_V can be told from F_C"
            if fast > ONE_SPEED * slow
            else f"{ratio}: too few to tell F_V from F_C"
        )
    if "force" not in quality.channels:
        sentences.append("no force: mass and friction have no scale but that of known constants")
    return sentences


def _covered(quality: Quality) -> Table:
    """Ranges of speed and force, by which it is told what a log can show."""
    rows = []
    for name in quality.channels:
        si = _si(quality, name)
        written = SHOWN.get(si, si)
        low, high = (number(float(unit(written).from_si(x)), 4) for x in quality.spans[name])
        step = quality.steps[name]
        shown = number(step / unit(written).factor, 3) if step else "–"
        rows.append([name, low, high, unit_label(written), shown])
    speed = SHOWN.get(si := _si(quality, "velocity"), si)
    middle = [number(float(unit(speed).from_si(s)), 3) for s in quality.speeds]
    share = "moving time is" if "position" in quality.channels else "runs are"
    note = f"half of the {share} below {middle[1]} {unit_label(speed)}, a tenth below "
    note += f"{middle[0]}, nine tenths below {middle[2]}"
    heads = ["channel", "least", "greatest", "unit", "step"]
    return Table.of_texts("Ranges", heads, rows, labels=(0, 3), note=note)


def _si(quality: Quality, channel: str) -> str:
    return CHANNELS[channel][quality.rotary]
