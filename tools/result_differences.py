"""Differences of two results: texts line by line, JSON field by field, tables cell by cell.

What changes from one run of the same code to the next is blanked or left out before: how long
something took, the version, hashes of cards (a card holds how long its search took) and what is
derived from them, and lines of progress, which come by the clock. Nothing else is.
"""

from __future__ import annotations

import csv
import difflib
import io
import json
import math
import re
import zipfile
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import PurePath
from typing import Any

_SECONDS = r"\d[\d,]*(?:\.\d+)?(?:e[+-]?\d+)?(?: ms| s| min| h)"
_LAP = r"[a-z-]+(?:\s[a-z-]+)*\s+\d+\.\d+"
#: Patterns blanked in any text: the number goes, the words stay.
BLANKED = (
    # `2.11 s: start-up 0.88, reading 0.02, ...`, the stopwatch's words, which may be wrapped
    (
        re.compile(rf"^{_SECONDS}: {_LAP}(?:,\s+{_LAP})*$", re.MULTILINE),
        "# s: ...",
    ),
    # `3,529 evaluations in 3 repeats, 0.4 s, ended: settled`
    (re.compile(rf"(evaluations in [\d,]+ repeats?, ){_SECONDS}"), r"\1# s"),
    (re.compile(rf"(evaluations, ){_SECONDS}(, ended)"), r"\1# s\2"),
    (re.compile(rf"(fits took)\s+{_SECONDS}"), r"\1 # s"),
    (re.compile(rf"(runs, [\d,]+ met their target in ){_SECONDS}"), r"\1#"),
    (re.compile(r'("seconds": )[-+.\de]+'), r"\1#"),
    # shares of seconds in a campaign's table of percentages
    (re.compile(r"^(\W*search time, [\w ]+? less than \w+).*$", re.MULTILINE), r"\1 #"),
    # the last column of tools/rig_study.py
    (re.compile(r"(?<=\d) +\d+\.\d ms$", re.MULTILINE), " # ms"),
    # the hash of the card that an export came from, and an FMU's GUID, which is derived from it
    (re.compile(r"(sha256)\s+[0-9a-f]{64}"), r"\1 #"),
    (re.compile(r"\{[0-9a-f]{32}\}"), "{#}"),
    (re.compile(r'(generationDateAndTime=)"[^"]*"'), r'\1"#"'),
    (re.compile(r"\bstribeck \d+\.\d+\.\d+"), "stribeck #"),
    (re.compile(r'((?:[vV]ersion|"stribeck")(?:=|: ))"\d+\.\d+\.\d+"'), r'\1"#"'),
)
#: Lines of standard error that come by the clock, or where something is compiled.
PROGRESS = re.compile(
    r"^[\d,]+/[\d,]+ (?:evaluations, |runs)|: [\d,]+ evaluations, best |compil|% of the work, "
)
#: Fields of JSON that describe the run and not its result.
IGNORED = frozenset({"seconds", "software"})
#: Columns of CSV that are seconds; of Table 4 it is the one beside the published seconds.
IGNORED_COLUMNS = frozenset({"seconds"})
PUBLISHED_SECONDS = "time/s published"
#: How rows of CSV begin that are shares of seconds.
TIMED_ROW = "search time"
#: The same tables in other forms, which hold seconds, too (they are compared as CSV), and what a
#: compiler made.
IGNORED_FILES = re.compile(
    r"tables/(?:table_4|summary)\.(?:txt|md|tex)$|[!/](?:binaries/|selftest$)"
)
#: The two tables with seconds in what a campaign prints; they are compared as CSV.
TIMED_TABLES = re.compile(
    rf"^(?:function +method +{PUBLISHED_SECONDS}|problem +method .* seconds *$).*?(?:\n\n|\Z)",
    re.MULTILINE | re.DOTALL,
)
NUMBER = re.compile(
    r"[-+−]?(?<![\w.])\d[\d,]*(?:\.\d+)?(?:[eE][-+]?\d+)?|[-+−]?\.\d+(?:[eE][-+]?\d+)?"
)
#: A list of numbers longer than this is compared by its largest difference.
SHORT_LIST = 8
#: Characters of a text that a difference shows.
SHOWN = 160
ABSENT = "absent"


