"""The tables of laws, methods, rigs, drive conventions and formats, for the terminal."""

from __future__ import annotations

import inspect
import json
import re
from collections.abc import Iterable, Mapping
from dataclasses import MISSING, asdict, fields
from typing import TYPE_CHECKING, Any

from rich.padding import Padding

from ..constant import BORROWED, Constant
from ..data.readers.log_file import Reader
from ..data.readers.registry import readers
from ..drive import CONVENTIONS, convention_named
from ..drive.chain_numbers import example_of
from ..errors import InputError
from ..friction import ELEMENTS, LAWS, TERMS, Law, law_named
from ..optimize import METHODS
from ..rig import RIGS
from ..rig.parts import PARTS
from ..rig.rig import shown_in
from .table import Table
from .terminal import console, show_table

if TYPE_CHECKING:
    from ..rig import Rig


#: How people see the two approaches: in the list of rigs, and beside a rig.
_APPROACHES = {
    "output_error": ("simulation", "simulation of its motion"),
    "force_balance": ("force balance", "force balance, without a search"),
}


def _and(names: Iterable[str]) -> str:
    *others, last = names
    return f"{', '.join(others)} and {last}"


def show_laws(name: str | None) -> None:
    """List the friction laws, or explain one."""
    out = console()
    if name is None:
        rows = [[n, _kind(law), law.doc] for n, law in LAWS.items()]
        show_table(Table.of_texts("", ["law", "kind", "what it says"], rows, labels=range(3)))
        out.print(
            f"\n{_and(ELEMENTS)} take a number: {next(iter(ELEMENTS))}:6"
            f"\nevery law takes terms ({', '.join(f'+{term}' for term in TERMS)}): "
            "stribeck+position:2"
        )
        return
    law = law_named(name)
    out.print(f"{law.name}: {law.doc}\n")
    for line in law.formula.split(",  "):
        out.print(_inset(line))
    out.print()
    out.print(_inset(law.cite))
    out.print()
    if law.states:
        out.print(f"  {_kind(law)}, at zero to begin with; continuous through rest")
    reads = [*law.loads, *(term for term in law.terms if term not in law.loads)]
    if reads:
        out.print(f"  depends on {' and '.join(_READS[load] for load in reads)}")
    if law.states or reads:
        out.print()
    rows = [
        [
            q.name,
            q.doc,
            q.unit,
            f"{q.lower:g} to {q.upper:g}" if q.fixed is None else f"{q.fixed:g} (fixed)",
        ]
        for q in law.params
    ]
    heads = ["parameter", "meaning", "unit", "range"]
    show_table(Table.of_texts("", heads, rows, labels=range(4)))
    out.print("\nunits and ranges of a linear axis; a rig has its own")


#: What a law may depend on beside speed, in words.
_READS = {
    "drive": "the force of the drive",
    "external": "the external force",
    "normal": "the normal load",
    "position": "position",
    "temperature": "temperature",
}


def _inset(text: str) -> Padding:
    """A paragraph that stands in by two columns, all of its lines."""
    return Padding(text, (0, 0, 0, 2), expand=False)


def _kind(law: Law) -> str:
    if law.states:
        return f"{law.states} state{'s' if law.states > 1 else ''}"
    return "load" if law.loads else "static"


def show_methods(name: str | None) -> None:
    """List the search methods, or explain one with its settings."""
    out = console()
    if name is None:
        rows = [[n, summary(kind)] for n, kind in METHODS.items()]
        show_table(Table.of_texts("", ["method", "what it does"], rows, labels=range(2)))
        return
    if name not in METHODS:
        raise InputError(f"no method {name!r}: there are {', '.join(METHODS)}")
    kind: Any = METHODS[name]
    said = meanings(kind)
    rows = [
        [f.name, str(f.default) if f.default is not MISSING else "", said.get(f.name, "")]
        for f in fields(kind)
    ]
    out.print(f"{name}: {summary(kind)}\n")
    title, heads = "settings (--setting NAME=VALUE)", ["setting", "default", "meaning"]
    show_table(Table.of_texts(title, heads, rows, labels=range(3)))


def show_parts() -> None:
    """List the parts that an axis is composed of, with their equations."""
    rows = [[p.role, p.name, p.doc, p.contribution] for p in PARTS.values()]
    heads = ["role", "part", "what it is", "equation"]
    show_table(Table.of_texts("", heads, rows, labels=range(4)))


def show_rigs(rig: Rig | None, likely: str = "") -> None:
    """List the rigs, the likely one marked; or show one with its constants and columns."""
    out = console()
    if rig is None:
        marks = [[("→" if n == likely else "")] * bool(likely) for n in RIGS]
        rows = [
            [*mark, n, _APPROACHES[r.approach][0], r.doc]
            for mark, (n, r) in zip(marks, RIGS.items(), strict=True)
        ]
        heads = [*[""] * bool(likely), "rig", "fitted by", "what it is"]
        chosen = [*RIGS].index(likely) if likely else None
        show_table(Table.of_texts("", heads, rows, labels=range(len(heads)), chosen=chosen))
        return
    out.print(f"{rig.name}: {rig.doc}")
    for line in (f"identified by {_APPROACHES[rig.approach][1]}", rig.cite):
        out.print(_inset(line))
    out.print()
    if (equation := rig.equation(law_named(rig.laws[0]))) is not None:
        out.print(f"equation of motion, {equation.friction}")
        for line in equation.text.split(";  "):
            out.print(_inset(line))
        out.print()
    if rig.constants:
        rows = [
            [c.name, f"{c.shown:.6g}", _tolerance(c), c.unit, c.doc, _vouched(c)]
            for c in rig.constants
        ]
        title = "constants (--set NAME=VALUE or NAME=VALUE±TOLERANCE)"
        heads = ["name", "value", "±", "unit", "meaning", "source"]
        show_table(Table.of_texts(title, heads, rows, labels=range(6)))
    law = law_named(rig.laws[0])
    rows = [[rig.label(q.name), q.doc, rig.unit_of(q), _range(rig, q)] for q in rig.parameters(law)]
    title, heads = f"\nparameters with {law.name}", ["name", "meaning", "unit", "range"]
    show_table(Table.of_texts(title, heads, rows, labels=range(4)))
    if rig.columns:
        rows = [[channel, _column(head)] for channel, head in rig.columns.items()]
        heads = ["channel", "column"]
        show_table(Table.of_texts("\ncolumns of its logs", heads, rows, labels=range(2)))


