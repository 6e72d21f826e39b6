"""How Modelica writes expressions, statements and functions.

Its AND and OR may evaluate all their parts, a minus sign only begins a sum, arrays count from 1,
and no zero has a sign: `copysign(x, v)` takes + for v == 0. Programs are lowered first.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import ClassVar

from .dialect import ATOM, CHOICE, SUM, Dialect
from .identifiers import Identifiers, declared, named
from .program import Expression, Item, Kind, Name, ProgramFunction

#: Keywords, and built-in functions and variables that nothing should hide (Modelica 3.6).
WORDS = frozenset(
    """
    algorithm and annotation block break class connect connector constant constrainedby der discrete
    each else elseif elsewhen encapsulated end enumeration equation expandable extends external
    false final flow for function if import impure in initial inner input loop model not operator
    or outer output package parameter partial protected public pure record redeclare replaceable
    return stream then true type when while within abs sign sqrt div mod rem ceil floor integer sin
    cos tan asin acos atan atan2 sinh cosh tanh exp log log10 min max sum product zeros ones fill
    size ndims scalar vector matrix identity diagonal linspace transpose cross skew symmetric cat
    pre edge change sample initial terminal time noEvent smooth reinit assert terminate delay
    homotopy cardinality semiLinear inStream actualStream spatialDistribution getInstanceName String
    Real Integer Boolean Modelica Clock hold previous subSample superSample shiftSample backSample
    noClock interval firstTick
    """.split()  # noqa: SIM905 - a list of words is read as a text
)
_HAS = {"abs", "sqrt", "exp", "log", "sin", "cos", "tanh", "min", "max"}
TYPES: Mapping[Kind, str] = {"real": "Real", "whole": "Integer", "truth": "Boolean"}
#: Functions of the mathematics that the language lacks.
HELPERS: Mapping[str, str] = {
    "copysign": """\
  function copysign "abs(x) with the sign of v; 0.0 has the sign +"
    input Real x;
    input Real v;
    output Real y;
  algorithm
    if v < 0.0 then
      y := -abs(x);
    else
      y := abs(x);
    end if;
  end copysign;
""",
    "expm1": """\
  function expm1 "exp(x) - 1, near 0 by its series: nothing cancels"
    input Real x;
    output Real y;
  algorithm
    if abs(x) < 0.5 then
      y := 1.0;
      for i in 17:-1:2 loop
        y := 1.0 + x * y / i;
      end for;
      y := x * y;
    else
      y := exp(x) - 1.0;
    end if;
  end expm1;
""",
    "log1p": """\
  function log1p "log(1 + x), near 0 as 2 artanh(x / (2 + x)) by its series"
    input Real x;
    output Real y;
  protected
    Real share;
  algorithm
    if abs(x) < 0.25 then
      share := x / (2.0 + x);
      y := 1.0 / 23.0;
      for i in 10:-1:1 loop
        y := y * share * share + 1.0 / (2 * i + 1);
      end for;
      y := 2.0 * (share + share * share * share * y);
    else
      y := log(1.0 + x);
    end if;
  end log1p;
""",
}


class Modelica(Dialect):
    """Modelica.

    Args:
        result: The variable that holds a function's value.
        called: What the program's functions are called here.
    """

    indent: ClassVar[str] = "  "
    becomes: ClassVar[str] = ":="
    true: ClassVar[str] = "true"
    false: ClassVar[str] = "false"
    negation: ClassVar[str] = "not "
    words: ClassVar[dict[str, str]] = {"!=": "<>"}

    def __init__(self, result: str, called: Mapping[str, str]) -> None:
        self._result, self._called = result, called

    def operand(self, expression: Expression, kind: Kind, above: int) -> str:
        """One side of an operation: what has a minus sign stands in brackets behind another."""
        del kind
        text = self.write(expression, above)
        return f"({text})" if text.startswith("-") and SUM < above < ATOM else text

    def item(self, array: str, index: Expression) -> str:
        """An element: one further than Python counts."""
        return f"{array}[{self.from_one(index)}]"

    def _by_two(self, sign: str, left: Expression, right: Expression, kind: Kind) -> str:
        if sign == "//":
            return f"div({self.write(left)}, {self.write(right)})"
        return super()._by_two(sign, left, right, kind)

    def call(self, name: str, arguments: Sequence[Expression]) -> str:
        """A function."""
        values = [self.write(argument) for argument in arguments]
        if name == "pow":
            return f"(({values[0]}) ^ ({values[1]}))"
        if name == "real":
            return f"({values[0]})"
        return f"{name if name in _HAS else self._called[name]}({', '.join(values)})"

    def assigned_targets(self, target: Name | Item, written: Sequence[str]) -> str:
        """A function's value and the arrays that it hands back."""
        return f"({', '.join([self.write(target), *written])})" if written else self.write(target)

    def return_lines(self, value: Expression) -> list[str]:
        """The result gets its value."""
        return [f"{self._result} := {self.write(value)};", "return;"]

    def count_loop(self, name: str, first: Expression, end: Expression) -> tuple[str, str]:
        """A loop that counts."""
        return f"for {name} in {self.write(first, SUM)}:{self.last(end)} loop", "end for;"

    def while_loop(self, test: Expression) -> tuple[str, str]:
        """A loop."""
        return f"while {self.write(test, CHOICE)} loop", "end while;"

    def if_words(self) -> tuple[str, str, str, str]:
        """If, else if, else and the end."""
        return "if {} then", "elseif {} then", "else", "end if;"


def function_text(f: ProgramFunction, called: Mapping[str, str]) -> str:
    """One function of the package."""
    names = Identifiers([*WORDS, *called.values()], alike=False)
    plain = [v.kind for v in f.variables if v.name in declared(f)]
    f = named(f, names)
    result, name = names.new("y"), called[f.name]
    lines = [f"  function {name}" + (f' "{quoted(f.doc)}"' if f.doc else "")]
    copied, handed_back = {}, []
    for a in f.arguments:
        if isinstance(a, Name):
            lines.append(f"    input {TYPES[a.kind]} {a.name};")
        elif a.written:
            copied[a.name] = names.new(f"{a.name}_before")
            lines.append(f"    input Real {copied[a.name]}[{a.length}];")
            handed_back.append(f"    output Real {a.name}[{a.length}];")
        else:
            lines.append(f"    input Real {a.name}[{a.length}];")
    lines += [f"    output {TYPES[f.results[0]]} {result};", *handed_back]
    if plain:
        lines.append("  protected")
        lines += [f"    {TYPES[k]} {v};" for k, v in zip(plain, declared(f), strict=True)]
    body = Modelica(result, called).block(f.body, depth=2)
    heads = [f"    {array} := {before};" for array, before in copied.items()]
    body = body[:-1] if body[-1].strip() == "return;" else body
    return "\n".join([*lines, "  algorithm", *heads, *body, f"  end {name};", ""])


def quoted(text: str) -> str:
    """What stands between the quotes of a string."""
    return text.replace("\\", "\\\\").replace('"', '\\"')