@dataclass(frozen=True)
class Difference:
    """A field with both values and, of numbers, by how much they differ relatively.

    Attributes:
        field: File and field, or file and line.
        before: As printed; empty where there is nothing.
        after: The same.
        relative: |after − before| over the greater magnitude; NaN for what is not a number.
        spacing: Whether only white space differs.
    """

    field: str
    before: str
    after: str
    relative: float = math.nan
    spacing: bool = False


def one_sided(field: str, *, before: bool) -> Difference:
    """Something that is on one side only."""
    return Difference(field, *(("present", ABSENT) if before else (ABSENT, "present")))


def relative(a: float, b: float) -> float:
    """|b − a| over the greater magnitude: 0 if equal, inf where one is not finite."""
    if a == b or (math.isnan(a) and math.isnan(b)):
        return 0.0
    size = max(abs(a), abs(b))
    return abs(b - a) / size if math.isfinite(size) else math.inf


# --- files ----------------------------------------------------------------------------------------


def file_differences(name: str, before: bytes, after: bytes) -> Iterator[Difference]:
    """Differences of a file's two states, by its kind."""
    if before == after or IGNORED_FILES.search(name):
        return
    suffix = PurePath(name).suffix
    if suffix == ".fmu":
        yield from _archive(name, before, after)
        return
    try:
        a, b = before.decode("utf-8"), after.decode("utf-8")
    except UnicodeDecodeError:
        yield Difference(name, f"{len(before)} bytes", f"{len(after)} bytes")
        return
    if suffix == ".json":
        yield from _json(name, a, b)
    elif suffix == ".csv":
        yield from _table(name, a, b)
    else:
        yield from text_differences(name, a, b, exact=True)


def _archive(name: str, before: bytes, after: bytes) -> Iterator[Difference]:
    """Differences of the members of two zip files; binaries are left out."""
    sides = []
    for content in (before, after):
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            sides.append({m: archive.read(m) for m in archive.namelist() if not m.endswith("/")})
    for member in sorted(sides[0].keys() | sides[1].keys()):
        a, b = (side.get(member) for side in sides)
        field = f"{name}!{member}"
        if a is None or b is None:
            yield one_sided(field, before=a is not None)
        else:
            yield from file_differences(field, a, b)


# --- JSON -----------------------------------------------------------------------------------------


def _json(name: str, before: str, after: str) -> Iterator[Difference]:
    try:
        a, b = json.loads(before), json.loads(after)
    except ValueError:
        yield from text_differences(name, before, after, exact=True)
        return
    yield from value_differences(f"{name}:", a, b)


def value_differences(field: str, a: Any, b: Any) -> Iterator[Difference]:
    """Differences of two values of JSON; `IGNORED` fields are passed over."""
    if isinstance(a, dict) and isinstance(b, dict):
        yield from _fields(field, a, b)
    elif isinstance(a, list) and isinstance(b, list):
        yield from _list(field, a, b)
    elif _is_number(a) and _is_number(b):
        if repr(a) != repr(b):
            yield Difference(field, repr(a), repr(b), relative(a, b))
    elif type(a) is not type(b):
        yield Difference(field, _show(a), _show(b))
    elif isinstance(a, str):
        yield from text_differences(field, a, b, exact=True)
    elif a != b:
        yield Difference(field, _show(a), _show(b))


def _fields(field: str, a: dict[str, Any], b: dict[str, Any]) -> Iterator[Difference]:
    for key in [*a, *(k for k in b if k not in a)]:
        if key in IGNORED:
            continue
        inner = f"{field}{'' if field.endswith(':') else '.'}{key}"
        if key in a and key in b:
            yield from value_differences(inner, a[key], b[key])
        else:
            yield Difference(
                inner,
                _show(a[key]) if key in a else ABSENT,
                _show(b[key]) if key in b else ABSENT,
            )


def _list(field: str, a: list[Any], b: list[Any]) -> Iterator[Difference]:
    if len(a) != len(b):
        yield Difference(field, f"{len(a)} entries", f"{len(b)} entries")
        return
    if len(a) > SHORT_LIST and all(_is_number(x) for x in (*a, *b)):
        distances = [relative(x, y) for x, y in zip(a, b, strict=True)]
        if (worst := max(distances)) > 0:
            k = distances.index(worst)
            count = sum(x > 0 for x in distances)
            yield Difference(f"{field}[{k}] ({count} of {len(a)})", repr(a[k]), repr(b[k]), worst)
        return
    for k, (x, y) in enumerate(zip(a, b, strict=True)):
        yield from value_differences(f"{field}[{k}]", x, y)


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _show(value: object) -> str:
    return json.dumps(value, ensure_ascii=False)[:SHOWN]


