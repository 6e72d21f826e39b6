"""Advice in sentences names options and commands that exist, where they are said."""

from __future__ import annotations

import ast
import re
from functools import cache
from pathlib import Path

import pytest

import stribeck
from stribeck.cli import command_line

SOURCE = Path(stribeck.__file__).parent
#: Which commands say what a folder or file says, the nearest first; elsewhere any command may.
SPEAKERS = {
    "identify/selection": {"select"},
    "identify/design": {"plan", "identify"},
    "identify/validate.py": {"validate"},
    "identify": {"identify"},
    "rig/twin.py": {"twin"},
    "rig": {"identify", "plan"},
    "compensate": {"compensate"},
    "export": {"export"},
    "bench": {"bench"},
}
#: What other programs take, by the file that calls them.
FOREIGN = {"bench/coco.py": {"--no-interactive"}, "bench/engines.py": {"--nthreads"}}
OPTION, COMMAND = re.compile(r"(?<![\w-])--[a-z][a-z-]*"), re.compile(r"`stribeck ([a-z]+)")
#: A call, as Python has it and a command line has not.
CALL = re.compile(r"\b[A-Za-z_]+\([a-z_]+=")


@cache
def options() -> dict[str, set[str]]:
    """The options of each command."""
    commands = command_line().commands
    return {
        name: {opt for p in command.params for opt in (*p.opts, *p.secondary_opts)}
        | {"--help", "--version"}
        for name, command in commands.items()
    }


def sentences(file: Path) -> list[tuple[int, str]]:
    """Texts in a file that somebody may read, each with its line: no docstrings."""
    tree = ast.parse(file.read_text(encoding="utf-8"))
    bodies = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
    documented = {
        id(statement.value)
        for node in ast.walk(tree)
        if isinstance(node, bodies)
        for statement in node.body
        if isinstance(statement, ast.Expr)
    }
    return [
        (node.lineno, node.value)
        for node in ast.walk(tree)
        if isinstance(node, ast.Constant)
        and isinstance(node.value, str)
        and id(node) not in documented
    ]


def said() -> list[tuple[str, int, str]]:
    """Every text of the package: file, line, text."""
    return [
        (file.relative_to(SOURCE).as_posix(), line, text)
        for file in sorted(SOURCE.rglob("*.py"))
        for line, text in sentences(file)
    ]


def allowed(file: str) -> set[str]:
    """The options that a text of a file may name."""
    speakers = next((v for k, v in SPEAKERS.items() if file.startswith(k)), set(options()))
    return set().union(*(options()[s] for s in speakers)) | FOREIGN.get(file, set())


def test_options_in_sentences_exist_where_they_are_said() -> None:
    named = [(file, line, option) for file, line, text in said() for option in OPTION.findall(text)]
    assert len(named) > 50
    assert [entry for entry in named if entry[2] not in allowed(entry[0])] == []


def test_commands_in_sentences_exist() -> None:
    named = [(file, line, name) for file, line, text in said() for name in COMMAND.findall(text)]
    assert named
    assert [entry for entry in named if entry[2] not in options()] == []


def test_nobody_is_told_to_call_python_on_a_command_line() -> None:
    told = [entry for entry in said() if entry[0].startswith("identify") and CALL.search(entry[2])]
    assert told == []


@pytest.mark.parametrize("option", ["--repeats", "--bounds"])
def test_an_option_that_another_command_has_is_not_enough(option: str) -> None:
    assert option in allowed("identify/fit_warnings.py")
    assert option not in allowed("compensate/trial.py")
