"""Each package imports only from the floors below it."""

import ast
import re
import subprocess
import sys
from pathlib import Path

import pytest

import stribeck
from architecture_figure import table
from structure import FLOORS, GRAPH, GROUND, MODULES, ROOMS, room

ROOT = Path(stribeck.__file__).parent
PAGE = Path(__file__).parents[1] / "docs" / "architecture.md"


@pytest.mark.parametrize("name", GRAPH)
def test_imports_only_from_lower_floors(name: str) -> None:
    package = name.split(".", maxsplit=1)[0]
    for target in GRAPH[name]:
        imported = target.split(".")[0]
        if imported != package and not (FLOORS[package] == 0 and imported in GROUND):
            assert FLOORS[imported] < FLOORS[package], f"{name} imports {target}"


@pytest.mark.parametrize("name", [n for n in GRAPH if room(n)])
def test_rooms_import_from_the_rooms_before_them(name: str) -> None:
    package = name.split(".", maxsplit=1)[0]
    order = ROOMS[package]
    for target in GRAPH[name]:
        imported = room(target) if target.split(".")[0] == package else ""
        if imported and imported != room(name):
            assert order.index(imported) < order.index(room(name)), f"{name} imports {target}"


def test_every_folder_is_a_room() -> None:
    for package, rooms in ROOMS.items():
        folders = {p.parent.name for p in (ROOT / package).glob("*/__init__.py")}
        assert folders == set(rooms), package
    deep = {p.parent.relative_to(ROOT).parts for p in ROOT.rglob("__init__.py")}
    assert {parts[0] for parts in deep if len(parts) > 1} == set(ROOMS)
    assert max(len(parts) for parts in deep) == 2, "a room inside a room"


@pytest.mark.parametrize(
    "name", [f"{package}.{r}" for package, rooms in ROOMS.items() for r in rooms]
)
def test_a_room_names_the_files_that_are_imported_from_outside(name: str) -> None:
    inside = {module for module in MODULES if module == name or module.startswith(f"{name}.")}
    importers = (targets for module, targets in GRAPH.items() if module not in inside)
    doors = {door.rsplit(".", maxsplit=1)[-1] for door in inside & set().union(*importers)}
    text = ast.get_docstring(ast.parse(MODULES[name].read_text(encoding="utf-8"))) or ""
    assert doors - {name.split(".")[1]} <= set(re.findall(r"[a-z_0-9]+", text))


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


def test_the_page_on_the_architecture_is_true_to_the_code() -> None:
    page = PAGE.read_text(encoding="utf-8")
    assert "\n".join(table()) in page, "renew it: python tools/architecture_figure.py"
    names = set(re.findall(r"`src/stribeck/([a-z_0-9/]+)(?:\.py)?`", page))
    paths = {name.replace(".", "/") for name in MODULES}
    assert names
    assert names <= paths, sorted(names - paths)


def test_names_that_say_nothing_are_not_used() -> None:
    vague = {"base", "utils", "helpers", "common", "manager", "misc"}
    assert not [p for p in ROOT.rglob("*.py") if p.stem in vague]


def test_public_names_are_sorted_and_there() -> None:
    names = stribeck.__all__
    assert names == sorted(names, key=lambda n: (not n.isupper(), not n[0].isupper(), n))
    assert dir(stribeck) == sorted([*names, "__version__"])
    for name in names:
        value = getattr(stribeck, name)
        home = getattr(value, "__module__", "stribeck")  # a table of laws has none
        assert home.startswith("stribeck.") or isinstance(value, dict)
    assert "stribeck" in stribeck.LAWS
    assert "bts" in stribeck.METHODS
    assert "slide-bed" in stribeck.RIGS
    with pytest.raises(AttributeError, match="no attribute 'nonsense'"):
        stribeck.nonsense  # noqa: B018


@pytest.mark.parametrize("name", ["compensate", "export", "fleet", "identify", "report"])
def test_a_function_keeps_its_name_though_its_package_has_the_same(name: str) -> None:
    """Before, after and while files of the package are imported, by any way of importing."""
    code = f"""
import pydoc, types
import stribeck.{name}, stribeck.rig
from stribeck import {name}
inside = sorted(m for m in __import__("sys").modules if m.startswith("stribeck.{name}."))[0]
package = __import__("importlib").import_module("stribeck.{name}")
assert isinstance(stribeck.{name}, types.FunctionType), stribeck.{name}
assert isinstance(package, types.ModuleType) and {name} is stribeck.{name}
assert getattr(stribeck.{name}, inside.split(".")[2]) is getattr(package, inside.split(".")[2])
page = pydoc.plain(pydoc.render_doc(stribeck.{name}))
assert page.splitlines()[2].startswith("{name}("), page
assert "Raises:" in page
"""
    subprocess.run([sys.executable, "-c", code], check=True)


def test_no_two_classes_of_one_name() -> None:
    places: dict[str, list[str]] = {}
    for module, path in MODULES.items():
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ClassDef):
                places.setdefault(node.name.lstrip("_"), []).append(f"{module}.{node.name}")
    assert {name: files for name, files in places.items() if len(files) > 1} == {}


#: Modules with the name of their package: its main module.
NAMESAKES = {"rig.rig": "the protocol of all rigs", "identify.balance.balance": "the solution"}


def test_no_two_modules_of_one_name() -> None:
    places: dict[str, list[str]] = {}
    for module, path in MODULES.items():
        if module:
            places.setdefault(module.rsplit(".", maxsplit=1)[-1], []).append(module)
        if path.name != "__init__.py" and path.stem == path.parent.name:
            assert module in NAMESAKES, f"{module} has the name of its room"
    for modules in places.values():
        extra = [m for m in modules if m not in NAMESAKES]
        assert len(extra) == 1, modules
