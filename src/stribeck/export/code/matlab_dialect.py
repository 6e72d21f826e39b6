"""How MATLAB and GNU Octave write expressions, statements and functions.

A function hands back what it writes: an array that it writes into is an argument and a further
result.
Indices count from 1. Zeros have signs, and `copysign` sees them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import ClassVar

from .dialect import CHOICE, SIGN, Dialect
from .identifiers import Identifiers, named
from .program import Array, Expression, Item, Kind, Name, ProgramFunction

#: Keywords, and the functions that the text calls: a variable of that name would hide them.
WORDS = frozenset(
    """
    break case catch classdef continue else elseif end for function global if methods otherwise
    parfor persistent properties return spmd switch try while events enumeration import arguments
    do end_try_catch end_unwind_protect endfor endfunction endif endmethods endparfor endproperties
    endswitch endwhile until unwind_protect unwind_protect_cleanup abs sqrt exp expm1 log log1p sin
    cos tanh power min max floor zeros numel isempty nargin nargout true false struct error ans
    """.split()  # noqa: SIM905 - a list of words is read as a text
)
#: Functions of a program that the language has itself under another name.
_OWN = {"pow": "power", "real": ""}
_HAS = frozenset(
    ("abs", "sqrt", "exp", "expm1", "log", "log1p", "sin", "cos", "tanh", "min", "max")
)
COPYSIGN = """\
function y = copysign(x, v)
% |x| with the sign of v, which a zero has, too.
if v < 0 || (v == 0 && 1 / v < 0)
    y = -abs(x);
else
    y = abs(x);
end
end
"""


class Matlab(Dialect):
    """MATLAB's language.

    Args:
        result: The variable that holds a function's value.
        called: What the program's functions are called here.
    """

    true: ClassVar[str] = "true"
    false: ClassVar[str] = "false"
    negation: ClassVar[str] = "~"
    words: ClassVar[dict[str, str]] = {"and": "&&", "or": "||", "!=": "~="}

    def __init__(self, result: str, called: Mapping[str, str]) -> None:
        self._result, self._called = result, called

    def item(self, array: str, index: Expression) -> str:
        """An element: one further than Python counts."""
        return f"{array}({self.from_one(index)})"

    def _by_two(self, sign: str, left: Expression, right: Expression, kind: Kind) -> str:
        if sign == "//":
            return f"floor({self.write(left, SIGN)} / {self.write(right, SIGN)})"
        return super()._by_two(sign, left, right, kind)

    def call(self, name: str, arguments: Sequence[Expression]) -> str:
        """A function."""
        values = ", ".join(self.write(argument) for argument in arguments)
        if name in _HAS:
            return f"{name}({values})"
        return f"{_OWN[name] if name in _OWN else self._called[name]}({values})"

    def assigned_targets(self, target: Name | Item, written: Sequence[str]) -> str:
        """A function's value and the arrays that it hands back."""
        return f"[{', '.join([self.write(target), *written])}]" if written else self.write(target)

    def return_lines(self, value: Expression) -> list[str]:
        """The result's variable gets its value."""
        return [f"{self._result} = {self.write(value)};", "return"]

    def count_loop(self, name: str, first: Expression, end: Expression) -> tuple[str, str]:
        """A loop that counts."""
        return f"for {name} = {self.write(first, SIGN)}:{self.last(end)}", "end"

    def while_loop(self, test: Expression) -> tuple[str, str]:
        """A loop."""
        return f"while {self.write(test, CHOICE)}", "end"

    def if_words(self) -> tuple[str, str, str, str]:
        """If, else if, else and the end."""
        return "if {}", "elseif {}", "else", "end"


def function_text(f: ProgramFunction, called: Mapping[str, str]) -> str:
    """One local function, with its end."""
    names = Identifiers([*WORDS, *called.values()], alike=False)
    f = named(f, names)
    result = names.new("y")
    arrays = [a for a in f.arguments if isinstance(a, Array) and a.written]
    results = [result, *(a.name for a in arrays)]
    arguments = ", ".join(a.name for a in f.arguments)
    targets = result if len(results) == 1 else f"[{', '.join(results)}]"
    lines = [f"function {targets} = {called[f.name]}({arguments})"]
    lines += [f"% {f.doc}"] if f.doc else []
    body = Matlab(result, called).block(f.body, depth=0)
    return "\n".join([*lines, *(body[:-1] if body[-1] == "return" else body), "end", ""])