def _tolerance(c: Constant) -> str:
    return f"{c.shown_tolerance:.3g}" if c.tolerance > 0 else ""


def _vouched(c: Constant) -> str:
    """Who vouches for a constant, and where it stands."""
    return f"{c.origin}: {c.source}" if c.origin in BORROWED else c.source


def _range(rig: Rig, param: Any) -> str:
    if param.fixed is not None:
        return f"{param.fixed:g} (fixed)"
    return f"{shown_in(rig, param, param.lower):g} to {shown_in(rig, param, param.upper):g}"


def summary(kind: Any) -> str:
    """What a method does, in a sentence: the first of its docstring."""
    return (inspect.getdoc(kind) or "").split("\n\n")[0].replace("\n", " ")


def meanings(kind: Any) -> dict[str, str]:
    """What the docstrings of a method and of those it is made of say of each setting."""
    meanings: dict[str, str] = {}
    for cls in kind.__mro__:
        _, _, args = (inspect.cleandoc(cls.__doc__ or "")).partition("Args:\n")
        for entry in re.split(r"\n(?=    \w)", "\n" + args.split("\n\n")[0]):
            name, colon, text = entry.strip().partition(":")
            if colon:
                meanings.setdefault(name, " ".join(text.replace("`", "").split()))
    return meanings


def _column(head: Any) -> str:
    if not isinstance(head, Mapping):
        return str(head)
    factor = f" times {head['factor']}" if "factor" in head else ""
    written = f" [{head['unit']}]" if "unit" in head else ""
    return f"{head['column']}{factor}{written}"


def show_drives(name: str | None) -> None:
    """List the drive conventions, or show one with the table that a file needs for it."""
    out = console()
    if name is None:
        rows = [
            [c.name, c.drives, c.object, c.table["signal"], ", ".join(c.needs)]
            for c in CONVENTIONS.values()
        ]
        heads = ["convention", "drives", "what is recorded", "signal", "needs"]
        show_table(Table.of_texts("", heads, rows, labels=range(5)))
        return
    c = convention_named(name)
    out.print(f"{c.name}: {c.drives}, {c.object}\n")
    for line in (c.meaning, c.note, c.document, c.address):
        if line:
            out.print(_inset(line))
    out.print("\nin a rig or a column map (lead and gear where there are):")
    needed = [f'{n} = "{c.examples.get(n, example_of(n))}"' for n in c.needs]
    for line in ("[drive]", f'convention = "{c.name}"', *needed):
        out.print(_inset(line))


def drives_text(name: str | None) -> str:
    """The same as JSON."""
    chosen = CONVENTIONS.values() if name is None else [convention_named(name)]
    entries = {c.name: {k: v for k, v in asdict(c).items() if k != "name"} for c in chosen}
    return json.dumps(entries, indent=2, ensure_ascii=False)


def show_readers(name: str | None) -> None:
    """List the formats of logs, or show one with its library."""
    out = console()
    if name is None:
        rows = [[r.name, r.title, " ".join(r.suffixes), _needed(r)] for r in readers().values()]
        heads = ["reader", "reads", "usual extensions", "needs"]
        show_table(Table.of_texts("", heads, rows, labels=range(4)))
        out.print("\nA log is known by its content, whatever its extension.")
        return
    r = _reader_named(name)
    out.print(f"{r.name}: {r.title}\n")
    lines = (
        f"usual extensions: {' '.join(r.suffixes)}" if r.suffixes else "",
        "a folder may be one" if r.folders else "",
        f"read by {r.library}" if r.library else "",
        f'pip install "stribeck[{r.extra}]"' if r.extra else "",
    )
    for line in filter(None, lines):
        out.print(_inset(line))


def readers_text(name: str | None) -> str:
    """The same as JSON."""
    chosen = readers().values() if name is None else [_reader_named(name)]
    entries = {
        r.name: {"title": r.title, "suffixes": list(r.suffixes), "extra": r.extra,
                 "library": r.library, "folders": r.folders}
        for r in chosen
    }  # fmt: skip
    return json.dumps(entries, indent=2, ensure_ascii=False)


def _reader_named(name: str) -> Reader:
    if name not in readers():
        raise InputError(f"no reader {name!r}: there are {', '.join(readers())}")
    return readers()[name]


def _needed(reader: Reader) -> str:
    """What is installed for a format, with its licence."""
    return f"stribeck[{reader.extra}]: {reader.library}" if reader.extra else reader.library
