"""The structure of the package, read from its imports: floors, rooms and arrows."""

from __future__ import annotations

import ast
from pathlib import Path

#: The floor of each package and module: it imports from lower floors only.
FLOORS = {
    "_version": 0, "errors": 0, "units": 0, "space": 0, "text_file": 0,
    "compile_cache": 0,
    "friction": 1, "data": 1, "optimize": 1,
    "rig": 2,
    "identify": 3,
    "compensate": 4,
    "export": 5,
    "report": 6,
    "bench": 7,
    "cli": 9, "__main__": 10,
}  # fmt: skip
#: The rooms of a package from the lowest up: a room imports from the rooms before it only.
ROOMS = {
    "data": ("readers",),
    "rig": ("experiments", "motion"),
    "identify": ("uncertainty", "balance", "selection", "design"),
    "export": ("code", "robot", "fmu"),
    "report": ("contents", "figures", "page"),
}
#: What floor 0 may import of its own floor.
GROUND = {"errors"}
ROOT = Path(__file__).parents[1] / "src" / "stribeck"


def dotted(path: Path) -> str:
    """The name of a module below the package: `identify.fit`; a package's own is its folder's."""
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


MODULES = {dotted(p): p for p in sorted(ROOT.rglob("*.py"))}


def imports(path: Path) -> set[str]:
    """The modules of the package that a file imports, by their names below it."""
    folder = path.relative_to(ROOT).parts[:-1]
    targets = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.level:
            above = folder[: len(folder) - node.level + 1]
            module = ".".join((*above, *(node.module.split(".") if node.module else ())))
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