# --- tables ---------------------------------------------------------------------------------------


def _table(name: str, before: str, after: str) -> Iterator[Difference]:
    """Differences of two CSV files, column by column where their heads are the same."""
    a, b = (list(csv.reader(io.StringIO(text))) for text in (before, after))
    regular = a and b and a[0] == b[0] and len(a) == len(b)
    if not regular or any(len(row) != len(a[0]) for row in (*a, *b)):
        yield from text_differences(name, before, after, exact=True)
        return
    for j, head in enumerate(a[0]):
        if head in IGNORED_COLUMNS or (j and a[0][j - 1] == PUBLISHED_SECONDS):
            continue
        rows = [
            (i, x[j], y[j])
            for i, (x, y) in enumerate(zip(a, b, strict=True))
            if x[j] != y[j] and not (j and x[0] == y[0] and x[0].startswith(TIMED_ROW))
        ]  # fmt: skip
        if rows:
            distances = [_largest_difference(x, y) for _, x, y in rows]
            k = max(
                range(len(rows)),
                key=lambda k: math.inf if distances[k] is None else distances[k] or 0,
            )
            i, x, y = rows[k]
            distance = distances[k]
            field = f"{name}: {head}, row {i} ({len(rows)} of {len(a) - 1})"
            yield Difference(
                field, x[:SHOWN], y[:SHOWN], math.nan if distance is None else distance
            )


# --- texts ----------------------------------------------------------------------------------------


def blanked(text: str) -> str:
    """A text without durations, versions and hashes, which change from run to run."""
    for pattern, replacement in BLANKED:
        text = pattern.sub(replacement, text)
    return "\n".join(line.rstrip() for line in text.splitlines())


def without_progress(text: str) -> str:
    """Standard error without lines that come by the clock, and none twice in a row."""
    lines: list[str] = []
    for line in text.splitlines():
        if not PROGRESS.search(line) and lines[-1:] != [line]:
            lines.append(line)
    return "\n".join(lines)


def printed_differences(name: str, before: str, after: str) -> Iterator[Difference]:
    """Differences of the outputs of two runs; JSON is compared field by field."""
    if before.startswith("{") and after.startswith("{"):
        yield from _json(name, before, after)
        return
    a, b = (TIMED_TABLES.sub("", text) for text in (before, after))
    yield from text_differences(name, a, b)


def text_differences(
    name: str, before: str, after: str, *, exact: bool = False
) -> Iterator[Difference]:
    """Differences of two texts, line by line.

    Args:
        name: What the text is called.
        before: One of them.
        after: The other.
        exact: Spacing counts like any other character.
    """
    a, b = blanked(before).splitlines(), blanked(after).splitlines()
    matcher = difflib.SequenceMatcher(a=a, b=b, autojunk=False)
    for kind, i, i_end, j, j_end in matcher.get_opcodes():
        if kind == "equal":
            continue
        for k, (x, y) in enumerate(zip_longest(a[i:i_end], b[j:j_end])):
            field = name if len(a) == len(b) == 1 else f"{name}:{i + k + 1}"
            equal_but_for_spaces = x is not None and y is not None and x.split() == y.split()
            distance = None if x is None or y is None else _largest_difference(x, y)
            yield Difference(
                field,
                ABSENT if x is None else x[:SHOWN],
                ABSENT if y is None else y[:SHOWN],
                math.nan if distance is None else distance,
                equal_but_for_spaces and not exact,
            )


def _largest_difference(before: str, after: str) -> float | None:
    """The largest relative difference of two lines' numbers, None where more than those differ."""
    a, b = (NUMBER.sub("#", line).split() for line in (before, after))
    if a != b:
        return None
    pairs = zip(_numbers(before), _numbers(after), strict=True)
    return max((relative(x, y) for x, y in pairs), default=None)


def _numbers(line: str) -> list[float]:
    return [float(n.replace(",", "").replace("−", "-")) for n in NUMBER.findall(line)]
