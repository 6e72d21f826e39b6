"""The tests' parser of Structured Text: it accepts what blark accepts, and refuses errors."""

from __future__ import annotations

from typing import Any

import pytest
from blark import transform as tf
from blark.parse import parse_source_code

import st_parser as st
from exported import model_of, model_with
from own_laws import AWKWARD, own_law
from st_interpreter import Controller
from st_parser import IecError, parsed
from stribeck.compensate.compensator import Compensator
from stribeck.export.code.st import st as exported
from stribeck.export.model import Model

_SECTIONS = {
    tf.InputDeclarations: "input",
    tf.InputOutputDeclarations: "in_out",
    tf.OutputDeclarations: "output",
    tf.VariableDeclarations: "own",
    tf.FunctionVariableDeclarations: "own",
}


def units_of(text: str) -> tuple[st.Unit, ...]:
    """The program units as blark parses them; its grammar is TwinCAT's."""
    source = parse_source_code(text).transform()
    assert isinstance(source, tf.SourceCode)
    return tuple(map(unit_of, source.items))


def unit_of(item: Any) -> st.Unit:
    variables = [
        variable_of(str(variable.variable.name), declaration, _SECTIONS[type(section)])
        for section in item.declarations
        for declaration in section.items
        for variable in declaration.variables
    ]
    result = str(item.return_type) if isinstance(item, tf.Function) else None
    return st.Unit(str(item.name), result, tuple(variables), body_of(item.body))


def variable_of(name: str, declaration: Any, section: str) -> st.Variable:
    init = declaration.init
    if isinstance(declaration, tf.ArrayVariableInitDeclaration):
        (bounds,) = init.spec.subranges
        assert int(str(bounds.start.value)) == 0
        length = int(str(bounds.stop.value)) + 1
        return st.Variable(name, str(init.spec.type.type_name), length, None, section)
    initial = None if init.value is None else expression_of(init.value)
    return st.Variable(name, str(init.spec), None, initial, section)


def body_of(body: Any) -> st.Body:
    return () if body is None else tuple(map(statement_of, body.statements))


def statement_of(item: Any) -> st.Statement:
    match item:
        case tf.AssignmentStatement(variables=[target], expression=value):
            place = expression_of(target)
            assert isinstance(place, st.Name | st.Element)
            return st.Assignment(place, expression_of(value))
        case tf.IfStatement():
            branches = [(item.if_expression, item.statements)]
            branches += [(branch.if_expression, branch.statements) for branch in item.else_ifs]
            return st.If(
                tuple((expression_of(test), body_of(body)) for test, body in branches),
                body_of(item.else_clause and item.else_clause.statements),
            )
        case tf.ForStatement():
            ends = (item.from_, item.to, item.step)
            first, last, step = (st.Number(1) if x is None else expression_of(x) for x in ends)
            return st.For(name_of(item.control), first, last, step, body_of(item.statements))
        case tf.WhileStatement():
            return st.While(expression_of(item.expression), body_of(item.statements))
        case tf.ReturnStatement():
            return st.Return()
        case tf.FunctionCallStatement() | tf.FunctionCall():
            return call_of(item)
    raise AssertionError(item)


def call_of(item: Any) -> st.Call:
    arguments = [
        (None if x.name is None else name_of(x.name), expression_of(x.value))
        for x in item.parameters
    ]
    return st.Call(name_of(item.name), tuple(arguments))


def expression_of(item: Any) -> st.Expression:  # noqa: C901, PLR0911 - one case a line
    match item:
        case tf.ParenthesizedExpression(expr=inner):
            return expression_of(inner)
        case tf.Real(value=text, type_name=kind):
            return st.Number(st.number(str(text), double=str(kind).upper() == "LREAL"))
        case tf.Integer(value=text):
            return st.Number(int(str(text)))
        case tf.Boolean(value=text):
            return st.Truth(str(text).upper() == "TRUE")
        case tf.UnaryOperation(op=op, expr=inner):
            return st.Unary(str(op).lower(), expression_of(inner))
        case tf.BinaryOperation(left=left, op=op, right=right):
            return st.Binary(str(op).lower(), expression_of(left), expression_of(right))
        case tf.FunctionCall():
            return call_of(item)
        case tf.SimpleVariable():
            return st.Name(name_of(item))
        case tf.MultiElementVariable(elements=[tf.FieldSelector(field=field)]):
            return st.Output(name_of(item.name), name_of(field))
        case tf.MultiElementVariable(elements=[tf.SubscriptList(subscripts=[index])]):
            return st.Element(name_of(item.name), expression_of(index))
    raise AssertionError(item)


def name_of(item: Any) -> str:
    while not isinstance(item, str):
        item = item.name
    return str(item).lower()


#: Texts rare in laws: precedence of operators, and positions of keywords.
GRAMMAR = """
(* a comment (with brackets) *)
FUNCTION Deep : LREAL
VAR_INPUT
    a : LREAL;
    b : LREAL;
END_VAR
VAR
    i : DINT;
    yes : BOOL := TRUE;
END_VAR

Deep := a - b - 1.5 * a / b / 2.0 * -a + (a + b) * LREAL#-1.0E-3;
IF a < b OR NOT yes AND b >= a - 1.0 = yes <> (a > b) THEN
    RETURN;
ELSIF NOT (yes OR FALSE) THEN
    Deep := -(a + b);
ELSIF yes AND NOT yes OR yes THEN
    i := 1 - 2 - 3;
ELSE
    FOR i := 3 TO 0 BY -1 DO
        WHILE a <= b DO
            RETURN;
        END_WHILE;
    END_FOR;
END_IF;
END_FUNCTION
"""


def text_of(model: Model) -> str:
    text = exported(model, compensator=Compensator(feedback=True))["Friction.st"]
    return text.decode("ascii")


