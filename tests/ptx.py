"""Code made for a GPU, run on the processor: PTX as C, one thread of the device after another.

It knows the instructions that the integrator's programs consist of, and refuses others. What runs
is what NVIDIA's compiler made, with its own `exp`, `pow` and fused products, up to what the last
step, from PTX to machine code, may still fuse.

PTX is described in NVIDIA's "Parallel Thread Execution ISA", 8.8.
"""

from __future__ import annotations

import ctypes
import re
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

_HEAD = """#include <math.h>
#include <stdint.h>
#include <string.h>
typedef uint64_t u64, b64; typedef uint32_t u32, b32; typedef uint16_t u16, b16; typedef uint8_t b8;
typedef int64_t s64; typedef int32_t s32; typedef int16_t s16; typedef _Bool pred;
typedef double f64; typedef float f32;
#define AS(T, U, x) ({ U from_ = (x); T to_; memcpy(&to_, &from_, sizeof to_); to_; })
#define LD(T, at) ({ T to_; memcpy(&to_, (void *)(at), sizeof to_); to_; })
#define ST(T, at, x) { T from_ = (x); memcpy((void *)(at), &from_, sizeof from_); }
static f64 about(f64 x) { return AS(f64, u64, AS(u64, f64, 1.0 / x) >> 32 << 32); }
"""
_REGISTERS = {"fd": "f64", "rd": "b64", "rs": "b16", "r": "b32", "p": "pred", "f": "f32"}
_SIGNS = {"add": "+", "sub": "-", "and": "&", "or": "|", "xor": "^", "mul": "*", "div": "/"}
_COMPARED = {"eq": "==", "ne": "!=", "lt": "<", "le": "<=", "gt": ">", "ge": ">="}
_OPPOSITE = {"eq": "!=", "ne": "==", "lt": ">=", "le": ">", "gt": "<=", "ge": "<"}
_CALLED = {"abs": "fabs", "sqrt": "sqrt", "min": "fmin", "max": "fmax", "fma": "fma"}
#: A block has one thread, and a candidate a block.
_PLACE = {"%tid.x": "0", "%ntid.x": "1", "%ctaid.x": "row_"}


class Device:
    """A program of the device on the processor.

    Args:
        ptx: A module with one entry.
        folder: Where it is compiled.
        fuse: Whether products may be fused into sums wherever they meet, as the step from PTX to
            machine code may do; else only where the PTX says so.
    """

    def __init__(self, ptx: str, folder: Path, *, fuse: bool) -> None:
        source, library = folder / "program.c", folder / f"program-{fuse}.so"
        source.write_text(as_c(ptx), encoding="utf-8")
        how = f"-ffp-contract={'fast' if fuse else 'off'}"
        command = ["gcc", "-O2", "-w", "-mfma", how, "-shared", "-fPIC"]
        subprocess.run([*command, "-o", str(library), str(source), "-lm"], check=True)
        self._run = ctypes.CDLL(str(library)).run

    def __call__(self, rows: int, *arguments: Any) -> None:
        """Run as many threads; arrays are laid out as numba hands them to a device."""
        passed: list[Any] = [ctypes.c_uint64(rows)]
        for value in arguments:
            if isinstance(value, float):
                passed.append(ctypes.c_double(value))
                continue
            numbers = (0, 0, value.size, value.itemsize, value.ctypes.data, *value.shape)
            passed += [ctypes.c_uint64(k) for k in (*numbers, *value.strides)]
        self._run.restype = None
        self._run(*passed)


def as_c(ptx: str) -> str:
    """A module with one entry as C: `run(rows, arguments...)`."""
    ptx = re.sub(r"//[^\n]*", "", ptx).replace("$", "at_")
    made: dict[str, list[str]] = {"func": [], "entry": []}
    for found in re.finditer(r"\.(func|entry)\s+([^{};]*)\n\{\n(.*?)\n\}", ptx, re.DOTALL):
        made[found[1]] += _function(*found.groups())
    return _HEAD + "\n".join([*made["func"], *made["entry"]])


def _function(kind: str, head: str, body: str) -> Iterator[str]:
    name, params = re.fullmatch(r"(?:\(.*?\) )?(\w+)\s*\((.*)\)\s*", head, re.DOTALL).groups()  # type: ignore[union-attr]
    every = re.findall(r"\.param \.(\w+) (\w+)", params)
    said = "".join(f", {type_} {p}" for type_, p in every)
    if kind == "func":
        yield f"static b64 {name}({said[2:]}) {{ b64 func_retval0;"
    else:
        yield f"static void thread_(u64 row_{said}) {{"
    statement = ""
    for line in body.splitlines():
        statement = f"{statement} {line.strip()}".strip()
        if statement in ("{", "}"):
            yield statement
        elif statement.endswith(":"):
            yield f"{statement};"
        elif statement == "ret;":
            yield "return func_retval0;" if kind == "func" else "return;"
        elif statement.endswith(";"):
            yield _statement(" ".join(statement[:-1].split()))
        else:
            continue
        statement = ""
    yield "}"
    if kind == "entry":
        passed = "".join(f", {p}" for _, p in every)
        yield f"void run(u64 rows{said}) {{ for (u64 k = 0; k < rows; k++) thread_(k{passed}); }}"


