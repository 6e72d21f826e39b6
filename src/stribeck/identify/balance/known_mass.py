"""A mass that is known otherwise, against the one that a force balance gives: the scale's check.

The mass of a balance is in proportion to all forces, so a factor of the drive's chain that was
left out, or applied twice, shows in it as nowhere else.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from ...drive import DriveChain
from ..conditions import Violation
from ..parameters import Parameters
from ..uncertainty.covariance import HALF_WIDTH
from ..uncertainty.estimates import Estimate

#: A ratio of masses is a factor of the chain if it is as close to it as it is known, which is no
#: closer than the first of these shares and no farther than the second.
NEAREST, CLOSE = 0.01, 0.06
#: Masses are told to differ beyond this share, and beyond the tolerances of both.
DIFFERS = 0.1
#: The mass (moment of inertia) of a force balance.
_MASS = "M"


def mass_violations(
    parameters: Parameters, estimates: Sequence[Estimate], scaled: frozenset[str]
) -> list[Violation]:
    """What is wrong with the scale of the forces where the mass is known and another comes out.

    Args:
        parameters: Rig, law and what is free.
        estimates: As in `parameters.every`, their intervals with the tolerances of the chain.
        scaled: Names of the parameters that go with the scale of all forces.
    """
    known = _known(parameters)
    e = _mass(parameters, estimates)
    if known is None or e is None or not e.value > 0:
        return []
    chain, mass, sd = known
    if parameters.rig.in_amperes:
        return []
    half = max(e.high - e.value, e.value - e.low)
    beyond = abs(e.value - mass) > math.hypot(half, HALF_WIDTH * sd)
    ratio = e.value / mass
    if not beyond or abs(ratio - 1) <= DIFFERS:
        return []
    within = max(half / e.value, HALF_WIDTH * sd / mass, NEAREST)
    factor = _factor(chain, ratio, min(within, CLOSE))
    rotor = f" with the rotor's {chain.rotor_mass:.3g}" if chain.rotor_mass else ""
    sentence = (
        f"the balance gives {e.name} = {e.value:.4g} {e.unit} where {mass:.4g} is known{rotor}: "
        f"{ratio:.3g} times; {factor or _unexplained(chain)}"
    )
    return [Violation("constants", sentence, scaled or None)]


def calibration(parameters: Parameters, estimates: Sequence[Estimate]) -> list[str]:
    """A sentence with the torque constant that a known mass asks for; none where none is known.

    Args:
        parameters: Rig, law and what is free.
        estimates: As in `parameters.every`, their intervals without the tolerances of the chain.
    """
    known = _known(parameters)
    e = _mass(parameters, estimates)
    if known is None or e is None or not e.value > 0:
        return []
    chain, mass, sd = known
    spread = math.hypot(max(e.high - e.value, e.value - e.low) / HALF_WIDTH / e.value, sd / mass)
    if parameters.rig.in_amperes:
        turns = parameters.rig.rotary or "lead" in chain.numbers
        name, written = "kt", f"{'N m' if turns else 'N'}/{chain.size}"
        kt = mass / e.value * (chain.travel if turns else 1.0)
    else:
        name = next((n for n in ("kt", "scale", chain.signal.base) if n in chain.numbers), "")
        if not name:
            return []
        constant = chain.numbers[name].constant
        kt, written = constant.shown * mass / e.value, constant.unit
    tolerance = 2 * spread * kt
    stated = f'{name} = "{kt:.4g} ± {tolerance:.2g} {written} (identified from the mass)"'
    return [f"the known mass asks for {stated}"]


def _known(parameters: Parameters) -> tuple[DriveChain, float, float] | None:
    """The chain, the mass that moves by what is known, and its standard deviation."""
    chain = parameters.rig.chain
    if chain is None or chain.known_mass is None:
        return None
    return chain, chain.known_mass.value + chain.rotor_mass, chain.known_mass.standard_deviation


def _mass(parameters: Parameters, estimates: Sequence[Estimate]) -> Estimate | None:
    free = {q.name for q in parameters.free}
    pairs = zip(parameters.every, estimates, strict=True)
    return next((e for q, e in pairs if q.name == _MASS and q.name in free), None)


def _factor(chain: DriveChain, ratio: float, within: float) -> str:
    """What a ratio, known within a share, is of the chain's factors; empty if it is none."""
    factors = {name: abs(factor) for name, factor in chain.factors().items()}
    factors |= {
        "all of the chain": abs(chain.gain),
        "the root of 2 between rms and peak": math.sqrt(2.0),
        "10 between % and ‰": 10.0,
        "100 of a percentage": 100.0,
        "2 π of a turn": 2 * math.pi,
    }
    for name, factor in factors.items():
        for power, words in ((1, "applied twice"), (-1, "left out")):
            close = abs(math.log(ratio) - power * math.log(factor)) <= within
            if close and abs(math.log(factor)) > 2 * CLOSE:
                return (
                    f"that is {name} ({factor:.4g}), as if it were {words}: check the [drive] table"
                )
    return ""


def _unexplained(chain: DriveChain) -> str:
    names = ", ".join(c.name for c in chain.constants) or "its numbers"
    return f"that is no single factor of the chain: check {names}, and what moves with the axis"
