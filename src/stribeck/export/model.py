"""The model that is exported: a card read back as law, parameters and rig, and its statements."""

from __future__ import annotations

import hashlib
import re
import textwrap
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..errors import InputError
from ..friction import Law
from ..identify.card import Card, Carded, card_file, card_of, read_card
from ..identify.parameters import Parameters
from ..rig import Rig
from ..rig.two_masses import TwoMassRig
from ..space import Array, Param
from ..units import unit


@dataclass(frozen=True, eq=False)
class Model:
    """An identified friction model, ready to be exported.

    Args:
        card: The card.
        parameters: Its rig, its law, and the names of all parameters.
        values: The complete parameter set, SI, (k,): the law's first, then the rig's own.
        sha256: Of the card's file.
        source: The card file's name.
    """

    card: Card
    parameters: Parameters
    values: Array
    sha256: str
    source: str

    @property
    def law(self) -> Law:
        """The friction law."""
        return self.parameters.law

    @property
    def rig(self) -> Rig:
        """The rig that it was identified on."""
        return self.parameters.rig

    @property
    def p(self) -> Array:
        """The law's parameters, SI, (k,)."""
        return np.ascontiguousarray(self.values[: len(self.law.params)])

    @property
    def speeds(self) -> tuple[float, float] | None:
        """Least and greatest velocity of the training data, m/s or rad/s, if the card has them."""
        card_speeds = self.card.speeds
        if card_speeds is None:
            return None
        to_si = unit(card_speeds.unit).to_si
        return float(to_si(card_speeds.low)), float(to_si(card_speeds.high))

    @property
    def force_unit(self) -> str:
        """Of friction, SI."""
        return self.rig.si_unit("force")

    @property
    def speed_unit(self) -> str:
        """Of velocity, SI."""
        return "rad/s" if self.rig.rotary else "m/s"

    def named(self) -> list[tuple[str, Param]]:
        """The law's parameters with names that any language takes, in the order of `p`.

        `F_S+` and `F_S-` become `F_S_pos` and `F_S_neg`.
        """
        params = self.parameters.every[: len(self.law.params)]
        names = [identifier(self.rig.label(q.name)) for q in params]
        unique = [
            name if names.count(name) == 1 else identifier(q.name)
            for name, q in zip(names, params, strict=True)
        ]
        return list(zip(unique, params, strict=True))

    @property
    def side(self) -> str:
        """Which friction of an axis of two masses its law is, a clause; empty of one mass."""
        if not isinstance(self.rig, TwoMassRig):
            return ""
        side = self.rig.friction_side
        if side == "both":
            return (
                "this is the load's friction alone: that of the motor's side, the stiffness "
                "between them and the play are in the card"
            )
        where = "load" if side == "load" else "motor, as a force at the load"
        where = where.replace("force", "torque") if self.rig.rotary else where
        return f"this is the friction of the {where}; the stiffness and the play are in the card"

    def head(self, other: str = "", *, whole: bool = False) -> list[str]:
        """What every exported file says of itself: formula, units, range, intervals, the card.

        Args:
            other: What of the file is not in SI, with its unit.
            whole: Whether the file has all of the axis, not the law alone.
        """
        law, card = self.law, self.card
        force = "torque" if self.rig.rotary else "force"
        force = "current" if self.rig.in_amperes else force
        odd = f", but for {other}." if other else "."
        lines = [
            f"Friction of an axis: law {law.name}, identified on rig {card.rig}.",
            "",
            f"  {law.formula}",
            f"  ({law.cite})",
            "",
            *([] if whole else self._side()),
            f"Velocity in {self.speed_unit}, friction in {self.force_unit}, and SI throughout"
            + odd,
            f"Friction has the sign of the velocity: subtract it from the {force} of the drive, or",
            f"add it to the {force} that is asked of the drive to compensate for it.",
            *self._volts(),
            f"Valid: {self.valid()}.",
            *([f"Beware: {card.speeds.one_way}."] if card.speeds and card.speeds.one_way else []),
            f"Misfit: {card.objective.value:.4g} {card.objective.unit} on the training data"
            + "".join(f", {h.value:.4g} {h.unit} held out ({h.range})" for h in card.holdout)
            + ".",
            "",
            "Parameters, 95 % intervals and verdicts:",
            *self._table(),
        ]
        if card.warnings:
            lines += ["", f"The identification warned of {len(card.warnings)}:"]
            for warning in card.warnings:
                lines += textwrap.wrap(warning, 88, initial_indent="- ", subsequent_indent="  ")
        versions = ", ".join(f"{n} {v}" for n, v in card.software.items())
        lines += ["", f"From {self.source}, sha256 {self.sha256} ({versions})."]
        return [_one_line(text) for text in lines]

    def _side(self) -> list[str]:
        """Which friction it is, of an axis of two masses."""
        if not self.side:
            return []
        text = f"Of an axis of two masses {self.side}."
        return [*textwrap.wrap(text, 88), ""]

    def _volts(self) -> list[str]:
        """How a torque is asked of a drive that takes volts."""
        values = {q.name: float(v) for q, v in zip(self.parameters.every, self.values, strict=True)}
        if not {"k_t", "R"} <= values.keys():
            return []
        per = values["R"] / values["k_t"]
        return [f"The drive takes volts: {per:.4g} V for a N m (R/k_t, as identified)."]

    def valid(self) -> str:
        """For which speeds data have been seen, in words."""
        if self.speeds is None:
            return "the card does not say for which speeds"
        low, high = self.speeds
        return f"{low:.4g} to {high:.4g} {self.speed_unit}, as far as the training data went"

    def _table(self) -> list[str]:
        rows = []
        for (name, q), value in zip(self.named(), self.p, strict=True):
            entry = self.card.parameters.get(self.rig.label(q.name))
            interval, verdict = "", "as the law has it"
            if entry is not None:
                verdict = entry.verdict_text
                if entry.low is not None and entry.high is not None:
                    low, high = (unit(entry.unit).to_si(x) for x in (entry.low, entry.high))
                    interval = f"{low:.6g} to {high:.6g}"
            rows.append((name, f"{value:.10g}", q.unit, interval, verdict, q.doc))
        widths = [max(len(row[i]) for row in rows) for i in range(5)]
        return [
            "  " + "  ".join(cell.ljust(w) for cell, w in zip(row, [*widths, 0], strict=True))
            for row in rows
        ]  # fmt: skip