def law_of(model: Model) -> str:
    """The law's own functions alone: the grammar takes a second for a thousand letters."""
    functions = text_of(model).split("END_FUNCTION\n")
    (last,) = (i for i, f in enumerate(functions) if "FUNCTION Friction_steady" in f)
    return "".join(f + "END_FUNCTION\n" for f in functions[: last + 1])


TEXTS = {
    "grammar": GRAMMAR,
    "elasto-plastic": text_of(model_of("elasto-plastic")),
    **{case: law_of(model_with(own_law(AWKWARD[case]))) for case in AWKWARD},
}


@pytest.mark.parametrize("name", TEXTS)
def test_it_reads_what_a_full_grammar_reads(name: str) -> None:
    assert parsed(TEXTS[name]) == units_of(TEXTS[name])


def program(body: str, declarations: str = "") -> str:
    return f"""FUNCTION f : LREAL
VAR_INPUT
    x : LREAL;
    n : DINT;
END_VAR
VAR
    i : DINT;
    yes : BOOL;
    two : ARRAY[0..1] OF LREAL;
    {declarations}
END_VAR
f := 0.0;
{body}
END_FUNCTION
"""


def test_a_program_runs() -> None:
    sums = "FOR i := 1 TO n DO f := f + x; END_FOR;"
    assert Controller(program(sums)).call("f", 0.5, 3) == 1.5
    halves = "WHILE f < x DO f := f + DINT_TO_LREAL(i + 1) / 2.0; END_WHILE;"
    assert Controller(program(halves)).call("f", 0.75, 0) == 1.0
    assert Controller(program("f := DINT_TO_LREAL(-7 / n);")).call("f", 0.0, 2) == -3.0
    assert Controller(program("f := 0.1;")).call("f", 0.0, 0) == pytest.approx(0.1, abs=2e-9)
    assert Controller(program("f := 0.1;")).call("f", 0.0, 0) != 0.1


@pytest.mark.parametrize(
    "body",
    [
        "f := y;", "y := 1.0;", "f := 1;", "f := x + n;", "i := x;", "yes := 1;", "f := yes;",
        "x := 1.0;", "FOR i := 0 TO 1 DO i := 2; END_FOR;", "FOR x := 0 TO 1 DO f := x; END_FOR;",
        "FOR i := 0 TO 1 DO FOR i := 0 TO 1 DO f := x; END_FOR; END_FOR;", "two := two;",
        "two[0.0] := x;", "f := two;", "f := x[0];", "IF x THEN f := x; END_IF;", "f := -yes;",
        "WHILE n DO f := x; END_WHILE;", "f := NOT x;", "f := yes AND x;", "yes := yes < yes;",
        "f := SQRT(n);", "f := SQRT(x, x);", "f := MIN(x, n);", "f := MIN(x);", "f := TAN(x);",
        "f := f(x := x, n := n);", "f := g(x);", "x(n := 1);", "f := x.out;", "f := abs;",
        "f := x", "f = x;", "f := (x;", "f := x);", "f := x ** 2.0;", "f := x MOD x;", "f := 1.;",
        "f := .5;", "f := 1e3;", "f := DINT#1;", "f := - -x;", "f := x; (* open", "f := 'x';",
        "IF yes THEN f := x;", "IF yes f := x; END_IF;", "EXIT;", "f := %IX0;", "// x",
    ],
)  # fmt: skip
def test_what_a_compiler_would_refuse(body: str) -> None:
    with pytest.raises(IecError):
        Controller(program(body))


@pytest.mark.parametrize(
    "declarations",
    [
        "x : LREAL;", "F : LREAL;", "X : LREAL;", "a__b : LREAL;", "_a : LREAL;", "a_ : LREAL;",
        "to : LREAL;", "limit : LREAL;", "a : REAL;", "a : LREAL := 1;", "a : LREAL := x;",
        "a : ARRAY[1..2] OF LREAL;", "a : g;", "a LREAL;", "a : LREAL",
    ],
)  # fmt: skip
def test_declarations_that_a_compiler_would_refuse(declarations: str) -> None:
    with pytest.raises(IecError):
        Controller(program("", declarations))
    Controller(program("", "a : LREAL := 1.0;"))


@pytest.mark.parametrize(
    ("body", "x", "n"),
    [
        ("f := 1.0 / x;", 0.0, 0),
        ("f := x * x;", 1e200, 0),
        ("f := EXP(x);", 1e3, 0),
        ("f := SQRT(x);", -1.0, 0),
        ("f := LN(x);", 0.0, 0),
        ("f := EXPT(x, 2.0);", 0.0, 0),
        ("f := two[n];", 0.0, 2),
        ("f := two[n];", 0.0, -1),
        ("two[n] := x;", 0.0, 2),
        ("i := 2147483647 + n;", 0.0, 1),
        ("i := n / 0;", 0.0, 1),
        ("FOR i := 0 TO n DO f := x; END_FOR; i := i;", 0.0, 1),
        ("f := x;", float("nan"), 0),
        ("f := x;", 0.0, True),
    ],
)
def test_what_a_controller_would_stop_at(body: str, x: float, n: int) -> None:
    controller = Controller(program(body))
    with pytest.raises(IecError):
        controller.call("f", x, n)


def test_units_that_are_twice_or_call_what_stands_behind() -> None:
    text = program("f := x;")
    with pytest.raises(IecError, match="twice"):
        Controller(text + text)
    caller = text.replace("FUNCTION f ", "FUNCTION g ").replace("f :=", "g :=")
    caller = caller.replace("g := x", "g := f(x := x, n := n)")
    assert Controller(text + caller).call("g", 2.0, 1) == 2.0
    with pytest.raises(IecError, match="no function f"):
        Controller(caller + text)