def _statement(line: str) -> str:  # noqa: PLR0911 - one for each kind of line
    if found := re.fullmatch(r"\.reg \.(\w+) (%?\w+)(?:<(\d+)>)?", line):
        kind, name, n = found.groups()
        names = [f"{name}{k}" for k in range(int(n))] if n else [name]
        return f"{kind} {', '.join(map(_name, names))};"
    if found := re.fullmatch(r"\.local \.align 16 \.b8 (\w+)\[(\d+)\]", line):
        return f"_Alignas(16) b8 {found[1]}[{found[2]}];"
    if found := re.fullmatch(r"\.param \.b64 (\w+)", line):
        return f"b64 {found[1]};"
    if found := re.fullmatch(r"@(!?)(%p\d+) bra (\w+)", line):
        return f"if ({found[1]}{_name(found[2])}) goto {found[3]};"
    if found := re.fullmatch(r"bra\.uni (\w+)", line):
        return f"goto {found[1]};"
    if found := re.fullmatch(r"call\.uni \((\w+)\), (\w+), \( ?(.*?) ?\)", line):
        return f"{found[1]} = {found[2]}({found[3]});"
    word, _, rest = line.partition(" ")
    return _instruction(word.split("."), re.findall(r"\{[^}]*\}|\[[^]]*\]|[^,\s]+", rest))


def _instruction(word: list[str], at: list[str]) -> str:
    op, kind, to = word[0], word[-1], at[0]
    if op == "st":
        pieces = [_value(x, kind) for x in _pieces(at[1])]
        where = _address(to)
        return " ".join(
            f"ST({kind}, {where} + {k} * sizeof({kind}), {x});" for k, x in enumerate(pieces)
        )
    if op == "mov" and to.startswith("{"):
        low, high = map(_name, _pieces(to))
        wide = f"u64 wide = AS(u64, {_kind(at[1])}, {_name(at[1])});"
        return f"{{ {wide} {low} = (u32)wide; {high} = wide >> 32; }}"
    if op == "mov" and at[1].startswith("{"):
        low, high = (_value(x, "u32") for x in _pieces(at[1]))
        return f"{_name(to)} = AS({_kind(to)}, u64, (u64){low} | (u64){high} << 32);"
    return f"{_name(to)} = {_expression(op, word[1:], at)};"


def _expression(op: str, said: list[str], at: list[str]) -> str:  # noqa: C901, PLR0911, PLR0912
    kind = said[-1]
    if op == "ld":
        return f"LD({kind}, {_address(at[1])})"
    if op == "mov" and kind[0] == "b" and at[1][0] == "%":
        return f"AS({_kind(at[0])}, {_kind(at[1])}, {_name(at[1])})"
    if op == "selp":
        return f"{_name(at[3])} ? {_value(at[1], kind)} : {_value(at[2], kind)}"
    a, *rest = (_value(x, kind) for x in at[1:])
    real, wide = kind[0] == "f", 64 if kind.endswith("64") else 32
    match op, said:
        case (("mov" | "cvta"), _):
            return a
        case "setp", [how, _]:
            return _comparison(how, a, rest[0], real=real)
        case (("not" | "neg"), _):
            return f"{'-' if op == 'neg' else '!' if kind == 'pred' else '~'}{a}"
        case "copysign", _:
            return f"copysign({rest[0]}, {a})"
        case "rcp", _:
            return f"about({a})" if said[0] == "approx" else f"1.0 / {a}"
        case (("shl" | "shr"), _):  # beyond its width a number is shifted out
            n, sign = _value(at[2], "u32"), "<<" if op == "shl" else ">>"
            gone = f"{a} >> {wide - 1}" if kind[0] == "s" else "0"
            return f"{n} < {wide} ? {a} {sign} ({n} & {wide - 1}) : {gone}"
        case "mul", ["wide", _]:
            return f"(s64){a} * (s64){rest[0]}"
        case "cvt", ["rzi", result, _]:
            return f"({result})trunc({a})"
        case "cvt", _:
            return f"({said[-2]}){a}"
        case (("min" | "max"), _) if not real:
            return f"{a} {'<' if op == 'min' else '>'} {rest[0]} ? {a} : {rest[0]}"
        case _ if op in _CALLED and real:
            return f"{_CALLED[op]}({', '.join((a, *rest))})"
        case _ if op in _SIGNS:
            return f"{a} {_SIGNS[op]} {rest[0]}"
    raise NotImplementedError(f"PTX {op}.{'.'.join(said)}")


def _comparison(how: str, a: str, b: str, *, real: bool) -> str:
    if how in _COMPARED:
        plain = f"{a} {_COMPARED[how]} {b}"
        return f"{plain} && !isunordered({a}, {b})" if real and how == "ne" else plain
    return f"!({a} {_OPPOSITE[how[:2]]} {b})" + (
        f" || isunordered({a}, {b})" if how == "equ" else ""
    )


def _name(register: str) -> str:
    return register.replace("%", "reg_")


def _kind(register: str) -> str:
    return _REGISTERS[register.strip("%0123456789")]


def _pieces(operand: str) -> list[str]:
    return [x.strip() for x in operand.strip("{}").split(",")]


def _address(operand: str) -> str:
    base, _, offset = operand.strip("[]").partition("+")
    return f"({_name(base) if base[0] == '%' else f'(u64)&{base}'} + {offset or 0})"


def _value(operand: str, kind: str) -> str:
    """An operand as a C expression of a type."""
    if operand in _PLACE:
        return _PLACE[operand]
    if operand[:2] in ("0d", "0f"):
        real, bits = ("f64", "u64") if operand[1] == "d" else ("f32", "u32")
        return f"AS({real}, {bits}, 0x{operand[2:]}ull)"
    if operand == str(-(2**63)):
        return "INT64_MIN"
    if operand[0] == "%":
        return f"(({kind}){_name(operand)})"
    return f"(({kind}){operand})" if operand.lstrip("-").isdigit() else f"(u64){operand}"
