"""Each package imports only from the floors below it."""

import ast
import inspect
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import stribeck

FLOORS = {
    "errors": -1, "units": 0, "space": 0,
    "friction": 1, "data": 1, "optimize": 1,
    "rig": 2,
    "identify": 3,
    "bench": 4, "export": 4,
    "report": 5,
    "studio": 6,
    "cli": 7, "__main__": 8,
}  # fmt: skip
ROOT = Path(stribeck.__file__).parent


def imports(path: Path) -> Iterator[tuple[str, ...]]:
    """What a file imports from the package, as paths below it."""
    here = path.relative_to(ROOT).parts[:-1]
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.level:
            up = here[: len(here) - node.level + 1]
            below = tuple(node.module.split(".")) if node.module else ()
            yield from ((*up, *below) or (alias.name,) for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] == "stribeck":
            yield tuple((node.module or "").split(".")[1:])
        elif isinstance(node, ast.Import):
            for alias in node.names:
                if alias.name.split(".")[0] == "stribeck":
                    yield tuple(alias.name.split(".")[1:])


@pytest.mark.parametrize(
    "path",
    [p for p in ROOT.rglob("*.py") if p != ROOT / "__init__.py"],
    ids=lambda p: str(p.relative_to(ROOT)),
)
def test_imports_only_from_below(path: Path) -> None:
    package = path.relative_to(ROOT).with_suffix("").parts[0]
    for target in imports(path):
        if not target or target[0] in {package, "__version__"}:
            continue
        assert FLOORS[target[0]] < FLOORS[package], f"{package} imports {'.'.join(target)}"


def test_every_package_has_a_floor() -> None:
    found = {
        p.stem if p.is_file() else p.name
        for p in ROOT.iterdir()
        if not p.name.startswith("__pycache__")
    }
    assert {n for n in found if not n.startswith(("py.typed", "__init__", "py"))} <= set(FLOORS)


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
