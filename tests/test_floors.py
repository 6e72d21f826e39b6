"""Each package imports only from the floors below it."""

import ast
import inspect
import subprocess
import sys
from pathlib import Path

import pytest

import stribeck

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
ROOT = Path(stribeck.__file__).parent


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
            assert not any((n or "").split(".")[0] == "stribeck" for n in names), (
                f"{path}: the package imports its own parts relatively"
            )
    return targets - {""}


GRAPH = {name: imports(path) for name, path in MODULES.items() if name}


def room(name: str) -> str:
    """The room of a package that a module lives in; empty for the package's own files."""
    package, *inner = name.split(".")
    return inner[0] if inner and inner[0] in ROOMS.get(package, ()) else ""


@pytest.mark.parametrize("name", GRAPH)
def test_imports_only_from_lower_floors(name: str) -> None:
    package = name.split(".", maxsplit=1)[0]
    for target in GRAPH[name]:
        other = target.split(".")[0]
        if other != package and not (FLOORS[package] == 0 and other in GROUND):
            assert FLOORS[other] < FLOORS[package], f"{name} imports {target}"


@pytest.mark.parametrize("name", [n for n in GRAPH if room(n)])
def test_rooms_import_from_the_rooms_before_them(name: str) -> None:
    package = name.split(".", maxsplit=1)[0]
    order = ROOMS[package]
    for target in GRAPH[name]:
        other = room(target) if target.split(".")[0] == package else ""
        if other and other != room(name):
            assert order.index(other) < order.index(room(name)), f"{name} imports {target}"


def test_every_folder_is_a_room() -> None:
    for package, rooms in ROOMS.items():
        folders = {p.parent.name for p in (ROOT / package).glob("*/__init__.py")}
        assert folders == set(rooms), package
    deep = {p.parent.relative_to(ROOT).parts for p in ROOT.rglob("__init__.py")}
    assert {parts[0] for parts in deep if len(parts) > 1} == set(ROOMS)
    assert max(len(parts) for parts in deep) == 2, "a room inside a room"


def test_no_circle_of_files() -> None:
    order: list[str] = []
    open_now: list[str] = []

    def visit(name: str) -> None:
        assert name not in open_now, " -> ".join([*open_now[open_now.index(name) :], name])
        if name in order:
            return
        open_now.append(name)
        for target in sorted(GRAPH.get(name, ())):
            visit(target)
        open_now.pop()
        order.append(name)

    for name in GRAPH:
        visit(name)


def test_every_package_has_a_floor() -> None:
    assert {name.split(".")[0] for name in GRAPH} == set(FLOORS)


def test_names_that_say_nothing_are_not_used() -> None:
    hollow = {"base", "utils", "helpers", "common", "manager", "misc"}
    assert not [p for p in ROOT.rglob("*.py") if p.stem in hollow]


def test_public_names_are_sorted_and_there() -> None:
    names = stribeck.__all__
    assert names == sorted(names, key=lambda n: (not n.isupper(), not n[0].isupper(), n))
    assert dir(stribeck) == sorted([*names, "__version__"])
    for name in names:
        value = getattr(stribeck, name)
        home = getattr(value, "__module__", "stribeck")  # a table of laws has none
        assert home.startswith("stribeck.") or isinstance(value, dict) or name == "identify"
    assert "stribeck" in stribeck.LAWS
    assert "bts" in stribeck.METHODS
    assert "slide-bed" in stribeck.RIGS
    with pytest.raises(AttributeError, match="no attribute 'nonsense'"):
        stribeck.nonsense  # noqa: B018


@pytest.mark.parametrize("first", ["stribeck.identify.problem", "stribeck.rig"])
def test_identify_can_be_called_whatever_was_imported_first(first: str) -> None:
    said = f"import {first}, stribeck.identify.fit; stribeck.identify.fit; stribeck.identify([])"
    done = subprocess.run([sys.executable, "-c", said], capture_output=True, text=True, check=False)
    assert "InputError: no recording was given" in done.stderr
    assert "method" in inspect.signature(stribeck.identify).parameters