def read_model(path: str | Path) -> Model:
    """A card's model, checked.

    Raises:
        InputError: no such card, a newer schema, or values that are no friction law.
    """
    path = card_file(path)
    card = read_card(path)
    try:
        parameters, values = _friction_of(card)
    except InputError as error:
        raise InputError(f"{path}: {error}") from error
    return Model(card, parameters, values, hashlib.sha256(path.read_bytes()).hexdigest(), path.name)


def as_model(card: Card) -> Model:
    """The model of a card that is no file yet; its hash is that of the file it would be."""
    parameters, values = _friction_of(card)
    return Model(
        card, parameters, values, hashlib.sha256(card.text().encode()).hexdigest(), "card.json"
    )


def model_of(model: Model | Card | Carded | str | Path) -> Model:
    """The model of a fit, of a card, or of the file of one.

    Raises:
        InputError: as `read_model`.
    """
    if isinstance(model, Model):
        return model
    return read_model(model) if isinstance(model, str | Path) else as_model(card_of(model))


def _friction_of(card: Card) -> tuple[Parameters, Array]:
    """The model of a card of which all is friction.

    Raises:
        InputError: it has a force that is none.
    """
    parameters, values = card.model()
    if "cogging" in parameters.law.terms:
        raise InputError(
            f"law {parameters.law.name} has a cogging force, which is no friction and is not "
            "exported: the card has its parameters"
        )
    return parameters, values


def _one_line(text: str) -> str:
    """A text that stays on its line: a line end in a name would leave the comment it stands in."""
    return "".join(c if c.isprintable() else " " for c in text)


def folded(text: str, wide: int) -> list[str]:
    """A line of a comment as one or more that are not too wide; blanks stay, as in tables."""
    return textwrap.wrap(
        text, wide, subsequent_indent="    ", drop_whitespace=False, replace_whitespace=False
    ) or [""]


def identifier(name: str) -> str:
    """A name that any language takes."""
    letters = name.replace("+", "_pos").replace("-", "_neg")
    letters = re.sub(r"[^A-Za-z0-9_]", "_", letters)
    return f"p_{letters}" if not letters[:1].isalpha() else letters
