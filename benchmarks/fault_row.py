"""A row of the fault table: an axis, what is wrong with it, and the words that name that."""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from dataclasses import dataclass, field
from hashlib import sha256
from typing import Any

import foreign_axes
import foreign_path  # noqa: F401 - before what it finds
from foreign import sensors
from foreign.sensors import Table
from stribeck.space import Rng


@dataclass(frozen=True)
class Fault:
    """What becomes of a channel of every log: a function of `foreign.sensors` and its arguments."""

    function: str
    channel: str | None
    arguments: Mapping[str, float]

    def applied(self, table: Table, rng: Rng) -> Table:
        """The table with the fault."""
        function = getattr(sensors, self.function)
        channel = {} if self.channel is None else {"channel": self.channel}
        chance = {"rng": rng} if "rng" in inspect.signature(function).parameters else {}
        table_with: Table = function(table, **channel, **self.arguments, **chance)
        return table_with


@dataclass(frozen=True)
class Row:
    """One perturbation.

    Args:
        axis: Name of the function of `foreign_axes` that makes the axis.
        perturbation: In words; empty for none.
        words: A regular expression that a sentence matches that names the fault; without case.
        faults: Of the sensors.
        machine: Arguments of the axis: how it differs from the plain one.
        constants: What its user sets besides, in the units of the rig, or instead; None: leaves.
        values: Parameters that its user sets, as multiples of the truth.
        exact: Whether the constants that are not set are taken as exact.
        standing: Whether no log can show it: a sentence that stands of any axis has to name it.
        seeds: How many seeds of the noise.
    """

    axis: str
    perturbation: str
    words: str = ""
    faults: tuple[Fault, ...] = ()
    machine: Mapping[str, Any] = field(default_factory=dict)
    constants: Mapping[str, float | None] = field(default_factory=dict)
    values: Mapping[str, float] = field(default_factory=dict)
    exact: bool = False
    standing: bool = False
    seeds: int = 2

    @property
    def key(self) -> str:
        """Of what it does: a row of results with this key is a row of it."""
        what: tuple[Any, ...] = (
            self.axis, self.faults, self.machine, self.constants, self.exact
        )  # fmt: skip
        what += (self.values,) if self.values else ()
        return sha256(repr(what).encode()).hexdigest()[:12]

    @property
    def clean(self) -> bool:
        """Whether nothing is wrong."""
        return not self.perturbation or set(self.values.values()) == {1.0}


def fault(function: str, channel: str | None = None, **arguments: float) -> tuple[Fault, ...]:
    """A single fault."""
    return (Fault(function, channel, arguments),)


def axis_of(row: Row) -> foreign_axes.Axis:
    """The axis of a row, with its truth."""
    axis: foreign_axes.Axis = getattr(foreign_axes, row.axis)(**row.machine)
    return axis


# --- words that name a fault ----------------------------------------------------------------------

CLIP = r"clip|saturat|\blimit\b"
LATE = r"\blate\b|delay|\bearly\b|\bahead\b|behind|\blag"
CLOCK = LATE + r"|clock|drift"
FILTER = LATE + r"|filter|smooth|cut-off"
HOLD = LATE + r"|held|hold|renewed|repeat"
COARSE = r"coarse|quanti|resolution|steps? of the sensor"
WRAP = r"wrap|jump|turn"
RESET = r"reset|jump|offset|starts anew"
FROZEN = r"frozen|stands? still|never changes|repeat|freez"
GAP = r"\bgap|missing|interval of time|irregular"
OUTLIER = r"outlier|spike|jump|beyond|off their neighbours"
GAIN = r"proportion|scale|gain"
RIPPLE = r"alias|ripple|oscillat|periodic"
SPEED = r"speed|velocity|stribeck|drop|square"
PLACE = r"position|cogging|harmonic|place|periodic|spring|stiffness"
TIME = r"\btime\b|temperature|warm|drift|third"
WANDER = r"stroke to stroke|" + TIME
SIDES = r"direction|asymm|\bside|rightward|leftward"
BACKLASH = r"backlash|play|position|reversal|direction|hyster"
RECURS = r"comes back wherever"
LOAD = r"\btime\b|acceleration|inertia|mass|load|neighbour|unexplained|third|noise of the force"
SCATTER = r"scatter|spread|breakaway|slip to slip|slips"
CONSTANTS = r"not of this axis|constant"
FEW = r"speeds|one speed|too few|cannot be told apart|hardly tell apart|never stops|rests"
MODEL = r"misfit|noise|residual|explain|law|" + SPEED
SET = r"\bis set to\b"
STEP = r"step|tolerance|arithmetic|finer|simulat"
