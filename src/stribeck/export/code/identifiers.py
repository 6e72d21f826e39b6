"""Identifiers of a language: no reserved words, no two equal, allowed characters only."""

from __future__ import annotations

import re
from collections.abc import Iterable

from .lowering import assigned, counters, renamed
from .program import ProgramFunction


class Identifiers:
    """The names of one scope, handed out one by one.

    A name is kept where it can be. Else it loses what the language does not take (underscores in
    front, at the end and in twos), and gets a number where it is a word of the language's or
    somebody else's already.

    Args:
        words: The language's own words, and names of the scopes around.
        alike: Whether the language does not tell capitals from small letters.
    """

    def __init__(self, words: Iterable[str], *, alike: bool) -> None:
        self._alike = alike
        self._taken = {self._folded(word) for word in words}

    def new(self, name: str) -> str:
        """A name as near to the wanted one as can be had; it is taken from now on."""
        stem = re.sub(r"_+", "_", re.sub(r"[^A-Za-z0-9_]", "_", name)).strip("_")
        if not stem[:1].isalpha():
            stem = f"x_{stem}".rstrip("_")
        candidate, n = stem, 1
        while self._folded(candidate) in self._taken:
            n += 1
            candidate = f"{stem}_{n}"
        self._taken.add(self._folded(candidate))
        return candidate

    def _folded(self, name: str) -> str:
        return name.upper() if self._alike else name


def named(function: ProgramFunction, names: Identifiers) -> ProgramFunction:
    """A function with names that a language takes, its arguments' first."""
    old_names = [*(a.name for a in function.arguments), *(v.name for v in function.variables)]
    return renamed(function, {name: names.new(name) for name in old_names})


def declared(function: ProgramFunction) -> list[str]:
    """The variables that a function has to declare where loops declare their own."""
    loops = counters(function.body) - assigned(function.body)
    return [v.name for v in function.variables if v.name not in loops]
