"""The structure of the package, read from its imports: floors, rooms and arrows.

`python tools/structure.py [CHECKOUT ...]` prints what can be counted of it, checkouts side by side.
"""

from __future__ import annotations

import ast
import re
import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from statistics import median

#: The floor of each package and module: it imports from lower floors only.
FLOORS = {
    "_version": 0, "errors": 0, "units": 0, "constant": 0, "space": 0, "text_file": 0,
    "lock_file": 0, "draft": 0, "compile_cache": 0, "drive": 0, "presenters": 0,
    "wording": 0,
    "friction": 1, "data": 1, "optimize": 1, "monitoring": 1,
    "rig": 2,
    "identify": 3,
    "compensate": 4,
    "export": 5,
    "report": 6,
    "bench": 7,
    "studio": 8, "fleet": 8,
    "cli": 9, "__main__": 10,
}  # fmt: skip
#: The rooms of a package from the lowest up: a room imports from the rooms before it only.
ROOMS = {
    "data": ("readers", "gate"),
    "rig": ("experiments", "motion", "parts"),
    "identify": ("uncertainty", "adequacy", "balance", "selection", "design"),
    "export": ("code", "robot", "fmu"),
    "report": ("contents", "figures", "page"),
}
#: What floor 0 may import of its own floor.
GROUND = {"constant", "errors", "lock_file", "space", "text_file", "units", "wording"}
ROOT = Path(__file__).parents[1] / "src" / "stribeck"


def dotted(path: Path) -> str:
    """The name of a module below the package: `identify.fit`; a package's own is its folder's."""
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


MODULES = {dotted(p): p for p in sorted(ROOT.rglob("*.py"))}


def statements(tree: ast.AST) -> Iterator[ast.AST]:
    """Every statement below a node; of ten times as many nodes, those that can be imports."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.stmt | ast.excepthandler | ast.match_case):
            yield node
            yield from statements(node)


def imports(path: Path) -> set[str]:
    """The modules of the package that a file imports, by their names below it."""
    folder = path.relative_to(ROOT).parts[:-1]
    targets = set()
    for node in statements(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.level:
            parents = folder[: len(folder) - node.level + 1]
            module = ".".join((*parents, *(node.module.split(".") if node.module else ())))
            for alias in node.names:
                inner = f"{module}.{alias.name}".strip(".")
                targets.add(inner if inner in MODULES else module)
        elif isinstance(node, ast.ImportFrom | ast.Import):
            names = [a.name for a in node.names] if isinstance(node, ast.Import) else [node.module]
            if any((n or "").split(".")[0] == "stribeck" for n in names):
                raise ValueError(f"{path}: the package imports its own parts relatively")
    return targets - {""}


GRAPH = {name: imports(path) for name, path in MODULES.items() if name}


def room(name: str) -> str:
    """The room of a package that a module lives in; empty for the package's own files."""
    package, *inner = name.split(".")
    return inner[0] if inner and inner[0] in ROOMS.get(package, ()) else ""


#: Names of rig classes whose type tests are counted, outside `rig`.
RIGS = re.compile(
    r"isinstance\([^()]*(?:\([^()]*\)[^()]*)*\b\w*(?:Rig|SlideBed|Emps|Joint|ServoPendulum|Simulated"
    r"|Stepped|Forced|Cylinder|Presliding|Balanced)\b"
)
#: A function longer than this does not fit on a screen.
SCREEN = 60


def counts(root: Path) -> Iterator[tuple[str, str]]:
    """Counts of the sources below a folder: a quantity and its value.

    Args:
        root: The folder of the package, `src/stribeck` of a checkout.
    """
    texts = {p: p.read_text(encoding="utf-8") for p in sorted(root.rglob("*.py"))}
    trees = {p: ast.parse(text) for p, text in texts.items()}
    lines = {p: len(text.splitlines()) for p, text in texts.items()}
    yield "files", f"{len(texts)}"
    yield "most files in one folder", f"{max(Counter(p.parent for p in texts).values())}"
    yield "lines", f"{sum(lines.values()):,}"
    yield "median lines of a file", f"{median(lines.values()):.0f}"
    longest = max(lines, key=lambda p: lines[p])
    yield "longest file", f"{lines[longest]} ({longest.relative_to(root)})"
    functions = [
        node
        for tree in trees.values()
        for node in ast.walk(tree)
        if isinstance(node, ast.FunctionDef)
    ]
    long = [f for f in functions if (f.end_lineno or f.lineno) - f.lineno + 1 > SCREEN]
    yield f"functions over {SCREEN} lines", f"{len(long)} of {len(functions)}"
    inside = [len(RIGS.findall(text)) for p, text in texts.items() if "rig" not in p.parts]
    yield "isinstance on rigs, outside rig/", f"{sum(inside)}"
    classes = Counter(
        node.name
        for tree in trees.values()
        for node in ast.walk(tree)
        if isinstance(node, ast.ClassDef)
    )
    twice = sorted(name for name, n in classes.items() if n > 1)
    yield "class names used twice", f"{len(twice)} {' '.join(twice)}".strip()
    modules = Counter(p.stem for p in texts if p.stem != "__init__")
    repeated = sorted(name for name, n in modules.items() if n > 1)
    yield "module names used twice", f"{len(repeated)} {' '.join(repeated)}".strip()
    names = Counter(
        node.id
        for tree in trees.values()
        for node in ast.walk(tree)
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store) and len(node.id) > 1
    )
    yield "most assigned names", ", ".join(f"{name} {n}" for name, n in names.most_common(10))


def main() -> None:
    """Print the counts of the checkouts named, side by side; of this one by default."""
    checkouts = [Path(a) for a in sys.argv[1:]] or [ROOT.parents[1]]
    columns = [dict(counts(c / "src" / "stribeck")) for c in checkouts]
    for quantity in columns[0]:
        print(f"{quantity:34}", " | ".join(c.get(quantity, "") for c in columns))


if __name__ == "__main__":
    main()
