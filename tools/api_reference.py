"""The reference of Python, docs/api.md, made from the docstrings of all public names.

    python tools/api_reference.py

Each function and class stands with its signature, and says its shapes, units, errors and source as
its docstring does; a test holds the page against the code.
"""

from __future__ import annotations

import dataclasses
import inspect
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import stribeck

PAGE = Path(__file__).parents[1] / "docs" / "api.md"
#: Chapters, and the public names in each; every name is in one of them.
CHAPTERS = {
    "Logs": ("read", "Recording", "check", "Quality", "twin"),
    "Identification": ("identify", "Fit", "select", "Selection", "validate", "plan", "Plan"),
    "What is made of it": (
        "report", "Card", "read_card", "simulate", "compensate", "Compensation", "export",
    ),
    "Many axes": ("fleet", "Fleet", "drift", "Drift"),
    "Rigs and laws": ("Rig", "Law", "Param", "Space"),
    "Search": ("minimize", "problem", "Search", "Run"),
    "Errors": ("InputError",),
}  # fmt: skip
REGISTRIES = {
    "RIGS": "Rigs by name",
    "LAWS": "Friction laws by name",
    "METHODS": "Search methods by name",
    "TARGETS": "Export targets by name",
}
HEAD = """# Python

Every public name of `stribeck`, from its docstring (made by `python tools/api_reference.py`).
Numbers are SI unless an argument says *in the unit that the rig shows*. What the user got wrong is
an `InputError` of one line. Options have the names of the command line. A notebook from a frame to
an exported C file: [first_axis.ipynb](notebooks/first_axis.ipynb).
"""
#: Longest signature that stays in one line.
WIDE = 88


def page() -> str:
    """The whole page."""
    parts = [HEAD]
    for chapter, names in CHAPTERS.items():
        parts.append(f"## {chapter}\n")
        parts += [entry(name, getattr(stribeck, name)) for name in names]
    parts.append("## Registries\n")
    parts += [registry(name, title) for name, title in REGISTRIES.items()]
    return "\n".join(parts)


def entry(name: str, value: Any) -> str:
    """A function or class: signature, docstring, and what a class can do."""
    lines = [f"### `{name}`\n", code(signature(name, value)), prose(inspect.getdoc(value) or "")]
    if inspect.isclass(value):
        lines += members(name, value)
    return "\n".join(lines)


def signature(name: str, value: Any) -> str:
    """A call with its annotations, on several lines where it is long."""
    try:
        called = inspect.signature(value)
    except ValueError:  # an exception has none
        return f"{name}(message)"
    if inspect.isclass(value):
        called = called.replace(return_annotation=inspect.Signature.empty)
    texts = [re.sub(r"(?<=: )'([^']*)'", r"\1", str(p)) for p in called.parameters.values()]
    texts = [re.sub(r"<function .*>", "...", text) for text in texts]
    kinds = [p.kind for p in called.parameters.values()]
    if inspect.Parameter.KEYWORD_ONLY in kinds:
        texts.insert(kinds.index(inspect.Parameter.KEYWORD_ONLY), "*")
    back = called.return_annotation
    end = "" if back is inspect.Signature.empty else f" -> {str(back).strip(chr(39))}"
    line = f"{name}({', '.join(texts)}){end}"
    inside = ",\n    ".join(texts)
    return line if len(line) <= WIDE else f"{name}(\n    {inside},\n){end}"


def members(name: str, kind: type) -> Iterator[str]:
    """Methods and properties that a class declares, those of its fields left out."""
    fields = {f.name for f in dataclasses.fields(kind)} if dataclasses.is_dataclass(kind) else set()
    for member, value in vars(kind).items():
        if member.startswith("_") or member in fields or not inspect.getdoc(value):
            continue
        if isinstance(value, property):
            yield f"#### `{name}.{member}`\n\n{prose(inspect.getdoc(value) or '')}"
        elif inspect.isfunction(value) or isinstance(value, classmethod | staticmethod):
            call = signature(f"{name}.{member}", getattr(kind, member))
            call = call.replace("(self, ", "(").replace("(self)", "()")
            yield "\n".join([
                f"#### `{name}.{member}`\n", code(call),
                prose(inspect.getdoc(value) or ""),
            ])  # fmt: skip


def code(text: str) -> str:
    """A block of Python."""
    return f"```python\n{text}\n```\n"


def prose(docstring: str) -> str:
    """A docstring of Google's form as Markdown: arguments are a list, code stays as it is."""
    lines: list[str] = []
    section = False
    for line in docstring.splitlines():
        if head := re.fullmatch(r"(Args|Attributes|Returns|Raises):", line):
            lines += [f"**{head[1]}**", ""]
            section = True
        elif section and (item := re.fullmatch(r"    ([*\w][\w, *]*): (.*)", line)):
            lines.append(f"- `{item[1]}`: {item[2]}")
        elif section and line.startswith("    "):
            lines.append(line[2:] if line.startswith("        ") else line.strip())
        else:
            section = section and not line.strip()
            lines.append(line)
    return "\n".join(lines).rstrip() + "\n"


def registry(name: str, title: str) -> str:
    """What a registry has, a line each."""
    entries = getattr(stribeck, name)
    rows = [f"- `{key}`: {summary(value)}" for key, value in entries.items()]
    return "\n".join([f"### `{name}`\n", f"{title}, as a mapping.\n", *rows, ""])


def summary(value: Any) -> str:
    """What a rig, law, method or target is, in a line."""
    text = value.doc if hasattr(value, "doc") else (inspect.getdoc(value) or "").split("\n\n")[0]
    return " ".join(text.split())


def main() -> None:
    """Write the page."""
    PAGE.write_text(page(), encoding="utf-8")
    print(PAGE)


if __name__ == "__main__":
    main()
