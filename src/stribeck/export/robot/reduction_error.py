"""What a simulator's friction does not hold of a card's: sentences with numbers."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...units import percent, unit
from .spring_pull import SpringPull, inertia, spring_pull, temperature

if TYPE_CHECKING:
    from ..model import Model
    from .reduction import Reduction

#: Friction below this share of the card's own is none, and differences below it are not told.
_NONE, _TOLD = 1e-9, 5e-3
#: The pull: this share of the greatest speed, a first stick of so many seconds, and so many of
#: them in all.
_SLOW, _STICK, _STICKS = 0.01, 2.0, 5
#: An axis that jumps by less, a share of the spring's stretch at breakaway, slides evenly.
_EVEN = 0.02
#: What an axis of unknown inertia is given, so that it swings on the spring at so many rad/s.
_SWINGS = 20.0
#: Motions that are apart by more of the whole way have run away.
_AWAY = 100.0
#: An axis that would swing through more radians than this in the pull is not simulated.
_SIMULATED = 1e7
_KELVIN = 273.15


class RigUnits:
    """Quantities in the units in which people see those of a rig."""

    def __init__(self, model: Model) -> None:
        rotary, shows = model.rig.rotary, model.rig.shows
        self.force = "N m" if rotary else "N"
        self._length = shows.get("position", "rad" if rotary else "m")
        self._speed = shows.get("velocity", shows.get("v_SS", "rad/s" if rotary else "m/s"))

    def length(self, x: float) -> str:
        """A way, m or rad."""
        return f"{unit(self._length).from_si(x):.3g} {self._length}"

    def speed(self, v: float) -> str:
        """A velocity, m/s or rad/s."""
        return f"{unit(self._speed).from_si(v):.3g} {self._speed}"

    def stiffness(self, k: float) -> str:
        """A spring's, N/m or N m/rad."""
        return f"{k * unit(self._length).factor:.3g} {self.force}/{self._length}"


def reduction_errors(model: Model, reduction: Reduction) -> list[str]:
    """What a reduction does not hold of a card's friction.

    First the error of the friction, then what the law has beside a curve, then a motion, and what
    the card itself doubts.
    """
    units = RigUnits(model)
    sentences = [
        _curve(reduction, units),
        *_rest(model, reduction, units),
        *_beside(model, reduction, units),
    ]
    minus, plus = model.law.levels(model.p)
    level = reduction.law.levels(reduction.p)[1]
    if reduction.rms > _NONE * reduction.size or max(plus - level, -minus - level) > _TOLD * level:
        sentences += _motion(model, reduction, units)
    return [*sentences, *_doubtful(model)]


def _doubtful(model: Model) -> list[str]:
    """Parameters of the law that the card itself does not vouch for."""
    labels = {model.rig.label(q.name) for q in model.law.params}
    entries = model.card.parameters.items()
    names = [n for n, q in entries if n in labels and q.verdict == "not identifiable"]
    if not names:
        return []
    return [f"the card calls {', '.join(names)} not identifiable: friction is as good as its data"]


def _curve(reduction: Reduction, units: RigUnits) -> str:
    span = f"from {units.speed(reduction.low)} to {units.speed(reduction.high)}"
    if reduction.assumed:
        span += " (assumed: the card does not say its speeds)"
    if reduction.rms <= _NONE * reduction.size:
        return f"sliding friction is the card's own, at speeds {span}"
    return (
        f"sliding friction is off by {reduction.rms:.3g} {units.force} RMS "
        f"({percent(_share(reduction.rms, reduction.size))} of F) and by "
        f"{reduction.worst:.3g} {units.force} at worst "
        f"({percent(_share(reduction.worst, reduction.worst_of))} of F, at "
        f"{units.speed(reduction.worst_at)}), at speeds {span}"
    )


def _share(part: float, whole: float) -> float:
    return part / whole if whole > 0 else np.inf


def _rest(model: Model, reduction: Reduction, units: RigUnits) -> list[str]:
    """What is said of the level at rest."""
    minus, plus = model.law.levels(model.p)
    F_S, level = 0.5 * (plus - minus), reduction.law.levels(reduction.p)[1]
    none = _NONE * reduction.size
    if none >= F_S:
        sentence = (
            f"the card's law never sticks; the file's level of {level:.4g} {units.force} does"
        )
        return [sentence] if level > none else []
    if abs(F_S - level) <= _TOLD * F_S:
        return []
    change = f"{100 * (level / F_S - 1):+.0f} %"
    sentence = f"static friction of {F_S:.4g} {units.force} is not held: "
    return [f"{sentence}the axis breaks away at {level:.4g} {units.force} ({change})"]


def _beside(model: Model, reduction: Reduction, units: RigUnits) -> list[str]:
    """What no symmetric law of speed alone has."""
    law, p = model.law, model.p
    sentences = []
    v = np.linspace(reduction.low, reduction.high, 51)[1:]
    apart = float(np.abs(law.friction(v, p) + law.friction(-v, p)).max())
    if apart > _TOLD * reduction.size:
        differs = f"friction of the two directions differs by up to {apart:.3g} {units.force}"
        sentences.append(f"{differs}: the file has what lies between them")
    if loads := [name for name in law.loads if name != "temperature"]:
        grows = f"friction that goes with the load ({', '.join(loads)}) is not held"
        sentences.append(f"{grows}: the numbers are those without load")
    if law.states and law.name != reduction.law.name:
        sentences.append(
            "presliding is not the card's: the bristles of the file are chosen for its time step"
            if reduction.law.states
            else "presliding is not held: the card's law gives way a little before it slips"
        )
    if law.warms:
        warm = temperature(law, p) - _KELVIN
        grows = "friction that goes with temperature is not held"
        sentences.append(f"{grows}: the numbers are those of {warm:.4g} degC")
    if "position" in law.terms:
        sentences.append("friction that goes with position is not held: the numbers are its mean")
    return sentences


def _motion(model: Model, reduction: Reduction, units: RigUnits) -> list[str]:
    """What it costs in a motion: the card's law and the file's, pulled alike."""
    law, p = model.law, model.p
    F_S = max(law.levels(p)[1], reduction.law.levels(reduction.p)[1])
    if not F_S > 0:
        return []
    speed = max(reduction.low, _SLOW * reduction.high)
    stiffness, span = F_S / (speed * _STICK), _STICKS * _STICK
    known = inertia(model.rig, law, model.values)
    mass = stiffness / _SWINGS**2 if known is None else known
    if not (stiffness / mass) ** 0.5 * span < _SIMULATED:
        return []
    card, file = (
        spring_pull(a, b, mass, stiffness, speed, span)
        for a, b in ((law, p), (reduction.law, reduction.p))
    )
    apart = float(np.linalg.norm(card.position - file.position)) / len(card.position) ** 0.5
    if not apart < _AWAY * speed * span:
        return []

    def described(pull: SpringPull) -> str:
        even = pull.jump <= _EVEN * F_S / stiffness
        then = "slides evenly" if even else f"jumps by {units.length(pull.jump)}"
        return f"breaks away at {pull.breakaway:.4g} {units.force} and then {then}"

    way = " forward" if law.directional else ""
    pulling = (
        f"pulled{way} at {units.speed(speed)} through a spring of {units.stiffness(stiffness)}"
    )
    inert = f"{mass:.3g} {'kg m^2' if model.rig.rotary else 'kg'}"
    both = f"the card's axis {described(card)}; the file's {described(file)}"
    return [
        f"{pulling} ({inert}), {both}; over {span:g} s they are {units.length(apart)} RMS apart"
    ]
