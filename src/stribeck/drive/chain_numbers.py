"""The numbers of a drive chain: which there are, in which units, and how a file writes them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from ..constant import Constant, Origin, quantity
from ..errors import InputError
from ..units import unit
from .drive_signal import BASES, Amplitude, sized

#: Numbers of a chain by name: the units in which each may be, and its meaning.
NUMBERS: Mapping[str, tuple[tuple[str, ...], str]] = {
    **{
        name: (
            (written,),
            f"{name.replace('_', ' ')} of the motor or its drive: 100 % of the signal",
        )
        for name, written in BASES.items()
    },
    "scale": (
        ("A", "N m", "N", "A/V", "N m/V", "N/V"),
        "what one count, or one volt, of the signal is",
    ),
    "kt": (("N m/A", "N/A"), "torque (force) constant of the motor"),
    "gear": (("",), "turns of the motor for one of the gear's output"),
    "lead": (("m",), "travel for one turn of screw, pinion or pulley"),
    "efficiency": (
        ("",),
        "share of the torque that a gear or screw passes on where the motor drives",
    ),
    "efficiency_backward": (("",), "the same where the load drives the motor"),
    "rotor_inertia": (("kg m**2",), "of the motor's rotor, brake and coupling"),
    "counts_per_turn": (("", "count"), "counts of the encoder for one turn of the motor"),
    "mass": (("kg", "kg m**2"), "mass (moment of inertia) of the load, known otherwise"),
}
#: Numbers on which the force depends: the constants that a rig takes over.
ACTING = (*BASES, "scale", "kt", "gear", "lead", "efficiency", "efficiency_backward")
#: Numbers that are counted, or cut to a standard: exact unless a tolerance is stated.
_COUNTED = ("gear", "lead", "counts_per_turn")
_SHARES = ("efficiency", "efficiency_backward")


@dataclass(frozen=True)
class ChainNumber:
    """A number of a chain.

    Args:
        constant: Name, value, unit, tolerance and source.
        amplitude: Which size of a current it is of.
    """

    constant: Constant
    amplitude: Amplitude = ""

    @property
    def value(self) -> float:
        """In SI."""
        return self.constant.value

    @property
    def text(self) -> str:
        """As a file writes it: `0.52 N m/A rms ± 0.026 (data sheet)`."""
        c = self.constant
        tolerance = f" ± {c.shown_tolerance:.12g}" if c.tolerance else ""
        nameplate = " nameplate" if c.origin == "nameplate" else ""
        source = f" ({c.source})" if c.source and c.source not in ("given", "its nameplate") else ""
        return f"{c.shown:.12g} {self.written}".strip() + tolerance + nameplate + source

    @property
    def written(self) -> str:
        """Its unit with the size of the current."""
        return (
            self.constant.unit.replace("A", f"A {self.amplitude}", 1)
            if self.amplitude
            else self.constant.unit
        )


def chain_number(name: str, stated: object, place: str) -> ChainNumber:
    """A number of a chain as a file has it: text, or a bare number where it has no unit.

    Raises:
        InputError: it is no such number, has no unit or another, or cannot be.
    """
    allowed, doc = NUMBERS[name]
    if isinstance(stated, bool) or not isinstance(stated, (str, int, float)):
        raise InputError(
            f'{place}: write a number with its unit in quotes, as in "{example_of(name)}"'
        )
    given = quantity(stated if isinstance(stated, str) else repr(stated), place)
    bare, amplitude = sized(given.unit)
    if name == "scale":
        bare = bare.removesuffix("/count").removesuffix("/inc").strip()
    try:
        measured = unit(bare)
    except InputError as error:
        raise InputError(f"{place}: {error}") from error
    if measured.dimension not in {unit(u).dimension for u in allowed}:
        units = " or ".join(u for u in allowed if u) or "a bare number"
        raise InputError(f"{place}: {stated!r} must be in {units}, as in {example_of(name)!r}")
    value = float(measured.to_si(given.value))
    if not value > 0 or (name in _SHARES and value > 1):
        raise InputError(
            f"{place}: {stated!r} must be {'within 0 and 1' if name in _SHARES else 'above 0'}"
        )
    counted = name in _COUNTED and not given.tolerance
    origin: Origin = "counted" if counted else given.origin
    source = given.source or ("given" if given.origin == "yours" else f"its {given.origin}")
    constant = Constant(name, value, bare, doc, source, origin, given.tolerance * measured.factor)
    return ChainNumber(constant, amplitude)


def example_of(name: str) -> str:
    """How a number is written, for a message."""
    return EXAMPLES.get(name, f"1.27 {NUMBERS[name][0][0]} ± 5 %".replace("  ", " "))


#: How some of them are written.
EXAMPLES = {
    "kt": "0.52 N m/A rms ± 5 %",
    "gear": "5",
    "lead": "10 mm",
    "efficiency": "0.9 ± 0.05",
    "efficiency_backward": "0.85 ± 0.05",
    "counts_per_turn": "65536",
    "scale": "2.69 mA",
    "rotor_inertia": "4.3e-5 kg m**2",
    "mass": "27 kg ± 2 %",
    "rated_current": "2.4 A rms",
    "standstill_current": "2.7 A rms",
    "peak_current": "8 A peak",
}
