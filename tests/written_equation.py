"""An equation of motion as a rig writes it, evaluated as it is written.

What stands there is read as arithmetic, letter by letter: nothing of the parts or of the stepper is
asked.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

#: A definition within a line: what stands left of its sign begins it.
_DEFINITION = re.compile(r"(?:^|, )([\w']+) = ")
_LOST = ", of which clip(F_m, F_fm) is lost"
_SHARED = re.compile(r"(\w+) (\w+) where it drives the load, \2 / (\w+) where it brakes it")
_FUNCTIONS = {
    "clip": lambda x, most: np.clip(x, -most, most),
    "sin": np.sin, "cos": np.cos, "round": np.round, "where": np.where, "sign": np.sign,
    "pi": np.pi,
}  # fmt: skip


def acceleration(lines: Sequence[str], values: Mapping[str, Any], inertial: str = "a") -> Any:
    """The acceleration that lines give.

    Args:
        lines: Of `Equation.text`.
        values: What its letters are, those apart that the lines define.
        inertial: The letter of the acceleration.
    """
    known = dict(values)
    pending = []
    for line in lines:
        if line.startswith("not stated: "):
            words = re.findall(r"(\w+) = (\S+?)(?:,|$)", line)
            known = {n: float(x.replace("∞", "inf")) for n, x in words} | known
        elif not re.search("as recorded|as read|as logged|at a flank|≤", line):
            pending += _definitions(line)
    balance = next(right for left, right in pending if left.endswith(f" {inertial}"))
    inertia = next(left for left, _ in pending if left.endswith(f" {inertial}"))
    pending = [(left, right) for left, right in pending if " " not in left]
    slope = next((right for left, right in pending if left == "q_m"), None)
    while pending:
        ready = [(n, right) for n, right in pending if _letters(right) <= {*known, *_FUNCTIONS}]
        if not ready:
            break
        known |= {n: _value(right, known) for n, right in ready}
        if slope is not None and "q_m" in known and "dq_m_dq" not in known:
            ends = [_along(pending_of(lines), known, known["q"] + h) for h in (-1e-7, 1e-7)]
            known["dq_m_dq"] = (ends[1] - ends[0]) / 2e-7
        pending = [pair for pair in pending if pair not in ready]
    mass = _value(_arithmetic(inertia[: -len(inertial) - 1]), known)
    return _value(balance, known) / mass


def pending_of(lines: Sequence[str]) -> dict[str, str]:
    """The definitions of the motor's position in lines."""
    return dict(pair for line in lines if line.startswith("q_m = ") for pair in _definitions(line))


def _along(definitions: Mapping[str, str], known: Mapping[str, Any], q: Any) -> Any:
    y = _value(definitions["y"], {**known, "q": q})
    return _value(definitions["q_m"], {**known, "q": q, "y": y})


def _definitions(line: str) -> list[tuple[str, str]]:
    """The definitions of a line: what is defined, and its arithmetic."""
    if " a = " in line or " a_m = " in line:
        left, _, right = line.partition(" = ")
        return [(left, _arithmetic(right))]
    places = [*_DEFINITION.finditer(line)]
    ends = [*(place.start() for place in places[1:]), len(line)]
    return [
        (place[1], _arithmetic(line[place.end() : end]))
        for place, end in zip(places, ends, strict=True)
    ]


def _arithmetic(text: str) -> str:
    """Written signs as those of a program."""
    for sign, ours in (("²", "**2"), ("−", "-"), ("±", ""), ("π", " pi"), ("dq_m/dq", "dq_m_dq")):
        text = text.replace(sign, ours)
    if text.endswith(_LOST):
        whole = text.removesuffix(_LOST)
        text = f"{whole} - clip({whole}, F_fm)"
    if shared := _SHARED.fullmatch(text):
        forward, force, backward = shared.groups()
        return f"where({force} * (v + (v == 0)) >= 0, {forward} * {force}, {force} / {backward})"
    text = re.sub(r"\b(sin|cos) (\w+)", r"\1(\2)", text.strip())
    text = re.sub(r"(?<![\w.])2x", "2 x", text)
    return re.sub(r"(?<=[\w)]) (?=[\w(])", "*", text)


def _letters(text: str) -> set[str]:
    return set(re.findall(r"[A-Za-z]\w*", text))


def _value(text: str, known: Mapping[str, Any]) -> Any:
    return eval(text, {}, {**_FUNCTIONS, **known})  # noqa: S307 - arithmetic that this file wrote
